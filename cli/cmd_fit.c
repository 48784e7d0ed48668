/* facetfit fit FILE: one model. */
#include "internal_cli.h"
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

/* What the flags want to know of finished fits, and the report. adaptive: how their loss was chosen, NULL when it was given. */
static int finish(const cli_args *args, cli_fitting *f, ff_fit_result *fit, size_t n, const ff_adaptive *adaptive)
{
    cli_trust trust = {0};
    int status = cli_trust_read(args, &f->options, &trust);
    if (status == EXIT_DONE) status = cli_trust_fit(&trust, f, fit, n);
    if (status == EXIT_DONE) status = cli_residuals_write(&trust, f, fit);
    if (status == EXIT_DONE) {
        ff_report_fits report = cli_fitting_report(args, f, fit, n);
        cli_trust_report(&trust, &report);
        report.adaptive = adaptive;
        status = cli_page_fits(args, &report);
        if (status == EXIT_DONE) status = cli_report(args, &(cli_form){write_json, write_text, write_table, say_warnings}, &report);
        for (size_t i = 0; i < n; i++) {
            const int outcome = cli_fitting_say_outcome(&fit[i]);
            if (status == EXIT_DONE) status = outcome;
            if (status == EXIT_DONE) status = cli_fitting_say_determined(&fit[i]);
        }
    }
    cli_trust_free(&trust);
    return status;
}

/* The fit anew with weights by the noise that it has found. */
static ff_status fit_by_noise(cli_fitting *f, size_t problem, const ff_model *model, const char *expression, ff_fit_result *fit,
                              ff_error *err)
{
    int weighed = 0;
    ff_fit_result again;
    ff_status status = cli_fitting_weigh(f, problem, fit, &weighed, err);
    if (status != FF_OK || !weighed) return status;
    status = cli_fitting_run(f, problem, model, expression, &again, err);
    if (status != FF_OK) return status;
    ff_fit_result_clear(fit);
    *fit = again;
    return FF_OK;
}

/* One fit for each choice of channels, with the loss that was asked for. */
static int fit_all(const cli_args *args, cli_fitting *f, const ff_model *model, const char *expression)
{
    ff_error err = {0};
    size_t n = 0;
    ff_fit_result *fit = calloc(f->n_problems, sizeof *fit);
    ff_status failed = fit ? FF_OK : FF_ERR_MEMORY;
    while (failed == FF_OK && n < f->n_problems) {
        failed = cli_fitting_scale(f, n, model, &err);
        if (failed == FF_OK) failed = cli_fitting_run(f, n, model, expression, &fit[n], &err);
        n += failed == FF_OK;
        if (failed == FF_OK && f->by_noise) failed = fit_by_noise(f, n - 1, model, expression, &fit[n - 1], &err);
    }
    const int status = failed == FF_OK ? finish(args, f, fit, n, NULL) : cli_failed(failed, &err);
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
    const int status = finish(args, f, &all->candidate[all->chosen].fit, 1, all);
    f->problem = NULL;
    f->n_problems = 0;
    ff_adaptive_clear(all);
    free(all);
    return status;
}

int cmd_fit(const cli_args *args)
{
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
    status = f.choose_loss ? fit_adaptive(args, &f, &model, expression) : fit_all(args, &f, &model, expression);
    cli_fitting_close(&f);
    cli_constraints_free(&constraints);
    cli_tables_free(&tables);
    return status;
}
