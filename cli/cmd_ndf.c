/* facetfit ndf FILE: the distribution of normals without a formula. */
#include "ff_ndf.h"
#include "ff_profile_file.h"
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
static int open_isotropic(const cli_args *args, const ff_model *models, cli_fitting *f)
{
    cli_args with_shape = *args;
    const size_t n = args->n_given;
    with_shape.flag = malloc((n + 1) * sizeof *with_shape.flag);
    with_shape.value = malloc((n + 1) * sizeof *with_shape.value);
    int status = with_shape.flag && with_shape.value ? EXIT_DONE : cli_failed(FF_ERR_MEMORY, NULL);
    if (status == EXIT_DONE) {
        memcpy(with_shape.flag, args->flag, n * sizeof *with_shape.flag);
        memcpy(with_shape.value, args->value, n * sizeof *with_shape.value);
        with_shape.flag[n] = FLAG_SHAPE;
        with_shape.value[n] = ff_shape_name(FF_SHAPE_ISOTROPIC);
        with_shape.n_given = n + 1;
        status = cli_fitting_open(&with_shape, models, FF_NDF_MODELS, 0, f);
    }
    free(with_shape.flag);
    free(with_shape.value);
    return status;
}

/* ---- the table ------------------------------------------------------------------------------- */

static void put_comment(const ndf_report *n, char *out, size_t size)
{
    const ff_ndf_result *r = n->r;
    size_t used = (size_t)snprintf(out, size,
                                   "distribution of normals retrieved from %s\nmasking %s, loss %s, smooth %.4g; half vectors from "
                                   "%.4g to %.4g degrees\nfor `tabulated` with",
                                   n->f->path, ff_term_at(FF_MASKING, (size_t)n->options->masking)->name,
                                   ff_loss_name((int)n->f->options.loss), r->smooth, degrees(r->first), degrees(r->reach));
    for (int kd = 0; kd < 2; ++kd)
        for (size_t c = 0; c < r->n_channels && used < size; ++c) {
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
}

static int write_table(const ndf_report *n, const char *path)
{
    const size_t rows = n->r->n_rows;
    double *theta = malloc(2 * rows * sizeof *theta), *d = theta + rows;
    char comment[2048];
    ff_error err = {0};
    if (!theta) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t i = 0; i < rows; ++i) {
        theta[i] = n->r->row[i].theta;
        d[i] = n->r->row[i].d;
    }
    put_comment(n, comment, sizeof comment);
    const ff_status status = ff_profile_write(path, FF_PROFILE_D, rows, theta, d, comment, &err);
    free(theta);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

/* ---- text ------------------------------------------------------------------------------------ */

static void put_head(const ndf_report *n, FILE *out)
{
    const ff_ndf_result *r = n->r;
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER];
    ff_selection s;
    ff_problem_selection(n->f->problem[0], &s);
    fprintf(out, "%s: %s, %zu samples, %zu used\n", n->f->path, n->f->table.format, s.samples, s.used);
    fprintf(out, "loss %s, weights by %s, masking %s\n", ff_loss_name((int)n->f->options.loss), ff_weighting_name((int)s.weighting),
            ff_term_at(FF_MASKING, (size_t)n->options->masking)->name);
    if (r->from_back_scatter)
        fprintf(out, "start: power iteration over %zu samples that look back within %s degrees of the half vector, f0 %s\n",
                r->back_samples, ff_text_number(degrees(r->back_angle), 3, a), ff_text_number(r->back_f0, 3, b));
    else
        fprintf(out, "start: the best parametric fit\n");
    fprintf(out, "%zu angles, half vectors from %s to %s degrees\n", r->n_nodes, ff_text_number(degrees(r->first), 3, a),
            ff_text_number(degrees(r->reach), 3, b));
    fprintf(out, "smooth %s%s: %s effective parameters, drawn to %s; %s after %d iterations, %s s\n\n",
            ff_text_number(r->smooth, 3, a), isnan(n->options->smooth) ? " by cross-validation" : "",
            ff_text_number(r->effective, 3, b), ff_term_at(FF_NDF, (size_t)r->fit[r->reference].model.lobe[0].ndf)->name,
            ff_outcome_name((int)r->outcome), r->iterations, ff_text_number(r->time_s, 2, c));
}

static void measure_row(ff_text_table *t, const char *name, double value, const char *unit)
{
    char number[FF_TEXT_NUMBER];
    ff_text_row(t);
    ff_text_cell(t, "%s", name);
    ff_text_cell(t, "%s", ff_text_number(value, 4, number));
    ff_text_cell(t, "%s", unit);
}

static ff_status put_measures(const ff_ndf_result *r, FILE *out)
{
    const ff_ndf_measures *m = &r->measures;
    ff_text_table t = {.right = {0, 1}};
    char rms[64], number[FF_TEXT_NUMBER];
    snprintf(rms, sizeof rms, "rms slope up to %s degrees", ff_text_number(degrees(r->reach), 3, number));
    ff_text_row(&t);
    ff_text_cell(&t, "roughness");
    ff_text_cell(&t, "value");
    measure_row(&t, "half width of D", degrees(m->half_width), "degrees");
    measure_row(&t, "mean slope", m->mean_slope, "1");
    measure_row(&t, rms, m->rms_slope, "1");
    measure_row(&t, "alpha of beckmann or ggx, same peak", m->alpha_peak, "1");
    measure_row(&t, "alpha of beckmann, same mean slope", m->beckmann_mean, "1");
    measure_row(&t, "alpha of ggx, same mean slope", m->ggx_mean, "1");
    return ff_text_print(&t, out, "  ");
}

static void channel_row(ff_text_table *t, const ndf_report *n, size_t c, const char *name, double v, double error)
{
    char value[FF_TEXT_NUMBER], text[FF_TEXT_NUMBER];
    ff_text_with_error(v, error, value, text);
    ff_text_row(t);
    if (n->r->n_channels > 1)
        ff_text_cell(t, "%s[%s]", name, ff_problem_channel_name(n->f->problem[0], c));
    else
        ff_text_cell(t, "%s", name);
    ff_text_cell(t, "%s", value);
    ff_text_cell(t, "%s", text);
    ff_text_cell(t, "%s", isnan(error) ? "on its bound" : "");
}

static ff_status put_channels(const ndf_report *n, FILE *out)
{
    const ff_ndf_result *r = n->r;
    ff_text_table t = {.right = {0, 1, 1}};
    ff_text_row(&t);
    ff_text_cell(&t, "parameter");
    ff_text_cell(&t, "value");
    ff_text_cell(&t, "std error");
    for (size_t c = 0; c < r->n_channels; ++c)
        channel_row(&t, n, c, r->scaled ? "ks" : "f0", r->scaled ? r->channel[c].ks : r->channel[c].f0, r->channel[c].scale_error);
    for (size_t c = 0; c < r->n_channels; ++c) channel_row(&t, n, c, "kd", r->channel[c].kd, r->channel[c].kd_error);
    return ff_text_print(&t, out, "  ");
}

/* "0.2007 gamma=1.892" */
static void shape_cell(ff_text_table *t, const ff_fit_result *fit, int retrieved)
{
    char alpha[FF_TEXT_NUMBER], gamma[FF_TEXT_NUMBER];
    const int g = ff_model_param_find(&fit->model, "gamma");
    ff_text_number(fit->shape_value[0].value, 4, alpha);
    if (retrieved)
        ff_text_cell(t, "-");
    else if (g >= 0)
        ff_text_cell(t, "%s gamma=%s", alpha, ff_text_number(fit->shape_value[g].value, 4, gamma));
    else
        ff_text_cell(t, "%s", alpha);
}

static ff_status put_fits(const ff_ndf_result *r, FILE *out)
{
    static const char *const head[] = {"distribution", "alpha", "objective", "rmse", "cosine rmse", "log rmse"};
    static const int order[FF_NDF_FITS] = {FF_NDF_TABULATED, FF_NDF_STUDENT_T, FF_NDF_GGX, FF_NDF_BECKMANN};
    ff_text_table t = {.right = {0, 0, 1, 1, 1, 1}};
    char number[FF_TEXT_NUMBER];
    ff_text_row(&t);
    for (size_t i = 0; i < sizeof head / sizeof *head; ++i) ff_text_cell(&t, "%s", head[i]);
    for (int i = 0; i < FF_NDF_FITS; ++i) {
        const ff_fit_result *fit = &r->fit[order[i]];
        ff_text_row(&t);
        ff_text_cell(&t, "%s", i ? ff_term_at(FF_NDF, (size_t)fit->model.lobe[0].ndf)->name : "retrieved");
        shape_cell(&t, fit, i == 0);
        ff_text_cell(&t, "%s", ff_text_number(fit->residual.objective, 5, number));
        ff_text_cell(&t, "%s", ff_text_number(fit->residual.rmse, 4, number));
        ff_text_cell(&t, "%s", ff_text_number(fit->residual.cosine_rmse, 4, number));
        ff_text_cell(&t, "%s", ff_text_number(fit->residual.log_rmse, 4, number));
    }
    return ff_text_print(&t, out, "  ");
}

static ff_status write_text(const void *context, FILE *out)
{
    const ndf_report *n = context;
    put_head(n, out);
    ff_status status = put_measures(n->r, out);
    fputc('\n', out);
    if (status == FF_OK) status = put_channels(n, out);
    fputc('\n', out);
    if (status == FF_OK) status = put_fits(n->r, out);
    const ff_words_subject subject = {.problem = n->f->problem[0], .retrieved = n->r};
    if (n->r->warnings.n) fputc('\n', out);
    ff_report_warnings_text(&subject, &n->r->warnings, out);
    return status;
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
    for (size_t c = 0; c < s.n_channels; ++c) ff_json_string(j, NULL, ff_problem_channel_name(n->f->problem[0], c));
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
    for (size_t c = 0; c < r->n_channels; ++c) {
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
    for (int i = 0; i < FF_NDF_FITS; ++i) {
        char expression[FF_MODEL_NAME];
        const ff_fit_result *fit = &r->fit[i];
        ff_model_expression(&fit->model, expression, sizeof expression);
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "model", expression);
        ff_json_number(j, "alpha", fit->shape_value[0].value);
        if (i == FF_NDF_STUDENT_T) ff_json_number(j, "gamma", fit->shape_value[ff_model_param_find(&fit->model, "gamma")].value);
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
    static const char *const columns[] = {"theta_deg", "d", "relative_std_error"};
    ff_json_array(j, "columns", FF_JSON_LINE);
    for (int i = 0; i < 3; ++i) ff_json_string(j, NULL, columns[i]);
    ff_json_close(j);
    ff_json_array(j, "rows", FF_JSON_BLOCK);
    for (size_t i = 0; i < r->n_rows; ++i) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        ff_json_number(j, NULL, degrees(r->row[i].theta));
        ff_json_number(j, NULL, r->row[i].d);
        ff_json_number(j, NULL, r->row[i].error);
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
    fprintf(stderr, "\r\033[Kiteration %d, objective %.12s", iteration, ff_report_number(objective, text));
    fflush(stderr);
}

/* The table alone where it goes to standard output. */
static int report(const ndf_report *n)
{
    const char *output = cli_value(n->args, FLAG_OUTPUT, NULL), *json = cli_value(n->args, FLAG_JSON, NULL);
    int status = output ? write_table(n, output) : EXIT_DONE;
    if (status != EXIT_DONE) return status;
    if (!output || strcmp(output, "-")) return cli_write_both(n->args, write_json, write_text, n);
    return json ? cli_write(json, write_json, n) : EXIT_DONE;
}

int cmd_ndf(const cli_args *args)
{
    ff_model models[FF_NDF_MODELS];
    ff_ndf_options o;
    ff_ndf_result r;
    ff_error err = {0};
    cli_fitting f;
    ff_ndf_options_init(&o);
    read_options(args, &o);
    ff_status failed = ff_ndf_models(o.masking, models, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    int status = open_isotropic(args, models, &f);
    if (status != EXIT_DONE) return status;
    o.fit = f.options;
    if (f.progress) o.fit.progress = show;
    failed = ff_ndf_retrieve(f.problem[0], &o, &r, &err);
    if (f.progress) fputs("\r\033[K", stderr);
    if (failed == FF_OK) {
        const ndf_report n = {args, &f, &o, &r};
        status = report(&n);
        if (r.outcome != FF_CONVERGED) {
            cli_message("the retrieval did not converge: %s after %d iterations", ff_outcome_name((int)r.outcome), r.iterations);
            if (status == EXIT_DONE) status = EXIT_ANSWER_IS_NO;
        }
        ff_ndf_result_free(&r);
    } else {
        if (failed == FF_ERR_DATA && !err.path[0]) snprintf(err.path, sizeof err.path, "%s", f.path);
        status = cli_failed(failed, &err);
    }
    cli_fitting_close(&f);
    return status;
}
