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
#include "data_formats/formats/images/internal_image_check.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include "data_formats/formats/images/oiio_bridge.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

enum { THETA_I, PHI_I, THETA_O, PHI_O, SCALE, EXPOSURE, X, Y, WIDTH, HEIGHT, N_NUMBERS, IMAGE = N_NUMBERS, MASK, N_COLUMNS };
static const char *const column_name[N_COLUMNS] = {"theta_i", "phi_i", "theta_o", "phi_o",  "scale", "exposure",
                                                   "x",       "y",     "width",   "height", "image", "mask"};
static const char *const quantity_name[3] = {"brdf", "brdf-cos", "reflectance-factor"};

/* How numbers of a file become light. */
typedef enum curve { CURVE_UNKNOWN, CURVE_LINEAR, CURVE_SRGB, CURVE_REC709, CURVE_GAMMA } curve;
typedef struct encoding {
    curve curve;
    double gamma;
} encoding;

typedef struct images {
    ff_lines lines;
    ff_error *err;
    const char *path;
    const ff_read_options *options;
    int quantity, isotropic; /* -1 = not said */
    double radians_per_unit;
    encoding said; /* by the comment */
    double region[4];
    int with_region;
    long column[N_COLUMNS]; /* where it stands, -1 = not there */
    size_t n_cells;
    char **cell; /* [n_cells] of the line, into its text */
    char first_image[FF_QUOTE];
    ff_image_info first; /* what all images have to agree with */
    size_t n_channels;   /* without alpha */
    const ff_image_reader *reader;
    ff_rows rows;
    double *curve_table; /* [2^bits] light of the integers */
    encoding table_of;
    int table_bits;
    /* for the notes */
    size_t n_images, n_saturated_images, n_linear_by_default, n_with_alpha;
    double pixels_least, pixels_most, n_saturated, n_pixels;
    size_t n_curve[CURVE_GAMMA + 1];
    int no_sigma;
} images;

/* One image on its way to a sample. */
typedef struct shot {
    images *f;
    char path[4096];
    char quoted[FF_QUOTE];
    ff_image *image, *mask;
    ff_image_info info, mask_info;
    encoding encoding;
    long x, y, width, height;                                      /* region */
    size_t channel[FF_IMAGE_CHANNELS];                             /* of the file, without alpha */
    double n, mean[FF_IMAGE_CHANNELS], squares[FF_IMAGE_CHANNELS]; /* squares: sum (v - mean)^2 */
    double saturated;
} shot;

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

/* ---- comments -------------------------------------------------------------------------------- */

static ff_status bad_comment(const images *f, const char *key, const char *found, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "'# %s:': found %s, expected %s", key,
                        ff_quote(found, strlen(found), quoted), expected);
}

static ff_status set_version(images *f, const char *key, const char *value)
{
    return strcmp(value, "1") == 0 ? FF_OK : bad_comment(f, key, value, "version 1");
}

static ff_status set_quantity(images *f, const char *key, const char *value)
{
    for (int q = 0; q < 3; q++)
        if (strcasecmp(value, quantity_name[q]) == 0) {
            f->quantity = q;
            return FF_OK;
        }
    return bad_comment(f, key, value, "brdf, brdf-cos or reflectance-factor");
}

static ff_status set_angles(images *f, const char *key, const char *value)
{
    if (strcasecmp(value, "degrees") != 0 && strcasecmp(value, "radians") != 0)
        return bad_comment(f, key, value, "degrees or radians");
    f->radians_per_unit = strcasecmp(value, "radians") == 0 ? 1 : degree;
    return FF_OK;
}

static ff_status set_isotropic(images *f, const char *key, const char *value)
{
    if (strcasecmp(value, "yes") != 0 && strcasecmp(value, "no") != 0) return bad_comment(f, key, value, "yes or no");
    f->isotropic = strcasecmp(value, "yes") == 0;
    return FF_OK;
}

static int gamma_is_right(double gamma)
{
    return gamma >= 0.1 && gamma <= 10;
}

/* The curve that a word names; CURVE_UNKNOWN for others. The words are those of OpenImageIO and of people. */
static encoding encoding_of(const char *word)
{
    encoding e = {CURVE_UNKNOWN, 1};
    if (strcasecmp(word, "linear") == 0 || strcasecmp(word, "scene_linear") == 0 || strncasecmp(word, "lin_", 4) == 0)
        e.curve = CURVE_LINEAR;
    else if (strcasecmp(word, "srgb") == 0)
        e.curve = CURVE_SRGB;
    else if (strcasecmp(word, "rec709") == 0)
        e.curve = CURVE_REC709;
    else if (strncasecmp(word, "gamma", 5) == 0) {
        const char *end = ff_number_read(word + 5 + (word[5] == ':'), &e.gamma);
        if (end && *end == '\0' && gamma_is_right(e.gamma)) e.curve = e.gamma == 1 ? CURVE_LINEAR : CURVE_GAMMA;
    }
    return e;
}

static ff_status set_encoding(images *f, const char *key, const char *value)
{
    f->said = encoding_of(value);
    return f->said.curve ? FF_OK : bad_comment(f, key, value, "linear, srgb, rec709 or gamma:EXPONENT");
}

static int is_whole(double v, double least)
{
    return v >= least && v <= 1e9 && v == floor(v);
}

static ff_status set_region(images *f, const char *key, const char *value)
{
    const char *p = value;
    for (int k = 0; k < 4; k++) {
        const char *end = ff_number_read(p + strspn(p, " \t"), &f->region[k]);
        if (end) end += strspn(end, " \t");
        if (!end || *end != (k < 3 ? ',' : '\0') || !is_whole(f->region[k], k < 2 ? 0 : 1))
            return bad_comment(f, key, value, "x,y,width,height: whole numbers of pixels");
        p = end + 1;
    }
    f->with_region = 1;
    return FF_OK;
}

/* "# key: value"; other comments say nothing to us. */
static ff_status read_comment(images *f, char *text)
{
    static const struct {
        const char *key;
        ff_status (*set)(images *, const char *, const char *);
    } known[] = {{"quantity", set_quantity}, {"angles", set_angles},           {"isotropic", set_isotropic},
                 {"encoding", set_encoding}, {"facetfit-images", set_version}, {"region", set_region}};
    char *key = text + strspn(text, "# \t"), *colon = strchr(key, ':');
    if (!colon) return FF_OK;
    char *value = colon + 1 + strspn(colon + 1, " \t"), *end = value + strlen(value);
    while (end > value && strchr(", \t\"", end[-1])) end--; /* commas at the end are what a spreadsheet adds */
    *end = '\0';
    for (*colon-- = '\0'; colon >= key && (*colon == ' ' || *colon == '\t'); colon--) *colon = '\0';
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++) {
        if (strcasecmp(key, known[k].key) != 0) continue;
        if (f->n_cells)
            return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1,
                                "found '# %s:' after the header, expected it before", known[k].key);
        return known[k].set(f, known[k].key, value);
    }
    return FF_OK;
}

/* The next line that is neither blank nor a comment; *text is NULL at the end. */
static ff_status next_line(images *f, char **text, size_t *length)
{
    for (;;) {
        ff_status s = ff_lines_next(&f->lines, text, length, f->err);
        if (s != FF_OK || !*text) return s;
        char *start = *text + strspn(*text, " \t");
        if (*start == '"' && start[1] == '#') start++; /* a comment that a spreadsheet has quoted */
        if (*start == '#' && (s = read_comment(f, start)) != FF_OK) return s;
        if (*start != '#' && *start != '\0') return FF_OK;
    }
}

/* ---- header ---------------------------------------------------------------------------------- */

static ff_status bad_header(const images *f, const ff_names *names, const char *name, const char *why)
{
    char found[FF_NAMES_LIST], quoted[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "column %s %s; found the columns %s",
                        ff_quote(name, strlen(name), quoted), why, ff_names_list(names, found));
}

static ff_status place_columns(images *f, const ff_names *names)
{
    for (size_t k = 0; k < names->n; k++) {
        int c = 0;
        while (c < N_COLUMNS && strcmp(names->name[k], column_name[c]) != 0) c++;
        if (c == N_COLUMNS)
            return bad_header(f, names, names->name[k],
                              "is none of image, theta_i, phi_i, theta_o, phi_o, scale, exposure, mask, x, y, width, height");
        f->column[c] = (long)k;
    }
    static const int needed[] = {IMAGE, THETA_I, PHI_I, THETA_O, PHI_O};
    for (size_t k = 0; k < sizeof needed / sizeof needed[0]; k++)
        if (f->column[needed[k]] < 0) return bad_header(f, names, column_name[needed[k]], "is missing");
    for (int c = X; c <= HEIGHT; c++)
        if ((f->column[c] < 0) != (f->column[X] < 0))
            return bad_header(f, names, column_name[f->column[X] < 0 ? X : c], "is missing: a region has x, y, width and height");
    f->n_cells = names->n;
    f->cell = calloc(names->n, sizeof *f->cell);
    return f->cell ? FF_OK : ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for %zu columns", names->n);
}

static ff_status read_header(images *f)
{
    char *text;
    size_t length;
    ff_names names;
    ff_status s = next_line(f, &text, &length);
    if (s != FF_OK) return s;
    if (!text)
        return ff_error_set(f->err, FF_ERR_READ, f->path, f->lines.line, -1,
                            "found the end of the file, expected a header line image,theta_i,phi_i,theta_o,phi_o");
    s = ff_names_read(text, length, f->path, f->lines.line, &names, f->err);
    if (s != FF_OK) return s;
    s = place_columns(f, &names);
    ff_names_free(&names);
    return s;
}

/* ---- cells ----------------------------------------------------------------------------------- */

/* Cuts a line at its commas, in place; quotes around a cell are dropped, "" inside them is one. Returns the number of cells. */
static size_t cut_cells(images *f, char *p)
{
    size_t n = 0;
    for (;;) {
        p += strspn(p, " \t");
        char *start = p, *to = p;
        if (*p == '"') {
            for (p++; *p && (*p != '"' || p[1] == '"'); p++) {
                if (*p == '"') p++;
                *to++ = *p;
            }
            p += strcspn(p, ",");
        } else {
            while (*p && *p != ',') *to++ = *p++;
            while (to > start && (to[-1] == ' ' || to[-1] == '\t')) to--;
        }
        const int last = *p == '\0';
        *to = '\0';
        if (n < f->n_cells) f->cell[n] = start;
        n++;
        if (last) return n;
        p++;
    }
}

static const char *cell(const images *f, int column)
{
    return f->column[column] >= 0 ? f->cell[f->column[column]] : "";
}

static ff_status bad_cell(const images *f, int column, const char *expected)
{
    char found[FF_QUOTE];
    const char *text = cell(f, column);
    return ff_error_set(f->err, FF_ERR_DATA, f->path, f->lines.line, -1, "column '%s': found %s, expected %s", column_name[column],
                        *text ? ff_quote(text, strlen(text), found) : "an empty cell", expected);
}

/* The numbers of a line; NaN where an optional cell is empty or its column is not there. */
static ff_status read_numbers(const images *f, double v[N_NUMBERS])
{
    const int radians = f->radians_per_unit == 1;
    for (int c = 0; c < N_NUMBERS; c++) {
        const char *text = cell(f, c);
        v[c] = NAN;
        if (*text == '\0' && c > PHI_O) continue;
        const char *end = ff_number_read(text, &v[c]);
        if (!end || *end || !isfinite(v[c])) return bad_cell(f, c, "a finite number");
        if ((c == THETA_I || c == THETA_O) && fabs(v[c]) > (radians ? pi + 1e-9 : 180))
            return bad_cell(f, c, radians ? "radians from -pi to pi" : "degrees from -180 to 180");
        if ((c == SCALE || c == EXPOSURE) && !(v[c] > 0)) return bad_cell(f, c, "a number > 0");
        if (c >= X && !is_whole(v[c], c < WIDTH ? 0 : 1)) return bad_cell(f, c, "a whole number of pixels");
    }
    for (int c = X; c <= HEIGHT; c++)
        if (isnan(v[c]) != isnan(v[X])) return bad_cell(f, isnan(v[c]) ? c : X, "a region of x, y, width and height");
    return FF_OK;
}

/* ---- an image -------------------------------------------------------------------------------- */

static ff_status shot_fails(const shot *s, ff_status code, const char *found, const char *expected)
{
    return ff_error_set(s->f->err, code, s->f->path, s->f->lines.line, -1, "image %s: found %s, expected %s", s->quoted, found,
                        expected);
}

/* Opens an image beside the CSV. */
static ff_status open_beside(shot *s, const char *name, ff_image **image, ff_image_info *info)
{
    images *f = s->f;
    const char *slash = *name == '/' ? NULL : strrchr(f->path, '/');
    const int n = snprintf(s->path, sizeof s->path, "%.*s%s", slash ? (int)(slash - f->path + 1) : 0, f->path, name);
    ff_quote(name, strlen(name), s->quoted);
    struct stat st;
    if (n < 0 || (size_t)n >= sizeof s->path) return shot_fails(s, FF_ERR_OPEN, "a path that is too long", "at most 4095 bytes");
    if (stat(s->path, &st) != 0)
        return ff_error_set(f->err, FF_ERR_OPEN, f->path, f->lines.line, -1, "image %s cannot be opened at '%.300s': %s", s->quoted,
                            s->path, strerror(errno));
    if (!S_ISREG(st.st_mode)) return shot_fails(s, FF_ERR_OPEN, "no regular file", "an image");
    ff_error inner = {0};
    const char *kind = NULL;
    ff_status status = f->options->ask ? f->options->ask(f->options->ask_context, s->path, &inner) : FF_OK;
    if (status == FF_OK) status = ff_image_check(s->path, &kind, &inner);
    if (status == FF_OK) status = f->reader->open(s->path, kind, image, info, &inner);
    if (status == FF_OK) return FF_OK;
    return ff_error_set(f->err, status, f->path, f->lines.line, -1, "image %s: %.500s", s->quoted, inner.message);
}

static ff_status settle_encoding(shot *s)
{
    images *f = s->f;
    const ff_image_info *info = &s->info;
    char found[FF_QUOTE];
    s->encoding = f->said.curve ? f->said : encoding_of(info->encoding);
    if (!f->said.curve && s->encoding.curve == CURVE_UNKNOWN && strncasecmp(info->encoding, "gamma", 5) == 0 &&
        gamma_is_right(info->gamma))
        s->encoding = (encoding){CURVE_GAMMA, info->gamma};
    if (s->encoding.curve == CURVE_UNKNOWN && !*info->encoding && info->bits == 0) {
        s->encoding.curve = CURVE_LINEAR;
        f->n_linear_by_default++;
    }
    if (s->encoding.curve != CURVE_UNKNOWN) {
        f->n_curve[s->encoding.curve]++;
        return FF_OK;
    }
    return shot_fails(s, FF_ERR_UNSUPPORTED,
                      *info->encoding ? ff_quote(info->encoding, strlen(info->encoding), found)
                                      : "no word on how its numbers encode light",
                      "a known encoding, or a comment '# encoding: linear' (srgb, rec709, gamma:2.2) in the CSV");
}

/* Names that a table can have: printable, each once. */
static ff_status check_names(const shot *s, size_t n)
{
    for (size_t c = 0; c < n; c++) {
        const char *name = s->info.name[s->channel[c]];
        int right = *name != '\0';
        for (const char *p = name; *p; p++) right &= (unsigned char)*p >= 0x20 && *p != 0x7F;
        for (size_t k = 0; k < c; k++) right &= strcmp(s->info.name[s->channel[k]], name) != 0;
        if (right) continue;
        char found[FF_QUOTE + 32], quoted[FF_QUOTE];
        snprintf(found, sizeof found, "a channel named %s", ff_quote(name, strlen(name), quoted));
        return shot_fails(s, FF_ERR_FORMAT, found, "a printable name of its own");
    }
    return FF_OK;
}

static ff_status settle_channels(shot *s)
{
    images *f = s->f;
    const ff_image_info *info = &s->info;
    size_t n = 0;
    for (size_t c = 0; c < info->n_channels; c++)
        if ((long)c != info->alpha) s->channel[n++] = c;
    if (n == 0) return shot_fails(s, FF_ERR_UNSUPPORTED, "a channel alpha alone", "a channel of light");
    const ff_status status = check_names(s, n);
    if (status != FF_OK) return status;
    f->n_with_alpha += info->alpha >= 0;
    if (!f->n_channels) {
        f->n_channels = n;
        for (size_t c = 0; c < n; c++) strcpy(f->first.name[c], info->name[s->channel[c]]);
        strcpy(f->first_image, s->quoted);
        f->rows.width = ff_rows_width(n, 1, 0);
        return FF_OK;
    }
    for (size_t c = 0; c < n || c < f->n_channels; c++) {
        if (c < n && c < f->n_channels && strcmp(f->first.name[c], info->name[s->channel[c]]) == 0) continue;
        char found[200], expected[300], one[FF_QUOTE], other[FF_QUOTE];
        snprintf(found, sizeof found, "%zu channels, number %zu named %s", n, c + 1,
                 c < n ? ff_quote(info->name[s->channel[c]], strlen(info->name[s->channel[c]]), one) : "nothing");
        snprintf(expected, sizeof expected, "the %zu of %s, there %s", f->n_channels, f->first_image,
                 c < f->n_channels ? ff_quote(f->first.name[c], strlen(f->first.name[c]), other) : "nothing");
        return shot_fails(s, FF_ERR_FORMAT, found, expected);
    }
    return FF_OK;
}

static ff_status settle_region(shot *s, const double v[N_NUMBERS])
{
    const images *f = s->f;
    const double whole[4] = {0, 0, (double)s->info.width, (double)s->info.height};
    const double *r = !isnan(v[X]) ? v + X : f->with_region ? f->region : whole;
    char found[120], expected[80];
    if (r[0] + r[2] > whole[2] || r[1] + r[3] > whole[3]) {
        snprintf(found, sizeof found, "a region of %.0f x %.0f pixels at (%.0f, %.0f)", r[2], r[3], r[0], r[1]);
        snprintf(expected, sizeof expected, "one inside of %.0f x %.0f", whole[2], whole[3]);
        return shot_fails(s, FF_ERR_DATA, found, expected);
    }
    s->x = (long)r[0];
    s->y = (long)r[1];
    s->width = (long)r[2];
    s->height = (long)r[3];
    return FF_OK;
}

/* ---- light ----------------------------------------------------------------------------------- */

static double decoded(encoding e, double v)
{
    switch (e.curve) {
    case CURVE_SRGB: /* IEC 61966-2-1 */
        return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    case CURVE_REC709: /* ITU-R BT.709 */
        return v < 0.081 ? v / 4.5 : pow((v + 0.099) / 1.099, 1 / 0.45);
    case CURVE_GAMMA:
        return v > 0 ? pow(v, e.gamma) : v;
    default:
        return v;
    }
}

/* Integers of up to 16 bits have their light in a table, of which one image after the other makes use. */
static ff_status make_table(shot *s)
{
    images *f = s->f;
    const int bits = s->info.bits;
    if (bits == 0 || bits > 16 || s->encoding.curve == CURVE_LINEAR) return FF_OK;
    if (f->curve_table && bits == f->table_bits && s->encoding.curve == f->table_of.curve && s->encoding.gamma == f->table_of.gamma)
        return FF_OK;
    const size_t n = (size_t)1 << bits;
    double *table = realloc(f->curve_table, n * sizeof *table);
    if (!table) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for %zu numbers", n);
    for (size_t k = 0; k < n; k++) table[k] = decoded(s->encoding, (double)k / (double)(n - 1));
    f->curve_table = table;
    f->table_of = s->encoding;
    f->table_bits = bits;
    return FF_OK;
}

static double light(const shot *s, float v)
{
    const images *f = s->f;
    if (s->encoding.curve == CURVE_LINEAR) return (double)v;
    if (s->info.bits == 0 || s->info.bits > 16) return decoded(s->encoding, (double)v);
    const long most = (1L << s->info.bits) - 1, k = lrint((double)v * (double)most);
    return f->curve_table[k < 0 ? 0 : k > most ? most : k];
}

/* Standard deviation of rounding to the integers of the file, where the light is `v`. */
static double rounding(const shot *s, size_t c)
{
    if (s->info.bits == 0) return 0;
    const double step = 1 / (exp2(s->info.bits) - 1);
    double low = 0, high = 1;
    for (int k = 0; k < 60; k++) { /* the number that encodes the mean */
        const double middle = (low + high) / 2;
        *(decoded(s->encoding, middle) < s->mean[c] ? &low : &high) = middle;
    }
    const double from = fmax(low - step / 2, 0);
    return (decoded(s->encoding, from + step) - decoded(s->encoding, from)) / sqrt(12);
}

/* ---- pixels ---------------------------------------------------------------------------------- */

/* Mean and sum of squares as pixels come (Welford 1962): no cancellation, one pass. */
static ff_status take_pixel(shot *s, const float *pixel, long x, long y)
{
    int saturated = 0;
    s->n++;
    for (size_t c = 0; c < s->f->n_channels; c++) {
        const float v = pixel[s->channel[c]];
        if (!isfinite(v)) {
            char found[120];
            snprintf(found, sizeof found, "%s in channel %.20s of pixel (%ld, %ld)", isnan(v) ? "nan" : "inf", s->f->first.name[c],
                     x, y);
            return shot_fails(s, FF_ERR_DATA, found, "finite numbers");
        }
        saturated |= s->info.bits && v >= 1;
        const double l = light(s, v), d = l - s->mean[c];
        s->mean[c] += d / s->n;
        s->squares[c] += d * (l - s->mean[c]);
    }
    s->saturated += saturated;
    return FF_OK;
}

static ff_status inner_error(const shot *s, ff_status status, const ff_error *inner)
{
    return ff_error_set(s->f->err, status, s->f->path, s->f->lines.line, -1, "image %s: %.500s", s->quoted, inner->message);
}

/* The lines of a band that are in the region. mask: of the same lines, or NULL. */
static ff_status take_band(shot *s, long first, long count, const float *pixels, const float *mask)
{
    const size_t channels = s->info.n_channels, mask_channels = s->mask_info.n_channels;
    for (long y = first; y < first + count; y++) {
        if (y < s->y || y >= s->y + s->height) continue;
        for (long x = s->x; x < s->x + s->width; x++) {
            const size_t at = (size_t)((y - first) * s->info.width + x);
            if (mask && !(mask[at * mask_channels] > 0.5F)) continue;
            const ff_status status = take_pixel(s, pixels + at * channels, x, y);
            if (status != FF_OK) return status;
        }
    }
    return FF_OK;
}

/* The whole mask: masks and images may come in bands of different heights. */
static ff_status read_mask(shot *s, float **out)
{
    const ff_image_info *m = &s->mask_info;
    const size_t line = (size_t)m->width * m->n_channels;
    float *all = malloc(line * (size_t)m->height * sizeof *all);
    if (!all) return ff_error_set(s->f->err, FF_ERR_MEMORY, s->f->path, s->f->lines.line, -1, "no memory for the mask");
    ff_error inner = {0};
    ff_status status = FF_OK;
    for (long y = 0; y < m->height && status == FF_OK; y += m->band)
        status = s->f->reader->lines(s->mask, y, m->height - y < m->band ? m->height - y : m->band, all + (size_t)y * line, &inner);
    if (status != FF_OK) {
        free(all);
        return inner_error(s, status, &inner);
    }
    *out = all;
    return FF_OK;
}

static ff_status read_pixels(shot *s, const float *mask)
{
    const ff_image_info *info = &s->info;
    const size_t line = (size_t)info->width * info->n_channels;
    float *band = malloc(line * (size_t)info->band * sizeof *band);
    if (!band)
        return ff_error_set(s->f->err, FF_ERR_MEMORY, s->f->path, s->f->lines.line, -1, "no memory for the lines of an image");
    ff_status status = FF_OK;
    for (long y = s->y / info->band * info->band; y < s->y + s->height && status == FF_OK; y += info->band) {
        const long count = info->height - y < info->band ? info->height - y : info->band;
        ff_error inner = {0};
        status = s->f->reader->lines(s->image, y, count, band, &inner);
        if (status != FF_OK)
            status = inner_error(s, status, &inner);
        else
            status = take_band(s, y, count, band, mask ? mask + (size_t)(y * info->width) * s->mask_info.n_channels : NULL);
    }
    free(band);
    return status;
}

static ff_status open_mask(shot *s)
{
    const char *name = cell(s->f, MASK);
    char found[80], expected[80];
    if (*name == '\0') return FF_OK;
    const ff_status status = open_beside(s, name, &s->mask, &s->mask_info);
    if (status != FF_OK || (s->mask_info.width == s->info.width && s->mask_info.height == s->info.height)) return status;
    snprintf(found, sizeof found, "a mask of %ld x %ld pixels", s->mask_info.width, s->mask_info.height);
    snprintf(expected, sizeof expected, "%ld x %ld as the image", s->info.width, s->info.height);
    return shot_fails(s, FF_ERR_DATA, found, expected);
}

/* ---- samples --------------------------------------------------------------------------------- */

static ff_status add_sample(shot *s, const double v[N_NUMBERS])
{
    images *f = s->f;
    double *row = ff_rows_add(&f->rows);
    if (!row) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for image %zu", f->rows.n + 1);
    const double factor = (isnan(v[SCALE]) ? 1 : v[SCALE]) / (isnan(v[EXPOSURE]) ? 1 : v[EXPOSURE]);
    memcpy(row, v, 4 * sizeof *row);
    for (size_t c = 0; c < f->n_channels; c++) {
        const double spread = s->n > 1 ? sqrt(s->squares[c] / (s->n - 1)) : 0, sigma = s->n > 1 ? fmax(spread, rounding(s, c)) : 0;
        row[4 + c] = factor * s->mean[c];
        row[4 + f->n_channels + c] = factor * sigma;
        if (!isfinite(row[4 + c]) || !isfinite(factor * sigma)) return bad_cell(f, SCALE, "a factor that keeps the values finite");
        f->no_sigma |= !(factor * sigma > 0);
    }
    f->n_images++;
    f->n_pixels += s->n;
    f->pixels_least = f->n_images == 1 ? s->n : fmin(f->pixels_least, s->n);
    f->pixels_most = fmax(f->pixels_most, s->n);
    f->n_saturated += s->saturated;
    f->n_saturated_images += s->saturated > 0;
    return FF_OK;
}

static ff_status read_shot(shot *s, const double v[N_NUMBERS])
{
    float *mask = NULL;
    ff_status status = open_beside(s, cell(s->f, IMAGE), &s->image, &s->info);
    if (status == FF_OK) status = settle_encoding(s);
    if (status == FF_OK) status = settle_channels(s);
    if (status == FF_OK) status = settle_region(s, v);
    if (status == FF_OK) status = make_table(s);
    if (status == FF_OK) status = open_mask(s);
    if (status == FF_OK && s->mask) status = read_mask(s, &mask);
    if (status == FF_OK) status = read_pixels(s, mask);
    free(mask);
    if (status == FF_OK && s->n == 0)
        status = shot_fails(s, FF_ERR_DATA, "no pixel in the region that the mask lets through", "at least one");
    return status == FF_OK ? add_sample(s, v) : status;
}

static ff_status find_reader(images *f)
{
    ff_error inner = {0};
    const ff_status s = ff_image_reader_get(&f->reader, &inner);
    if (s == FF_OK) return FF_OK;
    return ff_error_set(f->err, s, f->path, f->lines.line, -1, "%.700s", inner.message);
}

static ff_status read_line(images *f, char *text)
{
    const size_t n = cut_cells(f, text);
    if (n != f->n_cells)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "found %zu cells, expected %zu, one per column", n,
                            f->n_cells);
    double v[N_NUMBERS];
    if (*cell(f, IMAGE) == '\0') return bad_cell(f, IMAGE, "the path of an image");
    ff_status status = read_numbers(f, v);
    if (status == FF_OK && !f->reader) status = find_reader(f);
    shot *s = status == FF_OK ? calloc(1, sizeof *s) : NULL;
    if (status != FF_OK) return status;
    if (!s) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for an image");
    s->f = f;
    status = read_shot(s, v);
    f->reader->close(s->image);
    f->reader->close(s->mask);
    free(s);
    return status;
}

static ff_status read_lines(images *f)
{
    char *text;
    size_t length;
    for (;;) {
        ff_status s = next_line(f, &text, &length);
        if (s == FF_OK && text) s = read_line(f, text);
        if (s != FF_OK) return s;
        if (text) continue;
        if (f->rows.n) return FF_OK;
        return ff_error_set(f->err, FF_ERR_DATA, f->path, f->lines.line, -1,
                            "found no rows after the header, expected at least one image");
    }
}

/* ---- the table ------------------------------------------------------------------------------- */

static void note_light(const images *f, ff_table *t)
{
    static const char *const name[] = {NULL, "linear", "sRGB", "Rec. 709", "a power"};
    for (int k = CURVE_LINEAR; k <= CURVE_GAMMA; k++)
        if (f->n_curve[k] && f->said.curve)
            ff_table_note(t, "the images are read as %s, as the CSV says", name[k]);
        else if (f->n_curve[k] && k != CURVE_LINEAR)
            ff_table_note(t, "%zu images are %s, as their files say or their format is used, and were made linear", f->n_curve[k],
                          name[k]);
    if (f->n_linear_by_default)
        ff_table_note(t, "%zu floating-point images do not say how they encode light: they are taken to be linear",
                      f->n_linear_by_default);
}

static void note_all(const images *f, const ff_read_options *o, ff_table *t)
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
    if (f->column[SCALE] < 0 && isnan(o->scale))
        ff_table_note(t, "no scale is given: pixels%s are taken to be calibrated",
                      f->column[EXPOSURE] >= 0 ? " over their exposure" : "");
}

static int has_channel(const images *f, const char *name)
{
    for (size_t c = 0; c < f->n_channels; c++)
        if (strcmp(f->first.name[c], name) == 0) return 1;
    return 0;
}

/* R, G, B become r, g, b. */
static void name_channels(const images *f, ff_table *t)
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

static ff_status make_table_of(images *f, const ff_read_options *o, ff_table *out)
{
    ff_table t;
    ff_status s = ff_rows_to_table(&f->rows, f->n_channels, 1, 0, &t, f->err);
    if (s != FF_OK) return s;
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
    s = ff_table_count(&t, f->path, f->err);
    if (s == FF_OK)
        *out = t;
    else
        ff_table_free(&t);
    return s;
}

static ff_status read_images(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    images *f = calloc(1, sizeof *f);
    if (!f) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for an image stack");
    *f = (images){.err = err, .path = path, .options = o, .quantity = -1, .isotropic = -1, .radians_per_unit = degree};
    for (int c = 0; c < N_COLUMNS; c++) f->column[c] = -1;
    ff_status s = ff_lines_open(path, &f->lines, err);
    if (s == FF_OK) {
        s = read_header(f);
        if (s == FF_OK) s = read_lines(f);
        if (s == FF_OK) s = make_table_of(f, o, out);
        ff_lines_close(&f->lines);
    }
    free(f->cell);
    free(f->curve_table);
    ff_rows_free(&f->rows);
    free(f);
    return s;
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
