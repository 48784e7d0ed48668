/* Finds and opens the module that reads images. In this order: $FACETFIT_MODULES; beside the file that this code is in, a program
 * or a shared library; where an installation has it, seen from there; in ../bin, as the programs of a build tree do; where it was
 * to be installed. */
#define _GNU_SOURCE
#include "oiio_bridge.h"
#include <dlfcn.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/auxv.h>
#include <unistd.h>

static const char module_name[] = "facetfit_images.so";

/* Directory of the file that holds this code. The loader knows a library by its path and the program by no name: the one it was
 * called by is whatever the caller says. */
static int own_directory(char out[PATH_MAX])
{
    Dl_info info;
    struct link_map *map = NULL;
    char resolved[PATH_MAX];
    if (!dladdr1((const void *)module_name, &info, (void **)&map, RTLD_DL_LINKMAP) || !map) return 0;
    if (!realpath(*map->l_name ? map->l_name : "/proc/self/exe", resolved)) return 0;
    *strrchr(resolved, '/') = '\0';
    strcpy(out, resolved);
    return 1;
}

static ff_status use(void *module, const char *path, const ff_image_reader **out, ff_error *err)
{
    const ff_image_reader *reader = dlsym(module, "ff_image_reader_v1");
    if (!reader || reader->version != FF_IMAGE_READER)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "found a module of another version, expected version %d",
                            FF_IMAGE_READER);
    *out = reader;
    return FF_OK;
}

ff_status ff_image_reader_get(const ff_image_reader **out, ff_error *err)
{
    char own[PATH_MAX] = "", path[2 * PATH_MAX], reason[400] = "";
    const char *given = secure_getenv("FACETFIT_MODULES");   /* not of a program that has another's rights */
    if (getauxval(AT_SECURE)) unsetenv("OIIO_LIBRARY_PATH"); /* nor where OpenImageIO looks for more */
    const int here = own_directory(own);
    const struct {
        int use;
        const char *first, *second;
    } places[] = {{given != NULL, given, ""}, {here, own, ""},        {here, own, "/" FF_MODULES_FROM_BIN},
                  {here, own, "/facetfit"},   {here, own, "/../bin"}, {1, FF_MODULES_INSTALLED, ""}};
    for (size_t k = 0; k < sizeof places / sizeof places[0]; k++) {
        if (!places[k].use) continue;
        snprintf(path, sizeof path, "%s%s/%s", places[k].first, places[k].second, module_name);
        void *module = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
        if (module) return use(module, path, out, err);
        if (access(path, F_OK) == 0) snprintf(reason, sizeof reason, "%.380s", dlerror());
    }
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                        "image stacks need the module %s, which cannot be opened%s%s; $FACETFIT_MODULES may name its directory",
                        module_name, *reason ? ": " : "", reason);
}
