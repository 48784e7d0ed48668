/* A noise model as plain values: what ff_noise.h closes to others. */
#ifndef FF_NOISE_STRUCT_H
#define FF_NOISE_STRUCT_H
#include "ff_noise.h"

struct ff_noise {
    size_t n_levels;
    double cos_i, cos_o;                  /* p, q                                     */
    double along_scan[FF_NOISE_LAGS + 1]; /* [0] is 1                                 */
    double between_channels;
    /* Of an estimated one the inverse of what the data say of its numbers, those that are not 0: what a logarithm of a variance
     * with the derivatives z by a, b, c (as they are in units of `unit`), p, q is uncertain by is z' certainty z. */
    double unit;
    double uncertainty[5][5];
    ff_noise_level level[]; /* [n_levels]                               */
};

/* One of n_levels levels that are all 0, without correlation; NULL when there is no memory. */
ff_noise *ff_noise_make(size_t n_levels);

static inline const ff_noise_level *ff_noise_of(const ff_noise *n, size_t channel)
{
    return &n->level[n->n_levels == 1 ? 0 : channel]; /* which exists */
}

/* The part that depends on the value, (1/sr)^2. */
static inline double ff_noise_variance(const ff_noise_level *l, double f)
{
    const double y = f > 0 ? f : 0;
    return l->constant + y * (l->linear + y * l->square);
}
#endif
