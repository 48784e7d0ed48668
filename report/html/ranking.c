/* A comparison as tables: every fit by rank, and distributions by maskings. */
#include "internal_html.h"
#include "report/internal_fits_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- every fit ------------------------------------------------------------------------------- */

static void put_cell(ff_page *p, double x, int digits)
{
    char text[FF_TEXT_NUMBER], exact[FF_TEXT_NUMBER];
    if (!isfinite(x)) {
        ff_page_format(p, "<td></td>");
        return;
    }
    ff_page_format(p, "<td data-value=\"%s\">%s</td>", ff_text_exact(x, exact), ff_text_number(x, digits, text));
}

static const char *mark_of(const ff_html_subject *s, size_t fit, const ff_fit_result *best)
{
    const ff_versus *v = ff_report_versus(s->r, &s->r->fit[fit]);
    if (&s->r->fit[fit] == ff_report_simplest(s->r, best)) return "*";
    return v && !v->told_apart ? "~" : "";
}

static void put_row(ff_page *p, const ff_html_subject *s, size_t fit, size_t rank, const ff_fit_result *best)
{
    const ff_fit_result *f = &s->r->fit[fit];
    const ff_versus *v = ff_report_versus(s->r, f);
    ff_cell shape = {.is_number = 0}, base = {.is_number = 0};
    ff_report_shape_cell(&shape, f);
    ff_report_base_names(&base, &f->model);
    ff_page_format(p, "<tr data-fit=\"%zu\"><td data-value=\"%zu\">%zu %s</td><th scope=\"row\">", fit, rank, rank,
                   mark_of(s, fit, best));
    ff_page_text(p, ff_report_ndf_name(f));
    ff_page_format(p, "</th><td>");
    ff_page_text(p, ff_report_masking_name(f));
    ff_page_format(p, "</td><td>");
    ff_page_text(p, f->model.n_lobes ? ff_term_at(FF_FRESNEL, (size_t)f->model.lobe[0].fresnel)->name : "");
    ff_page_format(p, "</td><td>");
    ff_page_text(p, base.text);
    if (s->r->n_problems > 1) {
        ff_page_format(p, "</td><td>");
        ff_page_text(p, ff_problem_channel_name(s->r->problem[fit / s->models], 0));
    }
    ff_page_format(p, "</td><td>");
    ff_page_text(p, shape.text);
    ff_page_format(p, "</td>");
    put_cell(p, f->residual.objective, 5);
    put_cell(p, f->residual.objective / best->residual.objective, 4);
    put_cell(p, f->residual.rmse, 4);
    put_cell(p, f->residual.cosine_rmse, 4);
    put_cell(p, f->residual.log_rmse, 4);
    put_cell(p, v ? v->aic : NAN, 4);
    put_cell(p, v && f != best ? v->vuong_p : NAN, 3);
    put_cell(p, v && v->has_validation ? v->validation : NAN, 3);
    ff_page_format(p, "<td>%s</td></tr>\n", f->outcome == FF_CONVERGED ? "" : ff_outcome_name((int)f->outcome));
}

void ff_html_ranking(ff_page *p, const ff_html_subject *s)
{
    static const char *const head[] = {"rank",      "distribution", "masking", "fresnel",     "diffuse",  "channel",   "alpha",
                                       "objective", "/ best",       "rmse",    "cosine rmse", "log rmse", "delta AIC", "p",
                                       "held out",  "outcome"};
    size_t *rank = malloc((s->models + 1) * sizeof *rank);
    if (!rank) {
        ff_page_fail(p, FF_ERR_MEMORY);
        return;
    }
    ff_page_format(p,
                   "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"All fits\"><table id=\"ranking-table\" "
                   "class=\"sortable\"><caption>%zu fits; * the simplest that is not told apart from the best, ~ not told apart "
                   "either</caption>\n<thead><tr>",
                   s->r->n_fits);
    for (size_t k = 0; k < sizeof head / sizeof *head; k++)
        if (strcmp(head[k], "channel") || s->r->n_problems > 1) ff_page_format(p, "<th scope=\"col\">%s</th>", head[k]);
    ff_page_format(p, "</tr></thead>\n<tbody>\n");
    for (size_t problem = 0; problem < s->r->n_problems; problem++) {
        const ff_fit_result *best = ff_report_best(s->r, problem);
        ff_report_rank(s->r, problem, rank);
        for (size_t k = 0; k < s->models; k++) put_row(p, s, rank[k], k + 1, best);
    }
    ff_page_format(p, "</tbody></table></div>\n");
    free(rank);
}

/* ---- distributions by maskings --------------------------------------------------------------- */

typedef struct matrix {
    size_t n_rows, n_columns;
    int row[64], column[64]; /* distributions, maskings */
} matrix;

static size_t find(int *list, size_t *n, int term)
{
    size_t k = 0;
    while (k < *n && list[k] != term) k++;
    if (k == *n && *n < 64) list[(*n)++] = term;
    return k;
}

/* The best fit of the first problem with both; n_fits where there is none. */
static size_t best_of(const ff_html_subject *s, const size_t *rank, int ndf, int masking)
{
    for (size_t k = 0; k < s->models; k++) {
        const ff_model *m = &s->r->fit[rank[k]].model;
        if (m->n_lobes && m->lobe[0].ndf == ndf && m->lobe[0].masking == masking) return rank[k];
    }
    return s->r->n_fits;
}

/* Colour by ln(objective / best), from 0 at the best to 9 at ten times it. */
static int shade_of(double ratio)
{
    return isfinite(ratio) ? (int)fmin(fmax(floor(log10(ratio) * 9), 0), 9) : 9;
}

static void put_matrix_cell(ff_page *p, const ff_html_subject *s, size_t fit, const ff_fit_result *best)
{
    char text[FF_TEXT_NUMBER];
    if (fit == s->r->n_fits) {
        ff_page_format(p, "<td></td>");
        return;
    }
    const double ratio = s->r->fit[fit].residual.objective / best->residual.objective;
    const char *mark = mark_of(s, fit, best);
    ff_page_format(p, "<td class=\"shade%d%s\" data-fit=\"%zu\">%s%s</td>", shade_of(ratio), *mark ? " tied" : "", fit, mark,
                   isfinite(ratio) ? ff_text_number(ratio, 4, text) : "");
}

void ff_html_matrix(ff_page *p, const ff_html_subject *s)
{
    matrix m = {.n_rows = 0};
    size_t *rank = malloc((s->models + 1) * sizeof *rank);
    if (!rank) {
        ff_page_fail(p, FF_ERR_MEMORY);
        return;
    }
    const ff_fit_result *best = ff_report_best(s->r, 0);
    ff_report_rank(s->r, 0, rank);
    for (size_t k = 0; k < s->models; k++) {
        const ff_model *of = &s->r->fit[rank[k]].model;
        if (!of->n_lobes) continue;
        find(m.row, &m.n_rows, of->lobe[0].ndf);
        find(m.column, &m.n_columns, of->lobe[0].masking);
    }
    ff_page_format(p,
                   "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Distributions by maskings\"><table "
                   "id=\"matrix\" class=\"matrix\"><caption>Objective over the least, the best Fresnel and diffuse term of each; "
                   "outlined: not told apart from the best</caption>\n<thead><tr><th scope=\"col\">distribution</th>");
    for (size_t c = 0; c < m.n_columns; c++) {
        ff_page_format(p, "<th scope=\"col\">");
        ff_page_text(p, ff_term_at(FF_MASKING, (size_t)m.column[c])->name);
        ff_page_format(p, "</th>");
    }
    ff_page_format(p, "</tr></thead>\n<tbody>\n");
    for (size_t r = 0; r < m.n_rows; r++) {
        ff_page_format(p, "<tr><th scope=\"row\">");
        ff_page_text(p, ff_term_at(FF_NDF, (size_t)m.row[r])->name);
        ff_page_format(p, "</th>");
        for (size_t c = 0; c < m.n_columns; c++) put_matrix_cell(p, s, best_of(s, rank, m.row[r], m.column[c]), best);
        ff_page_format(p, "</tr>\n");
    }
    ff_page_format(p, "</tbody></table></div>\n");
    free(rank);
}
