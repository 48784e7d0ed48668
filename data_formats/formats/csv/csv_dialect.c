/* How a table is written: what separates its cells, which mark is the decimal one. Found from the first lines: the separator by
 * which most lines fall into cells that are numbers, as many in each. */
#define _GNU_SOURCE
#include "internal_csv_look.h"
#include "internal_csv_meaning.h"
#include "base/internal_input.h"
#include "base/internal_plain.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- lines ------------------------------------------------------------------------------------- */

static ff_status cut_lines(ff_csv_look *look)
{
    char *p = look->bytes, *stop = p + look->n_bytes;
    const char ends = memchr(p, '\n', look->n_bytes) ? '\n' : '\r';
    look->line = calloc(FF_CSV_LOOK_LINES, sizeof *look->line);
    if (!look->line) return FF_ERR_MEMORY;
    while (p < stop && look->n_lines < FF_CSV_LOOK_LINES) {
        char *end = memchr(p, ends, (size_t)(stop - p));
        if (!end && !look->whole) break;
        size_t length = (size_t)((end ? end : stop) - p);
        while (length && p[length - 1] == '\r') length--;
        const char *start = ff_csv_skip_blanks(p, p + length);
        const size_t quoted = start + 1 < p + length && *start == '"' && start[1] == '#';
        look->line[look->n_lines++] =
            (ff_csv_line){.text = p, .length = length, .is_comment = start < p + length && (*start == '#' || quoted)};
        p = end ? end + 1 : stop;
    }
    return FF_OK;
}

static ff_status read_head(const char *path, ff_csv_look *look, ff_error *err)
{
    int fd;
    int64_t size;
    ff_status status = ff_input_look(path, &fd, &size, err);
    if (status != FF_OK) return status;
    size_t got = 0;
    if (size >= 0) {
        const size_t room = size < FF_CSV_LOOK_BYTES ? (size_t)size + 1 : FF_CSV_LOOK_BYTES;
        look->bytes = malloc(room + 1);
        status = look->bytes ? ff_input_read(fd, path, 0, look->bytes, room, &got, err)
                             : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory to look at it");
        look->whole = got < room;
    }
    ff_input_unlook(path, fd, got);
    if (status != FF_OK || !look->bytes) return status;
    const size_t mark = ff_byte_order_mark(look->bytes, got);
    memmove(look->bytes, look->bytes + mark, got - mark);
    look->n_bytes = got - mark;
    look->bytes[look->n_bytes] = '\0';
    return cut_lines(look) == FF_OK ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory to look at it");
}

/* ---- numbers ----------------------------------------------------------------------------------- */

enum { NO_NUMBER, WHOLE, POINTS, COMMAS, POINTS_IN_COMMAS, COMMAS_IN_POINTS, MISSING };

/* What a cell is, by its marks: digits with no mark; with one, or several, of one kind; with both, the decimal one last. */
static int kind_of(const char *p, size_t n)
{
    size_t points = 0, commas = 0, digits = 0, k = 0, last_point = 0, last_comma = 0;
    if (n == 0 || ff_table_is_missing_word(p, n)) return MISSING;
    if (*p == '+' || *p == '-') k++;
    for (; k < n && (isdigit((unsigned char)p[k]) || p[k] == '.' || p[k] == ','); k++) {
        digits += isdigit((unsigned char)p[k]) != 0;
        if (p[k] == '.') points++, last_point = k;
        if (p[k] == ',') commas++, last_comma = k;
    }
    if (!digits) return NO_NUMBER;
    if (k < n && strchr("eEdD", p[k])) {
        size_t start = ++k;
        if (k < n && (p[k] == '+' || p[k] == '-')) start = ++k;
        while (k < n && isdigit((unsigned char)p[k])) k++;
        if (k == start) return NO_NUMBER;
    }
    while (k < n && (p[k] == ' ' || p[k] == '%' || (unsigned char)p[k] == 0xB0 || (unsigned char)p[k] == 0xC2))
        k++; /* "20 %", "20°" */
    if (k < n) return NO_NUMBER;
    if (points && commas)
        return last_comma > last_point && commas == 1 ? POINTS_IN_COMMAS : points == 1 ? COMMAS_IN_POINTS : NO_NUMBER;
    return points > 1 || commas > 1 ? NO_NUMBER : points ? POINTS : commas ? COMMAS : WHOLE;
}

typedef struct trial {
    size_t rows, cells, columns; /* lines that are rows of `columns` cells; cells that are numbers in them  */
} trial;

/* Whether a line is a row: two numbers at least, and no more cells of another kind than numbers. */
static int looks_like_row(const ff_csv_line *l, char separator, size_t *cells, size_t *full, size_t *numbers)
{
    const char *stop = l->text + l->length, *p = separator == ' ' ? ff_csv_skip_blanks(l->text, stop) : l->text;
    size_t n = 0, others = 0, first_is_text = 0;
    *numbers = *full = 0;
    for (; p; n++) {
        const char *next = ff_csv_next_cell(p, stop, separator);
        size_t length;
        const char *cell = ff_csv_cell(p, (size_t)(stop - p), separator, 0, &length);
        const int kind = kind_of(cell, length);
        *numbers += kind != NO_NUMBER && kind != MISSING;
        others += kind == NO_NUMBER;
        if (n == 0 && kind == NO_NUMBER) first_is_text = 1;
        if (length) *full = n + 1;
        p = next;
    }
    *cells = n;
    if (first_is_text && *numbers >= 2) { /* "theta_o\phi_o,0,20,40" is a header */
        char name[FF_CHANNEL_NAME];
        ff_named named;
        size_t length;
        const char *cell = ff_csv_cell(l->text, l->length, separator, 0, &length);
        snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name - 1), cell);
        name[strcspn(name, "\\/|")] = '\0';
        ff_name_meaning(name, &named);
        if (named.meaning != FF_MEANS_NOTHING && named.meaning != FF_MEANS_NUMBER) return 0;
    }
    return *numbers >= 2 && others <= *numbers;
}

static trial try_separator(const ff_csv_look *look, char separator)
{
    trial best = {0};
    size_t columns[16], rows[16], cells_of[16], n_counts = 0;
    for (size_t k = 0; k < look->n_lines; k++) {
        size_t cells, full, numbers, j = 0;
        if (look->line[k].is_comment || !looks_like_row(&look->line[k], separator, &cells, &full, &numbers)) continue;
        while (j < n_counts && columns[j] != cells) j++;
        if (j == n_counts && n_counts < 16) {
            columns[j] = cells;
            rows[j] = cells_of[j] = 0;
            n_counts++;
        }
        if (j < n_counts) {
            rows[j]++;
            cells_of[j] += numbers;
        }
    }
    for (size_t j = 0; j < n_counts; j++)
        if (rows[j] > best.rows || (rows[j] == best.rows && columns[j] > best.columns))
            best = (trial){rows[j], cells_of[j], columns[j]};
    return best;
}

/* A tab among blanks may stand before an empty cell: of what reads the same, the first. */
static char best_separator(const ff_csv_look *look)
{
    static const char separators[] = "\t;|, ";
    char best = 0;
    trial most = {0};
    for (const char *s = separators; *s; s++) {
        const trial t = try_separator(look, *s);
        if (t.columns < 2 || (t.rows < most.rows || (t.rows == most.rows && t.cells <= most.cells))) continue;
        most = t;
        best = *s;
        if (t.cells == t.rows * t.columns && 2 * t.rows > look->n_lines) break; /* nothing but numbers: none can cut them further */
    }
    return best;
}

/* ---- decimal mark ------------------------------------------------------------------------------- */

static void find_decimal(ff_csv_look *look)
{
    size_t count[MISSING + 1] = {0}, of_commas = 0;
    const char separator = look->dialect.separator;
    for (size_t k = 0; k < look->n_lines; k++) {
        const ff_csv_line *l = &look->line[k];
        if (!l->is_row) continue;
        for (size_t c = 0; c < l->full; c++) {
            size_t length;
            const char *cell = ff_csv_cell(l->text, l->length, separator, c, &length);
            const int kind = kind_of(cell, length);
            count[kind]++;
            if (kind == COMMAS || kind == POINTS_IN_COMMAS) of_commas = k + 1;
        }
    }
    const size_t commas = count[COMMAS] + count[POINTS_IN_COMMAS], points = count[POINTS] + count[COMMAS_IN_POINTS];
    const int comma = commas > 0 && points == 0;
    look->dialect.decimal = comma ? ',' : '.';
    if (commas && points) {
        look->mixed = (long)of_commas;
        return;
    }
    if (comma ? count[POINTS_IN_COMMAS] : count[COMMAS_IN_POINTS]) look->dialect.thousands = comma ? '.' : ',';
}

/* ---- all of it ---------------------------------------------------------------------------------- */

static void mark_rows(ff_csv_look *look)
{
    for (size_t k = 0; k < look->n_lines; k++) {
        ff_csv_line *l = &look->line[k];
        size_t numbers;
        l->is_row = looks_like_row(l, look->dialect.separator, &l->cells, &l->full, &numbers) && !l->is_comment;
        if (l->is_row && !look->first_row) look->first_row = k + 1;
    }
}

static int is_latin(const ff_csv_look *look)
{
    for (size_t k = 0; k < look->n_lines; k++)
        if (!ff_plain_is_utf8(look->line[k].text, look->line[k].length)) return 1;
    return 0;
}

static void find_dialect(ff_csv_look *look, const ff_csv_dialect *given)
{
    look->dialect = *given;
    if (!given->separator) look->dialect.separator = best_separator(look);
    if (!look->dialect.separator) look->dialect.separator = ',';
    look->dialect.latin = is_latin(look);
    mark_rows(look);
    if (!given->decimal)
        find_decimal(look);
    else
        look->dialect.thousands = given->decimal == ',' ? '.' : ',';
}

ff_status ff_csv_look_at(const char *path, const ff_csv_dialect *given, ff_csv_look *out, ff_error *err)
{
    ff_csv_look look = {0};
    const ff_status status = read_head(path, &look, err);
    if (status != FF_OK) {
        ff_csv_look_clear(&look);
        return status;
    }
    if (!given->separator && !given->decimal) ff_csv_look_for_ours(&look);
    if (look.n_lines && !look.is_ours) find_dialect(&look, given);
    *out = look;
    return FF_OK;
}

int ff_csv_looks_like_table(const unsigned char *head, size_t n)
{
    ff_csv_look look = {.bytes = malloc(n + 1), .n_bytes = n};
    int found = -1;
    if (look.bytes) {
        memcpy(look.bytes, head, n);
        look.bytes[n] = '\0';
        look.whole = 1;
        if (cut_lines(&look) == FF_OK) {
            find_dialect(&look, &(ff_csv_dialect){0});
            found = look.first_row > 0;
        }
    }
    ff_csv_look_clear(&look);
    return found;
}

void ff_csv_look_clear(ff_csv_look *look)
{
    free(look->bytes);
    free(look->line);
    *look = (ff_csv_look){0};
}

/* ---- recognising it -------------------------------------------------------------------------- */

static int contains(const char *text, size_t length, const char *word)
{
    return memmem(text, length, word, strlen(word)) != NULL;
}

static int probe_lines(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    const char *p = (const char *)head, *stop = p + n;
    while (p < stop) {
        const char *end = memchr(p, '\n', (size_t)(stop - p));
        size_t length = (size_t)((end ? end : stop) - p);
        if (contains(p, length, "# facetfit-csv:")) return 100;
        while (length && strchr(" \t\r", *p)) p++, length--;
        if (length && *p != '#') {
            int separated = memchr(p, ',', length) || memchr(p, ';', length) || memchr(p, '\t', length);
            if (contains(p, length, "VARS ") || !separated) return 0;
            if (contains(p, length, "theta_i")) return 90;
            return memchr(p, ',', length) ? 10 : 5; /* somebody's table: our reader tells which columns it misses */
        }
        p = end ? end + 1 : stop;
    }
    return 0;
}

/* Something else whose text has commas: JSON, XML. */
static int is_other_language(const char *p, const char *stop)
{
    while (p < stop && strchr(" \t\r\n", *p)) p++;
    return p < stop && strchr("{[<", *p) != NULL;
}

int ff_csv_probe(const unsigned char *head, size_t n, int64_t file_size)
{
    if (memchr(head, '\0', n) || is_other_language((const char *)head, (const char *)head + n)) return 0;
    const int sure = probe_lines(head, n, file_size);
    if (sure) return sure;
    if (memmem(head, n, "VARS ", 5)) return 0;
    const int table = ff_csv_looks_like_table(head, n); /* somebody's, however it is written */
    return table > 0 ? 3 : table;
}
