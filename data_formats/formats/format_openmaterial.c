/* ASAM OpenMATERIAL 3D, look-up table of a BRDF (.xompt): JSON, by its schema material_brdf_schema.json, version 1.0.0.
 *
 *     {"metadata": {...},
 *      "brdf": {"wavelengths": [9.05e-07],                                         m
 *               "lookupTable": [[9.05e-07, 0.5, 0.2, 3.14159, 0.013], ...]}}       m, rad, rad, rad, 1/sr; ascending, the first
 * slowest
 *
 * A row has wavelength, incident and exit angle from the normal, exit azimuth relative to the incident one (which is 0), and the
 * BRDF. That azimuth is taken for one between directions that both point away from the surface: mirror reflection is at pi, as
 * elsewhere here; the schema does not say. A null was not measured; as a wavelength, it is not known. */
#define _GNU_SOURCE
#include "base/internal_json.h"
#include "base/internal_number.h"
#include "base/internal_output.h"
#include "data_formats/formats/csv/internal_csv.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const char schema[] =
    "https://raw.githubusercontent.com/asam-ev/OpenMATERIAL-3D/refs/tags/v1.0.0/schemas/material_brdf_schema.json";
#define THETA_MOST 1.570796 /* as the schema rounds pi / 2 and 2 pi */
#define PHI_MOST   6.283185

static int probe(const unsigned char *head, size_t n, int64_t file_size)
{
    (void)file_size;
    size_t k = 0;
    while (k < n && (head[k] == ' ' || head[k] == '\n' || head[k] == '\t' || head[k] == '\r')) k++;
    if (k == n || head[k] != '{') return 0;
    const int table = memmem(head, n, "\"lookupTable\"", 13) != NULL, of_asam = memmem(head, n, "OpenMATERIAL", 12) != NULL;
    const int version = memmem(head, n, "\"openMaterial3dVersion\"", 23) != NULL;
    return table && (of_asam || version) ? 97 : version ? 60 : 0;
}

/* ---- reading --------------------------------------------------------------------------------------------- */

typedef struct xompt {
    const char *path;
    ff_error *err;
    ff_rows rows;
    size_t n_known; /* rows with a wavelength */
} xompt;

static ff_status bad_row(const xompt *x, size_t row, const char *what, double found, const char *expected)
{
    return ff_error_set(x->err, FF_ERR_DATA, x->path, 0, -1, "lookupTable: row %zu: found the %s %g, expected %s", row + 1, what,
                        found, expected);
}

static ff_status read_row(xompt *x, const ff_json_node *node, size_t k)
{
    double v[5];
    const ff_json_node *cell = ff_json_first(node);
    if (ff_json_kind_of(node) != FF_JSON_ARRAY || ff_json_count(node) != 5)
        return ff_error_set(x->err, FF_ERR_FORMAT, x->path, 0, -1, "lookupTable: row %zu: found %zu numbers, expected 5", k + 1,
                            ff_json_count(node));
    for (int j = 0; j < 5; j++, cell = ff_json_next(cell)) v[j] = ff_json_real(cell);
    for (int j = 1; j < 4; j++)
        if (!isfinite(v[j])) return bad_row(x, k, "angle", v[j], "radians");
    if (!(v[1] >= 0 && v[1] <= pi / 2 + 1e-6)) return bad_row(x, k, "incident angle", v[1], "radians from 0 to 1.570796");
    if (!(v[2] >= 0 && v[2] <= pi / 2 + 1e-6)) return bad_row(x, k, "exit angle", v[2], "radians from 0 to 1.570796");
    if (!isnan(v[0]) && !(v[0] > 0 && v[0] < 1)) return bad_row(x, k, "wavelength", v[0], "meters");
    double *row = ff_rows_add(&x->rows);
    if (!row) return ff_error_set(x->err, FF_ERR_MEMORY, x->path, 0, -1, "no memory for %zu rows", k + 1);
    row[0] = v[1];
    row[2] = v[2];
    row[3] = v[3];
    row[4] = v[4];
    row[5] = isnan(v[0]) ? 1 : 1e9 * v[0];
    x->n_known += isnan(v[0]) ? 0 : 1;
    return FF_OK;
}

static ff_status read_rows(xompt *x, const ff_json_node *table)
{
    size_t k = 0;
    ff_status status = FF_OK;
    if (ff_json_kind_of(table) != FF_JSON_ARRAY || ff_json_count(table) == 0)
        return ff_error_set(x->err, FF_ERR_FORMAT, x->path, 0, -1, "found no rows in brdf.lookupTable, expected one at least");
    for (const ff_json_node *row = ff_json_first(table); row && status == FF_OK; row = ff_json_next(row))
        status = read_row(x, row, k++);
    if (status == FF_OK && x->n_known && x->n_known < x->rows.n)
        return ff_error_set(x->err, FF_ERR_DATA, x->path, 0, -1,
                            "lookupTable: found %zu rows of %zu without a wavelength, expected none or all", x->rows.n - x->n_known,
                            x->rows.n);
    return status;
}

/* The values alone, of rows that say no wavelength. */
static ff_status without_wavelength(const ff_table *rows, ff_table *out, ff_error *err)
{
    ff_table t;
    const ff_status status = ff_table_init(rows->n, 1, NULL, 0, 0, &t, err);
    if (status != FF_OK) return status;
    for (int k = 0; k < 4; k++) memcpy(t.angle[k], rows->angle[k], t.n * sizeof(double));
    memcpy(t.value, rows->value, t.n * sizeof(double));
    memcpy(t.valid, rows->valid, t.n);
    strcpy(t.channels[0].name, "f");
    *out = t;
    return FF_OK;
}

static ff_status make_table(xompt *x, const ff_read_options *o, ff_table *out)
{
    ff_table rows, t;
    ff_status status = ff_rows_to_table(&x->rows, 2, 0, 0, &rows, x->err);
    if (status != FF_OK) return status;
    rows.radians_per_unit = 1;
    status = x->n_known ? ff_csv_pivot(&rows, o->part, x->path, &t, x->err) : without_wavelength(&rows, &t, x->err);
    ff_table_clear(&rows);
    if (status != FF_OK) return status;
    strcpy(t.format, "openmaterial");
    t.radians_per_unit = 1;
    t.isotropic = 1;
    ff_table_note(&t, "the exit azimuth is taken as counted from the direction of the light: mirror reflection is at 180 degrees");
    return ff_table_hand_out(&t, x->path, out, x->err);
}

static ff_status read_openmaterial(const char *path, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_json_tree *tree;
    xompt x = {.path = path, .err = err, .rows = {.width = ff_rows_width(2, 0, 0)}};
    ff_status status = ff_json_read(path, &tree, err);
    if (status != FF_OK) return status;
    const ff_json_node *brdf = ff_json_member(ff_json_root(tree), "brdf");
    if (ff_json_kind_of(brdf) != FF_JSON_OBJECT)
        status = ff_error_set(err, FF_ERR_FORMAT, path, 0, -1, "found no object \"brdf\", expected one with \"lookupTable\"");
    else
        status = read_rows(&x, ff_json_member(brdf, "lookupTable"));
    ff_json_free(tree);
    if (status == FF_OK) status = make_table(&x, o, out);
    ff_rows_free(&x.rows);
    return status;
}

/* ---- writing --------------------------------------------------------------------------------------------- */

typedef struct row {
    double angle[3]; /* incident, exit, azimuth */
    size_t sample;
} row;

static int by_angles(const void *a, const void *b)
{
    const row *x = a, *y = b;
    for (int k = 0; k < 3; k++)
        if (x->angle[k] != y->angle[k]) return x->angle[k] < y->angle[k] ? -1 : 1;
    return x->sample < y->sample ? -1 : x->sample > y->sample;
}

static ff_status check_writable(const char *path, const ff_table *t, ff_error *err)
{
    const ff_status status = ff_table_check(t, path, err);
    if (status != FF_OK) return status;
    if (!t->isotropic && !t->grid && !ff_table_one_incidence_azimuth(t))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a file of this format knows no azimuth of incidence, and these data have several; write csv, "
                            "anisotropicbsdf or zemax");
    for (size_t c = 0; c < t->n_channels; c++)
        if (t->n_channels > 1 && !isfinite(t->channels[c].wavelength_nm))
            return ff_error_set(
                err, FF_ERR_UNSUPPORTED, path, 0, -1,
                "channel '%s' is no wavelength, and a file of this format tells channels by these; take one, or their mean",
                t->channels[c].name);
    if (t->sigma)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "a file of this format has no room for the standard deviations of this table; write csv");
    return FF_OK;
}

/* Rows above the horizon in the order of the schema. Their number in *n. */
static row *sorted_rows(const ff_table *t, size_t *n)
{
    row *rows = malloc(t->n * sizeof *rows);
    size_t used = 0;
    for (size_t i = 0; i < t->n && rows; i++) {
        double a[4], *const planes[4] = {a, a + 1, a + 2, a + 3};
        ff_table_angles(t, 1, i, 1, planes);
        double apart = a[3] - a[1];
        for (int k = 0; k < 4; k += 2)
            if (a[k] < 0) a[k] = -a[k], apart += pi; /* a negative angle is on the other side */
        if (a[0] > pi / 2 + 1e-9 || a[2] > pi / 2 + 1e-9) continue;
        apart -= 2 * pi * floor(apart / (2 * pi));
        rows[used++] = (row){{fmin(a[0], THETA_MOST), fmin(a[2], THETA_MOST), fmin(fmax(apart, 0), PHI_MOST)}, i};
    }
    if (rows) qsort(rows, used, sizeof *rows, by_angles);
    *n = used;
    return rows;
}

static void put(FILE *file, double v)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
}

static void mix(uint64_t h[2], double v)
{
    uint64_t u;
    memcpy(&u, &v, sizeof u);
    for (int k = 0; k < 2; k++) h[k] = (h[k] ^ u) * 0x100000001B3u + (uint64_t)k, h[k] ^= h[k] >> 29;
}

/* What is written makes its name: the same data have the same. */
static void put_uuid(const ff_table *t, const row *rows, size_t n, FILE *file)
{
    uint64_t h[2] = {0xCBF29CE484222325u, 0x9E3779B97F4A7C15u};
    for (size_t i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++) mix(h, rows[i].angle[k]);
        for (size_t c = 0; c < t->n_channels; c++)
            mix(h, t->valid[rows[i].sample] ? t->channels[c].scale * t->value[c * t->n + rows[i].sample] : -1);
    }
    fprintf(file, "%08x-%04x-8%03x-a%03x-%012llx", (unsigned)(h[0] >> 32), (unsigned)(h[0] >> 16) & 0xFFFFu,
            (unsigned)h[0] & 0xFFFu, (unsigned)(h[1] >> 48) & 0xFFFu, (unsigned long long)h[1] & 0xFFFFFFFFFFFFull);
}

static void write_head(const ff_table *t, const row *rows, size_t n_rows, FILE *file)
{
    fprintf(file, "{\n  \"$schema\": \"%s\",\n  \"metadata\": {\n    \"name\": \"Measured reflectance\",\n    \"uuid\": \"",
            schema);
    put_uuid(t, rows, n_rows, file);
    fputs("\",\n    \"materialVersion\": \"1.0.0\",\n    \"openMaterial3dVersion\": \"1.0.0\",\n    \"copyrights\": [\"not "
          "stated\"],\n"
          "    \"license\": \"not stated\",\n    \"authors\": [\"not stated\"],\n    \"sources\": \"measurement\"\n  },\n"
          "  \"brdf\": {\n    \"wavelengths\": [",
          file);
    for (size_t c = 0, n = 0; c < t->n_channels; c++) {
        if (!isfinite(t->channels[c].wavelength_nm)) continue;
        if (n++) fputs(", ", file);
        put(file, t->channels[c].wavelength_nm / 1e9);
    }
    fputs("],\n    \"lookupTable\": [\n", file);
}

static void write_row(const ff_table *t, size_t c, const row *r, int more, FILE *file)
{
    const double nm = t->channels[c].wavelength_nm;
    fputs("      [", file);
    if (isfinite(nm))
        put(file, nm / 1e9);
    else
        fputs("null", file);
    for (int k = 0; k < 3; k++) {
        fputs(", ", file);
        put(file, r->angle[k]);
    }
    fputs(", ", file);
    if (t->valid[r->sample])
        put(file, t->channels[c].scale * t->value[c * t->n + r->sample]);
    else
        fputs("null", file);
    fputs(more ? "],\n" : "]\n", file);
}

static int by_wavelength(const void *a, const void *b)
{
    const ff_channel *const *x = a, *const *y = b;
    return ((*x)->wavelength_nm > (*y)->wavelength_nm) - ((*x)->wavelength_nm < (*y)->wavelength_nm);
}

static ff_status write_openmaterial(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err)
{
    ff_output out;
    size_t n;
    ff_status status = check_writable(path, t, err);
    if (status != FF_OK) return status;
    row *rows = sorted_rows(t, &n);
    const ff_channel **order = malloc(t->n_channels * sizeof *order);
    status = rows && order ? ff_output_open_with(path, with, &out, err)
                           : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory to sort %zu rows", t->n);
    if (status == FF_OK) {
        for (size_t c = 0; c < t->n_channels; c++) order[c] = &t->channels[c];
        qsort(order, t->n_channels, sizeof *order, by_wavelength);
        write_head(t, rows, n, out.file);
        for (size_t c = 0; c < t->n_channels; c++)
            for (size_t i = 0; i < n; i++)
                write_row(t, (size_t)(order[c] - t->channels), &rows[i], c + 1 < t->n_channels || i + 1 < n, out.file);
        fputs("    ]\n  }\n}\n", out.file);
        status = ff_output_commit(&out, err);
    }
    free(rows);
    free(order);
    return status;
}

const ff_format ff_format_openmaterial = {
    .name = "openmaterial",
    .title = "ASAM OpenMATERIAL 3D look-up table: any directions, wavelengths",
    .extensions = ".xompt",
    .source = "ASAM OpenMATERIAL 3D 1.0.0, material_brdf_schema.json",
    .probe = probe,
    .reads = FF_READS_PART,
    .holds = FF_HOLDS_INVALID | FF_HOLDS_DOUBLE | FF_HOLDS_MANY,
    .read = read_openmaterial,
    .write = write_openmaterial,
};
