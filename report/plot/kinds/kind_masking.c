/* masking: G1, and G2 in the mirror configuration, against the angle of the view, as in Heitz 2014, Hammon and Mikkelsen. */
#include "internal_curves.h"
#include <math.h>
#include <string.h>

enum { CURVE = 181 };

/* mirror 0: light along the normal, which casts no shadow, so that G2 is G1; 1: light and view at the same angle on both sides. */
static ff_status add_curve(const ff_plot_model *m, ff_isa isa, size_t k, int mirror, ff_figure *fig, ff_panel *panel, ff_error *err)
{
    double g[CURVE], theta[CURVE];
    ff_directions w;
    char label[FF_FIGURE_TEXT];
    ff_status status = ff_directions_new(CURVE, &w);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++) {
        theta[i] = fmin(90.0 * (double)i / (CURVE - 1), 89.99);
        ff_directions_set(&w, i, mirror ? theta[i] * FF_DEGREE : 0, 180 * FF_DEGREE, theta[i] * FF_DEGREE, 0);
    }
    status = ff_model_terms(m->model, isa, m->n_channels, m->shape, m->channel, 0, 0, &w.w, CURVE, &(ff_terms){.g = g});
    ff_directions_free(&w);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "%s has no masking to draw: %s", m->label, ff_status_str(status));
    ff_series *s =
        ff_panel_series(fig, panel, FF_SERIES_LINE, ff_figure_plain(m->label, label, sizeof label), ff_style_at(k), CURVE, 0);
    for (size_t i = 0; i < CURVE && s; i++) {
        s->x[i] = theta[i];
        s->y[i] = g[i];
    }
    return FF_OK;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    static const char *const title[] = {"light along the normal: G_{1}(θ_{o})", "mirror direction: G_{2}(θ_{i} = θ_{o})"};
    ff_status status = FF_OK;
    for (int mirror = 0; mirror < 2; mirror++) {
        ff_panel *p = ff_figure_panel(fig, title[mirror]);
        if (!p) break;
        for (size_t k = 0; k < s->n_models && !status; k++) status = add_curve(&s->model[k], c->isa, k, mirror, fig, p, err);
        ff_axis_say(&p->x, "θ_{o}", "degrees", FF_SCALE_ANGLE, 0, 90);
        ff_axis_say(&p->y, mirror ? "G_{2}" : "G_{1}", "1", c->log > 0 ? FF_SCALE_LOG : FF_SCALE_LINEAR, c->log > 0 ? 1e-3 : 0,
                    1.03);
        p->aspect = 0.8;
    }
    fig->columns = 2;
    snprintf(fig->title, sizeof fig->title, "Masking and shadowing");
    return status;
}

const ff_plot_kind ff_plot_masking = {
    .name = "masking",
    .help = "masking G1, and masking with shadowing G2, against the angle of the view",
    .takes = FF_PLOT_MODELS | FF_PLOT_TERMS | FF_PLOT_MASKINGS,
    .uses = FF_PLOT_LOG | FF_PLOT_ROUGHNESS | FF_PLOT_SEVERAL,
    .build = build,
};
