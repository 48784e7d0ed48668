/** @file ff_version.h  Which facetfit this is.
 *
 *  The macros are those of the headers that a program was compiled with, the functions those of the library that it runs with:
 *
 *      if (ff_version_number() < FF_VERSION_NUMBER) ...    // an older library than the program was made for
 *
 *  Threads  every function may be called from many threads at once. */
#ifndef FF_VERSION_H
#define FF_VERSION_H
#include "ff_api.h"
#ifdef __cplusplus
extern "C" {
#endif

/* The build reads these three lines; they are said nowhere else. */
#define FF_VERSION_MAJOR 0
#define FF_VERSION_MINOR 1
#define FF_VERSION_PATCH 0

#define FF_VERSION_TEXT_(x)       #x
#define FF_VERSION_JOIN_(a, b, c) FF_VERSION_TEXT_(a) "." FF_VERSION_TEXT_(b) "." FF_VERSION_TEXT_(c)
/** "0.1.0" */
#define FF_VERSION_STRING FF_VERSION_JOIN_(FF_VERSION_MAJOR, FF_VERSION_MINOR, FF_VERSION_PATCH)
/** A number that rises with every version: 10000 major + 100 minor + patch. */
#define FF_VERSION_NUMBER (FF_VERSION_MAJOR * 10000 + FF_VERSION_MINOR * 100 + FF_VERSION_PATCH)

/** FF_VERSION_STRING of the library that is linked. Static storage. */
FF_API const char *ff_version(void);

/** FF_VERSION_NUMBER of the library that is linked. */
FF_API int ff_version_number(void);

#ifdef __cplusplus
}
#endif
#endif
