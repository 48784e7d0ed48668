/* The cube root of lightness (CIE 1976 L*) on radiance, odd and with a finite slope at 0:
 *
 *   c(t) = t (t^2 + e^2)^(-1/3), c'(t) = (t^2/3 + e^2) (t^2 + e^2)^(-4/3), e = 1e-8
 *
 * Fores et al. 2012 take the cube root of the squared difference instead. */
#include "internal_loss_block.h"
#include "base/internal_vector_math.h"
#include <math.h>

#define E2 1e-16

static void target(size_t n, const double *y, const double *x, double *g)
{
    for (size_t i = 0; i < n; i++) g[i] = y[i] * x[i] / cbrt(y[i] * x[i] * y[i] * x[i] + E2);
}

static void slope(size_t n, const double *y, const double *x, double *out)
{
    for (size_t i = 0; i < n; i++) {
        const double u = y[i] * x[i], s = u * u + E2;
        out[i] = x[i] * (u * u / 3 + E2) / (s * cbrt(s));
    }
}

static inline double cube_root(double t)
{
    return t * ff_rcbrt(t * t + E2);
}

static inline double cube_root_slope(double t)
{
    const double inv = ff_rcbrt(t * t + E2), inv2 = inv * inv;
    return (t * t * (1.0 / 3) + E2) * inv2 * inv2;
}

static void residuals(const ff_loss_planes *l, const double *restrict f, double *restrict r, double *restrict j)
{
    for (int i = 0; i < FF_BLOCK; i++) {
        const double u = l->x[i] * f[i];
        r[i] = l->w[i] * (cube_root(u) - l->t[i]);
        j[i] = l->w[i] * l->x[i] * cube_root_slope(u);
    }
}

static void deviations(const double *restrict f, const double *restrict y, const double *restrict x, double *restrict e)
{
    for (int i = 0; i < FF_BLOCK; i++) e[i] = cube_root(x[i] * f[i]) - cube_root(x[i] * y[i]);
}

const ff_loss_descriptor FF_ISA_NAME(ff_loss_cube_root) = {
    .info = {.name = "cube-root",
             .help = "cube roots of radiance, as lightness goes: peak, haze and diffuse part all count",
             .compares = "c(f x), c(t) = t (t^2 + 1e-16)^(-1/3)",
             .source = "the cube root of lightness (CIE 1976 L*) on radiance; the cube root itself has no slope at 0",
             .rmse_unit = "sr^-1/3"},
    .reads_cosine = 1,
    .target = target,
    .slope = slope,
    .residuals = residuals,
    .deviations = deviations};
