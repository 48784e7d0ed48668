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
