/* What was done: a line for every job that ended, in journal.tsv, or journal-3-of-8.tsv of a shard. */
#define _GNU_SOURCE
#include "internal_batch.h"
#include "base/internal_errno.h"
#include "base/internal_input.h"
#include "base/internal_kept.h"
#include "base/internal_number.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

static const char prefix[] = "journal", suffix[] = ".tsv", end_of_entry[] = ".";
enum { FIELDS = 9 };

static ff_status no_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the journal");
}

/* ---- reading --------------------------------------------------------------------------------- */

static int take_sum(const char *text, char out[FF_SHA256_TEXT])
{
    const size_t n = strlen(text);
    if (n >= FF_SHA256_TEXT) return 0;
    memcpy(out, text, n + 1);
    return n == FF_SHA256_TEXT - 1 || !strcmp(text, "-");
}

static int take_number(const char *text, double *out)
{
    const char *end = ff_number_read(text, out);
    return end && !*end;
}

/* 0 where the line is not whole. */
static int read_entry(char *line, batch_entry *e)
{
    char *field[FIELDS];
    double status;
    if (batch_fields(line, field, FIELDS) != FIELDS || strcmp(field[8], end_of_entry) || !take_number(field[4], &status)) return 0;
    *e = (batch_entry){.name = field[0], .message = field[7], .status = (int)status};
    return take_sum(field[1], e->input) && take_sum(field[2], e->job) && take_sum(field[3], e->output) &&
           take_number(field[5], &e->seconds) && take_number(field[6], &e->ended);
}

static ff_status keep_line(batch_journal *j, const char *text, ff_error *err)
{
    if (j->n == j->room) {
        const size_t room = 2 * j->room + 64;
        batch_entry *entry = realloc(j->entry, room * sizeof *entry);
        if (entry) j->entry = entry;
        char **lines = realloc(j->text, room * sizeof *lines);
        if (lines) j->text = lines;
        if (!entry || !lines) return no_memory(err);
        j->room = room;
    }
    char *copy = strdup(text);
    if (!copy) return no_memory(err);
    if (!read_entry(copy, &j->entry[j->n])) {
        free(copy);
        return FF_OK;
    }
    j->text[j->n++] = copy;
    return FF_OK;
}

static ff_status read_one(const char *path, batch_journal *j, ff_error *err)
{
    ff_lines lines;
    char *text;
    size_t length;
    ff_status status = ff_lines_open(path, &lines, err);
    if (status != FF_OK) return status;
    while ((status = ff_lines_next(&lines, &text, &length, err)) == FF_OK && text) {
        status = keep_line(j, text, err);
        if (status != FF_OK) break;
    }
    ff_lines_close(&lines);
    return status;
}

static int is_journal(const struct dirent *entry)
{
    const size_t n = strlen(entry->d_name), end = sizeof suffix - 1;
    return !strncmp(entry->d_name, prefix, sizeof prefix - 1) && n > end && !strcmp(entry->d_name + n - end, suffix);
}

static int by_name_and_time(const void *a, const void *b)
{
    const batch_entry *p = a, *q = b;
    const int order = strcmp(p->name, q->name);
    return order ? order : (p->ended > q->ended) - (p->ended < q->ended);
}

ff_status batch_journal_read(const char *folder, batch_journal *out, ff_error *err)
{
    struct dirent **entry = NULL;
    ff_status status = FF_OK;
    *out = (batch_journal){.n = 0};
    const int n = scandir(folder, &entry, is_journal, alphasort);
    if (n < 0)
        return ff_error_set(err, FF_ERR_OPEN, folder, 0, -1, "the folder cannot be opened: %s",
                            ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
    for (int i = 0; i < n; i++) {
        char *path = status == FF_OK ? batch_path(folder, entry[i]->d_name) : NULL;
        if (path)
            status = read_one(path, out, err);
        else if (status == FF_OK)
            status = no_memory(err);
        free(path);
        free(entry[i]);
    }
    free(entry);
    if (out->n) qsort(out->entry, out->n, sizeof *out->entry, by_name_and_time);
    return status;
}

void batch_journal_free(batch_journal *j)
{
    for (size_t i = 0; i < j->n; i++) free(j->text[i]);
    free(j->text);
    free(j->entry);
    *j = (batch_journal){.n = 0};
}

const batch_entry *batch_journal_find(const batch_journal *j, const char *name, const char *key)
{
    size_t low = 0, high = j->n; /* entries before low have a name up to this one, those from high on a later one */
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (strcmp(j->entry[middle].name, name) <= 0)
            low = middle + 1;
        else
            high = middle;
    }
    while (low-- > 0 && !strcmp(j->entry[low].name, name))
        if (!strcmp(j->entry[low].job, key)) return &j->entry[low];
    return NULL;
}

/* ---- writing --------------------------------------------------------------------------------- */

static ff_status fail(const char *path, const char *what, ff_error *err)
{
    return ff_error_set(err, FF_ERR_WRITE, path, 0, -1, "%s: %s", what, ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
}

/* Half a line of a run that was killed must not be the beginning of ours. */
static ff_status end_last_line(int fd, const char *path, ff_error *err)
{
    char last = '\n';
    const off_t size = lseek(fd, 0, SEEK_END);
    if (size > 0 && pread(fd, &last, 1, size - 1) == 1 && last != '\n' && write(fd, "\n", 1) != 1)
        return fail(path, "the journal cannot be written", err);
    return FF_OK;
}

ff_status batch_log_open(const char *folder, const batch_shard *shard, int *fd, ff_error *err)
{
    char name[96];
    if (shard->count == 1)
        snprintf(name, sizeof name, "%s%s", prefix, suffix);
    else
        snprintf(name, sizeof name, "%s-%zu-of-%zu%s", prefix, shard->index, shard->count, suffix);
    char *path = batch_path(folder, name);
    if (!path) return no_memory(err);
    ff_status status = FF_OK;
    *fd = open(path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (*fd < 0)
        status = fail(path, "the journal cannot be written", err);
    else if (flock(*fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) /* where there are no locks we go without */
        status = ff_error_set(err, FF_ERR_WRITE, path, 0, -1, "another run that is not over writes this journal");
    if (status == FF_OK) status = end_last_line(*fd, path, err);
    if (status != FF_OK && *fd >= 0) close(*fd);
    free(path);
    return status;
}

static void put_entry(const batch_entry *e, FILE *out)
{
    batch_field_put(e->name, out);
    fprintf(out, "\t%s\t%s\t%s\t%d\t%.6f\t%.6f\t", *e->input ? e->input : "-", e->job, *e->output ? e->output : "-", e->status,
            e->seconds, e->ended);
    batch_field_put(e->message ? e->message : "", out);
    fprintf(out, "\t%s\n", end_of_entry);
}

ff_status batch_log_add(int fd, const char *folder, const batch_entry *e, ff_error *err)
{
    ff_kept kept;
    FILE *stream = ff_kept_open(&kept);
    if (stream) put_entry(e, stream);
    if (ff_kept_close(&kept, stream) != FF_OK) return no_memory(err);
    errno = ENOSPC; /* of a write that is short */
    const ff_status status =
        write(fd, kept.text, kept.n) == (ssize_t)kept.n ? FF_OK : fail(folder, "the journal cannot be written", err);
    free(kept.text);
    return status;
}
