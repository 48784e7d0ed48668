/* What the mutations share, and which of them an input gets. */
#include "mutate.h"
#include <string.h>

enum { SCRATCH = 1 << 16 };

size_t mutate_below(mutation *m, size_t n)
{
    m->random = m->random * 6364136223846793005u + 1442695040888963407u; /* Knuth's MMIX */
    return n ? (size_t)(m->random >> 33) % n : 0;
}

int mutate_replace(mutation *m, size_t at, size_t n, const void *with, size_t n_with)
{
    static uint8_t copy[SCRATCH];
    if (at > m->size || n > m->size - at || n_with > SCRATCH || m->size - n + n_with > m->most) return 0;
    if (n_with) memcpy(copy, with, n_with);
    memmove(m->data + at + n_with, m->data + at + n, m->size - at - n);
    if (n_with) memcpy(m->data + at, copy, n_with);
    m->size = m->size - n + n_with;
    return 1;
}

int mutate_swap(mutation *m, size_t a, size_t n_a, size_t b, size_t n_b)
{
    static uint8_t first[SCRATCH];
    if (a + n_a > b || b + n_b > m->size || n_a > SCRATCH) return 0;
    memcpy(first, m->data + a, n_a);
    return mutate_replace(m, a, n_a, m->data + b, n_b) && mutate_replace(m, b - n_a + n_b, n_b, first, n_a);
}

void mutate_same_size(mutation *m, size_t at, size_t n)
{
    if (n > 0 && at + n <= m->size) m->bytes(m->data + at, n, n);
}

const char *mutate_number(mutation *m)
{
    static const char *const numbers[] = {"0",
                                          "-0",
                                          "1",
                                          "-1",
                                          "1e999",
                                          "-1e999",
                                          "1e308",
                                          "1e-320",
                                          "nan",
                                          "inf",
                                          "-inf",
                                          "",
                                          "90",
                                          "180",
                                          "360",
                                          "89.999",
                                          "0x10",
                                          "1e",
                                          "+.",
                                          "1,5",
                                          "2.",
                                          ".5",
                                          "-90",
                                          "1e300",
                                          "1e-300",
                                          "4096",
                                          "65536",
                                          "2147483648",
                                          "4294967296",
                                          "18446744073709551616",
                                          "99999999999999999999999999999999"};
    return numbers[mutate_below(m, sizeof numbers / sizeof *numbers)];
}

uint64_t mutate_integer(mutation *m, uint64_t x)
{
    static const uint64_t limits[] = {0,     1,          2,          3,          255,         256,        65535,
                                      65536, 0x7fffffff, 0x80000000, 0xffffffff, 0x100000000, UINT64_MAX, UINT64_MAX / 2};
    switch (mutate_below(m, 5)) {
    case 0:
        return x + 1 + mutate_below(m, 8);
    case 1:
        return x - 1 - mutate_below(m, 8);
    case 2:
        return mutate_below(m, 2) ? x * 2 : x / 2;
    case 3:
        return mutate_below(m, 16);
    default:
        return limits[mutate_below(m, sizeof limits / sizeof *limits)];
    }
}

typedef int (*mutator)(mutation *m);

/* A picture of a stack begins with a zero byte (fuzz_reader.c). */
static mutator mutator_of(const char *target, const uint8_t *data, size_t size)
{
    static const char *const binary[] = {"merl", "utia", "mbsdf"};
    if (strcmp(target, "rgl") == 0) return mutate_tensors;
    if (strcmp(target, "exr") == 0) return mutate_exr;
    if (strcmp(target, "window") == 0) return mutate_xml;
    if (strcmp(target, "images") == 0 && size > 0 && data[0] == 0) return NULL;
    for (size_t k = 0; k < sizeof binary / sizeof *binary; k++)
        if (strcmp(target, binary[k]) == 0) return NULL;
    return mutate_text;
}

size_t mutate_structure(const char *target, uint8_t *data, size_t size, size_t most, unsigned seed, mutate_bytes bytes)
{
    mutation m = {data, size, most < SCRATCH ? most : SCRATCH, seed * 0x9E3779B97F4A7C15u + 1, bytes};
    mutator mutate = mutator_of(target, data, size);
    if (!mutate || size > m.most) return 0;
    int changed = 0;
    for (size_t times = 1 + mutate_below(&m, 3); times > 0; times--) changed |= mutate(&m);
    return changed ? m.size : 0;
}
