/* The complex numbers of Fresnel's equations: what a conductor's terms share. */
#ifndef FF_INTERNAL_COMPLEX_H
#define FF_INTERNAL_COMPLEX_H
#include "internal_optics.h"
#include <math.h>

typedef struct ff_complex {
    double re, im;
} ff_complex;

static inline ff_complex ff_complex_times(ff_complex a, ff_complex b)
{
    return (ff_complex){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static inline ff_complex ff_complex_conjugate(ff_complex a)
{
    return (ff_complex){a.re, -a.im};
}

static inline double ff_complex_norm(ff_complex a)
{
    return a.re * a.re + a.im * a.im;
}

/* Principal square root of x + i y, y >= 0: the larger part by a sum of equal signs, the other from the product of both, y / 2. */
static inline ff_complex ff_complex_root(double x, double y)
{
    const double length2 = ff_floored(x * x + y * y), larger2 = 0.5 * (length2 * ff_rsqrt(length2) + fabs(x));
    const double inv = ff_rsqrt(larger2), larger = larger2 * inv, smaller = 0.5 * y * inv;
    return x < 0 ? (ff_complex){smaller, larger} : (ff_complex){larger, smaller};
}

/* conj(r) r' for r = (q - w) / (q + w), where r' = numerator / (q + w)^2. */
static inline ff_complex ff_reflected_slope(ff_complex q, ff_complex w, ff_complex numerator)
{
    const ff_complex difference = {q.re - w.re, q.im - w.im}, sum = {q.re + w.re, q.im + w.im};
    const double inv = ff_recip(ff_floored(ff_complex_norm(sum)));
    const ff_complex product =
        ff_complex_times(ff_complex_times(ff_complex_conjugate(difference), ff_complex_conjugate(sum)), numerator);
    return (ff_complex){product.re * inv * inv, product.im * inv * inv};
}

static inline double ff_reflected(ff_complex q, ff_complex w)
{
    const ff_complex difference = {q.re - w.re, q.im - w.im}, sum = {q.re + w.re, q.im + w.im};
    return ff_complex_norm(difference) * ff_recip(ff_floored(ff_complex_norm(sum)));
}

#endif
