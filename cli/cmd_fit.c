/* facetfit fit FILE: one model. */
#include "internal_cli.h"
#include <stdlib.h>

static ff_status write_json(const void *report, FILE *out)
{
    return ff_report_fits_json(report, out);
}

static ff_status write_text(const void *report, FILE *out)
{
    return ff_report_fit_text(report, out);
}

/* One fit for each choice of channels, with the loss that was asked for. */
static int fit_all(const cli_args *args, cli_fitting *f, const ff_model *model, const char *expression)
{
    ff_error err = {0};
    size_t n = 0;
    int status;
    ff_fit_result *fit = calloc(f->n_problems, sizeof *fit);
    ff_status failed = fit ? FF_OK : FF_ERR_MEMORY;
    while (failed == FF_OK && n < f->n_problems) {
        failed = cli_fitting_run(f, n, model, expression, &fit[n], &err);
        n += failed == FF_OK;
    }
    if (failed == FF_OK) {
        const ff_report_fits report = cli_fitting_report(args, f, fit, n);
        status = cli_write_both(args, write_json, write_text, &report);
        for (size_t i = 0; i < n; ++i) {
            const int outcome = cli_fitting_say_outcome(&fit[i]);
            if (status == EXIT_DONE) status = outcome;
        }
    } else {
        status = cli_failed(failed, &err);
    }
    for (size_t i = 0; i < n; ++i) ff_fit_result_free(&fit[i]);
    free(fit);
    return status;
}

/* --loss auto: a fit with every loss, of which one is reported in full. */
static int fit_adaptive(const cli_args *args, cli_fitting *f, const ff_model *model, const char *expression)
{
    ff_error err = {0};
    ff_adaptive all;
    const ff_status failed = cli_fitting_choose(f, model, expression, &all, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    const ff_fit_result *fit = &all.candidate[all.chosen].fit;
    ff_report_fits report = cli_fitting_report(args, f, fit, 1);
    report.n_problems = 1;
    report.problem = (const ff_problem *const *)&all.problem;
    report.adaptive = &all;
    int status = cli_write_both(args, write_json, write_text, &report);
    const int outcome = cli_fitting_say_outcome(fit);
    if (status == EXIT_DONE) status = outcome;
    ff_adaptive_free(&all);
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
    if (status == EXIT_DONE) status = cli_fitting_open(args, &model, 1, &f);
    if (status != EXIT_DONE) {
        cli_tables_free(&tables);
        return status;
    }
    status = f.choose_loss ? fit_adaptive(args, &f, &model, expression) : fit_all(args, &f, &model, expression);
    cli_fitting_close(&f);
    cli_tables_free(&tables);
    return status;
}
