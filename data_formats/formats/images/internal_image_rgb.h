/** @file internal_image_rgb.h  A whole image of linear numbers in red, green and blue. */
#ifndef FF_INTERNAL_IMAGE_RGB_H
#define FF_INTERNAL_IMAGE_RGB_H
#include "ff_status.h"
#include <stddef.h>

/** Reads the image at path, of at most `most` pixels a side: *rgb [*ny][*nx][3], which the caller frees. R, G and B are found by
 * name, else they are the first three channels; a single one is all of them; alpha is passed over. Outputs are written only on
 * FF_OK. FF_ERR_OPEN, FF_ERR_READ, FF_ERR_FORMAT, FF_ERR_MEMORY; FF_ERR_UNSUPPORTED: the module of images is not there, numbers
 * that are not linear, two channels, more pixels. */
ff_status ff_image_rgb_read(const char *path, size_t most, size_t *nx, size_t *ny, float **rgb, ff_error *err);
#endif
