/* Masking and shadowing, G2. Heitz 2014 (RR-8468), eq. 19-24, unless a descriptor names another source. Each kernel gives G and the
 * derivatives of ln G by both Lambdas and by x, its own parameter or the roughness of the lobe.
 * The factors chi+ hold by construction: a half vector of two directions above the horizon is on their side.
 * Where max or min make a kink, the derivative is that of the branch taken. */
#include "internal_terms.h"
#include "base/internal_vector_math.h"

#define FF_ARGS                                                                                                                    \
    double x, const ff_geometry *g, size_t n, const double *restrict li, const double *restrict lo, double *restrict G,            \
        double *restrict gi, double *restrict go, double *restrict gx

static void smith_masking_only(FF_ARGS)
{
    (void)x, (void)g, (void)li, (void)gx;
    for (size_t i = 0; i < n; i++) {
        G[i] = ff_recip(1 + lo[i]);
        gi[i] = 0;
        go[i] = -G[i];
    }
}

static void smith_separable(FF_ARGS)
{
    (void)x, (void)g, (void)gx;
    for (size_t i = 0; i < n; i++) {
        const double g1i = ff_recip(1 + li[i]), g1o = ff_recip(1 + lo[i]);
        G[i] = g1i * g1o;
        gi[i] = -g1i;
        go[i] = -g1o;
    }
}

static void smith_height_correlated(FF_ARGS)
{
    (void)x, (void)g, (void)gx;
    for (size_t i = 0; i < n; i++) {
        G[i] = ff_recip(1 + li[i] + lo[i]);
        gi[i] = go[i] = -G[i];
    }
}

/* k(phi) = w phi / (w phi + 1) of van Ginneken et al. 1998: 0 at equal azimuths, towards 1 where masking and shadowing are
 * independent. */
static inline double apart(double w, double phi)
{
    return w * phi * ff_recip(w * phi + 1);
}

static const double ginneken = 4.41; /* of van Ginneken et al. 1998, found by ray tracing */

static void smith_direction_correlated(FF_ARGS)
{
    (void)x, (void)gx;
    const double *restrict phi = g->plane[FF_G_PHI];
    for (size_t i = 0; i < n; i++) {
        const double k = apart(ginneken, phi[i]);
        const double g1i = ff_recip(1 + li[i]), g1o = ff_recip(1 + lo[i]);
        const double lesser = g1i < g1o ? g1i : g1o, greater = g1i < g1o ? g1o : g1i;
        const double blend = k * greater + (1 - k); /* G = lesser * blend; k = 0 only at equal azimuths, where blend = 1 */
        const double d_greater = -k * greater * greater * ff_recip(blend);
        G[i] = lesser * blend;
        gi[i] = g1i < g1o ? -g1i : d_greater;
        go[i] = g1i < g1o ? d_greater : -g1o;
    }
}

static void smith_height_direction_correlated(FF_ARGS)
{
    const double *restrict phi = g->plane[FF_G_PHI];
    for (size_t i = 0; i < n; i++) {
        const double k = apart(x, phi[i]), wi = li[i] < lo[i] ? k : 1, wo = li[i] < lo[i] ? 1 : k;
        G[i] = ff_recip(1 + wi * li[i] + wo * lo[i]);
        gi[i] = -wi * G[i];
        go[i] = -wo * G[i];
    }
    if (!gx) return;
    for (size_t i = 0; i < n; i++) { /* d k / d w = phi / (w phi + 1)^2 */
        const double inv = ff_recip(x * phi[i] + 1), lesser = li[i] < lo[i] ? li[i] : lo[i];
        gx[i] = -G[i] * lesser * phi[i] * inv * inv;
    }
}

static void v_cavity(FF_ARGS)
{
    (void)x, (void)li, (void)lo, (void)gi, (void)go, (void)gx;
    for (size_t i = 0; i < n; i++) G[i] = g->plane[FF_G_VCAVITY][i];
}

/* G / (4 iz oz) = 1 / (4 c^2). With hz = (iz + oz) / (2 c) the V-cavity has min(1, (iz + oz) iz / c^2, (iz + oz) oz / c^2), which
 * is never less. */
static void kelemen(FF_ARGS)
{
    (void)x, (void)li, (void)lo, (void)gi, (void)go, (void)gx;
    const double *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O], *restrict c = g->plane[FF_G_C];
    for (size_t i = 0; i < n; i++) G[i] = iz[i] * oz[i] * ff_recip(c[i] * c[i]);
}

/* Smith's height-correlated G2 for ggx with Lambda = alpha (1 - cos)/(2 cos), that is with cos + alpha (1 - cos) for sqrt(cos^2 +
 * alpha^2 sin^2). */
static void hammon(FF_ARGS)
{
    (void)li, (void)lo, (void)gi, (void)go;
    const double *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    for (size_t i = 0; i < n; i++) {
        const double product = 2 * iz[i] * oz[i];
        G[i] = product * ff_recip(product + x * (iz[i] + oz[i] - product));
    }
    if (!gx) return;
    for (size_t i = 0; i < n; i++) {
        const double product = 2 * iz[i] * oz[i], rise = iz[i] + oz[i] - product;
        gx[i] = -rise * ff_recip(product + x * rise);
    }
}

/* The same Lambda in the separable form: G1 = cos / (cos (1 - k) + k), k = alpha / 2. */
static void schlick_smith(FF_ARGS)
{
    (void)li, (void)lo, (void)gi, (void)go;
    const double k = 0.5 * x, *restrict iz = g->plane[FF_G_COS_I], *restrict oz = g->plane[FF_G_COS_O];
    for (size_t i = 0; i < n; i++) G[i] = iz[i] * oz[i] * ff_recip((iz[i] + k * (1 - iz[i])) * (oz[i] + k * (1 - oz[i])));
    if (!gx) return;
    for (size_t i = 0; i < n; i++) {
        const double si = 1 - iz[i], so = 1 - oz[i];
        gx[i] = -0.5 * (si * ff_recip(iz[i] + k * si) + so * ff_recip(oz[i] + k * so));
    }
}

static void none(FF_ARGS)
{
    (void)x, (void)g, (void)li, (void)lo, (void)gi, (void)go, (void)gx;
    for (size_t i = 0; i < n; i++) G[i] = 1;
}

const ff_masking FF_ISA_NAME(ff_masking_smith_masking_only) = {
    .term = {.name = "smith-masking-only",
             .title = "G1(wo) alone",
             .source = "Heitz 2014, eq. 19",
             .note = "not reciprocal: exists for the weak white furnace test",
             .claims = FF_PASSIVE | FF_WEAK_FURNACE | FF_FURNACE_ONLY},
    .uses_lambda = 1,
    .eval = smith_masking_only};

const ff_masking FF_ISA_NAME(ff_masking_smith_separable) = {
    .term = {.name = "smith-separable",
             .also = "smith-uncorrelated",
             .title = "G1(wi) G1(wo): masking and shadowing independent",
             .source = "Smith 1967; Walter et al. 2007, eq. 23; Heitz 2014, eq. 20",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE},
    .uses_lambda = 1,
    .eval = smith_separable};

const ff_masking FF_ISA_NAME(ff_masking_smith_height_correlated) = {
    .term = {.name = "smith-height-correlated",
             .also = "smith-correlated,smith-joint",
             .title = "correlated by the height of the microsurface",
             .source = "Ross et al. 2005; Heitz 2014, eq. 21",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE},
    .uses_lambda = 1,
    .eval = smith_height_correlated};

const ff_masking FF_ISA_NAME(ff_masking_smith_direction_correlated) = {
    .term = {.name = "smith-direction-correlated",
             .title = "correlated by the azimuth difference",
             .source = "Ashikhmin et al. 2000; van Ginneken et al. 1998; Heitz 2014, eq. 22",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE},
    .uses_lambda = 1,
    .planes = 1u << FF_G_PHI,
    .eval = smith_direction_correlated};

static const ff_param height_direction_params[] = {{"ginneken", "1", "how fast the correlation falls with the azimuth difference",
                                                    0.1, 100, 4.41, FF_PARAM_LOG | FF_PARAM_HELD, 0}};

const ff_masking FF_ISA_NAME(ff_masking_smith_height_direction_correlated) = {
    .term = {.name = "smith-height-direction-correlated",
             .title = "correlated by height and azimuth difference",
             .source = "van Ginneken et al. 1998; Heitz 2014, eq. 23",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE,
             .n_params = 1,
             .params = height_direction_params},
    .uses_lambda = 1,
    .planes = 1u << FF_G_PHI,
    .eval = smith_height_direction_correlated};

const ff_masking FF_ISA_NAME(ff_masking_v_cavity) = {
    .term = {.name = "v-cavity",
             .also = "v-groove",
             .title = "symmetric grooves",
             .source = "Torrance and Sparrow 1967; Cook and Torrance 1982; Heitz 2014, eq. 24",
             .note = "does not depend on the roughness; undefined with a mean slope",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_WEAK_FURNACE | FF_NEEDS_CENTRED},
    .uses_lambda = 0,
    .planes = 1u << FF_G_VCAVITY,
    .eval = v_cavity};

const ff_masking FF_ISA_NAME(ff_masking_kelemen) = {
    .term = {.name = "kelemen",
             .title = "iz oz / (wi.h)^2: a smooth substitute for the V-cavity",
             .source = "Kelemen and Szirmay-Kalos 2001, eq. 2-3",
             .note = "never above the G of the V-cavity and passive with it (the largest albedo found with F = 1 is 0.9996); "
                     "undefined with a mean slope",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_NEEDS_CENTRED},
    .uses_lambda = 0,
    .planes = 1u << FF_G_COS_I | 1u << FF_G_COS_O | 1u << FF_G_C,
    .eval = kelemen};

const ff_masking FF_ISA_NAME(ff_masking_hammon) = {
    .term = {.name = "hammon",
             .title = "the height-correlated form of isotropic ggx without square roots",
             .source = "Hammon 2017, PBR Diffuse Lighting for GGX+Smith Microsurfaces (GDC)",
             .note = "below the exact G2 by up to 0.233 (alpha -> 0, both cosines 1.6 alpha), 0.197 for alpha >= 0.1, 0.090 for "
                     "alpha >= 0.5; exact at alpha = 1, above it by up to 0.236 at alpha = 4",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC},
    .uses_lambda = 0,
    .uses_alpha = 1,
    .planes = 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .only = "ggx",
    .eval = hammon};

const ff_masking FF_ISA_NAME(ff_masking_schlick_smith) = {
    .term = {.name = "schlick-smith",
             .title = "the separable form of isotropic ggx without square roots",
             .source = "Karis 2013; Hammon 2017: its k = alpha / 2 is the approximation of `hammon`",
             .note = "below the exact separable G2 by up to 0.263 (alpha -> 0, both cosines 1.5 alpha), 0.223 for alpha >= 0.1, "
                     "0.103 for alpha >= 0.5; exact at alpha = 1, above it by up to 0.275 at alpha = 4",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_ISOTROPIC},
    .uses_lambda = 0,
    .uses_alpha = 1,
    .planes = 1u << FF_G_COS_I | 1u << FF_G_COS_O,
    .only = "ggx",
    .eval = schlick_smith};

const ff_masking FF_ISA_NAME(ff_masking_none) = {.term = {.name = "none",
                                                          .title = "no masking, no shadowing",
                                                          .source = "",
                                                          .note = "reflects more than it receives at grazing angles",
                                                          .claims = FF_RECIPROCAL},
                                                 .uses_lambda = 0,
                                                 .eval = none};
