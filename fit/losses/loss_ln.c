/* Logarithms of reflectance itself: every decade counts alike, as in a plot with a logarithmic axis. Scattering of polished
 * surfaces spans eight of them and is fitted so (Stover 2012, chapter 4).
 *
 * A datum at or below 0 has no logarithm. A model at 0, as of a lobe without tails, has none either: below LEAST g goes on as its
 * tangent there, so that it is worse the darker it is, and finite. */
#include "internal_loss_block.h"
#include "base/internal_vector_math.h"
#include <math.h>

#define LEAST    1e-30 /* 1/sr; ln LEAST is below */
#define LN_LEAST (-69.07755278982137)

static void target(size_t n, const double *y, const double *x, double *g)
{
    (void)x;
    for (size_t i = 0; i < n; i++) g[i] = y[i] > LEAST ? log(y[i]) : LN_LEAST + y[i] / LEAST - 1;
}

static void slope(size_t n, const double *y, const double *x, double *out)
{
    (void)x;
    for (size_t i = 0; i < n; i++) out[i] = 1 / fmax(y[i], LEAST);
}

static int has_value(double y, double x)
{
    (void)x;
    return y > 0;
}

static void residuals(const ff_loss_planes *l, const double *restrict f, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = f[i] > LEAST ? f[i] : LEAST, inv = ff_recip(u);
        r[i] = l->w[i] * (ff_log(u) + (f[i] - u) * inv - l->t[i]);
        j[i] = l->w[i] * inv;
    }
}

const ff_loss_descriptor FF_ISA_NAME(ff_loss_ln) = {
    .info = {.name = "ln",
             .help = "logarithms of reflectance: every decade counts alike; values at or below 0 are left out",
             .compares = "ln f",
             .source = "Stover 2012"},
    .target = target,
    .slope = slope,
    .has_value = has_value,
    .residuals = residuals};
