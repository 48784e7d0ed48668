/* Differences of radiance: Ngan et al. 2005; Low et al. 2012, E1. */
#include "internal_loss_block.h"
#include <string.h>

static void cosine(size_t n, const double *x, double *factor)
{
    memcpy(factor, x, n * sizeof *factor);
}

static void deviations(const double *restrict f, const double *restrict y, const double *restrict x, double *restrict e)
{
    for (int i = 0; i < FF_BLOCK; i++) e[i] = (f[i] - y[i]) * x[i];
}

const ff_loss_descriptor FF_ISA_NAME(ff_loss_cosine) = {
    .info = {.name = "cosine",
             .help = "differences of radiance: bright values, as those of a peak, decide",
             .compares = "f x",
             .source = "Ngan et al. 2005; Low et al. 2012, E1",
             .rmse_unit = "1/sr"},
    .factor = cosine,
    .deviations = deviations};
