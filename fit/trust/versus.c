/* Two models on the same samples: what each sample says for one or the other, and how sure the sum of it is.
 *
 * Vuong's test (1989) takes the log likelihoods of the samples; in the form of Rivers and Vuong (2002) it takes what each sample
 * adds to the objective that was minimised, whatever that is, and a variance that knows of dependent samples. With residuals in
 * standard deviations the two are the same, otherwise they are to first order in the difference. */
#include "base/internal_statistics.h"
#include "internal_versus.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { GROUPS_FOR_VARIANCE = 10, FOLD_ITERATIONS = 50 };
#define FOLD_TOLERANCE 1e-9 /* held-out samples are not at their minimum: to first order in the parameters */

/* ---- cross-validation ------------------------------------------------------------------------ */

typedef struct folds {
    const ff_finished *fit;
    const ff_places *places;
    const ff_resampled *resampled;
    size_t n;
    double *held_out; /* [n_directions] objective of a direction's samples, in the fit that has not seen them */
    ff_status *status;
} folds;

/* The objective of the groups of a fold, which the fit has not seen. */
static ff_status add_held_out(const folds *f, size_t fold, const ff_point *at)
{
    const ff_places *places = f->places;
    double *cost = malloc((places->n + 1) * sizeof *cost);
    ff_status status = cost ? ff_point_evaluate(&f->fit->plan, at, 0, NULL, NULL, cost) : FF_ERR_MEMORY;
    for (size_t i = 0; i < places->n && !status; i++)
        if (places->direction[i] % f->n == fold) f->held_out[places->direction[i]] += cost[i];
    free(cost);
    return status;
}

static void fit_fold(void *context, size_t fold, int worker)
{
    static const ff_effort effort = {.tolerance = FOLD_TOLERANCE, .max_iterations = FOLD_ITERATIONS};
    const folds *f = context;
    const struct ff_problem *p = &f->resampled->problem[worker];
    const ff_plan plan = ff_plan_on(&f->fit->plan, p);
    ff_point at = {0};
    ff_status status = ff_plan_cancelled(&plan) ? FF_ERR_CANCELLED : ff_point_new(&plan, &at);
    if (!status) {
        float *multiplier = f->resampled->multiplier + (size_t)worker * p->n_blocks * FF_BLOCK;
        for (size_t i = 0; i < p->n; i++) multiplier[i] = f->places->direction[i] % f->n != fold;
        ff_point_set(&plan, f->fit->at.shape, f->fit->at.channel, &at);
        status = ff_solve(&plan, &effort, &at, NULL);
    }
    if (!status) status = add_held_out(f, fold, &at);
    f->status[fold] = status;
    ff_point_free(&at);
}

/* held_out [n_directions] */
static ff_status cross_validate(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                                size_t n, double *held_out, ff_error *err)
{
    ff_finished finished;
    ff_resampled resampled = {0};
    ff_status status = ff_finished_open_data(p, o, fit, "cross-validation", &finished, err);
    if (status) return status;
    folds f = {&finished, places, &resampled, n, held_out, calloc(n, sizeof *f.status)};
    status = f.status ? ff_resampled_new(p, &resampled) : FF_ERR_MEMORY;
    memset(held_out, 0, places->n_directions * sizeof *held_out);
    if (!status) {
        ff_pool_run(p->pool, n, fit_fold, &f);
        for (size_t k = 0; k < n && !status; k++) status = f.status[k];
    }
    if (status) (void)ff_trust_ended(status, "the cross-validation", err);
    ff_resampled_free(&resampled);
    free(f.status);
    ff_finished_close(&finished);
    return status;
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
    v->told_apart = v->vuong_p < FF_VERSUS_LEVEL;
}

static ff_status compare_all(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fits,
                             size_t n, size_t winner, size_t folds, const arrays *a, ff_versus *out, ff_error *err)
{
    ff_status status = ff_trust_evaluate(p, o, &fits[winner], NULL, NULL, a->winner, err);
    if (!status && folds) status = cross_validate(p, places, o, &fits[winner], folds, a->winner_held_out, err);
    for (size_t k = 0; k < n && !status; k++) {
        memset(&out[k], 0, sizeof out[k]);
        if (k == winner) continue;
        status = ff_trust_evaluate(p, o, &fits[k], NULL, NULL, a->other, err);
        if (status) break;
        compare_one(p, places, &fits[winner], &fits[k], a, &out[k]);
        if (!folds) continue;
        status = cross_validate(p, places, o, &fits[k], folds, a->other_held_out, err);
        if (status) break;
        compare_validation(a, places->n_directions, &out[k]);
    }
    if (!status && ff_versus_has_noise(fits, n)) status = ff_versus_by_common_weights(p, places, o, fits, n, winner, out, err);
    return status;
}

ff_status ff_trust_compare_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fits,
                                size_t n, size_t winner, size_t folds, ff_versus *out, ff_error *err)
{
    const size_t D = places->n_directions;
    if (winner >= n || folds == 1 || folds > D)
        return ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "cross-validation by incident direction takes 2 to %zu parts, as many as there are directions, found %zu", D, folds);
    double *memory = malloc((4 * p->n + 2 * D) * sizeof *memory); /* no more groups than samples */
    ff_versus *versus = calloc(n, sizeof *versus);
    ff_status status = memory && versus ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    if (!status) {
        const arrays a = {memory, memory + p->n, memory + 2 * p->n, memory + 3 * p->n, memory + 4 * p->n, memory + 4 * p->n + D};
        status = compare_all(p, places, o, fits, n, winner, folds, &a, versus, err);
    }
    if (!status) memcpy(out, versus, n * sizeof *out);
    free(memory);
    free(versus);
    return status;
}
