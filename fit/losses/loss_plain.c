/* Differences of the reflectance itself. Its root mean square is reported of every fit anyhow (ff_residual.rmse). */
#include "internal_loss_block.h"

const ff_loss_descriptor FF_ISA_NAME(ff_loss_plain) = {
    .info = {.name = "plain", .help = "differences of the reflectance itself, without the cosine", .compares = "f", .source = ""}};
