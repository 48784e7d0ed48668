/** @file internal_csv.h  What the readers of comma-separated tables share: comment lines, and columns that a mapping names. */
#ifndef FF_INTERNAL_CSV_H
#define FF_INTERNAL_CSV_H
#include "base/internal_input.h"
#include "data_formats/table/internal_table.h"

/* ---- csv_mapping.c: a text that says which columns of a file are ours -------------------------- */

/** What a column can be. The first four are the places of the angles in a row. */
typedef enum ff_csv_key {
    FF_CSV_THETA_I,
    FF_CSV_PHI_I,
    FF_CSV_THETA_O,
    FF_CSV_PHI_O,
    FF_CSV_VALUE,
    FF_CSV_SIGMA,
    FF_CSV_WEIGHT,
    FF_CSV_WAVELENGTH,
    FF_CSV_PHASE,
    FF_CSV_THETA_H, /**< half and difference angles (Rusinkiewicz 1998), in place of the four angles */
    FF_CSV_PHI_H,
    FF_CSV_THETA_D,
    FF_CSV_PHI_D,
    FF_CSV_WI_X, /**< components of vectors towards light and detector, in place of the four angles */
    FF_CSV_WI_Y,
    FF_CSV_WI_Z,
    FF_CSV_WO_X,
    FF_CSV_WO_Y,
    FF_CSV_WO_Z
} ff_csv_key;
enum { FF_CSV_KEYS = FF_CSV_WO_Z + 1 };

typedef enum ff_csv_unit {
    FF_CSV_PLAIN, /**< not said: degrees, nm, the quantity's own                                */
    FF_CSV_DEGREES,
    FF_CSV_RADIANS,
    FF_CSV_NM,
    FF_CSV_UM,
    FF_CSV_M,
    FF_CSV_PERCENT,   /**< of f: hundredths; of sigma: hundredths of the value of f                 */
    FF_CSV_ELEVATION, /**< of a polar angle: degrees above the surface                        */
    FF_CSV_ELEVATION_RADIANS
} ff_csv_unit;

/** One "key=column:unit". */
typedef struct ff_csv_item {
    ff_csv_key key;
    const char *text;    /**< the key as written, for messages                                                    */
    const char *channel; /**< of FF_CSV_VALUE and FF_CSV_SIGMA: NAME of f_NAME, "" of plain f and sigma           */
    const char *column;  /**< name in the file, "a|b" for either; NULL where number or constant stands for it     */
    int exact;           /**< the name was in quotes: '|' is part of it                                           */
    long number;         /**< #3 is 2; -1: none                                                                   */
    double constant;     /**< NaN: none                                                                           */
    const char *setting; /**< "@Incidence": the name before a number on lines of their own; NULL: none            */
    size_t n_at;         /**< of f@ANGLE: columns side by side, one a value of the angle; 0: none                 */
    double *at;          /**< [n_at] the values, in the item's unit                                               */
    ff_csv_key at_key;   /**< which of the four angles                                                            */
    ff_csv_unit unit;
} ff_csv_item;

typedef struct ff_csv_mapping {
    size_t n;
    ff_csv_item *item; /**< [n], strings into text                                                              */
    char *text;
    double *at; /**< what the items' at point into                                                              */
} ff_csv_mapping;

/** Reads "theta_i=incidence,f=#4,phi_i=0". FF_ERR_SYNTAX, FF_ERR_UNKNOWN (a key that is none), FF_ERR_MEMORY; messages name path
 *  and the item. An angle that is not named is looked for under our own name of it. */
ff_status ff_csv_mapping_read(const char *text, const char *path, ff_csv_mapping *out, ff_error *err);
void ff_csv_mapping_free(ff_csv_mapping *m);

/** The place of an item's column among names: its number, SIZE_MAX where there is none. *twice is set when two have the name. */
size_t ff_csv_item_find(const ff_csv_item *item, const ff_names *names, int *twice);

/* ---- csv_cells.c: cells that are no plain numbers ------------------------------------------------- */

/** How a table is written. 0 of a member: not known. */
typedef struct ff_csv_dialect {
    char separator; /**< ',' ';' '\t' '|', or ' ' for runs of blanks and tabs */
    char decimal;   /**< '.' or ','                                           */
    char thousands; /**< what may stand in a number and means nothing         */
    int latin;      /**< 1: not all is UTF-8                                  */
} ff_csv_dialect;

/** Reads "separator=semicolon,decimal=comma"; NULL: nothing is known. FF_ERR_SYNTAX, FF_ERR_UNKNOWN. */
ff_status ff_csv_dialect_read(const char *text, const char *path, ff_csv_dialect *out, ff_error *err);

/** The number in a cell: with the dialect's decimal mark, an exponent after D as Fortran writes it, a sign of degrees or per cent
 *  behind it. 0 when it is none that is finite. */
int ff_csv_number(const char *cell, size_t length, const ff_csv_dialect *dialect, double *value);

/** The number behind a name on a line: "# Incidence (deg) = 20". 0 when the line is none such. */
int ff_csv_setting(const char *text, size_t length, const char *name, const ff_csv_dialect *dialect, double *value);

/* ---- csv_comments.c ------------------------------------------------------------------------------ */

/** What "# key: value" lines before the header say. */
typedef struct ff_csv_head {
    ff_quantity quantity;
    double radians_per_unit;
    int isotropic;                         /**< -1: not said */
    int quantity_is_said, angles_are_said; /**< the file has these words */
    int is_ours;                           /**< it says "facetfit-csv": the angles are as docs/csv.md has them */
} ff_csv_head;

/** One comment line; it is changed. Comments that say nothing to us are FF_OK. FF_ERR_FORMAT. */
ff_status ff_csv_comment(ff_csv_head *h, char *text, int after_header, const char *path, long line, ff_error *err);

/** What may stand behind the ':' of a column. */
#define FF_CSV_UNITS ":deg, :rad, :elevation or :elevation-rad of an angle, :nm, :um or :m of a wavelength, :% of a value"

/** 1 for the name of a column that says that its values are the BRDF. */
int ff_csv_names_brdf(const char *name);

/* ---- csv_header.c ---------------------------------------------------------------------------------- */

typedef struct ff_csv_header {
    ff_names names;
    ff_csv_dialect dialect;
    long line, passed_over; /**< its number; lines before it that are no comments                           */
    int loose;              /**< cells at the end that nobody asks for may be missing                     */
    int ours;               /**< its comments are in our words: it says "facetfit-csv", or its angles are   */
    const char *first_row;  /**< the line found where the file has no header, valid until the next is read  */
    size_t first_row_length;
} ff_csv_header;

/** Reads lines up to the header. *out is written only on FF_OK; the caller frees its names. FF_ERR_FORMAT tells the columns of the
 *  line that comes nearest. */
ff_status ff_csv_header_find(ff_lines *lines, const ff_csv_mapping *map, ff_csv_head *head, ff_csv_header *out, ff_error *err);

/** Passes over the lines before line first_row, where all columns go by number; out->line, the line of the names, is the caller's.
 * The names are n_columns empty ones. */
ff_status ff_csv_header_skip(ff_lines *lines, size_t first_row, size_t n_columns, ff_csv_head *head, ff_csv_header *out,
                             ff_error *err);

/** 1 when no column of the mapping goes by name. */
int ff_csv_mapping_by_number(const ff_csv_mapping *map);

/** FF_ERR_FORMAT: the item's column is not among those of the header. */
ff_status ff_csv_missing_column(const ff_csv_item *item, const ff_csv_header *h, const char *path, ff_error *err);

/** A comment line of somebody's file, which means something only where the file says that it is ours. */
ff_status ff_csv_foreign_comment(ff_csv_head *head, int *ours, char *text, int after_header, const ff_lines *lines, ff_error *err);

static inline int ff_csv_is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/** From a double quote to that which ends it, of which two together are one character of what is quoted; stop where there is none.
 */
static inline const char *ff_csv_skip_quoted(const char *p, const char *stop)
{
    for (p++; p < stop; p++) {
        if (*p != '"') continue;
        if (p + 1 == stop || p[1] != '"') break;
        p++;
    }
    return p;
}

/** Start of the next cell, NULL after the last. A separator in double quotes is part of the cell. */
static inline const char *ff_csv_skip_cell(const char *p, const char *stop, char separator)
{
    while (p < stop && *p == ' ') p++;
    if (p < stop && *p == '"') p = ff_csv_skip_quoted(p, stop);
    while (p < stop && *p != separator) p++;
    return p < stop ? p + 1 : NULL;
}

/* ---- csv_columns.c: reading a file with a mapping ------------------------------------------------ */

/** A layout of somebody's CSV files that is described by a mapping. */
typedef struct ff_csv_layout {
    const char *format;  /**< name of the format                                                                  */
    const char *columns; /**< its mapping                                                                         */
    ff_quantity quantity;
    int zero_sigma_is_small; /**< 1: a standard deviation of 0 is below what the instrument resolves       */
    const char *note;        /**< sentence on what is read of such files, or NULL                                      */
} ff_csv_layout;

/** 1 when one of the first lines at head has all the columns of the layout; -1: no memory. */
int ff_csv_layout_probe(const ff_csv_layout *layout, const unsigned char *head, size_t n);

/** Reads a file whose columns the layout names, or o->columns where layout is NULL. */
ff_status ff_csv_read_columns(const char *path, const ff_read_options *o, const ff_csv_layout *layout, ff_table *out,
                              ff_error *err);

struct ff_csv_look;

/** Reads a table whose columns are what their names say; `look` is of the same file. FF_ERR_FORMAT also where the names say too
 * little: the message has the option that would read it. */
ff_status ff_csv_read_table(const char *path, const ff_read_options *o, struct ff_csv_look *look, ff_table *out, ff_error *err);

/* ---- csv_pivot.c: one row per wavelength becomes one channel per wavelength ------------------------ */

/** `rows` has two channels, the values and their wavelengths in nm; part chooses wavelengths ("532nm,633nm"; NULL: docs/csv.md).
 *  *out is a table of one channel per wavelength. FF_ERR_DATA, FF_ERR_UNKNOWN, FF_ERR_SYNTAX (part), FF_ERR_MEMORY. */
ff_status ff_csv_pivot(const ff_table *rows, const char *part, const char *path, ff_table *out, ff_error *err);

/** "532nm", for a channel's name: nm to 1e-6. */
void ff_csv_wavelength_name(double nm, char out[FF_CHANNEL_NAME]);

#endif
