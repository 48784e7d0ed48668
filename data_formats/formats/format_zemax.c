/* The BSDF data interchange format of Radiant Imaging, which Zemax OpticStudio reads as "tabular BSDF".
 *
 *     # comment                              anywhere
 *     Source           Measured
 *     Symmetry         PlaneSymmetrical, Asymmetrical or Asymmetrical4D
 *     SpectralContent  Monochrome or XYZ
 *     ScatterType      BRDF or BTDF
 *     SampleRotation   n                     then n angles, in degrees as all of them
 *     AngleOfIncidence n                     then n angles
 *     ScatterAzimuth   n                     then n angles; 0 to 180 when PlaneSymmetrical
 *     ScatterRadial    n                     then n angles
 *     Monochrome                             or TristimulusX, TristimulusY, TristimulusZ, each with data of its own
 *     DataBegin
 *     TIS v                                  total integrated scatter of one rotation and incidence (incidence runs faster)
 *     numbers                                a row per azimuth, a column per radial angle, in 1/sr without the cosine
 *     DataEnd
 *
 * Writers differ in the case of words, and in blanks and tabs. wo is given about the specular direction: ScatterRadial is the angle
 * between the two (not a difference of direction cosines), azimuth 0 points from the specular direction towards the normal and
 * grows counter-clockwise; axes.c has the formula. At rotation 0 the normal of the plane of incidence is the local +x; the maker's
 * own converter to Speos has the reflected ray over +y then, and turns the sample by +rotation.
 *
 * The specification says so of azimuth and rotation, and measured files agree: in four of them every number below the horizon of
 * this geometry is 0, which with azimuth 0 on the other side they are not; the values of a coating are reciprocal to 21 % rms (the
 * other way to 77 %), and those of a file of the same coating in absolute angles to 8 % (the other way to 38 %).
 *
 * 0 is the only mark there is for "not measured": below the horizon, and where an instrument does not reach. So it is read, and so
 * is written what was not measured; a measured value of exactly 0 does not survive. A number at or below the horizon is kept where
 * it stands, but not valid.
 * TIS is not the values' integral in many files, and nothing here depends on it. It is kept for writing the same file again;
 * otherwise it is the integral of f cos(theta_o) over the cells of the grid, plane-symmetrical halves counted twice.
 * Each sample has the solid angle of the directions nearest to it, where the azimuths are dense enough to speak of cells. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "models/model_struct.h"
#include "base/internal_number.h"
#include "data_formats/formats/zemax/internal_zemax.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;
enum { MONOCHROME, XYZ };
enum { BRDF, BTDF, BSDF };
static const char *const symmetry_name[] = {"PlaneSymmetrical", "Asymmetrical", "Asymmetrical4D", NULL};
static const char *const content_name[] = {"Monochrome", "XYZ", NULL};
static const char *const type_name[] = {"BRDF", "BTDF", "BSDF", NULL};
static const char *const axis_name[FF_ZEMAX_AXES] = {"SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial"};
static const double axis_least[FF_ZEMAX_AXES] = {-360, 0, -360, 0};
static const char *const part_name[2][3] = {{"Monochrome"}, {"TristimulusX", "TristimulusY", "TristimulusZ"}};

/* What is needed to write the same file again. */
typedef struct kept {
    int symmetry;
    size_t n;     /* of tis: channels x rotations x incidences */
    double tis[]; /* in stored units, as the values           */
} kept;

/* ---- reading --------------------------------------------------------------------------------- */

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    static const char *const keywords[] = {"SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial",
                                           "Symmetry",       "SpectralContent",  "ScatterType",    NULL};
    (void)file_size;
    const unsigned found = ff_keywords_in(head, n, keywords);
    int count = 0;
    for (unsigned bits = found; bits; bits &= bits - 1) count++;
    if (!(found & 3u)) return found & 12u && count > 2 ? 40 : 0; /* lighttools has neither of the two */
    return count > 3 ? 97 : count > 1 ? 60 : 20;
}

typedef struct zemax {
    ff_tokens t;
    ff_error *err;
    const char *path;
    int symmetry, content, type; /* -1 = not seen */
    ff_values axis[FF_ZEMAX_AXES], value, tis;
    size_t n[FF_ZEMAX_AXES], n_channels, n_blocks; /* blocks per channel */
} zemax;

static ff_status unexpected(zemax *z, const char *word, const char *expected)
{
    char found[FF_QUOTE];
    if (!word)
        return ff_error_set(z->err, FF_ERR_READ, z->path, z->t.lines.line, -1, "found the end of the file, expected %s", expected);
    return ff_error_set(z->err, FF_ERR_FORMAT, z->path, z->t.lines.line, -1, "found %s, expected %s",
                        ff_quote(word, strlen(word), found), expected);
}

static int begins_data(const char *word)
{
    for (int k = 0; k < 3; k++)
        if (strcasecmp(word, part_name[XYZ][k]) == 0) return 1;
    return strcasecmp(word, "DataBegin") == 0 || strcasecmp(word, part_name[MONOCHROME][0]) == 0;
}

/* What follows one word of the header. Words that are unknown are left with the rest of their line. */
static ff_status read_keyword(zemax *z, const char *word)
{
    if (strcasecmp(word, "Symmetry") == 0) return ff_choice_read(&z->t, "Symmetry", symmetry_name, &z->symmetry);
    if (strcasecmp(word, "SpectralContent") == 0) return ff_choice_read(&z->t, "SpectralContent", content_name, &z->content);
    if (strcasecmp(word, "ScatterType") == 0) return ff_choice_read(&z->t, "ScatterType", type_name, &z->type);
    for (int k = 0; k < FF_ZEMAX_AXES; k++)
        if (strcasecmp(word, axis_name[k]) == 0)
            return ff_angles_read(&z->t, axis_name[k], axis_least[k], ff_zemax_axis_most[k], &z->axis[k]);
    if ((*word >= '0' && *word <= '9') || *word == '-' || *word == '+' || *word == '.')
        return unexpected(z, word, "a keyword such as ScatterRadial: are there more angles than their count says?");
    z->t.at = NULL;
    return FF_OK;
}

static ff_status missing(zemax *z, const char *keyword)
{
    return ff_error_set(z->err, FF_ERR_FORMAT, z->path, z->t.lines.line, -1, "found data without %s before, expected it", keyword);
}

static ff_status check_header(zemax *z)
{
    if (z->symmetry < 0) return missing(z, "Symmetry");
    if (z->content < 0) return missing(z, "SpectralContent");
    if (z->type < 0) return missing(z, "ScatterType");
    for (int k = 0; k < FF_ZEMAX_AXES; k++) {
        if (z->axis[k].n == 0) return missing(z, axis_name[k]);
        z->n[k] = z->axis[k].n;
    }
    if (z->type == BTDF)
        return ff_error_set(z->err, FF_ERR_UNSUPPORTED, z->path, z->t.lines.line, -1,
                            "found ScatterType BTDF, transmission; expected BRDF, since only reflection is read");
    z->n_channels = z->content == XYZ ? 3 : 1;
    z->n_blocks = z->n[FF_ZEMAX_ROTATION] * z->n[FF_ZEMAX_INCIDENCE];
    return FF_OK;
}

/* Up to the word that begins the data, which is handed out. */
static ff_status read_header(zemax *z, char **word)
{
    for (;;) {
        ff_status status = ff_tokens_word(&z->t, word);
        if (status != FF_OK) return status;
        if (!*word) return unexpected(z, NULL, "DataBegin and values");
        if (begins_data(*word)) return check_header(z);
        status = read_keyword(z, *word);
        if (status != FF_OK) return status;
    }
}

static ff_status skip_word(zemax *z, const char *expected, int required, char **word)
{
    if (*word && strcasecmp(*word, expected) == 0) return ff_tokens_word(&z->t, word);
    return required ? unexpected(z, *word, expected) : FF_OK;
}

static ff_status read_block(zemax *z, char **word)
{
    char what[64];
    if (!*word || strcasecmp(*word, "TIS") != 0) return unexpected(z, *word, "TIS and the values of the next incidence");
    ff_status status = ff_values_read(&z->t, 1, "TIS", &z->tis);
    snprintf(what, sizeof what, "a row of %zu values", z->n[FF_ZEMAX_RADIAL]);
    for (size_t a = 0; a < z->n[FF_ZEMAX_AZIMUTH] && status == FF_OK; a++)
        status = ff_values_read(&z->t, z->n[FF_ZEMAX_RADIAL], what, &z->value);
    return status == FF_OK ? ff_tokens_word(&z->t, word) : status;
}

/* DataBegin and DataEnd around the second and third part of a tristimulus file are as writers like it. */
static ff_status read_data(zemax *z, char *word)
{
    ff_status status = FF_OK;
    for (size_t c = 0; c < z->n_channels && status == FF_OK; c++) {
        status = skip_word(z, part_name[z->content][c], z->content == XYZ, &word);
        if (status == FF_OK) status = skip_word(z, "DataBegin", c == 0, &word);
        for (size_t b = 0; b < z->n_blocks && status == FF_OK; b++) status = read_block(z, &word);
        if (status == FF_OK) status = skip_word(z, "DataEnd", c + 1 == z->n_channels, &word);
    }
    return status == FF_OK && word ? unexpected(z, word, "the end of the file after DataEnd") : status;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void *kept_copy(void *original)
{
    const kept *k = original;
    const size_t bytes = sizeof *k + k->n * sizeof *k->tis;
    kept *copy = malloc(bytes);
    if (copy) memcpy(copy, k, bytes);
    return copy;
}

static ff_status keep(const zemax *z, ff_table *t)
{
    kept *k = malloc(sizeof *k + z->tis.n * sizeof *k->tis);
    if (!k) return ff_error_set(z->err, FF_ERR_MEMORY, z->path, 0, -1, "no memory for %zu values of TIS", z->tis.n);
    k->symmetry = z->symmetry;
    k->n = z->tis.n;
    memcpy(k->tis, z->tis.value, z->tis.n * sizeof *k->tis);
    t->kept = k;
    t->kept_free = free;
    t->kept_share = kept_copy;
    return FF_OK;
}

static int is_below(const ff_table *t, size_t i, double horizon)
{
    return t->angle[0][i] >= horizon || t->angle[2][i] >= horizon;
}

/* Below this angle, in the table's unit, a direction is above the horizon. */
static double horizon_of(const ff_table *t)
{
    return acos(FF_COS_MIN) / t->radians_per_unit;
}

static void mark_unmeasured(ff_table *t)
{
    const double horizon = horizon_of(t);
    size_t zeros = 0, below = 0;
    for (size_t i = 0; i < t->n; i++) {
        int any = 0;
        for (size_t c = 0; c < t->n_channels; c++) any |= t->value[c * t->n + i] != 0;
        const int hidden = is_below(t, i, horizon);
        t->valid[i] = any && !hidden;
        zeros += !any && !hidden;
        below += any && hidden;
    }
    if (zeros) ff_table_note(t, "%zu values of 0 above the horizon are taken to be unmeasured", zeros);
    if (below) ff_table_note(t, "%zu values other than 0 stand at or below the horizon; they are left out", below);
}

/* Says how far the file's TIS is from its values; 20 % are a coarse grid's own error. */
static void compare_tis(const zemax *z, const ff_zemax_cells *c, ff_table *t)
{
    const size_t per_block = z->n[FF_ZEMAX_AZIMUTH] * z->n[FF_ZEMAX_RADIAL];
    size_t far = 0;
    double least = INFINITY, most = 0;
    for (size_t b = 0; b < z->tis.n; b++) {
        const size_t first = b % z->n_blocks * per_block;
        const double integral =
            ff_zemax_block_integral(c, z->n, b % z->n[FF_ZEMAX_INCIDENCE], t->value + b * per_block, t->valid + first);
        const double ratio = z->tis.value[b] / integral;
        if (!(integral > 0) || !(fabs(ratio - 1) > 0.2)) continue;
        far++;
        least = fmin(least, ratio);
        most = fmax(most, ratio);
    }
    if (far)
        ff_table_note(t,
                      "TIS of %zu of %zu blocks is not the integral of f cos(theta_o) over the block, but %.3g to %.3g times it; "
                      "the values stay as they are",
                      far, z->tis.n, least, most);
}

static ff_status describe(const zemax *z, ff_table *t)
{
    ff_zemax_cells c;
    const double *const node[FF_ZEMAX_AXES] = {t->axes.node[0], t->axes.node[1], t->axes.node[2], t->axes.node[3]};
    ff_status status = ff_zemax_cells_make(z->n, node, z->symmetry, &c, z->err);
    if (status != FF_OK) return status;
    snprintf(t->format, sizeof t->format, "zemax");
    t->isotropic = z->n[FF_ZEMAX_ROTATION] == 1;
    for (size_t k = 0; k < t->n_channels; k++)
        snprintf(t->channels[k].name, FF_CHANNEL_NAME, "%s", z->content == XYZ ? ff_zemax_xyz[k] : "f");
    mark_unmeasured(t);
    if (z->type == BSDF) ff_table_note(t, "ScatterType is BSDF: reflection is assumed");
    if (t->weight) {
        const double *const of[FF_ZEMAX_AXES] = {c.of[0], c.of[1], c.of[2], c.of[3]};
        ff_table_product_weights(t, of);
        compare_tis(z, &c, t);
    }
    free(c.memory);
    return keep(z, t);
}

/* The values were read in the table's order: their memory becomes its plane. */
static ff_status make_table(zemax *z, ff_table *out)
{
    ff_table t;
    const double *const node[FF_ZEMAX_AXES] = {z->axis[0].value, z->axis[1].value, z->axis[2].value, z->axis[3].value};
    ff_status status =
        ff_table_init_axes(FF_AXES_SPECULAR, z->n, node, degree, z->n_channels, ff_zemax_has_cells(z->n, node), &t, z->err);
    if (status != FF_OK) return status;
    double *exact = realloc(z->value.value, z->value.n * sizeof *exact);
    free(t.value);
    t.value = exact ? exact : z->value.value;
    z->value = (ff_values){0};
    status = describe(z, &t);
    if (status == FF_OK) status = ff_table_count(&t, z->path, z->err);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

static ff_status read_zemax(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    char *word = NULL;
    zemax z = {.err = err, .path = path, .symmetry = -1, .content = -1, .type = -1};
    ff_status status = ff_tokens_open(path, &z.t, err);
    if (status != FF_OK) return status;
    status = read_header(&z, &word);
    if (status == FF_OK) status = read_data(&z, word);
    ff_tokens_close(&z.t);
    if (status == FF_OK) status = make_table(&z, out);
    for (int k = 0; k < FF_ZEMAX_AXES; k++) free(z.axis[k].value);
    free(z.value.value);
    free(z.tis.value);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    const ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK) return status;
    if (t->axes.kind != FF_AXES_SPECULAR)
        return ff_error_set(
            err, FF_ERR_UNSUPPORTED, path, 0, -1,
            "a file of this format has a grid about the specular direction, and these directions are none; resample "
            "to it, or write csv or astm");
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a file of this format has no room for the standard deviations of this table; write csv");
    return ff_zemax_check_channels(t, path, err);
}

static void put_number(FILE *file, double v, char after)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
    putc(after, file);
}

typedef struct writer {
    const ff_table *t;
    FILE *file;
    const kept *kept; /* NULL: the table is not as it was read */
    ff_zemax_cells cells;
    double horizon;
} writer;

static void write_header(const writer *w, int symmetry)
{
    const ff_table *t = w->t;
    const double factor = t->radians_per_unit / degree; /* exactly 1 for degrees */
    fprintf(w->file, "# BSDF data interchange format\nSource\tMeasured\nSymmetry\t%s\nSpectralContent\t%s\nScatterType\tBRDF\n",
            symmetry_name[symmetry], content_name[t->n_channels == 3 ? XYZ : MONOCHROME]);
    for (int k = 0; k < FF_ZEMAX_AXES; k++) {
        fprintf(w->file, "%s\t%zu\n", axis_name[k], t->axes.n[k]);
        for (size_t i = 0; i < t->axes.n[k]; i++)
            put_number(w->file, factor * t->axes.node[k][i], i + 1 < t->axes.n[k] ? '\t' : '\n');
    }
}

/* What a sample that was not measured holds: 0, or its own number where that stands at or below the horizon. */
static double stored_invalid(const writer *w, size_t c, size_t i)
{
    const double v = w->t->value[c * w->t->n + i];
    return w->kept && is_below(w->t, i, w->horizon) && isfinite(v) ? v : 0;
}

static void write_block(const writer *w, size_t c, size_t block)
{
    const ff_table *t = w->t;
    const size_t *n = t->axes.n, per_block = n[FF_ZEMAX_AZIMUTH] * n[FF_ZEMAX_RADIAL], first = block * per_block;
    const double scale = t->channels[c].scale, *v = t->value + c * t->n + first;
    const double tis = w->kept ? w->kept->tis[c * n[FF_ZEMAX_ROTATION] * n[FF_ZEMAX_INCIDENCE] + block]
                               : ff_zemax_block_integral(&w->cells, n, block % n[FF_ZEMAX_INCIDENCE], v, t->valid + first);
    fputs("TIS\t", w->file);
    put_number(w->file, scale * tis, '\n');
    for (size_t i = 0; i < per_block; i++) {
        const double stored = t->valid[first + i] ? v[i] : stored_invalid(w, c, first + i);
        put_number(w->file, scale * stored, (i + 1) % n[FF_ZEMAX_RADIAL] ? '\t' : '\n');
    }
}

static ff_status write_table(const char *path, writer *w, int symmetry, ff_outputs *with, ff_error *err)
{
    ff_output out;
    const ff_table *t = w->t;
    const ff_status status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    w->file = out.file;
    write_header(w, symmetry);
    const int colours = t->n_channels == 3 ? XYZ : MONOCHROME;
    for (size_t c = 0; c < (colours == XYZ ? 3 : 1); c++) {
        fprintf(out.file, "\n%s\nDataBegin\n", part_name[colours][c]);
        for (size_t b = 0; b < t->axes.n[FF_ZEMAX_ROTATION] * t->axes.n[FF_ZEMAX_INCIDENCE]; b++) write_block(w, c, b);
        fputs("DataEnd\n", out.file);
    }
    return ff_output_commit(&out, err);
}

/* The integrals are taken with the nodes in degrees. */
static ff_status node_degrees(const ff_table *t, double **memory, const double *node[FF_ZEMAX_AXES], ff_error *err)
{
    size_t all = 0;
    for (int k = 0; k < FF_ZEMAX_AXES; k++) all += t->axes.n[k];
    double *p = *memory = malloc(all * sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu angles", all);
    for (int k = 0; k < FF_ZEMAX_AXES; k++) {
        node[k] = p;
        for (size_t i = 0; i < t->axes.n[k]; i++) *p++ = t->axes.node[k][i] * (t->radians_per_unit / degree);
    }
    return FF_OK;
}

static ff_status write_zemax(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    double *memory = NULL;
    const double *node[FF_ZEMAX_AXES];
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = node_degrees(t, &memory, node, err);
    if (status != FF_OK) return status;
    const kept *k = strcmp(t->format, "zemax") == 0 ? t->kept : NULL;
    const int same = k && k->n == t->n_channels * t->axes.n[FF_ZEMAX_ROTATION] * t->axes.n[FF_ZEMAX_INCIDENCE];
    const int symmetry = same ? k->symmetry : ff_zemax_symmetry_of(t);
    writer w = {.t = t, .kept = same ? k : NULL, .horizon = horizon_of(t)};
    status = ff_zemax_cells_make(t->axes.n, node, symmetry, &w.cells, err);
    if (status == FF_OK) status = write_table(path, &w, symmetry, with, err);
    free(w.cells.memory);
    free(memory);
    return status;
}

const ff_format ff_format_zemax = {
    .name = "zemax",
    .title = "BSDF data interchange format (Zemax OpticStudio), a grid about the specular direction",
    .extensions = ".zemax.bsdf",
    .source = "R. Rykowski, BSDF Data Interchange File Format Specification, Radiant Imaging and Zemax 2008",
    .probe = probe,
    .holds = FF_HOLDS_INVALID | FF_HOLDS_NEGATIVE | FF_HOLDS_DOUBLE,
    .read = read_zemax,
    .layout = ff_zemax_layout,
    .write = write_zemax,
};
