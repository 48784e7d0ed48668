/* One minimisation of a fit with many channels: the solver moves the shape, the channels follow.
 *
 * A parameter of one channel meets the shape and its own channel, no other one, so that J^T J is an arrowhead: a block for the
 * shape, one for each channel, and what joins the two. At a point of which a pass has left the channels' grams, the step of every
 * channel for a given step of the shape is a bounded least-squares problem of its own, and what is left for the shape is the Schur
 * complement: the Gauss-Newton matrix of the variable projection of Golub and Pereyra (1973) in Kaufman's form (1975). The
 * solver sees [R; 0] of it, as many columns as the shape has coordinates, at a cost that is linear in the number of channels.
 *
 * The channels are not solved anew at each shape, which would take further passes: a trial goes to the shape that the solver asks
 * for and to the channels that the grams of the last accepted point foretell for it. That is the Gauss-Newton step of the whole
 * problem, found by eliminating the blocks, and it converges as fast as projecting does (Ruhe and Wedin 1980); one pass is one
 * step, and nothing in it needs the model to be linear in its channel parameters or the loss to be straight. Where the two are, the
 * foretold channels are exact for a shape at rest. Where not, their steps are damped after a trial that failed, as the solver damps
 * the shape's, by a multiple of the diagonal and of the channel's |r|^2 (coordinates are of the order of 1, so that this bounds the
 * step), and the complement is that of the damped blocks. Convergence is always judged without damping.
 *
 * Parameters of a channel that its step leaves on a bound are no part of the elimination. A coordinate of the shape that presses
 * against its bound is held there, and let go when the gradient pulls it inside; a step of the solver that leaves the box ends on
 * its wall, which saves the line searches that bounds would cost. Converged is the same as in solve.c: the Newton decrement, here
 * the sum of what the channels gain by themselves and what the shape gains with the channels following. */
#include "fit/losses/internal_loss.h"
#include "internal_minimise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct solver {
    const ff_plan *plan;
    const ff_layout *l; /* the plan's                                                     */
    const ff_effort *effort;
    ff_point *at; /* its parameters are those of the last pass                      */
    int passes, iterations;
    size_t S, K; /* coordinates that all channels share, the shape; of a channel   */
    double *lower, *upper, *slope;
    /* The last pass: where it was made [P], and what it left, also in coordinates. have_last: it has not failed. */
    double *x;
    ff_normal normal;
    ff_gram gram;
    int have_last;
    /* The base, the point that steps are taken from: what its pass left, and what is left of J^T J and J^T r for the shape. */
    double *base;
    ff_normal at_base;
    ff_gram base_gram;
    double H[FF_MAX_SHARED * FF_MAX_SHARED], g[FF_MAX_SHARED];
    double gain;      /* of the channels with the shape at rest                         */
    double explained; /* of the moving shape with the channels following                */
    double work[2 * FF_MAX_SHARED * FF_MAX_SHARED + FF_MAX_SHARED];
    size_t moving[FF_MAX_SHARED], n_moving;
    double damping;   /* of the channels' steps; 0 where exact                          */
    double moved;     /* length of the last step, relative to that of the point         */
    int exact;        /* 1: the objective of the channels with the shape at rest is quadratic, or below its quadratic model */
    int at_wall;      /* 1: the solver has accepted a step that leaves the box          */
    ff_status status; /* of a pass that failed                                          */
} solver;

/* ---- passes ---------------------------------------------------------------------------------- */

static ff_status pass_here(solver *s)
{
    const ff_layout *l = s->l;
    ff_pass pass;
    if (ff_plan_cancelled(s->plan)) return FF_ERR_CANCELLED;
    ff_layout_unpack(l, s->x, s->at->shape, s->at->channel);
    ff_status status = ff_plan_pass(s->plan, s->at->shape, s->at->channel, &pass);
    if (status) return status;
    s->passes++;
    s->have_last = 0;
    status = ff_pass_run(&pass, s->effort->parallel, &s->normal);
    ff_pass_free(&pass);
    if (status) return status;
    ff_layout_slope(l, s->at->shape, s->at->channel, s->slope);
    ff_gram_fill(l, &s->normal, s->slope, &s->gram);
    status = ff_penalties_add(s->plan, s->effort->parallel, s->at->shape, s->at->channel, s->slope, &s->gram);
    s->have_last = !status;
    return status;
}

/* ---- one channel ----------------------------------------------------------------------------- */

/* How far the step of coordinate k may go towards a bound at this distance. Where the model is not linear in it, half the way: on a
 * bound it may have no effect left (k = 0 of a conductor), and then nothing would bring it back. */
static double reach(const solver *s, size_t k, double distance)
{
    const int linear = (ff_layout_param(s->l, k, NULL)->flags & FF_PARAM_LINEAR) != 0;
    return linear || fabs(distance) < 1e-6 * (s->upper[k] - s->lower[k]) ? distance : 0.5 * distance;
}

/* What the damping multiplies for coordinate a of a channel with gram G: its curvature and, where that may vanish at a bound, that
 * of a coordinate of which 1 is as much as the residuals. Linear ones have the units of the data, so that 1 says nothing of them,
 * and a curvature that stays. */
static double stiffness(const solver *s, const double *G, size_t a)
{
    const size_t at = s->S + a, m = s->S + s->K;
    const int linear = (ff_layout_param(s->l, at, NULL)->flags & FF_PARAM_LINEAR) != 0;
    return G[ff_tri(at, at)] + (linear ? 0 : G[ff_tri(m, m)]);
}

/* The step of channel c's coordinates for a step ds [S] of the shape: within bounds, damped. limited [K]: 1 where it goes as far as
 * it may. Returns what the channel gains by it from the point where the shape has moved and the channel has not. */
static double channel_step(const solver *s, size_t c, const double *ds, double damping, double *step, int *limited)
{
    const size_t S = s->S, K = s->K, m = S + K;
    const double *G = s->base_gram.local + c * s->base_gram.tri;
    double small[(FF_MAX_CHANNEL_PARAMS + 1) * (FF_MAX_CHANNEL_PARAMS + 2) / 2], lo[FF_MAX_CHANNEL_PARAMS] = {0},
                                                                                 hi[FF_MAX_CHANNEL_PARAMS] = {0};
    for (size_t a = 0; a < K; a++) {
        double slope = G[ff_tri(m, S + a)];
        for (size_t k = 0; k < S; k++) slope += G[ff_tri(S + a, k)] * ds[k];
        for (size_t b = 0; b <= a; b++) small[ff_tri(a, b)] = G[ff_tri(S + a, S + b)];
        const size_t k = S + c * K + a;
        small[ff_tri(a, a)] += damping * stiffness(s, G, a);
        small[ff_tri(K, a)] = slope;
        lo[a] = reach(s, k, s->lower[k] - s->base[k]);
        hi[a] = reach(s, k, s->upper[k] - s->base[k]);
    }
    double rest = G[ff_tri(m, m)];
    for (size_t k = 0; k < S; k++) {
        rest += 2 * G[ff_tri(m, k)] * ds[k];
        for (size_t j = 0; j < S; j++) rest += ds[k] * G[ff_tri(k, j)] * ds[j];
    }
    small[ff_tri(K, K)] = fmax(rest, 0);
    (void)ff_bounded_least_squares(small, K, lo, hi, step);
    double gain = 0; /* summed as such: a difference of two sums of squares would lose it near the optimum */
    for (size_t a = 0; a < K; a++) {
        limited[a] = step[a] <= lo[a] || step[a] >= hi[a];
        gain -= 2 * small[ff_tri(K, a)] * step[a];
        for (size_t b = 0; b < K; b++) gain -= step[a] * small[ff_tri(a, b)] * step[b];
    }
    return gain;
}

/* Where a step leaves coordinate k; on a bound to the last bit. */
static double stepped(const solver *s, size_t k, double step)
{
    if (step <= s->lower[k] - s->base[k]) return s->lower[k];
    return step >= s->upper[k] - s->base[k] ? s->upper[k] : s->base[k] + step;
}

/* ---- the base -------------------------------------------------------------------------------- */

/* Adds channel c to the reduced H and g: its part of the shape's, less what its own free coordinates take up. */
static void eliminate(solver *s, size_t c, double damping)
{
    const size_t S = s->S, K = s->K, m = S + K;
    const double *G = s->base_gram.local + c * s->base_gram.tri;
    static const double at_rest[FF_MAX_SHARED];
    double step[FF_MAX_CHANNEL_PARAMS], A[FF_MAX_CHANNEL_PARAMS * FF_MAX_CHANNEL_PARAMS], B[FF_MAX_CHANNEL_PARAMS * FF_MAX_SHARED],
        X[FF_MAX_CHANNEL_PARAMS * FF_MAX_SHARED];
    size_t in[FF_MAX_CHANNEL_PARAMS], n = 0;
    int limited[FF_MAX_CHANNEL_PARAMS];
    s->gain += channel_step(s, c, at_rest, damping, step, limited);
    for (size_t a = 0; a < K; a++)
        if (!limited[a]) in[n++] = S + a;
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) A[i * n + j] = G[ff_tri(in[i], in[j])];
        A[i * n + i] += damping * stiffness(s, G, in[i] - S);
        for (size_t k = 0; k < S; k++) B[i * S + k] = G[ff_tri(in[i], k)];
    }
    ff_solve_symmetric(A, n, B, S, X);
    for (size_t k = 0; k < S; k++) {
        s->g[k] += G[ff_tri(m, k)];
        for (size_t a = 0; a < K; a++) s->g[k] += G[ff_tri(S + a, k)] * step[a];
        for (size_t j = 0; j < S; j++) {
            s->H[k * S + j] += G[ff_tri(k, j)];
            for (size_t i = 0; i < n; i++) s->H[k * S + j] -= B[i * S + k] * X[i * S + j];
        }
    }
}

/* What the channels leave of J^T J and J^T r for the shape, and what they gain. */
static void reduce(solver *s, double damping)
{
    memset(s->H, 0, s->S * s->S * sizeof *s->H);
    memset(s->g, 0, s->S * sizeof *s->g);
    s->gain = 0;
    for (size_t c = 0; c < s->l->n_channels; c++) eliminate(s, c, damping);
}

/* What there is to gain at the base, and the reduced H and g that the next steps are to have. */
static void look_around(solver *s)
{
    double residual[FF_MAX_SHARED + 1];
    reduce(s, 0);
    s->explained = ff_compress(s->H, s->g, s->S, s->moving, s->n_moving, s->base_gram.cost2, s->work, residual, NULL);
    if (s->damping > 0) {
        const double gain = s->gain;
        reduce(s, s->damping);
        s->gain = gain;
    }
}

/* The last pass becomes what steps are taken from. */
static void make_base(solver *s)
{
    const ff_normal normal = s->at_base;
    const ff_gram gram = s->base_gram;
    s->at_base = s->normal;
    s->base_gram = s->gram;
    s->normal = normal; /* its memory serves the next pass */
    s->gram = gram;
    s->have_last = 0;
    memcpy(s->base, s->x, s->l->P * sizeof *s->x);
    look_around(s);
}

/* Length of the step from the base to x relative to that of the base, each coordinate by what it does to the residuals: they have
 * no unit in common. */
static double relative_step(const solver *s)
{
    const size_t S = s->S, K = s->K;
    double step2 = 0, at2 = 0;
    for (size_t c = 0; c < s->l->n_channels; c++)
        for (size_t a = 0; a < S + K; a++) {
            const size_t k = a < S ? a : a + c * K;
            const double weight = s->base_gram.local[c * s->base_gram.tri + ff_tri(a, a)], step = s->x[k] - s->base[k];
            step2 += weight * step * step;
            at2 += weight * s->base[k] * s->base[k];
        }
    return at2 > 0 ? sqrt(step2 / at2) : INFINITY;
}

/* A pass at the shape coordinates t [S], with the channels that the base foretells for them. */
static ff_status try_shape(solver *s, const double *t)
{
    const size_t S = s->S, K = s->K;
    double ds[FF_MAX_SHARED], step[FF_MAX_CHANNEL_PARAMS];
    int limited[FF_MAX_CHANNEL_PARAMS];
    for (size_t k = 0; k < S; k++) {
        ds[k] = t[k] - s->base[k];
        s->x[k] = t[k];
    }
    for (size_t c = 0; c < s->l->n_channels; c++) {
        channel_step(s, c, ds, s->damping, step, limited);
        for (size_t a = 0; a < K; a++) s->x[S + c * K + a] = stepped(s, S + c * K + a, step[a]);
    }
    s->moved = relative_step(s);
    const ff_status status = pass_here(s);
    if (s->exact) return status;
    if (status || s->gram.cost2 > s->base_gram.cost2)
        s->damping = fmax(4 * s->damping, 1e-3);
    else
        s->damping = s->damping > 1e-4 ? s->damping / 3 : 0;
    return status;
}

/* ---- what the solver sees -------------------------------------------------------------------- */

/* Outside the box the objective is that of the nearest point inside: where a step that leaves it is worth taking, the solve ends
 * there, to go on with what presses against a bound held. */
static ff_status evaluate(void *context, const double *x, double *residual, double *jacobian)
{
    solver *s = context;
    double t[FF_MAX_SHARED];
    int outside = 0;
    memcpy(t, s->base, s->S * sizeof *t);
    for (size_t i = 0; i < s->n_moving; i++) {
        const size_t k = s->moving[i];
        t[k] = fmin(fmax(x[i], s->lower[k]), s->upper[k]);
        outside |= t[k] != x[i];
    }
    const int at_base = memcmp(t, s->base, s->S * sizeof *t) == 0;
    if (!at_base && (!s->have_last || memcmp(t, s->x, s->S * sizeof *t) != 0)) {
        const ff_status status = try_shape(s, t);
        if (status) {
            s->status = status;
            return status;
        }
    }
    if (!jacobian) { /* the cost is all that is asked for */
        memset(residual, 0, s->n_moving * sizeof *residual);
        residual[s->n_moving] = sqrt(fmax(at_base ? s->base_gram.cost2 : s->gram.cost2, 0));
        return FF_OK;
    }
    if (!at_base) make_base(s);
    s->at_wall = outside;
    ff_compress(s->H, s->g, s->S, s->moving, s->n_moving, s->base_gram.cost2, s->work, residual, jacobian);
    return FF_OK;
}

static void tell(const solver *s, int iteration, double cost)
{
    if (s->plan->progress && s->effort->parallel) s->plan->progress(s->plan->progress_context, iteration, cost);
}

static int iterated(void *context, int iteration, double cost)
{
    solver *s = context;
    tell(s, s->iterations + iteration, cost);
    if (ff_plan_cancelled(s->plan)) return -1;
    if (s->at_wall) return 1;
    const int here = fabs(0.5 * s->base_gram.cost2 - cost) <= 1e-12 * cost;
    return here && s->explained + s->gain <= s->effort->tolerance * s->base_gram.cost2;
}

/* ---- moves ----------------------------------------------------------------------------------- */

static ff_status run_solver(solver *s, int max_iterations, ff_outcome *outcome, ff_error *err)
{
    double x[FF_MAX_SHARED], lower[FF_MAX_SHARED], upper[FF_MAX_SHARED];
    for (size_t i = 0; i < s->n_moving; i++) {
        x[i] = s->base[s->moving[i]];
        lower[i] = -INFINITY;
        upper[i] = INFINITY;
    }
    const ff_ceres_problem problem = {.n = s->n_moving,
                                      .lower = lower,
                                      .upper = upper,
                                      .evaluate = evaluate,
                                      .iterated = iterated,
                                      .context = s,
                                      .max_iterations = max_iterations,
                                      .function_tolerance = s->effort->tolerance,
                                      .parameter_tolerance = sqrt(s->effort->tolerance) * 1e-2};
    ff_ceres_summary summary;
    s->status = FF_OK;
    const ff_status status = ff_ceres_solve(&problem, x, &summary, err);
    if (status) return status;
    s->iterations += summary.iterations > 0 ? summary.iterations : 0;
    *outcome = ff_solve_outcome(summary.end);
    if (s->status == FF_ERR_CANCELLED || s->status == FF_ERR_MEMORY) return s->status;
    return *outcome == FF_CANCELLED ? FF_ERR_CANCELLED : FF_OK;
}

/* Steps of the channels alone, until they can gain no more. Where no coordinate of the shape moves that is the whole problem. */
static ff_status settle_channels(solver *s, int max_iterations, ff_outcome *outcome)
{
    double t[FF_MAX_SHARED];
    memcpy(t, s->base, s->S * sizeof *t);
    for (int step = 0; s->gain > s->effort->tolerance * s->base_gram.cost2; step++) {
        const double before = s->base_gram.cost2;
        if (step >= max_iterations || s->damping > 1e12) {
            *outcome = step >= max_iterations ? FF_LIMIT : FF_STALLED;
            break;
        }
        const ff_status status = try_shape(s, t);
        if (status && status != FF_ERR_INTERNAL) return status; /* a sum that is not finite is a step too far */
        s->iterations++;
        const int lower = !status && s->gram.cost2 < before;
        const int over = s->exact || s->moved <= 1e-2 * sqrt(s->effort->tolerance); /* what is left is rounding */
        if (lower) make_base(s);
        tell(s, s->iterations, 0.5 * s->base_gram.cost2);
        if (lower ? s->base_gram.cost2 >= before * (1 - s->effort->tolerance) : over) break;
    }
    return FF_OK;
}

/* ---- bounds of the shape --------------------------------------------------------------------- */

static int bound_of(const solver *s, size_t k)
{
    return ff_bound_of(s->l, &s->base_gram, s->base, s->lower[k], s->upper[k], k);
}

static int pulls_inside(const solver *s, size_t k, int bound)
{
    const double noise = 1e-9 * sqrt(fmax(s->H[k * s->S + k] * s->base_gram.cost2, 0));
    return bound * s->g[k] > noise;
}

/* As in solve.c. A coordinate that is held goes onto its bound without a pass: it was next to it. */
static int update_held(solver *s, int *held, int *releases)
{
    int changed = 0;
    for (size_t k = 0; k < s->S; k++) {
        const int bound = bound_of(s, k), hold = bound != 0 && !pulls_inside(s, k, bound);
        if (hold == held[k]) continue;
        if (!hold && releases[k]++ >= 3) continue;
        if (hold) s->base[k] = bound < 0 ? s->lower[k] : s->upper[k];
        held[k] = hold;
        changed = 1;
    }
    return changed;
}

static ff_status solve_moving(solver *s, const int *held, int max_iterations, ff_outcome *outcome, ff_error *err)
{
    const int before = s->iterations;
    s->n_moving = 0;
    s->at_wall = 0;
    for (size_t k = 0; k < s->S; k++)
        if (!held[k]) s->moving[s->n_moving++] = k;
    look_around(s);
    *outcome = FF_CONVERGED;
    ff_status status = FF_OK;
    if (s->n_moving > 0) status = run_solver(s, max_iterations, outcome, err);
    /* a last step that gained too little to be accepted is made all the same */
    if (!status && s->have_last && s->gram.cost2 < s->base_gram.cost2) make_base(s);
    const int left = max_iterations - (s->iterations - before);
    if (!status && *outcome != FF_LIMIT && !s->at_wall) status = settle_channels(s, left > 0 ? left : 0, outcome);
    return status;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void solver_free(solver *s)
{
    ff_normal_free(&s->normal);
    ff_normal_free(&s->at_base);
    ff_gram_free(&s->gram);
    ff_gram_free(&s->base_gram);
    free(s->x);
    free(s);
}

static solver *solver_new(const ff_plan *plan, const ff_effort *effort, ff_point *at)
{
    const ff_layout *l = &plan->l;
    const size_t P = l->P;
    solver *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->plan = plan, s->l = l, s->effort = effort, s->at = at;
    s->S = l->n_shared, s->K = l->n_own;
    s->exact = l->linear && !l->scaled && !plan->penalties && (plan->p->linearised || !ff_loss_is_curved(plan->p->loss));
    s->x = calloc(5 * P + 1, sizeof *s->x);
    if (!s->x || ff_layout_normal(l, &s->normal) || ff_layout_normal(l, &s->at_base) || ff_gram_new(l, &s->gram) ||
        ff_gram_new(l, &s->base_gram)) {
        solver_free(s);
        return NULL;
    }
    double **const vectors[] = {&s->lower, &s->upper, &s->slope, &s->base}, *next = s->x + P;
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++, next += P) *vectors[k] = next;
    ff_layout_bounds(l, s->lower, s->upper);
    ff_layout_pack(l, at->shape, at->channel, s->x);
    for (size_t k = 0; k < P; k++) s->x[k] = fmin(fmax(s->x[k], s->lower[k]), s->upper[k]);
    return s;
}

/* From s->x to the optimum. */
static ff_status minimise(solver *s, ff_error *err)
{
    const int most = s->effort->max_iterations;
    int held[FF_MAX_SHARED] = {0}, releases[FF_MAX_SHARED] = {0}, more;
    ff_outcome outcome = FF_CONVERGED;
    ff_status status = pass_here(s);
    if (status) return status;
    make_base(s);
    update_held(s, held, releases);
    do {
        const double before = s->base_gram.cost2;
        const int left = most - s->iterations;
        status = solve_moving(s, held, left > 0 ? left : 0, &outcome, err);
        /* the solver also ends when its steps are small, which says nothing of the channels */
        more = !status && s->explained + s->gain > s->effort->tolerance * s->base_gram.cost2 &&
               s->base_gram.cost2 < before * (1 - s->effort->tolerance);
        if (!status) more |= update_held(s, held, releases);
    } while (!status && outcome == FF_CONVERGED && s->iterations < most && more);
    s->at->outcome = outcome;
    return status;
}

/* What the point is told of its new place. */
static void arrive(solver *s)
{
    ff_point *at = s->at;
    ff_layout_unpack(s->l, s->base, at->shape, at->channel);
    for (size_t k = 0; k < s->l->P; k++) at->at_bound[k] = bound_of(s, k);
    at->iterations += s->iterations;
    at->passes += s->passes;
    at->cost2 = s->base_gram.cost2;
    at->open = ff_channels_open(s->l, &s->base_gram, s->base, s->lower, s->upper, s->effort->tolerance);
    if (!s->effort->speculate) return;
    at->normal = s->at_base; /* the sums that the uncertainty starts from */
    s->at_base = (ff_normal){0};
}

ff_status ff_solve_projected(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err)
{
    solver *s = solver_new(plan, effort, at);
    if (!s) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    const ff_status status = minimise(s, err);
    (void)ff_solve_failed(status, err);
    if (!status) arrive(s);
    solver_free(s);
    return status;
}
