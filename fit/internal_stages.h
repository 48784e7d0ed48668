/* The stages of a fit that stand above all others: see fit.c. */
#ifndef FF_INTERNAL_STAGES_H
#define FF_INTERNAL_STAGES_H
#include "fit/problem/internal_problem.h"

/* From the optimum of the data alone, with its sums, to that with the plan's penalties, with its own. Without penalties nothing is
 * done. */
ff_status ff_penalised_solve(ff_plan *plan, ff_point *at, ff_error *err);

/* A fit of m to the samples as they are: what ff_problem_fit does once the scale of a robust loss is known. */
ff_status ff_fit_run(const struct ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err);

/* Standard deviation of the residual of value i of channel c, of the problem's own weights and loss, by a noise that is known,
 * where the model [n_channels][n] is that. */
double ff_residual_deviation(const struct ff_problem *p, const struct ff_noise *noise, const double *model, size_t c, size_t i);
#endif
