/* The list of all jobs of a folder, jobs.tsv: a line each for the version, the words and the key that all have in common, then one
 * for every job, its name and its path. */
#define _GNU_SOURCE
#include "internal_batch.h"
#include "base/internal_input.h"
#include "base/internal_kept.h"
#include "base/internal_output.h"
#include <dirent.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char file_name[] = "jobs.tsv", title[] = "facetfit jobs 1";
enum { MOST_WORDS = 4096 };

static ff_status no_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the list of jobs");
}

void batch_jobs_free(batch_jobs *jobs)
{
    for (size_t k = 0; k < jobs->n_words; k++) free(jobs->word[k]);
    free(jobs->word);
    free(jobs->version);
    batch_inputs_free(&jobs->inputs);
    *jobs = (batch_jobs){.n_words = 0};
}

/* ---- keys ------------------------------------------------------------------------------------ */

/* With its end, so that two words are not one. */
static void add_text(ff_sha256 *s, const char *text)
{
    ff_sha256_add(s, text, strlen(text) + 1);
}

ff_status batch_jobs_key(batch_jobs *jobs, const char *table, ff_error *err)
{
    ff_sha256 s;
    char digits[FF_SHA256_TEXT] = "";
    if (table && !ff_sha256_file(table, digits))
        return ff_error_set(err, FF_ERR_OPEN, table, 0, -1, "cannot be read as a file, which all files of a batch read");
    ff_sha256_init(&s);
    add_text(&s, jobs->version);
    for (size_t k = 0; k < jobs->n_words; k++) add_text(&s, jobs->word[k]);
    add_text(&s, digits);
    ff_sha256_text(&s, jobs->key);
    return FF_OK;
}

void batch_job_key(const batch_jobs *jobs, size_t i, char out[FF_SHA256_TEXT])
{
    ff_sha256 s;
    ff_sha256_init(&s);
    add_text(&s, jobs->key);
    add_text(&s, jobs->inputs.at[i].path);
    add_text(&s, jobs->inputs.at[i].name);
    ff_sha256_text(&s, out);
}

/* ---- writing --------------------------------------------------------------------------------- */

static void put_jobs(const batch_jobs *jobs, FILE *out)
{
    fprintf(out, "%s\nversion\t", title);
    batch_field_put(jobs->version, out);
    fprintf(out, "\nkey\t%s\ncommand", jobs->key);
    for (size_t k = 0; k < jobs->n_words; k++) {
        fputc('\t', out);
        batch_field_put(jobs->word[k], out);
    }
    fputc('\n', out);
    for (size_t i = 0; i < jobs->inputs.n; i++) {
        batch_field_put(jobs->inputs.at[i].name, out);
        fputc('\t', out);
        batch_field_put(jobs->inputs.at[i].path, out);
        fputc('\n', out);
    }
}

static int says(const char *path, const char *text, size_t n)
{
    FILE *in = fopen(path, "rb");
    char *old = in ? malloc(n + 1) : NULL;
    const int same = old && fread(old, 1, n + 1, in) == n && !memcmp(old, text, n);
    free(old);
    if (in) (void)fclose(in);
    return same;
}

static ff_status put_text(const char *path, const char *text, size_t n, ff_error *err)
{
    ff_output out;
    const ff_status status = ff_output_open(path, &out, err);
    if (status != FF_OK) return status;
    fwrite(text, 1, n, out.file);
    return ff_output_commit(&out, err);
}

ff_status batch_jobs_write(const batch_jobs *jobs, const char *folder, ff_error *err)
{
    ff_kept kept;
    FILE *stream = ff_kept_open(&kept);
    char *path = batch_path(folder, file_name);
    if (stream) put_jobs(jobs, stream);
    ff_status status = ff_kept_close(&kept, stream);
    if (status == FF_OK && path && !says(path, kept.text, kept.n)) status = put_text(path, kept.text, kept.n, err);
    if (status == FF_ERR_MEMORY || !path) status = no_memory(err);
    free(path);
    free(kept.text);
    return status;
}

/* ---- reading --------------------------------------------------------------------------------- */

static ff_status wrong(const char *path, long line, const char *expected, ff_error *err)
{
    return ff_error_set(err, FF_ERR_FORMAT, path, line, -1, "is no list of the jobs of a folder: expected %s", expected);
}

static ff_status take_words(char **field, size_t n, batch_jobs *out, ff_error *err)
{
    out->word = calloc(n ? n : 1, sizeof *out->word);
    if (!out->word) return no_memory(err);
    for (; out->n_words < n; out->n_words++)
        if (!(out->word[out->n_words] = strdup(field[out->n_words]))) return no_memory(err);
    return FF_OK;
}

/* One of the first lines: "NAME", and n fields. */
static ff_status take_head(long line, char **field, size_t n, const char *path, batch_jobs *out, ff_error *err)
{
    switch (line) {
    case 1:
        return n == 1 && !strcmp(field[0], title) ? FF_OK : wrong(path, line, title, err);
    case 2:
        if (n != 2 || strcmp(field[0], "version")) return wrong(path, line, "'version'", err);
        return (out->version = strdup(field[1])) ? FF_OK : no_memory(err);
    case 3:
        if (n != 2 || strcmp(field[0], "key") || strlen(field[1]) != FF_SHA256_TEXT - 1) return wrong(path, line, "'key'", err);
        strcpy(out->key, field[1]);
        return FF_OK;
    default:
        if (n < 2 || n > MOST_WORDS || strcmp(field[0], "command")) return wrong(path, line, "'command'", err);
        return take_words(field + 1, n - 1, out, err);
    }
}

static ff_status take_job(char **field, size_t n, const char *path, long line, batch_jobs *out, ff_error *err)
{
    if (n != 2 || !*field[0] || strchr(field[0], '/')) return wrong(path, line, "the name of a result and its file", err);
    const ff_status status = batch_inputs_add(&out->inputs, field[1], 0, err);
    if (status != FF_OK) return status;
    char **name = &out->inputs.at[out->inputs.n - 1].name;
    return (*name = strdup(field[0])) ? FF_OK : no_memory(err);
}

static ff_status read_lines(const char *path, ff_lines *lines, char **field, batch_jobs *out, ff_error *err)
{
    enum { HEAD = 4 };
    char *text;
    size_t length;
    ff_status status;
    while ((status = ff_lines_next(lines, &text, &length, err)) == FF_OK && text) {
        const size_t n = batch_fields(text, field, MOST_WORDS);
        status = lines->line <= HEAD ? take_head(lines->line, field, n, path, out, err)
                                     : take_job(field, n, path, lines->line, out, err);
        if (status != FF_OK) return status;
    }
    if (status == FF_OK && lines->line < HEAD) return wrong(path, 0, "a title, 'version', 'key' and 'command'", err);
    return status;
}

ff_status batch_jobs_read(const char *folder, batch_jobs *out, ff_error *err)
{
    ff_lines lines;
    *out = (batch_jobs){.n_words = 0};
    char *path = batch_path(folder, file_name), **field = malloc(MOST_WORDS * sizeof *field);
    ff_status status = path && field ? ff_lines_open(path, &lines, err) : no_memory(err);
    if (status == FF_OK) {
        status = read_lines(path, &lines, field, out, err);
        ff_lines_close(&lines);
    }
    free(field);
    free(path);
    return status;
}

/* ---- shares ---------------------------------------------------------------------------------- */

int batch_shard_parse(const char *text, batch_shard *out)
{
    size_t number[2] = {0, 0};
    int part = 0;
    for (const char *c = text; *c; c++) {
        if (*c == '/' && part == 0 && c > text) {
            part = 1;
            continue;
        }
        if (*c < '0' || *c > '9' || number[part] > 1000000) return 0;
        number[part] = 10 * number[part] + (size_t)(*c - '0');
    }
    *out = (batch_shard){number[0], number[1]};
    return part == 1 && number[0] >= 1 && number[0] <= number[1];
}

int batch_shard_has(const batch_shard *s, size_t job)
{
    return job % s->count == s->index - 1;
}

/* ---- what a kill leaves ---------------------------------------------------------------------- */

static const char part[] = ".part-";

static int is_part(const struct dirent *entry)
{
    return strstr(entry->d_name, part) != NULL;
}

/* Others may be at their own results at this moment. */
static int is_ours(const batch_jobs *jobs, const batch_shard *s, const char *name)
{
    for (size_t i = 0; i < jobs->inputs.n; i++) {
        const char *own = jobs->inputs.at[i].name;
        const size_t n = strlen(own);
        if (batch_shard_has(s, i) && !strncmp(name, own, n) && !strncmp(name + n, part, sizeof part - 1)) return 1;
    }
    return 0;
}

void batch_parts_remove(const batch_jobs *jobs, const char *folder, const batch_shard *s)
{
    struct dirent **entry = NULL;
    const int n = scandir(folder, &entry, is_part, NULL);
    for (int i = 0; i < n; i++) {
        char *path = is_ours(jobs, s, entry[i]->d_name) ? batch_path(folder, entry[i]->d_name) : NULL;
        if (path) unlink(path);
        free(path);
        free(entry[i]);
    }
    if (n >= 0) free(entry);
}
