/** @file internal_errno.h  What an errno means, for any number of threads. */
#ifndef FF_INTERNAL_ERRNO_H
#define FF_INTERNAL_ERRNO_H

enum { FF_ERRNO_TEXT = 128 };

/** Writes it to out, "error 42" where the system knows nothing of it, and returns out. */
const char *ff_errno_text(int error, char out[FF_ERRNO_TEXT]);
#endif
