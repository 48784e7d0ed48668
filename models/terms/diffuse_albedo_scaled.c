/* albedo-scaled: what the lobes leave over of the view alone, as renderers put a layer on another.
 *
 *   kd / pi (1 - a_o),  a_o the directional albedo of all lobes seen from wo; 0 where that is above 1 */
#include "internal_optics.h"
#include "internal_terms.h"

static void eval(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    (void)g;
    const double scale = in->params[0] / FF_PI, *restrict a = in->ao;
    for (size_t i = 0; i < n; i++) f[i] = a[i] < 1 ? scale * (1 - a[i]) : 0;
    double *restrict dkd = ff_wanted_plane(d, 0), *restrict dai = ff_wanted_plane(d, FF_DD_AI),
                     *restrict da = ff_wanted_plane(d, FF_DD_AO);
    if (dkd)
        for (size_t i = 0; i < n; i++) dkd[i] = a[i] < 1 ? (1 - a[i]) / FF_PI : 0;
    if (dai)
        for (size_t i = 0; i < n; i++) dai[i] = 0;
    if (da)
        for (size_t i = 0; i < n; i++) da[i] = a[i] < 1 ? -scale : 0;
}

static const ff_param params[] = {{"kd", "1", "diffuse albedo, kd", 0, 1, 0.1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}};

const ff_diffuse FF_ISA_NAME(ff_diffuse_albedo_scaled) = {
    .term = {.name = "albedo-scaled",
             .title = "what the lobes leave over of the view: a layer on another",
             .source = "Smythe et al. 2016 to 2024, MaterialX 1.39, `layer`; Andersson et al. 2024, OpenPBR 1.1",
             .note = "not reciprocal: the light is not asked what it left",
             .claims = FF_ISOTROPIC,
             .n_params = 1,
             .params = params},
    .couples = FF_COUPLE_ALBEDO,
    .eval = eval};
