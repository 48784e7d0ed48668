/* PNG (ISO/IEC 15948) by streaming: the length of everything is known before the first byte. */
#include "internal_png.h"
#include <stdint.h>
#include <string.h>

enum { STORED = 65535 };

typedef struct sink {
    FILE *out;
    unsigned char kept[3];
    int n;
    uint32_t crc, a, b; /* of the open chunk; Adler-32 of the rows */
} sink;

static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/* Three bytes are four digits. */
static void flush(sink *s)
{
    const uint32_t bits = (uint32_t)s->kept[0] << 16 | (uint32_t)(s->n > 1 ? s->kept[1] : 0) << 8 | (s->n > 2 ? s->kept[2] : 0u);
    if (s->n == 0) return;
    for (int k = 0; k < 4; k++) fputc(k <= s->n ? digits[(bits >> (18 - 6 * k)) & 63] : '=', s->out);
    s->n = 0;
}

static void byte(sink *s, unsigned value)
{
    s->crc ^= value & 255;
    for (int k = 0; k < 8; k++) s->crc = s->crc >> 1 ^ (s->crc & 1 ? 0xedb88320u : 0);
    s->kept[s->n++] = (unsigned char)value;
    if (s->n == 3) flush(s);
}

static void number(sink *s, uint32_t value)
{
    for (int shift = 24; shift >= 0; shift -= 8) byte(s, value >> shift & 255);
}

static void begin(sink *s, uint32_t length, const char *name)
{
    number(s, length);
    s->crc = 0xffffffffu;
    for (int k = 0; k < 4; k++) byte(s, (unsigned char)name[k]);
}

static void end(sink *s)
{
    number(s, s->crc ^ 0xffffffffu);
}

static void row_byte(sink *s, unsigned value)
{
    s->a = (s->a + value) % 65521;
    s->b = (s->b + s->a) % 65521;
    byte(s, value);
}

/* What is written: pixels of one byte or three. */
typedef struct picture {
    size_t nx, ny, times;
    const unsigned char *rgb;
    size_t n_colours; /* of the palette; 0: there are too many for one */
    unsigned char colour[256][3];
    size_t last; /* found */
} picture;

static size_t find(const picture *p, const unsigned char *rgb)
{
    size_t k = 0;
    while (k < p->n_colours && memcmp(p->colour[k], rgb, 3)) k++;
    return k;
}

static void make_palette(picture *p)
{
    for (size_t i = 0; i < p->nx * p->ny; i++) {
        const size_t k = find(p, p->rgb + 3 * i);
        if (k < p->n_colours) continue;
        if (k == 256) {
            p->n_colours = 0;
            return;
        }
        memcpy(p->colour[p->n_colours++], p->rgb + 3 * i, 3);
    }
}

static size_t pixel_bytes(const picture *p)
{
    return p->n_colours ? 1 : 3;
}

/* Byte `at` of the rows, each of which begins with its filter, 0: none. */
static unsigned row_byte_at(picture *p, size_t at)
{
    const size_t width = pixel_bytes(p) * p->nx * p->times + 1, row = at / width / p->times, k = at % width;
    if (k == 0) return 0;
    const size_t pixel = (k - 1) / pixel_bytes(p) / p->times;
    const unsigned char *rgb = p->rgb + 3 * (row * p->nx + pixel);
    if (!p->n_colours) return rgb[(k - 1) % 3];
    if (memcmp(p->colour[p->last], rgb, 3)) p->last = find(p, rgb);
    return (unsigned)p->last;
}

static void put_rows(sink *s, picture *p)
{
    const size_t bytes = p->ny * p->times * (pixel_bytes(p) * p->nx * p->times + 1), blocks = (bytes + STORED - 1) / STORED;
    begin(s, (uint32_t)(2 + bytes + 5 * blocks + 4), "IDAT");
    byte(s, 0x78);
    byte(s, 0x01);
    for (size_t at = 0; at < bytes;) {
        const size_t n = bytes - at < STORED ? bytes - at : STORED;
        const unsigned low = (unsigned)n & 255, high = (unsigned)(n >> 8);
        byte(s, at + n == bytes);
        byte(s, low), byte(s, high), byte(s, low ^ 255), byte(s, high ^ 255);
        for (const size_t stop = at + n; at < stop; at++) row_byte(s, row_byte_at(p, at));
    }
    number(s, s->b << 16 | s->a);
    end(s);
}

void ff_png_base64(size_t nx, size_t ny, const unsigned char *rgb, size_t times, FILE *out)
{
    static const unsigned char magic[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    sink s = {.out = out, .a = 1};
    picture p = {.nx = nx, .ny = ny, .times = times, .rgb = rgb};
    make_palette(&p);
    for (size_t k = 0; k < sizeof magic; k++) byte(&s, magic[k]);
    begin(&s, 13, "IHDR");
    number(&s, (uint32_t)(nx * times));
    number(&s, (uint32_t)(ny * times));
    byte(&s, 8);                   /* bits                 */
    byte(&s, p.n_colours ? 3 : 2); /* by the palette, RGB  */
    for (int k = 0; k < 3; k++) byte(&s, 0);
    end(&s);
    if (p.n_colours) begin(&s, (uint32_t)(3 * p.n_colours), "PLTE");
    for (size_t k = 0; k < 3 * p.n_colours; k++) byte(&s, p.colour[k / 3][k % 3]);
    if (p.n_colours) end(&s);
    put_rows(&s, &p);
    begin(&s, 0, "IEND");
    end(&s);
    flush(&s);
}
