/* The way to an optimum that fits a layout; of means over an aperture, with levels that are held while a solver moves. */
#include "internal_minimise.h"
#include "fit/pass/internal_evaluate.h"
#include <stdlib.h>

static ff_status solve_with(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err)
{
    ff_point_forget(at);
    return plan->l.arrowhead ? ff_solve_projected(plan, effort, at, err) : ff_solve_dense(plan, effort, at, err);
}

/* A lobe that has changed by more than this needs nodes elsewhere; by less, the levels of most samples are what they were. */
#define CHANGED 0.1
enum { ROUNDS = 4 };

static int changed(double before, double now)
{
    return fabs(now - before) > CHANGED * fabs(before);
}

/* Has a lobe become wider or narrower, or moved by a part of its width? */
static int lobes_changed(const ff_needles *before, const ff_needles *now)
{
    int any = 0;
    for (uint32_t k = 0; k < now->n; k++) {
        const ff_needle *a = &before->needle[k], *b = &now->needle[k];
        const double x = b->at[0] - a->at[0], y = b->at[1] - a->at[1],
                     moved = a->inverse[0] * x * x + 2 * a->inverse[1] * x * y + a->inverse[2] * y * y;
        any |= moved > CHANGED * CHANGED;
        any |= changed(a->inverse[0], b->inverse[0]) || changed(a->inverse[2], b->inverse[2]) ||
               fabs(b->inverse[1] - a->inverse[1]) > CHANGED * sqrt(a->inverse[0] * a->inverse[2]);
    }
    return any;
}

/* Levels at the point, in place of *levels, where they are not yet held or its lobes are others. changed: whether it was so. */
static ff_status hold_levels(const ff_plan *plan, int parallel, const ff_point *at, ff_levels **levels, int *anew)
{
    ff_pass pass;
    ff_plan chosen = *plan;
    chosen.levels = NULL;
    ff_status status = ff_plan_pass(&chosen, at->shape, at->channel, &pass);
    if (status) return status;
    *anew = !*levels || lobes_changed(&(*levels)->needles, &pass.averaging->needles);
    if (*anew) {
        free(*levels);
        *levels = ff_levels_new(&pass, parallel);
        status = *levels ? FF_OK : FF_ERR_MEMORY;
    }
    ff_pass_free(&pass);
    return status;
}

ff_status ff_solve(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err)
{
    if (!ff_plan_averages(plan)) return solve_with(plan, effort, at, err);
    ff_levels *levels = NULL;
    ff_status status = FF_OK;
    for (int round = 0; round < ROUNDS && !status; round++) {
        int anew = 0;
        ff_plan held = *plan;
        status = hold_levels(plan, effort->parallel, at, &levels, &anew);
        if (status) status = ff_error_set(err, status, NULL, 0, -1, "out of memory");
        if (status || !anew) break;
        held.levels = levels;
        status = solve_with(&held, effort, at, err);
        if (at->outcome != FF_CONVERGED) break;
    }
    free(levels);
    return status;
}
