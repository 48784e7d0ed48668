/** @file ff_warning.h  What a result should be taken with: warnings as codes and numbers.
 *
 *  A warning says which of a list of things is so (its code), of which parameters and channels, and by which numbers. The list is
 *  ff_warnings.def. Here are no sentences: ff_words.h makes them, for a person; a program reads the code and the values.
 *  Memory   a result owns its warnings; they are released with it.
 *  Threads  no global state. */
#ifndef FF_WARNING_H
#define FF_WARNING_H
#include "ff_api.h"
#include "ff_composition.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

/** What can be warned of. */
typedef enum ff_warning_code {
#define FF_WARNING(id, name, severity, meaning, ...) FF_WARNING_##id,
#include "ff_warnings.def"
#undef FF_WARNING
    FF_WARNING_COUNT
} ff_warning_code;

/** How bad it is. */
typedef enum ff_severity {
    FF_SEVERITY_NOTE = 0,    /**< worth knowing; nothing is wrong                                    */
    FF_SEVERITY_WARNING = 1, /**< part of the result says less than it seems to                      */
    FF_SEVERITY_PROBLEM = 2  /**< the result is not what was asked for                               */
} ff_severity;
enum { FF_SEVERITY_COUNT = 3 };

enum { FF_WARNING_VALUES = 4 };

/** What is the same for all warnings of a code. */
typedef struct ff_warning_kind {
    const char *name; /**< "at-bound"                                                           */
    ff_severity severity;
    const char *meaning;                  /**< what it says, in half a sentence                                     */
    const char *value[FF_WARNING_VALUES]; /**< names of its values; NULL behind the last. "_deg": degrees           */
} ff_warning_kind;

/** A parameter that a warning is about. */
typedef struct ff_warning_parameter {
    ff_param_ref parameter; /**< of the model that was fitted                                         */
    size_t channel;         /**< where it is a channel's own: index into the problem's; else FF_NO_CHANNEL */
} ff_warning_parameter;
#define FF_NO_CHANNEL ((size_t)-1)

/** One of the warnings of a result: ff_fit_result_warning, ff_ndf_result_warning. Belongs to it and is only looked at; later
 * versions may have more members at its end. */
typedef struct ff_warning {
    ff_warning_code code;
    ff_severity severity;
    size_t n_parameters, n_channels;
    const ff_warning_parameter *parameter; /**< [n_parameters]; NULL when there are none                             */
    const size_t *channel;                 /**< [n_channels] rising: the channels in which it is so, where it is so of
                                                some channels; NULL when it is not about channels                    */
    double value[FF_WARNING_VALUES];       /**< named by the kind; 0 beyond                                          */
} ff_warning;

/** The kind of a code; NULL for a number that is none. */
FF_API const ff_warning_kind *ff_warning_kind_of(int code);
FF_API int ff_warning_find(const char *name);      /**< code of a name, -1 when unknown                  */
FF_API const char *ff_severity_name(int severity); /**< "note", "warning", "problem"; NULL for a number that is none */

#ifdef __cplusplus
}
#endif
#endif
