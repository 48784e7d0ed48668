/* The summary of a batch, and what is said of it. */
#include "internal_batching.h"
#include <stdlib.h>
#include <string.h>

static int ends_in(const char *path, const char *end)
{
    const size_t n = strlen(path), m = strlen(end);
    return n >= m && !strcmp(path + n - m, end);
}

int cli_summary_check(const cli_args *args)
{
    const char *path = cli_value(args, FLAG_SUMMARY, NULL);
    if (!path && cli_given(args, FLAG_SORT) && !cli_given(args, FLAG_JSON))
        return cli_usage(args, "--sort is the order of the summary: say with --summary FILE where it goes");
    if (!path || !strcmp(path, "-") || ends_in(path, ".csv") || ends_in(path, ".json")) return EXIT_DONE;
    return cli_usage(args, "--summary %s: expected NAME.csv or NAME.json, or '-' for CSV on standard output", path);
}

batch_summary cli_summary_of(const cli_args *args, const batch_jobs *jobs, const batch_rows *rows, const batch_shard *shard,
                             const char **head)
{
    head[0] = "facetfit";
    for (size_t k = 0; k < jobs->n_words; k++) head[k + 1] = jobs->word[k];
    return (batch_summary){.head = {jobs->version, jobs->n_words + 1, head},
                           .inputs = &jobs->inputs,
                           .rows = rows,
                           .shard = shard,
                           .order = (batch_order)cli_word(args, FLAG_SORT, BATCH_BY_FILE)};
}

int cli_summary_write(const cli_args *args, const batch_jobs *jobs, const batch_rows *rows, const batch_shard *shard)
{
    const char *path = cli_value(args, FLAG_SUMMARY, NULL);
    if (!path) return EXIT_DONE;
    const char **head = malloc((jobs->n_words + 1) * sizeof *head);
    if (!head) return cli_failed(FF_ERR_MEMORY, NULL);
    const batch_summary s = cli_summary_of(args, jobs, rows, shard, head);
    const int status = cli_write(args, path, ends_in(path, ".json") ? batch_summary_json : batch_summary_csv, &s);
    free(head);
    return status;
}

/* ---- in words -------------------------------------------------------------------------------- */

/* "a.csv: found ..." once, where the message begins with the name. */
static void say_failure(const char *path, const char *message)
{
    const size_t n = strlen(path);
    char *line = strdup(message && *message ? message : "failed without a word");
    if (!line) {
        cli_message("%s: failed", path);
        return;
    }
    for (char *c = line; *c; c++)
        if (*c == '\n') *c = c[1] ? ';' : '\0';
    if (!strncmp(line, path, n) && line[n] == ':')
        cli_message("%s", line);
    else
        cli_message("%s: %s", path, line);
    free(line);
}

static int is_answer(const batch_rows *r)
{
    for (size_t k = 0; k < r->n; k++)
        if (strcmp(r->row[k].outcome, "converged") != 0) return 0;
    return 1;
}

int cli_batch_say(const batch_jobs *jobs, const batch_rows *rows, const batch_shard *shard, const char *what)
{
    size_t of_state[BATCH_STATES] = {0}, n = 0, unsettled = 0;
    for (size_t i = 0; i < jobs->inputs.n; i++) {
        if (!batch_shard_has(shard, i)) continue;
        const batch_rows *r = &rows[i];
        of_state[r->state]++;
        n++;
        if (r->state == BATCH_FAILED) say_failure(jobs->inputs.at[i].path, r->message);
        if (r->state == BATCH_MISSING) cli_message("%s: missing", jobs->inputs.at[i].path);
        unsettled += r->state == BATCH_DONE && !is_answer(r);
    }
    cli_message("%s%zu file%s: %zu done, of which %zu did not converge, %zu failed, %zu missing", what, n, n == 1 ? "" : "s",
                of_state[BATCH_DONE], unsettled, of_state[BATCH_FAILED], of_state[BATCH_MISSING]);
    return of_state[BATCH_FAILED] || of_state[BATCH_MISSING] ? EXIT_ANSWER_IS_NO : EXIT_DONE;
}
