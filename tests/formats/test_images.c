/* Image stacks: values and spreads against sums made here, the encodings, regions and masks, every message, damaged files. */
#include "check_table.h"
#include "write_image.h"
#include <time.h>

static const double pi = 3.14159265358979323846;

enum { W = 7, H = 5, C = 3, PIXELS = W * H };

static void picture(const char *name, int channels, const char *type, const float *pixels, const char *space, int tile,
                    const char *names)
{
    if (write_image(ff_test_path(name), W, H, channels, type, pixels, space, tile, names) != 0) exit(1);
}

static void csv(const char *name, const char *text)
{
    ff_test_write(ff_test_path(name), text, strlen(text));
}

static int read_ok(const char *label, const char *text, ff_table *t)
{
    ff_error err = {0};
    char message[FF_ERROR_PATH + FF_ERROR_MESSAGE + 64];
    csv("stack.csv", text);
    const ff_status status = ff_table_read_into(ff_test_path("stack.csv"), NULL, t, &err);
    ff_error_format(&err, message, sizeof message);
    return FF_CHECK(status == FF_OK, "%s: %s", label, message) &&
           FF_CHECK(strcmp(t->format, "images") == 0, "%s: %s", label, t->format);
}

static void fails(const char *label, const char *text, ff_status code, long line, const char *const *words)
{
    csv("wrong.csv", text);
    check_fails(label, ff_test_path("wrong.csv"), NULL, code, line, words);
}

/* Mean and standard deviation of channel c over a region in two passes, after `light`. */
static void expected(const float *pixels, int channels, int c, int x0, int y0, int w, int h, double (*light)(double), double *mean,
                     double *spread)
{
    double sum = 0, squares = 0;
    for (int y = y0; y < y0 + h; y++)
        for (int x = x0; x < x0 + w; x++) sum += light((double)pixels[(y * W + x) * channels + c]);
    *mean = sum / (w * h);
    for (int y = y0; y < y0 + h; y++)
        for (int x = x0; x < x0 + w; x++) {
            const double d = light((double)pixels[(y * W + x) * channels + c]) - *mean;
            squares += d * d;
        }
    *spread = sqrt(squares / (w * h - 1));
}

static double same(double v)
{
    return v;
}
static double srgb(double v)
{
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}
static double rec709(double v)
{
    return v < 0.081 ? v / 4.5 : pow((v + 0.099) / 1.099, 1 / 0.45);
}
static double gamma22(double v)
{
    return pow(v, (double)2.2F);
}

/* Pixels that an 8-bit file holds exactly. */
static void fill(float *pixels, size_t n, int most)
{
    for (size_t i = 0; i < n; i++) pixels[i] = (float)(ff_test_random() % (unsigned)(most - 1) + 1) / (float)most;
}

static void check_sample(const char *label, const ff_table *t, size_t i, const float *pixels, int channels, const int region[4],
                         double (*light)(double), double factor)
{
    for (size_t c = 0; c < t->n_channels; c++) {
        double mean, spread;
        expected(pixels, channels, (int)c, region[0], region[1], region[2], region[3], light, &mean, &spread);
        const double v = t->value[c * t->n + i];
        FF_CHECK(fabs(v - factor * mean) < 2e-7 * factor * mean, "%s: sample %zu channel %zu: %.9g, expected %.9g", label, i, c, v,
                 factor * mean);
        if (!FF_CHECK(t->sigma != NULL, "%s: no sigma", label)) continue;
        const double s = t->sigma[c * t->n + i];
        FF_CHECK(fabs(s - factor * spread) < 1e-5 * factor * spread, "%s: sigma %zu %zu: %.9g, expected %.9g", label, i, c, s,
                 factor * spread);
    }
}

static const int whole[4] = {0, 0, W, H};

static void test_values(void)
{
    static float a[PIXELS * C], b[PIXELS * C];
    ff_table t;
    for (int i = 0; i < PIXELS * C; i++) a[i] = (float)(0.1 + ff_test_uniform()), b[i] = (float)(3 * ff_test_uniform() + 1);
    picture("a 1,2.exr", C, "float", a, NULL, 0, NULL);
    picture("b.exr", C, "float", b, NULL, 0, NULL);
    const char *text = "# facetfit-images: 1\n# any: thing\r\n\n"
                       "theta_i,phi_i,theta_o,phi_o, image ,scale,exposure,x,y,width,height\n"
                       "30,0,30.5,180,\"a 1,2.exr\",,,,,,\n"
                       "45,0,-10,90,b.exr,2,0.25,1,2,3,2\n"
                       "# a comment\n"
                       "45,0,0,0,./b.exr,0.5,,,,,\n";
    if (!read_ok("values", text, &t)) return;
    FF_CHECK(t.n == 3 && t.n_channels == 3 && t.radians_per_unit == pi / 180 && t.isotropic && t.quantity == FF_BRDF &&
                 !t.n_invalid,
             "shape");
    FF_CHECK(strcmp(t.channels[0].name, "r") == 0 && strcmp(t.channels[1].name, "g") == 0 && strcmp(t.channels[2].name, "b") == 0,
             "names");
    FF_CHECK(t.angle[0][0] == 30 && t.angle[2][0] == 30.5 && t.angle[3][0] == 180 && t.angle[2][1] == -10 && t.angle[1][2] == 0,
             "angles");
    check_sample("values", &t, 0, a, C, whole, same, 1);
    check_sample("values", &t, 1, b, C, (int[]){1, 2, 3, 2}, same, 8);
    check_sample("values", &t, 2, b, C, whole, same, 0.5);
    FF_CHECK(strstr(t.note, "mean of 6 to 35 pixels") && strstr(t.note, "not that of their mean"), "note: %s", t.note);
    FF_CHECK(!strstr(t.note, "saturated") && !strstr(t.note, "no scale"), "note: %s", t.note);
    ff_table_clear(&t);

    text = "# quantity: reflectance-factor\n# angles: radians\n# isotropic: no\n# region: 2, 1, 4,3\n"
           "image,theta_i,phi_i,theta_o,phi_o\nb.exr,0.5,0,1.25,0\n\"b.exr\",0.5,0,1.25,3";
    if (!read_ok("comments", text, &t)) return;
    FF_CHECK(t.radians_per_unit == 1 && !t.isotropic && t.channels[0].scale == 1 / pi && t.quantity == FF_REFLECTANCE_FACTOR,
             "comments");
    check_sample("comments", &t, 1, b, C, (int[]){2, 1, 4, 3}, same, 1);
    FF_CHECK(strstr(t.note, "no scale is given") && strstr(t.note, "no end-of-line") && strstr(t.note, "mean of 12 pixels"),
             "note: %s", t.note);
    ff_table_clear(&t);

    ff_read_options o;
    ff_error err = {0};
    ff_read_options_init(&o);
    o.quantity = FF_BRDF_COS;
    o.scale = 3;
    if (!FF_CHECK(ff_table_read_with_into(ff_test_path("stack.csv"), &o, &t, &err) == FF_OK, "%s", err.message)) return;
    double mean, spread, v;
    expected(b, C, 2, 2, 1, 4, 3, same, &mean, &spread);
    ff_table_values(&t, 2, 0, 1, &v);
    FF_CHECK(fabs(v - 3 * mean / cos(1.25)) < 1e-6 * v && t.quantity == FF_BRDF_COS && !strstr(t.note, "no scale is"),
             "options: %g", v);
    ff_table_clear(&t);
}

static void test_channels(void)
{
    static float p[PIXELS * 5];
    for (int i = 0; i < PIXELS * 5; i++) p[i] = (float)(0.1 + ff_test_uniform());
    static const struct {
        int channels;
        const char *names, *first, *second;
        size_t n;
    } cases[] = {{1, NULL, "f", NULL, 1},
                 {4, NULL, "r", "g", 3},
                 {1, "465nm", "465nm", NULL, 1},
                 {5, "410nm,500nm,600nm,700nm,x", "410nm", "500nm", 5}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        picture("c.exr", cases[k].channels, "float", p, NULL, 0, cases[k].names);
        if (!read_ok("channels", "image,theta_i,phi_i,theta_o,phi_o\nc.exr,0,0,0,0\n", &t)) continue;
        FF_CHECK(t.n_channels == cases[k].n && strcmp(t.channels[0].name, cases[k].first) == 0, "channels %zu: %zu, '%s'", k,
                 t.n_channels, t.channels[0].name);
        if (cases[k].second && t.n_channels > 1)
            FF_CHECK(strcmp(t.channels[1].name, cases[k].second) == 0, "channels %zu: '%s'", k, t.channels[1].name);
        FF_CHECK(isnan(t.channels[0].wavelength_nm) == !strstr(cases[k].first, "nm"), "channels %zu: wavelength", k);
        FF_CHECK(!strstr(t.note, "alpha of 1 images") == (cases[k].channels != 4), "channels %zu: %s", k, t.note);
        check_sample("channels", &t, 0, p, cases[k].channels, whole, same, 1);
        ff_table_clear(&t);
    }
    picture("c4.exr", 4, "float", p, NULL, 0, NULL);
    picture("c1.exr", 1, "float", p, NULL, 0, NULL);
    picture("cx.exr", 3, "float", p, NULL, 0, "R,G,X");
    picture("c3.exr", 3, "float", p, NULL, 0, NULL);
    ff_table t;
    if (read_ok("with and without alpha", "image,theta_i,phi_i,theta_o,phi_o\nc3.exr,0,0,0,0\nc4.exr,0,0,0,0\n", &t)) {
        FF_CHECK(t.n == 2 && t.n_channels == 3, "with and without alpha");
        ff_table_clear(&t);
    }
    fails("other channels", "image,theta_i,phi_i,theta_o,phi_o\nc4.exr,0,0,0,0\nc1.exr,0,0,0,0\n", FF_ERR_FORMAT, 3,
          WORDS("image 'c1.exr'", "found 1 channels, number 1 named 'Y'", "the 3 of 'c4.exr', there 'R'"));
    fails("other channels", "image,theta_i,phi_i,theta_o,phi_o\nc3.exr,0,0,0,0\ncx.exr,0,0,0,0\n", FF_ERR_FORMAT, 3,
          WORDS("image 'cx.exr'", "number 3 named 'X'", "there 'B'"));
    picture("same.exr", 2, "float", p, NULL, 0, "a,b\tc");
    fails("a tab in a name", "image,theta_i,phi_i,theta_o,phi_o\nsame.exr,0,0,0,0\n", FF_ERR_FORMAT, 2,
          WORDS("image 'same.exr'", "found a channel named 'b\\x09c', expected a printable name of its own"));
}

/* The same pixels in formats with integers and floats, in lines and in tiles, with what each says about its encoding. */
static void test_encodings(void)
{
    static float p8[PIXELS * C], p16[PIXELS * C];
    fill(p8, PIXELS * C, 255);
    fill(p16, PIXELS * C, 65535);
    static const struct {
        const char *file, *type, *space, *comment;
        int tile;
        double (*light)(double);
        const char *note;
    } cases[] = {{"e.png", "uint8", "sRGB", "", 0, srgb, "1 images are sRGB"},
                 {"e.png", "uint8", NULL, "", 0, srgb, "1 images are sRGB"},
                 {"e.png", "uint8", "sRGB", "# encoding: linear\n", 0, same, "read as linear, as the CSV says"},
                 {"e.png", "uint8", NULL, "# encoding: Gamma:2.2\n", 0, NULL, "read as a power, as the CSV says"},
                 {"e.png", "uint16", "sRGB", "# encoding: rec709\n", 0, rec709, "read as Rec. 709"},
                 {"e.png", "uint16", "linear", "", 0, same, "mean of 35"},
                 {"e.png", "uint8", "GammaCorrected2.2", "", 0, gamma22, "1 images are a power"},
                 {"e.tif", "uint16", NULL, "# encoding: linear\n", 0, same, "read as linear"},
                 {"e.tif", "uint16", NULL, "# encoding: linear\n", 16, same, "read as linear"},
                 {"e.tif", "uint8", NULL, "# encoding: srgb\n", 16, srgb, "read as sRGB"},
                 {"e.tif", "float", NULL, "", 0, same, "mean of 35"},
                 {"e.exr", "float", NULL, "", 16, same, "mean of 35"},
                 {"e.bmp", "uint8", NULL, "# encoding: linear\n", 0, same, "read as linear"},
                 {"e.tga", "uint8", NULL, "# encoding: linear\n", 0, same, "read as linear"},
                 {"e.ppm", "uint8", NULL, "# encoding: linear\n", 0, same, "read as linear"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        ff_table t;
        char text[256], label[64];
        const float *p = strcmp(cases[k].type, "uint8") == 0 ? p8 : p16;
        snprintf(label, sizeof label, "encoding %zu, %s %s", k, cases[k].file, cases[k].type);
        picture(cases[k].file, C, cases[k].type, p, cases[k].space, cases[k].tile, NULL);
        snprintf(text, sizeof text, "%simage,theta_i,phi_i,theta_o,phi_o,scale\n%s,0,0,0,0,1\n", cases[k].comment, cases[k].file);
        if (!read_ok(label, text, &t)) continue;
        check_sample(label, &t, 0, p, C, whole, cases[k].light ? cases[k].light : gamma22, 1);
        FF_CHECK(strstr(t.note, cases[k].note), "%s: note: %s", label, t.note);
        ff_table_clear(&t);
    }
    static char pfm[16 + 4 * PIXELS]; /* made by hand: lines from the bottom up, which is the same for a mean */
    const int head = snprintf(pfm, sizeof pfm, "Pf\n%d %d\n-1\n", W, H);
    memcpy(pfm + head, p16, 4 * PIXELS);
    ff_test_write(ff_test_path("e.pfm"), pfm, (size_t)head + 4 * PIXELS);
    ff_table t;
    if (read_ok("pfm", "image,theta_i,phi_i,theta_o,phi_o\ne.pfm,0,0,0,0\n", &t)) {
        check_sample("pfm", &t, 0, p16, 1, whole, same, 1);
        FF_CHECK(strstr(t.note, "1 floating-point images do not say"), "pfm: %s", t.note);
        ff_table_clear(&t);
    }
    picture("u.tif", C, "uint16", p16, NULL, 0, NULL);
    fails("no encoding", "image,theta_i,phi_i,theta_o,phi_o\nu.tif,0,0,0,0\n", FF_ERR_UNSUPPORTED, 2,
          WORDS("image 'u.tif'", "no word on how its numbers encode light", "'# encoding: linear'"));
}

static void test_masks(void)
{
    static float p[PIXELS * C], m[PIXELS];
    for (int i = 0; i < PIXELS * C; i++) p[i] = (float)(0.1 + ff_test_uniform());
    double sum[C] = {0}, n = 0, in_region = 0, region_sum = 0;
    for (int i = 0; i < PIXELS; i++) {
        m[i] = (float)(i % 3 == 1);
        n += i % 3 == 1;
        for (int c = 0; c < C; c++) sum[c] += i % 3 == 1 ? (double)p[i * C + c] : 0;
        const int inside = i % W >= 2 && i / W >= 1 && i % W < 5 && i / W < 4;
        in_region += inside && i % 3 == 1;
        region_sum += inside && i % 3 == 1 ? (double)p[i * C] : 0;
    }
    picture("p.exr", C, "float", p, NULL, 0, NULL);
    picture("m.png", 1, "uint8", m, NULL, 0, NULL);
    ff_table t;
    if (!read_ok("mask",
                 "image,theta_i,phi_i,theta_o,phi_o,mask,x,y,width,height\np.exr,0,0,0,0,m.png,,,,\np.exr,0,0,0,0,m.png,2,1,3,3\n",
                 &t))
        return;
    for (int c = 0; c < C; c++) FF_CHECK(fabs(t.value[c * 2] - sum[c] / n) < 1e-6, "mask: channel %d: %g", c, t.value[c * 2]);
    FF_CHECK(fabs(t.value[1] - region_sum / in_region) < 1e-6, "mask and region: %g, expected %g", t.value[1],
             region_sum / in_region);
    ff_table_clear(&t);
    memset(m, 0, sizeof m);
    picture("m.png", 1, "uint8", m, NULL, 0, NULL);
    fails("empty mask", "image,theta_i,phi_i,theta_o,phi_o,mask\np.exr,0,0,0,0,m.png\n", FF_ERR_DATA, 2,
          WORDS("found no pixel in the region"));
    if (write_image(ff_test_path("small.png"), 3, 2, 1, "uint8", m, NULL, 0, NULL) != 0) exit(1);
    fails("small mask", "image,theta_i,phi_i,theta_o,phi_o,mask\np.exr,0,0,0,0,small.png\n", FF_ERR_DATA, 2,
          WORDS("image 'small.png'", "found a mask of 3 x 2 pixels, expected 7 x 5"));
    fails("no mask", "image,theta_i,phi_i,theta_o,phi_o,mask\np.exr,0,0,0,0,none.png\n", FF_ERR_OPEN, 2,
          WORDS("'none.png'", "No such file"));
}

/* Equal pixels: the spread is that of rounding where there are integers, and unknown where there are none. */
static void test_spread(void)
{
    static float p[PIXELS];
    ff_table t;
    for (int i = 0; i < PIXELS; i++) p[i] = 100.0F / 255;
    picture("equal.png", 1, "uint8", p, NULL, 0, NULL);
    if (read_ok("equal", "image,theta_i,phi_i,theta_o,phi_o\nequal.png,0,0,0,0\n", &t)) {
        const double step = (srgb(100.5 / 255) - srgb(99.5 / 255)) / sqrt(12);
        FF_CHECK(t.sigma && fabs(t.sigma[0] - step) < 1e-6 * step, "equal: %g, expected %g", t.sigma ? t.sigma[0] : -1, step);
        ff_table_clear(&t);
    }
    picture("equal.exr", 1, "float", p, NULL, 0, NULL);
    static const char *const without[] = {"image,theta_i,phi_i,theta_o,phi_o\nequal.exr,0,0,0,0\n",
                                          "# region: 2,2,1,1\nimage,theta_i,phi_i,theta_o,phi_o\nequal.png,0,0,0,0\n"};
    for (int k = 0; k < 2; k++)
        if (read_ok("no sigma", without[k], &t)) {
            FF_CHECK(!t.sigma && strstr(t.note, "there are no standard deviations"), "no sigma %d: %s", k, t.note);
            ff_table_clear(&t);
        }
    static float q[PIXELS * C];
    fill(q, PIXELS * C, 255);
    q[3] = q[4] = q[60] = 1;
    picture("bright.png", C, "uint8", q, NULL, 0, NULL);
    if (read_ok("saturated", "image,theta_i,phi_i,theta_o,phi_o\nbright.png,0,0,0,0\nbright.png,10,0,0,0\n", &t)) {
        FF_CHECK(strstr(t.note, "4 of 70 pixels in 2 images are saturated"), "saturated: %s", t.note);
        ff_table_clear(&t);
    }
    picture("bright.exr", C, "half", q, NULL, 0, NULL);
    if (read_ok("half", "image,theta_i,phi_i,theta_o,phi_o\nbright.exr,0,0,0,0\n", &t)) {
        FF_CHECK(!strstr(t.note, "saturated"), "a float of 1 is no limit: %s", t.note);
        ff_table_clear(&t);
    }
}

static void messages(void)
{
    static float p[PIXELS * C];
    fill(p, PIXELS * C, 255);
    picture("p.png", C, "uint8", p, NULL, 0, NULL);
    csv("text.png", "no image at all");
    ff_test_write(ff_test_path("raw.NEF"), "II*\0preview", 11);
    ff_test_write(ff_test_path("cut.png"), "\x89PNG\r\n\x1A\n", 8);
    ff_test_write(ff_test_path("big.png"), "\x89PNG\r\n\x1A\n\x40\0\0\0tEXtabcd", 20);
    ff_test_write(ff_test_path("big.exr"), "\x76\x2F\x31\x01\2\0\0\0name\0string\0\0\0\0\x40", 24);
    const char *head = "image,theta_i,phi_i,theta_o,phi_o,scale,exposure,x,y,width,height\n";
    static const struct {
        const char *row;
        ff_status code;
        const char *words;
    } rows[] = {
        {"p.png,0,0,0,0,1,1,0,0,8,1", FF_ERR_DATA, "found a region of 8 x 1 pixels at (0, 0), expected one inside of 7 x 5"},
        {"p.png,0,0,0,0,1,1,6,4,1,2", FF_ERR_DATA, "found a region of 1 x 2 pixels at (6, 4)"},
        {"p.png,0,0,0,0,1,1,0,0,0,1", FF_ERR_DATA, "column 'width': found '0', expected a whole number"},
        {"p.png,0,0,0,0,1,1,0.5,0,1,1", FF_ERR_DATA, "column 'x': found '0.5', expected a whole number"},
        {"p.png,0,0,0,0,1,1,-1,0,1,1", FF_ERR_DATA, "column 'x': found '-1'"},
        {"p.png,0,0,0,0,1,1,0,,1,1", FF_ERR_DATA, "column 'y': found an empty cell, expected a region"},
        {"p.png,0,0,0,0,0,1,,,,", FF_ERR_DATA, "column 'scale': found '0', expected a number > 0"},
        {"p.png,0,0,0,0,1,-2,,,,", FF_ERR_DATA, "column 'exposure': found '-2'"},
        {"p.png,0,0,0,0,1e300,1e-300,,,,", FF_ERR_DATA, "a factor that keeps the values finite"},
        {"p.png,0,0,,0,1,1,,,,", FF_ERR_DATA, "column 'theta_o': found an empty cell, expected a finite number"},
        {"p.png,0,0,nan,0,1,1,,,,", FF_ERR_DATA, "column 'theta_o': found 'nan'"},
        {"p.png,0,0,1e999,0,1,1,,,,", FF_ERR_DATA, "column 'theta_o': found '1e999'"},
        {"p.png,200,0,0,0,1,1,,,,", FF_ERR_DATA, "column 'theta_i': found '200', expected degrees from -180 to 180"},
        {",0,0,0,0,1,1,,,,", FF_ERR_DATA, "column 'image': found an empty cell, expected the path"},
        {"p.png,0,0,0,0", FF_ERR_FORMAT, "found 5 cells, expected 11"},
        {"p.png,0,0,0,0,1,1,,,,,", FF_ERR_FORMAT, "found 12 cells, expected 11"},
        {"gone/p.png,0,0,0,0,1,1,,,,", FF_ERR_OPEN, "image 'gone/p.png' cannot be opened at '/tmp/"},
        {".,0,0,0,0,1,1,,,,", FF_ERR_OPEN, "image '.': found no regular file"},
        {"text.png,0,0,0,0,1,1,,,,", FF_ERR_UNSUPPORTED, "image 'text.png': found another kind of file, expected a PNG"},
        {"raw.NEF,0,0,0,0,1,1,,,,", FF_ERR_UNSUPPORTED, "image 'raw.NEF': found a raw file of a camera"},
        {"cut.png,0,0,0,0,1,1,,,,", FF_ERR_FORMAT, "image 'cut.png': OpenImageIO cannot read it"},
        {"big.png,0,0,0,0,1,1,,,,", FF_ERR_FORMAT, "image 'big.png': found a chunk of 1073741824 bytes, expected at most the 4"},
        {"big.exr,0,0,0,0,1,1,,,,", FF_ERR_FORMAT, "image 'big.exr': found an attribute of 1073741824 bytes"}};
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        char text[400];
        snprintf(text, sizeof text, "%sp.png,0,0,0,0,,,,,,\n%s\n", head, rows[k].row);
        fails(rows[k].row, text, rows[k].code, 3, WORDS(rows[k].words));
    }
    static const struct {
        const char *text;
        ff_status code;
        long line;
        const char *words;
    } files[] = {{"image,theta_i,phi_i,theta_o\n", FF_ERR_FORMAT, 1, "column 'phi_o' is missing"},
                 {"image,theta_i,phi_i,theta_o,phi_o,x\n", FF_ERR_FORMAT, 1, "column 'y' is missing: a region"},
                 {"image,theta_i,phi_i,theta_o,phi_o,width\n", FF_ERR_FORMAT, 1, "column 'x' is missing: a region"},
                 {"image,theta_i,phi_i,theta_o,phi_o,f\n", FF_ERR_FORMAT, 1, "column 'f' is none of image"},
                 {"image,theta_i,phi_i,theta_o,phi_o,image\n", FF_ERR_FORMAT, 1, "found column 'image' twice"},
                 {"image,theta_i,phi_i,theta_o,phi_o\n", FF_ERR_DATA, 1, "found no rows"},
                 {"# facetfit-images: 1\n", FF_ERR_READ, 1, "expected a header line"},
                 {"# facetfit-images: 2\n", FF_ERR_FORMAT, 1, "found '2', expected version 1"},
                 {"# facetfit-images: 1\n# quantity: bsdf\n", FF_ERR_FORMAT, 2, "found 'bsdf', expected brdf"},
                 {"# facetfit-images: 1\n# angles: turns\n", FF_ERR_FORMAT, 2, "found 'turns', expected degrees"},
                 {"# facetfit-images: 1\n# isotropic: maybe\n", FF_ERR_FORMAT, 2, "found 'maybe', expected yes or no"},
                 {"# facetfit-images: 1\n# encoding: gamma:0\n", FF_ERR_FORMAT, 2, "found 'gamma:0', expected linear, srgb"},
                 {"# facetfit-images: 1\n# region: 0,0,1\n", FF_ERR_FORMAT, 2, "found '0,0,1', expected x,y,width,height"},
                 {"# facetfit-images: 1\n# region: 0,0,0,1\n", FF_ERR_FORMAT, 2, "found '0,0,0,1'"},
                 {"image,theta_i,phi_i,theta_o,phi_o\np.png,0,0,0,0\n# region: 0,0,1,1\n", FF_ERR_FORMAT, 3, "after the header"}};
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++)
        fails(files[k].text, files[k].text, files[k].code, files[k].line, WORDS(files[k].words));
    p[50] = NAN;
    picture("nan.exr", C, "float", p, NULL, 0, NULL);
    fails("nan", "image,theta_i,phi_i,theta_o,phi_o\nnan.exr,0,0,0,0\n", FF_ERR_DATA, 2,
          WORDS("found nan in channel B of pixel (2, 2), expected finite numbers"));
}

/* What is no module where one is looked for first does not keep the right one from being found. */
static void test_module(void)
{
    static float p[PIXELS];
    picture("m.exr", 1, "float", p, NULL, 0, NULL);
    ff_table t;
    csv("facetfit_images.so", "");
    char dir[160];
    snprintf(dir, sizeof dir, "%s", ff_test_path("facetfit_images.so"));
    *strrchr(dir, '/') = '\0';
    setenv("FACETFIT_MODULES", dir, 1);
    if (read_ok("another module follows", "image,theta_i,phi_i,theta_o,phi_o\nm.exr,0,0,0,0\n", &t)) ff_table_clear(&t);
    unsetenv("FACETFIT_MODULES");
}

static void detection(void)
{
    static const struct {
        const char *text, *format;
    } cases[] = {{"image,theta_i,phi_i,theta_o,phi_o\n", "images"},
                 {"\xEF\xBB\xBF# x\r\n \"theta_i\",\"image\" ,phi_i,theta_o,phi_o\n", "images"},
                 {"# facetfit-images: 1\ntheta_i\n", "images"},
                 {"theta_i,phi_i,theta_o,phi_o,f\n", "csv"},
                 {"theta_i,phi_i,theta_o,phi_o,images\n", "csv"},
                 {"# facetfit-csv: 1\ntheta_i,phi_i,theta_o,phi_o,f\n", "csv"}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        const ff_format *f = NULL;
        ff_error err = {0};
        csv("d.csv", cases[k].text);
        FF_CHECK(ff_format_detect(ff_test_path("d.csv"), &f, &err) == FF_OK && strcmp(f->name, cases[k].format) == 0, "%s is %s",
                 cases[k].text, f ? f->name : err.message);
    }
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#if defined(__SANITIZE_ADDRESS__)
static const double soon = 60; /* marking 2 GB that libtiff asks for and never touches takes the sanitizer seconds */
#else
static const double soon = 1;
#endif

/* An error that says where, or a table that can be written; soon. */
static ff_status check_sane(const char *label, const char *path)
{
    ff_table t;
    ff_error err = {0};
    const double begin = now();
    const ff_status status = ff_table_read_into(path, "images", &t, &err);
    FF_CHECK(now() - begin < soon, "%s: took %g s", label, now() - begin);
    if (status != FF_OK) {
        FF_CHECK(err.code == status && err.message[0] && strcmp(err.path, path) == 0, "%s: an error without words", label);
        return status;
    }
    FF_CHECK(ff_table_write("/dev/null", "csv", &t, &err) == FF_OK, "%s: a table that is none: %s", label, err.message);
    ff_table_clear(&t);
    return status;
}

static void damaged_csv(void)
{
    static float p[PIXELS * C];
    fill(p, PIXELS * C, 255);
    picture("p.ppm", C, "uint8", p, NULL, 0, NULL);
    const char *text =
        "# region: 1,1,2,2\n# encoding: srgb\nimage,theta_i,phi_i,theta_o,phi_o,scale\np.ppm,1,2,3,4,5\n\"p.ppm\",5,4,3,2,1\n";
    const size_t n = strlen(text);
    const char *path = ff_test_path("cut.csv");
    char copy[256], label[64];
    for (size_t k = 0; k < n; k++) {
        snprintf(label, sizeof label, "first %zu bytes", k);
        ff_test_write(path, text, k);
        check_sane(label, path);
    }
    for (size_t bit = 0; bit < 8 * n; bit++) {
        memcpy(copy, text, n + 1);
        copy[bit / 8] = (char)(copy[bit / 8] ^ 1 << bit % 8);
        snprintf(label, sizeof label, "bit %zu", bit);
        ff_test_write(path, copy, n);
        check_sane(label, path);
    }
}

/* Images that are cut, and sizes that a small file cannot have. */
static void damaged_images(void)
{
    static float p[PIXELS * C];
    static const struct {
        const char *name, *type;
    } formats[] = {{"d.png", "uint8"}, {"d.exr", "half"}, {"d.tif", "uint16"}, {"d.bmp", "uint8"}};
    fill(p, PIXELS * C, 255);
    for (size_t k = 0; k < sizeof formats / sizeof formats[0]; k++) {
        size_t n;
        char text[160], label[96];
        picture(formats[k].name, C, formats[k].type, p, NULL, 0, NULL);
        char *bytes = ff_test_slurp(ff_test_path(formats[k].name), &n);
        snprintf(text, sizeof text, "# encoding: linear\nimage,theta_i,phi_i,theta_o,phi_o\n%s,0,0,0,0\n", formats[k].name);
        csv("damaged.csv", text);
        const char *stack = ff_test_path("damaged.csv"), *image = ff_test_path(formats[k].name);
        for (size_t cut = 0; cut < n; cut += 1 + n / 60) {
            snprintf(label, sizeof label, "%s: first %zu of %zu bytes", formats[k].name, cut, n);
            ff_test_write(image, bytes, cut);
            check_sane(label, stack);
        }
        for (size_t bit = 0; bit < 8 * n && bit < 8 * 200; bit += 3) {
            bytes[bit / 8] = (char)(bytes[bit / 8] ^ 1 << bit % 8);
            snprintf(label, sizeof label, "%s: bit %zu", formats[k].name, bit);
            ff_test_write(image, bytes, n);
            check_sane(label, stack);
            bytes[bit / 8] = (char)(bytes[bit / 8] ^ 1 << bit % 8);
        }
        free(bytes);
    }
    const char *huge = "P6 60000 60000 255\n";
    ff_test_write(ff_test_path("huge.ppm"), huge, strlen(huge));
    fails("huge", "# encoding: linear\nimage,theta_i,phi_i,theta_o,phi_o\nhuge.ppm,0,0,0,0\n", FF_ERR_FORMAT, 3,
          WORDS("image 'huge.ppm'", "found 60000 x 60000 pixels, expected a file that is large enough"));
}

/* OpenImageIO 2.4.7 loses its error message, some 30 bytes, where libpng leaves it by a longjmp because a PNG image ends early. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:PNGInput::PngReadCallback\n";
}
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "fast_unwind_on_malloc=0";
}

FF_TEST_MAIN(FF_TEST(test_values), FF_TEST(test_channels), FF_TEST(test_encodings), FF_TEST(test_masks), FF_TEST(test_spread),
             FF_TEST(messages), FF_TEST(detection), FF_TEST(test_module), FF_TEST(damaged_csv), FF_TEST(damaged_images))
