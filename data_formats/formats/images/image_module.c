/* Opens the module that reads images. */
#define _GNU_SOURCE
#include "oiio_bridge.h"
#include "base/internal_module.h"
#include <stdlib.h>
#include <sys/auxv.h>

ff_status ff_image_reader_get(const ff_image_reader **out, ff_error *err)
{
    const void *found = NULL;
    if (getauxval(AT_SECURE)) unsetenv("OIIO_LIBRARY_PATH"); /* nor where OpenImageIO looks for more */
    const ff_status status = ff_module_open(
        "facetfit_images.so", "ff_image_reader_v1", FF_IMAGE_READER, "image stacks need",
        ". It is in the package facetfit-modules, or built where OpenImageIO is (on Debian libopenimageio-dev)", &found, err);
    if (status == FF_OK) *out = found;
    return status;
}
