/* The losses as the fit uses them: a constant descriptor each, which nothing outside fit/losses/ knows more of.
 *
 * A new loss is one file loss_<id>.c with its descriptor and one line in ff_losses.def. Everything follows from these: fits, ndf,
 * --loss auto, the measures of a finished fit, help, JSON and the tests, which also say which row the table of
 * docs/fitting-reference.md lacks. The files are compiled once per instruction set. What is seldom computed (targets, slopes,
 * factors) is always that of the baseline, so that the data of a fit do not depend on the processor.
 *
 * f model, y datum, x = cos(theta_i); planes may have any length n where it is given and else have FF_BLOCK entries. */
#ifndef FF_INTERNAL_LOSS_H
#define FF_INTERNAL_LOSS_H
#include "ff_loss.h"
#include "base/internal_isa.h"
#include <stddef.h>

/* What a loss reads over a block: w, what multiplies g(f) - g(y); t = g(y); x, NULL unless the loss reads it. */
typedef struct ff_loss_planes {
    const double *restrict w, *restrict t, *restrict x;
} ff_loss_planes;

typedef struct ff_loss_descriptor {
    ff_loss_info info;

    /* What multiplies g(f) - g(y) for a sample of unit weight, [n]; at most one of them, none: 1. least: what a datum of the
     * channel counts as at least, 1/sr; 0 of a channel that is dark. With weights by standard deviations it says nothing: a
     * residual is then in its standard deviations. */
    void (*factor)(size_t n, const double *x, double *factor);
    void (*factor_of_datum)(size_t n, const double *y, const double *x, double least, double *factor);

    /* Linear losses, g(f) = f, have none of what follows; curved ones have target, slope and residuals. */

    int reads_cosine;                                                                  /* x is not given otherwise */
    void (*target)(size_t n, const double *y, const double *x, double *g);             /* g(y)                     */
    void (*slope)(size_t n, const double *y, const double *x, double *slope);          /* dg/df at f = y           */
    int (*has_value)(double y, double x);                                              /* NULL: g(y) always exists */
    void (*residuals)(const ff_loss_planes *l, const double *f, double *r, double *j); /* w (g(f) - t), dr/df      */

    /* g(f) - g(y) times the factor, as a measure of every fit; with info.rmse_unit, else NULL. Linear ones may have it too. x is
     * always given; y may be where g has no value. */
    void (*deviations)(const double *f, const double *y, const double *x, double *e);
} ff_loss_descriptor;

/* As compiled for an instruction set; NULL when it is not available. loss must be valid. */
const ff_loss_descriptor *ff_loss_of(ff_isa isa, ff_loss loss);

/* ---- of the baseline ------------------------------------------------------------------------- */

/* Is g(f) not f? */
int ff_loss_is_curved(ff_loss loss);
int ff_loss_reads_cosine(ff_loss loss);
/* Does every channel need weights of its own, since they depend on its data? */
int ff_loss_weighs_data(ff_loss loss);
int ff_loss_has_value(ff_loss loss, double y, double x);

/* g(y), dg/df at f = y, and the factor, [n]. x may be NULL where the loss does not read it; the factor has x. */
void ff_loss_targets(ff_loss loss, size_t n, const double *y, const double *x, double *g);
void ff_loss_slopes(ff_loss loss, size_t n, const double *y, const double *x, double *slope);
void ff_loss_factors(ff_loss loss, size_t n, const double *y, const double *x, double least, double *factor);

#endif
