/** @file ff_calibration.h  From the signals of an instrument to reflectance: less what it reads in the dark, over what it reads of
 * a standard.
 *
 *  An instrument counts photons or volts. A second measurement, of a white standard whose reflectance is known, says how many of
 * them make a reflectance; a third, with the lamp shut, what it reads of nothing:
 *
 *      f = (signal - dark) / (signal of the standard - dark) R / pi
 *
 *  the BRDF of a standard of reflectance R that scatters as Lambert's law has it (ASTM E1392, relative method). */
#ifndef FF_CALIBRATION_H
#define FF_CALIBRATION_H
#include "ff_table.h"

/** What to calibrate with. All is borrowed. Zero is: nothing. */
typedef struct ff_calibration {
    const ff_table *reference; /**< of the standard; NULL: values are not divided                             */
    double reflectance;        /**< R of the standard, > 0; counts with `reference` alone                      */
    const ff_table *dark;      /**< signals without light; NULL: dark_signal                                   */
    double dark_signal;        /**< the same at every pair, in the unit of the values; 0: nothing              */
} ff_calibration;

/** How the samples of a second measurement stand for those of the first. */
typedef enum ff_matched {
    FF_MATCHED_NOT = 0,       /**< there is none                                                          */
    FF_MATCHED_PAIRS = 1,     /**< every pair of directions is there as well                              */
    FF_MATCHED_INCIDENCE = 2, /**< every incidence is: the mean over what was read at it                    */
    FF_MATCHED_ALL = 3        /**< one mean for all                                                       */
} ff_matched;

/** What was done. */
typedef struct ff_calibrated {
    ff_matched reference, dark;
    /** Largest relative standard deviation of the standard's means above the dark, by their scatter and the file's own; NaN: of
     * pairs, or of one reading of which the file says nothing. */
    double reference_error;
    size_t n_lost; /**< samples whose standard reads no more than the dark: not measured now       */
} ff_calibrated;

/** Calibrates the values of t, which are in 1/sr afterwards where there is a reference; standard deviations, where t has them, get
 * those of the reference and of the dark at the same pair, which are independent, added in squares. A second measurement
 * stands for t pair by pair where it has all of its directions (within 0.05 degrees); else by the means at its incidences, where
 * those are the same; else, if it has one incidence alone, by its mean. Channels are matched by name, or are as many. FF_ERR_RANGE:
 * a reflectance not above 0, a signal that is no number. FF_ERR_DATA: incidences that the standard was not measured at (the message
 * has the first), or another number of channels; nothing above the dark. FF_ERR_UNSUPPORTED: tables of different quantities; a dark
 * signal that is one number, of values that were divided by a cosine on reading. FF_ERR_MEMORY. t is changed only on FF_OK.
 *  @param out  may be NULL */
FF_API ff_status ff_table_calibrate(ff_table *t, const ff_calibration *c, ff_calibrated *out, ff_error *err);
#endif
