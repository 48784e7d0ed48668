/* Random walks: what the flags say of them, and their progress. */
#include "internal_walking.h"

static void show(void *context, double done)
{
    (void)context;
    cli_progress_show("%.0f %% of the paths", 100 * done);
}

int cli_walk_read(const cli_args *args, uint64_t paths, const char *orders, ff_walk_options *o)
{
    static const cli_flag_id needs[] = {FLAG_PATHS, FLAG_ORDERS, FLAG_FACETS, FLAG_DESCENT};
    const char *text = cli_value(args, FLAG_ORDERS, orders);
    ff_error err = {0};
    ff_walk_options_init(o);
    for (size_t k = 0; k < sizeof needs / sizeof needs[0] && !cli_given(args, FLAG_WALK); k++)
        if (cli_given(args, needs[k])) return cli_usage(args, "--%s is for --walk, which is not given", cli_flag_name(needs[k]));
    if (ff_orders_parse(text, o->orders, &o->n_orders, &err)) return cli_usage(args, "--orders %s: %s", text, err.message);
    o->facets = (ff_facets)cli_word(args, FLAG_FACETS, FF_FACETS_MIRROR);
    o->descent = (ff_walk_descent)cli_word(args, FLAG_DESCENT, FF_DESCENT_PROJECTED);
    o->seed = cli_integer(args, FLAG_SEED, o->seed);
    o->paths = cli_integer(args, FLAG_PATHS, paths);
    o->threads = (int)cli_integer(args, FLAG_THREADS, 0);
    if (cli_given(args, FLAG_WALK) && cli_progress_wanted(args)) o->progress = show;
    return cli_isa(args, &o->isa);
}
