/* A fit from beginning to end. The request becomes a plan, once; then a point goes through the stages: start, minimise, errors,
 * what is known besides the data, result. */
#define _GNU_SOURCE /* clock_gettime */
#include "fit/errors/internal_errors.h"
#include "fit/minimise/internal_minimise.h"
#include "fit/result/internal_result.h"
#include "fit/start/internal_start.h"
#include "internal_stages.h"
#include <time.h>

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static ff_status last_pass(const ff_plan *plan, ff_point *at, ff_error *err)
{
    const ff_status status = ff_errors(plan, at);
    return status ? ff_error_set(err, status, NULL, 0, -1, "the last pass failed: %s", ff_status_str(status)) : FF_OK;
}

/* From the defaults to a finished result. errors: they are to be said, and not only made for the weights of priors. */
static ff_status stages(ff_plan *plan, ff_point *at, int errors, ff_fit_result *r, ff_error *err)
{
    ff_status status = ff_start(plan, at, err);
    if (!status) status = ff_minimise(plan, at, err);
    if (!status) status = last_pass(plan, at, err);
    if (!status) status = ff_penalised_solve(plan, at, err);
    if (status) return status;
    status = ff_result_fill(plan, at, errors, r);
    return status ? ff_error_set(err, status, NULL, 0, -1, "the last pass failed: %s", ff_status_str(status)) : FF_OK;
}

ff_status ff_fit_run(const struct ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err)
{
    const double began = seconds();
    ff_plan plan;
    ff_point at = {.outcome = FF_CONVERGED};
    ff_fit_result r = {.n_channels = 0};
    ff_status status = ff_plan_new(p, m, o, &plan, err);
    if (status) return status;
    if (ff_point_new(&plan, &at) || ff_result_new(&plan, &r))
        status = ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!status) status = stages(&plan, &at, o->std_errors, &r, err);
    ff_point_free(&at);
    ff_plan_free(&plan);
    if (status) {
        ff_fit_result_clear(&r);
        return status;
    }
    r.time_s = seconds() - began;
    *out = r;
    return FF_OK;
}
