/* The text of a LightTools file. */
#include "internal_lighttools.h"
#include "base/internal_number.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
enum { THETA_I, THETA_O = 2, PHI_O };

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK) return status;
    if (!ff_lighttools_is_layout(t))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a file of this format has a grid of theta_o and phi_o for each angle in one plane of incidence, and "
                            "these directions are none; resample to it, or write csv or astm");
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a file of this format has no room for the standard deviations of this table; write csv");
    return ff_lighttools_check_channels(t, path, err);
}

typedef struct writer {
    const ff_table *t;
    FILE *file;
    double *turn; /* [azimuths], radians: what each stands for */
} writer;

static void put_number(FILE *file, double v, char after)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
    putc(after, file);
}

/* Degrees; the factor is exactly 1 where the table has them. */
static double file_angle(const ff_table *t, int k, size_t i)
{
    return t->radians_per_unit / degree * t->axes.node[k][i];
}

static void put_axis(FILE *file, const ff_table *t, const char *keyword, int k)
{
    const size_t n = t->axes.n[k];
    fprintf(file, "%s\t%zu\n", keyword, n);
    for (size_t i = 0; i < n; i++) put_number(file, file_angle(t, k, i), i + 1 < n ? '\t' : '\n');
}

static double stored(const ff_table *t, size_t c, size_t i)
{
    return ff_table_is_measured(t, i) ? t->channels[c].scale * t->value[c * t->n + i] : 0;
}

/* Integral of cos(theta) sin(theta) over the cell of a radial angle, which ends half way to its neighbours, and at the horizon. */
static double projected(const ff_table *t, size_t r)
{
    const double *theta = t->axes.node[THETA_O], unit = t->radians_per_unit;
    const double low = r ? sin(unit * (theta[r - 1] + theta[r]) / 2) : 0,
                 high = r + 1 < t->axes.n[THETA_O] ? sin(unit * (theta[r] + theta[r + 1]) / 2) : 1;
    return (high * high - low * low) / 2;
}

/* Integral of f cos(theta_o) over an incidence. */
static double integral(const writer *w, size_t c, size_t first)
{
    const size_t n_azimuth = w->t->axes.n[PHI_O];
    double sum = 0;
    for (size_t r = 0; r < w->t->axes.n[THETA_O]; r++) {
        const double ring = projected(w->t, r);
        for (size_t a = 0; a < n_azimuth; a++) sum += ring * w->turn[a] * stored(w->t, c, first + r * n_azimuth + a);
    }
    return sum;
}

static void write_block(const writer *w, size_t incidence, size_t c)
{
    const ff_table *t = w->t;
    FILE *file = w->file;
    const size_t n_radial = t->axes.n[THETA_O], n_azimuth = t->axes.n[PHI_O], first = incidence * n_radial * n_azimuth;
    fputs("\nAOI\t", file);
    put_number(file, file_angle(t, THETA_I, incidence), '\n');
    fputs("POI\t0\nSide\tFront\n", file);
    if (isfinite(t->channels[c].wavelength_nm) && !ff_lighttools_is_xyz(t)) {
        fputs("Wavelength\t", file);
        put_number(file, t->channels[c].wavelength_nm, '\n');
    }
    fputs("ScatterType\tBRDF\n", file);
    if (ff_lighttools_is_xyz(t)) fprintf(file, "TristimulusValue\tTris%c\n", "XYZ"[c]);
    fputs("TIS\t", file);
    put_number(file, integral(w, c, first), '\n');
    for (size_t a = 0; a < n_azimuth; a++)
        for (size_t r = 0; r < n_radial; r++)
            put_number(file, stored(t, c, first + r * n_azimuth + a), r + 1 < n_radial ? '\t' : '\n');
}

static ff_status write_text(const char *path, writer *w, ff_outputs *with, ff_error *err)
{
    ff_output out;
    const ff_table *t = w->t;
    const ff_status status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    w->file = out.file;
    fprintf(out.file, "# BSDF data\nSource\tMeasured\nSymmetry\tAsymmetric\nSpectralContent\t%s\n",
            ff_lighttools_is_xyz(t) ? "XYZ" : "Monochrome");
    put_axis(out.file, t, "ScatterAzimuth", PHI_O);
    put_axis(out.file, t, "ScatterRadial", THETA_O);
    fputs("DataBegin\n", out.file);
    for (size_t i = 0; i < t->axes.n[THETA_I]; i++)
        for (size_t c = 0; c < t->n_channels; c++) write_block(w, i, c);
    fputs("DataEnd\n", out.file);
    return ff_output_commit(&out, err);
}

ff_status ff_lighttools_write(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_status status = check_writable(path, t, err);
    if (status != FF_OK) return status;
    const size_t n = t->axes.n[PHI_O];
    writer w = {t, NULL, malloc(2 * n * sizeof *w.turn)};
    if (!w.turn) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for %zu azimuths", n);
    for (size_t a = 0; a < n; a++) w.turn[n + a] = file_angle(t, PHI_O, a);
    ff_cells_circle(w.turn + n, n, 0, w.turn);
    status = write_text(path, &w, with, err);
    free(w.turn);
    return status;
}
