/** @file internal_canvas.h  What a figure is drawn on: lines, areas, text, images, on a page in points (1/72 inch).
 *
 *  x to the right, y downwards from the upper left corner. Two backends write it, SVG and PDF; a third would be one more ff_canvas.
 *  Numbers  are written with two digits after the point, the same in every locale.
 *  Text     as internal_figure.h has it, in Helvetica; its width is ff_text_points of the metrics, not the reader's font. */
#ifndef FF_INTERNAL_CANVAS_H
#define FF_INTERNAL_CANVAS_H
#include "internal_figure.h"

enum { FF_COLOUR_NONE = 0xff000000 }; /* no stroke, no fill */

typedef struct ff_pen {
    double width;    /* points         */
    uint32_t colour; /* 0xrrggbb       */
    int dash;        /* FF_DASH_...    */
} ff_pen;

typedef enum ff_anchor { FF_ANCHOR_LEFT = 0, FF_ANCHOR_MIDDLE = 1, FF_ANCHOR_RIGHT = 2 } ff_anchor;

typedef struct ff_text {
    double x, y; /* of the anchor, on the baseline */
    ff_anchor anchor;
    int upwards; /* 1: turned by 90 degrees, read from below */
    double size;
    uint32_t colour;
    const char *text;
} ff_text;

/* A backend. `self` is its own. */
typedef struct ff_canvas {
    void *self;
    /* xy [n][2]; NaN between two points lifts the pen. closed: an area, filled with `fill` and stroked with `pen`, either of which
     * may be none (pen->colour FF_COLOUR_NONE). */
    void (*path)(void *self, size_t n, const double *xy, int closed, const ff_pen *pen, uint32_t fill);
    /* n discs of one radius. */
    void (*dots)(void *self, size_t n, const double *xy, double radius, uint32_t colour);
    void (*text)(void *self, const ff_text *text);
    /* rgb [ny][nx][3], the first row on top. */
    void (*image)(void *self, const double box[4], size_t nx, size_t ny, const unsigned char *rgb);
    void (*clip)(void *self, const double box[4]); /* x, y, width, height; until unclip; not nested */
    void (*unclip)(void *self);
} ff_canvas;

/* A page of width x height points. Returns FF_ERR_MEMORY, or what draw does. */
typedef ff_status (*ff_drawing)(const void *figure, const ff_canvas *canvas);
ff_status ff_canvas_svg(FILE *out, double width, double height, const char *title, ff_drawing draw, const void *figure);
ff_status ff_canvas_pdf(FILE *out, double width, double height, const char *title, ff_drawing draw, const void *figure);

/* Lengths of dash and gap in turn, in widths of the pen; the count, 0 for a solid one. */
size_t ff_dash_lengths(int dash, double out[6]);

/* Fixed point with two digits, no zeros at the end. The length; out [FF_POINT]. */
enum { FF_POINT = 32 };
size_t ff_point_text(double x, char out[FF_POINT]);

/* ---- text ------------------------------------------------------------------------------------ */

/* A run of text between changes of its level. */
typedef struct ff_run {
    const char *text;
    size_t length;
    int level; /* 0 on the line, 1 raised, -1 lowered */
} ff_run;
/* The next run at *text, which moves on. 0 at the end. */
int ff_run_next(const char **text, ff_run *out);
#define FF_RUN_SIZE  0.7  /* of raised and lowered runs, in sizes of the line */
#define FF_RUN_RAISE 0.35 /* by which they are raised; lowered by half of it   */

double ff_run_rise(int level); /* in sizes of the line */

/* Width in points. Adobe's metrics of Helvetica and, for Greek, Symbol. */
double ff_text_points(const char *text, double size);
double ff_run_points(const char *text, size_t length, double size);
/* What a code point is drawn with: its place in WinAnsi or in the font Symbol, both 0 where neither has it. */
typedef struct ff_glyph {
    double width; /* advance in thousandths of the size of the line */
    unsigned char latin, symbol;
    int level; /* of a small one: as of a run                       */
} ff_glyph;
ff_glyph ff_glyph_of(uint32_t code);
/* As much of text as fits into `points`, with an ellipsis where something is missing. Returns out. */
const char *ff_text_fit(const char *text, double size, double points, char *out, size_t room);

/* ---- colours --------------------------------------------------------------------------------- */

uint32_t ff_colour_at(int colour);
uint32_t ff_colour_mix(uint32_t a, uint32_t b, double share);
/* t in [0, 1]; not finite: the grey of no value. */
uint32_t ff_colour_of(ff_map map, double t);

#endif
