/* The ways in which models are compared: by what each adds to its own objective (versus.c), and by common weights
 * (common_weights.c). */
#ifndef FF_INTERNAL_VERSUS_H
#define FF_INTERNAL_VERSUS_H
#include "internal_trust.h"

#define FF_VERSUS_LEVEL 0.05

/* Do all fits know the noise of their data? */
int ff_versus_has_noise(const ff_fit_result *fits, size_t n);

/* z, p, told_apart, the criteria against fits[winner] and what belongs to them of n fits of p that know their noise. FF_ERR_MEMORY,
 * FF_ERR_CANCELLED. */
ff_status ff_versus_by_common_weights(const ff_problem *p, const ff_places *places, const ff_fit_options *o,
                                      const ff_fit_result *fits, size_t n, size_t winner, ff_versus *out, ff_error *err);
#endif
