/* Scans in the plane of incidence: what lies beside the plane is extrapolated and says so, and the errors that `resample` states
 * hold against the formula behind the data. */
#include "data_formats/analysis/survey_struct.h"
#include "data_formats/interpolation/ff_interpolate.h"
#include "data_formats/interpolation/resample_struct.h"
#include "data_formats/table/internal_table.h"
#include "ff_simulate.h"
#include "ff_test.h"
#include "fit_samples.h"

static const double pi = 3.14159265358979323846;

/* ---- scans ----------------------------------------------------------------------------------- */

static void directions(const ff_table *t, size_t i, double wi[3], double wo[3])
{
    double *const planes[6] = {wi, wi + 1, wi + 2, wo, wo + 1, wo + 2};
    ff_table_directions(t, i, 1, planes);
}

static double formula(const fit_surface *s, const double wi[3], const double wo[3])
{
    const ff_dirs w = {wi, wi + 1, wi + 2, wo, wo + 1, wo + 2};
    double f = NAN;
    if (ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &w, 1, &f, NULL, 1)) exit(1);
    return f;
}

static ff_table empty(size_t n)
{
    ff_table t;
    if (ff_table_init(n, 1, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = pi / 180;
    t.isotropic = 1;
    return t;
}

static void fill(const fit_surface *s, ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) {
        double wi[3], wo[3];
        directions(t, i, wi, wo);
        t->value[i] = formula(s, wi, wo);
    }
}

/* Exit k of a scan over both sides: positive angles are on the side of the mirror direction. */
static void place(ff_table *t, size_t i, double theta_i, double exit_angle, double phi)
{
    t->angle[0][i] = theta_i, t->angle[1][i] = 0;
    t->angle[2][i] = fabs(exit_angle), t->angle[3][i] = (exit_angle < 0 ? 180 : 0) + 180 + phi;
}

/* A goniometer in the plane of incidence: light from 10 to 70 degrees, exits to 80 degrees on both sides. */
static ff_table scan(const fit_surface *s, double step_i, double step_o)
{
    const size_t n_i = (size_t)lround(60 / step_i) + 1, n_o = (size_t)lround(160 / step_o) + 1;
    ff_table t = empty(n_i * n_o);
    for (size_t i = 0; i < t.n; i++) place(&t, i, 10 + step_i * (double)(i / n_o), step_o * (double)(i % n_o) - 80, 0);
    fill(s, &t);
    return t;
}

/* Directions that no scan was made for: in the plane, or beside it by degrees. */
static ff_table held_out(const fit_surface *s, size_t n, int in_plane)
{
    ff_table t = empty(n);
    for (size_t i = 0; i < n; i++) {
        const double theta_i = 10 + 60 * ff_test_uniform(), theta_o = 160 * ff_test_uniform() - 80,
                     phi = 170 * ff_test_uniform() - 85;
        if (in_plane)
            place(&t, i, theta_i, theta_o, 0);
        else /* neither near the normal nor near the plane */
            place(&t, i, theta_i, copysign(fmax(fabs(theta_o), 5), theta_o), phi + copysign(5, phi));
    }
    fill(s, &t);
    return t;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* ---- what is interpolated, and what is not --------------------------------------------------- */

typedef struct outcome {
    size_t beyond, between;
    double most; /* of 95 % of those between samples: |ln(found / formula)| */
} outcome;

static outcome against(const ff_table *t, const ff_table *truth)
{
    outcome r = {0};
    ff_interpolant *p = NULL;
    double *e = malloc(truth->n * sizeof *e);
    if (!e || ff_interpolant_new(t, 0, &p, NULL)) exit(1);
    FF_CHECK(ff_interpolant_is_in_plane(p), "a scan in the plane of incidence is not known as one");
    for (size_t i = 0; i < truth->n; i++) {
        double w[6], f;
        unsigned char found;
        directions(truth, i, w, w + 3);
        const double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_interpolant_eval_reciprocal(p, planes, 1, &f, &found);
        FF_CHECK(f >= 0 && isfinite(f), "sample %zu is %g", i, f);
        r.beyond += found == FF_FOUND_BEYOND;
        if (found == FF_FOUND_BETWEEN || found == FF_FOUND_RECIPROCAL) e[r.between++] = fabs(log(f / truth->value[i]));
    }
    qsort(e, r.between, sizeof *e, ascending);
    r.most = r.between ? e[r.between * 95 / 100] : NAN;
    ff_interpolant_free(p);
    free(e);
    return r;
}

static void add_noise(ff_table *t, double relative)
{
    for (size_t i = 0; i < t->n; i++) t->value[i] *= 1 + relative * ff_random_normal(ff_test_seeded(1), 0, i);
}

/* Beside the plane an error is never stated, since all is called extrapolated; in it the stated one holds. */
static void stated_errors_hold(void)
{
    static const struct {
        const char *model, *words;
        double step_i, step_o, noise;
    } all[] = {{"ggx+lambert", "alpha=0.1 f0=0.3 kd=0.2", 15, 2, 0},
               {"ggx+lambert", "alpha=0.15 f0=0.3 kd=0.2", 10, 5, 0},
               {"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 15, 4, 0},
               {"ggx+lambert", "alpha=0.25 f0=0.3 kd=0.2", 10, 5, 0},
               {"ggx+lambert", "alpha=0.5 f0=0.3 kd=0.2", 15, 4, 0},
               {"ggx+lambert", "alpha=0.5 f0=0.3 kd=0.2", 20, 8, 0},
               {"beckmann+lambert", "alpha=0.2 f0=0.05 kd=0.4", 15, 4, 0},
               {"beckmann", "alpha=0.4 f0=0.9", 10, 5, 0.03},
               {"student-t+lambert", "alpha=0.15 gamma=1.7 f0=0.6 kd=0.1", 15, 2, 0.03},
               {"ggx/v-cavity+oren-nayar", "alpha=0.3 f0=0.1 kd=0.3 sigma_facet=0.4", 12, 4, 0.05},
               {"ggx+ggx+lambert", "alpha=0.12 f0=0.3 lobe2.alpha=0.5 lobe2.f0=0.2 kd=0.1", 10, 2, 0},
               {"lambert", "kd=0.7", 20, 8, 0.02}};
    for (size_t k = 0; k < sizeof all / sizeof all[0]; k++) {
        const fit_surface s = fit_surface_make(all[k].model, 1, all[k].words);
        ff_table t = scan(&s, all[k].step_i, all[k].step_o), inside = held_out(&s, 2000, 1), beside = held_out(&s, 2000, 0), made;
        add_noise(&t, all[k].noise);
        ff_resample_options o;
        ff_resample_report r;
        ff_error err = {0};
        ff_resample_options_init(&o);
        const outcome in = against(&t, &inside), out = against(&t, &beside);
        FF_CHECK(out.beyond == beside.n, "%zu of %zu beside the plane are called extrapolated", out.beyond, beside.n);
        if (FF_CHECK(ff_resample_into(&t, ff_format_find("zemax"), &o, &made, &r, &err) == FF_OK, "%s", err.message)) {
            const double stated = fmax(r.near.most, r.across.most);
            printf("  %s %s, steps of %g and %g, noise %g: in the plane 95 %% within %.3f, stated %.3f and %.3f\n", all[k].model,
                   all[k].words, all[k].step_i, all[k].step_o, all[k].noise, in.most, r.near.most, r.across.most);
            FF_CHECK(in.between > 1500 && in.most <= stated, "%s %s: error %g of %zu, stated %g", all[k].model, all[k].words,
                     in.most, in.between, stated);
            FF_CHECK(r.in_plane && r.beyond > 2 * r.between && r.incidences == 0 && isnan(r.lost), "%zu beyond, %zu between",
                     r.beyond, r.between);
            ff_table_clear(&made);
        }
        ff_table_clear(&t);
        ff_table_clear(&inside);
        ff_table_clear(&beside);
    }
}

/* ---- info ------------------------------------------------------------------------------------ */

static void no_reflectance_is_known(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha_x=0.25 alpha_y=0.25 f0=0.3 kd=0.2");
    ff_table t = scan(&s, 15, 4), whole = held_out(&s, 4000, 0);
    ff_survey v;
    if (FF_CHECK(ff_survey_init(&t, &v, NULL) == FF_OK, "no survey")) {
        FF_CHECK(v.in_plane && v.n_reflectances > 3, "in plane: %d, %zu incidences", v.in_plane, v.n_reflectances);
        for (size_t k = 0; k < v.n_reflectances; k++)
            FF_CHECK(isnan(v.albedo[k]) && isnan(v.albedo_raised[k]) && v.reflectance[k].covered == 0, "%g of %g covered",
                     v.albedo[k], v.reflectance[k].covered);
        ff_survey_clear(&v);
    }
    if (FF_CHECK(ff_survey_init(&whole, &v, NULL) == FF_OK, "no survey")) {
        FF_CHECK(!v.in_plane && v.albedo[1] > 0.1, "in plane: %d", v.in_plane);
        ff_survey_clear(&v);
    }
    ff_table_clear(&t);
    ff_table_clear(&whole);
}

/* ---- kinds of scans -------------------------------------------------------------------------- */

/* Steps of 5 degrees, light from 20, 40 and 60 degrees at azimuths that `turn` apart, detectors `aside` degrees from the plane. */
static ff_table by_hand(double turn, double aside)
{
    ff_table t;
    if (ff_table_init(3 * 33, 1, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = pi / 180;
    t.isotropic = turn == 0;
    for (size_t i = 0; i < t.n; i++) {
        const double exit_angle = 5 * ((double)(i % 33) - 16), phi_i = turn * (double)(i / 33);
        t.angle[0][i] = 20 * (1 + (double)(i / 33)), t.angle[1][i] = phi_i;
        t.angle[2][i] = fabs(exit_angle), t.angle[3][i] = phi_i + (exit_angle > 0 ? 180 : 0) + (i % 2 ? aside : 0);
        t.value[i] = 1 + 0.01 * exit_angle;
    }
    return t;
}

static void check_scan(double turn, double aside, int in_plane)
{
    ff_table t = by_hand(turn, aside);
    ff_interpolant *p = NULL;
    if (!FF_CHECK(ff_interpolant_new(&t, 0, &p, NULL) == FF_OK, "no interpolant")) return;
    FF_CHECK(ff_interpolant_is_in_plane(p) == in_plane, "turned %g, %g aside: in plane %d", turn, aside, !in_plane);
    for (size_t i = 0; i < t.n; i++) {
        double w[6], f;
        unsigned char found;
        const double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        directions(&t, i, w, w + 3);
        ff_interpolant_eval(p, planes, 1, &f, &found);
        FF_CHECK(found == FF_FOUND_SAMPLE && fabs(f - t.value[i]) < 1e-9, "sample %zu is %g (%d)", i, f, found);
        if (!in_plane || t.angle[2][i] < 20) continue;
        const double phi = (t.angle[3][i] + 20) * pi / 180, theta = t.angle[2][i] * pi / 180; /* near, but beside */
        w[3] = sin(theta) * cos(phi), w[4] = sin(theta) * sin(phi), w[5] = cos(theta);
        ff_interpolant_eval(p, planes, 1, &f, &found);
        FF_CHECK(found == FF_FOUND_BEYOND && f > 0 && f < 2, "beside sample %zu: %g (%d)", i, f, found);
    }
    ff_interpolant_free(p);
    ff_table_clear(&t);
}

/* Light from several azimuths, each seen in its own plane, is no better; a stage that leaves the plane a little is no worse; one
 * that leaves it for good has measured something there. */
static void scans_of_all_kinds(void)
{
    check_scan(0, 0, 1);
    check_scan(40, 0, 1);
    check_scan(0, 0.1, 1);
    check_scan(0, 10, 0);
}

/* What stands beside the plane, where it is asked for, is that of half vectors which lean as far: the lobe is not smeared across.
 */
static void values_beside_the_plane(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha_x=0.25 alpha_y=0.25 f0=0.3 kd=0.2");
    ff_table t = scan(&s, 15, 4), truth = held_out(&s, 2000, 0);
    ff_interpolant *p = NULL;
    double worst = 0;
    if (ff_interpolant_new(&t, 0, &p, NULL)) exit(1);
    for (size_t i = 0; i < truth.n; i++) {
        double w[6], f;
        const double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        directions(&truth, i, w, w + 3);
        if (fmin(w[2], w[5]) < cos(60 * pi / 180)) continue;
        ff_interpolant_eval(p, planes, 1, &f, NULL);
        worst = fmax(worst, fabs(log(f / truth.value[i])));
    }
    printf("  beside the plane, light and exits up to 60 degrees: a factor %.2f at most\n", exp(worst));
    FF_CHECK(worst > 0 && worst < log(2.2), "a factor %g", exp(worst));
    ff_interpolant_free(p);
    ff_table_clear(&t);
    ff_table_clear(&truth);
}

FF_TEST_MAIN(FF_TEST(stated_errors_hold), FF_TEST(no_reflectance_is_known), FF_TEST(scans_of_all_kinds),
             FF_TEST(values_beside_the_plane))
