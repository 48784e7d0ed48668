/** @file ff_words.h  What a person reads of the codes of the library: one sentence of a warning, an error or a reader's note.
 *
 *  The library says what is so, in codes and numbers. Here it becomes a sentence, which may name flags of the program `facetfit`;
 *  a program with other ways to be told makes its own sentences of the same codes.
 *  Numbers  do not depend on the locale.
 *  Threads  no global state. */
#ifndef FF_WORDS_H
#define FF_WORDS_H
#include "ff_api.h"
#include "ff_fit.h"
#include "ff_ndf.h"
#ifdef __cplusplus
extern "C" {
#endif

/** A warning of a fit to p as a sentence without a full stop: "kd (12 of 121 channels, 400nm to 500nm) is on its lower bound, 0".
 *  Into out [size], cut to fit and always terminated; returns the length of the whole sentence. */
FF_API size_t ff_words_fit_warning(const ff_problem *p, const ff_fit_result *fit, const ff_warning *w, char *out, size_t size);

/** The same of a retrieved distribution. */
FF_API size_t ff_words_ndf_warning(const ff_problem *p, const ff_ndf_result *retrieved, const ff_warning *w, char *out,
                                   size_t size);

/** What follows the message that has the hint: "; say --scale, the 1/sr of one of them", "" for FF_HINT_NONE and what is none. */
FF_API const char *ff_words_hint(ff_hint hint);

/** As ff_error_format, with what the hint says behind it. */
FF_API void ff_words_error(const ff_error *err, char *out, size_t size);

#ifdef __cplusplus
}
#endif
#endif
