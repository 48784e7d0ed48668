/* Options of callers that were compiled with another version. */
#include "internal_options.h"
#include <string.h>

/* Beyond it a size is a number that happened to be there: nothing of it is read. */
enum { LONGEST = 1 << 16 };

static size_t size_of(const void *record)
{
    size_t size;
    memcpy(&size, record, sizeof size);
    return size;
}

static void set_size(void *record, size_t size)
{
    if (size >= sizeof size) memcpy(record, &size, sizeof size);
}

static size_t least(size_t a, size_t b)
{
    return a < b ? a : b;
}

void ff_options_init(void *to, size_t size, const void *defaults, size_t known)
{
    memcpy(to, defaults, least(size, known));
    if (size > known) memset((unsigned char *)to + known, 0, size - known);
    set_size(to, size);
}

static ff_status check_size(const char *type, size_t size, size_t first, const char *how, ff_error *err)
{
    if (size >= first && size <= LONGEST) return FF_OK;
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a size of %zu is none of %s; %s", size, type, how);
}

ff_status ff_options_take(const char *type, const void *from, size_t first, void *out, size_t known, ff_error *err)
{
    const size_t size = size_of(from);
    const ff_status status = check_size(type, size, first, "expected what its _init function sets", err);
    if (status) return status;
    for (size_t i = known; i < size; i++)
        if (((const unsigned char *)from)[i])
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                                "%s has %zu bytes, and an option beyond the %zu that this version of the library knows is set",
                                type, size, known);
    memcpy(out, from, least(size, known));
    set_size(out, known);
    return FF_OK;
}

ff_status ff_record_check(const char *type, const void *record, size_t first, ff_error *err)
{
    return check_size(type, size_of(record), first, "expected its sizeof", err);
}
