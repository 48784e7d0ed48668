/* image: half angle against difference angle, the two that matter most to a lobe (Matusik et al. 2003 show MERL so): data, model,
 * and where the model is too high or too low. */
#include "internal_samples.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FINE = 60 };
#define CLIP 0.5 /* of the relative residual */

/* Cells of both angles, as small as the number of samples lets them be filled. */
static size_t cells_for(size_t n)
{
    return n > 20000 ? 45 : n > 3000 ? 30 : 18;
}

static void say_axes(ff_panel *p)
{
    ff_axis_say(&p->x, "θ_{d}", "degrees", FF_SCALE_ANGLE, 0, 90);
    ff_axis_say(&p->y, "θ_{h}", "degrees", FF_SCALE_ANGLE, 0, 90);
    p->equal_cells = 1;
}

static ff_series *new_image(ff_figure *fig, const char *title, size_t cells, int log)
{
    ff_panel *p = ff_figure_panel(fig, title);
    ff_series *s = ff_panel_image(fig, p, title, cells, cells);
    if (!s) return NULL;
    say_axes(p);
    ff_axis_say(&p->z, "f", "sr^{−1}", log ? FF_SCALE_LOG : FF_SCALE_LINEAR, NAN, NAN);
    s->image.x_lo = s->image.y_lo = 0;
    s->image.x_hi = s->image.y_hi = 90;
    s->image.log = log;
    return s;
}

static void as_residual(ff_figure *fig, ff_series *s)
{
    if (!s) return;
    ff_panel *p = fig->panel[fig->n_panels - 1];
    ff_axis_say(&p->z, "(model − data) / data", "1", FF_SCALE_LINEAR, NAN, NAN);
    s->image.map = FF_MAP_DIVERGING;
    s->image.clip = CLIP;
}

/* FF_ERR_MEMORY */
static ff_status fill(const ff_samples *v, size_t cells, double *data, double *model, double *residual)
{
    double *sum = calloc(3 * cells * cells + 1, sizeof *sum), *fit = sum ? sum + cells * cells : NULL,
           *n = sum ? fit + cells * cells : NULL;
    if (!sum) return FF_ERR_MEMORY;
    for (size_t i = 0; i < v->n; i++) {
        const size_t a = (size_t)fmin(v->theta_d[i] / (90 * FF_DEGREE) * (double)cells, (double)cells - 1),
                     b = (size_t)fmin(v->theta_h[i] / (90 * FF_DEGREE) * (double)cells, (double)cells - 1), k = b * cells + a;
        sum[k] += v->value[i];
        if (v->total) fit[k] += v->total[i];
        n[k]++;
    }
    for (size_t k = 0; k < cells * cells; k++) {
        if (!(n[k] > 0)) continue;
        data[k] = sum[k] / n[k];
        if (model) model[k] = fit[k] / n[k];
        if (residual && sum[k] > 0) residual[k] = (fit[k] - sum[k]) / sum[k];
    }
    free(sum);
    return FF_OK;
}

static ff_status of_data(const ff_plot_subject *s, const ff_plot_choice *c, const ff_plot_channel *channel, ff_figure *fig,
                         ff_error *err)
{
    ff_samples v;
    const int log = c->log != 0;
    ff_status status = ff_samples_make(s, channel, c->isa, &v, err);
    if (status) return status;
    const size_t cells = cells_for(v.n);
    ff_series *data = new_image(fig, "data", cells, log), *model = NULL, *residual = NULL;
    if (s->n_models) {
        model = new_image(fig, "model", cells, log);
        residual = new_image(fig, "residual", cells, 0);
        as_residual(fig, residual);
    }
    if (data && (!s->n_models || (model && residual)))
        status = fill(&v, cells, data->image.z, model ? model->image.z : NULL, residual ? residual->image.z : NULL);
    ff_figure_note(fig, "means of the samples in cells of %.2g°, over all φ_{d}, up to %.3g° of light and view",
                   90.0 / (double)cells, s->max_theta / FF_DEGREE);
    if (s->n_models) ff_figure_note(fig, "colours of the residual end at ±%g", CLIP);
    if (v.step > 1) ff_figure_note(fig, "one of %zu samples is looked at", v.step);
    ff_samples_free(&v);
    return status;
}

/* phi_d = 90 degrees, as is usual; light and view at the horizon are left out. */
static ff_status of_model(const ff_plot_subject *s, const ff_plot_choice *c, const ff_plot_channel *channel, ff_figure *fig,
                          ff_error *err)
{
    ff_series *image = new_image(fig, "", FINE, c->log != 0);
    ff_directions d;
    ff_status status = image ? ff_directions_new((size_t)FINE * FINE, &d) : FF_OK;
    if (status || !image) return status;
    for (size_t k = 0; k < d.n; k++) {
        const size_t row = k / FINE;
        const double td = ((double)(k % FINE) + 0.5) * 90 / FINE * FF_DEGREE, th = ((double)row + 0.5) * 90 / FINE * FF_DEGREE;
        for (int side = 0; side < 2; side++) { /* wi = h cos td + y sin td, wo the other way */
            d.plane[3 * side][k] = sin(th) * cos(td);
            d.plane[3 * side + 1][k] = (side ? -1 : 1) * sin(td);
            d.plane[3 * side + 2][k] = cos(th) * cos(td);
        }
    }
    status = ff_plot_evaluate(&s->model[0], c->isa, channel->of_model, &d.w, d.n, image->image.z, NULL, NULL, err);
    for (size_t k = 0; k < d.n && !status; k++)
        if (d.plane[2][k] < 0.01) image->image.z[k] = NAN;
    ff_directions_free(&d);
    ff_figure_note(fig, "φ_{d} = 90°");
    return status;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_plot_channel channel[FF_PLOT_LIST];
    size_t n;
    const ff_plot_model *m = s->n_models ? &s->model[0] : NULL;
    ff_status status = ff_plot_channels(m, s->table, c->channel, channel, &n, err);
    if (!status && n > 1) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "an image shows one channel: name one");
    if (!status) status = (s->table ? of_data : of_model)(s, c, channel, fig, err);
    if (status) return status;
    ff_plot_title(m, channel, fig->title, sizeof fig->title);
    ff_plot_note_outcome(fig, m);
    fig->columns = fig->n_panels;
    return FF_OK;
}

const ff_plot_kind ff_plot_image = {
    .name = "image",
    .help = "half angle against difference angle in colours: data, model and the signed residual",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_MODELS,
    .uses = FF_PLOT_LOG | FF_PLOT_CHANNEL,
    .build = build,
};
