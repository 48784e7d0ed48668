/* PNG (ISO/IEC 15948) in memory: rows by the filter whose bytes are smallest, deflated by zlib. */
#include "internal_render.h"
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { FILTERS = 5, HEAD = 8 + 25, END = 12, CHUNK = 12 };

/* The neighbour whose value is nearest to left + above - corner (section 9.4). */
static int paeth(int left, int above, int corner)
{
    const int p = left + above - corner, a = abs(p - left), b = abs(p - above), c = abs(p - corner);
    return a <= b && a <= c ? left : b <= c ? above : corner;
}

/* What `filter` takes a byte for. */
static inline int guess(int filter, int left, int above, int corner)
{
    switch (filter) {
    case 0:
        return 0;
    case 1:
        return left;
    case 2:
        return above;
    case 3:
        return (left + above) / 2;
    default:
        return paeth(left, above, corner);
    }
}

/* Row `at`, the one above it, filtered; the sum of the bytes' sizes as signed ones. The filter is a constant where this is inlined.
 */
static inline unsigned long filter_by(int filter, size_t n, size_t pixel, const unsigned char *at, const unsigned char *above,
                                      unsigned char *out)
{
    unsigned long sum = 0;
    for (size_t k = 0; k < pixel; k++) out[k] = (unsigned char)(at[k] - guess(filter, 0, above[k], 0));
    for (size_t k = pixel; k < n; k++) out[k] = (unsigned char)(at[k] - guess(filter, at[k - pixel], above[k], above[k - pixel]));
    for (size_t k = 0; k < n; k++) sum += out[k] < 128 ? out[k] : 256u - out[k];
    return sum;
}

static unsigned long filter_row(int filter, size_t n, size_t pixel, const unsigned char *at, const unsigned char *above,
                                unsigned char *out)
{
    switch (filter) {
    case 0:
        return filter_by(0, n, pixel, at, above, out);
    case 1:
        return filter_by(1, n, pixel, at, above, out);
    case 2:
        return filter_by(2, n, pixel, at, above, out);
    case 3:
        return filter_by(3, n, pixel, at, above, out);
    default:
        return filter_by(4, n, pixel, at, above, out);
    }
}

/* All rows, each after the number of its filter; scratch [2][width], its second row zeros: what is above the first. */
static void filter_rows(size_t width, size_t ny, size_t pixel, const unsigned char *pixels, unsigned char *scratch,
                        unsigned char *out)
{
    for (size_t r = 0; r < ny; r++) {
        const unsigned char *at = pixels + r * width, *above = r ? at - width : scratch + width;
        unsigned char *row = out + r * (width + 1);
        unsigned long least = 0;
        for (int f = 0; f < FILTERS; f++) {
            const unsigned long sum = filter_row(f, width, pixel, at, above, scratch);
            if (f > 0 && sum >= least) continue;
            least = sum;
            row[0] = (unsigned char)f;
            memcpy(row + 1, scratch, width);
        }
    }
}

static unsigned char *put_number(unsigned char *to, unsigned long v)
{
    for (int shift = 24; shift >= 0; shift -= 8) *to++ = (unsigned char)(v >> shift & 255);
    return to;
}

/* A chunk whose n bytes of content stand at to + 8 already; its end. */
static unsigned char *put_chunk(unsigned char *to, const char *name, size_t n)
{
    put_number(to, (unsigned long)n);
    memcpy(to + 4, name, 4);
    return put_number(to + 8 + n, crc32(crc32(0, NULL, 0), to + 4, (uInt)(n + 4)));
}

static unsigned char *put_head(unsigned char *to, size_t nx, size_t ny, size_t channels)
{
    static const unsigned char magic[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const unsigned char depth_and_kind[2][5] = {{8, 2, 0, 0, 0}, {8, 6, 0, 0, 0}};
    memcpy(to, magic, sizeof magic);
    to += sizeof magic;
    memcpy(put_number(put_number(to + 8, (unsigned long)nx), (unsigned long)ny), depth_and_kind[channels == 4], 5);
    return put_chunk(to, "IHDR", 13);
}

ff_status ff_png_encode(size_t nx, size_t ny, size_t channels, const unsigned char *pixels, unsigned char **png, size_t *n)
{
    const size_t width = nx * channels, raw = ny * (width + 1);
    uLongf packed = compressBound((uLong)raw);
    unsigned char *rows = malloc(raw), *scratch = calloc(2, width), *out = malloc(HEAD + CHUNK + packed + END), *at = out;
    if (rows && scratch && out) {
        filter_rows(width, ny, channels, pixels, scratch, rows);
        at = put_head(out, nx, ny, channels);
    }
    if (!rows || !scratch || !out || compress2(at + 8, &packed, rows, (uLong)raw, 6) != Z_OK) {
        free(out);
        out = NULL;
    } else {
        at = put_chunk(put_chunk(at, "IDAT", packed), "IEND", 0);
        *png = out;
        *n = (size_t)(at - out);
    }
    free(rows);
    free(scratch);
    return out ? FF_OK : FF_ERR_MEMORY;
}

void ff_render_png_free(unsigned char *png)
{
    free(png);
}
