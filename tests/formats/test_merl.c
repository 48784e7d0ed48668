/* MERL files, made here, and the grid: directions and weights against their definitions. */
#include "check_table.h"
#include <stdint.h>

enum { N = 1458000, BYTES = 12 + 24 * N };
static const double pi = 3.14159265358979323846;
static const double scale[3] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

/* ---- grid ------------------------------------------------------------------------------------ */

typedef struct vec {
    double x, y, z;
} vec;

static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* Definition of the pair, in the words of Rusinkiewicz 1998 and independent of the room's: d turned about y by theta_h, then about
 * z. */
static void pair(double theta_h, double phi_h, double theta_d, double phi_d, vec *wi, vec *wo)
{
    vec h = {sin(theta_h) * cos(phi_h), sin(theta_h) * sin(phi_h), cos(theta_h)};
    vec d = {sin(theta_d) * cos(phi_d), sin(theta_d) * sin(phi_d), cos(theta_d)};
    vec t = {cos(theta_h) * d.x + sin(theta_h) * d.z, d.y, cos(theta_h) * d.z - sin(theta_h) * d.x};
    *wi = (vec){cos(phi_h) * t.x - sin(phi_h) * t.y, sin(phi_h) * t.x + cos(phi_h) * t.y, t.z};
    double c = 2 * dot(h, *wi);
    *wo = (vec){c * h.x - wi->x, c * h.y - wi->y, c * h.z - wi->z};
}

static void sample_angles(size_t i, double *theta_h, double *theta_d, double *phi_d)
{
    double node = (double)(i / 16200) + 0.5;
    *theta_h = node * node / 90 * pi / 180;
    *theta_d = ((double)(i / 180 % 90) + 0.5) * pi / 180;
    *phi_d = ((double)(i % 180) + 0.5) * pi / 180;
}

static void test_directions(void)
{
    double *store = malloc(6 * (size_t)N * sizeof(double)), *part = malloc(6 * 1000 * sizeof(double));
    if (!store || !part) exit(1);
    double *planes[6], *parts[6];
    for (int k = 0; k < 6; k++) planes[k] = store + k * N, parts[k] = part + k * 1000;
    ff_grid_merl.directions(0, N, planes);
    double worst = 0;
    for (size_t i = 0; i < N; i++) {
        double th, td, pd;
        sample_angles(i, &th, &td, &pd);
        vec wi, wo;
        pair(th, 0, td, pd, &wi, &wo);
        const double expected[6] = {wi.x, wi.y, wi.z, wo.x, wo.y, wo.z};
        for (int k = 0; k < 6; k++) worst = fmax(worst, fabs(planes[k][i] - expected[k]));
    }
    FF_CHECK(worst < 4e-16 * 3, "directions differ from their definition by %g", worst);
    for (int trial = 0; trial < 300; trial++) { /* any range gives the same bits, and not a number more */
        size_t first = ff_test_random() % N, count = ff_test_random() % 999;
        if (first + count > N) count = N - first;
        for (int k = 0; k < 6; k++) parts[k][count] = -77;
        ff_grid_merl.directions(first, count, parts);
        for (int k = 0; k < 6; k++)
            FF_CHECK(check_same_bits(parts[k], planes[k] + first, count) && parts[k][count] == -77, "range %zu + %zu, plane %d",
                     first, count, k);
    }
    free(store);
    free(part);
}

/* |d(wi, wo) / d(h, d)| by finite differences: both directions in local coordinates of the tangent planes. */
static double jacobian(double th, double ph, double td, double pd)
{
    const double at[4] = {th, ph, td, pd}, e = 1e-6;
    double j[4][4];
    vec wi, wo, a, b, c, d;
    pair(th, ph, td, pd, &wi, &wo);
    for (int k = 0; k < 4; k++) {
        double lo[4], hi[4];
        memcpy(lo, at, sizeof lo);
        memcpy(hi, at, sizeof hi);
        lo[k] -= e, hi[k] += e;
        pair(lo[0], lo[1], lo[2], lo[3], &a, &b);
        pair(hi[0], hi[1], hi[2], hi[3], &c, &d);
        const vec dw[2] = {{(c.x - a.x) / (2 * e), (c.y - a.y) / (2 * e), (c.z - a.z) / (2 * e)},
                           {(d.x - b.x) / (2 * e), (d.y - b.y) / (2 * e), (d.z - b.z) / (2 * e)}};
        const vec w[2] = {wi, wo};
        for (int s = 0; s < 2; s++) { /* components along e_theta and e_phi of that direction */
            double rho = hypot(w[s].x, w[s].y);
            vec e_phi = {-w[s].y / rho, w[s].x / rho, 0};
            vec e_theta = {w[s].z * w[s].x / rho, w[s].z * w[s].y / rho, -rho};
            j[2 * s][k] = dot(dw[s], e_theta);
            j[2 * s + 1][k] = dot(dw[s], e_phi);
        }
    }
    double det = 1;
    for (int k = 0; k < 4; k++) { /* elimination with pivoting */
        int p = k;
        for (int r = k + 1; r < 4; r++)
            if (fabs(j[r][k]) > fabs(j[p][k])) p = r;
        for (int c2 = 0; c2 < 4; c2++) {
            double swap = j[k][c2];
            j[k][c2] = j[p][c2];
            j[p][c2] = swap;
        }
        det *= j[k][k];
        for (int r = k + 1; r < 4; r++)
            for (int c2 = 3; c2 >= k; c2--) j[r][c2] -= j[r][k] / j[k][k] * j[k][c2];
    }
    return fabs(det);
}

/* The measure of a cell: that determinant by the midpoint rule over theta_h and theta_d (it depends on neither azimuth), times the
 * azimuth of h and twice the cell of phi_d, which is folded. */
static double measured_cell(size_t h, size_t d, size_t p)
{
    enum { STEPS = 5 };
    double lo = (double)(h * h) / 90, hi = (double)((h + 1) * (h + 1)) / 90, sum = 0;
    double step_h = (hi - lo) / STEPS * pi / 180, step_d = 1.0 / STEPS * pi / 180;
    for (int a = 0; a < STEPS; a++)
        for (int b = 0; b < STEPS; b++) {
            double th = lo * pi / 180 + (a + 0.5) * step_h, td = (double)d * pi / 180 + (b + 0.5) * step_d;
            sum += jacobian(th, 0.3, td, ((double)p + 0.5) * pi / 180) * step_h * step_d;
        }
    return sum * 2 * pi * 2 * pi / 180;
}

static void test_weights(void)
{
    double *w = malloc(N * sizeof(double)), part[1000];
    double *planes[6];
    for (int k = 0; k < 6; k++) planes[k] = malloc(N * sizeof(double));
    if (!w || !planes[5]) exit(1);
    ff_grid_merl.weights(0, N, w);
    ff_grid_merl.directions(0, N, planes);
    double all = 0, above = 0, least = 1, i0 = 0, i1 = 0;
    for (size_t i = 0; i < N; i++) {
        all += w[i];
        least = fmin(least, w[i]);
        if (planes[2][i] > 0 && planes[5][i] > 0) {
            above += w[i];
            i0 += w[i] * planes[2][i] * planes[5][i];
            i1 += w[i] * planes[2][i] * planes[2][i];
        }
    }
    FF_CHECK(least > 0, "a weight of %g", least);
    FF_CHECK(fabs(all / (8 * pi * pi) - 1) < 1e-12, "all cells: %.15g, expected 8 pi^2 = %.15g", all, 8 * pi * pi);
    FF_CHECK(fabs(above / (4 * pi * pi) - 1) < 2e-4, "pairs above the horizon: %.10g, expected (2 pi)^2 = %.10g", above,
             4 * pi * pi);
    FF_CHECK(fabs(i0 / (pi * pi) - 1) < 2e-4, "integral of cos cos: %.10g, expected pi^2 = %.10g", i0, pi * pi);
    FF_CHECK(fabs(i1 / (4 * pi * pi / 3) - 1) < 2e-4, "integral of cos^2: %.10g, expected 4 pi^2 / 3 = %.10g", i1, 4 * pi * pi / 3);

    for (int trial = 0; trial < 1000; trial++) { /* each cell against the measure integrated over it */
        size_t i = ff_test_random() % N;
        double cell = measured_cell(i / 16200, i / 180 % 90, i % 180);
        FF_CHECK(fabs(w[i] / cell - 1) < 1e-3, "cell %zu: %g, by finite differences %g", i, w[i], cell);
        size_t count = ff_test_random() % 999;
        if (i + count > N) count = N - i;
        part[count] = -77;
        ff_grid_merl.weights(i, count, part);
        FF_CHECK(check_same_bits(part, w + i, count) && part[count] == -77, "range %zu + %zu", i, count);
    }
    free(w);
    for (int k = 0; k < 6; k++) free(planes[k]);
}

/* ---- files ----------------------------------------------------------------------------------- */

static void put_int32(unsigned char *b, int32_t v)
{
    for (int k = 0; k < 4; k++) b[k] = (unsigned char)((uint32_t)v >> (8 * k));
}

static void put_double(unsigned char *b, double v)
{
    uint64_t u;
    memcpy(&u, &v, 8);
    for (int k = 0; k < 8; k++) b[k] = (unsigned char)(u >> (8 * k));
}

/* A file of random numbers with some unmeasured cells, byte by byte from the layout; room for 16 bytes more. */
static unsigned char *make_file(void)
{
    unsigned char *b = malloc(BYTES + 16);
    if (!b) exit(1);
    put_int32(b, 90), put_int32(b + 4, 90), put_int32(b + 8, 180);
    for (size_t i = 0; i < N; i++)
        for (size_t c = 0; c < 3; c++)
            put_double(b + 12 + 8 * (c * N + i), i % 5 == 2 ? -1 : ldexp(ff_test_uniform(), (int)(i % 20)));
    for (size_t c = 0; c < 3; c++) put_double(b + 12 + 8 * (c * N + 8), c == 1 ? -0.25 : 3); /* one channel alone */
    put_double(b + 12 + 8 * 9, -0.0);                                                        /* not negative */
    return b;
}

static void test_reading(const unsigned char *bytes)
{
    const char *path = ff_test_path("made.binary"), *again = ff_test_path("again.binary");
    ff_test_write(path, bytes, BYTES);
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(t.n == N && t.n_channels == 3 && t.grid == &ff_grid_merl && t.isotropic == 1 && strcmp(t.format, "merl") == 0,
             "shape");
    FF_CHECK(!t.valid[8] && !t.valid[2] && t.valid[3] && t.valid[9] && t.n_negative == 0, "validity");
    size_t invalid = 0;
    for (size_t i = 0; i < N; i++) invalid += i % 5 == 2 || i == 8;
    FF_CHECK(t.n_invalid == invalid, "%zu invalid, expected %zu", t.n_invalid, invalid);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < N; i += 997) {
            double v, stored;
            unsigned char b[8];
            put_double(b, t.value[c * N + i]);
            FF_CHECK(memcmp(b, bytes + 12 + 8 * (c * N + i), 8) == 0, "cell %zu of channel %zu", i, c);
            ff_table_values(&t, c, i, 1, &v);
            stored = t.value[c * N + i];
            FF_CHECK(v == scale[c] * stored, "scale of channel %zu", c);
        }
    FF_CHECK(ff_table_write(again, NULL, &t, &err) == FF_OK, "%s", err.message);
    size_t n;
    char *copy = ff_test_slurp(again, &n);
    FF_CHECK(n == BYTES && memcmp(copy, bytes, BYTES) == 0, "written file differs from the one that was read");
    free(copy);
    ff_table_clear(&t);
}

static void writing(void)
{
    ff_table t, back;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(N, 3, &ff_grid_merl, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    for (size_t i = 0; i < 3 * (size_t)N; i++) t.value[i] = ff_test_uniform();
    for (size_t i = 0; i < N; i += 3) t.valid[i] = 0;
    const char *path = ff_test_path("made2.binary");
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
    if (FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(memcmp(t.valid, back.valid, N) == 0 && back.value[0] == -1, "validity");
        size_t same = 0, valid = 0;
        double worst = 0;
        for (size_t c = 0; c < 3; c++)
            for (size_t i = 0; i < N; i++) {
                if (!t.valid[i]) continue;
                double v;
                ff_table_values(&back, c, i, 1, &v);
                valid++;
                same += v == t.value[c * N + i];
                worst = fmax(worst, fabs(v / t.value[c * N + i] - 1));
            }
        FF_CHECK(worst < 2.3e-16, "%g from the value written", worst);
        FF_CHECK((double)same > 0.7 * (double)valid, "%zu of %zu come back with the same bits", same, valid);
        printf("values in 1/sr through a MERL file: %.1f %% with the same bits, the rest within %.2g relative\n",
               100 * (double)same / (double)valid, worst);
        ff_table_clear(&back);
    }
    const char *never = ff_test_path("never.binary");
    t.value[N + 4] = -1e-9;
    ff_status status = ff_table_write(never, NULL, &t, &err);
    FF_CHECK(status == FF_ERR_DATA && strstr(err.message, "sample 4, channel c1") && strstr(err.message, "negative") &&
                 access(never, F_OK) != 0,
             "%d %s", status, err.message);
    t.value[N + 4] = NAN;
    status = ff_table_write(never, NULL, &t, &err);
    FF_CHECK(status == FF_ERR_DATA && strstr(err.message, "sample 4") && access(never, F_OK) != 0, "%d %s", status, err.message);
    t.value[N + 4] = 1;
    status = ff_table_write("/dev/full", "merl", &t, &err);
    FF_CHECK(status == FF_ERR_WRITE && strstr(err.message, "No space"), "%d %s", status, err.message);
    ff_table_clear(&t);
    if (!FF_CHECK(ff_table_init(10, 3, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    status = ff_table_write(never, NULL, &t, &err);
    FF_CHECK(status == FF_ERR_UNSUPPORTED && strstr(err.message, "3 channels") && strstr(err.message, "grid 'merl'") &&
                 strstr(err.message, "scattered") && access(never, F_OK) != 0,
             "%d %s", status, err.message);
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

/* What is wrong with a file, told with the byte. The file is changed in place and put back. */
static void expect_bytes(const char *label, const char *path, ff_status code, int64_t byte, const char *const *words)
{
    ff_table t;
    ff_error err = {0};
    ff_status status = ff_table_read_into(path, "merl", &t, &err);
    FF_CHECK(status == code && err.byte == byte && err.line == 0 && strcmp(err.path, path) == 0,
             "%s: %d at byte %lld, expected %d at %lld: %s", label, status, (long long)err.byte, code, (long long)byte,
             err.message);
    for (; *words; words++) FF_CHECK(strstr(err.message, *words), "%s: no '%s' in: %s", label, *words, err.message);
    if (status == FF_OK) ff_table_clear(&t);
}

static void patch(const char *path, long at, const void *bytes, size_t n)
{
    FILE *f = fopen(path, "r+b");
    if (!f || fseek(f, at, SEEK_SET) != 0 || fwrite(bytes, 1, n, f) != n || fclose(f) != 0) exit(1);
}

static void test_bad_content(const unsigned char *bytes)
{
    const char *path = ff_test_path("bad.binary");
    ff_test_write(path, bytes, BYTES);
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    static const size_t cells[] = {0, 1, N - 1, N, 2 * N + 12345, 3 * N - 1};
    for (size_t k = 0; k < sizeof cells / sizeof cells[0]; k++) {
        unsigned char b[8];
        long at = 12 + 8 * (long)cells[k];
        put_double(b, bad[k % 3]);
        patch(path, at, b, 8);
        expect_bytes("not finite", path, FF_ERR_DATA, at,
                     WORDS(k % 3 ? "found inf" : "found nan", "expected a finite number", cells[k] < N ? "channel r" : "channel "));
        patch(path, at, bytes + at, 8);
    }
    static const int32_t wrong[][3] = {{90, 90, 360}, {0, 0, 0}, {-1, -1, -1}, {INT32_MAX, INT32_MAX, INT32_MAX},
                                       {180, 90, 90}, {1, 1, 1}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        unsigned char head[12];
        char found[80];
        for (int d = 0; d < 3; d++) put_int32(head + 4 * d, wrong[k][d]);
        patch(path, 0, head, 12);
        snprintf(found, sizeof found, "%d x %d x %d", wrong[k][0], wrong[k][1], wrong[k][2]);
        expect_bytes("dimensions", path, FF_ERR_FORMAT, wrong[k][0] == 90 ? 8 : 0, WORDS(found, "expected 90 x 90 x 180"));
    }
    static const unsigned char big_endian[12] = {0, 0, 0, 90, 0, 0, 0, 90, 0, 0, 0, 180};
    patch(path, 0, big_endian, 12);
    expect_bytes("byte order", path, FF_ERR_FORMAT, 0, WORDS("big-endian"));
    patch(path, 0, bytes, 12);

    unsigned char minus[8];
    put_double(minus, -0.5);
    unsigned char *all = malloc(BYTES + 16);
    if (!all) exit(1);
    memcpy(all, bytes, BYTES);
    for (size_t i = 0; i < N; i++) memcpy(all + 12 + 8 * (N + i), minus, 8);
    ff_test_write(path, all, BYTES);
    expect_bytes("nothing measured", path, FF_ERR_DATA, 12,
                 WORDS("negative number in each of the 1458000 cells", "expected at least one"));
    memcpy(all, bytes, BYTES);
    memset(all + BYTES, 0, 16);
    for (size_t more = 1; more <= 16; more += 5) {
        ff_test_write(path, all, BYTES + more);
        char found[40];
        snprintf(found, sizeof found, "found %zu bytes after", more);
        expect_bytes("trailing bytes", path, FF_ERR_FORMAT, BYTES, WORDS(found, "expected the end"));
    }
    free(all);
}

/* Every cut of the header, and seeded ones of the rest: by shortening one file, from its end. */
static int descending(const void *a, const void *b)
{
    long x = *(const long *)a, y = *(const long *)b;
    return (x < y) - (x > y);
}

static void test_prefixes(const unsigned char *bytes)
{
    enum { CUTS = 300 };
    long cuts[CUTS];
    for (int k = 0; k < CUTS; k++) cuts[k] = k <= 12 ? k : k == 13 ? BYTES - 1 : 13 + (long)(ff_test_random() % (BYTES - 13));
    qsort(cuts, CUTS, sizeof cuts[0], descending);
    const char *path = ff_test_path("cut.binary");
    ff_test_write(path, bytes, BYTES);
    for (int k = 0; k < CUTS; k++) {
        if (truncate(path, cuts[k]) != 0) exit(1);
        char found[40];
        snprintf(found, sizeof found, "after %ld bytes", cuts[k]);
        expect_bytes("cut", path, FF_ERR_READ, cuts[k], WORDS(found, "expected 34992012 bytes"));
    }
}

/* A file of other dimensions whose size is that of its cells is known as MERL's, and refused for them. */
static void other_dimensions(void)
{
    enum { CELLS = 10 * 20 * 30, SIZE = 12 + 24 * CELLS };
    static const int32_t dimension[3] = {10, 20, 30};
    unsigned char *bytes = calloc(SIZE, 1);
    if (!bytes) exit(1);
    for (int k = 0; k < 3; k++) bytes[4 * k] = (unsigned char)dimension[k];
    const char *path = ff_test_path("other");
    ff_test_write(path, bytes, SIZE);
    check_fails("other dimensions", path, NULL, FF_ERR_FORMAT, 0, WORDS("10 x 20 x 30", "90 x 90 x 180"));
    free(bytes);
}

static void reading(void)
{
    unsigned char *bytes = make_file();
    test_reading(bytes);
    free(bytes);
}

static void damage(void)
{
    unsigned char *bytes = make_file();
    test_bad_content(bytes);
    test_prefixes(bytes);
    free(bytes);
}

static void pipes(void)
{
    unsigned char *bytes = make_file();
    check_pipe("merl", bytes, BYTES, 20000000);
    free(bytes);
}

FF_TEST_MAIN(FF_TEST(test_directions), FF_TEST(test_weights), FF_TEST(other_dimensions), FF_TEST(reading), FF_TEST(writing),
             FF_TEST(damage), FF_TEST(pipes))
