/* A problem whose residuals are in standard deviations of its data: a fit to it is the quasi-likelihood estimate (Carroll and
 * Ruppert 1988, chapter 2), whose scatter is the smallest where the noise is what it is taken for. */
#include "internal_noise.h"

#include <string.h>
#include <stdlib.h>

/* 1 / standard deviation of every residual of p, the whole or one of its smaller problems, instead of the weights that its samples
 * have: what a sample stands for stays. */
static ff_status find_factors(const ff_plan *plan, const ff_noise_found *noise, const struct ff_problem *p, float **out)
{
    const struct ff_problem *whole = plan->p;
    ff_point where = {.channel = noise->channel};
    float *factor = calloc(p->n_channels * p->n_blocks * FF_BLOCK, sizeof *factor);
    if (!factor) return FF_ERR_MEMORY;
    memcpy(where.shape, noise->shape, sizeof where.shape);
    const ff_status status = ff_noise_deviations(plan, p, &where, noise->noise, factor);
    for (size_t i = 0; i < p->n && !status; i++) {
        const size_t at = p == whole ? i : p->index[i];
        const double root = ff_problem_plane(whole, at / FF_BLOCK, whole->sample_weight)[at % FF_BLOCK];
        for (size_t c = 0; c < p->n_channels; c++) {
            float *f = &factor[c * p->n_blocks * FF_BLOCK + i];
            const double sd = (double)*f * root;
            *f = sd > 0 ? (float)(1 / sd) : 0;
        }
    }
    if (status)
        free(factor);
    else
        *out = factor;
    return status;
}

static void weigh(struct ff_problem *p, float *factor)
{
    free((float *)(uintptr_t)p->own_factor);
    ff_problem_by_factor(p, factor);
    p->own_factor = factor;
}

ff_status ff_problem_weigh_by_noise(ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_error *err)
{
    enum { MOST = 4 };
    ff_fit_options own;
    ff_plan plan;
    float *factor[MOST] = {NULL};
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (o->robust != FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "weights by the noise are of sums of squares, not of a robust loss");
    if (!fit->noise)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "the fit has found no noise to weigh by: what it leaves is rounding, or its errors rest on residuals");
    ff_status status = ff_plan_of_result(p, o, fit, &plan, err);
    if (status) return status;
    struct ff_problem *all[MOST] = {p, p->subsample, p->sparse != p->subsample ? p->sparse : NULL, p->middle};
    for (int k = 0; k < MOST && !status; k++)
        if (all[k]) status = find_factors(&plan, fit->noise, all[k], &factor[k]);
    ff_plan_free(&plan);
    for (int k = 0; k < MOST; k++) {
        if (status)
            free(factor[k]);
        else if (all[k])
            weigh(all[k], factor[k]);
    }
    if (status) return ff_error_set(err, status, NULL, 0, -1, "the weights by the noise were not found: %s", ff_status_str(status));
    if (p->subsample_linear != p->subsample) ff_problem_subsample_free(p->subsample_linear);
    p->subsample_linear = p->subsample; /* the loss is its own surrogate now */
    p->selection.weighting = FF_WEIGHT_NOISE;
    return FF_OK;
}
