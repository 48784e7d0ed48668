/* The losses of ff_losses.def by number. Compiled once per instruction set. */
#include "internal_loss_block.h"

const ff_loss_descriptor *const FF_ISA_NAME(ff_losses)[FF_LOSS_COUNT] = {
#define FF_LOSS_ENTRY(NAME, id) &FF_ISA_NAME(ff_loss_##id),
#include "ff_losses.def"
};
