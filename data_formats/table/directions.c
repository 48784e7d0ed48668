/* Angles to unit vectors. Compiled once per instruction set. */
#include "internal_directions.h"
#include "base/internal_vector_math.h"

static void vectors(double unit, const double *restrict theta, const double *restrict phi, size_t n, double *restrict x,
                    double *restrict y, double *restrict z)
{
    for (size_t i = 0; i < n; i++) {
        double st, ct, sp, cp;
        ff_sincos(unit * theta[i], &st, &ct);
        ff_sincos(unit * phi[i], &sp, &cp);
        x[i] = st * cp;
        y[i] = st * sp;
        z[i] = ct;
    }
    for (size_t i = 0; i < n; i++) { /* beyond the range of ff_sincos: nobody's angles, but some file's */
        if (fabs(unit * theta[i]) <= 1e5 && fabs(unit * phi[i]) <= 1e5) continue;
        if (!isfinite(unit * theta[i]) || !isfinite(unit * phi[i])) { /* none at all: where no sample is used, below the horizon */
            x[i] = y[i] = 0;
            z[i] = -1;
            continue;
        }
        x[i] = sin(unit * theta[i]) * cos(unit * phi[i]);
        y[i] = sin(unit * theta[i]) * sin(unit * phi[i]);
        z[i] = cos(unit * theta[i]);
    }
}

void FF_ISA_NAME(ff_directions)(double unit, const double *const angle[4], size_t n, double *const planes[6])
{
    vectors(unit, angle[0], angle[1], n, planes[0], planes[1], planes[2]);
    vectors(unit, angle[2], angle[3], n, planes[3], planes[4], planes[5]);
}
