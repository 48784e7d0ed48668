/* What every pass does with a block of samples: residuals, their robust forms, statistics. For files that are compiled once per
 * instruction set. */
#ifndef FF_INTERNAL_BLOCK_H
#define FF_INTERNAL_BLOCK_H
#include "internal_pass.h"
#include "fit/losses/internal_loss_block.h"
#include "fit/losses/robust/internal_robust_block.h"
#include "base/internal_vector_math.h"

typedef double v8 __attribute__((vector_size(64), aligned(64)));

/* ---- residuals ------------------------------------------------------------------------------- */

/* lanes[i mod 8] += v[i] */
static void add_to_lanes(const double *restrict v, double *restrict lanes)
{
    v8 sum = *(const v8 *)lanes;
    for (int i = 0; i < FF_BLOCK; i += 8) sum += *(const v8 *)(v + i);
    *(v8 *)lanes = sum;
}

/* r and j are scaled by sqrt(rho'); rho is summed into cost2 [8]. unit: the standard deviation of each residual, in which b counts,
 * or NULL; root: of the weight of each sample, or NULL. */
static void robustify(ff_robust robust, double b, const float *restrict unit, const float *restrict root, double *restrict r,
                      double *restrict j, double *restrict cost2)
{
    void (*block)(double, const double *, double *, double *) = FF_ISA_NAME(ff_robusts)[robust]->block;
    double u[FF_BLOCK], rho[FF_BLOCK] __attribute__((aligned(64))), slope[FF_BLOCK];
    if (!block) return;
    for (int i = 0; i < FF_BLOCK; i++) u[i] = unit ? r[i] / (double)unit[i] : r[i];
    block(b, u, rho, slope);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double one = unit ? (double)unit[i] : 1, w = root ? (double)root[i] : 1, by = w * sqrt(slope[i]);
        rho[i] *= w * w * one * one;
        r[i] *= by;
        j[i] *= by;
    }
    add_to_lanes(rho, cost2);
}

/* Samples that count more or less than once. */
static void multiply(const float *restrict root, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        r[i] *= (double)root[i];
        j[i] *= (double)root[i];
    }
}

/* A datum that is known from one side only says nothing to a model on that side of it. */
static void one_sided(const double *restrict side, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double keep = side[i] * r[i] > 0 ? 0 : 1;
        r[i] *= keep;
        j[i] *= keep;
    }
}

/* r and j = dr/df of channel c from its model values f. x: cosines; NULL unless the loss reads them. cost2 [8]: lanes of a robust
 * loss. */
static inline void weighted_residuals(const ff_pass *pass, size_t block, size_t c, const double *restrict x,
                                      const double *restrict f, double *restrict r, double *restrict j, double *restrict cost2)
{
    const struct ff_problem *p = pass->p;
    const ff_loss_planes l = {ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c),
                              ff_problem_plane(p, block, p->target + (int)c), x};
    ff_loss_residuals(p->loss, p->linearised, &l, f, r, j);
    const size_t at = block * FF_BLOCK, of_channel = c * p->n_blocks * FF_BLOCK;
    const float *root = p->multiplier ? p->multiplier + at : NULL, *unit = p->unit ? p->unit + of_channel + at : NULL;
    if (p->side >= 0) one_sided(ff_problem_plane(p, block, p->side + (int)c), r, j);
    if (pass->robust != FF_ROBUST_NONE)
        robustify(pass->robust, pass->robust_scale, unit, root, r, j, cost2);
    else if (root)
        multiply(root, r, j);
}

/* ---- statistics ------------------------------------------------------------------------------ */

/* lanes[i mod 8] += w e^2 */
static void add_squares(const double *restrict w, const double *restrict e, double *restrict lanes)
{
    v8 sum = *(const v8 *)lanes;
    for (int i = 0; i < FF_BLOCK; i += 8) {
        const v8 d = *(const v8 *)(e + i);
        sum += *(const v8 *)(w + i) * d * d;
    }
    *(v8 *)lanes = sum;
}

/* The larger of both halves of v [n] into the first. */
static inline void fold_largest(int n, double *v)
{
    for (int i = 0; i < n / 2; i++) v[i] = v[i + n / 2] > v[i] ? v[i + n / 2] : v[i];
}

/* Residuals of the fit's quality, whichever loss is minimised. */
static void statistics(const double *restrict f, const double *restrict y, const double *restrict x, const double *restrict sw,
                       double *restrict stat)
{
    double w[FF_BLOCK] __attribute__((aligned(64))), e[FF_BLOCK] __attribute__((aligned(64))), size[FF_BLOCK],
        *largest = stat + FF_STAT_MAX * 8;
    for (int i = 0; i < FF_BLOCK; i++) {
        w[i] = sw[i] * sw[i];
        e[i] = f[i] - y[i];
        size[i] = w[i] > 0 ? fabs(e[i]) : 0;
    }
    add_to_lanes(w, stat + FF_STAT_WEIGHT * 8);
    add_squares(w, e, stat + FF_STAT_PLAIN * 8);
#pragma GCC unroll 4
    for (int n = FF_BLOCK; n > 8; n /= 2) fold_largest(n, size);
    for (int lane = 0; lane < 8; lane++) largest[lane] = size[lane] > largest[lane] ? size[lane] : largest[lane];
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
        const ff_loss_descriptor *d = FF_ISA_NAME(ff_losses)[loss];
        if (!d->deviations) continue;
        d->deviations(f, y, x, e);
        add_squares(w, e, stat + (FF_STAT_LOSS + loss) * 8);
    }
}

/* cos(theta_i) of the block, from the tangents. */
static void cosines(const ff_geometry *g, double *restrict x)
{
    const double *restrict t2 = g->plane[FF_G_TI2], *restrict tx = g->plane[FF_G_TIX], *restrict ty = g->plane[FF_G_TIY];
    if (g->plane[FF_G_COS_I])
        memcpy(x, g->plane[FF_G_COS_I], FF_BLOCK * sizeof *x);
    else if (t2)
        for (int i = 0; i < FF_BLOCK; i++) x[i] = ff_rsqrt(1 + t2[i]);
    else
        for (int i = 0; i < FF_BLOCK; i++) x[i] = ff_rsqrt(1 + tx[i] * tx[i] + ty[i] * ty[i]);
}

#endif
