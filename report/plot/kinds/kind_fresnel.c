/* fresnel: the Fresnel term against the angle between light and half vector, as in Mikkelsen 2009, figure 4(d). */
#include "internal_curves.h"
#include <math.h>
#include <string.h>

enum { CURVE = 181 };

/* F of the first lobe: light and view at the same angle on both sides of the normal, which is then the half vector. */
static ff_status add_curve(const ff_plot_model *m, ff_isa isa, size_t k, const ff_plot_channel *channel, int named, ff_figure *fig,
                           ff_panel *panel, ff_error *err)
{
    double f[CURVE], theta[CURVE];
    ff_directions w;
    char label[FF_FIGURE_TEXT], name[FF_FIGURE_TEXT + FF_CHANNEL_NAME + 4];
    ff_status status = ff_directions_new(CURVE, &w);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++) {
        theta[i] = fmin(90.0 * (double)i / (CURVE - 1), 89.99);
        ff_directions_set(&w, i, theta[i] * FF_DEGREE, 180 * FF_DEGREE, theta[i] * FF_DEGREE, 0);
    }
    status = ff_model_terms(m->model, isa, m->n_channels, m->shape, m->channel, 0, channel->of_model, &w.w, CURVE,
                            &(ff_terms){.fresnel = f});
    ff_directions_free(&w);
    if (status)
        return ff_error_set(err, status, NULL, 0, -1, "%s has no Fresnel term to draw: %s", m->label, ff_status_str(status));
    ff_figure_plain(m->label, label, sizeof label);
    snprintf(name, sizeof name, "%s%s%s", label, named ? ", " : "", named ? channel->name : "");
    ff_series *s = ff_panel_series(fig, panel, FF_SERIES_LINE, name, ff_style_at(k), CURVE, 0);
    for (size_t i = 0; i < CURVE && s; i++) {
        s->x[i] = theta[i];
        s->y[i] = f[i];
    }
    return FF_OK;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_panel *p = ff_figure_panel(fig, "");
    size_t style = 0;
    if (!p) return FF_OK;
    for (size_t m = 0; m < s->n_models; m++) {
        ff_plot_channel channel[FF_PLOT_LIST];
        size_t n;
        ff_status status = ff_plot_channels(&s->model[m], NULL, c->channel, channel, &n, err);
        for (size_t k = 0; k < n && !status; k++)
            status = add_curve(&s->model[m], c->isa, style++, &channel[k], s->model[m].n_channels > 1, fig, p, err);
        if (status) return status;
        ff_plot_note_outcome(fig, &s->model[m]);
    }
    ff_axis_say(&p->x, "θ_{d}", "degrees", FF_SCALE_ANGLE, 0, 90);
    ff_axis_say(&p->y, "F", "1", c->log > 0 ? FF_SCALE_LOG : FF_SCALE_LINEAR, c->log > 0 ? NAN : 0, 1.04);
    snprintf(fig->title, sizeof fig->title, "Fresnel term");
    return FF_OK;
}

const ff_plot_kind ff_plot_fresnel = {
    .name = "fresnel",
    .help = "the Fresnel term F of models against the angle between light and half vector",
    .takes = FF_PLOT_MODELS,
    .uses = FF_PLOT_LOG | FF_PLOT_CHANNEL | FF_PLOT_SEVERAL,
    .build = build,
};
