/* The logarithm of Cauchy's density. The tuning is from Holland and Welsch 1977, table 2. */
#include "internal_robust_block.h"
#include "base/internal_vector_math.h"
#include <math.h>

static double rho(double b, double r)
{
    const double b2 = b * b;
    return b2 * log1p(r * r / b2);
}

static void block(double b, const double *restrict r, double *restrict rho, double *restrict slope)
{
    const double b2 = b * b, inv_b2 = 1 / b2;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = r[i] * r[i] * inv_b2;
        rho[i] = b2 * ff_log1p(u);
        slope[i] = ff_recip(1 + u);
    }
}

const ff_robust_descriptor FF_ISA_NAME(ff_robust_cauchy) = {
    .info = {.name = "cauchy",
             .help = "logarithms beyond the scale: far outliers count little",
             .rho = "b^2 ln(1 + s/b^2)",
             .source = "Holland and Welsch 1977",
             .tuning = 2.385},
    .rho = rho,
    .block = block};
