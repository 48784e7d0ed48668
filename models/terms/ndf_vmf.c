/* vmf: von Mises-Fisher. Mikkelsen 2009, eq. 29.
 *
 *   D = kappa / (2 pi (1 - e^-kappa)) e^(kappa (mz - 1)) / mz,   p = D mz^4
 *
 * The source's density is one of solid angle, D mz; its printed form kappa / (e^kappa - 1) e^(kappa mz) overflows beyond kappa =
 * 709. The source has the V-cavity's masking.
 *
 * D mz does not vanish at the horizon, so that the normals near it cover an infinite area, logarithmically, and Smith's Lambda of
 * the whole density is infinite. Here normals steeper than a slope of 2^34 have no part in Lambda: they add
 * kappa e^-kappa ln(2^34 / ...) / pi to mu Lambda, less than 1e-9 from kappa = 30 on. */
#include "internal_isotropic.h"

/* pass->c */
enum { C_C, C_DLNC };

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    ff_isotropic_stretch(1, params, s, jac);
}

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    const double c = pass->c[C_C], kappa = pass->own[0];
    double mz[FF_BLOCK], low[FF_BLOCK]; /* low = 1 - mz */
    for (size_t i = 0; i < n; i++) mz[i] = ff_rsqrt(1 + q2[i]);
    for (size_t i = 0; i < n; i++) low[i] = ff_one_minus_mz(q2[i], mz[i]);
    for (size_t i = 0; i < n; i++) {
        p[i] = c * mz[i] * mz[i] * mz[i] * ff_exp(-kappa * low[i]);
        dlnp[i] = -(0.5 * kappa * mz[i] + 1.5) * mz[i] * mz[i];
    }
    if (!dlnp_own) return;
    double *restrict own = dlnp_own[0];
    for (size_t i = 0; i < n; i++) own[i] = pass->c[C_DLNC] - low[i];
}

static void prepare(ff_ndf_pass *pass)
{
    const double kappa = pass->own[0];
    pass->c[C_C] = 1 / (2 * FF_PI * ff_mean_exp(-kappa));
    pass->c[C_DLNC] = ff_mean_exp_slope(-kappa);
    ff_lambda_table_build(pass, 1, profile);
}

static const ff_param params[] = {{"kappa", "1", "concentration kappa, about 2 / alpha^2", 0.1, 1e6, 20, FF_PARAM_LOG, 0}};

const ff_ndf FF_ISA_NAME(ff_ndf_vmf) = {
    .term = {.name = "vmf",
             .also = "von-mises-fisher",
             .title = "von Mises-Fisher on the hemisphere",
             .source = "Mikkelsen 2009, eq. 29, as D = p / (h.n); Lambda by quadrature of Heitz 2014, section 3.4",
             .note =
                 "isotropic; the source's masking is v-cavity. Below kappa = 30 the area of its steepest normals counts in Smith's "
                 "Lambda, where it is cut off at a slope of 2^34",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC | FF_UNIT_AREA,
             .n_params = 1,
             .params = params},
    .stretch = stretch,
    .n_own = 1,
    .alpha_own = -1,
    .table_size = FF_LAMBDA_TABLE(1),
    .prepare = prepare,
    .profile = profile,
    .lambda = ff_lambda_table,
};
