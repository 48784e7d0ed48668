/* What the solver sees of a problem: as many residuals as coordinates, and one more. */
#include "internal_minimise.h"
#include <math.h>

double ff_compress(const double *H, const double *g, size_t P, const size_t *index, size_t n, double cost2, double *work,
                   double *residual, double *jacobian)
{
    double *sub = work, *L = sub + n * n, *D = L + n * n, explained = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) sub[i * n + j] = H[index[i] * P + index[j]];
    ff_scaled_cholesky(sub, n, 1e-14, L, D);
    for (size_t i = 0; i < n; i++) { /* L (Q^T r) = D^-1 g */
        double v = D[i] > 0 ? g[index[i]] / D[i] : 0;
        for (size_t k = 0; k < i; k++) v -= L[i * n + k] * residual[k];
        residual[i] = L[i * n + i] > 0 ? v / L[i * n + i] : 0;
        explained += residual[i] * residual[i];
    }
    residual[n] = sqrt(fmax(cost2 - explained, 0));
    if (!jacobian) return explained;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++) jacobian[i * n + j] = L[j * n + i] * D[j];
    for (size_t j = 0; j < n; j++) jacobian[n * n + j] = 0;
    return explained;
}

ff_outcome ff_solve_outcome(ff_ceres_end end)
{
    switch (end) {
    case FF_CERES_CONVERGED:
        return FF_CONVERGED;
    case FF_CERES_LIMIT:
        return FF_LIMIT;
    case FF_CERES_STOPPED:
        return FF_CANCELLED;
    default:
        return FF_STALLED;
    }
}

ff_status ff_solve_failed(ff_status status, ff_error *err)
{
    if (status == FF_ERR_CANCELLED) return ff_error_set(err, status, NULL, 0, -1, "cancelled");
    return status ? ff_error_set(err, status, NULL, 0, -1, "a pass over the samples failed: %s", ff_status_str(status)) : FF_OK;
}
