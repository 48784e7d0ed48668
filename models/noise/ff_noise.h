/** @file ff_noise.h  How large the errors of measured values are.
 *
 *  For the newcomer: a detector errs by so many per cent of what it sees, and never by less than its dark noise.
 *
 *      sigma^2 = (a + b f + c f^2) cos^p(theta_i) cos^q(theta_o)
 *
 *  f the true BRDF in 1/sr; a, b, c >= 0: noise that is always there, (1/sr)^2; of counted photons, 1/sr; and in proportion to the
 *  value. a, b, c belong to a channel or to all; p and q to all. Errors of neighbours along a scan, and of the channels of a
 * sample, may go together: their correlations are part of the model.
 *
 *  Errors   ff_status and ff_error; outputs are written only on FF_OK.
 *  Threads  no global state; a const ff_noise may be read from many threads at once. */
#ifndef FF_NOISE_H
#define FF_NOISE_H
#include "ff_api.h"
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

/** a, b, c of a channel. */
typedef struct ff_noise_level {
    double constant; /**< a, (1/sr)^2: sqrt(a) is the noise where nothing is reflected */
    double linear;   /**< b, 1/sr                                                      */
    double square;   /**< c: sqrt(c) is the relative noise of large values             */
} ff_noise_level;

enum { FF_NOISE_LAGS = 24 }; /**< neighbours along a scan whose correlation is known */

/** Closed. */
typedef struct ff_noise ff_noise;

/** From its numbers.
 *  @param level     [n_levels]; n_levels is 1 for all channels, or the number of channels
 *  @param cos_i     p
 *  @param cos_o     q
 *  FF_ERR_RANGE for a number that is not finite, a level below 0 or one that is all 0; FF_ERR_MEMORY. Release with ff_noise_free.
 */
FF_API ff_status ff_noise_new(const ff_noise_level *level, size_t n_levels, double cos_i, double cos_o, ff_noise **out,
                              ff_error *err);
FF_API void ff_noise_free(ff_noise *n); /**< NULL is allowed */

/** Reads "relative=0.05,floor=0.0003,counts=1e-5,cos_i=-1,cos_o=0": sqrt(c), sqrt(a) in 1/sr, b in 1/sr, p and q; what is left out
 *  is 0. FF_ERR_SYNTAX, FF_ERR_UNKNOWN (a name), FF_ERR_RANGE, FF_ERR_MEMORY. */
FF_API ff_status ff_noise_parse(const char *text, ff_noise **out, ff_error *err);

/** Levels: 1 for all channels, or one for each. */
FF_API size_t ff_noise_level_count(const ff_noise *n);
FF_API ff_noise_level ff_noise_level_at(const ff_noise *n, size_t channel); /**< of a channel; all 0 of one that has none */
FF_API double ff_noise_cos_i(const ff_noise *n);                            /**< p            */
FF_API double ff_noise_cos_o(const ff_noise *n);                            /**< q            */

/** Correlation of the errors of samples that are `lag` apart along a scan, in [-1, 1]; 1 at lag 0, 0 beyond FF_NOISE_LAGS. */
FF_API double ff_noise_along_scan(const ff_noise *n, size_t lag);
/** Correlation of the errors of two channels of one sample, a mean over their pairs. */
FF_API double ff_noise_between_channels(const ff_noise *n);

/** Standard deviation of a value, 1/sr; NaN of a channel that has none.
 *  @param f             the BRDF, 1/sr; below 0 as 0
 *  @param cos_i, cos_o  in (0, 1] */
FF_API double ff_noise_sd(const ff_noise *n, size_t channel, double f, double cos_i, double cos_o);

#ifdef __cplusplus
}
#endif
#endif
