/* FF_SCHEMA_FIT: one document for `fit` and `compare`. */
#include "ff_report.h"
#include "internal_controls_report.h"
#include "internal_fits_text.h"
#include "internal_report.h"
#include "internal_verdict.h"
#include "models/tools/internal_aperture.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const double degrees = 180 / 3.14159265358979323846;

static void put_selection(ff_json *j, const ff_report_fits *r)
{
    ff_selection s;
    ff_problem_selection(r->problem[0], &s);
    ff_json_object(j, "data", FF_JSON_BLOCK);
    ff_json_string(j, "path", r->path);
    ff_json_string(j, "format", r->table->format);
    ff_json_integer(j, "samples", (int64_t)s.samples);
    ff_json_integer(j, "used", (int64_t)s.used);
    ff_json_object(j, "rejected", FF_JSON_LINE);
    ff_json_integer(j, "invalid", (int64_t)s.invalid);
    ff_json_integer(j, "grazing", (int64_t)s.grazing);
    ff_json_integer(j, "below_horizon", (int64_t)s.below_horizon);
    ff_json_integer(j, "negative", (int64_t)s.dropped);
    ff_json_integer(j, "copies", (int64_t)s.copies);
    ff_json_close(j);
    ff_json_integer(j, "negative", (int64_t)s.negative);
    ff_json_integer(j, "saturated_values", (int64_t)s.saturated);
    ff_json_integer(j, "values_below_noise", (int64_t)s.below_noise);
    ff_json_array(j, "channels", FF_JSON_LINE);
    for (size_t p = 0; p < r->n_problems; p++) {
        ff_problem_selection(r->problem[p], &s);
        for (size_t c = 0; c < s.n_channels; c++) ff_json_string(j, NULL, ff_problem_channel_name(r->problem[p], c));
    }
    ff_json_close(j);
    ff_json_bool(j, "isotropic", s.isotropic);
    ff_json_string(j, "weighting", ff_weighting_name((int)s.weighting));
    ff_json_close(j);
}

static void put_candidates(ff_json *j, const ff_adaptive *a);

static void put_aperture(ff_json *j, const ff_aperture *a)
{
    const int disc = a->outline == FF_APERTURE_DISC;
    ff_json_object(j, "aperture", FF_JSON_LINE);
    ff_json_string(j, "outline", disc ? "disc" : "rectangle");
    ff_json_number(j, "half_deg", ff_report_degrees(a->half));
    ff_json_number(j, "across_deg", ff_report_degrees(disc ? a->half : a->across));
    ff_json_number(j, "source_deg", ff_report_degrees(a->source));
    ff_json_close(j);
}

static void put_loss(ff_json *j, const ff_fit_options *o, const ff_adaptive *adaptive)
{
    ff_json_object(j, "loss", adaptive ? FF_JSON_BLOCK : FF_JSON_LINE);
    ff_json_string(j, "name", ff_loss_name((int)o->loss));
    if (o->robust == FF_ROBUST_NONE) {
        ff_json_null(j, "robust");
    } else {
        ff_json_object(j, "robust", FF_JSON_LINE);
        ff_json_string(j, "name", ff_robust_name((int)o->robust));
        if (o->robust_scale > 0)
            ff_json_number(j, "scale", o->robust_scale);
        else
            ff_json_string(j, "scale", o->noise ? "noise-model" : "estimated");
        ff_json_close(j);
    }
    ff_json_number(j, "max_theta_deg", ff_report_degrees(o->max_theta));
    if (o->aperture && ff_aperture_extended(o->aperture)) put_aperture(j, o->aperture);
    if (adaptive) put_candidates(j, adaptive);
    ff_json_close(j);
}

static void put_range(ff_json *j, const char *key, double lo, double hi)
{
    ff_json_array(j, key, FF_JSON_LINE);
    ff_json_number(j, NULL, lo);
    ff_json_number(j, NULL, hi);
    ff_json_close(j);
}

/* null for NaN: there was none. */
static void put_prior(ff_json *j, const char *key, double mean, double sd)
{
    if (isnan(sd)) {
        ff_json_null(j, key);
        return;
    }
    ff_json_object(j, key, FF_JSON_LINE);
    ff_json_number(j, "mean", mean);
    ff_json_number(j, "sd", sd);
    ff_json_close(j);
}

/* What is known of a parameter besides the data; v: its last channel, which follows the first where all have one value. */
static void put_known(ff_json *j, const ff_fit_result *f, const ff_model_param *p, const ff_fit_value *v)
{
    put_range(j, "bounds", p->lo, p->hi);
    put_prior(j, "prior", v->prior_mean, v->prior_sd);
    ff_json_string(j, "tied_to", v->tied ? ff_report_followed(f, v)->name : NULL);
}

/* Values that parameters are held at by channel. */
static void put_fixed(ff_json *j, const ff_constraints *c)
{
    char key[FF_REPORT_KEY];
    ff_json_object(j, "fixed", FF_JSON_LINE);
    for (size_t i = 0; i < c->n_fixed; i++) {
        ff_json_array(j, ff_report_key(c->fixed[i].name, c->fixed[i].channel, key), FF_JSON_LINE);
        for (size_t k = 0; k < c->fixed[i].n; k++) ff_json_number(j, NULL, c->fixed[i].value[k]);
        ff_json_close(j);
    }
    ff_json_close(j);
}

/* null when nothing but the data was given. */
static void put_constraints(ff_json *j, const ff_constraints *c)
{
    char key[FF_REPORT_KEY];
    if (!c || c->n_bounds + c->n_priors + c->n_ties + c->n_fixed + (size_t)(c->energy_conserving != 0) == 0) {
        ff_json_null(j, "constraints");
        return;
    }
    ff_json_object(j, "constraints", FF_JSON_BLOCK);
    ff_json_object(j, "bounds", FF_JSON_LINE);
    for (size_t i = 0; i < c->n_bounds; i++)
        put_range(j, ff_report_key(c->bound[i].name, c->bound[i].channel, key), c->bound[i].lo, c->bound[i].hi);
    ff_json_close(j);
    ff_json_object(j, "priors", FF_JSON_LINE);
    for (size_t i = 0; i < c->n_priors; i++)
        put_prior(j, ff_report_key(c->prior[i].name, c->prior[i].channel, key), c->prior[i].mean, c->prior[i].sd);
    ff_json_close(j);
    ff_json_array(j, "ties", FF_JSON_LINE);
    for (size_t i = 0; i < c->n_ties; i++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        ff_json_string(j, NULL, c->tie[i].name);
        ff_json_string(j, NULL, c->tie[i].to);
        ff_json_close(j);
    }
    ff_json_close(j);
    put_fixed(j, c);
    ff_json_bool(j, "energy_conserving", c->energy_conserving);
    ff_json_close(j);
}

static void put_bound(ff_json *j, const char *key, int at_bound)
{
    ff_json_string(j, key, at_bound < 0 ? "lower" : at_bound > 0 ? "upper" : NULL);
}

/* 95 %, [low, high]; null where there is none */
static void put_interval(ff_json *j, const char *key, const ff_fit_value *v)
{
    if (v->interval == FF_INTERVAL_NONE) {
        ff_json_null(j, key);
        return;
    }
    ff_json_array(j, key, FF_JSON_LINE);
    ff_json_number(j, NULL, v->low);
    ff_json_number(j, NULL, v->high);
    ff_json_close(j);
}

static void put_shape(ff_json *j, const ff_fit_result *f)
{
    for (uint32_t k = 0; k < f->model.n_shape; k++) {
        const ff_fit_value *v = &f->shape_value[k];
        ff_json_object(j, f->model.shape[k].name, FF_JSON_LINE);
        ff_json_number(j, "value", v->value);
        ff_json_number(j, "std_error", v->std_error);
        put_interval(j, "interval", v);
        ff_json_string(j, "interval_from", v->interval ? ff_interval_name((int)v->interval) : NULL);
        ff_json_number(j, "carriers", v->carriers);
        ff_json_number(j, "residual_error", v->residual_error);
        put_bound(j, "at_bound", v->at_bound);
        ff_json_bool(j, "held", v->held);
        ff_json_bool(j, "tied", v->tied);
        put_known(j, f, &f->model.shape[k], v);
        ff_json_close(j);
    }
}

/* The last channel, with the prior that all have; a prior of some stands with the constraints. */
static ff_fit_value known_of_channels(const ff_fit_result *f, uint32_t k)
{
    const size_t stride = f->model.n_channel;
    ff_fit_value known = f->channel_value[(f->n_channels - 1) * stride + k];
    for (size_t c = 0; c < f->n_channels; c++)
        if (f->channel_value[c * stride + k].prior_sd != known.prior_sd) known.prior_sd = NAN;
    return known;
}

static void put_channels(ff_json *j, const ff_fit_result *f)
{
    const size_t n = f->n_channels, stride = f->model.n_channel;
    for (uint32_t k = 0; k < f->model.n_channel; k++) {
        const ff_fit_value *v = f->channel_value + k;
        ff_json_object(j, f->model.channel[k].name, FF_JSON_LINE);
        ff_json_array(j, "value", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) ff_json_number(j, NULL, v[c * stride].value);
        ff_json_close(j);
        ff_json_array(j, "std_error", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) ff_json_number(j, NULL, v[c * stride].std_error);
        ff_json_close(j);
        ff_json_array(j, "interval", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) put_interval(j, NULL, &v[c * stride]);
        ff_json_close(j);
        ff_json_array(j, "interval_from", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++)
            ff_json_string(j, NULL, v[c * stride].interval ? ff_interval_name((int)v[c * stride].interval) : NULL);
        ff_json_close(j);
        ff_json_array(j, "carriers", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) ff_json_number(j, NULL, v[c * stride].carriers);
        ff_json_close(j);
        ff_json_array(j, "residual_error", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) ff_json_number(j, NULL, v[c * stride].residual_error);
        ff_json_close(j);
        ff_json_array(j, "at_bound", FF_JSON_LINE);
        for (size_t c = 0; c < n; c++) put_bound(j, NULL, v[c * stride].at_bound);
        ff_json_close(j);
        ff_json_bool(j, "held", ff_report_all_held(f, k));
        const ff_fit_value known = known_of_channels(f, k);
        ff_json_bool(j, "tied", known.tied);
        put_known(j, f, &f->model.channel[k], &known);
        ff_json_close(j);
    }
}

/* Of many channels: for every channel the rows of its parameters, whose columns are those of `names`, then the channel's own. */
static void put_channel_correlation(ff_json *j, const ff_fit_result *f)
{
    const size_t N = f->model.n_channel, width = f->n_columns + N;
    int held[FF_MAX_CHANNEL_PARAMS];
    for (uint32_t k = 0; k < N; k++) held[k] = ff_report_all_held(f, k);
    ff_json_array(j, "channel_names", FF_JSON_LINE);
    for (uint32_t k = 0; k < N; k++)
        if (!held[k]) ff_json_string(j, NULL, f->model.channel[k].name);
    ff_json_close(j);
    ff_json_array(j, "channels", FF_JSON_BLOCK);
    for (size_t c = 0; c < f->n_channels; c++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        for (uint32_t k = 0; k < N; k++) {
            const double *row = f->channel_correlation + (c * N + k) * width;
            if (held[k]) continue;
            ff_json_array(j, NULL, FF_JSON_LINE);
            for (size_t i = 0; i < f->n_columns; i++) ff_json_number(j, NULL, row[i]);
            for (uint32_t i = 0; i < N; i++)
                if (!held[i]) ff_json_number(j, NULL, row[f->n_columns + i]);
            ff_json_close(j);
        }
        ff_json_close(j);
    }
    ff_json_close(j);
}

/* How --loss auto chose. */
static void put_candidates(ff_json *j, const ff_adaptive *a)
{
    ff_json_string(j, "chosen_by", "picture");
    ff_json_object(j, "pictures", FF_JSON_LINE);
    ff_json_integer(j, "pixels", (int64_t)a->coverage.pixels);
    ff_json_integer(j, "measured", (int64_t)a->coverage.measured);
    ff_json_close(j);
    ff_json_array(j, "candidates", FF_JSON_BLOCK);
    for (size_t k = 0; k < a->n; k++) {
        const ff_adaptive_candidate *c = &a->candidate[k];
        ff_json_object(j, NULL, FF_JSON_BLOCK);
        ff_json_string(j, "name", ff_loss_name((int)c->loss));
        ff_json_number(j, "picture_difference", c->difference);
        ff_json_string(j, "outcome", ff_outcome_name((int)c->fit.outcome));
        ff_json_object(j, "parameters", FF_JSON_BLOCK);
        put_shape(j, &c->fit);
        put_channels(j, &c->fit);
        ff_json_close(j);
        ff_json_close(j);
    }
    ff_json_close(j);
}

/* The noise of the data; null where the errors rest on the residuals alone. */
static void put_noise(ff_json *j, const ff_fit_result *f)
{
    const ff_noise *n = ff_fit_result_noise(f);
    if (!n) {
        ff_json_null(j, "noise");
        return;
    }
    ff_json_object(j, "noise", FF_JSON_BLOCK);
    ff_json_array(j, "levels", FF_JSON_BLOCK);
    for (size_t k = 0; k < ff_noise_level_count(n); k++) {
        const ff_noise_level l = ff_noise_level_at(n, k);
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_number(j, "constant", l.constant);
        ff_json_number(j, "linear", l.linear);
        ff_json_number(j, "square", l.square);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_number(j, "cos_i", ff_noise_cos_i(n));
    ff_json_number(j, "cos_o", ff_noise_cos_o(n));
    size_t lags = 0;
    while (lags < FF_NOISE_LAGS && ff_noise_along_scan(n, lags + 1) > 0) lags++;
    ff_json_array(j, "along_scan", FF_JSON_LINE);
    for (size_t lag = 1; lag <= lags; lag++) ff_json_number(j, NULL, ff_noise_along_scan(n, lag));
    ff_json_close(j);
    ff_json_number(j, "between_channels", ff_noise_between_channels(n));
    ff_json_close(j);
}

/* Names in the order of the columns, then the matrix by rows. With many channels the columns are those of the shape. */
static void put_correlation(ff_json *j, const ff_problem *p, const ff_fit_result *f)
{
    if (!f->correlation) {
        ff_json_null(j, "correlation");
        return;
    }
    ff_json_object(j, "correlation", FF_JSON_BLOCK);
    ff_json_array(j, "names", FF_JSON_LINE);
    for (size_t column = 0; column < f->n_columns; column++) {
        char name[FF_REPORT_NAME];
        ff_json_string(j, NULL, ff_report_column_name(p, f, column, name));
    }
    ff_json_close(j);
    ff_json_array(j, "matrix", FF_JSON_BLOCK);
    for (size_t a = 0; a < f->n_columns; a++) {
        ff_json_array(j, NULL, FF_JSON_LINE);
        for (size_t b = 0; b < f->n_columns; b++) ff_json_number(j, NULL, f->correlation[a * f->n_columns + b]);
        ff_json_close(j);
    }
    ff_json_close(j);
    if (f->channel_correlation) put_channel_correlation(j, f);
    ff_json_close(j);
}

static void put_ellipse(ff_json *j, const ff_fit_result *f)
{
    if (!f->has_ellipse) {
        ff_json_null(j, "ellipse");
        return;
    }
    ff_json_object(j, "ellipse", FF_JSON_LINE);
    ff_json_number(j, "alpha_major", f->ellipse.alpha_major);
    ff_json_number(j, "alpha_minor", f->ellipse.alpha_minor);
    ff_json_number(j, "phi_deg", f->ellipse.phi * degrees);
    ff_json_number(j, "phi_std_error_deg", f->ellipse.phi_std_error * degrees);
    ff_json_bool(j, "phi_determined", f->ellipse.phi_determined);
    ff_json_close(j);
}

void ff_report_rmses_json(ff_json *j, const ff_residual *r)
{
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++) {
        char key[64];
        if (!ff_loss_at(loss)->rmse_unit) continue;
        snprintf(key, sizeof key, "%s_rmse", ff_loss_name(loss));
        for (char *c = key; *c; c++)
            if (*c == '-') *c = '_';
        ff_json_number(j, key, r->loss_rmse[loss]);
    }
}

static void put_residual(ff_json *j, const ff_residual *r)
{
    ff_json_object(j, "residual", FF_JSON_LINE);
    ff_json_number(j, "objective", r->objective);
    ff_json_number(j, "rmse", r->rmse);
    ff_report_rmses_json(j, r);
    ff_json_number(j, "max_abs", r->max_abs);
    ff_json_close(j);
}

/* Names of the bases, joined by '+'. */
static void put_bases(ff_json *j, const ff_model *m)
{
    char names[FF_MODEL_NAME] = "";
    size_t used = 0;
    for (uint32_t b = 0; b < m->n_bases && used < sizeof names; b++)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s%s", b ? "+" : "",
                                 ff_term_at(FF_DIFFUSE, (size_t)m->base[b].diffuse)->name);
    ff_json_string(j, "diffuse", m->n_bases ? names : NULL);
}

static void put_fit(ff_json *j, const ff_report_fits *r, size_t i)
{
    const ff_problem *p = r->problem[i / (r->n_fits / r->n_problems)];
    const ff_fit_result *f = &r->fit[i];
    char expression[FF_MODEL_NAME];
    const ff_lobe *lobe = f->model.n_lobes ? &f->model.lobe[0] : NULL;
    ff_model_expression(&f->model, expression, sizeof expression);
    ff_json_object(j, NULL, FF_JSON_BLOCK);
    ff_json_string(j, "model", expression);
    ff_json_string(j, "ndf", lobe ? ff_term_at(FF_NDF, (size_t)lobe->ndf)->name : NULL);
    ff_json_string(j, "masking", lobe ? ff_term_at(FF_MASKING, (size_t)lobe->masking)->name : NULL);
    ff_json_string(j, "fresnel", lobe ? ff_term_at(FF_FRESNEL, (size_t)lobe->fresnel)->name : NULL);
    put_bases(j, &f->model);
    ff_json_string(j, "shape", ff_shape_name((int)f->shape));
    ff_json_array(j, "channels", FF_JSON_LINE);
    for (size_t c = 0; c < f->n_channels; c++) ff_json_string(j, NULL, ff_problem_channel_name(p, c));
    ff_json_close(j);
    ff_json_string(j, "outcome", ff_outcome_name((int)f->outcome));
    ff_json_integer(j, "iterations", f->iterations);
    ff_json_integer(j, "passes", f->passes);
    ff_json_number(j, "time_s", r->without_times ? NAN : f->time_s);
    ff_json_object(j, "parameters", FF_JSON_BLOCK);
    put_shape(j, f);
    put_channels(j, f);
    ff_json_close(j);
    put_ellipse(j, f);
    put_residual(j, &f->residual);
    ff_json_number(j, "prior_penalty", f->prior_penalty);
    ff_json_integer(j, "free_parameters", (int64_t)f->n_free);
    ff_json_number(j, "aic", f->aic);
    ff_json_number(j, "bic", f->bic);
    if (r->target) ff_report_controls_json(j, r, i);
    ff_report_trust_json(j, r, i);
    put_noise(j, f);
    put_correlation(j, p, f);
    const ff_words_subject subject = {.problem = p, .fit = f};
    ff_report_warnings_json(j, &subject, &f->warnings);
    ff_json_close(j);
}

static void put_groups(ff_json *j, const ff_report_fits *r)
{
    ff_json_object(j, "groups", FF_JSON_LINE);
    ff_json_integer(j, "n", (int64_t)r->places->n_groups);
    ff_json_string(j, "of", ff_grouping_name((int)r->places->kind));
    ff_json_integer(j, "folds", (int64_t)r->folds);
    ff_json_close(j);
}

static void put_difference(ff_json *j, const ff_difference *d)
{
    ff_json_object(j, "channels_differ", FF_JSON_LINE);
    ff_json_number(j, "chi2", d->chi2);
    ff_json_integer(j, "dof", (int64_t)d->dof);
    ff_json_number(j, "F", d->f);
    ff_json_number(j, "error_dof", d->error_dof);
    ff_json_number(j, "p", d->p);
    ff_json_close(j);
}

/* Of every problem that has it. */
static void put_next(ff_json *j, const ff_report_fits *r)
{
    int any = 0;
    for (size_t i = 0; i < r->n_fits; i++) any |= r->trust && r->trust[i].has_next;
    if (!any) return;
    ff_json_array(j, "measure_next", FF_JSON_BLOCK);
    for (size_t i = 0; i < r->n_fits; i++) {
        const ff_fit_trust *t = &r->trust[i];
        const ff_problem *p = r->problem[i / (r->n_fits / r->n_problems)];
        const ff_next *next = &t->next;
        if (!t->has_next) continue;
        const int of_channel = next->parameter.kind == FF_PARAM_CHANNEL;
        ff_json_object(j, NULL, FF_JSON_BLOCK);
        ff_json_integer(j, "fit", (int64_t)i);
        if (t->next_rival != i) ff_json_integer(j, "rival", (int64_t)t->next_rival);
        if (next->parameter.kind != FF_PARAM_NONE)
            ff_json_string(j, "parameter", ff_model_param_at(&r->fit[i].model, next->parameter)->name);
        if (of_channel) ff_json_string(j, "channel", ff_problem_channel_name(p, next->channel));
        ff_json_array(j, "incidences", FF_JSON_LINE);
        for (size_t k = 0; k < next->n; k++) {
            ff_json_object(j, NULL, FF_JSON_LINE);
            ff_json_number(j, "theta_i_deg", ff_report_degrees(next->at[k].theta_i));
            ff_json_number(j, "phi_i_deg", ff_report_degrees(next->at[k].phi_i));
            ff_json_close(j);
        }
        ff_json_close(j);
        ff_json_number(j, "reach_deg", ff_report_degrees(next->reach));
        ff_json_number(j, "now", next->now);
        ff_json_number(j, "then", next->then);
        ff_json_close(j);
    }
    ff_json_close(j);
}

/* What a comparison is made for: how well each masking can do, with whatever distribution suits it best. */
static ff_status put_maskings(ff_json *j, const ff_report_fits *r)
{
    ff_status status = FF_OK;
    if (r->target || r->n_fits == r->n_problems) return FF_OK;
    ff_json_array(j, "by_masking", FF_JSON_BLOCK);
    for (size_t p = 0; p < r->n_problems && status == FF_OK; p++) {
        size_t *row, n;
        status = ff_report_best_of_maskings(r, p, &row, &n);
        for (size_t k = 0; k < n; k++) {
            const double best = r->fit[row[0]].residual.objective, own = r->fit[row[k]].residual.objective;
            ff_json_object(j, NULL, FF_JSON_LINE);
            ff_json_string(j, "masking", ff_report_masking_name(&r->fit[row[k]]));
            ff_json_string(j, "ndf", ff_report_ndf_name(&r->fit[row[k]]));
            ff_json_integer(j, "fit", (int64_t)row[k]);
            ff_json_number(j, "ratio", own == best ? 1 : own / best);
            ff_json_close(j);
        }
        free(row);
    }
    ff_json_close(j);
    return status;
}

ff_status ff_report_fits_json(const ff_report_fits *r, FILE *out)
{
    ff_json j;
    const size_t models = r->n_fits / r->n_problems;
    size_t *rank = malloc((models ? models : 1) * sizeof *rank);
    if (!rank) return FF_ERR_MEMORY;
    ff_json_begin(&j, out);
    ff_json_object(&j, NULL, FF_JSON_BLOCK);
    ff_report_head_json(&j, FF_SCHEMA_FIT, &r->head);
    put_selection(&j, r);
    put_loss(&j, r->options, r->adaptive);
    put_constraints(&j, r->options->constraints);
    if (r->places) put_groups(&j, r);
    if (r->difference) put_difference(&j, r->difference);
    ff_status status = ff_report_verdict_json(&j, r);
    put_next(&j, r);
    ff_json_array(&j, "fits", FF_JSON_BLOCK);
    for (size_t i = 0; i < r->n_fits; i++) put_fit(&j, r, i);
    ff_json_close(&j);
    /* One problem after another: fits of different channels are not compared. */
    ff_json_array(&j, "ranking", FF_JSON_LINE);
    for (size_t p = 0; p < r->n_problems; p++) {
        ff_report_rank(r, p, rank);
        for (size_t i = 0; i < models; i++) ff_json_integer(&j, NULL, (int64_t)rank[i]);
    }
    ff_json_close(&j);
    if (status == FF_OK) status = put_maskings(&j, r);
    ff_json_close(&j);
    ff_json_end(&j);
    free(rank);
    return status;
}
