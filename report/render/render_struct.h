/* Writing a sheet as one of the outputs of a command. */
#ifndef FF_RENDER_STRUCT_H
#define FF_RENDER_STRUCT_H
#include "ff_render.h"
struct ff_outputs; /* base/internal_output.h */

/* ff_render_exr as one of `with`, which gives the file its name; NULL: alone. */
ff_status ff_render_exr_with(const char *path, const ff_render_sheet *s, size_t n_layers, const ff_render_layer *layer,
                             struct ff_outputs *with, ff_error *err);

#endif
