/* facetfit fit FILE: one model. */
#include "internal_batching.h"
#include <string.h>
#include <stdlib.h>

static ff_status write_json(const void *report, FILE *out)
{
    return ff_report_fits_json(report, out);
}

static ff_status write_text(const void *report, FILE *out)
{
    return ff_report_fit_text(report, out);
}

/* Do the flags ask for something that needs to know where samples lie? */
static int looks_at_samples(const cli_args *args)
{
    return cli_given(args, FLAG_BOOTSTRAP) || cli_given(args, FLAG_REACH) || cli_given(args, FLAG_RESIDUALS) ||
           cli_given(args, FLAG_SCALE_UNCERTAINTY) || cli_given(args, FLAG_OFFSET_UNCERTAINTY) ||
           cli_given(args, FLAG_ANGLE_UNCERTAINTY) || cli_given(args, FLAG_APERTURE_UNCERTAINTY) ||
           strcmp(cli_value(args, FLAG_ROBUST, "none"), "none") || cli_given(args, FLAG_JSON) || cli_given(args, FLAG_HTML) ||
           !strcmp(cli_value(args, FLAG_ERRORS, ""), "incidences") || !strcmp(cli_value(args, FLAG_WEIGHT, ""), "noise");
}

static ff_status write_table(const void *report, ff_table_form form, FILE *out)
{
    return ff_report_fit_table(report, form, out);
}

static void say_warnings(const void *report, FILE *out)
{
    const ff_report_fits *r = report;
    for (size_t i = 0; i < r->n_fits; i++) ff_report_fit_warnings(r, i, out);
}

/* The residuals by angle of the free fits beside those for a renderer. */
static int look_at_free(const cli_fitting *f, const cli_trust *trust, size_t n, ff_report_target *target, ff_bands *bands)
{
    ff_error err = {0};
    for (size_t i = 0; i < n && target; i++) {
        const ff_status status =
            ff_trust_bands_into(f->problem[i], &trust->looks.places[i], &f->options, target[i].free, &bands[i], &err);
        if (status != FF_OK) return cli_failed(status, &err);
        target[i].free_bands = &bands[i];
    }
    return EXIT_DONE;
}

/* What the flags want to know of finished fits, and the report. adaptive: how their loss was chosen, NULL when it was given. target
 * [n]: the renderer that they were made for, NULL for none. */
static int finish(const cli_args *args, cli_fitting *f, ff_fit_result *fit, size_t n, const ff_adaptive *adaptive,
                  ff_report_target *target)
{
    cli_trust trust = {0};
    ff_bands *bands = calloc(n, sizeof *bands);
    int status = bands ? cli_trust_read(args, &f->options, &trust) : cli_failed(FF_ERR_MEMORY, NULL);
    if (status == EXIT_DONE) status = cli_trust_fit(&trust, f, fit, n);
    if (status == EXIT_DONE) status = look_at_free(f, &trust, n, target, bands);
    if (status == EXIT_DONE) status = cli_residuals_write(args, &trust, f, fit);
    if (status == EXIT_DONE) {
        ff_report_fits report = cli_fitting_report(args, f, fit, n);
        cli_trust_report(&trust, &report);
        report.adaptive = adaptive;
        report.target = target;
        status = cli_page_fits(args, &report);
        if (status == EXIT_DONE) status = cli_report(args, &(cli_form){write_json, write_text, write_table, say_warnings}, &report);
        for (size_t i = 0; i < n; i++) {
            const int outcome = cli_fitting_say_outcome(&fit[i]);
            if (status == EXIT_DONE) status = outcome;
            if (status == EXIT_DONE) status = cli_fitting_say_determined(&fit[i]);
        }
    }
    cli_trust_free(&trust);
    free(bands);
    return status;
}

/* One fit for each choice of channels, with the loss that was asked for. */
static int fit_all(const cli_args *args, cli_fitting *f, const ff_model *model)
{
    const ff_fitting d = cli_fitting_data(f);
    ff_error err = {0};
    size_t n = 0;
    ff_fit_result *fit = calloc(f->n_problems, sizeof *fit);
    ff_status failed = fit ? FF_OK : FF_ERR_MEMORY;
    while (failed == FF_OK && n < f->n_problems) {
        failed = ff_fitting_fit(&d, n, model, &fit[n], &err);
        n += failed == FF_OK;
    }
    const int status = failed == FF_OK ? finish(args, f, fit, n, NULL, NULL) : cli_failed(failed, &err);
    for (size_t i = 0; i < n; i++) ff_fit_result_clear(&fit[i]);
    free(fit);
    return status;
}

/* --loss auto: a fit with every loss, of which one is reported in full. */
static int fit_adaptive(const cli_args *args, cli_fitting *f, const ff_model *model, const char *expression)
{
    ff_error err = {0};
    ff_adaptive *all = malloc(sizeof *all);
    const ff_status failed = all ? cli_fitting_choose(f, model, expression, all, &err) : FF_ERR_MEMORY;
    if (failed != FF_OK) {
        free(all);
        return cli_failed(failed, &err);
    }
    f->problem = &all->problem; /* for as long as it lasts */
    f->n_problems = 1;
    const int status = finish(args, f, &all->candidate[all->chosen].fit, 1, all, NULL);
    f->problem = NULL;
    f->n_problems = 0;
    ff_adaptive_clear(all);
    free(all);
    return status;
}

/* ---- for a renderer -------------------------------------------------------------------------- */

/* Fits model m to every problem, into fit [n_problems]; *n counts them. A model that the options rule out is left out, with none.
 */
static ff_status fit_model(cli_fitting *f, const ff_model *m, ff_fit_result *fit, size_t *n, ff_error *err)
{
    char expression[FF_MODEL_NAME];
    ff_model_expression(m, expression, sizeof expression);
    for (*n = 0; *n < f->n_problems; (*n)++) {
        const ff_status status = cli_fitting_run(f, *n, m, expression, &fit[*n], err);
        if (status == FF_ERR_UNSUPPORTED && *n == 0) {
            cli_note("left out %s: %s", expression, err->message);
            return FF_OK;
        }
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

/* The free model first, by which the data are weighed where they are weighed by their noise. */
static ff_status fit_free(cli_fitting *f, const ff_model *m, ff_fit_result *fit, size_t *n, ff_error *err)
{
    const ff_fitting d = cli_fitting_data(f);
    for (*n = 0; *n < f->n_problems; (*n)++) {
        const ff_status status = ff_fitting_fit(&d, *n, m, &fit[*n], err);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

static double objective_of(const ff_fit_result *fit, size_t n)
{
    double sum = 0;
    for (size_t i = 0; i < n; i++) sum += fit[i].residual.objective;
    return sum;
}

static void clear(ff_fit_result *fit, size_t n)
{
    for (size_t i = 0; i < n; i++) ff_fit_result_clear(&fit[i]);
}

/* The material that fits best, into fit [n_problems]; *best: its number, all->n where none could be fitted. */
static ff_status fit_materials(cli_fitting *f, const cli_combinations *all, ff_fit_result *fit, ff_fit_result *room, size_t *best,
                               ff_error *err)
{
    ff_status status = FF_OK;
    size_t n = 0;
    *best = all->n;
    for (size_t m = 0; m < all->n && status == FF_OK; m++) {
        status = fit_model(f, &all->model[m], room, &n, err);
        if (status == FF_OK && n && (*best == all->n || objective_of(room, n) < objective_of(fit, n))) {
            if (*best < all->n) clear(fit, n);
            memcpy(fit, room, n * sizeof *fit);
            *best = m;
        } else
            clear(room, n);
    }
    if (status != FF_OK && *best < all->n) clear(fit, f->n_problems);
    if (status == FF_OK && *best == all->n)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "no material of the renderer can be fitted with these options");
    return status;
}

/* Fits [3][n_problems]: of the chosen material, of the free model, and room for those that lose. */
static int fit_for_with(const cli_args *args, cli_fitting *f, const cli_combinations *all, const ff_model *other,
                        ff_fit_result *fit, ff_report_target *target)
{
    const size_t P = f->n_problems;
    ff_error err = {0};
    size_t best = all->n, n = 0;
    ff_status failed = fit_free(f, other, fit + P, &n, &err);
    if (failed == FF_OK) failed = fit_materials(f, all, fit, fit + 2 * P, &best, &err);
    if (failed != FF_OK) {
        clear(fit + P, n);
        return cli_failed(failed, &err);
    }
    for (size_t i = 0; i < P; i++) {
        target[i] = all->target[best];
        target[i].free = &fit[P + i];
    }
    const int status = finish(args, f, fit, P, NULL, target);
    clear(fit, 2 * P);
    return status;
}

static int fit_for(const cli_args *args, cli_fitting *f, const cli_combinations *all, const ff_model *other)
{
    ff_fit_result *fit = calloc(3 * f->n_problems, sizeof *fit);
    ff_report_target *target = calloc(f->n_problems, sizeof *target);
    const int status = fit && target ? fit_for_with(args, f, all, other, fit, target) : cli_failed(FF_ERR_MEMORY, NULL);
    free(target);
    free(fit);
    return status;
}

/* --for: what the renderer evaluates, and beside it the model of --model, which is free. */
static int fit_for_renderer(const cli_args *args)
{
    const char *expression = cli_value(args, FLAG_MODEL, "ggx+lambert");
    cli_fitting f;
    cli_tables tables;
    cli_combinations all;
    cli_constraints constraints = {.n_names = 0};
    ff_error err = {0};
    if (!strcmp(cli_value(args, FLAG_LOSS, ""), "auto"))
        return cli_usage(args, "--for compares residuals of one loss: name it, not auto");
    int status = cli_tables_read(args, &tables);
    if (status != EXIT_DONE) return status;
    status = cli_renderers_read(args, 0, &all);
    if (status == EXIT_DONE) { /* there is room for one more */
        ff_model *other = &all.model[all.n];
        ff_status failed = ff_model_parse(expression, other, &err);
        if (failed == FF_OK) failed = cli_tables_give(&tables, other, &err);
        status = failed == FF_OK ? cli_hold_and_free(args, other, 1) : cli_failed(failed, &err);
    }
    if (status == EXIT_DONE) status = cli_names_known(args, all.model, all.n + 1);
    if (status == EXIT_DONE) status = cli_residuals_check(args);
    if (status == EXIT_DONE) status = cli_constraints_read(args, all.model, all.n + 1, 1, &constraints);
    if (status == EXIT_DONE) status = cli_fitting_open(args, args->word[0], all.model, all.n + 1, 1, &f);
    if (status == EXIT_DONE) {
        f.options.constraints = &constraints.c;
        status = cli_polarize_channels(args, &f.table, all.model, all.n + 1, &constraints);
        if (status == EXIT_DONE) status = fit_for(args, &f, &all, &all.model[all.n]);
        cli_fitting_close(&f);
    }
    cli_constraints_free(&constraints);
    free(all.model);
    free(all.target);
    cli_tables_free(&tables);
    return status;
}

static int fit_file(const cli_args *args)
{
    if (cli_given(args, FLAG_FOR)) return fit_for_renderer(args);
    const char *expression = cli_value(args, FLAG_MODEL, "ggx+lambert");
    cli_fitting f;
    ff_model model;
    ff_error err = {0};
    ff_status failed = ff_model_parse(expression, &model, &err);
    cli_tables tables;
    if (failed != FF_OK) return cli_failed(failed, &err);
    int status = cli_tables_read(args, &tables);
    if (status != EXIT_DONE) return status;
    failed = cli_tables_give(&tables, &model, &err);
    status = failed == FF_OK ? cli_hold_and_free(args, &model, 0) : cli_failed(failed, &err);
    if (status == EXIT_DONE) status = cli_residuals_check(args);
    cli_constraints constraints = {.n_names = 0};
    if (status == EXIT_DONE) status = cli_constraints_read(args, &model, 1, 0, &constraints);
    if (status == EXIT_DONE) status = cli_fitting_open(args, args->word[0], &model, 1, looks_at_samples(args), &f);
    if (status != EXIT_DONE) {
        cli_constraints_free(&constraints);
        cli_tables_free(&tables);
        return status;
    }
    f.options.constraints = &constraints.c;
    status = cli_polarize_channels(args, &f.table, &model, 1, &constraints);
    if (status == EXIT_DONE) status = f.choose_loss ? fit_adaptive(args, &f, &model, expression) : fit_all(args, &f, &model);
    cli_fitting_close(&f);
    cli_constraints_free(&constraints);
    cli_tables_free(&tables);
    return status;
}

int cmd_fit(const cli_args *args)
{
    const int status = cli_batch_words_check(args);
    if (status != EXIT_DONE) return status;
    return cli_batch_wanted(args) ? cli_batch_run(args, fit_file) : fit_file(args);
}
