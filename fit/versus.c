/* Two models on the same samples: what each sample says for one or the other, and how sure the sum of it is. */
#include "internal_statistics.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { GROUPS_FOR_VARIANCE = 10, FOLD_ITERATIONS = 50 };
#define FOLD_TOLERANCE 1e-7

/* ---- cross-validation ------------------------------------------------------------------------ */

typedef struct folds {
    const struct ff_problem *p;
    const ff_point *point;
    const ff_places *places;
    const ff_fit_options *o;
    const ff_resampled *resampled;
    size_t n;
    double *held_out; /* [n_groups] objective of the samples of a group in the fit without it */
    ff_status *status;
} folds;

/* The objective of the groups of a fold, which the fit has not seen. */
static ff_status add_held_out(const folds *f, size_t fold, const double *shape, const double *channel)
{
    const ff_places *places = f->places;
    double *cost = malloc((places->n + 1) * sizeof *cost);
    ff_status st = cost ? ff_point_cost(&f->point->l, f->p, f->o, shape, channel, cost) : FF_ERR_MEMORY;
    for (size_t i = 0; i < places->n && !st; i++)
        if (places->group[i] % f->n == fold) f->held_out[places->group[i]] += cost[i];
    free(cost);
    return st;
}

static void fit_fold(void *context, size_t fold, int worker)
{
    const folds *f = context;
    const ff_layout *l = &f->point->l;
    const size_t G = f->places->n_groups, size = l->n_channels * l->m->n_channel;
    const struct ff_problem *p = &f->resampled->problem[worker];
    double *weight = malloc((G + 1) * sizeof *weight), shape[FF_MAX_SHAPE], *channel = malloc((size + 1) * sizeof *channel);
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    ff_solution solution;
    ff_status st = weight && channel && at_bound ? FF_OK : FF_ERR_MEMORY;
    if (!st) {
        for (size_t g = 0; g < G; g++) weight[g] = g % f->n != fold;
        ff_resampled_weigh(f->resampled, worker, f->places, weight);
        memcpy(shape, f->point->shape, sizeof shape);
        memcpy(channel, f->point->channel, size * sizeof *channel);
        st = ff_solve(l, p, f->o, 0, 0, FOLD_TOLERANCE, FOLD_ITERATIONS, shape, channel, at_bound, &solution, NULL);
    }
    if (!st) st = add_held_out(f, fold, shape, channel);
    f->status[fold] = st;
    free(weight);
    free(channel);
    free(at_bound);
}

/* held_out [n_groups] */
static ff_status cross_validate(ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit, size_t n,
                                double *held_out, ff_error *err)
{
    ff_point point;
    ff_resampled resampled = {0};
    ff_status st = ff_point_new(p, o, fit, &point, err);
    if (st) return st;
    folds f = {p, &point, places, o, &resampled, n, held_out, calloc(n, sizeof *f.status)};
    st = f.status ? ff_resampled_new(p, &resampled) : FF_ERR_MEMORY;
    memset(held_out, 0, places->n_groups * sizeof *held_out);
    if (!st) {
        ff_pool_run(p->pool, n, fit_fold, &f);
        for (size_t k = 0; k < n && !st; k++) st = f.status[k];
    }
    if (st) ff_error_set(err, st, NULL, 0, -1, "the cross-validation ended early: %s", ff_status_str(st));
    ff_resampled_free(&resampled);
    free(f.status);
    ff_point_free(&point);
    return st;
}

/* ---- Vuong's test ---------------------------------------------------------------------------- */

/* What every sample of p says for the winner, to the objective's last digit: log likelihoods of normal residuals whose variance is
 * that of each fit (with standard deviations of the data, 1). cost [n] each; out [n]. */
static void log_ratios(const struct ff_problem *p, const double *winner, const double *other, double *out)
{
    const double C = (double)p->n_channels, N = (double)p->n * C;
    double sum_w = 0, sum_o = 0;
    for (size_t i = 0; i < p->n; i++) sum_w += winner[i], sum_o += other[i];
    const int sigma = p->selection.weighting == FF_WEIGHT_SIGMA;
    const double vw = sigma ? 1 : fmax(2 * sum_w / N, 1e-300), vo = sigma ? 1 : fmax(2 * sum_o / N, 1e-300);
    const double constant = 0.5 * C * log(vo / vw);
    for (size_t i = 0; i < p->n; i++) out[i] = constant + other[i] / vo - winner[i] / vw;
}

/* Variance of the sum of n terms from the sums of clusters. */
static double variance_of_sum(const double *sums, size_t n)
{
    double mean = 0, square = 0;
    for (size_t k = 0; k < n; k++) mean += sums[k] / (double)n;
    for (size_t k = 0; k < n; k++) square += (sums[k] - mean) * (sums[k] - mean);
    return n > 1 ? square * (double)n / (double)(n - 1) : INFINITY;
}

static double variance_over_runs(const double *m, size_t n, size_t run, double *sums)
{
    const size_t clusters = (n + run - 1) / run;
    memset(sums, 0, clusters * sizeof *sums);
    for (size_t i = 0; i < n; i++) sums[i / run] += m[i];
    return variance_of_sum(sums, clusters);
}

static double variance_over_groups(const double *m, const ff_places *places, double *sums)
{
    if (places->n_groups < GROUPS_FOR_VARIANCE) return 0;
    memset(sums, 0, places->n_groups * sizeof *sums);
    for (size_t i = 0; i < places->n; i++) sums[places->group[i]] += m[i];
    return variance_of_sum(sums, places->n_groups);
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* Each array [n]. */
typedef struct arrays {
    double *winner, *other, *ratio, *sums;    /* [samples]  */
    double *winner_held_out, *other_held_out; /* [n_groups] */
} arrays;

static void compare_validation(const arrays *a, size_t G, ff_versus *v)
{
    double *d = a->other_held_out; /* becomes the difference */
    for (size_t g = 0; g < G; g++) {
        d[g] -= a->winner_held_out[g];
        v->validation += d[g];
    }
    v->has_validation = 1;
    v->validation_error = sqrt(variance_of_sum(d, G));
}

static void compare_one(const struct ff_problem *p, const ff_places *places, const ff_fit_result *w, const ff_fit_result *o,
                        const arrays *a, ff_versus *v)
{
    const double N = (double)(p->n * p->n_channels), effective = w->correlation ? w->effective_samples : N, share = effective / N;
    const double extra = (double)o->n_free - (double)w->n_free;
    double sum = 0;
    log_ratios(p, a->winner, a->other, a->ratio);
    for (size_t i = 0; i < p->n; i++) sum += a->ratio[i];
    const size_t run_w = w->correlated_over ? w->correlated_over : 1, run_o = o->correlated_over ? o->correlated_over : 1;
    const double runs = variance_over_runs(a->ratio, p->n, run_w > run_o ? run_w : run_o, a->sums);
    const double groups = variance_over_groups(a->ratio, places, a->sums);
    v->objective = o->residual.objective - w->residual.objective;
    v->aic = 2 * share * sum + 2 * extra;
    v->bic = 2 * share * sum + extra * log(fmax(effective, 1));
    /* the penalty in units of the sum over samples that are not independent */
    const double ratio = sum + extra / share, scatter = sqrt(fmax(runs, groups));
    v->vuong_z = scatter > 1e-9 * fabs(sum) ? ratio / scatter : 0;
    v->vuong_p = ff_normal_two_sided(fabs(v->vuong_z));
    v->told_apart = fabs(v->vuong_z) > FF_NORMAL_975;
}

static ff_status compare_all(ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fits, size_t n,
                             size_t winner, size_t folds, const arrays *a, ff_versus *out, ff_error *err)
{
    ff_status st = ff_trust_evaluate(p, o, &fits[winner], NULL, NULL, a->winner, err);
    if (!st && folds) st = cross_validate(p, places, o, &fits[winner], folds, a->winner_held_out, err);
    for (size_t k = 0; k < n && !st; k++) {
        memset(&out[k], 0, sizeof out[k]);
        if (k == winner) continue;
        st = ff_trust_evaluate(p, o, &fits[k], NULL, NULL, a->other, err);
        if (st) break;
        compare_one(p, places, &fits[winner], &fits[k], a, &out[k]);
        if (!folds) continue;
        st = cross_validate(p, places, o, &fits[k], folds, a->other_held_out, err);
        if (st) break;
        compare_validation(a, places->n_groups, &out[k]);
        out[k].told_apart &= fabs(out[k].validation) > 2 * out[k].validation_error;
    }
    return st;
}

ff_status ff_trust_compare(ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fits, size_t n,
                           size_t winner, size_t folds, ff_versus *out, ff_error *err)
{
    const size_t G = places->n_groups;
    if (winner >= n || folds == 1 || folds > G)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "cross-validation by %s takes 2 to %zu folds, found %zu",
                            ff_grouping_name((int)places->kind), G, folds);
    const size_t samples = p->n > G ? p->n : G;
    double *memory = malloc((4 * samples + 2 * G) * sizeof *memory);
    ff_versus *versus = calloc(n, sizeof *versus);
    ff_status st = memory && versus ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!st) {
        const arrays a = {memory, memory + samples, memory + 2 * samples, memory + 3 * samples, memory + 4 * samples, memory + 4 * samples + G};
        st = compare_all(p, places, o, fits, n, winner, folds, &a, versus, err);
    }
    if (!st) memcpy(out, versus, n * sizeof *out);
    free(memory);
    free(versus);
    return st;
}
