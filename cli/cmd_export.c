/* facetfit export FIT.json --to NAME -o FILE: a fit as a file that a renderer loads, as code, or as a table. */
#include "internal_cli.h"
#include "base/internal_kept.h"
#include "fit/controls/internal_refit.h"
#include "report/ff_fit_document.h"
#include "simulate/simulate_struct.h"
#include "targets/files/internal_files.h"
#include "targets/snippets/internal_snippet.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is exported. */
typedef struct job {
    const cli_args *args;
    const char *path;
    ff_fit_document *d;
    const ff_fitted *fit;
    ff_model model; /* with its table */
    cli_tables tables;
    ff_surface surface;
    ff_report_export report;
} job;

/* ---- a file of a renderer -------------------------------------------------------------------- */

typedef struct scene_job {
    const ff_scene *scene;
    const ff_scene_file *file;
} scene_job;

static ff_status write_scene(const void *context, FILE *out)
{
    const scene_job *s = context;
    return s->file->write(s->scene, out);
}

static ff_status write_json(const void *report, FILE *out)
{
    return ff_report_export_json(report, out);
}

static ff_status write_text(const void *report, FILE *out)
{
    return ff_report_export_text(report, out);
}

/* Where the file goes to stdout, what was lost goes to stderr. */
static int report(const job *j)
{
    const char *json = cli_value(j->args, FLAG_JSON, NULL);
    if (strcmp(j->path, "-")) return cli_write_both(j->args, write_json, write_text, &j->report);
    for (size_t i = 0; i < j->report.n_lost; i++)
        cli_warning("%s: lost: %s, %.2g %%", j->report.from, j->report.lost[i].what, 100 * j->report.lost[i].share);
    const int status = json ? cli_write(j->args, json, write_json, &j->report) : EXIT_DONE;
    return status == EXIT_DONE ? cli_outputs_commit(j->args) : status;
}

static int export_refit(job *j, const ff_target *t, const ff_scene_file *file, ff_refit *r)
{
    double control[FF_TARGET_CONTROLS * 3];
    const ff_status failed = ff_refit_controls(r, control);
    if (failed != FF_OK) return cli_failed(failed, NULL);
    const ff_scene scene = {t, r->material, r->n_channels, control, j->args->head.version};
    j->report.as = file->name;
    j->report.title = file->title;
    ff_report_export_take(t, r, control, &j->report);
    int status = cli_write(j->args, j->path, write_scene, &(scene_job){&scene, file});
    if (status == EXIT_DONE) status = report(j);
    j->report.control = NULL; /* they end here */
    j->report.n_lost = 0, j->report.lost = NULL;
    return status;
}

static int no_file(const job *j, const ff_target *t)
{
    char known[300] = "";
    for (size_t i = 0; i < ff_scene_file_count(); i++) {
        const ff_scene_file *f = ff_scene_file_at(i);
        for (size_t k = 0; f->targets[k]; k++)
            if (!strcmp(f->targets[k], t->name)) snprintf(known + strlen(known), sizeof known - strlen(known), " %s", f->extension);
    }
    if (!*known)
        return cli_usage(j->args, "%s has no file of its own: 'facetfit fit --for %s' prints what to set there", t->title, t->name);
    return cli_usage(j->args, "%s: expected a name that ends in%s", j->path, known);
}

/* name: "blender" or "blender:metal" */
static int export_to_renderer(job *j, const ff_target *t, const char *name)
{
    ff_error err = {0};
    ff_refit r;
    const char *colon = strchr(name, ':');
    const ff_material *m = colon ? ff_material_find(t, colon + 1, strlen(colon + 1)) : NULL;
    const ff_scene_file *file = ff_scene_file_find(t, j->path, !strcmp(j->path, "-"));
    if (colon && !m) return cli_usage(j->args, "--to %s: %s has no such material", name, t->name);
    if (!file) return no_file(j, t);
    if (j->surface.n_channels != 1 && j->surface.n_channels != 3)
        return cli_usage(j->args, "a renderer has three channels, and %s has %zu: fit with --reduce srgb, or --channels mean",
                         j->report.from, j->surface.n_channels);
    const int loss = ff_loss_find(j->d->loss);
    const ff_status failed = ff_refit_make(t, m, &j->surface, loss < 0 ? FF_LOSS_COSINE : (ff_loss)loss,
                                           (int)cli_integer(j->args, FLAG_THREADS, 0), &r, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    const int status = export_refit(j, t, file, &r);
    ff_refit_clear(&r);
    return status;
}

/* ---- code and tables ------------------------------------------------------------------------- */

typedef struct code_job {
    const job *j;
    int language;
    ff_error *err;
} code_job;

static ff_status write_code(const void *context, FILE *out)
{
    const code_job *c = context;
    const ff_surface *s = &c->j->surface;
    return ff_snippet_write(c->language, s->model, s->n_channels, s->shape, s->channel, c->j->args->head.version, out, c->err);
}

/* Written to nowhere first: what has no code leaves no file. */
static int export_code(job *j, int language)
{
    ff_error err = {0};
    const code_job c = {j, language, &err};
    ff_kept text;
    FILE *nowhere = ff_kept_open(&text);
    ff_status failed = nowhere ? write_code(&c, nowhere) : FF_ERR_MEMORY;
    const ff_status closed = ff_kept_close(&text, nowhere);
    if (failed == FF_OK) failed = closed;
    free(text.text);
    if (failed != FF_OK) return cli_failed(failed, &err);
    j->report.as = ff_snippet_name((size_t)language);
    j->report.title = "the model as code";
    const int status = cli_write(j->args, j->path, write_code, &c);
    return status == EXIT_DONE ? report(j) : status;
}

/* Some formats have one channel. */
static int no_table(const job *j, ff_status failed, ff_error *err)
{
    const size_t used = strlen(err->message);
    if (failed == FF_ERR_UNSUPPORTED && j->surface.n_channels > 1)
        snprintf(err->message + used, sizeof err->message - used, "; --channel %s takes one", j->fit->channel_name[0]);
    return cli_failed(failed, err);
}

static int export_table(job *j, const ff_format *to)
{
    ff_error err = {0};
    ff_table t;
    ff_simulate_options o;
    ff_lost rounding = {"", NAN};
    ff_simulate_options_init(&o);
    const int chosen = cli_isa(j->args, &o.isa);
    if (chosen != EXIT_DONE) return chosen;
    const ff_surface *s = &j->surface;
    ff_status failed = ff_simulate_layout_into(s->model, s->n_channels, s->shape, s->channel, to, NULL, &o, &t, &err);
    if (failed != FF_OK) return no_table(j, failed, &err);
    failed = ff_table_write_with(j->path, to->name, &t, j->args->outputs, &err);
    if (failed == FF_OK) cli_notes(j->path, &t);
    snprintf(rounding.what, sizeof rounding.what,
             "between its %zu samples the file says nothing, and whoever reads it interpolates", t.n);
    ff_table_clear(&t);
    if (failed != FF_OK) return no_table(j, failed, &err);
    j->report.as = to->name;
    j->report.title = to->title;
    j->report.n_lost = 1;
    j->report.lost = &rounding;
    const int status = report(j);
    j->report.n_lost = 0, j->report.lost = NULL;
    return status;
}

/* ---- the command ----------------------------------------------------------------------------- */

/* --channel: that one alone. */
static int take_channel(job *j)
{
    const char *name = cli_value(j->args, FLAG_CHANNEL, NULL);
    char known[300] = "";
    if (!name) return EXIT_DONE;
    for (size_t c = 0; c < j->fit->n_channels; c++) {
        if (!strcmp(j->fit->channel_name[c], name)) {
            j->surface.channel += c * j->model.n_channel;
            j->surface.n_channels = 1;
            return EXIT_DONE;
        }
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", j->fit->channel_name[c]);
    }
    return cli_usage(j->args, "--channel %s: the fit has no such channel; it has %s", name, known);
}

static int run(job *j)
{
    const char *to = cli_value(j->args, FLAG_TO, NULL);
    char name[CLI_NAME], known[900];
    if (!to) return cli_usage(j->args, "--to NAME is missing: a renderer, c, glsl, hlsl, osl, or a format");
    snprintf(name, sizeof name, "%.*s", (int)strcspn(to, ":"), to);
    const ff_target *t = ff_target_find(name);
    const int language = ff_snippet_find(to);
    const ff_format *format = ff_format_find(to);
    if (t) return export_to_renderer(j, t, to);
    if (language >= 0) return export_code(j, language);
    if (format && format->write) return export_table(j, format);
    const char *nearest = cli_words_nearest(cli_words_export, to, strlen(to));
    return cli_usage(j->args, "--to %s: neither a renderer nor a language nor a format that can be written%s%s%s; known are %s", to,
                     nearest ? "; did you mean '" : "", nearest ? nearest : "", nearest ? "'?" : "",
                     cli_words_list(cli_words_export, known, sizeof known));
}

int cmd_export(const cli_args *args)
{
    ff_error err = {0};
    char expression[FF_MODEL_NAME];
    job j = {.args = args, .path = cli_value(args, FLAG_OUTPUT, NULL), .report = {.head = args->head, .from = args->word[0]}};
    if (!j.path) return cli_usage(args, "-o FILE is missing: where to write");
    int status = cli_tables_read(args, &j.tables);
    if (status != EXIT_DONE) return status;
    ff_status failed = ff_fit_document_read(args->word[0], &j.d, &err);
    if (failed == FF_OK) {
        j.fit = &j.d->fit[j.d->best];
        j.model = j.fit->model;
        failed = cli_tables_give(&j.tables, &j.model, &err);
        j.surface = (ff_surface){&j.model, j.fit->n_channels, j.fit->shape, j.fit->channel};
        ff_model_expression(&j.model, expression, sizeof expression);
        j.report.expression = expression;
        j.report.path = j.path;
        status = failed == FF_OK ? take_channel(&j) : cli_failed(failed, &err);
        if (status == EXIT_DONE) status = run(&j);
        ff_fit_document_free(j.d);
    } else
        status = cli_failed(failed, &err);
    cli_tables_free(&j.tables);
    return status;
}
