/* A fit from beginning to end: search, approach over fewer samples, all samples, errors. */
#define _GNU_SOURCE /* clock_gettime */
#include "internal_arrow.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A problem that stands for another need not be minimised further than the two differ. */
#define FF_ROUGH 1e-7
#define FF_EXACT 1e-11

/* ---- from a search to a start ---------------------------------------------------------------- */

/* Candidates that are minimised: of a search along one parameter, and of one through several, where minima are more; and how many
 * optima of a stand-in lead on to the model. */
enum { FF_CANDIDATES_OF_ONE = 4, FF_CANDIDATES = 10, FF_OPTIMA = 3 };

/* A point that is minimised on the thin problem: shape and channel parameters, of the stand-in or of the model. */
typedef struct point {
    double cost2, shape[FF_MAX_SHAPE], *channel;
    ff_status status;
} point;

/* Several at once, each on its own thread. */
typedef struct polish {
    const ff_layout *l;
    const ff_standin *standin;
    const struct ff_problem *p;
    const ff_fit_options *o;
    const point *from; /* optima of the stand-in; NULL: `to` are candidates of it */
    point *to;
} polish;

static ff_status minimise(const polish *p, const ff_layout *l, point *at)
{
    ff_solution solution;
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    if (!at_bound) return FF_ERR_MEMORY;
    const ff_status s = ff_solve(l, p->p->thin, p->o, 0, 0, FF_ROUGH, 40, at->shape, at->channel, at_bound, &solution, NULL);
    if (!s) at->cost2 = solution.cost2;
    free(at_bound);
    return s;
}

static void polish_candidate(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_layout *l = &p->standin->layout;
    point *at = &p->to[i];
    (void)worker;
    ff_model_defaults(l->m, l->n_channels, NULL, at->channel);
    at->status = ff_start_channels(l, p->p, p->o, at->shape, at->channel, &at->cost2);
    if (!at->status) at->status = minimise(p, l, at);
}

/* From an optimum of the stand-in to one of the model, by the best of the ways between them. */
static void polish_optimum(void *context, size_t i, int worker)
{
    const polish *p = context;
    const ff_layout *l = p->l;
    const size_t size = l->n_channels * l->m->n_channel;
    point *at = &p->to[i];
    double *channel = malloc((size + 1) * sizeof *channel), cost2;
    (void)worker;
    at->cost2 = INFINITY;
    at->status = channel ? FF_OK : FF_ERR_MEMORY;
    for (uint32_t v = 0; v < ff_standin_variants(l) && !at->status; v++) {
        ff_standin_start(l, p->standin, v, p->from[i].shape, p->from[i].channel, at->shape, channel);
        at->status = ff_start_channels(l, p->p, p->o, at->shape, channel, &cost2);
        if (at->status || !(cost2 < at->cost2)) continue;
        at->cost2 = cost2;
        memcpy(at->channel, channel, size * sizeof *channel);
    }
    free(channel);
    if (!at->status) at->status = minimise(p, l, at);
}

/* Those that failed last. */
static int by_cost(const void *a, const void *b)
{
    const point *x = a, *y = b;
    if (!x->status != !y->status) return x->status ? 1 : -1;
    return x->status ? 0 : (x->cost2 > y->cost2) - (x->cost2 < y->cost2);
}

/* Best first; what ended in the same minimum once. Returns how many are left, at most max; the status when none is. */
static ff_status sort_points(point *points, size_t *n, size_t max)
{
    size_t kept = 0;
    if (*n == 0) return FF_ERR_INTERNAL;
    for (size_t i = 0; i < *n; i++)
        if (points[i].status == FF_ERR_CANCELLED || points[i].status == FF_ERR_MEMORY) return points[i].status;
    qsort(points, *n, sizeof *points, by_cost);
    if (points[0].status) return points[0].status;
    for (size_t i = 0; i < *n && kept < max && !points[i].status; i++) {
        if (kept && points[i].cost2 - points[kept - 1].cost2 <= 10 * FF_ROUGH * points[i].cost2) continue;
        const point here = points[i]; /* exchanged, since each has its own channel parameters */
        points[i] = points[kept];
        points[kept++] = here;
    }
    *n = kept;
    return FF_OK;
}

/* shape, channel: where to start on all samples. */
static ff_status find_start(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                            ff_error *err)
{
    ff_candidate candidate[FF_CANDIDATES];
    point points[FF_CANDIDATES], optima[FF_OPTIMA];
    ff_standin standin;
    size_t n = 0;
    const size_t size = l->n_channels * FF_MAX_CHANNEL_PARAMS; /* of either model */
    double *channels = calloc((FF_CANDIDATES + FF_OPTIMA) * size + 1, sizeof *channels);
    ff_status st = channels ? ff_standin_make(l, &standin) : FF_ERR_MEMORY;
    const size_t wanted = ff_start_searched(l) > 1 ? FF_CANDIDATES : FF_CANDIDATES_OF_ONE;
    if (!st) st = ff_start_search(&standin.layout, p, o, candidate, wanted, &n);
    if (!st) {
        for (size_t i = 0; i < n; i++) {
            memcpy(points[i].shape, candidate[i].shape, sizeof points[i].shape);
            points[i].channel = channels + i * size;
        }
        for (size_t i = 0; i < FF_OPTIMA; i++) optima[i].channel = channels + (FF_CANDIDATES + i) * size;
        polish work = {l, &standin, p, o, NULL, points};
        ff_pool_run(p->pool, n, polish_candidate, &work);
        st = sort_points(points, &n, FF_OPTIMA);
        const point *best = points;
        if (!st && !l->linear) {
            work.from = points;
            work.to = optima;
            ff_pool_run(p->pool, n, polish_optimum, &work);
            st = sort_points(optima, &n, 1);
            best = optima;
        }
        if (!st) {
            memcpy(shape, best->shape, l->m->n_shape * sizeof *shape);
            memcpy(channel, best->channel, l->n_channels * l->m->n_channel * sizeof *channel);
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

/* On all samples; should the lobes have changed places on the way, once more from there, which takes a pass. */
ff_status ff_solve_in_order(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                            int *at_bound, ff_solution *solution, ff_error *err)
{
    (void)ff_layout_order(l, shape, channel);
    ff_status st = ff_solve(l, p, o, 1, 1, FF_EXACT, o->max_iterations, shape, channel, at_bound, solution, err);
    if (st || !ff_layout_order(l, shape, channel)) return st;
    const ff_solution first = *solution;
    ff_normal_free(&solution->normal);
    *solution = (ff_solution){.outcome = FF_CONVERGED};
    st = ff_solve(l, p, o, 1, 0, FF_EXACT, o->max_iterations, shape, channel, at_bound, solution, err);
    solution->iterations += first.iterations;
    solution->passes += first.passes;
    return st;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* The pass at the optimum with statistics and the outer products of the errors, unless the solver has made it already. */
static ff_status final_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                            const double *channel, const int *at_bound, ff_solution *solution)
{
    ff_pass pass;
    if (solution->has_final) return FF_OK;
    if (l->arrow) return ff_arrow_finish(l, p, o, shape, channel, at_bound, solution);
    ff_status st = ff_normal_new(l, &solution->normal);
    if (!st) st = ff_layout_pass(l, p, o, shape, channel, &pass);
    if (st) return st;
    solution->has_final = 1;
    pass.final = 1;
    solution->passes++;
    st = ff_pass_run(&pass, 1, &solution->normal);
    ff_pass_free(&pass);
    return st ? st : ff_normal_fold(l, &solution->normal);
}

static ff_status check_fit(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, ff_error *err)
{
    uint32_t have = 0;
    for (int k = 0; k < FF_G_COUNT; k++)
        if (p->geometry[k] >= 0) have |= 1u << k;
    const uint32_t need = ff_model_planes(l->m, l->mode);
    if ((need & have) != need)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the problem was not made for this model and shape: name them to ff_problem_new");
    for (uint32_t k = 0; k < l->m->n_lobes; k++)
        if (ff_ndf_at(l->m->lobe[k].ndf)->needs_values && !l->m->lobe[k].table)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s needs the table of its profile",
                                ff_ndf_at(l->m->lobe[k].ndf)->term.name);
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
    ff_fit_result r = {.model = *m, .n_channels = C, .shape = ff_layout_shape(m, p->selection.isotropic, o->shape, o->mean_slope)};
    ff_ties ties;
    ff_extras *extras = NULL;
    st = ff_constraints_apply(o->constraints, r.shape, &r.model, &ties, err);
    if (!st) st = ff_layout_init(&r.model, C, r.shape, o->mean_slope, &l, err);
    if (!st && ties.n) ff_layout_tie(&l, &ties);
    if (!st) st = check_fit(&l, p, o, err);
    if (st) return st;
    if (o->robust != FF_ROBUST_NONE && o->robust_scale == 0 && !p->unit) st = ff_problem_estimate_scale(p, m, o, err);
    if (st) return st;
    double shape[FF_MAX_SHAPE], *channel = calloc(size + 1, sizeof *channel);
    int *at_bound = calloc(l.P + 1, sizeof *at_bound);
    r.shape_value = calloc(m->n_shape + 1, sizeof *r.shape_value);
    r.channel_value = calloc(size + 1, sizeof *r.channel_value);
    ff_solution solution = {.outcome = FF_CONVERGED};
    if (!channel || !at_bound || !r.shape_value || !r.channel_value)
        st = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!st && ff_extras_new(o->constraints, &l, r.shape, &extras))
        st = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    l.extras = extras;
    ff_layout_many(&l, o->dense_channels);
    ff_fit_options solving = *o; /* the weight of a prior needs the errors of the data */
    solving.std_errors |= extras != NULL;
    if (channel) ff_layout_defaults(&l, shape, channel);
    if (!st && o->start_shape) {
        memcpy(shape, o->start_shape, m->n_shape * sizeof *shape);
        memcpy(channel, o->start_channel, size * sizeof *channel);
        if (o->constraints) ff_layout_project(&l, shape, channel);
    } else if (!st)
        st = find_start(&l, p, o, shape, channel, err);
    if (!st) st = approach(&l, p, &solving, shape, channel, err);
    if (!st) st = ff_solve_in_order(&l, p, &solving, shape, channel, at_bound, &solution, err);
    if (!st) {
        st = final_pass(&l, p, &solving, shape, channel, at_bound, &solution);
        if (st) ff_error_set(err, st, NULL, 0, -1, "the last pass failed: %s", ff_status_str(st));
    }
    if (!st && extras) st = ff_extras_solve(extras, &l, p, &solving, shape, channel, at_bound, &solution, err);
    if (!st) {
        st = final_pass(&l, p, &solving, shape, channel, at_bound, &solution);
        if (!st) st = ff_result_fill(&l, p, o, shape, channel, at_bound, &solution, &r);
        if (st) ff_error_set(err, st, NULL, 0, -1, "the last pass failed: %s", ff_status_str(st));
    }
    ff_normal_free(&solution.normal);
    ff_arrow_free(solution.arrow);
    free(channel);
    free(at_bound);
    ff_extras_free(extras);
    if (st) {
        ff_fit_result_free(&r);
        return st;
    }
    r.time_s = seconds() - began;
    *out = r;
    return FF_OK;
}
