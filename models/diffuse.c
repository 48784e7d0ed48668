/* Diffuse terms, f in 1/sr. */
#include "internal_terms.h"
#include "internal_vector_math.h"

/* kd / pi */
static void lambert(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    (void)g;
    for (size_t i = 0; i < n; i++) f[i] = params[0] * (1 / FF_PI);
    if (!d) return;
    for (size_t i = 0; i < n; i++) d[0][i] = 1 / FF_PI;
}

static const ff_param lambert_params[] = {{"kd", "1", "diffuse albedo, kd", 0, 1, 0.1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}};

const ff_optics FF_ISA_NAME(ff_diffuse_lambert) = {.term = {.name = "lambert",
                                                            .title = "the same in every direction: kd / pi",
                                                            .source = "Lambert 1760",
                                                            .note = "added to the lobes as it is, without coupling to their albedo",
                                                            .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC,
                                                            .n_params = 1,
                                                            .params = lambert_params},
                                                   .eval = lambert};
