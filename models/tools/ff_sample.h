/** @file ff_sample.h  Directions drawn in proportion to a model: for path tracing and for integrals over it.
 *
 *  A sampler draws wi for a given wo by one of several strategies: one for each lobe, one for each diffuse term (for each lobe,
 *  where the term works lobe by lobe). A strategy is chosen with a probability in proportion to the light that its part of the
 *  model reflects, taken from a table over wo.z that is averaged over azimuths and channels; none has less than one hundredth. The
 *  density is that of the mixture (one-sample balance heuristic), so that it is > 0 wherever the model is.
 *
 *    lobes of ggx, beckmann, beckmann-walter   visible normals h: density D(h) max(0, wo.h) / integral of the same, for any
 *                                              roughness, correlation and mean slope; wi = 2 (wo.h) h - wo
 *    lobes of other distributions              normals h: density D(h) h.z; for a density that covers no unit area (no
 *                                              FF_UNIT_AREA) D(h) itself over its integral; wi likewise
 *    what the lobes leave over                 wi.z from the table of (1 - a(mu)) mu, a the directional albedo (Kelemen and
 *                                              Szirmay-Kalos 2001, section 2.2.1)
 *    scatter of polished surfaces (abg,        wi.z (1 + (d / L)^2)^-p over its integral, d the difference of direction cosines
 *    harvey-shack, k-correlation)              between wi and the mirror direction, L and p those of the term
 *    other diffuse terms                       wi.z / pi
 *
 *  A mirrored direction may lie below the horizon. Such a sample is lost: it counts, with weight 0, and the density integrates
 *  over the upper hemisphere to the fraction of samples that are not lost, which is below 1. The mean of the weights is the
 *  directional albedo of wo.
 *
 *  Frame    as ff_model.h. All planes of several numbers are [count][ld]: ld = 1 and n = 1 make them plain vectors.
 *  Errors   only ff_sampler_new can fail. Nothing else allocates.
 *  Threads  a sampler does not change after it was made; every function may be called from many threads at once. */
#ifndef FF_SAMPLE_H
#define FF_SAMPLE_H
#include "ff_api.h"
#include "ff_model.h"
#ifdef __cplusplus
extern "C" {
#endif

typedef struct ff_sampler ff_sampler;

/** Makes a sampler for a model with its parameters; takes a millisecond, a few when terms are coupled. It keeps copies, but borrows
 * the profile table of a `tabulated` lobe, which must outlive it. Release with ff_sampler_free.
 *  @param shape    [n_shape]                 see ff_model_check
 *  @param channel  [n_channels][n_channel]
 *  *out is written only on FF_OK. FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_check; FF_ERR_UNSUPPORTED for an isa that is not
 *  available; FF_ERR_MEMORY. */
FF_API ff_status ff_sampler_new(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                ff_sampler **out, ff_error *err);
FF_API void ff_sampler_free(ff_sampler *s); /**< NULL is allowed */

/** Draws n directions wi, one for each wo.
 *  @param wo   [3][ld]  unit vectors; for wo.z <= FF_COS_MIN the sample is lost, with wi = -z
 *  @param u    [3][ld]  independent uniform numbers in [0, 1): the choice of the strategy, two for the direction
 *  @param roulette  [n] a fourth uniform number, or NULL. With it a path goes on with probability q, when the number is below q =
 *                   min(1, a), a the albedo of wo averaged over channels, by the sampler's table and at least 0.01 (Kelemen and
 *                   Szirmay-Kalos 2001, section 2.2.1). Weights are divided by q; those of a path that ends are 0.
 *  @param wi      [3][ld] out           unit vectors, below the horizon where the sample is lost
 *  @param pdf     [n] out               density of wi, 1/sr, roulette aside; 0 where the sample is lost
 *  @param f       [n_channels][ld] out  the model, 1/sr, as ff_model_eval; NULL = not needed
 *  @param weight  [n_channels][ld] out  f wi.z / pdf, over q with roulette
 *  @param ld      stride of a plane, >= n */
FF_API void ff_sampler_sample(const ff_sampler *s, size_t n, const double *wo, const double *u, const double *roulette, double *wi,
                              double *pdf, double *f, double *weight, size_t ld);

/** Density with which ff_sampler_sample draws wi for wo, 1/sr over the solid angle of wi; 0 where either is at or below the
 * horizon. Light that comes from there is lost, so that the integral over wi is below 1.
 *  @param wo   [3][ld]  unit vectors
 *  @param wi   [3][ld]
 *  @param pdf  [n] out */
FF_API void ff_sampler_pdf(const ff_sampler *s, size_t n, const double *wo, const double *wi, double *pdf, size_t ld);

#ifdef __cplusplus
}
#endif
#endif
