/* The same fit to samples that stay further from grazing. */
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { CUT_ITERATIONS = 50 };
#define CUT_TOLERANCE 1e-9
#define CUT_ROUNDING  1e-6 /* of a value: what data without errors may move by */

void ff_cut_off_free(ff_cut_off *c)
{
    free(c->value);
    free(c->move);
    memset(c, 0, sizeof *c);
}

/* The fit to `used` samples of the part against that to all. */
static ff_status fill(const ff_point *at, const struct ff_problem *part, const ff_fit_options *o, const ff_fit_result *fit, size_t used,
                      ff_cut_off *out)
{
    const ff_layout *l = &at->l;
    const size_t P = l->P;
    ff_normal normal = {0};
    ff_uncertainty u = {0};
    int *use = malloc((P + 1) * sizeof *use);
    double *coordinates = malloc((P + 1) * sizeof *coordinates);
    ff_status st = use && coordinates ? ff_point_pass(at, part, o, &normal) : FF_ERR_MEMORY;
    for (size_t k = 0; k < P && !st; k++) use[k] = at->at_bound[k] == 0;
    if (!st) st = ff_uncertainty_new(l, part, &normal, use, used, &u);
    if (!st) ff_layout_pack(l, at->shape, at->channel, coordinates);
    for (size_t k = 0; k < P && !st; k++) {
        const ff_fit_value *v = ff_result_value(l, (ff_fit_result *)(uintptr_t)fit, k);
        if (v->column < 0) continue;
        const double value = ff_coordinate_value(ff_layout_param(l, k, NULL)->info, coordinates[k]), variance = u.cov[k * P + k];
        const double moved = fabs(value - v->value) > CUT_ROUNDING * fabs(v->value) ? value - v->value : 0;
        out->value[v->column] = value;
        out->move[v->column] = u.determined[k] && variance > 0 ? moved / sqrt(variance) : NAN;
    }
    ff_uncertainty_free(&u);
    ff_normal_free(&normal);
    free(use);
    free(coordinates);
    return st;
}

ff_status ff_trust_cut_off(ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double max_theta, ff_cut_off *out,
                           ff_error *err)
{
    ff_point point;
    struct ff_problem part = *p;
    ff_solution solution;
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
    if (!st)
        st = ff_solve(&point.l, &part, o, 1, 0, CUT_TOLERANCE, CUT_ITERATIONS, point.shape, point.channel, point.at_bound, &solution,
                      err);
    if (!st) st = fill(&point, &part, o, fit, c.used, &c);
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
