/* What --bootstrap, --profile, --cross-validate, --residuals and --cut-off ask of finished fits. */
#include "internal_cli.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

/* ---- options --------------------------------------------------------------------------------- */

/* "0.001", or "3sigma" where the data have standard deviations. */
static int read_noise_floor(const cli_args *args, ff_fit_options *o)
{
    const char *text = cli_value(args, FLAG_NOISE_FLOOR, NULL), *sigma = text ? strstr(text, "sigma") : NULL;
    char number[CLI_NAME];
    double x = 0;
    if (!text) return EXIT_DONE;
    snprintf(number, sizeof number, "%.*s", (int)(sigma ? sigma - text : (ptrdiff_t)strlen(text)), text);
    if (!cli_number_read(number, &x) || (sigma && (strcmp(sigma, "sigma") || !(x > 0))))
        return cli_usage(args, "--noise-floor %s: expected a value in 1/sr, or a number of standard deviations as in 3sigma", text);
    if (sigma)
        o->noise_sigmas = x;
    else
        o->noise_floor = x;
    return EXIT_DONE;
}

int cli_read_censoring(const cli_args *args, ff_fit_options *o)
{
    const int status = read_noise_floor(args, o);
    if (status != EXIT_DONE) return status;
    o->saturation = cli_number(args, FLAG_SATURATION, o->saturation);
    o->drop_negative = cli_word(args, FLAG_NEGATIVE, 0);
    if (!(o->noise_floor < o->saturation)) return cli_usage(args, "--noise-floor must lie below --saturation");
    return EXIT_DONE;
}

/* What is stated of the instrument. */
static int read_instrument(const cli_args *args, const ff_fit_options *o, cli_trust *t)
{
    ff_budget_options *u = &t->instrument;
    ff_budget_options_init(u);
    u->scale = cli_number(args, FLAG_SCALE_UNCERTAINTY, 0);
    u->offset = cli_number(args, FLAG_OFFSET_UNCERTAINTY, 0) * degree;
    u->angle = cli_number(args, FLAG_ANGLE_UNCERTAINTY, 0) * degree;
    u->aperture = cli_number(args, FLAG_APERTURE_UNCERTAINTY, 0) * degree;
    t->has_instrument = u->scale > 0 || u->offset > 0 || u->angle > 0 || u->aperture > 0;
    if (u->aperture > 0 && !(o->aperture && o->aperture->half > 0))
        return cli_usage(args, "--aperture-uncertainty is of an aperture: give it with --aperture");
    if (t->has_instrument && o->robust != FF_ROBUST_NONE)
        return cli_usage(args, "what an instrument adds is found for sums of squares: leave out --robust, or the uncertainties");
    return EXIT_DONE;
}

int cli_trust_read(const cli_args *args, const ff_fit_options *o, cli_trust *out)
{
    const double highest = o->max_theta / degree;
    const double cut_off = cli_number(args, FLAG_CUT_OFF, highest > 20 ? highest - 10 : 0);
    cli_trust t = {.seed = cli_integer(args, FLAG_SEED, 1),
                   .bootstrap = (size_t)cli_integer(args, FLAG_BOOTSTRAP, 0),
                   .folds = (size_t)cli_integer(args, FLAG_CROSS_VALIDATE, 0),
                   .profile = cli_switch(args, FLAG_PROFILE, 0),
                   .cut_off = cut_off * degree,
                   .cut_off_given = cli_given(args, FLAG_CUT_OFF) > 0 && cut_off > 0,
                   .residuals = cli_value(args, FLAG_RESIDUALS, NULL),
                   .by_angle = 1,
                   .reach = cli_given(args, FLAG_REACH) ? cli_number(args, FLAG_REACH, 0) * degree : -1};
    if (t.residuals && o->channels == FF_CHANNELS_EACH)
        return cli_usage(args,
                         "--residuals takes one fit, --channels each makes several: choose a channel with --reduce channels:NAME");
    if (t.bootstrap && t.profile) return cli_usage(args, "--profile and --bootstrap both find the intervals: give one of them");
    if (t.cut_off_given && !(cut_off < highest - 1e-9))
        return cli_usage(args, "--cut-off %g: expected an angle below that of --max-theta, %g", cut_off, highest);
    const int status = read_instrument(args, o, &t);
    if (status == EXIT_DONE) *out = t;
    return status;
}

/* ---- after the fits -------------------------------------------------------------------------- */

static ff_status make_places(cli_trust *t, cli_fitting *f, ff_error *err)
{
    t->places = calloc(f->n_problems, sizeof *t->places);
    if (!t->places) return FF_ERR_MEMORY;
    for (; t->n_places < f->n_problems; t->n_places++) {
        const ff_status status = ff_places_init(f->problem[t->n_places], &f->table, &t->places[t->n_places], err);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

/* The check at a lower limit is made unasked: where it cannot be, nothing is said. */
static ff_status check_cut_off(cli_trust *t, ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit,
                               ff_report_trust *each, ff_error *err)
{
    ff_error reason = {0};
    ff_selection s;
    if (!(t->cut_off > 0)) return FF_OK;
    ff_status status = ff_trust_cut_off_into(p, o, fit, t->cut_off, &each->cut_off, &reason);
    ff_problem_selection(p, &s);
    each->has_cut_off = status == FF_OK && (t->cut_off_given || each->cut_off.used < s.used);
    if (status == FF_OK && !each->has_cut_off) ff_cut_off_clear(&each->cut_off);
    if ((status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED) && !t->cut_off_given) return FF_OK;
    if (status != FF_OK) *err = reason;
    return status;
}

/* Unasked, as with weights by the noise, only where there are incidences enough and the data are all that is known. */
static ff_status leave_out_incidences(const cli_trust *t, const cli_fitting *f, size_t problem, ff_fit_result *fit, ff_error *err)
{
    ff_error reason = {0};
    if (f->options.errors != FF_ERRORS_INCIDENCES) return FF_OK;
    const ff_status status = ff_trust_jackknife(f->problem[problem], &t->places[problem], &f->options, fit, &reason);
    if ((status == FF_ERR_DATA || status == FF_ERR_UNSUPPORTED) && !f->errors_given) {
        cli_message("errors are by the noise of the data, not by whole incidences: %s", reason.message);
        return FF_OK;
    }
    if (status != FF_OK) *err = reason;
    return status;
}

static ff_status look_at_explained(const cli_fitting *f, size_t problem, const ff_fit_result *fit, ff_report_trust *each,
                                   ff_error *err)
{
    const ff_status status = ff_trust_explained_into(f->problem[problem], &f->options, fit, &each->explained, err);
    each->has_explained = status == FF_OK;
    return status;
}

static ff_status look_at_fit(cli_trust *t, cli_fitting *f, size_t problem, ff_fit_result *fit, ff_report_trust *each, ff_error *err)
{
    ff_problem *p = f->problem[problem];
    const ff_fit_options *o = &f->options;
    ff_status status = check_cut_off(t, p, o, fit, each, err);
    if (status == FF_OK) status = leave_out_incidences(t, f, problem, fit, err);
    if (status == FF_OK && t->bootstrap) {
        status = ff_trust_bootstrap_into(p, &t->places[problem], o, t->bootstrap, t->seed, fit, &each->bootstrap, err);
        each->has_bootstrap = status == FF_OK;
    }
    if (status == FF_OK && t->profile) status = ff_trust_profile(p, o, fit, err);
    return status == FF_OK ? look_at_explained(f, problem, fit, each, err) : status;
}

static ff_status look_at_instrument(const cli_trust *t, const cli_fitting *f, size_t problem, const ff_fit_result *fit,
                                    ff_report_trust *each, ff_error *err)
{
    if (!t->has_instrument) return FF_OK;
    const ff_status status = ff_trust_budget_into(f->problem[problem], &f->table, &t->places[problem], &f->options, fit,
                                                  &t->instrument, &each->budget, err);
    each->has_budget = status == FF_OK;
    each->uncertainties = t->instrument;
    return status;
}

static ff_status look_at_residuals(cli_trust *t, cli_fitting *f, size_t problem, const ff_fit_result *fit, ff_report_trust *each,
                                   ff_error *err)
{
    ff_problem *p = f->problem[problem];
    ff_status status = ff_trust_bands_into(p, &t->places[problem], &f->options, fit, &each->bands, err);
    each->has_bands = status == FF_OK;
    if (status != FF_OK || f->options.robust == FF_ROBUST_NONE) return status;
    status = ff_trust_outliers_into(p, &t->places[problem], &f->options, fit, &each->outliers, err);
    each->has_outliers = status == FF_OK;
    return status;
}

static ff_status begin(cli_trust *t, cli_fitting *f, size_t n_fits, int needs_places, ff_error *err)
{
    t->n_fits = n_fits;
    t->each = calloc(n_fits, sizeof *t->each);
    if (!t->each) return FF_ERR_MEMORY;
    return f->keeps_samples && needs_places ? make_places(t, f, err) : FF_OK;
}

static void say(const cli_fitting *f, const char *what)
{
    if (f->progress) cli_progress_show("%s", what);
}

/* What to measure next, where the noise of the data says what a sample tells; rival NULL: none. */
static ff_status look_ahead(cli_trust *t, cli_fitting *f, size_t problem, const ff_fit_result *fit, size_t i, size_t rival,
                            ff_error *err)
{
    ff_error reason = {0};
    const ff_status status = ff_trust_next_into(f->problem[problem], &f->table, &t->places[problem], &f->options, &fit[i],
                                                rival == i ? NULL : &fit[rival], fmax(t->reach, 0), &t->each[i].next, &reason);
    t->each[i].has_next = status == FF_OK;
    t->each[i].next_rival = rival;
    if (status == FF_ERR_UNSUPPORTED) return FF_OK;
    if (status != FF_OK) *err = reason;
    return status;
}

int cli_trust_fit(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits)
{
    ff_error err = {0};
    const int needs_places = t->by_angle || t->bootstrap || t->residuals || t->reach >= 0 || t->has_instrument ||
                             f->options.errors == FF_ERRORS_INCIDENCES;
    ff_status status = begin(t, f, n_fits, needs_places, &err);
    say(f, t->bootstrap ? "bootstrap" : t->profile ? "profile" : "residuals");
    for (size_t i = 0; i < n_fits && status == FF_OK; i++) {
        status = look_at_fit(t, f, i, &fit[i], &t->each[i], &err);
        if (status == FF_OK) status = look_at_instrument(t, f, i, &fit[i], &t->each[i], &err);
        if (status == FF_OK && t->places && t->by_angle) status = look_at_residuals(t, f, i, &fit[i], &t->each[i], &err);
        if (status == FF_OK && t->places && t->reach >= 0) status = look_ahead(t, f, i, fit, i, i, &err);
    }
    if (status == FF_OK && n_fits > 1) {
        status = ff_trust_channels_differ_into(fit, n_fits, &t->difference, &err);
        t->has_difference = status == FF_OK;
    }
    say(f, "");
    if (status == FF_ERR_DATA && !err.path[0]) snprintf(err.path, sizeof err.path, "%s", f->path);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

/* The best of those of n fits from `first` on that are not told apart from the best one; that itself where there is none. */
static size_t rival_of(const cli_trust *t, const ff_fit_result *fit, size_t first, size_t n, size_t best)
{
    size_t found = best;
    for (size_t i = first; i < first + n; i++) {
        if (i == best || t->each[i].versus.told_apart) continue;
        if (found == best || fit[i].residual.objective < fit[found].residual.objective) found = i;
    }
    return found;
}

int cli_trust_compare(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits, const size_t *best)
{
    const size_t models = n_fits / f->n_problems;
    ff_error err = {0};
    ff_status status = begin(t, f, n_fits, 1, &err);
    ff_versus *versus = calloc(models, sizeof *versus);
    if (!versus && status == FF_OK) status = FF_ERR_MEMORY;
    say(f, t->folds ? "cross-validation" : "residuals");
    for (size_t p = 0; p < f->n_problems && status == FF_OK; p++) {
        status = ff_trust_compare_into(f->problem[p], &t->places[p], &f->options, fit + p * models, models, best[p] - p * models,
                                       t->folds, versus, &err);
        for (size_t m = 0; m < models && status == FF_OK; m++) {
            ff_report_trust *each = &t->each[p * models + m];
            each->versus = versus[m];
            each->has_versus = 1;
            status = leave_out_incidences(t, f, p, &fit[p * models + m], &err);
            if (status != FF_OK) break;
            status = look_at_residuals(t, f, p, &fit[p * models + m], each, &err);
            if (status == FF_OK && !each->versus.told_apart) /* the answer is one of these */
                status = look_at_explained(f, p, &fit[p * models + m], each, &err);
        }
        if (status == FF_OK) status = look_ahead(t, f, p, fit, best[p], rival_of(t, fit, p * models, models, best[p]), &err);
    }
    say(f, "");
    free(versus);
    if (status == FF_ERR_RANGE) return cli_failed(FF_ERR_SYNTAX, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

void cli_trust_report(const cli_trust *t, ff_report_fits *r)
{
    r->trust = t->each;
    r->places = t->places;
    r->folds = t->folds;
    r->difference = t->has_difference ? &t->difference : NULL;
}

void cli_trust_free(cli_trust *t)
{
    for (size_t i = 0; i < t->n_fits && t->each; i++) {
        ff_cut_off_clear(&t->each[i].cut_off);
        ff_budget_clear(&t->each[i].budget);
    }
    for (size_t i = 0; i < t->n_places; i++) ff_places_clear(&t->places[i]);
    free(t->each);
    free(t->places);
    memset(t, 0, sizeof *t);
}

/* ---- --residuals ----------------------------------------------------------------------------- */

typedef struct residual_file {
    const ff_table *table, *residuals;
    const char *title;
} residual_file;

static ff_status write_csv(const void *context, FILE *out)
{
    const residual_file *r = context;
    return ff_report_residuals_csv(r->table, r->residuals, r->title, out);
}

static int has_extension(const char *path, const char *extension)
{
    const size_t n = strlen(path), m = strlen(extension);
    return n > m && !strcmp(path + n - m, extension);
}

int cli_residuals_check(const cli_args *args)
{
    const char *path = cli_value(args, FLAG_RESIDUALS, NULL);
    if (!path || has_extension(path, ".csv") || has_extension(path, ".exr")) return EXIT_DONE;
    return cli_usage(args, "--residuals %s: expected a name that ends in .csv or .exr", path);
}

int cli_residuals_write(const cli_args *args, const cli_trust *t, cli_fitting *f, const ff_fit_result *fit)
{
    char title[FF_MODEL_NAME + 64] = "residuals of ";
    ff_table residuals;
    ff_error err = {0};
    int status = EXIT_DONE;
    if (!t->residuals) return EXIT_DONE;
    ff_status failed = ff_trust_residual_table_into(f->problem[0], &f->table, &f->options, fit, &residuals, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    ff_model_expression(&fit->model, title + strlen(title), FF_MODEL_NAME);
    if (has_extension(t->residuals, ".exr")) {
        failed = ff_table_write_with(t->residuals, "exr", &residuals, args->outputs, &err);
        if (failed != FF_OK) status = cli_failed(failed, &err);
    } else {
        const residual_file file = {&f->table, &residuals, title};
        status = cli_write(args, t->residuals, write_csv, &file);
    }
    ff_table_clear(&residuals);
    return status;
}
