/* Evaluates a model, fits it to its own values and must get its parameters back: a program in C that has nothing but the
 * installed headers and libraries. */
#include <facetfit/ff_fit.h>
#include <facetfit/ff_model.h>
#include <facetfit/ff_table.h>
#include <math.h>
#include <stdio.h>

enum { SAMPLES = 500 };

static int report(ff_status status, const ff_error *error, const char *what)
{
    char message[1024];
    if (status == FF_OK) return 0;
    ff_error_format(error, message, sizeof message);
    fprintf(stderr, "%s: %s: %s\n", what, ff_status_str(status), message);
    return 1;
}

/* Directions that cover the hemisphere evenly enough: multiples of irrational numbers. */
static void fill_directions(ff_table *t)
{
    const double step[4] = {0.7548776662, 0.5698402910, 0.8191725134, 0.6710436067}, span[4] = {75, 360, 75, 360};
    for (size_t i = 0; i < SAMPLES; i++) {
        for (int k = 0; k < 4; k++) t->angle[k][i] = span[k] * fmod((double)(i + 1) * step[k], 1);
    }
    t->radians_per_unit = acos(-1) / 180;
}

int main(void)
{
    ff_error error = {0};
    ff_model model;
    ff_table table = {0};
    ff_problem *problem = NULL;
    ff_fit_result fit;
    ff_fit_options options;
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS], planes[6][SAMPLES];
    double *const directions[6] = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};
    const ff_dirs dirs = {planes[0], planes[1], planes[2], planes[3], planes[4], planes[5]};

    if (report(ff_model_parse("ggx", &model, &error), &error, "model")) return 1;
    ff_model_defaults(&model, 1, shape, channel);
    const char *const truth[] = {"alpha_x=0.3", "alpha_y=0.5", "r_xy=0.2", "f0=0.8"};
    for (size_t i = 0; i < sizeof truth / sizeof truth[0]; i++) {
        if (report(ff_model_set(&model, 1, truth[i], shape, channel, &error), &error, truth[i])) return 1;
    }
    if (report(ff_table_new(SAMPLES, 1, NULL, 0, 0, &table, &error), &error, "table")) return 1;
    fill_directions(&table);
    ff_table_directions(&table, 0, SAMPLES, directions);
    const ff_status evaluated = ff_model_eval(&model, FF_ISA_BEST, 1, shape, channel, &dirs, SAMPLES, table.value, NULL, SAMPLES);
    if (report(evaluated, &error, "evaluation")) return 1;

    ff_fit_options_init(&options);
    options.threads = 1;
    options.shape = FF_SHAPE_CORRELATED;
    if (report(ff_problem_new(&table, &model, 1, &options, &problem, &error), &error, "problem")) return 1;
    if (report(ff_problem_fit(problem, &model, &options, &fit, &error), &error, "fit")) return 1;

    int wrong = fit.outcome != FF_CONVERGED;
    for (size_t i = 0; i < sizeof truth / sizeof truth[0]; i++) {
        char name[FF_PARAM_NAME];
        double expected;
        if (sscanf(truth[i], "%31[a-z_0]=%lf", name, &expected) != 2) return 1;
        const double found = ff_fit_result_find(&fit, name, 0)->value;
        printf("%-8s %.6f, is %.6f\n", name, found, expected);
        wrong |= !(fabs(found - expected) < 1e-4);
    }
    ff_fit_result_free(&fit);
    ff_problem_free(problem);
    ff_table_free(&table);
    return wrong;
}
