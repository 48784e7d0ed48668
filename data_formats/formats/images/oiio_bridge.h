/* The only door to OpenImageIO: one image, read in bands of lines. It is a module, facetfit_images.so, that is opened when the
 * first image is to be read: the library brings some 250 others, whose loading takes longer than most fits. Prints  nothing, but
 * for libpng, whose words on a damaged PNG go to stderr: OpenImageIO gives it no other place. */
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
    long alpha;                   /**< index of the channel that is alpha, -1 = none                             */
    int bits;                     /**< of an integer format, whose largest number reads as 1; 0: floating point  */
    char encoding[FF_IMAGE_NAME]; /**< colour space as the library names it, "" when the file does not say */
    double gamma;                 /**< exponent that the file states, 0 when it does not                         */
    long band;                    /**< lines to be read at once                                                  */
} ff_image_info;

/** What the module does. No exception passes. */
typedef struct ff_image_reader {
    int version; /**< FF_IMAGE_READER */
    /** Opens the image at path, of a kind that ff_image_check found. *out and *info are written only on FF_OK; then close must
     * follow. FF_ERR_FORMAT for what is no image or none of two dimensions, or is larger than its file can hold; FF_ERR_UNSUPPORTED
     * for more channels, FF_ERR_MEMORY. */
    ff_status (*open)(const char *path, const char *kind, ff_image **out, ff_image_info *info, ff_error *err);
    /** Reads `count` lines from line `first` on, a multiple of info.band; count is info.band, or what is left of the image.
     *  out [count][width][n_channels]. FF_ERR_READ. */
    ff_status (*lines)(ff_image *image, long first, long count, float *out, ff_error *err);
    void (*close)(ff_image *image); /**< NULL is legal */
} ff_image_reader;

enum { FF_IMAGE_READER = 1 };
/** Symbol of the module. */
extern const ff_image_reader ff_image_reader_v1;

/** Opens the module, which stays open; internal_module.h says where it is looked for. FF_ERR_UNSUPPORTED when it is not there. */
ff_status ff_image_reader_get(const ff_image_reader **out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
