/** @file internal_neighbours.h  The nearest of many points in three or four dimensions (k-d tree). Immutable once made. */
#ifndef FF_INTERNAL_NEIGHBOURS_H
#define FF_INTERNAL_NEIGHBOURS_H
#include <stddef.h>
#include <stdint.h>

typedef struct ff_neighbours ff_neighbours;

typedef struct ff_neighbour {
    double distance2;
    const double *point; /**< [dim]                        */
    uint32_t sample;     /**< the caller's number of it    */
} ff_neighbour;

/** Takes over point [n][dim] and sample [n] (malloc'ed), also on failure; NULL without memory. dim is 3 or 4, n >= 1. */
ff_neighbours *ff_neighbours_new(int dim, size_t n, double *point, uint32_t *sample);
void ff_neighbours_free(ff_neighbours *tree);

/** The k nearest points of x [dim] whose sample is not `without` (UINT32_MAX: all), nearest first; their number, less than k where
 *  there are no more. Points at the same distance come in no particular order, but always in the same. k <= FF_NEIGHBOURS_MOST. */
enum { FF_NEIGHBOURS_MOST = 32 };
size_t ff_neighbours_find(const ff_neighbours *tree, const double *x, size_t k, uint32_t without, ff_neighbour *out);
#endif
