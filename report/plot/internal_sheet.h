/* Where everything of a figure stands on its page. Boxes are in points, y downwards. */
#ifndef FF_INTERNAL_SHEET_H
#define FF_INTERNAL_SHEET_H
#include "internal_canvas.h"

enum { FF_TICKS = 80, FF_TICK_LABEL = 96, FF_AXIS_TEXT = FF_FIGURE_TEXT + 80 };

/* A tick; label "": a small one without a number. */
typedef struct ff_tick {
    double at;
    char label[FF_TICK_LABEL];
} ff_tick;

typedef struct ff_ticks {
    size_t n;
    int power; /* labels are numbers over 10^power, which stands with the unit; 0: as they are */
    ff_tick tick[FF_TICKS];
} ff_ticks;

/* Ticks from lo to hi on an axis `length` points long whose labels, of this size, do not meet: side by side, or (stacked) above
 * each other. */
void ff_ticks_make(ff_scale scale, double lo, double hi, double length, double size, int stacked, ff_ticks *out);
/* Place on the axis, 0 at lo and 1 at hi; NaN where it has none. */
double ff_scale_place(ff_scale scale, double lo, double hi, double x);
double ff_ticks_widest(const ff_ticks *t, double size);
/* "label (10^{-4} unit)"; "" where nothing is to be said. Returns out. */
const char *ff_axis_text(const ff_axis *a, const ff_ticks *t, char *out, size_t size);

typedef struct ff_box {
    double x, y, w, h;
} ff_box;

/* A panel laid out. */
typedef struct ff_spot {
    ff_box box;              /* of the axes                                                    */
    double x[2], y[2], z[2]; /* ends of the axes                                               */
    ff_ticks x_ticks, y_ticks, z_ticks;
    int has_bar;                     /* 1: an image whose colours mean something                       */
    int x_names_upwards;             /* 1: names of the x axis are turned, for they would meet         */
    double left, right, top, bottom; /* what stands around the box                            */
} ff_spot;

typedef struct ff_layout_entry {
    const ff_series *series;
    double x, y; /* of its sample's left end, on the baseline */
} ff_layout_entry;

enum { FF_NOTE_LINES = 8 };
typedef struct ff_sheet {
    const ff_figure *fig;
    double width, height;
    ff_spot *spot; /* [n_panels] */
    size_t n_entries;
    ff_layout_entry *entry;
    double title_y;
    size_t n_lines; /* of the note, and where the first stands */
    double note_y;
    char line[FF_NOTE_LINES][FF_FIGURE_TEXT];
} ff_sheet;

/* FF_ERR_RANGE where there is no room for the panels, FF_ERR_MEMORY. Release with ff_sheet_free. */
ff_status ff_sheet_make(const ff_figure *fig, ff_sheet *out, ff_error *err);
void ff_sheet_free(ff_sheet *s);

/* Parts of the layout in sizes of the font. */
#define FF_TICK_LENGTH 0.35
#define FF_LABEL_GAP   0.35 /* between tick and label           */
#define FF_LINE_HEIGHT 1.35
#define FF_LABEL_AWAY  0.6  /* of an upright label's baseline from the numbers */
#define FF_SAMPLE      2.8  /* of a line, in the legend         */
#define FF_BAR         1.0  /* width of the bar of colours      */
#define FF_NAME_ROOM   0.32 /* of the width, for names on an axis */
#define FF_ASCENT      0.72

/* Colours of an image end at these values. */
void ff_image_range(const ff_image *im, double out[2]);

/* Draws the sheet: an ff_drawing of a const ff_sheet *. */
ff_status ff_sheet_draw(const void *sheet, const ff_canvas *c);

/* The axes of a panel and what stands around them; then its series. */
void ff_axes_draw(const ff_sheet *sheet, const ff_panel *p, const ff_spot *s, const ff_canvas *c);
/* What lies beneath the series: lines at the ticks. */
void ff_grid_draw(const ff_panel *p, const ff_spot *spot, const ff_canvas *c);
ff_status ff_series_draw(const ff_sheet *s, const ff_panel *p, const ff_spot *spot, const ff_canvas *c);
/* A marker, or n of them: xy [n][2]. */
void ff_markers_draw(const ff_canvas *c, size_t n, const double *xy, ff_style style, double radius);
/* Where a point of the data is on the page. */
void ff_spot_place(const ff_panel *p, const ff_spot *spot, double x, double y, double out[2]);

#endif
