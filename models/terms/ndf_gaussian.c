/* gaussian: a Gaussian of the angle. Blinn 1977 after Torrance and Sparrow 1967.
 *
 *   D = c exp(-(theta_m / sigma)^2),   1 / c = pi integral_0^(pi/2) exp(-(theta / sigma)^2) sin 2 theta dtheta,   p = D mz^4
 *
 * The source leaves c free; here it makes the projected area 1, by quadrature. */
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
    const double c = pass->c[C_C], sigma = pass->own[0], inv_s2 = 1 / (sigma * sigma);
    double t[FF_BLOCK], inv_t[FF_BLOCK], theta[FF_BLOCK], mz2[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const double x = q2[i] > 1e-280 ? q2[i] : 1e-280; /* theta / t below is 1 there */
        inv_t[i] = ff_rsqrt(x);
        t[i] = x * inv_t[i];
    }
    for (size_t i = 0; i < n; i++) theta[i] = ff_angle(t[i], 1);
    for (size_t i = 0; i < n; i++) {
        mz2[i] = ff_recip(1 + q2[i]);
        dlnp[i] = -(theta[i] * inv_t[i] * inv_s2 + 2) * mz2[i];
    }
    for (size_t i = 0; i < n; i++) p[i] = c * mz2[i] * mz2[i] * ff_exp(-theta[i] * theta[i] * inv_s2);
    if (!dlnp_own) return;
    double *restrict own = dlnp_own[0];
    for (size_t i = 0; i < n; i++) own[i] = pass->c[C_DLNC] + 2 / sigma * (theta[i] * theta[i] * inv_s2);
}

static void prepare(ff_ndf_pass *pass)
{
    enum { PANELS = 4, N = FF_GAUSS * PANELS };
    const double sigma = pass->own[0], end = fmin(FF_PI / 2, 6.5 * sigma);
    double theta[N], w[N], area = 0, slope = 0;
    ff_gauss_panels(0, end, PANELS, theta, w);
    for (int i = 0; i < N; i++) {
        const double x = theta[i] / sigma, f = w[i] * exp(-x * x) * sin(2 * theta[i]);
        area += f;
        slope += f * 2 * x * x / sigma;
    }
    pass->c[C_C] = 1 / (FF_PI * area);
    pass->c[C_DLNC] = -slope / area;
    ff_lambda_table_build(pass, 1, profile);
}

static const ff_param params[] = {{"sigma", "rad", "width of the angle, sigma", 1e-4, 4, 0.3, FF_PARAM_LOG, 0}};

const ff_ndf FF_ISA_NAME(ff_ndf_gaussian) = {
    .term = {.name = "gaussian",
             .title = "Gaussian of the half vector's angle",
             .source = "Blinn 1977 and Torrance and Sparrow 1967, normalised here; Lambda by quadrature of Heitz 2014, section 3.4",
             .note = "isotropic; sigma in radians, for small sigma the alpha of beckmann",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC | FF_UNIT_AREA | FF_WEAK_FURNACE,
             .n_params = 1,
             .params = params},
    .stretch = stretch,
    .n_own = 1,
    .alpha_own = 1,
    .table_size = FF_LAMBDA_TABLE(1),
    .prepare = prepare,
    .profile = profile,
    .lambda = ff_lambda_table,
};
