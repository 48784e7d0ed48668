/* Making the list of a result's warnings. */
#ifndef FF_INTERNAL_WARNING_H
#define FF_INTERNAL_WARNING_H
#include "ff_status.h"
#include "warning_struct.h"

/* Appends a copy of w, its parameters and channels included, with the severity of its code. FF_ERR_MEMORY: the list is as it was.
 */
ff_status ff_warnings_add(ff_warnings *list, const ff_warning *w);

/* One without parameters or channels; value [those the code has], NULL when it has none. */
ff_status ff_warnings_say(ff_warnings *list, ff_warning_code code, const double *value);

/* Releases the list and zeroes it. */
void ff_warnings_clear(ff_warnings *list);

#endif
