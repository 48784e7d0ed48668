/* An information kept as an arrowhead, linear in the number of channels:
 *
 *     H = [ A    B_1  B_2 .. ]      A [S][S] of the shape, D_c [K][K] of channel c, B_c [S][K] between the two,
 *         [ B_1'  D_1        ]
 *         [ B_2'       D_2   ]      T = A - sum over c of B_c D_c^-1 B_c'  (Schur complement),  K_c = D_c^-1 B_c'  [K][S],
 *
 * and so the influence H^-1 s of a sample with the score s (a block s_0 of the shape, one s_c of each channel) is
 *
 *     v_0 = T^-1 (s_0 - sum over c of K_c' s_c),     v_c = D_c^-1 s_c - K_c v_0.
 *
 * The sandwich H^-1 M H^-1 is the sum of v v' over the samples. Its blocks (0,0), (c,0) and (c,c) are all that is kept: those
 * between channels would be C^2 of them. They are summed as influences, not put together from sums of scores, which loses no digits
 * where shape and channels are nearly the same. It takes a pass of its own, since the v need H. */
#include "internal_storage.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t doubles(size_t S, size_t K, size_t C)
{
    return 2 * (S * S + C * K * S + C * K * K);
}

static void lay_out(ff_information *info, double *memory)
{
    const size_t S = info->S, K = info->K, C = info->C;
    ff_arrowhead *a = &info->arrowhead;
    *a = (ff_arrowhead){.S = S, .K = K, .C = C, .P = info->P, .scale = info->scale};
    a->inverse = memory;
    a->own = a->inverse + S * S;
    a->follow = a->own + C * K * K;
    info->covariance = a->follow + C * K * S;
}

/* Covariances: [S][S] of the shape, [C][K][S] of a channel with the shape, [C][K][K] within a channel. */
typedef struct blocks {
    double *shape, *cross, *block;
} blocks;

static blocks blocks_of(const ff_information *info)
{
    blocks b = {.shape = info->covariance};
    b.cross = b.shape + info->S * info->S;
    b.block = b.cross + info->C * info->K * info->S;
    return b;
}

/* ---- the inverse ----------------------------------------------------------------------------- */

/* Entry (i, j) of channel c's H, scaled. */
static double entry(const ff_information *info, const ff_gram *g, size_t c, size_t i, size_t j)
{
    return g->local[c * g->tri + ff_tri(i, j)] * info->scale[ff_gram_coordinate(g, c, i)] *
           info->scale[ff_gram_coordinate(g, c, j)];
}

/* D_c^-1 and K_c of a channel, of the parameters in use; what it leaves of the shape's block is taken from T. */
static void eliminate(ff_information *info, const ff_gram *g, size_t c, double *T, double *work)
{
    const size_t S = info->S, K = info->K;
    const int *use = info->use;
    double D[FF_MAX_CHANNEL_PARAMS * FF_MAX_CHANNEL_PARAMS], *own = info->arrowhead.own + c * K * K,
                                                             *follow = info->arrowhead.follow + c * K * S;
    size_t index[FF_MAX_CHANNEL_PARAMS], k = 0;
    for (size_t i = 0; i < K; i++) {
        if (use[S + c * K + i]) index[k++] = i;
        for (size_t j = 0; j < K; j++) D[i * K + j] = entry(info, g, c, S + i, S + j) + (i == j ? FF_RIDGE : 0);
    }
    ff_ridge_inverse(D, K, index, k, FF_RIDGE, own, work);
    for (size_t i = 0; i < K; i++)
        for (size_t j = 0; j < S; j++)
            for (size_t q = 0; q < K; q++) follow[i * S + j] += use[j] ? own[i * K + q] * entry(info, g, c, S + q, j) : 0;
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) {
            T[i * S + j] += entry(info, g, c, i, j);
            for (size_t q = 0; q < K; q++) T[i * S + j] -= entry(info, g, c, S + q, i) * follow[q * S + j];
        }
}

/* The blocks of H^-1 into those of the covariance. */
static void take_inverse(ff_information *info)
{
    const size_t S = info->S, K = info->K;
    const ff_arrowhead *a = &info->arrowhead;
    const blocks b = blocks_of(info);
    memcpy(b.shape, a->inverse, S * S * sizeof *b.shape);
    memcpy(b.block, a->own, info->C * K * K * sizeof *b.block);
    for (size_t c = 0; c < info->C; c++) {
        const double *follow = a->follow + c * K * S;
        double *cross = b.cross + c * K * S, *block = b.block + c * K * K;
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < S; j++) {
                cross[i * S + j] = 0;
                for (size_t q = 0; q < S; q++) cross[i * S + j] -= follow[i * S + q] * a->inverse[q * S + j];
            }
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < K; j++)
                for (size_t q = 0; q < S; q++) block[i * K + j] -= cross[i * S + q] * follow[j * S + q];
    }
}

void ff_information_followers(const ff_information *info, double *out)
{
    const size_t S = info->S, K = info->K;
    for (size_t row = 0; row < info->C * K; row++)
        for (size_t j = 0; j < S; j++)
            out[row * S + j] = info->use[j] && info->use[S + row]
                                   ? -info->arrowhead.follow[row * S + j] * info->scale[S + row] / info->scale[j]
                                   : 0;
}

static ff_status invert(ff_information *info, const ff_gram *g)
{
    const size_t S = info->S, most = S > info->K ? S : info->K;
    double *T = calloc(S * S + 4 * most * most + most + 1, sizeof *T);
    size_t index[FF_MAX_SHARED], k = 0;
    if (!T) return FF_ERR_MEMORY;
    double *work = T + S * S;
    for (size_t i = 0; i < S; i++) {
        T[i * S + i] = FF_RIDGE;
        if (info->use[i]) index[k++] = i;
    }
    for (size_t c = 0; c < info->C; c++) eliminate(info, g, c, T, work);
    ff_ridge_inverse(T, S, index, k, FF_RIDGE, info->arrowhead.inverse, work);
    free(T);
    take_inverse(info); /* for inverse_at */
    return FF_OK;
}

static double covariance(const ff_information *info, size_t i, size_t j)
{
    const size_t S = info->S, K = info->K;
    const blocks b = blocks_of(info);
    if (i < S && j < S) return b.shape[i * S + j];
    if (i < S) return covariance(info, j, i);
    const size_t c = (i - S) / K, row = i - S; /* of all channels' own */
    if (j < S) return b.cross[row * S + j];
    return (j - S) / K == c ? b.block[row * K + (j - S) % K] : NAN;
}

static double inverse_at(const ff_information *info, size_t i, size_t j)
{
    const size_t S = info->S, K = info->K;
    const ff_arrowhead *a = &info->arrowhead;
    if (i < S && j < S) return a->inverse[i * S + j];
    if (i < S) return inverse_at(info, j, i);
    const size_t c = (i - S) / K, row = i - S;
    double v = 0;
    if (j < S) {
        for (size_t q = 0; q < S; q++) v -= a->follow[row * S + q] * a->inverse[q * S + j];
        return v;
    }
    if ((j - S) / K != c) return NAN;
    for (size_t q = 0; q < S; q++)
        for (size_t r = 0; r < S; r++) v += a->follow[row * S + q] * a->inverse[q * S + r] * a->follow[(j - S) * S + r];
    return v + a->own[row * K + (j - S) % K];
}

/* ---- products of influences ------------------------------------------------------------------ */

static void apply(const ff_information *info, const double *score, double *influence)
{
    ff_arrowhead_apply(&info->arrowhead, score, influence);
}

static size_t products(const ff_information *info)
{
    return info->S * (info->S + 1) / 2 + info->C * ff_influence_channel(&info->arrowhead);
}

/* Adds factor times the products of an influence [P] to sums [products]. */
static void add_products(const ff_information *info, const double *influence, double factor, double *sums)
{
    const ff_arrowhead *a = &info->arrowhead;
    const size_t S = a->S, K = a->K;
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j <= i; j++) sums[ff_tri(i, j)] += factor * influence[i] * influence[j];
    sums += S * (S + 1) / 2;
    for (size_t c = 0; c < a->C; c++, sums += ff_influence_channel(a)) {
        const double *own = influence + S + c * K;
        for (size_t i = 0; i < K; i++) {
            for (size_t j = 0; j < S; j++) sums[i * S + j] += factor * own[i] * influence[j];
            for (size_t j = 0; j <= i; j++) sums[K * S + ff_tri(i, j)] += factor * own[i] * own[j];
        }
    }
}

static double product_at(const ff_information *info, const double *sums, size_t k)
{
    const size_t S = info->S, K = info->K;
    if (k < S) return sums[ff_tri(k, k)];
    const size_t c = (k - S) / K, i = (k - S) % K;
    return sums[S * (S + 1) / 2 + c * ff_influence_channel(&info->arrowhead) + K * S + ff_tri(i, i)];
}

/* Those that the pass over influences has summed, less what their mean adds. */
static ff_status of_single(const ff_information *info, const ff_normal *n, size_t n_samples, const double *mean,
                           const double *of_samples, double *sums)
{
    double *influence = malloc((2 * info->P + 1) * sizeof *influence);
    if (!influence) return FF_ERR_MEMORY;
    if (of_samples) memcpy(sums, of_samples, products(info) * sizeof *sums);
    ff_information_influence(info, n, mean, influence);
    add_products(info, influence, -(double)n_samples, sums);
    free(influence);
    return FF_OK;
}

static void take_products(ff_information *info, const double *sums)
{
    const size_t S = info->S, K = info->K;
    const blocks b = blocks_of(info);
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) b.shape[i * S + j] = sums[ff_tri(i, j)];
    sums += S * (S + 1) / 2;
    for (size_t c = 0; c < info->C; c++, sums += ff_influence_channel(&info->arrowhead)) {
        memcpy(b.cross + c * K * S, sums, K * S * sizeof *sums);
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < K; j++) b.block[(c * K + i) * K + j] = sums[K * S + ff_tri(i, j)];
    }
}

/* M has the blocks that H has. With G = sum over c of [I, -K_c'] M_c [I, -K_c']' and X_c = D_c^-1 (M_c0 - M_cc K_c) T^-1:
 *
 *     V_00 = T^-1 G T^-1,     V_c0 = X_c - K_c V_00,     V_cc = K_c V_00 K_c' - X_c K_c' - K_c X_c' + D_c^-1 M_cc D_c^-1. */
static ff_status sandwich(ff_information *info, const ff_gram *g)
{
    const size_t S = info->S, K = info->K;
    const ff_arrowhead *a = &info->arrowhead;
    const blocks b = blocks_of(info);
    double *G = calloc(3 * S * S + 2 * K * S + 3 * K * K + 1, sizeof *G);
    if (!G) return FF_ERR_MEMORY;
    double *T = G + S * S, *Y = T + S * S, *X = Y + K * S, *Z = X + K * S;
    for (size_t c = 0; c < info->C; c++) {
        const double *follow = a->follow + c * K * S;
        for (size_t i = 0; i < S; i++)
            for (size_t j = 0; j < S; j++) {
                double v = entry(info, g, c, i, j);
                for (size_t q = 0; q < K; q++) {
                    v -= entry(info, g, c, S + q, i) * follow[q * S + j] + follow[q * S + i] * entry(info, g, c, S + q, j);
                    for (size_t r = 0; r < K; r++) v += follow[q * S + i] * entry(info, g, c, S + q, S + r) * follow[r * S + j];
                }
                G[i * S + j] += v;
            }
    }
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++)
            for (size_t q = 0; q < S; q++) T[i * S + j] += a->inverse[i * S + q] * G[q * S + j];
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) {
            double v = 0;
            for (size_t q = 0; q < S; q++) v += T[i * S + q] * a->inverse[q * S + j];
            b.shape[i * S + j] = v;
        }
    for (size_t c = 0; c < info->C; c++) {
        const double *follow = a->follow + c * K * S, *own = a->own + c * K * K;
        double *cross = b.cross + c * K * S, *block = b.block + c * K * K;
        for (size_t i = 0; i < K; i++) { /* Y = M_c0 - M_cc K_c */
            for (size_t j = 0; j < S; j++) {
                Y[i * S + j] = info->use[j] ? entry(info, g, c, S + i, j) : 0;
                for (size_t q = 0; q < K; q++) Y[i * S + j] -= entry(info, g, c, S + i, S + q) * follow[q * S + j];
            }
            for (size_t j = 0; j < K; j++) { /* Z = D^-1 M_cc */
                Z[i * K + j] = 0;
                for (size_t q = 0; q < K; q++) Z[i * K + j] += own[i * K + q] * entry(info, g, c, S + q, S + j);
            }
        }
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < S; j++) {
                double v = 0;
                for (size_t q = 0; q < K; q++)
                    for (size_t r = 0; r < S; r++) v += own[i * K + q] * Y[q * S + r] * a->inverse[r * S + j];
                X[i * S + j] = v;
                cross[i * S + j] = v;
                for (size_t r = 0; r < S; r++) cross[i * S + j] -= follow[i * S + r] * b.shape[r * S + j];
            }
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < K; j++) {
                double v = 0;
                for (size_t q = 0; q < K; q++) v += Z[i * K + q] * own[q * K + j];
                for (size_t r = 0; r < S; r++) {
                    v -= X[i * S + r] * follow[j * S + r] + follow[i * S + r] * X[j * S + r];
                    for (size_t s = 0; s < S; s++) v += follow[i * S + r] * b.shape[r * S + s] * follow[j * S + s];
                }
                block[i * K + j] = v;
            }
    }
    free(G);
    return FF_OK;
}

static void multiply(ff_information *info, const double *factor)
{
    const size_t S = info->S, K = info->K;
    const blocks b = blocks_of(info);
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) b.shape[i * S + j] *= factor[i] * factor[j];
    for (size_t c = 0; c < info->C; c++) {
        const double *own = factor + S + c * K;
        for (size_t i = 0; i < K; i++) {
            for (size_t j = 0; j < S; j++) b.cross[(c * K + i) * S + j] *= own[i] * factor[j];
            for (size_t j = 0; j < K; j++) b.block[(c * K + i) * K + j] *= own[i] * own[j];
        }
    }
}

/* ---- condition ------------------------------------------------------------------------------- */

/* out = H x of the parameters in use. */
static void multiply_by_h(const ff_information *info, const ff_gram *g, const double *x, double *out)
{
    memset(out, 0, info->P * sizeof *out);
    for (size_t c = 0; c < info->C; c++)
        for (size_t i = 0; i < info->S + info->K; i++)
            for (size_t j = 0; j < info->S + info->K; j++) {
                const size_t to = ff_gram_coordinate(g, c, i), from = ff_gram_coordinate(g, c, j);
                if (info->use[to] && info->use[from]) out[to] += entry(info, g, c, i, j) * x[from];
            }
}

/* Largest eigenvalue of H, or without g of its inverse, by the power method from a vector without symmetry; work [2 P]. */
static double largest_eigenvalue(const ff_information *info, const ff_gram *g, double *work)
{
    enum { MOST = 3000 };
    const size_t P = info->P;
    double *x = work, *y = work + P, value = 0;
    for (size_t k = 0; k < P; k++) x[k] = info->use[k] ? 1 + 0.5 * sin(1 + 2.4 * (double)k) : 0;
    for (int step = 0; step < MOST; step++) {
        double norm = 0, before = value;
        for (size_t k = 0; k < P; k++) norm += x[k] * x[k];
        norm = sqrt(norm);
        if (!(norm > 0)) return 0;
        for (size_t k = 0; k < P; k++) x[k] /= norm;
        if (g)
            multiply_by_h(info, g, x, y);
        else
            apply(info, x, y);
        value = 0;
        for (size_t k = 0; k < P; k++) value += x[k] * y[k];
        memcpy(x, y, P * sizeof *x);
        if (fabs(value - before) <= 1e-12 * value) break;
    }
    return value;
}

/* The flattest direction joins channels, of which correlations are not formed: it is not looked for. */
static ff_status condition(const ff_information *info, const ff_gram *g, size_t *rank, double *out, double *curvature,
                           double *share)
{
    double *work = malloc((2 * info->P + 1) * sizeof *work);
    size_t lost = 0;
    if (!work) return FF_ERR_MEMORY;
    for (size_t k = 0; k < info->P; k++) lost += info->use[k] && !info->determined[k];
    const double most = largest_eigenvalue(info, g, work), least = largest_eigenvalue(info, NULL, work);
    *rank = info->used - lost;
    *out = info->used == 0 ? 1 : least < 1e12 ? sqrt(most * least) : INFINITY;
    if (share) {
        *curvature = 1;
        memset(share, 0, info->P * sizeof *share);
    }
    free(work);
    return FF_OK;
}

const ff_storage ff_storage_arrowhead = {doubles,      lay_out,      invert,     inverse_at, apply,
                                         products,     add_products, product_at, of_single,  take_products,
                                         take_inverse, sandwich,     multiply,   covariance, condition};
