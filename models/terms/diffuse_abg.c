/* ABg: the scatter of polished surfaces as its users write it (Harvey 1976; Pfisterer 2011), in direction cosines,
 *
 *   f = A / (B + d^g),   d = |beta - beta_0| = |(wi + wo) . (x, y)| = 2 (wi.h) sin(theta_h)
 *
 * beta and beta_0 are the projections of the direction seen and of the mirror direction. B^(1/g) is the d at which the peak goes
 * over into a straight line of slope -g in a plot with logarithmic axes, A / B the top of the peak. It is no distribution of
 * normals: d depends on wi.h too, so it stands among the terms that are added to the lobes. */
#include "internal_terms.h"
#include "internal_optics.h"
#include "base/internal_vector_math.h"
#include <math.h>

#define LEAST 1e-280 /* of d^2, which is 0 in the mirror direction */

static void abg(const ff_diffuse_input *in, const ff_geometry *g, size_t n, double *restrict f, double *const *d)
{
    const double A = in->params[0], B = in->params[1], half_g = 0.5 * in->params[2];
    const double *restrict s2 = g->plane[FF_G_S2], *restrict c = g->plane[FF_G_C];
    double inv[FF_BLOCK], power[FF_BLOCK], log_d2[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const double d2 = 4 * c[i] * c[i] * s2[i] * ff_recip(1 + s2[i]);
        log_d2[i] = ff_log(d2 > LEAST ? d2 : LEAST);
    }
    for (size_t i = 0; i < n; i++) power[i] = ff_exp(half_g * log_d2[i]);
    for (size_t i = 0; i < n; i++) {
        inv[i] = ff_recip(B + power[i]);
        f[i] = A * inv[i];
    }
    double *restrict dA = ff_wanted_plane(d, 0), *restrict dB = ff_wanted_plane(d, 1), *restrict dg = ff_wanted_plane(d, 2);
    if (dA)
        for (size_t i = 0; i < n; i++) dA[i] = inv[i];
    if (dB)
        for (size_t i = 0; i < n; i++) dB[i] = -A * inv[i] * inv[i];
    if (dg)
        for (size_t i = 0; i < n; i++) dg[i] = -0.5 * A * inv[i] * inv[i] * power[i] * log_d2[i];
}

/* (1 + t^g) over (1 + t^2)^(g/2), t = d / B^(1/g), lies between 1 and 2^(1 - g/2). */
static void peak(const double *p, double *width, double *power)
{
    *width = pow(p[1], 1 / p[2]);
    *power = 0.5 * p[2];
}

static const ff_param params[] = {
    {"abg_a", "1/sr", "scatter at d = 1, A", 0, 1, 1e-3, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR, 0},
    {"abg_b", "1", "where the peak ends, B: the g-th power of d there", 1e-20, 1, 1e-3, FF_PARAM_LOG, 0},
    {"abg_g", "1", "slope of the wings, g", 0.1, 6, 2, FF_PARAM_LOG, 0},
};

const ff_diffuse FF_ISA_NAME(ff_diffuse_abg) = {
    .term = {.name = "abg",
             .title = "scatter of a polished surface, A / (B + |beta - beta_0|^g), as in ABg and Harvey-Shack models",
             .source = "Harvey 1976; Pfisterer 2011, Approximated scatter models for stray light analysis",
             .note = "in direction cosines; data over many decades are fitted by the loss ln; nothing bounds what it reflects",
             .claims = FF_RECIPROCAL | FF_ISOTROPIC,
             .n_params = 3,
             .params = params},
    .planes = 1u << FF_G_C | 1u << FF_G_S2,
    .eval = abg,
    .peak = peak};
