/* Tabulated distributions: the lattice of a table against the function that the table was made of, its area, slopes and masking,
 * what it does beyond its points, and what it refuses. */
#include "data_formats/table/profile_file_struct.h"
#include "ff_test.h"
#include "models/internal_model.h"

#define PI 3.14159265358979323846

/* ---- tables of known functions --------------------------------------------------------------- */

static double p_ggx(double q2)
{
    return 1 / (PI * (1 + q2) * (1 + q2));
}

static double p_beckmann(double q2)
{
    return exp(-q2) / PI;
}

enum { POINTS = 4000 };
static double xs[POINTS], ys[POINTS];
static ff_profile_table table;

/* n points of p, q even in ln q from 1e-3 to `end`, and 0. */
static void points_of_p(double (*p)(double), int n, double end)
{
    for (int i = 0; i < n; i++) {
        const double q = i ? 1e-3 * pow(end / 1e-3, (i - 1) / (n - 2.)) : 0;
        xs[i] = q * q;
        ys[i] = p(q * q);
    }
}

/* n points of D = p(tan^2 / alpha^2) / (alpha^2 mz^4) over the angle, even, from the normal to `end` degrees. */
static void points_of_d(double (*p)(double), double alpha, int n, double end)
{
    for (int i = 0; i < n; i++) {
        const double theta = end * PI / 180 * i / (n - 1), t = tan(theta), inv_mz2 = 1 + t * t;
        xs[i] = theta;
        ys[i] = theta > 1.5707 ? alpha * alpha / PI : p(t * t / (alpha * alpha)) / (alpha * alpha) * inv_mz2 * inv_mz2;
    }
}

static void made(ff_profile_kind kind, int n)
{
    ff_error err = {0};
    const ff_status status = ff_profile_make(kind, (size_t)n, xs, ys, &table, NULL, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
}

/* ---- the distribution ------------------------------------------------------------------------ */

typedef struct tabulated {
    const ff_ndf *ndf;
    ff_ndf_pass pass;
} tabulated;

static tabulated prepared(void)
{
    tabulated t = {.ndf = ff_kernels_get(FF_ISA_BEST)->ndf[ff_term_find(FF_NDF, "tabulated")]};
    t.pass.values = &table;
    t.pass.v_lo = FF_V_MIN;
    t.pass.v_hi = 1e60;
    t.pass.table = NULL;
    t.ndf->prepare(&t.pass);
    return t;
}

static double p_of(const tabulated *t, double q2, double *dlnp)
{
    double p, d;
    t->ndf->profile(&t->pass, 1, &q2, &p, &d, NULL);
    if (dlnp) *dlnp = d;
    return p;
}

static double lambda_of(const tabulated *t, double v)
{
    double lam, d;
    t->ndf->lambda(&t->pass, 1, &v, &lam, &d, NULL);
    return lam;
}

/* Largest relative error of p up to q2 = most and largest error of Lambda over 1 + Lambda, against a function and its Lambda. */
static void compare(double (*p)(double), const char *other, double scale2, double most, double p_allowed, double lambda_allowed)
{
    const tabulated t = prepared();
    const ff_ndf *ndf = ff_kernels_get(FF_ISA_BEST)->ndf[ff_term_find(FF_NDF, other)];
    double worst_p = 0, worst_lambda = 0;
    for (double x = log(1e-6); x < log(most); x += 0.0137) {
        const double q2 = exp(x), expected = p(q2);
        worst_p = fmax(worst_p, fabs(scale2 * p_of(&t, scale2 * q2, NULL) / expected - 1));
    }
    for (double x = -12; x < 20; x += 0.0917) {
        const double v = exp(x);
        double lam, d;
        ndf->lambda(&t.pass, 1, &v, &lam, &d, NULL);
        worst_lambda = fmax(worst_lambda, fabs(lambda_of(&t, v / scale2) - lam) / (1 + lam));
    }
    printf("  %s: p to %.1e, Lambda to %.1e, area %.9f\n", other, worst_p, worst_lambda, table.area);
    FF_CHECK(worst_p <= p_allowed, "%s: p is off by %.3g", other, worst_p);
    FF_CHECK(worst_lambda <= lambda_allowed, "%s: Lambda is off by %.3g", other, worst_lambda);
    free(t.pass.table);
}

static void tables_are_what_they_were_made_of(void)
{
    points_of_p(p_ggx, 2000, 1e5);
    made(FF_PROFILE_P, 2000);
    FF_CHECK_CLOSE(table.area, 1, 1e-6, 0);
    FF_CHECK_CLOSE(table.half_q2, sqrt(2) - 1, 1e-3, 0);
    compare(p_ggx, "ggx", 1, 1e9, 1e-6, 1e-7);
    points_of_p(p_ggx, 60, 1e3);
    made(FF_PROFILE_P, 60);
    compare(p_ggx, "ggx", 1, 1e6, 2e-2, 1e-3);
    points_of_p(p_beckmann, 2000, 6);
    made(FF_PROFILE_P, 2000);
    compare(p_beckmann, "beckmann", 1, 30, 1e-4, 1e-6);
    points_of_d(p_ggx, 0.3, 3000, 90);
    made(FF_PROFILE_D, 3000);
    compare(p_ggx, "ggx", 0.09, 1e3, 1e-4, 1e-5);
}

/* ---- area, slopes, masking by definition ----------------------------------------------------- */

/* pi integral p dq2 by Simpson's rule on steps of ln q2 that no bin of the lattice knows of. */
static double area(const tabulated *t)
{
    enum { N = 400000 };
    const double lo = -60, hi = 60, step = (hi - lo) / N;
    double sum = 0;
    for (int i = 0; i <= N; i++) {
        const double q2 = exp(lo + i * step);
        sum += (i == 0 || i == N ? 1 : i % 2 ? 4 : 2) * q2 * p_of(t, q2, NULL);
    }
    return PI * sum * step / 3;
}

/* As tests/distribution_test.c has it; beyond q2 = 2^40 p ~ q2^-2. */
static double lambda_by_definition(const tabulated *t, double mu)
{
    enum { N = 40000 };
    const double last = 17179869184.0, end = sqrt(log(last / mu)), step = end / N;
    double sum = 0, f = 0;
    for (int i = 1; i <= N; i++) {
        const double z = i * step, y = z * z, s = sqrt(expm1(2 * y)), slope = mu * exp(y);
        const double kernel = s < 0.02 ? s * s * s * (1. / 3 - s * s * (1. / 5 - s * s / 7)) : s - atan(s);
        f = 2 * z * kernel * slope * slope * p_of(t, slope * slope, NULL);
        sum += step * f;
    }
    return 2 * (sum - step * f / 2) + 2 * last * last * p_of(t, last * last, NULL) * (last / mu);
}

/* A coarse and uneven measurement of something between the named distributions, with a hump at the side. */
static int measured(ff_profile_kind kind)
{
    static const double theta[] = {0, 1, 2, 3.5, 5, 7, 8, 11, 14, 15, 20, 24, 31, 40, 44, 55, 63, 72, 80, 85};
    static const double d[] = {9.1, 9.05, 8.8, 8.1, 7.4,  6.1,  5.2,  3.7,   3.9,   4.1,
                               2.0, 1.1,  0.6, 0.2, 0.21, 0.07, 0.03, 0.011, 0.004, 0.002};
    const int n = sizeof theta / sizeof *theta;
    for (int i = 0; i < n; i++) {
        const double a = theta[i] * PI / 180, t = tan(a), mz = cos(a);
        xs[i] = kind == FF_PROFILE_D ? a : t * t;
        ys[i] = kind == FF_PROFILE_D ? d[i] : d[i] * mz * mz * mz * mz;
    }
    return n;
}

static void a_coarse_table_is_a_distribution(void)
{
    for (int kind = 0; kind < 2; kind++) {
        const int n = measured((ff_profile_kind)kind);
        made((ff_profile_kind)kind, n);
        const tabulated t = prepared();
        double worst_point = 0, worst_slope = 0, worst_lambda = 0;
        FF_CHECK_CLOSE(area(&t), 1, 1e-9, 0);
        for (int i = 0; i < n; i++) {
            const double mz = cos(xs[i]), q2 = kind == FF_PROFILE_D ? 1 / (mz * mz) - 1 : xs[i];
            const double given = kind == FF_PROFILE_D ? ys[i] * mz * mz * mz * mz : ys[i];
            worst_point = fmax(worst_point, fabs(p_of(&t, q2, NULL) * table.area / given - 1));
        }
        for (double x = -15; x < 30; x += 0.01) {
            const double q2 = exp(x), h = 1e-5 * q2;
            double d, f[4];
            p_of(&t, q2, &d);
            for (int k = 0; k < 4; k++) f[k] = log(p_of(&t, q2 + (k < 2 ? k - 2 : k - 1) * h, NULL));
            worst_slope = fmax(worst_slope, fabs((8 * (f[2] - f[1]) - (f[3] - f[0])) / (12 * h) - d) * q2);
        }
        for (double x = -9; x < 4; x += 0.31) {
            const double mu = exp(x), lam = lambda_of(&t, 1 / (mu * mu)), expected = lambda_by_definition(&t, mu);
            FF_CHECK(lam >= 0, "Lambda(%g) is %g", mu, lam);
            worst_lambda = fmax(worst_lambda, fabs(lam - expected) / (1 + expected));
        }
        printf("  kind %d: points to %.1e, slopes to %.1e, Lambda by definition to %.1e\n", kind, worst_point, worst_slope,
               worst_lambda);
        FF_CHECK(worst_point <= 1e-4, "the points are met to %.3g", worst_point);
        FF_CHECK(worst_slope <= 1e-6, "slopes are off by %.3g", worst_slope); /* a difference over the seam of two bins: 3e-7 */
        FF_CHECK(worst_lambda <= 1e-7, "Lambda is off by %.3g", worst_lambda);
        free(t.pass.table);
    }
}

/* Between points that fall, the profile falls. */
static void monotone_points_make_a_monotone_profile(void)
{
    static const double q2[] = {0, 0.1, 0.11, 0.5, 0.9, 2, 2.1, 9, 30}, p[] = {1, 0.999, 0.5, 0.49, 0.489, 0.488, 1e-3, 9e-4, 1e-7};
    memcpy(xs, q2, sizeof q2);
    memcpy(ys, p, sizeof p);
    made(FF_PROFILE_P, 9);
    const tabulated t = prepared();
    double before = p_of(&t, 0, NULL);
    for (double x = -20; x < 40; x += 0.001) {
        const double now = p_of(&t, exp(x), NULL);
        FF_CHECK(now <= before * (1 + 1e-12), "p rises at q2 = %g from %.17g to %.17g", exp(x), before, now);
        before = now;
    }
    free(t.pass.table);
}

static void the_scale_of_the_values_does_not_matter(void)
{
    static ff_profile_table other;
    const int n = measured(FF_PROFILE_D);
    made(FF_PROFILE_D, n);
    other = table;
    for (int i = 0; i < n; i++) ys[i] *= 0.037;
    made(FF_PROFILE_D, n);
    FF_CHECK_CLOSE(table.area, 0.037 * other.area, 1e-13, 0);
    for (int k = 0; k < FF_PROFILE_BINS; k++) FF_CHECK_CLOSE(table.c[0][k], other.c[0][k], 0, 1e-12 * 100);
}

/* ---- the ends -------------------------------------------------------------------------------- */

static double power_at(const tabulated *t, double q2)
{
    double d;
    p_of(t, q2, &d);
    return d * q2;
}

static void beyond_the_last_point(void)
{
    points_of_p(p_ggx, 300, 30); /* ends at q2 = 900, falling as q2^-2 */
    made(FF_PROFILE_P, 300);
    tabulated t = prepared();
    FF_CHECK_CLOSE(power_at(&t, 1e6), -2, 1e-2, 0);
    FF_CHECK_CLOSE(power_at(&t, 1e20), -2, 1e-12, 0);
    free(t.pass.table);
    points_of_p(p_beckmann, 300, 4); /* ends at q2 = 16: the power that it has there */
    made(FF_PROFILE_P, 300);
    t = prepared();
    FF_CHECK(power_at(&t, 1e3) < -14, "the power is %g", power_at(&t, 1e3));
    free(t.pass.table);
    points_of_d(p_ggx, 0.3, 60, 59);
    for (int i = 50; i < 60; i++) ys[i] = 0.01 * (i - 40); /* a rise at the end: D stays */
    made(FF_PROFILE_D, 60);
    t = prepared();
    const double mz2 = 1 / (1 + 1e4);
    FF_CHECK_CLOSE(p_of(&t, 1e4, NULL) * table.area / (mz2 * mz2), ys[59], 1e-3, 0);
    FF_CHECK_CLOSE(power_at(&t, 1e4), -2, 1e-3, 0);
    free(t.pass.table);
}

/* Zeros at the end, in the middle, and at the horizon; a table that begins off the normal. */
static void zeros_and_gaps(void)
{
    points_of_d(p_ggx, 0.1, 91, 90);
    ys[90] = 0;
    made(FF_PROFILE_D, 91);
    const double whole = table.area;
    for (int i = 60; i < 91; i++) ys[i] = 0;
    made(FF_PROFILE_D, 91);
    FF_CHECK_CLOSE(table.area, whole, 0.01, 0);
    tabulated t = prepared();
    FF_CHECK(p_of(&t, 1e4, NULL) < 1e-25, "p is %g behind the zeros", p_of(&t, 1e4, NULL));
    FF_CHECK_CLOSE(area(&t), 1, 1e-9, 0);
    free(t.pass.table);
    points_of_d(p_ggx, 0.1, 91, 90);
    made(FF_PROFILE_D, 91);
    t = prepared();
    const double centre = p_of(&t, 0, NULL);
    free(t.pass.table);
    ff_error err = {0};
    FF_CHECK(ff_profile_make(FF_PROFILE_D, 90, xs + 1, ys + 1, &table, NULL, &err) == FF_OK, "%s", err.message);
    t = prepared();
    FF_CHECK_CLOSE(p_of(&t, 0, NULL), centre, 0.02, 0);
    free(t.pass.table);
}

/* ---- what is refused ------------------------------------------------------------------------- */

static void refused(const char *what, ff_profile_kind kind, size_t n, size_t index)
{
    static ff_profile_table untouched;
    size_t bad = 12345;
    ff_error err = {0};
    memset(&untouched, 0x5A, sizeof untouched);
    const ff_status status = ff_profile_make(kind, n, xs, ys, &untouched, &bad, &err);
    FF_CHECK(status == FF_ERR_DATA && err.code == status, "%s: %s", what, ff_status_str(status));
    FF_CHECK(bad == index, "%s: about point %zu, expected %zu", what, bad, index);
    FF_CHECK(strstr(err.message, "found") && strstr(err.message, "expected"), "%s: '%s'", what, err.message);
    for (size_t i = 0; i < sizeof untouched; i++)
        if (((unsigned char *)&untouched)[i] != 0x5A) {
            FF_CHECK(0, "%s: byte %zu of the table was written", what, i);
            break;
        }
}

static void refusals(void)
{
    const struct {
        const char *what;
        ff_profile_kind kind;
        int index;
        double x, y;
    } cases[] = {
        {"NaN angle", FF_PROFILE_D, 3, NAN, 1},          {"infinite D", FF_PROFILE_D, 5, -1e9, INFINITY},
        {"negative D", FF_PROFILE_D, 7, -1e9, -1e-9},    {"negative angle", FF_PROFILE_D, 0, -1e-3, 1},
        {"beyond 90 degrees", FF_PROFILE_D, 19, 1.6, 1}, {"angle again", FF_PROFILE_D, 2, 1 * PI / 180, 1},
        {"falling q2", FF_PROFILE_P, 4, 1e-5, 1},        {"NaN p", FF_PROFILE_P, 0, -1e9, NAN},
        {"infinite q2", FF_PROFILE_P, 19, INFINITY, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const int n = measured(cases[i].kind);
        if (cases[i].x > -1e8 || isnan(cases[i].x)) xs[cases[i].index] = cases[i].x;
        ys[cases[i].index] = cases[i].y;
        refused(cases[i].what, cases[i].kind, (size_t)n, (size_t)cases[i].index);
    }
    measured(FF_PROFILE_D);
    refused("3 points", FF_PROFILE_D, 3, 3);
    refused("no points", FF_PROFILE_D, 0, 0);
    for (int i = 0; i < 20; i++) ys[i] = 0;
    refused("nothing but zeros", FF_PROFILE_D, 20, 20);
    ys[0] = 1;
    refused("one value", FF_PROFILE_D, 20, 20);
    for (int i = 0; i < 20; i++) xs[i] = i, ys[i] = pow(1 + i, -1.2);
    refused("a tail without a mean", FF_PROFILE_P, 20, 19);
    for (int i = 0; i < 20; i++) xs[i] = 1e-13 * i, ys[i] = pow(1 + i, -3);
    refused("a width that is nothing", FF_PROFILE_P, 20, 20);
}

/* ---- files ----------------------------------------------------------------------------------- */

#define PATH "profile_test.csv"

static void write_text(const char *text)
{
    FILE *f = fopen(PATH, "wb");
    if (!f) exit(1);
    fputs(text, f);
    fclose(f);
}

static void files_come_back(void)
{
    static ff_profile_table read;
    for (int kind = 0; kind < 2; kind++) {
        ff_error err = {0};
        const int n = measured((ff_profile_kind)kind);
        made((ff_profile_kind)kind, n);
        FF_CHECK(ff_profile_write(PATH, (ff_profile_kind)kind, (size_t)n, xs, ys, "made by a test\nin two lines", &err) == FF_OK,
                 "%s", err.message);
        FF_CHECK(ff_profile_read_into(PATH, &read, &err) == FF_OK, "%s", err.message);
        FF_CHECK_CLOSE(read.area, table.area, 1e-12, 0);
        for (int k = 0; k < FF_PROFILE_BINS; k++) FF_CHECK_CLOSE(read.c[0][k], table.c[0][k], 0, 1e-9);
    }
    write_text("\xEF\xBB\xBF# spaces, tabs, quotes, CRLF and blank lines\r\n\r\n \"theta_deg\" , D\r\n0,1\r\n\t1 , 0.5\r\n# "
               "more\r\n5,0.1\r\n40,1e-3");
    ff_error err = {0};
    FF_CHECK(ff_profile_read_into(PATH, &read, &err) == FF_OK, "%s", err.message);
    remove(PATH);
}

static void files_that_are_refused(void)
{
    static const struct {
        const char *text;
        ff_status status;
        long line;
    } cases[] = {
        {"", FF_ERR_READ, 0},
        {"# nothing\n", FF_ERR_READ, 1},
        {"theta,D\n0,1\n", FF_ERR_FORMAT, 1},
        {"D,theta_deg\n1,0\n", FF_ERR_FORMAT, 1},
        {"theta_deg,D,weight\n0,1,1\n", FF_ERR_FORMAT, 1},
        {"theta_deg,D\n", FF_ERR_DATA, 0},
        {"theta_deg,D\n0,1\n1,0.9\n2,0.5\n", FF_ERR_DATA, 0},
        {"theta_deg,D\n0,1\n1,x\n2,0.5\n3,0.2\n", FF_ERR_DATA, 3},
        {"theta_deg,D\n0,1\n1\n2,0.5\n3,0.2\n", FF_ERR_FORMAT, 3},
        {"theta_deg,D\n0,1\n1,0.9,7\n2,0.5\n3,0.2\n", FF_ERR_FORMAT, 3},
        {"theta_deg,D\n0,1\n# a comment\n1,nan\n2,0.5\n3,0.2\n", FF_ERR_DATA, 4},
        {"theta_deg,D\n0,1\n\n1,-0.9\n2,0.5\n3,0.2\n", FF_ERR_DATA, 4},
        {"theta_deg,D\n0,1\n1,0.9\n2,0.5\n91,0.2\n", FF_ERR_DATA, 5},
        {"q2,p\n0,1\n2,0.9\n1,0.5\n91,0.2\n", FF_ERR_DATA, 4},
        {"q2,p\n0,1\n1,0.9\n2,0.85\n3,0.8\n", FF_ERR_DATA, 5},
        {"q2,p\n0,1\n1,\n2,0.85\n3,0.8\n", FF_ERR_DATA, 3},
    };
    static ff_profile_table t;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        ff_error err = {0};
        write_text(cases[i].text);
        const ff_status status = ff_profile_read_into(PATH, &t, &err);
        FF_CHECK(status == cases[i].status && err.code == status, "case %zu: %s: %s", i, ff_status_str(status), err.message);
        FF_CHECK(err.line == cases[i].line && strcmp(err.path, PATH) == 0, "case %zu: %s:%ld, expected line %ld: %s", i, err.path,
                 err.line, cases[i].line, err.message);
        FF_CHECK(strstr(err.message, "found") && strstr(err.message, "expected"), "case %zu: '%s'", i, err.message);
    }
    ff_error err = {0};
    remove(PATH);
    FF_CHECK(ff_profile_read_into(PATH, &t, &err) == FF_ERR_OPEN, "a missing file: %s", err.message);
    FF_CHECK(ff_profile_write("no/such/folder/x.csv", FF_PROFILE_D, 4, xs, ys, NULL, &err) == FF_ERR_WRITE, "%s", err.message);
    xs[2] = NAN;
    FF_CHECK(ff_profile_write(PATH, FF_PROFILE_D, 4, xs, ys, NULL, &err) == FF_ERR_DATA && access(PATH, F_OK) != 0, "%s",
             err.message);
}

FF_TEST_MAIN(FF_TEST(tables_are_what_they_were_made_of), FF_TEST(a_coarse_table_is_a_distribution),
             FF_TEST(monotone_points_make_a_monotone_profile), FF_TEST(the_scale_of_the_values_does_not_matter),
             FF_TEST(beyond_the_last_point), FF_TEST(zeros_and_gaps), FF_TEST(refusals), FF_TEST(files_come_back),
             FF_TEST(files_that_are_refused))
