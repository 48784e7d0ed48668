/* A fitted model as source code: a function of two directions and a channel, in C, GLSL, HLSL or OSL. */
#ifndef FF_INTERNAL_SNIPPET_H
#define FF_INTERNAL_SNIPPET_H
#include "models/model_struct.h"
#include <stdio.h>

/* Names, extensions without which nothing is written elsewhere: "c", "glsl", "hlsl", "osl". */
size_t ff_snippet_count(void);
const char *ff_snippet_name(size_t i); /* NULL when i >= count */
int ff_snippet_find(const char *name); /* -1 when unknown      */

/* Writes facetfit_brdf(ix, iy, iz, ox, oy, oz, channel): f in 1/sr of unit vectors towards light and view in the frame of the
 * surface, x along the tangent, 0 below the horizon. Parameters as ff_model_eval. version: of the program. FF_ERR_UNSUPPORTED names
 * a term that there is no code for, and those that there is. */
ff_status ff_snippet_write(int language, const ff_model *m, size_t n_channels, const double *shape, const double *channel,
                           const char *version, FILE *out, ff_error *err);
#endif
