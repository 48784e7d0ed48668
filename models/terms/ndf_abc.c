/* abc: the microfacet form of Low et al. 2012.
 *
 *   S = (1 + B (1 - mz))^-C,   D = S / N,   N = integral S mz dm = 2 pi (b J(1 - C) - J(2 - C)) / B^2
 *   J(k) = integral_1^b u^(k - 1) du = ln b E(k ln b),  b = 1 + B,  E(x) = (e^x - 1) / x
 *
 * The source does not normalise S but scales it by A per channel; here that factor is the lobe's scale. E has no exception at C = 1
 * and C = 2. The source's fits have the V-cavity's masking; Smith's Lambda is by quadrature. */
#include "internal_isotropic.h"

/* pass->c */
enum { C_C, C_DLNC_B, C_DLNC_C };

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    ff_isotropic_stretch(2, params, s, jac);
}

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    const double c = pass->c[C_C], B = pass->own[0], C = pass->own[1];
    double mz[FF_BLOCK], low[FF_BLOCK], inv_u[FF_BLOCK], log_u[FF_BLOCK]; /* low = 1 - mz, u = 1 + B low */
    for (size_t i = 0; i < n; i++) mz[i] = ff_rsqrt(1 + q2[i]);
    for (size_t i = 0; i < n; i++) low[i] = ff_one_minus_mz(q2[i], mz[i]);
    for (size_t i = 0; i < n; i++) {
        const double mz2 = mz[i] * mz[i];
        inv_u[i] = ff_recip(1 + B * low[i]);
        dlnp[i] = -(0.5 * C * B * mz[i] * inv_u[i] + 2) * mz2;
    }
    for (size_t i = 0; i < n; i++) {
        const double x = B * low[i], u = 1 + x;
        log_u[i] = ff_log(u) + (x - (u - 1)) * inv_u[i];
    }
    for (size_t i = 0; i < n; i++) p[i] = c * mz[i] * mz[i] * mz[i] * mz[i] * ff_exp(-C * log_u[i]);
    if (!dlnp_own) return;
    double *restrict by_B = dlnp_own[0], *restrict by_C = dlnp_own[1];
    for (size_t i = 0; i < n; i++) {
        by_B[i] = pass->c[C_DLNC_B] - C * low[i] * inv_u[i];
        by_C[i] = pass->c[C_DLNC_C] - log_u[i];
    }
}

static void prepare(ff_ndf_pass *pass)
{
    const double B = pass->own[0], C = pass->own[1], b = 1 + B, log_b = log1p(B);
    const double J1 = log_b * ff_mean_exp((1 - C) * log_b), J2 = log_b * ff_mean_exp((2 - C) * log_b);
    const double slope1 = ff_mean_exp_slope((1 - C) * log_b), slope2 = ff_mean_exp_slope((2 - C) * log_b);
    const double both = b * J1 - J2; /* its derivative by b is J1 alone: what the limits of the integrals add cancels */
    pass->c[C_C] = B * B / (2 * FF_PI * both);
    pass->c[C_DLNC_B] = 2 / B - J1 / both;
    pass->c[C_DLNC_C] = log_b * (b * J1 * slope1 - J2 * slope2) / both;
    ff_lambda_table_build(pass, 2, profile);
}

static const ff_param params[] = {
    {"B", "1", "width of the peak, B, about 1 / alpha^2", 1, 1e8, 100, FF_PARAM_LOG, 0},
    {"C", "1", "fall of the tails, C", 0.01, 10, 1, FF_PARAM_LOG, 0},
};

const ff_ndf FF_ISA_NAME(ff_ndf_abc) = {
    .term = {.name = "abc",
             .title = "the inverse power of Low's microfacet model",
             .source = "Low et al. 2012, microfacet form; normalised here; Lambda by quadrature of Heitz 2014, section 3.4",
             .note =
                 "isotropic; the published fits have v-cavity, dielectric and an S that is not normalised: ks = 4 N A / pi makes "
                 "this their A S F G / (pi cos cos), N = integral S (h.z) dh",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 2,
             .params = params},
    .stretch = stretch,
    .n_own = 2,
    .alpha_own = -1,
    .table_size = FF_LAMBDA_TABLE(2),
    .prepare = prepare,
    .profile = profile,
    .lambda = ff_lambda_table,
};
