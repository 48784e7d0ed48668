/* An information kept as a whole: all covariances, at a cost that grows with the square of the parameters. */
#include "internal_storage.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static size_t doubles(size_t S, size_t K, size_t C)
{
    const size_t P = S + K * C;
    return 2 * P * P;
}

static void lay_out(ff_information *info, double *memory)
{
    info->whole = memory;
    info->covariance = memory + info->P * info->P;
}

static ff_status invert(ff_information *info, const ff_gram *g)
{
    const size_t P = info->P;
    double *H = malloc((5 * P * P + 2 * P + 1) * sizeof *H), *gradient = H + P * P, *work = gradient + P;
    size_t *index = malloc((P + 1) * sizeof *index), k = 0;
    const ff_status status = H && index ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        ff_gram_dense(g, H, gradient);
        for (size_t i = 0; i < P; i++) {
            if (info->use[i]) index[k++] = i;
            for (size_t j = 0; j < P; j++) H[i * P + j] = H[i * P + j] * info->scale[i] * info->scale[j] + (i == j ? FF_RIDGE : 0);
        }
        ff_ridge_inverse(H, P, index, k, FF_RIDGE, info->whole, work);
    }
    free(H);
    free(index);
    return status;
}

static double inverse_at(const ff_information *info, size_t i, size_t j)
{
    return info->whole[i * info->P + j];
}

static void apply(const ff_information *info, const double *score, double *influence)
{
    for (size_t i = 0; i < info->P; i++) {
        double v = 0;
        for (size_t j = 0; j < info->P; j++) v += info->whole[i * info->P + j] * score[j];
        influence[i] = v;
    }
}

static size_t products(const ff_information *info)
{
    return info->P * (info->P + 1) / 2;
}

static void add_products(const ff_information *info, const double *influence, double factor, double *sums)
{
    for (size_t i = 0; i < info->P; i++)
        for (size_t j = 0; j <= i; j++) sums[ff_tri(i, j)] += factor * influence[i] * influence[j];
}

static double product_at(const ff_information *info, const double *sums, size_t k)
{
    (void)info;
    return sums[ff_tri(k, k)];
}

/* A B, [n][n] each */
static void multiply_matrices(const double *A, const double *B, size_t n, double *out)
{
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) {
            double v = 0;
            for (size_t q = 0; q < n; q++) v += A[i * n + q] * B[q * n + j];
            out[i * n + j] = v;
        }
}

/* H^-1 M H^-1 with M the outer products of the scores, which the pass has summed up. */
static ff_status of_single(const ff_information *info, const ff_normal *n, size_t n_samples, const double *mean,
                           const double *of_samples, double *sums)
{
    const size_t P = info->P;
    double *M = malloc((2 * P * P + 1) * sizeof *M);
    (void)of_samples;
    if (!M) return FF_ERR_MEMORY;
    double *T = M + P * P;
    for (size_t i = 0; i < P; i++)
        for (size_t j = 0; j < P; j++)
            M[i * P + j] =
                (n->score_products[ff_tri(i, j)] - (double)n_samples * mean[i] * mean[j]) * info->scale[i] * info->scale[j];
    multiply_matrices(info->whole, M, P, T);
    multiply_matrices(T, info->whole, P, M);
    for (size_t i = 0; i < P; i++)
        for (size_t j = 0; j <= i; j++) sums[ff_tri(i, j)] += 0.5 * (M[i * P + j] + M[j * P + i]);
    free(M);
    return FF_OK;
}

static void take_products(ff_information *info, const double *sums)
{
    for (size_t i = 0; i < info->P; i++)
        for (size_t j = 0; j < info->P; j++) info->covariance[i * info->P + j] = sums[ff_tri(i, j)];
}

static void take_inverse(ff_information *info)
{
    memcpy(info->covariance, info->whole, info->P * info->P * sizeof *info->covariance);
}

/* By the root of M, so that what cancels where parameters cannot be told apart cancels before it is squared: a variance stays one.
 */
static ff_status sandwich(ff_information *info, const ff_gram *g)
{
    const size_t P = info->P;
    double *M = malloc((3 * P * P + 2 * P + 1) * sizeof *M);
    if (!M) return FF_ERR_MEMORY;
    double *root = M + P * P, *T = root + P * P, *D = T + P * P;
    ff_gram_dense(g, M, D);
    for (size_t i = 0; i < P; i++)
        for (size_t j = 0; j < P; j++) M[i * P + j] *= info->scale[i] * info->scale[j];
    ff_scaled_cholesky(M, P, 0, root, D);
    for (size_t i = 0; i < P; i++)
        for (size_t j = 0; j <= i; j++) root[i * P + j] *= D[i];
    multiply_matrices(info->whole, root, P, T);
    memset(info->covariance, 0, P * P * sizeof *info->covariance);
    for (size_t i = 0; i < P; i++)
        for (size_t j = 0; j < P; j++)
            for (size_t k = 0; k < P; k++) info->covariance[i * P + j] += T[i * P + k] * T[j * P + k];
    free(M);
    return FF_OK;
}

static void multiply(ff_information *info, const double *factor)
{
    for (size_t i = 0; i < info->P; i++)
        for (size_t j = 0; j < info->P; j++) info->covariance[i * info->P + j] *= factor[i] * factor[j];
}

static double covariance(const ff_information *info, size_t i, size_t j)
{
    return info->covariance[i * info->P + j];
}

/* In a direction that is flatter than this nothing is determined. */
#define FF_NOTHING 1e-12

static ff_status condition(const ff_information *info, const ff_gram *g, size_t *rank, double *out, double *curvature,
                           double *share)
{
    const size_t P = info->P;
    double *H = malloc((3 * P * P + 2 * P + 1) * sizeof *H), *A = H + P * P, *V = A + P * P, *w = V + P * P, *gradient = w + P;
    size_t *index = malloc((P + 1) * sizeof *index), n = 0;
    ff_status status = H && index ? FF_OK : FF_ERR_MEMORY;
    if (!status) ff_gram_dense(g, H, gradient);
    for (size_t k = 0; k < P && !status; k++)
        if (info->use[k]) index[n++] = k;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) A[i * n + j] = H[index[i] * P + index[j]] * info->scale[index[i]] * info->scale[index[j]];
    if (!status) status = ff_symmetric_eigen(A, n, w, V);
    if (!status) {
        *rank = 0;
        for (size_t i = 0; i < n; i++) *rank += w[i] > FF_NOTHING;
        *out = n == 0 ? 1 : w[0] > FF_NOTHING ? sqrt(w[n - 1] / w[0]) : INFINITY;
    }
    if (!status && share) {
        *curvature = n ? w[0] : 1;
        memset(share, 0, P * sizeof *share);
        for (size_t i = 0; i < n; i++) share[index[i]] = V[i * n];
    }
    free(H);
    free(index);
    return status;
}

const ff_storage ff_storage_whole = {doubles,      lay_out,      invert,     inverse_at, apply,
                                     products,     add_products, product_at, of_single,  take_products,
                                     take_inverse, sandwich,     multiply,   covariance, condition};
