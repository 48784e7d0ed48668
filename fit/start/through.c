/* Starts of fits to means over an aperture: a lobe looks at least as wide as that, whatever it is. */
#include "fit/minimise/internal_minimise.h"
#include "internal_start.h"
#include <math.h>
#include <string.h>

#define NARROW  0.25 /* an aperture of less than this part of a lobe hardly widens it */
#define ROUGHLY 1e-4
enum { STEPS = 25 };

#define WIDER 0.7 /* and a lobe that looks as wide as this is not much narrower */

static const double factors[] = {1, 0.6, 0.25, 0.08};

/* The radius of the aperture, as a normal has to lean for it, in widths of the narrowest lobe. */
static ff_status widths(const ff_plan *plan, const ff_point *at, double *out)
{
    ff_pass pass;
    *out = 0;
    const ff_status status = ff_plan_pass(plan, at->shape, at->channel, &pass);
    if (status) return status;
    const ff_needles *needles = &pass.averaging->needles;
    for (uint32_t k = 0; k < needles->n; k++)
        for (int axis = 0; axis < 2; axis++)
            *out = fmax(*out, 0.5 * plan->p->rules->reach / ff_needle_width(&needles->needle[k], 1.5707963267948966 * axis));
    ff_pass_free(&pass);
    return FF_OK;
}

/* Free roughnesses times a factor, as far as their bounds go. */
static void narrow(const ff_plan *plan, double factor, double *shape)
{
    const ff_layout *l = &plan->l;
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const uint32_t i = l->free.shape[k];
        const ff_model_param *p = &l->m->shape[i];
        if (strncmp(p->info->name, "alpha", 5) == 0) shape[i] = fmin(fmax(shape[i] * factor, p->lo), p->hi);
    }
    ff_layout_candidate(l, shape);
}

ff_status ff_start_through(const ff_plan *plan, ff_point *at, ff_error *err)
{
    double ratio = 0;
    if (!ff_plan_averages(plan)) return FF_OK;
    const ff_plan subsample = ff_plan_on(plan, plan->p->subsample);
    const ff_effort effort = {.tolerance = ROUGHLY, .max_iterations = STEPS};
    ff_point trial = {.channel = NULL}, best = {.channel = NULL};
    ff_status status = widths(&subsample, at, &ratio);
    const size_t n = ratio > WIDER ? sizeof factors / sizeof *factors : ratio > NARROW ? 2 : 1;
    if (!status) status = ff_point_new(plan, &trial);
    if (!status) status = ff_point_new(plan, &best);
    best.cost2 = INFINITY;
    for (size_t k = 0; k < n && !status; k++) {
        ff_point_set(plan, at->shape, at->channel, &trial);
        narrow(plan, factors[k], trial.shape);
        status = ff_solve(&subsample, &effort, &trial, err);
        if (status == FF_ERR_CANCELLED || status == FF_ERR_MEMORY) break;
        if (!status && trial.cost2 < best.cost2) {
            ff_point_set(plan, trial.shape, trial.channel, &best);
            best.cost2 = trial.cost2;
        }
        status = FF_OK; /* another may lead somewhere */
    }
    if (!status && best.cost2 < INFINITY) {
        ff_point_set(plan, best.shape, best.channel, at);
        at->cost2 = best.cost2;
    }
    ff_point_free(&trial);
    ff_point_free(&best);
    return status;
}
