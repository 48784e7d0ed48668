/** @file internal_neighbours.h  The nearest of many points in a few dimensions (k-d tree). Immutable once made. */
#ifndef FF_INTERNAL_NEIGHBOURS_H
#define FF_INTERNAL_NEIGHBOURS_H
#include <stddef.h>
#include <stdint.h>

typedef struct ff_neighbours ff_neighbours;

/** A place with at least one sample. */
typedef struct ff_neighbour {
    double distance2;
    const double *point;    /**< [dim]                             */
    const uint32_t *sample; /**< [n_samples] the caller's numbers  */
    size_t n_samples;
} ff_neighbour;

/** Takes over point [n][dim] and sample [n] (malloc'ed), also on failure; NULL without memory. dim is 2 to 4, n >= 1. Points that
 * are the same to FF_NEIGHBOURS_SAME in every coordinate become one place. */
#define FF_NEIGHBOURS_SAME 1e-7
ff_neighbours *ff_neighbours_new(int dim, size_t n, double *point, uint32_t *sample);
void ff_neighbours_free(ff_neighbours *tree);

/** The k nearest places of x [dim] that have another sample than `without` (UINT32_MAX: all), nearest first; their number, less
 * than k where there are no more. k <= FF_NEIGHBOURS_MOST. */
enum { FF_NEIGHBOURS_MOST = 32 };
size_t ff_neighbours_find(const ff_neighbours *tree, const double *x, size_t k, uint32_t without, ff_neighbour *out);
#endif
