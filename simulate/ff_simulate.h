/** @file ff_simulate.h  Data sets made from a model: what an instrument would have measured, noise included.
 *
 *  Noise    y = f (1 + relative g1) + floor g2 with g1, g2 independent standard normal numbers for every sample and channel; or of
 *           a noise model y = f + sd g1, sd its standard deviation of f at these angles. They are a function of (seed, sample,
 * channel) alone, made by integer arithmetic and a rational approximation, so they are the same on every machine and do not depend
 * on how the work is divided. f itself may differ by rounding between instruction sets (see ff_isa). Errors   ff_status and
 * ff_error; outputs are written only on FF_OK. Threads  no global state; every function may be called from many threads at once. */
#ifndef FF_SIMULATE_H
#define FF_SIMULATE_H
#include "ff_aperture.h"
#include "ff_api.h"
#include "ff_model.h"
#include "ff_noise.h"
#include "ff_height_field.h"
#include "ff_table.h"
#include "ff_walk.h"
#ifdef __cplusplus
extern "C" {
#endif

/** Which pairs of directions are measured. */
typedef enum ff_sampling_kind {
    FF_SAMPLING_MERL = 0, /**< the 90 x 90 x 180 grid "merl" of ff_table.h; cells below the horizon are marked invalid        */
    FF_SAMPLING_GONIOMETER = 1, /**< theta_i 0, 15 .. 75; phi_i 0, 45, 90, 135 (0 alone when isotropic); theta_o 0 .. 85 and
                                     phi_o by step                                                                             */
    FF_SAMPLING_SCATTERED = 2   /**< random pairs, both directions uniform in solid angle down to 85 degrees                   */
} ff_sampling_kind;

typedef struct ff_sampling {
    ff_sampling_kind kind;
    double step_deg; /**< goniometer: in [0.5, 45]                                                              */
    size_t n;        /**< scattered: pairs, >= 1                                                               */
    double specular; /**< scattered: fraction in [0, 1] of pairs whose half vector is drawn near the normal (slope
                          log-uniform in 0.002 .. 1), so that glossy lobes are met                              */
} ff_sampling;

/** Reads "merl", "goniometer", "goniometer:STEP" (5 degrees unless given), "scattered:N" or "scattered:N:FRACTION".
 *  FF_ERR_UNKNOWN, FF_ERR_SYNTAX, FF_ERR_RANGE say what was expected. */
FF_API ff_status ff_sampling_parse(const char *text, ff_sampling *out, ff_error *err);

/** Options; fill with ff_simulate_options_init, then change. */
typedef struct ff_simulate_options {
    size_t size;          /**< sizeof(ff_simulate_options)                                                    */
    ff_sampling sampling; /**< goniometer, 5 degrees                                                          */
    double relative;      /**< standard deviation of the multiplicative noise, >= 0; 0                        */
    double floor;         /**< standard deviation of the additive noise, 1/sr, >= 0; 0                        */
    uint64_t seed;        /**< of the noise and of scattered directions; 1                                    */
    int sigma; /**< 1: the table carries the standard deviation of every value; needs noise, a walk or a surface. A value of exactly
                  0 under multiplicative noise alone has none: its sample is marked invalid        */
    int nonnegative; /**< 1: a value below 0 becomes 0 and the note counts them: for files that hold no negative values  */
    ff_isa isa;      /**< FF_ISA_BEST                                                                    */
    const volatile int *cancel; /**< polled; not NULL and != 0 ends with FF_ERR_CANCELLED                        */
    const ff_noise *noise; /**< NULL: relative and floor; else these are 0. Values are independent, whatever it says of neighbours
                                and channels. Of one level, or as many as channels; borrowed                    */
    const ff_aperture *aperture; /**< of the detector, borrowed; NULL: a point                                  */
    const ff_walk_options *walk; /**< borrowed: values are those of a walk on the surface of the model (ff_walk.h), each with its
                                      standard error, to which noise is added; the table has n_orders times as many channels,
                                      order by order, and no aperture. NULL: values of the model                     */
    const ff_height_field_options *surface; /**< the same of rays on a surface (ff_height_field.h), where `walk` is NULL; its own
                                            aperture is that of the values                                                       */
} ff_simulate_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_simulate_options_init_size(ff_simulate_options *o, size_t size);
static inline void ff_simulate_options_init(ff_simulate_options *o)
{
    ff_simulate_options_init_size(o, sizeof *o);
}

/** Makes a table of n_channels channels (named r, g, b when there are three, "f" when there is one, c0 ... otherwise).
 *  @param shape    [n_shape]                 see ff_model_check
 *  @param channel  [n_channels][n_channel]
 *  *out is written only on FF_OK; release it with ff_table_free. Samples whose f is not finite do not occur.
 *  FF_ERR_RANGE, FF_ERR_UNSUPPORTED (parameters, options), FF_ERR_MEMORY, FF_ERR_CANCELLED. */
FF_API ff_status ff_simulate(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                             const ff_simulate_options *o, ff_table **out, ff_error *err);

/** Standard normal number `index` of stream `stream` under a seed: the generator that ff_simulate uses, with stream = channel and
 *  index = 2 sample for g1, 2 sample + 1 for g2. Philox4x32-10 (Salmon et al. 2011), inverted by AS 241 (Wichura 1988). */
FF_API double ff_random_normal(uint64_t seed, uint32_t stream, uint64_t index);

/** Uniform number in (0, 1) of the same generator. */
FF_API double ff_random_uniform(uint64_t seed, uint32_t stream, uint64_t index);

#ifdef __cplusplus
}
#endif
#endif
