/* Fits for somebody else: files of renderers, code, tables. */
#define _GNU_SOURCE
#include "internal_study_report.h"
#include "base/internal_output.h"
#include "ff_version.h"
#include "fit/controls/internal_refit.h"
#include "simulate/simulate_struct.h"
#include "targets/files/internal_files.h"
#include "targets/snippets/internal_snippet.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What is exported, and where to. */
typedef struct job {
    const ff_study *s;
    const char *path;
    ff_content *file;
    ff_surface surface;
    ff_report_export report;
    ff_error *err;
} job;

const char *ff_export_name(size_t i)
{
    if (i < ff_target_count()) return ff_target_at(i)->name;
    i -= ff_target_count();
    if (i < ff_snippet_count()) return ff_snippet_name(i);
    i -= ff_snippet_count();
    for (size_t k = 0; k < ff_format_count(); k++)
        if (ff_format_can_write(ff_format_at(k)) && i-- == 0) return ff_format_name(ff_format_at(k));
    return NULL;
}

/* To the file, or where there is no path to *file. */
static ff_status put(const job *j, ff_status (*write)(const void *context, FILE *out), const void *context)
{
    ff_output out;
    if (!j->path) return ff_content_keep(write, context, j->file);
    ff_status status = ff_output_open(j->path, &out, j->err);
    if (status != FF_OK) return status;
    status = write(context, out.file);
    if (status == FF_OK) return ff_output_commit(&out, j->err);
    ff_output_abort(&out);
    return status;
}

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

static ff_status no_file(const job *j, const ff_target *t)
{
    char known[300] = "";
    for (size_t i = 0; i < ff_scene_file_count(); i++) {
        const ff_scene_file *f = ff_scene_file_at(i);
        for (size_t k = 0; f->targets[k]; k++) {
            const size_t used = strlen(known);
            if (!strcmp(f->targets[k], t->name)) snprintf(known + used, sizeof known - used, " %s", f->extension);
        }
    }
    if (!*known) return ff_error_set(j->err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s has no file of its own", t->title);
    return ff_error_set(j->err, FF_ERR_UNSUPPORTED, j->path, 0, -1, "expected a name that ends in%s", known);
}

static void report_refit(job *j, const ff_target *t, const ff_scene_file *file, const ff_refit *r, const double *control)
{
    j->report.as = file->name;
    j->report.title = file->title;
    ff_report_export_take(t, r, control, &j->report);
}

static ff_status write_about(const void *report, FILE *out)
{
    return ff_report_export_json(report, out);
}

static ff_status export_to_renderer(job *j, const ff_target *t, const char *name, ff_content *about)
{
    double control[FF_TARGET_CONTROLS * 3];
    ff_refit r;
    const char *colon = strchr(name, ':');
    const ff_material *m = colon ? ff_material_find(t, colon + 1, strlen(colon + 1)) : NULL;
    const ff_scene_file *file = ff_scene_file_find(t, j->path ? j->path : "", !j->path);
    if (colon && !m) return ff_error_set(j->err, FF_ERR_UNKNOWN, NULL, 0, -1, "%s has no material '%.40s'", t->name, colon + 1);
    if (!file) return no_file(j, t);
    if (j->surface.n_channels != 1 && j->surface.n_channels != 3)
        return ff_error_set(j->err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a renderer has three channels, and the fit has %zu",
                            j->surface.n_channels);
    ff_status status = ff_refit_make(t, m, &j->surface, j->s->options.loss, j->s->options.threads, &r, j->err);
    if (status != FF_OK) return status;
    status = ff_refit_controls(&r, control);
    const ff_scene scene = {t, r.material, r.n_channels, control, ff_version()};
    if (status == FF_OK) status = put(j, write_scene, &(scene_job){&scene, file});
    if (status == FF_OK && about) {
        report_refit(j, t, file, &r, control);
        status = ff_content_keep(write_about, &j->report, about);
    }
    ff_refit_clear(&r);
    return status;
}

/* ---- code and tables ------------------------------------------------------------------------- */

typedef struct code_job {
    const job *j;
    int language;
} code_job;

static ff_status write_code(const void *context, FILE *out)
{
    const code_job *c = context;
    const ff_surface *s = &c->j->surface;
    return ff_snippet_write(c->language, s->model, s->n_channels, s->shape, s->channel, ff_version(), out, c->j->err);
}

static ff_status export_code(job *j, int language, ff_content *about)
{
    ff_status status = put(j, write_code, &(code_job){j, language});
    j->report.as = ff_snippet_name((size_t)language);
    j->report.title = "the model as code";
    if (status == FF_OK && about) status = ff_content_keep(write_about, &j->report, about);
    return status;
}

static ff_status export_table(job *j, const ff_format *to, ff_content *about)
{
    ff_table t;
    ff_simulate_options o;
    ff_lost rounding = {"", NAN};
    const ff_surface *s = &j->surface;
    if (!j->path)
        return ff_error_set(j->err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "'%s' is a format of files: a path is missing", to->name);
    ff_simulate_options_init(&o);
    o.isa = j->s->options.isa;
    ff_status status = ff_simulate_layout_into(s->model, s->n_channels, s->shape, s->channel, to, NULL, &o, &t, j->err);
    if (status != FF_OK) return status;
    status = ff_table_write(j->path, to->name, &t, j->err);
    snprintf(rounding.what, sizeof rounding.what,
             "between its %zu samples the file says nothing, and whoever reads it interpolates", t.n);
    ff_table_clear(&t);
    j->report.as = to->name;
    j->report.title = to->title;
    j->report.n_lost = 1;
    j->report.lost = &rounding;
    if (status == FF_OK && about) status = ff_content_keep(write_about, &j->report, about);
    return status;
}

/* ---- all ------------------------------------------------------------------------------------- */

static ff_status unknown(const char *to, ff_error *err)
{
    char known[FF_ERROR_MESSAGE - 80] = "";
    const char *name;
    for (size_t i = 0; (name = ff_export_name(i)) != NULL; i++) {
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", name);
    }
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1,
                        "'%.40s' is no renderer, language or format that is written; known are %s", to, known);
}

static ff_status run(job *j, const char *to, ff_content *about)
{
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)strcspn(to, ":"), to);
    const ff_target *t = ff_target_find(name);
    const int language = ff_snippet_find(to);
    const ff_format *format = ff_format_find(to);
    if (t) return export_to_renderer(j, t, to, about);
    if (language >= 0) return export_code(j, language, about);
    if (format && format->write) return export_table(j, format, about);
    return unknown(to, j->err);
}

ff_status ff_study_export(const ff_study *s, size_t i, const char *to, const char *path, ff_content *file, ff_content *about,
                          ff_error *err)
{
    char expression[FF_MODEL_NAME];
    double shape[FF_MAX_SHAPE], *channel = NULL;
    ff_content written = {NULL, 0}, said = {NULL, 0};
    ff_status status = ff_study_check_fit(s, i, err);
    if (status != FF_OK) return status;
    if (!path == !file) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "expected a path, or room for what would be written");
    const ff_fit_result *fit = &s->fit[i];
    channel = malloc((fit->n_channels * fit->model.n_channel + 1) * sizeof *channel);
    if (!channel) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    ff_fit_result_values(fit, shape, channel);
    ff_model_expression(&fit->model, expression, sizeof expression);
    const ff_report_fits r = ff_study_report(s);
    job j = {.s = s,
             .path = path,
             .file = file ? &written : NULL,
             .surface = {&fit->model, fit->n_channels, shape, channel},
             .report = {.head = r.head, .from = s->path, .expression = expression, .path = path ? path : "-"},
             .err = err};
    status = run(&j, to, about ? &said : NULL);
    free(channel);
    if (status != FF_OK) {
        ff_content_clear(&written);
        ff_content_clear(&said);
        if (status == FF_ERR_MEMORY) ff_error_set(err, status, NULL, 0, -1, "out of memory");
        return status;
    }
    if (file) *file = written;
    if (about) *about = said;
    return FF_OK;
}
