/* Tables as plain values: what ff_table.h closes to others. In here a table is filled and read in place. */
#ifndef FF_TABLE_STRUCT_H
#define FF_TABLE_STRUCT_H
#include "ff_table.h"
#include "internal_cells.h"
#ifdef __cplusplus
extern "C" {
#endif

struct ff_outputs; /* base/internal_output.h */

/* ---- a table --------------------------------------------------------------------------------- */

/** A regular parametrisation whose directions and weights follow from the sample's index. Immutable, static storage. */
struct ff_grid {
    const char *name; /**< "merl"                                                                        */
    size_t n;         /**< samples it has                                                                */
    int isotropic;    /**< 1: the parametrisation cannot tell one azimuth of incidence from another   */
    /** Unit vectors of samples first .. first+count-1 into six planes [count] wix wiy wiz wox woy woz. z may be <= 0. */
    void (*directions)(size_t first, size_t count, double *const planes[6]);
    /** Solid-angle weights (sr^2, the measure d wi d wo of the cell) into w [count]. */
    void (*weights)(size_t first, size_t count, double *w);
};

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
    size_t n[4];
    double *node[4]; /**< [n[k]], owned by the table                                                     */
} ff_axes;

struct ff_table {
    char format[32]; /**< name of the format it was read from, "" when made in memory                   */
    size_t n, n_channels;
    ff_channel *channels;                    /**< [n_channels]                                                                   */
    double *value;                           /**< [n_channels][n], stored units; channel c of sample i at value[c*n + i]         */
    double *sigma;                           /**< [n_channels][n], stored units, standard deviations; NULL when the file has none */
    unsigned char *valid;                    /**< [n]; 0 = the file says that this is not a measurement                          */
    const ff_grid *grid;                     /**< NULL: angles below hold the directions                                         */
    double *angle[4];                        /**< [n] each: theta_i, phi_i, theta_o, phi_o in the file's unit; NULL with a grid  */
    double radians_per_unit;                 /**< 1 or pi/180                                                                  */
    ff_axes axes;                            /**< the product structure, where the file has one; angle planes are there as well  */
    double *weight;                          /**< [n] solid-angle weights of scattered samples; NULL when the file defines none  */
    int isotropic;                           /**< 1: only azimuth differences were measured (3D parametrisation, or one phi_i)   */
    int angles_are_open;                     /**< 1: nothing in the file says how its angles are counted, as in most CSVs      */
    int quantity_is_open;                    /**< 1: nor what its values are, and nobody has said it                           */
    int azimuth_from_mirror;                 /**< 1: taken from a file whose azimuth 0 is the mirror direction; turned already */
    ff_quantity quantity;                    /**< as the file declared; `value` is converted already where not a constant factor */
    size_t n_invalid;                        /**< samples with valid = 0                                                         */
    size_t n_negative;                       /**< valid samples with a negative value in at least one channel: kept, as noise    */
    char note[2048];                         /**< what a reader had to assume, sentences separated by newlines; "" when nothing  */
    unsigned char note_hint[FF_TABLE_NOTES]; /**< ff_hint of the k-th sentence: what the caller can say to it        */
    void *kept;                              /**< what `format` needs to write the same file again; NULL for most                */
    void (*kept_free)(void *kept);
    void *(*kept_share)(void *kept); /**< for a copy of the table: a copy, or the same with one owner more; NULL = no memory */
    /** The part of weight[sample] that its incidence has, where the other part makes the sum of f cos(theta_o) over an incidence
     * its reflectance; NULL: the weights are solid angles and no more. */
    double (*kept_incidence)(const void *kept, size_t sample);
    /** Where points lie that are by[k] of the distance to its neighbours away from a sample, as the file's function goes on from
     * it, and what f there weighs in a mean that is the sample's f: 0 below the horizon and outside. Returns 0 without memory.
     * NULL: what is between the samples follows from their directions. */
    int (*kept_around)(const void *kept, size_t sample, size_t n, const double (*by)[2], double (*wo)[3], double *weight);
    ff_cells *cells; /**< the cells over which the values are means, constant within each; NULL: values at points. Owned */
};

/** Releases what the table owns and zeroes it. A zeroed table and NULL are legal. */
void ff_table_clear(ff_table *t);

/** Allocates arrays for n samples (n >= 1) and n_channels (>= 1): values 0, all valid, scale 1, wavelengths NaN, names "c0"...
 *  With a grid, n must be grid->n and no angle planes are made. with_sigma, with_weight: also those planes. FF_ERR_MEMORY
 *  also when the sizes overflow. *out is overwritten, not freed. */
ff_status ff_table_init(size_t n, size_t n_channels, const ff_grid *grid, int with_sigma, int with_weight, ff_table *out,
                        ff_error *err);

/** How many of samples first .. first+count-1 there are. */
size_t ff_table_there(const ff_table *t, size_t first, size_t count);

/** ff_table_read and ff_table_read_with into a table of the caller's, which is overwritten, not freed; untouched on failure. */
ff_status ff_table_read_into(const char *path, const char *format, ff_table *out, ff_error *err);
ff_status ff_table_read_with_into(const char *path, const ff_read_options *o, ff_table *out, ff_error *err);

/** ff_table_write as one of `with` (base/internal_output.h); NULL: alone. */
ff_status ff_table_write_with(const char *path, const char *format, const ff_table *t, struct ff_outputs *with, ff_error *err);
/** ff_table_read_all into a table of the caller's. */
ff_status ff_table_read_all_into(const char *const *paths, size_t n, const ff_read_options *o, ff_table *out, ff_error *err);

/** Moves a table of the caller's to the heap: *t is zeroed, also on failure, when what it owns is released. FF_ERR_MEMORY. */
ff_status ff_table_move(ff_table *t, ff_table **out, ff_error *err);

/* ---- formats --------------------------------------------------------------------------------- */

/** Everything the program knows about one format; defined in one file. Immutable, static storage. */
struct ff_format {
    const char *name;       /**< "merl": key of --format                                                      */
    const char *title;      /**< one line for lists                                                           */
    const char *extensions; /**< usual ones, space separated, with the dot; a hint for writing, never for reading */
    const char *source;     /**< where the layout is documented                                               */
    /** Confidence 0..100 that a file is of this format, from its first n_head bytes (>= 0, without a UTF-8 byte-order mark) and
     *  its size (-1 = a stream). -1: no memory to tell. */
    int (*probe)(const unsigned char *head, size_t n_head, int64_t file_size);
    unsigned reads;        /**< FF_READS_...                                                                     */
    unsigned holds;        /**< FF_HOLDS_..., where it can be written                                            */
    const char *precision; /**< of written values without FF_HOLDS_DOUBLE: "32-bit float, 6e-8 relative"; else NULL */
    ff_status (*read)(const char *path, const ff_read_options *o, ff_table *out, ff_error *err);
    /** The pairs of directions that a file of this format has for data like t: a table with those directions (and grid or axes),
     *  channels named as in t (one channel may become several of the same content), scales as the format stores values, values 0,
     *  all valid. NULL: any directions.
     *  @param grid  what the format lets choose, as a text of its own; NULL = the usual.
     *  FF_ERR_SYNTAX, FF_ERR_RANGE for a grid that is none, FF_ERR_UNSUPPORTED for a t that cannot be held, FF_ERR_MEMORY. */
    ff_status (*layout)(const ff_table *t, const char *grid, ff_table *out, ff_error *err);
    /** NULL where the format cannot be written. Writes to a temporary name beside path, then renames; "-" is stdout.
     *  @param with  the outputs that it is one of (base/internal_output.h), which give it its name; NULL: alone.
     *  FF_ERR_UNSUPPORTED for directions that are not of its layout. */
    ff_status (*write)(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err);
};

/** The 90 x 90 x 180 half/difference-angle grid of Matusik et al. 2003 (samples at cell centres). */
extern const ff_grid ff_grid_merl;

#ifdef __cplusplus
}
#endif
#endif
