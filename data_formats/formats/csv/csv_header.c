/* Finding the header of somebody's CSV: the first line, comment or not, that has every column the mapping names. What stands before
 * it is passed over. A mapping that goes by numbers alone needs no header: then the first line is one, unless the cells asked for
 * are numbers. Cells are separated by commas, semicolons or tabs, whichever gives the header its names. */
#define _GNU_SOURCE
#include "internal_csv.h"
#include "base/internal_number.h"
#include <stdlib.h>
#include <string.h>

enum { HEADER_WITHIN = 1000 }; /* lines; a header further down is not looked for */

/* One name without blanks and quotes around it. */
static void take_name(const char *start, const char *stop, char **to)
{
    while (start < stop && ff_csv_is_blank(*start)) start++;
    while (start < stop && ff_csv_is_blank(stop[-1])) stop--;
    if (stop - start >= 2 && (*start == '"' || *start == '\'') && stop[-1] == *start) start++, stop--;
    memcpy(*to, start, (size_t)(stop - start));
    (*to)[stop - start] = '\0';
    *to += stop - start + 1;
}

/* Start of the next word, NULL after the last. A blank in double quotes is part of the word. */
static const char *skip_word(const char *p, const char *stop)
{
    if (p < stop && *p == '"') p = ff_csv_skip_quoted(p, stop);
    while (p < stop && !ff_csv_is_blank(*p)) p++;
    while (p < stop && ff_csv_is_blank(*p)) p++;
    return p < stop ? p : NULL;
}

static ff_status split_names(const char *text, size_t length, char separator, const char *path, long line, ff_names *out,
                             ff_error *err)
{
    const char *p = text, *stop = text + length;
    while (p < stop && (ff_csv_is_blank(*p) || *p == '#') && (*p != separator || separator == ' ')) p++;
    size_t most = 1;
    for (const char *c = p; c < stop; c++) most += (separator == ' ' ? ff_csv_is_blank(*c) : *c == separator) ? 1 : 0;
    if (most > FF_NAMES_MAX)
        return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "found %zu columns, expected at most %d", most, FF_NAMES_MAX);
    ff_names names = {.text = malloc((size_t)(stop - p) + most + 1), .name = malloc(most * sizeof *names.name)};
    if (!names.text || !names.name) {
        ff_names_free(&names);
        return ff_error_set(err, FF_ERR_MEMORY, path, line, -1, "no memory for %zu columns", most);
    }
    char *to = names.text;
    for (const char *next; p; p = next) {
        next = separator == ' ' ? skip_word(p, stop) : ff_csv_skip_cell(p, stop, separator);
        names.name[names.n++] = to;
        take_name(p, next ? next - 1 : stop, &to);
    }
    *out = names;
    return FF_OK;
}

/* How many of the named columns are among names. */
static size_t count_found(const ff_csv_mapping *map, const ff_names *names)
{
    size_t found = 0;
    int twice;
    for (size_t k = 0; k < map->n; k++) found += map->item[k].column && ff_csv_item_find(&map->item[k], names, &twice) != SIZE_MAX;
    return found;
}

static size_t count_named(const ff_csv_mapping *map)
{
    size_t named = 0;
    for (size_t k = 0; k < map->n; k++) named += map->item[k].column != NULL;
    return named;
}

/* The way of cutting a line that finds most of the named columns. */
static ff_status best_split(const ff_csv_mapping *map, const char *text, size_t length, const char *path, long line, ff_names *out,
                            char *separator, ff_error *err)
{
    const char separators[] = {',', ';', '\t', *separator && !strchr(",;\t", *separator) ? *separator : '\0', '\0'};
    size_t best = 0;
    *out = (ff_names){0};
    for (const char *s = separators; *s; s++) {
        ff_names names;
        if (s > separators && !memchr(text, *s, length)) continue;
        ff_status status = split_names(text, length, *s, path, line, &names, err);
        if (status == FF_ERR_FORMAT) continue;
        if (status != FF_OK) {
            ff_names_free(out);
            return status;
        }
        size_t score = count_found(map, &names) * FF_NAMES_MAX * 2 + names.n;
        if (score > best) {
            ff_names_free(out);
            *out = names;
            *separator = *s;
            best = score;
        } else {
            ff_names_free(&names);
        }
    }
    return FF_OK;
}

int ff_csv_layout_probe(const ff_csv_layout *layout, const unsigned char *head, size_t n)
{
    ff_csv_mapping map;
    if (memchr(head, '\0', n)) return 0;
    ff_status status = ff_csv_mapping_read(layout->columns, "", &map, NULL);
    if (status != FF_OK) return status == FF_ERR_MEMORY ? -1 : 0;
    const char *p = (const char *)head, *stop = p + n;
    int found = 0;
    for (int line = 0; p < stop && line < 20 && !found; line++) {
        const char *end = memchr(p, '\n', (size_t)(stop - p));
        size_t length = (size_t)((end ? end : stop) - p);
        if (length && p[length - 1] == '\r') length--;
        ff_names names;
        char separator = ',';
        status = best_split(&map, p, length, "", 0, &names, &separator, NULL);
        if (status != FF_OK) break;
        found = names.n && count_found(&map, &names) == count_named(&map);
        ff_names_free(&names);
        p = end ? end + 1 : stop;
    }
    ff_csv_mapping_free(&map);
    return status == FF_ERR_MEMORY ? -1 : found;
}

/* "theta_i:grad" where the file has a column theta_i, or "20:grad": what stands behind the ':' is meant for a unit. */
static const char *unit_meant(const ff_csv_item *item, const ff_csv_header *h)
{
    const char *colon = item->exact || item->number >= 0 ? NULL : strrchr(item->column, ':');
    if (!colon) return NULL;
    double v;
    const size_t n = (size_t)(colon - item->column);
    const char *end = ff_number_read(item->column, &v);
    int known = end == colon;
    for (size_t k = 0; k < h->names.n; k++) known |= strlen(h->names.name[k]) == n && !strncmp(h->names.name[k], item->column, n);
    return known ? colon + 1 : NULL;
}

ff_status ff_csv_missing_column(const ff_csv_item *item, const ff_csv_header *h, const char *path, ff_error *err)
{
    char found[FF_NAMES_LIST], quoted[FF_QUOTE];
    const char *hint = item->column == item->text ? "; say which it is, as in phi_i=0" : "";
    const char *unit = unit_meant(item, h);
    if (unit)
        return ff_error_set(err, FF_ERR_FORMAT, path, h->line, -1, "%s: found the unit %s, expected %s", item->text,
                            ff_quote(unit, strlen(unit), quoted), FF_CSV_UNITS);
    if (item->number >= 0)
        return ff_error_set(err, FF_ERR_FORMAT, path, h->line, -1, "found %zu columns, expected a column %ld for %s", h->names.n,
                            item->number + 1, item->text);
    return ff_error_set(err, FF_ERR_FORMAT, path, h->line, -1, "found the columns %s, expected one %s for %s%s",
                        ff_names_list(&h->names, found), ff_quote(item->column, strlen(item->column), quoted), item->text, hint);
}

static int is_number(const char *name)
{
    double v;
    const char *end = ff_number_read(name, &v);
    return end && !*end;
}

/* Whether a line is a row: the cells asked for are numbers. */
static int is_row(const ff_csv_mapping *map, const ff_names *names)
{
    int twice;
    for (size_t k = 0; k < map->n; k++) {
        size_t column = ff_csv_item_find(&map->item[k], names, &twice);
        if (column != SIZE_MAX && *names->name[column] && !is_number(names->name[column])) return 0;
    }
    return 1;
}

ff_status ff_csv_foreign_comment(ff_csv_head *head, int *ours, char *text, int after_header, const ff_lines *lines, ff_error *err)
{
    *ours |= strstr(text, "facetfit-csv:") != NULL;
    return *ours ? ff_csv_comment(head, text, after_header, lines->path, lines->line, err) : FF_OK;
}

typedef struct search {
    ff_lines *lines;
    const ff_csv_mapping *map;
    ff_csv_head *head;
    ff_error *err;
    ff_csv_header h;
    char rows_separator; /* of the rows, 0: not known */
    size_t nearest;      /* score of the line whose names are in h */
    int done;
} search;

/* Looks at one line; `done` when it is the header. Keeps the names of the line that comes nearest. */
static ff_status try_line(search *s, char *text, size_t length)
{
    ff_names names;
    char separator = s->rows_separator ? s->rows_separator : ',';
    const size_t blanks = strspn(text, " \t");
    const int comment = text[blanks] == '#' || (text[blanks] == '"' && text[blanks + 1] == '#');
    ff_status status = best_split(s->map, text, length, s->lines->path, s->lines->line, &names, &separator, s->err);
    if (status != FF_OK) return status;
    const size_t found = count_found(s->map, &names), named = count_named(s->map), score = 2 * found + (comment ? 0 : 1);
    s->done = names.n && (named ? found == named : !comment);
    if (names.n && (s->done || score > s->nearest)) {
        ff_names_free(&s->h.names);
        s->h.names = names;
        s->h.dialect.separator = separator;
        s->h.line = s->lines->line;
        s->nearest = score;
    } else {
        ff_names_free(&names);
    }
    if (s->done) {
        if (!named && is_row(s->map, &s->h.names)) s->h.first_row = text, s->h.first_row_length = length;
        return FF_OK;
    }
    s->h.passed_over += !comment;
    return comment ? ff_csv_foreign_comment(s->head, &s->h.ours, text + blanks, 0, s->lines, s->err) : FF_OK;
}

static ff_status not_found(const search *s)
{
    int twice;
    if (!s->h.names.n)
        return ff_error_set(s->err, FF_ERR_READ, s->lines->path, s->lines->line, -1,
                            "found the end of the file, expected a header line with the columns that the option 'columns' names");
    for (size_t k = 0; k < s->map->n; k++)
        if (s->map->item[k].column && ff_csv_item_find(&s->map->item[k], &s->h.names, &twice) == SIZE_MAX)
            return ff_csv_missing_column(&s->map->item[k], &s->h, s->lines->path, s->err);
    return ff_error_set(s->err, FF_ERR_FORMAT, s->lines->path, s->lines->line, -1,
                        "found no header line within %d lines, expected one", HEADER_WITHIN);
}

ff_status ff_csv_header_find(ff_lines *lines, const ff_csv_mapping *map, ff_csv_head *head, ff_csv_header *out, ff_error *err)
{
    search s = {.lines = lines,
                .map = map,
                .head = head,
                .err = err,
                .rows_separator = out->dialect.separator,
                .h = {.dialect = out->dialect}};
    ff_status status = FF_OK;
    while (status == FF_OK && !s.done && lines->line < HEADER_WITHIN) {
        char *text;
        size_t length;
        status = ff_lines_next(lines, &text, &length, err);
        if (status != FF_OK || !text) break;
        if (text[strspn(text, " \t")]) status = try_line(&s, text, length);
    }
    if (status == FF_OK && !s.done) status = not_found(&s);
    if (status == FF_OK)
        *out = s.h;
    else
        ff_names_free(&s.h.names);
    return status;
}

int ff_csv_mapping_by_number(const ff_csv_mapping *map)
{
    return count_named(map) == 0;
}

ff_status ff_csv_header_skip(ff_lines *lines, size_t first_row, size_t n_columns, ff_csv_head *head, ff_csv_header *out,
                             ff_error *err)
{
    ff_names names = {calloc(1, 1), malloc((n_columns + 1) * sizeof *names.name), n_columns};
    ff_status status = FF_OK;
    if (!names.text || !names.name)
        status = ff_error_set(err, FF_ERR_MEMORY, lines->path, 0, -1, "no memory for %zu columns", n_columns);
    for (size_t k = 0; k < n_columns && status == FF_OK; k++) names.name[k] = names.text;
    while (status == FF_OK && lines->line + 1 < (long)first_row) {
        char *text;
        size_t length;
        status = ff_lines_next(lines, &text, &length, err);
        if (status != FF_OK || !text) break;
        const size_t blanks = strspn(text, " \t");
        const int comment = text[blanks] == '#' || (text[blanks] == '"' && text[blanks + 1] == '#');
        if (comment && lines->line != out->line) status = ff_csv_foreign_comment(head, &out->ours, text + blanks, 0, lines, err);
        out->passed_over += !comment && text[blanks] && lines->line < out->line;
    }
    if (status == FF_OK)
        out->names = names;
    else
        ff_names_free(&names);
    return status;
}
