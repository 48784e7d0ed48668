/* facetfit simulate EXPR --grid NAME -o FILE: a data set from a model. */
#include "internal_cli.h"
#include "simulate/simulate_struct.h"
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

static int read_options(const cli_args *args, ff_simulate_options *o, ff_aperture *aperture)
{
    const char *grid = cli_value(args, FLAG_GRID, NULL);
    ff_error err = {0};
    ff_simulate_options_init(o);
    int status = cli_isa(args, &o->isa);
    if (status == EXIT_DONE) status = cli_aperture(args, aperture);
    if (status != EXIT_DONE) return status;
    o->aperture = aperture;
    o->seed = cli_integer(args, FLAG_SEED, o->seed);
    o->sigma = cli_switch(args, FLAG_SIGMA, 0);
    const ff_status failed = grid ? ff_sampling_parse(grid, &o->sampling, &err) : FF_OK;
    return failed == FF_OK ? EXIT_DONE : cli_failed(failed, &err);
}

static int simulate(const cli_args *args, const char *path, const ff_format *format, ff_simulate_options *o)
{
    const int merl = !strcmp(format->name, "merl"); /* three channels, no negative values */
    cli_scene scene;
    ff_table table;
    ff_error err = {0};
    int status = cli_scene_make(args, args->word[0], merl ? 3 : 1, &scene);
    if (status) return status;
    o->nonnegative = merl;
    ff_status failed = ff_simulate_into(&scene.model, scene.n_channels, scene.shape, scene.channel, o, &table, &err);
    cli_scene_free(&scene);
    if (failed != FF_OK) return cli_failed(failed, &err);
    failed = ff_table_write_with(path, format->name, &table, args->outputs, &err);
    status = failed == FF_OK ? cli_outputs_commit(args) : cli_failed(failed, &err);
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
    if (!path) return cli_usage(args, "-o FILE is missing: where to write");
    int status = read_options(args, &o, &aperture);
    if (!status) status = read_noise(args, &o, &noise);
    if (!status) status = cli_format_for_writing(args, FLAG_FORMAT, path, &format);
    if (!status) status = simulate(args, path, format, &o);
    ff_noise_free(noise);
    return status;
}
