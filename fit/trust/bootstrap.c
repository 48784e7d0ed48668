/* Refits with random weights of whole incident directions: errors that go together inside one are resampled together. */
#include "base/internal_order.h"
#include "base/internal_statistics.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST_REPEATS = 20, FEWEST_GROUPS = 5, MOST_ITERATIONS = 50 };
#define REFIT_TOLERANCE 1e-6 /* of the objective: of a refit's distance from its optimum, some 1e-3 standard errors */

typedef struct bootstrap {
    const ff_finished *fit;
    const ff_places *places;
    const ff_resampled *resampled;
    uint64_t seed;
    double *weight; /* [threads][n_groups]    */
    double *x;      /* [repeats][P], of those that converged */
    unsigned char *converged;
    ff_status *status; /* [repeats] */
} bootstrap;

/* SplitMix64 (Steele, Lea and Flood 2014) of a counter; in (0, 1). */
static double uniform_at(uint64_t seed, uint64_t repeat, uint64_t draw)
{
    uint64_t z =
        (seed * UINT64_C(0xd1342543de82ef95) + repeat) * UINT64_C(0xaf251af3b0f025b5) + (draw + 1) * UINT64_C(0x9e3779b97f4a7c15);
    for (int k = 0; k < 2; k++) {
        z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
        z ^= z >> 31;
    }
    return ((double)(z >> 12) + 0.5) / 4503599627370496.0;
}

/* A random weight for every group, with mean 1: Rubin's (1981). */
static void draw_weights(const bootstrap *b, size_t repeat, double *weight)
{
    const size_t G = b->places->n_groups;
    double sum = 0;
    for (size_t g = 0; g < G; g++) sum += weight[g] = -log(uniform_at(b->seed, repeat, g));
    for (size_t g = 0; g < G; g++) weight[g] *= (double)G / sum;
}

static void refit(void *context, size_t repeat, int worker)
{
    static const ff_effort effort = {.tolerance = REFIT_TOLERANCE, .max_iterations = MOST_ITERATIONS};
    const bootstrap *b = context;
    const ff_plan plan = ff_plan_on(&b->fit->plan, &b->resampled->problem[worker]);
    double *weight = b->weight + (size_t)worker * b->places->n_groups;
    ff_point at = {0};
    ff_status status = ff_plan_cancelled(&plan) ? FF_ERR_CANCELLED : ff_point_new(&plan, &at);
    if (!status) {
        draw_weights(b, repeat, weight);
        ff_resampled_weigh(b->resampled, worker, b->places, weight);
        ff_point_set(&plan, b->fit->at.shape, b->fit->at.channel, &at);
        status = ff_solve(&plan, &effort, &at, NULL);
    }
    b->status[repeat] = status;
    b->converged[repeat] = !status && at.outcome == FF_CONVERGED;
    if (b->converged[repeat]) ff_layout_pack(&plan.l, at.shape, at.channel, b->x + repeat * plan.l.P);
    ff_point_free(&at);
}

/* The covariance of coordinates a and b over n refits of P coordinates each. */
static double covariance(const double *x, size_t n, size_t P, size_t a, size_t b)
{
    double mean_a = 0, mean_b = 0, sum = 0;
    for (size_t i = 0; i < n; i++) {
        mean_a += x[i * P + a] / (double)n;
        mean_b += x[i * P + b] / (double)n;
    }
    for (size_t i = 0; i < n; i++) sum += (x[i * P + a] - mean_a) * (x[i * P + b] - mean_b);
    return sum / (double)(n - 1);
}

/* The 95 % quantile of the distance from the bound. */
static ff_status one_sided(const double *x, size_t n, size_t P, size_t k, const ff_param *info, ff_fit_value *v)
{
    double *sorted = malloc(n * sizeof *sorted);
    if (!sorted) return FF_ERR_MEMORY;
    for (size_t i = 0; i < n; i++) sorted[i] = x[i * P + k];
    qsort(sorted, n, sizeof *sorted, ff_ascending);
    const size_t at = (size_t)ceil(0.95 * (double)n) - 1;
    const double end = ff_coordinate_value(info, v->at_bound < 0 ? sorted[at] : sorted[n - 1 - at]);
    v->interval = FF_INTERVAL_BOOTSTRAP;
    v->low = fmin(v->value, end);
    v->high = fmax(v->value, end);
    free(sorted);
    return FF_OK;
}

/* For every parameter [P]. */
typedef struct groups_that_count {
    double *number, *seen; /* see ff_clusters_informative and ff_information_seen */
} groups_that_count;

/* x [n][P]: the refits that converged. */
static ff_status take_errors(const ff_layout *l, const double *x, size_t n, size_t G, const groups_that_count *count,
                             ff_fit_result *fit)
{
    const size_t P = l->P;
    ff_status status = FF_OK;
    for (size_t a = 0; a < P && !status; a++) {
        ff_fit_value *v = ff_result_value(l, fit, a);
        const ff_param *info = ff_layout_param(l, a, NULL)->info;
        if (v->held) continue;
        if (v->at_bound) {
            status = one_sided(x, n, P, a, info, v);
            continue;
        }
        /* weights of G groups have the variance (G - 1) / (G + 1) instead of 1 */
        const double factor = sqrt((double)(G + 1) / (double)(G - 1) * (1 - 1 / (double)G) / count->seen[a]);
        const double t = ff_student_quantile(0.95, count->number[a] - 1),
                     error = factor * sqrt(covariance(x, n, P, a, a)) * ff_coordinate_slope(info, v->value);
        if (!isnan(v->std_error)) v->std_error = error;
        ff_interval_around(info, t * error, FF_INTERVAL_BOOTSTRAP, v);
        for (size_t b = 0; b < P; b++) {
            const int i = v->column, j = ff_result_value(l, fit, b)->column;
            if (!fit->correlation || i < 0 || j < 0 || a == b) continue;
            const double scale = sqrt(covariance(x, n, P, a, a) * covariance(x, n, P, b, b));
            fit->correlation[(size_t)i * fit->n_columns + (size_t)j] = scale > 0 ? covariance(x, n, P, a, b) / scale : 0;
        }
    }
    ff_result_copy_tied(l, fit);
    return status;
}

static ff_status count_groups(ff_finished *f, const ff_places *places, const groups_that_count *count)
{
    const ff_plan *plan = &f->plan;
    ff_status status = ff_errors(plan, &f->at);
    if (!status)
        status = ff_clusters_informative(plan->p, &f->at.normal, plan->p->n, places->group, places->n_groups, f->at.information,
                                         count->number);
    for (size_t k = 0; k < plan->l.P && !status; k++) count->seen[k] = ff_information_seen(f->at.information, count->number[k]);
    return status;
}

static ff_status check(const ff_places *places, size_t repeats, ff_error *err)
{
    if (repeats < FEWEST_REPEATS)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a bootstrap needs at least %d refits, found %zu", (int)FEWEST_REPEATS,
                            repeats);
    if (places->n_groups < FEWEST_GROUPS)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "%zu %s are too few to resample: at least %d", places->n_groups,
                            ff_grouping_name((int)places->kind), (int)FEWEST_GROUPS);
    return FF_OK;
}

/* Refits that converged to the front of x; how many. */
static size_t pack(bootstrap *b, size_t repeats, size_t P)
{
    size_t n = 0;
    for (size_t i = 0; i < repeats; i++) {
        if (!b->converged[i]) continue;
        memmove(b->x + n * P, b->x + i * P, P * sizeof *b->x);
        n++;
    }
    return n;
}

ff_status ff_trust_bootstrap_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats,
                                  uint64_t seed, ff_fit_result *fit, ff_bootstrap *out, ff_error *err)
{
    ff_finished f;
    ff_resampled resampled = {0};
    ff_status status = check(places, repeats, err);
    if (!status) status = ff_finished_open_data(p, o, fit, "the bootstrap", &f, err);
    if (status) return status;
    const size_t P = f.plan.l.P, threads = (size_t)ff_pool_threads(p->pool);
    bootstrap b = {.fit = &f, .places = places, .resampled = &resampled, .seed = seed};
    b.weight = malloc(threads * places->n_groups * sizeof *b.weight);
    b.x = malloc((repeats * P + 1) * sizeof *b.x);
    b.converged = calloc(repeats, 1);
    b.status = calloc(repeats, sizeof *b.status);
    const groups_that_count count = {malloc((P + 1) * sizeof(double)), malloc((P + 1) * sizeof(double))};
    status =
        b.weight && b.x && b.converged && b.status && count.number && count.seen ? ff_resampled_new(p, &resampled) : FF_ERR_MEMORY;
    size_t n = 0;
    if (!status) {
        ff_pool_run(p->pool, repeats, refit, &b);
        for (size_t i = 0; i < repeats && !status; i++)
            if (b.status[i] == FF_ERR_CANCELLED || b.status[i] == FF_ERR_MEMORY) status = b.status[i];
        n = pack(&b, repeats, P);
    }
    if (status) {
        (void)ff_trust_ended(status, "the bootstrap", err);
    } else if (n < FEWEST_REPEATS) {
        status = ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "only %zu of %zu refits of the bootstrap converged", n, repeats);
    } else {
        status = count_groups(&f, places, &count);
        if (!status) status = take_errors(&f.plan.l, b.x, n, places->n_groups, &count, fit);
        if (status) ff_error_set(err, status, NULL, 0, -1, "out of memory");
    }
    if (!status) *out = (ff_bootstrap){sizeof *out, repeats, repeats - n, places->n_groups, places->kind};
    ff_resampled_free(&resampled);
    free(b.weight);
    free(b.x);
    free(b.converged);
    free(b.status);
    free(count.number);
    free(count.seen);
    ff_finished_close(&f);
    return status;
}
