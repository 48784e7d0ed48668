/* The same samples with other weights: copies of a problem that share everything but the multipliers. */
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

double ff_trust_uniform(uint64_t seed, uint64_t repeat, uint64_t draw)
{
    uint64_t z =
        (seed * UINT64_C(0xd1342543de82ef95) + repeat) * UINT64_C(0xaf251af3b0f025b5) + (draw + 1) * UINT64_C(0x9e3779b97f4a7c15);
    for (int k = 0; k < 2; k++) {
        z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
        z ^= z >> 31;
    }
    return ((double)(z >> 12) + 0.5) / 4503599627370496.0;
}

ff_status ff_resampled_new(const struct ff_problem *p, ff_resampled *out)
{
    const size_t size = p->n_blocks * FF_BLOCK;
    ff_resampled r = {.threads = (size_t)ff_pool_threads(p->pool)};
    r.problem = malloc(r.threads * sizeof *r.problem);
    r.multiplier = calloc(r.threads * size, sizeof *r.multiplier);
    if (!r.problem || !r.multiplier) {
        ff_resampled_free(&r);
        return FF_ERR_MEMORY;
    }
    for (size_t t = 0; t < r.threads; t++) {
        r.problem[t] = *p;
        r.problem[t].multiplier = r.multiplier + t * size;
    }
    *out = r;
    return FF_OK;
}

void ff_resampled_free(ff_resampled *r)
{
    free(r->problem);
    free(r->multiplier);
}

void ff_resampled_weigh(const ff_resampled *r, int worker, const ff_places *places, const double *weight)
{
    float *to = r->multiplier + (size_t)worker * r->problem->n_blocks * FF_BLOCK;
    for (size_t i = 0; i < places->n; i++) to[i] = (float)sqrt(weight[places->group[i]]);
}
