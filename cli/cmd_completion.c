/* facetfit completion SHELL: a script that completes command lines. */
#include "internal_cli.h"
#include <string.h>

static ff_status write_script(const void *context, FILE *out)
{
    cli_complete(*(const int *)context, out);
    return FF_OK;
}

int cmd_completion(const cli_args *args)
{
    const int shell = cli_words_find(cli_words_shell, args->word[0], strlen(args->word[0]));
    return cli_print(write_script, &shell);
}
