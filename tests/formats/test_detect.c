/* The registry, and finding a format by content. */
#include "check_table.h"
#include <unistd.h>

/* An allocation that cannot succeed shall fail here too when the test runs under AddressSanitizer, not end the program. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "allocator_may_return_null=1";
}

static void test_registry(void)
{
    FF_CHECK(ff_format_count() >= 3, "%zu formats", ff_format_count());
    FF_CHECK(ff_format_at(ff_format_count()) == NULL && ff_format_find("nonesuch") == NULL, "what does not exist");
    for (size_t i = 0; i < ff_format_count(); i++) {
        const ff_format *f = ff_format_at(i);
        FF_CHECK(f->name && f->title && f->extensions && f->source && f->probe && f->read, "format %zu is incomplete", i);
        FF_CHECK(ff_format_find(f->name) == f, "'%s' is not found, or twice there", f->name);
        if (f->write) {
            char path[64];
            snprintf(path, sizeof path, "x.y%.*s", (int)strcspn(f->extensions, " "), f->extensions);
            FF_CHECK(ff_format_for_writing(path) == f, "%s is not written as %s", path, f->name);
        }
    }
    FF_CHECK(!ff_format_for_writing("x") && !ff_format_for_writing("-") && !ff_format_for_writing("csv"),
             "names without extension");
    FF_CHECK(ff_format_for_writing("X.CSV") == ff_format_find("csv"), "capitals");
}

static void expect(const char *label, const void *bytes, size_t n, const char *name)
{
    const char *path = ff_test_path("thing.bin"); /* a name that says nothing */
    ff_test_write(path, bytes, n);
    const ff_format *f = NULL;
    ff_error err = {0};
    ff_status status = ff_format_detect(path, &f, &err);
    if (name)
        FF_CHECK(status == FF_OK && f && strcmp(f->name, name) == 0, "%s: %d %s %s", label, status, f ? f->name : "none",
                 err.message);
    else
        FF_CHECK(status != FF_OK && !f, "%s: claimed by %s", label, f ? f->name : "");
}
#define EXPECT(label, text, name) expect(label, text, sizeof(text) - 1, name)

static void test_content(void)
{
    static const unsigned char merl[12] = {90, 0, 0, 0, 90, 0, 0, 0, 180, 0, 0, 0},
                               big_endian[12] = {0, 0, 0, 90, 0, 0, 0, 90, 0, 0, 0, 180};
    expect("merl header", merl, sizeof merl, "merl");
    expect("merl of the other byte order", big_endian, sizeof big_endian, "merl");
    EXPECT("csv", "theta_i,phi_i,theta_o,phi_o,f\n0,0,0,0,1\n", "csv");
    EXPECT("csv with comments", "\n# hello\n# quantity: brdf\nf,theta_i,phi_i,theta_o,phi_o\n", "csv");
    EXPECT("csv with a mark", "\xEF\xBB\xBFtheta_i,phi_i,theta_o,phi_o,f\r\n", "csv");
    EXPECT("csv with semicolons", "theta_i;phi_i;theta_o;phi_o;f\n", "csv");
    EXPECT("somebody's table", "incidence,emission,value\n1,2,3\n", "csv");
    EXPECT("somebody's table with semicolons", "incidence;emission;value\n1;2;3\n", "csv");
    EXPECT("nist", "lambda,thetai,phii,thetar,phir,fr11,m12\n0.532,1,2,3,4,5,6\n", "nist");
    EXPECT("planetary",
           "# 'counter', 'incidence', 'emission', 'azimuth', 'phase', 'reflectance_factor', 'standard_deviation', "
           "'bandpass_central'\n",
           "planetary");
    EXPECT("astm", "LAB_NAME x\nNUM_POINTS 1\nVARS theta_i,phi_i,theta_s,465nm\n0,0,0,1\n", "astm");
    EXPECT("astm without its keys", "VARS theta_i,phi_i,theta_s,465nm\n0,0,0,1\n", "astm");
    EXPECT("astm with crlf", "NUM_POINTS 1\r\nVARS theta_i,theta_s,b\r\n", "astm");
    EXPECT("alta", "#SAMPLE x\n#PARAM_IN COS_TH\n#DIM 1 1\n1 1\n", "alta");
    EXPECT("alta, binary", "#DIM 4 1\n#PARAM_IN  CARTESIAN\n#FORMAT binary\n#BEGIN_STREAM\n\0\0\0\0", "alta");
    EXPECT("cornell", "# two\n2\n465 630\n0.1 0 0.2 3.14 5 6\n", "cornell");
    EXPECT("cornell without wavelengths", "2\n0.1 0.2 0.3 0.4 5 6\n", "csv");
    EXPECT("fred", "\n TYPE\tbsdf_data\r\nformat angles=deg bsdf=value scale=1\r\n", "fred");
    EXPECT("pgii", "#sample_name x\n#intheta 10\n#inphi 0\n#format: theta phi DSF\n1 2 3\n", "pgii");
    EXPECT("somebody's comments", "#intheta 10\n1 2 3\n", "csv");
    EXPECT("JSON", "{\"a\": [1, 2, 3],\n \"b\": [4, 5, 6]}\n", NULL);
    EXPECT("columns of blanks", "10 0 20 180 0.5\n10 0 30 180 0.4\n", "csv");
    EXPECT("rgl", "tensor_file\0\1\0\2\0\0\0\7\0theta_i\4\0vndf", "rgl");
    EXPECT("another tensor file", "tensor_file\0\1\0\1\0\0\0\5\0theta", "rgl");
    EXPECT("nothing", "", NULL);
    EXPECT("prose", "To be or not to be", NULL);
    EXPECT("binary with a csv header in it", "theta_i,phi_i,theta_o,phi_o,f\n\0\1\2", NULL);
    EXPECT("png", "\x89PNG\r\n\x1a\n\0\0\0\rIHDR", NULL);
}

static void messages(void)
{
    const char *path = ff_test_path("unknown");
    check_fails("missing file", path, NULL, FF_ERR_OPEN, 0, WORDS("No such file"));
    check_fails("missing file, named format", path, "csv", FF_ERR_OPEN, 0, WORDS("No such file"));
    check_fails("directory", ff_test_dir, NULL, FF_ERR_OPEN, 0, WORDS("directory", "expected a file"));
    check_fails("directory as merl", ff_test_dir, "merl", FF_ERR_OPEN, 0, WORDS("directory"));
    check_fails("device", "/dev/zero", NULL, FF_ERR_FORMAT, 0, WORDS("device", "expected a file"));
    ff_test_write(path, "", 0);
    check_fails("empty", path, NULL, FF_ERR_READ, 0, WORDS("byte 0", "empty"));
    ff_test_write(path, "\xEF\xBB\xBF", 3);
    check_fails("only a byte-order mark", path, NULL, FF_ERR_FORMAT, 0, WORDS("ef bb bf", "merl, "));
    ff_test_write(path, "\x89PNG\r\n\x1a\n", 8);
    check_fails("png", path, NULL, FF_ERR_FORMAT, 0, WORDS("89 50 4e 47", "PNG", "merl, ", "astm, ", "csv"));
    check_fails("unknown name", path, "nonesuch", FF_ERR_UNKNOWN, 0, WORDS("'nonesuch'", "merl, ", "astm, ", "csv"));
    if (geteuid() != 0) {
        chmod(path, 0);
        check_fails("unreadable", path, NULL, FF_ERR_OPEN, 0, WORDS("ermission"));
    }
}

/* What the person says of the numbers is heard for every format, also for those that leave no choice: instruments write a cosine
 * into them. One whose own numbers are something else refuses. */
static void quantities(void)
{
    static const char fred[] = "type bsdf_data\nformat angles=deg bsdf=value scale=2\n10 0\n0 0 0.25\n60 20 0.5\n90 0 1\n";
    static const double factor[] = {1, 2, 1 / 3.14159265358979323846}; /* by ff_quantity, at 60 degrees */
    const char *path = ff_test_path("quantity");
    ff_test_write(path, fred, sizeof fred - 1);
    for (int q = FF_BRDF; q <= FF_REFLECTANCE_FACTOR; q++) {
        ff_table t;
        ff_error err = {0};
        ff_read_options o;
        ff_read_options_init(&o);
        o.quantity = q;
        if (!FF_CHECK(ff_table_read_with_into(path, &o, &t, &err) == FF_OK, "%s: %s", ff_quantity_name(q), err.message)) continue;
        double v;
        ff_table_values(&t, 0, 1, 1, &v);
        FF_CHECK(fabs(v - factor[q]) < 1e-14, "%s: %.17g of 1 at 60 degrees", ff_quantity_name(q), v);
        FF_CHECK(t.quantity == (ff_quantity)q && t.valid[2] == (q != FF_BRDF_COS) && t.n_invalid == (q == FF_BRDF_COS),
                 "%s: at 90 degrees nothing is left of a cosine", ff_quantity_name(q));
        ff_table_clear(&t);
    }
}

static void test_table(void)
{
    ff_table t = {.n = 7};
    ff_error err = {0};
    FF_CHECK(ff_table_init(0, 1, NULL, 0, 0, &t, &err) == FF_ERR_RANGE && t.n == 7, "no samples");
    FF_CHECK(ff_table_init(1, 0, NULL, 0, 0, &t, &err) == FF_ERR_RANGE && t.n == 7, "no channels");
    FF_CHECK(ff_table_init(5, 1, &ff_grid_merl, 0, 0, &t, &err) == FF_ERR_RANGE && t.n == 7, "not the grid's size");
    FF_CHECK(ff_table_init(SIZE_MAX / 8, 16, NULL, 0, 0, &t, &err) == FF_ERR_MEMORY && t.n == 7, "sizes that overflow");
    FF_CHECK(ff_table_init(SIZE_MAX / 64, 2, NULL, 0, 0, &t, &err) == FF_ERR_MEMORY && t.n == 7, "no such memory");
    if (!FF_CHECK(ff_table_init(3, 2, NULL, 1, 1, &t, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(t.value[5] == 0 && t.sigma[5] == 0 && t.weight[2] == 0 && t.angle[3][2] == 0 && t.valid[2] == 1, "initial values");
    FF_CHECK(t.channels[1].scale == 1 && isnan(t.channels[1].wavelength_nm) && strcmp(t.channels[1].name, "c1") == 0, "channels");
    FF_CHECK(ff_table_channel_find(&t, "c1") == 1 && ff_table_channel_find(&t, "c2") == -1, "finding channels");
    t.radians_per_unit = acos(-1) / 180;
    t.angle[0][1] = 30, t.angle[1][1] = 90, t.angle[2][1] = 120, t.angle[3][1] = 180;
    t.channels[1].scale = 2, t.value[4] = 3, t.sigma[4] = 0.5, t.weight[1] = 7;
    double p[6], v, s, w, *const planes[6] = {p, p + 1, p + 2, p + 3, p + 4, p + 5};
    ff_table_directions(&t, 1, 1, planes);
    static const double expected[6] = {0, 0.5, 0.86602540378443865, -0.86602540378443865, 0, -0.5};
    for (int k = 0; k < 6; k++) FF_CHECK(fabs(p[k] - expected[k]) < 1e-15, "plane %d: %g", k, p[k]);
    ff_table_values(&t, 1, 1, 1, &v);
    ff_table_sigmas(&t, 1, 1, 1, &s);
    ff_table_weights(&t, 1, 1, &w);
    FF_CHECK(v == 6 && s == 1 && w == 7 && ff_table_has_weights(&t), "%g %g %g", v, s, w);
    ff_table_clear(&t);
    ff_table_clear(&t);
    ff_table_clear(NULL);
    FF_CHECK(t.value == NULL && t.n == 0, "freed");
}

static void writing_by_name(void)
{
    ff_table t;
    ff_error err = {0};
    if (!FF_CHECK(ff_table_init(1, 1, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message)) return;
    ff_status status = ff_table_write(ff_test_path("x.dat"), NULL, &t, &err);
    FF_CHECK(status == FF_ERR_UNKNOWN && strstr(err.message, "merl, astm, "), "%d %s", status, err.message);
    status = ff_table_write(ff_test_path("x.csv"), "nonesuch", &t, &err);
    FF_CHECK(status == FF_ERR_UNKNOWN && strstr(err.message, "nonesuch"), "%d %s", status, err.message);
    FF_CHECK(ff_table_write(ff_test_path("x.csv"), NULL, &t, &err) == FF_OK, "%s", err.message);
    status = ff_table_write("/dev/full", "csv", &t, &err);
    FF_CHECK(status == FF_ERR_WRITE && strcmp(err.path, "/dev/full") == 0, "%d %s", status, err.message);
    status = ff_table_write(ff_test_path("none/x.csv"), NULL, &t, &err);
    FF_CHECK(status == FF_ERR_WRITE, "%d %s", status, err.message);
    static const double wrong[] = {NAN, INFINITY};
    for (size_t f = 0; f < ff_format_count(); f++) {
        const ff_format *format = ff_format_at(f);
        if (!format->write || format == ff_format_find("merl")) continue;
        const char *path = ff_test_path("never");
        for (int k = 0; k < 2; k++) {
            t.value[0] = wrong[k];
            status = format->write(path, &t, NULL, &err);
            FF_CHECK(status == FF_ERR_DATA && strstr(err.message, "c0") && strstr(err.message, "finite") && access(path, F_OK) != 0,
                     "%s: %d %s", format->name, status, err.message);
        }
        t.value[0] = 1;
        t.angle[2][0] = NAN;
        status = format->write(path, &t, NULL, &err);
        FF_CHECK(status == FF_ERR_DATA && strstr(err.message, "theta_o") && access(path, F_OK) != 0, "%s: %d %s", format->name,
                 status, err.message);
        t.angle[2][0] = 0;
        t.valid[0] = 0;
        status = format->write(path, &t, NULL, &err);
        FF_CHECK(status == FF_ERR_DATA && strstr(err.message, "valid") && access(path, F_OK) != 0, "%s: %d %s", format->name,
                 status, err.message);
        t.valid[0] = 1;
    }
    ff_table_clear(&t);
    FF_CHECK(check_leftovers() == 0, "%d unfinished files", check_leftovers());
}

FF_TEST_MAIN(FF_TEST(test_registry), FF_TEST(test_content), FF_TEST(messages), FF_TEST(quantities), FF_TEST(test_table),
             FF_TEST(writing_by_name))
