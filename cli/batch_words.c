/* The words of a batch: those that all of its files have in common, those of one file, and what cannot be said of many. */
#define _GNU_SOURCE
#include "internal_batching.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What says how a batch runs and where things go, and has no part in a result. */
static const cli_flag_id own[] = {FLAG_OUTPUT,     FLAG_SUMMARY, FLAG_SORT,  FLAG_JOBS,    FLAG_RESUME,
                                  FLAG_KEEP_GOING, FLAG_SHARD,   FLAG_NAMES, FLAG_THREADS, FLAG_PROGRESS,
                                  FLAG_WIDE,       FLAG_COLOR,   FLAG_HTML,  FLAG_FORCE,   FLAG_TIMES};
/* What writes one file of one result. */
static const cli_flag_id single[] = {FLAG_JSON, FLAG_TABLE, FLAG_RESIDUALS};
static const cli_flag_id batch_only[] = {FLAG_SUMMARY, FLAG_SORT, FLAG_JOBS, FLAG_RESUME, FLAG_KEEP_GOING, FLAG_SHARD, FLAG_NAMES};

#define COUNT(array) (sizeof(array) / sizeof *(array))

static int is_among(const cli_flag_id *list, size_t n, int flag)
{
    for (size_t k = 0; k < n; k++)
        if ((int)list[k] == flag) return 1;
    return 0;
}

int cli_batch_wanted(const cli_args *args)
{
    return !args->job && cli_given(args, FLAG_OUTPUT);
}

int cli_batch_words_check(const cli_args *args)
{
    if (!cli_given(args, FLAG_OUTPUT)) {
        for (size_t k = 0; k < COUNT(batch_only); k++)
            if (cli_given(args, batch_only[k]))
                return cli_usage(args,
                                 "--%s is of many files, each of them a material of its own: say with -o DIR where their "
                                 "results go",
                                 cli_flag_name(batch_only[k]));
        return EXIT_DONE;
    }
    for (size_t k = 0; k < COUNT(single); k++)
        if (cli_given(args, single[k]))
            return cli_usage(args, "--%s is of one file; with -o DIR every file has its JSON in DIR, and --summary is of all",
                             cli_flag_name(single[k]));
    if (cli_switch(args, FLAG_TIMES, 0))
        return cli_usage(args, "with -o DIR the times are in the journal of DIR: leave out --times");
    return EXIT_DONE;
}

/* ---- the command of a file ------------------------------------------------------------------- */

/* "--name" "value", "--name", "--no-name" into word; a value that looks like a flag in one. Counts what was allocated in *n; 0: no
 * memory. */
static int put_flag(int flag, const char *value, char **word, size_t *n)
{
    const cli_flag *f = cli_flag_at((cli_flag_id)flag);
    const int is_switch = f->kind == KIND_SWITCH, glued = !is_switch && *value == '-';
    const char *no = is_switch && value ? "no-" : "", *equals = glued ? "=" : "", *rest = glued ? value : "";
    if (asprintf(&word[*n], "--%s%s%s%s", no, f->name, equals, rest) < 0) return 0;
    (*n)++;
    if (is_switch || glued) return 1;
    if (!(word[*n] = strdup(value))) return 0;
    (*n)++;
    return 1;
}

ff_status cli_batch_words(const cli_args *args, batch_jobs *jobs)
{
    jobs->version = strdup(args->head.version);
    jobs->word = calloc(2 * args->n_given + 1, sizeof *jobs->word);
    if (!jobs->version || !jobs->word || !(jobs->word[0] = strdup(args->command->name))) return FF_ERR_MEMORY;
    jobs->n_words = 1;
    for (size_t i = 0; i < args->n_given; i++)
        if (!is_among(own, COUNT(own), args->flag[i]) && !put_flag(args->flag[i], args->value[i], jobs->word, &jobs->n_words))
            return FF_ERR_MEMORY;
    return FF_OK;
}

/* ---- one job --------------------------------------------------------------------------------- */

/* What is recorded is a command that makes the same bytes: facetfit fit PATH ... --no-times --json NAME. */
static void put_head(const batch_jobs *jobs, const batch_input *in, const char **head, size_t *n)
{
    const int looks_like_flag = in->path[0] == '-';
    head[(*n)++] = "facetfit";
    head[(*n)++] = jobs->word[0];
    if (!looks_like_flag) head[(*n)++] = in->path;
    for (size_t k = 1; k < jobs->n_words; k++) head[(*n)++] = jobs->word[k];
    head[(*n)++] = "--no-times";
    head[(*n)++] = "--json";
    head[(*n)++] = in->name;
    if (!looks_like_flag) return;
    head[(*n)++] = "--";
    head[(*n)++] = in->path;
}

ff_status cli_batch_args(const cli_args *args, const batch_jobs *jobs, size_t i, const char *json, const char *page,
                         cli_batch_args_of *out)
{
    const size_t room = args->n_given + 3;
    *out = (cli_batch_args_of){.head = malloc((jobs->n_words + 8) * sizeof *out->head),
                               .flag = malloc(room * sizeof *out->flag),
                               .value = malloc(room * sizeof *out->value),
                               .word = jobs->inputs.at[i].path};
    if (!out->head || !out->flag || !out->value) return FF_ERR_MEMORY;
    size_t n_head = 0, n = 0;
    put_head(jobs, &jobs->inputs.at[i], out->head, &n_head);
    for (size_t k = 0; k < args->n_given; k++) {
        if (is_among(own, COUNT(own), args->flag[k])) continue;
        out->flag[n] = args->flag[k];
        out->value[n++] = args->value[k];
    }
    out->flag[n] = FLAG_TIMES;
    out->value[n++] = "no";
    out->flag[n] = FLAG_JSON;
    out->value[n++] = json;
    out->flag[n] = FLAG_HTML;
    out->value[n] = page;
    n += page != NULL;
    out->args = (cli_args){.command = args->command,
                           .n_words = 1,
                           .n_given = n,
                           .word = &out->word,
                           .flag = out->flag,
                           .value = out->value,
                           .head = {args->head.version, n_head, out->head}};
    return FF_OK;
}

void cli_batch_args_free(cli_batch_args_of *of)
{
    free(of->head);
    free(of->flag);
    free(of->value);
}

/* ---- which share ----------------------------------------------------------------------------- */

/* A number of the environment; 0 where there is none. */
static int number_of(const char *name, size_t *out)
{
    const char *text = getenv(name);
    double x;
    if (!text || !cli_number_read(text, &x) || x < 0 || x > 1e6 || x != (double)(size_t)x) return 0;
    *out = (size_t)x;
    return 1;
}

int cli_batch_shard(const cli_args *args, batch_shard *out)
{
    const char *text = cli_value(args, FLAG_SHARD, NULL);
    size_t id, count, first = 1, step = 1;
    *out = (batch_shard){1, 1};
    if (text)
        return batch_shard_parse(text, out)
                   ? EXIT_DONE
                   : cli_usage(args, "--shard %s: expected I/N, the I-th of N shards, I from 1 to N, e.g. 3/8", text);
    if (!number_of("SLURM_ARRAY_TASK_ID", &id) || !number_of("SLURM_ARRAY_TASK_COUNT", &count) || count < 2) return EXIT_DONE;
    number_of("SLURM_ARRAY_TASK_MIN", &first);
    number_of("SLURM_ARRAY_TASK_STEP", &step);
    if (id < first || !step || (id - first) % step || (id - first) / step >= count)
        return cli_usage(args, "task %zu of a Slurm array of %zu from %zu on in steps of %zu is none of it; say --shard I/N", id,
                         count, first, step);
    *out = (batch_shard){(id - first) / step + 1, count};
    cli_note("shard %zu of %zu, as the Slurm array says", out->index, out->count);
    return EXIT_DONE;
}
