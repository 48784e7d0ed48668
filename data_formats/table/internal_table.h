/** @file internal_table.h  What the formats share: rows of numbers on their way into a table, and checks of whole tables. */
#ifndef FF_INTERNAL_TABLE_H
#define FF_INTERNAL_TABLE_H
#include "table_struct.h"
#include <math.h>

/** 1 for a sample all of whose channels are numbers. Readers refuse files with others, but a program may put an infinity or a NaN
 *  into a table: that was not measured. */
static inline int ff_table_is_measured(const ff_table *t, size_t i)
{
    int measured = t->valid[i] != 0;
    for (size_t c = 0; c < t->n_channels && measured; c++) measured = isfinite(t->value[c * t->n + i]);
    return measured;
}

/* ---- rows.c: a text file's rows, whose number is not known before its end -------------------- */

struct ff_row_chunk;

/** Rows of `width` numbers, in chunks, so that growing copies nothing and each chunk is released as the table takes it over. */
typedef struct ff_rows {
    size_t width, n;
    struct ff_row_chunk *last;
} ff_rows;

/** Numbers of a row: theta_i, phi_i, theta_o, phi_o; one per channel (NaN = not measured); with_sigma: one per channel;
 *  with_weight: one. */
size_t ff_rows_width(size_t n_channels, int with_sigma, int with_weight);

/** Room for one more row of rows->width numbers, zeroed; NULL when memory is out. */
double *ff_rows_add(ff_rows *rows);
void ff_rows_free(ff_rows *rows);

/** Makes a table of the rows, which must be at least one, and frees them, also on failure. A sample with a value that was not
 *  measured is invalid; that value becomes 0. FF_ERR_MEMORY. */
ff_status ff_rows_to_table(ff_rows *rows, size_t n_channels, int with_sigma, int with_weight, ff_table *out, ff_error *err);

/** Reads the comma-separated numbers of one line into row[slot[k]], k = 0 .. n_columns-1. Spaces and quotes around a number are
 *  legal. Empty cells give NaN where may_be_empty[k], else an error, as does everything that is not a finite number and a
 *  wrong number of cells. names[k] are for the messages: FF_ERR_DATA for a cell, FF_ERR_FORMAT for the count, with path and line.
 */
typedef struct ff_columns {
    size_t n;
    char *const *names;
    const size_t *slot;
    const unsigned char *may_be_empty;
    size_t *n_errors; /**< counts cells with the word of an error of a spreadsheet, which are as if empty; NULL: they are refused */
} ff_columns;
ff_status ff_row_read(const char *text, size_t length, const ff_columns *columns, double *row, const char *path, long line,
                      ff_error *err);

/** A header line cut at its commas; spaces and quotes around a name are dropped, "" inside quotes is a quote. */
typedef struct ff_names {
    char *text;
    char **name; /**< [n], into text */
    size_t n;
} ff_names;
enum { FF_NAMES_MAX = 4096 };
/** FF_ERR_MEMORY; FF_ERR_FORMAT for more than FF_NAMES_MAX names, an empty, overlong, doubled or unprintable one. */
ff_status ff_names_read(const char *text, size_t length, const char *path, long line, ff_names *out, ff_error *err);
void ff_names_free(ff_names *names);
/** The names in one string for a message, cut when there are many. */
enum { FF_NAMES_LIST = 240 };
const char *ff_names_list(const ff_names *names, char out[FF_NAMES_LIST]);

/* ---- table.c --------------------------------------------------------------------------------- */

/** Appends a sentence to t->note, on a line of its own; what does not fit any more is left out whole. */
void ff_table_note(ff_table *t, const char *fmt, ...) __attribute__((format(printf, 2, 3)));
/** The same, with what the caller can say to it. */
void ff_table_note_hint(ff_table *t, ff_hint hint, const char *fmt, ...) __attribute__((format(printf, 3, 4)));

/** The four angles of samples first .. first+count-1 in another unit (radians per unit): as stored where it is the same, so that
 *  writing loses nothing; of a grid from its directions. out[k] [count]. */
void ff_table_angles(const ff_table *t, double unit, size_t first, size_t count, double *const out[4]);

/** A table on the product of four lists of nodes (copied), its angle planes filled from them; see ff_axes. FF_ERR_MEMORY. */
ff_status ff_table_init_axes(ff_axes_kind kind, const size_t n[4], const double *const node[4], double radians_per_unit,
                             size_t n_channels, int with_weight, ff_table *out, ff_error *err);

/** theta_i, phi_i, theta_o, phi_o of one point q of four axes, all in the same unit; axes.c has the formulas. Of
 * FF_AXES_INCIDENT_EXIT these are q itself, to the bit. */
void ff_axes_angles(ff_axes_kind kind, double radians_per_unit, const double q[4], double angle[4]);
/** The same, to the bit, of all samples of the product in their order into four planes. 0 when there is no memory. */
int ff_axes_fill(const ff_axes *axes, double radians_per_unit, double *const angle[4]);

/** The inverse: the point q of four axes (radians, azimuths in (-pi, pi]) of a pair of unit vectors wi, wo above the horizon. An
 *  azimuth that the pair leaves open is 0. Not of FF_AXES_NONE. */
void ff_axes_point(ff_axes_kind kind, const double wi[3], const double wo[3], double q[4]);

/** Solid angle per radian of azimuth, cos(lower edge) - cos(upper edge), of the bands around n ascending polar angles (times unit:
 *  radians) into band [n]. Neighbours meet half way; the first and the last reach as far outward as inward, though not beyond the
 *  normal and the horizon; one alone is the hemisphere. */
void ff_polar_bands(const double *node, size_t n, double unit, double *band);

/** t->weight of a table on axes: the product of a factor from each, factor[k] [t->axes.n[k]]. */
void ff_table_product_weights(ff_table *t, const double *const factor[4]);

/** The values just read are of this quantity: sets t->quantity and converts to the BRDF: f cos(theta_o) is divided by the cosine
 * (and the sample invalid where that is at most FF_COS_MIN), pi f gets its scale. Values, sigmas; call once. */
void ff_table_set_quantity(ff_table *t, ff_quantity quantity);

/** Takes angles as the person says (ff_azimuth, ff_phi_sense, ff_angles). What belonged to directions as they were (axes, cells) is
 * gone then. FF_ERR_MEMORY; the table is then to be cleared. */
ff_status ff_table_orient(ff_table *t, const ff_read_options *o, ff_error *err);

/** What the values of t were before the reader converted them: undoes ff_table_set_quantity. */
void ff_table_unset_quantity(ff_table *t);

/** The quantity that the person says, else the one given. */
ff_quantity ff_read_quantity(const ff_read_options *o, ff_quantity in_file);

/** Names a table's channels as those of `from`, with their wavelengths; from's only channel names them all r, g, b where t has 3.
 */
void ff_table_name_channels_like(ff_table *t, const ff_table *from);

/** 1 when every sample has the same phi_i. */
int ff_table_one_incidence_azimuth(const ff_table *t);

/** Marks as not measured what holds a code for that, as -9999: a value far below all others of its channel. A note counts them.
 * Before a quantity is made another one: a code divided by a cosine is none. */
void ff_table_leave_out_codes(ff_table *t);

/** 1 for words that stand in a cell for what was not measured: nan, N/A, -, *, null, and errors of spreadsheets as #DIV/0!. Blanks
 *  and quotes around them are cut already. */
int ff_table_is_missing_word(const char *cell, size_t length);

/** 1 for a value that ff_table_leave_out_codes takes for a code. */
int ff_table_is_code(double v);

/** 1 for a table in degrees whose angles can only be radians: polar angles up to a right angle of these, and among azimuths within
 * a turn some that are multiples of a right angle. */
int ff_table_has_radian_azimuths(const ff_table *t);

/** Counts invalid and negative samples. FF_ERR_DATA when no sample is valid. */
ff_status ff_table_count(ff_table *t, const char *path, ff_error *err);

/** The end of a reader: counts, and moves the table to *out; on failure (no valid sample) frees it. */
ff_status ff_table_hand_out(ff_table *t, const char *path, ff_table *out, ff_error *err);

/** What every writer requires: finite angles, weights >= 0, and of valid samples finite values and standard deviations > 0; at
 *  least one valid sample.
 *  FF_ERR_DATA names the sample. */
ff_status ff_table_check(const ff_table *t, const char *path, ff_error *err);

/** Wavelength in nm that a channel name like "465nm", "465.5 nm" or "0.45 um" stands for, else NaN. */
double ff_wavelength_of(const char *name);
#endif
