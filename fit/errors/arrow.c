/* The uncertainty of a fit with many channels, at a cost that is linear in their number: see internal_arrow.h. */
#include "internal_arrow.h"
#include "base/internal_statistics.h"
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
    const size_t sizes[] = {l->P, S * S, C * K * K, C * K * S, S * S, C * K * S, C * K * K, l->P};
    double **const parts[] = {&a->scale, &a->inverse, &a->own, &a->follow, &a->shape, &a->cross, &a->block, &a->dof};
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
    double *runs;
} run;

/* Products of influences: of the shape, then of the channels. */
static size_t products(const ff_arrow *a)
{
    return a ? a->S * (a->S + 1) / 2 + a->C * ff_influence_channel(a) : 0;
}

/* Sums of a pass: statistics, products, own, whole. */
static size_t all_sums(const ff_arrow *a)
{
    return FF_STAT_COUNT + products(a) + (a ? a->P + a->S : 0);
}

static void run_chunk(void *context, size_t chunk, int worker)
{
    const run *r = context;
    const struct ff_problem *p = r->pass->p;
    double *lanes = r->lanes + (size_t)worker * (r->n_sums * 8 + r->n_score);
    ff_influence_sums sums = {.stat = lanes, .shape = lanes + FF_STAT_COUNT * 8, .runs = r->runs};
    sums.channel = sums.shape + (r->arrow ? r->arrow->S * (r->arrow->S + 1) / 2 * 8 : 0);
    sums.own = sums.shape + products(r->arrow) * 8;
    sums.whole = sums.own + (r->arrow ? r->arrow->P * 8 : 0);
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

/* The sums of all chunks, merged in their order, into out [all_sums], and those over runs of samples. */
static ff_status influence_pass(const ff_pass *pass, const ff_arrow *arrow, double *runs, double *out)
{
    const struct ff_problem *p = pass->p;
    const size_t share = ff_problem_share(p), chunks = (p->n_blocks + share - 1) / share,
                 threads = (size_t)ff_pool_threads(p->pool), n_sums = all_sums(arrow);
    run r = {.pass = pass, .arrow = arrow, .n_sums = n_sums, .n_score = arrow ? arrow->P * FF_BLOCK : 0, .runs = runs};
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

/* ---- influences of clusters ------------------------------------------------------------------ */

void ff_arrow_apply(const ff_arrow *a, const double *score, double *influence)
{
    const size_t S = a->S, K = a->K;
    double left[FF_MAX_SHAPE];
    for (size_t k = 0; k < S; k++) {
        left[k] = score[k];
        for (size_t q = 0; q < a->C * K; q++) left[k] -= a->follow[q * S + k] * score[S + q];
    }
    for (size_t k = 0; k < S; k++) {
        influence[k] = 0;
        for (size_t q = 0; q < S; q++) influence[k] += a->inverse[k * S + q] * left[q];
    }
    for (size_t k = 0; k < a->C * K; k++) {
        double v = 0;
        for (size_t q = 0; q < K; q++) v += a->own[k * K + q] * score[S + k / K * K + q];
        for (size_t q = 0; q < S; q++) v -= a->follow[k * S + q] * influence[q];
        influence[S + k] = v;
    }
}

/* Adds factor times the products of an influence [P] to sums [products]. */
static void add_products(const ff_arrow *a, const double *influence, double factor, double *sums)
{
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

/* Products of influences into the covariances, scaled. */
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

/* Variance of parameter k in products of influences. */
static double variance_in(const ff_arrow *a, const double *sums, size_t k)
{
    if (k < a->S) return sums[ff_tri(k, k)];
    const size_t c = (k - a->S) / a->K, i = (k - a->S) % a->K;
    return sums[a->S * (a->S + 1) / 2 + c * ff_influence_channel(a) + a->K * a->S + ff_tri(i, i)];
}

/* Covariances times factor [P] of both parameters. */
static void multiply(ff_arrow *a, const double *factor)
{
    const size_t S = a->S, K = a->K;
    for (size_t i = 0; i < S; i++)
        for (size_t j = 0; j < S; j++) a->shape[i * S + j] *= factor[i] * factor[j];
    for (size_t c = 0; c < a->C; c++) {
        const double *own = factor + S + c * K;
        for (size_t i = 0; i < K; i++) {
            for (size_t j = 0; j < S; j++) a->cross[(c * K + i) * S + j] *= own[i] * factor[j];
            for (size_t j = 0; j < K; j++) a->block[(c * K + i) * K + j] *= own[i] * own[j];
        }
    }
}

/* Products of the influences of clusters of a->clusters.run samples into clustered [products]; single comes with those of samples,
 * and loses their mean. Also the number of independent values. */
static ff_status sum_clusters(ff_arrow *a, const struct ff_problem *p, const ff_normal *n, double *single, double *clustered)
{
    const size_t P = a->P, S = a->S, length = ff_run_length(p), runs = (p->n + length - 1) / length;
    double *sums = malloc((runs * P + 1) * sizeof *sums), *mean = malloc((2 * P + 1) * sizeof *mean), *influence = mean + P;
    double *meat = calloc(S * (S + 1) / 2 + 1, sizeof *meat);
    const ff_status st = sums && mean && meat ? FF_OK : FF_ERR_MEMORY;
    if (!st) {
        size_t now = ff_clusters_centred(p, n, p->n, sums, mean);
        ff_arrow_apply(a, mean, influence);
        add_products(a, influence, -(double)p->n, single);
        for (size_t k = 0; k < S; k++) meat[ff_tri(k, k)] = n->meat[k] - (double)p->n * mean[k] * mean[k];
        if (a->clusters.run > 1) {
            for (size_t run = length; run < a->clusters.run; run *= 2) now = ff_clusters_join(sums, now, P);
            memset(meat, 0, S * (S + 1) / 2 * sizeof *meat);
            for (size_t b = 0; b < now; b++) {
                ff_arrow_apply(a, sums + b * P, influence);
                add_products(a, influence, 1, clustered);
                for (size_t k = 0; k < S; k++) meat[ff_tri(k, k)] += sums[b * P + k] * sums[b * P + k];
            }
        }
        a->effective = S ? ff_clusters_effective(n, meat, S, (double)(p->n * a->C)) : (double)(p->n * a->C);
    }
    free(sums);
    free(mean);
    free(meat);
    return st;
}

/* Covariances of the parameters, as in covariance.c: from the blocks of H^-1 that a has, or the products of influences. */
static ff_status fill_covariances(ff_arrow *a, const struct ff_problem *p, const ff_normal *n, const double *of_samples)
{
    const int sigma = p->selection.weighting == FF_WEIGHT_SIGMA;
    const size_t P = a->P, length = ff_run_length(p), run = a->clusters.run > length ? a->clusters.run : length;
    const double N = (double)(p->n * a->C), correction = !sigma && N > (double)a->used ? (N - 1) / (N - (double)a->used) : 1;
    double *single = calloc(2 * products(a) + 1, sizeof *single), *clustered = single + products(a),
           *factor = malloc((P + 1) * sizeof *factor);
    ff_status st = single && factor ? FF_OK : FF_ERR_MEMORY;
    if (!st) {
        memcpy(single, of_samples, products(a) * sizeof *single);
        st = sum_clusters(a, p, n, single, clustered);
    }
    for (size_t k = 0; k < P; k++) a->dof[k] = INFINITY; /* still the number of clusters */
    if (!st && !(sigma && a->clusters.run == 1))
        st = ff_clusters_informative(p, n, p->n, NULL, (p->n + run - 1) / run, NULL, a, a->dof);
    if (!st) {
        if (!sigma) fill_sandwich(a, a->clusters.run > 1 ? clustered : single);
        for (size_t k = 0; k < P; k++) {
            const double one = variance_in(a, single, k), more = variance_in(a, clustered, k),
                         seen = ff_clusters_share_seen(a->of_channel, a->dof[k]);
            factor[k] = correction;
            if (sigma && a->clusters.run > 1 && one > 0) factor[k] *= fmax(more / one, 1);
            if (a->clusters.run > 1) factor[k] /= seen;
            factor[k] = a->scale[k] * sqrt(factor[k]);
            a->dof[k] -= 1;
        }
        multiply(a, factor);
    }
    free(single);
    free(factor);
    return st;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* The blocks' inverses at the optimum, of the parameters in use, and what they say by themselves. */
static ff_arrow *prepare(const ff_layout *l, const ff_normal *n, const int *at_bound, size_t values, int sandwich)
{
    ff_arrow *a = arrow_new(l);
    int *use = malloc((l->P + 1) * sizeof *use);
    if (a && use) {
        for (size_t k = 0; k < l->P; k++) {
            use[k] = at_bound ? at_bound[k] == 0 : !ff_layout_is_fixed(l, k);
            a->used += (size_t)use[k];
            a->of_channel += (double)use[k] / (k < l->free.n_shape ? 1 : (double)l->n_channels);
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

/* The sums of the score that clusters are chosen by, scaled. */
static ff_status make_room_for_scores(const struct ff_problem *p, ff_normal *n)
{
    n->diagonal = 1;
    n->n_runs = p->n_blocks * (FF_BLOCK / ff_run_length(p));
    free(n->runs);
    n->runs = malloc((n->n_runs * n->P + 1) * sizeof *n->runs);
    return n->runs ? FF_OK : FF_ERR_MEMORY;
}

ff_status ff_arrow_finish(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                          const double *channel, const int *at_bound, ff_solution *solution)
{
    ff_normal *n = &solution->normal;
    ff_status st = n->gram ? FF_OK : plain_pass(l, p, o, shape, channel, solution);
    if (st) return st;
    if (o->std_errors) {
        solution->arrow = prepare(l, n, at_bound, p->n * l->n_channels, p->selection.weighting != FF_WEIGHT_SIGMA);
        if (!solution->arrow || make_room_for_scores(p, n)) return FF_ERR_MEMORY;
    }
    ff_arrow *a = solution->arrow;
    double *sums = malloc(all_sums(a) * sizeof *sums);
    ff_pass pass;
    st = sums ? ff_layout_pass(l, p, o, shape, channel, &pass) : FF_ERR_MEMORY;
    if (!st) {
        solution->passes++;
        st = influence_pass(&pass, a, n->runs, sums);
        ff_pass_free(&pass);
    }
    if (!st) memcpy(n->stat, sums, sizeof n->stat);
    if (!st && a) {
        const double *own = sums + FF_STAT_COUNT + products(a);
        memcpy(n->own, own, a->P * sizeof *own);
        memcpy(n->meat, own + a->P, a->S * sizeof *own); /* a parameter of a channel has one value a sample */
        memcpy(n->meat + a->S, own + a->S, (a->P - a->S) * sizeof *own);
        st = ff_clusters_choose(p, n, p->n, &a->clusters);
        if (!st) st = fill_covariances(a, p, n, sums + FF_STAT_COUNT);
    }
    solution->has_final = !st;
    free(sums);
    return st;
}

/* ---- intervals and condition ----------------------------------------------------------------- */

/* J^T r of parameter k. */
static double slope_of(const ff_arrow *a, const ff_normal *n, size_t k)
{
    const size_t tri = n->m1 * (n->m1 + 1) / 2, m = n->m1 - 1;
    if (k >= a->S) return n->gram[(k - a->S) / a->K * tri + ff_tri(m, a->S + (k - a->S) % a->K)];
    double sum = 0;
    for (size_t c = 0; c < a->C; c++) sum += n->gram[c * tri + ff_tri(m, k)];
    return sum;
}

/* Parameters on a bound, from an arrow of all parameters. */
static ff_status one_sided(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                           const ff_clusters *clusters, ff_fit_result *r)
{
    const size_t P = l->P;
    ff_arrow *a = prepare(l, n, NULL, p->n * l->n_channels, p->selection.weighting != FF_WEIGHT_SIGMA);
    double *inverse = malloc((P + 1) * sizeof *inverse), *none = a ? calloc(products(a) + 1, sizeof *none) : NULL;
    ff_status st = a && inverse && none ? FF_OK : FF_ERR_MEMORY;
    for (size_t k = 0; k < P && !st; k++)
        inverse[k] =
            (k < a->S ? a->shape[k * a->S + k] : a->block[(k - a->S) * a->K + (k - a->S) % a->K]) * a->scale[k] * a->scale[k];
    if (!st) {
        const size_t shortest = ff_run_length(p);
        a->clusters = *clusters;
        if (a->clusters.run < shortest && p->selection.weighting != FF_WEIGHT_SIGMA) a->clusters.run = shortest;
        st = fill_covariances(a, p, n, none);
    }
    for (size_t k = 0; k < P && !st; k++) {
        if (!at_bound[k] || ff_layout_is_fixed(l, k)) continue;
        const double t = ff_student_quantile(0.9, a->dof[k]),
                     cov = k < a->S ? a->shape[k * a->S + k] : a->block[(k - a->S) * a->K + (k - a->S) % a->K];
        const int known = a->determined[k] && inverse[k] > 0;
        ff_interval_from_bound(ff_layout_param(l, k, NULL)->info, slope_of(a, n, k), known ? inverse[k] : 0,
                               0.5 * t * t * (known ? cov / inverse[k] : INFINITY), ff_result_value(l, r, k));
    }
    free(none);
    free(inverse);
    ff_arrow_free(a);
    return st;
}

ff_status ff_arrow_intervals(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                             const ff_arrow *a, ff_fit_result *r)
{
    int any = 0;
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        any |= at_bound[k] && !ff_layout_is_fixed(l, k);
        if (isnan(v->std_error)) continue;
        ff_interval_around(ff_layout_param(l, k, NULL)->info, ff_student_quantile(0.95, a->dof[k]) * v->std_error, FF_INTERVAL_WALD,
                           v);
    }
    return any ? one_sided(l, p, n, at_bound, &a->clusters, r) : FF_OK;
}

/* out = H x, scaled, of the parameters in use. */
static void multiply_by_h(const ff_arrow *a, const ff_normal *n, const int *use, const double *x, double *out)
{
    memset(out, 0, a->P * sizeof *out);
    for (size_t c = 0; c < a->C; c++)
        for (size_t i = 0; i < n->m1 - 1; i++)
            for (size_t j = 0; j < n->m1 - 1; j++) {
                const size_t to = i < a->S ? i : i + c * a->K, from = j < a->S ? j : j + c * a->K;
                if (use[to] && use[from]) out[to] += entry(a, n, c, i, j) * x[from];
            }
}

/* Largest eigenvalue of H, or of its inverse, by the power method from a vector without symmetry; work [2 P]. */
static double largest_eigenvalue(const ff_arrow *a, const ff_normal *n, const int *use, int inverse, double *work)
{
    enum { MOST = 3000 };
    double *x = work, *y = work + a->P, value = 0;
    for (size_t k = 0; k < a->P; k++) x[k] = use[k] ? 1 + 0.5 * sin(1 + 2.4 * (double)k) : 0;
    for (int step = 0; step < MOST; step++) {
        double norm = 0, before = value;
        for (size_t k = 0; k < a->P; k++) norm += x[k] * x[k];
        norm = sqrt(norm);
        if (!(norm > 0)) return 0;
        for (size_t k = 0; k < a->P; k++) x[k] /= norm;
        if (inverse)
            ff_arrow_apply(a, x, y);
        else
            multiply_by_h(a, n, use, x, y);
        value = 0;
        for (size_t k = 0; k < a->P; k++) value += x[k] * y[k];
        memcpy(x, y, a->P * sizeof *x);
        if (fabs(value - before) <= 1e-12 * value) break;
    }
    return value;
}

ff_status ff_arrow_condition(const ff_normal *n, const ff_arrow *a, const int *use, ff_fit_result *r)
{
    double *work = malloc((2 * a->P + 1) * sizeof *work);
    size_t lost = 0;
    if (!work) return FF_ERR_MEMORY;
    for (size_t k = 0; k < a->P; k++) lost += use[k] && !(a->determined[k]);
    const double most = largest_eigenvalue(a, n, use, 0, work), least = largest_eigenvalue(a, n, use, 1, work);
    r->rank = a->used - lost;
    r->condition = a->used == 0 ? 1 : least < 1e12 ? sqrt(most * least) : INFINITY;
    free(work);
    return FF_OK;
}
