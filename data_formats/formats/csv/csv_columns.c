/* Reading somebody's CSV with a mapping of its columns.
 *
 * Only the columns named are read; the others may hold anything. Numbers have a decimal point.
 *
 * A row on its way into the table: the places of ff_rows_width, the wavelength as one channel more. */
#define _GNU_SOURCE
#include "internal_csv_reader.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;
static const double phase_close = 0.5; /* degrees: angles in files are rounded */

typedef ff_csv_reader reader;
typedef ff_csv_want want;

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

/* All of the one kind of directions, and nothing of another. */
static ff_status check_directions(const reader *r)
{
    size_t n[3] = {0};
    for (size_t k = 0; k < r->map.n; k++) {
        const ff_csv_key key = r->map.item[k].key;
        n[0] += key <= FF_CSV_PHI_O ? 1 : 0;
        n[1] += key >= FF_CSV_THETA_H && key <= FF_CSV_PHI_D;
        n[2] += key >= FF_CSV_WI_X;
    }
    if (n[1] && (n[1] != 4 || n[0] || n[2] || r->at))
        return bad_mapping(r, "some half and difference angles", "theta_h, phi_h, theta_d, phi_d alone");
    if (n[2] && (n[2] != 6 || n[0] || r->at))
        return bad_mapping(r, "some components of directions", "wi_x, wi_y, wi_z, wo_x, wo_y, wo_z alone");
    return FF_OK;
}

static ff_status count_kinds(reader *r)
{
    ff_status status;
    size_t n_sigmas = 0;
    for (size_t k = 0; k < r->map.n; k++) {
        const ff_csv_key key = r->map.item[k].key;
        r->n_channels += key == FF_CSV_VALUE;
        n_sigmas += key == FF_CSV_SIGMA;
        r->with_weight |= key == FF_CSV_WEIGHT;
        r->with_wavelength |= key == FF_CSV_WAVELENGTH;
        r->with_phase |= key == FF_CSV_PHASE;
        r->with_half |= key >= FF_CSV_THETA_H && key <= FF_CSV_PHI_D;
        r->with_vectors |= key >= FF_CSV_WI_X;
        if (r->map.item[k].n_at) r->at = &r->map.item[k];
    }
    r->with_sigma = n_sigmas > 0;
    if (r->n_channels == 0) return bad_mapping(r, "no f", "f=column or f_NAME=column");
    status = check_directions(r);
    if (status != FF_OK) return status;
    if (r->at && (r->n_channels != 1 || r->with_wavelength || n_sigmas || r->with_weight))
        return bad_mapping(r, "f@ANGLE beside other values", "it alone");
    if (n_sigmas && n_sigmas != r->n_channels) return bad_mapping(r, "some sigmas", "none or one for each channel");
    if (r->with_wavelength && r->n_channels != 1)
        return bad_mapping(r, "a wavelength and several channels", "one column of values where rows differ by wavelength");
    for (size_t k = 0; k < r->map.n; k++)
        if (r->map.item[k].key == FF_CSV_SIGMA && sigma_channel(r, r->map.item[k].channel) == SIZE_MAX)
            return bad_mapping(r, r->map.item[k].text, "a standard deviation of a channel that is there");
    return FF_OK;
}

static size_t place_of(const reader *r, const ff_csv_item *item)
{
    switch (item->key) {
    case FF_CSV_VALUE:
        return 4 + channel_index(r, item->channel);
    case FF_CSV_WAVELENGTH:
        return 4 + r->n_channels;
    case FF_CSV_SIGMA:
        return 4 + ff_csv_row_channels(r) + sigma_channel(r, item->channel);
    case FF_CSV_WEIGHT:
        return r->rows.width - 1;
    case FF_CSV_PHASE:
        return FF_CSV_FAR + FF_FAR_PHASE;
    default:
        return item->key >= FF_CSV_THETA_H ? FF_CSV_FAR + (size_t)(item->key - FF_CSV_THETA_H) : (size_t)item->key;
    }
}

/* 1 when every column of angles is in radians, by its unit or by the file's word. */
static int all_radians(const reader *r)
{
    size_t n_radians = 0;
    if (r->with_half || r->with_vectors) return 0;
    for (size_t k = 0; k < r->map.n; k++) {
        const ff_csv_item *item = &r->map.item[k];
        if (item->key > FF_CSV_PHI_O || (!isnan(item->constant) && item->unit == FF_CSV_PLAIN)) continue;
        if (item->unit == FF_CSV_ELEVATION_RADIANS) return 0; /* the offset is simpler in degrees */
        if (item->unit != FF_CSV_RADIANS && (item->unit != FF_CSV_PLAIN || r->head.radians_per_unit != 1)) return 0;
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
    case FF_CSV_ELEVATION:
        return -degree / radians_per_unit;
    case FF_CSV_ELEVATION_RADIANS:
        return -1 / radians_per_unit;
    default:
        if (item->key >= FF_CSV_WI_X) return 1;
        if (item->key >= FF_CSV_PHASE) return unit / degree;
        return item->key <= FF_CSV_PHI_O && unit != radians_per_unit ? unit / radians_per_unit : 1;
    }
}

static int by_column(const void *a, const void *b)
{
    const want *x = a, *y = b;
    return x->column < y->column ? -1 : x->column > y->column;
}

/* The columns that hold f at the item's angles: side by side from the one it names, or all that no other item names. */
static ff_status place_columns_at(reader *r, const ff_csv_item *item, double radians_per_unit)
{
    const size_t columns = r->header.names.n, wanted = item->n_at;
    size_t n = 0;
    r->at_place = (size_t)item->at_key;
    r->side = malloc(wanted * sizeof *r->side);
    if (!r->side) return ff_csv_no_memory(r);
    for (size_t c = 0; c < columns; c++) {
        int named = item->number >= 0 && (c < (size_t)item->number || n == wanted), twice;
        for (size_t k = 0; k < r->map.n && !named; k++)
            named = item->number < 0 && !r->map.item[k].n_at && ff_csv_item_find(&r->map.item[k], &r->header.names, &twice) == c;
        if (named) continue;
        if (n < wanted) r->wants[r->n_wants++] = (want){item, c, FF_CSV_FAR + FF_FAR + n, 1, 0};
        n++;
    }
    const double unit = item->unit == FF_CSV_RADIANS ? 1 : item->unit == FF_CSV_DEGREES ? degree : r->head.radians_per_unit;
    for (size_t k = 0; k < wanted; k++) item->at[k] *= unit / radians_per_unit;
    if (n == wanted) return FF_OK;
    return ff_error_set(r->err, FF_ERR_FORMAT, r->path, r->header.line, -1,
                        "found %zu columns of values for %s, expected %zu: one for each angle", n, item->text, wanted);
}

static ff_status place_item(reader *r, const ff_csv_item *item, double radians_per_unit)
{
    int twice;
    char quoted[FF_QUOTE];
    want w = {.item = item, .place = place_of(r, item), .factor = factor_of(r, item, radians_per_unit)};
    if (item->unit == FF_CSV_ELEVATION || item->unit == FF_CSV_ELEVATION_RADIANS) w.offset = pi / 2 / radians_per_unit;
    if (item->n_at) return place_columns_at(r, item, radians_per_unit);
    if (item->setting) {
        r->set[r->n_settings++] = w;
        return FF_OK;
    }
    if (!isnan(item->constant)) {
        if (w.place == FF_CSV_FAR + FF_FAR_PHASE) return bad_mapping(r, "a constant phase", "a column");
        if (item->unit == FF_CSV_PERCENT) return bad_mapping(r, "a constant in %", "a column, or a number in the unit of f");
        *(w.place >= FF_CSV_FAR ? &r->far_initial[w.place - FF_CSV_FAR] : &r->initial[w.place]) =
            w.factor * item->constant + w.offset;
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
    r->rows.width = ff_rows_width(ff_csv_row_channels(r), r->with_sigma, r->with_weight);
    r->wants = malloc((r->map.n + (r->at ? r->at->n_at : 0) + 1) * sizeof *r->wants);
    r->set = malloc(r->map.n * sizeof *r->set);
    r->initial = calloc(r->rows.width, sizeof *r->initial);
    r->row = calloc(r->rows.width, sizeof *r->row);
    if (!r->wants || !r->set || !r->initial || !r->row) return ff_csv_no_memory(r);
    double unit = all_radians(r) ? 1 : degree;
    if (r->with_sigma && r->with_wavelength) r->initial[4 + ff_csv_row_channels(r) + 1] = 1; /* nobody looks at it */
    for (size_t k = 0; k < r->map.n && status == FF_OK; k++) status = place_item(r, &r->map.item[k], unit);
    if (status != FF_OK) return status;
    if (r->n_wants == 0) return bad_mapping(r, "constants alone", "at least one column");
    qsort(r->wants, r->n_wants, sizeof *r->wants, by_column);
    r->head.radians_per_unit = unit;
    return FF_OK;
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

/* What was assumed of a table whose names said what it is. */
static void tell_plan(const reader *r, ff_table *t)
{
    static const struct {
        char c;
        const char *word;
    } of[] = {{',', "commas"}, {';', "semicolons"}, {'\t', "tabs"}, {'|', "bars"}, {' ', "blanks"}};
    const ff_csv_dialect *d = &r->header.dialect;
    const char *separated = "";
    for (size_t k = 0; k < sizeof of / sizeof of[0]; k++)
        if (of[k].c == d->separator) separated = of[k].word;
    ff_table_note_hint(t, FF_HINT_SAY, "its columns are taken by their names; to take them otherwise, say columns '%.*s%s'", 700,
                       r->plan->columns, strlen(r->plan->columns) > 700 ? "..." : "");
    if (d->separator != ',' || d->decimal == ',' || d->thousands || d->latin)
        ff_table_note(t, "cells are separated by %s%s%s%s", separated, d->decimal == ',' ? ", the decimal mark is a comma" : "",
                      d->thousands ? ", thousands are separated too" : "", d->latin ? ", signs are those of ISO-8859-1" : "");
    for (const char *p = r->plan->notes; *p;) {
        const int n = (int)strcspn(p, "\n");
        ff_table_note_hint(t, memmem(p, (size_t)n, "say ", 4) ? FF_HINT_SAY : FF_HINT_NONE, "%.*s", n, p);
        p += n + (p[n] != '\0');
    }
    t->azimuth_from_mirror = r->plan->scan;
}

static void tell_rows(const reader *r, ff_table *t)
{
    if (r->n_missing)
        ff_table_note(t, "%zu %s no number but '%s'%s: not measured", r->n_missing, r->n_missing == 1 ? "cell has" : "cells have",
                      r->missing, r->n_missing == 1 ? "" : " or the like");
    if (r->n_blank) ff_table_note(t, "%zu empty row%s passed over", r->n_blank, r->n_blank == 1 ? " is" : "s are");
    if (r->header.passed_over)
        ff_table_note(t, "%ld line%s before the header line %ld %s passed over", r->header.passed_over,
                      r->header.passed_over == 1 ? "" : "s", r->header.line, r->header.passed_over == 1 ? "is" : "are");
    if (r->lines.unterminated) ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
}

/* Half vectors without azimuths say nothing of a direction of the surface. */
static int is_isotropic(const reader *r, const ff_table *t)
{
    for (size_t k = 0; k < r->map.n; k++)
        if (r->map.item[k].key == FF_CSV_PHI_H && !isnan(r->map.item[k].constant)) return 1;
    return ff_table_one_incidence_azimuth(t);
}

/* Has nobody said what the values are, neither the file nor the names that a plan went by nor the person? */
static int quantity_is_open(const reader *r, const ff_read_options *o)
{
    return o->quantity < 0 && !r->layout && !r->head.is_ours && !r->head.quantity_is_said && !(r->plan && r->plan->says_quantity);
}

static void describe(const reader *r, const ff_read_options *o, ff_table *t)
{
    strcpy(t->format, r->layout ? r->layout->format : "csv");
    if (r->layout && r->layout->note) ff_table_note(t, "%s", r->layout->note);
    t->angles_are_open = !r->layout && !r->head.is_ours;
    t->quantity_is_open = quantity_is_open(r, o);
    if (r->plan) tell_plan(r, t);
    if (r->with_phase) settle_azimuth(r, t);
    t->isotropic = r->head.isotropic >= 0 ? r->head.isotropic : is_isotropic(r, t);
    if (t->sigma && has_relative_sigma(r)) raise_zero_sigmas(t);
    tell_rows(r, t);
    ff_table_leave_out_codes(t);
    ff_table_set_quantity(t, ff_read_quantity(o, r->layout                      ? r->layout->quantity
                                                 : r->head.quantity_is_said     ? r->head.quantity
                                                 : r->plan && r->plan->quantity ? r->plan->quantity
                                                                                : r->head.quantity));
}

static ff_status make_table(reader *r, const ff_read_options *o, ff_table *out)
{
    ff_table t;
    ff_status status = ff_rows_to_table(&r->rows, ff_csv_row_channels(r), r->with_sigma, r->with_weight, &t, r->err);
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

/* The dialect of the rows; where names stand in a line cut otherwise, the rows may be cut as they are. */
static void settle_separator(reader *r, char of_rows)
{
    const ff_csv_line *l = r->look.first_row ? &r->look.line[r->look.first_row - 1] : NULL;
    const char of_names = r->header.dialect.separator;
    if (!l || !of_rows || ff_csv_count_cells(l->text, l->length, of_names) >= r->header.names.n) return;
    r->header.dialect.separator = of_rows;
}

static ff_status find_header(reader *r)
{
    const size_t first = r->look.first_row;
    r->header.dialect = r->look.dialect;
    if (r->plan || (!r->layout && first && ff_csv_mapping_by_number(&r->map))) {
        size_t most = 0;
        for (size_t k = first - 1; k < r->look.n_lines; k++)
            if (r->look.line[k].is_row && r->look.line[k].full > most) most = r->look.line[k].full;
        r->header.loose = 1;
        r->header.line = r->plan ? (long)r->plan->header_line : (long)first - 1;
        return ff_csv_header_skip(&r->lines, first, most, &r->head, &r->header, r->err);
    }
    const ff_status status = ff_csv_header_find(&r->lines, &r->map, &r->head, &r->header, r->err);
    if (status == FF_OK) settle_separator(r, r->look.dialect.separator);
    return status;
}

static ff_status read_all(reader *r, const ff_read_options *o, ff_table *out)
{
    ff_status status = find_header(r);
    if (status == FF_OK) status = place_columns(r);
    if (status == FF_OK && o->part && !r->with_wavelength)
        status =
            ff_error_set(r->err, FF_ERR_UNSUPPORTED, r->path, 0, -1,
                         "found the option 'part', expected it where the option 'columns' names a wavelength that it can choose");
    if (status == FF_OK) status = ff_csv_rows_read(r);
    return status == FF_OK ? make_table(r, o, out) : status;
}

static ff_status read_with(reader *r, const char *columns, const ff_read_options *o, ff_table *out)
{
    ff_status status = ff_csv_mapping_read(columns, r->path, &r->map, r->err);
    if (status == FF_OK) status = ff_lines_open(r->path, &r->lines, r->err);
    if (status == FF_OK) {
        status = read_all(r, o, out);
        ff_lines_close(&r->lines);
    }
    ff_csv_mapping_free(&r->map);
    ff_names_free(&r->header.names);
    free(r->wants);
    free(r->set);
    free(r->initial);
    free(r->row);
    free(r->side);
    ff_rows_free(&r->rows);
    return status;
}

ff_status ff_csv_read_columns(const char *path, const ff_read_options *o, const ff_csv_layout *layout, ff_table *out, ff_error *err)
{
    reader r = {.err = err, .path = path, .layout = layout, .head = {.radians_per_unit = degree, .isotropic = -1}};
    ff_csv_dialect given;
    if (layout) return read_with(&r, layout->columns, o, out);
    if (o->angles == FF_ANGLES_RADIANS) r.head.radians_per_unit = 1;
    ff_status status = ff_csv_dialect_read(o->dialect, path, &given, err);
    if (status == FF_OK) status = ff_csv_look_at(path, &given, &r.look, err);
    if (status != FF_OK) return status;
    status = read_with(&r, o->columns, o, out);
    ff_csv_look_clear(&r.look);
    return status;
}

ff_status ff_csv_read_table(const char *path, const ff_read_options *o, ff_csv_look *look, ff_table *out, ff_error *err)
{
    ff_csv_plan plan;
    ff_status status = ff_csv_plan_make(look, path, o->angles, &plan, err);
    if (status != FF_OK) return status;
    reader r = {.err = err, .path = path, .plan = &plan, .look = *look, .head = {.radians_per_unit = degree, .isotropic = -1}};
    if (o->angles == FF_ANGLES_RADIANS) r.head.radians_per_unit = 1;
    r.header.ours = look->our_angles;
    status = read_with(&r, plan.columns, o, out);
    ff_csv_plan_clear(&plan);
    return status;
}
