/* Writing a Klems matrix: the reflection of the front, on the patches "LBNL/Klems Full", as columns of incidence.
 *
 * A value is the mean of f over the patch of exit, weighted by the cosine, at the centre of the patch of incidence: the layout has
 * nine directions of equal solid angle in each patch of exit, and the writer takes the mean of whatever directions lie in a patch.
 */
#define _GNU_SOURCE
#include "internal_window.h"
#include "base/internal_number.h"
#include "base/internal_output.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
static const char basis_name[] = "LBNL/Klems Full";
enum { POLAR = 5, AZIMUTHS = 3, POINTS = POLAR * AZIMUTHS };

static void klems_full(ff_window_basis *b)
{
    memset(b, 0, sizeof *b);
    strcpy(b->name, basis_name);
    (void)ff_window_standard_basis(b); /* it is one */
}

/* ---- directions ------------------------------------------------------------------------------------------ */

static size_t fill_patch(ff_table *t, size_t at, const double light[2], const ff_window_ring *ring, size_t k, double weight)
{
    const double upper = cos(degree * ring->lower), lower = cos(degree * ring->upper), width = 360 / (double)ring->n_phi;
    for (int i = 0; i < POLAR; i++)
        for (int j = 0; j < AZIMUTHS; j++, at++) {
            const double theta = acos(upper + (lower - upper) * (i + 0.5) / POLAR) / degree;
            const double phi = width * ((double)k + (j + 0.5) / AZIMUTHS - 0.5);
            t->angle[0][at] = light[0];
            t->angle[1][at] = -light[1];
            t->angle[2][at] = theta;
            t->angle[3][at] = 180 - phi;
            t->weight[at] = weight / POINTS;
        }
    return at;
}

ff_status ff_window_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    ff_window_basis b;
    size_t at = 0;
    if (grid && strcmp(grid, "klems-full") != 0)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "grid: found '%.40s', expected klems-full", grid);
    klems_full(&b);
    double *patch = malloc(3 * b.n * sizeof *patch);
    if (!patch) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu patches", b.n);
    double *theta = patch, *phi = theta + b.n, *omega = phi + b.n;
    ff_window_patches(&b, theta, phi, omega);
    const ff_status status = ff_table_init(b.n * b.n * POINTS, t->n_channels, NULL, 0, 1, out, err);
    for (size_t i = 0; i < b.n && status == FF_OK; i++) {
        const double light[2] = {theta[i], phi[i]};
        size_t o = 0;
        for (size_t r = 0; r < b.n_rings; r++)
            for (size_t k = 0; k < b.ring[r].n_phi; k++, o++) at = fill_patch(out, at, light, &b.ring[r], k, omega[i] * omega[o]);
    }
    if (status == FF_OK) {
        out->radians_per_unit = degree;
        ff_table_name_channels_like(out, t);
    }
    free(patch);
    return status;
}

/* ---- means over patches ------------------------------------------------------------------------------------ */

/* The patch of a direction in the file's azimuths; beyond the horizon b->n. */
static size_t patch_of(const ff_window_basis *b, double theta, double phi)
{
    size_t first = 0;
    if (theta < 0) theta = -theta, phi += 180;
    for (size_t r = 0; r < b->n_rings; r++) {
        const ff_window_ring *ring = &b->ring[r];
        if (theta <= ring->upper + 1e-9) {
            const double turns = phi / 360, n = (double)ring->n_phi;
            const size_t k = (size_t)floor(n * (turns - floor(turns)) + 0.5) % ring->n_phi;
            return first + k;
        }
        first += ring->n_phi;
    }
    return b->n;
}

/* Sums of one channel: value and weight of each pair of patches, at [exit][incident]. */
static void add_samples(const ff_table *t, const ff_window_basis *b, size_t c, double *sum, double *weight)
{
    memset(sum, 0, b->n * b->n * sizeof *sum);
    memset(weight, 0, b->n * b->n * sizeof *weight);
    for (size_t i = 0; i < t->n; i++) {
        double a[4], *const planes[4] = {a, a + 1, a + 2, a + 3};
        if (!t->valid[i]) continue;
        ff_table_angles(t, degree, i, 1, planes);
        const size_t in = patch_of(b, a[0], -a[1]), out = patch_of(b, a[2], 180 - a[3]);
        const double w = cos(degree * a[2]);
        if (in == b->n || out == b->n || !(w > 0)) continue;
        sum[out * b->n + in] += w * t->channels[c].scale * t->value[c * t->n + i];
        weight[out * b->n + in] += w;
    }
}

static ff_status check_filled(const char *path, const ff_window_basis *b, const double *weight, ff_error *err)
{
    size_t empty = 0;
    for (size_t k = 0; k < b->n * b->n; k++) empty += weight[k] > 0 ? 0 : 1;
    if (empty == 0) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "a file of this format has values for all %zu pairs of Klems' patches, and %zu have no sample; resample to "
                        "it, or write csv",
                        b->n * b->n, empty);
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static void put_text(FILE *file, const char *text)
{
    for (; *text; text++) {
        if (*text == '<')
            fputs("&lt;", file);
        else if (*text == '&')
            fputs("&amp;", file);
        else
            fputc(*text, file);
    }
}

static void put_head(const ff_window_basis *b, FILE *file)
{
    fprintf(file,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\">\n"
            "<WindowElementType>System</WindowElementType>\n<Optical>\n<Layer>\n<Material>\n<Name>Measured reflectance</Name>\n"
            "<Manufacturer>not stated</Manufacturer>\n<DeviceType>Other</DeviceType>\n</Material>\n<DataDefinition>\n"
            "<IncidentDataStructure>Columns</IncidentDataStructure>\n<AngleBasis>\n<AngleBasisName>%s</AngleBasisName>\n",
            basis_name);
    for (size_t r = 0; r < b->n_rings; r++)
        fprintf(
            file,
            "<AngleBasisBlock><Theta>%g</Theta><ThetaBounds><LowerTheta>%g</LowerTheta><UpperTheta>%g</UpperTheta></ThetaBounds>"
            "<nPhis>%zu</nPhis></AngleBasisBlock>\n",
            b->ring[r].theta, b->ring[r].lower, b->ring[r].upper, b->ring[r].n_phi);
    fputs("</AngleBasis>\n</DataDefinition>\n", file);
}

static void put_channel(const ff_table *t, size_t c, const ff_window_basis *b, const double *sum, const double *weight, FILE *file)
{
    fputs("<WavelengthData>\n<LayerNumber>System</LayerNumber>\n<Wavelength unit=\"Integral\">", file);
    put_text(file, t->n_channels == 1 ? "Visible" : t->channels[c].name);
    fprintf(file,
            "</Wavelength>\n<WavelengthDataBlock>\n<WavelengthDataDirection>Reflection Front</WavelengthDataDirection>\n"
            "<ColumnAngleBasis>%s</ColumnAngleBasis>\n<RowAngleBasis>%s</RowAngleBasis>\n"
            "<ScatteringDataType>BRDF</ScatteringDataType>\n<ScatteringData>\n",
            basis_name, basis_name);
    for (size_t k = 0; k < b->n * b->n; k++) {
        char number[FF_NUMBER_TEXT];
        fwrite(number, 1, ff_number_write(sum[k] / weight[k], number), file);
        fputc((k + 1) % b->n ? ' ' : '\n', file);
    }
    fputs("</ScatteringData>\n</WavelengthDataBlock>\n</WavelengthData>\n", file);
}

static ff_status write_channels(const char *path, const ff_table *t, const ff_window_basis *b, double *sum, FILE *file,
                                ff_error *err)
{
    double *weight = sum + b->n * b->n;
    put_head(b, file);
    for (size_t c = 0; c < t->n_channels; c++) {
        add_samples(t, b, c, sum, weight);
        const ff_status status = check_filled(path, b, weight, err);
        if (status != FF_OK) return status;
        put_channel(t, c, b, sum, weight, file);
    }
    fputs("</Layer>\n</Optical>\n</WindowElement>\n", file);
    return FF_OK;
}

ff_status ff_window_write(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err)
{
    ff_window_basis b;
    ff_output out;
    ff_status status = ff_table_check(t, path, err);
    if (status == FF_OK && t->sigma)
        status = ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                              "a file of this format has no room for the standard deviations of this table; write csv");
    if (status != FF_OK) return status;
    klems_full(&b);
    double *sum = malloc(2 * b.n * b.n * sizeof *sum);
    status = sum ? ff_output_open_with(path, with, &out, err)
                 : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for %zu patches", b.n);
    if (status == FF_OK) {
        status = write_channels(path, t, &b, sum, out.file, err);
        if (status == FF_OK)
            status = ff_output_commit(&out, err);
        else
            ff_output_abort(&out);
    }
    free(sum);
    return status;
}
