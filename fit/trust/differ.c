/* Do the channels of a measurement have different shapes? Wald's test on fits of each alone. */
#include "base/internal_statistics.h"
#include "fit/problem/internal_problem.h"
#include "trust_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Shape parameters that have an error in every fit: their places. */
static size_t comparable(const ff_fit_result *fits, size_t n, uint32_t *at)
{
    size_t q = 0;
    for (uint32_t k = 0; k < fits->model.n_shape; k++) {
        int all = 1;
        for (size_t i = 0; i < n; i++) {
            const ff_fit_value *v = &fits[i].shape_value[k];
            all &= !v->held && !v->tied && v->column >= 0 && v->std_error > 0;
        }
        if (all) at[q++] = k;
    }
    return q;
}

/* A = L L^T in place, the lower triangle; 0 when A is not positive definite. */
static int cholesky(double *A, size_t n)
{
    for (size_t j = 0; j < n; j++) {
        for (size_t k = 0; k < j; k++) A[j * n + j] -= A[j * n + k] * A[j * n + k];
        if (!(A[j * n + j] > 0)) return 0;
        A[j * n + j] = sqrt(A[j * n + j]);
        for (size_t i = j + 1; i < n; i++) {
            for (size_t k = 0; k < j; k++) A[i * n + j] -= A[i * n + k] * A[j * n + k];
            A[i * n + j] /= A[j * n + j];
        }
    }
    return 1;
}

static void solve(const double *L, size_t n, double *x)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++) x[i] -= L[i * n + k] * x[k];
        x[i] /= L[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++) x[i] -= L[k * n + i] * x[k];
        x[i] /= L[i * n + i];
    }
}

/* Inverse covariance [q][q] of the comparable parameters of a fit. */
static int precision(const ff_fit_result *fit, const uint32_t *at, size_t q, double *out)
{
    double L[FF_MAX_SHAPE * FF_MAX_SHAPE], x[FF_MAX_SHAPE];
    for (size_t a = 0; a < q; a++)
        for (size_t b = 0; b < q; b++) {
            const ff_fit_value *va = &fit->shape_value[at[a]], *vb = &fit->shape_value[at[b]];
            L[a * q + b] =
                va->std_error * vb->std_error * fit->correlation[(size_t)va->column * fit->n_columns + (size_t)vb->column];
        }
    if (!cholesky(L, q)) return 0;
    for (size_t b = 0; b < q; b++) {
        for (size_t a = 0; a < q; a++) x[a] = a == b;
        solve(L, q, x);
        for (size_t a = 0; a < q; a++) out[a * q + b] = x[a];
    }
    return 1;
}

static double chi2_of(const ff_fit_result *fits, size_t n, const uint32_t *at, size_t q, int *ok)
{
    double total[FF_MAX_SHAPE * FF_MAX_SHAPE] = {0}, mean[FF_MAX_SHAPE] = {0}, W[FF_MAX_SHAPE * FF_MAX_SHAPE], chi2 = 0;
    *ok = 1;
    for (size_t i = 0; i < n && *ok; i++) {
        *ok = precision(&fits[i], at, q, W);
        for (size_t a = 0; a < q && *ok; a++)
            for (size_t b = 0; b < q; b++) {
                total[a * q + b] += W[a * q + b];
                mean[a] += W[a * q + b] * fits[i].shape_value[at[b]].value;
            }
    }
    *ok = *ok && cholesky(total, q);
    if (!*ok) return 0;
    solve(total, q, mean);
    for (size_t i = 0; i < n; i++) {
        precision(&fits[i], at, q, W);
        for (size_t a = 0; a < q; a++)
            for (size_t b = 0; b < q; b++)
                chi2 += (fits[i].shape_value[at[a]].value - mean[a]) * W[a * q + b] * (fits[i].shape_value[at[b]].value - mean[b]);
    }
    return chi2;
}

ff_status ff_trust_channels_differ_into(const ff_fit_result *fits, size_t n, ff_difference *out, ff_error *err)
{
    uint32_t at[FF_MAX_SHAPE];
    int ok = 0;
    for (size_t i = 1; i < n; i++)
        if (fits[i].model.n_shape != fits->model.n_shape || fits[i].model.lobe[0].ndf != fits->model.lobe[0].ndf)
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "fits of different models have no common shape");
    for (size_t i = 0; i < n; i++)
        if (!fits[i].correlation) n = 0;
    const size_t q = n > 1 ? comparable(fits, n, at) : 0;
    const double chi2 = q ? chi2_of(fits, n, at, q, &ok) : 0;
    *out = (ff_difference){.p = 1};
    if (ok) *out = (ff_difference){chi2, ff_chi2_tail(chi2, (double)(q * (n - 1))), q * (n - 1)};
    return FF_OK;
}
