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
    double *influence;      /* [P][FF_BLOCK] */
    double *many, *few, *log_i, *log_o; /* [FF_BLOCK]: samples that one stands for, its inverse; of its cosines */
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

/* What belongs to a block of samples and not to a channel. */
static void prepare_block(const walk *w, const ff_visited *v)
{
    for (size_t i = 0; i < v->n; i++) {
        const size_t at = w->p == w->whole ? v->first + i : w->p->index[v->first + i];
        w->many[i] = multiplicity(w, v->first + i);
        w->log_i[i] = log(fmax((double)w->whole->cosine[0][at], 1e-3));
        w->log_o[i] = log(fmax((double)w->whole->cosine[1][at], 1e-3));
    }
    memset(w->together, 0, w->P * FF_BLOCK * sizeof *w->together);
}

/* Influences on parameter k: out = H^-1 row. */
static void influence(const double *inverse, size_t m, double (*row)[FF_BLOCK], double *out)
{
    memset(out, 0, FF_BLOCK * sizeof *out);
    for (size_t b = 0; b < m; b++)
        for (size_t i = 0; i < FF_BLOCK; i++) out[i] += inverse[b] * row[b][i];
}

/* The place of parameter k among the coordinates of channel c; m for another channel's. */
static size_t own_place(const walk *w, size_t c, size_t k)
{
    const size_t S = w->l->n_shared, K = w->l->n_own;
    if (w->arrow || k < S) return k;
    return (k - S) / K == c ? S + (k - S) % K : w->m;
}

/* Adds what a block says of parameter k. a: influences; sd: of the residuals; of the logarithm of a variance z. */
static void add_parameter(const walk *w, const ff_visited *v, size_t k, const double *a, const double *sd, double (*z)[FF_BLOCK])
{
    enum { ROOM = FF_NOISE_LAGS + FF_BLOCK };
    const size_t at = parameter(w, v->c, k);
    double *tail = w->tail + (v->c * w->P + k) * ROOM + FF_NOISE_LAGS, *together = w->together + k * FF_BLOCK, sum = 0, square = 0,
           by[NUMBERS] = {0};
    for (size_t i = 0; i < v->n; i++) {
        const double s = a[i] * sd[i], var = s * s * w->few[i], each = var * w->few[i];
        tail[i] = s;
        together[i] += s;
        sum += var;
        square += var * each;
        for (size_t q = 0; q < NUMBERS; q++) by[q] += var * z[q][i];
    }
    w->sum[at] += sum;
    w->square[at] += square;
    for (size_t q = 0; q < NUMBERS; q++) w->z[at * NUMBERS + q] += by[q];
}

static void look_at(void *context, const ff_visited *v)
{
    const walk *w = context;
    const double *inverse = w->inverse + v->c * w->P * w->m;
    const float *deviation = w->deviation + v->c * w->p->n_blocks * FF_BLOCK + v->first;
    const ff_noise_level *level = ff_noise_of(w->noise, v->c);
    double row[FF_MAX_COLUMNS][FF_BLOCK], z[NUMBERS][FF_BLOCK], sd[FF_BLOCK], h[FF_BLOCK] = {0}, e2[FF_BLOCK], e3[FF_BLOCK];
    const double unit = w->noise->unit;
    if (v->c == 0) prepare_block(w, v);
    ff_noise_rows(w->l, v, row);
    for (size_t i = 0; i < v->n; i++) {
        const double y = fmax(v->f[i], 0) / unit, variance = ff_noise_variance(level, v->f[i]) / (unit * unit),
                     by = variance > 0 ? 1 / variance : 0;
        w->few[i] = 1 / w->many[i];
        sd[i] = v->j[i] * (double)deviation[i];
        z[0][i] = by;
        z[1][i] = by * y;
        z[2][i] = by * y * y;
        z[3][i] = w->log_i[i];
        z[4][i] = w->log_o[i];
    }
    for (size_t k = 0; k < w->P; k++) {
        double *a = w->influence + k * FF_BLOCK;
        const size_t own = own_place(w, v->c, k);
        influence(inverse + k * w->m, w->m, row, a);
        for (size_t i = 0; i < FF_BLOCK && own < w->m; i++) h[i] += a[i] * row[own][i];
        add_parameter(w, v, k, a, sd, z);
    }
    for (size_t i = 0; i < v->n; i++) {
        const double left = 1 - fmin(fmax(h[i] * w->few[i], 0), MOST_LEVERAGE), r = v->j[i] * (v->f[i] - v->y[i]);
        e2[i] = r * r / left * w->few[i];
        e3[i] = e2[i] / left;
    }
    for (size_t k = 0; k < w->P; k++) {
        const double *a = w->influence + k * FF_BLOCK;
        double two = 0, three = 0;
        for (size_t i = 0; i < v->n; i++) {
            two += a[i] * a[i] * e2[i];
            three += a[i] * a[i] * e3[i];
        }
        w->hc2[parameter(w, v->c, k)] += two;
        w->hc3[parameter(w, v->c, k)] += three;
    }
    if (w->noise->along_scan[1] > 0 && w->p->n == w->whole->n) lag(w, v);
    if (v->c + 1 < w->p->n_channels || !(w->noise->between_channels > 0)) return;
    for (size_t k = 0; k < (w->arrow ? w->l->n_shared : w->P); k++)
        for (size_t i = 0; i < v->n; i++) w->joint[k] += w->together[k * FF_BLOCK + i] * w->together[k * FF_BLOCK + i] * w->few[i];
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
    const size_t C = l->n_channels, doubles = C * w.P * w.m + (6 + NUMBERS) * l->P + 2 * w.P * FF_BLOCK + 4 * FF_BLOCK + C * w.P * ROOM;
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
    w.influence = w.together + w.P * FF_BLOCK;
    w.many = w.influence + w.P * FF_BLOCK;
    w.few = w.many + FF_BLOCK;
    w.log_i = w.few + FF_BLOCK;
    w.log_o = w.log_i + FF_BLOCK;
    w.tail = w.log_o + FF_BLOCK;
    take_inverse(&w, info);
    const ff_status st = ff_point_visit(&search, at, look_at, &w);
    if (!st) fill(&w, out);
    free(memory);
    return st;
}
