/* Directions of a simulated instrument as a table without values. */
#ifndef FF_INTERNAL_SAMPLING_H
#define FF_INTERNAL_SAMPLING_H
#include "simulate_struct.h"
/* *out is written only on FF_OK. `isotropic`: the surface has no direction of its own. */
ff_status ff_sampling_table(const ff_sampling *s, uint64_t seed, int isotropic, size_t n_channels, int sigma, ff_table *out,
                            ff_error *err);
#endif
