/* What the two ways of minimising share: solve.c moves all coordinates, project.c those of the shape with the channels following.
 */
#ifndef FF_INTERNAL_SOLVE_H
#define FF_INTERNAL_SOLVE_H
#include "ceres_bridge.h"
#include "internal_fit.h"

/* The compressed problem of the coordinates index [n] out of P: residual [Q^T r; rest] and Jacobian [R; 0], R = (D L)^T of
 * J^T J = D L L^T D, from H = J^T J [P][P], g = J^T r [P] and cost2 = |r|^2. work [2 n n + n]; jacobian may be NULL. Returns
 * |Q^T r|^2, what a Gauss-Newton step would gain. */
double ff_compress(const double *H, const double *g, size_t P, const size_t *index, size_t n, double cost2, double *work,
                   double *residual, double *jacobian);

ff_outcome ff_solve_outcome(ff_ceres_end end);

/* Bounds of all coordinates, [P] each. */
void ff_solve_bounds(const ff_layout *l, double *lower, double *upper);

/* -1, +1 where coordinate k of x [P] sits on its bound, else 0; n: what a pass at x has left. */
int ff_solve_bound_of(const ff_layout *l, const ff_normal *n, const double *x, double lower, double upper, size_t k);

/* As ff_solve, for layouts whose H is kept as an arrow: see project.c. */
ff_status ff_solve_projected(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, int parallel, int keep,
                             double tolerance, int max_iterations, double *shape, double *channel, int *at_bound, ff_solution *out,
                             ff_error *err);
#endif
