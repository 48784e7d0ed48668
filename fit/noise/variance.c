/* The variance of the data as a function of the value and of both angles: a gamma quasi-likelihood, levels and angles in turn. */
#include "internal_noise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LEVELS = 3,
    STEPS = 12,
    ROUNDS = 8,
    BINS = 12,
    ALL = (1 << LEVELS) - 1,
    NUMBERS = 5,
    MOST_VALUES = 4000,
    FEWEST_OF_CHANNEL = 300
};
#define FARTHEST               50.0 /* a square counts as at most so many times its expectation: one wild value is not the noise */
#define FEWEST_LEFT_OF_CHANNEL 10.0
#define SETTLED                1e-4 /* relative change                                                                           */
#define ANGLE_SD               1.0  /* what the powers of the cosines are expected to be, before the data: 0 +- this              */
#define ANGLE_MAX              4.0
#define ANGLE_SETTLED          1e-3
#define RIDGE                  1e-10
#define TINY                   1e-30 /* of the square of the largest value */

/* ---- levels ---------------------------------------------------------------------------------- */

/* Least x' A x / 2 - b' x over x >= 0, A [3][3] positive semidefinite with a diagonal of 1: the best of all supports that are
 * allowed, of which bit k stands for x_k. */
static void nonnegative(double A[LEVELS][LEVELS], const double b[LEVELS], unsigned allowed, double x[LEVELS])
{
    double best = INFINITY;
    for (unsigned support = 1; support < 1u << LEVELS; support++) {
        double M[LEVELS][LEVELS + 1], y[LEVELS] = {0}, value = 0;
        size_t index[LEVELS], n = 0;
        int bad = (support & ~allowed) != 0;
        for (size_t k = 0; k < LEVELS; k++)
            if (support >> k & 1) index[n++] = k;
        for (size_t i = 0; i < n; i++) {
            for (size_t j = 0; j < n; j++) M[i][j] = A[index[i]][index[j]] + (i == j ? 1e-13 : 0);
            M[i][n] = b[index[i]];
        }
        for (size_t i = 0; i < n; i++) {
            if (!(M[i][i] > 1e-12)) bad = 1;
            for (size_t r = i + 1; r < n && !bad; r++) {
                const double f = M[r][i] / M[i][i];
                for (size_t c = i; c <= n; c++) M[r][c] -= f * M[i][c];
            }
        }
        for (size_t i = n; i-- > 0 && !bad;) {
            double v = M[i][n];
            for (size_t j = i + 1; j < n; j++) v -= M[i][j] * y[index[j]];
            y[index[i]] = v / M[i][i];
            bad |= !(y[index[i]] >= 0);
        }
        if (bad) continue;
        for (size_t i = 0; i < n; i++) value -= 0.5 * b[index[i]] * y[index[i]];
        if (value >= best) continue;
        best = value;
        memcpy(x, y, sizeof y);
    }
}

static double level_at(const double x[LEVELS], double m)
{
    return x[0] + m * (x[1] + m * x[2]);
}

/* A squared error and what it depends on; s: the variance without the angles, angle: their factor. */
typedef struct datum {
    double value, square, weight, log_i, log_o, angle, s;
    size_t place; /* among all */
} datum;

/* Those of all channels, of channel c from first[c] on. */
typedef struct data {
    size_t C, *first; /* [C + 1] */
    datum *at;
} data;

/* One step: weighted least squares of the squares on 1, m, m^2 with the variances s^2 of before. */
static void level_step(const datum *from, const datum *end, unsigned allowed, double x[LEVELS])
{
    double A[LEVELS][LEVELS] = {{0}}, b[LEVELS] = {0}, scale[LEVELS];
    for (const datum *d = from; d < end; d++) {
        const double inverse = 1 / d->s, most = FARTHEST * d->s, of = d->square / d->angle, u = of < most ? of : most, m = d->value,
                     w = d->weight * inverse * inverse, wm = w * m, wm2 = wm * m;
        A[0][0] += w;
        A[1][0] += wm;
        A[1][1] += wm2;
        A[2][1] += wm2 * m;
        A[2][2] += wm2 * m * m;
        b[0] += w * u;
        b[1] += wm * u;
        b[2] += wm2 * u;
    }
    A[2][0] = A[1][1];
    for (size_t j = 0; j < LEVELS; j++) scale[j] = A[j][j] > 0 ? 1 / sqrt(A[j][j]) : 0;
    for (size_t j = 0; j < LEVELS; j++) {
        b[j] *= scale[j];
        for (size_t k = 0; k <= j; k++) A[j][k] = A[k][j] = A[j][k] * scale[j] * scale[k];
    }
    nonnegative(A, b, allowed, x);
    for (size_t j = 0; j < LEVELS; j++) x[j] *= scale[j];
}

static int by_value(const void *a, const void *b)
{
    const datum *x = a, *y = b;
    return (x->value > y->value) - (x->value < y->value);
}

static int by_place(const void *a, const void *b)
{
    const datum *x = a, *y = b;
    return (x->place > y->place) - (x->place < y->place);
}

/* A first variance: means of the squares over values of about one magnitude. */
static void first_guess(datum *from, datum *end)
{
    const size_t n = (size_t)(end - from), bins = n / 12 < 1 ? 1 : n / 12 > BINS ? BINS : n / 12;
    qsort(from, n, sizeof *from, by_value);
    for (size_t b = 0; b < bins; b++) {
        datum *const begin = from + b * n / bins, *const stop = from + (b + 1) * n / bins;
        double mean = 0;
        for (const datum *d = begin; d < stop; d++) mean += d->square / d->angle / (double)(stop - begin);
        for (datum *d = begin; d < stop; d++) d->s = fmax(mean, TINY);
    }
    qsort(from, n, sizeof *from, by_place); /* channels together again */
}

static int is_known(const ff_noise_level *l)
{
    return l->constant + l->linear + l->square > 0;
}

/* The sum of w (u / s + ln s) with the angles. */
static double deviance(const datum *from, const datum *end)
{
    double sum = 0;
    for (const datum *d = from; d < end; d++) {
        const double s = d->s * d->angle;
        sum += d->weight * (fmin(d->square / s, FARTHEST) + log(s));
    }
    return sum;
}

static void take_level(datum *from, datum *end, const ff_noise_level *level)
{
    for (datum *d = from; d < end; d++) d->s = fmax(ff_noise_variance(level, d->value), TINY);
}

/* The level of some data at given angles, from where it is. */
static void fit_level(datum *from, datum *end, unsigned allowed, ff_noise_level *level)
{
    double x[LEVELS] = {0};
    if (is_known(level))
        take_level(from, end, level);
    else
        first_guess(from, end);
    for (int step = 0; step < STEPS; step++) {
        double change = 0;
        level_step(from, end, allowed, x);
        for (datum *d = from; d < end; d++) {
            const double of = level_at(x, d->value), now = of > TINY ? of : TINY, by = fabs(now - d->s) / now;
            change = by > change ? by : change;
            d->s = now;
        }
        if (change < SETTLED) break;
    }
    *level = (ff_noise_level){x[0], x[1], x[2]};
}

/* Leaves out what the data do not ask for (Akaike 1974): what is above 0 by its own scatter alone would count most where values are
 * largest, and few. Returns the deviance. */
static double simplify(datum *from, datum *end, ff_noise_level *level)
{
    double sum = deviance(from, end);
    for (unsigned left = ALL, k = 0; k < LEVELS; k++) {
        const double now[LEVELS] = {level->constant, level->linear, level->square};
        const unsigned without = left & ~(1u << k);
        ff_noise_level other = {0, 0, 0};
        if (!(now[k] > 0)) {
            left = without;
            continue;
        }
        if (!without) break;
        fit_level(from, end, without, &other);
        const double then = deviance(from, end);
        if (then - sum > 2 || !is_known(&other)) continue;
        sum = then;
        left = without;
        *level = other;
    }
    take_level(from, end, level);
    return sum;
}

/* ---- angles ---------------------------------------------------------------------------------- */

static void fill_angles(const data *t, const ff_noise *noise)
{
    for (datum *d = t->at; d < t->at + t->first[t->C]; d++) d->angle = exp(noise->cos_i * d->log_i + noise->cos_o * d->log_o);
}

/* A Fisher step of both powers, the level following; with a prior, since few incidences say little. Returns the change. */
static double angle_step(const data *t, ff_noise *noise)
{
    const datum *const end = t->at + t->first[t->C];
    const double of_prior = 1 / (ANGLE_SD * ANGLE_SD);
    double W = 0, mean[2] = {0}, A[2][2] = {{of_prior, 0}, {0, of_prior}},
           b[2] = {-of_prior * noise->cos_i, -of_prior * noise->cos_o};
    for (const datum *d = t->at; d < end; d++) {
        W += d->weight;
        mean[0] += d->weight * d->log_i;
        mean[1] += d->weight * d->log_o;
    }
    if (!(W > 0)) return 0;
    for (const datum *d = t->at; d < end; d++) {
        const double z[2] = {d->log_i - mean[0] / W, d->log_o - mean[1] / W}, w = 0.5 * d->weight,
                     r = fmin(d->square / (d->s * d->angle), FARTHEST) - 1;
        for (int j = 0; j < 2; j++) {
            b[j] += w * r * z[j];
            for (int k = 0; k < 2; k++) A[j][k] += w * z[j] * z[k];
        }
    }
    const double det = A[0][0] * A[1][1] - A[0][1] * A[1][0], dp = (b[0] * A[1][1] - b[1] * A[0][1]) / det,
                 dq = (A[0][0] * b[1] - A[1][0] * b[0]) / det, p = fmin(fmax(noise->cos_i + dp, -ANGLE_MAX), ANGLE_MAX),
                 q = fmin(fmax(noise->cos_o + dq, -ANGLE_MAX), ANGLE_MAX),
                 change = fmax(fabs(p - noise->cos_i), fabs(q - noise->cos_o));
    noise->cos_i = p;
    noise->cos_o = q;
    return change;
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* Levels and angles in turn. final: what is not asked for is left out. Returns the deviance. */
static double fit_all(const data *t, int final, ff_noise *noise)
{
    double sum = 0;
    for (int round = 0, last = 0; !last; round++) {
        last = round + 1 == ROUNDS;
        fill_angles(t, noise);
        for (size_t k = 0; k < noise->n_levels; k++)
            fit_level(t->at + t->first[k * t->C / noise->n_levels], t->at + t->first[(k + 1) * t->C / noise->n_levels], ALL,
                      &noise->level[k]);
        last |= angle_step(t, noise) < ANGLE_SETTLED;
    }
    fill_angles(t, noise);
    for (size_t k = 0; k < noise->n_levels; k++) {
        datum *const from = t->at + t->first[k * t->C / noise->n_levels], *const end =
                                                                              t->at + t->first[(k + 1) * t->C / noise->n_levels];
        fit_level(from, end, ALL, &noise->level[k]);
        sum += final ? simplify(from, end, &noise->level[k]) : deviance(from, end);
    }
    return sum;
}

/* What the data say of a, b, c, p and q: half the sum of w z z', z the derivatives of the logarithm of the variance; what is 0
 * stays there. Of several channels with levels of their own a mean over them: each has as much of the angles as it has values. */
static void take_uncertainty(const data *t, ff_noise *noise)
{
    double A[NUMBERS * NUMBERS] = {0}, work[4 * NUMBERS * NUMBERS + NUMBERS], scale[NUMBERS], inverse[NUMBERS * NUMBERS];
    const double of_level = 1 / (double)noise->n_levels;
    size_t index[NUMBERS], n = 0;
    int use[NUMBERS] = {0, 0, 0, 1, 1};
    for (size_t k = 0; k < noise->n_levels; k++) {
        use[0] |= noise->level[k].constant > 0;
        use[1] |= noise->level[k].linear > 0;
        use[2] |= noise->level[k].square > 0;
    }
    for (const datum *d = t->at; d < t->at + t->first[t->C]; d++) {
        const double m = d->value, w = 0.5 * d->weight * of_level,
                     z[NUMBERS] = {1 / d->s, m / d->s, m * m / d->s, d->log_i, d->log_o};
        for (size_t a = 0; a < NUMBERS; a++)
            for (size_t b = 0; b < NUMBERS; b++) A[a * NUMBERS + b] += w * z[a] * z[b];
    }
    A[3 * NUMBERS + 3] += 1 / (ANGLE_SD * ANGLE_SD);
    A[4 * NUMBERS + 4] += 1 / (ANGLE_SD * ANGLE_SD);
    for (size_t a = 0; a < NUMBERS; a++) {
        scale[a] = A[a * NUMBERS + a] > 0 ? 1 / sqrt(A[a * NUMBERS + a]) : 0;
        if (use[a] && scale[a] > 0) index[n++] = a;
    }
    for (size_t a = 0; a < NUMBERS; a++)
        for (size_t b = 0; b < NUMBERS; b++) A[a * NUMBERS + b] = A[a * NUMBERS + b] * scale[a] * scale[b] + (a == b ? RIDGE : 0);
    ff_ridge_inverse(A, NUMBERS, index, n, RIDGE, inverse, work);
    for (size_t a = 0; a < NUMBERS; a++)
        for (size_t b = 0; b < NUMBERS; b++) noise->uncertainty[a][b] = inverse[a * NUMBERS + b] * scale[a] * scale[b];
}

/* The magnitude above which about `count` of the values of a channel lie. */
static double magnitude_of_largest(const ff_scatter *t, size_t c, size_t count)
{
    enum { MAGNITUDES = 256 }; /* quarters of a power of two */
    size_t histogram[MAGNITUDES] = {0}, sum = 0;
    double largest = 0;
    for (size_t i = 0; i < t->n; i++) largest = fmax(largest, t->value[c * t->n + i]);
    for (size_t i = 0; i < t->n; i++) {
        int exponent;
        const double m = t->value[c * t->n + i];
        if (!(t->weight[c * t->n + i] > 0) || !(m > 0)) continue;
        const double fraction = frexp(m / largest, &exponent); /* in [0.5, 1) */
        const long bin = -4L * exponent + (long)(8 * (1 - fraction));
        histogram[bin < 0 ? 0 : bin >= MAGNITUDES ? MAGNITUDES - 1 : bin]++;
    }
    for (int k = 0; k < MAGNITUDES; k++) {
        sum += histogram[k];
        if (sum <= count) continue;
        return k == 0 ? largest : largest * ldexp(1 - (k % 4) / 8.0, -(k / 4));
    }
    return 0;
}

/* Which values of channel c are taken: all from `large` on, and every stride-th of the rest. */
typedef struct picking {
    double large;
    size_t stride, n; /* at most n of them */
} picking;

static picking pick_of(const ff_scatter *t, size_t c, size_t most)
{
    picking p = {.stride = 1};
    size_t rest = 0;
    if (t->n > most) p.large = magnitude_of_largest(t, c, most / 3);
    for (size_t i = 0; i < t->n; i++) rest += t->value[c * t->n + i] < p.large;
    p.stride = rest / (most - most / 3) + 1;
    p.n = t->n - rest + (rest + p.stride - 1) / p.stride;
    return p;
}

/* The largest values of each channel and every so-manieth of the rest, with the weight of those it stands for: a few thousand say
 * as much of the noise as all. */
static ff_status gather(const ff_scatter *t, data *out)
{
    const size_t most = MOST_VALUES / t->C > FEWEST_OF_CHANNEL ? MOST_VALUES / t->C : FEWEST_OF_CHANNEL;
    data d = {.C = t->C, .first = calloc(t->C + 1, sizeof *d.first)};
    picking *pick = malloc(t->C * sizeof *pick);
    size_t n = 0, room = 1;
    for (size_t c = 0; c < t->C && pick; c++) {
        pick[c] = pick_of(t, c, most);
        room += pick[c].n;
    }
    d.at = pick ? malloc(room * sizeof *d.at) : NULL;
    if (!d.first || !d.at) {
        free(pick);
        free(d.first);
        free(d.at);
        return FF_ERR_MEMORY;
    }
    for (size_t c = 0; c < t->C; c++) {
        size_t seen = 0;
        for (size_t i = 0; i < t->n; i++) {
            const size_t at = c * t->n + i;
            const int is_large = t->value[at] >= pick[c].large;
            if (!is_large && seen++ % pick[c].stride) continue;
            if (!(t->weight[at] > 0)) continue;
            d.at[n] = (datum){.value = fmax(t->value[at], 0),
                              .square = t->square[at],
                              .weight = t->weight[at] * (is_large ? 1 : (double)pick[c].stride),
                              .log_i = t->log_i[i],
                              .log_o = t->log_o[i],
                              .angle = 1,
                              .place = n};
            n++;
        }
        d.first[c + 1] = n;
    }
    free(pick);
    *out = d;
    return FF_OK;
}

/* What the fit has left of the values of channel c, as a number of values. */
static double left_of_channel(const data *t, size_t c)
{
    double sum = 0;
    for (const datum *d = t->at + t->first[c]; d < t->at + t->first[c + 1]; d++) sum += d->weight;
    return sum;
}

/* Levels for each channel instead of one for all, where they are worth their number; a channel that the fit follows value by value
 * shows no noise, whatever it has. */
static ff_status try_each(const data *t, int final, double shared, ff_noise *noise)
{
    for (size_t c = 0; c < t->C; c++)
        if (t->first[c + 1] > t->first[c] && left_of_channel(t, c) < FEWEST_LEFT_OF_CHANNEL) return FF_OK;
    ff_noise *each = ff_noise_make(t->C);
    if (!each) return FF_ERR_MEMORY;
    each->cos_i = noise->cos_i;
    each->cos_o = noise->cos_o;
    if (fit_all(t, final, each) + LEVELS * (double)(t->C - 1) * log((double)t->first[t->C] + 1) < shared) {
        memcpy(noise->level, each->level, t->C * sizeof *noise->level);
        noise->n_levels = t->C;
        noise->cos_i = each->cos_i;
        noise->cos_o = each->cos_o;
    }
    free(each);
    return FF_OK;
}

ff_status ff_scatter_fit(const ff_scatter *t, int first, int final, ff_noise *noise)
{
    data d;
    ff_status status = gather(t, &d);
    if (status) return status;
    if (first || final) {
        noise->n_levels = 1;
        noise->cos_i = noise->cos_o = 0;
        noise->level[0] = (ff_noise_level){0, 0, 0};
    }
    const double sum = fit_all(&d, final, noise);
    if ((first || final) && t->C > 1) status = try_each(&d, final, sum, noise);
    if (final && !status) {
        fill_angles(&d, noise);
        for (size_t k = 0; k < t->C; k++)
            for (datum *v = d.at + d.first[k]; v < d.at + d.first[k + 1]; v++)
                v->s = fmax(ff_noise_variance(ff_noise_of(noise, k), v->value), TINY);
        take_uncertainty(&d, noise);
    }
    free(d.first);
    free(d.at);
    return status;
}
