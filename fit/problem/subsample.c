/* Fewer samples that stand for all: for the search of a start and for the way to the optimum. */
#define _GNU_SOURCE /* madvise */
#include "internal_problem.h"
#include "fit/losses/internal_loss.h"
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Memory of the blocks, in large pages where the system has them: a pass walks through all of it. */
double *ff_block_memory(size_t bytes)
{
    const size_t page = (size_t)1 << 21, size = (bytes + page - 1) / page * page;
    if (bytes < page) return aligned_alloc(64, (bytes + 63) / 64 * 64);
    double *data = aligned_alloc(page, size);
    if (data) madvise(data, size, MADV_HUGEPAGE); /* a hint: nothing depends on it */
    return data;
}

/* Bins of magnitudes: exponent and four bits of the mantissa of a positive float. */
enum { FF_BINS = 0x1000 };

static size_t bin_of(float m)
{
    uint32_t bits;
    memcpy(&bits, &m, sizeof bits);
    return (size_t)(bits >> 19) & 0xfff;
}

/* The smallest bin such that no more than `count` samples lie in it or above. */
static size_t threshold_bin(const size_t *histogram, size_t count)
{
    size_t sum = 0, bin = FF_BINS;
    while (bin > 0 && sum + histogram[bin - 1] <= count) sum += histogram[--bin];
    return bin;
}

/* A stride that shares no factor with the usual periods of grids. */
static size_t stride_for(size_t rest, size_t wanted)
{
    size_t s = rest / (wanted > 0 ? wanted : 1);
    if (s < 2) return 1;
    while (s % 2 == 0 || s % 3 == 0 || s % 5 == 0) s++;
    return s;
}

/* The samples of a subsample and what each stands for. */
typedef struct subsampling {
    const struct ff_problem *from;
    struct ff_problem *to;
    uint32_t *index;     /* [to->n]                                          */
    double rest_weight;  /* root weight of those with rest[k] = 1            */
    unsigned char *rest; /* [to->n]                                          */
} subsampling;

static int is_weight_plane(const struct ff_problem *p, size_t plane)
{
    const int n_weights = p->weight_stride ? (int)p->n_channels : 1, k = (int)plane;
    return (k >= p->weight && k < p->weight + n_weights) || k == p->sample_weight;
}

static void subsample_plane(void *context, size_t plane, int worker)
{
    const subsampling *t = context;
    const double factor = is_weight_plane(t->from, plane) ? t->rest_weight : 1;
    (void)worker;
    for (size_t k = 0; k < t->to->n; k++) {
        const size_t i = t->index[k];
        const double v = ff_problem_plane(t->from, i / FF_BLOCK, (int)plane)[i % FF_BLOCK];
        ff_problem_plane(t->to, k / FF_BLOCK, (int)plane)[k % FF_BLOCK] = t->rest[k] ? v * factor : v;
    }
    /* lanes beyond the last repeat it, without weight: a direction of zeros would be none */
    const size_t last = t->to->n - 1;
    const double v = is_weight_plane(t->from, plane) ? 0 : ff_problem_plane(t->to, last / FF_BLOCK, (int)plane)[last % FF_BLOCK];
    for (size_t k = t->to->n; k < t->to->n_blocks * FF_BLOCK; k++)
        ff_problem_plane(t->to, k / FF_BLOCK, (int)plane)[k % FF_BLOCK] = v;
}

/* Replaces loss by its tangent at the data: w g'(y) (f - y). A datum near 0, where the cube root is steep, counts as 1 % of the
 * mean. */
static void linearise(struct ff_problem *p)
{
    const struct ff_problem old = *p;
    double mean = 0;
    for (size_t i = 0; i < p->n; i++) mean += fabs(ff_problem_plane(p, i / FF_BLOCK, p->value)[i % FF_BLOCK]) / (double)p->n;
    for (size_t b = 0; b < p->n_blocks; b++) {
        const double *x = ff_loss_reads_cosine(p->loss) ? ff_problem_plane(p, b, p->geometry[FF_G_COS_I]) : NULL;
        /* the planes of g(y) become weights per channel; their former place is taken by the values */
        for (size_t c = 0; c < p->n_channels; c++) {
            const double *w = ff_problem_plane(&old, b, old.weight + old.weight_stride * (int)c),
                         *y = ff_problem_plane(&old, b, old.value + (int)c);
            double *target = ff_problem_plane(&old, b, old.target + (int)c);
            double at[FF_BLOCK], slope[FF_BLOCK];
            for (int i = 0; i < FF_BLOCK; i++) at[i] = fmax(fabs(y[i]), 0.01 * mean);
            ff_loss_slopes(p->loss, FF_BLOCK, at, x, slope);
            for (int i = 0; i < FF_BLOCK; i++) target[i] = w[i] * slope[i];
        }
    }
    p->weight = old.target;
    p->weight_stride = 1;
    p->target = old.value;
    p->linearised = 1;
}

ff_status ff_problem_subsample(const struct ff_problem *p, const float *size, size_t wanted, int linear, struct ff_problem **out)
{
    struct ff_problem *t = malloc(sizeof *t);
    size_t *histogram = calloc(FF_BINS, sizeof *histogram);
    if (!t || !histogram) {
        free(t);
        free(histogram);
        return FF_ERR_MEMORY;
    }
    *t = *p;
    t->channel_name = NULL;
    t->index = NULL;
    t->cosine[0] = t->cosine[1] = NULL;
    t->multiplier = t->unit = t->factor = t->own_factor = NULL;
    t->subsample = t->subsample_linear = t->middle = t->sparse = NULL;
    for (size_t i = 0; i < p->n; i++) histogram[bin_of(size[i])]++;
    const size_t bin = p->n > wanted ? threshold_bin(histogram, wanted / 3) : 0;
    size_t large = 0;
    for (size_t b = bin; b < FF_BINS; b++) large += histogram[b];
    free(histogram);
    const size_t rest = p->n - large, stride = rest ? stride_for(rest, wanted - wanted / 3) : 1;
    const size_t kept = rest ? (rest + stride - 1) / stride : 0;
    t->n = large + kept;
    t->n_blocks = (t->n + FF_BLOCK - 1) / FF_BLOCK;
    t->data = ff_block_memory(ff_problem_doubles(t) * sizeof *t->data);
    subsampling work = {p, t, malloc(t->n * sizeof(uint32_t)), kept ? sqrt((double)rest / (double)kept) : 1, malloc(t->n)};
    const int failed = !t->data || !work.index || !work.rest;
    if (!failed) {
        memset(t->data, 0, ff_problem_doubles(t) * sizeof *t->data);
        for (size_t i = 0, k = 0, skipped = 0; i < p->n; i++) {
            const int is_rest = bin_of(size[i]) < bin;
            if (is_rest && skipped++ % stride != 0) continue;
            work.index[k] = (uint32_t)i;
            work.rest[k++] = (unsigned char)is_rest;
        }
        ff_pool_run(p->pool, p->n_planes, subsample_plane, &work);
        if (linear) linearise(t);
    }
    free(work.rest);
    if (failed) {
        free(work.index);
        free(t->data);
        free(t);
        return FF_ERR_MEMORY;
    }
    t->index = work.index;
    *out = t;
    return FF_OK;
}

void ff_problem_subsample_free(struct ff_problem *p)
{
    if (!p) return;
    free(p->data);
    free(p->index);
    free((float *)(uintptr_t)p->unit);
    free((float *)(uintptr_t)p->own_factor);
    free(p);
}

double ff_problem_stands_for(const struct ff_problem *p, const struct ff_problem *whole, size_t i)
{
    if (p->n == whole->n) return 1;
    const size_t at = p->index[i];
    const double here = ff_problem_plane(p, i / FF_BLOCK, p->sample_weight)[i % FF_BLOCK],
                 there = ff_problem_plane(whole, at / FF_BLOCK, whole->sample_weight)[at % FF_BLOCK];
    return there > 0 && here > 0 ? (here / there) * (here / there) : 1;
}
