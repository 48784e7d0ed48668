/* gtr: generalised Trowbridge-Reitz. Burley 2012, course notes, appendix B.
 *
 *   D = c / (1 + (alpha^2 - 1) mz^2)^gamma,   p = c (1 + q2)^-2 ((1 + q2) / (q2 + alpha^2))^gamma
 *   c = E(L) / (pi E(-(gamma - 1) L)),  L = ln alpha^2,  E(x) = (e^x - 1) / x
 *
 * This c is the source's (gamma - 1)(alpha^2 - 1) / (pi (1 - alpha^(2 - 2 gamma))), and its logarithmic limit at gamma = 1, in one
 * form that is smooth there and at alpha = 1. gamma = 2 is ggx. The source takes no masking from it (it borrows ggx's with a
 * changed alpha); here Smith's Lambda is its own, by quadrature for any gamma. */
#include "internal_isotropic.h"

/* pass->c */
enum { C_C, C_A2, C_DLNC_ALPHA, C_DLNC_GAMMA };

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    ff_isotropic_stretch(2, params, s, jac);
}

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    const double c = pass->c[C_C] / FF_PI, alpha = pass->own[0], gamma = pass->own[1], a2 = pass->c[C_A2];
    double inv_t[FF_BLOCK], inv_r[FF_BLOCK], log_ratio[FF_BLOCK]; /* 1 / (1 + q2), 1 / (q2 + alpha^2), ln of their ratio */
    for (size_t i = 0; i < n; i++) {
        inv_t[i] = ff_recip(1 + q2[i]);
        inv_r[i] = ff_recip(q2[i] + a2);
        dlnp[i] = (gamma - 2) * inv_t[i] - gamma * inv_r[i];
    }
    for (size_t i = 0; i < n; i++) {
        const double u = (1 - a2) * inv_r[i], w = 1 + u;
        log_ratio[i] = ff_log(w) + (u - (w - 1)) * ((q2[i] + a2) * inv_t[i]);
    }
    for (size_t i = 0; i < n; i++) p[i] = c * inv_t[i] * inv_t[i] * ff_exp(gamma * log_ratio[i]);
    if (!dlnp_own) return;
    double *restrict by_alpha = dlnp_own[0], *restrict by_gamma = dlnp_own[1];
    for (size_t i = 0; i < n; i++) {
        by_alpha[i] = pass->c[C_DLNC_ALPHA] - 2 * alpha * gamma * inv_r[i];
        by_gamma[i] = pass->c[C_DLNC_GAMMA] + log_ratio[i];
    }
}

static void prepare(ff_ndf_pass *pass)
{
    const double alpha = pass->own[0], excess = pass->own[1] - 1, L = 2 * log(alpha);
    const double slope = ff_mean_exp_slope(-excess * L);
    pass->c[C_C] = ff_mean_exp(L) / ff_mean_exp(-excess * L);
    pass->c[C_A2] = alpha * alpha;
    pass->c[C_DLNC_ALPHA] = (ff_mean_exp_slope(L) + excess * slope) * 2 / alpha;
    pass->c[C_DLNC_GAMMA] = L * slope;
    ff_lambda_table_build(pass, 2, profile);
}

static const ff_param params[] = {
    {"alpha", "1", "roughness alpha", 1e-4, 1, 0.3, FF_PARAM_LOG, 0},
    {"gamma", "1", "shape of the tails, gamma: 2 is ggx, smaller is longer", 0.5, 10, 2, FF_PARAM_LOG, 0},
};

const ff_ndf FF_ISA_NAME(ff_ndf_gtr) = {
    .term = {.name = "gtr",
             .also = "generalized-trowbridge-reitz,generalised-trowbridge-reitz",
             .title = "generalised Trowbridge-Reitz, tails of any length",
             .source = "Burley 2012, appendix B (the distribution); Lambda by quadrature of Heitz 2014, section 3.4",
             .note = "isotropic; gamma = 2 is ggx, gamma = 1 Berry's; the masking is Smith's own, which the source does not give",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 2,
             .params = params,
             .contains = {"ggx", "gamma", 2}},
    .stretch = stretch,
    .n_own = 2,
    .alpha_own = 1,
    .table_size = FF_LAMBDA_TABLE(2),
    .prepare = prepare,
    .profile = profile,
    .lambda = ff_lambda_table,
};
