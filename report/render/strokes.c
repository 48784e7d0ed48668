/* Letters as strokes of a round pen, for labels of pictures: no font is needed, and they are smooth at any size.
 *
 * A glyph is its width and strokes separated by blanks, each a row of points of two characters: x from '0' to '9', 'A' to 'F', and
 * y as a letter, the baseline 'f', the height of small letters 'n', of capitals 'r'. '~' before them: a smooth curve through them.
 */
#include "internal_render.h"
#include "report/internal_text.h"
#include <math.h>

enum { CAPITAL = 12, SPACING = 3, PER_SPAN = 6, POINTS = 20 };
#define PEN 0.125 /* width of the pen, in sizes */

typedef struct glyph {
    uint32_t code;
    int width;
    const char *strokes;
} glyph;

#define BOWL_LEFT  "~7j6m4n1m0j1g4f6g7j" /* of a, d, g, q */
#define BOWL_RIGHT "~0j1m3n6m7j6g3f1g0j" /* of b, p        */

static const glyph glyphs[] = {
    {' ', 4, ""},
    {'0', 8, "~4r1p0l1h4f7h8l7p4r"},
    {'1', 4, "1p4r4f"},
    {'2', 8, "~0o2r6r8o6k0f 0f8f"},
    {'3', 8, "~0p2r6r7o6m3l ~3l7k8i6f2f0h"},
    {'4', 8, "6f6r0i8i"},
    {'5', 8, "7r1r0l ~0l4n7l8j7g4f0g"},
    {'6', 8, "~7q4r1o0j1g4f7g8j7l4m1l0j"},
    {'7', 8, "0r8r3f"},
    {'8', 8, "~4r1q1n4l7n7q4r ~4l1k0i1g4f7g8i7k4l"},
    {'9', 8, "~1g4f7i8n7q4r1q0n1l4k7l8n"},
    {'.', 1, "0f1f1g0g0f"},
    {',', 1, "1g0d"},
    {':', 1, "0f1f1g0g0f 0m1m1n0n0m"},
    {'\'', 0, "0r0o"},
    {'-', 5, "0j5j"},
    {0x2013, 7, "0j7j"},
    {0x2212, 8, "0j8j"},
    {'+', 8, "0j8j 4f4n"},
    {0x00b1, 8, "0k8k 4o4g 0f8f"},
    {'=', 8, "0h8h 0l8l"},
    {'/', 5, "0e5r"},
    {'*', 6, "0p6l 0l6p 3q3k"},
    {'<', 7, "7n0j7f"},
    {'>', 7, "0n7j0f"},
    {'(', 3, "~3s1p0k1f3c"},
    {')', 3, "~0s2p3k2f0c"},
    {'[', 3, "3s0s0c3c"},
    {']', 3, "0s3s3c0c"},
    {'_', 7, "0d7d"},
    {'%', 9, "0f9r ~2r0p2n4p2r ~7j5h7f9h7j"},
    {0x00b0, 4, "~2r0p2n4p2r"},
    {0x00d7, 6, "0g6m 0m6g"},
    {'A', 8, "0f4r8f 2j6j"},
    {'B', 8, "4f0f0r4r ~4r7q7m4l 0l4l ~4l8k8g4f"},
    {'C', 8, "~8p6r2r0o0i2f6f8h"},
    {'D', 8, "3f0f0r3r ~3r7q8l7g3f"},
    {'E', 7, "7r0r0f7f 0l5l"},
    {'F', 7, "7r0r0f 0l5l"},
    {'G', 8, "~8p6r2r0o0i2f6f8h 8h8k5k"},
    {'H', 8, "0r0f 8r8f 0l8l"},
    {'I', 0, "0r0f"},
    {'J', 5, "5r5i ~5i4f2f0h"},
    {'K', 7, "0r0f 7r0j 2l7f"},
    {'L', 6, "0r0f6f"},
    {'M', 10, "0f0r5hArAf"},
    {'N', 8, "0f0r8f8r"},
    {'O', 8, "~4r1q0l1g4f7g8l7q4r"},
    {'P', 8, "0f0r4r ~4r8q8m4l 4l0l"},
    {'Q', 8, "~4r1q0l1g4f7g8l7q4r 5i8e"},
    {'R', 8, "0f0r4r ~4r8q8m4l 0l4l8f"},
    {'S', 8, "~7p5r2r0p1m6k8i6f2f0h"},
    {'T', 8, "0r8r 4r4f"},
    {'U', 8, "0r0j ~0j1g4f7g8j 8j8r"},
    {'V', 8, "0r4f8r"},
    {'W', 12, "0r3f6r9fCr"},
    {'X', 8, "0r8f 8r0f"},
    {'Y', 8, "0r4l8r 4l4f"},
    {'Z', 8, "0r8r0f8f"},
    {'a', 7, BOWL_LEFT " 7n7f"},
    {'b', 7, "0r0f " BOWL_RIGHT},
    {'c', 7, "~7l6m4n1m0j1g4f6g7h"},
    {'d', 7, "7r7f " BOWL_LEFT},
    {'e', 7, "0j7j ~7j6m4n1m0j1g4f6g7h"},
    {'f', 5, "~5r3r2p2m 2m2f 0n5n"},
    {'g', 7, BOWL_LEFT " 7n7f ~7f6c3b0c"},
    {'h', 7, "0r0f ~0j1m4n6m7j 7j7f"},
    {'i', 0, "0n0f 0q0r"},
    {'j', 2, "2n2f ~2f2d0b 2q2r"},
    {'k', 7, "0r0f 6n0i 2k7f"},
    {'l', 2, "0r0h ~0h1f2f"},
    {'m', 10, "0n0f ~0j1m3n5m5j 5j5f ~5j6m8nAmAj AjAf"},
    {'n', 7, "0n0f ~0j1m4n6m7j 7j7f"},
    {'o', 8, "~4n1m0j1g4f7g8j7m4n"},
    {'p', 7, "0n0b " BOWL_RIGHT},
    {'q', 7, BOWL_LEFT " 7n7b"},
    {'r', 5, "0n0f ~0j1m3n5n"},
    {'s', 6, "~6l4n1m1k5i6h4f1f0h"},
    {'t', 5, "2r2h ~2h3f5f 0n5n"},
    {'u', 7, "0n0j ~0j1g3f6g7j 7n7f"},
    {'v', 6, "0n3f6n"},
    {'w', 10, "0n2f5n8fAn"},
    {'x', 6, "0n6f 6n0f"},
    {'y', 6, "0n3f 6n2b0b"},
    {'z', 6, "0n6n0f6f"},
    {0x03b1, 8, "~8n6h4f1g0j1m4n6l8f"},
    {0, 6, "0f6f6r0r0f"}, /* of what is not here */
};

static const glyph *glyph_of(uint32_t code)
{
    const glyph *g = glyphs;
    while (g->code && g->code != code) g++;
    return g;
}

/* The next code point of *text, which moves on; 0 at the end. */
static uint32_t next_code(const char **text)
{
    uint32_t code = '?';
    if (**text == '\0') return 0;
    const size_t n = ff_text_sequence(*text, &code);
    *text += n ? n : 1;
    return n ? code : '?';
}

double ff_strokes_width(const char *text, double size)
{
    double width = 0;
    uint32_t code;
    while ((code = next_code(&text))) width += glyph_of(code)->width + SPACING;
    return width > 0 ? (width - SPACING) * size / CAPITAL : 0;
}

/* ---- drawing --------------------------------------------------------------------------------- */

typedef struct canvas {
    size_t nx, ny;
    float *coverage;
    double radius; /* of the pen */
} canvas;

static size_t clamp(double x, size_t most)
{
    return x > 0 ? x < (double)most ? (size_t)x : most : 0;
}

/* All that is within the pen's radius of the line from a to b, its edge over one pixel. */
static void draw_line(const canvas *c, const double a[2], const double b[2])
{
    const double reach = c->radius + 1, dx = b[0] - a[0], dy = b[1] - a[1], length2 = dx * dx + dy * dy;
    const size_t left = clamp(fmin(a[0], b[0]) - reach, c->nx), right = clamp(fmax(a[0], b[0]) + reach + 1, c->nx),
                 top = clamp(fmin(a[1], b[1]) - reach, c->ny), bottom = clamp(fmax(a[1], b[1]) + reach + 1, c->ny);
    for (size_t j = top; j < bottom; j++)
        for (size_t i = left; i < right; i++) {
            const double x = (double)i + 0.5 - a[0], y = (double)j + 0.5 - a[1];
            const double t = length2 > 0 ? fmin(fmax((x * dx + y * dy) / length2, 0), 1) : 0;
            const double d = hypot(x - t * dx, y - t * dy), cover = fmin(fmax(c->radius + 0.5 - d, 0), 1);
            float *at = &c->coverage[j * c->nx + i];
            if (cover > (double)*at) *at = (float)cover;
        }
}

/* Catmull and Rom's curve between p[1] and p[2]. */
static double curve(double p0, double p1, double p2, double p3, double t)
{
    return 0.5 * (2 * p1 + (p2 - p0) * t + (2 * p0 - 5 * p1 + 4 * p2 - p3) * t * t + (3 * p1 - p0 - 3 * p2 + p3) * t * t * t);
}

static void draw_span(const canvas *c, const double *p0, const double *p1, const double *p2, const double *p3)
{
    double from[2] = {p1[0], p1[1]};
    for (int s = 1; s <= PER_SPAN; s++) {
        const double t = (double)s / PER_SPAN, to[2] = {curve(p0[0], p1[0], p2[0], p3[0], t), curve(p0[1], p1[1], p2[1], p3[1], t)};
        draw_line(c, from, to);
        from[0] = to[0], from[1] = to[1];
    }
}

static void draw_stroke(const canvas *c, size_t n, double p[][2], int smooth)
{
    const int closed = p[0][0] == p[n - 1][0] && p[0][1] == p[n - 1][1];
    for (size_t k = 0; k + 1 < n; k++) {
        if (!smooth) {
            draw_line(c, p[k], p[k + 1]);
            continue;
        }
        const double *before = k ? p[k - 1] : closed ? p[n - 2] : p[0], *after = k + 2 < n ? p[k + 2] : closed ? p[1] : p[n - 1];
        draw_span(c, before, p[k], p[k + 1], after);
    }
}

static void draw_glyph(const canvas *c, const char *strokes, double size, double x, double y)
{
    const double unit = size / CAPITAL;
    while (*strokes) {
        double p[POINTS][2] = {{0}};
        size_t n = 0;
        const int smooth = *strokes == '~';
        for (strokes += smooth; *strokes && *strokes != ' '; strokes += 2) {
            p[n][0] = x + unit * (strokes[0] >= 'A' ? strokes[0] - 'A' + 10 : strokes[0] - '0');
            p[n++][1] = y - unit * (strokes[1] - 'f');
        }
        draw_stroke(c, n, p, smooth);
        strokes += *strokes == ' ';
    }
}

void ff_strokes_draw(const char *text, double size, double x, double y, size_t nx, size_t ny, float *coverage)
{
    const canvas c = {nx, ny, coverage, fmax(0.5 * PEN * size, 0.5)};
    uint32_t code;
    while ((code = next_code(&text))) {
        const glyph *g = glyph_of(code);
        draw_glyph(&c, g->strokes, size, x, y);
        x += (g->width + SPACING) * size / CAPITAL;
    }
}
