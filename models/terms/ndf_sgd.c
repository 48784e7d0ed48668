/* sgd: shifted gamma distribution. Bagher et al. 2012.
 *
 *   x = alpha + q2 / alpha,   p = D mz^4 = K e^-x x^-p / pi,   1 / K = alpha Gamma(1 - p, alpha) = alpha integral_alpha^inf e^-x
 * x^-p dx
 *
 * K makes the projected area 1. The integral is by quadrature in ln x, for any p, with its derivatives. The source's masking is a
 * fit of its own per channel; Smith's Lambda of this D, by quadrature, is within 6e-4 of it in G1 where it was looked at. */
#include "internal_isotropic.h"

/* pass->c */
enum { C_C, C_DLNC_ALPHA, C_DLNC_P };

static void stretch(const double *params, ff_stretch *s, double jac[][FF_D_COUNT])
{
    ff_isotropic_stretch(2, params, s, jac);
}

static void profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                    double *const *dlnp_own)
{
    const double c = pass->c[C_C], alpha = pass->own[0], power = pass->own[1], inv_alpha = 1 / alpha;
    double x[FF_BLOCK], log_x[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const double whole = alpha + q2[i] * inv_alpha;
        x[i] = whole < 1e300 ? whole : 1e300;
    }
    for (size_t i = 0; i < n; i++) log_x[i] = ff_log(x[i]);
    for (size_t i = 0; i < n; i++) {
        p[i] = c * ff_exp(-x[i] - power * log_x[i]);
        dlnp[i] = -inv_alpha * (1 + power * ff_recip(x[i]));
    }
    if (!dlnp_own) return;
    double *restrict by_alpha = dlnp_own[0], *restrict by_p = dlnp_own[1];
    for (size_t i = 0; i < n; i++) { /* dx / d alpha = 2 - x / alpha */
        by_alpha[i] = pass->c[C_DLNC_ALPHA] + alpha * dlnp[i] * (2 - x[i] * inv_alpha);
        by_p[i] = pass->c[C_DLNC_P] - log_x[i];
    }
}

static void prepare(ff_ndf_pass *pass)
{
    enum { PANELS = 16, N = FF_GAUSS * PANELS };
    const double alpha = pass->own[0], power = pass->own[1];
    double y[N], w[N], f[N], integral = 0, of_log = 0; /* y = ln x */
    ff_gauss_panels(log(alpha), log(alpha + 45), PANELS, y, w);
    for (int i = 0; i < N; i++) f[i] = w[i] * ff_exp(alpha - ff_exp(y[i]) + (1 - power) * y[i]);
    for (int i = 0; i < N; i++) {
        integral += f[i];
        of_log += f[i] * y[i];
    }
    pass->c[C_C] = exp(alpha) / (FF_PI * alpha * integral);
    pass->c[C_DLNC_ALPHA] = -1 / alpha + pow(alpha, -power) / integral;
    pass->c[C_DLNC_P] = of_log / integral;
    ff_lambda_table_build(pass, 2, profile);
}

static const ff_param params[] = {
    {"alpha", "1", "width, alpha: about the square of the roughness", 1e-6, 10, 0.1, FF_PARAM_LOG, 0},
    {"p", "1", "power of the peak, p", 0, 4, 0.5, 0, 0},
};

const ff_ndf FF_ISA_NAME(ff_ndf_sgd) = {
    .term = {.name = "sgd",
             .also = "shifted-gamma",
             .title = "shifted gamma distribution",
             .source = "Bagher et al. 2012 (the distribution); Lambda by quadrature of Heitz 2014, section 3.4",
             .note =
                 "isotropic; the source has alpha and p per channel and a masking fitted to each, its f carries a factor 4 / pi",
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
