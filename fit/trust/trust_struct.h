/* What is told of fits, as plain values and by results that lie side by side. */
#ifndef FF_TRUST_STRUCT_H
#define FF_TRUST_STRUCT_H
#include "ff_trust.h"
#include "fit/interface/fit_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

struct ff_places {
    size_t n; /**< samples of the problem                                  */
    ff_grouping kind;
    size_t n_groups, n_directions;       /**< directions: distinct ones, or cells                     */
    uint32_t *direction;                 /**< [n] < n_directions, numbered by theta_i, then phi_i     */
    uint32_t *group;                     /**< [n] < n_groups: directions, or runs of samples inside them */
    unsigned char *band[FF_PLACE_COUNT]; /**< [n] < FF_BANDS                                          */
};

/* As the functions of ff_trust.h, into what is the caller's; and what releases what that owns. The options are as long as they are
 * here. */
ff_status ff_places_init(const ff_problem *p, const ff_table *t, ff_places *out, ff_error *err);
void ff_places_clear(ff_places *places);
ff_status ff_trust_bands_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                              ff_bands *out, ff_error *err);
ff_status ff_trust_residual_table_into(const ff_problem *p, const ff_table *t, const ff_fit_options *o, const ff_fit_result *fit,
                                       ff_table *out, ff_error *err);
ff_status ff_trust_outliers_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                                 ff_outliers *out, ff_error *err);
ff_status ff_trust_explained_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_explained *out,
                                  ff_error *err);
ff_status ff_trust_bootstrap_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats,
                                  uint64_t seed, ff_fit_result *fit, ff_bootstrap *out, ff_error *err);
ff_status ff_trust_cut_off_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double max_theta,
                                ff_cut_off *out, ff_error *err);
void ff_cut_off_clear(ff_cut_off *c);
ff_status ff_trust_budget_into(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                               const ff_fit_result *fit, const ff_budget_options *u, ff_budget *out, ff_error *err);
void ff_budget_clear(ff_budget *b);

ff_status ff_trust_next_into(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                             const ff_fit_result *fit, const ff_fit_result *rival, double reach, ff_next *out, ff_error *err);
/* The profile of one parameter: its values, and the least objective of all others there. */
typedef struct ff_curve {
    size_t n;
    double *value, *objective; /* [n]; objective belongs to value          */
    double best, low, high;    /* value of the fit, ends of its interval    */
    double limit;              /* objective at which the interval ends      */
} ff_curve;
/* Of n >= 3 points, over the interval and somewhat beyond. FF_ERR_UNSUPPORTED for a parameter that is held or tied. */
ff_status ff_trust_curve_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_param_ref ref,
                              size_t channel, size_t n, ff_curve *out, ff_error *err);
void ff_curve_clear(ff_curve *c);

/* The refits of a bootstrap by themselves: n_wanted parameters of each. Their distances from the mean are multiplied by what the
 * standard errors of ff_trust_bootstrap are, for errors that go together; a parameter on a bound is left as it is. */
typedef struct ff_refits {
    size_t n, n_wanted;
    double *value;  /* [n][n_wanted]                           */
    double widened; /* the largest of these factors            */
    ff_bootstrap made;
} ff_refits;
/* As ff_trust_bootstrap; the fit is left as it is. FF_ERR_UNSUPPORTED for a parameter that is held or tied. */
ff_status ff_trust_refits_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats, uint64_t seed,
                               const ff_fit_result *fit, size_t n_wanted, const ff_param_ref *wanted, const size_t *channel,
                               ff_refits *out, ff_error *err);
void ff_refits_clear(ff_refits *r);

/* fits [n] */
ff_status ff_trust_likeliest_into(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fits, size_t n, size_t *out,
                                  ff_error *err);
ff_status ff_trust_compare_into(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fits,
                                size_t n, size_t winner, size_t folds, ff_versus *out, ff_error *err);
ff_status ff_trust_channels_differ_into(const ff_fit_result *fits, size_t n, ff_difference *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
