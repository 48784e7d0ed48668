/* MBSDF: measured isotropic BSDFs of the NVIDIA Material Definition Language.
 *
 *     NVIDIA ARC MBSDF V1\n
 *     any number of lines of text     KEY="value", for people
 *     MBSDF_DATA_REFLECTION=\n        or MBSDF_DATA=\n, or MBSDF_DATA_TRANSMISSION=\n; reflection comes before transmission
 *     uint32 LE x 3                   0 = scalar, 1 = RGB; number of thetas; number of phis
 *     float32 LE                      value[theta_in][theta_out][phi][channel], one number of thetas for both
 *
 * theta is uniform in [0, pi/2) and phi, the difference of the azimuths, in [0, pi] (ibsdf_isotropic_data.h), with the mirror
 * direction at pi: wi = (theta_in, 0), wo = (theta_out, phi). Read as nodes, as the brackets say: theta_k = 90 k / n, phi_p =
 * 180 p / (n - 1) degrees. For theta the SDK's own files bear it out: their values at the first theta_out are the same for all phi,
 * as only the normal can be; the kinks of their interpolation over theta_in lie at k = 5, 10, 15 ..., measured at 10, 20, 30
 * degrees; and they are constant over theta_out from 80 degrees on. For phi they leave half a step open, 1 degree. The SDK's
 * renderers take values as averages of cells, half a step further in both.
 *
 * Values are f in 1/sr without the cosine: the SDK's albedo is their sum times the projected solid angle. A file need not be
 * reciprocal (the SDK averages the two orders of a pair) and has tens of thousands of negative values: both are kept as measured.
 * Rows that only repeat the last measured theta are not valid.
 */
#define _GNU_SOURCE
#include "base/internal_bytes.h"
#include "base/internal_input.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const char magic[] = "NVIDIA ARC MBSDF V1\n";
static const char family[] = "NVIDIA ARC MBSDF ";
static const char transmission_line[] = "MBSDF_DATA_TRANSMISSION=\n";
enum { MAGIC = sizeof magic - 1, FAMILY = sizeof family - 1, HEADER = 12, MOST_BYTES = 1 << 30, MOST_TEXT = 1 << 24 };

typedef struct mbsdf {
    const char *path;
    ff_error *err;
    const unsigned char *data; /* the whole file */
    size_t n, at;              /* its size, the next byte */
} mbsdf;

typedef struct block {
    size_t n_channels, n_theta, n_phi, n; /* n samples */
    size_t offset;                        /* of its values in the file */
} block;

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    if (n >= MAGIC && memcmp(head, magic, MAGIC) == 0) return 100;
    return n >= FAMILY && memcmp(head, family, FAMILY) == 0 ? 60 : 0; /* another version: the reader says so */
}

/* ---- text ------------------------------------------------------------------------------------ */

static ff_status ended(const mbsdf *m, const char *expected)
{
    return ff_error_set(m->err, FF_ERR_READ, m->path, 0, (int64_t)m->n, "found the end of the file after %zu bytes, expected %s",
                        m->n, expected);
}

static ff_status not_expected(const mbsdf *m, const char *expected)
{
    char found[FF_QUOTE];
    const size_t left = m->n - m->at;
    const unsigned char *end = memchr(m->data + m->at, '\n', left);
    const size_t length = end ? (size_t)(end - m->data) - m->at : left;
    return ff_error_set(m->err, FF_ERR_FORMAT, m->path, 0, (int64_t)m->at, "found %s, expected %s",
                        ff_quote((const char *)m->data + m->at, length < 64 ? length : 64, found), expected);
}

/* Steps over the line, which ends in '\n', when it stands there. FF_ERR_READ when the file ends within it. */
static ff_status skip_line(mbsdf *m, const char *line, const char *expected)
{
    const size_t length = strlen(line), left = m->n - m->at, same = left < length ? left : length;
    if (memcmp(m->data + m->at, line, same) != 0) return not_expected(m, expected);
    if (left < length) return ended(m, expected);
    m->at += length;
    return FF_OK;
}

static int is_line(const char *text, size_t length, const char *line)
{
    return length + 1 == strlen(line) && memcmp(text, line, length) == 0;
}

/* Goes behind the line that opens the first block. */
static ff_status find_data(mbsdf *m, int *transmission)
{
    static const char expected[] = "a line MBSDF_DATA_REFLECTION=";
    ff_status status = skip_line(m, magic, "the line NVIDIA ARC MBSDF V1");
    while (status == FF_OK) {
        const char *text = (const char *)m->data + m->at;
        size_t length = 0;
        while (m->at + length < m->n && text[length] != '\n') {
            if ((unsigned char)text[length] < 0x20 && text[length] != '\t') {
                m->at += length;
                return not_expected(m, "text, or a line MBSDF_DATA_REFLECTION= before the values");
            }
            length++;
        }
        if (m->at + length == m->n) return ended(m, expected);
        m->at += length + 1;
        *transmission = is_line(text, length, transmission_line);
        if (*transmission || is_line(text, length, "MBSDF_DATA_REFLECTION=\n") || is_line(text, length, "MBSDF_DATA=\n"))
            return FF_OK;
    }
    return status;
}

/* ---- blocks ---------------------------------------------------------------------------------- */

static ff_status wrong_number(const mbsdf *m, size_t k, const char *what, uint32_t found, const char *expected)
{
    return ff_error_set(m->err, FF_ERR_FORMAT, m->path, 0, (int64_t)(m->at + 4 * k), "%s: found %lu, expected %s", what,
                        (unsigned long)found, expected);
}

/* Reads the header of a block and steps over its values, all of which the file is known to have. */
static ff_status read_block(mbsdf *m, block *b)
{
    if (m->n - m->at < HEADER) return ended(m, "12 bytes: kind of values, number of thetas and of phis");
    const uint32_t type = ff_uint32_of(m->data + m->at), n_theta = ff_uint32_of(m->data + m->at + 4),
                   n_phi = ff_uint32_of(m->data + m->at + 8);
    if (type > 1) return wrong_number(m, 0, "kind of values", type, "0 (scalar) or 1 (RGB)");
    if (n_theta == 0) return wrong_number(m, 1, "number of thetas", n_theta, "at least 1");
    if (n_phi == 0) return wrong_number(m, 2, "number of phis", n_phi, "at least 1");
    m->at += HEADER;
    const uint64_t n_channels = type ? 3 : 1, pairs = (uint64_t)n_theta * n_theta, rooms = (m->n - m->at) / (4 * n_channels);
    if (rooms / pairs < n_phi) {
        char expected[96];
        snprintf(expected, sizeof expected, "%lu x %lu x %lu x %d floats from byte %zu on", (unsigned long)n_theta,
                 (unsigned long)n_theta, (unsigned long)n_phi, (int)n_channels, m->at);
        return ended(m, expected);
    }
    *b = (block){(size_t)n_channels, n_theta, n_phi, (size_t)(pairs * n_phi), m->at};
    m->at += 4 * b->n_channels * b->n;
    return FF_OK;
}

/* Reads all blocks; *b is that of the reflection. */
static ff_status read_blocks(mbsdf *m, block *b, int *with_transmission)
{
    int transmission = 0;
    block unused;
    ff_status status = find_data(m, &transmission);
    if (status == FF_OK) status = read_block(m, b);
    if (status == FF_OK && transmission)
        return ff_error_set(m->err, FF_ERR_UNSUPPORTED, m->path, 0, -1,
                            "found transmission alone, which is not a reflectance; expected a reflection part");
    *with_transmission = status == FF_OK && m->at < m->n;
    if (!*with_transmission) return status;
    status = skip_line(m, transmission_line, "the end of the file or a line MBSDF_DATA_TRANSMISSION=");
    if (status == FF_OK) status = read_block(m, &unused);
    if (status == FF_OK && m->at < m->n)
        status = ff_error_set(m->err, FF_ERR_FORMAT, m->path, 0, (int64_t)m->at,
                              "found %zu bytes after the transmission part, expected the end of the file", m->n - m->at);
    return status;
}

/* ---- table ----------------------------------------------------------------------------------- */

static ff_status not_finite(const mbsdf *m, const block *b)
{
    size_t k = 0;
    while (isfinite(ff_float_of(m->data + b->offset + 4 * k))) k++;
    const int nan = isnan(ff_float_of(m->data + b->offset + 4 * k));
    return ff_error_set(m->err, FF_ERR_DATA, m->path, 0, (int64_t)(b->offset + 4 * k),
                        "value %zu: found %s, expected a finite number", k, nan ? "nan" : "inf");
}

/* Exponent of ones: an infinity or a NaN. */
static uint32_t odd_float(const unsigned char *p)
{
    return (ff_uint32_of(p) & 0x7F800000u) == 0x7F800000u;
}

static ff_status take_values(const mbsdf *m, const block *b, ff_table *t)
{
    const unsigned char *p = m->data + b->offset;
    const size_t n = b->n;
    uint32_t odd = 0;
    if (b->n_channels == 1)
        for (size_t i = 0; i < n; i++, p += 4) {
            odd |= odd_float(p);
            t->value[i] = (double)ff_float_of(p);
        }
    else
        for (size_t i = 0; i < n; i++, p += 12) {
            odd |= odd_float(p) | odd_float(p + 4) | odd_float(p + 8);
            t->value[i] = (double)ff_float_of(p);
            t->value[n + i] = (double)ff_float_of(p + 4);
            t->value[2 * n + i] = (double)ff_float_of(p + 8);
        }
    return odd ? not_finite(m, b) : FF_OK;
}

/* Cells end half way between nodes, at the last theta half a step beyond; phi counts for both signs. */
static void fill_weights(ff_table *t, double *in, double *out, double *azimuth)
{
    const double one = 1;
    const size_t n_theta = t->axes.n[0], n_phi = t->axes.n[3];
    ff_polar_bands(t->axes.node[0], n_theta, t->radians_per_unit, out);
    for (size_t k = 0; k < n_theta; k++) in[k] = 2 * pi * out[k];
    for (size_t k = 0; k < n_phi; k++) azimuth[k] = 2 * pi / (double)(n_phi - 1) / (k == 0 || k + 1 == n_phi ? 2 : 1);
    if (n_phi == 1) azimuth[0] = 2 * pi;
    ff_table_product_weights(t, (const double *const[4]){in, &one, out, azimuth});
}

/* A table of the block's directions with its weights. */
static ff_status new_table(const block *b, ff_table *out, ff_error *err)
{
    const size_t n[4] = {b->n_theta, 1, b->n_theta, b->n_phi};
    const double zero = 0;
    double *work = malloc((2 * b->n_theta + b->n_phi) * sizeof *work);
    if (!work) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu + %zu nodes", b->n_theta, b->n_phi);
    double *theta = work, *phi = work + 2 * b->n_theta;
    for (size_t k = 0; k < b->n_theta; k++) theta[k] = 90 * (double)k / (double)b->n_theta;
    for (size_t k = 0; k < b->n_phi; k++) phi[k] = 180 * (double)k / (double)(b->n_phi - 1);
    if (b->n_phi == 1) phi[0] = 90; /* the middle of all of them */
    const double *const node[4] = {theta, &zero, theta, phi};
    const ff_status status = ff_table_init_axes(FF_AXES_INCIDENT_EXIT, n, node, pi / 180, b->n_channels, 1, out, err);
    if (status == FF_OK) fill_weights(out, work, work + b->n_theta, phi);
    free(work);
    return status;
}

/* ---- notes ----------------------------------------------------------------------------------- */

/* 1 when the values at theta k and k - 1 of one side are the same, bit for bit. */
static int repeats(const mbsdf *m, const block *b, int exit, size_t k)
{
    const size_t row = 4 * b->n_channels * b->n_phi, slice = row * b->n_theta, step = exit ? row : slice;
    const unsigned char *p = m->data + b->offset + k * step;
    for (size_t i = 0; i < (exit ? b->n_theta : 1); i++, p += slice)
        if (memcmp(p, p - step, step) != 0) return 0;
    return 1;
}

/* Samples of theta index k of one side. */
static void mark_theta(const block *b, int exit, size_t k, ff_table *t)
{
    for (size_t j = 0; j < b->n_theta; j++)
        memset(t->valid + (exit ? j * b->n_theta + k : k * b->n_theta + j) * b->n_phi, 0, b->n_phi);
}

/* Files are often filled up to the horizon with the last angle that was measured. What merely repeats it was not measured. */
static void mark_repetition(const mbsdf *m, const block *b, ff_table *t)
{
    for (int exit = 0; exit < 2; exit++) {
        size_t last = b->n_theta;
        while (last > 1 && repeats(m, b, exit, last - 1)) last--;
        if (last == b->n_theta || last == 1) continue; /* none, or no dependence on theta at all */
        for (size_t k = last; k < b->n_theta; k++) mark_theta(b, exit, k, t);
        ff_table_note(t, "beyond %s = %g degrees the values are those of that angle, repeated: taken as not measured",
                      exit ? "theta_o" : "theta_i", t->axes.node[0][last - 1]);
    }
}

static void add_notes(const block *b, int with_transmission, ff_table *t)
{
    ff_table_note(
        t,
        "values are taken to lie at theta = 0, %g, ... degrees and phi = 0 ... 180 degrees; renderers of the MDL SDK look "
        "them up half a step further",
        90 / (double)b->n_theta);
    ff_table_note(
        t, "the two orders of a pair of directions are kept as stored and need not be equal; negative values are kept as noise");
    if (with_transmission) ff_table_note(t, "the file has a transmission part, which is not read");
}

/* ---- reading --------------------------------------------------------------------------------- */

static ff_status read_data(mbsdf *m, ff_table *out)
{
    static const char *const rgb[3] = {"r", "g", "b"};
    block b;
    int with_transmission = 0;
    ff_table t;
    ff_status status = read_blocks(m, &b, &with_transmission);
    if (status == FF_OK) status = new_table(&b, &t, m->err);
    if (status != FF_OK) return status;
    status = take_values(m, &b, &t);
    if (status == FF_OK) mark_repetition(m, &b, &t);
    if (status == FF_OK) status = ff_table_count(&t, m->path, m->err);
    if (status != FF_OK) {
        ff_table_clear(&t);
        return status;
    }
    for (size_t c = 0; c < b.n_channels; c++) strcpy(t.channels[c].name, b.n_channels == 1 ? "f" : rgb[c]);
    snprintf(t.format, sizeof t.format, "mbsdf");
    t.isotropic = 1;
    add_notes(&b, with_transmission, &t);
    *out = t;
    return FF_OK;
}

static ff_status check_part(const char *path, const char *part, ff_error *err)
{
    char found[FF_QUOTE];
    if (!part || strcmp(part, "reflection") == 0) return FF_OK;
    if (strcmp(part, "transmission") == 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "the part 'transmission' is not a reflectance; expected 'reflection'");
    return ff_error_set(err, FF_ERR_UNKNOWN, path, 0, -1, "found the part %s, expected 'reflection'",
                        ff_quote(part, strlen(part), found));
}

/* Are the first bytes the text and the first block of a file of this size? Then it is worth its memory. */
static ff_status check_head(const ff_bytes *f, const unsigned char *head, size_t n)
{
    mbsdf m = {.path = f->path, .err = f->err, .data = head, .n = n};
    int transmission;
    block unused;
    const ff_status status = find_data(&m, &transmission);
    if (n < MOST_TEXT) return status; /* it is the whole file */
    if (status == FF_ERR_READ || (status == FF_OK && n - m.at < HEADER))
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, -1,
                            "found no values in the first %zu bytes, expected a line "
                            "MBSDF_DATA_REFLECTION= and values behind it",
                            n);
    m.n = f->size < 0 ? MOST_BYTES : (size_t)f->size;
    return status == FF_OK ? read_block(&m, &unused) : status;
}

static ff_status read_mbsdf(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_bytes b;
    unsigned char *data = NULL;
    mbsdf m = {.path = path, .err = err};
    ff_status status = check_part(path, o->part, err);
    if (status == FF_OK) status = ff_bytes_open(path, &b, err);
    if (status != FF_OK) return status;
    status = ff_bytes_head(&b, MOST_TEXT, &data, &m.n);
    if (status == FF_OK) status = check_head(&b, data, m.n);
    if (status == FF_OK) status = ff_bytes_rest(&b, MOST_BYTES, &data, &m.n); /* floats are a tenth of the table that they become */
    ff_bytes_close(&b);
    m.data = data;
    if (status == FF_OK) status = read_data(&m, out);
    free(data);
    return status;
}

const ff_format ff_format_mbsdf = {
    .name = "mbsdf",
    .title = "NVIDIA MDL measured BSDF, isotropic, scalar or RGB",
    .extensions = ".mbsdf",
    .source = "NVIDIA MDL specification, appendix on the MBSDF file format; MDL SDK, ibsdf_isotropic_data.h",
    .probe = probe,
    .reads = FF_READS_PART,
    .read = read_mbsdf,
};
