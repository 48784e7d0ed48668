/* Ansys Speos, anisotropic BSDF (.anisotropicbsdf): as format_speos.c, with a rotation of the sample and without wavelengths of its
 * own.
 *
 *     OPTIS - Anisotropic BSDF surface file v8.0
 *     0, comment, characters of the description, description: as there
 *     0 1 0                                the anisotropy vector
 *     1 0                                  reflection, transmission
 *     1                                    BSDF; 0: intensity
 *     2                                    rotations
 *     0 90                                 degrees
 *     13                                   incidences of each rotation, a count and its angles after one another
 *     15 20 25 ...
 *     15 0                                 polar angle and azimuth at which the spectrum was measured
 *                                          a line for its description
 *     2                                    wavelengths of the spectrum
 *     350 13.45                            nm, reflectance in per cent there
 *     850 13.45
 *     19 37                                a block for each rotation and incidence, as in format_speos.c
 *
 * All blocks are proportional to f by the same factor: that which gives the block of the spectrum's incidence its reflectance. (The
 * maker's pair of such a file and one of Zemax's says so: the TIS of 13 incidences are the blocks' integrals to 1 %, the factor
 * being that of the first; the values agree to 0.3 % in the middle and 2 % nine times of ten, but for what TIS and the values of
 * Zemax's file differ by.) A spectrum that is the same everywhere is one channel. Rotations are those of Zemax's files, from which
 * the maker's converter copies them. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "data_formats/formats/speos/internal_speos.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char title[] = "Anisotropic BSDF surface file";
static const double degree = 3.14159265358979323846 / 180;
enum { ROTATIONS = 3600, INCIDENCES = 4096, WAVELENGTHS = 4096 };

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    return ff_speos_probe(head, n, title) ? 98 : 0;
}

/* The incidences of one rotation. */
typedef struct turned {
    size_t n;
    double *incidence;
} turned;

typedef struct anisotropic {
    ff_speos s;
    size_t n_rotations, n_spectrum, n_channels;
    double *rotation;
    turned *at;           /* [n_rotations] */
    double measured[2];   /* where the spectrum was */
    double *spectrum;     /* [n_spectrum] wavelength, per cent */
    double off, integral; /* of the block nearest to that: how far, and its integral */
    ff_rows rows;
} anisotropic;

static ff_status no_memory(const anisotropic *f)
{
    return ff_error_set(f->s.err, FF_ERR_MEMORY, f->s.path, 0, -1, "no memory for the angles of a file");
}

static ff_status read_angles(anisotropic *f)
{
    ff_status status = ff_speos_count(&f->s, "rotations", ROTATIONS, &f->n_rotations);
    if (status == FF_OK) status = ff_speos_list(&f->s, "rotations", f->n_rotations, -360, 360, &f->rotation);
    if (status == FF_OK && !(f->at = calloc(f->n_rotations, sizeof *f->at))) return no_memory(f);
    for (size_t r = 0; r < f->n_rotations && status == FF_OK; r++) {
        status = ff_speos_count(&f->s, "incidences", INCIDENCES, &f->at[r].n);
        if (status == FF_OK) status = ff_speos_list(&f->s, "angles of incidence", f->at[r].n, 0, 90, &f->at[r].incidence);
    }
    return status;
}

/* A line of its own, which may be empty. */
static ff_status skip_line(anisotropic *f)
{
    char *text;
    size_t length;
    f->s.t.at = NULL;
    return ff_lines_next(&f->s.t.lines, &text, &length, f->s.err);
}

static ff_status read_spectrum(anisotropic *f)
{
    ff_status status = ff_tokens_numbers(&f->s.t, f->measured, 2, "polar angle and azimuth at which the spectrum was measured");
    if (status == FF_OK) status = skip_line(f);
    if (status == FF_OK) status = ff_speos_count(&f->s, "wavelengths of the spectrum", WAVELENGTHS, &f->n_spectrum);
    if (status == FF_OK && !(f->spectrum = malloc(2 * f->n_spectrum * sizeof *f->spectrum))) return no_memory(f);
    if (status == FF_OK)
        status = ff_tokens_numbers(&f->s.t, f->spectrum, 2 * f->n_spectrum, "wavelengths and reflectances in per cent");
    if (status != FF_OK) return status;
    f->n_channels = 1;
    for (size_t k = 0; k < f->n_spectrum; k++) {
        if (!(f->spectrum[2 * k + 1] >= 0) || (k && f->spectrum[2 * k] <= f->spectrum[2 * k - 2]) || !(f->spectrum[2 * k] > 0))
            return ff_error_set(f->s.err, FF_ERR_DATA, f->s.path, f->s.t.lines.line, -1,
                                "spectrum: found %g nm and %g per cent, expected ascending wavelengths and 0 per cent or more",
                                f->spectrum[2 * k], f->spectrum[2 * k + 1]);
        if (f->spectrum[2 * k + 1] != f->spectrum[1]) f->n_channels = f->n_spectrum;
    }
    return FF_OK;
}

static ff_status read_header(anisotropic *f)
{
    double vector[3];
    ff_status status = ff_speos_begin(&f->s, title);
    if (status == FF_OK) status = ff_tokens_numbers(&f->s.t, vector, 3, "the anisotropy vector");
    if (status == FF_OK) status = ff_speos_kinds(&f->s);
    if (status == FF_OK && f->s.transmits)
        status = ff_error_set(
            f->s.err, FF_ERR_UNSUPPORTED, f->s.path, f->s.t.lines.line, -1,
            "found reflection and transmission in one anisotropic file, expected reflection alone: save that from the BSDF viewer");
    if (status == FF_OK) status = read_angles(f);
    return status == FF_OK ? read_spectrum(f) : status;
}

/* How far a block is from where the spectrum was measured; incidences count before rotations. */
static double distance(const anisotropic *f, size_t r, size_t j)
{
    double turn = fabs(f->rotation[r] - f->measured[1]);
    turn = fmin(turn, fabs(360 - turn));
    return 1e3 * fabs(f->at[r].incidence[j] - f->measured[0]) + turn;
}

static ff_status read_blocks(anisotropic *f)
{
    double band[INCIDENCES / 8], one = 1;
    f->off = INFINITY;
    f->rows.width = ff_rows_width(1, 0, 1);
    for (size_t r = 0; r < f->n_rotations; r++) {
        const size_t n = f->at[r].n;
        const int fits = n <= sizeof band / sizeof band[0];
        if (fits) ff_polar_bands(f->at[r].incidence, n, degree, band);
        for (size_t j = 0; j < n; j++) {
            ff_speos_block b;
            ff_status status = ff_speos_block_read(&f->s, &b);
            if (status != FF_OK) return status;
            ff_speos_block_to_bsdf(&f->s, &b);
            if (distance(f, r, j) < f->off) f->off = distance(f, r, j), f->integral = ff_speos_block_integral(&b);
            status =
                ff_speos_rows_add(&f->s, f->rotation[r], f->at[r].incidence[j],
                                  (fits ? band[j] : 1) * 360 * degree / (double)f->n_rotations, &b, 1, &b.value, &one, &f->rows);
            ff_speos_block_clear(&b);
            if (status != FF_OK) return status;
        }
    }
    if (f->integral > 0) return FF_OK;
    return ff_error_set(f->s.err, FF_ERR_DATA, f->s.path, f->s.t.lines.line, -1,
                        "found a block whose integral is %g where the spectrum was measured, expected one above 0", f->integral);
}

/* The shape that was read, once for each wavelength. */
static ff_status make_table(const anisotropic *f, const ff_table *shape, ff_table *out)
{
    ff_table t;
    const ff_status status = ff_table_init(shape->n, f->n_channels, NULL, 0, 1, &t, f->s.err);
    if (status != FF_OK) return status;
    for (int k = 0; k < 4; k++) memcpy(t.angle[k], shape->angle[k], t.n * sizeof(double));
    memcpy(t.weight, shape->weight, t.n * sizeof(double));
    memcpy(t.valid, shape->valid, t.n);
    for (size_t c = 0; c < t.n_channels; c++) {
        const double scale = f->spectrum[2 * c + 1] / 100 / f->integral;
        for (size_t i = 0; i < t.n; i++) t.value[c * t.n + i] = scale * shape->value[i];
        strcpy(t.channels[c].name, "f");
        if (t.n_channels > 1) snprintf(t.channels[c].name, sizeof t.channels[c].name, "%gnm", f->spectrum[2 * c]);
        if (t.n_channels > 1) t.channels[c].wavelength_nm = f->spectrum[2 * c];
    }
    strcpy(t.format, "anisotropicbsdf");
    t.radians_per_unit = degree;
    t.isotropic = f->n_rotations == 1;
    ff_table_note(&t, "the values are proportional to the %s, and are such that the reflectance at %g degrees comes out",
                  f->s.is_bsdf ? "BRDF" : "intensity, the BRDF times the cosine", f->measured[0]);
    if (f->off >= 1e-3)
        ff_table_note(&t, "the spectrum was measured at %g degrees, where there is no block: the nearest one stands for it",
                      f->measured[0]);
    *out = t;
    return FF_OK;
}

static ff_status read_anisotropic(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    anisotropic f = {.s = {.err = err, .path = path}};
    ff_table shape, t;
    ff_status status = ff_tokens_open(path, &f.s.t, err);
    if (status != FF_OK) return status;
    status = read_header(&f);
    if (status == FF_OK) status = read_blocks(&f);
    if (status == FF_OK) status = ff_rows_to_table(&f.rows, 1, 0, 1, &shape, err);
    ff_tokens_close(&f.s.t);
    ff_rows_free(&f.rows);
    if (status == FF_OK) {
        status = make_table(&f, &shape, &t);
        ff_table_clear(&shape);
        if (status == FF_OK) status = ff_table_hand_out(&t, path, out, err);
    }
    for (size_t r = 0; r < f.n_rotations && f.at; r++) free(f.at[r].incidence);
    free(f.at);
    free(f.rotation);
    free(f.spectrum);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static ff_status layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    if (t->n_channels > 1)
        return ff_error_set(
            err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
            "found %zu channels, but a file of this format has one shape for all wavelengths; take one, or their mean",
            t->n_channels);
    return ff_speos_layout(t, 1, grid, out, err);
}

static void write_header(const ff_speos_grid *g, double percent, FILE *file)
{
    fprintf(file, "OPTIS - %s v8.0\n0\nBRDF, 1/sr\n1\n-\n0\t1\t0\n1\t0\n1\n%zu\n", title, g->n_rotations);
    for (size_t r = 0; r < g->n_rotations; r++) ff_speos_put(file, g->rotation[r], r + 1 < g->n_rotations ? '\t' : '\n');
    for (size_t r = 0; r < g->n_rotations; r++) {
        fprintf(file, "%zu\n", g->n_incidences);
        for (size_t j = 0; j < g->n_incidences; j++) ff_speos_put(file, g->incidence[j], j + 1 < g->n_incidences ? '\t' : '\n');
    }
    ff_speos_put(file, g->incidence[0], '\t');
    ff_speos_put(file, g->rotation[0], '\n');
    fputs("\n2\n350\t", file);
    ff_speos_put(file, percent, '\n');
    fputs("850\t", file);
    ff_speos_put(file, percent, '\n');
}

static ff_status write_anisotropic(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err)
{
    ff_speos_grid g;
    ff_output out;
    ff_status status = ff_table_check(t, path, err);
    if (status == FF_OK && (t->sigma || t->n_channels > 1))
        status =
            ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                         "a file of this format has one channel and no standard deviations; take one, or the mean, or write csv");
    if (status == FF_OK) status = ff_speos_grid_of(t, path, &g, err);
    if (status != FF_OK) return status;
    const double percent = ff_speos_block_percent(t, &g, 0, 0, err);
    if (isnan(percent)) status = FF_ERR_MEMORY;
    if (status == FF_OK && !(percent > 0))
        status = ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                              "found nothing reflected at %g degrees, by which the values would be scaled", g.incidence[0]);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status == FF_OK) {
        write_header(&g, percent, out.file);
        for (size_t b = 0; b < g.n_rotations * g.n_incidences; b++)
            ff_speos_block_write(t, &g, 0, b * g.n_theta * g.n_phi, out.file);
        fputs("End of file\n", out.file);
        status = ff_output_commit(&out, err);
    }
    free(g.rotation);
    return status;
}

const ff_format ff_format_anisotropicbsdf = {
    .name = "anisotropicbsdf",
    .title = "Ansys Speos anisotropic BSDF: rotations, incidences, polar angles and azimuths",
    .extensions = ".anisotropicbsdf",
    .source = "Ansys Speos User's Guide, anisotropic BSDF file format; the maker's conversions in ansys/optical-automation",
    .probe = probe,
    .precision = "scaled by their integral, 1e-15 relative",
    .read = read_anisotropic,
    .layout = layout,
    .write = write_anisotropic,
};
