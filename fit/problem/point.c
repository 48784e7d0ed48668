/* Where a fit is. */
#include "internal_problem.h"
#include <stdlib.h>
#include <string.h>

static size_t channel_size(const ff_layout *l)
{
    return l->n_channels * l->m->n_channel;
}

ff_status ff_point_new(const ff_plan *plan, ff_point *out)
{
    ff_point at = {.outcome = FF_CONVERGED};
    at.channel = calloc(channel_size(&plan->l) + 1, sizeof *at.channel);
    at.at_bound = calloc(plan->l.P + 1, sizeof *at.at_bound);
    if (!at.channel || !at.at_bound) {
        ff_point_free(&at);
        return FF_ERR_MEMORY;
    }
    ff_layout_defaults(&plan->l, at.shape, at.channel);
    *out = at;
    return FF_OK;
}

void ff_point_forget(ff_point *at)
{
    ff_normal_free(&at->normal);
    free(at->information);
    at->information = NULL;
    at->has_final = 0;
}

void ff_point_free(ff_point *at)
{
    ff_point_forget(at);
    free(at->noise);
    at->noise = NULL;
    free(at->channel);
    free(at->at_bound);
    at->channel = NULL;
    at->at_bound = NULL;
}

void ff_point_set(const ff_plan *plan, const double *shape, const double *channel, ff_point *at)
{
    memcpy(at->shape, shape, plan->l.m->n_shape * sizeof *shape);
    memcpy(at->channel, channel, channel_size(&plan->l) * sizeof *channel);
}

ff_status ff_point_of_result(const ff_plan *plan, const ff_fit_result *fit, ff_point *out)
{
    const ff_status status = ff_point_new(plan, out);
    if (status) return status;
    for (uint32_t k = 0; k < fit->model.n_shape; k++) out->shape[k] = fit->shape_value[k].value;
    for (size_t k = 0; k < channel_size(&plan->l); k++) out->channel[k] = fit->channel_value[k].value;
    for (size_t k = 0; k < plan->l.P; k++)
        out->at_bound[k] =
            ff_layout_is_fixed(&plan->l, k) ? -1 : ff_result_value(&plan->l, (ff_fit_result *)(uintptr_t)fit, k)->at_bound;
    return FF_OK;
}

ff_status ff_point_pass(const ff_plan *plan, ff_point *at)
{
    ff_pass pass;
    ff_point_forget(at);
    ff_status status = ff_layout_normal(&plan->l, &at->normal);
    if (!status) status = ff_plan_pass(plan, at->shape, at->channel, &pass);
    if (status) return status;
    pass.final = 1;
    at->passes++;
    status = ff_pass_run(&pass, 1, &at->normal);
    ff_pass_free(&pass);
    if (!status) status = ff_normal_fold(&plan->l, &at->normal);
    at->has_final = !status;
    return status;
}
