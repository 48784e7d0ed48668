/* Parameters on a bound: one-sided intervals, and what they go with. */
#include "base/internal_statistics.h"
#include "internal_errors.h"
#include <math.h>
#include <stdlib.h>

static double clamp(const ff_param *info, double v)
{
    return fmin(fmax(v, info->lo), info->hi);
}

int ff_interval_from_bound(const ff_param *info, double slope, double inverse, double allowed, ff_fit_value *v)
{
    const double inside = v->at_bound < 0 ? 1 : -1, down = fmax(slope * inside, 0), h = inverse > 0 ? 1 / inverse : 0;
    double d = INFINITY;
    if (h > 0) d = (sqrt(down * down + 2 * h * allowed) - down) / h;
    if (!(h > 0) && down > 0) d = allowed / down;
    const double end = clamp(info, v->value + inside * d);
    v->interval = FF_INTERVAL_ONE_SIDED;
    v->low = fmin(v->value, end);
    v->high = fmax(v->value, end);
    return !(down * d >= 0.5 * allowed) || allowed == INFINITY;
}

/* The gradient [P] of the objective by the parameters, penalties and all. ones [P]: room to work in. */
static ff_status fill_gradient(const ff_plan *plan, const ff_point *at, double *gradient, double *ones)
{
    ff_gram g;
    ff_status status = ff_gram_new(&plan->l, &g);
    if (status) return status;
    ff_gram_fill(&plan->l, &at->normal, NULL, &g);
    for (size_t k = 0; k < plan->l.P; k++) ones[k] = 1;
    status = ff_penalties_add(plan, 1, at->shape, at->channel, ones, &g);
    ff_gram_gradient(&g, gradient);
    ff_gram_free(&g);
    return status;
}

/* How steeply the objective rises with parameter k, those that are not on a bound following. What a minimisation leaves of their
 * own gradients is small against them and not against that of a parameter with little effect. work [2 P]. */
static ff_status slope_of(const ff_layout *l, const ff_point *at, const ff_information *info, const double *gradient, size_t k,
                          double *work, double *slope)
{
    double *step = work + l->P;
    for (size_t i = 0; i < l->P; i++) work[i] = at->at_bound[i] && i != k ? 0 : gradient[i];
    const ff_status status = ff_information_solve(info, work, step);
    *slope = status ? NAN : step[k] / info->inverse[k];
    return status;
}

/* Do the data tell coordinate k, which lies on its bound without pressing against it, from coordinate j? *correlation: with all
 * others following. */
static int goes_with(const ff_information *info, const int *leans, size_t k, size_t j, double *correlation)
{
    if (!leans[k] || !(info->inverse[k] > 0) || !(info->inverse[j] > 0) || (j < k && leans[j])) return 0;
    *correlation = ff_information_inverse(info, k, j) / sqrt(info->inverse[k] * info->inverse[j]);
    return fabs(*correlation) >= FF_CORRELATED;
}

/* The coordinate of kind i, shared or a channel's own, in channel c. */
static size_t coordinate(const ff_layout *l, size_t i, size_t c)
{
    return i < l->n_shared ? i : i + c * l->n_own;
}

static ff_status warn_of_pair(const ff_layout *l, size_t a, size_t b, const size_t *channel, size_t n, double most,
                              ff_fit_result *r)
{
    const int many = n > 1;
    ff_warning_parameter pair[] = {ff_layout_warned(l, coordinate(l, a, channel[0])),
                                   ff_layout_warned(l, coordinate(l, b, channel[0]))};
    for (int i = 0; i < 2 && many; i++) pair[i].channel = FF_NO_CHANNEL;
    return ff_warnings_add(&r->warnings, &(ff_warning){.code = FF_WARNING_CORRELATED,
                                                       .n_parameters = 2,
                                                       .parameter = pair,
                                                       .n_channels = many ? n : 0,
                                                       .channel = many ? channel : NULL,
                                                       .value = {most}});
}

/* The error of a parameter says nothing of one that rests on its bound and could as well be elsewhere: those that it goes with are
 * named, of many channels together. */
static ff_status warn_of_pairs(const ff_layout *l, const ff_information *info, const int *leans, ff_fit_result *r)
{
    const size_t kinds = l->n_shared + l->n_own;
    size_t *channel = malloc((l->n_channels + 1) * sizeof *channel);
    ff_status status = channel ? FF_OK : FF_ERR_MEMORY;
    for (size_t a = 0; a < kinds; a++)
        for (size_t b = 0; b < kinds && !status; b++) {
            const int apart = a < l->n_shared && b<l->n_shared, together = l->n_channels> FF_CHANNELS_NAMED;
            double most = 0, one;
            size_t n = 0;
            for (size_t c = 0; c < (apart ? 1 : l->n_channels) && a != b && !status; c++) {
                if (!goes_with(info, leans, coordinate(l, a, c), coordinate(l, b, c), &one)) continue;
                channel[n++] = c;
                if (fabs(one) > fabs(most)) most = one;
                if (together && !apart) continue;
                status = warn_of_pair(l, a, b, channel, n, most, r);
                n = 0, most = 0;
            }
            if (n && !status) status = warn_of_pair(l, a, b, channel, n, most, r);
        }
    free(channel);
    return status;
}

/* Parameters on a bound: the objective rises from there by its slope and, all others following, its curvature. */
ff_status ff_intervals_one_sided(const ff_plan *plan, ff_point *at, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    ff_information *info = NULL;
    double *gradient = malloc((3 * l->P + 1) * sizeof *gradient), *work = gradient + l->P;
    int *leans = calloc(l->P + 1, sizeof *leans);
    ff_status status = gradient && leans ? ff_errors_of_all(plan, at, &info) : FF_ERR_MEMORY;
    if (!status) status = fill_gradient(plan, at, gradient, work);
    for (size_t k = 0; k < l->P && !status; k++) {
        if (!at->at_bound[k] || ff_layout_is_fixed(l, k)) continue;
        const double t = ff_student_quantile(0.9, info->dof[k]), inverse = info->inverse[k];
        const int known = info->determined[k] && inverse > 0;
        double slope = gradient[k];
        if (known) status = slope_of(l, at, info, gradient, k, work, &slope);
        if (!status)
            leans[k] =
                ff_interval_from_bound(ff_layout_param(l, k, NULL)->info, slope, known ? inverse : 0,
                                       0.5 * t * t * (known ? info->variance[k] / inverse : INFINITY), ff_result_value(l, r, k));
    }
    if (!status) status = warn_of_pairs(l, info, leans, r);
    free(leans);
    free(info);
    free(gradient);
    return status;
}
