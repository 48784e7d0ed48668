/* A fit from beginning to end: search, approach over fewer samples, all samples, errors. */
#define _GNU_SOURCE /* clock_gettime */
#include "internal_fit.h"
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* A problem that stands for another need not be minimised further than the two differ. */
#define FF_ROUGH 1e-7
#define FF_EXACT 1e-11

/* ---- from a search to a start ---------------------------------------------------------------- */

/* Candidates that are minimised: of a search along one parameter, and of one through several, where minima are more. */
enum { FF_CANDIDATES_OF_ONE = 4, FF_CANDIDATES = 10 };

/* Candidates that are minimised on the thin problem, each on its own thread. */
typedef struct polish {
    const ff_layout *l;
    const ff_standin *standin;
    const struct ff_problem *p;
    const ff_fit_options *o;
    const ff_candidate *candidate;        /* of the stand-in                     */
    double (*shape)[FF_MAX_SHAPE];        /* [candidates]                        */
    double *channel, *from;               /* [candidates][size + 1] each         */
    double *cost2;                        /* [candidates]                        */
    ff_status *status;                    /* [candidates]                        */
    size_t size;                          /* doubles of channel parameters       */
} polish;

/* The best of the ways from the stand-in's optimum to channel parameters of the model. */
static ff_status start_best_variant(const polish *p, size_t i, const double *from, double *cost2)
{
    double *channel = p->channel + i * (p->size + 1), *shape = p->shape[i];
    const uint32_t variants = ff_standin_variants(p->l);
    ff_standin_start(p->l, p->standin, 0, p->candidate[i].shape, from, shape, channel);
    if (p->l->linear) return FF_OK;
    ff_status s = ff_start_channels(p->l, p->p, p->o, shape, channel, cost2);
    double *other = variants > 1 ? malloc((p->size + 1) * sizeof *other) : NULL;
    if (variants > 1 && !other) return FF_ERR_MEMORY;
    for (uint32_t v = 1; v < variants && !s; v++) {
        double cost;
        ff_standin_start(p->l, p->standin, v, p->candidate[i].shape, from, shape, other);
        s = ff_start_channels(p->l, p->p, p->o, shape, other, &cost);
        if (s || !(cost < *cost2)) continue;
        *cost2 = cost;
        memcpy(channel, other, p->size * sizeof *channel);
    }
    free(other);
    return s;
}

/* From the optimum of the stand-in's channel parameters to that of all of the model's. */
static ff_status polish_candidate(const polish *p, size_t i, int *at_bound)
{
    double *channel = p->channel + i * (p->size + 1), *from = p->from + i * (p->size + 1), *shape = p->shape[i], cost2;
    const double *from_shape = p->candidate[i].shape;
    ff_solution solution;
    ff_model_defaults(&p->standin->model, p->l->n_channels, NULL, from);
    ff_status s = ff_start_channels(&p->standin->layout, p->p, p->o, from_shape, from, &cost2);
    if (s) return s;
    s = start_best_variant(p, i, from, &cost2);
    if (!s) s = ff_solve(p->l, p->p->thin, p->o, 0, 0, FF_ROUGH, 40, shape, channel, at_bound, &solution, NULL);
    if (!s) p->cost2[i] = solution.cost2;
    return s;
}

static void polish_one(void *context, size_t i, int worker)
{
    const polish *p = context;
    int *at_bound = malloc((p->l->P + 1) * sizeof *at_bound);
    (void)worker;
    p->status[i] = at_bound ? polish_candidate(p, i, at_bound) : FF_ERR_MEMORY;
    free(at_bound);
}

/* shape, channel: where to start on all samples. */
static ff_status find_start(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                            ff_error *err)
{
    ff_candidate candidate[FF_CANDIDATES];
    double shapes[FF_CANDIDATES][FF_MAX_SHAPE], cost2[FF_CANDIDATES];
    ff_status status[FF_CANDIDATES] = {FF_OK};
    ff_standin standin;
    ff_status st = ff_standin_make(l, &standin);
    size_t n = 0;
    const size_t size = l->n_channels * FF_MAX_CHANNEL_PARAMS; /* of either model */
    double *channels = calloc(2 * FF_CANDIDATES * (size + 1), sizeof *channels);
    if (!channels) st = FF_ERR_MEMORY;
    const size_t wanted = ff_start_searched(l) > 1 ? FF_CANDIDATES : FF_CANDIDATES_OF_ONE;
    if (!st) st = ff_start_search(&standin.layout, p, o, candidate, wanted, &n);
    if (!st) {
        polish work = {l, &standin, p, o, candidate, shapes, channels, channels + FF_CANDIDATES * (size + 1), cost2, status, size};
        ff_pool_run(p->pool, n, polish_one, &work);
        size_t best = n;
        for (size_t i = 0; i < n; i++) {
            if (status[i] == FF_ERR_CANCELLED || status[i] == FF_ERR_MEMORY) st = status[i];
            if (!status[i] && (best == n || cost2[i] < cost2[best])) best = i;
        }
        if (!st && best == n) st = n ? status[0] : FF_ERR_INTERNAL;
        if (!st) {
            memcpy(shape, shapes[best], l->m->n_shape * sizeof *shape);
            memcpy(channel, channels + best * (size + 1), l->n_channels * l->m->n_channel * sizeof *channel);
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
static ff_status solve_in_order(const ff_layout *l, struct ff_problem *p, const ff_fit_options *o, double *shape, double *channel,
                                int *at_bound, ff_solution *solution, ff_error *err)
{
    (void)ff_lobes_order(l->m, l->n_channels, shape, channel);
    ff_status st = ff_solve(l, p, o, 1, 1, FF_EXACT, o->max_iterations, shape, channel, at_bound, solution, err);
    if (st || !ff_lobes_order(l->m, l->n_channels, shape, channel)) return st;
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
                            const double *channel, ff_solution *solution)
{
    ff_pass pass;
    if (solution->has_final) return FF_OK;
    ff_status st = ff_normal_new(l, &solution->normal);
    if (!st) st = ff_layout_pass(l, p, o, shape, channel, &pass);
    if (st) return st;
    pass.final = 1;
    solution->passes++;
    st = ff_pass_run(&pass, 1, &solution->normal);
    ff_pass_free(&pass);
    return st;
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
    ff_layout_defaults(&l, shape, channel);
    if (!st && o->start_shape) {
        memcpy(shape, o->start_shape, m->n_shape * sizeof *shape);
        memcpy(channel, o->start_channel, size * sizeof *channel);
    } else if (!st)
        st = find_start(&l, p, o, shape, channel, err);
    if (!st) st = approach(&l, p, o, shape, channel, err);
    if (!st) st = solve_in_order(&l, p, o, shape, channel, at_bound, &solution, err);
    if (!st) {
        st = final_pass(&l, p, o, shape, channel, &solution);
        if (!st) st = ff_result_fill(&l, p, o, shape, channel, at_bound, &solution, &r);
        if (st) ff_error_set(err, st, NULL, 0, -1, "the last pass failed: %s", ff_status_str(st));
    }
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
