/* Small arithmetic that the Fresnel and diffuse terms share. */
#ifndef FF_INTERNAL_OPTICS_H
#define FF_INTERNAL_OPTICS_H
#include <stddef.h>

/* Schlick's (1 - cos)^5 for m = 1 - cos. */
static inline double ff_fifth(double m)
{
    const double m2 = m * m;
    return m2 * m2 * m;
}

/* The derivative plane d[k] that an evaluation is asked for, NULL when it is not wanted. */
static inline double *ff_wanted_plane(double *const *d, int k)
{
    return d ? d[k] : NULL;
}

/* out = factor * x, where out is wanted. */
static inline void ff_scaled(size_t n, const double *restrict x, double factor, double *restrict out)
{
    if (!out) return;
    for (size_t i = 0; i < n; i++) out[i] = factor * x[i];
}

#endif
