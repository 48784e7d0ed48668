/* Series, legend, title and note on a canvas. */
#include "internal_sheet.h"
#include "report/internal_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const ff_pen no_pen = {.colour = FF_COLOUR_NONE};
enum { DENSE = 120, DENSE_ROUND = 24 }; /* bars: round a disc they meet in its middle */
#define LINE_WIDTH 1.1
#define STEPS      240.0 /* of colour, so that they make a palette */

static double marker_radius(const ff_sheet *s, size_t n)
{
    return s->fig->font * (n > 400 ? 0.09 : n > 60 ? 0.14 : 0.2);
}

/* ---- markers --------------------------------------------------------------------------------- */

/* Corners on a circle of radius 1; 0 corners: a dot. Crosses are two strokes. */
static const struct {
    double first; /* angle of the first corner, in right angles */
    double scale;
    int corners, strokes;
} shapes[FF_MARKER_COUNT] = {{0, 1, 0, 0},     {0.5, 1.15, 4, 0}, {1, 1.3, 3, 0}, {0, 1.25, 4, 0},
                             {0.5, 1.2, 4, 1}, {-1, 1.3, 3, 0},   {0, 1.25, 4, 1}};

void ff_markers_draw(const ff_canvas *c, size_t n, const double *xy, ff_style style, double radius)
{
    const int m = style.marker >= 0 && style.marker < FF_MARKER_COUNT ? style.marker : 0;
    const uint32_t colour = ff_colour_at(style.colour);
    if (!shapes[m].corners) {
        c->dots(c->self, n, xy, radius, colour);
        return;
    }
    for (size_t i = 0; i < n; i++) {
        double corner[4][2];
        if (!isfinite(xy[2 * i]) || !isfinite(xy[2 * i + 1])) continue;
        for (int k = 0; k < shapes[m].corners; k++) {
            const double angle = (shapes[m].first + 4.0 * k / shapes[m].corners) * 1.5707963267948966;
            corner[k][0] = xy[2 * i] + shapes[m].scale * radius * cos(angle);
            corner[k][1] = xy[2 * i + 1] - shapes[m].scale * radius * sin(angle);
        }
        if (!shapes[m].strokes) {
            c->path(c->self, (size_t)shapes[m].corners, corner[0], 1, &no_pen, colour);
            continue;
        }
        for (int k = 0; k < 2; k++) {
            const double stroke[] = {corner[k][0], corner[k][1], corner[k + 2][0], corner[k + 2][1]};
            c->path(c->self, 2, stroke, 0, &(ff_pen){0.5 * radius, colour, FF_DASH_SOLID}, FF_COLOUR_NONE);
        }
    }
}

/* ---- series ---------------------------------------------------------------------------------- */

static void place_all(const ff_panel *p, const ff_spot *spot, size_t n, const double *x, const double *y, double *xy)
{
    for (size_t i = 0; i < n; i++) ff_spot_place(p, spot, x[i], y[i], xy + 2 * i);
}

/* On a logarithmic axis a bar that reaches 0 ends at the axis. */
static double end_of(const ff_axis *a, double lo, double x)
{
    return a->scale == FF_SCALE_LOG && !(x > 0) ? lo : x;
}

/* Lighter than the points, which many bars beside each other would hide. */
static uint32_t error_colour(ff_style style)
{
    return ff_colour_mix(ff_colour_at(style.colour), 0xffffff, 0.4);
}

static void draw_errors(const ff_panel *p, const ff_spot *spot, const ff_series *s, const ff_canvas *c)
{
    const ff_pen pen = {0.6, error_colour(s->style), FF_DASH_SOLID}, across = {0.6, ff_colour_at(s->style.colour), FF_DASH_SOLID};
    const size_t most = p->kind == FF_PANEL_POLAR ? DENSE_ROUND : DENSE,
                 step = s->n > most ? (s->n + most / 2 - 1) / (most / 2) : 1; /* so many that they would hide the points */
    for (size_t i = 0; i < s->n; i += step) {
        double xy[2][2];
        if (s->low && isfinite(s->low[i]) && isfinite(s->high[i])) {
            ff_spot_place(p, spot, s->x[i], end_of(&p->y, spot->y[0], s->low[i]), xy[0]);
            ff_spot_place(p, spot, s->x[i], p->kind == FF_PANEL_POLAR ? fmin(s->high[i], spot->y[1]) : s->high[i], xy[1]);
            c->path(c->self, 2, xy[0], 0, &pen, FF_COLOUR_NONE);
        }
        if (s->x_low && isfinite(s->x_low[i]) && isfinite(s->x_high[i])) {
            ff_spot_place(p, spot, end_of(&p->x, spot->x[0], s->x_low[i]), s->y[i], xy[0]);
            ff_spot_place(p, spot, s->x_high[i], s->y[i], xy[1]);
            c->path(c->self, 2, xy[0], 0, &across, FF_COLOUR_NONE);
        }
    }
}

static void draw_band(const ff_panel *p, const ff_spot *spot, const ff_series *s, double *xy, const ff_canvas *c)
{
    size_t n = 0;
    for (size_t i = 0; i < s->n && s->low; i++) {
        const double low = end_of(&p->y, spot->y[0], s->low[i]);
        if (isfinite(low) && isfinite(s->high[i])) ff_spot_place(p, spot, s->x[i], low, xy + 2 * n++);
    }
    for (size_t i = s->n; i-- > 0 && s->low;)
        if (isfinite(end_of(&p->y, spot->y[0], s->low[i])) && isfinite(s->high[i]))
            ff_spot_place(p, spot, s->x[i], s->high[i], xy + 2 * n++);
    c->path(c->self, n, xy, 1, &no_pen, ff_colour_mix(ff_colour_at(s->style.colour), 0xffffff, 0.72));
}

static void draw_rule(const ff_panel *p, const ff_spot *spot, const ff_series *s, const ff_canvas *c)
{
    const int upright = isfinite(s->x[0]);
    const ff_pen pen = {0.7, ff_colour_at(s->style.colour), s->style.dash};
    double xy[2][2];
    const double log_end = spot->y[0];
    ff_spot_place(p, spot, upright ? s->x[0] : spot->x[0], upright ? log_end : s->y[0], xy[0]);
    ff_spot_place(p, spot, upright ? s->x[0] : spot->x[1], upright ? spot->y[1] : s->y[0], xy[1]);
    if (p->y.scale == FF_SCALE_NAMES && upright) {
        xy[0][1] = spot->box.y;
        xy[1][1] = spot->box.y + spot->box.h;
    }
    c->path(c->self, 2, xy[0], 0, &pen, FF_COLOUR_NONE);
}

/* ---- images ---------------------------------------------------------------------------------- */

static double image_place(const ff_image *im, const double range[2], double z)
{
    return ff_scale_place(im->log ? FF_SCALE_LOG : FF_SCALE_LINEAR, range[0], range[1], z);
}

static void image_box(const ff_panel *p, const ff_spot *spot, const ff_image *im, double box[4])
{
    double a[2], b[2];
    if (p->kind == FF_PANEL_DISC) {
        box[0] = spot->box.x, box[1] = spot->box.y, box[2] = spot->box.w, box[3] = spot->box.h;
        return;
    }
    ff_spot_place(p, spot, im->x_lo, im->y_lo, a);
    ff_spot_place(p, spot, im->x_hi, im->y_hi, b);
    box[0] = fmin(a[0], b[0]), box[1] = fmin(a[1], b[1]);
    box[2] = fabs(b[0] - a[0]), box[3] = fabs(b[1] - a[1]);
}

static void write_cells(const ff_sheet *s, const ff_image *im, const double box[4], const double range[2], const ff_canvas *c)
{
    const double w = box[2] / (double)im->nx, h = box[3] / (double)im->ny;
    double size = 0.9 * s->fig->font;
    while (size > 3 && ff_text_points("−0.00", size) > 0.9 * w) size *= 0.9;
    if (size <= 3 || size > h) return;
    for (size_t i = 0; i < im->nx * im->ny; i++) {
        char number[FF_TEXT_NUMBER], text[FF_TEXT_NUMBER + 4];
        const size_t row = i / im->nx;
        if (!isfinite(im->z[i])) continue;
        ff_text_fixed(im->z[i], 2, number);
        snprintf(text, sizeof text, "%s%s", *number == '-' ? "−" : "", number + (*number == '-'));
        const double t = image_place(im, range, im->z[i]);
        const uint32_t colour = im->map == FF_MAP_DIVERGING ? (t < 0.2 || t > 0.85 ? 0xffffff : 0) : (t < 0.5 ? 0xffffff : 0);
        c->text(c->self,
                &(ff_text){box[0] + ((double)(i % im->nx) + 0.5) * w, box[1] + ((double)row + 0.5) * h + FF_ASCENT / 2 * size,
                           FF_ANCHOR_MIDDLE, 0, size, colour, text});
    }
}

static ff_status draw_image(const ff_sheet *s, const ff_panel *p, const ff_spot *spot, const ff_image *im, const ff_canvas *c)
{
    unsigned char *rgb = malloc(3 * im->nx * im->ny + 1);
    const int downwards = p->y.scale == FF_SCALE_NAMES;
    double range[2], box[4];
    if (!rgb) return FF_ERR_MEMORY;
    ff_image_range(im, range);
    for (size_t r = 0; r < im->ny; r++)
        for (size_t k = 0; k < im->nx; k++) {
            const double z = im->z[r * im->nx + k];
            uint32_t colour = ff_colour_of(im->map, isfinite(z) ? round(image_place(im, range, z) * STEPS) / STEPS : NAN);
            if (p->kind == FF_PANEL_DISC && !isfinite(z)) colour = 0xffffff;
            unsigned char *to = rgb + 3 * ((downwards ? r : im->ny - 1 - r) * im->nx + k);
            for (int b = 0; b < 3; b++) to[b] = (unsigned char)(colour >> (16 - 8 * b));
        }
    image_box(p, spot, im, box);
    c->image(c->self, box, im->nx, im->ny, rgb);
    if (im->written) write_cells(s, im, box, range, c);
    free(rgb);
    return FF_OK;
}

static ff_status draw_one(const ff_sheet *sheet, const ff_panel *p, const ff_spot *spot, const ff_series *s, const ff_canvas *c)
{
    if (s->kind == FF_SERIES_IMAGE) return draw_image(sheet, p, spot, &s->image, c);
    double *xy = malloc((4 * s->n + 2) * sizeof *xy);
    if (!xy) return FF_ERR_MEMORY;
    if (s->kind == FF_SERIES_LINE) {
        place_all(p, spot, s->n, s->x, s->y, xy);
        c->path(c->self, s->n, xy, 0, &(ff_pen){LINE_WIDTH, ff_colour_at(s->style.colour), s->style.dash}, FF_COLOUR_NONE);
    } else if (s->kind == FF_SERIES_POINTS) {
        draw_errors(p, spot, s, c);
        place_all(p, spot, s->n, s->x, s->y, xy);
        ff_markers_draw(c, s->n, xy, s->style, marker_radius(sheet, s->n));
    } else if (s->kind == FF_SERIES_BAND) {
        draw_band(p, spot, s, xy, c);
    } else {
        draw_rule(p, spot, s, c);
    }
    free(xy);
    return FF_OK;
}

ff_status ff_series_draw(const ff_sheet *sheet, const ff_panel *p, const ff_spot *spot, const ff_canvas *c)
{
    const double box[] = {spot->box.x, spot->box.y, spot->box.w, spot->box.h};
    ff_status status = FF_OK;
    c->clip(c->self, box);
    for (size_t k = 0; k < p->n_series && !status; k++) status = draw_one(sheet, p, spot, p->series[k], c);
    c->unclip(c->self);
    return status;
}

/* ---- the sheet ------------------------------------------------------------------------------- */

static void draw_sample(const ff_sheet *s, const ff_layout_entry *e, const ff_canvas *c)
{
    const double size = s->fig->font, y = e->y - 0.28 * size, w = FF_SAMPLE * size, middle[] = {e->x + w / 2, y};
    const double ends[] = {e->x, y, e->x + w, y}, h = 0.35 * size;
    const ff_style style = e->series->style;
    if (e->series->kind == FF_SERIES_BAND) {
        const double area[] = {e->x, y - h, e->x + w, y - h, e->x + w, y + h, e->x, y + h};
        c->path(c->self, 4, area, 1, &no_pen, ff_colour_mix(ff_colour_at(style.colour), 0xffffff, 0.72));
    } else if (e->series->kind == FF_SERIES_POINTS) {
        const double bar[] = {middle[0], y - 0.45 * size, middle[0], y + 0.45 * size};
        if (e->series->low) c->path(c->self, 2, bar, 0, &(ff_pen){0.6, error_colour(style), 0}, FF_COLOUR_NONE);
        ff_markers_draw(c, 1, middle, style, 0.2 * size);
    } else {
        const double width = e->series->kind == FF_SERIES_RULE ? 0.7 : LINE_WIDTH;
        c->path(c->self, 2, ends, 0, &(ff_pen){width, ff_colour_at(style.colour), style.dash}, FF_COLOUR_NONE);
    }
}

static void draw_legend(const ff_sheet *s, const ff_canvas *c)
{
    const double size = s->fig->font, sample = (FF_SAMPLE + 0.5) * size;
    for (size_t k = 0; k < s->n_entries; k++) {
        const ff_layout_entry *e = &s->entry[k];
        char text[FF_FIGURE_TEXT + 8];
        draw_sample(s, e, c);
        ff_text_fit(e->series->name, size, s->width - sample - size, text, sizeof text);
        c->text(c->self, &(ff_text){e->x + sample, e->y, FF_ANCHOR_LEFT, 0, size, 0, text});
    }
}

static int has_value(const ff_panel *p)
{
    for (size_t k = 0; k < p->n_series; k++) {
        const ff_series *s = p->series[k];
        if (s->kind == FF_SERIES_RULE) continue;
        for (size_t i = 0; i < s->n; i++)
            if (isfinite(s->x[i]) && isfinite(s->y[i])) return 1;
        for (size_t i = 0; i < s->image.nx * s->image.ny; i++)
            if (isfinite(s->image.z[i])) return 1;
    }
    return 0;
}

/* A panel without a value says that it has none, for it might be thought to be unfinished. */
static void say_empty(const ff_sheet *s, const ff_spot *spot, const ff_canvas *c)
{
    c->text(c->self, &(ff_text){spot->box.x + spot->box.w / 2, spot->box.y + spot->box.h / 2, FF_ANCHOR_MIDDLE, 0, s->fig->font,
                                0x606060, "no values"});
}

ff_status ff_sheet_draw(const void *sheet, const ff_canvas *c)
{
    const ff_sheet *s = sheet;
    const ff_figure *fig = s->fig;
    char title[FF_FIGURE_TEXT + 8];
    ff_status status = FF_OK;
    ff_text_fit(fig->title, 1.1 * fig->font, s->width - 0.6 * fig->font, title, sizeof title);
    c->text(c->self, &(ff_text){0.3 * fig->font, s->title_y, FF_ANCHOR_LEFT, 0, 1.1 * fig->font, 0, title});
    for (size_t i = 0; i < fig->n_panels && !status; i++) {
        const ff_panel *p = fig->panel[i];
        ff_grid_draw(p, &s->spot[i], c);
        if (p->kind != FF_PANEL_PLANE && !s->spot[i].has_bar) ff_axes_draw(s, p, &s->spot[i], c);
        status = ff_series_draw(s, p, &s->spot[i], c);
        if (p->kind == FF_PANEL_PLANE || s->spot[i].has_bar) ff_axes_draw(s, p, &s->spot[i], c);
        if (!has_value(p)) say_empty(s, &s->spot[i], c);
    }
    draw_legend(s, c);
    for (size_t k = 0; k < s->n_lines; k++)
        c->text(c->self, &(ff_text){0.3 * fig->font, s->note_y + (double)k * FF_LINE_HEIGHT * 0.9 * fig->font, FF_ANCHOR_LEFT, 0,
                                    0.9 * fig->font, 0x404040, s->line[k]});
    return status;
}
