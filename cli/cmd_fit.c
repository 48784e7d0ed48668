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
    cli_constraints constraints = {.n_names = 0};
    if (status == EXIT_DONE) status = cli_constraints_read(args, &model, 1, 0, &constraints);
    if (status == EXIT_DONE) status = cli_fitting_open(args, &model, 1, &f);
    if (status != EXIT_DONE) {
        cli_constraints_free(&constraints);
        cli_tables_free(&tables);
        return status;
    }
    f.options.constraints = &constraints.c;
    size_t n = 0;
    ff_fit_result *fit = calloc(f.n_problems, sizeof *fit);
    failed = fit ? FF_OK : FF_ERR_MEMORY;
    while (failed == FF_OK && n < f.n_problems) {
        failed = cli_fitting_run(&f, n, &model, expression, &fit[n], &err);
        n += failed == FF_OK;
    }
    if (failed == FF_OK) {
        const ff_report_fits report = cli_fitting_report(args, &f, fit, n);
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
    cli_fitting_close(&f);
    cli_constraints_free(&constraints);
    cli_tables_free(&tables);
    return status;
}
