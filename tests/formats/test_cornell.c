/* Cornell's samples in free form, made here; real ones where they are. */
#include "check_text.h"

#define WAVES "# num wls\n3\n# wls\n400 550.5\n700 # the last\n"
#define ROWS  "0.5 0 0.25 -3.1415927 1 2 3\n0.5 0.1\n1.5 0.2 4\n5 -6\n"

static void reading(void)
{
    static const char *const texts[] = {
        WAVES ROWS, "3 400 550.5 700 0.5 0 0.25 -3.1415927 1 2 3 0.5 0.1 1.5 0.2 4 5 -6\n",
        "\xEF\xBB\xBF#\r\n3,400,550.5,700\r\n\r\n0.5,0,0.25,-3.1415927,1,2,3\r\n.5 .1 1.5 .2 4 5 -6\r\n"};
    for (size_t k = 0; k < sizeof texts / sizeof texts[0]; k++) {
        ff_table t;
        if (!check_reads(texts[k], "cornell", texts[k], &t)) continue;
        static const double angle[2][4] = {{0.5, 0, 0.25, -3.1415927}, {0.5, 0.1, 1.5, 0.2}};
        FF_CHECK(t.n == 2 && t.n_channels == 3 && t.isotropic == 1 && t.radians_per_unit == 1, "%zu x %zu", t.n, t.n_channels);
        for (size_t i = 0; i < 2; i++)
            for (int j = 0; j < 4; j++) FF_CHECK(t.angle[j][i] == angle[i][j], "angle %d of %zu: %g", j, i, t.angle[j][i]);
        for (size_t c = 0; c < 3; c++)
            FF_CHECK(t.value[2 * c] == (double)c + 1 && fabs(t.value[2 * c + 1]) == (double)c + 4, "channel %zu", c);
        FF_CHECK(t.value[5] == -6 && t.n_negative == 1 && t.n_invalid == 0 && t.note[0] == '\0', "%zu negative, '%s'", t.n_negative,
                 t.note);
        FF_CHECK(strcmp(t.channels[1].name, "550.5nm") == 0 && t.channels[1].wavelength_nm == 550.5 && t.channels[1].scale == 1,
                 "channel '%s'", t.channels[1].name);
        ff_table_clear(&t);
    }
}

static void refusals(void)
{
    check_refuses("cornell", "", FF_ERR_READ, 0, WORDS("end of the file", "number of wavelengths"));
    check_refuses("cornell", "# only\n", FF_ERR_READ, 1, WORDS("end of the file", "number of wavelengths"));
    check_refuses("cornell", "many\n", FF_ERR_FORMAT, 1, WORDS("'many'", "from 1 to 4096"));
    check_refuses("cornell", "#\n0\n", FF_ERR_FORMAT, 2, WORDS("'0'", "from 1 to 4096"));
    check_refuses("cornell", "1000000000 400\n", FF_ERR_FORMAT, 1, WORDS("'1000000000'", "from 1 to 4096"));
    check_refuses("cornell", "3 400 500\n", FF_ERR_READ, 1, WORDS("after 2 numbers", "expected 3", "wavelengths"));
    check_refuses("cornell", "2 400\nred\n", FF_ERR_DATA, 2, WORDS("'red'", "wavelengths"));
    check_refuses("cornell", "2 400\n0\n", FF_ERR_DATA, 2, WORDS("wavelength 0", "nm"));
    check_refuses("cornell", "2 400 400\n", FF_ERR_FORMAT, 1, WORDS("400 twice"));
    check_refuses("cornell", WAVES, FF_ERR_READ, 5, WORDS("no samples"));
    check_refuses("cornell", WAVES "0 0 0 0 1\n2\n", FF_ERR_READ, 7,
                  WORDS("after 6 numbers", "expected 7", "four angles and 3 values"));
    check_refuses("cornell", WAVES "0 0 0 0 1 2 nan\n", FF_ERR_DATA, 6, WORDS("'nan'", "finite number"));
    check_refuses("cornell", WAVES "0 0 0 0 1 2 1e999\n", FF_ERR_DATA, 6, WORDS("'1e999'", "finite number"));
    check_refuses("cornell", WAVES "30 0 0 0 1 2 3\n", FF_ERR_DATA, 6, WORDS("theta_i = 30", "degrees?"));
    check_refuses("cornell", WAVES "0 0 -30 0 1 2 3\n", FF_ERR_DATA, 6, WORDS("theta_s = -30", "degrees?"));
    const char *path = ff_test_path("options");
    ff_test_write(path, WAVES ROWS, strlen(WAVES ROWS));
    ff_read_options o;
    ff_read_options_init(&o);
    o.grid = "merl";
    ff_table t;
    ff_error err = {0};
    FF_CHECK(ff_table_read_with_into(path, &o, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "grid"), "%s", err.message);
}

/* The wavelengths and the values of a sample of the real files, with the C library as a second source. */
static int test_real(void)
{
    static const char *const names[] = {"cornell/acryl_blue.brdf", "cornell/cayman.brdf", "cornell/garnet_red.brdf"};
    int n_files = 0;
    for (size_t k = 0; k < 3; k++) {
        const char *path = check_data(names[k]);
        ff_table t;
        ff_error err = {0};
        if (!path) continue;
        n_files++;
        if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s:%ld: %s", path, err.line, err.message)) continue;
        FF_CHECK(strcmp(t.format, "cornell") == 0 && t.n == 1439 && t.n_channels == 31 && t.isotropic, "%s: %zu x %zu", path, t.n,
                 t.n_channels);
        FF_CHECK(t.channels[0].wavelength_nm == 400 && t.channels[30].wavelength_nm == 700, "%s: wavelengths", path);
        size_t size, brightest = 0;
        char *text = ff_test_slurp(path, &size), *p = strstr(text, "sample values");
        if (!FF_CHECK(p != NULL, "%s: no comment before the values", path)) continue;
        p += strcspn(p, "\n");
        double worst = 0;
        for (size_t i = 0; i < t.n; i++) {
            for (int j = 0; j < 4; j++) worst = fmax(worst, fabs(strtod(p, &p) - t.angle[j][i]));
            for (size_t c = 0; c < 31; c++) worst = fmax(worst, fabs(strtod(p, &p) - t.value[c * t.n + i]));
            if (t.value[15 * t.n + i] > t.value[15 * t.n + brightest]) brightest = i;
        }
        FF_CHECK(worst == 0 && p[strspn(p, " \r\n")] == '\0', "%s: off by %g", path, worst);
        double w[6]; /* the mirror direction is within 2 degrees of the largest value */
        check_directions(&t, brightest, w);
        FF_CHECK(-w[0] * w[3] - w[1] * w[4] + w[2] * w[5] > cos(0.035), "%s: the peak is not at the mirror direction", path);
        free(text);
        ff_table_clear(&t);
    }
    return n_files;
}

static void one_file_damaged(void)
{
    check_prefixes("cornell", WAVES ROWS, 2, 1);
    check_byte_order_mark("cornell", WAVES ROWS);
    check_flips("cornell", WAVES ROWS);
}

static void measured(void)
{
    if (!test_real()) FF_SKIP("no real files in %s/cornell", check_data_dir());
}

FF_TEST_MAIN(FF_TEST(reading), FF_TEST(refusals), FF_TEST(one_file_damaged), FF_TEST(measured))
