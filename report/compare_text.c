/* A comparison as people read it, and its ranking as a table. */
#include "internal_fits_text.h"
#include "internal_verdict.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the ranking ----------------------------------------------------------------------------- */

/* A row is a fit; those of a problem stand together, best first. */
typedef struct ranking {
    const ff_report_fits *r;
    size_t n;
    size_t *fit;          /* [n]                                                           */
    size_t *best;         /* [n] the best one of its problem                               */
    double *aic;          /* [n_problems] the least                                        */
    int together;         /* 1: all problems in one table                                  */
    int fresnels, bases;  /* 1: the models differ in them                                  */
    const char **shape;   /* [n_shape] names of the parameters of all models               */
    const char **channel; /* [n_channel]                                                   */
    size_t n_shape, n_channel;
} ranking;

static const ff_fit_result *fit_at(const ranking *t, size_t row)
{
    return &t->r->fit[t->fit[row]];
}

static const ff_fit_result *best_at(const ranking *t, size_t row)
{
    return &t->r->fit[t->best[row]];
}

static size_t problem_at(const ranking *t, size_t row)
{
    return t->fit[row] / (t->r->n_fits / t->r->n_problems);
}

static const ff_versus *versus_at(const ranking *t, size_t row)
{
    return ff_report_versus(t->r, fit_at(t, row));
}

/* ---- its columns ----------------------------------------------------------------------------- */

static int of_several(const void *of)
{
    const ranking *t = of;
    return t->together && t->r->n_problems > 1;
}

static void problem_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s",
                 ff_problem_channel_name(ff_report_problem_of(((const ranking *)w.of)->r, ((const ranking *)w.of)->fit[w.row]), 0));
}

static void mark_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    const ff_fit_result *f = fit_at(t, w.row), *best = best_at(t, w.row);
    const ff_versus *v = versus_at(t, w.row);
    const int chosen = f == ff_report_simplest(t->r, best);
    ff_cell_text(out, "%s", chosen ? "*" : v && !v->told_apart ? "~" : "");
    out->ink = chosen ? FF_INK_GOOD : FF_INK_FAINT;
}

/* From 1 for the best of its problem. */
static void rank_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    size_t first = w.row;
    while (first && problem_at(t, first - 1) == problem_at(t, w.row)) first--;
    ff_cell_exact(out, (double)(w.row - first + 1));
}

static int has_target(const void *of)
{
    return ((const ranking *)of)->r->target != NULL;
}

/* "blender:metal" */
static void target_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    const ff_report_target *target = &t->r->target[t->fit[w.row]];
    ff_cell_text(out, "%s:%s", target->target->name, target->material->name);
}

static int has_no_target(const void *of)
{
    return !has_target(of);
}

static void ndf_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_report_ndf_name(fit_at(w.of, w.row)));
}

static void masking_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_report_masking_name(fit_at(w.of, w.row)));
}

static int fresnels_differ(const void *of)
{
    return ((const ranking *)of)->fresnels;
}

static void fresnel_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_term_at(FF_FRESNEL, (size_t)fit_at(w.of, w.row)->model.lobe[0].fresnel)->name);
}

static int bases_differ(const void *of)
{
    return ((const ranking *)of)->bases;
}

static void base_cell(ff_cell *out, ff_where w)
{
    ff_report_base_names(out, &fit_at(w.of, w.row)->model);
}

static void model_cell(ff_cell *out, ff_where w)
{
    char expression[FF_MODEL_NAME];
    ff_model_expression(&fit_at(w.of, w.row)->model, expression, sizeof expression);
    ff_cell_text(out, "%s", expression);
}

static void shape_cell(ff_cell *out, ff_where w)
{
    ff_report_shape_cell(out, fit_at(w.of, w.row));
}

static void f0_cell(ff_cell *out, ff_where w)
{
    ff_report_channel_cells(out, fit_at(w.of, w.row), 1, "f0");
}

static void kd_cell(ff_cell *out, ff_where w)
{
    ff_report_channel_cells(out, fit_at(w.of, w.row), 0, "kd");
}

static void relative_cell(ff_cell *out, ff_where w)
{
    const double best = best_at(w.of, w.row)->residual.objective, x = fit_at(w.of, w.row)->residual.objective;
    ff_cell_number(out, x == best ? 1 : x / best, 4);
}

enum { OBJECTIVE, RMSE, COSINE, LOG };
static void residual_cell(ff_cell *out, ff_where w)
{
    const ff_residual *r = &fit_at(w.of, w.row)->residual;
    const double x[] = {[OBJECTIVE] = r->objective, [RMSE] = r->rmse, [COSINE] = r->cosine_rmse, [LOG] = r->log_rmse};
    ff_cell_number(out, x[w.index], w.index == OBJECTIVE ? 5 : 4);
}

static void aic_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    const ff_versus *v = versus_at(t, w.row);
    ff_cell_fixed(out, v ? v->aic : fit_at(t, w.row)->aic - t->aic[problem_at(t, w.row)], 1);
}

static int has_versus(const void *of)
{
    const ranking *t = of;
    return t->n && versus_at(t, 0) != NULL;
}

static void vuong_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    if (fit_at(t, w.row) == best_at(t, w.row)) return;
    const ff_versus *v = versus_at(t, w.row);
    char number[FF_TEXT_NUMBER], text[FF_TEXT_NUMBER + 4];
    if (isnan(v->vuong_z)) return; /* no test was possible */
    snprintf(text, sizeof text, "%s%s", ff_text_number(v->vuong_z, 3, number), v->by_parameter ? " w" : "");
    ff_cell_rounded(out, v->vuong_z, text);
}

/* How probable so large a difference is where there is none. */
static void evidence_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    char number[FF_TEXT_NUMBER];
    if (fit_at(t, w.row) == best_at(t, w.row)) return;
    const double p = versus_at(t, w.row)->vuong_p;
    if (!isnan(p)) ff_cell_text(out, p < 1e-3 ? "< 0.001" : "%s", ff_text_fixed(p, 3, number));
}

static void apart_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    if (fit_at(t, w.row) != best_at(t, w.row)) ff_cell_text(out, "%s", versus_at(t, w.row)->told_apart ? "yes" : "no");
}

static int has_folds(const void *of)
{
    return ((const ranking *)of)->r->folds != 0;
}

/* "3.1 +- 0.4" */
static void held_out_text(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    if (fit_at(t, w.row) == best_at(t, w.row)) return;
    const ff_versus *v = versus_at(t, w.row);
    ff_text_with_error(v->validation, v->validation_error, value, error);
    ff_cell_text(out, "%s +- %s", value, error);
}

enum { VALUE, ERROR };
static void held_out_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    if (fit_at(t, w.row) == best_at(t, w.row)) return;
    const ff_versus *v = versus_at(t, w.row);
    ff_cell_exact(out, w.index == VALUE ? v->validation : v->validation_error);
}

static void outcome_text(ff_cell *out, ff_where w)
{
    ff_report_outcome_cell(out, fit_at(w.of, w.row));
}

static void outcome_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_outcome_name((int)fit_at(w.of, w.row)->outcome));
}

static void shape_value_cell(ff_cell *out, ff_where w)
{
    const ff_fit_result *f = fit_at(w.of, w.row);
    for (uint32_t k = 0; k < f->model.n_shape; k++)
        if (!strcmp(f->model.shape[k].name, ((const ranking *)w.of)->shape[w.index])) ff_cell_exact(out, f->shape_value[k].value);
}

/* index: channel by channel, [n_channel] names each. */
static void channel_value_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    const ff_fit_result *f = fit_at(t, w.row);
    const size_t c = w.index / t->n_channel;
    for (uint32_t k = 0; k < f->model.n_channel; k++)
        if (!strcmp(f->model.channel[k].name, t->channel[w.index % t->n_channel]))
            ff_cell_exact(out, f->channel_value[c * f->model.n_channel + k].value);
}

/* "f0[r] kd" */
static void on_bound_cell(ff_cell *out, ff_where w)
{
    const ranking *t = w.of;
    const ff_fit_result *f = fit_at(t, w.row);
    char name[FF_REPORT_NAME];
    size_t at = 0;
    for (uint32_t k = 0; k < f->model.n_shape && at < sizeof out->text; k++)
        if (f->shape_value[k].at_bound)
            at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s", at ? " " : "", f->model.shape[k].name);
    for (uint32_t k = 0; k < f->model.n_channel; k++)
        for (size_t c = 0; c < f->n_channels && at < sizeof out->text; c++)
            if (f->channel_value[c * f->model.n_channel + k].at_bound)
                at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s", at ? " " : "",
                                       ff_report_channel_param(ff_report_problem_of(t->r, t->fit[w.row]), f, k, c, name));
}

static const ff_column ranking_columns[] = {
    {.head = "channel", .wanted = of_several, .cell = problem_cell},
    {.head = "", .audience = FF_PEOPLE, .cell = mark_cell},
    {.head = "rank", .audience = FF_PROGRAMS, .cell = rank_cell},
    {.head = "renderer", .wanted = has_target, .cell = target_cell},
    {.head = "distribution", .wanted = has_no_target, .cell = ndf_cell, .least = 9},
    {.head = "masking", .wanted = has_no_target, .cell = masking_cell, .least = 14},
    {.head = "fresnel", .wanted = fresnels_differ, .cell = fresnel_cell, .least = 7},
    {.head = "diffuse", .wanted = bases_differ, .cell = base_cell, .least = 7},
    {.head = "model", .audience = FF_PROGRAMS, .cell = model_cell},
    {.head = "alpha", .audience = FF_PEOPLE, .cell = shape_cell, .least = 8},
    {.head = "f0", .audience = FF_PEOPLE, .cell = f0_cell, .drop = 4},
    {.head = "kd", .audience = FF_PEOPLE, .cell = kd_cell, .drop = 5},
    {.head = "objective", .align = FF_RIGHT, .cell = residual_cell, .index = OBJECTIVE, .drop = 6},
    {.head = "/ best", .audience = FF_PEOPLE, .align = FF_RIGHT, .cell = relative_cell},
    {.head = "rmse", .align = FF_RIGHT, .cell = residual_cell, .index = RMSE, .drop = 10},
    {.head = "cosine rmse", .align = FF_RIGHT, .cell = residual_cell, .index = COSINE, .drop = 8},
    {.head = "log rmse", .align = FF_RIGHT, .cell = residual_cell, .index = LOG, .drop = 9},
    {.head = "delta AIC", .key = "delta_aic", .align = FF_RIGHT, .cell = aic_cell, .drop = 7},
    {.head = "Vuong z", .key = "vuong_z", .align = FF_RIGHT, .wanted = has_versus, .cell = vuong_cell, .drop = 3},
    {.head = "p", .audience = FF_PEOPLE, .align = FF_RIGHT, .wanted = has_versus, .cell = evidence_cell},
    {.head = "told apart", .audience = FF_PROGRAMS, .wanted = has_versus, .cell = apart_cell},
    {.head = "held out", .align = FF_RIGHT, .audience = FF_PEOPLE, .wanted = has_folds, .cell = held_out_text, .drop = 1},
    {.head = "held out", .audience = FF_PROGRAMS, .wanted = has_folds, .cell = held_out_cell, .index = VALUE},
    {.head = "held out error", .audience = FF_PROGRAMS, .wanted = has_folds, .cell = held_out_cell, .index = ERROR},
    {.head = "", .audience = FF_PEOPLE, .cell = outcome_text},
    {.head = "outcome", .audience = FF_PROGRAMS, .cell = outcome_cell},
    {.head = "on bound", .audience = FF_PROGRAMS, .cell = on_bound_cell}};

/* ---- making it ------------------------------------------------------------------------------- */

static void ranking_free(ranking *t)
{
    free(t->fit);
    free(t->best);
    free(t->aic);
    free(t->shape);
    free(t->channel);
}

static ff_status ranking_new(const ff_report_fits *r, ranking *t)
{
    const size_t problems = r->n_problems ? r->n_problems : 1;
    *t = (ranking){.r = r, .fit = malloc((r->n_fits + 1) * sizeof *t->fit), .best = malloc((r->n_fits + 1) * sizeof *t->best)};
    t->aic = malloc(problems * sizeof *t->aic);
    if (t->fit && t->best && t->aic) return FF_OK;
    ranking_free(t);
    return FF_ERR_MEMORY;
}

/* Adds the fits of problem p, the first `most` of them; 0 = all. */
static void add_problem(ranking *t, size_t p, size_t most)
{
    const size_t n = t->r->n_fits / t->r->n_problems, shown = most && most < n ? most : n;
    ff_report_rank(t->r, p, t->fit + t->n);
    t->aic[p] = INFINITY;
    for (size_t i = 0; i < n; i++) t->aic[p] = fmin(t->aic[p], t->r->fit[t->fit[t->n + i]].aic);
    for (size_t i = 0; i < shown; i++) t->best[t->n + i] = t->fit[t->n];
    t->n += shown;
}

static void see_what_differs(ranking *t)
{
    const ff_report_fits *r = t->r;
    ff_cell first = {.is_number = 0}, other = {.is_number = 0};
    ff_report_base_names(&first, &r->fit[0].model);
    for (size_t i = 1; i < r->n_fits; i++) {
        t->fresnels |= r->fit[i].model.lobe[0].fresnel != r->fit[0].model.lobe[0].fresnel;
        ff_report_base_names(&other, &r->fit[i].model);
        t->bases |= strcmp(first.text, other.text) != 0;
    }
}

static ff_status put_ranking(ranking *t, ff_table_form form, FILE *out)
{
    see_what_differs(t);
    return ff_columns_print(ranking_columns, FF_COUNT(ranking_columns), t, t->n, form, "", t->r->style, out);
}

/* ---- with a column for every parameter ------------------------------------------------------- */

/* Adds a name that is not there yet. */
static void add_name(const char **names, size_t *n, const char *name)
{
    for (size_t i = 0; i < *n; i++)
        if (!strcmp(names[i], name)) return;
    names[(*n)++] = name;
}

static ff_status collect_names(ranking *t)
{
    size_t shape = 1, channel = 1;
    for (size_t i = 0; i < t->r->n_fits; i++) {
        shape += t->r->fit[i].model.n_shape;
        channel += t->r->fit[i].model.n_channel;
    }
    t->shape = malloc(shape * sizeof *t->shape);
    t->channel = malloc(channel * sizeof *t->channel);
    if (!t->shape || !t->channel) return FF_ERR_MEMORY;
    for (size_t i = 0; i < t->r->n_fits; i++) {
        const ff_fit_result *f = &t->r->fit[i];
        for (uint32_t k = 0; k < f->model.n_shape; k++)
            if (!ff_report_left_alone(&f->shape_value[k], f->model.shape[k].info))
                add_name(t->shape, &t->n_shape, f->model.shape[k].name);
        for (uint32_t k = 0; k < f->model.n_channel; k++)
            if (!ff_report_all_left_alone(f, k)) add_name(t->channel, &t->n_channel, f->model.channel[k].name);
    }
    return FF_OK;
}

/* "f0[r]" for every parameter and channel, one after another in `label`. */
static ff_status put_wide(ranking *t, ff_table_form form, FILE *out)
{
    const size_t channels = t->r->fit[0].n_channels, fixed = FF_COUNT(ranking_columns);
    const size_t n = fixed + t->n_shape + t->n_channel * channels;
    ff_column *column = malloc(n * sizeof *column);
    char(*label)[FF_REPORT_KEY] = malloc((t->n_channel * channels + 1) * sizeof *label);
    ff_status status = column && label ? FF_OK : FF_ERR_MEMORY;
    if (status == FF_OK) {
        memcpy(column, ranking_columns, sizeof ranking_columns);
        for (size_t k = 0; k < t->n_shape; k++)
            column[fixed + k] = (ff_column){.head = t->shape[k], .cell = shape_value_cell, .index = k};
        for (size_t k = 0; k < t->n_channel * channels; k++) {
            const char *name = t->channel[k % t->n_channel];
            const char *of = channels > 1 ? ff_problem_channel_name(t->r->problem[0], k / t->n_channel) : NULL;
            snprintf(label[k], sizeof label[k], "%s", name);
            column[fixed + t->n_shape + k] =
                (ff_column){.head = of ? ff_report_key(name, of, label[k]) : label[k], .cell = channel_value_cell, .index = k};
        }
        see_what_differs(t);
        status = ff_columns_print(column, n, t, t->n, form, "", t->r->style, out);
    }
    free(column);
    free(label);
    return status;
}

ff_status ff_report_compare_table(const ff_report_fits *r, ff_table_form form, FILE *out)
{
    const int all = ff_table_form_exact(form);
    const size_t n = r->n_fits / r->n_problems;
    ranking t;
    ff_status status = ranking_new(r, &t);
    if (status != FF_OK) return status;
    t.together = 1;
    for (size_t p = 0; p < r->n_problems; p++) add_problem(&t, p, all ? 0 : r->rows);
    if (all) status = collect_names(&t);
    if (status == FF_OK) status = all ? put_wide(&t, form, out) : put_ranking(&t, form, out);
    if (status == FF_OK && t.n < r->n_fits)
        ff_columns_remark(form, out, "... and %zu more%s (--rows 0 shows all)", n - r->rows, r->n_problems > 1 ? " of each" : "");
    ranking_free(&t);
    return status;
}

/* ---- what stands under it -------------------------------------------------------------------- */

typedef struct maskings {
    const ff_report_fits *r;
    const size_t *row; /* the winner first */
} maskings;

static const ff_fit_result *masking_fit(const void *of, size_t row)
{
    const maskings *t = of;
    return &t->r->fit[t->row[row]];
}

static void by_masking_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_report_masking_name(masking_fit(w.of, w.row)));
}

static void ratio_cell(ff_cell *out, ff_where w)
{
    const double best = masking_fit(w.of, 0)->residual.objective, x = masking_fit(w.of, w.row)->residual.objective;
    ff_cell_number(out, x == best ? 1 : x / best, 5);
}

static void with_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_report_ndf_name(masking_fit(w.of, w.row)));
}

static const ff_column masking_columns[] = {{.head = "by masking", .cell = by_masking_cell, .least = 14},
                                            {.head = "objective / best", .align = FF_RIGHT, .cell = ratio_cell},
                                            {.head = "with", .cell = with_cell}};

static ff_status put_maskings(const ff_report_fits *r, size_t p, FILE *out)
{
    if (r->target) return FF_OK; /* renderers are what they are: nobody chooses their masking */
    size_t *row, n;
    ff_status status = ff_report_best_of_maskings(r, p, &row, &n);
    if (status != FF_OK) return status;
    const maskings t = {r, row};
    status = ff_columns_print(masking_columns, FF_COUNT(masking_columns), &t, n, FF_TABLE_TEXT, "", r->style, out);
    if (status == FF_OK && r->trust) status = ff_report_bands_text(r, row, n, out);
    free(row);
    return status;
}

static int any_on_bound(const ff_fit_result *f)
{
    int any = 0;
    for (uint32_t k = 0; k < f->model.n_shape; k++) any |= f->shape_value[k].at_bound;
    for (size_t k = 0; k < f->n_channels * f->model.n_channel; k++) any |= f->channel_value[k].at_bound;
    return any;
}

/* What a model that contains the simplest gains by its parameter: nothing that these data show. */
static void put_no_better(const ff_report_fits *r, size_t p, FILE *out)
{
    const size_t models = r->n_fits / r->n_problems;
    for (size_t i = p * models; i < (p + 1) * models; i++) {
        const ff_versus *v = ff_report_versus(r, &r->fit[i]);
        if (!v || !v->by_parameter || v->told_apart) continue;
        fprintf(out, "%s/%s: the model with the lowest residuals becomes it with one parameter held, and is no better for it\n",
                ff_report_ndf_name(&r->fit[i]), ff_report_masking_name(&r->fit[i]));
    }
}

/* Are there too few incidences for any test? */
static int is_untested(const ff_report_fits *r, size_t p)
{
    const ff_versus *v = ff_report_versus(r, &r->fit[p * (r->n_fits / r->n_problems)]);
    return v && v->weighted && v->incidences < 3;
}

/* What z and delta AIC are of, where the table shows that they are not what a reader would take them for. */
static void put_measures(const ff_report_fits *r, FILE *out)
{
    int by_parameter = 0, against_order = 0;
    for (size_t i = 0; i < r->n_fits; i++) {
        const ff_versus *v = ff_report_versus(r, &r->fit[i]);
        by_parameter |= v && v->by_parameter;
        against_order |= v && v->weighted && v->aic < -2;
    }
    if (by_parameter) fputs("w: z of the parameter that the best model has more than this one (Wald's test)\n", out);
    if (against_order)
        fputs(
            "delta AIC below 0: in standard deviations of the data's noise this model is nearer; the rows are ranked by the loss\n",
            out);
}

static void put_legend(const ff_report_fits *r, FILE *out)
{
    int any = 0, tied = 0;
    for (size_t i = 0; i < r->n_fits; i++) any |= any_on_bound(&r->fit[i]);
    for (size_t p = 0; p < r->n_problems && r->trust; p++)
        for (size_t i = p * (r->n_fits / r->n_problems); i < (p + 1) * (r->n_fits / r->n_problems); i++)
            tied |= ff_report_is_tied(r, &r->fit[i], ff_report_best(r, p));
    if (any || tied) fputc('\n', out);
    if (any) fputs("! on its bound\n", out);
    if (tied) fputs("~ cannot be told apart from the best by these data", out);
    if (tied) fputs(is_untested(r, 0) ? "\n" : "; * is the simplest of them\n", out);
    put_measures(r, out);
    for (size_t p = 0; p < r->n_problems && r->trust; p++) {
        const ff_versus *v = ff_report_versus(r, &r->fit[p * (r->n_fits / r->n_problems)]);
        put_no_better(r, p, out);
        if (is_untested(r, p))
            fprintf(out, "no model can be ruled out: that takes 3 incidences at least, found %zu; * is the best\n", v->incidences);
    }
}

/* Warnings are many in a comparison: those of the one that is marked. */
static void put_winner(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_fit_result *f = &r->fit[i];
    char expression[FF_MODEL_NAME];
    ff_model_expression(&f->model, expression, sizeof expression);
    const char *what =
        f == ff_report_best(r, i / (r->n_fits / r->n_problems)) ? "best" : "simplest that is not told apart from the best";
    fprintf(out, "\n* %s: %s, %s\n", what, expression, ff_shape_name((int)f->shape));
    ff_report_fit_warnings(r, i, out);
}

/* The ranking of problem p, the best of it into *best. */
static ff_status put_problem(const ff_report_fits *r, size_t p, size_t *best, FILE *out)
{
    const size_t n = r->n_fits / r->n_problems;
    ranking t;
    ff_status status = ranking_new(r, &t);
    if (status != FF_OK) return status;
    add_problem(&t, p, r->rows);
    *best = t.best[0];
    status = put_ranking(&t, FF_TABLE_TEXT, out);
    if (status == FF_OK && t.n < n) ff_columns_remark(FF_TABLE_TEXT, out, "... and %zu more (--rows 0 shows all)", n - t.n);
    ranking_free(&t);
    return status;
}

ff_status ff_report_compare_text(const ff_report_fits *r, FILE *out)
{
    ff_status status = ff_report_verdict_text(r, out);
    ff_report_selection_text(r, out);
    for (size_t p = 0; p < r->n_problems && status == FF_OK; p++) {
        size_t best = 0;
        fputc('\n', out);
        if (r->n_problems > 1) fprintf(out, "channel %s\n", ff_problem_channel_name(r->problem[p], 0));
        status = put_problem(r, p, &best, out);
        fputc('\n', out);
        if (status == FF_OK) status = put_maskings(r, p, out);
        if (status != FF_OK) break;
        if (r->trust && r->trust[best].has_outliers) ff_report_outliers_text(r, best, out);
        put_winner(r, (size_t)(ff_report_simplest(r, &r->fit[best]) - r->fit), out);
    }
    if (status == FF_OK) put_legend(r, out);
    return status;
}
