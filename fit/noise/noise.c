/* The noise that a fit has: given, or found; what is kept of it. */
#include "internal_noise.h"
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

void ff_carriers_lay_out(double *memory, size_t P, ff_carriers *out)
{
    double **const array[FF_CARRIER_ARRAYS] = {&out->number, &out->error, &out->hc2,    &out->hc3,
                                               &out->sway,   &out->along, &out->between};
    for (size_t k = 0; k < FF_CARRIER_ARRAYS; k++) *array[k] = memory + k * P;
}

int ff_noise_is_wanted(const ff_plan *plan)
{
    if (plan->by_residuals || plan->robust != FF_ROBUST_NONE) return 0;
    return plan->noise || plan->p->selection.weighting != FF_WEIGHT_SIGMA;
}

static ff_noise_found *keep(const ff_plan *plan, const ff_point *where, const ff_noise *noise)
{
    const size_t P = plan->l.P, channel = plan->l.n_channels * plan->l.m->n_channel, doubles = channel + FF_CARRIER_ARRAYS * P,
                 bytes = sizeof(ff_noise_found) + doubles * sizeof(double) + sizeof *noise + noise->n_levels * sizeof *noise->level;
    ff_noise_found *f = calloc(1, bytes);
    if (!f) return NULL;
    f->bytes = bytes;
    f->channel = (double *)(f + 1);
    ff_carriers_lay_out(f->channel + channel, P, &f->carriers);
    f->noise = (ff_noise *)(f->channel + doubles);
    memcpy(f->shape, where->shape, sizeof f->shape);
    memcpy(f->channel, where->channel, channel * sizeof *f->channel);
    memcpy(f->noise, noise, sizeof *noise + noise->n_levels * sizeof *noise->level);
    return f;
}

static void *moved(const ff_noise_found *from, ff_noise_found *to, const void *inside)
{
    return (char *)to + ((const char *)inside - (const char *)from);
}

ff_noise_found *ff_noise_found_copy(const ff_noise_found *found)
{
    ff_noise_found *f = found ? malloc(found->bytes) : NULL;
    if (!f) return NULL;
    memcpy(f, found, found->bytes);
    f->channel = moved(found, f, found->channel);
    f->noise = moved(found, f, found->noise);
    double **const array[FF_CARRIER_ARRAYS] = {&f->carriers.number, &f->carriers.error, &f->carriers.hc2,    &f->carriers.hc3,
                                               &f->carriers.sway,   &f->carriers.along, &f->carriers.between};
    for (size_t k = 0; k < FF_CARRIER_ARRAYS; k++) *array[k] = moved(found, f, *array[k]);
    return f;
}

/* Means over an aperture are known to so much of themselves: data that agree better than that tell no more for it. */
static void add_quadrature(const struct ff_problem *p, ff_noise *noise)
{
    const double part = p->rules ? p->rules->tolerance : 0;
    for (size_t k = 0; k < noise->n_levels; k++) noise->level[k].square += part * part;
}

ff_status ff_noise_find(const ff_plan *plan, const ff_point *at, ff_noise_found **out)
{
    ff_point where;
    ff_noise *own = NULL;
    *out = NULL;
    if (plan->noise) {
        *out = keep(plan, at, plan->noise);
        return *out ? FF_OK : FF_ERR_MEMORY;
    }
    ff_status status = ff_point_new(plan, &where);
    if (status) return status;
    status = ff_noise_estimate(plan, at, &where, &own);
    if (!status && own) add_quadrature(plan->p, own);
    if (!status && own && !(*out = keep(plan, &where, own))) status = FF_ERR_MEMORY;
    ff_noise_free(own);
    ff_point_free(&where);
    return status;
}
