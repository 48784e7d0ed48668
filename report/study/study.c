/* Making a study: the fits, and what is asked of them. */
#define _GNU_SOURCE
#include "internal_study_report.h"
#include "base/internal_options.h"
#include "fit/interface/internal_interface.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

void ff_study_options_init_size(ff_study_options *o, size_t size)
{
    const ff_study_options defaults = {.seed = 1, .cut_off = NAN, .reach = NAN};
    ff_options_init(o, size, &defaults, sizeof defaults);
}

/* ---- options --------------------------------------------------------------------------------- */

static ff_status check_many(const ff_study_options *o, size_t n_models, ff_error *err)
{
    if (n_models == 1 && !o->compare) return FF_OK;
    if (o->choose_loss)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a loss is chosen for one model: name a loss to compare several");
    if (o->bootstrap || o->profile)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "intervals by a bootstrap or a profile are of one fit: fit one model");
    return FF_OK;
}

static ff_status check_loss(const ff_fit_options *fit, ff_error *err)
{
    if (fit->robust != FF_ROBUST_NONE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "a robust loss has its scale in units of the residual, which every loss has its own: name a loss");
    if (fit->channels == FF_CHANNELS_EACH)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "a loss is chosen by pictures of all channels: name a loss");
    if (fit->weighting == FF_WEIGHT_NOISE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "weights by the noise take the place of the loss: name a loss");
    return FF_OK;
}

static ff_status check_range(const ff_study_options *o, const ff_fit_options *fit, ff_error *err)
{
    if (o->bootstrap && o->profile)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a profile and a bootstrap both find the intervals: one of them");
    if (o->folds == 1) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "1 fold leaves nothing to fit to: expected 2 or more");
    if (!isnan(o->cut_off) && !(o->cut_off >= 0 && o->cut_off < fit->max_theta))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "a cut-off of %g degrees: expected an angle below the limit of theta, %g", o->cut_off / degree,
                            fit->max_theta / degree);
    if (!isnan(o->reach) && !(o->reach >= 0 && o->reach < FF_HORIZON))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a reach of %g degrees: expected 0 to 90", o->reach / degree);
    return FF_OK;
}

/* *own: the options as this library has them. */
static ff_status take_options(const ff_study_options *o, const ff_fit_options *fit, size_t n_models, ff_study_options *own,
                              ff_fit_options *own_fit, ff_error *err)
{
    ff_study_options_init(own);
    ff_status status = FF_OK;
    if (o) status = ff_options_take("ff_study_options", o, FF_END_OF(ff_study_options, busy_context), own, sizeof *own, err);
    if (status != FF_OK) return status;
    ff_fit_options_init(own_fit);
    if (fit) {
        ff_fit_options room;
        const ff_fit_options *taken = ff_fit_options_take(fit, &room, err);
        if (!taken) return FF_ERR_RANGE;
        *own_fit = *taken;
    }
    if (n_models == 0) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "no models: expected one at least");
    status = check_many(own, n_models, err);
    if (status == FF_OK && own->choose_loss) status = check_loss(own_fit, err);
    return status == FF_OK ? check_range(own, own_fit, err) : status;
}

static ff_looks looks_of(const ff_study_options *o, const ff_fit_options *fit)
{
    const double highest = fit->max_theta / degree, usual = highest > 20 ? (highest - 10) * degree : 0;
    return (ff_looks){.bootstrap = o->bootstrap,
                      .folds = o->folds,
                      .seed = o->seed,
                      .profile = o->profile,
                      .cut_off = isnan(o->cut_off) ? usual : o->cut_off,
                      .cut_off_given = o->cut_off > 0,
                      .reach = isnan(o->reach) ? -1 : o->reach,
                      .by_angle = 1,
                      .places_wanted = 1};
}

/* ---- making ---------------------------------------------------------------------------------- */

static void keep_note(void *study, const char *sentence)
{
    ff_study *s = study;
    char **longer = realloc(s->note, (s->n_notes + 1) * sizeof *longer);
    if (longer) s->note = longer;
    char *text = longer ? strdup(sentence) : NULL;
    if (text)
        s->note[s->n_notes++] = text;
    else
        s->no_memory = 1;
}

static void tell(void *study, const char *what)
{
    const ff_study *s = study;
    if (s->busy) s->busy(s->busy_context, what);
}

static ff_status run(void *study, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err);

static ff_fitting data_of(ff_study *s, int errors_given)
{
    return (ff_fitting){.path = s->path,
                        .table = s->table,
                        .options = &s->options,
                        .n_problems = s->n_problems,
                        .problem = s->problem,
                        .keeps_samples = 1,
                        .errors_given = errors_given,
                        .run = run,
                        .note = keep_note,
                        .busy = tell,
                        .context = s};
}

static ff_status run(void *study, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err)
{
    ff_study *s = study;
    const ff_fitting d = data_of(s, 0);
    tell(s, label);
    const ff_status status = ff_fitting_run(&d, problem, m, out, err);
    tell(s, "");
    return status;
}

static ff_status fit_models(ff_study *s, int errors_given, ff_error *err)
{
    ff_status status = ff_fitting_problems(s->table, s->model, s->n_models, &s->options, &s->problem, &s->n_problems, err);
    if (status != FF_OK) return status;
    const ff_fitting d = data_of(s, errors_given);
    s->fit = calloc(s->n_models * s->n_problems, sizeof *s->fit);
    if (!s->fit) return FF_ERR_MEMORY;
    if (s->compares) return ff_fitting_fit_all(&d, s->model, s->n_models, s->fit, NULL, &s->n_fits, err);
    while (s->n_fits < s->n_problems && status == FF_OK) {
        status = ff_fitting_fit(&d, s->n_fits, s->model, &s->fit[s->n_fits], err);
        s->n_fits += status == FF_OK;
    }
    return status;
}

/* With every loss; the problem and the fit are then those of the chosen one. */
static ff_status fit_adaptively(ff_study *s, ff_error *err)
{
    ff_adaptive *all = calloc(1, sizeof *all);
    if (!all) return FF_ERR_MEMORY;
    tell(s, "losses");
    const ff_status status = ff_fit_adaptive_into(s->table, s->model, &s->options, all, err);
    tell(s, "");
    if (status != FF_OK) {
        free(all);
        return status;
    }
    s->adaptive = all;
    s->adaptive_problem[0] = all->problem;
    s->problem = s->adaptive_problem;
    s->fit = &all->candidate[all->chosen].fit;
    s->n_problems = s->n_fits = 1;
    s->options.loss = all->candidate[all->chosen].loss;
    return FF_OK;
}

static ff_status look(ff_study *s, int errors_given, ff_error *err)
{
    const ff_fitting d = data_of(s, errors_given);
    if (!s->compares) return ff_fitting_look(&s->looks, &d, s->fit, s->n_fits, err);
    const size_t models = s->n_fits / s->n_problems;
    size_t *best = calloc(s->n_problems, sizeof *best);
    if (!best) return FF_ERR_MEMORY;
    for (size_t p = 0; p < s->n_problems; p++) best[p] = p * models + ff_fits_best(s->problem[p], s->fit + p * models, models);
    const ff_status status = ff_fitting_compare(&s->looks, &d, s->fit, s->n_fits, best, err);
    free(best);
    return status;
}

static ff_status begin(ff_study *s, const ff_model *const *models, size_t n_models, const ff_study_options *o)
{
    s->path = strdup(o->path ? o->path : "data");
    s->command = o->command ? strdup(o->command) : NULL;
    s->model = calloc(n_models, sizeof *s->model);
    if (!s->path || !s->model || (o->command && !s->command)) return FF_ERR_MEMORY;
    for (; s->n_models < n_models; s->n_models++) s->model[s->n_models] = *models[s->n_models];
    s->words[0] = s->command;
    s->compares = o->compare || n_models > 1;
    s->looks = looks_of(o, &s->options);
    s->busy = o->busy;
    s->busy_context = o->busy_context;
    return FF_OK;
}

ff_status ff_study_new(const ff_table *t, const ff_model *const *models, size_t n_models, const ff_fit_options *fit,
                       const ff_study_options *o, ff_study **out, ff_error *err)
{
    ff_study_options own;
    ff_study *s = calloc(1, sizeof *s);
    if (!s) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    s->table = t;
    ff_status status = take_options(o, fit, n_models, &own, &s->options, err);
    if (status == FF_OK) status = begin(s, models, n_models, &own);
    if (status == FF_OK) status = own.choose_loss ? fit_adaptively(s, err) : fit_models(s, own.errors_asked, err);
    if (status == FF_OK) status = look(s, own.errors_asked, err);
    if (status == FF_OK && s->no_memory) status = FF_ERR_MEMORY;
    s->busy = NULL;
    if (status == FF_OK) {
        *out = s;
        return FF_OK;
    }
    ff_study_free(s);
    if (status == FF_ERR_MEMORY) ff_error_set(err, status, NULL, 0, -1, "out of memory");
    return status;
}

void ff_study_free(ff_study *s)
{
    if (!s) return;
    ff_looks_clear(&s->looks);
    if (s->adaptive) {
        ff_adaptive_clear(s->adaptive);
        free(s->adaptive);
    } else {
        for (size_t i = 0; i < s->n_fits; i++) ff_fit_result_clear(&s->fit[i]);
        for (size_t i = 0; i < s->n_problems; i++) ff_problem_free(s->problem[i]);
        free(s->fit);
        free(s->problem);
    }
    for (size_t i = 0; i < s->n_notes; i++) free(s->note[i]);
    free(s->note);
    free(s->model);
    free(s->command);
    free(s->path);
    free(s);
}

/* ---- looking --------------------------------------------------------------------------------- */

size_t ff_study_problem_count(const ff_study *s)
{
    return s->n_problems;
}

const ff_problem *ff_study_problem(const ff_study *s, size_t i)
{
    return i < s->n_problems ? s->problem[i] : NULL;
}

size_t ff_study_fit_count(const ff_study *s)
{
    return s->n_fits;
}

const ff_fit_result *ff_study_fit(const ff_study *s, size_t i)
{
    return i < s->n_fits ? &s->fit[i] : NULL;
}

size_t ff_study_ranked(const ff_study *s, size_t problem, size_t rank)
{
    const size_t models = s->n_fits / s->n_problems;
    size_t few[64], *all = models <= 64 ? few : malloc(models * sizeof *all), found = (size_t)-1;
    if (all && problem < s->n_problems && rank < models) {
        ff_fits_rank(s->problem[problem], s->fit + problem * models, models, all);
        found = problem * models + all[rank];
    }
    if (all != few) free(all);
    return found;
}

const ff_versus *ff_study_versus(const ff_study *s, size_t i)
{
    return i < s->n_fits && s->looks.each && s->looks.each[i].has_versus ? &s->looks.each[i].versus : NULL;
}

const ff_fit_options *ff_study_fit_options(const ff_study *s)
{
    return &s->options;
}

const char *ff_study_note(const ff_study *s, size_t i)
{
    return i < s->n_notes ? s->note[i] : NULL;
}
