/* Results of fits read back: the numbers of a document, and what is refused. */
#include "ff_test.h"
#include "ff_fit_document.h"

static const char good[] =
    "{\"schema\": \"facetfit.fit/2\", \"data\": {\"path\": \"p.csv\", \"format\": \"csv\"}, \"loss\": {\"name\": \"log\", "
    "\"max_theta_deg\": 70},"
    "\"fits\": [{\"model\": \"ggx/v-cavity/schlick+lambert\", \"shape\": \"isotropic\", \"channels\": [\"r\", \"g\"], \"outcome\": "
    "\"converged\","
    "\"parameters\": {"
    "\"alpha_x\": {\"value\": 0.3, \"std_error\": 0.01, \"interval\": [0.28, 0.32], \"at_bound\": null, \"held\": false, \"tied\": "
    "false},"
    "\"alpha_y\": {\"value\": 0.3, \"tied\": true}, \"r_xy\": {\"value\": 0, \"held\": true}, \"slope_x\": {\"value\": 0}, "
    "\"slope_y\": {\"value\": 0},"
    "\"f0\": {\"value\": [0.5, 0.4], \"std_error\": [0.1, null], \"interval\": [[0.4, 0.6], null], \"at_bound\": [null, "
    "\"upper\"]},"
    "\"ks\": {\"value\": [1, 1]}, \"kd\": {\"value\": [0.1, 0.2]}},"
    "\"residual\": {\"objective\": 2.5, \"rmse\": 0.5},"
    "\"noise\": {\"levels\": [{\"constant\": 1e-6, \"linear\": 0, \"square\": 0.01}], \"cos_i\": 0, \"cos_o\": -1},"
    "\"residual_bands\": {\"theta_i\": [{\"n\": 7, \"mean\": -0.5, \"rms\": 1}]},"
    "\"correlation\": {\"names\": [\"alpha_x\", \"f0[r]\"], \"matrix\": [[1, 0.5], [0.5, 1]]}}], \"ranking\": [0]}";

static ff_status parse(const char *text, ff_fit_document **out, ff_error *err)
{
    return ff_fit_document_parse(text, strlen(text), "fit.json", out, err);
}

static void numbers(void)
{
    ff_fit_document *d = NULL;
    ff_error err = {0};
    if (!FF_CHECK(parse(good, &d, &err) == FF_OK, "%s", err.message)) return;
    const ff_fitted *f = &d->fit[0];
    FF_CHECK(d->n_fits == 1 && d->best == 0 && !strcmp(d->loss, "log") && !strcmp(d->path, "p.csv"), "head");
    FF_CHECK_CLOSE(d->max_theta, 70 * FF_DEGREES, 1e-15, 0);
    FF_CHECK(f->n_channels == 2 && !strcmp(f->channel_name[1], "g") && !strcmp(f->expression, "ggx/v-cavity/schlick+lambert"),
             "model");
    const ff_param_ref alpha = ff_model_param_find(&f->model, "alpha_x"), f0 = ff_model_param_find(&f->model, "f0"),
                       kd = ff_model_param_find(&f->model, "kd");
    const size_t stride = f->model.n_channel;
    FF_CHECK_CLOSE(f->shape[alpha.index], 0.3, 0, 0);
    FF_CHECK_CLOSE(f->shape_value[alpha.index].high, 0.32, 0, 0);
    FF_CHECK_CLOSE(f->channel[stride + f0.index], 0.4, 0, 0);
    FF_CHECK_CLOSE(f->channel[stride + kd.index], 0.2, 0, 0);
    FF_CHECK_CLOSE(f->channel_value[f0.index].low, 0.4, 0, 0);
    FF_CHECK(isnan(f->channel_value[stride + f0.index].std_error) && isnan(f->channel_value[stride + f0.index].low), "null is NaN");
    FF_CHECK(f->channel_value[stride + f0.index].at_bound == 1 && f->channel_value[f0.index].at_bound == 0, "bounds");
    FF_CHECK_CLOSE(f->objective, 2.5, 0, 0);
    FF_CHECK_CLOSE(ff_noise_sd(f->noise, 0, 1, 0.5, 0.25), sqrt((1e-6 + 0.01) / 0.25), 1e-12, 0);
    FF_CHECK(f->has_bands && f->bands.band[FF_PLACE_THETA_I][0].n == 7 && f->bands.band[FF_PLACE_THETA_H][0].n == 0, "bands");
    FF_CHECK(f->n_columns == 2 && !strcmp(f->column_name[1], "f0[r]"), "correlation");
    FF_CHECK_CLOSE(f->correlation[2], 0.5, 0, 0);
    ff_fit_document_free(d);
    ff_fit_document_free(NULL);
}

/* The document with a piece of it replaced. */
static char *changed(const char *from, const char *to)
{
    const char *at = strstr(good, from);
    char *text = malloc(sizeof good + strlen(to) + 1);
    sprintf(text, "%.*s%s%s", (int)(at - good), good, to, at + strlen(from));
    return text;
}

static void refused(void)
{
    static const struct {
        const char *from, *to;
        ff_status status;
        const char *says;
    } cases[] = {{"facetfit.fit/2", "facetfit.info/1", FF_ERR_FORMAT, "not the result of a fit"},
                 {"facetfit.fit/2", "facetfit.fit/9", FF_ERR_FORMAT, "version"},
                 {"\"schema\"", "\"scheme\"", FF_ERR_FORMAT, "not the result of a fit"},
                 {"ggx/v-cavity/schlick+lambert", "gxx", FF_ERR_DATA, "not known here"},
                 {"\"fits\"", "\"fixes\"", FF_ERR_DATA, "fits"},
                 {"\"value\": 0.3,", "\"value\": null,", FF_ERR_DATA, "alpha_x"},
                 {"\"value\": 0.3,", "\"value\": \"0.3\",", FF_ERR_DATA, "alpha_x"},
                 {"\"value\": 0.3,", "\"value\": -1,", FF_ERR_DATA, "cannot have"},
                 {"\"value\": [0.5, 0.4]", "\"value\": [0.5]", FF_ERR_DATA, "channel 2"},
                 {"\"value\": [0.5, 0.4]", "\"value\": {}", FF_ERR_DATA, "f0"},
                 {"[\"r\", \"g\"]", "[]", FF_ERR_DATA, "channels"},
                 {"[[1, 0.5], [0.5, 1]]", "[[1, 0.5], [0.5]]", FF_ERR_DATA, "square"},
                 {"\"parameters\"", "\"parametres\"", FF_ERR_DATA, "alpha_x"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        ff_fit_document *d = NULL;
        ff_error err = {0};
        char *text = changed(cases[k].from, cases[k].to);
        FF_CHECK(parse(text, &d, &err) == cases[k].status, "%s -> %s: %s", cases[k].from, cases[k].to, err.message);
        FF_CHECK(strstr(err.message, cases[k].says) != NULL, "'%s' lacks '%s'", err.message, cases[k].says);
        free(text);
        ff_fit_document_free(d);
    }
}

/* Odd, but no reason to refuse. */
static void tolerated(void)
{
    static const char *const cases[][2] = {{"\"ranking\": [0]", "\"ranking\": [5, -1, \"x\"]"},
                                           {"\"max_theta_deg\": 70", "\"max_theta_deg\": 1e9"},
                                           {"\"noise\": {", "\"noise\": null, \"was\": {"},
                                           {"\"residual_bands\": {", "\"residual_bands\": [1], \"was\": {"},
                                           {"\"n\": 7", "\"n\": -7"},
                                           /* its profile is given to the model that was read */
                                           {"ggx/v-cavity/schlick+lambert", "tabulated/v-cavity/schlick+lambert"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        ff_fit_document *d = NULL;
        ff_error err = {0};
        char *text = changed(cases[k][0], cases[k][1]);
        FF_CHECK(parse(text, &d, &err) == FF_OK, "%s: %s", cases[k][1], err.message);
        FF_CHECK(!d || (d->best == 0 && d->max_theta <= 90 * FF_DEGREES), "%s", cases[k][1]);
        free(text);
        ff_fit_document_free(d);
    }
}

static void finding(void)
{
    ff_fit_document *d = NULL;
    ff_error err = {0};
    size_t k = 9;
    if (!FF_CHECK(parse(good, &d, &err) == FF_OK, "%s", err.message)) return;
    FF_CHECK(ff_fit_document_find(d, "", &k, &err) == FF_OK && k == 0, "the best");
    FF_CHECK(ff_fit_document_find(d, "1", &k, &err) == FF_OK && k == 0, "by number");
    FF_CHECK(ff_fit_document_find(d, "ggx/v", &k, &err) == FF_OK && k == 0, "by its beginning");
    FF_CHECK(ff_fit_document_find(d, "2", &k, &err) == FF_ERR_UNKNOWN, "none");
    FF_CHECK(ff_fit_document_find(d, "99999999999999999999", &k, &err) == FF_ERR_UNKNOWN, "none");
    FF_CHECK(ff_fit_document_find(d, "phong", &k, &err) == FF_ERR_UNKNOWN && strstr(err.message, "ggx/v-cavity"), "%s",
             err.message);
    ff_fit_document_free(d);
}

static void probing(void)
{
    const char *json = ff_test_path("a.json"), *other = ff_test_path("a.xompt"), *csv = ff_test_path("a.csv");
    ff_test_write(json, "{}", 2);
    ff_test_write(other, "{\"name\": \"asphalt\"}", 19);
    ff_test_write(csv, "theta_i,f\n", 10);
    FF_CHECK(ff_fit_document_probe(json), "a name in .json that begins so is looked at");
    FF_CHECK(!ff_fit_document_probe(other) && !ff_fit_document_probe(csv) && !ff_fit_document_probe(ff_test_path("none")),
             "others");
    ff_test_write(other, good, sizeof good - 1);
    FF_CHECK(ff_fit_document_probe(other), "by its schema");
}

FF_TEST_MAIN(FF_TEST(numbers), FF_TEST(refused), FF_TEST(tolerated), FF_TEST(finding), FF_TEST(probing))
