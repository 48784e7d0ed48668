/* Status names and the error object. */
#define _GNU_SOURCE
#include "ff_status.h"
#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const char *ff_status_str(ff_status status)
{
    switch (status) {
    case FF_OK:
        return "done";
    case FF_ERR_RANGE:
        return "out of range";
    case FF_ERR_UNKNOWN:
        return "unknown name";
    case FF_ERR_SYNTAX:
        return "syntax error";
    case FF_ERR_UNSUPPORTED:
        return "unsupported combination";
    case FF_ERR_MEMORY:
        return "out of memory";
    case FF_ERR_OPEN:
        return "cannot be opened";
    case FF_ERR_READ:
        return "cannot be read";
    case FF_ERR_FORMAT:
        return "wrong format";
    case FF_ERR_DATA:
        return "unusable data";
    case FF_ERR_WRITE:
        return "cannot be written";
    case FF_ERR_CANCELLED:
        return "cancelled";
    case FF_ERR_INTERNAL:
        return "internal error";
    default:
        return "unknown status";
    }
}

/* Cuts a string that was too long for its buffer with "..." and never inside a UTF-8 character. */
static void mark_cut(char *text, size_t size)
{
    size_t end = size - 4;
    while (end > 0 && ((unsigned char)text[end] & 0xC0u) == 0x80u) end--;
    memcpy(text + end, "...", 4);
}

/* vsnprintf with a decimal point whatever the program's locale is. */
static void format_message(char *out, size_t size, const char *fmt, va_list args)
{
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    locale_t previous = c_locale ? uselocale(c_locale) : (locale_t)0;
    int length = vsnprintf(out, size, fmt, args);
    if (c_locale) {
        uselocale(previous);
        freelocale(c_locale);
    }
    if (length < 0) out[0] = '\0';
    if (length >= (int)size) mark_cut(out, size);
}

ff_status ff_error_set(ff_error *err, ff_status code, const char *path, long line, int64_t byte, const char *fmt, ...)
{
    if (!err) return code;
    char message[FF_ERROR_MESSAGE]; /* first here: the arguments may point into *err */
    va_list args;
    va_start(args, fmt);
    format_message(message, sizeof message, fmt, args);
    va_end(args);

    size_t length = path ? strlen(path) : 0;
    size_t kept = length < sizeof err->path ? length : sizeof err->path - 1;
    if (kept) memmove(err->path, path, kept);
    err->path[kept] = '\0';
    memcpy(err->message, message, sizeof message);
    err->code = code;
    err->line = line;
    err->byte = byte;
    err->hint = FF_HINT_NONE;
    return code;
}

ff_status ff_error_hint(ff_error *err, ff_status code, ff_hint hint)
{
    if (err) err->hint = hint;
    return code;
}

void ff_error_format(const ff_error *err, char *out, unsigned long size)
{
    if (size == 0) return;
    if (err->path[0] == '\0')
        snprintf(out, size, "%s", err->message);
    else if (err->line > 0)
        snprintf(out, size, "%s:%ld: %s", err->path, err->line, err->message);
    else if (err->byte >= 0)
        snprintf(out, size, "%s: byte %lld: %s", err->path, (long long)err->byte, err->message);
    else
        snprintf(out, size, "%s: %s", err->path, err->message);
}
