/* The normal equations of the whole parameter set, and what they say about its uncertainty. */
#include "internal_errors.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

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
static double of_data(const ff_plan *plan, const ff_uncertainty *u, size_t k)
{
    return fmin(fmax(1 - ff_penalties_weight(plan, k) * u->inverse[k * plan->l.P + k], 1e-9), 1);
}

/* Parameters that a fit of one channel finds from the data. */
static double parameters_of_channel(const ff_plan *plan, const ff_uncertainty *u)
{
    const ff_layout *l = &plan->l;
    double sum = 0;
    for (size_t k = 0; k < l->P; k++)
        if (u->inverse[k * l->P + k] > 0) sum += of_data(plan, u, k) / (k < l->n_shared ? 1 : (double)l->n_channels);
    return sum;
}

double ff_clusters_seen(const ff_plan *plan, const ff_uncertainty *u, double number)
{
    return ff_clusters_share_seen(parameters_of_channel(plan, u), number);
}

/* u->dof is still the number of clusters. */
static double seen_of(const ff_plan *plan, const ff_uncertainty *u, size_t k)
{
    const double data = of_data(plan, u, k);
    return data * ff_clusters_seen(plan, u, u->dof[k]) + 1 - data;
}

/* Degrees of freedom, and errors as large as they are. */
static ff_status widen(const ff_plan *plan, const ff_normal *n, int sigma, size_t n_samples, ff_uncertainty *u)
{
    const struct ff_problem *p = plan->p;
    const size_t P = n->P, length = ff_run_length(p), run = u->clusters.run > length ? u->clusters.run : length,
                 clusters = (p->n + run - 1) / run;
    for (size_t k = 0; k < P; k++) u->dof[k] = INFINITY;
    if ((sigma && u->clusters.run == 1) || !n->runs) return FF_OK;
    const ff_status st = ff_clusters_informative(p, n, n_samples, NULL, clusters, u->inverse, NULL, u->dof);
    for (size_t a = 0; a < P && !st && u->clusters.run > 1; a++) /* of single samples there are so many that nothing is missed */
        for (size_t b = 0; b < P; b++) u->cov[a * P + b] /= sqrt(seen_of(plan, u, a) * seen_of(plan, u, b));
    for (size_t k = 0; k < P && !st; k++) u->dof[k] = (u->dof[k] - 1) / of_data(plan, u, k);
    return st;
}

static ff_status fill_uncertainty(const ff_plan *plan, const ff_normal *n, const subset *s, const double *H, int sigma,
                                  size_t n_samples, ff_uncertainty *u, double *work)
{
    const ff_layout *l = &plan->l;
    const struct ff_problem *p = plan->p;
    const size_t P = l->P, k = s->n;
    const double N = (double)(n_samples * l->n_channels);
    double *meat = work, *inverse = meat + P * (P + 1) / 2, *cov = inverse + k * k, *single = cov + k * k, *rest = single + k * k;
    ff_status st = ff_clusters_meat(p, n, n_samples, u->clusters.run, meat);
    if (st) return st;
    u->effective = ff_clusters_effective(n, meat, l->n_shared, N);
    const double factor = !sigma && N > (double)k ? (N - 1) / (N - (double)k) : 1;
    ff_penalties_covariance(plan, 1 / factor, NULL, meat); /* a prior is a datum whose variance is known */
    invert(s, H, P, inverse, rest);
    sandwich(s, inverse, meat, cov, rest);
    if (sigma && u->clusters.run > 1) {
        memcpy(meat, n->meat, P * (P + 1) / 2 * sizeof *meat);
        ff_penalties_covariance(plan, 1, NULL, meat);
        sandwich(s, inverse, meat, single, rest);
        memcpy(rest, inverse, k * k * sizeof *rest);
        stretch(s, single, cov, rest);
        memcpy(cov, rest, k * k * sizeof *cov);
    } else if (sigma) {
        memcpy(cov, inverse, k * k * sizeof *cov);
    }
    spread_out(s, inverse, 1, P, u->inverse);
    spread_out(s, cov, factor, P, u->cov);
    st = widen(plan, n, sigma, n_samples, u);
    if (st) return st;
    /* with as many parameters as values nothing is left to estimate the noise from */
    const int enough = sigma || N > (double)k;
    for (size_t i = 0; i < k; i++)
        u->determined[s->index[i]] = inverse[i * k + i] < FF_UNDETERMINED && H[s->index[i] * P + s->index[i]] > 0 && enough;
    return FF_OK;
}

ff_status ff_uncertainty_new(const ff_plan *plan, const ff_normal *n, const int *use, size_t n_samples, ff_uncertainty *out)
{
    const ff_layout *l = &plan->l;
    const struct ff_problem *p = plan->p;
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
        ff_penalties_covariance(plan, 1, H, NULL);
        for (size_t i = 0; i < P; i++)
            if (use[i]) s.index[s.n++] = i;
        for (size_t i = 0; i < s.n; i++) {
            s.D[i] = sqrt(H[s.index[i] * P + s.index[i]]);
            if (!(s.D[i] > 0)) s.D[i] = 1e-150; /* no effect at all: the ridge then marks it */
        }
        st = fill_uncertainty(plan, n, &s, H, sigma, n_samples, &u, s.D + P);
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

static ff_status uncertainty(const ff_plan *plan, const ff_point *at, int all, ff_uncertainty *out)
{
    int *use = malloc((plan->l.P + 1) * sizeof *use);
    if (!use) return FF_ERR_MEMORY;
    for (size_t k = 0; k < plan->l.P; k++) use[k] = all || at->at_bound[k] == 0;
    const ff_status st = ff_uncertainty_new(plan, &at->normal, use, plan->p->n, out);
    free(use);
    return st;
}

ff_status ff_uncertainty_at(const ff_plan *plan, const ff_point *at, ff_uncertainty *out)
{
    return uncertainty(plan, at, 0, out);
}

ff_status ff_uncertainty_of_all(const ff_plan *plan, const ff_point *at, ff_uncertainty *out)
{
    return uncertainty(plan, at, 1, out);
}
