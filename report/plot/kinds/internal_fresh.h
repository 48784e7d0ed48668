/* What the kinds share that compute anew from a fit of this run: which of its parameters. */
#ifndef FF_INTERNAL_FRESH_H
#define FF_INTERNAL_FRESH_H
#include "internal_curves.h"

/* A free number of a fit. */
typedef struct ff_plot_number {
    ff_param_ref ref;
    size_t channel;
    char name[FF_PARAM_NAME + FF_CHANNEL_NAME + 4]; /* "f0[r]" */
    const char *unit;
    const ff_fit_value *value;
} ff_plot_number;

/* Those that the choice names, or the shared ones and those of the chosen channels (the middle one): `most` at most; how many.
 * FF_ERR_UNKNOWN with the names, FF_ERR_DATA where nothing is free. */
ff_status ff_plot_numbers(const ff_plot_subject *s, const ff_plot_choice *c, size_t most, ff_plot_number *out, size_t *n,
                          ff_error *err);

#endif
