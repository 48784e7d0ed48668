/** @file ff_convert.h  Roughness of one convention in terms of another.
 *
 *  Every conversion is one immutable entry of a table: what goes in, what comes out, the formula, its source, what it assumes and
 *  where it stops being good. A conversion that is not an identity (beckmann to phong, beckmann to ggx) matches one feature of two
 *  different distributions; the entry names the feature.
 *  Angles   radians.
 *  Errors   ff_status; outputs are written only on FF_OK. Nothing allocates, prints or aborts.
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_CONVERT_H
#define FF_CONVERT_H
#include "ff_api.h"
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_CONVERSION_VALUES = 3 };

/** One number that goes in or comes out. lo and hi bound the open interval (lo, hi), or include lo where lo_included. */
typedef struct ff_conversion_value {
    const char *name;  /**< key on the command line: "m"                                             */
    const char *alias; /**< a second name it is known by, NULL when none                             */
    const char *unit;  /**< "1", "rad"                                                               */
    double lo, hi;
    int lo_included; /**< 1: lo itself is legal                                              */
} ff_conversion_value;

/** One conversion. Immutable, static storage. */
typedef struct ff_conversion {
    const char *from, *to; /**< names of the conventions: "beckmann", "phong"                         */
    const char *by;        /**< the criterion, where several lead from `from` to `to`; "" otherwise   */
    const char *formula;   /**< "n = 2/m^2 - 2"                                                       */
    const char *source;    /**< paper and equation                                                    */
    const char *assumes;   /**< what must be true for the answer to mean anything                     */
    const char *limits;    /**< where the answer stops being good                                     */
    uint32_t n_in, n_out;
    ff_conversion_value in[FF_CONVERSION_VALUES], out[FF_CONVERSION_VALUES];
    /** The formula itself; arguments are in their ranges already. NULL, or a reason why these arguments have no answer. */
    const char *(*apply)(const double *in, double *out);
    /** A sentence when this very answer is outside the good range, NULL when it is inside. May itself be NULL. */
    const char *(*doubt)(const double *in, const double *out);
} ff_conversion;

/** The list of conversions, in a fixed order. */
FF_API size_t ff_conversion_count(void);
FF_API const ff_conversion *ff_conversion_at(size_t i); /**< NULL when i >= count */

/** Index of the first conversion at or after `start` that leads from `from` to `to` by the criterion `by` (NULL = any), or -1. */
FF_API int ff_conversion_find(const char *from, const char *to, const char *by, size_t start);

/** Converts.
 *  @param in   [c->n_in]
 *  @param out  [c->n_out] out
 *  FF_ERR_RANGE for an argument that is not finite, lies outside its interval (the message has the interval and what the formula
 *  would give) or whose answer cannot be represented. */
FF_API ff_status ff_conversion_apply(const ff_conversion *c, const double *in, double *out, ff_error *err);

/** What a person must know about this very answer, NULL when it is in the good range of the conversion. */
FF_API const char *ff_conversion_doubt(const ff_conversion *c, const double *in, const double *out);

#ifdef __cplusplus
}
#endif
#endif
