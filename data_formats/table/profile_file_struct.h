/* Profiles from files in memory of the caller's. */
#ifndef FF_PROFILE_FILE_STRUCT_H
#define FF_PROFILE_FILE_STRUCT_H
#include "ff_profile_file.h"
#include "models/tools/profile_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

struct ff_outputs; /* base/internal_output.h */

/* ff_profile_read into a lattice of the caller's. */
ff_status ff_profile_read_into(const char *path, ff_profile_table *out, ff_error *err);

/* ff_profile_write with two more columns, error and known [n], or NULL: how well each point is known; as one of `with`, or NULL:
 * alone. */
ff_status ff_profile_write_noted(const char *path, ff_profile_kind kind, size_t n, const double *x, const double *y,
                                 const double *error, const unsigned char *known, const char *comment, struct ff_outputs *with,
                                 ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
