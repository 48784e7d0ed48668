/* The noise of the data: the model by itself, its estimate from the residuals of a fit, and the errors that follow. */
#include "fit_samples.h"
#include "models/noise/noise_struct.h"
#include "fit/noise/internal_noise.h"
#include "simulate/simulate_struct.h"
#include "fit/trust/trust_struct.h"

/* ---- the model ------------------------------------------------------------------------------- */

static void by_its_numbers(void)
{
    ff_noise *n = NULL;
    ff_error err = {0};
    FF_CHECK(ff_noise_parse("relative=0.05,floor=3e-4,counts=1e-5,cos_i=-1,cos_o=0.5", &n, &err) == FF_OK, "%s", err.message);
    const double f = 0.7, ci = 0.3, co = 0.8;
    FF_CHECK_CLOSE(ff_noise_sd(n, 0, f, ci, co), sqrt((9e-8 + 1e-5 * f + 0.0025 * f * f) * pow(ci, -1) * pow(co, 0.5)), 1e-14, 0);
    FF_CHECK_CLOSE(ff_noise_sd(n, 7, -1, 1, 1), 3e-4, 1e-14, 0); /* one level for all channels; below 0 as 0 */
    FF_CHECK(ff_noise_along_scan(n, 0) == 1 && ff_noise_along_scan(n, 1) == 0 && ff_noise_along_scan(n, 1000) == 0, "correlations");
    ff_noise_free(n);
    const ff_noise_level two[2] = {{1, 0, 0}, {0, 0, 4}};
    FF_CHECK(ff_noise_new(two, 2, 0, 0, &n, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_noise_sd(n, 0, 3, 1, 1) == 1 && ff_noise_sd(n, 1, 3, 1, 1) == 6, "a level for each channel");
    ff_noise_free(n);
}

static void what_is_no_noise(void)
{
    static const struct {
        const char *text, *words;
        ff_status status;
    } wrong[] = {{"relativ=0.05", "'relativ' is no part", FF_ERR_UNKNOWN},
                 {"relative", "expected relative=NUMBER", FF_ERR_SYNTAX},
                 {"relative=x", "expected relative=NUMBER", FF_ERR_SYNTAX},
                 {"relative=0.1x", "expected relative=NUMBER", FF_ERR_SYNTAX},
                 {"relative=1e999", "expected relative=NUMBER", FF_ERR_SYNTAX},
                 {"floor=-1", "at or above 0", FF_ERR_RANGE},
                 {"relative=0", "is no noise", FF_ERR_RANGE},
                 {"cos_i=1", "is no noise", FF_ERR_RANGE},
                 {"relative=1e200", "is no noise", FF_ERR_RANGE},
                 {"", "'' is no part", FF_ERR_UNKNOWN},
                 {"relative=1,,floor=1", "'' is no part", FF_ERR_UNKNOWN}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        ff_noise *n = NULL;
        ff_error err = {0};
        const ff_status status = ff_noise_parse(wrong[k].text, &n, &err);
        FF_CHECK(status == wrong[k].status && strstr(err.message, wrong[k].words) && !n, "'%s': %s, '%s'", wrong[k].text,
                 ff_status_str(status), err.message);
    }
}

/* ---- its estimate ---------------------------------------------------------------------------- */

/* A goniometer's table of a surface, with noise of its own: sd sqrt(a + c f^2) cos^(p/2)(theta_i). */
static ff_table measured(const fit_surface *s, const char *grid, double a, double c, double p, uint64_t seed)
{
    ff_simulate_options o;
    ff_table t;
    ff_error err = {0};
    uint64_t state = ff_test_seeded(seed);
    ff_simulate_options_init(&o);
    ff_status status = ff_sampling_parse(grid, &o.sampling, &err);
    if (!status) status = ff_simulate_into(&s->model, s->n_channels, s->shape, s->channel, &o, &t, &err);
    if (status) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    for (size_t k = 0; k < t.n * t.n_channels; k++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_table_directions(&t, k % t.n, 1, planes);
        t.value[k] += sqrt((a + c * t.value[k] * t.value[k]) * pow(fmax(w[2], 1e-3), p)) * fit_normal(&state);
    }
    return t;
}

static ff_fit_options with_noise(void)
{
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.shape = FF_SHAPE_ISOTROPIC;
    o.errors = FF_ERRORS_NOISE;
    o.threads = 1;
    return o;
}

static ff_fit_result fit_of(const ff_table *t, const ff_model *m, const ff_fit_options *o)
{
    ff_problem *p = NULL;
    ff_fit_result r = {.n_channels = 0};
    ff_error err = {0};
    ff_status status = ff_problem_make(t, m, 1, o, &p, &err);
    if (!status) status = ff_problem_fit_into(p, m, o, &r, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    ff_problem_free(p);
    return r;
}

/* About a hundred of the 900 values are within a factor of two of either value below: they tell a standard deviation to
 * 1 / sqrt(2 100) = 7 %, four of which it may be off; p to about 0.1, where the cosine goes from 1 to 0.26. */
static void found_from_residuals(void)
{
    static const struct {
        double a, c, p;
    } truth[] = {{0, 0.0025, 0}, {4e-4, 0, 0}, {0, 0.0025, -1}, {1e-4, 0.0009, 0}};
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.2 f0=0.5 kd=0.1");
    for (size_t k = 0; k < sizeof truth / sizeof *truth; k++) {
        ff_table t = measured(&s, "goniometer:10", truth[k].a, truth[k].c, truth[k].p, 100 + k);
        const ff_fit_options o = with_noise();
        ff_fit_result r = fit_of(&t, &s.model, &o);
        const ff_noise *n = ff_fit_result_noise(&r);
        FF_CHECK(n != NULL, "case %zu: no noise was found", k);
        for (int large = 0; large < 2 && n; large++) { /* where the lambert part is, and at a highlight */
            const double f = large ? 2 : 0.032, want = sqrt(truth[k].a + truth[k].c * f * f) * pow(0.7, 0.5 * truth[k].p),
                         got = ff_noise_sd(n, 0, f, 0.7, 0.7);
            FF_CHECK(fabs(log(got / want)) < 0.28, "case %zu: at %g the noise is %g, true %g", k, f, got, want);
        }
        if (n)
            FF_CHECK(fabs(ff_noise_cos_i(n) - truth[k].p) < 0.5, "case %zu: cos_i is %g, true %g", k, ff_noise_cos_i(n),
                     truth[k].p);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* Channels of which every one is of another brightness, all with 5 % of noise, have one level or their own, and 5 % in each; where
 * one has 15 % it has that, and the others 5. */
static void noises_of_channels(void)
{
    enum { CHANNELS = 6 };
    const fit_surface s =
        fit_surface_make("ggx+lambert", CHANNELS, "alpha=0.2 f0=0.5:0.4:0.3:0.2:0.1:0.04 kd=0.5:0.2:0.1:0.05:0.02:0.01");
    for (int odd = 0; odd < 2; odd++) {
        ff_table t = measured(&s, "goniometer:10", 0, 0.0025, 0, 7);
        ff_table loud = measured(&s, "goniometer:10", 0, 0.0225, 0, 8);
        for (size_t i = 0; i < t.n && odd; i++) t.value[2 * t.n + i] = loud.value[2 * t.n + i];
        const ff_fit_options o = with_noise();
        ff_fit_result r = fit_of(&t, &s.model, &o);
        const ff_noise *n = ff_fit_result_noise(&r);
        FF_CHECK(n != NULL, "no noise was found");
        for (size_t c = 0; c < CHANNELS && n; c++)
            for (int large = 0; large < 2; large++) {
                const double f = s.channel[c * s.model.n_channel + 2] / 3.14159265 * (large ? 20 : 1),
                             want = f * (odd && c == 2 ? 0.15 : 0.05), got = ff_noise_sd(n, c, f, 0.7, 0.7);
                FF_CHECK(fabs(log(got / want)) < 0.28, "channel %zu: at %g the noise is %g, true %g", c, f, got, want);
            }
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
        ff_table_clear(&loud);
    }
}

/* Data without noise have none, and a surface of zeros neither. */
static void nothing_but_rounding(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.2 f0=0.5 kd=0.1");
    for (int zeros = 0; zeros < 2; zeros++) {
        ff_table t = measured(&s, "goniometer:15", 0, 0, 0, 1);
        for (size_t k = 0; k < t.n && zeros; k++) t.value[k] = 0;
        const ff_fit_options o = with_noise();
        ff_fit_result r = fit_of(&t, &s.model, &o);
        FF_CHECK(ff_fit_result_noise(&r) == NULL, "%s: a noise of what has none: %g of f", zeros ? "zeros" : "exact data",
                 ff_fit_result_noise(&r) ? ff_noise_sd(ff_fit_result_noise(&r), 0, 0.1, 1, 1) : 0);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* Levels for another number of channels than are fitted are refused, and not read beyond their end. */
static void levels_of_other_channels(void)
{
    const fit_surface s = fit_surface_make("lambert", 3, "kd=0.4");
    const ff_noise_level level[3] = {{1e-4, 0, 0}, {1e-4, 0, 0}, {1e-4, 0, 0}};
    ff_table t = measured(&s, "goniometer:15", 1e-4, 0, 0, 3);
    for (size_t levels = 1; levels <= 3; levels++) {
        ff_fit_options o = with_noise();
        ff_problem *p = NULL;
        ff_noise *n = NULL;
        ff_fit_result r;
        ff_error err = {0};
        FF_CHECK(ff_noise_new(level, levels, 0, 0, &n, &err) == FF_OK, "%s", err.message);
        o.noise = n;
        ff_status status = ff_problem_make(&t, &s.model, 1, &o, &p, &err);
        if (!status) status = ff_problem_fit_into(p, &s.model, &o, &r, &err);
        FF_CHECK(status == (levels == 2 ? FF_ERR_RANGE : FF_OK), "%zu levels: %s", levels, ff_status_str(status));
        if (levels == 2) FF_CHECK(strstr(err.message, "one for each of the 3 channels"), "'%s'", err.message);
        if (!status) ff_fit_result_clear(&r);
        ff_problem_free(p);
        ff_noise_free(n);
    }
    ff_table_clear(&t);
}

/* ---- errors ---------------------------------------------------------------------------------- */

enum { REPEATS = 200 };

/* One to two values carry each parameter. The intervals by residuals hold the truth in 62 to 72 %, as is known; those by the noise
 * in 95 %, whose scatter over so many measurements is 1.5 %: three of that below. */
static void truth_is_inside(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.2 f0=0.5 kd=0.1");
    int inside[2] = {0, 0};
    double carriers = 0;
    for (uint64_t seed = 0; seed < REPEATS; seed++) {
        ff_table t = measured(&s, "goniometer:10", 0, 0.0025, 0, 1000 + seed);
        for (int source = 0; source < 2; source++) {
            ff_fit_options o = with_noise();
            o.errors = (ff_error_source)source;
            ff_fit_result r = fit_of(&t, &s.model, &o);
            const ff_fit_value *alpha = ff_fit_result_find(&r, "alpha_x", 0);
            inside[source] += alpha->low <= 0.2 && alpha->high >= 0.2;
            if (source == FF_ERRORS_NOISE) carriers += alpha->carriers / REPEATS;
            ff_fit_result_clear(&r);
        }
        ff_table_clear(&t);
    }
    printf("  alpha inside in %d of %d by the noise, %d by residuals; %.1f values carry it\n", inside[0], REPEATS, inside[1],
           carriers);
    FF_CHECK(inside[0] >= 0.95 * REPEATS - 3 * sqrt(0.95 * 0.05 * REPEATS), "%d of %d inside", inside[0], REPEATS);
    FF_CHECK(inside[1] < 0.85 * REPEATS, "by residuals %d of %d inside: the design is not the one it was", inside[1], REPEATS);
    FF_CHECK(carriers > 1 && carriers < 3, "%g values carry alpha", carriers);
}

/* Of equal values of one number each carries its share. Its error is then the floor over the root of their number, moderated by the
 * residuals, which have as much to say as half of them: within four standard deviations of that. */
static void equal_values_carry_equally(void)
{
    const fit_surface s = fit_surface_make("lambert", 1, "kd=0.4");
    ff_table t = measured(&s, "goniometer:15", 1e-4, 0, 0, 7);
    ff_fit_options o = with_noise();
    ff_noise *n = NULL;
    ff_noise_parse("floor=0.01", &n, NULL);
    o.noise = n;
    o.loss = FF_LOSS_PLAIN;
    ff_fit_result r = fit_of(&t, &s.model, &o);
    const ff_fit_value *kd = ff_fit_result_find(&r, "kd", 0);
    const double used = (double)r.effective_samples;
    FF_CHECK_CLOSE(kd->carriers, used, 1e-6, 0);
    FF_CHECK_CLOSE(kd->std_error, 0.01 * 3.14159265358979323846 / sqrt(used), 4 / sqrt(2 * used), 0);
    ff_fit_result_clear(&r);
    ff_noise_free(n);
    ff_table_clear(&t);
}

/* All channels together or one by one: the same errors by the same noise, correlations between channels included. */
static void many_channels_as_few(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 5, "alpha=0.3 f0=0.5 kd=0.1");
    ff_table t = measured(&s, "goniometer:10", 0, 0.0025, 0, 9);
    for (int together = 0; together < 2; together++) {
        ff_fit_result r[2];
        ff_noise *n = NULL;
        ff_noise_parse("relative=0.05,floor=0.001,cos_o=-0.5", &n, NULL);
        if (together) {
            n->between_channels = 0.4;
            for (int lag = 1; lag < 8; lag++) n->along_scan[lag] = pow(0.6, lag);
        }
        for (int many = 0; many < 2; many++) {
            ff_fit_options o = with_noise();
            o.dense_channels = many ? 0 : 100;
            o.noise = n;
            r[many] = fit_of(&t, &s.model, &o);
        }
        FF_CHECK_CLOSE(r[1].shape_value[0].std_error, r[0].shape_value[0].std_error, 1e-5, 0);
        FF_CHECK_CLOSE(r[1].shape_value[0].carriers, r[0].shape_value[0].carriers, 1e-4, 0);
        for (size_t k = 0; k < 5 * s.model.n_channel; k++) {
            if (r[0].channel_value[k].held) continue;
            FF_CHECK_CLOSE(r[1].channel_value[k].std_error, r[0].channel_value[k].std_error, 1e-5, 0);
            FF_CHECK_CLOSE(r[1].channel_value[k].residual_error, r[0].channel_value[k].residual_error, 1e-4, 0);
        }
        ff_fit_result_clear(&r[0]);
        ff_fit_result_clear(&r[1]);
        ff_noise_free(n);
    }
    ff_table_clear(&t);
}

/* Where nothing is wrong, a lower limit of theta moves something in 5 % of measurements. Twice that of a hundred is a chance of 2
 * %. */
static void cut_off_of_the_true_model(void)
{
    enum { TRIES = 100 };
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.2 f0=0.5 kd=0.1");
    int moved = 0;
    for (uint64_t seed = 0; seed < TRIES; seed++) {
        ff_table t = measured(&s, "goniometer:5", 0, 0.0004, 0, 5000 + seed);
        ff_problem *p = NULL;
        ff_fit_options o = with_noise();
        ff_fit_result r;
        ff_cut_off *c = NULL;
        ff_error err = {0};
        ff_status status = ff_problem_make(&t, &s.model, 1, &o, &p, &err);
        if (!status) status = ff_problem_fit_into(p, &s.model, &o, &r, &err);
        if (!status) status = ff_trust_cut_off(p, &o, &r, 70 * FIT_DEGREE, &c, &err);
        FF_CHECK(status == FF_OK, "%s", err.message);
        int any = 0;
        for (size_t k = 0; c && k < c->n_columns; k++) any |= fabs(c->move[k]) > c->limit;
        moved += any;
        ff_cut_off_free(c);
        ff_fit_result_clear(&r);
        ff_problem_free(p);
        ff_table_clear(&t);
    }
    printf("  a lower limit moves something in %d of %d measurements\n", moved, TRIES);
    FF_CHECK(moved <= 12, "%d of %d", moved, TRIES);
}

FF_TEST_MAIN(FF_TEST(by_its_numbers), FF_TEST(what_is_no_noise), FF_TEST(found_from_residuals), FF_TEST(noises_of_channels),
             FF_TEST(nothing_but_rounding), FF_TEST(levels_of_other_channels), FF_TEST(truth_is_inside),
             FF_TEST(equal_values_carry_equally), FF_TEST(many_channels_as_few), FF_TEST(cut_off_of_the_true_model))
