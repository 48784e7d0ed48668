/* fresnel-coupled: what the facets of the first lobe let through. Khronos, glTF 2.0, appendix B (2021), fresnel_mix.
 *
 *   kd / pi (1 - ks F(wi.h)),  ks F of the first lobe; 0 where that is above 1 */
#include "internal_optics.h"
#include "internal_terms.h"

static void eval(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    (void)g;
    const double scale = in->params[0] / FF_PI, *restrict F = in->fresnel;
    for (size_t i = 0; i < n; i++) f[i] = F[i] < 1 ? scale * (1 - F[i]) : 0;
    double *restrict dkd = ff_wanted_plane(d, 0), *restrict dF = ff_wanted_plane(d, FF_DD_FRESNEL);
    if (dkd)
        for (size_t i = 0; i < n; i++) dkd[i] = F[i] < 1 ? (1 - F[i]) / FF_PI : 0;
    if (dF)
        for (size_t i = 0; i < n; i++) dF[i] = F[i] < 1 ? -scale : 0;
}

static const ff_param params[] = {{"kd", "1", "diffuse albedo, kd", 0, 1, 0.1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}};

const ff_diffuse FF_ISA_NAME(ff_diffuse_fresnel_coupled) = {
    .term = {.name = "fresnel-coupled",
             .title = "lambert times what the facet at the half vector lets through, 1 - F",
             .source = "Khronos Group 2021, glTF 2.0, appendix B",
             .note = "the rest of the facets is not looked at: the sum with a lobe is not passive; by itself it is",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
             .n_params = 1,
             .params = params},
    .couples = FF_COUPLE_FRESNEL,
    .eval = eval};
