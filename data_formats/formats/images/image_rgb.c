/* An image for whoever needs its pixels, not a mean of them. */
#include "internal_image_rgb.h"
#include "internal_image_check.h"
#include "internal_stack.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Which channels are red, green and blue; 0 where there are none. */
static int find_colours(const ff_image_info *info, size_t channel[3])
{
    static const char *const name[3] = {"R", "G", "B"};
    size_t light[FF_IMAGE_CHANNELS], n = 0;
    int found = 0;
    for (size_t c = 0; c < info->n_channels; c++) {
        if ((long)c != info->alpha) light[n++] = c;
        for (int k = 0; k < 3; k++)
            if (!strcasecmp(info->name[c], name[k])) {
                channel[k] = c;
                found |= 1 << k;
            }
    }
    if (found == 7) return 1;
    for (size_t k = 0; k < 3 && n; k++) channel[k] = light[n >= 3 ? k : 0];
    return n == 1 || n >= 3;
}

static ff_status check(const char *path, const ff_image_info *info, size_t most, ff_error *err)
{
    const ff_curve curve = ff_encoding_of(info->encoding).curve;
    char found[FF_QUOTE];
    if ((size_t)info->width > most || (size_t)info->height > most)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "found %ld x %ld pixels, expected at most %zu a side",
                            info->width, info->height, most);
    if (curve == FF_CURVE_LINEAR || (curve == FF_CURVE_UNKNOWN && info->bits == 0 && !*info->encoding)) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                        "found numbers whose encoding is %s, expected linear ones, as in OpenEXR and Radiance HDR",
                        *info->encoding ? ff_quote(info->encoding, strlen(info->encoding), found) : "not said");
}

static ff_status read_lines(const ff_image_reader *reader, ff_image *image, const ff_image_info *info, const size_t channel[3],
                            float *band, float *rgb, ff_error *err)
{
    const size_t width = (size_t)info->width;
    for (long y = 0; y < info->height; y += info->band) {
        const long left = info->height - y, count = left < info->band ? left : info->band;
        const ff_status status = reader->lines(image, y, count, band, err);
        if (status != FF_OK) return status;
        for (size_t k = 0; k < width * (size_t)count; k++)
            for (size_t c = 0; c < 3; c++) rgb[3 * ((size_t)y * width + k) + c] = band[k * info->n_channels + channel[c]];
    }
    return FF_OK;
}

static ff_status read_image(const ff_image_reader *reader, ff_image *image, const ff_image_info *info, const char *path,
                            float **rgb, ff_error *err)
{
    size_t channel[3];
    const size_t line = (size_t)info->width * info->n_channels;
    if (!find_colours(info, channel))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1, "found %zu channels, expected one, or red, green and blue",
                            info->n_channels);
    float *band = malloc(line * (size_t)info->band * sizeof *band),
          *out = malloc(3 * (size_t)info->width * (size_t)info->height * sizeof *out);
    const ff_status status = band && out ? read_lines(reader, image, info, channel, band, out, err)
                                         : ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the image");
    free(band);
    if (status != FF_OK)
        free(out);
    else
        *rgb = out;
    return status;
}

ff_status ff_image_rgb_read(const char *path, size_t most, size_t *nx, size_t *ny, float **rgb, ff_error *err)
{
    const ff_image_reader *reader;
    const char *kind = NULL;
    ff_image *image = NULL;
    ff_image_info *info = malloc(sizeof *info);
    if (!info) return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for an image");
    ff_status status = ff_image_check(path, &kind, err);
    if (status == FF_OK) status = ff_image_reader_get(&reader, err);
    if (status == FF_OK) status = reader->open(path, kind, &image, info, err);
    if (status == FF_OK) {
        status = check(path, info, most, err);
        if (status == FF_OK) status = read_image(reader, image, info, path, rgb, err);
        if (status == FF_OK) {
            *nx = (size_t)info->width;
            *ny = (size_t)info->height;
        }
        reader->close(image);
    }
    free(info);
    return status;
}
