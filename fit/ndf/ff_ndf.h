/** @file ff_ndf.h  The distribution of normals behind measured data, without a formula for it.
 *
 *  An isotropic D(theta) on a lattice of angles is found together with F0 and a diffuse kd per channel by the least squares of a
 *  fit (loss and weights as in ff_fit.h), with a masking that is always that of the D at hand; integral D cos = 1, and D does not
 *  rise with theta. It starts from samples that look back along the light, where the data have them, by the power iteration of
 *  Dupuy et al. 2015, else from the best parametric fit. How smooth D is, by default, is left to cross-validation. fit/ndf.c says
 *  what is minimised.
 *
 *      ff_ndf_options o;
 *      ff_ndf_options_init(&o);
 *      ff_ndf_problem_new(table, &o, &problem, &err);
 *      ff_ndf_retrieve(problem, &o, &result, &err);
 *      for (size_t k = 0; k < ff_ndf_result_row_count(result); k++) ... ff_ndf_result_row(result, k)->d
 *      ff_ndf_result_free(result);
 *      ff_problem_free(problem);
 *
 *  Memory, errors, threads: as ff_fit.h. */
#ifndef FF_NDF_H
#define FF_NDF_H
#include "ff_api.h"
#include "ff_fit.h"
#include "ff_profile.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Fits that go with a retrieval, each with the masking asked for, schlick and lambert; FF_NDF_TABULATED is the retrieved one
 * itself, as the model `tabulated` with alpha = 1. */
enum { FF_NDF_BECKMANN = 0, FF_NDF_GGX = 1, FF_NDF_STUDENT_T = 2, FF_NDF_TABULATED = 3, FF_NDF_FITS = 4 };

/** What must not rise with the angle: the density of slopes D cos^4, which lets D rise as that of ggx with alpha > 1 or of
 * student-t with gamma < 2 does, or D itself. */
typedef enum ff_ndf_monotone { FF_NDF_MONOTONE_SLOPES = 0, FF_NDF_MONOTONE_D = 1 } ff_ndf_monotone;
enum { FF_NDF_MONOTONE_COUNT = 2 };
FF_API const char *ff_ndf_monotone_name(int monotone); /**< as on the command line; NULL for a number that is none */
FF_API int ff_ndf_monotone_find(const char *name);     /**< -1 when unknown                                         */

enum { FF_NDF_NODES_MIN = 31, FF_NDF_NODES_MAX = 100 };

/** Options; fill with ff_ndf_options_init, then change. */
typedef struct ff_ndf_options {
    size_t size;               /**< sizeof(ff_ndf_options)                                                              */
    const ff_fit_options *fit; /**< of selection and fits, with shape FF_SHAPE_ISOTROPIC and no robust loss; NULL: the defaults */
    int masking;               /**< index into the registry: smith-height-correlated                                     */
    double smooth;             /**< weight of the penalty, >= 0; NaN: chosen by cross-validation                          */
    ff_ndf_monotone monotone;  /**< FF_NDF_MONOTONE_SLOPES                                                               */
    int nodes;                 /**< of the lattice, FF_NDF_NODES_MIN .. FF_NDF_NODES_MAX; 0: by the range of the data      */
} ff_ndf_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_ndf_options_init_size(ff_ndf_options *o, size_t size);
static inline void ff_ndf_options_init(ff_ndf_options *o)
{
    ff_ndf_options_init_size(o, sizeof *o);
}

/** D is known where its relative standard error is at most this: 1.96 of it are a factor of 2 upwards. */
#define FF_NDF_KNOWN 0.25

/** One angle of the result. */
typedef struct ff_ndf_row {
    double theta;   /**< of the normal, radians                                                                  */
    double d;       /**< D, 1/sr                                                                                 */
    double error;   /**< relative standard error of F0 D, the smoothness taken for a guess; F0 and D share that of the area */
    double d_error; /**< the same of D                                                                          */
    int known;      /**< 1: both are at most FF_NDF_KNOWN, and half vectors reach here; 0: D is a continuation  */
} ff_ndf_row;

/** What one channel multiplies D with, and its diffuse part. */
typedef struct ff_ndf_channel {
    double f0, ks, kd;            /**< ks = 1 unless `scaled`                                                  */
    double scale_error, kd_error; /**< standard errors, of f0 or (scaled) of ks; NaN on a bound                 */
} ff_ndf_channel;

/** Roughness by several measures. Of the slopes q = tan theta with density P22 = D cos^4. */
typedef struct ff_ndf_measures {
    double half_width;    /**< angle at which D is half its peak, radians                          */
    double mean_slope;    /**< mean of q                                                           */
    double rms_slope;     /**< root of the mean of q^2, over the slopes that the data reach       */
    double beyond;        /**< share of the area, integral D cos, that lies beyond the data's reach */
    double alpha_peak;    /**< of the beckmann or ggx with the same D at the normal                */
    double beckmann_mean; /**< alpha of the beckmann with the same mean slope                      */
    double ggx_mean;      /**< alpha of the ggx with the same mean slope                           */
} ff_ndf_measures;

/** A distribution that was found. Closed: read by the functions below; what they hand out by pointer belongs to the result. */
typedef struct ff_ndf_result ff_ndf_result;

/** Selects the samples of t for a retrieval: a problem for the models of all its fits. Errors as ff_problem_new; FF_ERR_RANGE,
 *  FF_ERR_UNSUPPORTED for a masking that is made for one distribution only. */
FF_API ff_status ff_ndf_problem_new(const ff_table *t, const ff_ndf_options *o, ff_problem **out, ff_error *err);

/** Retrieves D from the samples of p, which ff_ndf_problem_new made with the same options. FF_ERR_DATA (too few samples or half
 *  vectors, no specular peak), FF_ERR_RANGE, FF_ERR_UNSUPPORTED (a robust loss; a problem made for other models or another shape),
 *  FF_ERR_CANCELLED, FF_ERR_MEMORY. *out is written only on FF_OK; release it with ff_ndf_result_free. */
FF_API ff_status ff_ndf_retrieve(const ff_problem *p, const ff_ndf_options *o, ff_ndf_result **out, ff_error *err);
FF_API void ff_ndf_result_free(ff_ndf_result *r); /**< NULL is allowed */

/** The distribution: rows by rising theta from 0, dense enough for the cubics of ff_profile_new. NULL when k >= count. */
FF_API size_t ff_ndf_result_row_count(const ff_ndf_result *r);
FF_API const ff_ndf_row *ff_ndf_result_row(const ff_ndf_result *r, size_t k);

/** What the channels multiply it with. NULL when c >= count. */
FF_API size_t ff_ndf_result_channel_count(const ff_ndf_result *r);
FF_API const ff_ndf_channel *ff_ndf_result_channel(const ff_ndf_result *r, size_t c);

FF_API const ff_ndf_measures *ff_ndf_result_measures(const ff_ndf_result *r); /**< roughness */
FF_API const ff_profile_table *ff_ndf_result_profile(const ff_ndf_result *r); /**< of the rows, for ff_model_set_table */

/** One of the fits, FF_NDF_BECKMANN .. FF_NDF_TABULATED; NULL for a number that is none. */
FF_API const ff_fit_result *ff_ndf_result_fit(const ff_ndf_result *r, int fit);
FF_API int ff_ndf_result_reference(const ff_ndf_result *r); /**< the fit that the smoothness draws to               */

FF_API double ff_ndf_result_first(const ff_ndf_result *r);     /**< smallest angle of a half vector, radians           */
FF_API double ff_ndf_result_reach(const ff_ndf_result *r);     /**< largest angle of a half vector, radians            */
FF_API double ff_ndf_result_sure(const ff_ndf_result *r);      /**< end of the first angles at which D is known; NaN: none */
FF_API double ff_ndf_result_smooth(const ff_ndf_result *r);    /**< weight of the penalty as used                      */
FF_API double ff_ndf_result_effective(const ff_ndf_result *r); /**< parameters that the data really determine          */
/** 1: the data ask for F0 > 1; F0 is 1 and the scale is ks, in all fits. */
FF_API int ff_ndf_result_is_scaled(const ff_ndf_result *r);
FF_API int ff_ndf_result_from_back_scatter(const ff_ndf_result *r); /**< 1: it started from the power iteration             */
FF_API double ff_ndf_result_objective(const ff_ndf_result *r);      /**< of the samples, without the penalty                */
FF_API ff_outcome ff_ndf_result_outcome(const ff_ndf_result *r);    /**< never FF_CANCELLED                                 */
FF_API double ff_ndf_result_seconds(const ff_ndf_result *r);        /**< wall clock, the fits included                      */

/** What it should be taken with; NULL when i >= count. */
FF_API size_t ff_ndf_result_warning_count(const ff_ndf_result *r);
FF_API const ff_warning *ff_ndf_result_warning(const ff_ndf_result *r, size_t i);

#ifdef __cplusplus
}
#endif
#endif
