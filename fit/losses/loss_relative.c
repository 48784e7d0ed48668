/* Differences in parts of the datum: least squares of percentages, Tofallis 2008. */
#include "internal_loss_block.h"
#include <math.h>

static void inverse(size_t n, const double *y, const double *x, double least, double *factor)
{
    const double floor = least > 0 ? least : 1;
    (void)x;
    for (size_t i = 0; i < n; i++) factor[i] = 1 / fmax(y[i], floor);
}

const ff_loss_descriptor FF_ISA_NAME(ff_loss_relative) = {
    .info = {.name = "relative",
             .help = "differences in percent of the datum: dark values decide, with their noise",
             .compares = "f / max(y, least), least the smaller of 0.001 mean |y| and the 5 % quantile of |y| > 0, of the channel",
             .source = "least squares of percentages (Tofallis 2008)"},
    .factor_of_datum = inverse};
