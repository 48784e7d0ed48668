/** @file ff_fit.h  Finding the parameters of a model in measured data.
 *
 *  A problem selects the usable samples of a table once and keeps the geometry that no parameter changes; every model is then
 *  fitted to the same samples. The result depends on the data and the options, not on the number of threads nor on the run.
 *
 *      ff_fit_options o;
 *      ff_fit_options_init(&o);
 *      ff_problem_new(table, &(const ff_model *){model}, 1, &o, &problem, &err);
 *      ff_problem_fit(problem, model, &o, &fit, &err);
 *      const ff_fit_value *alpha = ff_fit_result_find(fit, "alpha_x", 0);        // alpha->value, alpha->std_error, ...
 *      ff_fit_result_free(fit);
 *      ff_problem_free(problem);
 *
 *  Objective  1/2 sum over samples i and channels c of rho(r_ic^2), r_ic = sqrt(w_i) (g(f(p)) - g(y)) with g of the loss
 *             (ff_loss.h) and w of the weighting below; the weights have mean 1, so that the objective of unit weights is the
 *             plain half sum.
 *  Memory     problems and results own their arrays; release with the _free functions. Where memory runs out the status is
 *             FF_ERR_MEMORY, with one exception: within the solver, Ceres allocates also where it may not throw (in destructors),
 * and then ends the process by std::terminate; elsewhere in it an allocation or two may stay behind. A program that has to survive
 * that fits in a process of its own. Errors     ff_status and ff_error. How a fit ended (converged, stalled, ...) is not a status:
 * see ff_outcome. Threads    a problem may serve one fit at a time; several problems are independent. A const result may be read
 * from many threads at once. */
#ifndef FF_FIT_H
#define FF_FIT_H
#include "ff_aperture.h"
#include "ff_api.h"
#include "ff_brightest.h"
#include "ff_diagnosis.h"
#include "ff_loss.h"
#include "ff_model.h"
#include "ff_noise.h"
#include "ff_table.h"
#include "ff_warning.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Weight of a sample. AUTO takes the first the file offers: solid angle, sigma, sample. SIGMA divides each residual by the
 *  standard deviation that the file gives (propagated through g). */
typedef enum ff_weighting {
    FF_WEIGHT_AUTO = 0,
    FF_WEIGHT_SOLID_ANGLE = 1,
    FF_WEIGHT_SAMPLE = 2,
    FF_WEIGHT_SIGMA = 3,
    FF_WEIGHT_NOISE = 4
} ff_weighting;
enum { FF_WEIGHT_COUNT = 5 };

/** Which roughness parameters are free. AUTO: isotropic where the table is, correlated otherwise. */
typedef enum ff_shape {
    FF_SHAPE_AUTO = 0,
    FF_SHAPE_ISOTROPIC = 1, /**< alpha_x = alpha_y, r_xy = 0 */
    FF_SHAPE_AXIS = 2,      /**< alpha_x, alpha_y; r_xy = 0  */
    FF_SHAPE_CORRELATED = 3 /**< alpha_x, alpha_y, r_xy      */
} ff_shape;
enum { FF_SHAPE_COUNT = 4 };

/** RGB: the channels share the shape, each has its own f0 and kd. MEAN: one channel, their average. EACH: one fit per channel. */
typedef enum ff_channel_mode { FF_CHANNELS_RGB = 0, FF_CHANNELS_MEAN = 1, FF_CHANNELS_EACH = 2 } ff_channel_mode;
enum { FF_CHANNELS_COUNT = 3 };

/** Names as on the command line; NULL for a number that is none. The _find functions return -1 when unknown. */
FF_API const char *ff_weighting_name(int weighting);
FF_API const char *ff_shape_name(int shape);
FF_API const char *ff_channel_mode_name(int mode);
FF_API int ff_weighting_find(const char *name);
FF_API int ff_shape_find(const char *name);
FF_API int ff_channel_mode_find(const char *name);

/** What standard errors are made of.
 *
 *  NOISE: the covariance H^-1 J' S J H^-1 with S the variance of the data by their noise (ff_noise.h), estimated from the residuals
 *  or given, moderated by the residuals where many values carry a parameter. RESIDUALS: the same with S the squares of the
 * residuals themselves over clusters of neighbours: right without a noise model, but only where tens of values carry each
 * parameter. With SIGMA weights and without a given noise, and with a robust loss, it is the latter. INCIDENCES: what all samples
 * of an incident direction have in common is an error too; it is for the caller, who asks ff_trust_jackknife for it after the fit,
 * whose own errors are by the noise. */
typedef enum ff_error_source { FF_ERRORS_NOISE = 0, FF_ERRORS_RESIDUALS = 1, FF_ERRORS_INCIDENCES = 2 } ff_error_source;
enum { FF_ERROR_SOURCE_COUNT = 3 };
FF_API const char *ff_error_source_name(int source); /**< "noise", "residuals", "incidences"; NULL for a number that is none */
FF_API int ff_error_source_find(const char *name);   /**< -1 when unknown */

/** How a fit ended. */
typedef enum ff_outcome {
    FF_CONVERGED = 0, /**< the steps or the gradient fell below their tolerances                      */
    FF_STALLED = 1,   /**< no step lowers the objective, though the gradient is not small             */
    FF_LIMIT = 2,     /**< max_iterations was reached                                                 */
    FF_CANCELLED = 3  /**< the caller asked to stop                                                   */
} ff_outcome;
FF_API const char *ff_outcome_name(int outcome); /**< "converged", ...; NULL for a number that is none */

/** What is known of a parameter besides the data. Names are those of the model ("alpha_x", "lobe2.f0"); "alpha" and "lobe2.alpha"
 *  stand for both axes, a per-channel name for all channels or, with a `channel` as the table names it, for that one. */
typedef struct ff_bound {
    const char *name;
    double lo, hi;       /**< as ff_model_bound                                                    */
    const char *channel; /**< NULL: of all channels                                                */
} ff_bound;

/** The parameter is mean +- sd, a normal distribution, before the data are seen. Of every channel by itself, unless they are tied.
 */
typedef struct ff_prior {
    const char *name;
    double mean, sd;     /**< finite; sd > 0                                                       */
    const char *channel; /**< NULL: of every channel                                               */
} ff_prior;

/** A per-channel parameter is held: at value [n], one for each channel of the table in its order; or, with n = 1 and a `channel`,
 * in that channel alone, whatever it is in the others. One value for all channels is ff_model_hold. */
typedef struct ff_fixed {
    const char *name;
    size_t n;
    const double *value; /**< [n]                                                                  */
    const char *channel; /**< NULL: all of them                                                    */
} ff_fixed;

/** Parameter `name` is equal to `to`; to = NULL: the per-channel parameter has one value for all channels. Tied parameters are of
 * one kind: both shared or both per channel, fitted in the same coordinate. What follows a parameter that is held is held. */
typedef struct ff_tie {
    const char *name, *to;
} ff_tie;

/** Borrowed by the options; must outlive the fit. */
typedef struct ff_constraints {
    size_t n_bounds, n_priors, n_ties, n_fixed;
    const ff_bound *bound;      /**< [n_bounds]                                                             */
    const ff_prior *prior;      /**< [n_priors]                                                             */
    const ff_tie *tie;          /**< [n_ties]                                                               */
    const ff_fixed *fixed;      /**< [n_fixed]                                                              */
    int energy_conserving;      /**< 1: no channel reflects more than arrives, at any incidence: albedo <= 1 + 1e-4 */
    int where_present;          /**< 1: what names a parameter that the model lacks is left out             */
    const char *const *because; /**< [n_bounds] why a bound is assumed, in half a sentence, for reports; an entry, or all of it,
                                     NULL: the caller says so                                           */
} ff_constraints;

/** Whether the constraints make sense for m. FF_ERR_UNKNOWN names the parameter that m lacks (not with where_present); FF_ERR_RANGE
 *  for bounds (see ff_model_bound; those of tied parameters must overlap), priors and held values out of range; FF_ERR_UNSUPPORTED
 *  for a tie of unlike parameters, or of one that is held apart, for a channel of a parameter that has one value for all, and for a
 *  model that no parameters make conserve energy. Channels themselves, and the number of held values, are looked at by
 *  ff_problem_fit, which knows the data: FF_ERR_UNKNOWN for a channel that is none, FF_ERR_RANGE for another number of values than
 *  channels, FF_ERR_UNSUPPORTED for single channels of a tied parameter or of channels that are averaged. A bound of one channel
 *  takes the place of that of all. Fitted alone (only_channel), a channel takes what is its own. */
FF_API ff_status ff_constraints_check(const ff_constraints *c, const ff_model *m, ff_error *err);

/** Options of the selection (used by ff_problem_new) and of the fit. Fill with ff_fit_options_init, then change. */
typedef struct ff_fit_options {
    size_t size;              /**< sizeof(ff_fit_options)                                                    */
    ff_loss loss;             /**< FF_LOSS_COSINE                                                            */
    ff_robust robust;         /**< FF_ROBUST_NONE                                                            */
    double robust_scale;      /**< b of ff_robust_info, > 0, in units of the weighted residual; 0 (as initialised): estimated, see
                                   ff_problem_estimate_scale */
    ff_weighting weighting;   /**< FF_WEIGHT_AUTO                                                            */
    double max_theta;         /**< radians, in (0, pi/2]; samples with theta_i or theta_o beyond it are left out; 80 degrees */
    ff_channel_mode channels; /**< FF_CHANNELS_RGB or _MEAN for a problem; EACH is for the caller: one problem per channel */
    int only_channel;         /**< >= 0: this channel alone; -1 = all                                        */
    double saturation;        /**< values at or above it (1/sr) are only known to be at least this; INFINITY */
    double noise_floor;       /**< values below it (1/sr) are only known to be at most this; -INFINITY       */
    double noise_sigmas;      /**< the same for values below this many of their standard deviations; 0 = off */
    int drop_negative;        /**< 1: samples with a negative value are left out; 0: they are kept as noise  */
    ff_shape shape;           /**< FF_SHAPE_AUTO                                                             */
    int mean_slope;           /**< 1: slope_x, slope_y are free too (a tilted sample)                        */
    int threads;              /**< 1 .. FF_THREADS_MOST; 0 = one per processor                               */
    ff_isa isa;               /**< FF_ISA_BEST                                                               */
    int max_iterations;       /**< of the solver on all samples; 100                                        */
    int std_errors;           /**< 1: covariance, standard errors, correlations                              */
    const ff_constraints *constraints; /**< NULL: none                                                     */
    /** Start given by the caller instead of searched for: [n_shape] and [n_channels][n_channel]; both or neither. */
    const double *start_shape, *start_channel;
    /** Polled between passes; not NULL and *cancel != 0 ends the fit with FF_CANCELLED. May be set by a signal handler or another
     * thread. */
    const volatile int *cancel;
    /** Called between steps of the solver: iterations so far and the objective. May be NULL. */
    void (*progress)(void *context, int iteration, double objective);
    void *progress_context;
    /** Up to this many channels all parameters are solved for together, and all their correlations are given. Beyond, time and
     * memory are linear in the channels: see ff_fit_result. The optimum and the standard errors are the same. FF_DENSE_CHANNELS. */
    size_t dense_channels;
    ff_error_source errors; /**< FF_ERRORS_NOISE                                                                 */
    const ff_noise *noise;  /**< the noise of the data, borrowed; NULL: estimated from the residuals. Its levels are one, or one
                                 for each channel of the problem. Also the scale of a robust loss whose robust_scale is 0 */
    /** What the data are means over, borrowed while a problem is made; NULL or a point: values at single directions. The model is
     * then that mean too (ff_aperture.h), to FF_APERTURE_OF_FITS of its value. */
    const ff_aperture *aperture;
} ff_fit_options;
enum { FF_DENSE_CHANNELS = 8, FF_THREADS_MOST = 1024 };

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. A program that was compiled with an
 * older header has shorter options; what it does not know of is as by default. */
FF_API void ff_fit_options_init_size(ff_fit_options *o, size_t size);
static inline void ff_fit_options_init(ff_fit_options *o)
{
    ff_fit_options_init_size(o, sizeof *o);
}

/** What was kept and why the rest was not. Made by a problem and only looked at; later versions may have more members at its end.
 */
typedef struct ff_selection {
    size_t samples; /**< in the table                                                              */
    size_t used;
    size_t invalid;         /**< the file says: not a measurement (or not finite, or without a usable sigma) */
    size_t below_horizon;   /**< a direction at or under the horizon                                       */
    size_t grazing;         /**< beyond max_theta                                                          */
    size_t negative;        /**< used samples with a negative value in at least one channel                */
    size_t dropped;         /**< left out for a negative value, with drop_negative                         */
    size_t saturated;       /**< values (of used samples, by channel) at or above the saturation           */
    size_t below_noise;     /**< values below the noise floor                                              */
    size_t at_top;          /**< used samples at the very largest value of a channel, if several at places that
                                 have nothing else in common, as where a detector saturates; else 0         */
    double top;             /**< that value, 1/sr                                                          */
    size_t n_channels;      /**< of the problem                                                            */
    ff_weighting weighting; /**< the one AUTO stood for                                                   */
    int isotropic;          /**< of the table                                                              */
    size_t copies;          /**< left out: the same directions and values as another sample, to the last bit  */
    ff_brightest brightest; /**< where the data are brightest, and how much they reflect at least            */
} ff_selection;

/** Samples ready to be fitted to. Closed. */
typedef struct ff_problem ff_problem;

/** Selects the samples of t by o and computes the geometry that the n_models models (at least one) will need, and no other:
 *  only these may be fitted to it. t and models may be freed afterwards.
 *  FF_ERR_DATA when nothing usable is left (the message counts why), FF_ERR_RANGE for an option, FF_ERR_UNSUPPORTED for
 *  a weighting the table does not offer, FF_ERR_MEMORY. *out is written only on FF_OK. */
FF_API ff_status ff_problem_new(const ff_table *t, const ff_model *const *models, size_t n_models, const ff_fit_options *o,
                                ff_problem **out, ff_error *err);
FF_API void ff_problem_free(ff_problem *p); /**< NULL is allowed */

/** What it has selected. Belongs to p. */
FF_API const ff_selection *ff_problem_selected(const ff_problem *p);

/** Name of its channel c, "mean" of an average; NULL when there is none. Belongs to p. */
FF_API const char *ff_problem_channel_name(const ff_problem *p, size_t c);

/** What a 95 % interval rests on. */
typedef enum ff_interval {
    FF_INTERVAL_NONE = 0,      /**< there is none: held, or the data say nothing                        */
    FF_INTERVAL_WALD = 1,      /**< the standard error, with Student's t, in the fit's coordinates      */
    FF_INTERVAL_ONE_SIDED = 2, /**< from the bound to where the objective, from its slope and curvature there, has
                                    risen by what one parameter's 95 % allow                            */
    FF_INTERVAL_PROFILE = 3,   /**< the profile of the objective: ff_trust_profile                      */
    FF_INTERVAL_BOOTSTRAP = 4, /**< refits to resampled incident directions: ff_trust_bootstrap         */
    FF_INTERVAL_JACKKNIFE = 5  /**< one incident direction after another left out: ff_trust_jackknife   */
} ff_interval;
enum { FF_INTERVAL_COUNT = 6 };
FF_API const char *ff_interval_name(int interval); /**< "standard-error", ...; NULL for a number that is none */

/** One fitted number. Belongs to its result and is only looked at; later versions may have more members at its end. */
typedef struct ff_fit_value {
    double value;
    double std_error; /**< NaN when held, on a bound, or not determined by the data           */
    double low, high; /**< 95 % interval; NaN when there is none                              */
    ff_interval interval;
    int at_bound;                /**< -1 on its lower bound, +1 on its upper, 0 otherwise                */
    int held;                    /**< 1: not fitted (fixed by the shape, or held at its initial value)   */
    int tied;                    /**< 1: not a parameter of its own, equal to another one (alpha_y of an isotropic shape) */
    ff_param_ref follows;        /**< of a tied one: that parameter; else none                                 */
    size_t follows_channel;      /**< and its channel, 0 for a shared one                                      */
    double prior_mean, prior_sd; /**< NaN where it had no prior                                           */
    int column;                  /**< its number among those that have a standard error, -1 when it has none */
    double carriers; /**< number of equal values that carry it as well: (sum v)^2 / sum v^2 of the shares v of its variance; NaN
                          where it was not counted                                       */
    double
        residual_error; /**< its standard error by the residuals alone, HC3 (MacKinnon and White 1985), independent; NaN likewise */
    int weightless;     /**< 1: what it belongs to adds nothing to the model here, as a lobe whose ks or F0 is 0: its value means
                           nothing */
    double student_t;   /**< half-width of the 95 % interval by its standard error, in units of that; 0 when it has none */
} ff_fit_value;

/** Orientation-free description of the roughness of the first lobe: alpha_major >= alpha_minor along phi and phi + pi/2. */
typedef struct ff_ellipse {
    double alpha_major, alpha_minor, phi; /**< phi in [0, pi)                         */
    double phi_std_error;                 /**< radians; NaN when not determined       */
    int phi_determined;                   /**< 0: the two axes differ by less than their error, or the shape is isotropic */
} ff_ellipse;

/** What was found, and how well. Closed: read by the functions below; what they hand out by pointer belongs to the result. */
typedef struct ff_fit_result ff_fit_result;

FF_API void ff_fit_result_free(ff_fit_result *r); /**< NULL is allowed */

FF_API const ff_model *ff_fit_result_model(const ff_fit_result *r); /**< as it was fitted, with what was held and bounded      */
FF_API ff_shape ff_fit_result_shape(const ff_fit_result *r);        /**< never AUTO                                            */
FF_API ff_outcome ff_fit_result_outcome(const ff_fit_result *r);    /**< how it ended                                          */
FF_API int ff_fit_result_iterations(const ff_fit_result *r);        /**< solver steps on all samples                           */
FF_API int ff_fit_result_passes(const ff_fit_result *r);            /**< passes over all samples, the final ones included      */
FF_API double ff_fit_result_seconds(const ff_fit_result *r);        /**< wall clock                                            */
FF_API size_t ff_fit_result_channel_count(const ff_fit_result *r);  /**< of its problem */
FF_API size_t ff_fit_result_free_count(const ff_fit_result *r);     /**< free parameters, those on a bound not counted         */

/** A number of the result: the parameter at a place of its model, in channel c where it has a value in each (else c is not read).
 *  NULL when there is no such parameter or channel. */
FF_API const ff_fit_value *ff_fit_result_at(const ff_fit_result *r, ff_param_ref ref, size_t c);

/** The same by the name of the parameter: "alpha_x", "lobe2.f0". */
FF_API const ff_fit_value *ff_fit_result_find(const ff_fit_result *r, const char *name, size_t c);

/** Fills shape [n_shape] and channel [n_channels][n_channel] with the values that were found, for ff_model_eval. Either may be
 * NULL. */
FF_API void ff_fit_result_values(const ff_fit_result *r, double *shape, double *channel);

/** Correlation of two numbers of the result, places as ff_fit_result_at: 1 or -1 where the data see only one combination of them.
 * NaN where one of them has no standard error, and between parameters of different channels when there are more channels than
 *  dense_channels, since it is not formed then. */
FF_API double ff_fit_result_correlation(const ff_fit_result *r, ff_param_ref a, size_t channel_a, ff_param_ref b, size_t channel_b);

FF_API const ff_ellipse *ff_fit_result_ellipse(const ff_fit_result *r); /**< NULL: the first lobe has no stretch */

/** How far the model is from the data: weighted root-mean-square residuals over all used samples and channels, whichever loss was
 *  minimised. */
FF_API double ff_fit_result_objective(const ff_fit_result *r);     /**< what was minimised, of the data alone                 */
FF_API double ff_fit_result_prior_penalty(const ff_fit_result *r); /**< what priors add to it                                 */
FF_API double ff_fit_result_rmse(const ff_fit_result *r);          /**< of f - y, 1/sr                                        */
FF_API double ff_fit_result_max_abs(const ff_fit_result *r);       /**< largest |f - y|, 1/sr, not weighted                   */
/** The same by the measure of a loss, in ff_loss_info.rmse_unit; NaN of a loss that is no measure. */
FF_API double ff_fit_result_loss_rmse(const ff_fit_result *r, ff_loss loss);

/** n ln(2 objective / n) + 2k and + k ln n over n = used * channels residuals, k = free parameters + 1; with sigma weights
 *  2 objective + 2 k, + k ln n, of k free parameters. The lower the better, of fits to the same problem. */
FF_API double ff_fit_result_aic(const ff_fit_result *r);
FF_API double ff_fit_result_bic(const ff_fit_result *r);

/** What the data can tell; only with std_errors. Rank and condition of the Jacobian of the parameters that are not on a bound, each
 *  column scaled to unit length. Residuals of neighbouring samples go together over `correlated_over` samples (1: not at all), so
 *  that the values count as `effective_samples` independent ones (else as many as there are). Not settled (0): further than can be
 *  seen; the standard errors are then lower bounds. */
FF_API size_t ff_fit_result_rank(const ff_fit_result *r);
FF_API double ff_fit_result_condition(const ff_fit_result *r);
FF_API double ff_fit_result_effective_samples(const ff_fit_result *r);
FF_API size_t ff_fit_result_correlated_over(const ff_fit_result *r);
FF_API int ff_fit_result_correlation_settled(const ff_fit_result *r);

/** The noise of the data as the errors have it; NULL where they rest on the residuals alone. Belongs to r. */
FF_API const ff_noise *ff_fit_result_noise(const ff_fit_result *r);

/** What the result should be taken with, in the order in which a person should read it; NULL when i >= count. */
FF_API size_t ff_fit_result_warning_count(const ff_fit_result *r);
FF_API const ff_warning *ff_fit_result_warning(const ff_fit_result *r, size_t i);

/* ---- fitting --------------------------------------------------------------------------------- */

/** Estimates the scale of a robust loss from the residuals of m: for every value a standard deviation, by the median absolute
 * residual of values of about its magnitude (Hampel 1974). It stays with p and serves all fits whose robust_scale is 0, so that
 * these minimise the same objective; a first such fit makes it by its own model when there is none. Errors as ff_problem_fit. */
FF_API ff_status ff_problem_estimate_scale(ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_error *err);

/** Weighs every value of p by the noise that a fit to p has found, 1 / its standard deviation at the model's value: a fit to p is
 * from now on the quasi-likelihood estimate (Carroll and Ruppert 1988), whatever the loss, which scatters less than any other where
 * the noise is as it is taken to be, and most of all where few values lie on the lobe. For FF_WEIGHT_NOISE; again by another fit.
 * FF_ERR_DATA where the fit has found no noise (its residuals are rounding, or its errors were not by the noise);
 * FF_ERR_UNSUPPORTED with a robust loss; FF_ERR_MEMORY: p is as it was. */
FF_API ff_status ff_problem_weigh_by_noise(ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_error *err);

/** Fits m to the samples of p. FF_ERR_UNKNOWN and others as ff_constraints_check. Options must be those p was made with, as far as
 * they concern the selection. FF_ERR_DATA (fewer residuals than parameters), FF_ERR_RANGE, FF_ERR_UNSUPPORTED (a shape the model
 * cannot take), FF_ERR_CANCELLED, FF_ERR_MEMORY. *out is written only on FF_OK; release it with ff_fit_result_free. */
FF_API ff_status ff_problem_fit(const ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result **out,
                                ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
