/* Parameters that have no effect left on their bound.
 *
 * The reflectance of a dielectric is ((eta - 1) / (eta + 1))^2, that of a conductor has k^2 in it: at eta = 1 and k = 0 the
 * gradient is 0 whatever the data say, and a minimisation that a long step or a start has taken there calls it an optimum. A pass a
 * little way inside says whether the objective falls. */
#include "internal_minimise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define INSIDE    0.02 /* of the way from the bound to where the parameter starts by default */
#define NO_EFFECT 1e-12

/* Where the point is, and what a pass has left there. */
typedef struct waking {
    double *x, *lower, *upper, *slope; /* [P] */
    ff_gram gram;
} waking;

static int may_sleep(const ff_layout *l, const waking *w, const ff_point *at, size_t k)
{
    const ff_model_param *p = ff_layout_param(l, k, NULL);
    return at->at_bound[k] && k != l->pinned && w->lower[k] != w->upper[k] && ff_is_of_channel(l->m, p) &&
           !(p->flags & FF_PARAM_LINEAR);
}

/* How far inside coordinate k is looked at. */
static double way_inside(const ff_layout *l, const waking *w, size_t k)
{
    const ff_model_param *p = ff_layout_param(l, k, NULL);
    const double bound = w->x[k], start = ff_coordinate(p->info, p->init), span = w->upper[k] - w->lower[k];
    const double way = INSIDE * (start != bound ? start - bound : bound > w->lower[k] ? -span : span);
    return fmin(fmax(bound + way, w->lower[k]), w->upper[k]) - bound;
}

/* Does coordinate k move the residuals by nothing, were the Jacobian all there is? */
static int has_no_effect(const ff_layout *l, const waking *w, size_t k)
{
    const size_t m = w->gram.S + w->gram.K;
    const double way = way_inside(l, w, k) / INSIDE;
    double effect2 = 0, size2 = 0;
    for (size_t c = 0; c < l->n_channels; c++)
        for (size_t a = 0; a < m; a++) {
            if (ff_gram_coordinate(&w->gram, c, a) != k) continue;
            const double *local = w->gram.local + c * w->gram.tri;
            effect2 += local[ff_tri(a, a)] * way * way;
            size2 += local[ff_tri(m, m)];
        }
    return effect2 <= NO_EFFECT * size2;
}

/* A pass at w->x: the gram there. */
static ff_status look(const ff_plan *plan, ff_point *at, waking *w)
{
    const ff_layout *l = &plan->l;
    ff_pass pass;
    ff_normal normal = {0};
    ff_status status = ff_layout_normal(l, &normal);
    ff_layout_unpack(l, w->x, at->shape, at->channel);
    if (!status) status = ff_plan_pass(plan, at->shape, at->channel, &pass);
    if (!status) {
        at->passes++;
        status = ff_pass_run(&pass, 1, &normal);
        ff_pass_free(&pass);
    }
    if (!status) {
        ff_layout_slope(l, at->shape, at->channel, w->slope);
        ff_gram_fill(l, &normal, w->slope, &w->gram);
        status = ff_penalties_add(plan, 1, at->shape, at->channel, w->slope, &w->gram);
    }
    ff_normal_free(&normal);
    return status;
}

/* From where those without effect are a little way inside, if it is lower there. *better: `inside` ends lower than `at`. */
static ff_status wake(const ff_plan *plan, const ff_effort *effort, const ff_point *at, waking *w, ff_point *inside, int *better,
                      ff_error *err)
{
    const ff_layout *l = &plan->l;
    size_t asleep = 0;
    ff_status status = look(plan, inside, w);
    for (size_t k = 0; k < l->P && !status; k++) {
        if (!may_sleep(l, w, at, k) || !has_no_effect(l, w, k)) continue;
        w->x[k] += way_inside(l, w, k);
        asleep++;
    }
    const double before = at->cost2, least = before * (1 - effort->tolerance);
    if (!status && asleep) status = look(plan, inside, w);
    if (status || !asleep || !(w->gram.cost2 < least)) return status;
    status = ff_solve(plan, effort, inside, err);
    *better = !status && inside->cost2 < least;
    return status;
}

ff_status ff_wake(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err)
{
    const ff_layout *l = &plan->l;
    const size_t P = l->P;
    ff_point inside = {0};
    waking w = {.x = calloc(4 * P + 1, sizeof *w.x)};
    int any = 0, better = 0;
    if (!w.x) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    w.lower = w.x + P, w.upper = w.lower + P, w.slope = w.upper + P;
    ff_layout_bounds(l, w.lower, w.upper);
    ff_layout_pack(l, at->shape, at->channel, w.x);
    for (size_t k = 0; k < P; k++) any |= may_sleep(l, &w, at, k);
    if (!any) {
        free(w.x);
        return FF_OK;
    }
    ff_status status = ff_gram_new(l, &w.gram);
    if (!status) {
        status = ff_point_new(plan, &inside);
        if (!status) ff_point_set(plan, at->shape, at->channel, &inside);
        if (!status) status = wake(plan, effort, at, &w, &inside, &better, err);
        ff_gram_free(&w.gram);
    }
    at->passes += inside.passes;
    if (better) {
        const int passes = at->passes, iterations = at->iterations;
        ff_point last = *at;
        *at = inside;
        at->passes = passes;
        at->iterations += iterations;
        at->noise = last.noise;
        last.noise = NULL;
        inside = last;
    }
    ff_point_free(&inside);
    free(w.x);
    return ff_solve_failed(status == FF_ERR_INTERNAL ? FF_OK : status, err);
}
