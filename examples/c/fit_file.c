/* fit_file FILE [MODEL]: fits a model to a measured file, whatever its format, and prints what was found with its errors.
 *
 *   cc fit_file.c $(pkg-config --cflags --libs facetfit) -lm -o fit_file */
#include <facetfit/ff_fit.h>
#include <facetfit/ff_table.h>
#include <facetfit/ff_words.h>
#include <stdio.h>

static void print_value(const char *name, const char *channel, const ff_fit_value *v)
{
    if (v->held || v->tied) return;
    printf("%-8s %-6s %10.5g +- %.2g, 95 %% from %.5g to %.5g\n", name, channel, v->value, v->std_error, v->low, v->high);
}

static void print_fit(const ff_problem *p, const ff_fit_result *fit)
{
    const ff_model *m = ff_fit_result_model(fit);
    const ff_param_kind kinds[] = {FF_PARAM_SHAPE, FF_PARAM_CHANNEL};
    char sentence[1024];
    for (int kind = 0; kind < 2; kind++)
        for (uint32_t k = 0; k < ff_model_param_count(m, kinds[kind]); k++) {
            const ff_param_ref ref = {kinds[kind], k};
            const size_t channels = kind ? ff_fit_result_channel_count(fit) : 1;
            for (size_t c = 0; c < channels; c++)
                print_value(ff_model_param_at(m, ref)->name, kind ? ff_problem_channel_name(p, c) : "", ff_fit_result_at(fit, ref, c));
        }
    for (size_t k = 0; k < ff_fit_result_warning_count(fit); k++) {
        ff_words_fit_warning(p, fit, ff_fit_result_warning(fit, k), sentence, sizeof sentence);
        printf("%s: %s\n", ff_severity_name((int)ff_fit_result_warning(fit, k)->severity), sentence);
    }
}

int main(int argc, char **argv)
{
    ff_error err = {0};
    ff_table *table = NULL;
    ff_model *model = NULL;
    ff_problem *problem = NULL;
    ff_fit_result *fit = NULL;
    ff_fit_options options;
    char message[1024];
    if (argc < 2) return fprintf(stderr, "usage: fit_file FILE [MODEL]\n"), 2;
    ff_fit_options_init(&options);
    ff_status status = ff_table_read(argv[1], NULL, &table, &err);
    if (!status) status = ff_model_new(argc > 2 ? argv[2] : "ggx+lambert", &model, &err);
    if (!status) status = ff_problem_new(table, (const ff_model *[]){model}, 1, &options, &problem, &err);
    if (!status) status = ff_problem_fit(problem, model, &options, &fit, &err);
    if (!status) print_fit(problem, fit);
    if (status) ff_words_error(&err, message, sizeof message), fprintf(stderr, "fit_file: %s\n", message);
    ff_fit_result_free(fit);
    ff_problem_free(problem);
    ff_model_free(model);
    ff_table_free(table);
    return status ? 1 : 0;
}
