/* One minimisation: the compressed problem that the solver sees, its bounds, and when it has converged. */
#include "internal_minimise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the compressed problem ------------------------------------------------------------------ */

/* What the solver's evaluations share. */
typedef struct solver {
    const ff_plan *plan;
    const ff_layout *l; /* the plan's                                                        */
    const ff_effort *effort;
    ff_point *at; /* its parameters are those of the last pass                         */
    int passes, iterations, have_last;
    double *x;             /* [P] all coordinates; the solver moves those in `moving`             */
    double *lower, *upper; /* [P]                                                                 */
    size_t *moving, n_moving;
    int *held, *releases; /* [P]: 1 on a bound that it presses against; how often it was let go  */
    ff_normal normal;     /* of the last pass                                                    */
    ff_gram gram;         /* and in coordinates                                                  */
    double cost2;         /* twice the objective there                                           */
    double *last;         /* [P] where it was made                                               */
    double *H, *g;        /* [P][P], [P] in coordinates, of the last pass                        */
    double *work, *slope;
    double explained; /* |Q^T r|^2 of the last evaluation: what a Gauss-Newton step would gain */
    double gain[2];   /* explained / cost2 of the last two points, the latest first; 0 = none */
    int last_is_final;
    int left_box;     /* a step of the unbounded solver went outside                          */
    ff_status status; /* of a pass that failed                                               */
} solver;

/* A pass that also gathers statistics and errors costs half as much again as a plain one, and a pass less is a pass less. Near the
 * minimum the gains of successive steps fall quadratically at first, then by a constant factor. */
static int next_looks_last(const solver *s)
{
    if (s->gain[0] <= 0) return 0;
    return s->gain[1] > 0 ? s->gain[0] * (s->gain[0] / s->gain[1]) < s->effort->tolerance : s->gain[0] < 1e-3;
}

/* One pass at s->x unless the last one was made there: cost and Jacobian at a point are one pass, not two. */
static ff_status pass_here(solver *s)
{
    const ff_layout *l = s->l;
    if (s->have_last && memcmp(s->x, s->last, l->P * sizeof *s->x) == 0) return FF_OK;
    if (ff_plan_cancelled(s->plan)) return FF_ERR_CANCELLED;
    ff_pass pass;
    ff_layout_unpack(l, s->x, s->at->shape, s->at->channel);
    ff_status status = ff_plan_pass(s->plan, s->at->shape, s->at->channel, &pass);
    if (status) return status;
    pass.final = s->effort->speculate && next_looks_last(s);
    s->last_is_final = pass.final;
    s->passes++;
    s->have_last = 0;
    status = ff_pass_run(&pass, s->effort->parallel, &s->normal);
    ff_pass_free(&pass);
    if (status) return status;
    ff_layout_slope(l, s->at->shape, s->at->channel, s->slope);
    ff_gram_fill(l, &s->normal, s->slope, &s->gram);
    status = ff_penalties_add(s->plan, s->effort->parallel, s->at->shape, s->at->channel, s->slope, &s->gram);
    if (status) return status;
    ff_gram_dense(&s->gram, s->H, s->g);
    s->cost2 = s->gram.cost2;
    memcpy(s->last, s->x, l->P * sizeof *s->x);
    s->have_last = 1;
    s->gain[1] = s->gain[0];
    s->gain[0] = 0;
    return FF_OK;
}

/* The compressed problem of the moving coordinates at x. */
static ff_status evaluate(void *context, const double *x, double *residual, double *jacobian)
{
    solver *s = context;
    const size_t n = s->n_moving;
    for (size_t i = 0; i < n; i++) {
        const size_t k = s->moving[i];
        if (!(x[i] >= s->lower[k] && x[i] <= s->upper[k])) {
            s->left_box = 1;
            return FF_ERR_RANGE;
        }
        s->x[k] = x[i];
    }
    const ff_status status = pass_here(s);
    if (status) {
        s->status = status;
        return status;
    }
    s->explained = ff_compress(s->H, s->g, s->l->P, s->moving, n, s->cost2, s->work, residual, jacobian);
    s->gain[0] = s->explained / fmax(s->cost2, 1e-300);
    return FF_OK;
}

/* What all steps from here on can gain, of the objective: as much as a Gauss-Newton step (the Newton decrement), and where gains
 * fall by a constant factor q, as under robust losses, 1 / (1 - q) times that. */
static double left_to_gain(const solver *s)
{
    const double gain = s->explained / fmax(s->cost2, 1e-300);
    const double q = s->gain[1] > 0 ? fmin(gain / s->gain[1], 0.99) : 0;
    return gain / (1 - q);
}

/* Converged when nothing that counts is left: this needs no further pass to see it. The last evaluation was made at the current
 * point when its cost is the current one. */
static int iterated(void *context, int iteration, double cost)
{
    solver *s = context;
    const ff_plan *plan = s->plan;
    if (plan->progress && s->effort->parallel) plan->progress(plan->progress_context, s->iterations + iteration, cost);
    if (ff_plan_cancelled(plan)) return -1;
    if (s->left_box) return 1; /* to be taken up again with bounds */
    const int here = s->have_last && fabs(0.5 * s->cost2 - cost) <= 1e-12 * cost;
    return here && left_to_gain(s) <= s->effort->tolerance;
}

/* ---- bounds ---------------------------------------------------------------------------------- */

/* Of a solver, at its point. */
static int bound_of(const solver *s, size_t k)
{
    return ff_bound_of(s->l, &s->gram, s->x, s->lower[k], s->upper[k], k);
}

/* |column of coordinate k| |r|, the sum over the channels it is in: what its gradient is a part of, and rounds by. */
static double gradient_size(const solver *s, size_t k)
{
    const size_t S = s->gram.S, m = S + s->gram.K;
    double sum = 0;
    for (size_t c = 0; c < s->gram.C; c++) {
        const double *G = s->gram.local + c * s->gram.tri;
        if (k >= S && (k - S) / s->gram.K != c) continue;
        const size_t a = k < S ? k : S + (k - S) % s->gram.K;
        sum += sqrt(fmax(G[ff_tri(a, a)] * G[ff_tri(m, m)], 0));
    }
    return sum;
}

/* Would the objective fall if a coordinate on its bound moved inside? Judged against the rounding of the gradient. */
static int pulls_inside(const solver *s, size_t k, int bound)
{
    const double noise = 1e-9 * gradient_size(s, k);
    return bound * s->g[k] > noise;
}

/* Coordinates that press against a bound rest there while the others move: the solver's own projection crawls along walls. Returns
 * whether any that is held changed; none is let go so often that it flips for ever. */
static int update_held(solver *s)
{
    int changed = 0;
    for (size_t k = 0; k < s->l->P; k++) {
        if (k == s->l->pinned || s->lower[k] == s->upper[k]) {
            s->held[k] = 1;
            continue;
        }
        const int bound = bound_of(s, k);
        const int hold = bound != 0 && !pulls_inside(s, k, bound);
        if (hold == s->held[k]) continue;
        if (!hold && s->releases[k]++ >= 3) continue;
        if (hold) s->x[k] = bound < 0 ? s->lower[k] : s->upper[k];
        s->held[k] = hold;
        changed = 1;
    }
    return changed;
}

/* ---- one minimisation ------------------------------------------------------------------------ */

/* Runs the solver over the moving coordinates from s->x; walls: with their bounds, else as if there were none. */
static ff_status run_solver(solver *s, double *x, double *lower, double *upper, int walls, int max_iterations, ff_outcome *outcome,
                            ff_error *err)
{
    for (size_t i = 0; i < s->n_moving; i++) {
        const size_t k = s->moving[i];
        x[i] = s->x[k];
        lower[i] = walls ? s->lower[k] : -INFINITY;
        upper[i] = walls ? s->upper[k] : INFINITY;
    }
    /* The gradient has the scale of the data, so only steps and the objective decide; and `iterated`, which knows more of it, where
     * the objective still falls. */
    const ff_ceres_problem problem = {.n = s->n_moving,
                                      .lower = lower,
                                      .upper = upper,
                                      .evaluate = evaluate,
                                      .iterated = iterated,
                                      .context = s,
                                      .max_iterations = max_iterations,
                                      .function_tolerance = 1e-2 * s->effort->tolerance,
                                      .parameter_tolerance = sqrt(s->effort->tolerance) * 1e-2};
    ff_ceres_summary summary;
    s->status = FF_OK;
    s->left_box = 0;
    const ff_status status = ff_ceres_solve(&problem, x, &summary, err);
    if (status) return status;
    s->iterations += summary.iterations > 0 ? summary.iterations : 0;
    *outcome = ff_solve_outcome(summary.end);
    for (size_t i = 0; i < s->n_moving; i++) s->x[s->moving[i]] = fmin(fmax(x[i], s->lower[s->moving[i]]), s->upper[s->moving[i]]);
    if (s->status == FF_ERR_CANCELLED || s->status == FF_ERR_MEMORY) return s->status;
    return *outcome == FF_CANCELLED ? FF_ERR_CANCELLED : FF_OK;
}

/* Moves the coordinates that are not held until the solver is content. Bounds cost the solver extra evaluations, so it gets them
 * only when it ran into one. */
static ff_status solve_moving(solver *s, int max_iterations, ff_outcome *outcome, ff_error *err)
{
    const size_t P = s->l->P;
    double *x = malloc((3 * P + 1) * sizeof *x);
    if (!x) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    s->n_moving = 0;
    for (size_t k = 0; k < P; k++)
        if (!s->held[k]) s->moving[s->n_moving++] = k;
    ff_status status = FF_OK;
    *outcome = FF_CONVERGED;
    if (s->n_moving > 0) {
        const int before = s->iterations;
        status = run_solver(s, x, x + P, x + 2 * P, 0, max_iterations, outcome, err);
        const int left = max_iterations - (s->iterations - before);
        if (!status && s->left_box) status = run_solver(s, x, x + P, x + 2 * P, 1, left > 0 ? left : 0, outcome, err);
    }
    free(x);
    if (status) return status;
    return pass_here(s); /* mostly the solver's last pass */
}

static void solver_free(solver *s)
{
    ff_normal_free(&s->normal);
    ff_gram_free(&s->gram);
    free(s->x);
    free(s->moving);
    free(s->held);
}

static ff_status solver_new(const ff_plan *plan, const ff_effort *effort, ff_point *at, solver *s)
{
    const size_t P = plan->l.P;
    *s = (solver){.plan = plan, .l = &plan->l, .effort = effort, .at = at};
    s->x = calloc(7 * P + 3 * P * P + 1, sizeof *s->x);
    s->moving = calloc(P + 1, sizeof *s->moving);
    s->held = calloc(2 * P + 1, sizeof *s->held);
    if (!s->x || !s->moving || !s->held || ff_layout_normal(s->l, &s->normal) || ff_gram_new(s->l, &s->gram)) {
        solver_free(s);
        return FF_ERR_MEMORY;
    }
    s->releases = s->held + P;
    double *next = s->x + P;
    double **const vectors[] = {&s->lower, &s->upper, &s->last, &s->g, &s->slope};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++, next += P) *vectors[k] = next;
    s->H = next;
    s->work = next + P * P; /* [2 P P + P] */
    ff_layout_bounds(s->l, s->lower, s->upper);
    ff_layout_pack(s->l, at->shape, at->channel, s->x);
    for (size_t k = 0; k < P; k++) s->x[k] = fmin(fmax(s->x[k], s->lower[k]), s->upper[k]);
    return FF_OK;
}

/* From s->x to the optimum. */
static ff_status minimise(solver *s, ff_error *err)
{
    const int most = s->effort->max_iterations;
    ff_outcome outcome = FF_CONVERGED;
    ff_status status = pass_here(s);
    if (status) return status;
    update_held(s);
    do {
        const int left = most - s->iterations;
        status = solve_moving(s, left > 0 ? left : 0, &outcome, err);
    } while (!status && outcome == FF_CONVERGED && s->iterations < most && update_held(s));
    s->at->outcome = outcome;
    return status;
}

/* What the point is told of its new place. */
static ff_status arrive(solver *s)
{
    ff_point *at = s->at;
    ff_layout_unpack(s->l, s->x, at->shape, at->channel);
    for (size_t k = 0; k < s->l->P; k++) at->at_bound[k] = bound_of(s, k);
    at->iterations += s->iterations;
    at->passes += s->passes;
    at->cost2 = s->cost2;
    at->open = ff_channels_open(s->l, &s->gram, s->x, s->lower, s->upper, s->effort->tolerance);
    if (!s->last_is_final || !s->have_last || memcmp(s->x, s->last, s->l->P * sizeof *s->x) != 0) return FF_OK;
    at->normal = s->normal;
    at->has_final = 1;
    s->normal = (ff_normal){0};
    return ff_normal_fold(s->l, &at->normal);
}

ff_status ff_solve_dense(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err)
{
    solver s;
    ff_status status = solver_new(plan, effort, at, &s);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "out of memory");
    status = minimise(&s, err);
    (void)ff_solve_failed(status, err);
    if (!status) status = arrive(&s);
    solver_free(&s);
    return status;
}
