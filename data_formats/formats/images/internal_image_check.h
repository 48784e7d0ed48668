/** @file internal_image_check.h  An image before a library sees it: what it is, and whether its parts fit into its file. */
#ifndef FF_INTERNAL_IMAGE_CHECK_H
#define FF_INTERNAL_IMAGE_CHECK_H
#include "ff_status.h"

/** The kind of an image by its content, in OpenImageIO's words ("png", "tiff", ...), a static string. FF_ERR_OPEN, FF_ERR_READ;
 *  FF_ERR_UNSUPPORTED for what is none of the kinds that are read; FF_ERR_FORMAT for a PNG or OpenEXR file with a part that says it
 *  is larger than the rest of the file, for which the libraries would take memory. */
ff_status ff_image_check(const char *path, const char **kind, ff_error *err);
#endif
