/* Where a minimisation starts. Nothing is random: the same data give the same start. */
#ifndef FF_INTERNAL_START_H
#define FF_INTERNAL_START_H
#include "fit/minimise/internal_minimise.h"

/* A candidate for the optimum. */
typedef struct ff_candidate {
    double cost2;
    double shape[FF_MAX_SHAPE];
} ff_candidate;

/* Bounded least squares for all channels of a layout of channel parameters alone of which some are tied: from the parameters `at`
 * [n_channels] [n_channel], where tied ones are equal, to the minimum out (may be at) of the quadratic that the grams are of.
 * Returns it; INFINITY and out = at without memory. */
double ff_tied_least_squares(const ff_layout *l, const ff_normal *normal, const double *at, double *out);

/* A model that is linear in its channel parameters and has the lobes of l's: its start leads to that of l's (ff_surrogate_start).
 * For a layout that is linear itself that is the layout. f0_in_common: F0 of lobes that share a Fresnel term whose scale is free
 * (ff_surrogate_has_f0_in_common); unused otherwise. FF_ERR_INTERNAL cannot happen for models that parsed. */
typedef struct ff_surrogate {
    ff_model model;
    ff_plan plan;
    ff_limits *limits; /* of its model, NULL = none */
} ff_surrogate;
ff_status ff_surrogate_make(const ff_plan *plan, double f0_in_common, ff_surrogate *out);
int ff_surrogate_has_f0_in_common(const ff_layout *l);
void ff_surrogate_free(ff_surrogate *s);

/* From an optimum of the surrogate: shape, channel of l's model. There are ff_surrogate_variants ways where it does not say enough.
 */
uint32_t ff_surrogate_variants(const ff_layout *l);
void ff_surrogate_start(const ff_layout *l, const ff_surrogate *s, uint32_t variant, const double *from_shape,
                        const double *from_channel, double *shape, double *channel);

/* Data far from grazing incidence determine F0 of a conductor, and leave a valley of (eta, k) that ends at k = 0 on either side,
 * where the slope by k vanishes. Puts channel c of a lobe at the end with the higher or the lower eta; 0 when it has no such term.
 */
int ff_surrogate_end_of_valley(const ff_layout *l, uint32_t lobe, size_t c, int high, double *channel);

/* Shape parameters that the search goes through point by point. */
uint32_t ff_start_searched(const ff_layout *l);

/* The best starting points of a linear layout on the subsample of the plan, best first, at most max; channel parameters by
 * ff_start_channels. */
ff_status ff_start_search(const ff_plan *plan, ff_candidate *out, size_t max, size_t *n_out);

/* Other places for one lobe of a linear layout, the others staying where they are in the shape `from`: best first, at most
 * FF_MOVES, the best of the narrowest among them. */
enum { FF_MOVES = 4 };
ff_status ff_start_moves(const ff_plan *plan, const double *from, uint32_t lobe, ff_candidate *out, size_t *n_out);

/* One lobe after the other on a grid of its own, from lobe `first` on, the later ones not there yet: best first, at most
 * FF_SEQUENCES. */
enum { FF_SEQUENCES = 4 };
ff_status ff_start_sequence(const ff_plan *plan, uint32_t first, ff_candidate *out, size_t *n_out);

/* The free channel parameters that minimise the subsample of the plan for a shape: exact where the residual is linear in them,
 * else by Gauss-Newton steps, from the linear surrogate of the loss or, in a layout that is not linear, from channel as it comes.
 * channel [n_channels][n_channel] in and out. On the calling thread. */
ff_status ff_start_channels(const ff_plan *plan, const double *shape, double *channel, double *cost2);

/* The stage before the minimisation: the point given or searched for on the subsample, and most of the way to the optimum, which
 * is gone on fewer samples. FF_ERR_CANCELLED, FF_ERR_MEMORY. */
ff_status ff_start(const ff_plan *plan, ff_point *at, ff_error *err);
/* ---- through an aperture ----------------------------------------------------------------------- */

/* From a point that was found as if samples were points, where an aperture may have widened the lobes, to the best that lobes of
 * fewer widths lead to on the subsample. FF_ERR_MEMORY, FF_ERR_CANCELLED. */
ff_status ff_start_through(const ff_plan *plan, ff_point *at, ff_error *err);
#endif
