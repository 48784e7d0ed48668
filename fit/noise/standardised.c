/* The fit whose residuals are in standard deviations, and the noise that these come from: each makes the other better. */
#include "internal_noise.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 6, STEPS = 25, FEWEST_PAIRS = 20 };
#define SETTLED       0.05 /* change of the logarithm of a standard deviation, at the root of its mean square */
#define TOLERANCE     1e-6
#define MOST_LEVERAGE 0.99
#define ROUNDING      1e-7   /* of the largest value: where a fit to exact data may end */
#define LEAST_VALUE   1e-100 /* a square of less is none */

ff_status ff_standardised_new(const struct ff_problem *p, ff_standardised *out)
{
    ff_standardised s = {.problem = *p};
    s.factor = calloc(p->n_channels * p->n_blocks * FF_BLOCK, sizeof *s.factor);
    if (!s.factor) return FF_ERR_MEMORY;
    ff_problem_by_factor(&s.problem, s.factor);
    *out = s;
    return FF_OK;
}

void ff_standardised_free(ff_standardised *s)
{
    free(s->factor);
}

/* Cosines of sample i of p, some of the samples of `whole`. */
static void cosines_of(const struct ff_problem *p, const struct ff_problem *whole, size_t i, double *cos_i, double *cos_o)
{
    const size_t at = p == whole ? i : p->index[i];
    *cos_i = fmax((double)whole->cosine[0][at], 1e-3);
    *cos_o = fmax((double)whole->cosine[1][at], 1e-3);
}

typedef struct arrays {
    double *value, *square, *weight, *sign, *model; /* [C][n] */
    double *log_i, *log_o;                          /* [n]    */
} arrays;

/* 1 / sd of every value of a model [C][n] by a noise. */
static void weigh(ff_standardised *s, const ff_noise *noise, const arrays *a)
{
    const struct ff_problem *p = &s->problem;
    const double *model = a->value;
    for (size_t i = 0; i < p->n; i++) {
        const double angle = exp(noise->cos_i * a->log_i[i] + noise->cos_o * a->log_o[i]),
                     root = ff_problem_plane(p, i / FF_BLOCK, p->sample_weight)[i % FF_BLOCK];
        for (size_t c = 0; c < p->n_channels; c++) {
            const double sd = sqrt(ff_noise_variance(ff_noise_of(noise, c), model[c * p->n + i]) * angle) * root;
            s->factor[c * p->n_blocks * FF_BLOCK + i] = sd > 0 ? (float)(1 / sd) : 0;
        }
    }
}

/* ---- residuals and leverages ------------------------------------------------------------------ */

/* Leverage x' H^-1 x of a row x of channel c, by coordinates. */
typedef struct leverages {
    const ff_layout *l;
    size_t n, m;                     /* samples; coordinates of a channel                  */
    double *inverse;                 /* [C][m][m]                                          */
    double *row;                     /* [m][FF_BLOCK] of the Jacobian                      */
    double *value, *square, *weight; /* [C][n]                               */
} leverages;

static void take_block(void *context, const ff_visited *v)
{
    const leverages *w = context;
    const size_t m = w->m;
    const double *inverse = w->inverse + v->c * m * m;
    double(*row)[FF_BLOCK] = (double(*)[FF_BLOCK])w->row, h[FF_BLOCK] = {0};
    ff_noise_rows(w->l, v, row);
    for (size_t a = 0; a < m; a++)
        for (size_t b = 0; b <= a; b++) {
            const double factor = inverse[a * m + b] * (a == b ? 1 : 2);
            for (size_t i = 0; i < FF_BLOCK; i++) h[i] += factor * row[a][i] * row[b][i];
        }
    double *value = w->value + v->c * w->n + v->first, *square = w->square + v->c * w->n + v->first,
           *weight = w->weight + v->c * w->n + v->first;
    for (size_t i = 0; i < v->n; i++) {
        const double left = 1 - fmin(fmax(h[i], 0), MOST_LEVERAGE), e = v->y[i] - v->f[i];
        value[i] = fmax(v->f[i], 0);
        square[i] = e * e / left;
        weight[i] = v->j[i] != 0 ? left : 0;
    }
}

void ff_noise_rows(const ff_layout *l, const ff_visited *v, double (*row)[FF_BLOCK])
{
    const size_t columns = (size_t)l->free.n_shape + l->free.n_channel;
    memset(row, 0, (l->n_shared + l->n_own) * sizeof *row);
    for (size_t k = 0; k < columns; k++) {
        double *to = row[ff_layout_coordinate(l, 0, k)];
        for (size_t i = 0; i < FF_BLOCK; i++) to[i] += v->column[k][i];
    }
}

/* value, square and weight of every value at a point where plan's objective has its optimum. */
static ff_status residuals(const ff_plan *plan, ff_point *at, double *value, double *square, double *weight)
{
    const ff_layout *l = &plan->l;
    ff_information *info = NULL;
    leverages w = {.l = l, .n = plan->p->n, .m = l->n_shared + l->n_own, .value = value, .square = square, .weight = weight};
    w.inverse = malloc((l->n_channels * w.m * w.m + 1) * sizeof *w.inverse);
    w.row = malloc((w.m + 1) * FF_BLOCK * sizeof *w.row);
    ff_status status = w.inverse && w.row ? ff_point_pass(plan, at) : FF_ERR_MEMORY;
    if (!status) status = ff_information_new(plan, &at->normal, at->at_bound, &info);
    if (!status) {
        const ff_gram g = {.S = l->n_shared, .K = l->n_own, .C = l->n_channels};
        for (size_t c = 0; c < l->n_channels; c++)
            for (size_t a = 0; a < w.m; a++)
                for (size_t b = 0; b < w.m; b++) {
                    const size_t i = ff_gram_coordinate(&g, c, a), j = ff_gram_coordinate(&g, c, b);
                    w.inverse[(c * w.m + a) * w.m + b] = info->use[i] && info->use[j] ? ff_information_inverse(info, i, j) : 0;
                }
        status = ff_point_visit(plan, at, take_block, &w);
    }
    free(info);
    free(w.inverse);
    free(w.row);
    return status;
}

/* ---- correlations ------------------------------------------------------------------------------ */

static double clipped(double u)
{
    return fmin(fmax(u, -4), 4);
}

/* Along scans: of standardised residuals e [C][n], as far as they are above their own scatter. Samples of a smaller problem are no
 * neighbours. */
static void along_scans(const struct ff_problem *p, const struct ff_problem *whole, const double *e, ff_noise *noise)
{
    double square = 0;
    const size_t all = p->n * p->n_channels;
    memset(noise->along_scan + 1, 0, FF_NOISE_LAGS * sizeof *noise->along_scan);
    if (p->n != whole->n) return;
    for (size_t k = 0; k < all; k++) square += e[k] * e[k] / (double)all;
    for (size_t lag = 1; lag <= FF_NOISE_LAGS && square > 0; lag++) {
        double sum = 0, pairs = 0;
        for (size_t i = 0; i + lag < p->n; i++) {
            if (fabsf(whole->cosine[0][i] - whole->cosine[0][i + lag]) > 1e-5f) continue;
            for (size_t c = 0; c < p->n_channels; c++) sum += e[c * p->n + i] * e[c * p->n + i + lag];
            pairs += (double)p->n_channels;
        }
        const double r = pairs >= FEWEST_PAIRS ? sum / pairs / square : 0;
        if (!(r > 2 / sqrt(fmax(pairs, 1)))) { /* from where it drowns in its own scatter it decays as it began */
            for (; lag > 1 && lag <= FF_NOISE_LAGS; lag++)
                noise->along_scan[lag] = noise->along_scan[lag - 1] * noise->along_scan[1];
            break;
        }
        noise->along_scan[lag] = fmin(r, 1);
    }
}

static void between_channels(const struct ff_problem *p, const double *e, ff_noise *noise)
{
    double together = 0, square = 0;
    const double C = (double)p->n_channels;
    noise->between_channels = 0;
    if (p->n_channels < 2) return;
    for (size_t i = 0; i < p->n; i++) {
        double sum = 0, own = 0;
        for (size_t c = 0; c < p->n_channels; c++) {
            sum += e[c * p->n + i];
            own += e[c * p->n + i] * e[c * p->n + i];
        }
        together += sum * sum - own;
        square += own;
    }
    const double r = square > 0 ? together / (square * (C - 1)) : 0, noise_of_r = sqrt(2 / (C * (C - 1) * (double)p->n));
    if (r > 2 * noise_of_r) noise->between_channels = fmin(r, 1);
}

static void correlations(const struct ff_problem *p, const struct ff_problem *whole, const arrays *a, ff_noise *noise)
{
    double *e = a->model;
    for (size_t i = 0; i < p->n; i++) {
        const double angle = exp(noise->cos_i * a->log_i[i] + noise->cos_o * a->log_o[i]);
        for (size_t c = 0; c < p->n_channels; c++) {
            const size_t at = c * p->n + i;
            const double v = ff_noise_variance(ff_noise_of(noise, c), a->value[at]) * angle;
            e[at] = a->weight[at] > 0 && v > 0 ? clipped(copysign(sqrt(a->square[at] / v), a->sign[at])) : 0;
        }
    }
    along_scans(p, whole, e, noise);
    between_channels(p, e, noise);
}

/* ---- the whole --------------------------------------------------------------------------------- */

/* Is what the fit leaves rounding, or less than one value, so that it says nothing of the noise? */
static int shows_no_noise(const ff_scatter *s, double largest)
{
    double mean = 0, n = 0, left = 0;
    for (size_t k = 0; k < s->n * s->C; k++) {
        if (!(s->weight[k] > 0)) continue;
        mean += s->square[k], n++;
        left += s->weight[k];
    }
    return !(left >= 1 && sqrt(mean / n) > ROUNDING * largest);
}

/* In units of the largest value: what is small in a variance does not depend on the data's units. */
static ff_status fit_scatter(const ff_scatter *s, double *value, double *square, double largest, int first, int final,
                             ff_noise *noise)
{
    const size_t all = s->n * s->C;
    for (size_t k = 0; k < noise->n_levels && !first; k++) {
        noise->level[k].constant /= largest * largest;
        noise->level[k].linear /= largest;
    }
    for (size_t k = 0; k < all; k++) value[k] /= largest, square[k] /= largest * largest;
    const ff_status status = ff_scatter_fit(s, first, final, noise);
    for (size_t k = 0; k < all; k++) value[k] *= largest, square[k] *= largest * largest;
    noise->unit = largest;
    for (size_t k = 0; k < noise->n_levels && !status; k++) {
        noise->level[k].constant *= largest * largest;
        noise->level[k].linear *= largest;
    }
    return status;
}

/* Root mean square change of the logarithms of the weights. */
static double change_of(const float *before, const float *now, size_t n)
{
    double sum = 0, count = 0;
    for (size_t k = 0; k < n; k++) {
        if (!(before[k] > 0 && now[k] > 0)) continue;
        const double d = log((double)(now[k] / before[k]));
        sum += d * d;
        count++;
    }
    return count > 0 ? sqrt(sum / count) : 0;
}

static void fill_signs(const struct ff_problem *p, const double *model, double *sign)
{
    for (size_t c = 0; c < p->n_channels; c++)
        for (size_t i = 0; i < p->n; i++)
            sign[c * p->n + i] = ff_problem_plane(p, i / FF_BLOCK, p->value + (int)c)[i % FF_BLOCK] - model[c * p->n + i];
}

static ff_status iterate(const ff_plan *on_search, const struct ff_problem *whole, ff_standardised *s, const arrays *a,
                         float *before, ff_point *at, ff_noise *noise, int *nothing)
{
    static const ff_effort effort = {.parallel = 1, .tolerance = TOLERANCE, .max_iterations = STEPS};
    const struct ff_problem *p = on_search->p;
    const size_t stride = p->n_channels * p->n_blocks * FF_BLOCK;
    ff_plan plan = ff_plan_on(on_search, &s->problem);
    const ff_scatter scatter = {p->n, p->n_channels, a->value, a->square, a->weight, a->log_i, a->log_o};
    double change = 1;
    for (int round = 0; round < ROUNDS; round++) {
        ff_status status = residuals(round ? &plan : on_search, at, a->value, a->square, a->weight);
        double largest = 0;
        for (size_t k = 0; k < p->n * p->n_channels; k++) largest = fmax(largest, a->value[k]);
        if (!status && (*nothing = !(largest > LEAST_VALUE && largest < 1 / LEAST_VALUE) || shows_no_noise(&scatter, largest)))
            return FF_OK;
        const int last = change < SETTLED || round + 1 == ROUNDS;
        if (!status) status = fit_scatter(&scatter, a->value, a->square, largest, round == 0, last, noise);
        if (status) return status;
        if (last) break;
        memcpy(before, s->factor, stride * sizeof *before);
        weigh(s, noise, a);
        change = round ? change_of(before, s->factor, stride) : 1;
        status = ff_solve(&plan, &effort, at, NULL);
        if (status) return status;
    }
    fill_signs(p, a->value, a->sign);
    correlations(p, whole, a, noise);
    return FF_OK;
}

ff_status ff_noise_estimate(const ff_plan *plan, const ff_point *at, ff_point *where, ff_noise **out)
{
    const struct ff_problem *whole = plan->p, *p = whole->sparse;
    const size_t all = p->n * p->n_channels;
    ff_standardised s = {.factor = NULL};
    ff_plan search = ff_plan_on(plan, p);
    ff_noise *noise = ff_noise_make(p->n_channels);
    double *memory = malloc((5 * all + 2 * p->n) * sizeof *memory);
    float *before = malloc(p->n_channels * p->n_blocks * FF_BLOCK * sizeof *before);
    double data = 0;
    int nothing = 0;
    for (size_t c = 0; c < whole->n_channels; c++) data = fmax(data, whole->channel_mean[c]);
    if (!(data > 0)) { /* what scatters about zeros is the fit */
        ff_noise_free(noise);
        free(memory);
        free(before);
        *out = NULL;
        return FF_OK;
    }
    ff_status status = noise && memory && before ? ff_standardised_new(p, &s) : FF_ERR_MEMORY;
    *out = NULL;
    search.penalties = NULL;
    search.errors = 0;
    search.progress = NULL;
    search.robust = FF_ROBUST_NONE;
    if (!status) {
        const arrays a = {memory,           memory + all,     memory + 2 * all,       memory + 3 * all,
                          memory + 4 * all, memory + 5 * all, memory + 5 * all + p->n};
        for (size_t i = 0; i < p->n; i++) {
            double cos_i, cos_o;
            cosines_of(p, whole, i, &cos_i, &cos_o);
            a.log_i[i] = log(cos_i);
            a.log_o[i] = log(cos_o);
        }
        ff_point_set(plan, at->shape, at->channel, where);
        memcpy(where->at_bound, at->at_bound, plan->l.P * sizeof *at->at_bound);
        status = iterate(&search, whole, &s, &a, before, where, noise, &nothing);
    }
    ff_standardised_free(&s);
    free(memory);
    free(before);
    if (status ==
        FF_ERR_INTERNAL) { /* no number came out, as where weights by a noise lead to no optimum: there is no such noise */
        status = FF_OK;
        nothing = 1;
    }
    if (status || nothing)
        ff_noise_free(noise);
    else
        *out = noise;
    return status;
}

/* ---- deviations -------------------------------------------------------------------------------- */

typedef struct deviating {
    const struct ff_problem *p, *whole;
    const ff_noise *noise;
    float *out, angle[FF_BLOCK]; /* of the block: the root of the angles' factor */
} deviating;

static void deviate(void *context, const ff_visited *v)
{
    deviating *d = context;
    for (size_t i = 0; i < v->n && v->c == 0; i++) {
        double cos_i, cos_o;
        cosines_of(d->p, d->whole, v->first + i, &cos_i, &cos_o);
        d->angle[i] = (float)exp(0.5 * (d->noise->cos_i * log(cos_i) + d->noise->cos_o * log(cos_o)));
    }
    const ff_noise_level *level = ff_noise_of(d->noise, v->c);
    float *out = d->out + v->c * d->p->n_blocks * FF_BLOCK + v->first;
    for (size_t i = 0; i < FF_BLOCK; i++) {
        out[i] = 0;
        if (i < v->n) out[i] = (float)sqrt(ff_noise_variance(level, v->f[i])) * d->angle[i];
    }
}

ff_status ff_noise_deviations(const ff_plan *plan, const struct ff_problem *p, const ff_point *at, const ff_noise *noise,
                              float *out)
{
    deviating d = {.p = p, .whole = plan->p, .noise = noise, .out = out};
    ff_plan values = ff_plan_on(plan, p);
    values.l.free = (ff_wanted){0};
    return ff_point_visit(&values, at, deviate, &d);
}
