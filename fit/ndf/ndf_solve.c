/* The penalised least squares of a curve: Levenberg-Marquardt steps inside bounds, and what is said of an optimum.
 *
 *   1/2 sum r^2 + smooth / 2 sum_k v_k (e_(k-1) - e_k)^2 / step^3
 *
 * e are the falls of the coefficients less those of the reference, so that the penalty is on the second difference of
 * ln (D / D_reference): smooth / 2 integral v (d^2/dy^2)^2 dy. v is the variance of the residuals near the node, which makes
 * `smooth` a pure number: one over the variance, per unit of y, of the curvature that the surface may have beyond the reference. */
#include "internal_ndf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- memory ---------------------------------------------------------------------------------- */

ff_status ff_ndf_fit_new(const ff_curve *curve, const ff_fit_options *o, int masking, double masking_own, int scaled,
                         size_t n_channels, ff_ndf_fit *out)
{
    ff_ndf_fit f = {.curve = curve,
                    .o = o,
                    .masking = masking,
                    .masking_own = masking_own,
                    .scaled = scaled,
                    .n_channels = n_channels,
                    .P = (size_t)curve->top + 2 * n_channels};
    const size_t P = f.P;
    ff_status status = ff_curve_state_new(curve, &f.state);
    if (!status) status = ff_ndf_sums_new(curve, n_channels, &f.sums);
    f.H = calloc(3 * P * P + 10 * P, sizeof *f.H);
    f.X = calloc(2 * f.sums.n * P + 1, sizeof *f.X);
    f.held = calloc(P, sizeof *f.held);
    f.index = calloc(P, sizeof *f.index);
    if (!status && (!f.H || !f.X || !f.held || !f.index)) status = FF_ERR_MEMORY;
    if (status) {
        ff_ndf_fit_free(&f);
        return status;
    }
    f.A = f.H + P * P;
    f.L = f.A + P * P;
    double *next = f.L + P * P;
    double **const vectors[] = {&f.g, &f.D, &f.step, &f.trial, &f.work, &f.u, &f.lower, &f.upper, &f.reference, &f.variance};
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++, next += P) *vectors[i] = next;
    *out = f;
    return FF_OK;
}

void ff_ndf_fit_free(ff_ndf_fit *f)
{
    free(f->H);
    free(f->X);
    free(f->held);
    free(f->index);
    ff_curve_state_free(&f->state);
    ff_ndf_sums_free(&f->sums);
    *f = (ff_ndf_fit){.P = 0};
}

/* ---- from raw columns to parameters ---------------------------------------------------------- */

/* Derivatives by the coefficients -> by the falls: c[m] = -(u[0] + ... + u[m-1]). */
static void by_falls(const double *by_c, size_t top, double *out)
{
    double sum = 0;
    for (size_t k = top; k >= 1; k--) out[k - 1] = sum -= by_c[k];
}

/* X [n][P] = d raw column / d parameter; the coefficients less ln A. */
static void fill_slopes(ff_ndf_fit *f)
{
    const size_t top = (size_t)f->curve->top, P = f->P, n_curve = f->sums.n_curve;
    memset(f->X, 0, f->sums.n * P * sizeof *f->X);
    by_falls(f->state.d_area, top, f->work);
    for (size_t m = 0; m <= top; m++)
        for (size_t k = 0; k < top; k++) f->X[m * P + k] = (k < m ? -1 : 0) - f->work[k];
    for (size_t j = 0; j < (size_t)f->curve->n_lambda; j++)
        by_falls(f->state.d_lambda + j * n_curve, top, f->X + (n_curve + j) * P);
    for (size_t k = top; k < P; k++) f->X[(f->sums.n_raw + k - top) * P + k] = 1;
}

/* out [P][P] = X^T M X */
static void transform(const ff_ndf_fit *f, const double *M, double *out)
{
    const size_t n = f->sums.n, P = f->P;
    double *half = f->X + n * P;
    memset(half, 0, n * P * sizeof *half);
    memset(out, 0, P * P * sizeof *out);
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < n; j++)
            for (size_t k = 0; k < P; k++) half[i * P + k] += M[i * n + j] * f->X[j * P + k];
    for (size_t i = 0; i < n; i++)
        for (size_t a = 0; a < P; a++)
            for (size_t b = 0; b < P; b++) out[a * P + b] += f->X[i * P + a] * half[i * P + b];
}

/* ---- the penalty ----------------------------------------------------------------------------- */

/* Term k < top is the second difference of ln (D / D_reference) at node k, between the falls k - 1 and k. At node 0, where the
 * curve meets its mirror image, it is twice the first fall, and the node stands for half a step. */
static double penalty_term(const ff_ndf_fit *f, size_t k, double *weight)
{
    const double h = f->curve->step, here = f->u[k] - f->reference[k];
    *weight = f->smooth * f->variance[k] / (h * h * h) * (k ? 1 : 0.5);
    return k ? f->u[k - 1] - f->reference[k - 1] - here : -2 * here;
}

double ff_ndf_penalty2(const ff_ndf_fit *f)
{
    double sum = 0, w;
    for (size_t k = 0; k < (size_t)f->curve->top; k++) {
        const double t = penalty_term(f, k, &w);
        sum += w * t * t;
    }
    return sum;
}

/* A += sum of factor[k] times the second derivative of term k (NULL: 1); g += the gradient, NULL: not wanted. */
static void add_penalty(const ff_ndf_fit *f, const double *factor, double *A, double *g)
{
    const size_t P = f->P;
    for (size_t k = 0; k < (size_t)f->curve->top; k++) {
        double w;
        const double t = penalty_term(f, k, &w), here = k ? -1 : -2;
        if (factor) w *= factor[k];
        A[k * P + k] += w * here * here;
        if (g) g[k] += w * here * t;
        if (k == 0) continue;
        A[(k - 1) * P + k - 1] += w;
        A[(k - 1) * P + k] += w * here;
        A[k * P + k - 1] += w * here;
        if (g) g[k - 1] += w * t;
    }
}

/* ---- linear algebra -------------------------------------------------------------------------- */

/* Factor of the rows and columns of A that are not held, listed in index; returns their number. */
static size_t factor(ff_ndf_fit *f, const double *A)
{
    size_t n = 0;
    for (size_t k = 0; k < f->P; k++)
        if (!f->held[k]) f->index[n++] = k;
    double *sub = f->X + f->sums.n * f->P; /* P <= n */
    for (size_t a = 0; a < n; a++)
        for (size_t b = 0; b < n; b++) sub[a * n + b] = A[f->index[a] * f->P + f->index[b]];
    ff_scaled_cholesky(sub, n, 1e-15, f->L, f->D);
    return n;
}

/* x [n] = (D L L^T D)^-1 x; 0 where the factor has a zero column. */
static void solve(const ff_ndf_fit *f, size_t n, double *x)
{
    const double *L = f->L, *D = f->D;
    for (size_t a = 0; a < n; a++) {
        double v = L[a * n + a] > 0 ? x[a] / D[a] : 0;
        for (size_t b = 0; b < a; b++) v -= L[a * n + b] * x[b];
        x[a] = L[a * n + a] > 0 ? v / L[a * n + a] : 0;
    }
    for (size_t a = n; a-- > 0;) {
        double v = x[a];
        for (size_t b = a + 1; b < n; b++) v -= L[b * n + a] * x[b];
        x[a] = L[a * n + a] > 0 ? v / L[a * n + a] : 0;
    }
    for (size_t a = 0; a < n; a++) x[a] = D[a] > 0 ? x[a] / D[a] : 0;
}

/* ---- steps inside the box -------------------------------------------------------------------- */

/* g + A step, row k */
static double slope_at(const ff_ndf_fit *f, size_t k)
{
    double v = f->g[k];
    for (size_t j = 0; j < f->P; j++) v += f->A[k * f->P + j] * f->step[j];
    return v;
}

/* Is parameter k of u + step on its bound, and where does the slope v press it? 1: against that bound. */
static int is_pressed(const ff_ndf_fit *f, size_t k, double v)
{
    const double at = f->u[k] + f->step[k];
    return (at <= f->lower[k] && v >= 0) || (at >= f->upper[k] && v <= 0);
}

/* Goes from f->step towards the minimum over what is free; stops at the first bound and holds what has met it. 1: all the way. */
static int go_to_minimum(ff_ndf_fit *f)
{
    const size_t n = factor(f, f->A);
    double *x = f->work, part = 1, met = 0;
    size_t blocking = f->P;
    for (size_t a = 0; a < n; a++) x[a] = -slope_at(f, f->index[a]);
    solve(f, n, x);
    for (size_t a = 0; a < n; a++) {
        const size_t k = f->index[a];
        const double from = f->u[k] + f->step[k], bound = x[a] < 0 ? f->lower[k] : f->upper[k];
        if (x[a] == 0 || (bound - from) / x[a] >= part) continue;
        part = fmax((bound - from) / x[a], 0);
        blocking = k;
        met = bound;
    }
    for (size_t a = 0; a < n; a++) f->step[f->index[a]] += part * x[a];
    if (blocking == f->P) return 1;
    f->held[blocking] = 1;
    f->step[blocking] = met - f->u[blocking];
    return 0;
}

/* The held parameter that the slope pulls inside most, by the scale of its diagonal; P: none. */
static size_t most_pulled(const ff_ndf_fit *f)
{
    size_t most = f->P;
    double best = 0;
    for (size_t k = 0; k < f->P; k++) {
        const double v = f->held[k] ? slope_at(f, k) : 0, pull = v * v / fmax(f->A[k * f->P + k], 1e-300);
        if (!f->held[k] || is_pressed(f, k, v) || pull <= best) continue;
        best = pull;
        most = k;
    }
    return most;
}

/* f->step: the minimum of g.s + s.A s / 2 inside the box, by an active set. */
static void step_inside(ff_ndf_fit *f)
{
    memset(f->step, 0, f->P * sizeof *f->step);
    for (size_t k = 0; k < f->P; k++) f->held[k] = is_pressed(f, k, f->g[k]);
    for (size_t round = 0; round < 4 * f->P; round++) {
        if (!go_to_minimum(f)) continue;
        const size_t k = most_pulled(f);
        if (k == f->P) return;
        f->held[k] = 0;
    }
}

/* What the quadratic model gains by f->step. */
static double gain(const ff_ndf_fit *f)
{
    double v = 0;
    for (size_t k = 0; k < f->P; k++) v -= 0.5 * f->step[k] * (f->g[k] + slope_at(f, k));
    return v;
}

/* ---- the iteration --------------------------------------------------------------------------- */

static ff_ndf_place place_of(const ff_ndf_fit *f, const struct ff_problem *p)
{
    return (ff_ndf_place){.p = p,
                          .curve = f->curve,
                          .state = &f->state,
                          .masking = f->masking,
                          .masking_own = f->masking_own,
                          .scaled = f->scaled,
                          .channel = f->u + f->curve->top};
}

/* Sums at u; 1/2 cost2 and the penalty. */
static ff_status evaluate(ff_ndf_fit *f, const struct ff_problem *p, int with_products, double *objective)
{
    const size_t top = (size_t)f->curve->top;
    if (ff_fit_cancelled(f->o)) return FF_ERR_CANCELLED;
    f->state.c[0] = 0;
    for (size_t k = 0; k < top; k++) f->state.c[k + 1] = f->state.c[k] - f->u[k];
    ff_curve_evaluate(f->curve, &f->state);
    const ff_ndf_place at = place_of(f, p);
    f->passes++;
    const ff_status status = ff_ndf_sum(&at, with_products, &f->sums);
    *objective = 0.5 * (f->sums.cost2 + ff_ndf_penalty2(f));
    return status;
}

/* H and g at the last pass. */
static void assemble_into(ff_ndf_fit *f, double *H)
{
    const size_t n = f->sums.n, P = f->P;
    fill_slopes(f);
    transform(f, f->sums.gram, H);
    memset(f->g, 0, P * sizeof *f->g);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < P; k++) f->g[k] += f->X[i * P + k] * f->sums.gradient[i];
    add_penalty(f, NULL, H, f->g);
}

static void assemble(ff_ndf_fit *f)
{
    assemble_into(f, f->H);
}

/* A damped step; what the model gains by it. */
static double propose(ff_ndf_fit *f, double damping)
{
    const size_t P = f->P;
    memcpy(f->A, f->H, P * P * sizeof *f->A);
    for (size_t k = 0; k < P; k++) f->A[k * P + k] *= 1 + damping;
    step_inside(f);
    return gain(f);
}

ff_status ff_ndf_solve(ff_ndf_fit *f, const struct ff_problem *p, double tolerance, int max_iterations, ff_outcome *outcome)
{
    double objective, damping = 1e-6, tried;
    ff_status status = evaluate(f, p, 0, &objective);
    *outcome = FF_LIMIT;
    for (int iteration = 0; !status && iteration < max_iterations && damping < 1e12; iteration++) {
        assemble(f);
        if (f->o->progress) f->o->progress(f->o->progress_context, f->iterations, objective);
        f->iterations++;
        for (int moved = 0; !status && !moved && damping < 1e12;) {
            const double expected = propose(f, damping);
            if (expected <= tolerance * objective * (damping > 1e-3 ? 1e-3 : 1)) {
                *outcome = FF_CONVERGED;
                return FF_OK;
            }
            memcpy(f->trial, f->u, f->P * sizeof *f->u);
            for (size_t k = 0; k < f->P; k++) f->u[k] = fmin(fmax(f->u[k] + f->step[k], f->lower[k]), f->upper[k]);
            status = evaluate(f, p, 0, &tried);
            moved = !status && tried < objective;
            if (!moved) {
                memcpy(f->u, f->trial, f->P * sizeof *f->u);
                damping *= 10;
                continue;
            }
            if (objective - tried > 0.25 * expected) damping = fmax(0.1 * damping, 1e-9);
            objective = tried;
        }
    }
    if (damping >= 1e12) *outcome = FF_STALLED;
    return status;
}

/* ---- what is said of an optimum -------------------------------------------------------------- */

ff_status ff_ndf_look(ff_ndf_fit *f, const struct ff_problem *p)
{
    double objective;
    const ff_status status = evaluate(f, p, 1, &objective);
    if (status) return status;
    assemble(f);
    memset(f->step, 0, f->P * sizeof *f->step);
    for (size_t k = 0; k < f->P; k++) f->held[k] = is_pressed(f, k, f->g[k]);
    return FF_OK;
}

/* Each node with its neighbours, weighted 1 2 1. */
static void blur(double *v, size_t n)
{
    double before = v[0];
    for (size_t k = 0; k + 1 < n; k++) {
        const double here = v[k];
        v[k] = 0.25 * (before + 2 * here + v[k + 1]);
        before = here;
    }
    v[n - 1] = 0.25 * (before + 3 * v[n - 1]);
}

/* By each coefficient alone: sum (J r)^2 / sum J^2, over some neighbours; where no sample says anything, that of all. */
void ff_ndf_variances(ff_ndf_fit *f, double least)
{
    const size_t top = (size_t)f->curve->top, n = f->sums.n;
    const double part = 1e-9; /* of all, that counts for every node */
    double *scores = f->work, *squares = f->trial, all_scores = 0, all_squares = 0;
    for (size_t k = 0; k < top; k++) {
        all_scores += scores[k] = f->sums.score_products[k * n + k];
        all_squares += squares[k] = f->sums.gram[k * n + k];
    }
    for (int i = 0; i < 3; i++) {
        blur(scores, top);
        blur(squares, top);
    }
    for (size_t k = 0; k < top; k++) {
        const double square = squares[k] + part * all_squares;
        f->variance[k] = square > 0 ? fmax((scores[k] + part * all_scores) / square, least) : least;
    }
}

/* trace (H^-1 M) over what is not held, M given over the raw columns. */
static double trace_of(ff_ndf_fit *f, const double *raw)
{
    const size_t P = f->P;
    double *M = f->A, sum = 0;
    transform(f, raw, M);
    const size_t n = factor(f, f->H);
    for (size_t a = 0; a < n; a++) {
        for (size_t b = 0; b < n; b++) f->work[b] = M[f->index[b] * P + f->index[a]];
        solve(f, n, f->work);
        sum += f->work[a];
    }
    return sum;
}

/* sum (r / (1 - h))^2 ~ sum r^2 + 2 sum r^2 h, with the leverage h = J H^-1 J^T: the second sum is a trace. */
double ff_ndf_left_out(ff_ndf_fit *f)
{
    return f->sums.cost2 + 2 * trace_of(f, f->sums.score_products);
}

double ff_ndf_effective(ff_ndf_fit *f)
{
    return trace_of(f, f->sums.gram);
}

ff_status ff_ndf_take_noise(ff_ndf_fit *f, const struct ff_problem *p, const struct ff_noise *noise)
{
    ff_ndf_sums sums;
    ff_ndf_place at = place_of(f, p);
    at.noise = noise;
    if (ff_fit_cancelled(f->o)) return FF_ERR_CANCELLED;
    ff_status status = ff_ndf_sums_new(f->curve, f->n_channels, &sums);
    if (!status) status = ff_ndf_sum(&at, 1, &sums);
    if (!status) memcpy(f->sums.score_products, sums.score_products, sums.n * sums.n * sizeof *sums.score_products);
    ff_ndf_sums_free(&sums);
    f->passes++;
    return status;
}

/* The penalty's weight is the one that cross-validation finds where samples speak, which tells nothing of other angles. Errors are
 * those of a curve that may bend by LIKELY_BEND2 everywhere, and what such a curve would be apart from this one: where the samples
 * speak it is the same curve but for their noise, and elsewhere a guess. */
#define LIKELY_BEND2 3.0  /* variance of the curvature of ln (D / D_reference), per unit of y          */
#define LEAST_SMOOTH 1e-3 /* of the errors: what no sample tells of has a large error, not one of zero */

/* A^-1 (M + N) A^-1: M the samples' scores, N that of the penalty seen as an observation, each term 0 with the variance 1 / smooth;
 * and the step to its optimum. Nothing is held: a bound is not a measurement. */
ff_status ff_ndf_covariance(ff_ndf_fit *f, double *cov)
{
    const size_t P = f->P;
    const double smooth = f->smooth;
    double *M = malloc(P * P * sizeof *M), *step = f->step;
    int *held = malloc(P * sizeof *held);
    if (!M || !held) {
        free(M);
        free(held);
        return FF_ERR_MEMORY;
    }
    memcpy(held, f->held, P * sizeof *held);
    memset(f->held, 0, P * sizeof *f->held);
    f->smooth = fmax(fmin(smooth, 1 / LIKELY_BEND2), LEAST_SMOOTH);
    assemble_into(f, f->A);
    transform(f, f->sums.score_products, M);
    add_penalty(f, f->variance, M, NULL);
    memset(cov, 0, P * P * sizeof *cov);
    const size_t n = factor(f, f->A), *at = f->index;
    for (size_t a = 0; a < n; a++) f->work[a] = -f->g[at[a]];
    solve(f, n, f->work);
    memset(step, 0, P * sizeof *step);
    for (size_t a = 0; a < n; a++) step[at[a]] = f->work[a];
    for (int side = 0; side < 2; side++) { /* A^-1 M, then A^-1 of its transpose */
        for (size_t a = 0; a < n; a++) {
            for (size_t b = 0; b < n; b++) f->work[b] = M[at[b] * P + at[a]];
            solve(f, n, f->work);
            for (size_t b = 0; b < n; b++) cov[at[a] * P + at[b]] = f->work[b];
        }
        memcpy(M, cov, P * P * sizeof *M);
    }
    for (size_t a = 0; a < P; a++)
        for (size_t b = 0; b < P; b++) cov[a * P + b] += step[a] * step[b];
    f->smooth = smooth;
    memcpy(f->held, held, P * sizeof *held);
    free(held);
    free(M);
    return FF_OK;
}
