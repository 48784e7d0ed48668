/** @file compressed_point.h  What the compressed problem says at one point; in C because the inside of fit/ is. */
#ifndef COMPRESSED_POINT_H
#define COMPRESSED_POINT_H
#include "fit/interface/fit_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Objective, gradient [P] and J^T J [P][P] by the parameters themselves, for the shape correlated: P = n_shape_free + n_channels
 *  n_channel of m, the free shape parameters first.
 *  @param shape    [m->n_shape]
 *  @param channel  [n_channels][m->n_channel] */
ff_status compressed_point(const ff_problem *p, const ff_model *m, const ff_fit_options *o, size_t n_channels, const double *shape,
                           const double *channel, double *cost, double *gradient, double *gram);

#ifdef __cplusplus
}
#endif
#endif
