/* The robust losses as the fit uses them: a constant descriptor each.
 *
 * A new one is one file robust_<id>.c with its descriptor and one line in ff_robusts.def. The files are compiled once per
 * instruction set. Planes have FF_BLOCK entries. */
#ifndef FF_INTERNAL_ROBUST_H
#define FF_INTERNAL_ROBUST_H
#include "base/internal_isa.h"
#include "ff_loss.h"

/* rho(s) of s = r^2 and its scale b. Twice differentiable but for a finite number of s, with rho'' <= 0: the second-order term of
 * Triggs et al. 1999 is dropped then, as the Ceres Solver does. */
typedef struct ff_robust_descriptor {
    ff_robust_info info;
    double (*rho)(double b, double r);
    /* rho(r^2) and rho'(r^2) over a block; NULL: nothing is done. */
    void (*block)(double b, const double *restrict r, double *restrict rho, double *restrict slope);
} ff_robust_descriptor;

/* As compiled for an instruction set; NULL when it is not available. robust must be valid. */
const ff_robust_descriptor *ff_robust_of(ff_isa isa, ff_robust robust);

/* rho of a residual r at the scale b, by the baseline. */
double ff_robust_rho(ff_robust robust, double b, double r);

/* The scale, in standard deviations of normal residuals, at which 5 % of their information is lost. */
double ff_robust_tuning(ff_robust robust);

#endif
