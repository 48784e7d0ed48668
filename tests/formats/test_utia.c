/* UTIA files, made here byte by byte from the layout, against directions and solid angles computed another way. */
#include "check_table.h"

enum { SIDE = 288, N = SIDE * SIDE, COUNT = 3 * N, BYTES = 8 * COUNT };
static const double pi = 3.14159265358979323846;

static void put_double(unsigned char *b, double v)
{
    uint64_t u;
    memcpy(&u, &v, 8);
    for (int k = 0; k < 8; k++) b[k] = (unsigned char)(u >> (8 * k));
}

/* Number of a value by the formula of the database's reader. */
static size_t place(size_t plane, size_t ti, size_t pi_, size_t tv, size_t pv)
{
    return plane * SIDE * SIDE + SIDE * (48 * ti + pi_) + 48 * tv + pv;
}

/* Says where it belongs; some are negative. */
static double value_at(size_t plane, size_t ti, size_t pi_, size_t tv, size_t pv)
{
    const double v = (double)plane + 0.1 * (double)ti + 0.002 * (double)pi_ + 1e-3 / 3 * (double)tv + 1e-5 / 7 * (double)pv + 1e-6;
    return (ti + pi_ + tv + pv) % 50 == 7 ? -v : v;
}

static unsigned char *make_file(void)
{
    unsigned char *b = malloc(BYTES + 16);
    if (!b) exit(1);
    memset(b + BYTES, 0, 16);
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < N; i++)
            put_double(b + 8 * place(c, i / 13824, i / 288 % 48, i / 48 % 6, i % 48),
                       value_at(c, i / 13824, i / 288 % 48, i / 48 % 6, i % 48));
    put_double(b + 8 * 5, -0.0);
    put_double(b + 8 * 6, 0);
    put_double(b + 8 * 7, 5e-324);
    return b;
}

static int read_with(const char *path, int quantity, double scale, ff_table *t)
{
    ff_error err = {0};
    ff_read_options o;
    ff_read_options_init(&o);
    o.quantity = quantity;
    o.scale = scale;
    return FF_CHECK(ff_table_read_with_into(path, &o, t, &err) == FF_OK, "%s", err.message);
}

/* ---- reading --------------------------------------------------------------------------------- */

static void check_sample(const ff_table *t, size_t ti, size_t p_i, size_t tv, size_t pv)
{
    const size_t i = place(0, ti, p_i, tv, pv);
    double v, plane[6], *const planes[6] = {plane, plane + 1, plane + 2, plane + 3, plane + 4, plane + 5};
    for (size_t c = 0; c < 3; c++) {
        ff_table_values(t, c, i, 1, &v);
        if (c > 0 || i > 7) FF_CHECK(v == value_at(c, ti, p_i, tv, pv), "%zu %zu %zu %zu, channel %zu: %g", ti, p_i, tv, pv, c, v);
    }
    const double a = 15 * (double)ti * pi / 180, b = 7.5 * (double)p_i * pi / 180, c = 15 * (double)tv * pi / 180,
                 d = 7.5 * (double)pv * pi / 180;
    const double expected[6] = {sin(a) * cos(b), sin(a) * sin(b), cos(a), sin(c) * cos(d), sin(c) * sin(d), cos(c)};
    ff_table_directions(t, i, 1, planes);
    for (int k = 0; k < 6; k++)
        FF_CHECK(fabs(plane[k] - expected[k]) < 1e-15, "%zu %zu %zu %zu: component %d is %g, expected %g", ti, p_i, tv, pv, k,
                 plane[k], expected[k]);
}

static void test_reading(const char *path, const unsigned char *bytes)
{
    ff_table t;
    if (!read_with(path, -1, NAN, &t)) return;
    FF_CHECK(t.n == N && t.n_channels == 3 && strcmp(t.format, "utia") == 0 && !t.isotropic && !t.sigma && t.n_invalid == 0,
             "shape");
    FF_CHECK(t.axes.kind == FF_AXES_INCIDENT_EXIT && t.axes.n[0] == 6 && t.axes.n[1] == 48 && t.axes.n[2] == 6 &&
                 t.axes.n[3] == 48 && t.axes.node[0][5] == 75 && t.axes.node[3][47] == 352.5 && t.radians_per_unit == pi / 180,
             "axes");
    FF_CHECK(strcmp(t.channels[0].name, "r") == 0 && strcmp(t.channels[2].name, "b") == 0 && t.channels[1].scale == 1, "channels");
    FF_CHECK(strstr(t.note, "without the cosine") && strstr(t.note, "scale") && strstr(t.note, "linear"), "note '%s'", t.note);
    size_t negative = 0;
    for (size_t i = 0; i < N; i++) negative += i > 7 && value_at(0, i / 13824, i / 288 % 48, i / 48 % 6, i % 48) < 0;
    for (size_t i = 0; i <= 7; i++) negative += value_at(1, 0, 0, 0, i) < 0;
    FF_CHECK(t.n_negative == negative && negative > 1000, "%zu negative, expected %zu", t.n_negative, negative);
    FF_CHECK(t.value[7] == 5e-324 && signbit(t.value[5]) && t.value[5] == 0, "small numbers");
    for (int k = 0; k < 3000; k++)
        check_sample(&t, ff_test_random() % 6, ff_test_random() % 48, ff_test_random() % 6, ff_test_random() % 48);
    check_sample(&t, 5, 47, 5, 47);
    const char *copy = ff_test_path("copy.bin");
    ff_error err = {0};
    FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s", err.message);
    size_t n;
    char *written = ff_test_slurp(copy, &n);
    FF_CHECK(n == BYTES && memcmp(written, bytes, BYTES) == 0, "the copy differs");
    free(written);
    ff_table_clear(&t);
}

static void test_weights(const char *path)
{
    ff_table t;
    if (!read_with(path, -1, NAN, &t)) return;
    double sum = 0, normal = 0, cosines = 0,
           plane[6], *const planes[6] = {plane, plane + 1, plane + 2, plane + 3, plane + 4, plane + 5};
    for (size_t i = 0; i < N; i++) {
        ff_table_directions(&t, i, 1, planes);
        sum += t.weight[i];
        cosines += t.weight[i] * plane[2] * plane[5];
        if (plane[2] > 0.9999 && plane[5] > 0.9999) normal += t.weight[i];
    }
    const double side = 2 * pi * (1 - cos(82.5 * pi / 180)), cap = 2 * pi * (1 - cos(7.5 * pi / 180)), s = sin(82.5 * pi / 180);
    FF_CHECK(ff_table_has_weights(&t) && fabs(sum / (side * side) - 1) < 1e-12, "all cells: %.15g, expected %.15g", sum,
             side * side);
    FF_CHECK(fabs(normal / (cap * cap) - 1) < 1e-12, "both at the normal: %.15g, expected %.15g", normal, cap * cap);
    FF_CHECK(fabs(cosines / (pi * s * s * pi * s * s) - 1) < 0.02, "integral of both cosines: %g", cosines);
    for (size_t ti = 0; ti < 6; ti++)
        for (size_t tv = 0; tv < 6; tv++) {
            const double a = ti ? cos((15 * (double)ti - 7.5) * pi / 180) : 1, b = cos((15 * (double)ti + 7.5) * pi / 180),
                         c = tv ? cos((15 * (double)tv - 7.5) * pi / 180) : 1, d = cos((15 * (double)tv + 7.5) * pi / 180);
            const double cell = (a - b) * (c - d) * (2 * pi / 48) * (2 * pi / 48), w = t.weight[place(0, ti, 11, tv, 40)];
            FF_CHECK(fabs(w / cell - 1) < 1e-12, "cell %zu %zu: %g, expected %g", ti, tv, w, cell);
        }
    ff_table_clear(&t);
}

static void test_quantity(const char *path)
{
    ff_table t;
    double v;
    const size_t i = place(0, 3, 5, 4, 9);
    const double stored = value_at(1, 3, 5, 4, 9);
    if (read_with(path, FF_BRDF_COS, NAN, &t)) {
        ff_table_values(&t, 1, i, 1, &v);
        FF_CHECK(fabs(v * 0.5 / stored - 1) < 1e-15 && t.quantity == FF_BRDF_COS && t.n_invalid == 0, "f cos: %g of %g", v, stored);
        FF_CHECK(!strstr(t.note, "without the cosine"), "note '%s'", t.note);
        ff_table_clear(&t);
    }
    if (read_with(path, FF_REFLECTANCE_FACTOR, NAN, &t)) {
        ff_table_values(&t, 1, i, 1, &v);
        FF_CHECK(fabs(v * pi / stored - 1) < 1e-15, "pi f: %g of %g", v, stored);
        ff_table_clear(&t);
    }
    if (read_with(path, -1, 0.25, &t)) {
        ff_table_values(&t, 1, i, 1, &v);
        FF_CHECK(v == 0.25 * stored, "scaled: %g of %g", v, stored);
        ff_error err = {0};
        const char *copy = ff_test_path("scaled.bin");
        FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s", err.message);
        ff_table_clear(&t);
        if (read_with(copy, -1, NAN, &t)) {
            FF_CHECK(t.value[N + i] == 0.25 * stored, "scaled and written: %g", t.value[N + i]);
            ff_table_clear(&t);
        }
    }
}

/* ---- content that is wrong ------------------------------------------------------------------- */

static void expect_bytes(const char *label, const char *path, const char *format, ff_status code, int64_t byte,
                         const char *const *words)
{
    ff_table t;
    ff_error err = {0};
    ff_status status = ff_table_read_into(path, format, &t, &err);
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

static void test_bad_numbers(const unsigned char *bytes)
{
    const char *path = ff_test_path("bad.bin");
    ff_test_write(path, bytes, BYTES);
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    static const size_t cells[] = {0, 1, 4095, 4096, N - 1, N, 2 * N + 12345, COUNT - 1};
    for (size_t k = 0; k < sizeof cells / sizeof cells[0]; k++) {
        unsigned char b[8];
        const long at = 8 * (long)cells[k];
        put_double(b, bad[k % 3]);
        patch(path, at, b, 8);
        expect_bytes("not finite", path, NULL, FF_ERR_DATA, at,
                     WORDS(k % 3 ? "found inf" : "found nan", "expected a finite number",
                           cells[k] < N       ? "channel r"
                           : cells[k] < 2 * N ? "channel g"
                                              : "channel b"));
        patch(path, at, bytes + at, 8);
    }
    for (int k = 0; k < 500; k++) { /* any bit: an error at that number, or a table */
        const long at = (long)(ff_test_random() % BYTES);
        const unsigned char flipped = (unsigned char)(bytes[at] ^ 1 << ff_test_random() % 8);
        ff_table t;
        ff_error err = {0};
        patch(path, at, &flipped, 1);
        const ff_status status = ff_table_read_into(path, "utia", &t, &err);
        FF_CHECK(status == FF_OK || (status == FF_ERR_DATA && err.byte == at / 8 * 8), "bit in byte %ld: %d %s", at, status,
                 err.message);
        if (status == FF_OK) FF_CHECK(t.n == N && t.n_channels == 3, "bit in byte %ld", at);
        if (status == FF_OK) ff_table_clear(&t);
        patch(path, at, bytes + at, 1);
    }
}

static int descending(const void *a, const void *b)
{
    const long x = *(const long *)a, y = *(const long *)b;
    return (x < y) - (x > y);
}

static void test_sizes(unsigned char *bytes)
{
    enum { CUTS = 300 };
    long cuts[CUTS];
    for (int k = 0; k < CUTS; k++) cuts[k] = k < 100 ? k : k == 100 ? BYTES - 1 : (long)(ff_test_random() % BYTES);
    qsort(cuts, CUTS, sizeof cuts[0], descending);
    const char *path = ff_test_path("cut.bin");
    ff_test_write(path, bytes, BYTES);
    for (int k = 0; k < CUTS; k++) {
        if (truncate(path, cuts[k]) != 0) exit(1);
        char found[40];
        snprintf(found, sizeof found, "after %ld bytes", cuts[k]);
        expect_bytes("cut", path, "utia", FF_ERR_READ, cuts[k], WORDS(found, "expected 1990656 bytes"));
        const ff_format *f = NULL;
        ff_error err = {0};
        FF_CHECK(ff_format_detect(path, &f, &err) != FF_OK || f != ff_format_find("utia"), "%ld bytes are recognised", cuts[k]);
    }
    for (size_t more = 1; more <= 16; more += 5) {
        char found[40];
        ff_test_write(path, bytes, BYTES + more);
        snprintf(found, sizeof found, "found %zu bytes after", more);
        expect_bytes("trailing", path, "utia", FF_ERR_FORMAT, BYTES, WORDS(found, "expected the end"));
    }
}

static void expect_format(const char *label, const unsigned char *bytes, const char *name)
{
    const char *path = ff_test_path("thing");
    ff_test_write(path, bytes, BYTES);
    const ff_format *f = NULL;
    ff_error err = {0};
    const ff_status status = ff_format_detect(path, &f, &err);
    FF_CHECK(name ? status == FF_OK && strcmp(f->name, name) == 0 : status != FF_OK, "%s: %d %s", label, status,
             status == FF_OK ? f->name : "none");
}

static void test_recognition(const unsigned char *bytes)
{
    unsigned char *b = malloc(BYTES);
    if (!b) exit(1);
    expect_format("a UTIA file", bytes, "utia");
    memcpy(b, bytes, BYTES);
    put_double(b + 80, NAN);
    expect_format("one NaN", b, "utia");
    memset(b, 0, BYTES);
    expect_format("zeros", b, NULL);
    for (size_t i = 0; i < BYTES; i++) b[i] = (unsigned char)ff_test_random();
    expect_format("noise", b, NULL);
    for (size_t i = 0; i < BYTES; i++) b[i] = (unsigned char)("0.25 17\n"[i % 8]);
    expect_format("numbers as text", b, "csv"); /* a table without names, which its reader asks for */
    for (size_t i = 0; i < BYTES / 8; i++) put_double(b + 8 * i, ff_test_uniform() * 1e-12);
    expect_format("tiny doubles", b, NULL);
    free(b);
}

/* ---- writing --------------------------------------------------------------------------------- */

static void expect_unwritable(const char *label, const ff_table *t, ff_status code, const char *const *words)
{
    const char *never = ff_test_path("never.bin");
    ff_error err = {0};
    const ff_status status = ff_table_write(never, NULL, t, &err);
    FF_CHECK(status == code && access(never, F_OK) != 0, "%s: %d %s", label, status, err.message);
    for (; *words; words++) FF_CHECK(strstr(err.message, *words), "%s: no '%s' in: %s", label, *words, err.message);
}

static void test_layout(void)
{
    const ff_format *f = ff_format_find("utia");
    ff_table one, t, back;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(1, 1, NULL, 0, 0, &one, &err) == FF_OK, "%s", err.message)) return;
    strcpy(one.channels[0].name, "f");
    FF_CHECK(f->layout(&one, "fine", &t, &err) == FF_ERR_SYNTAX && strstr(err.message, "'fine'"), "%s", err.message);
    if (!FF_CHECK(f->layout(&one, NULL, &t, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(t.n == N && t.n_channels == 3 && strcmp(t.channels[1].name, "g") == 0 && t.weight && t.value[7] == 0, "layout");
    for (size_t i = 0; i < COUNT; i++) t.value[i] = ff_test_uniform() - 0.25;
    for (int radians = 0; radians < 2; radians++) {
        const char *path = ff_test_path("laid-out.bin");
        for (int k = 0; k < 4 && radians; k++)
            for (size_t a = 0; a < t.axes.n[k]; a++) t.axes.node[k][a] *= pi / 180;
        for (int k = 0; k < 4 && radians; k++)
            for (size_t i = 0; i < N; i++) t.angle[k][i] *= pi / 180;
        if (radians) t.radians_per_unit = 1;
        FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK, "%s", err.message);
        if (!FF_CHECK(ff_table_read_into(path, NULL, &back, &err) == FF_OK, "%s", err.message)) continue;
        FF_CHECK(check_same_bits(t.value, back.value, COUNT), "values through a file");
        ff_table_clear(&back);
    }
    t.axes.node[2][3] += 1e-6;
    expect_unwritable("another node", &t, FF_ERR_UNSUPPORTED, WORDS("own grid", "352.5", "write csv"));
    t.axes.node[2][3] -= 1e-6;
    t.valid[77] = 0;
    expect_unwritable("not measured", &t, FF_ERR_UNSUPPORTED, WORDS("sample 77", "not measured", "write csv"));
    t.valid[77] = 1;
    t.value[N + 3] = NAN;
    expect_unwritable("nan", &t, FF_ERR_DATA, WORDS("sample 3", "channel g", "finite"));
    t.value[N + 3] = 0;
    t.sigma = calloc(COUNT, sizeof(double));
    for (size_t i = 0; i < COUNT && t.sigma; i++) t.sigma[i] = 1;
    expect_unwritable("sigma", &t, FF_ERR_UNSUPPORTED, WORDS("standard deviations", "write csv"));
    expect_unwritable("scattered", &one, FF_ERR_UNSUPPORTED, WORDS("3 channels", "found 1 channels", "resample"));
    free(t.sigma);
    t.sigma = NULL;
    ff_status status = ff_table_write("/dev/full", "utia", &t, &err);
    FF_CHECK(status == FF_ERR_WRITE && strstr(err.message, "No space"), "%d %s", status, err.message);
    ff_table_clear(&t);
    ff_table_clear(&one);
    if (!FF_CHECK(ff_table_init(1, 4, NULL, 0, 0, &one, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(f->layout(&one, NULL, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "found 4"), "%s", err.message);
    ff_table_clear(&one);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

static unsigned char *made;
static char made_path[160];

static void setup(void)
{
    made = make_file();
    snprintf(made_path, sizeof made_path, "%s", ff_test_path("made.bin"));
    ff_test_write(made_path, made, BYTES);
}

static void reading(void)
{
    setup();
    test_reading(made_path, made);
    test_weights(made_path);
    test_quantity(made_path);
    free(made);
}

static void damage(void)
{
    setup();
    test_bad_numbers(made);
    test_sizes(made);
    test_recognition(made);
    free(made);
}

static void pipes(void)
{
    setup();
    check_pipe("utia", made, BYTES, 1000000);
    free(made);
}

FF_TEST_MAIN(FF_TEST(reading), FF_TEST(damage), FF_TEST(pipes), FF_TEST(test_layout))
