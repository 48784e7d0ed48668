/** @file ff_profile.h  A distribution of normals given by a table: what the distribution `tabulated` takes its profile from.
 *
 *  The table has D over the angle of the normal, or the profile p over q2 (p of ff_ndf: the slopes' density at alpha = 1, over
 *  q2 = slope^2). ff_profile_new turns it into a fixed lattice that the kernels read, scaled so that the projected area is 1:
 *
 *      ff_profile_table *t;
 *      s = ff_profile_new(FF_PROFILE_D, n, theta, D, &t, &bad, &err);
 *      ff_model_set_table(model, t);        // `model` has a lobe `tabulated`; t must outlive its use
 *      ...
 *      ff_profile_free(t);
 *
 *  - Between the points ln D, or ln p, is a monotone cubic of ln(1 + q2 / s), s the q2 at which the values have fallen to half; a
 *    straight line of that where the table begins above q2 = 0. On the lattice it is rendered to about 1e-4 of p where the cubics
 *    meet, and much closer elsewhere.
 *  - Beyond the last one D goes on as the power of 1 + q2 / s that it ends with, but does not rise; p as the power it ends with,
 *    which must be steeper than q2^-1.6, since slopes without a mean have no Smith masking. From q2 = 2^40 on p ~ q2^-2.
 *  - Values below 1e-30 of the largest count as that; at the end of the table only the first of them counts.
 *  - A table that is made is not changed any more and may be read from many threads. */
#ifndef FF_PROFILE_H
#define FF_PROFILE_H
#include "ff_api.h"

#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

/** A profile on the lattice. Closed; it does not change after it was made. */
typedef struct ff_profile_table ff_profile_table;

/** What the two columns are. */
typedef enum ff_profile_kind {
    FF_PROFILE_D = 0, /**< theta_m in radians, 0 .. pi/2; D in 1/sr, any scale     */
    FF_PROFILE_P = 1  /**< q2 >= 0; p, any scale                                   */
} ff_profile_kind;

enum { FF_PROFILE_POINTS_MIN = 4 };

/** Makes the lattice; release it with ff_profile_free.
 *  @param x    [n] theta_m or q2, strictly increasing
 *  @param y    [n] D or p, >= 0
 *  @param out  written only on FF_OK
 *  @param bad  index of the point that the error is about, n when it is about the whole; may be NULL
 *  FF_ERR_DATA  fewer than FF_PROFILE_POINTS_MIN points; one that is not finite, negative, out of range or not beyond that before;
 *               all values zero; a tail too heavy; a width outside 2^-34 .. 2^34 of q2
 *  FF_ERR_RANGE a kind that is none
 *  FF_ERR_MEMORY  for the lattice, 155 KiB, and for the quadrature of Lambda, which takes some 10 ms */
FF_API ff_status ff_profile_new(ff_profile_kind kind, size_t n, const double *x, const double *y, ff_profile_table **out,
                                size_t *bad, ff_error *err);
FF_API void ff_profile_free(ff_profile_table *t); /**< NULL is allowed */

#ifdef __cplusplus
}
#endif
#endif
