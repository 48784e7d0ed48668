/* The normal equations of the whole parameter set, and what they say about its uncertainty. */
#include "internal_fit.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

void ff_normal_assemble(const ff_layout *l, const ff_normal *n, const double *slope, double *H, double *g)
{
    const size_t P = l->P, m = n->m1 - 1, tri = n->m1 * (n->m1 + 1) / 2;
    memset(H, 0, P * P * sizeof *H);
    memset(g, 0, P * sizeof *g);
    for (size_t c = 0; c < n->n_channels; c++) {
        const double *gram = n->gram + c * tri;
        for (size_t a = 0; a < m; a++) {
            const size_t i = ff_layout_coordinate(l, c, a);
            g[i] += gram[ff_tri(m, a)];
            for (size_t b = 0; b < m; b++) H[i * P + ff_layout_coordinate(l, c, b)] += gram[ff_tri(a, b)];
        }
    }
    if (!slope) return;
    for (size_t i = 0; i < P; i++) {
        g[i] *= slope[i];
        for (size_t j = 0; j < P; j++) H[i * P + j] *= slope[i] * slope[j];
    }
}

/* Coordinate of column i of all channels' columns. */
static size_t coordinate_of(const ff_layout *l, size_t i)
{
    const size_t shape = l->free.n_shape, own = l->free.n_channel;
    return i < shape ? l->shape_at[i] : ff_layout_coordinate(l, (i - shape) / own, shape + (i - shape) % own);
}

void ff_normal_meat(const ff_layout *l, const double *packed, double *M)
{
    memset(M, 0, l->P * l->P * sizeof *M);
    for (size_t i = 0; i < l->n_columns; i++)
        for (size_t j = 0; j < l->n_columns; j++) M[coordinate_of(l, i) * l->P + coordinate_of(l, j)] += packed[ff_tri(i, j)];
}

size_t ff_scaled_cholesky(const double *A, size_t n, double tolerance, double *L, double *D)
{
    size_t rank = 0;
    memset(L, 0, n * n * sizeof *L);
    for (size_t i = 0; i < n; i++) D[i] = A[i * n + i] > 0 ? sqrt(A[i * n + i]) : 0;
    for (size_t j = 0; j < n; j++) {
        double pivot = D[j] > 0 ? 1 : 0;
        for (size_t k = 0; k < j; k++) pivot -= L[j * n + k] * L[j * n + k];
        if (!(pivot > tolerance)) continue;
        rank++;
        const double root = sqrt(pivot);
        L[j * n + j] = root;
        for (size_t i = j + 1; i < n; i++) {
            double v = D[i] > 0 ? A[i * n + j] / (D[i] * D[j]) : 0;
            for (size_t k = 0; k < j; k++) v -= L[i * n + k] * L[j * n + k];
            L[i * n + j] = v / root;
        }
    }
    return rank;
}

/* x = (L L^T)^-1 b */
static void solve_cholesky(const double *L, size_t n, const double *b, double *x)
{
    for (size_t i = 0; i < n; i++) {
        double v = b[i];
        for (size_t k = 0; k < i; k++) v -= L[i * n + k] * x[k];
        x[i] = v / L[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        double v = x[i];
        for (size_t k = i + 1; k < n; k++) v -= L[k * n + i] * x[k];
        x[i] = v / L[i * n + i];
    }
}

/* A ridge of this size on the scaled J^T J keeps the inverse finite; a parameter whose variance it sets is not determined. */
#define FF_RIDGE        1e-13
#define FF_UNDETERMINED 1e10

ff_status ff_covariance(const ff_layout *l, const ff_normal *n, const int *use, int sandwich, size_t n_samples, double *cov,
                        int *determined)
{
    const size_t P = l->P;
    size_t *index = malloc((P + 1) * sizeof *index), k = 0;
    double *work = calloc(7 * P * P + 3 * P + 1, sizeof *work);
    if (!index || !work) {
        free(index);
        free(work);
        return FF_ERR_MEMORY;
    }
    double *H = work, *A = H + P * P, *L = A + P * P, *inverse = L + P * P, *M = inverse + P * P, *T = M + P * P, *meat = T + P * P,
           *g = meat + P * P, *D = g + P, *e = D + P;
    for (size_t i = 0; i < P; i++)
        if (use[i]) index[k++] = i;
    ff_normal_assemble(l, n, NULL, H, g);
    ff_extras_covariance(l, H, NULL);
    for (size_t i = 0; i < k; i++) {
        D[i] = sqrt(H[index[i] * P + index[i]]);
        if (!(D[i] > 0)) D[i] = 1e-150; /* no effect at all: the ridge then marks it */
    }
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) A[i * k + j] = H[index[i] * P + index[j]] / (D[i] * D[j]) + (i == j ? FF_RIDGE : 0);
    ff_scaled_cholesky(A, k, 0, L, e);
    /* ff_scaled_cholesky scales once more, by e close to 1: (A)^-1 = E^-1 (L L^T)^-1 E^-1 */
    double *column = g, *x = T;
    for (size_t j = 0; j < k; j++) {
        for (size_t i = 0; i < k; i++) {
            column[i] = i == j ? 1 : 0;
            if (!(L[i * k + i] > 0)) L[i * k + i] = sqrt(FF_RIDGE);
        }
        solve_cholesky(L, k, column, x);
        for (size_t i = 0; i < k; i++) inverse[i * k + j] = x[i] / (e[i] > 0 ? e[i] : 1) / (e[j] > 0 ? e[j] : 1);
    }
    memset(cov, 0, P * P * sizeof *cov);
    /* with as many parameters as values nothing is left to estimate the noise from */
    const int enough = n_samples * l->n_channels > k;
    for (size_t i = 0; i < P; i++) determined[i] = 0;
    for (size_t i = 0; i < k; i++)
        determined[index[i]] = inverse[i * k + i] < FF_UNDETERMINED && H[index[i] * P + index[i]] > 0 && (!sandwich || enough);
    const double N = (double)(n_samples * l->n_channels), G = (double)n_samples;
    const double factor = sandwich && N > (double)k && G > 1 ? G / (G - 1) * (N - 1) / (N - (double)k) : 1;
    if (sandwich) { /* inverse M inverse */
        ff_normal_meat(l, n->meat, meat);
        for (size_t i = 0; i < P * P; i++) meat[i] *= factor; /* a prior is a datum whose variance is known */
        ff_extras_covariance(l, NULL, meat);
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++) M[i * k + j] = meat[index[i] * P + index[j]] / (D[i] * D[j]);
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++) {
                double v = 0;
                for (size_t q = 0; q < k; q++) v += inverse[i * k + q] * M[q * k + j];
                T[i * k + j] = v;
            }
        for (size_t i = 0; i < k; i++)
            for (size_t j = 0; j < k; j++) {
                double v = 0;
                for (size_t q = 0; q < k; q++) v += T[i * k + q] * inverse[q * k + j];
                A[i * k + j] = v;
            }
    } else
        memcpy(A, inverse, k * k * sizeof *A);
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) /* the mean of two roundings, so that it is symmetric to the last bit */
            cov[index[i] * P + index[j]] = 0.5 * (A[i * k + j] + A[j * k + i]) / (D[i] * D[j]);
    free(index);
    free(work);
    return FF_OK;
}
