/** @file ff_composition.h  A composed model as a plain value, and the pairs of directions it is asked for.
 *
 *  The terms that a person names (ff_term.h) and their parameters in one list: what is evaluated and fitted. ff_model.h makes one,
 *  changes it and evaluates it; frame and units are described there. The members may be read by anyone and are changed by those
 *  functions alone. */
#ifndef FF_COMPOSITION_H
#define FF_COMPOSITION_H
#include "ff_term.h"

enum { FF_MAX_LOBES = 3, FF_MAX_BASES = 2, FF_MAX_SHAPE = 32, FF_MAX_CHANNEL_PARAMS = 16, FF_PARAM_NAME = 32, FF_MODEL_NAME = 256 };
#define FF_FRESNEL_SHARED (-1) /**< of a second or third lobe: the Fresnel term of the first one, parameters and all */

/** One specular lobe ks D F G / (4 iz oz): indices into the registry. */
typedef struct ff_lobe {
    int ndf, masking, fresnel;            /**< fresnel may be FF_FRESNEL_SHARED                        */
    int isotropic;                        /**< 1: one `alpha` (or the distribution's own width) instead of a stretch  */
    uint32_t shape0, n_shape;             /**< its slice of the model's shape parameters              */
    uint32_t channel0, n_channel;         /**< its slice of the per-channel parameters                */
    const struct ff_profile_table *table; /**< of `tabulated`, borrowed (see ff_profile.h); else NULL */
} ff_lobe;

/** A term under the lobes: diffuse reflection, or what the lobes scatter more than once. */
typedef struct ff_base {
    int diffuse; /**< index into the registry of FF_DIFFUSE */
    uint32_t shape0, n_shape, channel0, n_channel;
} ff_base;

/** Which of a model's two lists of parameters. */
typedef enum ff_param_kind {
    FF_PARAM_NONE = 0,   /**< neither: there is no such parameter                  */
    FF_PARAM_SHAPE = 1,  /**< one value for all channels: roughness, ...            */
    FF_PARAM_CHANNEL = 2 /**< a value in each channel: f0, kd, ...                  */
} ff_param_kind;

/** A parameter of a model by its place. A zeroed one is none. */
typedef struct ff_param_ref {
    ff_param_kind kind;
    uint32_t index; /**< into that list; 0 of none                            */
} ff_param_ref;

/** A parameter of a composed model: as in the registry, with the name it has there ("lobe2.alpha_x" for the second lobe,
 *  "base2.kd" for a second base where the plain name is taken). */
typedef struct ff_model_param {
    char name[FF_PARAM_NAME];
    const ff_param *info; /**< static storage; info->name is the bare name                              */
    uint32_t lobe;        /**< 0-based; n_lobes + b for base b                                            */
    double init;          /**< where it starts or is held: info->init unless the model says otherwise    */
    double lo, hi;        /**< where a fit may go: info->lo, info->hi unless ff_model_bound narrowed them */
    uint32_t flags;       /**< info->flags, FF_PARAM_HELD as the model has it                            */
} ff_model_param;

/** A sum of lobes and bases. A plain value: copy it freely.
 *  Its parameters are n_shape shared ones (roughness ...) followed, for each colour channel, by n_channel ones (f0 ..., kd).
 *  Every lobe has per channel a scale ks, 1 and held unless freed; lobes that share their Fresnel term have a `weight` instead,
 *  lobe l's share of what the lobes up to it weigh: weights w2, w3 give (1-w2)(1-w3), w2 (1-w3), w3. */
typedef struct ff_model {
    uint32_t n_lobes, n_bases;
    ff_lobe lobe[FF_MAX_LOBES];
    ff_base base[FF_MAX_BASES];
    uint32_t n_shape, n_channel;
    ff_model_param shape[FF_MAX_SHAPE];
    ff_model_param channel[FF_MAX_CHANNEL_PARAMS];
} ff_model;

/** n pairs of directions as six planes [n]. A z <= FF_COS_MIN is legal and gives f = df = 0. */
typedef struct ff_dirs {
    const double *wix, *wiy, *wiz, *wox, *woy, *woz;
} ff_dirs;
#define FF_COS_MIN 1e-8 /**< cosines at or below it count as at or under the horizon */
#endif
