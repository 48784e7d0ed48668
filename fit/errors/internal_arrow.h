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
#include "fit/pass/internal_influence.h"
#include "internal_errors.h"

/* 95 % intervals, rank and condition of a fit that has its standard errors, as ff_intervals_fill and ff_condition_fill. On a bound
 * the errors are those of runs at least. FF_ERR_MEMORY. */
ff_status ff_arrow_intervals(const ff_plan *plan, const ff_point *at, ff_fit_result *r);
ff_status ff_arrow_condition(const ff_plan *plan, const ff_point *at, ff_fit_result *r);

/* What is left to do at an optimum: at->normal holds the sums of the plain pass there, or is empty, and is made then. Makes
 * at->arrow, its covariances like ff_uncertainty_new, the sums of the score that these need, and the statistics of the normal.
 * Where no errors are wanted only the statistics. */
ff_status ff_arrow_finish(const ff_plan *plan, ff_point *at);
#endif
