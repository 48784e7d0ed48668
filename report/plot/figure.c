/* Figures as values: made, filled, released. */
#include "internal_figure.h"
#include "report/internal_text.h"
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define MM (72 / 25.4)

const char *ff_series_kind_name(int kind)
{
    static const char *const names[FF_SERIES_KINDS] = {"line", "points", "band", "image", "rule"};
    return kind >= 0 && kind < FF_SERIES_KINDS ? names[kind] : NULL;
}

void ff_figure_init(ff_figure *fig)
{
    *fig = (ff_figure){.status = FF_OK, .font = 8, .columns = 1};
}

static void free_axis(ff_axis *a)
{
    free(a->name);
}

static void free_series(ff_series *s)
{
    if (!s) return;
    double *const planes[] = {s->x, s->y, s->low, s->high, s->x_low, s->x_high, s->image.z};
    for (size_t k = 0; k < sizeof planes / sizeof *planes; k++) free(planes[k]);
    free(s);
}

void ff_figure_clear(ff_figure *fig)
{
    for (size_t i = 0; i < fig->n_panels; i++) {
        ff_panel *p = fig->panel[i];
        for (size_t k = 0; k < p->n_series; k++) free_series(p->series[k]);
        free(p->series);
        free_axis(&p->x);
        free_axis(&p->y);
        free(p);
    }
    free(fig->panel);
    *fig = (ff_figure){.status = FF_OK};
}

/* A longer list of pointers with `item` at its end; item is NULL: no memory. */
static int append(void ***list, size_t *n, void *item)
{
    void **longer = item ? realloc(*list, (*n + 1) * sizeof *longer) : NULL;
    if (!longer) return 0;
    *list = longer;
    longer[(*n)++] = item;
    return 1;
}

ff_panel *ff_figure_panel(ff_figure *fig, const char *title)
{
    ff_panel *p = fig->status ? NULL : calloc(1, sizeof *p);
    if (p) {
        snprintf(p->title, sizeof p->title, "%s", title);
        p->x.lo = p->x.hi = p->y.lo = p->y.hi = p->z.lo = p->z.hi = NAN;
    }
    void **list = (void **)fig->panel;
    if (append(&list, &fig->n_panels, p)) {
        fig->panel = (ff_panel **)list;
        return p;
    }
    free(p);
    if (!fig->status) fig->status = FF_ERR_MEMORY;
    return NULL;
}

static double *plane(size_t n)
{
    double *x = n < SIZE_MAX / sizeof *x ? malloc((n ? n : 1) * sizeof *x) : NULL;
    for (size_t i = 0; x && i < n; i++) x[i] = NAN;
    return x;
}

/* Into the panel, or released. */
static ff_series *take(ff_figure *fig, ff_panel *p, ff_series *s, int whole)
{
    void **list = p ? (void **)p->series : NULL;
    if (p && whole && append(&list, &p->n_series, s)) {
        p->series = (ff_series **)list;
        return s;
    }
    free_series(s);
    if (!fig->status) fig->status = FF_ERR_MEMORY;
    return NULL;
}

ff_series *ff_panel_series(ff_figure *fig, ff_panel *p, ff_series_kind kind, const char *name, ff_style style, size_t n,
                           int columns)
{
    ff_series *s = p && !fig->status ? calloc(1, sizeof *s) : NULL;
    if (!s) return take(fig, p, NULL, 0);
    *s = (ff_series){.kind = kind, .style = style, .n = n, .x = plane(n), .y = plane(n)};
    snprintf(s->name, sizeof s->name, "%s", name);
    int whole = s->x && s->y;
    if (columns & FF_WITH_Y_ERRORS) whole &= (s->low = plane(n)) && (s->high = plane(n));
    if (columns & FF_WITH_X_ERRORS) whole &= (s->x_low = plane(n)) && (s->x_high = plane(n));
    return take(fig, p, s, whole);
}

ff_series *ff_panel_image(ff_figure *fig, ff_panel *p, const char *name, size_t nx, size_t ny)
{
    ff_series *s = p && !fig->status ? calloc(1, sizeof *s) : NULL;
    if (!s) return take(fig, p, NULL, 0);
    s->kind = FF_SERIES_IMAGE;
    snprintf(s->name, sizeof s->name, "%s", name);
    s->image = (ff_image){.nx = nx, .ny = ny, .clip = NAN, .z = plane(nx * ny)};
    return take(fig, p, s, s->image.z != NULL);
}

void ff_panel_rule_x(ff_figure *fig, ff_panel *p, const char *name, ff_style style, double x)
{
    ff_series *s = ff_panel_series(fig, p, FF_SERIES_RULE, name, style, 1, 0);
    if (s) s->x[0] = x;
}

void ff_panel_rule_y(ff_figure *fig, ff_panel *p, const char *name, ff_style style, double y)
{
    ff_series *s = ff_panel_series(fig, p, FF_SERIES_RULE, name, style, 1, 0);
    if (s) s->y[0] = y;
}

void ff_series_cut(ff_series *s, size_t n)
{
    if (s && n < s->n) s->n = n;
}

void ff_axis_say(ff_axis *a, const char *label, const char *unit, ff_scale scale, double lo, double hi)
{
    snprintf(a->label, sizeof a->label, "%s", label);
    snprintf(a->unit, sizeof a->unit, "%s", strcmp(unit, "1") ? unit : "");
    a->scale = scale;
    a->lo = lo;
    a->hi = hi;
}

void ff_axis_names(ff_figure *fig, ff_axis *a, size_t n)
{
    a->scale = FF_SCALE_NAMES;
    a->lo = -0.5;
    a->hi = (double)n - 0.5;
    a->name = calloc(n ? n : 1, sizeof *a->name);
    a->n_names = a->name ? n : 0;
    if (!a->name && !fig->status) fig->status = FF_ERR_MEMORY;
}

void ff_axis_name(ff_axis *a, size_t k, const char *name)
{
    if (k < a->n_names) snprintf(a->name[k], sizeof a->name[k], "%s", name);
}

const char *ff_figure_plain(const char *text, char *out, size_t size)
{
    size_t used = 0;
    while (*text && used + 5 < size) {
        uint32_t code = 0;
        const size_t n = ff_text_sequence(text, &code);
        if (n == 0 || ff_text_is_control(code)) {
            out[used++] = '?';
        } else if ((code == '_' || code == '^') && text[1] == '{') {
            out[used++] = ' ';
        } else {
            memcpy(out + used, text, n);
            used += n;
        }
        text += n ? n : 1;
    }
    out[used] = '\0';
    return out;
}

void ff_figure_note(ff_figure *fig, const char *format, ...)
{
    const size_t used = strlen(fig->note);
    va_list args;
    va_start(args, format);
    if (used) snprintf(fig->note + used, sizeof fig->note - used, "; ");
    vsnprintf(fig->note + strlen(fig->note), sizeof fig->note - strlen(fig->note), format, args);
    va_end(args);
}
