/* Rows of somebody's table, with a mapping of its columns.
 *
 * A row of the file becomes one of the table, or several where values at several angles stand side by side. Directions may be given
 * as half and difference angles, or as vectors; then the row's four angles follow from them. */
#define _GNU_SOURCE
#include "internal_csv_reader.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;

typedef ff_csv_reader reader;
typedef ff_csv_want want;

ff_status ff_csv_no_memory(const ff_csv_reader *r)
{
    return ff_error_set(r->err, FF_ERR_MEMORY, r->path, r->lines.line, -1, "no memory for a table of %zu samples", r->rows.n + 1);
}

size_t ff_csv_row_channels(const reader *r)
{
    return r->n_channels + (r->with_wavelength ? 1 : 0);
}

/* ---- rows ------------------------------------------------------------------------------------ */

static ff_status bad_cell(const reader *r, const want *w, const char *start, const char *stop)
{
    char found[FF_QUOTE], key[FF_QUOTE];
    const int may_be_empty = w->item->key == FF_CSV_VALUE || w->item->key == FF_CSV_SIGMA;
    const int comma = memchr(start, ',', (size_t)(stop - start)) != NULL;
    const char *hint = comma          ? " with a decimal point and not a comma; say dialect decimal=comma"
                       : may_be_empty ? "; leave the cell empty where nothing was measured"
                                      : "";
    const ff_status status =
        ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1, "column %zu (%s): found %s, expected a finite number%s",
                     w->column + 1, ff_quote(w->item->text, strlen(w->item->text), key),
                     start == stop ? "an empty cell, or a word for one," : ff_quote(start, (size_t)(stop - start), found), hint);
    return ff_error_hint(r->err, status, comma ? FF_HINT_SAY : FF_HINT_NONE);
}

static int may_be_missing(const want *w)
{
    return w->item->key == FF_CSV_VALUE || w->item->key == FF_CSV_SIGMA;
}

/* A cell that could not be read at once: quoted, with another decimal mark, missing, or wrong. */
static ff_status read_odd_cell(reader *r, const want *w, const char *p, const char *stop, double *value)
{
    while (p < stop && ff_csv_is_blank(*p)) p++;
    while (stop > p && ff_csv_is_blank(stop[-1])) stop--;
    const char *start = p, *end = stop;
    if (stop - p >= 2 && (*p == '"' || *p == '\'') && stop[-1] == *p) {
        for (p++, stop--; p < stop && ff_csv_is_blank(*p);) p++;
        while (stop > p && ff_csv_is_blank(stop[-1])) stop--;
    }
    if (ff_csv_number(p, (size_t)(stop - p), &r->header.dialect, value)) return FF_OK;
    *value = NAN;
    if (p == stop) return may_be_missing(w) || !r->layout ? FF_OK : bad_cell(r, w, start, end);
    if (!ff_table_is_missing_word(p, (size_t)(stop - p))) return bad_cell(r, w, start, end);
    if (!r->n_missing && (size_t)(stop - p) < sizeof r->missing) memcpy(r->missing, p, (size_t)(stop - p));
    r->n_missing++;
    return FF_OK;
}

static const char *skip_cell(const char *p, const char *stop, char separator)
{
    if (separator != ' ') return ff_csv_skip_cell(p, stop, separator);
    if (p < stop && *p == '"') p = ff_csv_skip_quoted(p, stop);
    while (p < stop && !ff_csv_is_blank(*p)) p++;
    while (p < stop && ff_csv_is_blank(*p)) p++;
    return p < stop ? p : NULL;
}

/* One cell at p; *next is where the one after it starts, NULL at the end of the line. */
static ff_status read_cell(reader *r, const want *w, const char *p, const char *stop, double *value, const char **next)
{
    const ff_csv_dialect *d = &r->header.dialect;
    while (p < stop && ff_csv_is_blank(*p) && *p != d->separator) p++;
    const char *end = d->decimal == ',' && d->thousands ? NULL : ff_number_read(p, value);
    if (end && isfinite(*value)) {
        const char *behind = end;
        while (end < stop && ff_csv_is_blank(*end) && *end != d->separator) end++;
        if (end == stop || *end == d->separator || (d->separator == ' ' && end > behind)) {
            if (d->separator == ' ')
                while (end < stop && ff_csv_is_blank(*end)) end++;
            *next = end < stop ? end + (d->separator != ' ') : NULL;
            if (d->decimal != ',' || !memchr(p, '.', (size_t)(behind - p))) return FF_OK;
        }
    }
    *next = skip_cell(p, stop, d->separator);
    return read_odd_cell(r, w, p, !*next ? stop : d->separator == ' ' ? *next : *next - 1, value);
}

static ff_status wrong_count(const reader *r, size_t found)
{
    return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->lines.line, -1, "found %zu cells, expected %zu, one per column", found,
                        r->header.names.n);
}

static double *place_in(reader *r, double *row, size_t place)
{
    if (place < FF_CSV_FAR) return row + place;
    place -= FF_CSV_FAR;
    return place < FF_FAR ? &r->far[place] : &r->side[place - FF_FAR];
}

/* Cells beyond the header's must be empty, as spreadsheets leave them. */
static ff_status read_cells(reader *r, const char *text, size_t length, double *row)
{
    const char *p = text, *stop = text + length;
    size_t column = 0;
    if (r->header.dialect.separator == ' ')
        while (p < stop && ff_csv_is_blank(*p)) p++;
    for (size_t w = 0; w < r->n_wants;) {
        for (; p && column < r->wants[w].column; column++) p = skip_cell(p, stop, r->header.dialect.separator);
        if (!p) return wrong_count(r, column);
        double value;
        ff_status status = read_cell(r, &r->wants[w], p, stop, &value, &p);
        if (status != FF_OK) return status;
        for (; w < r->n_wants && r->wants[w].column == column; w++)
            *place_in(r, row, r->wants[w].place) = value * r->wants[w].factor + r->wants[w].offset;
        column++;
    }
    for (; p && column < r->header.names.n; column++) p = skip_cell(p, stop, r->header.dialect.separator);
    if (column < r->header.names.n && !r->header.loose) return wrong_count(r, column);
    for (size_t extra = column; p; extra++) {
        const char *next = skip_cell(p, stop, r->header.dialect.separator);
        for (const char *c = p; c < (next ? next - 1 : stop); c++)
            if (!ff_csv_is_blank(*c)) return wrong_count(r, extra + 1);
        p = next;
    }
    return FF_OK;
}

/* `found` is what stands in the row; the message has what stands in the file, too. */
static ff_status bad_value(const reader *r, size_t place, double found, const char *expected)
{
    char text[FF_NUMBER_TEXT + 1] = "an empty cell";
    const char *name = "a constant";
    double in_file = found;
    int percent = 0;
    for (size_t w = 0; w < r->n_wants; w++) {
        if (r->wants[w].place != place) continue;
        name = r->wants[w].item->text;
        in_file = (found - r->wants[w].offset) / r->wants[w].factor;
        percent |= r->wants[w].item->unit == FF_CSV_PERCENT;
    }
    if (percent) found = in_file;
    if (isfinite(found)) text[ff_number_write(found, text)] = '\0';
    if (isfinite(found) && fabs(in_file - found) > 1e-9 * fabs(found))
        return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1, "%s: found %.12g, which makes %.12g, expected %s",
                            name, in_file, found, expected);
    return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1, "%s: found %s, expected %s", name, text, expected);
}

/* The angle between the directions, were azimuth 0 of the detector on the side of the light [0] or of the mirror [1]. */
static void compare_phase(reader *r, const double *row)
{
    double u = r->head.radians_per_unit, along = cos(u * row[0]) * cos(u * row[2]);
    double across = sin(u * row[0]) * sin(u * row[2]) * cos(u * (row[3] - row[1]));
    for (int k = 0; k < 2; k++) {
        double c = along + (k ? -across : across);
        r->phase_off[k] = fmax(r->phase_off[k], fabs(acos(fmax(-1, fmin(1, c))) / degree - r->far[FF_FAR_PHASE]));
    }
}

static ff_status check_row(reader *r, double *row)
{
    const int radians = r->head.radians_per_unit == 1;
    const double theta_max = radians ? pi + 1e-9 : 180;
    for (size_t k = 0; k < 4; k += 2)
        if (fabs(row[k]) > theta_max)
            return bad_value(r, k, row[k], radians ? "radians from -pi to pi" : "degrees from -180 to 180");
    double *value = row + 4, *sigma = value + ff_csv_row_channels(r);
    for (size_t c = 0; c < r->n_channels && r->with_sigma; c++) {
        int fine = isnan(sigma[c]) ? isnan(value[c])
                                   : sigma[c] > 0 || ff_table_is_code(value[c]) ||
                                         (sigma[c] == 0 && r->layout && r->layout->zero_sigma_is_small);
        if (!fine) return bad_value(r, 4 + ff_csv_row_channels(r) + c, sigma[c], "a standard deviation > 0");
    }
    for (size_t w = 0; w < r->n_wants; w++)
        if (r->wants[w].item->key == FF_CSV_SIGMA && r->wants[w].item->unit == FF_CSV_PERCENT)
            row[r->wants[w].place] *= fabs(value[r->wants[w].place - 4 - ff_csv_row_channels(r)]);
    if (r->with_wavelength && !(value[r->n_channels] > 0))
        return bad_value(r, 4 + r->n_channels, value[r->n_channels], "a wavelength > 0");
    if (r->with_weight && row[r->rows.width - 1] < 0)
        return bad_value(r, r->rows.width - 1, row[r->rows.width - 1], "a weight >= 0");
    if (r->with_phase) compare_phase(r, row);
    return FF_OK;
}

/* ---- directions of another kind --------------------------------------------------------------- */

static void angles_of(const double w[3], double *theta, double *phi)
{
    *theta = atan2(hypot(w[0], w[1]), w[2]) / degree;
    *phi = w[0] == 0 && w[1] == 0 ? 0 : atan2(w[1], w[0]) / degree;
}

static ff_status take_vectors(const reader *r, double *row)
{
    for (int k = 0; k < 2; k++) {
        const double *w = r->far + FF_FAR_ANGLES + 3 * k, length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        if (!(length > 0.5 && length < 2))
            return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1,
                                "w%c: found a vector of length %.3g, expected one of length 1", k ? 'o' : 'i', length);
        angles_of(w, row + 2 * k, row + 2 * k + 1);
    }
    return FF_OK;
}

static void take_half(const reader *r, double *row)
{
    const double q[4] = {r->far[0] * degree, r->far[1] * degree, r->far[2] * degree, r->far[3] * degree};
    double angle[4];
    ff_axes_angles(FF_AXES_HALF_DIFFERENCE, 1, q, angle);
    for (int k = 0; k < 4; k++) row[k] = angle[k] / degree;
}

/* ---- rows ---------------------------------------------------------------------------------------- */

/* Angles that are not there: an empty row, or a mistake. 1: nothing is there at all. */
static int is_padding(const reader *r, const double *row)
{
    for (size_t w = 0; w < r->n_wants; w++) {
        const size_t place = r->wants[w].place;
        const double v = place < FF_CSV_FAR            ? row[place]
                         : place < FF_CSV_FAR + FF_FAR ? r->far[place - FF_CSV_FAR]
                                                       : r->side[place - FF_CSV_FAR - FF_FAR];
        if (!isnan(v)) return 0;
    }
    return 1;
}

static ff_status check_there(const reader *r, const double *row)
{
    for (size_t w = 0; w < r->n_wants; w++) {
        const want *one = &r->wants[w];
        if (may_be_missing(one)) continue;
        const double v = one->place < FF_CSV_FAR ? row[one->place] : r->far[one->place - FF_CSV_FAR];
        if (isnan(v)) return bad_cell(r, one, "", "");
    }
    return FF_OK;
}

static ff_status add_row(reader *r, const double *row)
{
    double *added = ff_rows_add(&r->rows);
    if (!added) return ff_csv_no_memory(r);
    memcpy(added, row, r->rows.width * sizeof *added);
    return check_row(r, added);
}

static ff_status add_side(reader *r)
{
    ff_status status = FF_OK;
    for (size_t k = 0; k < r->at->n_at && status == FF_OK; k++) {
        r->row[r->at_place] = r->at->at[k];
        r->row[4] = r->side[k];
        status = add_row(r, r->row);
    }
    return status;
}

static ff_status check_settings(const reader *r)
{
    if (r->n_set == r->n_settings) return FF_OK;
    for (size_t k = 0; k < r->n_settings; k++)
        if (isnan(r->set[k].place < FF_CSV_FAR ? r->initial[r->set[k].place] : r->far_initial[r->set[k].place - FF_CSV_FAR]))
            return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->lines.line, -1,
                                "found a row of numbers, expected a line before it with '%s' and the number of %s",
                                r->set[k].item->setting, r->set[k].item->text);
    return FF_OK;
}

static ff_status read_row(reader *r, const char *text, size_t length)
{
    memcpy(r->row, r->initial, r->rows.width * sizeof *r->row);
    memcpy(r->far, r->far_initial, sizeof r->far);
    ff_status status = check_settings(r);
    if (status == FF_OK) status = read_cells(r, text, length, r->row);
    if (status != FF_OK) return status;
    if (is_padding(r, r->row)) {
        r->n_blank++;
        return FF_OK;
    }
    status = check_there(r, r->row);
    if (status == FF_OK && r->with_vectors) status = take_vectors(r, r->row);
    if (status == FF_OK && r->with_half) take_half(r, r->row);
    if (status != FF_OK) return status;
    return r->at ? add_side(r) : add_row(r, r->row);
}

/* ---- lines --------------------------------------------------------------------------------------- */

static int read_setting(reader *r, const char *text, size_t length)
{
    int any = 0;
    for (size_t k = 0; k < r->n_settings; k++) {
        double v;
        const want *w = &r->set[k];
        if (!ff_csv_setting(text, length, w->item->setting, &r->header.dialect, &v)) continue;
        *(w->place < FF_CSV_FAR ? &r->initial[w->place] : &r->far_initial[w->place - FF_CSV_FAR]) = v * w->factor + w->offset;
        any = 1;
    }
    return any;
}

static void begin_settings(reader *r)
{
    for (size_t k = 0; k < r->n_settings; k++)
        *(r->set[k].place < FF_CSV_FAR ? &r->initial[r->set[k].place] : &r->far_initial[r->set[k].place - FF_CSV_FAR]) = NAN;
    for (size_t k = 0; r->n_settings && k < r->look.n_lines && (long)k < r->lines.line; k++)
        (void)read_setting(r, r->look.line[k].text, r->look.line[k].length);
}

/* The line of names once more, as above each block. */
static int is_header_again(const reader *r, const char *text, size_t length)
{
    const size_t k = (size_t)r->header.line;
    if (k == 0 || k > r->look.n_lines) return 0;
    const ff_csv_line *l = &r->look.line[k - 1];
    return l->length == length && memcmp(l->text, text, length) == 0;
}

static int is_empty(const char *text, char separator)
{
    for (; *text; text++)
        if (!ff_csv_is_blank(*text) && *text != separator) return 0;
    return 1;
}

static ff_status read_line(reader *r, char *text, size_t length)
{
    const char *start = text + strspn(text, " \t");
    const int comment = *start == '#' || (*start == '"' && start[1] == '#');
    if (r->n_settings && read_setting(r, text, length)) return FF_OK;
    if (comment) return ff_csv_foreign_comment(&r->head, &r->header.ours, text + (start - text), 1, &r->lines, r->err);
    if (is_empty(text, r->header.dialect.separator)) return FF_OK;
    if (!r->layout && is_header_again(r, text, length)) {
        r->n_repeats++;
        return FF_OK;
    }
    return read_row(r, text, length);
}

ff_status ff_csv_rows_read(ff_csv_reader *r)
{
    begin_settings(r);
    ff_status status = r->header.first_row ? read_row(r, r->header.first_row, r->header.first_row_length) : FF_OK;
    while (status == FF_OK) {
        char *text;
        size_t length;
        status = ff_lines_next(&r->lines, &text, &length, r->err);
        if (status != FF_OK || !text) break;
        status = read_line(r, text, length);
    }
    if (status == FF_OK && r->rows.n == 0)
        return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1,
                            "found no rows after the header, expected at least one");
    return status;
}
