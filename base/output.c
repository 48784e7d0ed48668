/* Output files that appear whole or not at all. */
#define _GNU_SOURCE
#include "internal_output.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio_ext.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_BYTES = 1 << 16, NAME_ATTEMPTS = 1000 };

static void output_release(ff_output *out)
{
    free(out->target);
    free(out->temporary);
    *out = (ff_output){0};
}

static ff_status fail(ff_error *err, const char *path, const char *what, int reason)
{
    return ff_error_set(err, FF_ERR_WRITE, path, 0, -1, "%s: %s", what, strerror(reason));
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

/* Creates "TARGET.part-PID-N" with the first N that is free. */
static int create_temporary(const char *target, mode_t mode, char **name)
{
    for (int attempt = 0; attempt < NAME_ATTEMPTS; attempt++) {
        if (asprintf(name, "%s.part-%ld-%d", target, (long)getpid(), attempt) < 0) {
            *name = NULL;
            errno = ENOMEM;
            return -1;
        }
        int fd = open(*name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (fd >= 0) return fd;
        int reason = errno;
        free(*name);
        *name = NULL;
        errno = reason;
        if (reason != EEXIST) return -1;
    }
    return -1;
}

/* A new file beside target, or beside the existing regular file that it will replace. */
static ff_status open_replacing(const char *path, const struct stat *old, ff_output *out, ff_error *err)
{
    if (old && access(path, W_OK) != 0) return fail(err, path, "exists and cannot be written", errno);
    char *target = old ? realpath(path, NULL) : strdup(path), *temporary = NULL;
    if (!target) return fail(err, path, "cannot be written", errno);
    int fd = create_temporary(target, 0666, &temporary);
    if (fd < 0) {
        int reason = errno;
        free(target);
        return fail(err, path, "no file can be created beside it", reason);
    }
    ff_output o = {.target = target, .temporary = temporary};
    if (old) (void)fchmod(fd, old->st_mode & 07777); /* another owner's file: then ours keeps the default mode */
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

ff_status ff_output_open(const char *path, ff_output *out, ff_error *err)
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
    if (!reason && out->temporary && fsync(fileno(out->file)) != 0) reason = errno;
    if (fclose(out->file) != 0 && !reason) reason = errno;
    out->file = NULL;
    if (!reason && out->temporary && rename(out->temporary, out->target) != 0) reason = errno;
    return reason;
}

ff_status ff_output_commit(ff_output *out, ff_error *err)
{
    int reason = finish_file(out);
    ff_status status = FF_OK;
    if (reason) {
        if (out->temporary) unlink(out->temporary);
        status = fail(err, out->target ? out->target : "-", "could not be written completely", reason);
    }
    output_release(out);
    return status;
}

void ff_output_abort(ff_output *out)
{
    if (!out || !out->file) return;
    __fpurge(out->file); /* what has not gone to a pipe or to stdout yet shall not */
    fclose(out->file);
    if (out->temporary) unlink(out->temporary);
    output_release(out);
}
