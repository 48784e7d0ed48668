/* Studies and tables in the forms that the program has. */
#include "internal_study_report.h"
#include "base/internal_kept.h"
#include "ff_version.h"
#include "report/html/ff_html.h"
#include <stdlib.h>
#include <string.h>

void ff_content_clear(ff_content *c)
{
    if (!c) return;
    free(c->text);
    *c = (ff_content){NULL, 0};
}

ff_status ff_content_keep(ff_status (*write)(const void *context, FILE *out), const void *context, ff_content *out)
{
    ff_kept kept;
    FILE *stream = ff_kept_open(&kept);
    ff_status status = stream ? write(context, stream) : FF_ERR_MEMORY;
    const ff_status closed = ff_kept_close(&kept, stream);
    if (status == FF_OK) status = closed;
    if (status == FF_OK)
        *out = (ff_content){kept.text, kept.n};
    else
        free(kept.text);
    return status;
}

ff_status ff_study_check_fit(const ff_study *s, size_t i, ff_error *err)
{
    if (i < s->n_fits) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "fit %zu: there are %zu", i, s->n_fits);
}

ff_report_fits ff_study_report(const ff_study *s)
{
    return (ff_report_fits){.head = {ff_version(), s->command ? 1 : 0, s->words},
                            .path = s->path,
                            .table = s->table,
                            .options = &s->options,
                            .n_problems = s->n_problems,
                            .problem = (const ff_problem *const *)s->problem,
                            .n_fits = s->n_fits,
                            .fit = s->fit,
                            .trust = s->looks.each,
                            .folds = s->looks.folds,
                            .places = s->looks.places,
                            .difference = s->looks.has_difference ? &s->looks.difference : NULL,
                            .adaptive = s->adaptive};
}

/* ---- forms ----------------------------------------------------------------------------------- */

/* What is written, of one of the two. */
typedef struct writing {
    const ff_study *s;
    const ff_report_fits *r;
    ff_table_form table;
    const ff_table *t;
    const char *path;
    ff_error *err;
} writing;

static ff_status write_text(const void *context, FILE *out)
{
    const writing *w = context;
    return w->s->compares ? ff_report_compare_text(w->r, out) : ff_report_fit_text(w->r, out);
}

static ff_status write_json(const void *context, FILE *out)
{
    return ff_report_fits_json(((const writing *)context)->r, out);
}

static ff_status write_page(const void *context, FILE *out)
{
    const writing *w = context;
    return ff_html_fits_write(w->r, NULL, w->s->options.isa, out, w->err);
}

static ff_status write_summary(const void *context, FILE *out)
{
    const writing *w = context;
    return ff_html_summary_write(w->r, w->s->options.isa, out, w->err);
}

static ff_status write_table(const void *context, FILE *out)
{
    const writing *w = context;
    return w->s->compares ? ff_report_compare_table(w->r, w->table, out) : ff_report_fit_table(w->r, w->table, out);
}

static ff_status unknown(const char *form, const char *known, ff_error *err)
{
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "no form '%.40s'; known are %s", form, known);
}

static ff_status keep(ff_status (*write)(const void *context, FILE *out), const writing *w, ff_content *out)
{
    const ff_status status = ff_content_keep(write, w, out);
    if (status == FF_ERR_MEMORY) ff_error_set(w->err, status, NULL, 0, -1, "out of memory");
    return status;
}

ff_status ff_study_write(const ff_study *s, const char *form, ff_content *out, ff_error *err)
{
    static const struct {
        const char *name;
        ff_status (*write)(const void *context, FILE *out);
    } forms[] = {{"text", write_text}, {"json", write_json}, {"html", write_page}, {"summary", write_summary}};
    const ff_report_fits r = ff_study_report(s);
    writing w = {.s = s, .r = &r, .err = err};
    for (size_t k = 0; k < sizeof forms / sizeof *forms; k++)
        if (!strcmp(form, forms[k].name)) return keep(forms[k].write, &w, out);
    for (int k = FF_TABLE_CSV; ff_table_form_name(k); k++)
        if (!strcmp(form, ff_table_form_name(k))) {
            w.table = (ff_table_form)k;
            return keep(write_table, &w, out);
        }
    return unknown(form, "text, json, html, summary, csv, tsv, md, latex", err);
}

/* ---- tables ---------------------------------------------------------------------------------- */

static ff_status describe_text(const void *context, FILE *out)
{
    const writing *w = context;
    return ff_report_table_text(w->path, w->t, NULL, out);
}

static ff_status describe_json(const void *context, FILE *out)
{
    const writing *w = context;
    const ff_report_head head = {ff_version(), 0, NULL};
    return ff_report_table_json(&head, w->path, w->t, out);
}

static ff_status describe_page(const void *context, FILE *out)
{
    const writing *w = context;
    const ff_report_head head = {ff_version(), 0, NULL};
    return ff_html_table_write(&head, w->path, w->t, NULL, out, w->err);
}

ff_status ff_table_describe(const ff_table *t, const char *path, const char *form, ff_content *out, ff_error *err)
{
    const writing w = {.t = t, .path = path ? path : "data", .err = err};
    if (!strcmp(form, "text")) return keep(describe_text, &w, out);
    if (!strcmp(form, "json")) return keep(describe_json, &w, out);
    if (!strcmp(form, "html")) return keep(describe_page, &w, out);
    return unknown(form, "text, json, html", err);
}
