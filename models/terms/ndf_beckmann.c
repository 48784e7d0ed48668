/* beckmann: Gaussian slopes. Beckmann and Spizzichino 1963; in the form of Heitz 2014 (RR-8468), sections 3.2 to 3.4.
 *
 *   p(q2)     = exp(-q2) / pi
 *   Lambda(a) = (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi)),  a = 1 / sqrt(v)
 *
 * Evaluated as exp(-a^2) (1 / (a sqrt(pi)) - erfcx(a)) / 2, which keeps its relative accuracy where the printed form cancels.
 * alpha is sqrt(2) times the rms slope along an axis. */
#include "internal_terms.h"
#include "internal_walter.h"

void ff_beckmann_profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                         double *const *dlnp_own)
{
    (void)pass, (void)dlnp_own;
    for (size_t i = 0; i < n; i++) {
        p[i] = ff_exp(-q2[i]) * (1 / FF_PI);
        dlnp[i] = -1;
    }
}

static void lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *const *dlam_own)
{
    (void)pass, (void)dlam_own;
    double a[FF_BLOCK], e[FF_BLOCK], excess[FF_BLOCK];
    /* short loops: their iterations overlap in the processor where those of one long chain of operations cannot */
    for (size_t i = 0; i < n; i++) a[i] = ff_rsqrt(v[i]);
    for (size_t i = 0; i < n; i++) e[i] = ff_exp(-a[i] * a[i]);
    for (size_t i = 0; i < n; i++) excess[i] = v[i] * a[i] * (1 / FF_SQRT_PI) - ff_erfcx(a[i]);
    for (size_t i = 0; i < n; i++) {
        lam[i] = 0.5 * e[i] * excess[i];
        dlam[i] = e[i] * a[i] * (0.25 / FF_SQRT_PI); /* d(a Lambda)/da = -erfc(a)/2 */
    }
}

static const ff_param params[] = {FF_STRETCH_PARAMS};

const ff_ndf FF_ISA_NAME(ff_ndf_beckmann) = {
    .term = {.name = "beckmann",
             .also = "beckmann-spizzichino",
             .title = "Gaussian slopes",
             .source = "Beckmann and Spizzichino 1963; Walter et al. 2007, eq. 25; Heitz 2014, sections 3.2 to 3.4",
             .note = "alpha is sqrt(2) times the rms slope along an axis; the masking is exact, not Walter's rational fit",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 5,
             .params = params},
    .profile = ff_beckmann_profile,
    .lambda = lambda,
};
