/* How far fits can be trusted, as programs read it: keys of a fit in FF_SCHEMA_FIT. */
#include "internal_report.h"
#include <math.h>

/* What the data can tell; null without standard errors. */
static void put_information(ff_json *j, const ff_fit_result *f)
{
    static const char *const keys[] = {"rank", "condition", "effective_samples", "correlated_over", "correlation_settled"};
    for (size_t k = 0; k < sizeof keys / sizeof *keys && !f->correlation; k++) ff_json_null(j, keys[k]);
    if (!f->correlation) return;
    ff_json_integer(j, "rank", (int64_t)f->rank);
    ff_json_number(j, "condition", f->condition);
    ff_json_number(j, "effective_samples", f->effective_samples);
    ff_json_integer(j, "correlated_over", (int64_t)f->correlated_over);
    ff_json_bool(j, "correlation_settled", f->correlation_settled);
}

static void put_bands(ff_json *j, const ff_bands *bands)
{
    ff_json_object(j, "residual_bands", FF_JSON_BLOCK);
    for (int place = 0; place < FF_PLACE_COUNT; place++) {
        ff_json_array(j, ff_place_name(place), FF_JSON_BLOCK);
        for (size_t b = 0; b < FF_BANDS; b++) {
            const ff_band *band = &bands->band[place][b];
            ff_json_object(j, NULL, FF_JSON_LINE);
            ff_json_integer(j, "from", (int64_t)(b * FF_BAND_DEGREES));
            ff_json_integer(j, "to", (int64_t)((b + 1) * FF_BAND_DEGREES));
            ff_json_integer(j, "n", (int64_t)band->n);
            ff_json_number(j, "mean", band->mean);
            ff_json_number(j, "rms", band->rms);
            ff_json_close(j);
        }
        ff_json_close(j);
    }
    ff_json_close(j);
}

static void put_versus(ff_json *j, const ff_versus *v)
{
    ff_json_object(j, "versus_best", FF_JSON_LINE);
    ff_json_number(j, "delta_objective", v->objective);
    ff_json_number(j, "delta_aic", v->aic);
    ff_json_number(j, "delta_bic", v->bic);
    ff_json_number(j, "vuong_z", v->vuong_z);
    ff_json_number(j, "vuong_p", v->vuong_p);
    ff_json_string(j, "test", v->by_parameter ? "parameter" : v->weighted ? "incidences" : "objective");
    if (v->has_validation) {
        ff_json_object(j, "cross_validation", FF_JSON_LINE);
        ff_json_number(j, "difference", v->validation);
        ff_json_number(j, "std_error", v->validation_error);
        ff_json_close(j);
    } else {
        ff_json_null(j, "cross_validation");
    }
    ff_json_bool(j, "told_apart", v->told_apart);
    ff_json_close(j);
}

static void put_cut_off(ff_json *j, const ff_problem *p, const ff_fit_result *f, const ff_cut_off *c)
{
    ff_json_object(j, "cut_off", FF_JSON_BLOCK);
    ff_json_number(j, "max_theta_deg", ff_report_degrees(c->max_theta));
    ff_json_integer(j, "used", (int64_t)c->used);
    ff_json_number(j, "limit_in_errors", c->limit);
    ff_json_array(j, "parameters", FF_JSON_BLOCK);
    for (size_t k = 0; k < c->n_columns; k++) {
        char name[FF_REPORT_NAME];
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "name", ff_report_column_name(p, f, k, name));
        ff_json_number(j, "value", c->value[k]);
        ff_json_number(j, "move_in_errors", c->move[k]);
        ff_json_number(j, "move_in_fit_errors", c->shift[k]);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_close(j);
}

/* What was stated of the instrument, and what it adds. */
static void put_budget(ff_json *j, const ff_problem *p, const ff_fit_result *f, const ff_budget *b, const ff_budget_options *u)
{
    ff_json_object(j, "uncertainty_budget", FF_JSON_BLOCK);
    ff_json_object(j, "of", FF_JSON_LINE);
    ff_json_number(j, "scale", u->scale);
    ff_json_number(j, "offset_deg", ff_report_degrees(u->offset));
    ff_json_number(j, "angle_deg", ff_report_degrees(u->angle));
    ff_json_number(j, "aperture_deg", ff_report_degrees(u->aperture));
    ff_json_close(j);
    ff_json_array(j, "parameters", FF_JSON_BLOCK);
    for (size_t k = 0; k < b->n_columns; k++) {
        char name[FF_REPORT_NAME];
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_string(j, "name", ff_report_column_name(p, f, k, name));
        ff_json_number(j, "random", b->random[k]);
        for (int s = 0; s < FF_BUDGET_SOURCES; s++)
            if (b->by[s]) ff_json_number(j, ff_budget_source_name(s), b->by[s][k]);
        ff_json_number(j, "combined", b->combined[k]);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_close(j);
}

static void put_bootstrap(ff_json *j, const ff_bootstrap *b)
{
    ff_json_object(j, "bootstrap", FF_JSON_LINE);
    ff_json_integer(j, "repeats", (int64_t)b->repeats);
    ff_json_integer(j, "failed", (int64_t)b->failed);
    ff_json_integer(j, "groups", (int64_t)b->n_groups);
    ff_json_string(j, "of", ff_grouping_name((int)b->kind));
    ff_json_close(j);
}

static void put_outliers(ff_json *j, const ff_problem *p, const ff_outliers *o)
{
    ff_json_object(j, "outliers", FF_JSON_BLOCK);
    ff_json_number(j, "beyond_std_deviations", FF_OUTLIER);
    ff_json_integer(j, "samples", (int64_t)o->samples);
    ff_json_integer(j, "values", (int64_t)o->values);
    for (int place = 0; place < FF_PLACE_COUNT; place++) {
        ff_json_array(j, ff_place_name(place), FF_JSON_LINE);
        for (size_t b = 0; b < FF_BANDS; b++) ff_json_integer(j, NULL, (int64_t)o->in_band[place][b]);
        ff_json_close(j);
    }
    ff_json_array(j, "worst", FF_JSON_BLOCK);
    for (size_t k = 0; k < o->n_worst; k++) {
        ff_json_object(j, NULL, FF_JSON_LINE);
        ff_json_integer(j, "sample", (int64_t)o->worst[k].sample);
        ff_json_string(j, "channel", ff_problem_channel_name(p, o->worst[k].channel));
        ff_json_number(j, "residual_in_std_deviations", o->worst[k].ratio);
        ff_json_close(j);
    }
    ff_json_close(j);
    ff_json_close(j);
}

static void put_explained(ff_json *j, const ff_explained *e)
{
    ff_json_object(j, "explained", FF_JSON_LINE);
    ff_json_number(j, "share", e->share);
    ff_json_number(j, "bright_error", e->bright_error);
    ff_json_integer(j, "bright_values", (int64_t)e->bright_values);
    if (!isnan(e->worst_mean)) {
        ff_json_object(j, "worst", FF_JSON_LINE);
        ff_json_string(j, "angle", ff_place_name(e->worst_place));
        ff_json_integer(j, "from_deg", (int64_t)e->worst_band * FF_BAND_DEGREES);
        ff_json_integer(j, "to_deg", ((int64_t)e->worst_band + 1) * FF_BAND_DEGREES);
        ff_json_number(j, "mean", e->worst_mean);
        ff_json_number(j, "share", e->worst_share);
        ff_json_close(j);
    }
    ff_json_close(j);
}

void ff_report_trust_json(ff_json *j, const ff_report_fits *r, size_t i)
{
    const ff_fit_result *f = &r->fit[i];
    const ff_problem *p = r->problem[i / (r->n_fits / r->n_problems)];
    const ff_fit_trust *t = r->trust ? &r->trust[i] : NULL;
    put_information(j, f);
    if (!t) return;
    if (t->has_explained) put_explained(j, &t->explained);
    if (t->has_versus) put_versus(j, &t->versus);
    if (t->has_bands) put_bands(j, &t->bands);
    if (t->has_cut_off) put_cut_off(j, p, f, &t->cut_off);
    if (t->has_budget) put_budget(j, p, f, &t->budget, &t->uncertainties);
    if (t->has_bootstrap) put_bootstrap(j, &t->bootstrap);
    if (t->has_outliers) put_outliers(j, p, &t->outliers);
}
