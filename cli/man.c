/* Manual pages in the language of man(7), from the definitions. */
#include "internal_flags.h"
#include <string.h>

/* ---- text in troff --------------------------------------------------------------------------- */

/* Characters that would command, as they are. */
static size_t put_char(FILE *out, char c)
{
    static const struct {
        char c;
        const char *escape;
    } special[] = {{'\\', "\\e"}, {'-', "\\-"}, {'\'', "\\(aq"}, {'`', "\\(ga"}, {'^', "\\(ha"}, {'~', "\\(ti"}};
    for (size_t i = 0; i < sizeof special / sizeof *special; i++)
        if (c == special[i].c) {
            fputs(special[i].escape, out);
            return strlen(special[i].escape);
        }
    fputc(c, out);
    return 1;
}

/* At the start of a line a point commands too. */
static size_t put_word(FILE *out, const char *word, size_t length, int first)
{
    size_t n = 0;
    if (first && *word == '.') n += (size_t)fprintf(out, "\\&");
    for (size_t i = 0; i < length; i++) n += put_char(out, word[i]);
    return n;
}

static void put(FILE *out, const char *text)
{
    put_word(out, text, strlen(text), 1);
}

static void put_line(FILE *out, const char *text)
{
    put(out, text);
    fputc('\n', out);
}

/* A phrase in lines of a source that people can read, with a point at its end unless it has one. */
static void put_text(FILE *out, const char *text)
{
    enum { LONGEST = 64 }; /* escapes come on top */
    size_t column = 0;
    const int ends = text[strlen(text) - 1] == '.';
    while (*text) {
        const size_t n = strcspn(text, " ");
        if (column + n > LONGEST) {
            fputc('\n', out);
            column = 0;
        } else if (column) {
            column += put_char(out, ' ');
        }
        column += put_word(out, text, n, column == 0);
        text += n + (text[n] != '\0');
    }
    fputs(ends ? "\n" : ".\n", out);
}

static void section(FILE *out, const char *name)
{
    fprintf(out, ".SH %s\n", name);
}

static void head(const char *command, const char *summary, const char *version, FILE *out)
{
    char upper[32];
    size_t n = 0;
    for (; command[n] && n + 1 < sizeof upper; n++) upper[n] = command[n] == '-' ? '-' : (char)(command[n] - 'a' + 'A');
    upper[n] = '\0';
    fprintf(out, ".TH %s 1 \"\" \"facetfit %s\" \"facetfit manual\"\n", upper, version);
    section(out, "NAME");
    put(out, command);
    fputs(" \\- ", out);
    put_line(out, summary);
}

static void exit_status(FILE *out)
{
    static const char *const meaning[][2] = {
        {"0", "done"},
        {"1", "the answer is no: a fit did not converge, a check failed"},
        {"2", "usage"},
        {"3", "an input cannot be read, not understood, or is of a kind that cannot be fitted"},
        {"4", "an output cannot be written"},
        {"5", "internal"},
        {"130", "ended by Ctrl-C"}};
    section(out, "EXIT STATUS");
    for (size_t i = 0; i < sizeof meaning / sizeof *meaning; i++) fprintf(out, ".TP\n.B %s\n%s\n", meaning[i][0], meaning[i][1]);
}

static void see_also(const cli_command *but, FILE *out)
{
    section(out, "SEE ALSO");
    if (but) fputs(".BR facetfit (1),\n", out);
    size_t last = cli_command_count() - 1;
    if (cli_command_at(last) == but) last--;
    for (size_t i = 0; i <= last; i++)
        if (cli_command_at(i) != but) fprintf(out, ".BR facetfit\\-%s (1)%s\n", cli_command_at(i)->name, i < last ? "," : "");
}

/* ---- pages ----------------------------------------------------------------------------------- */

void cli_man(const char *version, FILE *out)
{
    head("facetfit", "microfacet parameters from measured reflectance", version, out);
    section(out, "SYNOPSIS");
    fputs(".B facetfit\n.I COMMAND\n[\\fIflags\\fR] ...\n", out);
    section(out, "DESCRIPTION");
    put_text(out,
             "facetfit finds microfacet BRDF parameters in measured reflectance: roughness, reflectance at normal incidence and a "
             "diffuse part, each with its standard error, for every distribution of normals under every masking.");
    section(out, "COMMANDS");
    for (size_t i = 0; i < cli_command_count(); i++) {
        const cli_command *c = cli_command_at(i);
        fprintf(out, ".TP\n.BR facetfit\\-%s (1)\n", c->name);
        put_line(out, c->summary);
    }
    exit_status(out);
    section(out, "ENVIRONMENT");
    fputs(".TP\n.B FACETFIT_MODULES\nthe folder of the module that reads images, where it is not beside the program\n", out);
    see_also(NULL, out);
}

static void put_meanings(cli_words *words, cli_words *meaning, FILE *out)
{
    const char *word;
    fputs(".RS\n", out);
    for (size_t i = 0; (word = words(i)) != NULL; i++) {
        fputs(".TP\n", out);
        put_line(out, word);
        put_text(out, meaning(i));
    }
    fputs(".RE\n", out);
}

static void put_option(const cli_flag *f, FILE *out)
{
    char otherwise[128];
    fputs(".TP\n.B ", out);
    if (f->letter) fprintf(out, "\\-%c, ", f->letter);
    fputs(f->negatable ? "\\-\\-[no\\-]" : "\\-\\-", out);
    put(out, f->name);
    if (f->placeholder) {
        fputs(" \\fI", out);
        put(out, f->placeholder);
        fputs("\\fR", out);
    }
    fputc('\n', out);
    put_text(out, f->help);
    if (f->more) put_text(out, f->more);
    if (f->repeatable) put_text(out, "Can be given several times");
    if (f->otherwise) {
        snprintf(otherwise, sizeof otherwise, "Otherwise: %s", f->otherwise);
        put_text(out, otherwise);
    }
    if (f->meaning) put_meanings(f->words, f->meaning, out);
}

static void put_group(const cli_command *command, int group, FILE *out)
{
    int any = 0;
    for (int i = 0; i < FLAG_COUNT; i++) {
        const cli_flag f = cli_flag_of((cli_flag_id)i, command);
        if (!cli_flag_has(&f, command) || (int)f.group != group) continue;
        if (!any++) fprintf(out, ".SS %s\n", cli_group_name(group));
        put_option(&f, out);
    }
}

void cli_man_command(const cli_command *command, const char *version, FILE *out)
{
    char name[32], usage[128];
    snprintf(name, sizeof name, "facetfit-%s", command->name);
    head(name, command->summary, version, out);
    section(out, "SYNOPSIS");
    fprintf(out, ".B facetfit %s\n", command->name);
    if (*cli_command_usage(command, usage, sizeof usage)) put_line(out, usage);
    fputs("[\\fIflags\\fR]\n", out);
    section(out, "DESCRIPTION");
    put_text(out, command->more);
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name; k++) {
        if (!command->place[k].meaning) continue;
        fprintf(out, ".SS %s\n", command->place[k].name);
        put_meanings(command->place[k].words, command->place[k].meaning, out);
    }
    section(out, "EXAMPLES");
    fputs(".nf\n", out);
    for (size_t k = 0; k < CLI_EXAMPLES && command->example[k]; k++) put_line(out, command->example[k]);
    fputs(".fi\n", out);
    section(out, "OPTIONS");
    for (int group = 0; group < GROUP_COUNT; group++) put_group(command, group, out);
    exit_status(out);
    see_also(command, out);
}
