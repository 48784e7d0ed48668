/* What every pass does with a block of samples: losses, their robust forms, statistics. For files that are compiled once per
 * instruction set. */
#ifndef FF_INTERNAL_BLOCK_H
#define FF_INTERNAL_BLOCK_H
#include "internal_pass.h"
#include "internal_loss.h"
#include "base/internal_vector_math.h"

typedef double v8 __attribute__((vector_size(64), aligned(64)));

/* ---- losses: r = w (g(f) - t), j = dr/df ----------------------------------------------------- */

/* Tabulated per block: everything a loss reads. */
typedef struct loss_planes {
    const double *restrict w, *restrict t, *restrict x; /* weight, target, cos(theta_i) */
} loss_planes;

static void loss_linear(const loss_planes *l, const double *restrict f, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        r[i] = l->w[i] * (f[i] - l->t[i]);
        j[i] = l->w[i];
    }
}

static void loss_log(const loss_planes *l, const double *restrict f, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = l->x[i] * f[i];
        r[i] = l->w[i] * (ff_log1p(u) - l->t[i]);
        j[i] = l->w[i] * l->x[i] * ff_recip(1 + u);
    }
}

/* c(t) = t (t^2 + e^2)^(-1/3), c'(t) = (t^2/3 + e^2) (t^2 + e^2)^(-4/3) */
static inline double cube_root(double t)
{
    return t * ff_rcbrt(t * t + FF_CUBE_ROOT_E2);
}

static inline double cube_root_slope(double t)
{
    const double inv = ff_rcbrt(t * t + FF_CUBE_ROOT_E2), inv2 = inv * inv;
    return (t * t * (1.0 / 3) + FF_CUBE_ROOT_E2) * inv2 * inv2;
}

static void loss_cube_root(const loss_planes *l, const double *restrict f, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = l->x[i] * f[i];
        r[i] = l->w[i] * (cube_root(u) - l->t[i]);
        j[i] = l->w[i] * l->x[i] * cube_root_slope(u);
    }
}

/* lanes[i mod 8] += v[i] */
static void add_to_lanes(const double *restrict v, double *restrict lanes)
{
    v8 sum = *(const v8 *)lanes;
    for (int i = 0; i < FF_BLOCK; i += 8) sum += *(const v8 *)(v + i);
    *(v8 *)lanes = sum;
}

/* Robust losses of the Ceres Solver: rho(s) and rho'(s) of s = r^2, b2 = scale^2. All have rho'' <= 0, where Triggs' second-order
 * term is dropped as there. */
static void huber(double b2, const double *restrict r, double *restrict rho, double *restrict slope)
{
    const double b = sqrt(b2);
    for (int i = 0; i < FF_BLOCK; i++) {
        const double s = r[i] * r[i], a = fabs(r[i]), inv = ff_recip(a > 1e-290 ? a : 1e-290);
        rho[i] = s > b2 ? 2 * b * a - b2 : s;
        slope[i] = s > b2 ? b * inv : 1;
    }
}

static void cauchy(double b2, const double *restrict r, double *restrict rho, double *restrict slope)
{
    const double inv_b2 = 1 / b2;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = r[i] * r[i] * inv_b2;
        rho[i] = b2 * ff_log1p(u);
        slope[i] = ff_recip(1 + u);
    }
}

static void tukey(double b2, const double *restrict r, double *restrict rho, double *restrict slope)
{
    const double inv_b2 = 1 / b2, third = b2 / 3;
    for (int i = 0; i < FF_BLOCK; i++) {
        const double v = 1 - r[i] * r[i] * inv_b2, in = v > 0 ? v : 0;
        rho[i] = third * (1 - in * in * in);
        slope[i] = in * in;
    }
}

/* r and j are scaled by sqrt(rho'); rho is summed into cost2 [8]. unit: the standard deviation of each residual, in which b counts,
 * or NULL; root: of the weight of each sample, or NULL. */
static void robustify(ff_robust robust, double b, const float *restrict unit, const float *restrict root, double *restrict r,
                      double *restrict j, double *restrict cost2)
{
    double u[FF_BLOCK], rho[FF_BLOCK] __attribute__((aligned(64))), slope[FF_BLOCK];
    for (int i = 0; i < FF_BLOCK; i++) u[i] = unit ? r[i] / (double)unit[i] : r[i];
    switch (robust) {
    case FF_ROBUST_HUBER:
        huber(b * b, u, rho, slope);
        break;
    case FF_ROBUST_CAUCHY:
        cauchy(b * b, u, rho, slope);
        break;
    case FF_ROBUST_TUKEY:
        tukey(b * b, u, rho, slope);
        break;
    default:
        return;
    }
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

/* r and j = dr/df of channel c from its model values f. x: cosines, of a loss that reads them. cost2 [8]: lanes of a robust loss.
 */
static inline void residuals(const ff_pass *pass, size_t block, size_t c, const double *restrict x, const double *restrict f,
                             double *restrict r, double *restrict j, double *restrict cost2)
{
    const struct ff_problem *p = pass->p;
    const loss_planes l = {ff_problem_plane(p, block, p->weight + p->weight_stride * (int)c),
                           ff_problem_plane(p, block, p->target + (int)c), x};
    if (p->surrogate || p->loss == FF_LOSS_COSINE || p->loss == FF_LOSS_RELATIVE || p->loss == FF_LOSS_PLAIN)
        loss_linear(&l, f, r, j);
    else if (p->loss == FF_LOSS_LOG)
        loss_log(&l, f, r, j);
    else
        loss_cube_root(&l, f, r, j);
    const size_t at = block * FF_BLOCK, of_channel = c * p->n_blocks * FF_BLOCK;
    const float *root = p->multiplier ? p->multiplier + at : NULL, *unit = p->unit ? p->unit + of_channel + at : NULL;
    if (p->side >= 0) one_sided(ff_problem_plane(p, block, p->side + (int)c), r, j);
    if (pass->robust != FF_ROBUST_NONE)
        robustify(pass->robust, pass->robust_scale, unit, root, r, j, cost2);
    else if (root)
        multiply(root, r, j);
}

/* ---- statistics ------------------------------------------------------------------------------ */

/* Residuals of the fit's quality, whichever loss is minimised. A datum below -1/cos, where the log loss has no value, counts as
 * there. */
static void statistics(const double *restrict f, const double *restrict y, const double *restrict x, const double *restrict sw,
                       double *restrict stat)
{
    double part[FF_STAT_COUNT][FF_BLOCK] __attribute__((aligned(64)));
    for (int i = 0; i < FF_BLOCK; i++) {
        const double w = sw[i] * sw[i], e = f[i] - y[i], low = -0.999999, ly = x[i] * y[i] > low ? x[i] * y[i] : low;
        const double el = ff_log((1 + x[i] * f[i]) * ff_recip(1 + ly)), ec = cube_root(x[i] * f[i]) - cube_root(x[i] * y[i]);
        part[FF_STAT_WEIGHT][i] = w;
        part[FF_STAT_PLAIN][i] = w * e * e;
        part[FF_STAT_COSINE][i] = w * e * e * x[i] * x[i];
        part[FF_STAT_LOG][i] = w * el * el;
        part[FF_STAT_CUBE_ROOT][i] = w * ec * ec;
        part[FF_STAT_MAX][i] = w > 0 ? fabs(e) : 0;
    }
    for (int k = 0; k < FF_STAT_MAX; k++) add_to_lanes(part[k], stat + k * 8);
    double *largest = stat + FF_STAT_MAX * 8;
    for (int i = 0; i < FF_BLOCK; i += 8)
        for (int lane = 0; lane < 8; lane++)
            largest[lane] = part[FF_STAT_MAX][i + lane] > largest[lane] ? part[FF_STAT_MAX][i + lane] : largest[lane];
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
