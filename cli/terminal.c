/* The terminal that a command speaks to: its width, and the one line of progress. */
#define _GNU_SOURCE
#include "internal_flags.h"
#include "report/internal_text.h"
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { NARROWEST = 20, WIDEST = 100000 };

/* COLUMNS says it as a shell would, also of a file. */
size_t cli_terminal_width(int descriptor)
{
    struct winsize size = {.ws_col = 0};
    const char *said = getenv("COLUMNS");
    const long columns = said ? strtol(said, NULL, 10) : 0;
    if (columns >= NARROWEST && columns <= WIDEST) return (size_t)columns;
    if (!isatty(descriptor) || ioctl(descriptor, TIOCGWINSZ, &size)) return 0;
    return size.ws_col >= NARROWEST ? size.ws_col : 0;
}

int cli_terminal_is_smart(int descriptor)
{
    const char *term = getenv("TERM");
    return isatty(descriptor) && term && *term && strcmp(term, "dumb") != 0;
}

volatile sig_atomic_t cli_progress_is_shown;

void cli_progress_show(const char *format, ...)
{
    char line[1024];
    const size_t width = cli_terminal_width(STDERR_FILENO);
    va_list args;
    va_start(args, format);
    vsnprintf(line, sizeof line, format, args);
    va_end(args);
    /* the last column stays free: a terminal may wrap when it is filled */
    if (width) line[ff_text_fitting(line, width - 1)] = '\0';
    cli_progress_is_shown = 1;
    fputs("\r\033[K", stderr);
    ff_text_print(line, stderr);
    fflush(stderr);
}

void cli_progress_end(void)
{
    fputs("\r\033[K", stderr);
    fflush(stderr);
    cli_progress_is_shown = 0;
}
