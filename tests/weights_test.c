/* Weights by the noise, and errors by leaving out incidences: against fits with the same weights in a column, against fits without
 * one incidence after another, and where one incidence alone says something. */
#include "fit_samples.h"
#include "warnings.h"
#include "base/internal_statistics.h"
#include "fit/noise/internal_noise.h"
#include "simulate/simulate_struct.h"
#include "trust_struct.h"

enum { MOST = 16 };

static ff_fit_options options(void)
{
    ff_fit_options o;
    ff_fit_options_init(&o);
    o.shape = FF_SHAPE_ISOTROPIC;
    o.threads = 1;
    return o;
}

static ff_table measured(const fit_surface *s, const char *grid, double relative, const char *stream)
{
    ff_simulate_options o;
    ff_table t;
    ff_error err = {0};
    uint64_t state = ff_test_stream("%s", stream);
    ff_simulate_options_init(&o);
    ff_status status = ff_sampling_parse(grid, &o.sampling, &err);
    if (!status) status = ff_simulate_into(&s->model, s->n_channels, s->shape, s->channel, &o, &t, &err);
    if (status) {
        printf("the test itself is wrong: %s\n", err.message);
        exit(1);
    }
    for (size_t k = 0; k < t.n * t.n_channels; k++) t.value[k] *= 1 + relative * fit_normal(&state);
    return t;
}

static ff_problem *problem_of(const ff_table *t, const ff_model *m, const ff_fit_options *o)
{
    ff_problem *p = NULL;
    ff_error err = {0};
    FF_CHECK(ff_problem_make(t, m, 1, o, &p, &err) == FF_OK, "%s", err.message);
    if (!p) exit(1);
    return p;
}

static ff_fit_result fit_to(ff_problem *p, const ff_model *m, const ff_fit_options *o)
{
    ff_fit_result r = {.n_channels = 0};
    ff_error err = {0};
    FF_CHECK(ff_problem_fit_into(p, m, o, &r, &err) == FF_OK, "%s", err.message);
    if (!r.shape_value) exit(1);
    return r;
}

static void compare(const char *what, const ff_fit_result *a, const ff_fit_result *b, double tolerance)
{
    for (size_t k = 0; k < fit_parameter_count(a); k++) {
        char name[64];
        double ignored;
        const ff_fit_value *x = fit_parameter(a, k, NULL, &ignored, name), *y = fit_parameter(b, k, NULL, &ignored, name);
        if (x)
            FF_CHECK(fabs(x->value - y->value) <= tolerance * fmax(fabs(y->value), 1e-3), "%s: %s is %.10g and %.10g", what, name,
                     x->value, y->value);
    }
}

/* The standard deviation of every value of t at the model where the standardised fit of r has ended. */
static ff_table with_deviations(const ff_table *t, const ff_fit_result *r)
{
    ff_table out;
    ff_error err = {0};
    fit_surface s = {.model = r->model, .n_channels = t->n_channels};
    memcpy(s.shape, r->noise->shape, sizeof s.shape);
    memcpy(s.channel, r->noise->channel, r->model.n_channel * t->n_channels * sizeof *s.channel);
    FF_CHECK(ff_table_init(t->n, t->n_channels, NULL, 1, 0, &out, &err) == FF_OK, "%s", err.message);
    for (int k = 0; k < 4; k++) memcpy(out.angle[k], t->angle[k], t->n * sizeof *out.angle[k]);
    out.radians_per_unit = t->radians_per_unit;
    out.isotropic = t->isotropic;
    fit_evaluate(&s, &out);
    for (size_t c = 0; c < t->n_channels; c++)
        for (size_t i = 0; i < t->n; i++) {
            double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
            ff_table_directions(t, i, 1, planes);
            out.sigma[c * t->n + i] = ff_noise_sd(r->noise->noise, c, out.value[c * t->n + i], w[2], w[5]);
        }
    memcpy(out.value, t->value, t->n * t->n_channels * sizeof *out.value);
    return out;
}

/* A fit by the noise is the fit to the same data with a column of these standard deviations: of few samples, and of so many that
 * starts are searched on some of them; with a loss that has no say any more. */
static void as_a_column_of_deviations(void)
{
    static const struct {
        const char *grid;
        ff_loss loss;
        size_t channels;
    } cases[] = {{"goniometer:10", FF_LOSS_COSINE, 1}, {"goniometer:5", FF_LOSS_LOG, 3}, {"scattered:30000", FF_LOSS_CUBE_ROOT, 2}};
    const fit_surface three = fit_surface_make("ggx+lambert", 3, "alpha=0.2 f0=0.5:0.3:0.1 kd=0.1:0.2:0.05");
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        fit_surface s = three;
        s.n_channels = cases[k].channels;
        ff_table t = measured(&s, cases[k].grid, 0.05, cases[k].grid);
        uint64_t state = ff_test_stream("weights of %s", cases[k].grid);
        t.weight = malloc(t.n * sizeof *t.weight); /* which have no say then either */
        for (size_t i = 0; i < t.n && t.weight; i++) t.weight[i] = 0.5 + fit_uniform(&state);
        ff_fit_options o = options();
        o.loss = cases[k].loss;
        ff_problem *p = problem_of(&t, &s.model, &o);
        ff_fit_result first = fit_to(p, &s.model, &o);
        ff_error err = {0};
        FF_CHECK(first.noise && ff_problem_weigh_by_noise(p, &o, &first, &err) == FF_OK, "%s", err.message);
        FF_CHECK(ff_problem_selected(p)->weighting == FF_WEIGHT_NOISE, "weights by %s",
                 ff_weighting_name((int)ff_problem_selected(p)->weighting));
        ff_fit_result r = fit_to(p, &s.model, &o);
        ff_table column = with_deviations(&t, &first);
        o.loss = FF_LOSS_PLAIN;
        o.weighting = FF_WEIGHT_SIGMA;
        ff_problem *q = problem_of(&column, &s.model, &o);
        ff_fit_result want = fit_to(q, &s.model, &o);
        compare(cases[k].grid, &r, &want, 2e-6); /* factors are kept as floats: 6e-8 each */
        FF_CHECK(fabs(r.residual.objective / want.residual.objective - 1) < 1e-5, "%s: objectives %.10g and %.10g", cases[k].grid,
                 r.residual.objective, want.residual.objective);
        FF_CHECK(fabs(2 * r.residual.objective / (double)(p->n * p->n_channels) - 1) < 0.15,
                 "%s: a mean square of %.3g in standard deviations", cases[k].grid,
                 2 * r.residual.objective / (double)(p->n * p->n_channels));
        ff_fit_result_clear(&first);
        ff_fit_result_clear(&r);
        ff_fit_result_clear(&want);
        ff_problem_free(p);
        ff_problem_free(q);
        ff_table_clear(&column);
        ff_table_clear(&t);
    }
}

static void refusals(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.2 f0=0.5 kd=0.1");
    ff_table t = measured(&s, "goniometer:15", 0, "refusals");
    ff_fit_options o = options();
    ff_problem *p = problem_of(&t, &s.model, &o);
    ff_fit_result exact = fit_to(p, &s.model, &o);
    ff_error err = {0};
    FF_CHECK(ff_problem_weigh_by_noise(p, &o, &exact, &err) == FF_ERR_DATA && strstr(err.message, "no noise"), "'%s'", err.message);
    FF_CHECK(ff_problem_selected(p)->weighting == FF_WEIGHT_SAMPLE, "a refusal has changed the weights");
    o.robust = FF_ROBUST_HUBER;
    o.robust_scale = 1;
    FF_CHECK(ff_problem_weigh_by_noise(p, &o, &exact, &err) == FF_ERR_UNSUPPORTED, "'%s'", err.message);
    ff_fit_result_clear(&exact);
    ff_problem_free(p);
    ff_table_clear(&t);
}

/* ---- leaving out incidences ------------------------------------------------------------------- */

/* The variance of CR3 by refits without one incidence after another, by parameter. */
static void by_refits(const ff_table *t, const fit_surface *s, const ff_places *places, const ff_fit_options *o,
                      const ff_fit_result *all, double *variance)
{
    const size_t G = places->n_directions;
    memset(variance, 0, MOST * sizeof *variance);
    for (size_t g = 0; g < G; g++) {
        for (size_t i = 0; i < t->n; i++) t->valid[i] = places->direction[i] != g;
        ff_problem *p = problem_of(t, &s->model, o);
        ff_fit_result r = fit_to(p, &s->model, o);
        for (size_t k = 0; k < fit_parameter_count(&r) && k < MOST; k++) {
            char name[64];
            double ignored;
            const ff_fit_value *v = fit_parameter(&r, k, NULL, &ignored, name), *w = fit_parameter(all, k, NULL, &ignored, name);
            if (v) variance[k] += (double)(G - 1) / (double)G * (v->value - w->value) * (v->value - w->value);
        }
        ff_fit_result_clear(&r);
        ff_problem_free(p);
    }
    memset(t->valid, 1, t->n);
}

/* As refits from nothing have it, of few channels and of many, of the right model and of one that is not the surface. Moves count
 * in the coordinate that a parameter is fitted in: where they are a tenth of it, its square is a few per cent. */
static void as_refits_without(void)
{
    static const struct {
        size_t channels;
        ff_loss loss;
        const char *fitted;
        double within;
    } cases[] = {{1, FF_LOSS_COSINE, "ggx+lambert", 0.02},
                 {12, FF_LOSS_COSINE, "ggx+lambert", 0.02},
                 {1, FF_LOSS_LOG, "ggx+lambert", 0.02},
                 {1, FF_LOSS_LOG, "beckmann+lambert", 0.05},
                 {1, FF_LOSS_CUBE_ROOT, "beckmann+lambert", 0.05}};
    for (size_t which = 0; which < sizeof cases / sizeof *cases; which++) {
        const size_t channels = cases[which].channels;
        const fit_surface measured_one = fit_surface_make("ggx+lambert", channels, "alpha=0.3 f0=0.5 kd=0.1"),
                          s = fit_surface_make(cases[which].fitted, channels, "");
        ff_table t = measured(&measured_one, "goniometer:10", 0.002, "leaving out");
        ff_fit_options o = options();
        o.loss = cases[which].loss;
        ff_problem *p = problem_of(&t, &s.model, &o);
        ff_fit_result r = fit_to(p, &s.model, &o);
        ff_places places;
        ff_error err = {0};
        double variance[MOST];
        FF_CHECK(ff_places_init(p, &t, &places, &err) == FF_OK && p->n == t.n, "%s", err.message);
        by_refits(&t, &s, &places, &o, &r, variance);
        FF_CHECK(ff_trust_jackknife(p, &places, &o, &r, &err) == FF_OK, "%s", err.message);
        const double student = ff_student_quantile(0.95, (double)(places.n_directions - 1));
        for (size_t k = 0; k < fit_parameter_count(&r) && k < MOST; k++) {
            char name[64];
            double ignored;
            const ff_fit_value *v = fit_parameter(&r, k, NULL, &ignored, name);
            if (!v) continue;
            FF_CHECK(v->interval == FF_INTERVAL_JACKKNIFE, "%s: %s", name, ff_interval_name((int)v->interval));
            FF_CHECK(fabs(v->std_error / sqrt(variance[k]) - 1) < cases[which].within, "%zu channels, %s, %s: %.4g, by refits %.4g",
                     channels, ff_loss_name((int)o.loss), name, v->std_error, sqrt(variance[k]));
            if (name[0] == 'f') /* fitted as it is: symmetric */
                FF_CHECK(fabs(0.5 * (v->high - v->low) / (student * v->std_error) - 1) < 1e-6, "%s: %g to %g", name, v->low,
                         v->high);
        }
        for (size_t a = 0; a < r.n_columns; a++)
            for (size_t b = 0; b < r.n_columns; b++)
                FF_CHECK(fabs(r.correlation[a * r.n_columns + b]) <= 1 + 1e-12 &&
                             r.correlation[a * r.n_columns + b] == r.correlation[b * r.n_columns + a],
                         "correlation %g", r.correlation[a * r.n_columns + b]);
        ff_places_clear(&places);
        ff_fit_result_clear(&r);
        ff_problem_free(p);
        ff_table_clear(&t);
    }
}

/* Three incidences, of which only one has samples on the lobe, whose tails reach nowhere else. */
static void one_incidence_alone(void)
{
    const fit_surface s = fit_surface_make("beckmann+lambert", 1, "alpha=0.05 f0=0.5 kd=0.2");
    ff_table t;
    ff_error err = {0};
    uint64_t state = ff_test_stream("one incidence");
    FF_CHECK(ff_table_init(90, 1, NULL, 0, 0, &t, &err) == FF_OK, "%s", err.message);
    for (size_t i = 0; i < t.n; i++) {
        const double scan = (double)(i % 30);
        t.angle[0][i] = (10 + 20 * (double)(i / 30)) * FIT_DEGREE; /* 10, 30, 50 degrees: the lobe of the last is looked at */
        t.angle[1][i] = 0;
        t.angle[2][i] = (i < 60 ? 10 + 2 * scan : 35 + scan) * FIT_DEGREE;
        t.angle[3][i] = (i < 60 ? 90 : 180) * FIT_DEGREE;
        if (i < 60) t.angle[2][i] += 10 * FIT_DEGREE;
    }
    t.radians_per_unit = 1;
    t.isotropic = 1;
    fit_evaluate(&s, &t);
    for (size_t i = 0; i < t.n; i++) t.value[i] *= 1 + 0.02 * fit_normal(&state);
    const ff_fit_options o = options();
    ff_problem *p = problem_of(&t, &s.model, &o);
    ff_fit_result r = fit_to(p, &s.model, &o);
    ff_places places;
    FF_CHECK(ff_places_init(p, &t, &places, &err) == FF_OK && places.n_directions == 3, "%zu directions", places.n_directions);
    FF_CHECK(!isnan(r.shape_value[0].std_error), "alpha is not determined to begin with");
    FF_CHECK(ff_trust_jackknife(p, &places, &o, &r, &err) == FF_OK, "%s", err.message);
    FF_CHECK(isnan(r.shape_value[0].std_error) && r.shape_value[0].interval == FF_INTERVAL_NONE, "alpha %g +- %g",
             r.shape_value[0].value, r.shape_value[0].std_error);
    FF_CHECK(find_warning(&r, FF_WARNING_ONE_INCIDENCE, "alpha_x") != NULL, "nothing is said");
    places.n_directions = 2;
    FF_CHECK(ff_trust_jackknife(p, &places, &o, &r, &err) == FF_ERR_DATA && strstr(err.message, "at least 3"), "'%s'", err.message);
    ff_places_clear(&places);
    ff_fit_result_clear(&r);
    ff_problem_free(p);
    ff_table_clear(&t);
}

FF_TEST_MAIN(FF_TEST(as_a_column_of_deviations), FF_TEST(refusals), FF_TEST(as_refits_without), FF_TEST(one_incidence_alone))
