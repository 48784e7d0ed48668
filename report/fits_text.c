/* Fits as people read them. */
#include "internal_report.h"
#include "internal_text.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- what was fitted ------------------------------------------------------------------------- */

static const char *plural(size_t n)
{
    return n == 1 ? "" : "s";
}

static void put_count(FILE *out, const char **separator, size_t n, const char *what)
{
    if (n == 0) return;
    fprintf(out, "%s%zu %s", *separator, n, what);
    *separator = ", ";
}

/* "eta held at 0.18:0.42:1.45", of many channels the first ones */
static void put_fixed(const ff_fixed *f, const char *separator, FILE *out)
{
    enum { SHOWN = 4 };
    char key[FF_REPORT_KEY], number[FF_TEXT_NUMBER];
    fprintf(out, "%s%s held at ", separator, ff_report_key(f->name, f->channel, key));
    for (size_t k = 0; k < f->n && k < SHOWN; ++k) fprintf(out, "%s%s", k ? ":" : "", ff_text_number(f->value[k], 6, number));
    if (f->n > SHOWN) fprintf(out, ":... (%zu values)", f->n);
}

/* A line of what was given besides the data. */
static void put_constraints(const ff_constraints *c, FILE *out)
{
    char a[FF_TEXT_NUMBER], b[FF_TEXT_NUMBER], key[FF_REPORT_KEY];
    const char *separator = "given: ";
    if (!c) return;
    for (size_t i = 0; i < c->n_bounds; ++i, separator = "; ")
        fprintf(out, "%s%s in [%s, %s]", separator, ff_report_key(c->bound[i].name, c->bound[i].channel, key),
                ff_text_number(c->bound[i].lo, 6, a), ff_text_number(c->bound[i].hi, 6, b));
    for (size_t i = 0; i < c->n_priors; ++i, separator = "; ")
        fprintf(out, "%s%s = %s +- %s", separator, ff_report_key(c->prior[i].name, c->prior[i].channel, key),
                ff_text_number(c->prior[i].mean, 6, a), ff_text_number(c->prior[i].sd, 6, b));
    for (size_t i = 0; i < c->n_ties; ++i, separator = "; ")
        fprintf(out, "%s%s %s%s", separator, c->tie[i].name, c->tie[i].to ? "= " : "the same in all channels",
                c->tie[i].to ? c->tie[i].to : "");
    for (size_t i = 0; i < c->n_fixed; ++i, separator = "; ") put_fixed(&c->fixed[i], separator, out);
    if (c->energy_conserving) fprintf(out, "%senergy is conserved", separator), separator = "; ";
    if (*separator == ';') fputc('\n', out);
}

static void put_selection(const ff_report_fits *r, FILE *out)
{
    char number[FF_TEXT_NUMBER], grazing[FF_TEXT_NUMBER + 32];
    const char *separator = "; left out: ";
    ff_selection s;
    ff_problem_selection(r->problem[0], &s);
    fprintf(out, "%s: %s, %zu sample%s, %zu used", r->path, r->table->format, s.samples, plural(s.samples), s.used);
    snprintf(grazing, sizeof grazing, "beyond %s degrees", ff_text_number(ff_report_degrees(r->options->max_theta), 6, number));
    put_count(out, &separator, s.invalid, "invalid");
    put_count(out, &separator, s.below_horizon, "below the horizon");
    put_count(out, &separator, s.grazing, grazing);
    put_count(out, &separator, s.dropped, "negative");
    fputc('\n', out);
    fprintf(out, "loss %s%s, weights by %s", ff_loss_name((int)r->options->loss), r->adaptive ? " (chosen)" : "",
            ff_weighting_name((int)s.weighting));
    if (r->options->robust != FF_ROBUST_NONE)
        fprintf(out, ", robust %s at %s", ff_robust_name((int)r->options->robust),
                r->options->robust_scale > 0 ? ff_text_number(r->options->robust_scale, 6, number)
                                             : "the spread of the residuals about each magnitude");
    if (s.saturated > 0) fprintf(out, "; %zu saturated value%s", s.saturated, plural(s.saturated));
    if (s.below_noise > 0) fprintf(out, "; %zu value%s below the noise floor", s.below_noise, plural(s.below_noise));
    if (s.negative > 0) fprintf(out, "; %zu used sample%s with a negative value (kept as noise)", s.negative, plural(s.negative));
    fputc('\n', out);
    put_constraints(r->options->constraints, out);
}

/* "channel r: " where every channel has its own fit. */
static void put_problem(const ff_report_fits *r, size_t p, FILE *out)
{
    if (r->n_problems > 1) fprintf(out, "channel %s: ", ff_problem_channel_name(r->problem[p], 0));
}

/* ---- fit ------------------------------------------------------------------------------------- */

/* What it follows, where it lies, or what was known before. */
static const char *value_note(const ff_problem *p, const ff_fit_result *f, const ff_fit_value *v, char out[FF_TEXT_CELL])
{
    char name[FF_REPORT_NAME], mean[FF_TEXT_NUMBER], sd[FF_TEXT_NUMBER];
    if (v->tied) {
        const char *followed = v->follows.kind == FF_PARAM_SHAPE
                                   ? f->model.shape[v->follows.index].name
                                   : ff_report_channel_param(p, f, v->follows.index, v->follows_channel, name);
        snprintf(out, FF_TEXT_CELL, "= %s", followed);
        return out;
    }
    if (v->at_bound) return v->at_bound < 0 ? "on its lower bound" : "on its upper bound";
    if (v->held) return "held";
    if (isnan(v->prior_sd)) return "";
    snprintf(out, FF_TEXT_CELL, "prior %s +- %s", ff_text_number(v->prior_mean, 6, mean), ff_text_number(v->prior_sd, 6, sd));
    return out;
}

/* "0.19 to 0.21", with the digits that its width deserves; "-" where there is none. */
static const char *interval_cell(const ff_fit_value *v, char out[2 * FF_TEXT_NUMBER])
{
    char low[FF_TEXT_NUMBER], high[FF_TEXT_NUMBER], rest[FF_TEXT_NUMBER];
    if (v->interval == FF_INTERVAL_NONE || v->tied) return strcpy(out, "-");
    const double width = v->high > v->low ? 0.25 * (v->high - v->low) : NAN;
    ff_text_with_error(v->low, width, low, rest);
    ff_text_with_error(v->high, width, high, rest);
    snprintf(out, 2 * FF_TEXT_NUMBER, "%.40s to %.40s", low, high);
    return out;
}

static void put_value(ff_text_table *t, const char *name, const ff_problem *p, const ff_fit_result *f, const ff_fit_value *v,
                      const ff_param *info)
{
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER], interval[2 * FF_TEXT_NUMBER], note[FF_TEXT_CELL];
    ff_text_with_error(v->value, v->held || v->at_bound ? NAN : v->std_error, value, error);
    if (v->tied) strcpy(error, "-");
    ff_text_row(t);
    ff_text_cell(t, "%s", name);
    ff_text_cell(t, "%s", value);
    ff_text_cell(t, "%s", error);
    ff_text_cell(t, "%s", interval_cell(v, interval));
    ff_text_cell(t, "%s", info->unit);
    ff_text_cell(t, "%s", value_note(p, f, v, note));
}

static void head_row(ff_text_table *t, const char *const *names, size_t n)
{
    ff_text_row(t);
    for (size_t i = 0; i < n; ++i) ff_text_cell(t, "%s", names[i]);
}

/* Is it held where it always is unless someone asks: the mean slope, the scale of a lobe? */
static int is_left_alone(const ff_fit_value *v, const ff_param *info)
{
    return v->held && (info->flags & FF_PARAM_HELD) && v->value == info->init;
}

/* Are all channels' values of parameter k left alone? */
static int all_left_alone(const ff_fit_result *f, uint32_t k)
{
    int all = 1;
    for (size_t c = 0; c < f->n_channels; ++c)
        all &= is_left_alone(&f->channel_value[c * f->model.n_channel + k], f->model.channel[k].info);
    return all;
}

/* One row per channel: its name, value and error of every parameter, and what is to be said of them. */
static ff_status put_channels(const ff_problem *p, const ff_fit_result *f, FILE *out)
{
    ff_text_table t = {.right = {0}};
    size_t column = 1;
    ff_text_row(&t);
    ff_text_cell(&t, "channel");
    for (uint32_t k = 0; k < f->model.n_channel; ++k) {
        if (all_left_alone(f, k)) continue;
        t.right[column] = t.right[column + 1] = 1;
        column += 2;
        ff_text_cell(&t, "%s", f->model.channel[k].name);
        ff_text_cell(&t, "std error");
    }
    for (size_t c = 0; c < f->n_channels; ++c) {
        char note[FF_TEXT_CELL] = "", value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER], is_text[FF_TEXT_CELL];
        size_t at = 0;
        ff_text_row(&t);
        ff_text_cell(&t, "%s", ff_problem_channel_name(p, c));
        for (uint32_t k = 0; k < f->model.n_channel; ++k) {
            const ff_fit_value *v = &f->channel_value[c * f->model.n_channel + k];
            const char *is = value_note(p, f, v, is_text);
            if (all_left_alone(f, k)) continue;
            ff_text_with_error(v->value, v->held || v->at_bound ? NAN : v->std_error, value, error);
            ff_text_cell(&t, "%s", value);
            ff_text_cell(&t, "%s", error);
            if (is[0] && at < sizeof note)
                at += (size_t)snprintf(note + at, sizeof note - at, "%s%s %s", at ? ", " : "", f->model.channel[k].name, is);
        }
        ff_text_cell(&t, "%s", note);
    }
    return ff_text_print(&t, out, "  ");
}

/* Is the table of channels the better one: are they many, and does it hold all their parameters? */
static int has_channel_table(const ff_fit_result *f)
{
    size_t shown = 0;
    for (uint32_t k = 0; k < f->model.n_channel; ++k) shown += !all_left_alone(f, k);
    return f->n_channels > FF_REPORT_CHANNELS && shown > 0 && 2 * shown + 2 <= FF_TEXT_COLUMNS;
}

static ff_status put_parameters(const ff_problem *p, const ff_fit_result *f, FILE *out)
{
    static const char *const head[] = {"parameter", "value", "std error", "95 % interval", "unit", ""};
    ff_text_table t = {.right = {0, 1, 1, 1}};
    char name[FF_REPORT_NAME];
    const int apart = has_channel_table(f);
    head_row(&t, head, 6);
    for (uint32_t k = 0; k < f->model.n_shape; ++k) {
        const ff_fit_value *v = &f->shape_value[k];
        const ff_param *info = f->model.shape[k].info;
        if (is_left_alone(v, info)) continue;
        put_value(&t, f->model.shape[k].name, p, f, v, info);
    }
    for (uint32_t k = 0; k < f->model.n_channel && !apart; ++k)
        for (size_t c = 0; c < f->n_channels; ++c) {
            const ff_fit_value *v = &f->channel_value[c * f->model.n_channel + k];
            const ff_param *info = f->model.channel[k].info;
            if (!is_left_alone(v, info)) put_value(&t, ff_report_channel_param(p, f, k, c, name), p, f, v, info);
        }
    const ff_status status = ff_text_print(&t, out, "  ");
    if (status != FF_OK || !apart) return status;
    fputc('\n', out);
    return put_channels(p, f, out);
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

static void residual_row(ff_text_table *t, const char *name, const char *value, const char *unit)
{
    ff_text_row(t);
    ff_text_cell(t, "%s", name);
    ff_text_cell(t, "%s", value);
    ff_text_cell(t, "%s", unit);
}

static ff_status put_residual(const ff_fit_result *f, FILE *out)
{
    static const char *const head[] = {"residual", "value", "unit"};
    char n[FF_TEXT_NUMBER];
    ff_text_table t = {.right = {0, 1}};
    head_row(&t, head, 3);
    residual_row(&t, "objective", ff_text_number(f->residual.objective, 5, n), "");
    residual_row(&t, "rmse", ff_text_number(f->residual.rmse, 5, n), "1/sr");
    for (int loss = 0; loss < FF_LOSS_COUNT; ++loss) {
        char name[FF_TEXT_CELL];
        if (!ff_loss_at(loss)->rmse_unit) continue;
        snprintf(name, sizeof name, "%s rmse", ff_loss_name(loss));
        residual_row(&t, name, ff_text_number(f->residual.loss_rmse[loss], 5, n), ff_loss_at(loss)->rmse_unit);
    }
    residual_row(&t, "largest", ff_text_number(f->residual.max_abs, 5, n), "1/sr");
    residual_row(&t, "AIC", ff_text_fixed(f->aic, 1, n), "");
    residual_row(&t, "BIC", ff_text_fixed(f->bic, 1, n), "");
    return ff_text_print(&t, out, "  ");
}

static void put_warnings(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_words_subject subject = {.problem = r->problem[i / (r->n_fits / r->n_problems)], .fit = &r->fit[i]};
    ff_report_warnings_text(&subject, &r->fit[i].warnings, out);
}

static ff_status put_fit(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_fit_result *f = &r->fit[i];
    const size_t p = i / (r->n_fits / r->n_problems);
    char expression[FF_MODEL_NAME], time[FF_TEXT_NUMBER];
    ff_model_expression(&f->model, expression, sizeof expression);
    fputc('\n', out);
    put_problem(r, p, out);
    fprintf(out, "%s, %s: %s after %d iteration%s, %d pass%s, %s s\n\n", expression, ff_shape_name((int)f->shape),
            ff_outcome_name((int)f->outcome), f->iterations, plural((size_t)f->iterations), f->passes, f->passes == 1 ? "" : "es",
            ff_text_number(f->time_s, 2, time));
    ff_status status = put_parameters(r->problem[p], f, out);
    put_ellipse(f, out);
    fputc('\n', out);
    if (status == FF_OK) status = put_residual(f, out);
    ff_report_trust_of_fit(r, i, out);
    if (f->warnings.n > 0) fputc('\n', out);
    put_warnings(r, i, out);
    return status;
}

static void put_difference(const ff_difference *d, FILE *out)
{
    char p[FF_TEXT_NUMBER], chi2[FF_TEXT_NUMBER];
    if (d->dof == 0) return;
    fprintf(out, "\nthe channels' shapes %s: chi^2 %s with %zu degrees of freedom, p = %s\n",
            d->p < 0.05 ? "differ by more than their errors" : "do not differ by more than their errors",
            ff_text_number(d->chi2, 3, chi2), d->dof, ff_text_number(d->p, 2, p));
}
static ff_status put_candidates(const ff_adaptive *a, FILE *out);

ff_status ff_report_fit_text(const ff_report_fits *r, FILE *out)
{
    ff_status status = FF_OK;
    put_selection(r, out);
    if (r->adaptive) status = put_candidates(r->adaptive, out);
    for (size_t i = 0; i < r->n_fits && status == FF_OK; ++i) status = put_fit(r, i, out);
    if (r->difference) put_difference(r->difference, out);
    return status;
}

/* ---- compare --------------------------------------------------------------------------------- */

/* Free shape parameters: the roughness by its numbers alone, everything else as name=value. "0.2", "0.2/0.45 r=0.4 gamma=2.1" */
static void shape_cell(const ff_fit_result *f, char *out, size_t size)
{
    size_t at = 0;
    out[0] = '\0';
    for (uint32_t k = 0; k < f->model.n_shape; ++k) {
        const ff_fit_value *v = &f->shape_value[k];
        const char *name = f->model.shape[k].name;
        char number[FF_TEXT_NUMBER], label[FF_PARAM_NAME + 2];
        if (v->tied || v->held || at >= size) continue;
        snprintf(label, sizeof label, "%s%s=", at ? " " : "", strcmp(name, "r_xy") ? name : "r");
        if (!strcmp(name, "alpha_x") || !strcmp(name, "alpha")) label[0] = '\0';
        if (!strcmp(name, "alpha_y")) strcpy(label, "/");
        at += (size_t)snprintf(out + at, size - at, "%s%s%s", label, ff_text_number(v->value, 4, number), v->at_bound ? "!" : "");
    }
}

/* One number per channel, "0.91/0.62/0.31"; '!' marks one on its bound. Of many channels the range, "0.31..0.91". */
static void channel_cell(const ff_fit_result *f, uint32_t k, char *out, size_t size)
{
    size_t at = 0;
    int bounds = 0;
    double lowest = INFINITY, highest = -INFINITY;
    char number[FF_TEXT_NUMBER], other[FF_TEXT_NUMBER];
    out[0] = '\0';
    for (size_t c = 0; c < f->n_channels && at < size; ++c) {
        const ff_fit_value *v = &f->channel_value[c * f->model.n_channel + k];
        lowest = fmin(lowest, v->value);
        highest = fmax(highest, v->value);
        bounds |= v->at_bound != 0;
        if (f->n_channels <= FF_REPORT_CHANNELS)
            at += (size_t)snprintf(out + at, size - at, "%s%s%s", c ? "/" : "", ff_text_number(v->value, 3, number),
                                   v->at_bound ? "!" : "");
    }
    if (f->n_channels > FF_REPORT_CHANNELS)
        snprintf(out, size, "%s..%s%s", ff_text_number(lowest, 3, number), ff_text_number(highest, 3, other), bounds ? "!" : "");
}

/* The free channel parameters of the lobes, or of what is under them; each with its name but a lone one called `lone`. */
static void channel_cells(const ff_fit_result *f, int of_lobes, const char *lone, char *out, size_t size)
{
    size_t at = 0;
    snprintf(out, size, "-");
    for (uint32_t k = 0; k < f->model.n_channel && at < size; ++k) {
        const ff_model_param *p = &f->model.channel[k];
        char cell[FF_TEXT_CELL];
        if ((p->lobe < f->model.n_lobes) != of_lobes || ff_report_all_held(f, k)) continue;
        channel_cell(f, k, cell, sizeof cell);
        if (strcmp(p->name, lone))
            at += (size_t)snprintf(out + at, size - at, "%s%s=%s", at ? " " : "", p->name, cell);
        else
            at += (size_t)snprintf(out + at, size - at, "%s%s", at ? " " : "", cell);
    }
}

static const char *masking_name(const ff_fit_result *f)
{
    return ff_term_at(FF_MASKING, (size_t)f->model.lobe[0].masking)->name;
}

static const char *ndf_name(const ff_fit_result *f)
{
    return ff_term_at(FF_NDF, (size_t)f->model.lobe[0].ndf)->name;
}

static void base_names(const ff_model *m, char *out, size_t size)
{
    size_t at = 0;
    snprintf(out, size, "-");
    for (uint32_t b = 0; b < m->n_bases && at < size; ++b)
        at += (size_t)snprintf(out + at, size - at, "%s%s", b ? "+" : "", ff_term_at(FF_DIFFUSE, (size_t)m->base[b].diffuse)->name);
}

/* Which columns a comparison needs: those in which its models differ. */
typedef struct several {
    int fresnels, bases;
} several;

static several several_of(const ff_report_fits *r)
{
    several s = {0, 0};
    char first[FF_MODEL_NAME], other[FF_MODEL_NAME];
    base_names(&r->fit[0].model, first, sizeof first);
    for (size_t i = 1; i < r->n_fits; ++i) {
        s.fresnels |= r->fit[i].model.lobe[0].fresnel != r->fit[0].model.lobe[0].fresnel;
        base_names(&r->fit[i].model, other, sizeof other);
        s.bases |= strcmp(first, other) != 0;
    }
    return s;
}

static const ff_versus *versus_of(const ff_report_fits *r, const ff_fit_result *f)
{
    const ff_report_trust *t = r->trust ? &r->trust[f - r->fit] : NULL;
    return t && t->has_versus ? &t->versus : NULL;
}

static int is_tied(const ff_report_fits *r, const ff_fit_result *f, const ff_fit_result *best)
{
    const ff_versus *v = versus_of(r, f);
    return v && f != best && !v->told_apart;
}

/* "3.1 +- 0.4" */
static const char *validation_cell(const ff_versus *v, char *out)
{
    char value[FF_TEXT_NUMBER], error[FF_TEXT_NUMBER];
    ff_text_with_error(v->validation, v->validation_error, value, error);
    snprintf(out, FF_TEXT_CELL, "%s +- %s", value, error);
    return out;
}

static void compare_row(ff_text_table *t, const ff_report_fits *r, const ff_fit_result *f, const ff_fit_result *best,
                        double aic_best, several columns)
{
    char cell[FF_TEXT_CELL], n[FF_TEXT_NUMBER];
    ff_text_row(t);
    ff_text_cell(t, "%s", f == best ? "*" : is_tied(r, f, best) ? "~" : "");
    ff_text_cell(t, "%s", ndf_name(f));
    ff_text_cell(t, "%s", masking_name(f));
    if (columns.fresnels) ff_text_cell(t, "%s", ff_term_at(FF_FRESNEL, (size_t)f->model.lobe[0].fresnel)->name);
    base_names(&f->model, cell, sizeof cell);
    if (columns.bases) ff_text_cell(t, "%s", cell);
    shape_cell(f, cell, sizeof cell);
    ff_text_cell(t, "%s", cell);
    channel_cells(f, 1, "f0", cell, sizeof cell);
    ff_text_cell(t, "%s", cell);
    channel_cells(f, 0, "kd", cell, sizeof cell);
    ff_text_cell(t, "%s", cell);
    ff_text_cell(t, "%s", ff_text_number(f->residual.objective, 5, n));
    ff_text_cell(t, "%s", ff_text_number(f->residual.rmse, 4, n));
    ff_text_cell(t, "%s", ff_text_number(f->residual.cosine_rmse, 4, n));
    ff_text_cell(t, "%s", ff_text_number(f->residual.log_rmse, 4, n));
    const ff_versus *v = versus_of(r, f);
    ff_text_cell(t, "%s", ff_text_fixed(v ? v->aic : f->aic - aic_best, 1, n));
    if (v) ff_text_cell(t, "%s", f == best ? "" : ff_text_number(v->vuong_z, 3, n));
    if (r->folds) ff_text_cell(t, "%s", f == best ? "" : validation_cell(v, cell));
    ff_text_cell(t, "%s", f->outcome == FF_CONVERGED ? "" : ff_outcome_name((int)f->outcome));
}

static ff_status put_rows(const ff_report_fits *r, const size_t *rank, size_t n, FILE *out)
{
    const several columns = several_of(r);
    const ff_fit_result *best = &r->fit[rank[0]];
    double aic_best = INFINITY;
    ff_text_table t = {.columns = 0};
    ff_text_row(&t);
    ff_text_cell(&t, "%s", "");
    ff_text_cell(&t, "distribution");
    ff_text_cell(&t, "masking");
    if (columns.fresnels) ff_text_cell(&t, "fresnel");
    if (columns.bases) ff_text_cell(&t, "diffuse");
    ff_text_cell(&t, "alpha");
    ff_text_cell(&t, "f0");
    ff_text_cell(&t, "kd");
    ff_text_cell(&t, "objective");
    ff_text_cell(&t, "rmse");
    ff_text_cell(&t, "cosine rmse");
    ff_text_cell(&t, "log rmse");
    ff_text_cell(&t, "delta AIC");
    if (versus_of(r, best)) ff_text_cell(&t, "Vuong z");
    if (r->folds) ff_text_cell(&t, "held out");
    const size_t first = 6 + (size_t)columns.fresnels + (size_t)columns.bases;
    for (size_t c = first; c < first + 7; ++c) t.right[c] = 1;
    for (size_t i = 0; i < n; ++i) aic_best = fmin(aic_best, r->fit[rank[i]].aic);
    const size_t shown = r->rows && r->rows < n ? r->rows : n;
    for (size_t i = 0; i < shown; ++i) compare_row(&t, r, &r->fit[rank[i]], best, aic_best, columns);
    const ff_status status = ff_text_print(&t, out, "");
    if (shown < n) fprintf(out, "   ... and %zu more (--rows 0 shows all)\n", n - shown);
    return status;
}

/* The best fit of every masking, by rank, its objective relative to the winner's. */
static ff_status put_maskings(const ff_report_fits *r, const size_t *rank, size_t n, FILE *out)
{
    const double best = r->fit[rank[0]].residual.objective;
    ff_text_table t = {.right = {0, 1}};
    ff_text_row(&t);
    ff_text_cell(&t, "by masking");
    ff_text_cell(&t, "objective / best");
    ff_text_cell(&t, "with");
    for (size_t i = 0; i < n; ++i) {
        const ff_fit_result *f = &r->fit[rank[i]];
        char number[FF_TEXT_NUMBER];
        int seen = 0;
        for (size_t k = 0; k < i; ++k) seen |= r->fit[rank[k]].model.lobe[0].masking == f->model.lobe[0].masking;
        if (seen) continue;
        ff_text_row(&t);
        ff_text_cell(&t, "%s", masking_name(f));
        ff_text_cell(&t, "%s", f->residual.objective == best ? "1" : ff_text_number(f->residual.objective / best, 5, number));
        ff_text_cell(&t, "%s", ndf_name(f));
    }
    return ff_text_print(&t, out, "");
}

static int any_on_bound(const ff_fit_result *f)
{
    int any = 0;
    for (uint32_t k = 0; k < f->model.n_shape; ++k) any |= f->shape_value[k].at_bound;
    for (size_t k = 0; k < f->n_channels * f->model.n_channel; ++k) any |= f->channel_value[k].at_bound;
    return any;
}

static void put_legend(const ff_report_fits *r, FILE *out)
{
    int any = 0, tied = 0;
    for (size_t i = 0; i < r->n_fits; ++i) any |= any_on_bound(&r->fit[i]);
    for (size_t p = 0; p < r->n_problems && r->trust; ++p) {
        size_t best = p * (r->n_fits / r->n_problems);
        for (size_t i = best; i < (p + 1) * (r->n_fits / r->n_problems); ++i)
            if (r->fit[i].residual.objective < r->fit[best].residual.objective) best = i;
        for (size_t i = p * (r->n_fits / r->n_problems); i < (p + 1) * (r->n_fits / r->n_problems); ++i)
            tied |= is_tied(r, &r->fit[i], &r->fit[best]);
    }
    if (any || tied) fputc('\n', out);
    if (any) fputs("! on its bound\n", out);
    if (tied) fputs("~ cannot be told apart from the best by these data\n", out);
}

/* The best fit of every masking, and what its residuals look like by angle. */
static ff_status put_bands(const ff_report_fits *r, const size_t *rank, size_t n, FILE *out)
{
    size_t *row = malloc((n ? n : 1) * sizeof *row), rows = 0;
    if (!row) return FF_ERR_MEMORY;
    for (size_t i = 0; i < n; ++i) {
        int seen = 0;
        for (size_t k = 0; k < i; ++k) seen |= r->fit[rank[k]].model.lobe[0].masking == r->fit[rank[i]].model.lobe[0].masking;
        if (!seen) row[rows++] = rank[i];
    }
    const ff_status status = ff_report_bands_text(r, row, rows, out);
    free(row);
    return status;
}

/* Warnings are many in a comparison: those of the winner. */
static void put_winner(const ff_report_fits *r, size_t i, FILE *out)
{
    const ff_fit_result *f = &r->fit[i];
    char expression[FF_MODEL_NAME];
    ff_model_expression(&f->model, expression, sizeof expression);
    fprintf(out, "\n* best: %s, %s\n", expression, ff_shape_name((int)f->shape));
    put_warnings(r, i, out);
}

ff_status ff_report_compare_text(const ff_report_fits *r, FILE *out)
{
    const size_t n = r->n_fits / r->n_problems;
    size_t *rank = malloc((n ? n : 1) * sizeof *rank);
    ff_status status = rank ? FF_OK : FF_ERR_MEMORY;
    put_selection(r, out);
    for (size_t p = 0; p < r->n_problems && status == FF_OK; ++p) {
        ff_report_rank(r, p, rank);
        fputc('\n', out);
        if (r->n_problems > 1) fprintf(out, "channel %s\n", ff_problem_channel_name(r->problem[p], 0));
        status = put_rows(r, rank, n, out);
        fputc('\n', out);
        if (status == FF_OK) status = put_maskings(r, rank, n, out);
        if (status == FF_OK && r->trust) status = put_bands(r, rank, n, out);
        if (r->trust && r->trust[rank[0]].has_outliers) ff_report_outliers_text(r, rank[0], out);
        put_winner(r, rank[0], out);
    }
    if (status == FF_OK) put_legend(r, out);
    free(rank);
    return status;
}

/* ---- how --loss auto chose ------------------------------------------------------------------- */

static void candidate_row(ff_text_table *t, const ff_adaptive_candidate *c, int chosen)
{
    char cell[FF_TEXT_CELL], n[FF_TEXT_NUMBER];
    ff_text_row(t);
    ff_text_cell(t, "%s", chosen ? "*" : "");
    ff_text_cell(t, "%s", ff_loss_name((int)c->loss));
    ff_text_cell(t, "%s", ff_text_number(c->difference, 4, n));
    shape_cell(&c->fit, cell, sizeof cell);
    ff_text_cell(t, "%s", cell);
    channel_cells(&c->fit, 1, "f0", cell, sizeof cell);
    ff_text_cell(t, "%s", cell);
    channel_cells(&c->fit, 0, "kd", cell, sizeof cell);
    ff_text_cell(t, "%s", cell);
    ff_text_cell(t, "%s", c->fit.outcome == FF_CONVERGED ? "" : ff_outcome_name((int)c->fit.outcome));
}

static ff_status put_candidates(const ff_adaptive *a, FILE *out)
{
    static const char *const head[] = {"", "loss", "picture difference", "alpha", "f0", "kd", ""};
    ff_text_table t = {.right = {0, 0, 1}};
    head_row(&t, head, 7);
    for (size_t k = 0; k < a->n; ++k) candidate_row(&t, &a->candidate[k], k == a->chosen);
    fputc('\n', out);
    const ff_status status = ff_text_print(&t, out, "");
    fprintf(out, "* chosen: its pictures of a lit sphere are nearest to the data's, which cover %zu of %zu pixels\n",
            a->coverage.measured, a->coverage.pixels);
    return status;
}
