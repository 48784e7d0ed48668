/** @file ff_trust.h  How far a fit can be trusted: resampled, profiled, cross-validated, compared, looked at by angle.
 *
 *  Everything here starts from a result of ff_problem_fit and the problem it was fitted to, with the same options; places say where
 *  the samples of the problem lie. Results do not depend on the number of threads.
 *  Memory   outputs own their arrays; release with the _free functions.
 *  Errors   ff_status and ff_error; outputs are written only on FF_OK. FF_ERR_CANCELLED as ff_problem_fit.
 *  Threads  as ff_fit.h: one call at a time on a problem. */
#ifndef FF_TRUST_H
#define FF_TRUST_H
#include "ff_api.h"
#include "ff_fit.h"
#ifdef __cplusplus
extern "C" {
#endif

/* ---- places ---------------------------------------------------------------------------------- */

/** What samples are resampled in: errors inside a group may go together in any way. */
typedef enum ff_grouping {
    FF_GROUP_DIRECTIONS = 0, /**< incident directions (of isotropic data their theta_i), to 0.001 rad               */
    FF_GROUP_CELLS = 1,      /**< cells of incident directions, where nearly every sample has its own                */
    FF_GROUP_RUNS = 2,       /**< runs of consecutive samples inside an incident direction, where these are too few   */
    FF_GROUP_VALUES = 3      /**< of a bootstrap: each value by itself, drawn by the noise of the data                */
} ff_grouping;
FF_API const char *ff_grouping_name(int kind); /**< "incident directions", ...; NULL for a number that is none */

enum { FF_PLACE_THETA_I = 0, FF_PLACE_THETA_H = 1, FF_PLACE_THETA_D = 2, FF_PLACE_COUNT = 3 };
enum { FF_BANDS = 9, FF_BAND_DEGREES = 10 }; /**< [0, 10), [10, 20) ... degrees */

/** Where the samples of a problem lie: groups, incident directions, bands of angles. Closed. */
typedef struct ff_places ff_places;

/** Finds the places of the samples of p.
 *  @param t  the table that p was made from, unchanged
 *  FF_ERR_MEMORY. *out is written only on FF_OK; release it with ff_places_free. */
FF_API ff_status ff_places_new(const ff_problem *p, const ff_table *t, ff_places **out, ff_error *err);
FF_API void ff_places_free(ff_places *places); /**< NULL is allowed */

/** What the groups are, how many there are, and in how many incident directions. */
FF_API ff_grouping ff_places_grouping(const ff_places *places);
FF_API size_t ff_places_group_count(const ff_places *places);
FF_API size_t ff_places_direction_count(const ff_places *places); /**< distinct incident directions, or cells of them */

/* ---- values ---------------------------------------------------------------------------------- */

/** "theta_i", "theta_h", "theta_d"; NULL for a number that is none */
FF_API const char *ff_place_name(int place);

/** Place of each used sample in the table: [used], owned by p. */
FF_API const uint32_t *ff_problem_index(const ff_problem *p);

/** The fitted model at the used samples.
 *  @param model     [n_channels][used] out, 1/sr; may be NULL
 *  @param residual  [n_channels][used] out, weighted, as in the objective but before a robust loss; may be NULL
 *  @param cost      [used] out, what each sample adds to the objective; may be NULL */
FF_API ff_status ff_trust_evaluate(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double *model,
                                   double *residual, double *cost, ff_error *err);

/** Residuals of one band of angles, all channels, by sample weight: cos(theta_i) (f - y), relative to the mean of cos(theta_i) |y|
 * in the band. */
typedef struct ff_band {
    size_t n;         /**< samples                                                      */
    double mean, rms; /**< signed mean: below 0 where the model is too low; NaN when n = 0 */
} ff_band;
/** All of them, by every angle of ff_place_name. */
typedef struct ff_bands {
    ff_band band[FF_PLACE_COUNT][FF_BANDS];
} ff_bands;

/** Where is the model too low or too high? Residuals of the fit by angle. FF_ERR_MEMORY. */
FF_API ff_status ff_trust_bands(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                                ff_bands *out, ff_error *err);

/** Model minus data (1/sr) as a table with the directions of t, from which p was made: samples that the fit did not use are invalid
 *  there, standard deviations are left out. Release with ff_table_free. */
FF_API ff_status ff_trust_residual_table(const ff_problem *p, const ff_table *t, const ff_fit_options *o, const ff_fit_result *fit,
                                         ff_table **out, ff_error *err);

/** What a fit explains of its data, and where it fails most. Of more than 20,000 samples it is looked at through some of them. */
typedef struct ff_explained {
    size_t size;  /**< sizeof(ff_explained), set by the caller                                                       */
    double share; /**< 1 - squares that the model leaves / squares of the data, with the weights and the loss of the fit, of the
                       loss ln about the mean of each channel; NaN of data that are 0. Below 0: worse than black */
    double bright_error;  /**< median of |y - f| / f where f cos(theta_i) cos(theta_o) is at least a tenth of the largest of its
                               channel; NaN: nowhere                                                                    */
    size_t bright_values; /**< how many these are                                                                       */
    int worst_place;      /**< FF_PLACE_THETA_I or FF_PLACE_THETA_H, of the band of angles ...                          */
    int worst_band;       /**< ... in which the mean of model - data is furthest from 0, of those whose mean is more than twice
                               its own scatter and that have a hundredth of the light and of the samples, five at least */
    double worst_mean;    /**< relative to the mean of the data there, both times cos(theta_i); NaN: there is none      */
    double worst_share;   /**< of the data, times cos(theta_i), that lie in that band                                   */
} ff_explained;

/** How well does the fit describe its data? *out is written only on FF_OK, its size is set. FF_ERR_RANGE for a size that is none;
 *  FF_ERR_MEMORY. */
FF_API ff_status ff_trust_explained(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_explained *out,
                                    ff_error *err);

#define FF_OUTLIER 5.0 /**< standard deviations of a residual, as the scale of the robust loss tells these */
enum { FF_WORST = 5 };
/** Values that lie further from the model than FF_OUTLIER. */
typedef struct ff_outliers {
    size_t size;                              /**< sizeof(ff_outliers), set by the caller                */
    size_t values, samples;                   /**< values, and samples that have one                     */
    size_t in_band[FF_PLACE_COUNT][FF_BANDS]; /**< samples with one                                      */
    size_t n_worst;
    struct {
        uint32_t sample; /**< place in the table */
        uint32_t channel;
        double ratio; /**< residual in standard deviations, with its sign */
    } worst[FF_WORST];
} ff_outliers;

/** Which values does the model not explain? *out is written only on FF_OK, its size is set. FF_ERR_RANGE for a size that is none;
 *  FF_ERR_UNSUPPORTED without a robust loss. */
FF_API ff_status ff_trust_outliers(const ff_problem *p, const ff_places *places, const ff_fit_options *o, const ff_fit_result *fit,
                                   ff_outliers *out, ff_error *err);

/* ---- intervals ------------------------------------------------------------------------------- */

/** What a bootstrap was made of. */
typedef struct ff_bootstrap {
    size_t size;            /**< sizeof(ff_bootstrap), set by the caller              */
    size_t repeats, failed; /**< refits, and those that did not converge (left out) */
    size_t n_groups;        /**< or values                                        */
    ff_grouping kind;
} ff_bootstrap;

/** How refits scatter: replaces the standard errors and intervals of fit.
 *
 *  With ff_fit_options.errors = FF_ERRORS_NOISE a parametric bootstrap (Efron and Tibshirani 1993, chapter 6): values are drawn
 * about the fit by the noise of the data. Where a fit is not linear in its errors the refits know it and its standard errors do
 * not; that errors go together, and what the residuals say of few values, is taken from these (a factor), and their degrees of
 * freedom.
 *
 *  Otherwise, where the fit has found no noise, and where values are known from one side only, a block bootstrap: random weights of
 *  the groups of places, exponential ones (Rubin 1981), so that no incident direction is ever missing; the standard deviation of
 * the refits is corrected for the variance of the weights of G groups and for the number of groups that say much of the parameter,
 * with Student's t of as many degrees of freedom less one.
 *
 *  Of a parameter on its bound the 95 % quantile. The same seed gives the same intervals.
 *  FF_ERR_RANGE for repeats < 20 and for a size of *out that is none; FF_ERR_DATA for fewer than 5 groups where groups are weighed.
 */
FF_API ff_status ff_trust_bootstrap(const ff_problem *p, const ff_places *places, const ff_fit_options *o, size_t repeats,
                                    uint64_t seed, ff_fit_result *fit, ff_bootstrap *out, ff_error *err);

/** Profile of the objective: for every free parameter the values at which the least objective of all others has risen by what 95 %
 * allow: t^2 / 2 times the variance of a residual, corrected as the standard error is (a parameter whose error is twice the
 * textbook's may raise it four times as much; after ff_trust_jackknife as much as its interval would). An interval that ends at a
 * bound ends there because the data do not end it. Replaces the intervals of fit. Where a lower objective than that of the fit is
 * found, a warning of fit says so. */
FF_API ff_status ff_trust_profile(const ff_problem *p, const ff_fit_options *o, ff_fit_result *fit, ff_error *err);

/** Errors by leaving out one incident direction after another (the cluster jackknife CR3, by a fit without each; Bell and McCaffrey
 * 2002; MacKinnon, Nielsen and Webb 2023), with Student's t of one less than their number: they allow for anything that all samples
 * of an incidence have in common, as an error of its gain. Replaces the standard errors, correlations and intervals of fit, but
 * those of parameters on a bound. A parameter that one incidence alone determines has no error, and a warning of fit says so.
 * FF_ERR_DATA for fewer than 3 incident directions, FF_ERR_UNSUPPORTED with priors or conserved energy, FF_ERR_CANCELLED. */
FF_API ff_status ff_trust_jackknife(const ff_problem *p, const ff_places *places, const ff_fit_options *o, ff_fit_result *fit,
                                    ff_error *err);

/** How the parameters moved. Made by ff_trust_cut_off and only looked at; later versions may have more members at its end. */
typedef struct ff_cut_off {
    double max_theta;     /**< radians                              */
    size_t used;          /**< samples left                         */
    size_t n_columns;     /**< parameters with a standard error      */
    double *value, *move; /**< [n_columns] by column of fit: value there; difference to that of all samples in units of its own
                               standard error, which samples in both do not add to; where errors rest on the residuals alone in
                               units of the error there, which what is wrong beyond the limit does not enlarge */
    double limit;         /**< |move| beyond which one of all is seen in 5 % of measurements where nothing moves */
    double *shift;        /**< [n_columns] the same difference in standard errors of the fit to all samples */
} ff_cut_off;
#define FF_CUT_OFF_MATTERS                                                                                                         \
    (1.0 / 3) /**< |shift| below which a move, chance or not, is nothing to who uses the number with its error */

/** The same fit with a lower limit of theta: which parameters move by more than their errors? max_theta in radians, in
 * (0, pi/2]: FF_ERR_RANGE. FF_ERR_DATA when too few samples are left. *out is written only on FF_OK; release it with
 * ff_cut_off_free. */
FF_API ff_status ff_trust_cut_off(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, double max_theta,
                                  ff_cut_off **out, ff_error *err);
FF_API void ff_cut_off_free(ff_cut_off *c); /**< NULL is allowed */

/* ---- what the instrument adds ----------------------------------------------------------------- */

/** Standard uncertainties of what an instrument says of itself; 0: none. Fill with ff_budget_options_init, then change. */
typedef struct ff_budget_options {
    size_t size;
    double scale;    /**< of all values together, relative, in [0, 1]: the calibration                                       */
    double offset;   /**< of the zero of each angular scale, radians in [0, 0.1]: one for all angles of incidence, one for all of
                          the detector. In the plane of incidence, away from the light counting up                        */
    double angle;    /**< of each polar angle by itself, radians in [0, 0.1]: every setting of the incidence, every reading of the
                          detector                                                                                        */
    double aperture; /**< of the half angle of the aperture, radians in [0, 0.1]                                             */
} ff_budget_options;
FF_API void ff_budget_options_init_size(ff_budget_options *u, size_t size);
static inline void ff_budget_options_init(ff_budget_options *u)
{
    ff_budget_options_init_size(u, sizeof *u);
}

/** What an uncertainty of a parameter comes from. */
typedef enum ff_budget_source {
    FF_BUDGET_SCALE = 0,
    FF_BUDGET_INCIDENCE_OFFSET = 1,
    FF_BUDGET_DETECTOR_OFFSET = 2,
    FF_BUDGET_INCIDENCES = 3, /**< each setting of the incidence by itself */
    FF_BUDGET_READINGS = 4,   /**< each reading of the detector by itself: it scatters the data, so that the random error has it
                                   already, and `combined` does not count it again */
    FF_BUDGET_APERTURE = 5
} ff_budget_source;
enum { FF_BUDGET_SOURCES = 6 };
FF_API const char *ff_budget_source_name(int source); /**< "scale", "incidence_offset", ...; NULL for a number that is none */

/** A table of contributions. Made by ff_trust_budget and only looked at; later versions may have more members at its end. */
typedef struct ff_budget {
    size_t n_columns;              /**< parameters with a standard error                                                     */
    double *random;                /**< [n_columns] the standard error of the fit                                            */
    double *by[FF_BUDGET_SOURCES]; /**< [n_columns] standard uncertainties by column of fit; NULL where the source has none   */
    double *combined;              /**< [n_columns] root of the sum of squares of the two                                    */
} ff_budget;

/** What do the uncertainties of the instrument add to each parameter? The law of propagation (JCGM 100:2008, 5.1.2): by how much
 * the optimum moves, to first order, where the data are what the model reads at angles, through an aperture or with a scale that
 * are off by one standard uncertainty. Contributions count as independent.
 *  @param t  the table that p was made from, unchanged
 *  *out is written only on FF_OK; release it with ff_budget_free. FF_ERR_RANGE for an uncertainty that is none; FF_ERR_UNSUPPORTED
 *  with a robust loss, for the uncertainty of an aperture that is a point, and for single angles where a fit has more than 512
 *  parameters; FF_ERR_MEMORY. */
FF_API ff_status ff_trust_budget(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                                 const ff_fit_result *fit, const ff_budget_options *u, ff_budget **out, ff_error *err);
FF_API void ff_budget_free(ff_budget *b); /**< NULL is allowed */

/* ---- comparison ------------------------------------------------------------------------------ */

/** What a fit differs from the best by, positive where the best is better.
 *
 *  Is it worse? Where errors rest on the noise of the data, all models are fitted again by common weights, residuals in standard
 *  deviations of the data by the noise of the model that makes them most likely, and the differences of the squares to the best of
 *  these fits are summed over whole incidences: vuong_z is the sum over its standard deviation, vuong_p one-sided by Student's t of
 *  incidences - 1 (Rivers and Vuong 2002, with clusters). A model that the best one becomes where a parameter has a certain value
 *  (by_parameter) is judged by Wald's test of that parameter, two-sided. told_apart is p below 0.05, corrected for the number of
 *  models that lead (p of 0.05 or more; Sidak 1967, with n^2 / sum r^2 of their correlations over incidences for their number).
 * Fewer than 3 incidences: no test is possible, z and p are NaN.
 *
 *  Where errors rest on residuals: vuong_z is the difference of the objective, with the penalty of AIC, over its standard deviation
 *  (Vuong 1989). The variance is that over clusters of neighbours or, from 10 on, over groups, whichever leaves more doubt; p is
 *  two-sided by Student's t, whose degrees of freedom are the clusters that count less one. */
typedef struct ff_versus {
    double objective; /**< difference                                                              */
    double aic, bic;  /**< differences, with the effective number of values of the winner; by common weights those of the
                           likelihood of residuals in standard deviations */
    double vuong_z;
    double vuong_p;
    int has_validation;
    double validation, validation_error; /**< held-out objective: difference, its standard error over incident directions */
    /** 0: the data cannot tell the two apart: vuong_p is too large, or (where errors rest on residuals) held-out samples do not say
     *  the same by more than their standard error. */
    int told_apart;
    int weighted;        /**< 1: by common weights                                                     */
    int by_parameter;    /**< 1: by the parameter that the best one has more                            */
    double standardised; /**< sum of squares in standard deviations: difference                         */
    size_t incidences;   /**< that were summed over                                                   */
} ff_versus;

/** Which of n fits to p makes its data most likely, each by the noise that it has found? *out: its number, 0 where one of them has
 * found none. FF_ERR_RANGE for no fits. Its noise is what ff_problem_weigh_by_noise should weigh all by that are to be compared.
 * FF_ERR_MEMORY. */
FF_API ff_status ff_trust_likeliest(const ff_problem *p, const ff_fit_options *o, const ff_fit_result *const *fits, size_t n,
                                    size_t *out, ff_error *err);

/** Each of n fits to p against fits[winner].
 *  @param folds  >= 2: cross-validation, each fold every folds-th incident direction; 0: none
 *  @param out    [n] out; out[winner] is all 0
 *  FF_ERR_RANGE for folds = 1 or more than directions. */
FF_API ff_status ff_trust_compare(const ff_problem *p, const ff_places *places, const ff_fit_options *o,
                                  const ff_fit_result *const *fits, size_t n, size_t winner, size_t folds, ff_versus *out,
                                  ff_error *err);

/** An incident direction, radians. */
typedef struct ff_incidence {
    double theta_i, phi_i;
} ff_incidence;
enum { FF_NEXT = 3 };
/** What to measure next. */
typedef struct ff_next {
    size_t size; /**< sizeof(ff_next), set by the caller                                                          */
    size_t n;    /**< incidences, by theta_i, then phi_i: fewer than FF_NEXT where there is no room for more       */
    ff_incidence at[FF_NEXT];
    /** With a rival: the z that a comparison may be expected to find (ff_versus), with the samples that there are and with the
     *  incidences added. Without: the standard error of `parameter`. */
    double now, then;
    double reach;           /**< up to which theta_i was looked, radians                                              */
    ff_param_ref parameter; /**< without a rival the one whose error is largest beside its value; else none           */
    size_t channel;         /**< of it                                                                                */
} ff_next;

/** Which incidences would best tell `fit` from `rival`, if fit is the surface, or with rival NULL say most of the parameter that is
 *  known worst? A new incidence is taken to be measured in the exit directions of the one that has the most samples, with the noise
 *  that fit has found; candidates lie every 5 degrees, not within 2 of what is there. By first derivatives (Atkinson and Fedorov
 *  1975; Fedorov 1972).
 *  @param t      the table that p was made from, unchanged
 *  @param reach  the largest theta_i of the instrument, radians in [0, pi/2): FF_ERR_RANGE; 0: that of the data
 *  *out is written only on FF_OK, its size is set. FF_ERR_RANGE for a size that is none; FF_ERR_UNSUPPORTED where fit has found no
 *  noise; FF_ERR_MEMORY. */
FF_API ff_status ff_trust_next(const ff_problem *p, const ff_table *t, const ff_places *places, const ff_fit_options *o,
                               const ff_fit_result *fit, const ff_fit_result *rival, double reach, ff_next *out, ff_error *err);

/** A test of a difference: chi^2 of dof degrees of freedom by errors that are estimates themselves, F of it, which allows for that
 *  by error_dof (INFINITY: errors are known), and the probability of an F as large where there is no difference. */
typedef struct ff_difference {
    double chi2, p;
    size_t dof; /**< 0 where nothing can be compared */
    double f, error_dof;
} ff_difference;

/** Do fits of one model to n channels of the same data differ in their shape by more than their errors? Wald's chi^2 of the free
 * shape parameters, in the coordinates of the fit, about their common weighted mean, and Johansen's (1980) F of it; errors of
 * different channels count as independent, so that it errs on the side of "no".  FF_ERR_RANGE for fits of different models. */
FF_API ff_status ff_trust_channels_differ(const ff_fit_result *const *fits, size_t n, ff_difference *out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
