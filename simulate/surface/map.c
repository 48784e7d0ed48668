/* Measured maps of heights: images, SDF, ESRI text grids, rows of numbers. */
#include "internal_surface.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "base/internal_vector_math.h"
#ifdef FF_HAVE_IMAGES
#include "data_formats/formats/images/internal_image_check.h"
#include "data_formats/formats/images/oiio_bridge.h"
#endif
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { LEAST = 16, MOST = 16384, FADED = 16 }; /* points along an axis; the part of an axis that is faded is one of FADED */

/* Heights as they are read: rows from the top, y up; growing. */
typedef struct sheet {
    size_t nx, ny, n, room;
    double *h, dx, dy;
    double missing; /* stands for a height that is not there; NaN: nothing does */
} sheet;

static ff_status add(sheet *s, double x, const char *path, long line, ff_error *err)
{
    if (!isfinite(x) || x == s->missing)
        return ff_error_set(err, FF_ERR_DATA, path, line, -1, "a height is missing; fill the gaps of the map first");
    if (s->n == s->room) {
        const size_t room = s->room ? 2 * s->room : 4096;
        double *more = room <= (size_t)MOST * MOST ? realloc(s->h, room * sizeof *more) : NULL;
        if (!more) return ff_error_set(err, FF_ERR_MEMORY, path, line, -1, "no memory for %zu heights", room);
        s->h = more;
        s->room = room;
    }
    s->h[s->n++] = x;
    return FF_OK;
}

/* ---- text ------------------------------------------------------------------------------------ */

static const char *skip(const char *text)
{
    while (*text == ' ' || *text == '\t' || *text == ',' || *text == ';') text++;
    return text;
}

/* The numbers of a line; *count is how many. */
static ff_status add_line(sheet *s, const char *text, const char *path, long line, size_t *count, ff_error *err)
{
    ff_status status = FF_OK;
    char quote[FF_QUOTE];
    *count = 0;
    for (text = skip(text); *text && !status; text = skip(text), (*count)++) {
        double x;
        const char *end = ff_number_read(text, &x);
        if (!end || (*end && !strchr(" \t,;", *end)))
            return ff_error_set(err, FF_ERR_DATA, path, line, -1, "found %s, expected a height",
                                ff_quote(text, strcspn(text, " \t,;"), quote));
        status = add(s, x, path, line, err);
        text = end;
    }
    return status;
}

/* "ncols 512", "Xscale = 1e-6": the value of a key, 0 when the line is of another. */
static int value_of(const char *text, const char *key, double *value)
{
    const size_t n = strlen(key);
    if (strncasecmp(text, key, n) || (text[n] != ' ' && text[n] != '\t' && text[n] != '=')) return 0;
    const char *at = text + n + strspn(text + n, " \t=");
    return ff_number_read(at, value) != NULL;
}

static ff_status check_size(double nx, double ny, const char *path, long line, sheet *s, ff_error *err)
{
    if (!(nx >= LEAST && nx <= MOST && ny >= LEAST && ny <= MOST))
        return ff_error_set(err, FF_ERR_DATA, path, line, -1, "found %g x %g heights, expected %d to %d along each axis", nx, ny,
                            (int)LEAST, (int)MOST);
    s->nx = (size_t)nx;
    s->ny = (size_t)ny;
    return FF_OK;
}

/* All heights of what is left, however they are broken into lines; `stop`: a line that ends them. */
static ff_status read_body(ff_lines *lines, sheet *s, char *text, const char *stop, double unit, ff_error *err)
{
    ff_status status = FF_OK;
    size_t length, count;
    while (!status && text && !(stop && text[0] == stop[0])) {
        status = add_line(s, text, lines->path, lines->line, &count, err);
        if (!status) status = ff_lines_next(lines, &text, &length, err);
    }
    for (size_t k = 0; k < s->n; k++) s->h[k] *= unit;
    if (!status && s->n != s->nx * s->ny)
        return ff_error_set(err, FF_ERR_DATA, lines->path, lines->line, -1, "found %zu heights, expected %zu x %zu", s->n, s->nx,
                            s->ny);
    return status;
}

/* aBCR-1.0 and the like: keys up to a line of '*', heights in units of Zscale. */
static ff_status read_sdf(ff_lines *lines, sheet *s, ff_error *err)
{
    double nx = 0, ny = 0, unit = 1;
    char *text = NULL;
    size_t length;
    ff_status status = ff_lines_next(lines, &text, &length, err);
    for (; !status && text && text[0] != '*'; status = ff_lines_next(lines, &text, &length, err)) {
        const char *key = skip(text);
        if (value_of(key, "NumPoints", &nx) || value_of(key, "NumProfiles", &ny) || value_of(key, "Xscale", &s->dx) ||
            value_of(key, "Yscale", &s->dy) || value_of(key, "Zscale", &unit))
            continue;
    }
    if (!status) status = check_size(nx, ny, lines->path, lines->line, s, err);
    if (!status) status = ff_lines_next(lines, &text, &length, err);
    return status ? status : read_body(lines, s, text, "*", unit, err);
}

static ff_status read_esri(ff_lines *lines, sheet *s, char *text, ff_error *err)
{
    double nx = 0, ny = 0, cell = NAN, ignored;
    size_t length;
    ff_status status = FF_OK;
    for (; !status && text && isalpha((unsigned char)*skip(text)); status = ff_lines_next(lines, &text, &length, err)) {
        const char *key = skip(text);
        if (value_of(key, "ncols", &nx) || value_of(key, "nrows", &ny) || value_of(key, "cellsize", &cell) ||
            value_of(key, "NODATA_value", &s->missing) || value_of(key, "xllcorner", &ignored))
            continue;
    }
    s->dx = s->dy = cell;
    if (!status) status = check_size(nx, ny, lines->path, lines->line, s, err);
    return status ? status : read_body(lines, s, text, NULL, 1, err);
}

static ff_status read_rows(ff_lines *lines, sheet *s, char *text, ff_error *err)
{
    ff_status status = FF_OK;
    size_t length, count;
    for (; !status && text; status = status ? status : ff_lines_next(lines, &text, &length, err)) {
        if (!*skip(text) || *skip(text) == '#') continue;
        status = add_line(s, text, lines->path, lines->line, &count, err);
        if (!status && s->nx && count != s->nx)
            status = ff_error_set(err, FF_ERR_DATA, lines->path, lines->line, -1,
                                  "found %zu heights, expected %zu as in the rows before", count, s->nx);
        s->nx = count;
        s->ny++;
    }
    return status ? status : check_size((double)s->nx, (double)s->ny, lines->path, 0, s, err);
}

static ff_status read_text(const char *path, sheet *s, ff_error *err)
{
    ff_lines lines;
    char *text = NULL;
    size_t length = 0;
    ff_status status = ff_lines_open(path, &lines, err);
    if (status) return status;
    status = ff_lines_next(&lines, &text, &length, err);
    if (!status && !text) status = ff_error_set(err, FF_ERR_DATA, path, 0, -1, "found an empty file, expected a map of heights");
    if (!status) {
        const char *at = skip(text);
        if ((*at == 'a' || *at == 'A') && strstr(at, "-1.0"))
            status = read_sdf(&lines, s, err);
        else if (!strncasecmp(at, "ncols", 5))
            status = read_esri(&lines, s, text, err);
        else
            status = read_rows(&lines, s, text, err);
    }
    ff_lines_close(&lines);
    return status;
}

/* ---- images ---------------------------------------------------------------------------------- */

#ifdef FF_HAVE_IMAGES
/* The first channel. */
static ff_status read_lines(const ff_image_reader *reader, ff_image *image, const ff_image_info *info, const char *path, sheet *s,
                            ff_error *err)
{
    float *band = malloc((size_t)info->band * (size_t)info->width * info->n_channels * sizeof *band);
    ff_status status = band ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for %ld lines", info->band);
    for (long y = 0; y < info->height && !status; y += info->band) {
        const long left = info->height - y, count = left < info->band ? left : info->band;
        status = reader->lines(image, y, count, band, err);
        for (size_t k = 0; k < (size_t)count * (size_t)info->width && !status; k++)
            status = add(s, band[k * info->n_channels], path, 0, err);
    }
    free(band);
    return status;
}

static ff_status read_image(const char *path, sheet *s, ff_error *err)
{
    const char *kind;
    const ff_image_reader *reader;
    ff_image *image;
    ff_image_info info;
    ff_status status = ff_image_check(path, &kind, err);
    if (!status) status = ff_image_reader_get(&reader, err);
    if (!status) status = reader->open(path, kind, &image, &info, err);
    if (status) return status;
    status = check_size((double)info.width, (double)info.height, path, 0, s, err);
    if (!status) status = read_lines(reader, image, &info, path, s, err);
    reader->close(image);
    return status;
}
#else
static ff_status read_image(const char *path, sheet *s, ff_error *err)
{
    (void)s;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "this program was built without images");
}
#endif

static int is_image(const char *path)
{
    static const char *const ends[] = {".exr", ".tif", ".tiff", ".png"};
    const size_t n = strlen(path);
    for (size_t k = 0; k < sizeof ends / sizeof ends[0]; k++)
        if (n > strlen(ends[k]) && !strcasecmp(path + n - strlen(ends[k]), ends[k])) return 1;
    return 0;
}

/* ---- a map that can be repeated -------------------------------------------------------------- */

/* Less its mean plane, by least squares. */
static void level(sheet *s)
{
    double sum = 0, x2 = 0, y2 = 0, xz = 0, yz = 0;
    const double cx = 0.5 * (double)(s->nx - 1), cy = 0.5 * (double)(s->ny - 1), n = (double)s->nx * (double)s->ny;
    for (size_t j = 0; j < s->ny; j++)
        for (size_t i = 0; i < s->nx; i++) {
            const double x = (double)i - cx, y = (double)j - cy, z = s->h[j * s->nx + i];
            sum += z, x2 += x * x, y2 += y * y, xz += x * z, yz += y * z;
        }
    for (size_t j = 0; j < s->ny; j++)
        for (size_t i = 0; i < s->nx; i++) s->h[j * s->nx + i] -= sum / n + ((double)i - cx) * xz / x2 + ((double)j - cy) * yz / y2;
}

/* The last `faded` of n values a stride apart go into the first; weights whose squares add up to 1 keep the variance of heights
 * that know nothing of each other. */
static void fade(double *h, size_t n, size_t stride, size_t faded)
{
    for (size_t k = 0; k < faded; k++) {
        const double t = 0.5 * FF_PI * (double)k / (double)faded;
        h[k * stride] = sin(t) * h[k * stride] + cos(t) * h[(n - faded + k) * stride];
    }
}

static void finish(sheet *s, ff_heights *out)
{
    const size_t fx = s->nx / FADED, fy = s->ny / FADED;
    level(s);
    for (size_t j = 0; j < s->ny; j++) fade(s->h + j * s->nx, s->nx, 1, fx);
    for (size_t i = 0; i < s->nx; i++) fade(s->h + i, s->ny, s->nx, fy);
    *out = (ff_heights){s->nx - fx, s->ny - fy, s->h, s->dx, s->dy};
    for (size_t j = 0; j < out->ny; j++) memmove(s->h + j * out->nx, s->h + j * s->nx, out->nx * sizeof *s->h);
}

/* Rows come from the top; y grows upwards. */
static void turn_up(sheet *s)
{
    for (size_t j = 0; j < s->ny / 2; j++)
        for (size_t i = 0; i < s->nx; i++) {
            double *a = &s->h[j * s->nx + i], *b = &s->h[(s->ny - 1 - j) * s->nx + i];
            const double x = *a;
            *a = *b;
            *b = x;
        }
}

ff_status ff_heights_read(const char *path, const double pitch[2], double unit, ff_heights *out, ff_error *err)
{
    sheet s = {.dx = NAN, .dy = NAN, .missing = NAN};
    ff_status status = is_image(path) ? read_image(path, &s, err) : read_text(path, &s, err);
    if (!isnan(pitch[0])) s.dx = pitch[0];
    if (!isnan(pitch[1])) s.dy = pitch[1];
    if (!status && !(s.dx > 0 && s.dy > 0 && isfinite(s.dx) && isfinite(s.dy)))
        status = ff_error_set(err, FF_ERR_DATA, path, 0, -1,
                              "nothing says how far apart its heights are, in their unit: give their pitch");
    if (status) {
        free(s.h);
        return status;
    }
    for (size_t k = 0; k < s.n; k++) s.h[k] *= unit;
    turn_up(&s);
    finish(&s, out);
    return FF_OK;
}
