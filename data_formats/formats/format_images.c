/* Image stacks: a CSV that lists one image per pair of directions; every image becomes one sample. OpenImageIO reads the images.
 *
 *     # facetfit-images: 1               comment lines before the header; all optional
 *     # quantity: brdf                   brdf, brdf-cos, reflectance-factor: what a pixel stands for, after scale and exposure
 *     # angles: degrees                  or radians
 *     # isotropic: no                    yes: only azimuth differences mean something. Not said: when there is but one phi_i
 *     # encoding: srgb                   linear, srgb, rec709 or gamma:2.2, instead of what the images say
 *     # region: 100,80,256,256           x, y, width, height in pixels from the upper left corner, of all images
 *     image,theta_i,phi_i,theta_o,phi_o,scale,exposure,mask,x,y,width,height
 *     shots/a 001.png,30,0,30,180,1,0.01,,,,,
 *
 * image                 path, relative to the CSV
 * theta_i ... phi_o     directions to the light and to the camera, as in the other CSV
 * scale                 factor on the pixels, > 0
 * exposure              time, > 0: pixels are divided by it
 * mask                  image of the same size; pixels whose first channel is above 1/2 count. Empty: all
 * x, y, width, height   region of this image; empty: the one of the comment, else the whole image
 *
 * The value of a sample is the mean of the linear pixels in the region and the mask, per channel. Its sigma is the standard
 * deviation of these pixels, s^2 = sum (v - mean)^2 / (n - 1), and never less than that of rounding to the integers of the file:
 * what one place of the surface differs from the next, and the noise of a pixel. It is not the standard error of the mean, s /
 * sqrt(n): pixels share the errors of the lamp, of the lens and of a texture larger than a pixel, so that their number says little
 * about the mean. A data set with an image of one pixel, or of equal pixels of a floating-point format, has no sigmas.
 *
 * Linear light is required. What the file says goes (sRGB, Rec. 709, an exponent, linear); OpenImageIO takes 8-bit formats that do
 * not say it for sRGB. Floating-point images that do not say are linear; integers that do not say are refused without `encoding`.
 */
#define _GNU_SOURCE
#include "data_formats/formats/images/internal_stack.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

/* ---- recognising it -------------------------------------------------------------------------- */

static int is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

static int has_image_column(const char *p, const char *stop)
{
    while (p < stop) {
        const char *comma = memchr(p, ',', (size_t)(stop - p)), *end = comma ? comma : stop;
        const char *a = p, *b = end;
        while (a < b && (is_blank(*a) || *a == '"')) a++;
        while (a < b && (is_blank(b[-1]) || b[-1] == '"')) b--;
        if (b - a == 5 && memcmp(a, "image", 5) == 0) return 1;
        p = end + 1;
    }
    return 0;
}

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    if (memchr(head, '\0', n)) return 0;
    const char *p = (const char *)head, *stop = p + n;
    while (p < stop) {
        const char *newline = memchr(p, '\n', (size_t)(stop - p)), *end = newline ? newline : stop;
        if (memmem(p, (size_t)(end - p), "# facetfit-images:", 18)) return 100;
        while (p < end && is_blank(*p)) p++;
        const int comment = p < end && (*p == '#' || (*p == '"' && p + 1 < end && p[1] == '#'));
        if (p < end && !comment) return has_image_column(p, end) ? 96 : 0;
        p = end + 1;
    }
    return 0;
}

/* ---- lines ----------------------------------------------------------------------------------- */

static ff_status find_reader(ff_image_stack *f)
{
    ff_error inner = {0};
    const ff_status status = ff_image_reader_get(&f->reader, &inner);
    if (status == FF_OK) return FF_OK;
    return ff_error_set(f->err, status, f->path, f->lines.line, -1, "%.700s", inner.message);
}

static ff_status read_line(ff_image_stack *f, char *text)
{
    const size_t n = ff_stack_cut_cells(f, text);
    if (n != f->n_cells)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "found %zu cells, expected %zu, one per column", n,
                            f->n_cells);
    double v[FF_STACK_NUMBERS];
    if (*ff_stack_cell(f, FF_STACK_IMAGE) == '\0') return ff_stack_bad_cell(f, FF_STACK_IMAGE, "the path of an image");
    ff_status status = ff_stack_read_numbers(f, v);
    if (status == FF_OK && !f->reader) status = find_reader(f);
    ff_image_shot *s = status == FF_OK ? calloc(1, sizeof *s) : NULL;
    if (status != FF_OK) return status;
    if (!s) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for an image");
    s->f = f;
    status = ff_stack_read_shot(s, v);
    f->reader->close(s->image);
    f->reader->close(s->mask);
    free(s);
    return status;
}

static ff_status read_lines(ff_image_stack *f)
{
    char *text;
    size_t length;
    for (;;) {
        ff_status status = ff_stack_next_line(f, &text, &length);
        if (status == FF_OK && text) status = read_line(f, text);
        if (status != FF_OK) return status;
        if (text) continue;
        if (f->rows.n) return FF_OK;
        return ff_error_set(f->err, FF_ERR_DATA, f->path, f->lines.line, -1,
                            "found no rows after the header, expected at least one image");
    }
}

/* ---- the table ------------------------------------------------------------------------------- */

static void note_light(const ff_image_stack *f, ff_table *t)
{
    static const char *const name[] = {NULL, "linear", "sRGB", "Rec. 709", "a power"};
    for (int k = FF_CURVE_LINEAR; k <= FF_CURVE_GAMMA; k++)
        if (f->n_curve[k] && f->said.curve)
            ff_table_note(t, "the images are read as %s, as the CSV says", name[k]);
        else if (f->n_curve[k] && k != FF_CURVE_LINEAR)
            ff_table_note(t, "%zu images are %s, as their files say or their format is used, and were made linear", f->n_curve[k],
                          name[k]);
    if (f->n_linear_by_default)
        ff_table_note(t, "%zu floating-point images do not say how they encode light: they are taken to be linear",
                      f->n_linear_by_default);
}

static void note_all(const ff_image_stack *f, const ff_read_options *o, ff_table *t)
{
    if (f->pixels_least == f->pixels_most)
        ff_table_note(t, "each value is the mean of %.0f pixels", f->pixels_most);
    else
        ff_table_note(t, "each value is the mean of %.0f to %.0f pixels", f->pixels_least, f->pixels_most);
    if (f->no_sigma)
        ff_table_note(t, "there are no standard deviations: an image has but one pixel, or equal ones");
    else
        ff_table_note(t, "a standard deviation is that of the pixels of an image, not that of their mean");
    note_light(f, t);
    if (f->n_saturated > 0)
        ff_table_note(t, "%.0f of %.0f pixels in %zu images are saturated: their values are too low", f->n_saturated, f->n_pixels,
                      f->n_saturated_images);
    if (f->n_with_alpha) ff_table_note(t, "the channel alpha of %zu images was left out", f->n_with_alpha);
    if (f->column[FF_STACK_SCALE] < 0 && isnan(o->scale))
        ff_table_note(t, "no scale is given: pixels%s are taken to be calibrated",
                      f->column[FF_STACK_EXPOSURE] >= 0 ? " over their exposure" : "");
}

static int has_channel(const ff_image_stack *f, const char *name)
{
    for (size_t c = 0; c < f->n_channels; c++)
        if (strcmp(f->first.name[c], name) == 0) return 1;
    return 0;
}

/* R, G, B become r, g, b. */
static void name_channels(const ff_image_stack *f, ff_table *t)
{
    static const char *const rgb[2][3] = {{"R", "G", "B"}, {"r", "g", "b"}};
    for (size_t c = 0; c < f->n_channels; c++) {
        const char *name = f->first.name[c];
        for (int k = 0; k < 3; k++)
            if (strcmp(name, rgb[0][k]) == 0 && !has_channel(f, rgb[1][k])) name = rgb[1][k];
        ff_channel *to = &t->channels[c];
        to->wavelength_nm = ff_wavelength_of(name);
        if (f->n_channels == 1 && isnan(to->wavelength_nm)) name = "f";
        snprintf(to->name, sizeof to->name, "%s", name);
    }
}

static ff_status make_table_of(ff_image_stack *f, const ff_read_options *o, ff_table *out)
{
    ff_table t;
    ff_status status = ff_rows_to_table(&f->rows, f->n_channels, 1, 0, &t, f->err);
    if (status != FF_OK) return status;
    strcpy(t.format, "images");
    t.radians_per_unit = f->radians_per_unit;
    name_channels(f, &t);
    if (f->no_sigma) {
        free(t.sigma);
        t.sigma = NULL;
    }
    t.isotropic = f->isotropic >= 0 ? f->isotropic : ff_table_one_incidence_azimuth(&t);
    note_all(f, o, &t);
    if (f->lines.unterminated) ff_table_note(&t, "the last line has no end-of-line: if the file was cut, so was its last cell");
    ff_table_set_quantity(&t, ff_read_quantity(o, f->quantity < 0 ? FF_BRDF : (ff_quantity)f->quantity));
    status = ff_table_count(&t, f->path, f->err);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

static ff_status read_images(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_image_stack *f = calloc(1, sizeof *f);
    if (!f) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for an image stack");
    *f = (ff_image_stack){.err = err, .path = path, .options = o, .quantity = -1, .isotropic = -1, .radians_per_unit = degree};
    for (int c = 0; c < FF_STACK_COLUMNS; c++) f->column[c] = -1;
    ff_status status = ff_lines_open(path, &f->lines, err);
    if (status == FF_OK) {
        status = ff_stack_read_header(f);
        if (status == FF_OK) status = read_lines(f);
        if (status == FF_OK) status = make_table_of(f, o, out);
        ff_lines_close(&f->lines);
    }
    free(f->cell);
    free(f->curve_table);
    ff_rows_free(&f->rows);
    free(f);
    return status;
}

const ff_format ff_format_images = {
    .name = "images",
    .title = "Image stack: a CSV that lists one image per pair of directions, each reduced to its mean and spread",
    .extensions = ".csv",
    .source = "this format; images through OpenImageIO",
    .probe = probe,
    .reads = FF_READS_QUANTITY,
    .read = read_images,
};
