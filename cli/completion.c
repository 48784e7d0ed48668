/* What bash, zsh and fish need to complete a command line, from the definitions. */
#include "internal_flags.h"
#include <string.h>

/* ---- common ---------------------------------------------------------------------------------- */

/* Text within single quotes of a shell, `escaped` characters with a backslash. */
static void put_quoted(FILE *out, const char *text, const char *escaped, const char *quote)
{
    for (; *text; text++) {
        if (*text == '\'')
            fputs(quote, out);
        else
            fprintf(out, "%s%c", strchr(escaped, *text) ? "\\" : "", *text);
    }
}

static void put_words(FILE *out, cli_words *words)
{
    for (size_t i = 0; words(i); i++) fprintf(out, "%s%s", i ? " " : "", words(i));
}

/* The commands, and "help", which is none. */
static void put_commands(FILE *out)
{
    for (size_t i = 0; i < cli_command_count(); i++) fprintf(out, "%s ", cli_command_at(i)->name);
    fputs("help", out);
}

/* ---- bash ------------------------------------------------------------------------------------ */

static const char bash_head[] = "# bash completion of facetfit, written by 'facetfit completion bash'\n"
                                "\n"
                                "_facetfit_words() { # current word...\n"
                                "    local IFS=$' \\t\\n' current=$1\n"
                                "    shift\n"
                                "    COMPREPLY=($(compgen -W \"$*\" -- \"$current\"))\n"
                                "    return 0\n"
                                "}\n"
                                "\n"
                                "_facetfit_list() { # separator current word...: what follows the last separator\n"
                                "    local IFS=$' \\t\\n' separator=$1 current=$2 before=\n"
                                "    shift 2\n"
                                "    case $current in *\"$separator\"*) before=${current%\"$separator\"*}$separator ;; esac\n"
                                "    COMPREPLY=($(compgen -P \"$before\" -W \"$*\" -- \"${current#\"$before\"}\"))\n"
                                "    compopt -o nospace 2>/dev/null\n"
                                "    return 0\n"
                                "}\n"
                                "\n"
                                "_facetfit_path() { # -f|-d current\n"
                                "    local IFS=$'\\n'\n"
                                "    COMPREPLY=($(compgen \"$1\" -- \"$2\"))\n"
                                "    compopt -o filenames 2>/dev/null\n"
                                "    return 0\n"
                                "}\n\n";

static const char bash_tail[] =
    "_facetfit() {\n"
    "    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]} i place=0\n"
    "    COMPREPLY=()\n"
    "    if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
    "        _facetfit_words \"$current\" $(_facetfit_commands) --help --version\n"
    "        return\n"
    "    fi\n"
    "    # '=' is a word of its own: --loss = log\n"
    "    if [ \"$current\" = '=' ]; then\n"
    "        current=\n"
    "    elif [ \"$previous\" = '=' ] && [ \"$COMP_CWORD\" -gt 2 ]; then\n"
    "        previous=${COMP_WORDS[COMP_CWORD-2]}\n"
    "    fi\n"
    "    case $current in\n"
    "    -?*)\n"
    "        _facetfit_words \"$current\" $(_facetfit_flags \"$command\")\n"
    "        return\n"
    "        ;;\n"
    "    esac\n"
    "    case $previous in\n"
    "    -?*) _facetfit_value \"$command\" \"$previous\" \"$current\" && return ;;\n"
    "    esac\n"
    "    for ((i = 2; i < COMP_CWORD; i++)); do\n"
    "        case ${COMP_WORDS[i]} in\n"
    "        -?*)\n"
    "            if [ \"${COMP_WORDS[i+1]}\" = '=' ]; then\n"
    "                i=$((i + 2))\n"
    "            elif _facetfit_value \"$command\" \"${COMP_WORDS[i]}\" ''; then\n"
    "                i=$((i + 1))\n"
    "            fi\n"
    "            ;;\n"
    "        *) place=$((place + 1)) ;;\n"
    "        esac\n"
    "    done\n"
    "    COMPREPLY=()\n"
    "    _facetfit_value \"$command\" \"$place\" \"$current\" || COMPREPLY=()\n"
    "}\n"
    "complete -F _facetfit facetfit\n";

/* What completes a value of this kind, $3. */
static void bash_value(FILE *out, cli_kind kind, cli_words *words)
{
    if (cli_kind_is_file(kind)) {
        fputs("_facetfit_path -f \"$3\"", out);
    } else if (kind == KIND_FOLDER) {
        fputs("_facetfit_path -d \"$3\"", out);
    } else if (words) {
        fputs(kind == KIND_WORDS        ? "_facetfit_list , \"$3\" "
              : kind == KIND_EXPRESSION ? "_facetfit_list + \"$3\" "
                                        : "_facetfit_words \"$3\" ",
              out);
        put_words(out, words);
    } else {
        fputs("COMPREPLY=()", out);
    }
    fputs(" ;;\n", out);
}

static void bash_flags(FILE *out)
{
    fputs("_facetfit_flags() { # command\n    case $1 in\n", out);
    for (size_t c = 0; c < cli_command_count(); c++) {
        fprintf(out, "    %s) echo", cli_command_at(c)->name);
        for (int i = 0; i < FLAG_COUNT; i++) {
            const cli_flag *f = cli_flag_at((cli_flag_id)i);
            if (!cli_flag_has(f, cli_command_at(c))) continue;
            fprintf(out, " --%s", f->name);
            if (f->negatable) fprintf(out, " --no-%s", f->name);
        }
        fputs(" ;;\n", out);
    }
    fputs("    esac\n}\n\n", out);
}

/* A value after --flag, or the word in place 0, 1, ... */
static void bash_values(FILE *out)
{
    fputs("_facetfit_value() { # command flag|place current: false where there is none\n    case $1:$2 in\n", out);
    for (size_t c = 0; c < cli_command_count(); c++) {
        const cli_command *command = cli_command_at(c);
        for (size_t k = 0; k < CLI_PLACES && command->place[k].name; k++) {
            fprintf(out, "    %s:%zu) ", command->name, k);
            bash_value(out, command->place[k].kind, command->place[k].words);
        }
        for (int i = 0; i < FLAG_COUNT; i++) {
            const cli_flag f = cli_flag_of((cli_flag_id)i, command);
            if (!cli_flag_has(&f, command) || f.kind == KIND_SWITCH) continue;
            fprintf(out, "    %s:--%s", command->name, f.name);
            if (f.letter) fprintf(out, "|%s:-%c", command->name, f.letter);
            fputs(") ", out);
            bash_value(out, f.kind, f.words);
        }
    }
    fputs("    help:0) _facetfit_words \"$3\" $(_facetfit_commands) ;;\n    *) return 1 ;;\n    esac\n}\n\n", out);
}

static void bash(FILE *out)
{
    fputs(bash_head, out);
    fputs("_facetfit_commands() {\n    echo ", out);
    put_commands(out);
    fputs("\n}\n\n", out);
    bash_flags(out);
    bash_values(out);
    fputs(bash_tail, out);
}

/* ---- zsh ------------------------------------------------------------------------------------- */

static void zsh_value(FILE *out, const char *name, cli_kind kind, cli_words *words, const char *optional)
{
    fprintf(out, ":%s", optional);
    put_quoted(out, name, ":[]\\", "'\\''");
    fputc(':', out);
    if (cli_kind_is_file(kind)) {
        fputs("_files", out);
    } else if (kind == KIND_FOLDER) {
        fputs("_files -/", out);
    } else if (words && (kind == KIND_WORDS || kind == KIND_EXPRESSION)) {
        fprintf(out, "_sequence -s %c compadd - ", kind == KIND_WORDS ? ',' : '+');
        put_words(out, words);
    } else if (words) {
        fputc('(', out);
        put_words(out, words);
        fputc(')', out);
    } else {
        fputc(' ', out);
    }
    fputc('\'', out);
}

static void zsh_spec(FILE *out, const cli_flag *f, const char *before, const char *name)
{
    fprintf(out, " \\\n            '%s%s%s%s[", f->repeatable ? "*" : "", before, name, f->kind == KIND_SWITCH ? "" : "=");
    put_quoted(out, f->help, ":[]\\", "'\\''");
    fputc(']', out);
    if (f->kind == KIND_SWITCH)
        fputc('\'', out);
    else
        zsh_value(out, f->placeholder, f->kind, f->words, f->without ? ":" : "");
}

static void zsh_command(FILE *out, const cli_command *command)
{
    char letter[4] = "";
    fprintf(out, "    %s)\n        _arguments", command->name);
    for (int i = 0; i < FLAG_COUNT; i++) {
        cli_flag f = cli_flag_of((cli_flag_id)i, command);
        if (!cli_flag_has(&f, command)) continue;
        zsh_spec(out, &f, "--", f.name);
        if (f.negatable) zsh_spec(out, &f, "--no-", f.name);
        snprintf(letter, sizeof letter, "%c", f.letter);
        f.name = letter;
        if (f.letter && f.kind == KIND_SWITCH) zsh_spec(out, &f, "-", letter);
    }
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name; k++) {
        fprintf(out, " \\\n            '%s", command->repeats ? "*" : "");
        zsh_value(out, command->place[k].name, command->place[k].kind, command->place[k].words,
                  command->place[k].optional && !command->repeats ? ":" : "");
    }
    fputs("\n        ;;\n", out);
}

static void zsh(FILE *out)
{
    fputs("#compdef facetfit\n# zsh completion of facetfit, written by 'facetfit completion zsh'\n\n_facetfit() {\n"
          "    local -a commands\n    commands=(\n",
          out);
    for (size_t i = 0; i < cli_command_count(); i++) {
        fprintf(out, "        '%s:", cli_command_at(i)->name);
        put_quoted(out, cli_command_at(i)->summary, ":\\", "'\\''");
        fputs("'\n", out);
    }
    fputs("        'help:the flags of a command'\n    )\n"
          "    if (( CURRENT == 2 )); then\n        _describe command commands\n        return\n    fi\n"
          "    shift words\n    (( CURRENT-- ))\n    case $words[1] in\n",
          out);
    for (size_t i = 0; i < cli_command_count(); i++) zsh_command(out, cli_command_at(i));
    fputs("    help)\n        (( CURRENT == 2 )) && _describe command commands\n        ;;\n    esac\n}\n\n_facetfit \"$@\"\n",
          out);
}

/* ---- fish ------------------------------------------------------------------------------------ */

static void fish_value(FILE *out, cli_kind kind, cli_words *words)
{
    if (cli_kind_is_file(kind) || kind == KIND_FOLDER) {
        fputs(" -r -F", out);
    } else {
        fputs(" -x", out);
        if (!words) return;
        fputs(" -a '", out);
        put_words(out, words);
        fputc('\'', out);
    }
}

static void fish_flag(FILE *out, const cli_command *command, const cli_flag *f, const char *before)
{
    fprintf(out, "complete -c facetfit -n '__fish_seen_subcommand_from %s' -l %s%s", command->name, before, f->name);
    if (f->letter) fprintf(out, " -s %c", f->letter);
    if (f->kind != KIND_SWITCH) fish_value(out, f->kind, f->words);
    fputs(" -d '", out);
    put_quoted(out, f->help, "\\", "\\'");
    fputs("'\n", out);
}

static void fish_command(FILE *out, const cli_command *command)
{
    fprintf(out, "\ncomplete -c facetfit -n __fish_use_subcommand -a %s -d '", command->name);
    put_quoted(out, command->summary, "\\", "\\'");
    fputs("'\n", out);
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name; k++) {
        const cli_place *p = &command->place[k];
        if (!cli_kind_is_file(p->kind) && !p->words) continue;
        fprintf(out, "complete -c facetfit -n '__fish_seen_subcommand_from %s'", command->name);
        if (cli_kind_is_file(p->kind)) {
            fputs(" -F", out);
        } else {
            fputs(" -a '", out);
            put_words(out, p->words);
            fputc('\'', out);
        }
        fputc('\n', out);
    }
    for (int i = 0; i < FLAG_COUNT; i++) {
        const cli_flag f = cli_flag_of((cli_flag_id)i, command);
        if (!cli_flag_has(&f, command)) continue;
        fish_flag(out, command, &f, "");
        if (f.negatable) fish_flag(out, command, &f, "no-");
    }
}

static void fish(FILE *out)
{
    fputs("# fish completion of facetfit, written by 'facetfit completion fish'\ncomplete -c facetfit -f\n", out);
    for (size_t i = 0; i < cli_command_count(); i++) fish_command(out, cli_command_at(i));
    fputs("\ncomplete -c facetfit -n __fish_use_subcommand -a help -d 'the flags of a command'\n"
          "complete -c facetfit -n '__fish_seen_subcommand_from help' -a '",
          out);
    put_commands(out);
    fputs("'\n", out);
}

void cli_complete(int shell, FILE *out)
{
    static void (*const write[])(FILE *) = {bash, zsh, fish};
    write[shell](out);
}
