/* profile: what the half angle tells: f, and D as every sample has it when the rest of the model is divided out; beneath, F and G.
 *
 *  D of a sample = D(theta_h) (f - what lies under the first lobe) / first lobe: exact where F, G and diffuse are right. */
#include "internal_samples.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CURVE = 181, BINS = 90, FEWEST = 3 };

/* ---- bins of theta_h ------------------------------------------------------------------------- */

typedef struct binned {
    double x, low, middle, high;
} binned;

static void swap(double *a, double *b)
{
    const double t = *a;
    *a = *b;
    *b = t;
}

/* Puts the k-th smallest of n numbers in its place, none larger before it and none smaller behind (Hoare 1961). */
static void select_place(double *x, size_t n, size_t k)
{
    size_t first = 0, last = n - 1;
    while (first < last) {
        const double pivot = x[first + (last - first) / 2];
        size_t i = first, j = last;
        for (;;) {
            while (x[i] < pivot) i++;
            while (x[j] > pivot) j--;
            if (i >= j) break;
            swap(&x[i++], &x[j--]);
        }
        if (k <= j)
            last = j;
        else
            first = j + 1;
    }
}

/* Quantile of n numbers, which change their places. */
static double quantile(double *x, size_t n, double q)
{
    const double at = q * (double)(n - 1);
    const size_t k = (size_t)at;
    select_place(x, n, k);
    double next = k + 1 < n ? x[k + 1] : x[k];
    for (size_t i = k + 2; i < n; i++) next = fmin(next, x[i]);
    return x[k] + (at - (double)k) * (next - x[k]);
}

static size_t bin_of(const ff_samples *v, size_t i, size_t bins)
{
    return (size_t)fmin(v->theta_h[i] / (90 * FF_DEGREE) * (double)bins, (double)bins - 1);
}

/* Medians and the range from 10 to 90 per cent of y in every bin that has enough of them; how many. */
static ff_status bin(const ff_samples *v, const double *y, size_t bins, binned *out, size_t *n)
{
    size_t start[BINS + 1] = {0};
    double *binned_values = malloc((v->n + 1) * sizeof *binned_values);
    *n = 0;
    if (!binned_values) return FF_ERR_MEMORY;
    for (size_t i = 0; i < v->n; i++)
        if (isfinite(y[i])) start[bin_of(v, i, bins) + 1]++;
    for (size_t b = 0; b < bins; b++) start[b + 1] += start[b];
    size_t filled[BINS];
    memcpy(filled, start, sizeof filled);
    for (size_t i = 0; i < v->n; i++)
        if (isfinite(y[i])) binned_values[filled[bin_of(v, i, bins)]++] = y[i];
    for (size_t b = 0; b < bins; b++) {
        double *values = binned_values + start[b];
        const size_t count = start[b + 1] - start[b];
        if (count < FEWEST) continue;
        out[(*n)++] = (binned){((double)b + 0.5) * 90 / (double)bins, quantile(values, count, 0.1), quantile(values, count, 0.5),
                               quantile(values, count, 0.9)};
    }
    free(binned_values);
    return FF_OK;
}

static void add_binned(ff_figure *fig, ff_panel *p, const char *name, const binned *b, size_t n)
{
    char text[FF_FIGURE_TEXT];
    snprintf(text, sizeof text, "%s, 10 to 90 %%", name);
    ff_series *band = ff_panel_series(fig, p, FF_SERIES_BAND, text, (ff_style){FF_COLOUR_SKY, 0, 0}, n, FF_WITH_Y_ERRORS);
    snprintf(text, sizeof text, "%s, median", name);
    ff_series *points = ff_panel_series(fig, p, FF_SERIES_POINTS, text, ff_style_data, n, 0);
    for (size_t i = 0; i < n && band && points; i++) {
        band->x[i] = points->x[i] = b[i].x;
        band->y[i] = points->y[i] = b[i].middle;
        band->low[i] = b[i].low;
        band->high[i] = b[i].high;
    }
}

/* Of the data; few samples stand there by themselves. */
static ff_status add_data(ff_figure *fig, ff_panel *p, const ff_samples *v, const double *y, const char *name, ff_error *err)
{
    binned b[BINS];
    size_t n;
    const size_t bins = v->n > 2000 ? 45 : 18;
    (void)err;
    if (v->n < 200) {
        ff_series *s = ff_panel_series(fig, p, FF_SERIES_POINTS, name, ff_style_data, v->n, 0);
        for (size_t i = 0; i < v->n && s; i++) {
            s->x[i] = v->theta_h[i] / FF_DEGREE;
            s->y[i] = y[i];
        }
        return FF_OK;
    }
    const ff_status status = bin(v, y, bins, b, &n);
    if (!status && n) add_binned(fig, p, name, b, n);
    return status;
}

/* ---- curves of the model --------------------------------------------------------------------- */

typedef enum factor { FACTOR_D, FACTOR_F, FACTOR_G } factor;

static void direction(ff_directions *d, size_t i, factor which, double theta)
{
    if (which == FACTOR_D) ff_directions_set(d, i, theta, 0, theta, 0);               /* h = wi = wo      */
    if (which == FACTOR_F) ff_directions_set(d, i, theta, 180 * FF_DEGREE, theta, 0); /* h = n            */
    if (which == FACTOR_G) ff_directions_set(d, i, 0, 0, theta, 0);                   /* light along n: G1 */
}

static ff_status add_curve(const ff_plot_model *m, const ff_plot_choice *c, size_t channel, factor which, ff_figure *fig,
                           ff_panel *p, ff_error *err)
{
    double y[CURVE];
    ff_directions d;
    ff_status status = ff_directions_new(CURVE, &d);
    if (status) return status;
    for (size_t i = 0; i < CURVE; i++) direction(&d, i, which, fmin(90.0 * (double)i / (CURVE - 1), 89.9) * FF_DEGREE);
    const ff_terms terms = {
        .d = which == FACTOR_D ? y : NULL, .fresnel = which == FACTOR_F ? y : NULL, .g = which == FACTOR_G ? y : NULL};
    status = ff_model_terms(m->model, c->isa, m->n_channels, m->shape, m->channel, 0, channel < m->n_channels ? channel : 0, &d.w,
                            CURVE, &terms);
    ff_directions_free(&d);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "%s has no lobe to draw: %s", m->label, ff_status_str(status));
    ff_series *s = ff_panel_series(fig, p, FF_SERIES_LINE, "model", ff_style_model, CURVE, 0);
    for (size_t i = 0; i < CURVE && s; i++) {
        s->x[i] = 90.0 * (double)i / (CURVE - 1);
        s->y[i] = y[i];
    }
    return FF_OK;
}

/* ---- panels ---------------------------------------------------------------------------------- */

static ff_status add_f(const ff_samples *v, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    binned b[BINS];
    size_t n = 0;
    ff_panel *p = ff_figure_panel(fig, "BRDF by half angle, all θ_{d}");
    ff_status status = add_data(fig, p, v, v->value, "data", err);
    if (!status && v->total) status = bin(v, v->total, v->n > 2000 ? 45 : 18, b, &n);
    if (status || !p) return status;
    ff_series *s =
        n ? ff_panel_series(fig, p, FF_SERIES_LINE, "model, median", (ff_style){FF_COLOUR_VERMILLION, FF_DASH_LONG, 0}, n, 0)
          : NULL;
    for (size_t i = 0; i < n && s; i++) s->x[i] = b[i].x, s->y[i] = b[i].middle;
    ff_axis_say(&p->x, "θ_{h}", "degrees", FF_SCALE_ANGLE, 0, 90);
    ff_axis_say(&p->y, "f", "sr^{−1}", c->log == 0 ? FF_SCALE_LINEAR : FF_SCALE_LOG, NAN, NAN);
    return FF_OK;
}

static double largest_of(const ff_panel *p)
{
    double most = 0;
    for (size_t k = 0; k < p->n_series; k++)
        for (size_t i = 0; i < p->series[k]->n; i++)
            if (p->series[k]->y && isfinite(p->series[k]->y[i])) most = fmax(most, p->series[k]->y[i]);
    return most;
}

/* Above 0. */
static double least_of(const ff_panel *p)
{
    double least = INFINITY;
    for (size_t k = 0; k < p->n_series; k++)
        for (size_t i = 0; i < p->series[k]->n; i++)
            if (p->series[k]->y[i] > 0) least = fmin(least, p->series[k]->y[i]);
    return least;
}

static ff_status add_d(ff_samples *v, const ff_plot_model *m, const ff_plot_choice *c, size_t channel, ff_figure *fig,
                       ff_error *err)
{
    ff_panel *p = ff_figure_panel(fig, v ? "D: of the model, and as the data have it" : "distribution of normals");
    ff_status status = FF_OK;
    for (size_t i = 0; v && i < v->n; i++)
        v->d[i] = v->lobe[i] > 1e-3 * v->total[i] ? v->d[i] * (v->value[i] - v->base[i]) / v->lobe[i] : NAN;
    if (v) status = add_data(fig, p, v, v->d, "data", err);
    if (!status) status = add_curve(m, c, channel, FACTOR_D, fig, p, err);
    if (status || !p) return status;
    const double most = largest_of(p), least = fmax(1e-6 * most, 0.5 * least_of(p));
    ff_axis_say(&p->x, "θ_{h}", "degrees", FF_SCALE_ANGLE, 0, 90);
    ff_axis_say(&p->y, "D", "sr^{−1}", c->log == 0 ? FF_SCALE_LINEAR : FF_SCALE_LOG, c->log == 0 ? 0 : least, 1.5 * most);
    return FF_OK;
}

static ff_status add_factor(const ff_plot_model *m, const ff_plot_choice *c, size_t channel, factor which, ff_figure *fig,
                            ff_error *err)
{
    const int is_f = which == FACTOR_F;
    ff_panel *p = ff_figure_panel(fig, is_f ? "Fresnel term" : "masking, light along the normal");
    const ff_status status = add_curve(m, c, channel, which, fig, p, err);
    if (status || !p) return status;
    ff_axis_say(&p->x, is_f ? "θ_{d}" : "θ_{o}", "degrees", FF_SCALE_ANGLE, 0, 90);
    ff_axis_say(&p->y, is_f ? "F" : "G_{1}", "1", FF_SCALE_LINEAR, 0, fmax(1.04, 1.04 * largest_of(p)));
    return FF_OK;
}

static ff_status build(const ff_plot_subject *s, const ff_plot_choice *c, ff_figure *fig, ff_error *err)
{
    ff_plot_channel channel[FF_PLOT_LIST];
    size_t n;
    ff_samples v = {.n = 0};
    const ff_plot_model *m = &s->model[0];
    ff_status status = ff_plot_channels(m, s->table, c->channel, channel, &n, err);
    if (!status && n > 1) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a profile shows one channel: name one");
    if (!status && m->model->n_lobes == 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s has no lobe, and so no distribution of normals", m->label);
    if (!status && s->table) status = ff_samples_make(s, channel, c->isa, &v, err);
    if (!status && s->table) status = add_f(&v, c, fig, err);
    if (!status) status = add_d(s->table ? &v : NULL, m, c, channel->of_model, fig, err);
    if (!status) status = add_factor(m, c, channel->of_model, FACTOR_F, fig, err);
    if (!status) status = add_factor(m, c, channel->of_model, FACTOR_G, fig, err);
    if (v.step > 1) ff_figure_note(fig, "one of %zu samples is looked at", v.step);
    ff_samples_free(&v);
    if (status) return status;
    if (m->model->n_lobes > 1) ff_figure_note(fig, "D, F and G of the first lobe");
    ff_plot_title(m, channel, fig->title, sizeof fig->title);
    ff_plot_note_outcome(fig, m);
    fig->columns = s->table ? 2 : 3;
    return FF_OK;
}

const ff_plot_kind ff_plot_profile = {
    .name = "profile",
    .help = "by half angle: f, and D as the data have it beside that of the model; F and G",
    .takes = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_MODELS,
    .uses = FF_PLOT_LOG | FF_PLOT_CHANNEL,
    .build = build,
};
