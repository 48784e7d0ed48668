/* facetfit gather DIR: what all shards of a folder have done, and what is missing. */
#include "internal_batching.h"
#include <stdlib.h>
#include <string.h>

typedef struct gathered {
    const cli_args *args;
    batch_jobs jobs;
    batch_journal journal;
    batch_rows *rows;
} gathered;

/* What was written for e, if it still is what was written. */
static ff_status take_result(const batch_entry *e, const char *path, int with_picture, batch_rows *out)
{
    char sum[FF_SHA256_TEXT];
    size_t n;
    ff_sha256 s;
    ff_error err;
    char *text = batch_read_whole(path, &n);
    ff_status status = text ? FF_OK : FF_ERR_OPEN;
    if (status == FF_OK) {
        ff_sha256_init(&s);
        ff_sha256_add(&s, text, n);
        ff_sha256_text(&s, sum);
        status = strcmp(sum, e->output) ? FF_ERR_DATA : batch_rows_of(text, n, path, out, &err);
        if (status == FF_OK && with_picture) out->picture = batch_thumbnail(text, n);
    }
    free(text);
    return status;
}

static ff_status gather_one(gathered *g, const char *folder, size_t i)
{
    char key[FF_SHA256_TEXT];
    batch_rows *out = &g->rows[i];
    batch_job_key(&g->jobs, i, key);
    const batch_entry *e = batch_journal_find(&g->journal, g->jobs.inputs.at[i].name, key);
    out->state = BATCH_MISSING;
    if (!e) return FF_OK;
    if (!strcmp(e->output, "-")) {
        out->state = BATCH_FAILED;
    } else {
        char *path = batch_path(folder, g->jobs.inputs.at[i].name);
        if (!path) return FF_ERR_MEMORY;
        const ff_status status = take_result(e, path, cli_given(g->args, FLAG_HTML) > 0, out);
        free(path);
        if (status == FF_ERR_MEMORY) return status;
        if (status != FF_OK) out->state = BATCH_MISSING;
    }
    if (out->state != BATCH_MISSING && *e->message && !(out->message = strdup(e->message))) return FF_ERR_MEMORY;
    return FF_OK;
}

static ff_status write_json(const void *gathered_all, FILE *out)
{
    const gathered *g = gathered_all;
    static const batch_shard all = {1, 1};
    const char **head = malloc((g->jobs.n_words + 1) * sizeof *head);
    if (!head) return FF_ERR_MEMORY;
    const batch_summary s = cli_summary_of(g->args, &g->jobs, g->rows, &all, head);
    const ff_status status = batch_summary_json(&s, out);
    free(head);
    return status;
}

static int gather(gathered *g)
{
    static const batch_shard all = {1, 1};
    const char *folder = g->args->word[0], *json = cli_value(g->args, FLAG_JSON, NULL);
    ff_error err = {0};
    ff_status failed = batch_jobs_read(folder, &g->jobs, &err);
    if (failed == FF_OK) failed = batch_journal_read(folder, &g->journal, &err);
    if (failed == FF_OK && !(g->rows = calloc(g->jobs.inputs.n + 1, sizeof *g->rows))) failed = FF_ERR_MEMORY;
    for (size_t i = 0; i < g->jobs.inputs.n && failed == FF_OK; i++) failed = gather_one(g, folder, i);
    if (failed != FF_OK) return cli_failed(failed, &err);
    int status = cli_summary_write(g->args, &g->jobs, g->rows, &all);
    if (status == EXIT_DONE) status = cli_index_write(g->args, folder, &g->jobs, g->rows, &all);
    if (status == EXIT_DONE && json) status = cli_write(g->args, json, write_json, g);
    const cli_batch_state state = {&g->jobs, g->rows, &all};
    const char *summary = cli_value(g->args, FLAG_SUMMARY, "");
    const int is_taken = !strcmp(summary, "-") || (json && !strcmp(json, "-"));
    if (status == EXIT_DONE && is_taken)
        cli_batch_say(&state);
    else if (status == EXIT_DONE)
        status = cli_write(g->args, "-", cli_batch_state_write, &state);
    if (status == EXIT_DONE) status = cli_outputs_commit(g->args);
    return status == EXIT_DONE ? cli_batch_state_status(&state) : status;
}

int cmd_gather(const cli_args *args)
{
    gathered g = {.args = args};
    int status = cli_summary_check(args);
    if (status == EXIT_DONE) status = gather(&g);
    for (size_t i = 0; i < g.jobs.inputs.n && g.rows; i++) batch_rows_free(&g.rows[i]);
    free(g.rows);
    batch_journal_free(&g.journal);
    batch_jobs_free(&g.jobs);
    return status;
}
