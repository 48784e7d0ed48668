/* Sheets of pictures as an OpenEXR image of linear floats. */
#include "internal_render.h"
#include "data_formats/formats/exr/internal_exr.h"
#include <stdlib.h>
#include <string.h>

enum { LAYERS_MAX = 64, NAME = 72 };
static const size_t most_pixels = (size_t)1 << 28;

/* The cells of a layer where they are in the sheet; [ny][nx][4]. */
static void tile(const ff_render_sheet *s, size_t columns, const ff_render_cell *cell, float *out)
{
    const size_t row = 4 * s->pixels;
    for (size_t k = 0; k < s->n; k++)
        for (size_t j = 0; j < s->pixels; j++)
            memcpy(out + (k / columns * s->pixels + j) * columns * row + k % columns * row, cell[k].rgba + j * row,
                   row * sizeof *out);
}

static ff_status check(const ff_render_sheet *s, size_t n_layers, const ff_render_layer *layer, size_t columns, ff_error *err)
{
    const size_t rows = columns ? (s->n + columns - 1) / columns : 0;
    if (s->pixels < 1 || s->pixels > FF_RENDER_PIXELS_MAX || s->n < 1 || n_layers < 1 || n_layers > LAYERS_MAX ||
        (double)columns * (double)rows * (double)s->pixels * (double)s->pixels * (double)n_layers > (double)most_pixels ||
        columns * s->pixels > INT32_MAX / 2 || rows * s->pixels > INT32_MAX / 2)
        return ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "%zu layers of %zu pictures of %zu pixels a side, expected 1 to %d layers and less than 2^28 pixels in all", n_layers,
            s->n, s->pixels, LAYERS_MAX);
    for (size_t k = 0; k < n_layers; k++) {
        int again = strlen(layer[k].name) >= NAME - 2;
        for (size_t i = 0; i < k; i++) again |= !strcmp(layer[i].name, layer[k].name);
        if (again)
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                                "layer %zu: found '%.80s', expected a name of its own of at most %d bytes", k, layer[k].name,
                                NAME - 3);
    }
    return FF_OK;
}

static void name_channels(size_t n_layers, const ff_render_layer *layer, const float *tiled, size_t size, char (*name)[NAME],
                          ff_exr_samples *samples)
{
    for (size_t k = 0; k < n_layers; k++)
        for (size_t c = 0; c < 4; c++) {
            snprintf(name[4 * k + c], NAME, "%s%s%c", layer[k].name, *layer[k].name ? "." : "", "RGBA"[c]);
            samples[4 * k + c] = (ff_exr_samples){name[4 * k + c], tiled + k * size + c, 4};
        }
}

ff_status ff_render_exr(const char *path, const ff_render_sheet *s, size_t n_layers, const ff_render_layer *layer, ff_error *err)
{
    const size_t columns = s->columns ? s->columns : s->n;
    ff_status status = check(s, n_layers, layer, columns, err);
    if (status != FF_OK) return status;
    const size_t width = columns * s->pixels, height = (s->n + columns - 1) / columns * s->pixels, size = 4 * width * height;
    float *tiled = calloc(n_layers * size, sizeof *tiled);
    char(*name)[NAME] = malloc(4 * n_layers * sizeof *name);
    ff_exr_samples *samples = malloc(4 * n_layers * sizeof *samples);
    if (tiled && name && samples) {
        for (size_t k = 0; k < n_layers; k++) tile(s, columns, layer[k].cell, tiled + k * size);
        name_channels(n_layers, layer, tiled, size, name, samples);
        status = ff_exr_picture_write(path, &(ff_exr_picture){width, height, 4 * n_layers, samples}, err);
    } else {
        status = ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for an image of %zu x %zu pixels", width, height);
    }
    free(tiled);
    free(name);
    free(samples);
    return status;
}
