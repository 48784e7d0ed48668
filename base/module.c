#define _GNU_SOURCE
#include "internal_module.h"
#include <dlfcn.h>
#include <limits.h>
#include <link.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Directory of the file that holds this code. The loader knows a library by its path and the program by no name: the one it was
 * called by is whatever the caller says. */
static int own_directory(char out[PATH_MAX])
{
    static const char here[] = "";
    Dl_info info;
    struct link_map *map = NULL;
    char resolved[PATH_MAX];
    if (!dladdr1((const void *)here, &info, (void **)&map, RTLD_DL_LINKMAP) || !map) return 0;
    if (!realpath(*map->l_name ? map->l_name : "/proc/self/exe", resolved)) return 0;
    *strrchr(resolved, '/') = '\0';
    strcpy(out, resolved);
    return 1;
}

static ff_status use(void *module, const char *symbol, int version, const char *path, const void **out, ff_error *err)
{
    const int *descriptor = dlsym(module, symbol);
    if (!descriptor || *descriptor != version)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "found a module of another version, expected version %d",
                            version);
    *out = descriptor;
    return FF_OK;
}

ff_status ff_module_open(const char *file, const char *symbol, int version, const char *needed, const char *help, const void **out,
                         ff_error *err)
{
    char own[PATH_MAX] = "", path[2 * PATH_MAX], reason[400] = "";
    const char *given = secure_getenv("FACETFIT_MODULES"); /* not of a program that has another's rights */
    const int here = own_directory(own);
    const struct {
        int use;
        const char *first, *second;
    } places[] = {{given != NULL, given, ""}, {here, own, ""},        {here, own, "/" FF_MODULES_FROM_BIN},
                  {here, own, "/facetfit"},   {here, own, "/../bin"}, {1, FF_MODULES_INSTALLED, ""}};
    for (size_t k = 0; k < sizeof places / sizeof places[0]; k++) {
        if (!places[k].use) continue;
        snprintf(path, sizeof path, "%s%s/%s", places[k].first, places[k].second, file);
        void *module = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
        if (module) return use(module, symbol, version, path, out, err);
        if (access(path, F_OK) == 0) snprintf(reason, sizeof reason, "%.380s", dlerror());
    }
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                        "%s the module %s, which cannot be opened%s%s; $FACETFIT_MODULES may name its directory%s", needed, file,
                        *reason ? ": " : "", reason, help);
}
