/* The registry of files that renderers load. */
#include "internal_files.h"
#include <string.h>

#define FF_SCENE_FILE(id) extern const ff_scene_file ff_scene_file_##id;
#include "files.def"
#undef FF_SCENE_FILE

static const ff_scene_file *const files[] = {
#define FF_SCENE_FILE(id) &ff_scene_file_##id,
#include "files.def"
#undef FF_SCENE_FILE
};

size_t ff_scene_file_count(void)
{
    return sizeof files / sizeof *files;
}

const ff_scene_file *ff_scene_file_at(size_t i)
{
    return i < ff_scene_file_count() ? files[i] : NULL;
}

static int is_for(const ff_scene_file *f, const ff_target *t)
{
    for (size_t k = 0; f->targets[k]; k++)
        if (!strcmp(f->targets[k], t->name)) return 1;
    return 0;
}

static int ends_in(const char *path, const char *extension)
{
    const size_t n = strlen(path), m = strlen(extension);
    return n > m && !strcmp(path + n - m, extension);
}

const ff_scene_file *ff_scene_file_find(const ff_target *t, const char *path, int any)
{
    const ff_scene_file *first = NULL;
    for (size_t i = 0; i < ff_scene_file_count(); i++) {
        if (!is_for(files[i], t)) continue;
        if (ends_in(path, files[i]->extension)) return files[i];
        if (!first) first = files[i];
    }
    return any ? first : NULL;
}
