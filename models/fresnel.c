/* Fresnel terms F(c), c = wi.h. */
#include "internal_terms.h"

/* F0 + (1 - F0)(1 - c)^5: linear in F0. */
static void schlick(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    const double f0 = params[0], *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) {
        const double m = 1 - c[i], m2 = m * m, m5 = m2 * m2 * m;
        f[i] = m5 + (1 - m5) * f0;
    }
    if (!d) return;
    double *restrict df0 = d[0];
    for (size_t i = 0; i < n; i++) {
        const double m = 1 - c[i], m2 = m * m;
        df0[i] = 1 - m2 * m2 * m;
    }
}

static void none(const double *params, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    (void)params, (void)g, (void)d;
    for (size_t i = 0; i < n; i++) f[i] = 1;
}

static const ff_param schlick_params[] = {
    {"f0", "1", "reflectance at normal incidence, F0", 0, 1, 0.5, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0}};

const ff_optics FF_ISA_NAME(ff_fresnel_schlick) = {.term = {.name = "schlick",
                                                            .title = "F0 + (1 - F0)(1 - cos)^5",
                                                            .source = "Schlick 1994",
                                                            .note = "",
                                                            .claims = FF_RECIPROCAL | FF_PASSIVE,
                                                            .n_params = 1,
                                                            .params = schlick_params},
                                                   .planes = 1u << FF_G_C,
                                                   .eval = schlick};

const ff_optics FF_ISA_NAME(ff_fresnel_none) = {.term = {.name = "none",
                                                         .title = "F = 1: a perfect mirror in every facet",
                                                         .source = "",
                                                         .note = "the lobe then has no free scale",
                                                         .claims = FF_RECIPROCAL | FF_PASSIVE},
                                                .eval = none};
