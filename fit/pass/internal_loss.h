/* The losses as a datum sees them; pass_kernels.c has them over a block of samples. A new loss is a line in each of these
 * functions, its kernel there, and its name in options.c. */
#ifndef FF_INTERNAL_LOSS_H
#define FF_INTERNAL_LOSS_H
#include "ff_fit.h"
#include <math.h>

/* e^2 of the cube root that has a finite slope at 0 */
#define FF_CUBE_ROOT_E2 1e-16

/* g(y) of a loss; linear losses keep y. x = cos(theta_i). */
static inline double ff_loss_target(ff_loss loss, double y, double x)
{
    if (loss == FF_LOSS_LOG) return log1p(y * x);
    if (loss == FF_LOSS_CUBE_ROOT) return y * x / cbrt(y * x * y * x + FF_CUBE_ROOT_E2);
    return y;
}

static inline int ff_loss_is_curved(ff_loss loss)
{
    return loss == FF_LOSS_LOG || loss == FF_LOSS_CUBE_ROOT;
}

/* d g / d f at f = y of a curved loss. */
static inline double ff_loss_slope(ff_loss loss, double y, double x)
{
    const double u = y * x, s = u * u + FF_CUBE_ROOT_E2;
    return loss == FF_LOSS_LOG ? x / (1 + u) : x * (u * u / 3 + FF_CUBE_ROOT_E2) / (s * cbrt(s));
}

/* What multiplies g(f) - g(y) for a sample of unit weight: for linear losses their factor, for the others 1. */
static inline double ff_loss_factor(ff_loss loss, double y, double x, double floor)
{
    if (loss == FF_LOSS_COSINE) return x;
    if (loss == FF_LOSS_RELATIVE) return 1 / fmax(y, floor);
    return 1;
}

#endif
