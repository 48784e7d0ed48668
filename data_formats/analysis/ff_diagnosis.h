/** @file ff_diagnosis.h  Whether a file's angles and values are what they were taken for.
 *
 *  A glossy surface is brightest where the half vector stands on it, whatever the incidence: f depends on theta_h more than on
 * anything else. Where that holds only if azimuths are turned, or polar angles are elevations, the angles were taken for something
 * else. Nothing else is assumed of the surface. A retro-reflector is brightest towards the light: the same as azimuths that are
 * turned, which only who made the file can tell apart. Threads  no global state. */
#ifndef FF_DIAGNOSIS_H
#define FF_DIAGNOSIS_H
#include "ff_api.h"
#include "ff_status.h"
#include "ff_table.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef enum ff_diagnosis_kind {
    FF_DIAGNOSIS_TURNED = 0,        /**< azimuth 0 is the mirror direction (or the surface is a retro-reflector)      */
    FF_DIAGNOSIS_UNTURNED = 1,      /**< azimuth 0 was taken for the mirror direction and is the light's              */
    FF_DIAGNOSIS_ELEVATION = 2,     /**< both polar angles are elevations above the surface                           */
    FF_DIAGNOSIS_ELEVATION_IN = 3,  /**< that of the light is                                                       */
    FF_DIAGNOSIS_ELEVATION_OUT = 4, /**< that of the detector is                                                    */
    FF_DIAGNOSIS_CLOCKWISE = 5,     /**< one azimuth grows the other way than the other                               */
    FF_DIAGNOSIS_RADIANS = 6,       /**< degrees that are radians                                                     */
    FF_DIAGNOSIS_PERCENT = 7,       /**< values of 100 times what can be                                              */
    FF_DIAGNOSIS_FACTOR = 8,        /**< values of pi times what can be                                               */
    FF_DIAGNOSIS_BEYOND = 9,        /**< every sample is beyond the largest angle that is looked at                   */
    FF_DIAGNOSIS_COSINE = 10,       /**< values with the cosine of the detector in them                               */
    FF_DIAGNOSIS_NO_COSINE = 11,    /**< values out of which a cosine was divided that was not there                  */
    FF_DIAGNOSIS_UNIT = 12          /**< values of more than 100 times what can be: counts, or another unit           */
} ff_diagnosis_kind;
enum { FF_DIAGNOSIS_KINDS = 13, FF_DIAGNOSIS_FINDINGS = 4 };

/** Something that was found, with the option of ff_read_options that mends it. */
typedef struct ff_finding {
    ff_diagnosis_kind kind;
    int sure;        /**< 1: the data leave no doubt                                                               */
    double value[2]; /**< TURNED ... CLOCKWISE: what share of the differences theta_h explains, as it is and mended; RADIANS: the
                          largest polar angle; PERCENT, FACTOR, UNIT: what would be reflected at least; BEYOND: the least angle,
                        degrees; COSINE, NO_COSINE: the deviation from reciprocity (ff_survey.h), as it is and mended */
} ff_finding;

/** Made by ff_diagnosis_find and only looked at; later versions may have more members at its end. */
typedef struct ff_diagnosis {
    size_t n;
    ff_finding finding[FF_DIAGNOSIS_FINDINGS];
    int open;          /**< 1: nothing in the file says how its angles are counted, as in most CSVs */
    int quantity_open; /**< 1: nor what its values are, and nobody has said it                      */
} ff_diagnosis;

/** Looks at the valid samples of t, or at many of them, with polar angles up to max_theta (radians, in (0, pi/2]). FF_ERR_RANGE,
 *  FF_ERR_MEMORY; *out is written only on FF_OK. */
FF_API ff_status ff_diagnosis_find(const ff_table *t, double max_theta, ff_diagnosis *out);

/** The option that mends it and its value: "azimuth", "mirror". value has room for 32 bytes. NULL for a kind
 * that is none, and for UNIT, which only who made the file knows. */
FF_API const char *ff_diagnosis_option(const ff_finding *finding, char value[32]);

#ifdef __cplusplus
}
#endif
#endif
