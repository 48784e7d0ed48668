/* Errors by leaving out one incidence after another: whatever goes wrong at one of them, a gain, a drift, an alignment, goes wrong
 * in all of its samples, and moves the fit as often as it is there. With H and s the sums of J'J and J'r over the samples of an
 * incidence, the fit without it is a step (H_all - H)^-1 s away, to first order; the variance is (G - 1) / G times the sum of the
 * squares of these steps (CR3: Bell and McCaffrey 2002; MacKinnon, Nielsen and Webb 2023), with Student's t of G - 1. */
#include "base/internal_statistics.h"
#include "fit/result/internal_result.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST = 3, NAMED = 16 };

/* Sums over the samples of each incidence. */
typedef struct by_incidence {
    const ff_layout *l;
    const uint32_t *incidence; /* [n] */
    ff_gram *gram;             /* [G] */
} by_incidence;

static void add_block(void *context, const ff_visited *v)
{
    const by_incidence *b = context;
    const size_t m = b->l->n_shared + b->l->n_own;
    double row[FF_MAX_COLUMNS][FF_BLOCK], one[FF_MAX_COLUMNS];
    ff_noise_rows(b->l, v, row);
    for (size_t i = 0; i < v->n; i++) {
        for (size_t k = 0; k < m; k++) one[k] = row[k][i];
        ff_gram_add_row(&b->gram[b->incidence[v->first + i]], v->c, 1, v->j[i] * (v->f[i] - v->y[i]), one);
    }
}

/* Is the step of a parameter so far that nothing is left of its first order: where it is fitted in a logarithm a factor of e? */
static int is_lost(const ff_layout *l, size_t k, const ff_point *at, double step)
{
    const ff_model_param *p = ff_layout_param(l, k, NULL);
    const int bent = (p->info->flags & (FF_PARAM_LOG | FF_PARAM_ATANH)) != 0;
    return bent && k < l->n_shared && p >= l->m->shape && p < l->m->shape + l->m->n_shape &&
           fabs(step) > ff_coordinate_slope(p->info, at->shape[p - l->m->shape]);
}

/* The steps [G][P]; out [P]: 1 where a parameter is not determined without one of them. */
static ff_status find_steps(const ff_plan *plan, const ff_point *at, const by_incidence *b, size_t G, double *step, int *lost)
{
    const size_t P = plan->l.P;
    double *gradient = malloc((P + 1) * sizeof *gradient);
    ff_status status = gradient ? FF_OK : FF_ERR_MEMORY;
    for (size_t g = 0; g < G && !status; g++) {
        ff_information *without = NULL;
        status = ff_information_without(plan, at, &b->gram[g], &without);
        if (status) break;
        ff_gram_gradient(&b->gram[g], gradient);
        status = ff_information_solve(without, gradient, step + g * P);
        for (size_t k = 0; k < P && !status; k++)
            lost[k] |= at->information->determined[k] && (!without->determined[k] || is_lost(&plan->l, k, at, step[g * P + k]));
        free(without);
    }
    free(gradient);
    return status;
}

static void replace_errors(const ff_plan *plan, const ff_point *at, size_t G, const int *lost, ff_fit_result *fit)
{
    const ff_layout *l = &plan->l;
    const ff_information *info = at->information;
    const double t = ff_student_quantile(0.95, (double)(G - 1));
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, fit, k);
        if (isnan(v->std_error)) continue;
        v->std_error = lost[k] ? NAN : sqrt(info->variance[k]);
        v->low = v->high = NAN;
        v->interval = FF_INTERVAL_NONE;
        if (!lost[k]) ff_interval_around(ff_layout_param(l, k, NULL)->info, t * v->std_error, FF_INTERVAL_JACKKNIFE, v);
    }
    ff_result_correlations(plan, info, fit);
    ff_result_copy_tied(l, fit);
}

static ff_status say_lost(const ff_layout *l, const int *lost, ff_fit_result *fit)
{
    ff_warning_parameter named[NAMED];
    ff_warning w = {.code = FF_WARNING_ONE_INCIDENCE, .parameter = named};
    for (size_t k = 0; k < l->P && w.n_parameters < NAMED; k++)
        if (lost[k]) named[w.n_parameters++] = ff_layout_warned(l, k);
    return w.n_parameters ? ff_warnings_add(&fit->warnings, &w) : FF_OK;
}

/* With room: gram [G], step [G][P], lost [P]. */
static ff_status jackknife(ff_finished *f, const ff_places *places, const by_incidence *b, double *step, int *lost,
                           ff_fit_result *fit)
{
    const size_t G = places->n_directions;
    ff_status status = ff_errors(&f->plan, &f->at);
    if (!status) status = ff_point_visit(&f->plan, &f->at, add_block, (void *)(uintptr_t)b);
    if (!status) status = find_steps(&f->plan, &f->at, b, G, step, lost);
    if (!status) status = ff_information_from_influences(f->at.information, step, G, (double)(G - 1) / (double)G);
    if (status) return status;
    replace_errors(&f->plan, &f->at, G, lost, fit);
    return say_lost(&f->plan.l, lost, fit);
}

ff_status ff_trust_jackknife(const ff_problem *p, const ff_places *places, const ff_fit_options *o, ff_fit_result *fit,
                             ff_error *err)
{
    ff_fit_options own;
    ff_finished f;
    const size_t G = places->n_directions;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    if (G < FEWEST)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "%zu incident directions are too few to leave one out: at least %d", G,
                            (int)FEWEST);
    ff_status status = ff_finished_open_data(p, o, fit, "leaving out incidences", &f, err);
    if (status) return status;
    const size_t P = f.plan.l.P;
    by_incidence b = {&f.plan.l, places->direction, calloc(G, sizeof *b.gram)};
    double *step = malloc((G * P + 1) * sizeof *step);
    int *lost = calloc(P + 1, sizeof *lost);
    status = b.gram && step && lost ? FF_OK : FF_ERR_MEMORY;
    for (size_t g = 0; g < G && !status; g++) status = ff_gram_new(&f.plan.l, &b.gram[g]);
    if (!status) status = jackknife(&f, places, &b, step, lost, fit);
    if (status) (void)ff_trust_ended(status, "leaving out incidences", err);
    for (size_t g = 0; g < G && b.gram; g++) ff_gram_free(&b.gram[g]);
    free(b.gram);
    free(step);
    free(lost);
    ff_finished_close(&f);
    return status;
}
