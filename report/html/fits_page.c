/* The pages of fits and of comparisons. */
#include "internal_html.h"
#include "report/plot/kinds/internal_plots.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What the JSON of a page is written from. */
typedef struct page_data {
    const ff_html_subject *s;
    const ff_html_samples *v;
} page_data;

static ff_status write_result(const void *context, FILE *out)
{
    return ff_report_fits_json(((const page_data *)context)->s->r, out);
}

static ff_status write_page(const void *context, FILE *out)
{
    const page_data *d = context;
    const ff_html_subject *s = d->s;
    ff_json j;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_LINE);
    ff_json_string(&j, "path", s->r->path);
    ff_json_string(&j, "sha256", s->sha256);
    ff_json_string(&j, "loss", ff_loss_name((int)s->r->options->loss));
    ff_json_bool(&j, "by_noise", s->r->options->weighting == FF_WEIGHT_NOISE);
    ff_json_string(&j, "robust", s->r->options->robust == FF_ROBUST_NONE ? NULL : ff_robust_name((int)s->r->options->robust));
    ff_json_number(&j, "max_theta", ff_report_degrees(s->r->options->max_theta));
    ff_json_bool(&j, "isotropic", s->r->table->isotropic);
    ff_json_integer(&j, "problems", (int64_t)s->r->n_problems);
    ff_json_integer(&j, "best", (int64_t)s->best);
    ff_json_integer(&j, "shown", (int64_t)s->shown);
    ff_json_integer(&j, "rival", (int64_t)s->rival);
    ff_html_samples_json(&j, s, d->v);
    ff_status status = ff_html_models_json(&j, s, d->v);
    if (!status && s->models == 1) status = ff_html_start_json(&j, s);
    if (!status) status = ff_html_sphere_json(&j, s);
    ff_json_close(&j);
    return status;
}

static ff_status write_table(const void *context, FILE *out)
{
    const ff_html_subject *s = ((const page_data *)context)->s;
    return ff_report_table_text(s->r->path, s->r->table, NULL, out);
}

/* ---- figures --------------------------------------------------------------------------------- */

static void put_kind(ff_page *p, const ff_html_subject *s, const ff_plot_kind *kind, const ff_plot_subject *of, const char *caption,
                     int with_numbers)
{
    const ff_plot_choice any = {.log = -1, .isa = s->isa, .repeats = 1, .seed = 1};
    ff_figure fig;
    ff_error reason = {0};
    ff_figure_init(&fig);
    if (p->status) return;
    const ff_status status = kind->build(of, &any, &fig, &reason);
    ff_page_figure(p, kind->name, caption, &fig, status, &reason, with_numbers);
}

static void put_slices(ff_page *p, const ff_html_subject *s, const ff_plot_subject *of)
{
    ff_page_section(p, "slices", "Plane of incidence");
    put_kind(p, s, &ff_plot_slice, of, "f against the angle of the view; bars are one standard deviation", 0);
    ff_page_section_end(p);
}

static void put_half_angles(ff_page *p, const ff_html_subject *s, const ff_plot_subject *of)
{
    ff_page_section(p, "profiles", "By half angle");
    if (of->n_models == 1 && of->model[0].model->n_lobes)
        put_kind(p, s, &ff_plot_profile, of, "f and D by half angle; F and G of the model", 0);
    ff_page_section_end(p);
    ff_page_section(p, "images", "Image slices");
    put_kind(p, s, &ff_plot_image, of,
             "Half angle against difference angle: data, model, and where the model is too high or too low", 0);
    ff_page_section_end(p);
}

static void put_coverage(ff_page *p, const ff_html_subject *s, const ff_plot_subject *of)
{
    ff_page_section(p, "directions", "Coverage");
    put_kind(p, s, &ff_plot_coverage, of, "Directions of light and view that were measured", 0);
    ff_page_section_end(p);
}

static void put_residuals(ff_page *p, const ff_html_subject *s, const ff_plot_subject *of)
{
    ff_page_section(p, "by-angle", "Residuals by angle");
    put_kind(p, s, &ff_plot_residuals, of, "Where the model is too high or too low, by bands of 10 degrees", 1);
    ff_page_section_end(p);
}

static void put_data(ff_page *p, const page_data *d)
{
    ff_page_section(p, "data", "Data");
    ff_page_block(p, "What is in the file", write_table, d);
    ff_page_section_end(p);
}

/* ---- of a fit -------------------------------------------------------------------------------- */

static void put_check(ff_page *p, const ff_html_subject *s, const char *id, const char *caption,
                      ff_status (*build)(const ff_html_subject *, ff_figure *, ff_error *))
{
    ff_figure fig;
    ff_error reason = {0};
    ff_figure_init(&fig);
    if (p->status) return;
    const ff_status status = build(s, &fig, &reason);
    ff_page_figure(p, id, caption, &fig, status, &reason, 1);
}

static ff_status build_albedo(const ff_html_subject *s, ff_figure *fig, ff_error *err)
{
    char names[FF_PLOT_LIST * FF_CHANNEL_NAME] = "";
    const ff_plot_model *m = &s->model[s->shown];
    const ff_plot_subject of = ff_html_plot_subject(s, m, 1);
    ff_plot_choice c = {.log = -1, .isa = s->isa};
    for (size_t k = 0; k < m->n_channels && m->n_channels <= 4; k++)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", k ? "," : "", m->channel_name[k]);
    if (*names && !strchr(m->channel_name[0], ',')) c.channel = names;
    ff_status status = ff_plot_albedo.build(&of, &c, fig, err);
    if (status == FF_ERR_UNKNOWN) { /* a name with a comma in it */
        ff_figure_clear(fig);
        ff_figure_init(fig);
        c.channel = NULL;
        status = ff_plot_albedo.build(&of, &c, fig, err);
    }
    if (!status && fig->n_panels) ff_panel_rule_y(fig, fig->panel[0], "all of the light", ff_style_zero, 1);
    return status;
}

static void put_symmetry(ff_page *p, const page_data *d)
{
    ff_page_format(p, "<p id=\"reciprocity\">Reciprocity of the data: see <a href=\"#data\">what is in the file</a>. ");
    const ff_plot_model *m = &d->s->model[d->s->shown];
    ff_page_format(p, "The model %s reciprocal for these parameters.</p>\n",
                   ff_model_claims(m->model, m->shape) & FF_RECIPROCAL ? "is" : "is not");
}

static void put_checks(ff_page *p, const page_data *d)
{
    const ff_html_subject *s = d->s;
    ff_page_section(p, "checks", "Checks");
    put_check(p, s, "cut-off", "Parameters when samples beyond an angle are left out", ff_html_cut_offs);
    put_check(p, s, "losses", "Parameters by other losses", ff_html_losses);
    put_check(p, s, "albedo", "Share of the light that the model reflects, by incidence", build_albedo);
    put_symmetry(p, d);
    ff_page_section_end(p);
}

static void put_parameters(ff_page *p, const ff_html_subject *s, const ff_plot_subject *of)
{
    ff_page_section(p, "parameters", "Parameters");
    for (size_t k = 0; k < s->r->n_fits && k < FF_HTML_CHANNELS; k++) ff_html_parameters(p, s, k);
    put_kind(p, s, &ff_plot_forest, of, "Parameters with their 95 % intervals", 1);
    ff_html_units(p, s);
    ff_page_section_end(p);
}

static void put_fit(ff_page *p, const page_data *d)
{
    const ff_html_subject *s = d->s;
    const ff_plot_subject of = ff_html_plot_subject(s, &s->model[s->shown], 1);
    ff_html_verdict(p, s);
    ff_html_spheres(p, s);
    put_slices(p, s, &of);
    put_half_angles(p, s, &of);
    put_residuals(p, s, &of);
    put_coverage(p, s, &of);
    put_parameters(p, s, &of);
    put_checks(p, d);
    put_data(p, d);
    ff_html_reproduce(p, s);
}

/* ---- of a comparison ------------------------------------------------------------------------- */

enum { DIFFERENCES = 24 };

/* By common weights in squared standard deviations, else of the objective. */
static double difference_of(const ff_versus *v)
{
    return v->weighted ? v->standardised : v->objective;
}

static void add_difference(const ff_versus *v, size_t row, ff_series *s, ff_series *held_out)
{
    const double x = difference_of(v), error = fabs(x / v->vuong_z);
    s->x[row] = x;
    s->y[row] = (double)row;
    if (isfinite(error) && !v->by_parameter) {
        s->x_low[row] = x - 1.96 * error;
        s->x_high[row] = x + 1.96 * error;
    }
    if (!held_out || !v->has_validation) return;
    held_out->x[row] = v->validation;
    held_out->y[row] = (double)row;
    held_out->x_low[row] = v->validation - 1.96 * v->validation_error;
    held_out->x_high[row] = v->validation + 1.96 * v->validation_error;
}

static ff_panel *difference_panel(const ff_html_subject *s, ff_figure *fig, const size_t *rank, size_t n, const char *label)
{
    ff_panel *p = ff_figure_panel(fig, "");
    if (!p) return NULL;
    ff_axis_say(&p->x, label, "1", FF_SCALE_LINEAR, NAN, NAN);
    ff_axis_names(fig, &p->y, n);
    for (size_t k = 0; k < n; k++) {
        char name[FF_AXIS_NAME];
        snprintf(name, sizeof name, "%s/%s", ff_term_at(FF_NDF, (size_t)s->model[rank[k]].model->lobe[0].ndf)->name,
                 ff_term_at(FF_MASKING, (size_t)s->model[rank[k]].model->lobe[0].masking)->name);
        ff_axis_name(&p->y, k, fig->n_panels == 1 ? name : "");
    }
    ff_panel_rule_x(fig, p, "", ff_style_zero, 0);
    return p;
}

/* Of the best of the first problem. */
static ff_status build_differences(const ff_html_subject *s, ff_figure *fig, ff_error *err)
{
    const size_t n = s->models < DIFFERENCES ? s->models : DIFFERENCES;
    size_t *rank = malloc((s->models + 1) * sizeof *rank);
    if (!rank) return FF_ERR_MEMORY;
    ff_report_rank(s->r, 0, rank);
    const ff_versus *first = ff_report_versus(s->r, &s->r->fit[rank[n > 1 ? 1 : 0]]);
    if (!first) {
        free(rank);
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "no test was made");
    }
    ff_panel *p = difference_panel(s, fig, rank, n, first->weighted ? "Δ χ^{2}" : "Δ objective");
    ff_panel *q = s->r->folds ? difference_panel(s, fig, rank, n, "Δ held-out objective") : NULL;
    ff_series *all = ff_panel_series(fig, p, FF_SERIES_POINTS, "", ff_style_data, n, FF_WITH_X_ERRORS);
    ff_series *held_out = q ? ff_panel_series(fig, q, FF_SERIES_POINTS, "", ff_style_data, n, FF_WITH_X_ERRORS) : NULL;
    for (size_t k = 0; k < n && all; k++) {
        const ff_versus *v = ff_report_versus(s->r, &s->r->fit[rank[k]]);
        if (v) add_difference(v, k, all, held_out);
    }
    fig->columns = q ? 2 : 1;
    if (s->models > n) ff_figure_note(fig, "%zu more fits are not drawn", s->models - n);
    free(rank);
    return FF_OK;
}

static ff_status build_differ(const ff_html_subject *s, ff_figure *fig, ff_error *err)
{
    return ff_html_differ(s, s->shown, s->rival, fig, err);
}

static void put_ranking(ff_page *p, const ff_html_subject *s)
{
    ff_page_section(p, "ranking", "Ranking");
    ff_html_matrix(p, s);
    put_check(p, s, "differences", "Differences to the best with their 95 % intervals", build_differences);
    ff_html_ranking(p, s);
    ff_page_section_end(p);
}

static void put_comparison(ff_page *p, const page_data *d)
{
    const ff_html_subject *s = d->s;
    const ff_plot_model two[] = {s->model[s->shown], s->model[s->rival]};
    const ff_plot_subject one = ff_html_plot_subject(s, two, 1), both = ff_html_plot_subject(s, two, 2);
    ff_html_verdict(p, s);
    put_ranking(p, s);
    ff_page_section(p, "differ", "Where two models differ");
    put_check(p, s, "differ-image", "B less A over incidence and view, in the plane of incidence: measure where they differ",
              build_differ);
    ff_page_section_end(p);
    ff_html_spheres(p, s);
    put_residuals(p, s, &one);
    put_slices(p, s, &both);
    put_half_angles(p, s, &one);
    put_coverage(p, s, &one);
    ff_page_section(p, "parameters", "Parameters");
    ff_html_parameters(p, s, s->shown);
    if (s->rival != s->shown) ff_html_parameters(p, s, s->rival);
    put_kind(p, s, &ff_plot_forest, &one, "Parameters with their 95 % intervals, best first", 1);
    ff_html_units(p, s);
    ff_page_section_end(p);
    put_data(p, d);
    ff_html_reproduce(p, s);
}

/* ---- the whole ------------------------------------------------------------------------------- */

static void put_page(ff_page *p, const page_data *d)
{
    const ff_html_subject *s = d->s;
    const ff_page_kind kind = s->models > 1 ? FF_PAGE_COMPARISON : FF_PAGE_FIT;
    char title[600], subtitle[FF_MODEL_NAME + 128];
    const char *slash = strrchr(s->r->path, '/');
    snprintf(title, sizeof title, "%s: %s", slash && slash[1] ? slash + 1 : s->r->path,
             kind == FF_PAGE_FIT ? s->model[s->shown].label : "comparison of models");
    snprintf(subtitle, sizeof subtitle, "facetfit %s, loss %s%s", s->r->head.version, ff_loss_name((int)s->r->options->loss),
             s->r->n_problems > 1 ? ", each channel by itself" : "");
    ff_page_begin(p, kind, title, subtitle);
    if (kind == FF_PAGE_FIT)
        put_fit(p, d);
    else
        put_comparison(p, d);
    ff_page_json(p, "result", write_result, d);
    ff_page_json(p, "page", write_page, d);
    ff_page_end(p, kind);
}

ff_status ff_html_fits_write(const ff_report_fits *r, const char *sha256, ff_isa isa, FILE *out, ff_error *err)
{
    ff_html_subject s;
    ff_html_samples v = {.n = 0};
    ff_page p = {.out = out, .err = err};
    ff_status status = ff_html_subject_make(r, sha256, isa, &s, err);
    if (!status) status = ff_html_samples_make(&s, &v, err);
    if (!status) {
        put_page(&p, &(page_data){&s, &v});
        status = p.status;
    }
    if (status && err && !err->message[0]) ff_error_set(err, status, NULL, 0, -1, "the page: %s", ff_status_str(status));
    ff_html_samples_free(&v);
    ff_html_subject_free(&s);
    return status;
}
