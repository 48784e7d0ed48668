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
    return cli_given(args, FLAG_BOOTSTRAP) || cli_given(args, FLAG_RESIDUALS) || strcmp(cli_value(args, FLAG_ROBUST, "none"), "none") ||
           cli_given(args, FLAG_JSON);
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
    if (status == EXIT_DONE) status = cli_fitting_open(args, &model, 1, looks_at_samples(args), &f);
    if (status != EXIT_DONE) {
        cli_tables_free(&tables);
        return status;
    }
    size_t n = 0;
    cli_trust trust = {0};
    ff_fit_result *fit = calloc(f.n_problems, sizeof *fit);
    failed = fit ? FF_OK : FF_ERR_MEMORY;
    status = cli_trust_read(args, &f.options, &trust);
    while (status == EXIT_DONE && failed == FF_OK && n < f.n_problems) {
        failed = cli_fitting_run(&f, n, &model, expression, &fit[n], &err);
        n += failed == FF_OK;
    }
    if (failed == FF_OK && status == EXIT_DONE) status = cli_trust_fit(&trust, &f, fit, n);
    if (failed == FF_OK && status == EXIT_DONE) status = cli_residuals_write(&trust, &f, fit);
    if (failed == FF_OK && status == EXIT_DONE) {
        ff_report_fits report = cli_fitting_report(args, &f, fit, n);
        cli_trust_report(&trust, &report);
        status = cli_write_both(args, write_json, write_text, &report);
        for (size_t i = 0; i < n; ++i) {
            const int outcome = cli_fitting_say_outcome(&fit[i]);
            if (status == EXIT_DONE) status = outcome;
        }
    } else if (failed != FF_OK) {
        status = cli_failed(failed, &err);
    }
    cli_trust_free(&trust);
    for (size_t i = 0; i < n; ++i) ff_fit_result_free(&fit[i]);
    free(fit);
    cli_fitting_close(&f);
    cli_tables_free(&tables);
    return status;
}
