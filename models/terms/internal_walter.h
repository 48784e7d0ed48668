/* Walter's rational approximation of beckmann's Lambda, shared by beckmann-walter and phong-walter. Walter et al. 2007, in the form
 * of Heitz 2014, section 3.2:
 *
 *   Lambda(a) = (1 - 1.259 a + 0.396 a^2) / (3.535 a + 2.181 a^2) below a = 1.6, else 0
 *
 * As published: it has a kink at 1.6, where it comes from below 0 (-5.7e-5). */
#ifndef FF_INTERNAL_WALTER_H
#define FF_INTERNAL_WALTER_H
#include "internal_term.h"
#include "base/internal_vector_math.h"

/* The profile that beckmann-walter shares with beckmann. */
#define ff_beckmann_profile FF_ISA_NAME(ff_beckmann_profile)
void ff_beckmann_profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                         double *const *dlnp_own);

static inline void ff_walter_lambda(size_t n, const double *restrict v, double *restrict lam, double *restrict dlam)
{
    for (size_t i = 0; i < n; i++) {
        const double a = ff_rsqrt(v[i]), near = a < 1.6 ? 1 : 0, x = near > 0 ? a : 1.6;
        const double over = 1 - (1.259 - 0.396 * x) * x, inv_under = ff_recip((3.535 + 2.181 * x) * x);
        const double slope = (0.792 * x - 1.259) - over * inv_under * (3.535 + 4.362 * x);
        lam[i] = near * over * inv_under;
        dlam[i] = -0.5 * near * slope * inv_under * x * x * x; /* da / dv = -a^3 / 2 */
    }
}
#endif
