/** @file internal_input.h  Opening inputs, and lines of text without holding the file in memory. */
#ifndef FF_INTERNAL_INPUT_H
#define FF_INTERNAL_INPUT_H
#include "ff_status.h"
#include <stddef.h>

/** Opens path for reading ("-" is standard input). *size is -1 for what has none (pipes, devices). A file packed with gzip and text
 *  in UTF-16 are unpacked into memory (internal_plain.h), and what is read is that.
 *  FF_ERR_OPEN for a missing file, a directory, no permission; those of ff_plain_open. The caller closes *fd. */
ff_status ff_input_open(const char *path, int *fd, int64_t *size, ff_error *err);

/** Opens path to look at its first bytes before it is read from there. Standard input that cannot be wound back, a pipe, is copied
 * to memory, and the copy takes its place as the process's standard input. Any other pipe or device has *size = -1 as before, and
 * what is looked at is gone. Close it with ff_input_unlook, which goes back to where it began. Errors as ff_input_open,
 * FF_ERR_READ, FF_ERR_MEMORY. Not for several threads at once where path is "-". */
ff_status ff_input_look(const char *path, int *fd, int64_t *size, ff_error *err);
void ff_input_unlook(const char *path, int fd, size_t looked_at);

/** Reads up to `bytes` bytes into out and stops early only at the end of the input; *got is what arrived.
 *  `offset` is the position of the first of them, for the message of FF_ERR_READ. */
ff_status ff_input_read(int fd, const char *path, int64_t offset, void *out, size_t bytes, size_t *got, ff_error *err);

/** A line is refused beyond this length; nothing that people measure comes near. */
enum { FF_LINE_BYTES = 1 << 24 };

/** Reader of lines. */
typedef struct ff_lines {
    const char *path; /**< the caller's string                                                      */
    int fd;
    char *buffer;
    size_t capacity, begin, end; /**< unread bytes are buffer[begin..end)                        */
    int64_t offset;              /**< position in the file of buffer[0]                                 */
    long line;                   /**< number of the line handed out last, 1-based                       */
    int at_end;                  /**< the file has no more bytes than those in buffer                   */
    char ends;                   /**< what ends a line: '\n', or '\r' in a file that has no other            */
    int unterminated;            /**< the line handed out last had no end-of-line: it may have been cut */
} ff_lines;

/** Bytes of the UTF-8 byte-order mark that head (n bytes, the start of a file) begins with: 3 or 0. */
size_t ff_byte_order_mark(const void *head, size_t n);

/** Opens path; a UTF-8 byte-order mark is skipped. *lines is written only on FF_OK; then ff_lines_close must follow. */
ff_status ff_lines_open(const char *path, ff_lines *lines, ff_error *err);
void ff_lines_close(ff_lines *lines);

/** Hands out the next line, without "\n", "\r\n", "\r\r\n" or (where all have it) "\r", with a '\0' at text[*length]; valid until
 * the next call. *text is NULL at the end. FF_ERR_FORMAT for a NUL byte or an overlong line, FF_ERR_READ, FF_ERR_MEMORY. */
ff_status ff_lines_next(ff_lines *lines, char **text, size_t *length, ff_error *err);

enum { FF_QUOTE = 96 };
/** Text of a file as it can stand in a message: 'abc', all but printable ASCII as \xNN, cut when long. Returns out. */
const char *ff_quote(const char *text, size_t length, char out[FF_QUOTE]);
#endif
