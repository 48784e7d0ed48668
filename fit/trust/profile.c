/* Intervals by the profile of the objective: one parameter is held, all others follow. */
#include "base/internal_statistics.h"
#include "internal_trust.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_SOLVES = 12, PROFILE_ITERATIONS = 60 };
#define PROFILE_TOLERANCE 1e-9
#define PROFILE_CLOSE     0.01 /* of the interval's half width: where the search for its end may stop */

/* One end of one interval. */
typedef struct end {
    size_t k;
    int side;
    double x0, step; /* coordinate of the optimum; first step, > 0                          */
    double unit;     /* rise of the objective that counts as 1: t^2 allowed is at root = t   */
    double t;
    double x;     /* where it ends                                                       */
    double lower; /* least objective seen, relative to the optimum's; < 0: it was not one */
    ff_status status;
} end;

typedef struct profile {
    const ff_point *point;
    const struct ff_problem *p;
    const ff_fit_options *o;
    double objective;
    end *ends;
} profile;

/* Root of twice the rise in units, sign by the direction; the others go on from shape, channel. */
static ff_status root_at(const profile *f, end *e, double x, double *shape, double *channel, double *root)
{
    ff_layout l = f->point->l;
    ff_solution solution;
    double *all = malloc((l.P + 1) * sizeof *all);
    int *at_bound = malloc((l.P + 1) * sizeof *at_bound);
    ff_status st = all && at_bound ? FF_OK : FF_ERR_MEMORY;
    if (!st) {
        l.pinned = e->k;
        ff_layout_pack(&l, shape, channel, all);
        all[e->k] = x;
        ff_layout_unpack(&l, all, shape, channel);
        st = ff_solve(&l, f->p, f->o, 0, 0, PROFILE_TOLERANCE, PROFILE_ITERATIONS, shape, channel, at_bound, &solution, NULL);
    }
    if (!st) {
        const double rise = 0.5 * solution.cost2 - f->objective;
        e->lower = fmin(e->lower, f->objective > 0 ? rise / f->objective : 0);
        *root = sqrt(2 * fmax(rise, 0) / e->unit);
    }
    free(all);
    free(at_bound);
    return st;
}

/* Outwards until the root passes t, then between the last two points, by the secant that bisection keeps honest. */
static ff_status find_end(const profile *f, end *e, double *shape, double *channel)
{
    const ff_model_param *param = ff_layout_param(&f->point->l, e->k, NULL);
    const double wall = ff_coordinate(param->info, e->side < 0 ? param->lo : param->hi);
    double in = e->x0, in_root = 0, out = NAN, out_root = NAN, x = e->x0 + e->side * e->step;
    e->x = wall;
    for (int solve = 0; solve < MOST_SOLVES; solve++) {
        double root;
        x = e->side < 0 ? fmax(x, wall) : fmin(x, wall);
        const ff_status st = root_at(f, e, x, shape, channel, &root);
        if (st) return st;
        e->x = x;
        if (fabs(root - e->t) <= PROFILE_CLOSE * e->t || (x == wall && root < e->t)) return FF_OK;
        if (root < e->t)
            in = x, in_root = root;
        else
            out = x, out_root = root;
        if (isnan(out)) {
            const double reach = root > 0.1 * e->t ? fmin(1.1 * e->t / root, 4) : 4;
            x = e->x0 + (x - e->x0) * reach;
        } else {
            const double s = (e->t - in_root) / (out_root - in_root);
            x = in + fmin(fmax(s, 0.1), 0.9) * (out - in);
        }
    }
    e->x = isnan(out) ? wall : x;
    return FF_OK;
}

static void profile_end(void *context, size_t item, int worker)
{
    const profile *f = context;
    const ff_layout *l = &f->point->l;
    end *e = &f->ends[item];
    const size_t size = l->n_channels * l->m->n_channel;
    double shape[FF_MAX_SHAPE], *channel = malloc((size + 1) * sizeof *channel);
    (void)worker;
    e->status = channel ? ff_fit_cancelled(f->o) ? FF_ERR_CANCELLED : FF_OK : FF_ERR_MEMORY;
    if (!e->status) {
        memcpy(shape, f->point->shape, sizeof shape);
        memcpy(channel, f->point->channel, size * sizeof *channel);
        e->status = find_end(f, e, shape, channel);
    }
    free(channel);
}

/* Where to begin and what to look for: the steps of the Wald interval. */
static size_t plan(const profile *f, const ff_uncertainty *u, ff_fit_result *fit)
{
    const ff_layout *l = &f->point->l;
    const size_t P = l->P;
    const double values = (double)(f->p->n * f->p->n_channels),
                 variance = 2 * f->objective / fmax(values - (double)P, 1) * values / fmax(u->effective, 1);
    size_t n = 0;
    for (size_t k = 0; k < P; k++) {
        const ff_model_param *param = ff_layout_param(l, k, NULL);
        const ff_param *info = param->info;
        const ff_fit_value *v = ff_result_value(l, fit, k);
        const double inverse = u->inverse[k * P + k], cov = u->cov[k * P + k], x = ff_coordinate(info, v->value);
        const int known = u->determined[k] && inverse > 0 && cov > 0;
        const double range = ff_coordinate(info, param->hi) - ff_coordinate(info, param->lo);
        for (int side = -1; side <= 1; side += 2) {
            if (v->at_bound == side) continue;
            end *e = &f->ends[n++];
            *e = (end){.k = k, .side = side, .x0 = x, .unit = known ? cov / inverse : fmax(variance, 1e-300)};
            e->t = ff_student_quantile(v->at_bound ? 0.9 : 0.95, u->dof[k]);
            e->step = known ? e->t * sqrt(cov) / ff_coordinate_slope(info, v->value) : 0.05 * range;
            if (!(e->step < 0.5 * range)) e->step = 0.5 * range;
        }
    }
    return n;
}

static ff_status take_ends(const profile *f, size_t n, ff_fit_result *fit)
{
    const ff_layout *l = &f->point->l;
    double lower = 0;
    for (size_t i = 0; i < n; i++) {
        const end *e = &f->ends[i];
        ff_fit_value *v = ff_result_value(l, fit, e->k);
        const double value = ff_coordinate_value(ff_layout_param(l, e->k, NULL)->info, e->x);
        if (v->interval != FF_INTERVAL_PROFILE) v->low = v->high = v->value;
        v->interval = FF_INTERVAL_PROFILE;
        *(e->side < 0 ? &v->low : &v->high) = value;
        lower = fmin(lower, e->lower);
    }
    ff_result_copy_tied(l, fit);
    const double share = -lower;
    return share > 1e-6 ? ff_warnings_say(&fit->warnings, FF_WARNING_LOWER_OBJECTIVE, &share) : FF_OK;
}

ff_status ff_trust_profile(ff_problem *p, const ff_fit_options *o, ff_fit_result *fit, ff_error *err)
{
    ff_point point;
    ff_normal normal = {0};
    ff_uncertainty u = {0};
    ff_status st = ff_point_data_alone(o, "the profile of the objective", err);
    if (!st) st = ff_point_new(p, o, fit, &point, err);
    if (st) return st;
    const size_t P = point.l.P;
    int *use = malloc((P + 1) * sizeof *use);
    profile f = {&point, p, o, fit->residual.objective, malloc((2 * P + 1) * sizeof *f.ends)};
    st = use && f.ends ? ff_point_pass(&point, p, o, &normal) : FF_ERR_MEMORY;
    for (size_t k = 0; k < P && !st; k++) use[k] = 1;
    if (!st) st = ff_uncertainty_new(&point.l, p, &normal, use, p->n, &u);
    size_t n = 0;
    if (!st) {
        n = plan(&f, &u, fit);
        ff_pool_run(p->pool, n, profile_end, &f);
        for (size_t i = 0; i < n && !st; i++) st = f.ends[i].status;
    }
    if (!st) st = take_ends(&f, n, fit);
    if (st) (void)ff_trust_ended(st, "the profile", err);
    ff_uncertainty_free(&u);
    ff_normal_free(&normal);
    free(use);
    free(f.ends);
    ff_point_free(&point);
    return st;
}
