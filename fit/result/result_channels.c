/* What is said of many channels: their errors from the arrow, and warnings that name channels with the same trouble together. */
#include "internal_result.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *ff_channels_label(const struct ff_problem *p, const unsigned char *mark, char *out, size_t size)
{
    size_t n = 0, first = 0, last = 0, used = 0;
    for (size_t c = 0; c < p->n_channels; c++) {
        if (!mark[c]) continue;
        if (n++ == 0) first = c;
        last = c;
    }
    out[0] = '\0';
    if (p->n_channels > FF_CHANNELS_NAMED && n > 3) {
        snprintf(out, size, "%zu of %zu channels, %.32s to %.32s", n, p->n_channels, p->channel_name[first], p->channel_name[last]);
        return out;
    }
    for (size_t c = 0; c < p->n_channels && used < size; c++)
        if (mark[c]) used += (size_t)snprintf(out + used, size - used, "%s%.32s", used ? ", " : "", p->channel_name[c]);
    return out;
}

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

/* ---- warnings -------------------------------------------------------------------------------- */

void ff_result_warn_undetermined(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    char names[120];
    unsigned char *mark = malloc(r->n_channels + 1);
    for (uint32_t k = 0; k < l->free.n_channel && mark; k++) {
        int any = 0;
        for (size_t c = 0; c < r->n_channels; c++) {
            const ff_fit_value *v = ff_result_value(l, r, l->free.n_shape + c * l->free.n_channel + k);
            mark[c] = !v->at_bound && !v->held && isnan(v->std_error);
            any |= mark[c];
        }
        if (any)
            ff_result_warn(r, "%s (%s) is not determined by these data", l->m->channel[l->free.channel[k]].name,
                           ff_channels_label(p, mark, names, sizeof names));
    }
    free(mark);
}

/* Channels in which a parameter and `other`, a column of the shape or (from n_columns on) a parameter of the channel, cannot be
 * told apart. */
static void warn_pair(const ff_layout *l, const struct ff_problem *p, uint32_t k, size_t other, const char *name,
                      unsigned char *mark, ff_fit_result *r)
{
    const size_t N = l->m->n_channel, width = r->n_columns + N;
    double most = 0;
    char names[120];
    for (size_t c = 0; c < r->n_channels; c++) {
        const double v = r->channel_correlation[(c * N + k) * width + other];
        mark[c] = fabs(v) >= 0.99;
        if (mark[c] && fabs(v) > fabs(most)) most = v;
    }
    if (most != 0)
        ff_result_warn(r, "%s and %s (%s) are correlated by up to %.4f: these data hardly tell them apart", name,
                       l->m->channel[k].name, ff_channels_label(p, mark, names, sizeof names), most);
}

void ff_result_warn_channels_correlated(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    unsigned char *mark = malloc(r->n_channels + 1);
    for (uint32_t i = 0; i < l->free.n_shape && mark; i++) {
        const ff_fit_value *x = ff_result_value(l, r, i);
        for (uint32_t j = 0; j < i; j++) {
            const ff_fit_value *y = ff_result_value(l, r, j);
            if (x->column < 0 || y->column < 0) continue;
            const double c = r->correlation[(size_t)x->column * r->n_columns + (size_t)y->column];
            if (fabs(c) >= 0.99)
                ff_result_warn(r, "%s and %s are correlated by %.4f: these data hardly tell them apart",
                               ff_layout_param(l, j, NULL)->name, ff_layout_param(l, i, NULL)->name, c);
        }
    }
    for (uint32_t k = 0; k < l->free.n_channel && mark; k++) {
        const uint32_t at = l->free.channel[k];
        for (uint32_t j = 0; j < l->free.n_shape; j++) {
            const ff_fit_value *v = ff_result_value(l, r, j);
            if (v->column >= 0) warn_pair(l, p, at, (size_t)v->column, ff_layout_param(l, j, NULL)->name, mark, r);
        }
        for (uint32_t j = 0; j < k; j++) {
            const uint32_t with = l->free.channel[j];
            warn_pair(l, p, at, r->n_columns + with, l->m->channel[with].name, mark, r);
        }
    }
    free(mark);
}
