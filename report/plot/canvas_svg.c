/* A canvas as SVG 1.1: readable, one element a stroke, no scripts, no fonts of its own. */
#include "internal_canvas.h"
#include "internal_png.h"
#include "report/internal_text.h"
#include <math.h>
#include <string.h>

enum { FEW = 400, SHARP = 240 }; /* pixels across, at least */

typedef struct svg {
    FILE *out;
    int clips;
} svg;

static void put(svg *s, double x)
{
    char text[FF_POINT];
    fwrite(text, 1, ff_point_text(x, text), s->out);
}

static void put_escaped(FILE *out, const char *text, size_t length)
{
    for (size_t i = 0; i < length;) {
        uint32_t code = 0;
        const size_t n = ff_text_sequence(text + i, &code);
        if (n == 0 || ff_text_is_control(code) || code == 0xfffe || code == 0xffff)
            fputc('?', out);
        else if (code == '<' || code == '>' || code == '&' || code == '"')
            fprintf(out, "&#%u;", (unsigned)code);
        else
            fwrite(text + i, 1, n, out);
        i += n ? n : 1;
    }
}

static void put_attribute(svg *s, const char *name, double x)
{
    fprintf(s->out, " %s=\"", name);
    put(s, x);
    fputc('"', s->out);
}

static void put_pen(svg *s, const ff_pen *pen)
{
    double dash[6];
    if (pen->colour == FF_COLOUR_NONE) return;
    const size_t n = ff_dash_lengths(pen->dash, dash);
    fprintf(s->out, " stroke=\"#%06x\"", (unsigned)pen->colour);
    put_attribute(s, "stroke-width", pen->width);
    for (size_t i = 0; i < n; i++) {
        fputs(i ? "," : " stroke-dasharray=\"", s->out);
        put(s, dash[i] * pen->width);
    }
    if (n) fputc('"', s->out);
}

static void path(void *self, size_t n, const double *xy, int closed, const ff_pen *pen, uint32_t fill)
{
    svg *s = self;
    int down = 0;
    fputs("<path d=\"", s->out);
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(xy[2 * i]) || !isfinite(xy[2 * i + 1])) {
            if (down && closed) fputc('z', s->out);
            down = 0;
            continue;
        }
        fputc(down ? 'L' : 'M', s->out);
        put(s, xy[2 * i]);
        fputc(' ', s->out);
        put(s, xy[2 * i + 1]);
        down = 1;
    }
    if (down && closed) fputc('z', s->out);
    fputc('"', s->out);
    if (fill == FF_COLOUR_NONE)
        fputs(" fill=\"none\"", s->out);
    else
        fprintf(s->out, " fill=\"#%06x\"", (unsigned)fill);
    put_pen(s, pen);
    fputs("/>\n", s->out);
}

/* Lines of no length with round ends: a dozen bytes each. */
static void dots(void *self, size_t n, const double *xy, double radius, uint32_t colour)
{
    svg *s = self;
    fputs("<path d=\"", s->out);
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(xy[2 * i]) || !isfinite(xy[2 * i + 1])) continue;
        fputc('M', s->out);
        put(s, xy[2 * i]);
        fputc(' ', s->out);
        put(s, xy[2 * i + 1]);
        fputs("h0", s->out);
    }
    fprintf(s->out, "\" fill=\"none\" stroke-linecap=\"round\" stroke=\"#%06x\"", (unsigned)colour);
    put_attribute(s, "stroke-width", 2 * radius);
    fputs("/>\n", s->out);
}

/* Raised and lowered runs are spans; what follows them goes back by as much. */
static void text(void *self, const ff_text *t)
{
    static const char *const anchor[] = {"", " text-anchor=\"middle\"", " text-anchor=\"end\""};
    svg *s = self;
    const char *rest = t->text;
    double at = 0;
    ff_run run;
    if (!*t->text) return;
    fputs("<text", s->out);
    put_attribute(s, "x", t->x);
    put_attribute(s, "y", t->y);
    put_attribute(s, "font-size", t->size);
    fputs(anchor[t->anchor], s->out);
    if (t->colour) fprintf(s->out, " fill=\"#%06x\"", (unsigned)t->colour);
    if (t->upwards) {
        fputs(" transform=\"rotate(-90 ", s->out);
        put(s, t->x);
        fputc(' ', s->out);
        put(s, t->y);
        fputs(")\"", s->out);
    }
    fputc('>', s->out);
    while (ff_run_next(&rest, &run)) {
        const double to = -ff_run_rise(run.level) * t->size;
        const int span = run.level || at != 0;
        if (span) {
            fputs("<tspan", s->out);
            put_attribute(s, "dy", to - at);
            if (run.level) put_attribute(s, "font-size", FF_RUN_SIZE * t->size);
            fputc('>', s->out);
        }
        put_escaped(s->out, run.text, run.length);
        if (span) fputs("</tspan>", s->out);
        at = to;
    }
    fputs("</text>\n", s->out);
}

/* Few cells are areas of their own: sharp in every viewer, and to be edited. Neighbours of one colour are one area, and each
 * reaches a little under the next ones, that nothing shines through where a viewer rounds to its pixels. */
static void cells(svg *s, const double box[4], size_t nx, size_t ny, const unsigned char *rgb)
{
    const double w = box[2] / (double)nx, h = box[3] / (double)ny, under = 0.3;
    fputs("<g shape-rendering=\"crispEdges\">\n", s->out);
    for (size_t first = 0, end; first < nx * ny; first = end) {
        const size_t row = first / nx;
        for (end = first + 1; end < (row + 1) * nx && !memcmp(rgb + 3 * first, rgb + 3 * end, 3);) end++;
        fprintf(s->out, "<rect fill=\"#%02x%02x%02x\"", rgb[3 * first], rgb[3 * first + 1], rgb[3 * first + 2]);
        put_attribute(s, "x", box[0] + (double)(first % nx) * w);
        put_attribute(s, "y", box[1] + (double)row * h);
        put_attribute(s, "width", (double)(end - first) * w + (end % nx ? under : 0));
        put_attribute(s, "height", h + (row + 1 < ny ? under : 0));
        fputs("/>\n", s->out);
    }
    fputs("</g>\n", s->out);
}

static void image(void *self, const double box[4], size_t nx, size_t ny, const unsigned char *rgb)
{
    svg *s = self;
    if (nx > 1 && nx * ny <= FEW) {
        cells(s, box, nx, ny, rgb);
        return;
    }
    fputs("<image", s->out);
    put_attribute(s, "x", box[0]);
    put_attribute(s, "y", box[1]);
    put_attribute(s, "width", box[2]);
    put_attribute(s, "height", box[3]);
    fputs(" preserveAspectRatio=\"none\" image-rendering=\"optimizeSpeed\" style=\"image-rendering:pixelated\" "
          "xlink:href=\"data:image/png;base64,",
          s->out);
    const size_t most = nx > ny ? nx : ny, times = most < SHARP ? (SHARP + most - 1) / most : 1;
    ff_png_base64(nx, ny, rgb, times, s->out);
    fputs("\"/>\n", s->out);
}

static void clip(void *self, const double box[4])
{
    svg *s = self;
    s->clips++;
    fprintf(s->out, "<clipPath id=\"c%d\"><rect", s->clips);
    put_attribute(s, "x", box[0]);
    put_attribute(s, "y", box[1]);
    put_attribute(s, "width", box[2]);
    put_attribute(s, "height", box[3]);
    fprintf(s->out, "/></clipPath>\n<g clip-path=\"url(#c%d)\">\n", s->clips);
}

static void unclip(void *self)
{
    svg *s = self;
    fputs("</g>\n", s->out);
}

ff_status ff_canvas_svg(FILE *out, double width, double height, const char *title, ff_drawing draw, const void *figure)
{
    svg s = {.out = out};
    const ff_canvas canvas = {&s, path, dots, text, image, clip, unclip};
    const double box[] = {0, 0, width, 0, width, height, 0, height};
    fputs("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
          "xmlns:xlink=\"http://www.w3.org/1999/xlink\" version=\"1.1\" width=\"",
          out);
    put(&s, width);
    fputs("pt\" height=\"", out);
    put(&s, height);
    fputs("pt\" viewBox=\"0 0 ", out);
    put(&s, width);
    fputc(' ', out);
    put(&s, height);
    fputs("\" font-family=\"Helvetica, Arial, 'Liberation Sans', 'Nimbus Sans', sans-serif\" stroke-linejoin=\"round\" "
          "xml:space=\"preserve\">\n<title>",
          out);
    for (ff_run run; ff_run_next(&title, &run);) put_escaped(out, run.text, run.length);
    fputs("</title>\n", out);
    path(&s, 4, box, 1, &(ff_pen){.colour = FF_COLOUR_NONE}, 0xffffff);
    const ff_status status = draw(figure, &canvas);
    fputs("</svg>\n", out);
    return status;
}
