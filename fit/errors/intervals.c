/* What the Jacobian at the optimum says of each parameter: its 95 % interval, and how well the parameters can be told from each
 * other. */
#include "base/internal_statistics.h"
#include "internal_errors.h"
#include <math.h>
#include <stdlib.h>

static double clamp(const ff_param *info, double v)
{
    return fmin(fmax(v, info->lo), info->hi);
}

/* Symmetric in the coordinate that the parameter is fitted in: a roughness by a factor, F0 by a difference. */
void ff_interval_around(const ff_param *info, double half_width, ff_interval kind, ff_fit_value *v)
{
    const double x = ff_coordinate(info, v->value), dx = half_width / ff_coordinate_slope(info, v->value);
    v->interval = kind;
    v->low = ff_coordinate_value(info, x - dx);
    v->high = ff_coordinate_value(info, x + dx);
}

void ff_interval_from_bound(const ff_param *info, double slope, double inverse, double allowed, ff_fit_value *v)
{
    const double inside = v->at_bound < 0 ? 1 : -1, down = fmax(slope * inside, 0), h = inverse > 0 ? 1 / inverse : 0;
    double d = INFINITY;
    if (h > 0) d = (sqrt(down * down + 2 * h * allowed) - down) / h;
    if (!(h > 0) && down > 0) d = allowed / down;
    const double end = clamp(info, v->value + inside * d);
    v->interval = FF_INTERVAL_ONE_SIDED;
    v->low = fmin(v->value, end);
    v->high = fmax(v->value, end);
}

/* The gradient [P] of the objective by the parameters, penalties and all. ones [P]: room to work in. */
static ff_status fill_gradient(const ff_plan *plan, const ff_point *at, double *gradient, double *ones)
{
    ff_gram g;
    ff_status st = ff_gram_new(&plan->l, &g);
    if (st) return st;
    ff_gram_fill(&plan->l, &at->normal, NULL, &g);
    for (size_t k = 0; k < plan->l.P; k++) ones[k] = 1;
    st = ff_penalties_add(plan, 1, at->shape, at->channel, ones, &g);
    ff_gram_gradient(&g, gradient);
    ff_gram_free(&g);
    return st;
}

/* How steeply the objective rises with parameter k, those that are not on a bound following. What a minimisation leaves of their
 * own gradients is small against them and not against that of a parameter with little effect. work [2 P]. */
static ff_status slope_of(const ff_layout *l, const ff_point *at, const ff_information *info, const double *gradient, size_t k,
                          double *work, double *slope)
{
    double *step = work + l->P;
    for (size_t i = 0; i < l->P; i++) work[i] = at->at_bound[i] && i != k ? 0 : gradient[i];
    const ff_status st = ff_information_solve(info, work, step);
    *slope = st ? NAN : step[k] / info->inverse[k];
    return st;
}

/* Parameters on a bound: the objective rises from there by its slope and, all others following, its curvature. */
static ff_status fill_one_sided(const ff_plan *plan, ff_point *at, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    ff_information *info = NULL;
    double *gradient = malloc((3 * l->P + 1) * sizeof *gradient), *work = gradient + l->P;
    ff_status st = gradient ? ff_errors_of_all(plan, at, &info) : FF_ERR_MEMORY;
    if (!st) st = fill_gradient(plan, at, gradient, work);
    for (size_t k = 0; k < l->P && !st; k++) {
        if (!at->at_bound[k] || ff_layout_is_fixed(l, k)) continue;
        const double t = ff_student_quantile(0.9, info->dof[k]), inverse = info->inverse[k];
        const int known = info->determined[k] && inverse > 0;
        double slope = gradient[k];
        if (known) st = slope_of(l, at, info, gradient, k, work, &slope);
        if (!st)
            ff_interval_from_bound(ff_layout_param(l, k, NULL)->info, slope, known ? inverse : 0,
                                   0.5 * t * t * (known ? info->variance[k] / inverse : INFINITY), ff_result_value(l, r, k));
    }
    free(info);
    free(gradient);
    return st;
}

ff_status ff_intervals_fill(const ff_plan *plan, ff_point *at, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    int any = 0;
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        any |= at->at_bound[k] && !ff_layout_is_fixed(l, k);
        if (isnan(v->std_error)) continue;
        ff_interval_around(ff_layout_param(l, k, NULL)->info, ff_student_quantile(0.95, at->information->dof[k]) * v->std_error,
                           FF_INTERVAL_WALD, v);
    }
    return any ? fill_one_sided(plan, at, r) : FF_OK;
}

/* ---- what can be told apart ------------------------------------------------------------------ */

/* A direction in which the objective is this much flatter than along the parameters themselves is worth a word. */
#define FF_FLAT 1e-4
/* And in one that is flatter than this nothing is determined. */
#define FF_NOTHING 1e-12
/* Share that a parameter has in it at least to be named. */
#define FF_SHARE 0.25

/* The parameters that have a share in the flattest direction trade off. */
static ff_status warn_of_flat_direction(const ff_layout *l, const double *share, double value, ff_fit_result *r)
{
    const int nothing = value <= FF_NOTHING;
    ff_warning_parameter *named = malloc((l->P + 1) * sizeof *named);
    ff_warning w = {.code = nothing ? FF_WARNING_COMBINATION_NOT_DETERMINED : FF_WARNING_TRADE_OFF,
                    .parameter = named,
                    .value = {nothing ? 0 : 1 / sqrt(value)}};
    for (size_t k = 0; k < l->P && named; k++)
        if (fabs(share[k]) >= FF_SHARE) named[w.n_parameters++] = ff_layout_warned(l, k);
    ff_status s = named ? FF_OK : FF_ERR_MEMORY;
    if (!s && w.n_parameters > (nothing ? 1 : 2)) s = ff_warnings_add(&r->warnings, &w); /* pairs are warned of as correlated */
    free(named);
    return s;
}

ff_status ff_condition_fill(const ff_plan *plan, const ff_point *at, ff_fit_result *r)
{
    double *share = malloc((plan->l.P + 1) * sizeof *share), curvature = 1;
    ff_status st = share ? ff_information_condition(plan, at, &r->rank, &r->condition) : FF_ERR_MEMORY;
    if (!st && r->condition > 1 / sqrt(FF_FLAT)) st = ff_information_flattest(plan, at, &curvature, share);
    if (!st && curvature < FF_FLAT) st = warn_of_flat_direction(&plan->l, share, curvature, r);
    free(share);
    return st;
}
