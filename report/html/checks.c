/* What a fit depends on and should not: the largest angle that is fitted, and the loss. */
#include "internal_html.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PANELS = 4, LIMITS = 8, FIRST_DEGREES = 30, SAMPLES = 20000 };

/* A number with a standard error. */
typedef struct shown_number {
    char name[FF_REPORT_NAME];
    const ff_fit_value *value;
    ff_param_ref ref;
    size_t channel;
    const char *unit;
} shown_number;

/* Those of the shape and of one channel, the middle one. */
static size_t choose_numbers(const ff_html_subject *s, size_t most, shown_number *out)
{
    const ff_fit_result *fit = &s->r->fit[s->shown];
    const ff_problem *p = s->r->problem[s->shown / s->models];
    const size_t c = fit->n_channels / 2;
    size_t n = 0;
    for (uint32_t k = 0; k < fit->model.n_shape && n < most; k++) {
        const ff_fit_value *v = &fit->shape_value[k];
        if (v->held || v->tied) continue;
        out[n] = (shown_number){.value = v, .ref = {FF_PARAM_SHAPE, k}, .unit = fit->model.shape[k].info->unit};
        snprintf(out[n++].name, FF_REPORT_NAME, "%s", fit->model.shape[k].name);
    }
    for (uint32_t k = 0; k < fit->model.n_channel && n < most; k++) {
        const ff_fit_value *v = &fit->channel_value[c * fit->model.n_channel + k];
        if (v->held || v->tied) continue;
        out[n] = (shown_number){.value = v, .ref = {FF_PARAM_CHANNEL, k}, .channel = c, .unit = fit->model.channel[k].info->unit};
        ff_report_channel_param(p, fit, k, c, out[n++].name);
    }
    return n;
}

static ff_panel *new_panel(ff_figure *fig, const shown_number *number)
{
    char name[FF_FIGURE_TEXT];
    ff_panel *p = ff_figure_panel(fig, "");
    if (!p) return NULL;
    ff_axis_say(&p->y, ff_figure_plain(number->name, name, sizeof name), number->unit, FF_SCALE_LINEAR, NAN, NAN);
    p->aspect = 0.85;
    return p;
}

/* The interval of the fit as a band from x = lo to hi. */
static void add_band(ff_figure *fig, ff_panel *p, const ff_fit_value *v, double lo, double hi)
{
    if (!isfinite(v->low)) return;
    ff_series *band =
        ff_panel_series(fig, p, FF_SERIES_BAND, "95 % interval of the fit", (ff_style){FF_COLOUR_SKY, 0, 0}, 2, FF_WITH_Y_ERRORS);
    for (size_t i = 0; i < 2 && band; i++) {
        band->x[i] = i ? hi : lo;
        band->y[i] = v->value;
        band->low[i] = v->low;
        band->high[i] = v->high;
    }
}

/* ---- lower limits of theta ------------------------------------------------------------------- */

/* Values [n] of the numbers at a limit; 0 where the fit to so few samples cannot be made. */
static ff_status fit_below(const ff_html_subject *s, const shown_number *number, size_t n, double theta, double *out, int *done,
                           ff_error *err)
{
    ff_cut_off c;
    ff_error reason = {0};
    ff_fit_options o = *s->r->options;
    if (o.channels == FF_CHANNELS_EACH) o.channels = FF_CHANNELS_RGB, o.only_channel = (int)(s->shown / s->models);
    const ff_status status =
        ff_trust_cut_off_into(s->r->problem[s->shown / s->models], &o, &s->r->fit[s->shown], theta, &c, &reason);
    *done = status == FF_OK;
    if (status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED || status == FF_ERR_RANGE) return FF_OK;
    if (status) {
        if (err) *err = reason;
        return status;
    }
    for (size_t k = 0; k < n; k++) {
        const int column = number[k].value->column;
        out[k] = column >= 0 && (size_t)column < c.n_columns ? c.value[column] : NAN;
    }
    ff_cut_off_clear(&c);
    return FF_OK;
}

ff_status ff_html_cut_offs(const ff_html_subject *s, ff_figure *fig, ff_error *err)
{
    shown_number number[PANELS];
    double theta[LIMITS], value[LIMITS][PANELS];
    const size_t n = choose_numbers(s, PANELS, number);
    const double last = s->r->options->max_theta / FF_DEGREE;
    const int step = last > FIRST_DEGREES + 10 * (LIMITS - 2) ? 20 : 10;
    size_t limits = 0;
    ff_status status = FF_OK;
    for (int degrees = FIRST_DEGREES; degrees < last - 5 && limits + 1 < LIMITS && !status; degrees += step) {
        int done;
        status = fit_below(s, number, n, degrees * FF_DEGREE, value[limits], &done, err);
        if (!status && done) theta[limits++] = degrees;
    }
    if (status) return status;
    if (n == 0 || limits == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "too few samples below any lower limit");
    for (size_t k = 0; k < n; k++) value[limits][k] = number[k].value->value;
    theta[limits++] = last;
    for (size_t k = 0; k < n; k++) {
        ff_panel *p = new_panel(fig, &number[k]);
        if (!p) break;
        add_band(fig, p, number[k].value, theta[0] - 2, last + 2);
        ff_series *line = ff_panel_series(fig, p, FF_SERIES_LINE, "samples up to the angle", ff_style_model, limits, 0);
        ff_series *points = ff_panel_series(fig, p, FF_SERIES_POINTS, "", ff_style_model, limits, 0);
        for (size_t i = 0; i < limits && line && points; i++) {
            line->x[i] = points->x[i] = theta[i];
            line->y[i] = points->y[i] = value[i][k];
        }
        ff_axis_say(&p->x, "samples up to", "degrees", FF_SCALE_ANGLE, theta[0] - 2, last + 2);
    }
    fig->columns = n < 2 ? 1 : 2;
    return FF_OK;
}

/* ---- other losses ---------------------------------------------------------------------------- */

/* Every step-th sample of t as a table by itself. */
static ff_status thin(const ff_table *t, size_t step, ff_table *out, ff_error *err)
{
    const size_t n = (t->n + step - 1) / step;
    ff_status status = ff_table_init(n, t->n_channels, NULL, t->sigma != NULL, ff_table_has_weights(t), out, err);
    if (status) return status;
    out->radians_per_unit = 1;
    out->isotropic = t->isotropic;
    for (size_t c = 0; c < t->n_channels; c++) out->channels[c] = t->channels[c];
    for (size_t i = 0; i < n; i++) {
        double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_table_directions(t, i * step, 1, planes);
        for (int k = 0; k < 2; k++) {
            out->angle[2 * k][i] = atan2(hypot(w[3 * k], w[3 * k + 1]), w[3 * k + 2]);
            out->angle[2 * k + 1][i] = atan2(w[3 * k + 1], w[3 * k]);
        }
        out->valid[i] = t->valid[i * step];
        for (size_t c = 0; c < t->n_channels; c++) {
            out->value[c * n + i] = t->value[c * t->n + i * step];
            if (t->sigma) out->sigma[c * n + i] = t->sigma[c * t->n + i * step];
        }
        if (out->weight) ff_table_weights(t, i * step, 1, &out->weight[i]);
    }
    return FF_OK;
}

/* The fit of a loss from where the fit ended. *done 0: these data cannot be fitted so, or the fit did not converge. */
static ff_status fit_by(const ff_html_subject *s, const ff_table *t, int loss, ff_fit_result *out, int *done, ff_error *err)
{
    const ff_plot_model *m = &s->model[s->shown];
    const ff_model *model = &s->r->fit[s->shown].model;
    ff_fit_options o = *s->r->options;
    ff_error reason = {0};
    ff_problem *p;
    o.loss = (ff_loss)loss;
    o.progress = NULL;
    o.start_shape = m->shape;
    o.start_channel = m->channel;
    if (o.channels == FF_CHANNELS_EACH) o.channels = FF_CHANNELS_RGB, o.only_channel = (int)(s->shown / s->models);
    ff_status status = ff_problem_make(t, model, 1, &o, &p, &reason);
    if (!status) {
        status = ff_problem_fit_into(p, model, &o, out, &reason);
        ff_problem_free(p);
    }
    *done = status == FF_OK;
    if (status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED || status == FF_ERR_RANGE) return FF_OK;
    if (status && err) *err = reason;
    return status;
}

typedef struct by_loss {
    int done[FF_LOSS_COUNT];
    ff_fit_value value[FF_LOSS_COUNT][PANELS];
} by_loss;

static ff_status fit_all(const ff_html_subject *s, const ff_table *t, const shown_number *number, size_t n, by_loss *out,
                         ff_error *err)
{
    ff_status status = FF_OK;
    for (int loss = 0; loss < FF_LOSS_COUNT && !status; loss++) {
        ff_fit_result fit;
        status = fit_by(s, t, loss, &fit, &out->done[loss], err);
        if (status || !out->done[loss]) continue;
        out->done[loss] = fit.outcome == FF_CONVERGED;
        for (size_t k = 0; k < n; k++) out->value[loss][k] = *ff_fit_result_at(&fit, number[k].ref, number[k].channel);
        ff_fit_result_clear(&fit);
    }
    return status;
}

static void add_losses(const ff_html_subject *s, const by_loss *by, const shown_number *number, size_t k, ff_figure *fig)
{
    ff_panel *p = new_panel(fig, &number[k]);
    if (!p) return;
    add_band(fig, p, number[k].value, -0.5, FF_LOSS_COUNT - 0.5);
    ff_axis_names(fig, &p->x, FF_LOSS_COUNT);
    for (int own = 0; own < 2; own++) {
        ff_series *points = ff_panel_series(fig, p, FF_SERIES_POINTS, own ? "the loss of the fit" : "other losses",
                                            own ? ff_style_model : ff_style_data, FF_LOSS_COUNT, FF_WITH_Y_ERRORS);
        size_t n = 0;
        for (int loss = 0; loss < FF_LOSS_COUNT && points; loss++) {
            const ff_fit_value *v = &by->value[loss][k];
            ff_axis_name(&p->x, (size_t)loss, ff_loss_name(loss));
            if (!by->done[loss] || own != (loss == (int)s->r->options->loss)) continue;
            points->x[n] = loss;
            points->y[n] = v->value;
            points->low[n] = v->low;
            points->high[n++] = v->high;
        }
        ff_series_cut(points, n);
    }
}

ff_status ff_html_losses(const ff_html_subject *s, ff_figure *fig, ff_error *err)
{
    const ff_table *t = s->r->table;
    const size_t step = (t->n + SAMPLES - 1) / SAMPLES;
    shown_number number[PANELS];
    ff_table small;
    if (s->r->options->weighting == FF_WEIGHT_NOISE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "weights by the noise take the place of the loss");
    const size_t n = choose_numbers(s, PANELS, number);
    if (n == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the fit has no free parameter");
    by_loss *by = calloc(1, sizeof *by);
    ff_status status = by ? FF_OK : FF_ERR_MEMORY;
    if (!status && step > 1) status = thin(t, step, &small, err);
    if (!status) {
        status = fit_all(s, step > 1 ? &small : t, number, n, by, err);
        if (step > 1) ff_table_clear(&small);
    }
    for (size_t k = 0; k < n && !status; k++) add_losses(s, by, number, k, fig);
    if (step > 1) ff_figure_note(fig, "fits to one of %zu samples", step);
    ff_figure_note(fig, "bars: 95 %% intervals; fits that did not converge are left out");
    fig->columns = n < 2 ? 1 : 2;
    free(by);
    return status;
}
