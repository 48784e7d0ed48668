/* Masking and shadowing, G2 of Heitz 2014 (RR-8468), eq. 19-24. Each kernel gives G and the derivatives of ln G by both Lambdas.
 * The factors chi+ hold by construction: a half vector of two directions above the horizon is on their side.
 * Where max or min make a kink, the derivative is that of the branch taken. */
#include "internal_terms.h"
#include "internal_vector_math.h"

#define FF_ARGS                                                                                                                    \
    const ff_geometry *g, size_t n, const double *restrict li, const double *restrict lo, double *restrict G, double *restrict gi, \
        double *restrict go

static void smith_masking_only(FF_ARGS)
{
    (void)g, (void)li;
    for (size_t i = 0; i < n; i++) {
        G[i] = ff_recip(1 + lo[i]);
        gi[i] = 0;
        go[i] = -G[i];
    }
}

static void smith_separable(FF_ARGS)
{
    (void)g;
    for (size_t i = 0; i < n; i++) {
        const double g1i = ff_recip(1 + li[i]), g1o = ff_recip(1 + lo[i]);
        G[i] = g1i * g1o;
        gi[i] = -g1i;
        go[i] = -g1o;
    }
}

static void smith_height_correlated(FF_ARGS)
{
    (void)g;
    for (size_t i = 0; i < n; i++) {
        G[i] = ff_recip(1 + li[i] + lo[i]);
        gi[i] = go[i] = -G[i];
    }
}

static void smith_direction_correlated(FF_ARGS)
{
    const double *restrict k = g->plane[FF_G_KPHI];
    for (size_t i = 0; i < n; i++) {
        const double g1i = ff_recip(1 + li[i]), g1o = ff_recip(1 + lo[i]);
        const double lesser = g1i < g1o ? g1i : g1o, greater = g1i < g1o ? g1o : g1i;
        const double blend = k[i] * greater + (1 - k[i]); /* G = lesser * blend; k = 0 only at equal azimuths, where blend = 1 */
        const double d_greater = -k[i] * greater * greater * ff_recip(blend);
        G[i] = lesser * blend;
        gi[i] = g1i < g1o ? -g1i : d_greater;
        go[i] = g1i < g1o ? d_greater : -g1o;
    }
}

static void smith_height_direction_correlated(FF_ARGS)
{
    const double *restrict k = g->plane[FF_G_KPHI];
    for (size_t i = 0; i < n; i++) {
        const double wi = li[i] < lo[i] ? k[i] : 1, wo = li[i] < lo[i] ? 1 : k[i];
        G[i] = ff_recip(1 + wi * li[i] + wo * lo[i]);
        gi[i] = -wi * G[i];
        go[i] = -wo * G[i];
    }
}

static void v_cavity(FF_ARGS)
{
    (void)li, (void)lo, (void)gi, (void)go;
    for (size_t i = 0; i < n; i++) G[i] = g->plane[FF_G_VCAVITY][i];
}

static void none(FF_ARGS)
{
    (void)g, (void)li, (void)lo, (void)gi, (void)go;
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
             .title = "G1(wi) G1(wo): masking and shadowing independent",
             .source = "Smith 1967; Walter et al. 2007, eq. 23; Heitz 2014, eq. 20",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE},
    .uses_lambda = 1,
    .eval = smith_separable};

const ff_masking FF_ISA_NAME(ff_masking_smith_height_correlated) = {
    .term = {.name = "smith-height-correlated",
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
    .planes = 1u << FF_G_KPHI,
    .eval = smith_direction_correlated};

const ff_masking FF_ISA_NAME(ff_masking_smith_height_direction_correlated) = {
    .term = {.name = "smith-height-direction-correlated",
             .title = "correlated by height and azimuth difference",
             .source = "van Ginneken et al. 1998; Heitz 2014, eq. 23",
             .note = "",
             .claims = FF_RECIPROCAL | FF_PASSIVE},
    .uses_lambda = 1,
    .planes = 1u << FF_G_KPHI,
    .eval = smith_height_direction_correlated};

const ff_masking FF_ISA_NAME(ff_masking_v_cavity) = {
    .term = {.name = "v-cavity",
             .title = "symmetric grooves",
             .source = "Torrance and Sparrow 1967; Cook and Torrance 1982; Heitz 2014, eq. 24",
             .note = "does not depend on the roughness; undefined with a mean slope",
             .claims = FF_RECIPROCAL | FF_PASSIVE | FF_WEAK_FURNACE | FF_NEEDS_CENTRED},
    .uses_lambda = 0,
    .planes = 1u << FF_G_VCAVITY,
    .eval = v_cavity};

const ff_masking FF_ISA_NAME(ff_masking_none) = {.term = {.name = "none",
                                                          .title = "no masking, no shadowing",
                                                          .source = "",
                                                          .note = "reflects more than it receives at grazing angles",
                                                          .claims = FF_RECIPROCAL},
                                                 .uses_lambda = 0,
                                                 .eval = none};
