/* What the parts of ff_trust.h share: a fit taken up again where it ended. */
#ifndef FF_INTERNAL_TRUST_H
#define FF_INTERNAL_TRUST_H
#include "trust_struct.h"
#include "fit/errors/internal_errors.h"
#include "fit/minimise/internal_minimise.h"

/* The plan of a finished fit, whose model it has a copy of, and the point where it ended. */
typedef struct ff_finished {
    ff_plan plan;
    ff_point at;
} ff_finished;

/* FF_ERR_RANGE for a fit of other channels than those of p, and for a robust loss whose scale is not known; FF_ERR_MEMORY. out must
 * stay where it is; release with ff_finished_close. */
ff_status ff_finished_open(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_finished *out,
                           ff_error *err);
/* The same for refits, which know the samples alone: FF_ERR_UNSUPPORTED where priors or conserved energy moved the fit; `what` says
 * who asks. */
ff_status ff_finished_open_data(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, const char *what,
                                ff_finished *out, ff_error *err);
void ff_finished_close(ff_finished *f);

/* For every thread of the pool of p a problem with multipliers of its own. */
typedef struct ff_resampled {
    struct ff_problem *problem; /* [threads]: copies of p that share everything but their multipliers */
    float *multiplier;          /* [threads][n_blocks FF_BLOCK]                                         */
    size_t threads;
} ff_resampled;
ff_status ff_resampled_new(const struct ff_problem *p, ff_resampled *out);
void ff_resampled_free(ff_resampled *r);

/* The same directions with values drawn anew about a fit by the noise of its data: copies of its problem with planes of their own.
 */
typedef struct ff_redrawn {
    struct ff_problem *problem; /* [copies] */
    size_t copies;              /* as many as threads, fewer of large problems */
    double *model;              /* [n_channels][n] of the fit, 1/sr */
    float *deviation;           /* [n_channels][n_blocks FF_BLOCK] 1/sr */
} ff_redrawn;
/* Of a fit that has found noise. FF_ERR_MEMORY. */
ff_status ff_redrawn_new(const ff_finished *f, ff_redrawn *out);
void ff_redrawn_free(ff_redrawn *r);
/* Values of a copy for one repeat, the same whichever copy it is; those that the loss has no value for are drawn again. */
void ff_redrawn_draw(const ff_redrawn *r, size_t copy, uint64_t seed, uint64_t repeat);

/* SplitMix64 (Steele, Lea and Flood 2014) of a counter; in (0, 1). */
double ff_trust_uniform(uint64_t seed, uint64_t repeat, uint64_t draw);

/* The coordinate of a parameter; l->P where it has none of its own. */
size_t ff_trust_coordinate(const ff_layout *l, ff_param_ref ref, size_t channel);

/* Says in err why `what` ("the bootstrap") came to no end: cancelled, or st. Returns st. */
ff_status ff_trust_ended(ff_status status, const char *what, ff_error *err);

/* Gives the samples of group g the weight weight[g]. */
void ff_resampled_weigh(const ff_resampled *r, int worker, const ff_places *places, const double *weight);

#endif
