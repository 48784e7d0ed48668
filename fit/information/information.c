/* The information at an optimum and the covariance from it: what is the same whether H is kept as a whole or as an arrowhead. */
#include "internal_storage.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int is_sigma(const ff_plan *plan)
{
    return plan->p->selection.weighting == FF_WEIGHT_SIGMA;
}

/* ---- the inverse ----------------------------------------------------------------------------- */

static ff_information *make(const ff_plan *plan)
{
    const ff_layout *l = &plan->l;
    const ff_storage *storage = l->arrowhead ? &ff_storage_arrowhead : &ff_storage_whole;
    const size_t P = l->P, own = storage->doubles(l->n_shared, l->n_own, l->n_channels);
    ff_information *info = calloc(1, sizeof *info + (5 * P + own) * sizeof(double) + 2 * P * sizeof(int));
    if (!info) return NULL;
    double *next = (double *)(info + 1),
           **const vectors[] = {&info->scale, &info->inverse, &info->variance, &info->dof, &info->of_data};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++, next += P) *vectors[k] = next;
    info->storage = storage;
    info->P = P, info->S = l->n_shared, info->K = l->n_own, info->C = l->n_channels;
    storage->lay_out(info, next);
    info->use = (int *)(next + own);
    info->determined = info->use + P;
    return info;
}

/* The information that data and penalties give of the parameters. */
static ff_status gram_of(const ff_plan *plan, const ff_normal *n, int penalties, ff_gram *out)
{
    const ff_status status = ff_gram_new(&plan->l, out);
    if (status) return status;
    ff_gram_fill(&plan->l, n, NULL, out);
    if (penalties) ff_penalties_inform(plan, out);
    return FF_OK;
}

static void fill_scale(ff_information *info, const ff_gram *g)
{
    for (size_t c = 0; c < g->C; c++)
        for (size_t i = 0; i < g->S + g->K; i++) info->scale[ff_gram_coordinate(g, c, i)] += g->local[c * g->tri + ff_tri(i, i)];
    for (size_t k = 0; k < info->P; k++) /* no effect at all: the ridge then marks it */
        info->scale[k] = info->scale[k] > 0 ? 1 / sqrt(info->scale[k]) : 1e150;
}

/* What the inverse says by itself. With as many parameters as values nothing is left to estimate the noise from. */
static void look_at_inverse(const ff_plan *plan, ff_information *info)
{
    const size_t values = plan->p->n * plan->p->n_channels;
    const int enough = is_sigma(plan) || values > info->used;
    for (size_t k = 0; k < info->P; k++) {
        const double v = info->storage->inverse_at(info, k, k);
        info->inverse[k] = info->use[k] ? v * info->scale[k] * info->scale[k] : 0;
        info->determined[k] = info->use[k] && v < FF_UNDETERMINED && info->scale[k] < 1e150 && enough;
        info->of_data[k] = fmin(fmax(1 - ff_penalties_weight(plan, k) * info->inverse[k], 1e-9), 1);
        if (info->use[k]) info->of_channel += info->of_data[k] / (k < info->S ? 1 : (double)info->C);
    }
}

static ff_status invert(const ff_plan *plan, const ff_normal *n, const int *at_bound, int penalties, ff_information **out)
{
    ff_gram g;
    ff_information *info = make(plan);
    ff_status status = info ? gram_of(plan, n, penalties, &g) : FF_ERR_MEMORY;
    if (status) {
        free(info);
        return status;
    }
    for (size_t k = 0; k < info->P; k++) {
        info->use[k] = at_bound ? at_bound[k] == 0 : !ff_layout_is_fixed(&plan->l, k);
        info->used += (size_t)info->use[k];
    }
    fill_scale(info, &g);
    status = info->storage->invert(info, &g);
    ff_gram_free(&g);
    if (!status) look_at_inverse(plan, info);
    if (status)
        free(info);
    else
        *out = info;
    return status;
}

ff_status ff_information_new(const ff_plan *plan, const ff_normal *n, const int *at_bound, ff_information **out)
{
    return invert(plan, n, at_bound, 1, out);
}

/* ---- the covariance -------------------------------------------------------------------------- */

/* Sums of products of influences, and of squares of scores. */
typedef struct products {
    double *single, *clustered; /* the storage's                                       */
    double *square;             /* [P] of the clusters' scores, in the units of the runs */
    double *mean, *influence;   /* [P], [2 P]                                          */
} products;

/* Of clusters of info->clusters.run samples. */
static ff_status sum_clusters(const ff_information *info, const struct ff_problem *p, const ff_normal *n, size_t n_samples,
                              products *s)
{
    const size_t P = info->P, length = ff_run_length(p), runs = (p->n + length - 1) / length, last = info->clusters.run;
    double *sums = malloc((runs * P + 1) * sizeof *sums);
    if (!sums) return FF_ERR_MEMORY;
    size_t now = ff_clusters_centred(p, n, n_samples, sums, s->mean);
    for (size_t run = length; run < last; run *= 2) now = ff_clusters_join(sums, now, P);
    for (size_t k = 0; k < P; k++)
        s->square[k] =
            last > 1 ? 0 : n->score_products[n->diagonal ? k : ff_tri(k, k)] - (double)n_samples * s->mean[k] * s->mean[k];
    for (size_t b = 0; b < now && last > 1; b++) {
        ff_information_influence(info, n, sums + b * P, s->influence);
        info->storage->add_products(info, s->influence, 1, s->clustered);
        for (size_t k = 0; k < P; k++) s->square[k] += sums[b * P + k] * sums[b * P + k];
    }
    free(sums);
    return FF_OK;
}

/* A prior is a datum whose variance is known; the correction for what is estimated from the data is not its. */
static void add_priors(const ff_information *info, const ff_plan *plan, double correction, products *s)
{
    double *unit = s->influence + info->P;
    for (size_t k = 0; k < info->P; k++) {
        const double noise = ff_penalties_noise(plan, k) * info->scale[k] * info->scale[k] / correction;
        if (!(noise > 0)) continue;
        memset(unit, 0, info->P * sizeof *unit);
        unit[k] = 1;
        info->storage->apply(info, unit, s->influence);
        info->storage->add_products(info, s->influence, noise, s->single);
        info->storage->add_products(info, s->influence, noise, s->clustered);
    }
}

double ff_information_seen(const ff_information *info, double number)
{
    return ff_clusters_share_seen(info->of_channel, number);
}

/* Factors on the variances, and degrees of freedom; info->dof comes as the number of clusters. */
static void widen(ff_information *info, int sigma, double correction, const products *s, double *factor)
{
    const int clustered = info->clusters.run > 1;
    for (size_t k = 0; k < info->P; k++) {
        const double one = info->storage->product_at(info, s->single, k), more = info->storage->product_at(info, s->clustered, k),
                     data = info->of_data[k];
        factor[k] = correction;
        if (sigma && clustered && one > 0) factor[k] *= fmax(more / one, 1); /* larger by what clusters have more than samples */
        if (clustered)
            factor[k] /= data * ff_information_seen(info, info->dof[k]) + 1 - data; /* of so many samples nothing is missed */
        factor[k] = info->scale[k] * sqrt(factor[k]);
        info->dof[k] = (info->dof[k] - 1) / data;
    }
}

static ff_status count_clusters(ff_information *info, const ff_plan *plan, const ff_normal *n, size_t n_samples)
{
    const struct ff_problem *p = plan->p;
    const size_t length = ff_run_length(p), run = info->clusters.run > length ? info->clusters.run : length;
    for (size_t k = 0; k < info->P; k++) info->dof[k] = INFINITY;
    if ((is_sigma(plan) && info->clusters.run == 1) || !n->runs) return FF_OK;
    return ff_clusters_informative(p, n, n_samples, NULL, (p->n + run - 1) / run, info, info->dof);
}

static ff_status fill(ff_information *info, const ff_plan *plan, const ff_normal *n, size_t n_samples, const double *of_samples,
                      products *s, double *factor)
{
    const ff_storage *storage = info->storage;
    const int sigma = is_sigma(plan);
    const double N = (double)(n_samples * info->C), used = (double)info->used,
                 correction = !sigma && N > used ? (N - 1) / (N - used) : 1;
    ff_status status = sum_clusters(info, plan->p, n, n_samples, s);
    if (!status) status = storage->of_single(info, n, n_samples, s->mean, of_samples, s->single);
    if (!status) status = count_clusters(info, plan, n, n_samples);
    if (status) return status;
    info->effective = ff_clusters_effective(n, s->square, info->S, N);
    add_priors(info, plan, correction, s);
    if (sigma)
        storage->take_inverse(info);
    else
        storage->take_products(info, info->clusters.run > 1 ? s->clustered : s->single);
    widen(info, sigma, correction, s, factor);
    storage->multiply(info, factor);
    for (size_t k = 0; k < info->P; k++) info->variance[k] = storage->covariance(info, k, k);
    return FF_OK;
}

static ff_status covariance(ff_information *info, const ff_plan *plan, const ff_normal *n, size_t n_samples,
                            const double *of_samples)
{
    const size_t size = info->storage->products(info), P = info->P;
    double *memory = calloc(2 * size + 5 * P + 1, sizeof *memory);
    if (!memory) return FF_ERR_MEMORY;
    products s = {.single = memory, .clustered = memory + size, .square = memory + 2 * size};
    s.mean = s.square + P;
    s.influence = s.mean + P;
    const ff_status status = fill(info, plan, n, n_samples, of_samples, &s, s.influence + 2 * P);
    free(memory);
    return status;
}

ff_status ff_information_finish(ff_information *info, const ff_plan *plan, const ff_normal *n, size_t n_samples,
                                const double *of_samples)
{
    const ff_status status = ff_clusters_choose(plan, n, n_samples, &info->clusters);
    return status ? status : covariance(info, plan, n, n_samples, of_samples);
}

double ff_information_inverse(const ff_information *info, size_t i, size_t j)
{
    return info->storage->inverse_at(info, i, j) * info->scale[i] * info->scale[j];
}

void ff_information_multiply(ff_information *info, const double *factor)
{
    info->storage->multiply(info, factor);
    for (size_t k = 0; k < info->P; k++) info->variance[k] = info->storage->covariance(info, k, k);
}

ff_status ff_information_from_scores(ff_information *info, const ff_plan *plan, ff_gram *M)
{
    for (size_t c = 0; c < M->C; c++)
        for (size_t i = 0; i < M->S + M->K; i++) {
            const size_t k = ff_gram_coordinate(M, c, i);
            if (i >= M->S || c == 0) M->local[c * M->tri + ff_tri(i, i)] += ff_penalties_noise(plan, k);
        }
    const ff_status status = info->storage->sandwich(info, M);
    if (!status) ff_information_multiply(info, info->scale);
    return status;
}

ff_status ff_information_from_influences(ff_information *info, const double *influence, size_t n, double factor)
{
    const size_t P = info->P;
    double *sums = calloc(info->storage->products(info) + P + 1, sizeof *sums);
    if (!sums) return FF_ERR_MEMORY;
    double *scaled = sums + info->storage->products(info);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < P; k++) scaled[k] = info->use[k] ? influence[i * P + k] / info->scale[k] : 0;
        info->storage->add_products(info, scaled, factor, sums);
    }
    info->storage->take_products(info, sums);
    ff_information_multiply(info, info->scale);
    free(sums);
    return FF_OK;
}

/* ---- what others ask ------------------------------------------------------------------------- */

double ff_information_covariance(const ff_information *info, size_t i, size_t j)
{
    return info->storage->covariance(info, i, j);
}

ff_status ff_information_solve(const ff_information *info, const double *gradient, double *out)
{
    double *scaled = malloc((info->P + 1) * sizeof *scaled);
    if (!scaled) return FF_ERR_MEMORY;
    for (size_t k = 0; k < info->P; k++) scaled[k] = info->use[k] ? gradient[k] * info->scale[k] : 0;
    info->storage->apply(info, scaled, out);
    for (size_t k = 0; k < info->P; k++) out[k] *= info->scale[k];
    free(scaled);
    return FF_OK;
}

/* By the data alone. */
static ff_status look_at_condition(const ff_plan *plan, const ff_point *at, size_t *rank, double *condition, double *curvature,
                                   double *share)
{
    ff_gram g;
    ff_information *info = NULL;
    ff_status status = invert(plan, &at->normal, at->at_bound, 0, &info);
    if (status) return status;
    status = gram_of(plan, &at->normal, 0, &g);
    if (!status) {
        status = info->storage->condition(info, &g, rank, condition, curvature, share);
        ff_gram_free(&g);
    }
    free(info);
    return status;
}

ff_status ff_information_condition(const ff_plan *plan, const ff_point *at, size_t *rank, double *condition)
{
    return look_at_condition(plan, at, rank, condition, NULL, NULL);
}

ff_status ff_information_flattest(const ff_plan *plan, const ff_point *at, double *curvature, double *share)
{
    size_t rank;
    double condition;
    return look_at_condition(plan, at, &rank, &condition, curvature, share);
}
