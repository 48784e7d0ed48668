/* Tables made of others in memory of the caller's. */
#ifndef FF_RESAMPLE_STRUCT_H
#define FF_RESAMPLE_STRUCT_H
#include "data_formats/table/table_struct.h"
#include "ff_resample.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_resample into a table of the caller's, which is overwritten, not freed; untouched on failure. */
ff_status ff_resample_into(const ff_table *t, const ff_format *to, const ff_resample_options *o, ff_table *out,
                           ff_resample_report *report, ff_error *err);

/* A copy of the table, `kept` included. FF_ERR_MEMORY. */
ff_status ff_table_copy_into(const ff_table *t, ff_table *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
