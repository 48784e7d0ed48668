/* The uncertainty of a fit with many channels. J^T J is an arrow,
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
#ifndef FF_INTERNAL_ARROW_H
#define FF_INTERNAL_ARROW_H
#include "fit/internal_fit.h"

/* X [n][m] = A^-1 B of a symmetric positive semidefinite A [n][n], n <= FF_MAX_SHAPE, and B [n][m]; 0 in what A does not say. */
void ff_solve_symmetric(const double *A, size_t n, const double *B, size_t m, double *X);

/* Everything of the parameters, not of coordinates. The first four are scaled: those of the H whose diagonal is 1, with the ridge
 * of ff_covariance; 0 where a parameter is not used. */
typedef struct ff_arrow {
    size_t S, K, C, P; /* parameters of the shape, of a channel, channels, all                    */
    double *scale;     /* [P] 1 / the root of H's diagonal                                        */
    double *inverse;   /* [S][S] T^-1                                                             */
    double *own;       /* [C][K][K] D_c^-1                                                        */
    double *follow;    /* [C][K][S] K_c                                                           */
    double *shape;     /* [S][S] covariances, once they are known; of the shape,                  */
    double *cross;     /* [C][K][S] of a channel with the shape,                                  */
    double *block;     /* [C][K][K] and within a channel                                          */
    int *determined;   /* [P] 0: not used, or the data say nothing                                */
    double *dof;       /* [P] degrees of freedom that the error of each is estimated from         */
    ff_clusters clusters;
    double effective; /* number of independent values                                             */
    size_t used;
    double of_channel; /* parameters in use that a channel has to do with: the shape's and its own, a mean over channels */
} ff_arrow;
void ff_arrow_free(ff_arrow *a);

/* Influence H^-1 s of the score s [P], both scaled. */
void ff_arrow_apply(const ff_arrow *a, const double *score, double *influence);

/* 95 % intervals, rank and condition of a fit that has its standard errors, as ff_intervals_fill and ff_condition_fill. On a bound
 * the errors are those of runs at least. FF_ERR_MEMORY. */
ff_status ff_arrow_intervals(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                             const ff_arrow *a, ff_fit_result *r);
ff_status ff_arrow_condition(const ff_normal *n, const ff_arrow *a, const int *use, ff_fit_result *r);

/* What is left to do at an optimum: solution->normal holds the sums of the plain pass there, or is empty, and is made then. Makes
 * solution->arrow, its covariances like ff_uncertainty_new, the sums of the score that these need, and the statistics of the
 * normal. Without o->std_errors only the statistics. */
ff_status ff_arrow_finish(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                          const double *channel, const int *at_bound, ff_solution *solution);

/* ---- the pass over influences ---------------------------------------------------------------- */

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
} ff_influence_sums;

static inline size_t ff_influence_channel(const ff_arrow *a)
{
    return a->K * a->S + a->K * (a->K + 1) / 2;
}

/* arrow NULL: the statistics alone. */
typedef void (*ff_influence_chunk_fn)(const ff_pass *pass, const ff_arrow *arrow, size_t first_block, size_t n_blocks,
                                      const ff_influence_sums *sums);
#endif
