/* Tables in OpenEXR images: round trips, an image that another program could have written (made here through OpenEXRCore from the
 * text of docs/exr.md), the UTIA layout, every message, damaged files. */
#include "check_table.h"
#include "data_formats/table/internal_table.h"
#include <openexr.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <time.h>

static const double pi = 3.14159265358979323846;

/* ---- images made here ------------------------------------------------------------------------ */

enum { CHANNELS = 8, ATTRIBUTES = 24, VECTOR = 4 };

typedef struct image {
    int width, height, compression;
    int x0, y0;
    const char *channel[CHANNELS]; /* sorted by name */
    int type[CHANNELS];
    const void *pixels[CHANNELS]; /* [height][width] of float, uint32 or half */
    struct {
        const char *name;
        char kind; /* i, s, v */
        int number;
        const char *text, *vector[VECTOR];
    } attribute[ATTRIBUTES];
    int n_channels, n_attributes;
} image;

static void set_int(image *m, const char *name, int v)
{
    m->attribute[m->n_attributes].name = name;
    m->attribute[m->n_attributes].number = v;
    m->attribute[m->n_attributes++].kind = 'i';
}

static void set_text(image *m, const char *name, const char *text)
{
    m->attribute[m->n_attributes].name = name;
    m->attribute[m->n_attributes].text = text;
    m->attribute[m->n_attributes++].kind = 's';
}

static void set_vector(image *m, const char *name, const char *a, const char *b)
{
    m->attribute[m->n_attributes].name = name;
    m->attribute[m->n_attributes].vector[0] = a;
    m->attribute[m->n_attributes].vector[1] = b;
    m->attribute[m->n_attributes++].kind = 'v';
}

static void set_channel(image *m, const char *name, int type, const void *pixels)
{
    m->channel[m->n_channels] = name;
    m->type[m->n_channels] = type;
    m->pixels[m->n_channels++] = pixels;
}

static void must(exr_result_t r, const char *what)
{
    if (r == EXR_ERR_SUCCESS) return;
    fprintf(stderr, "OpenEXRCore: %s: %s\n", what, exr_get_default_error_message(r));
    exit(1);
}

static void write_chunks(exr_context_t c, const image *m)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int lines;
    must(exr_get_scanlines_per_chunk(c, 0, &lines), "lines");
    for (int y = 0; y < m->height; y += lines) {
        exr_chunk_info_t chunk;
        must(exr_write_scanline_chunk_info(c, 0, m->y0 + y, &chunk), "chunk");
        must(y ? exr_encoding_update(c, 0, &chunk, &pipe) : exr_encoding_initialize(c, 0, &chunk, &pipe), "encoding");
        for (int k = 0; k < m->n_channels; k++) {
            const int bytes = m->type[k] == EXR_PIXEL_HALF ? 2 : 4;
            exr_coding_channel_info_t *to = &pipe.channels[k];
            to->user_bytes_per_element = (int16_t)bytes;
            to->user_data_type = (uint16_t)m->type[k];
            to->user_pixel_stride = bytes;
            to->user_line_stride = bytes * m->width;
            to->encode_from_ptr = (const uint8_t *)m->pixels[k] + (size_t)bytes * (size_t)m->width * (size_t)y;
        }
        if (!y) must(exr_encoding_choose_default_routines(c, 0, &pipe), "routines");
        must(exr_encoding_run(c, 0, &pipe), "run");
    }
    must(exr_encoding_destroy(c, &pipe), "destroy");
}

static const char *write_image(const char *name, const image *m)
{
    const char *path = ff_test_path(name);
    exr_context_t c;
    int part;
    must(exr_start_write(&c, path, EXR_WRITE_FILE_DIRECTLY, NULL), "start");
    must(exr_set_longname_support(c, 1), "names");
    must(exr_add_part(c, "any", EXR_STORAGE_SCANLINE, &part), "part");
    must(exr_initialize_required_attr_simple(c, 0, m->width, m->height, (exr_compression_t)m->compression), "attributes");
    const exr_attr_box2i_t window = {{{{m->x0, m->y0}}}, {{{m->x0 + m->width - 1, m->y0 + m->height - 1}}}};
    must(exr_set_data_window(c, 0, &window), "window");
    for (int k = 0; k < m->n_channels; k++)
        must(exr_add_channel(c, 0, m->channel[k], (exr_pixel_type_t)m->type[k], EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1), m->channel[k]);
    for (int k = 0; k < m->n_attributes; k++) {
        const char *n = m->attribute[k].name;
        if (m->attribute[k].kind == 'i') must(exr_attr_set_int(c, 0, n, m->attribute[k].number), n);
        if (m->attribute[k].kind == 's') must(exr_attr_set_string(c, 0, n, m->attribute[k].text), n);
        const char **v = (const char **)m->attribute[k].vector;
        if (m->attribute[k].kind == 'v') must(exr_attr_set_string_vector(c, 0, n, v[1] ? 2 : 1, v), n);
    }
    must(exr_write_header(c), "header");
    write_chunks(c, m);
    must(exr_finish(&c), "finish");
    return path;
}

/* The list of docs/exr.md: three samples in an image of 2 x 2. */
static float list_r[4] = {1, 2, NAN, 99}, list_s[4] = {0.5F, 0.25F, -1, 99}, list_w[4] = {1, 0, 3, -1};
static float list_angle[4][4] = {{10, 20, 30, NAN}, {0, 90, 180, NAN}, {40, 50, 60, NAN}, {-90, 270, 45.5F, NAN}};

static image list_image(void)
{
    image m = {.width = 2, .height = 2};
    set_channel(&m, "465nm", EXR_PIXEL_FLOAT, list_r);
    set_channel(&m, "direction.phi_i", EXR_PIXEL_FLOAT, list_angle[1]);
    set_channel(&m, "direction.phi_o", EXR_PIXEL_FLOAT, list_angle[3]);
    set_channel(&m, "direction.theta_i", EXR_PIXEL_FLOAT, list_angle[0]);
    set_channel(&m, "direction.theta_o", EXR_PIXEL_FLOAT, list_angle[2]);
    set_channel(&m, "sigma.465nm", EXR_PIXEL_FLOAT, list_s);
    set_channel(&m, "weight", EXR_PIXEL_FLOAT, list_w);
    set_int(&m, "facetfit.version", 1);
    set_text(&m, "facetfit.parametrisation", "list");
    set_text(&m, "facetfit.quantity", "brdf");
    set_text(&m, "facetfit.angle_unit", "degree");
    set_text(&m, "facetfit.value_unit", "1/sr");
    set_int(&m, "facetfit.isotropic", 0);
    set_int(&m, "facetfit.samples", 3);
    set_vector(&m, "facetfit.channels", "465nm", NULL);
    set_vector(&m, "facetfit.planes", "465nm", NULL);
    set_text(&m, "facetfit.wavelengths", "465");
    return m;
}

static int index_of(const image *m, const char *attribute)
{
    for (int k = 0; k < m->n_attributes; k++)
        if (strcmp(m->attribute[k].name, attribute) == 0) return k;
    exit(1);
}

static int read_ok(const char *label, const char *path, ff_table *t)
{
    ff_error err = {0};
    char message[FF_ERROR_PATH + FF_ERROR_MESSAGE + 64];
    const ff_status status = ff_table_read_into(path, NULL, t, &err);
    ff_error_format(&err, message, sizeof message);
    return FF_CHECK(status == FF_OK, "%s: %s", label, message);
}

static void check_list(const char *label, const char *path)
{
    ff_table t;
    if (!read_ok(label, path, &t)) return;
    FF_CHECK(strcmp(t.format, "exr") == 0 && t.n == 3 && t.n_channels == 1 && t.axes.kind == FF_AXES_NONE && !t.grid, "%s: shape",
             label);
    FF_CHECK(strcmp(t.channels[0].name, "465nm") == 0 && t.channels[0].wavelength_nm == 465, "%s: channel", label);
    FF_CHECK(t.value[0] == 1 && t.value[1] == 2 && t.value[2] == 0, "%s: %g %g %g", label, t.value[0], t.value[1], t.value[2]);
    FF_CHECK(t.valid[0] && t.valid[1] && !t.valid[2] && t.n_invalid == 1, "%s: validity", label);
    FF_CHECK(t.sigma && t.sigma[0] == 0.5 && t.sigma[1] == 0.25 && t.sigma[2] == 0, "%s: sigma", label);
    FF_CHECK(t.weight && t.weight[0] == 1 && t.weight[1] == 0 && t.weight[2] == 3, "%s: weight", label);
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 3; i++) FF_CHECK(t.angle[k][i] == (double)list_angle[k][i], "%s: angle %d %d", label, k, i);
    FF_CHECK(t.radians_per_unit == pi / 180 && !t.isotropic && t.quantity == FF_BRDF, "%s: unit, quantity", label);
    ff_table_clear(&t);
}

static void test_list(void)
{
    image m = list_image();
    check_list("list", write_image("list.exr", &m));
    m.x0 = -7;
    m.y0 = 1000;
    check_list("window elsewhere", write_image("window.exr", &m));
    m = list_image(); /* an attribute and a channel that nobody knows, an image of one line */
    m.width = 4;
    m.height = 1;
    set_text(&m, "owner", "somebody");
    set_channel(&m, "zebra", EXR_PIXEL_FLOAT, list_r);
    check_list("more than needed", write_image("more.exr", &m));
    for (int c = EXR_COMPRESSION_NONE; c <= EXR_COMPRESSION_ZIP; c++) {
        m = list_image();
        m.compression = c;
        check_list("lossless compression", write_image("compressed.exr", &m));
    }
}

/* Every compression that OpenEXRCore 3.1 has (it has no DWA), on a smooth table of more lines than a chunk. */
static void test_compressions(void)
{
    enum { W = 19, H = 70, N = W * H };
    static float v[N], w[N], angle[4][N];
    for (int i = 0; i < N; i++) {
        v[i] = 1.0F + (float)(i % W) / 64 + (float)(i / W) / 128;
        w[i] = (float)i;
        for (int k = 0; k < 4; k++) angle[k][i] = (float)((i + k) % 80);
    }
    for (int c = EXR_COMPRESSION_NONE; c <= EXR_COMPRESSION_B44A; c++) {
        image m = list_image();
        m.width = W;
        m.height = H;
        m.compression = c;
        const void *const from[7] = {v, angle[1], angle[3], angle[0], angle[2], v, w};
        memcpy(m.pixels, from, sizeof from);
        m.attribute[index_of(&m, "facetfit.samples")].number = N;
        ff_table t;
        char label[32];
        snprintf(label, sizeof label, "compression %d", c);
        if (!read_ok(label, write_image("c.exr", &m), &t)) continue;
        double worst = 0;
        for (size_t i = 0; i < N; i++) worst = fmax(worst, fabs(t.value[i] - (double)v[i]));
        FF_CHECK(worst <= (c < EXR_COMPRESSION_PXR24 ? 0 : 1e-2), "%s: off by %g", label, worst);
        FF_CHECK(!strstr(t.note, "loss") == (c < EXR_COMPRESSION_PXR24), "%s: note '%s'", label, t.note);
        ff_table_clear(&t);
    }
}

/* Halves, as a picture program saves them, and 64-bit numbers in two channels. */
static void types(void)
{
    static const uint16_t half[4] = {0x3C00, 0x4000, 0x7E00, 0}; /* 1, 2, NaN */
    image m = list_image();
    m.type[0] = EXR_PIXEL_HALF;
    m.pixels[0] = half;
    check_list("halves", write_image("half.exr", &m));

    static uint32_t high[4], low[4];
    const double v[4] = {1.0 / 3, -2.0e-300, NAN, 0};
    for (int i = 0; i < 4; i++) {
        uint64_t u;
        memcpy(&u, v + i, 8);
        high[i] = (uint32_t)(u >> 32);
        low[i] = (uint32_t)u;
    }
    m = list_image();
    m.n_channels = 0;
    set_channel(&m, "465nm.high", EXR_PIXEL_UINT, high);
    set_channel(&m, "465nm.low", EXR_PIXEL_UINT, low);
    for (int k = 0; k < 4; k++) {
        static const char *const name[4] = {"direction.phi_i", "direction.phi_o", "direction.theta_i", "direction.theta_o"};
        set_channel(&m, name[k], EXR_PIXEL_FLOAT, list_angle[0]);
    }
    ff_table t;
    if (!read_ok("doubles", write_image("double.exr", &m), &t)) return;
    FF_CHECK(t.value[0] == v[0] && t.value[1] == v[1] && !t.valid[2] && !t.sigma && !t.weight && t.n_negative == 1,
             "doubles: %.17g %.17g", t.value[0], t.value[1]);
    ff_table_clear(&t);
}

static void test_quantity(void)
{
    image m = list_image();
    m.attribute[index_of(&m, "facetfit.quantity")].text = "brdf-cos";
    ff_table t;
    if (!read_ok("brdf-cos", write_image("cos.exr", &m), &t)) return;
    FF_CHECK(fabs(t.value[0] - 1 / cos(40 * pi / 180)) < 1e-14 && fabs(t.sigma[1] - 0.25 / cos(50 * pi / 180)) < 1e-14 &&
                 t.quantity == FF_BRDF_COS,
             "brdf-cos: %.17g", t.value[0]);
    ff_table_clear(&t);
    ff_read_options o;
    ff_error err = {0};
    ff_read_options_init(&o);
    o.quantity = FF_REFLECTANCE_FACTOR;
    if (!FF_CHECK(ff_table_read_with_into(ff_test_path("cos.exr"), &o, &t, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(t.value[0] == 1 && t.channels[0].scale == 1 / pi, "the person's word goes before the file's");
    ff_table_clear(&t);
    m = list_image();
    m.attribute[index_of(&m, "facetfit.angle_unit")].text = "radian";
    if (!read_ok("radian", write_image("radian.exr", &m), &t)) return;
    FF_CHECK(t.radians_per_unit == 1, "radian");
    ff_table_clear(&t);
}

/* ---- round trips ----------------------------------------------------------------------------- */

static void fill(ff_table *t)
{
    for (size_t c = 0; c < t->n_channels; c++)
        for (size_t i = 0; i < t->n; i++) {
            t->value[c * t->n + i] = exp(20 * ff_test_uniform() - 10) * (ff_test_random() % 9 ? 1 : -1);
            if (t->sigma) t->sigma[c * t->n + i] = 0.01 + ff_test_uniform();
        }
    for (size_t i = 1; i < t->n; i += 7) t->valid[i] = 0;
    for (size_t i = 0; i < t->n && t->weight; i++) t->weight[i] = ff_test_uniform();
}

static void check_near(const char *label, const ff_table *t, const ff_table *back, double relative)
{
    if (!FF_CHECK(back->n == t->n && back->n_channels == t->n_channels && !back->sigma == !t->sigma && !back->weight == !t->weight,
                  "%s: shape", label))
        return;
    FF_CHECK(memcmp(t->valid, back->valid, t->n) == 0 && t->isotropic == back->isotropic, "%s: validity", label);
    for (size_t c = 0; c < t->n_channels; c++) {
        const double scale = t->channels[c].scale;
        FF_CHECK(strcmp(t->channels[c].name, back->channels[c].name) == 0, "%s: channel '%s' '%s'", label, t->channels[c].name,
                 back->channels[c].name);
        const double nm = t->channels[c].wavelength_nm, nm_back = back->channels[c].wavelength_nm;
        FF_CHECK(nm == nm_back || (isnan(nm) && isnan(nm_back)), "%s: wavelength %g %g", label, nm, nm_back);
        for (size_t i = 0; i < t->n; i++) {
            const size_t k = c * t->n + i;
            if (!t->valid[i]) continue;
            if (!FF_CHECK(fabs(back->value[k] - scale * t->value[k]) <= relative * fabs(scale * t->value[k]),
                          "%s: %zu %zu: %.17g %.17g", label, c, i, t->value[k], back->value[k]))
                return;
            if (t->sigma)
                FF_CHECK(fabs(back->sigma[k] - scale * t->sigma[k]) <= relative * scale * t->sigma[k], "%s: sigma %zu", label, i);
        }
    }
    for (size_t i = 0; i < t->n && t->weight; i++)
        FF_CHECK(fabs(back->weight[i] - t->weight[i]) <= relative * t->weight[i], "%s: weight %zu", label, i);
}

static void same_nodes(const char *label, const ff_table *t, const ff_table *back)
{
    FF_CHECK(t->axes.kind == back->axes.kind, "%s: axes %d %d", label, t->axes.kind, back->axes.kind);
    for (int k = 0; k < 4 && t->axes.kind; k++)
        if (FF_CHECK(t->axes.n[k] == back->axes.n[k], "%s: axis %d", label, k))
            FF_CHECK(check_same_bits(t->axes.node[k], back->axes.node[k], t->axes.n[k]), "%s: nodes %d", label, k);
}

/* Writes, reads, compares within the loss of floats; writes that again, which loses nothing any more. */
static void round_trip(const char *label, const ff_table *t, double relative)
{
    ff_table back, again;
    ff_error err = {0};
    const char *path = ff_test_path("a.exr"), *second = ff_test_path("b.exr");
    if (!FF_CHECK(ff_table_write(path, NULL, t, &err) == FF_OK, "%s: %s", label, err.message)) return;
    if (!read_ok(label, path, &back)) return;
    FF_CHECK(back.grid == t->grid, "%s: grid", label);
    check_near(label, t, &back, relative);
    same_nodes(label, t, &back);
    if (!t->grid) check_same_angles(label, t, &back);
    FF_CHECK(ff_table_write(second, NULL, &back, &err) == FF_OK, "%s: %s", label, err.message);
    size_t n, m;
    char *one = ff_test_slurp(path, &n), *two = ff_test_slurp(second, &m);
    FF_CHECK(n == m && memcmp(one, two, n) == 0, "%s: written again it differs", label);
    free(one);
    free(two);
    if (read_ok(label, second, &again)) {
        check_same_tables(label, &back, &again);
        ff_table_clear(&again);
    }
    ff_table_clear(&back);
}

static void name(ff_table *t, size_t c, const char *text, double nm)
{
    snprintf(t->channels[c].name, sizeof t->channels[c].name, "%s", text);
    t->channels[c].wavelength_nm = nm;
}

static const double float_loss = 6e-8;

static void round_trips(void)
{
    ff_table t;
    ff_error err;
    for (int kind = FF_AXES_HALF_DIFFERENCE; kind <= FF_AXES_SPECULAR; kind++) {
        const double a[5] = {0, 0.1, 1.0 / 3, 45, 88}, b[3] = {0, 120.7, 240}, c[2] = {10, 11.5}, one[1] = {0};
        const size_t n[4] = {5, 1, 3, 2};
        const double *const node[4] = {a, one, b, c};
        if (ff_table_init_axes((ff_axes_kind)kind, n, node, pi / 180, 2, kind == FF_AXES_SPECULAR, &t, &err) != FF_OK) exit(1);
        fill(&t);
        t.isotropic = kind == FF_AXES_HALF_DIFFERENCE;
        round_trip("axes", &t, float_loss);
        ff_table_clear(&t);
    }
    for (int exact = 0; exact < 2; exact++) {
        if (ff_table_init(20000, 5, NULL, 1, 1, &t, &err) != FF_OK) exit(1); /* two lines, the second not full */
        for (int k = 0; k < 4; k++)
            for (size_t i = 0; i < t.n; i++) t.angle[k][i] = exact ? (double)(i % 80) + 0.5 : 80 * ff_test_uniform();
        t.radians_per_unit = exact ? pi / 180 : 1;
        name(&t, 0, "r", NAN);
        name(&t, 1, "R", NAN);
        name(&t, 2, "sigma.x y", 500.25);
        name(&t, 3, "f.high", NAN);
        name(&t, 4, "a channel whose name is as long as it may be, 63 bytes 123456", 1e4);
        t.channels[2].scale = 1 / pi;
        fill(&t);
        round_trip(exact ? "list" : "list of doubles", &t, float_loss);
        ff_table_clear(&t);
    }
    if (ff_table_init(1, 1, NULL, 0, 0, &t, &err) != FF_OK) exit(1);
    name(&t, 0, "f", NAN);
    t.value[0] = 0.25;
    round_trip("one sample", &t, 0);
    ff_table_clear(&t);
}

static void test_merl(void)
{
    ff_table t, back, binary;
    ff_error err = {0};
    if (ff_table_init(ff_grid_merl.n, 3, &ff_grid_merl, 0, 0, &t, &err) != FF_OK) exit(1);
    name(&t, 0, "r", NAN);
    name(&t, 1, "g", NAN);
    name(&t, 2, "b", NAN);
    for (size_t k = 0; k < 3 * t.n; k++) t.value[k] = ff_test_uniform();
    for (size_t i = 0; i < t.n; i += 3) t.valid[i] = 0;
    round_trip("merl", &t, float_loss);
    if (read_ok("merl", ff_test_path("a.exr"), &back)) {
        FF_CHECK(back.grid == &ff_grid_merl && back.isotropic == 1 && !back.angle[0], "the grid is MERL's");
        FF_CHECK(ff_table_write(ff_test_path("m.binary"), NULL, &back, &err) == FF_OK, "%s", err.message);
        if (read_ok("merl file", ff_test_path("m.binary"), &binary)) {
            FF_CHECK(binary.n_invalid == back.n_invalid, "invalid %zu %zu", binary.n_invalid, back.n_invalid);
            double u, v;
            ff_table_values(&back, 2, 1000001, 1, &u);
            ff_table_values(&binary, 2, 1000001, 1, &v);
            FF_CHECK(fabs(u - v) <= 4e-16 * u, "%.17g %.17g", u, v);
            ff_table_clear(&binary);
        }
        ff_table_clear(&back);
    }
    /* the image is what docs/exr.md says: theta_h down, (theta_d, phi_d) across */
    size_t n;
    char *bytes = ff_test_slurp(ff_test_path("a.exr"), &n);
    const size_t i = 1 + 180 * (2 + 90 * (size_t)3), head = n - 90 * (8 + 3 * 4 * (size_t)16200);
    float r;
    memcpy(&r, bytes + head + 3 * (8 + 3 * 4 * (size_t)16200) + 8 + 2 * 4 * (size_t)16200 + 4 * (size_t)(2 * 180 + 1), 4);
    FF_CHECK(t.valid[i] && r == (float)t.value[i], "channel R of pixel (361, 3) is %g, expected %g", (double)r, t.value[i]);
    free(bytes);
    ff_table_clear(&t);
}

/* ---- layouts --------------------------------------------------------------------------------- */

static ff_status lay_out(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    return ff_format_find("exr")->layout(t, grid, out, err);
}

static void test_product(const ff_table *t, const char *grid, ff_axes_kind kind, const size_t n[4], const double first[4],
                         const double last[4])
{
    ff_table made;
    ff_error err = {0};
    if (!FF_CHECK(lay_out(t, grid, &made, &err) == FF_OK, "%s: %s", grid, err.message)) return;
    FF_CHECK(made.axes.kind == kind && made.n_channels == t->n_channels && !made.n_invalid, "%s: kind", grid);
    for (int k = 0; k < 4; k++) {
        if (!FF_CHECK(made.axes.n[k] == n[k], "%s: axis %d has %zu", grid, k, made.axes.n[k])) continue;
        const double *node = made.axes.node[k];
        FF_CHECK(fabs(node[0] - first[k]) < 1e-12 && fabs(node[n[k] - 1] - last[k]) < 1e-12, "%s: axis %d from %.17g to %.17g",
                 grid, k, node[0], node[n[k] - 1]);
    }
    FF_CHECK(made.radians_per_unit == pi / 180 && made.isotropic == (n[1] == 1), "%s: isotropic %d", grid, made.isotropic);
    FF_CHECK(strcmp(made.channels[0].name, t->channels[0].name) == 0, "%s: channel", grid);
    for (size_t i = 0; i < made.n * made.n_channels; i++) made.value[i] = 1.5;
    round_trip(grid, &made, 0);
    ff_table_clear(&made);
}

static void test_layouts(void)
{
    ff_table t, made, back;
    ff_error err = {0};
    if (ff_table_init(300, 2, NULL, 0, 1, &t, &err) != FF_OK) exit(1);
    name(&t, 0, "450nm", 450);
    name(&t, 1, "x", NAN);
    for (int k = 0; k < 4; k++)
        for (size_t i = 0; i < t.n; i++) t.angle[k][i] = 80 * ff_test_uniform();
    t.radians_per_unit = pi / 180;
    fill(&t);
    test_product(&t, "half-difference:10x9x18", FF_AXES_HALF_DIFFERENCE, (size_t[]){10, 1, 9, 18}, (double[]){0.225, 0, 5, 5},
                 (double[]){90 * 0.95 * 0.95, 0, 85, 175});
    test_product(&t, "half-difference:3x4x9x18,double", FF_AXES_HALF_DIFFERENCE, (size_t[]){3, 4, 9, 18}, (double[]){2.5, 0, 5, 5},
                 (double[]){62.5, 270, 85, 175});
    test_product(&t, "incident-exit:6x9x12", FF_AXES_INCIDENT_EXIT, (size_t[]){6, 1, 9, 12}, (double[]){7.5, 0, 5, 0},
                 (double[]){82.5, 0, 85, 330});
    test_product(&t, "incident-exit:1x2x3x4", FF_AXES_INCIDENT_EXIT, (size_t[]){1, 2, 3, 4}, (double[]){45, 0, 15, 0},
                 (double[]){45, 180, 75, 270});

    static const char *const same[] = {NULL, "own", "list", "own,double", "double"};
    for (int k = 0; k < 5; k++) {
        const char *label = same[k] ? same[k] : "nothing";
        if (!FF_CHECK(lay_out(&t, same[k], &made, &err) == FF_OK, "%s: %s", label, err.message)) continue;
        check_same_angles(label, &t, &made);
        FF_CHECK(check_same_bits(t.weight, made.weight, t.n), "%s: weights", label);
        memcpy(made.value, t.value, 2 * t.n * sizeof *t.value);
        memcpy(made.valid, t.valid, t.n);
        round_trip(label, &made, k < 3 ? float_loss : 0);
        FF_CHECK(ff_table_write(ff_test_path("d.exr"), NULL, &made, &err) == FF_OK, "%s", err.message);
        if (read_ok(label, ff_test_path("d.exr"), &back)) {
            size_t equal = 0;
            for (size_t i = 0; i < t.n; i++) equal += back.value[i] == t.value[i];
            FF_CHECK((equal > t.n / 2) == (k >= 3), "%s: %zu values to the bit", label, equal);
            ff_table_clear(&back);
        }
        ff_table_clear(&made);
    }
    if (FF_CHECK(lay_out(&t, "merl", &made, &err) == FF_OK, "%s", err.message)) {
        FF_CHECK(made.grid == &ff_grid_merl && made.n_channels == 2, "merl");
        const ff_table on_grid = made;
        ff_table list;
        if (FF_CHECK(lay_out(&on_grid, "list", &list, &err) == FF_OK, "%s", err.message)) {
            double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5},
                                g[6], *const of_grid[6] = {g, g + 1, g + 2, g + 3, g + 4, g + 5};
            ff_table_directions(&list, 777777, 1, planes);
            ff_table_directions(&on_grid, 777777, 1, of_grid);
            for (int k = 0; k < 6; k++) FF_CHECK(fabs(w[k] - g[k]) < 1e-12, "merl as list: %d: %g %g", k, w[k], g[k]);
            ff_table_clear(&list);
        }
        ff_table_clear(&made);
    }
    static const char *const wrong[] = {"",
                                        "mer",
                                        "half-difference:",
                                        "half-difference:10x9",
                                        "incident-exit:1x2x3x4x5",
                                        "incident-exit:0x2x3",
                                        "half-difference:2x3x4,float",
                                        "half-difference:2x-3x4",
                                        "own,double,double",
                                        "half-difference:99999999999999999999x1x1",
                                        "incident-exit:1x2x3 "};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        err = (ff_error){0};
        const ff_status status = lay_out(&t, wrong[k], &made, &err);
        FF_CHECK(status == FF_ERR_SYNTAX && strstr(err.message, "expected"), "grid '%s': %d %s", wrong[k], status, err.message);
    }
    FF_CHECK(lay_out(&t, "incident-exit:100000x100000x3", &made, &err) == FF_ERR_RANGE, "a grid beyond 2^31 samples");
    ff_table_clear(&t);
}

/* ---- the UTIA database ----------------------------------------------------------------------- */

static void test_utia(void)
{
    enum { SIDE = 288 };
    static float r[SIDE * SIDE], g[SIDE * SIDE], b[SIDE * SIDE];
    for (int i = 0; i < SIDE * SIDE; i++) {
        r[i] = (float)i;
        g[i] = (float)(i / SIDE);
        b[i] = i == 5 ? -0.5F : (float)(i % SIDE);
    }
    image m = {.width = SIDE, .height = SIDE};
    set_channel(&m, "B", EXR_PIXEL_FLOAT, b);
    set_channel(&m, "G", EXR_PIXEL_FLOAT, g);
    set_channel(&m, "R", EXR_PIXEL_FLOAT, r);
    for (int c = 0; c <= EXR_COMPRESSION_PIZ; c++) {
        ff_table t;
        m.compression = c;
        if (!read_ok("utia", write_image("utia.exr", &m), &t)) return;
        FF_CHECK(t.n == 82944 && t.n_channels == 3 && t.axes.kind == FF_AXES_INCIDENT_EXIT && !t.isotropic && t.n_negative == 1,
                 "utia: shape");
        FF_CHECK(strcmp(t.channels[0].name, "r") == 0 && strcmp(t.channels[2].name, "b") == 0, "utia: channels");
        const int line = 48 * 3 + 7, column = 48 * 5 + 20; /* theta_i 45, phi_i 52.5; theta_o 75, phi_o 150 */
        const size_t i = (size_t)(SIDE * line + column);
        FF_CHECK(t.angle[0][i] == 45 && t.angle[1][i] == 52.5 && t.angle[2][i] == 75 && t.angle[3][i] == 150, "utia: %g %g %g %g",
                 t.angle[0][i], t.angle[1][i], t.angle[2][i], t.angle[3][i]);
        FF_CHECK(t.value[i] == (double)i && t.value[t.n + i] == line && t.value[2 * t.n + i] == column, "utia: values");
        FF_CHECK(strstr(t.note, "UTIA") && strstr(t.note, "linear") && t.note_hint[1] == FF_HINT_SCALE, "utia: note '%s'", t.note);
        ff_table_clear(&t);
    }
    m.compression = 0;
    m.channel[0] = "A";
    check_fails("288 x 288 without B", write_image("no.exr", &m), NULL, FF_ERR_UNSUPPORTED, 0,
                WORDS("picture of 288 x 288", "UTIA", "CSV"));
    m.channel[0] = "B";
    m.width = 96;
    check_fails("a picture", write_image("no.exr", &m), NULL, FF_ERR_UNSUPPORTED, 0, WORDS("picture of 96 x 288", "docs/exr.md"));
}

/* ---- messages -------------------------------------------------------------------------------- */

static void fails_with(const char *label, const image *m, ff_status code, const char *const *words)
{
    check_fails(label, write_image("wrong.exr", m), NULL, code, 0, words);
}

static void test_attributes(void)
{
    static const struct {
        const char *attribute;
        int number;
        const char *text, *found;
    } wrong[] = {{"facetfit.version", 2, NULL, "found 2, expected 1"},
                 {"facetfit.version", -1, NULL, "found -1"},
                 {"facetfit.parametrisation", 0, "half", "found 'half', expected one of list, half-difference"},
                 {"facetfit.quantity", 0, "BRDF", "found 'BRDF', expected one of brdf"},
                 {"facetfit.angle_unit", 0, "degrees", "found 'degrees', expected one of degree, radian"},
                 {"facetfit.value_unit", 0, "sr", "found 'sr', expected 1/sr"},
                 {"facetfit.isotropic", 7, NULL, "found 7, expected 0 to 1"},
                 {"facetfit.samples", 0, NULL, "found 0, expected 1 to"},
                 {"facetfit.samples", 5, NULL, "found an image of 2 x 2 pixels, expected the 5 samples"},
                 {"facetfit.wavelengths", 0, "465 500", "expected a number > 0 or '-' for each of the 1 channels"},
                 {"facetfit.wavelengths", 0, "", "expected a number"},
                 {"facetfit.wavelengths", 0, "blue", "expected a number"},
                 {"facetfit.wavelengths", 0, "-5", "expected a number"},
                 {"facetfit.parametrisation", 0, "merl", "found 3 samples, expected the 1458000 of the MERL grid"},
                 {"facetfit.parametrisation", 0, "specular", "found no attribute 'facetfit.rotation'"}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        image m = list_image();
        const int a = index_of(&m, wrong[k].attribute);
        m.attribute[a].number = wrong[k].number;
        m.attribute[a].text = wrong[k].text;
        fails_with(wrong[k].attribute, &m, FF_ERR_FORMAT, WORDS(wrong[k].found));
    }
    static const char *const needed[] = {"parametrisation", "quantity", "angle_unit", "value_unit", "isotropic",
                                         "samples",         "channels", "planes",     "wavelengths"};
    for (size_t k = 0; k < sizeof needed / sizeof needed[0]; k++) {
        image m = list_image();
        char full[64], expected[96];
        snprintf(full, sizeof full, "facetfit.%s", needed[k]);
        m.attribute[index_of(&m, full)].name = "other";
        snprintf(expected, sizeof expected, "found no attribute '%s'", full);
        fails_with(needed[k], &m, FF_ERR_FORMAT, WORDS(expected));
        m = list_image();
        m.attribute[index_of(&m, full)].kind = m.attribute[index_of(&m, full)].kind == 'i' ? 's' : 'i';
        m.attribute[index_of(&m, full)].text = "1";
        fails_with(needed[k], &m, FF_ERR_FORMAT, WORDS(full, "found the type", "expected"));
    }
    image m = list_image();
    set_vector(&m, "facetfit.x", "a", "b");
    m.attribute[index_of(&m, "facetfit.planes")].vector[1] = "weight";
    fails_with("planes", &m, FF_ERR_FORMAT, WORDS("facetfit.planes", "found 2 names, expected 1"));
    m.attribute[index_of(&m, "facetfit.channels")].vector[1] = "465nm";
    fails_with("doubled", &m, FF_ERR_FORMAT, WORDS("found channel '465nm' twice"));
    m = list_image();
    m.attribute[index_of(&m, "facetfit.planes")].vector[0] = "466nm";
    fails_with("plane", &m, FF_ERR_FORMAT, WORDS("found the channels 465nm, direction.phi_i", "expected '466nm'", "'466nm.high'"));
    m = list_image();
    m.channel[3] = "direction.theta_j";
    fails_with("no theta_i", &m, FF_ERR_FORMAT, WORDS("expected 'direction.theta_i'"));
    m = list_image();
    m.type[0] = EXR_PIXEL_UINT;
    fails_with("integers", &m, FF_ERR_FORMAT, WORDS("expected '465nm' of floating point"));
}

static void axes_attributes(void)
{
    static const char *const axis[4] = {"facetfit.theta_i", "facetfit.phi_i", "facetfit.theta_o", "facetfit.phi_o"};
    static const struct {
        const char *text, *found;
    } wrong[] = {{"1 2", "axes of 2 x 1 x 3 x 1 nodes, expected 3 samples"},
                 {"", "found no number, expected the nodes"},
                 {"nan", "nan"},
                 {"1e999", "1e999"}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        image m = list_image();
        m.attribute[index_of(&m, "facetfit.parametrisation")].text = "incident-exit";
        set_text(&m, axis[0], wrong[k].text);
        set_text(&m, axis[1], "0");
        set_text(&m, axis[2], "10 20.25 1e1");
        set_text(&m, axis[3], "180");
        check_fails(wrong[k].text, write_image("axes.exr", &m), NULL, k < 2 ? FF_ERR_FORMAT : FF_ERR_DATA, 0,
                    WORDS(wrong[k].found));
        m.attribute[m.n_attributes - 4].text = "  7 ";
        ff_table t;
        if (!read_ok("axes", write_image("axes.exr", &m), &t)) continue;
        FF_CHECK(t.axes.kind == FF_AXES_INCIDENT_EXIT && t.angle[0][2] == 7 && t.angle[2][1] == 20.25 && t.angle[3][0] == 180,
                 "axes");
        ff_table_clear(&t);
    }
}

static void test_pixels(void)
{
    const float kept[4] = {list_r[1], list_s[1], list_w[1], list_angle[2][1]};
    image m = list_image();
    list_r[1] = INFINITY;
    fails_with("infinity", &m, FF_ERR_DATA, WORDS("channel '465nm', pixel (1, 0): found inf, expected a finite number"));
    list_r[1] = kept[0];
    list_s[1] = 0;
    fails_with("sigma", &m, FF_ERR_DATA, WORDS("channel 'sigma.465nm', pixel (1, 0): found 0, expected a standard deviation > 0"));
    list_s[1] = NAN;
    fails_with("sigma", &m, FF_ERR_DATA, WORDS("'sigma.465nm'", "found nan"));
    list_s[1] = kept[1];
    list_w[1] = -2;
    fails_with("weight", &m, FF_ERR_DATA, WORDS("channel 'weight', pixel (1, 0): found -2, expected a weight >= 0"));
    list_w[1] = kept[2];
    list_angle[2][1] = NAN;
    fails_with("angle", &m, FF_ERR_DATA, WORDS("'direction.theta_o', pixel (1, 0): found nan"));
    list_angle[2][1] = kept[3];
    static float none[4] = {NAN, NAN, NAN, NAN};
    m.pixels[0] = none;
    fails_with("nothing", &m, FF_ERR_DATA, WORDS("all of them marked as not measured"));
}

static void refusals(void)
{
    ff_table t;
    ff_error err = {0};
    const char *path = ff_test_path("refused.exr");
    if (ff_table_init(4, 2, NULL, 1, 0, &t, &err) != FF_OK) exit(1);
    for (int k = 0; k < 8; k++) t.value[k] = 1, t.sigma[k] = 1;
    static const struct {
        double value, sigma;
        ff_status code;
        const char *words;
    } wrong[] = {{1e39, 1, FF_ERR_UNSUPPORTED, "plane 'c0', sample 2: found 1e+39, expected at most 3.4e38"},
                 {1, 1e-60, FF_ERR_UNSUPPORTED, "plane 'sigma.c0', sample 2: found 1e-60"},
                 {1, 0, FF_ERR_DATA, "expected"},
                 {NAN, 1, FF_ERR_DATA, "finite"}};
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        t.value[2] = wrong[k].value;
        t.sigma[2] = wrong[k].sigma;
        const ff_status status = ff_table_write(path, NULL, &t, &err);
        FF_CHECK(status == wrong[k].code && strstr(err.message, wrong[k].words), "%zu: %d %s", k, status, err.message);
    }
    t.value[2] = t.sigma[2] = 1;
    name(&t, 1, "c0", NAN);
    FF_CHECK(ff_table_write(path, NULL, &t, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "a name of its own"), "%s",
             err.message);
    name(&t, 1, "c1", NAN);
    FF_CHECK(ff_table_write("/nowhere/x.exr", NULL, &t, &err) == FF_ERR_WRITE, "%s", err.message);
    FF_CHECK(access("/dev/full", W_OK) != 0 || ff_table_write("/dev/full", "exr", &t, &err) == FF_ERR_WRITE, "/dev/full: %s",
             err.message);
    FF_CHECK(access(path, F_OK) != 0 && check_leftovers() == 0, "something was left behind");
    ff_table_clear(&t);
}

/* Runs a command beside the test; both ends of a named pipe wait for each other when they open it. A command whose other end never
 * comes ends by itself. */
static FILE *start_beside(const char *format, const char *a, const char *b)
{
    char command[800];
    snprintf(command, sizeof command, format, a, b);
    FILE *started = popen(command, "r");
    if (!started) exit(1);
    return started;
}

/* A pipe has no positions: the image is made beside it, and read whole. The program at its other end is waited for: while it still
 * reads, it would take what the next one writes, and nothing would be left to read here. */
static void test_pipe(void)
{
    image m = list_image();
    const char *path = write_image("list.exr", &m);
    ff_table t;
    ff_error err = {0};
    const char *pipe_path = ff_test_path("pipe"), *copy = ff_test_path("copy.exr");
    if (!read_ok("pipe", path, &t)) return;
    if (mkfifo(pipe_path, 0600) != 0) exit(1);
    FILE *other_end = start_beside("exec timeout 60 cat '%s' > '%s'", pipe_path, copy);
    FF_CHECK(ff_table_write(pipe_path, "exr", &t, &err) == FF_OK, "to a pipe: %s", err.message);
    FF_CHECK(pclose(other_end) == 0, "the reader of the pipe failed");
    ff_table_clear(&t);
    check_list("written to a pipe", copy);
    other_end = start_beside("exec timeout 60 cat '%s' > '%s'", path, pipe_path);
    if (FF_CHECK(ff_table_read_into(pipe_path, "exr", &t, &err) == FF_OK, "from a pipe: %s", err.message)) {
        FF_CHECK(t.n == 3 && t.value[1] == 2, "from a pipe");
        ff_table_clear(&t);
    }
    FF_CHECK(pclose(other_end) == 0, "the writer of the pipe failed");
}

/* ---- damaged files --------------------------------------------------------------------------- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* An error that says where, or a table that can be written; within a second. */
static ff_status check_sane(const char *label, const char *path)
{
    ff_table t;
    ff_error err = {0};
    const double begin = now();
    const ff_status status = ff_table_read_into(path, "exr", &t, &err);
    FF_CHECK(now() - begin < 1, "%s: took %g s", label, now() - begin);
    if (status != FF_OK) {
        FF_CHECK(err.code == status && err.message[0] && strcmp(err.path, path) == 0, "%s: an error without words", label);
        return status;
    }
    FF_CHECK(ff_table_write("/dev/null", "csv", &t, &err) == FF_OK, "%s: a table that is none: %s", label, err.message);
    ff_table_clear(&t);
    return status;
}

static void truncated(void)
{
    for (int c = 0; c <= EXR_COMPRESSION_B44A; c++) {
        image m = list_image();
        m.compression = c;
        size_t n;
        char *bytes = ff_test_slurp(write_image("whole.exr", &m), &n), label[96];
        const char *path = ff_test_path("cut.exr");
        for (size_t k = 0; k < n; k++) {
            snprintf(label, sizeof label, "compression %d, first %zu of %zu bytes", c, k, n);
            ff_test_write(path, bytes, k);
            FF_CHECK(check_sane(label, path) != FF_OK, "%s: read", label);
        }
        bytes = realloc(bytes, n + 1);
        bytes[n] = 0;
        ff_test_write(path, bytes, n + 1);
        FF_CHECK(check_sane("trailing", path) == FF_ERR_FORMAT, "compression %d: a trailing byte", c);
        free(bytes);
    }
}

static void flips(void)
{
    static const int compressions[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_ZIP, EXR_COMPRESSION_PIZ};
    for (int c = 0; c < 3; c++) {
        image m = list_image();
        m.compression = compressions[c];
        size_t n, read = 0;
        char *bytes = ff_test_slurp(write_image("whole.exr", &m), &n), label[96];
        const char *path = ff_test_path("flip.exr");
        for (size_t bit = 0; bit < 8 * n; bit++) {
            bytes[bit / 8] = (char)(bytes[bit / 8] ^ 1 << bit % 8);
            snprintf(label, sizeof label, "compression %d, bit %zu", compressions[c], bit);
            ff_test_write(path, bytes, n);
            read += check_sane(label, path) == FF_OK;
            bytes[bit / 8] = (char)(bytes[bit / 8] ^ 1 << bit % 8);
        }
        FF_CHECK(read < 8 * n, "every flip was read");
        free(bytes);
    }
}

static size_t find_bytes(const char *bytes, size_t n, const char *word, size_t length)
{
    const char *p = memmem(bytes, n, word, length);
    if (!p) exit(1);
    return (size_t)(p - bytes);
}

static void put32(char *to, uint32_t v)
{
    for (int k = 0; k < 4; k++) to[k] = (char)(v >> 8 * k);
}

static void hostile(const char *label, const image *m, const char *word, size_t length, size_t offset, uint32_t value,
                    ff_status code, int64_t byte, const char *words)
{
    size_t n;
    char *bytes = ff_test_slurp(write_image("whole.exr", m), &n);
    const char *path = ff_test_path("hostile.exr");
    const size_t at = word ? find_bytes(bytes, n, word, length) + length + offset : offset;
    put32(bytes + at, value);
    ff_test_write(path, bytes, n);
    ff_table t;
    ff_error err = {0};
    const ff_status status = ff_table_read_into(path, "exr", &t, &err);
    FF_CHECK(status == code && strstr(err.message, words), "%s: %d %s", label, status, err.message);
    if (byte == -2) byte = (int64_t)at;
    if (byte >= 0) FF_CHECK(err.byte == byte, "%s: byte %lld, expected %lld", label, (long long)err.byte, (long long)byte);
    if (status == FF_OK) ff_table_clear(&t);
    free(bytes);
}

static void test_hostile(void)
{
    image m = list_image(), z = list_image();
    z.compression = EXR_COMPRESSION_ZIP;
    static const char window[] = "dataWindow\0box2i\0\x10\0\0", compression[] = "compression\0compression\0\1\0\0",
                      channels[] = "channels\0chlist\0";
    hostile("magic", &m, NULL, 0, 0, 7, FF_ERR_FORMAT, 0, "expected 76 2f 31 01");
    hostile("version", &m, NULL, 0, 4, 3, FF_ERR_UNSUPPORTED, 4, "expected version 2");
    hostile("tiles", &m, NULL, 0, 4, 0x202, FF_ERR_UNSUPPORTED, 4, "found an image of tiles");
    hostile("deep", &m, NULL, 0, 4, 0x802, FF_ERR_UNSUPPORTED, 4, "found an image of deep pixels");
    hostile("parts", &m, NULL, 0, 4, 0x1002, FF_ERR_UNSUPPORTED, 4, "found an image of several parts");
    hostile("window", &m, window, sizeof window, 8, 0x7FFFFFFF, FF_ERR_FORMAT, -1, "found a data window");
    hostile("window", &m, window, sizeof window, 0, 0x80000000, FF_ERR_FORMAT, -1, "found a data window");
    hostile("empty window", &m, window, sizeof window, 8, (uint32_t)-5, FF_ERR_FORMAT, -1, "found a data window");
    hostile("wide", &m, window, sizeof window, 8, 0x1FFFFFF0, FF_ERR_UNSUPPORTED, -1, "found lines of");
    hostile("high", &m, window, sizeof window, 12, 0x1FFFFFF0, FF_ERR_READ, -1, "expected all lines");
    hostile("wide zip", &z, window, sizeof window, 8, 1 << 20, FF_ERR_FORMAT, -1, "expected");
    hostile("high zip", &z, window, sizeof window, 12, 1 << 28, FF_ERR_READ, -1, "expected all lines");
    hostile("compression", &m, compression, sizeof compression, 0, 0x746164AA, FF_ERR_UNSUPPORTED, -1, "found the compression 170");
    hostile("channels", &m, channels, sizeof channels - 1, 0, 0x7FFFFFFF, FF_ERR_READ, -2,
            "found an attribute of 2147483647 bytes");
    hostile("channels", &m, channels, sizeof channels - 1, 0, 0xFFFFFFFF, FF_ERR_READ, -2,
            "found an attribute of 4294967295 bytes");
    hostile("pixel type", &m, "465nm", 6, 0, 3, FF_ERR_FORMAT, -1, "channel 1: expected the type");
    hostile("sampling", &m, "465nm", 6, 8, 2, FF_ERR_FORMAT, -1, "channel 1: expected as many pixels");
    hostile("order", &m, "direction.phi_i", 10, 0, 0x7A7A7A7A, FF_ERR_FORMAT, -1, "expected a name of its own");

    size_t n;
    char *bytes = ff_test_slurp(write_image("whole.exr", &m), &n);
    const size_t chunks = n - 2 * (8 + 7 * 8), table = chunks - 16;
    free(bytes);
    hostile("offset", &m, NULL, 0, table + 4, 0x7FFFFFFF, FF_ERR_READ, -1, "found chunk 0 of the image at byte");
    hostile("offset", &m, NULL, 0, table + 8, 0, FF_ERR_READ, -1, "found chunk 1 of the image at byte 0");
    hostile("line", &m, NULL, 0, chunks, 77, FF_ERR_FORMAT, -2, "found a chunk of line 77, expected line 0");
    hostile("size", &m, NULL, 0, chunks + 4, 0x7FFFFFFF, FF_ERR_FORMAT, -2, "found a chunk of 2147483647 bytes, expected 56");
    hostile("size", &m, NULL, 0, chunks + 4, 55, FF_ERR_FORMAT, -2, "found a chunk of 55 bytes, expected 56");
    hostile("size", &m, NULL, 0, chunks + 4, (uint32_t)-1, FF_ERR_FORMAT, -2, "found a chunk of -1 bytes");
    struct rusage use;
    getrusage(RUSAGE_SELF, &use);
    printf("largest resident set %ld MiB\n", use.ru_maxrss / 1024);
}

/* Small files for the fuzzers: tests/fuzz/corpus/exr is what this writes. */
static int write_corpus(const char *dir)
{
    static const struct {
        const char *name, *attribute, *text;
        int compression;
    } files[] = {{"list.exr", NULL, NULL, EXR_COMPRESSION_NONE},
                 {"list-zip.exr", NULL, NULL, EXR_COMPRESSION_ZIP},
                 {"list-piz.exr", NULL, NULL, EXR_COMPRESSION_PIZ},
                 {"list-pxr24.exr", NULL, NULL, EXR_COMPRESSION_PXR24},
                 {"axes.exr", "facetfit.parametrisation", "half-difference", EXR_COMPRESSION_NONE},
                 {"cosine.exr", "facetfit.quantity", "brdf-cos", EXR_COMPRESSION_RLE},
                 {"wrong-version.exr", "facetfit.version", NULL, EXR_COMPRESSION_NONE}};
    for (size_t k = 0; k < sizeof files / sizeof files[0]; k++) {
        image m = list_image();
        char path[512];
        size_t n;
        m.compression = files[k].compression;
        if (files[k].attribute) m.attribute[index_of(&m, files[k].attribute)].text = files[k].text;
        if (files[k].attribute) m.attribute[index_of(&m, files[k].attribute)].number = 2;
        static const char *const axis[4] = {"facetfit.theta_h", "facetfit.phi_h", "facetfit.theta_d", "facetfit.phi_d"};
        for (int j = 0; j < 4 && strcmp(files[k].name, "axes.exr") == 0; j++) set_text(&m, axis[j], j ? "45" : "10 20.5 30");
        char *bytes = ff_test_slurp(write_image("corpus.exr", &m), &n);
        snprintf(path, sizeof path, "%s/%s", dir, files[k].name);
        ff_test_write(path, bytes, n);
        free(bytes);
    }
    return 0;
}

static const ff_test_case cases[] = {
    FF_TEST(test_list),       FF_TEST(types),           FF_TEST(test_quantity), FF_TEST(test_compressions),
    FF_TEST(test_attributes), FF_TEST(axes_attributes), FF_TEST(test_pixels),   FF_TEST(test_utia),
    FF_TEST(truncated),       FF_TEST(flips),           FF_TEST(test_hostile),  FF_TEST(round_trips),
    FF_TEST(test_layouts),    FF_TEST(refusals),        FF_TEST(test_pipe),     FF_TEST(test_merl)};

int main(int argc, char **argv)
{
    if (argc == 3 && strcmp(argv[1], "--corpus") == 0) return write_corpus(argv[2]);
    return ff_test_main(cases, sizeof cases / sizeof *cases, argc, argv);
}
