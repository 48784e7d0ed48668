/* Loading the module that reads images, when there is the first one. */
#define _GNU_SOURCE
#include "oiio_bridge.h"
#include <dlfcn.h>
#include <limits.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MODULE "facetfit_oiio.so"
enum { PLACES = 6, ROOM = PATH_MAX + 64 };

struct ff_image {
    const ff_oiio_calls *calls;
    void *module, *image;
};

/* ---- where it may be ------------------------------------------------------------------------- */

typedef struct places {
    size_t n;
    char path[PLACES][ROOM];
} places;

__attribute__((format(printf, 2, 3))) static void add(places *p, const char *format, ...)
{
    va_list args;
    if (p->n == PLACES) return;
    va_start(args, format);
    const int length = vsnprintf(p->path[p->n], ROOM, format, args);
    va_end(args);
    if (length > 0 && length < ROOM) p->n++;
}

/* Beside a program or a library, in the library folder of an installation that may have been moved. */
static void add_beside(places *p, const char *binary)
{
    const char *slash = strrchr(binary, '/');
    if (!slash) return;
    const int folder = (int)(slash - binary);
    add(p, "%.*s/facetfit/" MODULE, folder, binary);
    add(p, "%.*s/../" FF_LIBDIR "/facetfit/" MODULE, folder, binary);
}

static void find_places(places *p)
{
    const char *asked = getenv("FACETFIT_MODULES");
    char program[PATH_MAX];
    Dl_info self;
    p->n = 0;
    if (asked) add(p, "%s/" MODULE, asked);
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length > 0) {
        program[length] = '\0';
        add_beside(p, program);
    }
    if (dladdr((void *)(uintptr_t)find_places, &self) && self.dli_fname) add_beside(p, self.dli_fname);
    if (p->n < PLACES) add(p, "%s/" MODULE, FF_MODULES);
}

/* ---- loading --------------------------------------------------------------------------------- */

/* Once loaded the module stays: libraries behind it do not bear being unloaded. */
static void *load(const char *path, const ff_oiio_calls **calls)
{
    void *module = dlopen(path, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    if (!module) return NULL;
    *calls = dlsym(module, FF_OIIO_SYMBOL);
    if (*calls && (*calls)->version == FF_OIIO_VERSION) return module;
    dlclose(module);
    return NULL;
}

static ff_status not_found(const places *p, const char *path, ff_error *err)
{
    char reason[160] = "it is in none of the usual places";
    for (size_t k = 0; k < p->n; k++) {
        if (access(p->path[k], R_OK) != 0) continue;
        void *module = dlopen(p->path[k], RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
        const char *why = module ? "another version" : dlerror();
        if (module) dlclose(module);
        snprintf(reason, sizeof reason, "%s", why ? why : "it cannot be loaded");
        break;
    }
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "images need the module " MODULE ": %s (it is looked for beside the program, in ../" FF_LIBDIR
                        "/facetfit, and where FACETFIT_MODULES says)",
                        reason);
}

ff_status ff_image_open(const char *path, const char *kind, ff_image **out, ff_image_info *info, ff_error *err)
{
    ff_image image = {0};
    places *p = malloc(sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for an image");
    find_places(p);
    for (size_t k = 0; k < p->n && !image.module; k++) image.module = load(p->path[k], &image.calls);
    ff_status s = image.module ? image.calls->open(path, kind, &image.image, info, err) : not_found(p, path, err);
    free(p);
    ff_image *opened = s == FF_OK ? malloc(sizeof *opened) : NULL;
    if (s == FF_OK && !opened) {
        image.calls->close(image.image);
        s = ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for an image");
    }
    if (s != FF_OK) {
        if (image.module) dlclose(image.module);
        return s;
    }
    *opened = image;
    *out = opened;
    return FF_OK;
}

ff_status ff_image_lines(ff_image *image, long first, long count, float *out, ff_error *err)
{
    return image->calls->lines(image->image, first, count, out, err);
}

void ff_image_close(ff_image *image)
{
    if (!image) return;
    image->calls->close(image->image);
    dlclose(image->module);
    free(image);
}
