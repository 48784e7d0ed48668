/* Models compared by the same weights: every model is fitted again to residuals in standard deviations of the data, which are those
 * of the model that explains them best, so that what a sample adds to the sum means the same for all. The test is of the sums over
 * whole incidences: what goes wrong at one of them, a gain or a drift, goes wrong in all of its samples, and no smaller cluster is
 * independent of the next. It is one-sided, since a model is left out for being worse alone, with Student's t of one less than the
 * number of incidences. A model that is another one with a parameter held is asked by Wald's test of that parameter, because the
 * larger one is never worse. */
#include "base/internal_statistics.h"
#include "internal_versus.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST_INCIDENCES = 3, ENOUGH_SIGNS = 5, STEPS = 50 };
#define HOPELESS  2.0 /* times the sum of squares in standard deviations */
#define TOLERANCE 1e-7

/* All models on the samples that noise is estimated on. */
typedef struct field {
    const struct ff_problem *p, *search;
    const ff_places *places;
    const ff_fit_options *o;
    const ff_fit_result *fits; /* [n] */
    size_t n, best;
    double *square;           /* [n][search->n]: squares of a sample's residuals in standard deviations */
    double *total;            /* [n] */
    float *deviation, *other; /* [n_channels][n_blocks FF_BLOCK] */
    double *sums;             /* [n][n_directions]: differences to the best, of incidences that have samples */
    double *value;            /* [n_channels][search->n] */
    int *used;                /* [n_directions] */
    ff_error *err;
} field;

static size_t size_of(const struct ff_problem *p)
{
    return p->n_channels * p->n_blocks * FF_BLOCK;
}

/* ---- the noise that all are weighed by -------------------------------------------------------- */

/* -2 ln of the likelihood of a fit by its own noise, less a constant; the deviations into f->other. */
static ff_status likelihood(const field *f, const ff_finished *finished, double *out)
{
    const struct ff_problem *p = f->search;
    const ff_noise_found *noise = finished->at.noise;
    ff_plan on = ff_plan_on(&finished->plan, p);
    ff_point where = {.channel = noise->channel};
    memcpy(where.shape, noise->shape, sizeof where.shape);
    on.penalties = NULL;
    ff_status status = ff_noise_deviations(&finished->plan, p, &where, noise->noise, f->other);
    if (!status) status = ff_point_evaluate(&on, &where, 1, f->value, NULL, NULL);
    *out = 0;
    for (size_t c = 0; c < p->n_channels && !status; c++)
        for (size_t i = 0; i < p->n; i++) {
            const double sd = (double)f->other[c * p->n_blocks * FF_BLOCK + i],
                         y = ff_problem_plane(p, i / FF_BLOCK, p->value + (int)c)[i % FF_BLOCK], e = y - f->value[c * p->n + i];
            if (sd > 0) *out += 2 * log(sd) + e * e / (sd * sd);
        }
    return status;
}

/* The fit whose own noise makes the data most likely; its deviations into f->deviation. */
static ff_status choose_weights(const field *f, size_t *which)
{
    double least = INFINITY, now;
    ff_status status = FF_OK;
    for (size_t k = 0; k < f->n && !status; k++) {
        ff_finished finished;
        status = ff_finished_open(f->p, f->o, &f->fits[k], &finished, f->err);
        if (status) break;
        status = likelihood(f, &finished, &now);
        if (!status && now < least) {
            least = now;
            *which = k;
            memcpy(f->deviation, f->other, size_of(f->search) * sizeof *f->deviation);
        }
        ff_finished_close(&finished);
    }
    return status;
}

/* ---- fits by these weights -------------------------------------------------------------------- */

/* A fit by the common weights. */
typedef struct refit {
    ff_finished finished;
    ff_standardised standardised;
    ff_plan plan;
    ff_point at;
} refit;

static void refit_close(refit *r)
{
    ff_point_free(&r->at);
    ff_standardised_free(&r->standardised);
    ff_finished_close(&r->finished);
}

static ff_status refit_open(const field *f, size_t k, refit *r)
{
    static const ff_effort effort = {.parallel = 1, .tolerance = TOLERANCE, .max_iterations = STEPS};
    const struct ff_problem *p = f->search;
    *r = (refit){.at = {.outcome = FF_CONVERGED}};
    ff_status status = ff_finished_open(f->p, f->o, &f->fits[k], &r->finished, f->err);
    if (status) return status;
    status = ff_standardised_new(p, &r->standardised);
    for (size_t i = 0; i < p->n && !status; i++) {
        const double root = ff_problem_plane(p, i / FF_BLOCK, p->sample_weight)[i % FF_BLOCK];
        for (size_t c = 0; c < p->n_channels; c++) {
            const size_t at = c * p->n_blocks * FF_BLOCK + i;
            const double unit = (double)f->deviation[at] * root;
            r->standardised.factor[at] = unit > 0 ? (float)(1 / unit) : 0;
        }
    }
    r->plan = ff_plan_on(&r->finished.plan, &r->standardised.problem);
    r->plan.penalties = NULL;
    r->plan.progress = NULL;
    r->plan.errors = 0;
    if (!status) status = ff_point_new(&r->plan, &r->at);
    if (!status) {
        ff_point_set(&r->plan, r->finished.at.noise->shape, r->finished.at.noise->channel, &r->at);
        status = ff_solve(&r->plan, &effort, &r->at, f->err);
    }
    if (status) refit_close(r);
    return status;
}

static ff_status fill_squares(const field *f, size_t k)
{
    refit r;
    double *cost = f->square + k * f->search->n;
    ff_status status = refit_open(f, k, &r);
    if (status == FF_ERR_INTERNAL) { /* no number came out: it explains nothing */
        f->total[k] = INFINITY;
        return FF_OK;
    }
    if (status) return status;
    status = ff_point_evaluate(&r.plan, &r.at, 1, NULL, NULL, cost);
    f->total[k] = 0;
    for (size_t i = 0; i < f->search->n && !status; i++) {
        cost[i] *= 2;
        f->total[k] += cost[i];
    }
    refit_close(&r);
    return status;
}

/* ---- the test --------------------------------------------------------------------------------- */

/* Sums of the differences to the best over incidences; how many of them have samples. */
static size_t sum_incidences(const field *f, size_t k)
{
    const double *a = f->square + k * f->search->n, *b = f->square + f->best * f->search->n;
    double *sums = f->sums + k * f->places->n_directions;
    size_t n = 0;
    memset(sums, 0, f->places->n_directions * sizeof *sums);
    memset(f->used, 0, f->places->n_directions * sizeof *f->used);
    for (size_t i = 0; i < f->search->n; i++) {
        const uint32_t d = f->places->direction[f->search == f->p ? i : f->search->index[i]];
        sums[d] += a[i] - b[i];
        f->used[d] = 1;
    }
    for (size_t d = 0; d < f->places->n_directions; d++)
        if (f->used[d]) sums[n++] = sums[d];
    return n;
}

static void test(const field *f, size_t k, ff_versus *v)
{
    v->vuong_z = NAN;
    v->vuong_p = NAN;
    const size_t n = sum_incidences(f, k);
    v->incidences = n;
    if (n < FEWEST_INCIDENCES) return;
    if (!isfinite(f->total[k])) {
        v->vuong_z = INFINITY;
        v->vuong_p = 0;
        return;
    }
    double *sums = f->sums + k * f->places->n_directions, sum = 0, squares = 0;
    for (size_t g = 0; g < n; g++) sum += sums[g];
    for (size_t g = 0; g < n; g++) squares += pow(sums[g] - sum / (double)n, 2);
    const double scatter = sqrt(squares * (double)n / (double)(n - 1));
    v->vuong_z = scatter > 1e-9 * fabs(sum) ? sum / scatter : sum > 0 ? INFINITY : 0;
    const double two = isinf(v->vuong_z) ? 0 : ff_student_two_sided(fabs(v->vuong_z), (double)(n - 1));
    v->vuong_p = v->vuong_z > 0 ? 0.5 * two : 1 - 0.5 * two;
}

/* ---- models in models ------------------------------------------------------------------------- */

/* The parameter of `large` that makes it `small` where it has the value, FF_PARAM_NONE where there is none: all else is the same.
 */
static ff_param_ref parameter_apart(const ff_model *large, const ff_model *small, double *value)
{
    const ff_param_ref none = {FF_PARAM_NONE, 0};
    ff_param_ref found = none;
    if (large->n_lobes != small->n_lobes || large->n_bases != small->n_bases) return none;
    for (uint32_t b = 0; b < large->n_bases; b++)
        if (large->base[b].diffuse != small->base[b].diffuse) return none;
    for (uint32_t l = 0; l < large->n_lobes; l++) {
        const ff_lobe *x = &large->lobe[l], *y = &small->lobe[l];
        if (x->masking != y->masking || x->fresnel != y->fresnel) return none;
        if (x->ndf == y->ndf) continue;
        const ff_contains *c = &ff_term_at(FF_NDF, (size_t)x->ndf)->contains;
        if (found.kind != FF_PARAM_NONE || !c->name || strcmp(c->name, ff_term_at(FF_NDF, (size_t)y->ndf)->name) != 0) return none;
        for (uint32_t k = x->shape0; k < x->shape0 + x->n_shape; k++)
            if (!strcmp(large->shape[k].info->name, c->parameter)) found = (ff_param_ref){FF_PARAM_SHAPE, k};
        *value = c->value;
    }
    return found;
}

/* Wald's test at the fit of the best by the common weights, whose residuals are in standard deviations: the covariance is H^-1, of
 * samples that go together along scans larger by as much as these add up to. */
static ff_status test_parameter(const field *f, ff_param_ref which, double value, ff_versus *v)
{
    refit r;
    ff_information *info = NULL;
    ff_status status = refit_open(f, f->best, &r);
    if (status) return status;
    const ff_layout *l = &r.plan.l;
    size_t k = 0;
    while (k < l->n_shared && ff_layout_param(l, k, NULL) != &l->m->shape[which.index]) k++;
    const int is_free = k < l->n_shared;
    if (is_free) status = ff_point_pass(&r.plan, &r.at);
    if (is_free && !status) status = ff_information_new(&r.plan, &r.at.normal, NULL, &info);
    if (!status && info && info->determined[k]) {
        const ff_noise *noise = r.finished.at.noise->noise;
        double together = 1;
        for (int lag = 1; lag <= FF_NOISE_LAGS; lag++) together += 2 * noise->along_scan[lag];
        /* in the coordinate that it is fitted in, in which its error does not grow with it */
        const ff_param *param = l->m->shape[which.index].info;
        const double now = r.at.shape[which.index], slope = ff_coordinate_slope(param, now),
                     error = sqrt(info->inverse[k] * fmax(together, 1)) / slope;
        v->vuong_z = fabs(ff_coordinate(param, now) - ff_coordinate(param, value)) / error; /* worse on either side */
        v->vuong_p = ff_normal_two_sided(v->vuong_z);
        v->by_parameter = 1;
    }
    free(info);
    refit_close(&r);
    return status;
}

static int leads(const field *f, size_t k, const ff_versus *out)
{
    return k != f->best && !(out[k].vuong_p < FF_VERSUS_LEVEL) && isfinite(f->total[k]);
}

/* Correlation of the differences of two models to the best, over incidences. */
static double correlation(const field *f, size_t a, size_t b, size_t n)
{
    const double *x = f->sums + a * f->places->n_directions, *y = f->sums + b * f->places->n_directions;
    double mx = 0, my = 0, xy = 0, xx = 0, yy = 0;
    for (size_t g = 0; g < n; g++) mx += x[g] / (double)n, my += y[g] / (double)n;
    for (size_t g = 0; g < n; g++) {
        xy += (x[g] - mx) * (y[g] - my);
        xx += (x[g] - mx) * (x[g] - mx);
        yy += (y[g] - my) * (y[g] - my);
    }
    return xx > 0 && yy > 0 ? xy / sqrt(xx * yy) : 1;
}

/* The best is the luckiest of those that lead, and each of these may be the true one. Those that go wrong at the same incidences
 * count as one: n^2 / sum r^2 of n. */
static double independent_leaders(const field *f, const ff_versus *out)
{
    double n = 0, squares = 0;
    for (size_t a = 0; a < f->n; a++)
        for (size_t b = 0; b < f->n && leads(f, a, out); b++)
            if (leads(f, b, out)) squares += pow(correlation(f, a, b, out[a].incidences), 2);
    for (size_t a = 0; a < f->n; a++) n += leads(f, a, out);
    return n > 0 ? fmax(n * n / fmax(squares, 1e-300), 1) : 1;
}

/* Student's t of a few sums over incidences knows their scatter badly, and where a model fails at some incidences more than at
 * others it sees nothing but that. One that is worse at every incidence, of which the probability is 2^-n where neither is better,
 * and that leaves twice as much, is worse. */
static int is_hopeless(const field *f, size_t k, const ff_versus *v)
{
    const double *sums = f->sums + k * f->places->n_directions;
    int everywhere = v->incidences >= ENOUGH_SIGNS && f->total[k] >= HOPELESS * f->total[f->best];
    for (size_t g = 0; g < v->incidences && everywhere; g++) everywhere = sums[g] > 0;
    return everywhere;
}

static ff_status test_all(const field *f, ff_versus *out)
{
    for (size_t k = 0; k < f->n; k++) {
        double value = 0;
        if (k == f->best) {
            out[k].incidences = sum_incidences(f, k);
            continue;
        }
        test(f, k, &out[k]);
        const ff_param_ref apart = parameter_apart(&f->fits[f->best].model, &f->fits[k].model, &value);
        const int possible = apart.kind != FF_PARAM_NONE && out[k].incidences >= FEWEST_INCIDENCES;
        const ff_status status = possible ? test_parameter(f, apart, value, &out[k]) : FF_OK;
        if (status) return status;
    }
    const double level = 1 - pow(1 - FF_VERSUS_LEVEL, 1 / independent_leaders(f, out));
    for (size_t k = 0; k < f->n; k++) out[k].told_apart = k != f->best && (out[k].vuong_p < level || is_hopeless(f, k, &out[k]));
    return FF_OK;
}

/* ---- the whole -------------------------------------------------------------------------------- */

/* Differences of the criteria to the winner: of residuals in standard deviations they are those of the likelihood, for as many
 * values as are independent. */
static void fill_criteria(const field *f, size_t winner, size_t k, ff_versus *v)
{
    const ff_fit_result *w = &f->fits[winner], *fit = &f->fits[k];
    const double extra = (double)fit->n_free - (double)w->n_free, N = (double)(f->search->n * f->search->n_channels),
                 effective = w->correlation ? w->effective_samples : (double)(f->p->n * f->p->n_channels),
                 ratio = effective / N * (f->total[k] - f->total[winner]);
    v->aic = ratio + 2 * extra;
    v->bic = ratio + extra * log(fmax(effective, 1));
}

static ff_status compare(field *f, size_t winner, ff_versus *out)
{
    size_t which = 0;
    ff_status status = choose_weights(f, &which);
    for (size_t k = 0; k < f->n && !status; k++) {
        status = fill_squares(f, k);
        if (!status && f->total[k] < f->total[f->best]) f->best = k;
    }
    for (size_t k = 0; k < f->n && !status; k++) {
        out[k].weighted = 1;
        out[k].standardised = f->total[k] - f->total[f->best];
        fill_criteria(f, winner, k, &out[k]);
    }
    return status ? status : test_all(f, out);
}

int ff_versus_has_noise(const ff_fit_result *fits, size_t n)
{
    for (size_t k = 0; k < n; k++)
        if (!fits[k].noise) return 0;
    return n > 0;
}

ff_status ff_trust_likeliest_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fits, size_t n, size_t *out,
                                  ff_error *err)
{
    const struct ff_problem *search = p->sparse;
    field f = {.p = p, .search = search, .o = o, .fits = fits, .n = n, .err = err};
    *out = 0;
    if (!ff_versus_has_noise(fits, n)) return FF_OK;
    f.deviation = malloc(2 * size_of(search) * sizeof *f.deviation);
    f.value = malloc((search->n_channels * search->n + 1) * sizeof *f.value);
    ff_status status = f.deviation && f.value ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        f.other = f.deviation + size_of(search);
        status = choose_weights(&f, out);
    }
    if (status) (void)ff_trust_ended(status, "the comparison of noises", err);
    free(f.deviation);
    free(f.value);
    return status;
}

ff_status ff_versus_by_common_weights(const ff_problem *p, const ff_places *places, const ff_fit_options *o,
                                      const ff_fit_result *fits, size_t n, size_t winner, ff_versus *out, ff_error *err)
{
    const struct ff_problem *search = p->sparse;
    const size_t values = search->n_channels * search->n, D = places->n_directions;
    field f = {.p = p, .search = search, .places = places, .o = o, .fits = fits, .n = n, .err = err};
    double *memory = malloc((n * search->n + n + n * D + values + 1) * sizeof *memory);
    f.deviation = malloc(2 * size_of(search) * sizeof *f.deviation);
    f.used = malloc((D + 1) * sizeof *f.used);
    ff_status status = memory && f.deviation && f.used ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        f.other = f.deviation + size_of(search);
        f.square = memory;
        f.total = f.square + n * search->n;
        f.sums = f.total + n;
        f.value = f.sums + n * D;
        status = compare(&f, winner, out);
    }
    if (status) (void)ff_trust_ended(status, "the comparison by common weights", err);
    free(f.used);
    free(f.deviation);
    free(memory);
    return status;
}
