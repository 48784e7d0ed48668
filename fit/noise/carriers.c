/* What single values have to do with the errors: how many carry a parameter, what their residuals alone say, and how much larger
 * the errors are since neighbours and channels err together. */
#include "internal_noise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LEVERAGE 0.9999
/* Of the variance of independent values: correlations are not known so well that they could take more away. */
#define LEAST_ALONG 0.25

enum { NUMBERS = 5, VARIANCE = 0, HC2 = 1, HC3 = 2, LAGGED = 3, SUMS = 4, ROOM = FF_NOISE_LAGS + FF_BLOCK };

/* A walk over the values. Of an arrowhead a value has influences [P] on what all channels share and on its own channel's; on that
 * of another channel c it has F_c times that on the shared ones (information/arrowhead.c: v_c = -K_c v_0 there), which is put
 * together from the products of the shared ones in the end. */
typedef struct walk {
    const ff_layout *l;
    const struct ff_problem *p, *whole;
    const ff_noise *noise;
    const float *deviation; /* [C][n_blocks FF_BLOCK]                                                    */
    size_t m, P;            /* coordinates of a channel; influences of a value                            */
    int arrowhead;
    double *inverse;                    /* [C][P][m]                                                      */
    double *outside;                    /* [C][P][m] for samples that are not in the part; NULL: all are  */
    const float *part;                  /* [whole n_blocks FF_BLOCK] 1 in the part                        */
    double *other;                      /* [C][K][S] F, of an arrowhead                                       */
    double *sum[SUMS];                  /* [parameters] of v, of squares of residuals, of neighbours      */
    double *own, *square, *z;           /* [parameters] of v, v^2; [parameters][NUMBERS]                  */
    double *joint;                      /* [parameters]                                                   */
    double *shared[SUMS];               /* [C][S][S] of an arrowhead: products of influences on what is shared */
    double *row;                        /* [m][FF_BLOCK] of the Jacobian, by coordinate                   */
    double *influence;                  /* [P][FF_BLOCK]                                                  */
    double *together;                   /* [P][FF_BLOCK] sum over channels so far                         */
    double *tail;                       /* [C][P][ROOM] in deviations, the latest block behind those before it */
    double *many, *few, *log_i, *log_o; /* [FF_BLOCK]: samples that one stands for, its inverse; of its cosines */
} walk;

/* The parameter of influence k of channel c. */
static size_t parameter(const walk *w, size_t c, size_t k)
{
    return !w->arrowhead || k < w->l->n_shared ? k : k + c * w->l->n_own;
}

/* Sum over neighbours along scans of the products of influences a and b [ROOM], the latest block. */
static double neighbours(const walk *w, const ff_visited *v, const double *a, const double *b)
{
    double sum = 0;
    for (size_t d = 1; d <= FF_NOISE_LAGS && w->noise->along_scan[d] > 0; d++)
        for (size_t i = 0; i < v->n; i++) {
            const size_t at = v->first + i, k = FF_NOISE_LAGS + i;
            if (at < d || fabsf(w->whole->cosine[0][at] - w->whole->cosine[0][at - d]) > 1e-5f) continue;
            sum += w->noise->along_scan[d] * (a[k] * b[k - d] + b[k] * a[k - d]);
        }
    return sum;
}

static void lag(const walk *w, const ff_visited *v)
{
    const size_t S = w->l->n_shared;
    double *tail = w->tail + v->c * w->P * ROOM;
    for (size_t k = 0; k < w->P; k++) w->sum[LAGGED][parameter(w, v->c, k)] += neighbours(w, v, tail + k * ROOM, tail + k * ROOM);
    for (size_t a = 0; a < S && w->arrowhead; a++)
        for (size_t b = 0; b < S; b++)
            w->shared[LAGGED][(v->c * S + a) * S + b] += neighbours(w, v, tail + a * ROOM, tail + b * ROOM);
    for (size_t k = 0; k < w->P; k++) memmove(tail + k * ROOM, tail + k * ROOM + FF_BLOCK, FF_NOISE_LAGS * sizeof *tail);
}

/* What belongs to a block of samples and not to a channel. */
static void prepare_block(const walk *w, const ff_visited *v)
{
    for (size_t i = 0; i < v->n; i++) {
        const size_t at = w->p == w->whole ? v->first + i : w->p->index[v->first + i];
        w->many[i] = ff_problem_stands_for(w->p, w->whole, v->first + i);
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

/* Replaces the influences of the samples outside the part. */
static void leave_part(const walk *w, const ff_visited *v, const double *inverse, double (*row)[FF_BLOCK], double *a)
{
    double other[FF_BLOCK];
    influence(inverse, w->m, row, other);
    for (size_t i = 0; i < v->n; i++) {
        const size_t at = w->p == w->whole ? v->first + i : w->p->index[v->first + i];
        if (!(w->part[at] > 0)) a[i] = other[i];
    }
}

/* The place of parameter k among the coordinates of channel c; m for another channel's. */
static size_t own_place(const walk *w, size_t c, size_t k)
{
    const size_t S = w->l->n_shared, K = w->l->n_own;
    if (w->arrowhead || k < S) return k;
    return (k - S) / K == c ? S + (k - S) % K : w->m;
}

/* Adds what a block says of parameter k, one of the channel's `own` or of another. a: influences; sd: of the residuals; of the
 * logarithm of a variance z. */
static void add_parameter(const walk *w, const ff_visited *v, size_t k, int own, const double *a, const double *sd,
                          double (*z)[FF_BLOCK])
{
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
    w->sum[VARIANCE][at] += sum;
    if (!own) return; /* a parameter of a channel is carried by its values; others act through what is shared */
    w->own[at] += sum;
    w->square[at] += square;
    for (size_t q = 0; q < NUMBERS; q++) w->z[at * NUMBERS + q] += by[q];
}

/* Products of the influences on what is shared, by the weights of every sum. */
static void add_shared(const walk *w, const ff_visited *v, const double *sd, const double *e2, const double *e3)
{
    const size_t S = w->l->n_shared;
    for (size_t a = 0; a < S; a++)
        for (size_t b = 0; b < S; b++) {
            const double *x = w->influence + a * FF_BLOCK, *y = w->influence + b * FF_BLOCK;
            double sum[3] = {0};
            for (size_t i = 0; i < v->n; i++) {
                sum[VARIANCE] += x[i] * y[i] * sd[i] * sd[i] * w->few[i];
                sum[HC2] += x[i] * y[i] * e2[i];
                sum[HC3] += x[i] * y[i] * e3[i];
            }
            for (int k = 0; k < 3; k++) w->shared[k][(v->c * S + a) * S + b] += sum[k];
        }
}

/* Squares of the sums over the channels of a sample, after the last of them. Its block is still behind the tails. */
static void add_joint(const walk *w, const ff_visited *v)
{
    const size_t S = w->l->n_shared, K = w->l->n_own, C = w->p->n_channels;
    for (size_t k = 0; k < (w->arrowhead ? S : w->P); k++)
        for (size_t i = 0; i < v->n; i++) w->joint[k] += w->together[k * FF_BLOCK + i] * w->together[k * FF_BLOCK + i] * w->few[i];
    for (size_t c = 0; c < C && w->arrowhead; c++)
        for (size_t k = 0; k < K; k++) {
            const double *of_block = w->tail + c * w->P * ROOM + FF_NOISE_LAGS, *F = w->other + (c * K + k) * S;
            double sum = 0;
            for (size_t i = 0; i < v->n; i++) {
                double all = of_block[(S + k) * ROOM + i];
                for (size_t a = 0; a < S; a++) all += F[a] * (w->together[a * FF_BLOCK + i] - of_block[a * ROOM + i]);
                sum += all * all * w->few[i];
            }
            w->joint[S + c * K + k] += sum;
        }
}

static void look_at(void *context, const ff_visited *v)
{
    const walk *w = context;
    const double *inverse = w->inverse + v->c * w->P * w->m;
    const float *deviation = w->deviation + v->c * w->p->n_blocks * FF_BLOCK + v->first;
    const ff_noise_level *level = ff_noise_of(w->noise, v->c);
    double(*row)[FF_BLOCK] = (double(*)[FF_BLOCK])w->row, z[NUMBERS][FF_BLOCK], sd[FF_BLOCK], h[FF_BLOCK] = {0}, e2[FF_BLOCK],
    e3[FF_BLOCK];
    const double unit = w->noise->unit > 0 ? w->noise->unit : 1;
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
        if (w->outside) leave_part(w, v, w->outside + (v->c * w->P + k) * w->m, row, a);
        for (size_t i = 0; i < FF_BLOCK && own < w->m; i++) h[i] += a[i] * row[own][i];
        add_parameter(w, v, k, own < w->m, a, sd, z);
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
        w->sum[HC2][parameter(w, v->c, k)] += two;
        w->sum[HC3][parameter(w, v->c, k)] += three;
    }
    if (w->arrowhead) add_shared(w, v, sd, e2, e3);
    if (v->c + 1 == w->p->n_channels && w->noise->between_channels > 0) add_joint(w, v);
    if (w->noise->along_scan[1] > 0 && w->p->n == w->whole->n) lag(w, v);
}

/* H^-1 between the influences of a channel and its coordinates. */
static void take_inverse(const walk *w, const ff_information *info, double *out)
{
    const ff_gram g = {.S = w->l->n_shared, .K = w->l->n_own, .C = w->l->n_channels};
    for (size_t c = 0; c < g.C; c++)
        for (size_t k = 0; k < w->P; k++)
            for (size_t b = 0; b < w->m; b++) {
                const size_t i = parameter(w, c, k), j = ff_gram_coordinate(&g, c, b);
                out[(c * w->P + k) * w->m + b] = info->use[i] && info->use[j] ? ff_information_inverse(info, i, j) : 0;
            }
    if (w->arrowhead) ff_information_followers(info, w->other);
}

/* What the values of other channels add to the sums of channel c's own parameters. */
static void add_others(const walk *w)
{
    const size_t S = w->l->n_shared, K = w->l->n_own, C = w->l->n_channels;
    for (int sum = 0; sum < SUMS; sum++) {
        double all[FF_MAX_SHARED * FF_MAX_SHARED] = {0};
        for (size_t c = 0; c < C; c++)
            for (size_t q = 0; q < S * S; q++) all[q] += w->shared[sum][c * S * S + q];
        for (size_t c = 0; c < C; c++)
            for (size_t k = 0; k < K; k++) {
                const double *F = w->other + (c * K + k) * S, *own = w->shared[sum] + c * S * S;
                for (size_t a = 0; a < S; a++)
                    for (size_t b = 0; b < S; b++) w->sum[sum][S + c * K + k] += F[a] * (all[a * S + b] - own[a * S + b]) * F[b];
            }
    }
}

static void fill(const walk *w, ff_carriers *out)
{
    const double r = w->noise->between_channels;
    for (size_t k = 0; k < w->l->P; k++) {
        const double own = w->own[k];
        out->number[k] = w->square[k] > 0 ? own * own / w->square[k] : 0;
        out->sway[k] = 0;
        for (size_t a = 0; a < NUMBERS && own > 0; a++)
            for (size_t b = 0; b < NUMBERS; b++)
                out->sway[k] += w->z[k * NUMBERS + a] * w->noise->uncertainty[a][b] * w->z[k * NUMBERS + b] / (own * own);
    }
    if (w->arrowhead) add_others(w);
    for (size_t k = 0; k < w->l->P; k++) {
        const double sum = w->sum[VARIANCE][k];
        out->error[k] = sqrt(fmax(sum, 0));
        out->hc2[k] = sqrt(w->sum[HC2][k]);
        out->hc3[k] = sqrt(w->sum[HC3][k]);
        out->along[k] = sum > 0 ? sqrt(fmax(1 + w->sum[LAGGED][k] / sum, LEAST_ALONG)) : 1;
        out->between[k] = sum > 0 && r > 0 ? sqrt(fmax(1 - r + r * w->joint[k] / sum, 0)) : 1;
    }
}

static ff_status walk_over(const ff_plan *plan, const ff_point *at, const ff_noise *noise, const float *deviation,
                           const ff_information *info, const ff_information *of_part, const float *part, ff_carriers *out)
{
    const ff_layout *l = &plan->l;
    const struct ff_problem *whole = plan->p, *p = whole->sparse;
    const ff_plan search = ff_plan_on(plan, p);
    walk w = {.l = l,
              .p = p,
              .whole = whole,
              .noise = noise,
              .deviation = deviation,
              .m = l->n_shared + l->n_own,
              .arrowhead = l->arrowhead};
    const size_t S = l->n_shared, K = l->n_own, C = l->n_channels, P = l->P;
    w.P = l->arrowhead ? w.m : P;
    const size_t outside = of_part ? C * w.P * w.m : 0, shared = l->arrowhead ? C * S * S : 0, other = l->arrowhead ? C * K * S : 0;
    double *next = NULL, *memory;
    const struct {
        double **at;
        size_t n;
    } piece[] = {{&w.inverse, C * w.P * w.m},
                 {&w.outside, outside},
                 {&w.other, other},
                 {&w.sum[VARIANCE], P},
                 {&w.sum[HC2], P},
                 {&w.sum[HC3], P},
                 {&w.sum[LAGGED], P},
                 {&w.own, P},
                 {&w.square, P},
                 {&w.z, NUMBERS * P},
                 {&w.joint, P},
                 {&w.shared[VARIANCE], shared},
                 {&w.shared[HC2], shared},
                 {&w.shared[HC3], shared},
                 {&w.shared[LAGGED], shared},
                 {&w.row, w.m * FF_BLOCK},
                 {&w.influence, w.P * FF_BLOCK},
                 {&w.together, w.P * FF_BLOCK},
                 {&w.tail, C * w.P * ROOM},
                 {&w.many, FF_BLOCK},
                 {&w.few, FF_BLOCK},
                 {&w.log_i, FF_BLOCK},
                 {&w.log_o, FF_BLOCK}};
    size_t doubles = 1;
    for (size_t k = 0; k < sizeof piece / sizeof *piece; k++) doubles += piece[k].n;
    memory = calloc(doubles, sizeof *memory);
    if (!memory) return FF_ERR_MEMORY;
    next = memory;
    for (size_t k = 0; k < sizeof piece / sizeof *piece; k++) {
        *piece[k].at = next;
        next += piece[k].n;
    }
    take_inverse(&w, info, w.inverse);
    if (of_part) {
        take_inverse(&w, of_part, w.outside);
        for (size_t k = 0; k < outside; k++) { /* H_part^-1 - H^-1 inside, -H^-1 outside */
            const double all = w.inverse[k];
            w.inverse[k] = w.outside[k] - all;
            w.outside[k] = -all;
        }
        w.part = part;
    } else
        w.outside = NULL;
    const ff_status status = ff_point_visit(&search, at, look_at, &w);
    if (!status) fill(&w, out);
    free(memory);
    return status;
}

ff_status ff_carriers_find(const ff_plan *plan, const ff_point *at, const ff_noise *noise, const float *deviation,
                           const ff_information *info, ff_carriers *out)
{
    return walk_over(plan, at, noise, deviation, info, NULL, NULL, out);
}

ff_status ff_carriers_of_difference(const ff_plan *plan, const ff_point *at, const ff_noise *noise, const float *deviation,
                                    const ff_information *all, const ff_information *of_part, const float *part, ff_carriers *out)
{
    return walk_over(plan, at, noise, deviation, all, of_part, part, out);
}
