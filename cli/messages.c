/* What the program says on stderr, and its exit status. */
#define _GNU_SOURCE /* vasprintf */
#include "internal_flags.h"
#include "base/internal_kept.h"
#include "report/internal_text.h"
#include "report/words/words_struct.h"
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A whole message; NULL: no memory. */
static char *message_of(const char *format, va_list args)
{
    char *text = NULL;
    va_list again;
    va_copy(again, args);
    const int n = vasprintf(&text, format, again);
    va_end(again);
    return n < 0 ? NULL : text;
}

/* A word of a hundred thousand characters, as of a list that a script has put together wrongly, hides what is said about it: the
 * middle of longer ones than any path of ordinary length is left out. */
static void shorten_words(char *text)
{
    enum { MOST = 1024, BEGINNING = 480, END = 80 };
    static const char gap[] = " ... ";
    char *to = text;
    for (const char *from = text; *from;) {
        const size_t n = strcspn(from, " \n"), blanks = strspn(from + n, " \n");
        if (n > MOST) {
            memmove(to, from, BEGINNING);
            memcpy(to + BEGINNING, gap, sizeof gap - 1);
            memmove(to + BEGINNING + sizeof gap - 1, from + n - END, END + blanks);
            to += BEGINNING + sizeof gap - 1 + END + blanks;
        } else {
            memmove(to, from, n + blanks);
            to += n + blanks;
        }
        from += n + blanks;
    }
    *to = '\0';
}

static ff_status write_line(const void *text, FILE *out)
{
    fputs("facetfit: ", out);
    ff_text_print(text, out);
    fputc('\n', out);
    return FF_OK;
}

static _Thread_local FILE *listener;

FILE *cli_messages_into(FILE *out)
{
    FILE *before = listener;
    listener = out;
    return before;
}

/* Names and values are whatever the person, a script or an archive gave: none of it speaks to the terminal. */
static void put_message(const char *format, va_list args)
{
    char cut[1024];
    char *text = message_of(format, args);
    if (!text) vsnprintf(cut, sizeof cut, format, args);
    if (text) shorten_words(text);
    if (listener) {
        fprintf(listener, "%s\n", text ? text : cut);
        free(text);
        return;
    }
    /* in a file or a pipe a message is one line, which can be looked for */
    const ff_report_style style = {.width = isatty(STDERR_FILENO) ? cli_terminal_width(STDERR_FILENO) : 0};
    if (ff_report_fold(write_line, text ? text : cut, &style, stderr)) write_line(text ? text : cut, stderr);
    free(text);
}

void cli_message(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    put_message(format, args);
    va_end(args);
}

/* Said to a person, "facetfit: error: ..."; whoever else listens knows what it is. */
static void put_as(const char *kind, const char *format, va_list args)
{
    char *text = message_of(format, args);
    if (text)
        cli_message("%s%s%s", listener ? "" : kind, listener ? "" : ": ", text);
    else
        cli_message("%s: no memory left for the message", kind);
    free(text);
}

void cli_error(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    put_as("error", format, args);
    va_end(args);
}

void cli_warning(const char *format, ...)
{
    va_list args;
    va_start(args, format);
    put_as("warning", format, args);
    va_end(args);
}

static int notes_are_left_out;

void cli_notes_wanted(int wanted)
{
    notes_are_left_out = !wanted;
}

void cli_note(const char *format, ...)
{
    va_list args;
    if (notes_are_left_out) return;
    va_start(args, format);
    put_as("note", format, args);
    va_end(args);
}

int cli_usage(const cli_args *args, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    put_as("error", format, list);
    va_end(list);
    if (!listener) cli_message("see 'facetfit %s --help'", args->command->name);
    return EXIT_USAGE;
}

int cli_exit_status(ff_status status)
{
    switch (status) {
    case FF_OK:
        return EXIT_DONE;
    case FF_ERR_RANGE:
    case FF_ERR_UNKNOWN:
    case FF_ERR_SYNTAX:
    case FF_ERR_UNSUPPORTED:
        return EXIT_USAGE;
    case FF_ERR_OPEN:
    case FF_ERR_READ:
    case FF_ERR_FORMAT:
    case FF_ERR_DATA:
        return EXIT_INPUT;
    case FF_ERR_WRITE:
        return EXIT_OUTPUT;
    case FF_ERR_CANCELLED:
        return 128 + SIGINT;
    default:
        return EXIT_INTERNAL;
    }
}

int cli_failed(ff_status status, const ff_error *err)
{
    char text[FF_ERROR_PATH + FF_ERROR_MESSAGE + 128] = "";
    if (err) {
        ff_error named = *err;
        if (!strcmp(named.path, "-")) strcpy(named.path, status == FF_ERR_WRITE ? "standard output" : "standard input");
        ff_words_error(&named, text, sizeof text);
    }
    cli_error("%s", *text ? text : ff_status_str(status));
    return cli_exit_status(status);
}

/* One message, however many sentences. */
void cli_notes(const char *path, const ff_table *t)
{
    char text[FF_WORDS_SENTENCE];
    ff_kept all;
    FILE *out = ff_kept_open(&all);
    for (size_t k = 0; out && ff_words_note(t, k, text); k++) fprintf(out, "%s%s", k ? "; " : "", text);
    if (ff_kept_close(&all, out) == FF_OK && all.n) cli_note("%s: %s", path, all.text);
    free(all.text);
}
