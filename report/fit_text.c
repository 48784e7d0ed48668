/* A fit as people read it, and its parameters as a table. */
#include "internal_controls_report.h"
#include "internal_fits_text.h"
#include "internal_verdict.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- parameters ------------------------------------------------------------------------------ */

/* A row: parameter k of fit i, of channel c if it has one for each. */
typedef struct parameter {
    size_t fit, c;
    uint32_t k;
    int of_channel;
} parameter;

typedef struct parameters {
    const ff_report_fits *r;
    size_t n;
    parameter *row; /* [n] */
    int together;   /* 1: those of all fits in one table */
} parameters;

static const ff_fit_result *fit_of(const parameters *t, size_t row)
{
    return &t->r->fit[t->row[row].fit];
}

static const ff_fit_value *value_of(const parameters *t, size_t row)
{
    const parameter *p = &t->row[row];
    const ff_fit_result *f = fit_of(t, row);
    return p->of_channel ? &f->channel_value[p->c * f->model.n_channel + p->k] : &f->shape_value[p->k];
}

static const ff_model_param *param_of(const parameters *t, size_t row)
{
    const parameter *p = &t->row[row];
    return p->of_channel ? &fit_of(t, row)->model.channel[p->k] : &fit_of(t, row)->model.shape[p->k];
}

static void add_row(parameters *t, size_t i, int of_channel, uint32_t k, size_t c)
{
    t->row[t->n] = (parameter){.fit = i, .c = c, .k = k, .of_channel = of_channel};
    if (!ff_report_left_alone(value_of(t, t->n), param_of(t, t->n)->info)) t->n++;
}

static void add_shape(parameters *t, size_t i)
{
    for (uint32_t k = 0; k < t->r->fit[i].model.n_shape; k++) add_row(t, i, 0, k, 0);
}

static void add_channels(parameters *t, size_t i)
{
    for (uint32_t k = 0; k < t->r->fit[i].model.n_channel; k++)
        for (size_t c = 0; c < t->r->fit[i].n_channels; c++) add_row(t, i, 1, k, c);
}

/* Room for the parameters of n fits from fit i on. */
static ff_status parameters_new(const ff_report_fits *r, size_t i, size_t n, parameters *t)
{
    size_t most = 1;
    for (size_t k = i; k < i + n; k++) most += r->fit[k].model.n_shape + r->fit[k].n_channels * r->fit[k].model.n_channel;
    *t = (parameters){.r = r, .row = malloc(most * sizeof *t->row)};
    return t->row ? FF_OK : FF_ERR_MEMORY;
}

/* What it follows, where it lies, or what was known before. */
static const char *value_note(const ff_problem *p, const ff_fit_result *f, const ff_fit_value *v, char out[FF_CELL])
{
    char name[FF_REPORT_NAME], mean[FF_TEXT_NUMBER], sd[FF_TEXT_NUMBER];
    if (v->tied) {
        const char *followed = v->follows.kind == FF_PARAM_SHAPE
                                   ? f->model.shape[v->follows.index].name
                                   : ff_report_channel_param(p, f, v->follows.index, v->follows_channel, name);
        snprintf(out, FF_CELL, "= %s", followed);
        return out;
    }
    if (v->weightless) return "not determined";
    if (v->at_bound) return v->at_bound < 0 ? "on its lower bound" : "on its upper bound";
    if (v->held) return "held";
    if (isnan(v->prior_sd)) return "";
    snprintf(out, FF_CELL, "prior %s +- %s", ff_text_number(v->prior_mean, 6, mean), ff_text_number(v->prior_sd, 6, sd));
    return out;
}

/* What is to be said of a row, "" = nothing. */
static const char *note_of(const parameters *t, size_t row, char out[FF_CELL])
{
    return value_note(ff_report_problem_of(t->r, t->row[row].fit), fit_of(t, row), value_of(t, row), out);
}

static double error_of(const ff_fit_value *v)
{
    return v->tied || v->held || v->at_bound ? NAN : v->std_error;
}

static int of_several(const void *of)
{
    const parameters *t = of;
    return t->together && t->r->n_problems > 1;
}

static void problem_cell(ff_cell *out, ff_where w)
{
    const parameters *t = w.of;
    ff_cell_text(out, "%s", ff_problem_channel_name(ff_report_problem_of(t->r, t->row[w.row].fit), 0));
}

/* "f0[r]" */
static void label_cell(ff_cell *out, ff_where w)
{
    const parameters *t = w.of;
    const parameter *p = &t->row[w.row];
    char name[FF_REPORT_NAME];
    ff_cell_text(out, "%s",
                 p->of_channel ? ff_report_channel_param(ff_report_problem_of(t->r, p->fit), fit_of(t, w.row), p->k, p->c, name)
                               : param_of(t, w.row)->name);
}

static void name_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", param_of(w.of, w.row)->name);
}

static void channel_name_cell(ff_cell *out, ff_where w)
{
    const parameters *t = w.of;
    const parameter *p = &t->row[w.row];
    if (p->of_channel) ff_cell_text(out, "%s", ff_problem_channel_name(ff_report_problem_of(t->r, p->fit), p->c));
}

static void value_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = value_of(w.of, w.row);
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    ff_text_with_error(v->value, v->held || v->at_bound ? NAN : v->std_error, value, error);
    ff_cell_rounded(out, v->value, value);
}

static void error_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = value_of(w.of, w.row);
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    ff_text_with_error(v->value, error_of(v), value, error);
    ff_cell_rounded(out, error_of(v), error);
}

/* "0.19 to 0.21", with the digits that its width deserves; "-" where there is none. */
static const char *interval_cell(const ff_fit_value *v, char out[2 * FF_TEXT_NUMBER])
{
    char low[FF_TEXT_NUMBER], high[FF_TEXT_NUMBER];
    if (v->interval == FF_INTERVAL_NONE || v->tied) return strcpy(out, "-");
    const double width = v->high > v->low ? 0.25 * (v->high - v->low) : NAN;
    snprintf(out, 2 * FF_TEXT_NUMBER, "%.40s to %.40s", ff_text_within(v->low, width, low), ff_text_within(v->high, width, high));
    return out;
}

static void interval_text(ff_cell *out, ff_where w)
{
    char text[2 * FF_TEXT_NUMBER];
    ff_cell_text(out, "%s", interval_cell(value_of(w.of, w.row), text));
}

enum { LOW, HIGH };
static void limit_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = value_of(w.of, w.row);
    if (v->interval != FF_INTERVAL_NONE && !v->tied) ff_cell_exact(out, w.index == LOW ? v->low : v->high);
}

static int has_carriers(const void *of)
{
    const parameters *t = of;
    for (size_t row = 0; row < t->n; row++)
        if (!isnan(value_of(t, row)->carriers)) return 1;
    return 0;
}

/* How many values carry it: 1.6, 24, 5300. */
static void carriers_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = value_of(w.of, w.row);
    char n[FF_TEXT_NUMBER];
    const double shown = v->tied || v->held ? NAN : v->carriers;
    const double unit = shown >= 100 ? pow(10, floor(log10(shown)) - 1) : 1, two = round(shown / unit) * unit; /* digits */
    ff_cell_rounded(out, shown, isnan(shown) ? "-" : shown < 10 ? ff_text_fixed(shown, 1, n) : ff_text_fixed(two, 0, n));
}

static void residual_error_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = value_of(w.of, w.row);
    if (!v->tied && !v->held && !isnan(v->residual_error)) ff_cell_exact(out, v->residual_error);
}

static void unit_cell(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", param_of(w.of, w.row)->info->unit);
}

static void note_cell(ff_cell *out, ff_where w)
{
    char text[FF_CELL];
    ff_cell_text(out, "%s", note_of(w.of, w.row, text));
}

static const ff_column parameter_columns[] = {
    {.head = "channel", .key = "fit", .wanted = of_several, .cell = problem_cell},
    {.head = "parameter", .audience = FF_PEOPLE, .cell = label_cell},
    {.head = "parameter", .audience = FF_PROGRAMS, .cell = name_cell},
    {.head = "channel", .audience = FF_PROGRAMS, .cell = channel_name_cell},
    {.head = "value", .align = FF_RIGHT, .cell = value_cell},
    {.head = "std error", .align = FF_RIGHT, .cell = error_cell},
    {.head = "95 % interval", .align = FF_RIGHT, .audience = FF_PEOPLE, .cell = interval_text},
    {.head = "low", .audience = FF_PROGRAMS, .cell = limit_cell, .index = LOW},
    {.head = "high", .audience = FF_PROGRAMS, .cell = limit_cell, .index = HIGH},
    {.head = "N", .key = "carriers", .align = FF_RIGHT, .wanted = has_carriers, .cell = carriers_cell, .drop = 2},
    {.head = "residual error",
     .key = "residual_error",
     .audience = FF_PROGRAMS,
     .wanted = has_carriers,
     .cell = residual_error_cell},
    {.head = "unit", .cell = unit_cell, .drop = 3},
    {.head = "", .key = "note", .cell = note_cell, .least = 10, .wraps = 1}};

static ff_status put_rows(const parameters *t, ff_table_form form, const char *indent, FILE *out)
{
    return ff_columns_print(parameter_columns, FF_COUNT(parameter_columns), t, t->n, form, indent, t->r->style, out);
}

ff_status ff_report_fit_table(const ff_report_fits *r, ff_table_form form, FILE *out)
{
    parameters t;
    ff_status status = parameters_new(r, 0, r->n_fits, &t);
    if (status != FF_OK) return status;
    t.together = 1;
    for (size_t i = 0; i < r->n_fits; i++) {
        add_shape(&t, i);
        add_channels(&t, i);
    }
    status = put_rows(&t, form, "", out);
    free(t.row);
    return status;
}

/* ---- many channels --------------------------------------------------------------------------- */

typedef struct channels {
    const ff_problem *p;
    const ff_fit_result *f;
    const ff_report_style *style;
} channels;

static const ff_fit_value *channel_value(const channels *t, size_t c, size_t k)
{
    return &t->f->channel_value[c * t->f->model.n_channel + k];
}

static void channel_cell(ff_cell *out, ff_where w)
{
    const channels *t = w.of;
    ff_cell_text(out, "%s", ff_problem_channel_name(t->p, w.row));
}

static void channel_value_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = channel_value(w.of, w.row, w.index);
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    ff_text_with_error(v->value, v->held || v->at_bound ? NAN : v->std_error, value, error);
    ff_cell_rounded(out, v->value, value);
}

static void channel_error_cell(ff_cell *out, ff_where w)
{
    const ff_fit_value *v = channel_value(w.of, w.row, w.index);
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    ff_text_with_error(v->value, v->held || v->at_bound ? NAN : v->std_error, value, error);
    ff_cell_rounded(out, v->std_error, error);
}

static void channel_note_cell(ff_cell *out, ff_where w)
{
    const channels *t = w.of;
    size_t at = 0;
    for (uint32_t k = 0; k < t->f->model.n_channel; k++) {
        char is_text[FF_CELL];
        const char *is = value_note(t->p, t->f, channel_value(t, w.row, k), is_text);
        if (!is[0] || ff_report_all_left_alone(t->f, k) || at >= sizeof out->text) continue;
        at += (size_t)snprintf(out->text + at, sizeof out->text - at, "%s%s %s", at ? ", " : "", t->f->model.channel[k].name, is);
    }
}

/* A row for each channel: its name, value and error of every parameter, and what is to be said of them. */
static ff_status put_channels(const ff_problem *p, const ff_fit_result *f, const ff_report_style *style, FILE *out)
{
    const channels t = {p, f, style};
    ff_column *column = malloc((2 + 2 * (size_t)f->model.n_channel) * sizeof *column);
    size_t n = 0;
    if (!column) return FF_ERR_MEMORY;
    column[n++] = (ff_column){.head = "channel", .cell = channel_cell};
    for (uint32_t k = 0; k < f->model.n_channel; k++) {
        if (ff_report_all_left_alone(f, k)) continue;
        column[n++] = (ff_column){.head = f->model.channel[k].name, .align = FF_RIGHT, .cell = channel_value_cell, .index = k};
        column[n++] = (ff_column){.head = "std error", .align = FF_RIGHT, .cell = channel_error_cell, .index = k, .drop = 1};
    }
    column[n++] = (ff_column){.head = "", .cell = channel_note_cell, .least = 10, .wraps = 1};
    const ff_status status = ff_columns_print(column, n, &t, f->n_channels, FF_TABLE_TEXT, "  ", style, out);
    free(column);
    return status;
}

/* Is a table with a row for each channel the better one? */
static int has_channel_table(const ff_fit_result *f)
{
    size_t shown = 0;
    for (uint32_t k = 0; k < f->model.n_channel; k++) shown += !ff_report_all_left_alone(f, k);
    return f->n_channels > FF_REPORT_CHANNELS && shown > 0;
}

/* ---- a fit ----------------------------------------------------------------------------------- */

static ff_status put_parameters(const ff_report_fits *r, size_t i, FILE *out)
{
    const int apart = has_channel_table(&r->fit[i]);
    parameters t;
    ff_status status = parameters_new(r, i, 1, &t);
    if (status != FF_OK) return status;
    add_shape(&t, i);
    if (!apart) add_channels(&t, i);
    status = put_rows(&t, FF_TABLE_TEXT, "  ", out);
    free(t.row);
    if (status != FF_OK || !apart) return status;
    fputc('\n', out);
    return put_channels(ff_report_problem_of(r, i), &r->fit[i], r->style, out);
}

static void put_ellipse(const ff_fit_result *f, FILE *out)
{
    const ff_ellipse *e = &f->ellipse;
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], phi[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    if (!f->has_ellipse) return;
    fprintf(out, "\n  roughness ellipse: %s along, %s across", ff_text_number(e->alpha_major, 5, a),
            ff_text_number(e->alpha_minor, 5, b));
    if (e->phi_determined) {
        ff_text_with_error(ff_report_degrees(e->phi), ff_report_degrees(e->phi_std_error), phi, error);
        fprintf(out, ", phi = %s +- %s degrees\n", phi, error);
    } else {
        fprintf(out, "; its direction is not determined\n");
    }
}

/* Rows of the residuals: two, the losses that are measures, three. */
enum { LARGEST, AIC, BIC, AFTER };
typedef struct residuals {
    const ff_fit_result *f;
    int loss[FF_LOSS_COUNT];
    size_t n_losses;
} residuals;

static size_t residual_rows(const residuals *t)
{
    return 2 + t->n_losses + AFTER;
}

static void residual_name(ff_cell *out, ff_where w)
{
    static const char *const after[] = {[LARGEST] = "largest", [AIC] = "AIC", [BIC] = "BIC"};
    const residuals *t = w.of;
    if (w.row < 2)
        ff_cell_text(out, "%s", w.row ? "rmse" : "objective");
    else if (w.row - 2 < t->n_losses)
        ff_cell_text(out, "%s rmse", ff_loss_name(t->loss[w.row - 2]));
    else
        ff_cell_text(out, "%s", after[w.row - 2 - t->n_losses]);
}

static void residual_value(ff_cell *out, ff_where w)
{
    const residuals *t = w.of;
    const ff_residual *r = &t->f->residual;
    if (w.row < 2)
        ff_cell_number(out, w.row ? r->rmse : r->objective, 5);
    else if (w.row - 2 < t->n_losses)
        ff_cell_number(out, r->loss_rmse[t->loss[w.row - 2]], 5);
    else if (w.row - 2 - t->n_losses == LARGEST)
        ff_cell_number(out, r->max_abs, 5);
    else
        ff_cell_fixed(out, w.row - 2 - t->n_losses == AIC ? t->f->aic : t->f->bic, 1);
}

static void residual_unit(ff_cell *out, ff_where w)
{
    const residuals *t = w.of;
    if (w.row == 1 || w.row - 2 == t->n_losses + LARGEST)
        ff_cell_text(out, "1/sr");
    else if (w.row >= 2 && w.row - 2 < t->n_losses)
        ff_cell_text(out, "%s", ff_loss_at(t->loss[w.row - 2])->rmse_unit);
}

static const ff_column residual_columns[] = {{.head = "residual", .cell = residual_name},
                                             {.head = "value", .align = FF_RIGHT, .cell = residual_value},
                                             {.head = "unit", .cell = residual_unit}};

static ff_status put_residual(const ff_fit_result *f, const ff_report_style *style, FILE *out)
{
    residuals t = {.f = f};
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        if (ff_loss_at(loss)->rmse_unit) t.loss[t.n_losses++] = loss;
    return ff_columns_print(residual_columns, FF_COUNT(residual_columns), &t, residual_rows(&t), FF_TABLE_TEXT, "  ", style, out);
}

static ff_status put_fit(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_fit_result *f = &r->fit[i];
    char expression[FF_MODEL_NAME], time[FF_TEXT_NUMBER];
    ff_model_expression(&f->model, expression, sizeof expression);
    fputc('\n', out);
    ff_report_problem_text(r, i / (r->n_fits / r->n_problems), out);
    fprintf(out, "%s, %s: %s after %d iteration%s, %d pass%s, %s s\n\n", expression, ff_shape_name((int)f->shape),
            ff_outcome_name((int)f->outcome), f->iterations, ff_report_plural((size_t)f->iterations), f->passes,
            f->passes == 1 ? "" : "es", ff_text_number(f->time_s, 2, time));
    ff_status status = put_parameters(r, i, out);
    put_ellipse(f, out);
    fputc('\n', out);
    if (status == FF_OK) status = put_residual(f, r->style, out);
    if (status == FF_OK && r->target) status = ff_report_controls_text(r, i, out);
    ff_report_trust_of_fit(r, i, out);
    if (status == FF_OK) status = ff_report_budget_text(r, i, out);
    if (f->warnings.n > 0) fputc('\n', out);
    ff_report_fit_warnings(r, i, out);
    return status;
}

static void put_difference(const ff_difference *d, FILE *out)
{
    char p[FF_TEXT_NUMBER], f[FF_TEXT_NUMBER], error_dof[FF_TEXT_NUMBER];
    if (d->dof == 0) return;
    fprintf(out, "\nthe channels' shapes %s: F %s with %zu and %s degrees of freedom, p = %s\n",
            d->p < 0.05 ? "differ by more than their errors" : "do not differ by more than their errors",
            ff_text_number(d->f, 3, f), d->dof, isinf(d->error_dof) ? "any" : ff_text_number(d->error_dof, 3, error_dof),
            ff_text_number(d->p, 2, p));
}
/* ---- how --loss auto chose ------------------------------------------------------------------- */

static const ff_adaptive_candidate *candidate(const void *of, size_t row)
{
    return &((const ff_adaptive *)of)->candidate[row];
}

static void candidate_mark(ff_cell *out, ff_where w)
{
    const ff_adaptive *a = w.of;
    ff_cell_text(out, "%s", w.row == a->chosen ? "*" : "");
}

static void candidate_loss(ff_cell *out, ff_where w)
{
    ff_cell_text(out, "%s", ff_loss_name((int)candidate(w.of, w.row)->loss));
}

static void candidate_difference(ff_cell *out, ff_where w)
{
    ff_cell_number(out, candidate(w.of, w.row)->difference, 4);
}

static void candidate_shape(ff_cell *out, ff_where w)
{
    ff_report_shape_cell(out, &candidate(w.of, w.row)->fit);
}

static void candidate_f0(ff_cell *out, ff_where w)
{
    ff_report_channel_cells(out, &candidate(w.of, w.row)->fit, 1, "f0");
}

static void candidate_kd(ff_cell *out, ff_where w)
{
    ff_report_channel_cells(out, &candidate(w.of, w.row)->fit, 0, "kd");
}

static void candidate_outcome(ff_cell *out, ff_where w)
{
    ff_report_outcome_cell(out, &candidate(w.of, w.row)->fit);
}

static const ff_column candidate_columns[] = {{.head = "", .cell = candidate_mark},
                                              {.head = "loss", .cell = candidate_loss},
                                              {.head = "picture difference", .align = FF_RIGHT, .cell = candidate_difference},
                                              {.head = "alpha", .cell = candidate_shape, .least = 8},
                                              {.head = "f0", .cell = candidate_f0, .least = 8, .drop = 1},
                                              {.head = "kd", .cell = candidate_kd, .least = 8, .drop = 2},
                                              {.head = "", .cell = candidate_outcome}};

static ff_status put_candidates(const ff_adaptive *a, const ff_report_style *style, FILE *out)
{
    fputc('\n', out);
    const ff_status status =
        ff_columns_print(candidate_columns, FF_COUNT(candidate_columns), a, a->n, FF_TABLE_TEXT, "", style, out);
    fprintf(out, "* chosen: its pictures of a lit sphere are nearest to the data's, which cover %zu of %zu pixels\n",
            a->coverage.measured, a->coverage.pixels);
    return status;
}

ff_status ff_report_fit_text(const ff_report_fits *r, FILE *out)
{
    ff_status status = ff_report_verdict_text(r, out);
    ff_report_selection_text(r, out);
    if (r->adaptive && status == FF_OK) status = put_candidates(r->adaptive, r->style, out);
    for (size_t i = 0; i < r->n_fits && status == FF_OK; i++) status = put_fit(r, i, out);
    if (r->difference) put_difference(r->difference, out);
    return status;
}
