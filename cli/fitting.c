/* What `fit` and `compare` share: options from flags, the data, problems, progress. */
#define _GNU_SOURCE
#include "internal_cli.h"
#include "data_formats/analysis/internal_diagnosis.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const double pi = 3.14159265358979323846;

/* ---- options --------------------------------------------------------------------------------- */

/* The scale after the name; the parser knows the name. */
static int read_robust(const cli_args *args, ff_fit_options *o)
{
    const char *text = cli_value(args, FLAG_ROBUST, NULL), *colon = text ? strchr(text, ':') : NULL;
    o->robust = (ff_robust)cli_word(args, FLAG_ROBUST, FF_ROBUST_NONE);
    if (!colon || (o->robust != FF_ROBUST_NONE && cli_number_read(colon + 1, &o->robust_scale) && o->robust_scale > 0))
        return EXIT_DONE;
    return cli_usage(args, "--robust %s: expected NAME, or NAME:SCALE with a scale above 0, e.g. huber:0.1", text);
}

/* The noise belongs to the fitting, which the options borrow it from. */
static int read_noise(const cli_args *args, cli_fitting *f)
{
    const char *text = cli_value(args, FLAG_NOISE_MODEL, NULL);
    ff_error err = {0};
    f->by_noise = f->options.weighting == FF_WEIGHT_NOISE;
    f->options.errors = (ff_error_source)cli_word(args, FLAG_ERRORS, f->by_noise ? FF_ERRORS_INCIDENCES : FF_ERRORS_NOISE);
    f->errors_given = cli_given(args, FLAG_ERRORS) > 0;
    if (f->by_noise && f->options.errors == FF_ERRORS_RESIDUALS)
        return cli_usage(args, "weights by the noise need the noise: --errors noise or incidences");
    if (f->by_noise && f->options.robust != FF_ROBUST_NONE)
        return cli_usage(args, "weights by the noise are of sums of squares: leave out --robust");
    if (f->by_noise && f->choose_loss)
        return cli_usage(args, "weights by the noise take the place of the loss: leave out --loss auto");
    if (text && f->options.errors == FF_ERRORS_RESIDUALS && f->options.robust == FF_ROBUST_NONE)
        return cli_usage(args, "--noise-model has no effect on errors that rest on residuals: leave out --errors residuals");
    if (f->options.robust != FF_ROBUST_NONE && cli_given(args, FLAG_ERRORS) && f->options.errors == FF_ERRORS_NOISE)
        return cli_usage(args, "errors by the noise of the data are of sums of squares: leave out --robust, or --errors noise");
    if (text && f->options.robust_scale > 0)
        return cli_usage(args, "--noise-model is the scale of the robust loss: leave out one of --noise-model and --robust's %g",
                         f->options.robust_scale);
    if (!text) return EXIT_DONE;
    if (ff_noise_parse(text, &f->noise, &err)) return cli_usage(args, "--noise-model %s: %s", text, err.message);
    f->options.noise = f->noise;
    return EXIT_DONE;
}

/* "0.001", or "3sigma" where the data have standard deviations. */
static int read_noise_floor(const cli_args *args, ff_fit_options *o)
{
    const char *text = cli_value(args, FLAG_NOISE_FLOOR, NULL), *sigma = text ? strstr(text, "sigma") : NULL;
    char number[CLI_NAME];
    double x = 0;
    if (!text) return EXIT_DONE;
    snprintf(number, sizeof number, "%.*s", (int)(sigma ? sigma - text : (ptrdiff_t)strlen(text)), text);
    if (!cli_number_read(number, &x) || (sigma && (strcmp(sigma, "sigma") || !(x > 0))))
        return cli_usage(args, "--noise-floor %s: expected a value in 1/sr, or a number of standard deviations as in 3sigma", text);
    if (sigma)
        o->noise_sigmas = x;
    else
        o->noise_floor = x;
    return EXIT_DONE;
}

static int read_censoring(const cli_args *args, ff_fit_options *o)
{
    const int status = read_noise_floor(args, o);
    if (status != EXIT_DONE) return status;
    o->saturation = cli_number(args, FLAG_SATURATION, o->saturation);
    o->drop_negative = cli_word(args, FLAG_NEGATIVE, 0);
    if (!(o->noise_floor < o->saturation)) return cli_usage(args, "--noise-floor must lie below --saturation");
    return EXIT_DONE;
}

/* What cannot go with --loss auto. */
static int check_auto(const cli_args *args, const ff_fit_options *o)
{
    if (o->robust != FF_ROBUST_NONE)
        return cli_usage(args,
                         "--robust has its scale in units of the residual, which every loss has its own: name a --loss, not auto");
    if (o->channels == FF_CHANNELS_EACH)
        return cli_usage(args, "--loss auto compares pictures of all channels: with --channels each, name a loss");
    return EXIT_DONE;
}

static int read_options(const cli_args *args, ff_fit_options *o, int *choose_loss)
{
    const int loss = cli_word(args, FLAG_LOSS, FF_LOSS_COSINE); /* "auto", which `fit` knows, is one more */
    int status;
    ff_fit_options_init(o);
    if ((status = cli_isa(args, &o->isa)) || (status = read_robust(args, o)) || (status = read_censoring(args, o))) return status;
    *choose_loss = loss == FF_LOSS_COUNT;
    o->loss = *choose_loss ? FF_LOSS_COSINE : (ff_loss)loss;
    o->weighting = (ff_weighting)cli_word(args, FLAG_WEIGHT, FF_WEIGHT_AUTO);
    o->shape = (ff_shape)cli_word(args, FLAG_SHAPE, FF_SHAPE_AUTO);
    o->channels = (ff_channel_mode)cli_word(args, FLAG_CHANNELS, FF_CHANNELS_RGB);
    if (cli_given(args, FLAG_MAX_THETA)) o->max_theta = cli_number(args, FLAG_MAX_THETA, 80) * pi / 180;
    o->threads = args->job ? args->job->threads : (int)cli_integer(args, FLAG_THREADS, 0);
    o->max_iterations = (int)cli_integer(args, FLAG_MAX_ITERATIONS, (uint64_t)o->max_iterations);
    o->mean_slope = cli_switch(args, FLAG_MEAN_SLOPE, 0);
    return *choose_loss ? check_auto(args, o) : EXIT_DONE;
}

/* ---- data ------------------------------------------------------------------------------------ */

/* The table's values are in the problems now; what the report needs of it is small. */
static void release_samples(ff_table *t)
{
    ff_table small = {.n = t->n, .grid = t->grid, .quantity = t->quantity, .isotropic = t->isotropic};
    memcpy(small.format, t->format, sizeof small.format);
    small.n_channels = t->n_channels, small.channels = t->channels;
    t->channels = NULL;
    ff_table_clear(t);
    *t = small;
}

/* Is a finding said by the report, where the command has one that goes on? By its verdict, or where all that is known is the side
 * of the brightest samples, by a warning of the fit. */
static int is_for_report(const cli_args *args, const ff_finding *f)
{
    const int of_side = (f->kind == FF_DIAGNOSIS_TURNED || f->kind == FF_DIAGNOSIS_UNTURNED) && isnan(f->value[0]);
    const int has_verdict = args->command->id == COMMAND_fit || args->command->id == COMMAND_compare;
    return has_verdict &&
           (of_side || f->kind == FF_DIAGNOSIS_PERCENT || f->kind == FF_DIAGNOSIS_FACTOR || f->kind == FF_DIAGNOSIS_UNIT);
}

/* What the data say of their angles and values, before anything is fitted to them: where they leave no doubt and the file leaves
 * open what these are, nothing is, unless the person insists. Exit status. */
static int diagnose(const cli_args *args, const char *path, const ff_table *t, double max_theta)
{
    ff_diagnosis g;
    char text[FF_WORDS_SENTENCE];
    int stops = 0;
    if (cli_switch(args, FLAG_AS_IS, 0)) return EXIT_DONE;
    const ff_status failed = ff_diagnosis_find(t, max_theta, &g);
    if (failed != FF_OK) return cli_failed(failed, NULL);
    for (size_t k = 0; k < g.n; k++) {
        const ff_finding *f = &g.finding[k];
        const int open = ff_diagnosis_is_of_values(f) ? g.quantity_open : g.open;
        const int stops_here = open && f->sure && f->kind != FF_DIAGNOSIS_BEYOND;
        if (!stops_here && is_for_report(args, f)) continue;
        if (stops_here)
            cli_error("%s: %s, or --as-is to fit it as it stands", path, ff_words_finding(f, text));
        else
            cli_note("%s: %s", path, ff_words_finding(f, text));
        stops |= stops_here;
    }
    return stops ? EXIT_INPUT : EXIT_DONE;
}

int cli_fitting_open(const cli_args *args, const char *path, const ff_model *models, size_t n_models, int keep_samples,
                     cli_fitting *out)
{
    cli_fitting f = {.path = path, .keeps_samples = keep_samples};
    ff_error err = {0};
    int status = read_options(args, &f.options, &f.choose_loss);
    if (status == EXIT_DONE) status = cli_aperture(args, NULL, &f.aperture);
    f.options.aperture = &f.aperture;
    if (status == EXIT_DONE) status = read_noise(args, &f);
    if (status != EXIT_DONE) {
        ff_noise_free(f.noise);
        return status;
    }
    f.progress = !args->job && cli_progress_wanted(args);
    if ((status = cli_read(args, f.path, 1, &f.table)) != EXIT_DONE ||
        (status = diagnose(args, f.path, &f.table, f.options.max_theta)) != EXIT_DONE) {
        ff_table_clear(&f.table);
        ff_noise_free(f.noise);
        return status;
    }
    const ff_status failed =
        f.choose_loss ? FF_OK : ff_fitting_problems(&f.table, models, n_models, &f.options, &f.problem, &f.n_problems, &err);
    if (failed == FF_OK) {
        if (!keep_samples && !f.choose_loss) release_samples(&f.table);
        *out = f;
        out->options.aperture = &out->aperture;
        return EXIT_DONE;
    }
    cli_fitting_close(&f);
    if (!err.path[0] && err.code == failed) snprintf(err.path, sizeof err.path, "%s", path);
    return cli_failed(failed, &err);
}

void cli_fitting_close(cli_fitting *f)
{
    for (size_t i = 0; i < f->n_problems; i++) ff_problem_free(f->problem[i]);
    free(f->problem);
    ff_table_clear(&f->table);
    ff_noise_free(f->noise);
    memset(f, 0, sizeof *f);
}

/* ---- fits ------------------------------------------------------------------------------------ */

static void show(void *label, int iteration, double objective)
{
    char text[FF_REPORT_NUMBER];
    cli_progress_show("%s: iteration %d, objective %.12s", (const char *)label, iteration, ff_report_number(objective, text));
}

/* words [FF_MODEL_NAME + 64] must live as long as the fit. */
static void begin_progress(const cli_fitting *f, const char *label, char *words, ff_fit_options *o)
{
    snprintf(words, FF_MODEL_NAME + 64, "%s", label);
    if (!f->progress) return;
    o->progress = show;
    o->progress_context = words;
    cli_progress_show("%s", words);
}

ff_status cli_fitting_run(cli_fitting *f, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err)
{
    char words[FF_MODEL_NAME + 64];
    ff_fit_options o = f->options;
    begin_progress(f, label, words, &o);
    const ff_fitting d = {.path = f->path, .options = &o, .n_problems = f->n_problems, .problem = f->problem};
    const ff_status status = ff_fitting_run(&d, problem, m, out, err);
    if (f->progress) cli_progress_end();
    return status;
}

static ff_status run(void *fitting, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err)
{
    return cli_fitting_run(fitting, problem, m, label, out, err);
}

static void hear(void *fitting, const char *sentence)
{
    (void)fitting;
    cli_note("%s", sentence);
}

static void show_busy(void *fitting, const char *what)
{
    if (((const cli_fitting *)fitting)->progress) cli_progress_show("%s", what);
}

ff_fitting cli_fitting_data(cli_fitting *f)
{
    return (ff_fitting){.path = f->path,
                        .table = &f->table,
                        .options = &f->options,
                        .n_problems = f->n_problems,
                        .problem = f->problem,
                        .keeps_samples = f->keeps_samples,
                        .errors_given = f->errors_given,
                        .run = run,
                        .note = hear,
                        .busy = show_busy,
                        .context = f};
}

ff_status cli_fitting_choose(cli_fitting *f, const ff_model *m, const char *label, ff_adaptive *out, ff_error *err)
{
    char words[FF_MODEL_NAME + 64];
    ff_fit_options o = f->options;
    begin_progress(f, label, words, &o);
    const ff_status status = ff_fit_adaptive_into(&f->table, m, &o, out, err);
    if (f->progress) cli_progress_end();
    if (status == FF_OK)
        f->options.loss = out->candidate[out->chosen].loss;
    else if (!err->path[0])
        snprintf(err->path, sizeof err->path, "%s", f->path);
    return status;
}

/* Is there a parameter whose lobe or base came out as nothing? Its name; NULL: none. */
static const char *first_weightless(const ff_fit_result *fit)
{
    for (uint32_t k = 0; k < fit->model.n_shape; k++)
        if (fit->shape_value[k].weightless) return fit->model.shape[k].name;
    for (size_t k = 0; k < fit->n_channels * fit->model.n_channel; k++)
        if (fit->channel_value[k].weightless) return fit->model.channel[k % fit->model.n_channel].name;
    return NULL;
}

int cli_fitting_say_determined(const ff_fit_result *fit)
{
    char expression[FF_MODEL_NAME];
    const char *name = first_weightless(fit);
    if (!name) return EXIT_DONE;
    ff_model_expression(&fit->model, expression, sizeof expression);
    cli_error("%s: %s is not determined: what it belongs to reflects nothing in these data", expression, name);
    return EXIT_ANSWER_IS_NO;
}

int cli_fitting_say_outcome(const ff_fit_result *fit)
{
    char expression[FF_MODEL_NAME];
    if (fit->outcome == FF_CONVERGED) return EXIT_DONE;
    ff_model_expression(&fit->model, expression, sizeof expression);
    if (fit->outcome == FF_LIMIT) {
        cli_error("%s did not converge within %d iteration%s", expression, fit->iterations, fit->iterations == 1 ? "" : "s");
    } else {
        cli_error("%s did not converge: %s after %d iteration%s", expression, ff_outcome_name((int)fit->outcome), fit->iterations,
                  fit->iterations == 1 ? "" : "s");
    }
    return EXIT_ANSWER_IS_NO;
}

ff_report_fits cli_fitting_report(const cli_args *args, const cli_fitting *f, const ff_fit_result *fit, size_t n_fits)
{
    return (ff_report_fits){.head = args->head,
                            .path = f->path,
                            .table = &f->table,
                            .options = &f->options,
                            .n_problems = f->n_problems,
                            .problem = (const ff_problem *const *)f->problem,
                            .n_fits = n_fits,
                            .fit = fit,
                            .style = &args->style,
                            .again = cli_again,
                            .again_context = args,
                            .without_times = !cli_switch(args, FLAG_TIMES, 1)};
}
