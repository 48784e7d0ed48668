/* Files that renderers load, written from the controls of a material. A kind of file is one file write_NAME.c and one line in
 * files.def. */
#ifndef FF_INTERNAL_FILES_H
#define FF_INTERNAL_FILES_H
#include "base/internal_number.h"
#include "targets/internal_target.h"
#include <stdio.h>

/* A material with its controls. */
typedef struct ff_scene {
    const ff_target *target;
    const ff_material *material;
    size_t n_channels;     /* 1 or 3                                                                        */
    const double *control; /* [ff_control_count][n_channels], inside what the renderer takes                */
    const char *version;   /* of the program                                                                */
} ff_scene;

typedef struct ff_scene_file {
    const char *name;      /* "blender-python"                                                              */
    const char *extension; /* ".py"                                                                         */
    const char *title;
    const char *const *targets; /* names, NULL after the last                                               */
    int is_binary;
    ff_status (*write)(const ff_scene *s, FILE *out); /* what fails to be written stays in the stream; FF_ERR_MEMORY */
} ff_scene_file;

size_t ff_scene_file_count(void);
const ff_scene_file *ff_scene_file_at(size_t i); /* NULL when i >= count */
/* The kind for a target whose name ends as path does, or the target's first kind where none does and any is allowed; NULL: none. */
const ff_scene_file *ff_scene_file_find(const ff_target *t, const char *path, int any);

/* A control by name, in channel c of 0, 1, 2 (one channel serves all); `otherwise` where the material has none. */
double ff_scene_control(const ff_scene *s, const char *name, size_t c, double otherwise);
/* A setting of the material by name. */
double ff_scene_setting(const ff_scene *s, const char *name, double otherwise);
/* The fewest digits that read back. */
const char *ff_scene_number(double x, char out[FF_NUMBER_TEXT + 1]);
/* The three channels of a control with `between` between them. */
void ff_scene_color(const ff_scene *s, const char *name, const char *between, FILE *out);
/* One number. */
void ff_scene_put(const ff_scene *s, const char *name, double otherwise, FILE *out);
#endif
