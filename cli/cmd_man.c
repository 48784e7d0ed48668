/* facetfit man [COMMAND]: manual pages. */
#include "internal_cli.h"

static ff_status write_page(const void *context, FILE *out)
{
    const cli_args *args = context;
    if (cli_given(args, FLAG_MARKDOWN)) return cli_page(out);
    if (args->n_words)
        cli_man_command(cli_command_find(args->word[0]), args->head.version, out);
    else
        cli_man(args->head.version, out);
    return FF_OK;
}

int cmd_man(const cli_args *args)
{
    if (cli_given(args, FLAG_MARKDOWN) && args->n_words)
        return cli_usage(args, "--markdown writes one page of all commands; leave out '%s'", args->word[0]);
    return cli_print(write_page, args);
}
