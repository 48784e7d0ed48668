/* What is said of an optimum: shared by the files of this folder. */
#ifndef FF_INTERNAL_RESULT_H
#define FF_INTERNAL_RESULT_H
#include "fit/errors/internal_arrow.h"

/* Up to this many channels, each has warnings of its own; beyond, one names all channels with the same trouble. */
enum { FF_CHANNELS_NAMED = 8 };

/* Standard errors, correlations and intervals of a layout that is an arrow. FF_ERR_MEMORY. */
ff_status ff_result_channel_errors(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *at_bound,
                                   const ff_arrow *a, ff_fit_result *r);

/* The warnings of a result that has everything else. FF_ERR_MEMORY. */
ff_status ff_result_warnings(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r);
#endif
