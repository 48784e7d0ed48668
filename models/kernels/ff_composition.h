/** @file ff_composition.h  A composed model, its parameters, and the pairs of directions it is asked for.
 *
 *  The terms that a person names (ff_term.h) and their parameters in one list: what is evaluated and fitted. ff_model.h makes one,
 *  changes it, reads it and evaluates it; frame and units are described there. */
#ifndef FF_COMPOSITION_H
#define FF_COMPOSITION_H
#include "ff_term.h"

enum { FF_PARAM_NAME = 32, FF_MODEL_NAME = 256 }; /**< sizes of buffers for the name of a parameter, and for a whole expression */

/** A sum of lobes and bases: what a surface reflects, up to the numbers. Closed: ff_model_new makes one.
 *  Its parameters are shared ones (roughness ...) followed, for each colour channel, by those that a channel has for itself (f0
 * ..., kd). Every lobe has per channel a scale ks, 1 and held unless it is let vary; lobes that share their Fresnel term have a
 * `weight` instead, lobe l's share of what the lobes up to it weigh: weights w2, w3 give (1-w2)(1-w3), w2 (1-w3), w3. */
typedef struct ff_model ff_model;

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
 *  "base2.kd" for a second base where the plain name is taken). Owned by its model. */
typedef struct ff_model_param {
    char name[FF_PARAM_NAME];
    const ff_param *info; /**< static storage; info->name is the bare name                              */
    uint32_t lobe;        /**< 0-based; number of lobes + b for base b                                   */
    double init;          /**< where it starts or is held: info->init unless the model says otherwise    */
    double lo, hi;        /**< where a fit may go: info->lo, info->hi unless ff_model_bound narrowed them */
    uint32_t flags;       /**< info->flags, FF_PARAM_HELD as the model has it                            */
} ff_model_param;

/** n pairs of directions as six planes [n]. A z <= FF_COS_MIN is legal and gives f = df = 0. */
typedef struct ff_dirs {
    const double *wix, *wiy, *wiz, *wox, *woy, *woz;
} ff_dirs;
#define FF_COS_MIN 1e-8 /**< cosines at or below it count as at or under the horizon */
#endif
