/* Measured data as the flags want them. */
#include "internal_cli.h"
#include "data_formats/analysis/spectral_struct.h"
#include <string.h>

static void read_options(const cli_args *args, ff_read_options *o)
{
    ff_read_options_init(o);
    o->format = cli_value(args, FLAG_FORMAT, NULL);
    o->columns = cli_value(args, FLAG_COLUMNS, NULL);
    o->dialect = cli_value(args, FLAG_DIALECT, NULL);
    o->azimuth = cli_word(args, FLAG_AZIMUTH, -1) + 1;
    o->phi = cli_word(args, FLAG_PHI, -1) + 1;
    o->angles = cli_word(args, FLAG_ANGLES, -1) + 1;
    o->part = cli_value(args, FLAG_PART, NULL);
    o->ask = cli_files_ask;
    o->ask_context = args;
    if (args->command->id != COMMAND_resample) o->grid = cli_value(args, FLAG_GRID, NULL); /* there it is the grid of OUT */
    o->quantity = cli_word(args, FLAG_QUANTITY, o->quantity);
    o->scale = cli_number(args, FLAG_SCALE, o->scale);
}

/* Replaces *t by what --reduce makes of it. */
static ff_status reduce(const char *to, ff_table *t, ff_error *err)
{
    ff_table reduced;
    const ff_status failed = ff_table_reduce_into(t, to, &reduced, err);
    ff_table_clear(t);
    if (failed == FF_OK) *t = reduced;
    return failed;
}

/* All that a command is given which reads nothing else. */
int cli_joins_files(const cli_command *command)
{
    const cli_command_id id = command->id;
    return id == COMMAND_fit || id == COMMAND_compare || id == COMMAND_ndf || id == COMMAND_info;
}

/* Is a file that cannot be read one of a kind that there is no use for, as of transmission alone? What a flag asks of it in vain,
 * and a pipe whose format a flag has to say, are usage. */
static int is_the_input(const cli_args *args, const char *path, ff_status failed)
{
    static const cli_flag_id asks[] = {FLAG_COLUMNS, FLAG_DIALECT, FLAG_GRID, FLAG_PART, FLAG_QUANTITY};
    if (failed != FF_ERR_UNSUPPORTED || (!strcmp(path, "-") && !cli_given(args, FLAG_FORMAT))) return 0;
    for (size_t k = 0; k < sizeof asks / sizeof *asks; k++)
        if (cli_given(args, asks[k])) return 0;
    return 1;
}

int cli_read(const cli_args *args, const char *path, int with_notes, ff_table *out)
{
    ff_read_options o;
    ff_table t;
    ff_error err = {0};
    const char *to = cli_value(args, FLAG_REDUCE, NULL);
    read_options(args, &o);
    const size_t n = cli_joins_files(args->command) ? args->n_words : 1;
    ff_status failed = ff_table_read_all_into(n > 1 ? args->word : &path, n, &o, &t, &err);
    const int of_input = is_the_input(args, path, failed);
    if (failed == FF_OK) {
        const int status = cli_calibrate(args, &o, &t);
        if (status != EXIT_DONE) {
            ff_table_clear(&t);
            return status;
        }
    }
    if (failed == FF_OK && to) failed = reduce(to, &t, &err);
    if (failed != FF_OK) {
        if (!err.path[0]) snprintf(err.path, sizeof err.path, "%s", path);
        const int status = cli_failed(failed, &err);
        return of_input ? EXIT_INPUT : status;
    }
    if (with_notes) cli_notes(path, &t);
    *out = t;
    return EXIT_DONE;
}

int cli_format_for_writing(const cli_args *args, cli_flag_id flag, const char *path, const ff_format **out)
{
    const char *name = cli_value(args, flag, strcmp(path, "-") ? NULL : "csv");
    const ff_format *format = name ? ff_format_find(name) : ff_format_for_writing(path);
    char known[512] = "";
    if (format && format->write) {
        *out = format;
        return EXIT_DONE;
    }
    for (size_t i = 0; i < ff_format_count(); i++) {
        const ff_format *f = ff_format_at(i);
        if (f->write)
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s (%s)", *known ? ", " : "", f->name, f->extensions);
    }
    if (name) return cli_usage(args, "--%s %s cannot be written; expected one of %s", cli_flag_name(flag), name, known);
    return cli_usage(args, "%s: no format has this extension; expected one of %s, or --%s", path, known, cli_flag_name(flag));
}
