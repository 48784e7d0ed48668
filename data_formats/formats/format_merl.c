/* MERL binary: the file of the MERL BRDF database (Matusik et al. 2003).
 *
 *     int32 LE x 3          90, 90, 180
 *     float64 LE [3][n]     planes red, green, blue; n = 1,458,000; sample order: grid_merl.c
 *
 * f = scale x stored in 1/sr without the cosine, scale = 1/1500, 1.15/1500, 1.66/1500. A negative number in any plane means that
 * the cell was not measured. The planes are kept as stored: reading and writing again gives the same file. */
#define _GNU_SOURCE
#include "base/internal_output.h"
#include "base/internal_bytes.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { N_CHANNELS = 3, HEADER_BYTES = 12, BLOCK = 1 << 14 };
static const int32_t dimension[3] = {90, 90, 180};
static const char *const channel_name[N_CHANNELS] = {"r", "g", "b"};
static const double channel_scale[N_CHANNELS] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

static const char whole[] = "34992012 bytes of a MERL file";

static int64_t file_bytes(void)
{
    return HEADER_BYTES + (int64_t)(N_CHANNELS * ff_grid_merl.n * sizeof(double));
}

/* ---- reading --------------------------------------------------------------------------------- */

static int32_t int32_of(const unsigned char *b)
{
    return (int32_t)ff_uint32_of(b);
}

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    if (n < HEADER_BYTES) return 0;
    int64_t cells = 1;
    int same = 1, swapped = 1;
    for (int k = 0; k < 3; k++) {
        int32_t d = int32_of(head + 4 * k);
        same &= d == dimension[k];
        swapped &= d == (int32_t)((uint32_t)dimension[k] << 24);
        cells = d > 0 && d < 4096 && cells > 0 ? cells * d : 0;
    }
    if (same) return 100;
    if (swapped) return 60; /* big-endian: the reader says so */
    return cells && file_size == HEADER_BYTES + 24 * cells ? 80 : file_size == file_bytes() ? 60 : 0;
}

static ff_status check_header(const unsigned char *head, const char *path, ff_error *err)
{
    for (int k = 0; k < 3; k++) {
        if (int32_of(head + 4 * k) == dimension[k]) continue;
        const char *hint = int32_of(head + 4 * k) == (int32_t)((uint32_t)dimension[k] << 24) ? " (a big-endian copy?)" : "";
        return ff_error_set(err, FF_ERR_FORMAT, path, 0, 4 * k, "found dimensions %ld x %ld x %ld, expected 90 x 90 x 180%s",
                            (long)int32_of(head), (long)int32_of(head + 4), (long)int32_of(head + 8), hint);
    }
    return FF_OK;
}

static ff_status read_header(ff_bytes *b)
{
    unsigned char head[HEADER_BYTES];
    ff_status status = ff_bytes_read(b, head, sizeof head, whole);
    if (status == FF_OK) status = check_header(head, b->path, b->err);
    return status == FF_OK ? ff_bytes_need(b, (uint64_t)(file_bytes() - HEADER_BYTES), whole) : status;
}

static void mark_negative(const double *v, size_t n, unsigned char *valid)
{
    for (size_t i = 0; i < n; i++) valid[i] = (unsigned char)(valid[i] & (v[i] >= 0));
}

static ff_status not_finite(const double *v, size_t n, int64_t offset, size_t c, const char *path, ff_error *err)
{
    size_t i = 0;
    while (i + 1 < n && isfinite(v[i])) i++;
    return ff_error_set(err, FF_ERR_DATA, path, 0, offset + 8 * (int64_t)i, "channel %s: found %s, expected a finite number",
                        channel_name[c], isnan(v[i]) ? "nan" : "inf");
}

/* Reads one plane in blocks that are looked at while they are in the cache. */
/* Reads one plane in blocks that are looked at while they are in the cache. */
static ff_status read_plane(ff_bytes *b, size_t c, ff_table *t)
{
    double *plane = t->value + c * t->n;
    for (size_t i = 0; i < t->n; i += BLOCK) {
        size_t n = t->n - i < BLOCK ? t->n - i : BLOCK;
        int64_t offset = b->offset;
        ff_status status = ff_bytes_read(b, plane + i, 8 * n, whole);
        if (status != FF_OK) return status;
        ff_doubles_from_file(plane + i, n);
        if (!ff_all_finite(plane + i, n)) return not_finite(plane + i, n, offset, c, b->path, b->err);
        mark_negative(plane + i, n, t->valid + i);
    }
    return FF_OK;
}

static ff_status read_planes(ff_bytes *b, ff_table *t)
{
    for (size_t c = 0; c < N_CHANNELS; c++) {
        ff_status status = read_plane(b, c, t);
        if (status != FF_OK) return status;
        snprintf(t->channels[c].name, sizeof t->channels[c].name, "%s", channel_name[c]);
        t->channels[c].scale = channel_scale[c];
    }
    for (size_t i = 0; i < t->n; i++) t->n_invalid += t->valid[i] == 0;
    if (t->n_invalid == t->n)
        return ff_error_set(b->err, FF_ERR_DATA, b->path, 0, HEADER_BYTES,
                            "found a negative number in each of the %zu cells, expected at least one measurement", t->n);
    return ff_bytes_end(b, "the last plane");
}

static ff_status read_open_file(ff_bytes *b, ff_table *out)
{
    ff_table t;
    ff_status status = read_header(b);
    if (status == FF_OK) status = ff_table_init(ff_grid_merl.n, N_CHANNELS, &ff_grid_merl, 0, 0, &t, b->err);
    if (status != FF_OK) return status;
    status = read_planes(b, &t);
    if (status != FF_OK) {
        ff_table_clear(&t);
        return status;
    }
    snprintf(t.format, sizeof t.format, "merl");
    *out = t;
    return FF_OK;
}

static ff_status read_merl(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    (void)o;
    ff_bytes b;
    ff_status status = ff_bytes_open(path, &b, err);
    if (status != FF_OK) return status;
    status = read_open_file(&b, out);
    ff_bytes_close(&b);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------- */

static int has_merl_scales(const ff_table *t)
{
    for (size_t c = 0; c < N_CHANNELS; c++)
        if (t->channels[c].scale != channel_scale[c]) return 0;
    return 1;
}

/* What an unmeasured sample holds in the file: what it held there before, when that says so, else -1. */
static double stored_invalid(const ff_table *t, size_t c, size_t i, int same_scales)
{
    int any = 0;
    for (size_t k = 0; k < N_CHANNELS && same_scales; k++) any |= t->value[k * t->n + i] < 0;
    double v = t->value[c * t->n + i];
    return any && isfinite(v) ? v : -1;
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    if (t->grid != &ff_grid_merl || t->n_channels != N_CHANNELS)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a MERL file needs 3 channels on the grid 'merl' (90 x 90 x 180), found %zu channels on %s",
                            t->n_channels, t->grid ? t->grid->name : "scattered directions; resample to it, or write csv or astm");
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a MERL file has no room for the standard deviations of this table; write csv");
    ff_status status = ff_table_check(t, path, err);
    for (size_t i = 0; i < t->n && status == FF_OK; i++)
        for (size_t c = 0; c < N_CHANNELS && t->valid[i]; c++)
            if (t->value[c * t->n + i] < 0)
                return ff_error_set(err, FF_ERR_DATA, path, 0, -1,
                                    "sample %zu, channel %s: found the negative measurement %g, which a MERL file would hold to be "
                                    "unmeasured; write csv",
                                    i, t->channels[c].name, t->channels[c].scale * t->value[c * t->n + i]);
    return status;
}

static ff_status layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err)
{
    if (grid)
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "found the grid '%s', but a MERL file has only its own, 90 x 90 x 180",
                            grid);
    if (t->n_channels != N_CHANNELS && t->n_channels != 1)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "a MERL file has 3 channels, found %zu; reduce them first (srgb, or three bands)", t->n_channels);
    ff_status status = ff_table_init(ff_grid_merl.n, N_CHANNELS, &ff_grid_merl, 0, 0, out, err);
    if (status != FF_OK) return status;
    ff_table_name_channels_like(out, t);
    for (size_t c = 0; c < N_CHANNELS; c++) out->channels[c].scale = channel_scale[c];
    return FF_OK;
}

/* With the file's own scales the numbers go out as they are; else the nearest ones: scale (f / scale) is f again for most f and the
 * neighbouring double for the rest, which no number of the file could give. */
static void write_plane(const ff_table *t, size_t c, int same_scales, FILE *file)
{
    enum { N = 1024 };
    double v[N];
    unsigned char bytes[8 * N];
    for (size_t i = 0; i < t->n; i += N) {
        size_t n = t->n - i < N ? t->n - i : N;
        for (size_t k = 0; k < n; k++) {
            double stored = t->value[c * t->n + i + k];
            if (!t->valid[i + k])
                v[k] = stored_invalid(t, c, i + k, same_scales);
            else
                v[k] = same_scales ? stored : t->channels[c].scale * stored / channel_scale[c];
        }
        for (size_t k = 0; k < n; k++) ff_bytes_of_double(v[k], bytes + 8 * k);
        fwrite(bytes, 8, n, file);
    }
}

static ff_status write_merl(const char *path, const ff_table *t, ff_outputs *with, ff_error *err)
{
    ff_output out;
    ff_status status = check_writable(path, t, err);
    if (status == FF_OK) status = ff_output_open_with(path, with, &out, err);
    if (status != FF_OK) return status;
    for (int k = 0; k < 3; k++) {
        unsigned char b[4];
        ff_bytes_of_uint((uint64_t)dimension[k], 4, b);
        fwrite(b, 1, 4, out.file);
    }
    int same_scales = has_merl_scales(t);
    for (size_t c = 0; c < N_CHANNELS; c++) write_plane(t, c, same_scales, out.file);
    return ff_output_commit(&out, err);
}

const ff_format ff_format_merl = {
    .name = "merl",
    .title = "MERL BRDF database, 90 x 90 x 180 half/difference angles, RGB",
    .extensions = ".binary",
    .source = "Matusik, Pfister, Brand, McMillan 2003; www.merl.com/research/downloads/BRDF",
    .probe = probe,
    .holds = FF_HOLDS_INVALID | FF_HOLDS_DOUBLE,
    .read = read_merl,
    .layout = layout,
    .write = write_merl,
};
