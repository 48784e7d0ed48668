/* Simulated data in tables of the caller's. */
#ifndef FF_SIMULATE_STRUCT_H
#define FF_SIMULATE_STRUCT_H
#include "data_formats/table/table_struct.h"
#include "ff_simulate.h"
#include "models/model_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_simulate into a table of the caller's, which is overwritten, not freed; untouched on failure. */
ff_status ff_simulate_into(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                           const ff_simulate_options *o, ff_table *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
