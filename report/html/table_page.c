/* The page of a table: what `info` says, coverage, and how it looks. */
#include "internal_page.h"
#include "report/plot/kinds/internal_curves.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct table_data {
    const ff_report_head *head;
    const char *path, *sha256;
    const ff_table *t;
} table_data;

static ff_status write_json(const void *context, FILE *out)
{
    const table_data *d = context;
    return ff_report_table_json(d->head, d->path, d->t, out);
}

static ff_status write_text(const void *context, FILE *out)
{
    const table_data *d = context;
    return ff_report_table_text(d->path, d->t, NULL, out);
}

static ff_status write_source(const void *context, FILE *out)
{
    const table_data *d = context;
    ff_page_put_command(d->head, d->sha256, out);
    return FF_OK;
}

static void put_kind(ff_page *p, const ff_plot_kind *kind, const table_data *d, const char *caption)
{
    const ff_plot_subject of = {.path = d->path, .table = d->t, .max_theta = 90 * FF_DEGREE};
    const ff_plot_choice any = {.log = -1, .isa = FF_ISA_BEST};
    ff_figure fig;
    ff_error reason = {0};
    ff_figure_init(&fig);
    if (p->status) return;
    const ff_status status = kind->build(&of, &any, &fig, &reason);
    ff_page_figure(p, kind->name, caption, &fig, status, &reason, 1);
}

static void put_notes(ff_page *p, const ff_table *t)
{
    char text[FF_WORDS_SENTENCE];
    ff_page_section(p, "verdict", "Notes");
    ff_page_format(p, "<ul class=\"alerts\">\n");
    for (size_t k = 0; ff_words_note(t, k, text); k++) {
        ff_page_format(p, "<li class=\"note\">");
        ff_page_text(p, text);
        ff_page_format(p, "</li>\n");
    }
    ff_page_format(p, "<li class=\"plain\">%zu samples, %zu channels, %zu invalid, %zu negative</li>\n</ul>\n", t->n, t->n_channels,
                   t->n_invalid, t->n_negative);
    ff_page_section_end(p);
}

static void put_page(ff_page *p, const table_data *d)
{
    char title[600], subtitle[128];
    const char *slash = strrchr(d->path, '/');
    snprintf(title, sizeof title, "%s", slash && slash[1] ? slash + 1 : d->path);
    snprintf(subtitle, sizeof subtitle, "facetfit %s, format %.32s", d->head->version, d->t->format);
    ff_page_begin(p, FF_PAGE_TABLE, title, subtitle);
    put_notes(p, d->t);
    ff_page_section(p, "data", "Data");
    ff_page_block(p, "What is in the file", write_text, d);
    ff_page_section_end(p);
    ff_page_section(p, "directions", "Coverage");
    put_kind(p, &ff_plot_coverage, d, "Directions of light and view that were measured");
    ff_page_section_end(p);
    ff_page_section(p, "slices", "Plane of incidence");
    put_kind(p, &ff_plot_slice, d, "f against the angle of the view");
    ff_page_section_end(p);
    ff_page_section(p, "images", "Image slice");
    put_kind(p, &ff_plot_image, d, "Half angle against difference angle");
    ff_page_section_end(p);
    ff_page_section(p, "reproduce", "Reproduce");
    ff_page_block(p, "Command", write_source, d);
    ff_page_section_end(p);
    ff_page_json(p, "table", write_json, d);
    ff_page_end(p, FF_PAGE_TABLE);
}

ff_status ff_html_table_write(const ff_report_head *head, const char *path, const ff_table *t, const char *sha256, FILE *out,
                              ff_error *err)
{
    ff_page p = {.out = out, .err = err};
    put_page(&p, &(table_data){head, path, sha256, t});
    if (p.status) ff_error_set(err, p.status, NULL, 0, -1, "the page: %s", ff_status_str(p.status));
    return p.status;
}
