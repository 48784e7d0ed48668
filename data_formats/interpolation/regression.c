/* Local regression over the nearest samples. */
#include "internal_interpolate.h"
#include <math.h>

enum { TERMS = 6 };

/* Terms of the polynomial at an offset: of second degree in the plane, of first in more dimensions. Their number. */
static int terms(int dim, const double *offset, double out[TERMS])
{
    out[0] = 1;
    for (int k = 0; k < dim; k++) out[k + 1] = offset[k];
    if (dim > 2) return dim + 1;
    out[3] = offset[0] * offset[0];
    out[4] = offset[0] * offset[1];
    out[5] = offset[1] * offset[1];
    return TERMS;
}

/* Solves a x = b for a symmetric positive definite a of m rows, in place. */
static void solve(int m, double a[TERMS][TERMS], double b[TERMS])
{
    for (int k = 0; k < m; k++)
        for (int i = k + 1; i < m; i++) {
            const double f = a[i][k] / a[k][k];
            for (int j = k; j < m; j++) a[i][j] -= f * a[k][j];
            b[i] -= f * b[k];
        }
    for (int k = m - 1; k >= 0; k--) {
        for (int j = k + 1; j < m; j++) b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
}

/* The shares with which the neighbours' values make up the value at x: that of the weighted polynomial through them. */
static void fitted_shares(int dim, const double *x, size_t n, const ff_neighbour *near, double *share)
{
    const double reach = 1.05 * sqrt(near[n - 1].distance2);
    double a[TERMS][TERMS] = {{0}}, b[TERMS] = {1}, row[FF_NEIGHBOURS_MOST][TERMS], w[FF_NEIGHBOURS_MOST], offset[4];
    int m = 0;
    for (size_t j = 0; j < n; j++) {
        const double r = sqrt(near[j].distance2) / reach, u = 1 - r * r * r;
        w[j] = u * u * u;
        for (int k = 0; k < dim; k++) offset[k] = (near[j].point[k] - x[k]) / reach;
        m = terms(dim, offset, row[j]);
        for (int i = 0; i < m; i++)
            for (int k = 0; k < m; k++) a[i][k] += w[j] * row[j][i] * row[j][k];
    }
    for (int k = 1; k < m; k++) a[k][k] += (k <= dim ? 1e-4 : 1e-3) * a[0][0]; /* no slope where the neighbours show none */
    solve(m, a, b);
    for (size_t j = 0; j < n; j++) {
        share[j] = 0;
        for (int k = 0; k < m; k++) share[j] += b[k] * row[j][k];
        share[j] *= w[j];
    }
}

/* Mean of the samples at one place, without one. */
static double value_of(const ff_table *t, size_t c, const ff_neighbour *place, uint32_t without)
{
    double sum = 0;
    size_t n = 0;
    for (size_t k = 0; k < place->n_samples; k++) {
        if (place->sample[k] == without) continue;
        sum += t->value[c * t->n + place->sample[k]];
        n++;
    }
    return t->channels[c].scale * sum / (double)n;
}

/* One channel from its neighbours: by logarithms where all are positive, within their range. */
static double combine(const ff_table *t, size_t c, size_t n, const ff_neighbour *near, uint32_t without, const double *share)
{
    double v[FF_NEIGHBOURS_MOST], lo = INFINITY, hi = -INFINITY, plain = 0, logs = 0;
    for (size_t j = 0; j < n; j++) {
        v[j] = value_of(t, c, &near[j], without);
        lo = fmin(lo, v[j]);
        hi = fmax(hi, v[j]);
    }
    for (size_t j = 0; j < n; j++) {
        plain += share[j] * v[j];
        if (lo > 0) logs += share[j] * log(v[j]);
    }
    return fmin(fmax(lo > 0 ? exp(logs) : plain, lo), hi);
}

/* 1 when all the neighbours lie to one side of x and not close, measured by their own spread. */
static int is_beyond(int dim, const double *x, size_t n, const ff_neighbour *near)
{
    double mean[4] = {0};
    for (size_t j = 0; j < n; j++)
        for (int k = 0; k < dim; k++) mean[k] += near[j].point[k] - x[k];
    for (size_t j = 0; j < n; j++) {
        double along = 0;
        for (int k = 0; k < dim; k++) along += mean[k] * (near[j].point[k] - x[k]);
        if (along <= 0) return 0;
    }
    return sqrt(near[0].distance2) > 0.3 * sqrt(near[n - 1].distance2);
}

/* The neighbours to make a value of. Where the nearest all lie to one side (a row of samples close together), more are asked. */
static size_t neighbours_around(const ff_neighbours *tree, int dim, const double *x, uint32_t without, ff_neighbour *near,
                                ff_found *found)
{
    size_t n = ff_neighbours_find(tree, x, FF_INTERPOLATE_NEIGHBOURS, without, near);
    *found = FF_FOUND_BEYOND;
    if (n == 0) return 0;
    *found = FF_FOUND_SAMPLE;
    if (near[0].distance2 < ff_same_place * ff_same_place) return 1;
    *found = FF_FOUND_BETWEEN;
    if (!is_beyond(dim, x, n, near)) return n;
    n = ff_neighbours_find(tree, x, FF_NEIGHBOURS_MOST, without, near);
    if (!is_beyond(dim, x, n, near)) return n;
    *found = FF_FOUND_BEYOND;
    return 1;
}

/* The value at x of the samples in one tree. */
ff_found ff_regress(const ff_table *t, const ff_neighbours *tree, int dim, const double *x, uint32_t without, double *value,
                    size_t stride)
{
    ff_neighbour near[FF_NEIGHBOURS_MOST];
    double share[FF_NEIGHBOURS_MOST];
    ff_found found;
    const size_t n = neighbours_around(tree, dim, x, without, near, &found);
    share[0] = 1;
    if (n > 1) fitted_shares(dim, x, n, near, share);
    for (size_t c = 0; c < t->n_channels; c++) value[c * stride] = n ? combine(t, c, n, near, without, share) : 0;
    return found;
}
