/* The tables of commands and flags, and looking things up in them. */
#include "internal_flags.h"
#include "fit/ndf/ndf_struct.h"
#include "ff_render.h"
#include <math.h>
#include <string.h>

/* ---- commands -------------------------------------------------------------------------------- */

static const char *cli_words_commands(size_t i);

static const cli_command commands[COMMAND_COUNT] = {
#define COMMAND(ID, ...) [COMMAND_##ID] = {.id = COMMAND_##ID, .name = #ID, __VA_ARGS__},
#include "commands.def"
#undef COMMAND
};

static const char *cli_words_commands(size_t i)
{
    return i < COMMAND_COUNT ? commands[i].name : NULL;
}

size_t cli_command_count(void)
{
    return COMMAND_COUNT;
}

const cli_command *cli_command_at(size_t i)
{
    return i < COMMAND_COUNT ? &commands[i] : NULL;
}

const cli_command *cli_command_find(const char *name)
{
    if (!strcmp(name, "self-test")) name = "selftest"; /* as people spell it */
    const int i = cli_words_find(cli_words_commands, name, strlen(name));
    return i < 0 ? NULL : &commands[i];
}

const char *cli_command_nearest(const char *word)
{
    return cli_words_nearest(cli_words_commands, word, strlen(word));
}

const char *cli_command_usage(const cli_command *command, char *out, size_t size)
{
    size_t used = 0;
    *out = '\0';
    if (command->usage) snprintf(out, size, "%s", command->usage);
    for (size_t k = 0; k < CLI_PLACES && command->place[k].name && !command->usage && used < size; k++) {
        const cli_place *p = &command->place[k];
        used += (size_t)snprintf(out + used, size - used, "%s%s%s%s", k ? " " : "", p->optional ? "[" : "", p->name,
                                 p->optional ? "]" : "");
    }
    return out;
}

/* ---- flags ----------------------------------------------------------------------------------- */

#define C(ID) (1u << COMMAND_##ID)
enum {
    C_FITTING = C(fit) | C(compare) | C(plot),
    C_MEASURED = C_FITTING | C(ndf),
    C_READS = C_MEASURED | C(info) | C(resample) | C(render),
    C_SCENE = C(eval) | C(simulate) | C(furnace) | C(sample) | C(plot) | C(render),
    C_PATHS = C(simulate) | C(furnace),
    C_BATCH = C(fit) | C(compare),
    C_REPORTS = C(fit) | C(compare) | C(ndf) | C(info) | C(models) | C(formats) | C(diff),
    C_ALL = (1u << COMMAND_COUNT) - 1,
    C_JSON = C_ALL & ~(C(simulate) | C(plot) | C(man) | C(completion) | C(diff) | C(selftest))
};

static const cli_flag flags[FLAG_COUNT] = {
#define FLAG(ID, ...) [FLAG_##ID] = {__VA_ARGS__},
#include "flags.def"
#undef FLAG
};

static const struct {
    const char *name;
    cli_bearing bearing;
} groups[GROUP_COUNT] = {
    [GROUP_DATA] = {"Data", BEARS_RESULT},
    [GROUP_MODEL] = {"Model", BEARS_RESULT},
    [GROUP_WEIGHTS] = {"Weights", BEARS_RESULT},
    [GROUP_RETRIEVAL] = {"Retrieval", BEARS_RESULT},
    [GROUP_TRUST] = {"Trust", BEARS_QUESTION},
    [GROUP_CONVERSION] = {"Conversion", BEARS_OUTPUT},
    [GROUP_VIEW] = {"View", BEARS_OUTPUT},
    [GROUP_NOISE] = {"Noise", BEARS_RESULT},
    [GROUP_PATHS] = {"Paths of light", BEARS_RESULT},
    [GROUP_FIGURE] = {"Figure", BEARS_OUTPUT},
    [GROUP_OUTPUT] = {"Output", BEARS_OUTPUT},
    [GROUP_BATCH] = {"Many files", BEARS_OUTPUT},
    [GROUP_RUN] = {"Running", BEARS_OUTPUT},
};

const char *cli_group_name(int group)
{
    return groups[group].name;
}

cli_bearing cli_flag_bearing(const cli_flag *flag)
{
    return flag->bears ? (cli_bearing)(flag->bears - 1) : groups[flag->group].bearing;
}

const cli_flag *cli_flag_at(cli_flag_id flag)
{
    return &flags[flag];
}

const char *cli_flag_name(cli_flag_id flag)
{
    return flags[flag].name;
}

int cli_flag_has(const cli_flag *flag, const cli_command *command)
{
    return (flag->commands >> command->id) & 1u;
}

cli_flag cli_flag_of(cli_flag_id id, const cli_command *command)
{
    cli_flag f = flags[id];
    for (size_t k = 0; k < CLI_OTHERS && f.other[k].commands; k++) {
        const cli_flag_other *o = &f.other[k];
        if (!((o->commands >> command->id) & 1u)) continue;
        if (o->help) f.help = o->help;
        if (o->otherwise) f.otherwise = o->otherwise;
        if (o->placeholder) f.placeholder = o->placeholder;
        if (o->kind) f.kind = o->kind;
        if (o->words) f.words = o->words;
        if (o->group) f.group = (cli_group)(o->group - 1);
    }
    return f;
}

int cli_kind_is_file(cli_kind kind)
{
    return kind == KIND_INPUT_FILE || kind == KIND_OUTPUT_FILE;
}
