/* What is said of many channels: their errors from the arrow. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>

/* ---- errors ---------------------------------------------------------------------------------- */

/* cov / (sd sd): a correlation, where both have a standard error. */
static double correlation(double cov, double a, double b)
{
    const double scale = a * b;
    return isnan(scale) ? NAN : scale > 0 ? fmin(fmax(cov / scale, -1), 1) : 0;
}

static void shape_errors(const ff_layout *l, const ff_arrow *a, ff_fit_result *r)
{
    size_t n = 0;
    for (size_t k = 0; k < a->S; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        if (!a->determined[k]) continue;
        v->std_error = sqrt(fmax(a->shape[k * a->S + k], 0));
        v->column = (int)n++;
    }
    r->n_columns = n;
}

static void shape_correlations(const ff_layout *l, const ff_arrow *a, ff_fit_result *r)
{
    for (size_t i = 0; i < a->S; i++)
        for (size_t j = 0; j < a->S; j++) {
            const ff_fit_value *x = ff_result_value(l, r, i), *y = ff_result_value(l, r, j);
            if (x->column < 0 || y->column < 0) continue;
            r->correlation[(size_t)x->column * r->n_columns + (size_t)y->column] =
                i == j ? 1 : correlation(a->shape[i * a->S + j], x->std_error, y->std_error);
        }
}

static void channel_errors(const ff_layout *l, const ff_arrow *a, size_t c, ff_fit_result *r)
{
    const size_t S = a->S, K = a->K, N = l->m->n_channel, width = r->n_columns + N;
    for (size_t k = 0; k < K; k++)
        if (a->determined[S + c * K + k])
            ff_result_value(l, r, S + c * K + k)->std_error = sqrt(fmax(a->block[(c * K + k) * K + k], 0));
    for (size_t k = 0; k < N * width; k++) r->channel_correlation[c * N * width + k] = NAN;
    for (size_t k = 0; k < K; k++) {
        double *row = r->channel_correlation + (c * N + l->free.channel[k]) * width;
        const double sd = ff_result_value(l, r, S + c * K + k)->std_error;
        for (size_t j = 0; j < S; j++) {
            const ff_fit_value *v = ff_result_value(l, r, j);
            if (v->column >= 0) row[v->column] = correlation(a->cross[(c * K + k) * S + j], sd, v->std_error);
        }
        for (size_t j = 0; j < K; j++) {
            const double other = correlation(a->block[(c * K + k) * K + j], sd, ff_result_value(l, r, S + c * K + j)->std_error);
            row[r->n_columns + l->free.channel[j]] = j == k && !isnan(sd) ? 1 : other;
        }
    }
}

ff_status ff_result_channel_errors(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                                   const ff_arrow *a, ff_fit_result *r)
{
    shape_errors(l, a, r);
    r->correlation = calloc(r->n_columns * r->n_columns + 1, sizeof *r->correlation);
    r->channel_correlation =
        malloc((r->n_channels * l->m->n_channel * (r->n_columns + l->m->n_channel) + 1) * sizeof *r->channel_correlation);
    if (!r->correlation || !r->channel_correlation) return FF_ERR_MEMORY;
    shape_correlations(l, a, r);
    for (size_t c = 0; c < a->C; c++) channel_errors(l, a, c, r);
    r->effective_samples = a->effective;
    r->correlated_over = a->clusters.run;
    r->correlation_settled = a->clusters.settled;
    int *use = malloc((l->P + 1) * sizeof *use);
    for (size_t k = 0; k < l->P && use; k++) use[k] = at_bound[k] == 0;
    ff_status st = use ? ff_arrow_intervals(l, p, n, at_bound, a, r) : FF_ERR_MEMORY;
    if (!st) st = ff_arrow_condition(n, a, use, r);
    free(use);
    ff_result_copy_tied(l, r);
    return st;
}
