/* One pass over the samples with a curve for their distribution. The blocks are cut into slices that do not depend on the threads,
 * and the slices' sums are merged in their order. */
#include "internal_ndf.h"
#include <math.h>
#include <stdlib.h>

enum { SLICES = 16, SLICE_BLOCKS = 32 }; /* at most; of about so many blocks at least */

void ff_ndf_blocks_scalar(const ff_ndf_place *at, size_t first, size_t end, int with_meat, ff_ndf_channel_planes *channel,
                          ff_ndf_sums *sums);
#ifdef FF_HAVE_AVX2
void ff_ndf_blocks_avx2(const ff_ndf_place *at, size_t first, size_t end, int with_meat, ff_ndf_channel_planes *channel,
                        ff_ndf_sums *sums);
#endif
#ifdef FF_HAVE_AVX512
void ff_ndf_blocks_avx512(const ff_ndf_place *at, size_t first, size_t end, int with_meat, ff_ndf_channel_planes *channel,
                          ff_ndf_sums *sums);
#endif

/* cost2, gradient, gram, meat, in one piece. */
static size_t doubles_of(size_t n)
{
    return 1 + n + 2 * n * n;
}

static void point_into(ff_ndf_sums *s, double *memory)
{
    s->gradient = memory + 1;
    s->gram = s->gradient + s->n;
    s->meat = s->gram + s->n * s->n;
}

ff_status ff_ndf_sums_new(const ff_curve *curve, size_t n_channels, ff_ndf_sums *out)
{
    ff_ndf_sums s = {.n_curve = (size_t)curve->top + 1, .n_channels = n_channels};
    s.n_raw = s.n_curve + 1 + (size_t)curve->n_lambda;
    s.n = s.n_raw + 2 * n_channels;
    double *memory = calloc(doubles_of(s.n), sizeof *memory);
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
    int with_meat;
    size_t slices;
    ff_ndf_sums like;
    double *memory;                 /* [slices][doubles_of n] */
    ff_ndf_channel_planes *channel; /* [threads][n_channels]  */
} pass;

static void run_slice(void *context, size_t slice, int worker)
{
    const pass *s = context;
    const struct ff_problem *p = s->at->p;
    ff_ndf_sums sums = s->like;
    double *memory = s->memory + slice * doubles_of(sums.n);
    point_into(&sums, memory);
    sums.cost2 = 0;
    FF_ISA_PICK(p->isa, ff_ndf_blocks)
    (s->at, slice * p->n_blocks / s->slices, (slice + 1) * p->n_blocks / s->slices, s->with_meat,
     s->channel + (size_t)worker * p->n_channels, &sums);
    memory[0] = sums.cost2;
}

/* The rows of the channels hold their products with the lobe's columns, whose own square is whole. */
static void mirror(double *matrix, size_t n)
{
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < a; b++) matrix[b * n + a] = matrix[a * n + b];
}

ff_status ff_ndf_sum(const ff_ndf_place *at, int with_meat, ff_ndf_sums *out)
{
    const struct ff_problem *p = at->p;
    const size_t n = doubles_of(out->n), used = with_meat ? n : n - out->n * out->n, least = p->n_blocks / SLICE_BLOCKS + 1;
    pass s = {.at = at, .with_meat = with_meat, .slices = least < SLICES ? least : SLICES, .like = *out};
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
        mirror(out->gram, out->n);
        mirror(out->meat, out->n);
    }
    free(s.memory);
    free(s.channel);
    return status;
}
