/* Many channels: eliminating their parameters leads to the optimum of the dense path, with its standard errors and correlations,
 * and what is reported says so in a bounded number of words. */
#include "fit_samples.h"
#include "fit/errors/internal_errors.h"
#include "fit/minimise/internal_minimise.h"

/* One set of data and how it is fitted. */
typedef struct experiment {
    const char *what, *model, *set; /* set: shape parameters; those of the channels follow from the channel */
    size_t n_channels;
    ff_loss loss;
    ff_robust robust;
    double robust_scale;
    fit_sampling how;
    double outliers;    /* added to every 50th value                                                       */
    int beyond;         /* 1: every third channel asks for f0 > 1, every other third for kd < 0            */
    const char *hold;   /* a shape parameter that is held                                                  */
    const char *fit;    /* the model that is fitted, where it is another one                               */
    int misfit;         /* 1: residuals of neighbours must go together                                     */
    ff_shape shape;     /* CORRELATED unless given                                                         */
    double start_off;   /* relative distance of a start given by the caller, 0 = searched for              */
    int start_at_truth; /* the start is the parameters of the data                                         */
    const char *start;  /* assignments to that start, to all channels alike                                */
    int max_iterations; /* 0 = the default                                                                 */
} experiment;

/* Parameters of channel c of C: smooth in c, different for each. */
static double channel_value(const char *name, double t)
{
    if (strstr(name, "f0")) return 0.15 + 0.7 / (1 + exp(-8 * (t - 0.5)));
    if (strstr(name, "eta")) return 1.4 + 0.3 * t;
    if (!strcmp(name, "k") || strstr(name, ".k") == name + strlen(name) - 2) return 2 + 1.5 * t;
    if (strstr(name, "ks")) return 0.6 + 0.3 * t;
    return 0.2 - 0.15 * t; /* kd and the like */
}

static fit_surface surface_of(const experiment *e)
{
    fit_surface s = fit_surface_make(e->model, e->n_channels, e->set);
    for (size_t c = 0; c < e->n_channels; c++)
        for (uint32_t k = 0; k < s.model.n_channel; k++) {
            const ff_model_param *p = &s.model.channel[k];
            const double t = (double)c / (double)(e->n_channels > 1 ? e->n_channels - 1 : 1);
            if (p->flags & FF_PARAM_HELD) continue;
            s.channel[c * s.model.n_channel + k] = fmin(fmax(channel_value(p->name, t), p->info->lo), p->info->hi);
        }
    return s;
}

static ff_table data_of(const experiment *e, const fit_surface *s)
{
    ff_table t = fit_measure(s, &e->how);
    for (size_t k = 0; k < t.n * t.n_channels && e->outliers > 0; k += 50) t.value[k] += e->outliers;
    for (size_t c = 0; c < t.n_channels && e->beyond; c++)
        for (size_t i = 0; i < t.n; i++) {
            double *v = &t.value[c * t.n + i];
            if (c % 3 == 0) *v = 1.6 * (*v - 0.02);
            if (c % 3 == 1) *v -= 0.15;
        }
    return t;
}

static ff_fit_options options_of(const experiment *e, size_t dense_channels)
{
    ff_fit_options o = fit_options();
    o.errors = FF_ERRORS_RESIDUALS; /* noise_test compares the two paths where errors rest on the noise */
    o.loss = e->loss;
    o.robust = e->robust;
    o.robust_scale = e->robust_scale > 0 ? e->robust_scale : 1;
    o.shape = e->shape ? e->shape : FF_SHAPE_CORRELATED;
    o.dense_channels = dense_channels;
    if (e->max_iterations) o.max_iterations = e->max_iterations;
    return o;
}

/* The correlation of two parameters of a channel, or of one and a column of the shape, as either path gives it. */
static double correlation_with_shape(const ff_fit_result *r, size_t c, uint32_t k, const ff_fit_value *shape)
{
    const ff_fit_value *v = &r->channel_value[c * r->model.n_channel + k];
    if (shape->column < 0) return NAN;
    if (r->channel_correlation)
        return r->channel_correlation[(c * r->model.n_channel + k) * (r->n_columns + r->model.n_channel) + (size_t)shape->column];
    return v->column < 0 ? NAN : r->correlation[(size_t)v->column * r->n_columns + (size_t)shape->column];
}

static double correlation_within(const ff_fit_result *r, size_t c, uint32_t a, uint32_t b)
{
    const size_t N = r->model.n_channel;
    const ff_fit_value *x = &r->channel_value[c * N + a], *y = &r->channel_value[c * N + b];
    if (r->channel_correlation) return r->channel_correlation[(c * N + a) * (r->n_columns + N) + r->n_columns + b];
    return x->column < 0 || y->column < 0 ? NAN : r->correlation[(size_t)x->column * r->n_columns + (size_t)y->column];
}

static void check_close_or_nan(const char *what, double a, double b, double tolerance)
{
    FF_CHECK((isnan(a) && isnan(b)) || fabs(a - b) <= tolerance, "%s: %.12g and %.12g", what, a, b);
}

static void check_correlations(const char *what, const ff_fit_result *a, const ff_fit_result *d)
{
    const ff_model *m = &a->model;
    for (uint32_t i = 0; i < m->n_shape; i++)
        for (uint32_t j = 0; j < m->n_shape; j++) {
            const ff_fit_value *x = &a->shape_value[i], *y = &a->shape_value[j], *u = &d->shape_value[i], *v = &d->shape_value[j];
            FF_CHECK((x->column < 0) == (u->column < 0), "%s: column of %s", what, m->shape[i].name);
            if (x->column < 0 || y->column < 0 || u->column < 0 || v->column < 0) continue;
            check_close_or_nan(what, a->correlation[(size_t)x->column * a->n_columns + (size_t)y->column],
                               d->correlation[(size_t)u->column * d->n_columns + (size_t)v->column], 1e-4);
        }
    for (size_t c = 0; c < a->n_channels; c++)
        for (uint32_t k = 0; k < m->n_channel; k++) {
            for (uint32_t i = 0; i < m->n_shape; i++)
                check_close_or_nan(what, correlation_with_shape(a, c, k, &a->shape_value[i]),
                                   correlation_with_shape(d, c, k, &d->shape_value[i]), 1e-4);
            for (uint32_t i = 0; i < m->n_channel; i++)
                check_close_or_nan(what, correlation_within(a, c, k, i), correlation_within(d, c, k, i), 1e-4);
        }
}

/* The result of the arrowhead against that of the dense path. */
static void check_same(const char *what, ff_robust robust, const ff_fit_result *a, const ff_fit_result *d)
{
    double worst = 0, worst_error = 0;
    int bounds = 0;
    FF_CHECK(a->outcome == d->outcome, "%s: %s, dense %s", what, ff_outcome_name((int)a->outcome),
             ff_outcome_name((int)d->outcome));
    const int slow = robust == FF_ROBUST_TUKEY || robust == FF_ROBUST_CAUCHY;
    FF_CHECK_CLOSE(a->residual.objective, d->residual.objective, slow ? 1e-8 : 1e-9, 1e-25);
    FF_CHECK_CLOSE(a->residual.rmse, d->residual.rmse, 1e-5, 1e-12);
    FF_CHECK_CLOSE(a->residual.log_rmse, d->residual.log_rmse, 1e-5, 1e-12);
    FF_CHECK_CLOSE(a->residual.max_abs, d->residual.max_abs, 1e-4, 1e-9);
    FF_CHECK_CLOSE(a->aic, d->aic, 1e-9, 1e-3);
    FF_CHECK(a->n_free == d->n_free, "%s: %zu free, dense %zu", what, a->n_free, d->n_free);
    for (size_t k = 0; k < fit_parameter_count(a); k++) {
        char name[64];
        double truth;
        const ff_fit_value *x = fit_parameter(a, k, NULL, &truth, name), *y = fit_parameter(d, k, NULL, &truth, name);
        FF_CHECK(!x == !y, "%s: %s", what, name);
        if (!x || !y) continue;
        FF_CHECK(x->at_bound == y->at_bound, "%s: %s at bound %d, dense %d", what, name, x->at_bound, y->at_bound);
        FF_CHECK(isnan(x->std_error) == isnan(y->std_error), "%s: std error of %s is %g, dense %g", what, name, x->std_error,
                 y->std_error);
        bounds += x->at_bound != 0;
        FF_CHECK(x->interval == y->interval, "%s: %s has interval %d, dense %d", what, name, (int)x->interval, (int)y->interval);
        const double wide = fmax(y->high - y->low, 1e-9);
        if (y->interval)
            FF_CHECK(fabs(x->low - y->low) < 1e-3 * wide && fabs(x->high - y->high) < 1e-3 * wide,
                     "%s: %s in %g .. %g, dense %g .. %g", what, name, x->low, x->high, y->low, y->high);
        if (x->at_bound)
            FF_CHECK(x->value == y->value, "%s: %s is %.17g on its bound, dense %.17g", what, name, x->value, y->value);
        if (isnan(x->std_error) || isnan(y->std_error)) continue;
        /* Either solver stops when a Gauss-Newton step would gain too small a part of the objective. With the losses whose
         * influence falls again the steps shrink by a constant factor only, and what is left is a multiple of the last one; where
         * the model misses by more than the sigmas say, the objective is large against the errors. A stricter stop brings both
         * below 1e-4. */
        const double most_off = d->correlated_over > 1 ? 5e-3 : slow ? 3e-3 : 1e-3;
        const double off = fabs(x->value - y->value) / fmax(y->std_error, 1e-9), error = fabs(x->std_error / y->std_error - 1);
        worst = fmax(worst, off);
        if (y->std_error > 1e-9) worst_error = fmax(worst_error, error);
        FF_CHECK(off < most_off, "%s: %s is %.12g, dense %.12g +- %.2g", what, name, x->value, y->value, y->std_error);
        FF_CHECK(error < 1e-4 || y->std_error <= 1e-9, "%s: std error of %s is %.10g, dense %.10g", what, name, x->std_error,
                 y->std_error);
    }
    if (!a->correlation || !d->correlation) return;
    check_correlations(what, a, d);
    FF_CHECK(a->rank == d->rank && a->correlated_over == d->correlated_over && a->correlation_settled == d->correlation_settled,
             "%s: rank %zu, over %zu, dense %zu, %zu", what, a->rank, a->correlated_over, d->rank, d->correlated_over);
    FF_CHECK_CLOSE(a->condition, d->condition, 1e-3, 0);
    FF_CHECK_CLOSE(a->effective_samples, d->effective_samples, 1e-3, 0);
    FF_CHECK(a->has_ellipse == d->has_ellipse && a->ellipse.phi_determined == d->ellipse.phi_determined, "%s: ellipse", what);
    check_close_or_nan(what, a->ellipse.phi_std_error, d->ellipse.phi_std_error, 1e-4);
    printf(
        "%-44s %2d on bounds, off by %.0e errors, errors by %.0e; %2d and %2d iterations, %2d and %2d passes, %4.0f and %4.0f ms\n",
        what, bounds, worst, worst_error, a->iterations, d->iterations, a->passes, d->passes, 1e3 * a->time_s, 1e3 * d->time_s);
}

static void compare(const experiment *e)
{
    fit_surface s = surface_of(e);
    ff_table t = data_of(e, &s);
    ff_fit_result r[2];
    ff_error err = {0};
    ff_status status = FF_OK;
    size_t made = 0;
    if (e->fit) s = fit_surface_make(e->fit, e->n_channels, "");
    const ff_param_ref held = e->hold ? ff_model_param_find(&s.model, e->hold) : (ff_param_ref){FF_PARAM_NONE, 0};
    if (held.kind == FF_PARAM_SHAPE) {
        s.model.shape[held.index].flags |= FF_PARAM_HELD;
        s.model.shape[held.index].init = s.shape[held.index];
    }
    double shape[FF_MAX_SHAPE], channel[FIT_CHANNELS * FF_MAX_CHANNEL_PARAMS];
    ff_model_defaults(&s.model, e->n_channels, NULL, channel);
    if (e->start_at_truth) memcpy(channel, s.channel, e->n_channels * s.model.n_channel * sizeof *channel);
    for (uint32_t k = 0; k < s.model.n_shape; k++)
        shape[k] = fmin(s.shape[k] * (1 + e->start_off * (k % 2 ? -0.5 : 1)), s.model.shape[k].info->hi);
    char words[128], *save = NULL;
    snprintf(words, sizeof words, "%s", e->start ? e->start : "");
    for (char *word = strtok_r(words, " ", &save); word && !status; word = strtok_r(NULL, " ", &save))
        status = ff_model_set(&s.model, e->n_channels, word, shape, channel, &err);
    for (; made < 2 && !status; made += !status) {
        ff_fit_options o = options_of(e, made == 0 ? 0 : 1000);
        if (e->start_off > 0 || e->start || e->start_at_truth) {
            o.start_shape = shape;
            o.start_channel = channel;
        }
        status = fit_table(&t, &s.model, &o, &r[made], NULL, &err);
        FF_CHECK(status == FF_OK, "%s: %s", e->what, err.message);
    }
    if (!status) {
        FF_CHECK(r[0].channel_correlation != NULL && r[1].channel_correlation == NULL, "%s: which path was taken", e->what);
        check_same(e->what, e->robust, &r[0], &r[1]);
        FF_CHECK(!e->misfit || r[0].correlated_over > 1, "%s: residuals go together over %zu samples", e->what,
                 r[0].correlated_over);
    }
    while (made > 0) ff_fit_result_clear(&r[--made]);
    ff_table_clear(&t);
}

static const char *const ellipse = "alpha_x=0.25 alpha_y=0.4 r_xy=0.3";

static experiment experiment_make(const char *what, const char *model, const char *set, size_t n_channels)
{
    experiment e = {.what = what, .model = model, .set = set, .n_channels = n_channels};
    e.how = (fit_sampling){.n = 3000, .max_theta = 80, .glossy = 0.2, .noise = 0.03, .seed = 11};
    return e;
}

/* ---- the same optimum and the same errors ---------------------------------------------------- */

static void any_number_of_channels(void)
{
    const size_t counts[] = {1, 3, 8, 16};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        char what[64];
        snprintf(what, sizeof what, "%zu channels", counts[i]);
        experiment e = experiment_make(what, "ggx+lambert", ellipse, counts[i]);
        compare(&e);
        snprintf(what, sizeof what, "%zu channels, from afar", counts[i]);
        e.start_off = 0.8;
        compare(&e);
    }
}

static void every_loss(void)
{
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        for (int robust = 0; robust < FF_ROBUST_COUNT; robust++) {
            char what[64];
            if ((loss + robust) % 2 && !ff_test_is_thorough()) continue; /* every one of both, half of the pairs */
            snprintf(what, sizeof what, "%s, %s", ff_loss_name(loss), ff_robust_name(robust));
            experiment e = experiment_make(what, "ggx+lambert", ellipse, 5);
            e.loss = (ff_loss)loss;
            e.robust = (ff_robust)robust;
            e.robust_scale = 0.05;
            if (robust) e.outliers = 1;
            /* a loss that lets go of outliers has a minimum for each choice of them: both are to be in the same one */
            e.start_at_truth = robust == FF_ROBUST_TUKEY;
            if (robust == FF_ROBUST_TUKEY) e.max_iterations = 1000;
            compare(&e);
        }
}

static void weights_and_bounds(void)
{
    experiment e = experiment_make("sigma weights", "ggx+lambert", ellipse, 9);
    e.how.sigma = 1;
    compare(&e);
    e.loss = FF_LOSS_LOG;
    e.what = "sigma weights, log";
    compare(&e);
    e = experiment_make("bounds", "ggx+lambert", ellipse, 12);
    e.beyond = 1;
    compare(&e);
    e.what = "bounds, log";
    e.loss = FF_LOSS_LOG;
    compare(&e);
    e.what = "bounds, log, cauchy";
    e.robust = FF_ROBUST_CAUCHY;
    e.robust_scale = 0.05;
    compare(&e);
    e = experiment_make("bounds, from afar", "ggx+lambert", ellipse, 12);
    e.beyond = 1;
    e.start_off = 0.8;
    compare(&e);
    e = experiment_make("a shape on its bound", "beckmann+lambert", "alpha=0.3", 6);
    e.fit = "student-t+lambert";
    e.shape = FF_SHAPE_ISOTROPIC;
    compare(&e);
}

static void every_kind_of_model(void)
{
    static const char *const models[] = {"beckmann/v-cavity+lambert",
                                         "ggx/smith-height-correlated/conductor+lambert",
                                         "ggx/smith-separable/dielectric+lambert",
                                         "ggx/smith-height-correlated/schlick-f82+lambert",
                                         "student-t+oren-nayar",
                                         "ggx+disney-coupled",
                                         "lambert"};
    for (size_t i = 0; i < sizeof models / sizeof *models; i++) {
        const int lobe = strcmp(models[i], "lambert") != 0, coupled = strstr(models[i], "coupled") != NULL;
        experiment e = experiment_make(models[i], models[i], !lobe ? "" : coupled ? "alpha=0.3" : ellipse, 9);
        if (!lobe || coupled) e.shape = FF_SHAPE_ISOTROPIC;
        compare(&e);
        char what[80];
        snprintf(what, sizeof what, "from afar: %s", models[i]);
        e.what = what;
        e.start_off = 0.5;
        compare(&e);
    }
    experiment e = experiment_make("isotropic", "ggx+lambert", "alpha=0.3", 9);
    e.shape = FF_SHAPE_ISOTROPIC;
    compare(&e);
    e.what = "a shape that is held";
    e.hold = "alpha_x";
    compare(&e);
    e = experiment_make("two lobes", "ggx+beckmann+lambert", "alpha=0.1 lobe2.alpha=0.5", 9);
    e.shape = FF_SHAPE_ISOTROPIC;
    e.how.glossy = 0.5;
    compare(&e);
}

/* Residuals of the wrong model go together: clusters are longer than a sample. */
static void clusters_of_samples(void)
{
    for (int way = 0; way < 4; way++) {
        experiment e = experiment_make("clusters", "beckmann+lambert", "alpha=0.3", 9);
        e.fit = way < 3 ? "ggx+lambert" : "student-t+lambert";
        e.misfit = way < 3;
        e.how.n = 6000;
        e.how.noise = 0.01;
        e.shape = FF_SHAPE_ISOTROPIC;
        if (way == 1) e.what = "clusters, sigma weights", e.how.sigma = 1;
        if (way == 2) e.what = "clusters, bounds", e.beyond = 1;
        if (way == 3) e.what = "no clusters";
        compare(&e);
    }
}

/* The values of a result, shape [n_shape] first, then those of the channels [n_channels][n_channel]. */
typedef struct place {
    double shape[FF_MAX_SHAPE], channel[FIT_CHANNELS * FF_MAX_CHANNEL_PARAMS];
} place;

static place place_of(const ff_fit_result *r)
{
    place x = {{0}, {0}};
    for (uint32_t k = 0; k < r->model.n_shape; k++) x.shape[k] = r->shape_value[k].value;
    for (size_t k = 0; k < r->n_channels * r->model.n_channel; k++) x.channel[k] = r->channel_value[k].value;
    return x;
}

/* From x on all samples, either way, with so many iterations: where that ends. Returns the objective there. */
static double minimised(const experiment *e, ff_plan *plan, int arrow, int iterations, place *x)
{
    ff_point at = {.outcome = FF_CONVERGED};
    ff_error err = {0};
    if (ff_point_new(plan, &at)) exit(1);
    plan->l.arrowhead = arrow;
    plan->max_iterations = iterations;
    ff_point_set(plan, x->shape, x->channel, &at);
    const ff_status status = ff_minimise(plan, &at, &err);
    FF_CHECK(!status && (iterations == 0 || at.outcome == FF_CONVERGED), "%s: %s, %s", e->what, err.message,
             ff_outcome_name((int)at.outcome));
    memcpy(x->shape, at.shape, plan->l.m->n_shape * sizeof *at.shape);
    memcpy(x->channel, at.channel, e->n_channels * plan->l.m->n_channel * sizeof *at.channel);
    const double objective = 0.5 * at.cost2;
    ff_point_free(&at);
    return objective;
}

/* The objective where value k of a result is moved by `step`, relative to that of the result. */
static double aside(const experiment *e, ff_plan *plan, const ff_fit_result *r, size_t k, double step)
{
    const size_t S = r->model.n_shape;
    place x = place_of(r);
    *(k < S ? &x.shape[k] : &x.channel[k - S]) += step;
    return minimised(e, plan, 0, 0, &x) / r->residual.objective;
}

/* From its bound a step of 1e-7 of the box inwards must not lower the objective to first order. Where it is lower, a second step
 * tells that from the second order: where eta is 1 a lobe goes with (eta - 1)^2, and descents by first derivatives do not leave. */
static void check_on_bound(const experiment *e, ff_plan *plan, const ff_fit_result *r, size_t k, const char *name, double step)
{
    const double near = aside(e, plan, r, k, step), far = aside(e, plan, r, k, 2 * step), first = 0.5 * (4 * near - far - 3);
    FF_CHECK(near >= 1 - 1e-9 || first >= -1e-9, "%s: %s pulls inside: by %g the objective falls by %.3g of itself", e->what, name,
             step, -first);
    if (near < 1 - 1e-9) printf("%-44s %s on its bound has no slope, and the objective falls inside\n", e->what, name);
}

/* Where a descent may end: from there neither way goes anywhere, beside it, a parameter moved by its standard error, the objective
 * is not lower, and from a bound it has no slope inwards. */
static void check_minimum(const experiment *e, const ff_table *t, const ff_model *m, const ff_fit_result *r)
{
    const size_t S = m->n_shape, N = S + e->n_channels * m->n_channel;
    const place from = place_of(r);
    ff_problem *p = NULL;
    ff_layout l;
    ff_error err = {0};
    const ff_fit_options o = options_of(e, 1000);
    ff_status status = ff_problem_make(t, m, 1, &o, &p, &err);
    if (!status) status = ff_layout_init(m, e->n_channels, o.shape, 0, &l, &err);
    if (!FF_CHECK(status == FF_OK, "%s: %s", e->what, err.message)) return;
    ff_plan plan = ff_plan_with(&l, p, &o);
    place to[2] = {from, from};
    for (int arrow = 0; arrow < 2; arrow++)
        FF_CHECK_CLOSE(minimised(e, &plan, arrow, o.max_iterations, &to[arrow]), r->residual.objective, 1e-9, 0);
    for (size_t k = 0; k < N; k++) {
        const ff_fit_value *v = k < S ? &r->shape_value[k] : &r->channel_value[k - S];
        const ff_model_param *q = k < S ? &m->shape[k] : &m->channel[(k - S) % m->n_channel];
        const double off = 1e-7 * (q->info->hi - q->info->lo);
        for (int arrow = 0; arrow < 2; arrow++) {
            const double end = k < S ? to[arrow].shape[k] : to[arrow].channel[k - S];
            FF_CHECK(v->at_bound ? end == v->value : !(fabs(end - v->value) > 1e-3 * v->std_error),
                     "%s: %s goes on from %.12g to %.12g", e->what, q->name, v->value, end);
        }
        if (v->at_bound) check_on_bound(e, &plan, r, k, q->name, v->at_bound < 0 ? off : -off);
        for (int side = -1; side <= 1 && !v->at_bound && v->std_error > 0; side += 2) {
            const double step = fmin(fmax(side * v->std_error, q->info->lo - v->value), q->info->hi - v->value),
                         there = aside(e, &plan, r, k, step);
            FF_CHECK(there >= 1 - 1e-9, "%s: %s and %g: the objective falls by %.3g of itself", e->what, q->name, step, 1 - there);
        }
    }
    ff_problem_free(p);
}

/* From a start that is hard, either way: to the minimum that the dense fit finds from the surface's own parameters, or to another
 * one. astray [arrow, dense]: counts these. */
static void start_hard(const experiment *e, int astray[2])
{
    const fit_surface s = surface_of(e);
    ff_table t = data_of(e, &s);
    ff_fit_result best = {.n_channels = 0}, r;
    ff_error err = {0};
    double shape[FF_MAX_SHAPE], channel[FIT_CHANNELS * FF_MAX_CHANNEL_PARAMS];
    ff_fit_options o = options_of(e, 1000);
    o.start_shape = s.shape;
    o.start_channel = s.channel;
    ff_status status = fit_table(&t, &s.model, &o, &best, NULL, &err);
    FF_CHECK(status == FF_OK, "%s: %s", e->what, err.message);
    ff_model_defaults(&s.model, e->n_channels, shape, channel);
    char words[128], *save = NULL;
    snprintf(words, sizeof words, "%s", e->start);
    for (char *word = strtok_r(words, " ", &save); word && !status; word = strtok_r(NULL, " ", &save))
        status = ff_model_set(&s.model, e->n_channels, word, shape, channel, &err);
    for (int way = 0; way < 2 && !status; way++) {
        o = options_of(e, way == 0 ? 0 : 1000);
        o.start_shape = shape;
        o.start_channel = channel;
        const ff_status end = fit_table(&t, &s.model, &o, &r, NULL, &err);
        if (!FF_CHECK(end == FF_OK, "%s: %s", e->what, err.message)) continue;
        FF_CHECK((r.channel_correlation != NULL) == (way == 0), "%s: which path was taken", e->what);
        if (fabs(r.residual.objective - best.residual.objective) <= 1e-6 * best.residual.objective) {
            check_same(e->what, e->robust, &r, &best);
        } else {
            printf("%-44s %s: objective %.8g, %.8g at the surface\n", e->what, way ? "dense" : "arrow", r.residual.objective,
                   best.residual.objective);
            FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", e->what, ff_outcome_name((int)r.outcome));
            check_minimum(e, &t, &s.model, &r);
            astray[way]++;
        }
        ff_fit_result_clear(&r);
    }
    if (best.n_channels) ff_fit_result_clear(&best);
    ff_table_clear(&t);
}

/* Starts from which an undamped step of the channels goes astray, and shapes that start on a bound and must leave it. A start that
 * is given is where a descent begins; it may lead to another minimum, most often a lobe narrower than what the samples are apart,
 * with alpha on its bound, or to eta = 1, where it has no slope; and rounding and noise decide. With seeds 0 to 30 75 of 2170 did,
 * 2.4 of 70, no more scattered than Poisson says (0 to 6): 10 or more come once in 4600 seeds. */
static void starts_that_are_hard(void)
{
    static const struct {
        const char *model, *set, *start;
    } cases[] = {{"ggx/smith-height-correlated/conductor+lambert", "alpha=0.3", "alpha=0.5 eta=3 k=1 kd=0.5"},
                 {"ggx/smith-height-correlated/conductor+lambert", "alpha=0.3", "alpha=0.2 eta=0.5 k=4 kd=0"},
                 {"ggx/smith-height-correlated/dielectric+lambert", "alpha=0.3", "alpha=1 eta=2.9 kd=1"},
                 {"ggx/smith-height-correlated/dielectric+lambert", "alpha=0.3", "alpha=0.1 eta=1.01 kd=0"},
                 {"student-t+lambert", "alpha=0.3 gamma=2.5", "alpha=0.2 gamma=100"},
                 {"student-t+lambert", "alpha=0.3 gamma=2.5", "alpha=0.5 gamma=1.51"},
                 {"ggx+lambert", "alpha=0.3", "alpha=1 f0=0 kd=1"}};
    int all = 0;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        int astray[2] = {0};
        char what[120];
        snprintf(what, sizeof what, "%s from %s", cases[i].model, cases[i].start);
        for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
            experiment e = experiment_make(what, cases[i].model, cases[i].set, 9);
            e.shape = FF_SHAPE_ISOTROPIC;
            e.start = cases[i].start;
            e.loss = (ff_loss)loss;
            start_hard(&e, astray);
        }
        FF_CHECK(astray[0] < FF_LOSS_COUNT && astray[1] < FF_LOSS_COUNT, "%s: astray with every loss: arrow %d, dense %d", what,
                 astray[0], astray[1]);
        all += astray[0] + astray[1];
    }
    printf("%d of 70 end in another minimum\n", all);
    FF_CHECK(all <= 9, "%d of 70 end in another minimum", all);
}

static void exact_data(void)
{
    experiment e = experiment_make("exact data", "ggx+lambert", ellipse, 9);
    const fit_surface s = surface_of(&e);
    e.how.noise = 0;
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
        e.loss = (ff_loss)loss;
        ff_table t = data_of(&e, &s);
        ff_fit_options o = options_of(&e, 0);
        ff_fit_result r;
        ff_error err = {0};
        const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
        FF_CHECK(status == FF_OK, "%s", err.message);
        if (!status) {
            FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", ff_loss_name(loss), ff_outcome_name((int)r.outcome));
            for (size_t k = 0; k < fit_parameter_count(&r); k++) {
                char name[64];
                double truth;
                const ff_fit_value *v = fit_parameter(&r, k, &s, &truth, name);
                if (v) FF_CHECK_CLOSE(v->value, truth, 1e-6, 1e-8);
            }
            ff_fit_result_clear(&r);
        }
        ff_table_clear(&t);
    }
}

static void outcome_limit(void)
{
    experiment e = experiment_make("one iteration", "ggx+lambert", ellipse, 9);
    e.how.n = 30000; /* the start is refined on a part of them, whose optimum is another one */
    const fit_surface s = surface_of(&e);
    ff_table t = data_of(&e, &s);
    double shape[FF_MAX_SHAPE];
    memcpy(shape, s.shape, sizeof shape);
    shape[0] = 1, shape[1] = 0.05;
    ff_fit_options o = options_of(&e, 0);
    o.start_shape = shape;
    o.start_channel = s.channel;
    o.max_iterations = 0;
    ff_fit_result r;
    ff_error err = {0};
    const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    if (!status) {
        FF_CHECK(r.outcome == FF_LIMIT, "%s", ff_outcome_name((int)r.outcome));
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* ---- the covariance at one point ------------------------------------------------------------- */

/* Both at the same parameters, so that nothing but rounding may differ. dark: a channel whose lobe has no strength, so that its f0
 * has no effect; -1 = none. Returns how many parameters are in use and not determined. */
static int covariance_at(const experiment *e, int dark)
{
    fit_surface s = surface_of(e);
    const uint32_t scale = ff_model_param_find(&s.model, "ks").index;
    if (dark >= 0) {
        s.model.channel[scale].flags &= ~(uint32_t)FF_PARAM_HELD;
        s.channel[(size_t)dark * s.model.n_channel + scale] = 0;
    }
    int lost = 0;
    ff_table t = data_of(e, &s);
    ff_fit_options o = options_of(e, 1000);
    ff_problem *p = NULL;
    ff_layout l;
    ff_error err = {0};
    ff_status status = ff_problem_make(&t, &s.model, 1, &o, &p, &err);
    if (!status) status = ff_layout_init(&s.model, e->n_channels, o.shape, 0, &l, &err);
    FF_CHECK(status == FF_OK, "%s: %s", e->what, err.message);
    if (status) {
        ff_table_clear(&t);
        return 0;
    }
    ff_plan plan = ff_plan_with(&l, p, &o);
    ff_point dense = {0}, many = {0};
    const size_t P = l.P, S = l.free.n_shape, K = l.free.n_channel;
    double worst = 0;
    if (ff_point_new(&plan, &dense) || ff_point_new(&plan, &many)) exit(1);
    ff_point_set(&plan, s.shape, s.channel, &dense);
    ff_point_set(&plan, s.shape, s.channel, &many);
    for (size_t k = 0; k < P; k++) dense.at_bound[k] = many.at_bound[k] = e->beyond ? (k % 5 == 4) - (k % 7 == 6) : 0;
    status = ff_errors(&plan, &dense);
    ff_selection used;
    ff_problem_selection(p, &used);
    FF_CHECK(used.used == t.n - t.n_invalid, "all samples are used");
    plan.l.arrowhead = 1;
    if (!status) status = ff_errors(&plan, &many);
    FF_CHECK(status == FF_OK, "%s: %s", e->what, ff_status_str(status));
    const ff_information *a = many.information, *u = dense.information;
    if (a) {
        FF_CHECK(a->clusters.run == u->clusters.run && a->clusters.settled == u->clusters.settled, "%s: clusters of %zu, dense %zu",
                 e->what, a->clusters.run, u->clusters.run);
        FF_CHECK_CLOSE(a->effective, u->effective, 1e-9, 0);
    }
    for (size_t i = 0; i < P && a; i++) {
        FF_CHECK(a->determined[i] == u->determined[i], "%s: parameter %zu is determined: %d, dense %d", e->what, i,
                 a->determined[i], u->determined[i]);
        lost += dense.at_bound[i] == 0 && !u->determined[i];
        if (u->determined[i]) FF_CHECK_CLOSE(a->dof[i], u->dof[i], 1e-9, 0);
        for (size_t j = 0; j < P; j++) {
            if (!u->determined[i] || !u->determined[j]) continue;
            const double v = ff_information_covariance(a, i, j), cov = ff_information_covariance(u, i, j);
            const int between = i >= S && j >= S && (i - S) / K != (j - S) / K;
            FF_CHECK(between == isnan(v), "%s: covariance %zu %zu is %.15g", e->what, i, j, v);
            if (between) continue;
            const double off = fabs(v - cov) / fmax(sqrt(u->variance[i] * u->variance[j]), 1e-300);
            worst = fmax(worst, off);
            FF_CHECK(off < 1e-9, "%s: covariance %zu %zu is %.15g, dense %.15g", e->what, i, j, v, cov);
        }
    }
    for (int k = 0; k < FF_STAT_COUNT; k++) FF_CHECK_CLOSE(many.normal.stat[k], dense.normal.stat[k], 1e-12, 0);
    printf("%-44s covariances differ by %.0e\n", e->what, worst);
    ff_point_free(&dense);
    ff_point_free(&many);
    ff_problem_free(p);
    ff_table_clear(&t);
    return lost;
}

static void covariance_of_one_point(void)
{
    experiment e = experiment_make("sandwich", "ggx+lambert", ellipse, 7);
    FF_CHECK(covariance_at(&e, -1) == 0, "%s: all are determined", e.what);
    e.what = "sandwich, some left out";
    e.beyond = 1;
    FF_CHECK(covariance_at(&e, -1) == 0, "%s: all are determined", e.what);
    e.what = "log, huber";
    e.loss = FF_LOSS_LOG;
    e.robust = FF_ROBUST_HUBER;
    e.robust_scale = 0.02;
    FF_CHECK(covariance_at(&e, -1) == 0, "%s: all are determined", e.what);
    e = experiment_make("H^-1 of sigma weights", "ggx+lambert", ellipse, 7);
    e.how.sigma = 1;
    FF_CHECK(covariance_at(&e, -1) == 0, "%s: all are determined", e.what);
    e = experiment_make("conductor", "ggx/smith-height-correlated/conductor+lambert", ellipse, 7);
    FF_CHECK(covariance_at(&e, -1) == 0, "%s: all are determined", e.what);
    e = experiment_make("two lobes", "ggx+beckmann+lambert", "alpha_x=0.1 alpha_y=0.15 r_xy=0.2 lobe2.alpha=0.5", 7);
    e.how.n = 5000;
    FF_CHECK(covariance_at(&e, -1) == 0, "%s: all are determined", e.what);
    e = experiment_make("a lobe without strength", "ggx+lambert", ellipse, 7);
    FF_CHECK(covariance_at(&e, 3) == 1, "%s: f0 is not determined", e.what);
    e = experiment_make("two equal lobes", "ggx+ggx", "alpha=0.3 lobe2.alpha=0.3", 7);
    FF_CHECK(covariance_at(&e, -1) == 20, "%s: nothing is determined", e.what);
}

/* ---- how it is done -------------------------------------------------------------------------- */

/* One thread against three, each instruction set against the best one: the same bits, the same numbers. */
static void threads_and_instruction_sets(void)
{
    experiment e = experiment_make("threads", "ggx+lambert", ellipse, 12);
    e.how.n = 20000;
    const fit_surface s = surface_of(&e);
    ff_table t = data_of(&e, &s);
    ff_fit_result first, r;
    ff_error err = {0};
    ff_fit_options o = options_of(&e, FF_DENSE_CHANNELS);
    o.threads = 1;
    FF_CHECK(fit_table(&t, &s.model, &o, &first, NULL, &err) == FF_OK, "%s", err.message);
    FF_CHECK(first.channel_correlation != NULL, "twelve channels are many");
    for (int way = 0; way < 4; way++) {
        const ff_isa isas[] = {FF_ISA_BEST, FF_ISA_SCALAR, FF_ISA_AVX2, FF_ISA_AVX512};
        o.threads = way == 0 ? 3 : 1;
        o.isa = isas[way];
        if (!ff_isa_available(o.isa)) continue;
        const ff_status status = fit_table(&t, &s.model, &o, &r, NULL, &err);
        FF_CHECK(status == FF_OK, "%s", err.message);
        if (status) continue;
        for (size_t k = 0; k < fit_parameter_count(&r); k++) {
            char name[64];
            double truth;
            const ff_fit_value *x = fit_parameter(&r, k, NULL, &truth, name), *y = fit_parameter(&first, k, NULL, &truth, name);
            if (!x) continue;
            if (way == 0) FF_CHECK(x->value == y->value && x->std_error == y->std_error, "%s with three threads", name);
            FF_CHECK_CLOSE(x->value, y->value, 1e-8, 0);
            FF_CHECK_CLOSE(x->std_error, y->std_error, 1e-6, 0);
        }
        ff_fit_result_clear(&r);
    }
    ff_fit_result_clear(&first);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(any_number_of_channels), FF_TEST(every_loss), FF_TEST(weights_and_bounds), FF_TEST(every_kind_of_model),
             FF_TEST(starts_that_are_hard), FF_TEST(clusters_of_samples), FF_TEST(exact_data), FF_TEST(outcome_limit),
             FF_TEST(covariance_of_one_point), FF_TEST(threads_and_instruction_sets))
