/** @file internal_csv_look.h  The beginning of a table: how it is written, where its rows begin, what its columns are. */
#ifndef FF_INTERNAL_CSV_LOOK_H
#define FF_INTERNAL_CSV_LOOK_H
#include "internal_csv.h"

enum { FF_CSV_LOOK_BYTES = 1 << 17, FF_CSV_LOOK_LINES = 250 };

typedef struct ff_csv_line {
    const char *text;
    size_t length;
    size_t cells; /**< by the dialect                                         */
    size_t full;  /**< cells up to the last one that is not empty             */
    int is_row;
    int is_comment;
} ff_csv_line;

/** The first lines of a file. */
typedef struct ff_csv_look {
    char *bytes;
    size_t n_bytes;
    int whole; /**< the file has no more                                     */
    size_t n_lines;
    ff_csv_line *line; /**< line k has the number k + 1                        */
    ff_csv_dialect dialect;
    int is_ours;      /**< in our own words, comma-separated: the rest is not filled, since format_csv.c reads it */
    int our_angles;   /**< else: in our own words but for names of values that say what these are, as "reflectance (%)" */
    long mixed;       /**< number of a line whose decimal mark is another than that of others; 0: all the same */
    size_t first_row; /**< number of the first line with numbers; 0: none      */
} ff_csv_look;

/** Looks at path and finds the dialect, unless `given` says it (its members that are not 0). FF_ERR_OPEN, FF_ERR_READ,
 * FF_ERR_MEMORY. A pipe other than standard input has nothing to look at: no lines. */
ff_status ff_csv_look_at(const char *path, const ff_csv_dialect *given, ff_csv_look *out, ff_error *err);
void ff_csv_look_clear(ff_csv_look *look);

/** Past blanks; and the start of the cell after the one at p, NULL at the end: runs of blanks are one separator. */
const char *ff_csv_skip_blanks(const char *p, const char *stop);
const char *ff_csv_next_cell(const char *p, const char *stop, char separator);

/** Cell k of a line cut by separator, without blanks and quotes around it; *length 0 for what is not there. */
const char *ff_csv_cell(const char *text, size_t length, char separator, size_t k, size_t *cell_length);
size_t ff_csv_count_cells(const char *text, size_t length, char separator);

/** 1 when the beginning of a file has a line with two numbers or more, whatever separates them; -1: no memory to tell. */
int ff_csv_looks_like_table(const unsigned char *head, size_t n);

/** csv_ours.c: sets is_ours and our_angles. Looks at lines alone. */
void ff_csv_look_for_ours(ff_csv_look *look);

/** The probe of the format: 100 for our own, less for what looks like a table; JSON and XML are none. */
int ff_csv_probe(const unsigned char *head, size_t n, int64_t file_size);

/** The text of the option 'columns' that reads the table, as its names say, with what had to be assumed. */
typedef struct ff_csv_plan {
    char *columns;      /**< to be freed                                       */
    size_t header_line; /**< 0: none                                            */
    size_t first_row;
    ff_quantity quantity;
    int says_quantity; /**< 1: a name says that this is what the values are */
    char notes[1024];  /**< sentences, a line each                               */
    int scan;          /**< no azimuth: a scan in the plane of incidence, positive on the side of the mirror direction */
} ff_csv_plan;

/** angles: an ff_angles. FF_ERR_FORMAT: what the columns mean cannot be told; the message has the option that would. FF_ERR_MEMORY.
 */
ff_status ff_csv_plan_make(const ff_csv_look *look, const char *path, int angles, ff_csv_plan *out, ff_error *err);
void ff_csv_plan_clear(ff_csv_plan *plan);

#endif
