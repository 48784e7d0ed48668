/* Which pictures `render` makes: of files, results and models that the command line names. */
#include "internal_rendering.h"
#include "ff_spectral.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- pictures -------------------------------------------------------------------------------- */

static int room_for(cli_balls *b, size_t n)
{
    b->ball = calloc(n + 1, sizeof *b->ball);
    return b->ball ? EXIT_DONE : cli_failed(FF_ERR_MEMORY, NULL);
}

/* A model with a copy of its values. */
static int add_model(cli_balls *b, const ff_model *m, size_t n_channels, const double *shape, const double *channel)
{
    cli_ball *ball = &b->ball[b->n++];
    ball->model = m;
    ball->n_channels = n_channels;
    ball->shape = malloc((m->n_shape + 1) * sizeof *shape);
    ball->channel = malloc((n_channels * m->n_channel + 1) * sizeof *channel);
    if (!ball->shape || !ball->channel) return cli_failed(FF_ERR_MEMORY, NULL);
    memcpy(ball->shape, shape, m->n_shape * sizeof *shape);
    memcpy(ball->channel, channel, n_channels * m->n_channel * sizeof *channel);
    return EXIT_DONE;
}

static void say(cli_ball *ball, const char *separator, const char *format, const char *name, const char *value)
{
    const size_t used = strlen(ball->label);
    snprintf(ball->label + used, sizeof ball->label - used, format, used ? separator : "", name, value);
}

/* Sets a parameter of the last picture to value k of a sweep, and says so. */
static int apply(const cli_args *args, cli_flag_id flag, const cli_sweep *sweep, size_t k, cli_balls *b)
{
    cli_ball *ball = &b->ball[b->n - 1];
    char word[CLI_NAME + FF_REPORT_NUMBER + 2], number[FF_REPORT_NUMBER];
    ff_error err = {0};
    if (!sweep->n) return EXIT_DONE;
    ff_report_number(sweep->value[k], number);
    snprintf(word, sizeof word, "%s=%s", sweep->name, number);
    ff_status status = ff_model_set(ball->model, ball->n_channels, word, ball->shape, ball->channel, &err);
    if (status == FF_OK) status = ff_model_check(ball->model, ball->n_channels, ball->shape, ball->channel, &err);
    if (status != FF_OK) {
        const char *nearest = status == FF_ERR_UNKNOWN ? cli_param_nearest(ball->model, 1, sweep->name) : NULL;
        cli_error("--%s %s: %s%s%s%s", cli_flag_name(flag), cli_value(args, flag, ""), err.message,
                  nearest ? "; did you mean '" : "", nearest ? nearest : "", nearest ? "'?" : "");
        return cli_exit_status(status);
    }
    say(ball, ", ", "%s%s = %s", sweep->name, number);
    return EXIT_DONE;
}

/* A model once for each value of one sweep, or of two. */
static int add_swept(const cli_args *args, const cli_sweep *across, const cli_sweep *down, const char *label, const ff_model *m,
                     size_t n_channels, const double *shape, const double *channel, cli_balls *b)
{
    for (size_t j = 0; j < (down->n ? down->n : 1); j++)
        for (size_t i = 0; i < (across->n ? across->n : 1); i++) {
            int status = add_model(b, m, n_channels, shape, channel);
            if (status != EXIT_DONE) return status;
            snprintf(b->ball[b->n - 1].label, CLI_LABEL, "%s", label);
            status = apply(args, FLAG_ACROSS, across, i, b);
            if (status == EXIT_DONE) status = apply(args, FLAG_DOWN, down, j, b);
            if (status != EXIT_DONE) return status;
        }
    return EXIT_DONE;
}

/* ---- models ---------------------------------------------------------------------------------- */

static int add_expressions(const cli_args *args, const cli_sweep *across, const cli_sweep *down, cli_balls *b)
{
    const size_t n = args->n_words, each = (across->n ? across->n : 1) * (down->n ? down->n : 1);
    if (n > 1 && down->n)
        return cli_usage(args, "--down has its rows, and so have several models: give one model, or --across alone");
    b->columns = across->n ? across->n : down->n ? 1 : n;
    int status = room_for(b, n * each);
    b->scene = calloc(n + 1, sizeof *b->scene);
    if (!b->scene) return cli_failed(FF_ERR_MEMORY, NULL);
    for (size_t k = 0; k < n && status == EXIT_DONE; k++) {
        cli_scene *s = &b->scene[k];
        status = cli_scene_make(args, args->word[k], 1, s);
        if (status != EXIT_DONE) return status;
        b->n_scenes++;
        status = add_swept(args, across, down, n > 1 ? args->word[k] : "", &s->model, s->n_channels, s->shape, s->channel, b);
    }
    b->differ = cli_switch(args, FLAG_DIFFERENCE, 0);
    if (status == EXIT_DONE && b->differ && b->n != 2)
        return cli_usage(args, "--difference is of two pictures, and these are %zu", b->n);
    return status;
}

/* ---- files ----------------------------------------------------------------------------------- */

/* Colours by the names of channels, of which "465nm" is a wavelength. */
static ff_status name_colours(const ff_fitted *f, double **out, ff_error *err)
{
    ff_channel *channel = malloc(f->n_channels * sizeof *channel);
    ff_status status = FF_ERR_MEMORY;
    *out = malloc(3 * f->n_channels * sizeof **out);
    if (channel && *out) {
        for (size_t c = 0; c < f->n_channels; c++) {
            char number[FF_CHANNEL_NAME];
            const size_t digits = strspn(f->channel_name[c], "0123456789.");
            channel[c] = (ff_channel){.wavelength_nm = NAN, .scale = 1};
            snprintf(channel[c].name, sizeof channel[c].name, "%s", f->channel_name[c]);
            snprintf(number, sizeof number, "%.*s", (int)digits, f->channel_name[c]);
            if (!strcmp(f->channel_name[c] + digits, "nm") && !cli_number_read(number, &channel[c].wavelength_nm))
                channel[c].wavelength_nm = NAN;
        }
        status = ff_spectral_colours(f->n_channels, channel, *out, err);
    }
    free(channel);
    return status;
}

static int read_document(const cli_args *args, const char *path, cli_balls *b, const ff_fitted **out)
{
    ff_error err = {0};
    ff_status failed = ff_fit_document_read(path, &b->document, &err);
    if (failed != FF_OK) {
        if (!err.path[0]) snprintf(err.path, sizeof err.path, "%s", path);
        return cli_failed(failed, &err);
    }
    ff_fitted *f = &b->document->fit[b->document->best];
    const int status = cli_tables_read(args, &b->tables);
    if (status != EXIT_DONE) return status;
    failed = cli_tables_give(&b->tables, &f->model, &err);
    if (failed == FF_OK) failed = name_colours(f, &b->colours, &err);
    *out = f;
    return failed == FF_OK ? EXIT_DONE : cli_failed(failed, &err);
}

/* The table; with the document of --from also its model. */
static int add_table(const cli_args *args, const char *path, cli_balls *b)
{
    const char *from = cli_value(args, FLAG_FROM, NULL);
    const ff_fitted *f = NULL;
    int status = cli_read(args, path, 1, &b->table);
    if (status != EXIT_DONE) return status;
    b->has_table = 1;
    status = room_for(b, 2);
    if (status == EXIT_DONE && from) status = read_document(args, from, b, &f);
    if (status != EXIT_DONE) return status;
    if (f) {
        status = add_model(b, &f->model, f->n_channels, f->shape, f->channel);
        if (status == EXIT_DONE) status = add_model(b, &f->model, f->n_channels, f->shape, f->channel);
        if (status != EXIT_DONE) return status;
        b->ball[1].colours = b->colours;
        snprintf(b->ball[0].label, CLI_LABEL, "data");
        snprintf(b->ball[1].label, CLI_LABEL, "model");
    }
    b->n = b->columns = f ? 2 : 1;
    b->with_data = f != NULL;
    b->ball[0].table = &b->table;
    b->differ = cli_switch(args, FLAG_DIFFERENCE, f != NULL);
    if (!b->differ || f) return EXIT_DONE;
    return cli_usage(args, "--difference is of data and a model, and there is no model: add --from FIT.json");
}

static int add_document(const cli_args *args, const cli_sweep *across, const cli_sweep *down, cli_balls *b)
{
    const ff_fitted *f = NULL;
    int status = read_document(args, args->word[0], b, &f);
    b->columns = across->n ? across->n : 1;
    if (status == EXIT_DONE) status = room_for(b, b->columns * (down->n ? down->n : 1));
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): there is a fit where the status is EXIT_DONE
    if (status == EXIT_DONE) status = add_swept(args, across, down, "", &f->model, f->n_channels, f->shape, f->channel, b);
    for (size_t k = 0; k < b->n; k++) b->ball[k].colours = b->colours;
    if (status == EXIT_DONE && cli_switch(args, FLAG_DIFFERENCE, 0))
        return cli_usage(args, "--difference is of data and a model: name the data, and the result by --from");
    return status;
}

/* ---- all ------------------------------------------------------------------------------------- */

int cli_balls_gather(const cli_args *args, const cli_sweep *across, const cli_sweep *down, cli_balls *b)
{
    cli_source first = CLI_SOURCE_MODEL;
    for (size_t k = 0; k < args->n_words; k++) {
        cli_source one;
        const int status = cli_source_of(args->word[k], &one);
        if (status != EXIT_DONE) return status;
        if (k == 0) first = one;
        if (k > 0 && (one != CLI_SOURCE_MODEL || first != CLI_SOURCE_MODEL))
            return cli_usage(args, "pictures are of one file, or of models: '%s' is too much", args->word[k]);
    }
    if (first != CLI_SOURCE_MODEL && cli_given(args, FLAG_SET))
        return cli_usage(args, "--set is of models, and %s is a file", args->word[0]);
    if (first == CLI_SOURCE_TABLE && (across->n || down->n))
        return cli_usage(args, "--%s is of models, and %s is a file", across->n ? "across" : "down", args->word[0]);
    if (first != CLI_SOURCE_TABLE && cli_given(args, FLAG_FROM))
        return cli_usage(args, "--from is the model of measured data, and %s is none: leave it out", args->word[0]);
    if (first == CLI_SOURCE_TABLE) return add_table(args, args->word[0], b);
    return first == CLI_SOURCE_MODEL ? add_expressions(args, across, down, b) : add_document(args, across, down, b);
}

void cli_balls_free(cli_balls *b)
{
    for (size_t k = 0; k < b->n && b->ball; k++) {
        free(b->ball[k].shape);
        free(b->ball[k].channel);
    }
    free(b->ball);
    for (size_t k = 0; k < b->n_scenes; k++) cli_scene_free(&b->scene[k]);
    free(b->scene);
    if (b->has_table) ff_table_clear(&b->table);
    ff_fit_document_free(b->document);
    free(b->colours);
    cli_tables_free(&b->tables);
}
