/* Small dense linear algebra: what the minimisation and the errors of a fit have in common. Nothing here knows of samples. Matrices
 * are by rows; every function may be called from many threads. */
#ifndef FF_INTERNAL_LINALG_H
#define FF_INTERNAL_LINALG_H
#include "ff_status.h"
#include "models/kernels/composition_struct.h"
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Position in the packed lower triangle of a symmetric matrix. */
static inline size_t ff_tri(size_t row, size_t col)
{
    return row >= col ? row * (row + 1) / 2 + col : col * (col + 1) / 2 + row;
}

/* Cholesky factor of a symmetric positive semidefinite A [n][n] after scaling its diagonal to 1: A = D L L^T D, L [n][n] lower, D
 * [n]. A pivot at or below `tolerance` leaves a zero column: that parameter is a combination of the ones before it. Returns the
 * rank. */
size_t ff_scaled_cholesky(const double *A, size_t n, double tolerance, double *L, double *D);

/* X [n][m] = A^-1 B from the factor of A = D L L^T D; a zero in L or D gives 0. X may be B. */
void ff_factored_solve(const double *L, const double *D, size_t n, const double *B, size_t m, double *X);

/* X [n][m] = A^-1 B of a symmetric positive semidefinite A [n][n], n <= FF_MAX_SHAPE, and B [n][m]; 0 in what A does not say. */
void ff_solve_symmetric(const double *A, size_t n, const double *B, size_t m, double *X);

/* Inverse of the rows and columns index [k] of A [n][n], whose diagonal is near 1 and has a ridge added: 0 elsewhere, symmetric to
 * the last bit. What rounding has left no pivot gets that of the ridge. work [4 k k + k]. */
void ff_ridge_inverse(const double *A, size_t n, const size_t *index, size_t k, double ridge, double *inverse, double *work);

/* Bounded least squares: q in [lo, hi] minimising |r + L q|^2 from the packed gram of [L r], n <= FF_MAX_CHANNEL_PARAMS columns.
 * Returns the minimum. Active sets: Lawson and Hanson 1974, chapter 23; Stark and Parker 1995. */
double ff_bounded_least_squares(const double *gram, size_t n, const double *lo, const double *hi, double *q);

/* Eigenvalues [n], ascending, and eigenvectors (columns of V [n][n]) of a symmetric A [n][n], of which the lower triangle is read.
 * FF_ERR_MEMORY; FF_ERR_INTERNAL where the iteration does not end, as with numbers that are not finite. */
ff_status ff_symmetric_eigen(const double *A, size_t n, double *values, double *V);

/* "3.4.0", the version of Eigen, into out. Returns out. */
const char *ff_eigen_version(char *out, size_t size);

#ifdef __cplusplus
}
#endif
#endif
