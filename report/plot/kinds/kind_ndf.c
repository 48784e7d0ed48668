/* ndf: distributions of normals against the angle of the normal, as in Heitz 2014, figures 12 and 13. */
#include "internal_curves.h"
#include <math.h>
#include <string.h>

enum { CURVE = 181 };

/* D of the first lobe for normals up to just short of the horizon: light and view both along the normal of the facet. */
static ff_status add_curve(const ff_plot_model *m, ff_isa isa, size_t k, ff_figure *fig, ff_panel *panel, ff_error *err)
{
    double d[CURVE], theta[CURVE];
    ff_directions w;
    char label[FF_FIGURE_TEXT];
    ff_status status = ff_directions_new(CURVE, &w);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++) {
        theta[i] = fmin(90.0 * (double)i / (CURVE - 1), 89.9);
        ff_directions_set(&w, i, theta[i] * FF_DEGREE, 0, theta[i] * FF_DEGREE, 0);
    }
    status = ff_model_terms(m->model, isa, m->n_channels, m->shape, m->channel, 0, 0, &w.w, CURVE, &(ff_terms){.d = d});
    ff_directions_free(&w);
    if (status)
        return ff_error_set(err, status, NULL, 0, -1, "%s has no distribution to draw: %s", m->label, ff_status_str(status));
    ff_series *s =
        ff_panel_series(fig, panel, FF_SERIES_LINE, ff_figure_plain(m->label, label, sizeof label), ff_style_at(k), CURVE, 0);
    for (size_t i = 0; i < CURVE && s; i++) {
        s->x[i] = theta[i];
        s->y[i] = d[i];
    }
    return FF_OK;
}

/* Largest and smallest value above 0. */
static void range(const ff_panel *p, double *most, double *least)
{
    *most = 0;
    *least = INFINITY;
    for (size_t k = 0; p && k < p->n_series; k++)
        for (size_t i = 0; i < p->series[k]->n; i++) {
            const double y = p->series[k]->y[i];
            if (!isfinite(y)) continue;
            *most = fmax(*most, y);
            if (y > 0) *least = fmin(*least, y);
        }
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_status status = FF_OK;
    for (int log = 0; log < 2; log++) {
        if (c->log >= 0 && c->log != log) continue;
        ff_panel *p = ff_figure_panel(fig, "");
        if (!p) break;
        for (size_t k = 0; k < s->n_models && !status; k++) status = add_curve(&s->model[k], c->isa, k, fig, p, err);
        double most, least;
        range(p, &most, &least);
        ff_axis_say(&p->x, "θ_{h}", "degrees", FF_SCALE_ANGLE, 0, 90);
        ff_axis_say(&p->y, "D", "sr^{−1}", log ? FF_SCALE_LOG : FF_SCALE_LINEAR, log ? fmax(1e-6 * most, 0.5 * least) : 0,
                    most > 0 ? (log ? 1.5 : 1.05) * most : 1);
        p->aspect = 0.8;
    }
    fig->columns = fig->n_panels;
    snprintf(fig->title, sizeof fig->title, "Distribution of normals");
    return status;
}

const ff_plot_kind ff_plot_ndf = {
    .name = "ndf",
    .help = "distributions of normals D against the angle of the normal, linear and logarithmic",
    .takes = FF_PLOT_MODELS | FF_PLOT_TERMS,
    .uses = FF_PLOT_LOG | FF_PLOT_ROUGHNESS | FF_PLOT_SEVERAL,
    .build = build,
};
