/** @file internal_sha256.h  SHA-256 (FIPS 180-4): which bytes a result was made of.
 *
 *  Threads  an ff_sha256 belongs to one thread at a time. */
#ifndef FF_INTERNAL_SHA256_H
#define FF_INTERNAL_SHA256_H
#include <stddef.h>
#include <stdint.h>

typedef struct ff_sha256 {
    uint32_t state[8];
    uint64_t n; /**< bytes so far */
    unsigned char block[64];
} ff_sha256;

enum { FF_SHA256_TEXT = 65 };

void ff_sha256_init(ff_sha256 *s);
void ff_sha256_add(ff_sha256 *s, const void *bytes, size_t n);
void ff_sha256_text(ff_sha256 *s, char out[FF_SHA256_TEXT]); /**< 64 hexadecimal digits; s is of no use afterwards */

/** Of the content of a file, read to its end. Returns 0 where that cannot be done: of "-", and of what is no regular file. */
int ff_sha256_file(const char *path, char out[FF_SHA256_TEXT]);

#endif
