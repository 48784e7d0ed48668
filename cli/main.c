/* facetfit: chooses the command. */
#include "internal_cli.h"
#include "ff_version.h"
#include <fcntl.h>
#include <pthread.h>
#include <string.h>
#include <unistd.h>

enum { STACK = 8 << 20 };

/* Of a command, or with NULL of the program. */
typedef struct help {
    const cli_command *command;
    int all;
} help;

static ff_status write_help(const void *context, FILE *out)
{
    const help *h = context;
    if (h->command)
        cli_help_command(h->command, h->all, out);
    else
        cli_help(h->all, out);
    return FF_OK;
}

static ff_status write_version(const void *verbose, FILE *out)
{
    fprintf(out, "facetfit %s\n", ff_version());
    if (verbose) cli_about(out);
    return FF_OK;
}

/* --version, or -V, and --verbose behind it. */
static int print_version(int argc, char **argv)
{
    const int verbose = argc > 2 && (!strcmp(argv[2], "--verbose") || !strcmp(argv[2], "-v"));
    if (argc > 2 && !verbose) {
        cli_error("unexpected '%s': facetfit --version [--verbose]", argv[2]);
        return EXIT_USAGE;
    }
    return cli_print(write_version, verbose ? argv : NULL);
}

static ff_status write_schema(const void *args, FILE *out)
{
    const cli_command *command = ((const cli_args *)args)->command;
    return ff_report_schema_json(cli_given(args, FLAG_LIST) ? command->listed : command->schema, out);
}

static int unknown_command(const char *word)
{
    const char *nearest = cli_command_nearest(word);
    if (nearest) {
        cli_error("unknown command '%s'; did you mean '%s'?", word, nearest);
    } else {
        cli_error("unknown command '%s'", word);
    }
    cli_message("see 'facetfit --help'");
    return EXIT_USAGE;
}

static int run(const cli_command *command, int argc, char **argv)
{
    cli_args args;
    ff_outputs outputs = {0};
    int status = cli_args_parse(command, argc - 1, argv + 1, &args);
    args.outputs = &outputs;
    args.head = (ff_report_head){ff_version(), (size_t)argc, (const char *const *)argv};
    args.style = cli_style(&args);
    cli_notes_wanted(!cli_given(&args, FLAG_QUIET));
    if (status != EXIT_DONE) {
        /* a message has been written */
    } else if (cli_given(&args, FLAG_HELP)) {
        status = cli_print(write_help, &(help){command, !args.help_in_short});
    } else if (cli_given(&args, FLAG_PRINT_SCHEMA)) {
        status = cli_print(write_schema, &args);
    } else if ((status = cli_files_check(&args)) == EXIT_DONE) {
        status = cli_command_run(&args);
    }
    cli_args_free(&args);
    return status;
}

/* Whoever starts us with one of the three closed would have the next file that is opened take its number: messages would go into an
 * output, a table into the JSON. It is open then, and neither read nor written: those who try are told. */
static void hold_standard_descriptors(void)
{
    for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; fd++)
        if (fcntl(fd, F_GETFD) < 0) (void)!open("/dev/null", fd == STDIN_FILENO ? O_WRONLY : O_RDONLY);
}

static int run_words(int argc, char **argv)
{
    const char *word = argc > 1 ? argv[1] : NULL;
    cli_signals_catch();
    if (!word) {
        cli_help(0, stderr);
        return EXIT_USAGE;
    }
    if (!strcmp(word, "--help") || !strcmp(word, "-h") || !strcmp(word, "help")) {
        const cli_command *command = argc > 2 ? cli_command_find(argv[2]) : NULL;
        return argc > 2 && !command ? unknown_command(argv[2]) : cli_print(write_help, &(help){command, strcmp(word, "-h") != 0});
    }
    if (!strcmp(word, "--version") || !strcmp(word, "-V")) return print_version(argc, argv);
    const cli_command *command = cli_command_find(word);
    return command ? run(command, argc, argv) : unknown_command(word);
}

typedef struct line {
    int argc, status;
    char **argv;
} line;

static void *run_line(void *argument)
{
    line *l = argument;
    l->status = run_words(l->argc, l->argv);
    return NULL;
}

/* On a thread whose stack is large enough whatever the limit of the shell: `ulimit -s` of a batch system may be less than the
 * library needs. Where there is none to be had, here. */
int main(int argc, char **argv)
{
    line l = {.argc = argc, .argv = argv};
    hold_standard_descriptors();
    pthread_attr_t attributes;
    pthread_t thread;
    int failed = pthread_attr_init(&attributes);
    if (!failed) {
        failed = pthread_attr_setstacksize(&attributes, STACK) || pthread_create(&thread, &attributes, run_line, &l);
        pthread_attr_destroy(&attributes);
    }
    if (failed)
        run_line(&l);
    else
        pthread_join(thread, NULL);
    return l.status;
}
