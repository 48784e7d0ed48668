/** @file internal_module.h  Modules: parts of the library that need heavy libraries, opened when they are first needed. */
#ifndef FF_INTERNAL_MODULE_H
#define FF_INTERNAL_MODULE_H
#include "ff_status.h"

/** Opens the module `file`, "facetfit_images.so", which stays open, and gives the descriptor behind its `symbol`, whose first
 * member is an int that must be `version`. It is looked for, in this order: in $FACETFIT_MODULES; beside the file that this code is
 * in, a program or a shared library; where an installation has it, seen from there; in ../bin, as the programs of a build tree do;
 * where it was to be installed.
 *  @param needed  who needs it, for the message: "image stacks need the module"
 *  @param help    how to get it, added to the message; "" when there is nothing to say
 *  FF_ERR_UNSUPPORTED when it is not there or of another version. */
ff_status ff_module_open(const char *file, const char *symbol, int version, const char *needed, const char *help, const void **out,
                         ff_error *err);
#endif
