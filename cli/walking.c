/* Random walks: what the flags say of them, and their progress. */
#include "internal_walking.h"
#include <string.h>

static void show(void *context, double done)
{
    (void)context;
    cli_progress_show("%.0f %% of the paths", 100 * done);
}

int cli_walk_read(const cli_args *args, uint64_t paths, const char *orders, ff_walk_options *o)
{
    static const cli_flag_id needs[] = {FLAG_PATHS, FLAG_ORDERS, FLAG_FACETS, FLAG_DESCENT};
    const int paths_go = cli_given(args, FLAG_WALK) || cli_given(args, FLAG_SURFACE);
    const char *text = cli_value(args, FLAG_ORDERS, orders);
    ff_error err = {0};
    ff_walk_options_init(o);
    for (size_t k = 0; k < sizeof needs / sizeof needs[0] && !paths_go; k++)
        if (cli_given(args, needs[k]))
            return cli_usage(args, "--%s is for --walk and --surface, of which none is given", cli_flag_name(needs[k]));
    if (cli_given(args, FLAG_WALK) && cli_given(args, FLAG_SURFACE))
        return cli_usage(args, "--walk and --surface are two kinds of surfaces: one of them");
    if (cli_given(args, FLAG_DESCENT) && cli_given(args, FLAG_SURFACE))
        return cli_usage(args, "--descent is of --walk, not of --surface");
    if (ff_orders_parse(text, o->orders, &o->n_orders, &err)) return cli_usage(args, "--orders %s: %s", text, err.message);
    o->facets = (ff_facets)cli_word(args, FLAG_FACETS, FF_FACETS_MIRROR);
    o->descent = (ff_walk_descent)cli_word(args, FLAG_DESCENT, FF_DESCENT_PROJECTED);
    o->seed = cli_integer(args, FLAG_SEED, o->seed);
    o->paths = cli_integer(args, FLAG_PATHS, paths);
    o->threads = (int)cli_integer(args, FLAG_THREADS, 0);
    if (cli_given(args, FLAG_WALK) && cli_progress_wanted(args)) o->progress = show;
    return cli_isa(args, &o->isa);
}

/* Flags of --surface without it. */
static int check_alone(const cli_args *args)
{
    static const cli_flag_id needs[] = {FLAG_CORRELATION, FLAG_CELLS,       FLAG_REALISATIONS, FLAG_HURST,
                                        FLAG_PITCH,       FLAG_HEIGHT_UNIT, FLAG_VISIBLE,      FLAG_NORMALS};
    for (size_t k = 0; k < sizeof needs / sizeof needs[0] && !cli_given(args, FLAG_SURFACE); k++)
        if (cli_given(args, needs[k])) return cli_usage(args, "--%s is for --surface, which is not given", cli_flag_name(needs[k]));
    return EXIT_DONE;
}

static int read_pitch(const cli_args *args, ff_height_field_options *o)
{
    const char *text = cli_value(args, FLAG_PITCH, NULL);
    if (!text) return EXIT_DONE;
    const size_t n = cli_numbers_read(text, ':', 2, o->pitch);
    if (n == 1) o->pitch[1] = o->pitch[0];
    if (n == 0 || !(o->pitch[0] > 0) || !(o->pitch[1] > 0))
        return cli_usage(args, "--pitch %s: expected DX or DX:DY, above 0", text);
    return EXIT_DONE;
}

int cli_surface_read(const cli_args *args, const ff_walk_options *walk, ff_height_field_options *o)
{
    const char *name = cli_value(args, FLAG_SURFACE, NULL), *to = cli_value(args, FLAG_OUTPUT, NULL);
    ff_height_field_options_init(o);
    int status = check_alone(args);
    if (status || !name) return status;
    const int spectrum = cli_words_find(cli_words_surface, name, strlen(name));
    if (spectrum < 0) o->map = name;
    if (spectrum >= 0) o->spectrum = (ff_spectrum)spectrum;
    if (o->map && to && !strcmp(o->map, to)) return cli_usage(args, "-o %s would replace the map that is read", to);
    o->correlation = cli_number(args, FLAG_CORRELATION, o->correlation);
    o->cells = (size_t)cli_integer(args, FLAG_CELLS, o->cells);
    o->realisations = (size_t)cli_integer(args, FLAG_REALISATIONS, o->realisations);
    o->hurst = cli_number(args, FLAG_HURST, o->hurst);
    o->height_unit = cli_number(args, FLAG_HEIGHT_UNIT, o->height_unit);
    o->facets = walk->facets;
    o->seed = walk->seed;
    o->paths = walk->paths;
    o->n_orders = walk->n_orders;
    memcpy(o->orders, walk->orders, sizeof o->orders);
    o->threads = walk->threads;
    if (cli_progress_wanted(args)) o->progress = show;
    if (o->paths < o->realisations)
        return cli_usage(args, "--paths %llu: expected one for each of %zu realisations", (unsigned long long)o->paths,
                         o->realisations);
    return read_pitch(args, o);
}
