/** @file ff_profile_file.h  Files of a tabulated distribution (ff_profile.h): columns of text.
 *
 *      # comments, anywhere
 *      theta_deg,D                 or    q2,p
 *      0,12.73                           0,0.3183
 *      0.5,12.69                         0.01,0.3120
 *
 *  - theta_deg is the angle of the normal in degrees, 0 to 90, D in 1/sr; q2 the square of the slope and p its density. The scale
 * of the values does not matter. Numbers are written as in the CSV of samples.
 *  - After theta_deg,D there may be d_relative_std_error,known, which `facetfit ndf` writes and this reader passes over: the
 * standard error of D over D, and 1 where it is at most FF_NDF_KNOWN.
 *  - Errors say the path, the line, what was found and what was expected; nothing is left behind.
 *  - There is no global state. */
#ifndef FF_PROFILE_FILE_H
#define FF_PROFILE_FILE_H
#include "ff_api.h"
#include "ff_profile.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Reads a file ("-": standard input) and makes its table. *out is written only on FF_OK; release it with ff_profile_free.
 *  FF_ERR_OPEN, FF_ERR_READ, FF_ERR_MEMORY; FF_ERR_FORMAT for another header or count of cells; FF_ERR_DATA for a cell that is no
 *  number and for what ff_profile_new refuses, with its line. */
FF_API ff_status ff_profile_read(const char *path, ff_profile_table **out, ff_error *err);

/** Writes n points, x [n] (theta_m in radians, or q2) and y [n], after `comment` (lines without '#', NULL = none).
 *  FF_ERR_RANGE for a kind that is none; FF_ERR_DATA for a number that is not finite, or an x below 0 or an angle beyond pi/2;
 *  FF_ERR_WRITE. "-" is standard output. */
FF_API ff_status ff_profile_write(const char *path, ff_profile_kind kind, size_t n, const double *x, const double *y,
                                  const char *comment, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
