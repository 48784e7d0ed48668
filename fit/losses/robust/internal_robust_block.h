/* Robust losses for files that are compiled once per instruction set. */
#ifndef FF_INTERNAL_ROBUST_BLOCK_H
#define FF_INTERNAL_ROBUST_BLOCK_H
#include "internal_robust.h"
#include "models/internal_model.h"

#define FF_ROBUST_ENTRY(NAME, id) extern const ff_robust_descriptor FF_ISA_NAME(ff_robust_##id);
#include "ff_robusts.def"
extern const ff_robust_descriptor *const FF_ISA_NAME(ff_robusts)[FF_ROBUST_COUNT];

#endif
