/* What is said of an optimum: shared by the files of this folder. */
#ifndef FF_INTERNAL_RESULT_H
#define FF_INTERNAL_RESULT_H
#include "fit/errors/internal_errors.h"

/* Up to this many channels, each has warnings of its own; beyond, one names all channels with the same trouble. */

/* Standard errors, correlations, intervals, condition, from the information of the point. FF_ERR_MEMORY. */
ff_status ff_result_errors(const ff_plan *plan, ff_point *at, ff_fit_result *r);

/* Correlations of the parameters with a standard error anew, from info. */
void ff_result_correlations(const ff_plan *plan, const ff_information *info, ff_fit_result *r);

/* Marks the parameters that have nothing to act on, at a point that has the sums of a pass; and takes back what was said of their
 * errors, and of everything where all data are 0. FF_ERR_MEMORY. */
ff_status ff_result_weightless(const ff_plan *plan, const ff_point *at, ff_fit_result *r);
void ff_result_forget_weightless(const ff_plan *plan, ff_fit_result *r);

/* Are all data 0? */
int ff_problem_is_dark(const struct ff_problem *p);

/* The warnings of a result that has everything else; info: NULL where no errors were asked for. FF_ERR_MEMORY. */
ff_status ff_result_warnings(const ff_plan *plan, const ff_information *info, ff_fit_result *r);

/* Room for what is said of a fit by this plan. FF_ERR_MEMORY. */
ff_status ff_result_new(const ff_plan *plan, ff_fit_result *out);

/* The last stage: everything that is said of an optimum whose sums the point has. errors: 1: its errors too. FF_ERR_MEMORY. */
ff_status ff_result_fill(const ff_plan *plan, ff_point *at, int errors, ff_fit_result *r);
/* Of lobes that detectors or the steps between samples broaden. FF_ERR_MEMORY. */
ff_status ff_result_warn_of_narrow_lobes(const struct ff_problem *p, ff_fit_result *r);
#endif
