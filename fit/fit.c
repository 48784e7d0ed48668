/* A fit from beginning to end: search, approach over fewer samples, all samples, errors. */
#define _GNU_SOURCE /* clock_gettime */
#include "fit/errors/internal_arrow.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* How far all samples are minimised. */
#define FF_EXACT 1e-11

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
    ff_limits *limits = NULL;
    st = ff_constraints_apply(o->constraints, r.shape, &r.model, &ties, err);
    if (!st) st = ff_layout_init(&r.model, C, r.shape, o->mean_slope, &l, err);
    if (!st && ties.n) ff_layout_tie(&l, &ties);
    if (!st) st = check_fit(&l, p, o, err);
    if (!st && o->robust != FF_ROBUST_NONE && o->robust_scale == 0 && !p->unit) st = ff_problem_estimate_scale(p, m, o, err);
    if (!st) st = ff_limits_of(o->constraints, p, &r.model, &ties, &limits, err);
    if (st) return st;
    l.limits = limits;
    double shape[FF_MAX_SHAPE], *channel = calloc(size + 1, sizeof *channel);
    int *at_bound = calloc(l.P + 1, sizeof *at_bound);
    r.shape_value = calloc(m->n_shape + 1, sizeof *r.shape_value);
    r.channel_value = calloc(size + 1, sizeof *r.channel_value);
    ff_solution solution = {.outcome = FF_CONVERGED};
    if (!channel || !at_bound || !r.shape_value || !r.channel_value)
        st = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!st) st = ff_extras_new(o->constraints, &l, p, r.shape, &extras, err);
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
        st = ff_search(&l, p, o, shape, channel, err);
    if (!st) st = ff_approach(&l, p, &solving, shape, channel, err);
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
    ff_limits_free(limits);
    if (st) {
        ff_fit_result_free(&r);
        return st;
    }
    r.time_s = seconds() - began;
    *out = r;
    return FF_OK;
}
