/* Least squares: rho(s) = s. */
#include "internal_robust_block.h"

static double rho(double b, double r)
{
    (void)b;
    return r * r;
}

const ff_robust_descriptor FF_ISA_NAME(ff_robust_none) = {
    .info = {.name = "none", .help = "every residual counts by its square", .rho = "s", .source = "", .tuning = 1}, .rho = rho};
