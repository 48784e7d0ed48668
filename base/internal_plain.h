/** @file internal_plain.h  Files as readers want them: unpacked, and text as UTF-8. */
#ifndef FF_INTERNAL_PLAIN_H
#define FF_INTERNAL_PLAIN_H
#include "ff_status.h"
#include <stddef.h>

/** What a packed or converted file may come to, in bytes: beyond that it is refused, before memory is gone. */
enum { FF_PLAIN_BYTES_LOG2 = 32 };

/** Where a file that was opened for reading begins with the mark of gzip (RFC 1952), or is text in UTF-16 (with a byte-order mark,
 *  or without one where every other byte of its beginning is 0), its plain bytes are put into memory, and *fd and *size become
 *  those of that memory; the file itself is closed. Anything else, and what is no regular file, stays as it is.
 *  FF_ERR_FORMAT: packed data that are damaged or cut, or too many bytes; FF_ERR_READ, FF_ERR_MEMORY. On failure *fd is closed. */
ff_status ff_plain_open(const char *path, int *fd, int64_t *size, ff_error *err);

/** ISO-8859-1 (with the signs that Windows adds) as UTF-8: writes the bytes of one character to out [3], returns their number. */
size_t ff_plain_latin(unsigned char c, char *out);

/** 1 when text is UTF-8 as it should be. */
int ff_plain_is_utf8(const char *text, size_t length);
#endif
