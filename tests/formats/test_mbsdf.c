/* MBSDF files, made here, and two real ones where they are. */
#include "check_table.h"
#include <time.h>

static const double pi = 3.14159265358979323846;

typedef struct made {
    unsigned char b[8192];
    size_t n;      /* bytes      */
    size_t counts; /* of the byte where the last block's three counts begin */
} made;

static void add_text(made *m, const char *text)
{
    memcpy(m->b + m->n, text, strlen(text));
    m->n += strlen(text);
}

static void put_uint32(unsigned char *b, uint32_t u)
{
    for (int k = 0; k < 4; k++) b[k] = (unsigned char)(u >> (8 * k));
}

static void put_float(unsigned char *b, float v)
{
    uint32_t u;
    memcpy(&u, &v, 4);
    put_uint32(b, u);
}

/* Says where it belongs; some are negative. */
static float value_at(size_t ti, size_t to, size_t p, size_t c)
{
    const float v = 0.5f + (float)ti + 0.1f * (float)to + 0.01f * (float)p + 0.001f * (float)c;
    return (ti + to + p) % 7 == 3 ? -v : v;
}

static void add_block(made *m, size_t n_theta, size_t n_phi, int rgb)
{
    const size_t factor = rgb ? 3 : 1;
    m->counts = m->n;
    put_uint32(m->b + m->n, (uint32_t)rgb);
    put_uint32(m->b + m->n + 4, (uint32_t)n_theta);
    put_uint32(m->b + m->n + 8, (uint32_t)n_phi);
    m->n += 12;
    for (size_t ti = 0; ti < n_theta; ti++)
        for (size_t to = 0; to < n_theta; to++)
            for (size_t p = 0; p < n_phi; p++)
                for (size_t c = 0; c < factor; c++)
                    put_float(m->b + m->n + 4 * (factor * (ti * n_phi * n_theta + to * n_phi + p) + c), value_at(ti, to, p, c));
    m->n += 4 * factor * n_theta * n_theta * n_phi;
}

static made make(const char *lines, size_t n_theta, size_t n_phi, int rgb)
{
    made m = {.n = 0};
    add_text(&m, "NVIDIA ARC MBSDF V1\n");
    add_text(&m, lines);
    add_block(&m, n_theta, n_phi, rgb);
    return m;
}

static int read_bytes(const void *b, size_t n, ff_table *t)
{
    const char *path = ff_test_path("made.mbsdf");
    ff_error err = {0};
    ff_test_write(path, b, n);
    return FF_CHECK(ff_table_read_into(path, NULL, t, &err) == FF_OK, "%s", err.message);
}

/* ---- reading --------------------------------------------------------------------------------- */

static void check_table(const ff_table *t, size_t n_theta, size_t n_phi, int rgb)
{
    const size_t n = n_theta * n_theta * n_phi;
    size_t negative = 0, i = 0;
    if (!FF_CHECK(t->n == n && t->n_channels == (rgb ? 3 : 1) && t->isotropic == 1 && strcmp(t->format, "mbsdf") == 0 &&
                      t->n_invalid == 0,
                  "%zu x %zu", t->n, t->n_channels))
        return;
    FF_CHECK(strcmp(t->channels[0].name, rgb ? "r" : "f") == 0 && strcmp(t->channels[t->n_channels - 1].name, rgb ? "b" : "f") == 0,
             "names");
    FF_CHECK(t->axes.kind == FF_AXES_INCIDENT_EXIT && t->axes.n[0] == n_theta && t->axes.n[1] == 1 && t->axes.n[2] == n_theta &&
                 t->axes.n[3] == n_phi,
             "axes");
    double v, d[6], *const planes[6] = {d, d + 1, d + 2, d + 3, d + 4, d + 5};
    for (size_t ti = 0; ti < n_theta; ti++)
        for (size_t to = 0; to < n_theta; to++)
            for (size_t p = 0; p < n_phi; p++, i++) {
                negative += value_at(ti, to, p, 0) < 0;
                for (size_t c = 0; c < t->n_channels; c++) {
                    ff_table_values(t, c, i, 1, &v);
                    FF_CHECK(v == (double)value_at(ti, to, p, c), "%zu %zu %zu, channel %zu: %g", ti, to, p, c, v);
                }
                const double a = pi / 2 * (double)ti / (double)n_theta, b = pi / 2 * (double)to / (double)n_theta,
                             f = n_phi == 1 ? pi / 2 : pi * (double)p / (double)(n_phi - 1);
                const double expected[6] = {sin(a), 0, cos(a), sin(b) * cos(f), sin(b) * sin(f), cos(b)};
                ff_table_directions(t, i, 1, planes);
                for (int k = 0; k < 6; k++)
                    FF_CHECK(fabs(d[k] - expected[k]) < 1e-15, "%zu %zu %zu: component %d is %g, expected %g", ti, to, p, k, d[k],
                             expected[k]);
            }
    FF_CHECK(t->n_negative == negative, "%zu negative, expected %zu", t->n_negative, negative);
}

/* The sum is that of all pairs down to the outer edge of the last band; each cell by its edges. */
static void check_weights(const ff_table *t, size_t n_theta, size_t n_phi)
{
    const double step = pi / 2 / (double)n_theta, edge = n_theta == 1 ? pi / 2 : pi / 2 - step / 2, side = 2 * pi * (1 - cos(edge));
    double sum = 0;
    for (size_t i = 0; i < t->n; i++) {
        const size_t ti = i / (n_theta * n_phi), to = i / n_phi % n_theta, p = i % n_phi;
        const double high_i = n_theta == 1 ? pi / 2 : ((double)ti + 0.5) * step,
                     high_o = n_theta == 1 ? pi / 2 : ((double)to + 0.5) * step;
        const double band_i = (ti ? cos(((double)ti - 0.5) * step) : 1) - cos(high_i),
                     band_o = (to ? cos(((double)to - 0.5) * step) : 1) - cos(high_o);
        const double width = n_phi == 1 ? pi : pi / (double)(n_phi - 1) / (p == 0 || p + 1 == n_phi ? 2 : 1);
        sum += t->weight[i];
        FF_CHECK(fabs(t->weight[i] / (2 * pi * band_i * 2 * width * band_o) - 1) < 1e-10, "cell %zu: %g", i, t->weight[i]);
    }
    FF_CHECK(fabs(sum / (side * side) - 1) < 1e-12, "all cells: %.15g, expected %.15g", sum, side * side);
}

static void test_reading(void)
{
    static const struct {
        const char *lines;
        size_t n_theta, n_phi;
        int rgb;
    } cases[] = {{"MBSDF_DATA_REFLECTION=\n", 3, 4, 1},
                 {"MBSDF_DATA_REFLECTION=\n", 4, 5, 0},
                 {"MBSDF_DATA=\n", 2, 3, 1},
                 {"MEASURED_BY=\"J. Doe \\\"x\\\"\"\n\nDATE=\"2013\"\n\tnot = a pair\nMBSDF_DATA_REFLECTION=\n", 3, 2, 0},
                 {"MBSDF_DATA_REFLECTION\nMBSDF_DATA_REFLECTION=x\nMBSDF_DATA_REFLECTION=\n", 1, 1, 0},
                 {"NAME=\"M\xC3\xBCller\"\nMBSDF_DATA_REFLECTION=\n", 1, 6, 1},
                 {"MBSDF_DATA_REFLECTION=\n", 5, 1, 1}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        made m = make(cases[k].lines, cases[k].n_theta, cases[k].n_phi, cases[k].rgb);
        ff_table t;
        for (int transmission = 0; transmission < 2; transmission++) {
            if (!read_bytes(m.b, m.n, &t)) continue;
            check_table(&t, cases[k].n_theta, cases[k].n_phi, cases[k].rgb);
            check_weights(&t, cases[k].n_theta, cases[k].n_phi);
            FF_CHECK(!strstr(t.note, "transmission") == !transmission && strstr(t.note, "half a step"), "note '%s'", t.note);
            FF_CHECK(!strstr(t.note, "repeated"), "note '%s'", t.note);
            ff_table_clear(&t);
            add_text(&m, "MBSDF_DATA_TRANSMISSION=\n");
            add_block(&m, 2, 2, 0);
        }
    }
}

/* From the second last theta on nothing changes. */
static void repetition(void)
{
    made m = make("MBSDF_DATA_REFLECTION=\n", 5, 3, 1);
    ff_table t;
    unsigned char *v = m.b + m.counts + 12;
    const size_t row = 4 * 3 * 3, slice = 5 * row;
    memcpy(v + 4 * slice, v + 3 * slice, slice);
    if (read_bytes(m.b, m.n, &t)) {
        FF_CHECK(strstr(t.note, "beyond theta_i = 54 degrees") && !strstr(t.note, "beyond theta_o"), "note '%s'", t.note);
        for (size_t i = 0; i < t.n; i++) FF_CHECK(t.valid[i] == (t.angle[0][i] < 60), "sample %zu: valid %d", i, t.valid[i]);
        FF_CHECK(t.n_invalid == 5 * 3, "%zu invalid", t.n_invalid);
        ff_table_clear(&t);
    }
    for (size_t ti = 0; ti < 5; ti++)
        for (size_t to = 3; to < 5; to++) memcpy(v + ti * slice + to * row, v + ti * slice + 2 * row, row);
    if (read_bytes(m.b, m.n, &t)) {
        FF_CHECK(strstr(t.note, "beyond theta_i = 54 degrees") && strstr(t.note, "beyond theta_o = 36 degrees"), "note '%s'",
                 t.note);
        for (size_t i = 0; i < t.n; i++)
            FF_CHECK(t.valid[i] == (t.angle[0][i] < 60 && t.angle[2][i] < 40), "sample %zu: valid %d", i, t.valid[i]);
        ff_table_clear(&t);
    }
    m.b[m.n - 1] ^= 0x80; /* one bit is a difference */
    if (read_bytes(m.b, m.n, &t)) {
        FF_CHECK(!strstr(t.note, "repeated"), "note '%s'", t.note);
        ff_table_clear(&t);
    }
}

static void test_part(void)
{
    const made m = make("MBSDF_DATA_REFLECTION=\n", 2, 2, 0);
    const char *path = ff_test_path("part.mbsdf");
    ff_test_write(path, m.b, m.n);
    static const struct {
        const char *part;
        ff_status status;
        const char *word;
    } cases[] = {{"reflection", FF_OK, ""},
                 {"transmission", FF_ERR_UNSUPPORTED, "not a reflectance; expected 'reflection'"},
                 {"front\n", FF_ERR_UNKNOWN, "'front\\x0a', expected 'reflection'"}};
    for (size_t k = 0; k < 3; k++) {
        ff_table t;
        ff_error err = {0};
        ff_read_options o;
        ff_read_options_init(&o);
        o.part = cases[k].part;
        const ff_status status = ff_table_read_with_into(path, &o, &t, &err);
        FF_CHECK(status == cases[k].status && strstr(err.message, cases[k].word), "part %s: %d %s", cases[k].part, status,
                 err.message);
        if (status == FF_OK) ff_table_clear(&t);
    }
    const made only = make("MBSDF_DATA_TRANSMISSION=\n", 2, 2, 1);
    ff_test_write(path, only.b, only.n);
    check_fails("transmission alone", path, NULL, FF_ERR_UNSUPPORTED, 0, WORDS("transmission alone", "not a reflectance"));
}

/* ---- content that is wrong ------------------------------------------------------------------- */

static void expect_bytes(const char *label, const void *b, size_t n, ff_status code, int64_t byte, const char *const *words)
{
    const char *path = ff_test_path("bad.mbsdf");
    ff_table t;
    memset(&t, 0x5A, sizeof t);
    ff_error err = {0};
    ff_test_write(path, b, n);
    const ff_status status = ff_table_read_into(path, "mbsdf", &t, &err);
    FF_CHECK(status == code && err.byte == byte && err.line == 0 && strcmp(err.path, path) == 0,
             "%s: %d at byte %lld, expected %d at %lld: %s", label, status, (long long)err.byte, code, (long long)byte,
             err.message);
    for (; *words; words++) FF_CHECK(strstr(err.message, *words), "%s: no '%s' in: %s", label, *words, err.message);
    if (status == FF_OK) {
        ff_table_clear(&t);
        return;
    }
    FF_CHECK(t.n_channels == (size_t)0x5A5A5A5A5A5A5A5A, "%s: the table was touched", label);
}

static void expect_text(const char *label, const char *text, ff_status code, int64_t byte, const char *const *words)
{
    expect_bytes(label, text, strlen(text), code, byte, words);
}

static void test_text(void)
{
    expect_text("empty", "", FF_ERR_READ, 0, WORDS("after 0 bytes", "NVIDIA ARC MBSDF V1"));
    expect_text("other version", "NVIDIA ARC MBSDF V2\nx\n", FF_ERR_FORMAT, 0,
                WORDS("'NVIDIA ARC MBSDF V2'", "expected the line NVIDIA"));
    expect_text("crlf", "NVIDIA ARC MBSDF V1\r\nx\n", FF_ERR_FORMAT, 0, WORDS("'NVIDIA ARC MBSDF V1\\x0d'"));
    expect_text("no data", "NVIDIA ARC MBSDF V1\na=\"b\"\n", FF_ERR_READ, 26, WORDS("a line MBSDF_DATA_REFLECTION="));
    expect_text("binary too early", "NVIDIA ARC MBSDF V1\nab\001c\n", FF_ERR_FORMAT, 22, WORDS("'\\x01c'", "before the values"));
    made m = make("MBSDF_DATA_REFLECTION=\n", 2, 2, 1);
    const size_t end = m.n;
    add_text(&m, "MBSDF_DATA_REFLECTION=\n");
    expect_bytes("reflection twice", m.b, m.n, FF_ERR_FORMAT, (int64_t)end,
                 WORDS("'MBSDF_DATA_REFLECTION='", "MBSDF_DATA_TRANSMISSION="));
    m.n = end;
    add_text(&m, "MBSDF_DATA_TRANSMISSION=\n");
    add_block(&m, 1, 2, 0);
    const size_t last = m.n;
    add_text(&m, "xy");
    expect_bytes("trailing", m.b, m.n, FF_ERR_FORMAT, (int64_t)last,
                 WORDS("found 2 bytes after the transmission part", "expected the end"));
    for (size_t more = 1; more < 20; more++) {
        m.n = end + more;
        memset(m.b + end, 0, more);
        expect_bytes("trailing zeros", m.b, m.n, FF_ERR_FORMAT, (int64_t)end,
                     WORDS("'\\x00", "expected the end of the file or a line"));
    }
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void test_counts(void)
{
    static const uint32_t wild[] = {0, 1, 3, 255, 65536, 1000000000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF};
    made m = make("MBSDF_DATA_REFLECTION=\n", 2, 3, 1);
    const int64_t at = (int64_t)m.counts;
    const double begin = seconds();
    for (size_t a = 0; a < 9; a++)
        for (size_t b = 0; b < 9; b++) {
            put_uint32(m.b + at + 4, wild[a]);
            put_uint32(m.b + at + 8, wild[b]);
            if (wild[a] == 0)
                expect_bytes("no theta", m.b, m.n, FF_ERR_FORMAT, at + 4, WORDS("number of thetas: found 0", "at least 1"));
            else if (wild[b] == 0)
                expect_bytes("no phi", m.b, m.n, FF_ERR_FORMAT, at + 8, WORDS("number of phis: found 0", "at least 1"));
            else if (wild[a] * (double)wild[a] * wild[b] > 12)
                expect_bytes("too many", m.b, m.n, FF_ERR_READ, (int64_t)m.n, WORDS("end of the file", "floats from byte"));
            else /* what is left over is no transmission part */
                expect_bytes("too few", m.b, m.n, FF_ERR_FORMAT, at + 12 + 12 * (int64_t)(wild[a] * wild[a] * wild[b]),
                             WORDS("expected the end of the file or a line"));
        }
    FF_CHECK(seconds() - begin < 5, "81 wild headers took %g s", seconds() - begin);
    put_uint32(m.b + at + 4, 2);
    put_uint32(m.b + at + 8, 3);
    put_uint32(m.b + at, 2);
    expect_bytes("kind", m.b, m.n, FF_ERR_FORMAT, at, WORDS("kind of values: found 2", "0 (scalar) or 1 (RGB)"));
}

static void numbers(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (int rgb = 0; rgb < 2; rgb++) {
        made m = make("MBSDF_DATA_REFLECTION=\n", 2, 3, rgb);
        const size_t first = m.counts + 12, count = (m.n - first) / 4;
        for (size_t k = 0; k < count; k++) {
            unsigned char kept[4];
            char which[48];
            memcpy(kept, m.b + first + 4 * k, 4);
            put_float(m.b + first + 4 * k, bad[k % 3]);
            snprintf(which, sizeof which, "value %zu: found", k);
            expect_bytes("not finite", m.b, m.n, FF_ERR_DATA, (int64_t)(first + 4 * k),
                         WORDS(which, k % 3 ? "inf" : "nan", "finite"));
            memcpy(m.b + first + 4 * k, kept, 4);
        }
    }
}

/* Every prefix is an error, but for the one that ends with the reflection part; every flipped bit an error or a table. */
static void damage(void)
{
    made m = make("NAME=\"x\"\nMBSDF_DATA_REFLECTION=\n", 2, 2, 1);
    const size_t reflection = m.n;
    add_text(&m, "MBSDF_DATA_TRANSMISSION=\n");
    add_block(&m, 2, 2, 0);
    const char *path = ff_test_path("damaged.mbsdf");
    for (size_t n = 0; n < m.n; n++) {
        ff_table t;
        ff_error err = {0};
        ff_test_write(path, m.b, n);
        const ff_status status = ff_table_read_into(path, "mbsdf", &t, &err);
        FF_CHECK(n == reflection ? status == FF_OK : status == FF_ERR_READ && err.byte == (int64_t)n, "%zu bytes: %d at %lld %s", n,
                 status, (long long)err.byte, err.message);
        if (status == FF_OK) ff_table_clear(&t);
    }
    for (size_t bit = 0; bit < 8 * m.n; bit++) {
        ff_table t;
        ff_error err = {0};
        m.b[bit / 8] ^= (unsigned char)(1 << bit % 8);
        ff_test_write(path, m.b, m.n);
        const ff_status status = ff_table_read_into(path, "mbsdf", &t, &err);
        m.b[bit / 8] ^= (unsigned char)(1 << bit % 8);
        if (status == FF_OK) {
            FF_CHECK(t.n == 8 && t.n_channels == 3, "bit %zu: %zu x %zu", bit, t.n, t.n_channels);
            ff_table_clear(&t);
        } else {
            FF_CHECK(err.message[0] && strcmp(err.path, path) == 0, "bit %zu: %d", bit, status);
        }
    }
}

static void recognition(void)
{
    const made m = make("MBSDF_DATA_REFLECTION=\n", 2, 2, 0);
    const char *path = ff_test_path("thing.binary");
    const ff_format *f = NULL;
    ff_error err = {0};
    ff_test_write(path, m.b, m.n);
    FF_CHECK(ff_format_detect(path, &f, &err) == FF_OK && strcmp(f->name, "mbsdf") == 0, "%s", err.message);
    ff_test_write(path, "NVIDIA ARC MBSDF V2\n", 20);
    check_fails("another version", path, NULL, FF_ERR_FORMAT, 0, WORDS("V2", "expected the line NVIDIA ARC MBSDF V1"));
    ff_test_write(path, "NVIDIA ARC", 10);
    FF_CHECK(ff_format_detect(path, &f, &err) != FF_OK, "a beginning is taken for %s", f->name);
    ff_table t;
    if (!read_bytes(m.b, m.n, &t)) return;
    FF_CHECK(ff_table_write(ff_test_path("x.mbsdf"), "mbsdf", &t, &err) == FF_ERR_UNSUPPORTED &&
                 strstr(err.message, "only be read"),
             "%s", err.message);
    ff_table_clear(&t);
}

static void pipes(void)
{
    const made m = make("MBSDF_DATA_REFLECTION=\n", 4, 5, 1);
    char path[160], fifo[160], command[700];
    snprintf(path, sizeof path, "%s", ff_test_path("piped.mbsdf"));
    snprintf(fifo, sizeof fifo, "%s", ff_test_path("fifo"));
    ff_test_write(path, m.b, m.n);
    for (int cut = 0; cut < 2; cut++) {
        snprintf(command, sizeof command, "rm -f '%s'; mkfifo '%s'; head -c %zu '%s' > '%s' &", fifo, fifo, m.n - (size_t)cut, path,
                 fifo);
        if (system(command) != 0) exit(1);
        ff_table t;
        ff_error err = {0};
        const ff_status status = ff_table_read_into(fifo, "mbsdf", &t, &err);
        FF_CHECK(status == (cut ? FF_ERR_READ : FF_OK), "%d %s", status, err.message);
        if (status != FF_OK) continue;
        check_table(&t, 4, 5, 1);
        ff_table_clear(&t);
    }
}

/* ---- the files of the MDL SDK ---------------------------------------------------------------- */

static float float_in_file(const char *bytes, size_t ti, size_t to, size_t p, size_t c)
{
    float v;
    memcpy(&v, bytes + 55 + 4 * (3 * (ti * 90 * 45 + to * 90 + p) + c), 4); /* on a little-endian machine */
    return v;
}

static void test_real_file(const char *path, size_t negative, double largest)
{
    ff_table t;
    ff_error err = {0};
    size_t size, found = 0, measured = 0, invalid = 0;
    char *bytes = ff_test_slurp(path, &size);
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s", err.message)) exit(1);
    FF_CHECK(strcmp(t.format, "mbsdf") == 0 && t.n == 182250 && t.n_channels == 3 && t.isotropic && size == 2187055, "%zu x %zu",
             t.n, t.n_channels);
    double most = 0, brightest = 0;
    for (size_t i = 0; i < 182250; i++) {
        int any = 0;
        for (size_t c = 0; c < 3; c++) {
            const double v = (double)float_in_file(bytes, 0, 0, i, c);
            any |= v < 0;
            most = fmax(most, v);
            FF_CHECK(t.value[c * t.n + i] == v, "sample %zu: %g, in the file %g", i, t.value[c * t.n + i], v);
        }
        found += any != 0;
        const int repeated = i / 4050 > 33 || i / 90 % 45 > 40; /* beyond 66 and 80 degrees */
        FF_CHECK(t.valid[i] == !repeated, "sample %zu: valid %d", i, t.valid[i]);
        measured += any && !repeated;
        invalid += repeated != 0;
    }
    FF_CHECK(found == negative, "%zu negative in the file, expected %zu", found, negative);
    FF_CHECK(t.n_negative == measured && t.n_invalid == invalid, "%zu negative, %zu invalid, expected %zu, %zu", t.n_negative,
             t.n_invalid, measured, invalid);
    FF_CHECK(fabs(most - largest) < 1e-5, "largest %.9g, expected %.9g", most, largest);
    FF_CHECK(t.value[1 * t.n + (20 * 45 + 21) * 90 + 89] == (double)float_in_file(bytes, 20, 21, 89, 1),
             "a value at the mirror direction");
    FF_CHECK(t.angle[0][(20 * 45 + 21) * 90 + 89] == 40 && t.angle[2][(20 * 45 + 21) * 90 + 89] == 42 &&
                 t.angle[3][(20 * 45 + 21) * 90 + 89] == 180 && t.angle[1][7] == 0,
             "its direction");
    FF_CHECK(strstr(t.note, "beyond theta_i = 66 degrees") && strstr(t.note, "beyond theta_o = 80 degrees"), "note '%s'", t.note);
    for (size_t ti = 0; ti < 45; ti++) { /* reflects less than it receives, and more than nothing */
        double albedo = 0, cells = 0, o;
        for (size_t i = ti * 4050; i < (ti + 1) * 4050; i++) {
            o = cos(t.angle[2][i] * pi / 180);
            albedo += t.weight[i] * o * t.value[2 * t.n + i], cells += t.weight[i];
        }
        albedo *= 2 * pi * (1 - cos(89 * pi / 180)) / cells;
        FF_CHECK(albedo > 0 && albedo < 1, "%s: albedo %g at %zu degrees", path, albedo, 2 * ti);
        brightest = fmax(brightest, albedo);
    }
    printf("%s: %zu of %zu negative, albedo of blue up to %.3f\n", path, t.n_negative, t.n, brightest);
    ff_table_clear(&t);
    free(bytes);
}

static void measured(void)
{
    static const struct {
        const char *name;
        size_t negative;
        double largest;
    } files[] = {{"carpaint_blue", 74397, 8.891786575317383}, {"carpaint_red", 64374, 34.35967254638672}};
    const char *set = getenv("FACETFIT_DATA");
    for (size_t k = 0; k < 2; k++) {
        char path[900];
        snprintf(path, sizeof path, "%s/mbsdf/%s.mbsdf", set ? set : FF_SOURCE_DIR "/../shared/data", files[k].name);
        if (access(path, R_OK) != 0) FF_SKIP("no file %s", path);
        test_real_file(path, files[k].negative, files[k].largest);
    }
}

FF_TEST_MAIN(FF_TEST(test_reading), FF_TEST(repetition), FF_TEST(test_part), FF_TEST(test_text), FF_TEST(test_counts),
             FF_TEST(numbers), FF_TEST(damage), FF_TEST(recognition), FF_TEST(pipes), FF_TEST(measured))
