/** @file ff_json.h  Writing JSON to a stream: commas, escapes and numbers that read back as the same double.
 *
 *  Inside an object every call takes a key; inside an array the key is NULL. Write errors stay in the stream (ferror).
 *  Numbers  do not depend on the locale; NaN and infinities become null, for JSON has no word for them.
 *  Text     is UTF-8; bytes that are not become U+FFFD, so that the document is always valid.
 *  Threads  a writer belongs to one thread at a time. */
#ifndef FF_JSON_H
#define FF_JSON_H
#include <stdint.h>
#include <stdio.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_JSON_DEPTH = 16 };

/** How the members of an object or array are laid out. */
typedef enum ff_json_layout {
    FF_JSON_BLOCK = 0, /**< one to a line, indented        */
    FF_JSON_LINE = 1   /**< everything inside on one line  */
} ff_json_layout;

/** A writer; fill with ff_json_begin. At most FF_JSON_DEPTH levels. */
typedef struct ff_json {
    FILE *file;
    int depth;
    unsigned char filled[FF_JSON_DEPTH + 1], line[FF_JSON_DEPTH + 1], array[FF_JSON_DEPTH + 1];
} ff_json;

void ff_json_begin(ff_json *j, FILE *file);
void ff_json_end(ff_json *j); /**< ends the last line */

void ff_json_object(ff_json *j, const char *key, ff_json_layout layout); /**< opens; ff_json_close closes */
void ff_json_array(ff_json *j, const char *key, ff_json_layout layout);
void ff_json_close(ff_json *j);

void ff_json_string(ff_json *j, const char *key, const char *value); /**< value NULL = null */
void ff_json_number(ff_json *j, const char *key, double value);
void ff_json_integer(ff_json *j, const char *key, int64_t value);
void ff_json_bool(ff_json *j, const char *key, int value);
void ff_json_null(ff_json *j, const char *key);

#ifdef __cplusplus
}
#endif
#endif
