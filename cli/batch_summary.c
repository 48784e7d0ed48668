/* The summary of a batch, and what is said of it. */
#define _GNU_SOURCE /* strsep */
#include "internal_batching.h"
#include "report/internal_text.h"
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int ends_in(const char *path, const char *end)
{
    const size_t n = strlen(path), m = strlen(end);
    return n >= m && !strcmp(path + n - m, end);
}

int cli_summary_check(const cli_args *args)
{
    const char *path = cli_value(args, FLAG_SUMMARY, NULL);
    if (!path && cli_given(args, FLAG_SORT) && !cli_given(args, FLAG_JSON) && !cli_given(args, FLAG_HTML))
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

/* ---- the index ------------------------------------------------------------------------------- */

/* From the folder of the page to that of the results: both as they were named, where neither leads upwards. To be freed. */
static char *way_between(const char *page, const char *folder)
{
    const char *slash = strrchr(page, '/');
    char *way = NULL;
    const size_t own = slash ? (size_t)(slash + 1 - page) : 0;
    if (slash && !strncmp(page, folder, own - 1) &&
        (folder[own - 1] == '\0' || folder[own - 1] == '/')) /* the page lies above it */
        folder += folder[own - 1] ? own : own - 1;
    else if (slash && folder[0] != '/') {
        char *real = realpath(folder, NULL);
        if (real && asprintf(&way, "%s/", real) < 0) way = NULL;
        free(real);
        return way;
    }
    return asprintf(&way, "%s%s", folder, *folder && folder[strlen(folder) - 1] != '/' ? "/" : "") < 0 ? NULL : way;
}

static void find_pages(const char *folder, const batch_jobs *jobs, char *has_page)
{
    for (size_t i = 0; i < jobs->inputs.n; i++) {
        char *name = batch_page_name(jobs->inputs.at[i].name), *path = name ? batch_path(folder, name) : NULL;
        has_page[i] = path && access(path, R_OK) == 0;
        free(path);
        free(name);
    }
}

int cli_index_write(const cli_args *args, const char *folder, const batch_jobs *jobs, const batch_rows *rows,
                    const batch_shard *shard)
{
    const char *path = cli_value(args, FLAG_HTML, NULL);
    if (!path) return EXIT_DONE;
    const char **head = malloc((jobs->n_words + 1) * sizeof *head);
    char *has_page = calloc(jobs->inputs.n + 1, 1), *way = way_between(path, folder);
    int status;
    if (!head || !has_page || !way) {
        status = cli_failed(FF_ERR_MEMORY, NULL);
    } else {
        find_pages(folder, jobs, has_page);
        batch_index index = {cli_summary_of(args, jobs, rows, shard, head), way, has_page};
        if (!cli_given(args, FLAG_SORT)) index.s.order = BATCH_BY_VERDICT;
        status = cli_write(args, path, batch_index_html, &index);
    }
    free(way);
    free(has_page);
    free(head);
    return status;
}

/* ---- in words -------------------------------------------------------------------------------- */

/* "a.csv: found ..." once, where the message begins with the name; what was said before the reason goes first. */
static void put_failure(const char *path, const char *message, FILE *out)
{
    const size_t n = strlen(path);
    if (!message || !*message) message = "failed without a word";
    if (strncmp(message, path, n) != 0 || message[n] != ':') fprintf(out, "%s: ", path);
    for (const char *c = message; *c; c++) fputs(*c == '\n' ? "; " : (char[2]){*c, '\0'}, out);
    fputc('\n', out);
}

static int is_answer(const batch_rows *r)
{
    for (size_t k = 0; k < r->n; k++)
        if (strcmp(r->row[k].outcome, "converged") != 0) return 0;
    return 1;
}

ff_status cli_batch_state_write(const void *state, FILE *out)
{
    const cli_batch_state *s = state;
    size_t of_state[BATCH_STATES] = {0}, n = 0, unsettled = 0;
    for (size_t i = 0; i < s->jobs->inputs.n; i++) {
        const batch_rows *r = &s->rows[i];
        const char *path = s->jobs->inputs.at[i].path;
        if (!batch_shard_has(s->shard, i)) continue;
        of_state[r->state]++;
        n++;
        if (r->state == BATCH_FAILED) put_failure(path, r->message, out);
        if (r->state == BATCH_MISSING) fprintf(out, "%s: missing\n", path);
        unsettled += r->state == BATCH_DONE && !is_answer(r);
    }
    fprintf(out, "%zu file%s: %zu done, of which %zu did not converge; %zu failed, %zu missing\n", n, n == 1 ? "" : "s",
            of_state[BATCH_DONE], unsettled, of_state[BATCH_FAILED], of_state[BATCH_MISSING]);
    return FF_OK;
}

int cli_batch_state_status(const cli_batch_state *s)
{
    for (size_t i = 0; i < s->jobs->inputs.n; i++)
        if (batch_shard_has(s->shard, i) && s->rows[i].state != BATCH_DONE) return EXIT_ANSWER_IS_NO;
    return EXIT_DONE;
}

void cli_batch_say(const cli_batch_state *s)
{
    char *text, *line;
    if (ff_text_capture(cli_batch_state_write, s, &text) == FF_OK)
        for (char *rest = text; (line = strsep(&rest, "\n")) && *line;) {
            if (*rest)
                cli_error("%s", line);
            else /* the last counts them */
                cli_message("%s", line);
        }
    free(text);
}
