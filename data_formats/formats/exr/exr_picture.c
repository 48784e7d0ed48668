/* A picture as an OpenEXR image: named channels of 32-bit floats, without compression. */
#include "internal_exr.h"
#include "base/internal_bytes.h"
#include <stdlib.h>

typedef struct writer {
    const ff_exr_picture *p;
    ff_exr_output *out;
    const ff_exr_samples **order; /* [n] as the file has them */
    unsigned char *line;
} writer;

static exr_result_t write_header(const writer *w)
{
    int index;
    const exr_context_t context = w->out->context;
    const int32_t width = (int32_t)w->p->width, height = (int32_t)w->p->height;
    exr_result_t r = exr_set_longname_support(context, 1);
    if (r == EXR_ERR_SUCCESS) r = exr_add_part(context, "picture", EXR_STORAGE_SCANLINE, &index);
    if (r == EXR_ERR_SUCCESS) r = exr_initialize_required_attr_simple(context, 0, width, height, EXR_COMPRESSION_NONE);
    for (size_t k = 0; k < w->p->n && r == EXR_ERR_SUCCESS; k++)
        r = exr_add_channel(context, 0, w->p->samples[k].name, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return r;
}

/* The library keeps the channels in the order of the file. */
static exr_result_t order_samples(writer *w)
{
    const exr_attr_chlist_t *list;
    size_t found = 0;
    const exr_result_t r = exr_get_channels(w->out->context, 0, &list);
    if (r != EXR_ERR_SUCCESS) return r;
    for (int c = 0; c < list->num_channels; c++)
        for (size_t k = 0; k < w->p->n; k++)
            if (strcmp(list->entries[c].name.str, w->p->samples[k].name) == 0) w->order[found++] = &w->p->samples[k];
    return found == w->p->n && list->num_channels == (int)found ? exr_write_header(w->out->context) : EXR_ERR_INVALID_ATTR;
}

static exr_result_t write_line(const writer *w, size_t y)
{
    unsigned char *to = w->line;
    for (size_t k = 0; k < w->p->n; k++)
        for (size_t x = 0; x < w->p->width; x++, to += 4)
            ff_bytes_of_float(w->order[k]->at[(y * w->p->width + x) * w->order[k]->stride], to);
    return exr_write_scanline_chunk(w->out->context, 0, (int)y, w->line, (uint64_t)(to - w->line));
}

/* An ff_exr_body of an ff_exr_picture. */
static ff_status write_picture(ff_exr_output *out, void *context)
{
    writer w = {.p = context, .out = out};
    w.order = malloc(w.p->n * sizeof *w.order);
    w.line = malloc(w.p->n * w.p->width * 4);
    ff_status status = w.order && w.line ? FF_OK : FF_ERR_MEMORY;
    if (status == FF_OK) {
        exr_result_t r = write_header(&w);
        if (r == EXR_ERR_SUCCESS) r = order_samples(&w);
        for (size_t y = 0; y < w.p->height && r == EXR_ERR_SUCCESS && !out->broken; y++) r = write_line(&w, y);
        status = ff_exr_output_result(out, r, "a picture that it can hold");
    } else {
        ff_error_set(out->err, status, out->path, 0, -1, "no memory for a line of %zu pixels", w.p->width);
    }
    free(w.order);
    free(w.line);
    return status;
}

ff_status ff_exr_picture_write(const char *path, const ff_exr_picture *p, ff_error *err)
{
    ff_exr_picture own = *p;
    return ff_exr_output_write(path, write_picture, &own, err);
}
