/* The samples of a problem as blocks of planes, and a pass over them. */
#ifndef FF_INTERNAL_PASS_H
#define FF_INTERNAL_PASS_H
#include "base/internal_pool.h"
#include "fit/interface/fit_struct.h"
#include "fit/linalg/internal_linalg.h"
#include "models/tools/internal_averaging.h"
#include <math.h>

/* ---- samples --------------------------------------------------------------------------------- */

enum { FF_CHUNK = 32 }; /* blocks that are summed before their sums are merged, in their order: the sums do not know of threads */

/* One sample per lane. A chunk keeps each plane in one piece, so that the processor sees a few long streams and fetches ahead of
 * them; the pieces start a little more than a whole page apart, or they would contend for the same lines of the first-level cache.
 * Lanes beyond n hold some pair of directions with weight 0. */
enum { FF_PLANE_STRIDE = FF_CHUNK * FF_BLOCK + FF_BLOCK + 8 };
struct ff_problem {
    size_t n, n_blocks, n_planes, n_channels;
    double *data;
    /* Position of each plane inside a block, -1 = absent. */
    int geometry[FF_G_COUNT];
    int weight;        /* square root of the loss's weight, everything that multiplies g(f) - g(y)        */
    int weight_stride; /* 0: one plane for all channels; 1: plane weight + c                              */
    int target;        /* plane target + c: g(y); for linear losses y                                     */
    int value;         /* plane value + c: y                                                              */
    int sample_weight; /* square root of the sample's weight alone                                        */
    int direction;     /* first of the six planes of directions, incident ones first; -1 = absent: samples are points       */
    int side;          /* plane side + c, -1 = absent: +1 where the datum is only known to be at or above the target, -1 at or
                          below, else 0 */
    ff_loss loss;
    int linearised;          /* 1: a linear surrogate for the loss, for the search of a start                     */
    double tan2_lo, tan2_hi; /* range of tan^2 theta over the samples' directions                       */
    ff_selection selection;
    double spacing; /* of exits near the mirror direction, radians; NaN: not known                            */
    char (*channel_name)[FF_CHANNEL_NAME];
    size_t n_table_channels; /* of the table, of which this may have one: only_channel, -1 = all or their mean     */
    char (*table_channel)[FF_CHANNEL_NAME];
    int only_channel;
    double *channel_mean;    /* [n_channels] of |y| over the used samples */
    double *least;           /* [n_channels] what a datum counts as at least where a loss divides by it */
    uint32_t *index;         /* [n] place of each sample in the table, or in the problem that a smaller one stands for */
    float *cosine[2];        /* [n_blocks FF_BLOCK] of both directions, incident first; NULL in a smaller problem */
    const float *multiplier; /* [n_blocks FF_BLOCK] borrowed, NULL = 1: root of the weight of each sample when they are resampled */
    /* [n_channels][n_blocks FF_BLOCK], NULL = 1: standard deviation of each residual, which the scale of a robust loss multiplies.
     */
    const float *unit;
    /* [n_channels][n_blocks FF_BLOCK] borrowed, NULL = 1: what multiplies each residual and its derivatives, as where residuals are
     * counted in standard deviations of their own. */
    const float *factor, *own_factor; /* the latter belongs to the problem: of weights by the noise */
    const ff_rules *rules; /* of the aperture that the values are means over, NULL = points; smaller problems borrow them */
    ff_pool *pool;
    ff_isa isa;
    /* What starts are searched on, and what they are then refined on before all samples are: see ff_problem_subsample. The last is
     * NULL where there are too few samples to make it worth while. */
    struct ff_problem *subsample, *subsample_linear, *middle;
    struct ff_problem *sparse; /* what the noise of the data is estimated on; `subsample` where that has few samples itself */
};

static inline double *ff_problem_plane(const struct ff_problem *p, size_t block, int plane)
{
    return p->data + (block / FF_CHUNK * p->n_planes + (size_t)plane) * FF_PLANE_STRIDE + block % FF_CHUNK * FF_BLOCK;
}

/* From now on its residuals are (f - y) factor [n_channels][n_blocks FF_BLOCK], times the root of the weights of its samples. */
static inline void ff_problem_by_factor(struct ff_problem *p, const float *factor)
{
    p->loss = FF_LOSS_PLAIN;
    p->linearised = 0;
    p->weight = p->sample_weight;
    p->weight_stride = 0;
    p->target = p->value;
    p->unit = NULL;
    p->factor = factor;
}

/* Blocks whose sums a pass over the pool makes in one go: a chunk, or less where there are so many channels that a few chunks would
 * be all the work there is to share out. */
static inline size_t ff_problem_share(const struct ff_problem *p)
{
    const size_t share = 8 * FF_CHUNK / p->n_channels;
    return share > FF_CHUNK ? FF_CHUNK : share < 4 ? 4 : share;
}

/* Doubles that the planes of a problem take. */
static inline size_t ff_problem_doubles(const struct ff_problem *p)
{
    return (p->n_blocks + FF_CHUNK - 1) / FF_CHUNK * p->n_planes * FF_PLANE_STRIDE;
}

/* cos(theta_i) of a block from whichever of its planes has it. */
static inline void ff_problem_cosines(const ff_geometry *g, double *x)
{
    const double *t2 = g->plane[FF_G_TI2], *tx = g->plane[FF_G_TIX], *ty = g->plane[FF_G_TIY], *cosine = g->plane[FF_G_COS_I];
    for (int i = 0; i < FF_BLOCK; i++)
        x[i] = cosine ? cosine[i] : t2 ? 1 / sqrt(1 + t2[i]) : 1 / sqrt(1 + tx[i] * tx[i] + ty[i] * ty[i]);
}

/* ---- one pass -------------------------------------------------------------------------------- */

/* Columns of a channel with the residual; coordinates that all channels may share. */
enum { FF_MAX_COLUMNS = FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS + 1, FF_MAX_SHARED = FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS };

/* At which level each sample's mean is made, and for which lobes: an objective of which that is held is smooth. */
typedef struct ff_levels {
    ff_needles needles;
    unsigned char level[]; /* [n_blocks FF_BLOCK] */
} ff_levels;

/* What one pass evaluates. Columns of a channel: the free shape parameters, the channel's free ones, and the residual. */
typedef struct ff_pass {
    ff_prepared prepared;
    ff_averaging *averaging; /* NULL: samples are points */
    const ff_levels *levels; /* NULL: each block chooses its own */
    const struct ff_problem *p;
    ff_robust robust;
    double robust_scale;
    /* [n_channels][n_blocks FF_BLOCK] borrowed, NULL: standard deviations of the data, 1/sr. The residuals are then 1, and the
     * derivatives those of the score in its standard deviations: the sums are those of the score's covariance. */
    const float *deviation;
    int final;  /* 1: also the residual statistics                                    */
    int errors; /* 1: and what standard errors need: outer products and sums of the score */
} ff_pass;

/* Sums of the residual statistics, over samples and channels, by sample weight. */
enum { FF_STAT_WEIGHT = 0, FF_STAT_PLAIN, FF_STAT_MAX, FF_STAT_LOSS /* + loss */, FF_STAT_COUNT = FF_STAT_LOSS + FF_LOSS_COUNT };

/* Samples of a run: residuals of neighbours go together, and sums over runs show how much. Many samples have long ones, so that
 * what is done with the sums stays short beside a pass. */
enum { FF_SHORT_RUN = 8, FF_LONG_RUN = FF_BLOCK, FF_LONG_RUNS_FROM = 100000 };
static inline size_t ff_run_length(const struct ff_problem *p)
{
    return p->n >= FF_LONG_RUNS_FROM ? FF_LONG_RUN : FF_SHORT_RUN;
}

/* What a pass leaves. m1 = columns of a channel and the residual, P = columns of the layout, tied ones apart (until
 * ff_normal_fold). */
typedef struct ff_normal {
    size_t m1, P, n_channels;
    double cost2;           /* sum of rho(r^2): twice the objective                                    */
    double *gram;           /* [n_channels][m1 (m1+1) / 2], lower triangle by rows: J^T J, J^T r, r^T r */
    double *score_products; /* [P (P+1) / 2]: sum over samples of score score^T; only of a final pass. Of an arrowhead [P]: its
                               diagonal */
    int diagonal;           /* 1: score_products is [P], its diagonal alone: of an arrowhead, whose score is scaled */
    double *own;            /* [P]: sum over samples and channels of the squared score of one value     */
    size_t n_runs;
    double *runs; /* [n_runs][P]: sums of the score over runs of consecutive samples; NULL unless of a final pass */
    double stat[FF_STAT_COUNT];
} ff_normal;

/* Room for a pass of n_shape + n_channels n_channel columns. diagonal: 1: the products of the scores by their diagonal alone.
 * FF_ERR_MEMORY. */
ff_status ff_normal_new(size_t n_shape, size_t n_channel, size_t n_channels, int diagonal, ff_normal *out);
void ff_normal_free(ff_normal *n);

/* Runs the pass. parallel = 0: on the calling thread alone, for callers that are themselves spread over the pool.
 * FF_ERR_MEMORY; FF_ERR_INTERNAL when a sum is not finite. */
ff_status ff_pass_run(const ff_pass *pass, int parallel, ff_normal *out);

/* What the kernel of a chunk works in, one for each thread: too much for a stack. */
typedef struct __attribute__((aligned(64))) ff_pass_scratch {
    ff_average_work *average; /* NULL: samples are points */
    ff_block model;
    ff_block_slopes slopes;
    double f[FF_BLOCK], r[FF_BLOCK], j[FF_BLOCK], x[FF_BLOCK];
    double column[FF_MAX_COLUMNS][FF_BLOCK];
} ff_pass_scratch;

/* The kernel of one chunk of blocks: adds to the lane sums [8] each. acc: cost2 lanes, gram lanes, stat lanes, lanes of score
 * products; see pass.c. */
typedef struct ff_chunk_sums {
    double *cost2;          /* [8]                                   */
    double *gram;           /* [n_channels][m1 (m1+1)/2][8]          */
    double *stat;           /* [FF_STAT_COUNT][8]                    */
    double *score_products; /* [P (P+1)/2][8]                        */
    double *own;            /* [P][8]                                */
    double *score;          /* scratch [P][FF_BLOCK], with errors     */
    double *runs;           /* [n_runs][P] of the whole problem, with errors */
    ff_pass_scratch *work;
} ff_chunk_sums;
typedef void (*ff_pass_chunk_fn)(const ff_pass *pass, size_t first_block, size_t n_blocks, const ff_chunk_sums *sums);
ff_pass_chunk_fn ff_pass_chunk_get(ff_isa isa);
#endif
