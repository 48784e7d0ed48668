/* The composition's kernels of the instruction set this file is compiled for; see ff_kernels. */
#ifndef FF_INTERNAL_COMPOSE_H
#define FF_INTERNAL_COMPOSE_H
#include "internal_kernel.h"

#define ff_compose_shape   FF_ISA_NAME(ff_compose_shape)
#define ff_compose_value   FF_ISA_NAME(ff_compose_value)
#define ff_compose_columns FF_ISA_NAME(ff_compose_columns)
#define ff_albedo_add      FF_ISA_NAME(ff_albedo_add)
#define ff_albedo_place_of FF_ISA_NAME(ff_albedo_place_of)
#define ff_albedo_values   FF_ISA_NAME(ff_albedo_values)
#define ff_albedo_at       FF_ISA_NAME(ff_albedo_at)

void ff_compose_shape(const ff_prepared *p, const ff_geometry *g, size_t n, ff_block *b);
void ff_compose_value(const ff_prepared *p, const ff_geometry *g, size_t n, size_t c, ff_block *b, double *restrict f);
void ff_compose_columns(const ff_prepared *p, size_t n, size_t c, const double *restrict j, ff_block *b,
                        double (*restrict df)[FF_BLOCK]);
void ff_albedo_add(const ff_prepared *p, double mu, const ff_albedo_points *points, uint32_t at, ff_block_work *work);
/* A function of a curve at cosines, in two steps: what all functions share, and the values. */
void ff_albedo_place_of(size_t n, const double *restrict mu, ff_albedo_place *place);
void ff_albedo_values(const ff_albedo_curve *curve, uint32_t function, size_t n, const ff_albedo_place *place,
                      double *restrict out);
void ff_albedo_at(const ff_albedo_curve *curve, uint32_t function, size_t n, const double *restrict mu, double *restrict out);
#endif
