/** @file ff_convert.h  Roughness and reflectance of one convention in terms of another.
 *
 *  A number for roughness means nothing without its convention: .3 is a Beckmann m, the roughness that a renderer squares, or a
 *  gloss. Conventions are the nodes of a graph and conversions its edges; any two conventions with a path between them convert.
 *
 *  Every conversion is one immutable entry: what goes in, what comes out, the formula, its source, what it assumes and where it
 * stops being good. Some say the same thing in other words (roughness to alpha). Others match one feature of two different things
 *  (beckmann to ggx); the entry names the feature, and a path takes as few of them as it can.
 *  Angles   radians.
 *  Errors   ff_status; outputs are written only on FF_OK. Nothing prints or aborts; what allocates says so.
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_CONVERT_H
#define FF_CONVERT_H
#include "ff_api.h"
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_CONVERSION_VALUES = 3, FF_CONVERSION_STEPS = 6 };

/** One number that goes in or comes out. lo and hi bound the open interval (lo, hi), or include lo where lo_included. */
typedef struct ff_conversion_value {
    const char *name;  /**< key on the command line: "m"                                             */
    const char *alias; /**< a second name it is known by, NULL when none                             */
    const char *unit;  /**< "1", "rad"                                                               */
    double lo, hi;
    int lo_included; /**< 1: lo itself is legal                                              */
    int optional;    /**< 1: need not be given, and is then `initial`                        */
    double initial;
} ff_conversion_value;

/** One conversion. Immutable, static storage. */
typedef struct ff_conversion {
    const char *from, *to; /**< names of the conventions: "beckmann", "phong"                         */
    const char *by;        /**< the criterion, where several lead from `from` to `to`; "" otherwise   */
    const char *formula;   /**< "n = 2/m^2 - 2"                                                       */
    const char *source;    /**< paper and equation                                                    */
    const char *assumes;   /**< what must be true for the answer to mean anything                     */
    const char *limits;    /**< where the answer stops being good                                     */
    int matches;           /**< 1: one feature of two different things is made equal; 0: the same thing    */
    uint32_t n_in, n_out;
    ff_conversion_value in[FF_CONVERSION_VALUES], out[FF_CONVERSION_VALUES];
    /** The formula itself; arguments are in their ranges already. NULL, or a reason why these arguments have no answer. Of the two
     *  one is set: apply_at also takes an angle of incidence, allocates, and fails as functions do. */
    const char *(*apply)(const double *in, double *out);
    ff_status (*apply_at)(const double *in, double theta_i, double *out, ff_error *err);
    /** A sentence when this very answer is outside the good range, NULL when it is inside. May itself be NULL. */
    const char *(*doubt)(const double *in, const double *out);
} ff_conversion;

/** The list of conversions, in a fixed order. */
FF_API size_t ff_conversion_count(void);
FF_API const ff_conversion *ff_conversion_at(size_t i); /**< NULL when i >= count */

/** Name of the convention that a word means: the word itself, or that of which it is another name ("ior" of "eta"). NULL when none.
 */
FF_API const char *ff_conversion_name(const char *word);

/** Index of the first conversion at or after `start` that leads from `from` to `to` by the criterion `by` (NULL = any), or -1. */
FF_API int ff_conversion_find(const char *from, const char *to, const char *by, size_t start);

/** Converts.
 *  @param in       [c->n_in]
 *  @param theta_i  angle of incidence, radians, [0, pi/2): read by conversions with an `apply_at`
 *  @param out      [c->n_out] out
 *  FF_ERR_RANGE for an argument that is not finite, lies outside its interval (the message has the interval and what the formula
 *  would give) or whose answer cannot be represented;
 *  FF_ERR_MEMORY where the conversion has an `apply_at`. */
FF_API ff_status ff_conversion_apply(const ff_conversion *c, const double *in, double theta_i, double *out, ff_error *err);

/** What a person must know about this very answer, NULL when it is in the good range of the conversion. */
FF_API const char *ff_conversion_doubt(const ff_conversion *c, const double *in, const double *out);

/** A way from one convention to another: the conversions on it, in their order. */
typedef struct ff_conversion_path {
    size_t n;
    const ff_conversion *step[FF_CONVERSION_STEPS];
} ff_conversion_path;

/** The ways from `from` to `to`: along the conventions between them that take the fewest matches, then the fewest steps. Where a
 *  step can be done by several criteria each is a way, unless `by` names one; a step with a conversion that has no criterion is
 * done by that one alone unless `by` is given.
 *  @param by    criterion, or NULL. Steps that do not know it, and need none, are done as without
 *  @param most  room in `out`; ways beyond it are left out
 *  @param out   [most] out
 *  @return      number of ways in `out`; 0 where there is none, or none by this criterion */
FF_API size_t ff_conversion_paths(const char *from, const char *to, const char *by, size_t most, ff_conversion_path *out);

/** Converts along a path; arguments and errors as of ff_conversion_apply, values [path->step[0]->n_in] in,
 *  [path->step[path->n - 1]->n_out] out. An error names the step where the path has several.
 *  @param doubt  out: what ff_conversion_doubt says of the first step of which it says anything, else NULL; NULL = not needed */
FF_API ff_status ff_conversion_follow(const ff_conversion_path *path, const double *in, double theta_i, double *out,
                                      const char **doubt, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
