/* What single values have to do with the errors: how many carry a parameter, what their residuals alone say, and how much larger the
 * errors are since neighbours and channels err together. */
#include "internal_noise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LEVERAGE 0.9999
#define LEAST_ALONG   0.25 /* of the variance of independent values: what correlations are known to so little that they cannot remove more */

enum { NUMBERS = 5 };

typedef struct walk {
    const ff_layout *l;
    const struct ff_problem *p, *whole;
    const ff_noise *noise;
    const float *deviation; /* [C][n_blocks FF_BLOCK] */
    size_t m, P;            /* coordinates of a channel; influences of a value: all, or of an arrow those of the channel */
    double *inverse;        /* [C][P][m] */
    double *sum, *square;   /* [parameters] of v, v^2  */
    double *hc2, *hc3, *z, *lagged, *joint, *single;
    double *together;       /* [P][FF_BLOCK] sum over channels so far */
    double *tail;           /* [C][P][FF_NOISE_LAGS + FF_BLOCK] signed influences, the latest block behind those before it */
    int arrow;
} walk;

/* How many samples of the whole problem a sample of a smaller one stands for. */
static double multiplicity(const walk *w, size_t i)
{
    if (w->p->n == w->whole->n) return 1;
    const size_t at = w->p->index[i];
    const double here = ff_problem_plane(w->p, i / FF_BLOCK, w->p->sample_weight)[i % FF_BLOCK],
                 there = ff_problem_plane(w->whole, at / FF_BLOCK, w->whole->sample_weight)[at % FF_BLOCK];
    return there > 0 ? (here / there) * (here / there) : 1;
}

/* The parameter of influence k of channel c. */
static size_t parameter(const walk *w, size_t c, size_t k)
{
    return !w->arrow || k < w->l->n_shared ? k : k + c * w->l->n_own;
}

/* Products of influences of neighbours along scans, of channel c: block i0 .. i0 + n has just come. */
static void lag(const walk *w, const ff_visited *v)
{
    enum { ROOM = FF_NOISE_LAGS + FF_BLOCK };
    for (size_t k = 0; k < w->P; k++) {
        double *s = w->tail + (v->c * w->P + k) * ROOM, sum = 0;
        for (size_t d = 1; d <= FF_NOISE_LAGS && w->noise->along_scan[d] > 0; d++) {
            for (size_t i = 0; i < v->n; i++) {
                const size_t at = v->first + i;
                if (at < d || fabsf(w->whole->cosine[0][at] - w->whole->cosine[0][at - d]) > 1e-5f) continue;
                sum += 2 * w->noise->along_scan[d] * s[FF_NOISE_LAGS + i] * s[FF_NOISE_LAGS + i - d];
            }
        }
        w->lagged[parameter(w, v->c, k)] += sum;
        memmove(s, s + FF_BLOCK, FF_NOISE_LAGS * sizeof *s);
    }
}

/* Derivatives of the logarithm of a variance by the numbers of the noise. */
static void derivatives(const walk *w, size_t c, size_t i, double f, double z[NUMBERS])
{
    const ff_noise_level *l = ff_noise_of(w->noise, c);
    const size_t at = w->p == w->whole ? i : w->p->index[i];
    const double y = fmax(f, 0) / w->noise->unit, v = ff_noise_variance(l, f) / (w->noise->unit * w->noise->unit);
    z[0] = v > 0 ? 1 / v : 0;
    z[1] = v > 0 ? y / v : 0;
    z[2] = v > 0 ? y * y / v : 0;
    z[3] = log(fmax((double)w->whole->cosine[0][at], 1e-3));
    z[4] = log(fmax((double)w->whole->cosine[1][at], 1e-3));
}

static void look_at(void *context, const ff_visited *v)
{
    enum { ROOM = FF_NOISE_LAGS + FF_BLOCK };
    const walk *w = context;
    const size_t m = w->m, columns = (size_t)w->l->free.n_shape + w->l->free.n_channel;
    const double *inverse = w->inverse + v->c * w->P * m;
    const float *deviation = w->deviation + v->c * w->p->n_blocks * FF_BLOCK + v->first;
    if (v->c == 0) memset(w->together, 0, w->P * FF_BLOCK * sizeof *w->together);
    for (size_t i = 0; i < v->n; i++) {
        double x[FF_MAX_COLUMNS] = {0}, h = 0;
        const double many = multiplicity(w, v->first + i), sd = v->j[i] * (double)deviation[i], r = v->j[i] * (v->f[i] - v->y[i]);
        double z[NUMBERS];
        derivatives(w, v->c, v->first + i, v->f[i], z);
        for (size_t k = 0; k < columns; k++) x[ff_layout_coordinate(w->l, 0, k)] += v->column[k][i];
        for (size_t k = 0; k < w->P; k++) {
            double a = 0;
            for (size_t b = 0; b < m; b++) a += inverse[k * m + b] * x[b];
            const size_t at = parameter(w, v->c, k), own = w->arrow || k < w->l->n_shared ? k : k - v->c * w->l->n_own;
            if (own < m && (w->arrow || k < w->l->n_shared || (k - w->l->n_shared) / w->l->n_own == v->c)) h += a * x[own];
            const double s = a * sd, var = s * s / many, each = var / many;
            w->sum[at] += var;
            w->square[at] += many * each * each;
            for (size_t q = 0; q < NUMBERS; q++) w->z[at * NUMBERS + q] += var * z[q];
            w->tail[(v->c * w->P + k) * ROOM + FF_NOISE_LAGS + i] = s;
            w->together[k * FF_BLOCK + i] += s;
        }
        const double left = 1 - fmin(fmax(h / many, 0), MOST_LEVERAGE), e2 = r * r / (left * many);
        for (size_t k = 0; k < w->P; k++) {
            double a = 0;
            for (size_t b = 0; b < m; b++) a += inverse[k * m + b] * x[b];
            w->hc2[parameter(w, v->c, k)] += a * a * e2;
            w->hc3[parameter(w, v->c, k)] += a * a * e2 / left;
        }
    }
    if (w->noise->along_scan[1] > 0 && w->p->n == w->whole->n) lag(w, v);
    if (v->c + 1 < w->p->n_channels) return;
    for (size_t k = 0; k < w->P; k++)
        for (size_t i = 0; i < v->n; i++) {
            const double t = w->together[k * FF_BLOCK + i], many = multiplicity(w, v->first + i);
            if (!w->arrow || k < w->l->n_shared) w->joint[k] += t * t / many;
        }
}

/* H^-1 between the influences of a channel and its coordinates. */
static void take_inverse(const walk *w, const ff_information *info)
{
    const ff_gram g = {.S = w->l->n_shared, .K = w->l->n_own, .C = w->l->n_channels};
    for (size_t c = 0; c < g.C; c++)
        for (size_t k = 0; k < w->P; k++)
            for (size_t b = 0; b < w->m; b++) {
                const size_t i = parameter(w, c, k), j = ff_gram_coordinate(&g, c, b);
                w->inverse[(c * w->P + k) * w->m + b] = info->use[i] && info->use[j] ? ff_information_inverse(info, i, j) : 0;
            }
}

static void fill(const walk *w, ff_carriers *out)
{
    for (size_t k = 0; k < w->l->P; k++) {
        const double sum = w->sum[k], r = w->noise->between_channels;
        out->number[k] = w->square[k] > 0 ? sum * sum / w->square[k] : 0;
        out->sway[k] = 0;
        for (size_t a = 0; a < NUMBERS && sum > 0; a++)
            for (size_t b = 0; b < NUMBERS; b++)
                out->sway[k] += w->z[k * NUMBERS + a] * w->noise->uncertainty[a][b] * w->z[k * NUMBERS + b] / (sum * sum);
        out->hc2[k] = sqrt(w->hc2[k]);
        out->hc3[k] = sqrt(w->hc3[k]);
        out->along[k] = sum > 0 ? sqrt(fmax(1 + w->lagged[k] / sum, LEAST_ALONG)) : 1;
        out->between[k] = sum > 0 && w->joint[k] > 0 ? sqrt(fmax(1 - r + r * w->joint[k] / sum, 0)) : 1;
    }
}

ff_status ff_carriers_find(const ff_plan *plan, const ff_point *at, const ff_noise *noise, const float *deviation,
                           const ff_information *info, ff_carriers *out)
{
    enum { ROOM = FF_NOISE_LAGS + FF_BLOCK };
    const ff_layout *l = &plan->l;
    const struct ff_problem *whole = plan->p, *p = whole->thin;
    const ff_plan search = ff_plan_on(plan, p);
    walk w = {.l = l, .p = p, .whole = whole, .noise = noise, .deviation = deviation, .m = l->n_shared + l->n_own, .arrow = l->arrow};
    w.P = l->arrow ? w.m : l->P;
    const size_t C = l->n_channels, doubles = C * w.P * w.m + (6 + NUMBERS) * l->P + w.P * FF_BLOCK + C * w.P * ROOM;
    double *memory = calloc(doubles + 1, sizeof *memory);
    if (!memory) return FF_ERR_MEMORY;
    w.inverse = memory;
    w.sum = w.inverse + C * w.P * w.m;
    w.square = w.sum + l->P;
    w.hc2 = w.square + l->P;
    w.hc3 = w.hc2 + l->P;
    w.lagged = w.hc3 + l->P;
    w.joint = w.lagged + l->P;
    w.z = w.joint + l->P;
    w.together = w.z + NUMBERS * l->P;
    w.tail = w.together + w.P * FF_BLOCK;
    take_inverse(&w, info);
    const ff_status st = ff_point_visit(&search, at, look_at, &w);
    if (!st) fill(&w, out);
    free(memory);
    return st;
}
