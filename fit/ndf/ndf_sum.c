/* One pass over the samples with a curve for their distribution. The blocks are cut into slices that do not depend on the threads,
 * and the slices' sums are merged in their order. */
#include "internal_ndf.h"
#include <math.h>
#include <stdlib.h>

enum { SLICES = 16, SLICE_BLOCKS = 32 }; /* at most; of about so many blocks at least */

void ff_ndf_blocks_scalar(const ff_ndf_place *at, size_t first, size_t end, int with_products, ff_ndf_channel_planes *channel,
                          ff_ndf_sums *sums);
#ifdef FF_HAVE_AVX2
void ff_ndf_blocks_avx2(const ff_ndf_place *at, size_t first, size_t end, int with_products, ff_ndf_channel_planes *channel,
                        ff_ndf_sums *sums);
#endif
#ifdef FF_HAVE_AVX512
void ff_ndf_blocks_avx512(const ff_ndf_place *at, size_t first, size_t end, int with_products, ff_ndf_channel_planes *channel,
                          ff_ndf_sums *sums);
#endif

/* cost2, gradient, gram, score_products in one piece; each square with the cross products of the directions' stencils, [n_raw][n].
 */
static size_t square_of(const ff_ndf_sums *s)
{
    return (s->n + s->n_raw) * s->n;
}

static size_t doubles_of(const ff_ndf_sums *s)
{
    return 1 + s->n + 2 * square_of(s);
}

static void point_into(ff_ndf_sums *s, double *memory)
{
    s->gradient = memory + 1;
    s->gram = s->gradient + s->n;
    s->gram_cross = s->gram + s->n * s->n;
    s->score_products = s->gram + square_of(s);
    s->products_cross = s->score_products + s->n * s->n;
}

ff_status ff_ndf_sums_new(const ff_curve *curve, size_t n_channels, ff_ndf_sums *out)
{
    ff_ndf_sums s = {.n_curve = (size_t)curve->top + 1, .n_channels = n_channels};
    s.n_raw = s.n_curve + (size_t)curve->n_lambda;
    s.n = s.n_raw + 2 * n_channels;
    double *memory = calloc(doubles_of(&s), sizeof *memory);
    if (!memory) return FF_ERR_MEMORY;
    point_into(&s, memory);
    *out = s;
    return FF_OK;
}

void ff_ndf_sums_free(ff_ndf_sums *s)
{
    if (s->gradient) free(s->gradient - 1);
    *s = (ff_ndf_sums){.n = 0};
}

typedef struct pass {
    const ff_ndf_place *at;
    int with_products;
    size_t slices;
    ff_ndf_sums like;
    double *memory;                 /* [slices][doubles_of]   */
    ff_ndf_channel_planes *channel; /* [threads][n_channels]  */
} pass;

static void run_slice(void *context, size_t slice, int worker)
{
    const pass *s = context;
    const struct ff_problem *p = s->at->p;
    ff_ndf_sums sums = s->like;
    double *memory = s->memory + slice * doubles_of(&sums);
    point_into(&sums, memory);
    sums.cost2 = 0;
    FF_ISA_PICK(p->isa, ff_ndf_blocks)
    (s->at, slice * p->n_blocks / s->slices, (slice + 1) * p->n_blocks / s->slices, s->with_products,
     s->channel + (size_t)worker * p->n_channels, &sums);
    memory[0] = sums.cost2;
}

/* Adds the cross products in both orders; what stands below the diagonal goes above it too. */
static void make_whole(const ff_ndf_sums *s, double *matrix, const double *cross)
{
    const size_t n = s->n;
    for (size_t a = 0; a < s->n_raw; a++)
        for (size_t b = 0; b <= a; b++) matrix[a * n + b] += cross[a * n + b] + cross[b * n + a];
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < a; b++) matrix[b * n + a] = matrix[a * n + b];
}

ff_status ff_ndf_sum(const ff_ndf_place *at, int with_products, ff_ndf_sums *out)
{
    const struct ff_problem *p = at->p;
    const size_t n = doubles_of(out), used = with_products ? n : n - square_of(out), least = p->n_blocks / SLICE_BLOCKS + 1;
    pass s = {.at = at, .with_products = with_products, .slices = least < SLICES ? least : SLICES, .like = *out};
    s.memory = calloc(s.slices * n, sizeof *s.memory);
    s.channel = malloc((size_t)ff_pool_threads(p->pool) * p->n_channels * sizeof *s.channel);
    ff_status status = s.memory && s.channel ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        ff_pool_run(p->pool, s.slices, run_slice, &s);
        double *sum = out->gradient - 1;
        for (size_t k = 0; k < n; k++) sum[k] = 0;
        for (size_t slice = 0; slice < s.slices; slice++)
            for (size_t k = 0; k < used; k++) sum[k] += s.memory[slice * n + k];
        for (size_t k = 0; k < used; k++)
            if (!isfinite(sum[k])) status = FF_ERR_INTERNAL;
        out->cost2 = sum[0];
        make_whole(out, out->gram, out->gram_cross);
        make_whole(out, out->score_products, out->products_cross);
    }
    free(s.memory);
    free(s.channel);
    return status;
}
