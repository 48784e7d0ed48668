/** @file ff_table.h  Measured reflectance: one table for every format, and the registry of formats.
 *
 *  A table holds n samples, each a pair of directions with one value per channel. It comes from a file, or a program fills it:
 *
 *      ff_table *t;
 *      ff_table_read("gold.csv", NULL, &t, &err);           // whatever format it has
 *      ...
 *      ff_table_new(n, 1, 0, 0, &t, &err);                  // n samples, one channel, of your own
 *      ff_table_set_angle_unit(t, FF_DEGREES);
 *      for (int k = 0; k < 4; k++) fill(ff_table_angle_plane(t, k));
 *      fill(ff_table_value_plane(t, 0));
 *
 *  Values are handed out in 1/sr without the cosine, whatever the file stored. Directions are stored as the file had them (four
 *  angle planes in the file's unit) or, for a grid, given by formula, so that a MERL file costs its values and little else.
 *  Frame, angles: as ff_model.h.
 *  Memory   a table owns its arrays; release with ff_table_free. Planes are as long as the table and go with it.
 *  Errors   ff_status and a caller-owned ff_error with path, line or byte; *out is written only on FF_OK. Nothing prints or aborts.
 *  Threads  no global state; a const table may be read from many threads at once. */
#ifndef FF_TABLE_H
#define FF_TABLE_H
#include "ff_api.h"
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_CHANNEL_NAME = 64, FF_TABLE_NOTES = 64 };

/** Radians in a degree: see ff_table_set_angle_unit. */
#define FF_DEGREES 0.017453292519943295

/** One colour channel. */
typedef struct ff_channel {
    char name[FF_CHANNEL_NAME]; /**< "r", "465nm", ...                                              */
    double wavelength_nm;       /**< NaN where the channel is not a wavelength                      */
    double scale;               /**< 1/sr per stored unit: value = scale * stored                   */
} ff_channel;

/** What the values of a file stand for. Readers convert to FF_BRDF; writers write FF_BRDF unless their format says otherwise. */
typedef enum ff_quantity {
    FF_BRDF = 0,              /**< f, 1/sr                       */
    FF_BRDF_COS = 1,          /**< f cos(theta_o), 1/sr          */
    FF_REFLECTANCE_FACTOR = 2 /**< pi f                          */
} ff_quantity;

/** "brdf", "brdf-cos", "reflectance-factor"; NULL for a number that is none. */
FF_API const char *ff_quantity_name(int quantity);

/** Measured samples. Closed: read and filled by the functions below. */
typedef struct ff_table ff_table;

/** A regular parametrisation whose directions and weights follow from the sample's index. Closed, immutable, static storage. */
typedef struct ff_grid ff_grid;

/** The grid of a name; NULL when unknown. "merl" is the 90 x 90 x 180 half and difference angles of Matusik et al. 2003, samples at
 *  the centres of cells. */
FF_API const ff_grid *ff_grid_find(const char *name);

/** Samples that a grid has. */
FF_API size_t ff_grid_samples(const ff_grid *grid);

/* ---- making and filling ---------------------------------------------------------------------- */

/** A table of n samples (>= 1) and n_channels (>= 1) to be filled: values 0, all valid, scale 1, wavelengths NaN, names "c0" ...,
 *  angles 0 in radians. with_sigma, with_weight: 1 for planes of standard deviations and of weights too.
 *  FF_ERR_RANGE; FF_ERR_MEMORY, also when the sizes overflow. */
FF_API ff_status ff_table_new(size_t n, size_t n_channels, int with_sigma, int with_weight, ff_table **out, ff_error *err);

/** The same on a grid: the directions are its own. */
FF_API ff_status ff_table_new_on_grid(const ff_grid *grid, size_t n_channels, int with_sigma, ff_table **out, ff_error *err);

/** A copy of the table, with what its format needs to write the same file again. FF_ERR_MEMORY. */
FF_API ff_status ff_table_copy(const ff_table *t, ff_table **out, ff_error *err);

/** Releases the table and what it owns. NULL is allowed. */
FF_API void ff_table_free(ff_table *t);

/** The planes, to be filled or looked at: [n] each, in the order of the samples, in the table's own units.
 *  value    of channel c: times the channel's scale it is f in 1/sr
 *  sigma    of channel c: standard deviations in the unit of the values; NULL when the table has none
 *  angle    k = 0 .. 3: theta_i, phi_i, theta_o, phi_o in the unit of ff_table_set_angle_unit; NULL of a grid
 *  weight   solid-angle weights; NULL when the table has none
 *  valid    0 = not a measurement
 *  NULL also for a channel or angle that does not exist. */
FF_API double *ff_table_value_plane(ff_table *t, size_t c);
FF_API double *ff_table_sigma_plane(ff_table *t, size_t c);
FF_API double *ff_table_angle_plane(ff_table *t, int k);
FF_API double *ff_table_weight_plane(ff_table *t);
FF_API unsigned char *ff_table_valid_plane(ff_table *t);

/** Unit of the angle planes in radians: 1, or FF_DEGREES. FF_ERR_RANGE unless finite and > 0. */
FF_API ff_status ff_table_set_angle_unit(ff_table *t, double radians);

/** 1: only differences of azimuths were measured, so that nothing can be said of a direction of the surface. */
FF_API void ff_table_set_isotropic(ff_table *t, int isotropic);

/** Names channel c (cut to fit), and says its wavelength (NaN = none) and scale (1/sr per stored unit). FF_ERR_RANGE for a channel
 *  that does not exist, and for a wavelength or scale that is not finite and > 0. */
FF_API ff_status ff_table_set_channel(ff_table *t, size_t c, const char *name, double wavelength_nm, double scale);

/* ---- reading --------------------------------------------------------------------------------- */

FF_API size_t ff_table_samples(const ff_table *t);       /**< n: samples, those that are no measurements included          */
FF_API size_t ff_table_channel_count(const ff_table *t); /**< n_channels                                                  */

/** Channel c; NULL when there is none. It goes with the table. */
FF_API const ff_channel *ff_table_channel(const ff_table *t, size_t c);

/** Index of a channel by name, -1 when there is none. */
FF_API int ff_table_channel_find(const ff_table *t, const char *name);

FF_API const char *ff_table_format(const ff_table *t);   /**< name of the format it was read from, "" when made in memory   */
FF_API const ff_grid *ff_table_grid(const ff_table *t);  /**< its grid, NULL when the samples have angles of their own      */
FF_API int ff_table_is_isotropic(const ff_table *t);     /**< 1: see ff_table_set_isotropic                                 */
FF_API double ff_table_angle_unit(const ff_table *t);    /**< radians per unit of the angle planes                          */
FF_API ff_quantity ff_table_quantity(const ff_table *t); /**< what the file declared; values are the BRDF already           */

/** What a reader had to assume: sentence k of the notes into out [size], always terminated; what the caller can say to it into
 * *hint (may be NULL). Returns 0 when there are not so many. */
FF_API int ff_table_assumption(const ff_table *t, size_t k, char *out, size_t size, ff_hint *hint);

/** Unit vectors of samples first .. first+count-1 into six planes [count] wix wiy wiz wox woy woz. A direction whose
 *  angles are not finite is (0, 0, -1), below the horizon. Here and below nothing is written of samples, or a channel, that do not
 *  exist. */
FF_API void ff_table_directions(const ff_table *t, size_t first, size_t count, double *const planes[6]);

/** Values of channel c in 1/sr into out [count]; sigma likewise (requires ff_table_has_sigmas). */
FF_API void ff_table_values(const ff_table *t, size_t c, size_t first, size_t count, double *out);
FF_API void ff_table_sigmas(const ff_table *t, size_t c, size_t first, size_t count, double *out);

/** 1 for every sample that is a measurement, else 0, into out [count]. */
FF_API void ff_table_valid(const ff_table *t, size_t first, size_t count, unsigned char *out);

/** 1 when the table has standard deviations. */
FF_API int ff_table_has_sigmas(const ff_table *t);

/** 1 when the table defines solid-angle weights (a grid, or a weight plane). */
FF_API int ff_table_has_weights(const ff_table *t);
/** Solid-angle weights (sr^2, the measure d wi d wo of the sample's cell) into out [count]; requires ff_table_has_weights. */
FF_API void ff_table_weights(const ff_table *t, size_t first, size_t count, double *out);

/* ---- files ----------------------------------------------------------------------------------- */

/** Where the azimuth of the detector, counted from that of the light, is 0: on the side of the light, or of the mirror direction.
 * Of a scan in the plane of incidence without azimuths it says on which side the positive angles are. */
typedef enum ff_azimuth { FF_AZIMUTH_AS_FORMAT = 0, FF_AZIMUTH_MIRROR = 1, FF_AZIMUTH_LIGHT = 2 } ff_azimuth;

/** Azimuths that grow clockwise, seen from above: both, or that of the light, or of the detector alone. */
typedef enum ff_phi_sense {
    FF_PHI_AS_FORMAT = 0,
    FF_PHI_CLOCKWISE = 1,
    FF_PHI_CLOCKWISE_IN = 2,
    FF_PHI_CLOCKWISE_OUT = 3
} ff_phi_sense;

/** What polar angles are (or all, of degrees and radians), where the file is taken for something else. */
typedef enum ff_angles {
    FF_ANGLES_AS_FORMAT = 0,
    FF_ANGLES_DEGREES = 1,
    FF_ANGLES_RADIANS = 2,
    FF_ANGLES_ELEVATION = 3,    /**< both above the surface, not from its normal */
    FF_ANGLES_ELEVATION_IN = 4, /**< that of the light                           */
    FF_ANGLES_ELEVATION_OUT = 5 /**< that of the detector                        */
} ff_angles;

/** "degrees", "radians", "elevation", "elevation-in", "elevation-out"; "" for 0, NULL for a number that is none. */
FF_API const char *ff_angles_name(int angles);

/** "mirror", "light"; "clockwise", "clockwise-in", "clockwise-out"; "" for 0, NULL for a number that is none. */
FF_API const char *ff_azimuth_name(int azimuth);
FF_API const char *ff_phi_sense_name(int phi);

/** What a person knows about a file and the file does not say. Fill with ff_read_options_init, then change. */
typedef struct ff_read_options {
    size_t size;         /**< sizeof(ff_read_options)                                                                   */
    const char *format;  /**< name of the format; NULL: by content                                                      */
    const char *columns; /**< "theta_i=incidence,f=reflectance": our names of a CSV's columns; NULL: the file's names     */
    const char *grid;    /**< sampling of a file that holds a function rather than samples; NULL: as it was measured      */
    const char *part;    /**< which of several data sets in the file ("reflection-back"); NULL: the format's usual one    */
    int quantity;        /**< ff_quantity of the numbers, -1: what the file says                                        */
    double scale;        /**< factor on all values (1/sr per unit of an uncalibrated file), > 0; NaN: none given          */
    /** Asked before a file is opened that the data name (an image of a stack): anything but FF_OK ends the reading with that status
     *  and the message of err. NULL: all may be read. */
    ff_status (*ask)(const void *context, const char *path, ff_error *err);
    const void *ask_context;
    const char *dialect; /**< "separator=semicolon,decimal=comma": how a CSV is written; NULL: as its rows look           */
    int azimuth;         /**< ff_azimuth: what azimuth 0 of the detector means; 0: what the format says                  */
    int phi;             /**< ff_phi_sense: which azimuths are counted clockwise; 0: none                                 */
    int angles;          /**< ff_angles: what the angles are; 0: what the format says                                     */
} ff_read_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_read_options_init_size(ff_read_options *o, size_t size);
static inline void ff_read_options_init(ff_read_options *o)
{
    ff_read_options_init_size(o, sizeof *o);
}

/** Options that a format understands beyond `format` and `scale`; giving another is an error. */
enum {
    FF_READS_COLUMNS = 1 << 0,
    FF_READS_GRID = 1 << 1,
    FF_READS_PART = 1 << 2,
    FF_READS_QUANTITY = 1 << 3,
    FF_READS_DIALECT = 1 << 4
};

/** What a file of a format can hold beside values. What it cannot is dropped by ff_resample, which says so; a plain write refuses.
 */
enum {
    FF_HOLDS_SIGMA = 1 << 0,    /**< standard deviations                                              */
    FF_HOLDS_INVALID = 1 << 1,  /**< samples that were not measured, in their places                  */
    FF_HOLDS_NEGATIVE = 1 << 2, /**< negative values                                                  */
    FF_HOLDS_NAMES = 1 << 3,    /**< names and wavelengths of channels                                */
    FF_HOLDS_DOUBLE = 1 << 4,   /**< the bits of every value; else `precision` says what remains      */
    FF_HOLDS_WEIGHTS = 1 << 5,  /**< solid-angle weights of scattered samples                         */
    FF_HOLDS_MANY = 1 << 6,     /**< any number of channels                                           */
    FF_HOLDS_NM = 1 << 7        /**< wavelengths of channels, which are their names; no others        */
};

/** A format of files. Closed, immutable, static storage. */
typedef struct ff_format ff_format;

/** The list of formats, in a fixed order. */
FF_API size_t ff_format_count(void);
FF_API const ff_format *ff_format_at(size_t i);           /**< NULL when i >= count */
FF_API const ff_format *ff_format_find(const char *name); /**< NULL when unknown    */

FF_API const char *ff_format_name(const ff_format *f);       /**< "merl"                                                         */
FF_API const char *ff_format_title(const ff_format *f);      /**< one line for lists                                             */
FF_API const char *ff_format_extensions(const ff_format *f); /**< usual ones, space separated, with the dot                      */
FF_API const char *ff_format_source(const ff_format *f);     /**< where the layout is documented                                 */
FF_API unsigned ff_format_reads(const ff_format *f);         /**< FF_READS_...                                                   */
FF_API unsigned ff_format_holds(const ff_format *f);         /**< FF_HOLDS_..., where it can be written                          */
FF_API const char *ff_format_precision(const ff_format *f);  /**< of written values without FF_HOLDS_DOUBLE; else NULL            */
FF_API int ff_format_can_write(const ff_format *f);          /**< 1, or 0: such files can only be read                           */

/** The format whose probe is most confident about the content of path. FF_ERR_OPEN, FF_ERR_READ, FF_ERR_FORMAT (none recognised it;
 *  the message says what the first bytes look like and which formats exist). */
FF_API ff_status ff_format_detect(const char *path, const ff_format **out, ff_error *err);

/** The format that a name to be written asks for by its extension; NULL when none does. */
FF_API const ff_format *ff_format_for_writing(const char *path);

/** Reads path ("-": standard input) with the named format, or by content when format is NULL. FF_ERR_OPEN, FF_ERR_READ,
 *  FF_ERR_FORMAT, FF_ERR_DATA with path, line or byte; FF_ERR_UNKNOWN, FF_ERR_MEMORY. */
FF_API ff_status ff_table_read(const char *path, const char *format, ff_table **out, ff_error *err);

/** The same with all options (NULL: none). FF_ERR_UNSUPPORTED also for an option that the format does not understand. */
FF_API ff_status ff_table_read_with(const char *path, const ff_read_options *o, ff_table **out, ff_error *err);

/** Reads n files (>= 1) and joins their samples to one measurement, as where each file has one incidence; a folder stands for the
 * files in it that some format recognises, by their names. Channels are the same in all; standard deviations stay where all have
 * them. Errors as ff_table_read_with, of the first file that has one; FF_ERR_DATA for channels that differ; FF_ERR_RANGE for n = 0.
 */
FF_API ff_status ff_table_read_all(const char *const *paths, size_t n, const ff_read_options *o, ff_table **out, ff_error *err);

/** Writes with the named format, or by extension when format is NULL ("-" is standard output). The file appears whole or not at
 * all. FF_ERR_UNSUPPORTED for a format that cannot be written or cannot hold such data, FF_ERR_DATA for samples that no file can
 * hold, FF_ERR_UNKNOWN, FF_ERR_WRITE, FF_ERR_MEMORY. */
FF_API ff_status ff_table_write(const char *path, const char *format, const ff_table *t, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
