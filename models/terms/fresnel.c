/* Fresnel terms F(c), c = wi.h in (0, 1], of unpolarised light: Schlick's and two terms linear in their parameters like it, and
 * the exact equations for a dielectric and a conductor.
 *
 *   schlick      F0 + (1 - F0) m^5,  m = 1 - c
 *   schlick-f82  schlick(c) - b(c) (schlick(cb) - F82),  b(c) = c m^6 / (cb (1 - cb)^6),  cb = 1/7
 *   sgd          F0 - F1 c + (1 - F0) m^5
 *   dielectric, conductor
 *                (|rs|^2 + |rp|^2) / 2,  rs = (c - w) / (c + w),  rp = (N c - w) / (N c + w),  w = sqrt(N - s^2),
 *                N = (eta + i k)^2,  s^2 = 1 - c^2
 *
 * At c = 1 every one of them is exact: m = 0 and w = eta + i k. */
#include "internal_terms.h"
#include "internal_complex.h"
#include "internal_index.h"
#include "internal_optics.h"
#include "base/internal_vector_math.h"

#define FF_ARGS const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d

/* ---- linear in their parameters -------------------------------------------------------------- */

static void schlick(FF_ARGS)
{
    const double f0 = params[0], *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) {
        const double m5 = ff_fifth(1 - c[i]);
        f[i] = m5 + (1 - m5) * f0;
    }
    if (!d) return;
    double *restrict df0 = d[0];
    for (size_t i = 0; i < n; i++) df0[i] = 1 - ff_fifth(1 - c[i]);
}

static void schlick_f82(FF_ARGS)
{
    const double cb = 1.0 / 7, mb5 = ff_fifth(1 - cb), inv_dip = 1 / (cb * (1 - cb) * mb5);
    const double f0 = params[0], f82 = params[1], miss = mb5 + (1 - mb5) * f0 - f82, *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) {
        const double m = 1 - c[i], m5 = ff_fifth(m), b = c[i] * m * m5 * inv_dip;
        f[i] = m5 + (1 - m5) * f0 - b * miss;
    }
    if (!d) return;
    double *restrict df0 = d[0], *restrict df82 = d[1];
    for (size_t i = 0; i < n; i++) {
        const double m = 1 - c[i], m5 = ff_fifth(m), b = c[i] * m * m5 * inv_dip;
        df0[i] = 1 - m5 - b * (1 - mb5);
        df82[i] = b;
    }
}

static void sgd(FF_ARGS)
{
    const double f0 = params[0], f1 = params[1], *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) {
        const double m5 = ff_fifth(1 - c[i]);
        f[i] = m5 + (1 - m5) * f0 - f1 * c[i];
    }
    if (!d) return;
    double *restrict df0 = d[0], *restrict df1 = d[1];
    for (size_t i = 0; i < n; i++) {
        df0[i] = 1 - ff_fifth(1 - c[i]);
        df1[i] = -c[i];
    }
}

/* ---- the exact equations --------------------------------------------------------------------- */

static void dielectric(FF_ARGS)
{
    const double eta = params[0], *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) f[i] = ff_dielectric(eta, c[i]);
    if (!d) return;
    double *restrict deta = d[0];
    for (size_t i = 0; i < n; i++) deta[i] = ff_dielectric_slope(eta, c[i]);
}

/* F is the squared modulus of functions that are analytic in eta + i k: with r' their derivative by it, d|r|^2/d eta = 2 Re(conj(r)
 * r') and d|r|^2/d k = -2 Im(conj(r) r'); and w' = (eta + i k) / w. */
static void conductor(FF_ARGS)
{
    const double eta = params[0], k = params[1], *restrict c = g->plane[FF_G_C];
    const ff_complex index = {eta, k}, N = {(eta - k) * (eta + k), 2 * eta * k};
    const double excess = (eta - 1) * (eta + 1) - k * k;
    for (size_t i = 0; i < n; i++) {
        const ff_complex w = ff_complex_root(excess + c[i] * c[i], N.im), qs = {c[i], 0}, qp = {N.re * c[i], N.im * c[i]};
        f[i] = 0.5 * (ff_reflected(qs, w) + ff_reflected(qp, w));
    }
    if (!d) return;
    double *restrict deta = d[0], *restrict dk = d[1];
    for (size_t i = 0; i < n; i++) {
        const ff_complex w = ff_complex_root(excess + c[i] * c[i], N.im), qs = {c[i], 0}, qp = {N.re * c[i], N.im * c[i]};
        const ff_complex w2 = {excess + c[i] * c[i], N.im}, inner = {2 * w2.re - N.re, 2 * w2.im - N.im};
        const double twice = 2 * c[i] * ff_recip(ff_floored(ff_complex_norm(w)));
        const ff_complex ratio = ff_complex_times(index, ff_complex_conjugate(w)),
                         step = {twice * ratio.re, twice * ratio.im}; /* 2 c index / w */
        const ff_complex ds = ff_reflected_slope(qs, w, step), dp = ff_reflected_slope(qp, w, ff_complex_times(step, inner));
        deta[i] = dp.re - ds.re;
        dk[i] = ds.im - dp.im;
    }
}

/* ---- descriptors ----------------------------------------------------------------------------- */

static void none(FF_ARGS)
{
    (void)params, (void)g, (void)d;
    for (size_t i = 0; i < n; i++) f[i] = 1;
}

#define FF_LINEAR (FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR)

static const ff_param schlick_params[] = {{"f0", "1", "reflectance at normal incidence, F0", 0, 1, 0.5, FF_LINEAR, 0}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_schlick) = {.term = {.name = "schlick",
                                                             .title = "F0 + (1 - F0)(1 - cos)^5",
                                                             .source = "Schlick 1994",
                                                             .note = "",
                                                             .claims = FF_RECIPROCAL | FF_PASSIVE,
                                                             .n_params = 1,
                                                             .params = schlick_params},
                                                    .planes = 1u << FF_G_C,
                                                    .eval = schlick};

static const ff_param schlick_f82_params[] = {{"f0", "1", "reflectance at normal incidence, F0", 0, 1, 0.5, FF_LINEAR, 0},
                                              {"f82", "1", "reflectance at cos = 1/7 (82 degrees), F82", 0, 1, 0.7, FF_LINEAR, 0}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_schlick_f82) = {
    .term = {.name = "schlick-f82",
             .also = "f82,f82-tint",
             .title = "schlick with the dip or tint of metals near grazing incidence",
             .source = "Hoffman 2019; Kutz et al. 2021 (Adobe Standard Material)",
             .note = "F stays in [0, 1] for F82 from 0.511 times Schlick's own value there, 0.463 + 0.537 F0, up to that value; "
                     "outside it goes to "
                     "-0.127 and 1.127 at most",
             .claims = FF_RECIPROCAL,
             .n_params = 2,
             .params = schlick_f82_params},
    .planes = 1u << FF_G_C,
    .eval = schlick_f82};

static const ff_param dielectric_params[] = {{"eta", "1", "index of refraction over that of the medium outside, eta", 1,
                                              FF_DIELECTRIC_MAX, 1.5, FF_PARAM_PER_CHANNEL | FF_PARAM_LOG, -0.9}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_dielectric) = {.term = {.name = "dielectric",
                                                                .title = "exact, unpolarised, without absorption",
                                                                .source = "Fresnel's equations; Cook and Torrance 1982",
                                                                .note = "eta = 1 reflects nothing",
                                                                .claims = FF_RECIPROCAL | FF_PASSIVE,
                                                                .n_params = 1,
                                                                .params = dielectric_params},
                                                       .planes = 1u << FF_G_C,
                                                       .eval = dielectric,
                                                       .like_schlick = ff_dielectric_like};

static const ff_param conductor_params[] = {
    {"eta", "1", "real part of the index of refraction, eta", FF_CONDUCTOR_MIN, FF_CONDUCTOR_MAX, 1,
     FF_PARAM_PER_CHANNEL | FF_PARAM_LOG, 0},
    {"k", "1", "extinction coefficient, k", 0, FF_CONDUCTOR_MAX, 3, FF_PARAM_PER_CHANNEL | FF_PARAM_LOG, 0.1}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_conductor) = {
    .term = {.name = "conductor",
             .title = "exact, unpolarised, with absorption",
             .source = "Fresnel's equations with the index eta + i k; Cook and Torrance 1982",
             .note =
                 "k = 0 is a dielectric, with total reflection where eta < 1; data far from grazing incidence determine F0, not "
                 "eta and k apart",
             .claims = FF_RECIPROCAL | FF_PASSIVE,
             .n_params = 2,
             .params = conductor_params},
    .planes = 1u << FF_G_C,
    .eval = conductor,
    .like_schlick = ff_conductor_like};

static const ff_param sgd_params[] = {{"f0", "1", "F0 of the source; at normal incidence F = F0 - F1", 0, 10, 0.5, FF_LINEAR, 0},
                                      {"f1", "1", "slope by the cosine, F1", -2, 10, 0, FF_LINEAR, 0}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_sgd) = {
    .term = {.name = "sgd",
             .title = "F0 - F1 cos + (1 - F0)(1 - cos)^5",
             .source = "Bagher et al. 2012",
             .note = "made to follow measurements, not to stay in [0, 1]: above 1 for F0 > 1, negative near the normal for F1 > F0",
             .claims = FF_RECIPROCAL,
             .n_params = 2,
             .params = sgd_params},
    .planes = 1u << FF_G_C,
    .eval = sgd};

const ff_fresnel FF_ISA_NAME(ff_fresnel_none) = {.term = {.name = "none",
                                                          .title = "F = 1: a perfect mirror in every facet",
                                                          .source = "",
                                                          .note = "the lobe then has no free scale",
                                                          .claims = FF_RECIPROCAL | FF_PASSIVE},
                                                 .eval = none};
