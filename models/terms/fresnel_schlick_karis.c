/* schlick-karis: Schlick's term with an exponential in place of the fifth power. Karis 2013, Real Shading in Unreal Engine 4.
 *
 *   F0 + (1 - F0) 2^((-5.55473 c - 6.98316) c) */
#include "internal_optics.h"
#include "internal_terms.h"

static inline double rise(double c)
{
    const double ln2 = 0.69314718055994531;
    return ff_exp(ln2 * (-5.55473 * c - 6.98316) * c);
}

static void eval(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    const double f0 = params[0], *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) {
        const double m = rise(c[i]);
        f[i] = m + (1 - m) * f0;
    }
    if (!d) return;
    double *restrict df0 = d[0];
    for (size_t i = 0; i < n; i++) df0[i] = 1 - rise(c[i]);
}

static const ff_param params[] = {
    {"f0", "1", "reflectance at normal incidence, F0", 0, 1, 0.5, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}};

const ff_fresnel FF_ISA_NAME(ff_fresnel_schlick_karis) = {
    .term = {.name = "schlick-karis",
             .title = "schlick with 2^((-5.55473 cos - 6.98316) cos) for (1 - cos)^5",
             .source = "Karis 2013, Real Shading in Unreal Engine 4",
             .note = "from 0.0029 (1 - F0) below schlick, at cos = 0.26, to 0.0038 above it, at 0.055; 0.00017 above it at normal "
                     "incidence",
             .claims = FF_RECIPROCAL | FF_PASSIVE,
             .n_params = 1,
             .params = params},
    .planes = 1u << FF_G_C,
    .eval = eval};
