/* What is known besides the data: bounds, ties, priors and the conservation of energy, each against a second way to the same
 * answer. */
#include "model_samples.h"
#include "warnings.h"
#include "ff_albedo.h"
#include "fit/start/internal_start.h"
#include "models/tools/internal_albedo.h"
#include "pass_of.h"

/* What is compared by hand here is the covariance by the residuals. */
static ff_fit_options by_residuals(void)
{
    ff_fit_options o = fit_options();
    o.errors = FF_ERRORS_RESIDUALS;
    return o;
}

/* ---- one fit --------------------------------------------------------------------------------- */

/* The fit has to work. */
static ff_fit_result fitted(const char *what, const ff_table *t, const ff_model *m, const ff_fit_options *o)
{
    ff_fit_result r = {0};
    ff_error err = {0};
    const ff_status status = fit_table(t, m, o, &r, NULL, &err);
    FF_CHECK(status == FF_OK, "%s: %s", what, err.message);
    if (status) exit(1);
    FF_CHECK(r.outcome == FF_CONVERGED, "%s: %s", what, ff_outcome_name((int)r.outcome));
    return r;
}

static const ff_fit_value *value_of(const ff_fit_result *r, const char *name, size_t c)
{
    const ff_fit_value *v = ff_fit_result_find(r, name, c);
    if (!v) {
        printf("the test itself is wrong: there is no %s\n", name);
        exit(1);
    }
    return v;
}

/* Equal to a part of the standard error. */
static void check_same(const char *what, const ff_fit_value *a, const ff_fit_value *b, double part)
{
    if (b->held) return;
    FF_CHECK(fabs(a->value - b->value) <= part * b->std_error, "%s: %.12g and %.12g", what, a->value, b->value);
    FF_CHECK(fabs(a->std_error - b->std_error) <= 1e-3 * b->std_error, "%s: standard errors %.8g and %.8g", what, a->std_error,
             b->std_error);
}

/* The objective with these parameters held, the others free. */
static double objective_with(const ff_table *t, const ff_model *m, const ff_fit_options *o, const char *const *names, double value)
{
    ff_model held = *m;
    for (; *names; names++)
        if (ff_model_hold(&held, *names, value, NULL)) exit(1);
    ff_fit_result r = fitted("held", t, &held, o);
    const double objective = r.residual.objective;
    ff_fit_result_clear(&r);
    return objective;
}

/* The smallest of it over the value, by golden sections between lo and hi. */
static double golden(const ff_table *t, const ff_model *m, const ff_fit_options *o, const char *const *names, double lo, double hi,
                     double *at)
{
    const double ratio = 0.6180339887498949;
    double a = hi - ratio * (hi - lo), b = lo + ratio * (hi - lo), fa = objective_with(t, m, o, names, a),
           fb = objective_with(t, m, o, names, b);
    for (int i = 0; i < 22; i++) {
        if (fa < fb) {
            hi = b, b = a, fb = fa;
            fa = objective_with(t, m, o, names, a = hi - ratio * (hi - lo));
        } else {
            lo = a, a = b, fa = fb;
            fb = objective_with(t, m, o, names, b = lo + ratio * (hi - lo));
        }
    }
    *at = 0.5 * (a + b);
    return fmin(fa, fb);
}

/* ---- bounds ---------------------------------------------------------------------------------- */

static void bounds_of_a_model(void)
{
    ff_model m;
    ff_error err = {0};
    FF_CHECK(ff_model_parse("ggx+lambert", &m, &err) == FF_OK, "parse");
    FF_CHECK(m.shape[0].lo == m.shape[0].info->lo && m.shape[0].hi == m.shape[0].info->hi, "bounds are not the box at first");
    FF_CHECK(ff_model_bound(&m, "alpha", 0.4, 0.5, &err) == FF_OK, "%s", err.message);
    FF_CHECK(m.shape[0].lo == 0.4 && m.shape[1].hi == 0.5 && m.shape[0].init == 0.4, "alpha is not both axes, or starts outside");
    FF_CHECK(ff_model_bound(&m, "alhpa", 0.4, 0.5, &err) == FF_ERR_UNKNOWN, "an unknown name");
    FF_CHECK(ff_model_bound(&m, "f0", 0.5, 0.5, &err) == FF_ERR_RANGE && strstr(err.message, "must rise"), "%s", err.message);
    FF_CHECK(ff_model_bound(&m, "f0", 0.5, NAN, &err) == FF_ERR_RANGE, "a bound that is no number");
    FF_CHECK(ff_model_bound(&m, "r_xy", 0, 1.5, &err) == FF_ERR_RANGE && strstr(err.message, "[-0.999, 0.999]"), "%s", err.message);
    FF_CHECK(ff_model_bound(&m, "f0", -0.5, 1.5, &err) == FF_ERR_RANGE && strstr(err.message, "[0, 1e+15]"), "%s", err.message);
    FF_CHECK(ff_model_bound(&m, "ks", 2, 3, &err) == FF_ERR_RANGE && strstr(err.message, "held at 1"), "%s", err.message);
}

static void bounds_hold(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 2, "alpha=0.3 f0=0.6:0.3 kd=0.1:0.3");
    const fit_sampling how = {.n = 3000, .max_theta = 75, .noise = 0.03, .seed = 3};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_fit_result plain = fitted("no bounds", &t, &s.model, &o);
    /* bounds that nothing runs into change nothing */
    const ff_bound wide[] = {{"alpha_x", 0.1, 0.9, NULL}, {"kd", 0, 0.6, NULL}};
    ff_constraints c = {.n_bounds = 2, .bound = wide};
    o.constraints = &c;
    ff_fit_result r = fitted("wide bounds", &t, &s.model, &o);
    for (size_t k = 0; k < r.model.n_channel; k++) check_same("inactive", &r.channel_value[k], &plain.channel_value[k], 1e-3);
    check_same("inactive", &r.shape_value[0], &plain.shape_value[0], 1e-3);
    FF_CHECK(!has_warning(&r, FF_WARNING_AT_BOUND, NULL), "a bound is warned of that nothing runs into");
    ff_fit_result_clear(&r);
    /* and those that bind are as good as the parameter held there; alpha_y speaks of the one alpha */
    const ff_bound narrow[] = {{"alpha_y", 0.05, 0.2, NULL}, {"kd", 0.15, 0.25, NULL}};
    c.bound = narrow;
    r = fitted("narrow bounds", &t, &s.model, &o);
    const ff_fit_value *alpha = value_of(&r, "alpha_x", 0);
    FF_CHECK(alpha->value == 0.2 && alpha->at_bound == 1 && isnan(alpha->std_error), "alpha is %.17g, bound %d", alpha->value,
             alpha->at_bound);
    const ff_warning *w = find_warning(&r, FF_WARNING_AT_BOUND, "alpha_x"), *of_kd = find_warning(&r, FF_WARNING_AT_BOUND, "kd");
    FF_CHECK(w && w->value[0] == 0.2 && w->value[1] == 1 && w->value[2] == 1, "alpha on the given upper bound, and no warning");
    FF_CHECK(w && w->severity == FF_SEVERITY_WARNING && w->n_parameters == 1 && w->n_channels == 0,
             "a shared parameter has channels");
    FF_CHECK(of_kd && of_kd->value[2] == 1 && of_kd->n_channels > 0, "the bound of kd goes without a word");
    for (size_t k = 0; of_kd && k < of_kd->n_channels; k++)
        FF_CHECK(value_of(&r, "kd", of_kd->channel[k])->at_bound == (int)of_kd->value[1], "channel %zu", of_kd->channel[k]);
    size_t on_bound = 0;
    for (size_t i = 0; i < 2; i++) {
        const ff_fit_value *kd = value_of(&r, "kd", i);
        const double expected = kd->at_bound < 0 ? 0.15 : kd->at_bound > 0 ? 0.25 : kd->value;
        FF_CHECK(kd->value == expected, "kd is %g, and on its bound %g", kd->value, expected);
        FF_CHECK(kd->at_bound || (kd->value > 0.15 && kd->value < 0.25), "kd is %g, and on no bound", kd->value);
        on_bound += kd->at_bound != 0;
    }
    FF_CHECK(of_kd && on_bound >= of_kd->n_channels && on_bound > 0, "%zu channels on a bound", on_bound);
    o.constraints = NULL;
    ff_model held = s.model;
    ff_model_hold(&held, "alpha", 0.2, NULL);
    ff_model_bound(&held, "kd", 0.15, 0.25, NULL);
    ff_fit_result same = fitted("held", &t, &held, &o);
    FF_CHECK_CLOSE(r.residual.objective, same.residual.objective, 1e-9, 0);
    FF_CHECK(r.residual.objective > 1.01 * plain.residual.objective, "the bounds cost nothing");
    ff_fit_result_clear(&same);
    ff_fit_result_clear(&r);
    ff_fit_result_clear(&plain);
    ff_table_clear(&t);
}

/* Bounds on what is solved for, with a free scale, and through a surrogate. */
static void bounds_in_the_search(void)
{
    static const struct {
        const char *model, *set, *free_name, *bounded;
        double lo, hi;
    } cases[] = {
        {"ggx+lambert", "alpha=0.2 f0=0.5 ks=1.6 kd=0.1", "ks", "ks", 0.5, 1.2},
        {"ggx+lambert", "alpha=0.2 f0=0.5 ks=1.6 kd=0.1", "ks", "f0", 0.6, 0.9},
        {"ggx/smith-separable/dielectric+lambert", "alpha=0.2 eta=1.5 kd=0.3", NULL, "eta", 1.6, 2.5},
        {"beckmann/smith-separable/conductor+oren-nayar", "alpha=0.4 eta=0.8 k=2 kd=0.3 sigma_facet=0.3", NULL, "k", 0.5, 1.7},
        {"ggx+ggx+lambert", "alpha=0.1 lobe2.alpha=0.5 f0=0.3 lobe2.f0=0.4 kd=0.1", NULL, "lobe2.alpha", 0.02, 0.3},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const fit_surface s = fit_surface_make(cases[i].model, 1, cases[i].set);
        const fit_sampling how = {.n = 3000, .max_theta = 75, .noise = 0.02, .glossy = 0.3, .seed = 4 + i};
        ff_table t = fit_measure(&s, &how);
        ff_fit_options o = by_residuals();
        o.shape = FF_SHAPE_ISOTROPIC;
        ff_model m = s.model;
        if (cases[i].free_name) ff_model_vary(&m, cases[i].free_name, NULL);
        const ff_bound b = {cases[i].bounded, cases[i].lo, cases[i].hi, NULL};
        const ff_constraints c = {.n_bounds = 1, .bound = &b};
        o.constraints = &c;
        ff_fit_result r = fitted(cases[i].model, &t, &m, &o);
        o.constraints = NULL;
        double best = INFINITY; /* of the parameter held at places within */
        for (int k = 0; k <= 4; k++) {
            const double v = cases[i].lo + (cases[i].hi - cases[i].lo) * k / 4;
            best = fmin(best, objective_with(&t, &m, &o, (const char *const[]){cases[i].bounded, NULL}, v));
        }
        FF_CHECK(r.residual.objective <= best * (1 + 1e-7), "%s, %s bounded: objective %.10g, with it held %.10g", cases[i].model,
                 cases[i].bounded, r.residual.objective, best);
        for (size_t k = 0; k < r.model.n_shape; k++)
            FF_CHECK(r.shape_value[k].held ||
                         (r.shape_value[k].value >= r.model.shape[k].lo && r.shape_value[k].value <= r.model.shape[k].hi),
                     "%s: %s = %g lies outside", cases[i].model, r.model.shape[k].name, r.shape_value[k].value);
        for (size_t k = 0; k < r.model.n_channel; k++)
            FF_CHECK(r.channel_value[k].value >= r.model.channel[k].lo && r.channel_value[k].value <= r.model.channel[k].hi,
                     "%s: %s = %g lies outside", cases[i].model, r.model.channel[k].name, r.channel_value[k].value);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* The search of a start moves nothing that is held, though its ellipses have both axes and a direction. */
static void what_is_held_stays(void)
{
    static const char *const names[] = {"alpha_x", "alpha_y", "r_xy"};
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha_x=0.2 alpha_y=0.4 r_xy=0.3 f0=0.6 kd=0.1");
    const fit_sampling how = {.n = 2000, .max_theta = 75, .noise = 0.05, .seed = 6};
    ff_table t = fit_measure(&s, &how);
    const ff_fit_options o = by_residuals();
    for (int k = 0; k < 3; k++) {
        ff_model m = s.model;
        ff_model_hold(&m, names[k], 0.25, NULL);
        ff_fit_result r = fitted(names[k], &t, &m, &o);
        const ff_fit_value *v = value_of(&r, names[k], 0);
        FF_CHECK(v->held && v->value == 0.25, "%s is held at 0.25 and came out as %g", names[k], v->value);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* ---- ties ------------------------------------------------------------------------------------ */

/* alpha_y = alpha_x along the axes is the isotropic shape: every number and its error. */
static void two_axes_are_one(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha_x=0.25 alpha_y=0.35 f0=0.9:0.6:0.3 kd=0.1:0.05:0.02");
    const fit_sampling how = {.n = 3000, .max_theta = 75, .noise = 0.05, .seed = 9};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_fit_result one = fitted("isotropic", &t, &s.model, &o);
    const ff_tie tie = {"alpha_y", "alpha_x"};
    const ff_constraints c = {.n_ties = 1, .tie = &tie};
    o.shape = FF_SHAPE_AXIS;
    o.constraints = &c;
    ff_fit_result two = fitted("tied axes", &t, &s.model, &o);
    FF_CHECK_CLOSE(two.residual.objective, one.residual.objective, 1e-9, 0);
    FF_CHECK(two.n_free == one.n_free && two.n_columns == one.n_columns, "%zu and %zu free parameters", two.n_free, one.n_free);
    check_same("alpha_x", value_of(&two, "alpha_x", 0), value_of(&one, "alpha_x", 0), 1e-3);
    for (size_t k = 0; k < 3 * two.model.n_channel; k++)
        if (!two.channel_value[k].held) check_same("channel", &two.channel_value[k], &one.channel_value[k], 1e-3);
    const ff_fit_value *x = value_of(&two, "alpha_x", 0), *y = value_of(&two, "alpha_y", 0);
    FF_CHECK(y->tied && !x->tied && y->follows.kind == FF_PARAM_SHAPE && y->follows.index == 0 && y->value == x->value &&
                 y->std_error == x->std_error && y->column == x->column,
             "alpha_y does not follow alpha_x");
    for (size_t k = 0; k < two.n_columns * two.n_columns; k++)
        FF_CHECK(fabs(two.correlation[k] - one.correlation[k]) < 1e-4, "correlation %zu: %g and %g", k, two.correlation[k],
                 one.correlation[k]);
    ff_fit_result_clear(&two);
    ff_fit_result_clear(&one);
    ff_table_clear(&t);
}

/* A tie against the best of the parameters held together at one value. */
typedef struct tie_case {
    const char *what, *model, *set;
    size_t n_channels;
    const char *free_names[3];
    ff_tie tie[3];
    const char *held[4]; /* what the ties make one */
    double lo, hi;
} tie_case;

static const tie_case tie_cases[] = {
    {"one f0 of two lobes",
     "ggx+ggx+lambert",
     "alpha=0.08 lobe2.alpha=0.4 f0=0.3 lobe2.f0=0.5 kd=0.1",
     1,
     {0},
     {{"lobe2.f0", "f0"}},
     {"f0", "lobe2.f0"},
     0.2,
     0.7},
    {"one f0 of all channels", "ggx+lambert", "alpha=0.3 f0=0.3:0.5:0.4 kd=0.3:0.1:0.2", 3, {0}, {{"f0", NULL}}, {"f0"}, 0.2, 0.7},
    {"one f0 of both lobes and all channels",
     "ggx+beckmann+lambert",
     "alpha=0.1 lobe2.alpha=0.5 f0=0.3:0.5 lobe2.f0=0.3:0.2 kd=0.2:0.1",
     2,
     {0},
     {{"f0", "lobe2.f0"}, {"f0", NULL}},
     {"f0", "lobe2.f0"},
     0.1,
     0.7},
    {"one alpha of two lobes",
     "ggx+beckmann/v-cavity",
     "alpha=0.3 lobe2.alpha=0.4 f0=0.3 lobe2.f0=0.5",
     1,
     {0},
     {{"lobe2.alpha", "alpha"}},
     {"alpha", "lobe2.alpha"},
     0.2,
     0.6},
    {"one index of all channels",
     "ggx/smith-separable/dielectric+lambert",
     "alpha=0.3 eta=1.4:1.6 kd=0.3:0.1",
     2,
     {0},
     {{"eta", NULL}},
     {"eta"},
     1.2,
     2},
    {"one index of two lobes",
     "ggx/smith-separable/dielectric+beckmann/smith-separable/dielectric+lambert",
     "alpha=0.1 lobe2.alpha=0.5 eta=1.4 lobe2.eta=1.7 kd=0.2",
     1,
     {0},
     {{"lobe2.eta", "eta"}},
     {"eta", "lobe2.eta"},
     1.2,
     2},
    {"one scale of two lobes",
     "ggx+beckmann+lambert",
     "alpha=0.1 lobe2.alpha=0.5 f0=0.1 lobe2.f0=0.4 ks=0.8 lobe2.ks=0.7 kd=0.2",
     1,
     {"ks", "lobe2.ks"},
     {{"lobe2.ks", "ks"}},
     {"ks", "lobe2.ks"},
     0.3,
     2},
};

static void ties_against_brute_force(void)
{
    for (size_t i = 0; i < sizeof tie_cases / sizeof *tie_cases; i++) {
        const tie_case *t = &tie_cases[i];
        const fit_surface s = fit_surface_make(t->model, t->n_channels, t->set);
        const fit_sampling how = {.n = 3000, .max_theta = 75, .noise = 0.02, .glossy = 0.3, .seed = 40 + i};
        ff_table table = fit_measure(&s, &how);
        ff_fit_options o = by_residuals();
        ff_constraints c = {.tie = t->tie};
        ff_model m = s.model;
        for (; c.n_ties < 3 && t->tie[c.n_ties].name; c.n_ties++) {
        }
        for (int k = 0; k < 3 && t->free_names[k]; k++) ff_model_vary(&m, t->free_names[k], NULL);
        o.shape = FF_SHAPE_ISOTROPIC;
        o.constraints = &c;
        ff_fit_result r = fitted(t->what, &table, &m, &o);
        o.constraints = NULL;
        ff_fit_result untied = fitted(t->what, &table, &m, &o);
        double at;
        const double best = golden(&table, &m, &o, t->held, t->lo, t->hi, &at);
        const char *leader = t->tie[0].to ? t->tie[0].to : t->tie[0].name;
        const ff_fit_value *v = value_of(&r, strcmp(leader, "alpha") ? leader : "alpha_x", 0);
        printf("    %-40s %.6g, by brute force %.6g; objective %.8g, untied %.8g\n", t->what, v->value, at, r.residual.objective,
               untied.residual.objective);
        FF_CHECK(fabs(r.residual.objective - best) <= 1e-6 * best, "%s: objective %.10g, by brute force %.10g", t->what,
                 r.residual.objective, best);
        FF_CHECK(fabs(v->value - at) <= 1e-3 * at && v->std_error > 0, "%s: %g +- %g, by brute force %g", t->what, v->value,
                 v->std_error, at);
        FF_CHECK(r.residual.objective > untied.residual.objective && r.n_free < untied.n_free, "%s: the tie costs nothing",
                 t->what);
        for (size_t c2 = 0; c2 < t->n_channels; c2++)
            for (int k = 0; t->held[k]; k++) {
                const ff_fit_value *w = value_of(&r, strstr(t->held[k], "alpha") ? "lobe2.alpha_y" : t->held[k], c2);
                if (t->tie[0].to && !t->tie[1].name && c2 > 0) continue;
                FF_CHECK(w->value == v->value && w->std_error == v->std_error && w->column == v->column && w->tied == (w != v),
                         "%s: %s of channel %zu is %g, tied %d", t->what, t->held[k], c2, w->value, w->tied);
            }
        ff_fit_result_clear(&untied);
        ff_fit_result_clear(&r);
        ff_table_clear(&table);
    }
}

/* The small problems of the search: a folded minimum against that of all unknowns at once by projected gradient descent. */
static void folded_least_squares(void)
{
    const fit_surface s = fit_surface_make("ggx+ggx+lambert", 3, "");
    for (int trial = 0; trial < 200; trial++) {
        uint64_t state = ff_test_stream("folded least squares %d", trial);
        const ff_tie all[] = {{"f0", NULL}, {"lobe2.f0", "f0"}, {"kd", NULL}, {"kd", "lobe2.f0"}};
        const ff_constraints c = {.n_ties = 1, .tie = &all[trial % 4]};
        ff_model m = s.model;
        ff_layout whole;
        ff_ties ties;
        FF_CHECK(ff_constraints_apply(&c, FF_SHAPE_ISOTROPIC, &m, &ties, NULL) == FF_OK, "apply");
        FF_CHECK(ff_layout_init(&m, 3, FF_SHAPE_ISOTROPIC, 0, &whole, NULL) == FF_OK, "layout");
        ff_layout_tie(&whole, &ties);
        const ff_layout l = ff_layout_of_channels(&whole);
        ff_normal n;
        FF_CHECK(ff_layout_normal(&l, &n) == FF_OK && l.tied && l.P == (trial % 2 ? 6 : 7), "%zu coordinates", l.P);
        for (size_t i = 0; i < 3; i++) { /* gram of four random columns */
            double column[4][6];
            for (int k = 0; k < 4; k++)
                for (int j = 0; j < 6; j++) column[k][j] = fit_normal(&state) * (k == 3 ? 2 : 1) + (k < 3 && j == 0);
            for (size_t a = 0; a < 4; a++)
                for (size_t b = 0; b <= a; b++)
                    for (int j = 0; j < 6; j++) n.gram[i * 10 + ff_tri(a, b)] += column[a][j] * column[b][j];
        }
        double at[15], out[15], x[16], H[256], g[16];
        ff_model_defaults(&m, 3, NULL, at);
        for (size_t i = 0; i < 3; i++)
            for (uint32_t k = 0; k < l.free.n_channel; k++) at[i * m.n_channel + l.free.channel[k]] = 0.25;
        const double sum = ff_tied_least_squares(&l, &n, at, out);
        assemble(&l, &n, NULL, H, g);
        double trace = 0, constant = 0, value = 0;
        for (size_t k = 0; k < l.P; k++) trace += H[k * l.P + k], x[k] = 0.25;
        for (size_t i = 0; i < 3; i++) constant += n.gram[i * 10 + 9];
        for (int step = 0; step < 20000; step++)
            for (size_t k = 0; k < l.P; k++) {
                double slope = g[k];
                for (size_t j = 0; j < l.P; j++) slope += H[k * l.P + j] * (x[j] - 0.25);
                x[k] = fmin(fmax(x[k] - slope / H[k * l.P + k], 0), 1);
            }
        for (size_t k = 0; k < l.P; k++) {
            value += 2 * g[k] * (x[k] - 0.25);
            for (size_t j = 0; j < l.P; j++) value += H[k * l.P + j] * (x[k] - 0.25) * (x[j] - 0.25);
        }
        FF_CHECK(fabs(sum - value - constant) <= 1e-8 * (trace + constant), "trial %d: %.12g, by descent %.12g", trial, sum,
                 value + constant);
        ff_normal_free(&n);
    }
}

/* What a final pass leaves for the errors, its columns added up by hand. */
static void check_fold(const ff_layout *l, const ff_problem *p, const ff_fit_options *o, const double *shape, const double *channel)
{
    enum { COLUMNS = 15, P = 8 };
    static const size_t to[COLUMNS] = {0, 0, 3, 1, 2, 3, 4, 5, 5, 4, 6, 6, 4, 7, 7}; /* alpha, r_xy, lobe2.alpha_x, _y, f0, kd */
    ff_normal n, folded;
    ff_pass pass;
    FF_CHECK(l->n_columns == COLUMNS && l->P == P, "%zu columns, %zu coordinates", l->n_columns, l->P);
    FF_CHECK(ff_layout_normal(l, &n) == FF_OK && ff_layout_normal(l, &folded) == FF_OK, "memory");
    for (int k = 0; k < 2; k++) {
        FF_CHECK(pass_of(l, p, o, shape, channel, &pass) == FF_OK, "pass");
        pass.final = pass.errors = 1;
        FF_CHECK(ff_pass_run(&pass, 0, k ? &folded : &n) == FF_OK, "pass");
        ff_pass_free(&pass);
    }
    FF_CHECK(ff_normal_fold(l, &folded) == FF_OK && folded.P == P && n.P == COLUMNS, "fold");
    double score_products[P][P] = {{0}}, own[P] = {0};
    for (size_t i = 0; i < COLUMNS; i++) {
        own[to[i]] += n.own[i];
        for (size_t k = 0; k < COLUMNS; k++) score_products[to[i]][to[k]] += n.score_products[ff_tri(i, k)];
    }
    for (size_t i = 0; i < P; i++) {
        const int meets = i == 0 || i == 3 || i >= 5; /* several columns of one value: not known from squares */
        FF_CHECK(meets ? folded.own[i] == 0 : fabs(folded.own[i] - own[i]) <= 1e-12 * own[i], "squares of %zu: %g, expected %g", i,
                 folded.own[i], own[i]);
        for (size_t k = 0; k <= i; k++)
            FF_CHECK_CLOSE(folded.score_products[ff_tri(i, k)], score_products[i][k], 1e-12,
                           1e-12 * sqrt(score_products[i][i] * score_products[k][k]));
    }
    for (size_t r = 0; r < n.n_runs; r += 17) {
        double sums[P] = {0};
        for (size_t i = 0; i < COLUMNS; i++) sums[to[i]] += n.runs[r * COLUMNS + i];
        for (size_t k = 0; k < P; k++) FF_CHECK_CLOSE(folded.runs[r * P + k], sums[k], 1e-12, 1e-13);
    }
    ff_normal_free(&n);
    ff_normal_free(&folded);
}

/* With ties of every kind at once: parameters and coordinates lead to each other, and J^T r is the slope of the objective by each.
 */
static void coordinates_of_tied_parameters(void)
{
    const fit_surface s = fit_surface_make("ggx+beckmann+lambert", 3,
                                           "alpha_x=0.2 alpha_y=0.3 r_xy=0.3 lobe2.alpha_x=0.5 lobe2.alpha_y=0.4 lobe2.r_xy=-0.2 "
                                           "f0=0.6:0.4:0.3 lobe2.f0=0.2:0.3:0.4 kd=0.3:0.2:0.1");
    const fit_sampling how = {.n = 1500, .max_theta = 75, .noise = 0.1, .seed = 13};
    const ff_tie tie[] = {{"alpha_y", "alpha_x"}, {"r_xy", "lobe2.r_xy"}, {"lobe2.f0", "kd"}, {"f0", NULL}};
    const ff_constraints c = {.n_ties = 4, .tie = tie};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    ff_problem *p = NULL;
    ff_model m = s.model;
    ff_layout l;
    ff_ties ties;
    ff_normal n;
    FF_CHECK(ff_problem_make(&t, &m, 1, &o, &p, NULL) == FF_OK, "problem");
    FF_CHECK(ff_constraints_apply(&c, FF_SHAPE_CORRELATED, &m, &ties, NULL) == FF_OK, "ties");
    FF_CHECK(ff_layout_init(&m, 3, FF_SHAPE_CORRELATED, 0, &l, NULL) == FF_OK, "layout");
    ff_layout_tie(&l, &ties);
    FF_CHECK(l.n_columns == 6 + 3 * 3 && l.P == 4 + 1 + 3 && ff_layout_normal(&l, &n) == FF_OK, "%zu coordinates of %zu columns",
             l.P, l.n_columns);
    enum { P = 8 };
    double shape[FF_MAX_SHAPE], channel[FIT_CHANNELS * FF_MAX_CHANNEL_PARAMS], x[P], back[P], slope[P], g[P], H[P * P];
    memcpy(shape, s.shape, sizeof shape);
    memcpy(channel, s.channel, sizeof channel);
    ff_layout_project(&l, shape, channel);
    ff_layout_pack(&l, shape, channel, x);
    ff_layout_slope(&l, shape, channel, slope);
    for (size_t k = 0; k < P; k++) {
        size_t at;
        const ff_model_param *q = ff_layout_param(&l, k, &at);
        const int is_shape = q >= m.shape && q < m.shape + m.n_shape;
        const double v = is_shape ? shape[q - m.shape] : channel[at * m.n_channel + (size_t)(q - m.channel)];
        FF_CHECK_CLOSE(ff_coordinate_value(q->info, x[k]), v, 1e-14, 0);
        FF_CHECK(slope[k] == ff_coordinate_slope(q->info, v), "slope of %s", q->name);
        x[k] += 0.01 * (double)(k + 1);
    }
    ff_layout_unpack(&l, x, shape, channel);
    ff_layout_pack(&l, shape, channel, back);
    for (size_t k = 0; k < P; k++) FF_CHECK_CLOSE(back[k], x[k], 1e-14, 0);
    FF_CHECK(shape[0] == shape[1] && shape[2] == shape[m.lobe[1].shape0 + 2] && shape[0] != shape[m.lobe[1].shape0],
             "shapes are tied");
    for (size_t i = 0; i < 3; i++)
        FF_CHECK(channel[i * m.n_channel] == channel[0] &&
                     channel[i * m.n_channel + m.lobe[1].channel0] == channel[i * m.n_channel + m.base[0].channel0],
                 "channels are tied");
    FF_CHECK(channel[m.base[0].channel0] != channel[m.n_channel + m.base[0].channel0], "kd is not one");
    double cost[3];
    for (size_t k = 0; k < P; k++)
        for (int side = 0; side < 3; side++) {
            ff_pass pass;
            double at[P];
            memcpy(at, x, sizeof at);
            at[k] += 1e-4 * (side - 1);
            ff_layout_unpack(&l, at, shape, channel);
            FF_CHECK(pass_of(&l, p, &o, shape, channel, &pass) == FF_OK && ff_pass_run(&pass, 0, &n) == FF_OK, "pass");
            cost[side] = n.cost2;
            if (k == 0 && side == 1) {
                ff_layout_slope(&l, shape, channel, slope);
                assemble(&l, &n, slope, H, g);
            }
            ff_pass_free(&pass);
            if (side < 2) continue;
            const double by_differences = (cost[2] - cost[0]) / 4e-4;
            if (k == 0) memcpy(back, g, sizeof back);
            FF_CHECK(fabs(back[k] - by_differences) <= 1e-5 * sqrt(H[k * P + k] * cost[1]),
                     "coordinate %zu: slope %.9g, by differences %.9g", k, back[k], by_differences);
        }
    check_fold(&l, p, &o, shape, channel);
    ff_normal_free(&n);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Lobes of one kind keep an order, unless something was said of one of them. */
static void order_of_lobes(void)
{
    const fit_surface s = fit_surface_make("ggx+ggx", 1, "alpha=0.1 lobe2.alpha=0.5 f0=0.3 lobe2.f0=0.4");
    const fit_sampling how = {.n = 3000, .max_theta = 75, .noise = 0.02, .glossy = 0.3, .seed = 5};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    const ff_tie tie = {"lobe2.f0", "f0"};
    const ff_bound wide_first[] = {{"alpha", 0.3, 1, NULL}, {"lobe2.alpha", 0.02, 0.25, NULL}};
    const ff_prior prior = {"alpha", 0.5, 0.05, NULL};
    const ff_constraints ties = {.n_ties = 1, .tie = &tie}, bounds = {.n_bounds = 2, .bound = wide_first},
                         priors = {.n_priors = 1, .prior = &prior};
    o.constraints = &ties;
    ff_fit_result r = fitted("tied", &t, &s.model, &o);
    FF_CHECK(r.shape_value[0].value < 0.2 && value_of(&r, "lobe2.alpha_x", 0)->value > 0.3, "the narrower lobe is not the first");
    ff_fit_result_clear(&r);
    /* a prior of what they share tells nothing apart */
    const ff_prior of_both = {"f0", 0.3, 0.1, NULL};
    const ff_constraints shared = {.n_ties = 1, .tie = &tie, .n_priors = 1, .prior = &of_both};
    o.constraints = &shared;
    r = fitted("tied with a prior", &t, &s.model, &o);
    FF_CHECK(r.shape_value[0].value < 0.2 && value_of(&r, "lobe2.alpha_x", 0)->value > 0.3, "the narrower lobe is not the first");
    ff_fit_result_clear(&r);
    o.constraints = &bounds;
    r = fitted("bounded", &t, &s.model, &o);
    FF_CHECK_CLOSE(r.shape_value[0].value, 0.5, 0.05, 0);
    FF_CHECK_CLOSE(value_of(&r, "lobe2.alpha_x", 0)->value, 0.1, 0.05, 0);
    ff_fit_result_clear(&r);
    o.constraints = &priors;
    r = fitted("with a prior", &t, &s.model, &o);
    FF_CHECK_CLOSE(r.shape_value[0].value, 0.5, 0.05, 0);
    FF_CHECK_CLOSE(value_of(&r, "lobe2.alpha_x", 0)->value, 0.1, 0.05, 0);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* ---- priors ---------------------------------------------------------------------------------- */

/* A model that is linear in f0 and kd, its shape held: data, columns, and the estimates by hand. */
typedef struct linear_case {
    fit_surface s;
    ff_table t;
    double H[3], g[2]; /* J^T J, J^T y: 00, 01, 11 */
    double value[2], V[3], noise[2];
    size_t n;
    double *a, *b, *y; /* [n] columns, data */
} linear_case;

static void solve2(const double A[3], const double b[2], double x[2])
{
    const double d = A[0] * A[2] - A[1] * A[1];
    x[0] = (A[2] * b[0] - A[1] * b[1]) / d;
    x[1] = (A[0] * b[1] - A[1] * b[0]) / d;
}

/* A^-1 M A^-1 */
static void sandwich2(const double A[3], const double M[3], double V[3])
{
    const double d = A[0] * A[2] - A[1] * A[1], i[3] = {A[2] / d, -A[1] / d, A[0] / d};
    const double a = i[0] * M[0] + i[1] * M[1], b = i[0] * M[1] + i[1] * M[2], c = i[1] * M[0] + i[2] * M[1],
                 e = i[1] * M[1] + i[2] * M[2];
    V[0] = a * i[0] + b * i[1];
    V[1] = a * i[1] + b * i[2];
    V[2] = c * i[1] + e * i[2];
}

/* Outer products of the scores at x, with the factor for the parameters that were found; with sigma weights J^T J. */
static void products2(const linear_case *l, int sigma, const double x[2], double M[3])
{
    const double n = (double)l->n, factor = n / (n - 1) * (n - 1) / (n - 2);
    memcpy(M, l->H, sizeof l->H);
    if (sigma) return;
    M[0] = M[1] = M[2] = 0;
    for (size_t i = 0; i < l->n; i++) {
        const double r2 = factor * pow(l->a[i] * x[0] + l->b[i] * x[1] - l->y[i], 2);
        M[0] += r2 * l->a[i] * l->a[i], M[1] += r2 * l->a[i] * l->b[i], M[2] += r2 * l->b[i] * l->b[i];
    }
}

/* sigma: weights 1 / sigma^2 instead of 1. */
static linear_case linear_make(int sigma, uint64_t seed)
{
    linear_case l = {.s = fit_surface_make("ggx+lambert", 1, "alpha=0.3 f0=0.5 kd=0.3"), .n = 2000};
    const fit_sampling how = {.n = l.n, .max_theta = 75, .noise = 0.1, .sigma = sigma, .seed = seed};
    l.t = fit_measure(&l.s, &how);
    const uint32_t m = l.s.model.n_shape + l.s.model.n_channel;
    double *w[6], *plane = malloc((10 + m) * l.n * sizeof *plane), *f = plane + 9 * l.n, M[3];
    if (!plane) exit(1);
    for (size_t k = 0; k < 6; k++) w[k] = plane + (3 + k) * l.n;
    l.a = plane, l.b = plane + l.n, l.y = plane + 2 * l.n;
    ff_table_directions(&l.t, 0, l.n, w);
    const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
    l.s.channel[0] = l.s.channel[2] = 0; /* f of f0 = kd = 0, and the columns */
    if (ff_model_eval(&l.s.model, FF_ISA_BEST, 1, l.s.shape, l.s.channel, &dirs, l.n, f, f + l.n, l.n)) exit(1);
    const double *by_f0 = f + (1 + l.s.model.n_shape) * l.n, *by_kd = by_f0 + 2 * l.n;
    for (size_t i = 0; i < l.n; i++) {
        const double x = dirs.wiz[i], weight = sigma ? 1 / (l.t.sigma[i] * x) : 1;
        const double a = l.a[i] = x * weight * by_f0[i], b = l.b[i] = x * weight * by_kd[i],
                     y = l.y[i] = x * weight * (l.t.value[i] - f[i]);
        l.H[0] += a * a, l.H[1] += a * b, l.H[2] += b * b, l.g[0] += a * y, l.g[1] += b * y;
    }
    solve2(l.H, l.g, l.value);
    products2(&l, sigma, l.value, M);
    sandwich2(l.H, M, l.V);
    const double d = l.H[0] * l.H[2] - l.H[1] * l.H[1];
    l.noise[0] = l.V[0] / (l.H[2] / d);
    l.noise[1] = l.V[2] / (l.H[0] / d);
    return l;
}

static void prior_by_hand(void)
{
    for (int sigma = 0; sigma < 2; sigma++) {
        linear_case l = linear_make(sigma, 8);
        ff_fit_options o = by_residuals();
        o.shape = FF_SHAPE_ISOTROPIC;
        ff_model m = l.s.model;
        ff_model_hold(&m, "alpha", 0.3, NULL);
        ff_fit_result r = fitted("without a prior", &l.t, &m, &o);
        FF_CHECK_CLOSE(r.channel_value[0].value, l.value[0], 1e-7, 0);
        FF_CHECK_CLOSE(r.channel_value[2].value, l.value[1], 1e-7, 0);
        FF_CHECK_CLOSE(r.channel_value[0].std_error, sqrt(l.V[0]), sigma ? 1e-6 : 0.02, 0);
        FF_CHECK(isnan(r.channel_value[0].prior_sd) && r.prior_penalty == 0, "a prior that nobody gave");
        const double error[2] = {r.channel_value[0].std_error, r.channel_value[2].std_error};
        for (int k = 0; k < 2; k++) l.noise[k] *= pow(error[k], 2) / l.V[2 * k]; /* by so much errors from few samples are wider */
        ff_fit_result_clear(&r);
        /* one, then two, as sure as the data */
        const ff_prior prior[2] = {{"f0", l.value[0] + 2 * error[0], error[0], NULL},
                                   {"kd", l.value[1] - error[1], 0.7 * error[1], NULL}};
        for (size_t n = 1; n <= 2; n++) {
            double A[3], M[3], b[2], x[2], V[3], weight[2];
            memcpy(A, l.H, sizeof A);
            memcpy(b, l.g, sizeof b);
            for (size_t k = 0; k < n; k++) {
                weight[k] = l.noise[k] / (prior[k].sd * prior[k].sd);
                A[2 * k] += weight[k];
                b[k] += weight[k] * prior[k].mean;
            }
            solve2(A, b, x);
            products2(&l, sigma, x, M);
            for (size_t k = 0; k < n; k++) M[2 * k] += weight[k] * l.noise[k];
            sandwich2(A, M, V);
            const ff_constraints c = {.n_priors = n, .prior = prior};
            o.constraints = &c;
            r = fitted("with priors", &l.t, &m, &o);
            FF_CHECK_CLOSE(r.channel_value[0].value, x[0], 1e-7, 0);
            FF_CHECK_CLOSE(r.channel_value[2].value, x[1], 1e-7, 0);
            FF_CHECK_CLOSE(r.channel_value[0].std_error, sqrt(V[0]), sigma ? 1e-6 : 0.02, 0);
            FF_CHECK_CLOSE(r.channel_value[2].std_error, sqrt(V[2]), sigma ? 1e-6 : 0.02, 0);
            FF_CHECK(r.channel_value[0].prior_mean == prior[0].mean && r.channel_value[0].prior_sd == prior[0].sd &&
                         r.prior_penalty > 0,
                     "the prior is not reported");
            if (n == 1) { /* by inverse variances */
                FF_CHECK_CLOSE(r.channel_value[0].value, l.value[0] + error[0], 1e-6, 0);
                FF_CHECK_CLOSE(r.channel_value[0].std_error, error[0] / sqrt(2), 0.03, 0);
            }
            FF_CHECK(!has_warning(&r, FF_WARNING_PRIOR_DISAGREES, NULL), "a prior of 2 standard deviations is no disagreement");
            ff_fit_result_clear(&r);
        }
        ff_table_clear(&l.t);
        free(l.a);
    }
}

/* Three errors of the difference, which both have a part in: of a prior that is sure, as unsure as the data, or weak, which hardly
 * moves anything and may be as wrong. */
static void priors_that_data_contradict(void)
{
    linear_case l = linear_make(0, 8);
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_model m = l.s.model;
    ff_model_hold(&m, "alpha", 0.3, NULL);
    ff_fit_result plain = fitted("without a prior", &l.t, &m, &o);
    const double alone = plain.channel_value[0].value, error = plain.channel_value[0].std_error;
    static const double sureness[] = {0.1, 1, 10};
    for (size_t k = 0; k < 3; k++)
        for (int apart = -1; apart <= 1; apart += 2)
            for (int more = 0; more < 2; more++) {
                const double sd = sureness[k] * error, off = (more ? 3.1 : 2.9) * hypot(error, sd);
                const ff_prior prior = {"f0", alone + apart * off, sd, NULL};
                const ff_constraints c = {.n_priors = 1, .prior = &prior};
                o.constraints = &c;
                ff_fit_result r = fitted("with a prior", &l.t, &m, &o);
                FF_CHECK(has_warning(&r, FF_WARNING_PRIOR_DISAGREES, "f0") == more,
                         "a prior of %g errors of the data, %g joint errors away: %s", sureness[k], more ? 3.1 : 2.9,
                         more ? "not a word" : "a warning");
                FF_CHECK(!has_warning(&r, FF_WARNING_PRIOR_DISAGREES, "kd"), "kd has no prior");
                ff_fit_result_clear(&r);
            }
    ff_fit_result_clear(&plain);
    ff_table_clear(&l.t);
    free(l.a);
}

static void priors_in_their_limits(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 2, "alpha_x=0.2 alpha_y=0.4 r_xy=0.3 f0=0.6:0.3 kd=0.1:0.3");
    const fit_sampling how = {.n = 3000, .max_theta = 75, .noise = 0.05, .seed = 12};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    ff_fit_result plain = fitted("no prior", &t, &s.model, &o);
    ff_prior prior[] = {{"alpha", 0.3, 1e6, NULL}, {"f0", 0.5, 1e6, NULL}};
    const ff_constraints c = {.n_priors = 2, .prior = prior};
    o.constraints = &c;
    ff_fit_result r = fitted("a prior that says nothing", &t, &s.model, &o);
    for (size_t k = 0; k < 3; k++) check_same("sd large", &r.shape_value[k], &plain.shape_value[k], 1e-3);
    for (size_t k = 0; k < 2 * r.model.n_channel; k++)
        if (!r.channel_value[k].held) check_same("sd large", &r.channel_value[k], &plain.channel_value[k], 1e-3);
    ff_fit_result_clear(&r);
    /* a prior that leaves no doubt holds the parameter; the others are those of a fit with it held */
    prior[0] = (ff_prior){"alpha_x", 0.23, 1e-7, NULL};
    prior[1] = (ff_prior){"f0", 0.5, 1e-7, NULL};
    r = fitted("a prior that is certain", &t, &s.model, &o);
    FF_CHECK_CLOSE(r.shape_value[0].value, 0.23, 0, 1e-7);
    FF_CHECK_CLOSE(r.shape_value[0].std_error, 1e-7, 1e-3, 0);
    FF_CHECK(has_warning(&r, FF_WARNING_PRIOR_DISAGREES, "alpha_x"), "alpha_x moved without a word");
    FF_CHECK(has_warning(&r, FF_WARNING_PRIOR_DISAGREES, "f0"), "f0 moved without a word");
    ff_model held = s.model;
    ff_model_hold(&held, "alpha_x", 0.23, NULL);
    ff_model_hold(&held, "f0", 0.5, NULL);
    o.constraints = NULL;
    ff_fit_result same = fitted("held", &t, &held, &o);
    for (size_t k = 1; k < 3; k++) check_same("sd small", &r.shape_value[k], &same.shape_value[k], 1e-2);
    for (size_t i = 0; i < 2; i++) check_same("sd small", value_of(&r, "kd", i), value_of(&same, "kd", i), 1e-2);
    ff_fit_result_clear(&same);
    ff_fit_result_clear(&r);
    ff_fit_result_clear(&plain);
    ff_table_clear(&t);
}

/* Near the mirror direction and the normal the data show ks f0 alone: the prior decides how much is which. */
static void prior_for_what_the_data_do_not_say(void)
{
    const fit_surface s = fit_surface_make("ggx", 1, "alpha=0.1 f0=0.5");
    const fit_sampling how = {.n = 2000, .max_theta = 12, .noise = 0.01, .seed = 14};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_model m = s.model;
    ff_model_vary(&m, "ks", NULL);
    const ff_prior prior = {"ks", 1.25, 0.05, NULL};
    const ff_constraints c = {.n_priors = 1, .prior = &prior};
    o.constraints = &c;
    ff_fit_result r = fitted("f0 and ks", &t, &m, &o);
    FF_CHECK_CLOSE(r.channel_value[1].value, 1.25, 0, 0.01);
    FF_CHECK_CLOSE(r.channel_value[1].std_error, 0.05, 0.1, 0);
    FF_CHECK_CLOSE(r.channel_value[0].value, 0.4, 0, 0.01);
    FF_CHECK_CLOSE(r.channel_value[0].std_error, 0.4 * 0.05 / 1.25, 0.1, 0);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* Over many measurements, each with a prior whose mean is as far off as its sd says, the truth lies in the intervals as often as
 * they say, which are narrower than without. */
static void cover_with_a_prior(const char *what, const fit_sampling *sampling, double sd)
{
    const int repeats = fit_repeats(200, 600); /* the bounds: four standard deviations of a binomial and of a mean of squares */
    const double around = 4 * sqrt(0.95 * 0.05 / repeats), around_square = 4 * sqrt(2.0 / repeats);
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.3 f0=0.5 kd=0.2");
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    uint64_t state = ff_test_stream("prior %s", what);
    double sum_z2[3] = {0}, plain_z2 = 0, gain = 0;
    int inside[3] = {0};
    for (uint64_t i = 0; i < (uint64_t)repeats; i++) {
        fit_sampling how = *sampling;
        how.seed = 700 + i;
        ff_table t = fit_measure(&s, &how);
        o.constraints = NULL;
        ff_fit_result plain = fitted("without", &t, &s.model, &o);
        const ff_prior prior = {"f0", 0.5 + sd * fit_normal(&state), sd, NULL};
        const ff_constraints c = {.n_priors = 1, .prior = &prior};
        o.constraints = &c;
        ff_fit_result r = fitted("with", &t, &s.model, &o);
        const ff_fit_value *v[3] = {&r.shape_value[0], value_of(&r, "f0", 0), value_of(&r, "kd", 0)};
        const double truth[3] = {0.3, 0.5, 0.2};
        for (int k = 0; k < 3; k++) {
            const double z = (v[k]->value - truth[k]) / v[k]->std_error;
            sum_z2[k] += z * z / repeats;
            inside[k] += fabs(z) < 1.959964;
        }
        plain_z2 += pow((value_of(&plain, "f0", 0)->value - 0.5) / value_of(&plain, "f0", 0)->std_error, 2) / repeats;
        gain += v[1]->std_error / value_of(&plain, "f0", 0)->std_error / repeats;
        ff_fit_result_clear(&r);
        ff_fit_result_clear(&plain);
        ff_table_clear(&t);
    }
    for (int k = 0; k < 3; k++) {
        printf("    %s, parameter %d: %.1f %% inside, rms of error / standard error %.3f\n", what, k, 100.0 * inside[k] / repeats,
               sqrt(sum_z2[k]));
        FF_CHECK(fabs(inside[k] - 0.95 * repeats) <= around * repeats, "parameter %d: %d of %d inside", k, inside[k], repeats);
        FF_CHECK(fabs(sum_z2[k] - 1) <= around_square, "parameter %d: mean square of error / standard error %.3f", k, sum_z2[k]);
    }
    printf("    standard error of f0 with the prior: %.3f of that without, where rms of error / standard error is %.3f\n", gain,
           sqrt(plain_z2));
    FF_CHECK(gain < 0.95 && gain > 0.3, "the prior changes the standard error by %.3f", gain);
}

static void standard_errors_with_a_prior(void)
{
    const fit_sampling by_sigma = {.n = 300, .max_theta = 75, .noise = 0.1, .sigma = 1},
                       by_residuals = {.n = 6000, .max_theta = 75, .noise = 0.1};
    cover_with_a_prior("standard deviations of the file", &by_sigma, 0.012);
    cover_with_a_prior("noise from the residuals", &by_residuals, 0.006);
}

/* ---- energy ---------------------------------------------------------------------------------- */

/* Albedos and derivatives against ff_albedo_directional and differences of it. */
static void albedo_derivatives(void)
{
    static const struct {
        const char *model, *set;
        ff_shape shape;
    } cases[] = {
        {"ggx+lambert", "alpha=0.3 f0=0.9:0.5 kd=0.2:0.1", FF_SHAPE_ISOTROPIC},
        {"ggx+lambert", "alpha_x=0.2 alpha_y=0.5 r_xy=0.4 f0=0.9:0.5 kd=0.2:0.1", FF_SHAPE_CORRELATED},
        {"beckmann/v-cavity/conductor+oren-nayar", "alpha_x=0.3 alpha_y=0.6 kd=0.3:0.2 eta=0.5:1 k=2:3", FF_SHAPE_AXIS},
        {"ggx+student-t/smith-height-correlated/shared", "alpha=0.2 lobe2.alpha=0.5 lobe2.weight=0.3 f0=0.6:0.3",
         FF_SHAPE_ISOTROPIC},
        {"ggx/smith-separable/dielectric+mikkelsen-coupled", "alpha=0.3 eta=1.5:1.8", FF_SHAPE_ISOTROPIC},
        {"ggx+kulla-conty", "alpha=0.6 f0=0.8:0.3", FF_SHAPE_ISOTROPIC},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        fit_surface s = fit_surface_make(cases[i].model, 2, cases[i].set);
        ff_layout l;
        FF_CHECK(ff_model_vary(&s.model, "ks", NULL) == FF_OK, "ks");
        FF_CHECK(ff_layout_init(&s.model, 2, cases[i].shape, 0, &l, NULL) == FF_OK, "%s", cases[i].model);
        double worst = 0, worst_slope = 0;
        const double mus[] = {1, 0.5, 0.06};
        for (size_t v = 0; v < 3; v++) {
            const double side = sqrt(1 - mus[v] * mus[v]), wo[3] = {side * cos(0.7), side * sin(0.7), mus[v]};
            const size_t size = 1 + l.free.n_shape + l.free.n_channel;
            double out[2 * 50];
            ff_albedo_parts *parts;
            FF_CHECK(ff_albedo_parts_make(&s.model, ff_kernels_get(FF_ISA_BEST), l.mode, 2, s.shape, s.channel, &l.free, &parts) ==
                         FF_OK,
                     "parts");
            ff_block_work *work = ff_block_work_new(1);
            FF_CHECK(work != NULL, "memory");
            ff_albedo_parts_at(parts, 8, wo, work, out);
            free(work);
            ff_albedo_parts_free(parts);
            ff_integral exact[2];
            FF_CHECK(ff_albedo_directional(&s.model, FF_ISA_BEST, 2, s.shape, s.channel, wo, exact, NULL) == FF_OK, "albedo");
            for (size_t c = 0; c < 2; c++) {
                worst = fmax(worst, fabs(out[c * size] - exact[c].value));
                for (size_t k = 0; k + 1 < size; k++) {
                    fit_surface near = s;
                    const int shared = k < l.free.n_shape;
                    double *p = shared ? &near.shape[l.free.shape[k]]
                                       : &near.channel[c * s.model.n_channel + l.free.channel[k - l.free.n_shape]];
                    const double middle = *p, step = 1e-3;
                    ff_integral side_value[4][2];
                    static const double at[4] = {-2, -1, 1, 2};
                    for (int j = 0; j < 4; j++) {
                        *p = middle + at[j] * step;
                        if (shared && l.free.tied[k]) p[1] = p[0];
                        FF_CHECK(ff_albedo_directional(&near.model, FF_ISA_BEST, 2, near.shape, near.channel, wo, side_value[j],
                                                       NULL) == FF_OK,
                                 "albedo");
                    }
                    const double slope = (side_value[0][c].value - 8 * side_value[1][c].value + 8 * side_value[2][c].value -
                                          side_value[3][c].value) /
                                         (12 * step);
                    worst_slope = fmax(worst_slope, fabs(out[c * size + 1 + k] - slope));
                    FF_CHECK(fabs(out[c * size + 1 + k] - slope) < 3e-5 * fmax(1, fabs(slope)),
                             "%s, cosine %g, channel %zu: column %zu is %.9g, by differences %.9g", cases[i].model, mus[v], c, k,
                             out[c * size + 1 + k], slope);
                }
            }
        }
        printf("    %-50s albedo within %.1e, derivatives within %.1e\n", cases[i].model, worst, worst_slope);
        FF_CHECK(worst < 1e-5, "%s: albedo off by %.3g", cases[i].model, worst);
    }
}

/* The largest albedo over views from the normal to 89.94 degrees. */
static double largest_albedo(const ff_fit_result *r, int n, int turns)
{
    double shape[FF_MAX_SHAPE], channel[FIT_CHANNELS * FF_MAX_CHANNEL_PARAMS], most = 0;
    for (size_t k = 0; k < r->model.n_shape; k++) shape[k] = r->shape_value[k].value;
    for (size_t k = 0; k < r->n_channels * r->model.n_channel; k++) channel[k] = r->channel_value[k].value;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < turns; j++) {
            const double mu = pow(1 - 0.9 * i / (n - 1), 3), side = sqrt((1 - mu) * (1 + mu)), phi = 180 * FIT_DEGREE * j / turns;
            const double wo[3] = {side * cos(phi), side * sin(phi), mu};
            ff_integral a[FIT_CHANNELS];
            if (ff_albedo_directional(&r->model, FF_ISA_BEST, r->n_channels, shape, channel, wo, a, NULL)) exit(1);
            for (size_t c = 0; c < r->n_channels; c++) most = fmax(most, a[c].value);
        }
    return most;
}

static void energy_is_conserved(void)
{
    static const struct {
        const char *model, *set, *free_name;
        size_t n_channels;
        ff_shape shape;
        double scale; /* of the data */
    } cases[] = {
        {"ggx+lambert", "alpha=0.3 f0=0.9:0.2:0.6 kd=0.4:0.5:0.1", NULL, 3, FF_SHAPE_ISOTROPIC, 1},
        {"ggx", "alpha=0.2 f0=1", "ks", 1, FF_SHAPE_ISOTROPIC, 1.3},
        {"beckmann+lambert", "alpha=0.4 f0=1 kd=0.3", "ks", 1, FF_SHAPE_ISOTROPIC, 1.3},
        {"ggx+lambert", "alpha_x=0.15 alpha_y=0.5 r_xy=0.4 f0=0.8 kd=0.5", NULL, 1, FF_SHAPE_CORRELATED, 1},
        {"ggx+beckmann", "alpha=0.15 lobe2.alpha=0.5 f0=0.6:0.4 lobe2.f0=0.5:0.5", "ks", 2, FF_SHAPE_ISOTROPIC, 1},
        {"ggx/smith-separable/dielectric+lambert", "alpha=0.15 eta=1.5 kd=0.9", NULL, 1, FF_SHAPE_ISOTROPIC, 1},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const fit_surface s = fit_surface_make(cases[i].model, cases[i].n_channels, cases[i].set);
        const fit_sampling how = {.n = 4000, .max_theta = 75, .noise = 0.03, .glossy = 0.3, .seed = 60 + i};
        ff_table t = fit_measure(&s, &how);
        for (size_t k = 0; k < t.n * t.n_channels; k++) t.value[k] *= cases[i].scale;
        ff_fit_options o = by_residuals();
        o.shape = cases[i].shape;
        ff_model m = s.model;
        if (cases[i].free_name) ff_model_vary(&m, cases[i].free_name, NULL);
        ff_fit_result plain = fitted(cases[i].model, &t, &m, &o);
        const ff_constraints c = {.energy_conserving = 1};
        o.constraints = &c;
        ff_fit_result r = fitted(cases[i].model, &t, &m, &o);
        const int turns = cases[i].shape == FF_SHAPE_ISOTROPIC ? 1 : 6;
        const double before = largest_albedo(&plain, 6, 1), after = largest_albedo(&r, turns > 1 ? 15 : 30, turns);
        printf("    %-54s albedo %.4f, conserving %.6f, objective times %.3f, %d passes, %.0f ms\n", cases[i].model, before, after,
               r.residual.objective / plain.residual.objective, r.passes, 1e3 * r.time_s);
        FF_CHECK(before > 1.02, "%s: the data alone do not ask for too much (%g)", cases[i].model, before);
        FF_CHECK(after <= 1 + 1e-4, "%s: albedo %.8f", cases[i].model, after);
        FF_CHECK(after >= 1 - (turns > 1 ? 3e-3 : 1e-4), "%s: albedo %.8f, less than was asked", cases[i].model, after);
        FF_CHECK(r.residual.objective >= plain.residual.objective && has_warning(&r, FF_WARNING_ALBEDO_ABOVE_ONE, NULL),
                 "%s: nothing is said of it", cases[i].model);
        ff_fit_result_clear(&plain);
        ff_fit_result_clear(&r);
        ff_table_clear(&t);
    }
}

/* With the shape held there are two parameters: for each f0 the largest kd that the albedo of the lobe leaves. */
static void energy_against_brute_force(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.3 f0=0.6 kd=0.6");
    const fit_sampling how = {.n = 2000, .max_theta = 75, .noise = 0.03, .seed = 71};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_model m = s.model;
    ff_model_hold(&m, "alpha", 0.3, NULL);
    const ff_constraints c = {.energy_conserving = 1};
    o.constraints = &c;
    ff_fit_result r = fitted("conserving", &t, &m, &o);
    o.constraints = NULL;
    double best = INFINITY, best_f0 = 0, best_kd = 0;
    for (int i = 0; i <= 40; i++) {
        const double f0 = 0.55 + 0.1 * i / 40;
        ff_model held = m;
        ff_model_hold(&held, "f0", f0, NULL);
        ff_model lobe = held;
        ff_model_hold(&lobe, "kd", 0, NULL);
        ff_fit_result at = fitted("lobe", &t, &lobe, &o);
        const double room = 1 - largest_albedo(&at, 6, 1);
        ff_fit_result_clear(&at);
        if (room < 1e-3) continue;
        ff_model_bound(&held, "kd", 0, room, NULL);
        at = fitted("held", &t, &held, &o);
        if (at.residual.objective < best) best = at.residual.objective, best_f0 = f0, best_kd = value_of(&at, "kd", 0)->value;
        ff_fit_result_clear(&at);
    }
    const ff_fit_value *f0 = value_of(&r, "f0", 0), *kd = value_of(&r, "kd", 0);
    printf("    f0 %.4f, kd %.4f, by brute force %.4f, %.4f; objective %.6g, %.6g\n", f0->value, kd->value, best_f0, best_kd,
           r.residual.objective, best);
    FF_CHECK_CLOSE(f0->value, best_f0, 0, 4e-3);
    FF_CHECK_CLOSE(kd->value, best_kd, 0, 4e-3);
    FF_CHECK_CLOSE(r.residual.objective, best, 1e-3, 0);
    FF_CHECK(f0->std_error > 0 && kd->std_error > 0 && r.correlation[1] < -0.99,
             "along the constraint f0 and kd move together: errors %g, %g, correlation %g", f0->std_error, kd->std_error,
             r.correlation[1]);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* Where the data ask for nothing impossible, nothing changes, to the last bit. */
static void energy_that_does_not_bind(void)
{
    const fit_surface s = fit_surface_make("ggx", 2, "alpha=0.3 f0=0.6:0.3");
    const fit_sampling how = {.n = 2000, .max_theta = 75, .noise = 0.03, .seed = 72};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    ff_fit_result plain = fitted("plain", &t, &s.model, &o);
    const ff_constraints c = {.energy_conserving = 1};
    o.constraints = &c;
    ff_fit_result r = fitted("conserving", &t, &s.model, &o);
    for (size_t k = 0; k < r.model.n_shape; k++)
        FF_CHECK(r.shape_value[k].value == plain.shape_value[k].value, "shape %zu moved", k);
    for (size_t k = 0; k < 2 * r.model.n_channel; k++)
        FF_CHECK(r.channel_value[k].value == plain.channel_value[k].value, "channel parameter %zu moved", k);
    FF_CHECK(r.residual.objective == plain.residual.objective && r.warnings.n == plain.warnings.n && r.passes == plain.passes,
             "something else happened: %d passes, %d without", r.passes, plain.passes);
    ff_fit_result_clear(&r);
    ff_fit_result_clear(&plain);
    ff_table_clear(&t);
}

/* ---- what makes no sense --------------------------------------------------------------------- */

static void refused(const char *model, const ff_constraints *c, ff_status expected, const char *words)
{
    ff_error err = {0};
    ff_model m;
    if (ff_model_parse(model, &m, NULL)) exit(1);
    const ff_status status = ff_constraints_check(c, &m, &err);
    FF_CHECK(status == expected && strstr(err.message, words), "%s: status %d, '%s', expected %d and '%s'", model, (int)status,
             err.message, (int)expected, words);
}

static void errors(void)
{
    refused("ggx", &(ff_constraints){.n_bounds = 1, .bound = &(ff_bound){"kd", 0, 1, NULL}}, FF_ERR_UNKNOWN, "no parameter 'kd'");
    refused("ggx", &(ff_constraints){.n_bounds = 1, .bound = &(ff_bound){"f0", 0.5, 0.2, NULL}}, FF_ERR_RANGE, "must rise");
    refused("ggx", &(ff_constraints){.n_priors = 1, .prior = &(ff_prior){"kd", 0, 1, NULL}}, FF_ERR_UNKNOWN, "no parameter 'kd'");
    refused("ggx", &(ff_constraints){.n_priors = 1, .prior = &(ff_prior){"f0", 0.5, 0, NULL}}, FF_ERR_RANGE, "above 0");
    refused("ggx", &(ff_constraints){.n_priors = 1, .prior = &(ff_prior){"f0", NAN, 1, NULL}}, FF_ERR_RANGE, "finite");
    const ff_prior twice[] = {{"f0", 0.5, 1, NULL}, {"f0", 0.4, 1, NULL}};
    refused("ggx", &(ff_constraints){.n_priors = 2, .prior = twice}, FF_ERR_UNSUPPORTED, "two priors");
    refused("ggx", &(ff_constraints){.n_ties = 1, .tie = &(ff_tie){"f0", "kd"}}, FF_ERR_UNKNOWN, "no parameter 'kd'");
    refused("ggx", &(ff_constraints){.n_ties = 1, .tie = &(ff_tie){"f0", "alpha_x"}}, FF_ERR_UNSUPPORTED, "for each channel");
    refused("ggx", &(ff_constraints){.n_ties = 1, .tie = &(ff_tie){"alpha_x", "r_xy"}}, FF_ERR_UNSUPPORTED,
            "different coordinates");
    refused("ggx", &(ff_constraints){.n_ties = 1, .tie = &(ff_tie){"r_xy", "alpha"}}, FF_ERR_UNSUPPORTED, "two axes");
    refused("ggx", &(ff_constraints){.n_ties = 1, .tie = &(ff_tie){"alpha_x", NULL}}, FF_ERR_UNSUPPORTED, "as it is");
    refused("ggx/none", &(ff_constraints){.energy_conserving = 1}, FF_ERR_UNSUPPORTED, "without bound");
    const ff_bound apart[] = {{"f0", 0, 0.2, NULL}, {"lobe2.f0", 0.3, 1, NULL}};
    refused("ggx+ggx", &(ff_constraints){.n_bounds = 2, .bound = apart, .n_ties = 1, .tie = &(ff_tie){"lobe2.f0", "f0"}},
            FF_ERR_RANGE, "do not overlap");
    ff_model m;
    ff_error err = {0};
    ff_model_parse("ggx+ggx", &m, NULL);
    ff_model_hold(&m, "lobe2.f0", 0.3, NULL);
    const ff_constraints held = {.n_ties = 1, .tie = &(ff_tie){"lobe2.f0", "f0"}},
                         other = {.n_ties = 1, .tie = &(ff_tie){"f0", "lobe2.f0"}},
                         absent = {.n_ties = 1,
                                   .tie = &(ff_tie){"kd", "f0"},
                                   .n_priors = 1,
                                   .prior = &(ff_prior){"kd", 0.1, 0.1, NULL},
                                   .n_bounds = 1,
                                   .bound = &(ff_bound){"kd", 0, 0.5, NULL},
                                   .where_present = 1};
    FF_CHECK(ff_constraints_check(&held, &m, &err) == FF_ERR_UNSUPPORTED && strstr(err.message, "held at 0.3"), "%s", err.message);
    FF_CHECK(ff_constraints_check(&other, &m, &err) == FF_OK, "what follows a held parameter: %s", err.message);
    FF_CHECK(ff_constraints_check(&absent, &m, &err) == FF_OK, "where present: %s", err.message);
    /* the follower is held with what it follows, and a prior of it is said to do nothing */
    const fit_surface s = fit_surface_make("ggx+beckmann", 1, "alpha=0.1 lobe2.alpha=0.4 f0=0.3 lobe2.f0=0.3");
    const fit_sampling how = {.n = 1000, .max_theta = 70, .noise = 0.02, .glossy = 0.3, .seed = 2};
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = by_residuals();
    const ff_constraints both = {.n_ties = 1, .tie = other.tie, .n_priors = 1, .prior = &(ff_prior){"f0", 0.3, 0.1, NULL}};
    ff_model two = s.model;
    ff_model_hold(&two, "lobe2.f0", 0.31, NULL);
    o.constraints = &both;
    ff_fit_result r = fitted("held together", &t, &two, &o);
    FF_CHECK(value_of(&r, "f0", 0)->held && value_of(&r, "f0", 0)->value == 0.31, "f0 = %g", value_of(&r, "f0", 0)->value);
    FF_CHECK(has_warning(&r, FF_WARNING_PRIOR_WITHOUT_EFFECT, "f0"), "a prior without effect goes without a word");
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(bounds_of_a_model), FF_TEST(bounds_hold), FF_TEST(bounds_in_the_search), FF_TEST(what_is_held_stays),
             FF_TEST(two_axes_are_one), FF_TEST(ties_against_brute_force), FF_TEST(folded_least_squares),
             FF_TEST(coordinates_of_tied_parameters), FF_TEST(order_of_lobes), FF_TEST(prior_by_hand),
             FF_TEST(priors_that_data_contradict), FF_TEST(priors_in_their_limits), FF_TEST(prior_for_what_the_data_do_not_say),
             FF_TEST(standard_errors_with_a_prior), FF_TEST(albedo_derivatives), FF_TEST(energy_is_conserved),
             FF_TEST(energy_against_brute_force), FF_TEST(energy_that_does_not_bind), FF_TEST(errors))
