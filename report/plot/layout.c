/* From a figure to places on a page: ranges of the axes, ticks, and the room that text needs around them. */
#include "internal_sheet.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TURNS = 8 };

/* ---- ranges ---------------------------------------------------------------------------------- */

static void stretch(double range[2], double x, int log)
{
    if (!isfinite(x) || (log && !(x > 0))) return;
    if (!(range[0] <= x)) range[0] = x;
    if (!(range[1] >= x)) range[1] = x;
}

static void stretch_by(double range[2], const double *x, size_t n, int log)
{
    for (size_t i = 0; x && i < n; i++) stretch(range, x[i], log);
}

static void series_range(const ff_series *s, int of_y, int log, double range[2])
{
    if (s->kind == FF_SERIES_RULE) return;
    if (s->kind == FF_SERIES_IMAGE) {
        stretch(range, of_y ? s->image.y_lo : s->image.x_lo, log);
        stretch(range, of_y ? s->image.y_hi : s->image.x_hi, log);
        return;
    }
    stretch_by(range, of_y ? s->y : s->x, s->n, log);
    stretch_by(range, of_y ? s->low : s->x_low, s->n, log);
    stretch_by(range, of_y ? s->high : s->x_high, s->n, log);
}

/* What is not said is taken from the data, and a little more. */
static void axis_range(const ff_panel *p, const ff_axis *a, int of_y, double out[2])
{
    const int log = a->scale == FF_SCALE_LOG, has_image = p->n_series && p->series[0]->kind == FF_SERIES_IMAGE;
    double range[2] = {NAN, NAN};
    for (size_t k = 0; k < p->n_series; k++) series_range(p->series[k], of_y, log, range);
    if (isnan(range[0])) range[0] = log ? 0.1 : 0, range[1] = 1;
    if (range[1] <= range[0]) {
        const double by = log ? 1 : fmax(fabs(range[0]) * 0.1, 1e-300);
        range[0] = log ? range[0] / 2 : range[0] - by;
        range[1] = log ? range[1] * 2 : range[1] + by;
    } else if (!has_image) {
        const double by = log ? pow(range[1] / range[0], 0.04) : 0.04 * (range[1] - range[0]);
        range[0] = log ? range[0] / by : range[0] - by;
        range[1] = log ? range[1] * by : range[1] + by;
    }
    out[0] = isnan(a->lo) ? range[0] : a->lo;
    out[1] = isnan(a->hi) ? range[1] : a->hi;
    if (!(out[1] > out[0])) out[1] = log ? out[0] * 10 : out[0] + 1;
}

void ff_image_range(const ff_image *im, double out[2])
{
    double range[2] = {NAN, NAN};
    stretch_by(range, im->z, im->nx * im->ny, im->log);
    if (isnan(range[0])) range[0] = im->log ? 0.1 : 0, range[1] = 1;
    if (im->map == FF_MAP_DIVERGING) {
        const double most = im->clip > 0 ? im->clip : fmax(fabs(range[0]), fabs(range[1]));
        range[1] = most > 0 ? most : 1;
        range[0] = -range[1];
    }
    if (!(range[1] > range[0])) range[1] = im->log ? range[0] * 10 : range[0] + 1;
    out[0] = range[0];
    out[1] = range[1];
}

static const ff_image *image_of(const ff_panel *p)
{
    for (size_t k = 0; k < p->n_series; k++)
        if (p->series[k]->kind == FF_SERIES_IMAGE) return &p->series[k]->image;
    return NULL;
}

/* ---- around a panel -------------------------------------------------------------------------- */

static double widest_name(const ff_axis *a, double size)
{
    double widest = 0;
    for (size_t k = 0; k < a->n_names && !a->quiet; k++) widest = fmax(widest, ff_text_points(a->name[k], size));
    return widest;
}

/* By how far the labels of a horizontal axis stand out of its ends. */
static void overhang(const ff_spot *s, const ff_panel *p, double size, double *left, double *right)
{
    for (size_t k = 0; k < s->x_ticks.n; k++) {
        const ff_tick *t = &s->x_ticks.tick[k];
        const double half = ff_text_points(t->label, size) / 2, at = ff_scale_place(p->x.scale, s->x[0], s->x[1], t->at) * s->box.w;
        *left = fmax(*left, half - at);
        *right = fmax(*right, half - (s->box.w - at));
    }
}

static int has_text(const ff_axis *a, const ff_ticks *t)
{
    char text[FF_AXIS_TEXT];
    return *ff_axis_text(a, t, text, sizeof text) != '\0';
}

static void around_plane(const ff_figure *fig, const ff_panel *p, ff_spot *s, double size)
{
    const double tick = (FF_TICK_LENGTH + FF_LABEL_GAP) * size;
    const double y_labels = p->y.scale == FF_SCALE_NAMES ? fmin(widest_name(&p->y, size), FF_NAME_ROOM * fig->width)
                                                         : ff_ticks_widest(&s->y_ticks, size);
    double left = tick + y_labels + (has_text(&p->y, &s->y_ticks) ? FF_LINE_HEIGHT * size : 0), right = 0.3 * size;
    double x_labels = size;
    if (p->x.scale == FF_SCALE_NAMES) {
        const double cell = s->box.w / (double)(p->x.n_names ? p->x.n_names : 1), widest = widest_name(&p->x, size);
        s->x_names_upwards = widest + 0.4 * size > cell;
        x_labels = s->x_names_upwards ? fmin(widest, FF_NAME_ROOM * fig->width) : size;
    }
    overhang(s, p, size, &left, &right);
    if (s->has_bar)
        right = fmax(right, (0.8 + FF_BAR) * size + tick + ff_ticks_widest(&s->z_ticks, size) +
                                (has_text(&p->z, &s->z_ticks) ? FF_LINE_HEIGHT * size : 0) + 0.3 * size);
    s->left = fmax(s->left, left);
    s->right = fmax(s->right, right);
    s->bottom = fmax(s->bottom, tick + x_labels + 0.25 * size + (has_text(&p->x, &s->x_ticks) ? FF_LINE_HEIGHT * size : 0));
    s->top = 0.6 * size;
}

/* Angles stand around the arc, radii beneath the line through its ends. */
static void around_round(const ff_panel *p, ff_spot *s, double size)
{
    const double label = ff_text_points("180°", size) + 0.5 * size;
    s->left = label;
    s->right = label;
    if (s->has_bar)
        s->right += (0.8 + FF_BAR) * size + ff_ticks_widest(&s->z_ticks, size) + (FF_TICK_LENGTH + FF_LABEL_GAP) * size +
                    (has_text(&p->z, &s->z_ticks) ? FF_LINE_HEIGHT * size : 0);
    s->top = 1.7 * size;
    s->bottom = p->kind == FF_PANEL_POLAR
                    ? (1.35 + FF_TICK_LENGTH) * size + (has_text(&p->y, &s->y_ticks) ? FF_LINE_HEIGHT * size : 0)
                    : 1.7 * size;
}

static void around(const ff_figure *fig, const ff_panel *p, ff_spot *s, double size)
{
    s->top = 0;
    if (p->kind == FF_PANEL_PLANE)
        around_plane(fig, p, s, size);
    else
        around_round(p, s, size);
    if (p->title[0]) s->top += FF_LINE_HEIGHT * size;
}

static double height_of(const ff_panel *p, double width, double size)
{
    if (p->kind == FF_PANEL_POLAR) return width / 2;
    if (p->kind == FF_PANEL_DISC) return width;
    const ff_image *im = image_of(p);
    if (p->equal_cells && im && im->nx) return width * (double)im->ny / (double)im->nx;
    if (p->y.scale == FF_SCALE_NAMES) return fmax((double)p->y.n_names, 1) * 1.6 * size;
    return width * (p->aspect > 0 ? p->aspect : 0.62);
}

static void make_ticks(const ff_panel *p, ff_spot *s, double size)
{
    if (p->kind == FF_PANEL_PLANE) {
        ff_ticks_make(p->x.scale, s->x[0], s->x[1], s->box.w, size, 0, &s->x_ticks);
        ff_ticks_make(p->y.scale, s->y[0], s->y[1], s->box.h, size, 1, &s->y_ticks);
    } else if (p->kind == FF_PANEL_POLAR) {
        ff_ticks_make(p->y.scale, s->y[0], s->y[1], s->box.w / 2, size, 0, &s->y_ticks);
    }
    const ff_image *im = image_of(p);
    if (s->has_bar) ff_ticks_make(im->log ? FF_SCALE_LOG : FF_SCALE_LINEAR, s->z[0], s->z[1], s->box.h, size, 1, &s->z_ticks);
}

/* ---- the sheet ------------------------------------------------------------------------------- */

static size_t columns_of(const ff_figure *fig)
{
    const size_t n = fig->n_panels ? fig->n_panels : 1, most = n < FF_FIGURE_COLUMNS ? n : FF_FIGURE_COLUMNS;
    return fig->columns < 1 ? 1 : fig->columns < most ? fig->columns : most;
}

static void begin_spots(const ff_figure *fig, ff_sheet *s)
{
    for (size_t i = 0; i < fig->n_panels; i++) {
        const ff_panel *p = fig->panel[i];
        const ff_image *im = image_of(p);
        ff_spot *spot = &s->spot[i];
        axis_range(p, &p->x, 0, spot->x);
        axis_range(p, &p->y, 1, spot->y);
        spot->has_bar = im != NULL;
        if (im) ff_image_range(im, spot->z);
        spot->box.w = fig->width / (double)columns_of(fig) * 0.8;
        spot->box.h = height_of(p, spot->box.w, fig->font);
    }
}

/* The room that the panels of a column need to both sides, and what is left for their axes. */
static double share_width(const ff_figure *fig, const ff_sheet *s, double *left, double *right)
{
    const size_t columns = columns_of(fig);
    double rest = fig->width - 2.0 * 0.3 * fig->font - (double)(columns - 1) * 0.8 * fig->font;
    for (size_t c = 0; c < columns; c++) {
        left[c] = right[c] = 0;
        for (size_t i = c; i < fig->n_panels; i += columns) {
            left[c] = fmax(left[c], s->spot[i].left);
            right[c] = fmax(right[c], s->spot[i].right);
        }
        rest -= left[c] + right[c];
    }
    return rest / (double)columns;
}

/* Heights of the rows' axes: as the panels have them, or scaled so that the whole figure is as high as asked for. */
static double row_height(const ff_figure *fig, const ff_sheet *s, size_t row, double *above, double *below)
{
    const size_t columns = columns_of(fig);
    double h = 0;
    *above = *below = 0;
    for (size_t i = row * columns; i < fig->n_panels && i < (row + 1) * columns; i++) {
        h = fmax(h, s->spot[i].box.h);
        *above = fmax(*above, s->spot[i].top);
        *below = fmax(*below, s->spot[i].bottom);
    }
    return h;
}

static double total_height(const ff_figure *fig, const ff_sheet *s, double *of_axes)
{
    const size_t columns = columns_of(fig), rows = (fig->n_panels + columns - 1) / columns;
    double sum = 0;
    *of_axes = 0;
    for (size_t row = 0; row < rows; row++) {
        double above, below;
        *of_axes += row_height(fig, s, row, &above, &below);
        sum += above + below + (row ? 0.5 * fig->font : 0);
    }
    return sum + *of_axes;
}

/* Widths and heights of all boxes for the room that is taken; scale: of the heights. */
static void size_boxes(const ff_figure *fig, ff_sheet *s, double width, double scale)
{
    for (size_t i = 0; i < fig->n_panels; i++) {
        const ff_panel *p = fig->panel[i];
        double w = width, h = height_of(p, w, fig->font) * scale;
        if (p->kind != FF_PANEL_PLANE && scale < 1) w *= scale; /* round ones stay round */
        s->spot[i].box.w = w;
        s->spot[i].box.h = p->kind == FF_PANEL_PLANE ? h : height_of(p, w, fig->font);
    }
}

static ff_status too_small(const ff_figure *fig, ff_error *err)
{
    return ff_error_set(
        err, FF_ERR_RANGE, NULL, 0, -1,
        "no room for %zu panel%s in %zu column%s on %.4g mm with text of %.3g points: the figure needs to be larger, or "
        "its text smaller",
        fig->n_panels, fig->n_panels == 1 ? "" : "s", columns_of(fig), columns_of(fig) == 1 ? "" : "s", fig->width / 72 * 25.4,
        fig->font);
}

static void place_boxes(const ff_figure *fig, ff_sheet *s, double y, const double *left, const double *right, double width)
{
    const size_t columns = columns_of(fig);
    for (size_t first = 0; first < fig->n_panels; first += columns) {
        double above, below, x = 0.3 * fig->font;
        const double h = row_height(fig, s, first / columns, &above, &below);
        for (size_t c = 0; c < columns && first + c < fig->n_panels; c++) {
            ff_spot *spot = &s->spot[first + c];
            spot->box.x = x + left[c] + (width - spot->box.w) / 2;
            spot->box.y = y + above;
            x += left[c] + width + right[c] + 0.8 * fig->font;
        }
        y += above + h + below + 0.5 * fig->font;
    }
}

/* ---- legend, title, note --------------------------------------------------------------------- */

static int is_listed(const ff_sheet *s, const char *name)
{
    for (size_t k = 0; k < s->n_entries; k++)
        if (!strcmp(s->entry[k].series->name, name)) return 1;
    return 0;
}

static ff_status list_entries(const ff_figure *fig, ff_sheet *s)
{
    size_t n = 0;
    for (size_t i = 0; i < fig->n_panels; i++) n += fig->panel[i]->n_series;
    s->entry = calloc(n + 1, sizeof *s->entry);
    if (!s->entry) return FF_ERR_MEMORY;
    for (size_t i = 0; i < fig->n_panels; i++)
        for (size_t k = 0; k < fig->panel[i]->n_series; k++) {
            const ff_series *e = fig->panel[i]->series[k];
            if (e->kind == FF_SERIES_IMAGE || !e->name[0] || e->n == 0 || is_listed(s, e->name)) continue;
            s->entry[s->n_entries++].series = e;
        }
    return FF_OK;
}

/* In columns of one width where there are many, else one behind the other. Returns the height. */
static double place_entries(const ff_figure *fig, ff_sheet *s, double y)
{
    const double size = fig->font, sample = (FF_SAMPLE + 0.5) * size, gap = 1.6 * size;
    double widest = 0, whole = 0, x = 0.3 * size, line = 1;
    if (s->n_entries == 0) return 0;
    y += 0.5 * size;
    for (size_t k = 0; k < s->n_entries; k++)
        widest = fmax(widest, sample + fmin(ff_text_points(s->entry[k].series->name, size), fig->width - sample - size) + gap);
    for (size_t k = 0; k < s->n_entries; k++) whole += sample + ff_text_points(s->entry[k].series->name, size) + gap;
    const size_t columns = (size_t)fmax(floor((fig->width - 0.6 * size + gap) / widest), 1);
    const int in_columns = s->n_entries > 2 && whole - gap > fig->width - 0.6 * size;
    for (size_t k = 0; k < s->n_entries; k++) {
        const double width = sample + ff_text_points(s->entry[k].series->name, size) + gap;
        if (in_columns ? k && k % columns == 0 : k && x + width - gap > fig->width - 0.3 * size) x = 0.3 * size, line++;
        s->entry[k].x = x;
        s->entry[k].y = y + line * FF_LINE_HEIGHT * size - 0.3 * size;
        x += in_columns ? widest : width;
    }
    return (line * FF_LINE_HEIGHT + 0.9) * size;
}

/* The note in lines, broken at blanks. Returns its height. */
static double place_note(const ff_figure *fig, ff_sheet *s, double y)
{
    const double size = 0.9 * fig->font, room = fig->width - 0.6 * fig->font;
    const char *rest = fig->note;
    s->note_y = y + FF_LINE_HEIGHT * size;
    while (*rest && s->n_lines < FF_NOTE_LINES) {
        char *line = s->line[s->n_lines];
        size_t keep = 0, end = 0;
        do {
            end += strcspn(rest + end, " ");
            snprintf(line, FF_FIGURE_TEXT, "%.*s", (int)end, rest);
            if (end >= FF_FIGURE_TEXT || (keep && ff_text_points(line, size) > room)) break;
            keep = end;
            end += rest[end] == ' ';
        } while (rest[keep]);
        char whole[FF_FIGURE_TEXT];
        snprintf(whole, sizeof whole, "%.*s", (int)keep, rest);
        ff_text_fit(whole, size, room, line, FF_FIGURE_TEXT);
        s->n_lines++;
        rest += keep;
        rest += strspn(rest, " ");
    }
    return (double)s->n_lines * FF_LINE_HEIGHT * size + (s->n_lines ? 0.3 * size : 0);
}

/* Until the room around the boxes and the ticks in them agree; it only grows. */
static double settle(const ff_figure *fig, ff_sheet *s, double left[], double right[], double outside)
{
    double width = 0, scale = 1;
    for (int turn = 0; turn < TURNS; turn++) {
        for (size_t i = 0; i < fig->n_panels; i++) {
            make_ticks(fig->panel[i], &s->spot[i], fig->font);
            around(fig, fig->panel[i], &s->spot[i], fig->font);
        }
        width = share_width(fig, s, left, right);
        if (!(width > 4 * fig->font)) return 0;
        size_boxes(fig, s, width, scale);
        if (fig->height > 0) {
            double of_axes;
            const double rest = total_height(fig, s, &of_axes);
            scale *= fmax(fig->height - outside - (rest - of_axes), 0) / of_axes;
            size_boxes(fig, s, width, scale);
            if (!(scale * of_axes > 0)) return 0;
        }
    }
    for (size_t i = 0; i < fig->n_panels; i++) make_ticks(fig->panel[i], &s->spot[i], fig->font);
    for (size_t i = 0; i < fig->n_panels; i++)
        if (!(s->spot[i].box.h > 2 * fig->font || fig->panel[i]->y.scale == FF_SCALE_NAMES)) return 0;
    return width;
}

ff_status ff_sheet_make(const ff_figure *fig, ff_sheet *out, ff_error *err)
{
    double left[FF_FIGURE_COLUMNS], right[FF_FIGURE_COLUMNS], of_axes;
    ff_sheet s = {.fig = fig, .width = fig->width, .spot = calloc(fig->n_panels + 1, sizeof *s.spot)};
    ff_status status = s.spot ? list_entries(fig, &s) : FF_ERR_MEMORY;
    if (!status) {
        begin_spots(fig, &s);
        s.title_y = 1.25 * fig->font;
        const double head = fig->title[0] ? 1.9 * fig->font : 0.3 * fig->font,
                     foot = place_entries(fig, &s, 0) + place_note(fig, &s, 0) + 0.5 * fig->font;
        const double width = settle(fig, &s, left, right, head + foot);
        if (!(width > 0)) status = too_small(fig, err);
        if (!status) {
            place_boxes(fig, &s, head, left, right, width);
            s.n_lines = 0;
            s.height = head + total_height(fig, &s, &of_axes);
            s.height += place_entries(fig, &s, s.height);
            s.height += place_note(fig, &s, s.height) + 0.5 * fig->font;
        }
    }
    if (status) {
        ff_sheet_free(&s);
        return status;
    }
    *out = s;
    return FF_OK;
}

void ff_sheet_free(ff_sheet *s)
{
    free(s->spot);
    free(s->entry);
    s->spot = NULL;
    s->entry = NULL;
}
