/* Values at the directions of a table that come from simulated paths of light and not from a formula. */
#ifndef FF_INTERNAL_SIMULATED_H
#define FF_INTERNAL_SIMULATED_H
#include "simulate_struct.h"

typedef struct ff_simulated {
    size_t n_planes;
    double *f,
        *error; /* [n_planes][t->n] in 1/sr, 0 where a direction is below the horizon; one allocation, f the caller's to free */
} ff_simulated;

/* The groups of orders that o asks for; NULL and *n = 1 where values are those of the model. */
const ff_orders *ff_simulated_orders(const ff_simulate_options *o, size_t *n);

/* Values of a walk or of a surface, where o asks for one; else *out stays as it is. Errors as ff_walk_new and ff_walk_values, and
 * those of a surface. */
ff_status ff_simulated_values(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                              const ff_simulate_options *o, const ff_table *t, ff_simulated *out, ff_error *err);
#endif
