/* Figures of studies, of tables and of models. */
#define _GNU_SOURCE
#include "internal_study_report.h"
#include "base/internal_options.h"
#include "report/plot/kinds/internal_plots.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SHOWN_FITS = 7 };

const char *ff_plot_name(size_t i)
{
    for (size_t k = 0; k < i; k++)
        if (!ff_plot_kind_at(k)) return NULL;
    const ff_plot_kind *kind = ff_plot_kind_at(i);
    return kind ? kind->name : NULL;
}

void ff_plot_options_init_size(ff_plot_options *o, size_t size)
{
    const ff_plot_options defaults = {
        .form = "svg", .log = -1, .repeats = 200, .seed = 1, .width = NAN, .height = NAN, .font = NAN};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

/* ---- options --------------------------------------------------------------------------------- */

/* NaN: as is usual. */
static ff_status check_length(double x, double lo, double hi, const char *what, ff_error *err)
{
    if (isnan(x) || (x >= lo && x <= hi)) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s %g: expected %g to %g", what, x, lo, hi);
}

static ff_status check_lists(const ff_plot_options *o, ff_error *err)
{
    if (o->n_incidence > FF_PLOT_LIST)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%zu incidences: expected %d at most", o->n_incidence,
                            (int)FF_PLOT_LIST);
    for (size_t k = 0; k < o->n_incidence; k++)
        if (!(o->incidence[k] >= 0 && o->incidence[k] <= 90))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "an incidence of %g degrees: expected 0 to 90", o->incidence[k]);
    if (o->per_row > FF_FIGURE_COLUMNS)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%zu panels side by side: expected %d at most", o->per_row,
                            (int)FF_FIGURE_COLUMNS);
    if (o->log < -1 || o->log > 1) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "log %d: expected 1, 0 or -1", o->log);
    if (!ff_isa_available(o->isa)) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the instruction set is not there");
    return FF_OK;
}

static ff_status take_options(const ff_plot_options *o, ff_plot_options *own, ff_error *err)
{
    ff_plot_options_init(own);
    ff_status status = FF_OK;
    if (o) status = ff_options_take("ff_plot_options", o, FF_END_OF(ff_plot_options, isa), own, sizeof *own, err);
    if (status == FF_OK) status = check_length(own->width, 20, 2000, "a width in millimetres of", err);
    if (status == FF_OK) status = check_length(own->height, 15, 2000, "a height in millimetres of", err);
    if (status == FF_OK) status = check_length(own->font, 3, 72, "a font in points of", err);
    return status == FF_OK ? check_lists(own, err) : status;
}

static ff_status form_of(const char *form, ff_figure_form *out, ff_error *err)
{
    for (int k = 0; k < FF_FIGURE_FORMS; k++)
        if (!strcmp(form, ff_figure_form_name(k))) {
            *out = (ff_figure_form)k;
            return FF_OK;
        }
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "no form '%.40s'; known are svg, pdf, csv", form);
}

static ff_status kind_of(const char *name, unsigned takes, const char *of, const ff_plot_kind **out, ff_error *err)
{
    char known[400] = "";
    for (size_t i = 0; (*out = ff_plot_kind_at(i)) != NULL; i++) {
        if (!strcmp((*out)->name, name)) {
            if ((*out)->takes & takes) return FF_OK;
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "'%s' is not drawn of %s", name, of);
        }
        const size_t used = strlen(known);
        snprintf(known + used, sizeof known - used, "%s%s", used ? ", " : "", (*out)->name);
    }
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "no figure '%.40s'; known are %s", name, known);
}

static ff_plot_choice choice_of(const ff_plot_options *o)
{
    ff_plot_choice c = {.log = o->log,
                        .channel = o->channel,
                        .parameter = o->parameter,
                        .repeats = o->repeats,
                        .seed = o->seed,
                        .isa = o->isa,
                        .n_incidence = o->n_incidence};
    for (size_t k = 0; k < o->n_incidence; k++) c.incidence[k] = o->incidence[k];
    return c;
}

/* ---- drawing --------------------------------------------------------------------------------- */

typedef struct drawing {
    const ff_figure *fig;
    ff_figure_form form;
    ff_error *err;
} drawing;

static ff_status write_figure(const void *context, FILE *out)
{
    const drawing *d = context;
    return ff_figure_write(d->fig, d->form, out, d->err);
}

static void lay_out(const ff_plot_options *o, ff_figure *fig)
{
    if (o->title) snprintf(fig->title, sizeof fig->title, "%s", o->title);
    if (o->per_row)
        fig->columns = o->per_row;
    else
        ff_figure_narrow(fig);
}

/* takes: what there is, of which the kind must be able to be drawn; `of` says it. */
static ff_status draw(const ff_plot_subject *s, const char *name, unsigned takes, const char *of, const ff_plot_options *options,
                      ff_content *out, ff_error *err)
{
    const double mm = 72 / 25.4;
    const ff_plot_kind *kind;
    ff_plot_options o;
    ff_figure_form form = FF_FIGURE_SVG;
    ff_figure fig;
    ff_status status = take_options(options, &o, err);
    if (status == FF_OK) status = form_of(o.form, &form, err);
    if (status == FF_OK) status = kind_of(name, takes, of, &kind, err);
    if (status != FF_OK) return status;
    const ff_plot_choice choice = choice_of(&o);
    ff_figure_init(&fig);
    if (!isnan(o.width)) fig.width = o.width * mm;
    if (!isnan(o.height)) fig.height = o.height * mm;
    if (!isnan(o.font)) fig.font = o.font;
    status = kind->build(s, &choice, &fig, err);
    if (status == FF_OK) status = fig.status;
    if (status == FF_OK) {
        lay_out(&o, &fig);
        status = ff_content_keep(write_figure, &(drawing){&fig, form, err}, out);
    }
    ff_figure_clear(&fig);
    if (status == FF_ERR_MEMORY) ff_error_set(err, status, NULL, 0, -1, "out of memory");
    return status;
}

/* ---- of what --------------------------------------------------------------------------------- */

static ff_status write_json(const void *r, FILE *out)
{
    return ff_report_fits_json(r, out);
}

/* As the JSON of the fits says it, so that a figure of a study and one of its document are the same. */
static ff_status document_of(const ff_report_fits *r, ff_fit_document **out, ff_error *err)
{
    ff_content text = {NULL, 0};
    ff_status status = ff_content_keep(write_json, r, &text);
    if (status == FF_OK) status = ff_fit_document_parse(text.text, text.n, NULL, out, err);
    ff_content_clear(&text);
    return status;
}

static void add_models(const ff_study *s, ff_fit_document *d, size_t most, ff_plot_model *model, size_t *n)
{
    for (*n = 0; *n < d->n_fits && *n < most; (*n)++) {
        ff_fitted *f = &d->fit[d->rank[*n]];
        for (uint32_t l = 0; l < f->model.n_lobes; l++) f->model.lobe[l].table = s->fit[d->rank[*n]].model.lobe[l].table;
        model[*n] = (ff_plot_model){f->expression, &f->model,  f->n_channels,
                                    f->shape,      f->channel, (const char(*)[FF_CHANNEL_NAME])f->channel_name,
                                    f->noise,      f->outcome, d->aperture};
    }
}

ff_status ff_study_plot(const ff_study *s, const char *kind, const ff_plot_options *o, ff_content *out, ff_error *err)
{
    enum { ALL = FF_PLOT_DATA | FF_PLOT_FITS | FF_PLOT_COMPARES | FF_PLOT_MODELS | FF_PLOT_RESULTS | FF_PLOT_FRESH };
    const ff_report_fits r = ff_study_report(s);
    const ff_plot_kind *of;
    ff_fit_document *d = NULL;
    ff_plot_model model[SHOWN_FITS];
    ff_status status = kind_of(kind, ALL, "fits", &of, err);
    if (status == FF_OK) status = document_of(&r, &d, err);
    if (status != FF_OK) return status;
    ff_plot_subject subject = {.path = s->path,
                               .table = s->table,
                               .max_theta = s->options.max_theta,
                               .model = model,
                               .document = d,
                               .problem = s->problem[0],
                               .places = s->looks.places,
                               .options = &s->options,
                               .fit = &s->fit[d->best]};
    add_models(s, d, of->takes & (FF_PLOT_COMPARES | FF_PLOT_RESULTS) ? SHOWN_FITS : 1, model, &subject.n_models);
    status = draw(&subject, kind, ALL, "fits", o, out, err);
    ff_fit_document_free(d);
    return status;
}

ff_status ff_table_plot(const ff_table *t, const char *kind, const ff_plot_options *o, ff_content *out, ff_error *err)
{
    const ff_plot_subject subject = {.path = "data", .table = t, .max_theta = FF_HORIZON};
    const ff_plot_kind *of;
    const ff_status status = kind_of(kind, FF_PLOT_DATA, "data alone", &of, err);
    if (status != FF_OK) return status;
    if (of->takes & (FF_PLOT_FITS | FF_PLOT_RESULTS | FF_PLOT_FRESH))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "'%s' is drawn of data with a fit", kind);
    return draw(&subject, kind, FF_PLOT_DATA, "data alone", o, out, err);
}

ff_status ff_models_plot(const ff_plotted *m, size_t n, const char *kind, const ff_plot_options *o, ff_content *out, ff_error *err)
{
    const ff_plot_kind *of;
    ff_status status = kind_of(kind, FF_PLOT_MODELS, "models alone", &of, err);
    if (status != FF_OK) return status;
    if (n == 0) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "no models to draw");
    if (n > 1 && !(of->uses & FF_PLOT_SEVERAL))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "'%s' shows one model, not %zu", kind, n);
    ff_plot_model *model = calloc(n, sizeof *model);
    if (!model) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    for (size_t k = 0; k < n && status == FF_OK; k++) {
        model[k] = (ff_plot_model){
            .label = m[k].label, .model = m[k].model, .n_channels = m[k].n_channels, .shape = m[k].shape, .channel = m[k].channel};
        status = ff_model_check(m[k].model, m[k].n_channels, m[k].shape, m[k].channel, err);
    }
    const ff_plot_subject subject = {.max_theta = FF_HORIZON, .n_models = n, .model = model};
    if (status == FF_OK) status = draw(&subject, kind, FF_PLOT_MODELS, "models alone", o, out, err);
    free(model);
    return status;
}
