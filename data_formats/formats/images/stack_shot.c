/* One image of a stack as a sample: mean and spread of its linear pixels in the region and the mask. */
#include "internal_image_check.h"
#include "internal_stack.h"
#include "base/internal_errno.h"
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

/* ---- an image -------------------------------------------------------------------------------- */

static ff_status shot_fails(const ff_image_shot *s, ff_status code, const char *found, const char *expected)
{
    return ff_error_set(s->f->err, code, s->f->path, s->f->lines.line, -1, "image %s: found %s, expected %s", s->quoted, found,
                        expected);
}

/* Opens an image beside the CSV. */
static ff_status open_beside(ff_image_shot *s, const char *name, ff_image **image, ff_image_info *info)
{
    ff_image_stack *f = s->f;
    const char *slash = *name == '/' ? NULL : strrchr(f->path, '/');
    const int n = snprintf(s->path, sizeof s->path, "%.*s%s", slash ? (int)(slash - f->path + 1) : 0, f->path, name);
    ff_quote(name, strlen(name), s->quoted);
    struct stat st;
    if (n < 0 || (size_t)n >= sizeof s->path) return shot_fails(s, FF_ERR_OPEN, "a path that is too long", "at most 4095 bytes");
    if (stat(s->path, &st) != 0)
        return ff_error_set(f->err, FF_ERR_OPEN, f->path, f->lines.line, -1, "image %s cannot be opened at '%.300s': %s", s->quoted,
                            s->path, ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
    if (!S_ISREG(st.st_mode)) return shot_fails(s, FF_ERR_OPEN, "no regular file", "an image");
    ff_error inner = {0};
    const char *kind = NULL;
    ff_status status = f->options->ask ? f->options->ask(f->options->ask_context, s->path, &inner) : FF_OK;
    if (status == FF_OK) status = ff_image_check(s->path, &kind, &inner);
    if (status == FF_OK) status = f->reader->open(s->path, kind, image, info, &inner);
    if (status == FF_OK) return FF_OK;
    return ff_error_set(f->err, status, f->path, f->lines.line, -1, "image %s: %.500s", s->quoted, inner.message);
}

static ff_status settle_encoding(ff_image_shot *s)
{
    ff_image_stack *f = s->f;
    const ff_image_info *info = &s->info;
    char found[FF_QUOTE];
    s->encoding = f->said.curve ? f->said : ff_encoding_of(info->encoding);
    if (!f->said.curve && s->encoding.curve == FF_CURVE_UNKNOWN && strncasecmp(info->encoding, "gamma", 5) == 0 &&
        ff_gamma_is_right(info->gamma))
        s->encoding = (ff_encoding){FF_CURVE_GAMMA, info->gamma};
    if (s->encoding.curve == FF_CURVE_UNKNOWN && !*info->encoding && info->bits == 0) {
        s->encoding.curve = FF_CURVE_LINEAR;
        f->n_linear_by_default++;
    }
    if (s->encoding.curve != FF_CURVE_UNKNOWN) {
        f->n_curve[s->encoding.curve]++;
        return FF_OK;
    }
    return shot_fails(s, FF_ERR_UNSUPPORTED,
                      *info->encoding ? ff_quote(info->encoding, strlen(info->encoding), found)
                                      : "no word on how its numbers encode light",
                      "a known encoding, or a comment '# encoding: linear' (srgb, rec709, gamma:2.2) in the CSV");
}

/* Names that a table can have: printable, each once. */
static ff_status check_names(const ff_image_shot *s, size_t n)
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

static ff_status settle_channels(ff_image_shot *s)
{
    ff_image_stack *f = s->f;
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

static ff_status settle_region(ff_image_shot *s, const double v[FF_STACK_NUMBERS])
{
    const ff_image_stack *f = s->f;
    const double whole[4] = {0, 0, (double)s->info.width, (double)s->info.height};
    const double *r = !isnan(v[FF_STACK_X]) ? v + FF_STACK_X : f->with_region ? f->region : whole;
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

static double decoded(ff_encoding e, double v)
{
    switch (e.curve) {
    case FF_CURVE_SRGB: /* IEC 61966-2-1 */
        return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    case FF_CURVE_REC709: /* ITU-R BT.709 */
        return v < 0.081 ? v / 4.5 : pow((v + 0.099) / 1.099, 1 / 0.45);
    case FF_CURVE_GAMMA:
        return v > 0 ? pow(v, e.gamma) : v;
    default:
        return v;
    }
}

/* Integers of up to 16 bits have their light in a table, of which one image after the other makes use. */
static ff_status make_table(ff_image_shot *s)
{
    ff_image_stack *f = s->f;
    const int bits = s->info.bits;
    if (bits == 0 || bits > 16 || s->encoding.curve == FF_CURVE_LINEAR) return FF_OK;
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

static double light(const ff_image_shot *s, float v)
{
    const ff_image_stack *f = s->f;
    if (s->encoding.curve == FF_CURVE_LINEAR) return (double)v;
    if (s->info.bits == 0 || s->info.bits > 16) return decoded(s->encoding, (double)v);
    const long most = (1L << s->info.bits) - 1, k = lrint((double)v * (double)most);
    return f->curve_table[k < 0 ? 0 : k > most ? most : k];
}

/* Standard deviation of rounding to the integers of the file, where the light is `v`. */
static double rounding(const ff_image_shot *s, size_t c)
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
static ff_status take_pixel(ff_image_shot *s, const float *pixel, long x, long y)
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

static ff_status inner_error(const ff_image_shot *s, ff_status status, const ff_error *inner)
{
    return ff_error_set(s->f->err, status, s->f->path, s->f->lines.line, -1, "image %s: %.500s", s->quoted, inner->message);
}

/* The lines of a band that are in the region. mask: of the same lines, or NULL. */
static ff_status take_band(ff_image_shot *s, long first, long count, const float *pixels, const float *mask)
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
static ff_status read_mask(ff_image_shot *s, float **out)
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

static ff_status read_pixels(ff_image_shot *s, const float *mask)
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

static ff_status open_mask(ff_image_shot *s)
{
    const char *name = ff_stack_cell(s->f, FF_STACK_MASK);
    char found[80], expected[80];
    if (*name == '\0') return FF_OK;
    const ff_status status = open_beside(s, name, &s->mask, &s->mask_info);
    if (status != FF_OK || (s->mask_info.width == s->info.width && s->mask_info.height == s->info.height)) return status;
    snprintf(found, sizeof found, "a mask of %ld x %ld pixels", s->mask_info.width, s->mask_info.height);
    snprintf(expected, sizeof expected, "%ld x %ld as the image", s->info.width, s->info.height);
    return shot_fails(s, FF_ERR_DATA, found, expected);
}

/* ---- samples --------------------------------------------------------------------------------- */

static ff_status add_sample(ff_image_shot *s, const double v[FF_STACK_NUMBERS])
{
    ff_image_stack *f = s->f;
    double *row = ff_rows_add(&f->rows);
    if (!row) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for image %zu", f->rows.n + 1);
    const double factor =
        (isnan(v[FF_STACK_SCALE]) ? 1 : v[FF_STACK_SCALE]) / (isnan(v[FF_STACK_EXPOSURE]) ? 1 : v[FF_STACK_EXPOSURE]);
    memcpy(row, v, 4 * sizeof *row);
    for (size_t c = 0; c < f->n_channels; c++) {
        const double spread = s->n > 1 ? sqrt(s->squares[c] / (s->n - 1)) : 0, sigma = s->n > 1 ? fmax(spread, rounding(s, c)) : 0;
        row[4 + c] = factor * s->mean[c];
        row[4 + f->n_channels + c] = factor * sigma;
        if (!isfinite(row[4 + c]) || !isfinite(factor * sigma))
            return ff_stack_bad_cell(f, FF_STACK_SCALE, "a factor that keeps the values finite");
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

ff_status ff_stack_read_shot(ff_image_shot *s, const double v[FF_STACK_NUMBERS])
{
    float *mask = NULL;
    ff_status status = open_beside(s, ff_stack_cell(s->f, FF_STACK_IMAGE), &s->image, &s->info);
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
