/* Reading somebody's CSV with a mapping of its columns.
 *
 * Only the columns named are read; the others may hold anything. Numbers have a decimal point.
 *
 * A row on its way into the table: the places of ff_rows_width, the wavelength as one channel more. */
#define _GNU_SOURCE
#include "internal_csv.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;
static const double phase_close = 0.5; /* degrees: angles in files are rounded */

/* One column that is read: where it stands in the file and in a row. */
typedef struct want {
    const ff_csv_item *item;
    size_t column, place;
    double factor;
} want;

typedef struct reader {
    ff_lines lines;
    ff_error *err;
    const char *path;
    const ff_csv_layout *layout; /* NULL: the person's own mapping */
    ff_csv_mapping map;
    ff_csv_head head;
    ff_csv_header header;
    size_t n_channels;
    int with_sigma, with_weight, with_wavelength, with_phase;
    size_t n_wants;
    want *wants;     /* [n_wants] by column */
    double *initial; /* [width] a row with its constants */
    ff_rows rows;
    double phase;        /* of this row                                                                       */
    double phase_off[2]; /* largest difference, were azimuth 0 the side of the light [0], of the mirror [1]    */
} reader;

static ff_status no_memory(const reader *r)
{
    return ff_error_set(r->err, FF_ERR_MEMORY, r->path, r->lines.line, -1, "no memory for a table of %zu samples", r->rows.n + 1);
}

/* ---- columns --------------------------------------------------------------------------------- */

static size_t channel_index(const reader *r, const char *name)
{
    size_t c = 0;
    for (size_t k = 0; k < r->map.n; k++) {
        if (r->map.item[k].key != FF_CSV_VALUE) continue;
        if (strcmp(r->map.item[k].channel, name) == 0) return c;
        c++;
    }
    return SIZE_MAX;
}

/* The channel of a sigma: plain "sigma" is of f, or of the only channel. */
static size_t sigma_channel(const reader *r, const char *name)
{
    size_t c = channel_index(r, strcmp(name, "f") == 0 ? "" : name);
    return c == SIZE_MAX && !*name && r->n_channels == 1 ? 0 : c;
}

static ff_status bad_mapping(const reader *r, const char *found, const char *expected)
{
    return ff_error_set(r->err, FF_ERR_SYNTAX, r->path, 0, -1, "columns: found %s, expected %s", found, expected);
}

static ff_status count_kinds(reader *r)
{
    size_t n_sigmas = 0;
    for (size_t k = 0; k < r->map.n; k++) {
        const ff_csv_key key = r->map.item[k].key;
        r->n_channels += key == FF_CSV_VALUE;
        n_sigmas += key == FF_CSV_SIGMA;
        r->with_weight |= key == FF_CSV_WEIGHT;
        r->with_wavelength |= key == FF_CSV_WAVELENGTH;
        r->with_phase |= key == FF_CSV_PHASE;
    }
    r->with_sigma = n_sigmas > 0;
    if (r->n_channels == 0) return bad_mapping(r, "no f", "f=column or f_NAME=column");
    if (n_sigmas && n_sigmas != r->n_channels) return bad_mapping(r, "some sigmas", "none or one for each channel");
    if (r->with_wavelength && r->n_channels != 1)
        return bad_mapping(r, "a wavelength and several channels", "one column of values where rows differ by wavelength");
    for (size_t k = 0; k < r->map.n; k++)
        if (r->map.item[k].key == FF_CSV_SIGMA && sigma_channel(r, r->map.item[k].channel) == SIZE_MAX)
            return bad_mapping(r, r->map.item[k].text, "a standard deviation of a channel that is there");
    return FF_OK;
}

/* Channels of the rows: the wavelength is one more. */
static size_t row_channels(const reader *r)
{
    return r->n_channels + (r->with_wavelength ? 1 : 0);
}

static size_t place_of(const reader *r, const ff_csv_item *item)
{
    switch (item->key) {
    case FF_CSV_VALUE:
        return 4 + channel_index(r, item->channel);
    case FF_CSV_WAVELENGTH:
        return 4 + r->n_channels;
    case FF_CSV_SIGMA:
        return 4 + row_channels(r) + sigma_channel(r, item->channel);
    case FF_CSV_WEIGHT:
        return r->rows.width - 1;
    case FF_CSV_PHASE:
        return SIZE_MAX;
    default:
        return (size_t)item->key;
    }
}

/* 1 when every column of angles is in radians, by its unit or by the file's word. */
static int all_radians(const reader *r)
{
    size_t n_radians = 0;
    for (size_t k = 0; k < r->map.n; k++) {
        const ff_csv_item *item = &r->map.item[k];
        if (item->key > FF_CSV_PHI_O || (!isnan(item->constant) && item->unit == FF_CSV_PLAIN)) continue;
        if (item->unit == FF_CSV_DEGREES || (item->unit == FF_CSV_PLAIN && r->head.radians_per_unit != 1)) return 0;
        n_radians++;
    }
    return n_radians > 0;
}

/* Stored unit per unit of the file. Of a percentage of the value the product is made in the row. */
static double factor_of(const reader *r, const ff_csv_item *item, double radians_per_unit)
{
    double unit = item->unit == FF_CSV_RADIANS ? 1 : item->unit == FF_CSV_DEGREES ? degree : r->head.radians_per_unit;
    switch (item->unit) {
    case FF_CSV_UM:
        return 1e3;
    case FF_CSV_M:
        return 1e9;
    case FF_CSV_PERCENT:
        return 0.01;
    default:
        if (item->key == FF_CSV_PHASE) return unit / degree;
        return item->key <= FF_CSV_PHI_O && unit != radians_per_unit ? unit / radians_per_unit : 1;
    }
}

static int by_column(const void *a, const void *b)
{
    const want *x = a, *y = b;
    return x->column < y->column ? -1 : x->column > y->column;
}

static ff_status place_item(reader *r, const ff_csv_item *item, double radians_per_unit)
{
    int twice;
    char quoted[FF_QUOTE];
    want w = {.item = item, .place = place_of(r, item), .factor = factor_of(r, item, radians_per_unit)};
    if (!isnan(item->constant)) {
        if (w.place == SIZE_MAX) return bad_mapping(r, "a constant phase", "a column");
        if (item->unit == FF_CSV_PERCENT) return bad_mapping(r, "a constant in %", "a column, or a number in the unit of f");
        r->initial[w.place] = w.factor * item->constant;
        return FF_OK;
    }
    w.column = ff_csv_item_find(item, &r->header.names, &twice);
    if (w.column == SIZE_MAX) return ff_csv_missing_column(item, &r->header, r->path, r->err);
    if (twice)
        return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->header.line, -1,
                            "found column %s twice, expected it once: choose by number, as in %s=#%zu",
                            ff_quote(item->column, strlen(item->column), quoted), item->text, w.column + 1);
    for (size_t k = 0; k < r->n_wants; k++) {
        int angles = item->key <= FF_CSV_PHI_O && r->wants[k].item->key <= FF_CSV_PHI_O;
        if (r->wants[k].column == w.column && !angles) /* theta_o=theta_i is how retro-reflection is measured */
            return ff_error_set(r->err, FF_ERR_SYNTAX, r->path, 0, -1,
                                "columns: found %s and %s from the same column, expected two", r->wants[k].item->text, item->text);
    }
    r->wants[r->n_wants++] = w;
    return FF_OK;
}

/* A constant in radians goes with angles in radians when they all are; so the unit is settled first. */
static ff_status place_columns(reader *r)
{
    ff_status status = count_kinds(r);
    if (status != FF_OK) return status;
    r->rows.width = ff_rows_width(row_channels(r), r->with_sigma, r->with_weight);
    r->wants = malloc(r->map.n * sizeof *r->wants);
    r->initial = calloc(r->rows.width, sizeof *r->initial);
    if (!r->wants || !r->initial) return no_memory(r);
    double unit = all_radians(r) ? 1 : degree;
    if (r->with_sigma && r->with_wavelength) r->initial[4 + row_channels(r) + 1] = 1; /* nobody looks at it */
    for (size_t k = 0; k < r->map.n && status == FF_OK; k++) status = place_item(r, &r->map.item[k], unit);
    if (status != FF_OK) return status;
    if (r->n_wants == 0) return bad_mapping(r, "constants alone", "at least one column");
    qsort(r->wants, r->n_wants, sizeof *r->wants, by_column);
    r->head.radians_per_unit = unit;
    return FF_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

static ff_status bad_cell(const reader *r, const want *w, const char *start, const char *stop)
{
    char found[FF_QUOTE], key[FF_QUOTE];
    int may_be_empty = w->item->key == FF_CSV_VALUE || w->item->key == FF_CSV_SIGMA;
    const char *hint = may_be_empty ? "; leave the cell empty where nothing was measured" : "";
    if (memchr(start, ',', (size_t)(stop - start))) hint = " with a decimal point and not a comma";
    return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1, "column %zu (%s): found %s, expected a finite number%s",
                        w->column + 1, ff_quote(w->item->text, strlen(w->item->text), key),
                        start == stop ? "an empty cell" : ff_quote(start, (size_t)(stop - start), found), hint);
}

/* One cell at p; *next is where the one after it starts, NULL at the end of the line. */
static ff_status read_cell(const reader *r, const want *w, const char *p, const char *stop, double *value, const char **next)
{
    while (p < stop && ff_csv_is_blank(*p) && *p != r->header.separator) p++;
    const char *end = ff_number_read(p, value);
    if (end && isfinite(*value)) {
        while (end < stop && ff_csv_is_blank(*end) && *end != r->header.separator) end++;
        if (end == stop || *end == r->header.separator) {
            *next = end < stop ? end + 1 : NULL;
            return FF_OK;
        }
    }
    *next = ff_csv_skip_cell(p, stop, r->header.separator);
    const char *cell_stop = *next ? *next - 1 : stop;
    while (cell_stop > p && ff_csv_is_blank(cell_stop[-1])) cell_stop--;
    if (cell_stop - p >= 2 && *p == '"' && cell_stop[-1] == '"') {
        end = ff_number_read(p + 1, value);
        if (end == cell_stop - 1 && isfinite(*value)) return FF_OK;
    }
    if (p == cell_stop && (w->item->key == FF_CSV_VALUE || w->item->key == FF_CSV_SIGMA)) {
        *value = NAN;
        return FF_OK;
    }
    return bad_cell(r, w, p, cell_stop);
}

static ff_status wrong_count(const reader *r, size_t found)
{
    return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->lines.line, -1, "found %zu cells, expected %zu, one per column", found,
                        r->header.names.n);
}

/* Cells beyond the header's must be empty, as spreadsheets leave them. */
static ff_status read_cells(reader *r, const char *text, size_t length, double *row)
{
    const char *p = text, *stop = text + length;
    size_t column = 0;
    for (size_t w = 0; w < r->n_wants;) {
        for (; p && column < r->wants[w].column; column++) p = ff_csv_skip_cell(p, stop, r->header.separator);
        if (!p) return wrong_count(r, column);
        double value;
        ff_status status = read_cell(r, &r->wants[w], p, stop, &value, &p);
        if (status != FF_OK) return status;
        for (; w < r->n_wants && r->wants[w].column == column; w++)
            *(r->wants[w].place == SIZE_MAX ? &r->phase : row + r->wants[w].place) = value * r->wants[w].factor;
        column++;
    }
    for (; p && column < r->header.names.n; column++) p = ff_csv_skip_cell(p, stop, r->header.separator);
    if (column < r->header.names.n) return wrong_count(r, column);
    for (size_t extra = column; p; extra++) {
        const char *next = ff_csv_skip_cell(p, stop, r->header.separator);
        for (const char *c = p; c < (next ? next - 1 : stop); c++)
            if (!ff_csv_is_blank(*c)) return wrong_count(r, extra + 1);
        p = next;
    }
    return FF_OK;
}

/* `found` is what stands in the row; of a percentage the message has what stands in the file. */
static ff_status bad_value(const reader *r, size_t place, double found, const char *expected)
{
    char text[FF_NUMBER_TEXT + 1] = "an empty cell";
    const char *name = "a constant";
    for (size_t w = 0; w < r->n_wants; w++) {
        if (r->wants[w].place != place) continue;
        name = r->wants[w].item->text;
        if (r->wants[w].item->unit == FF_CSV_PERCENT) found /= r->wants[w].factor;
    }
    if (isfinite(found)) text[ff_number_write(found, text)] = '\0';
    return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1, "%s: found %s, expected %s", name, text, expected);
}

/* The angle between the directions, were azimuth 0 of the detector on the side of the light [0] or of the mirror [1]. */
static void compare_phase(reader *r, const double *row)
{
    double u = r->head.radians_per_unit, along = cos(u * row[0]) * cos(u * row[2]);
    double across = sin(u * row[0]) * sin(u * row[2]) * cos(u * (row[3] - row[1]));
    for (int k = 0; k < 2; k++) {
        double c = along + (k ? -across : across);
        r->phase_off[k] = fmax(r->phase_off[k], fabs(acos(fmax(-1, fmin(1, c))) / degree - r->phase));
    }
}

static ff_status check_row(reader *r, double *row)
{
    const int radians = r->head.radians_per_unit == 1;
    const double theta_max = radians ? pi + 1e-9 : 180;
    for (size_t k = 0; k < 4; k += 2)
        if (fabs(row[k]) > theta_max)
            return bad_value(r, k, row[k], radians ? "radians from -pi to pi" : "degrees from -180 to 180");
    double *value = row + 4, *sigma = value + row_channels(r);
    for (size_t c = 0; c < r->n_channels && r->with_sigma; c++) {
        int fine =
            isnan(sigma[c]) ? isnan(value[c]) : sigma[c] > 0 || (sigma[c] == 0 && r->layout && r->layout->zero_sigma_is_small);
        if (!fine) return bad_value(r, 4 + row_channels(r) + c, sigma[c], "a standard deviation > 0");
    }
    for (size_t w = 0; w < r->n_wants; w++)
        if (r->wants[w].item->key == FF_CSV_SIGMA && r->wants[w].item->unit == FF_CSV_PERCENT)
            row[r->wants[w].place] *= fabs(value[r->wants[w].place - 4 - row_channels(r)]);
    if (r->with_wavelength && !(value[r->n_channels] > 0))
        return bad_value(r, 4 + r->n_channels, value[r->n_channels], "a wavelength > 0");
    if (r->with_weight && row[r->rows.width - 1] < 0)
        return bad_value(r, r->rows.width - 1, row[r->rows.width - 1], "a weight >= 0");
    if (r->with_phase) compare_phase(r, row);
    return FF_OK;
}

static ff_status read_row(reader *r, const char *text, size_t length)
{
    double *row = ff_rows_add(&r->rows);
    if (!row) return no_memory(r);
    memcpy(row, r->initial, r->rows.width * sizeof *row);
    ff_status status = read_cells(r, text, length, row);
    return status == FF_OK ? check_row(r, row) : status;
}

static ff_status read_rows(reader *r)
{
    ff_status status = r->header.first_row ? read_row(r, r->header.first_row, r->header.first_row_length) : FF_OK;
    while (status == FF_OK) {
        char *text;
        size_t length;
        status = ff_lines_next(&r->lines, &text, &length, r->err);
        if (status != FF_OK || !text) break;
        const char *start = text + strspn(text, " \t");
        if (*start == '#')
            status = ff_csv_foreign_comment(&r->head, &r->header.ours, text + (start - text), 1, &r->lines, r->err);
        else if (*start)
            status = read_row(r, text, length);
    }
    if (status == FF_OK && r->rows.n == 0)
        return ff_error_set(r->err, FF_ERR_DATA, r->path, r->lines.line, -1,
                            "found no rows after the header, expected at least one");
    return status;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void name_channels(const reader *r, ff_table *t)
{
    size_t c = 0;
    for (size_t k = 0; k < r->map.n; k++) {
        if (r->map.item[k].key != FF_CSV_VALUE) continue;
        strcpy(t->channels[c].name, *r->map.item[k].channel ? r->map.item[k].channel : "f"); /* its length was checked */
        t->channels[c].wavelength_nm = ff_wavelength_of(t->channels[c].name);
        c++;
    }
}

/* A deviation of 0 says that the readings did not differ by the instrument's smallest step: the smallest other one stands in. */
static void raise_zero_sigmas(ff_table *t)
{
    size_t n_zero = 0, n_without = 0;
    for (size_t c = 0; c < t->n_channels; c++) {
        double *sigma = t->sigma + c * t->n, least = INFINITY;
        for (size_t i = 0; i < t->n; i++)
            if (sigma[i] > 0) least = fmin(least, sigma[i]);
        n_without += isfinite(least) ? 0 : 1;
        for (size_t i = 0; i < t->n && isfinite(least); i++) {
            if (sigma[i] > 0 || !t->valid[i]) continue;
            sigma[i] = least;
            n_zero++;
        }
    }
    if (n_without) {
        free(t->sigma);
        t->sigma = NULL;
        ff_table_note(t, "a channel has no standard deviation above 0: none are used");
    } else if (n_zero) {
        ff_table_note(t, "%zu standard deviations are 0 (all readings alike): the smallest other one of the channel stands in",
                      n_zero);
    }
}

/* A percentage of a value that is 0 is 0 too. */
static int has_relative_sigma(const reader *r)
{
    for (size_t w = 0; w < r->n_wants; w++)
        if (r->wants[w].item->key == FF_CSV_SIGMA && r->wants[w].item->unit == FF_CSV_PERCENT) return 1;
    return r->layout && r->layout->zero_sigma_is_small;
}

static void settle_azimuth(const reader *r, ff_table *t)
{
    if (r->phase_off[0] <= phase_close) return;
    if (r->phase_off[1] <= phase_close) {
        for (size_t i = 0; i < t->n; i++) t->angle[3][i] += r->head.radians_per_unit == 1 ? pi : 180;
        ff_table_note(t, "the phase angles say that azimuth 0 is the side of the mirror direction: 180 degrees are added to phi_o");
    } else {
        ff_table_note(t,
                      "the phase angles are up to %.0f degrees from those of the directions: is azimuth 0 the side of the light?",
                      fmin(r->phase_off[0], r->phase_off[1]));
    }
}

static void describe(const reader *r, const ff_read_options *o, ff_table *t)
{
    strcpy(t->format, r->layout ? r->layout->format : "csv");
    if (r->layout && r->layout->note) ff_table_note(t, "%s", r->layout->note);
    if (r->with_phase) settle_azimuth(r, t);
    t->isotropic = r->head.isotropic >= 0 ? r->head.isotropic : ff_table_one_incidence_azimuth(t);
    if (t->sigma && has_relative_sigma(r)) raise_zero_sigmas(t);
    if (r->header.passed_over)
        ff_table_note(t, "%ld line%s before the header line %ld %s passed over", r->header.passed_over,
                      r->header.passed_over == 1 ? "" : "s", r->header.line, r->header.passed_over == 1 ? "is" : "are");
    if (r->lines.unterminated) ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
    ff_table_leave_out_codes(t);
    ff_table_set_quantity(t, ff_read_quantity(o, r->layout ? r->layout->quantity : r->head.quantity));
}

static ff_status make_table(reader *r, const ff_read_options *o, ff_table *out)
{
    ff_table t;
    ff_status status = ff_rows_to_table(&r->rows, row_channels(r), r->with_sigma, r->with_weight, &t, r->err);
    if (status != FF_OK) return status;
    t.radians_per_unit = r->head.radians_per_unit;
    if (r->with_wavelength) {
        ff_table long_form = t;
        status = ff_csv_pivot(&long_form, o->part, r->path, &t, r->err);
        ff_table_clear(&long_form);
        if (status != FF_OK) return status;
    } else {
        name_channels(r, &t);
    }
    describe(r, o, &t);
    status = ff_table_count(&t, r->path, r->err);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

static ff_status read_all(reader *r, const ff_read_options *o, ff_table *out)
{
    ff_status status = ff_csv_header_find(&r->lines, &r->map, &r->head, &r->header, r->err);
    if (status == FF_OK) status = place_columns(r);
    if (status == FF_OK && o->part && !r->with_wavelength)
        status = ff_error_set(r->err, FF_ERR_UNSUPPORTED, r->path, 0, -1,
                              "found the option 'part', expected it where 'columns' names a wavelength that it can choose");
    if (status == FF_OK) status = read_rows(r);
    return status == FF_OK ? make_table(r, o, out) : status;
}

ff_status ff_csv_read_columns(const char *path, const ff_read_options *o, const ff_csv_layout *layout, ff_table *out, ff_error *err)
{
    reader r = {.err = err, .path = path, .layout = layout, .head = {.radians_per_unit = degree, .isotropic = -1}};
    ff_status status = ff_csv_mapping_read(layout ? layout->columns : o->columns, path, &r.map, err);
    if (status == FF_OK) status = ff_lines_open(path, &r.lines, err);
    if (status == FF_OK) {
        status = read_all(&r, o, out);
        ff_lines_close(&r.lines);
    }
    ff_csv_mapping_free(&r.map);
    ff_names_free(&r.header.names);
    free(r.wants);
    free(r.initial);
    ff_rows_free(&r.rows);
    return status;
}
