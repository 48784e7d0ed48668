/* Beaton and Tukey 1974, the biweight: constant beyond the scale. The tuning is from Holland and Welsch 1977, table 2. */
#include "internal_robust_block.h"
#include <math.h>

static double rho(double b, double r)
{
    const double b2 = b * b, v = fmax(1 - r * r / b2, 0);
    return b2 / 3 * (1 - v * v * v);
}

static void block(double b, const double *restrict r, double *restrict rho, double *restrict slope)
{
    const double b2 = b * b, inv_b2 = 1 / b2, third = b2 / 3;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double v = 1 - r[i] * r[i] * inv_b2, in = v > 0 ? v : 0;
        rho[i] = third * (1 - in * in * in);
        slope[i] = in * in;
    }
}

const ff_robust_descriptor FF_ISA_NAME(ff_robust_tukey) = {
    .info = {.name = "tukey",
             .help = "level beyond the scale: outliers do not count; there may be several minima",
             .rho = "b^2/3 (1 - (1 - s/b^2)^3) up to b^2, b^2/3 beyond",
             .source = "Beaton and Tukey 1974",
             .tuning = 4.685},
    .rho = rho,
    .block = block};
