/* Axes: frame, grid, ticks, labels, the bar of colours, and their round counterparts. */
#include "internal_sheet.h"
#include <math.h>
#include <string.h>

static const uint32_t ink = 0x000000, faint = 0xe2e2e2, soft = 0x8c8c8c;
static const double degree = 3.14159265358979323846 / 180;

static void line(const ff_canvas *c, double x0, double y0, double x1, double y1, double width, uint32_t colour)
{
    const double xy[] = {x0, y0, x1, y1};
    c->path(c->self, 2, xy, 0, &(ff_pen){width, colour, FF_DASH_SOLID}, FF_COLOUR_NONE);
}

static void write_text(const ff_canvas *c, double x, double y, ff_anchor anchor, double size, const char *text)
{
    c->text(c->self, &(ff_text){x, y, anchor, 0, size, ink, text});
}

/* What an axis shows, with its unit, beside its ticks. */
static void write_label(const ff_sheet *s, const ff_canvas *c, const char *whole, double x, double y, double room, int upwards)
{
    char text[FF_AXIS_TEXT + 8];
    ff_text_fit(whole, s->fig->font, room, text, sizeof text);
    c->text(c->self, &(ff_text){x, y, FF_ANCHOR_MIDDLE, upwards, s->fig->font, ink, text});
}

/* ---- a plane --------------------------------------------------------------------------------- */

static double x_at(const ff_panel *p, const ff_spot *s, double x)
{
    return s->box.x + ff_scale_place(p->x.scale, s->x[0], s->x[1], x) * s->box.w;
}

/* Names go down the page, numbers up. */
static double y_at(const ff_panel *p, const ff_spot *s, double y)
{
    const double at = ff_scale_place(p->y.scale, s->y[0], s->y[1], y);
    return s->box.y + (p->y.scale == FF_SCALE_NAMES ? at : 1 - at) * s->box.h;
}

static void draw_x(const ff_sheet *sheet, const ff_panel *p, const ff_spot *s, const ff_canvas *c)
{
    const double size = sheet->fig->font, bottom = s->box.y + s->box.h,
                 base = bottom + (FF_TICK_LENGTH + FF_LABEL_GAP + FF_ASCENT) * size;
    char text[FF_AXIS_TEXT];
    for (size_t k = 0; k < s->x_ticks.n; k++) {
        const ff_tick *t = &s->x_ticks.tick[k];
        const double x = x_at(p, s, t->at);
        line(c, x, bottom, x, bottom + (t->label[0] ? 1 : 0.6) * FF_TICK_LENGTH * size, 0.6, ink);
        write_text(c, x, base, FF_ANCHOR_MIDDLE, size, t->label);
    }
    for (size_t k = 0; k < p->x.n_names; k++) {
        const double x = x_at(p, s, (double)k);
        char name[FF_AXIS_NAME + 8];
        ff_text_fit(p->x.name[k], size, s->x_names_upwards ? FF_NAME_ROOM * sheet->width : s->box.w, name, sizeof name);
        if (s->x_names_upwards)
            c->text(c->self, &(ff_text){x + 0.35 * size, bottom + (FF_TICK_LENGTH + FF_LABEL_GAP) * size, FF_ANCHOR_RIGHT, 1, size,
                                        ink, name});
        else
            write_text(c, x, base, FF_ANCHOR_MIDDLE, size, name);
    }
    if (*ff_axis_text(&p->x, &s->x_ticks, text, sizeof text))
        write_label(sheet, c, text, s->box.x + s->box.w / 2, s->box.y + s->box.h + s->bottom - 0.35 * size,
                    s->box.w + 2 * fmin(s->left, s->right), 0);
}

static void draw_y(const ff_sheet *sheet, const ff_panel *p, const ff_spot *s, const ff_canvas *c)
{
    const double size = sheet->fig->font, x = s->box.x, gap = (FF_TICK_LENGTH + FF_LABEL_GAP) * size;
    double widest = ff_ticks_widest(&s->y_ticks, size);
    char text[FF_AXIS_TEXT];
    for (size_t k = 0; k < s->y_ticks.n; k++) {
        const ff_tick *t = &s->y_ticks.tick[k];
        const double y = y_at(p, s, t->at);
        line(c, x - (t->label[0] ? 1 : 0.6) * FF_TICK_LENGTH * size, y, x, y, 0.6, ink);
        write_text(c, x - gap, y + FF_ASCENT / 2 * size, FF_ANCHOR_RIGHT, size, t->label);
    }
    for (size_t k = 0; k < p->y.n_names && !p->y.quiet; k++) {
        char name[FF_AXIS_NAME + 8];
        ff_text_fit(p->y.name[k], size, FF_NAME_ROOM * sheet->width, name, sizeof name);
        write_text(c, x - gap, y_at(p, s, (double)k) + FF_ASCENT / 2 * size, FF_ANCHOR_RIGHT, size, name);
        widest = fmax(widest, ff_text_points(name, size));
    }
    if (*ff_axis_text(&p->y, &s->y_ticks, text, sizeof text))
        write_label(sheet, c, text, x - gap - widest - FF_LABEL_AWAY * size, s->box.y + s->box.h / 2, s->box.h + s->top, 1);
}

static void draw_grid(const ff_panel *p, const ff_spot *s, const ff_canvas *c)
{
    for (size_t k = 0; k < s->x_ticks.n; k++) {
        const double x = x_at(p, s, s->x_ticks.tick[k].at);
        if (s->x_ticks.tick[k].label[0]) line(c, x, s->box.y, x, s->box.y + s->box.h, 0.4, faint);
    }
    for (size_t k = 0; k < s->y_ticks.n; k++) {
        const double y = y_at(p, s, s->y_ticks.tick[k].at);
        if (s->y_ticks.tick[k].label[0]) line(c, s->box.x, y, s->box.x + s->box.w, y, 0.4, faint);
    }
    for (size_t k = 0; k < p->y.n_names; k++)
        line(c, s->box.x, y_at(p, s, (double)k), s->box.x + s->box.w, y_at(p, s, (double)k), 0.4, faint);
}

static void draw_frame(const ff_spot *s, const ff_canvas *c)
{
    const double x = s->box.x, y = s->box.y, xy[] = {x, y, x + s->box.w, y, x + s->box.w, y + s->box.h, x, y + s->box.h};
    c->path(c->self, 4, xy, 1, &(ff_pen){0.6, ink, FF_DASH_SOLID}, FF_COLOUR_NONE);
}

/* ---- the bar of colours ---------------------------------------------------------------------- */

static void draw_bar(const ff_sheet *sheet, const ff_panel *p, const ff_spot *s, const ff_image *im, const ff_canvas *c)
{
    enum { STEPS = 128 };
    unsigned char rgb[STEPS][3];
    char text[FF_AXIS_TEXT];
    const double size = sheet->fig->font;
    const double outside = p->kind == FF_PANEL_PLANE ? 0.8 * size : ff_text_points("180°", size) + 1.3 * size;
    const double box[] = {s->box.x + s->box.w + outside, s->box.y, FF_BAR * size, s->box.h};
    const double x = box[0] + box[2], frame[] = {box[0], box[1], x, box[1], x, box[1] + box[3], box[0], box[1] + box[3]};
    for (int k = 0; k < STEPS; k++) {
        const uint32_t colour = ff_colour_of(im->map, 1 - (k + 0.5) / STEPS);
        for (int b = 0; b < 3; b++) rgb[k][b] = (unsigned char)(colour >> (16 - 8 * b));
    }
    c->image(c->self, box, 1, STEPS, rgb[0]);
    c->path(c->self, 4, frame, 1, &(ff_pen){0.6, ink, FF_DASH_SOLID}, FF_COLOUR_NONE);
    for (size_t k = 0; k < s->z_ticks.n; k++) {
        const ff_tick *t = &s->z_ticks.tick[k];
        const double y = box[1] + (1 - ff_scale_place(im->log ? FF_SCALE_LOG : FF_SCALE_LINEAR, s->z[0], s->z[1], t->at)) * box[3];
        line(c, x, y, x + (t->label[0] ? 1 : 0.6) * FF_TICK_LENGTH * size, y, 0.6, ink);
        write_text(c, x + (FF_TICK_LENGTH + FF_LABEL_GAP) * size, y + FF_ASCENT / 2 * size, FF_ANCHOR_LEFT, size, t->label);
    }
    if (*ff_axis_text(&p->z, &s->z_ticks, text, sizeof text))
        write_label(sheet, c, text, x + (FF_TICK_LENGTH + FF_LABEL_GAP) * size + ff_ticks_widest(&s->z_ticks, size) + 1.1 * size,
                    box[1] + box[3] / 2, box[3] + s->top, 1);
}

/* ---- round panels ---------------------------------------------------------------------------- */

static void arc(const ff_canvas *c, double x, double y, double radius, double from, double to, const ff_pen *pen)
{
    enum { STEPS = 90 };
    double xy[STEPS + 1][2];
    for (int k = 0; k <= STEPS; k++) {
        const double angle = from + (to - from) * k / STEPS;
        xy[k][0] = x + radius * cos(angle);
        xy[k][1] = y - radius * sin(angle);
    }
    c->path(c->self, STEPS + 1, xy[0], 0, pen, FF_COLOUR_NONE);
}

/* Text beside a point of a circle, on its outer side. */
static void outside(const ff_canvas *c, double x, double y, double radius, double angle, double size, const char *text)
{
    const double s = sin(angle), co = cos(angle);
    const ff_anchor anchor = co > 0.3 ? FF_ANCHOR_LEFT : co < -0.3 ? FF_ANCHOR_RIGHT : FF_ANCHOR_MIDDLE;
    write_text(c, x + (radius + 0.5 * size) * co,
               y - (radius + 0.5 * size) * s +
                   (s > 0.3    ? 0
                    : s < -0.3 ? FF_ASCENT
                               : FF_ASCENT / 2) *
                       size,
               anchor, size, text);
}

static void draw_polar(const ff_sheet *sheet, const ff_panel *p, const ff_spot *s, const ff_canvas *c)
{
    const double size = sheet->fig->font, radius = s->box.w / 2, x = s->box.x + radius, y = s->box.y + s->box.h;
    const ff_pen grid = {0.4, 0xd0d0d0, FF_DASH_SOLID}, edge = {0.6, ink, FF_DASH_SOLID};
    char label[FF_AXIS_TEXT];
    for (size_t k = 0; k < s->y_ticks.n; k++) {
        const ff_tick *t = &s->y_ticks.tick[k];
        const double r = ff_scale_place(p->y.scale, s->y[0], s->y[1], t->at) * radius;
        if (!t->label[0]) continue;
        if (r > 0) arc(c, x, y, r, 0, 180 * degree, &grid);
        line(c, x + r, y, x + r, y + FF_TICK_LENGTH * size, 0.6, ink);
        write_text(c, x + r, y + (FF_TICK_LENGTH + FF_LABEL_GAP + FF_ASCENT) * size, FF_ANCHOR_MIDDLE, size, t->label);
    }
    for (int a = -90; a <= 90; a += 30) {
        char text[16];
        const double angle = (90 - a) * degree;
        if (a > -90 && a < 90) line(c, x, y, x + radius * cos(angle), y - radius * sin(angle), 0.4, 0xd0d0d0);
        snprintf(text, sizeof text, "%s%d°", a < 0 ? "−" : "", a < 0 ? -a : a);
        outside(c, x, y, radius, angle, size, text);
    }
    arc(c, x, y, radius, 0, 180 * degree, &edge);
    line(c, x - radius, y, x + radius, y, 0.6, ink);
    if (*ff_axis_text(&p->y, &s->y_ticks, label, sizeof label))
        write_label(sheet, c, label, x + radius / 2, y + s->bottom - 0.35 * size, radius + s->right, 0);
}

static void draw_disc(const ff_sheet *sheet, const ff_spot *s, const ff_canvas *c)
{
    const double size = sheet->fig->font, radius = s->box.w / 2, x = s->box.x + radius, y = s->box.y + radius;
    for (int theta = 30; theta <= 90; theta += 30) {
        char text[16];
        const double r = radius * theta / 90;
        arc(c, x, y, r, 0, 360 * degree, &(ff_pen){theta == 90 ? 0.6 : 0.4, theta == 90 ? ink : soft, FF_DASH_SOLID});
        snprintf(text, sizeof text, "%d°", theta);
        if (theta < 90 && radius > 6 * size) {
            const double left = x + (r + 0.2 * size) * cos(45 * degree), base = y + (r + 0.9 * size) * sin(45 * degree),
                         width = ff_text_points(text, 0.85 * size), top = base - 0.7 * size, bottom = base + 0.1 * size;
            const double area[] = {left, top, left + width, top, left + width, bottom, left, bottom};
            c->path(c->self, 4, area, 1, &(ff_pen){.colour = FF_COLOUR_NONE}, 0xffffff); /* or colours would swallow it */
            c->text(c->self, &(ff_text){left, base, FF_ANCHOR_LEFT, 0, 0.85 * size, 0x404040, text});
        }
    }
    for (int a = 0; a < 360; a += 90) {
        char text[16];
        snprintf(text, sizeof text, "%d°", a);
        line(c, x, y, x + radius * cos(a * degree), y - radius * sin(a * degree), 0.4, 0xd0d0d0);
        outside(c, x, y, radius, a * degree, size, text);
    }
}

void ff_spot_place(const ff_panel *p, const ff_spot *s, double x, double y, double out[2])
{
    if (p->kind == FF_PANEL_PLANE) {
        out[0] = x_at(p, s, x);
        out[1] = y_at(p, s, y);
        return;
    }
    const int polar = p->kind == FF_PANEL_POLAR;
    const double radius = s->box.w / 2, angle = (polar ? 90 - x : x) * degree,
                 r = radius * fmax(polar ? ff_scale_place(p->y.scale, s->y[0], s->y[1], y) : y / 90, 0);
    out[0] = s->box.x + radius + r * cos(angle);
    out[1] = s->box.y + radius - r * sin(angle);
    if (isnan(y) || (polar && p->y.scale == FF_SCALE_LOG && !(y > 0))) out[0] = out[1] = NAN;
}

void ff_axes_draw(const ff_sheet *sheet, const ff_panel *p, const ff_spot *s, const ff_canvas *c)
{
    const double size = sheet->fig->font;
    char title[FF_FIGURE_TEXT + 8];
    const ff_image *im = NULL;
    for (size_t k = 0; k < p->n_series && !im; k++)
        if (p->series[k]->kind == FF_SERIES_IMAGE) im = &p->series[k]->image;
    if (p->kind == FF_PANEL_POLAR) draw_polar(sheet, p, s, c);
    if (p->kind == FF_PANEL_DISC) draw_disc(sheet, s, c);
    if (p->kind == FF_PANEL_PLANE) {
        draw_frame(s, c);
        draw_x(sheet, p, s, c);
        draw_y(sheet, p, s, c);
    }
    if (im) draw_bar(sheet, p, s, im, c);
    ff_text_fit(p->title, size, s->box.w + s->left + s->right, title, sizeof title);
    const double width = ff_text_points(title, size), over = width > s->box.w ? s->box.x + s->box.w + s->right - width : s->box.x;
    write_text(c, fmin(s->box.x, over), s->box.y - s->top + 1.0 * size, FF_ANCHOR_LEFT, size, title);
}

/* Beneath everything: what helps the eye. */
void ff_grid_draw(const ff_panel *p, const ff_spot *s, const ff_canvas *c)
{
    if (p->kind == FF_PANEL_PLANE && !s->has_bar) draw_grid(p, s, c);
}
