/* The robust losses of ff_robusts.def by number. Compiled once per instruction set. */
#include "internal_robust_block.h"

const ff_robust_descriptor *const FF_ISA_NAME(ff_robusts)[FF_ROBUST_COUNT] = {
#define FF_ROBUST_ENTRY(NAME, id) &FF_ISA_NAME(ff_robust_##id),
#include "ff_robusts.def"
};
