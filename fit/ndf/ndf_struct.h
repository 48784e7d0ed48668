/* Retrievals as plain values: what ff_ndf.h closes to others. */
#ifndef FF_NDF_STRUCT_H
#define FF_NDF_STRUCT_H
#include "ff_ndf.h"
#include "fit/interface/fit_struct.h"
#include "models/tools/profile_struct.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_NDF_MODELS = FF_NDF_FITS + 1 };

/* The models that a problem must be made for: those of the fits, each with `masking` (index into the registry), schlick and
 * lambert, and lambert alone. FF_ERR_RANGE; FF_ERR_UNSUPPORTED for a masking that is made for one distribution only. */
ff_status ff_ndf_models(int masking, ff_model out[FF_NDF_MODELS], ff_error *err);

struct ff_ndf_result {
    size_t n_rows, n_channels;
    ff_ndf_row *row;            /**< [n_rows] rising theta from 0, dense enough for the cubics of ff_profile_make     */
    ff_ndf_channel *channel;    /**< [n_channels]                                                                    */
    size_t n_nodes;             /**< of the lattice that was fitted                                                  */
    int reference;              /**< the fit that the smoothness draws to: FF_NDF_BECKMANN, ...                       */
    double first, reach;        /**< smallest and largest angle of the samples' half vectors, radians                */
    double sure;                /**< end of the first angles at which D is known, radians; NaN: none                  */
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
    ff_warnings warnings; /**< what it should be taken with                                                    */
};

/* Are the options, and those of the fits among them, in their ranges? Errors as ff_ndf_retrieve. */
ff_status ff_ndf_options_check(const ff_ndf_options *o, ff_error *err);

/* ff_ndf_retrieve into a result of the caller's; and what releases what it owns. o->fit is there, and the options are as long as
 * here. */
ff_status ff_ndf_retrieve_into(const ff_problem *p, const ff_ndf_options *o, ff_ndf_result *out, ff_error *err);
void ff_ndf_result_clear(ff_ndf_result *r);

#ifdef __cplusplus
}
#endif
#endif
