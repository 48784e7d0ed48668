/* A small lit sphere of a result, as the index of a batch shows it. */
#include "internal_batch.h"
#include "base/internal_kept.h"
#include "ff_render.h"
#include "report/ff_fit_document.h"
#include <stdlib.h>

enum { PIXELS = BATCH_THUMBNAIL };

static void put_base64(const unsigned char *bytes, size_t n, FILE *out)
{
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < n; i += 3) {
        const unsigned second = i + 1 < n ? bytes[i + 1] : 0u, third = i + 2 < n ? bytes[i + 2] : 0u;
        const unsigned all = (unsigned)bytes[i] << 16 | second << 8 | third;
        fputc(digit[all >> 18], out);
        fputc(digit[all >> 12 & 63], out);
        fputc(i + 1 < n ? digit[all >> 6 & 63] : '=', out);
        fputc(i + 2 < n ? digit[all & 63] : '=', out);
    }
}

static ff_status put_png(const float *rgba, FILE *out, ff_error *err)
{
    unsigned char *png = NULL;
    size_t n;
    ff_render_sheet sheet;
    const ff_render_cell cell = {rgba, NULL, FF_CELL_PICTURE};
    ff_render_sheet_init(&sheet);
    sheet.pixels = PIXELS;
    sheet.n = 1;
    sheet.cell = &cell;
    sheet.background = FF_BACKGROUND_TRANSPARENT;
    const ff_status status = ff_render_png(&sheet, &png, &n, err);
    if (status == FF_OK) put_base64(png, n, out);
    ff_render_png_free(png);
    return status;
}

/* On one thread, and scalar: the same bits on every machine. */
static ff_status draw(const ff_fitted *f, FILE *out, ff_error *err)
{
    static const double light[1][3] = {{-0.5, 0.5, 0.70710678118654752}}; /* 45 degrees from the view, up to the left */
    const size_t n = f->n_channels;
    float *rgba = malloc(sizeof(float[4]) * PIXELS * PIXELS);
    double *grey = malloc(3 * n * sizeof *grey);
    ff_render_options o;
    for (size_t k = 0; k < 3 * n && grey; k++) grey[k] = 1.0 / (double)n;
    ff_render_options_init(&o);
    o.pixels = PIXELS;
    o.n_lights = 1;
    o.light = light;
    o.threads = 1;
    o.isa = FF_ISA_SCALAR;
    if (n != 1 && n != 3) o.colours = grey; /* their mean */
    ff_status status = rgba && grey ? FF_OK : FF_ERR_MEMORY;
    if (status == FF_OK) status = ff_render_model(&f->model, f->n_channels, f->shape, f->channel, &o, rgba, NULL, err);
    if (status == FF_OK) status = put_png(rgba, out, err);
    free(grey);
    free(rgba);
    return status;
}

char *batch_thumbnail(const char *text, size_t n)
{
    ff_fit_document *d;
    ff_kept kept;
    ff_error err;
    if (ff_fit_document_parse(text, n, NULL, &d, &err) != FF_OK) return NULL;
    FILE *stream = ff_kept_open(&kept);
    const int drawn = stream && draw(&d->fit[d->best], stream, &err) == FF_OK;
    if (ff_kept_close(&kept, stream) == FF_OK && !drawn) {
        free(kept.text);
        kept.text = NULL;
    }
    ff_fit_document_free(d);
    return kept.text;
}
