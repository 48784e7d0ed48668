/* A fit from beginning to end. The request becomes a plan, once; then a point goes through the stages: start, minimise, errors,
 * what is known besides the data, result. */
#define _GNU_SOURCE /* clock_gettime */
#include "fit/errors/internal_errors.h"
#include "fit/minimise/internal_minimise.h"
#include "fit/noise/internal_noise.h"
#include "fit/result/internal_result.h"
#include "fit/start/internal_start.h"
#include "internal_stages.h"
#include <stdlib.h>
#include <stdio.h>
#include <time.h>

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static ff_status last_pass(const ff_plan *plan, ff_point *at, ff_error *err)
{
    const ff_status st = ff_errors(plan, at);
    return st ? ff_error_set(err, st, NULL, 0, -1, "the last pass failed: %s", ff_status_str(st)) : FF_OK;
}

/* The noise of the data, and the errors that follow from it. */
static ff_status take_noise(const ff_plan *plan, ff_point *at, ff_error *err)
{
    ff_point where;
    ff_noise *noise = NULL;
    if (plan->p->selection.weighting == FF_WEIGHT_SIGMA || plan->robust != FF_ROBUST_NONE || getenv("FF_NO_NOISE")) return FF_OK;
    ff_status st = ff_point_new(plan, &where);
    if (st) return st;
    st = ff_noise_estimate(plan, at, &where, &noise, err);
    if (!st && noise) st = ff_noise_errors(plan, at, &where, noise, at->information);
    if (noise && getenv("FF_SHOW_NOISE")) printf("noise a %g b %g c %g p %g q %g rho1 %g between %g\n", sqrt(noise->level[0].constant), noise->level[0].linear, sqrt(noise->level[0].square), noise->cos_i, noise->cos_o, noise->along_scan[1], noise->between_channels);
    ff_noise_free(noise);
    ff_point_free(&where);
    return st;
}

/* From the defaults to a finished result. errors: they are to be said, and not only made for the weights of priors. */
static ff_status stages(ff_plan *plan, ff_point *at, int errors, ff_fit_result *r, ff_error *err)
{
    ff_status st = ff_start(plan, at, err);
    if (!st) st = ff_minimise(plan, at, err);
    if (!st) st = last_pass(plan, at, err);
    if (!st) st = ff_penalised_solve(plan, at, err);
    if (!st && errors) st = take_noise(plan, at, err);
    if (st) return st;
    st = ff_result_fill(plan, at, errors, r);
    return st ? ff_error_set(err, st, NULL, 0, -1, "the last pass failed: %s", ff_status_str(st)) : FF_OK;
}

ff_status ff_fit_run(const struct ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err)
{
    const double began = seconds();
    ff_plan plan;
    ff_point at = {.outcome = FF_CONVERGED};
    ff_fit_result r = {.n_channels = 0};
    ff_status st = ff_plan_new(p, m, o, &plan, err);
    if (st) return st;
    if (ff_point_new(&plan, &at) || ff_result_new(&plan, &r)) st = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!st) st = stages(&plan, &at, o->std_errors, &r, err);
    ff_point_free(&at);
    ff_plan_free(&plan);
    if (st) {
        ff_fit_result_clear(&r);
        return st;
    }
    r.time_s = seconds() - began;
    *out = r;
    return FF_OK;
}
