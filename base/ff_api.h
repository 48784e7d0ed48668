/** @file ff_api.h  Which functions of the library are for others.
 *
 *  A function that is declared FF_API is exported by a shared library; everything else is hidden, so that nobody can come to depend
 * on it. docs/design.md says what is promised of those that are. */
#ifndef FF_API_H
#define FF_API_H

#if defined(__GNUC__)
#define FF_API __attribute__((visibility("default")))
#else
#define FF_API
#endif

#endif
