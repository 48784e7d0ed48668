/* The table: memory, directions, values, weights. */
#define _GNU_SOURCE
#include "internal_directions.h"
#include "internal_table.h"
#include "base/internal_number.h"
#include <locale.h>
#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

void ff_table_clear(ff_table *t)
{
    if (!t) return;
    free(t->channels);
    free(t->value);
    free(t->sigma);
    free(t->valid);
    for (int k = 0; k < 4; k++) free(t->angle[k]);
    for (int k = 0; k < 4; k++) free(t->axes.node[k]);
    free(t->weight);
    if (t->kept && t->kept_free) t->kept_free(t->kept);
    if (t->cells) t->cells->release(t->cells);
    memset(t, 0, sizeof *t);
}

/* Zeros whose pages nobody has touched yet; large pages, where the system has them, halve the time to fill a plane. */
static double *new_plane(size_t n)
{
    double *plane = calloc(n, sizeof *plane);
#ifdef MADV_HUGEPAGE
    const size_t large = (size_t)1 << 21, size = n * sizeof *plane, before = (size_t)(-(uintptr_t)plane & (large - 1));
    if (plane && size >= before + large) (void)madvise((char *)plane + before, (size - before) & ~(large - 1), MADV_HUGEPAGE);
#endif
    return plane;
}

static int allocate(ff_table *t, int with_sigma, int with_weight)
{
    size_t cells = t->n * t->n_channels;
    t->channels = calloc(t->n_channels, sizeof *t->channels);
    t->value = new_plane(cells);
    t->valid = malloc(t->n);
    if (!t->channels || !t->value || !t->valid) return 0;
    if (with_sigma && !(t->sigma = new_plane(cells))) return 0;
    if (with_weight && !(t->weight = new_plane(t->n))) return 0;
    for (int k = 0; k < 4 && !t->grid; k++)
        if (!(t->angle[k] = new_plane(t->n))) return 0;
    return 1;
}

ff_status ff_table_init(size_t n, size_t n_channels, const ff_grid *grid, int with_sigma, int with_weight, ff_table *out,
                        ff_error *err)
{
    if (n == 0 || n_channels == 0)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "a table of %zu samples and %zu channels, expected at least one of each", n, n_channels);
    if (grid && n != grid->n)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%zu samples on the grid '%s', expected %zu", n, grid->name, grid->n);
    ff_table t = {.n = n, .n_channels = n_channels, .grid = grid, .radians_per_unit = 1, .isotropic = grid ? grid->isotropic : 0};
    if (n_channels > SIZE_MAX / sizeof(ff_channel) || n > SIZE_MAX / sizeof(double) / n_channels ||
        !allocate(&t, with_sigma, with_weight)) {
        ff_table_clear(&t);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a table of %zu samples and %zu channels", n,
                            n_channels);
    }
    memset(t.valid, 1, n);
    for (size_t c = 0; c < n_channels; c++) {
        snprintf(t.channels[c].name, sizeof t.channels[c].name, "c%zu", c);
        t.channels[c].wavelength_nm = NAN;
        t.channels[c].scale = 1;
    }
    *out = t;
    return FF_OK;
}

size_t ff_table_there(const ff_table *t, size_t first, size_t count)
{
    const size_t left = first < t->n ? t->n - first : 0;
    return count < left ? count : left;
}

void ff_table_directions(const ff_table *t, size_t first, size_t count, double *const planes[6])
{
    count = ff_table_there(t, first, count);
    if (count == 0) return;
    if (t->grid) {
        t->grid->directions(first, count, planes);
        return;
    }
    const double *const angle[4] = {t->angle[0] + first, t->angle[1] + first, t->angle[2] + first, t->angle[3] + first};
    FF_ISA_PICK(FF_ISA_BEST, ff_directions)(t->radians_per_unit, angle, count, planes);
}

static void scaled(double scale, const double *stored, size_t count, double *out)
{
    for (size_t k = 0; k < count; k++) out[k] = scale * stored[k];
}

/* Of a plane [n_channels][n]: nothing of a channel, or samples, that are not there. */
static void of_channel(const ff_table *t, const double *plane, size_t c, size_t first, size_t count, double *out)
{
    count = ff_table_there(t, first, count);
    if (c < t->n_channels && plane && count > 0) scaled(t->channels[c].scale, plane + c * t->n + first, count, out);
}

void ff_table_values(const ff_table *t, size_t c, size_t first, size_t count, double *out)
{
    of_channel(t, t->value, c, first, count, out);
}

void ff_table_sigmas(const ff_table *t, size_t c, size_t first, size_t count, double *out)
{
    of_channel(t, t->sigma, c, first, count, out);
}

int ff_table_has_weights(const ff_table *t)
{
    return t->grid || t->weight;
}

/* A weight plane, which somebody filled on purpose, goes before the grid's own weights. */
void ff_table_weights(const ff_table *t, size_t first, size_t count, double *out)
{
    count = ff_table_there(t, first, count);
    if (count == 0) return;
    if (t->weight)
        memcpy(out, t->weight + first, count * sizeof *out);
    else if (t->grid)
        t->grid->weights(first, count, out);
}

int ff_table_channel_find(const ff_table *t, const char *name)
{
    for (size_t c = 0; c < t->n_channels; c++)
        if (strcmp(t->channels[c].name, name) == 0) return (int)c;
    return -1;
}

/* ---- shared by the formats ------------------------------------------------------------------- */

/* Numbers have a decimal point in every locale, as in the messages of errors. */
static void add_note(ff_table *t, ff_hint hint, const char *fmt, va_list args)
{
    char sentence[sizeof t->note];
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    locale_t previous = c_locale ? uselocale(c_locale) : (locale_t)0;
    int length = vsnprintf(sentence, sizeof sentence, fmt, args);
    if (c_locale) {
        uselocale(previous);
        freelocale(c_locale);
    }
    size_t used = strlen(t->note), before = 0;
    if (length < 0 || used + (size_t)length + 2 > sizeof t->note) return;
    for (const char *p = t->note; (p = strchr(p, '\n')); p++) before++;
    if (used) t->note[used++] = '\n', before++;
    memcpy(t->note + used, sentence, (size_t)length + 1);
    if (before >= FF_TABLE_NOTES) return;
    memset(t->note_hint + before, FF_HINT_NONE, FF_TABLE_NOTES - before); /* of notes that were cleared, and of further lines */
    t->note_hint[before] = (unsigned char)hint;
}

void ff_table_note(ff_table *t, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    add_note(t, FF_HINT_NONE, fmt, args);
    va_end(args);
}

void ff_table_note_hint(ff_table *t, ff_hint hint, const char *fmt, ...)
{
    va_list args;
    va_start(args, fmt);
    add_note(t, hint, fmt, args);
    va_end(args);
}

static int any_sign(const double *v, size_t n)
{
    uint64_t any = 0;
    for (size_t k = 0; k < n; k++) {
        uint64_t u;
        memcpy(&u, v + k, sizeof u);
        any |= u;
    }
    return (any >> 63) != 0;
}

/* Most blocks have no negative number, which their signs tell at the speed of the memory. */
static size_t count_negative(const ff_table *t)
{
    enum { BLOCK = 256 };
    size_t negative = 0;
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        unsigned char any[BLOCK] = {0};
        int seen = 0;
        for (size_t c = 0; c < t->n_channels; c++) {
            const double *v = t->value + c * t->n + first;
            if (!any_sign(v, n)) continue;
            seen = 1;
            for (size_t k = 0; k < n; k++) any[k] |= v[k] < 0;
        }
        for (size_t k = 0; k < n && seen; k++) negative += any[k] && t->valid[first + k];
    }
    return negative;
}

ff_status ff_table_count(ff_table *t, const char *path, ff_error *err)
{
    size_t invalid = 0;
    for (size_t i = 0; i < t->n; i++) invalid += t->valid[i] == 0;
    if (invalid == t->n)
        return ff_error_set(err, FF_ERR_DATA, path, 0, -1,
                            "found %zu samples, all of them marked as not measured, expected at least one measurement", t->n);
    t->n_invalid = invalid;
    t->n_negative = count_negative(t);
    return FF_OK;
}

ff_status ff_table_hand_out(ff_table *t, const char *path, ff_table *out, ff_error *err)
{
    const ff_status status = ff_table_count(t, path, err);
    if (status == FF_OK)
        *out = *t;
    else
        ff_table_clear(t);
    return status;
}

static ff_status bad_number(const char *path, size_t i, const char *what, const char *name, double found, const char *expected,
                            ff_error *err)
{
    return ff_error_set(err, FF_ERR_DATA, path, 0, -1, "sample %zu: found %s%s = %g, expected %s", i, what, name, found, expected);
}

static ff_status check_sample(const ff_table *t, size_t i, const char *path, ff_error *err)
{
    static const char *const angle_name[4] = {"theta_i", "phi_i", "theta_o", "phi_o"};
    for (int k = 0; k < 4 && !t->grid; k++)
        if (!isfinite(t->angle[k][i])) return bad_number(path, i, angle_name[k], "", t->angle[k][i], "a finite number", err);
    if (t->weight && !(isfinite(t->weight[i]) && t->weight[i] >= 0))
        return bad_number(path, i, "weight", "", t->weight[i], "a finite number >= 0", err);
    for (size_t c = 0; c < t->n_channels && t->valid[i]; c++) {
        const ff_channel *channel = &t->channels[c];
        double f = channel->scale * t->value[c * t->n + i];
        if (!isfinite(f)) return bad_number(path, i, "channel ", channel->name, f, "a finite number", err);
        double sigma = t->sigma ? channel->scale * t->sigma[c * t->n + i] : 1;
        if (!(isfinite(sigma) && sigma > 0))
            return bad_number(path, i, "standard deviation of ", channel->name, sigma, "a finite number > 0", err);
    }
    return FF_OK;
}

ff_status ff_table_check(const ff_table *t, const char *path, ff_error *err)
{
    size_t n_valid = 0;
    for (size_t i = 0; i < t->n; i++) {
        ff_status status = check_sample(t, i, path, err);
        if (status != FF_OK) return status;
        n_valid += t->valid[i] != 0;
    }
    if (n_valid == 0)
        return ff_error_set(err, FF_ERR_DATA, path, 0, -1, "found no valid sample among %zu, expected at least one to write", t->n);
    return FF_OK;
}

static void angles_of_grid(const ff_grid *grid, double unit, size_t first, size_t count, double *const out[4])
{
    enum { BLOCK = 256 };
    double w[6][BLOCK];
    double *const planes[6] = {w[0], w[1], w[2], w[3], w[4], w[5]};
    for (size_t done = 0; done < count; done += BLOCK) {
        size_t n = count - done < BLOCK ? count - done : BLOCK;
        grid->directions(first + done, n, planes);
        for (size_t k = 0; k < n; k++)
            for (int side = 0; side < 2; side++) {
                double x = w[3 * side][k], y = w[3 * side + 1][k], z = w[3 * side + 2][k];
                out[2 * side][done + k] = atan2(hypot(x, y), z) / unit;
                out[2 * side + 1][done + k] = atan2(y, x) / unit;
            }
    }
}

void ff_table_angles(const ff_table *t, double unit, size_t first, size_t count, double *const out[4])
{
    if (t->grid) {
        angles_of_grid(t->grid, unit, first, count, out);
        return;
    }
    double factor = t->radians_per_unit / unit; /* exactly 1 where they are the same */
    for (int k = 0; k < 4; k++) scaled(factor, t->angle[k] + first, count, out[k]);
}

/* ---- axes ------------------------------------------------------------------------------------ */

/* Where the nodes are the angles: plain runs, several times as fast. */
static void copy_nodes(ff_table *t)
{
    const ff_axes *x = &t->axes;
    const size_t runs = t->n / x->n[3];
    for (size_t r = 0; r < runs; r++) {
        const double q0 = x->node[0][r / x->n[2] / x->n[1]], q1 = x->node[1][r / x->n[2] % x->n[1]], q2 = x->node[2][r % x->n[2]];
        double *const to[4] = {t->angle[0] + r * x->n[3], t->angle[1] + r * x->n[3], t->angle[2] + r * x->n[3],
                               t->angle[3] + r * x->n[3]};
        for (size_t k = 0; k < x->n[3]; k++) to[0][k] = q0;
        for (size_t k = 0; k < x->n[3]; k++) to[1][k] = q1;
        for (size_t k = 0; k < x->n[3]; k++) to[2][k] = q2;
        memcpy(to[3], x->node[3], x->n[3] * sizeof(double));
    }
}

ff_status ff_table_init_axes(ff_axes_kind kind, const size_t n[4], const double *const node[4], double radians_per_unit,
                             size_t n_channels, int with_weight, ff_table *out, ff_error *err)
{
    size_t samples = 1;
    for (int k = 0; k < 4; k++) {
        if (n[k] == 0 || samples > SIZE_MAX / sizeof(double) / n[k])
            return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu x %zu x %zu x %zu samples", n[0], n[1], n[2],
                                n[3]);
        samples *= n[k];
    }
    ff_table t;
    ff_status status = ff_table_init(samples, n_channels, NULL, 0, with_weight, &t, err);
    if (status != FF_OK) return status;
    t.radians_per_unit = radians_per_unit;
    t.axes.kind = kind;
    for (int k = 0; k < 4; k++) {
        t.axes.n[k] = n[k];
        t.axes.node[k] = malloc(n[k] * sizeof(double));
        if (!t.axes.node[k]) {
            ff_table_clear(&t);
            return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for an axis of %zu nodes", n[k]);
        }
        memcpy(t.axes.node[k], node[k], n[k] * sizeof(double));
    }
    if (kind == FF_AXES_INCIDENT_EXIT) {
        copy_nodes(&t);
    } else if (!ff_axes_fill(&t.axes, radians_per_unit, t.angle)) {
        ff_table_clear(&t);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of %zu samples", samples);
    }
    *out = t;
    return FF_OK;
}

int ff_table_one_incidence_azimuth(const ff_table *t)
{
    for (size_t i = 1; i < t->n; i++)
        if (t->angle[1][i] != t->angle[1][0]) return 0;
    return 1;
}

void ff_table_name_channels_like(ff_table *t, const ff_table *from)
{
    static const char *const rgb[3] = {"r", "g", "b"};
    for (size_t c = 0; c < t->n_channels; c++) {
        ff_channel *to = &t->channels[c];
        if (from->n_channels == 1 && t->n_channels == 3) {
            strcpy(to->name, rgb[c]);
            continue;
        }
        const ff_channel *source = &from->channels[from->n_channels == 1 ? 0 : c];
        memcpy(to->name, source->name, sizeof to->name);
        to->wavelength_nm = source->wavelength_nm;
    }
}

/* um, or with the Greek letter or the sign of micro. */
static int is_micrometer(const char *unit)
{
    return strcmp(unit, "um") == 0 || strcmp(unit, "\xC2\xB5m") == 0 || strcmp(unit, "\xCE\xBCm") == 0;
}

double ff_wavelength_of(const char *name)
{
    double nm;
    const char *end = *name >= '0' && *name <= '9' ? ff_number_read(name, &nm) : NULL;
    if (!end) return NAN;
    if (*end == ' ') end++;
    const double unit = strcmp(end, "nm") == 0 ? 1 : is_micrometer(end) ? 1e3 : NAN;
    return isfinite(nm) && nm > 0 ? rint(1e9 * unit * nm) / 1e9 : NAN;
}
