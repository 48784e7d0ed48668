/* Measured data fitted for a figure: as `fit` and `compare` do it, and then as their JSON says it, so that a figure of a file and
 * one of its result are the same. */
#define _GNU_SOURCE
#include "internal_plotting.h"
#include "base/internal_kept.h"
#include <stdlib.h>
#include <string.h>

static int names_terms(const cli_args *args)
{
    return cli_given(args, FLAG_NDF) || cli_given(args, FLAG_MASKING) || cli_given(args, FLAG_FRESNEL) ||
           cli_given(args, FLAG_DIFFUSE);
}

static int one_model(const cli_args *args, cli_drawn_fits *d)
{
    ff_error err = {0};
    d->models.model = malloc(sizeof *d->models.model);
    if (!d->models.model) return cli_failed(FF_ERR_MEMORY, NULL);
    ff_status failed = ff_model_parse(cli_value(args, FLAG_MODEL, "ggx+lambert"), d->models.model, &err);
    if (failed == FF_OK) failed = cli_tables_give(&d->tables, d->models.model, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    d->models.n = 1;
    return cli_hold_and_free(args, d->models.model, 0);
}

static int choose_models(const cli_args *args, int many, cli_drawn_fits *d)
{
    if (!many && names_terms(args))
        return cli_usage(args, "this figure shows one model: name it by --model, not by --ndf, --masking, --fresnel or --diffuse");
    if (!many || !names_terms(args)) return one_model(args, d);
    if (cli_given(args, FLAG_MODEL))
        return cli_usage(args, "--model is one model, --ndf and the like are several: leave out one of them");
    const int status = cli_combine(args, &d->tables, "ggx", "smith-height-correlated", &d->models);
    return status == EXIT_DONE ? cli_names_known(args, d->models.model, d->models.n) : status;
}

/* As `fit` does it, and of several models as `compare` does. */
static ff_status fit_models(cli_drawn_fits *d, ff_error *err)
{
    const ff_fitting data = cli_fitting_data(&d->f);
    if (d->models.n > 1) return ff_fitting_fit_all(&data, d->models.model, d->models.n, d->fit, NULL, &d->n, err);
    const ff_status status = ff_fitting_fit(&data, 0, d->models.model, d->fit, err);
    d->n = status == FF_OK;
    return status;
}

/* Through the text, which is what a program gets too. */
static ff_status make_document(const cli_args *args, cli_drawn_fits *d, ff_error *err)
{
    ff_kept kept;
    FILE *memory = ff_kept_open(&kept);
    if (!memory) return FF_ERR_MEMORY;
    ff_report_fits report = cli_fitting_report(args, &d->f, d->fit, d->n);
    cli_trust_report(&d->trust, &report);
    ff_status status = ff_report_fits_json(&report, memory);
    const ff_status closed = ff_kept_close(&kept, memory);
    if (status == FF_OK) status = closed;
    if (status == FF_OK) status = ff_fit_document_parse(kept.text, kept.n, NULL, &d->document, err);
    free(kept.text);
    return status;
}

/* Errors and intervals as the flags want them, residuals by angle: for curves through the data nothing of it is looked at, and it
 * takes a pass over them. A kind that computes anew (its own bootstrap) needs the places of the samples, which come with them. */
static int look_closer(const cli_args *args, cli_drawn_fits *d, const ff_plot_kind *kind)
{
    int status = cli_trust_read(args, &d->f.options, &d->trust);
    d->trust.looks.cut_off = 0;
    d->trust.looks.by_angle = (kind->takes & (FF_PLOT_BY_ANGLE | FF_PLOT_FRESH)) != 0;
    if (!(kind->takes & (FF_PLOT_RESULTS | FF_PLOT_FRESH))) return status;
    if (!(kind->takes & FF_PLOT_RESULTS)) d->trust.looks.bootstrap = 0, d->trust.looks.profile = 0;
    for (size_t i = 0; i < d->n && status == EXIT_DONE && d->n == 1; i++) status = cli_trust_fit(&d->trust, &d->f, d->fit, 1);
    if (status != EXIT_DONE || d->n < 2) return status;
    if (d->trust.looks.bootstrap || d->trust.looks.profile)
        return cli_usage(
            args, "--profile and --bootstrap are of one fit: name it by --model, or draw the results of several 'fit --json'");
    ff_report_fits report = cli_fitting_report(args, &d->f, d->fit, d->n);
    size_t *rank = malloc(d->n * sizeof *rank);
    if (!rank) return cli_failed(FF_ERR_MEMORY, NULL);
    ff_report_rank(&report, 0, rank);
    status = cli_trust_compare(&d->trust, &d->f, d->fit, d->n, rank);
    free(rank);
    return status;
}

int cli_fits_draw(const cli_args *args, const char *path, const ff_plot_kind *kind, cli_drawn_fits *d)
{
    const int many = (kind->takes & FF_PLOT_COMPARES) != 0;
    ff_error err = {0};
    int status = cli_tables_read(args, &d->tables);
    if (status == EXIT_DONE) status = choose_models(args, many, d);
    if (status == EXIT_DONE) status = cli_constraints_read(args, d->models.model, d->models.n, d->models.n > 1, &d->constraints);
    if (status == EXIT_DONE) status = cli_fitting_open(args, path, d->models.model, d->models.n, 1, &d->f);
    if (status != EXIT_DONE) return status;
    d->is_open = 1;
    d->f.options.constraints = &d->constraints.c;
    if ((status = cli_polarize_channels(args, &d->f.table, d->models.model, d->models.n, &d->constraints)) != EXIT_DONE)
        return status;
    d->fit = calloc(d->models.n, sizeof *d->fit);
    ff_status failed = d->fit ? fit_models(d, &err) : FF_ERR_MEMORY;
    if (failed != FF_OK) return cli_failed(failed, &err);
    if ((status = look_closer(args, d, kind)) != EXIT_DONE) return status;
    failed = make_document(args, d, &err);
    return failed == FF_OK ? EXIT_DONE : cli_failed(failed, &err);
}

void cli_fits_free(cli_drawn_fits *d)
{
    ff_fit_document_free(d->document);
    cli_trust_free(&d->trust);
    for (size_t i = 0; i < d->n; i++) ff_fit_result_clear(&d->fit[i]);
    free(d->fit);
    if (d->is_open) cli_fitting_close(&d->f);
    cli_constraints_free(&d->constraints);
    free(d->models.model);
    cli_tables_free(&d->tables);
}
