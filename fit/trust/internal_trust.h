/* What the parts of ff_trust.h share: a fit taken up again where it ended. */
#ifndef FF_INTERNAL_TRUST_H
#define FF_INTERNAL_TRUST_H
#include "ff_trust.h"
#include "fit/internal_fit.h"

/* Parameters and layout of a finished fit. */
typedef struct ff_point {
    ff_layout l;
    double shape[FF_MAX_SHAPE], *channel; /* [n_channels][n_channel] */
    int *at_bound;                        /* [P]; not 0 either where a parameter is held in its channel */
    ff_limits *limits;                    /* those of l, NULL = none */
} ff_point;

/* FF_ERR_RANGE for a fit of other channels than those of p, FF_ERR_MEMORY. Release with ff_point_free. */
ff_status ff_point_new(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_point *out, ff_error *err);
void ff_point_free(ff_point *point);

/* Refits know the samples alone: FF_ERR_UNSUPPORTED where priors or conserved energy moved the fit; `what` says who asks. */
ff_status ff_point_data_alone(const ff_fit_options *o, const char *what, ff_error *err);

/* A pass at the point with statistics and errors. */
ff_status ff_point_pass(const ff_point *point, const struct ff_problem *p, const ff_fit_options *o, ff_normal *out);

/* What each sample adds to the objective: cost [n]. On the calling thread. */
ff_status ff_point_cost(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                        const double *channel, double *cost);

/* What a residual adds to the objective, its standard deviation being `unit` (1 where the scale b is not in these). */
double ff_half_rho(ff_robust robust, double b, double residual, double unit);

/* For every thread of the pool of p a problem with multipliers of its own. */
typedef struct ff_resampled {
    struct ff_problem *problem; /* [threads]: copies of p that share everything but their multipliers */
    float *multiplier;          /* [threads][n_blocks FF_BLOCK]                                         */
    size_t threads;
} ff_resampled;
ff_status ff_resampled_new(const struct ff_problem *p, ff_resampled *out);
void ff_resampled_free(ff_resampled *r);

/* Says in err why `what` ("the bootstrap") came to no end: cancelled, or st. Returns st. */
ff_status ff_trust_ended(ff_status st, const char *what, ff_error *err);

/* Gives the samples of group g the weight weight[g]. */
void ff_resampled_weigh(const ff_resampled *r, int worker, const ff_places *places, const double *weight);

#endif
