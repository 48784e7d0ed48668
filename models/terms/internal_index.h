/* Indices of refraction: their boxes, and which of them is like a reflectance at normal incidence, where a fit starts. */
#ifndef FF_INTERNAL_INDEX_H
#define FF_INTERNAL_INDEX_H
#include <math.h>

static inline double ff_clamped(double x, double lo, double hi)
{
    return x < lo ? lo : x > hi ? hi : x;
}

/* The boxes: real media at one end, the published fits of tables of measured materials (eta up to 100) at the other. */
#define FF_DIELECTRIC_MAX 100
#define FF_CONDUCTOR_MIN  0.01
#define FF_CONDUCTOR_MAX  100

/* F0 = ((eta - 1) / (eta + 1))^2 */
static inline void ff_dielectric_like(double f0, double *params)
{
    const double r = sqrt(ff_clamped(f0, 0, 0.999));
    params[0] = ff_clamped((1 + r) / (1 - r), 1, FF_DIELECTRIC_MAX);
}

/* Among the (eta, k) with this F0, from the lowest eta to the dielectric (Gulbrandsen 2014), one whose curve follows Schlick's: for
 * F0 in [0.02, 0.98] their cosine-weighted mean distance is at most 0.015. k > 0, for F has no slope by k at 0. */
static inline void ff_conductor_like(double f0, double *params)
{
    const double r = ff_clamped(f0, 1e-4, 0.999), root_r = sqrt(r), lowest = (1 - r) / (1 + r),
                 highest = (1 + root_r) / (1 - root_r);
    const double dielectric_share = (1 - r) * (1 - r) * sqrt(1 - r);
    const double eta = ff_clamped(lowest + dielectric_share * (highest - lowest), FF_CONDUCTOR_MIN, FF_CONDUCTOR_MAX);
    params[0] = eta;
    params[1] = ff_clamped(sqrt((r * (eta + 1) * (eta + 1) - (eta - 1) * (eta - 1)) / (1 - r)), 0, FF_CONDUCTOR_MAX);
}

#endif
