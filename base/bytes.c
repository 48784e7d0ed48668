/* Binary files in order. */
#define _GNU_SOURCE
#include "internal_bytes.h"
#include "internal_input.h"
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

ff_status ff_bytes_open(const char *path, ff_bytes *b, ff_error *err)
{
    ff_bytes opened = {.path = path, .err = err};
    const ff_status status = ff_input_open(path, &opened.fd, &opened.size, err);
    if (status == FF_OK) *b = opened;
    return status;
}

void ff_bytes_close(ff_bytes *b)
{
    if (b->fd >= 0) close(b->fd);
    b->fd = -1;
}

static ff_status ended(const ff_bytes *b, int64_t found, const char *what)
{
    return ff_error_set(b->err, FF_ERR_READ, b->path, 0, found, "found the end of the file after %lld bytes, expected %s",
                        (long long)found, what);
}

ff_status ff_bytes_read(ff_bytes *b, void *out, size_t n, const char *what)
{
    size_t got = 0;
    const ff_status status = ff_input_read(b->fd, b->path, b->offset, out, n, &got, b->err);
    if (status != FF_OK) return status;
    b->offset += (int64_t)got;
    return got == n ? FF_OK : ended(b, b->offset, what);
}

ff_status ff_bytes_need(const ff_bytes *b, uint64_t n, const char *what)
{
    if (b->size < 0 || (b->size >= b->offset && n <= (uint64_t)(b->size - b->offset))) return FF_OK;
    return ended(b, b->size, what);
}

ff_status ff_bytes_end(ff_bytes *b, const char *after)
{
    unsigned char more;
    size_t got = 0;
    const ff_status status = ff_input_read(b->fd, b->path, b->offset, &more, 1, &got, b->err);
    if (status != FF_OK || got == 0) return status;
    char found[32] = "more";
    if (b->size > b->offset) snprintf(found, sizeof found, "%lld", (long long)(b->size - b->offset));
    return ff_error_set(b->err, FF_ERR_FORMAT, b->path, 0, b->offset, "found %s bytes after %s, expected the end of the file",
                        found, after);
}

static ff_status no_memory(const ff_bytes *b, size_t bytes)
{
    return ff_error_set(b->err, FF_ERR_MEMORY, b->path, 0, b->offset, "no memory for %zu bytes of the file", bytes);
}

static uint64_t left_of(const ff_bytes *b, uint64_t unless_known)
{
    return b->size < 0 ? unless_known : b->size > b->offset ? (uint64_t)(b->size - b->offset) : 0;
}

ff_status ff_bytes_head(ff_bytes *b, size_t most, unsigned char **data, size_t *n)
{
    const uint64_t left = left_of(b, most);
    const size_t room = left < most ? (size_t)left : most;
    unsigned char *bytes = malloc(room + 1);
    size_t got = 0;
    if (!bytes) return no_memory(b, room);
    const ff_status status = ff_input_read(b->fd, b->path, b->offset, bytes, room, &got, b->err);
    if (status != FF_OK) {
        free(bytes);
        return status;
    }
    b->offset += (int64_t)got;
    *data = bytes;
    *n = got;
    return FF_OK;
}

static ff_status more_than(const ff_bytes *b, size_t most)
{
    return ff_error_set(b->err, FF_ERR_FORMAT, b->path, 0, b->offset, "found a file of more than %zu bytes, expected fewer", most);
}

/* Reads behind *used bytes until the file ends. */
static ff_status read_rest(ff_bytes *b, size_t most, unsigned char **bytes, size_t *used)
{
    enum { STEP = 1 << 16 };
    const uint64_t left = left_of(b, STEP);
    if (*used > most || (b->size >= 0 && left > most - *used)) return more_than(b, most);
    for (size_t capacity = *used + (size_t)left + 1;; capacity *= 2) {
        if (capacity > most + 1) capacity = most + 1;
        unsigned char *larger = realloc(*bytes, capacity);
        if (!larger) return no_memory(b, capacity);
        *bytes = larger;
        size_t got = 0;
        const ff_status status = ff_input_read(b->fd, b->path, b->offset, larger + *used, capacity - *used, &got, b->err);
        *used += got;
        b->offset += (int64_t)got;
        if (status != FF_OK || *used < capacity) return status;
        if (*used > most) return more_than(b, most);
    }
}

ff_status ff_bytes_rest(ff_bytes *b, size_t most, unsigned char **data, size_t *n)
{
    const ff_status status = read_rest(b, most, data, n);
    if (status == FF_OK) return FF_OK;
    free(*data);
    *data = NULL;
    *n = 0;
    return status;
}

int ff_all_finite(const double *v, size_t n)
{
    uint64_t any = 0;
    for (size_t i = 0; i < n; i++) {
        uint64_t u;
        memcpy(&u, v + i, 8);
        any |= (u & UINT64_C(0x7FFFFFFFFFFFFFFF)) + UINT64_C(0x0010000000000000); /* carries into the top bit */
    }
    return any >> 63 == 0;
}
