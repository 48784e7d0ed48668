/* No command writes over what it reads unless it is told to, nor two results into one file. The definitions say which words and
 * flags name a file; here all of a command line are compared before the command runs.
 *
 * --force lets an output replace an input: everything is read before anything is written, and what is written takes the name when
 * it is complete, so that a command that fails leaves the input. It lifts nothing else. Two outputs of one name are one output that
 * is lost; what the shell opened for standard output is written while the input is read; a device is written in place. */
#include "internal_flags.h"
#include "base/internal_output.h"
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Where a command line can name a file: its first words, its flags, and the standard output that nobody named. */
enum { FLAGS_FROM = CLI_PLACES, UNNAMED_OUTPUT = FLAGS_FROM + FLAG_COUNT, PLACES };

/* What a file is, however it is spelled. */
typedef struct identity {
    int known;       /* 0: a pipe or a device, which takes whatever comes, or nowhere */
    int is_replaced; /* 1: by an output of its name, when that is complete            */
    dev_t device;
    ino_t number;
    char name[NAME_MAX + 1]; /* of a file that does not exist yet, in the folder that the numbers mean; "" of one that does */
} identity;

typedef struct named_file {
    cli_kind use;
    char label[32]; /* "--json", "FILE" */
    int unnamed;    /* 1: the label says all */
    const char *path;
    identity is;
} named_file;

/* ---- identity -------------------------------------------------------------------------------- */

static identity identity_in_folder(const char *path)
{
    char folder[PATH_MAX];
    struct stat st;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    const int n = snprintf(folder, sizeof folder, "%.*s.", (int)(name - path), path);
    identity is = {0};
    if (n < 0 || (size_t)n >= sizeof folder || strlen(name) > NAME_MAX || stat(folder, &st) != 0) return is;
    is = (identity){.known = 1, .device = st.st_dev, .number = st.st_ino};
    strcpy(is.name, name);
    return is;
}

static identity identity_of_new(const char *path)
{
    char *end = ff_output_name(path); /* of links that lead nowhere yet */
    const identity is = identity_in_folder(end ? end : path);
    free(end);
    return is;
}

static identity identify(const char *path, cli_kind use)
{
    struct stat st;
    const int standard = !strcmp(path, "-");
    const int failed = standard ? fstat(use == KIND_INPUT_FILE ? STDIN_FILENO : STDOUT_FILENO, &st) : stat(path, &st);
    if (failed) return standard ? (identity){0} : identity_of_new(path);
    const int regular = S_ISREG(st.st_mode) != 0;
    return (identity){regular || S_ISBLK(st.st_mode), regular && !standard, st.st_dev, st.st_ino, ""};
}

static int same(const identity *a, const identity *b)
{
    return a->known && b->known && a->device == b->device && a->number == b->number && !strcmp(a->name, b->name);
}

/* ---- the files of a command line ------------------------------------------------------------- */

static void take_word(const cli_args *args, size_t k, named_file *out)
{
    const cli_place *place = &args->command->place[k];
    if (!place->name || !cli_kind_is_file(place->kind)) return;
    out->use = place->kind;
    snprintf(out->label, sizeof out->label, "%s", place->name);
    out->path = k < args->n_words ? args->word[k] : "-";
}

static void take_flag(const cli_args *args, cli_flag_id flag, named_file *out)
{
    const cli_flag f = cli_flag_of(flag, args->command);
    if (!cli_kind_is_file(f.kind)) return;
    out->use = f.kind;
    out->path = cli_value(args, flag, NULL);
    snprintf(out->label, sizeof out->label, "--%s", f.name);
}

static int take(const cli_args *args, size_t place, named_file *out);

/* What a command prints goes to standard output, unless a result that was sent there has it to itself. */
static void take_unnamed(const cli_args *args, named_file *out)
{
    named_file other;
    for (size_t place = 0; place < UNNAMED_OUTPUT; place++)
        if (take(args, place, &other) && other.use == KIND_OUTPUT_FILE && !strcmp(other.path, "-")) return;
    *out = (named_file){.use = KIND_OUTPUT_FILE, .label = "standard output", .unnamed = 1, .path = "-"};
}

/* 0 when no file is named in this place. */
static int take(const cli_args *args, size_t place, named_file *out)
{
    *out = (named_file){.use = KIND_SWITCH};
    if (place < FLAGS_FROM)
        take_word(args, place, out);
    else if (place < UNNAMED_OUTPUT)
        take_flag(args, (cli_flag_id)(place - FLAGS_FROM), out);
    else
        take_unnamed(args, out);
    if (out->use == KIND_SWITCH || !out->path) return 0;
    out->is = identify(out->path, out->use);
    return 1;
}

/* ---- collisions ------------------------------------------------------------------------------ */

/* "--json a.json" */
static void show(const named_file *f, char out[PATH_MAX])
{
    snprintf(out, PATH_MAX, "%s%s%s", f->label, f->unnamed ? "" : " ", f->unnamed ? "" : f->path);
}

/* Is it an output that may take the place of an input, if --force says so? */
static int may_replace(const named_file *output)
{
    return output->use == KIND_OUTPUT_FILE && output->is.is_replaced;
}

static int refuse(const cli_args *args, const named_file *a, const named_file *b)
{
    char first[PATH_MAX], second[PATH_MAX];
    show(a, first);
    show(b, second);
    if (a->use != b->use)
        return cli_usage(args, "%s is the input %s; give another file to %s%s", first, second, a->label,
                         may_replace(a) ? ", or --force to replace it" : "");
    if (!strcmp(a->path, "-") && !strcmp(b->path, "-"))
        return cli_usage(args, "%s and %s both want standard %s; give a file to one of them", first, second,
                         a->use == KIND_INPUT_FILE ? "input" : "output");
    return cli_usage(args, "%s and %s are the same file; give another to one of them", first, second);
}

/* Reading a file twice is no harm, reading standard input twice is. */
static int collide(const cli_args *args, const named_file *a, const named_file *b)
{
    if (a->use != b->use && may_replace(a) && cli_switch(args, FLAG_FORCE, 0)) return 0;
    if (a->use == b->use && !strcmp(a->path, "-") && !strcmp(b->path, "-")) return 1;
    return a->use == KIND_OUTPUT_FILE && same(&a->is, &b->is);
}

/* Standard output takes the table or the JSON. */
static int check_table(const cli_args *args)
{
    const char *json = cli_value(args, FLAG_JSON, NULL);
    if (cli_word(args, FLAG_TABLE, FF_TABLE_TEXT) == FF_TABLE_TEXT || !json || strcmp(json, "-")) return EXIT_DONE;
    return cli_usage(args, "--table %s and --json both want standard output; give a file to --json",
                     cli_value(args, FLAG_TABLE, NULL));
}

/* Does it lie in the folder of -o, which the command will make? */
static int is_in_new_folder(const cli_args *args, const char *path)
{
    struct stat st;
    const char *folder = cli_flag_of(FLAG_OUTPUT, args->command).kind == KIND_FOLDER ? cli_value(args, FLAG_OUTPUT, NULL) : NULL;
    const size_t n = folder ? strlen(folder) : 0;
    if (!n || stat(folder, &st) == 0 || strncmp(path, folder, n) != 0 || (folder[n - 1] != '/' && path[n] != '/')) return 0;
    return !strchr(path + n + (path[n] == '/'), '/');
}

/* What cannot be written is said before anything is computed. A pipe is not touched: whoever reads it would see its end. */
static int check_can_be_written(const cli_args *args, const named_file *f)
{
    struct stat st;
    ff_output out;
    ff_error err = {0};
    const int there = stat(f->path, &st) == 0;
    if (f->use != KIND_OUTPUT_FILE || !strcmp(f->path, "-") || (there && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode)))
        return EXIT_DONE;
    if (is_in_new_folder(args, f->path)) return EXIT_DONE;
    const ff_status status = ff_output_open(f->path, &out, &err);
    if (status != FF_OK) return cli_failed(status, &err);
    ff_output_abort(&out);
    return EXIT_DONE;
}

int cli_files_check(const cli_args *args)
{
    named_file a, b;
    const int status = check_table(args);
    if (status != EXIT_DONE) return status;
    for (size_t i = 0; i < PLACES; i++) {
        if (!take(args, i, &a)) continue;
        for (size_t j = 0; j < PLACES; j++)
            if (j != i && take(args, j, &b) && collide(args, &a, &b)) return refuse(args, &a, &b);
    }
    for (size_t i = 0; i < PLACES; i++) {
        const int failed = take(args, i, &a) ? check_can_be_written(args, &a) : EXIT_DONE;
        if (failed) return failed;
    }
    return EXIT_DONE;
}

ff_status cli_files_ask(const void *args, const char *path, ff_error *err)
{
    named_file output;
    const identity input = identify(path, KIND_INPUT_FILE);
    for (size_t place = 0; place < PLACES; place++) {
        if (!take(args, place, &output) || output.use != KIND_OUTPUT_FILE || !same(&output.is, &input)) continue;
        if (may_replace(&output) && cli_switch(args, FLAG_FORCE, 0)) continue;
        return ff_error_set(err, FF_ERR_SYNTAX, NULL, 0, -1, "it is what %s would write; give another file to %s%s", output.label,
                            output.label, may_replace(&output) ? ", or --force to replace it" : "");
    }
    return FF_OK;
}
