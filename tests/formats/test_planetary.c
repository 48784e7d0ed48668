/* Goniometer tables of planetary science, made here, and a published one where it is. */
#include "check_text.h"

static const double pi = 3.14159265358979323846;
#define HEAD                                                                                                                       \
    "# 'counter', 'incidence', 'emission', 'azimuth', 'phase', 'reflectance_factor', 'standard_deviation', 'error_estimate', "     \
    "'quality_flag', 'bandpass_central', 'bandpass_FWHM'\n"

static void test_made(void)
{
    static const char text[] = HEAD "000000, 30.00, 40.00, 0.00, 10.00, 0.80, 0.5, 1.9, 5, 450.00, 70.00\n"
                                    "000001, 30.00, 40.00, 180.00, 70.00, 0.90, 0.0, 1.9, 5, 450.00, 70.00\n"
                                    "000002, 30.00, 40.00, 0.00, 10.00, 0.60, 0.25, 1.9, 5, 1064.00, 70.00\n"
                                    "000003, 30.00, 40.00, 180.00, 70.00, 0.50, 0.1, 1.9, 5, 1064.00, 70.00\n";
    ff_table t;
    if (!check_reads_part("made", "planetary", text, NULL, &t)) return;
    double v, s, p[6], *const planes[6] = {p, p + 1, p + 2, p + 3, p + 4, p + 5};
    FF_CHECK(t.n == 2 && t.n_channels == 2 && t.channels[1].wavelength_nm == 1064 && t.isotropic == 1 &&
                 t.quantity == FF_REFLECTANCE_FACTOR,
             "%zu x %zu", t.n, t.n_channels);
    ff_table_values(&t, 0, 0, 1, &v);
    ff_table_sigmas(&t, 0, 0, 1, &s);
    FF_CHECK(fabs(v - 0.8 / pi) < 1e-16 && fabs(s - 0.004 / pi) < 1e-17, "%g %g", v, s);
    ff_table_sigmas(&t, 0, 1, 1, &s); /* was 0: that of the other sample of the band */
    FF_CHECK(fabs(s - 0.004 / pi) < 1e-17 && strstr(t.note, "1 standard deviations are 0"), "%g, note '%s'", s, t.note);
    ff_table_sigmas(&t, 1, 1, 1, &s);
    FF_CHECK(fabs(s - 0.0005 / pi) < 1e-18 && strstr(t.note, "percent"), "%g", s);
    ff_table_directions(&t, 1, 1, planes);
    FF_CHECK(p[0] > 0 && p[3] < 0, "azimuth 180 is the side of the mirror: %g %g", p[0], p[3]);
    ff_table_clear(&t);
    if (check_reads_part("part", "planetary", text, "1064nm", &t)) {
        FF_CHECK(t.n == 2 && t.n_channels == 1 && t.value[0] == 0.6, "one band");
        ff_table_clear(&t);
    }
    if (check_reads_part("the other convention", "planetary",
                         HEAD "0, 30, 40, 0, 70, 0.8, 0.5, 1, 5, 450, 70\n1, 30, 40, 180, 10, 0.9, 0.5, 1, 5, 450, 70\n", NULL,
                         &t)) {
        FF_CHECK(t.angle[3][0] == 180 && strstr(t.note, "180 degrees are added"), "note '%s'", t.note);
        ff_table_clear(&t);
    }
    if (check_reads_part("no deviations", "planetary", HEAD "0, 30, 40, 0, 10, 0.8, 0, 1, 5, 450, 70\n", NULL, &t)) {
        FF_CHECK(!t.sigma && strstr(t.note, "none are used"), "note '%s'", t.note);
        ff_table_clear(&t);
    }
    const char *path = ff_test_path("bad.csv");
    static const char bad[] = HEAD "0, 30, 40, 0, 10, 0.8, -0.5, 1, 5, 450, 70\n";
    ff_test_write(path, bad, sizeof bad - 1);
    check_fails("negative deviation", path, NULL, FF_ERR_DATA, 2, WORDS("sigma: found -0.5", "> 0"));
    static const char less[] =
        "# 'incidence', 'emission', 'azimuth', 'reflectance_factor', 'standard_deviation', 'bandpass_central'\n1,1,1,1,1,1\n";
    ff_test_write(path, less, sizeof less - 1);
    check_fails("no phase", path, "planetary", FF_ERR_FORMAT, 1, WORDS("'phase'", "incidence, emission"));
}

static void prefixes(void)
{
    static const char text[] =
        HEAD "0, 30.00, 40.00, 0.00, 10.00, 0.80, 0.5, 1.9, 5, 450.00, 70.00\n1, 30, 40, 180, 70, .9, 0, 1, 5, 450, 70\n";
    const char *path = ff_test_path("prefix");
    for (size_t n = 0; n < sizeof text; n++)
        for (int bit = -1; bit < 8; bit++) {
            char copy[sizeof text];
            memcpy(copy, text, sizeof text);
            if (bit >= 0) copy[n] ^= (char)(1 << bit);
            ff_test_write(path, copy, bit < 0 ? n : sizeof text - 1);
            ff_table t;
            ff_error err = {0};
            if (ff_table_read_into(path, "planetary", &t, &err) == FF_OK) {
                FF_CHECK(bit >= 0 || n == 0 || text[n - 1] == '\n' || strstr(t.note, "cut"), "prefix %zu: note '%s'", n, t.note);
                for (size_t i = 0; i < t.n; i++)
                    FF_CHECK(isfinite(t.value[i]) && isfinite(t.angle[3][i]), "prefix %zu: not finite", n);
                ff_table_clear(&t);
            } else {
                FF_CHECK(err.message[0] && err.path[0], "prefix %zu bit %d: no message", n, bit);
            }
        }
}

static int test_real(void)
{
    enum { MOST = 8000, COLUMNS = 12 };
    static double row[MOST][COLUMNS];
    const char *set = getenv("FACETFIT_DATA");
    char path[900], line[4096];
    snprintf(path, sizeof path, "%s/planetary/20200313_mastcamz_spectralon.csv", set ? set : FF_SOURCE_DIR "/../shared/data");
    FILE *f = fopen(path, "r");
    if (!f) return 0;
    size_t n = 0, matched = 0, zeros = 0;
    while (fgets(line, sizeof line, f) && n < MOST) {
        double *v = row[n];
        n += sscanf(line, "%lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf, %lf", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6,
                    v + 7, v + 8, v + 9, v + 10, v + 11) == 12;
    }
    fclose(f);
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%ld: %s", err.line, err.message)) return 1;
    FF_CHECK(strcmp(t.format, "planetary") == 0 && n == 7824 && t.n == n / 6 && t.n_channels == 6 && t.isotropic == 1,
             "%s: %zu rows, %zu x %zu", t.format, n, t.n, t.n_channels);
    static const double nm[6] = {450, 550, 650, 750, 905, 1064};
    for (size_t c = 0; c < t.n_channels; c++) FF_CHECK(t.channels[c].wavelength_nm == nm[c], "band %zu", c);
    for (size_t k = 0; k < n && t.n_channels == 6; k += 1 + k % 7) {
        for (size_t i = 0; i < t.n; i++) {
            if (t.angle[0][i] != row[k][1] || t.angle[2][i] != row[k][2] || t.angle[3][i] != row[k][3]) continue;
            for (size_t c = 0; c < 6; c++) {
                double v, s;
                if (nm[c] != row[k][11]) continue;
                ff_table_values(&t, c, i, 1, &v);
                ff_table_sigmas(&t, c, i, 1, &s);
                matched++;
                FF_CHECK(fabs(pi * v - row[k][5]) < 1e-15, "row %zu: %g", k, v);
                if (row[k][6] > 0)
                    FF_CHECK(fabs(pi * s - row[k][5] * row[k][6] / 100) < 1e-15, "row %zu: sigma %g", k, s);
                else
                    FF_CHECK(s > 0 && s < 1e-3, "row %zu: sigma %g", k, s);
            }
        }
    }
    for (size_t k = 0; k < n; k++) zeros += row[k][6] == 0;
    char expected[64];
    snprintf(expected, sizeof expected, "%zu standard deviations are 0", zeros);
    FF_CHECK(matched > 1500 && strstr(t.note, expected), "%zu rows compared; '%s' in '%s'", matched, expected, t.note);
    /* the angle between the directions is that of the file */
    for (size_t i = 0; i < t.n; i++) {
        double p[6], *const planes[6] = {p, p + 1, p + 2, p + 3, p + 4, p + 5};
        ff_table_directions(&t, i, 1, planes);
        double phase = acos(fmax(-1, fmin(1, p[0] * p[3] + p[1] * p[4] + p[2] * p[5]))) * 180 / pi;
        size_t k = 0;
        while (k < n && (row[k][1] != t.angle[0][i] || row[k][2] != t.angle[2][i] || row[k][3] != t.angle[3][i])) k++;
        FF_CHECK(k < n && fabs(phase - row[k][4]) < 0.006, "sample %zu: phase %g", i, phase);
    }
    ff_table_clear(&t);
    return 1;
}

static void byte_order_marks(void)
{
    check_byte_order_mark("planetary", HEAD "0, 30, 40, 0, 10, 0.8, 0, 1, 5, 450, 70\n");
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no 20200313_mastcamz_spectralon.csv in $FACETFIT_DATA/planetary");
}

FF_TEST_MAIN(FF_TEST(test_made), FF_TEST(prefixes), FF_TEST(byte_order_marks), FF_TEST(measured))
