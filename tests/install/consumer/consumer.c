/* A program in C that has nothing but the installed headers and libraries: fits a model to its own values and gets its parameters
 * back, reads what else a result says, goes through files, warnings, intervals and retrieved distributions. */
#include <facetfit/ff_albedo.h>
#include <facetfit/ff_convert.h>
#include <facetfit/ff_fit.h>
#include <facetfit/ff_interpolate.h>
#include <facetfit/ff_model.h>
#include <facetfit/ff_ndf.h>
#include <facetfit/ff_picture.h>
#include <facetfit/ff_profile_file.h>
#include <facetfit/ff_resample.h>
#include <facetfit/ff_rgl.h>
#include <facetfit/ff_sample.h>
#include <facetfit/ff_simulate.h>
#include <facetfit/ff_spectral.h>
#include <facetfit/ff_survey.h>
#include <facetfit/ff_table.h>
#include <facetfit/ff_trust.h>
#include <facetfit/ff_version.h>
#include <facetfit/ff_words.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SAMPLES = 500 };

static int wrong;
static ff_error error;

/* Counts what is not so, with what the library says of it. */
static int check(int holds, const char *what)
{
    char message[1024];
    if (holds) return 1;
    ff_error_format(&error, message, sizeof message);
    fprintf(stderr, "%s: %s\n", what, message);
    wrong++;
    return 0;
}

/* Directions that cover the hemisphere evenly enough: multiples of irrational numbers. */
static void fill_directions(ff_table *t)
{
    const double step[4] = {0.7548776662, 0.5698402910, 0.8191725134, 0.6710436067}, span[4] = {75, 360, 75, 360};
    for (int k = 0; k < 4; k++)
        for (size_t i = 0; i < SAMPLES; i++) ff_table_angle_plane(t, k)[i] = span[k] * fmod((double)(i + 1) * step[k], 1);
    check(ff_table_set_angle_unit(t, FF_DEGREES) == FF_OK, "degrees");
}

/* A table of the model's own values. */
static ff_table *table_of(const ff_model *m, const double *shape, const double *channel)
{
    static double planes[6][SAMPLES];
    double *const directions[6] = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    const ff_dirs dirs = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    ff_table *t;
    if (!check(ff_table_new(SAMPLES, 1, 0, 0, &t, &error) == FF_OK, "table")) return NULL;
    fill_directions(t);
    ff_table_directions(t, 0, SAMPLES, directions);
    check(ff_model_eval(m, FF_ISA_BEST, 1, shape, channel, &dirs, SAMPLES, ff_table_value_plane(t, 0), NULL, SAMPLES) == FF_OK,
          "values");
    check(ff_table_set_channel(t, 0, "550nm", 550, 1) == FF_OK && ff_table_channel(t, 0)->wavelength_nm == 550, "channel");
    return t;
}

/* ---- a fit ----------------------------------------------------------------------------------- */

static void read_result(const ff_problem *p, const ff_fit_result *fit)
{
    const ff_model *m = ff_fit_result_model(fit);
    char text[256];
    size_t free_ones = 0;
    for (uint32_t k = 0; k < ff_model_param_count(m, FF_PARAM_SHAPE); k++) {
        const ff_param_ref at = {FF_PARAM_SHAPE, k};
        const ff_fit_value *v = ff_fit_result_at(fit, at, 0);
        const ff_model_param *known = ff_model_param_at(m, at);
        check(v->value >= known->lo && v->value <= known->hi, known->name);
        free_ones += v->column >= 0;
        if (v->column >= 0) check(fabs(ff_fit_result_correlation(fit, at, 0, at, 0) - 1) < 1e-9, "a parameter with itself");
    }
    check(free_ones == 3 && ff_fit_result_free_count(fit) == 4, "free parameters");
    check(ff_fit_result_ellipse(fit) && ff_fit_result_rmse(fit) < 1e-4 && ff_fit_result_passes(fit) > 0, "what a result says");
    for (size_t i = 0; i < ff_fit_result_warning_count(fit); i++)
        check(ff_words_fit_warning(p, fit, ff_fit_result_warning(fit, i), text, sizeof text) > 0 && text[0], "words");
    check(ff_fit_result_warning(fit, ff_fit_result_warning_count(fit)) == NULL, "one warning too many");
}

static void read_trust(ff_problem *p, const ff_table *t, const ff_fit_options *o, ff_fit_result *fit)
{
    ff_places *places;
    ff_bands bands;
    ff_bootstrap bootstrap = {.size = sizeof bootstrap};
    ff_table *residuals;
    if (!check(ff_places_new(p, t, &places, &error) == FF_OK, "places")) return;
    check(ff_trust_bands(p, places, o, fit, &bands, &error) == FF_OK && bands.band[FF_PLACE_THETA_I][1].n > 0, "bands");
    check(ff_trust_residual_table(p, t, o, fit, &residuals, &error) == FF_OK && ff_table_samples(residuals) == SAMPLES,
          "residuals");
    check(ff_trust_bootstrap(p, places, o, 20, 1, fit, &bootstrap, &error) == FF_OK && bootstrap.repeats == 20, "bootstrap");
    check(ff_fit_result_find(fit, "alpha_x", 0)->interval == FF_INTERVAL_BOOTSTRAP, "intervals of the bootstrap");
    ff_table_free(residuals);
    ff_places_free(places);
}

static void fit_own_values(void)
{
    const struct {
        const char *assignment, *name;
        double value;
    } truth[] = {
        {"alpha_x=0.3", "alpha_x", 0.3}, {"alpha_y=0.5", "alpha_y", 0.5}, {"r_xy=0.2", "r_xy", 0.2}, {"f0=0.8", "f0", 0.8}};
    ff_model *m;
    ff_problem *problem;
    ff_fit_result *fit;
    ff_fit_options o;
    if (!check(ff_model_new("ggx", &m, &error) == FF_OK, "model")) return;
    double *shape = malloc(ff_model_param_count(m, FF_PARAM_SHAPE) * sizeof *shape);
    double *channel = malloc(ff_model_param_count(m, FF_PARAM_CHANNEL) * sizeof *channel);
    ff_model_defaults(m, 1, shape, channel);
    for (size_t i = 0; i < sizeof truth / sizeof *truth; i++)
        check(ff_model_set(m, 1, truth[i].assignment, shape, channel, &error) == FF_OK, truth[i].name);
    ff_table *t = table_of(m, shape, channel);
    const ff_model *models[] = {m};
    ff_fit_options_init(&o);
    o.threads = 1;
    o.shape = FF_SHAPE_CORRELATED;
    if (t && check(ff_problem_new(t, models, 1, &o, &problem, &error) == FF_OK, "problem")) {
        check(ff_problem_selected(problem)->used == SAMPLES && !strcmp(ff_problem_channel_name(problem, 0), "550nm"), "selection");
        if (check(ff_problem_fit(problem, m, &o, &fit, &error) == FF_OK, "fit")) {
            check(ff_fit_result_outcome(fit) == FF_CONVERGED, "not converged");
            for (size_t i = 0; i < sizeof truth / sizeof *truth; i++) {
                const double found = ff_fit_result_find(fit, truth[i].name, 0)->value;
                printf("%-8s %.6f, is %.6f\n", truth[i].name, found, truth[i].value);
                check(fabs(found - truth[i].value) < 1e-4, truth[i].name);
            }
            check(ff_fit_result_find(fit, "no such parameter", 0) == NULL, "a parameter that there is not");
            read_result(problem, fit);
            read_trust(problem, t, &o, fit);
            ff_fit_result_free(fit);
        }
        ff_problem_free(problem);
    }
    ff_table_free(t);
    free(shape);
    free(channel);
    ff_model_free(m);
}

/* ---- the rest of the library ----------------------------------------------------------------- */

/* A distribution without a formula, from data of one. */
static void retrieve(const ff_table *t)
{
    ff_fit_options fit;
    ff_ndf_options o;
    ff_problem *p;
    ff_ndf_result *r;
    ff_model *m;
    ff_fit_options_init(&fit);
    fit.shape = FF_SHAPE_ISOTROPIC;
    fit.threads = 1;
    ff_ndf_options_init(&o);
    o.fit = &fit;
    o.smooth = 1;
    if (!check(ff_ndf_problem_new(t, &o, &p, &error) == FF_OK, "problem of a retrieval")) return;
    if (check(ff_ndf_retrieve(p, &o, &r, &error) == FF_OK, "retrieval")) {
        check(fabs(ff_ndf_result_measures(r)->ggx_mean - 0.3) < 0.03, "roughness of the retrieved distribution");
        check(ff_ndf_result_row(r, 0)->theta == 0 && ff_ndf_result_row(r, ff_ndf_result_row_count(r)) == NULL, "rows");
        check(fabs(ff_fit_result_find(ff_ndf_result_fit(r, FF_NDF_GGX), "alpha_x", 0)->value - 0.3) < 0.03,
              "the fit that goes with it");
        if (check(ff_model_new("tabulated", &m, &error) == FF_OK, "tabulated")) {
            check(ff_model_set_table(m, ff_ndf_result_profile(r)) == 1, "its table");
            ff_model_free(m);
        }
        ff_ndf_result_free(r);
    }
    ff_problem_free(p);
}

/* Written, read again, surveyed, resampled, interpolated, reduced. */
static void go_through_files(const ff_table *t, const char *path)
{
    ff_table *again, *made, *mean;
    ff_survey *survey;
    ff_interpolant *between;
    ff_read_options o;
    ff_resample_report report = {.size = sizeof report};
    ff_read_options_init(&o);
    o.format = "csv";
    check(ff_table_write(path, "csv", t, &error) == FF_OK, "writing");
    if (!check(ff_table_read_with(path, &o, &again, &error) == FF_OK, "reading")) return;
    check(ff_table_samples(again) == ff_table_samples(t) && !strcmp(ff_table_format(again), "csv"), "what was read");
    check(ff_survey_new(again, &survey, &error) == FF_OK, "survey");
    check(ff_resample(again, ff_format_find("csv"), NULL, &made, &report, &error) == FF_OK && report.as_it_is, "resampling");
    check(ff_table_reduce(again, "mean", &mean, &error) == FF_OK && ff_table_channel_count(mean) == 1, "mean");
    check(ff_interpolant_new(again, 0, &between, &error) == FF_OK, "interpolation");
    ff_interpolant_free(between);
    ff_survey_free(survey);
    ff_table_free(mean);
    ff_table_free(made);
    ff_table_free(again);
    remove(path);
    check(ff_table_read(path, NULL, &again, &error) == FF_ERR_OPEN && !strcmp(error.path, path), "a file that is gone");
}

static void simulate_and_retrieve(const char *path)
{
    ff_model *m;
    ff_table *t;
    ff_simulate_options o;
    ff_sampler *sampler;
    ff_integral albedo;
    double shape[16], channel[16];
    const double wo[3] = {0, 0, 1};
    if (!check(ff_model_new("ggx+lambert", &m, &error) == FF_OK, "model")) return;
    check(ff_model_param_count(m, FF_PARAM_SHAPE) <= 16 && ff_model_param_count(m, FF_PARAM_CHANNEL) <= 16,
          "room for the parameters");
    ff_model_defaults(m, 1, shape, channel);
    check(ff_model_set(m, 1, "alpha=0.3", shape, channel, &error) == FF_OK, "alpha");
    ff_simulate_options_init(&o);
    check(ff_simulate(m, 1, shape, channel, &o, &t, &error) == FF_OK, "simulation");
    check(ff_albedo_directional(m, FF_ISA_BEST, 1, shape, channel, wo, &albedo, &error) == FF_OK && albedo.value > 0, "albedo");
    check(ff_sampler_new(m, FF_ISA_BEST, 1, shape, channel, &sampler, &error) == FF_OK, "sampler");
    ff_sampler_free(sampler);
    go_through_files(t, path);
    retrieve(t);
    ff_table_free(t);
    ff_model_free(m);
}

int main(int argc, char **argv)
{
    check(ff_version_number() == FF_VERSION_NUMBER && !strcmp(ff_version(), FF_VERSION_STRING), "version");
    check(argc == 2, "usage: consumer FILE-TO-WRITE");
    fit_own_values();
    if (argc == 2) simulate_and_retrieve(argv[1]);
    return wrong != 0;
}
