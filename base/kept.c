/* Text that is written to memory. */
#define _GNU_SOURCE /* fopencookie */
#include "internal_kept.h"
#include <stdlib.h>
#include <string.h>

static ssize_t keep(void *cookie, const char *bytes, size_t n)
{
    ff_kept *k = cookie;
    if (n >= k->room - k->n) {
        const size_t room = 2 * k->room + n;
        char *longer = realloc(k->text, room);
        if (!longer) return 0;
        k->text = longer;
        k->room = room;
    }
    memcpy(k->text + k->n, bytes, n);
    k->n += n;
    k->text[k->n] = '\0';
    return (ssize_t)n;
}

FILE *ff_kept_open(ff_kept *k)
{
    enum { FIRST = 4096 };
    *k = (ff_kept){calloc(1, FIRST), 0, FIRST};
    FILE *stream = k->text ? fopencookie(k, "w", (cookie_io_functions_t){.write = keep}) : NULL;
    if (!stream) {
        free(k->text);
        *k = (ff_kept){NULL, 0, 0};
    }
    return stream;
}

ff_status ff_kept_close(ff_kept *k, FILE *stream)
{
    if (!stream) return FF_ERR_MEMORY;
    const int failed = ferror(stream);
    if (fclose(stream) == 0 && !failed) return FF_OK;
    free(k->text);
    *k = (ff_kept){NULL, 0, 0};
    return FF_ERR_MEMORY;
}
