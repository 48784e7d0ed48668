/* Environments from files. */
#include "internal_render.h"
#include <math.h>
#include <stdlib.h>
#ifdef FF_HAVE_IMAGES
#include "data_formats/formats/images/internal_image_rgb.h"

enum { SIDE_MAX = 32768 };

static ff_status check_pixels(const char *path, size_t nx, size_t ny, const float *rgb, ff_error *err)
{
    double sum = 0;
    for (size_t k = 0; k < 3 * nx * ny; k++) {
        if (!(rgb[k] >= 0 && isfinite(rgb[k])))
            return ff_error_set(err, FF_ERR_DATA, path, 0, -1, "pixel (%zu, %zu): found %g, expected a radiance of 0 or more",
                                k / 3 % nx, k / 3 / nx, (double)rgb[k]);
        sum += (double)rgb[k];
    }
    return sum > 0 ? FF_OK : ff_error_set(err, FF_ERR_DATA, path, 0, -1, "found black everywhere, expected light");
}

ff_status ff_environment_read(const char *path, double turn, ff_environment **out, ff_error *err)
{
    size_t nx, ny;
    float *rgb = NULL;
    if (!(fabs(turn) <= 1e9)) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a turn of %g, expected -1e9 to 1e9", turn);
    ff_status status = ff_image_rgb_read(path, SIDE_MAX, &nx, &ny, &rgb, err);
    if (status != FF_OK) return status;
    status = check_pixels(path, nx, ny, rgb, err);
    if (status == FF_OK) status = ff_environment_of(nx, ny, rgb, turn, out, err);
    free(rgb);
    return status;
}
#else
ff_status ff_environment_read(const char *path, double turn, ff_environment **out, ff_error *err)
{
    (void)turn, (void)out;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "this build reads no images");
}
#endif
