/* Errors by leaving out one incidence after another: whatever goes wrong at one of them, a gain, a drift, an alignment, goes wrong
 * in all of its samples, and moves the fit as often as it is there. The fit is made again without each of them; the variance is
 * (G - 1) / G times the sum of the squares of its moves (CR3: Bell and McCaffrey 2002; MacKinnon, Nielsen and Webb 2023), with
 * Student's t of G - 1. A step of Gauss and Newton in the place of a fit would do where the model is the surface; where it is not,
 * the residuals bend the objective, and the step is short by a quarter and more. */
#include "base/internal_statistics.h"
#include "fit/result/internal_result.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FEWEST = 3, NAMED = 16, MOST_ITERATIONS = 50 };
#define TOLERANCE 1e-8

/* The moves [G][P] of all parameters, and those that are not determined without one of the incidences: lost [P]. */
typedef struct moves {
    const ff_finished *fit;
    const uint32_t *incidence; /* [n] */
    float *multiplier;         /* [n_blocks FF_BLOCK] 0 at the incidence that is left out */
    double *x, *there;         /* [P] coordinates of the fit, and of the one without */
    double *move;
    int *lost;
} moves;

/* What the fit without incidence g says of the parameters: how far they have moved, in the units of the parameter, to first order
 * of its coordinate; whether something is known of them. One that is fitted in a logarithm and moves by a factor of e is lost. */
static ff_status take_moves(const moves *m, const ff_plan *plan, const ff_point *at, size_t g)
{
    const ff_layout *l = &plan->l;
    ff_information *without = NULL;
    const ff_status status = ff_information_new(plan, &at->normal, at->at_bound, &without);
    ff_layout_pack(l, at->shape, at->channel, m->there);
    for (size_t k = 0; k < l->P && !status; k++) {
        const ff_param *info = ff_layout_param(l, k, NULL)->info;
        const double by = m->there[k] - m->x[k];
        const int bent = (info->flags & (FF_PARAM_LOG | FF_PARAM_ATANH)) != 0,
                  unknown = !without->determined[k] && !at->at_bound[k];
        m->move[g * l->P + k] = by * ff_coordinate_slope(info, ff_coordinate_value(info, m->x[k]));
        m->lost[k] |= m->fit->at.information->determined[k] && (unknown || (bent && k < l->n_shared && fabs(by) > 1));
    }
    free(without);
    return status;
}

static ff_status leave_out(const moves *m, size_t g)
{
    static const ff_effort effort = {.parallel = 1, .tolerance = TOLERANCE, .max_iterations = MOST_ITERATIONS};
    const struct ff_problem *p = m->fit->plan.p;
    struct ff_problem within = *p;
    ff_plan plan = ff_plan_on(&m->fit->plan, &within);
    ff_point at;
    ff_status status = ff_point_new(&plan, &at);
    if (status) return status;
    for (size_t i = 0; i < p->n; i++) m->multiplier[i] = m->incidence[i] != g;
    within.multiplier = m->multiplier;
    plan.errors = 0;
    plan.progress = NULL;
    ff_point_set(&plan, m->fit->at.shape, m->fit->at.channel, &at);
    status = ff_solve(&plan, &effort, &at, NULL);
    if (!status) status = ff_point_pass(&plan, &at);
    if (!status) status = take_moves(m, &plan, &at, g);
    ff_point_free(&at);
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

/* With room. */
static ff_status jackknife(ff_finished *f, const moves *m, size_t G, ff_fit_result *fit)
{
    const ff_layout *l = &f->plan.l;
    ff_status status = ff_errors(&f->plan, &f->at);
    ff_layout_pack(l, f->at.shape, f->at.channel, m->x);
    for (size_t g = 0; g < G && !status; g++) status = leave_out(m, g);
    if (!status) status = ff_information_from_influences(f->at.information, m->move, G, (double)(G - 1) / (double)G);
    if (status) return status;
    replace_errors(&f->plan, &f->at, G, m->lost, fit);
    return say_lost(l, m->lost, fit);
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
    double *memory = malloc(((G + 2) * P + 1) * sizeof *memory);
    float *multiplier = calloc(p->n_blocks * FF_BLOCK, sizeof *multiplier);
    int *lost = calloc(P + 1, sizeof *lost);
    status = memory && multiplier && lost ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        const moves m = {&f, places->direction, multiplier, memory, memory + P, memory + 2 * P, lost};
        status = jackknife(&f, &m, G, fit);
    }
    if (status) (void)ff_trust_ended(status, "leaving out incidences", err);
    free(memory);
    free(multiplier);
    free(lost);
    ff_finished_close(&f);
    return status;
}
