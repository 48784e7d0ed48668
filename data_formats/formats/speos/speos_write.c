/* The grid of a Speos file to be written: what the data have, and the blocks of a table that has it. */
#define _GNU_SOURCE
#include "internal_speos.h"
#include "base/internal_input.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;
enum { HUNDREDTHS = 36000, FEW = 36 };

void ff_speos_put(FILE *file, double v, char after)
{
    char number[FF_NUMBER_TEXT];
    fwrite(number, 1, ff_number_write(v, number), file);
    putc(after, file);
}

/* ---- finding the blocks of a table ------------------------------------------------------------------------ */

static double rounded(double v)
{
    const double r = rint(1e9 * v) / 1e9;
    return r == 0 ? 0 : r;
}

static double turn(double v)
{
    v = rounded(v - 360 * floor(rounded(v) / 360));
    return v >= 360 ? v - 360 : v;
}

/* Sample i in the words of the format: rotation, incidence, polar angle, azimuth from the specular direction. */
static void words_of(const ff_table *t, size_t i, double w[4])
{
    double a[4], *const planes[4] = {a, a + 1, a + 2, a + 3};
    ff_table_angles(t, degree, i, 1, planes);
    w[0] = turn(-90 - a[1]);
    w[1] = rounded(a[0]);
    w[2] = rounded(a[2]);
    w[3] = turn(a[3] - a[1] - 180);
}

static int near(double a, double b)
{
    return fabs(a - b) < 1e-6;
}

/* How many samples from `first` on, in steps, have the same word k as it. */
static size_t run(const ff_table *t, size_t first, size_t step, int k)
{
    double w[4], v[4];
    size_t n = 0;
    words_of(t, first, w);
    for (size_t i = first; i < t->n; i += step, n++) {
        words_of(t, i, v);
        if (!near(v[k], w[k])) break;
    }
    return n;
}

static int is_regular(const ff_table *t, const ff_speos_grid *g)
{
    size_t i = 0;
    for (size_t r = 0; r < g->n_rotations; r++)
        for (size_t j = 0; j < g->n_incidences; j++)
            for (size_t a = 0; a < g->n_theta; a++)
                for (size_t b = 0; b < g->n_phi; b++, i++) {
                    double w[4];
                    words_of(t, i, w);
                    if (!near(w[0], g->rotation[r]) || !near(w[1], g->incidence[j]) || !near(w[2], g->theta[a]) ||
                        !near(w[3], g->phi[b]))
                        return 0;
                }
    return 1;
}

static int is_ascending(const double *v, size_t n)
{
    for (size_t k = 1; k < n; k++)
        if (!(v[k] > v[k - 1])) return 0;
    return 1;
}

static ff_status no_grid(const char *path, ff_error *err)
{
    return ff_error_set(
        err, FF_ERR_UNSUPPORTED, path, 0, -1,
        "a file of this format has the same polar angles and azimuths at each incidence, and these directions have not; resample "
        "to it, or write csv");
}

/* Samples to a row of azimuths, a block, a rotation. 0 where an angle is no number, which is like none, not even itself. */
static int count_samples(const ff_table *t, size_t n[3])
{
    size_t step = 1;
    for (int k = 0; k < 3; k++) {
        n[k] = run(t, 0, step, 2 - k) * step;
        if (n[k] == 0) return 0;
        step = n[k];
    }
    return 1;
}

ff_status ff_speos_grid_of(const ff_table *t, const char *path, ff_speos_grid *out, ff_error *err)
{
    size_t n[3], i = 0;
    double w[4];
    if (!count_samples(t, n)) return no_grid(path, err);
    if (t->n % n[2] || n[2] % n[1] || n[1] % n[0]) return no_grid(path, err);
    ff_speos_grid g = {t->n / n[2], n[2] / n[1], n[1] / n[0], n[0], NULL, NULL, NULL, NULL};
    g.rotation = malloc((g.n_rotations + g.n_incidences + g.n_theta + g.n_phi) * sizeof *g.rotation);
    if (!g.rotation) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the angles of a grid");
    g.incidence = g.rotation + g.n_rotations;
    g.theta = g.incidence + g.n_incidences;
    g.phi = g.theta + g.n_theta;
    for (i = 0; i < g.n_rotations; i++) words_of(t, i * n[2], w), g.rotation[i] = w[0];
    for (i = 0; i < g.n_incidences; i++) words_of(t, i * n[1], w), g.incidence[i] = w[1];
    for (i = 0; i < g.n_theta; i++) words_of(t, i * n[0], w), g.theta[i] = w[2];
    for (i = 0; i < g.n_phi; i++) words_of(t, i, w), g.phi[i] = w[3];
    if (is_ascending(g.rotation, g.n_rotations) && is_ascending(g.incidence, g.n_incidences) && is_ascending(g.theta, g.n_theta) &&
        is_ascending(g.phi, g.n_phi) && is_regular(t, &g)) {
        *out = g;
        return FF_OK;
    }
    free(g.rotation);
    return no_grid(path, err);
}

/* ---- a layout for data --------------------------------------------------------------------------------------- */

/* Distinct incidences [0] or rotations [1] of the valid samples, to a hundredth of a degree, ascending. Their number. */
static size_t distinct(const ff_table *t, int which, double *bin)
{
    size_t n = 0;
    for (int b = 0; b < HUNDREDTHS; b++) bin[b] = NAN;
    for (size_t i = 0; i < t->n; i++) {
        double w[4];
        if (!t->valid[i]) continue;
        words_of(t, i, w);
        if (w[1] < 0) w[1] = -w[1], w[0] = turn(w[0] + 180);
        const double v = which ? w[0] : w[1];
        if (!which && !(v < 89.995)) continue;
        const long b = lround(v * 100) % HUNDREDTHS;
        if (isnan(bin[b])) bin[b] = near(v, 0.01 * (double)b) ? (double)b / 100 : v, n++;
    }
    for (size_t b = 0, at = 0; b < HUNDREDTHS; b++)
        if (!isnan(bin[b])) bin[at++] = bin[b];
    return n;
}

static size_t steps(double *out, double step, double end)
{
    size_t n = 0;
    for (; (double)n * step <= end + 1e-9; n++) out[n] = (double)n * step;
    return n;
}

static ff_status parse_step(const char *grid, double *step, ff_error *err)
{
    char found[FF_QUOTE];
    const char *end = ff_number_read(grid, step);
    if (end && !*end && *step >= 0.5 && *step <= 30) return FF_OK;
    return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1,
                        "grid: found %s, expected a step of polar angles and azimuths from 0.5 to 30 degrees",
                        ff_quote(grid, strlen(grid), found));
}

typedef struct axes {
    double *memory, *node[4]; /* rotation, incidence, theta, phi */
    size_t n[4];
} axes;

static ff_status make_axes(const ff_table *t, int anisotropic, double step, axes *a, ff_error *err)
{
    a->memory = malloc((size_t)4 * HUNDREDTHS * sizeof *a->memory);
    if (!a->memory) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the angles of a grid");
    for (int k = 0; k < 4; k++) a->node[k] = a->memory + (size_t)k * HUNDREDTHS;
    a->n[0] = anisotropic && !t->isotropic ? distinct(t, 1, a->node[0]) : steps(a->node[0], 1, 0);
    a->n[1] = distinct(t, 0, a->node[1]);
    if (a->n[0] > FEW) a->n[0] = steps(a->node[0], 10, 350);
    if (a->n[1] > FEW) a->n[1] = steps(a->node[1], 5, fmin(a->node[1][a->n[1] - 1], 85));
    if (a->n[0] == 0) a->n[0] = steps(a->node[0], 1, 0);
    if (a->n[1] == 0) a->n[1] = steps(a->node[1], 1, 0);
    a->n[2] = steps(a->node[2], step, 90);
    a->n[3] = steps(a->node[3], step, 360 - step / 2);
    return FF_OK;
}

static void fill_layout(const axes *a, ff_table *out)
{
    double band[HUNDREDTHS / 100], polar[HUNDREDTHS / 100];
    size_t i = 0;
    ff_polar_bands(a->node[1], a->n[1], degree, band);
    ff_polar_bands(a->node[2], a->n[2], degree, polar);
    for (size_t r = 0; r < a->n[0]; r++)
        for (size_t j = 0; j < a->n[1]; j++)
            for (size_t b = 0; b < a->n[2]; b++)
                for (size_t c = 0; c < a->n[3]; c++, i++) {
                    out->angle[0][i] = a->node[1][j];
                    out->angle[1][i] = -90 - a->node[0][r];
                    out->angle[2][i] = a->node[2][b];
                    out->angle[3][i] = 90 - a->node[0][r] + a->node[3][c];
                    out->weight[i] = fmax(0, band[j] * polar[b] * 2 * 180 * degree / (double)a->n[3]);
                }
}

ff_status ff_speos_layout(const ff_table *t, int anisotropic, const char *grid, ff_table *out, ff_error *err)
{
    double step = 2.5;
    axes a = {0};
    ff_status status = grid ? parse_step(grid, &step, err) : FF_OK;
    if (status == FF_OK) status = make_axes(t, anisotropic, step, &a, err);
    if (status == FF_OK) status = ff_table_init(a.n[0] * a.n[1] * a.n[2] * a.n[3], t->n_channels, NULL, 0, 1, out, err);
    if (status == FF_OK) {
        out->radians_per_unit = degree;
        out->isotropic = a.n[0] == 1;
        fill_layout(&a, out);
        ff_table_name_channels_like(out, t);
    }
    free(a.memory);
    return status;
}

/* ---- writing a block ------------------------------------------------------------------------------------------- */

static double value_at(const ff_table *t, size_t c, size_t i)
{
    return t->valid[i] ? t->channels[c].scale * t->value[c * t->n + i] : 0;
}

double ff_speos_block_percent(const ff_table *t, const ff_speos_grid *g, size_t c, size_t first, ff_error *err)
{
    ff_speos_block b = {g->n_theta, g->n_phi, g->theta, g->phi, malloc(g->n_theta * g->n_phi * sizeof(double))};
    if (!b.value) {
        ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu values", g->n_theta * g->n_phi);
        return NAN;
    }
    for (size_t i = 0; i < g->n_theta * g->n_phi; i++) b.value[i] = value_at(t, c, first + i);
    const double percent = 100 * ff_speos_block_integral(&b);
    free(b.value);
    return percent;
}

void ff_speos_block_write(const ff_table *t, const ff_speos_grid *g, size_t c, size_t first, FILE *file)
{
    const int closes = g->n_phi > 1 && near(g->phi[0], 0); /* the first azimuth comes again after a turn */
    fprintf(file, "%zu\t%zu\n", g->n_theta, g->n_phi + (closes ? 1 : 0));
    putc('\t', file);
    for (size_t k = 0; k < g->n_phi; k++) ff_speos_put(file, g->phi[k], closes || k + 1 < g->n_phi ? '\t' : '\n');
    if (closes) fputs("360\n", file);
    for (size_t i = 0; i < g->n_theta; i++) {
        const size_t row = first + i * g->n_phi;
        ff_speos_put(file, g->theta[i], '\t');
        for (size_t k = 0; k < g->n_phi; k++) ff_speos_put(file, value_at(t, c, row + k), closes || k + 1 < g->n_phi ? '\t' : '\n');
        if (closes) ff_speos_put(file, value_at(t, c, row), '\n');
    }
}
