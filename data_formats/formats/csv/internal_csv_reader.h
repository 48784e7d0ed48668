/** @file internal_csv_reader.h  Reading a table with a mapping: what its columns are (csv_columns.c), what its rows hold
 * (csv_rows.c). */
#ifndef FF_INTERNAL_CSV_READER_H
#define FF_INTERNAL_CSV_READER_H
#include "internal_csv_look.h"

/** Numbers of a row that are not in the table: angles that its own follow from, and the phase. */
enum { FF_FAR_ANGLES = 4, FF_FAR_VECTORS = 6, FF_FAR_PHASE = FF_FAR_ANGLES + FF_FAR_VECTORS, FF_FAR };

/** One column that is read: where it stands in the file, and in a row or (place = FF_CSV_FAR + ...) beside it. */
enum { FF_CSV_FAR = 1 << 20 };
typedef struct ff_csv_want {
    const ff_csv_item *item;
    size_t column, place;
    double factor, offset;
} ff_csv_want;

typedef struct ff_csv_reader {
    ff_lines lines;
    ff_error *err;
    const char *path;
    const ff_csv_layout *layout; /**< NULL: a mapping of the person's, or of what the names say */
    const ff_csv_plan *plan;     /**< NULL: the mapping is not that of a plan               */
    ff_csv_look look;
    ff_csv_mapping map;
    ff_csv_head head;
    ff_csv_header header;
    size_t n_channels;
    int with_sigma, with_weight, with_wavelength, with_phase, with_half, with_vectors;
    const ff_csv_item *at; /**< f@ANGLE, or NULL             */
    size_t at_place, n_settings, n_set;
    size_t n_wants;
    ff_csv_want *wants; /**< [n_wants] by column */
    ff_csv_want *set;   /**< [n_settings] those of lines of their own */
    double *initial;    /**< [width] a row with its constants */
    double *row;        /**< [width] a row of the file, where it makes several of the table */
    double *side;       /**< [at->n_at] values side by side */
    ff_rows rows;
    double far[FF_FAR], far_initial[FF_FAR];
    double phase_off[2]; /**< largest difference, were azimuth 0 the side of the light [0], of the mirror [1]    */
    size_t n_missing;    /**< cells with a word for what was not measured */
    size_t n_blank;      /**< rows without a number where they should have one: padding */
    size_t n_repeats;    /**< lines that repeat the names */
    char missing[16];    /**< the first of these words */
} ff_csv_reader;

ff_status ff_csv_no_memory(const ff_csv_reader *r);

/** Channels of the rows: the wavelength is one more. */
size_t ff_csv_row_channels(const ff_csv_reader *r);

/** Reads all rows after the header into r->rows. FF_ERR_FORMAT, FF_ERR_DATA, FF_ERR_READ, FF_ERR_MEMORY. */
ff_status ff_csv_rows_read(ff_csv_reader *r);

#endif
