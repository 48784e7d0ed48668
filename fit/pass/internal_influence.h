/* The pass over influences: information/arrowhead.c has the formulas of an arrowhead. */
#ifndef FF_INTERNAL_INFLUENCE_H
#define FF_INTERNAL_INFLUENCE_H
#include "internal_pass.h"

/* Runs of neighbouring samples whose errors go together. */
typedef struct ff_clusters {
    size_t run;  /* samples of a cluster; 1: they are independent, as far as can be seen            */
    size_t n;    /* clusters                                                                        */
    int settled; /* 0: the errors reach further than the longest runs of which there are enough     */
} ff_clusters;

/* What a pass needs of an information that is kept as an arrowhead, scaled so that the diagonal of H is 1. P = S + C K parameters.
 */
typedef struct ff_arrowhead {
    size_t S, K, C, P;                       /* parameters that all channels share, the shape; of a channel; channels; all */
    const double *scale;                     /* [P] 1 / the root of H's diagonal                                        */
    double *inverse;                         /* [S][S] T^-1; 0 where a parameter is not in use                          */
    double *own;                             /* [C][K][K] D_c^-1                                                        */
    double *follow;                          /* [C][K][S] K_c                                                           */
    size_t n_columns, place[FF_MAX_COLUMNS]; /* of a channel's columns: the parameter of the shape, or S + that of the channel */
} ff_arrowhead;

/* Influence H^-1 s of the score s [P], both scaled. */
void ff_arrowhead_apply(const ff_arrowhead *a, const double *score, double *influence);

/* What the kernel of a chunk works in, one for each thread. */
typedef struct __attribute__((aligned(64))) ff_influence_scratch {
    ff_average_work *average; /* NULL: samples are points */
    ff_block model;
    ff_block_slopes slopes;
    double f[FF_BLOCK], r[FF_BLOCK], j[FF_BLOCK], x[FF_BLOCK];
    double column[FF_MAX_COLUMNS][FF_BLOCK], local[FF_MAX_COLUMNS][FF_BLOCK];
    double on_shape[FF_MAX_SHARED][FF_BLOCK], on_channel[FF_MAX_CHANNEL_PARAMS][FF_BLOCK];
} ff_influence_scratch;

/* Lane sums [8] of a chunk: statistics, then products of the scaled influences by their packed triangle: of the shape, and for
 * each channel [K][S] with the shape's and a triangle of its own. */
typedef struct ff_influence_sums {
    double *stat;    /* [FF_STAT_COUNT][8]             */
    double *shape;   /* [S (S+1)/2][8]                 */
    double *channel; /* [C][K S + K (K+1)/2][8]        */
    double *own;     /* [P][8] squares of the scores of single values */
    double *whole;   /* [S][8] and of the shape's scores of samples   */
    double *runs;    /* [n_runs][P] of all blocks: sums of the scores */
    double *score;   /* scratch [S + C K][FF_BLOCK]    */
    ff_influence_scratch *work;
} ff_influence_sums;

static inline size_t ff_influence_channel(const ff_arrowhead *a)
{
    return a->K * a->S + a->K * (a->K + 1) / 2;
}

/* arrowhead NULL: the statistics alone. */
typedef void (*ff_influence_chunk_fn)(const ff_pass *pass, const ff_arrowhead *arrowhead, size_t first_block, size_t n_blocks,
                                      const ff_influence_sums *sums);
#endif
