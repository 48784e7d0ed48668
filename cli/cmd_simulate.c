/* facetfit simulate EXPR --grid NAME -o FILE: a data set from a model. */
#include "internal_cli.h"
#include "ff_simulate.h"
#include <string.h>

/* The format by --format or by the extension; CSV on stdout. */
static int find_format(const cli_args *args, const char *path, const ff_format **out)
{
    const char *name = cli_value(args, FLAG_FORMAT, strcmp(path, "-") ? NULL : "csv");
    const ff_format *format = name ? ff_format_find(name) : ff_format_for_writing(path);
    char known[256] = "";
    if (format && format->write) {
        *out = format;
        return EXIT_DONE;
    }
    for (size_t i = 0; i < ff_format_count(); ++i) {
        const ff_format *f = ff_format_at(i);
        if (f->write)
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s (%s)", *known ? ", " : "", f->name, f->extensions);
    }
    if (name) return cli_usage(args, "--format %s cannot be written; expected one of %s", name, known);
    return cli_usage(args, "%s: no format has this extension; expected one of %s, or --format", path, known);
}

static int read_options(const cli_args *args, ff_simulate_options *o)
{
    const char *grid = cli_value(args, FLAG_GRID, NULL);
    ff_error err = {0};
    int status;
    ff_simulate_options_init(o);
    if ((status = cli_number(args, FLAG_NOISE, 0, 1e6, &o->relative)) ||
        (status = cli_number(args, FLAG_NOISE_FLOOR, 0, 1e6, &o->floor)) ||
        (status = cli_integer(args, FLAG_SEED, UINT64_MAX, &o->seed)) || (status = cli_isa(args, &o->isa)))
        return status;
    o->sigma = cli_given(args, FLAG_SIGMA) > 0;
    const ff_status failed = grid ? ff_sampling_parse(grid, &o->sampling, &err) : FF_OK;
    return failed == FF_OK ? EXIT_DONE : cli_failed(failed, &err);
}

int cmd_simulate(const cli_args *args)
{
    const char *path = cli_value(args, FLAG_OUTPUT, NULL);
    const ff_format *format = NULL;
    ff_simulate_options o;
    cli_scene scene;
    ff_table table;
    ff_error err = {0};
    int status;
    if (!path) return cli_usage(args, "-o FILE is missing: where to write");
    if ((status = read_options(args, &o)) || (status = find_format(args, path, &format))) return status;
    const int merl = !strcmp(format->name, "merl"); /* three channels, no negative values */
    if ((status = cli_scene_make(args, args->word[0], merl ? 3 : 1, &scene))) return status;
    o.nonnegative = merl;
    o.cancel = cli_catch_signals();
    ff_status failed = ff_simulate(&scene.model, scene.n_channels, scene.shape, scene.channel, &o, &table, &err);
    cli_scene_free(&scene);
    if (failed != FF_OK) return cli_failed(failed, &err);
    failed = ff_table_write(path, format->name, &table, &err);
    if (failed == FF_OK) cli_notes(path, table.note);
    ff_table_free(&table);
    return failed == FF_OK ? EXIT_DONE : cli_failed(failed, &err);
}
