/* The fit: start, solver, uncertainty, and the words that go with the numbers. */
#define _GNU_SOURCE /* clock_gettime */
#include "ceres_bridge.h"
#include "internal_fit.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A problem that stands for another need not be minimised further than the two differ. */
#define FF_ROUGH 1e-7
#define FF_EXACT 1e-11

/* ---- the compressed problem
 * ------------------------------------------------------------------------------------------------------ */

/* What the solver's evaluations share. */
typedef struct solver {
    const ff_layout *l;
    const struct ff_problem *p;
    const ff_fit_options *o;
    int parallel, passes, iterations, have_last;
    double shape[FF_MAX_SHAPE];
    double *x;             /* [P] all coordinates; the solver moves those in `moving`             */
    double *lower, *upper; /* [P]                                                                 */
    size_t *moving, n_moving;
    ff_normal normal; /* of the last pass                                                    */
    double *last;     /* [P] where it was made                                               */
    double *H, *g;    /* [P][P], [P] in coordinates, of the last pass                        */
    double *sub, *L, *D, *slope;
    double explained; /* |Q^T r|^2 of the last evaluation: what a Gauss-Newton step would gain */
    double tolerance; /* explained <= tolerance * cost2 is converged                         */
    double gain[2];   /* explained / cost2 of the last two points, the latest first; 0 = none */
    int speculate, last_is_final;
    int left_box;     /* a step of the unbounded solver went outside                          */
    ff_status status; /* of a pass that failed                                               */
} solver;

int ff_fit_cancelled(const ff_fit_options *o)
{
    return o->cancel && __atomic_load_n(o->cancel, __ATOMIC_RELAXED);
}

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
    ff_layout_unpack(l, s->x, s->shape);
    ff_layout_pass(l, s->p, s->o, s->shape, s->x + l->n_free, &pass);
    pass.final = s->speculate && next_looks_last(s);
    s->last_is_final = pass.final;
    s->passes++;
    s->have_last = 0;
    const ff_status st = ff_pass_run(&pass, s->parallel, &s->normal);
    if (st) return st;
    for (size_t k = 0; k < l->P; k++)
        s->slope[k] = k < l->n_free ? ff_coordinate_slope(l->m->shape[l->index[k]].info, s->shape[l->index[k]]) : 1;
    ff_normal_assemble(l, &s->normal, s->slope, s->H, s->g);
    memcpy(s->last, s->x, l->P * sizeof *s->x);
    s->have_last = 1;
    s->gain[1] = s->gain[0];
    s->gain[0] = 0;
    return FF_OK;
}

/* Residual [Q^T r; rest] and Jacobian [R; 0] of the moving coordinates: R = (D L)^T from J^T J = D L L^T D. */
static ff_status evaluate(void *context, const double *x, double *residual, double *jacobian)
{
    solver *s = context;
    const size_t n = s->n_moving, P = s->l->P;
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
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) s->sub[i * n + j] = s->H[s->moving[i] * P + s->moving[j]];
    ff_scaled_cholesky(s->sub, n, 1e-14, s->L, s->D);
    double explained = 0;
    for (size_t i = 0; i < n; i++) { /* L (Q^T r) = D^-1 g */
        double v = s->D[i] > 0 ? s->g[s->moving[i]] / s->D[i] : 0;
        for (size_t k = 0; k < i; k++) v -= s->L[i * n + k] * residual[k];
        residual[i] = s->L[i * n + i] > 0 ? v / s->L[i * n + i] : 0;
        explained += residual[i] * residual[i];
    }
    residual[n] = sqrt(fmax(s->normal.cost2 - explained, 0));
    s->explained = explained;
    s->gain[0] = explained / fmax(s->normal.cost2, 1e-300);
    if (!jacobian) return FF_OK;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) jacobian[i * n + j] = s->L[j * n + i] * s->D[j];
    for (size_t j = 0; j < n; j++) jacobian[n * n + j] = 0;
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
    const int here = s->have_last && fabs(0.5 * s->normal.cost2 - cost) <= 1e-12 * cost;
    return here && s->explained <= s->tolerance * s->normal.cost2;
}

/* ---- bounds
 * ------------------------------------------------------------------------------------------------------------------------ */

/* -1, +1 where a coordinate sits on its bound, else 0. */
static int bound_of(const solver *s, size_t k)
{
    const double span = s->upper[k] - s->lower[k], near = 1e-10 * span;
    return s->x[k] <= s->lower[k] + near ? -1 : s->x[k] >= s->upper[k] - near ? 1 : 0;
}

/* Would the objective fall if a coordinate on its bound moved inside? Judged against the rounding of the gradient. */
static int pulls_inside(const solver *s, size_t k, int bound)
{
    const double noise = 1e-9 * sqrt(fmax(s->H[k * s->l->P + k] * s->normal.cost2, 0));
    return bound * s->g[k] > noise;
}

/* Coordinates that press against a bound rest there while the others move: the solver's own projection crawls along walls. held [P]
 * is updated; returns whether it changed. releases [P] counts how often each was let go, so that none flips for ever. */
static int update_held(solver *s, int *held, int *releases)
{
    int changed = 0;
    for (size_t k = 0; k < s->l->P; k++) {
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

static void set_bounds(const ff_layout *l, double *lower, double *upper)
{
    for (size_t k = 0; k < l->P; k++) {
        const ff_param *info =
            k < l->n_free ? l->m->shape[l->index[k]].info : l->m->channel[(k - l->n_free) % l->m->n_channel].info;
        lower[k] = k < l->n_free ? ff_coordinate(info, info->lo) : info->lo;
        upper[k] = k < l->n_free ? ff_coordinate(info, info->hi) : info->hi;
    }
}

/* ---- one minimisation
 * -------------------------------------------------------------------------------------------------------------- */

static ff_outcome outcome_of(ff_ceres_end end)
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
    *outcome = outcome_of(summary.end);
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
    free(s->moving);
}

static ff_status solver_new(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, solver *s)
{
    const size_t P = l->P;
    memset(s, 0, sizeof *s);
    s->l = l, s->p = p, s->o = o, s->parallel = parallel;
    s->x = calloc(7 * P + 3 * P * P + 1, sizeof *s->x);
    s->moving = calloc(P + 1, sizeof *s->moving);
    if (!s->x || !s->moving || ff_normal_new(l->m, l->n_free, l->n_channels, &s->normal)) {
        solver_free(s);
        return FF_ERR_MEMORY;
    }
    double *next = s->x + P;
    double **const vectors[] = {&s->lower, &s->upper, &s->last, &s->g, &s->D, &s->slope},
                   **const matrices[] = {&s->H, &s->sub, &s->L};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++, next += P) *vectors[k] = next;
    for (size_t k = 0; k < sizeof matrices / sizeof *matrices; k++, next += P * P) *matrices[k] = next;
    set_bounds(l, s->lower, s->upper);
    return FF_OK;
}

ff_status ff_solve(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, int speculate,
                   double tolerance, int max_iterations, double *shape, double *channel, int *at_bound, ff_solution *out,
                   ff_error *err)
{
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
    ff_layout_pack(l, shape, s.x);
    memcpy(s.x + l->n_free, channel, l->n_channels * l->m->n_channel * sizeof *channel);
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
        ff_layout_unpack(l, s.x, s.shape);
        memcpy(shape, s.shape, l->m->n_shape * sizeof *shape);
        memcpy(channel, s.x + l->n_free, l->n_channels * l->m->n_channel * sizeof *channel);
        for (size_t k = 0; k < l->P; k++) at_bound[k] = bound_of(&s, k);
        *out = (ff_solution){.outcome = outcome, .iterations = s.iterations, .passes = s.passes, .cost2 = s.normal.cost2};
        if (s.last_is_final && s.have_last && memcmp(s.x, s.last, l->P * sizeof *s.x) == 0) {
            out->normal = s.normal;
            out->has_final = 1;
            s.normal = (ff_normal){0};
        }
    }
    solver_free(&s);
    free(held);
    return st;
}

/* ---- from a search to a start
 * ------------------------------------------------------------------------------------------------------ */

enum { FF_CANDIDATES = 4 };

/* Candidates that are minimised on the thin problem, each on its own thread. */
typedef struct polish {
    const ff_layout *l;
    const struct ff_problem *p;
    const ff_fit_options *o;
    ff_candidate *candidate;
    double *channel;   /* [candidates][n_channels n_channel] */
    ff_status *status; /* [candidates] */
} polish;

static void polish_one(void *context, size_t i, int worker)
{
    const polish *p = context;
    const size_t size = p->l->n_channels * p->l->m->n_channel;
    double *channel = p->channel + i * (size + 1), cost2;
    ff_solution solution;
    int *at_bound = malloc((p->l->P + 1) * sizeof *at_bound);
    (void)worker;
    p->status[i] = at_bound ? ff_start_channels(p->l, p->p, p->o, p->candidate[i].shape, channel, &cost2) : FF_ERR_MEMORY;
    if (!p->status[i])
        p->status[i] =
            ff_solve(p->l, p->p->thin, p->o, 0, 0, FF_ROUGH, 40, p->candidate[i].shape, channel, at_bound, &solution, NULL);
    if (!p->status[i]) p->candidate[i].cost2 = solution.cost2;
    free(at_bound);
}

/* shape, channel: where to start on all samples. */
static ff_status find_start(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                            ff_error *err)
{
    ff_candidate candidate[FF_CANDIDATES];
    ff_status status[FF_CANDIDATES] = {FF_OK}, st = FF_OK;
    size_t n = 0;
    const size_t size = l->n_channels * l->m->n_channel;
    double *channels = calloc(FF_CANDIDATES * (size + 1), sizeof *channels);
    if (!channels) st = FF_ERR_MEMORY;
    if (!st) st = ff_start_search(l, p, o, candidate, FF_CANDIDATES, &n);
    if (!st) {
        polish work = {l, p, o, candidate, channels, status};
        ff_pool_run(p->pool, n, polish_one, &work);
        size_t best = n;
        for (size_t i = 0; i < n; i++) {
            if (status[i] == FF_ERR_CANCELLED || status[i] == FF_ERR_MEMORY) st = status[i];
            if (!status[i] && (best == n || candidate[i].cost2 < candidate[best].cost2)) best = i;
        }
        if (!st && best == n) st = n ? status[0] : FF_ERR_INTERNAL;
        if (!st) {
            memcpy(shape, candidate[best].shape, l->m->n_shape * sizeof *shape);
            memcpy(channel, channels + best * (size + 1), size * sizeof *channel);
        }
    }
    free(channels);
    if (st == FF_ERR_CANCELLED) return ff_error_set(err, st, NULL, 0, -1, "cancelled");
    return st ? ff_error_set(err, st, NULL, 0, -1, "the search for a start failed: %s", ff_status_str(st)) : FF_OK;
}

/* Most of the way is gone on fewer samples: from a given start on the thin problem, then on the middle one. */
static ff_status approach(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                          ff_error *err)
{
    const struct ff_problem *const levels[2] = {o->start_shape ? p->thin : NULL, p->middle};
    ff_solution solution;
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    ff_status st = at_bound ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (int k = 0; k < 2 && !st; k++)
        if (levels[k]) st = ff_solve(l, levels[k], o, k == 1, 0, FF_ROUGH, 100, shape, channel, at_bound, &solution, err);
    free(at_bound);
    return st;
}

/* ---- the result
 * -------------------------------------------------------------------------------------------------------------------- */

static void warn(ff_fit_result *r, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
static void warn(ff_fit_result *r, const char *fmt, ...)
{
    if (r->n_warnings == FF_MAX_WARNINGS) return;
    va_list args;
    va_start(args, fmt);
    vsnprintf(r->warning[r->n_warnings++], FF_WARNING_LENGTH, fmt, args);
    va_end(args);
}

/* "f0 (r)" or "alpha_x" for a parameter of the fit. */
static void parameter_label(const ff_layout *l, const struct ff_problem *p, size_t k, char *out, size_t size)
{
    if (k < l->n_free) {
        snprintf(out, size, "%s", l->m->shape[l->index[k]].name);
        return;
    }
    const size_t c = (k - l->n_free) / l->m->n_channel, i = (k - l->n_free) % l->m->n_channel;
    if (l->n_channels > 1)
        snprintf(out, size, "%s (%.32s)", l->m->channel[i].name, p->channel_name[c]);
    else
        snprintf(out, size, "%s", l->m->channel[i].name);
}

static ff_fit_value *value_at(const ff_layout *l, ff_fit_result *r, size_t k)
{
    return k < l->n_free ? &r->shape_value[l->index[k]] : &r->channel_value[k - l->n_free];
}

static void fill_values(const ff_layout *l, const double *shape, const double *channel, const int *at_bound, ff_fit_result *r)
{
    for (uint32_t k = 0; k < l->m->n_shape; k++)
        r->shape_value[k] = (ff_fit_value){.value = shape[k], .std_error = NAN, .held = 1, .column = -1};
    for (size_t k = 0; k < l->n_channels * l->m->n_channel; k++)
        r->channel_value[k] = (ff_fit_value){.value = channel[k], .std_error = NAN, .column = -1};
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = value_at(l, r, k);
        v->held = 0;
        v->at_bound = at_bound[k];
    }
    for (uint32_t k = 0; k < l->n_free; k++) {
        if (!l->tied[k]) continue;
        ff_fit_value *y = &r->shape_value[l->index[k] + 1];
        *y = r->shape_value[l->index[k]];
        y->tied = 1;
    }
}

/* Standard errors and correlations of the parameters that are free and not on a bound. */
static ff_status fill_errors(const ff_layout *l, const struct ff_problem *p, const ff_normal *normal, const int *at_bound,
                             double *cov, ff_fit_result *r)
{
    const size_t P = l->P;
    int *use = malloc(2 * P * sizeof *use + 1), *determined = use + P;
    if (!use) return FF_ERR_MEMORY;
    for (size_t k = 0; k < P; k++) use[k] = at_bound[k] == 0;
    ff_status st = ff_covariance(l, normal, use, p->selection.weighting != FF_WEIGHT_SIGMA, p->n, cov, determined);
    size_t n = 0;
    for (size_t k = 0; k < P && !st; k++) {
        ff_fit_value *v = value_at(l, r, k);
        if (!determined[k]) continue;
        v->std_error = sqrt(cov[k * P + k]);
        v->column = (int)n++;
    }
    r->n_columns = n;
    r->correlation = st ? NULL : calloc(n * n + 1, sizeof *r->correlation);
    if (!st && !r->correlation) st = FF_ERR_MEMORY;
    for (size_t a = 0; a < P && !st; a++)
        for (size_t b = 0; b < P; b++) {
            const int i = value_at(l, r, a)->column, j = value_at(l, r, b)->column;
            if (i < 0 || j < 0) continue;
            const double scale = sqrt(cov[a * P + a] * cov[b * P + b]);
            r->correlation[(size_t)i * n + (size_t)j] = a == b ? 1 : scale > 0 ? cov[a * P + b] / scale : 0;
        }
    for (uint32_t k = 0; k < l->n_free; k++)
        if (l->tied[k]) {
            r->shape_value[l->index[k] + 1].std_error = r->shape_value[l->index[k]].std_error;
            r->shape_value[l->index[k] + 1].column = r->shape_value[l->index[k]].column;
        }
    free(use);
    return st;
}

/* The ellipse of the first lobe's slopes; with covariances, also whether its direction means anything. */
static void fill_ellipse(const ff_layout *l, const double *shape, const double *cov, ff_fit_result *r)
{
    const ff_model *m = l->m;
    if (m->n_lobes == 0) return;
    ff_stretch s;
    ff_model_stretch(m, 0, shape, &s, NULL);
    const double xx = s.ax * s.ax, yy = s.ay * s.ay, xy = s.r * s.ax * s.ay, d = xx - yy, e = 2 * xy, D = hypot(d, e), T = xx + yy;
    ff_ellipse *o = &r->ellipse;
    r->has_ellipse = 1;
    o->alpha_major = sqrt(0.5 * (T + D));
    o->alpha_minor = D < T ? sqrt((xx * yy - xy * xy) / (0.5 * (T + D))) : 0;
    o->phi = D > 0 ? 0.5 * atan2(e, d) : 0;
    if (o->phi < 0) o->phi += 3.14159265358979323846;
    o->phi_std_error = NAN;
    o->phi_determined = 0;
    if (!cov || l->mode == FF_ISOTROPIC_MODE || !(D > 0)) return;
    /* gradients of d and e by alpha_x, alpha_y, r_xy, in the order of the free parameters */
    const double by[3][2] = {{2 * s.ax, 2 * s.r * s.ay}, {-2 * s.ay, 2 * s.r * s.ax}, {0, 2 * s.ax * s.ay}};
    double var_D = 0, var_phi = 0;
    for (uint32_t a = 0; a < l->n_free; a++)
        for (uint32_t b = 0; b < l->n_free; b++) {
            const uint32_t i = l->index[a], j = l->index[b];
            if (i > 2 || j > 2) continue;
            const double gDa = (d * by[i][0] + e * by[i][1]) / D, gDb = (d * by[j][0] + e * by[j][1]) / D;
            const double gpa = 0.5 * (d * by[i][1] - e * by[i][0]) / (D * D), gpb = 0.5 * (d * by[j][1] - e * by[j][0]) / (D * D);
            var_D += gDa * gDb * cov[a * l->P + b];
            var_phi += gpa * gpb * cov[a * l->P + b];
        }
    o->phi_determined = D > 2 * sqrt(fmax(var_D, 0));
    if (o->phi_determined) o->phi_std_error = sqrt(fmax(var_phi, 0));
}

static void fill_residual(const ff_normal *n, ff_fit_result *r)
{
    const double w = n->stat[FF_STAT_WEIGHT] > 0 ? n->stat[FF_STAT_WEIGHT] : 1;
    r->residual = (ff_residual){.objective = 0.5 * n->cost2,
                                .rmse = sqrt(n->stat[FF_STAT_PLAIN] / w),
                                .cosine_rmse = sqrt(n->stat[FF_STAT_COSINE] / w),
                                .log_rmse = sqrt(n->stat[FF_STAT_LOG] / w),
                                .cube_root_rmse = sqrt(n->stat[FF_STAT_CUBE_ROOT] / w),
                                .max_abs = n->stat[FF_STAT_MAX]};
}

static void fill_criteria(const struct ff_problem *p, size_t n_free, ff_fit_result *r)
{
    const double n = (double)(p->n * p->n_channels), q = 2 * r->residual.objective, k = (double)n_free;
    r->n_free = n_free;
    if (p->selection.weighting == FF_WEIGHT_SIGMA) {
        r->aic = q + 2 * k;
        r->bic = q + k * log(n);
    } else {
        const double likelihood = n * log(fmax(q / n, 1e-300));
        r->aic = likelihood + 2 * (k + 1);
        r->bic = likelihood + (k + 1) * log(n);
    }
}

/* Parameters of one channel (or the shape) that the data cannot tell apart. */
static void warn_correlated(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    char a[80], b[80];
    for (size_t i = 0; i < l->P; i++)
        for (size_t j = 0; j < i; j++) {
            const int x = value_at(l, r, i)->column, y = value_at(l, r, j)->column;
            if (x < 0 || y < 0) continue;
            const double c = r->correlation[(size_t)x * r->n_columns + (size_t)y];
            if (fabs(c) < 0.99) continue;
            parameter_label(l, p, i, a, sizeof a);
            parameter_label(l, p, j, b, sizeof b);
            warn(r, "%s and %s are correlated by %.4f: these data hardly tell them apart", b, a, c);
        }
}

/* One warning for all channels whose parameter k lies on the same bound. */
static void warn_channels_at_bound(const ff_layout *l, const struct ff_problem *p, uint32_t k, int bound, ff_fit_result *r)
{
    char names[120] = "";
    double value = 0;
    for (size_t c = 0; c < l->n_channels; c++) {
        const ff_fit_value *v = &r->channel_value[c * l->m->n_channel + k];
        const size_t used = strlen(names);
        if (v->at_bound != bound) continue;
        value = v->value;
        snprintf(names + used, sizeof names - used, "%s%.32s", used ? ", " : "", p->channel_name[c]);
    }
    if (!names[0]) return;
    warn(r, "%s%s%s%s is on its %s bound, %g: no standard error there", l->m->channel[k].name, l->n_channels > 1 ? " (" : "",
         l->n_channels > 1 ? names : "", l->n_channels > 1 ? ")" : "", bound < 0 ? "lower" : "upper", value);
}

static void fill_warnings(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    char label[80];
    if (r->outcome == FF_LIMIT)
        warn(r, "stopped after %d iterations before it converged; --max-iterations allows more", r->iterations);
    if (r->outcome == FF_STALLED)
        warn(r, "the solver found no step that lowers the objective; the parameters may not be the best ones");
    for (size_t k = 0; k < l->P; k++) {
        const ff_fit_value *v = value_at(l, r, k);
        parameter_label(l, p, k, label, sizeof label);
        if (k < l->n_free && v->at_bound)
            warn(r, "%s is on its %s bound, %g", label, v->at_bound < 0 ? "lower" : "upper", v->value);
        if (!v->at_bound && r->correlation && isnan(v->std_error)) warn(r, "%s is not determined by these data", label);
    }
    for (uint32_t k = 0; k < l->m->n_channel; k++) {
        warn_channels_at_bound(l, p, k, -1, r);
        warn_channels_at_bound(l, p, k, +1, r);
    }
    if (r->correlation) warn_correlated(l, p, r);
    if (r->correlation && r->has_ellipse && l->mode != FF_ISOTROPIC_MODE && !r->ellipse.phi_determined)
        warn(r, "the two roughness axes differ by less than their error: the orientation is undetermined");
    if (p->selection.negative) warn(r, "%zu of the samples have negative values; they are kept as noise", p->selection.negative);
    const size_t n = p->n * p->n_channels;
    if (p->selection.weighting == FF_WEIGHT_SIGMA && n > l->P) {
        const double chi2 = 2 * r->residual.objective / (double)(n - l->P);
        if (chi2 > 2 || chi2 < 0.5)
            warn(r,
                 "chi^2 per degree of freedom is %.3g: the standard deviations of the data do not match the residuals, and the "
                 "standard errors follow them",
                 chi2);
    }
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The pass at the optimum with statistics and the outer products of the errors, unless the solver has made it already. */
static ff_status final_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                            const double *channel, ff_solution *solution)
{
    ff_pass pass;
    if (solution->has_final) return FF_OK;
    const ff_status st = ff_normal_new(l->m, l->n_free, l->n_channels, &solution->normal);
    if (st) return st;
    ff_layout_pass(l, p, o, shape, channel, &pass);
    pass.final = 1;
    solution->passes++;
    return ff_pass_run(&pass, 1, &solution->normal);
}

/* Everything that is said of the optimum. */
static ff_status finish(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                        const double *channel, const int *at_bound, ff_solution *solution, ff_fit_result *r, ff_error *err)
{
    double *cov = calloc(l->P * l->P + 1, sizeof *cov);
    ff_status st = cov ? final_pass(l, p, o, shape, channel, solution) : FF_ERR_MEMORY;
    size_t n_free = 0;
    for (size_t k = 0; k < l->P; k++) n_free += at_bound[k] == 0;
    if (!st) {
        r->outcome = solution->outcome;
        r->iterations = solution->iterations;
        r->passes = solution->passes;
        fill_values(l, shape, channel, at_bound, r);
        fill_residual(&solution->normal, r);
        fill_criteria(p, n_free, r);
        if (o->std_errors) st = fill_errors(l, p, &solution->normal, at_bound, cov, r);
    }
    if (!st) fill_ellipse(l, shape, o->std_errors ? cov : NULL, r);
    if (!st) fill_warnings(l, p, r);
    free(cov);
    return st ? ff_error_set(err, st, NULL, 0, -1, "the last pass failed: %s", ff_status_str(st)) : FF_OK;
}

/* What AUTO stands for. */
static ff_shape shape_of(const ff_model *m, const struct ff_problem *p, ff_shape asked, int mean_slope)
{
    if (asked != FF_SHAPE_AUTO) return asked;
    for (uint32_t k = 0; k < m->n_lobes; k++)
        if (ff_ndf_at(m->lobe[k].ndf)->term.claims & FF_ISOTROPIC) return FF_SHAPE_ISOTROPIC;
    return m->n_lobes == 0 || (p->selection.isotropic && !mean_slope) ? FF_SHAPE_ISOTROPIC : FF_SHAPE_CORRELATED;
}

static ff_status check_fit(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, ff_error *err)
{
    uint32_t have = 0;
    for (int k = 0; k < FF_G_COUNT; k++)
        if (p->geometry[k] >= 0) have |= 1u << k;
    for (uint32_t k = 0; k < l->m->n_lobes; k++) {
        const int isotropic = (ff_ndf_at(l->m->lobe[k].ndf)->term.claims & FF_ISOTROPIC) || l->mode == FF_ISOTROPIC_MODE;
        const uint32_t need = ff_model_planes(l->m, isotropic ? FF_ISOTROPIC_MODE : FF_CENTRED_MODE);
        if ((need & have) != need)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "the problem was not made for this model and shape: name them to ff_problem_new");
    }
    if (p->n * p->n_channels < l->P)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "%zu values (%zu samples of %zu channels) cannot determine %zu parameters", p->n * p->n_channels, p->n,
                            p->n_channels, l->P);
    if ((o->start_shape == NULL) != (o->start_channel == NULL))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a start needs both its shape and its channel parameters");
    if (o->start_shape) return ff_model_check(l->m, l->n_channels, o->start_shape, o->start_channel, err);
    return FF_OK;
}

ff_status ff_problem_fit(ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err)
{
    const double began = seconds();
    ff_status st = ff_fit_options_check(o, err);
    if (st) return st;
    const size_t C = p->n_channels, size = C * m->n_channel;
    ff_layout l;
    ff_fit_result r = {.model = *m, .n_channels = C, .shape = shape_of(m, p, o->shape, o->mean_slope)};
    st = ff_layout_init(m, C, r.shape, o->mean_slope, &l, err);
    if (!st) st = check_fit(&l, p, o, err);
    if (st) return st;
    l.m = &r.model;
    double shape[FF_MAX_SHAPE], *channel = calloc(size + 1, sizeof *channel);
    int *at_bound = calloc(l.P + 1, sizeof *at_bound);
    r.shape_value = calloc(m->n_shape + 1, sizeof *r.shape_value);
    r.channel_value = calloc(size + 1, sizeof *r.channel_value);
    ff_solution solution = {.outcome = FF_CONVERGED};
    if (!channel || !at_bound || !r.shape_value || !r.channel_value)
        st = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_model_defaults(m, C, shape, channel ? channel : NULL);
    if (!st && o->start_shape) {
        memcpy(shape, o->start_shape, m->n_shape * sizeof *shape);
        memcpy(channel, o->start_channel, size * sizeof *channel);
    } else if (!st)
        st = find_start(&l, p, o, shape, channel, err);
    if (!st) st = approach(&l, p, o, shape, channel, err);
    if (!st) st = ff_solve(&l, p, o, 1, 1, FF_EXACT, o->max_iterations, shape, channel, at_bound, &solution, err);
    if (!st) st = finish(&l, p, o, shape, channel, at_bound, &solution, &r, err);
    ff_normal_free(&solution.normal);
    free(channel);
    free(at_bound);
    if (st) {
        ff_fit_result_free(&r);
        return st;
    }
    r.time_s = seconds() - began;
    *out = r;
    return FF_OK;
}

void ff_fit_result_free(ff_fit_result *r)
{
    if (!r) return;
    free(r->shape_value);
    free(r->channel_value);
    free(r->correlation);
    memset(r, 0, sizeof *r);
}
