/** @file internal_figure.h  A figure before it is drawn: panels with axes, series of numbers, what stands beside them.
 *
 *  A kind of figure (kinds/) fills one; ff_figure_draw lays it out and draws it on a canvas, ff_figure_csv writes its numbers. The
 *  figure knows nothing of pages, the writers nothing of reflectance.
 *
 *      ff_panel *p = ff_figure_panel(fig, "θ_{i} = 30°");
 *      ff_axis_say(&p->x, "θ_{o}", "degrees", FF_SCALE_ANGLE, -90, 90);
 *      ff_series *s = ff_panel_series(fig, p, FF_SERIES_LINE, "model", ff_style_at(0), n, 0);
 *      if (s) for (i = 0; i < n; i++) s->x[i] = ..., s->y[i] = ...;
 *
 *  Text     UTF-8; "_{...}" is a subscript and "^{...}" a superscript. What others named goes through ff_figure_plain first.
 *  Memory   the figure owns panels, series and their arrays; ff_figure_clear releases all. Where there is none left, functions
 *           return NULL, take NULL, and fig->status is FF_ERR_MEMORY: a kind need look at it once, at its end.
 *  Numbers  NaN is a gap. What an axis cannot show (0 on a logarithmic one) is not drawn and stays in the CSV.
 *  Threads  a figure belongs to one thread at a time. */
#ifndef FF_INTERNAL_FIGURE_H
#define FF_INTERNAL_FIGURE_H
#include "ff_status.h"
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

enum { FF_FIGURE_TEXT = 320, FF_AXIS_NAME = 96 };

typedef enum ff_scale {
    FF_SCALE_LINEAR = 0,
    FF_SCALE_LOG = 1,
    FF_SCALE_ANGLE = 2, /* linear, in degrees: ticks at 15, 30, 45          */
    FF_SCALE_NAMES = 3  /* place k has name[k]; y from the top downwards    */
} ff_scale;

typedef struct ff_axis {
    char label[FF_FIGURE_TEXT], unit[32]; /* unit "" or "1": none is written                */
    ff_scale scale;
    double lo, hi; /* NaN: as the data have it                                  */
    size_t n_names;
    char (*name)[FF_AXIS_NAME];
    char ending[FF_AXIS_NAME]; /* of all names, where each is not to repeat it; in the CSV they are whole */
    int quiet;                 /* 1: the names stand beside another panel, and in the CSV */
} ff_axis;

/* How a series looks. Colours alone tell nothing in grey print: dash and marker go with them. */
typedef struct ff_style {
    int colour; /* index into ff_colour_at                                   */
    int dash;   /* index into the dashes of the canvas: 0 solid              */
    int marker; /* index into the markers: 0 dot                             */
} ff_style;

typedef enum ff_series_kind {
    FF_SERIES_LINE = 0,
    FF_SERIES_POINTS = 1, /* with error bars where low, high or x_low, x_high are there */
    FF_SERIES_BAND = 2,   /* between low and high                                       */
    FF_SERIES_IMAGE = 3,  /* cells of a regular lattice                                 */
    FF_SERIES_RULE = 4    /* a line across the panel at x[0], or at y[0] where that is NaN */
} ff_series_kind;
enum { FF_SERIES_KINDS = 5 };
const char *ff_series_kind_name(int kind); /* "line", "points", ...; NULL for a number that is none */

/* Columns beyond x and y. */
enum { FF_WITH_Y_ERRORS = 1, FF_WITH_X_ERRORS = 2 };

typedef enum ff_map { FF_MAP_VIRIDIS = 0, FF_MAP_DIVERGING = 1 } ff_map;

/* Cell (row r, column k) covers x_lo + (k, k+1) dx and y_lo + (r, r+1) dy; its value is z[r nx + k]. */
typedef struct ff_image {
    size_t nx, ny;
    double x_lo, x_hi, y_lo, y_hi;
    double *z; /* [ny][nx]; NaN: no value             */
    ff_map map;
    int log;     /* 1: colours by the logarithm, z > 0  */
    double clip; /* of the diverging map: colours end at -clip and clip; NaN: the largest |z| */
    int written; /* 1: the value stands in its cell     */
} ff_image;

typedef struct ff_series {
    ff_series_kind kind;
    char name[FF_FIGURE_TEXT]; /* in the legend; "": not in it */
    ff_style style;
    size_t n;
    double *x, *y, *low, *high, *x_low, *x_high; /* [n]; NULL where the series has none */
    ff_image image;
} ff_series;

typedef enum ff_panel_kind {
    FF_PANEL_PLANE = 0,
    FF_PANEL_POLAR = 1, /* upper half: x an angle from the normal in degrees, y the radius */
    FF_PANEL_DISC = 2   /* hemisphere from above: x azimuth, y polar angle, in degrees     */
} ff_panel_kind;

typedef struct ff_panel {
    ff_panel_kind kind;
    char title[FF_FIGURE_TEXT];
    ff_axis x, y, z; /* z: of an image's colours */
    double aspect;   /* height / width of the plane; 0: the usual one; of names by their number */
    int equal_cells; /* 1: a cell of the image is a square */
    size_t n_series;
    ff_series **series;
} ff_panel;

typedef struct ff_figure {
    ff_status status;
    char title[FF_FIGURE_TEXT];
    char note[2 * FF_FIGURE_TEXT]; /* under all: what must be known to read it; "" none */
    double width, height, font;    /* points; width 0: as is usual, height 0: as the panels have it */
    size_t columns;                /* of panels                                         */
    size_t n_panels;
    ff_panel **panel;
} ff_figure;

enum { FF_FIGURE_COLUMNS = 12 };

void ff_figure_init(ff_figure *fig); /* 8 pt, one column, as wide as is usual for it */
void ff_figure_clear(ff_figure *fig);

ff_panel *ff_figure_panel(ff_figure *fig, const char *title);
/* n >= 1; all numbers NaN. columns: FF_WITH_... . */
ff_series *ff_panel_series(ff_figure *fig, ff_panel *p, ff_series_kind kind, const char *name, ff_style style, size_t n,
                           int columns);
ff_series *ff_panel_image(ff_figure *fig, ff_panel *p, const char *name, size_t nx, size_t ny);
/* A line across at x = value, or at y. */
void ff_panel_rule_x(ff_figure *fig, ff_panel *p, const char *name, ff_style style, double x);
void ff_panel_rule_y(ff_figure *fig, ff_panel *p, const char *name, ff_style style, double y);
/* The series has only its first n points. */
void ff_series_cut(ff_series *s, size_t n);

void ff_axis_say(ff_axis *a, const char *label, const char *unit, ff_scale scale, double lo, double hi);
/* Makes it one of n names, "" each. */
void ff_axis_names(ff_figure *fig, ff_axis *a, size_t n);
void ff_axis_name(ff_axis *a, size_t k, const char *name);

/* Text of others without the meaning of its "_{" and "^{", controls and what is no UTF-8 as '?'. Returns out. */
const char *ff_figure_plain(const char *text, char *out, size_t size);
void ff_figure_note(ff_figure *fig, const char *format, ...) __attribute__((format(printf, 2, 3))); /* one more sentence */

/* The k-th of styles that differ in colour, dash and marker at once. */
ff_style ff_style_at(size_t k);
/* Names for what every figure has. */
enum {
    FF_COLOUR_BLUE,
    FF_COLOUR_VERMILLION,
    FF_COLOUR_GREEN,
    FF_COLOUR_PURPLE,
    FF_COLOUR_ORANGE,
    FF_COLOUR_SKY,
    FF_COLOUR_BLACK,
    FF_COLOUR_GREY,
    FF_COLOUR_LIGHT,
    FF_COLOUR_COUNT
};
enum { FF_DASH_SOLID, FF_DASH_LONG, FF_DASH_DOTTED, FF_DASH_DOT, FF_DASH_SHORT, FF_DASH_COUNT };
enum {
    FF_MARKER_DOT,
    FF_MARKER_SQUARE,
    FF_MARKER_TRIANGLE,
    FF_MARKER_DIAMOND,
    FF_MARKER_CROSS,
    FF_MARKER_DOWN,
    FF_MARKER_PLUS,
    FF_MARKER_COUNT
};

/* Fewer columns where the panels of as many would be narrow for their text. */
void ff_figure_narrow(ff_figure *fig);

/* ---- writers --------------------------------------------------------------------------------- */

/* What can be written, by the extension of the name. */
typedef enum ff_figure_form { FF_FIGURE_SVG = 0, FF_FIGURE_PDF = 1, FF_FIGURE_CSV = 2 } ff_figure_form;
enum { FF_FIGURE_FORMS = 3 };
const char *ff_figure_form_name(int form); /* "svg", "pdf", "csv" */
int ff_figure_form_find(const char *path); /* -1: none of them    */

/* FF_ERR_RANGE where the panels have no room, said in err; FF_ERR_MEMORY. */
ff_status ff_figure_write(const ff_figure *fig, ff_figure_form form, FILE *out, ff_error *err);
/* Rows panel,title,series,kind,x,y,low,high,x_low,x_high,z, with all digits; names for numbers where an axis has names. */
ff_status ff_figure_csv(const ff_figure *fig, FILE *out);

#endif
