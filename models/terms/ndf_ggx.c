/* ggx (Trowbridge-Reitz): Walter et al. 2007, eq. 33-34; anisotropic and correlated as in Heitz 2014, sections 3.2 to 3.4.
 *
 *   p(q2)     = 1 / (pi (1 + q2)^2)
 *   Lambda(a) = (-1 + sqrt(1 + v)) / 2,  v = 1 / a^2
 *
 * Evaluated as v / (2 (1 + sqrt(1 + v))), which does not cancel near normal incidence. */
#include "internal_terms.h"
#include "base/internal_vector_math.h"

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    (void)pass, (void)dlnp_own;
    for (size_t i = 0; i < n; i++) {
        const double inv = ff_recip(1 + q2[i]);
        p[i] = inv * inv * (1 / FF_PI);
        dlnp[i] = -2 * inv;
    }
}

static void lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                   double *const *dlam_own)
{
    (void)pass, (void)dlam_own;
    for (size_t i = 0; i < n; i++) {
        const double inv_root = ff_rsqrt(1 + v[i]), root = (1 + v[i]) * inv_root;
        lam[i] = 0.5 * v[i] * ff_recip(1 + root);
        dlam[i] = 0.25 * inv_root;
    }
}

static const ff_param params[] = {FF_STRETCH_PARAMS};

const ff_ndf FF_ISA_NAME(ff_ndf_ggx) = {
    .term = {.name = "ggx",
             .also = "trowbridge-reitz",
             .title = "Trowbridge-Reitz slopes, long tails",
             .source = "Trowbridge and Reitz 1975; Walter et al. 2007, eq. 33-34; Heitz 2014, sections 3.2 to 3.4",
             .note = "its slopes have no finite variance",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 5,
             .params = params},
    .profile = profile,
    .lambda = lambda,
};
