/* Factors and solutions of small symmetric systems whose rows may be of any scale, and of which some may say the same. */
#include "internal_linalg.h"
#include <math.h>
#include <string.h>

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

void ff_factored_solve(const double *L, const double *D, size_t n, const double *B, size_t m, double *X)
{
    for (size_t j = 0; j < m; j++) {
        for (size_t i = 0; i < n; i++) {
            double v = D[i] > 0 ? B[i * m + j] / D[i] : 0;
            for (size_t k = 0; k < i; k++) v -= L[i * n + k] * X[k * m + j];
            X[i * m + j] = L[i * n + i] > 0 ? v / L[i * n + i] : 0;
        }
        for (size_t i = n; i-- > 0;) {
            double v = X[i * m + j];
            for (size_t k = i + 1; k < n; k++) v -= L[k * n + i] * X[k * m + j];
            X[i * m + j] = L[i * n + i] > 0 ? v / L[i * n + i] : 0;
        }
        for (size_t i = 0; i < n; i++) X[i * m + j] = D[i] > 0 ? X[i * m + j] / D[i] : 0;
    }
}

void ff_solve_symmetric(const double *A, size_t n, const double *B, size_t m, double *X)
{
    double L[FF_MAX_SHAPE * FF_MAX_SHAPE], D[FF_MAX_SHAPE];
    ff_scaled_cholesky(A, n, 1e-14, L, D);
    ff_factored_solve(L, D, n, B, m, X);
}

void ff_ridge_inverse(const double *A, size_t n, const size_t *index, size_t k, double ridge, double *inverse, double *work)
{
    double *sub = work, *unit = sub + k * k, *X = unit + k * k, *L = X + k * k, *D = L + k * k;
    for (size_t i = 0; i < k; i++) {
        for (size_t j = 0; j < k; j++) {
            sub[i * k + j] = A[index[i] * n + index[j]];
            unit[i * k + j] = i == j;
        }
        sub[i * k + i] = fmax(sub[i * k + i], ridge);
    }
    ff_scaled_cholesky(sub, k, 0, L, D);
    for (size_t i = 0; i < k; i++)
        if (!(L[i * k + i] > 0)) L[i * k + i] = sqrt(ridge);
    ff_factored_solve(L, D, k, unit, k, X);
    memset(inverse, 0, n * n * sizeof *inverse);
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) inverse[index[i] * n + index[j]] = 0.5 * (X[i * k + j] + X[j * k + i]);
}
