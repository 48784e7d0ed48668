/** @file internal_csv_meaning.h  What the names of columns mean: csv_words.def, units, numbers in names. */
#ifndef FF_INTERNAL_CSV_MEANING_H
#define FF_INTERNAL_CSV_MEANING_H
#include "internal_csv.h"

/** What one word of a name can say; a name says the sum of its words. */
enum {
    FF_SAYS_SIDE_I = 1 << 0,
    FF_SAYS_SIDE_O = 1 << 1,
    FF_SAYS_POLAR = 1 << 2,
    FF_SAYS_AZIMUTH = 1 << 3,
    FF_SAYS_ELEVATION = 1 << 4,
    FF_SAYS_ANGLE = 1 << 5, /**< some angle; which one the others say */
    FF_SAYS_HALF = 1 << 6,
    FF_SAYS_DIFFERENCE = 1 << 7,
    FF_SAYS_PHASE = 1 << 8,
    FF_SAYS_AXIS_X = 1 << 9,
    FF_SAYS_AXIS_Y = 1 << 10,
    FF_SAYS_AXIS_Z = 1 << 11,
    FF_SAYS_VECTOR = 1 << 12,
    FF_SAYS_BRDF = 1 << 13,
    FF_SAYS_COSINE = 1 << 14,
    FF_SAYS_REFLECTANCE = 1 << 15,
    FF_SAYS_FACTOR = 1 << 16,
    FF_SAYS_COUNTS = 1 << 17,
    FF_SAYS_PLAIN_VALUE = 1 << 18,
    FF_SAYS_COLOR = 1 << 19,
    FF_SAYS_SIGMA = 1 << 20,
    FF_SAYS_WEIGHT = 1 << 21,
    FF_SAYS_WAVELENGTH = 1 << 22,
    FF_SAYS_FILLER = 1 << 23
};

/** What a column is. */
typedef enum ff_meaning {
    FF_MEANS_NOTHING, /**< a stranger                                                        */
    FF_MEANS_THETA_I,
    FF_MEANS_THETA_O,
    FF_MEANS_THETA, /**< a polar angle, of whichever side is missing                         */
    FF_MEANS_PHI_I,
    FF_MEANS_PHI_O,
    FF_MEANS_PHI, /**< the azimuth of the detector, or between both directions               */
    FF_MEANS_ELEVATION_I,
    FF_MEANS_ELEVATION_O,
    FF_MEANS_THETA_H,
    FF_MEANS_PHI_H,
    FF_MEANS_THETA_D,
    FF_MEANS_PHI_D,
    FF_MEANS_WI_X,
    FF_MEANS_WI_Y,
    FF_MEANS_WI_Z,
    FF_MEANS_WO_X,
    FF_MEANS_WO_Y,
    FF_MEANS_WO_Z,
    FF_MEANS_PHASE,
    FF_MEANS_VALUE,
    FF_MEANS_SIGMA,
    FF_MEANS_WEIGHT,
    FF_MEANS_WAVELENGTH,
    FF_MEANS_NUMBER /**< a name that is a number and perhaps a unit: a value there            */
} ff_meaning;

/** Which column of values counts where several are there: the higher. */
enum { FF_RANK_NONE, FF_RANK_PLAIN, FF_RANK_COUNTS, FF_RANK_REFLECTANCE, FF_RANK_FACTOR, FF_RANK_BRDF };

typedef struct ff_named {
    ff_meaning meaning;
    int rank; /**< of a value                                                                   */
    ff_quantity quantity;
    ff_csv_unit unit;              /**< FF_CSV_PLAIN: the name has none that goes with its meaning       */
    double number;                 /**< of "BRDF 20 deg" or "550 nm"; NaN: none                       */
    ff_csv_unit number_unit;       /**< its unit                                                      */
    int is_elevation;              /**< it has a word for an elevation, whether or not one for a side     */
    char channel[FF_CHANNEL_NAME]; /**< what is left of the name of a value: "R" of "BRDF_R", "" of "BRDF" */
} ff_named;

/** The meaning of a name. Never fails. */
void ff_name_meaning(const char *name, ff_named *out);

/** The unit that a text is, "deg", "[1/sr]", as in a row of units below the names; -1: none. FF_CSV_PLAIN: a unit that changes
 * nothing.
 */
int ff_name_unit(const char *text);

/** The angle of incidence that the name of a file says, in degrees: "A3_20deg.csv", "aoi 12.5.txt", "theta_i=20". 0 when it says
 * none, or several. */
int ff_name_incidence(const char *path, double *degrees);

/** Makes UTF-8 of a name in ISO-8859-1; one that is UTF-8 stays. Cut to fit. Returns out. */
const char *ff_name_utf8(const char *name, char *out, size_t size);

#endif
