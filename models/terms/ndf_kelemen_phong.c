/* kelemen-phong: the half-vector density of Kelemen and Szirmay-Kalos 2001 after Phong.
 *
 *   P_H = (n + 1) / (2 pi) mz^n,  p = P_H mz^4
 *
 * As kelemen-ward it is a density of solid angle, integral P_H dm = 1, that stands where others have D, and has no Smith masking.
 */
#include "internal_isotropic.h"

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    ff_isotropic_stretch(1, params, s, jac);
}

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    const double exponent = pass->own[0], half = 0.5 * exponent + 2, c = (exponent + 1) / (2 * FF_PI);
    double log_t[FF_BLOCK], inv_t[FF_BLOCK]; /* of 1 + q2 = mz^-2 */
    for (size_t i = 0; i < n; i++) {
        inv_t[i] = ff_recip(1 + q2[i]);
        dlnp[i] = -half * inv_t[i];
    }
    for (size_t i = 0; i < n; i++) {
        const double t = 1 + q2[i];
        log_t[i] = ff_log(t) + (q2[i] - (t - 1)) * inv_t[i];
    }
    for (size_t i = 0; i < n; i++) p[i] = c * ff_exp(-half * log_t[i]);
    if (!dlnp_own) return;
    double *restrict own = dlnp_own[0];
    for (size_t i = 0; i < n; i++) own[i] = 1 / (exponent + 1) - 0.5 * log_t[i];
}

static const ff_param params[] = {{"n", "1", "exponent n of (h.z)^n", 0, 2e6, 20, FF_PARAM_LOG, 1}};

const ff_ndf FF_ISA_NAME(ff_ndf_kelemen_phong) = {
    .term = {.name = "kelemen-phong",
             .title = "Kelemen's half-vector density after Phong",
             .source = "Kelemen and Szirmay-Kalos 2001, the second density of section 2.1",
             .note =
                 "isotropic; the integral of P_H over solid angle is 1, in the source's normalisation, not the projected area; no "
                 "Smith masking: use kelemen. That area is (n + 1) / (n + 2), and its peak is kelemen-ward's for n = 2/m^2 - 1",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 1,
             .params = params},
    .stretch = stretch,
    .n_own = 1,
    .alpha_own = -1,
    .profile = profile,
};
