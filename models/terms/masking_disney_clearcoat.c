/* disney-clearcoat: the separable Smith form of ggx with one roughness, 0.25, whatever that of the lobe. Burley 2012, course notes,
 * section 5.4: the clear coat is gtr with gamma = 1, for which this masking stands.
 *
 *   G1 = 2 c / (c + sqrt(a^2 + (1 - a^2) c^2)),  a = 1/4 */
#include "internal_terms.h"
#include "base/internal_vector_math.h"

static inline double g1(double cosine)
{
    const double a2 = 0.25 * 0.25, root2 = a2 + (1 - a2) * cosine * cosine;
    return 2 * cosine * ff_recip(cosine + root2 * ff_rsqrt(root2));
}

static void eval(double x, const ff_geometry *g, size_t n, const double *restrict li, const double *restrict lo, double *restrict G,
                 double *restrict gi, double *restrict go, double *restrict gx)
{
    (void)x, (void)li, (void)lo, (void)gi, (void)go, (void)gx;
    const double *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    for (size_t i = 0; i < n; i++) G[i] = g1(iz[i]) * g1(oz[i]);
}

const ff_masking FF_ISA_NAME(ff_masking_disney_clearcoat) = {
    .term = {.name = "disney-clearcoat",
             .title = "the separable form of ggx at alpha = 0.25, whatever the lobe has",
             .source = "Burley 2012, section 5.4",
             .note = "made for gtr with gamma = 1, ks = clearcoat / 4 and f0 = 0.04; not passive by itself, since a rough lobe is "
                     "masked as if it were smoother",
             .claims = FF_RECIPROCAL | FF_NEEDS_CENTRED},
    .uses_lambda = 0,
    .planes = 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .only = "gtr",
    .eval = eval};
