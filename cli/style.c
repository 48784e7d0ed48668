/* How text on stdout is laid out, and whether progress is shown: by the flags and the terminal. */
#include "internal_flags.h"
#include <stdlib.h>
#include <unistd.h>

ff_report_style cli_style(const cli_args *args)
{
    enum { AUTO, ALWAYS };
    const char *no_color = getenv("NO_COLOR"); /* no-color.org: present and not empty */
    const int asked = cli_word(args, FLAG_COLOR, AUTO), may = !(no_color && *no_color) && cli_terminal_is_smart(STDOUT_FILENO);
    return (ff_report_style){.width = cli_switch(args, FLAG_WIDE, 0) ? 0 : cli_terminal_width(STDOUT_FILENO),
                             .color = asked == ALWAYS || (asked == AUTO && may)};
}

int cli_progress_wanted(const cli_args *args)
{
    return !cli_given(args, FLAG_QUIET) && cli_switch(args, FLAG_PROGRESS, cli_terminal_is_smart(STDERR_FILENO));
}
