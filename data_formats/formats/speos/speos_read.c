/* Blocks of Speos files: read, brought to the BSDF, and put into rows. */
#define _GNU_SOURCE
#include "internal_speos.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;
enum { MOST_ANGLES = 1 << 14, MOST_VALUES = 1 << 26 };

/* ---- header --------------------------------------------------------------------------------------- */

int ff_speos_probe(const unsigned char *head, size_t n, const char *title)
{
    static const char maker[] = "OPTIS";
    const char *end = memchr(head, '\n', n);
    const size_t length = end ? (size_t)(end - (const char *)head) : n;
    return length > sizeof maker && strncasecmp((const char *)head, maker, sizeof maker - 1) == 0 && length < 200 &&
           memmem(head, length, title, strlen(title)) != NULL;
}

static ff_status next_line(ff_speos *s, const char *expected, char **text)
{
    size_t length;
    const ff_status status = ff_lines_next(&s->t.lines, text, &length, s->err);
    if (status != FF_OK || *text) return status;
    return ff_error_set(s->err, FF_ERR_READ, s->path, s->t.lines.line, -1, "found the end of the file, expected %s", expected);
}

/* So many characters of description, over as many lines as they take: one at least. */
static ff_status skip_description(ff_speos *s, uint64_t characters)
{
    uint64_t seen = 0;
    do {
        char *text;
        const ff_status status = next_line(s, "the description of the measurement", &text);
        if (status != FF_OK) return status;
        seen += strlen(text) + 1;
    } while (seen < characters);
    return FF_OK;
}

ff_status ff_speos_begin(ff_speos *s, const char *title)
{
    char *text, found[FF_QUOTE];
    uint64_t number;
    ff_status status = next_line(s, "the title of the format", &text);
    if (status != FF_OK) return status;
    if (!strstr(text, title))
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, s->t.lines.line, -1, "found %s, expected 'OPTIS - %s v8.0'",
                            ff_quote(text, strlen(text), found), title);
    status = next_line(s, "0, the mode of a file that is text", &text);
    if (status != FF_OK) return status;
    if (strcmp(text + strspn(text, " \t"), "0") != 0 && text[strspn(text, " \t")] != '0')
        return ff_error_set(
            s->err, FF_ERR_UNSUPPORTED, s->path, s->t.lines.line, -1,
            "found the mode %s, expected 0, text: save it from the BSDF viewer as a file that is not binary or encrypted",
            ff_quote(text, strlen(text), found));
    status = next_line(s, "a comment", &text);
    if (status == FF_OK) status = next_line(s, "the number of characters of the description", &text);
    if (status != FF_OK) return status;
    char *word = text + strspn(text, " \t");
    word[strcspn(word, " \t")] = '\0';
    if (!ff_whole_number(word, 1 << 20, &number))
        return ff_error_set(s->err, FF_ERR_FORMAT, s->path, s->t.lines.line, -1,
                            "found %s, expected the number of characters of the description", ff_quote(text, strlen(text), found));
    return skip_description(s, number);
}

ff_status ff_speos_kinds(ff_speos *s)
{
    double v[3];
    const ff_status status = ff_tokens_numbers(&s->t, v, 3, "whether it reflects, whether it transmits, and what its values are");
    if (status != FF_OK) return status;
    for (int k = 0; k < 3; k++)
        if (v[k] != 0 && v[k] != 1)
            return ff_error_set(
                s->err, FF_ERR_DATA, s->path, s->t.lines.line, -1,
                "found %g, expected 0 or 1: whether it reflects, whether it transmits, and 1 for BSDF or 0 for intensity", v[k]);
    s->reflects = v[0] == 1;
    s->transmits = v[1] == 1;
    s->is_bsdf = v[2] == 1;
    if (s->reflects) return FF_OK;
    return ff_error_set(s->err, FF_ERR_UNSUPPORTED, s->path, s->t.lines.line, -1, "found transmission only, expected reflection");
}

/* ---- numbers --------------------------------------------------------------------------------------- */

ff_status ff_speos_count(ff_speos *s, const char *what, size_t most, size_t *out)
{
    double v;
    const ff_status status = ff_tokens_numbers(&s->t, &v, 1, what);
    if (status != FF_OK) return status;
    if (!(v >= 1 && v <= (double)most && v == floor(v)))
        return ff_error_set(s->err, FF_ERR_DATA, s->path, s->t.lines.line, -1,
                            "%s: found %g, expected a whole number from 1 to %zu", what, v, most);
    *out = (size_t)v;
    return FF_OK;
}

static ff_status check_ascending(const ff_speos *s, const char *what, size_t n, const double *v, double lo, double hi)
{
    for (size_t k = 0; k < n; k++)
        if (!(v[k] >= lo && v[k] <= hi) || (k && v[k] <= v[k - 1]))
            return ff_error_set(s->err, FF_ERR_DATA, s->path, s->t.lines.line, -1,
                                "%s: found %g, expected ascending numbers from %g to %g", what, v[k], lo, hi);
    return FF_OK;
}

ff_status ff_speos_list(ff_speos *s, const char *what, size_t n, double lo, double hi, double **out)
{
    double *v = malloc(n * sizeof *v);
    if (!v) return ff_error_set(s->err, FF_ERR_MEMORY, s->path, s->t.lines.line, -1, "no memory for %zu numbers", n);
    ff_status status = ff_tokens_numbers(&s->t, v, n, what);
    if (status == FF_OK) status = check_ascending(s, what, n, v, lo, hi);
    if (status == FF_OK)
        *out = v;
    else
        free(v);
    return status;
}

void ff_speos_block_clear(ff_speos_block *b)
{
    free(b->theta);
    *b = (ff_speos_block){0};
}

static ff_status read_values(ff_speos *s, ff_speos_block *b, size_t in_file)
{
    ff_status status = ff_tokens_numbers(&s->t, b->phi, in_file, "the azimuths of a block");
    if (status == FF_OK) status = check_ascending(s, "azimuths", in_file, b->phi, -360, 360);
    for (size_t i = 0; i < b->n_theta && status == FF_OK; i++) {
        status = ff_tokens_numbers(&s->t, &b->theta[i], 1, "a polar angle and its row of values");
        if (status == FF_OK) status = ff_tokens_numbers(&s->t, b->value + i * in_file, in_file, "a row of values");
    }
    return status == FF_OK ? check_ascending(s, "polar angles", b->n_theta, b->theta, 0, 180) : status;
}

ff_status ff_speos_block_read(ff_speos *s, ff_speos_block *out)
{
    ff_speos_block b = {0};
    ff_status status = ff_speos_count(s, "polar angles of a block", MOST_ANGLES, &b.n_theta);
    if (status == FF_OK) status = ff_speos_count(s, "azimuths of a block", MOST_ANGLES, &b.n_phi);
    if (status != FF_OK) return status;
    const size_t in_file = b.n_phi;
    if (b.n_theta * in_file > MOST_VALUES)
        return ff_error_set(s->err, FF_ERR_DATA, s->path, s->t.lines.line, -1,
                            "found a block of %zu x %zu values, expected at most %d", b.n_theta, in_file, MOST_VALUES);
    b.theta = malloc((b.n_theta + in_file + b.n_theta * in_file) * sizeof *b.theta);
    if (!b.theta)
        return ff_error_set(s->err, FF_ERR_MEMORY, s->path, s->t.lines.line, -1, "no memory for %zu values", b.n_theta * in_file);
    b.phi = b.theta + b.n_theta;
    b.value = b.phi + in_file;
    status = read_values(s, &b, in_file);
    if (status != FF_OK) {
        free(b.theta);
        return status;
    }
    if (in_file > 1 && fabs(b.phi[in_file - 1] - b.phi[0] - 360) < 1e-6) { /* the first azimuth again */
        b.n_phi--;
        for (size_t i = 1; i < b.n_theta; i++) memmove(b.value + i * b.n_phi, b.value + i * in_file, b.n_phi * sizeof *b.value);
    }
    *out = b;
    return FF_OK;
}

/* ---- what the values are ------------------------------------------------------------------------------- */

void ff_speos_block_to_bsdf(const ff_speos *s, ff_speos_block *b)
{
    for (size_t i = 0; i < b->n_theta && !s->is_bsdf; i++) {
        const double c = cos(degree * b->theta[i]);
        for (size_t k = 0; k < b->n_phi; k++) b->value[i * b->n_phi + k] = c > FF_COS_MIN ? b->value[i * b->n_phi + k] / c : 0;
    }
}

/* Mean over the azimuths of one polar angle, by trapezoids; one azimuth alone is all of them, and half a turn stands for both. */
static double mean_of_row(const ff_speos_block *b, size_t i)
{
    const double *v = b->value + i * b->n_phi, *phi = b->phi, range = phi[b->n_phi - 1] - phi[0];
    double sum = 0;
    if (b->n_phi == 1) return v[0];
    for (size_t k = 0; k + 1 < b->n_phi; k++) sum += (v[k] + v[k + 1]) / 2 * (phi[k + 1] - phi[k]);
    if (range <= 180 + 1e-6) return sum / range;
    return (sum + (v[b->n_phi - 1] + v[0]) / 2 * (360 - range)) / 360;
}

double ff_speos_block_integral(const ff_speos_block *b)
{
    double sum = 0, last = 0, at = 0;
    for (size_t i = 0; i < b->n_theta && b->theta[i] <= 90 + 1e-9; i++) {
        const double theta = degree * b->theta[i], y = mean_of_row(b, i) * fmax(0, cos(theta)) * sin(theta);
        if (i) sum += (y + last) / 2 * (theta - at);
        last = y;
        at = theta;
    }
    return 2 * 180 * degree * sum;
}

/* ---- rows ------------------------------------------------------------------------------------------------ */

static double azimuth_width(const ff_speos_block *b, size_t k)
{
    const size_t n = b->n_phi;
    if (n == 1) return 360 * degree;
    const double before = k ? b->phi[k] - b->phi[k - 1] : b->phi[0] + 360 - b->phi[n - 1];
    const double after = k + 1 < n ? b->phi[k + 1] - b->phi[k] : b->phi[0] + 360 - b->phi[n - 1];
    return degree * (before + after) / 2;
}

ff_status ff_speos_rows_add(ff_speos *s, double rotation, double incidence, double band, const ff_speos_block *b, size_t n,
                            double *const *value, const double *scale, ff_rows *rows)
{
    double *polar = malloc(b->n_theta * sizeof *polar);
    if (!polar) return ff_error_set(s->err, FF_ERR_MEMORY, s->path, s->t.lines.line, -1, "no memory for %zu angles", b->n_theta);
    ff_polar_bands(b->theta, b->n_theta, degree, polar);
    for (size_t i = 0; i < b->n_theta; i++)
        for (size_t k = 0; k < b->n_phi; k++) {
            double *row = ff_rows_add(rows);
            if (!row) {
                free(polar);
                return ff_error_set(s->err, FF_ERR_MEMORY, s->path, s->t.lines.line, -1, "no memory for %zu samples", rows->n + 1);
            }
            row[0] = incidence;
            row[1] = -90 - rotation;
            row[2] = b->theta[i];
            row[3] = 90 - rotation + b->phi[k];
            for (size_t c = 0; c < n; c++) row[4 + c] = b->theta[i] < 90 ? scale[c] * value[c][i * b->n_phi + k] : NAN;
            row[4 + n] = fmax(0, band * polar[i] * azimuth_width(b, k));
        }
    free(polar);
    return FF_OK;
}
