/* Fresnel terms of polarized light: what a dielectric and a conductor reflect of a source of which the share s is polarized
 * perpendicular to the plane of incidence of the sample, and 1 - s within it. The detector takes both.
 *
 * A facet has a plane of incidence of its own, which the light's direction and the half vector span; it is turned against that of
 * the sample by the angle psi about the light. Of light that is perpendicular to the latter the share cos^2 psi is so to the
 * former:
 *
 *   F = (Rs + Rp) / 2 + (2 s - 1) cos 2 psi (Rs - Rp) / 2
 *   cos^2 psi = (u.(t + s))^2 / (|t + s|^2 + (s x t)^2)
 *
 * with t = (wi.x, wi.y) / wi.z of the light, s the slope of the facet, whose normal is along (-s, 1), and u = t / |t|: the cosine
 * between the planes that the light spans with the normals of sample and facet, without a difference of cosines. The upper row of
 * the Mueller matrix of Priest and Meier (2002), for a detector without an analyser. In the plane of incidence psi is 0. At theta_i
 * = 0 the sample has no such plane, and that of the azimuth 0 stands for it: u = (1, 0). Where h = wi both reflectances are one. */
#include "internal_complex.h"
#include "internal_index.h"
#include "internal_optics.h"
#include "internal_terms.h"
#include "base/internal_vector_math.h"

#define FF_ARGS   const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d
#define FF_PLANES (1u << FF_G_C | 1u << FF_G_TIX | 1u << FF_G_TIY | 1u << FF_G_SX | 1u << FF_G_SY)

/* Below this tan^2 theta_i the light comes along the normal: what rounding leaves does not say from where. */
#define FF_NORMAL_INCIDENCE 1e-26

/* cos 2 psi of the i-th pair. Averages over F alone, which know no directions, have no such plane: light of both kinds. */
static inline double turned(const ff_geometry *g, size_t i)
{
    if (!g->plane[FF_G_TIX]) return 0;
    const double tx = g->plane[FF_G_TIX][i], ty = g->plane[FF_G_TIY][i], sx = g->plane[FF_G_SX][i], sy = g->plane[FF_G_SY][i];
    const double t2 = tx * tx + ty * ty, x = tx + sx, y = ty + sy, z = sx * ty - sy * tx;
    const int along = t2 < FF_NORMAL_INCIDENCE;
    const double within = along ? x : tx * x + ty * y,
                 share = within * within * ff_recip(ff_floored((along ? 1 : t2) * (x * x + y * y + z * z)));
    return 2 * (share < 1 ? share : 1) - 1;
}

static void dielectric(FF_ARGS)
{
    const double eta = params[0], q = 2 * params[1] - 1, N = eta * eta, *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) {
        const double w2 = ff_floored((eta - 1) * (eta + 1) + c[i] * c[i]), inv_w = ff_rsqrt(w2), w = w2 * inv_w, Nc = N * c[i];
        const double is = ff_recip(c[i] + w), ip = ff_recip(Nc + w), rs = (c[i] - w) * is, rp = (Nc - w) * ip;
        const double cos2 = turned(g, i), half = 0.5 * (rs * rs - rp * rp);
        f[i] = 0.5 * (rs * rs + rp * rp) + q * cos2 * half;
        if (!d) continue;
        const double step = 2 * eta * c[i] * inv_w, ds = -step * rs * is * is, dp = step * rp * (2 * w2 - N) * ip * ip;
        d[0][i] = ds + dp + q * cos2 * (ds - dp);
        d[1][i] = 2 * cos2 * half;
    }
}

static void conductor(FF_ARGS)
{
    const double eta = params[0], k = params[1], q = 2 * params[2] - 1, *restrict c = g->plane[FF_G_C];
    const ff_complex index = {eta, k}, N = {(eta - k) * (eta + k), 2 * eta * k};
    const double excess = (eta - 1) * (eta + 1) - k * k;
    for (size_t i = 0; i < n; i++) {
        const ff_complex w2 = {excess + c[i] * c[i], N.im}, w = ff_complex_root(w2.re, w2.im);
        const ff_complex qs = {c[i], 0}, qp = {N.re * c[i], N.im * c[i]};
        const double Rs = ff_reflected(qs, w), Rp = ff_reflected(qp, w), cos2 = turned(g, i), half = 0.5 * (Rs - Rp);
        f[i] = 0.5 * (Rs + Rp) + q * cos2 * half;
        if (!d) continue;
        const ff_complex inner = {2 * w2.re - N.re, 2 * w2.im - N.im};
        const double twice = 2 * c[i] * ff_recip(ff_floored(ff_complex_norm(w)));
        const ff_complex ratio = ff_complex_times(index, ff_complex_conjugate(w)), step = {twice * ratio.re, twice * ratio.im};
        const ff_complex ds = ff_reflected_slope(qs, w, step), dp = ff_reflected_slope(qp, w, ff_complex_times(step, inner));
        d[0][i] = dp.re - ds.re - q * cos2 * (ds.re + dp.re);
        d[1][i] = ds.im - dp.im + q * cos2 * (ds.im + dp.im);
        d[2][i] = 2 * cos2 * half;
    }
}

#define FF_SHARE                                                                                                                   \
    {                                                                                                                              \
        "s_share", "1", "share of s polarized light: 1 s, 0 p", 0, 1, 0.5, FF_PARAM_PER_CHANNEL | FF_PARAM_HELD, 0                 \
    }

static const ff_param dielectric_params[] = {{"eta", "1", "index of refraction over that of the medium outside, eta", 1,
                                              FF_DIELECTRIC_MAX, 1.5, FF_PARAM_PER_CHANNEL | FF_PARAM_LOG, -0.9},
                                             FF_SHARE};

const ff_fresnel FF_ISA_NAME(ff_fresnel_dielectric_polarized) = {
    .term = {.name = "dielectric-polarized",
             .title = "exact, of polarized light, without absorption",
             .source = "Fresnel's equations; Priest and Meier 2002; Hyde et al. 2009",
             .note = "s_share = 0.5 is dielectric; the detector takes light of both kinds",
             .claims = FF_PASSIVE,
             .n_params = 2,
             .params = dielectric_params,
             .contains = {"dielectric", "s_share", 0.5}},
    .planes = FF_PLANES,
    .eval = dielectric,
    .like_schlick = ff_dielectric_like};

static const ff_param conductor_params[] = {
    {"eta", "1", "real part of the index of refraction, eta", FF_CONDUCTOR_MIN, FF_CONDUCTOR_MAX, 1,
     FF_PARAM_PER_CHANNEL | FF_PARAM_LOG, 0},
    {"k", "1", "extinction coefficient, k", 0, FF_CONDUCTOR_MAX, 3, FF_PARAM_PER_CHANNEL | FF_PARAM_LOG, 0.1},
    FF_SHARE};

const ff_fresnel FF_ISA_NAME(ff_fresnel_conductor_polarized) = {
    .term = {.name = "conductor-polarized",
             .title = "exact, of polarized light, with absorption",
             .source = "Fresnel's equations with the index eta + i k; Priest and Meier 2002; Hyde et al. 2009",
             .note = "s_share = 0.5 is conductor; s and p light together tell eta and k apart, which the mean of both hardly does",
             .claims = FF_PASSIVE,
             .n_params = 3,
             .params = conductor_params,
             .contains = {"conductor", "s_share", 0.5}},
    .planes = FF_PLANES,
    .eval = conductor,
    .like_schlick = ff_conductor_like};
