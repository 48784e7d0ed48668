/* Standard errors, correlations and intervals of a result, from the information at its point. */
#include "internal_result.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Of parameters i and j, where both have a standard error; NaN where it is not formed. */
static double correlation(const ff_information *info, size_t i, size_t j, double a, double b)
{
    const double scale = a * b, cov = ff_information_covariance(info, i, j);
    if (i == j && !isnan(a)) return 1;
    return isnan(scale) || isnan(cov) ? NAN : scale > 0 ? fmin(fmax(cov / scale, -1), 1) : 0;
}

/* Parameters with a standard error get a column of the correlations; of many channels those that all share. */
static void standard_errors(const ff_plan *plan, const ff_information *info, const ff_noise_found *noise, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    r->n_columns = 0;
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        if (!info->determined[k] || v->weightless) continue;
        v->std_error = sqrt(fmax(info->variance[k], 0)); /* rounding may leave -1e-30 where the residuals vanish */
        if (!l->arrowhead || k < l->n_shared) v->column = (int)r->n_columns++;
        if (!noise) continue;
        v->carriers = noise->carriers.number[k];
        v->residual_error = noise->carriers.hc3[k];
    }
}

static void fill_correlations(const ff_layout *l, const ff_information *info, ff_fit_result *r)
{
    const size_t n = l->arrowhead ? l->n_shared : l->P;
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++) {
            const ff_fit_value *x = ff_result_value(l, r, a), *y = ff_result_value(l, r, b);
            if (x->column < 0 || y->column < 0) continue;
            r->correlation[(size_t)x->column * r->n_columns + (size_t)y->column] =
                correlation(info, a, b, x->std_error, y->std_error);
        }
}

/* Of one of many channels with what all share and within itself. */
static void correlations_of_channel(const ff_layout *l, const ff_information *info, size_t c, ff_fit_result *r)
{
    const size_t S = l->n_shared, K = l->n_own, N = l->m->n_channel, width = r->n_columns + N, first = S + c * K;
    double *rows = r->channel_correlation + c * N * width;
    for (size_t k = 0; k < N * width; k++) rows[k] = NAN;
    for (size_t k = 0; k < K; k++) {
        double *row = rows + (size_t)(ff_layout_param(l, first + k, NULL) - l->m->channel) * width;
        const double sd = ff_result_value(l, r, first + k)->std_error;
        for (size_t j = 0; j < S; j++) {
            const ff_fit_value *v = ff_result_value(l, r, j);
            if (v->column >= 0) row[v->column] = correlation(info, first + k, j, sd, v->std_error);
        }
        for (size_t j = 0; j < K; j++)
            row[r->n_columns + (size_t)(ff_layout_param(l, first + j, NULL) - l->m->channel)] =
                correlation(info, first + k, first + j, sd, ff_result_value(l, r, first + j)->std_error);
    }
}

/* Where the residuals vanish, the digits of the value itself are what is left. */
static void raise_errors(const ff_plan *plan, ff_fit_result *r)
{
    for (size_t k = 0; k < plan->l.P; k++) {
        ff_fit_value *v = ff_result_value(&plan->l, r, k);
        if (v->std_error < DBL_EPSILON * fabs(v->value)) v->std_error = DBL_EPSILON * fabs(v->value);
    }
}

static ff_status make_room(const ff_layout *l, ff_fit_result *r)
{
    const size_t N = l->m->n_channel;
    r->correlation = calloc(r->n_columns * r->n_columns + 1, sizeof *r->correlation);
    if (!r->correlation) return FF_ERR_MEMORY;
    if (!l->arrowhead) return FF_OK;
    r->channel_correlation = malloc((r->n_channels * N * (r->n_columns + N) + 1) * sizeof *r->channel_correlation);
    return r->channel_correlation ? FF_OK : FF_ERR_MEMORY;
}

void ff_result_correlations(const ff_plan *plan, const ff_information *info, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    fill_correlations(l, info, r);
    for (size_t c = 0; c < l->n_channels && l->arrowhead; c++) correlations_of_channel(l, info, c, r);
}

ff_status ff_result_errors(const ff_plan *plan, ff_point *at, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    const ff_information *info = at->information;
    ff_status status = ff_result_weightless(plan, at, r);
    if (!status) standard_errors(plan, info, at->noise, r);
    if (!status) status = make_room(l, r);
    if (!status && at->noise && !(r->noise = ff_noise_found_copy(at->noise))) status = FF_ERR_MEMORY;
    if (status) return status;
    ff_result_correlations(plan, info, r);
    r->effective_samples = info->effective;
    r->correlated_over = info->clusters.run;
    r->correlation_settled = info->clusters.settled;
    status = ff_intervals_fill(plan, at, r);
    if (!status) status = ff_condition_fill(plan, at, r);
    ff_result_forget_weightless(plan, r);
    raise_errors(plan, r);
    ff_result_copy_tied(l, r);
    return status;
}
