/* FRED's tabulated BSDF (Photon Engineering): two lines of header, then rows of two or three numbers.
 *
 *     type bsdf_data
 *     format angles=deg|sin bsdf=value|log scale=1
 *     theta_spec phi_spec                       two numbers: the specular direction of the rows that follow
 *     theta phi bsdf                            three numbers: a direction of scattering and the value there
 *     ...                                       any number of both
 *
 * angles=deg is polar angle and azimuth in degrees, theta < 0 being the opposite azimuth (data in the plane of incidence);
 * angles=sin is sin(phi) sin(theta) and cos(phi) sin(theta), in this order, as the manual has them. bsdf=log is the decimal
 * logarithm. scale multiplies the BSDF; 1 when left out.
 *
 * The two numbers are the specular direction and not the light's: FRED's manual says so (AddTabulatedScatterData: "elevation angle
 * for the specular direction"), and so do the files of ua-loft/bsdf-tools at theta_spec = 10, 30, 50, 70 and phi_spec = 0: the
 * largest values of each stand at phi = 0, none at 180, and the value at (theta_spec, 0) is, to 4 %, the one that the Zemax file of
 * the same measurement has at the specular direction. So the light is at (theta_spec, phi_spec + 180 degrees). Rows with |theta| >
 * 90 degrees are transmission and not read: they are there as samples that were not measured. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "data_formats/table/internal_table.h"
#include "base/internal_tokens.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;

typedef struct fred {
    ff_tokens tokens;
    ff_error *err;
    const char *path;
    int cosines, logarithm;
    double scale;
    int has_light, light_has_rows;
    long light_line;
    double light[2]; /* theta_i, phi_i */
    size_t n_transmitted;
    ff_rows rows;
} fred;

static long line_of(const fred *f)
{
    return f->tokens.lines.line;
}

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    if (memchr(head, '\0', n)) return 0;
    const char *p = (const char *)head, *stop = p + n;
    while (p < stop && strchr(" \t\r\n", *p)) p++;
    if (stop - p < 14 || strncasecmp(p, "type", 4) != 0) return 0;
    for (p += 4; p < stop && (*p == ' ' || *p == '\t'); p++) continue;
    return stop - p >= 9 && strncasecmp(p, "bsdf_data", 9) == 0 ? 97 : 0;
}

/* ---- header ---------------------------------------------------------------------------------- */

static ff_status read_type(fred *f)
{
    char *text, found[FF_QUOTE];
    const ff_status status = ff_tokens_line(&f->tokens, &text);
    if (status != FF_OK) return status;
    if (!text)
        return ff_error_set(f->err, FF_ERR_READ, f->path, line_of(f), -1, "found the end of the file, expected 'type bsdf_data'");
    size_t n = strcspn(text, " \t");
    const char *value = text + n + strspn(text + n, " \t");
    if (n == 4 && strncasecmp(text, "type", 4) == 0 && strncasecmp(value, "bsdf_data", 9) == 0 &&
        !value[9 + strspn(value + 9, " \t")])
        return FF_OK;
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, line_of(f), -1, "found %s, expected 'type bsdf_data'",
                        ff_quote(text, strlen(text), found));
}

/* Which of two words a value is: 0 or 1, -1 = neither. */
static int which(const char *value, const char *zero, const char *one)
{
    return strcasecmp(value, zero) == 0 ? 0 : strcasecmp(value, one) == 0 ? 1 : -1;
}

static ff_status bad_setting(const fred *f, const char *found, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, line_of(f), -1, "'format': found %s, expected %s",
                        ff_quote(found, strlen(found), quoted), expected);
}

static ff_status read_setting(fred *f, char *key, char *value)
{
    if (strcasecmp(key, "angles") == 0)
        return (f->cosines = which(value, "deg", "sin")) < 0 ? bad_setting(f, value, "angles=deg or angles=sin") : FF_OK;
    if (strcasecmp(key, "bsdf") == 0)
        return (f->logarithm = which(value, "value", "log")) < 0 ? bad_setting(f, value, "bsdf=value or bsdf=log") : FF_OK;
    if (strcasecmp(key, "scale") == 0) {
        const char *end = ff_number_read(value, &f->scale);
        if (!end || *end || !(f->scale > 0 && isfinite(f->scale))) return bad_setting(f, value, "scale= a finite number > 0");
        return FF_OK;
    }
    if (strcasecmp(key, "exclude") == 0 || strcasecmp(key, "num") == 0) { /* how FRED draws rays, nothing about the surface */
        double ignored;
        const char *end = ff_number_read(value, &ignored);
        return end && !*end ? FF_OK : bad_setting(f, value, "exclude= and num= a number");
    }
    return bad_setting(f, key, "angles=, bsdf=, scale=, exclude= and num=");
}

static ff_status read_format(fred *f)
{
    char *text, found[FF_QUOTE];
    ff_status status = ff_tokens_line(&f->tokens, &text);
    if (status != FF_OK) return status;
    static const char expected[] = "'format angles=deg bsdf=value scale=1' or the like";
    if (!text)
        return ff_error_set(f->err, FF_ERR_READ, f->path, line_of(f), -1, "found the end of the file, expected %s", expected);
    char *rest, *word = strtok_r(text, " \t,", &rest);
    if (!word || strcasecmp(word, "format") != 0)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, line_of(f), -1, "found %s, expected %s",
                            ff_quote(text, strlen(text), found), expected);
    while (status == FF_OK && (word = strtok_r(NULL, " \t,", &rest))) {
        char *equals = strchr(word, '=');
        if (!equals) return bad_setting(f, word, "angles=, bsdf= and scale=, without spaces");
        *equals = '\0';
        status = read_setting(f, word, equals + 1);
    }
    if (status == FF_OK && (f->cosines < 0 || f->logarithm < 0))
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, line_of(f), -1, "found no %s, expected %s",
                            f->cosines < 0 ? "'angles='" : "'bsdf='", expected);
    return status;
}

/* ---- rows ------------------------------------------------------------------------------------ */

/* Two numbers of the file as polar angle and azimuth in the table's unit. */
static ff_status take_direction(const fred *f, const double v[2], double limit, const char *what, double angle[2])
{
    if (f->cosines) {
        const double sine = hypot(v[0], v[1]);
        if (!(sine <= 1 + 1e-9))
            return ff_error_set(f->err, FF_ERR_DATA, f->path, line_of(f), -1,
                                "found the %s %g %g, expected direction cosines (angles=sin), at most 1 together", what, v[0],
                                v[1]);
        angle[0] = asin(fmin(sine, 1));
        angle[1] = atan2(v[0], v[1]); /* sin(phi) sin(theta) first */
        return FF_OK;
    }
    if (!(fabs(v[0]) <= limit))
        return ff_error_set(f->err, FF_ERR_DATA, f->path, line_of(f), -1,
                            "found the polar angle %g of the %s, expected -%g to %g degrees", v[0], what, limit, limit);
    angle[0] = v[0];
    angle[1] = v[1];
    return FF_OK;
}

static ff_status take_light(fred *f, const double v[2])
{
    const ff_status status = take_direction(f, v, 90, "specular direction", f->light);
    f->light[1] += f->cosines ? 180 * degree : 180;
    f->has_light = 1;
    f->light_has_rows = 0;
    f->light_line = line_of(f);
    return status;
}

static ff_status take_sample(fred *f, const double v[3])
{
    if (!f->has_light)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, line_of(f), -1,
                            "found a row of three numbers, expected the two of a specular direction before it");
    double *row = ff_rows_add(&f->rows);
    if (!row) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, line_of(f), -1, "no memory for row %zu", f->rows.n + 1);
    memcpy(row, f->light, sizeof f->light);
    const ff_status status = take_direction(f, v, 180, "scattering", row + 2);
    if (status != FF_OK) return status;
    f->light_has_rows = 1;
    row[4] = f->logarithm ? pow(10, v[2]) : v[2];
    if (!isfinite(row[4] * f->scale))
        return ff_error_set(f->err, FF_ERR_DATA, f->path, line_of(f), -1, "found the %s %g, expected a BSDF of less than 1e308",
                            f->logarithm ? "logarithm" : "value", v[2]);
    if (!f->cosines && fabs(v[0]) > 90) {
        row[4] = NAN;
        f->n_transmitted++;
    }
    return FF_OK;
}

static ff_status read_rows(fred *f)
{
    for (;;) {
        char *text;
        double v[3];
        size_t n;
        ff_status status = ff_tokens_line(&f->tokens, &text);
        if (status != FF_OK || !text) return status;
        status =
            ff_line_numbers(text, v, 3, &n, f->path, line_of(f), "a specular direction (2 numbers) or a scattering (3)", f->err);
        if (status == FF_OK && n < 2)
            status = ff_error_set(f->err, FF_ERR_FORMAT, f->path, line_of(f), -1,
                                  "found one number, expected the 2 of a specular direction or the 3 of a scattering");
        if (status == FF_OK) status = n == 2 ? take_light(f, v) : take_sample(f, v);
        if (status != FF_OK) return status;
    }
}

static ff_status check_rows(const fred *f)
{
    if (!f->has_light)
        return ff_error_set(f->err, FF_ERR_READ, f->path, line_of(f), -1,
                            "found the end of the file, expected a specular direction and rows of three numbers");
    if (!f->light_has_rows)
        return ff_error_set(f->err, FF_ERR_READ, f->path, line_of(f), -1,
                            "found the end of the file, expected rows of three numbers after the specular direction of line %ld",
                            f->light_line);
    if (f->n_transmitted == f->rows.n)
        return ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, 0, -1,
                            "found transmission only (every polar angle is beyond 90 degrees), expected reflection");
    return FF_OK;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void describe(const fred *f, ff_table *t)
{
    strcpy(t->format, "fred");
    strcpy(t->channels[0].name, "f");
    t->channels[0].scale = f->scale;
    t->radians_per_unit = f->cosines ? 1 : degree;
    t->isotropic = ff_table_one_incidence_azimuth(t);
    if (f->cosines) ff_table_note(t, "angles=sin: the numbers are taken to be sin(phi) sin(theta) and cos(phi) sin(theta)");
    if (f->logarithm) ff_table_note(t, "bsdf=log: the values are taken to be decimal logarithms");
    if (f->n_transmitted) ff_table_note(t, "%zu samples beyond 90 degrees are transmission and left out", f->n_transmitted);
    if (f->tokens.lines.unterminated)
        ff_table_note(t, "the last line has no end-of-line: if the file was cut, so was its last number");
}

static ff_status read_all(fred *f, ff_table *out)
{
    ff_status status = read_type(f);
    if (status == FF_OK) status = read_format(f);
    if (status == FF_OK) status = read_rows(f);
    if (status == FF_OK) status = check_rows(f);
    if (status != FF_OK) return status;
    ff_table t;
    status = ff_rows_to_table(&f->rows, 1, 0, 0, &t, f->err);
    if (status != FF_OK) return status;
    describe(f, &t);
    return ff_table_hand_out(&t, f->path, out, f->err);
}

static ff_status read_fred(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    fred f = {.err = err, .path = path, .cosines = -1, .logarithm = -1, .scale = 1};
    f.rows.width = ff_rows_width(1, 0, 0);
    ff_status status = ff_tokens_open(path, &f.tokens, err);
    if (status != FF_OK) return status;
    status = read_all(&f, out);
    ff_tokens_close(&f.tokens);
    ff_rows_free(&f.rows);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

typedef struct ray {
    double in[2];
    size_t sample;
} ray;

static int by_light(const void *a, const void *b)
{
    const ray *x = a, *y = b;
    for (int k = 0; k < 2; k++)
        if (x->in[k] != y->in[k]) return x->in[k] < y->in[k] ? -1 : 1;
    return x->sample < y->sample ? -1 : x->sample > y->sample;
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    const ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK || (t->n_channels == 1 && !t->sigma)) return status;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "a file of this format has one channel and no standard deviations; take one, or the mean, or write csv");
}

static void put(FILE *file, double v, char after)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
    putc(after, file);
}

/* The specular direction is on the other side than the light. What was not measured has no row. */
static void write_rays(const ff_table *t, const ray *rays, size_t n, FILE *file)
{
    for (size_t k = 0; k < n; k++) {
        double a[4], *const planes[4] = {a, a + 1, a + 2, a + 3};
        const size_t i = rays[k].sample;
        ff_table_angles(t, degree, i, 1, planes);
        if (k == 0 || rays[k].in[0] != rays[k - 1].in[0] || rays[k].in[1] != rays[k - 1].in[1]) {
            put(file, a[0], ' ');
            put(file, a[1] >= 180 ? a[1] - 180 : a[1] + 180, '\n');
        }
        put(file, a[2], ' ');
        put(file, a[3], ' ');
        put(file, t->channels[0].scale * t->value[i], '\n');
    }
}

static ff_status write_fred(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err)
{
    ff_output out;
    ff_status status = check_writable(path, t, err);
    if (status != FF_OK) return status;
    ray *rays = malloc(t->n * sizeof *rays);
    size_t n = 0;
    if (!rays) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory to sort %zu samples", t->n);
    for (size_t i = 0; i < t->n; i++) {
        double a[4], *const planes[4] = {a, a + 1, a + 2, a + 3};
        ff_table_angles(t, degree, i, 1, planes);
        if (t->valid[i] && fabs(a[0]) <= 90 && fabs(a[2]) <= 90) rays[n++] = (ray){{a[0], a[1]}, i};
    }
    qsort(rays, n, sizeof *rays, by_light);
    status = n ? ff_output_open_with(path, with, &out, err)
               : ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "found no sample above the horizon, expected one at least");
    if (status == FF_OK) {
        fputs("type bsdf_data\nformat angles=deg bsdf=value scale=1\n", out.file);
        write_rays(t, rays, n, out.file);
        status = ff_output_commit(&out, err);
    }
    free(rays);
    return status;
}

const ff_format ff_format_fred = {
    .name = "fred",
    .title = "FRED tabulated BSDF: any directions about several specular directions",
    .extensions = ".fred .txt",
    .source = "FRED manual (help.photonengr.com), Tabulated BSDF",
    .probe = probe,
    .holds = FF_HOLDS_INVALID | FF_HOLDS_NEGATIVE | FF_HOLDS_DOUBLE,
    .read = read_fred,
    .write = write_fred,
};
