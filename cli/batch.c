/* fit and compare of many files, each a material of its own: a job for each, on as many threads as there are, with its JSON in a
 * folder. What a job says is kept with it; what was done is in the journal of the folder. */
#define _GNU_SOURCE
#include "internal_batching.h"
#include "base/internal_errno.h"
#include "base/internal_kept.h"
#include "base/internal_pool.h"
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

typedef struct batch {
    const cli_args *args;
    int (*command)(const cli_args *args);
    const char *folder;
    batch_shard shard;
    batch_jobs jobs;
    batch_journal known; /* what earlier runs did, with --resume; else empty */
    int log;
    batch_rows *rows; /* [jobs.inputs.n], each written by its own job         */
    int *answer;      /* [jobs.inputs.n] exit status of each                  */
    size_t *mine, n_mine;
    int keep_going, progress, pages; /* pages: each file has one, and there is an index of them */
    pthread_mutex_t mutex;           /* of what follows                                 */
    volatile int stop;
    size_t done, failed, kept;
    double shown;
    ff_error lost; /* why nothing more could be written; code FF_OK: all could */
} batch;

static double now(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- one file -------------------------------------------------------------------------------- */

/* What one job brings about. */
typedef struct outcome {
    batch_entry entry;
    char *said, *json, *page; /* to be freed */
    size_t n_json, n_page;
    batch_rows rows;
} outcome;

static void sum_of(const char *bytes, size_t n, char out[FF_SHA256_TEXT])
{
    ff_sha256 s;
    ff_sha256_init(&s);
    ff_sha256_add(&s, bytes, n);
    ff_sha256_text(&s, out);
}

/* Is there a result of an earlier run, of the same file and command, that is still as it was written? Then its rows. */
static int take_earlier(const batch *b, size_t i, const char *path, const char *page, outcome *o)
{
    const batch_entry *e = batch_journal_find(&b->known, b->jobs.inputs.at[i].name, o->entry.job);
    char sum[FF_SHA256_TEXT];
    ff_error err;
    size_t n;
    if (!e || e->status > EXIT_ANSWER_IS_NO || strcmp(e->input, o->entry.input) != 0 || (page && access(page, R_OK) != 0)) return 0;
    char *text = batch_read_whole(path, &n);
    if (text) sum_of(text, n, sum);
    const int same = text && !strcmp(sum, e->output) && batch_rows_of(text, n, path, &o->rows, &err) == FF_OK;
    if (same && page) o->rows.picture = batch_thumbnail(text, n);
    free(text);
    if (!same) return 0;
    o->entry.status = e->status;
    o->said = strdup(e->message);
    return 1;
}

/* The command itself, whose JSON and messages are kept. */
static int run_command(const batch *b, size_t i, const char *path, const char *page, int threads, outcome *o)
{
    ff_kept json, said, html;
    FILE *json_stream = ff_kept_open(&json), *said_stream = ff_kept_open(&said), *html_stream = ff_kept_open(&html);
    cli_batch_args_of of;
    ff_outputs outputs = {0};
    const cli_job job = {threads, json_stream, html_stream};
    int status = EXIT_INTERNAL;
    const ff_status ready = cli_batch_args(b->args, &b->jobs, i, path, page, &of);
    if (ready == FF_OK && json_stream && said_stream && html_stream) {
        of.args.outputs = &outputs;
        of.args.job = &job;
        (void)cli_messages_into(said_stream);
        status = b->command(&of.args);
        (void)cli_messages_into(NULL);
        ff_outputs_abort(&outputs);
    }
    cli_batch_args_free(&of);
    const int whole = (ff_kept_close(&json, json_stream) == FF_OK) & (ff_kept_close(&said, said_stream) == FF_OK) &
                      (ff_kept_close(&html, html_stream) == FF_OK);
    o->page = html.text;
    o->n_page = html.n;
    o->json = json.text;
    o->n_json = json.n;
    o->said = said.text;
    return whole ? status : EXIT_INTERNAL;
}

static ff_status write_result(const char *text, size_t n, const char *path, ff_error *err)
{
    ff_output out;
    const ff_status status = ff_output_open(path, &out, err);
    if (status != FF_OK) return status;
    out.is_unsynced = 1; /* its sum is in the journal, and the file system is synced at the end */
    fwrite(text, 1, n, out.file);
    return ff_output_commit(&out, err);
}

/* Is the file still what was read? Its sum was taken before. */
static int is_unchanged(const struct stat *before, const char *path)
{
    struct stat after;
    return stat(path, &after) == 0 && after.st_size == before->st_size && after.st_ino == before->st_ino &&
           after.st_mtim.tv_sec == before->st_mtim.tv_sec && after.st_mtim.tv_nsec == before->st_mtim.tv_nsec;
}

static void replace_said(outcome *o, const char *words)
{
    free(o->said);
    o->said = strdup(words);
}

static void run_anew(const batch *b, size_t i, const char *path, const char *page, int threads, outcome *o)
{
    const char *input = b->jobs.inputs.at[i].path;
    struct stat before = {.st_size = -1};
    ff_error err = {0};
    const int known = stat(input, &before) == 0;
    o->entry.status = run_command(b, i, path, page, threads, o);
    if (o->entry.status > EXIT_ANSWER_IS_NO || !o->n_json) return;
    if (known && !is_unchanged(&before, input)) {
        o->entry.status = EXIT_INPUT;
        replace_said(o, "changed while it was read");
    } else if (batch_rows_of(o->json, o->n_json, path, &o->rows, &err) != FF_OK) {
        o->entry.status = EXIT_INTERNAL;
        replace_said(o, err.message);
    } else {
        sum_of(o->json, o->n_json, o->entry.output);
        if (page) o->rows.picture = batch_thumbnail(o->json, o->n_json);
    }
}

/* ---- what came of it ------------------------------------------------------------------------- */

static int has_result(const outcome *o)
{
    return o->rows.n > 0;
}

/* One line for a failure: the last is what ended it, those before are notes. */
static char *message_of(const outcome *o)
{
    const char *text = o->said ? o->said : "";
    size_t n = strlen(text);
    while (n && text[n - 1] == '\n') n--;
    return n ? strndup(text, n) : NULL;
}

/* Result and journal belong together: a signal finds both or none. What cannot be written ends the batch. */
static void keep(batch *b, const char *path, const char *page, int is_new, outcome *o)
{
    ff_error err = {0};
    ff_status status = FF_OK;
    batch_hold();
    if (is_new && has_result(o) && page) status = write_result(o->page, o->n_page, page, &err);
    if (is_new && has_result(o) && status == FF_OK) status = write_result(o->json, o->n_json, path, &err);
    pthread_mutex_lock(&b->mutex);
    if (is_new && status == FF_OK && !b->lost.code) status = batch_log_add(b->log, b->folder, &o->entry, &err);
    if (status != FF_OK && !b->lost.code) {
        b->lost = err;
        b->lost.code = status;
    }
    if (status != FF_OK) b->stop = 1;
    pthread_mutex_unlock(&b->mutex);
    batch_release();
    if (status == FF_OK) return;
    batch_rows_free(&o->rows);
    o->rows.state = BATCH_MISSING;
}

static void show_progress(batch *b)
{
    const double t = now(CLOCK_MONOTONIC);
    if (!b->progress || t < b->shown + 0.1) return;
    b->shown = t;
    cli_progress_show("%zu of %zu files, %zu failed", b->done, b->n_mine, b->failed);
}

static void count(batch *b, const outcome *o, int is_new)
{
    const int failed = o->rows.state == BATCH_FAILED;
    pthread_mutex_lock(&b->mutex);
    b->done++;
    b->failed += (size_t)failed;
    b->kept += !is_new;
    if (failed && !b->keep_going) b->stop = 1;
    show_progress(b);
    pthread_mutex_unlock(&b->mutex);
}

static void run_job(void *context, size_t k, int threads)
{
    batch *b = context;
    const size_t i = b->mine[k];
    const batch_input *in = &b->jobs.inputs.at[i];
    const double began = now(CLOCK_MONOTONIC);
    outcome o = {.entry = {.name = in->name}, .rows = {.state = BATCH_MISSING}};
    char *path = batch_path(b->folder, in->name), *page_name = b->pages ? batch_page_name(in->name) : NULL;
    char *page = page_name ? batch_path(b->folder, page_name) : NULL;
    if (!ff_sha256_file(in->path, o.entry.input)) strcpy(o.entry.input, "-");
    batch_job_key(&b->jobs, i, o.entry.job);
    const int is_new = !path || !take_earlier(b, i, path, page, &o);
    if (path && is_new) run_anew(b, i, path, page, threads, &o);
    if (!path) o.entry.status = EXIT_INTERNAL;
    char *message = message_of(&o);
    o.entry.message = message;
    o.entry.seconds = now(CLOCK_MONOTONIC) - began;
    o.entry.ended = now(CLOCK_REALTIME);
    o.rows.state = has_result(&o) ? BATCH_DONE : BATCH_FAILED;
    keep(b, path, page, is_new, &o);
    count(b, &o, is_new);
    b->rows[i] = o.rows;
    b->rows[i].message = message;
    b->answer[i] = o.entry.status;
    free(o.said);
    free(o.json);
    free(o.page);
    free(page);
    free(page_name);
    free(path);
}

/* ---- before ---------------------------------------------------------------------------------- */

/* The files that are read, by device and number. */
typedef struct place {
    dev_t device;
    ino_t number;
    const char *path;
} place;

static int by_place(const void *a, const void *b)
{
    const place *p = a, *q = b;
    if (p->device != q->device) return p->device < q->device ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

static size_t places_of(const batch *b, place *out)
{
    const char *table = cli_value(b->args, FLAG_NDF_TABLE, NULL);
    struct stat st;
    size_t n = 0;
    for (size_t i = 0; i <= b->jobs.inputs.n; i++) {
        const char *path = i < b->jobs.inputs.n ? b->jobs.inputs.at[i].path : table;
        if (path && stat(path, &st) == 0 && S_ISREG(st.st_mode)) out[n++] = (place){st.st_dev, st.st_ino, path};
    }
    qsort(out, n, sizeof *out, by_place);
    return n;
}

static int refuse_input(const batch *b, const place *read, size_t n, const char *path)
{
    struct stat st;
    if (!path || stat(path, &st) != 0) return EXIT_DONE;
    const place key = {st.st_dev, st.st_ino, NULL}, *same = bsearch(&key, read, n, sizeof *read, by_place);
    if (!same) return EXIT_DONE;
    return cli_usage(b->args, "%s would be written, and is the input %s; give another folder or name", path, same->path);
}

/* Nothing that is read by any of the jobs is written by one: not even with --force, since another may read it afterwards. */
static int check_outputs(const batch *b)
{
    place *read = malloc((b->jobs.inputs.n + 1) * sizeof *read);
    if (!read) return cli_failed(FF_ERR_MEMORY, NULL);
    const size_t n = places_of(b, read);
    int status = refuse_input(b, read, n, cli_value(b->args, FLAG_SUMMARY, NULL));
    for (size_t i = 0; i < b->jobs.inputs.n && status == EXIT_DONE; i++) {
        char *path = batch_path(b->folder, b->jobs.inputs.at[i].name);
        status = path ? refuse_input(b, read, n, path) : cli_failed(FF_ERR_MEMORY, NULL);
        free(path);
    }
    free(read);
    return status;
}

static int make_folder(const char *folder)
{
    struct stat st;
    ff_error err = {0};
    if (mkdir(folder, 0777) == 0 || (errno == EEXIST && stat(folder, &st) == 0 && S_ISDIR(st.st_mode))) return EXIT_DONE;
    if (errno == EEXIST)
        ff_error_set(&err, FF_ERR_WRITE, folder, 0, -1, "is no folder, expected one for the results");
    else
        ff_error_set(&err, FF_ERR_WRITE, folder, 0, -1, "the folder cannot be made: %s",
                     ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
    return cli_failed(FF_ERR_WRITE, &err);
}

static ff_status list_jobs(batch *b, ff_error *err)
{
    const cli_args *args = b->args;
    ff_status status = batch_inputs_read(args->word, args->n_words, cli_value(args, FLAG_FORMAT, NULL), &b->jobs.inputs, err);
    if (status == FF_OK) status = batch_inputs_name(&b->jobs.inputs, cli_word(args, FLAG_NAMES, 0), err);
    if (status == FF_OK) status = cli_batch_words(args, &b->jobs);
    if (status == FF_OK) status = batch_jobs_key(&b->jobs, cli_value(args, FLAG_NDF_TABLE, NULL), err);
    const size_t n = b->jobs.inputs.n;
    b->rows = calloc(n + 1, sizeof *b->rows);
    b->answer = calloc(n + 1, sizeof *b->answer);
    b->mine = calloc(n + 1, sizeof *b->mine);
    if (!b->rows || !b->answer || !b->mine) return FF_ERR_MEMORY;
    for (size_t i = 0; i < n; i++) {
        b->rows[i].state = BATCH_MISSING;
        if (batch_shard_has(&b->shard, i)) b->mine[b->n_mine++] = i;
    }
    return status;
}

/* The folder with its list, and what is known of it. */
static int open_folder(batch *b)
{
    ff_error err = {0};
    int status = make_folder(b->folder);
    if (status != EXIT_DONE) return status;
    ff_status failed = batch_log_open(b->folder, &b->shard, &b->log, &err);
    if (failed != FF_OK) {
        b->log = -1;
        return cli_failed(failed, &err);
    }
    batch_parts_remove(&b->jobs, b->folder, &b->shard);
    failed = batch_jobs_write(&b->jobs, b->folder, &err);
    if (failed == FF_OK && cli_given(b->args, FLAG_RESUME)) failed = batch_journal_read(b->folder, &b->known, &err);
    return failed == FF_OK ? EXIT_DONE : cli_failed(failed, &err);
}

/* ---- after ----------------------------------------------------------------------------------- */

/* All results at once: a sync for each of thousands would take longer than the fits. */
static void sync_results(const batch *b)
{
    if (b->log < 0) return;
    (void)!syncfs(b->log);
}

static int finish(batch *b)
{
    const cli_args *args = b->args;
    if (b->progress) cli_progress_end();
    sync_results(b);
    const cli_batch_state state = {&b->jobs, b->rows, &b->shard};
    cli_batch_say(&state);
    int status = cli_batch_state_status(&state);
    if (b->kept) cli_note("%zu of them were done before", b->kept);
    if (b->lost.code) {
        status = cli_failed(b->lost.code, &b->lost);
        cli_message("what is missing is named above; where there is room again, the same command with --resume goes on");
        return status;
    }
    for (size_t i = 0; i < b->jobs.inputs.n; i++)
        if (b->answer[i] != EXIT_DONE) status = EXIT_ANSWER_IS_NO;
    int written = cli_summary_write(args, &b->jobs, b->rows, &b->shard);
    if (written == EXIT_DONE) written = cli_index_write(args, b->folder, &b->jobs, b->rows, &b->shard);
    return written == EXIT_DONE ? status : written;
}

static int run(batch *b)
{
    const cli_args *args = b->args;
    ff_error err = {0};
    int status = cli_batch_shard(args, &b->shard);
    if (status != EXIT_DONE) return status;
    ff_status failed = list_jobs(b, &err);
    if (failed != FF_OK) return cli_failed(failed, &err);
    for (size_t i = 0; i < b->jobs.inputs.n_passed; i++) cli_note("%s: passed over: no format knows it", b->jobs.inputs.passed[i]);
    status = check_outputs(b);
    if (status == EXIT_DONE) status = open_folder(b);
    if (status != EXIT_DONE) return status;
    const int threads = (int)cli_integer(args, FLAG_THREADS, 0), all = threads ? threads : ff_threads_default();
    const batch_engine engine = {.n = b->n_mine,
                                 .workers = (int)cli_integer(args, FLAG_JOBS, (uint64_t)all),
                                 .threads = all,
                                 .run = run_job,
                                 .context = b,
                                 .stop = &b->stop};
    failed = batch_engine_run(&engine);
    return failed == FF_OK ? finish(b) : cli_failed(failed, NULL);
}

int cli_batch_run(const cli_args *args, int (*command)(const cli_args *args))
{
    int status = cli_summary_check(args);
    if (status != EXIT_DONE) return status;
    batch b = {.args = args,
               .command = command,
               .folder = cli_value(args, FLAG_OUTPUT, NULL),
               .log = -1,
               .keep_going = cli_switch(args, FLAG_KEEP_GOING, 1),
               .progress = cli_progress_wanted(args),
               .pages = cli_given(args, FLAG_HTML) > 0,
               .mutex = PTHREAD_MUTEX_INITIALIZER};
    status = run(&b);
    for (size_t i = 0; i < b.jobs.inputs.n && b.rows; i++) batch_rows_free(&b.rows[i]);
    free(b.rows);
    free(b.answer);
    free(b.mine);
    batch_journal_free(&b.known);
    batch_jobs_free(&b.jobs);
    if (b.log >= 0) close(b.log);
    return status;
}
