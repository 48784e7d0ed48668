/* Samples that are copies of others: the same directions and the same values, to the last bit.
 *
 * A file that was joined from overlapping ones, or written twice over, has them. A copy is no measurement: with it errors would
 * shrink for nothing. Where the samples of a direction differ they are measurements repeated, and all of them count. */
#include "internal_problem.h"
#include <stdlib.h>
#include <string.h>

/* Samples by their directions, in an open hash table: slot [size] has a place in index + 1, 0 = free. */
typedef struct finder {
    const ff_table *t;
    const uint32_t *index;
    uint32_t *slot;
    size_t size;           /* a power of two */
    unsigned char *differ; /* [n] of the first sample of a direction: another one has other values */
} finder;

static uint64_t hash_of(const ff_table *t, size_t i)
{
    uint64_t h = 0x9e3779b97f4a7c15u, bits;
    for (int k = 0; k < 4; k++) {
        memcpy(&bits, &t->angle[k][i], sizeof bits);
        h = (h ^ bits) * 0xd6e8feb86659fd93u;
        h ^= h >> 32;
    }
    return h;
}

static int same_directions(const ff_table *t, size_t a, size_t b)
{
    for (int k = 0; k < 4; k++)
        if (t->angle[k][a] != t->angle[k][b]) return 0;
    return 1;
}

static int same_values(const ff_table *t, size_t a, size_t b)
{
    for (size_t c = 0; c < t->n_channels; c++)
        if (t->value[c * t->n + a] != t->value[c * t->n + b]) return 0;
    return 1;
}

/* The first sample with the directions of the i-th, which is itself where there is none yet. */
static uint32_t first_like(finder *f, uint32_t i)
{
    size_t at = (size_t)hash_of(f->t, f->index[i]) & (f->size - 1);
    while (f->slot[at] && !same_directions(f->t, f->index[f->slot[at] - 1], f->index[i])) at = (at + 1) & (f->size - 1);
    if (!f->slot[at]) f->slot[at] = i + 1;
    return f->slot[at] - 1;
}

/* first [n]: of each sample. */
static void find(finder *f, size_t n, uint32_t *first)
{
    for (size_t i = 0; i < n; i++) {
        first[i] = first_like(f, (uint32_t)i);
        if (first[i] != i && !same_values(f->t, f->index[first[i]], f->index[i])) f->differ[first[i]] = 1;
    }
}

ff_status ff_copies_leave_out(const ff_table *t, uint32_t *index, size_t *n, size_t *copies)
{
    finder f = {.t = t, .index = index, .size = 2};
    *copies = 0;
    if (t->grid || t->axes.kind != FF_AXES_NONE || t->weight) return FF_OK; /* every place is there once, or has its weight */
    while (f.size < 2 * *n) f.size *= 2;
    f.slot = calloc(f.size, sizeof *f.slot);
    f.differ = calloc(*n + 1, 1);
    uint32_t *first = malloc((*n + 1) * sizeof *first);
    const ff_status status = f.slot && f.differ && first ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        size_t kept = 0;
        find(&f, *n, first);
        for (size_t i = 0; i < *n; i++)
            if (first[i] == i || f.differ[first[i]]) index[kept++] = index[i];
        *copies = *n - kept;
        *n = kept;
    }
    free(f.slot);
    free(f.differ);
    free(first);
    return status;
}
