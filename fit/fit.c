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
    const ff_status st = ff_normal_new(l->m, l->n_free, l->n_channels, &solution->normal);
    if (st) return st;
    ff_layout_pass(l, p, o, shape, channel, &pass);
    pass.final = 1;
    solution->passes++;
    return ff_pass_run(&pass, 1, &solution->normal);
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
