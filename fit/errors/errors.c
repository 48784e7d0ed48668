/* The stage between minimisation and result: the pass that errors and statistics are made of, in the way of the layout. */
#include "internal_arrow.h"

ff_status ff_errors_pass(const ff_plan *plan, ff_point *at)
{
    if (at->has_final) return FF_OK;
    return plan->l.arrow ? ff_arrow_finish(plan, at) : ff_point_pass(plan, at);
}
