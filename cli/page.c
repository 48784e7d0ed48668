/* docs/flags.md, from the definitions. */
#include "internal_flags.h"
#include <string.h>

/* A cell of a table: '|' would end it. */
static void put_cell(FILE *out, const char *text)
{
    for (; *text; text++) {
        if (*text == '|') fputc('\\', out);
        fputc(*text, out);
    }
}

static const char *kind_name(cli_kind kind)
{
    static const char *const names[] = {
        "switch",         "input file",      "output file",        "folder", "number",      "angle", "whole number", "numbers",
        "word of a list", "words of a list", "word, with details", "model",  "assignments", "text"};
    return names[kind];
}

static void put_flag(const cli_flag *f, FILE *out)
{
    char spelling[64];
    fputs("| `", out);
    put_cell(out, cli_flag_spelling(f, spelling, sizeof spelling));
    fprintf(out, "` | %s | ", kind_name(f->kind));
    put_cell(out, f->help);
    if (f->more) {
        fputs(". ", out);
        put_cell(out, f->more);
    }
    if (f->repeatable) fputs(". Can be given several times", out);
    fputs(" | ", out);
    put_cell(out, f->otherwise ? f->otherwise : "");
    fputs(" |\n", out);
}

static void put_meanings(const char *before, const char *name, cli_words *words, cli_words *meaning, FILE *out)
{
    const char *word;
    fprintf(out, "\n`%s%s`:\n\n", before, name);
    for (size_t i = 0; (word = words(i)) != NULL; i++) fprintf(out, "- `%s`: %s\n", word, meaning(i));
}

static void put_words(const cli_flag *f, FILE *out)
{
    char list[1024];
    if (f->meaning)
        put_meanings("--", f->name, f->words, f->meaning, out);
    else if (f->words && f->kind != KIND_EXPRESSION && f->kind != KIND_TEXT)
        fprintf(out, "\n`--%s`: %s.\n", f->name, cli_words_list(f->words, list, sizeof list));
}

static void put_group(const cli_command *command, int group, FILE *out)
{
    int any = 0;
    for (int i = 0; i < FLAG_COUNT; i++) {
        const cli_flag f = cli_flag_of((cli_flag_id)i, command);
        if (!cli_flag_has(&f, command) || (int)f.group != group) continue;
        if (!any++) fprintf(out, "\n| %s | value | | otherwise |\n|---|---|---|---|\n", cli_group_name(group));
        put_flag(&f, out);
    }
    for (int i = 0; i < FLAG_COUNT && any; i++) {
        const cli_flag f = cli_flag_of((cli_flag_id)i, command);
        if (cli_flag_has(&f, command) && (int)f.group == group) put_words(&f, out);
    }
}

static void put_command(const cli_command *command, FILE *out)
{
    char usage[128];
    cli_command_usage(command, usage, sizeof usage);
    fprintf(out, "\n## %s\n\n`facetfit %s %s%s[flags]`: %s. %s\n\n", command->name, command->name, usage, *usage ? " " : "",
            command->summary, command->more);
    for (size_t k = 0; k < CLI_EXAMPLES && command->example[k]; k++) fprintf(out, "    %s\n", command->example[k]);
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name; k++)
        if (command->place[k].meaning)
            put_meanings("", command->place[k].name, command->place[k].words, command->place[k].meaning, out);
    for (int group = 0; group < GROUP_COUNT; group++) put_group(command, group, out);
}

static ff_status put_page(const void *none, FILE *out)
{
    (void)none;
    fputs(
        "# Commands and flags\n\n`facetfit man --markdown` writes this page from the definitions in `cli/commands.def` and "
        "`cli/flags.def`; do not edit it.\n\nThe examples run in a folder with `paint.csv`, three channels of a painted surface, "
        "`grey.csv`, another with one, `fits`, a folder of fits of both with `old.csv` and `new.csv`, two summaries "
        "of it, and `directions.csv`, pairs of directions.\n\nValues: numbers are decimal, with an exponent where you like; angles "
        "are in "
        "degrees; a file `-` is standard input or output. An assignment is `P=V`: `f0=0.04`. `P=a:b:c` gives one value per "
        "channel, "
        "`P[r]=V` names one channel, `P=LO:HI` is a range where a flag takes one, and `P={a,b,c}` a list of values where a command "
        "takes lists. Several are separated by commas.\n\nA flag that takes a value is given once, where its line does not say "
        "that it "
        "can be given several times; of a switch that can be switched off the last one counts.\n",
        out);
    for (size_t i = 0; i < cli_command_count(); i++) put_command(cli_command_at(i), out);
    return FF_OK;
}

ff_status cli_page(FILE *out)
{
    return ff_report_page(put_page, NULL, out);
}
