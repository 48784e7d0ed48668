/* The files of a batch: named, in folders, in lists. */
#define _GNU_SOURCE
#include "internal_batch.h"
#include "base/internal_errno.h"
#include "base/internal_input.h"
#include "data_formats/table/table_struct.h"
#include <dirent.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { NESTED_MOST = 32 };

static ff_status no_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the names of files");
}

void batch_inputs_free(batch_inputs *in)
{
    for (size_t i = 0; i < in->n; i++) {
        free(in->at[i].path);
        free(in->at[i].name);
    }
    for (size_t i = 0; i < in->n_passed; i++) free(in->passed[i]);
    free(in->at);
    free(in->passed);
    *in = (batch_inputs){.n = 0};
}

ff_status batch_inputs_add(batch_inputs *in, const char *path, size_t own, ff_error *err)
{
    if (in->n == in->room) {
        const size_t room = 2 * in->room + 64;
        batch_input *larger = realloc(in->at, room * sizeof *larger);
        if (!larger) return no_memory(err);
        in->at = larger;
        in->room = room;
    }
    char *copy = strdup(path);
    if (!copy) return no_memory(err);
    in->at[in->n++] = (batch_input){.path = copy, .own = own};
    return FF_OK;
}

static ff_status pass_over(batch_inputs *in, const char *path, ff_error *err)
{
    char **larger = realloc(in->passed, (in->n_passed + 1) * sizeof *larger);
    if (!larger) return no_memory(err);
    in->passed = larger;
    larger[in->n_passed] = strdup(path);
    return larger[in->n_passed] ? (in->n_passed++, FF_OK) : no_memory(err);
}

/* ---- a folder -------------------------------------------------------------------------------- */

static int is_shown(const struct dirent *entry)
{
    return entry->d_name[0] != '.';
}

static int by_bytes(const struct dirent **a, const struct dirent **b)
{
    return strcmp((*a)->d_name, (*b)->d_name);
}

static ff_status add_folder(batch_inputs *in, const char *folder, size_t own, const char *format, int depth, ff_error *err);

static ff_status add_found(batch_inputs *in, const char *path, size_t own, const char *format, int depth, ff_error *err)
{
    struct stat st;
    const ff_format *known;
    if (stat(path, &st) != 0) return batch_inputs_add(in, path, own, err); /* a link to nowhere: the job says so */
    if (S_ISDIR(st.st_mode)) return add_folder(in, path, own, format, depth + 1, err);
    if (!S_ISREG(st.st_mode)) return pass_over(in, path, err);
    if (!format && ff_format_detect(path, &known, NULL) == FF_ERR_FORMAT) return pass_over(in, path, err);
    return batch_inputs_add(in, path, own, err);
}

static ff_status add_folder(batch_inputs *in, const char *folder, size_t own, const char *format, int depth, ff_error *err)
{
    struct dirent **entry = NULL;
    if (depth == NESTED_MOST)
        return ff_error_set(err, FF_ERR_OPEN, folder, 0, -1, "found folders %d deep, expected fewer: does a link lead back?",
                            NESTED_MOST);
    const int n = scandir(folder, &entry, is_shown, by_bytes);
    if (n < 0)
        return ff_error_set(err, FF_ERR_OPEN, folder, 0, -1, "the folder cannot be opened: %s",
                            ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
    ff_status status = FF_OK;
    for (int i = 0; i < n; i++) {
        char *path = status == FF_OK ? batch_path(folder, entry[i]->d_name) : NULL;
        if (path)
            status = add_found(in, path, own, format, depth, err);
        else if (status == FF_OK)
            status = no_memory(err);
        free(path);
        free(entry[i]);
    }
    free(entry);
    return status;
}

/* ---- a word ---------------------------------------------------------------------------------- */

/* What follows the last slash. */
static size_t base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash + 1 - path) : 0;
}

static ff_status add_path(batch_inputs *in, const char *path, const char *format, ff_error *err)
{
    struct stat st;
    if (!strcmp(path, "-"))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "standard input ('-') has no name for a result in a folder");
    if (stat(path, &st) != 0 || !S_ISDIR(st.st_mode)) return batch_inputs_add(in, path, base_of(path), err);
    const size_t length = strlen(path), before = in->n;
    const ff_status status = add_folder(in, path, length + (length && path[length - 1] != '/'), format, 0, err);
    if (status != FF_OK || in->n > before) return status;
    return ff_error_set(err, FF_ERR_OPEN, path, 0, -1, "found a directory without a file of measurements, expected one at least");
}

static ff_status add_list(batch_inputs *in, const char *list, const char *format, ff_error *err)
{
    ff_lines lines;
    char *text;
    size_t length;
    ff_status status = ff_lines_open(list, &lines, err);
    if (status != FF_OK) return status;
    while ((status = ff_lines_next(&lines, &text, &length, err)) == FF_OK && text) {
        if (!*text) continue;
        status = add_path(in, text, format, err);
        if (status != FF_OK) break;
    }
    ff_lines_close(&lines);
    return status;
}

/* ---- once each ------------------------------------------------------------------------------- */

/* Number of an input, and what it is sorted by. */
typedef struct place {
    const char *text;
    size_t at;
} place;

static int by_text(const void *a, const void *b)
{
    const place *p = a, *q = b;
    const int order = strcmp(p->text, q->text);
    return order ? order : (p->at > q->at) - (p->at < q->at);
}

static place *sorted(const batch_inputs *in, int by_name)
{
    place *p = malloc((in->n + 1) * sizeof *p);
    for (size_t i = 0; i < in->n && p; i++) p[i] = (place){by_name ? in->at[i].name : in->at[i].path, i};
    if (p) qsort(p, in->n, sizeof *p, by_text);
    return p;
}

/* Of equal paths the first stays. */
static ff_status drop_copies(batch_inputs *in, ff_error *err)
{
    place *p = sorted(in, 0);
    size_t kept = 0;
    if (!p) return no_memory(err);
    for (size_t k = in->n; k-- > 1;)
        if (!strcmp(p[k].text, p[k - 1].text)) {
            batch_input *copy = &in->at[p[k].at];
            free(copy->path);
            copy->path = NULL;
        }
    free(p);
    for (size_t i = 0; i < in->n; i++)
        if (in->at[i].path) in->at[kept++] = in->at[i];
    in->n = kept;
    return FF_OK;
}

ff_status batch_inputs_read(const char *const *words, size_t n, const char *format, batch_inputs *out, ff_error *err)
{
    ff_status status = FF_OK;
    *out = (batch_inputs){.n = 0};
    for (size_t k = 0; k < n && status == FF_OK; k++)
        status = words[k][0] == '@' ? add_list(out, words[k] + 1, format, err) : add_path(out, words[k], format, err);
    if (status == FF_OK) status = drop_copies(out, err);
    if (status == FF_OK && out->n == 0)
        status = ff_error_set(err, FF_ERR_OPEN, words[0], 0, -1, "found no file in it, expected one at least");
    return status;
}

/* ---- names ----------------------------------------------------------------------------------- */

static char *name_of(const batch_input *in, int by_path)
{
    char *name;
    const char *own = in->path + (by_path ? 0 : in->own);
    while (by_path && (own[0] == '/' || !strncmp(own, "./", 2) || !strncmp(own, "../", 3))) own += strcspn(own, "/") + 1;
    if (asprintf(&name, "%s.json", own) < 0) return NULL;
    for (char *c = name; *c; c++)
        if (*c == '/') *c = '_';
    if (*name == '.') *name = '_'; /* what a folder hides is not passed over by whoever lists the results */
    return name;
}

static ff_status refuse_same(const batch_inputs *in, const place *p, int by_path, ff_error *err)
{
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%.200s and %.200s would both be written to %.200s: %s",
                        in->at[p[0].at].path, in->at[p[1].at].path, p->text,
                        by_path
                            ? "rename one of them"
                            : "--names path makes names of whole paths, and a folder that holds both those of the paths below it");
}

ff_status batch_inputs_name(batch_inputs *in, int by_path, ff_error *err)
{
    for (size_t i = 0; i < in->n; i++)
        if (!(in->at[i].name = name_of(&in->at[i], by_path))) return no_memory(err);
    place *p = sorted(in, 1);
    ff_status status = p ? FF_OK : no_memory(err);
    for (size_t k = 1; k < in->n && status == FF_OK; k++)
        if (!strcmp(p[k].text, p[k - 1].text)) status = refuse_same(in, &p[k - 1], by_path, err);
    free(p);
    return status;
}
