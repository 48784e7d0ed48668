/* Commands and flags: what they are (commands.def, flags.def), a command line taken apart, and everything that is made of the
 * definitions: help, man pages, completion, docs/flags.md.
 *
 * A flag is one entry of flags.def. Files in the order of their calls: terminal < messages < words < definitions < values < parse,
 * files; text < help, man, completion, page. */
#ifndef FF_INTERNAL_FLAGS_H
#define FF_INTERNAL_FLAGS_H
#include "ff_report.h"
#include "ff_status.h"
#include <signal.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Exit status of the program. */
enum { EXIT_DONE = 0, EXIT_ANSWER_IS_NO = 1, EXIT_USAGE = 2, EXIT_INPUT = 3, EXIT_OUTPUT = 4, EXIT_INTERNAL = 5 };

/* ---- kinds of values -------------------------------------------------------------------------------------------------------*/

/* What a word of the command line is. The kind says how it is checked, completed and described. */
typedef enum cli_kind {
    KIND_SWITCH = 0,  /* a flag without a value                                                         */
    KIND_INPUT_FILE,  /* "-": standard input                                                            */
    KIND_OUTPUT_FILE, /* "-": standard output                                                           */
    KIND_FOLDER,
    KIND_NUMBER,      /* in [lo, hi], or (lo, hi] with `above`                                          */
    KIND_ANGLE,       /* the same, in degrees                                                           */
    KIND_INTEGER,     /* in [lo, hi], hi = 0: any                                                       */
    KIND_NUMBERS,     /* such numbers, "a,b,c" or "{a,b,c}"                                             */
    KIND_WORD,        /* one of `words`                                                                 */
    KIND_WORDS,       /* some of `words`, separated by commas                                           */
    KIND_WORD_DETAIL, /* one of `words`, and after a ':' what it takes, which the command reads         */
    KIND_EXPRESSION,  /* a model                                                                        */
    KIND_ASSIGNMENTS, /* parameters with what is said of them; the command reads them                   */
    KIND_TEXT         /* the command reads it; `words` are suggestions                                  */
} cli_kind;
int cli_kind_is_file(cli_kind kind);

/* The i-th word of a closed list, NULL after the last. */
typedef const char *cli_words(size_t i);
cli_words cli_words_loss, cli_words_loss_auto, cli_meaning_loss, cli_words_robust, cli_meaning_robust, cli_words_weighting,
    cli_words_errors, cli_words_shape, cli_words_polarization, cli_words_channels, cli_words_channels_one, cli_words_isa,
    cli_words_quantity, cli_words_azimuth, cli_words_phi, cli_words_angles, cli_words_monotone, cli_words_negative, cli_words_ndf,
    cli_words_masking, cli_words_masking_one, cli_words_term, cli_words_fresnel, cli_words_diffuse, cli_words_model, cli_words_read,
    cli_words_written, cli_words_grid, cli_words_reduce, cli_words_from, cli_words_to, cli_words_for, cli_words_export,
    cli_words_by, cli_words_table, cli_words_color, cli_words_shell, cli_words_plot, cli_meaning_plot, cli_words_tone,
    cli_words_background, cli_words_environment, cli_words_sort, cli_words_names, cli_words_surface, cli_words_facets,
    cli_words_descent;

int cli_words_find(cli_words *words, const char *word, size_t length); /* index, -1 = none of them */
size_t cli_words_count(cli_words *words);
/* Is the word none of the list, but what several of it begin with, as "smith"? */
int cli_words_is_group(cli_words *words, const char *word, size_t length);
/* "a, b, c", as much as fits. */
const char *cli_words_list(cli_words *words, char *out, size_t size);

/* The word in names [n] that is closest to `word`, NULL when none is close; the same of a list. */
const char *cli_nearest(const char *word, const char *const *names, size_t n);
const char *cli_words_nearest(cli_words *words, const char *word, size_t length);

/* ---- definitions -----------------------------------------------------------------------------------------------------------*/

typedef enum cli_command_id {
#define COMMAND(id, ...) COMMAND_##id,
#include "commands.def"
#undef COMMAND
    COMMAND_COUNT
} cli_command_id;

/* A positional word. */
typedef struct cli_place {
    const char *name; /* as the usage line and messages call it; NULL = no more */
    cli_kind kind;
    cli_words *words;
    int optional;       /* left out: standard input, of a file; of a NAME=VALUE, any number of them */
    cli_words *meaning; /* of the i-th of `words`; NULL where they say it themselves */
} cli_place;

enum { CLI_PLACES = 2, CLI_EXAMPLES = 4 };
typedef struct cli_command {
    cli_command_id id;
    const char *name;
    const char *usage;   /* of the whole line where it is not the places; NULL: those               */
    const char *summary; /* one line                                                                */
    const char *more;    /* paragraphs, separated by a newline                                      */
    cli_place place[CLI_PLACES];
    size_t repeats;           /* words that may follow the last place, as the first one                  */
    ff_schema schema, listed; /* what --json writes, and with --list; 0: the command has no JSON  */
    /* Command lines that work in a folder which has what docs/flags.md says of it. */
    const char *example[CLI_EXAMPLES];
} cli_command;

size_t cli_command_count(void);
const cli_command *cli_command_at(size_t i);
const cli_command *cli_command_find(const char *name); /* NULL when unknown */
/* "FILE", "EXPR [FILE]" */
const char *cli_command_usage(const cli_command *command, char *out, size_t size);
const char *cli_command_nearest(const char *word);

/* Headings of --help, in this order. */
typedef enum cli_group {
    GROUP_DATA,
    GROUP_MODEL,
    GROUP_WEIGHTS,
    GROUP_RETRIEVAL,
    GROUP_TRUST,
    GROUP_CONVERSION,
    GROUP_VIEW,
    GROUP_NOISE,
    GROUP_PATHS,
    GROUP_FIGURE,
    GROUP_OUTPUT,
    GROUP_BATCH,
    GROUP_RUN,
    GROUP_COUNT
} cli_group;
const char *cli_group_name(int group);

/* What flags of a group bear on: a command line that does the same to the same data has those of BEARS_RESULT. */
typedef enum cli_bearing {
    BEARS_RESULT,   /* what is read, and what is found in it              */
    BEARS_QUESTION, /* what else is asked of that                         */
    BEARS_OUTPUT    /* what is written, drawn or converted; how it is run */
} cli_bearing;

typedef enum cli_flag_id {
#define FLAG(id, ...) FLAG_##id,
#include "flags.def"
#undef FLAG
    FLAG_COUNT
} cli_flag_id;

/* What a flag is to some of its commands, where that differs; NULL or 0: as the flag itself. */
typedef struct cli_flag_other {
    unsigned commands; /* bits 1 << cli_command_id; 0 = no more */
    const char *help, *otherwise, *placeholder;
    cli_kind kind;
    cli_words *words;
    int group; /* of this command, cli_group + 1 */
} cli_flag_other;

enum { CLI_OTHERS = 4 };
typedef struct cli_flag {
    const char *name;
    char letter; /* short form, 0 = none                                                     */
    cli_kind kind;
    const char *placeholder; /* of the value; NULL for a switch                                          */
    double lo, hi;           /* of numbers                                                               */
    int above;               /* 1: lo itself is none of them                                             */
    cli_words *words;
    cli_words *meaning; /* of the i-th of `words`, a line each under the flag; NULL where the words say it themselves */
    cli_group group;
    unsigned commands;     /* bits 1 << cli_command_id                                                 */
    const char *help;      /* one line, without the default                                            */
    const char *more;      /* what the man page adds; NULL = nothing                                   */
    const char *otherwise; /* what it is when it is not given, as shown; NULL where that says nothing  */
    int bears;             /* cli_bearing + 1, where it is not that of the group */
    int chooses;           /* 1: it says which models: a command line for another model has none of these */
    int repeatable;        /* 1: all that are given count; 0: it is given once, or is a switch, of which the last one counts */
    int negatable;         /* 1: --no-NAME too                                                         */
    const char *without;   /* the value when none follows, as the last word or before a flag; NULL = one must */
    const char *older;     /* an earlier spelling that still works; NULL = none                        */
    cli_flag_other other[CLI_OTHERS];
} cli_flag;

const cli_flag *cli_flag_at(cli_flag_id flag);
cli_bearing cli_flag_bearing(const cli_flag *flag);                 /* of one as a command has it */
int cli_flag_has(const cli_flag *flag, const cli_command *command); /* does it belong to the command? */
/* The flag as the command has it. */
cli_flag cli_flag_of(cli_flag_id flag, const cli_command *command);
/* The value of a flag of words in the writing of its list, with the words of a group for its name; rest of a WORD:DETAIL as it is.
 * Into out [size]; 0: there is no room. Only for what was checked. */
int cli_words_known(const cli_flag *f, const char *value, char *out, size_t size);
const char *cli_flag_name(cli_flag_id flag);

/* ---- a command line --------------------------------------------------------------------------------------------------------*/

/* What a command is told that runs for one of many files. */
typedef struct cli_job {
    int threads; /* of its fits, in place of --threads                */
    FILE *json;  /* takes its JSON                                    */
    FILE *html;  /* and its page, with --html; nothing else is written by it */
} cli_job;

/* A command line taken apart. Words are those of argv. */
typedef struct cli_args {
    const cli_command *command;
    size_t n_words, n_given;
    const char **word;          /* [n_words] positional; the first NULL where --from stands for an expression */
    int *flag;                  /* [n_given] cli_flag_id          */
    const char **value;         /* [n_given] NULL for a switch, "no" for one that is switched off */
    ff_report_head head;        /* the whole command line         */
    ff_report_style style;      /* of text on stdout              */
    struct ff_outputs *outputs; /* of the command                 */
    const cli_job *job;         /* NULL: it is the only one       */
    int help_in_short;          /* 1: -h and not --help */
    size_t n_own;
    char **own; /* [n_own] values in the writing of their lists, "ggx" of "GGX"; what else is in `value` and `word` is argv's */
} cli_args;

/* Takes argv apart for `command` (argv[0] is its first word); every value is one of its kind. Exit status; cli_args_free
 * afterwards, whatever it is. */
int cli_args_parse(const cli_command *command, int argc, char **argv, cli_args *out);
void cli_args_free(cli_args *args);

int cli_given(const cli_args *args, cli_flag_id flag);                                /* how often       */
const char *cli_value(const cli_args *args, cli_flag_id flag, const char *otherwise); /* of the last one */
/* The last value of a flag of that kind, `otherwise` when there is none. The parser has checked it. */
int cli_switch(const cli_args *args, cli_flag_id flag, int otherwise);
double cli_number(const cli_args *args, cli_flag_id flag, double otherwise);
uint64_t cli_integer(const cli_args *args, cli_flag_id flag, uint64_t otherwise);
int cli_word(const cli_args *args, cli_flag_id flag, int otherwise); /* index into its words */

/* Is `value` one of the flag's kind? EXIT_DONE, or EXIT_USAGE and a message with flag, value and what was expected. */
int cli_value_check(const cli_args *args, const cli_flag *flag, const char *value);
/* Does the expression parse? `flag` names where it stands; NULL: a word of its own. Exit status. */
int cli_expression_check(const char *flag, const char *text);

/* Before a command runs: is an output one of its inputs or another output, however they are spelled? EXIT_DONE or EXIT_USAGE. */
int cli_files_check(const cli_args *args);
/* The same for a file that an input names: FF_ERR_UNSUPPORTED where it is an output. An ff_read_options.ask, of a cli_args. */
ff_status cli_files_ask(const void *args, const char *path, ff_error *err);

/* ---- written forms ---------------------------------------------------------------------------------------------------------*/

enum { CLI_NAME = 64, CLI_VALUES = 1024 };

/* "NAME=REST", or "NAME[CHANNEL]=REST" */
typedef struct cli_assignment {
    char name[CLI_NAME], channel[CLI_NAME]; /* channel: "" = none was named     */
    const char *rest;                       /* after '=', in the word; NULL where there is none */
} cli_assignment;
/* 0 when it is not of that form. */
int cli_assignment_read(const char *word, cli_assignment *out);

/* One decimal number that is all of text (C locale; no hexadecimal, infinity or nan). 0 when it is not. */
int cli_number_read(const char *text, double *out);
/* Numbers with `separator` between them, at most `most`: how many; 0 when something else stands there. The last may end in any of
 * `stops`; *end is where that is. */
size_t cli_numbers_read(const char *text, char separator, size_t most, double *out);
/* A list of values, "a,b,c" or "{a,b,c}": how many; 0 when it is none. */
size_t cli_list_read(const char *text, size_t most, double *out);
/* Is it "{...}"? */
int cli_is_list(const char *text);

/* Calls apply for every word of every such flag, in order, until a status is not EXIT_DONE; returns it. Words are separated by
 * commas outside of braces. */
int cli_each_word(const cli_args *args, cli_flag_id flag, int (*apply)(const cli_args *args, const char *word, void *context),
                  void *context);

/* ---- what is made of the definitions -----------------------------------------------------------------------------------------*/

enum { CLI_WIDTH = 80 };
/* Writes text in lines of at most CLI_WIDTH columns, the first of which starts at column `at`, the others at `indent`; ends the
 * line. */
void cli_wrap(FILE *out, const char *text, size_t at, size_t indent);
/* "-o, --output FILE", "--[no-]progress" */
const char *cli_flag_spelling(const cli_flag *flag, char *out, size_t size);

/* Libraries, instruction sets, modules: about.c. */
void cli_about(FILE *out);
/* all: not just a line for each. */
void cli_help_command(const cli_command *command, int all, FILE *out);
void cli_help(int all, FILE *out);
void cli_man(const char *version, FILE *out);
void cli_man_command(const cli_command *command, const char *version, FILE *out);
ff_status cli_page(FILE *out);           /* docs/flags.md */
void cli_complete(int shell, FILE *out); /* shell: index into cli_words_shell */

/* ---- the terminal ------------------------------------------------------------------------------------------------------------*/

/* Columns of the terminal behind a descriptor, 0: it is none. */
size_t cli_terminal_width(int descriptor);
/* Does it obey more than line ends? */
int cli_terminal_is_smart(int descriptor);
/* How text on stdout is laid out, by --wide, --color and the terminal. */
ff_report_style cli_style(const cli_args *args);
/* --progress; without it where stderr is a terminal that can take a line back. */
int cli_progress_wanted(const cli_args *args);
/* One line on stderr in place of the last, cut to the terminal; the end takes it away. */
void cli_progress_show(const char *format, ...) __attribute__((format(printf, 1, 2)));
void cli_progress_end(void);
extern volatile sig_atomic_t cli_progress_is_shown;

/* ---- messages --------------------------------------------------------------------------------------------------------------*/

/* "facetfit: ..." on stderr: what was done, and what else there is. */
void cli_message(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* "facetfit: error: ...": why the exit status is not 0. */
void cli_error(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* "facetfit: warning: ...": done, but a number may be wrong or a part is missing. */
void cli_warning(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* "facetfit: note: ...": worth knowing, and nothing is wrong. Not said where notes are not wanted, which the first thread says. */
void cli_note(const char *format, ...) __attribute__((format(printf, 1, 2)));
void cli_notes_wanted(int wanted);
/* From here on what this thread says goes to `out`, a line each, without "facetfit: error: ", and hints at --help nowhere; NULL: to
 * stderr again. */
FILE *cli_messages_into(FILE *out); /* returns where they went before */
int cli_usage(const cli_args *args, const char *format, ...) __attribute__((format(printf, 2, 3))); /* with a hint; EXIT_USAGE */
int cli_exit_status(ff_status status);
int cli_failed(ff_status status, const ff_error *err); /* message and exit status */
void cli_notes(const char *path, const ff_table *t);   /* notes of a table, as messages */
#endif
