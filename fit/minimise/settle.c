/* Channels that are dark beside the others.
 *
 * A minimisation ends when a step would gain less than a given part of the whole objective, which is nearly that of the brightest
 * channels. One whose values are 1e-6 of theirs adds 1e-12 to it: its parameters may be anywhere, on a bound onto which a step of
 * the first iterations has taken them, and nothing that is added up says so. With the shape at rest the channels are problems of
 * their own, each of few unknowns and with its own sum of squares, which the last pass has left; so each is judged by that, and
 * those that have more to gain are moved alone. What this does to the shape is less than the tolerance by which it was found. */
#include "internal_minimise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 8 };

/* Where the channels are, and what a pass has left there. */
typedef struct settling {
    const ff_plan *plan;
    const ff_layout *l;                         /* the plan's */
    ff_point *at;                               /* its parameters are those of the last pass */
    double *lower, *upper, *x, *before, *slope; /* [P] */
    double *cost;                               /* [n_channels] before the step; NAN of those that rest */
    ff_normal normal;
    ff_gram gram;
} settling;

/* How far coordinate k may go to a bound at this distance: half the way where the model is not linear, as in project.c. */
static double reach(const ff_layout *l, size_t k, double distance)
{
    return ff_layout_param(l, k, NULL)->flags & FF_PARAM_LINEAR ? distance : 0.5 * distance;
}

/* What channel c, with the shape at rest, would gain by its step [K]. */
static double channel_gain(const ff_layout *l, const ff_gram *g, const double *x, const double *lower, const double *upper,
                           size_t c, double *step)
{
    const size_t S = g->S, K = g->K, m = S + K;
    const double *G = g->local + c * g->tri;
    double small[(FF_MAX_CHANNEL_PARAMS + 1) * (FF_MAX_CHANNEL_PARAMS + 2) / 2], lo[FF_MAX_CHANNEL_PARAMS] = {0},
                                                                                 hi[FF_MAX_CHANNEL_PARAMS] = {0}, gain = 0;
    for (size_t a = 0; a < K; a++) {
        const size_t k = S + c * K + a;
        for (size_t b = 0; b <= a; b++) small[ff_tri(a, b)] = G[ff_tri(S + a, S + b)];
        small[ff_tri(K, a)] = G[ff_tri(m, S + a)];
        lo[a] = reach(l, k, lower[k] - x[k]);
        hi[a] = reach(l, k, upper[k] - x[k]);
    }
    small[ff_tri(K, K)] = G[ff_tri(m, m)];
    (void)ff_bounded_least_squares(small, K, lo, hi, step);
    for (size_t a = 0; a < K; a++) {
        gain -= 2 * small[ff_tri(K, a)] * step[a];
        for (size_t b = 0; b < K; b++) gain -= step[a] * small[ff_tri(a, b)] * step[b];
    }
    return gain;
}

/* Has channel c more to gain than the tolerance leaves where all are equally bright? */
static int is_open(const ff_layout *l, const ff_gram *g, const double *x, const double *lower, const double *upper, size_t c,
                   double tolerance, double *step)
{
    const size_t m = g->S + g->K;
    return channel_gain(l, g, x, lower, upper, c, step) > tolerance * (double)l->n_channels * g->local[c * g->tri + ff_tri(m, m)];
}

int ff_channels_open(const ff_layout *l, const ff_gram *g, const double *x, const double *lower, const double *upper,
                     double tolerance)
{
    double step[FF_MAX_CHANNEL_PARAMS];
    if (l->n_channels < 2 || l->n_own == 0 || l->pinned != FF_NOT_PINNED) return 0;
    for (size_t c = 0; c < l->n_channels; c++)
        if (is_open(l, g, x, lower, upper, c, tolerance, step)) return 1;
    return 0;
}

/* ---- steps ----------------------------------------------------------------------------------- */

static void settling_free(settling *s)
{
    ff_normal_free(&s->normal);
    ff_gram_free(&s->gram);
    free(s->lower);
}

static ff_status settling_new(const ff_plan *plan, ff_point *at, settling *s)
{
    const size_t P = plan->l.P;
    *s = (settling){.plan = plan, .l = &plan->l, .at = at};
    s->lower = calloc(5 * P + plan->l.n_channels, sizeof *s->lower);
    if (!s->lower || ff_layout_normal(s->l, &s->normal) || ff_gram_new(s->l, &s->gram)) {
        settling_free(s);
        return FF_ERR_MEMORY;
    }
    double **const vectors[] = {&s->upper, &s->x, &s->before, &s->slope, &s->cost};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++) *vectors[k] = s->lower + (k + 1) * P;
    ff_layout_bounds(s->l, s->lower, s->upper);
    ff_layout_pack(s->l, at->shape, at->channel, s->x);
    return FF_OK;
}

static ff_status pass_here(settling *s)
{
    ff_point *at = s->at;
    ff_pass pass;
    if (ff_plan_cancelled(s->plan)) return FF_ERR_CANCELLED;
    ff_layout_unpack(s->l, s->x, at->shape, at->channel);
    ff_status status = ff_plan_pass(s->plan, at->shape, at->channel, &pass);
    if (status) return status;
    at->passes++;
    status = ff_pass_run(&pass, 1, &s->normal);
    ff_pass_free(&pass);
    if (status) return status;
    ff_layout_slope(s->l, at->shape, at->channel, s->slope);
    ff_gram_fill(s->l, &s->normal, s->slope, &s->gram);
    return ff_penalties_add(s->plan, 1, at->shape, at->channel, s->slope, &s->gram);
}

static double cost_of(const settling *s, size_t c)
{
    const size_t m = s->gram.S + s->gram.K;
    return s->gram.local[c * s->gram.tri + ff_tri(m, m)];
}

/* Steps of all channels that have something to gain; how many. A step to a bound ends on it to the last bit. */
static size_t step_channels(settling *s, double tolerance)
{
    const size_t S = s->l->n_shared, K = s->l->n_own;
    size_t open = 0;
    memcpy(s->before, s->x, s->l->P * sizeof *s->x);
    for (size_t c = 0; c < s->l->n_channels; c++) {
        double step[FF_MAX_CHANNEL_PARAMS];
        s->cost[c] = NAN;
        if (!is_open(s->l, &s->gram, s->x, s->lower, s->upper, c, tolerance, step)) continue;
        s->cost[c] = cost_of(s, c);
        open++;
        for (size_t a = 0; a < K; a++) {
            const size_t k = S + c * K + a;
            s->x[k] = step[a] <= s->lower[k] - s->x[k]   ? s->lower[k]
                      : step[a] >= s->upper[k] - s->x[k] ? s->upper[k]
                                                         : s->x[k] + step[a];
        }
    }
    return open;
}

/* Takes back the steps of channels that have risen; how many. */
static size_t take_back(settling *s)
{
    const size_t S = s->l->n_shared, K = s->l->n_own;
    size_t risen = 0;
    for (size_t c = 0; c < s->l->n_channels; c++) {
        if (isnan(s->cost[c]) || cost_of(s, c) <= s->cost[c]) continue;
        memcpy(s->x + S + c * K, s->before + S + c * K, K * sizeof *s->x);
        risen++;
    }
    return risen;
}

ff_status ff_settle_channels(const ff_plan *plan, double tolerance, ff_point *at, ff_error *err)
{
    settling s;
    size_t risen = 0;
    ff_point_forget(at);
    ff_status status = settling_new(plan, at, &s);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "out of memory");
    status = pass_here(&s);
    for (int round = 0; round < ROUNDS && !status && !risen && step_channels(&s, tolerance); round++) {
        at->iterations++;
        status = pass_here(&s);
        if (!status) risen = take_back(&s);
        if (risen && !status) status = pass_here(&s);
    }
    for (size_t k = 0; k < plan->l.P && !status; k++) at->at_bound[k] = ff_bound_of(s.l, &s.gram, s.x, s.lower[k], s.upper[k], k);
    at->cost2 = s.gram.cost2;
    at->open = 0;
    settling_free(&s);
    return ff_solve_failed(status, err);
}
