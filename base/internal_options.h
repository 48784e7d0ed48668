/* Structs of options that may be shorter or longer than those of this library: their first member is `size`, the caller's sizeof. A
 * program that was compiled with an older header has fewer members, which mean what they did; members are only ever added at the
 * end. */
#ifndef FF_INTERNAL_OPTIONS_H
#define FF_INTERNAL_OPTIONS_H
#include "ff_status.h"
#include <stddef.h>

/* pi/2, and a rounding more: what programs make of 90 degrees. Limits of polar angles are in (0, FF_HORIZON]. */
#define FF_HORIZON 1.5707963267948968

/* The end of a member: sizeof the struct when it was the last one. */
#define FF_END_OF(type, member) (offsetof(type, member) + sizeof(((type *)0)->member))

/* Writes defaults, or a result, of `known` bytes into the caller's struct of `size` bytes, and nothing beyond it. Of a longer
 * struct the rest is 0. */
void ff_options_init(void *to, size_t size, const void *defaults, size_t known);

/* Copies the caller's options `from` over *out [known], which has the defaults. FF_ERR_RANGE, naming the type, when they are
 * shorter than `first`, those of the first version, or longer than `known` with something set that this library does not know. */
ff_status ff_options_take(const char *type, const void *from, size_t first, void *out, size_t known, ff_error *err);

/* Has the caller's struct for a result a size, at least that of the first version? FF_ERR_RANGE. */
ff_status ff_record_check(const char *type, const void *record, size_t first, ff_error *err);
#endif
