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
    const ff_finished *fit;
    double objective;
    end *ends;
} profile;

/* Root of twice the rise in units, sign by the direction; the others go on from the point. */
static ff_status root_at(const profile *f, end *e, double x, ff_point *at, double *root)
{
    static const ff_effort effort = {.tolerance = PROFILE_TOLERANCE, .max_iterations = PROFILE_ITERATIONS};
    ff_plan plan = f->fit->plan;
    double *all = malloc((plan.l.P + 1) * sizeof *all);
    if (!all) return FF_ERR_MEMORY;
    plan.l.pinned = e->k;
    ff_layout_pack(&plan.l, at->shape, at->channel, all);
    all[e->k] = x;
    ff_layout_unpack(&plan.l, all, at->shape, at->channel);
    free(all);
    const ff_status status = ff_solve(&plan, &effort, at, NULL);
    if (status) return status;
    const double rise = 0.5 * at->cost2 - f->objective;
    e->lower = fmin(e->lower, f->objective > 0 ? rise / f->objective : 0);
    *root = sqrt(2 * fmax(rise, 0) / e->unit);
    return FF_OK;
}

/* Outwards until the root passes t, then between the last two points, by the secant that bisection keeps honest. */
static ff_status find_end(const profile *f, end *e, ff_point *at)
{
    const ff_layout *l = &f->fit->plan.l;
    double lo, hi;
    ff_layout_range(l, e->k, &lo, &hi);
    const double wall = ff_coordinate(ff_layout_param(l, e->k, NULL)->info, e->side < 0 ? lo : hi);
    double in = e->x0, in_root = 0, out = NAN, out_root = NAN, x = e->x0 + e->side * e->step;
    e->x = wall;
    for (int solve = 0; solve < MOST_SOLVES; solve++) {
        double root;
        x = e->side < 0 ? fmax(x, wall) : fmin(x, wall);
        const ff_status status = root_at(f, e, x, at, &root);
        if (status) return status;
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
    const ff_plan *plan = &f->fit->plan;
    end *e = &f->ends[item];
    ff_point at = {0};
    (void)worker;
    e->status = ff_plan_cancelled(plan) ? FF_ERR_CANCELLED : ff_point_new(plan, &at);
    if (!e->status) {
        ff_point_set(plan, f->fit->at.shape, f->fit->at.channel, &at);
        e->status = find_end(f, e, &at);
    }
    ff_point_free(&at);
}

/* As much as the interval allows that is there, where the objective were a parabola: of errors by incidences. */
static void take_width(const ff_param *info, const ff_fit_value *v, double inverse, end *e)
{
    const double half = 0.5 * (ff_coordinate(info, v->high) - ff_coordinate(info, v->low)),
                 sd = half * ff_coordinate_slope(info, v->value) / e->t;
    if (!(sd > 0)) return;
    e->unit = sd * sd / inverse;
    e->step = half;
}

/* Where to begin and what to look for: the steps of the Wald interval. */
static size_t lay_out_ends(const profile *f, const ff_information *u, const ff_fit_result *fit)
{
    const ff_layout *l = &f->fit->plan.l;
    const size_t P = l->P;
    const double values = (double)(f->fit->plan.p->n * f->fit->plan.p->n_channels),
                 variance = 2 * f->objective / fmax(values - (double)P, 1) * values / fmax(u->effective, 1);
    size_t n = 0;
    for (size_t k = 0; k < P; k++) {
        const ff_param *info = ff_layout_param(l, k, NULL)->info;
        const ff_fit_value *v = ff_result_value(l, (ff_fit_result *)fit, k);
        const double inverse = u->inverse[k], cov = u->variance[k], x = ff_coordinate(info, v->value);
        const int known = u->determined[k] && inverse > 0 && cov > 0;
        double lo, hi;
        ff_layout_range(l, k, &lo, &hi);
        const double range = ff_coordinate(info, hi) - ff_coordinate(info, lo);
        for (int side = -1; side <= 1; side += 2) {
            if (v->at_bound == side || v->held) continue;
            end *e = &f->ends[n++];
            *e = (end){.k = k, .side = side, .x0 = x, .unit = known ? cov / inverse : fmax(variance, 1e-300)};
            e->t = ff_student_quantile(v->at_bound ? 0.9 : 0.95, u->dof[k]);
            e->step = known ? e->t * sqrt(cov) / ff_coordinate_slope(info, v->value) : 0.05 * range;
            if (known && v->interval == FF_INTERVAL_JACKKNIFE) take_width(info, v, inverse, e);
            if (!(e->step < 0.5 * range)) e->step = 0.5 * range;
        }
    }
    return n;
}

/* ---- curves ---------------------------------------------------------------------------------- */

#define BESIDE 0.4 /* of the interval, to both sides of it */

typedef struct curve_work {
    const profile *f;
    const end *e; /* of the upper one: where the optimum is, and the unit */
    const double *x;
    double *root;
    ff_status *status;
} curve_work;

static void curve_point(void *context, size_t item, int worker)
{
    const curve_work *w = context;
    const ff_plan *plan = &w->f->fit->plan;
    ff_point at = {0};
    end e = *w->e;
    (void)worker;
    w->status[item] = ff_plan_cancelled(plan) ? FF_ERR_CANCELLED : ff_point_new(plan, &at);
    if (!w->status[item]) {
        ff_point_set(plan, w->f->fit->at.shape, w->f->fit->at.channel, &at);
        w->status[item] = root_at(w->f, &e, w->x[item], &at, &w->root[item]);
    }
    ff_point_free(&at);
}

size_t ff_trust_coordinate(const ff_layout *l, ff_param_ref ref, size_t channel)
{
    const ff_model_param *wanted = ff_model_param_at(l->m, ref);
    for (size_t k = 0; k < l->P; k++) {
        size_t c = 0;
        const ff_model_param *p = ff_layout_param(l, k, &c);
        if (p == wanted && (ref.kind == FF_PARAM_SHAPE || c == channel)) return k;
    }
    return l->P;
}

/* Between the ends of the interval and beside them, inside of the bounds; the optimum is one of the points. */
static void lay_out_curve(const profile *f, const end *low, const end *high, size_t n, double *x)
{
    const ff_layout *l = &f->fit->plan.l;
    const ff_param *info = ff_layout_param(l, high->k, NULL)->info;
    double lo, hi;
    ff_layout_range(l, high->k, &lo, &hi);
    const double beside = BESIDE * (high->x - low->x), from = fmax(low->x - beside, ff_coordinate(info, lo)),
                 to = fmin(high->x + beside, ff_coordinate(info, hi));
    for (size_t i = 0; i < n; i++) x[i] = from + (to - from) * (double)i / (double)(n - 1);
    size_t nearest = 0;
    for (size_t i = 1; i < n; i++)
        if (fabs(x[i] - high->x0) < fabs(x[nearest] - high->x0)) nearest = i;
    x[nearest] = high->x0;
}

static ff_status curve_of(const profile *f, end *low, end *high, size_t n, ff_curve *out)
{
    const ff_layout *l = &f->fit->plan.l;
    double *x = malloc((2 * n + 1) * sizeof *x), *root = x + n;
    ff_status *each = calloc(n + 1, sizeof *each);
    out->value = malloc((2 * n + 1) * sizeof *out->value);
    out->objective = out->value + n;
    ff_status status = x && each && out->value ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        lay_out_curve(f, low, high, n, x);
        curve_work work = {f, high, x, root, each};
        ff_pool_run(f->fit->plan.p->pool, n, curve_point, &work);
    }
    const ff_param *info = ff_layout_param(l, high->k, NULL)->info;
    for (size_t i = 0; i < n && !status; i++) {
        status = each[i];
        out->value[i] = ff_coordinate_value(info, x[i]);
        out->objective[i] = f->objective + 0.5 * high->unit * root[i] * root[i];
    }
    out->n = n;
    out->best = ff_coordinate_value(info, high->x0);
    out->limit = f->objective + 0.5 * high->unit * high->t * high->t;
    out->low = ff_coordinate_value(info, low->x);
    out->high = ff_coordinate_value(info, high->x);
    free(x);
    free(each);
    return status;
}

void ff_curve_clear(ff_curve *c)
{
    free(c->value);
    *c = (ff_curve){.n = 0};
}

/* The ends of coordinate k, both of them; one that is a bound itself stays there. */
static ff_status ends_of(const profile *f, size_t n, size_t k, end out[2])
{
    int found = 0;
    for (size_t i = 0; i < n; i++)
        if (f->ends[i].k == k) {
            const int high = f->ends[i].side > 0;
            profile_end((void *)f, i, 0);
            if (f->ends[i].status) return f->ends[i].status;
            out[high] = f->ends[i];
            if (!found) out[!high] = (end){.k = k, .x0 = out[high].x0, .x = out[high].x0, .t = out[high].t, .unit = out[high].unit};
            found = 1;
        }
    return found ? FF_OK : FF_ERR_UNSUPPORTED;
}

ff_status ff_trust_curve_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_param_ref ref,
                              size_t channel, size_t n, ff_curve *out, ff_error *err)
{
    ff_finished finished;
    ff_information *info = NULL;
    ff_curve made = {0};
    end pair[2];
    if (n < 3) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a curve needs 3 points at least, found %zu", n);
    ff_status status = ff_finished_open_data(p, o, fit, "the profile of the objective", &finished, err);
    if (status) return status;
    const size_t k = ff_trust_coordinate(&finished.plan.l, ref, channel);
    profile f = {&finished, fit->residual.objective, malloc((2 * finished.plan.l.P + 1) * sizeof *f.ends)};
    status = k == finished.plan.l.P ? FF_ERR_UNSUPPORTED : f.ends ? ff_point_pass(&finished.plan, &finished.at) : FF_ERR_MEMORY;
    if (!status) status = ff_errors_of_all(&finished.plan, &finished.at, &info);
    if (!status) status = ends_of(&f, lay_out_ends(&f, info, fit), k, pair);
    if (!status) status = curve_of(&f, &pair[0], &pair[1], n, &made);
    if (status == FF_ERR_UNSUPPORTED)
        ff_error_set(err, status, NULL, 0, -1, "a parameter that is not free by itself has no profile");
    else if (status)
        (void)ff_trust_ended(status, "the profile", err);
    free(info);
    free(f.ends);
    ff_finished_close(&finished);
    if (status)
        ff_curve_clear(&made);
    else
        *out = made;
    return status;
}

/* ---- intervals ------------------------------------------------------------------------------- */

static ff_status take_ends(const profile *f, size_t n, ff_fit_result *fit)
{
    const ff_layout *l = &f->fit->plan.l;
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

ff_status ff_trust_profile(const ff_problem *p, const ff_fit_options *o, ff_fit_result *fit, ff_error *err)
{
    ff_fit_options own;
    ff_finished finished;
    ff_information *info = NULL;
    o = ff_fit_options_take(o, &own, err);
    if (!o) return FF_ERR_RANGE;
    ff_status status = ff_finished_open_data(p, o, fit, "the profile of the objective", &finished, err);
    if (status) return status;
    profile f = {&finished, fit->residual.objective, malloc((2 * finished.plan.l.P + 1) * sizeof *f.ends)};
    status = f.ends ? ff_point_pass(&finished.plan, &finished.at) : FF_ERR_MEMORY;
    if (!status) status = ff_errors_of_all(&finished.plan, &finished.at, &info);
    size_t n = 0;
    if (!status) {
        n = lay_out_ends(&f, info, fit);
        ff_pool_run(p->pool, n, profile_end, &f);
        for (size_t i = 0; i < n && !status; i++) status = f.ends[i].status;
    }
    if (!status) status = take_ends(&f, n, fit);
    if (status) (void)ff_trust_ended(status, "the profile", err);
    free(info);
    free(f.ends);
    ff_finished_close(&finished);
    return status;
}
