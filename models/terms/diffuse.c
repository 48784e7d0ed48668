/* Diffuse terms that need no angle: Lambert's and Disney's, f in 1/sr.
 *
 *   lambert  kd / pi
 *   disney   kd/pi (1 + (F90 - 1)(1 - iz)^5) (1 + (F90 - 1)(1 - oz)^5),  F90 = 1/2 + 2 rough c^2,  c = wi.h
 *
 * Burley's shader has one roughness for both terms, alpha = roughness^2: disney-coupled takes rough = sqrt(alpha) of the first
 * lobe, disney its own. */
#include "internal_terms.h"
#include "internal_optics.h"
#include "base/internal_vector_math.h"

#define FF_ARGS const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d

/* ---- lambert --------------------------------------------------------------------------------- */

static void lambert(FF_ARGS)
{
    (void)g;
    const double value = in->params[0] / FF_PI;
    for (size_t i = 0; i < n; i++) f[i] = value;
    double *restrict dkd = ff_wanted_plane(d, 0);
    if (!dkd) return;
    for (size_t i = 0; i < n; i++) dkd[i] = 1 / FF_PI;
}

/* ---- disney ---------------------------------------------------------------------------------- */

/* f and its derivatives by kd and rough. */
static void burley(double kd, double rough, const ff_geometry *g, size_t n, double *restrict f, double *restrict dkd,
                   double *restrict drough)
{
    const double *restrict c = g->plane[FF_G_C], *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    double shape[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const double rise = 2 * rough * c[i] * c[i] - 0.5;
        shape[i] = (1 + rise * ff_fifth(1 - iz[i])) * (1 + rise * ff_fifth(1 - oz[i]));
    }
    ff_scaled(n, shape, kd / FF_PI, f);
    ff_scaled(n, shape, 1 / FF_PI, dkd);
    if (!drough) return;
    for (size_t i = 0; i < n; i++) {
        const double twice = 2 * c[i] * c[i], rise = rough * twice - 0.5, mi = ff_fifth(1 - iz[i]), mo = ff_fifth(1 - oz[i]);
        drough[i] = kd / FF_PI * twice * (mi * (1 + rise * mo) + mo * (1 + rise * mi));
    }
}

static void disney(FF_ARGS)
{
    burley(in->params[0], in->params[1], g, n, f, ff_wanted_plane(d, 0), ff_wanted_plane(d, 1));
}

static void disney_coupled(FF_ARGS)
{
    const double rough = sqrt(in->alpha);
    double *restrict dalpha = ff_wanted_plane(d, FF_DD_ALPHA);
    burley(in->params[0], rough, g, n, f, ff_wanted_plane(d, 0), dalpha);
    if (!dalpha) return;
    for (size_t i = 0; i < n; i++) dalpha[i] *= 0.5 / rough;
}

/* ---- descriptors ----------------------------------------------------------------------------- */

#define FF_KD                                                                                                                      \
    {                                                                                                                              \
        "kd", "1", "diffuse albedo, kd", 0, 1, 0.1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0                                      \
    }

static const ff_param kd_params[] = {FF_KD};

const ff_diffuse FF_ISA_NAME(ff_diffuse_lambert) = {
    .term = {.name = "lambert",
             .also = "lambertian",
             .title = "the same in every direction: kd / pi",
             .source = "Lambert 1760",
             .note = "added to the lobes as it is, without coupling to their albedo",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
             .n_params = 1,
             .params = kd_params},
    .eval = lambert};

static const ff_param disney_params[] = {FF_KD,
                                         {"rough", "1", "roughness of the diffuse term, 0 smooth, 1 rough", 0, 1, 0.5, 0, 0}};

const ff_diffuse FF_ISA_NAME(ff_diffuse_disney) = {
    .term = {.name = "disney",
             .title = "darker or brighter towards grazing angles with its own roughness",
             .source = "Burley 2012, section 5.3",
             .note = "not passive for a white surface: albedo above 1 for rough > 0.4, up to 1.56 at rough = 1, grazing",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 2,
             .params = disney_params},
    .planes = 1u << FF_G_C | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .eval = disney};

const ff_diffuse FF_ISA_NAME(ff_diffuse_disney_coupled) = {
    .term = {.name = "disney-coupled",
             .title = "disney with the roughness of the first lobe, sqrt(alpha)",
             .source = "Burley 2012, section 5.3 and 5.4",
             .note = "not passive for a white surface, as disney; meant for alpha up to 1",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 1,
             .params = kd_params},
    .planes = 1u << FF_G_C | 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .couples = FF_COUPLE_ALPHA,
    .eval = disney_coupled};
