/* What is known of single channels: values that a parameter is held at by channel or in one of them, bounds and priors of one, each
 * against a second way to the same answer; with few channels and with so many that they are solved for one by one. */
#include "model_samples.h"
#include "warnings.h"
#include "fit/trust/trust_struct.h"

enum { MANY = 12 };

/* ---- one fit --------------------------------------------------------------------------------- */

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
    if (!v) exit(1);
    return v;
}

/* Is there a warning of a given upper bound at this value? */
static int is_on_given_bound(const ff_fit_result *r, double value)
{
    for (size_t k = 0; k < r->warnings.n; k++) {
        const ff_warning *w = &r->warnings.item[k];
        if (w->code == FF_WARNING_AT_BOUND && w->value[0] == value && w->value[1] > 0 && w->value[2] == 1) return 1;
    }
    return 0;
}

static void check_held(const char *what, const ff_fit_value *v, double value)
{
    FF_CHECK(v->held && v->value == value, "%s: %.17g, held %d; expected %.17g", what, v->value, v->held, value);
    FF_CHECK(!v->at_bound && isnan(v->std_error) && v->interval == FF_INTERVAL_NONE && v->column < 0, "%s has an error or a bound",
             what);
}

static void check_same(const char *what, const ff_fit_value *a, const ff_fit_value *b, double part)
{
    FF_CHECK(fabs(a->value - b->value) <= part * b->std_error + 1e-9, "%s: %.12g and %.12g +- %.2g", what, a->value, b->value,
             b->std_error);
}

/* A surface whose channels all differ. */
static fit_surface surface(const char *expression, size_t n_channels, const char *shape, const char *name, double from, double to)
{
    fit_surface s = fit_surface_make(expression, n_channels, shape);
    const ff_param_ref at = ff_model_param_find(&s.model, name);
    if (at.kind != FF_PARAM_CHANNEL) exit(1);
    for (size_t c = 0; c < n_channels; c++)
        s.channel[c * s.model.n_channel + at.index] = from + (to - from) * (double)c / (double)(n_channels - 1);
    return s;
}

static fit_sampling sampling(uint64_t seed)
{
    return (fit_sampling){.n = 2500, .max_theta = 75, .glossy = 0.4, .noise = 0.02, .seed = seed};
}

/* ---- values by channel ----------------------------------------------------------------------- */

/* Held at their optimum, the rest has the same optimum; held anywhere, they are there to the last bit. */
static void values_by_channel(size_t C)
{
    const fit_surface s = surface("ggx+lambert", C, "alpha=0.25 kd=0.2", "f0", 0.2, 0.8);
    const fit_sampling how = sampling(3 + C);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_fit_result all = fitted("free", &t, &s.model, &o);
    double value[MANY];
    for (size_t c = 0; c < C; c++) value[c] = value_of(&all, "f0", c)->value;
    const ff_fixed fixed = {"f0", C, value, NULL};
    const ff_constraints constraints = {.n_fixed = 1, .fixed = &fixed};
    o.constraints = &constraints;
    ff_fit_result r = fitted("at the optimum", &t, &s.model, &o);
    FF_CHECK_CLOSE(r.residual.objective, all.residual.objective, 1e-9, 0);
    FF_CHECK(r.n_free == all.n_free - C, "%zu free parameters, %zu without", r.n_free, all.n_free);
    check_same("alpha", value_of(&r, "alpha_x", 0), value_of(&all, "alpha_x", 0), 1e-3);
    for (size_t c = 0; c < C; c++) {
        check_held("f0", value_of(&r, "f0", c), value[c]);
        check_same("kd", value_of(&r, "kd", c), value_of(&all, "kd", c), 1e-3);
    }
    ff_fit_result_clear(&r);
    for (size_t c = 0; c < C; c++) value[c] = 0.3 + 0.01 * (double)c;
    r = fitted("elsewhere", &t, &s.model, &o);
    FF_CHECK(r.residual.objective > 1.5 * all.residual.objective, "other values fit as well");
    for (size_t c = 0; c < C; c++) check_held("f0 elsewhere", value_of(&r, "f0", c), value[c]);
    ff_fit_result_clear(&r);
    ff_fit_result_clear(&all);
    ff_table_clear(&t);
}

static void held_by_channel(void)
{
    values_by_channel(3);
}

static void held_by_channel_of_many(void)
{
    values_by_channel(MANY);
}

/* A value of one channel is one of all of them with the others where the fit finds them. */
static void value_of_one(size_t C, size_t dense)
{
    const fit_surface s = surface("ggx+lambert", C, "alpha=0.25 f0=0.5", "kd", 0.1, 0.5);
    const fit_sampling how = sampling(40 + C);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    const size_t last = C - 1;
    o.shape = FF_SHAPE_ISOTROPIC;
    o.dense_channels = dense;
    const double f0 = 0.45;
    double value[MANY];
    const ff_fixed one = {"f0", 1, &f0, t.channels[last].name}, every = {"f0", C, value, NULL};
    ff_constraints c = {.n_fixed = 1, .fixed = &one};
    o.constraints = &c;
    ff_fit_result r = fitted("one channel", &t, &s.model, &o);
    check_held("f0 of the last", value_of(&r, "f0", last), f0);
    for (size_t k = 0; k < C; k++) {
        value[k] = value_of(&r, "f0", k)->value;
        FF_CHECK(k == last || (!value_of(&r, "f0", k)->held && value_of(&r, "f0", k)->std_error > 0), "channel %zu is not free", k);
    }
    FF_CHECK(r.n_free == 1 + 2 * C - 1, "%zu free parameters", r.n_free);
    FF_CHECK(!has_warning(&r, FF_WARNING_AT_BOUND, NULL) && !has_warning(&r, FF_WARNING_NOT_DETERMINED, NULL), "a warning");
    c.fixed = &every;
    ff_fit_result same = fitted("all where they were", &t, &s.model, &o);
    FF_CHECK_CLOSE(same.residual.objective, r.residual.objective, 1e-9, 0);
    check_same("alpha", value_of(&r, "alpha_x", 0), value_of(&same, "alpha_x", 0), 2e-3);
    for (size_t k = 0; k < C; k++) check_same("kd", value_of(&r, "kd", k), value_of(&same, "kd", k), 2e-3);
    ff_fit_result_clear(&same);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

static void held_in_one_channel(void)
{
    value_of_one(3, FF_DENSE_CHANNELS);
}

static void held_in_one_of_many(void)
{
    value_of_one(3, 1);
    value_of_one(MANY, FF_DENSE_CHANNELS);
}

static void check_like(const char *what, const ff_fit_value *a, const ff_fit_value *b)
{
    const double width = b->high - b->low;
    FF_CHECK(a->interval == b->interval && a->at_bound == b->at_bound, "%s: intervals of kind %d and %d", what, (int)a->interval,
             (int)b->interval);
    FF_CHECK_CLOSE(a->value, b->value, 0, 1e-3 * width);
    FF_CHECK_CLOSE(a->low, b->low, 0, 2e-3 * width);
    FF_CHECK_CLOSE(a->high, b->high, 0, 2e-3 * width);
    if (!isnan(b->std_error)) FF_CHECK_CLOSE(a->std_error, b->std_error, 1e-3, 0);
}

/* Errors and intervals of the others, on a bound or not, do not know of a coordinate that stands still: they are those of a fit
 * whose model lacks it, and so are its profile and its refits. */
static void same_without_it(size_t dense)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.25 f0=0.5 kd=0.2");
    fit_sampling how = sampling(8);
    how.n = 800;
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options(), by_model = fit_options();
    const double f0 = 0.45;
    const ff_fixed one = {"f0", 1, &f0, t.channels[0].name};
    const ff_bound bound = {"kd", 0, 0.18, NULL};
    const ff_constraints c = {.n_fixed = 1, .fixed = &one, .n_bounds = 1, .bound = &bound},
                         c_model = {.n_bounds = 1, .bound = &bound};
    ff_model held = s.model;
    FF_CHECK(ff_model_hold(&held, "f0", f0, NULL) == FF_OK, "hold");
    o.shape = by_model.shape = FF_SHAPE_ISOTROPIC;
    o.dense_channels = by_model.dense_channels = dense;
    o.constraints = &c;
    by_model.constraints = &c_model;
    ff_problem *p = NULL;
    ff_fit_result r = {0}, m = {0};
    ff_error err = {0};
    FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, &err) == FF_OK && ff_problem_fit_into(p, &s.model, &o, &r, &err) == FF_OK &&
                 ff_problem_fit_into(p, &held, &by_model, &m, &err) == FF_OK,
             "%s", err.message);
    FF_CHECK_CLOSE(r.aic, m.aic, 1e-9, 1e-6);
    FF_CHECK(r.rank == m.rank && value_of(&m, "kd", 0)->at_bound == 1, "rank %zu and %zu", r.rank, m.rank);
    check_held("f0", value_of(&r, "f0", 0), f0);
    check_like("alpha", value_of(&r, "alpha_x", 0), value_of(&m, "alpha_x", 0));
    check_like("kd on its bound", value_of(&r, "kd", 0), value_of(&m, "kd", 0));
    if (dense) {
        FF_CHECK(ff_trust_profile(p, &o, &r, &err) == FF_OK && ff_trust_profile(p, &by_model, &m, &err) == FF_OK, "%s",
                 err.message);
        check_like("alpha by its profile", value_of(&r, "alpha_x", 0), value_of(&m, "alpha_x", 0));
        check_like("kd by its profile", value_of(&r, "kd", 0), value_of(&m, "kd", 0));
    }
    ff_fit_result_clear(&m);
    ff_fit_result_clear(&r);
    ff_problem_free(p);
    ff_table_clear(&t);
}

static void errors_without_it(void)
{
    same_without_it(FF_DENSE_CHANNELS);
    same_without_it(0);
}

/* Models that are searched for by a surrogate, and those with a free scale, hold them on the way too. */
static void conductor_with_known_eta(void)
{
    const double eta[3] = {0.2, 0.4, 1.4};
    fit_surface s = fit_surface_make("ggx/smith-height-correlated/conductor", 3, "alpha=0.2 eta=0.2:0.4:1.4 k=3.4:2.4:1.9");
    fit_sampling how = sampling(5);
    how.noise = 0.005;
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    const ff_fixed fixed[] = {{"eta", 3, eta, NULL}, {"k", 1, &(double){2.4}, t.channels[1].name}};
    for (size_t n = 1; n <= 2; n++) {
        const ff_constraints c = {.n_fixed = n, .fixed = fixed};
        o.constraints = &c;
        ff_fit_result r = fitted("conductor", &t, &s.model, &o);
        for (size_t k = 0; k < 3; k++) {
            const ff_fit_value *v = value_of(&r, "k", k);
            check_held("eta", value_of(&r, "eta", k), eta[k]);
            if (n == 2 && k == 1)
                check_held("k", v, 2.4);
            else
                FF_CHECK(fabs(v->value - (const double[]){3.4, 2.4, 1.9}[k]) < 5 * v->std_error, "k %g +- %g", v->value,
                         v->std_error);
        }
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

static void with_a_free_scale(void)
{
    fit_surface s = fit_surface_make("ggx+lambert", 3, "alpha=0.2 f0=0.2:0.4:0.6 ks=1.2 kd=0.1");
    const fit_sampling how = sampling(6);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    FF_CHECK(ff_model_vary(&s.model, "ks", NULL) == FF_OK, "free");
    const ff_fixed fixed = {"f0", 1, &(double){0.4}, t.channels[1].name};
    const ff_constraints c = {.n_fixed = 1, .fixed = &fixed};
    o.constraints = &c;
    ff_fit_result r = fitted("free scale", &t, &s.model, &o);
    check_held("f0", value_of(&r, "f0", 1), 0.4);
    const ff_fit_value *ks = value_of(&r, "ks", 1);
    FF_CHECK(fabs(ks->value - 1.2) < 4 * ks->std_error, "ks %g +- %g", ks->value, ks->std_error);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* ---- bounds and priors of one ---------------------------------------------------------------- */

static void bound_of_one(size_t C, size_t dense)
{
    const fit_surface s = surface("ggx+lambert", C, "alpha=0.25 f0=0.5", "kd", 0.2, 0.5);
    const fit_sampling how = sampling(70 + C);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    o.dense_channels = dense;
    ff_fit_result plain = fitted("no bounds", &t, &s.model, &o);
    const ff_bound wide = {"kd", 0, 0.9, t.channels[1].name}, narrow = {"kd", 0, 0.1, t.channels[1].name};
    ff_constraints c = {.n_bounds = 1, .bound = &wide};
    o.constraints = &c;
    ff_fit_result r = fitted("wide", &t, &s.model, &o);
    for (size_t k = 0; k < C; k++) check_same("wide", value_of(&r, "kd", k), value_of(&plain, "kd", k), 1e-3);
    ff_fit_result_clear(&r);
    c.bound = &narrow;
    r = fitted("narrow", &t, &s.model, &o);
    const ff_fit_value *v = value_of(&r, "kd", 1);
    FF_CHECK(v->value == 0.1 && v->at_bound == 1 && v->interval == FF_INTERVAL_ONE_SIDED, "kd %g, at bound %d", v->value,
             v->at_bound);
    for (size_t k = 0; k < C; k++)
        FF_CHECK(k == 1 || value_of(&r, "kd", k)->value > 0.15, "channel %zu is bounded too: %g", k, value_of(&r, "kd", k)->value);
    FF_CHECK(is_on_given_bound(&r, 0.1), "no word of the bound");
    /* the same as with the value held there */
    const ff_fixed fixed = {"kd", 1, &(double){0.1}, t.channels[1].name};
    const ff_constraints held = {.n_fixed = 1, .fixed = &fixed};
    o.constraints = &held;
    ff_fit_result at = fitted("held at the bound", &t, &s.model, &o);
    FF_CHECK_CLOSE(r.residual.objective, at.residual.objective, 1e-9, 0);
    ff_fit_result_clear(&at);
    ff_fit_result_clear(&r);
    ff_fit_result_clear(&plain);
    ff_table_clear(&t);
}

static void bounds_of_one_channel(void)
{
    bound_of_one(3, FF_DENSE_CHANNELS);
    bound_of_one(3, 1);
    bound_of_one(MANY, FF_DENSE_CHANNELS);
}

/* Different bounds of different channels are different words. */
static void bounds_of_two_channels(void)
{
    const fit_surface s = surface("ggx+lambert", 3, "alpha=0.25 f0=0.5", "kd", 0.2, 0.5);
    const fit_sampling how = sampling(75);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    const ff_bound two[] = {{"kd", 0, 0.1, t.channels[0].name}, {"kd", 0, 0.2, t.channels[2].name}};
    const ff_constraints c = {.n_bounds = 2, .bound = two};
    o.constraints = &c;
    ff_fit_result r = fitted("two bounds", &t, &s.model, &o);
    FF_CHECK(value_of(&r, "kd", 0)->value == 0.1 && value_of(&r, "kd", 2)->value == 0.2, "the bounds do not hold");
    FF_CHECK(is_on_given_bound(&r, 0.1) && is_on_given_bound(&r, 0.2), "no word of a bound");
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

static void prior_of_one_channel(void)
{
    const fit_surface s = surface("ggx+lambert", 3, "alpha=0.25 kd=0.2", "f0", 0.3, 0.6);
    const fit_sampling how = sampling(9);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    ff_fit_result plain = fitted("no prior", &t, &s.model, &o);
    const double sd = value_of(&plain, "f0", 1)->std_error, mean = value_of(&plain, "f0", 1)->value + 2 * sd;
    const ff_prior prior = {"f0", mean, sd, t.channels[1].name};
    const ff_constraints c = {.n_priors = 1, .prior = &prior};
    o.constraints = &c;
    ff_fit_result r = fitted("prior", &t, &s.model, &o);
    FF_CHECK_CLOSE(value_of(&r, "f0", 1)->value, mean - sd, 0, 0.1 * sd); /* half way, since both say as much */
    FF_CHECK(value_of(&r, "f0", 1)->prior_mean == mean && isnan(value_of(&r, "f0", 0)->prior_mean), "whose prior is it?");
    /* the prior says nothing of the others: they are where they would be with this one held at the value it has now */
    const ff_fixed held = {"f0", 1, &value_of(&r, "f0", 1)->value, t.channels[1].name};
    const ff_constraints there = {.n_fixed = 1, .fixed = &held};
    o.constraints = &there;
    ff_fit_result same = fitted("held", &t, &s.model, &o);
    const ff_fit_value *a = value_of(&r, "f0", 0), *b = value_of(&same, "f0", 0), *before = value_of(&plain, "f0", 0);
    FF_CHECK_CLOSE(a->value, b->value, 0, 1e-3 * before->std_error);
    FF_CHECK(fabs(a->value - before->value) > 0.05 * before->std_error, "the other channel stayed at %g", a->value);
    ff_fit_result_clear(&same);
    ff_fit_result_clear(&plain);
    ff_fit_result_clear(&r);
    ff_table_clear(&t);
}

/* ---- after the fit --------------------------------------------------------------------------- */

static void refits_keep_it(void)
{
    const fit_surface s = surface("ggx+lambert", 3, "alpha=0.25 kd=0.2", "f0", 0.3, 0.6);
    fit_sampling how = sampling(12);
    how.n = 600;
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    o.shape = FF_SHAPE_ISOTROPIC;
    const double values[3] = {0.1, 0.2, 0.3};
    const ff_fixed fixed[] = {{"f0", 1, &(double){0.4}, t.channels[1].name}, {"kd", 3, values, NULL}};
    const ff_constraints c = {.n_fixed = 2, .fixed = fixed};
    o.constraints = &c;
    ff_problem *p = NULL;
    ff_error err = {0};
    ff_fit_result r = {0};
    ff_places places;
    ff_bootstrap b;
    ff_cut_off cut = {0};
    FF_CHECK(ff_problem_make(&t, &s.model, 1, &o, &p, &err) == FF_OK && ff_problem_fit_into(p, &s.model, &o, &r, &err) == FF_OK,
             "%s", err.message);
    FF_CHECK(ff_places_init(p, &t, &places, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_trust_cut_off_into(p, &o, &r, 60 * FIT_DEGREE, &cut, &err) == FF_OK, "%s", err.message);
    FF_CHECK(ff_trust_profile(p, &o, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(value_of(&r, "f0", 0)->interval == FF_INTERVAL_PROFILE, "no profile of what is free");
    check_held("profile", value_of(&r, "f0", 1), 0.4);
    FF_CHECK(ff_trust_bootstrap_into(p, &places, &o, 30, 1, &r, &b, &err) == FF_OK, "%s", err.message);
    FF_CHECK(value_of(&r, "f0", 0)->interval == FF_INTERVAL_BOOTSTRAP, "no bootstrap of what is free");
    check_held("bootstrap", value_of(&r, "f0", 1), 0.4);
    for (size_t k = 0; k < 3; k++) check_held("bootstrap", value_of(&r, "kd", k), values[k]);
    ff_cut_off_clear(&cut);
    ff_places_clear(&places);
    ff_fit_result_clear(&r);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* Each channel alone takes what is its own. */
static void channels_alone(void)
{
    const fit_surface s = surface("ggx+lambert", 3, "alpha=0.25 kd=0.2", "f0", 0.3, 0.6);
    const fit_sampling how = sampling(13);
    ff_table t = fit_measure(&s, &how);
    ff_fit_options o = fit_options();
    const double values[3] = {0.3, 0.4, 0.5};
    const ff_fixed fixed[] = {{"f0", 3, values, NULL}, {"kd", 1, &(double){0.15}, t.channels[2].name}};
    const ff_constraints c = {.n_fixed = 2, .fixed = fixed};
    o.constraints = &c;
    for (int k = 0; k < 3; k++) {
        o.only_channel = k;
        ff_fit_result r = fitted("alone", &t, &s.model, &o);
        check_held("f0 alone", value_of(&r, "f0", 0), values[k]);
        FF_CHECK((value_of(&r, "kd", 0)->held != 0) == (k == 2), "kd of channel %d", k);
        ff_fit_result_clear(&r);
    }
    ff_table_clear(&t);
}

/* ---- what makes no sense --------------------------------------------------------------------- */

static void refused(const ff_table *t, const ff_model *m, ff_constraints c, ff_channel_mode mode, ff_status expected,
                    const char *words)
{
    ff_fit_options o = fit_options();
    ff_fit_result r = {0};
    ff_error err = {0};
    o.constraints = &c;
    o.channels = mode;
    const ff_status status = fit_table(t, m, &o, &r, NULL, &err);
    FF_CHECK(status == expected && strstr(err.message, words), "status %d, '%s'; expected %d, '%s'", (int)status, err.message,
             (int)expected, words);
    if (!status) ff_fit_result_clear(&r);
}

static void senseless(void)
{
    const fit_surface s = surface("ggx+lambert", 3, "alpha=0.25 kd=0.2", "f0", 0.3, 0.6);
    const fit_sampling how = sampling(14);
    ff_table t = fit_measure(&s, &how);
    const char *name = t.channels[1].name;
    const double v[4] = {0.1, 0.2, 0.3, -0.5};
    const ff_fixed two = {"f0", 2, v, NULL}, three = {"f0", 3, v, NULL}, low = {"f0", 1, v + 3, name}, lacking = {"g0", 1, v, name},
                   nobody = {"f0", 1, v, "uv"}, shape = {"alpha_x", 1, v, name}, one = {"f0", 1, v, name};
    const ff_bound box = {"f0", 0.25, 0.9, NULL}, of_one = {"f0", 0.2, 0.1, name}, of_nobody = {"f0", 0, 0.5, "uv"};
    const ff_prior prior = {"f0", 0.5, 0.1, "uv"};
    const ff_tie shared = {"f0", NULL};
    const ff_channel_mode rgb = FF_CHANNELS_RGB;
#define FIXED(f) {.n_fixed = 1, .fixed = &f}
    refused(&t, &s.model, (ff_constraints)FIXED(two), rgb, FF_ERR_RANGE, "2 values; expected 3");
    refused(&t, &s.model, (ff_constraints)FIXED(three), FF_CHANNELS_MEAN, FF_ERR_RANGE, "3 values; expected 1");
    refused(&t, &s.model, (ff_constraints)FIXED(low), rgb, FF_ERR_RANGE, "outside [0, 1e+15]");
    refused(&t, &s.model, (ff_constraints)FIXED(lacking), rgb, FF_ERR_UNKNOWN, "no parameter 'g0'");
    refused(&t, &s.model, (ff_constraints)FIXED(nobody), rgb, FF_ERR_UNKNOWN, "no channel 'uv'");
    refused(&t, &s.model, (ff_constraints)FIXED(one), FF_CHANNELS_MEAN, FF_ERR_UNSUPPORTED, "averaged");
    refused(&t, &s.model, (ff_constraints)FIXED(shape), rgb, FF_ERR_UNSUPPORTED, "one value for all channels");
    refused(&t, &s.model, (ff_constraints){.n_fixed = 1, .fixed = &three, .n_bounds = 1, .bound = &box}, rgb, FF_ERR_RANGE,
            "outside its bounds [0.25, 0.9]");
    refused(&t, &s.model, (ff_constraints){.n_fixed = 1, .fixed = &one, .n_ties = 1, .tie = &shared}, rgb, FF_ERR_UNSUPPORTED,
            "tied");
    refused(&t, &s.model, (ff_constraints){.n_bounds = 1, .bound = &of_one}, rgb, FF_ERR_RANGE, "must rise");
    refused(&t, &s.model, (ff_constraints){.n_bounds = 1, .bound = &of_nobody}, rgb, FF_ERR_UNKNOWN, "no channel 'uv'");
    refused(&t, &s.model, (ff_constraints){.n_priors = 1, .prior = &prior}, rgb, FF_ERR_UNKNOWN, "no channel 'uv'");
#undef FIXED
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(held_by_channel), FF_TEST(held_by_channel_of_many), FF_TEST(held_in_one_channel), FF_TEST(held_in_one_of_many),
             FF_TEST(errors_without_it), FF_TEST(conductor_with_known_eta), FF_TEST(with_a_free_scale),
             FF_TEST(bounds_of_one_channel), FF_TEST(bounds_of_two_channels), FF_TEST(prior_of_one_channel),
             FF_TEST(refits_keep_it), FF_TEST(channels_alone), FF_TEST(senseless))
