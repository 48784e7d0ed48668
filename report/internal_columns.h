/* Tables: an array of columns, each of which says what is in it. The same array is printed for people (text, Markdown, LaTeX) and
 * for programs (CSV, TSV: every digit, names without spaces).
 *
 * A new column is one entry of the array of its table; nothing is counted elsewhere, and there is no most. */
#ifndef FF_INTERNAL_COLUMNS_H
#define FF_INTERNAL_COLUMNS_H
#include "ff_report.h"
#include "internal_text.h"

enum { FF_CELL = 320 };

/* What stands in a cell. */
typedef struct ff_cell {
    char text[FF_CELL]; /* as people read it, "" = empty                                        */
    double number;      /* the same in all its digits, if is_number; NaN is empty in CSV        */
    int is_number;
    ff_ink ink; /* in text                                                             */
} ff_cell;

void ff_cell_text(ff_cell *cell, const char *format, ...) __attribute__((format(printf, 2, 3)));
void ff_cell_number(ff_cell *cell, double x, int significant);
void ff_cell_fixed(ff_cell *cell, double x, int decimals);
void ff_cell_exact(ff_cell *cell, double x);
/* x, as `text` for people. */
void ff_cell_rounded(ff_cell *cell, double x, const char *text);

typedef enum ff_align { FF_LEFT, FF_RIGHT } ff_align;
typedef enum ff_audience { FF_EVERYBODY, FF_PEOPLE, FF_PROGRAMS } ff_audience;

/* Which cell: of the thing that the table is of, in which row, and the column's index. */
typedef struct ff_where {
    const void *of;
    size_t row, index;
} ff_where;

typedef struct ff_column {
    const char *head; /* as people read it                                           */
    const char *key;  /* in CSV; NULL: the head, with '_' for spaces                 */
    ff_align align;
    ff_audience audience;
    int (*wanted)(const void *of);          /* NULL: always                                                */
    void (*cell)(ff_cell *out, ff_where w); /* *out is empty before                               */
    size_t index;                           /* for functions that serve several columns                    */
    unsigned drop;                          /* of text that is too wide the largest goes first; 0: stays   */
    unsigned least;                         /* its text is cut down to so many columns; 0: never           */
    int wraps;                              /* 1: of the last column, which goes on below instead          */
} ff_column;

/* Are these forms for programs? Then numbers have all their digits. */
int ff_table_form_exact(ff_table_form form);

/* Prints head and rows; text is indented, and in a style that has a width loses columns and ends of words until it fits. style:
 * NULL = plain. FF_ERR_MEMORY: nothing was printed. */
ff_status ff_columns_print(const ff_column *column, size_t n_columns, const void *of, size_t rows, ff_table_form form,
                           const char *indent, const ff_report_style *style, FILE *out);

/* A line about the table, under it: text, or a comment. Nothing in CSV. */
void ff_columns_remark(ff_table_form form, FILE *out, const char *format, ...) __attribute__((format(printf, 3, 4)));

#define FF_COUNT(array) (sizeof(array) / sizeof *(array))
#endif
