/* Differences in parts of the datum: least squares of percentages, Tofallis 2008. */
#include "internal_loss_block.h"
#include <math.h>

#define FLOOR 1e-3 /* of the mean |y|: what a datum counts as at least */

static void inverse(size_t n, const double *y, const double *x, double mean, double *factor)
{
    const double floor = mean > 0 ? FLOOR * mean : 1;
    (void)x;
    for (size_t i = 0; i < n; i++) factor[i] = 1 / fmax(y[i], floor);
}

const ff_loss_descriptor FF_ISA_NAME(ff_loss_relative) = {
    .info = {.name = "relative",
             .help = "differences in percent of the datum: dark values decide, with their noise",
             .compares = "f / max(y, 0.001 mean |y| of the channel)",
             .source = "least squares of percentages (Tofallis 2008)"},
    .factor_of_datum = inverse};
