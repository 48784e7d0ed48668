/* One measurement in several files, as where each has one incidence: read one after another and joined. */
#define _GNU_SOURCE
#include "base/internal_input.h"
#include "base/internal_options.h"
#include "data_formats/table/internal_table.h"
#include <dirent.h>
#include <stdio.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FILES_MAX = 4096 };

typedef struct list {
    char **path; /* [n], each allocated */
    size_t n, skipped;
    char first_skipped[256];
} list;

static void list_free(list *l)
{
    for (size_t k = 0; k < l->n; k++) free(l->path[k]);
    free(l->path);
    *l = (list){0};
}

static ff_status no_memory(const char *path, ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the names of files");
}

static ff_status list_add(list *l, const char *folder, const char *name, ff_error *err)
{
    if (l->n == FILES_MAX)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, folder, 0, -1, "found more than %d files, expected those of one measurement",
                            FILES_MAX);
    char **larger = realloc(l->path, (l->n + 1) * sizeof *larger);
    if (!larger) return no_memory(folder, err);
    l->path = larger;
    if (asprintf(&l->path[l->n], "%s%s%s", folder ? folder : "", folder ? "/" : "", name) < 0) return no_memory(folder, err);
    l->n++;
    return FF_OK;
}

/* "scan_5deg" before "scan_20deg". */
static int by_name(const void *a, const void *b)
{
    return strverscmp(*(char *const *)a, *(char *const *)b);
}

/* Files that no format knows (a remark, a picture) are passed over; but all that were named are read. */
static ff_status add_if_known(list *l, const char *folder, const char *name, const char *format, ff_error *err)
{
    char *path;
    struct stat st;
    const ff_format *f;
    if (asprintf(&path, "%s/%s", folder, name) < 0) return no_memory(folder, err);
    ff_status status = FF_OK;
    if (stat(path, &st) == 0 && S_ISREG(st.st_mode)) {
        status = format ? FF_OK : ff_format_detect(path, &f, err);
        if (status == FF_ERR_FORMAT || (status == FF_ERR_READ && st.st_size == 0)) {
            if (!l->skipped++) snprintf(l->first_skipped, sizeof l->first_skipped, "%s", name);
            status = FF_OK;
        } else if (status == FF_OK) {
            status = list_add(l, folder, name, err);
        }
    }
    free(path);
    return status;
}

static ff_status add_folder(list *l, const char *folder, const char *format, ff_error *err)
{
    DIR *d = opendir(folder);
    if (!d) return ff_error_set(err, FF_ERR_OPEN, folder, 0, -1, "the folder cannot be opened");
    const size_t first = l->n;
    ff_status status = FF_OK;
    for (struct dirent *e; status == FF_OK && (e = readdir(d));)
        if (e->d_name[0] != '.') status = add_if_known(l, folder, e->d_name, format, err);
    closedir(d);
    if (status == FF_OK && l->n == first)
        return ff_error_set(err, FF_ERR_OPEN, folder, 0, -1,
                            "found a directory without a file of measurements, expected one at least");
    if (status == FF_OK) qsort(l->path + first, l->n - first, sizeof *l->path, by_name);
    return status;
}

static int is_folder(const char *path)
{
    struct stat st;
    return strcmp(path, "-") && stat(path, &st) == 0 && S_ISDIR(st.st_mode);
}

/* ---- joining ---------------------------------------------------------------------------------- */

static ff_status check_alike(const ff_table *first, const ff_table *other, const char *path, const char *first_path, ff_error *err)
{
    int alike = first->n_channels == other->n_channels;
    for (size_t c = 0; c < first->n_channels && alike; c++) alike = strcmp(first->channels[c].name, other->channels[c].name) == 0;
    if (alike) return FF_OK;
    return ff_error_set(
        err, FF_ERR_DATA, path, 0, -1,
        "found %zu channels, the first '%s', expected those of %.200s, %zu, the first '%s': they are no parts of one measurement",
        other->n_channels, other->channels[0].name, first_path, first->n_channels, first->channels[0].name);
}

static void copy_in(const ff_table *from, size_t at, ff_table *to)
{
    double *const planes[4] = {to->angle[0] + at, to->angle[1] + at, to->angle[2] + at, to->angle[3] + at};
    ff_table_angles(from, to->radians_per_unit, 0, from->n, planes);
    memcpy(to->valid + at, from->valid, from->n);
    for (size_t c = 0; c < to->n_channels; c++) {
        ff_table_values(from, c, 0, from->n, to->value + c * to->n + at);
        if (to->sigma) ff_table_sigmas(from, c, 0, from->n, to->sigma + c * to->n + at);
    }
}

/* Notes that all have in common once, those of one alone not: they are of its lines. */
static void join_notes(const ff_table *part, size_t n, const list *l, ff_table *out)
{
    ff_table_note(out, "%zu files are joined to one measurement, from %.100s to %.100s", n, l->path[0], l->path[n - 1]);
    if (l->skipped)
        ff_table_note(out, "%zu other file%s of the folder %s no measurement: %s", l->skipped, l->skipped == 1 ? "" : "s",
                      l->skipped == 1 ? "is" : "are", l->first_skipped);
    char sentence[sizeof out->note];
    ff_hint hint;
    for (size_t k = 0; ff_table_assumption(&part[0], k, sentence, sizeof sentence, &hint); k++) {
        size_t same = 0;
        for (size_t j = 0; j < n; j++) same += strstr(part[j].note, sentence) != NULL;
        if (same == n)
            ff_table_note_hint(out, hint, "%s", sentence);
        else
            ff_table_note_hint(out, hint, "the first of them: %s", sentence);
    }
}

static ff_status join(const ff_table *part, size_t n, const list *l, ff_table *out, ff_error *err)
{
    size_t samples = 0, with_sigma = 0, negative = 0, invalid = 0;
    for (size_t j = 0; j < n; j++) {
        const ff_status status = check_alike(&part[0], &part[j], l->path[j], l->path[0], err);
        if (status != FF_OK) return status;
        samples += part[j].n;
        with_sigma += part[j].sigma != NULL;
        negative += part[j].n_negative;
        invalid += part[j].n_invalid;
    }
    ff_table t;
    const ff_status status = ff_table_init(samples, part[0].n_channels, NULL, with_sigma == n, 0, &t, err);
    if (status != FF_OK) return status;
    t.radians_per_unit = part[0].radians_per_unit;
    size_t at = 0;
    for (size_t j = 0; j < n; j++) {
        copy_in(&part[j], at, &t);
        at += part[j].n;
        t.angles_are_open |= part[j].angles_are_open;
        t.quantity_is_open |= part[j].quantity_is_open;
        t.azimuth_from_mirror |= part[j].azimuth_from_mirror;
    }
    strcpy(t.format, part[0].format);
    t.quantity = part[0].quantity;
    t.n_negative = negative;
    t.n_invalid = invalid;
    t.isotropic = ff_table_one_incidence_azimuth(&t);
    for (size_t c = 0; c < t.n_channels; c++) {
        memcpy(t.channels[c].name, part[0].channels[c].name, sizeof t.channels[c].name);
        t.channels[c].wavelength_nm = part[0].channels[c].wavelength_nm;
    }
    join_notes(part, n, l, &t);
    if (with_sigma && with_sigma < n)
        ff_table_note(&t, "%zu of %zu files have standard deviations: they are not used", with_sigma, n);
    *out = t;
    return FF_OK;
}

static ff_status read_all(const list *l, const ff_read_options *o, ff_table *out, ff_error *err)
{
    ff_table *part = calloc(l->n, sizeof *part);
    size_t n = 0;
    ff_status status = part ? FF_OK : no_memory(l->path[0], err);
    for (; status == FF_OK && n < l->n; n += status == FF_OK) {
        if (o && o->ask) status = o->ask(o->ask_context, l->path[n], err);
        if (status != FF_OK && err && !err->path[0]) snprintf(err->path, sizeof err->path, "%s", l->path[n]);
        if (status == FF_OK) status = ff_table_read_with_into(l->path[n], o, &part[n], err);
    }
    if (status == FF_OK) status = join(part, l->n, l, out, err);
    for (size_t j = 0; j < n; j++) ff_table_clear(&part[j]);
    free(part);
    return status;
}

ff_status ff_table_read_all_into(const char *const *paths, size_t n, const ff_read_options *o, ff_table *out, ff_error *err)
{
    if (n == 0) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "found no file, expected one at least");
    if (n == 1 && !is_folder(paths[0])) return ff_table_read_with_into(paths[0], o, out, err);
    list l = {0};
    ff_status status = FF_OK;
    for (size_t k = 0; k < n && status == FF_OK; k++)
        status = is_folder(paths[k]) ? add_folder(&l, paths[k], o ? o->format : NULL, err) : list_add(&l, NULL, paths[k], err);
    if (status == FF_OK && l.n == 1)
        status = ff_table_read_with_into(l.path[0], o, out, err);
    else if (status == FF_OK)
        status = read_all(&l, o, out, err);
    list_free(&l);
    return status;
}

ff_status ff_table_read_all(const char *const *paths, size_t n, const ff_read_options *o, ff_table **out, ff_error *err)
{
    ff_read_options own;
    ff_table t;
    ff_read_options_init(&own);
    ff_status status =
        o ? ff_options_take("ff_read_options", o, FF_END_OF(ff_read_options, ask_context), &own, sizeof own, err) : FF_OK;
    if (!status) status = ff_table_read_all_into(paths, n, &own, &t, err);
    return status ? status : ff_table_move(&t, out, err);
}
