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
#include "ff_output.h"
#include "ff_model.h"
#include "base/internal_number.h"
#include "data_formats/table/internal_scatter_grid.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;
enum { ROTATION, INCIDENCE, AZIMUTH, RADIAL, N_AXES };
enum { PLANE_SYMMETRICAL, ASYMMETRICAL, ASYMMETRICAL_4D };
enum { MONOCHROME, XYZ };
enum { BRDF, BTDF, BSDF };
static const char *const symmetry_name[] = {"PlaneSymmetrical", "Asymmetrical", "Asymmetrical4D", NULL};
static const char *const content_name[] = {"Monochrome", "XYZ", NULL};
static const char *const type_name[] = {"BRDF", "BTDF", "BSDF", NULL};
static const char *const axis_name[N_AXES] = {"SampleRotation", "AngleOfIncidence", "ScatterAzimuth", "ScatterRadial"};
static const double axis_least[N_AXES] = {-360, 0, -360, 0}, axis_most[N_AXES] = {360, 90, 360, 180};
static const char *const part_name[2][3] = {{"Monochrome"}, {"TristimulusX", "TristimulusY", "TristimulusZ"}};
static const char *const xyz[3] = {"X", "Y", "Z"};

/* What is needed to write the same file again. */
typedef struct kept {
    int symmetry;
    size_t n;     /* of tis: channels x rotations x incidences */
    double tis[]; /* in stored units, as the values           */
} kept;

/* ---- cells and their integrals --------------------------------------------------------------- */

typedef struct cells {
    double *of[N_AXES], *cosine[N_AXES], *sine[N_AXES]; /* per node; cosine and sine of its angle */
    double *memory;
} cells;

/* 1 when neighbouring azimuths are near enough for the space between them to be a cell. */
static int has_cells(const size_t n[N_AXES], const double *const node[N_AXES])
{
    return n[AZIMUTH] > 1 && ff_largest_gap(node[AZIMUTH], n[AZIMUTH]) <= 45 && n[RADIAL] > 1;
}

static ff_status make_cells(const size_t n[N_AXES], const double *const node[N_AXES], int symmetry, cells *c, ff_error *err)
{
    size_t all = 0;
    for (int k = 0; k < N_AXES; k++) all += n[k];
    double *p = malloc(3 * all * sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the cells of %zu angles", all);
    c->memory = p;
    for (int k = 0; k < N_AXES; k++) {
        c->of[k] = p, c->cosine[k] = p + n[k], c->sine[k] = p + 2 * n[k];
        p += 3 * n[k];
        for (size_t i = 0; i < n[k]; i++) {
            c->cosine[k][i] = cos(node[k][i] * degree);
            c->sine[k][i] = sin(node[k][i] * degree);
        }
    }
    ff_cells_circle(node[ROTATION], n[ROTATION], 0, c->of[ROTATION]);
    ff_cells_polar(node[INCIDENCE], n[INCIDENCE], 90, c->of[INCIDENCE]);
    ff_cells_circle(node[AZIMUTH], n[AZIMUTH], symmetry == PLANE_SYMMETRICAL, c->of[AZIMUTH]);
    ff_cells_polar(node[RADIAL], n[RADIAL], -1, c->of[RADIAL]);
    return FF_OK;
}

/* Integral of v cos(theta_o) over the directions above the horizon, of incidence i; v [azimuth][radial], valid likewise. */
static double block_integral(const cells *c, const size_t n[N_AXES], size_t i, const double *v, const unsigned char *valid)
{
    double sum = 0;
    for (size_t a = 0; a < n[AZIMUTH]; a++) {
        double row = 0;
        for (size_t r = 0; r < n[RADIAL]; r++, v++, valid++) {
            const double z =
                c->cosine[INCIDENCE][i] * c->cosine[RADIAL][r] + c->sine[INCIDENCE][i] * c->sine[RADIAL][r] * c->cosine[AZIMUTH][a];
            if (*valid && z > 0) row += *v * z * c->of[RADIAL][r];
        }
        sum += row * c->of[AZIMUTH][a];
    }
    return sum;
}

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
    ff_values axis[N_AXES], value, tis;
    size_t n[N_AXES], n_channels, n_blocks; /* blocks per channel */
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
    for (int k = 0; k < N_AXES; k++)
        if (strcasecmp(word, axis_name[k]) == 0)
            return ff_angles_read(&z->t, axis_name[k], axis_least[k], axis_most[k], &z->axis[k]);
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
    for (int k = 0; k < N_AXES; k++) {
        if (z->axis[k].n == 0) return missing(z, axis_name[k]);
        z->n[k] = z->axis[k].n;
    }
    if (z->type == BTDF)
        return ff_error_set(z->err, FF_ERR_UNSUPPORTED, z->path, z->t.lines.line, -1,
                            "found ScatterType BTDF, transmission; expected BRDF, since only reflection is read");
    z->n_channels = z->content == XYZ ? 3 : 1;
    z->n_blocks = z->n[ROTATION] * z->n[INCIDENCE];
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
    snprintf(what, sizeof what, "a row of %zu values", z->n[RADIAL]);
    for (size_t a = 0; a < z->n[AZIMUTH] && status == FF_OK; a++) status = ff_values_read(&z->t, z->n[RADIAL], what, &z->value);
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
static void compare_tis(const zemax *z, const cells *c, ff_table *t)
{
    const size_t per_block = z->n[AZIMUTH] * z->n[RADIAL];
    size_t far = 0;
    double least = INFINITY, most = 0;
    for (size_t b = 0; b < z->tis.n; b++) {
        const size_t first = b % z->n_blocks * per_block;
        const double integral = block_integral(c, z->n, b % z->n[INCIDENCE], t->value + b * per_block, t->valid + first);
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
    cells c;
    const double *const node[N_AXES] = {t->axes.node[0], t->axes.node[1], t->axes.node[2], t->axes.node[3]};
    ff_status status = make_cells(z->n, node, z->symmetry, &c, z->err);
    if (status != FF_OK) return status;
    snprintf(t->format, sizeof t->format, "zemax");
    t->isotropic = z->n[ROTATION] == 1;
    for (size_t k = 0; k < t->n_channels; k++)
        snprintf(t->channels[k].name, FF_CHANNEL_NAME, "%s", z->content == XYZ ? xyz[k] : "f");
    mark_unmeasured(t);
    if (z->type == BSDF) ff_table_note(t, "ScatterType is BSDF: reflection is assumed");
    if (t->weight) {
        const double *const of[N_AXES] = {c.of[0], c.of[1], c.of[2], c.of[3]};
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
    const double *const node[N_AXES] = {z->axis[0].value, z->axis[1].value, z->axis[2].value, z->axis[3].value};
    ff_status status = ff_table_new_axes(FF_AXES_SPECULAR, z->n, node, degree, z->n_channels, has_cells(z->n, node), &t, z->err);
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
        ff_table_free(&t);
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
    for (int k = 0; k < N_AXES; k++) free(z.axis[k].value);
    free(z.value.value);
    free(z.tis.value);
    return status;
}

/* What the angles of a table say. */
static int symmetry_of(const ff_table *t)
{
    const double *azimuth = t->axes.node[AZIMUTH], half = 180 * degree / t->radians_per_unit;
    if (t->axes.n[ROTATION] > 1) return ASYMMETRICAL_4D;
    return azimuth[0] >= 0 && azimuth[t->axes.n[AZIMUTH] - 1] <= half ? PLANE_SYMMETRICAL : ASYMMETRICAL;
}

/* ---- layout ---------------------------------------------------------------------------------- */

/* The grid of a file to be written: "rotation:0/90,incidence:20,azimuth:10,radial:0/2/5/10". A single number is a step. */
typedef struct plan {
    ff_values axis[N_AXES];
    int half; /* the data are isotropic: azimuths 0 to 180 */
} plan;

static const char *const plan_name[N_AXES] = {"rotation", "incidence", "azimuth", "radial"};
enum { PLAN_ANGLES = 4096, MOST_SAMPLES = 200000000 };
static const char plan_syntax[] = "parts like azimuth:10 (a step in degrees) or radial:0/2/5/10 (ascending angles), of rotation, "
                                  "incidence, azimuth and radial, separated by commas";

static ff_status add_angle(ff_values *v, double angle, ff_error *err)
{
    if (v->n == v->capacity) {
        double *larger = realloc(v->value, (2 * v->capacity + 16) * sizeof *larger);
        if (!larger) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of a grid");
        v->value = larger;
        v->capacity = 2 * v->capacity + 16;
    }
    v->value[v->n++] = angle;
    return FF_OK;
}

static ff_status add_steps(ff_values *v, double from, double to, double step, ff_error *err)
{
    ff_status status = FF_OK;
    for (int k = 0; from + k * step <= to + 1e-9 && status == FF_OK; k++) status = add_angle(v, from + k * step, err);
    return status;
}

static double axis_end(const plan *p, int k)
{
    static const double end[N_AXES] = {360, 85, 360, 175};
    return k == AZIMUTH && p->half ? 180 : end[k];
}

static ff_status bad_grid(const char *part, ff_error *err)
{
    char found[FF_QUOTE];
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "grid: found %s, expected %s", ff_quote(part, strcspn(part, ","), found),
                        plan_syntax);
}

static ff_status out_of_grid(int k, double v, double least, double most, ff_error *err)
{
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %s %g, expected ascending degrees from %g to %g", plan_name[k],
                        v, least, most);
}

/* The numbers of one part, up to ',' or the end; *p moves there. */
static ff_status parse_angles(plan *p, int k, const char *part, const char **at, ff_error *err)
{
    ff_values *v = &p->axis[k];
    const double most = k == INCIDENCE ? 89.9 : k == AZIMUTH && p->half ? 180 : axis_most[k];
    for (;;) {
        double angle;
        const char *end = ff_number_read(*at, &angle);
        if (!end || (*end != '/' && *end != ',' && *end != '\0')) return bad_grid(part, err);
        const int is_step = v->n == 0 && *end != '/';
        if (is_step && !(angle >= 0.01 && angle <= 360)) return out_of_grid(k, angle, 0.01, 360, err);
        if (is_step) {
            *at = end;
            return add_steps(v, 0, axis_end(p, k), angle, err);
        }
        if (!(angle >= 0 && angle <= most) || (v->n && angle <= v->value[v->n - 1]) || v->n == PLAN_ANGLES)
            return out_of_grid(k, angle, 0, most, err);
        const ff_status status = add_angle(v, angle, err);
        *at = *end == '/' ? end + 1 : end;
        if (status != FF_OK || *end != '/') return status;
    }
}

static ff_status parse_grid(const char *grid, plan *p, ff_error *err)
{
    for (const char *at = grid; at;) {
        int k = 0;
        const char *part = at;
        const size_t length = strcspn(at, ":,");
        while (k < N_AXES && (strlen(plan_name[k]) != length || strncmp(at, plan_name[k], length) != 0)) k++;
        if (k == N_AXES || at[length] != ':' || p->axis[k].n) return bad_grid(part, err);
        at += length + 1;
        const ff_status status = parse_angles(p, k, part, &at, err);
        if (status != FF_OK) return status;
        at = *at == ',' ? at + 1 : NULL;
    }
    return FF_OK;
}

enum { BINS = 36000, DISTINCT = 36 };
/* Distinct angles of the data, in degrees within [0, 90) or [0, 360), to a hundredth of a degree; the first met of each stands for
 * it. bin [BINS] ends with -1 in the empty ones. Returns their number. */
static size_t distinct(const ff_table *t, int rotation, double *bin)
{
    enum { BLOCK = 512 };
    double plane[4][BLOCK], *const planes[4] = {plane[0], plane[1], plane[2], plane[3]};
    size_t count = 0;
    for (int b = 0; b < BINS; b++) bin[b] = -1;
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_angles(t, degree, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            const double turn = plane[0][k] < 0 ? 180 : 0; /* a negative theta is on the other side */
            double v = rotation ? -90 - turn - plane[1][k] : fabs(plane[0][k]);
            if (rotation) v -= 360 * floor(v / 360);
            if (!t->valid[first + k] || !(v >= 0 && v < (rotation ? 360 : 89.995))) continue;
            const long b = lround(v * 100) % BINS;
            if (fabs(v - 0.01 * (double)b) < 1e-9 || (rotation && b == 0)) v = (double)b / 100;
            if (bin[b] < 0) bin[b] = v, count++;
        }
    }
    return count;
}

/* The data's own angles when they are few, else steps over their range. Rotation 0 comes again as 360: a reader that interpolates
 * needs it. */
static ff_status plan_from_data(const ff_table *t, int k, plan *p, ff_error *err)
{
    static const double step[2] = {10, 5};
    ff_status status = FF_OK;
    double *bin = malloc(BINS * sizeof *bin), last = 0;
    if (!bin) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of a grid");
    const size_t count = distinct(t, k == ROTATION, bin);
    for (int b = 0; b < BINS && status == FF_OK; b++) {
        if (bin[b] < 0) continue;
        last = bin[b];
        if (count <= DISTINCT) status = add_angle(&p->axis[k], last, err);
    }
    if (status == FF_OK && count > DISTINCT) status = add_steps(&p->axis[k], 0, k == ROTATION ? 360 : fmin(last, 85), step[k], err);
    if (status == FF_OK && count == 0) status = add_angle(&p->axis[k], 0, err);
    ff_values *v = &p->axis[k];
    if (status == FF_OK && k == ROTATION && v->n > 1 && v->value[0] == 0 && v->value[v->n - 1] < 360)
        status = add_angle(v, 360, err);
    free(bin);
    return status;
}

static ff_status plan_radial(plan *p, ff_error *err)
{
    static const double from[] = {0, 2, 5, 10, 20, 60}, step[] = {0.5, 1, 2.5, 5, 5, 10}, to[] = {1.5, 4, 7.5, 15, 55, 170};
    ff_status status = FF_OK;
    for (int k = 0; k < 6 && status == FF_OK; k++) status = add_steps(&p->axis[RADIAL], from[k], to[k], step[k], err);
    return status;
}

/* Data of this layout keep their own angles. */
static ff_status plan_like(const ff_table *t, plan *p, ff_error *err)
{
    ff_status status = FF_OK;
    for (int k = 0; k < N_AXES && status == FF_OK; k++) {
        const int given = p->axis[k].n > 0;
        for (size_t i = 0; i < t->axes.n[k] && !given && status == FF_OK; i++)
            status = add_angle(&p->axis[k], t->radians_per_unit / degree * t->axes.node[k][i], err);
    }
    return status;
}

static ff_status fill_plan(const ff_table *t, const char *grid, plan *p, ff_error *err)
{
    ff_status status = grid ? parse_grid(grid, p, err) : FF_OK;
    if (status == FF_OK && t->axes.kind == FF_AXES_SPECULAR) status = plan_like(t, p, err);
    if (status == FF_OK && !p->axis[ROTATION].n)
        status = t->isotropic ? add_angle(&p->axis[ROTATION], 0, err) : plan_from_data(t, ROTATION, p, err);
    if (status == FF_OK && !p->axis[INCIDENCE].n) status = plan_from_data(t, INCIDENCE, p, err);
    if (status == FF_OK && !p->axis[AZIMUTH].n) status = add_steps(&p->axis[AZIMUTH], 0, axis_end(p, AZIMUTH), 10, err);
    if (status == FF_OK && !p->axis[RADIAL].n) status = plan_radial(p, err);
    return status;
}

static ff_status check_channels(const ff_table *t, const char *path, ff_error *err)
{
    int same = t->n_channels == 3;
    for (size_t c = 0; c < 3 && same; c++) same = strcmp(t->channels[c].name, xyz[c]) == 0;
    if (t->n_channels == 1 || same) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "found %zu channels ('%s' first), but a file of this format has one, or the tristimulus values X, Y and Z; "
                        "write one file per channel, or csv",
                        t->n_channels, t->channels[0].name);
}

static ff_status make_layout(const ff_table *t, const plan *p, ff_table *out, ff_error *err)
{
    cells c;
    size_t n[N_AXES];
    const double *node[N_AXES];
    double samples = (double)t->n_channels;
    for (int k = 0; k < N_AXES; k++) n[k] = p->axis[k].n, node[k] = p->axis[k].value, samples *= (double)n[k];
    if (samples > MOST_SAMPLES)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "grid: found %.0f values, expected at most %d: take larger steps",
                            samples, MOST_SAMPLES);
    ff_status status = make_cells(n, node, p->half ? PLANE_SYMMETRICAL : ASYMMETRICAL, &c, err);
    if (status != FF_OK) return status;
    status = ff_table_new_axes(FF_AXES_SPECULAR, n, node, degree, t->n_channels, has_cells(n, node), out, err);
    if (status == FF_OK) {
        const double *const of[N_AXES] = {c.of[0], c.of[1], c.of[2], c.of[3]};
        if (out->weight) ff_table_product_weights(out, of);
        out->isotropic = n[ROTATION] == 1;
        ff_table_name_channels_like(out, t);
    }
    free(c.memory);
    return status;
}

static ff_status layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    plan p = {.half = t->isotropic};
    if (t->axes.kind == FF_AXES_SPECULAR) p.half &= symmetry_of(t) == PLANE_SYMMETRICAL;
    ff_status status = check_channels(t, NULL, err);
    if (status == FF_OK) status = fill_plan(t, grid, &p, err);
    if (status == FF_OK) status = make_layout(t, &p, out, err);
    for (int k = 0; k < N_AXES; k++) free(p.axis[k].value);
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
    return check_channels(t, path, err);
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
    cells cells;
    double horizon;
} writer;

static void write_header(const writer *w, int symmetry)
{
    const ff_table *t = w->t;
    const double factor = t->radians_per_unit / degree; /* exactly 1 for degrees */
    fprintf(w->file, "# BSDF data interchange format\nSource\tMeasured\nSymmetry\t%s\nSpectralContent\t%s\nScatterType\tBRDF\n",
            symmetry_name[symmetry], content_name[t->n_channels == 3 ? XYZ : MONOCHROME]);
    for (int k = 0; k < N_AXES; k++) {
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
    const size_t *n = t->axes.n, per_block = n[AZIMUTH] * n[RADIAL], first = block * per_block;
    const double scale = t->channels[c].scale, *v = t->value + c * t->n + first;
    const double tis = w->kept ? w->kept->tis[c * n[ROTATION] * n[INCIDENCE] + block]
                               : block_integral(&w->cells, n, block % n[INCIDENCE], v, t->valid + first);
    fputs("TIS\t", w->file);
    put_number(w->file, scale * tis, '\n');
    for (size_t i = 0; i < per_block; i++) {
        const double stored = t->valid[first + i] ? v[i] : stored_invalid(w, c, first + i);
        put_number(w->file, scale * stored, (i + 1) % n[RADIAL] ? '\t' : '\n');
    }
}

static ff_status write_table(const char *path, writer *w, int symmetry, ff_error *err)
{
    ff_output out;
    const ff_table *t = w->t;
    const ff_status status = ff_output_open(path, &out, err);
    if (status != FF_OK) return status;
    w->file = out.file;
    write_header(w, symmetry);
    for (size_t c = 0; c < t->n_channels; c++) {
        fprintf(out.file, "\n%s\nDataBegin\n", part_name[t->n_channels == 3 ? XYZ : MONOCHROME][c]);
        for (size_t b = 0; b < t->axes.n[ROTATION] * t->axes.n[INCIDENCE]; b++) write_block(w, c, b);
        fputs("DataEnd\n", out.file);
    }
    return ff_output_commit(&out, err);
}

/* The integrals are taken with the nodes in degrees. */
static ff_status node_degrees(const ff_table *t, double **memory, const double *node[N_AXES], ff_error *err)
{
    size_t all = 0;
    for (int k = 0; k < N_AXES; k++) all += t->axes.n[k];
    double *p = *memory = malloc(all * sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu angles", all);
    for (int k = 0; k < N_AXES; k++) {
        node[k] = p;
        for (size_t i = 0; i < t->axes.n[k]; i++) *p++ = t->axes.node[k][i] * (t->radians_per_unit / degree);
    }
    return FF_OK;
}

static ff_status write_zemax(const char *path, const ff_table *t, ff_error *err)
{
    double *memory = NULL;
    const double *node[N_AXES];
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = node_degrees(t, &memory, node, err);
    if (status != FF_OK) return status;
    const kept *k = strcmp(t->format, "zemax") == 0 ? t->kept : NULL;
    const int same = k && k->n == t->n_channels * t->axes.n[ROTATION] * t->axes.n[INCIDENCE];
    const int symmetry = same ? k->symmetry : symmetry_of(t);
    writer w = {.t = t, .kept = same ? k : NULL, .horizon = horizon_of(t)};
    status = make_cells(t->axes.n, node, symmetry, &w.cells, err);
    if (status == FF_OK) status = write_table(path, &w, symmetry, err);
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
    .layout = layout,
    .write = write_zemax,
};
