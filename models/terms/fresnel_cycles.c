/* cycles: the exact curve of a dielectric between F0 and 1. Cycles of Blender 2.79 to 3.6, interpolate_fresnel_color.
 *
 *   F = F0 + (1 - F0) H,  H = (F_d(c, eta) - R) / (1 - R),  R = ((eta - 1) / (eta + 1))^2
 *
 * With F0 = R it is F_d, the dielectric; with the base colour for F0 the metal. Between them is F0 = metallic base + (1 - metallic)
 * R. The box ends at eta = 2, beyond the specular of 1: of an index above 3.7 the
 * curve first falls, and F would be negative.
 * Derivatives: H = 1 - (1 - F_d) / (1 - R), and dR/d eta = 4 (eta - 1) / (eta + 1)^3. */
#include "internal_optics.h"
#include "internal_terms.h"

static void eval(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    const double f0 = params[0], eta = params[1], root = (eta - 1) / (eta + 1), inv = 1 / (1 - root * root);
    const double *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) f[i] = 1 - (1 - f0) * (1 - ff_dielectric(eta, c[i])) * inv;
    if (!d) return;
    double *restrict df0 = d[0], *restrict deta = d[1];
    for (size_t i = 0; i < n; i++) df0[i] = (1 - ff_dielectric(eta, c[i])) * inv;
    const double slope = 4 * root / ((eta + 1) * (eta + 1)) * inv;
    for (size_t i = 0; i < n; i++)
        deta[i] = (1 - f0) * inv * (ff_dielectric_slope(eta, c[i]) - (1 - ff_dielectric(eta, c[i])) * slope);
}

static const ff_param params[] = {
    {"f0", "1", "reflectance at normal incidence, F0", 0, 1, 0.5, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0},
    {"eta", "1", "index whose curve it follows, eta: 2 / (1 - sqrt(0.08 specular)) - 1", 1, 2, 1.5,
     FF_PARAM_PER_CHANNEL | FF_PARAM_LOG | FF_PARAM_HELD, -0.9}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_cycles) = {
    .term = {.name = "cycles",
             .title = "the curve of a dielectric drawn from F0 to 1",
             .source = "Cycles of Blender 2.79 to 3.6: the Principled BSDF",
             .note = "eta is 1.5 for the specular of 0.5 that Blender starts with; dielectric where F0 is that of eta",
             .claims = FF_RECIPROCAL | FF_PASSIVE,
             .n_params = 2,
             .params = params},
    .planes = 1u << FF_G_C,
    .eval = eval};
