/* ALTA (Belcour, Barla, Pacanowski), its text files: a header of '#KEY value' lines, then rows of numbers separated by blanks.
 *
 *     #DIM nX nY                  numbers of a row: nX coordinates, nY values
 *     #PARAM_IN NAME              what the coordinates are, see alta/alta_coordinates.c; radians
 *     #PARAM_OUT NAME             INV_STERADIAN: f; INV_STERADIAN_COSINE_FACTOR: f cos(theta_v);
 *                                 RGB_COLOR, XYZ_COLOR: f of three channels
 *     #VS 0|1|2                   0 or missing: no more columns; 1: half-widths of intervals about the values; 2: their two ends
 *     #CHANNELS r,g,b             written by this program only: names of the values
 *     #ISOTROPIC 0|1              likewise: 1 = only differences of azimuth mean something
 *     # text                      a comment; so are other keys, and every '#' line after the first row
 *
 * L is the light and V the view, both pointing away from the surface, azimuths counter-clockwise: this program's frame. L = V is
 * retro-reflection: in the tapes of hal-01083366 the retro-reflected peak stands at L = V, the mirror image at a difference of pi.
 * "Cosine factor" is that "of the output direction" (params.h), theta_v; the values of those tapes obey reciprocity after division
 * by it. RUSIN_*: ALTA measures the difference angles of V, where others take L; the pair is the same but for reciprocity.
 *
 * Where ALTA's two directions of conversion disagree, or one is wrong, the documented meaning is read:
 *
 *     STEREOGRAPHIC               the inverse of its from_cartesian; its to_cartesian does not give unit vectors
 *     STARK_3D, NEUMANN_3D        phi_B of B = (L - V)/2 as documented and as from_cartesian has it; to_cartesian turns B around
 *     RETRO_TL_TVL_PROJ_DPHI      the point at the arc theta_VL from L; to_cartesian forgets on which side of the normal it lies
 *     ..._DPHI with sin           V at +phi from L as in to_cartesian; from_cartesian has the mirror image
 *
 * #VS: in current versions of ALTA only the first value of a row has an interval; a column per value is what its binary format has.
 * Both are read. The intervals have no stated level: half their width is taken as the standard deviation.
 * Samples that were not measured and weights are not written: the format has no place for them. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include "base/internal_tokens.h"
#include "data_formats/formats/alta/internal_alta.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- reading: the header --------------------------------------------------------------------- */

enum { COORDINATES_MAX = 6 };

typedef struct alta {
    ff_lines lines;
    ff_error *err;
    const char *path;
    const ff_read_options *options;
    size_t n_x, n_y; /* #DIM; 0 = not said */
    const ff_alta_parametrisation *in;
    char out[40];             /* #PARAM_OUT, "" = not said */
    int intervals, isotropic; /* #VS; #ISOTROPIC or -1 */
    ff_names names;           /* #CHANNELS */
    size_t n_columns;         /* of a row, known from the first one on */
    int with_sigma;           /* the rows have an interval for each value */
    double *x;                /* [n_columns] a row of the file */
    size_t n_no_pair;
    ff_rows rows;
} alta;

static long line_of(const alta *a)
{
    return a->lines.line;
}

static ff_status bad_key(const alta *a, const char *key, const char *found, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1, "#%s: found %s, expected %s", key,
                        ff_quote(found, strlen(found), quoted), expected);
}

/* The rest of '#KEY value' without the blanks around it; NULL when the line has another key. */
static char *value_of(char *line, const char *key)
{
    const size_t n = strlen(key);
    if (strncmp(line + 1, key, n) != 0 || (line[n + 1] && !strchr(" \t", line[n + 1]))) return NULL;
    line += 1 + n;
    line += strspn(line, " \t");
    for (char *end = line + strlen(line); end > line && strchr(" \t", end[-1]);) *--end = '\0';
    return line;
}

static ff_status read_dimensions(alta *a, const char *key, char *value)
{
    char text[48];
    uint64_t n[2];
    const size_t first = strcspn(value, " \t");
    const char *second = value + first + strspn(value + first, " \t");
    if (first >= sizeof text) return bad_key(a, key, value, "two whole numbers");
    memcpy(text, value, first);
    text[first] = '\0';
    if (!ff_whole_number(text, COORDINATES_MAX, &n[0]) || !ff_whole_number(second, FF_NAMES_MAX, &n[1]) || !n[0] || !n[1])
        return bad_key(a, key, value, "two whole numbers, 1 to 6 coordinates and 1 to 4096 values");
    a->n_x = (size_t)n[0];
    a->n_y = (size_t)n[1];
    return FF_OK;
}

static ff_status read_param_in(alta *a, const char *key, char *value)
{
    a->in = ff_alta_parametrisation_find(value);
    if (!a->in) return bad_key(a, key, value, "a parametrisation of two directions, SPHERICAL_TL_PL_TV_PV or another of ALTA's");
    if (a->in->convert) return FF_OK;
    return ff_error_set(a->err, FF_ERR_UNSUPPORTED, a->path, line_of(a), -1,
                        "#PARAM_IN: found %s, which tells %s only, expected coordinates that determine two directions", a->in->name,
                        a->in->expected);
}

static ff_status read_param_out(alta *a, const char *key, char *value)
{
    static const char *const known[] = {"INV_STERADIAN", "INV_STERADIAN_COSINE_FACTOR", "RGB_COLOR", "XYZ_COLOR", "UNKNOWN_OUTPUT"};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (strcmp(value, known[k]) == 0) {
            strcpy(a->out, k < 4 ? known[k] : "");
            return FF_OK;
        }
    if (strcmp(value, "ENERGY") != 0)
        return bad_key(a, key, value, "INV_STERADIAN, INV_STERADIAN_COSINE_FACTOR, RGB_COLOR or XYZ_COLOR");
    if (a->options->quantity >= 0) return FF_OK;
    return ff_error_hint(a->err,
                         ff_error_set(a->err, FF_ERR_UNSUPPORTED, a->path, line_of(a), -1,
                                      "#PARAM_OUT: found ENERGY, which ALTA does not define, expected INV_STERADIAN or the like"),
                         FF_HINT_QUANTITY);
}

static ff_status read_vs(alta *a, const char *key, char *value)
{
    uint64_t n;
    if (!ff_whole_number(value, 2, &n)) return bad_key(a, key, value, "0, 1 or 2");
    a->intervals = (int)n;
    return FF_OK;
}

static ff_status read_isotropic(alta *a, const char *key, char *value)
{
    uint64_t n;
    if (!ff_whole_number(value, 1, &n)) return bad_key(a, key, value, "0 or 1");
    a->isotropic = (int)n;
    return FF_OK;
}

static ff_status read_channels(alta *a, const char *key, char *value)
{
    (void)key;
    ff_names_free(&a->names);
    return ff_names_read(value, strlen(value), a->path, line_of(a), &a->names, a->err);
}

static ff_status read_encoding(alta *a, const char *key, char *value)
{
    (void)key;
    if (strcmp(value, "text") == 0) return FF_OK;
    char quoted[FF_QUOTE];
    return ff_error_set(a->err, FF_ERR_UNSUPPORTED, a->path, line_of(a), -1,
                        "#FORMAT: found %s, expected ALTA's text files: data2data converts",
                        ff_quote(value, strlen(value), quoted));
}

static ff_status read_comment(alta *a, char *text)
{
    static const struct {
        const char *key;
        ff_status (*read)(alta *, const char *, char *);
    } keys[] = {{"DIM", read_dimensions},  {"PARAM_IN", read_param_in},   {"PARAM_OUT", read_param_out}, {"VS", read_vs},
                {"FORMAT", read_encoding}, {"ISOTROPIC", read_isotropic}, {"CHANNELS", read_channels}};
    char *value;
    for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++)
        if ((value = value_of(text, keys[k].key))) return keys[k].read(a, keys[k].key, value);
    return FF_OK;
}

static ff_status check_header(const alta *a)
{
    const char *missing = !a->n_x ? "#DIM" : !a->in ? "#PARAM_IN" : NULL;
    if (missing)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1,
                            "found numbers before a line %s, expected it in the header", missing);
    if (a->n_x != a->in->dimension)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1,
                            "#DIM: found %zu coordinates, expected %zu, as many as %s has", a->n_x, a->in->dimension, a->in->name);
    if (a->names.n && a->names.n != a->n_y)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1,
                            "#CHANNELS: found %zu names, expected %zu, one per value", a->names.n, a->n_y);
    return FF_OK;
}

/* ---- reading: rows --------------------------------------------------------------------------- */

static size_t count_numbers(const char *p)
{
    size_t n = 0;
    for (;;) {
        p += strspn(p, " \t,\r");
        if (!*p || *p == '#') return n;
        p += strcspn(p, " \t,\r");
        n++;
    }
}

/* What the rows have, from the first one. */
static ff_status settle_columns(alta *a, const char *text)
{
    ff_status status = check_header(a);
    if (status != FF_OK) return status;
    const size_t n = a->n_x + a->n_y, found = count_numbers(text), of_one = (size_t)a->intervals, of_all = of_one * a->n_y;
    if (found != n && found != n + of_one && found != n + of_all)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1,
                            "found %zu numbers, expected %zu coordinates, %zu values and, as #VS says, %zu per value", found,
                            a->n_x, a->n_y, of_one);
    if (a->intervals && found == n)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1,
                            "found %zu numbers, expected %zu: #VS says that there are intervals", found, n + of_one);
    a->n_columns = found;
    a->with_sigma = a->intervals && found == n + of_all && (a->intervals == 1 || a->n_y == 1);
    a->rows.width = ff_rows_width(a->n_y, a->with_sigma, 0);
    a->x = malloc(found * sizeof *a->x);
    return a->x ? FF_OK : ff_error_set(a->err, FF_ERR_MEMORY, a->path, line_of(a), -1, "no memory for %zu columns", found);
}

static ff_status take_row(alta *a)
{
    double *row = ff_rows_add(&a->rows);
    if (!row) return ff_error_set(a->err, FF_ERR_MEMORY, a->path, line_of(a), -1, "no memory for row %zu", a->rows.n + 1);
    double *value = row + 4;
    const double *y = a->x + a->n_x;
    const ff_alta_conversion found = a->in->convert(a->x, row);
    if (found == FF_ALTA_WRONG)
        return ff_error_set(a->err, FF_ERR_DATA, a->path, line_of(a), -1, "found coordinates %g, %g ..., expected %s%s", a->x[0],
                            a->x[1], a->in->expected, strstr(a->in->expected, "radians") ? ": are these degrees?" : "");
    memcpy(value, y, a->n_y * sizeof *value);
    if (a->with_sigma && a->intervals == 1) memcpy(value + a->n_y, y + a->n_y, a->n_y * sizeof *value);
    if (a->with_sigma && a->intervals == 2) value[1] = (y[2] - y[1]) / 2;
    if (found == FF_ALTA_NO_PAIR) {
        value[0] = NAN;
        a->n_no_pair++;
    }
    return FF_OK;
}

static ff_status read_row(alta *a, const char *text)
{
    size_t n;
    if (!text[strspn(text, " \t,\r")]) return FF_OK;
    ff_status status = a->x ? FF_OK : settle_columns(a, text);
    if (status == FF_OK)
        status = ff_line_numbers(text, a->x, a->n_columns, &n, a->path, line_of(a), "a row as the first one", a->err);
    if (status != FF_OK) return status;
    if (n == 0) return FF_OK;
    if (n != a->n_columns)
        return ff_error_set(a->err, FF_ERR_FORMAT, a->path, line_of(a), -1, "found %zu numbers, expected %zu as in the first row",
                            n, a->n_columns);
    return take_row(a);
}

static ff_status read_lines(alta *a)
{
    for (;;) {
        char *text;
        size_t length;
        ff_status status = ff_lines_next(&a->lines, &text, &length, a->err);
        if (status != FF_OK) return status;
        if (!text) break;
        if (*text == '#')
            status = a->x ? FF_OK : read_comment(a, text);
        else
            status = read_row(a, text);
        if (status != FF_OK) return status;
    }
    if (a->rows.n > 0) return FF_OK;
    return ff_error_set(a->err, FF_ERR_READ, a->path, line_of(a), -1, "found no rows of numbers, expected at least one");
}

/* ---- reading: the table ---------------------------------------------------------------------- */

static void name_channels(const alta *a, ff_table *t)
{
    static const char *const three[2][3] = {{"r", "g", "b"}, {"X", "Y", "Z"}};
    const int xyz = strcmp(a->out, "XYZ_COLOR") == 0;
    for (size_t c = 0; c < a->n_y; c++) {
        ff_channel *channel = &t->channels[c];
        if (a->names.n)
            strcpy(channel->name, a->names.name[c]); /* ff_names_read checked the length */
        else if (a->n_y == 3 && (xyz || strcmp(a->out, "RGB_COLOR") == 0))
            strcpy(channel->name, three[xyz][c]);
        else if (a->n_y == 1)
            strcpy(channel->name, "f");
        channel->wavelength_nm = ff_wavelength_of(channel->name);
    }
}

/* Standard deviations must be more than 0. */
static void check_sigmas(ff_table *t)
{
    for (size_t i = 0; i < t->n * t->n_channels; i++) {
        if (!t->valid[i % t->n] || t->sigma[i] > 0) continue;
        ff_table_note(t, "the intervals of #VS are left out: sample %zu has none of a width more than 0", i % t->n);
        free(t->sigma);
        t->sigma = NULL;
        return;
    }
    ff_table_note(t, "half the width of the intervals of #VS is taken as the standard deviation");
}

static void describe(const alta *a, ff_table *t)
{
    strcpy(t->format, "alta");
    name_channels(a, t);
    t->isotropic = a->isotropic >= 0 ? a->isotropic : a->in->isotropic || ff_table_one_incidence_azimuth(t);
    if (a->in->note) ff_table_note(t, a->in->note, a->in->name);
    if (!a->out[0] && a->options->quantity < 0)
        ff_table_note_hint(t, FF_HINT_QUANTITY_BRDF_COS,
                           "there is no #PARAM_OUT: the values are taken as the BRDF without a cosine");
    if (a->n_no_pair) ff_table_note(t, "%zu samples have coordinates of no pair of directions and are left out", a->n_no_pair);
    if (a->with_sigma)
        check_sigmas(t);
    else if (a->intervals)
        ff_table_note(t,
                      "the intervals of #VS are left out: they are not of every value, or in an order that ALTA does not define");
    if (a->lines.unterminated) ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
    ff_table_set_quantity(t, ff_read_quantity(a->options, strcmp(a->out, "INV_STERADIAN_COSINE_FACTOR") ? FF_BRDF : FF_BRDF_COS));
}

static ff_status read_all(alta *a, ff_table *out)
{
    ff_status status = read_lines(a);
    if (status != FF_OK) return status;
    ff_table t;
    status = ff_rows_to_table(&a->rows, a->n_y, a->with_sigma, 0, &t, a->err);
    if (status != FF_OK) return status;
    describe(a, &t);
    return ff_table_hand_out(&t, a->path, out, a->err);
}

static ff_status read_alta(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    alta a = {.err = err, .path = path, .options = o, .isotropic = -1};
    ff_status status = ff_lines_open(path, &a.lines, err);
    if (status != FF_OK) return status;
    status = read_all(&a, out);
    ff_lines_close(&a.lines);
    ff_names_free(&a.names);
    ff_rows_free(&a.rows);
    free(a.x);
    return status;
}

/* The header may end within a binary file, which the reader refuses by its name. */
static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    const char *p = (const char *)head, *stop = p + n;
    int dimensions = 0, parametrised = 0;
    while (p < stop && *p == '#') {
        const size_t left = (size_t)(stop - p);
        dimensions |= left > 5 && (memcmp(p, "#DIM ", 5) == 0 || memcmp(p, "#DIM\t", 5) == 0);
        parametrised |= left > 10 && (memcmp(p, "#PARAM_IN ", 10) == 0 || memcmp(p, "#PARAM_IN\t", 10) == 0);
        p = memchr(p, '\n', left);
        p = p ? p + 1 : stop;
    }
    return dimensions && parametrised ? 95 : parametrised ? 80 : dimensions ? 60 : 0;
}

/* ---- writing --------------------------------------------------------------------------------- */

static int has_names(const ff_table *t, const char *const *names, size_t n)
{
    if (t->n_channels != n) return 0;
    for (size_t c = 0; c < n; c++)
        if (strcmp(t->channels[c].name, names[c]) != 0) return 0;
    return 1;
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    if (t->n_channels > FF_NAMES_MAX)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "found %zu channels, expected at most %d", t->n_channels,
                            FF_NAMES_MAX);
    for (size_t c = 0; c < t->n_channels; c++) {
        char found[FF_QUOTE];
        const char *name = t->channels[c].name;
        const size_t n = strlen(name);
        int bad =
            n == 0 || strpbrk(name, ",\"") || name[0] == ' ' || name[n - 1] == ' ' || ff_table_channel_find(t, name) != (int)c;
        for (const char *p = name; *p; p++) bad |= (unsigned char)*p < 0x20 || *p == 0x7F;
        if (bad)
            return ff_error_set(
                err, FF_ERR_UNSUPPORTED, path, 0, -1,
                "found channel %zu named %s, expected a name of its own without commas, quotes and control characters", c,
                ff_quote(name, n, found));
    }
    return ff_table_check(t, path, err);
}

static void write_header(const ff_table *t, FILE *file)
{
    static const char *const one[] = {"f"}, *const rgb[] = {"r", "g", "b"}, *const xyz[] = {"X", "Y", "Z"};
    const int colours = has_names(t, rgb, 3) ? 1 : has_names(t, xyz, 3) ? 2 : 0;
    static const char *const out[] = {"INV_STERADIAN", "RGB_COLOR", "XYZ_COLOR"};
    fprintf(file, "#DIM 4 %zu\n#PARAM_IN SPHERICAL_TL_PL_TV_PV\n#PARAM_OUT %s\n#VS %d\n#ISOTROPIC %d\n", t->n_channels,
            out[colours], t->sigma ? 1 : 0, t->isotropic ? 1 : 0);
    if (colours || has_names(t, one, 1)) return;
    for (size_t c = 0; c < t->n_channels; c++) fprintf(file, "%s%s", c ? "," : "#CHANNELS ", t->channels[c].name);
    putc('\n', file);
}

static void write_number(double v, char before, FILE *file)
{
    char number[FF_NUMBER_TEXT];
    if (before) putc(before, file);
    fwrite(number, 1, ff_number_write(v, number), file);
}

static void write_rows(const ff_table *t, FILE *file)
{
    enum { BLOCK = 256 };
    double angle[4][BLOCK];
    double *const planes[4] = {angle[0], angle[1], angle[2], angle[3]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_angles(t, 1, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            if (!t->valid[first + k]) continue;
            for (int j = 0; j < 4; j++) write_number(angle[j][k], j ? '\t' : '\0', file);
            for (size_t c = 0; c < t->n_channels; c++)
                write_number(t->channels[c].scale * t->value[c * t->n + first + k], '\t', file);
            for (size_t c = 0; c < t->n_channels && t->sigma; c++)
                write_number(t->channels[c].scale * t->sigma[c * t->n + first + k], '\t', file);
            putc('\n', file);
        }
    }
}

static ff_status write_alta(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_output out;
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    write_header(t, out.file);
    write_rows(t, out.file);
    return ff_output_commit(&out, err);
}

const ff_format ff_format_alta = {
    .name = "alta",
    .title = "ALTA text: two directions in any of its parametrisations, any channels, standard deviations",
    .extensions = ".alta",
    .source = "ALTA, sources/core/params.cpp and data_storage.cpp",
    .probe = probe,
    .reads = FF_READS_QUANTITY,
    .holds = FF_HOLDS_SIGMA | FF_HOLDS_NEGATIVE | FF_HOLDS_NAMES | FF_HOLDS_DOUBLE | FF_HOLDS_MANY,
    .read = read_alta,
    .write = write_alta,
};
