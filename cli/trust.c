/* What --bootstrap, --profile, --cross-validate, --residuals and --cut-off ask of finished fits. */
#include "internal_cli.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double degree = 3.14159265358979323846 / 180;

/* ---- options --------------------------------------------------------------------------------- */

/* What is stated of the instrument. */
static int read_instrument(const cli_args *args, const ff_fit_options *o, cli_trust *t)
{
    ff_budget_options *u = &t->looks.instrument;
    ff_budget_options_init(u);
    u->scale = cli_number(args, FLAG_SCALE_UNCERTAINTY, 0);
    u->offset = cli_number(args, FLAG_OFFSET_UNCERTAINTY, 0) * degree;
    u->angle = cli_number(args, FLAG_ANGLE_UNCERTAINTY, 0) * degree;
    u->aperture = cli_number(args, FLAG_APERTURE_UNCERTAINTY, 0) * degree;
    t->looks.has_instrument = u->scale > 0 || u->offset > 0 || u->angle > 0 || u->aperture > 0;
    if (u->aperture > 0 && !(o->aperture && o->aperture->half > 0))
        return cli_usage(args, "--aperture-uncertainty is of an aperture: give it with --aperture");
    if (t->looks.has_instrument && o->robust != FF_ROBUST_NONE)
        return cli_usage(args, "what an instrument adds is found for sums of squares: leave out --robust, or the uncertainties");
    return EXIT_DONE;
}

int cli_trust_read(const cli_args *args, const ff_fit_options *o, cli_trust *out)
{
    const double highest = o->max_theta / degree;
    const double cut_off = cli_number(args, FLAG_CUT_OFF, highest > 20 ? highest - 10 : 0);
    cli_trust t = {.looks = {.seed = cli_integer(args, FLAG_SEED, 1),
                             .bootstrap = (size_t)cli_integer(args, FLAG_BOOTSTRAP, 0),
                             .folds = (size_t)cli_integer(args, FLAG_CROSS_VALIDATE, 0),
                             .profile = cli_switch(args, FLAG_PROFILE, 0),
                             .cut_off = cut_off * degree,
                             .cut_off_given = cli_given(args, FLAG_CUT_OFF) > 0 && cut_off > 0,
                             .by_angle = 1,
                             .reach = cli_given(args, FLAG_REACH) ? cli_number(args, FLAG_REACH, 0) * degree : -1},
                   .residuals = cli_value(args, FLAG_RESIDUALS, NULL)};
    t.looks.places_wanted = t.residuals != NULL;
    if (t.residuals && o->channels == FF_CHANNELS_EACH)
        return cli_usage(args,
                         "--residuals takes one fit, --channels each makes several: choose a channel with --reduce channels:NAME");
    if (t.looks.bootstrap && t.looks.profile)
        return cli_usage(args, "--profile and --bootstrap both find the intervals: give one of them");
    if (t.looks.cut_off_given && !(cut_off < highest - 1e-9))
        return cli_usage(args, "--cut-off %g: expected an angle below that of --max-theta, %g", cut_off, highest);
    const int status = read_instrument(args, o, &t);
    if (status == EXIT_DONE) *out = t;
    return status;
}

/* ---- after the fits -------------------------------------------------------------------------- */

int cli_trust_fit(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits)
{
    ff_error err = {0};
    const ff_fitting d = cli_fitting_data(f);
    const ff_status status = ff_fitting_look(&t->looks, &d, fit, n_fits, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

int cli_trust_compare(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits, const size_t *best)
{
    ff_error err = {0};
    const ff_fitting d = cli_fitting_data(f);
    const ff_status status = ff_fitting_compare(&t->looks, &d, fit, n_fits, best, &err);
    if (status == FF_ERR_RANGE) return cli_failed(FF_ERR_SYNTAX, &err);
    return status == FF_OK ? EXIT_DONE : cli_failed(status, &err);
}

void cli_trust_report(const cli_trust *t, ff_report_fits *r)
{
    r->trust = t->looks.each;
    r->places = t->looks.places;
    r->folds = t->looks.folds;
    r->difference = t->looks.has_difference ? &t->looks.difference : NULL;
}

void cli_trust_free(cli_trust *t)
{
    ff_looks_clear(&t->looks);
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
