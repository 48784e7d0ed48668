/* From a start to the optimum. solve.c moves all coordinates, project.c those of the shape with the channels following, settle.c
 * those of dark channels, wake.c those without effect on their bound; way.c chooses; minimise.c does what a fit needs of them.
 */
#ifndef FF_INTERNAL_MINIMISE_H
#define FF_INTERNAL_MINIMISE_H
#include "ceres_bridge.h"
#include "fit/problem/internal_problem.h"

/* How far and by what means a minimisation goes. */
typedef struct ff_effort {
    int parallel;     /* 0: on the calling thread alone                                         */
    int speculate;    /* 1: passes that look like being the last are made final ones            */
    double tolerance; /* ends when a step would lower the objective by less than this of itself */
    int max_iterations;
} ff_effort;

/* Minimises the plan's objective from the point, whose sums are forgotten. Iterations and passes add to those of the point. */
ff_status ff_solve(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err);

/* On all samples as far as a fit goes, lobes in their order. */
ff_status ff_minimise(const ff_plan *plan, ff_point *at, ff_error *err);

/* ---- what the two ways share ------------------------------------------------------------------ */

/* As ff_solve, with all coordinates before the solver; and for layouts whose H is kept as an arrowhead. */
ff_status ff_solve_dense(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err);
ff_status ff_solve_projected(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err);

/* The compressed problem of the coordinates index [n] out of P: residual [Q^T r; rest] and Jacobian [R; 0], R = (D L)^T of
 * J^T J = D L L^T D, from H = J^T J [P][P], g = J^T r [P] and cost2 = |r|^2. work [2 n n + n]; jacobian may be NULL. Returns
 * |Q^T r|^2, what a Gauss-Newton step would gain. */
double ff_compress(const double *H, const double *g, size_t P, const size_t *index, size_t n, double cost2, double *work,
                   double *residual, double *jacobian);

/* -1, +1 where coordinate k of x [P] sits on its bound, else 0; g: what a pass at x has left. */
int ff_bound_of(const ff_layout *l, const ff_gram *g, const double *x, double lower, double upper, size_t k);

/* Has a channel, with the shape at rest, more to gain than this part of its own objective (once per channel)? g: what a pass at x
 * has left. */
int ff_channels_open(const ff_layout *l, const ff_gram *g, const double *x, const double *lower, const double *upper,
                     double tolerance);

/* Moves the channels that have, alone, until none has or one would rise. */
ff_status ff_settle_channels(const ff_plan *plan, double tolerance, ff_point *at, ff_error *err);

/* From an optimum at which a parameter lies on a bound without any effect there to the one inside, if there is one. */
ff_status ff_wake(const ff_plan *plan, const ff_effort *effort, ff_point *at, ff_error *err);

/* How a solve ended, from the words of the solver. */
ff_outcome ff_solve_outcome(ff_ceres_end end);

/* Why it came to no end, in words. Returns st. */
ff_status ff_solve_failed(ff_status status, ff_error *err);
#endif
