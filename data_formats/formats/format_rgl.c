/* RGL: the material database of EPFL's Realistic Graphics Lab (Dupuy and Jakob 2018), as of rgl.epfl.ch/materials.
 *
 * A tensor file (internal_tensor_file.h) with the fields, float32 unless said otherwise,
 *
 *     phi_i [P], theta_i [T]            nodes of incidence, radians; isotropic materials have one phi_i (or two)
 *     ndf [.][.], sigma [.][.]          distribution of normals and its projected area, over u (rgl.c), azimuth first
 *     vndf [P][T][.][.]                 density of visible normals over u, of any scale
 *     rgb [P][T][3][H][W]               colours over s; or, in spectral files,
 *     spectra [P][T][C][H][W]           with wavelengths [C] in nm
 *     luminance [P][T][H][W]            of the colours, for sampling; 0 where nothing was measured
 *     jacobian uint8 [1]                1: colours are to be multiplied by ndf / (4 sigma)
 *     description uint8 [.]             text
 *
 * and others, which are kept. The file holds a function (rgl.c) whose value is f cos(theta_o); the table has f.
 *
 * Samples: for every node of incidence those of the colours, at s = (column / (W-1), row / (H-1)): the file's numbers themselves,
 * not interpolated. The vndf warp of the node takes s to u, u is the half vector m, and wo is the mirror image of wi about m. The
 * corners of the grid are those of the square, so a whole column looks in the mirror direction and the first and last row at the
 * same azimuth; the measurements there differ, as they were made. Weights are solid angles as far as the colours of a sample reach,
 * each direction counting by the density of normals relative to that of the sample (rgl.c): with them the sum of f cos(theta_o)
 * over an incidence is the reflectance of the function. A cell of the lobe's foot may be a thousand times wider than one of its
 * peak, and the value at its corner is no mean of it.
 *
 * Not valid: wo below the horizon, incidence at 90 degrees, no density of normals, and colours that are 0 in all channels with a
 * luminance of 0. The field `valid` of some files says no more than the first of these, with either meaning of its bits.
 * Negative colours lie outside the gamut of RGB; they are not clipped as the loader does.
 *
 * Frame: wi is the direction towards the light, phi counter-clockwise from x: ours.
 *
 * Writing turns f back into colours. What was read gives the same bytes; for other tables rgl_layout.c makes the fields. Colours
 * of samples below the horizon are then 0, which is where those above it go: they are those of f cos(theta_o). */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "data_formats/formats/rgl/internal_rgl.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

enum { SAMPLES_MOST = 1 << 25 };

/* Of a colour that is not valid to that of the sample that takes its share; more would let noise at the horizon weigh a sample. */
static const double largest_ratio = 4;

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    if (n < FF_TENSOR_HEADER || memcmp(head, ff_tensor_magic, FF_TENSOR_MAGIC) != 0) return 0;
    return memmem(head, n, "theta_i", 7) && memmem(head, n, "vndf", 4) ? 100 : 50; /* else the reader says what is missing */
}

/* ---- the measured grid ----------------------------------------------------------------------- */

static void kept_free(void *kept)
{
    ff_rgl_free(kept);
}

/* What a table keeps never changes: copies of the table share it. */
static void *kept_share(void *kept)
{
    ff_rgl *r = kept;
    r->owners++;
    return r;
}

static double kept_incidence(const void *kept, size_t sample)
{
    const ff_rgl *r = kept;
    const size_t slice = sample / (r->width * r->height);
    return ff_rgl_incidence_weight(r, slice / r->n_theta, slice % r->n_theta);
}

/* The function is colour ndf / (4 sigma), the colour bilinear: a colour is the mean of those around it. */
static int kept_around(const void *kept, size_t sample, size_t n, const double (*by)[2], double (*wo)[3], double *weight)
{
    const ff_rgl *r = kept;
    const size_t size = r->width * r->height, slice = sample / size, at = sample % size, row_of_at = at / r->width;
    const double x = (double)(at % r->width), y = (double)row_of_at, width = (double)(r->width - 1),
                 height = (double)(r->height - 1);
    double *row = malloc(2 * r->vndf.width * sizeof *row), own, w[3];
    if (!row) return 0;
    ff_rgl_place(r, slice / r->n_theta, slice % r->n_theta, (const double[]){x / width, y / height}, row, w, &own);
    for (size_t k = 0; k < n; k++) {
        const double s[2] = {(x + by[k][0]) / width, (y + by[k][1]) / height};
        const int inside = s[0] >= 0 && s[0] <= 1 && s[1] >= 0 && s[1] <= 1;
        double factor = 0;
        if (inside) ff_rgl_place(r, slice / r->n_theta, slice % r->n_theta, s, row, wo[k], &factor);
        weight[k] = factor > 0 ? own / factor : 0;
    }
    free(row);
    return 1;
}

/* Planes and scratch for one node of incidence. */
typedef struct slice_room {
    double *memory, *row, *mass;
    ff_rgl_slice slice;
} slice_room;

static int slice_room_new(const ff_rgl *r, slice_room *room)
{
    const size_t n = r->width * r->height;
    double *m = room->memory = malloc((5 * n + 2 * r->vndf.width) * sizeof(double));
    if (!m) return 0;
    room->slice = (ff_rgl_slice){m, m + n, m + 2 * n, m + 3 * n};
    room->mass = m + 4 * n, room->row = m + 5 * n;
    return 1;
}

/* Colours of channel c (luminance: c = n_channels) of node `slice` in the file. */
static unsigned char *colours_of(const ff_rgl *r, size_t slice, size_t c)
{
    const size_t size = 4 * r->width * r->height;
    if (c == r->n_channels) return ff_tensor_data(&r->file, r->luminance) + size * slice;
    return ff_tensor_data(&r->file, r->colour) + size * (slice * r->n_channels + c);
}

static int all_zero(const ff_rgl *r, size_t slice, size_t i)
{
    for (size_t c = r->n_channels + 1; c-- > 0;)
        if (ff_uint32_of(colours_of(r, slice, c) + 4 * i) << 1) return 0; /* -0 is 0 */
    return 1;
}

/* What became of the samples, for the notes. */
typedef struct counts {
    size_t grazing, below, unmeasured, undefined;
} counts;

static void count_invalid(const ff_rgl *r, size_t t, double theta_o, int measured, counts *n)
{
    if (cos(r->theta[t]) <= 1e-6)
        n->grazing++;
    else if (cos(theta_o) <= 1e-6)
        n->below++;
    else if (!measured)
        n->unmeasured++;
    else
        n->undefined++;
}

/* Directions of node (p, t) into the table's samples. */
static void place_slice(const ff_rgl *r, size_t p, size_t t, const ff_rgl_slice *s, ff_table *out)
{
    const size_t n = r->width * r->height, at = (p * r->n_theta + t) * n;
    for (size_t i = 0; i < n; i++) {
        out->angle[0][at + i] = r->theta[t];
        out->angle[1][at + i] = r->phi[p];
    }
    memcpy(out->angle[2] + at, s->theta_o, n * sizeof(double));
    memcpy(out->angle[3] + at, s->phi_o, n * sizeof(double));
}

/* Sum of the colours of sample i. */
static double colour_sum(const ff_rgl *r, size_t slice, size_t i)
{
    double sum = 0;
    for (size_t c = 0; c < r->n_channels; c++) sum += (double)ff_float_of(colours_of(r, slice, c) + 4 * i);
    return sum;
}

/* The nearest sample of the row that is valid, the one before first; i when there is none. */
static size_t valid_beside(const ff_rgl *r, const unsigned char *valid, size_t i)
{
    const size_t first = i - i % r->width, end = first + r->width;
    for (size_t k = i; k-- > first;)
        if (valid[k]) return k;
    for (size_t k = i + 1; k < end; k++)
        if (valid[k]) return k;
    return i;
}

/* Weights of node (p, t), so that their sum with f cos(theta_o) is the reflectance of the function. A colour that is not valid
 * where it stands, most of all below the horizon, still takes part in the function on this side: its share of the reflectance is
 * added to that of the nearest sample of the row, where their colours allow it. */
static void weigh_slice(const ff_rgl *r, size_t p, size_t t, const ff_rgl_slice *s, const double *mass, ff_table *out)
{
    const size_t n = r->width * r->height, slice = p * r->n_theta + t, at = slice * n;
    const double incidence = ff_rgl_incidence_weight(r, p, t);
    const unsigned char *valid = out->valid + at;
    double *w = out->weight + at;
    for (size_t i = 0; i < n; i++) w[i] = valid[i] && s->factor[i] > 0 ? incidence * mass[i] / s->density[i] : 0;
    for (size_t i = 0; i < n; i++) {
        const size_t to = valid[i] || !(mass[i] > 0) ? i : valid_beside(r, valid, i);
        if (to == i) continue;
        const double ratio = colour_sum(r, slice, i) / colour_sum(r, slice, to);
        if (ratio > 0 && isfinite(ratio)) w[to] += incidence * fmin(ratio, largest_ratio) * mass[i] / s->density[to];
    }
}

static void fill_slice(const ff_rgl *r, size_t p, size_t t, const ff_rgl_slice *s, ff_table *out, counts *invalid)
{
    const size_t n = r->width * r->height, slice = p * r->n_theta + t, at = slice * n;
    for (size_t i = 0; i < n; i++) {
        const int measured = s->factor[i] > 0 && !all_zero(r, slice, i);
        out->valid[at + i] = (unsigned char)measured;
        if (!measured) count_invalid(r, t, s->theta_o[i], s->factor[i] <= 0, invalid);
    }
    for (size_t c = 0; c < r->n_channels; c++) {
        const unsigned char *colour = colours_of(r, slice, c);
        double *value = out->value + c * out->n + at;
        for (size_t i = 0; i < n; i++) value[i] = out->valid[at + i] ? (double)ff_float_of(colour + 4 * i) * s->factor[i] : 0;
    }
}

/* The table of the measured grid, with values or without. */
static ff_status sample_file(const ff_rgl *r, int with_values, ff_table *out, counts *invalid, ff_error *err)
{
    slice_room room = {NULL};
    ff_rgl_weights *weights = NULL;
    ff_table t;
    const size_t n = r->n_phi * r->n_theta * r->width * r->height; /* the luminance has as many numbers */
    ff_status status = ff_table_init(n, r->n_channels, NULL, 0, 1, &t, err);
    if (status != FF_OK) return status;
    if (!slice_room_new(r, &room) || !(weights = ff_rgl_weights_new(r))) {
        free(room.memory);
        ff_table_clear(&t);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the samples of an RGL file");
    }
    for (size_t p = 0; p < r->n_phi; p++)
        for (size_t k = 0; k < r->n_theta; k++) {
            ff_rgl_sample_slice(r, p, k, room.row, &room.slice);
            place_slice(r, p, k, &room.slice, &t);
            if (with_values) fill_slice(r, p, k, &room.slice, &t, invalid);
            ff_rgl_weigh(r, weights, p, k, room.mass);
            weigh_slice(r, p, k, &room.slice, room.mass, &t);
        }
    ff_rgl_weights_free(weights);
    free(room.memory);
    memcpy(t.channels, r->channels, r->n_channels * sizeof *t.channels);
    t.isotropic = r->isotropic;
    *out = t;
    return FF_OK;
}

static void note_grid(const ff_rgl *r, const counts *n, ff_table *t)
{
    ff_table_note(
        t,
        "samples are the file's own: %zu x %zu incidences (phi_i, theta_i), each with %zu x %zu half vectors at the corners "
        "of its grid",
        r->n_phi, r->n_theta, r->height, r->width);
    if (n->below) ff_table_note(t, "%zu samples look below the horizon and are not valid", n->below);
    if (n->grazing) ff_table_note(t, "%zu samples of light at 90 degrees are extrapolations and not valid", n->grazing);
    if (n->unmeasured) ff_table_note(t, "%zu samples have no colour and no luminance and are not valid", n->unmeasured);
    if (n->undefined) ff_table_note(t, "%zu samples have no density of normals and are not valid", n->undefined);
}

/* ---- reading --------------------------------------------------------------------------------- */

static void note_file(const ff_rgl *r, ff_table *t)
{
    char text[FF_QUOTE];
    if (r->description[0]) ff_table_note(t, "description: %s", ff_quote(r->description, strlen(r->description), text));
    if (t->n_negative)
        ff_table_note(t, "%zu samples have a negative channel%s; kept", t->n_negative,
                      r->spectral ? "" : ": colours outside the gamut of RGB");
    if (!r->jacobian) ff_table_note(t, "the file says that its colours are not relative to a distribution of normals");
    if (r->reduction > 1)
        ff_table_note(
            t, "azimuths of incidence cover one of %d parts of the circle that are alike by symmetry; the others are not listed",
            r->reduction);
    if (r->spectral && ff_tensor_find(&r->file, "rgb")) ff_table_note(t, "the spectra were read; the file also has RGB colours");
}

static ff_status read_own_grid(ff_rgl *r, ff_table *out, ff_error *err)
{
    ff_table t;
    counts invalid = {0};
    const ff_status status = sample_file(r, 1, &t, &invalid, err);
    if (status != FF_OK) return status;
    note_grid(r, &invalid, &t);
    t.kept = r;
    t.kept_free = kept_free;
    t.kept_share = kept_share;
    t.kept_incidence = kept_incidence;
    t.kept_around = kept_around;
    *out = t;
    return FF_OK;
}

/* A regular grid: nodes at their own places, and the borders between them. */
typedef struct regular {
    size_t n[4]; /* theta_i, phi_i, theta_o, phi_o */
    double first[4], step[4];
} regular;

static ff_status no_grid(const char *path, const char *text, ff_error *err)
{
    char quoted[FF_QUOTE];
    return ff_error_set(
        err, FF_ERR_SYNTAX, path, 0, -1,
        "found the grid %s, expected 'merl', 'goniometer:STEP' in degrees, 'TIxTOxPHI' or 'TIxPHIxTOxPHI' (numbers of "
        "theta_i, theta_o and azimuths)",
        ff_quote(text, strlen(text), quoted));
}

static ff_status grid_range(const char *path, const char *found, const char *expected, ff_error *err)
{
    return ff_error_set(err, FF_ERR_RANGE, path, 0, -1, "found the grid '%s', expected %s", found, expected);
}

/* Up to 4 whole numbers with x between them; their count, or 0. */
static size_t read_counts(const char *text, size_t n[4])
{
    size_t count = 0;
    for (;;) {
        size_t v = 0;
        if (*text < '0' || *text > '9' || count == 4) return 0;
        for (; *text >= '0' && *text <= '9'; text++) v = v < 1000000 ? 10 * v + (size_t)(*text - '0') : v;
        n[count++] = v;
        if (*text == '\0') return count;
        if (*text++ != 'x') return 0;
    }
}

/* Nodes 0, STEP, .. below 90 degrees and all around. */
static ff_status goniometer(const char *path, const char *text, int isotropic, regular *g, ff_error *err)
{
    double step;
    const char *end = ff_number_read(text, &step);
    if (!end || *end) return no_grid(path, text, err);
    const double around = 360 / step;
    if (!(step >= 0.25 && step <= 45) || fabs(around - round(around)) > 1e-9 * around)
        return grid_range(path, text, "a step of 0.25 to 45 degrees that divides 360", err);
    const size_t polar = (size_t)ceil(90 / step - 1e-9), azimuths = (size_t)round(around);
    *g = (regular){.n = {polar, isotropic ? 1 : azimuths, polar, azimuths}, .step = {step, step, step, step}};
    return FF_OK;
}

static ff_status parse_grid(const char *path, const char *text, int isotropic, regular *g, ff_error *err)
{
    static const char word[] = "goniometer:";
    size_t n[4];
    ff_status status = FF_OK;
    if (strncmp(text, word, sizeof word - 1) == 0)
        status = goniometer(path, text + sizeof word - 1, isotropic, g, err);
    else {
        const size_t count = read_counts(text, n);
        if (count < 3) return no_grid(path, text, err);
        if (count == 3) n[3] = n[2], n[2] = n[1], n[1] = isotropic ? 1 : n[3];
        *g = (regular){.n = {n[0], n[1], n[2], n[3]}};
        for (int k = 0; k < 4; k++) {
            g->step[k] = (k % 2 ? 360.0 : 90.0) / (double)n[k];
            g->first[k] = k % 2 ? 0 : 0.5 * g->step[k];
        }
        if (n[0] == 0 || n[1] == 0 || n[2] == 0 || n[3] == 0) return grid_range(path, text, "at least one of each angle", err);
    }
    double samples = 1;
    for (int k = 0; k < 4; k++) samples *= (double)g->n[k];
    if (status == FF_OK && samples > SAMPLES_MOST) return grid_range(path, text, "at most 33554432 samples", err);
    return status;
}

/* Solid angle of the ring around node i of the polar angle, up to half way to its neighbours and to the horizon; per node of
 * azimuth. */
static double ring(const regular *g, int k, size_t i)
{
    const double at = g->first[k] + (double)i * g->step[k], lo = fmax(at - 0.5 * g->step[k], 0),
                 hi = i + 1 < g->n[k] ? at + 0.5 * g->step[k] : 90;
    return 2 * pi / (double)g->n[k + 1] * (cos(lo * pi / 180) - cos(hi * pi / 180));
}

static ff_status new_regular(const regular *g, size_t n_channels, ff_table *out, ff_error *err)
{
    size_t total = 0, i = 0;
    for (int k = 0; k < 4; k++) total += g->n[k];
    double *memory = malloc(total * sizeof(double)), *node[4];
    if (!memory) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a grid");
    for (int k = 0; k < 4; k++) {
        node[k] = k ? node[k - 1] + g->n[k - 1] : memory;
        for (size_t a = 0; a < g->n[k]; a++) node[k][a] = g->first[k] + (double)a * g->step[k];
    }
    const ff_status status =
        ff_table_init_axes(FF_AXES_INCIDENT_EXIT, g->n, (const double *const *)node, pi / 180, n_channels, 1, out, err);
    free(memory);
    if (status != FF_OK) return status;
    for (size_t a = 0; a < g->n[0]; a++)
        for (size_t b = 0; b < g->n[1]; b++)
            for (size_t c = 0; c < g->n[2]; c++)
                for (size_t d = 0; d < g->n[3]; d++) out->weight[i++] = ring(g, 0, a) * ring(g, 2, c);
    return FF_OK;
}

static void evaluate_all(const ff_rgl *r, ff_table *t)
{
    enum { BLOCK = 256 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    const double *const w[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        ff_rgl_eval(r, w, n, t->value + first, t->n, t->valid + first);
    }
}

/* The function at directions of one's choice. The file is not needed any more afterwards. */
static ff_status read_grid(const char *path, const char *grid, const ff_rgl *r, ff_table *out, ff_error *err)
{
    ff_table t;
    regular g;
    ff_status status;
    if (strcmp(grid, ff_grid_merl.name) == 0) {
        if (!r->isotropic)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                                "found an anisotropic material, which the grid 'merl' cannot hold; expected 'goniometer:STEP' or "
                                "'TIxPHIxTOxPHI'");
        status = ff_table_init(ff_grid_merl.n, r->n_channels, &ff_grid_merl, 0, 0, &t, err);
    } else {
        status = parse_grid(path, grid, r->isotropic, &g, err);
        if (status == FF_OK) status = new_regular(&g, r->n_channels, &t, err);
    }
    if (status != FF_OK) return status;
    memcpy(t.channels, r->channels, r->n_channels * sizeof *t.channels);
    t.isotropic = r->isotropic;
    evaluate_all(r, &t);
    ff_table_note(&t, "samples are the file's function on the grid '%s', interpolated", grid);
    *out = t;
    return FF_OK;
}

static ff_status read_rgl(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_tensor_file file;
    ff_rgl *r = NULL;
    ff_table t;
    ff_status status = ff_tensor_file_read(path, &file, err);
    if (status == FF_OK) status = ff_rgl_of_file(&file, path, o->grid != NULL, &r, err);
    if (status != FF_OK) return status;
    status = o->grid ? read_grid(path, o->grid, r, &t, err) : read_own_grid(r, &t, err);
    if (status != FF_OK) {
        ff_rgl_free(r);
        return status;
    }
    snprintf(t.format, sizeof t.format, "rgl");
    t.quantity = FF_BRDF_COS;
    status = ff_table_count(&t, path, err);
    if (status == FF_OK) note_file(r, &t);
    if (!t.kept) ff_rgl_free(r);
    if (status != FF_OK)
        ff_table_clear(&t);
    else
        *out = t;
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

/* An empty table on the directions of a file that is made for it; it keeps the file. */
static ff_status layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    ff_tensor_file file;
    ff_rgl *r = NULL;
    ff_status status = ff_rgl_make(t, grid, &file, err);
    if (status == FF_OK) status = ff_rgl_of_file(&file, NULL, 0, &r, err);
    if (status == FF_OK) status = sample_file(r, 0, out, NULL, err);
    if (status != FF_OK) {
        ff_rgl_free(r);
        return status;
    }
    out->kept = r;
    out->kept_free = kept_free;
    out->kept_share = kept_share;
    out->kept_incidence = kept_incidence;
    out->kept_around = kept_around;
    return FF_OK;
}

static ff_status not_our_layout(const char *path, const char *found, ff_error *err)
{
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "found %s; an RGL file needs the directions of its own layout: resample to it, or write csv", found);
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    const ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK) return status;
    if (!t->kept || t->kept_free != kept_free)
        return not_our_layout(path, t->grid ? "a table on a grid" : "scattered directions", err);
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "an RGL file has no room for the standard deviations of this table; write csv");
    const ff_rgl *r = t->kept;
    if (t->n != r->n_phi * r->n_theta * r->width * r->height || t->n_channels != r->n_channels || t->grid ||
        t->radians_per_unit != 1)
        return not_our_layout(path, "another number of samples or channels than the table was read or laid out with", err);
    return FF_OK;
}

static int same_directions(const ff_rgl *r, const ff_table *t, size_t p, size_t k, const ff_rgl_slice *s)
{
    const size_t n = r->width * r->height, at = (p * r->n_theta + k) * n;
    for (size_t i = 0; i < n; i++)
        if (t->angle[0][at + i] != r->theta[k] || t->angle[1][at + i] != r->phi[p]) return 0;
    return memcmp(t->angle[2] + at, s->theta_o, n * sizeof(double)) == 0 &&
           memcmp(t->angle[3] + at, s->phi_o, n * sizeof(double)) == 0;
}

/* What the colours weigh in the luminance: that of linear RGB with the primaries of sRGB; all the same in a spectrum. */
static double luminance_weight(const ff_rgl *r, size_t c)
{
    static const double rgb[3] = {0.212671, 0.715160, 0.072169};
    return r->spectral ? 1 / (double)r->n_channels : rgb[c];
}

/* Black that was measured has a luminance that no one notices, to tell it from what was not. */
static void write_luminance(const ff_rgl *r, size_t slice, size_t i, int measured)
{
    double sum = 0;
    for (size_t c = 0; c < r->n_channels; c++) sum += luminance_weight(r, c) * (double)ff_float_of(colours_of(r, slice, c) + 4 * i);
    ff_bytes_of_float(measured ? (float)fmax(sum, 1e-20) : 0.0f, colours_of(r, slice, r->n_channels) + 4 * i);
}

/* Puts sample i into the file, unless it is there. FF_ERR_DATA when it does not fit into a float. */
static ff_status put_sample(const ff_rgl *r, const ff_table *t, size_t slice, size_t i, double factor, const char *path,
                            ff_error *err)
{
    const size_t at = slice * r->width * r->height + i;
    int changed = !t->valid[at] && !all_zero(r, slice, i);
    for (size_t c = 0; c < r->n_channels; c++) {
        const double f = t->valid[at] ? t->channels[c].scale * t->value[c * t->n + at] : 0, colour = f / factor;
        unsigned char *to = colours_of(r, slice, c) + 4 * i, bytes[4];
        if (!(fabs(colour) <= 3e38))
            return ff_error_set(err, FF_ERR_DATA, path, 0, -1,
                                "sample %zu: found channel %s = %g, which an RGL file would hold as %g, too large for 32 bits", at,
                                t->channels[c].name, f, colour);
        if (colour == 0 && ff_float_of(to) == 0) continue; /* a zero keeps its sign */
        ff_bytes_of_float((float)colour, bytes);
        changed |= memcmp(bytes, to, 4) != 0;
        memcpy(to, bytes, 4);
    }
    if (changed || (t->valid[at] && all_zero(r, slice, i))) write_luminance(r, slice, i, t->valid[at]);
    return FF_OK;
}

static ff_status put_table(const ff_rgl *r, const ff_table *t, const slice_room *room, const char *path, ff_error *err)
{
    for (size_t p = 0; p < r->n_phi; p++)
        for (size_t k = 0; k < r->n_theta; k++) {
            const size_t slice = p * r->n_theta + k;
            ff_rgl_sample_slice(r, p, k, room->row, &room->slice);
            if (!same_directions(r, t, p, k, &room->slice))
                return not_our_layout(path, "other directions than those of its layout", err);
            for (size_t i = 0; i < r->width * r->height; i++) {
                const double factor = room->slice.factor[i];
                const ff_status status = factor > 0 ? put_sample(r, t, slice, i, factor, path, err) : FF_OK;
                if (status != FF_OK) return status;
            }
        }
    return FF_OK;
}

static ff_status write_bytes(const char *path, const ff_tensor_file *file, ff_outputs *with, ff_error *err)
{
    ff_output out;
    const ff_status status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    fwrite(file->bytes, 1, file->n_bytes, out.file);
    return ff_output_commit(&out, err);
}

static ff_status write_rgl(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_status status = check_writable(path, t, err);
    if (status != FF_OK) return status;
    const ff_rgl *kept = t->kept;
    ff_rgl copy = *kept; /* with bytes of its own */
    slice_room room;
    if ((status = ff_tensor_file_copy(&kept->file, &copy.file, err)) != FF_OK) return status;
    if (slice_room_new(&copy, &room)) {
        room.slice.density = NULL; /* directions and factors are all it takes */
        status = put_table(&copy, t, &room, path, err);
        free(room.memory);
    } else
        status = ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the samples of an RGL file");
    if (status == FF_OK) status = write_bytes(path, &copy.file, with, err);
    ff_tensor_file_free(&copy.file);
    return status;
}

const ff_format ff_format_rgl = {
    .name = "rgl",
    .title = "RGL material database (EPFL), adaptive parametrisation, RGB or spectral",
    .extensions = ".bsdf",
    .source = "Dupuy, Jakob 2018; rgl.epfl.ch/materials, github.com/rgl-epfl/brdf-loader",
    .probe = probe,
    .reads = FF_READS_GRID,
    .holds = FF_HOLDS_INVALID | FF_HOLDS_NEGATIVE | FF_HOLDS_NAMES | FF_HOLDS_MANY,
    .precision = "32-bit float, 6e-8 relative",
    .read = read_rgl,
    .layout = layout,
    .write = write_rgl,
};
