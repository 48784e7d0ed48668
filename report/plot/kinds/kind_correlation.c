/* correlation: which parameters the data cannot tell apart. */
#include "internal_curves.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 60, WRITTEN = 14, FEW = 4 };
#define COLUMN (85 * 72 / 25.4) /* points: of few cells no more than that */

/* All parameters that go together in one matrix: the columns, and of many channels those of one of them. */
typedef struct matrix {
    const ff_fitted *f;
    size_t channel; /* whose own parameters stand behind the columns, where there are some */
    size_t n, left_out;
    size_t place[MOST];
    char name[MOST][FF_AXIS_NAME];
} matrix;

static void add(matrix *m, const ff_plot_choice *c, size_t place, const char *name)
{
    if (!ff_plot_names(c->parameter, name)) return;
    if (m->n == MOST) {
        m->left_out++;
        return;
    }
    m->place[m->n] = place;
    ff_figure_plain(name, m->name[m->n++], FF_AXIS_NAME);
}

static double value_at(const matrix *m, size_t a, size_t b)
{
    const ff_fitted *f = m->f;
    const size_t n = f->n_columns, width = n + f->n_own;
    if (a < n && b < n) return f->correlation[a * n + b];
    if (a < n) return value_at(m, b, a);
    return f->own[(m->channel * f->n_own + a - n) * width + b];
}

static ff_status list_all(const ff_plot_choice *c, matrix *m, ff_error *err)
{
    const ff_fitted *f = m->f;
    const ff_plot_model of = {
        .model = &f->model, .n_channels = f->n_channels, .channel_name = (const char(*)[FF_CHANNEL_NAME])f->channel_name};
    ff_plot_channel channel[FF_PLOT_LIST];
    size_t n;
    const ff_status status = ff_plot_channels(&of, NULL, c->channel, channel, &n, err);
    if (status) return status;
    m->channel = channel[0].of_model;
    for (size_t k = 0; k < f->n_columns; k++) add(m, c, k, f->column_name[k]);
    for (size_t k = 0; k < f->n_own; k++) {
        char name[FF_PARAM_NAME + FF_CHANNEL_NAME + 4];
        snprintf(name, sizeof name, "%s[%s]", f->own_name[k], f->channel_name[m->channel]);
        add(m, c, f->n_columns + k, name);
    }
    if (m->n) return FF_OK;
    if (!f->n_columns) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the result has no correlations");
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "none of the parameters '%.200s' has correlations",
                        c->parameter ? c->parameter : "");
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    matrix m = {.f = &s->document->fit[s->document->best]};
    const ff_status status = list_all(c, &m, err);
    if (status) return status;
    ff_panel *p = ff_figure_panel(fig, "");
    ff_series *image = ff_panel_image(fig, p, "correlation", m.n, m.n);
    if (!image) return FF_OK;
    ff_axis_names(fig, &p->x, m.n);
    ff_axis_names(fig, &p->y, m.n);
    ff_axis_say(&p->z, "correlation", "1", FF_SCALE_LINEAR, -1, 1);
    p->equal_cells = 1;
    image->image = (ff_image){.nx = m.n,
                              .ny = m.n,
                              .x_lo = -0.5,
                              .x_hi = (double)m.n - 0.5,
                              .y_lo = -0.5,
                              .y_hi = (double)m.n - 0.5,
                              .z = image->image.z,
                              .map = FF_MAP_DIVERGING,
                              .clip = 1,
                              .written = m.n <= WRITTEN};
    for (size_t a = 0; a < m.n; a++) {
        ff_axis_name(&p->x, a, m.name[a]);
        ff_axis_name(&p->y, a, m.name[a]);
        for (size_t b = 0; b < m.n; b++) image->image.z[a * m.n + b] = value_at(&m, m.place[a], m.place[b]);
    }
    snprintf(fig->title, sizeof fig->title, "%s", m.f->expression);
    if (m.left_out) ff_figure_note(fig, "%zu more parameters are not drawn", m.left_out);
    ff_plot_note_failed(fig, NULL, m.f->outcome);
    if (fig->width <= 0 && m.n <= FEW) fig->width = COLUMN;
    return FF_OK;
}

const ff_plot_kind ff_plot_correlation = {
    .name = "correlation",
    .help = "correlations of the parameters of a fit",
    .takes = FF_PLOT_FITS | FF_PLOT_RESULTS,
    .uses = FF_PLOT_CHANNEL | FF_PLOT_PARAMETER | FF_PLOT_REFITS,
    .build = build,
};
