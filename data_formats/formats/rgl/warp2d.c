/* Warps of the unit square by bilinear densities: internal_warp2d.h has the definition.
 *
 * Units: x and y count cells, so that the integral of a row of numbers d0, d1, .. over its first cell is (d0 + d1) / 2. Integrals
 * are kept as 32-bit floats like the loader's; sums and what is made of them are double. */
#include "internal_warp2d.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void ff_warp2d_free(ff_warp2d *w)
{
    free(w->node[0]);
    free(w->node[1]);
    free(w->density);
    free(w->marginal);
    free(w->conditional);
    *w = (ff_warp2d){0};
}

/* ---- integrals ------------------------------------------------------------------------------- */

static double row_integral(const float *d, size_t width)
{
    double part[4] = {0};
    size_t i = 0;
    for (; i + 4 <= width; i += 4)
        for (size_t k = 0; k < 4; k++) part[k] += (double)d[i + k];
    for (; i < width; i++) part[0] += (double)d[i];
    return part[0] + part[1] + part[2] + part[3] - 0.5 * ((double)d[0] + (double)d[width - 1]);
}

static void normalise(ff_warp2d *w, size_t slice)
{
    float *d = w->density + slice * w->height * w->width, *marginal = w->marginal + slice * w->height;
    double sum = 0, row = row_integral(d, w->width);
    for (size_t y = 0; y + 1 < w->height; y++) {
        const double next = row_integral(d + (y + 1) * w->width, w->width);
        sum += 0.5 * (row + next);
        row = next;
    }
    const double factor = 1 / sum;
    for (size_t i = 0; i < w->height * w->width; i++) d[i] = (float)((double)d[i] * factor);
    sum = 0;
    marginal[0] = 0;
    row = row_integral(d, w->width);
    for (size_t y = 0; y + 1 < w->height; y++) {
        const double next = row_integral(d + (y + 1) * w->width, w->width);
        sum += 0.5 * (row + next);
        marginal[y + 1] = (float)sum;
        row = next;
    }
}

static void integrate_rows(ff_warp2d *w, size_t slice)
{
    for (size_t y = 0; y < w->height; y++) {
        const size_t at = (slice * w->height + y) * w->width;
        double sum = 0;
        w->conditional[at] = 0;
        for (size_t x = 1; x < w->width; x++) {
            sum += 0.5 * ((double)w->density[at + x - 1] + (double)w->density[at + x]);
            w->conditional[at + x] = (float)sum;
        }
    }
}

int ff_warp2d_new(size_t width, size_t height, const size_t n_node[2], const double *const node[2], float *density,
                  int with_inverse, ff_warp2d *out)
{
    const size_t slices = n_node[0] * n_node[1];
    ff_warp2d w = {.width = width, .height = height, .n_node = {n_node[0], n_node[1]}, .density = density};
    w.marginal = malloc(slices * height * sizeof *w.marginal);
    if (with_inverse) w.conditional = malloc(slices * height * width * sizeof *w.conditional);
    for (int k = 0; k < 2; k++)
        if ((w.node[k] = malloc(n_node[k] * sizeof(double)))) memcpy(w.node[k], node[k], n_node[k] * sizeof(double));
    if (!w.marginal || (with_inverse && !w.conditional) || !w.node[0] || !w.node[1]) {
        ff_warp2d_free(&w);
        return 0;
    }
    for (size_t k = 0; k < slices; k++) {
        normalise(&w, k);
        if (with_inverse) integrate_rows(&w, k);
    }
    *out = w;
    return 1;
}

/* ---- parameters ------------------------------------------------------------------------------ */

/* The interval of nodes that holds v, and how far v is into it: 0..1. */
static size_t interval(const double *node, size_t n, double v, double *t)
{
    *t = 0;
    if (n < 2) return 0;
    size_t i = 0;
    for (size_t hi = n - 1; hi - i > 1;) {
        const size_t middle = i + (hi - i) / 2;
        if (node[middle] <= v)
            i = middle;
        else
            hi = middle;
    }
    *t = fmin(fmax((v - node[i]) / (node[i + 1] - node[i]), 0), 1);
    return i;
}

ff_warp2d_mix ff_warp2d_at(const ff_warp2d *w, const double parameter[2])
{
    ff_warp2d_mix mix = {0};
    double t[2];
    size_t i[2];
    for (int k = 0; k < 2; k++) i[k] = interval(w->node[k], w->n_node[k], parameter[k], &t[k]);
    for (size_t a = 0; a < 2; a++)
        for (size_t b = 0; b < 2; b++) {
            const double weight = (a ? t[0] : 1 - t[0]) * (b ? t[1] : 1 - t[1]);
            if (!(weight > 0)) continue;
            mix.slice[mix.n] = (i[0] + a) * w->n_node[1] + i[1] + b;
            mix.weight[mix.n++] = weight;
        }
    return mix;
}

/* Number `at` of every slice's `size`, interpolated. */
static double mixed(const float *data, size_t size, size_t at, const ff_warp2d_mix *mix)
{
    double sum = 0;
    for (int k = 0; k < mix->n; k++) sum += mix->weight[k] * (double)data[mix->slice[k] * size + at];
    return sum;
}

/* ---- the maps -------------------------------------------------------------------------------- */

/* The cell of u and the place in it. */
static size_t cell_of(double u, size_t n, double *t)
{
    const double at = fmin(fmax(u, 0), 1) * (double)(n - 1);
    const size_t cell = at < (double)(n - 2) ? (size_t)at : n - 2;
    *t = at - (double)cell;
    return cell;
}

double ff_bilinear(const float *grid, size_t width, size_t height, const double u[2])
{
    double x, y;
    const float *at = grid + cell_of(u[0], width, &x);
    at += width * cell_of(u[1], height, &y);
    return (1 - y) * ((1 - x) * (double)at[0] + x * (double)at[1]) + y * ((1 - x) * (double)at[width] + x * (double)at[width + 1]);
}

/* Where a density that goes from d0 to d1 over a cell has the integral `mass`: 0..1. */
static double invert_cell(double mass, double d0, double d1)
{
    const double square = d0 * d0 + 2 * mass * (d1 - d0), below = d0 + (square > 0 ? sqrt(square) : 0);
    const double place = below > 0 ? 2 * mass / below : 0;
    return place > 1 ? 1 : place > 0 ? place : 0;
}

void ff_warp2d_invert(const ff_warp2d *w, const ff_warp2d_mix *mix, const double u[2], double s[2])
{
    double x, y;
    const size_t column = cell_of(u[0], w->width, &x), row = cell_of(u[1], w->height, &y);
    const size_t size = w->width * w->height, at = row * w->width + column, end = (row + 1) * w->width - 1;
    const float *d = w->density, *c = w->conditional;
    const double d0 = (1 - y) * mixed(d, size, at, mix) + y * mixed(d, size, at + w->width, mix);
    const double d1 = (1 - y) * mixed(d, size, at + 1, mix) + y * mixed(d, size, at + 1 + w->width, mix);
    const double before = (1 - y) * mixed(c, size, at, mix) + y * mixed(c, size, at + w->width, mix);
    const double r0 = mixed(c, size, end, mix), r1 = mixed(c, size, end + w->width, mix);
    const double whole = (1 - y) * r0 + y * r1;
    s[0] = whole > 0 ? fmin((before + x * (d0 + 0.5 * x * (d1 - d0))) / whole, 1) : 0;
    s[1] = fmin(mixed(w->marginal, w->height, row, mix) + y * (r0 + 0.5 * y * (r1 - r0)), 1);
}

/* Adds the mixed densities of a row of the grid. */
static void mix_row(const ff_warp2d *w, const ff_warp2d_mix *mix, size_t y, double factor, double *sum)
{
    for (int k = 0; k < mix->n; k++) {
        const float *d = w->density + (mix->slice[k] * w->height + y) * w->width;
        const double f = factor * mix->weight[k];
        for (size_t x = 0; x < w->width; x++) sum[x] += f * (double)d[x];
    }
}

static double mixed_integral(const ff_warp2d *w, const ff_warp2d_mix *mix, size_t y)
{
    double sum = 0;
    for (int k = 0; k < mix->n; k++)
        sum += mix->weight[k] * row_integral(w->density + (mix->slice[k] * w->height + y) * w->width, w->width);
    return sum;
}

/* Rows without density are passed over: the cell has some, and the row taken in it is the limit from inside. */
double ff_warp2d_row(const ff_warp2d *w, const ff_warp2d_mix *mix, double s_y, double *row)
{
    size_t lo = 0, hi = w->height - 1;
    const double mass = s_y * mixed(w->marginal, w->height, hi, mix);
    while (hi - lo > 1) {
        const size_t middle = lo + (hi - lo) / 2;
        if (mixed(w->marginal, w->height, middle, mix) <= mass)
            lo = middle;
        else
            hi = middle;
    }
    double r0, r1;
    while ((r0 = mixed_integral(w, mix, lo)) + (r1 = mixed_integral(w, mix, lo + 1)) <= 0 && lo > 0) lo--; /* s_y = 1 */
    const double y = invert_cell(mass - mixed(w->marginal, w->height, lo, mix), r0, r1);
    const double place = ((double)lo + y) / (double)(w->height - 1);
    if (!row) return place;
    const double inside = y <= 0 && r0 <= 0 ? 1 : y >= 1 && r1 <= 0 ? 0 : y;
    memset(row, 0, w->width * sizeof *row);
    mix_row(w, mix, lo, 1 - inside, row);
    mix_row(w, mix, lo + 1, inside, row);
    double *sum = row + w->width;
    sum[0] = 0;
    for (size_t x = 1; x < w->width; x++) sum[x] = sum[x - 1] + 0.5 * (row[x - 1] + row[x]);
    return place;
}

double ff_warp2d_along(const ff_warp2d *w, const double *row, double s_x, size_t *cell)
{
    const double *sum = row + w->width, mass = s_x * sum[w->width - 1];
    size_t x = *cell;
    while (x + 2 < w->width && sum[x + 1] <= mass && sum[x + 1] < sum[w->width - 1]) x++;
    *cell = x;
    return ((double)x + invert_cell(mass - sum[x], row[x], row[x + 1])) / (double)(w->width - 1);
}
