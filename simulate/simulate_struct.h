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

/* ff_simulate_into at the directions that a file of the format `to` has, in the words of its layout (NULL: the usual); with no
 * layout of its own those of o->sampling. The layout is made for the goniometer's directions. Of one channel a format may make
 * several alike. FF_ERR_UNSUPPORTED, FF_ERR_SYNTAX and FF_ERR_RANGE as the layout of the format, and as ff_simulate. */
ff_status ff_simulate_layout_into(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                                  const ff_format *to, const char *grid, const ff_simulate_options *o, ff_table *out,
                                  ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
