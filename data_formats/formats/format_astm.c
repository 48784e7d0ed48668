/* ASTM E1392: angle-resolved scatter data, as instruments of Light Tec and others write it.
 *
 *     KEY value                      any number of lines; NUM_POINTS is checked, the rest is for people
 *     VARS theta_i,phi_i,theta_s,phi_s,465nm,...
 *     numbers, comma separated       one line per point; angles in radians, BRDF in 1/sr without the cosine
 *
 * What is named neither theta_i, phi_i, theta_s nor phi_s is a channel. A file may leave phi_i out (then pi, the standard's side of
 * the source) or phi_s (then 0, the plane of incidence, where theta_s < 0 is the side of the source). Some writers leave phi_s out
 * of VARS but not out of the rows: a row of exactly one number more is read as such, and the table says so. Negative values are
 * noise and stay. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "base/internal_tokens.h"
#include "data_formats/table/internal_table.h"
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double pi = 3.14159265358979323846;
static const double theta_max = 3.14159265358979323846 + 1e-9; /* files round pi to the digits they have */

typedef struct astm {
    ff_lines lines;
    ff_error *err;
    const char *path;
    long points;    /* NUM_POINTS, -1 = not stated */
    ff_names names; /* as in VARS, with phi_s where only the rows have it */
    int unnamed_phi_s;
    size_t n_channels;
    long column[4]; /* of theta_i, phi_i, theta_s, phi_s; -1 = not there */
    size_t *slot;
    unsigned char *may_be_empty;
    ff_rows rows;
} astm;

/* Rest of the line after KEY, or NULL when it starts with another word. */
static const char *value_of(const char *line, const char *key)
{
    size_t n = strlen(key);
    if (strncasecmp(line, key, n) != 0 || (line[n] != ' ' && line[n] != '\t' && line[n] != '\0')) return NULL;
    return line + n + strspn(line + n, " \t");
}

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    if (memchr(head, '\0', n)) return 0;
    int keys = 0;
    const char *p = (const char *)head, *stop = p + n;
    for (const char *line = p; line && line < stop;) {
        if (stop - line > 5 && strncasecmp(line, "VARS", 4) == 0 && (line[4] == ' ' || line[4] == '\t')) return 95;
        if (stop - line > 11 && strncasecmp(line, "NUM_POINTS", 10) == 0) keys += 2;
        if (stop - line > 9 && strncasecmp(line, "LAB_NAME ", 9) == 0) keys++;
        line = memchr(line, '\n', (size_t)(stop - line));
        if (line) line++;
    }
    return 25 * keys;
}

/* ---- header ---------------------------------------------------------------------------------- */

static ff_status read_points(astm *a, const char *text)
{
    char found[FF_QUOTE], word[32];
    uint64_t points = 0;
    const size_t length = strcspn(text, " \t");
    if (length < sizeof word && text[length + strspn(text + length, " \t")] == '\0') {
        memcpy(word, text, length);
        word[length] = '\0';
        if (!ff_whole_number(word, LONG_MAX - 1, &points)) points = 0;
    }
    if (points < 1)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, a->lines.line, -1, "NUM_POINTS: found %s, expected a whole number >= 1",
                            ff_quote(text, strlen(text), found));
    a->points = (long)points;
    return FF_OK;
}

static int angle_of(const char *name)
{
    static const char *const known[4][3] = {{"theta_i"}, {"phi_i"}, {"theta_s", "theta_r", "theta_o"}, {"phi_s", "phi_r", "phi_o"}};
    for (int k = 0; k < 4; k++)
        for (int j = 0; j < 3 && known[k][j]; j++)
            if (strcasecmp(name, known[k][j]) == 0) return k;
    return -1;
}

static ff_status read_vars(astm *a, const char *text)
{
    static const char *const angle_name[4] = {"theta_i", "phi_i", "theta_s", "phi_s"};
    char found[FF_NAMES_LIST];
    ff_status status = ff_names_read(text, strlen(text), a->path, a->lines.line, &a->names, a->err);
    if (status != FF_OK) return status;
    for (size_t k = 0; k < a->names.n; k++) {
        int angle = angle_of(a->names.name[k]);
        if (angle < 0)
            a->n_channels++;
        else if (a->column[angle] >= 0)
            return ff_error_set(a->err, FF_ERR_FORMAT, a->path, a->lines.line, -1,
                                "VARS: found two columns for %s (%s and %s), expected one", angle_name[angle],
                                a->names.name[a->column[angle]], a->names.name[k]);
        else
            a->column[angle] = (long)k;
    }
    for (int k = 0; k < 4; k += 2)
        if (a->column[k] < 0)
            return ff_error_set(a->err, FF_ERR_FORMAT, a->path, a->lines.line, -1, "VARS: found %s, expected a column %s",
                                ff_names_list(&a->names, found), angle_name[k]);
    if (a->n_channels == 0)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, a->lines.line, -1,
                            "VARS: found %s, expected at least one column of values too", ff_names_list(&a->names, found));
    return FF_OK;
}

static ff_status read_header(astm *a)
{
    char *text, found[FF_QUOTE];
    size_t length;
    for (;;) {
        ff_status status = ff_lines_next(&a->lines, &text, &length, a->err);
        if (status != FF_OK) return status;
        if (!text)
            return ff_error_set(a->err, FF_ERR_READ, a->path, a->lines.line, -1,
                                "found the end of the file, expected a line VARS and rows of numbers");
        text += strspn(text, " \t");
        const char *value;
        if ((value = value_of(text, "VARS"))) return read_vars(a, value);
        if ((value = value_of(text, "NUM_POINTS")) && (status = read_points(a, value)) != FF_OK) return status;
        if (*text && strchr("+-.0123456789", *text))
            return ff_error_set(a->err, FF_ERR_FORMAT, a->path, a->lines.line, -1,
                                "found %s, expected 'KEY value' or VARS before the numbers", ff_quote(text, strlen(text), found));
    }
}

/* ---- columns: settled by the first row ------------------------------------------------------- */

static ff_status insert_phi_s(astm *a)
{
    static char phi_s[] = "phi_s";
    char **name = realloc(a->names.name, (a->names.n + 1) * sizeof *name);
    if (!name) return ff_error_set(a->err, FF_ERR_MEMORY, a->path, a->lines.line, -1, "no memory for the names of columns");
    a->names.name = name;
    size_t at = (size_t)a->column[2] + 1;
    memmove(name + at + 1, name + at, (a->names.n - at) * sizeof *name);
    name[at] = phi_s;
    a->names.n++;
    for (int k = 0; k < 3; k++) a->column[k] += a->column[k] >= (long)at;
    a->column[3] = (long)at;
    a->unnamed_phi_s = 1;
    return FF_OK;
}

static ff_status settle_columns(astm *a, const char *row)
{
    size_t cells = 1;
    for (const char *p = row; *p; p++) cells += *p == ',';
    if (cells == a->names.n + 1 && a->column[1] >= 0 && a->column[3] < 0) {
        ff_status status = insert_phi_s(a);
        if (status != FF_OK) return status;
    }
    a->slot = malloc((a->names.n + 1) * sizeof *a->slot);
    a->may_be_empty = calloc(a->names.n + 1, 1);
    if (!a->slot || !a->may_be_empty)
        return ff_error_set(a->err, FF_ERR_MEMORY, a->path, a->lines.line, -1, "no memory for %zu columns", a->names.n);
    size_t channel = 0;
    for (size_t k = 0; k < a->names.n; k++) {
        int angle = angle_of(a->names.name[k]);
        a->slot[k] = angle >= 0 ? (size_t)angle : 4 + channel++;
    }
    a->rows.width = ff_rows_width(a->n_channels, 0, 0);
    return FF_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

static ff_status read_row(astm *a, const char *text, size_t length)
{
    if (a->points >= 0 && a->rows.n == (size_t)a->points)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, a->lines.line, -1, "found more rows, expected %ld as NUM_POINTS says",
                            a->points);
    double *row = ff_rows_add(&a->rows);
    if (!row) return ff_error_set(a->err, FF_ERR_MEMORY, a->path, a->lines.line, -1, "no memory for row %zu", a->rows.n + 1);
    row[1] = pi;
    const ff_columns columns = {a->names.n, a->names.name, a->slot, a->may_be_empty, NULL};
    ff_status status = ff_row_read(text, length, &columns, row, a->path, a->lines.line, a->err);
    if (status != FF_OK) return status;
    for (int k = 0; k < 4; k += 2)
        if (!(fabs(row[k]) <= theta_max))
            return ff_error_set(a->err, FF_ERR_DATA, a->path, a->lines.line, -1,
                                "column '%s': found %g, expected radians of at most pi: are these degrees?",
                                a->names.name[a->column[k]], row[k]);
    return FF_OK;
}

static ff_status read_rows(astm *a)
{
    char *text;
    size_t length;
    for (;;) {
        ff_status status = ff_lines_next(&a->lines, &text, &length, a->err);
        if (status != FF_OK || !text) return status;
        if (text[strspn(text, " \t")] == '\0') continue;
        if (!a->slot) status = settle_columns(a, text);
        if (status == FF_OK) status = read_row(a, text, length);
        if (status != FF_OK) return status;
    }
}

static ff_status check_count(const astm *a)
{
    if (a->rows.n == 0)
        return ff_error_set(a->err, FF_ERR_READ, a->path, a->lines.line, -1, "found no rows of numbers after VARS, expected %s",
                            a->points > 0 ? "as many as NUM_POINTS says" : "at least one");
    if (a->points >= 0 && a->rows.n < (size_t)a->points)
        return ff_error_set(a->err, FF_ERR_READ, a->path, a->lines.line, -1,
                            "found the end of the file after %zu rows, expected %ld as NUM_POINTS says", a->rows.n, a->points);
    return FF_OK;
}

static void describe(const astm *a, ff_table *t)
{
    strcpy(t->format, "astm");
    for (size_t k = 0; k < a->names.n; k++) {
        if (a->slot[k] < 4) continue;
        ff_channel *c = &t->channels[a->slot[k] - 4];
        strcpy(c->name, a->names.name[k]); /* ff_names_read checked the length */
        c->wavelength_nm = ff_wavelength_of(c->name);
    }
    t->isotropic = ff_table_one_incidence_azimuth(t);
    if (a->unnamed_phi_s)
        ff_table_note(t, "VARS names %zu columns, the rows have %zu: the one after %s is taken to be phi_s", a->names.n - 1,
                      a->names.n, a->names.name[a->column[2]]);
    if (a->column[1] < 0) ff_table_note(t, "there is no phi_i: pi is assumed, the standard's side of the source");
    if (a->column[3] < 0) ff_table_note(t, "there is no phi_s: 0 is assumed, the plane of incidence");
    if (a->points < 0) ff_table_note(t, "NUM_POINTS is missing: it cannot be known whether all rows are there");
    if (a->lines.unterminated) ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
}

static ff_status read_all(astm *a, ff_table *out)
{
    ff_status status = read_header(a);
    if (status == FF_OK) status = read_rows(a);
    if (status == FF_OK) status = check_count(a);
    if (status != FF_OK) return status;
    ff_table t;
    status = ff_rows_to_table(&a->rows, a->n_channels, 0, 0, &t, a->err);
    if (status != FF_OK) return status;
    describe(a, &t);
    return ff_table_hand_out(&t, a->path, out, a->err);
}

static ff_status read_astm(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    astm a = {.err = err, .path = path, .points = -1, .column = {-1, -1, -1, -1}};
    ff_status status = ff_lines_open(path, &a.lines, err);
    if (status != FF_OK) return status;
    status = read_all(&a, out);
    ff_lines_close(&a.lines);
    ff_names_free(&a.names);
    free(a.slot);
    free(a.may_be_empty);
    ff_rows_free(&a.rows);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "an ASTM file has no column for the standard deviations of this table; write csv");
    for (size_t c = 0; c < t->n_channels; c++) {
        const char *name = t->channels[c].name;
        if (name[0] == '\0' || strpbrk(name, ", \t\r\n\"") || angle_of(name) >= 0)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                                "found channel '%s', expected a name without spaces, commas and quotes that is no angle's", name);
    }
    return ff_table_check(t, path, err);
}

static void write_rows(const ff_table *t, FILE *file)
{
    enum { BLOCK = 256 };
    double angle[4][BLOCK];
    double *const planes[4] = {angle[0], angle[1], angle[2], angle[3]};
    char number[FF_NUMBER_TEXT];
    for (size_t first = 0; first < t->n; first += BLOCK) {
        size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_angles(t, 1, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            if (!t->valid[first + k]) continue;
            for (int j = 0; j < 4; j++) {
                fwrite(number, 1, ff_number_write(angle[j][k], number), file);
                putc(',', file);
            }
            for (size_t c = 0; c < t->n_channels; c++) {
                double f = t->channels[c].scale * t->value[c * t->n + first + k];
                fwrite(number, 1, ff_number_write(f, number), file);
                putc(c + 1 < t->n_channels ? ',' : '\n', file);
            }
        }
    }
}

/* Samples that were not measured are left out: the format has no way to say so. So are weights. */
static ff_status write_astm(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_output out;
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    size_t n_valid = 0;
    for (size_t i = 0; i < t->n; i++) n_valid += t->valid[i] != 0;
    fprintf(out.file, "MEAS_NAME BRDF\nNUM_POINTS %zu\nVARS theta_i,phi_i,theta_s,phi_s", n_valid);
    for (size_t c = 0; c < t->n_channels; c++) fprintf(out.file, ",%s", t->channels[c].name);
    fputs("\n\n", out.file);
    write_rows(t, out.file);
    return ff_output_commit(&out, err);
}

const ff_format ff_format_astm = {
    .name = "astm",
    .title = "ASTM E1392 angle-resolved scatter, any number of wavelengths",
    .extensions = ".astm",
    .source = "ASTM E1392, as written by Light Tec Mini-Diff",
    .probe = probe,
    .holds = FF_HOLDS_NEGATIVE | FF_HOLDS_NAMES | FF_HOLDS_DOUBLE | FF_HOLDS_MANY,
    .read = read_astm,
    .write = write_astm,
};
