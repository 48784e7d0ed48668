/** @file ff_table.h  Measured reflectance: one table for every format, and the registry of formats.
 *
 *  A table holds n samples, each a pair of directions with one value per channel. Values are handed out in 1/sr without the
 *  cosine, whatever the file stored. Directions are stored as the file had them (four angle planes in the file's unit) or, for a
 *  grid, given by formula, so that a MERL file costs its values and little else.
 *  Frame, angles: as ff_model.h.
 *  Memory   a table owns its arrays; release with ff_table_free.
 *  Errors   ff_status and a caller-owned ff_error with path, line or byte. Nothing prints or aborts.
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

/** One colour channel. */
typedef struct ff_channel {
    char   name[FF_CHANNEL_NAME]; /**< "r", "465nm", ...                                              */
    double wavelength_nm;         /**< NaN where the channel is not a wavelength                      */
    double scale;                 /**< 1/sr per stored unit: value = scale * stored                   */
} ff_channel;

/** What the values of a file stand for. Readers convert to FF_BRDF; writers write FF_BRDF unless their format says otherwise. */
typedef enum ff_quantity {
    FF_BRDF = 0,              /**< f, 1/sr                       */
    FF_BRDF_COS = 1,          /**< f cos(theta_o), 1/sr          */
    FF_REFLECTANCE_FACTOR = 2 /**< pi f                          */
} ff_quantity;

/** "brdf", "brdf-cos", "reflectance-factor"; NULL for a number that is none. */
FF_API const char *ff_quantity_name(int quantity);

struct ff_table;

/** A regular parametrisation whose directions and weights follow from the sample's index. Immutable, static storage. */
typedef struct ff_grid {
    const char *name;   /**< "merl"                                                                        */
    size_t      n;      /**< samples it has                                                                */
    int         isotropic; /**< 1: the parametrisation cannot tell one azimuth of incidence from another   */
    /** Unit vectors of samples first .. first+count-1 into six planes [count] wix wiy wiz wox woy woz. z may be <= 0. */
    void (*directions)(size_t first, size_t count, double *const planes[6]);
    /** Solid-angle weights (sr^2, the measure d wi d wo of the cell) into w [count]. */
    void (*weights)(size_t first, size_t count, double *w);
} ff_grid;

/** How the samples of a table are the product of up to four lists of nodes. */
typedef enum ff_axes_kind {
    FF_AXES_NONE = 0,            /**< scattered: no such structure                                                     */
    FF_AXES_HALF_DIFFERENCE = 1, /**< theta_h, phi_h, theta_d, phi_d (Rusinkiewicz 1998)                               */
    FF_AXES_INCIDENT_EXIT = 2,   /**< theta_i, phi_i, theta_o, phi_o                                                   */
    FF_AXES_SPECULAR = 3         /**< rotation of the sample, incidence, azimuth and polar angle about the specular direction */
} ff_axes_kind;

/** Sample ((a0 n[1] + a1) n[2] + a2) n[3] + a3 is at node[k][ak], in the table's angle unit. An axis that the format does not
 *  have has one node, 0. */
typedef struct ff_axes {
    ff_axes_kind kind;
    size_t       n[4];
    double      *node[4];        /**< [n[k]], owned by the table                                                     */
} ff_axes;

typedef struct ff_table {
    char         format[32];     /**< name of the format it was read from, "" when made in memory                   */
    size_t       n, n_channels;
    ff_channel  *channels;       /**< [n_channels]                                                                   */
    double      *value;          /**< [n_channels][n], stored units; channel c of sample i at value[c*n + i]         */
    double      *sigma;          /**< [n_channels][n], stored units, standard deviations; NULL when the file has none */
    unsigned char *valid;        /**< [n]; 0 = the file says that this is not a measurement                          */
    const ff_grid *grid;         /**< NULL: angles below hold the directions                                         */
    double      *angle[4];       /**< [n] each: theta_i, phi_i, theta_o, phi_o in the file's unit; NULL with a grid  */
    double       radians_per_unit; /**< 1 or pi/180                                                                  */
    ff_axes      axes;           /**< the product structure, where the file has one; angle planes are there as well  */
    double      *weight;         /**< [n] solid-angle weights of scattered samples; NULL when the file defines none  */
    int          isotropic;      /**< 1: only azimuth differences were measured (3D parametrisation, or one phi_i)   */
    ff_quantity  quantity;       /**< as the file declared; `value` is converted already where not a constant factor */
    size_t       n_invalid;      /**< samples with valid = 0                                                         */
    size_t       n_negative;     /**< valid samples with a negative value in at least one channel: kept, as noise    */
    char         note[2048];     /**< what a reader had to assume, sentences separated by newlines; "" when nothing  */
    unsigned char note_hint[FF_TABLE_NOTES]; /**< ff_hint of the k-th sentence: what the caller can say to it        */
    void        *kept;           /**< what `format` needs to write the same file again; NULL for most                */
    void       (*kept_free)(void *kept);
    void      *(*kept_share)(void *kept); /**< for a copy of the table: a copy, or the same with one owner more; NULL = no memory */
    /** The part of weight[sample] that its incidence has, where the other part makes the sum of f cos(theta_o) over an incidence its
     *  reflectance; NULL: the weights are solid angles and no more. */
    double     (*kept_incidence)(const void *kept, size_t sample);
} ff_table;

/** Releases what the table owns and zeroes it. A zeroed table and NULL are legal. */
FF_API void ff_table_free(ff_table *t);

/** Allocates arrays for n samples (n >= 1) and n_channels (>= 1): values 0, all valid, scale 1, wavelengths NaN, names "c0"...
 *  With a grid, n must be grid->n and no angle planes are made. with_sigma, with_weight: also those planes. FF_ERR_MEMORY
 *  also when the sizes overflow. *out is overwritten, not freed. */
FF_API ff_status ff_table_new(size_t n, size_t n_channels, const ff_grid *grid, int with_sigma, int with_weight, ff_table *out, ff_error *err);

/** Unit vectors of samples first .. first+count-1 into six planes [count] wix wiy wiz wox woy woz. first+count <= n. */
FF_API void ff_table_directions(const ff_table *t, size_t first, size_t count, double *const planes[6]);

/** Values of channel c in 1/sr into out [count]; sigma likewise (requires t->sigma). */
FF_API void ff_table_values(const ff_table *t, size_t c, size_t first, size_t count, double *out);
FF_API void ff_table_sigmas(const ff_table *t, size_t c, size_t first, size_t count, double *out);

/** 1 when the table defines solid-angle weights (a grid, or a weight plane). */
FF_API int ff_table_has_weights(const ff_table *t);
/** Solid-angle weights into out [count]; requires ff_table_has_weights. */
FF_API void ff_table_weights(const ff_table *t, size_t first, size_t count, double *out);

/** Index of a channel by name, -1 when there is none. */
FF_API int ff_table_channel_find(const ff_table *t, const char *name);

/* ---- formats --------------------------------------------------------------------------------- */

/** What a person knows about a file and the file does not say. Fill with ff_read_options_init, then change. */
typedef struct ff_read_options {
    size_t      size;      /**< sizeof(ff_read_options)                                                                   */
    const char *format;    /**< name of the format; NULL: by content                                                      */
    const char *columns;   /**< "theta_i=incidence,f=reflectance": our names of a CSV's columns; NULL: the file's names     */
    const char *grid;      /**< sampling of a file that holds a function rather than samples; NULL: as it was measured      */
    const char *part;      /**< which of several data sets in the file ("reflection-back"); NULL: the format's usual one    */
    int         quantity;  /**< ff_quantity of the numbers, -1: what the file says                                        */
    double      scale;     /**< factor on all values (1/sr per unit of an uncalibrated file), > 0; NaN: none given          */
    /** Asked before a file is opened that the data name (an image of a stack): anything but FF_OK ends the reading with that status
     *  and the message of err. NULL: all may be read. */
    ff_status (*ask)(const void *context, const char *path, ff_error *err);
    const void *ask_context;
} ff_read_options;
FF_API void ff_read_options_init(ff_read_options *o);

/** Options that a format understands beyond `format` and `scale`; giving another is an error. */
enum { FF_READS_COLUMNS = 1 << 0, FF_READS_GRID = 1 << 1, FF_READS_PART = 1 << 2, FF_READS_QUANTITY = 1 << 3 };

/** What a file of a format can hold beside values. What it cannot is dropped by ff_resample, which says so; a plain write refuses. */
enum {
    FF_HOLDS_SIGMA = 1 << 0,    /**< standard deviations                                              */
    FF_HOLDS_INVALID = 1 << 1,  /**< samples that were not measured, in their places                  */
    FF_HOLDS_NEGATIVE = 1 << 2, /**< negative values                                                  */
    FF_HOLDS_NAMES = 1 << 3,    /**< names and wavelengths of channels                                */
    FF_HOLDS_DOUBLE = 1 << 4,   /**< the bits of every value; else `precision` says what remains      */
    FF_HOLDS_WEIGHTS = 1 << 5,  /**< solid-angle weights of scattered samples                         */
    FF_HOLDS_MANY = 1 << 6      /**< any number of channels                                           */
};

/** Everything the program knows about one format; defined in one file. Immutable, static storage. */
typedef struct ff_format {
    const char *name;       /**< "merl": key of --format                                                      */
    const char *title;      /**< one line for lists                                                           */
    const char *extensions; /**< usual ones, space separated, with the dot; a hint for writing, never for reading */
    const char *source;     /**< where the layout is documented                                               */
    /** Confidence 0..100 that a file is of this format, from its first n_head bytes (>= 0, without a UTF-8 byte-order mark) and
     *  its size (-1 = a stream). */
    int (*probe)(const unsigned char *head, size_t n_head, int64_t file_size);
    unsigned    reads;      /**< FF_READS_...                                                                     */
    unsigned    holds;      /**< FF_HOLDS_..., where it can be written                                            */
    const char *precision;  /**< of written values without FF_HOLDS_DOUBLE: "32-bit float, 6e-8 relative"; else NULL */
    ff_status (*read)(const char *path, const ff_read_options *o, ff_table *out, ff_error *err);
    /** The pairs of directions that a file of this format has for data like t: a table with those directions (and grid or axes),
     *  channels named as in t (one channel may become several of the same content), scales as the format stores values, values 0,
     *  all valid. NULL: any directions.
     *  @param grid  what the format lets choose, as a text of its own; NULL = the usual.
     *  FF_ERR_SYNTAX, FF_ERR_RANGE for a grid that is none, FF_ERR_UNSUPPORTED for a t that cannot be held, FF_ERR_MEMORY. */
    ff_status (*layout)(const ff_table *t, const char *grid, ff_table *out, ff_error *err);
    /** NULL where the format cannot be written. Writes to a temporary name beside path, then renames; "-" is stdout.
     *  FF_ERR_UNSUPPORTED for directions that are not of its layout. */
    ff_status (*write)(const char *path, const ff_table *t, ff_error *err);
} ff_format;

FF_API size_t           ff_format_count(void);
FF_API const ff_format *ff_format_at(size_t i);           /**< NULL when i >= count */
FF_API const ff_format *ff_format_find(const char *name); /**< NULL when unknown    */

/** The format whose probe is most confident about the content of path. FF_ERR_OPEN, FF_ERR_READ, FF_ERR_FORMAT (none recognised it;
 *  the message says what the first bytes look like and which formats exist). */
FF_API ff_status ff_format_detect(const char *path, const ff_format **out, ff_error *err);

/** The format that a name to be written asks for by its extension; NULL when none does. */
FF_API const ff_format *ff_format_for_writing(const char *path);

/** Reads path with the named format, or by content when format is NULL. *out is overwritten, not freed; untouched on failure. */
FF_API ff_status ff_table_read(const char *path, const char *format, ff_table *out, ff_error *err);

/** The same with all options (NULL: none). FF_ERR_UNSUPPORTED also for an option that the format does not understand. */
FF_API ff_status ff_table_read_with(const char *path, const ff_read_options *o, ff_table *out, ff_error *err);

/** Writes with the named format, or by extension when format is NULL. The file appears whole or not at all. */
FF_API ff_status ff_table_write(const char *path, const char *format, const ff_table *t, ff_error *err);

/** The 90 x 90 x 180 half/difference-angle grid of Matusik et al. 2003 (samples at cell centres). */
extern const ff_grid ff_grid_merl;

#ifdef __cplusplus
}
#endif
#endif
