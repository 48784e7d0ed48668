/* Small arithmetic that the Fresnel and diffuse terms share. */
#ifndef FF_INTERNAL_OPTICS_H
#define FF_INTERNAL_OPTICS_H
#include "base/internal_vector_math.h"
#include <stddef.h>

/* Schlick's (1 - cos)^5 for m = 1 - cos. */
static inline double ff_fifth(double m)
{
    const double m2 = m * m;
    return m2 * m2 * m;
}

/* Keeps reciprocals finite where eta = 1 meets c = 0, and eta < 1 with k = 0 the angle of total reflection. */
#define FF_TINY 1e-60

static inline double ff_floored(double x)
{
    return x > FF_TINY ? x : FF_TINY;
}

/* Fresnel's equations for an index eta without absorption: with N = eta^2 and w real; N - s^2 = (eta - 1)(eta + 1) + c^2. */
static inline double ff_dielectric(double eta, double c)
{
    const double w2 = ff_floored((eta - 1) * (eta + 1) + c * c), w = w2 * ff_rsqrt(w2), q = eta * eta * c;
    const double rs = (c - w) * ff_recip(c + w), rp = (q - w) * ff_recip(q + w);
    return 0.5 * (rs * rs + rp * rp);
}

/* Its derivative by eta: d w = eta / w, d (N c) = 2 eta c. */
static inline double ff_dielectric_slope(double eta, double c)
{
    const double N = eta * eta, w2 = ff_floored((eta - 1) * (eta + 1) + c * c), inv_w = ff_rsqrt(w2), w = w2 * inv_w, q = N * c;
    const double is = ff_recip(c + w), ip = ff_recip(q + w), rs = (c - w) * is, rp = (q - w) * ip;
    return 2 * eta * c * inv_w * (rp * (2 * w2 - N) * ip * ip - rs * is * is);
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
