/* Text for people: columns that line up, numbers with the digits they deserve. */
#ifndef FF_INTERNAL_TEXT_H
#define FF_INTERNAL_TEXT_H
#include "ff_status.h"
#include <stddef.h>
#include <stdio.h>

enum { FF_TEXT_COLUMNS = 16, FF_TEXT_CELL = 320, FF_TEXT_NUMBER = 48 };

/* Columns that text takes on a terminal: code points, wide ones twice, combining marks none. */
size_t ff_text_width(const char *text);

/* Length of the valid UTF-8 sequence at text, 0 when there is none. */
size_t ff_text_sequence(const char *text, uint32_t *code);

/* A table that grows by rows and prints itself with columns two spaces apart. Zero-initialise. */
typedef struct ff_text_table {
    size_t columns, rows, capacity;
    char **cell;                   /* [rows][FF_TEXT_COLUMNS] */
    char   right[FF_TEXT_COLUMNS]; /* 1: the column is flush right */
    int    failed;                 /* an allocation failed: print reports it */
} ff_text_table;

void ff_text_row(ff_text_table *t); /* starts a row */
/* The next cell of the last row. */
void ff_text_cell(ff_text_table *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
ff_status ff_text_print(ff_text_table *t, FILE *out, const char *indent); /* prints and releases */

/* `significant` digits, in plain or exponent notation as fits. Independent of the locale, as are the others. */
const char *ff_text_number(double x, int significant, char out[FF_TEXT_NUMBER]);
/* A fixed number of digits after the point. */
const char *ff_text_fixed(double x, int decimals, char out[FF_TEXT_NUMBER]);
/* Value and standard error, both cut at the second digit of the error; six digits and "-" where the error is not known. */
void ff_text_with_error(double value, double error, char out[FF_TEXT_NUMBER], char out_error[FF_TEXT_NUMBER]);
/* The shortest text that reads back as the same double; "nan", "inf", "-inf". */
const char *ff_text_exact(double x, char out[FF_TEXT_NUMBER]);

#endif
