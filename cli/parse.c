/* A command line taken apart by the table of flags. */
#define _GNU_SOURCE /* strdup */
#include "internal_flags.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { LISTED = 4096 };

/* ---- which flag ------------------------------------------------------------------------------ */

/* The flag of this name: of those that go by it, one that the command has. *off: it was "no-NAME". -1 when there is none. */
static int find_long(const cli_command *command, const char *name, size_t length, int *off)
{
    int found = -1;
    const int negated = length > 3 && !strncmp(name, "no-", 3);
    for (int pass = 0; pass < 2; pass++) /* names of today before older ones */
        for (int i = 0; i < FLAG_COUNT; i++) {
            const cli_flag *f = cli_flag_at((cli_flag_id)i);
            const char *own = pass ? f->older : f->name;
            const size_t n = own ? strlen(own) : 0;
            const int plain = n == length && n && !strncmp(own, name, n);
            const int no = negated && f->negatable && n == length - 3 && !strncmp(own, name + 3, n);
            if (!plain && !no) continue;
            *off = no;
            if (cli_flag_has(f, command)) return i;
            if (found < 0) found = i;
        }
    return found;
}

static int find_letter(char letter)
{
    for (int i = 0; i < FLAG_COUNT; i++)
        if (letter && cli_flag_at((cli_flag_id)i)->letter == letter) return i;
    return -1;
}

static int unknown_flag(const cli_args *args, const char *word)
{
    const char *names[2 * FLAG_COUNT];
    char bare[CLI_NAME];
    size_t n = 0;
    for (int i = 0; i < FLAG_COUNT; i++) {
        const cli_flag *f = cli_flag_at((cli_flag_id)i);
        if (cli_flag_has(f, args->command)) names[n++] = f->name;
    }
    snprintf(bare, sizeof bare, "%.*s", (int)strcspn(word + strspn(word, "-"), "="), word + strspn(word, "-"));
    const char *nearest = cli_nearest(bare, names, n);
    if (nearest) return cli_usage(args, "unknown flag %s; did you mean --%s?", word, nearest);
    return cli_usage(args, "unknown flag %s", word);
}

static int misplaced_flag(const cli_args *args, const cli_flag *f)
{
    char where[256] = "";
    for (size_t i = 0; i < cli_command_count(); i++)
        if (cli_flag_has(f, cli_command_at(i)))
            snprintf(where + strlen(where), sizeof where - strlen(where), "%s%s", *where ? ", " : "", cli_command_at(i)->name);
    return cli_usage(args, "--%s is not a flag of '%s'; it belongs to %s", f->name, args->command->name, where);
}

/* ---- its value ------------------------------------------------------------------------------- */

/* --table names the form of the report's tables; before that it named the profile of `tabulated`, and still does where a file of
 * that name is. */
static int which_table(const cli_args *args, int *id, const char *value)
{
    const cli_flag *format = cli_flag_at(FLAG_TABLE), *file = cli_flag_at(FLAG_NDF_TABLE);
    const int has_format = cli_flag_has(format, args->command), has_file = cli_flag_has(file, args->command);
    if (has_format && cli_words_find(format->words, value, strlen(value)) >= 0) {
        *id = FLAG_TABLE;
        return EXIT_DONE;
    }
    if (!has_file) return EXIT_DONE; /* the kind's own message */
    *id = FLAG_NDF_TABLE;
    if (!strcmp(value, "-") || access(value, F_OK) == 0) return EXIT_DONE;
    char known[128];
    const char *nearest = cli_words_nearest(format->words, value, strlen(value));
    cli_words_list(format->words, known, sizeof known);
    return cli_usage(args,
                     "--table %s: neither a form of tables (%s) nor a file that exists (the profile of `tabulated`: --ndf-table "
                     "FILE)%s%s%s",
                     value, known, nearest ? "; did you mean '" : "", nearest ? nearest : "", nearest ? "'?" : "");
}

static int has_no_value(const char *next)
{
    return !next || (next[0] == '-' && next[1] != '\0');
}

/* From after '=' or from the next word; a flag that has a value without one takes none from a flag that follows. */
static int find_value(const cli_args *args, const cli_flag *f, int off, const char *after, int argc, char **argv, int *i,
                      const char **value)
{
    *value = off ? "no" : after;
    if (f->kind == KIND_SWITCH) return after ? cli_usage(args, "--%s takes no value", f->name) : EXIT_DONE;
    if (after) return EXIT_DONE;
    const char *next = *i + 1 < argc ? argv[*i + 1] : NULL;
    if (f->without && has_no_value(next)) {
        *value = f->without;
        return EXIT_DONE;
    }
    if (!next) return cli_usage(args, "--%s needs a value: %s", f->name, f->placeholder);
    *value = next;
    (*i)++;
    return EXIT_DONE;
}

/* A value that is not used would go unnoticed: of a flag that takes one, a second is refused, whatever the flag. Of switches the
 * last one counts. */
static int given_twice(const cli_args *args, const cli_flag *f, const char *before, const char *value)
{
    const int is_list = f->kind == KIND_NUMBERS || f->kind == KIND_WORDS || f->kind == KIND_ASSIGNMENTS;
    return cli_usage(args, "--%s is given twice, '%s' and '%s', and takes one value%s", f->name, before, value,
                     is_list ? ": a list, separated by commas" : "");
}

/* A word of a list in the writing of the list, and the words of a group in its place: what is done with it need not know others. */
static int as_listed(cli_args *args, const cli_flag *f, const char **value)
{
    char known[LISTED];
    if (!*value || !f->words || (f->kind != KIND_WORD && f->kind != KIND_WORDS && f->kind != KIND_WORD_DETAIL)) return EXIT_DONE;
    if (!cli_words_known(f, *value, known, sizeof known) || !strcmp(known, *value)) return EXIT_DONE;
    char *own = strdup(known);
    if (!own) return cli_failed(FF_ERR_MEMORY, NULL);
    *value = args->own[args->n_own++] = own;
    return EXIT_DONE;
}

static int take(cli_args *args, int id, const char *value)
{
    const cli_flag f = cli_flag_of((cli_flag_id)id, args->command);
    const char *before = cli_value(args, (cli_flag_id)id, NULL);
    if (before && f.kind != KIND_SWITCH && !f.repeatable) return given_twice(args, &f, before, value);
    args->flag[args->n_given] = id;
    args->value[args->n_given++] = value;
    const int status = f.kind == KIND_SWITCH ? EXIT_DONE : cli_value_check(args, &f, value);
    return status == EXIT_DONE ? as_listed(args, &f, &args->value[args->n_given - 1]) : status;
}

/* One word that starts with '-', and what belongs to it. */
static int parse_flag(cli_args *args, int argc, char **argv, int *i)
{
    const char *word = argv[*i], *value = NULL;
    const int is_long = word[1] == '-';
    const size_t length = is_long ? strcspn(word + 2, "=") : 1;
    int off = 0, id = is_long ? find_long(args->command, word + 2, length, &off) : word[2] == '\0' ? find_letter(word[1]) : -1;
    if (id < 0) return unknown_flag(args, word);
    if (!cli_flag_has(cli_flag_at((cli_flag_id)id), args->command)) return misplaced_flag(args, cli_flag_at((cli_flag_id)id));
    const cli_flag f = cli_flag_of((cli_flag_id)id, args->command);
    if (id == FLAG_HELP) args->help_in_short = !is_long;
    const char *after = is_long && word[2 + length] == '=' ? word + 2 + length + 1 : NULL;
    int status = find_value(args, &f, off, after, argc, argv, i, &value);
    if (status == EXIT_DONE && value && is_long && length == 5 && !strncmp(word + 2, "table", length))
        status = which_table(args, &id, value);
    return status == EXIT_DONE ? take(args, id, value) : status;
}

/* ---- the whole line -------------------------------------------------------------------------- */

static size_t least_words(const cli_command *command)
{
    size_t n = 0;
    while (n < CLI_PLACES && command->place[n].name && !command->place[n].optional) n++;
    return n;
}

static size_t most_words(const cli_command *command)
{
    size_t n = command->repeats;
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name; k++) n++;
    return n;
}

/* Is every positional word what stands in its place? Files are looked at when they are opened. */
static int check_places(cli_args *args)
{
    for (size_t k = 0; k < args->n_words && k < CLI_PLACES; k++) {
        const cli_place *p = &args->command->place[k];
        const char *word = args->word[k];
        int status = EXIT_DONE;
        if (!word) continue; /* the model of --from */
        if (p->kind == KIND_EXPRESSION) status = cli_expression_check(NULL, word);
        if (p->kind == KIND_WORD && cli_words_find(p->words, word, strlen(word)) < 0) {
            char known[256];
            const char *nearest = cli_words_nearest(p->words, word, strlen(word));
            cli_words_list(p->words, known, sizeof known);
            status = cli_usage(args, "%s %s: expected one of %s%s%s%s", p->name, word, known, nearest ? "; did you mean '" : "",
                               nearest ? nearest : "", nearest ? "'?" : "");
        }
        if (status == EXIT_DONE && p->kind == KIND_WORD)
            status = as_listed(args, &(cli_flag){.kind = p->kind, .words = p->words}, &args->word[k]);
        if (status != EXIT_DONE) return status;
    }
    return EXIT_DONE;
}

/* "; '--json a.csv' writes to a.csv": a flag that can do without a value has taken the word that is missing. "" when none has. */
static const char *who_took_it(const cli_args *args, char *out, size_t size)
{
    *out = '\0';
    for (size_t i = 0; i < args->n_given; i++) {
        const cli_flag *f = cli_flag_at((cli_flag_id)args->flag[i]);
        if (f->without && strcmp(args->value[i], f->without))
            snprintf(out, size, "; '--%s %s' writes to %s, and --%s alone goes last", f->name, args->value[i], args->value[i],
                     f->name);
    }
    return out;
}

static int check_words(cli_args *args)
{
    char usage[128], taken[512];
    const cli_command *command = args->command;
    if (args->n_words < least_words(command)) {
        cli_command_usage(command, usage, sizeof usage);
        return cli_usage(args, "%s is missing: facetfit %s %s%s",
                         args->n_words || command->repeats ? command->place[args->n_words].name : usage, command->name, usage,
                         who_took_it(args, taken, sizeof taken));
    }
    if (args->n_words > most_words(command) && !args->word[0])
        return cli_usage(args, "unexpected '%s': --from has the model", args->word[most_words(command)]);
    if (args->n_words > most_words(command)) return cli_usage(args, "unexpected '%s'", args->word[most_words(command)]);
    return check_places(args);
}

int cli_args_parse(const cli_command *command, int argc, char **argv, cli_args *out)
{
    int only_words = 0, status = EXIT_DONE;
    const size_t n = (size_t)argc;
    *out = (cli_args){.command = command};
    out->word = malloc((n + 1) * sizeof *out->word);
    out->value = malloc(n * sizeof *out->value);
    out->flag = malloc(n * sizeof *out->flag);
    out->own = malloc((n + 1) * sizeof *out->own);
    if (!out->word || !out->value || !out->flag || !out->own) return cli_failed(FF_ERR_MEMORY, NULL);
    for (int i = 1; i < argc && status == EXIT_DONE; i++) {
        const char *word = argv[i];
        if (!only_words && !strcmp(word, "--")) {
            only_words = 1;
        } else if (only_words || word[0] != '-' || word[1] == '\0') {
            out->word[out->n_words++] = word;
        } else {
            status = parse_flag(out, argc, argv, &i);
        }
    }
    if (command->place[0].kind == KIND_EXPRESSION && cli_given(out, FLAG_FROM)) {
        memmove(out->word + 1, out->word, out->n_words * sizeof *out->word);
        out->word[0] = NULL;
        out->n_words++;
    }
    const int only_says = cli_given(out, FLAG_HELP) || cli_given(out, FLAG_PRINT_SCHEMA); /* and needs no words */
    return status != EXIT_DONE || only_says ? status : check_words(out);
}

void cli_args_free(cli_args *args)
{
    free(args->word);
    free(args->value);
    free(args->flag);
    for (size_t i = 0; i < args->n_own; i++) free(args->own[i]);
    free(args->own);
    *args = (cli_args){.command = NULL};
}
