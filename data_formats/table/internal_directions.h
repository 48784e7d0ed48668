/* Unit vectors of n pairs of angles theta_i phi_i theta_o phi_o (times unit: radians) into six planes [n]; one copy per instruction
 * set. */
#ifndef FF_INTERNAL_DIRECTIONS_H
#define FF_INTERNAL_DIRECTIONS_H
#include "base/internal_isa.h"
#include <stddef.h>

typedef void ff_directions_fn(double unit, const double *const angle[4], size_t n, double *const planes[6]);
ff_directions_fn ff_directions_scalar;
#ifdef FF_HAVE_AVX2
ff_directions_fn ff_directions_avx2;
#endif
#ifdef FF_HAVE_AVX512
ff_directions_fn ff_directions_avx512;
#endif
#ifdef FF_ISA_SUFFIX
ff_directions_fn FF_ISA_NAME(ff_directions);
#endif

#endif
