/* LightTools BSDF text, as the MiniDiff software of Light Tec exports it too.
 *
 *     # comment                              anywhere
 *     Model #: ...                           lines with other words are for people
 *     Source           Measured
 *     Symmetry         Asymmetric or PlaneSymmetrical
 *     SpectralContent  Monochrome or XYZ
 *     ScatterAzimuth   n                     then n angles, in degrees as all of them
 *     ScatterRadial    n                     then n angles
 *     DataBegin
 *     AOI              v                     angle of incidence; of the back side also as 180 - v
 *     POI              v                     azimuth of the plane of incidence
 *     Side             Front or Back
 *     Wavelength       v                     nm
 *     ScatterType      BRDF or BTDF
 *     TristimulusValue TrisX, TrisY or TrisZ, where SpectralContent is XYZ
 *     TIS              v                     total integrated scatter
 *     numbers                                a row per azimuth, a column per radial angle, in 1/sr without the cosine
 *     AOI ...                                and so on, in any order of incidences and wavelengths
 *     DataEnd                                may be missing
 *
 * The maker's documentation is not public. The layout is that which three public readers agree on: libbsdf (R. Kimura), a
 * converter for files of a Mini-Diff V2, and a reader of MiniDiff exports with tests on a measured file. Unlike in the interchange
 * format of format_zemax.c, ScatterRadial and ScatterAzimuth are theta_o and phi_o about the surface normal. That the light is at
 * the azimuth 90, so that the mirror direction is at 270, is in libbsdf alone; the data are asked whether they agree, and the table
 * says so when they do not. In which sense POI turns the plane of incidence is documented nowhere: with more than one POI a file is
 * refused.
 *
 * TIS is checked to be a number and dropped. A number of exactly 0 is taken to be unmeasured, as in the interchange format. What is
 * written (lighttools/) has one plane of incidence and all azimuths, in the order in which files have it, TIS the integral of
 * f cos(theta_o) over the cells of the grid. */
#define _GNU_SOURCE
#include "base/internal_order.h"
#include "data_formats/formats/lighttools/internal_lighttools.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double degree = 3.14159265358979323846 / 180;
enum { PLANE_SYMMETRICAL, ASYMMETRIC, ASYMMETRICAL };
enum { MONOCHROME, XYZ };
enum { FRONT, BACK };
enum { BRDF, BTDF };
static const char *const symmetry_name[] = {"PlaneSymmetrical", "Asymmetric", "Asymmetrical", NULL};
static const char *const content_name[] = {"Monochrome", "XYZ", NULL};
static const char *const side_name[] = {"Front", "Back", NULL};
static const char *const type_name[] = {"BRDF", "BTDF", NULL};
static const char *const tristimulus_name[] = {"TrisX", "TrisY", "TrisZ", NULL};
static const double phi_light = FF_LIGHTTOOLS_LIGHT, phi_mirror = 270;

/* One incidence of one wavelength. */
typedef struct block {
    double aoi, poi, wavelength; /* NaN = not stated */
    int side, type, tristimulus; /* -1 = not stated  */
    long line;                   /* of TIS           */
    size_t at;                   /* of its first value */
} block;

typedef struct lighttools {
    ff_tokens t;
    ff_error *err;
    const char *path;
    int symmetry, content; /* -1 = not seen */
    ff_values azimuth, radial, value;
    block *blocks; /* of reflection only */
    size_t n_blocks, capacity, n_transmission;
    int ended; /* DataEnd was there */
} lighttools;

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    static const char *const keywords[] = {"ScatterAzimuth", "ScatterRadial",    "AOI", "POI", "DataBegin", "Symmetry",
                                           "SampleRotation", "AngleOfIncidence", NULL};
    (void)file_size;
    const unsigned found = ff_keywords_in(head, n, keywords);
    if (!(found & 3u) || found & (3u << 6)) return 0; /* the last two are of the interchange format */
    return found & 12u ? 95 : (found & 3u) == 3u && found & (3u << 4) ? 70 : 30;
}

/* ---- the head of the file -------------------------------------------------------------------- */

static ff_status unexpected(lighttools *l, const char *word, const char *expected)
{
    char found[FF_QUOTE];
    if (!word)
        return ff_error_set(l->err, FF_ERR_READ, l->path, l->t.lines.line, -1, "found the end of the file, expected %s", expected);
    return ff_error_set(l->err, FF_ERR_FORMAT, l->path, l->t.lines.line, -1, "found %s, expected %s",
                        ff_quote(word, strlen(word), found), expected);
}

static ff_status read_keyword(lighttools *l, const char *word)
{
    if (strcasecmp(word, "Symmetry") == 0) return ff_choice_read(&l->t, "Symmetry", symmetry_name, &l->symmetry);
    if (strcasecmp(word, "SpectralContent") == 0) return ff_choice_read(&l->t, "SpectralContent", content_name, &l->content);
    if (strcasecmp(word, "ScatterAzimuth") == 0) return ff_angles_read(&l->t, "ScatterAzimuth", -360, 360, &l->azimuth);
    if (strcasecmp(word, "ScatterRadial") == 0) return ff_angles_read(&l->t, "ScatterRadial", 0, 180, &l->radial);
    if ((*word >= '0' && *word <= '9') || *word == '-' || *word == '+' || *word == '.')
        return unexpected(l, word, "a keyword such as ScatterRadial: are there more angles than their count says?");
    l->t.at = NULL;
    return FF_OK;
}

static ff_status missing(lighttools *l, const char *keyword)
{
    return ff_error_set(l->err, FF_ERR_FORMAT, l->path, l->t.lines.line, -1, "found DataBegin without %s before, expected it",
                        keyword);
}

static ff_status read_header(lighttools *l)
{
    char *word;
    for (;;) {
        ff_status status = ff_tokens_word(&l->t, &word);
        if (status != FF_OK) return status;
        if (!word) return unexpected(l, NULL, "DataBegin and values");
        if (strcasecmp(word, "DataBegin") == 0) break;
        status = read_keyword(l, word);
        if (status != FF_OK) return status;
    }
    if (l->symmetry < 0) return missing(l, "Symmetry");
    if (l->content < 0) return missing(l, "SpectralContent");
    if (!l->azimuth.n) return missing(l, "ScatterAzimuth");
    return l->radial.n ? FF_OK : missing(l, "ScatterRadial");
}

/* ---- blocks ---------------------------------------------------------------------------------- */

static ff_status read_number(lighttools *l, const char *keyword, double *v)
{
    if (!isnan(*v)) return ff_error_set(l->err, FF_ERR_FORMAT, l->path, l->t.lines.line, -1, "found %s twice before TIS", keyword);
    return ff_tokens_numbers(&l->t, v, 1, keyword);
}

static ff_status read_block_keyword(lighttools *l, const char *word, block *b)
{
    if (strcasecmp(word, "AOI") == 0) return read_number(l, "AOI", &b->aoi);
    if (strcasecmp(word, "POI") == 0) return read_number(l, "POI", &b->poi);
    if (strcasecmp(word, "Wavelength") == 0) return read_number(l, "Wavelength", &b->wavelength);
    if (strcasecmp(word, "Side") == 0) return ff_choice_read(&l->t, "Side", side_name, &b->side);
    if (strcasecmp(word, "ScatterType") == 0) return ff_choice_read(&l->t, "ScatterType", type_name, &b->type);
    if (strcasecmp(word, "TristimulusValue") == 0)
        return ff_choice_read(&l->t, "TristimulusValue", tristimulus_name, &b->tristimulus);
    return unexpected(l, word, "AOI, POI, Side, Wavelength, ScatterType, TristimulusValue, TIS or DataEnd");
}

static ff_status bad_block(lighttools *l, const block *b, ff_status code, const char *text)
{
    return ff_error_set(l->err, code, l->path, b->line, -1, "block of AOI %g, wavelength %g: %s", b->aoi, b->wavelength, text);
}

/* What is not stated gets its usual value; the angle of incidence becomes that from the normal of its side. */
static ff_status settle_block(lighttools *l, block *b)
{
    if (isnan(b->aoi)) return bad_block(l, b, FF_ERR_FORMAT, "found no AOI, expected it before TIS");
    if (b->type < 0) return bad_block(l, b, FF_ERR_FORMAT, "found no ScatterType, expected it before TIS");
    if (l->content == XYZ && b->tristimulus < 0)
        return bad_block(l, b, FF_ERR_FORMAT, "found no TristimulusValue, expected it since SpectralContent is XYZ");
    if (b->side < 0) b->side = FRONT;
    if (isnan(b->poi)) b->poi = 0;
    if (b->side == BACK && b->aoi > 90) b->aoi = 180 - b->aoi;
    if (!(b->aoi >= 0 && b->aoi <= 90)) return bad_block(l, b, FF_ERR_DATA, "found this AOI, expected one from 0 to 90 degrees");
    if (!isnan(b->wavelength) && !(b->wavelength > 0))
        return bad_block(l, b, FF_ERR_DATA, "found this wavelength, expected one > 0");
    return FF_OK;
}

static ff_status add_block(lighttools *l, const block *b)
{
    if (l->n_blocks == l->capacity) {
        const size_t capacity = 2 * l->capacity + 16;
        block *larger = realloc(l->blocks, capacity * sizeof *larger);
        if (!larger) return ff_error_set(l->err, FF_ERR_MEMORY, l->path, b->line, -1, "no memory for %zu blocks", capacity);
        l->blocks = larger;
        l->capacity = capacity;
    }
    l->blocks[l->n_blocks++] = *b;
    return FF_OK;
}

/* After the word TIS. Values of transmission are read and dropped. */
static ff_status read_values(lighttools *l, block *b)
{
    double tis;
    char what[64];
    b->line = l->t.lines.line;
    b->at = l->value.n;
    snprintf(what, sizeof what, "a row of %zu values", l->radial.n);
    ff_status status = ff_tokens_numbers(&l->t, &tis, 1, "TIS");
    if (status == FF_OK) status = settle_block(l, b);
    for (size_t a = 0; a < l->azimuth.n && status == FF_OK; a++) status = ff_values_read(&l->t, l->radial.n, what, &l->value);
    if (status != FF_OK) return status;
    if (b->type == BRDF) return add_block(l, b);
    l->value.n = b->at;
    l->n_transmission++;
    return FF_OK;
}

static ff_status read_blocks(lighttools *l)
{
    const block none = {NAN, NAN, NAN, -1, -1, -1, 0, 0};
    block b = none;
    for (int begun = 0;;) {
        char *word;
        ff_status status = ff_tokens_word(&l->t, &word);
        if (status != FF_OK) return status;
        if (!begun && (!word || (l->ended = strcasecmp(word, "DataEnd") == 0))) break;
        if (!word) return unexpected(l, NULL, "TIS and the values of the block");
        if (strcasecmp(word, "TIS") == 0) {
            status = read_values(l, &b);
            b = none;
            begun = 0;
        } else {
            status = read_block_keyword(l, word, &b);
            begun = 1;
        }
        if (status != FF_OK) return status;
    }
    if (!l->ended) return FF_OK;
    char *word;
    const ff_status status = ff_tokens_word(&l->t, &word);
    return status == FF_OK && word ? unexpected(l, word, "the end of the file after DataEnd") : status;
}

/* ---- which blocks make the table ------------------------------------------------------------- */

static ff_status choose_side(lighttools *l, const char *part, int *side)
{
    size_t n[2] = {0, 0};
    for (size_t k = 0; k < l->n_blocks; k++) n[l->blocks[k].side]++;
    if (l->n_blocks == 0 && l->n_transmission)
        return ff_error_set(l->err, FF_ERR_UNSUPPORTED, l->path, 0, -1,
                            "found %zu blocks of transmission and none of reflection, expected ScatterType BRDF",
                            l->n_transmission);
    if (l->n_blocks == 0) return unexpected(l, NULL, "at least one block of values after DataBegin");
    *side = n[FRONT] ? FRONT : BACK;
    if (part && strcmp(part, "front") != 0 && strcmp(part, "back") != 0)
        return ff_error_set(l->err, FF_ERR_UNKNOWN, l->path, 0, -1, "found the part '%s', expected front or back", part);
    if (part) *side = strcmp(part, "back") == 0;
    if (n[*side]) return FF_OK;
    return ff_error_set(l->err, FF_ERR_UNSUPPORTED, l->path, 0, -1, "found no reflection of the %s side, expected part %s",
                        *side == BACK ? "back" : "front", *side == BACK ? "front" : "back");
}

/* The blocks of one side as incidences times channels. */
typedef struct plan {
    int side;
    ff_values theta_i, wavelength; /* distinct ones; without any, one NaN. XYZ: wavelength.n is 3 */
    size_t *block;                 /* [incidence][channel], its index + 1                         */
} plan;

enum { MOST_DISTINCT = 4096 };
static ff_status add_distinct(lighttools *l, ff_values *v, double x, size_t *index)
{
    for (*index = 0; *index < v->n; (*index)++)
        if (v->value[*index] == x || (isnan(x) && isnan(v->value[*index]))) return FF_OK;
    if (v->n == MOST_DISTINCT)
        return ff_error_set(l->err, FF_ERR_FORMAT, l->path, 0, -1, "found more than %d incidences or wavelengths, expected fewer",
                            MOST_DISTINCT);
    if (v->n == v->capacity) {
        double *larger = realloc(v->value, (2 * v->capacity + 16) * sizeof *larger);
        if (!larger) return ff_error_set(l->err, FF_ERR_MEMORY, l->path, 0, -1, "no memory for %zu blocks", l->n_blocks);
        v->value = larger;
        v->capacity = 2 * v->capacity + 16;
    }
    v->value[v->n++] = x;
    return FF_OK;
}

static ff_status find_axes(lighttools *l, plan *p)
{
    const block *first = NULL;
    ff_status status = FF_OK;
    size_t index;
    for (size_t k = 0; k < l->n_blocks && status == FF_OK; k++) {
        const block *b = &l->blocks[k];
        if (b->side != p->side) continue;
        if (!first) first = b;
        if (b->poi != first->poi)
            return ff_error_set(l->err, FF_ERR_UNSUPPORTED, l->path, b->line, -1,
                                "found POI %g after POI %g, expected one plane of incidence: which way POI turns is not documented",
                                b->poi, first->poi);
        status = add_distinct(l, &p->theta_i, b->aoi, &index);
        if (status == FF_OK)
            status = add_distinct(l, &p->wavelength, l->content == XYZ ? (double)b->tristimulus : b->wavelength, &index);
    }
    if (status == FF_OK && p->theta_i.n > 1) qsort(p->theta_i.value, p->theta_i.n, sizeof(double), ff_ascending);
    if (status == FF_OK && l->content == XYZ && p->wavelength.n > 1)
        qsort(p->wavelength.value, p->wavelength.n, sizeof(double), ff_ascending);
    return status;
}

/* As many blocks as pairs of an incidence and a channel, and none twice: then each pair has its block. */
static ff_status place_blocks(lighttools *l, plan *p)
{
    const size_t cells = p->theta_i.n * p->wavelength.n;
    size_t n = 0;
    for (size_t k = 0; k < l->n_blocks; k++) n += l->blocks[k].side == p->side;
    if (n != cells)
        return ff_error_set(l->err, FF_ERR_FORMAT, l->path, l->t.lines.line, -1,
                            "found %zu blocks for %zu incidences and %zu channels, expected %zu: one for each pair", n,
                            p->theta_i.n, p->wavelength.n, cells);
    p->block = calloc(cells + 1, sizeof *p->block);
    if (!p->block) return ff_error_set(l->err, FF_ERR_MEMORY, l->path, 0, -1, "no memory for %zu blocks", cells);
    for (size_t k = 0; k < l->n_blocks; k++) {
        const block *b = &l->blocks[k];
        size_t i, c;
        if (b->side != p->side) continue;
        (void)add_distinct(l, &p->theta_i, b->aoi, &i); /* they are all there */
        (void)add_distinct(l, &p->wavelength, l->content == XYZ ? (double)b->tristimulus : b->wavelength, &c);
        size_t *at = &p->block[i * p->wavelength.n + c];
        if (*at) return bad_block(l, b, FF_ERR_FORMAT, "found it twice, expected it once");
        *at = k + 1;
    }
    return FF_OK;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void fill_values(const lighttools *l, const plan *p, ff_table *t)
{
    const size_t n_azimuth = l->azimuth.n, n_radial = l->radial.n;
    for (size_t i = 0; i < p->theta_i.n; i++)
        for (size_t c = 0; c < t->n_channels; c++) {
            const double *from = l->value.value + l->blocks[p->block[i * t->n_channels + c] - 1].at;
            double *to = t->value + c * t->n + i * n_radial * n_azimuth;
            for (size_t a = 0; a < n_azimuth; a++)
                for (size_t r = 0; r < n_radial; r++) to[r * n_azimuth + a] = from[a * n_radial + r];
        }
}

static void mark_unmeasured(ff_table *t)
{
    const double horizon = acos(FF_COS_MIN) / degree;
    size_t zeros = 0;
    for (size_t i = 0; i < t->n; i++) {
        int any = 0;
        for (size_t c = 0; c < t->n_channels; c++) any |= t->value[c * t->n + i] != 0;
        const int hidden = t->angle[0][i] >= horizon || t->angle[2][i] >= horizon;
        t->valid[i] = any && !hidden;
        zeros += !any && !hidden;
    }
    if (zeros) ff_table_note(t, "%zu values of 0 above the horizon are taken to be unmeasured", zeros);
}

/* Does the light of the most oblique incidence leave on the side of the mirror direction? */
static void check_mirror_side(const lighttools *l, ff_table *t)
{
    const size_t block = t->axes.n[2] * t->axes.n[3], first = t->n - block;
    const double theta_i = t->axes.node[0][t->axes.n[0] - 1];
    double along = 0, across = 0, all = 0;
    for (size_t i = first; i < t->n; i++) {
        const double theta = t->angle[2][i] * degree, phi = (t->angle[3][i] - phi_mirror) * degree;
        const double f = t->valid[i] ? t->value[i] * cos(theta) * sin(theta) * t->weight[i] : 0;
        along += f * cos(phi);
        across += f * sin(phi);
        all += fabs(f);
    }
    if (l->symmetry == PLANE_SYMMETRICAL) across = 0;
    if (theta_i < 10 || !(hypot(along, across) > 0.05 * all) || along >= fabs(across)) return;
    ff_table_note(t,
                  "at the incidence %g most of the light leaves around the azimuth %.0f, not around %g, the mirror direction that "
                  "the format is taken to have: the file may count its azimuths from elsewhere",
                  theta_i, fmod(atan2(across, along) / degree + phi_mirror + 360, 360), phi_mirror);
}

static void name_channels(const lighttools *l, const plan *p, ff_table *t)
{
    for (size_t c = 0; c < t->n_channels; c++) {
        const double w = p->wavelength.value[c];
        char *name = t->channels[c].name;
        if (l->content == XYZ)
            snprintf(name, FF_CHANNEL_NAME, "%c", "XYZ"[(int)w]);
        else if (isnan(w))
            snprintf(name, FF_CHANNEL_NAME, "f");
        else
            snprintf(name, FF_CHANNEL_NAME, "%.10gnm", w);
        t->channels[c].wavelength_nm = l->content == XYZ ? NAN : w;
    }
}

static ff_status describe(const lighttools *l, const plan *p, ff_table *t)
{
    size_t other = 0;
    snprintf(t->format, sizeof t->format, "lighttools");
    t->isotropic = 1;
    name_channels(l, p, t);
    fill_values(l, p, t);
    mark_unmeasured(t);
    for (size_t k = 0; k < l->n_blocks; k++) other += l->blocks[k].side != p->side;
    ff_table_note(t, "the light is taken to be at the azimuth %g, the mirror direction at %g", phi_light, phi_mirror);
    const double poi = l->blocks[p->block[0] - 1].poi;
    if (poi != 0) ff_table_note(t, "POI is %g in all blocks; the azimuths are taken to count from the same plane", poi);
    if (p->side == BACK) ff_table_note(t, "this is the reflection of the back side");
    if (other)
        ff_table_note(t, "%zu blocks of the other side are left out; part %s reads them", other,
                      p->side == BACK ? "front" : "back");
    if (l->n_transmission) ff_table_note(t, "%zu blocks of transmission are left out", l->n_transmission);
    if (!l->ended)
        ff_table_note(t, "there is no DataEnd: if the file was cut, its last blocks or the end of its last number are missing");
    if (!t->weight) return FF_OK;
    const ff_status status = ff_lighttools_weigh(t, l->symmetry == PLANE_SYMMETRICAL, l->err);
    if (status == FF_OK) check_mirror_side(l, t);
    return status;
}

static ff_status make_table(lighttools *l, const plan *p, ff_table *out)
{
    ff_table t;
    const size_t n[4] = {p->theta_i.n, 1, l->radial.n, l->azimuth.n};
    const double *const node[4] = {p->theta_i.value, &phi_light, l->radial.value, l->azimuth.value};
    ff_status status =
        ff_table_init_axes(FF_AXES_INCIDENT_EXIT, n, node, degree, p->wavelength.n, ff_lighttools_has_cells(n, node), &t, l->err);
    if (status != FF_OK) return status;
    status = describe(l, p, &t);
    if (status == FF_OK) status = ff_table_count(&t, l->path, l->err);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

static ff_status build(lighttools *l, const char *part, ff_table *out)
{
    plan p = {0};
    ff_status status = choose_side(l, part, &p.side);
    if (status == FF_OK) status = find_axes(l, &p);
    if (status == FF_OK) status = place_blocks(l, &p);
    if (status == FF_OK) status = make_table(l, &p, out);
    free(p.theta_i.value);
    free(p.wavelength.value);
    free(p.block);
    return status;
}

static ff_status read_lighttools(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    lighttools l = {.err = err, .path = path, .symmetry = -1, .content = -1};
    ff_status status = ff_tokens_open(path, &l.t, err);
    if (status != FF_OK) return status;
    status = read_header(&l);
    if (status == FF_OK) status = read_blocks(&l);
    if (status == FF_OK) status = build(&l, o->part, out);
    ff_tokens_close(&l.t);
    free(l.azimuth.value);
    free(l.radial.value);
    free(l.value.value);
    free(l.blocks);
    return status;
}

const ff_format ff_format_lighttools = {
    .name = "lighttools",
    .title = "LightTools BSDF text (Light Tec MiniDiff)",
    .extensions = ".lighttools.bsdf .bsdf",
    .source = "as read by libbsdf (github.com/KimuraRyo/libbsdf) and readers of MiniDiff exports",
    .probe = probe,
    .reads = FF_READS_PART,
    .holds = FF_HOLDS_INVALID | FF_HOLDS_NEGATIVE | FF_HOLDS_DOUBLE | FF_HOLDS_NM,
    .read = read_lighttools,
    .layout = ff_lighttools_layout,
    .write = ff_lighttools_write,
};
