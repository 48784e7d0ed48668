/* Output files that appear whole or not at all. */
#define _GNU_SOURCE
#include "internal_output.h"
#include "internal_errno.h"
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_BYTES = 1 << 16, NAME_ATTEMPTS = 1000, MOST_LINKS = 40, MOST_UNFINISHED = 64 };

/* ---- what a signal leaves to be done ---------------------------------------------------------- */

/* Names of the temporary files, for those who end the program. A handler may come at any time, so nothing is locked: a name is here
 * before it is used and goes before it is freed. */
static char *_Atomic unfinished[MOST_UNFINISHED];

static void remember(char *name)
{
    char *none = NULL;
    for (int i = 0; i < MOST_UNFINISHED && !atomic_compare_exchange_strong(&unfinished[i], &none, name); i++) none = NULL;
}

static void forget(char *name)
{
    for (int i = 0; name && i < MOST_UNFINISHED; i++) {
        char *this_one = name;
        if (atomic_compare_exchange_strong(&unfinished[i], &this_one, NULL)) return;
    }
}

void ff_outputs_remove(void)
{
    for (int i = 0; i < MOST_UNFINISHED; i++) {
        const char *name = atomic_load(&unfinished[i]);
        if (name) unlink(name);
    }
}

/* ---- an output and its errors ------------------------------------------------------------------ */

static void output_release(ff_output *out)
{
    forget(out->temporary);
    free(out->target);
    free(out->temporary);
    *out = (ff_output){0};
}

static ff_status fail(ff_error *err, const char *path, const char *what, int reason)
{
    const ff_status status = reason == ENOMEM ? FF_ERR_MEMORY : FF_ERR_WRITE;
    return ff_error_set(err, status, path, 0, -1, "%s: %s", what, ff_errno_text(reason, (char[FF_ERRNO_TEXT]){""}));
}

/* Wraps a descriptor; on failure closes it and leaves *out released. */
static ff_status output_attach(int fd, const char *path, ff_output *out, ff_error *err)
{
    out->file = fdopen(fd, "wb");
    if (out->file) {
        setvbuf(out->file, NULL, _IOFBF, BUFFER_BYTES); /* a refused buffer only makes it slower */
        return FF_OK;
    }
    int reason = errno;
    close(fd);
    if (out->temporary) unlink(out->temporary);
    output_release(out);
    return fail(err, path, "cannot be written", reason);
}

static ff_status open_stdout(ff_output *out, ff_error *err)
{
    fflush(stdout); /* what the program printed before comes first */
    int fd = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
    if (fd < 0) return fail(err, "-", "standard output cannot be written", errno);
    return output_attach(fd, "-", out, err);
}

/* ---- the temporary file ---------------------------------------------------------------------- */

/* Bytes of a path up to and with its last slash: its folder, 0 for the current one. */
static int folder_length(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? (int)(slash + 1 - path) : 0;
}

/* Nobody else may look into it while it is written, nor write: its mode comes with its name. */
static int create_one(char *name)
{
    return name ? open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, S_IRUSR | S_IWUSR) : (errno = ENOMEM, -1);
}

/* "TARGET.part-PID-N", or ".part-PID-N" beside it where that is longer than a name may be. */
static char *temporary_name(const char *target, int attempt, int is_short)
{
    char *name;
    const int kept = is_short ? folder_length(target) : (int)strlen(target);
    return asprintf(&name, "%.*s.part-%ld-%d", kept, target, (long)getpid(), attempt) < 0 ? NULL : name;
}

/* Creates it with the first N that is free. */
static int create_temporary(const char *target, char **name)
{
    int is_short = 0;
    for (int attempt = 0; attempt < NAME_ATTEMPTS; attempt++) {
        *name = temporary_name(target, attempt, is_short);
        const int fd = create_one(*name);
        if (fd >= 0) return fd;
        const int reason = errno;
        free(*name);
        *name = NULL;
        errno = reason;
        if (reason == ENAMETOOLONG && !is_short) {
            is_short = 1;
        } else if (reason != EEXIST) {
            return -1;
        }
    }
    return -1;
}

/* Between its birth and its being known no signal comes to this thread, which is the one that has them handled. */
static int create_remembered(const char *target, char **name)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    const int fd = create_temporary(target, name);
    const int reason = errno;
    if (fd >= 0) remember(*name);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    errno = reason;
    return fd;
}

/* ---- permissions ----------------------------------------------------------------------------- */

/* The process has one mask, which can only be asked for by setting it: to the strictest, for a moment. */
static mode_t mask_by_setting(void)
{
    static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&one_at_a_time);
    const mode_t mask = umask(S_IRWXG | S_IRWXO);
    umask(mask);
    pthread_mutex_unlock(&one_at_a_time);
    return mask;
}

/* Linux tells it without. */
static mode_t mask_of_process(void)
{
    char text[512];
    const int fd = open("/proc/self/status", O_RDONLY | O_CLOEXEC);
    const ssize_t n = fd >= 0 ? read(fd, text, sizeof text - 1) : -1;
    if (fd >= 0) close(fd);
    text[n > 0 ? n : 0] = '\0';
    const char *mask = strstr(text, "\nUmask:");
    return mask ? (mode_t)strtoul(mask + strlen("\nUmask:"), NULL, 8) : mask_by_setting();
}

/* What the finished file may be used for: by those who could use the old one, where there is one. Never by the name of its owner:
 * whoever had set that did not know these bytes. */
static mode_t permissions_for(int fd, const struct stat *old)
{
    const mode_t all = S_IRWXU | S_IRWXG | S_IRWXO;
    if (!old) return 0666 & ~mask_of_process();
    if (fchown(fd, old->st_uid, old->st_gid) == 0 || fchown(fd, (uid_t)-1, old->st_gid) == 0) return old->st_mode & all;
    const mode_t others = old->st_mode & S_IRWXO; /* our group is not the one that was meant */
    return (old->st_mode & S_IRWXU) | (old->st_mode & S_IRWXG & others << 3) | others;
}

/* ---- opening --------------------------------------------------------------------------------- */

/* Where a link leads, one step; NULL with errno: EINVAL is the end. */
static char *link_step(const char *path)
{
    char to[PATH_MAX], *next = NULL;
    const ssize_t n = readlink(path, to, sizeof to - 1);
    if (n < 0) return NULL;
    to[n] = '\0';
    if (asprintf(&next, "%.*s%s", to[0] == '/' ? 0 : folder_length(path), path, to) < 0) {
        errno = ENOMEM;
        return NULL;
    }
    return next;
}

char *ff_output_name(const char *path)
{
    char *name = strdup(path);
    for (int i = 0; name && i < MOST_LINKS; i++) {
        char *next = link_step(name);
        if (!next && (errno == EINVAL || errno == ENOENT)) return name;
        free(name);
        name = next;
    }
    return name;
}

/* Is it the folder that is missing? FF_OK: no. */
static ff_status folder_is_missing(const char *path, char *target, ff_error *err)
{
    struct stat s;
    char *slash = strrchr(target, '/');
    if (!slash || slash == target) return FF_OK;
    *slash = '\0';
    if (stat(target, &s) == 0 || errno != ENOENT) return FF_OK;
    return ff_error_set(err, FF_ERR_WRITE, path, 0, -1, "the folder %s does not exist", target);
}

/* A new file beside target, or beside the existing regular file that it will replace. */
static ff_status open_replacing(const char *path, const struct stat *old, ff_output *out, ff_error *err)
{
    if (old && access(path, W_OK) != 0) return fail(err, path, "exists and cannot be written", errno);
    char *target = old ? realpath(path, NULL) : ff_output_name(path), *temporary = NULL;
    if (!target) return fail(err, path, "cannot be written", errno);
    int fd = create_remembered(target, &temporary);
    if (fd < 0) {
        int reason = errno;
        const ff_status no_folder = reason == ENOENT ? folder_is_missing(path, target, err) : FF_OK;
        free(target);
        if (no_folder) return no_folder;
        return fail(err, path, "no file can be created beside it", reason);
    }
    ff_output o = {.target = target, .temporary = temporary, .mode = permissions_for(fd, old)};
    ff_status status = output_attach(fd, path, &o, err);
    if (status == FF_OK) *out = o;
    return status;
}

static ff_status open_directly(const char *path, ff_output *out, ff_error *err)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0) return fail(err, path, "cannot be opened for writing", errno);
    ff_output o = {0};
    o.target = strdup(path);
    if (!o.target) {
        close(fd);
        return fail(err, path, "cannot be written", ENOMEM);
    }
    ff_status status = output_attach(fd, path, &o, err);
    if (status == FF_OK) *out = o;
    return status;
}

static ff_status open_alone(const char *path, ff_output *out, ff_error *err)
{
    if (strcmp(path, "-") == 0) {
        ff_output o = {0};
        ff_status status = open_stdout(&o, err);
        if (status == FF_OK) *out = o;
        return status;
    }
    if (path[0] == '\0') return fail(err, path, "the name is empty", ENOENT);
    struct stat old;
    if (stat(path, &old) != 0) {
        if (errno != ENOENT) return fail(err, path, "cannot be written", errno);
        return open_replacing(path, NULL, out, err);
    }
    if (S_ISDIR(old.st_mode)) return fail(err, path, "is a directory, expected the name of a file", EISDIR);
    return S_ISREG(old.st_mode) ? open_replacing(path, &old, out, err) : open_directly(path, out, err);
}

ff_status ff_output_open_with(const char *path, ff_outputs *with, ff_output *out, ff_error *err)
{
    const ff_status status = open_alone(path, out, err);
    if (status == FF_OK) out->with = with;
    return status;
}

ff_status ff_output_open(const char *path, ff_output *out, ff_error *err)
{
    return ff_output_open_with(path, NULL, out, err);
}

/* ---- finishing: every byte is where it belongs, under the temporary name ---------------------- */

/* Why an earlier write failed, whose errno is gone: asked again with one byte more, where that does no harm. */
static int reason_of_earlier(const ff_output *out)
{
    struct stat st;
    int fd = fileno(out->file);
    int harmless = out->temporary || (fstat(fd, &st) == 0 && S_ISCHR(st.st_mode));
    return harmless && write(fd, "", 1) < 0 ? errno : EIO;
}

/* 0, or the errno of the first thing that failed since the file was opened. */
static int finish_file(ff_output *out)
{
    int reason = 0;
    int earlier = ferror(out->file);
    if (fflush(out->file) != 0) reason = errno;
    if (!reason && earlier) reason = reason_of_earlier(out);
    if (!reason && out->temporary && fchmod(fileno(out->file), out->mode) != 0) reason = errno;
    if (!reason && out->temporary && !out->is_unsynced && fsync(fileno(out->file)) != 0) reason = errno;
    if (fclose(out->file) != 0 && !reason) reason = errno;
    out->file = NULL;
    return reason;
}

/* Nothing of it stays, but for what has gone to a pipe, a device or standard output already. */
static void drop(ff_output *out)
{
    if (out->file) {
        __fpurge(out->file);
        fclose(out->file);
    }
    if (out->temporary) unlink(out->temporary);
    output_release(out);
}

static ff_status fail_incomplete(const ff_output *out, int reason, ff_error *err)
{
    return fail(err, out->target ? out->target : "-", "could not be written completely", reason);
}

static ff_status finish(ff_output *out, ff_error *err)
{
    const int reason = finish_file(out);
    return reason ? fail_incomplete(out, reason, err) : FF_OK;
}

/* ---- giving names ------------------------------------------------------------------------------ */

/* The name is on the disk when its folder is. A folder that cannot be opened or synchronised (not every file system can) is left to
 * the system: the file is whole and has its name. */
static void sync_folder(const char *target)
{
    char *folder = strndup(target, (size_t)folder_length(target));
    const int fd = folder ? open(*folder ? folder : ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC) : -1;
    free(folder);
    if (fd < 0) return;
    (void)!fsync(fd);
    close(fd);
}

/* Of n finished outputs as many as can be, in their order; how many, and why no more. A signal would part them: it waits. */
static size_t give_names(ff_output *out, size_t n, int *reason)
{
    size_t i = 0;
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    for (*reason = 0; i < n; i++) {
        if (!out[i].temporary || rename(out[i].temporary, out[i].target) == 0) continue;
        *reason = errno;
        break;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return i;
}

/* Which cannot be undone. */
static void name_those_in_place(const ff_output *out, size_t n, ff_error *err)
{
    const char *between = "; in place already: ";
    for (size_t i = 0; i < n && err; i++) {
        const size_t used = strlen(err->message);
        if (!out[i].temporary) continue;
        snprintf(err->message + used, sizeof err->message - used, "%s%s", between, out[i].target);
        between = ", ";
    }
}

/* All n are finished. */
static ff_status commit_all(ff_output *out, size_t n, ff_error *err)
{
    int reason;
    ff_status status = FF_OK;
    const size_t n_named = give_names(out, n, &reason);
    for (size_t i = 0; i < n_named; i++)
        if (out[i].temporary && !out[i].is_unsynced) sync_folder(out[i].target);
    if (n_named < n) {
        status = fail_incomplete(&out[n_named], reason, err);
        name_those_in_place(out, n_named, err);
    }
    for (size_t i = 0; i < n_named; i++) output_release(&out[i]);
    for (size_t i = n_named; i < n; i++) drop(&out[i]);
    return status;
}

/* Whole, under its temporary name; what cannot be taken back waits for the others. */
static ff_status hand_over(ff_output *out, ff_error *err)
{
    ff_outputs *all = out->with;
    ff_status status = out->temporary ? finish(out, err) : FF_OK;
    if (status == FF_OK && all->n == FF_OUTPUTS_MOST)
        status = ff_error_set(err, FF_ERR_INTERNAL, out->target ? out->target : "-", 0, -1, "is one output more than %d",
                              FF_OUTPUTS_MOST);
    if (status != FF_OK) {
        drop(out);
        return status;
    }
    all->of[all->n++] = *out;
    *out = (ff_output){0};
    return FF_OK;
}

ff_status ff_output_commit(ff_output *out, ff_error *err)
{
    if (out->with) return hand_over(out, err);
    const ff_status status = finish(out, err);
    if (status == FF_OK) return commit_all(out, 1, err);
    drop(out);
    return status;
}

void ff_output_abort(ff_output *out)
{
    if (out && out->file) drop(out);
}

ff_status ff_outputs_commit(ff_outputs *all, ff_error *err)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < all->n && status == FF_OK; i++)
        if (all->of[i].file) status = finish(&all->of[i], err);
    if (status == FF_OK) {
        status = commit_all(all->of, all->n, err);
        all->n = 0;
    }
    ff_outputs_abort(all);
    return status;
}

void ff_outputs_abort(ff_outputs *all)
{
    for (size_t i = 0; i < all->n; i++) drop(&all->of[i]);
    all->n = 0;
}
