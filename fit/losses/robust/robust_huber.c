/* Huber 1964: squares up to the scale, straight lines beyond. Convex. The tuning is from Holland and Welsch 1977, table 2. */
#include "internal_robust_block.h"
#include "base/internal_vector_math.h"
#include <math.h>

static double rho(double b, double r)
{
    const double s = r * r, b2 = b * b;
    return s > b2 ? 2 * b * fabs(r) - b2 : s;
}

static void block(double b, const double *restrict r, double *restrict rho, double *restrict slope)
{
    const double b2 = b * b;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double s = r[i] * r[i], a = fabs(r[i]), inv = ff_recip(a > 1e-290 ? a : 1e-290);
        rho[i] = s > b2 ? 2 * b * a - b2 : s;
        slope[i] = s > b2 ? b * inv : 1;
    }
}

const ff_robust_descriptor FF_ISA_NAME(ff_robust_huber) = {
    .info = {.name = "huber",
             .help = "straight beyond the scale: one minimum, outliers keep some of their pull",
             .rho = "s up to b^2, 2 b sqrt(s) - b^2 beyond",
             .source = "Huber 1964",
             .tuning = 1.345},
    .rho = rho,
    .block = block};
