/* The scale of a robust loss from the data: the spread of the residuals where the model has about this value.
 *
 * One scale for all values would be that of the many small ones, and a whole specular peak would count as outliers. So residuals
 * are put in order of the magnitude that the model gives them, cut into bins of equal number, and each bin has its own standard
 * deviation, 1.4826 times the median of |r| (Hampel 1974); between the bins it is interpolated. The fit and the scale improve each
 * other in turn. Where the noise of the data is given, its standard deviations about the fit are the scale. */
#include "fit/losses/internal_loss.h"
#include "internal_stages.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { PER_BIN = 200, MOST_BINS = 24, ROUNDS = 6 };
#define MAD_TO_SIGMA   1.4826
#define SCALE_SETTLED  0.01 /* relative change of the median scale */
#define LEAST_OF_SCALE 1e-6 /* of the magnitude: a scale of 0 divides nothing */

typedef struct value {
    float magnitude, residual;
} value;

static int by_magnitude(const void *a, const void *b)
{
    const value *x = a, *y = b;
    return (x->magnitude > y->magnitude) - (x->magnitude < y->magnitude);
}

static int by_residual(const void *a, const void *b)
{
    const value *x = a, *y = b;
    return (x->residual > y->residual) - (x->residual < y->residual);
}

/* Scale as a function of magnitude: [n] points. */
typedef struct curve {
    size_t n;
    double magnitude[MOST_BINS], scale[MOST_BINS];
} curve;

static double scale_at(const curve *c, double magnitude)
{
    size_t k = 1;
    if (c->n == 1 || magnitude <= c->magnitude[0]) return c->scale[0];
    while (k < c->n && c->magnitude[k] < magnitude) k++;
    if (k == c->n) return c->scale[c->n - 1];
    const double span = c->magnitude[k] - c->magnitude[k - 1], s = span > 0 ? (magnitude - c->magnitude[k - 1]) / span : 1;
    return c->scale[k - 1] + s * (c->scale[k] - c->scale[k - 1]);
}

/* values [n], in any order; sorted here. */
static curve curve_of(value *values, size_t n)
{
    curve c = {.n = n / PER_BIN < 1 ? 1 : n / PER_BIN > MOST_BINS ? MOST_BINS : n / PER_BIN};
    qsort(values, n, sizeof *values, by_magnitude);
    for (size_t b = 0; b < c.n; b++) {
        const size_t first = b * n / c.n, end = (b + 1) * n / c.n;
        c.magnitude[b] = (double)values[(first + end) / 2].magnitude;
        qsort(values + first, end - first, sizeof *values, by_residual);
        c.scale[b] = fmax(MAD_TO_SIGMA * (double)values[(first + end) / 2].residual, LEAST_OF_SCALE * c.magnitude[b]);
        if (!(c.scale[b] > 0)) c.scale[b] = 1e-30;
    }
    return c;
}

/* Magnitude of w g(f) of value i of channel c. */
static double magnitude_of(const struct ff_problem *p, const double *model, size_t c, size_t i)
{
    const size_t block = i / FF_BLOCK, lane = i % FF_BLOCK;
    const double w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[lane], f = model[c * p->n + i];
    const double *x = ff_loss_reads_cosine(p->loss) ? ff_problem_plane(p, block, p->geometry[FF_G_COS_I]) + lane : NULL;
    double g;
    ff_loss_targets(p->loss, 1, &f, x, &g);
    return fabs(w * g);
}

double ff_residual_deviation(const struct ff_problem *p, const struct ff_noise *noise, const double *model, size_t c, size_t i)
{
    const size_t block = i / FF_BLOCK, lane = i % FF_BLOCK;
    const double w = ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[lane], f = fmax(model[c * p->n + i], 0),
                 cos_i = fmax((double)p->cosine[0][i], 1e-3), cos_o = fmax((double)p->cosine[1][i], 1e-3);
    const double *x = ff_loss_reads_cosine(p->loss) ? ff_problem_plane(p, block, p->geometry[FF_G_COS_I]) + lane : NULL;
    double slope;
    ff_loss_slopes(p->loss, 1, &f, x, &slope);
    return fmax(fabs(w * slope) * ff_noise_sd(noise, c, f, cos_i, cos_o), 1e-30);
}

/* Every k-th value, so that sorting stays quick. */
static size_t gather_values(const struct ff_problem *p, const double *model, const double *residual, size_t most, value *out)
{
    const size_t all = p->n * p->n_channels, step = all / most + 1;
    size_t n = 0;
    for (size_t at = 0; at < all; at += step) {
        const size_t c = at / p->n, i = at % p->n, block = i / FF_BLOCK;
        if (p->side >= 0 && ff_problem_plane(p, block, p->side + (int)c)[i % FF_BLOCK] != 0) continue;
        if (!(ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c)[i % FF_BLOCK] > 0)) continue;
        out[n++] = (value){(float)magnitude_of(p, model, c, i), (float)fabs(residual[at])};
    }
    return n;
}

/* Units of a smaller problem from those of p: its samples are some of p's, with other weights. */
static ff_status hand_down(const struct ff_problem *p, struct ff_problem *to)
{
    if (!to) return FF_OK;
    float *unit = malloc(to->n_channels * to->n_blocks * FF_BLOCK * sizeof *unit);
    if (!unit) return FF_ERR_MEMORY;
    for (size_t c = 0; c < to->n_channels; c++)
        for (size_t k = 0; k < to->n_blocks * FF_BLOCK; k++) {
            float *u = &unit[c * to->n_blocks * FF_BLOCK + k];
            *u = 1;
            if (k >= to->n) continue;
            const size_t i = to->index[k];
            const double here = ff_problem_plane(to, k / FF_BLOCK, to->sample_weight)[k % FF_BLOCK],
                         there = ff_problem_plane(p, i / FF_BLOCK, p->sample_weight)[i % FF_BLOCK];
            *u = p->unit[c * p->n_blocks * FF_BLOCK + i] * (float)(there > 0 ? here / there : 1);
        }
    free((float *)(uintptr_t)to->unit);
    to->unit = unit;
    return FF_OK;
}

/* The units of all values by the noise, NULL: by the curve; change: the mean of their |log ratio|, 1 at the first time. */
static ff_status set_units(struct ff_problem *p, const double *model, const struct ff_noise *noise, const curve *c, double *change)
{
    const size_t stride = p->n_blocks * FF_BLOCK;
    float *unit = malloc(p->n_channels * stride * sizeof *unit);
    double sum = 0;
    if (!unit) return FF_ERR_MEMORY;
    for (size_t k = 0; k < p->n_channels; k++)
        for (size_t i = 0; i < stride; i++) {
            double u = 1;
            if (i < p->n) u = noise ? ff_residual_deviation(p, noise, model, k, i) : scale_at(c, magnitude_of(p, model, k, i));
            unit[k * stride + i] = (float)u;
            if (i < p->n && p->unit) sum += fabs(log((double)(float)u / (double)p->unit[k * stride + i]));
        }
    *change = p->unit ? sum / (double)(p->n * p->n_channels) : 1;
    free((float *)(uintptr_t)p->unit);
    p->unit = unit;
    ff_status status = hand_down(p, p->subsample);
    if (!status && p->subsample_linear != p->subsample) status = hand_down(p, p->subsample_linear);
    return status ? status : hand_down(p, p->middle);
}

static void forget_units(struct ff_problem *p)
{
    struct ff_problem *const all[] = {p, p->subsample, p->subsample_linear, p->middle};
    for (size_t k = 0; k < 4; k++) {
        if (!all[k]) continue;
        free((float *)(uintptr_t)all[k]->unit);
        all[k]->unit = NULL;
    }
}

/* Model and residual of every value where the fit has ended. */
static ff_status values_at(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double *model,
                           double *residual, ff_error *err)
{
    ff_fit_options plain = *o; /* the residuals are those before any robust loss */
    ff_plan plan;
    ff_point at;
    plain.robust = FF_ROBUST_NONE;
    ff_status status = ff_plan_of_result(p, &plain, fit, &plan, err);
    if (status) return status;
    status = ff_point_of_result(&plan, fit, &at);
    if (!status) {
        status = ff_point_evaluate(&plan, &at, 1, model, residual, NULL);
        ff_point_free(&at);
    }
    ff_plan_free(&plan);
    return status ? ff_error_set(err, status, NULL, 0, -1, "out of memory") : FF_OK;
}

/* One round: the scale about the fit, which the fit then follows. */
static ff_status improve(struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double *model, double *residual,
                         value *values, size_t most, double *change, ff_error *err)
{
    ff_status status = values_at(p, o, fit, model, residual, err);
    if (status) return status;
    const size_t n = gather_values(p, model, residual, most, values);
    if (n == 0) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "no value is left to estimate the scale of the residuals from");
    const curve c = curve_of(values, n);
    status = set_units(p, model, o->noise, &c, change);
    return status ? ff_error_set(err, status, NULL, 0, -1, "out of memory") : FF_OK;
}

/* A fit from where `from` ended. */
static ff_status refit(struct ff_problem *p, const ff_model *m, const ff_fit_options *o, const ff_fit_result *from,
                       ff_fit_result *out, ff_error *err)
{
    const size_t size = from->n_channels * m->n_channel;
    ff_fit_options again = *o;
    double shape[FF_MAX_SHAPE], *channel = malloc((size + 1) * sizeof *channel);
    if (!channel) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (uint32_t k = 0; k < m->n_shape; k++) shape[k] = from->shape_value[k].value;
    for (size_t k = 0; k < size; k++) channel[k] = from->channel_value[k].value;
    again.start_shape = shape;
    again.start_channel = channel;
    const ff_status status = ff_fit_run(p, m, &again, out, err);
    free(channel);
    return status;
}

ff_status ff_problem_estimate_scale(ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_error *err)
{
    enum { MOST_VALUES = 200000 };
    const size_t all = p->n * p->n_channels;
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_fit_options plain = *o, robust = *o;
    ff_fit_result fit;
    plain.robust = FF_ROBUST_NONE;
    plain.std_errors = robust.std_errors = 0;
    robust.robust = FF_ROBUST_HUBER; /* convex: it has no minimum of its own to be caught in */
    robust.robust_scale = 0;
    forget_units(p);
    ff_status status = ff_fit_run(p, m, &plain, &fit, err);
    if (status) return status;
    double *model = malloc(2 * all * sizeof *model), *residual = model ? model + all : NULL, change = 1;
    value *values = malloc((MOST_VALUES + 1) * sizeof *values);
    if (!model || !values) status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (int round = 0; round < ROUNDS && !status && change > SCALE_SETTLED; round++) {
        ff_fit_result next;
        status = improve(p, o, &fit, model, residual, values, MOST_VALUES, &change, err);
        if (!status) status = refit(p, m, &robust, &fit, &next, err);
        if (status) break;
        ff_fit_result_clear(&fit);
        fit = next;
    }
    ff_fit_result_clear(&fit);
    free(model);
    free(values);
    if (status) forget_units(p);
    return status;
}

/* ---- a fit ----------------------------------------------------------------------------------- */

/* A problem and its smaller ones with units of their own: everything else is shared. */
typedef struct scaled {
    struct ff_problem all, subsample, subsample_linear, middle;
} scaled;

static void share(const struct ff_problem *p, scaled *s)
{
    s->all = *p;
    s->subsample = *p->subsample;
    s->all.subsample = s->all.subsample_linear = &s->subsample;
    if (p->subsample_linear != p->subsample) {
        s->subsample_linear = *p->subsample_linear;
        s->all.subsample_linear = &s->subsample_linear;
    }
    if (!p->middle) return;
    s->middle = *p->middle;
    s->all.middle = &s->middle;
}

ff_status ff_problem_fit_into(const ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err)
{
    scaled s;
    ff_status status = ff_fit_options_check(o, err);
    if (status) return status;
    if (o->robust == FF_ROBUST_NONE || o->robust_scale > 0 || p->unit) return ff_fit_run(p, m, o, out, err);
    share(p, &s);
    status = ff_problem_estimate_scale(&s.all, m, o, err);
    if (!status) status = ff_fit_run(&s.all, m, o, out, err);
    forget_units(&s.all);
    return status;
}
