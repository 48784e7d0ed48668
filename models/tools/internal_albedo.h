/* Directional albedos of a model with their derivatives, for fits that conserve energy. */
#ifndef FF_INTERNAL_ALBEDO_H
#define FF_INTERNAL_ALBEDO_H
#include "models/internal_model.h"

enum { FF_ALBEDO_COLUMNS = FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS };

/* A model made ready to be integrated over its lobes and bases, from any view. */
typedef struct ff_albedo_parts ff_albedo_parts;

/* mode, wanted: as ff_prepare, for columns of the whole model; n_shape = n_channel = 0: values alone. m, shape and channel
 * [n_channels][m->n_channel] must outlive it. FF_ERR_MEMORY. */
ff_status ff_albedo_parts_make(const ff_model *m, const ff_kernels *kernels, ff_stretch_mode mode, size_t n_channels,
                               const double *shape, const double *channel, const ff_wanted *wanted, ff_albedo_parts **out);
void ff_albedo_parts_free(ff_albedo_parts *a);

/* The albedo seen from wo (a unit vector above the horizon) by the quadrature of ff_albedo_directional with one Gauss-Legendre
 * order (8: errors below 1e-6 for most parameters), the nodes being those of these parameters. out [n_channels][1 + columns]: the
 * albedo, its derivative by each wanted column. May be called from many threads, each with a work of its own. */
void ff_albedo_parts_at(const ff_albedo_parts *a, int order, const double wo[3], ff_block_work *work, double *out);

#endif
