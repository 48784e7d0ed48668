/* Planes of a table from the channels of an OpenEXR image, through OpenEXRCore. Sample i is the pixel at x, y with i = y width + x;
 * pixels after the last sample are filling. */
#define _GNU_SOURCE
#include "internal_exr.h"
#include "base/internal_bytes.h"
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- OpenEXRCore ----------------------------------------------------------------------------- */

/* Whose context works in this thread. The context itself cannot be asked in a handler: what calls it may have it locked, and waits
 * for itself. */
static _Thread_local ff_exr_io *current;

static void keep_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    ff_exr_io *io = current;
    if (!io) return;
    io->code = code;
    size_t n = strnlen(message, sizeof io->message - 1);
    memcpy(io->message, message, n);
    io->message[n] = '\0';
}

/* More is asked for by a damaged file only. */
static const size_t most_plausible = (size_t)1 << 32;

static void *allocate(size_t bytes)
{
    void *p = malloc(bytes);
    if (!p && current && bytes <= most_plausible) current->no_memory = 1;
    return p;
}

exr_result_t ff_exr_finish(exr_context_t *context)
{
    const exr_result_t r = *context ? exr_finish(context) : EXR_ERR_SUCCESS;
    current = NULL;
    return r;
}

exr_context_initializer_t ff_exr_initializer(ff_exr_io *io)
{
    current = io;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_error;
    init.alloc_fn = allocate;
    init.free_fn = free;
    init.user_data = io;
    return init;
}

ff_status ff_exr_failed(const ff_exr_io *io, exr_result_t result, const char *path, const char *expected, ff_error *err)
{
    if (result == EXR_ERR_OUT_OF_MEMORY || io->no_memory)
        return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for the image");
    if (result == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, path, 0, -1,
                            "this version of OpenEXRCore cannot read the image (%s), expected another compression, best none",
                            io->message[0] ? io->message : "not implemented");
    const char *message = io->message[0] ? io->message : exr_get_default_error_message(result);
    return ff_error_set(err, result == EXR_ERR_READ_IO ? FF_ERR_READ : FF_ERR_FORMAT, path, 0, -1,
                        "OpenEXR refuses it (%s), expected %s", message, expected);
}

static int64_t read_at(exr_const_context_t context, void *user, void *out, uint64_t n, uint64_t offset,
                       exr_stream_error_func_ptr_t report)
{
    ff_exr_file *f = ((ff_exr_io *)user)->in;
    if (offset > (uint64_t)f->size) {
        report(context, EXR_ERR_READ_IO, "read beyond the end of the file");
        return -1;
    }
    if (n > (uint64_t)f->size - offset) n = (uint64_t)f->size - offset; /* the library looks ahead */
    if (ff_exr_bytes_at(f, (int64_t)offset, out, (size_t)n) == FF_OK) return (int64_t)n;
    report(context, EXR_ERR_READ_IO, "the file cannot be read");
    return -1;
}

static int64_t size_of(exr_const_context_t context, void *user)
{
    (void)context;
    return ((ff_exr_io *)user)->in->size;
}

/* ---- planes ---------------------------------------------------------------------------------- */

ff_status ff_exr_plane_find(const ff_exr_file *f, ff_exr_plane *plane)
{
    char high[320], low[320], found[FF_ERROR_MESSAGE / 2] = "";
    snprintf(high, sizeof high, "%s" FF_EXR_HIGH, plane->name);
    snprintf(low, sizeof low, "%s" FF_EXR_LOW, plane->name);
    plane->channel = ff_exr_channel_find(f, plane->name);
    plane->low = -1;
    if (plane->channel >= 0 && f->channel[plane->channel].type != EXR_PIXEL_UINT) return FF_OK;
    plane->channel = ff_exr_channel_find(f, high);
    plane->low = ff_exr_channel_find(f, low);
    if (plane->channel >= 0 && plane->low >= 0 && f->channel[plane->channel].type == EXR_PIXEL_UINT &&
        f->channel[plane->low].type == EXR_PIXEL_UINT)
        return FF_OK;
    for (size_t c = 0; c < f->n_channels && strlen(found) + 40 < sizeof found; c++)
        snprintf(found + strlen(found), 40, "%s%.30s", c ? ", " : "", f->channel[c].name);
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, -1,
                        "found the channels %s, expected '%.80s' of floating point, or '%.80s" FF_EXR_HIGH "' and '%.80s" FF_EXR_LOW
                        "' of unsigned integers",
                        found, plane->name, plane->name, plane->name);
}

/* ---- one chunk ------------------------------------------------------------------------------- */

typedef struct pixels {
    ff_exr_file *f;
    ff_exr_io io;
    exr_context_t context;
    exr_decode_pipeline_t pipe;
    int open; /* the pipe is */
    const ff_exr_plane *planes;
    size_t n_planes;
    ff_table *t;
    uint32_t **line; /* [f->n_channels]: pixels of a chunk, NULL where no plane wants them */
    uint32_t *storage;
} pixels;

static void from_floats(const float *restrict in, size_t n, double *restrict out)
{
    for (size_t i = 0; i < n; i++) out[i] = (double)in[i];
}

static void from_halves_of_doubles(const uint32_t *restrict high, const uint32_t *restrict low, size_t n, double *restrict out)
{
    for (size_t i = 0; i < n; i++) {
        const uint64_t u = (uint64_t)high[i] << 32 | low[i];
        memcpy(out + i, &u, sizeof u);
    }
}

/* NaN was not measured and becomes 0. Returns 0 when there is an infinity. */
static int take_values(double *restrict v, size_t n, unsigned char *restrict valid)
{
    if (ff_all_finite(v, n)) return 1;
    int infinite = 0;
    for (size_t i = 0; i < n; i++) {
        infinite |= fabs(v[i]) > DBL_MAX;
        valid[i] = (unsigned char)(valid[i] & (v[i] == v[i]));
        v[i] = v[i] == v[i] ? v[i] : 0;
    }
    return !infinite;
}

static ff_status bad_pixel(const pixels *p, const ff_exr_plane *plane, size_t i, const char *expected)
{
    char found[40];
    snprintf(found, sizeof found, "%.9g", plane->to[i]);
    const size_t width = (size_t)p->f->width;
    return ff_error_set(p->f->err, FF_ERR_DATA, p->f->path, 0, -1, "channel '%s', pixel (%zu, %zu): found %s, expected %s",
                        plane->name, i % width, i / width, found, expected);
}

/* Samples first .. first+n-1 of a plane from pixel `at` of the chunk on. */
static ff_status take_block(const pixels *p, const ff_exr_plane *plane, size_t at, size_t first, size_t n)
{
    double *to = plane->to + first;
    const uint32_t *from = p->line[plane->channel] + at;
    if (plane->low >= 0)
        from_halves_of_doubles(from, p->line[plane->low] + at, n, to);
    else
        from_floats((const float *)from, n, to);
    if (plane->role == FF_EXR_VALUE ? take_values(to, n, p->t->valid + first) : ff_all_finite(to, n)) return FF_OK;
    if (plane->role == FF_EXR_SIGMA) return FF_OK; /* of invalid samples anything: looked at when all planes are there */
    size_t i = first;
    while (isfinite(plane->to[i])) i++;
    return bad_pixel(p, plane, i, "a finite number");
}

/* In blocks that are looked at again while they are in the cache. */
static ff_status take_plane(const pixels *p, const ff_exr_plane *plane, size_t first, size_t n)
{
    enum { BLOCK = 256 };
    for (size_t at = 0; at < n; at += BLOCK) {
        const ff_status status = take_block(p, plane, at, first + at, n - at < BLOCK ? n - at : BLOCK);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

/* Standard deviations and weights, once it is known which samples are valid. */
static ff_status check_plane(const pixels *p, const ff_exr_plane *plane)
{
    const unsigned char *valid = p->t->valid;
    for (size_t i = 0; i < p->t->n; i++) {
        double *v = plane->to + i;
        if (plane->role == FF_EXR_WEIGHT && !(*v >= 0)) return bad_pixel(p, plane, i, "a weight >= 0");
        if (plane->role == FF_EXR_SIGMA && valid[i] && !(*v > 0 && isfinite(*v)))
            return bad_pixel(p, plane, i, "a standard deviation > 0");
        if (plane->role == FF_EXR_SIGMA && !valid[i]) *v = 0;
    }
    return FF_OK;
}

/* ---- all chunks ------------------------------------------------------------------------------ */

/* Where the pixels of the channels go: into lines, one channel after the other, as the library can read them at once. */
static ff_status set_lines(pixels *p)
{
    const ff_exr_file *f = p->f;
    const size_t at_once = (size_t)f->width * (size_t)ff_exr_chunk_lines(f->compression);
    unsigned char *wanted = calloc(f->n_channels, 1);
    p->line = calloc(f->n_channels, sizeof *p->line);
    if (!wanted || !p->line) {
        free(wanted);
        return ff_error_set(f->err, FF_ERR_MEMORY, f->path, 0, -1, "no memory for %zu channels", f->n_channels);
    }
    size_t n = 0;
    for (size_t k = 0; k < p->n_planes; k++) {
        wanted[p->planes[k].channel] = 1;
        if (p->planes[k].low >= 0) wanted[p->planes[k].low] = 1;
    }
    for (size_t c = 0; c < f->n_channels; c++) n += wanted[c];
    p->storage = malloc((n * at_once + 1) * sizeof *p->storage);
    for (size_t c = 0, used = 0; c < f->n_channels && p->storage; c++)
        if (wanted[c]) p->line[c] = p->storage + at_once * used++;
    free(wanted);
    return p->storage ? FF_OK : ff_error_set(f->err, FF_ERR_MEMORY, f->path, 0, -1, "no memory for %zu channels", n);
}

static exr_result_t open_pipe(pixels *p, const exr_chunk_info_t *chunk)
{
    exr_result_t r = exr_decoding_initialize(p->context, 0, chunk, &p->pipe);
    if (r != EXR_ERR_SUCCESS) return r;
    p->open = 1;
    if ((size_t)p->pipe.channel_count != p->f->n_channels) return EXR_ERR_INVALID_ATTR;
    for (size_t c = 0; c < p->f->n_channels; c++) {
        exr_coding_channel_info_t *to = &p->pipe.channels[c];
        if (strcmp(to->channel_name, p->f->channel[c].name) != 0) return EXR_ERR_INVALID_ATTR;
        to->user_bytes_per_element = 4;
        to->user_data_type = to->data_type == EXR_PIXEL_UINT ? EXR_PIXEL_UINT : EXR_PIXEL_FLOAT;
        to->user_pixel_stride = 4;
        to->user_line_stride = (int32_t)(4 * p->f->width);
        to->decode_to_ptr = (uint8_t *)p->line[c];
    }
    return exr_decoding_choose_default_routines(p->context, 0, &p->pipe);
}

/* The library moves the pointers of the channels as it decodes. */
static exr_result_t decode(pixels *p, int64_t y)
{
    exr_chunk_info_t chunk;
    exr_result_t r = exr_read_scanline_chunk_info(p->context, 0, (int)(p->f->first_y + y), &chunk);
    if (r == EXR_ERR_SUCCESS) r = p->open ? exr_decoding_update(p->context, 0, &chunk, &p->pipe) : open_pipe(p, &chunk);
    for (size_t c = 0; c < p->f->n_channels && r == EXR_ERR_SUCCESS; c++) p->pipe.channels[c].decode_to_ptr = (uint8_t *)p->line[c];
    return r == EXR_ERR_SUCCESS ? exr_decoding_run(p->context, 0, &p->pipe) : r;
}

static ff_status read_chunks(pixels *p)
{
    const int lines = ff_exr_chunk_lines(p->f->compression);
    const size_t width = (size_t)p->f->width;
    for (int64_t y = 0; y < p->f->height; y += lines) {
        const size_t first = (size_t)y * width;
        if (first >= p->t->n) break;
        exr_result_t r = decode(p, y);
        if (r == EXR_ERR_OUT_OF_MEMORY) r = EXR_ERR_CORRUPT_CHUNK; /* what the decoders of PIZ and B44 say of damaged data */
        if (r != EXR_ERR_SUCCESS) return ff_exr_failed(&p->io, r, p->f->path, "a whole image", p->f->err);
        const size_t there = width * (size_t)lines, n = p->t->n - first < there ? p->t->n - first : there;
        for (size_t k = 0; k < p->n_planes; k++) {
            const ff_status status = take_plane(p, &p->planes[k], first, n);
            if (status != FF_OK) return status;
        }
    }
    for (size_t k = 0; k < p->n_planes; k++) {
        const int later = p->planes[k].role == FF_EXR_SIGMA || p->planes[k].role == FF_EXR_WEIGHT;
        const ff_status status = !later ? FF_OK : check_plane(p, &p->planes[k]);
        if (status != FF_OK) return status;
    }
    return FF_OK;
}

ff_status ff_exr_pixels_read(ff_exr_file *f, const ff_exr_plane *planes, size_t n_planes, ff_table *t)
{
    pixels p = {.f = f, .planes = planes, .n_planes = n_planes, .t = t, .io = {.in = f}};
    ff_status status = set_lines(&p);
    if (status == FF_OK) {
        exr_context_initializer_t init = ff_exr_initializer(&p.io);
        init.read_fn = read_at;
        init.size_fn = size_of;
        init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
        const exr_result_t r = exr_start_read(&p.context, f->path, &init);
        status = r == EXR_ERR_SUCCESS ? read_chunks(&p) : ff_exr_failed(&p.io, r, f->path, "an image", f->err);
        if (p.open) exr_decoding_destroy(p.context, &p.pipe);
        ff_exr_finish(&p.context);
    }
    free(p.line);
    free(p.storage);
    return status;
}
