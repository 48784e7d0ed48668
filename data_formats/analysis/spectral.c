/* Many wavelengths become a few channels: bands, sRGB, chosen channels, the mean. Each is a matrix of weights over the channels.
 *
 * sRGB: with W = S (x, y, z), S the illuminant, tabulated every 5 nm and linear between, X is the integral of W f over the
 * wavelength, by the trapezoidal rule on the nodes of the table and of the data together, with f linear between the wavelengths of
 * the data and constant beyond. On data at multiples of 5 nm that is the sum over the table that the CIE's 5 nm method prescribes.
 * Everything is divided by the Y of f = 1. The matrix to sRGB is made from the primaries of IEC 61966-2-1 and the white that this
 * integration gives D65, so that f = 1 is (1, 1, 1); under E, Bradford's matrix adapts the white first. */
#define _GNU_SOURCE
#include "spectral_struct.h"
#include "internal_cie1931.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include "base/internal_order.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double covered_least = 0.5; /* of Y */
static const double gap_noted = 20;      /* nm    */

typedef struct reduction {
    const ff_table *t;
    ff_error *err;
    size_t n_out;
    double *weight;      /* [n_out][t->n_channels]                                        */
    ff_channel *channel; /* [n_out] names                                                 */
    size_t *order;       /* [t->n_channels] channels by wavelength                        */
    double *nm;          /* [t->n_channels] ascending                                     */
    int pick;            /* 1: each channel is one of t's, unchanged: weights 0 and one 1 */
    ff_table said;       /* its note: sentences for the table that is made                 */
} reduction;

static ff_status no_memory(const reduction *r)
{
    return ff_error_set(r->err, FF_ERR_MEMORY, NULL, 0, -1, "no memory to reduce %zu channels", r->t->n_channels);
}

static ff_status syntax(const reduction *r, const char *found, size_t length, const char *expected)
{
    char quoted[FF_QUOTE];
    return ff_error_set(r->err, FF_ERR_SYNTAX, NULL, 0, -1, "found the reduction %s, expected %s", ff_quote(found, length, quoted),
                        expected);
}

static ff_status allocate(reduction *r, size_t n_out)
{
    r->n_out = n_out;
    if (n_out > SIZE_MAX / sizeof(double) / r->t->n_channels) return no_memory(r);
    r->weight = calloc(n_out * r->t->n_channels, sizeof *r->weight);
    r->channel = calloc(n_out, sizeof *r->channel);
    for (size_t k = 0; k < n_out && r->channel; k++) r->channel[k] = (ff_channel){.wavelength_nm = NAN, .scale = 1};
    return r->weight && r->channel ? FF_OK : no_memory(r);
}

static void release(reduction *r)
{
    free(r->weight);
    free(r->channel);
    free(r->order);
    free(r->nm);
}

/* ---- wavelengths ----------------------------------------------------------------------------- */

static ff_status sort_wavelengths(reduction *r)
{
    const ff_table *t = r->t;
    r->order = malloc(t->n_channels * sizeof *r->order);
    r->nm = malloc(t->n_channels * sizeof *r->nm);
    if (!r->order || !r->nm) return no_memory(r);
    for (size_t c = 0; c < t->n_channels; c++) {
        const double nm = t->channels[c].wavelength_nm;
        size_t k = c;
        if (!(isfinite(nm) && nm > 0))
            return ff_error_set(r->err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "found the channel '%s' without a wavelength, expected a wavelength of every channel",
                                t->channels[c].name);
        for (; k > 0 && r->nm[k - 1] > nm; k--) r->nm[k] = r->nm[k - 1], r->order[k] = r->order[k - 1];
        r->nm[k] = nm;
        r->order[k] = c;
        if (k > 0 && r->nm[k - 1] == nm)
            return ff_error_set(r->err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                                "found the channels '%s' and '%s' of one wavelength, expected one; choose by 'channels:'",
                                t->channels[r->order[k - 1]].name, t->channels[c].name);
    }
    return FF_OK;
}

/* Adds `amount` of f at nm to the weights of one channel: f is linear between wavelengths, constant beyond. *segment only grows. */
static void add_at(const reduction *r, double nm, double amount, size_t *segment, double *weight)
{
    const size_t n = r->t->n_channels;
    while (*segment + 2 < n && nm > r->nm[*segment + 1]) (*segment)++;
    const size_t s = *segment;
    double u = n > 1 ? (nm - r->nm[s]) / (r->nm[s + 1] - r->nm[s]) : 0;
    u = fmax(0, fmin(1, u));
    weight[r->order[s]] += (1 - u) * amount;
    if (n > 1) weight[r->order[s + 1]] += u * amount;
}

/* ---- bands ----------------------------------------------------------------------------------- */

static ff_status fill_band(reduction *r, size_t band, double from, double to)
{
    const size_t n = r->t->n_channels;
    const double first = r->nm[0], last = r->nm[n - 1], a = fmax(from, first), b = fmin(to, last);
    double *weight = r->weight + band * n;
    if (n == 1 && from <= first && first <= to) {
        weight[0] = 1;
        return FF_OK;
    }
    if (!(a < b))
        return ff_error_set(r->err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "found the band '%s' from %g to %g nm, expected one within the wavelengths of the table, %g to %g nm",
                            r->channel[band].name, from, to, first, last);
    for (size_t k = 0; k + 1 < n; k++) {
        const double p = fmax(a, r->nm[k]), q = fmin(b, r->nm[k + 1]);
        if (!(p < q)) continue;
        const double share = (q - p) / (b - a), u = (0.5 * (p + q) - r->nm[k]) / (r->nm[k + 1] - r->nm[k]);
        weight[r->order[k]] += (1 - u) * share;
        weight[r->order[k + 1]] += u * share;
    }
    if (a > from || b < to)
        ff_table_note(&r->said, "band '%s', %g to %g nm: the mean is over %g to %g nm, where the wavelengths are",
                      r->channel[band].name, from, to, a, b);
    return FF_OK;
}

/* "NAME=A-B" */
static ff_status read_band(reduction *r, size_t band, const char *text, size_t length)
{
    static const char expected[] = "bands NAME=A-B in nm, as in bands:blue=400-500,green=500-600";
    double from, to;
    char copy[2 * FF_CHANNEL_NAME];
    if (length >= sizeof copy) return syntax(r, text, length, expected);
    memcpy(copy, text, length);
    copy[length] = '\0';
    char *equals = strchr(copy, '=');
    if (!equals || equals == copy || equals - copy >= FF_CHANNEL_NAME) return syntax(r, text, length, expected);
    *equals = '\0';
    const char *end = ff_number_read(equals + 1, &from);
    end = end && *end == '-' ? ff_number_read(end + 1, &to) : NULL;
    if (!end || *end) return syntax(r, text, length, expected);
    if (!(from >= 0 && from < to && isfinite(to)))
        return ff_error_set(r->err, FF_ERR_RANGE, NULL, 0, -1, "found the band '%s' from %g to %g nm, expected from less to more",
                            copy, from, to);
    for (size_t k = 0; k < band; k++)
        if (strcmp(r->channel[k].name, copy) == 0) return syntax(r, text, length, "each name of a band once");
    strcpy(r->channel[band].name, copy);
    return fill_band(r, band, from, to);
}

static size_t count_items(const char *text)
{
    size_t n = 1;
    for (; *text; text++) n += *text == ',';
    return n;
}

static ff_status make_bands(reduction *r, const char *text)
{
    ff_status status = sort_wavelengths(r);
    if (status == FF_OK) status = allocate(r, count_items(text));
    for (size_t band = 0; band < r->n_out && status == FF_OK; band++) {
        size_t length = strcspn(text, ",");
        status = read_band(r, band, text, length);
        text += length + (text[length] == ',');
    }
    return status;
}

/* ---- sRGB ------------------------------------------------------------------------------------ */

/* S (x, y, z) of the illuminant, linear between the nodes of the table. */
static void weighting(double nm, int equal_energy, double w[3])
{
    const double at = (nm - FF_CIE_FIRST_NM) / FF_CIE_STEP_NM;
    const int k = (int)fmax(0, fmin(FF_CIE_N - 2, floor(at)));
    const double u = at - k, s0 = equal_energy ? 100 : ff_cie_d65[k], s1 = equal_energy ? 100 : ff_cie_d65[k + 1];
    for (int c = 0; c < 3; c++) w[c] = (1 - u) * s0 * ff_cie1931[k][c] + u * s1 * ff_cie1931[k + 1][c];
}

static void white_of(int equal_energy, double xyz[3])
{
    xyz[0] = xyz[1] = xyz[2] = 0;
    for (int k = 0; k < FF_CIE_N; k++) {
        double w[3];
        weighting(FF_CIE_FIRST_NM + FF_CIE_STEP_NM * k, equal_energy, w);
        for (int c = 0; c < 3; c++) xyz[c] += w[c] * (k == 0 || k == FF_CIE_N - 1 ? 0.5 : 1);
    }
    for (int c = 0; c < 3; c += 2) xyz[c] /= xyz[1];
    xyz[1] = 1;
}

static void multiply(const double a[3][3], const double b[3][3], double out[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
}

static void apply(const double a[3][3], const double v[3], double out[3])
{
    for (int i = 0; i < 3; i++) out[i] = a[i][0] * v[0] + a[i][1] * v[1] + a[i][2] * v[2];
}

static void invert(const double a[3][3], double out[3][3])
{
    double cofactor[3][3];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
            cofactor[i][j] = a[i1][j1] * a[i2][j2] - a[i1][j2] * a[i2][j1];
        }
    const double determinant = a[0][0] * cofactor[0][0] + a[0][1] * cofactor[0][1] + a[0][2] * cofactor[0][2];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) out[i][j] = cofactor[j][i] / determinant;
}

/* XYZ to linear RGB of the primaries of sRGB, `white` being (1, 1, 1). */
static void to_srgb(const double white[3], double out[3][3])
{
    static const double primary[3][2] = {{0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06}};
    double columns[3][3], inverse[3][3], amount[3];
    for (int c = 0; c < 3; c++) {
        columns[0][c] = primary[c][0] / primary[c][1];
        columns[1][c] = 1;
        columns[2][c] = (1 - primary[c][0] - primary[c][1]) / primary[c][1];
    }
    invert(columns, inverse);
    apply(inverse, white, amount);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) columns[i][j] *= amount[j];
    invert(columns, out);
}

/* Von Kries in the cone space of Lam 1985 ("Bradford"), as ICC profiles use it. */
static void adaptation(const double from[3], const double to[3], double out[3][3])
{
    static const double bradford[3][3] = {{0.8951, 0.2664, -0.1614}, {-0.7502, 1.7135, 0.0367}, {0.0389, -0.0685, 1.0296}};
    double inverse[3][3], scaled[3][3], a[3], b[3];
    apply(bradford, from, a);
    apply(bradford, to, b);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) scaled[i][j] = b[i] / a[i] * bradford[i][j];
    invert(bradford, inverse);
    multiply(inverse, scaled, out);
}

static void xyz_to_rgb(int equal_energy, double out[3][3])
{
    double d65[3], e[3], rgb[3][3], adapt[3][3];
    white_of(0, d65);
    to_srgb(d65, rgb);
    memcpy(out, rgb, sizeof rgb);
    if (!equal_energy) return;
    white_of(1, e);
    adaptation(e, d65, adapt);
    multiply(rgb, adapt, out);
}

/* Nodes of the table and of the data within it, ascending, each once; *n of them. */
static double *all_nodes(const reduction *r, size_t *n)
{
    const double last = FF_CIE_FIRST_NM + FF_CIE_STEP_NM * (FF_CIE_N - 1);
    double *node = malloc((FF_CIE_N + r->t->n_channels) * sizeof *node);
    size_t count = 0, kept = 1;
    if (!node) return NULL;
    for (int k = 0; k < FF_CIE_N; k++) node[count++] = FF_CIE_FIRST_NM + FF_CIE_STEP_NM * k;
    for (size_t c = 0; c < r->t->n_channels; c++)
        if (r->nm[c] > FF_CIE_FIRST_NM && r->nm[c] < last) node[count++] = r->nm[c];
    qsort(node, count, sizeof *node, ff_ascending);
    for (size_t k = 1; k < count; k++)
        if (node[k] > node[kept - 1]) node[kept++] = node[k];
    *n = kept;
    return node;
}

/* Weights of X, Y, Z over the channels into xyz [3][n_channels], those of f = 1 being `white` with Y = 1; outside[c]: the share of
 * what lies beyond the wavelengths of the data. */
static ff_status integrate(const reduction *r, int equal_energy, double *xyz, double outside[3])
{
    const size_t n = r->t->n_channels;
    size_t n_nodes, segment[3] = {0, 0, 0};
    double total[3] = {0, 0, 0};
    double *node = all_nodes(r, &n_nodes);
    if (!node) return no_memory(r);
    for (int c = 0; c < 3; c++) outside[c] = 0;
    for (size_t k = 0; k < n_nodes; k++) {
        const double below = k ? node[k] - node[k - 1] : 0, above = k + 1 < n_nodes ? node[k + 1] - node[k] : 0;
        double w[3];
        weighting(node[k], equal_energy, w);
        for (int c = 0; c < 3; c++) {
            const double amount = 0.5 * (below + above) * w[c];
            total[c] += amount;
            if (node[k] < r->nm[0] || node[k] > r->nm[n - 1]) outside[c] += amount;
            add_at(r, node[k], amount, &segment[c], xyz + (size_t)c * n);
        }
    }
    for (size_t k = 0; k < 3 * n; k++) xyz[k] /= total[1];
    for (int c = 0; c < 3; c++) outside[c] /= total[c];
    free(node);
    return FF_OK;
}

static void note_coverage(reduction *r, const double outside[3])
{
    double gap = 0;
    for (size_t k = 0; k + 1 < r->t->n_channels; k++)
        if (r->nm[k] < 730 && r->nm[k + 1] > 380) gap = fmax(gap, r->nm[k + 1] - r->nm[k]);
    if (fmax(outside[0], fmax(outside[1], outside[2])) > 5e-4)
        ff_table_note(&r->said,
                      "beyond %g to %g nm lie %.1f %% of X, %.1f %% of Y and %.1f %% of Z: f is taken to stay as at the ends",
                      r->nm[0], r->nm[r->t->n_channels - 1], 100 * outside[0], 100 * outside[1], 100 * outside[2]);
    if (gap > gap_noted) ff_table_note(&r->said, "wavelengths are up to %g nm apart: f is taken to be linear between", gap);
}

static ff_status make_srgb(reduction *r, int equal_energy)
{
    static const char *const name[3] = {"r", "g", "b"};
    const size_t n = r->t->n_channels;
    double matrix[3][3], outside[3];
    ff_status status = sort_wavelengths(r);
    if (status == FF_OK) status = allocate(r, 3);
    if (status != FF_OK) return status;
    double *xyz = calloc(3 * n, sizeof *xyz);
    status = xyz ? integrate(r, equal_energy, xyz, outside) : no_memory(r);
    if (status == FF_OK && 1 - outside[1] < covered_least)
        status =
            ff_error_set(r->err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                         "found wavelengths from %g to %g nm, which have %.0f %% of what the eye sees, expected at least %.0f %%",
                         r->nm[0], r->nm[n - 1], 100 * (1 - outside[1]), 100 * covered_least);
    if (status == FF_OK) {
        xyz_to_rgb(equal_energy, matrix);
        for (int k = 0; k < 3; k++) {
            double *weight = r->weight + (size_t)k * n, sum = 0;
            for (size_t c = 0; c < n; c++) {
                weight[c] = matrix[k][0] * xyz[c] + matrix[k][1] * xyz[n + c] + matrix[k][2] * xyz[2 * n + c];
                sum += weight[c];
            }
            for (size_t c = 0; c < n; c++) weight[c] /= sum; /* 1 but for rounding */
            strcpy(r->channel[k].name, name[k]);
        }
        note_coverage(r, outside);
    }
    free(xyz);
    return status;
}

/* ---- the rest -------------------------------------------------------------------------------- */

static ff_status make_mean(reduction *r)
{
    ff_status status = allocate(r, 1);
    if (status != FF_OK) return status;
    strcpy(r->channel[0].name, "mean");
    for (size_t c = 0; c < r->t->n_channels; c++) r->weight[c] = 1 / (double)r->t->n_channels;
    return FF_OK;
}

static ff_status pick_channels(reduction *r, const char *text)
{
    char quoted[FF_QUOTE];
    r->pick = 1;
    ff_status status = allocate(r, count_items(text));
    for (size_t k = 0; k < r->n_out && status == FF_OK; k++) {
        char name[FF_CHANNEL_NAME] = "";
        size_t length = strcspn(text, ",");
        if (length < sizeof name) memcpy(name, text, length);
        int c = length && length < sizeof name ? ff_table_channel_find(r->t, name) : -1;
        if (c < 0)
            return ff_error_set(r->err, FF_ERR_UNKNOWN, NULL, 0, -1,
                                "found the channel %s, expected one of the %zu of the table, '%s' to '%s'",
                                ff_quote(text, length, quoted), r->t->n_channels, r->t->channels[0].name,
                                r->t->channels[r->t->n_channels - 1].name);
        for (size_t j = 0; j < k; j++)
            if (strcmp(r->channel[j].name, name) == 0) return syntax(r, text, length, "each channel once");
        r->channel[k] = r->t->channels[c];
        r->weight[k * r->t->n_channels + (size_t)c] = 1;
        text += length + (text[length] == ',');
    }
    return status;
}

static ff_status make_weights(reduction *r, const char *text)
{
    if (strncmp(text, "bands:", 6) == 0) return make_bands(r, text + 6);
    if (strncmp(text, "channels:", 9) == 0) return pick_channels(r, text + 9);
    if (strcmp(text, "srgb") == 0 || strcmp(text, "srgb:d65") == 0) return make_srgb(r, 0);
    if (strcmp(text, "srgb:e") == 0) return make_srgb(r, 1);
    if (strcmp(text, "mean") == 0) return make_mean(r);
    return syntax(r, text, strlen(text), "bands:NAME=A-B,..., srgb, srgb:d65, srgb:e, channels:NAME,... or mean");
}

/* Plane k of the result: sums over the planes of t that have a weight; of sigmas, the root of the sum of squares. */
static void combine(const reduction *r, size_t k, const double *from, int squares, double *to)
{
    const ff_table *t = r->t;
    for (size_t c = 0; c < t->n_channels; c++) {
        const double weight = r->weight[k * t->n_channels + c] * (r->pick ? 1 : t->channels[c].scale);
        const double *plane = from + c * t->n;
        if (weight == 0) continue;
        if (r->pick) {
            memcpy(to, plane, t->n * sizeof *to);
        } else if (squares) {
            for (size_t i = 0; i < t->n; i++) to[i] += weight * plane[i] * (weight * plane[i]);
        } else {
            for (size_t i = 0; i < t->n; i++) to[i] += weight * plane[i];
        }
    }
    if (squares && !r->pick)
        for (size_t i = 0; i < t->n; i++) to[i] = sqrt(to[i]);
    for (size_t i = 0; i < t->n; i++)
        if (!t->valid[i]) to[i] = 0;
}

/* Everything of t but its channels and what its format keeps. */
static ff_status copy_frame(const reduction *r, ff_table *out)
{
    const ff_table *t = r->t;
    ff_status status = ff_table_init(t->n, r->n_out, t->grid, t->sigma != NULL, t->weight != NULL, out, r->err);
    if (status != FF_OK) return status;
    memcpy(out->format, t->format, sizeof out->format);
    memcpy(out->note, t->note, sizeof out->note);
    memcpy(out->note_hint, t->note_hint, sizeof out->note_hint);
    memcpy(out->valid, t->valid, t->n);
    if (t->weight) memcpy(out->weight, t->weight, t->n * sizeof *t->weight);
    for (int k = 0; k < 4 && !t->grid; k++) memcpy(out->angle[k], t->angle[k], t->n * sizeof *t->angle[k]);
    out->radians_per_unit = t->radians_per_unit;
    out->isotropic = t->isotropic;
    out->quantity = t->quantity;
    out->angles_are_open = t->angles_are_open;
    out->quantity_is_open = t->quantity_is_open;
    out->azimuth_from_mirror = t->azimuth_from_mirror;
    if (t->cells) out->cells = t->cells->share(t->cells);
    if (t->kept_incidence && t->kept_share) { /* the quadrature, without what would write the channels of the file again */
        out->kept = t->kept_share(t->kept);
        if (!out->kept) return no_memory(r);
        out->kept_free = t->kept_free;
        out->kept_incidence = t->kept_incidence;
    }
    out->axes.kind = t->axes.kind;
    for (int k = 0; k < 4 && t->axes.kind != FF_AXES_NONE; k++) {
        out->axes.n[k] = t->axes.n[k];
        out->axes.node[k] = malloc(t->axes.n[k] * sizeof(double));
        if (!out->axes.node[k]) return no_memory(r);
        memcpy(out->axes.node[k], t->axes.node[k], t->axes.n[k] * sizeof(double));
    }
    return FF_OK;
}

static ff_status make_table(const reduction *r, ff_table *out)
{
    ff_table t = {0};
    ff_status status = copy_frame(r, &t);
    for (size_t k = 0; k < r->n_out && status == FF_OK; k++) {
        t.channels[k] = r->channel[k];
        combine(r, k, r->t->value, 0, t.value + k * t.n);
        if (t.sigma) combine(r, k, r->t->sigma, 1, t.sigma + k * t.n);
    }
    if (status == FF_OK) status = ff_table_count(&t, NULL, r->err);
    if (status == FF_OK && r->said.note[0]) ff_table_note(&t, "%s", r->said.note);
    if (status == FF_OK)
        *out = t;
    else
        ff_table_clear(&t);
    return status;
}

/* ---- colours --------------------------------------------------------------------------------- */

/* The channel of a name; n where there is none. */
static size_t channel_named(size_t n, const ff_channel *channel, const char *name)
{
    size_t c = 0;
    while (c < n && strcmp(channel[c].name, name)) c++;
    return c;
}

/* Three channels that are red, green and blue: by their names, or in this order where neither these nor wavelengths tell. */
static int are_colours(size_t n, const ff_channel *channel, int has_wavelengths, size_t at[3])
{
    static const char *const names[3] = {"r", "g", "b"};
    int named = 1;
    for (int k = 0; k < 3; k++) named &= (at[k] = channel_named(n, channel, names[k])) < n;
    if (named) return 1;
    for (size_t k = 0; k < 3; k++) at[k] = k;
    return n == 3 && !has_wavelengths;
}

/* By the observer, where the wavelengths have enough of what the eye sees. */
static ff_status observed(size_t n, const ff_channel *channel, double *matrix, ff_error *err)
{
    ff_channel *own = malloc(n * sizeof *own);
    const ff_table t = {.n_channels = n, .channels = own};
    reduction r = {.t = &t, .err = err};
    ff_status status = FF_ERR_MEMORY;
    if (own) {
        memcpy(own, channel, n * sizeof *own);
        status = make_srgb(&r, 0);
    }
    if (status == FF_OK) memcpy(matrix, r.weight, 3 * n * sizeof *matrix);
    release(&r);
    free(own);
    return status;
}

ff_status ff_spectral_colours(size_t n, const ff_channel *channel, double *matrix, ff_error *err)
{
    size_t at[3];
    int has_wavelengths = 1;
    for (size_t c = 0; c < n; c++) has_wavelengths &= isfinite(channel[c].wavelength_nm) && channel[c].wavelength_nm > 0;
    if (are_colours(n, channel, has_wavelengths, at)) {
        for (size_t k = 0; k < 3 * n; k++) matrix[k] = k % n == at[k / n];
        return FF_OK;
    }
    if (n >= 3 && has_wavelengths) {
        ff_error why = {0};
        const ff_status status = observed(n, channel, matrix, &why);
        if (status == FF_ERR_MEMORY && err) *err = why;
        if (status == FF_OK || status == FF_ERR_MEMORY) return status;
    }
    for (size_t k = 0; k < 3 * n; k++) matrix[k] = 1 / (double)n;
    return FF_OK;
}

ff_status ff_table_reduce_into(const ff_table *t, const char *text, ff_table *out, ff_error *err)
{
    reduction r = {.t = t, .err = err};
    ff_status status = make_weights(&r, text);
    if (status == FF_OK) status = make_table(&r, out);
    release(&r);
    return status;
}

ff_status ff_table_reduce(const ff_table *t, const char *text, ff_table **out, ff_error *err)
{
    ff_table made;
    const ff_status status = ff_table_reduce_into(t, text, &made, err);
    return status ? status : ff_table_move(&made, out, err);
}
