/* Lobes as narrow as the steps between samples, or as detectors are: it is said that the roughness is an upper bound, and not said
 * of lobes that are resolved. And that it is one: a lobe seen by a detector of 1.5 degrees comes out wider than it is. */
#include "fit_samples.h"
#include "fit/problem/internal_problem.h"
#include "warnings.h"

static const double pi = 3.14159265358979323846;

/* Light from 20, 40 and 60 degrees; exits up to 12 degrees from the mirror direction in and across the plane, by steps. A disc of
 * `aperture` degrees across: the mean over rings of it. */
static ff_table scans(const fit_surface *s, double step, double aperture)
{
    enum { RINGS = 8, AROUND = 16 };
    const int each = 2 * (int)floor(12 / step) + 1;
    ff_table t;
    if (ff_table_init((size_t)(3 * 2 * each - 3), 1, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = 1;
    t.isotropic = 1;
    uint64_t noise = ff_test_stream("narrow %g %g", step, aperture);
    size_t n = 0;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2 * each; k++) {
            const double theta_i = (20 + 20 * i) * FIT_DEGREE, off = (k % each - each / 2) * step * FIT_DEGREE;
            const double along = k < each ? off : 0, across = k < each ? 0 : off;
            if (k >= each && off == 0) continue; /* once */
            double sum = 0;
            for (int r = 0; r < (aperture > 0 ? RINGS * AROUND : 1); r++) {
                const double rho = aperture > 0 ? 0.5 * aperture * FIT_DEGREE * sqrt((r / AROUND + 0.5) / RINGS) : 0,
                             psi = 2 * pi * (r % AROUND) / AROUND, theta = theta_i + along + rho * cos(psi),
                             c = across + rho * sin(psi);
                /* turned out of the plane by the great circle across it */
                const double wi[3] = {-sin(theta_i), 0, cos(theta_i)}, wo[3] = {sin(theta) * cos(c), sin(c), cos(theta) * cos(c)};
                const ff_dirs w = {wi, wi + 1, wi + 2, wo, wo + 1, wo + 2};
                double f;
                if (ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &w, 1, &f, NULL, 1)) exit(1);
                sum += f;
                if (r) continue;
                t.angle[0][n] = theta_i, t.angle[1][n] = pi;
                const double middle[3] = {sin(theta_i + along) * cos(across), sin(across), cos(theta_i + along) * cos(across)};
                t.angle[2][n] = acos(middle[2]), t.angle[3][n] = atan2(middle[1], middle[0]);
            }
            t.value[n] = sum / (aperture > 0 ? RINGS * AROUND : 1) * (1 + 0.01 * fit_normal(&noise));
            n++;
        }
    return t;
}

/* The fit of the model that made the surface. */
static void fit_to(const ff_table *t, const ff_model *m, ff_fit_result *r, double *spacing)
{
    ff_fit_options o;
    ff_problem *p;
    ff_error err = {0};
    ff_fit_options_init(&o);
    o.shape = FF_SHAPE_ISOTROPIC;
    if (ff_problem_make(t, m, 1, &o, &p, &err) || ff_problem_fit_into(p, m, &o, r, &err)) {
        printf("%s\n", err.message);
        exit(1);
    }
    *spacing = p->spacing / FIT_DEGREE;
    ff_problem_free(p);
}

static void said_of_narrow_lobes(void)
{
    static const struct {
        const char *model, *words;
        double step, aperture;
        int said;
    } all[] = {{"ggx+lambert", "alpha=0.02 f0=0.5 kd=0.05", 0.5, 1.5, 1}, /* as narrow as the detector             */
               {"ggx+lambert", "alpha=0.02 f0=0.5 kd=0.05", 0.5, 0, 1},   /* or it might be                        */
               {"beckmann+lambert", "alpha=0.015 f0=0.5 kd=0.05", 1, 1.5, 1},
               {"ggx+lambert", "alpha=0.04 f0=0.5 kd=0.05", 4, 0, 1}, /* 6 degrees by steps of 4               */
               {"beckmann+lambert", "alpha=0.06 f0=0.1 kd=0.3", 6, 0, 1},
               {"ggx+lambert", "alpha=0.02 f0=0.5 kd=0.05", 0.1, 0, 0}, /* steps that tell of a small detector   */
               {"ggx+lambert", "alpha=0.04 f0=0.5 kd=0.05", 1, 0, 0},
               {"ggx+lambert", "alpha=0.06 f0=0.1 kd=0.3", 2, 1.5, 0},
               {"beckmann+lambert", "alpha=0.1 f0=0.1 kd=0.3", 4, 0, 0},
               {"ggx+lambert", "alpha=0.3 f0=0.1 kd=0.3", 4, 0, 0}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++) {
        const fit_surface s = fit_surface_make(all[k].model, 1, all[k].words);
        ff_table t = scans(&s, all[k].step, all[k].aperture);
        ff_fit_result r;
        double spacing;
        fit_to(&t, &s.model, &r, &spacing);
        const size_t said = count_warnings(&r.warnings, FF_WARNING_NARROW_LOBE);
        FF_CHECK(said == (size_t)all[k].said, "%s %s, steps of %g: said %zu times", all[k].model, all[k].words, all[k].step, said);
        FF_CHECK_CLOSE(spacing, all[k].step, 0, 0.05 * all[k].step);
        if (all[k].aperture > 0 && all[k].said)
            FF_CHECK(r.shape_value[0].value > 1.02 * s.shape[0], "alpha %g is no upper bound of %g", r.shape_value[0].value,
                     s.shape[0]);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* Nothing is said of a roughness that was given. */
static void not_of_what_is_held(void)
{
    fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.02 f0=0.5 kd=0.05");
    ff_table t = scans(&s, 0.5, 0);
    ff_fit_result r;
    double spacing;
    if (ff_model_hold(&s.model, "alpha", 0.02, NULL)) exit(1);
    fit_to(&t, &s.model, &r, &spacing);
    FF_CHECK(!count_warnings(&r.warnings, FF_WARNING_NARROW_LOBE), "said of a roughness that is held");
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(said_of_narrow_lobes), FF_TEST(not_of_what_is_held))
