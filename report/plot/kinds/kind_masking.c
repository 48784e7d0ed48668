/* masking: G1, and G2 in the mirror configuration, against the angle of the view, as in Heitz 2014, Hammon and Mikkelsen; or G2 of
 * light from one side over all views of the plane of incidence. */
#include "internal_curves.h"
#include <math.h>
#include <string.h>

enum { CURVE = 181 };

/* What a panel shows. */
typedef enum light {
    LIGHT_NORMAL, /* along the normal, which casts no shadow, so that G2 is G1 */
    LIGHT_MIRROR, /* light and view at the same angle on both sides            */
    LIGHT_FIXED   /* at theta_i; the view goes from its side to the other      */
} light;

static double view_at(light which, size_t i)
{
    const double share = (double)i / (CURVE - 1), degrees = which == LIGHT_FIXED ? 180 * share - 90 : 90 * share;
    return fmin(fmax(degrees, -89.99), 89.99);
}

static ff_status add_curve(const ff_plot_model *m, ff_isa isa, size_t k, light which, double theta_i, ff_figure *fig,
                           ff_panel *panel, ff_error *err)
{
    double g[CURVE], theta[CURVE];
    ff_directions w;
    char label[FF_FIGURE_TEXT];
    ff_status status = ff_directions_new(CURVE, &w);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++) {
        theta[i] = view_at(which, i);
        const double light = which == LIGHT_NORMAL ? 0 : which == LIGHT_MIRROR ? theta[i] : fmin(theta_i, 89.99);
        ff_directions_set(&w, i, light * FF_DEGREE, 180 * FF_DEGREE, theta[i] * FF_DEGREE, 0);
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

static ff_status add_panel(const ff_plot_subject *s, const ff_plot_choice *c, light which, double theta_i, ff_figure *fig,
                           ff_error *err)
{
    static const char *const usual[] = {"light along the normal: G_{1}(θ_{o})", "mirror direction: G_{2}(θ_{i} = θ_{o})"};
    char title[FF_FIGURE_TEXT];
    ff_status status = FF_OK;
    snprintf(title, sizeof title, "G_{2}, θ_{i} = %.4g°", theta_i);
    ff_panel *p = ff_figure_panel(fig, which == LIGHT_FIXED ? title : usual[which]);
    if (!p) return FF_OK;
    for (size_t k = 0; k < s->n_models && !status; k++) status = add_curve(&s->model[k], c->isa, k, which, theta_i, fig, p, err);
    if (which == LIGHT_FIXED) ff_panel_rule_x(fig, p, "mirror direction", ff_style_mark, theta_i);
    ff_axis_say(&p->x, "θ_{o}", "degrees", FF_SCALE_ANGLE, which == LIGHT_FIXED ? -90 : 0, 90);
    ff_axis_say(&p->y, which == LIGHT_NORMAL ? "G_{1}" : "G_{2}", "1", c->log > 0 ? FF_SCALE_LOG : FF_SCALE_LINEAR,
                c->log > 0 ? 1e-3 : 0, 1.03);
    p->aspect = 0.8;
    return status;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t k = 0; k < c->n_incidence && !status; k++) status = add_panel(s, c, LIGHT_FIXED, c->incidence[k], fig, err);
    if (c->n_incidence == 0) status = add_panel(s, c, LIGHT_NORMAL, 0, fig, err);
    if (c->n_incidence == 0 && !status) status = add_panel(s, c, LIGHT_MIRROR, 0, fig, err);
    if (c->n_incidence) ff_figure_note(fig, "θ_{o} > 0 on the side of the mirror direction");
    fig->columns = fig->n_panels == 1 ? 1 : 2;
    snprintf(fig->title, sizeof fig->title, "Masking and shadowing");
    return status;
}

const ff_plot_kind ff_plot_masking = {
    .name = "masking",
    .help = "masking G1, and masking with shadowing G2, against the angle of the view",
    .takes = FF_PLOT_MODELS | FF_PLOT_TERMS | FF_PLOT_MASKINGS,
    .uses = FF_PLOT_INCIDENCE | FF_PLOT_LOG | FF_PLOT_ROUGHNESS | FF_PLOT_SEVERAL,
    .build = build,
};
