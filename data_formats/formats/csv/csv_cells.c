/* Cells that are no plain numbers, lines that hold a name and a number, and the option 'dialect'. */
#define _GNU_SOURCE
#include "internal_csv_look.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

enum { CELL = 64 };

/* ---- cells ------------------------------------------------------------------------------------- */

const char *ff_csv_skip_blanks(const char *p, const char *stop)
{
    while (p < stop && ff_csv_is_blank(*p)) p++;
    return p;
}

/* Start of the cell after the one at p, NULL at the end. Runs of blanks are one separator. */
const char *ff_csv_next_cell(const char *p, const char *stop, char separator)
{
    if (separator != ' ') return ff_csv_skip_cell(p, stop, separator);
    if (p < stop && *p == '"') p = ff_csv_skip_quoted(p, stop);
    while (p < stop && !ff_csv_is_blank(*p)) p++;
    p = ff_csv_skip_blanks(p, stop);
    return p < stop ? p : NULL;
}

size_t ff_csv_count_cells(const char *text, size_t length, char separator)
{
    const char *stop = text + length, *p = separator == ' ' ? ff_csv_skip_blanks(text, stop) : text;
    size_t n = 0;
    for (; p; p = ff_csv_next_cell(p, stop, separator)) n++;
    return n;
}

const char *ff_csv_cell(const char *text, size_t length, char separator, size_t k, size_t *cell_length)
{
    const char *stop = text + length, *p = separator == ' ' ? ff_csv_skip_blanks(text, stop) : text;
    for (; p && k; k--) p = ff_csv_next_cell(p, stop, separator);
    *cell_length = 0;
    if (!p) return text;
    const char *next = ff_csv_next_cell(p, stop, separator), *end = next ? next - (separator == ' ' ? 0 : 1) : stop;
    while (p < end && ff_csv_is_blank(*p)) p++;
    while (p < end && ff_csv_is_blank(end[-1])) end--;
    if (end - p >= 2 && (*p == '"' || *p == '\'') && end[-1] == *p) {
        p = ff_csv_skip_blanks(p + 1, end - 1);
        for (end--; p < end && ff_csv_is_blank(end[-1]);) end--;
    }
    *cell_length = (size_t)(end - p);
    return p;
}

/* ---- numbers ------------------------------------------------------------------------------------ */

/* What may follow a number in its cell: a sign of degrees (also in ISO-8859-1), of per cent, blanks. */
static int is_trailer(const char *p, const char *stop)
{
    for (; p < stop; p++)
        if (!strchr(" \t%", *p) && (unsigned char)*p != 0xB0 && (unsigned char)*p != 0xC2) return 0;
    return 1;
}

/* Groups of three digits before the decimal mark, one to three in the first. */
static int are_thousands(const char *cell, size_t length, char thousands, char decimal)
{
    const char *decimals = memchr(cell, decimal, length), *stop = decimals ? decimals : cell + length;
    const char *p = cell + (length && (*cell == '-' || *cell == '+'));
    size_t digits = 0, groups = 0;
    for (; p < stop; p++) {
        if (isdigit((unsigned char)*p)) {
            digits++;
        } else if (*p == thousands) {
            if (groups ? digits != 3 : digits == 0 || digits > 3) return 0;
            groups++;
            digits = 0;
        } else {
            break;
        }
    }
    return groups == 0 || digits == 3;
}

int ff_csv_number(const char *cell, size_t length, const ff_csv_dialect *d, double *value)
{
    char copy[CELL];
    size_t n = 0;
    const char decimal = d->decimal ? d->decimal : '.';
    if (length == 0 || length + 1 > sizeof copy) return 0;
    if (memchr(cell, decimal == ',' ? '.' : ',', length) && (!d->thousands || !are_thousands(cell, length, d->thousands, decimal)))
        return 0;
    size_t k = 0;
    for (; k < length; k++) {
        const char c = cell[k];
        if (d->thousands && c == d->thousands) continue;
        if (c == decimal)
            copy[n++] = '.';
        else if ((c == 'D' || c == 'd') && n > 0 && isdigit((unsigned char)copy[n - 1]))
            copy[n++] = 'e';
        else
            copy[n++] = c;
    }
    copy[n] = '\0';
    double v;
    const char *end = ff_number_read(copy + (*copy == '+'), &v);
    if (!end || !is_trailer(end, copy + n) || !isfinite(v)) return 0;
    *value = v;
    return 1;
}

/* ---- settings ------------------------------------------------------------------------------------- */

/* Past blanks, marks, and remarks in brackets; NULL where a word stands. */
static const char *skip_to_number(const char *p, const char *stop)
{
    while (p < stop && !isdigit((unsigned char)*p) && !strchr("+-.", *p)) {
        if (*p == '(' || *p == '[') {
            const char *close = memchr(p, *p == '(' ? ')' : ']', (size_t)(stop - p));
            if (!close) return NULL;
            p = close;
        } else if (isalpha((unsigned char)*p)) {
            return NULL;
        }
        p++;
    }
    return p < stop ? p : NULL;
}

int ff_csv_setting(const char *text, size_t length, const char *name, const ff_csv_dialect *dialect, double *value)
{
    const size_t n = strlen(name);
    const char *stop = text + length;
    for (const char *at = text; at + n < stop; at++) {
        if (strncasecmp(at, name, n) != 0 || isalnum((unsigned char)at[n]) || (at > text && isalnum((unsigned char)at[-1])))
            continue;
        const char *p = skip_to_number(at + n, stop), *end = p;
        if (!p) continue;
        while (end < stop && (isalnum((unsigned char)*end) || strchr("+-.", *end) || (*end == ',' && dialect->decimal == ',')))
            end++;
        while (end > p && isalpha((unsigned char)end[-1])) end--; /* "20deg" */
        while (end > p && (end[-1] == ',' || end[-1] == '.')) end--;
        if (ff_csv_number(p, (size_t)(end - p), dialect, value)) return 1;
    }
    return 0;
}

/* ---- the option ------------------------------------------------------------------------------------ */

static const struct {
    const char *name;
    char separator;
} separators[] = {{"comma", ','}, {"semicolon", ';'}, {"tab", '\t'}, {"bar", '|'}, {"blank", ' '}};

static int take_word(const char *key, size_t n, const char *value, size_t length, ff_csv_dialect *out)
{
    if (n == strlen("separator") && strncmp(key, "separator", n) == 0)
        for (size_t k = 0; k < sizeof separators / sizeof separators[0]; k++)
            if (strlen(separators[k].name) == length && strncmp(value, separators[k].name, length) == 0) {
                out->separator = separators[k].separator;
                return 1;
            }
    if (n != strlen("decimal") || strncmp(key, "decimal", n) != 0) return 0;
    const int comma = length == 5 && strncmp(value, "comma", 5) == 0, point = length == 5 && strncmp(value, "point", 5) == 0;
    if (comma || point) out->decimal = comma ? ',' : '.';
    return comma || point;
}

ff_status ff_csv_dialect_read(const char *text, const char *path, ff_csv_dialect *out, ff_error *err)
{
    *out = (ff_csv_dialect){0};
    for (const char *at = text; at && *at;) {
        char found[FF_QUOTE];
        at += strspn(at, " \t");
        const size_t all = strcspn(at, ","), n = strcspn(at, "=");
        if (n >= all || !take_word(at, n, at + n + 1, all - n - 1, out))
            return ff_error_set(
                err, FF_ERR_SYNTAX, path, 0, -1,
                "dialect: found %s, expected separator=comma, semicolon, tab, bar or blank, and decimal=point or comma",
                ff_quote(at, all, found));
        at += all + (at[all] == ',');
    }
    if (out->decimal && out->separator == out->decimal)
        return ff_error_set(err, FF_ERR_SYNTAX, path, 0, -1, "dialect: found a comma for both, expected another separator");
    return FF_OK;
}
