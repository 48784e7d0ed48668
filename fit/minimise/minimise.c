/* The minimisation of a fit: lobes of one kind in their order, what has no effect on its bound, what is dark beside the rest. */
#include "internal_minimise.h"

/* How far all samples are minimised. */
#define FF_EXACT 1e-11

/* Should the lobes have changed places on the way, once more from there, which takes a pass; and what is dark beside the rest. */
ff_status ff_minimise(const ff_plan *plan, ff_point *at, ff_error *err)
{
    ff_effort effort = {.parallel = 1, .speculate = 1, .tolerance = FF_EXACT, .max_iterations = plan->max_iterations};
    (void)ff_plan_order(plan, at->shape, at->channel);
    ff_status status = ff_solve(plan, &effort, at, err);
    if (status) return status;
    if (ff_plan_order(plan, at->shape, at->channel)) {
        effort.speculate = 0;
        status = ff_solve(plan, &effort, at, err);
    }
    if (!status && at->outcome == FF_CONVERGED) status = ff_wake(plan, &effort, at, err);
    if (status || !at->open || at->outcome != FF_CONVERGED) return status;
    return ff_settle_channels(plan, effort.tolerance, at, err);
}
