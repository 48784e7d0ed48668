/* Many files, each a material of its own: which they are and where their results go, what was done of them, one table of all.
 *
 *  A job is one file, and its result one JSON in the folder of the batch. The folder also has `jobs.tsv`, the list of all jobs with
 *  what they have in common, and journals, a line for every job that ended. A journal is appended to and never rewritten, so that
 *  a process that is killed leaves at most half a line, which is passed over. Shards write a journal each.
 *
 *  Nothing here knows what a job does: cli/batch.c runs the command. Files in the order of their calls: fields < inputs < jobs <
 *  journal; rows < summary < changes, index; thumbnail; engine.
 *  Errors   FF_ERR_MEMORY everywhere, and what is said. Outputs are written only on FF_OK unless they are to be freed all the same.
 *  Threads  what is not said to be for many belongs to one at a time. */
#ifndef FF_INTERNAL_BATCH_H
#define FF_INTERNAL_BATCH_H
#include "base/internal_sha256.h"
#include "report/ff_report.h"
#include "ff_status.h"
#include <stddef.h>
#include <stdio.h>

/* ---- lines of fields -------------------------------------------------------------------------------------------------------*/

/* Writes text so that it holds no tab and no end of line: these as \t, \n and \r, a backslash as \\. */
void batch_field_put(const char *text, FILE *out);
/* Takes a line apart at its tabs, in place, and undoes the above: how many fields, of which the first `most` are in field. */
size_t batch_fields(char *line, char **field, size_t most);
/* "FOLDER/NAME", to be freed; NULL: no memory. */
char *batch_path(const char *folder, const char *name);
/* The bytes of a regular file, *n of them, to be freed; NULL: there is none, or no memory. */
char *batch_read_whole(const char *path, size_t *n);

/* ---- inputs ----------------------------------------------------------------------------------------------------------------*/

typedef struct batch_input {
    char *path; /* as it is read                                                 */
    char *name; /* of its JSON, in the folder of the batch; NULL before it has one */
    size_t own; /* where in the path begins what the name is made of             */
} batch_input;

/* Zeroed is empty. */
typedef struct batch_inputs {
    size_t n, room;
    batch_input *at;
    size_t n_passed; /* files of folders that no format knows */
    char **passed;   /* [n_passed]                            */
} batch_inputs;

/* The files that words name: a file, a folder, for all in it and below it by name, or @LIST, a file with a name in each line. A
 * file that is named twice is taken once. format: of all files, NULL: by content, and what of a folder no format knows is passed
 * over; what was named itself never is. FF_ERR_OPEN, FF_ERR_UNSUPPORTED. `out` is to be freed whatever the status. */
ff_status batch_inputs_read(const char *const *words, size_t n, const char *format, batch_inputs *out, ff_error *err);
/* Gives all their names: that of the file, below the folder where one was named, with '_' for '/', and ".json" after it; by_path:
 * the whole path. It depends on nothing but the file's own words. FF_ERR_UNSUPPORTED says which two have the same. */
ff_status batch_inputs_name(batch_inputs *in, int by_path, ff_error *err);
ff_status batch_inputs_add(batch_inputs *in, const char *path, size_t own, ff_error *err);
void batch_inputs_free(batch_inputs *in);

/* ---- jobs ------------------------------------------------------------------------------------------------------------------*/

/* What all jobs of a folder have in common, and which they are. */
typedef struct batch_jobs {
    char *version; /* of the program                                                                     */
    size_t n_words;
    char **word;              /* [n_words] of the command, without files and without what has no part in the results  */
    char key[FF_SHA256_TEXT]; /* of version, words and files that all jobs read                          */
    batch_inputs inputs;
} batch_jobs;

/* Fills `key`; table: a file that all jobs read besides, NULL. FF_ERR_OPEN where that cannot be read. */
ff_status batch_jobs_key(batch_jobs *jobs, const char *table, ff_error *err);
/* SHA-256 of everything that the result of job i depends on but for the content of its file. */
void batch_job_key(const batch_jobs *jobs, size_t i, char out[FF_SHA256_TEXT]);
/* FOLDER/jobs.tsv, which is left alone where it says the same. FF_ERR_WRITE. */
ff_status batch_jobs_write(const batch_jobs *jobs, const char *folder, ff_error *err);
/* FF_ERR_OPEN, FF_ERR_FORMAT; to be freed whatever the status. */
ff_status batch_jobs_read(const char *folder, batch_jobs *out, ff_error *err);
void batch_jobs_free(batch_jobs *jobs);

/* A share of the jobs: every count-th from the first on. */
typedef struct batch_shard {
    size_t index, count; /* index 1 ... count; 1 of 1 is all */
} batch_shard;
/* "3/8": 0 when it is none. */
int batch_shard_parse(const char *text, batch_shard *out);
int batch_shard_has(const batch_shard *s, size_t job);
/* Removes what a run of this shard that was killed left of results that it was writing, "NAME.part-...": for whoever has its
 * journal open, and before anything is written. */
void batch_parts_remove(const batch_jobs *jobs, const char *folder, const batch_shard *s);

/* ---- the journal -----------------------------------------------------------------------------------------------------------*/

/* One job that ended. */
typedef struct batch_entry {
    const char *name, *message; /* of the JSON; what was said                             */
    char input[FF_SHA256_TEXT], job[FF_SHA256_TEXT], output[FF_SHA256_TEXT]; /* "-": none */
    int status;            /* exit status                                            */
    double seconds, ended; /* wall clock; since 1970                                 */
} batch_entry;

typedef struct batch_journal {
    size_t n, room;
    batch_entry *entry; /* [n] by name, then by when they ended */
    char **text;        /* [n] what the entries point into       */
} batch_journal;

/* All journals of the folder; none is an empty one. A line that is not whole is passed over. FF_ERR_READ; to be freed whatever the
 * status. */
ff_status batch_journal_read(const char *folder, batch_journal *out, ff_error *err);
void batch_journal_free(batch_journal *j);
/* The last that is of this name and key; NULL: none. */
const batch_entry *batch_journal_find(const batch_journal *j, const char *name, const char *key);

/* The journal of a shard, to append to; it is ours alone while it is open. FF_ERR_WRITE. */
ff_status batch_log_open(const char *folder, const batch_shard *shard, int *fd, ff_error *err);
/* In one piece. For one thread at a time. */
ff_status batch_log_add(int fd, const char *folder, const batch_entry *e, ff_error *err);

/* ---- rows ------------------------------------------------------------------------------------------------------------------*/

typedef enum batch_state { BATCH_DONE, BATCH_FAILED, BATCH_MISSING, BATCH_STATES } batch_state;
const char *batch_state_name(int state);

typedef struct batch_value {
    char *name; /* "alpha_x", "f0[r]"                       */
    double value, error;
    int tied; /* 1: it follows another parameter */
} batch_value;

/* What the table says of one problem of a file: of its best fit. */
typedef struct batch_row {
    char *model, *channels, *outcome, *quality, *verdict, *warnings; /* codes with blanks between; "" where there is nothing */
    double samples, explained, objective, rmse;                      /* NaN where there is none                              */
    size_t n_values;
    batch_value *value;
} batch_row;

/* What the table says of a job. */
typedef struct batch_rows {
    batch_state state;
    char *message; /* what was said, NULL: nothing */
    char *picture; /* batch_thumbnail, NULL: none  */
    size_t n;
    batch_row *row; /* [n]                         */
} batch_rows;

/* Of a document of fits, text [n]. FF_ERR_FORMAT, FF_ERR_DATA. */
ff_status batch_rows_of(const char *text, size_t n, const char *path, batch_rows *out, ff_error *err);
void batch_rows_free(batch_rows *r);

/* ---- the table -------------------------------------------------------------------------------------------------------------*/

typedef enum batch_order { BATCH_BY_FILE, BATCH_BY_VERDICT, BATCH_BY_RESIDUAL, BATCH_ORDERS } batch_order;
const char *batch_order_name(size_t i); /* NULL after the last */

typedef struct batch_summary {
    ff_report_head head;
    const batch_inputs *inputs;
    const batch_rows *rows; /* [inputs->n]                                              */
    const batch_shard *shard;
    batch_order order; /* by file: that of the jobs; else the worst first          */
} batch_summary;

/* A line of the table: a row of a job, NULL where it has none. */
typedef struct batch_line {
    size_t job;
    const batch_rows *rows;
    const batch_row *row;
    double badness;
} batch_line;
/* In their order; to be freed. NULL: no memory. */
batch_line *batch_lines_of(const batch_summary *s, size_t *n);

ff_status batch_summary_csv(const void *summary, FILE *out);
ff_status batch_summary_json(const void *summary, FILE *out); /* FF_SCHEMA_SUMMARY */

/* ---- the index -------------------------------------------------------------------------------------------------------------*/

enum { BATCH_THUMBNAIL = 48 };
/* A lit sphere of the best fit of a document, text [n]: a PNG of so many pixels as base64, to be freed. NULL where there is none.
 */
char *batch_thumbnail(const char *text, size_t n);
/* "a.csv.html" of "a.csv.json", to be freed; NULL: no memory. */
char *batch_page_name(const char *json);

typedef struct batch_index {
    batch_summary s;
    const char *way;      /* from the page to the folder, "" or with '/' at its end            */
    const char *has_page; /* [inputs->n] not 0: the file has one in the folder; NULL: none has */
} batch_index;
ff_status batch_index_html(const void *index, FILE *out);

/* ---- two tables ------------------------------------------------------------------------------------------------------------*/

/* A summary read back. */
typedef struct batch_table {
    size_t n, n_columns, room;
    char **line;  /* [n + 1] what the cells point into, the head first */
    char ***cell; /* [n + 1][n_columns]                                */
} batch_table;

/* FF_ERR_OPEN, FF_ERR_FORMAT; to be freed whatever the status. */
ff_status batch_table_read(const char *path, batch_table *out, ff_error *err);
void batch_table_free(batch_table *t);

/* What is not as it was. */
typedef struct batch_change {
    const char *file, *channels, *what; /* a parameter, or "state", "model", "outcome", "quality", "file" */
    const char *before, *after;         /* as they stand in the tables; "" where there is none           */
    double errors;                      /* how many of its errors a parameter moved by; NaN: not known   */
} batch_change;

typedef struct batch_changes {
    size_t n, room, n_rows; /* n_rows: that are in both */
    batch_change *change;   /* [n] in the order of the new table, then what only the old one has */
} batch_changes;

/* limit: how many errors make a move; a parameter that has none moved where it differs by more than FF_FITS_TIE of it. The tables
 * must outlive the changes, which are to be freed whatever the status. */
ff_status batch_changes_find(const batch_table *before, const batch_table *after, double limit, batch_changes *out);
void batch_changes_free(batch_changes *c);
ff_status batch_changes_table(const batch_changes *c, ff_table_form form, const ff_report_style *style, FILE *out);

/* ---- work ------------------------------------------------------------------------------------------------------------------*/

typedef struct batch_engine {
    size_t n;
    int workers, threads;                                /* jobs at once; threads of all of them together */
    void (*run)(void *context, size_t job, int threads); /* threads: that the job may use */
    void *context;
    const volatile int *stop; /* not 0: no more are begun */
} batch_engine;

/* Runs all jobs, `workers` at once, the first ones first; threads that are left over are shared among those that run. Meanwhile a
 * signal that ends the program lets nobody be between batch_hold and batch_release, removes what is unfinished and ends it, within
 * a second. For one batch at a time. FF_ERR_MEMORY: fewer threads than asked for are not an error, none is. */
ff_status batch_engine_run(const batch_engine *e);
void batch_hold(void);
void batch_release(void);
#endif
