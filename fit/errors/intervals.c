/* What the Jacobian at the optimum says of each parameter: its 95 % interval, and how well the parameters can be told from each
 * other. */
#include "base/internal_statistics.h"
#include "internal_errors.h"
#include <math.h>
#include <stdlib.h>

/* Symmetric in the coordinate that the parameter is fitted in: a roughness by a factor, F0 by a difference. */
void ff_interval_around(const ff_param *info, double half_width, ff_interval kind, ff_fit_value *v)
{
    const double x = ff_coordinate(info, v->value), dx = half_width / ff_coordinate_slope(info, v->value);
    v->interval = kind;
    v->student_t = half_width / v->std_error;
    v->low = ff_coordinate_value(info, x - dx);
    v->high = ff_coordinate_value(info, x + dx);
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
    return any ? ff_intervals_one_sided(plan, at, r) : FF_OK;
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
    ff_status status = named ? FF_OK : FF_ERR_MEMORY;
    if (!status && w.n_parameters > (nothing ? 1 : 2))
        status = ff_warnings_add(&r->warnings, &w); /* pairs are warned of as correlated */
    free(named);
    return status;
}

ff_status ff_condition_fill(const ff_plan *plan, const ff_point *at, ff_fit_result *r)
{
    double *share = malloc((plan->l.P + 1) * sizeof *share), curvature = 1;
    ff_status status = share ? ff_information_condition(plan, at, &r->rank, &r->condition) : FF_ERR_MEMORY;
    if (!status && r->condition > 1 / sqrt(FF_FLAT)) status = ff_information_flattest(plan, at, &curvature, share);
    if (!status && curvature < FF_FLAT) status = warn_of_flat_direction(&plan->l, share, curvature, r);
    free(share);
    return status;
}
