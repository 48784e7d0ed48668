/** @file ff_aperture.h  What a detector of finite size reads of a model: the mean over its aperture.
 *
 *  A detector covers more than one direction. What an instrument writes as f(wi, wo) is the power that it caught, by the solid
 * angle of its aperture and the cosine of the aperture's centre: (1 / (W cos theta_o)) times the integral of f cos over the solid
 * angle W (ASTM E1392 and SEMI ME1392 define the BSDF so). For a lobe that is narrow beside the aperture that is broader and lower
 * than f.
 *
 *  Below the horizon f is 0, as a surface is opaque: what of an aperture hangs there catches nothing, and still counts in W.
 *
 *  A source that is seen under a cone is another mean, over incident directions that all carry the same power.
 *
 *  Quadrature  levels of 1, 4, 7, 16, 36 and 100 nodes over a disc (1, 4, 9, 16, 36 and 100 over a rectangle), and from 144 to
 * 9,216 that crowd where the narrowest lobe is, with as many over the source as go with them; a pair has the first level that
 *           differs from the next by FF_APERTURE_TOLERANCE of its value at most, and that difference is the error that is reported.
 *           Where a bound says so, from the width of the lobe beside the aperture, the centre alone is looked at. The derivatives
 *           are those of the sum, to the last digit.
 *  Frame, errors  as ff_model.h: outputs are written only on FF_OK, or not read after an error.
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_APERTURE_H
#define FF_APERTURE_H
#include "ff_api.h"
#include "ff_model.h"
#ifdef __cplusplus
extern "C" {
#endif

/** The outline of an aperture, seen from the sample. */
typedef enum ff_aperture_outline {
    FF_APERTURE_DISC = 0,     /**< a cone about the centre                                                   */
    FF_APERTURE_RECTANGLE = 1 /**< sides along theta and across it; at the normal along x and y               */
} ff_aperture_outline;

/** Half angles, radians, in [0, FF_APERTURE_MOST]: of a disc both are one, and `across` is not read. All 0: a point. */
typedef struct ff_aperture {
    ff_aperture_outline outline;
    double half, across;
    double source; /**< of the cone of incident directions about each wi */
} ff_aperture;

#define FF_APERTURE_MOST      0.5  /**< radians: what is larger is no goniometer's detector */
#define FF_APERTURE_TOLERANCE 1e-7 /**< of a value, between a level and the next             */
#define FF_APERTURE_OF_FITS   1e-4 /**< the same in a fit: little beside the noise of data   */

enum { FF_APERTURE_TEXT = 80 }; /**< size of a buffer for one in words */

/** Reads half angles in degrees and an outline: "0.75", "0.75:disc", "0.75:square", or "0.5x1", along theta and across it; the
 * source stays as it is in *out. FF_ERR_SYNTAX, FF_ERR_RANGE beyond FF_APERTURE_MOST; *out is written only on FF_OK. */
FF_API ff_status ff_aperture_parse(const char *text, ff_aperture *out);

/** The same the other way, the source left out. Returns out. */
FF_API char *ff_aperture_text(const ff_aperture *a, char out[FF_APERTURE_TEXT]);

/** f as ff_model_eval gives it, averaged over the aperture about each wo and the source about each wi; a point gives the same bits
 * as that function.
 *  @param shape, channel, w, f, df, ld  as ff_model_eval; 0 where wi or the centre lies at or below the horizon
 *  @param error  [n] out, or NULL: the difference to the next level by the value, the largest of the channels; at most
 *         FF_APERTURE_TOLERANCE unless the last level does not reach it, as where the horizon cuts an aperture that a lobe fills
 *  FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_eval; FF_ERR_RANGE for an aperture that is none; FF_ERR_MEMORY. */
FF_API ff_status ff_aperture_eval(const ff_aperture *a, const ff_model *m, ff_isa isa, size_t n_channels, const double *shape,
                                  const double *channel, const ff_dirs *w, size_t n, double *f, double *df, double *error,
                                  size_t ld);

#ifdef __cplusplus
}
#endif
#endif
