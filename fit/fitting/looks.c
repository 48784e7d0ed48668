/* What is asked of finished fits: other errors and intervals, a lower limit of theta, residuals by angle, comparisons, what to
 * measure next. */
#define _GNU_SOURCE
#include "internal_fitting.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void say(const ff_fitting *d, const char *what)
{
    if (d->busy) d->busy(d->context, what);
}

static ff_status make_places(ff_looks *l, const ff_fitting *d, ff_error *err)
{
    l->places = calloc(d->n_problems, sizeof *l->places);
    if (!l->places) return FF_ERR_MEMORY;
    for (; l->n_places < d->n_problems; l->n_places++) {
        const ff_status status = ff_places_init(d->problem[l->n_places], d->table, &l->places[l->n_places], err);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

static ff_status begin(ff_looks *l, const ff_fitting *d, size_t n_fits, int needs_places, ff_error *err)
{
    l->n_fits = n_fits;
    l->each = calloc(n_fits, sizeof *l->each);
    if (!l->each) return FF_ERR_MEMORY;
    return d->keeps_samples && needs_places ? make_places(l, d, err) : FF_OK;
}

/* ---- of one fit ------------------------------------------------------------------------------ */

/* The check at a lower limit is made unasked: where it cannot be, nothing is said. */
static ff_status check_cut_off(const ff_looks *l, const ff_fitting *d, size_t problem, const ff_fit_result *fit, ff_fit_trust *each,
                               ff_error *err)
{
    ff_error reason = {0};
    ff_selection s;
    if (!(l->cut_off > 0)) return FF_OK;
    ff_status status = ff_trust_cut_off_into(d->problem[problem], d->options, fit, l->cut_off, &each->cut_off, &reason);
    ff_problem_selection(d->problem[problem], &s);
    each->has_cut_off = status == FF_OK && (l->cut_off_given || each->cut_off.used < s.used);
    if (status == FF_OK && !each->has_cut_off) ff_cut_off_clear(&each->cut_off);
    if ((status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED) && !l->cut_off_given) return FF_OK;
    if (status != FF_OK && err) *err = reason;
    return status;
}

/* Unasked, as with weights by the noise, only where there are incidences enough and the data are all that is known. */
static ff_status leave_out_incidences(const ff_looks *l, const ff_fitting *d, size_t problem, ff_fit_result *fit, ff_error *err)
{
    char text[FF_ERROR_MESSAGE + 80];
    ff_error reason = {0};
    if (d->options->errors != FF_ERRORS_INCIDENCES) return FF_OK;
    const ff_status status = ff_trust_jackknife(d->problem[problem], &l->places[problem], d->options, fit, &reason);
    if ((status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED) && !d->errors_given) {
        snprintf(text, sizeof text, "errors are by the noise of the data, not by whole incidences: %s", reason.message);
        if (d->note) d->note(d->context, text);
        return FF_OK;
    }
    if (status != FF_OK && err) *err = reason;
    return status;
}

static ff_status look_at_explained(const ff_fitting *d, size_t problem, const ff_fit_result *fit, ff_fit_trust *each, ff_error *err)
{
    const ff_status status = ff_trust_explained_into(d->problem[problem], d->options, fit, &each->explained, err);
    each->has_explained = status == FF_OK;
    return status;
}

static ff_status look_at_fit(const ff_looks *l, const ff_fitting *d, size_t problem, ff_fit_result *fit, ff_fit_trust *each,
                             ff_error *err)
{
    ff_problem *p = d->problem[problem];
    const ff_fit_options *o = d->options;
    ff_status status = check_cut_off(l, d, problem, fit, each, err);
    if (status == FF_OK) status = leave_out_incidences(l, d, problem, fit, err);
    if (status == FF_OK && l->bootstrap) {
        status = ff_trust_bootstrap_into(p, &l->places[problem], o, l->bootstrap, l->seed, fit, &each->bootstrap, err);
        each->has_bootstrap = status == FF_OK;
    }
    if (status == FF_OK && l->profile) status = ff_trust_profile(p, o, fit, err);
    return status == FF_OK ? look_at_explained(d, problem, fit, each, err) : status;
}

static ff_status look_at_instrument(const ff_looks *l, const ff_fitting *d, size_t problem, const ff_fit_result *fit,
                                    ff_fit_trust *each, ff_error *err)
{
    if (!l->has_instrument) return FF_OK;
    const ff_status status = ff_trust_budget_into(d->problem[problem], d->table, &l->places[problem], d->options, fit,
                                                  &l->instrument, &each->budget, err);
    each->has_budget = status == FF_OK;
    each->uncertainties = l->instrument;
    return status;
}

static ff_status look_at_residuals(const ff_looks *l, const ff_fitting *d, size_t problem, const ff_fit_result *fit,
                                   ff_fit_trust *each, ff_error *err)
{
    ff_problem *p = d->problem[problem];
    ff_status status = ff_trust_bands_into(p, &l->places[problem], d->options, fit, &each->bands, err);
    each->has_bands = status == FF_OK;
    if (status != FF_OK || d->options->robust == FF_ROBUST_NONE) return status;
    status = ff_trust_outliers_into(p, &l->places[problem], d->options, fit, &each->outliers, err);
    each->has_outliers = status == FF_OK;
    return status;
}

/* What to measure next, where the noise of the data says what a sample tells; rival is the fit itself: none. */
static ff_status look_ahead(const ff_looks *l, const ff_fitting *d, size_t problem, const ff_fit_result *fit, size_t i,
                            size_t rival, ff_error *err)
{
    ff_error reason = {0};
    ff_fit_trust *each = &l->each[i];
    const ff_status status = ff_trust_next_into(d->problem[problem], d->table, &l->places[problem], d->options, &fit[i],
                                                rival == i ? NULL : &fit[rival], fmax(l->reach, 0), &each->next, &reason);
    each->has_next = status == FF_OK;
    each->next_rival = rival;
    if (status == FF_ERR_UNSUPPORTED) return FF_OK;
    if (status != FF_OK && err) *err = reason;
    return status;
}

ff_status ff_fitting_look(ff_looks *l, const ff_fitting *d, ff_fit_result *fit, size_t n_fits, ff_error *err)
{
    const int needs_places = l->by_angle || l->bootstrap || l->places_wanted || l->reach >= 0 || l->has_instrument ||
                             d->options->errors == FF_ERRORS_INCIDENCES;
    ff_status status = begin(l, d, n_fits, needs_places, err);
    say(d, l->bootstrap ? "bootstrap" : l->profile ? "profile" : "residuals");
    for (size_t i = 0; i < n_fits && status == FF_OK; i++) {
        status = look_at_fit(l, d, i, &fit[i], &l->each[i], err);
        if (status == FF_OK) status = look_at_instrument(l, d, i, &fit[i], &l->each[i], err);
        if (status == FF_OK && l->places && l->by_angle) status = look_at_residuals(l, d, i, &fit[i], &l->each[i], err);
        if (status == FF_OK && l->places && l->reach >= 0) status = look_ahead(l, d, i, fit, i, i, err);
    }
    if (status == FF_OK && n_fits > 1) {
        status = ff_trust_channels_differ_into(fit, n_fits, &l->difference, err);
        l->has_difference = status == FF_OK;
    }
    say(d, "");
    if (status == FF_ERR_DATA && err && !err->path[0]) snprintf(err->path, sizeof err->path, "%s", d->path);
    return status;
}

/* ---- of compared fits ------------------------------------------------------------------------ */

/* The best of those of n fits from `first` on that are not told apart from the best one; that itself where there is none. */
static size_t rival_of(const ff_looks *l, const ff_fit_result *fit, size_t first, size_t n, size_t best)
{
    size_t found = best;
    for (size_t i = first; i < first + n; i++) {
        if (i == best || l->each[i].versus.told_apart) continue;
        if (found == best || fit[i].residual.objective < fit[found].residual.objective) found = i;
    }
    return found;
}

/* The answer is one of those that are not told apart from the best: what they explain is looked at. */
static ff_status look_at_compared(const ff_looks *l, const ff_fitting *d, size_t problem, ff_fit_result *fit, size_t i,
                                  ff_error *err)
{
    ff_fit_trust *each = &l->each[i];
    ff_status status = leave_out_incidences(l, d, problem, &fit[i], err);
    if (status == FF_OK) status = look_at_residuals(l, d, problem, &fit[i], each, err);
    if (status == FF_OK && !each->versus.told_apart) status = look_at_explained(d, problem, &fit[i], each, err);
    return status;
}

static ff_status compare_in(ff_looks *l, const ff_fitting *d, size_t problem, ff_fit_result *fit, size_t models, size_t best,
                            ff_versus *versus, ff_error *err)
{
    const size_t first = problem * models;
    ff_status status = ff_trust_compare_into(d->problem[problem], &l->places[problem], d->options, fit + first, models,
                                             best - first, l->folds, versus, err);
    for (size_t m = 0; m < models && status == FF_OK; m++) {
        l->each[first + m].versus = versus[m];
        l->each[first + m].has_versus = 1;
        status = look_at_compared(l, d, problem, fit, first + m, err);
    }
    return status == FF_OK ? look_ahead(l, d, problem, fit, best, rival_of(l, fit, first, models, best), err) : status;
}

ff_status ff_fitting_compare(ff_looks *l, const ff_fitting *d, ff_fit_result *fit, size_t n_fits, const size_t *best, ff_error *err)
{
    const size_t models = n_fits / d->n_problems;
    ff_status status = begin(l, d, n_fits, 1, err);
    ff_versus *versus = calloc(models, sizeof *versus);
    if (!versus && status == FF_OK) status = FF_ERR_MEMORY;
    say(d, l->folds ? "cross-validation" : "residuals");
    for (size_t p = 0; p < d->n_problems && status == FF_OK; p++) status = compare_in(l, d, p, fit, models, best[p], versus, err);
    say(d, "");
    free(versus);
    return status;
}

void ff_looks_clear(ff_looks *l)
{
    for (size_t i = 0; i < l->n_fits && l->each; i++) {
        ff_cut_off_clear(&l->each[i].cut_off);
        ff_budget_clear(&l->each[i].budget);
    }
    for (size_t i = 0; i < l->n_places; i++) ff_places_clear(&l->places[i]);
    free(l->each);
    free(l->places);
    *l = (ff_looks){.n_fits = 0};
}
