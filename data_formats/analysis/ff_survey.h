/** @file ff_survey.h  What the samples of a table say of themselves: coverage, symmetry, reflectance.
 *
 *  Everything is measured on the values; nothing is assumed of the surface. Deviations are medians of |ln(a / b)| over pairs of
 * values that symmetry would make equal, of the channel mean; b comes from interpolation (ff_interpolate.h), whose own error is
 * measured by leaving samples out and is given beside it: a deviation no larger says nothing against the symmetry. Errors ff_status
 * and ff_error; outputs are written only on FF_OK. Threads  no global state. */
#ifndef FF_SURVEY_H
#define FF_SURVEY_H
#include "ff_api.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

enum {
    FF_SURVEY_ROWS = 9,      /**< theta_i in bands of 10 degrees                              */
    FF_SURVEY_COLUMNS = 18,  /**< theta_o in bands of 5 degrees                               */
    FF_SURVEY_AZIMUTHS = 12, /**< |phi_o - phi_i| in bands of 15 degrees                      */
    FF_SURVEY_INCIDENCES = 8,
    FF_SURVEY_SAMPLES = 2000000 /**< memory for interpolation is that of so many samples at most   */
};

/** A symmetry put to the test. */
typedef struct ff_symmetry {
    int given;            /**< 1: the parametrisation makes it so, there is nothing to measure     */
    size_t pairs;         /**< compared; 0: no two samples are there to compare                    */
    double deviation;     /**< median |ln(a / b)|; NaN without pairs                               */
    double interpolation; /**< the same of interpolation alone; NaN where it could not be measured */
} ff_symmetry;

/** Reflectance into the part of the hemisphere that the data cover, for one incidence. */
typedef struct ff_reflectance {
    double theta_i, phi_i; /**< degrees; phi_i NaN: the mean over all azimuths of incidence at that theta_i */
    double covered;        /**< part of the projected hemisphere between samples, 0..1             */
} ff_reflectance;

/** Made by ff_survey_new and only looked at; later versions may have more members at its end. */
typedef struct ff_survey {
    size_t below_horizon;                                      /**< valid samples at or below it                       */
    double theta_i[2], theta_o[2];                             /**< range, degrees, of valid samples above; NaN: none  */
    unsigned char azimuths[FF_SURVEY_ROWS][FF_SURVEY_COLUMNS]; /**< how many of the azimuth bands have a valid sample  */
    size_t near_mirror[4];                                     /**< samples with theta_h up to 1, 2, 5, 10 degrees     */
    const char *method;                                        /**< of interpolation                                   */
    size_t every; /**< what follows is of every so many samples of a list longer than FF_SURVEY_SAMPLES; 1 = of all    */
    ff_symmetry isotropy;
    ff_symmetry reciprocity;
    double with_cosine;    /**< deviation from reciprocity if the values were f cos(theta_o); NaN without pairs            */
    double without_cosine; /**< ... if the reader had divided by a cosine that was not there                               */
    size_t n_reflectances;
    ff_reflectance reflectance[FF_SURVEY_INCIDENCES];
    double *albedo; /**< [n_reflectances][n_channels]: integral of f cos(theta_o) over the covered part; NaN where that is less
                         than 1 %. Of values that are means over cells the exact sum over all cells; of an RGL file the sum over
                         its samples, which is the integral of its function                                             */
    double *albedo_raised; /**< [n_reflectances][n_channels]: the same with negative values as 0                             */
    size_t azimuths_of[FF_SURVEY_INCIDENCES];      /**< azimuths of incidence that the reflectance is the mean over    */
    double over_azimuths[FF_SURVEY_INCIDENCES][2]; /**< least and most over these, of the channel mean                  */
    int in_plane; /**< 1: all samples lie in the plane of incidence: no reflectance into the hemisphere was measured      */
} ff_survey;

/** FF_ERR_MEMORY. *out is written only on FF_OK; release it with ff_survey_free. A table without a usable sample has an empty
 * survey. */
FF_API ff_status ff_survey_new(const ff_table *t, ff_survey **out, ff_error *err);
FF_API void ff_survey_free(ff_survey *s); /**< NULL is allowed */

/** 1 when reciprocity says that a cosine is still in the values, -1 that one was divided out that was not there, 0 when it says
 *  nothing: three quarters of the deviation must go, and it must be above that of interpolation. (Glossy materials are less
 * reciprocal as measured than one would think: half is not enough to tell.) */
FF_API int ff_survey_cosine(const ff_survey *s);

#ifdef __cplusplus
}
#endif
#endif
