/* What runs each command. */
#include "internal_cli.h"

int cli_command_run(const cli_args *args)
{
    static int (*const run[COMMAND_COUNT])(const cli_args *args) = {
#define COMMAND(ID, ...) [COMMAND_##ID] = cmd_##ID,
#include "commands.def"
#undef COMMAND
    };
    return cli_outputs_end(args, run[args->command->id](args));
}
