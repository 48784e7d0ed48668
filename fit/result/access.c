/* A result for programs that do not see inside: read by name and place. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>

const ff_model *ff_fit_result_model(const ff_fit_result *r)
{
    return &r->model;
}

ff_shape ff_fit_result_shape(const ff_fit_result *r)
{
    return r->shape;
}

ff_outcome ff_fit_result_outcome(const ff_fit_result *r)
{
    return r->outcome;
}

int ff_fit_result_iterations(const ff_fit_result *r)
{
    return r->iterations;
}

int ff_fit_result_passes(const ff_fit_result *r)
{
    return r->passes;
}

double ff_fit_result_seconds(const ff_fit_result *r)
{
    return r->time_s;
}

size_t ff_fit_result_channel_count(const ff_fit_result *r)
{
    return r->n_channels;
}

const ff_noise *ff_fit_result_noise(const ff_fit_result *r)
{
    return r->noise ? r->noise->noise : NULL;
}

size_t ff_fit_result_free_count(const ff_fit_result *r)
{
    return r->n_free;
}

void ff_fit_result_free(ff_fit_result *r)
{
    ff_fit_result_clear(r);
    free(r);
}

/* ---- numbers --------------------------------------------------------------------------------- */

const ff_fit_value *ff_fit_result_at(const ff_fit_result *r, ff_param_ref ref, size_t c)
{
    if (ref.kind == FF_PARAM_SHAPE && ref.index < r->model.n_shape) return &r->shape_value[ref.index];
    if (ref.kind == FF_PARAM_CHANNEL && ref.index < r->model.n_channel && c < r->n_channels)
        return &r->channel_value[c * r->model.n_channel + ref.index];
    return NULL;
}

const ff_fit_value *ff_fit_result_find(const ff_fit_result *r, const char *name, size_t c)
{
    return ff_fit_result_at(r, ff_model_param_find(&r->model, name), c);
}

void ff_fit_result_values(const ff_fit_result *r, double *shape, double *channel)
{
    for (uint32_t k = 0; shape && k < r->model.n_shape; k++) shape[k] = r->shape_value[k].value;
    for (size_t k = 0; channel && k < r->n_channels * r->model.n_channel; k++) channel[k] = r->channel_value[k].value;
}

/* That of parameter k of channel c with a column, or with parameter `own` of its channel; see ff_fit_result. */
static double with_channel(const ff_fit_result *r, uint32_t k, size_t c, size_t at)
{
    const size_t K = r->model.n_channel;
    return r->channel_correlation[(c * K + k) * (r->n_columns + K) + at];
}

double ff_fit_result_correlation(const ff_fit_result *r, ff_param_ref a, size_t channel_a, ff_param_ref b, size_t channel_b)
{
    const ff_fit_value *x = ff_fit_result_at(r, a, channel_a), *y = ff_fit_result_at(r, b, channel_b);
    if (!x || !y || !r->correlation) return NAN;
    if (x->column >= 0 && y->column >= 0) return r->correlation[(size_t)x->column * r->n_columns + (size_t)y->column];
    if (!r->channel_correlation) return NAN;
    if (a.kind == FF_PARAM_SHAPE) return b.kind == FF_PARAM_SHAPE ? NAN : ff_fit_result_correlation(r, b, channel_b, a, channel_a);
    if (b.kind == FF_PARAM_SHAPE) return y->column < 0 ? NAN : with_channel(r, a.index, channel_a, (size_t)y->column);
    return channel_a == channel_b ? with_channel(r, a.index, channel_a, r->n_columns + b.index) : NAN;
}

const ff_ellipse *ff_fit_result_ellipse(const ff_fit_result *r)
{
    return r->has_ellipse ? &r->ellipse : NULL;
}

/* ---- residuals, and what the data can tell --------------------------------------------------- */

double ff_fit_result_objective(const ff_fit_result *r)
{
    return r->residual.objective;
}

double ff_fit_result_prior_penalty(const ff_fit_result *r)
{
    return r->prior_penalty;
}

double ff_fit_result_rmse(const ff_fit_result *r)
{
    return r->residual.rmse;
}

double ff_fit_result_max_abs(const ff_fit_result *r)
{
    return r->residual.max_abs;
}

double ff_fit_result_loss_rmse(const ff_fit_result *r, ff_loss loss)
{
    return (int)loss >= 0 && (int)loss < FF_LOSS_COUNT ? r->residual.loss_rmse[loss] : NAN;
}

double ff_fit_result_aic(const ff_fit_result *r)
{
    return r->aic;
}

double ff_fit_result_bic(const ff_fit_result *r)
{
    return r->bic;
}

size_t ff_fit_result_rank(const ff_fit_result *r)
{
    return r->rank;
}

double ff_fit_result_condition(const ff_fit_result *r)
{
    return r->condition;
}

double ff_fit_result_effective_samples(const ff_fit_result *r)
{
    return r->effective_samples;
}

size_t ff_fit_result_correlated_over(const ff_fit_result *r)
{
    return r->correlated_over;
}

int ff_fit_result_correlation_settled(const ff_fit_result *r)
{
    return r->correlation_settled;
}

/* ---- warnings -------------------------------------------------------------------------------- */

size_t ff_fit_result_warning_count(const ff_fit_result *r)
{
    return r->warnings.n;
}

const ff_warning *ff_fit_result_warning(const ff_fit_result *r, size_t i)
{
    return i < r->warnings.n ? &r->warnings.item[i] : NULL;
}
