/* --help and the shorter -h, from the definitions: examples, then the flags by what they are about. */
#include "internal_flags.h"
#include <string.h>

enum { COLUMN = 28, MEANING = COLUMN + 11 };

/* "      NAME       what it means" */
static void put_meanings(cli_words *words, cli_words *meaning, FILE *out)
{
    const char *word;
    for (size_t i = 0; (word = words(i)) != NULL; i++) {
        fprintf(out, "%*s%-*s", COLUMN, "", MEANING - COLUMN, word);
        cli_wrap(out, meaning(i), MEANING, MEANING);
    }
}

/* Of all, what the manual adds and what the words mean; else a line. */
static void put_flag(const cli_flag *f, int all, FILE *out)
{
    char spelling[64], text[400];
    const int indent = f->letter ? 2 : 6;
    const size_t n = (size_t)indent + strlen(cli_flag_spelling(f, spelling, sizeof spelling));
    snprintf(text, sizeof text, "%s%s%s%s", f->help, f->otherwise ? " (" : "", f->otherwise ? f->otherwise : "",
             f->otherwise ? ")" : "");
    fprintf(out, "%*s%s", indent, "", spelling);
    if (n + 1 >= COLUMN)
        fprintf(out, "\n%*s", COLUMN, "");
    else
        fprintf(out, "%*s", (int)(COLUMN - n), "");
    cli_wrap(out, text, COLUMN, COLUMN);
    if (all && f->meaning) put_meanings(f->words, f->meaning, out);
    if (!all || !f->more) return;
    fprintf(out, "%*s", COLUMN, "");
    cli_wrap(out, f->more, COLUMN, COLUMN);
}

static void put_group(const cli_command *command, int group, int all, FILE *out)
{
    int any = 0;
    for (int i = 0; i < FLAG_COUNT; i++) {
        const cli_flag f = cli_flag_of((cli_flag_id)i, command);
        if (!cli_flag_has(&f, command) || (int)f.group != group) continue;
        if (!any++) fprintf(out, "\n%s:\n", cli_group_name(group));
        put_flag(&f, all, out);
    }
}

void cli_help_command(const cli_command *command, int all, FILE *out)
{
    char usage[128], sentence[160];
    cli_command_usage(command, usage, sizeof usage);
    fprintf(out, "facetfit %s %s%s[flags]\n\n%c", command->name, usage, *usage ? " " : "", command->summary[0] - 'a' + 'A');
    snprintf(sentence, sizeof sentence, "%s.", command->summary + 1);
    cli_wrap(out, sentence, 1, 0);
    fputs("\nExamples:\n", out);
    for (size_t k = 0; k < CLI_EXAMPLES && command->example[k]; k++) fprintf(out, "  %s\n", command->example[k]);
    if (all) fputc('\n', out);
    if (all) cli_wrap(out, command->more, 0, 0);
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name && all; k++) {
        if (!command->place[k].meaning) continue;
        fprintf(out, "\nWhat %s can be:\n", command->place[k].name);
        put_meanings(command->place[k].words, command->place[k].meaning, out);
    }
    for (int group = 0; group < GROUP_COUNT; group++) put_group(command, group, all, out);
    if (!all) fprintf(out, "\n'facetfit %s --help' says more.\n", command->name);
}

void cli_help(int all, FILE *out)
{
    fputs("facetfit finds microfacet BRDF parameters in measured reflectance.\n\nfacetfit COMMAND ...\n\n", out);
    for (size_t i = 0; i < cli_command_count(); i++) {
        fprintf(out, "  %-11s", cli_command_at(i)->name);
        cli_wrap(out, cli_command_at(i)->summary, 13, 13);
    }
    if (!all) {
        fputs("\n'facetfit COMMAND -h' lists the flags of a command; 'facetfit --help' says more.\n", out);
        return;
    }
    fputs("\n'facetfit COMMAND --help' or 'facetfit help COMMAND' explains the flags of a\n"
          "command, 'facetfit COMMAND -h' lists them; 'facetfit man COMMAND' is the manual;\n"
          "'facetfit --version' prints the version, with --verbose what it is built of.\n\n"
          "Exit status: 0 done, 1 the answer is no (not converged, a check failed),\n"
          "2 usage, 3 input, 4 output, 5 internal, 130 Ctrl-C.\n",
          out);
}
