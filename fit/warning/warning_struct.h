/* The list of a result's warnings. */
#ifndef FF_WARNING_STRUCT_H
#define FF_WARNING_STRUCT_H
#include "ff_warning.h"

/** The warnings of a result, in the order in which a person should read them. */
typedef struct ff_warnings {
    size_t n;
    ff_warning *item; /**< [n]                                                                 */
} ff_warnings;
#endif
