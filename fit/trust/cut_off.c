/* The same fit to samples that stay further from grazing. */
#include "base/internal_statistics.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CUT_ITERATIONS = 50 };
#define CUT_TOLERANCE 1e-9
#define CUT_NEAR      1.5  /* errors: so little is not worth more than one step */
#define CUT_ROUNDING  1e-6 /* of a value: what data without errors may move by */

void ff_cut_off_clear(ff_cut_off *c)
{
    free(c->value);
    free(c->move);
    free(c->shift);
    memset(c, 0, sizeof *c);
}

/* Values [P] of one Gauss-Newton step from the point, of which info is; *inside: 0 where it leaves the box. */
static ff_status step_from(const ff_layout *l, const ff_normal *normal, const ff_information *info, double *value, int *inside)
{
    const size_t P = l->P;
    ff_gram g;
    double *slope = malloc((2 * P + 1) * sizeof *slope), *step = slope + P;
    ff_status status = slope ? ff_gram_new(l, &g) : FF_ERR_MEMORY;
    if (!status) {
        ff_gram_fill(l, normal, NULL, &g);
        ff_gram_gradient(&g, slope);
        ff_gram_free(&g);
        status = ff_information_solve(info, slope, step);
    }
    *inside = 1;
    for (size_t k = 0; k < P && !status; k++) {
        double lo, hi;
        ff_layout_range(l, k, &lo, &hi);
        value[k] -= step[k];
        *inside &= value[k] >= lo && value[k] <= hi;
    }
    free(slope);
    return status;
}

/* What a pass over the part at the point says: the point's values, or with `step` those of one step from it, against those of the
 * fit, in errors of the part. near: 1 where the step stays in the box and moves nothing by much, so that more steps would say the
 * same. */
static ff_status fill(const ff_plan *plan, ff_point *at, const ff_fit_result *fit, const double *difference, int step,
                      ff_cut_off *out, int *near)
{
    const ff_layout *l = &plan->l;
    const size_t P = l->P;
    ff_information *info = NULL;
    double *value = malloc((P + 1) * sizeof *value);
    ff_status status = value ? ff_point_pass(plan, at) : FF_ERR_MEMORY;
    if (!status) status = ff_information_new(plan, &at->normal, at->at_bound, &info);
    if (!status) status = ff_information_finish(info, plan, &at->normal, out->used, NULL);
    if (!status) ff_layout_pack(l, at->shape, at->channel, value);
    for (size_t k = 0; k < P && !status; k++) value[k] = ff_coordinate_value(ff_layout_param(l, k, NULL)->info, value[k]);
    if (!status && step) status = step_from(l, &at->normal, info, value, near);
    for (size_t k = 0; k < P && !status; k++) {
        const ff_fit_value *v = ff_result_value(l, (ff_fit_result *)(uintptr_t)fit, k);
        if (v->column < 0) continue;
        const double variance = difference ? difference[k] * difference[k] : info->variance[k];
        const double moved = fabs(value[k] - v->value) > CUT_ROUNDING * fabs(v->value) ? value[k] - v->value : 0;
        out->value[v->column] = value[k];
        out->move[v->column] = info->determined[k] && variance > 0 ? moved / sqrt(variance) : NAN;
        out->shift[v->column] = moved / v->std_error;
        if (step) *near &= fabs(out->move[v->column]) < CUT_NEAR;
    }
    free(info);
    free(value);
    return status;
}

/* One pass mostly says that nothing moves. Else, or where bounds have a part in it, the fit to the part is made. */
static ff_status compare_with_part(const ff_plan *part, ff_point *at, const ff_fit_result *fit, const double *difference,
                                   ff_cut_off *out, ff_error *err)
{
    static const ff_effort effort = {.parallel = 1, .tolerance = CUT_TOLERANCE, .max_iterations = CUT_ITERATIONS};
    int near = 0, bounds = 0;
    ff_status status = FF_OK;
    for (size_t k = 0; k < part->l.P; k++) bounds |= at->at_bound[k];
    if (!bounds) status = fill(part, at, fit, difference, 1, out, &near);
    if (status || near) return status;
    status = ff_solve(part, &effort, at, err);
    return status ? status : fill(part, at, fit, difference, 0, out, &near);
}

/* One of several that moves by its own scatter alone should be as rare as if there were one (Sidak 1967): of as many as are not the
 * same, n^2 / sum r^2 of their correlations. */
static double limit_of(const ff_fit_result *fit, double dof)
{
    const size_t n = fit->n_columns;
    double squares = 0;
    for (size_t k = 0; k < n * n; k++) squares += isnan(fit->correlation[k]) ? 0 : fit->correlation[k] * fit->correlation[k];
    const double number = squares > 0 ? fmax((double)(n * n) / squares, 1) : 1;
    return ff_student_quantile(pow(0.95, 1 / number), dof);
}

ff_status ff_trust_cut_off_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double max_theta,
                                ff_cut_off *out, ff_error *err)
{
    ff_finished f;
    struct ff_problem part = *p;
    ff_cut_off c = {.max_theta = max_theta, .n_columns = fit->n_columns};
    ff_status status = ff_finished_open_data(p, o, fit, "the check at a lower limit of the angles", &f, err);
    if (status) return status;
    float *multiplier = calloc(p->n_blocks * FF_BLOCK, sizeof *multiplier);
    double *difference = malloc((2 * f.plan.l.P + 1) * sizeof *difference), *dof = difference ? difference + f.plan.l.P : NULL,
           least = INFINITY;
    c.value = malloc((c.n_columns + 1) * sizeof *c.value);
    c.move = malloc((c.n_columns + 1) * sizeof *c.move);
    c.shift = malloc((c.n_columns + 1) * sizeof *c.shift);
    if (!multiplier || !difference || !c.value || !c.move || !c.shift) status = FF_ERR_MEMORY;
    const float lowest = (float)(cos(max_theta) * (1 - 1e-6));
    for (size_t i = 0; i < p->n && !status; i++) {
        const int inside = fminf(p->cosine[0][i], p->cosine[1][i]) >= lowest;
        multiplier[i] = (float)inside;
        c.used += (size_t)inside;
    }
    part.multiplier = multiplier;
    if (!status && c.used * p->n_channels < 2 * f.plan.l.P)
        status = ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "only %zu of the samples lie below %g degrees: too few for a fit",
                              c.used, max_theta * (180 / 3.14159265358979323846));
    const ff_plan on_part = ff_plan_on(&f.plan, &part);
    if (!status && f.at.noise) status = ff_noise_difference(&f.plan, &f.at, f.at.noise, multiplier, difference, dof);
    for (size_t k = 0; k < f.plan.l.P && f.at.noise && !status; k++) least = fmin(least, dof[k]);
    if (!status) c.limit = limit_of(fit, least);
    if (!status) status = compare_with_part(&on_part, &f.at, fit, f.at.noise ? difference : NULL, &c, err);
    if (status == FF_ERR_MEMORY) ff_error_set(err, status, NULL, 0, -1, "out of memory");
    free(multiplier);
    free(difference);
    ff_finished_close(&f);
    if (status) {
        ff_cut_off_clear(&c);
        return status;
    }
    *out = c;
    return FF_OK;
}
