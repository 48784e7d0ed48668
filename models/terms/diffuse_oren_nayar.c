/* Rough diffuse surfaces, f in 1/sr: V-cavities with lambertian walls whose slope angles have the standard deviation sigma (Oren
 * and Nayar 1994), in full and in their qualitative form, and the energy-preserving model made from the latter (Portsmouth et al.
 * 2024).
 *
 * oren-nayar, with alpha and beta the larger and the lesser of both angles of incidence, phi the difference of azimuths:
 *   f  = kd/pi (C1 + C2 cos(phi) (sin(alpha) - [cos(phi) < 0] b^3) tan(beta) + C3 (1 - |cos(phi)|) (a b)^2 tan((alpha + beta)/2))
 *      + kd^2/pi C4 (1 - cos(phi) b^2),     a = 2 alpha/pi, b = 2 beta/pi, never below 0
 *   C1 = 1 - 0.5 v/(v + 0.33), C2 = 0.45 v/(v + 0.09), C3 = 0.125 v/(v + 0.09), C4 = 0.17 v/(v + 0.13), v = sigma^2
 *   (the paper writes (4 alpha beta / pi^2)^2 for (a b)^2)
 * oren-nayar-qualitative:
 *   f  = kd/pi (C1 + C2 max(0, cos(phi)) sin(alpha) tan(beta))
 * eon, with s = wi.wo - iz oz = cos(phi) sin(theta_i) sin(theta_o) and t = max(iz, oz) where s > 0, else 1:
 *   f  = rho/pi A (1 + r s/t) + rho_ms/pi (1 - E_i)(1 - E_o)/(1 - <E>),     A = 1/(1 + a1 r), a1 = 1/2 - 2/(3 pi)
 *   E  = A (1 + r G/pi), <E> = A (1 + a2 r), a2 = 2/3 - 28/(15 pi), rho_ms = rho^2 <E>/(1 - rho (1 - <E>))
 *   G  = sin(theta) (theta - sin(theta) cos(theta)) + (2/3) (tan(theta) (1 - sin^3(theta)) - sin(theta))
 * Here 1 - E = A r (a1 - G/pi) and 1 - <E> = A r (a1 - a2): the quotient needs no limit at r = 0. */
#include "internal_terms.h"
#include "internal_optics.h"
#include "base/internal_vector_math.h"

#define FF_ARGS const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d

/* An angle in [0, pi/2] and its sine. */
typedef struct inclination {
    double theta, sine;
} inclination;

/* acos(1 - t) = sqrt(t) p(t) on [0, 1]; the polynomial is a Chebyshev fit made with 50 digits, off by 3e-17. 2 ulp. */
static inline inclination inclination_of(double cosine)
{
    const double t = cosine < 1 ? 1 - cosine : 0, root_t = t * ff_rsqrt(t > 1e-60 ? t : 1e-60);
    double p = 4.7975410330206165536e-6;
    p = p * t - 3.5378354952821868479e-5;
    p = p * t + 1.2425167869548126938e-4;
    p = p * t - 2.6884644677358589363e-4;
    p = p * t + 4.006882818589302051e-4;
    p = p * t - 4.3000945159494794304e-4;
    p = p * t + 3.4809874714982453404e-4;
    p = p * t - 2.0499919349473680623e-4;
    p = p * t + 1.0871230018361806996e-4;
    p = p * t - 7.1858009923678480247e-6;
    p = p * t + 7.2870682571377915407e-5;
    p = p * t + 1.5250797182385683792e-4;
    p = p * t + 3.8370003612568147094e-4;
    p = p * t + 9.8869370645919837e-4;
    p = p * t + 2.685411542950586423e-3;
    p = p * t + 7.8918166870961976506e-3;
    p = p * t + 2.6516504295916166588e-2;
    p = p * t + 1.1785113019774604311e-1;
    p = p * t + 1.4142135623730950653;
    return (inclination){root_t * p, root_t * (2 - t) * ff_rsqrt(2 - t)};
}

/* factor v / (v + offset) with its derivative by sigma, v = sigma^2. */
typedef struct coefficient {
    double value, slope;
} coefficient;

static coefficient saturating(double factor, double offset, double sigma)
{
    const double v = sigma * sigma, inv = 1 / (v + offset);
    return (coefficient){factor * v * inv, factor * 2 * sigma * offset * inv * inv};
}

/* ---- oren-nayar ------------------------------------------------------------------------------ */

/* cos(phi), from wi.wo - iz oz over both sines. Where those vanish all that it multiplies does. */
static inline double cos_azimuth(double s, double sines)
{
    const double ratio = s * ff_recip(sines > 1e-30 ? sines : 1e-30);
    return ratio < -1 ? -1 : ratio > 1 ? 1 : ratio;
}

/* What C2, C3 and C4 multiply. */
static void cavity_shapes(const ff_geometry *g, size_t n, double *restrict p2, double *restrict p3, double *restrict p4)
{
    const double *restrict c = g->plane[FF_G_C], *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    for (size_t i = 0; i < n; i++) {
        const double cos_a = iz[i] < oz[i] ? iz[i] : oz[i], cos_b = iz[i] < oz[i] ? oz[i] : iz[i];
        const inclination alpha = inclination_of(cos_a), beta = inclination_of(cos_b);
        const double sin_a = alpha.sine, sin_b = beta.sine, a = 2 / FF_PI * alpha.theta, b = 2 / FF_PI * beta.theta;
        const double cos_phi = cos_azimuth(2 * c[i] * c[i] - 1 - cos_a * cos_b, sin_a * sin_b);
        const double away = cos_phi < 0 ? b * b * b : 0;
        p2[i] = cos_phi * (sin_a - away) * sin_b * ff_recip(cos_b);
        p3[i] = (1 - fabs(cos_phi)) * (a * b) * (a * b) * (sin_a + sin_b) * ff_recip(cos_a + cos_b);
        p4[i] = 1 - cos_phi * b * b;
    }
}

static void oren_nayar(FF_ARGS)
{
    const double kd = in->params[0], sigma = in->params[1];
    const coefficient c1 = saturating(-0.5, 0.33, sigma), c2 = saturating(0.45, 0.09, sigma), c3 = saturating(0.125, 0.09, sigma),
                      c4 = saturating(0.17, 0.13, sigma);
    double p2[FF_BLOCK], p3[FF_BLOCK], p4[FF_BLOCK], single[FF_BLOCK];
    cavity_shapes(g, n, p2, p3, p4);
    for (size_t i = 0; i < n; i++) single[i] = 1 + c1.value + c2.value * p2[i] + c3.value * p3[i];
    for (size_t i = 0; i < n; i++) {
        const double sum = single[i] + kd * c4.value * p4[i];
        f[i] = sum > 0 ? kd / FF_PI * sum : 0;
    }
    double *restrict dkd = ff_wanted_plane(d, 0), *restrict dsigma = ff_wanted_plane(d, 1);
    if (dkd)
        for (size_t i = 0; i < n; i++) {
            const double twice = kd * c4.value * p4[i];
            dkd[i] = single[i] + twice > 0 ? (single[i] + 2 * twice) / FF_PI : 0;
        }
    if (dsigma)
        for (size_t i = 0; i < n; i++) {
            const double sum = single[i] + kd * c4.value * p4[i];
            dsigma[i] = sum > 0 ? kd / FF_PI * (c1.slope + c2.slope * p2[i] + c3.slope * p3[i] + kd * c4.slope * p4[i]) : 0;
        }
}

/* s/t of the head of this file for s > 0, s otherwise. */
static inline double towards(double c, double iz, double oz)
{
    const double s = 2 * c * c - 1 - iz * oz, t = iz > oz ? iz : oz; /* wi.wo = 2 c^2 - 1 */
    return s > 0 ? s * ff_recip(t) : s;
}

static void oren_nayar_qualitative(FF_ARGS)
{
    const double kd = in->params[0], sigma = in->params[1];
    const double *restrict c = g->plane[FF_G_C], *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    const coefficient c1 = saturating(-0.5, 0.33, sigma), c2 = saturating(0.45, 0.09, sigma);
    double p2[FF_BLOCK], shape[FF_BLOCK];
    for (size_t i = 0; i < n; i++) { /* sin(alpha) tan(beta) cos(phi) = s / max(iz, oz) */
        const double q = towards(c[i], iz[i], oz[i]);
        p2[i] = q > 0 ? q : 0;
        shape[i] = 1 + c1.value + c2.value * p2[i];
    }
    ff_scaled(n, shape, kd / FF_PI, f);
    ff_scaled(n, shape, 1 / FF_PI, ff_wanted_plane(d, 0));
    double *restrict dsigma = ff_wanted_plane(d, 1);
    if (!dsigma) return;
    for (size_t i = 0; i < n; i++) dsigma[i] = kd / FF_PI * (c1.slope + c2.slope * p2[i]);
}

/* ---- eon ------------------------------------------------------------------------------------- */

#define FF_EON_A1 (0.5 - 2 / (3 * FF_PI))
#define FF_EON_A2 (2.0 / 3 - 28 / (15 * FF_PI))

/* (1 - E)/(A r) = a1 - G/pi, with tan (1 - sin^3) = sin cos (1 + sin + sin^2)/(1 + sin): finite at grazing angles. */
static inline double deficit(double cosine)
{
    const inclination w = inclination_of(cosine);
    const double s = w.sine, rim = s * cosine * (1 + s + s * s) * ff_recip(1 + s);
    const double G = s * (w.theta - s * cosine) + 2.0 / 3 * (rim - s);
    return FF_EON_A1 - G / FF_PI;
}

static void eon(FF_ARGS)
{
    const double rho = in->params[0], r = in->params[1];
    const double *restrict c = g->plane[FF_G_C], *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    const double A = 1 / (1 + FF_EON_A1 * r), dA = -FF_EON_A1 * A * A;
    const double mean = A * (1 + FF_EON_A2 * r), dmean = dA * (1 + FF_EON_A2 * r) + A * FF_EON_A2;
    const double inv = 1 / (1 - rho * (1 - mean)), multiple = rho * rho * mean * inv;
    const double d_rho = rho * mean * (2 - rho * (1 - mean)) * inv * inv, d_mean = rho * rho * (1 - rho) * inv * inv;
    double single[FF_BLOCK], both[FF_BLOCK];
    for (size_t i = 0; i < n; i++) single[i] = towards(c[i], iz[i], oz[i]);
    for (size_t i = 0; i < n; i++) both[i] = deficit(iz[i]) * deficit(oz[i]) * (1 / (FF_EON_A1 - FF_EON_A2));
    for (size_t i = 0; i < n; i++) f[i] = A / FF_PI * (rho * (1 + r * single[i]) + multiple * r * both[i]);
    double *restrict drho = ff_wanted_plane(d, 0), *restrict dr = ff_wanted_plane(d, 1);
    if (drho)
        for (size_t i = 0; i < n; i++) drho[i] = A / FF_PI * (1 + r * single[i] + d_rho * r * both[i]);
    if (dr)
        for (size_t i = 0; i < n; i++)
            dr[i] = 1 / FF_PI *
                    (dA * (rho * (1 + r * single[i]) + multiple * r * both[i]) +
                     A * (rho * single[i] + (multiple + d_mean * dmean * r) * both[i]));
}

/* ---- descriptors ----------------------------------------------------------------------------- */

#define FF_SIGMA                                                                                                                   \
    {                                                                                                                              \
        "sigma_facet", "rad", "standard deviation of the slope angle of the facets, sigma", 0, 0.5 * FF_PI, 0.3, 0, 0              \
    }

static const ff_param oren_nayar_params[] = {{"kd", "1", "albedo of the facets, rho", 0, 1, 0.1, FF_PARAM_PER_CHANNEL, 0},
                                             FF_SIGMA};

const ff_diffuse FF_ISA_NAME(ff_diffuse_oren_nayar) = {
    .term = {.name = "oren-nayar",
             .title = "rough lambertian surface, with light that goes between two facets",
             .source = "Oren and Nayar 1994, the functional approximation",
             .note = "not passive for a white surface: albedo up to 1.051 at sigma = 0.3, grazing. 0 where the source is negative: "
                     "opposite the light, grazing, for sigma > 0.66",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 2,
             .params = oren_nayar_params},
    .planes = 1u << FF_G_C | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .eval = oren_nayar};

static const ff_param qualitative_params[] = {
    {"kd", "1", "albedo of the facets, rho", 0, 1, 0.1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}, FF_SIGMA};

const ff_diffuse FF_ISA_NAME(ff_diffuse_oren_nayar_qualitative) = {
    .term = {.name = "oren-nayar-qualitative",
             .title = "rough lambertian surface, the short form without interreflection",
             .source = "Oren and Nayar 1994, the qualitative model",
             .note = "not passive for a white surface: albedo up to 1.015 at sigma = 0.20, grazing",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 2,
             .params = qualitative_params},
    .planes = 1u << FF_G_C | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .eval = oren_nayar_qualitative};

static const ff_param eon_params[] = {{"rho", "1", "albedo of the facets, rho", 0, 1, 0.1, FF_PARAM_PER_CHANNEL, 0},
                                      {"r", "1", "roughness of the diffuse term, r: 0 is lambert", 0, 1, 0.5, 0, 0}};

const ff_diffuse FF_ISA_NAME(ff_diffuse_eon) = {
    .term = {.name = "eon",
             .title = "rough lambertian surface that loses no energy: albedo 1 in every direction for rho = 1",
             .source = "Portsmouth, Kutz and Hill 2024 (EON), with the exact directional albedo",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
             .n_params = 2,
             .params = eon_params},
    .planes = 1u << FF_G_C | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .eval = eon};
