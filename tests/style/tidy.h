/* What clang-tidy is told of the errors, included in front of every source but base/status.c: the analyzer looks at one file at a
 * time and would else assume that `return ff_error_set(err, FF_ERR_MEMORY, ...)` may return FF_OK, with nothing where the caller
 * looks. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* before the first header of the C library, as in the sources that need it */
#endif
#include "../../base/ff_status.h"

#define ff_error_set(err, code, ...)   (ff_error_set(err, code, __VA_ARGS__), (code))
#define ff_error_hint(err, code, hint) (ff_error_hint(err, code, hint), (code))
