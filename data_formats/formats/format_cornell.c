/* Cornell's irregular samples of isotropic surfaces, as pbrt-v2 reads them: numbers in free form, `#` starts a comment.
 *
 *     31                                            number of wavelengths
 *     400 410 ... 700                               them, in nm
 *     theta_i phi_i theta_s phi_s f f ... f         one sample: radians, and the BRDF in 1/sr at each wavelength; any number of
 * these
 *
 * Lines mean nothing: a list may go on on the next one. Both directions point away from the surface and phi_s - phi_i = pi is the
 * mirror reflection (the largest values of the files stand there), which is this program's frame. The surface is isotropic by the
 * definition of the format. How many samples there are is not said. */
#define _GNU_SOURCE
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include "base/internal_tokens.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double theta_max = 3.14159265358979323846 + 1e-6; /* files round pi to the digits they have */
static const double nm_max = 1e6;

typedef struct cornell {
    ff_tokens tokens;
    ff_error *err;
    const char *path;
    size_t n;   /* wavelengths */
    double *nm; /* [n] */
    ff_rows rows;
} cornell;

/* ---- recognising it -------------------------------------------------------------------------- */

/* The next word of p .. stop that is complete, '\0'-terminated in out; 0 at the end. */
static int next_word(const char **p, const char *stop, char out[32])
{
    const char *q = *p;
    while (q < stop && (*q == '#' || strchr(" \t\r\n,", *q))) {
        if (*q == '#')
            while (q < stop && *q != '\n') q++;
        else
            q++;
    }
    size_t n = 0;
    while (q + n < stop && n < 31 && !strchr(" \t\r\n,", q[n])) n++;
    *p = q + n;
    if (q + n == stop || n == 0 || n == 31) return 0;
    memcpy(out, q, n);
    out[n] = '\0';
    return 1;
}

static int next_number(const char **p, const char *stop, double *value)
{
    char word[32];
    if (!next_word(p, stop, word)) return 0;
    const char *end = ff_number_read(word, value);
    return end && *end == '\0';
}

/* A count, as many wavelengths from ultraviolet to infrared, and then four angles. */
static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    if (memchr(head, '\0', n)) return 0;
    const char *p = (const char *)head, *stop = p + n;
    char word[32];
    uint64_t count;
    if (!next_word(&p, stop, word) || !ff_whole_number(word, FF_NAMES_MAX, &count) || count == 0) return 0;
    double value;
    for (uint64_t k = 0; k < count; k++) {
        if (!next_number(&p, stop, &value)) return p == stop && k > 0 ? 30 : 0;
        if (!(value >= 100 && value <= 30000)) return 0;
    }
    for (int k = 0; k < 4; k++) {
        if (!next_number(&p, stop, &value)) return p == stop ? 30 : 0;
        if (!(fabs(value) <= 2 * theta_max)) return 0;
    }
    return 80;
}

/* ---- reading --------------------------------------------------------------------------------- */

static ff_status read_wavelengths(cornell *c)
{
    char *word, found[FF_QUOTE];
    ff_status status = ff_tokens_word(&c->tokens, &word);
    if (status != FF_OK) return status;
    const long line = c->tokens.lines.line;
    uint64_t n = 0;
    if (!word)
        return ff_error_set(c->err, FF_ERR_READ, c->path, line, -1,
                            "found the end of the file, expected the number of wavelengths");
    if (!ff_whole_number(word, FF_NAMES_MAX, &n) || n == 0)
        return ff_error_set(c->err, FF_ERR_FORMAT, c->path, line, -1, "found %s, expected the number of wavelengths, from 1 to %d",
                            ff_quote(word, strlen(word), found), FF_NAMES_MAX);
    c->n = (size_t)n;
    c->nm = malloc(c->n * sizeof *c->nm);
    if (!c->nm) return ff_error_set(c->err, FF_ERR_MEMORY, c->path, line, -1, "no memory for %zu wavelengths", c->n);
    status = ff_tokens_numbers(&c->tokens, c->nm, c->n, "the wavelengths in nm");
    for (size_t k = 0; k < c->n && status == FF_OK; k++) {
        if (!(c->nm[k] > 0 && c->nm[k] <= nm_max))
            status = ff_error_set(c->err, FF_ERR_DATA, c->path, c->tokens.lines.line, -1,
                                  "found the wavelength %g, expected nm, more than 0 and at most %g", c->nm[k], nm_max);
        for (size_t j = 0; j < k && status == FF_OK; j++)
            if (c->nm[j] == c->nm[k])
                status = ff_error_set(c->err, FF_ERR_FORMAT, c->path, c->tokens.lines.line, -1,
                                      "found the wavelength %g twice, expected it once", c->nm[k]);
    }
    return status;
}

static ff_status read_samples(cornell *c)
{
    char what[64];
    snprintf(what, sizeof what, "a sample: four angles and %zu values", c->n);
    for (;;) {
        int end;
        ff_status status = ff_tokens_at_end(&c->tokens, &end);
        if (status != FF_OK || end) return status;
        double *row = ff_rows_add(&c->rows);
        if (!row)
            return ff_error_set(c->err, FF_ERR_MEMORY, c->path, c->tokens.lines.line, -1, "no memory for sample %zu",
                                c->rows.n + 1);
        status = ff_tokens_numbers(&c->tokens, row, c->rows.width, what);
        if (status != FF_OK) return status;
        for (int k = 0; k < 4; k += 2)
            if (!(fabs(row[k]) <= theta_max))
                return ff_error_set(c->err, FF_ERR_DATA, c->path, c->tokens.lines.line, -1,
                                    "found theta_%c = %g, expected radians of at most pi: are these degrees?", k ? 's' : 'i',
                                    row[k]);
    }
}

static void describe(const cornell *c, ff_table *t)
{
    strcpy(t->format, "cornell");
    t->isotropic = 1;
    for (size_t k = 0; k < c->n; k++) {
        char *name = t->channels[k].name;
        strcpy(name + ff_number_write(c->nm[k], name), "nm");
        t->channels[k].wavelength_nm = c->nm[k];
    }
    if (c->tokens.lines.unterminated)
        ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
}

static ff_status read_all(cornell *c, ff_table *out)
{
    ff_status status = read_wavelengths(c);
    if (status != FF_OK) return status;
    c->rows.width = ff_rows_width(c->n, 0, 0);
    status = read_samples(c);
    if (status == FF_OK && c->rows.n == 0)
        status = ff_error_set(c->err, FF_ERR_READ, c->path, c->tokens.lines.line, -1,
                              "found no samples after the wavelengths, expected at least one");
    if (status != FF_OK) return status;
    ff_table t;
    status = ff_rows_to_table(&c->rows, c->n, 0, 0, &t, c->err);
    if (status != FF_OK) return status;
    describe(c, &t);
    return ff_table_hand_out(&t, c->path, out, c->err);
}

static ff_status read_cornell(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    cornell c = {.err = err, .path = path};
    ff_status status = ff_tokens_open(path, &c.tokens, err);
    if (status != FF_OK) return status;
    status = read_all(&c, out);
    ff_tokens_close(&c.tokens);
    ff_rows_free(&c.rows);
    free(c.nm);
    return status;
}

const ff_format ff_format_cornell = {
    .name = "cornell",
    .title = "Cornell's measurements as pbrt-v2 has them: isotropic samples, any number of wavelengths",
    .extensions = ".brdf",
    .source = "pbrt-v2, src/materials/measured.cpp, irregularly sampled isotropic BRDF",
    .probe = probe,
    .read = read_cornell,
};
