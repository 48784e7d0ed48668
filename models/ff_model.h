/** @file ff_model.h  Microfacet reflectance models: registry, composition, evaluation with derivatives.
 *
 *  A model says how much of the light from one direction a rough surface sends into another, up to a handful of parameters: its
 *  roughness, its reflectance. It is made from an expression, has its parameters by name, and is evaluated for their values:
 *
 *      ff_model *m;
 *      if (ff_model_new("ggx+lambert", &m, &err)) ...                // err says what was wrong
 *      double *shape = malloc(ff_model_param_count(m, FF_PARAM_SHAPE) * sizeof *shape);
 *      double *channel = malloc(n_channels * ff_model_param_count(m, FF_PARAM_CHANNEL) * sizeof *channel);
 *      ff_model_defaults(m, n_channels, shape, channel);
 *      ff_model_set(m, n_channels, "alpha=0.3", shape, channel, &err);
 *      ff_model_eval(m, FF_ISA_BEST, n_channels, shape, channel, &dirs, n, f, NULL, n);
 *      ff_model_free(m);
 *
 *  Frame    macro-normal = +z, tangent = +x; wi (to the light) and wo (to the viewer) are unit vectors pointing away from the
 *           surface, h = (wi+wo)/|wi+wo|. theta is measured from z, phi from x counter-clockwise. Angles: radians.
 *  Value    f = f_r(wi, wo) in 1/sr, the cosine NOT included.
 *  Slopes   of a normal m: (-mx/mz, -my/mz).
 *  Arrays   planes of double, owned by the caller, never kept after return; outputs must not overlap inputs.
 *  Sizes    n_shape and n_channel stand for ff_model_param_count of FF_PARAM_SHAPE and FF_PARAM_CHANNEL.
 *  Memory   models are released with ff_model_free. Nothing else allocates but evaluations, for derivatives and for the tables of
 *           models that have any; they release it before they return.
 *  Errors   ff_status; outputs are written only on FF_OK. Nothing aborts or prints.
 *  Stack    every function of the library works on a thread of 128 KiB, Ceres and the libraries that read files included; half of
 *           it is what glibc takes out of a thread's stack for the thread-local variables of the libraries that a process has
 *           (62 KiB with Ceres, glog and METIS of Debian 12): a process with more of these adds them. Threads of the library's own
 *           have 1 MiB, of which what is not touched costs nothing.
 *  Threads  descriptors are immutable; every function may be called from many threads at once, those that change a model from one
 *           thread at a time. */
#ifndef FF_MODEL_H
#define FF_MODEL_H
#include "ff_api.h"
#include "ff_composition.h"
#include "ff_isa.h"
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

/* ---- the registry: the terms a model is composed of ------------------------------------------ */

/** The list of terms of a kind, in a fixed order; an index stays the same within a version. Names are what expressions are made of;
 * they are found in capitals too, with '_' for '-', and by the other names that people have for them (ff_term.also). */
FF_API size_t ff_term_count(ff_term_kind kind);                /**< 0 for a kind that does not exist        */
FF_API const ff_term *ff_term_at(ff_term_kind kind, size_t i); /**< NULL when i >= count                    */
FF_API int ff_term_find(ff_term_kind kind, const char *name);  /**< index, or -1 when unknown          */
FF_API const char *ff_term_kind_name(ff_term_kind kind);       /**< "distribution", "masking", ...          */

/** A model by the name that people know: an expression, and parameters held at the values of the source. Immutable. */
typedef struct ff_preset {
    const char *name, *title, *source, *note; /**< as of a term                                   */
    const char *expression;
    const char *hold[3]; /**< "ks=4"; NULL = no more                         */
} ff_preset;

/** The list of presets, in a fixed order. */
FF_API size_t ff_preset_count(void);
FF_API const ff_preset *ff_preset_at(size_t i);           /**< NULL when i >= count */
FF_API const ff_preset *ff_preset_find(const char *name); /**< NULL when unknown    */

/* ---- composition ----------------------------------------------------------------------------- */

/** Makes a model from an expression: the name of a preset, or terms joined by '+', each a lobe NDF[/MASKING[/FRESNEL]] or a diffuse
 * name; left out means smith-height-correlated, schlick, no diffuse term. The Fresnel term `shared` of a later lobe is that of the
 * first. FF_ERR_UNKNOWN names the word and what is known; FF_ERR_SYNTAX; FF_ERR_UNSUPPORTED says what is allowed (too many lobes or
 *  diffuse terms, a masking that is not made for the distribution, a coupled diffuse term without a lobe); FF_ERR_MEMORY.
 *  *out is written only on FF_OK; release it with ff_model_free. */
FF_API ff_status ff_model_new(const char *expr, ff_model **out, ff_error *err);

/** The same model once more, with what was held, let vary and bounded; a table of a profile is borrowed by both. FF_ERR_MEMORY. */
FF_API ff_status ff_model_copy(const ff_model *m, ff_model **out, ff_error *err);

FF_API void ff_model_free(ff_model *m); /**< NULL is allowed */

/** How many lobes it has. */
FF_API uint32_t ff_model_lobe_count(const ff_model *m);

/** Writes the full expression of m, every default spelled out, into out [size]; always terminated. */
FF_API void ff_model_expression(const ff_model *m, char *out, size_t size);

/** Holds a parameter at a value, or lets fits vary it; by name, "alpha" for both axes. FF_ERR_UNKNOWN, FF_ERR_RANGE. */
FF_API ff_status ff_model_hold(ff_model *m, const char *name, double value, ff_error *err);
FF_API ff_status ff_model_vary(ff_model *m, const char *name, ff_error *err);

/** Says in which range a fit may move a parameter, by name, "alpha" for both axes; its initial value moves inside. Evaluation knows
 * nothing of it. The range lies inside the parameter's box; that of a reflectance in which the model is affine (the F0 and F82 of
 * Schlick's terms, kd), unless a base depends on what the lobes reflect, may go beyond 1, as colours outside the gamut and
 * uncalibrated data do: up to 1e15. FF_ERR_UNKNOWN; FF_ERR_RANGE when not lo < hi, when they lie outside (the message has the
 * range), or when the parameter is held outside them. m is changed only on FF_OK. */
FF_API ff_status ff_model_bound(ff_model *m, const char *name, double lo, double hi, ff_error *err);

/** Makes the model one of polarized light: every Fresnel factor, dielectric or conductor, becomes that of its own for a source of
 * which the share s_share (0 to 1) is polarized perpendicular to the plane of incidence of the sample, and held there; the detector
 * takes light of both kinds (Priest and Meier 2002). What was held, let vary or bounded before stays so. FF_ERR_RANGE;
 * FF_ERR_UNSUPPORTED where a Fresnel factor says nothing of polarization, or there is none. m is changed only on FF_OK. */
FF_API ff_status ff_model_polarize(ff_model *m, double s_share, ff_error *err);

struct ff_profile_table;
/** Gives every `tabulated` lobe its table (ff_profile.h), which must outlive m and its copies; the count of such lobes. */
FF_API uint32_t ff_model_set_table(ff_model *m, const struct ff_profile_table *table);

/** Initial values: shape [n_shape], channel [n_channels][n_channel]. Either may be NULL. */
FF_API void ff_model_defaults(const ff_model *m, size_t n_channels, double *shape, double *channel);

/** How many parameters it has of a kind: the places of the kind are 0 up to this. 0 of FF_PARAM_NONE. */
FF_API size_t ff_model_param_count(const ff_model *m, ff_param_kind kind);

/** Place of a parameter by name; kind FF_PARAM_NONE when unknown. "alpha" is not a parameter where there are two axes (see
 *  ff_model_set). */
FF_API ff_param_ref ff_model_param_find(const ff_model *m, const char *name);

/** The parameter at a place of m: its name, meaning, unit and box. It belongs to m and goes with it; NULL when there is none. */
FF_API const ff_model_param *ff_model_param_at(const ff_model *m, ff_param_ref ref);

/** Applies one assignment "name=v" or, for a per-channel parameter, "name=v1:v2:..." with one value (all channels) or n_channels.
 *  "alpha=v" sets alpha_x and alpha_y (also "lobe2.alpha=v"). Numbers are decimal, with an exponent or without, in any locale.
 *  FF_ERR_SYNTAX, FF_ERR_UNKNOWN (with the names that exist), FF_ERR_RANGE (with the box). */
FF_API ff_status ff_model_set(const ff_model *m, size_t n_channels, const char *assignment, double *shape, double *channel,
                              ff_error *err);

/** Checks that every value is finite and in its box (a reflectance also beyond 1, as ff_model_bound) and that the combination has a
 * meaning (V-cavity with a mean slope has none). FF_ERR_RANGE also for no channels.
 *  @param shape    [n_shape]
 *  @param channel  [n_channels][n_channel] */
FF_API ff_status ff_model_check(const ff_model *m, size_t n_channels, const double *shape, const double *channel, ff_error *err);

/** Claims of the whole model for these parameters: FF_RECIPROCAL (not with a mean slope), FF_PASSIVE (for ks <= 1), FF_ISOTROPIC.
 */
FF_API uint32_t ff_model_claims(const ff_model *m, const double *shape);

/* ---- evaluation ------------------------------------------------------------------------------ */

/** Evaluates f and, on request, its derivatives by the parameters.
 *  @param shape    [n_shape]                 see ff_model_check
 *  @param channel  [n_channels][n_channel]
 *  @param f   [n_channels][ld] out  1/sr, >= 0 where the Fresnel terms are FF_PASSIVE; the same bits whether or not df is asked for
 *  @param df  [n_channels][n_shape + n_channel][ld] out, or NULL:
 *             df[(c (n_shape+n_channel) + k) ld + i] = d f[c ld + i] / d p_k, p = shape then channel c's own;
 *             where the model has a kink (max, min), the derivative of the branch taken
 *  @param ld  stride of a plane, >= n
 *  FF_ERR_RANGE / FF_ERR_UNSUPPORTED as ff_model_check; FF_ERR_RANGE for an ld below n; FF_ERR_UNSUPPORTED for an isa that is not
 *  available; FF_ERR_MEMORY. */
FF_API ff_status ff_model_eval(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                               const ff_dirs *w, size_t n, double *f, double *df, size_t ld);

/** The factors of one lobe, planes [n] each, any of them NULL = not needed. */
typedef struct ff_terms {
    double *d;        /**< D(h), 1/sr                                                    */
    double *lambda_i; /**< Smith's Lambda of wi; 0 where the masking uses none           */
    double *lambda_o;
    double *g;       /**< G2 (smith-masking-only: G1(wo))                               */
    double *fresnel; /**< F of colour channel `c`                                       */
} ff_terms;

/** The factors of lobe `lobe` for colour channel `c` (parameters as ff_model_eval). 0 in all planes below the horizon.
 *  Errors as ff_model_eval; FF_ERR_RANGE for a lobe or channel that does not exist. */
FF_API ff_status ff_model_terms(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                uint32_t lobe, size_t c, const ff_dirs *w, size_t n, const ff_terms *out);

#ifdef __cplusplus
}
#endif
#endif
