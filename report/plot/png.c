/* PNG (ISO/IEC 15948) by streaming: the length of everything is known before the first byte. */
#include "internal_png.h"
#include <stdint.h>

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

static unsigned pixel_byte(size_t nx, const unsigned char *rgb, size_t at)
{
    const size_t row = at / (3 * nx + 1), k = at % (3 * nx + 1);
    return k == 0 ? 0 : rgb[row * 3 * nx + k - 1]; /* filter 0: none */
}

void ff_png_base64(size_t nx, size_t ny, const unsigned char *rgb, FILE *out)
{
    static const unsigned char magic[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    sink s = {.out = out, .a = 1};
    const size_t bytes = ny * (3 * nx + 1), blocks = (bytes + STORED - 1) / STORED;
    for (size_t k = 0; k < sizeof magic; k++) byte(&s, magic[k]);
    begin(&s, 13, "IHDR");
    number(&s, (uint32_t)nx);
    number(&s, (uint32_t)ny);
    byte(&s, 8); /* bits */
    byte(&s, 2); /* RGB  */
    for (int k = 0; k < 3; k++) byte(&s, 0);
    end(&s);
    begin(&s, (uint32_t)(2 + bytes + 5 * blocks + 4), "IDAT");
    byte(&s, 0x78);
    byte(&s, 0x01);
    for (size_t at = 0; at < bytes;) {
        const size_t n = bytes - at < STORED ? bytes - at : STORED;
        byte(&s, at + n == bytes);
        const unsigned low = (unsigned)n & 255, high = (unsigned)(n >> 8);
        byte(&s, low), byte(&s, high), byte(&s, low ^ 255), byte(&s, high ^ 255);
        for (const size_t stop = at + n; at < stop; at++) row_byte(&s, pixel_byte(nx, rgb, at));
    }
    number(&s, s.b << 16 | s.a);
    end(&s);
    begin(&s, 0, "IEND");
    end(&s);
    flush(&s);
}
