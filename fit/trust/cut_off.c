/* The same fit to samples that stay further from grazing. */
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CUT_ITERATIONS = 50 };
#define CUT_TOLERANCE 1e-9
#define CUT_NEAR      1.5  /* errors: so little is not worth more than one step */
#define CUT_ROUNDING  1e-6 /* of a value: what data without errors may move by */

void ff_cut_off_free(ff_cut_off *c)
{
    free(c->value);
    free(c->move);
    memset(c, 0, sizeof *c);
}

/* Values [P] of one Gauss-Newton step from the point, of which normal and u are; 0 where it leaves the box. */
static int step_from(const ff_point *at, const ff_normal *normal, const ff_uncertainty *u, double *H, double *g, double *value)
{
    const ff_layout *l = &at->l;
    const size_t P = l->P;
    int inside = 1;
    ff_normal_assemble(l, normal, NULL, H, g);
    for (size_t k = 0; k < P; k++) {
        double lo, hi;
        ff_layout_range(l, k, &lo, &hi);
        for (size_t j = 0; j < P; j++) value[k] -= u->inverse[k * P + j] * g[j];
        inside &= value[k] >= lo && value[k] <= hi;
    }
    return inside;
}

/* What a pass over the part at the point says: the point's values, or with `step` those of one step from it, against those of the
 * fit, in errors of the part. near: 1 where the step stays in the box and moves nothing by much, so that more steps would say the
 * same. */
static ff_status fill(const ff_point *at, const struct ff_problem *part, const ff_fit_options *o, const ff_fit_result *fit,
                      size_t used, int step, ff_cut_off *out, int *near)
{
    const ff_layout *l = &at->l;
    const size_t P = l->P;
    ff_normal normal = {0};
    ff_uncertainty u = {0};
    int *use = malloc((P + 1) * sizeof *use);
    double *value = malloc((P * P + 2 * P + 1) * sizeof *value);
    ff_status st = use && value ? ff_point_pass(at, part, o, &normal) : FF_ERR_MEMORY;
    for (size_t k = 0; k < P && !st; k++) use[k] = at->at_bound[k] == 0;
    if (!st) st = ff_uncertainty_new(l, part, &normal, use, used, &u);
    if (!st) ff_layout_pack(l, at->shape, at->channel, value);
    for (size_t k = 0; k < P && !st; k++) value[k] = ff_coordinate_value(ff_layout_param(l, k, NULL)->info, value[k]);
    if (!st && step) *near = step_from(at, &normal, &u, value + P, value + P + P * P, value);
    for (size_t k = 0; k < P && !st; k++) {
        const ff_fit_value *v = ff_result_value(l, (ff_fit_result *)(uintptr_t)fit, k);
        if (v->column < 0) continue;
        const double variance = u.cov[k * P + k];
        const double moved = fabs(value[k] - v->value) > CUT_ROUNDING * fabs(v->value) ? value[k] - v->value : 0;
        out->value[v->column] = value[k];
        out->move[v->column] = u.determined[k] && variance > 0 ? moved / sqrt(variance) : NAN;
        if (step) *near &= fabs(out->move[v->column]) < CUT_NEAR;
    }
    ff_uncertainty_free(&u);
    ff_normal_free(&normal);
    free(use);
    free(value);
    return st;
}

/* One pass mostly says that nothing moves. Else, or where bounds have a part in it, the fit to the part is made. */
static ff_status compare_with_part(ff_point *at, const struct ff_problem *part, const ff_fit_options *o, const ff_fit_result *fit,
                                   ff_cut_off *out, ff_error *err)
{
    ff_solution solution;
    int near = 0, bounds = 0;
    ff_status st = FF_OK;
    for (size_t k = 0; k < at->l.P; k++) bounds |= at->at_bound[k];
    if (!bounds) st = fill(at, part, o, fit, out->used, 1, out, &near);
    if (st || near) return st;
    st = ff_solve(&at->l, part, o, 1, 0, CUT_TOLERANCE, CUT_ITERATIONS, at->shape, at->channel, at->at_bound, &solution, err);
    return st ? st : fill(at, part, o, fit, out->used, 0, out, &near);
}

ff_status ff_trust_cut_off(ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double max_theta, ff_cut_off *out,
                           ff_error *err)
{
    ff_point point;
    struct ff_problem part = *p;
    ff_cut_off c = {.max_theta = max_theta, .n_columns = fit->n_columns};
    ff_status st = ff_point_data_alone(o, "the check at a lower limit of the angles", err);
    if (!st) st = ff_point_new(p, o, fit, &point, err);
    if (st) return st;
    float *multiplier = calloc(p->n_blocks * FF_BLOCK, sizeof *multiplier);
    c.value = malloc((c.n_columns + 1) * sizeof *c.value);
    c.move = malloc((c.n_columns + 1) * sizeof *c.move);
    if (!multiplier || !c.value || !c.move) st = FF_ERR_MEMORY;
    const float least = (float)(cos(max_theta) * (1 - 1e-6));
    for (size_t i = 0; i < p->n && !st; i++) {
        multiplier[i] = p->lowest[i] >= least;
        c.used += p->lowest[i] >= least;
    }
    part.multiplier = multiplier;
    if (!st && c.used * p->n_channels < 2 * point.l.P)
        st = ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "only %zu of the samples lie below %g degrees: too few for a fit", c.used,
                          max_theta * (180 / 3.14159265358979323846));
    if (!st) st = compare_with_part(&point, &part, o, fit, &c, err);
    if (st == FF_ERR_MEMORY) ff_error_set(err, st, NULL, 0, -1, "out of memory");
    free(multiplier);
    ff_point_free(&point);
    if (st) {
        ff_cut_off_free(&c);
        return st;
    }
    *out = c;
    return FF_OK;
}
