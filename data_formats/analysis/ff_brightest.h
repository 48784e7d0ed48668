/** @file ff_brightest.h  On which side of the surface the data are brightest, and whether they reflect more than arrives.
 *
 *  A glossy surface is brightest about the mirror direction, opposite to the light. Where a file counts azimuths from the mirror
 *  direction, or the columns of light and detector stand for each other's, the brightest samples lie elsewhere; where it is in
 * other units than 1/sr, it reflects more than arrives. Nothing is assumed of the surface beyond that. Threads  no global state. */
#ifndef FF_BRIGHTEST_H
#define FF_BRIGHTEST_H
#include "ff_api.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Where the brightest sample of an incidence lies, by the azimuth between light and detector: more than 120 degrees, less than 60,
 *  or between. NONE: there are no samples to compare, or none stands out, by less than half. */
typedef enum ff_side { FF_SIDE_NONE = 0, FF_SIDE_MIRROR = 1, FF_SIDE_LIGHT = 2, FF_SIDE_ACROSS = 3 } ff_side;
enum { FF_SIDES = 4, FF_BRIGHTEST_ROWS = 18 };

/** What a surface cannot reflect of what arrives, with a tenth for noise; what it reflects in values of pi f at the most, and in
 * per cent. */
#define FF_REFLECTS_SOME   1.1
#define FF_REFLECTS_FACTOR (1.1 * 3.14159265358979323846)
#define FF_REFLECTS_ODD    110.0

/** Made by ff_brightest_find and only looked at; later versions may have more members at its end. */
typedef struct ff_brightest {
    size_t count[FF_SIDES];            /**< incidences of each kind, in bands of 5 degrees                            */
    ff_side side[FF_BRIGHTEST_ROWS];   /**< of each band                                                              */
    double theta_i[FF_BRIGHTEST_ROWS]; /**< of a sample in it, degrees; NaN where there is none                       */
    double reflects; /**< at least so much of the light, by the least value of every part of the hemisphere, at the incidence and in
                          the channel where it is most; NaN: no samples                                               */
} ff_brightest;

/** Of the valid samples above the horizon with both polar angles up to max_theta (radians, in (0, pi/2]), or of many of them an
 * even choice. FF_ERR_RANGE, FF_ERR_MEMORY; *out is written only on FF_OK. */
FF_API ff_status ff_brightest_find(const ff_table *t, double max_theta, ff_brightest *out);

/** The side on which all incidences that say anything have their brightest sample, at least two and as glossy surfaces do not:
 * LIGHT or ACROSS; else NONE. */
FF_API ff_side ff_brightest_odd(const ff_brightest *b);

#ifdef __cplusplus
}
#endif
#endif
