/* Mutations that know what a file is made of: they leave a file that is nearly one, where bytes changed at random are refused by
 * the first check. They stand beside libFuzzer's own (fuzz_main.c), which do the rest. */
#ifndef FF_FUZZ_MUTATE_H
#define FF_FUZZ_MUTATE_H
#include <stddef.h>
#include <stdint.h>

/** libFuzzer's own: changes data [size] in place, at most to `most` bytes; the new size. */
typedef size_t (*mutate_bytes)(uint8_t *data, size_t size, size_t most);

/** What a mutation works with. */
typedef struct mutation {
    uint8_t *data;
    size_t size, most; /* most: room in data */
    uint64_t random;
    mutate_bytes bytes;
} mutation;

/** Changes data [size] as an input for `target`; the new size, 0 where it has nothing of the structure. */
size_t mutate_structure(const char *target, uint8_t *data, size_t size, size_t most, unsigned seed, mutate_bytes bytes);

/* ---- what they share (mutate.c) --------------------------------------------------------------- */

/** 0 .. n-1; 0 for n = 0. */
size_t mutate_below(mutation *m, size_t n);
/** Replaces n bytes at `at` by those of `with` [n_with], which may lie in data. 0 where there is no room; nothing is changed then.
 */
int mutate_replace(mutation *m, size_t at, size_t n, const void *with, size_t n_with);
/** Changes the places of two ranges that do not overlap, a before b. */
int mutate_swap(mutation *m, size_t a, size_t n_a, size_t b, size_t n_b);
/** n bytes at `at`, by libFuzzer, their number kept. */
void mutate_same_size(mutation *m, size_t at, size_t n);
/** A text that a number may be replaced by. */
const char *mutate_number(mutation *m);
/** A whole number near x, at a limit, or any. */
uint64_t mutate_integer(mutation *m, uint64_t x);

/* ---- one for each structure: 1 when something was changed -------------------------------------- */

int mutate_tensors(mutation *m);
int mutate_exr(mutation *m);
int mutate_xml(mutation *m);
int mutate_text(mutation *m);
#endif
