/* Two summaries beside each other: what moved by more than its errors. */
#define _GNU_SOURCE
#include "internal_batch.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "report/internal_columns.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- reading --------------------------------------------------------------------------------- */

/* What every summary begins with; parameters follow in pairs. */
enum { FILE_CELL, JSON_CELL, STATE_CELL, MODEL_CELL, CHANNELS_CELL, OUTCOME_CELL, QUALITY_CELL, FIXED_CELLS = 14 };
static const char head_begins[] = "file,json,state,model,channels,outcome,quality,";

/* The cells of a line of CSV, in place; NULL after the last. */
static char *next_cell(char **rest)
{
    char *from = *rest, *to = from, *cell = from;
    if (!from) return NULL;
    int quoted = *from == '"';
    for (from += quoted; *from && (quoted || *from != ','); from++) {
        if (quoted && *from == '"') {
            if (from[1] != '"') {
                quoted = 0;
                continue;
            }
            from++;
        }
        *to++ = *from;
    }
    *rest = *from ? from + 1 : NULL;
    *to = '\0';
    return cell;
}

static size_t split(char *line, char **cell, size_t most)
{
    size_t n = 0;
    char *rest = line;
    for (char *c; (c = next_cell(&rest)); n++)
        if (n < most) cell[n] = c;
    return n;
}

static ff_status no_memory(const char *path, ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the summary");
}

static ff_status add_line(batch_table *t, const char *text, const char *path, long line, ff_error *err)
{
    const size_t at = t->n_columns ? t->n + 1 : 0;
    if (at == t->room) {
        const size_t room = 2 * t->room + 64;
        char **lines = realloc(t->line, room * sizeof *lines);
        if (lines) t->line = lines;
        char ***cells = realloc(t->cell, room * sizeof *cells);
        if (cells) t->cell = cells;
        if (!lines || !cells) return no_memory(path, err);
        t->room = room;
    }
    char *copy = strdup(text), *counted = strdup(text);
    const size_t n = counted ? split(counted, NULL, 0) : 0;
    char **cell = calloc(n + 1, sizeof *cell);
    free(counted);
    if (!copy || !n || !cell) {
        free(copy);
        free(cell);
        return no_memory(path, err);
    }
    split(copy, cell, n);
    t->line[at] = copy;
    t->cell[at] = cell;
    if (!t->n_columns)
        t->n_columns = n;
    else
        t->n++;
    if (n == t->n_columns) return FF_OK;
    return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found %zu cells, expected the %zu of the first line", n, t->n_columns);
}

ff_status batch_table_read(const char *path, batch_table *out, ff_error *err)
{
    ff_lines lines;
    char *text;
    size_t length;
    *out = (batch_table){.n = 0};
    ff_status status = ff_lines_open(path, &lines, err);
    if (status != FF_OK) return status;
    while ((status = ff_lines_next(&lines, &text, &length, err)) == FF_OK && text) {
        if (!out->n_columns && strncmp(text, head_begins, sizeof head_begins - 1) != 0)
            status = ff_error_set(err, FF_ERR_FORMAT, path, 1, -1,
                                  "is no summary as --summary NAME.csv writes it: expected '%s...'", head_begins);
        if (status == FF_OK) status = add_line(out, text, path, lines.line, err);
        if (status != FF_OK) break;
    }
    ff_lines_close(&lines);
    if (status == FF_OK && !out->n_columns) return ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "is empty, expected a summary");
    return status;
}

void batch_table_free(batch_table *t)
{
    for (size_t i = 0; t->n_columns && i <= t->n; i++) {
        free(t->line[i]);
        free(t->cell[i]);
    }
    free(t->line);
    free(t->cell);
    *t = (batch_table){.n = 0};
}

/* ---- comparing ------------------------------------------------------------------------------- */

void batch_changes_free(batch_changes *c)
{
    free(c->change);
    *c = (batch_changes){.n = 0};
}

static ff_status add(batch_changes *c, const batch_change *change)
{
    if (c->n == c->room) {
        const size_t room = 2 * c->room + 64;
        batch_change *larger = realloc(c->change, room * sizeof *larger);
        if (!larger) return FF_ERR_MEMORY;
        c->change = larger;
        c->room = room;
    }
    c->change[c->n++] = *change;
    return FF_OK;
}

static int by_file(const void *a, const void *b)
{
    char *const *p = *(char **const *)a, *const *q = *(char **const *)b;
    const int order = strcmp(p[FILE_CELL], q[FILE_CELL]);
    return order ? order : strcmp(p[CHANNELS_CELL], q[CHANNELS_CELL]);
}

static char ***sorted(const batch_table *t)
{
    char ***row = malloc((t->n + 1) * sizeof *row);
    if (row) memcpy(row, t->cell + 1, t->n * sizeof *row);
    if (row) qsort(row, t->n, sizeof *row, by_file);
    return row;
}

static double number_of(const char *text)
{
    double x;
    const char *end = *text ? ff_number_read(text, &x) : NULL;
    return end && !*end ? x : NAN;
}

/* Where a column of this name stands in the other table; 0: nowhere. */
static size_t column_in(const batch_table *t, const char *name, size_t from)
{
    for (size_t k = FIXED_CELLS; k + 1 < t->n_columns; k += 2) {
        const size_t at = from >= FIXED_CELLS && from + 1 < t->n_columns
                              ? (from - FIXED_CELLS + k - FIXED_CELLS) % (t->n_columns - FIXED_CELLS) + FIXED_CELLS
                              : k;
        if (!strcmp(t->cell[0][at], name)) return at;
    }
    return 0;
}

/* In errors; infinite where there are none and it moved, 0 where it did not. */
static double moved(double x, double y, double error_x, double error_y)
{
    const double error = hypot(isnan(error_x) ? 0 : error_x, isnan(error_y) ? 0 : error_y), difference = fabs(x - y);
    if (error > 0) return difference / error;
    return difference > FF_FITS_TIE * fmax(fabs(x), fabs(y)) ? INFINITY : 0;
}

static ff_status compare_values(const batch_table *before, const batch_table *after, char **x, char **y, double limit,
                                batch_changes *out)
{
    for (size_t k = FIXED_CELLS, at = FIXED_CELLS; k + 1 < after->n_columns; k += 2) {
        const size_t old = column_in(before, after->cell[0][k], at);
        if (!old) continue;
        at = old + 2;
        const double a = number_of(x[old]), b = number_of(y[k]);
        if (isnan(a) && isnan(b)) continue;
        const double errors = isnan(a) || isnan(b) ? NAN : moved(a, b, number_of(x[old + 1]), number_of(y[k + 1]));
        if (errors <= limit) continue;
        const batch_change c = {y[FILE_CELL], y[CHANNELS_CELL], after->cell[0][k], x[old], y[k], errors};
        const ff_status status = add(out, &c);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

/* Parameters of another model are others. */
static ff_status compare_rows(const batch_table *before, const batch_table *after, char **x, char **y, double limit,
                              batch_changes *out)
{
    static const struct {
        size_t cell;
        const char *what;
    } words[] = {{STATE_CELL, "state"}, {MODEL_CELL, "model"}, {OUTCOME_CELL, "outcome"}, {QUALITY_CELL, "quality"}};
    out->n_rows++;
    for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
        if (!strcmp(x[words[k].cell], y[words[k].cell])) continue;
        const batch_change c = {y[FILE_CELL], y[CHANNELS_CELL], words[k].what, x[words[k].cell], y[words[k].cell], NAN};
        const ff_status status = add(out, &c);
        if (status != FF_OK) return status;
    }
    if (strcmp(x[MODEL_CELL], y[MODEL_CELL]) != 0) return FF_OK;
    return compare_values(before, after, x, y, limit, out);
}

ff_status batch_changes_find(const batch_table *before, const batch_table *after, double limit, batch_changes *out)
{
    *out = (batch_changes){.n = 0};
    char ***x = sorted(before), ***y = sorted(after);
    ff_status status = x && y ? FF_OK : FF_ERR_MEMORY;
    for (size_t i = 0, k = 0; status == FF_OK && (i < before->n || k < after->n);) {
        const int order = i == before->n ? 1 : k == after->n ? -1 : by_file(&x[i], &y[k]);
        if (order == 0)
            status = compare_rows(before, after, x[i], y[k], limit, out);
        else if (order < 0)
            status = add(out, &(batch_change){x[i][FILE_CELL], x[i][CHANNELS_CELL], "file", "there", "", NAN});
        else
            status = add(out, &(batch_change){y[k][FILE_CELL], y[k][CHANNELS_CELL], "file", "", "there", NAN});
        i += order <= 0;
        k += order >= 0;
    }
    free(x);
    free(y);
    return status;
}

/* ---- the table of it ------------------------------------------------------------------------- */

static const batch_change *at(ff_where w)
{
    return &((const batch_changes *)w.of)->change[w.row];
}

static void text_cell(ff_cell *out, ff_where w)
{
    const batch_change *c = at(w);
    const char *const text[] = {c->file, c->channels, c->what};
    ff_cell_text(out, "%.300s", text[w.index]);
}

/* Numbers with all their digits for programs. */
static void side_cell(ff_cell *out, ff_where w)
{
    const char *text = w.index ? at(w)->after : at(w)->before;
    const double x = number_of(text);
    if (isnan(x))
        ff_cell_text(out, "%.300s", text);
    else
        ff_cell_number(out, x, 6);
}

static void errors_cell(ff_cell *out, ff_where w)
{
    if (!isnan(at(w)->errors)) ff_cell_number(out, at(w)->errors, 3);
}

static const ff_column change_columns[] = {
    {.head = "file", .cell = text_cell, .index = 0},  {.head = "channels", .cell = text_cell, .index = 1, .drop = 1},
    {.head = "what", .cell = text_cell, .index = 2},  {.head = "before", .cell = side_cell, .index = 0},
    {.head = "after", .cell = side_cell, .index = 1}, {.head = "errors", .align = FF_RIGHT, .cell = errors_cell},
};

ff_status batch_changes_table(const batch_changes *c, ff_table_form form, const ff_report_style *style, FILE *out)
{
    if (!c->n && form == FF_TABLE_TEXT) return FF_OK;
    return ff_columns_print(change_columns, FF_COUNT(change_columns), c, c->n, form, "", style, out);
}
