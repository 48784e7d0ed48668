/* Logarithms of radiance and 1: Low et al. 2012, E2. */
#include "internal_loss_block.h"
#include "base/internal_vector_math.h"
#include <math.h>

static void target(size_t n, const double *y, const double *x, double *g)
{
    for (size_t i = 0; i < n; i++) g[i] = log1p(y[i] * x[i]);
}

static void slope(size_t n, const double *y, const double *x, double *out)
{
    for (size_t i = 0; i < n; i++) out[i] = x[i] / (1 + y[i] * x[i]);
}

/* The logarithm needs 1 + y x > 0. */
static int has_value(double y, double x)
{
    return y * x > -0.999;
}

static void residuals(const ff_loss_planes *l, const double *restrict f, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = l->x[i] * f[i];
        r[i] = l->w[i] * (ff_log1p(u) - l->t[i]);
        j[i] = l->w[i] * l->x[i] * ff_recip(1 + u);
    }
}

/* A datum below -1/cos, which other losses can use, counts as there. */
static void deviations(const double *restrict f, const double *restrict y, const double *restrict x, double *restrict e)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double low = -0.999999, ly = x[i] * y[i] > low ? x[i] * y[i] : low;
        e[i] = ff_log((1 + x[i] * f[i]) * ff_recip(1 + ly));
    }
}

const ff_loss_descriptor FF_ISA_NAME(ff_loss_log) = {.info = {.name = "log",
                                                              .help = "logarithms of 1 + radiance: a peak counts for less",
                                                              .compares = "ln(1 + f x)",
                                                              .source = "Low et al. 2012, E2",
                                                              .rmse_unit = "1"},
                                                     .reads_cosine = 1,
                                                     .target = target,
                                                     .slope = slope,
                                                     .has_value = has_value,
                                                     .residuals = residuals,
                                                     .deviations = deviations};
