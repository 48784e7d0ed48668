/* What a fit says of parameters that have nothing to act on: no error, no interval, a warning, whatever is left in the sums. */
#include "fit_samples.h"
#include "warnings.h"

typedef struct fitted {
    ff_fit_result r;
    ff_status status;
} fitted;

/* Fits a model, with its ks free or not, to a surface that is multiplied by `scale`. */
static fitted fit_scaled(const char *surface, const char *set, double scale, double noise, const char *expression, int free_scale)
{
    const fit_surface s = fit_surface_make(surface, 1, set);
    const fit_sampling how = {.n = 600, .max_theta = 70, .noise = noise, .glossy = 0.5, .seed = 3};
    ff_table t = fit_measure(&s, &how);
    for (size_t k = 0; k < t.n; k++) t.value[k] *= scale;
    ff_model m;
    ff_error err = {0};
    const ff_fit_options o = fit_options();
    fitted f = {.status = FF_ERR_INTERNAL};
    if (!ff_model_parse(expression, &m, &err) && (!free_scale || !ff_model_vary(&m, "ks", &err)))
        f.status = fit_table(&t, &m, &o, &f.r, NULL, &err);
    FF_CHECK(f.status == FF_OK, "%s: %s", expression, err.message);
    ff_table_clear(&t);
    return f;
}

static void check_nothing(const ff_fit_result *r, const char *name, const char *what)
{
    const ff_fit_value *v = ff_fit_result_find(r, name, 0);
    if (!FF_CHECK(v != NULL, "%s has no %s", what, name)) return;
    const ff_warning *w = find_warning(r, FF_WARNING_NOT_DETERMINED, name);
    FF_CHECK(isnan(v->std_error) && isnan(v->low) && isnan(v->high) && v->interval == FF_INTERVAL_NONE,
             "%s: %s = %g +- %g, %g to %g", what, name, v->value, v->std_error, v->low, v->high);
    FF_CHECK(v->weightless && w && w->value[0] == 1 && !has_warning(r, FF_WARNING_AT_BOUND, name), "%s: no warning of %s", what,
             name);
}

static void check_something(const ff_fit_result *r, const char *name, const char *what)
{
    const ff_fit_value *v = ff_fit_result_find(r, name, 0);
    FF_CHECK(v && v->std_error >= 0 && v->low <= v->high && !v->weightless, "%s: %s has no error", what, name);
}

/* Data of 0: nothing has an error, and the fit says so. */
static void zero(void)
{
    static const struct {
        const char *expression, *nothing[4];
        int free_scale;
    } trials[] = {{"ggx", {"alpha_x"}, 0},
                  {"ggx", {"alpha_x"}, 1},
                  {"ggx+lambert", {"alpha_x"}, 0},
                  {"student-t+lambert", {"alpha_x", "alpha_y", "r_xy", "gamma"}, 0},
                  {"ggx/smith-height-correlated/conductor", {"alpha_x", "eta", "k"}, 0},
                  {"ggx/smith-height-correlated/dielectric", {"alpha_x", "eta"}, 0},
                  {"ggx+oren-nayar", {"alpha_x", "sigma_facet"}, 0},
                  {"oren-nayar", {"sigma_facet"}, 0},
                  {"ggx+beckmann/smith-height-correlated/shared", {"alpha_x", "lobe2.alpha_x"}, 0}};
    for (size_t k = 0; k < sizeof trials / sizeof *trials; k++) {
        fitted f = fit_scaled("ggx+lambert", "alpha=0.3 f0=0.4 kd=0.2", 0, 0, trials[k].expression, trials[k].free_scale);
        if (f.status) continue;
        FF_CHECK(has_warning(&f.r, FF_WARNING_NOTHING_TO_FIT, NULL), "%s: all is 0, and nothing is said", trials[k].expression);
        for (size_t i = 0; i < 4 && trials[k].nothing[i]; i++) check_nothing(&f.r, trials[k].nothing[i], trials[k].expression);
        for (size_t i = 0; i < fit_parameter_count(&f.r); i++) {
            char name[64];
            double truth;
            const ff_fit_value *v = fit_parameter(&f.r, i, NULL, &truth, name);
            FF_CHECK(!v || (isnan(v->std_error) && isnan(v->low)), "%s: %s has an error", trials[k].expression, name);
        }
        ff_fit_result_clear(&f.r);
    }
}

/* A matt surface: the lobe that is not there has no roughness, and what is there has its error. */
static void no_lobe(void)
{
    static const char *const expressions[] = {"ggx+lambert", "beckmann+lambert", "student-t+lambert", "ggx/v-cavity+lambert"};
    int without = 0;
    for (size_t k = 0; k < sizeof expressions / sizeof *expressions; k++) {
        fitted f = fit_scaled("lambert", "kd=0.3", 1, 0, expressions[k], 0);
        if (f.status) continue;
        if (ff_fit_result_find(&f.r, "f0", 0)->value == 0) {
            check_nothing(&f.r, "alpha_x", expressions[k]);
            without++;
        }
        check_something(&f.r, "kd", expressions[k]);
        FF_CHECK(!has_warning(&f.r, FF_WARNING_NOTHING_TO_FIT, NULL), "there is something to fit");
        ff_fit_result_clear(&f.r);
    }
    FF_CHECK(without > 0, "every fit has found a lobe");
}

/* A lobe that is not there beside one that is, and a base that is not there beside a lobe. */
static void one_of_two(void)
{
    fitted f = fit_scaled("ggx", "alpha=0.3 f0=0.6", 1, 0.02, "ggx/smith-height-correlated/none+oren-nayar", 1);
    if (!f.status) {
        check_something(&f.r, "alpha_x", "one lobe");
        if (ff_fit_result_find(&f.r, "kd", 0)->value == 0) check_nothing(&f.r, "sigma_facet", "no base");
        ff_fit_result_clear(&f.r);
    }
    /* lambert data, a lobe without a Fresnel rise: its scale is 0 */
    f = fit_scaled("lambert", "kd=0.3", 1, 0, "ggx/smith-height-correlated/none+lambert", 1);
    if (!f.status) {
        FF_CHECK(ff_fit_result_find(&f.r, "ks", 0)->value < 1e-6, "ks = %g", ff_fit_result_find(&f.r, "ks", 0)->value);
        if (ff_fit_result_find(&f.r, "ks", 0)->value == 0) check_nothing(&f.r, "alpha_x", "ks = 0");
        ff_fit_result_clear(&f.r);
    }
}

/* What is there keeps its errors: a weak lobe on a bright base, one with F0 = 0 whose rise is all there is. */
static void something(void)
{
    fitted f = fit_scaled("ggx+lambert", "alpha=0.2 f0=0.02 kd=0.5", 1, 0.01, "ggx+lambert", 0);
    if (!f.status) {
        check_something(&f.r, "alpha_x", "a weak lobe");
        ff_fit_result_clear(&f.r);
    }
    f = fit_scaled("ggx", "alpha=0.3 f0=0", 1, 0.01, "ggx", 0);
    if (!f.status) {
        check_something(&f.r, "alpha_x", "the rise alone");
        ff_fit_result_clear(&f.r);
    }
}

FF_TEST_MAIN(FF_TEST(zero), FF_TEST(no_lobe), FF_TEST(one_of_two), FF_TEST(something))
