/* Manual pages in the language of man(7), from the definitions. */
#include "internal_flags.h"
#include <string.h>

/* ---- text in troff --------------------------------------------------------------------------- */

/* Text as it is: no character of it commands. At the start of a line a point or an apostrophe would. */
static void put(FILE *out, const char *text)
{
    if (*text == '.' || *text == '\'') fputs("\\&", out);
    for (; *text; ++text) {
        if (*text == '\\')
            fputs("\\e", out);
        else if (*text == '-')
            fputs("\\-", out);
        else if (*text == '\'')
            fputs("\\(aq", out);
        else if (*text == '`')
            fputs("\\(ga", out);
        else if (*text == '^')
            fputs("\\(ha", out);
        else if (*text == '~')
            fputs("\\(ti", out);
        else
            fputc(*text, out);
    }
}

static void put_line(FILE *out, const char *text)
{
    put(out, text);
    fputc('\n', out);
}

/* A sentence out of a phrase: a large first letter and a point at the end, unless it begins with a name. */
static void put_sentence(FILE *out, const char *phrase)
{
    put(out, phrase);
    fputs(phrase[strlen(phrase) - 1] == '.' ? "\n" : ".\n", out);
}

static void section(FILE *out, const char *name)
{
    fprintf(out, ".SH %s\n", name);
}

static void head(const char *command, const char *summary, const char *version, FILE *out)
{
    char upper[32];
    size_t n = 0;
    for (; command[n] && n + 1 < sizeof upper; ++n) upper[n] = command[n] == '-' ? '-' : (char)(command[n] - 'a' + 'A');
    upper[n] = '\0';
    fprintf(out, ".TH %s 1 \"\" \"facetfit %s\" \"facetfit manual\"\n", upper, version);
    section(out, "NAME");
    put(out, command);
    fputs(" \\- ", out);
    put_line(out, summary);
}

static void exit_status(FILE *out)
{
    static const char *const meaning[][2] = {{"0", "done"},
                                             {"1", "the answer is no: a fit did not converge, a check failed"},
                                             {"2", "usage"},
                                             {"3", "an input cannot be read, or not understood"},
                                             {"4", "an output cannot be written"},
                                             {"5", "internal"},
                                             {"130", "ended by Ctrl-C"}};
    section(out, "EXIT STATUS");
    for (size_t i = 0; i < sizeof meaning / sizeof *meaning; ++i) fprintf(out, ".TP\n.B %s\n%s\n", meaning[i][0], meaning[i][1]);
}

static void see_also(const cli_command *but, FILE *out)
{
    section(out, "SEE ALSO");
    if (but) fputs(".BR facetfit (1),\n", out);
    size_t last = cli_command_count() - 1;
    if (cli_command_at(last) == but) --last;
    for (size_t i = 0; i <= last; ++i)
        if (cli_command_at(i) != but) fprintf(out, ".BR facetfit\\-%s (1)%s\n", cli_command_at(i)->name, i < last ? "," : "");
}

/* ---- pages ----------------------------------------------------------------------------------- */

void cli_man(const char *version, FILE *out)
{
    head("facetfit", "microfacet parameters from measured reflectance", version, out);
    section(out, "SYNOPSIS");
    fputs(".B facetfit\n.I COMMAND\n[\\fIflags\\fR] ...\n", out);
    section(out, "DESCRIPTION");
    put_line(out,
             "facetfit finds microfacet BRDF parameters in measured reflectance: roughness, reflectance at normal incidence and a "
             "diffuse part, each with its standard error, for every distribution of normals under every masking.");
    section(out, "COMMANDS");
    for (size_t i = 0; i < cli_command_count(); ++i) {
        const cli_command *c = cli_command_at(i);
        fprintf(out, ".TP\n.BR facetfit\\-%s (1)\n", c->name);
        put_line(out, c->summary);
    }
    exit_status(out);
    section(out, "ENVIRONMENT");
    fputs(".TP\n.B FACETFIT_MODULES\nthe folder of the module that reads images, where it is not beside the program\n", out);
    see_also(NULL, out);
}

static void put_option(const cli_flag *f, FILE *out)
{
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
    put_sentence(out, f->help);
    if (f->more) put_line(out, f->more);
    if (f->repeatable) put_line(out, "Can be given several times.");
    if (!f->otherwise) return;
    fputs("Otherwise: ", out);
    put_sentence(out, f->otherwise);
}

static void put_group(const cli_command *command, int group, FILE *out)
{
    int any = 0;
    for (int i = 0; i < FLAG_COUNT; ++i) {
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
    put_line(out, command->more);
    section(out, "EXAMPLES");
    fputs(".nf\n", out);
    for (size_t k = 0; k < CLI_EXAMPLES && command->example[k]; ++k) put_line(out, command->example[k]);
    fputs(".fi\n", out);
    section(out, "OPTIONS");
    for (int group = 0; group < GROUP_COUNT; ++group) put_group(command, group, out);
    exit_status(out);
    see_also(command, out);
}
