/* Ansys Speos, spectral BSDF (.brdf): text of the BSDF viewer.
 *
 *     OPTIS - brdf surface file v8.0
 *     0                                    text
 *     comment                              a line
 *     5                                    characters of a description, which follows on lines of its own
 *     -----
 *     1 1                                  there are data of reflection, of transmission
 *     1                                    values are proportional to the BSDF; 0: to the intensity, f cos(theta)
 *     4 1                                  incidences, wavelengths
 *     0 22.5 45 67.5                       degrees
 *     550                                  nm
 *     2.3                                  reflectance, per cent, of this incidence and wavelength (the wavelength runs faster)
 *     91 361                               polar angles, azimuths
 *         0 1 2 ...                        azimuths
 *     0   0.0018 ...                       a polar angle and its values
 *     ...                                  then the same of transmission, and "End of file"
 *
 * The values of a block say how f goes, its reflectance how much it is: f = v R / integral(v cos). The integral is by trapezoids,
 * as the file's grid has it. Polar angles are from the normal. Azimuth 0 is the side of the mirror direction and grows
 * counter-clockwise: of the maker's own pair of a file of this format and one of Zemax's, read by format_zemax.c, half of 122,043
 * values agree to 3e-4 and 95 of 100 to 1e-3 with this orientation, and to 1.3 % and 5 % with the other sense. The frame is the one
 * that Zemax's files are read in. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "data_formats/formats/speos/internal_speos.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char title[] = "brdf surface file";
static const double degree = 3.14159265358979323846 / 180;
enum { INCIDENCES = 4096, WAVELENGTHS = 4096 };

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    return ff_speos_probe(head, n, title) ? 98 : 0;
}

typedef struct speos {
    ff_speos s;
    size_t n_incidences, n_wavelengths;
    double *incidence, *band, *wavelength; /* [..] */
    ff_speos_block *block;                 /* [n_wavelengths] of one incidence */
    double *scale, **value;                /* [n_wavelengths] */
    ff_rows rows;
} speos;

static ff_status allocate(speos *f)
{
    const size_t n = f->n_wavelengths;
    f->band = malloc(f->n_incidences * sizeof *f->band);
    f->block = calloc(n, sizeof *f->block);
    f->scale = malloc(n * sizeof *f->scale);
    f->value = malloc(n * sizeof *f->value);
    f->rows.width = ff_rows_width(n, 0, 1);
    if (!f->band || !f->block || !f->scale || !f->value)
        return ff_error_set(f->s.err, FF_ERR_MEMORY, f->s.path, 0, -1, "no memory for %zu wavelengths", n);
    ff_polar_bands(f->incidence, f->n_incidences, degree, f->band);
    for (size_t k = 0; k < f->n_incidences; k++) f->band[k] *= 360 * degree;
    return FF_OK;
}

static ff_status read_header(speos *f)
{
    ff_status status = ff_speos_begin(&f->s, title);
    if (status == FF_OK) status = ff_speos_kinds(&f->s);
    if (status == FF_OK) status = ff_speos_count(&f->s, "incidences", INCIDENCES, &f->n_incidences);
    if (status == FF_OK) status = ff_speos_count(&f->s, "wavelengths", WAVELENGTHS, &f->n_wavelengths);
    if (status == FF_OK) status = ff_speos_list(&f->s, "angles of incidence", f->n_incidences, 0, 90, &f->incidence);
    if (status == FF_OK) status = ff_speos_list(&f->s, "wavelengths in nm", f->n_wavelengths, 1, 1e9, &f->wavelength);
    return status == FF_OK ? allocate(f) : status;
}

static int same_grid(const ff_speos_block *a, const ff_speos_block *b)
{
    if (a->n_theta != b->n_theta || a->n_phi != b->n_phi) return 0;
    return memcmp(a->theta, b->theta, a->n_theta * sizeof *a->theta) == 0 && memcmp(a->phi, b->phi, a->n_phi * sizeof *a->phi) == 0;
}

/* The factor of a block of the given reflectance. */
static ff_status scale_of(const ff_speos *s, const ff_speos_block *b, double percent, double *out)
{
    const double integral = ff_speos_block_integral(b);
    if (!(percent >= 0))
        return ff_error_set(s->err, FF_ERR_DATA, s->path, s->t.lines.line, -1,
                            "found a reflectance of %g per cent, expected 0 or more", percent);
    if (percent > 0 && !(integral > 0))
        return ff_error_set(s->err, FF_ERR_DATA, s->path, s->t.lines.line, -1,
                            "found a block of values whose integral is %g, expected one above 0: its reflectance is %g per cent",
                            integral, percent);
    *out = percent > 0 ? percent / 100 / integral : 0;
    return FF_OK;
}

static ff_status read_wavelengths(speos *f)
{
    ff_status status = FF_OK;
    for (size_t k = 0; k < f->n_wavelengths && status == FF_OK; k++) {
        double percent;
        status = ff_tokens_numbers(&f->s.t, &percent, 1, "the reflectance of an incidence and wavelength");
        if (status == FF_OK) status = ff_speos_block_read(&f->s, &f->block[k]);
        if (status != FF_OK) return status;
        ff_speos_block_to_bsdf(&f->s, &f->block[k]);
        if (!same_grid(&f->block[0], &f->block[k]))
            return ff_error_set(f->s.err, FF_ERR_UNSUPPORTED, f->s.path, f->s.t.lines.line, -1,
                                "found other angles at %g nm than at %g nm, expected the same", f->wavelength[k], f->wavelength[0]);
        f->value[k] = f->block[k].value;
        status = scale_of(&f->s, &f->block[k], percent, &f->scale[k]);
    }
    return status;
}

static ff_status read_incidences(speos *f)
{
    ff_status status = FF_OK;
    for (size_t j = 0; j < f->n_incidences && status == FF_OK; j++) {
        status = read_wavelengths(f);
        if (status == FF_OK)
            status = ff_speos_rows_add(&f->s, 0, f->incidence[j], f->band[j], &f->block[0], f->n_wavelengths, f->value, f->scale,
                                       &f->rows);
        for (size_t k = 0; k < f->n_wavelengths; k++) ff_speos_block_clear(&f->block[k]);
    }
    return status;
}

static void name_channels(const speos *f, ff_table *t)
{
    for (size_t c = 0; c < f->n_wavelengths; c++) {
        snprintf(t->channels[c].name, sizeof t->channels[c].name, "%gnm", f->wavelength[c]);
        t->channels[c].wavelength_nm = f->wavelength[c];
    }
}

static ff_status read_speos(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    speos f = {.s = {.err = err, .path = path}};
    ff_table t;
    ff_status status = ff_tokens_open(path, &f.s.t, err);
    if (status != FF_OK) return status;
    status = read_header(&f);
    if (status == FF_OK) status = read_incidences(&f);
    if (status == FF_OK) status = ff_rows_to_table(&f.rows, f.n_wavelengths, 0, 1, &t, err);
    ff_tokens_close(&f.s.t);
    ff_rows_free(&f.rows);
    if (status == FF_OK) {
        strcpy(t.format, "speos");
        name_channels(&f, &t);
        t.radians_per_unit = degree;
        t.isotropic = 1;
        ff_table_note(&t, "the values are proportional to the %s, and are such that the reflectances of the file come out",
                      f.s.is_bsdf ? "BRDF" : "intensity, the BRDF times the cosine");
        if (f.s.transmits) ff_table_note(&t, "what the file has of transmission is not read");
        status = ff_table_hand_out(&t, path, out, err);
    }
    free(f.incidence);
    free(f.band);
    free(f.wavelength);
    free(f.block);
    free(f.scale);
    free(f.value);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static ff_status layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    return ff_speos_layout(t, 0, grid, out, err);
}

/* Wavelengths in nm; channels that have none are one after another from 550 on. */
static double wavelength_of(const ff_table *t, size_t c)
{
    return isfinite(t->channels[c].wavelength_nm) ? t->channels[c].wavelength_nm : 550 + (double)c;
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    const ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK) return status;
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a file of this format has no room for the standard deviations of this table; write csv");
    for (size_t c = 1; c < t->n_channels; c++)
        if (!(wavelength_of(t, c) > wavelength_of(t, c - 1)))
            return ff_error_set(
                err, FF_ERR_UNSUPPORTED, path, 0, -1,
                "found channels that do not ascend by wavelength ('%s' after '%s'), expected it: take some, or their mean",
                t->channels[c].name, t->channels[c - 1].name);
    return FF_OK;
}

static ff_status write_blocks(const ff_table *t, const ff_speos_grid *g, FILE *file, ff_error *err)
{
    for (size_t j = 0; j < g->n_incidences; j++)
        for (size_t c = 0; c < t->n_channels; c++) {
            const size_t first = j * g->n_theta * g->n_phi;
            const double percent = ff_speos_block_percent(t, g, c, first, err);
            if (isnan(percent)) return FF_ERR_MEMORY;
            ff_speos_put(file, fmax(percent, 0), '\n');
            ff_speos_block_write(t, g, c, first, file);
        }
    return FF_OK;
}

static ff_status write_speos(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err)
{
    ff_speos_grid g;
    ff_output out;
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = ff_speos_grid_of(t, path, &g, err);
    if (status != FF_OK) return status;
    if (g.n_rotations > 1)
        status = ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                              "found %zu rotations, but a file of this format has one; write anisotropicbsdf", g.n_rotations);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status == FF_OK) {
        fprintf(out.file, "OPTIS - %s v8.0\n0\nBRDF, 1/sr\n1\n-\n1\t0\n1\n%zu\t%zu\n", title, g.n_incidences, t->n_channels);
        for (size_t j = 0; j < g.n_incidences; j++) ff_speos_put(out.file, g.incidence[j], j + 1 < g.n_incidences ? '\t' : '\n');
        for (size_t c = 0; c < t->n_channels; c++) ff_speos_put(out.file, wavelength_of(t, c), c + 1 < t->n_channels ? '\t' : '\n');
        status = write_blocks(t, &g, out.file, err);
        fputs("End of file\n", out.file);
        if (status == FF_OK)
            status = ff_output_commit(&out, err);
        else
            ff_output_abort(&out);
    }
    free(g.rotation);
    return status;
}

const ff_format ff_format_speos = {
    .name = "speos",
    .title = "Ansys Speos spectral BSDF: polar angles and azimuths at each incidence, wavelengths",
    .extensions = ".brdf",
    .source = "Ansys Speos User's Guide, BRDF file format; the maker's conversions in ansys/optical-automation",
    .probe = probe,
    .holds = FF_HOLDS_MANY,
    .precision = "scaled by their integral, 1e-15 relative",
    .read = read_speos,
    .layout = layout,
    .write = write_speos,
};
