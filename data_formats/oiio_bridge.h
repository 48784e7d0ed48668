/* The only door to OpenImageIO: one image, read in bands of lines. The library brings hundreds of others along, which take a quarter of
 * a second and 130 MB to load: so it stands behind a module, facetfit_oiio.so, that is loaded with the first image (oiio_module.c).
 * Prints  nothing, but for libpng, whose words on a damaged PNG go to stderr: OpenImageIO gives it no other place. */
#ifndef FF_OIIO_BRIDGE_H
#define FF_OIIO_BRIDGE_H
#include "ff_status.h"
#include <stddef.h>
#ifdef __cplusplus
extern "C" {
#endif

enum { FF_IMAGE_CHANNELS = 64, FF_IMAGE_NAME = 64 };

typedef struct ff_image ff_image;

/** What an image's file says of it. */
typedef struct ff_image_info {
    long width, height; /**< pixels, >= 1                                                              */
    size_t n_channels;  /**< 1 .. FF_IMAGE_CHANNELS, alpha included                                    */
    char name[FF_IMAGE_CHANNELS][FF_IMAGE_NAME];
    long alpha;               /**< index of the channel that is alpha, -1 = none                             */
    int bits;                 /**< of an integer format, whose largest number reads as 1; 0: floating point  */
    char encoding[FF_IMAGE_NAME]; /**< colour space as the library names it, "" when the file does not say */
    double gamma;             /**< exponent that the file states, 0 when it does not                         */
    long band;                /**< lines to be read at once                                                  */
} ff_image_info;

/** Opens the image at path, of a kind that ff_image_check found. *out and *info are written only on FF_OK; then ff_image_close must
 *  follow. FF_ERR_FORMAT for what is no image or none of two dimensions, or is larger than its file can hold; FF_ERR_UNSUPPORTED for
 *  more channels, and where the module is not installed; FF_ERR_MEMORY. No exception passes. */
ff_status ff_image_open(const char *path, const char *kind, ff_image **out, ff_image_info *info, ff_error *err);

/** Reads `count` lines from line `first` on, a multiple of info.band; count is info.band, or what is left of the image.
 *  out [count][width][n_channels]. FF_ERR_READ. */
ff_status ff_image_lines(ff_image *image, long first, long count, float *out, ff_error *err);

void ff_image_close(ff_image *image);

/** The same as the module has it, under the name FF_OIIO_SYMBOL. `version` changes with everything in this header. */
typedef struct ff_oiio_calls {
    int version;
    ff_status (*open)(const char *path, const char *kind, void **out, ff_image_info *info, ff_error *err);
    ff_status (*lines)(void *image, long first, long count, float *out, ff_error *err);
    void (*close)(void *image);
} ff_oiio_calls;
enum { FF_OIIO_VERSION = 1 };
#define FF_OIIO_SYMBOL "ff_oiio_calls_1"

#ifdef __cplusplus
}
#endif
#endif
