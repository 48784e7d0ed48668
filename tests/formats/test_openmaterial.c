/* Look-up tables of ASAM OpenMATERIAL 3D: made here, and a published one where it is. */
#include "check_text.h"

#define HEAD                                                                                                                       \
    "{\"metadata\": {\"openMaterial3dVersion\": \"1.0.0\"}, \"brdf\": {\"wavelengths\": [4.5e-07, 6.5e-7], \"lookupTable\": ["
#define FOOT "]}}\n"

static void test_made(void)
{
    ff_table t;
    double v;
    if (!check_reads("made", "openmaterial",
                     HEAD "[4.5e-07, 0.5, 0.25, 0, 0.1],\n[4.5e-07, 0.5, 0.25, 3.14159, 0.2], [4.5e-07, 0.5, 1, 1, null],"
                          "[6.5e-07, 0.5, 0.25, 0, 0.3],\n[6.5e-07, 0.5, 0.25, 3.14159, 0.4], [6.5e-07, 0.5, 1, 1, 0.5]" FOOT,
                     &t))
        return;
    FF_CHECK(t.n == 3 && t.n_channels == 2 && t.isotropic == 1 && t.n_invalid == 1, "%zu x %zu, %zu left out", t.n, t.n_channels,
             t.n_invalid);
    FF_CHECK(fabs(t.channels[0].wavelength_nm - 450) < 1e-9 && t.radians_per_unit == 1 && t.angle[2][1] == 0.25 &&
                 t.angle[3][1] == 3.14159,
             "%g", t.channels[0].wavelength_nm);
    ff_table_values(&t, 1, 1, 1, &v);
    FF_CHECK(v == 0.4 && !t.valid[2], "%g", v);
    ff_table again;
    ff_error err = {0};
    const char *path = ff_test_path("again.xompt");
    if (FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_OK && ff_table_read_into(path, NULL, &again, &err) == FF_OK, "%s",
                 err.message)) {
        FF_CHECK(again.n == 3 && again.n_invalid == 1 && again.n_channels == 2, "%zu", again.n);
        ff_table_values(&again, 1, 1, 1, &v);
        FF_CHECK(v == 0.4 && again.angle[3][1] == 3.14159, "%g", v);
        ff_table_clear(&again);
    }
    ff_table_clear(&t);
    if (check_reads("no wavelength", "openmaterial", HEAD "[null, 0.5, 0.25, 0, 0.1]" FOOT, &t)) {
        FF_CHECK(t.n == 1 && t.n_channels == 1 && !strcmp(t.channels[0].name, "f") && isnan(t.channels[0].wavelength_nm), "%s",
                 t.channels[0].name);
        ff_table_clear(&t);
    }
    if (check_reads_part("part", "openmaterial", HEAD "[4.5e-07, 0.5, 0.25, 0, 0.1], [6.5e-07, 0.5, 0.25, 0, 0.3]" FOOT, "650nm",
                         &t)) {
        FF_CHECK(t.n_channels == 1 && t.value[0] == 0.3, "%g", t.value[0]);
        ff_table_clear(&t);
    }
}

static void refused(void)
{
    check_refuses("openmaterial", HEAD FOOT, FF_ERR_FORMAT, 0, WORDS("no rows", "lookupTable"));
    check_refuses("openmaterial", "{\"brdf\": 3}", FF_ERR_FORMAT, 0, WORDS("brdf"));
    check_refuses("openmaterial", HEAD "[4.5e-07, 0.5, 0.25, 0]" FOOT, FF_ERR_FORMAT, 0,
                  WORDS("row 1", "found 4 numbers", "expected 5"));
    check_refuses("openmaterial", HEAD "[4.5e-07, 45, 0.25, 0, 1]" FOOT, FF_ERR_DATA, 0,
                  WORDS("row 1", "incident angle 45", "1.570796"));
    check_refuses("openmaterial", HEAD "[4.5e-07, 0.5, -0.25, 0, 1]" FOOT, FF_ERR_DATA, 0, WORDS("exit angle -0.25"));
    check_refuses("openmaterial", HEAD "[4.5e-07, 0.5, null, 0, 1]" FOOT, FF_ERR_DATA, 0, WORDS("angle nan"));
    check_refuses("openmaterial", HEAD "[905, 0.5, 0.5, 0, 1]" FOOT, FF_ERR_DATA, 0, WORDS("wavelength 905", "meters"));
    check_refuses("openmaterial", HEAD "[null, 0.5, 0.5, 0, 1], [4.5e-7, 0.5, 0.5, 0, 1]" FOOT, FF_ERR_DATA, 0,
                  WORDS("1 rows of 2"));
    check_refuses("openmaterial", HEAD "[4.5e-07, 0.5, 0.25, 0, 1]", FF_ERR_FORMAT, 1, WORDS("end"));
}

static void prefixes(void)
{
    static const char text[] = HEAD "[4.5e-07, 0.5, 0.25, 0, 0.1], [6.5e-07, 0.5, 0.25, 0, 0.3]" FOOT;
    const char *path = ff_test_path("prefix");
    for (size_t n = 0; n < sizeof text; n++) {
        ff_table t;
        ff_error err = {0};
        ff_test_write(path, text, n);
        if (ff_table_read_into(path, "openmaterial", &t, &err) != FF_OK) continue;
        FF_CHECK(n >= sizeof text - 2 && t.n == 1, "prefix %zu is read", n);
        ff_table_clear(&t);
    }
}

static void measured(void)
{
    char path[1024];
    ff_table t;
    ff_error err = {0};
    if (!ff_test_shared("data/openmaterial/asphalt_lidar_brdf.xompt", path, sizeof path))
        FF_SKIP("the published table is not there");
    if (!FF_CHECK(ff_table_read_into(path, NULL, &t, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(t.n == 905 && t.n_channels == 1 && fabs(t.channels[0].wavelength_nm - 905) < 1e-6 && t.value[0] == 0.0013255,
             "%zu samples, first %g", t.n, t.value[0]);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(test_made), FF_TEST(refused), FF_TEST(prefixes), FF_TEST(measured))
