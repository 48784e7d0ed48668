/* Two models on the same samples: what each sample says for one or the other, and how sure the sum of it is.
 *
 * Vuong's test (1989) takes the log likelihoods of the samples; in the form of Rivers and Vuong (2002) it takes what each sample
 * adds to the objective that was minimised, whatever that is, and a variance that knows of dependent samples. With residuals in
 * standard deviations the two are the same, otherwise they are to first order in the difference. */
#include "base/internal_statistics.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { GROUPS_FOR_VARIANCE = 10, FOLD_ITERATIONS = 50 };
#define FOLD_TOLERANCE 1e-9 /* held-out samples are not at their minimum: to first order in the parameters */

/* ---- cross-validation ------------------------------------------------------------------------ */

typedef struct folds {
    const struct ff_problem *p;
    const ff_point *point;
    const ff_places *places;
    const ff_fit_options *o;
    const ff_resampled *resampled;
    size_t n;
    double *held_out; /* [n_directions] objective of a direction's samples, in the fit that has not seen them */
    ff_status *status;
} folds;

/* The objective of the groups of a fold, which the fit has not seen. */
static ff_status add_held_out(const folds *f, size_t fold, const double *shape, const double *channel)
{
    const ff_places *places = f->places;
    double *cost = malloc((places->n + 1) * sizeof *cost);
    ff_status st = cost ? ff_point_cost(&f->point->l, f->p, f->o, shape, channel, cost) : FF_ERR_MEMORY;
    for (size_t i = 0; i < places->n && !st; i++)
        if (places->direction[i] % f->n == fold) f->held_out[places->direction[i]] += cost[i];
    free(cost);
    return st;
}

static void fit_fold(void *context, size_t fold, int worker)
{
    const folds *f = context;
    const ff_layout *l = &f->point->l;
    const size_t size = l->n_channels * l->m->n_channel;
    const struct ff_problem *p = &f->resampled->problem[worker];
    double shape[FF_MAX_SHAPE], *channel = malloc((size + 1) * sizeof *channel);
    int *at_bound = malloc((l->P + 1) * sizeof *at_bound);
    ff_solution solution;
    ff_status st = channel && at_bound ? ff_fit_cancelled(f->o) ? FF_ERR_CANCELLED : FF_OK : FF_ERR_MEMORY;
    if (!st) {
        float *multiplier = f->resampled->multiplier + (size_t)worker * p->n_blocks * FF_BLOCK;
        for (size_t i = 0; i < p->n; i++) multiplier[i] = f->places->direction[i] % f->n != fold;
        memcpy(shape, f->point->shape, sizeof shape);
        memcpy(channel, f->point->channel, size * sizeof *channel);
        st = ff_solve(l, p, f->o, 0, 0, FOLD_TOLERANCE, FOLD_ITERATIONS, shape, channel, at_bound, &solution, NULL);
    }
    if (!st) st = add_held_out(f, fold, shape, channel);
    f->status[fold] = st;
    free(channel);
    free(at_bound);
}

/* held_out [n_directions] */
static ff_status cross_validate(ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit, size_t n,
                                double *held_out, ff_error *err)
{
    ff_point point;
    ff_resampled resampled = {0};
    ff_status st = ff_point_new(p, o, fit, &point, err);
    if (st) return st;
    folds f = {p, &point, places, o, &resampled, n, held_out, calloc(n, sizeof *f.status)};
    st = f.status ? ff_resampled_new(p, &resampled) : FF_ERR_MEMORY;
    memset(held_out, 0, places->n_directions * sizeof *held_out);
    if (!st) {
        ff_pool_run(p->pool, n, fit_fold, &f);
        for (size_t k = 0; k < n && !st; k++) st = f.status[k];
    }
    if (st) (void)ff_trust_ended(st, "the cross-validation", err);
    ff_resampled_free(&resampled);
    free(f.status);
    ff_point_free(&point);
    return st;
}

/* ---- the test of the difference -------------------------------------------------------------- */

/* A variance, and the number of equal clusters that it is as good as. */
typedef struct spread {
    double variance, number;
} spread;

/* Of the sum of n terms from the sums of clusters. */
static spread spread_of_sum(const double *sums, size_t n)
{
    double mean = 0, all[2] = {0};
    for (size_t k = 0; k < n; k++) mean += sums[k] / (double)n;
    for (size_t k = 0; k < n; k++) {
        const double square = (sums[k] - mean) * (sums[k] - mean);
        all[0] += square;
        all[1] += square * square;
    }
    return (spread){n > 1 ? all[0] * (double)n / (double)(n - 1) : INFINITY, ff_clusters_count(all, all[1] / 3, (double)n)};
}

static spread spread_over_runs(const double *m, size_t n, size_t run, double *sums)
{
    const size_t clusters = (n + run - 1) / run;
    memset(sums, 0, clusters * sizeof *sums);
    for (size_t i = 0; i < n; i++) sums[i / run] += m[i];
    return spread_of_sum(sums, clusters);
}

static spread spread_over_groups(const double *m, const ff_places *places, double *sums)
{
    memset(sums, 0, places->n_groups * sizeof *sums);
    for (size_t i = 0; i < places->n; i++) sums[places->group[i]] += m[i];
    return spread_of_sum(sums, places->n_groups);
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* Each array [n]. */
typedef struct arrays {
    double *winner, *other, *difference, *sums; /* [samples]  */
    double *winner_held_out, *other_held_out;   /* [n_directions] */
} arrays;

static void compare_validation(const arrays *a, size_t n, ff_versus *v)
{
    double *d = a->other_held_out; /* becomes the difference */
    for (size_t k = 0; k < n; k++) {
        d[k] -= a->winner_held_out[k];
        v->validation += d[k];
    }
    v->has_validation = 1;
    v->validation_error = sqrt(spread_of_sum(d, n).variance);
    v->told_apart &= v->validation * v->vuong_z > 0 && fabs(v->validation) > v->validation_error;
}

static void compare_one(const struct ff_problem *p, const ff_places *places, const ff_fit_result *w, const ff_fit_result *o,
                        const arrays *a, ff_versus *v)
{
    const double N = (double)(p->n * p->n_channels), effective = w->correlation ? w->effective_samples : N, share = effective / N;
    const double extra = (double)o->n_free - (double)w->n_free, qw = w->residual.objective, qo = o->residual.objective;
    const int sigma = p->selection.weighting == FF_WEIGHT_SIGMA;
    const double variance = sigma ? 1 : 2 * qw / N, ratio = sigma ? 2 * (qo - qw) : N * log(qw > 0 ? qo / qw : 1);
    double sum = 0;
    for (size_t i = 0; i < p->n; i++) {
        a->difference[i] = a->other[i] - a->winner[i];
        sum += a->difference[i];
    }
    const size_t run_w = w->correlated_over ? w->correlated_over : 1, run_o = o->correlated_over ? o->correlated_over : 1;
    const size_t run = run_w > run_o ? run_w : run_o;
    const int groups = places->n_groups >= GROUPS_FOR_VARIANCE;
    const spread s[2] = {spread_over_runs(a->difference, p->n, run, a->sums),
                         groups ? spread_over_groups(a->difference, places, a->sums) : (spread){0}};
    v->objective = qo - qw;
    v->aic = share * ratio + 2 * extra;
    v->bic = share * ratio + extra * log(fmax(effective, 1));
    /* the penalty of AIC in units of the objective, of samples that are not independent */
    const double penalised = sum + extra * variance / share;
    v->vuong_p = 0;
    for (int k = 0; k <= groups; k++) { /* by the clusters that leave more doubt */
        const double scatter = sqrt(s[k].variance), z = scatter > 1e-9 * fabs(sum) ? penalised / scatter : 0,
                     doubt = ff_student_two_sided(fabs(z), s[k].number - 1);
        if (doubt < v->vuong_p) continue;
        v->vuong_z = z;
        v->vuong_p = doubt;
    }
    v->told_apart = v->vuong_p < 0.05;
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
        compare_validation(a, places->n_directions, &out[k]);
    }
    return st;
}

ff_status ff_trust_compare(ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fits, size_t n,
                           size_t winner, size_t folds, ff_versus *out, ff_error *err)
{
    const size_t D = places->n_directions;
    if (winner >= n || folds == 1 || folds > D)
        return ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "cross-validation by incident direction takes 2 to %zu parts, as many as there are directions, found %zu", D, folds);
    ff_status st = folds ? ff_point_data_alone(o, "cross-validation", err) : FF_OK;
    if (st) return st;
    double *memory = malloc((4 * p->n + 2 * D) * sizeof *memory); /* no more groups than samples */
    ff_versus *versus = calloc(n, sizeof *versus);
    st = memory && versus ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!st) {
        const arrays a = {memory, memory + p->n, memory + 2 * p->n, memory + 3 * p->n, memory + 4 * p->n, memory + 4 * p->n + D};
        st = compare_all(p, places, o, fits, n, winner, folds, &a, versus, err);
    }
    if (!st) memcpy(out, versus, n * sizeof *out);
    free(memory);
    free(versus);
    return st;
}
