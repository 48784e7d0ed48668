/** @file published_sheet.h  Published tables of parameters as sheets of named columns, for the tests that simulate them. */
#ifndef PUBLISHED_SHEET_H
#define PUBLISHED_SHEET_H
#include "fit_samples.h"

enum { SHEET_ROWS = 128, SHEET_COLUMNS = 48, SHEET_CELL = 32 };

/** Row 0 holds the names of the columns, rows 1 .. rows - 1 one material each. */
typedef struct sheet {
    size_t rows, columns;
    char cell[SHEET_ROWS][SHEET_COLUMNS][SHEET_CELL];
} sheet;

/** Reads a file with commas between cells; a cell may be empty. 0 when it is not there. */
static inline int sheet_read_file(const char *name, sheet *s)
{
    char line[4096];
    FILE *f = fopen(name, "r");
    if (!f) return 0;
    s->rows = 0;
    while (s->rows < SHEET_ROWS && fgets(line, sizeof line, f)) {
        char *rest = line, *word;
        size_t columns = 0;
        line[strcspn(line, "\r\n")] = 0;
        while (columns < SHEET_COLUMNS && (word = strsep(&rest, ",")))
            snprintf(s->cell[s->rows][columns++], SHEET_CELL, "%.31s", word);
        if (s->rows == 0) s->columns = columns;
        if (columns > 1 && columns != s->columns) {
            printf("%s: row %zu has %zu columns, the first %zu\n", name, s->rows, columns, s->columns);
            exit(1);
        }
        s->rows += columns > 1;
    }
    fclose(f);
    return s->rows > 1;
}

/** The same of the shared material (see ff_test_shared). */
static inline int sheet_read(const char *name, sheet *s)
{
    char path[1024];
    return ff_test_shared(name, path, sizeof path) && sheet_read_file(path, s);
}

/** The number in a row under a name; a name or a cell that is none ends the program. */
static inline double sheet_number(const sheet *s, size_t row, const char *column)
{
    for (size_t k = 0; k < s->columns; k++) {
        char *end;
        if (strcmp(s->cell[0][k], column) != 0) continue;
        const double value = strtod(s->cell[row][k], &end);
        if (end != s->cell[row][k] && *end == 0) return value;
        printf("%s of %s is no number: '%s'\n", column, s->cell[row][0], s->cell[row][k]);
        exit(1);
    }
    printf("the test itself is wrong: no column %s\n", column);
    exit(1);
}

/** The same of a column that there is for each of three channels, "name_r", "name_g", "name_b". */
static inline double sheet_channel(const sheet *s, size_t row, const char *column, size_t c)
{
    char name[SHEET_CELL];
    snprintf(name, sizeof name, "%s_%c", column, "rgb"[c]);
    return sheet_number(s, row, name);
}

/** Rows of the materials in the order of a seeded shuffle, into row [SHEET_ROWS]; the count. */
static inline size_t sheet_shuffle(const sheet *s, uint64_t seed, size_t *row)
{
    const size_t n = s->rows - 1;
    for (size_t i = 0; i < n; i++) row[i] = i + 1;
    for (size_t i = 0; i < n; i++) {
        const size_t k = i + fit_random(&seed) % (n - i), swap = row[i];
        row[i] = row[k];
        row[k] = swap;
    }
    return n;
}

#endif
