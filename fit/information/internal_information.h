/* What the sums at an optimum say of its parameters: the information, its inverse,
 * clusters of samples whose errors go together, and the covariance by the residuals themselves. */
#ifndef FF_INTERNAL_INFORMATION_H
#define FF_INTERNAL_INFORMATION_H
#include "fit/pass/internal_influence.h"
#include "fit/problem/internal_problem.h"

/* ---- information ------------------------------------------------------------------------------ */

/* The two sides of what is known at an optimum, of the parameters (not coordinates) in use: the information H = J^T J, by its
 * inverse, and the covariance. H is kept as a whole or as an arrowhead, behind the functions of a storage; nobody else needs to
 * know which. One piece of memory, released with free. */
typedef struct ff_information {
    const struct ff_storage *storage;
    size_t P, S, K, C; /* parameters: all, shared, of a channel; channels                                            */
    size_t used;       /* parameters in use                                                                          */
    double of_channel; /* those that a channel has to do with: the shared and its own, a mean over channels           */
    double *scale;     /* [P] 1 / the root of H's diagonal: what is scaled below is of the H whose diagonal is 1      */
    double *inverse;   /* [P] the diagonal of H^-1; 0 where not in use                                               */
    double *variance;  /* [P] that of the covariance                                                                 */
    double *dof;       /* [P] degrees of freedom that the error of each is estimated from                            */
    double *of_data;   /* [P] share of what is known that the data say; a prior is not estimated from clusters       */
    int *use;          /* [P]                                                                                        */
    int *determined;   /* [P] 0: not in use, or the data say nothing                                                 */
    ff_clusters clusters;
    double effective; /* number of independent values                                                                */
    /* The storage's own: of an arrowhead what the pass over influences reads too, of a whole H the scaled H^-1 [P][P]. */
    ff_arrowhead arrowhead;
    double *whole;
    double *covariance; /* as the storage lays it out                                                                */
} ff_information;

/* H and its inverse from the sums of a pass, in the storage of the plan's layout. at_bound [P]: parameters that are on a bound are
 * not in use; NULL: all are. FF_ERR_MEMORY. */
ff_status ff_information_new(const ff_plan *plan, const ff_normal *n, const int *at_bound, ff_information **out);

/* The covariance from the sums of a final pass over n_samples of the plan's samples: H^-1 M H^-1 with M over clusters
 * (heteroscedasticity-consistent, HC1: MacKinnon and White 1985); with weights by the data's standard deviations H^-1, its errors
 * larger by what the clusters say. of_samples: the products of the influences of single samples, where the pass has made them, else
 * NULL. FF_ERR_MEMORY. */
ff_status ff_information_finish(ff_information *info, const ff_plan *plan, const ff_normal *n, size_t n_samples,
                                const double *of_samples);

/* The covariance as factor times the sum of the products of n influences [n][P]. dof are left alone. FF_ERR_MEMORY. */
ff_status ff_information_from_influences(ff_information *info, const double *influence, size_t n, double factor);

/* Of parameters i and j; NaN where it is not formed: between channels of an arrowhead. */
double ff_information_covariance(const ff_information *info, size_t i, size_t j);

/* The scaled influence H^-1 s of a score [P] in the units of the runs of n: influence [2 P], whose second half is room to work in.
 */
void ff_information_influence(const ff_information *info, const ff_normal *n, const double *score, double *influence);

/* What is known of the parameters from a change of the gradient: out = H^-1 gradient, [P] each. FF_ERR_MEMORY. */
ff_status ff_information_solve(const ff_information *info, const double *gradient, double *out);

/* Entry (i, j) of H^-1. Between channels of an arrowhead it is not formed: NaN. */
double ff_information_inverse(const ff_information *info, size_t i, size_t j);

/* Of an arrowhead: what an influence on the parameters that all channels share moves those of channel c by, where the sample has no
 * value in it, [C][K][S]. */
void ff_information_followers(const ff_information *info, double *out);

/* The covariance from that of the score of the data, M in the layout of H, whose channels are independent, with what priors add.
 * dof are left alone. FF_ERR_MEMORY. */
ff_status ff_information_from_scores(ff_information *info, const ff_plan *plan, ff_gram *M);

/* Multiplies the standard deviation of each parameter by factor [P]. */
void ff_information_multiply(ff_information *info, const double *factor);

/* Share of the variance that is seen when the error of a parameter is estimated from a number of clusters. */
double ff_information_seen(const ff_information *info, double number);

/* Rank and condition of the Jacobian of the parameters in use, by the data alone, each column scaled to unit length. FF_ERR_MEMORY.
 */
ff_status ff_information_condition(const ff_plan *plan, const ff_point *at, size_t *rank, double *condition);

/* The flattest direction of the scaled H: its curvature and the shares [P] of the parameters in it; curvature 1 where the storage
 * does not look for it. FF_ERR_MEMORY. */
ff_status ff_information_flattest(const ff_plan *plan, const ff_point *at, double *curvature, double *share);

/* ---- clusters --------------------------------------------------------------------------------- */

/* Residuals that are nothing but rounding have no errors that could go together. */
ff_status ff_clusters_choose(const ff_plan *plan, const ff_normal *n, size_t n_samples, ff_clusters *out);

/* Sums of the score over the runs, less their mean: it is 0 for a parameter at its optimum, and for one that rests on its bound a
 * slope, which is no error. n_samples of the samples of p count. sums [runs][P], mean [P] out; returns the number of runs. */
size_t ff_clusters_centred(const struct ff_problem *p, const ff_normal *n, size_t n_samples, double *sums, double *mean);
/* Joins pairs of neighbours; a last one without partner stays. Returns how many are left. */
size_t ff_clusters_join(double *sums, size_t n, size_t P);

/* Clusters are as good as equal ones of a smaller number where some have more to say of a parameter than others (Carter, Schnepel
 * and Steigerwald 2017): number [P], for the degrees of freedom of its error. cluster [p->n] of each sample, NULL: n_clusters of
 * equal length in the order of the samples. FF_ERR_MEMORY. */
ff_status ff_clusters_informative(const struct ff_problem *p, const ff_normal *n, size_t n_samples, const uint32_t *cluster,
                                  size_t n_clusters, const ff_information *info, double *number);

/* Number of independent values that would say as much as the n_values: square [P], of the clusters' scores. */
double ff_clusters_effective(const ff_normal *n, const double *square, size_t n_shared, double n_values);

/* Number of equal clusters that n of unequal variance are as good as, from squares q of normal variables: all = {sum q, sum q^2},
 * squares = sum over clusters of (sum q)^2 - 2/3 sum q^2. */
double ff_clusters_count(const double all[2], double squares, double n);

/* Share of the variance that is seen when the error of a parameter is estimated from a number of clusters, by a fit of so many
 * parameters to a channel. */
double ff_clusters_share_seen(double parameters, double number);
#endif
