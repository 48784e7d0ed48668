#include "rays_bridge.h"
#include "base/internal_module.h"

ff_status ff_rays_get(const ff_rays **out, ff_error *err)
{
    const void *found = NULL;
    const ff_status status =
        ff_module_open("facetfit_rays.so", "ff_rays_v1", FF_RAYS, "surfaces need",
                       ". It is in the package facetfit-modules, or built where Embree and FFTW are (on Debian "
                       "libembree-dev, libfftw3-dev: ./setup surfaces)",
                       &found, err);
    if (status == FF_OK) *out = found;
    return status;
}
