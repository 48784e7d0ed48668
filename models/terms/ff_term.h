/** @file ff_term.h  What a person is told about one term of a model: its name, where it was published, what it claims, its
 * parameters.
 *
 *  A model is put together from terms: how the facets of the surface are spread (a distribution), which of them hide others
 * (masking), how much one of them reflects (Fresnel), and what is scattered from underneath (diffuse). ff_model.h lists the terms
 * and composes them. Descriptors are immutable and have static storage: read them from any thread. */
#ifndef FF_TERM_H
#define FF_TERM_H
#include <stdint.h>

typedef enum ff_term_kind { FF_NDF = 0, FF_MASKING = 1, FF_FRESNEL = 2, FF_DIFFUSE = 3 } ff_term_kind;
enum { FF_TERM_KINDS = 4 };

/** What a term claims; the test suite checks each claim for every term that makes it, and the absence of none. */
enum {
    FF_RECIPROCAL = 1u << 0,    /**< f(wi, wo) = f(wo, wi)                                                   */
    FF_PASSIVE = 1u << 1,       /**< reflects at most what arrives, for parameters in their box              */
    FF_ISOTROPIC = 1u << 2,     /**< has no direction of its own; makes the lobes of the model isotropic       */
    FF_WEAK_FURNACE = 1u << 3,  /**< masking: the weak white furnace integral of its G1 is 1; distribution: its
                                     Lambda is Smith's, so that it is 1 for the Smith forms                    */
    FF_FURNACE_ONLY = 1u << 4,  /**< masking: exists for the furnace test; `all` does not include it           */
    FF_NEEDS_CENTRED = 1u << 5, /**< masking: undefined when the mean slope is not zero                       */
    FF_UNIT_AREA = 1u << 6      /**< distribution: integral D(m) mz dm = 1                                    */
};

enum {
    FF_PARAM_PER_CHANNEL = 1u << 0, /**< one value per colour channel                                           */
    FF_PARAM_LINEAR = 1u << 1,      /**< the model is affine in it: the fit solves for it                        */
    FF_PARAM_LOG = 1u << 2,         /**< a scale: searched and fitted as ln(p + offset)                          */
    FF_PARAM_ATANH = 1u << 3,       /**< in (-1, 1): fitted as its inverse hyperbolic tangent                    */
    FF_PARAM_HELD = 1u << 4,        /**< stays at its initial value unless the caller frees it (mean slopes)     */
    FF_PARAM_SHARED = 1u << 5       /**< of a model, not of a term: a per-channel one that all channels have alike,
                                         an alpha_y that is alpha_x                                             */
};

/** One parameter. The value of the model and its derivative are finite on the whole closed box [lo, hi]. */
typedef struct ff_param {
    const char *name;    /**< key in files and on the command line: "alpha_x"     */
    const char *unit;    /**< "1" where there is none; never NULL                 */
    const char *meaning; /**< one line, naming the symbol of the source           */
    double lo, hi, init; /**< lo <= init <= hi                               */
    uint32_t flags;      /**< FF_PARAM_...                                        */
    double offset;       /**< of FF_PARAM_LOG; lo + offset > 0                    */
} ff_param;

/** A simpler term that a term becomes where one of its parameters has a value: then the larger one is never worse, and whether it
 * is better is a question about the parameter. */
typedef struct ff_contains {
    const char *name;      /**< of the same kind; NULL: none */
    const char *parameter; /**< bare name                    */
    double value;
} ff_contains;

/** Everything a person is told about one term. Immutable, static storage. */
typedef struct ff_term {
    const char *name;       /**< stable, lower case: "ggx", "smith-height-correlated"        */
    const char *title;      /**< one line for lists                                           */
    const char *source;     /**< paper and equations                                          */
    const char *note;       /**< what a user must know (validity, differences), "" when none  */
    uint32_t claims;        /**< FF_RECIPROCAL | ...                                          */
    uint32_t n_params;      /**< length of params                                             */
    const ff_param *params; /**< of this term alone; NULL when n_params = 0                   */
    ff_contains contains;   /**< {NULL} when it contains no other                             */
    const char *also;       /**< other names that people have for it, separated by commas; NULL: none */
} ff_term;
#endif
