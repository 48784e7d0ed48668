/* Rows of numbers: reading one, and keeping them until their number is known. */
#define _GNU_SOURCE
#include "internal_table.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { CHUNK_BYTES = 1 << 20 }; /* more than FF_NAMES_MAX columns of doubles, with their sigmas */

/* Mapped, not malloc'ed: the C library may keep freed chunks for itself, and then rows and table would be in memory at once. */
struct ff_row_chunk {
    struct ff_row_chunk *previous;
    size_t n, capacity;
    double rows[];
};

size_t ff_rows_width(size_t n_channels, int with_sigma, int with_weight)
{
    return 4 + n_channels * (with_sigma ? 2 : 1) + (with_weight ? 1 : 0);
}

static struct ff_row_chunk *chunk_new(size_t width)
{
    size_t room = (CHUNK_BYTES - sizeof(struct ff_row_chunk)) / sizeof(double);
    struct ff_row_chunk *c = mmap(NULL, CHUNK_BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (c == MAP_FAILED) return NULL;
    c->capacity = room / width;
    return c;
}

double *ff_rows_add(ff_rows *rows)
{
    if (!rows->last || rows->last->n == rows->last->capacity) {
        struct ff_row_chunk *c = chunk_new(rows->width);
        if (!c) return NULL;
        c->previous = rows->last;
        rows->last = c;
    }
    double *row = rows->last->rows + rows->last->n * rows->width;
    rows->last->n++;
    rows->n++;
    return row;
}

static void drop_last(ff_rows *rows)
{
    struct ff_row_chunk *previous = rows->last->previous;
    munmap(rows->last, CHUNK_BYTES);
    rows->last = previous;
}

void ff_rows_free(ff_rows *rows)
{
    while (rows->last) drop_last(rows);
    rows->n = 0;
}

/* Sample i of the table from one row. */
static void take_row(const double *row, size_t i, ff_table *t)
{
    for (int k = 0; k < 4; k++) t->angle[k][i] = *row++;
    for (size_t c = 0; c < t->n_channels; c++, row++) {
        if (isnan(*row)) t->valid[i] = 0;
        t->value[c * t->n + i] = isnan(*row) ? 0 : *row;
    }
    if (t->sigma)
        for (size_t c = 0; c < t->n_channels; c++, row++) t->sigma[c * t->n + i] = isnan(*row) ? 0 : *row;
    if (t->weight) t->weight[i] = *row;
}

ff_status ff_rows_to_table(ff_rows *rows, size_t n_channels, int with_sigma, int with_weight, ff_table *out, ff_error *err)
{
    ff_table t;
    ff_status status = ff_table_init(rows->n, n_channels, NULL, with_sigma, with_weight, &t, err);
    if (status == FF_OK) {
        size_t i = rows->n;
        for (; rows->last; drop_last(rows))
            for (size_t k = rows->last->n; k-- > 0;) take_row(rows->last->rows + k * rows->width, --i, &t);
        *out = t;
    }
    ff_rows_free(rows);
    return status;
}

static int is_space(char c)
{
    return c == ' ' || c == '\t';
}

/* ---- names ----------------------------------------------------------------------------------- */

/* Copies one name to *to and ends it there; returns where the next one starts, NULL at the end. */
static const char *take_name(const char *p, const char *stop, char **to)
{
    while (p < stop && is_space(*p)) p++;
    char *start = *to, *q = start;
    if (p < stop && *p == '"') {
        for (p++; p < stop && (*p != '"' || (p + 1 < stop && p[1] == '"')); p++) {
            if (*p == '"') p++;
            *q++ = *p;
        }
        while (p < stop && *p != ',') p++; /* the closing quote, and spaces */
    } else {
        while (p < stop && *p != ',') *q++ = *p++;
        while (q > start && is_space(q[-1])) q--;
    }
    *q++ = '\0';
    *to = q;
    return p < stop ? p + 1 : NULL;
}

static ff_status check_name(const ff_names *names, size_t k, const char *path, long line, ff_error *err)
{
    char found[FF_QUOTE];
    const char *name = names->name[k];
    size_t length = strlen(name);
    if (length == 0) return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "column %zu: found no name, expected one", k + 1);
    ff_quote(name, length, found);
    if (length >= FF_CHANNEL_NAME)
        return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "column %zu: found the name %s of %zu bytes, expected at most %d",
                            k + 1, found, length, FF_CHANNEL_NAME - 1);
    for (const char *p = name; *p; p++)
        if ((unsigned char)*p < 0x20 || *p == 0x7F)
            return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "column %zu: found the name %s, expected no control characters",
                                k + 1, found);
    for (size_t j = 0; j < k; j++)
        if (strcmp(names->name[j], name) == 0)
            return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found column %s twice (columns %zu and %zu), expected it once",
                                found, j + 1, k + 1);
    return FF_OK;
}

ff_status ff_names_read(const char *text, size_t length, const char *path, long line, ff_names *out, ff_error *err)
{
    size_t most = 1;
    for (size_t i = 0; i < length; i++) most += text[i] == ',';
    if (most > FF_NAMES_MAX)
        return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found %zu columns, expected at most %d", most, FF_NAMES_MAX);
    ff_names names = {.text = malloc(length + most + 1), .name = malloc(most * sizeof *names.name)};
    ff_status status = FF_OK;
    if (!names.text || !names.name) status = ff_error_set(err, FF_ERR_MEMORY, path, line, -1, "no memory for %zu columns", most);
    char *to = names.text;
    for (const char *p = text; p && status == FF_OK; names.n++) {
        names.name[names.n] = to;
        p = take_name(p, text + length, &to);
        status = check_name(&names, names.n, path, line, err);
    }
    if (status != FF_OK)
        ff_names_free(&names);
    else
        *out = names;
    return status;
}

void ff_names_free(ff_names *names)
{
    free(names->text);
    free(names->name);
    *names = (ff_names){0};
}

const char *ff_names_list(const ff_names *names, char out[FF_NAMES_LIST])
{
    size_t used = 0;
    out[0] = '\0';
    for (size_t k = 0; k < names->n; k++) {
        char name[FF_QUOTE];
        size_t length = strlen(ff_quote(names->name[k], strlen(names->name[k]), name)) - 2; /* without the quotes */
        if (used + length + 8 > FF_NAMES_LIST) {
            strcpy(out + used, ", ...");
            break;
        }
        if (used) used += (size_t)(stpcpy(out + used, ", ") - (out + used));
        memcpy(out + used, name + 1, length);
        out[used += length] = '\0';
    }
    return out;
}

/* ---- cells ----------------------------------------------------------------------------------- */

static size_t count_cells(const char *text)
{
    size_t n = 1;
    for (; *text; text++) n += *text == ',';
    return n;
}

/* The cell that could not be read at once: empty, quoted, or wrong. */
static ff_status read_odd_cell(const char *start, const char *stop, size_t column, const ff_columns *columns, double *value,
                               const char *path, long line, ff_error *err)
{
    while (start < stop && is_space(*start)) start++;
    while (start < stop && is_space(stop[-1])) stop--;
    const char *name = columns->names[column], *all = start, *all_stop = stop;
    if (stop - start >= 2 && *start == '"' && stop[-1] == '"') {
        for (start++, stop--; start < stop && is_space(*start);) start++;
        while (start < stop && is_space(stop[-1])) stop--;
        const char *end = ff_number_read(start, value);
        if (end == stop && isfinite(*value)) return FF_OK;
    }
    if (ff_number_read_fortran(start, (size_t)(stop - start), value)) return FF_OK;
    if (start == stop && columns->may_be_empty[column]) {
        *value = NAN;
        return FF_OK;
    }
    if (columns->may_be_empty[column] && columns->n_errors && ff_table_is_missing_word(start, (size_t)(stop - start))) {
        *value = NAN;
        *columns->n_errors += 1;
        return FF_OK;
    }
    char found[FF_QUOTE];
    const char *what = start == stop ? "an empty cell" : ff_quote(all, (size_t)(all_stop - all), found);
    const char *hint = columns->may_be_empty[column] ? "; leave the cell empty where nothing was measured" : "";
    if (memchr(start, ';', (size_t)(stop - start))) hint = ", columns separated by ',' and not by ';'";
    return ff_error_set(err, FF_ERR_DATA, path, line, -1, "column '%s': found %s, expected a finite number%s", name, what, hint);
}

static ff_status wrong_count(const char *text, const ff_columns *columns, const char *path, long line, ff_error *err)
{
    size_t found = count_cells(text);
    const char *hint = found > columns->n ? " (decimal commas are not numbers here: write 1.5, not 1,5)" : "";
    if (strchr(text, ';')) hint = " (columns are separated by ',' and not by ';')";
    return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found %zu cells, expected %zu, one per column%s", found, columns->n,
                        hint);
}

ff_status ff_row_read(const char *text, size_t length, const ff_columns *columns, double *row, const char *path, long line,
                      ff_error *err)
{
    const char *p = text, *stop = text + length;
    for (size_t k = 0; k < columns->n; k++) {
        while (is_space(*p)) p++;
        double value = 0;
        const char *end = ff_number_read(p, &value);
        if (end)
            while (is_space(*end)) end++;
        if (!end || (end != stop && *end != ',') || !isfinite(value)) {
            const char *comma = memchr(p, ',', (size_t)(stop - p));
            end = comma ? comma : stop;
            ff_status status = read_odd_cell(p, end, k, columns, &value, path, line, err);
            if (status != FF_OK) return count_cells(text) == columns->n ? status : wrong_count(text, columns, path, line, err);
        }
        row[columns->slot[k]] = value;
        if ((end == stop) != (k + 1 == columns->n)) return wrong_count(text, columns, path, line, err);
        p = end + 1;
    }
    return FF_OK;
}
