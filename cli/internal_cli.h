/* The program: one table of flags, one table of commands, what the commands share. Data go to stdout, messages to stderr. */
#ifndef FF_INTERNAL_CLI_H
#define FF_INTERNAL_CLI_H
#include "ff_fit.h"
#include "ff_model.h"
#include "ff_output.h"
#include "ff_picture.h"
#include "ff_report.h"
#include "ff_status.h"
#include "ff_table.h"

/* Exit status of the program. */
enum { EXIT_DONE = 0, EXIT_ANSWER_IS_NO = 1, EXIT_USAGE = 2, EXIT_INPUT = 3, EXIT_OUTPUT = 4, EXIT_INTERNAL = 5 };

/* ---- commands ----------------------------------------------------------------------------------------------------------------*/

typedef struct cli_args cli_args;

typedef struct cli_command {
    const char *name;
    const char *usage;   /* what follows the name, flags aside */
    const char *summary; /* one line                            */
    const char *more;    /* the rest of --help                  */
    size_t      least, most; /* positional words                */
    int (*run)(const cli_args *args); /* exit status            */
} cli_command;

size_t             cli_command_count(void);
const cli_command *cli_command_at(size_t i);
int cmd_fit(const cli_args *args);
int cmd_compare(const cli_args *args);
int cmd_convert(const cli_args *args);
int cmd_eval(const cli_args *args);
int cmd_simulate(const cli_args *args);
int cmd_furnace(const cli_args *args);
int cmd_sample(const cli_args *args);
int cmd_info(const cli_args *args);
int cmd_models(const cli_args *args);
int cmd_formats(const cli_args *args);
int cmd_ndf(const cli_args *args);
int cmd_resample(const cli_args *args);

/* ---- flags -------------------------------------------------------------------------------------------------------------------*/

/* Order of the table in flags.c. */
typedef enum cli_flag_id {
    FLAG_MODEL,
    FLAG_NDF,
    FLAG_MASKING,
    FLAG_FRESNEL,
    FLAG_DIFFUSE,
    FLAG_SET,
    FLAG_FREE,
    FLAG_FIX,
    FLAG_BOUND,
    FLAG_PRIOR,
    FLAG_TIE,
    FLAG_ENERGY,
    FLAG_TABLE,
    FLAG_SHAPE,
    FLAG_LOSS,
    FLAG_ROBUST,
    FLAG_SATURATION,
    FLAG_NEGATIVE,
    FLAG_WEIGHT,
    FLAG_MAX_THETA,
    FLAG_CUT_OFF,
    FLAG_PROFILE,
    FLAG_BOOTSTRAP,
    FLAG_CROSS_VALIDATE,
    FLAG_RESIDUALS,
    FLAG_CHANNELS,
    FLAG_MEAN_SLOPE,
    FLAG_MAX_ITERATIONS,
    FLAG_SMOOTH,
    FLAG_NODES,
    FLAG_MONOTONE,
    FLAG_FROM,
    FLAG_TO,
    FLAG_BY,
    FLAG_LIST,
    FLAG_TERMS,
    FLAG_MARKDOWN,
    FLAG_ROWS,
    FLAG_GRID,
    FLAG_NOISE,
    FLAG_NOISE_FLOOR,
    FLAG_SIGMA,
    FLAG_SEED,
    FLAG_COLUMNS,
    FLAG_QUANTITY,
    FLAG_SCALE,
    FLAG_PART,
    FLAG_REDUCE,
    FLAG_EXTRAPOLATE,
    FLAG_OUTPUT,
    FLAG_WEAK,
    FLAG_MU,
    FLAG_THETA,
    FLAG_PHI,
    FLAG_SAMPLES,
    FLAG_FORMAT,
    FLAG_THREADS,
    FLAG_ISA,
    FLAG_JSON,
    FLAG_PROGRESS,
    FLAG_NO_PROGRESS,
    FLAG_HELP,
    FLAG_COUNT
} cli_flag_id;

/* A command line taken apart. Words are those of argv. */
struct cli_args {
    const cli_command *command;
    size_t             n_words, n_given;
    const char       **word;   /* [n_words] positional           */
    int               *flag;   /* [n_given] cli_flag_id          */
    const char       **value;  /* [n_given] NULL for a switch    */
    ff_report_head     head;   /* the whole command line         */
};

/* Takes argv apart for `command` (argv[0] is its first word). Exit status; cli_args_free afterwards, whatever it is. */
int  cli_args_parse(const cli_command *command, int argc, char **argv, cli_args *out);
void cli_args_free(cli_args *args);

const char *cli_flag_name(cli_flag_id flag);
int         cli_given(const cli_args *args, cli_flag_id flag);                          /* how often               */
const char *cli_value(const cli_args *args, cli_flag_id flag, const char *otherwise);   /* of the last one         */

/* Calls apply for every comma-separated word of every such flag, in order, until a status is not EXIT_DONE; returns it. */
int cli_each_word(const cli_args *args, cli_flag_id flag, int (*apply)(const cli_args *args, const char *word, void *context),
                  void *context);

void cli_help_command(const cli_command *command, FILE *out);
void cli_help(FILE *out);
/* The word in names [n] that is closest to `word`, NULL when none is close. */
const char *cli_nearest(const char *word, const char *const *names, size_t n);

/* ---- messages and numbers ----------------------------------------------------------------------------------------------------*/

void cli_message(const char *format, ...) __attribute__((format(printf, 1, 2)));     /* "facetfit: ..." on stderr */
int  cli_usage(const cli_args *args, const char *format, ...) __attribute__((format(printf, 2, 3))); /* with a hint; EXIT_USAGE */
int  cli_exit_status(ff_status status);
int  cli_failed(ff_status status, const ff_error *err); /* message and exit status */
void cli_notes(const char *path, const ff_table *t);    /* notes of a table, as messages */

/* Numbers of a flag, in [lo, hi]. EXIT_DONE or EXIT_USAGE with a message; *out keeps its value when the flag is not given. */
int cli_number(const cli_args *args, cli_flag_id flag, double lo, double hi, double *out);
int cli_integer(const cli_args *args, cli_flag_id flag, uint64_t hi, uint64_t *out);
/* Index of the flag's value by `find`; names of all by `name` for the message. *out keeps its value when the flag is not given. */
int cli_choice(const cli_args *args, cli_flag_id flag, int (*find)(const char *), const char *(*name)(int), int count, int *out);
int cli_isa(const cli_args *args, ff_isa *out);

/* ---- a model and its parameters ----------------------------------------------------------------------------------------------*/

/* What --table names: the profile of `tabulated` lobes. NULL where the flag is not given. */
typedef struct cli_tables {
    struct ff_profile_table *profile;
} cli_tables;
int  cli_tables_read(const cli_args *args, cli_tables *out);
void cli_tables_free(cli_tables *tables);
/* Gives the lobes of m their tables, which must outlive it. FF_ERR_UNSUPPORTED when one is needed and there is none. */
ff_status cli_tables_give(const cli_tables *tables, ff_model *m, ff_error *err);

/* --free and --fix on a model; where_present: a name that this model does not have is not an error. Exit status. */
int cli_hold_and_free(const cli_args *args, ff_model *m, int where_present);
/* What --bound, --prior, --tie and --energy-conserving say, for fits of n models; where_present: what a model lacks is left out, as
 * long as one has it. Exit status; to be freed whatever it is. The names are those of the command line. */
typedef struct cli_constraints {
    ff_constraints c;
    ff_bound      *bound;
    ff_prior      *prior;
    ff_tie        *tie;
    size_t         n_names;
    char         **names;
} cli_constraints;
int  cli_constraints_read(const cli_args *args, const ff_model *model, size_t n, int where_present, cli_constraints *out);
void cli_constraints_free(cli_constraints *constraints);

/* A usage error for a name of --free or --fix that none of n models has. */
int cli_names_known(const cli_args *args, const ff_model *model, size_t n);

typedef struct cli_scene {
    ff_model model;
    size_t   n_channels;
    double   shape[FF_MAX_SHAPE];
    double  *channel; /* [n_channels][model.n_channel] */
    cli_tables tables;
} cli_scene;

/* The expression with every --set applied. As many channels as the longest list v1:v2:..., at least `least_channels`. */
int  cli_scene_make(const cli_args *args, const char *expression, size_t least_channels, cli_scene *out);
void cli_scene_free(cli_scene *scene);
/* "" for one channel, "_r", "_g", "_b" for three, "_c0" ... otherwise. */
const char *cli_channel_suffix(size_t n_channels, size_t c, char out[24]);

/* ---- measured data -----------------------------------------------------------------------------------------------------------*/

/* Reads `path` with the options of the flags, reduced as --reduce says; notes as messages when with_notes. Exit status; the table is
 * to be freed after EXIT_DONE. */
int cli_read(const cli_args *args, const char *path, int with_notes, ff_table *out);

/* The format to write `path` in: by the flag, or by its extension; CSV for "-". Exit status. */
int cli_format_for_writing(const cli_args *args, cli_flag_id flag, const char *path, const ff_format **out);

/* ---- outputs -----------------------------------------------------------------------------------------------------------------*/

/* Writes a whole document to path ("-" is stdout) through `write`. Exit status. */
typedef ff_status (*cli_writer)(const void *context, FILE *out);
int cli_write(const char *path, cli_writer write, const void *context);
/* --json F: F alone when it is "-", else F and the text on stdout. */
int cli_write_both(const cli_args *args, cli_writer json, cli_writer text, const void *context);

/* A table of numbers, row by row, as CSV or as JSON {columns, rows} with --json. */
typedef struct cli_rows {
    ff_output csv, json;
    int       with_csv, with_json;
    ff_json   writer;
    size_t    column;
} cli_rows;
int  cli_rows_open(const cli_args *args, const char *schema, cli_rows *rows);
void cli_rows_column(cli_rows *rows, const char *name);  /* each column once, then cli_rows_end_header */
void cli_rows_end_header(cli_rows *rows);
void cli_rows_number(cli_rows *rows, double x);          /* each cell, then cli_rows_end_row */
void cli_rows_end_row(cli_rows *rows);
int  cli_rows_commit(cli_rows *rows);
void cli_rows_abort(cli_rows *rows);

/* ---- Ctrl-C ------------------------------------------------------------------------------------------------------------------*/

/* From here on SIGINT and SIGTERM set the flag that is returned; a second one ends the program at once. */
const volatile int *cli_catch_signals(void);

/* ---- fit and compare ---------------------------------------------------------------------------------------------------------*/

/* Data, options and problems that both share. */
typedef struct cli_fitting {
    const char     *path;
    ff_table        table;
    ff_fit_options  options;
    size_t          n_problems;
    ff_problem    **problem;
    int             progress;      /* 1: shown on stderr                                            */
    int             keeps_samples; /* 1: the table still has its samples; else only what a report says of it */
    int             choose_loss;   /* 1: --loss auto; cli_fitting_open leaves the problems to cli_fitting_choose */
} cli_fitting;
/* Reads args->word[0]; the n_models models are those that will be fitted. keep_samples: also where only the problems need
 * them. Exit status; close only after EXIT_DONE. */
int  cli_fitting_open(const cli_args *args, const ff_model *models, size_t n_models, int keep_samples, cli_fitting *out);
void cli_fitting_close(cli_fitting *f);
/* One fit with its progress; `label` names it there. */
ff_status cli_fitting_run(cli_fitting *f, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err);
/* --loss auto: every loss, and the choice among them, which the options have afterwards. The problem is `out`'s. */
ff_status cli_fitting_choose(cli_fitting *f, const ff_model *m, const char *label, ff_adaptive *out, ff_error *err);
/* Says so when the fit did not converge; EXIT_DONE or EXIT_ANSWER_IS_NO. */
int cli_fitting_say_outcome(const ff_fit_result *fit);
/* Fits for the report; `fit` [n_fits]. */
ff_report_fits cli_fitting_report(const cli_args *args, const cli_fitting *f, const ff_fit_result *fit, size_t n_fits);


/* ---- how far fits can be trusted ---------------------------------------------------------------------------------------------*/

/* What the flags ask for, and what came of it. Zero is a legal one to free. */
typedef struct cli_trust {
    size_t           bootstrap, folds; /* 0: none                              */
    uint64_t         seed;
    int              profile;
    double           cut_off;          /* radians; 0: none                     */
    int              cut_off_given;    /* 1: asked for                         */
    const char      *residuals;        /* file; NULL: none                     */
    size_t           n_fits, n_places;
    ff_report_trust *each;             /* [n_fits]                             */
    ff_places       *places;           /* [n_places] one for each problem      */
    int              has_difference;
    ff_difference    difference;
} cli_trust;

/* --saturation, --noise-floor, --negative. Exit status, as all here. */
int cli_read_censoring(const cli_args *args, ff_fit_options *o);
int cli_trust_read(const cli_args *args, const ff_fit_options *o, cli_trust *out);
/* After `fit`: fit i belongs to problem i; its errors and intervals are replaced as the flags ask. */
int cli_trust_fit(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits);
/* After `compare`: best [n_problems] is the best fit of each problem. */
int cli_trust_compare(cli_trust *t, cli_fitting *f, const ff_fit_result *fit, size_t n_fits, const size_t *best);
void cli_trust_report(const cli_trust *t, ff_report_fits *r);
void cli_trust_free(cli_trust *t);
/* Is the name of --residuals one that can be written? Then the residuals of a fit to the first problem. */
int cli_residuals_check(const cli_args *args);
int cli_residuals_write(const cli_trust *t, cli_fitting *f, const ff_fit_result *fit);

#endif
