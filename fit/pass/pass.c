/* A pass over all samples: chunks of blocks are shared out, summed in lanes, and merged in their order. */
#include "internal_evaluate.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void ff_pass_chunk_scalar(const ff_pass *pass, size_t first_block, size_t n_blocks, const ff_chunk_sums *sums);
#ifdef FF_HAVE_AVX2
void ff_pass_chunk_avx2(const ff_pass *pass, size_t first_block, size_t n_blocks, const ff_chunk_sums *sums);
#endif
#ifdef FF_HAVE_AVX512
void ff_pass_chunk_avx512(const ff_pass *pass, size_t first_block, size_t n_blocks, const ff_chunk_sums *sums);
#endif

ff_pass_chunk_fn ff_pass_chunk_get(ff_isa isa)
{
    return ff_isa_available(isa) ? FF_ISA_PICK(isa, ff_pass_chunk) : NULL;
}

ff_status ff_normal_new(size_t n_shape, size_t n_channel, size_t n_channels, int diagonal, ff_normal *out)
{
    ff_normal n = {.m1 = n_shape + n_channel + 1, .P = n_shape + n_channels * n_channel, .n_channels = n_channels};
    n.gram = calloc(n_channels * (n.m1 * (n.m1 + 1) / 2), sizeof *n.gram);
    n.score_products = calloc(diagonal ? n.P + 1 : n.P * (n.P + 1) / 2 + 1, sizeof *n.score_products);
    n.own = calloc(n.P + 1, sizeof *n.own);
    if (!n.gram || !n.score_products || !n.own) {
        ff_normal_free(&n);
        return FF_ERR_MEMORY;
    }
    *out = n;
    return FF_OK;
}

void ff_normal_free(ff_normal *n)
{
    free(n->gram);
    free(n->score_products);
    free(n->own);
    free(n->runs);
    *n = (ff_normal){0};
}

/* All sums of a chunk, lanes reduced: cost2, gram, stat, score_products, own, in this order. */
typedef struct run {
    const ff_pass *pass;
    ff_pass_chunk_fn kernel;
    size_t share, n_gram, n_products, n_own, n_sums, n_score;
    double *lanes;         /* [threads][n_sums * 8 + n_score] */
    ff_pass_scratch *work; /* [threads]                       */
    double *result;        /* [chunks][n_sums]                */
    double *runs;
} run;

static void run_chunk(void *context, size_t chunk, int worker)
{
    const run *r = context;
    const struct ff_problem *p = r->pass->p;
    double *lanes = r->lanes + (size_t)worker * (r->n_sums * 8 + r->n_score);
    ff_chunk_sums sums;
    sums.cost2 = lanes;
    sums.gram = sums.cost2 + 8;
    sums.stat = sums.gram + r->n_gram * 8;
    sums.score_products = sums.stat + FF_STAT_COUNT * 8;
    sums.own = sums.score_products + r->n_products * 8;
    sums.score = sums.own + r->n_own * 8;
    sums.runs = r->runs;
    sums.work = r->work + worker;
    memset(lanes, 0, r->n_sums * 8 * sizeof *lanes);
    const size_t first = chunk * r->share, left = p->n_blocks - first;
    r->kernel(r->pass, first, left < r->share ? left : r->share, &sums);
    double *out = r->result + chunk * r->n_sums;
    const size_t max_at = 1 + r->n_gram + FF_STAT_MAX;
    for (size_t k = 0; k < r->n_sums; k++) {
        double sum = lanes[k * 8];
        for (int i = 1; i < 8; i++) {
            const double v = lanes[k * 8 + (size_t)i];
            sum = k == max_at ? (v > sum ? v : sum) : sum + v;
        }
        out[k] = sum;
    }
}

ff_status ff_pass_run(const ff_pass *pass, int parallel, ff_normal *out)
{
    const struct ff_problem *p = pass->p;
    const size_t share = parallel ? ff_problem_share(p) : FF_CHUNK, chunks = (p->n_blocks + share - 1) / share;
    const size_t tri = out->m1 * (out->m1 + 1) / 2;
    run r = {.pass = pass, .kernel = ff_pass_chunk_get(p->isa), .share = share};
    r.n_gram = out->n_channels * tri;
    const int errors = pass->final && pass->errors;
    r.n_products = errors ? out->P * (out->P + 1) / 2 : 0;
    r.n_own = errors ? out->P : 0;
    r.n_sums = 1 + r.n_gram + FF_STAT_COUNT + r.n_products + r.n_own;
    r.n_score = errors ? out->P * FF_BLOCK : 0;
    if (errors && !out->runs) {
        out->n_runs = p->n_blocks * (FF_BLOCK / ff_run_length(p));
        out->runs = malloc((out->n_runs * out->P + 1) * sizeof *out->runs);
        if (!out->runs) return FF_ERR_MEMORY;
    }
    r.runs = out->runs;
    const size_t threads = parallel ? (size_t)ff_pool_threads(p->pool) : 1, per_thread = r.n_sums * 8 + r.n_score;
    /* lanes and scores are read as whole vectors: both start on a cache line */
    r.lanes = aligned_alloc(64, (threads * per_thread * sizeof(double) + 63) / 64 * 64);
    r.work = aligned_alloc(64, threads * sizeof *r.work);
    r.result = malloc(chunks * r.n_sums * sizeof(double));
    ff_average_work **average = NULL;
    if (!r.lanes || !r.work || !r.result || !r.kernel || ff_evaluate_works(pass, threads, &average)) {
        free(r.lanes);
        free(r.work);
        free(r.result);
        return r.kernel ? FF_ERR_MEMORY : FF_ERR_UNSUPPORTED;
    }
    for (size_t i = 0; i < threads; i++) r.work[i].average = average ? average[i] : NULL;
    if (parallel)
        ff_pool_run(p->pool, chunks, run_chunk, &r);
    else
        for (size_t c = 0; c < chunks; c++) run_chunk(&r, c, 0);
    /* merge in the order of the chunks, whoever summed them */
    double cost2 = 0;
    memset(out->gram, 0, r.n_gram * sizeof(double));
    memset(out->score_products, 0, r.n_products * sizeof(double));
    memset(out->own, 0, r.n_own * sizeof(double));
    memset(out->stat, 0, sizeof out->stat);
    for (size_t c = 0; c < chunks; c++) {
        const double *s = r.result + c * r.n_sums;
        cost2 += *s++;
        for (size_t k = 0; k < r.n_gram; k++) out->gram[k] += *s++;
        for (size_t k = 0; k < FF_STAT_COUNT; k++, s++)
            out->stat[k] = k == FF_STAT_MAX ? fmax(out->stat[k], *s) : out->stat[k] + *s;
        for (size_t k = 0; k < r.n_products; k++) out->score_products[k] += *s++;
        for (size_t k = 0; k < r.n_own; k++) out->own[k] += *s++;
    }
    ff_average_works_free(average);
    free(r.lanes);
    free(r.work);
    free(r.result);
    if (pass->robust == FF_ROBUST_NONE)
        for (size_t c = 0; c < out->n_channels; c++) cost2 += out->gram[(c + 1) * tri - 1]; /* r^T r */
    out->cost2 = cost2;
    return isfinite(cost2) ? FF_OK : FF_ERR_INTERNAL;
}
