/* Reductions into tables of the caller's. */
#ifndef FF_SPECTRAL_STRUCT_H
#define FF_SPECTRAL_STRUCT_H
#include "data_formats/table/table_struct.h"
#include "ff_spectral.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_table_reduce into a table of the caller's, which is overwritten, not freed; untouched on failure. */
ff_status ff_table_reduce_into(const ff_table *t, const char *text, ff_table *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
