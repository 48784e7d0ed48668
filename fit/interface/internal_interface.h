/* Options of a fit as they were given. */
#ifndef FF_INTERNAL_INTERFACE_H
#define FF_INTERNAL_INTERFACE_H
#include "fit_struct.h"

/* FF_ERR_RANGE for an option that names nothing or lies outside its range, whatever the data. */
ff_status ff_fit_options_check(const ff_fit_options *o, ff_error *err);

/* Has the caller asked to stop? */
int ff_fit_cancelled(const ff_fit_options *o);

#endif
