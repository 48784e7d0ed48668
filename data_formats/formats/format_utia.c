/* UTIA binary: the .bin files of the UTIA BRDF database (Filip and Vavra 2014).
 *
 *     float64 LE [3][288][288]   planes red, green, blue; row 48 ti + pi is the light, column 48 tv + pv the view
 *     theta = 0, 15, ... 75 degrees, phi = 0, 7.5, ... 352.5 degrees
 *
 * There is no header: a file is known by its size and by numbers that a reflectance can have. Both azimuths are those of the
 * sample's frame, counter-clockwise, so the angles are ours as they stand; at theta = 0 all 48 azimuths are one direction, measured
 * once or copied, and stay 48 samples that share a cell.
 *
 * The reader that the database hands out (TBDRF.cpp, J. Filip 2013) interpolates the numbers as they are and leaves the cosine of
 * the light to its caller: a BRDF without the cosine. Nothing states their absolute scale; users report materials that reflect more
 * than they receive, hence --quantity and --scale. The colour space is stated as sRGB, which leaves open whether its curve was
 * applied: some readers undo it, the database's own and others do not. Here the numbers are taken as linear, for readers have to
 * clip numbers above one and below zero, which a conversion of linear colours gives and an encoded image does not.
 * Negative numbers are noise or colours outside of sRGB: other readers set them to 0, this one keeps them. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "base/internal_bytes.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    N_CHANNELS = 3,
    N_THETA = 6,
    N_PHI = 48,
    SIDE = N_THETA * N_PHI,
    N = SIDE * SIDE,
    BYTES = 8 * N_CHANNELS * N,
    BLOCK = 1 << 12
};
static const double pi = 3.14159265358979323846;
static const double theta_step = 15, phi_step = 7.5; /* degrees */
static const char *const channel_name[N_CHANNELS] = {"r", "g", "b"};
static const char whole[] = "1990656 bytes of a UTIA file";

/* ---- the grid -------------------------------------------------------------------------------- */

/* Cells: theta half way to the neighbours, [0, 7.5], [7.5, 22.5] .. [67.5, 82.5] degrees; phi one step wide. */
static void fill_weights(ff_table *t)
{
    double band[N_THETA], azimuth[N_PHI];
    ff_polar_bands(t->axes.node[0], N_THETA, t->radians_per_unit, band);
    for (size_t k = 0; k < N_PHI; k++) azimuth[k] = 2 * pi / N_PHI;
    ff_table_product_weights(t, (const double *const[4]){band, azimuth, band, azimuth});
}

static ff_status new_table(ff_table *out, ff_error *err)
{
    static const size_t n[4] = {N_THETA, N_PHI, N_THETA, N_PHI};
    double theta[N_THETA], phi[N_PHI];
    for (size_t k = 0; k < N_THETA; k++) theta[k] = theta_step * (double)k;
    for (size_t k = 0; k < N_PHI; k++) phi[k] = phi_step * (double)k;
    const double *const node[4] = {theta, phi, theta, phi};
    const ff_status status = ff_table_init_axes(FF_AXES_INCIDENT_EXIT, n, node, pi / 180, N_CHANNELS, 1, out, err);
    if (status == FF_OK) fill_weights(out);
    return status;
}

/* 1 when the table has these axes, whatever its unit. */
static int on_the_grid(const ff_table *t)
{
    const double step[4] = {theta_step, phi_step, theta_step, phi_step};
    if (t->axes.kind != FF_AXES_INCIDENT_EXIT) return 0;
    for (int k = 0; k < 4; k++) {
        if (t->axes.n[k] != (k % 2 ? N_PHI : N_THETA)) return 0;
        for (size_t a = 0; a < t->axes.n[k]; a++)
            if (!(fabs(t->axes.node[k][a] * t->radians_per_unit - step[k] * (double)a * (pi / 180)) < 1e-9)) return 0;
    }
    return 1;
}

/* ---- reading --------------------------------------------------------------------------------- */

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    size_t zero = 0, odd = 0, count = n / 8;
    if (file_size != BYTES || count == 0) return 0;
    for (size_t i = 0; i < count; i++) {
        const double v = fabs(ff_double_of(head + 8 * i));
        zero += v == 0;
        odd += v != 0 && !(v > 1e-9 && v < 1e6); /* text and integers are far outside, and NaN */
    }
    return zero < count && 16 * odd <= count ? 75 : 0;
}

static ff_status not_finite(const double *v, int64_t offset, size_t c, const ff_bytes *b)
{
    size_t i = 0;
    while (isfinite(v[i])) i++;
    return ff_error_set(b->err, FF_ERR_DATA, b->path, 0, offset + 8 * (int64_t)i, "channel %s: found %s, expected a finite number",
                        channel_name[c], isnan(v[i]) ? "nan" : "inf");
}

/* In blocks that are looked at while they are in the cache. */
static ff_status read_plane(ff_bytes *b, size_t c, ff_table *t)
{
    double *plane = t->value + c * N;
    for (size_t i = 0; i < N; i += BLOCK) {
        const size_t n = N - i < BLOCK ? N - i : BLOCK;
        const int64_t offset = b->offset;
        const ff_status status = ff_bytes_read(b, plane + i, 8 * n, whole);
        if (status != FF_OK) return status;
        ff_doubles_from_file(plane + i, n);
        if (!ff_all_finite(plane + i, n)) return not_finite(plane + i, offset, c, b);
    }
    return FF_OK;
}

static void add_notes(ff_table *t, const ff_read_options *o)
{
    if (o->quantity < 0)
        ff_table_note(
            t, "the numbers are taken as a BRDF in 1/sr without the cosine, as the database's own reader does; their absolute "
               "scale is not documented");
    ff_table_note(t, "the colour space is sRGB; the numbers are taken as linear, not as encoded by the sRGB curve");
}

static ff_status fill(ff_bytes *b, const ff_read_options *o, ff_table *t)
{
    ff_status status = FF_OK;
    for (size_t c = 0; c < N_CHANNELS && status == FF_OK; c++) {
        snprintf(t->channels[c].name, sizeof t->channels[c].name, "%s", channel_name[c]);
        status = read_plane(b, c, t);
    }
    if (status == FF_OK) status = ff_bytes_end(b, "the last plane");
    if (status != FF_OK) return status;
    ff_table_set_quantity(t, ff_read_quantity(o, FF_BRDF));
    add_notes(t, o);
    snprintf(t->format, sizeof t->format, "utia");
    return ff_table_count(t, b->path, b->err);
}

static ff_status read_open_file(ff_bytes *b, const ff_read_options *o, ff_table *out)
{
    ff_table t;
    ff_status status = ff_bytes_need(b, BYTES, whole);
    if (status == FF_OK) status = new_table(&t, b->err);
    if (status != FF_OK) return status;
    status = fill(b, o, &t);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

static ff_status read_utia(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_bytes b;
    ff_status status = ff_bytes_open(path, &b, err);
    if (status != FF_OK) return status;
    status = read_open_file(&b, o, out);
    ff_bytes_close(&b);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

static ff_status layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    if (grid)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "found the grid '%s', but a UTIA file has only its own, 288 x 288",
                            grid);
    if (t->n_channels != N_CHANNELS && t->n_channels != 1)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "a UTIA file has 3 channels, found %zu; reduce them first (srgb, or three bands)", t->n_channels);
    const ff_status status = new_table(out, err);
    if (status == FF_OK) ff_table_name_channels_like(out, t);
    return status;
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    const ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK) return status;
    if (t->n_channels != N_CHANNELS || !on_the_grid(t))
        return ff_error_set(
            err, FF_ERR_UNSUPPORTED, path, 0, -1,
            "a UTIA file needs 3 channels on its own grid (theta 0, 15 .. 75, phi 0, 7.5 .. 352.5 degrees of light and "
            "view), found %zu channels on other directions; resample to it, or write csv",
            t->n_channels);
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a UTIA file has no room for the standard deviations of this table; write csv");
    for (size_t i = 0; i < t->n; i++)
        if (!t->valid[i])
            return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                                "a UTIA file cannot say that sample %zu was not measured; write csv", i);
    return FF_OK;
}

static void write_plane(const ff_table *t, size_t c, FILE *file)
{
    enum { MANY = 1024 };
    double v[MANY];
    unsigned char bytes[8 * MANY];
    for (size_t i = 0; i < t->n; i += MANY) {
        const size_t n = t->n - i < MANY ? t->n - i : MANY;
        ff_table_values(t, c, i, n, v);
        for (size_t k = 0; k < n; k++) ff_bytes_of_double(v[k], bytes + 8 * k);
        fwrite(bytes, 8, n, file);
    }
}

static ff_status write_utia(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_output out;
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    for (size_t c = 0; c < N_CHANNELS; c++) write_plane(t, c, out.file);
    return ff_output_commit(&out, err);
}

const ff_format ff_format_utia = {
    .name = "utia",
    .title = "UTIA BRDF database, anisotropic, 288 x 288 directions of light and view, RGB",
    .extensions = ".bin",
    .source = "Filip, Vavra 2014, Template-based sampling of anisotropic BRDFs; btf.utia.cas.cz (TBDRF.cpp)",
    .probe = probe,
    .reads = FF_READS_QUANTITY,
    .holds = FF_HOLDS_NEGATIVE | FF_HOLDS_DOUBLE,
    .read = read_utia,
    .layout = layout,
    .write = write_utia,
};
