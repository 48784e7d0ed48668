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

ff_status ff_bytes_rest(ff_bytes *b, size_t most, unsigned char **data, size_t *n)
{
    enum { STEP = 1 << 16 };
    size_t capacity = b->size >= b->offset ? (size_t)(b->size - b->offset) + 1 : STEP, used = 0;
    unsigned char *bytes = NULL;
    for (;;) {
        if (capacity > most + 1) capacity = most + 1;
        unsigned char *larger = realloc(bytes, capacity);
        if (!larger) {
            free(bytes);
            return ff_error_set(b->err, FF_ERR_MEMORY, b->path, 0, b->offset, "no memory for %zu bytes of the file", capacity);
        }
        bytes = larger;
        size_t got = 0;
        const ff_status status = ff_input_read(b->fd, b->path, b->offset, bytes + used, capacity - used, &got, b->err);
        used += got;
        b->offset += (int64_t)got;
        if (status == FF_OK && used <= most && used == capacity) {
            capacity = 2 * capacity;
            continue;
        }
        if (status == FF_OK && used <= most) break;
        free(bytes);
        return status ? status
                      : ff_error_set(b->err, FF_ERR_FORMAT, b->path, 0, b->offset,
                                     "found a file of more than %zu bytes, expected fewer", most);
    }
    *data = bytes;
    *n = used;
    return FF_OK;
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
