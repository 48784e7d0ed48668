/* The only door to the Ceres Solver: a compressed least-squares problem of n parameters and n + 1 residuals. */
#ifndef FF_CERES_BRIDGE_H
#define FF_CERES_BRIDGE_H
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

/** A least-squares problem min 1/2 |residual(x)|^2 with lower <= x <= upper, in compressed form: residual = [Q^T r; rest], Jacobian
 * [R; 0]. */
typedef struct ff_ceres_problem {
    size_t n;            /**< parameters, >= 1                                              */
    const double *lower; /**< [n], -INFINITY where there is no bound                        */
    const double *upper; /**< [n]                                                           */
    /** At x [n]: residual [n+1] and, unless NULL, jacobian [(n+1)][n] by rows. Not FF_OK: the point is refused. */
    ff_status (*evaluate)(void *context, const double *x, double *residual, double *jacobian);
    /** After each iteration: 0 goes on, > 0 ends the solve as converged, < 0 as stopped. May be NULL. */
    int (*iterated)(void *context, int iteration, double cost);
    void *context;
    int max_iterations;
    double function_tolerance, gradient_tolerance, parameter_tolerance;
} ff_ceres_problem;

/** How the solver ended. */
typedef enum ff_ceres_end { FF_CERES_CONVERGED = 0, FF_CERES_LIMIT = 1, FF_CERES_FAILED = 2, FF_CERES_STOPPED = 3 } ff_ceres_end;

typedef struct ff_ceres_summary {
    ff_ceres_end end;
    int iterations;
    double cost; /**< 1/2 |residual|^2 at the returned x */
} ff_ceres_summary;

/** The version of Ceres, with the libraries that it was built with. Static storage. */
const char *ff_ceres_version(void);

/** Minimises from x [n] (in, out). Arguments that Ceres would abort on are refused with FF_ERR_RANGE; no exception passes. */
ff_status ff_ceres_solve(const ff_ceres_problem *p, double *x, ff_ceres_summary *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
