/* The variance of the data as a function of the value and of both angles: a gamma quasi-likelihood, levels and angles in turn. */
#include "internal_noise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 3, STEPS = 12, ROUNDS = 8, BINS = 12 };
#define FARTHEST  50.0 /* a square counts as at most so many times its expectation: one wild value is not the noise */
#define SETTLED   1e-4 /* change of a logarithm                                                                     */
#define ANGLE_SD  1.0  /* what the powers of the cosines are expected to be, before the data: 0 +- this              */
#define ANGLE_MAX 4.0
#define TINY      1e-30

/* ---- levels ---------------------------------------------------------------------------------- */

/* Least x' A x / 2 - b' x over x >= 0, A [3][3] positive semidefinite with a diagonal of 1: the best of all supports that are allowed,
 * of which bit k stands for x_k. */
static void nonnegative(double A[LEVELS][LEVELS], const double b[LEVELS], unsigned allowed, double x[LEVELS])
{
    double best = INFINITY;
    for (unsigned support = 1; support < 1u << LEVELS; ++support) {
        double M[LEVELS][LEVELS + 1], y[LEVELS] = {0}, value = 0;
        size_t index[LEVELS], n = 0;
        int bad = (support & ~allowed) != 0;
        for (size_t k = 0; k < LEVELS; ++k)
            if (support >> k & 1) index[n++] = k;
        for (size_t i = 0; i < n; ++i) {
            for (size_t j = 0; j < n; ++j) M[i][j] = A[index[i]][index[j]] + (i == j ? 1e-13 : 0);
            M[i][n] = b[index[i]];
        }
        for (size_t i = 0; i < n; ++i) {
            if (!(M[i][i] > 1e-12)) bad = 1;
            for (size_t r = i + 1; r < n && !bad; ++r) {
                const double f = M[r][i] / M[i][i];
                for (size_t c = i; c <= n; ++c) M[r][c] -= f * M[i][c];
            }
        }
        for (size_t i = n; i-- > 0 && !bad;) {
            double v = M[i][n];
            for (size_t j = i + 1; j < n; ++j) v -= M[i][j] * y[index[j]];
            y[index[i]] = v / M[i][i];
            bad |= !(y[index[i]] >= 0);
        }
        if (bad) continue;
        for (size_t i = 0; i < n; ++i) value -= 0.5 * b[index[i]] * y[index[i]];
        if (value >= best) continue;
        best = value;
        memcpy(x, y, sizeof y);
    }
}

static double level_at(const double x[LEVELS], double m)
{
    return x[0] + m * (x[1] + m * x[2]);
}

/* One step: weighted least squares of u on 1, m, m^2 with the variances s^2 of before. */
static void level_step(const ff_scatter *t, size_t first, size_t end, const double *angle, unsigned allowed,
                       const double *s, double x[LEVELS])
{
    double A[LEVELS][LEVELS] = {{0}}, b[LEVELS] = {0}, scale[LEVELS];
    for (size_t i = first; i < end; ++i) {
        if (!(t->weight[i] > 0)) continue;
        const double m = fmax(t->value[i], 0), w = t->weight[i] / (s[i] * s[i]), u = fmin(t->square[i] / angle[i % t->n], FARTHEST * s[i]),
                     row[LEVELS] = {1, m, m * m};
        for (size_t j = 0; j < LEVELS; ++j) {
            b[j] += w * u * row[j];
            for (size_t k = 0; k <= j; ++k) A[j][k] += w * row[j] * row[k];
        }
    }
    for (size_t j = 0; j < LEVELS; ++j) scale[j] = A[j][j] > 0 ? 1 / sqrt(A[j][j]) : 0;
    for (size_t j = 0; j < LEVELS; ++j) {
        b[j] *= scale[j];
        for (size_t k = 0; k <= j; ++k) A[j][k] = A[k][j] = A[j][k] * scale[j] * scale[k];
    }
    nonnegative(A, b, allowed, x);
    for (size_t j = 0; j < LEVELS; ++j) x[j] *= scale[j];
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A first variance: means of the squares over values of about one magnitude. pairs [end - first][2]. */
static void first_guess(const ff_scatter *t, size_t first, size_t end, const double *angle, double *pairs, double *s)
{
    size_t n = 0;
    double edge[BINS + 1], mean[BINS];
    for (size_t i = first; i < end; ++i) {
        if (!(t->weight[i] > 0)) continue;
        pairs[2 * n] = t->value[i];
        pairs[2 * n++ + 1] = t->square[i] / angle[i % t->n];
    }
    qsort(pairs, n, 2 * sizeof *pairs, by_value);
    const size_t bins = n / 12 < 1 ? 1 : n / 12 > BINS ? BINS : n / 12;
    for (size_t b = 0; b < bins; ++b) {
        const size_t from = b * n / bins, to = (b + 1) * n / bins;
        edge[b] = n ? pairs[2 * from] : 0;
        mean[b] = 0;
        for (size_t i = from; i < to; ++i) mean[b] += pairs[2 * i + 1] / (double)(to - from);
    }
    for (size_t i = first; i < end; ++i) {
        size_t b = bins - 1;
        while (b > 0 && t->value[i] < edge[b]) --b;
        s[i] = fmax(mean[b], TINY);
    }
}

/* The level of values [first, end) at given angles; s is left as the variance without them. Returns the sum of w (u / s + ln s). */
static double fit_level(const ff_scatter *t, size_t first, size_t end, const double *angle, unsigned allowed, double *pairs,
                        double *s, ff_noise_level *out)
{
    double x[LEVELS] = {0}, sum = 0;
    if (out->constant + out->linear + out->square > 0)
        for (size_t i = first; i < end; ++i) s[i] = fmax(ff_noise_variance(out, t->value[i]), TINY);
    else
        first_guess(t, first, end, angle, pairs, s);
    for (int step = 0; step < STEPS; ++step) {
        double change = 0;
        level_step(t, first, end, angle, allowed, s, x);
        for (size_t i = first; i < end; ++i) {
            const double now = fmax(level_at(x, fmax(t->value[i], 0)), TINY);
            change = fmax(change, fabs(log(now / s[i])));
            s[i] = now;
        }
        if (change < SETTLED) break;
    }
    *out = (ff_noise_level){x[0], x[1], x[2]};
    for (size_t i = first; i < end; ++i)
        if (t->weight[i] > 0) {
            const double of = s[i] * angle[i % t->n];
            sum += t->weight[i] * (fmin(t->square[i] / of, FARTHEST) + log(of));
        }
    return sum;
}

enum { ALL = (1u << LEVELS) - 1 };

/* Leaves out what the data do not ask for (Akaike 1974): what is above 0 by its own scatter alone would count most where values are
 * largest, and few. Returns the sum. */
static double simplify(const ff_scatter *t, size_t first, size_t end, const double *angle, double sum, double *pairs, double *s, ff_noise_level *level)
{
    for (unsigned left = ALL, k = 0; k < LEVELS; ++k) {
        const double now[LEVELS] = {level->constant, level->linear, level->square};
        const unsigned without = left & ~(1u << k);
        ff_noise_level other = {0, 0, 0};
        if (!(now[k] > 0)) {
            left = without;
            continue;
        }
        if (!without) break;
        const double then = fit_level(t, first, end, angle, without, pairs, s, &other);
        if (then - sum > 2 || !(other.constant + other.linear + other.square > 0)) continue;
        sum = then;
        left = without;
        *level = other;
    }
    return sum;
}

/* ---- angles ---------------------------------------------------------------------------------- */

static void fill_angles(const ff_scatter *t, const ff_noise *noise, double *angle)
{
    for (size_t i = 0; i < t->n; ++i) angle[i] = exp(noise->cos_i * t->log_i[i] + noise->cos_o * t->log_o[i]);
}

/* A Fisher step of both powers, the level following; with a prior, since few incidences say little. */
static double angle_step(const ff_scatter *t, const double *angle, const double *s, ff_noise *noise)
{
    double W = 0, mean[2] = {0}, A[2][2] = {{0}}, b[2] = {0};
    for (size_t i = 0; i < t->n * t->C; ++i) {
        W += t->weight[i];
        mean[0] += t->weight[i] * t->log_i[i % t->n];
        mean[1] += t->weight[i] * t->log_o[i % t->n];
    }
    if (!(W > 0)) return 0;
    for (size_t i = 0; i < t->n * t->C; ++i) {
        if (!(t->weight[i] > 0)) continue;
        const double z[2] = {t->log_i[i % t->n] - mean[0] / W, t->log_o[i % t->n] - mean[1] / W},
                     r = fmin(t->square[i] / (s[i] * angle[i % t->n]), FARTHEST) - 1, w = 0.5 * t->weight[i];
        for (int j = 0; j < 2; ++j) {
            b[j] += w * r * z[j];
            for (int k = 0; k < 2; ++k) A[j][k] += w * z[j] * z[k];
        }
    }
    const double of_prior = 1 / (ANGLE_SD * ANGLE_SD);
    A[0][0] += of_prior;
    A[1][1] += of_prior;
    b[0] -= of_prior * noise->cos_i;
    b[1] -= of_prior * noise->cos_o;
    const double det = A[0][0] * A[1][1] - A[0][1] * A[1][0], dp = (b[0] * A[1][1] - b[1] * A[0][1]) / det,
                 dq = (A[0][0] * b[1] - A[1][0] * b[0]) / det, p = fmin(fmax(noise->cos_i + dp, -ANGLE_MAX), ANGLE_MAX),
                 q = fmin(fmax(noise->cos_o + dq, -ANGLE_MAX), ANGLE_MAX), change = fmax(fabs(p - noise->cos_i), fabs(q - noise->cos_o));
    noise->cos_i = p;
    noise->cos_o = q;
    return change;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* Doubles of work that a fit needs. */
static size_t room(const ff_scatter *t)
{
    return 3 * t->n * t->C + t->n;
}

double ff_scatter_fit_levels(const ff_scatter *t, int angles, double *work, ff_noise *noise)
{
    double *s = work, *angle = s + t->n * t->C, *pairs = angle + t->n, sum = 0;
    for (int round = 0; round < ROUNDS; ++round) {
        sum = 0;
        fill_angles(t, noise, angle);
        const size_t part = t->n * t->C / noise->n_levels;
        for (size_t k = 0; k < noise->n_levels; ++k) sum += fit_level(t, k * part, (k + 1) * part, angle, ALL, pairs, s, &noise->level[k]);
        if (!angles || angle_step(t, angle, s, noise) < 1e-3) break;
    }
    const size_t part = t->n * t->C / noise->n_levels;
    sum = 0;
    for (size_t k = 0; k < noise->n_levels; ++k) {
        const size_t first = k * part, end = first + part;
        const double one = fit_level(t, first, end, angle, ALL, pairs, s, &noise->level[k]);
        sum += simplify(t, first, end, angle, one, pairs, s, &noise->level[k]);
    }
    return sum;
}

/* What the data say of a, b, c, p and q: half the sum of w z z', z the derivatives of the logarithm of the variance; what is 0 stays
 * there. Of several channels with levels of their own a mean over them: each has as much of the angles as it has values. */
static void take_uncertainty(const ff_scatter *t, ff_noise *noise)
{
    enum { N = 5 };
    double A[N * N] = {0}, work[4 * N * N + N];
    const double of_level = 1 / (double)noise->n_levels;
    size_t index[N], n = 0;
    int use[N] = {0, 0, 0, 1, 1};
    for (size_t k = 0; k < noise->n_levels; ++k) {
        use[0] |= noise->level[k].constant > 0;
        use[1] |= noise->level[k].linear > 0;
        use[2] |= noise->level[k].square > 0;
    }
    for (size_t i = 0; i < t->n * t->C; ++i) {
        const ff_noise_level *l = ff_noise_of(noise, i / t->n);
        const double m = fmax(t->value[i], 0), v = fmax(ff_noise_variance(l, m), TINY), w = 0.5 * t->weight[i] * of_level,
                     z[N] = {1 / v, m / v, m * m / v, t->log_i[i % t->n], t->log_o[i % t->n]};
        for (size_t a = 0; a < N; ++a)
            for (size_t b = 0; b < N; ++b) A[a * N + b] += w * z[a] * z[b];
    }
    A[3 * N + 3] += 1 / (ANGLE_SD * ANGLE_SD);
    A[4 * N + 4] += 1 / (ANGLE_SD * ANGLE_SD);
    double scale[N], inverse[N * N];
    for (size_t a = 0; a < N; ++a) {
        scale[a] = A[a * N + a] > 0 ? 1 / sqrt(A[a * N + a]) : 0;
        if (use[a] && scale[a] > 0) index[n++] = a;
    }
    for (size_t a = 0; a < N; ++a)
        for (size_t b = 0; b < N; ++b) A[a * N + b] = A[a * N + b] * scale[a] * scale[b] + (a == b ? 1e-10 : 0);
    ff_ridge_inverse(A, N, index, n, 1e-10, inverse, work);
    for (size_t a = 0; a < N; ++a)
        for (size_t b = 0; b < N; ++b) noise->uncertainty[a][b] = inverse[a * N + b] * scale[a] * scale[b];
}

ff_status ff_scatter_fit(const ff_scatter *t, ff_noise *out)
{
    double *work = malloc(room(t) * sizeof *work), used = 0;
    if (!work) return FF_ERR_MEMORY;
    for (size_t i = 0; i < t->n * t->C; ++i) used += t->weight[i] > 0;
    out->n_levels = 1;
    out->cos_i = out->cos_o = 0;
    out->level[0] = (ff_noise_level){0, 0, 0};
    const double shared = ff_scatter_fit_levels(t, 1, work, out);
    if (t->C > 1) {
        ff_noise *each = ff_noise_make(t->C);
        if (!each) {
            free(work);
            return FF_ERR_MEMORY;
        }
        each->cos_i = out->cos_i;
        each->cos_o = out->cos_o;
        if (ff_scatter_fit_levels(t, 1, work, each) + LEVELS * (double)(t->C - 1) * log(fmax(used, 1)) < shared) {
            memcpy(out->level, each->level, t->C * sizeof *out->level);
            out->n_levels = t->C;
            out->cos_i = each->cos_i;
            out->cos_o = each->cos_o;
        }
        free(each);
    }
    take_uncertainty(t, out);
    free(work);
    return FF_OK;
}
