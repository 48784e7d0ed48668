/* NIST CSV, made here, and the published random-direction data where they are. */
#include "check_text.h"

#define OLD "lambda,thetai,phii,thetar,phir,fr11,m12,m44\n"
#define NEW "lambda,thetai,phi,thetar,phir,f_r11,f_r12/f_r11,f_r44/f_r11\n"

static void test_made(void)
{
    static const char *const heads[] = {OLD, NEW};
    ff_table t;
    for (int k = 0; k < 2; k++) {
        char text[600];
        snprintf(text, sizeof text,
                 "%s0.532,-30,10,45,170,0.3,0.1,x\r\n0.532,30,10,45,170,0.31,-0.1,\r\n0.633,-30,10,45,170,0.4,1,1\r\n0.633,30,10,"
                 "45,170,0.41,1,1\r\n",
                 heads[k]);
        if (!check_reads_part("regular", "nist", text, NULL, &t)) continue;
        double v, p[6], *const planes[6] = {p, p + 1, p + 2, p + 3, p + 4, p + 5};
        FF_CHECK(t.n == 2 && t.n_channels == 2 && t.channels[0].wavelength_nm == 532 && strcmp(t.channels[1].name, "633nm") == 0 &&
                     !t.sigma,
                 "%zu x %zu", t.n, t.n_channels);
        ff_table_values(&t, 1, 1, 1, &v);
        FF_CHECK(v == 0.41 && t.value[0] == 0.3 && t.angle[0][0] == -30 && t.angle[3][0] == 170 && t.quantity == FF_BRDF, "values");
        ff_table_directions(&t, 1, 1, planes);
        FF_CHECK(p[0] > 0 && p[2] > 0 && p[3] < 0 && p[5] > 0, "light and detector on opposite sides: %g %g", p[0], p[3]);
        ff_table_clear(&t);
    }
    if (check_reads_part("random", "nist", NEW ".633,1,2,3,4,5,6,7\n.532,2,2,3,4,6,6,7\n.532,3,2,3,4,7,6,7\n", NULL, &t)) {
        FF_CHECK(t.n == 2 && t.n_channels == 1 && t.channels[0].wavelength_nm == 532 && strstr(t.note, "'part'"), "%s", t.note);
        ff_table_clear(&t);
    }
    if (check_reads_part("random, chosen", "nist", NEW ".633,1,2,3,4,5,6,7\n.532,2,2,3,4,6,6,7\n.532,3,2,3,4,7,6,7\n", "633nm",
                         &t)) {
        FF_CHECK(t.n == 1 && t.value[0] == 5, "%zu", t.n);
        ff_table_clear(&t);
    }
    const char *path = ff_test_path("bad.csv");
    ff_test_write(path, NEW ".633,1,2,3,4,inf,6,7\n", strlen(NEW) + 21);
    check_fails("inf", path, "nist", FF_ERR_DATA, 2, WORDS("column 6", "'inf'"));
    ff_test_write(path, NEW, strlen(NEW));
    check_fails("no rows", path, NULL, FF_ERR_DATA, 1, WORDS("no rows"));
    ff_test_write(path, "lambda,thetai,phii,thetar,phir\n1,2,3,4,5\n", 41);
    check_fails("no values", path, "nist", FF_ERR_FORMAT, 1, WORDS("f_r11|fr11", "lambda, thetai, phii"));
    ff_error err = {0};
    if (check_reads_part("not written", "nist", NEW ".633,1,2,3,4,5,6,7\n", NULL, &t)) {
        FF_CHECK(ff_table_write(ff_test_path("x"), "nist", &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "only be read"),
                 "%s", err.message);
        ff_table_clear(&t);
    }
}

static void prefixes(void)
{
    static const char text[] = NEW "0.532,-30,10,45,170,0.3,0.1,1\n0.532,30,10,45,170,0.31,-0.1,2\n";
    const char *path = ff_test_path("prefix");
    for (size_t n = 0; n < sizeof text; n++)
        for (int bit = -1; bit < (n < 60 ? 8 : 0); bit++) {
            char copy[sizeof text];
            memcpy(copy, text, sizeof text);
            size_t length = bit < 0 ? n : sizeof text - 1;
            if (bit >= 0) copy[n] ^= (char)(1 << bit);
            ff_test_write(path, copy, length);
            ff_table t;
            ff_error err = {0};
            if (ff_table_read_into(path, "nist", &t, &err) == FF_OK) {
                FF_CHECK(bit >= 0 || n == 0 || text[n - 1] == '\n' || strstr(t.note, "cut"), "prefix %zu: note '%s'", n, t.note);
                FF_CHECK(t.n >= 1 && t.n <= 2, "%zu samples", t.n);
                ff_table_clear(&t);
            } else {
                FF_CHECK(err.message[0] && err.path[0], "prefix %zu bit %d: no message", n, bit);
            }
        }
}

static int test_real(void)
{
    const char *set = getenv("FACETFIT_DATA");
    char path[900], line[4096];
    snprintf(path, sizeof path, "%s/nist/PTFE.data.random.csv", set ? set : FF_SOURCE_DIR "/../shared/data");
    FILE *f = fopen(path, "r");
    if (!f) return 0;
    size_t n = 0;
    double sum[6] = {0};
    while (fgets(line, sizeof line, f)) {
        double v[6];
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf", v, v + 1, v + 2, v + 3, v + 4, v + 5) != 6) continue;
        for (int k = 0; k < 6; k++) sum[k] += v[k];
        n++;
    }
    fclose(f);
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%ld: %s", err.line, err.message)) return 1;
    double mine[6] = {0}, forward = 0, backward = 0;
    size_t n_forward = 0, n_backward = 0;
    for (size_t i = 0; i < t.n; i++) {
        for (int k = 0; k < 4; k++) mine[k + 1] += t.angle[k][i];
        mine[5] += t.value[i];
        double d = fabs(remainder(t.angle[3][i] - t.angle[1][i], 360));
        if (t.angle[0][i] < 50 || t.angle[2][i] < 50) continue;
        if (d > 140) forward += t.value[i], n_forward++;
        if (d < 40) backward += t.value[i], n_backward++;
    }
    FF_CHECK(strcmp(t.format, "nist") == 0 && t.n == n && n == 1760 && t.n_channels == 1 && t.channels[0].wavelength_nm == 532,
             "%s: %zu of %zu, '%s'", t.format, t.n, n, t.channels[0].name);
    for (int k = 1; k < 6; k++) FF_CHECK(mine[k] == sum[k], "sum of column %d: %.17g, expected %.17g", k, mine[k], sum[k]);
    /* the side on which it scatters more is that of the mirror direction */
    forward /= (double)n_forward, backward /= (double)n_backward;
    FF_CHECK(forward > 1.2 * backward && forward < 0.5 && backward > 0.2, "forward %g, backward %g", forward, backward);
    FF_CHECK(t.n_invalid == 0 && t.n_negative == 0 && !t.note[0], "note '%s'", t.note);
    ff_table_clear(&t);
    return 1;
}

static void byte_order_marks(void)
{
    check_byte_order_mark("nist", NEW ".633,1,2,3,4,5,6,7\n");
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no PTFE.data.random.csv in $FACETFIT_DATA/nist");
}

FF_TEST_MAIN(FF_TEST(test_made), FF_TEST(prefixes), FF_TEST(byte_order_marks), FF_TEST(measured))
