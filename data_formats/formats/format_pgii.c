/* pab's pgII gonio-photometer, text files of its program mountain: one incidence, a scan of outgoing directions.
 *
 *     #pgII ...                                  '#' lines: 'key value', of which these mean something here
 *     #incident_angle 26.8421 0                  theta and phi of the light, degrees; #intheta and #inphi say the same
 *     #format: theta phi BSDF                    what the third column is
 *     #colorimetry: CIE-XYZ                      three values per row; CIE-Y or nothing: one
 *     #datapoints_in_file 127039
 *     89.98829 44.44809 2.138e-06                rows: theta, phi in degrees, value
 *
 * Both directions point away from the sample in one spherical frame, so that the mirror reflection of (theta, 0) is (theta, 180),
 * as here (pab: "compatible to Standard E2387"; the peak of a scan at 26.84 0 is at 29.2 178.6). BSDF and BRDF are f. DSF is f
 * cos(theta_o). A unit in brackets, [uA], is what the detector gave: not calibrated, refused unless the person says the factor.
 * pab: "the measured signal is proportional to the incident power on the detector", which sees the whole lit area from afar; so it
 * goes like the DSF, and is read as that unless the person says otherwise. Its scans agree: towards 90 degrees they fall to zero
 * like the cosine. Rows on the other side of the sample than the light are transmission: they are there as samples that were not
 * measured. With the light at theta > 90, behind the sample, the frame is turned over about x: theta -> 180 - theta, phi -> -phi.
 */
#define _GNU_SOURCE
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include "base/internal_tokens.h"
#include <math.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;

typedef struct pgii {
    ff_lines lines;
    ff_error *err;
    const char *path;
    const ff_read_options *options;
    double in[2]; /* theta, phi of the light; NaN = not said */
    size_t n_channels;
    int has_format, raw;
    ff_quantity quantity;
    char unit[16];   /* of raw readings */
    uint64_t points; /* #datapoints_in_file, 0 = not said */
    int behind;      /* the light is at theta > 90 */
    size_t n_transmitted;
    ff_rows rows;
} pgii;

/* ---- recognising it -------------------------------------------------------------------------- */

/* The value of '#key value' or '#key: value'; NULL when the line has another key. */
static char *value_of(char *line, const char *key)
{
    const size_t n = strlen(key);
    line += 1 + strspn(line + 1, " \t");
    if (strncasecmp(line, key, n) != 0 || (line[n] && !strchr(": \t", line[n]))) return NULL;
    line += n + strspn(line + n, ": \t");
    for (char *end = line + strlen(line); end > line && strchr(" \t", end[-1]);) *--end = '\0';
    return line;
}

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    static const char *const keys[] = {"format", "incident_angle", "intheta", "inphi", "pgII"};
    static const int worth[] = {40, 30, 30, 20, 20};
    if (memchr(head, '\0', n)) return 0;
    int sum = 0;
    const char *p = (const char *)head, *stop = p + n;
    while (p < stop && *p == '#') {
        char line[96] = "";
        const char *end = memchr(p, '\n', (size_t)(stop - p));
        size_t length = (size_t)((end ? end : stop) - p);
        memcpy(line, p, length < sizeof line ? length : sizeof line - 1);
        for (size_t k = 0; k < sizeof keys / sizeof keys[0]; k++) {
            const char *value = value_of(line, keys[k]);
            if (value && (k > 0 || strncasecmp(value, "theta", 5) == 0)) sum += worth[k];
        }
        p = end ? end + 1 : stop;
    }
    return sum >= 60 ? 90 : sum >= 40 ? 60 : 0;
}

/* ---- header ---------------------------------------------------------------------------------- */

static ff_status bad_header(const pgii *g, const char *key, const char *found, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(g->err, FF_ERR_FORMAT, g->path, g->lines.line, -1, "#%s: found %s, expected %s", key,
                        ff_quote(found, strlen(found), quoted), expected);
}

/* n angles of the line into the light's from `at` on. */
static ff_status read_light(pgii *g, const char *key, const char *value, size_t at, size_t n)
{
    double v[2];
    size_t got;
    if (ff_line_numbers(value, v, 2, &got, g->path, g->lines.line, key, NULL) != FF_OK || got != n ||
        (at == 0 && !(v[0] >= 0 && v[0] <= 180)))
        return bad_header(g, key, value,
                          n == 2 ? "theta (0 to 180 degrees) and phi"
                          : at   ? "phi in degrees"
                                 : "theta (0 to 180 degrees)");
    memcpy(g->in + at, v, n * sizeof *v);
    return FF_OK;
}

static ff_status read_kind(pgii *g, const char *kind)
{
    const size_t n = strlen(kind);
    g->raw = n > 2 && kind[0] == '[' && kind[n - 1] == ']';
    if (g->raw) {
        strncat(memset(g->unit, 0, sizeof g->unit), kind + 1, n - 2 < sizeof g->unit ? n - 2 : sizeof g->unit - 1);
        g->quantity = FF_BRDF_COS;
        return FF_OK;
    }
    g->quantity = strcasecmp(kind, "DSF") == 0 ? FF_BRDF_COS : FF_BRDF;
    if (g->quantity == FF_BRDF_COS || strcasecmp(kind, "BSDF") == 0 || strcasecmp(kind, "BRDF") == 0) return FF_OK;
    if (strcasecmp(kind, "BTDF") != 0)
        return bad_header(g, "format", kind, "theta phi and one of BSDF, BRDF, DSF or a unit as in [uA]");
    return ff_error_set(g->err, FF_ERR_UNSUPPORTED, g->path, g->lines.line, -1,
                        "#format: found BTDF, which is transmission, expected reflection");
}

static ff_status read_format(pgii *g, char *value)
{
    char *rest, *word[4] = {0};
    int n = 0;
    for (char *w = strtok_r(value, " \t", &rest); w && n < 4; w = strtok_r(NULL, " \t", &rest)) word[n++] = w;
    if (n != 3 || strcasecmp(word[0], "theta") != 0 || strcasecmp(word[1], "phi") != 0)
        return bad_header(g, "format", n ? word[0] : "", "theta phi and what the values are");
    g->has_format = 1;
    const ff_status status = read_kind(g, word[2]);
    if (status != FF_OK || !g->raw || !isnan(g->options->scale)) return status;
    return ff_error_hint(g->err,
                         ff_error_set(g->err, FF_ERR_UNSUPPORTED, g->path, g->lines.line, -1,
                                      "#format: found readings of the detector in '%s', not calibrated, expected a BRDF", g->unit),
                         FF_HINT_SCALE);
}

static ff_status read_comment(pgii *g, char *text)
{
    char *value;
    if ((value = value_of(text, "incident_angle"))) return read_light(g, "incident_angle", value, 0, 2);
    if ((value = value_of(text, "intheta"))) return read_light(g, "intheta", value, 0, 1);
    if ((value = value_of(text, "inphi"))) return read_light(g, "inphi", value, 1, 1);
    if ((value = value_of(text, "format"))) return read_format(g, value);
    if ((value = value_of(text, "datapoints_in_file")) && !ff_whole_number(value, UINT64_C(1) << 53, &g->points))
        return bad_header(g, "datapoints_in_file", value, "a whole number");
    if ((value = value_of(text, "colorimetry"))) {
        const int xyz = strcasecmp(value, "CIE-XYZ") == 0;
        if (!xyz && strcasecmp(value, "CIE-Y") != 0) return bad_header(g, "colorimetry", value, "CIE-XYZ or CIE-Y");
        g->n_channels = xyz ? 3 : 1;
    }
    return FF_OK;
}

static ff_status check_header(pgii *g)
{
    const char *missing = isnan(g->in[0]) || isnan(g->in[1]) ? "#incident_angle" : !g->has_format ? "#format:" : NULL;
    if (missing)
        return ff_error_set(g->err, FF_ERR_FORMAT, g->path, g->lines.line, -1,
                            "found numbers before a line %s, expected it in the header", missing);
    g->behind = g->in[0] > 90;
    if (g->behind) {
        g->in[0] = 180 - g->in[0];
        g->in[1] = -g->in[1];
    }
    g->rows.width = ff_rows_width(g->n_channels, 0, 0);
    return FF_OK;
}

/* ---- rows ------------------------------------------------------------------------------------ */

static ff_status read_row(pgii *g, const char *text)
{
    double v[5];
    size_t n;
    const size_t expected = 2 + g->n_channels;
    ff_status status = ff_line_numbers(text, v, expected, &n, g->path, g->lines.line, "a row: theta, phi and the values", g->err);
    if (status != FF_OK || n == 0) return status;
    if (n != expected)
        return ff_error_set(g->err, FF_ERR_FORMAT, g->path, g->lines.line, -1, "found %zu numbers, expected %zu: theta, phi and %s",
                            n, expected, g->n_channels == 1 ? "a value" : "X, Y, Z");
    if (!(v[0] >= 0 && v[0] <= 180))
        return ff_error_set(g->err, FF_ERR_DATA, g->path, g->lines.line, -1, "found theta %g, expected 0 to 180 degrees", v[0]);
    if (!g->rows.width && (status = check_header(g)) != FF_OK) return status;
    double *row = ff_rows_add(&g->rows);
    if (!row) return ff_error_set(g->err, FF_ERR_MEMORY, g->path, g->lines.line, -1, "no memory for row %zu", g->rows.n + 1);
    memcpy(row, g->in, sizeof g->in);
    row[2] = g->behind ? 180 - v[0] : v[0];
    row[3] = g->behind ? -v[1] : v[1];
    memcpy(row + 4, v + 2, g->n_channels * sizeof *v);
    if (row[2] > 90) {
        row[4] = NAN;
        g->n_transmitted++;
    }
    return FF_OK;
}

static ff_status read_lines(pgii *g)
{
    for (;;) {
        char *text;
        size_t length;
        ff_status status = ff_lines_next(&g->lines, &text, &length, g->err);
        if (status != FF_OK || !text) return status;
        if (*text == '#')
            status = g->rows.n ? FF_OK : read_comment(g, text); /* what stands between rows comes too late to mean anything */
        else
            status = read_row(g, text);
        if (status != FF_OK) return status;
    }
}

static ff_status check_rows(const pgii *g)
{
    if (g->rows.n == 0)
        return ff_error_set(g->err, FF_ERR_READ, g->path, g->lines.line, -1, "found no rows of numbers, expected at least one");
    if (g->n_transmitted == g->rows.n)
        return ff_error_set(g->err, FF_ERR_UNSUPPORTED, g->path, 0, -1,
                            "found transmission only (every direction is on the other side than the light), expected reflection");
    return FF_OK;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void describe(const pgii *g, ff_table *t)
{
    static const char *const xyz[3] = {"X", "Y", "Z"};
    strcpy(t->format, "pgii");
    for (size_t c = 0; c < g->n_channels; c++) strcpy(t->channels[c].name, g->n_channels == 3 ? xyz[c] : "f");
    t->radians_per_unit = degree;
    t->isotropic = 1; /* one incidence */
    ff_table_set_quantity(t, ff_read_quantity(g->options, g->quantity));
    const int said = g->options->quantity >= 0;
    if (g->raw)
        ff_table_note_hint(t, said ? FF_HINT_NONE : FF_HINT_QUANTITY_BRDF,
                           "the values are readings of the detector in %s: taken as proportional to %s", g->unit,
                           said ? "what the option 'quantity' says" : "f cos(theta_o), the power on the detector");
    if (g->behind) ff_table_note(t, "the light is behind the sample: the frame is turned over about x");
    if (g->n_transmitted)
        ff_table_note(t, "%zu samples on the other side than the light are transmission and left out", g->n_transmitted);
    if (g->points && g->points != t->n)
        ff_table_note(t, "#datapoints_in_file says %llu, the file has %zu rows", (unsigned long long)g->points, t->n);
    if (!g->points) ff_table_note(t, "#datapoints_in_file is missing: it cannot be known whether all rows are there");
    if (g->lines.unterminated) ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
}

static ff_status read_all(pgii *g, ff_table *out)
{
    ff_status status = read_lines(g);
    if (status == FF_OK) status = check_rows(g);
    if (status != FF_OK) return status;
    ff_table t;
    status = ff_rows_to_table(&g->rows, g->n_channels, 0, 0, &t, g->err);
    if (status != FF_OK) return status;
    describe(g, &t);
    return ff_table_hand_out(&t, g->path, out, g->err);
}

static ff_status read_pgii(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    pgii g = {.err = err, .path = path, .options = o, .in = {NAN, NAN}, .n_channels = 1};
    ff_status status = ff_lines_open(path, &g.lines, err);
    if (status != FF_OK) return status;
    status = read_all(&g, out);
    ff_lines_close(&g.lines);
    ff_rows_free(&g.rows);
    return status;
}

const ff_format ff_format_pgii = {
    .name = "pgii",
    .title = "pab pgII gonio-photometer: one incidence, a scan of outgoing directions",
    .extensions = ".txt .dat",
    .source = "pab-opto.de, data visualisation; Radiance, pabopto2bsdf(1)",
    .probe = probe,
    .reads = FF_READS_QUANTITY,
    .read = read_pgii,
};
