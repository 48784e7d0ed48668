/* Errors of a fit: by the noise of the data, or by the residuals themselves; intervals; what can be told apart. */
#ifndef FF_INTERNAL_ERRORS_H
#define FF_INTERNAL_ERRORS_H
#include "fit/noise/internal_noise.h"

/* The stage between minimisation and result: what errors and statistics of a point need, unless the minimisation has left it.
 * FF_ERR_MEMORY, FF_ERR_CANCELLED; FF_ERR_INTERNAL where a sum is not finite. */
ff_status ff_errors(const ff_plan *plan, ff_point *at);

/* Covariance of all parameters, those on a bound too, as ff_errors has it of those that are not; of an arrowhead by another pass.
 * FF_ERR_MEMORY, FF_ERR_CANCELLED. */
ff_status ff_errors_of_all(const ff_plan *plan, ff_point *at, ff_information **out);

/* ---- intervals -------------------------------------------------------------------------------- */

/* 95 % intervals of all parameters: by their standard errors, which r has, or one-sided on a bound. FF_ERR_MEMORY. */
ff_status ff_intervals_fill(const ff_plan *plan, ff_point *at, ff_fit_result *r);
/* Interval of v->value +- half_width, symmetric in the coordinate. */
void ff_interval_around(const ff_param *info, double half_width, ff_interval kind, ff_fit_value *v);
/* From the bound of v inside to where slope d + d^2 / (2 inverse) has risen by allowed; no curvature: to the other bound. Returns
 * whether it is the curvature that ends it, not the slope: the data do not press the parameter against its bound. */
int ff_interval_from_bound(const ff_param *info, double slope, double inverse, double allowed, ff_fit_value *v);

/* Those of the parameters on a bound, with a warning of what they cannot be told from. FF_ERR_MEMORY, FF_ERR_CANCELLED. */
ff_status ff_intervals_one_sided(const ff_plan *plan, ff_point *at, ff_fit_result *r);

/* Parameters that go together by this much can hardly be told apart. */
#define FF_CORRELATED 0.99

enum { FF_CHANNELS_NAMED = 8 }; /* of more, what is said is said of all together */

/* Rank and condition of a result; warns of several parameters that trade off. FF_ERR_MEMORY. */
ff_status ff_condition_fill(const ff_plan *plan, const ff_point *at, ff_fit_result *r);
#endif
