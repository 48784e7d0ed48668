/* CSV: the program's own format for scattered directions. docs and the reader's messages use these words:
 *
 *     # facetfit-csv: 1                    comment lines; only these keys mean something, all are optional,
 *     # quantity: brdf                     and they stand before the header
 *     # angles: degrees
 *     # isotropic: no
 *     theta_i,phi_i,theta_o,phi_o,f_r,f_g,sigma_r,sigma_g,weight
 *     30,0,30,180,0.81,0.79,0.01,0.01,0.002
 *
 * theta_i phi_i theta_o phi_o   required; degrees unless `angles: radians`; |theta| <= 180 degrees, beyond 90 is below the horizon
 * f, f_NAME, any other name     a channel, called f, NAME or as it stands ("465nm" is a wavelength); an empty cell was not measured
 *                               and makes the sample invalid
 * wavelength, lambda            in nm, beside one channel: a row for each
 * sigma, sigma_NAME             standard deviation of a channel, > 0; of all channels or of none. Also called std, stddev, stdev,
 *                               std_dev, uncertainty
 * weight                        solid-angle weight d wi d wo of the sample, >= 0
 * quantity                      brdf (f, 1/sr), brdf-cos (f cos theta_o), reflectance-factor (pi f); for values and sigmas
 * isotropic                     yes: only azimuth differences mean something. Not said: when there is but one phi_i
 *
 * Columns come in any order. Numbers have a decimal point, cells are separated by commas. Written files hold the brdf. Tables with
 * other names are read through a mapping of their columns: csv_columns.c. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "data_formats/formats/csv/internal_csv_look.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double pi = 3.14159265358979323846;
static const double degree = 3.14159265358979323846 / 180;
static const double cos_min = 1e-8; /* FF_COS_MIN of ff_model.h: at or below it nothing can be divided by the cosine */
static const char *const angle_name[4] = {"theta_i", "phi_i", "theta_o", "phi_o"};

typedef struct csv {
    ff_lines lines;
    ff_error *err;
    const char *path;
    ff_csv_head head;
    ff_names names;
    int angles; /* ff_angles: what the person says, which goes before what the file says */
    size_t n_channels;
    int with_sigma, with_weight;
    size_t n_errors;             /* cells with the word of an error of a spreadsheet */
    size_t padding;              /* columns without a name behind all others, as spreadsheets leave them: their cells are empty */
    size_t *slot;                /* [names.n] place of a column in a row, see ff_rows_width */
    size_t *column;              /* [width]   column of a place: the inverse                */
    unsigned char *may_be_empty; /* [names.n]                                               */
    ff_rows rows;
    double theta_largest;
} csv;

static ff_status no_memory(const csv *f)
{
    return ff_error_set(f->err, FF_ERR_MEMORY, f->path, f->lines.line, -1, "no memory for a table of %zu samples", f->rows.n + 1);
}

/* ---- lines ----------------------------------------------------------------------------------- */

/* A header behind the sign of a comment, as numpy.savetxt writes it. */
static int is_header(const char *comment)
{
    return strstr(comment, "theta_i") && strstr(comment, "theta_o") && strchr(comment, ',') && !strchr(comment, ':');
}

static size_t count_commas(const char *text)
{
    size_t n = 0;
    for (; *text; text++) n += *text == ',';
    return n;
}

/* Takes `most` empty cells at the most off the end of a line; how many there were. */
static size_t take_padding(char *text, size_t *length, size_t most)
{
    size_t taken = 0;
    for (; taken < most; taken++) {
        size_t n = *length;
        while (n && (text[n - 1] == ' ' || text[n - 1] == '\t')) n--;
        if (!n || text[n - 1] != ',') break;
        *length = n - 1;
        text[*length] = '\0';
    }
    return taken;
}

/* The next line that is neither blank nor a comment; *text is NULL at the end. */
static ff_status next_line(csv *f, char **text, size_t *length)
{
    for (;;) {
        ff_status status = ff_lines_next(&f->lines, text, length, f->err);
        if (status != FF_OK || !*text) return status;
        char *start = *text + strspn(*text, " \t");
        if (*start == '"' && start[1] == '#') start++; /* a comment that a spreadsheet has quoted */
        if (*start == '#' && !f->names.n && is_header(start)) {
            *length -= (size_t)(start + 1 - *text);
            *text = start + 1;
            return FF_OK;
        }
        if (*start == '#') status = ff_csv_comment(&f->head, start, f->names.n > 0, f->path, f->lines.line, f->err);
        if (status != FF_OK) return status;
        if (f->names.n && *start && !start[strspn(start, " \t,")]) continue; /* a spreadsheet's empty row */
        if (*start != '#' && *start != '\0') return FF_OK;
    }
}

/* ---- header ---------------------------------------------------------------------------------- */

static ff_status wrong_header(const csv *f, const char *name, const char *why)
{
    char found[FF_NAMES_LIST], quoted[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1, "column %s %s; found the columns %s",
                        ff_quote(name, strlen(name), quoted), why, ff_names_list(&f->names, found));
}

static long find_name(const ff_names *names, const char *name)
{
    for (size_t k = 0; k < names->n; k++)
        if (strcmp(names->name[k], name) == 0) return (long)k;
    return -1;
}

/* Where column k would be looked for: its kind is its name. */
static int is_angle(const char *name)
{
    for (int k = 0; k < 4; k++)
        if (strcmp(name, angle_name[k]) == 0) return 1;
    return 0;
}

/* The channel whose standard deviation a column is: "" of a plain "sigma", NULL of what is none. */
static const char *sigma_of(const char *name)
{
    static const char *const words[] = {"sigma", "std", "stddev", "std_dev", "stdev", "uncertainty"};
    for (size_t k = 0; k < sizeof words / sizeof words[0]; k++) {
        const size_t n = strlen(words[k]);
        if (strncmp(name, words[k], n) == 0 && (!name[n] || (name[n] == '_' && name[n + 1]))) return name[n] ? name + n + 1 : "";
    }
    return NULL;
}

static int is_sigma(const char *name)
{
    return sigma_of(name) != NULL;
}

static int is_wavelength(const char *name)
{
    return strcasecmp(name, "wavelength") == 0 || strcasecmp(name, "wavelength_nm") == 0 || strcasecmp(name, "lambda") == 0 ||
           strcasecmp(name, "lambda_nm") == 0;
}

static int is_channel(const char *name)
{
    return !is_angle(name) && !is_sigma(name) && strcmp(name, "weight") != 0;
}

static const char *channel_of(const char *column)
{
    return strncmp(column, "f_", 2) == 0 && column[2] ? column + 2 : column;
}

/* Gives column k its place in a row. */
static void put(csv *f, size_t k, size_t place)
{
    f->slot[k] = place;
    f->column[place] = k;
}

static ff_status place_angles(csv *f)
{
    for (size_t a = 0; a < 4; a++) {
        long k = find_name(&f->names, angle_name[a]);
        if (k < 0)
            return wrong_header(
                f, angle_name[a],
                "is missing (the option 'columns' can say which one it is, as in theta_i=NAME, and passes over lines "
                "before the header)");
        put(f, (size_t)k, a);
    }
    return FF_OK;
}

static ff_status place_channels(csv *f)
{
    size_t c = 0;
    for (size_t k = 0; k < f->names.n; k++) {
        if (!is_channel(f->names.name[k])) continue;
        for (size_t j = 0; j < c; j++)
            if (strcmp(channel_of(f->names.name[f->column[4 + j]]), channel_of(f->names.name[k])) == 0)
                return wrong_header(f, f->names.name[k], "names a channel that another column has named already");
        f->may_be_empty[k] = 1;
        put(f, k, 4 + c++);
    }
    return FF_OK;
}

/* The channel that a sigma column belongs to, -1 = none. Plain "sigma" is of f, or of the only channel. */
static long sigma_channel(const csv *f, const char *name)
{
    const char *given = sigma_of(name), *of = *given ? given : "f";
    for (size_t c = 0; c < f->n_channels; c++)
        if (strcmp(channel_of(f->names.name[f->column[4 + c]]), of) == 0) return (long)c;
    return !*given && f->n_channels == 1 ? 0 : -1;
}

static ff_status place_sigmas(csv *f, size_t n_sigmas)
{
    for (size_t k = 0; k < f->names.n; k++) {
        const char *name = f->names.name[k];
        if (!is_sigma(name)) continue;
        long c = sigma_channel(f, name);
        if (c < 0) return wrong_header(f, name, "is the standard deviation of a channel that is missing");
        size_t place = 4 + f->n_channels + (size_t)c;
        if (f->column[place] != SIZE_MAX) return wrong_header(f, name, "is a second standard deviation of its channel");
        f->may_be_empty[k] = 1;
        put(f, k, place);
    }
    if (n_sigmas != f->n_channels)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1,
                            "found %zu sigma columns, expected none or one for each of the %zu channels", n_sigmas, f->n_channels);
    return FF_OK;
}

/* A wavelength beside one column of values: a row for each wavelength, which is read by a mapping. */
static int has_row_per_wavelength(const csv *f)
{
    size_t values = 0, wavelengths = 0, quoted = 0;
    for (size_t k = 0; k < f->names.n; k++) {
        const char *name = f->names.name[k];
        wavelengths += is_wavelength(name) ? 1 : 0;
        values += is_channel(name) && !is_wavelength(name) ? 1 : 0;
        quoted += strchr(name, '"') ? 1 : 0;
    }
    return wavelengths == 1 && values == 1 && !quoted;
}

static ff_status place_columns(csv *f)
{
    size_t n_sigmas = 0;
    for (size_t k = 0; k < f->names.n; k++) {
        f->n_channels += is_channel(f->names.name[k]) ? 1 : 0;
        n_sigmas += is_sigma(f->names.name[k]) ? 1 : 0;
    }
    long weight = find_name(&f->names, "weight");
    f->with_sigma = n_sigmas > 0;
    f->with_weight = weight >= 0;
    f->rows.width = ff_rows_width(f->n_channels, f->with_sigma, f->with_weight);
    f->slot = calloc(f->names.n + 1, sizeof *f->slot);
    f->column = malloc(f->rows.width * sizeof *f->column);
    f->may_be_empty = calloc(f->names.n + 1, 1);
    if (!f->slot || !f->column || !f->may_be_empty) return no_memory(f);
    memset(f->column, 0xFF, f->rows.width * sizeof *f->column);

    ff_status status = place_angles(f);
    if (status == FF_OK && f->n_channels == 0) status = wrong_header(f, "f", "(or f_NAME) is missing");
    if (status == FF_OK) status = place_channels(f);
    if (status == FF_OK && f->with_sigma) status = place_sigmas(f, n_sigmas);
    if (status == FF_OK && f->with_weight) put(f, (size_t)weight, f->rows.width - 1);
    return status;
}

static ff_status read_header(csv *f)
{
    char *text;
    size_t length;
    ff_status status = next_line(f, &text, &length);
    if (status != FF_OK) return status;
    if (!text)
        return ff_error_set(f->err, FF_ERR_READ, f->path, f->lines.line, -1,
                            "found the end of the file, expected a header line theta_i,phi_i,theta_o,phi_o,f");
    if (!strchr(text, ',') && strpbrk(text, ";\t"))
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, f->lines.line, -1,
                            "found columns separated by %s, expected ',' (and numbers with a decimal point); the option 'columns' "
                            "takes either",
                            strchr(text, ';') ? "';'" : "tabs");
    f->padding = take_padding(text, &length, count_commas(text) < FF_NAMES_MAX ? FF_NAMES_MAX : 0);
    status = ff_names_read(text, length, f->path, f->lines.line, &f->names, f->err);
    if (status == FF_OK && has_row_per_wavelength(f)) return FF_OK;
    return status == FF_OK ? place_columns(f) : status;
}

/* ---- rows ------------------------------------------------------------------------------------ */

static ff_status bad_cell(const csv *f, size_t place, double found, const char *expected)
{
    char text[FF_NUMBER_TEXT + 1] = "an empty cell";
    if (isfinite(found)) text[ff_number_write(found, text)] = '\0';
    return ff_error_set(f->err, FF_ERR_DATA, f->path, f->lines.line, -1, "column '%s': found %s, expected %s",
                        f->names.name[f->column[place]], text, expected);
}

static ff_status check_row(csv *f, const double *row)
{
    int radians = f->head.radians_per_unit == 1 && f->angles != FF_ANGLES_DEGREES;
    double theta_max = radians ? pi + 1e-9 : 180; /* files round pi to the digits they have */
    for (size_t k = 0; k < 4; k += 2) {
        if (fabs(row[k]) > theta_max)
            return bad_cell(f, k, row[k], radians ? "radians from -pi to pi" : "degrees from -180 to 180");
        f->theta_largest = fmax(f->theta_largest, fabs(row[k]));
    }
    const double *value = row + 4, *sigma = value + f->n_channels;
    for (size_t c = 0; c < f->n_channels && f->with_sigma; c++) {
        if (isnan(sigma[c]) ? !isnan(value[c]) : sigma[c] <= 0 && !ff_table_is_code(value[c]))
            return bad_cell(f, 4 + f->n_channels + c, sigma[c], "a standard deviation > 0");
    }
    if (f->with_weight && row[f->rows.width - 1] < 0)
        return bad_cell(f, f->rows.width - 1, row[f->rows.width - 1], "a weight >= 0");
    return FF_OK;
}

static ff_status read_rows(csv *f)
{
    const ff_columns columns = {f->names.n, f->names.name, f->slot, f->may_be_empty, &f->n_errors};
    char *text;
    size_t length;
    for (;;) {
        ff_status status = next_line(f, &text, &length);
        if (status != FF_OK || !text) return status;
        double *row = ff_rows_add(&f->rows);
        if (!row) return no_memory(f);
        take_padding(text, &length, f->padding);
        status = ff_row_read(text, length, &columns, row, f->path, f->lines.line, f->err);
        if (status == FF_OK) status = check_row(f, row);
        if (status != FF_OK) return status;
    }
}

/* ---- the table ------------------------------------------------------------------------------- */

/* f cos(theta_o) -> f; where the cosine leaves nothing, the sample was not measured. */
static void divide_by_cosine(const csv *f, ff_table *t)
{
    for (size_t i = 0; i < t->n; i++) {
        const double cosine = cos(f->head.radians_per_unit * t->angle[2][i]);
        const int gone = !(cosine > cos_min);
        if (gone) t->valid[i] = 0;
        for (size_t c = 0; c < t->n_channels; c++) {
            double *v = &t->value[c * t->n + i], *s = t->sigma ? &t->sigma[c * t->n + i] : v;
            *v = gone ? 0 : *v / cosine;
            if (s != v) *s = gone ? 0 : *s / cosine;
        }
    }
}

/* Has nobody said what the values are? A column that is called BRDF says it. */
static int is_open(const csv *f, const ff_read_options *o)
{
    if (f->head.is_ours || f->head.quantity_is_said || o->quantity >= 0) return 0;
    for (size_t c = 0; c < f->n_channels; c++)
        if (ff_csv_names_brdf(f->names.name[f->column[4 + c]])) return 0;
    return 1;
}

static void describe(const csv *f, const ff_read_options *o, ff_table *t)
{
    strcpy(t->format, "csv");
    t->angles_are_open = !f->head.is_ours;
    t->quantity_is_open = is_open(f, o);
    ff_table_leave_out_codes(t);
    if (f->n_errors)
        ff_table_note(t, "%zu %s a word in place of a number, as nan or #DIV/0!: not measured", f->n_errors,
                      f->n_errors == 1 ? "cell has" : "cells have");
    if (f->head.quantity == FF_BRDF_COS) divide_by_cosine(f, t);
    t->quantity = f->head.quantity;
    t->radians_per_unit = f->head.radians_per_unit;
    for (size_t c = 0; c < f->n_channels; c++) {
        strcpy(t->channels[c].name, channel_of(f->names.name[f->column[4 + c]])); /* ff_names_read checked the length */
        t->channels[c].wavelength_nm = ff_wavelength_of(t->channels[c].name);
        t->channels[c].scale = f->head.quantity == FF_REFLECTANCE_FACTOR ? 1 / pi : 1;
    }
    t->isotropic = f->head.isotropic >= 0 ? f->head.isotropic : ff_table_one_incidence_azimuth(t);
    if (f->head.radians_per_unit != 1 && t->n >= 20 && f->theta_largest > 0 && f->theta_largest <= 1.5708) {
        char largest[FF_NUMBER_TEXT + 1];
        largest[ff_number_write(round(f->theta_largest * 1e4) / 1e4, largest)] = '\0';
        ff_table_note_hint(t, FF_HINT_SAY, "the largest theta is %s degrees: are these radians? say angles radians", largest);
    }
    if (f->lines.unterminated) ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
}

/* "f=NAME,wavelength=NAME,...", by what the header has. */
static ff_status read_by_wavelength(csv *f, const ff_read_options *o, ff_table *out)
{
    char mapping[4096] = "";
    ff_read_options mapped = *o;
    mapped.columns = mapping;
    if (strcmp(f->path, "-") == 0)
        return ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, f->lines.line, -1,
                            "found a column of wavelengths, expected the option 'columns' to name it, as in wavelength=wavelength");
    for (size_t k = 0; k < f->names.n; k++) {
        const char *name = f->names.name[k], *sigma = sigma_of(name),
                   *key = is_angle(name) || strcmp(name, "weight") == 0 ? name
                          : sigma                                       ? "sigma"
                          : is_wavelength(name)                         ? "wavelength"
                                                                        : "f";
        const size_t used = strlen(mapping);
        if ((size_t)snprintf(mapping + used, sizeof mapping - used, "%s%s=\"%s\"", used ? "," : "", key, name) >=
            sizeof mapping - used)
            return wrong_header(f, name, "is beyond what is read with wavelengths in a column");
    }
    const ff_status status = ff_csv_read_columns(f->path, &mapped, NULL, out, f->err);
    if (status == FF_OK) ff_table_note(out, "a row for each wavelength, by the column that has their name");
    return status;
}

static ff_status read_all(csv *f, const ff_read_options *o, ff_table *out)
{
    ff_status status = read_header(f);
    if (status == FF_OK && has_row_per_wavelength(f)) return read_by_wavelength(f, o, out);
    f->head.quantity = ff_read_quantity(o, f->head.quantity);
    if (status == FF_OK && o->part)
        status =
            ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, 0, -1,
                         "found the option 'part', expected it where the option 'columns' names a wavelength that it can choose");
    if (status == FF_OK) status = read_rows(f);
    if (status == FF_OK && f->rows.n == 0)
        status =
            ff_error_set(f->err, FF_ERR_DATA, f->path, f->lines.line, -1, "found no rows after the header, expected at least one");
    if (status != FF_OK) return status;
    ff_table t;
    status = ff_rows_to_table(&f->rows, f->n_channels, f->with_sigma, f->with_weight, &t, f->err);
    if (status != FF_OK) return status;
    describe(f, o, &t);
    if (o->angles == FF_ANGLES_AS_FORMAT && !f->head.is_ours && ff_table_has_radian_azimuths(&t)) {
        ff_table_clear(&t);
        return ff_error_hint(
            f->err,
            ff_error_set(f->err, FF_ERR_DATA, f->path, 0, -1,
                         "found polar angles that are all below 1.571 and azimuths that are multiples of pi / 2: if they are "
                         "not in degrees (which angles degrees insists on), say angles radians"),
            FF_HINT_SAY);
    }
    return ff_table_hand_out(&t, f->path, out, f->err);
}

static ff_status read_csv(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    if (o->columns) return ff_csv_read_columns(path, o, NULL, out, err);
    csv f = {.err = err,
             .path = path,
             .angles = o->angles,
             .head = {.radians_per_unit = o->angles == FF_ANGLES_RADIANS ? 1 : degree, .isotropic = -1}};
    ff_csv_look look;
    ff_csv_dialect given;
    ff_status status = ff_csv_dialect_read(o->dialect, path, &given, err);
    if (status == FF_OK) status = ff_csv_look_at(path, &given, &look, err);
    if (status != FF_OK) return status;
    if (look.first_row && !look.is_ours) {
        status = ff_csv_read_table(path, o, &look, out, err);
        ff_csv_look_clear(&look);
        return status;
    }
    ff_csv_look_clear(&look);
    status = ff_lines_open(path, &f.lines, err);
    if (status != FF_OK) return status;
    status = read_all(&f, o, out);
    ff_lines_close(&f.lines);
    ff_names_free(&f.names);
    free(f.slot);
    free(f.column);
    free(f.may_be_empty);
    ff_rows_free(&f.rows);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

/* A header cell in quotes, where the name needs them. */
static void write_name(const char *prefix, const char *name, FILE *file)
{
    int quoted = strpbrk(name, ",\" ") != NULL;
    if (quoted) putc('"', file);
    fputs(prefix, file);
    for (; *name; name++) {
        if (*name == '"') putc('"', file);
        putc(*name, file);
    }
    if (quoted) putc('"', file);
}

static void write_header(const ff_table *t, FILE *file)
{
    fprintf(file, "# facetfit-csv: 1\n# quantity: brdf\n# angles: %s\n# isotropic: %s\n",
            t->radians_per_unit == 1 && !t->grid ? "radians" : "degrees", t->isotropic ? "yes" : "no");
    fputs("theta_i,phi_i,theta_o,phi_o", file);
    for (size_t c = 0; c < t->n_channels; c++) {
        const char *name = t->channels[c].name;
        int as_is = strcmp(name, "f") == 0 || !isnan(ff_wavelength_of(name));
        putc(',', file);
        write_name(as_is ? "" : "f_", name, file);
    }
    for (size_t c = 0; c < t->n_channels && t->sigma; c++) {
        putc(',', file);
        if (strcmp(t->channels[c].name, "f") == 0)
            fputs("sigma", file);
        else
            write_name("sigma_", t->channels[c].name, file);
    }
    fputs(ff_table_has_weights(t) ? ",weight\n" : "\n", file);
}

static void write_number(double v, FILE *file)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
}

/* ",v" for each channel of one plane (value or sigma), or just the commas. */
static void write_channels(const ff_table *t, const double *plane, size_t i, FILE *file)
{
    for (size_t c = 0; c < t->n_channels; c++) {
        putc(',', file);
        if (t->valid[i]) write_number(t->channels[c].scale * plane[c * t->n + i], file);
    }
}

static void write_rows(const ff_table *t, FILE *file)
{
    enum { BLOCK = 256 };
    double angle[4][BLOCK], weight[BLOCK];
    double *const planes[4] = {angle[0], angle[1], angle[2], angle[3]};
    double unit = t->radians_per_unit == 1 && !t->grid ? 1 : degree;
    for (size_t first = 0; first < t->n; first += BLOCK) {
        size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_angles(t, unit, first, n, planes);
        if (ff_table_has_weights(t)) ff_table_weights(t, first, n, weight);
        for (size_t k = 0; k < n; k++) {
            for (int a = 0; a < 4; a++) {
                if (a) putc(',', file);
                write_number(angle[a][k], file);
            }
            write_channels(t, t->value, first + k, file);
            if (t->sigma) write_channels(t, t->sigma, first + k, file);
            if (ff_table_has_weights(t)) {
                putc(',', file);
                write_number(weight[k], file);
            }
            putc('\n', file);
        }
    }
}

static ff_status check_names(const char *path, const ff_table *t, ff_error *err)
{
    for (size_t c = 0; c < t->n_channels; c++) {
        char found[FF_QUOTE];
        const char *name = t->channels[c].name;
        int bad = name[0] == '\0' || strlen(name) + sizeof "sigma_" > FF_CHANNEL_NAME || ff_table_channel_find(t, name) != (int)c;
        for (const char *p = name; *p; p++) bad |= (unsigned char)*p < 0x20 || *p == 0x7F;
        if (bad)
            return ff_error_set(
                err, FF_ERR_UNSUPPORTED, path, 0, -1,
                "found channel %zu named %s, expected a name of its own of 1 to %zu bytes without control characters", c,
                ff_quote(name, strlen(name), found), FF_CHANNEL_NAME - sizeof "sigma_");
    }
    return FF_OK;
}

static ff_status write_csv(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_output out;
    ff_status status = check_names(path, t, err);
    if (status == FF_OK) status = ff_table_check(t, path, err);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    write_header(t, out.file);
    write_rows(t, out.file);
    return ff_output_commit(&out, err);
}

const ff_format ff_format_csv = {
    .name = "csv",
    .title = "facetfit's own CSV: scattered directions, any channels, standard deviations, weights",
    .extensions = ".csv",
    .source = "docs/csv.md",
    .probe = ff_csv_probe,
    .reads = FF_READS_COLUMNS | FF_READS_DIALECT | FF_READS_PART | FF_READS_QUANTITY,
    .holds =
        FF_HOLDS_SIGMA | FF_HOLDS_INVALID | FF_HOLDS_NEGATIVE | FF_HOLDS_NAMES | FF_HOLDS_DOUBLE | FF_HOLDS_WEIGHTS | FF_HOLDS_MANY,
    .read = read_csv,
    .write = write_csv,
};
