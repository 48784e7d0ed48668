/* facetfit ndf FILE: the distribution of normals without a formula. */
#include "fit/ndf/ndf_struct.h"
#include "data_formats/table/profile_file_struct.h"
#include "internal_cli.h"
#include "report/internal_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Everything the report needs. */
typedef struct ndf_report {
    const cli_args *args;
    const cli_fitting *f;
    const ff_ndf_options *options;
    const ff_ndf_result *r;
} ndf_report;

static double degrees(double radians)
{
    return radians * (180 / pi);
}

/* ---- what is asked --------------------------------------------------------------------------- */

static void read_options(const cli_args *args, ff_ndf_options *o)
{
    o->masking = cli_word(args, FLAG_MASKING, o->masking);
    o->smooth = cli_number(args, FLAG_SMOOTH, o->smooth);
    o->nodes = (int)cli_integer(args, FLAG_NODES, 0);
    o->monotone = (ff_ndf_monotone)cli_word(args, FLAG_MONOTONE, (int)o->monotone);
}

/* The same command line with an isotropic shape, which is the only one that a retrieval has. */
static int open_with_shape(const cli_args *args, const ff_model *models, cli_fitting *f)
{
    cli_args with_shape = *args;
    const size_t n = args->n_given;
    with_shape.flag = malloc((n + 1) * sizeof *with_shape.flag);
    with_shape.value = malloc((n + 1) * sizeof *with_shape.value);
    int status;
    if (with_shape.flag && with_shape.value) {
        memcpy(with_shape.flag, args->flag, n * sizeof *with_shape.flag);
        memcpy(with_shape.value, args->value, n * sizeof *with_shape.value);
        with_shape.flag[n] = FLAG_SHAPE;
        with_shape.value[n] = ff_shape_name(FF_SHAPE_ISOTROPIC);
        with_shape.n_given = n + 1;
        status = cli_fitting_open(&with_shape, args->word[0], models, FF_NDF_MODELS, 0, f);
    } else {
        status = cli_failed(FF_ERR_MEMORY, NULL);
    }
    free(with_shape.flag);
    free(with_shape.value);
    return status;
}

static int open_isotropic(const cli_args *args, int masking, cli_fitting *f)
{
    ff_error err = {0};
    ff_model *models = malloc(FF_NDF_MODELS * sizeof *models);
    const ff_status failed = models ? ff_ndf_models(masking, models, &err) : FF_ERR_MEMORY;
    const int status = failed == FF_OK ? open_with_shape(args, models, f) : cli_failed(failed, &err);
    free(models);
    return status;
}

/* ---- the profile ----------------------------------------------------------------------------- */

static ff_status write_name(const void *name, FILE *out)
{
    ff_text_print(name, out);
    return FF_OK;
}

/* The name of the data speaks neither to a terminal nor to who reads the table again. */
static ff_status put_comment(const ndf_report *n, char *out, size_t size)
{
    char *name = NULL;
    const ff_ndf_result *r = n->r;
    const ff_status status = ff_text_capture(write_name, n->f->path, &name);
    if (status != FF_OK) return status;
    size_t used = (size_t)snprintf(out, size,
                                   "distribution of normals retrieved from %s\nmasking %s, loss %s, smooth %.4g; half vectors from "
                                   "%.4g to %.4g degrees\nfor `tabulated` with",
                                   name, ff_term_at(FF_MASKING, (size_t)n->options->masking)->name,
                                   ff_loss_name((int)n->f->options.loss), r->smooth, degrees(r->first), degrees(r->reach));
    for (int kd = 0; kd < 2; kd++)
        for (size_t c = 0; c < r->n_channels && used < size; c++) {
            const ff_ndf_channel *v = &r->channel[c];
            used += (size_t)snprintf(out + used, size - used, "%s%.5g",
                                     c           ? ":"
                                     : kd        ? ", kd="
                                     : r->scaled ? " f0=1, ks="
                                                 : " f0=",
                                     kd          ? v->kd
                                     : r->scaled ? v->ks
                                                 : v->f0);
        }
    free(name);
    return FF_OK;
}

static int write_profile(const ndf_report *n, const char *path)
{
    const size_t rows = n->r->n_rows;
    double *theta = malloc(3 * rows * sizeof *theta + rows);
    char comment[2048];
    ff_error err = {0};
    if (!theta) return cli_failed(FF_ERR_MEMORY, NULL);
    double *d = theta + rows, *error = d + rows;
    unsigned char *known = (unsigned char *)(error + rows);
    for (size_t i = 0; i < rows; i++) {
        theta[i] = n->r->row[i].theta;
        d[i] = n->r->row[i].d;
        error[i] = n->r->row[i].d_error;
        known[i] = (unsigned char)n->r->row[i].known;
    }
    ff_status status = put_comment(n, comment, sizeof comment);
    if (status == FF_OK)
        status = ff_profile_write_noted(path, FF_PROFILE_D, rows, theta, d, error, known, comment, n->args->outputs, &err);
    free(theta);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

/* ---- the report ------------------------------------------------------------------------------ */

static ff_report_ndf report_of(const ndf_report *n)
{
    return (ff_report_ndf){n->f->path, &n->f->table, n->f->problem[0], n->options, n->r, &n->args->style};
}

static ff_status write_text(const void *context, FILE *out)
{
    const ff_report_ndf r = report_of(context);
    return ff_report_ndf_text(&r, out);
}

static ff_status write_table(const void *context, ff_table_form form, FILE *out)
{
    const ff_report_ndf r = report_of(context);
    return ff_report_ndf_table(&r, form, out);
}

static void say_warnings(const void *context, FILE *out)
{
    const ff_report_ndf r = report_of(context);
    const ff_words_subject subject = {.problem = r.problem, .retrieved = r.result};
    ff_report_warnings_text(&subject, &r.result->warnings, out);
}

/* ---- JSON ------------------------------------------------------------------------------------ */

static void json_data(ff_json *j, const ndf_report *n)
{
    ff_selection s;
    ff_problem_selection(n->f->problem[0], &s);
    ff_json_object(j, "data", FF_JSON_BLOCK);
    ff_json_string(j, "path", n->f->path);
    ff_json_string(j, "format", n->f->table.format);
    ff_json_integer(j, "samples", (int64_t)s.samples);
    ff_json_integer(j, "used", (int64_t)s.used);
    ff_json_array(j, "channels", FF_JSON_LINE);
    for (size_t c = 0; c < s.n_channels; c++) ff_json_string(j, NULL, ff_problem_channel_name(n->f->problem[0], c));
    ff_json_close(j);
    ff_json_string(j, "weighting", ff_weighting_name((int)s.weighting));
    ff_json_number(j, "first_deg", degrees(n->r->first));
    ff_json_number(j, "reach_deg", degrees(n->r->reach));
    ff_json_close(j);
}

static void json_start(ff_json *j, const ff_ndf_result *r)
{
    ff_json_object(j, "start", FF_JSON_LINE);
    ff_json_string(j, "kind", r->from_back_scatter ? "back-scatter" : "parametric");
    ff_json_integer(j, "samples", (int64_t)r->back_samples);
    if (r->from_back_scatter) {
        ff_json_number(j, "angle_deg", degrees(r->back_angle));
        ff_json_number(j, "f0", r->back_f0);
        ff_json_integer(j, "iterations", r->back_iterations);
    } else {
        ff_json_null(j, "angle_deg");
        ff_json_null(j, "f0");
        ff_json_null(j, "iterations");
    }
    ff_json_close(j);
}

static void json_measures(ff_json *j, const ff_ndf_measures *m)
{
    ff_json_object(j, "roughness", FF_JSON_BLOCK);
    ff_json_number(j, "half_width_deg", degrees(m->half_width));
    ff_json_number(j, "mean_slope", m->mean_slope);
    ff_json_number(j, "rms_slope", m->rms_slope);
    ff_json_number(j, "area_beyond_reach", m->beyond);
    ff_json_number(j, "alpha_same_peak", m->alpha_peak);
    ff_json_number(j, "beckmann_alpha_same_mean_slope", m->beckmann_mean);
    ff_json_number(j, "ggx_alpha_same_mean_slope", m->ggx_mean);
    ff_json_close(j);
}

/* key: [v of each channel] by its offset in ff_ndf_channel */
static void json_channels(ff_json *j, const ff_ndf_result *r, const char *key, size_t offset)
{
    ff_json_array(j, key, FF_JSON_LINE);
    for (size_t c = 0; c < r->n_channels; c++) {
        double v;
        memcpy(&v, (const char *)&r->channel[c] + offset, sizeof v);
        ff_json_number(j, NULL, v);
    }
    ff_json_close(j);
}

static void json_parameters(ff_json *j, const ff_ndf_result *r)
{
    ff_json_object(j, "parameters", FF_JSON_BLOCK);
    json_channels(j, r, "f0", offsetof(ff_ndf_channel, f0));
    json_channels(j, r, "ks", offsetof(ff_ndf_channel, ks));
    json_channels(j, r, r->scaled ? "ks_std_error" : "f0_std_error", offsetof(ff_ndf_channel, scale_error));
    json_channels(j, r, "kd", offsetof(ff_ndf_channel, kd));
    json_channels(j, r, "kd_std_error", offsetof(ff_ndf_channel, kd_error));
    ff_json_close(j);
}

static void json_fits(ff_json *j, const ff_ndf_result *r)
{
    ff_json_array(j, "fits", FF_JSON_BLOCK);
    for (int i = 0; i < FF_NDF_FITS; i++) {
        char expression[FF_MODEL_NAME];
        const ff_fit_result *fit = &r->fit[i];
        ff_model_expression(&fit->model, expression, sizeof expression);
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "model", expression);
        ff_json_number(j, "alpha", fit->shape_value[0].value);
        if (i == FF_NDF_STUDENT_T) ff_json_number(j, "gamma", ff_fit_result_find(fit, "gamma", 0)->value);
        ff_json_number(j, "objective", fit->residual.objective);
        ff_json_number(j, "rmse", fit->residual.rmse);
        ff_report_rmses_json(j, &fit->residual);
        ff_json_number(j, "max_abs", fit->residual.max_abs);
        ff_json_close(j);
    }
    ff_json_close(j);
}

static void json_rows(ff_json *j, const ff_ndf_result *r)
{
    static const char *const columns[] = {"theta_deg", "d", "relative_std_error", "d_relative_std_error", "known"};
    ff_json_array(j, "columns", FF_JSON_LINE);
    for (size_t i = 0; i < sizeof columns / sizeof *columns; i++) ff_json_string(j, NULL, columns[i]);
    ff_json_close(j);
    ff_json_array(j, "rows", FF_JSON_BLOCK);
    for (size_t i = 0; i < r->n_rows; i++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        ff_json_number(j, NULL, degrees(r->row[i].theta));
        ff_json_number(j, NULL, r->row[i].d);
        ff_json_number(j, NULL, r->row[i].error);
        ff_json_number(j, NULL, r->row[i].d_error);
        ff_json_integer(j, NULL, r->row[i].known);
        ff_json_close(j);
    }
    ff_json_close(j);
}

static ff_status write_json(const void *context, FILE *out)
{
    const ndf_report *n = context;
    const ff_ndf_result *r = n->r;
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, n->args->command->schema, &n->args->head);
    json_data(&j, n);
    ff_json_string(&j, "loss", ff_loss_name((int)n->f->options.loss));
    ff_json_string(&j, "masking", ff_term_at(FF_MASKING, (size_t)n->options->masking)->name);
    ff_json_string(&j, "monotone", ff_ndf_monotone_name((int)n->options->monotone));
    json_start(&j, r);
    ff_json_string(&j, "outcome", ff_outcome_name((int)r->outcome));
    ff_json_integer(&j, "iterations", r->iterations);
    ff_json_integer(&j, "passes", r->passes);
    ff_json_number(&j, "time_s", r->time_s);
    ff_json_integer(&j, "nodes", (int64_t)r->n_nodes);
    ff_json_number(&j, "smooth", r->smooth);
    ff_json_bool(&j, "smooth_chosen", isnan(n->options->smooth));
    ff_json_number(&j, "effective_parameters", r->effective);
    ff_json_number(&j, "sure_deg", degrees(r->sure));
    ff_json_number(&j, "known_error", FF_NDF_KNOWN);
    json_measures(&j, &r->measures);
    json_parameters(&j, r);
    ff_json_number(&j, "objective", r->objective);
    json_fits(&j, r);
    json_rows(&j, r);
    const ff_words_subject subject = {.problem = n->f->problem[0], .retrieved = r};
    ff_report_warnings_json(&j, &subject, &r->warnings);
    ff_json_close(&j);
    ff_json_end(&j);
    return FF_OK;
}

/* ---- the command ----------------------------------------------------------------------------- */

static void show(void *context, int iteration, double objective)
{
    char text[FF_REPORT_NUMBER];
    (void)context;
    cli_progress_show("iteration %d, objective %.12s", iteration, ff_report_number(objective, text));
}

/* The table alone where it goes to standard output. */
static int report(const ndf_report *n)
{
    const char *output = cli_value(n->args, FLAG_OUTPUT, NULL), *json = cli_value(n->args, FLAG_JSON, NULL);
    int status = output ? write_profile(n, output) : EXIT_DONE;
    if (status != EXIT_DONE) return status;
    if (!output || strcmp(output, "-"))
        return cli_report(n->args, &(cli_form){write_json, write_text, write_table, say_warnings}, n);
    if (json) status = cli_write(n->args, json, write_json, n);
    return status == EXIT_DONE ? cli_outputs_commit(n->args) : status;
}

int cmd_ndf(const cli_args *args)
{
    ff_ndf_options o;
    ff_ndf_result r;
    ff_error err = {0};
    cli_fitting f = {0};
    ff_ndf_options_init(&o);
    read_options(args, &o);
    if (!strcmp(cli_value(args, FLAG_WEIGHT, ""), "noise"))
        return cli_usage(
            args, "--weight noise is of the noise about a model, which is not known here: expected solid-angle, sigma or sample");
    int status = open_isotropic(args, o.masking, &f);
    if (status != EXIT_DONE) return status;
    ff_fit_options fit = f.options;
    if (f.progress) fit.progress = show;
    o.fit = &fit;
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): where the status is EXIT_DONE there is a problem
    const ff_status failed = ff_ndf_retrieve_into(f.problem[0], &o, &r, &err);
    if (f.progress) cli_progress_end();
    if (failed == FF_OK) {
        const ndf_report n = {args, &f, &o, &r};
        status = report(&n);
        if (r.outcome != FF_CONVERGED) {
            cli_error("the retrieval did not converge: %s after %d iterations", ff_outcome_name((int)r.outcome), r.iterations);
            if (status == EXIT_DONE) status = EXIT_ANSWER_IS_NO;
        }
        ff_ndf_result_clear(&r);
    } else {
        if (failed == FF_ERR_DATA && !err.path[0]) snprintf(err.path, sizeof err.path, "%s", f.path);
        status = cli_failed(failed, &err);
    }
    cli_fitting_close(&f);
    return status;
}
