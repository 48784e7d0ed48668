/** @file ff_picture.h  Pictures of a lit sphere: how different two reflectances look, and which loss of a fit looks best.
 *
 *  The losses of a fit weigh highlight against haze against diffuse reflection each in its own way, and where the model is not the
 *  surface none of them is best for every surface. So every one is minimised, and of the fits the one is taken whose pictures are
 *  nearest to those of the data: candidates from the reflectance alone, the choice among them by appearance, as in Bieron and Peers
 *  2020 ("An adaptive BRDF fitting metric"). Lights, exposure and the measure below are our own.
 *
 *  Picture    a unit sphere of FF_PICTURE_SIZE^2 pixels, seen along -z from far away, x to the right and y up, under one distant
 *             light. Pixel (i, j), j counted from the top, is the point with x = (2i+1)/size - 1, y = 1 - (2j+1)/size. Its normal
 *             is n = (x, y, z), its tangent the direction of the parallel, (0, 1, 0) x n scaled to length 1. Its radiance is
 *             f(wi, wo) cos(theta_i).
 *  Lights     FF_PICTURE_LIGHTS of them, 15, 45, 75, 105 and 135 degrees from the view, each turned by 72 degrees about it from the
 *             one before: from the front to behind the sphere. Under one light all pixels have the same angle between light and
 *             half vector, half of that.
 *  Exposure   one for all lights and channels: the largest channel's radiance is below 1 for FF_PICTURE_QUANTILE of the pixels.
 *  Tone       e / (1 + e) of the exposed radiance (Reinhard et al. 2002, eq. 3), negative values as 0, then the curve of sRGB (IEC
 *             61966-2-1): white, which is 1, is never reached, and highlights stay apart.
 *  Difference root mean square of the difference of tones over pixels of all lights and over channels: 0 to 1, 1/255 is a step of
 * an 8-bit image. Pixels     count when the surface there is lit and seen at angles up to max_theta and the table says something of
 * the pair of directions, or of light and view exchanged (ff_interpolant_eval_reciprocal); the others are left out and counted.
 *  Errors     ff_status and ff_error; outputs are written only on FF_OK.
 *  Threads    no global state; a picture is immutable and may be compared with from any number of threads. Results do not depend on
 *             the number of threads. */
#ifndef FF_PICTURE_H
#define FF_PICTURE_H
#include "ff_api.h"
#include "ff_fit.h"
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_PICTURE_SIZE = 96, FF_PICTURE_LIGHTS = 5 };
#define FF_PICTURE_QUANTILE 0.95
#define FF_PICTURE_COVERED  0.25 /**< share of the pixels with data below which ff_fit_adaptive warns */
#define FF_PICTURE_SAME     1e-6 /**< differences that are no further apart count as equal: roundings of exact fits */

/** Unit vector to light k < FF_PICTURE_LIGHTS, in the frame of the picture. */
FF_API void ff_picture_light(size_t k, double light[3]);

/** Pairs of directions of the pixels whose light and view are within max_theta (radians) of the normal, in the frame of the surface
 *  there (tangent, bitangent, normal).
 *  @param light  [3]  unit vector, in the frame of the picture
 *  @param w      six planes wix wiy wiz wox woy woz, of FF_PICTURE_SIZE^2 at most; NULL: not wanted
 *  @param pixel  [as w]  j FF_PICTURE_SIZE + i; NULL: not wanted
 *  @return how many; 0 for a max_theta outside of (0, pi/2] */
FF_API size_t ff_picture_directions(const double light[3], double max_theta, double *const w[6], size_t *pixel);

/** Tone of an exposed radiance, in [0, 1). */
FF_API double ff_picture_tone(double exposed);

typedef struct ff_picture_coverage {
    size_t pixels;   /**< lit and seen within max_theta, over all lights */
    size_t measured; /**< of these, where the table has a value           */
} ff_picture_coverage;

/** The pictures of a table under all lights. */
typedef struct ff_picture ff_picture;

/** Makes the pictures of t. Of o it reads max_theta, channels, only_channel (as ff_problem_new), threads and cancel. t may be freed
 *  afterwards.
 *  FF_ERR_DATA when no pixel has data or none is brighter than 0, FF_ERR_RANGE for an option, FF_ERR_CANCELLED, FF_ERR_MEMORY.
 *  *out is released with ff_picture_free. */
FF_API ff_status ff_picture_new(const ff_table *t, const ff_fit_options *o, ff_picture **out, ff_error *err);
FF_API void ff_picture_free(ff_picture *p);
FF_API ff_picture_coverage ff_picture_covered(const ff_picture *p);
FF_API size_t ff_picture_channels(const ff_picture *p);
FF_API double ff_picture_exposure(const ff_picture *p); /**< what radiances are multiplied by, sr */

/** Difference between the pictures of the table and those of a model under the same lights and exposure, over the pixels that have
 *  data.
 *  @param shape    [n_shape]                         see ff_model_check
 *  @param channel  [ff_picture_channels][n_channel]
 *  Errors as ff_model_eval. */
FF_API ff_status ff_picture_difference(const ff_picture *p, const ff_model *m, const double *shape, const double *channel,
                                       double *out, ff_error *err);

/* ---- the loss of a fit by pictures ----------------------------------------------------------- */

/** Fits with every loss, and which of them looks best. Closed; what its functions hand out by pointer belongs to it. */
typedef struct ff_adaptive ff_adaptive;

/** Fits m to t with every loss and chooses the fit whose pictures differ least from those of the table; of several within
 *  FF_PICTURE_SAME of the least the first. Fits that did not converge are chosen only when none did. With sigma weights the linear
 *  losses are one and the same, (f - y) / sigma, and `cosine` stands for them.
 *
 *  @param o  o->loss is not read. Robust losses are FF_ERR_UNSUPPORTED: their scale is in units of the residual, which are each
 *            loss's own. Starts (start_shape) are used for every loss.
 *  A warning of the chosen fit says when fewer than FF_PICTURE_COVERED of the pixels have data.
 *  Errors as ff_picture_new, ff_problem_new and ff_problem_fit; a fit that is cancelled is FF_ERR_CANCELLED. *out is released with
 *  ff_adaptive_free. */
FF_API ff_status ff_fit_adaptive(const ff_table *t, const ff_model *m, const ff_fit_options *o, ff_adaptive **out, ff_error *err);
FF_API void ff_adaptive_free(ff_adaptive *a); /**< NULL is allowed */

/** The fits, candidates 0 .. count-1 in the order of ff_loss. For another k: a loss without a name, NaN, NULL. */
FF_API size_t ff_adaptive_count(const ff_adaptive *a);
FF_API size_t ff_adaptive_chosen(const ff_adaptive *a);               /**< the one that was chosen                   */
FF_API ff_loss ff_adaptive_loss(const ff_adaptive *a, size_t k);      /**< what was minimised                        */
FF_API double ff_adaptive_difference(const ff_adaptive *a, size_t k); /**< of the pictures, as ff_picture_difference */
FF_API const ff_fit_result *ff_adaptive_fit(const ff_adaptive *a, size_t k);
FF_API ff_picture_coverage ff_adaptive_coverage(const ff_adaptive *a);

/** The samples as the chosen loss has them, for ff_trust.h. */
FF_API const ff_problem *ff_adaptive_problem(const ff_adaptive *a);

#ifdef __cplusplus
}
#endif
#endif
