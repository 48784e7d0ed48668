/* Means over an aperture, against sums over 10^5 nodes and more that know nothing of lobes, differences, and what is known exactly.
 */
#include "ff_aperture.h"
#include "fit_samples.h"
#include "base/internal_gauss.h"
#include "models/tools/internal_averaging.h"

enum { BRUTE = 160 * FF_GAUSS };

static void direction(double theta, double phi, double *x, double *y, double *z)
{
    *x = sin(theta) * cos(phi), *y = sin(theta) * sin(phi), *z = cos(theta);
}

/* 16 panels x 16 panels, of points of Gauss, over the plane of an aperture: chords of a disc, tangents of a rectangle. It knows
 * nothing of lobes. */
static double plane_sum(const fit_surface *s, const ff_aperture *a, const double wi[3], double theta, double phi, int panels)
{
    static double w[6][BRUTE], f[BRUTE], x[BRUTE], weight[BRUTE], inner[BRUTE];
    const int n = FF_GAUSS * panels, disc = a->outline == FF_APERTURE_DISC;
    double sum = 0, area = 0;
    ff_gauss_panels(-1, 1, panels, x, weight);
    for (int i = 0; i < n; i++) {
        const double psi = 90 * FIT_DEGREE * x[i], radius = sin(a->half);
        for (int k = 0; k < n; k++) {
            double p = radius * cos(psi) * x[k], q = radius * sin(psi), r = sqrt(1 - p * p - q * q);
            inner[k] = cos(psi) * cos(psi) * weight[k] / r;
            if (!disc) {
                r = 1 / sqrt(1 + pow(tan(a->half) * x[k], 2) + pow(tan(a->across) * x[i], 2));
                p = tan(a->half) * x[k] * r, q = tan(a->across) * x[i] * r;
                inner[k] = weight[k] * r * r * r;
            }
            for (int d = 0; d < 3; d++) w[d][k] = wi[d];
            const double along = p * cos(theta) + r * sin(theta);
            w[3][k] = along * cos(phi) - q * sin(phi), w[4][k] = along * sin(phi) + q * cos(phi);
            w[5][k] = -p * sin(theta) + r * cos(theta);
        }
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        FF_CHECK(!ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &dirs, (size_t)n, f, NULL, (size_t)n),
                 "evaluation");
        for (int k = 0; k < n; k++) {
            sum += weight[i] * inner[k] * fmax(w[5][k], 0) * f[k];
            area += weight[i] * inner[k];
        }
    }
    return sum / area / cos(theta);
}

/* 10^5 nodes, or as many more as it takes that half as many along a side say the same. */
static double brute(const fit_surface *s, const ff_aperture *a, const double wi[3], double theta, double phi, double tolerance)
{
    int panels = 10;
    double before = plane_sum(s, a, wi, theta, phi, panels), now = plane_sum(s, a, wi, theta, phi, panels *= 2);
    while (fabs(now - before) > 0.1 * tolerance * fabs(now) && panels < BRUTE / FF_GAUSS) {
        before = now;
        now = plane_sum(s, a, wi, theta, phi, panels *= 2);
    }
    FF_CHECK_CLOSE(now, before, 0.2 * tolerance, 0);
    return now;
}

/* A setting of the kinds that are asked for: alpha from .003 to .3, apertures from .1 to 3 degrees, up to 75 degrees of incidence
 * and exit, most exits about the mirror direction. */
typedef struct setting {
    fit_surface surface;
    ff_aperture aperture;
    double theta, phi, w[6];
} setting;

static void make_setting(setting *out)
{
    static const char *const model[] = {"ggx+lambert", "beckmann+lambert", "student-t+lambert", "ggx/v-cavity+oren-nayar"};
    char set[120];
    const double alpha = 0.003 * pow(100, ff_test_uniform()),
                 other = ff_test_uniform() < 0.5 ? alpha : 0.003 * pow(100, ff_test_uniform()),
                 half = 0.1 * FIT_DEGREE * pow(30, ff_test_uniform()), theta_i = 75 * FIT_DEGREE * ff_test_uniform(),
                 phi_i = 6.28 * ff_test_uniform(), far = ff_test_uniform() < 0.3 ? 0.5 : 3 * half;
    snprintf(set, sizeof set, "alpha_x=%g alpha_y=%g f0=0.5 kd=0.05", alpha, other);
    out->surface = fit_surface_make(model[(int)(4 * ff_test_uniform())], 1, set);
    out->aperture = (ff_aperture){ff_test_uniform() < 0.6 ? FF_APERTURE_DISC : FF_APERTURE_RECTANGLE, half,
                                  half * (0.3 + ff_test_uniform()), 0};
    out->theta = fmin(fabs(theta_i + far * (2 * ff_test_uniform() - 1)), 75 * FIT_DEGREE);
    out->phi = phi_i + 180 * FIT_DEGREE + far * (2 * ff_test_uniform() - 1);
    direction(theta_i, phi_i, &out->w[0], &out->w[1], &out->w[2]);
    direction(out->theta, out->phi, &out->w[3], &out->w[4], &out->w[5]);
}

/* The mean as fits make it. */
static double mean_of_fits(const setting *t)
{
    static ff_averaging a;
    ff_rules *rules = ff_rules_new(&t->aperture, FF_APERTURE_OF_FITS);
    ff_average_work **work = ff_average_works_new(1, 1, 0);
    ff_prepared p;
    const ff_dirs dirs = {t->w, t->w + 1, t->w + 2, t->w + 3, t->w + 4, t->w + 5};
    const ff_status status = ff_prepare(&t->surface.model, ff_kernels_get(FF_ISA_BEST), FF_CHEAPEST_MODE, 1, t->surface.shape,
                                        t->surface.channel, NULL, 0, INFINITY, &p);
    if (status || !rules || !work) abort();
    ff_averaging_make(rules, &p, NULL, &a);
    ff_average_choose(&a, &dirs, 1, work[0]);
    const double f = work[0]->f[0];
    ff_average_works_free(work);
    ff_prepared_free(&p);
    free(rules);
    return f;
}

/* What fits take for a mean is within their tolerance, and what eval says within its own. */
static void against_brute_force(void)
{
    const long settings = fit_repeats(40, 1000);
    for (long k = 0; k < settings; k++) {
        setting t;
        double f, error;
        make_setting(&t);
        const fit_surface *s = &t.surface;
        const ff_dirs dirs = {t.w, t.w + 1, t.w + 2, t.w + 3, t.w + 4, t.w + 5};
        FF_CHECK(!ff_aperture_eval(&t.aperture, &s->model, FF_ISA_BEST, 1, s->shape, s->channel, &dirs, 1, &f, NULL, &error, 1),
                 "aperture");
        FF_CHECK(error <= FF_APERTURE_TOLERANCE, "error %g at %g degrees", error, t.aperture.half / FIT_DEGREE);
        const double exact = brute(s, &t.aperture, t.w, t.theta, t.phi, FF_APERTURE_TOLERANCE);
        FF_CHECK_CLOSE(f, exact, 2 * FF_APERTURE_TOLERANCE, 0);
        FF_CHECK_CLOSE(mean_of_fits(&t), exact, FF_APERTURE_OF_FITS, 0);
    }
}

/* The value of a setting at one parameter, at given levels and for lobes where they were. */
static double shifted(setting *t, const ff_rules *rules, const ff_needles *needles, const unsigned char *level, double *p,
                      double to)
{
    static ff_averaging a;
    const double at = *p;
    ff_average_work **work = ff_average_works_new(1, 1, 0);
    ff_prepared ready;
    const ff_dirs dirs = {t->w, t->w + 1, t->w + 2, t->w + 3, t->w + 4, t->w + 5};
    *p = to;
    if (!work || ff_prepare(&t->surface.model, ff_kernels_get(FF_ISA_BEST), FF_TILTED_MODE, 1, t->surface.shape, t->surface.channel,
                            NULL, 0, INFINITY, &ready))
        abort();
    ff_averaging_make(rules, &ready, needles, &a);
    ff_average_at(&a, &dirs, 1, level, work[0]);
    const double f = work[0]->f[0];
    *p = at;
    ff_average_works_free(work);
    ff_prepared_free(&ready);
    return f;
}

/* Of the sum at its nodes: against differences of the sixth order of it. */
static void derivatives(void)
{
    static ff_averaging a;
    for (int round = 0; round < 40; round++) {
        setting t;
        ff_prepared ready;
        make_setting(&t);
        if (round % 2) t.aperture.source = t.aperture.half * 0.5;
        fit_surface *s = &t.surface;
        ff_wanted all = {.n_shape = s->model.n_shape, .n_channel = s->model.n_channel};
        for (uint32_t k = 0; k < FF_MAX_SHAPE; k++) all.shape[k] = k;
        for (uint32_t k = 0; k < FF_MAX_CHANNEL_PARAMS; k++) all.channel[k] = k;
        const size_t P = all.n_shape + all.n_channel;
        ff_rules *rules = ff_rules_new(&t.aperture, 1e-2);
        ff_average_work **work = ff_average_works_new(1, 1, P);
        const ff_dirs dirs = {t.w, t.w + 1, t.w + 2, t.w + 3, t.w + 4, t.w + 5};
        if (!rules || !work ||
            ff_prepare(&s->model, ff_kernels_get(FF_ISA_BEST), FF_TILTED_MODE, 1, s->shape, s->channel, &all, 0, INFINITY, &ready))
            abort();
        ff_averaging_make(rules, &ready, NULL, &a);
        ff_average_choose(&a, &dirs, 1, work[0]);
        const unsigned char level = work[0]->level[0];
        const double f = work[0]->f[0];
        ff_average_at(&a, &dirs, 1, &level, work[0]);
        FF_CHECK_CLOSE(work[0]->f[0], f, 1e-13, 0);
        for (size_t k = 0; k < P; k++) {
            const ff_model_param *info = k < all.n_shape ? &s->model.shape[k] : &s->model.channel[k - all.n_shape];
            double *p = k < all.n_shape ? &s->shape[k] : &s->channel[k - all.n_shape], sum = 0;
            const double at = *p, h = 2e-3 * (info->flags & FF_PARAM_LOG ? at : fabs(at) > 0 ? fabs(at) : 0.1 * s->shape[0]);
            static const double c[3] = {3 / 4.0, -3 / 20.0, 1 / 60.0};
            for (int i = 1; i <= 3; i++)
                sum += c[i - 1] * (shifted(&t, rules, &a.needles, &level, p, at + i * h) -
                                   shifted(&t, rules, &a.needles, &level, p, at - i * h));
            FF_CHECK_CLOSE(work[0]->df[k * FF_BLOCK], sum / h, 1e-8, 1e-8 * f / (fabs(at) > 0 ? fabs(at) : s->shape[0]));
        }
        ff_average_works_free(work);
        ff_prepared_free(&ready);
        free(rules);
    }
}

/* Of Lambert's term the mean of the cosine over a cone is (1 + cos A) / 2 of that of its centre; a source changes nothing in it; a
 * point is the model itself; and there is no negative aperture. */
static void exact(void)
{
    const fit_surface s = fit_surface_make("lambert", 1, "kd=0.5");
    const double half = 3 * FIT_DEGREE;
    double w[6], f, plain;
    direction(0.5, 0, &w[0], &w[1], &w[2]);
    direction(0.7, 2, &w[3], &w[4], &w[5]);
    const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    FF_CHECK(!ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &plain, NULL, 1), "evaluation");
    FF_CHECK(!ff_aperture_eval(&(ff_aperture){FF_APERTURE_DISC, half, 0, 0.02}, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs,
                               1, &f, NULL, NULL, 1),
             "aperture");
    FF_CHECK_CLOSE(f, plain * 0.5 * (1 + cos(half)), 1e-12, 0);
    FF_CHECK(!ff_aperture_eval(&(ff_aperture){.outline = FF_APERTURE_DISC}, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1,
                               &f, NULL, NULL, 1) &&
                 f == plain,
             "a point: %g, expected %g", f, plain);
    FF_CHECK(ff_aperture_eval(&(ff_aperture){FF_APERTURE_DISC, -1, 0, 0}, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1,
                              &f, NULL, NULL, 1) == FF_ERR_RANGE,
             "a negative aperture");
}

/* Values of another program, alpha .02, F0 .5, kd .05 through a disc of .75 degrees, in six digits: not of a point. */
static void of_another_program(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.02 f0=0.5 kd=0.05");
    const ff_aperture disc = {FF_APERTURE_DISC, 0.75 * FIT_DEGREE, 0, 0};
    FILE *in = fopen(FF_TESTS "/aper02.csv", "r");
    char line[128];
    int n = 0;
    if (!FF_CHECK(in != NULL, "aper02.csv is not there")) return;
    while (fgets(line, sizeof line, in)) {
        double a[4], y, w[6], f;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf", &a[0], &a[1], &a[2], &a[3], &y) != 5) continue;
        direction(a[0] * FIT_DEGREE, a[1] * FIT_DEGREE, &w[0], &w[1], &w[2]);
        direction(a[2] * FIT_DEGREE, a[3] * FIT_DEGREE, &w[3], &w[4], &w[5]);
        const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        FF_CHECK(!ff_aperture_eval(&disc, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &f, NULL, NULL, 1), "aperture");
        FF_CHECK_CLOSE(f, y, 3e-4, 0);
        n++;
    }
    fclose(in);
    FF_CHECK(n == 170, "%d samples", n);
}

FF_TEST_MAIN(FF_TEST(against_brute_force), FF_TEST(derivatives), FF_TEST(exact), FF_TEST(of_another_program))
