/* Harvey-Shack: the scatter of polished surfaces in direction cosines, with a shoulder,
 *
 *   f = b0 (1 + (d / L)^2)^(s / 2),   d = |beta - beta_0| = |(wi + wo) . (x, y)| = 2 (wi.h) sin(theta_h)
 *
 * beta and beta_0 are the projections of the direction seen and of the mirror direction: the shape depends on their difference
 * alone, whatever the angle of incidence. b0 is the top, L the d at which the wing begins, s < 0 its slope in a plot with
 * logarithmic axes. k-correlation is the same curve with the obliquity of vector scattering theory,
 *
 *   f = b0 iz oz (1 + (d / L)^2)^(-(c + 1) / 2)
 *
 * where the curve is the power spectrum of heights at the spatial frequency d / wavelength: L is the wavelength over 2 pi times
 * the correlation length, c the exponent of a scan in one direction. */
#include "internal_terms.h"
#include "internal_optics.h"
#include "base/internal_vector_math.h"

/* b0 (1 + (d / L)^2)^p over a block, times `by` where it is not NULL; derivatives by b0, L and p. */
static void shoulder(double b0, double L, double p, const ff_geometry *g, size_t n, const double *restrict by, double *restrict f,
                     double *restrict db0, double *restrict dL, double *restrict dp)
{
    const double *restrict s2 = g->plane[FF_G_S2], *restrict c = g->plane[FF_G_C];
    const double least = L > 1e-30 ? L : 1e-30, inv_L2 = 1 / (least * least);
    double u[FF_BLOCK], ln[FF_BLOCK], shape[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        u[i] = 4 * c[i] * c[i] * s2[i] * ff_recip(1 + s2[i]) * inv_L2;
        ln[i] = ff_log1p(u[i]);
    }
    for (size_t i = 0; i < n; i++) shape[i] = ff_exp(p * ln[i]) * (by ? by[i] : 1);
    for (size_t i = 0; i < n; i++) f[i] = b0 * shape[i];
    if (db0)
        for (size_t i = 0; i < n; i++) db0[i] = shape[i];
    if (dL)
        for (size_t i = 0; i < n; i++) dL[i] = -2 * p / least * f[i] * u[i] * ff_recip(1 + u[i]);
    if (dp)
        for (size_t i = 0; i < n; i++) dp[i] = f[i] * ln[i];
}

static void harvey_shack(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    double *restrict ds = ff_wanted_plane(d, 2);
    shoulder(in->params[0], in->params[1], 0.5 * in->params[2], g, n, NULL, f, ff_wanted_plane(d, 0), ff_wanted_plane(d, 1), ds);
    for (size_t i = 0; ds && i < n; i++) ds[i] *= 0.5;
}

static void k_correlation(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    const double *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    double both[FF_BLOCK] = {0}, *restrict dc = ff_wanted_plane(d, 2);
    for (size_t i = 0; i < n; i++) both[i] = iz[i] * oz[i];
    shoulder(in->params[0], in->params[1], -0.5 * (in->params[2] + 1), g, n, both, f, ff_wanted_plane(d, 0), ff_wanted_plane(d, 1),
             dc);
    for (size_t i = 0; dc && i < n; i++) dc[i] *= -0.5;
}

static void harvey_shack_peak(const double *params, double *width, double *power)
{
    *width = params[1];
    *power = -0.5 * params[2];
}

/* What is left is iz oz, at most 1. */
static void k_correlation_peak(const double *params, double *width, double *power)
{
    *width = params[1];
    *power = 0.5 * (params[2] + 1);
}

static const ff_param harvey_shack_params[] = {
    {"hs_b0", "1/sr", "scatter in the mirror direction, b0", 0, 1e8, 1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0},
    {"hs_l", "1", "where the shoulder ends and the wing begins, L: a difference of direction cosines", 1e-6, 4, 0.01, FF_PARAM_LOG,
     0},
    {"hs_s", "1", "slope of the wing, s", -8, -0.05, -2, 0, 0},
};

const ff_diffuse FF_ISA_NAME(ff_diffuse_harvey_shack) = {
    .term = {.name = "harvey-shack",
             .title = "scatter of a polished surface with a shoulder, b0 (1 + (|beta - beta_0| / L)^2)^(s/2)",
             .source = "Harvey 1976; Pfisterer 2011, Approximated scatter models for stray light analysis",
             .note = "in direction cosines; data over many decades are fitted by the loss ln; nothing bounds what it reflects",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 3,
             .params = harvey_shack_params},
    .planes = 1u << FF_G_C | 1u << FF_G_S2,
    .eval = harvey_shack,
    .peak = harvey_shack_peak};

static const ff_param k_correlation_params[] = {
    {"kc_b0", "1/sr", "scatter in the mirror direction at normal incidence, b0", 0, 1e8, 1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR,
     0},
    {"kc_l", "1", "wavelength over 2 pi correlation lengths, L: a difference of direction cosines", 1e-6, 4, 0.01, FF_PARAM_LOG, 0},
    {"kc_c", "1", "exponent of the power spectrum along a line, c", 0.1, 6, 1.5, 0, 0},
};

const ff_diffuse FF_ISA_NAME(ff_diffuse_k_correlation) = {
    .term = {.name = "k-correlation",
             .title = "scatter of a smooth surface by its power spectrum, b0 iz oz (1 + (|beta - beta_0| / L)^2)^(-(c+1)/2)",
             .source = "Church and Takacs 1991; Dittman 2006, K-correlation power spectral density and surface scatter model",
             .note = "to first order in the heights, which are far below the wavelength; its reflectance (Q) is part of b0",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 3,
             .params = k_correlation_params},
    .planes = 1u << FF_G_C | 1u << FF_G_S2 | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .eval = k_correlation,
    .peak = k_correlation_peak};
