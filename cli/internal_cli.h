/* What the commands share. Data go to stdout, messages to stderr. */
#ifndef FF_INTERNAL_CLI_H
#define FF_INTERNAL_CLI_H
#include "ff_aperture.h"
#include "internal_flags.h"
#include "fit/interface/fit_struct.h"
#include "models/model_struct.h"
#include "base/internal_output.h"
#include "fit/picture/picture_struct.h"
#include "fit/fitting/internal_fitting.h"
#include "ff_report.h"
#include "ff_status.h"
#include "data_formats/table/table_struct.h"

/* ---- commands ----------------------------------------------------------------------------------------------------------------*/

/* Exit status of each. */
#define COMMAND(ID, ...) int cmd_##ID(const cli_args *args);
#include "commands.def"
#undef COMMAND
/* Runs args->command. */
int cli_command_run(const cli_args *args);

/* Index of the instruction set that --isa names. Exit status. */
int cli_isa(const cli_args *args, ff_isa *out);

/* ---- a model and its parameters ----------------------------------------------------------------------------------------------*/

/* What --ndf-table names: the profile of `tabulated` lobes. NULL where the flag is not given. */
typedef struct cli_tables {
    struct ff_profile_table *profile;
} cli_tables;
int cli_tables_read(const cli_args *args, cli_tables *out);
void cli_tables_free(cli_tables *tables);
/* Gives the lobes of m their tables, which must outlive it. FF_ERR_UNSUPPORTED when one is needed and there is none. */
ff_status cli_tables_give(const cli_tables *tables, ff_model *m, ff_error *err);

/* --free, and --fix with one value, on a model; where_present: a name that this model does not have is not an error. Exit
 * status. */
int cli_hold_and_free(const cli_args *args, ff_model *m, int where_present);
/* What --bound, --prior, --tie, --energy-conserving and --fix with values by channel say, for fits of n models; where_present: what
 * a model lacks is left out, as long as one has it. Exit status; to be freed whatever it is. The names are those of the command
 * line. */
typedef struct cli_constraints {
    ff_constraints c;
    ff_bound *bound;
    ff_prior *prior;
    ff_tie *tie;
    ff_fixed *fixed;
    const char **because; /* of each bound */
    size_t n_room;        /* of bound      */
    size_t n_names, n_values;
    char **names;
    double **values;
} cli_constraints;
int cli_constraints_read(const cli_args *args, const ff_model *model, size_t n, int where_present, cli_constraints *out);
void cli_constraints_free(cli_constraints *constraints);

/* --polarization: the model becomes one of such light; with `both` each channel's share of s light is held at what its name says,
 * and all channels have one index of refraction, which is for the constraints of n models that fit `table`. A file whose names say
 * nothing, or a model whose Fresnel term knows no polarization, is a usage error. */
int cli_polarize(const cli_args *args, ff_model *m);
int cli_polarize_channels(const cli_args *args, const ff_table *table, const ff_model *model, size_t n, cli_constraints *c);

/* Adds the bounds beyond 1 that --reduce srgb and --free ks ask for, of n models, which must outlive the constraints; as many as
 * there is room for. */
void cli_boxes_assume(const cli_args *args, const ff_model *model, size_t n, cli_constraints *c);

/* Do the flags let reflectances exceed 1? */
int cli_boxes_are_open(const cli_args *args);

/* A usage error for a name of --free or --fix that none of n models has. */
int cli_names_known(const cli_args *args, const ff_model *model, size_t n);

/* The parameter of n models whose name is nearest, NULL when none is near. It lives as long as the models. */
const char *cli_param_nearest(const ff_model *model, size_t n, const char *name);

typedef struct cli_scene {
    ff_model model;
    size_t n_channels;
    double shape[FF_MAX_SHAPE];
    double *channel; /* [n_channels][model.n_channel] */
    cli_tables tables;
    ff_aperture aperture; /* of the document that --from names; else a point */
    /* Other models that a --set may be of; one that no model has is an error. */
    const struct ff_model *others;
    size_t n_others;
} cli_scene;

/* The expression, or with NULL the best model of the document that --from names, with every --set applied. As many channels as the
 * longest list v1:v2:..., at least `least_channels`. */
int cli_scene_make(const cli_args *args, const char *expression, size_t least_channels, cli_scene *out);
/* The same for one of several models: own: values of it alone, "alpha=0.2,f0=1" or "", which win over --set. */
int cli_scene_make_among(const cli_args *args, const char *expression, const char *own, const ff_model *others, size_t n_others,
                         cli_scene *out);
void cli_scene_free(cli_scene *scene);
/* "" for one channel, "_r", "_g", "_b" for three, "_c0" ... otherwise. */
const char *cli_channel_suffix(size_t n_channels, size_t c, char out[24]);

/* Models of every combination of terms, and how many combinations had no meaning. */
typedef struct cli_combinations {
    ff_model *model;          /* freed by the caller, whatever the status was */
    ff_report_target *target; /* [n] of renderers' materials, likewise; else NULL */
    size_t n, left_out;
    char example[256]; /* the first one left out, and why */
} cli_combinations;
/* What --ndf, --masking, --fresnel and --diffuse list; all_ndf and all_masking where they are not given. Exit status. */
int cli_combine(const cli_args *args, const cli_tables *tables, const char *all_ndf, const char *all_masking,
                cli_combinations *out);

/* The materials that --for names, "blender", "blender:metal" or with `several` a list of such or "all", with --free and --fix on
 * them. Exit status; model and target are to be freed whatever it is. */
int cli_renderers_read(const cli_args *args, int several, cli_combinations *out);

/* ---- a command line for another command ---------------------------------------------------------------------------------------*/

/* An ff_report_again of a cli_args, of `fit` or `compare`. Which flags go along is said by their groups and their commands; of what
 * they say of parameters, that of parameters which the other command has. */
int cli_again(const void *args, const char *command, const ff_report_change *change, size_t n, char *out, size_t size);

/* ---- measured data -----------------------------------------------------------------------------------------------------------*/

/* --reference and --dark, of signals that were read with these options: t is changed, and notes what was done. Exit status. */
int cli_calibrate(const cli_args *args, const ff_read_options *o, ff_table *t);

/* Reads `path` with the options of the flags, reduced as --reduce says; notes as messages when with_notes. Exit status; the table
 * is to be freed after EXIT_DONE. */
int cli_read(const cli_args *args, const char *path, int with_notes, ff_table *out);

/* Does the command read several FILEs as one measurement? */
int cli_joins_files(const cli_command *command);

/* The format to write `path` in: by the flag, or by its extension; CSV for "-". Exit status. */
int cli_format_for_writing(const cli_args *args, cli_flag_id flag, const char *path, const ff_format **out);

/* ---- outputs -----------------------------------------------------------------------------------------------------------------*/

/* All outputs of a command, standard output among them, belong together (args->outputs): a file that it writes has its new content
 * when all others can have theirs. Whatever writes one opens it with them; what writes the last one commits them, and the runner
 * does, or drops them, where a command is done. Exit status. */
int cli_outputs_commit(const cli_args *args);
/* After a command that ended with this status: commits what is left, or drops it where the command failed. The exit status then. */
int cli_outputs_end(const cli_args *args, int status);

/* Writes a whole document to path ("-" is stdout) through `write`, as one of the outputs. Exit status. */
typedef ff_status (*cli_writer)(const void *context, FILE *out);
int cli_write(const cli_args *args, const char *path, cli_writer write, const void *context);
/* To stdout, alone: where nothing else is written. */
int cli_print(cli_writer write, const void *context);
/* --json F: F alone when it is "-", else F and the text on stdout. Commits, as the two after it. */
int cli_write_both(const cli_args *args, cli_writer json, cli_writer text, const void *context);

/* A report that has a table: the same, and with --table FORM the table instead of the text, the warnings on stderr. */
typedef struct cli_form {
    cli_writer json, text;
    ff_status (*table)(const void *context, ff_table_form form, FILE *out);
    void (*warnings)(const void *context, FILE *out); /* NULL: there are none */
} cli_form;
int cli_report(const cli_args *args, const cli_form *form, const void *context);

/* A table of numbers, row by row, as CSV or, with --json, as the command's JSON: {columns, rows}. */
typedef struct cli_rows {
    const cli_args *args;
    ff_output csv, json;
    int with_csv, with_json;
    ff_json writer;
    size_t column;
} cli_rows;
int cli_rows_open(const cli_args *args, cli_rows *rows);
void cli_rows_column(cli_rows *rows, const char *name); /* each column once, then cli_rows_end_header */
void cli_rows_end_header(cli_rows *rows);
void cli_rows_number(cli_rows *rows, double x); /* each cell, then cli_rows_end_row */
void cli_rows_end_row(cli_rows *rows);
int cli_rows_commit(cli_rows *rows);
void cli_rows_abort(cli_rows *rows);

/* --html F: the page of fits, or of a table. Exit status, EXIT_DONE where the flag is not given. */
int cli_page_fits(const cli_args *args, const ff_report_fits *report);
int cli_page_table(const cli_args *args, const char *path, const ff_table *t);

/* ---- signals -----------------------------------------------------------------------------------------------------------------*/

/* From here on a signal that ends the program removes what is written and unfinished first. Ctrl-C is said, and is exit status
 * 130. Called by the first thread before there are others. */
void cli_signals_catch(void);

/* ---- fit and compare ---------------------------------------------------------------------------------------------------------*/

/* Data, options and problems that both share. */
typedef struct cli_fitting {
    const char *path;
    ff_table table;
    ff_fit_options options;
    size_t n_problems;
    ff_problem **problem;
    int progress;         /* 1: shown on stderr                                            */
    int keeps_samples;    /* 1: the table still has its samples; else only what a report says of it */
    ff_noise *noise;      /* of --noise-model, which the options borrow; NULL: estimated          */
    int choose_loss;      /* 1: --loss auto; cli_fitting_open leaves the problems to cli_fitting_choose */
    int by_noise;         /* 1: --weight noise: fitted once more, after cli_fitting_weigh                  */
    int errors_given;     /* 1: --errors is there                                                       */
    ff_aperture aperture; /* of --aperture, which the options borrow                                */
} cli_fitting;
/* Reads `path`; the n_models models are those that will be fitted. keep_samples: also where only the problems need
 * them. Exit status; close only after EXIT_DONE. */
int cli_fitting_open(const cli_args *args, const char *path, const ff_model *models, size_t n_models, int keep_samples,
                     cli_fitting *out);
void cli_fitting_close(cli_fitting *f);
/* What the fits are made of, for ff_fitting_fit and the like: they show their progress, and what they note is a message. It borrows
 * f. */
ff_fitting cli_fitting_data(cli_fitting *f);
/* One fit with its progress; `label` names it there. */
ff_status cli_fitting_run(cli_fitting *f, size_t problem, const ff_model *m, const char *label, ff_fit_result *out, ff_error *err);
/* --loss auto: every loss, and the choice among them, which the options have afterwards. The problem is `out`'s. */
ff_status cli_fitting_choose(cli_fitting *f, const ff_model *m, const char *label, ff_adaptive *out, ff_error *err);
/* Says so when the fit did not converge; EXIT_DONE or EXIT_ANSWER_IS_NO. */
int cli_fitting_say_outcome(const ff_fit_result *fit);
/* Says so when a parameter has nothing to act on: its lobe or base came out as nothing. Likewise. */
int cli_fitting_say_determined(const ff_fit_result *fit);
/* Fits for the report; `fit` [n_fits]. */
ff_report_fits cli_fitting_report(const cli_args *args, const cli_fitting *f, const ff_fit_result *fit, size_t n_fits);

/* ---- how far fits can be trusted ---------------------------------------------------------------------------------------------*/

/* What the flags ask for, and what came of it. Zero is a legal one to free. */
typedef struct cli_trust {
    ff_looks looks;
    const char *residuals; /* file; NULL: none */
} cli_trust;

/* --aperture and --source; what is not given is as in `otherwise`, NULL for a point. */
int cli_aperture(const cli_args *args, const ff_aperture *otherwise, ff_aperture *out);
int cli_trust_read(const cli_args *args, const ff_fit_options *o, cli_trust *out);
/* After `fit`: fit i belongs to problem i; its errors and intervals are replaced as the flags ask. */
int cli_trust_fit(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits);
/* After `compare`: best [n_problems] is the best fit of each problem. */
int cli_trust_compare(cli_trust *t, cli_fitting *f, ff_fit_result *fit, size_t n_fits, const size_t *best);
void cli_trust_report(const cli_trust *t, ff_report_fits *r);
void cli_trust_free(cli_trust *t);
/* Is the name of --residuals one that can be written? Then the residuals of a fit to the first problem. */
int cli_residuals_check(const cli_args *args);
int cli_residuals_write(const cli_args *args, const cli_trust *t, cli_fitting *f, const ff_fit_result *fit);

#endif
