/* Real files, at $FACETFIT_DATA or ../shared/data beside the project, skipped where they are absent; and one that is made here,
 * with the same checks. */
#include "instrument.h"
#include "check_table.h"

static const char *data_dir(void)
{
    const char *set = getenv("FACETFIT_DATA");
    return set ? set : FF_SOURCE_DIR "/../shared/data";
}

/* NUM_POINTS, and the sum of a column of the rows: read here with the C library, as a second source. */
static void second_source(const char *path, long *points, double *sum_theta_i, double *sum_last)
{
    char line[1024];
    FILE *f = fopen(path, "r");
    if (!f) exit(1);
    *points = -1, *sum_theta_i = *sum_last = 0;
    while (fgets(line, sizeof line, f)) {
        double v[7];
        sscanf(line, "NUM_POINTS %ld", points);
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf,%lf,%lf", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6) == 7)
            *sum_theta_i += v[0], *sum_last += v[6];
    }
    fclose(f);
}

static void test_astm_file(const char *path, size_t expected)
{
    ff_table t, back;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s:%ld: %s", path, err.line, err.message)) return;
    long points;
    double sum_theta_i, sum_last, theta_i = 0, last = 0;
    second_source(path, &points, &sum_theta_i, &sum_last);
    FF_CHECK(strcmp(t.format, "astm") == 0 && t.n_channels == 3 && t.n == (size_t)points && t.n == expected,
             "%s: %zu x %zu as %s, NUM_POINTS %ld", path, t.n, t.n_channels, t.format, points);
    for (size_t i = 0; i < t.n; i++) theta_i += t.angle[0][i], last += t.value[2 * t.n + i];
    FF_CHECK(theta_i == sum_theta_i && last == sum_last, "%s: sums %.17g %.17g, expected %.17g %.17g", path, theta_i, last,
             sum_theta_i, sum_last);
    FF_CHECK(t.channels[0].wavelength_nm == 465 && t.channels[1].wavelength_nm == 525 && t.channels[2].wavelength_nm == 630,
             "%s: wavelengths", path);
    FF_CHECK(t.isotropic == 1 && t.n_invalid == 0 && t.n_negative > 0 && strstr(t.note, "phi_s"), "%s: %zu negative, note '%s'",
             path, t.n_negative, t.note);
    static const char *const names[] = {"real.astm", "real.csv"};
    for (int k = 0; k < 2; k++) {
        const char *copy = ff_test_path(names[k]);
        FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s: %s", path, err.message);
        if (!FF_CHECK(ff_table_read_into(copy, NULL, &back, &err) == FF_OK, "%s: %s", path, err.message)) continue;
        check_same_tables(path, &t, &back);
        check_same_angles(path, &t, &back);
        ff_table_clear(&back);
    }
    ff_table_clear(&t);
}

static int test_astm(void)
{
    char dir[600], path[900];
    snprintf(dir, sizeof dir, "%s/astm", data_dir());
    DIR *d = opendir(dir);
    if (!d) return 0;
    int n = 0;
    for (struct dirent *e; (e = readdir(d));) {
        if (!strstr(e->d_name, ".astm")) continue;
        snprintf(path, sizeof path, "%s/%s", dir, e->d_name);
        test_astm_file(path, 12964);
        n++;
    }
    closedir(d);
    FF_CHECK(n > 0, "no .astm file in %s", dir);
    printf("%d ASTM files\n", n);
    return 1;
}

/* make_merl.py marks the 305,826 cells that the database has not; its networks add a few negative cells of their own. */
static int test_merl(void)
{
    char command[1600], path[200];
    snprintf(path, sizeof path, "%s", ff_test_path("gold.binary"));
    snprintf(command, sizeof command,
             "tool='%s/../tools/make_merl.py'; test -f \"$tool\" && { \"$tool\" gold-metallic-paint '%s' || python3 \"$tool\" "
             "gold-metallic-paint '%s'; } 2>/dev/null",
             data_dir(), path, path);
    if (system(command) != 0) return 0;
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s", err.message)) return 1;
    size_t size, missing = 0, negative = 0;
    char *bytes = ff_test_slurp(path, &size);
    for (size_t i = 0; i < t.n; i++) {
        double v[3];
        for (size_t c = 0; c < 3; c++) memcpy(v + c, bytes + 12 + 8 * (c * t.n + i), 8); /* on a little-endian machine */
        missing += v[0] == -1 && v[1] == -1 && v[2] == -1;
        negative += v[0] < 0 || v[1] < 0 || v[2] < 0;
    }
    FF_CHECK(missing == 305826, "%zu cells of the database's mask, expected 305826", missing);
    FF_CHECK(t.n_invalid == negative && negative >= missing && negative < missing + 5000, "%zu invalid, expected %zu", t.n_invalid,
             negative);
    FF_CHECK(strcmp(t.format, "merl") == 0 && t.n == 1458000 && t.n_channels == 3, "%s %zu", t.format, t.n);
    double at_normal[3];
    for (size_t c = 0; c < 3; c++) ff_table_values(&t, c, 0, 1, at_normal + c);
    FF_CHECK(at_normal[0] > at_normal[1] && at_normal[1] > at_normal[2] && at_normal[2] > 0, "gold is %g %g %g", at_normal[0],
             at_normal[1], at_normal[2]);
    const char *copy = ff_test_path("copy.binary");
    FF_CHECK(ff_table_write(copy, NULL, &t, &err) == FF_OK, "%s", err.message);
    size_t n;
    char *written = ff_test_slurp(copy, &n);
    FF_CHECK(n == size && memcmp(written, bytes, n) == 0, "the copy differs");
    printf("MERL: %zu invalid, %zu of them of the database\n", negative, missing);
    free(bytes);
    free(written);
    ff_table_clear(&t);
    return 1;
}

static void made_astm_file(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha=0.08 f0=0.6:0.3:0.1 kd=0:0.01:0.05");
    const char *path = ff_test_path("made.astm");
    instrument_write(path, &s, &(instrument_faults){.noise = 0.02, .offset = 1e-2, .horizon = 84}, "made");
    test_astm_file(path, INSTRUMENT_POINTS);
}

static void astm_files(void)
{
    if (!test_astm()) FF_SKIP("no ASTM files in %s/astm", data_dir());
}

static void merl_file(void)
{
    if (!test_merl()) FF_SKIP("no MERL file, %s/../tools/make_merl.py is missing or needs python3-numpy", data_dir());
}

FF_TEST_MAIN(FF_TEST(made_astm_file), FF_TEST(astm_files), FF_TEST(merl_file))
