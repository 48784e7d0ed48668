/* Many files in one command: what batch_words.c, batch.c and the commands share. */
#ifndef FF_INTERNAL_BATCHING_H
#define FF_INTERNAL_BATCHING_H
#include "internal_cli.h"
#include "cli/batch/internal_batch.h"

/* Is each FILE a material of its own? */
int cli_batch_wanted(const cli_args *args);
/* Are flags given that have no meaning with many files, or without? Exit status, as of all here that return an int. */
int cli_batch_words_check(const cli_args *args);

/* The words that all jobs have in common, and the version. */
ff_status cli_batch_words(const cli_args *args, batch_jobs *jobs);
/* --shard, or what Slurm says. */
int cli_batch_shard(const cli_args *args, batch_shard *out);

/* The command line of one job, whose JSON goes to the path `json`, and its page to `page`; NULL: there is none. To be freed
 * whatever the status. */
typedef struct cli_batch_args_of {
    cli_args args;
    const char **head, **value, *word;
    int *flag;
} cli_batch_args_of;
ff_status cli_batch_args(const cli_args *args, const batch_jobs *jobs, size_t i, const char *json, const char *page,
                         cli_batch_args_of *out);
void cli_batch_args_free(cli_batch_args_of *of);

/* Runs `command` for every file. */
int cli_batch_run(const cli_args *args, int (*command)(const cli_args *args));

/* How far a batch, or a shard of it, has come. */
typedef struct cli_batch_state {
    const batch_jobs *jobs;
    const batch_rows *rows; /* [jobs->inputs.n] */
    const batch_shard *shard;
} cli_batch_state;
/* What failed, and why, what is missing, and counts; a line each. */
ff_status cli_batch_state_write(const void *state, FILE *out);
void cli_batch_say(const cli_batch_state *s);         /* the same as messages                     */
int cli_batch_state_status(const cli_batch_state *s); /* is there a result of every file? */
/* Is the name of --summary one that can be written? */
int cli_summary_check(const cli_args *args);
/* --summary, where it is given. */
int cli_summary_write(const cli_args *args, const batch_jobs *jobs, const batch_rows *rows, const batch_shard *shard);
/* --html, where it is given: the index of the folder. */
int cli_index_write(const cli_args *args, const char *folder, const batch_jobs *jobs, const batch_rows *rows,
                    const batch_shard *shard);
/* The same as the command's --json. */
batch_summary cli_summary_of(const cli_args *args, const batch_jobs *jobs, const batch_rows *rows, const batch_shard *shard,
                             const char **head);
#endif
