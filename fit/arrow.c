/* The uncertainty of a fit with many channels, at a cost that is linear in their number: see internal_arrow.h. */
#include "internal_arrow.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void ff_influence_chunk_scalar(const ff_pass *pass, const ff_arrow *arrow, size_t first_block, size_t n_blocks,
                               const ff_influence_sums *sums);
#ifdef FF_HAVE_AVX2
void ff_influence_chunk_avx2(const ff_pass *pass, const ff_arrow *arrow, size_t first_block, size_t n_blocks,
                             const ff_influence_sums *sums);
#endif
#ifdef FF_HAVE_AVX512
void ff_influence_chunk_avx512(const ff_pass *pass, const ff_arrow *arrow, size_t first_block, size_t n_blocks,
                               const ff_influence_sums *sums);
#endif

/* X [n][m] = A^-1 B from the factor of A = D L L^T D; a zero in L or D gives 0. */
static void solve_factored(const double *L, const double *D, size_t n, const double *B, size_t m, double *X)
{
    for (size_t j = 0; j < m; j++) {
        for (size_t i = 0; i < n; i++) {
            double v = D[i] > 0 ? B[i * m + j] / D[i] : 0;
            for (size_t k = 0; k < i; k++) v -= L[i * n + k] * X[k * m + j];
            X[i * m + j] = L[i * n + i] > 0 ? v / L[i * n + i] : 0;
        }
        for (size_t i = n; i-- > 0;) {
            double v = X[i * m + j];
            for (size_t k = i + 1; k < n; k++) v -= L[k * n + i] * X[k * m + j];
            X[i * m + j] = L[i * n + i] > 0 ? v / L[i * n + i] : 0;
        }
        for (size_t i = 0; i < n; i++) X[i * m + j] = D[i] > 0 ? X[i * m + j] / D[i] : 0;
    }
}

void ff_solve_symmetric(const double *A, size_t n, const double *B, size_t m, double *X)
{
    double L[FF_MAX_SHAPE * FF_MAX_SHAPE], D[FF_MAX_SHAPE];
    ff_scaled_cholesky(A, n, 1e-14, L, D);
    solve_factored(L, D, n, B, m, X);
}

/* ---- inverses of the blocks ------------------------------------------------------------------ */

static ff_arrow *arrow_new(const ff_layout *l)
{
    const size_t S = l->free.n_shape, K = l->free.n_channel, C = l->n_channels;
    ff_arrow *a = calloc(1, sizeof *a);
    if (!a) return NULL;
    a->S = S, a->K = K, a->C = C, a->P = l->P;
    const size_t sizes[] = {l->P, S * S, C * K * K, C * K * S, S * S, C * K * S, C * K * K};
    double **const parts[] = {&a->scale, &a->inverse, &a->own, &a->follow, &a->shape, &a->cross, &a->block};
    size_t total = 1;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) total += sizes[i];
    double *next = calloc(total, sizeof *next);
    a->scale = next;
    a->determined = calloc(l->P + 1, sizeof *a->determined);
    if (!next || !a->determined) {
        ff_arrow_free(a);
        return NULL;
    }
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; next += sizes[i++]) *parts[i] = next;
    return a;
}

void ff_arrow_free(ff_arrow *a)
{
    if (!a) return;
    free(a->scale);
    free(a->determined);
    free(a);
}

/* A ridge of this size keeps inverses finite; a parameter whose variance it sets is not determined. As in covariance.c. */
#define FF_RIDGE        1e-13
#define FF_UNDETERMINED 1e10

/* Inverse of the rows and columns index [k] of A [n][n]; 0 elsewhere. What rounding has left no pivot gets that of the ridge. */
static void invert(const double *A, size_t n, const size_t *index, size_t k, double *inverse)
{
    double sub[FF_MAX_SHAPE * FF_MAX_SHAPE] = {0}, unit[FF_MAX_SHAPE * FF_MAX_SHAPE] = {0}, X[FF_MAX_SHAPE * FF_MAX_SHAPE];
    double L[FF_MAX_SHAPE * FF_MAX_SHAPE], D[FF_MAX_SHAPE];
    for (size_t i = 0; i < k; i++) {
        unit[i * k + i] = 1;
        for (size_t j = 0; j < k; j++) sub[i * k + j] = A[index[i] * n + index[j]];
        sub[i * k + i] = fmax(sub[i * k + i], FF_RIDGE);
    }
    ff_scaled_cholesky(sub, k, 0, L, D);
    for (size_t i = 0; i < k; i++)
        if (!(L[i * k + i] > 0)) L[i * k + i] = sqrt(FF_RIDGE);
    solve_factored(L, D, k, unit, k, X);
    memset(inverse, 0, n * n * sizeof *inverse);
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) inverse[index[i] * n + index[j]] = 0.5 * (X[i * k + j] + X[j * k + i]);
}

/* Entry (i, j) of channel c's H, columns counted as in its gram, scaled. */
static double entry(const ff_arrow *a, const ff_normal *n, size_t c, size_t i, size_t j)
{
    const size_t tri = n->m1 * (n->m1 + 1) / 2, S = a->S;
    const double by_i = a->scale[i < S ? i : i + c * a->K], by_j = a->scale[j < S ? j : j + c * a->K];
    return n->gram[c * tri + ff_tri(i, j)] * by_i * by_j;
}

static void fill_scale(ff_arrow *a, const ff_normal *n)
{
    const size_t tri = n->m1 * (n->m1 + 1) / 2;
    for (size_t c = 0; c < a->C; c++) {
        for (size_t k = 0; k < a->S; k++) a->scale[k] += n->gram[c * tri + ff_tri(k, k)];
        for (size_t k = 0; k < a->K; k++) a->scale[a->S + c * a->K + k] = n->gram[c * tri + ff_tri(a->S + k, a->S + k)];
    }
    for (size_t k = 0; k < a->P; k++) a->scale[k] = a->scale[k] > 0 ? 1 / sqrt(a->scale[k]) : 1e150; /* no effect at all */
}

/* D_c^-1, K_c, T^-1, of the parameters that are in use. */
static void invert_blocks(ff_arrow *a, const ff_normal *n, const int *use)
{
    const size_t S = a->S, K = a->K;
    double T[FF_MAX_SHAPE * FF_MAX_SHAPE] = {0}, D[FF_MAX_CHANNEL_PARAMS * FF_MAX_CHANNEL_PARAMS];
    size_t index[FF_MAX_SHAPE], k;
    for (size_t i = 0; i < S; i++) T[i * S + i] = FF_RIDGE;
    for (size_t c = 0; c < a->C; c++) {
        double *own = a->own + c * K * K, *follow = a->follow + c * K * S;
        k = 0;
        for (size_t i = 0; i < K; i++) {
            if (use[S + c * K + i]) index[k++] = i;
            for (size_t j = 0; j < K; j++) D[i * K + j] = entry(a, n, c, S + i, S + j) + (i == j ? FF_RIDGE : 0);
        }
        invert(D, K, index, k, own);
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < S; j++)
                for (size_t q = 0; q < K; q++) follow[i * S + j] += use[j] ? own[i * K + q] * entry(a, n, c, S + q, j) : 0;
        for (size_t i = 0; i < S; i++)
            for (size_t j = 0; j < S; j++) {
                T[i * S + j] += entry(a, n, c, i, j);
                for (size_t q = 0; q < K; q++) T[i * S + j] -= entry(a, n, c, S + q, i) * follow[q * S + j];
            }
    }
    k = 0;
    for (size_t i = 0; i < S; i++)
        if (use[i]) index[k++] = i;
    invert(T, S, index, k, a->inverse);
}

/* The blocks of H^-1, scaled, into the covariances. */
static void fill_inverse(ff_arrow *a)
{
    const size_t S = a->S, K = a->K;
    memcpy(a->shape, a->inverse, S * S * sizeof *a->shape);
    for (size_t c = 0; c < a->C; c++) {
        const double *follow = a->follow + c * K * S;
        double *cross = a->cross + c * K * S, *block = a->block + c * K * K;
        memcpy(block, a->own + c * K * K, K * K * sizeof *block);
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

/* Which parameters the data determine, from the variances that H^-1 gives. */
static void fill_determined(ff_arrow *a, const int *use, int enough)
{
    for (size_t k = 0; k < a->P; k++) {
        const size_t c = k < a->S ? 0 : (k - a->S) / a->K, i = k < a->S ? k : (k - a->S) % a->K;
        const double variance = k < a->S ? a->shape[i * a->S + i] : a->block[(c * a->K + i) * a->K + i];
        a->determined[k] = use[k] && variance < FF_UNDETERMINED && enough;
    }
}

/* ---- the pass over influences ---------------------------------------------------------------- */

typedef struct run {
    const ff_pass *pass;
    const ff_arrow *arrow;
    ff_influence_chunk_fn kernel;
    size_t n_sums, n_score;
    double *lanes;  /* [threads][n_sums * 8 + n_score] */
    double *result; /* [chunks][n_sums]                */
} run;

static void run_chunk(void *context, size_t chunk, int worker)
{
    const run *r = context;
    const struct ff_problem *p = r->pass->p;
    double *lanes = r->lanes + (size_t)worker * (r->n_sums * 8 + r->n_score);
    ff_influence_sums sums = {.stat = lanes, .shape = lanes + FF_STAT_COUNT * 8};
    sums.channel = sums.shape + (r->arrow ? r->arrow->S * (r->arrow->S + 1) / 2 * 8 : 0);
    sums.score = lanes + r->n_sums * 8;
    memset(lanes, 0, r->n_sums * 8 * sizeof *lanes);
    const size_t share = ff_problem_share(p), first = chunk * share, left = p->n_blocks - first;
    r->kernel(r->pass, r->arrow, first, left < share ? left : share, &sums);
    double *out = r->result + chunk * r->n_sums;
    for (size_t k = 0; k < r->n_sums; k++) {
        double sum = lanes[k * 8];
        for (size_t i = 1; i < 8; i++) {
            const double v = lanes[k * 8 + i];
            sum = k == FF_STAT_MAX ? fmax(sum, v) : sum + v;
        }
        out[k] = sum;
    }
}

/* The sums of all chunks, merged in their order, into out [n_sums]. */
static ff_status influence_pass(const ff_pass *pass, const ff_arrow *arrow, size_t n_sums, double *out)
{
    const struct ff_problem *p = pass->p;
    const size_t share = ff_problem_share(p), chunks = (p->n_blocks + share - 1) / share,
                 threads = (size_t)ff_pool_threads(p->pool);
    run r = {.pass = pass, .arrow = arrow, .n_sums = n_sums, .n_score = arrow ? arrow->P * FF_BLOCK : 0};
    r.kernel = ff_isa_available(p->isa) ? FF_ISA_PICK(p->isa, ff_influence_chunk) : NULL;
    r.lanes = aligned_alloc(64, (threads * (n_sums * 8 + r.n_score) * sizeof(double) + 63) / 64 * 64);
    r.result = malloc(chunks * n_sums * sizeof(double));
    const ff_status st = !r.kernel ? FF_ERR_UNSUPPORTED : r.lanes && r.result ? FF_OK : FF_ERR_MEMORY;
    if (!st) ff_pool_run(p->pool, chunks, run_chunk, &r);
    memset(out, 0, n_sums * sizeof *out);
    for (size_t c = 0; c < chunks && !st; c++)
        for (size_t k = 0; k < n_sums; k++) {
            const double v = r.result[c * n_sums + k];
            out[k] = k == FF_STAT_MAX ? fmax(out[k], v) : out[k] + v;
        }
    free(r.lanes);
    free(r.result);
    return st;
}

/* The products of influences into the covariances, scaled. */
static void fill_sandwich(ff_arrow *a, const double *sums)
{
    const size_t S = a->S, K = a->K;
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) a->shape[i * S + j] = sums[ff_tri(i, j)];
    sums += S * (S + 1) / 2;
    for (size_t c = 0; c < a->C; c++, sums += ff_influence_channel(a)) {
        memcpy(a->cross + c * K * S, sums, K * S * sizeof *sums);
        for (size_t i = 0; i < K; i++)
            for (size_t j = 0; j < K; j++) a->block[(c * K + i) * K + j] = sums[K * S + ff_tri(i, j)];
    }
}

/* From scaled covariances to those of the parameters. */
static void unscale(ff_arrow *a, double factor)
{
    const size_t S = a->S, K = a->K;
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) a->shape[i * S + j] *= factor * a->scale[i] * a->scale[j];
    for (size_t c = 0; c < a->C; c++) {
        const double *scale = a->scale + S + c * K;
        for (size_t i = 0; i < K; i++) {
            for (size_t j = 0; j < S; j++) a->cross[(c * K + i) * S + j] *= factor * scale[i] * a->scale[j];
            for (size_t j = 0; j < K; j++) a->block[(c * K + i) * K + j] *= factor * scale[i] * scale[j];
        }
    }
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* The blocks' inverses at the optimum, and what they say by themselves. */
static ff_arrow *prepare(const ff_layout *l, const ff_normal *n, const int *at_bound, size_t values, int sandwich)
{
    ff_arrow *a = arrow_new(l);
    int *use = malloc((l->P + 1) * sizeof *use);
    if (a && use) {
        for (size_t k = 0; k < l->P; k++) {
            use[k] = at_bound[k] == 0;
            a->used += (size_t)use[k];
        }
        fill_scale(a, n);
        invert_blocks(a, n, use);
        fill_inverse(a);
        fill_determined(a, use, !sandwich || values > a->used);
        free(use);
        return a;
    }
    free(use);
    ff_arrow_free(a);
    return NULL;
}

static ff_status plain_pass(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                            const double *channel, ff_solution *solution)
{
    ff_pass pass;
    ff_status st = ff_normal_new(l, &solution->normal);
    if (!st) st = ff_layout_pass(l, p, o, shape, channel, &pass);
    if (st) return st;
    solution->passes++;
    st = ff_pass_run(&pass, 1, &solution->normal);
    ff_pass_free(&pass);
    return st;
}

ff_status ff_arrow_finish(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                          const double *channel, const int *at_bound, ff_solution *solution)
{
    const int sandwich = p->selection.weighting != FF_WEIGHT_SIGMA;
    const double G = (double)p->n, N = G * (double)l->n_channels;
    ff_status st = solution->normal.gram ? FF_OK : plain_pass(l, p, o, shape, channel, solution);
    if (st) return st;
    if (o->std_errors) {
        solution->arrow = prepare(l, &solution->normal, at_bound, p->n * l->n_channels, sandwich);
        if (!solution->arrow) return FF_ERR_MEMORY;
    }
    ff_arrow *a = solution->arrow, *summed = sandwich ? a : NULL;
    const size_t n_sums = FF_STAT_COUNT + (summed ? a->S * (a->S + 1) / 2 + a->C * ff_influence_channel(a) : 0);
    double *sums = malloc(n_sums * sizeof *sums);
    ff_pass pass;
    st = sums ? ff_layout_pass(l, p, o, shape, channel, &pass) : FF_ERR_MEMORY;
    if (!st) {
        solution->passes++;
        st = influence_pass(&pass, summed, n_sums, sums);
        ff_pass_free(&pass);
    }
    if (!st) memcpy(solution->normal.stat, sums, sizeof solution->normal.stat);
    if (!st && summed) fill_sandwich(a, sums + FF_STAT_COUNT);
    if (!st && a) unscale(a, sandwich && N > (double)a->used && G > 1 ? G / (G - 1) * (N - 1) / (N - (double)a->used) : 1);
    free(sums);
    return st;
}
