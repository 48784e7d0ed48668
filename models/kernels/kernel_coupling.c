/* The sums that curves of directional albedo are made of; see coupling.c. Compiled once per instruction set. */
#include "internal_compose.h"
#include "base/internal_vector_math.h"

/* wi = 2 (o.h) h - o and the weight of f: that of q dq dpsi times 4 iz (o.h) hz^3, since V hz^4 = (o.h) hz^3. */
static void mirror(const ff_albedo_points *t, double mu, double w[6][FF_BLOCK], double *restrict weight)
{
    const double side = sqrt((1 - mu) * (1 + mu));
    for (size_t i = 0; i < t->n; i++) {
        const double q = t->q[i], hz = ff_rsqrt(1 + q * q), hx = q * hz * t->cos_psi[i], hy = q * hz * t->sin_psi[i];
        const double twice = 2 * (side * hx + mu * hz), iz = twice * hz - mu;
        w[0][i] = twice * hx - side;
        w[1][i] = twice * hy;
        w[2][i] = iz;
        w[3][i] = side;
        w[4][i] = 0;
        w[5][i] = mu;
        weight[i] = t->weight[i] * 2 * twice * iz * hz * hz * hz;
    }
}

static double total(size_t n, const double *restrict v)
{
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < n; i++) sum += v[i];
    return sum;
}

static double product(size_t n, const double *restrict a, const double *restrict b)
{
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < n; i++) sum += a[i] * b[i];
    return sum;
}

static void add_albedo(const ff_prepared *p, const ff_geometry *g, size_t n, size_t c, const double *weight, double factor,
                       uint32_t at, ff_block_work *work)
{
    const uint32_t columns = p->wanted.n_shape + p->wanted.n_channel;
    double f[FF_BLOCK], *out = p->albedo[c].coefficient + at;
    ff_compose_value(p, g, n, c, &work->block, f);
    out[0] += factor * product(n, weight, f);
    if (columns) ff_compose_columns(p, n, c, weight, &work->block, work->column);
    for (uint32_t k = 0; k < columns; k++) out[(1 + k) * FF_ALBEDO_COEFFICIENTS] += factor * total(n, work->column[k]);
}

/* Lobe l with F = 1. The columns are times its weight, which the curve is not; a lobe without weight has no use for them. */
static void add_loss(const ff_prepared *p, size_t n, uint32_t l, const double *weight, double factor, uint32_t at,
                     const ff_block *b)
{
    double d[FF_D_COUNT] = {0}, *out = p->loss[l].coefficient + at;
    out[0] += factor * product(n, weight, b->S[l]);
    if (p->weight[l] == 0) return;
    for (int k = 0; k < FF_D_COUNT; k++)
        if (p->needs[l] & 1u << k) d[k] = factor / p->weight[l] * product(n, weight, b->d->dS[l][k]);
    for (uint32_t k = 0; k < p->wanted.n_shape; k++)
        for (int j = 0; j < FF_D_COUNT && p->shape[k].lobe == (int)l; j++)
            if (p->shape[k].d[j] != 0) out[(1 + k) * FF_ALBEDO_COEFFICIENTS] += p->shape[k].d[j] * d[j];
}

void ff_albedo_add(const ff_prepared *p, double mu, const ff_albedo_points *points, uint32_t at, ff_block_work *work)
{
    const uint32_t needs = p->planes;
    const size_t n = points->n, losses = p->couples & FF_COUPLE_LOSS ? p->m->n_lobes : 0,
                 albedos = p->couples & FF_COUPLE_ALBEDO ? p->n_channels : 0;
    double w[6][FF_BLOCK], weight[FF_BLOCK];
    ff_geometry g = {{NULL}};
    mirror(points, mu, w, weight);
    for (int k = 0; k < FF_G_COUNT; k++)
        if (needs & 1u << k) g.plane[k] = work->planes[k];
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    p->kernels->geometry(&dirs, n, &g);
    ff_compose_shape(p, &g, n, &work->block);
    for (size_t c = 0; c < albedos; c++) add_albedo(p, &g, n, c, weight, p->albedo[c].over_cosine ? mu : 1, at, work);
    for (uint32_t l = 0; l < losses; l++) add_loss(p, n, l, weight, p->loss[l].over_cosine ? mu : 1, at, &work->block);
}
