/* Profiles in memory of the caller's. */
#ifndef FF_PROFILE_STRUCT_H
#define FF_PROFILE_STRUCT_H
#include "ff_profile.h"
#include "models/terms/profile_table_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_profile_new into a lattice of the caller's. */
ff_status ff_profile_make(ff_profile_kind kind, size_t n, const double *x, const double *y, ff_profile_table *out, size_t *bad,
                          ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
