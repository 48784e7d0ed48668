/* turquin: a lobe raised to what it would be if it lost nothing between its facets. Turquin 2019, Practical Multiple Scattering
 * Compensation for Microfacet Models, eq. 16.
 *
 *   f F0 (1 / E - 1),  f the lobe, F0 its Fresnel at normal incidence, E(wo) its directional albedo with F = 1
 *
 * so that lobe and term are f (1 + F0 (1/E - 1)). E is held above 1e-6; a lobe that is not passive loses nothing where E is
 * above 1. */
#include "internal_optics.h"
#include "internal_terms.h"

/* 1/E - 1 and its derivative. */
typedef struct loss {
    double value, slope;
} loss;

static inline loss loss_of(double E)
{
    const double least = 1e-6;
    if (E >= 1) return (loss){0, 0};
    if (E < least) return (loss){1 / least - 1, 0};
    const double inv = 1 / E;
    return (loss){inv - 1, -inv * inv};
}

static void eval(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    (void)g;
    const double f0 = in->f0 > 0 ? in->f0 : 0, *restrict lobe = in->lobe, *restrict E = in->ao;
    double *restrict dai = ff_wanted_plane(d, FF_DD_AI), *restrict dE = ff_wanted_plane(d, FF_DD_AO),
                     *restrict df0 = ff_wanted_plane(d, FF_DD_F0), *restrict dlobe = ff_wanted_plane(d, FF_DD_LOBE),
                     *restrict df_average = ff_wanted_plane(d, FF_DD_F_AVERAGE);
    for (size_t i = 0; i < n; i++) f[i] = lobe[i] * f0 * loss_of(E[i]).value;
    if (dai)
        for (size_t i = 0; i < n; i++) dai[i] = 0;
    if (df_average)
        for (size_t i = 0; i < n; i++) df_average[i] = 0;
    if (dE)
        for (size_t i = 0; i < n; i++) dE[i] = lobe[i] * f0 * loss_of(E[i]).slope;
    if (df0)
        for (size_t i = 0; i < n; i++) df0[i] = in->f0 > 0 ? lobe[i] * loss_of(E[i]).value : 0;
    if (dlobe)
        for (size_t i = 0; i < n; i++) dlobe[i] = f0 * loss_of(E[i]).value;
}

const ff_diffuse FF_ISA_NAME(ff_diffuse_turquin) = {
    .term = {.name = "turquin",
             .title = "each lobe raised to what it would reflect without loss between its facets",
             .source = "Turquin 2019, Practical Multiple Scattering Compensation for Microfacet Models, eq. 16",
             .note = "not reciprocal; with F = 1 as much as arrives is reflected towards every view",
             .claims = FF_ISOTROPIC},
    .couples = FF_COUPLE_LOSS | FF_COUPLE_LOBE | FF_COUPLE_F0,
    .eval = eval};
