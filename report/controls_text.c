/* What a fit for a renderer says: the renderer's own numbers, what it cannot show, and what it lacks. */
#include "internal_controls_report.h"
#include "internal_fits_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- rows: controls by channel, then what has to be set besides ------------------------------ */

typedef struct controls {
    const ff_report_fits *r;
    const ff_report_target *t;
    const ff_problem *p;
    const ff_fit_result *f;
    size_t n;
    struct {
        size_t control, c; /* control: from n_controls on a setting */
    } * row;
    size_t n_controls;
} controls;

static int is_round(const ff_fit_result *f)
{
    return f->shape == FF_SHAPE_ISOTROPIC;
}

size_t ff_report_control_shown(const ff_report_target *t, const ff_fit_result *f, size_t k)
{
    const ff_control *control = &t->material->control[k];
    if (control->is_of_axis && is_round(f)) return 0;
    return control->is_color ? f->n_channels : 1;
}

static ff_status controls_new(const ff_report_fits *r, size_t i, controls *out)
{
    controls t = {.r = r, .t = &r->target[i], .p = ff_report_problem_of(r, i), .f = &r->fit[i]};
    t.n_controls = ff_control_count(t.t->material);
    t.row = malloc((t.n_controls * t.f->n_channels + FF_TARGET_SETTINGS + 1) * sizeof *t.row);
    if (!t.row) return FF_ERR_MEMORY;
    for (size_t k = 0; k < t.n_controls; k++)
        for (size_t c = 0; c < ff_report_control_shown(t.t, t.f, k); c++) {
            t.row[t.n].control = k;
            t.row[t.n++].c = c;
        }
    for (size_t k = 0; k < FF_TARGET_SETTINGS && t.t->material->setting[k].name; k++) {
        t.row[t.n].control = t.n_controls + k;
        t.row[t.n++].c = 0;
    }
    *out = t;
    return FF_OK;
}

static const ff_setting *setting_at(const controls *t, size_t row)
{
    const size_t k = t->row[row].control;
    return k < t->n_controls ? NULL : &t->t->material->setting[k - t->n_controls];
}

static const ff_control *control_at(const controls *t, size_t row)
{
    return &t->t->material->control[t->row[row].control];
}

static ff_control_estimate estimate_at(const controls *t, size_t row)
{
    return ff_control_estimate_of(control_at(t, row), t->f, t->row[row].c);
}

static void name_cell(ff_cell *out, ff_where w)
{
    const controls *t = w.of;
    const ff_setting *setting = setting_at(t, w.row);
    if (setting)
        ff_cell_text(out, "%s", setting->name);
    else if (control_at(t, w.row)->is_color && t->f->n_channels > 1)
        ff_cell_text(out, "%s[%s]", control_at(t, w.row)->made.name, ff_problem_channel_name(t->p, t->row[w.row].c));
    else
        ff_cell_text(out, "%s", control_at(t, w.row)->made.name);
}

static void value_cell(ff_cell *out, ff_where w)
{
    const controls *t = w.of;
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    if (setting_at(t, w.row)) {
        ff_cell_exact(out, setting_at(t, w.row)->value);
        return;
    }
    const ff_control_estimate e = estimate_at(t, w.row);
    ff_text_with_error(e.value, e.std_error, value, error);
    ff_cell_rounded(out, e.value, value);
}

static void error_cell(ff_cell *out, ff_where w)
{
    const controls *t = w.of;
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    if (setting_at(t, w.row)) return;
    const ff_control_estimate e = estimate_at(t, w.row);
    ff_text_with_error(e.value, e.std_error, value, error);
    ff_cell_rounded(out, e.std_error, error);
}

static void interval_cell(ff_cell *out, ff_where w)
{
    const controls *t = w.of;
    char low[FF_TEXT_NUMBER], high[FF_TEXT_NUMBER];
    if (setting_at(t, w.row)) return;
    const ff_control_estimate e = estimate_at(t, w.row);
    if (isnan(e.low)) {
        ff_cell_text(out, "-");
        return;
    }
    const double width = e.high > e.low ? 0.25 * (e.high - e.low) : NAN;
    ff_cell_text(out, "%.40s to %.40s", ff_text_within(e.low, width, low), ff_text_within(e.high, width, high));
}

static void unit_cell(ff_cell *out, ff_where w)
{
    const controls *t = w.of;
    ff_cell_text(out, "%s", setting_at(t, w.row) ? "1" : control_at(t, w.row)->unit);
}

static void note_cell(ff_cell *out, ff_where w)
{
    const controls *t = w.of;
    char end[FF_TEXT_NUMBER];
    if (setting_at(t, w.row)) {
        ff_cell_text(out, "to be set");
        return;
    }
    const ff_control *k = control_at(t, w.row);
    const ff_control_estimate e = estimate_at(t, w.row);
    if (e.beyond)
        ff_cell_text(out, "beyond what the renderer takes, %s", ff_text_number(e.beyond < 0 ? k->lo : k->hi, 6, end));
    else if (e.at_bound)
        ff_cell_text(out, "on its %s bound", e.at_bound < 0 ? "lower" : "upper");
    else if (e.held)
        ff_cell_text(out, "held");
}

static const ff_column control_columns[] = {{.head = "control", .cell = name_cell},
                                            {.head = "value", .align = FF_RIGHT, .cell = value_cell},
                                            {.head = "std error", .align = FF_RIGHT, .cell = error_cell},
                                            {.head = "95 % interval", .align = FF_RIGHT, .cell = interval_cell, .drop = 1},
                                            {.head = "unit", .cell = unit_cell, .drop = 2},
                                            {.head = "", .key = "note", .cell = note_cell, .least = 10, .wraps = 1}};

/* ---- what it cannot show --------------------------------------------------------------------- */

static void put_residual_beside(const ff_fit_result *f, const ff_fit_result *other, FILE *out)
{
    char expression[FF_MODEL_NAME], a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], c[FF_TEXT_NUMBER];
    ff_model_expression(&other->model, expression, sizeof expression);
    fprintf(out, "\n  beside a model that is free, %s: rmse %s against %s 1/sr, objective %s times as large\n", expression,
            ff_text_number(f->residual.rmse, 4, a), ff_text_number(other->residual.rmse, 4, b),
            ff_text_number(f->residual.objective / other->residual.objective, 4, c));
}

static void put_shortfalls(const ff_bands *fit, const ff_bands *other, FILE *out)
{
    enum { MOST = 4 };
    ff_shortfall at[MOST];
    char mean[FF_TEXT_NUMBER], rms[FF_TEXT_NUMBER], free_rms[FF_TEXT_NUMBER];
    const size_t n = ff_shortfalls_find(fit, other, 0.01, MOST, at);
    if (n == 0) {
        fputs("  at no angle is it further from the data by more than 1 % of them\n", out);
        return;
    }
    fputs("  what the renderer cannot show, where its residuals are the larger ones, in % of the data there:\n", out);
    for (size_t i = 0; i < n; i++)
        fprintf(out, "    %s %d to %d degrees: rms %s (free %s), on average %s%s\n", ff_place_name(at[i].place),
                at[i].band * FF_BAND_DEGREES, (at[i].band + 1) * FF_BAND_DEGREES, ff_text_number(100 * at[i].rms, 2, rms),
                ff_text_number(100 * at[i].free_rms, 2, free_rms), at[i].mean > 0 ? "+" : "",
                ff_text_number(100 * at[i].mean, 2, mean));
}

ff_status ff_report_controls_text(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_report_target *t = &r->target[i];
    controls rows;
    ff_status status = controls_new(r, i, &rows);
    if (status != FF_OK) return status;
    fprintf(out, "\n  for %s, %s (%s):\n\n", t->target->title, t->target->version, t->material->title);
    status = ff_columns_print(control_columns, FF_COUNT(control_columns), &rows, rows.n, FF_TABLE_TEXT, "  ", r->style, out);
    free(rows.row);
    if (t->free) put_residual_beside(&r->fit[i], t->free, out);
    if (t->free_bands && r->trust && r->trust[i].has_bands) put_shortfalls(&r->trust[i].bands, t->free_bands, out);
    fprintf(out, "  not in it: %s\n", t->target->lacks);
    if (t->target->rendered)
        fprintf(out, "  the model was compared with the renderer (%s)\n", t->target->rendered);
    else
        fputs("  the model is from its documentation: it was not rendered\n", out);
    return status;
}
