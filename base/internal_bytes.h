/** @file internal_bytes.h  Binary files: reading in order with errors that name the byte, and little-endian numbers on any machine.
 */
#ifndef FF_INTERNAL_BYTES_H
#define FF_INTERNAL_BYTES_H
#include "ff_status.h"
#include <stddef.h>
#include <string.h>

/** Reader of a binary file. */
typedef struct ff_bytes {
    const char *path; /**< the caller's string                         */
    ff_error *err;    /**< the caller's                                */
    int fd;
    int64_t size;   /**< -1 for pipes and devices                    */
    int64_t offset; /**< of the next byte                            */
} ff_bytes;

/** *b is written only on FF_OK; then ff_bytes_close must follow. */
ff_status ff_bytes_open(const char *path, ff_bytes *b, ff_error *err);
void ff_bytes_close(ff_bytes *b);

/** Reads exactly n bytes. FF_ERR_READ names the byte where the file ended and `what` was expected ("a header of 12 bytes"). */
ff_status ff_bytes_read(ff_bytes *b, void *out, size_t n, const char *what);

/** Before memory is asked for: FF_ERR_READ when the file is known to have fewer than n bytes more. n may be anything. */
ff_status ff_bytes_need(const ff_bytes *b, uint64_t n, const char *what);

/** FF_ERR_FORMAT when there are more bytes; `after` says after what ("the last plane"). */
ff_status ff_bytes_end(ff_bytes *b, const char *after);

/** The next `most` bytes of the file, or what is left of it, in memory that the caller frees: to be looked at before the rest. */
ff_status ff_bytes_head(ff_bytes *b, size_t most, unsigned char **data, size_t *n);

/** The whole rest of the file in memory of its size, which the caller frees, behind *data [*n]: what ff_bytes_head has handed out,
 *  or NULL and 0. On failure that is freed too, and NULL. FF_ERR_FORMAT when it is more than `most` bytes in all, FF_ERR_READ,
 *  FF_ERR_MEMORY. */
ff_status ff_bytes_rest(ff_bytes *b, size_t most, unsigned char **data, size_t *n);

static inline uint16_t ff_uint16_of(const unsigned char *b)
{
    return (uint16_t)(b[0] | b[1] << 8);
}

static inline uint32_t ff_uint32_of(const unsigned char *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static inline uint64_t ff_uint64_of(const unsigned char *b)
{
    return (uint64_t)ff_uint32_of(b) | (uint64_t)ff_uint32_of(b + 4) << 32;
}

static inline float ff_float_of(const unsigned char *b)
{
    const uint32_t u = ff_uint32_of(b);
    float v;
    memcpy(&v, &u, sizeof v);
    return v;
}

static inline double ff_double_of(const unsigned char *b)
{
    const uint64_t u = ff_uint64_of(b);
    double v;
    memcpy(&v, &u, sizeof v);
    return v;
}

static inline void ff_bytes_of_uint(uint64_t u, unsigned n, unsigned char *b)
{
    for (unsigned k = 0; k < n; k++) b[k] = (unsigned char)(u >> (8 * k));
}

static inline void ff_bytes_of_float(float v, unsigned char *b)
{
    uint32_t u;
    memcpy(&u, &v, sizeof u);
    ff_bytes_of_uint(u, 4, b);
}

static inline void ff_bytes_of_double(double v, unsigned char *b)
{
    uint64_t u;
    memcpy(&u, &v, sizeof u);
    ff_bytes_of_uint(u, 8, b);
}

/** Turns doubles as they lay in the file into doubles of this machine, in place; nothing on a little-endian one. */
static inline void ff_doubles_from_file(double *v, size_t n)
{
#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
    for (size_t i = 0; i < n; i++) v[i] = ff_double_of((const unsigned char *)(v + i));
#else
    (void)v, (void)n;
#endif
}

/** 1 when none of them is a NaN or an infinity. */
int ff_all_finite(const double *v, size_t n);
#endif
