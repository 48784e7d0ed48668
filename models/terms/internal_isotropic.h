/* What the isotropic distributions share that are not shape-invariant: their stretch, and two functions of their normalisations.
 *
 * They leave alpha_x = alpha_y = 1, so that q2 = tan^2 theta_m, mz = 1 / sqrt(1 + q2), p(q2) = D mz^4 and v = tan^2 theta_o. */
#ifndef FF_INTERNAL_ISOTROPIC_H
#define FF_INTERNAL_ISOTROPIC_H
#include "base/internal_gauss.h"
#include "internal_lambda_table.h"
#include "internal_terms.h"
#include "base/internal_vector_math.h"

/* ff_ndf.stretch of n parameters that are the distribution's own. */
static inline void ff_isotropic_stretch(int n, const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    *s = (ff_stretch){.ax = 1, .ay = 1};
    for (int k = 0; k < n; k++) {
        s->own[k] = params[k];
        if (jac) jac[k][FF_D_OWN + k] = 1;
    }
}

/* 1 - mz of mz = 1 / sqrt(1 + q2), without the cancellation near the normal. */
static inline double ff_one_minus_mz(double q2, double mz)
{
    return q2 * mz * mz * ff_recip(1 + mz);
}

/* E(x) = (e^x - 1) / x = integral_0^1 e^(x t) dt: what remains of an integral of a power where it becomes a logarithm. */
static inline double ff_mean_exp(double x)
{
    return x == 0 ? 1 : expm1(x) / x;
}

/* d ln E / dx = 1 / (1 - e^-x) - 1 / x, near 0 by its series (Bernoulli numbers). */
static inline double ff_mean_exp_slope(double x)
{
    const double z = x * x;
    if (z < 0.0625) return 0.5 + x / 12 * (1 - z / 60 * (1 - z / 42 * (1 - z / 40 * (1 - z * 5 / 198))));
    return -1 / expm1(-x) - 1 / x;
}
#endif
