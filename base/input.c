/* Opening inputs, and lines of text. */
#define _GNU_SOURCE
#include "internal_input.h"
#include "internal_errno.h"
#include "internal_plain.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FIRST_CAPACITY = 1 << 17 };

ff_status ff_input_open(const char *path, int *fd, int64_t *size, ff_error *err)
{
    int opened = strcmp(path, "-") == 0 ? fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3) : open(path, O_RDONLY | O_CLOEXEC);
    struct stat st;
    if (opened < 0 || fstat(opened, &st) != 0) {
        int reason = errno;
        if (opened >= 0) close(opened);
        return ff_error_set(err, FF_ERR_OPEN, path, 0, -1, "cannot be opened: %s",
                            ff_errno_text(reason, (char[FF_ERRNO_TEXT]){""}));
    }
    if (S_ISDIR(st.st_mode)) {
        close(opened);
        return ff_error_set(err, FF_ERR_OPEN, path, 0, -1, "found a directory, expected a file");
    }
    *fd = opened;
    *size = S_ISREG(st.st_mode) ? (int64_t)st.st_size : -1;
    return ff_plain_open(path, fd, size, err);
}

ff_status ff_input_read(int fd, const char *path, int64_t offset, void *out, size_t bytes, size_t *got, ff_error *err)
{
    size_t done = 0;
    while (done < bytes) {
        ssize_t n = read(fd, (char *)out + done, bytes - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) {
            const char *reason = ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""});
            return ff_error_set(err, FF_ERR_READ, path, 0, offset + (int64_t)done, "cannot be read further: %s", reason);
        }
        if (n == 0) break;
        done += (size_t)n;
    }
    *got = done;
    return FF_OK;
}

/* ---- looking before reading ------------------------------------------------------------------ */

static ff_status write_all(int fd, const char *bytes, size_t n, ff_error *err)
{
    for (size_t done = 0; done < n;) {
        const ssize_t w = write(fd, bytes + done, n - done);
        if (w < 0 && errno == EINTR) continue;
        if (w <= 0) return ff_error_set(err, FF_ERR_MEMORY, "-", 0, -1, "no memory for what comes through a pipe");
        done += (size_t)w;
    }
    return FF_OK;
}

static ff_status copy_all(int from, int to, ff_error *err)
{
    char block[1 << 14];
    for (int64_t at = 0;; at += (int64_t)sizeof block) {
        size_t got = 0;
        ff_status status = ff_input_read(from, "-", at, block, sizeof block, &got, err);
        if (status == FF_OK) status = write_all(to, block, got, err);
        if (status != FF_OK || got < sizeof block) return status;
    }
}

static ff_status keep_pipe(int pipe, ff_error *err)
{
    const int copy = memfd_create("facetfit-stdin", MFD_CLOEXEC);
    if (copy < 0) return ff_error_set(err, FF_ERR_MEMORY, "-", 0, -1, "no memory for what comes through a pipe");
    ff_status status = copy_all(pipe, copy, err);
    if (status == FF_OK && (lseek(copy, 0, SEEK_SET) != 0 || dup2(copy, STDIN_FILENO) < 0))
        status = ff_error_set(err, FF_ERR_READ, "-", 0, -1, "cannot be kept: %s", ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
    close(copy);
    return status;
}

ff_status ff_input_look(const char *path, int *fd, int64_t *size, ff_error *err)
{
    ff_status status = ff_input_open(path, fd, size, err);
    if (status != FF_OK || *size >= 0 || strcmp(path, "-") != 0) return status;
    status = keep_pipe(*fd, err);
    close(*fd);
    return status == FF_OK ? ff_input_open(path, fd, size, err) : status;
}

void ff_input_unlook(const char *path, int fd, size_t looked_at)
{
    if (strcmp(path, "-") == 0) lseek(fd, -(off_t)looked_at, SEEK_CUR); /* the place is that of standard input itself */
    close(fd);
}

size_t ff_byte_order_mark(const void *head, size_t n)
{
    return n >= 3 && memcmp(head, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
}

ff_status ff_lines_open(const char *path, ff_lines *lines, ff_error *err)
{
    ff_lines l = {.path = path, .fd = -1, .capacity = FIRST_CAPACITY, .ends = '\n'};
    int64_t size;
    ff_status status = ff_input_open(path, &l.fd, &size, err);
    if (status != FF_OK) return status;
    l.buffer = malloc(l.capacity);
    if (!l.buffer) {
        close(l.fd);
        return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for a buffer of %zu bytes", l.capacity);
    }
    status = ff_input_read(l.fd, path, 0, l.buffer, 3, &l.end, err);
    if (status != FF_OK) {
        ff_lines_close(&l);
        return status;
    }
    l.begin = ff_byte_order_mark(l.buffer, l.end);
    *lines = l;
    return FF_OK;
}

void ff_lines_close(ff_lines *lines)
{
    if (lines->fd >= 0) close(lines->fd);
    free(lines->buffer);
    *lines = (ff_lines){.fd = -1};
}

static ff_status line_too_long(const ff_lines *l, ff_error *err)
{
    return ff_error_set(err, FF_ERR_FORMAT, l->path, l->line + 1, -1,
                        "found a line of more than %d bytes, expected lines of text: is this a binary file?", FF_LINE_BYTES);
}

/* Moves the unread bytes to the front, makes room and reads more. One byte stays free for the '\0' of a last line. */
static ff_status lines_fill(ff_lines *l, ff_error *err)
{
    memmove(l->buffer, l->buffer + l->begin, l->end - l->begin);
    l->offset += (int64_t)l->begin;
    l->end -= l->begin;
    l->begin = 0;
    if (l->capacity - l->end < l->capacity / 2) {
        if (l->end > FF_LINE_BYTES) return line_too_long(l, err);
        char *larger = realloc(l->buffer, 2 * l->capacity);
        if (!larger) return ff_error_set(err, FF_ERR_MEMORY, l->path, l->line + 1, -1, "no memory for a line this long");
        l->buffer = larger;
        l->capacity *= 2;
    }
    size_t room = l->capacity - 1 - l->end, got = 0;
    ff_status status = ff_input_read(l->fd, l->path, l->offset + (int64_t)l->end, l->buffer + l->end, room, &got, err);
    if (status != FF_OK) return status;
    l->end += got;
    l->at_end = got < room;
    if (l->line == 0 && l->offset + (int64_t)l->begin <= 3 && l->end > l->begin && !memchr(l->buffer, '\n', l->end) &&
        memchr(l->buffer, '\r', l->end - !l->at_end))
        l->ends = '\r';
    return FF_OK;
}

ff_status ff_lines_next(ff_lines *l, char **text, size_t *length, ff_error *err)
{
    char *newline;
    size_t searched = 0;
    while (!(newline = memchr(l->buffer + l->begin + searched, l->ends, l->end - l->begin - searched)) && !l->at_end) {
        searched = l->end - l->begin;
        ff_status status = lines_fill(l, err);
        if (status != FF_OK) return status;
        if (l->ends == '\r' && l->line == 0) searched = 0;
    }
    *text = NULL;
    *length = 0;
    if (!newline && l->begin == l->end) return FF_OK;

    char *start = l->buffer + l->begin, *stop = newline ? newline : l->buffer + l->end;
    if (stop - start > FF_LINE_BYTES) return line_too_long(l, err);
    l->unterminated = !newline;
    l->begin = newline ? (size_t)(newline + 1 - l->buffer) : l->end;
    l->line++;
    const char *nul = memchr(start, '\0', (size_t)(stop - start));
    if (nul)
        return ff_error_set(err, FF_ERR_FORMAT, l->path, l->line, l->offset + (nul - l->buffer),
                            "found a NUL byte (byte %lld of the file), expected UTF-8 text: is this a binary or UTF-16 file?",
                            (long long)(l->offset + (nul - l->buffer)));
    while (stop > start && stop[-1] == '\r') stop--;
    *stop = '\0';
    *text = start;
    *length = (size_t)(stop - start);
    return FF_OK;
}

const char *ff_quote(const char *text, size_t length, char out[FF_QUOTE])
{
    enum { ROOM = FF_QUOTE - 5 }; /* for "...", the closing quote and the end */
    size_t at = 0;
    out[at++] = '\'';
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        int plain = c >= 0x20 && c < 0x7F;
        if (at + (plain ? 1 : 4) > ROOM) {
            memcpy(out + at, "...", 3);
            at += 3;
            break;
        }
        if (plain)
            out[at++] = (char)c;
        else
            at += (size_t)snprintf(out + at, 5, "\\x%02x", c);
    }
    out[at++] = '\'';
    out[at] = '\0';
    return out;
}
