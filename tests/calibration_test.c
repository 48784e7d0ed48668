/* Signals become reflectance: what an instrument would have read of a known surface, of a standard and in the dark, is taken back.
 */
#include "fit_samples.h"
#include "data_formats/table/ff_calibration.h"
#include "data_formats/table/table_struct.h"

static const double pi = 3.14159265358979323846;

enum { INCIDENCES = 4, EXITS = 9, AZIMUTHS = 5, N = INCIDENCES * EXITS * AZIMUTHS, CHANNELS = 2 };

/* Directions of a goniometer, degrees; the sample's azimuth is turned by `turn`. */
static ff_table directions(double turn, int isotropic, int with_sigma)
{
    ff_table t;
    if (ff_table_init(N, CHANNELS, NULL, with_sigma, 0, &t, NULL) != FF_OK) exit(1);
    t.radians_per_unit = pi / 180;
    t.isotropic = isotropic;
    for (size_t i = 0; i < N; i++) {
        t.angle[0][i] = 20.0 * (double)(i / (EXITS * AZIMUTHS)), t.angle[1][i] = turn;
        t.angle[2][i] = 8.0 * (double)(i / AZIMUTHS % EXITS), t.angle[3][i] = turn + 45.0 * (double)(i % AZIMUTHS);
    }
    for (size_t c = 0; c < CHANNELS; c++) snprintf(t.channels[c].name, FF_CHANNEL_NAME, "%c", "ab"[c]);
    return t;
}

static double brdf(size_t c, size_t i)
{
    return 0.1 + 0.05 * (double)c + exp(-0.02 * (double)i) / 3;
}

/* Counts per reflectance, at an incidence. */
static double gain(size_t c, size_t i)
{
    return (4000 - 1000 * (double)c) * (1 + 0.2 * sin(1 + (double)(i / (EXITS * AZIMUTHS))));
}

static const double R = 0.97;

static double dark_of(size_t c, size_t i)
{
    return 12 + 3 * (double)c + 0.01 * (double)(i / AZIMUTHS % 7);
}

/* Signals of the surface (which 0), the standard (1), the dark (2). */
static ff_table signals(int which, double turn, int isotropic, int with_sigma)
{
    ff_table t = directions(turn, isotropic, with_sigma);
    for (size_t c = 0; c < CHANNELS; c++)
        for (size_t i = 0; i < N; i++)
            t.value[c * N + i] = dark_of(c, i) + (which == 0 ? gain(c, i) * pi * brdf(c, i) : which == 1 ? gain(c, i) * R : 0);
    return t;
}

/* Sample k of the result is sample order[k]; n are left. */
static void reorder(ff_table *t, const size_t *order, size_t n)
{
    ff_table old = *t, copy;
    if (ff_table_init(n, CHANNELS, NULL, old.sigma != NULL, 0, &copy, NULL) != FF_OK) exit(1);
    copy.radians_per_unit = old.radians_per_unit, copy.isotropic = old.isotropic;
    memcpy(copy.channels, old.channels, CHANNELS * sizeof *old.channels);
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 4; k++) copy.angle[k][i] = old.angle[k][order[i]];
        for (size_t c = 0; c < CHANNELS; c++) {
            copy.value[c * n + i] = old.value[c * N + order[i]];
            if (old.sigma) copy.sigma[c * n + i] = old.sigma[c * N + order[i]];
        }
    }
    ff_table_clear(t);
    *t = copy;
}

static void check_values(const char *what, const ff_table *t, double tolerance)
{
    double worst = 0;
    for (size_t c = 0; c < CHANNELS; c++)
        for (size_t i = 0; i < N; i++) worst = fmax(worst, fabs(t->value[c * N + i] / brdf(c, i) - 1));
    FF_CHECK(worst < tolerance, "%s: values are off by %g", what, worst);
}

/* In another order, turned about the normal where the sample is isotropic, azimuths counted over the circle, angles not quite met.
 */
static void pair_by_pair(void)
{
    size_t order[N];
    uint64_t state = ff_test_stream("order");
    for (size_t i = 0; i < N; i++) order[i] = i;
    for (size_t i = N; i-- > 1;) {
        const size_t k = (size_t)(ff_test_next(&state) % (i + 1)), was = order[i];
        order[i] = order[k], order[k] = was;
    }
    for (int kind = 0; kind < 3; kind++) {
        ff_table t = signals(0, 0, kind < 2, 0), reference = signals(1, kind == 1 ? 70 : 0, kind < 2, 0),
                 dark = signals(2, 0, kind < 2, 0);
        reorder(&reference, order, N);
        for (size_t i = 0; i < N; i++) {
            for (int k = 0; k < 4; k++) reference.angle[k][i] += 0.02 * (2 * ff_test_uniform() - 1);
            if (i % 3 == 0) reference.angle[1][i] += 360, reference.angle[3][i] -= kind ? 0 : 360;
        }
        const ff_calibration c = {&reference, R, &dark, 0};
        ff_calibrated done;
        ff_error err = {0};
        if (FF_CHECK(ff_table_calibrate(&t, &c, &done, &err) == FF_OK, "%s", err.message)) {
            check_values(kind == 2 ? "anisotropic" : kind ? "turned" : "shuffled", &t, 1e-12);
            FF_CHECK(done.reference == FF_MATCHED_PAIRS && done.dark == FF_MATCHED_PAIRS && done.n_lost == 0 &&
                         isnan(done.reference_error),
                     "matched %d, %d", done.reference, done.dark);
        }
        ff_table_clear(&t), ff_table_clear(&reference), ff_table_clear(&dark);
    }
}

/* The standard at one or two pairs of every incidence, or of one. */
static void by_incidence(void)
{
    for (int one = 0; one < 2; one++) {
        size_t order[N], n = 0;
        for (size_t i = 0; i < N; i++)
            if (i % (EXITS * AZIMUTHS) == 7 || i % (EXITS * AZIMUTHS) == 14)
                if (!one || i < EXITS * AZIMUTHS) order[n++] = i;
        ff_table t = signals(0, 0, 1, 0), reference = signals(1, 0, 1, 0), dark = signals(2, 0, 1, 0);
        for (size_t k = 0; k < n; k++) /* two readings, 1 % apart from their mean */
            for (size_t c = 0; c < CHANNELS; c++) {
                double *v = &reference.value[c * N + order[k]];
                *v = dark_of(c, order[k]) + (*v - dark_of(c, order[k])) * (k % 2 ? 1.01 : 0.99);
            }
        for (size_t c = 0; c < CHANNELS && one; c++)
            for (size_t i = 0; i < N; i++) t.value[c * N + i] = dark_of(c, i) + gain(c, 0) * pi * brdf(c, i);
        reorder(&reference, order, n);
        const ff_calibration c = {&reference, R, &dark, 0};
        ff_calibrated done;
        ff_error err = {0};
        if (FF_CHECK(ff_table_calibrate(&t, &c, &done, &err) == FF_OK, "%s", err.message)) {
            check_values(one ? "one incidence" : "by incidence", &t,
                         1e-4); /* the dark differs by .06 of thousands among the readings */
            FF_CHECK(done.reference == (one ? FF_MATCHED_ALL : FF_MATCHED_INCIDENCE), "matched %d", done.reference);
            FF_CHECK_CLOSE(done.reference_error, 0.01, 0.02, 0);
        }
        ff_table_clear(&t), ff_table_clear(&reference), ff_table_clear(&dark);
    }
}

/* The error of a standard's means: of one reading it is the file's, or not known; above the dark, which may be most of the signal.
 * What was not measured needs no standard. */
static void error_of_the_standard(void)
{
    for (int with_sigma = 0; with_sigma < 2; with_sigma++) {
        size_t order[INCIDENCES];
        for (size_t k = 0; k < INCIDENCES; k++) order[k] = k * EXITS * AZIMUTHS + 7;
        ff_table t = signals(0, 0, 1, 0), reference = signals(1, 0, 1, with_sigma);
        reorder(&reference, order, INCIDENCES);
        for (size_t i = 0; i < N * CHANNELS; i++) t.value[i] += 1e5;
        for (size_t i = 0; i < INCIDENCES * CHANNELS; i++) reference.value[i] += 1e5;
        for (size_t i = 0; i < INCIDENCES * CHANNELS && with_sigma; i++) reference.sigma[i] = 30;
        t.valid[3] = 0, t.angle[0][3] = 33; /* where the standard was not */
        double least = INFINITY;
        for (size_t c = 0; c < CHANNELS; c++)
            for (size_t i = 0; i < N; i++) least = fmin(least, gain(c, i) * R);
        const ff_calibration c = {&reference, R, NULL, 1e5 + 12};
        ff_calibrated done;
        ff_error err = {0};
        if (FF_CHECK(ff_table_calibrate(&t, &c, &done, &err) == FF_OK, "%s", err.message)) {
            if (with_sigma)
                FF_CHECK_CLOSE(done.reference_error, 30 / least, 2e-3, 0);
            else
                FF_CHECK(isnan(done.reference_error), "one reading is known to %g", done.reference_error);
        }
        ff_table_clear(&t), ff_table_clear(&reference);
    }
}

/* Standard deviations against the scatter of many calibrations of noisy signals. */
static void errors_are_the_scatter(void)
{
    enum { REPEATS = 4000, AT = 58 };
    static const double noise[3] = {30, 20, 8};
    double sum = 0, squares = 0, said = 0;
    uint64_t state = ff_test_stream("signals");
    for (int r = 0; r < REPEATS; r++) {
        ff_table t[3];
        for (int k = 0; k < 3; k++) {
            t[k] = signals(k, 0, 1, 1);
            for (size_t i = 0; i < CHANNELS * N; i++) t[k].sigma[i] = noise[k];
            t[k].value[AT] += noise[k] * fit_normal(&state);
        }
        const ff_calibration c = {&t[1], R, &t[2], 0};
        if (ff_table_calibrate(&t[0], &c, NULL, NULL)) exit(1);
        sum += t[0].value[AT], squares += t[0].value[AT] * t[0].value[AT], said += t[0].sigma[AT];
        for (int k = 0; k < 3; k++) ff_table_clear(&t[k]);
    }
    const double sd = sqrt((squares - sum * sum / REPEATS) / (REPEATS - 1));
    FF_CHECK(fabs(said / REPEATS / sd - 1) < 5 / sqrt(2.0 * REPEATS), "scatter %g, stated %g", sd, said / REPEATS);
    FF_CHECK(fabs(sum / REPEATS / brdf(0, AT) - 1) < 5 * sd / sqrt(REPEATS) / brdf(0, AT) + 1e-4, "mean %g of %g", sum / REPEATS,
             brdf(0, AT));
}

static void refusals(void)
{
    ff_table t = signals(0, 0, 1, 0), reference = signals(1, 0, 1, 0), dark = signals(2, 0, 1, 0);
    const double first = t.value[0];
    ff_error err = {0};
    const struct {
        const char *what;
        ff_calibration c;
        ff_status status;
        const char *says;
    } cases[] = {{"R = 0", {&reference, 0, NULL, 0}, FF_ERR_RANGE, "reflectance 0"},
                 {"R = NaN", {&reference, NAN, NULL, 0}, FF_ERR_RANGE, "reflectance"},
                 {"an infinite dark", {&reference, 1, NULL, INFINITY}, FF_ERR_RANGE, "dark signal"},
                 {"all dark", {&reference, 1, NULL, 1e6}, FF_ERR_DATA, "no more than the dark"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        FF_CHECK(ff_table_calibrate(&t, &cases[k].c, NULL, &err) == cases[k].status && strstr(err.message, cases[k].says) &&
                     t.value[0] == first,
                 "%s: %s", cases[k].what, err.message);
    ff_calibration c = {&reference, R, NULL, 0};
    reference.quantity = FF_REFLECTANCE_FACTOR;
    FF_CHECK(ff_table_calibrate(&t, &c, NULL, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "reflectance-factor"), "%s",
             err.message);
    reference.quantity = FF_BRDF;
    t.quantity = FF_BRDF_COS;
    c = (ff_calibration){NULL, 0, NULL, 3};
    FF_CHECK(ff_table_calibrate(&t, &c, NULL, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "cosine"), "%s", err.message);
    t.quantity = FF_BRDF;
    for (size_t i = 0; i < N; i++) reference.angle[0][i] += 3;
    c = (ff_calibration){&reference, R, NULL, 0};
    FF_CHECK(ff_table_calibrate(&t, &c, NULL, &err) == FF_ERR_DATA && strstr(err.message, "theta_i = 0") && t.value[0] == first,
             "%s", err.message);
    snprintf(dark.channels[0].name, FF_CHANNEL_NAME, "other");
    dark.n_channels = 1;
    c = (ff_calibration){NULL, 1, &dark, 0};
    FF_CHECK(ff_table_calibrate(&t, &c, NULL, &err) == FF_ERR_DATA && strstr(err.message, "1 channels"), "%s", err.message);
    dark.n_channels = 2;
    c = (ff_calibration){NULL, 1, NULL, 5};
    FF_CHECK(ff_table_calibrate(&t, &c, NULL, &err) == FF_OK && t.value[0] == first - 5, "a dark signal alone: %s", err.message);
    ff_table_clear(&t), ff_table_clear(&reference), ff_table_clear(&dark);
}

/* Where the standard reads no more than the dark a sample is lost, and counted. */
static void lost_samples(void)
{
    ff_table t = signals(0, 0, 1, 0), reference = signals(1, 0, 1, 0);
    const ff_calibration c = {&reference, R, NULL, 10};
    ff_calibrated done;
    reference.value[53] = 9, reference.value[N + 58] = 10; /* of pairs that are there once */
    FF_CHECK(ff_table_calibrate(&t, &c, &done, NULL) == FF_OK && done.n_lost == 2 && t.n_invalid == 2 && !t.valid[53] &&
                 !t.valid[58],
             "%zu lost, %zu invalid", done.n_lost, t.n_invalid);
    ff_table_clear(&t), ff_table_clear(&reference);
}

FF_TEST_MAIN(FF_TEST(pair_by_pair), FF_TEST(by_incidence), FF_TEST(error_of_the_standard), FF_TEST(errors_are_the_scatter),
             FF_TEST(refusals), FF_TEST(lost_samples))
