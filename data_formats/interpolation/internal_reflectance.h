/** @file internal_reflectance.h  Reflectance of a table at an incidence: the integral of f cos(theta_o) over the hemisphere.
 *
 *  By the table's own quadrature where it has one: exact sums over cells (ff_table.cells), and over the samples of a file whose
 *  weights are those of its function (kept_incidence). Elsewhere the midpoint rule over the interpolated values, over what the data
 *  cover: extrapolated values are not counted. */
#ifndef FF_INTERNAL_REFLECTANCE_H
#define FF_INTERNAL_REFLECTANCE_H
#include "data_formats/table/table_struct.h"
#include "ff_interpolate.h"

/** Less than this part of the projected hemisphere covered is no reflectance. */
static const double ff_reflectance_least_covered = 0.01;

/** One polar angle of incidence. */
typedef struct ff_reflected {
    double theta_i, phi_i; /**< degrees; phi_i NaN: mean over several azimuths */
    size_t azimuths;       /**< of incidence that the mean is over            */
    double covered;        /**< part of the projected hemisphere, 0..1        */
    double range[2];       /**< of the channel mean over the azimuths         */
} ff_reflected;

/** Up to `most` polar angles to ask for, with an azimuth each; their number. p may be of fewer samples than t, which then counts
 *  for the table's own quadrature. */
size_t ff_reflectance_incidences(const ff_table *t, const ff_interpolant *p, size_t most, double *theta_i, double *phi_i);

/** Fills r for theta_i at all azimuths of the table's own quadrature, or at phi_i alone where it has none.
 *  @param albedo   [n_channels] out: NaN where the data cover less than ff_reflectance_least_covered
 *  @param raised   [n_channels] out: the same of values whose negative ones count as 0
 *  FF_ERR_MEMORY. */
ff_status ff_reflectance_find(const ff_table *t, const ff_interpolant *p, double theta_i, double phi_i, ff_reflected *r,
                              double *albedo, double *raised, ff_error *err);

/** 1 where ff_reflectance_find is the table's own quadrature. */
int ff_reflectance_is_own(const ff_table *t);

/** Channel mean of the reflectance at one incidence (degrees). within: only where that has values, as far as the table has no
 *  quadrature of its own there; NULL: everywhere. FF_ERR_MEMORY. */
ff_status ff_reflectance_mean(const ff_table *t, const ff_interpolant *p, const ff_interpolant *within, double theta_i,
                              double phi_i, double *out, ff_error *err);

/** Up to `most` azimuths of the table's own quadrature at a polar angle, spread over all, degrees; their number. */
size_t ff_reflectance_azimuths(const ff_table *t, double theta_i, size_t most, double *phi_i);

/** What a table made of t by interpolation has of its reflectance. */
typedef struct ff_energy {
    size_t incidences;     /**< compared                                                              */
    size_t missed;         /**< of which made has nothing: not among these                            */
    double lost, most, at; /**< 1 - made / t: of all, where it is furthest from 0, and that theta_i   */
} ff_energy;

/** Compares channel means at a few incidences, over what t covers. p: interpolant of t. FF_ERR_MEMORY. */
ff_status ff_energy_compare(const ff_table *t, const ff_interpolant *p, const ff_table *made, ff_energy *out, ff_error *err);
#endif
