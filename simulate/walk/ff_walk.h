/** @file ff_walk.h  Smith's random walk: what a surface of microfacets reflects when light may meet it more than once, by
 * simulation.
 *
 *  Smith's surface is a cloud of facets whose slopes know nothing of their height or of their neighbours. A ray meets them as it
 * meets the particles of a cloud (Heitz, Hanika, d'Eon and Dachsbacher 2016, "Multiple-scattering microfacet BSDFs with the Smith
 * model"): it flies freely for a while, meets a facet in proportion to what the facets show to it, is reflected, and flies on,
 * until it leaves upwards. What leaves after one facet is the model D F G2 / (4 cos theta_i cos theta_o) with the height-correlated
 * G2 of Heitz 2014, equation 21; what leaves after two and more is what that model lacks.
 *
 *  Heights  A path knows its height only as C, the fraction of the surface that lies lower. Free flight changes ln C by
 *           cos(theta) / (what the facets show to the ray) times a number of exponential distribution, whatever the distribution of
 *           heights is: the result is the same for all of them, uniform and Gaussian among them.
 *  Normals  Drawn from D(m) max(0, -r.m), r the ray's direction, for rays that go up or down, from the profile p(q2) of the
 *           distribution alone: radii q of the unit surface from tables of the two cumulative masses of q p and q^2 p, a rejection
 *           for the rest, each rejected facet being one that the ray flies past. No Lambda is used for a path; of the values at
 * given directions it weighs the last step. Values   At given pairs of directions every facet that a path from wi meets adds F D(h)
 * / (4 N) C^Lambda(wo) / wo.z, h halfway between the ray and wo and N what the facets show to the ray: no cells, and no bias. Every
 * pair has paths of its own, so that the errors of two samples are independent. Frame    as ff_model.h. A lobe is that of light
 * from wi; the sum over directions of what is reflected. Model    One lobe, of a distribution that covers a unit area and whose
 * Lambda is Smith's (FF_UNIT_AREA, FF_WEAK_FURNACE), without a mean slope, masking smith-height-correlated, ks = 1. Its Fresnel
 * term acts at every facet. Numbers  Philox counters of seed, path and step: the bits depend neither on the number of threads nor
 * on how work is divided; by rounding on the instruction set (see ff_isa). Errors   ff_status and ff_error; outputs are written
 * only on FF_OK. Threads  a walk does not change after it was made; every function may be called from many threads at once. */
#ifndef FF_WALK_H
#define FF_WALK_H
#include "ff_api.h"
#include "ff_model.h"
#ifdef __cplusplus
extern "C" {
#endif

/** What a facet does with light. */
typedef enum ff_facets {
    FF_FACETS_MIRROR = 0, /**< reflects F of it; the rest is lost. The model has no base                                          */
    FF_FACETS_LAMBERT =
        1, /**< scatters kd of it evenly, kd that of the model's base `lambert`; the Fresnel term is not looked at  */
    FF_FACETS_COUPLED = 2 /**< reflects F, and scatters of what enters kd (1 - F(i)) (1 - F(o)) / (pi (1 - Fa)), Fa the mean of F
                               over the hemisphere: reciprocal (Shirley et al. 1997; Hammon 2017, appendix). kd as above          */
} ff_facets;

/** How rays that go down are stopped. */
typedef enum ff_walk_descent {
    FF_DESCENT_PROJECTED = 0, /**< by all that the facets show to them: Lambda(-w) = -1 - Lambda(w). Paths and their reverses have
                                   the same weight, so that the result is reciprocal (Heitz et al. 2016)                          */
    FF_DESCENT_SYMMETRIC = 1  /**< after the first facet as rays that go up the same way, Lambda(-w) = -Lambda(w), so that two
                                 heights  see each other alike (Hammon 2017, appendix). The result is not reciprocal  */
} ff_walk_descent;

/** Orders that are counted together: from first (>= 1) to last, 0 meaning without an end. */
typedef struct ff_orders {
    uint32_t first, last;
} ff_orders;
enum { FF_WALK_ORDERS = 16 };

/** Options; fill with ff_walk_options_init, then change. */
typedef struct ff_walk_options {
    size_t size;                      /**< sizeof(ff_walk_options)                                                    */
    ff_facets facets;                 /**< FF_FACETS_MIRROR                                                           */
    ff_walk_descent descent;          /**< FF_DESCENT_PROJECTED                                                       */
    uint64_t seed;                    /**< 1                                                                          */
    uint64_t paths;                   /**< from each direction, or for each pair, 2 .. 1e12; 10000                    */
    size_t n_orders;                  /**< 1 .. FF_WALK_ORDERS; 1                                                     */
    ff_orders orders[FF_WALK_ORDERS]; /**< {1, 0}: all. They may overlap                                     */
    int threads;                      /**< 0 .. 1024; 0: as many as the system lets run                                */
    ff_isa isa;                       /**< FF_ISA_BEST                                                       */
    const volatile int *cancel;       /**< polled; not NULL and != 0 ends with FF_ERR_CANCELLED              */
    void (*progress)(void *context, double done); /**< called by the caller's thread, done in [0, 1]; NULL: not */
    void *progress_context;
} ff_walk_options;

/** Writes the defaults into options of `size` bytes, the caller's sizeof, and nothing beyond. */
FF_API void ff_walk_options_init_size(ff_walk_options *o, size_t size);
static inline void ff_walk_options_init(ff_walk_options *o)
{
    ff_walk_options_init_size(o, sizeof *o);
}

/** "1", "2+", "1-3", "all", and lists of these with commas, into orders [FF_WALK_ORDERS] and their count. FF_ERR_SYNTAX,
 *  FF_ERR_RANGE, which say what was expected. */
FF_API ff_status ff_orders_parse(const char *text, ff_orders *orders, size_t *n, ff_error *err);
/** The word of one of them into out [size], always terminated. */
FF_API void ff_orders_name(ff_orders o, char *out, size_t size);

/** A walk on the surface of a model with its parameters. */
typedef struct ff_walk ff_walk;

/** Makes a walk; takes a few milliseconds. It keeps copies, but borrows the profile table of a `tabulated` lobe, the cancel flag
 * and the context of the progress, which must outlive it. Release with ff_walk_free.
 *  @param shape    [n_shape]                 see ff_model_check
 *  @param channel  [n_channels][n_channel]
 *  *out is written only on FF_OK. FF_ERR_RANGE, FF_ERR_UNSUPPORTED as ff_model_check; FF_ERR_UNSUPPORTED for a model that the walk
 *  has no meaning for (see above; the message says what), or slopes whose mean lies too far out (student-t near gamma = 1.5);
 *  FF_ERR_RANGE for options; FF_ERR_MEMORY. */
FF_API ff_status ff_walk_new(const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                             const ff_walk_options *o, ff_walk **out, ff_error *err);
FF_API void ff_walk_free(ff_walk *w); /**< NULL is allowed */

/** The model at n pairs of directions, as o.paths paths for each have it.
 *  @param w      unit vectors above the horizon (z > FF_COS_MIN)
 *  @param first  number of the first pair: pairs of other numbers have other paths
 *  @param f      [n_orders][n_channels][ld] out  1/sr
 *  @param error  [n_orders][n_channels][ld] out  standard errors of f, 1/sr, not below 1e-6 f
 *  @param ld     stride of a plane, >= n
 *  FF_ERR_RANGE for directions that are none and an ld below n; FF_ERR_MEMORY, FF_ERR_CANCELLED. */
FF_API ff_status ff_walk_values(const ff_walk *walk, const ff_dirs *w, size_t n, uint64_t first, double *f, double *error,
                                size_t ld, ff_error *err);

/** What is reflected of light from one direction. Errors are standard errors. */
typedef struct ff_lobe_mean {
    double albedo, albedo_error;   /**< of the light that arrives                                            */
    double mean[3], mean_error[3]; /**< of the directions it leaves in, weighted by it; NaN where there is none */
} ff_lobe_mean;

/** Reflectance and mean direction of the light from wi, by counting the paths that leave.
 *  @param wi    unit vector, wi.z > FF_COS_MIN
 *  @param lobe  [n_orders][n_channels] out
 *  @param lost  what paths still had that were ended, as a part of what arrives: those that carry less than 1e-9, and those of
 *               4096 facets; the most of all channels. NULL: not wanted
 *  FF_ERR_RANGE for a wi that is no unit vector above the horizon; FF_ERR_MEMORY, FF_ERR_CANCELLED. */
FF_API ff_status ff_walk_lobe(const ff_walk *walk, const double wi[3], ff_lobe_mean *lobe, double *lost, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
