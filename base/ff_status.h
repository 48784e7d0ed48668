/** @file ff_status.h  Status codes and the error object that every room uses.
 *
 *  A call that can fail returns an ff_status; outputs are written only when it is FF_OK. Calls that read a file or a person's
 *  words also take a caller-owned ff_error that says where and what. Nothing here allocates, prints, exits or aborts.
 *  Threads  every function may be called from many threads at once; an ff_error belongs to one of them. */
#ifndef FF_STATUS_H
#define FF_STATUS_H
#include "ff_api.h"
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

/** Outcome of a call. The numbers are explicit and never reused. */
typedef int32_t ff_status;
enum {
    FF_OK = 0,              /**< done; outputs are written                                          */
    FF_ERR_RANGE = 1,       /**< a number lies outside its documented range                         */
    FF_ERR_UNKNOWN = 2,     /**< no model, parameter, format, loss ... of that name                 */
    FF_ERR_SYNTAX = 3,      /**< a model expression, parameter list or number cannot be parsed      */
    FF_ERR_UNSUPPORTED = 4, /**< each part is known, the combination has no meaning                 */
    FF_ERR_MEMORY = 5,      /**< an allocation failed                                               */
    FF_ERR_OPEN = 6,        /**< an input cannot be opened                                          */
    FF_ERR_READ = 7,        /**< an input ended early or the system refused to read it              */
    FF_ERR_FORMAT = 8,      /**< an input is not what its format says                               */
    FF_ERR_DATA = 9,        /**< an input is well-formed, its content is not usable                 */
    FF_ERR_WRITE = 10,      /**< an output cannot be written; nothing was left behind               */
    FF_ERR_CANCELLED = 11,  /**< the caller asked to stop                                           */
    FF_ERR_INTERNAL = 12    /**< a defect of this library                                           */
};

/** What the caller can say to help, where something can be said. A message does not name it, for every program has its own way of
 *  being told: ff_words_hint has the words of the program `facetfit`. The numbers are explicit and never reused. */
typedef enum ff_hint {
    FF_HINT_NONE = 0,
    FF_HINT_SCALE = 1,            /**< what one unit of the file's numbers is, in 1/sr: ff_read_options.scale     */
    FF_HINT_QUANTITY = 2,         /**< what the file's numbers are: ff_read_options.quantity                       */
    FF_HINT_QUANTITY_BRDF = 3,    /**< that they are the BRDF, should they not be what was assumed                 */
    FF_HINT_SAY = 5,              /**< the message ends with "say OPTION VALUE": an option of ff_read_options and its value */
    FF_HINT_RESULT = 6,           /**< the file is a result of fits, no measurement                                */
    FF_HINT_QUANTITY_BRDF_COS = 4 /**< that they are the BRDF times cos(theta_o), should they not be what was assumed */
} ff_hint;
enum { FF_HINT_COUNT = 7 };

enum { FF_ERROR_PATH = 512, FF_ERROR_MESSAGE = 768 };

/** What went wrong and where. Zero-initialise; a call fills it only when it returns a status other than FF_OK. */
typedef struct ff_error {
    ff_status code;                 /**< the status that was returned                          */
    char path[FF_ERROR_PATH];       /**< file, or "" when none is concerned; cut at its end    */
    long line;                      /**< 1-based line of a text file, 0 = not known            */
    int64_t byte;                   /**< 0-based offset in a binary file, -1 = not known       */
    char message[FF_ERROR_MESSAGE]; /**< one sentence: what was found, what was expected   */
    ff_hint hint;                   /**< what the caller can say, FF_HINT_NONE mostly       */
} ff_error;

/** Name of a status ("out of range"), for messages. Never NULL, also for numbers that are no status. */
FF_API const char *ff_status_str(ff_status status);

/** Fills *err (may be NULL), without a hint, and returns code, so that a failing path reads `return ff_error_set(...)`.
 *  @param path  file concerned or NULL
 *  @param line  1-based, 0 = not known
 *  @param byte  0-based, -1 = not known
 *  @param fmt   printf format of the message */
FF_API ff_status ff_error_set(ff_error *err, ff_status code, const char *path, long line, int64_t byte, const char *fmt, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 6, 7)))
#endif
    ;

/** Adds to *err (may be NULL) what would help, and returns code: `return ff_error_hint(err, ff_error_set(...), hint)`. */
FF_API ff_status ff_error_hint(ff_error *err, ff_status code, ff_hint hint);

/** Writes "PATH:LINE: MESSAGE", "PATH: byte N: MESSAGE" or "MESSAGE" into out [size], always terminated. */
FF_API void ff_error_format(const ff_error *err, char *out, unsigned long size);

#ifdef __cplusplus
}
#endif
#endif
