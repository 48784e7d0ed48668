/* The fits of a study: one model to each problem, or many. */
#define _GNU_SOURCE
#include "internal_fitting.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void note(const ff_fitting *d, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void note(const ff_fitting *d, const char *format, ...)
{
    char text[FF_ERROR_MESSAGE + FF_MODEL_NAME + 32];
    va_list args;
    if (!d->note) return;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    d->note(d->context, text);
}

ff_status ff_fitting_problems(const ff_table *t, const ff_model *models, size_t n_models, const ff_fit_options *o,
                              ff_problem ***problem, size_t *n, ff_error *err)
{
    const int each = o->channels == FF_CHANNELS_EACH;
    const size_t wanted = each ? t->n_channels : 1;
    ff_fit_options own = *o;
    *n = 0;
    *problem = calloc(wanted, sizeof **problem);
    if (!*problem) return FF_ERR_MEMORY;
    if (each) own.channels = FF_CHANNELS_RGB;
    for (; *n < wanted; (*n)++) {
        if (each) own.only_channel = (int)*n;
        const ff_status status = ff_problem_make(t, models, n_models, &own, &(*problem)[*n], err);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

ff_fit_options ff_fitting_options_of(const ff_fitting *d, size_t problem)
{
    ff_fit_options o = *d->options;
    if (o.channels == FF_CHANNELS_EACH) {
        o.channels = FF_CHANNELS_RGB;
        o.only_channel = (int)problem;
    }
    return o;
}

ff_status ff_fitting_run(const ff_fitting *d, size_t problem, const ff_model *m, ff_fit_result *out, ff_error *err)
{
    const ff_fit_options o = ff_fitting_options_of(d, problem);
    const ff_status status = ff_problem_fit_into(d->problem[problem], m, &o, out, err);
    if (status == FF_ERR_DATA && err && !err->path[0]) snprintf(err->path, sizeof err->path, "%s", d->path);
    return status;
}

static ff_status run(const ff_fitting *d, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err)
{
    return d->run ? d->run(d->context, problem, m, label, out, err) : ff_fitting_run(d, problem, m, out, err);
}

ff_status ff_fitting_scale(const ff_fitting *d, size_t problem, const ff_model *m, ff_error *err)
{
    const ff_fit_options o = ff_fitting_options_of(d, problem);
    if (o.robust == FF_ROBUST_NONE || o.robust_scale > 0) return FF_OK;
    return ff_problem_estimate_scale(d->problem[problem], m, &o, err);
}

ff_status ff_fitting_weigh(const ff_fitting *d, size_t problem, const ff_fit_result *by, int *weighed, ff_error *err)
{
    const ff_fit_options o = ff_fitting_options_of(d, problem);
    *weighed = by->noise != NULL;
    if (*weighed) return ff_problem_weigh_by_noise(d->problem[problem], &o, by, err);
    note(d, "the first fit leaves nothing but rounding: there is no noise to weigh by, and weights are as by default");
    return FF_OK;
}

ff_status ff_fitting_fit(const ff_fitting *d, size_t problem, const ff_model *m, ff_fit_result *out, ff_error *err)
{
    char expression[FF_MODEL_NAME];
    int weighed = 0;
    ff_fit_result first, again;
    ff_model_expression(m, expression, sizeof expression);
    ff_status status = ff_fitting_scale(d, problem, m, err);
    if (status == FF_OK) status = run(d, problem, m, expression, &first, err);
    if (status != FF_OK) return status;
    if (d->options->weighting == FF_WEIGHT_NOISE) status = ff_fitting_weigh(d, problem, &first, &weighed, err);
    if (status == FF_OK && weighed) {
        status = run(d, problem, m, expression, &again, err);
        if (status == FF_OK) {
            ff_fit_result_clear(&first);
            first = again;
        }
    }
    if (status == FF_OK)
        *out = first;
    else
        ff_fit_result_clear(&first);
    return status;
}

/* ---- many models ----------------------------------------------------------------------------- */

/* The models are compared by one objective: where the scale of a robust loss is to be estimated, the model that bends most does it
 * for all. */
static ff_status share_scale(const ff_fitting *d, const ff_model *model, size_t n_models, ff_error *err)
{
    static const char *const flexible[] = {"student-t", "gtr", "sgd", "ggx"};
    const ff_model *by = model;
    if (d->options->robust == FF_ROBUST_NONE || d->options->robust_scale > 0) return FF_OK;
    for (size_t k = sizeof flexible / sizeof *flexible; k-- > 0;)
        for (size_t m = 0; m < n_models; m++)
            if (model[m].lobe[0].ndf == ff_term_find(FF_NDF, flexible[k])) by = &model[m];
    for (size_t p = 0; p < d->n_problems; p++) {
        const ff_status status = ff_fitting_scale(d, p, by, err);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

static ff_status fit_each(const ff_fitting *d, const ff_model *model, size_t n_models, ff_fit_result *fit, size_t *which, size_t *n,
                          ff_error *err)
{
    for (size_t p = 0; p < d->n_problems; p++)
        for (size_t m = 0; m < n_models; m++) {
            char expression[FF_MODEL_NAME], label[FF_MODEL_NAME + 64];
            ff_model_expression(&model[m], expression, sizeof expression);
            snprintf(label, sizeof label, "%zu of %zu: %s", p * n_models + m + 1, d->n_problems * n_models, expression);
            const ff_status status = run(d, p, &model[m], label, &fit[*n], err);
            if (status == FF_OK) {
                if (which) which[*n] = m;
                (*n)++;
            } else if (status == FF_ERR_UNSUPPORTED) {
                if (p == 0) note(d, "left out %s: %s", expression, err->message);
            } else {
                return status;
            }
        }
    return *n > 0 ? FF_OK : ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "no combination is left to compare");
}

/* Weighs every problem by the noise of the model that makes its data most likely; *any: whether there was some. */
static ff_status weigh_all(const ff_fitting *d, const ff_fit_result *fit, size_t models, int *any, ff_error *err)
{
    for (size_t p = 0; p < d->n_problems; p++) {
        int weighed = 0;
        size_t best = 0;
        ff_status status = ff_trust_likeliest_into(d->problem[p], d->options, fit + p * models, models, &best, err);
        if (status == FF_OK) status = ff_fitting_weigh(d, p, &fit[p * models + best], &weighed, err);
        if (status != FF_OK) return status;
        *any |= weighed;
    }
    return FF_OK;
}

ff_status ff_fitting_fit_all(const ff_fitting *d, const ff_model *model, size_t n_models, ff_fit_result *fit, size_t *which,
                             size_t *n, ff_error *err)
{
    int any = 0;
    *n = 0;
    ff_status status = share_scale(d, model, n_models, err);
    if (status == FF_OK) status = fit_each(d, model, n_models, fit, which, n, err);
    if (status != FF_OK || d->options->weighting != FF_WEIGHT_NOISE) return status;
    status = weigh_all(d, fit, *n / d->n_problems, &any, err);
    if (status != FF_OK || !any) return status;
    for (size_t i = 0; i < *n; i++) ff_fit_result_clear(&fit[i]);
    *n = 0;
    return fit_each(d, model, n_models, fit, which, n, err);
}
