/* The written forms of values: numbers, lists of them, assignments. Every number of a command line is read here. */
#define _GNU_SOURCE
#include "internal_flags.h"
#include "base/internal_number.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

int cli_number_read(const char *text, double *out)
{
    return cli_numbers_read(text, '\0', 1, out) == 1;
}

size_t cli_numbers_read(const char *text, char separator, size_t most, double *out)
{
    for (size_t n = 0; n < most; text++) {
        text = ff_number_read(text, &out[n++]);
        if (!text || !isfinite(out[n - 1])) return 0;
        if (!*text) return n;
        if (*text != separator) return 0;
    }
    return 0;
}

int cli_is_list(const char *text)
{
    const size_t n = strlen(text);
    return n >= 2 && text[0] == '{' && text[n - 1] == '}';
}

size_t cli_list_read(const char *text, size_t most, double *out)
{
    if (!cli_is_list(text)) return cli_numbers_read(text, ',', most, out);
    char *inside = strndup(text + 1, strlen(text) - 2);
    const size_t n = inside ? cli_numbers_read(inside, ',', most, out) : 0;
    free(inside);
    return n;
}

/* Copies length characters; 0 when there is none or they do not fit. */
static int take_name(const char *text, size_t length, char out[CLI_NAME])
{
    if (length == 0 || length >= CLI_NAME) return 0;
    memcpy(out, text, length);
    out[length] = '\0';
    return 1;
}

int cli_assignment_read(const char *word, cli_assignment *out)
{
    const size_t name = strcspn(word, "[=");
    const char *rest = word + name;
    *out = (cli_assignment){.rest = NULL};
    if (!take_name(word, name, out->name)) return 0;
    if (*rest == '[') {
        const size_t channel = strcspn(rest + 1, "]");
        if (rest[1 + channel] != ']' || !take_name(rest + 1, channel, out->channel)) return 0;
        rest += channel + 2;
    }
    if (*rest && *rest != '=') return 0;
    out->rest = *rest ? rest + 1 : NULL;
    return 1;
}

/* The length of the first word of a list: up to a comma that is not within braces. */
static size_t first_word(const char *text)
{
    size_t n = 0;
    for (int inside = 0; text[n] && (inside || text[n] != ','); n++) inside = text[n] == '{' ? 1 : text[n] == '}' ? 0 : inside;
    return n;
}

static int each_word_of(const cli_args *args, const char *text, int (*apply)(const cli_args *, const char *, void *), void *context)
{
    int status = EXIT_DONE;
    while (status == EXIT_DONE && *text) {
        const size_t n = first_word(text);
        char *word = strndup(text, n);
        if (!word) return cli_failed(FF_ERR_MEMORY, NULL);
        if (n) status = apply(args, word, context);
        free(word);
        text += n + (text[n] == ',');
    }
    return status;
}

int cli_each_word(const cli_args *args, cli_flag_id flag, int (*apply)(const cli_args *args, const char *word, void *context),
                  void *context)
{
    int status = EXIT_DONE;
    for (size_t i = 0; i < args->n_given && status == EXIT_DONE; i++)
        if (args->flag[i] == (int)flag) status = each_word_of(args, args->value[i], apply, context);
    return status;
}
