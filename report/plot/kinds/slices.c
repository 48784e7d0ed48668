/* f against the angle of the view in the plane of incidence: data with their errors, the model and its parts, the mirror direction.
 */
#include "internal_slices.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CURVE = 361, MOST_PANELS = 4, MOST_POINTS = 1500, SPARSE = 30 };
#define LOG_FROM 30.0 /* spread of the values from which on an axis is logarithmic by itself */

typedef struct slices {
    const ff_plot_subject *s;
    const ff_plot_choice *c;
    int polar;
    size_t n_channels;
    ff_plot_channel channel[FF_PLOT_LIST];
    ff_planes planes;   /* of the data; n_groups = 0: none */
    double most, least; /* largest and smallest value above 0, of data that were fitted */
    double peak;        /* largest of the models                                       */
    size_t noted;       /* how many values of the data                                 */
} slices;

/* The only one has the styles of its parts, several have colours of their own. */
static ff_style style_of(const slices *f, ff_style alone, size_t k)
{
    if (f->n_channels == 1) return alone;
    const ff_style one = ff_style_at(k);
    return (ff_style){one.colour, alone.dash, f->n_channels > 1 && alone.dash == FF_DASH_SOLID ? one.marker : alone.marker};
}

static void name_of(const slices *f, const char *what, size_t k, char out[FF_FIGURE_TEXT])
{
    char channel[FF_CHANNEL_NAME];
    ff_figure_plain(f->channel[k].name, channel, sizeof channel);
    if (f->n_channels == 1)
        snprintf(out, FF_FIGURE_TEXT, "%s", what);
    else
        snprintf(out, FF_FIGURE_TEXT, "%s, %s", what, channel);
}

static void note_value(slices *f, double x)
{
    if (!isfinite(x)) return;
    f->most = fmax(f->most, x);
    f->noted++;
    if (x > 0) f->least = fmin(f->least, x);
}

/* ---- data ------------------------------------------------------------------------------------ */

static double error_of(const slices *f, size_t k, const ff_plane_sample *p, double value)
{
    const ff_plot_model *m = f->s->n_models ? &f->s->model[0] : NULL;
    const double sigma = ff_plot_sigma(f->s->table, f->channel[k].of_table, p->index);
    if (isfinite(sigma) || !m || !m->noise) return sigma;
    return ff_noise_sd(m->noise, f->channel[k].of_model, value, cos(p->theta_i), cos(p->theta_o));
}

static void add_points(slices *f, ff_figure *fig, ff_panel *panel, size_t k, size_t group, int fitted, size_t step)
{
    const size_t first = f->planes.first[group], end = f->planes.first[group + 1];
    char name[FF_FIGURE_TEXT];
    name_of(f, fitted ? "data" : "data, not fitted", k, name);
    ff_series *s = ff_panel_series(fig, panel, FF_SERIES_POINTS, name, style_of(f, fitted ? ff_style_data : ff_style_unused, k),
                                   end - first, fitted ? FF_WITH_Y_ERRORS : 0);
    size_t n = 0;
    for (size_t i = first; i < end && s; i += step) {
        const ff_plane_sample *p = &f->planes.sample[i];
        const int inside = fmax(p->theta_i, fabs(p->theta_o)) <= f->s->max_theta + 1e-9;
        if (inside != fitted) continue;
        const double y = ff_plot_value(f->s->table, f->channel[k].of_table, p->index), sd = error_of(f, k, p, y);
        s->x[n] = p->theta_o / FF_DEGREE;
        s->y[n] = y;
        if (fitted && sd > 0) {
            s->low[n] = y - sd;
            s->high[n] = y + sd;
        }
        if (fitted) note_value(f, y);
        n++;
    }
    ff_series_cut(s, n);
}

/* ---- models ---------------------------------------------------------------------------------- */

static void add_line(slices *f, ff_figure *fig, ff_panel *panel, const char *what, ff_style style, size_t k, const double *y)
{
    char name[FF_FIGURE_TEXT];
    name_of(f, what, k, name);
    ff_series *s = ff_panel_series(fig, panel, FF_SERIES_LINE, name, style, CURVE, 0);
    for (size_t i = 0; i < CURVE && s; i++) {
        s->x[i] = -90 + 180.0 * (double)i / (CURVE - 1);
        s->y[i] = y[i];
    }
}

/* At the horizon itself nothing is defined: a hair above it. */
static double angle_at(size_t i)
{
    const double degrees = -90 + 180.0 * (double)i / (CURVE - 1);
    return fmin(fmax(degrees, -89.99), 89.99) * FF_DEGREE;
}

static ff_status add_model(slices *f, ff_figure *fig, ff_panel *panel, size_t m, size_t k, double theta_i, double phi_i,
                           ff_error *err)
{
    const ff_plot_model *model = &f->s->model[m];
    const int parts = f->n_channels == 1 && f->s->n_models == 1;
    double y[FF_MAX_LOBES + 2][CURVE], *const lobes[FF_MAX_LOBES] = {y[2], y[3], y[4]};
    ff_directions d;
    char label[FF_FIGURE_TEXT];
    ff_status status = ff_directions_new(CURVE, &d);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++) ff_directions_set(&d, i, theta_i, phi_i, angle_at(i), phi_i + 180 * FF_DEGREE);
    status = ff_plot_evaluate(model, f->c->isa, f->channel[k].of_model < model->n_channels ? f->channel[k].of_model : 0, &d.w,
                              CURVE, y[0], parts ? lobes : NULL, parts ? y[1] : NULL, err);
    ff_directions_free(&d);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++)
        if (fabs(angle_at(i)) <= f->s->max_theta) f->peak = fmax(f->peak, y[0][i]);
    for (size_t i = 0; i < CURVE && !f->s->table; i++)
        if (fabs(angle_at(i)) <= f->s->max_theta) note_value(f, y[0][i]);
    ff_figure_plain(model->label, label, sizeof label);
    const ff_style style = f->n_channels > 1    ? style_of(f, ff_style_model, k)
                           : f->s->n_models > 1 ? ff_style_at(m)
                                                : ff_style_model;
    add_line(f, fig, panel, f->s->n_models > 1 ? label : "model", style, k, y[0]);
    for (uint32_t l = 0; parts && l < model->model->n_lobes; l++) {
        char name[16];
        snprintf(name, sizeof name, model->model->n_lobes > 1 ? "lobe %u" : "lobe", (unsigned)l + 1);
        ff_style lobe = ff_style_lobe;
        if (l) lobe = (ff_style){l == 1 ? FF_COLOUR_SKY : FF_COLOUR_PURPLE, l == 1 ? FF_DASH_SHORT : FF_DASH_DOTTED, 0};
        if (model->model->n_lobes + model->model->n_bases > 1) add_line(f, fig, panel, name, lobe, k, y[2 + l]);
    }
    if (parts && model->model->n_bases && model->model->n_lobes) add_line(f, fig, panel, "diffuse", ff_style_diffuse, k, y[1]);
    return FF_OK;
}

/* ---- panels ---------------------------------------------------------------------------------- */

/* One scale for all panels, over what was fitted: it may rise without bound towards the horizon. A half disc has its own, for its
 * shape is what is looked at. */
static void scale_axes(const slices *f, ff_figure *fig)
{
    const int log = f->c->log >= 0 ? f->c->log : f->most > LOG_FROM * f->least && !f->polar;
    const double most =
        fmax(f->most, f->noted < SPARSE ? f->peak : fmin(f->peak, 2 * f->most)); /* a peak of its own hides no data */
    double lo = 0, hi = most > 0 ? 1.06 * most : 1;
    if (log && f->most > 0) {
        const double floor_at = fmax(f->least, 1e-5 * f->most);
        lo = pow(10, floor(log10(floor_at) * 4) / 4);
        hi = 1.3 * most;
    }
    for (size_t i = f->polar && fig->n_panels ? fig->n_panels - 1 : 0; i < fig->n_panels; i++)
        ff_axis_say(&fig->panel[i]->y, "f", "sr^{−1}", log ? FF_SCALE_LOG : FF_SCALE_LINEAR, lo, hi);
}

static ff_status add_panel(slices *f, ff_figure *fig, double theta_i, double phi_i, size_t group, ff_error *err)
{
    char title[FF_FIGURE_TEXT];
    const double degrees = theta_i / FF_DEGREE;
    const int has_phi = f->s->table && !f->s->table->isotropic && theta_i > 1e-3;
    const int n = snprintf(title, sizeof title, "θ_{i} = %.4g°",
                           round(degrees * (f->planes.width > 0 ? 10 : 100)) / (f->planes.width > 0 ? 10 : 100));
    if (has_phi)
        snprintf(title + n, sizeof title - (size_t)n, ", φ_{i} = %s%.4g°", phi_i < -1e-3 ? "−" : "",
                 fabs(round(phi_i / FF_DEGREE * 10) / 10));
    ff_panel *p = ff_figure_panel(fig, title);
    if (!p) return FF_OK;
    p->kind = f->polar ? FF_PANEL_POLAR : FF_PANEL_PLANE;
    ff_axis_say(&p->x, "θ_{o}", "degrees", FF_SCALE_ANGLE, -90, 90);
    if (f->s->table) {
        const size_t count = f->planes.first[group + 1] - f->planes.first[group], step = (count + MOST_POINTS - 1) / MOST_POINTS;
        if (step > 1) ff_figure_note(fig, "%s: one of %zu samples is drawn", title, step);
        for (size_t k = 0; k < f->n_channels; k++)
            for (int fitted = 1; fitted >= (f->s->n_models ? 0 : 1); fitted--)
                add_points(f, fig, p, k, group, fitted, step ? step : 1);
    }
    ff_status status = FF_OK;
    for (size_t k = 0; k < f->n_channels && !status; k++)
        for (size_t m = 0; m < f->s->n_models && !status; m++) status = add_model(f, fig, p, m, k, theta_i, phi_i, err);
    if (degrees > 0.01) ff_panel_rule_x(fig, p, "mirror direction", ff_style_mark, degrees);
    if (f->polar) {
        scale_axes(f, fig);
        f->most = f->peak = 0;
        f->noted = 0;
        f->least = INFINITY;
    }
    return status;
}

static ff_status add_measured(slices *f, ff_figure *fig, ff_error *err)
{
    size_t group[FF_PLOT_LIST];
    ff_status status = ff_planes_find(f->s->table, &f->planes, err);
    const size_t n = status ? 0 : ff_planes_choose(&f->planes, f->c, MOST_PANELS, group);
    for (size_t k = 0; k < n && !status; k++) {
        const double theta = ff_planes_theta(&f->planes, group[k]);
        status = add_panel(f, fig, theta, f->planes.sample[f->planes.first[group[k]]].phi_i, group[k], err);
    }
    if (status) return status;
    if (f->planes.step > 1) ff_figure_note(fig, "one of %zu samples is looked at", f->planes.step);
    if (f->planes.width > 0) ff_figure_note(fig, "samples within half a degree of θ_{i}");
    if (f->planes.tolerance > 0.0011)
        ff_figure_note(fig, "samples up to %.2g° from the plane of incidence", asin(f->planes.tolerance) / FF_DEGREE);
    return FF_OK;
}

ff_status ff_slices_build(const ff_plot_subject *s, const ff_plot_choice *c, int polar, ff_figure *fig, ff_error *err)
{
    static const double usual[] = {15, 30, 45, 60};
    slices f = {.s = s, .c = c, .polar = polar, .least = INFINITY};
    const ff_plot_model *m = s->n_models ? &s->model[0] : NULL;
    ff_status status = ff_plot_channels(m, s->table, c->channel, f.channel, &f.n_channels, err);
    if (status) return status;
    if (s->table) {
        status = add_measured(&f, fig, err);
    } else {
        const size_t n = c->n_incidence ? c->n_incidence : 4;
        const double *degrees = c->n_incidence ? c->incidence : usual;
        for (size_t k = 0; k < n && !status; k++) status = add_panel(&f, fig, fmin(degrees[k], 89.9) * FF_DEGREE, 0, 0, err);
    }
    if (!status) {
        if (!polar) scale_axes(&f, fig);
        ff_plot_title(s->n_models > 1 ? NULL : m, f.n_channels == 1 ? &f.channel[0] : NULL, fig->title, sizeof fig->title);
        for (size_t k = 0; k < s->n_models; k++) ff_plot_note_outcome(fig, &s->model[k]);
        fig->columns = fig->n_panels > 1 ? 2 : 1;
    }
    ff_planes_free(&f.planes);
    return status;
}
