/* Fits as plain values: what ff_fit.h closes to others. */
#ifndef FF_FIT_STRUCT_H
#define FF_FIT_STRUCT_H
#include "data_formats/table/table_struct.h"
#include "ff_fit.h"
#include "fit/warning/warning_struct.h"
#include "models/model_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Weighted root-mean-square residuals over all used samples and channels, whichever loss was minimised. */
typedef struct ff_residual {
    double objective;      /**< what was minimised                                   */
    double rmse;           /**< f - y, 1/sr                                          */
    double cosine_rmse;    /**< (f - y) cos(theta_i), 1/sr                           */
    double log_rmse;       /**< of FF_LOSS_LOG                                       */
    double cube_root_rmse; /**< of FF_LOSS_CUBE_ROOT                                 */
    double max_abs;        /**< largest |f - y|, 1/sr, not weighted                  */
    /** Of every loss that is a measure, the three above among them, in ff_loss_info.rmse_unit; NaN of those that are none. */
    double loss_rmse[FF_LOSS_COUNT];
} ff_residual;

struct ff_fit_result {
    ff_model model;
    ff_shape shape; /**< never AUTO                                               */
    ff_outcome outcome;
    int iterations; /**< solver steps on all samples                              */
    int passes;     /**< passes over all samples, the final ones included         */
    double time_s;  /**< wall clock                                               */
    size_t n_channels;
    ff_fit_value *shape_value;   /**< [model.n_shape]                                          */
    ff_fit_value *channel_value; /**< [n_channels][model.n_channel]                            */
    size_t n_columns;    /**< parameters with a standard error; with more channels than dense_channels those of the shape alone */
    double *correlation; /**< [n_columns][n_columns]; NULL when std_errors was 0       */
    /** With more channels than dense_channels, else NULL: [n_channels][model.n_channel][n_columns + model.n_channel], the
     * correlations of every parameter of a channel with the columns of correlation, then with the parameters of its channel; NaN
     * where one of the two has no standard error. Those between channels are not formed. */
    double *channel_correlation;
    int has_ellipse;
    ff_ellipse ellipse;
    ff_residual residual; /**< its objective is that of the data alone            */
    double prior_penalty; /**< what priors add to it                                */
    size_t n_free;        /**< free parameters                                          */
    /** What the data can tell; only with std_errors. Rank and condition of the Jacobian of the parameters that are not on a
     *  bound, each column scaled to unit length. Residuals of neighbouring samples go together over `correlated_over` samples
     *  (1: not at all), so that the values count as `effective_samples` independent ones (else as many as there are). */
    size_t rank;
    double condition;
    double effective_samples;
    size_t correlated_over;
    int correlation_settled;      /**< 0: further than can be seen; the standard errors are then lower bounds */
    double aic, bic;              /**< n ln(2 objective / n) + 2k and + k ln n over n = used * channels residuals, k = n_free + 1;
                                       with sigma weights 2 objective + 2 n_free, + n_free ln n     */
    struct ff_noise_found *noise; /**< of the data; NULL where there is none */
    ff_warnings warnings;         /**< what it should be taken with                            */
};

/* The selection into one of the caller's. */
void ff_problem_selection(const ff_problem *p, ff_selection *out);

/* ff_problem_new of models that lie side by side. */
ff_status ff_problem_make(const ff_table *t, const ff_model *models, size_t n_models, const ff_fit_options *o, ff_problem **out,
                          ff_error *err);

/* ff_problem_fit into a result of the caller's; and what releases what it owns. The options are as long as they are here. */
ff_status ff_problem_fit_into(const ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_fit_result *out, ff_error *err);
void ff_fit_result_clear(ff_fit_result *r);

/* The caller's options, or where they are shorter or longer than those of this library, *own made of them; NULL for FF_ERR_RANGE.
 */
const ff_fit_options *ff_fit_options_take(const ff_fit_options *o, ff_fit_options *own, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
