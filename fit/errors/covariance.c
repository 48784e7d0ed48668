/* The normal equations of the whole parameter set, and what they say about its uncertainty. */
#include "fit/internal_fit.h"
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

/* Squares of the score of single values add up over channels; of columns that meet in one value their sum is not known, -1 says so.
 */
static double fold_own(const ff_layout *l, size_t i, double before, double square)
{
    const size_t at = coordinate_of(l, i), shape = l->free.n_shape;
    for (size_t k = 0; k < shape + l->free.n_channel; k++) {
        const size_t c = i < shape ? 0 : (i - shape) / l->free.n_channel,
                     column = i < shape ? i : shape + (i - shape) % l->free.n_channel;
        if (k != column && ff_layout_coordinate(l, c, k) == at) return -1;
    }
    return before < 0 ? before : before + square;
}

ff_status ff_normal_fold(const ff_layout *l, ff_normal *n)
{
    const size_t P = l->P, from = n->P;
    if (from == P) return FF_OK;
    double *meat = calloc(P * (P + 1) / 2 + 1, sizeof *meat), *own = calloc(P + 1, sizeof *own),
           *sums = malloc((P + 1) * sizeof *sums);
    const ff_status st = meat && own && sums ? FF_OK : FF_ERR_MEMORY;
    for (size_t i = 0; i < from && !st; i++) {
        const size_t a = coordinate_of(l, i);
        for (size_t j = 0; j < from; j++) {
            const size_t b = coordinate_of(l, j);
            if (a >= b) meat[ff_tri(a, b)] += n->meat[ff_tri(i, j)];
        }
        own[a] = fold_own(l, i, own[a], n->own[i]);
    }
    for (size_t k = 0; k < P && !st; k++) own[k] = fmax(own[k], 0);
    for (size_t r = 0; n->runs && r < n->n_runs && !st; r++) { /* shorter rows: in place */
        memset(sums, 0, P * sizeof *sums);
        for (size_t i = 0; i < from; i++) sums[coordinate_of(l, i)] += n->runs[r * from + i];
        memcpy(n->runs + r * P, sums, P * sizeof *sums);
    }
    free(sums);
    if (st) {
        free(meat);
        free(own);
        return st;
    }
    free(n->meat);
    free(n->own);
    n->meat = meat;
    n->own = own;
    n->P = P;
    return FF_OK;
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

/* The parameters in use: places and scales of their columns. */
typedef struct subset {
    size_t n, *index;
    double *D; /* root of the diagonal of H */
} subset;

/* inverse [k][k] of the scaled H with its ridge; work [3 k^2 + 3 k]. */
static void invert(const subset *s, const double *H, size_t P, double *inverse, double *work)
{
    const size_t k = s->n;
    double *A = work, *L = A + k * k, *e = L + k * k, *column = e + k, *x = column + k;
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++)
            A[i * k + j] = H[s->index[i] * P + s->index[j]] / (s->D[i] * s->D[j]) + (i == j ? FF_RIDGE : 0);
    ff_scaled_cholesky(A, k, 0, L, e);
    /* ff_scaled_cholesky scales once more, by e close to 1: (A)^-1 = E^-1 (L L^T)^-1 E^-1 */
    for (size_t j = 0; j < k; j++) {
        for (size_t i = 0; i < k; i++) {
            column[i] = i == j ? 1 : 0;
            if (!(L[i * k + i] > 0)) L[i * k + i] = sqrt(FF_RIDGE);
        }
        solve_cholesky(L, k, column, x);
        for (size_t i = 0; i < k; i++) inverse[i * k + j] = x[i] / (e[i] > 0 ? e[i] : 1) / (e[j] > 0 ? e[j] : 1);
    }
}

/* A B, [k][k] each */
static void multiply(const double *A, const double *B, size_t k, double *out)
{
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) {
            double v = 0;
            for (size_t q = 0; q < k; q++) v += A[i * k + q] * B[q * k + j];
            out[i * k + j] = v;
        }
}

/* out = inverse M inverse of the scaled subset; work [2 k^2]. */
static void sandwich(const subset *s, const double *inverse, const double *meat, double *out, double *work)
{
    const size_t k = s->n;
    double *M = work, *T = M + k * k;
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) M[i * k + j] = meat[ff_tri(s->index[i], s->index[j])] / (s->D[i] * s->D[j]);
    multiply(inverse, M, k, T);
    multiply(T, inverse, k, out);
}

/* From the scaled subset to the parameters: the mean of two roundings, so that it is symmetric to the last bit. */
static void spread_out(const subset *s, const double *scaled, double factor, size_t P, double *out)
{
    const size_t k = s->n;
    memset(out, 0, P * P * sizeof *out);
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++)
            out[s->index[i] * P + s->index[j]] = factor * 0.5 * (scaled[i * k + j] + scaled[j * k + i]) / (s->D[i] * s->D[j]);
}

/* Errors that the data's own standard deviations give, larger by what clusters have more than samples. */
static void stretch(const subset *s, const double *single, const double *clustered, double *scaled)
{
    const size_t k = s->n;
    for (size_t i = 0; i < k; i++)
        for (size_t j = 0; j < k; j++) {
            const double fi = single[i * k + i] > 0 ? clustered[i * k + i] / single[i * k + i] : 1,
                         fj = single[j * k + j] > 0 ? clustered[j * k + j] / single[j * k + j] : 1;
            scaled[i * k + j] *= sqrt(fmax(fi, 1) * fmax(fj, 1));
        }
}

/* Share of what is known of a parameter that the data say; a prior is not estimated from clusters. */
static double of_data(const ff_layout *l, const ff_uncertainty *u, size_t k)
{
    return fmin(fmax(1 - ff_extras_weight(l, k) * u->inverse[k * l->P + k], 1e-9), 1);
}

/* Parameters that a fit of one channel finds from the data. */
static double parameters_of_channel(const ff_layout *l, const ff_uncertainty *u)
{
    double sum = 0;
    for (size_t k = 0; k < l->P; k++)
        if (u->inverse[k * l->P + k] > 0) sum += of_data(l, u, k) / (k < l->n_shared ? 1 : (double)l->n_channels);
    return sum;
}

double ff_clusters_seen(const ff_layout *l, const ff_uncertainty *u, double number)
{
    return ff_clusters_share_seen(parameters_of_channel(l, u), number);
}

/* u->dof is still the number of clusters. */
static double seen_of(const ff_layout *l, const ff_uncertainty *u, size_t k)
{
    const double data = of_data(l, u, k);
    return data * ff_clusters_seen(l, u, u->dof[k]) + 1 - data;
}

/* Degrees of freedom, and errors as large as they are. */
static ff_status widen(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, int sigma, size_t n_samples,
                       ff_uncertainty *u)
{
    const size_t P = n->P, length = ff_run_length(p), run = u->clusters.run > length ? u->clusters.run : length,
                 clusters = (p->n + run - 1) / run;
    for (size_t k = 0; k < P; k++) u->dof[k] = INFINITY;
    if ((sigma && u->clusters.run == 1) || !n->runs) return FF_OK;
    const ff_status st = ff_clusters_informative(p, n, n_samples, NULL, clusters, u->inverse, NULL, u->dof);
    for (size_t a = 0; a < P && !st && u->clusters.run > 1; a++) /* of single samples there are so many that nothing is missed */
        for (size_t b = 0; b < P; b++) u->cov[a * P + b] /= sqrt(seen_of(l, u, a) * seen_of(l, u, b));
    for (size_t k = 0; k < P && !st; k++) u->dof[k] = (u->dof[k] - 1) / of_data(l, u, k);
    return st;
}

static ff_status fill_uncertainty(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const subset *s,
                                  const double *H, int sigma, size_t n_samples, ff_uncertainty *u, double *work)
{
    const size_t P = l->P, k = s->n;
    const double N = (double)(n_samples * l->n_channels);
    double *meat = work, *inverse = meat + P * (P + 1) / 2, *cov = inverse + k * k, *single = cov + k * k, *rest = single + k * k;
    ff_status st = ff_clusters_meat(p, n, n_samples, u->clusters.run, meat);
    if (st) return st;
    u->effective = ff_clusters_effective(n, meat, l->n_shared, N);
    const double factor = !sigma && N > (double)k ? (N - 1) / (N - (double)k) : 1;
    ff_extras_covariance(l, 1 / factor, NULL, meat); /* a prior is a datum whose variance is known */
    invert(s, H, P, inverse, rest);
    sandwich(s, inverse, meat, cov, rest);
    if (sigma && u->clusters.run > 1) {
        memcpy(meat, n->meat, P * (P + 1) / 2 * sizeof *meat);
        ff_extras_covariance(l, 1, NULL, meat);
        sandwich(s, inverse, meat, single, rest);
        memcpy(rest, inverse, k * k * sizeof *rest);
        stretch(s, single, cov, rest);
        memcpy(cov, rest, k * k * sizeof *cov);
    } else if (sigma) {
        memcpy(cov, inverse, k * k * sizeof *cov);
    }
    spread_out(s, inverse, 1, P, u->inverse);
    spread_out(s, cov, factor, P, u->cov);
    st = widen(l, p, n, sigma, n_samples, u);
    if (st) return st;
    /* with as many parameters as values nothing is left to estimate the noise from */
    const int enough = sigma || N > (double)k;
    for (size_t i = 0; i < k; i++)
        u->determined[s->index[i]] = inverse[i * k + i] < FF_UNDETERMINED && H[s->index[i] * P + s->index[i]] > 0 && enough;
    return FF_OK;
}

ff_status ff_uncertainty_new(const ff_layout *l, const struct ff_problem *p, const ff_normal *n, const int *use, size_t n_samples,
                             ff_uncertainty *out)
{
    const int sigma = p->selection.weighting == FF_WEIGHT_SIGMA;
    const size_t P = l->P;
    ff_uncertainty u = {.storage = calloc(2 * P * P + P + 1, sizeof *u.storage), .determined = calloc(P + 1, sizeof *u.determined)};
    subset s = {.index = malloc((P + 1) * sizeof *s.index)};
    double *work = calloc(10 * P * P + 6 * P + 2, sizeof *work);
    ff_status st = u.storage && u.determined && s.index && work ? ff_clusters_choose(p, n, n_samples, &u.clusters) : FF_ERR_MEMORY;
    if (!st) {
        u.inverse = u.storage;
        u.cov = u.storage + P * P;
        u.dof = u.cov + P * P;
        double *H = work, *g = H + P * P;
        s.D = g + P;
        ff_normal_assemble(l, n, NULL, H, g);
        ff_extras_covariance(l, 1, H, NULL);
        for (size_t i = 0; i < P; i++)
            if (use[i]) s.index[s.n++] = i;
        for (size_t i = 0; i < s.n; i++) {
            s.D[i] = sqrt(H[s.index[i] * P + s.index[i]]);
            if (!(s.D[i] > 0)) s.D[i] = 1e-150; /* no effect at all: the ridge then marks it */
        }
        st = fill_uncertainty(l, p, n, &s, H, sigma, n_samples, &u, s.D + P);
    }
    free(s.index);
    free(work);
    if (st) {
        ff_uncertainty_free(&u);
        return st;
    }
    *out = u;
    return FF_OK;
}

void ff_uncertainty_free(ff_uncertainty *u)
{
    free(u->storage);
    free(u->determined);
    *u = (ff_uncertainty){0};
}

/* ---- eigenvalues ----------------------------------------------------------------------------- */

/* One rotation that makes A[p][q] zero (Golub and Van Loan, Matrix Computations, 8.5). */
static void rotate(double *A, size_t n, size_t p, size_t q, double *V)
{
    const double apq = A[p * n + q], theta = (A[q * n + q] - A[p * n + p]) / (2 * apq);
    const double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(1 + theta * theta)), c = 1 / sqrt(1 + t * t), s = t * c;
    for (size_t k = 0; k < n; k++) {
        const double a = A[k * n + p], b = A[k * n + q];
        A[k * n + p] = c * a - s * b;
        A[k * n + q] = s * a + c * b;
    }
    for (size_t k = 0; k < n; k++) {
        const double a = A[p * n + k], b = A[q * n + k];
        A[p * n + k] = c * a - s * b;
        A[q * n + k] = s * a + c * b;
    }
    for (size_t k = 0; k < n; k++) {
        const double a = V[k * n + p], b = V[k * n + q];
        V[k * n + p] = c * a - s * b;
        V[k * n + q] = s * a + c * b;
    }
}

static void order_columns(size_t n, double *values, double *V)
{
    for (size_t i = 0; i < n; i++) {
        size_t least = i;
        for (size_t j = i + 1; j < n; j++)
            if (values[j] < values[least]) least = j;
        if (least == i) continue;
        const double v = values[i];
        values[i] = values[least];
        values[least] = v;
        for (size_t k = 0; k < n; k++) {
            const double a = V[k * n + i];
            V[k * n + i] = V[k * n + least];
            V[k * n + least] = a;
        }
    }
}

void ff_symmetric_eigen(double *A, size_t n, double *values, double *V)
{
    enum { SWEEPS = 60 };
    double scale = 0;
    for (size_t i = 0; i < n * n; i++) {
        scale += A[i] * A[i];
        V[i] = i % (n + 1) == 0;
    }
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double off = 0;
        for (size_t p = 0; p < n; p++)
            for (size_t q = p + 1; q < n; q++) off += A[p * n + q] * A[p * n + q];
        if (!(off > 1e-32 * scale)) break;
        for (size_t p = 0; p < n; p++)
            for (size_t q = p + 1; q < n; q++)
                if (fabs(A[p * n + q]) > 1e-300) rotate(A, n, p, q, V);
    }
    for (size_t i = 0; i < n; i++) values[i] = A[i * n + i];
    order_columns(n, values, V);
}
