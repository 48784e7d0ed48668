/* Scatter of a polished surface over eight decades, A / (B + d^g) with A = 3e-7, B = 1e-8, g = 2.2 and 3 % noise, made without this
 * program (abg.csv): the fit finds them, from the default start and by every loss that counts decades alike. */
#include "fit_samples.h"
#include "models/tools/ff_albedo.h"

static const double truth[3] = {3e-7, 1e-8, 2.2};
static const char *const name[3] = {"abg_a", "abg_b", "abg_g"};

static void found(ff_loss loss)
{
    ff_table t;
    ff_model m;
    ff_error err = {0};
    ff_fit_result r;
    ff_fit_options o = fit_options();
    o.loss = loss;
    if (ff_table_read_into(FF_TESTS "/abg.csv", NULL, &t, &err) || ff_model_parse("abg", &m, &err)) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    if (FF_CHECK(fit_table(&t, &m, &o, &r, NULL, &err) == FF_OK && r.outcome == FF_CONVERGED, "%s: %s", ff_loss_name((int)loss),
                 err.message)) {
        for (int k = 0; k < 3; k++) {
            const ff_fit_value *v = ff_fit_result_find(&r, name[k], 0);
            if (!FF_CHECK(v != NULL, "no %s", name[k])) continue;
            FF_CHECK(!v->at_bound && v->low <= truth[k] && truth[k] <= v->high, "%s, %s: %g, %g to %g, expected %g",
                     ff_loss_name((int)loss), name[k], v->value, v->low, v->high, truth[k]);
            FF_CHECK(fabs(v->value / truth[k] - 1) < 0.05, "%s, %s: %g, expected %g", ff_loss_name((int)loss), name[k], v->value,
                     truth[k]);
        }
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

static void eight_decades(void)
{
    found(FF_LOSS_LN);
    found(FF_LOSS_RELATIVE);
    found(FF_LOSS_CUBE_ROOT);
}

/* ---- with a shoulder ------------------------------------------------------------------------- */

/* A scan in the plane of incidence, evenly in the logarithm of the angle from the mirror direction on both sides, by the formula.
 */
static ff_table scan(const double p[3], int oblique, double noise, uint64_t *state)
{
    enum { SIDE = 60 };
    static const double thetas[] = {5, 30, 60};
    ff_table t;
    size_t n = 0;
    if (ff_table_init(3 * 2 * SIDE, 1, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = 1;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 2 * SIDE; k++) {
            const double theta = thetas[i] * FIT_DEGREE, away = (k % 2 ? 1 : -1) * 0.02 * pow(4000, (k / 2) / (SIDE - 1.0));
            const double at = theta + away * FIT_DEGREE, d = fabs(sin(at) - sin(theta));
            if (fabs(at) > 85 * FIT_DEGREE) continue;
            t.angle[0][n] = theta, t.angle[1][n] = 0;
            t.angle[2][n] = fabs(at), t.angle[3][n] = at > 0 ? 180 * FIT_DEGREE : 0;
            t.value[n] = oblique ? p[0] * cos(theta) * cos(at) * pow(1 + d * d / (p[1] * p[1]), -(p[2] + 1) / 2)
                                 : p[0] * pow(1 + d * d / (p[1] * p[1]), p[2] / 2);
            t.value[n] *= 1 + noise * fit_normal(state);
            t.valid[n++] = 1;
        }
    t.n = n;
    return t;
}

/* Whatever the shoulder and the slope: the search starts from the defaults. */
static void shoulders(void)
{
    static const char *const models[] = {"harvey-shack", "k-correlation"};
    static const char *const names[][3] = {{"hs_b0", "hs_l", "hs_s"}, {"kc_b0", "kc_l", "kc_c"}};
    static const double truths[][3] = {{1e3, 1e-3, -1.5}, {5, 0.02, -2.5}, {1e-2, 0.3, -3}, {1e5, 1e-4, -1.8}};
    int outside = 0, all = 0;
    for (int m = 0; m < 2; m++)
        for (size_t i = 0; i < sizeof truths / sizeof *truths; i++) {
            const double p[3] = {truths[i][0], truths[i][1], m ? -1 - truths[i][2] : truths[i][2]};
            uint64_t state = ff_test_stream("%s %zu", models[m], i);
            ff_table t = scan(p, m, 0.03, &state);
            ff_model model;
            ff_fit_result r;
            ff_error err = {0};
            ff_fit_options o = fit_options();
            o.loss = FF_LOSS_LN;
            if (ff_model_parse(models[m], &model, &err)) exit(1);
            if (FF_CHECK(fit_table(&t, &model, &o, &r, NULL, &err) == FF_OK && r.outcome == FF_CONVERGED, "%s", err.message)) {
                for (int k = 0; k < 3; k++) {
                    const ff_fit_value *v = ff_fit_result_find(&r, names[m][k], 0);
                    if (!FF_CHECK(v != NULL, "no %s", names[m][k])) continue;
                    FF_CHECK(fabs(v->value - p[k]) < 5 * v->std_error, "%s of set %zu: %g +- %g, expected %g", names[m][k], i,
                             v->value, v->std_error, p[k]);
                    FF_CHECK(v->std_error < 0.1 * fabs(p[k]), "%s of set %zu: %g +- %g", names[m][k], i, v->value, v->std_error);
                    outside += !(v->low <= p[k] && p[k] <= v->high);
                    all++;
                }
                ff_fit_result_clear(&r);
            }
            ff_table_clear(&t);
        }
    FF_CHECK(all == 24 && outside <= 5, "%d of %d intervals miss", outside, all); /* more than 5 of 24 once in 1,000 */
}

/* ---- all that is scattered ------------------------------------------------------------------- */

/* Along the normal the projected hemisphere is a disk about the peak, and the integral has a closed form, however narrow the peak:
 * of harvey-shack pi b0 L^2 ((1 + 1/L^2)^q - 1) / q with q = s/2 + 1, of abg with g = 2 pi A ln(1 + 1/B). */
static void albedo(const char *name, const char *const *set, const double *to, int n, double expected)
{
    const double normal[3] = {0, 0, 1};
    ff_model m;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_integral all;
    ff_error err = {0};
    if (ff_model_parse(name, &m, &err)) exit(1);
    ff_model_defaults(&m, 1, shape, channel);
    for (int k = 0; k < n; k++) {
        int found = 0;
        for (uint32_t j = 0; j < m.n_shape; j++)
            if (strcmp(m.shape[j].info->name, set[k]) == 0) shape[j] = to[k], found++;
        for (uint32_t j = 0; j < m.n_channel; j++)
            if (strcmp(m.channel[j].info->name, set[k]) == 0) channel[j] = to[k], found++;
        FF_CHECK(found == 1, "%s: %d parameters named %s", name, found, set[k]);
    }
    if (!FF_CHECK(ff_albedo_directional(&m, FF_ISA_BEST, 1, shape, channel, normal, &all, &err) == FF_OK, "%s", err.message))
        return;
    const double off = fabs(all.value - expected);
    FF_CHECK(off < 1e-9 * expected, "%s, %s %g: %.15g, expected %.15g", name, set[1], to[1], all.value, expected);
    FF_CHECK(off <= all.error + 1e-12 * expected, "%s, %s %g: off by %g, said to be %g", name, set[1], to[1], off, all.error);
}

static void narrow_peaks(void)
{
    static const char *const hs[] = {"hs_b0", "hs_l", "hs_s"};
    static const double slopes[] = {-1.5, -2, -2.5, -3, -4};
    for (int decade = 0; decade < 5; decade++)
        for (int j = 0; j < 5; j++) {
            const double width = pow(10, -decade), to[3] = {0.3 / (width * width), width, slopes[j]}, q = slopes[j] / 2 + 1;
            const double grown = log1p(1 / (width * width));
            albedo("harvey-shack", hs, to, 3, 180 * FIT_DEGREE * 0.3 * (q == 0 ? grown : expm1(q * grown) / q));
        }
    for (int decade = 1; decade < 10; decade += 2) {
        const double b = pow(10, -decade), to[3] = {0.1 * b, b, 2};
        albedo("abg", name, to, 3, 180 * FIT_DEGREE * to[0] * log1p(1 / b));
    }
}

FF_TEST_MAIN(FF_TEST(eight_decades), FF_TEST(shoulders), FF_TEST(narrow_peaks))
