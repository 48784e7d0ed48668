/* Diffuse terms that know the lobes above them, f in 1/sr.
 *
 *   hammon             albedo (lerp(smooth, rough, alpha)/pi + albedo 0.1159 alpha), alpha of the first lobe, 1 where it is more,
 *                      smooth = 1.05 e(iz) e(oz), e(z) = 1 - (1 - z)^5,
 *                      rough = facing (0.9 - 0.4 facing)(1/2 + hz)/hz, facing = (1 + wi.wo)/2
 *   shirley-coupled    1.05 kd (1 - F0) e(iz) e(oz)/pi, where 1.05 = 21/20 normalises it
 *   mikkelsen-coupled  kd (1 - a_i)(1 - a_o)/pi, a the directional albedo of all lobes
 *   kelemen-matte      kd (1 - a_i)(1 - a_o)/(pi (1 - mean)), mean = 2 integral a(mu) mu dmu
 *   kulla-conty        Fms (1 - a_i)(1 - a_o)/(pi (1 - E)), a and their mean E of one lobe with F = 1,
 *                      Fms = F^2 E/(1 - F (1 - E)), F the average of its Fresnel term
 *
 * Lobes that are not passive reflect more than they receive in some directions. Nothing is left over there: 1 - a and 1 - F0 count
 * as 0 where they are negative.
 *
 * As 1 - mean goes to 0 (a perfect mirror) all 1 - a do, and the quotient with them, but not those of numbers that carry the error
 * of a quadrature: mean is held within [1e-6, 1 - 1e-6], with the derivative 0 outside. What that leaves out is less than 1e-6 of
 * the light. */
#include "internal_terms.h"
#include "internal_optics.h"
#include "base/internal_vector_math.h"

#define FF_ARGS const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d

/* The Fresnel transmission of a smooth surface over that at normal incidence, with Schlick's F. */
static inline double enters(double cosine)
{
    return 1 - ff_fifth(1 - cosine);
}

/* ---- hammon ---------------------------------------------------------------------------------- */

/* facing = c^2 and hz = (iz + oz) / (2 c). */
static void hammon(FF_ARGS)
{
    const double *restrict c = g->plane[FF_G_C], *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    const double albedo = in->params[0], alpha = in->alpha < 1 ? in->alpha : 1, multi = 0.1159;
    double smooth[FF_BLOCK], rise[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const double facing = c[i] * c[i], rough = facing * (0.9 - 0.4 * facing) * (1 + c[i] * ff_recip(iz[i] + oz[i]));
        smooth[i] = 1.05 / FF_PI * enters(iz[i]) * enters(oz[i]);
        rise[i] = rough / FF_PI - smooth[i];
    }
    for (size_t i = 0; i < n; i++) f[i] = albedo * (smooth[i] + alpha * (rise[i] + albedo * multi));
    double *restrict dalbedo = ff_wanted_plane(d, 0), *restrict dalpha = ff_wanted_plane(d, FF_DD_ALPHA);
    if (dalbedo)
        for (size_t i = 0; i < n; i++) dalbedo[i] = smooth[i] + alpha * (rise[i] + 2 * albedo * multi);
    if (dalpha) {
        const double inside = in->alpha < 1 ? albedo : 0;
        for (size_t i = 0; i < n; i++) dalpha[i] = inside * (rise[i] + albedo * multi);
    }
}

/* ---- what the lobes leave over --------------------------------------------------------------- */

static double positive(double x)
{
    return x > 0 ? x : 0;
}

static void shirley_coupled(FF_ARGS)
{
    const double *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    const double kd = in->params[0], left = positive(1 - in->f0);
    double shape[FF_BLOCK];
    for (size_t i = 0; i < n; i++) shape[i] = 1.05 / FF_PI * enters(iz[i]) * enters(oz[i]);
    ff_scaled(n, shape, kd * left, f);
    ff_scaled(n, shape, left, ff_wanted_plane(d, 0));
    ff_scaled(n, shape, in->f0 < 1 ? -kd : 0, ff_wanted_plane(d, FF_DD_F0));
}

/* (1 - a_i)(1 - a_o) times scale, with the derivatives by a_i and a_o. */
static void leftover(const ff_diffuse_input *in, size_t n, double scale, double *restrict f, double *restrict dai,
                     double *restrict dao)
{
    const double *restrict ai = in->ai, *restrict ao = in->ao;
    for (size_t i = 0; i < n; i++) {
        const double li = ai[i] < 1 ? 1 - ai[i] : 0, lo = ao[i] < 1 ? 1 - ao[i] : 0;
        f[i] = scale * li * lo;
    }
    if (dai)
        for (size_t i = 0; i < n; i++) {
            const double lo = ao[i] < 1 ? 1 - ao[i] : 0;
            dai[i] = ai[i] < 1 ? -scale * lo : 0;
        }
    if (dao)
        for (size_t i = 0; i < n; i++) {
            const double li = ai[i] < 1 ? 1 - ai[i] : 0;
            dao[i] = ao[i] < 1 ? -scale * li : 0;
        }
}

static void mikkelsen_coupled(FF_ARGS)
{
    (void)g;
    const double kd = in->params[0];
    double *restrict dkd = ff_wanted_plane(d, 0);
    leftover(in, n, kd / FF_PI, f, ff_wanted_plane(d, FF_DD_AI), ff_wanted_plane(d, FF_DD_AO));
    if (dkd) leftover(in, n, 1 / FF_PI, dkd, NULL, NULL);
}

/* The mean albedo, held away from 0 and from 1; `slope` is its derivative by what was given. */
typedef struct held_mean {
    double value, slope;
} held_mean;

static held_mean hold(double mean)
{
    const double edge = 1e-6;
    if (mean < edge) return (held_mean){edge, 0};
    return mean > 1 - edge ? (held_mean){1 - edge, 0} : (held_mean){mean, 1};
}

static void kelemen_matte(FF_ARGS)
{
    (void)g;
    const held_mean mean = hold(in->mean);
    const double kd = in->params[0], inv = 1 / (1 - mean.value);
    double *restrict dkd = ff_wanted_plane(d, 0), *restrict dmean = ff_wanted_plane(d, FF_DD_MEAN);
    leftover(in, n, kd / FF_PI * inv, f, ff_wanted_plane(d, FF_DD_AI), ff_wanted_plane(d, FF_DD_AO));
    if (dkd) leftover(in, n, 1 / FF_PI * inv, dkd, NULL, NULL);
    if (dmean) leftover(in, n, kd / FF_PI * inv * inv * mean.slope, dmean, NULL, NULL);
}

/* At each reflection F of the light stays, and E of that leaves the surface: F E + F (1 - E) F E + ..., the first of which is the
 * lobe itself. An F above 1 would feed on itself and counts as 1. */
static void kulla_conty(FF_ARGS)
{
    (void)g;
    const held_mean mean = hold(in->mean);
    const double E = mean.value, loss = 1 - E, F = in->f_average < 1 ? positive(in->f_average) : 1;
    const double inv = 1 / (1 - F * loss), Fms = F * F * E * inv;
    const double d_F = in->f_average > 0 && in->f_average <= 1 ? F * E * (2 - F * loss) * inv * inv : 0;
    const double d_mean = F * F * inv * inv * (1 - F) * mean.slope; /* d Fms / d E */
    double *restrict dmean = ff_wanted_plane(d, FF_DD_MEAN), *restrict df_average = ff_wanted_plane(d, FF_DD_F_AVERAGE);
    leftover(in, n, Fms / (FF_PI * loss), f, ff_wanted_plane(d, FF_DD_AI), ff_wanted_plane(d, FF_DD_AO));
    if (dmean) leftover(in, n, (d_mean + Fms / loss * mean.slope) / (FF_PI * loss), dmean, NULL, NULL);
    if (df_average) leftover(in, n, d_F / (FF_PI * loss), df_average, NULL, NULL);
}

/* ---- descriptors ----------------------------------------------------------------------------- */

static const ff_param kd_params[] = {{"kd", "1", "diffuse albedo, kd", 0, 1, 0.1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}};
static const ff_param hammon_params[] = {{"albedo", "1", "albedo of the facets", 0, 1, 0.1, FF_PARAM_PER_CHANNEL, 0}};

const ff_diffuse FF_ISA_NAME(ff_diffuse_hammon) = {
    .term = {.name = "hammon",
             .title = "diffuse facets below a ggx surface, fitted to path tracing",
             .source = "Hammon 2017, PBR Diffuse Lighting for GGX+Smith Microsurfaces (GDC)",
             .note = "not passive for a white surface: albedo up to 1.18 at alpha = 1, grazing. An alpha above 1 counts as 1",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 1,
             .params = hammon_params},
    .planes = 1u << FF_G_C | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .couples = FF_COUPLE_ALPHA,
    .eval = hammon};

const ff_diffuse FF_ISA_NAME(ff_diffuse_shirley_coupled) = {
    .term =
        {.name = "shirley-coupled",
         .title = "what a smooth surface with Schlick's Fresnel term lets in and out again",
         .source = "Shirley et al. 1997; Hammon 2017",
         .note =
             "the light that a lobe reflects is estimated by F0, so that the sum with a rough one is not passive: albedo 1.0044 "
             "above beckmann with alpha = 0.2, F0 = 0.04, at kd = 1 and cos = 0.6. By itself it is",
         .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
         .n_params = 1,
         .params = kd_params},
    .planes = 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .couples = FF_COUPLE_F0,
    .eval = shirley_coupled};

const ff_diffuse FF_ISA_NAME(ff_diffuse_mikkelsen_coupled) = {
    .term = {.name = "mikkelsen-coupled",
             .title = "what the lobes leave over, on the way in and on the way out",
             .source = "Mikkelsen 2009, eq. 28",
             .note = "with passive lobes the sum is passive; darker than kelemen-matte by the factor 1 - mean albedo",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
             .n_params = 1,
             .params = kd_params},
    .couples = FF_COUPLE_ALBEDO,
    .eval = mikkelsen_coupled};

const ff_diffuse FF_ISA_NAME(ff_diffuse_kelemen_matte) = {
    .term = {.name = "kelemen-matte",
             .title = "what the lobes leave over, all of it for kd = 1",
             .source = "Kelemen and Szirmay-Kalos 2001, section 2.2",
             .note = "with passive lobes the sum is passive, and its albedo is 1 in every direction for kd = 1",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
             .n_params = 1,
             .params = kd_params},
    .couples = FF_COUPLE_ALBEDO,
    .eval = kelemen_matte};

const ff_diffuse FF_ISA_NAME(ff_diffuse_kulla_conty) = {
    .term = {.name = "kulla-conty",
             .title = "what each lobe scatters more than once",
             .source = "Kulla and Conty 2017, Revisiting Physically Based Shading at Imageworks",
             .note = "with passive lobes the sum is passive; an average Fresnel above 1 counts as 1",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC},
    .couples = FF_COUPLE_LOSS,
    .eval = kulla_conty};
