/* Tables of reflectance in OpenEXR images, through OpenEXRCore: one part of scan lines, any number of channels. docs/exr.md is the
 * reference. In short:
 *
 *     facetfit.version          int 1
 *     facetfit.parametrisation  half-difference, incident-exit, specular (axes), merl (grid_merl.c), list
 *     facetfit.samples          int n; sample i is the pixel (x, y) with i = y width + x, the pixels after it are filling
 *     facetfit.theta_h ...      nodes of the axes as text, the last axis fastest: ((a0 n1 + a1) n2 + a2) n3 + a3
 *     facetfit.angle_unit       degree, radian
 *     facetfit.value_unit       1/sr
 *     facetfit.quantity         brdf, brdf-cos, reflectance-factor
 *     facetfit.isotropic        int 0, 1
 *     facetfit.channels         names of the channels in their order;  facetfit.planes: the channels of the image they are in
 *     facetfit.wavelengths      nm, "-" where a channel has none
 *     facetfit.source           format that the table was read from
 *
 * A plane is a channel of floats (or halves), or of doubles: two channels of unsigned integers, NAME.high and NAME.low. Planes are
 * the channels themselves, sigma.NAME, weight, and of a list direction.theta_i and so on. NaN was not measured. Angles are those of
 * ff_model.h and are kept as the file has them.
 *
 * An image of 288 x 288 pixels R, G, B without these attributes is a measurement of the UTIA BRDF database (Filip and Vavra 2014),
 * as the database writes it for its own binaries: line 48 ti + pi is the light, column 48 tv + pv the detector, theta in steps of
 * 15 degrees from 0, phi of 7.5; linear, as OpenEXR has it. Light by lines follows two programs made from the authors' code (ALTA,
 * UTIA-brdf); a reciprocal surface does not tell the difference. The scale of the numbers is not documented. */
#define _GNU_SOURCE
#include "data_formats/formats/exr/internal_exr.h"
#include "base/internal_bytes.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_table.h"
#include "base/internal_tokens.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double degree = 3.14159265358979323846 / 180;
static const char *const quantity_name[3] = {"brdf", "brdf-cos", "reflectance-factor"};

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    return n >= 4 && memcmp(head, "\x76\x2F\x31\x01", 4) == 0 ? 95 : 0;
}

/* ---- attributes ------------------------------------------------------------------------------ */

/* What the attributes say of a table. */
typedef struct description {
    int merl;
    ff_axes_kind kind;
    size_t n, n_channels;
    size_t n_axis[4];
    double *node[4];
    double unit;
    int quantity, isotropic;
    int with_sigma, with_weight;
    char **name, **plane; /* [n_channels] */
    double *wavelength;   /* [n_channels] */
    char source[FF_EXR_SOURCE];
} description;

static void description_free(description *d)
{
    for (int k = 0; k < 4; k++) free(d->node[k]);
    for (size_t c = 0; c < d->n_channels; c++) {
        if (d->name) free(d->name[c]);
        if (d->plane) free(d->plane[c]);
    }
    free(d->name);
    free(d->plane);
    free(d->wavelength);
}

static ff_status no_memory(const ff_exr_file *f)
{
    return ff_error_set(f->err, FF_ERR_MEMORY, f->path, 0, -1, "no memory for the table's description");
}

static ff_status find(const ff_exr_file *f, const char *name, const char *type, const ff_exr_attribute **out)
{
    char found[FF_QUOTE];
    const ff_exr_attribute *a = ff_exr_attribute_find(f, name);
    if (!a)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, 8, "found no attribute '%s' of type %s, expected one", name, type);
    *out = a;
    if (strcmp(a->type, type) == 0) return FF_OK;
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset, "attribute '%s': found the type %s, expected %s", name,
                        ff_quote(a->type, strlen(a->type), found), type);
}

static ff_status find_int(const ff_exr_file *f, const char *name, long least, long most, long *out)
{
    const ff_exr_attribute *a = NULL;
    const ff_status status = find(f, name, "int", &a);
    if (status != FF_OK) return status;
    *out = (int32_t)ff_uint32_of(a->data);
    if (*out >= least && *out <= most) return FF_OK;
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset, "attribute '%s': found %ld, expected %ld to %ld", name, *out,
                        least, most);
}

/* Which of n words a text attribute is. */
static ff_status find_word(const ff_exr_file *f, const char *name, const char *const *words, size_t n, int *out)
{
    const ff_exr_attribute *a = NULL;
    char found[FF_QUOTE], list[160] = "";
    const ff_status status = find(f, name, "string", &a);
    if (status != FF_OK) return status;
    for (size_t k = 0; k < n; k++) {
        if (a->n == strlen(words[k]) && memcmp(a->data, words[k], a->n) == 0) {
            *out = (int)k;
            return FF_OK;
        }
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", k ? ", " : "", words[k]);
    }
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset, "attribute '%s': found %s, expected %s%s", name,
                        ff_quote((const char *)a->data, a->n, found), n > 1 ? "one of " : "", list);
}

static char *copy_text(const ff_exr_attribute *a)
{
    return memchr(a->data, '\0', a->n) ? NULL : strndup((const char *)a->data, a->n);
}

static ff_status read_axis(const ff_exr_file *f, const char *name, double **node, size_t *n)
{
    const ff_exr_attribute *a = NULL;
    ff_status status = find(f, name, "string", &a);
    if (status != FF_OK) return status;
    char *text = copy_text(a);
    const size_t most = a->n / 2 + 1; /* a digit and a blank each */
    *node = malloc(most * sizeof **node);
    if (!text || !*node)
        status = no_memory(f);
    else
        status = ff_line_numbers(text, *node, most, n, f->path, 0, name, f->err);
    free(text);
    if (status == FF_OK && *n == 0)
        status = ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset,
                              "attribute '%s': found no number, expected the nodes of an axis", name);
    return status;
}

static ff_status read_axes(const ff_exr_file *f, description *d)
{
    size_t samples = 1;
    for (int k = 0; k < 4; k++) {
        const ff_status status = read_axis(f, ff_exr_axis_name[d->kind][k], &d->node[k], &d->n_axis[k]);
        if (status != FF_OK) return status;
        samples = samples > d->n ? samples : samples * d->n_axis[k]; /* n < 2^31, an axis < 2^31 */
    }
    if (samples == d->n) return FF_OK;
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, -1, "found axes of %zu x %zu x %zu x %zu nodes, expected %zu samples",
                        d->n_axis[0], d->n_axis[1], d->n_axis[2], d->n_axis[3], d->n);
}

static int is_name(const char *text, size_t length)
{
    for (size_t k = 0; k < length; k++)
        if ((unsigned char)text[k] < 0x20 || text[k] == 0x7F) return 0;
    return length > 0;
}

/* A list of texts; *n is their number, which is to be `expected` unless that is 0. */
static ff_status read_names(const ff_exr_file *f, const char *name, size_t expected, size_t most, char ***out, size_t *n)
{
    const ff_exr_attribute *a = NULL;
    const ff_status status = find(f, name, "stringvector", &a);
    if (status != FF_OK) return status;
    size_t count = 0;
    for (size_t at = 0; at < a->n; at += 4 + ff_uint32_of(a->data + at)) count++;
    if (count == 0 || count > f->n_channels || (expected && count != expected))
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset, "attribute '%s': found %zu names, expected %s%zu", name,
                            count, expected ? "" : "1 to ", expected ? expected : f->n_channels);
    if (!(*out = calloc(count, sizeof **out))) return no_memory(f);
    *n = count;
    for (size_t at = 0, c = 0; at < a->n; c++) {
        const size_t length = ff_uint32_of(a->data + at);
        const char *text = (const char *)a->data + at + 4;
        char found[FF_QUOTE];
        if (length > most || !is_name(text, length))
            return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset + (int64_t)at,
                                "attribute '%s': found the name %s, expected 1 to %zu bytes without control characters", name,
                                ff_quote(text, length, found), most);
        if (!((*out)[c] = strndup(text, length))) return no_memory(f);
        at += 4 + length;
    }
    return FF_OK;
}

static ff_status check_names(const ff_exr_file *f, const description *d)
{
    for (size_t c = 0; c < d->n_channels; c++)
        for (size_t k = 0; k < c; k++)
            if (strcmp(d->name[c], d->name[k]) == 0 || strcmp(d->plane[c], d->plane[k]) == 0) {
                char found[FF_QUOTE];
                return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, -1, "found channel %s twice, expected it once",
                                    ff_quote(d->name[c], strlen(d->name[c]), found));
            }
    return FF_OK;
}

static ff_status read_wavelengths(const ff_exr_file *f, description *d)
{
    const ff_exr_attribute *a = NULL;
    if (!(d->wavelength = calloc(d->n_channels, sizeof *d->wavelength))) return no_memory(f);
    const ff_status status = find(f, FF_EXR_A("wavelengths"), "string", &a);
    char *text = status == FF_OK ? copy_text(a) : NULL, *rest = NULL;
    if (status == FF_OK && !text) return no_memory(f);
    int right = text != NULL;
    size_t c = 0;
    for (char *word = text ? strtok_r(text, " ", &rest) : NULL; word && right; word = strtok_r(NULL, " ", &rest), c++) {
        double nm = NAN;
        const char *end = strcmp(word, "-") == 0 ? word + 1 : ff_number_read(word, &nm);
        right = c < d->n_channels && end && !*end && (isnan(nm) || (nm > 0 && isfinite(nm)));
        if (right) d->wavelength[c] = nm;
    }
    right = right && c == d->n_channels;
    free(text);
    if (status != FF_OK || right) return status;
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset,
                        "attribute '" FF_EXR_A("wavelengths") "': expected a number > 0 or '-' for each of the %zu channels",
                        d->n_channels);
}

static ff_status read_samples(const ff_exr_file *f, description *d)
{
    long n;
    ff_status status = find_int(f, FF_EXR_A("samples"), 1, INT32_MAX, &n);
    if (status != FF_OK) return status;
    d->n = (size_t)n;
    if (d->n > (uint64_t)f->width * (uint64_t)f->height)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, -1,
                            "found an image of %lld x %lld pixels, expected the %zu samples of "
                            "the attribute '" FF_EXR_A("samples") "'",
                            (long long)f->width, (long long)f->height, d->n);
    if (d->merl && d->n != ff_grid_merl.n)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, -1, "found %zu samples, expected the %zu of the MERL grid", d->n,
                            ff_grid_merl.n);
    return d->kind ? read_axes(f, d) : FF_OK;
}

static int has_channel(const ff_exr_file *f, const char *prefix, const char *name)
{
    char plain[320], high[320];
    snprintf(plain, sizeof plain, "%s%s", prefix, name);
    snprintf(high, sizeof high, "%s%s" FF_EXR_HIGH, prefix, name);
    return ff_exr_channel_find(f, plain) >= 0 || ff_exr_channel_find(f, high) >= 0;
}

static void read_source(const ff_exr_file *f, description *d)
{
    const ff_exr_attribute *a = ff_exr_attribute_find(f, FF_EXR_A("source"));
    size_t n = 0;
    if (a && strcmp(a->type, "string") == 0)
        while (n < a->n && n + 1 < sizeof d->source && a->data[n] > ' ' && a->data[n] < 0x7F) n++;
    if (n) memcpy(d->source, a->data, n);
    d->source[n] = '\0';
}

static ff_status read_description(const ff_exr_file *f, description *d)
{
    static const char *const parametrisations[5] = {"list", "half-difference", "incident-exit", "specular", "merl"};
    static const char *const angle_units[2] = {"degree", "radian"}, *const value_units[1] = {"1/sr"};
    long version, isotropic = 0;
    size_t n_planes;
    int which = 0, angle_unit = 0, value_unit = 0;
    ff_status status = find_int(f, FF_EXR_A("version"), FF_EXR_VERSION, FF_EXR_VERSION, &version);
    if (status == FF_OK) status = find_word(f, FF_EXR_A("parametrisation"), parametrisations, 5, &which);
    if (status == FF_OK) status = find_word(f, FF_EXR_A("quantity"), quantity_name, 3, &d->quantity);
    if (status == FF_OK) status = find_word(f, FF_EXR_A("angle_unit"), angle_units, 2, &angle_unit);
    if (status == FF_OK) status = find_word(f, FF_EXR_A("value_unit"), value_units, 1, &value_unit);
    if (status == FF_OK) status = find_int(f, FF_EXR_A("isotropic"), 0, 1, &isotropic);
    d->merl = which == 4;
    d->kind = d->merl ? FF_AXES_NONE : (ff_axes_kind)which;
    d->unit = angle_unit ? 1 : degree;
    d->isotropic = (int)isotropic;
    if (status == FF_OK) status = read_samples(f, d);
    if (status == FF_OK) status = read_names(f, FF_EXR_A("channels"), 0, FF_CHANNEL_NAME - 1, &d->name, &d->n_channels);
    if (status == FF_OK) status = read_names(f, FF_EXR_A("planes"), d->n_channels, 240, &d->plane, &n_planes);
    if (status == FF_OK) status = check_names(f, d);
    if (status == FF_OK) status = read_wavelengths(f, d);
    if (status != FF_OK) return status;
    d->with_sigma = has_channel(f, "sigma.", d->plane[0]);
    d->with_weight = has_channel(f, "", "weight");
    read_source(f, d);
    return FF_OK;
}

/* ---- the table ------------------------------------------------------------------------------- */

/* A table takes far more memory than the compressed file can be worth: somebody made it so. */
static ff_status check_memory(const ff_exr_file *f, size_t n, size_t planes)
{
    const double most = 48e6, expansion = 2000;
    const double chunk = 8.0 * (double)f->width * ff_exr_chunk_lines(f->compression) * (double)f->n_channels;
    const double bytes = 8.0 * (double)n * (double)planes + (double)n + (f->compression ? 1.5 * chunk : chunk);
    if (bytes <= most || bytes <= expansion * (double)f->size) return FF_OK;
    return ff_error_set(
        f->err, FF_ERR_FORMAT, f->path, 0, -1,
        "found %zu samples in %zu channels of %lld x %lld pixels in a file of %lld bytes, expected a file that can hold "
        "them",
        n, f->n_channels, (long long)f->width, (long long)f->height, (long long)f->size);
}

static ff_status new_table(const ff_exr_file *f, const description *d, ff_table *t)
{
    const int angles = d->merl ? 0 : 4;
    ff_status status = check_memory(f, d->n, d->n_channels * (d->with_sigma ? 2 : 1) + (size_t)(d->with_weight + angles));
    if (status != FF_OK) return status;
    if (d->kind) {
        status = ff_table_init_axes(d->kind, d->n_axis, (const double *const *)d->node, d->unit, d->n_channels, d->with_weight, t,
                                    f->err);
        if (status != FF_OK || !d->with_sigma) return status;
        if ((t->sigma = calloc(d->n_channels * d->n, sizeof *t->sigma))) return FF_OK;
        ff_table_clear(t);
        return no_memory(f);
    }
    status = ff_table_init(d->n, d->n_channels, d->merl ? &ff_grid_merl : NULL, d->with_sigma, d->with_weight, t, f->err);
    if (status == FF_OK && !d->merl) t->radians_per_unit = d->unit;
    return status;
}

static ff_status describe(const ff_exr_file *f, const description *d, ff_table *t)
{
    snprintf(t->format, sizeof t->format, "exr");
    t->isotropic = d->isotropic;
    for (size_t c = 0; c < d->n_channels; c++) {
        snprintf(t->channels[c].name, sizeof t->channels[c].name, "%s", d->name[c]);
        t->channels[c].wavelength_nm = d->wavelength[c];
    }
    if (f->compression >= EXR_COMPRESSION_PXR24)
        ff_table_note(t, "the image was compressed with loss (OpenEXR compression %d): its numbers are not those that were written",
                      f->compression);
    char high[320];
    snprintf(high, sizeof high, "%s" FF_EXR_HIGH, d->plane[0]);
    return ff_exr_keep(t, ff_exr_channel_find(f, d->plane[0]) < 0 && ff_exr_channel_find(f, high) >= 0, d->source, f->err);
}

/* Reads the planes whose names and places are in `planes`, and finishes the table; frees it on failure. */
static ff_status finish(ff_exr_file *f, ff_exr_plane *planes, size_t n, ff_quantity quantity, ff_table *t, ff_table *out)
{
    ff_status status = FF_OK;
    for (size_t k = 0; k < n && status == FF_OK; k++) status = ff_exr_plane_find(f, &planes[k]);
    if (status == FF_OK) status = ff_exr_pixels_read(f, planes, n, t);
    if (status == FF_OK) {
        ff_table_set_quantity(t, quantity);
        status = ff_table_count(t, f->path, f->err);
    }
    if (status == FF_OK)
        *out = *t;
    else
        ff_table_clear(t);
    return status;
}

static ff_status read_planes(ff_exr_file *f, const description *d, const ff_read_options *o, ff_table *t, ff_table *out)
{
    const size_t most = 2 * d->n_channels + 5;
    ff_exr_plane *planes = calloc(most, sizeof *planes);
    char(*sigma)[256] = calloc(d->n_channels, sizeof *sigma);
    size_t n = 0;
    ff_status status = FF_OK;
    if (!planes || !sigma) {
        ff_table_clear(t);
        status = no_memory(f);
    } else {
        for (size_t c = 0; c < d->n_channels; c++) {
            snprintf(sigma[c], sizeof sigma[c], "sigma.%s", d->plane[c]);
            planes[n++] = (ff_exr_plane){.name = d->plane[c], .role = FF_EXR_VALUE, .to = t->value + c * t->n};
            if (t->sigma) planes[n++] = (ff_exr_plane){.name = sigma[c], .role = FF_EXR_SIGMA, .to = t->sigma + c * t->n};
        }
        if (t->weight) planes[n++] = (ff_exr_plane){.name = "weight", .role = FF_EXR_WEIGHT, .to = t->weight};
        for (int k = 0; k < 4 && !t->grid && !d->kind; k++)
            planes[n++] = (ff_exr_plane){.name = ff_exr_direction[k], .role = FF_EXR_ANGLE, .to = t->angle[k]};
        status = finish(f, planes, n, ff_read_quantity(o, (ff_quantity)d->quantity), t, out);
    }
    free(planes);
    free(sigma);
    return status;
}

static ff_status read_table(ff_exr_file *f, const ff_read_options *o, ff_table *out)
{
    description d = {0};
    ff_table t;
    ff_status status = read_description(f, &d);
    if (status == FF_OK) status = new_table(f, &d, &t);
    if (status == FF_OK && (status = describe(f, &d, &t)) != FF_OK) ff_table_clear(&t);
    if (status == FF_OK) status = read_planes(f, &d, o, &t, out);
    description_free(&d);
    return status;
}

/* ---- the UTIA database ----------------------------------------------------------------------- */

enum { UTIA_THETA = 6, UTIA_PHI = 48, UTIA_SIDE = UTIA_THETA * UTIA_PHI };

static int is_utia(const ff_exr_file *f)
{
    return f->width == UTIA_SIDE && f->height == UTIA_SIDE && ff_exr_channel_find(f, "R") >= 0 &&
           ff_exr_channel_find(f, "G") >= 0 && ff_exr_channel_find(f, "B") >= 0;
}

static ff_status read_utia(ff_exr_file *f, const ff_read_options *o, ff_table *out)
{
    static const char *const name[3] = {"r", "g", "b"}, *const plane[3] = {"R", "G", "B"};
    double theta[UTIA_THETA], phi[UTIA_PHI];
    for (int k = 0; k < UTIA_THETA; k++) theta[k] = 15 * k;
    for (int k = 0; k < UTIA_PHI; k++) phi[k] = 7.5 * k;
    const size_t n[4] = {UTIA_THETA, UTIA_PHI, UTIA_THETA, UTIA_PHI};
    const double *const node[4] = {theta, phi, theta, phi};
    ff_exr_plane planes[3];
    ff_table t;
    ff_status status = check_memory(f, (size_t)UTIA_SIDE * UTIA_SIDE, 7);
    if (status == FF_OK) status = ff_table_init_axes(FF_AXES_INCIDENT_EXIT, n, node, degree, 3, 0, &t, f->err);
    if (status != FF_OK) return status;
    snprintf(t.format, sizeof t.format, "exr");
    for (size_t c = 0; c < 3; c++) {
        snprintf(t.channels[c].name, sizeof t.channels[c].name, "%s", name[c]);
        planes[c] = (ff_exr_plane){.name = plane[c], .role = FF_EXR_VALUE, .to = t.value + c * t.n};
    }
    ff_table_note(&t,
                  "an image of 288 x 288 pixels without our attributes is taken for one of the UTIA BRDF database, lines the light "
                  "and columns the detector");
    ff_table_note_hint(&t, FF_HINT_SCALE,
                       "its numbers are taken to be linear, in the sRGB primaries%s; their scale is not documented",
                       o->quantity >= 0 ? "" : ", and the BRDF in 1/sr");
    return finish(f, planes, 3, ff_read_quantity(o, FF_BRDF), &t, out);
}

/* ---- reading --------------------------------------------------------------------------------- */

static ff_status not_a_table(const ff_exr_file *f)
{
    return ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, 0, -1,
                        "found a picture of %lld x %lld pixels without the attribute '" FF_EXR_A(
                            "version") "', expected a table of "
                                       "reflectance as facetfit writes it (docs/exr.md), or the 288 x 288 pixels R, G, B of the "
                                       "UTIA database; pictures "
                                       "are read through a CSV that lists them, one image per pair of directions",
                        (long long)f->width, (long long)f->height);
}

static ff_status read_exr(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_exr_file f;
    ff_status status = ff_exr_open(path, &f, err);
    if (status != FF_OK) return status;
    if (ff_exr_attribute_find(&f, FF_EXR_A("version")))
        status = read_table(&f, o, out);
    else
        status = is_utia(&f) ? read_utia(&f, o, out) : not_a_table(&f);
    ff_exr_close(&f);
    return status;
}

const ff_format ff_format_exr = {
    .name = "exr",
    .title = "OpenEXR image of a table on axes, on the MERL grid or of scattered directions; UTIA BRDF database",
    .extensions = ".exr",
    .source = "docs/exr.md; Filip and Vavra 2014, btf.utia.cas.cz",
    .probe = probe,
    .reads = FF_READS_QUANTITY,
    .holds = FF_HOLDS_SIGMA | FF_HOLDS_INVALID | FF_HOLDS_NEGATIVE | FF_HOLDS_NAMES | FF_HOLDS_WEIGHTS | FF_HOLDS_MANY,
    .precision = "32-bit float, 6e-8 relative; exact where the grid says 'double'",
    .read = read_exr,
    .layout = ff_exr_layout,
    .write = ff_exr_write,
};
