/* What an errno means. POSIX's strerror_r: GNU's has another form of the same name. */
#undef _GNU_SOURCE
#define _POSIX_C_SOURCE 200809L
#include "internal_errno.h"
#include <stdio.h>
#include <string.h>

const char *ff_errno_text(int error, char out[FF_ERRNO_TEXT])
{
    if (strerror_r(error, out, FF_ERRNO_TEXT) != 0) snprintf(out, FF_ERRNO_TEXT, "error %d", error);
    return out;
}
