/* Refits to values drawn anew by the noise of the data; or with random weights of whole incident directions, so that errors that go
 * together inside one are resampled together. */
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
    int by_noise; /* 1: of redrawn, else of resampled */
    ff_resampled resampled;
    ff_redrawn redrawn;
    size_t repeats;
    uint64_t seed;
    double *weight; /* [threads][n_groups]    */
    double *x;      /* [repeats][P], of those that converged */
    unsigned char *converged;
    ff_status *status; /* [repeats] */
} bootstrap;

/* A random weight for every group, with mean 1: Rubin's (1981). */
static void draw_weights(const bootstrap *b, size_t repeat, double *weight)
{
    const size_t G = b->places->n_groups;
    double sum = 0;
    for (size_t g = 0; g < G; g++) sum += weight[g] = -log(ff_trust_uniform(b->seed, repeat, g));
    for (size_t g = 0; g < G; g++) weight[g] *= (double)G / sum;
}

/* To the samples of p, which have their values and weights. */
static void refit(const bootstrap *b, const struct ff_problem *p, size_t repeat, int parallel)
{
    const ff_effort effort = {.parallel = parallel, .tolerance = REFIT_TOLERANCE, .max_iterations = MOST_ITERATIONS};
    const ff_plan plan = ff_plan_on(&b->fit->plan, p);
    ff_point at = {0};
    ff_status status = ff_plan_cancelled(&plan) ? FF_ERR_CANCELLED : ff_point_new(&plan, &at);
    if (!status) {
        ff_point_set(&plan, b->fit->at.shape, b->fit->at.channel, &at);
        status = ff_solve(&plan, &effort, &at, NULL);
    }
    b->status[repeat] = status;
    b->converged[repeat] = !status && at.outcome == FF_CONVERGED;
    if (b->converged[repeat]) ff_layout_pack(&plan.l, at.shape, at.channel, b->x + repeat * plan.l.P);
    ff_point_free(&at);
}

static void reweighted(void *context, size_t repeat, int worker)
{
    const bootstrap *b = context;
    double *weight = b->weight + (size_t)worker * b->places->n_groups;
    draw_weights(b, repeat, weight);
    ff_resampled_weigh(&b->resampled, worker, b->places, weight);
    refit(b, &b->resampled.problem[worker], repeat, 0);
}

/* Every repeat that falls to a copy. */
static void redrawn(void *context, size_t copy, int worker)
{
    const bootstrap *b = context;
    (void)worker;
    for (size_t repeat = copy; repeat < b->repeats; repeat += b->redrawn.copies) {
        if (ff_plan_cancelled(&b->fit->plan)) {
            b->status[repeat] = FF_ERR_CANCELLED;
            return;
        }
        ff_redrawn_draw(&b->redrawn, copy, b->seed, repeat);
        refit(b, &b->redrawn.problem[copy], repeat, b->redrawn.copies == 1);
    }
}

static void refit_all(bootstrap *b, ff_pool *pool)
{
    if (!b->by_noise)
        ff_pool_run(pool, b->repeats, reweighted, b);
    else if (b->redrawn.copies > 1)
        ff_pool_run(pool, b->redrawn.copies, redrawn, b);
    else
        redrawn(b, 0, 0);
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

/* Of a parameter: what the standard deviation of the refits is to be multiplied by, and its degrees of freedom. */
typedef struct correction {
    double factor, dof;
} correction;

/* x [n][P]: the refits that converged. */
static ff_status take_errors(const ff_layout *l, const double *x, size_t n, const correction *by, ff_fit_result *fit)
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
        const double t = ff_student_quantile(0.95, by[a].dof),
                     error = by[a].factor * sqrt(covariance(x, n, P, a, a)) * ff_coordinate_slope(info, v->value);
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

static ff_status correct_for_groups(ff_finished *f, const ff_places *places, correction *by)
{
    const ff_plan *plan = &f->plan;
    const double G = (double)places->n_groups;
    double *number = malloc((plan->l.P + 1) * sizeof *number);
    ff_status status = number ? ff_errors(plan, &f->at) : FF_ERR_MEMORY;
    if (!status)
        status =
            ff_clusters_informative(plan->p, &f->at.normal, plan->p->n, places->group, places->n_groups, f->at.information, number);
    for (size_t k = 0; k < plan->l.P && !status; k++) {
        /* weights of G groups have the variance (G - 1) / (G + 1) instead of 1 */
        const double seen = ff_information_seen(f->at.information, number[k]);
        by[k] = (correction){sqrt((G + 1) / (G - 1) * (1 - 1 / G) / seen), number[k] - 1};
    }
    free(number);
    return status;
}

/* Values are drawn as if they were independent. What errors that go together make of it, and what the residuals say of the few
 * values that carry a parameter, comes from the errors of the fit: the refits stand for the straight line that these go along. */
static ff_status correct_for_noise(ff_finished *f, correction *by)
{
    const ff_status status = ff_errors(&f->plan, &f->at);
    for (size_t k = 0; k < f->plan.l.P && !status; k++) {
        const double alone = f->at.noise->carriers.error[k], whole = f->at.information->variance[k];
        by[k] = (correction){alone > 0 && whole > 0 ? sqrt(whole) / alone : 1, f->at.information->dof[k]};
    }
    return status;
}

/* places NULL: nothing is resampled by them. */
static ff_status check(const ff_places *places, size_t repeats, ff_error *err)
{
    if (repeats < FEWEST_REPEATS)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a bootstrap needs at least %d refits, found %zu", (int)FEWEST_REPEATS,
                            repeats);
    if (places && places->n_groups < FEWEST_GROUPS)
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

/* By the noise of the data, where the errors are and there is one; values that are known from one side only are not drawn. */
static int is_by_noise(const ff_finished *f, const ff_fit_options *o)
{
    return f->at.noise && o->errors == FF_ERRORS_NOISE && f->plan.p->side < 0;
}

/* With room for the refits: how many converged, at the front of b->x. */
static ff_status resample(bootstrap *b, ff_finished *f, size_t *converged, ff_error *err)
{
    const struct ff_problem *p = f->plan.p;
    const size_t P = f->plan.l.P;
    ff_status status = b->by_noise ? ff_redrawn_new(f, &b->redrawn) : ff_resampled_new(p, &b->resampled);
    if (!status) refit_all(b, p->pool);
    for (size_t i = 0; i < b->repeats && !status; i++)
        if (b->status[i] == FF_ERR_CANCELLED || b->status[i] == FF_ERR_MEMORY) status = b->status[i];
    if (status) return ff_trust_ended(status, "the bootstrap", err);
    const size_t n = pack(b, b->repeats, P);
    if (n < FEWEST_REPEATS)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "only %zu of %zu refits of the bootstrap converged", n, b->repeats);
    *converged = n;
    return FF_OK;
}

/* What is wanted of the refits, and where; NULL: the errors of the fit. */
typedef struct wanted {
    const ff_param_ref *ref;
    const size_t *channel;
    ff_refits *out;
} wanted;

/* Coordinate k of the refits about its mean, as far as the errors of the fit reach; inside its bounds. A parameter on a bound has
 * no such error, and stays. */
static void take_coordinate(const bootstrap *b, const ff_finished *f, size_t n, size_t k, double factor, double *value,
                            size_t stride)
{
    const size_t P = f->plan.l.P;
    const ff_param *info = ff_layout_param(&f->plan.l, k, NULL)->info;
    double mean = 0;
    for (size_t i = 0; i < n; i++) mean += b->x[i * P + k] / (double)n;
    for (size_t i = 0; i < n; i++) {
        const double x = ff_coordinate_value(info, mean + factor * (b->x[i * P + k] - mean));
        value[i * stride] = fmin(fmax(x, info->lo), info->hi);
    }
}

static ff_status take_refits(const bootstrap *b, const ff_finished *f, size_t n, const wanted *w, const correction *by,
                             ff_error *err)
{
    const ff_layout *l = &f->plan.l;
    const size_t n_wanted = w->out->n_wanted;
    double *value = malloc((n * n_wanted + 1) * sizeof *value);
    if (!value) return ff_trust_ended(FF_ERR_MEMORY, "the bootstrap", err);
    for (size_t a = 0; a < n_wanted; a++) {
        const size_t k = ff_trust_coordinate(l, w->ref[a], w->channel[a]);
        if (k == l->P) {
            free(value);
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a parameter that is not free by itself has no refits");
        }
        const double factor = f->at.at_bound[k] ? 1 : by[k].factor;
        w->out->widened = fmax(w->out->widened, factor);
        take_coordinate(b, f, n, k, factor, value + a, n_wanted);
    }
    w->out->n = n;
    w->out->value = value;
    return FF_OK;
}

/* Either into fit or into what is wanted of the refits. */
static ff_status take(const bootstrap *b, ff_finished *f, size_t n, ff_fit_result *fit, const wanted *w, ff_error *err)
{
    correction *by = malloc((f->plan.l.P + 1) * sizeof *by);
    ff_status status = !by ? FF_ERR_MEMORY : b->by_noise ? correct_for_noise(f, by) : correct_for_groups(f, b->places, by);
    if (!status && !w) status = take_errors(&f->plan.l, b->x, n, by, fit);
    if (status)
        status = ff_trust_ended(status, "the bootstrap", err);
    else if (w)
        status = take_refits(b, f, n, w, by, err);
    free(by);
    return status;
}

static ff_status run(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats, uint64_t seed,
                     const ff_fit_result *from, ff_fit_result *fit, const wanted *w, ff_bootstrap *out, ff_error *err)
{
    ff_finished f;
    size_t n = 0;
    ff_status status = ff_finished_open_data(p, o, from, "the bootstrap", &f, err);
    if (status) return status;
    bootstrap b = {.fit = &f, .places = places, .repeats = repeats, .seed = seed, .by_noise = is_by_noise(&f, o)};
    status = check(b.by_noise ? NULL : places, repeats, err);
    if (status) {
        ff_finished_close(&f);
        return status;
    }
    b.weight = malloc((size_t)ff_pool_threads(p->pool) * places->n_groups * sizeof *b.weight);
    b.x = malloc((repeats * f.plan.l.P + 1) * sizeof *b.x);
    b.converged = calloc(repeats, 1);
    b.status = calloc(repeats, sizeof *b.status);
    if (!(b.weight && b.x && b.converged && b.status))
        status = ff_trust_ended(FF_ERR_MEMORY, "the bootstrap", err);
    else
        status = resample(&b, &f, &n, err);
    if (!status) status = take(&b, &f, n, fit, w, err);
    const size_t failed = repeats - n;
    if (!status)
        *out = b.by_noise ? (ff_bootstrap){sizeof *out, repeats, failed, p->n * p->n_channels, FF_GROUP_VALUES}
                          : (ff_bootstrap){sizeof *out, repeats, failed, places->n_groups, places->kind};
    ff_resampled_free(&b.resampled);
    ff_redrawn_free(&b.redrawn);
    free(b.weight);
    free(b.x);
    free(b.converged);
    free(b.status);
    ff_finished_close(&f);
    return status;
}

ff_status ff_trust_bootstrap_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats,
                                  uint64_t seed, ff_fit_result *fit, ff_bootstrap *out, ff_error *err)
{
    ff_fit_options own;
    o = ff_fit_options_take(o, &own, err);
    return o ? run(p, places, o, repeats, seed, fit, fit, NULL, out, err) : FF_ERR_RANGE;
}

ff_status ff_trust_refits_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats, uint64_t seed,
                               const ff_fit_result *fit, size_t n_wanted, const ff_param_ref *ref, const size_t *channel,
                               ff_refits *out, ff_error *err)
{
    ff_refits made = {.n_wanted = n_wanted};
    const wanted w = {ref, channel, &made};
    const ff_status status = run(p, places, o, repeats, seed, fit, NULL, &w, &made.made, err);
    if (!status) *out = made;
    return status;
}

void ff_refits_clear(ff_refits *r)
{
    free(r->value);
    *r = (ff_refits){.n = 0};
}
