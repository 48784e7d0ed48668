/* What is said of an optimum: shared by result.c, errors.c and result_channels.c. */
#ifndef FF_INTERNAL_RESULT_H
#define FF_INTERNAL_RESULT_H
#include "fit/errors/internal_errors.h"

/* Up to this many channels, a warning names each that it is about. */
enum { FF_CHANNELS_NAMED = 8 };

/* Of the channels that are marked (mark [n_channels], not all 0): "400, 410, 450", or where there are many, "31 of 121 channels,
 * 400 to 700". Returns out. */
const char *ff_channels_label(const struct ff_problem *p, const unsigned char *mark, char *out, size_t size);

/* Standard errors, correlations, intervals, condition, from the information of the point. FF_ERR_MEMORY. */
ff_status ff_result_errors(const ff_plan *plan, const ff_point *at, ff_fit_result *r);

/* Warnings of what the data do not determine or do not tell apart, for more channels than FF_CHANNELS_NAMED: one for all channels
 * with the same trouble. errors, correlations: which of them. */
void ff_result_warn_undetermined(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r);
void ff_result_warn_channels_correlated(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r);

/* Room for what is said of a fit by this plan. FF_ERR_MEMORY. */
ff_status ff_result_new(const ff_plan *plan, ff_fit_result *out);

/* The last stage: everything that is said of an optimum whose sums the point has. errors: 1: its errors too. FF_ERR_MEMORY. */
ff_status ff_result_fill(const ff_plan *plan, const ff_point *at, int errors, ff_fit_result *r);
#endif
