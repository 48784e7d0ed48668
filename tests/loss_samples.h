/** @file loss_samples.h  The losses a second time, by the C library, as docs/fitting-reference.md states them: what tests compare
 * the program with. Of a loss that is not written out here they take its descriptor's word, whose parts loss_registry_test.c holds
 *  against each other. */
#ifndef LOSS_SAMPLES_H
#define LOSS_SAMPLES_H
#include "fit/losses/internal_loss.h"
#include "fit/losses/robust/internal_robust.h"
#include "models/internal_model.h"
#include <math.h>
#include <stdlib.h>

/** The odd cube root with a finite slope at 0. */
static inline double loss_cube_root(double t)
{
    return t / cbrt(t * t + 1e-16);
}

/** g(f) at x = cos(theta_i). */
static inline double loss_g(ff_loss loss, double f, double x)
{
    double g;
    if (loss == FF_LOSS_COSINE || loss == FF_LOSS_RELATIVE || loss == FF_LOSS_PLAIN) return f;
    if (loss == FF_LOSS_LOG) return log1p(f * x);
    if (loss == FF_LOSS_CUBE_ROOT) return loss_cube_root(f * x);
    ff_loss_targets(loss, 1, &f, &x, &g);
    return g;
}

/** dg/df. */
static inline double loss_slope(ff_loss loss, double f, double x)
{
    const double u = f * x, s = u * u + 1e-16;
    double slope;
    if (loss == FF_LOSS_COSINE || loss == FF_LOSS_RELATIVE || loss == FF_LOSS_PLAIN) return 1;
    if (loss == FF_LOSS_LOG) return x / (1 + u);
    if (loss == FF_LOSS_CUBE_ROOT) return x * (u * u / 3 + 1e-16) / (s * cbrt(s));
    ff_loss_slopes(loss, 1, &f, &x, &slope);
    return slope;
}

static inline int loss_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/** What a datum counts as at least where a loss divides by it: of a channel y [n]. */
static inline double loss_least(const double *y, size_t n)
{
    double mean = 0, *v = (double *)malloc((n + 1) * sizeof *v), least;
    size_t count = 0;
    if (!v) exit(1);
    for (size_t i = 0; i < n; i++) {
        mean += fabs(y[i]) / (double)n;
        if (y[i] != 0) v[count++] = fabs(y[i]);
    }
    qsort(v, count, sizeof *v, loss_ascending);
    least = count ? fmin(0.001 * mean, v[count / 20]) : 0;
    free(v);
    return least;
}

/** What multiplies g(f) - g(y). least: of the channel. */
static inline double loss_factor(ff_loss loss, double y, double x, double least)
{
    double factor;
    if (loss == FF_LOSS_COSINE) return x;
    if (loss == FF_LOSS_RELATIVE) return 1 / fmax(fmax(y, least), 1e-12);
    if (loss == FF_LOSS_LOG || loss == FF_LOSS_CUBE_ROOT || loss == FF_LOSS_PLAIN) return 1;
    ff_loss_factors(loss, 1, &y, &x, least, &factor);
    return factor;
}

/** rho(s) at the scale b. */
static inline double loss_rho(ff_robust robust, double s, double b)
{
    const double b2 = b * b, v = 1 - s / b2;
    if (robust == FF_ROBUST_NONE) return s;
    if (robust == FF_ROBUST_HUBER) return s > b2 ? 2 * b * sqrt(s) - b2 : s;
    if (robust == FF_ROBUST_CAUCHY) return b2 * log1p(s / b2);
    if (robust == FF_ROBUST_TUKEY) return s > b2 ? b2 / 3 : b2 / 3 * (1 - v * v * v);
    return ff_robust_rho(robust, b, sqrt(s));
}

/** rho'(s). */
static inline double loss_rho_slope(ff_robust robust, double s, double b)
{
    const double b2 = b * b, v = 1 - s / b2;
    double r[FF_BLOCK], rho[FF_BLOCK], slope[FF_BLOCK];
    if (robust == FF_ROBUST_NONE) return 1;
    if (robust == FF_ROBUST_HUBER) return s > b2 ? b / sqrt(s) : 1;
    if (robust == FF_ROBUST_CAUCHY) return 1 / (1 + s / b2);
    if (robust == FF_ROBUST_TUKEY) return s > b2 ? 0 : v * v;
    for (int i = 0; i < FF_BLOCK; i++) r[i] = sqrt(s);
    ff_robust_of(FF_ISA_SCALAR, robust)->block(b, r, rho, slope);
    return slope[0];
}

#endif
