/* forest: values with their 95 % intervals; a panel a parameter, a row a model, or of one model a row a channel. */
#include "internal_curves.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ROWS = 24, MOST_PANELS = 9 };

/* A number in a fit: by parameter and channel; NULL where the model has no such parameter. The alpha of a model that is isotropic
 * by itself stands for alpha_x. */
static const ff_fitted_value *find(const ff_fitted *f, const char *name, size_t channel)
{
    if (!strcmp(name, "alpha_x") && ff_model_param_find(&f->model, name).kind == FF_PARAM_NONE) name = "alpha";
    for (uint32_t k = 0; k < f->model.n_shape; k++)
        if (!strcmp(f->model.shape[k].name, name)) return &f->shape_value[k];
    for (uint32_t k = 0; k < f->model.n_channel; k++)
        if (!strcmp(f->model.channel[k].name, name) && channel < f->n_channels)
            return &f->channel_value[channel * f->model.n_channel + k];
    return NULL;
}

typedef struct forest {
    const ff_fit_document *d;
    size_t n_rows, row[MOST_ROWS]; /* fits by rank */
    size_t n_channels;
    ff_plot_channel channel[FF_PLOT_LIST];
    size_t n_names;
    const ff_model_param *name[MOST_PANELS];
} forest;

/* Is it free in some channel of some fit that is drawn? */
static int is_free(const forest *w, const char *name)
{
    for (size_t r = 0; r < w->n_rows; r++) {
        const ff_fitted *f = &w->d->fit[w->row[r]];
        for (size_t c = 0; c < f->n_channels; c++) {
            const ff_fitted_value *v = find(f, name, c);
            if (v && !v->held && !v->tied) return 1;
        }
    }
    return 0;
}

static int is_listed(const forest *w, const char *name)
{
    if (!strcmp(name, "alpha")) name = "alpha_x";
    for (size_t k = 0; k < w->n_names; k++)
        if (!strcmp(w->name[k]->name, name)) return 1;
    return 0;
}

static void list_names(forest *w, const ff_plot_choice *c)
{
    for (size_t r = 0; r < w->n_rows; r++) {
        const ff_model *m = &w->d->fit[w->row[r]].model;
        for (uint32_t k = 0; k < m->n_shape + m->n_channel && w->n_names < MOST_PANELS; k++) {
            const ff_model_param *p = k < m->n_shape ? &m->shape[k] : &m->channel[k - m->n_shape];
            if (!is_listed(w, p->name) && (c->parameter ? ff_plot_names(c->parameter, p->name) : is_free(w, p->name)))
                w->name[w->n_names++] = p;
        }
    }
}

static void set_point(ff_series *s, size_t i, const ff_fitted_value *v, double y)
{
    s->y[i] = y;
    if (!v) return;
    s->x[i] = v->value;
    s->x_low[i] = v->low;
    s->x_high[i] = v->high;
}

/* Rows are models: a series for each channel that is drawn, beside each other in the row. */
static void add_models(const forest *w, const char *name, ff_figure *fig, ff_panel *p)
{
    for (size_t c = 0; c < w->n_channels; c++) {
        char plain[FF_CHANNEL_NAME];
        ff_figure_plain(w->channel[c].name, plain, sizeof plain);
        ff_series *s = ff_panel_series(fig, p, FF_SERIES_POINTS, w->n_channels > 1 ? plain : "",
                                       w->n_channels > 1 ? ff_style_at(c) : ff_style_data, w->n_rows, FF_WITH_X_ERRORS);
        const double shift = w->n_channels > 1 ? 0.5 * ((double)c / (double)(w->n_channels - 1) - 0.5) : 0;
        for (size_t r = 0; r < w->n_rows && s; r++)
            set_point(s, r, find(&w->d->fit[w->row[r]], name, w->channel[c].of_model), (double)r + shift);
    }
}

static int is_per_channel(const ff_model *m, const char *name)
{
    for (uint32_t k = 0; k < m->n_channel; k++)
        if (!strcmp(m->channel[k].name, name)) return 1;
    return 0;
}

/* Rows are channels of the only model; a parameter that all share has one. */
static size_t rows_of_one(const ff_fitted *f, const char *name)
{
    return is_per_channel(&f->model, name) ? f->n_channels : 1;
}

static void add_channels(const ff_fitted *f, const char *name, ff_figure *fig, ff_panel *p)
{
    const size_t n = rows_of_one(f, name);
    ff_series *s = ff_panel_series(fig, p, FF_SERIES_POINTS, "", ff_style_data, n, FF_WITH_X_ERRORS);
    for (size_t c = 0; c < n && s; c++) set_point(s, c, find(f, name, c), (double)c);
    ff_axis_names(fig, &p->y, n);
    for (size_t c = 0; c < n; c++) {
        char plain[FF_AXIS_NAME];
        ff_axis_name(&p->y, c, n > 1 ? ff_figure_plain(f->channel_name[c], plain, sizeof plain) : "all");
    }
}

/* How long the terms are, "/schlick+lambert", that all rows end with: they need not stand in each. */
static size_t common_end(const forest *w)
{
    const char *first = w->d->fit[w->row[0]].expression;
    size_t length = strlen(first);
    for (size_t r = 1; r < w->n_rows; r++) {
        const char *other = w->d->fit[w->row[r]].expression;
        size_t n = 0;
        while (n < length && n < strlen(other) && first[strlen(first) - 1 - n] == other[strlen(other) - 1 - n]) n++;
        length = n;
    }
    if (length == strlen(first)) return 0; /* one model of several channels */
    while (length && first[strlen(first) - length] != '/' && first[strlen(first) - length] != '+') length--;
    return length;
}

/* The model; where channels were fitted each alone, the channel too. */
static void name_rows(const forest *w, ff_axis *a, int shown)
{
    const ff_fitted *first = &w->d->fit[w->row[0]];
    int alone = 0, same = 1;
    for (size_t r = 1; r < w->n_rows; r++) {
        const ff_fitted *f = &w->d->fit[w->row[r]];
        alone |= f->n_channels == 1 && strcmp(f->channel_name[0], first->channel_name[0]) != 0;
        same &= !strcmp(f->expression, first->expression);
    }
    const size_t common = common_end(w);
    snprintf(a->ending, sizeof a->ending, "%s", first->expression + strlen(first->expression) - common);
    a->quiet = !shown;
    for (size_t r = 0; r < w->n_rows; r++) {
        const ff_fitted *f = &w->d->fit[w->row[r]];
        const int length = (int)(strlen(f->expression) - common);
        char name[FF_MODEL_NAME + FF_CHANNEL_NAME + 8], channel[FF_CHANNEL_NAME];
        ff_figure_plain(f->channel_name[0], channel, sizeof channel);
        snprintf(name, sizeof name, "%s%s%.*s", alone ? channel : "", alone && !same ? ", " : "", alone && same ? 0 : length,
                 f->expression);
        ff_axis_name(a, r, name);
    }
}

/* Panels of many rows beside each other, those of one behind them. */
static void put_long_first(forest *w, const ff_fitted *f)
{
    const ff_model_param *sorted[MOST_PANELS];
    size_t n = 0;
    for (int one = 0; one < 2; one++)
        for (size_t k = 0; k < w->n_names; k++)
            if ((rows_of_one(f, w->name[k]->name) == 1) == one) sorted[n++] = w->name[k];
    memcpy(w->name, sorted, n * sizeof *sorted);
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    forest w = {.d = s->document};
    for (size_t k = 0; k < w.d->n_fits && w.n_rows < MOST_ROWS; k++) w.row[w.n_rows++] = w.d->rank[k];
    const ff_fitted *best = &w.d->fit[w.row[0]];
    const ff_plot_model of_best = {
        .model = &best->model, .n_channels = best->n_channels, .channel_name = (const char(*)[FF_CHANNEL_NAME])best->channel_name};
    ff_status status = ff_plot_channels(&of_best, NULL, c->channel, w.channel, &w.n_channels, err);
    if (status) return status;
    list_names(&w, c);
    if (w.n_rows == 1) put_long_first(&w, best);
    if (w.n_names == 0)
        return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "no parameter '%.200s' in the result",
                            c->parameter ? c->parameter : "that is free");
    fig->columns = w.n_rows > 1 ? (w.n_names < 3 ? w.n_names : 3) : (w.n_names < 2 ? w.n_names : 2);
    for (size_t k = 0; k < w.n_names; k++) {
        ff_panel *p = ff_figure_panel(fig, "");
        if (!p) break;
        char name[FF_FIGURE_TEXT];
        ff_figure_plain(w.name[k]->name, name, sizeof name);
        ff_axis_say(&p->x, name, w.name[k]->info->unit, FF_SCALE_LINEAR, NAN, NAN);
        if (w.n_rows == 1) {
            add_channels(best, w.name[k]->name, fig, p);
            continue;
        }
        ff_axis_names(fig, &p->y, w.n_rows);
        name_rows(&w, &p->y, k % fig->columns == 0);
        add_models(&w, w.name[k]->name, fig, p);
    }
    snprintf(fig->title, sizeof fig->title, "%s",
             w.n_rows > 1 ? "Parameters with 95 % intervals, best fit first" : best->expression);
    if (w.n_rows > 1 && best->n_channels > 1 && w.n_channels == 1) {
        char plain[FF_CHANNEL_NAME];
        ff_figure_note(fig, "channel %s", ff_figure_plain(w.channel[0].name, plain, sizeof plain));
    }
    const size_t common = w.n_rows > 1 ? common_end(&w) : 0;
    if (common) ff_figure_note(fig, "all with %s", best->expression + strlen(best->expression) - common + 1);
    if (w.d->n_fits > w.n_rows) ff_figure_note(fig, "%zu more fits are not drawn", w.d->n_fits - w.n_rows);
    for (size_t r = 0; r < w.n_rows; r++)
        ff_plot_note_failed(fig, w.n_rows > 1 ? w.d->fit[w.row[r]].expression : NULL, w.d->fit[w.row[r]].outcome);
    return FF_OK;
}

const ff_plot_kind ff_plot_forest = {
    .name = "forest",
    .help = "parameters with their 95 % intervals, over models or over the channels of one",
    .takes = FF_PLOT_FITS | FF_PLOT_COMPARES | FF_PLOT_RESULTS,
    .uses = FF_PLOT_CHANNEL | FF_PLOT_PARAMETER | FF_PLOT_REFITS | FF_PLOT_PROFILE,
    .build = build,
};
