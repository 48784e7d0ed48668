/** @file ff_interpolate.h  Values of a table between its samples, with word of how each was found.
 *
 *  Method   Where a table's values are means over cells (Klems' patches, tensor trees), the value of the cell, constant up to its
 * border. Where a table is the product of axes in which the mirror direction stands still (half and difference angles, the MERL
 * grid, polar angles about the specular direction): linear along each axis between the neighbouring nodes, periodic azimuths
 *           joined, samples that were not measured left out and the others' weights raised to make up for them.
 *           Where samples come in slices of one incident direction each (goniometers): in every slice, local regression of second
 *           degree over the half vector (theta_h cos phi_h, theta_h sin phi_h), which keeps the mirror direction in place; between
 *           slices linear in theta_i and, where the table is not isotropic, phi_i (or by inverse distance between the nearest in
 * each quadrant around the incident direction, where incident directions do not come in rings of one theta_i). Everywhere else:
 * local linear regression in the coordinates isotropic   (s theta_h cos phi_d, -s theta_h sin phi_d, theta_d) otherwise   (s
 * theta_h cos phi_h, s theta_h sin phi_h, theta_d cos(phi_d + phi_h), theta_d sin(phi_d + phi_h)) of Rusinkiewicz' angles in
 * degrees, with s = FF_INTERPOLATE_HALF_SCALE since reflectance changes faster with the half vector. Regressions:
 * FF_INTERPOLATE_NEIGHBOURS nearest samples (k-d tree), tricube weights, logarithms where all of them are positive, the result kept
 * within the range of their values. No reciprocity is assumed. An isotropic table with samples on one side of the plane of
 * incidence only is mirrored at it; no other mirror symmetry is assumed. Where all samples lie in the plane of incidence (to half a
 * degree of the half vector), what is beside it is beyond the data, and its value that of half vectors which lean as far within it.
 * Errors   ff_status and ff_error; outputs are written only on FF_OK. Threads  an interpolant is immutable; any number of threads
 * may evaluate it. The table must outlive it. */
#ifndef FF_INTERPOLATE_H
#define FF_INTERPOLATE_H
#include "ff_api.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_INTERPOLATE_NEIGHBOURS = 14, FF_INTERPOLATE_HALF_SCALE = 3 };

/** How a value was found. */
typedef enum ff_found {
    FF_FOUND_SAMPLE = 0,     /**< the pair of directions is a sample (to 1e-6 degrees): its value, the mean of several    */
    FF_FOUND_BETWEEN = 1,    /**< interpolated                                                                            */
    FF_FOUND_RECIPROCAL = 2, /**< beyond the data, but light and detector exchanged it is not: that value                 */
    FF_FOUND_BEYOND = 3,     /**< outside of the data: the value of the nearest ones, a guess whose error is not known    */
    FF_FOUND_BELOW = 4       /**< a direction at or below the horizon: 0                                                  */
} ff_found;

typedef struct ff_interpolant ff_interpolant;

/** @param scattered  1: regression (slices or scattered) whatever the structure of the table
 *  FF_ERR_DATA when no valid sample lies above the horizon, FF_ERR_MEMORY. *out is released with ff_interpolant_free. */
FF_API ff_status ff_interpolant_new(const ff_table *t, int scattered, ff_interpolant **out, ff_error *err);
FF_API void ff_interpolant_free(ff_interpolant *p);

/** Values of all channels for n pairs of directions.
 *  @param w      six planes [n] wix wiy wiz wox woy woz, unit vectors
 *  @param value  [n_channels][n] out, 1/sr
 *  @param found  [n] out, ff_found; may be NULL */
FF_API void ff_interpolant_eval(const ff_interpolant *p, const double *const w[6], size_t n, double *value, unsigned char *found);

/** The same, with light and detector exchanged where the pair as given is beyond the data (FF_FOUND_RECIPROCAL). */
FF_API void ff_interpolant_eval_reciprocal(const ff_interpolant *p, const double *const w[6], size_t n, double *value,
                                           unsigned char *found);

/** The method in words: static storage. */
FF_API const char *ff_interpolant_method(const ff_interpolant *p);

/** 1 where values come from regression over neighbours, 0 where they are interpolated along axes. */
FF_API int ff_interpolant_regresses(const ff_interpolant *p);

/** 1 where all samples lie in the plane of incidence: what is beside it is extrapolated. 0 of products of axes and of cells. */
FF_API int ff_interpolant_is_in_plane(const ff_interpolant *p);

/** What the other samples say of sample i, by regression: value [n_channels]; an ff_found. Of a product of axes, the sample itself.
 */
FF_API ff_found ff_interpolant_without(const ff_interpolant *p, size_t i, double *value);

/** What the incidences on both sides say of sample i, its own left out: FF_FOUND_BETWEEN, or FF_FOUND_BEYOND where there are none
 * on one side, and where the samples do not come in slices or the table is not isotropic. */
FF_API ff_found ff_interpolant_without_incidence(const ff_interpolant *p, size_t i, double *value);

/** Up to `most` incident directions (degrees) at which exits can be interpolated: those of the slices, spread over theta_i, each
 *  theta_i once; without slices, round ones within the data. Their number. */
FF_API size_t ff_interpolant_incidences(const ff_interpolant *p, size_t most, double *theta_i, double *phi_i);

/** 1 when a slice of that incident direction (unit vector; to `within` degrees, of theta_i alone where the table is isotropic)
 * exists. */
FF_API int ff_interpolant_is_incidence(const ff_interpolant *p, const double wi[3], double within);

#ifdef __cplusplus
}
#endif
#endif
