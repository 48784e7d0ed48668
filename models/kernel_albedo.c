/* Curves of directional albedo: the sums that coupling.c makes them of, and their values at given cosines. Compiled once per
 * instruction set. */
#include "internal_compose.h"
#include "internal_vector_math.h"
#include <string.h>

/* ---- sums ------------------------------------------------------------------------------------ */

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
                       uint32_t at, ff_block *b)
{
    const uint32_t columns = p->wanted.n_shape + p->wanted.n_channel;
    double f[FF_BLOCK], df[FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS][FF_BLOCK], *out = p->albedo[c].coefficient + at;
    ff_compose_value(p, g, n, c, b, f);
    out[0] += factor * product(n, weight, f);
    if (columns) ff_compose_columns(p, n, c, weight, b, df);
    for (uint32_t k = 0; k < columns; k++) out[(1 + k) * FF_ALBEDO_COEFFICIENTS] += factor * total(n, df[k]);
}

/* Lobe l with F = 1. The columns are times its weight, which the curve is not; a lobe without weight has no use for them. */
static void add_loss(const ff_prepared *p, size_t n, uint32_t l, const double *weight, double factor, uint32_t at,
                     const ff_block *b)
{
    double d[FF_D_COUNT] = {0}, *out = p->loss[l].coefficient + at;
    out[0] += factor * product(n, weight, b->S[l]);
    if (p->weight[l] == 0) return;
    for (int k = 0; k < FF_D_COUNT; k++)
        if (p->needs[l] & 1u << k) d[k] = factor / p->weight[l] * product(n, weight, b->dS[l][k]);
    for (uint32_t k = 0; k < p->wanted.n_shape; k++)
        for (int j = 0; j < FF_D_COUNT && p->shape[k].lobe == (int)l; j++)
            if (p->shape[k].d[j] != 0) out[(1 + k) * FF_ALBEDO_COEFFICIENTS] += p->shape[k].d[j] * d[j];
}

void ff_albedo_add(const ff_prepared *p, double mu, const ff_albedo_points *points, uint32_t at)
{
    const uint32_t needs = ff_prepared_planes(p);
    const size_t n = points->n, losses = p->couples & FF_COUPLE_LOSS ? p->m->n_lobes : 0,
                 albedos = p->couples & FF_COUPLE_ALBEDO ? p->n_channels : 0;
    double w[6][FF_BLOCK], weight[FF_BLOCK], planes[FF_G_COUNT][FF_BLOCK];
    ff_geometry g = {{NULL}};
    ff_block b;
    mirror(points, mu, w, weight);
    for (int k = 0; k < FF_G_COUNT; k++)
        if (needs & 1u << k) g.plane[k] = planes[k];
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    p->kernels->geometry(&dirs, n, &g);
    ff_compose_shape(p, &g, n, &b);
    for (size_t c = 0; c < albedos; c++) add_albedo(p, &g, n, c, weight, p->albedo[c].over_cosine ? mu : 1, at, &b);
    for (uint32_t l = 0; l < losses; l++) add_loss(p, n, l, weight, p->loss[l].over_cosine ? mu : 1, at, &b);
}

/* ---- values ---------------------------------------------------------------------------------- */

/* A polynomial of an even count of coefficients; even and odd powers apart halve the chain of dependent sums. */
static inline double horner(int count, const double *restrict c, double t)
{
    const double t2 = t * t;
    double even = c[count - 2], odd = c[count - 1];
#pragma GCC unroll 16
    for (int k = count - 4; k >= 0; k -= 2) {
        even = even * t2 + c[k];
        odd = odd * t2 + c[k + 1];
    }
    return even + t * odd;
}

/* x in [from, to] -> [-1, 1] */
static inline double within(double x, double from, double to)
{
    return (2 * x - (from + to)) * (1 / (to - from));
}

/* The variable t in [-1, 1] of a piece in which 1 - t goes as the root of the distance from its end. */
static inline double root_within(double x, double from, double to)
{
    const double distance = (to - x) * (1 / (to - from));
    const double d = 0.5 * (distance + fabs(distance)) + 1e-30; /* a choice would be made after the root, of negative numbers too */
    return 1 - 2 * d * ff_rsqrt(d);
}

void ff_albedo_place_of(size_t n, const double *restrict mu, ff_albedo_place *place)
{
    const double lowest = FF_ALBEDO_X_0 * FF_ALBEDO_X_0 * FF_ALBEDO_X_0;
    for (size_t i = 0; i < n; i++) {
        const double m = mu[i] > lowest ? mu[i] : lowest, inv = ff_rcbrt(m), x = m * inv * inv;
        place->x[i] = x;
        place->middle[i] = root_within(x, FF_ALBEDO_X_1, FF_ALBEDO_X_2);
        place->last[i] = root_within(x, FF_ALBEDO_X_2, 1);
    }
}

void ff_albedo_values(const ff_albedo_curve *curve, uint32_t function, size_t n, const ff_albedo_place *place, double *restrict out)
{
    double c[FF_ALBEDO_COEFFICIENTS]; /* a local copy: the compiler then knows that the stores below leave it alone */
    const double *restrict c1 = c + FF_ALBEDO_PIECE_0, *restrict c2 = c1 + FF_ALBEDO_PIECE_1;
    memcpy(c, curve->coefficient + function * FF_ALBEDO_COEFFICIENTS, sizeof c);
    for (size_t i = 0; i < n; i++) {
        const double x = place->x[i];
        const double v0 = horner(FF_ALBEDO_PIECE_0, c, within(x, FF_ALBEDO_X_0, FF_ALBEDO_X_1));
        const double v1 = horner(FF_ALBEDO_PIECE_1, c1, place->middle[i]);
        const double v2 = horner(FF_ALBEDO_PIECE_2, c2, place->last[i]);
        out[i] = x < FF_ALBEDO_X_1 ? v0 : x < FF_ALBEDO_X_2 ? v1 : v2;
    }
    if (!curve->over_cosine) return;
    for (size_t i = 0; i < n; i++) {
        const double x = place->x[i];
        out[i] *= ff_recip(x * x * x);
    }
}

void ff_albedo_at(const ff_albedo_curve *curve, uint32_t function, size_t n, const double *restrict mu, double *restrict out)
{
    ff_albedo_place place;
    ff_albedo_place_of(n, mu, &place);
    ff_albedo_values(curve, function, n, &place, out);
}
