/* Errors of a fit from the noise of its data: H^-1 J' S J H^-1. */
#include "internal_noise.h"
#include "base/internal_statistics.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* J' S J in the layout of H, on the samples that noise is estimated on: where they stand for more of them, these are as many
 * independent values, and a score with the weight of k counts k of them and not k^2. */
static ff_status scores(const ff_plan *plan, const ff_point *at, float *deviation, ff_gram *out)
{
    const struct ff_problem *whole = plan->p, *p = whole->sparse;
    const ff_plan search = ff_plan_on(plan, p);
    const size_t stride = p->n_blocks * FF_BLOCK;
    ff_normal n = {0};
    ff_pass pass;
    for (size_t i = 0; i < p->n && p->n < whole->n; i++) {
        const float few = (float)(1 / sqrt(ff_problem_stands_for(p, whole, i)));
        for (size_t c = 0; c < p->n_channels; c++) deviation[c * stride + i] *= few;
    }
    ff_status status = ff_layout_normal(&plan->l, &n);
    if (!status) status = ff_plan_pass(&search, at->shape, at->channel, &pass);
    if (status) {
        ff_normal_free(&n);
        return status;
    }
    pass.deviation = deviation;
    pass.errors = 0;
    status = ff_pass_run(&pass, 1, &n);
    ff_pass_free(&pass);
    if (!status) status = ff_gram_new(&plan->l, out);
    if (!status) ff_gram_fill(&plan->l, &n, NULL, out);
    ff_normal_free(&n);
    return status;
}

/* Two estimates of a variance: that of the noise model, which many values agree on, and that of the residuals themselves, which
 * knows nothing of a model but rests on the N values that carry the parameter. The model counts as so many values, or half of
 * those that it was estimated from (an empirical Bayes estimate in the manner of Smyth 2004). */
#define PRIOR_VALUES 60.0

/* Degrees of freedom of a variance from its relative scatter: 2 / that of its logarithm (Satterthwaite 1946). */
static double degrees_of(double sway, double values)
{
    return fmax(fmin(2 / fmax(sway, 1e-6), values), 3);
}

/* values: those that the fit leaves for the noise. Of the parameters, from the covariance by the noise as if all values were
 * independent, which info has: errors that go together, moderated by the residuals, and what priors add, which is known. before
 * [P]: the variances by the residuals of all samples and their clusters. */
static void moderate(const ff_plan *plan, const ff_carriers *c, const double *before, double values, ff_information *info,
                     double *factor)
{
    const int all_seen = plan->p->sparse->n == plan->p->n;
    for (size_t k = 0; k < info->P; k++) {
        const double all = info->variance[k], data = plan->penalties ? fmin(c->error[k] * c->error[k], all) : all,
                     prior = all - data, N = c->number[k], together = c->along[k] * c->along[k] * c->between[k] * c->between[k],
                     by_noise = data * together,
                     by_residuals = all_seen ? c->hc2[k] * c->hc2[k] * together : fmax(before[k] - prior, 0);
        const double of_noise = degrees_of(c->sway[k], values), of_residuals = fmax(fmin(N, info->dof[k]), 1),
                     V = fmin(PRIOR_VALUES, values / 2), W = V + N;
        factor[k] = 1;
        if (!(all > 0)) continue;
        factor[k] = sqrt(((V * by_noise + N * by_residuals) / W + prior) / all);
        info->dof[k] = W * W / (V * V / of_noise + N * N / of_residuals) / info->of_data[k];
    }
    ff_information_multiply(info, factor);
}

/* With room for the carriers. */
static ff_status errors_of(const ff_plan *plan, const ff_point *at, const ff_noise_found *found, ff_information *info,
                           ff_carriers *c, float *deviation, double *factor, double *before)
{
    const struct ff_problem *p = plan->p, *few = p->sparse;
    ff_point where = {.channel = found->channel};
    ff_gram M = {.local = NULL};
    memcpy(where.shape, found->shape, sizeof where.shape);
    memcpy(before, info->variance, info->P * sizeof *before);
    ff_status status = ff_noise_deviations(plan, few, &where, found->noise, deviation);
    if (!status) status = ff_carriers_find(plan, at, found->noise, deviation, info, c);
    if (!status) status = scores(plan, at, deviation, &M);
    if (!status) status = ff_information_from_scores(info, plan, &M);
    for (size_t k = 0; k < info->P && !status && few->n < p->n; k++)
        c->along[k] = sqrt(fmax((double)(p->n * p->n_channels) / info->effective, 1));
    const double values = (double)(few->n * few->n_channels), left = values - (double)info->P;
    if (!status) moderate(plan, c, before, fmax(left, 1), info, factor);
    ff_gram_free(&M);
    return status;
}

ff_status ff_noise_errors(const ff_plan *plan, const ff_point *at, const ff_noise_found *found, ff_information *info,
                          ff_carriers *carriers)
{
    const struct ff_problem *p = plan->p;
    const size_t P = plan->l.P, values = p->n_channels * p->sparse->n_blocks * FF_BLOCK;
    float *deviation = malloc(values * sizeof *deviation);
    double *memory = malloc(((FF_CARRIER_ARRAYS + 2) * P + 1) * sizeof *memory);
    ff_status status = deviation && memory ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        ff_carriers own;
        ff_carriers_lay_out(memory + 2 * P, P, &own);
        status = errors_of(plan, at, found, info, carriers ? carriers : &own, deviation, memory, memory + P);
    }
    free(deviation);
    free(memory);
    return status;
}

/* ---- the difference to a part ------------------------------------------------------------------ */

/* A point for the searched samples, with a pass there and the information. */
static ff_status look_there(const ff_plan *plan, const ff_point *from, ff_point *at, ff_information **info)
{
    ff_status status = ff_point_new(plan, at);
    if (status) return status;
    ff_point_set(plan, from->shape, from->channel, at);
    memcpy(at->at_bound, from->at_bound, plan->l.P * sizeof *at->at_bound);
    status = ff_point_pass(plan, at);
    return status ? status : ff_information_new(plan, &at->normal, at->at_bound, info);
}

/* The noise that the part shows by itself, with the rest left out: where the rest goes wrong, what it leaves is no noise, and would
 * hide that it does. *out: of the whole fit, copied, where it was given, or where the part shows none. */
static ff_status noise_of_part(const ff_plan *plan, const ff_point *at, const ff_noise_found *found, struct ff_problem *few,
                               ff_noise_found **out)
{
    struct ff_problem within = *plan->p;
    const ff_plan on = ff_plan_on(plan, &within);
    within.sparse = few;
    *out = NULL;
    const ff_status status = plan->noise ? FF_OK : ff_noise_find(&on, at, out);
    if (status || *out) return status;
    *out = ff_noise_found_copy(found);
    return *out ? FF_OK : FF_ERR_MEMORY;
}

ff_status ff_noise_difference(const ff_plan *plan, const ff_point *at, const ff_noise_found *found, const float *part, double *out,
                              double *dof)
{
    const struct ff_problem *whole = plan->p, *search = whole->sparse;
    struct ff_problem few = *search;
    const size_t size = search->n_blocks * FF_BLOCK, P = plan->l.P;
    float *multiplier = calloc(size, sizeof *multiplier), *deviation = malloc(search->n_channels * size * sizeof *deviation);
    double *memory = malloc((FF_CARRIER_ARRAYS * P + 1) * sizeof *memory);
    ff_plan all = ff_plan_on(plan, search), of_part = ff_plan_on(plan, &few);
    ff_point there = {0}, in_part = {0};
    ff_information *info = NULL, *info_part = NULL;
    ff_noise_found *noise = NULL;
    ff_carriers c;
    ff_status status = multiplier && deviation && memory ? FF_OK : FF_ERR_MEMORY;
    all.errors = of_part.errors = 0;
    for (size_t i = 0; i < search->n && !status; i++) multiplier[i] = part[search->index[i]];
    few.multiplier = multiplier;
    if (!status) status = look_there(&all, at, &there, &info);
    if (!status) status = look_there(&of_part, at, &in_part, &info_part);
    if (!status) status = noise_of_part(plan, at, found, &few, &noise);
    if (!status) {
        ff_point where = {.channel = noise->channel};
        memcpy(where.shape, noise->shape, sizeof where.shape);
        status = ff_noise_deviations(plan, search, &where, noise->noise, deviation);
    }
    if (!status) {
        ff_carriers_lay_out(memory, P, &c);
        status = ff_carriers_of_difference(plan, at, noise->noise, deviation, info, info_part, part, &c);
    }
    free(noise);
    for (size_t k = 0; k < P && !status; k++) {
        out[k] = c.error[k] * c.along[k] * c.between[k];
        dof[k] = degrees_of(c.sway[k], (double)(search->n * search->n_channels));
    }
    free(info);
    free(info_part);
    ff_point_free(&there);
    ff_point_free(&in_part);
    free(multiplier);
    free(deviation);
    free(memory);
    return status;
}
