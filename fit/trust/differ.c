/* Do the channels of a measurement have different shapes? Johansen's test of the fits of each alone (Biometrika 67, 1980, 85-92):
 * means that are known by errors which are estimates themselves, each with its degrees of freedom; Welch's (1951) of one parameter.
 * In the coordinates of the fit, where an error does not go with the value. */
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

/* x = A^-1 x, A = L L^T. */
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

static double coordinate(const ff_fit_result *fit, uint32_t k)
{
    return ff_coordinate(fit->model.shape[k].info, fit->shape_value[k].value);
}

static double error_of(const ff_fit_result *fit, uint32_t k)
{
    return fit->shape_value[k].std_error / ff_coordinate_slope(fit->model.shape[k].info, fit->shape_value[k].value);
}

/* Inverse covariance [q][q] of the comparable parameters of a fit. */
static int precision(const ff_fit_result *fit, const uint32_t *at, size_t q, double *out)
{
    double L[FF_MAX_SHAPE * FF_MAX_SHAPE], x[FF_MAX_SHAPE];
    for (size_t a = 0; a < q; a++)
        for (size_t b = 0; b < q; b++) {
            const size_t i = (size_t)fit->shape_value[at[a]].column, j = (size_t)fit->shape_value[at[b]].column;
            L[a * q + b] = error_of(fit, at[a]) * error_of(fit, at[b]) * fit->correlation[i * fit->n_columns + j];
        }
    if (!cholesky(L, q)) return 0;
    for (size_t b = 0; b < q; b++) {
        for (size_t a = 0; a < q; a++) x[a] = a == b;
        solve(L, q, x);
        for (size_t a = 0; a < q; a++) out[a * q + b] = x[a];
    }
    return 1;
}

/* Degrees of freedom of the errors of a fit: those of the parameter whose error is known worst. */
static double degrees_of_errors(const ff_fit_result *fit, const uint32_t *at, size_t q)
{
    double t = 0;
    for (size_t a = 0; a < q; a++) t = fmax(t, fit->shape_value[at[a]].student_t);
    return ff_student_degrees(0.95, t);
}

/* The common mean of the parameters by the weights W of all fits: L of their sum, and that of W times the values. */
static int find_mean(const ff_fit_result *fits, size_t n, const uint32_t *at, size_t q, double *total, double *mean)
{
    double W[FF_MAX_SHAPE * FF_MAX_SHAPE];
    for (size_t i = 0; i < n; i++) {
        if (!precision(&fits[i], at, q, W)) return 0;
        for (size_t a = 0; a < q; a++)
            for (size_t b = 0; b < q; b++) {
                total[a * q + b] += W[a * q + b];
                mean[a] += W[a * q + b] * coordinate(&fits[i], at[b]);
            }
    }
    if (!cholesky(total, q)) return 0;
    solve(total, q, mean);
    return 1;
}

static double square_of(const ff_fit_result *fit, const uint32_t *at, size_t q, const double *W, const double *mean)
{
    double sum = 0;
    for (size_t a = 0; a < q; a++)
        for (size_t b = 0; b < q; b++)
            sum += (coordinate(fit, at[a]) - mean[a]) * W[a * q + b] * (coordinate(fit, at[b]) - mean[b]);
    return sum;
}

/* tr(R^2) + tr(R)^2 of R = 1 - total^-1 W: how much the test feels that W is estimated. L: of the total. */
static double share_of_others(const double *L, size_t q, const double *W)
{
    double R[FF_MAX_SHAPE * FF_MAX_SHAPE], x[FF_MAX_SHAPE], trace = 0, squares = 0;
    for (size_t b = 0; b < q; b++) {
        for (size_t a = 0; a < q; a++) x[a] = W[a * q + b];
        solve(L, q, x);
        for (size_t a = 0; a < q; a++) R[a * q + b] = (a == b) - x[a];
        trace += R[b * q + b];
    }
    for (size_t a = 0; a < q; a++)
        for (size_t b = 0; b < q; b++) squares += R[a * q + b] * R[b * q + a];
    return squares + trace * trace;
}

static ff_difference test(const ff_fit_result *fits, size_t n, const uint32_t *at, size_t q)
{
    double total[FF_MAX_SHAPE * FF_MAX_SHAPE] = {0}, mean[FF_MAX_SHAPE] = {0}, W[FF_MAX_SHAPE * FF_MAX_SHAPE], A = 0;
    ff_difference d = {.p = 1};
    if (!find_mean(fits, n, at, q, total, mean)) return d;
    d.dof = q * (n - 1);
    for (size_t i = 0; i < n; i++) {
        precision(&fits[i], at, q, W);
        d.chi2 += square_of(&fits[i], at, q, W, mean);
        A += 0.5 * share_of_others(total, q, W) / degrees_of_errors(&fits[i], at, q);
    }
    const double m = (double)d.dof;
    d.error_dof = A > 0 ? m * (m + 2) / (3 * A) : INFINITY;
    d.f = d.chi2 / (m + 2 * A - 6 * A / (m + 2));
    d.p = ff_f_tail(d.f, m, d.error_dof);
    return d;
}

ff_status ff_trust_channels_differ_into(const ff_fit_result *fits, size_t n, ff_difference *out, ff_error *err)
{
    uint32_t at[FF_MAX_SHAPE];
    for (size_t i = 1; i < n; i++)
        if (fits[i].model.n_shape != fits->model.n_shape || fits[i].model.lobe[0].ndf != fits->model.lobe[0].ndf)
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "fits of different models have no common shape");
    for (size_t i = 0; i < n; i++)
        if (!fits[i].correlation) n = 0;
    const size_t q = n > 1 ? comparable(fits, n, at) : 0;
    *out = q ? test(fits, n, at, q) : (ff_difference){.p = 1};
    return FF_OK;
}
