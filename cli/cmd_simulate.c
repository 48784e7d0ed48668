/* facetfit simulate EXPR -o FILE: a data set from a model, at directions that have a name, or at those that the format has. */
#include "internal_walking.h"
#include "simulate/simulate_struct.h"
#include <stdio.h>
#include <string.h>

/* The options borrow the noise, which *noise owns. */
static int read_noise(const cli_args *args, ff_simulate_options *o, ff_noise **noise)
{
    const char *text = cli_value(args, FLAG_NOISE_MODEL, NULL);
    ff_error err = {0};
    o->relative = cli_number(args, FLAG_NOISE, o->relative);
    o->floor = cli_number(args, FLAG_NOISE_FLOOR, o->floor);
    if (!text) return EXIT_DONE;
    if (cli_given(args, FLAG_NOISE) || cli_given(args, FLAG_NOISE_FLOOR))
        return cli_usage(args, "--noise-model takes the place of --noise and --noise-floor: give relative= and floor= in it");
    if (ff_noise_parse(text, noise, &err)) return cli_usage(args, "--noise-model %s: %s", text, err.message);
    o->noise = *noise;
    return EXIT_DONE;
}

static int read_options(const cli_args *args, ff_simulate_options *o, ff_aperture *aperture, ff_walk_options *walk,
                        ff_height_field_options *surface)
{
    ff_simulate_options_init(o);
    int status = cli_isa(args, &o->isa);
    if (status == EXIT_DONE) status = cli_aperture(args, NULL, aperture);
    if (status != EXIT_DONE) return status;
    o->aperture = aperture;
    o->seed = cli_integer(args, FLAG_SEED, o->seed);
    o->sigma = cli_switch(args, FLAG_SIGMA, 0);
    status = cli_walk_read(args, cli_given(args, FLAG_SURFACE) ? 4000000 : 10000, "all", walk);
    if (!status) status = cli_surface_read(args, walk, surface);
    if (cli_given(args, FLAG_WALK)) o->walk = walk;
    if (!cli_given(args, FLAG_SURFACE) || status) return status;
    o->surface = surface;
    if (aperture->across != aperture->half && cli_given(args, FLAG_APERTURE))
        return cli_usage(args, "--surface counts in cones: --aperture DEG");
    if (aperture->half > 0) surface->aperture = aperture->half;
    *aperture = (ff_aperture){.outline = FF_APERTURE_DISC};
    return EXIT_DONE;
}

/* Whether --grid names directions of its own; otherwise the words are those of the format. */
static ff_status read_grid(const char *grid, const ff_format *format, ff_simulate_options *o, int *named, ff_error *err)
{
    *named = 0;
    if (!grid) return FF_OK;
    const ff_status status = ff_sampling_parse(grid, &o->sampling, err);
    if (status == FF_ERR_UNKNOWN && format->layout) return FF_OK;
    *named = 1;
    return status;
}

static ff_status make_table(const cli_scene *scene, const ff_format *format, const char *grid, const ff_simulate_options *o,
                            int named, ff_table *t, ff_error *err)
{
    if (named) return ff_simulate_into(&scene->model, scene->n_channels, scene->shape, scene->channel, o, t, err);
    return ff_simulate_layout_into(&scene->model, scene->n_channels, scene->shape, scene->channel, format, grid, o, t, err);
}

/* Directions that were asked for may be none that the format can hold; its own are those of no --grid. */
static int not_written(const ff_format *format, int named, ff_status failed, ff_error *err)
{
    const size_t used = strlen(err->message);
    if (failed == FF_ERR_UNSUPPORTED && named && format->layout)
        snprintf(err->message + used, sizeof err->message - used, "; without --grid the directions are those of the format");
    return cli_failed(failed, err);
}

static int simulate(const cli_args *args, const char *path, const ff_format *format, ff_simulate_options *o)
{
    const char *grid = cli_value(args, FLAG_GRID, NULL);
    cli_scene scene;
    ff_table table;
    ff_error err = {0};
    int named;
    ff_status failed = read_grid(grid, format, o, &named, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    if (o->sigma && !named && format->layout && !(format->holds & FF_HOLDS_SIGMA))
        return cli_usage(args, "--sigma: the format '%s' has no room for standard deviations; --format csv has", format->name);
    int status = cli_scene_make(args, args->word[0], strcmp(format->name, "merl") ? 1 : 3, &scene); /* MERL has three channels */
    if (status) return status;
    o->nonnegative = format->layout && !(format->holds & FF_HOLDS_NEGATIVE);
    failed = make_table(&scene, format, grid, o, named, &table, &err);
    if ((o->walk && o->walk->progress) || (o->surface && o->surface->progress)) cli_progress_end();
    cli_scene_free(&scene);
    if (failed != FF_OK) return cli_failed(failed, &err);
    failed = ff_table_write_with(path, format->name, &table, args->outputs, &err);
    status = failed == FF_OK ? cli_outputs_commit(args) : not_written(format, named, failed, &err);
    if (status == EXIT_DONE) cli_notes(path, &table);
    ff_table_clear(&table);
    return status;
}

int cmd_simulate(const cli_args *args)
{
    const char *path = cli_value(args, FLAG_OUTPUT, NULL);
    const ff_format *format = NULL;
    ff_simulate_options o;
    ff_noise *noise = NULL;
    ff_aperture aperture;
    ff_walk_options walk;
    ff_height_field_options surface;
    if (!path) return cli_usage(args, "-o FILE is missing: where to write");
    int status = read_options(args, &o, &aperture, &walk, &surface);
    if (!status) status = read_noise(args, &o, &noise);
    if (!status) status = cli_format_for_writing(args, FLAG_FORMAT, path, &format);
    if (!status) status = simulate(args, path, format, &o);
    ff_noise_free(noise);
    return status;
}
