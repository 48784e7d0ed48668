/* Values of flags: is each one of its kind, and which was given. */
#include "internal_flags.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- numbers --------------------------------------------------------------------------------- */

static int inside(const cli_flag *f, double x)
{
    return x <= f->hi && (f->above ? x > f->lo : x >= f->lo);
}

/* "a number from 0 to 1", "an angle above 0" */
static const char *expected_number(const cli_flag *f, char *out, size_t size)
{
    char lo[FF_REPORT_NUMBER], hi[FF_REPORT_NUMBER];
    const char *what = f->kind == KIND_ANGLE ? "a number of degrees" : f->kind == KIND_NUMBERS ? "numbers" : "a number";
    ff_report_number(f->lo, lo);
    ff_report_number(f->hi, hi);
    if (isinf(f->hi))
        snprintf(out, size, "%s %s %s", what, f->above ? "above" : "from", lo);
    else
        snprintf(out, size, f->above ? "%s above %s, up to %s" : "%s from %s to %s", what, lo, hi);
    if (f->kind == KIND_NUMBERS) strncat(out, ", separated by commas", size - strlen(out) - 1);
    return out;
}

static int check_numbers(const cli_args *args, const cli_flag *f, const char *text)
{
    double *x = malloc(CLI_VALUES * sizeof *x);
    if (!x) return cli_failed(FF_ERR_MEMORY, NULL);
    const size_t n = f->kind == KIND_NUMBERS ? cli_list_read(text, CLI_VALUES, x) : (size_t)cli_number_read(text, x);
    char expected[160];
    int good = n > 0;
    for (size_t i = 0; i < n; i++) good &= inside(f, x[i]);
    free(x);
    if (good) return EXIT_DONE;
    if (f->kind != KIND_NUMBERS && cli_is_list(text))
        return cli_usage(args, "--%s %s: a list of values has no meaning here; expected %s", f->name, text,
                         expected_number(f, expected, sizeof expected));
    return cli_usage(args, "--%s %s: expected %s", f->name, text, expected_number(f, expected, sizeof expected));
}

static int read_integer(const char *text, uint64_t *out)
{
    uint64_t n = 0;
    for (const char *p = text; *p; p++) {
        const uint64_t digit = (uint64_t)(*p - '0');
        if (*p < '0' || *p > '9' || n > (UINT64_MAX - digit) / 10) return 0;
        n = 10 * n + digit;
    }
    *out = n;
    return *text != '\0';
}

static int check_integer(const cli_args *args, const cli_flag *f, const char *text)
{
    const uint64_t lo = (uint64_t)f->lo, hi = f->hi > 0 ? (uint64_t)f->hi : UINT64_MAX;
    uint64_t n;
    if (read_integer(text, &n) && n >= lo && n <= hi) return EXIT_DONE;
    return cli_usage(args, "--%s %s: expected a whole number from %llu to %llu", f->name, text, (unsigned long long)lo,
                     (unsigned long long)hi);
}

/* ---- words ----------------------------------------------------------------------------------- */

enum { LISTED = 600 };

/* "that is for fit; " where another command knows the word, else "". */
static const char *elsewhere(const cli_flag *f, const char *word, size_t length, char *out, size_t size)
{
    char where[96] = "";
    for (size_t i = 0; i < cli_command_count(); i++) {
        const cli_command *command = cli_command_at(i);
        for (int k = 0; k < FLAG_COUNT; k++) {
            const cli_flag other = cli_flag_of((cli_flag_id)k, command);
            if (strcmp(other.name, f->name) || !cli_flag_has(&other, command) || !other.words || other.kind == KIND_TEXT) continue;
            if (cli_words_find(other.words, word, length) >= 0)
                snprintf(where + strlen(where), sizeof where - strlen(where), "%s%s", *where ? ", " : "", command->name);
        }
    }
    *out = '\0';
    if (*where) snprintf(out, size, "that is for %s; ", where);
    return out;
}

static int unknown_word(const cli_args *args, const cli_flag *f, const char *value, const char *word, size_t length)
{
    char known[LISTED], other[160];
    const char *nearest = cli_words_nearest(f->words, word, length);
    cli_words_list(f->words, known, sizeof known);
    elsewhere(f, word, length, other, sizeof other);
    if (!nearest) return cli_usage(args, "--%s %s: %sexpected one of %s", f->name, value, other, known);
    return cli_usage(args, "--%s %s: %sexpected one of %s; did you mean '%s'?", f->name, value, other, known, nearest);
}

static int check_words(const cli_args *args, const cli_flag *f, const char *value)
{
    for (const char *word = value;; word++) {
        const size_t n = f->kind == KIND_WORD ? strlen(word) : strcspn(word, f->kind == KIND_WORDS ? "," : ":");
        const int is_group = f->kind == KIND_WORDS && cli_words_is_group(f->words, word, n);
        if (!is_group && cli_words_find(f->words, word, n) < 0) return unknown_word(args, f, value, word, n);
        word += n;
        if (!*word || f->kind == KIND_WORD_DETAIL) return EXIT_DONE;
    }
}

int cli_value_check(const cli_args *args, const cli_flag *flag, const char *value)
{
    switch (flag->kind) {
    case KIND_NUMBER:
    case KIND_ANGLE:
    case KIND_NUMBERS:
        return check_numbers(args, flag, value);
    case KIND_INTEGER:
        return check_integer(args, flag, value);
    case KIND_WORD:
    case KIND_WORDS:
    case KIND_WORD_DETAIL:
        return check_words(args, flag, value);
    case KIND_EXPRESSION:
        return cli_expression_check(flag->name, value);
    case KIND_INPUT_FILE:
    case KIND_OUTPUT_FILE:
    case KIND_FOLDER:
        return *value ? EXIT_DONE : cli_usage(args, "--%s: the name of a file is empty", flag->name);
    default:
        return EXIT_DONE;
    }
}

/* ---- what was given -------------------------------------------------------------------------- */

int cli_given(const cli_args *args, cli_flag_id id)
{
    int n = 0;
    for (size_t i = 0; i < args->n_given; i++) n += args->flag[i] == (int)id;
    return n;
}

const char *cli_value(const cli_args *args, cli_flag_id id, const char *otherwise)
{
    for (size_t i = args->n_given; i-- > 0;)
        if (args->flag[i] == (int)id) return args->value[i];
    return otherwise;
}

int cli_switch(const cli_args *args, cli_flag_id flag, int otherwise)
{
    return cli_given(args, flag) ? cli_value(args, flag, NULL) == NULL : otherwise;
}

double cli_number(const cli_args *args, cli_flag_id flag, double otherwise)
{
    const char *text = cli_value(args, flag, NULL);
    double x = otherwise;
    if (text) cli_number_read(text, &x);
    return x;
}

uint64_t cli_integer(const cli_args *args, cli_flag_id flag, uint64_t otherwise)
{
    const char *text = cli_value(args, flag, NULL);
    uint64_t n = otherwise;
    if (text) read_integer(text, &n);
    return n;
}

int cli_word(const cli_args *args, cli_flag_id flag, int otherwise)
{
    const char *text = cli_value(args, flag, NULL);
    const cli_flag f = cli_flag_of(flag, args->command);
    return text ? cli_words_find(f.words, text, strcspn(text, f.kind == KIND_WORD_DETAIL ? ":" : "")) : otherwise;
}
