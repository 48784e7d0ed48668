/* Reflectances beyond 1: bounds, values held, evaluation and its derivatives there, and where they have no meaning. */
#include "fit_samples.h"
#include "models/internal_model.h"

/* f and its derivatives at F0, F82 or kd above 1: against differences, which are exact but for rounding in what is affine. */
static void derivatives(void)
{
    static const struct {
        const char *expression, *set;
    } trials[] = {{"ggx+lambert", "alpha=0.3 f0=1.4 kd=3"},
                  {"beckmann/v-cavity/schlick-f82+lambert", "alpha=0.4 f0=1.2 f82=1.1 kd=200"},
                  {"phong+lambert", "n=30 f0=50 kd=1e4"}};
    enum { N = 200 };
    for (size_t t = 0; t < sizeof trials / sizeof *trials; t++) {
        fit_surface s = fit_surface_make(trials[t].expression, 1, trials[t].set);
        const size_t P = s.model.n_shape + s.model.n_channel;
        double w[6][N], f[N], df[FF_MAX_SHAPE * N + FF_MAX_CHANNEL_PARAMS * N], up[N], down[N];
        for (size_t i = 0; i < N; i++)
            for (size_t d = 0; d < 2; d++) {
                const double z = 0.1 + 0.9 * ff_test_uniform(), phi = 360 * FIT_DEGREE * ff_test_uniform(), r = sqrt(1 - z * z);
                w[3 * d][i] = r * cos(phi), w[3 * d + 1][i] = r * sin(phi), w[3 * d + 2][i] = z;
            }
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        FF_CHECK(ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, N, f, df, N) == FF_OK, "%s",
                 trials[t].expression);
        for (size_t k = 0; k < P; k++) {
            double *p = k < s.model.n_shape ? &s.shape[k] : &s.channel[k - s.model.n_shape];
            const double at = *p, h = 1e-6 * (1 + fabs(at));
            *p = at + h;
            const ff_status above = ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, N, up, NULL, N);
            *p = at - h;
            const ff_status below = ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, N, down, NULL, N);
            *p = at;
            if (above == FF_ERR_UNSUPPORTED && below == above) continue; /* the V-cavity has no mean slope */
            for (size_t i = 0; i < N; i++)
                FF_CHECK_CLOSE(df[k * N + i], (up[i] - down[i]) / (2 * h), 1e-5, 1e-7 * (1 + fabs(f[i])));
        }
    }
}

/* A coloured metal in a space whose gamut it leaves: bounds for all channels, and for one. */
static void beyond_one(void)
{
    static const char *const channels[] = {NULL, "c0"};
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha=0.2 f0=1.3:0.7:0.3 kd=0:0.1:0.2");
    const fit_sampling how = {.n = 2000, .max_theta = 70, .glossy = 0.5, .seed = 5};
    ff_table t = fit_measure(&s, &how);
    ff_error err = {0};
    for (size_t k = 0; k < 2; k++) {
        ff_fit_options o = fit_options();
        ff_fit_result r;
        char name[FF_CHANNEL_NAME];
        snprintf(name, sizeof name, "%s", t.channels[0].name);
        const ff_bound bound = {"f0", 0, 2, channels[k] ? name : NULL};
        const ff_constraints c = {.n_bounds = 1, .bound = &bound};
        o.constraints = &c;
        if (!FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, &err) == FF_OK, "%s", err.message)) continue;
        for (size_t channel = 0; channel < 3; channel++) {
            const ff_fit_value *v = ff_fit_result_find(&r, "f0", channel);
            FF_CHECK(!v->at_bound && v->high < 2, "channel %zu: bound %d, up to %g", channel, v->at_bound, v->high);
            FF_CHECK_CLOSE(v->value, s.channel[channel * s.model.n_channel], 1e-6, 1e-9);
        }
        FF_CHECK_CLOSE(ff_fit_result_find(&r, "alpha_x", 0)->value, 0.2, 1e-6, 0);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* Counts: kd of some thousands, ks too. */
static void counts(void)
{
    fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.25 f0=0.3 ks=20000 kd=5000");
    const fit_sampling how = {.n = 2000, .max_theta = 70, .glossy = 0.5, .noise = 0.02, .seed = 6};
    ff_table t = fit_measure(&s, &how);
    ff_error err = {0};
    ff_fit_result r;
    const ff_fit_options o = fit_options();
    ff_model m = s.model;
    FF_CHECK(!ff_model_hold(&m, "f0", 0.3, &err) && !ff_model_vary(&m, "ks", &err) && !ff_model_bound(&m, "kd", 0, 1e5, &err), "%s",
             err.message);
    if (FF_CHECK(fit_table(&t, &m, &o, &r, NULL, &err) == FF_OK, "%s", err.message)) {
        const ff_fit_value *kd = ff_fit_result_find(&r, "kd", 0), *alpha = ff_fit_result_find(&r, "alpha_x", 0);
        FF_CHECK(fabs(kd->value - 5000) < 5 * kd->std_error && kd->std_error < 200, "kd = %g +- %g", kd->value, kd->std_error);
        FF_CHECK(fabs(alpha->value - 0.25) < 5 * alpha->std_error, "alpha = %g +- %g", alpha->value, alpha->std_error);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* A value that is held beyond 1 is that value, in the fit and in its result. */
static void held(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha=0.2 f0=1.3:0.7:0.3 kd=0.1");
    const fit_sampling how = {.n = 1000, .max_theta = 70, .glossy = 0.5, .seed = 7};
    static const double f0[] = {1.3, 0.7, 0.3};
    const ff_fixed fixed = {"f0", 3, f0, NULL};
    const ff_constraints c = {.n_fixed = 1, .fixed = &fixed};
    ff_table t = fit_measure(&s, &how);
    ff_error err = {0};
    ff_fit_result r;
    ff_fit_options o = fit_options();
    o.constraints = &c;
    if (FF_CHECK(fit_table(&t, &s.model, &o, &r, NULL, &err) == FF_OK, "%s", err.message)) {
        for (size_t k = 0; k < 3; k++)
            FF_CHECK(ff_fit_result_find(&r, "f0", k)->value == f0[k], "channel %zu is not held there", k);
        FF_CHECK_CLOSE(ff_fit_result_find(&r, "alpha_x", 0)->value, 0.2, 1e-6, 0);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* A base that takes what the lobes leave over has no meaning where they leave less than nothing; nor has a roughness a wider box.
 */
static void refused(void)
{
    ff_error err = {0};
    ff_model m;
    size_t n = 0;
    for (size_t d = 0; d < ff_term_count(FF_DIFFUSE); d++) {
        char expression[64];
        snprintf(expression, sizeof expression, "ggx+%s", ff_term_at(FF_DIFFUSE, d)->name);
        if (ff_model_parse(expression, &m, &err)) continue;
        const uint32_t couples = ff_diffuse_at((int)d)->couples & FF_COUPLES_CURVED;
        const ff_status status = ff_model_bound(&m, "f0", 0, 2, &err);
        FF_CHECK(status == (couples ? FF_ERR_RANGE : FF_OK), "%s: %d", expression, (int)status);
        n += couples != 0;
    }
    FF_CHECK(n >= 3, "%zu coupled bases", n);
    FF_CHECK(ff_model_parse("ggx+lambert", &m, &err) == FF_OK && ff_model_bound(&m, "alpha", 0.1, 5, &err) == FF_ERR_RANGE,
             "alpha of 5");
    FF_CHECK(ff_model_bound(&m, "f0", -1, 0.5, &err) == FF_ERR_RANGE && ff_model_bound(&m, "kd", 0, 1e16, &err) == FF_ERR_RANGE,
             "below 0, or beyond everything");
}

FF_TEST_MAIN(FF_TEST(derivatives), FF_TEST(beyond_one), FF_TEST(counts), FF_TEST(held), FF_TEST(refused))
