/** @file ff_ndf.h  The distribution of normals behind measured data, without a formula for it.
 *
 *  An isotropic D(theta) on a lattice of angles is found together with F0 and a diffuse kd per channel by the least squares of a
 *  fit (loss and weights as in ff_fit.h), with a masking that is always that of the D at hand; integral D cos = 1, and D does not
 *  rise with theta. It starts from samples that look back along the light, where the data have them, by the power iteration of
 *  Dupuy et al. 2015, else from the best parametric fit. How smooth D is, by default, is left to cross-validation. fit/ndf.c says
 *  what is minimised.
 *
 *      ff_model models[FF_NDF_MODELS];
 *      ff_ndf_models(masking, models, err);                                  // o.shape = FF_SHAPE_ISOTROPIC
 *      ff_problem_new(&table, models, FF_NDF_MODELS, &o, &problem, err);
 *      ff_ndf_retrieve(problem, &ndf_options, &result, err);
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

/** Fits that go with a retrieval; FF_NDF_TABULATED is the retrieved one itself, as the model `tabulated` with alpha = 1. */
enum { FF_NDF_BECKMANN = 0, FF_NDF_GGX = 1, FF_NDF_STUDENT_T = 2, FF_NDF_TABULATED = 3, FF_NDF_FITS = 4 };
enum { FF_NDF_MODELS = FF_NDF_FITS + 1 };

/** The models that a problem must be made for: those of the fits, each with `masking` (index into the registry), schlick and
 *  lambert, and lambert alone. FF_ERR_RANGE; FF_ERR_UNSUPPORTED for a masking that is made for one distribution only. */
FF_API ff_status ff_ndf_models(int masking, ff_model out[FF_NDF_MODELS], ff_error *err);

/** What must not rise with the angle: the density of slopes D cos^4, which lets D rise as that of ggx with alpha > 1 or of student-t
 *  with gamma < 2 does, or D itself. */
typedef enum ff_ndf_monotone { FF_NDF_MONOTONE_SLOPES = 0, FF_NDF_MONOTONE_D = 1 } ff_ndf_monotone;
enum { FF_NDF_MONOTONE_COUNT = 2 };
FF_API const char *ff_ndf_monotone_name(int monotone); /**< as on the command line; NULL for a number that is none */
FF_API int ff_ndf_monotone_find(const char *name);     /**< -1 when unknown                                         */

enum { FF_NDF_NODES_MIN = 31, FF_NDF_NODES_MAX = 100 };

/** Options; fill with ff_ndf_options_init. */
typedef struct ff_ndf_options {
    size_t size;              /**< sizeof(ff_ndf_options)                                                              */
    ff_fit_options fit;       /**< those the problem was made with; no robust loss                                      */
    int masking;              /**< index into the registry: smith-height-correlated                                     */
    double smooth;            /**< weight of the penalty, >= 0; NaN: chosen by cross-validation                          */
    ff_ndf_monotone monotone; /**< FF_NDF_MONOTONE_SLOPES                                                               */
    int nodes;                /**< of the lattice, FF_NDF_NODES_MIN .. FF_NDF_NODES_MAX; 0: by the range of the data      */
} ff_ndf_options;
FF_API void ff_ndf_options_init(ff_ndf_options *o);

/** One angle of the result. */
typedef struct ff_ndf_row {
    double theta; /**< of the normal, radians                                                                  */
    double d;     /**< D, 1/sr                                                                                 */
    double error; /**< relative standard error of F0 D, the smoothness taken for a guess; F0 and D share that of the area */
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

typedef struct ff_ndf_result {
    size_t n_rows, n_channels;
    ff_ndf_row *row;            /**< [n_rows] rising theta from 0, dense enough for the cubics of ff_profile_make     */
    ff_ndf_channel *channel;    /**< [n_channels]                                                                    */
    size_t n_nodes;             /**< of the lattice that was fitted                                                  */
    int reference;              /**< the fit that the smoothness draws to: FF_NDF_BECKMANN, ...                       */
    double first, reach;        /**< smallest and largest angle of the samples' half vectors, radians                */
    double sure;                /**< largest angle up to `reach` at which the error is below a half                  */
    ff_ndf_measures measures;   /**< of roughness                                                                    */
    int from_back_scatter;      /**< 1: it started from the power iteration                                          */
    size_t back_samples;        /**< those with wi and wo within `back_angle` of the half vector                     */
    double back_angle, back_f0; /**< radians; F0 of the power iteration, mean of the channels                        */
    int back_iterations;        /**< of the power iteration                                                          */
    double smooth;              /**< weight of the penalty as used                                                   */
    double effective;           /**< parameters that the data really determine: trace of the influence of the data   */
    int scaled;                 /**< 1: the data ask for F0 > 1; F0 is 1 and the scale is ks, in all fits            */
    double objective;           /**< of the samples, without the penalty                                             */
    ff_outcome outcome;         /**< never FF_CANCELLED                                                              */
    int iterations, passes;     /**< of the retrieval, on all samples and fewer                                      */
    double time_s;              /**< wall clock, the fits included                                                   */
    ff_profile_table *profile;  /**< made of the rows; fit[FF_NDF_TABULATED].model refers to it                      */
    ff_fit_result fit[FF_NDF_FITS];
    ff_warnings warnings;       /**< what it should be taken with                                                    */
} ff_ndf_result;

/** Retrieves D from the samples of p. FF_ERR_DATA (too few samples or half vectors, no specular peak), FF_ERR_RANGE,
 *  FF_ERR_UNSUPPORTED (a robust loss; a problem made for other models or another shape), FF_ERR_CANCELLED, FF_ERR_MEMORY.
 *  *out is written only on FF_OK; release it with ff_ndf_result_free. */
FF_API ff_status ff_ndf_retrieve(const ff_problem *p, const ff_ndf_options *o, ff_ndf_result *out, ff_error *err);
FF_API void ff_ndf_result_free(ff_ndf_result *r);

#ifdef __cplusplus
}
#endif
#endif
