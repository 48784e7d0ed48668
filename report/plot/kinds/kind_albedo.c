/* albedo: what share of the light is reflected, against the angle it comes from. */
#include "internal_curves.h"
#include "ff_albedo.h"
#include "models/tools/internal_albedo.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CURVE = 31, ORDER = 8 };

/* By the quadrature of furnace with one order: its error is far below a line's width. */
static ff_status add_curve(const ff_plot_model *m, const ff_plot_choice *c, size_t k, const ff_plot_channel *channel, int named,
                           ff_figure *fig, ff_panel *panel, ff_error *err)
{
    static const ff_wanted nothing = {.n_shape = 0};
    char label[FF_FIGURE_TEXT], name[FF_FIGURE_TEXT + FF_CHANNEL_NAME + 4];
    ff_albedo_parts *parts = NULL;
    double *out = malloc((m->n_channels + 1) * sizeof *out);
    ff_block_work *work = ff_block_work_new(1);
    ff_status status = ff_model_check(m->model, m->n_channels, m->shape, m->channel, err);
    if (!status && (!out || !work)) status = FF_ERR_MEMORY;
    if (!status)
        status = ff_albedo_parts_make(m->model, ff_kernels_get(c->isa), FF_CHEAPEST_MODE, m->n_channels, m->shape, m->channel,
                                      &nothing, &parts);
    ff_figure_plain(m->label, label, sizeof label);
    snprintf(name, sizeof name, "%s%s%s", label, named ? ", " : "", named ? channel->name : "");
    ff_series *s = status ? NULL : ff_panel_series(fig, panel, FF_SERIES_LINE, name, ff_style_at(k), CURVE, 0);
    for (size_t i = 0; i < CURVE && s; i++) {
        const double degrees = i + 1 < CURVE ? 3.0 * (double)i : 89, theta = degrees * FF_DEGREE;
        const double wo[3] = {sin(theta), 0, cos(theta)};
        ff_albedo_parts_at(parts, ORDER, wo, work, out);
        s->x[i] = degrees;
        s->y[i] = out[channel->of_model < m->n_channels ? channel->of_model : 0];
    }
    if (parts) ff_albedo_parts_free(parts);
    free(work);
    free(out);
    return status;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_panel *p = ff_figure_panel(fig, "");
    size_t style = 0;
    double most = 1;
    if (!p) return FF_OK;
    for (size_t m = 0; m < s->n_models; m++) {
        ff_plot_channel channel[FF_PLOT_LIST];
        size_t n;
        ff_status status = ff_plot_channels(&s->model[m], NULL, c->channel, channel, &n, err);
        for (size_t k = 0; k < n && !status; k++)
            status = add_curve(&s->model[m], c, style++, &channel[k], s->model[m].n_channels > 1, fig, p, err);
        if (status) return status;
        ff_plot_note_outcome(fig, &s->model[m]);
    }
    for (size_t k = 0; k < p->n_series; k++)
        for (size_t i = 0; i < CURVE; i++) most = fmax(most, p->series[k]->y[i]);
    ff_axis_say(&p->x, "θ_{i}", "degrees", FF_SCALE_ANGLE, 0, 90);
    ff_axis_say(&p->y, "directional albedo", "1", c->log > 0 ? FF_SCALE_LOG : FF_SCALE_LINEAR, c->log > 0 ? NAN : 0, 1.04 * most);
    return FF_OK;
}

const ff_plot_kind ff_plot_albedo = {
    .name = "albedo",
    .help = "directional albedo of models against the angle of incidence",
    .takes = FF_PLOT_MODELS,
    .uses = FF_PLOT_LOG | FF_PLOT_CHANNEL | FF_PLOT_ROUGHNESS | FF_PLOT_SEVERAL,
    .build = build,
};
