/* The subject of a page of fits: its models, its channels, which fits are looked at. */
#include "internal_html.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static ff_status write_document(const void *r, FILE *out)
{
    return ff_report_fits_json(r, out);
}

static ff_status read_document(const ff_report_fits *r, ff_fit_document **out, ff_error *err)
{
    char *text = NULL;
    ff_status status = ff_text_capture(write_document, r, &text);
    if (!status) status = ff_fit_document_parse(text, strlen(text), NULL, out, err);
    free(text);
    return status;
}

static ff_status make_models(ff_html_subject *s)
{
    s->model = calloc(s->document->n_fits + 1, sizeof *s->model);
    if (!s->model) return FF_ERR_MEMORY;
    for (size_t k = 0; k < s->document->n_fits; k++) {
        ff_fitted *f = &s->document->fit[k];
        for (uint32_t l = 0; l < f->model.n_lobes; l++) f->model.lobe[l].table = s->r->fit[k].model.lobe[l].table;
        s->model[k] = (ff_plot_model){f->expression, &f->model,  f->n_channels,
                                      f->shape,      f->channel, (const char(*)[FF_CHANNEL_NAME])f->channel_name,
                                      f->noise,      f->outcome, s->document->aperture};
    }
    return FF_OK;
}

static void add_channel(ff_html_subject *s, size_t problem, size_t c, size_t total, size_t at)
{
    const ff_table *t = s->r->table;
    const char *name = ff_problem_channel_name(s->r->problem[problem], c);
    int of_table = ff_table_channel_find(t, name);
    if (of_table < 0 && total == t->n_channels) of_table = (int)at;
    s->channel[s->n_channels++] = (ff_html_channel){problem, c, of_table, name};
}

/* Of many a few that are spread over all. */
static void choose_channels(ff_html_subject *s)
{
    size_t total = 0, at = 0;
    for (size_t p = 0; p < s->r->n_problems; p++) total += ff_problem_selected(s->r->problem[p])->n_channels;
    const size_t shown = total < FF_HTML_CHANNELS ? total : FF_HTML_CHANNELS;
    for (size_t p = 0; p < s->r->n_problems; p++)
        for (size_t c = 0; c < ff_problem_selected(s->r->problem[p])->n_channels; c++, at++)
            if (s->n_channels < shown && at == s->n_channels * total / shown) add_channel(s, p, c, total, at);
    s->skipped = total - s->n_channels;
}

/* The best that is not told apart from what is shown; else the next by rank. */
static ff_status choose_fits(ff_html_subject *s)
{
    size_t *rank = malloc((s->models + 1) * sizeof *rank);
    if (!rank) return FF_ERR_MEMORY;
    ff_report_rank(s->r, 0, rank);
    s->best = s->shown = s->rival = rank[0];
    if (s->models > 1) {
        const ff_fit_result *simplest = ff_report_simplest(s->r, &s->r->fit[s->best]);
        s->shown = (size_t)(simplest - s->r->fit);
        s->rival = s->shown == rank[0] ? rank[1] : rank[0];
    }
    free(rank);
    return FF_OK;
}

ff_status ff_html_subject_make(const ff_report_fits *r, const char *sha256, ff_isa isa, ff_html_subject *out, ff_error *err)
{
    *out = (ff_html_subject){.r = r, .sha256 = sha256, .isa = isa, .models = r->n_fits / r->n_problems};
    ff_status status = read_document(r, &out->document, err);
    if (!status) status = make_models(out);
    if (!status) status = choose_fits(out);
    if (!status) choose_channels(out);
    return status;
}

void ff_html_subject_free(ff_html_subject *s)
{
    ff_fit_document_free(s->document);
    free(s->model);
}

ff_plot_subject ff_html_plot_subject(const ff_html_subject *s, const ff_plot_model *model, size_t n)
{
    return (ff_plot_subject){.path = s->r->path,
                             .table = s->r->table,
                             .max_theta = s->r->options->max_theta,
                             .n_models = n,
                             .model = model,
                             .document = s->document,
                             .options = s->r->options,
                             .fit = &s->r->fit[s->shown]};
}
