/* What the sums at an optimum say of its parameters: clusters of samples whose errors go together, covariance, intervals. */
#ifndef FF_INTERNAL_ERRORS_H
#define FF_INTERNAL_ERRORS_H
#include "fit/pass/internal_influence.h"
#include "fit/problem/internal_problem.h"

/* Residuals that are nothing but rounding have no errors that could go together. */
ff_status ff_clusters_choose(const struct ff_problem *p, const ff_normal *n, size_t n_samples, ff_clusters *out);

/* Outer products of the score summed over runs of `run` samples (1, or ff_run_length 2^k), packed as ff_normal.meat. FF_ERR_MEMORY.
 */
ff_status ff_clusters_meat(const struct ff_problem *p, const ff_normal *n, size_t n_samples, size_t run, double *meat);

/* Clusters are as good as equal ones of a smaller number where some have more to say of a parameter than others (Carter, Schnepel
 * and Steigerwald 2017): number [P], for the degrees of freedom of its error. cluster [p->n] of each sample, NULL: n_clusters of
 * equal length in the order of the samples; inverse [P][P] of J^T J, 0 for parameters that are not in use, or arrow instead.
 * FF_ERR_MEMORY. */
ff_status ff_clusters_informative(const struct ff_problem *p, const ff_normal *n, size_t n_samples, const uint32_t *cluster,
                                  size_t n_clusters, const double *inverse, const struct ff_arrow *arrow, double *number);

/* Sums of the score over the runs, less their mean: it is 0 for a parameter at its optimum, and for one that rests on its bound a
 * slope, which is no error. n_samples of the samples of p count. sums [runs][P], mean [P] out; returns the number of runs. */
size_t ff_clusters_centred(const struct ff_problem *p, const ff_normal *n, size_t n_samples, double *sums, double *mean);
/* Joins pairs of neighbours; a last one without partner stays. Returns how many are left. */
size_t ff_clusters_join(double *sums, size_t n, size_t P);

/* Number of independent values that would say as much as the n_values; meat of the clusters. */
double ff_clusters_effective(const ff_normal *n, const double *meat, size_t n_shape, double n_values);

/* The two sides of what is known at an optimum, of the parameters (not coordinates) in use; [P][P], 0 elsewhere. */
typedef struct ff_uncertainty {
    double *inverse; /* H^-1                                                                       */
    double *cov;     /* covariance                                                                 */
    int *determined; /* [P]: 0 where the data say nothing                                          */
    ff_clusters clusters;
    double effective; /* number of independent values                                               */
    double *dof;      /* [P] degrees of freedom that the error of each is estimated from            */
    double *storage;
} ff_uncertainty;
void ff_uncertainty_free(ff_uncertainty *u);

/* Number of equal clusters that n of unequal variance are as good as, from squares q of normal variables: all = {sum q, sum q^2},
 * squares = sum over clusters of (sum q)^2 - 2/3 sum q^2. */
double ff_clusters_count(const double all[2], double squares, double n);

/* Share of the variance that is seen when the error of a parameter is estimated from a number of clusters, by a fit of so many
 * parameters to a channel. */
double ff_clusters_share_seen(double parameters, double number);
double ff_clusters_seen(const ff_plan *plan, const ff_uncertainty *u, double number);

/* Of the parameters whose `use` is not 0, from a pass over n_samples of the plan's samples. The covariance is H^-1 M H^-1 with M over
 * clusters (heteroscedasticity-consistent, HC1: MacKinnon and White 1985); with weights by the data's standard deviations it is
 * H^-1, its errors larger by what the clusters say. FF_ERR_MEMORY. */
ff_status ff_uncertainty_new(const ff_plan *plan, const ff_normal *n, const int *use, size_t n_samples, ff_uncertainty *out);

/* Of the parameters that are on no bound, from the sums at a point of all samples. FF_ERR_MEMORY. */
ff_status ff_uncertainty_at(const ff_plan *plan, const ff_point *at, ff_uncertainty *out);
/* Of all parameters, those on a bound too. FF_ERR_MEMORY. */
ff_status ff_uncertainty_of_all(const ff_plan *plan, const ff_point *at, ff_uncertainty *out);

/* The stage before the result: what the errors and the statistics of a point need, unless the minimisation has left it. FF_ERR_MEMORY;
 * FF_ERR_INTERNAL where a sum is not finite. */
ff_status ff_errors_pass(const ff_plan *plan, ff_point *at);

/* 95 % intervals of all parameters: by their standard errors, which r has, or one-sided on a bound. FF_ERR_MEMORY. */
ff_status ff_intervals_fill(const ff_plan *plan, const ff_point *at, const ff_uncertainty *u, ff_fit_result *r);
/* Interval of v->value +- half_width, symmetric in the coordinate. */
void ff_interval_around(const ff_param *info, double half_width, ff_interval kind, ff_fit_value *v);
/* From the bound of v inside to where slope d + d^2 / (2 inverse) has risen by allowed; no curvature: to the other bound. */
void ff_interval_from_bound(const ff_param *info, double slope, double inverse, double allowed, ff_fit_value *v);

/* Rank and condition of the Jacobian of the parameters on no bound; warns of several that trade off. FF_ERR_MEMORY. */
ff_status ff_condition_fill(const ff_plan *plan, const ff_point *at, ff_fit_result *r);
#endif
