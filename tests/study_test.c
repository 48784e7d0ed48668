/* Studies: the fits are those of ff_fit.h and ff_trust.h to the bit, every form and figure is written, what makes no sense is
 * refused, and nothing is left where something fails. */
#include "ff_test.h"

#include "ff_simulate.h"
#include "ff_study.h"
#include <stdlib.h>
#include <string.h>

static ff_error err;

typedef struct scene {
    ff_model *model[3];
    ff_table *table;
    ff_fit_options options;
} scene;

static int scene_make(scene *s)
{
    static const char *const name[] = {"ggx+lambert", "beckmann+lambert", "ggx/v-cavity+lambert"};
    double shape[16], channel[32];
    ff_simulate_options o;
    ff_simulate_options_init(&o);
    o.sampling.step_deg = 10;
    o.relative = 0.02;
    ff_status status = FF_OK;
    for (int k = 0; k < 3 && !status; k++) status = ff_model_new(name[k], &s->model[k], &err);
    if (!status) ff_model_defaults(s->model[0], 3, shape, channel);
    if (!status) status = ff_model_set(s->model[0], 3, "alpha=0.3", shape, channel, &err);
    if (!status) status = ff_model_set(s->model[0], 3, "f0=0.05:0.06:0.04", shape, channel, &err);
    if (!status) status = ff_simulate(s->model[0], 3, shape, channel, &o, &s->table, &err);
    ff_fit_options_init(&s->options);
    s->options.shape = FF_SHAPE_ISOTROPIC;
    s->options.threads = 1;
    return FF_CHECK(!status, "the scene: %s", err.message);
}

static void scene_free(scene *s)
{
    for (int k = 0; k < 3; k++) ff_model_free(s->model[k]);
    ff_table_free(s->table);
}

static ff_study *study_of(const scene *s, size_t n, const ff_study_options *o)
{
    ff_study *made = NULL;
    const ff_status status = ff_study_new(s->table, (const ff_model *const *)s->model, n, &s->options, o, &made, &err);
    FF_CHECK(!status, "%s", err.message);
    return made;
}

static int same(double a, double b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

/* ---- numbers --------------------------------------------------------------------------------- */

static void check_value(const ff_fit_value *a, const ff_fit_value *b, const char *name)
{
    FF_CHECK(same(a->value, b->value) && same(a->std_error, b->std_error) && same(a->low, b->low) && same(a->high, b->high),
             "%s: %.17g +- %.17g and %.17g +- %.17g", name, a->value, a->std_error, b->value, b->std_error);
}

/* Of one model, all numbers are those of a fit by hand. */
static void same_as_by_hand(void)
{
    static const char *const name[] = {"alpha_x", "f0", "kd"};
    scene s;
    ff_problem *p = NULL;
    ff_fit_result *fit = NULL;
    if (!scene_make(&s)) return;
    ff_study *study = study_of(&s, 1, NULL);
    FF_CHECK(!ff_problem_new(s.table, (const ff_model *const *)s.model, 1, &s.options, &p, &err), "%s", err.message);
    FF_CHECK(p && !ff_problem_fit(p, s.model[0], &s.options, &fit, &err), "%s", err.message);
    if (study && fit) {
        FF_CHECK(ff_study_fit_count(study) == 1 && ff_study_problem_count(study) == 1, "one fit");
        for (int k = 0; k < 3; k++)
            for (size_t c = 0; c < 3; c++)
                check_value(ff_fit_result_find(ff_study_fit(study, 0), name[k], c), ff_fit_result_find(fit, name[k], c), name[k]);
        FF_CHECK(same(ff_fit_result_objective(ff_study_fit(study, 0)), ff_fit_result_objective(fit)), "the objective");
        FF_CHECK(ff_study_ranked(study, 0, 0) == 0 && !ff_study_versus(study, 0), "it is the best, compared to nothing");
    }
    ff_fit_result_free(fit);
    ff_problem_free(p);
    ff_study_free(study);
    scene_free(&s);
}

/* Every channel by itself is a problem of its own. */
static void each_channel(void)
{
    scene s;
    if (!scene_make(&s)) return;
    s.options.channels = FF_CHANNELS_EACH;
    ff_study *study = study_of(&s, 1, NULL);
    for (size_t c = 0; study && c < 3; c++) {
        ff_fit_options o = s.options;
        ff_problem *p = NULL;
        ff_fit_result *fit = NULL;
        o.channels = FF_CHANNELS_RGB;
        o.only_channel = (int)c;
        FF_CHECK(!ff_problem_new(s.table, (const ff_model *const *)s.model, 1, &o, &p, &err) &&
                     !ff_problem_fit(p, s.model[0], &o, &fit, &err),
                 "%s", err.message);
        if (fit)
            check_value(ff_fit_result_find(ff_study_fit(study, c), "alpha_x", 0), ff_fit_result_find(fit, "alpha_x", 0), "alpha_x");
        ff_fit_result_free(fit);
        ff_problem_free(p);
    }
    FF_CHECK(study && ff_study_problem_count(study) == 3 && ff_study_fit_count(study) == 3, "three problems");
    ff_study_free(study);
    scene_free(&s);
}

/* Ranks rise with the objective; the fit that made the data is the best, and the tests are against it. */
static void comparison(void)
{
    scene s;
    if (!scene_make(&s)) return;
    ff_study *study = study_of(&s, 3, NULL);
    double before = 0;
    for (size_t k = 0; study && k < 3; k++) {
        const size_t i = ff_study_ranked(study, 0, k);
        const ff_versus *v = ff_study_versus(study, i);
        const double objective = ff_fit_result_objective(ff_study_fit(study, i));
        FF_CHECK(objective >= before, "rank %zu: %g after %g", k, objective, before);
        FF_CHECK(v && (k == 0) == (v->objective == 0), "rank %zu is compared to the best", k);
        before = objective;
    }
    FF_CHECK(study && ff_study_ranked(study, 0, 0) == 0, "ggx is the best");
    FF_CHECK(study && ff_study_ranked(study, 0, 3) == (size_t)-1 && ff_study_ranked(study, 1, 0) == (size_t)-1, "no more ranks");
    ff_study_free(study);
    scene_free(&s);
}

/* What the options ask for is done: errors by a bootstrap are those of ff_trust_bootstrap. */
static void bootstrap(void)
{
    scene s;
    ff_study_options o;
    ff_problem *p = NULL;
    ff_fit_result *fit = NULL;
    ff_places *places = NULL;
    ff_bootstrap made = {.size = sizeof made};
    if (!scene_make(&s)) return;
    ff_study_options_init(&o);
    o.bootstrap = 25;
    o.seed = 7;
    o.cut_off = 0;
    ff_study *study = study_of(&s, 1, &o);
    FF_CHECK(!ff_problem_new(s.table, (const ff_model *const *)s.model, 1, &s.options, &p, &err) &&
                 !ff_problem_fit(p, s.model[0], &s.options, &fit, &err) && !ff_places_new(p, s.table, &places, &err) &&
                 !ff_trust_bootstrap(p, places, &s.options, 25, 7, fit, &made, &err),
             "%s", err.message);
    if (study && fit)
        check_value(ff_fit_result_find(ff_study_fit(study, 0), "alpha_x", 0), ff_fit_result_find(fit, "alpha_x", 0), "alpha_x");
    ff_places_free(places);
    ff_fit_result_free(fit);
    ff_problem_free(p);
    ff_study_free(study);
    scene_free(&s);
}

/* ---- forms ----------------------------------------------------------------------------------- */

static void check_written(ff_status status, ff_content *c, const char *form, const char *has)
{
    FF_CHECK(!status, "%s: %s", form, err.message);
    if (status) return;
    FF_CHECK(c->n > 0 && strlen(c->text) == c->n && strstr(c->text, has), "%s has no '%s'", form, has);
    ff_content_clear(c);
}

static void forms(void)
{
    static const char *const of_fit[][2] = {{"text", "alpha_x"}, {"json", "\"facetfit.fit/2\""},
                                            {"html", "</html>"}, {"summary", "</table>"},
                                            {"csv", "alpha_x"},  {"tsv", "\t"},
                                            {"md", "|"},         {"latex", "tabular"}};
    static const char *const of_table[][2] = {{"text", "samples"}, {"json", "\"facetfit.info/1\""}, {"html", "</html>"}};
    scene s;
    ff_content c = {0};
    if (!scene_make(&s)) return;
    ff_study *one = study_of(&s, 1, NULL), *many = study_of(&s, 3, NULL);
    for (size_t k = 0; one && many && k < sizeof of_fit / sizeof *of_fit; k++) {
        check_written(ff_study_write(one, of_fit[k][0], &c, &err), &c, of_fit[k][0], of_fit[k][1]);
        check_written(ff_study_write(many, of_fit[k][0], &c, &err), &c, of_fit[k][0], k == 0 ? "v-cavity" : of_fit[k][1]);
    }
    for (size_t k = 0; k < sizeof of_table / sizeof *of_table; k++)
        check_written(ff_table_describe(s.table, NULL, of_table[k][0], &c, &err), &c, of_table[k][0], of_table[k][1]);
    FF_CHECK(one && ff_study_write(one, "yaml", &c, &err) == FF_ERR_UNKNOWN && !c.text && strstr(err.message, "json"), "%s",
             err.message);
    FF_CHECK(ff_table_describe(s.table, NULL, "csv", &c, &err) == FF_ERR_UNKNOWN && !c.text, "%s", err.message);
    ff_study_free(one);
    ff_study_free(many);
    scene_free(&s);
}

/* Every kind of figure is drawn of a study; of data alone and of models alone those that can be. */
static void figures(void)
{
    scene s;
    ff_content c = {0};
    ff_plot_options o;
    double shape[16], channel[32];
    size_t of_models = 0, of_data = 0;
    const char *kind;
    if (!scene_make(&s)) return;
    ff_study *study = study_of(&s, 1, NULL);
    ff_model_defaults(s.model[0], 1, shape, channel);
    const ff_plotted model = {"a model", s.model[0], 1, shape, channel};
    ff_plot_options_init(&o);
    o.repeats = 20;
    for (size_t k = 0; study && (kind = ff_plot_name(k)) != NULL; k++) {
        check_written(ff_study_plot(study, kind, &o, &c, &err), &c, kind, "</svg>");
        ff_status status = ff_models_plot(&model, 1, kind, NULL, &c, &err);
        of_models += !status;
        FF_CHECK(!status || status == FF_ERR_UNSUPPORTED, "%s of a model: %s", kind, err.message);
        ff_content_clear(&c);
        status = ff_table_plot(s.table, kind, NULL, &c, &err);
        of_data += !status;
        FF_CHECK(!status || status == FF_ERR_UNSUPPORTED, "%s of data: %s", kind, err.message);
        ff_content_clear(&c);
    }
    FF_CHECK(of_models >= 5 && of_data >= 1, "%zu kinds of models, %zu of data", of_models, of_data);
    o.form = "csv";
    o.title = "a title";
    check_written(study ? ff_study_plot(study, "residuals", &o, &c, &err) : FF_OK, &c, "csv", "panel,");
    FF_CHECK(study && ff_study_plot(study, "pie", NULL, &c, &err) == FF_ERR_UNKNOWN && strstr(err.message, "slice"), "%s",
             err.message);
    o.form = "png";
    FF_CHECK(study && ff_study_plot(study, "slice", &o, &c, &err) == FF_ERR_UNKNOWN, "%s", err.message);
    ff_study_free(study);
    scene_free(&s);
}

/* What is written to a file and to memory is the same; every renderer that has a file has one; a format needs a path. */
static void exports(void)
{
    scene s;
    ff_content file = {0}, about = {0};
    const char *to;
    size_t written = 0;
    if (!scene_make(&s)) return;
    ff_study *study = study_of(&s, 1, NULL);
    for (size_t k = 0; study && (to = ff_export_name(k)) != NULL; k++) {
        const ff_status status = ff_study_export(study, 0, to, NULL, &file, &about, &err);
        written += !status;
        FF_CHECK(!status || status == FF_ERR_UNSUPPORTED, "%s: %s", to, err.message);
        FF_CHECK(status || (file.n > 0 && strstr(about.text, "facetfit.export/1")), "%s: %s", to, about.text);
        FF_CHECK(!status || (!file.text && !about.text), "%s left something", to);
        ff_content_clear(&file);
        ff_content_clear(&about);
    }
    FF_CHECK(written >= 15, "%zu were written", written);
    const char *path = ff_test_path("out.py");
    FF_CHECK(study && !ff_study_export(study, 0, "blender", path, NULL, NULL, &err), "%s", err.message);
    FF_CHECK(study && !ff_study_export(study, 0, "blender", NULL, &file, NULL, &err), "%s", err.message);
    size_t n = 0;
    char *there = ff_test_slurp(path, &n);
    FF_CHECK(there && n == file.n && !memcmp(there, file.text, n), "the file and the memory differ");
    free(there);
    ff_content_clear(&file);
    FF_CHECK(study && ff_study_export(study, 0, "csv", ff_test_path("out.csv"), NULL, &about, &err) == FF_OK, "%s", err.message);
    ff_content_clear(&about);
    FF_CHECK(study && ff_study_export(study, 0, "povray", NULL, &file, NULL, &err) == FF_ERR_UNKNOWN, "%s", err.message);
    FF_CHECK(study && ff_study_export(study, 0, "blender:tin", NULL, &file, NULL, &err) == FF_ERR_UNKNOWN, "%s", err.message);
    FF_CHECK(study && ff_study_export(study, 0, "c", NULL, NULL, NULL, &err) == FF_ERR_RANGE, "neither a path nor room");
    ff_study_free(study);
    scene_free(&s);
}

/* ---- refusals -------------------------------------------------------------------------------- */

static void check_refused(const scene *s, size_t n, const ff_study_options *o, ff_status expected)
{
    ff_study *made = NULL;
    err = (ff_error){0};
    const ff_status status = ff_study_new(s->table, (const ff_model *const *)s->model, n, &s->options, o, &made, &err);
    FF_CHECK(status == expected && !made && err.message[0], "status %d: %s", (int)status, err.message);
    ff_study_free(made);
}

static void refusals(void)
{
    scene s;
    ff_study_options o;
    if (!scene_make(&s)) return;
    ff_study_options_init(&o);
    o.bootstrap = 20;
    check_refused(&s, 2, &o, FF_ERR_UNSUPPORTED);
    o.profile = 1;
    check_refused(&s, 1, &o, FF_ERR_RANGE);
    ff_study_options_init(&o);
    o.folds = 1;
    check_refused(&s, 2, &o, FF_ERR_RANGE);
    ff_study_options_init(&o);
    o.choose_loss = 1;
    check_refused(&s, 2, &o, FF_ERR_UNSUPPORTED);
    s.options.robust = FF_ROBUST_HUBER;
    check_refused(&s, 1, &o, FF_ERR_UNSUPPORTED);
    s.options.robust = FF_ROBUST_NONE;
    o.size = 3;
    check_refused(&s, 1, &o, FF_ERR_RANGE);
    scene_free(&s);
}

/* The loss that is chosen is one of those that there are, and its name is in the report. */
static void chosen_loss(void)
{
    scene s;
    ff_study_options o;
    ff_content c = {0};
    if (!scene_make(&s)) return;
    ff_study_options_init(&o);
    o.choose_loss = 1;
    ff_study *study = study_of(&s, 1, &o);
    const char *name = study ? ff_loss_name((int)ff_study_fit_options(study)->loss) : NULL;
    FF_CHECK(name, "a loss was chosen");
    if (name) check_written(ff_study_write(study, "text", &c, &err), &c, "text", name);
    ff_study_free(study);
    scene_free(&s);
}

/* Cancelled between passes, with nothing left. */
static void cancelled(void)
{
    const volatile int cancel = 1;
    scene s;
    if (!scene_make(&s)) return;
    s.options.cancel = &cancel;
    check_refused(&s, 3, NULL, FF_ERR_CANCELLED);
    scene_free(&s);
}

FF_TEST_MAIN(FF_TEST(same_as_by_hand), FF_TEST(each_channel), FF_TEST(comparison), FF_TEST(bootstrap), FF_TEST(forms),
             FF_TEST(figures), FF_TEST(exports), FF_TEST(refusals), FF_TEST(chosen_loss), FF_TEST(cancelled))
