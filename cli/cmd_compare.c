/* facetfit compare FILE: every combination on the same samples. */
#define _GNU_SOURCE
#include "internal_batching.h"
#include <stdlib.h>
#include <string.h>

static ff_status write_json(const void *report, FILE *out)
{
    return ff_report_fits_json(report, out);
}

static ff_status write_text(const void *report, FILE *out)
{
    return ff_report_compare_text(report, out);
}

static ff_status write_table(const void *report, ff_table_form form, FILE *out)
{
    return ff_report_compare_table(report, form, out);
}

/* Of the best of every problem, as in the text. */
static void say_warnings(const void *report, FILE *out)
{
    const ff_report_fits *r = report;
    const size_t n = r->n_fits / r->n_problems;
    size_t *rank = malloc(n * sizeof *rank);
    for (size_t p = 0; p < r->n_problems && rank; p++) {
        ff_report_rank(r, p, rank);
        ff_report_fit_warnings(r, rank[0], out);
    }
    free(rank);
}

/* Says which fits did not converge; the answer is no when the best of a problem is among them. */
static int say_outcomes(const ff_report_fits *r)
{
    const size_t n = r->n_fits / r->n_problems;
    size_t *rank = malloc(n * sizeof *rank);
    int status = EXIT_DONE;
    if (!rank) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t p = 0; p < r->n_problems; p++) {
        ff_report_rank(r, p, rank);
        if (r->fit[rank[0]].outcome != FF_CONVERGED) status = EXIT_ANSWER_IS_NO;
        if (status == EXIT_DONE) status = cli_fitting_say_determined(&r->fit[rank[0]]);
    }
    for (size_t i = 0; i < r->n_fits; i++) cli_fitting_say_outcome(&r->fit[i]);
    free(rank);
    return status;
}

/* Every model, on every problem; of a renderer's materials also whose they are. */
static ff_status fit_all(cli_fitting *f, const cli_combinations *all, ff_fit_result *fit, ff_report_target *target, size_t *n,
                         ff_error *err)
{
    const ff_fitting d = cli_fitting_data(f);
    size_t *which = malloc((all->n * f->n_problems + 1) * sizeof *which);
    if (!which) return FF_ERR_MEMORY;
    const ff_status status = ff_fitting_fit_all(&d, all->model, all->n, fit, which, n, err);
    for (size_t i = 0; i < *n && all->target; i++) target[i] = all->target[which[i]];
    free(which);
    return status;
}

/* Comparisons with the best fits, their residuals by angle and, where asked for, by sample. */
static int look_closer(const cli_args *args, const ff_report_fits *r, ff_fit_result *fit, cli_trust *trust, cli_fitting *f)
{
    const size_t models = r->n_fits / r->n_problems;
    size_t *rank = malloc((models + r->n_problems) * sizeof *rank);
    if (!rank) return cli_failed(FF_ERR_MEMORY, NULL);
    size_t *best = rank + models;
    for (size_t p = 0; p < r->n_problems; p++) {
        ff_report_rank(r, p, rank);
        best[p] = rank[0];
    }
    int status = cli_trust_compare(trust, f, fit, r->n_fits, best);
    if (status == EXIT_DONE) status = cli_residuals_write(args, trust, f, &r->fit[best[0]]);
    free(rank);
    return status;
}

static int compare(const cli_args *args, cli_fitting *f, const cli_combinations *all)
{
    const size_t n_models = all->n;
    ff_error err = {0};
    size_t n = 0;
    cli_trust trust = {0};
    int status = cli_trust_read(args, &f->options, &trust);
    if (status != EXIT_DONE) return status;
    ff_fit_result *fit = calloc(n_models * f->n_problems + 1, sizeof *fit);
    ff_report_target *target = calloc(n_models * f->n_problems + 1, sizeof *target);
    const ff_status failed = fit && target ? fit_all(f, all, fit, target, &n, &err) : FF_ERR_MEMORY;
    if (failed == FF_OK) {
        ff_report_fits report = cli_fitting_report(args, f, fit, n);
        if (all->target) report.target = target;
        report.rows = (size_t)cli_integer(args, FLAG_ROWS, 25);
        status = look_closer(args, &report, fit, &trust, f);
        if (status == EXIT_DONE) {
            cli_trust_report(&trust, &report);
            status = cli_page_fits(args, &report);
        }
        if (status == EXIT_DONE) {
            status = cli_report(args, &(cli_form){write_json, write_text, write_table, say_warnings}, &report);
        }
        const int outcome = say_outcomes(&report);
        if (status == EXIT_DONE) status = outcome;
    } else {
        status = cli_failed(failed, &err);
    }
    cli_trust_free(&trust);
    for (size_t i = 0; i < n; i++) ff_fit_result_clear(&fit[i]);
    free(fit);
    free(target);
    return status;
}

static int compare_file(const cli_args *args)
{
    cli_tables tables;
    cli_fitting f;
    cli_combinations all;
    int status = cli_tables_read(args, &tables);
    if (status != EXIT_DONE) return status;
    if (cli_given(args, FLAG_FOR))
        status = cli_renderers_read(args, 1, &all);
    else
        status = cli_combine(args, &tables, "all", "all", &all);
    if (status == EXIT_DONE) status = cli_names_known(args, all.model, all.n);
    if (status == EXIT_DONE) status = cli_residuals_check(args);
    cli_constraints constraints = {.n_names = 0};
    if (status == EXIT_DONE) status = cli_constraints_read(args, all.model, all.n, 1, &constraints);
    if (status == EXIT_DONE) status = cli_fitting_open(args, args->word[0], all.model, all.n, 1, &f);
    if (status == EXIT_DONE) {
        f.options.constraints = &constraints.c;
        status = cli_polarize_channels(args, &f.table, all.model, all.n, &constraints);
        if (status == EXIT_DONE) status = compare(args, &f, &all);
        cli_fitting_close(&f);
    }
    free(all.model);
    free(all.target);
    cli_constraints_free(&constraints);
    cli_tables_free(&tables);
    return status;
}

int cmd_compare(const cli_args *args)
{
    const int status = cli_batch_words_check(args);
    if (status != EXIT_DONE) return status;
    return cli_batch_wanted(args) ? cli_batch_run(args, compare_file) : compare_file(args);
}
