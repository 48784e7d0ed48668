/* One minimisation: the compressed problem that the solver sees, its bounds, and when it has converged. */
#include "internal_solve.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the compressed problem ------------------------------------------------------------------ */

/* What the solver's evaluations share. */
typedef struct solver {
    const ff_layout *l;
    const struct ff_problem *p;
    const ff_fit_options *o;
    int parallel, passes, iterations, have_last;
    double shape[FF_MAX_SHAPE];
    double *channel;       /* [n_channels][n_channel]                                             */
    double *x;             /* [P] all coordinates; the solver moves those in `moving`             */
    double *lower, *upper; /* [P]                                                                 */
    size_t *moving, n_moving;
    ff_normal normal; /* of the last pass                                                    */
    double cost2;     /* twice the objective there                                           */
    double *last;     /* [P] where it was made                                               */
    double *H, *g;    /* [P][P], [P] in coordinates, of the last pass                        */
    double *work, *slope;
    double explained; /* |Q^T r|^2 of the last evaluation: what a Gauss-Newton step would gain */
    double tolerance; /* explained <= tolerance * cost2 is converged                         */
    double gain[2];   /* explained / cost2 of the last two points, the latest first; 0 = none */
    int speculate, last_is_final;
    int left_box;     /* a step of the unbounded solver went outside                          */
    ff_status status; /* of a pass that failed                                               */
} solver;

/* A pass that also gathers statistics and errors costs half as much again as a plain one, and a pass less is a pass less. Near the
 * minimum the gains of successive steps fall quadratically at first, then by a constant factor. */
static int next_looks_last(const solver *s)
{
    if (s->gain[0] <= 0) return 0;
    return s->gain[1] > 0 ? s->gain[0] * (s->gain[0] / s->gain[1]) < s->tolerance : s->gain[0] < 1e-3;
}

/* One pass at s->x unless the last one was made there: cost and Jacobian at a point are one pass, not two. */
static ff_status pass_here(solver *s)
{
    const ff_layout *l = s->l;
    if (s->have_last && memcmp(s->x, s->last, l->P * sizeof *s->x) == 0) return FF_OK;
    if (ff_fit_cancelled(s->o)) return FF_ERR_CANCELLED;
    ff_pass pass;
    ff_layout_unpack(l, s->x, s->shape, s->channel);
    ff_status st = ff_layout_pass(l, s->p, s->o, s->shape, s->channel, &pass);
    if (st) return st;
    pass.final = s->speculate && next_looks_last(s);
    s->last_is_final = pass.final;
    s->passes++;
    s->have_last = 0;
    st = ff_pass_run(&pass, s->parallel, &s->normal);
    ff_pass_free(&pass);
    if (st) return st;
    ff_layout_slope(l, s->shape, s->channel, s->slope);
    ff_normal_assemble(l, &s->normal, s->slope, s->H, s->g);
    s->cost2 = s->normal.cost2;
    st = ff_extras_add(l, s->p, s->parallel, s->shape, s->channel, s->slope, &s->cost2, s->H, s->g);
    if (st) return st;
    memcpy(s->last, s->x, l->P * sizeof *s->x);
    s->have_last = 1;
    s->gain[1] = s->gain[0];
    s->gain[0] = 0;
    return FF_OK;
}

double ff_compress(const double *H, const double *g, size_t P, const size_t *index, size_t n, double cost2, double *work,
                   double *residual, double *jacobian)
{
    double *sub = work, *L = sub + n * n, *D = L + n * n, explained = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) sub[i * n + j] = H[index[i] * P + index[j]];
    ff_scaled_cholesky(sub, n, 1e-14, L, D);
    for (size_t i = 0; i < n; i++) { /* L (Q^T r) = D^-1 g */
        double v = D[i] > 0 ? g[index[i]] / D[i] : 0;
        for (size_t k = 0; k < i; k++) v -= L[i * n + k] * residual[k];
        residual[i] = L[i * n + i] > 0 ? v / L[i * n + i] : 0;
        explained += residual[i] * residual[i];
    }
    residual[n] = sqrt(fmax(cost2 - explained, 0));
    if (!jacobian) return explained;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) jacobian[i * n + j] = L[j * n + i] * D[j];
    for (size_t j = 0; j < n; j++) jacobian[n * n + j] = 0;
    return explained;
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
    const ff_status st = pass_here(s);
    if (st) {
        s->status = st;
        return st;
    }
    s->explained = ff_compress(s->H, s->g, s->l->P, s->moving, n, s->cost2, s->work, residual, jacobian);
    s->gain[0] = s->explained / fmax(s->cost2, 1e-300);
    return FF_OK;
}

/* Converged when a Gauss-Newton step can gain nothing that counts (the Newton decrement): this needs no further pass to see it. The
 * last evaluation was made at the current point when its cost is the current one. */
static int iterated(void *context, int iteration, double cost)
{
    solver *s = context;
    if (s->o->progress && s->parallel) s->o->progress(s->o->progress_context, s->iterations + iteration, cost);
    if (ff_fit_cancelled(s->o)) return -1;
    if (s->left_box) return 1; /* to be taken up again with bounds */
    const int here = s->have_last && fabs(0.5 * s->cost2 - cost) <= 1e-12 * cost;
    return here && s->explained <= s->tolerance * s->cost2;
}

/* ---- bounds ---------------------------------------------------------------------------------- */

#define FF_NEAR 1e-10 /* of the box or of the data: a coordinate that is no further from a bound is on it */

/* What coordinate k moves the residuals of channel c by, squared, and how large these and the parts of the model are that belong to
 * the channel's parameters. */
static void effect_in(const ff_layout *l, const ff_normal *n, const double *x, size_t k, size_t c, double *effect2, double *size2)
{
    const size_t S = l->free.n_shape, m = n->m1 - 1;
    const double *gram = n->gram + c * (n->m1 * (n->m1 + 1) / 2);
    *size2 += gram[ff_tri(m, m)];
    for (size_t a = S; a < m; a++) {
        const size_t at = ff_layout_coordinate(l, c, a);
        const ff_param *info = l->m->channel[l->free.channel[a - S]].info;
        const double value = ff_coordinate_value(info, x[at]), slope = ff_coordinate_slope(info, value), g = gram[ff_tri(a, a)];
        *size2 += g * value * value;
        if (at == k) *effect2 += g * slope * slope;
    }
}

/* A parameter of a channel has the scale of the data, which may be a millionth of its box: near is what is lost beside the data. */
static double near_bound(const ff_layout *l, const ff_normal *n, const double *x, size_t k, double span)
{
    size_t c, end;
    double effect2 = 0, size2 = 0;
    (void)ff_layout_param(l, k, &c);
    end = k < l->n_shared ? l->n_channels : c + 1;
    for (; c < end; c++) effect_in(l, n, x, k, c, &effect2, &size2);
    return FF_NEAR * (effect2 > 0 ? fmin(span, sqrt(size2 / effect2)) : span);
}

int ff_solve_bound_of(const ff_layout *l, const ff_normal *n, const double *x, double lower, double upper, size_t k)
{
    const double to_lower = x[k] - lower, to_upper = upper - x[k], distance = fmin(to_lower, to_upper);
    if (distance > FF_NEAR * (upper - lower)) return 0;
    if (distance > 0 && distance > near_bound(l, n, x, k, upper - lower)) return 0;
    return to_lower <= to_upper ? -1 : 1;
}

/* Of a solver, at its point. */
static int bound_of(const solver *s, size_t k)
{
    return ff_solve_bound_of(s->l, &s->normal, s->x, s->lower[k], s->upper[k], k);
}

/* Would the objective fall if a coordinate on its bound moved inside? Judged against the rounding of the gradient. */
static int pulls_inside(const solver *s, size_t k, int bound)
{
    const double noise = 1e-9 * sqrt(fmax(s->H[k * s->l->P + k] * s->cost2, 0));
    return bound * s->g[k] > noise;
}

/* Coordinates that press against a bound rest there while the others move: the solver's own projection crawls along walls. held [P]
 * is updated; returns whether it changed. releases [P] counts how often each was let go, so that none flips for ever. */
static int update_held(solver *s, int *held, int *releases)
{
    int changed = 0;
    for (size_t k = 0; k < s->l->P; k++) {
        if (k == s->l->pinned) {
            held[k] = 1;
            continue;
        }
        const int bound = bound_of(s, k);
        const int hold = bound != 0 && !pulls_inside(s, k, bound);
        if (hold == held[k]) continue;
        if (!hold && releases[k]++ >= 3) continue;
        if (hold) s->x[k] = bound < 0 ? s->lower[k] : s->upper[k];
        held[k] = hold;
        changed = 1;
    }
    return changed;
}

void ff_solve_bounds(const ff_layout *l, double *lower, double *upper)
{
    for (size_t k = 0; k < l->P; k++) {
        const ff_model_param *p = ff_layout_param(l, k, NULL);
        lower[k] = ff_coordinate(p->info, p->lo);
        upper[k] = ff_coordinate(p->info, p->hi);
    }
}

/* ---- one minimisation ------------------------------------------------------------------------ */

ff_outcome ff_solve_outcome(ff_ceres_end end)
{
    switch (end) {
    case FF_CERES_CONVERGED:
        return FF_CONVERGED;
    case FF_CERES_LIMIT:
        return FF_LIMIT;
    case FF_CERES_STOPPED:
        return FF_CANCELLED;
    default:
        return FF_STALLED;
    }
}

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
    /* the gradient has the scale of the data, so only steps and the objective decide */
    const ff_ceres_problem problem = {.n = s->n_moving,
                                      .lower = lower,
                                      .upper = upper,
                                      .evaluate = evaluate,
                                      .iterated = iterated,
                                      .context = s,
                                      .max_iterations = max_iterations,
                                      .function_tolerance = s->tolerance,
                                      .parameter_tolerance = sqrt(s->tolerance) * 1e-2};
    ff_ceres_summary summary;
    s->status = FF_OK;
    s->left_box = 0;
    const ff_status st = ff_ceres_solve(&problem, x, &summary, err);
    if (st) return st;
    s->iterations += summary.iterations > 0 ? summary.iterations : 0;
    *outcome = ff_solve_outcome(summary.end);
    for (size_t i = 0; i < s->n_moving; i++) s->x[s->moving[i]] = fmin(fmax(x[i], s->lower[s->moving[i]]), s->upper[s->moving[i]]);
    if (s->status == FF_ERR_CANCELLED || s->status == FF_ERR_MEMORY) return s->status;
    return *outcome == FF_CANCELLED ? FF_ERR_CANCELLED : FF_OK;
}

/* Moves the coordinates that are not held until the solver is content. Bounds cost the solver extra evaluations, so it gets them
 * only when it ran into one. */
static ff_status solve_moving(solver *s, const int *held, int max_iterations, ff_outcome *outcome, ff_error *err)
{
    const size_t P = s->l->P;
    double *x = malloc((3 * P + 1) * sizeof *x);
    if (!x) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    s->n_moving = 0;
    for (size_t k = 0; k < P; k++)
        if (!held[k]) s->moving[s->n_moving++] = k;
    ff_status st = FF_OK;
    *outcome = FF_CONVERGED;
    if (s->n_moving > 0) {
        const int before = s->iterations;
        st = run_solver(s, x, x + P, x + 2 * P, 0, max_iterations, outcome, err);
        const int left = max_iterations - (s->iterations - before);
        if (!st && s->left_box) st = run_solver(s, x, x + P, x + 2 * P, 1, left > 0 ? left : 0, outcome, err);
    }
    free(x);
    if (st) return st;
    return pass_here(s); /* mostly the solver's last pass */
}

static void solver_free(solver *s)
{
    ff_normal_free(&s->normal);
    free(s->x);
    free(s->channel);
    free(s->moving);
}

static ff_status solver_new(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, solver *s)
{
    const size_t P = l->P;
    memset(s, 0, sizeof *s);
    s->l = l, s->p = p, s->o = o, s->parallel = parallel;
    s->x = calloc(7 * P + 3 * P * P + 1, sizeof *s->x);
    s->moving = calloc(P + 1, sizeof *s->moving);
    s->channel = calloc(l->n_channels * l->m->n_channel + 1, sizeof *s->channel);
    if (!s->x || !s->moving || !s->channel || ff_normal_new(l, &s->normal)) {
        solver_free(s);
        return FF_ERR_MEMORY;
    }
    double *next = s->x + P;
    double **const vectors[] = {&s->lower, &s->upper, &s->last, &s->g, &s->slope};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++, next += P) *vectors[k] = next;
    s->H = next;
    s->work = next + P * P; /* [2 P P + P] */
    ff_solve_bounds(l, s->lower, s->upper);
    return FF_OK;
}

ff_status ff_solve(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, int speculate,
                   double tolerance, int max_iterations, double *shape, double *channel, int *at_bound, ff_solution *out,
                   ff_error *err)
{
    if (l->arrow)
        return ff_solve_projected(l, p, o, parallel, speculate, tolerance, max_iterations, shape, channel, at_bound, out, err);
    solver s;
    int *held = calloc(2 * l->P + 1, sizeof *held), *releases = held + l->P;
    ff_status st = held ? solver_new(l, p, o, parallel, &s) : FF_ERR_MEMORY;
    if (st) {
        free(held);
        return ff_error_set(err, st, NULL, 0, -1, "out of memory");
    }
    s.tolerance = tolerance;
    s.speculate = speculate;
    memcpy(s.shape, shape, l->m->n_shape * sizeof *shape);
    memcpy(s.channel, channel, l->n_channels * l->m->n_channel * sizeof *channel);
    ff_layout_pack(l, shape, channel, s.x);
    for (size_t k = 0; k < l->P; k++) s.x[k] = fmin(fmax(s.x[k], s.lower[k]), s.upper[k]);
    ff_outcome outcome = FF_CONVERGED;
    st = pass_here(&s);
    if (!st) {
        update_held(&s, held, releases);
        do {
            const int left = max_iterations - s.iterations;
            st = solve_moving(&s, held, left > 0 ? left : 0, &outcome, err);
        } while (!st && outcome == FF_CONVERGED && s.iterations < max_iterations && update_held(&s, held, releases));
    }
    if (st == FF_ERR_CANCELLED)
        ff_error_set(err, st, NULL, 0, -1, "cancelled");
    else if (st)
        ff_error_set(err, st, NULL, 0, -1, "a pass over the samples failed: %s", ff_status_str(st));
    if (!st) {
        ff_layout_unpack(l, s.x, shape, channel);
        for (size_t k = 0; k < l->P; k++) at_bound[k] = bound_of(&s, k);
        *out = (ff_solution){.outcome = outcome, .iterations = s.iterations, .passes = s.passes, .cost2 = s.cost2};
        if (s.last_is_final && s.have_last && memcmp(s.x, s.last, l->P * sizeof *s.x) == 0) {
            out->normal = s.normal;
            out->has_final = 1;
            s.normal = (ff_normal){0};
            st = ff_normal_fold(l, &out->normal);
        }
    }
    solver_free(&s);
    free(held);
    return st;
}
