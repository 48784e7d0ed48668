/* kelemen-ward: the half-vector density of Kelemen and Szirmay-Kalos 2001, eq. 4, after Ward.
 *
 *   P_H = exp(-tan^2 theta / m^2) / (pi m^2 mz^3),  p = P_H mz^4
 *
 * P_H is a density of solid angle, integral P_H dm = 1, and stands in the source where others have D: f = P_H F / (4 (wi.h)^2). So
 * it covers no unit area, and Smith's masking has no meaning for it. */
#include "internal_isotropic.h"

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    ff_isotropic_stretch(1, params, s, jac);
}

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    const double m = pass->own[0], inv_m2 = 1 / (m * m), c = inv_m2 / FF_PI;
    for (size_t i = 0; i < n; i++) {
        const double mz = ff_rsqrt(1 + q2[i]);
        p[i] = c * mz * ff_exp(-q2[i] * inv_m2);
        dlnp[i] = -inv_m2 - 0.5 * mz * mz;
    }
    if (!dlnp_own) return;
    double *restrict own = dlnp_own[0];
    for (size_t i = 0; i < n; i++) {
        const double x = q2[i] * inv_m2;
        own[i] = 2 / m * ((x < 1e300 ? x : 1e300) - 1);
    }
}

static const ff_param params[] = {{"m", "1", "roughness m", 1e-4, 4, 0.3, FF_PARAM_LOG, 0}};

const ff_ndf FF_ISA_NAME(ff_ndf_kelemen_ward) = {
    .term = {.name = "kelemen-ward",
             .title = "Kelemen's half-vector density after Ward",
             .source = "Kelemen and Szirmay-Kalos 2001, eq. 4",
             .note =
                 "isotropic; the integral of P_H over solid angle is 1, in the source's normalisation, not the projected area; no "
                 "Smith masking: use kelemen. That area is 0.96 at m = 0.3, 0.81 at m = 0.8: so much less is reflected",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 1,
             .params = params},
    .stretch = stretch,
    .n_own = 1,
    .alpha_own = 1,
    .profile = profile,
};
