/* Pictures beside each other with their labels, as a PNG. */
#include "internal_render.h"
#include "base/internal_options.h"
#include "report/plot/internal_canvas.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT = 256 };
static const size_t most_pixels = (size_t)1 << 28;

void ff_render_sheet_init_size(ff_render_sheet *s, size_t size)
{
    const ff_render_sheet defaults = {.clip = 0.25};
    ff_options_init(s, size, &defaults, sizeof defaults);
}

/* ---- layout ---------------------------------------------------------------------------------- */

/* Everything in pixels. */
typedef struct layout {
    size_t columns, rows, gap, label; /* label: height of a line of text below a picture, 0 where none has one */
    size_t nx, ny;
} layout;

static int has_label(const ff_render_cell *c)
{
    return c->label && *c->label;
}

static layout lay_out(const ff_render_sheet *s)
{
    layout l = {.columns = s->columns ? s->columns : s->n, .gap = s->n > 1 ? (s->pixels + 31) / 32 : 0};
    l.rows = (s->n + l.columns - 1) / l.columns;
    for (size_t k = 0; k < s->n; k++)
        if (has_label(&s->cell[k])) l.label = s->pixels / 12 > 16 ? s->pixels / 12 : 16;
    l.nx = l.columns * s->pixels + (l.columns + 1) * l.gap;
    l.ny = l.rows * (s->pixels + l.label) + (l.rows + 1) * l.gap;
    return l;
}

static ff_status check(const ff_render_sheet *s, ff_error *err)
{
    if (s->pixels < 1 || s->pixels > FF_RENDER_PIXELS_MAX || s->n < 1 || s->n > most_pixels || s->columns > most_pixels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a sheet of %zu pictures of %zu pixels, expected 1 or more of 1 to %d",
                            s->n, s->pixels, FF_RENDER_PIXELS_MAX);
    const size_t columns = s->columns ? s->columns : s->n, rows = (s->n + columns - 1) / columns;
    const double size = 1.2 * (double)s->pixels + 18;
    if (size * size * (double)columns * (double)rows > (double)most_pixels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "a sheet of %zu x %zu pictures of %zu pixels a side, expected less than 2^28 in all", columns, rows,
                            s->pixels);
    if (!(fabs(s->exposure) <= 64) || !(s->clip > 0 && isfinite(s->clip)) || !ff_render_tone_name((int)s->tone) ||
        !ff_render_background_name((int)s->background))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "exposure %g, clip %g, tone %d, background %d: expected -64 to 64, above 0, 0 to %d, 0 to %d",
                            s->exposure, s->clip, (int)s->tone, (int)s->background, FF_TONES - 1, FF_BACKGROUNDS - 1);
    return FF_OK;
}

/* ---- pixels ---------------------------------------------------------------------------------- */

typedef struct page {
    const ff_render_sheet *s;
    layout l;
    size_t channels;
    unsigned char *pixels; /* [ny][nx][channels] */
    float *text;           /* [ny][nx] coverage by letters */
    double factor;         /* of the exposure */
} page;

static unsigned char byte_of(double v)
{
    return (unsigned char)lround(255 * fmin(fmax(v, 0), 1));
}

static double background_of(const page *p)
{
    return p->s->background == FF_BACKGROUND_BLACK ? 0 : 1;
}

/* Of letters: black on white, white on black, and grey where nobody knows on what. */
static double ink_of(const page *p)
{
    return p->s->background == FF_BACKGROUND_TRANSPARENT ? 0.5 : 1 - background_of(p);
}

/* What is shown of a pixel of the sphere, by itself. */
static void shown(const page *p, const ff_render_cell *c, const float *rgba, double out[3])
{
    const double cover = (double)rgba[3];
    if (c->kind == FF_CELL_DIFFERENCE) {
        const double mean = ((double)rgba[0] + (double)rgba[1] + (double)rgba[2]) / (3 * cover);
        const uint32_t colour = ff_colour_of(FF_MAP_DIVERGING, 0.5 + 0.5 * mean * p->factor / p->s->clip);
        for (int k = 0; k < 3; k++) out[k] = (double)((colour >> (16 - 8 * k)) & 255) / 255;
        return;
    }
    for (int k = 0; k < 3; k++)
        out[k] = k && rgba[k] == rgba[k - 1] ? out[k - 1] : ff_render_tone_of(p->s->tone, (double)rgba[k] / cover * p->factor);
}

static void put_cell(page *p, const ff_render_cell *c, size_t left, size_t top)
{
    const size_t n = p->s->pixels;
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < n; i++) {
            const float *rgba = c->rgba + 4 * (j * n + i);
            unsigned char *to = p->pixels + p->channels * ((top + j) * p->l.nx + left + i);
            double v[3];
            if (!(rgba[3] > 0)) continue;
            const double cover = fmin((double)rgba[3], 1);
            shown(p, c, rgba, v);
            for (int k = 0; k < 3; k++) to[k] = byte_of(p->channels == 4 ? v[k] : cover * v[k] + (1 - cover) * background_of(p));
            if (p->channels == 4) to[3] = byte_of(cover);
        }
}

/* As large as its line lets it be, smaller where it is long, and cut where that is not enough. */
static void put_label(page *p, const char *label, size_t left, size_t top)
{
    char text[TEXT];
    const double room = (double)p->s->pixels, most = 0.5 * (double)p->l.label;
    double size = most;
    size_t n = (size_t)snprintf(text, sizeof text, "%s", label);
    if (n >= sizeof text) n = sizeof text - 1;
    const double width = ff_strokes_width(text, most);
    if (width > room) size = fmax(most * room / width, fmin(most, 8));
    while (n > 0 && ff_strokes_width(text, size) > room) {
        for (n--; n > 0 && ((unsigned char)text[n] & 0xc0) == 0x80;) n--;
        if (n + 4 < sizeof text) memcpy(text + n, "...", 4);
    }
    const double x = (double)left + 0.5 * (room - ff_strokes_width(text, size)), y = (double)top + 0.75 * (double)p->l.label;
    ff_strokes_draw(text, size, x, y, p->l.nx, p->l.ny, p->text);
}

/* Letters over what is there. */
static void ink(page *p)
{
    for (size_t k = 0; k < p->l.nx * p->l.ny; k++) {
        const double a = (double)p->text[k];
        unsigned char *to = p->pixels + p->channels * k;
        if (!(a > 0)) continue;
        for (int c = 0; c < 3; c++) to[c] = byte_of(p->channels == 4 ? ink_of(p) : a * ink_of(p) + (1 - a) * to[c] / 255.0);
        if (p->channels == 4) to[3] = byte_of(a);
    }
}

static void paint(page *p)
{
    const ff_render_sheet *s = p->s;
    for (size_t k = 0; k < s->n; k++) {
        const size_t left = p->l.gap + k % p->l.columns * (s->pixels + p->l.gap),
                     top = p->l.gap + k / p->l.columns * (s->pixels + p->l.label + p->l.gap);
        put_cell(p, &s->cell[k], left, top);
        if (has_label(&s->cell[k])) put_label(p, s->cell[k].label, left, top + s->pixels);
    }
    ink(p);
}

ff_status ff_render_png(const ff_render_sheet *s, unsigned char **png, size_t *n, ff_error *err)
{
    ff_render_sheet own;
    ff_render_sheet_init(&own);
    ff_status status = ff_options_take("ff_render_sheet", s, FF_END_OF(ff_render_sheet, background), &own, sizeof own, err);
    if (status == FF_OK) status = check(&own, err);
    if (status != FF_OK) return status;
    page p = {.s = &own, .l = lay_out(&own), .channels = own.background == FF_BACKGROUND_TRANSPARENT ? 4 : 3};
    const size_t bytes = p.l.nx * p.l.ny * p.channels;
    p.factor = exp2(own.exposure);
    p.pixels = malloc(bytes);
    p.text = calloc(p.l.nx * p.l.ny, sizeof *p.text);
    status = p.pixels && p.text ? FF_OK : FF_ERR_MEMORY;
    if (status == FF_OK) {
        memset(p.pixels, p.channels == 3 && background_of(&p) > 0 ? 255 : 0, bytes);
        paint(&p);
        status = ff_png_encode(p.l.nx, p.l.ny, p.channels, p.pixels, png, n);
    }
    free(p.pixels);
    free(p.text);
    if (status != FF_OK) ff_error_set(err, status, NULL, 0, -1, "no memory for a sheet of %zu x %zu pixels", p.l.nx, p.l.ny);
    return status;
}
