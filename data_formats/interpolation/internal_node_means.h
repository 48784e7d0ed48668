/** @file internal_node_means.h  Values that are constant over cells, averaged over what each sample of another table stands for.
 *
 *  A reader of the other table interpolates: between the nodes of axes linearly, in an RGL file bilinearly along its own warp, and
 *  the MERL grid says itself what its cells are. So a sample's value is the mean with the weight that the reader gives it around
 *  it, times the cosine of the exit: then the integral over the hemisphere is that of the cells. Directions of incidence stand for
 *  themselves (on a border between cells for both sides), as far as the other table tells them apart. */
#ifndef FF_INTERNAL_NODE_MEANS_H
#define FF_INTERNAL_NODE_MEANS_H
#include "data_formats/table/table_struct.h"

typedef struct ff_node_means ff_node_means;

/** @param from  a table with cells; both must outlive it
 *  NULL: no memory. Immutable: any number of threads may ask. */
ff_node_means *ff_node_means_new(const ff_table *from, const ff_table *to);
void ff_node_means_free(ff_node_means *m);

/** 1 when samples of `to` stand for more than their directions. */
int ff_node_means_is_wide(const ff_node_means *m);

/** Channels of the sample i of `to` into value[c * stride], 1/sr; its directions w are above the horizon. 0 where nothing is known
 *  around it. */
int ff_node_means_at(const ff_node_means *m, size_t i, const double wi[3], const double wo[3], double *value, size_t stride);
#endif
