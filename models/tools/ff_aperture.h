/** @file ff_aperture.h  What a detector of finite size reads of a model: the mean over its aperture.
 *
 *  A detector covers more than one direction. What an instrument writes as f(wi, wo) is the power that it caught, by the solid
 * angle of its aperture and the cosine of the aperture's centre: (1 / (W cos theta_o)) times the integral of f cos over the solid
 * angle W (ASTM E1392 and SEMI ME1392 define the BSDF so). For a lobe that is narrow beside the aperture that is broader and lower
 * than f.
 *
 *  Below the horizon f is 0, as a surface is opaque: what of an aperture hangs there catches nothing, and still counts in W.
 *
 *  Quadrature  in polar coordinates about the centre of a disc, in tangents of the angles of a rectangle. The order that a pair
 *           begins with follows from the width of the narrowest lobe beside the aperture, and doubles until two orders agree to
 *           FF_APERTURE_TOLERANCE, or 65,536 nodes are reached; the difference of the two is the error that is reported. The
 *           derivatives are those of the last sum, to the last digit.
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
} ff_aperture;

#define FF_APERTURE_MOST      0.5  /**< radians: what is larger is no goniometer's detector */
#define FF_APERTURE_TOLERANCE 1e-7 /**< of a value, between two orders                      */

/** f as ff_model_eval gives it, averaged over the aperture about each wo; a point gives the same bits as that function.
 *  @param shape, channel, w, f, df, ld  as ff_model_eval; 0 where wi or the centre lies at or below the horizon
 *  @param error  [n] out, or NULL: the largest difference of the last two orders by the value, over channels
 *  FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_eval; FF_ERR_RANGE for an aperture that is none; FF_ERR_MEMORY. */
FF_API ff_status ff_aperture_eval(const ff_aperture *a, const ff_model *m, ff_isa isa, size_t n_channels, const double *shape,
                                  const double *channel, const ff_dirs *w, size_t n, double *f, double *df, double *error,
                                  size_t ld);

#ifdef __cplusplus
}
#endif
#endif
