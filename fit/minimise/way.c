/* The way to an optimum that fits a layout. */
#include "internal_minimise.h"

ff_status ff_solve(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err)
{
    ff_point_forget(at);
    return plan->l.arrowhead ? ff_solve_projected(plan, effort, at, err) : ff_solve_dense(plan, effort, at, err);
}
