/* Profiles from files in memory of the caller's. */
#ifndef FF_PROFILE_FILE_STRUCT_H
#define FF_PROFILE_FILE_STRUCT_H
#include "ff_profile_file.h"
#include "models/tools/profile_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ff_profile_read into a lattice of the caller's. */
ff_status ff_profile_read_into(const char *path, ff_profile_table *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
