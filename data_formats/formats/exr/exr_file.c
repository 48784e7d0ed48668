/* An OpenEXR file before OpenEXRCore sees it: header and list of chunks are checked against the size of the file, so that the
 * library is only handed images that hold together, and messages can name the byte. See "OpenEXR File Layout" on openexr.com.
 *
 *     76 2F 31 01                      magic
 *     u32                              version 2 in the lowest byte; 0x200 tiles, 0x400 names up to 255 bytes, 0x800 deep, 0x1000
 * parts name\0 type\0 i32 n, n bytes     attributes, up to an empty name u64 per chunk                    offsets i32 y, i32 n, n
 * bytes            chunks of 1, 16, 32 or 256 lines; in a line, a channel after the other, by name */
#define _GNU_SOURCE
#include "internal_exr.h"
#include "base/internal_bytes.h"
#include "base/internal_errno.h"
#include "base/internal_input.h"
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { MAGIC_BYTES = 8, NAME_BYTES = 255, ATTRIBUTES_MAX = 1024, CHANNELS_MAX = 16384, STREAM_MAX = INT_MAX, STEP = 1 << 16 };
enum { TILED = 0x200, LONG_NAMES = 0x400, DEEP = 0x800, PARTS = 0x1000 };

/* ---- bytes ----------------------------------------------------------------------------------- */

static ff_status ended(const ff_exr_file *f, const char *what)
{
    return ff_error_set(f->err, FF_ERR_READ, f->path, 0, f->size, "found the end of the file after %lld bytes, expected %s",
                        (long long)f->size, what);
}

ff_status ff_exr_bytes_at(ff_exr_file *f, int64_t offset, void *out, size_t n)
{
    if (offset < 0 || offset > f->size || n > (uint64_t)(f->size - offset)) return ended(f, "more of the image");
    if (f->whole) {
        memcpy(out, f->bytes + offset, n);
        return FF_OK;
    }
    for (size_t done = 0; done < n;) {
        const ssize_t got = pread(f->fd, (char *)out + done, n - done, offset + (int64_t)done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0)
            return ff_error_set(f->err, FF_ERR_READ, f->path, 0, offset, "cannot be read: %s",
                                ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
        if (got == 0) return ended(f, "more of the image");
        done += (size_t)got;
    }
    return FF_OK;
}

/* Makes the first n bytes available in f->bytes. */
static ff_status need(ff_exr_file *f, size_t n, const char *what)
{
    if (n <= f->n_bytes) return FF_OK;
    if (f->whole || n > (uint64_t)f->size) return ended(f, what);
    size_t larger = f->n_bytes + f->n_bytes / 2 + STEP;
    if (larger < n) larger = n;
    if (larger > (uint64_t)f->size) larger = (size_t)f->size;
    unsigned char *bytes = realloc(f->bytes, larger);
    if (!bytes) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, 0, -1, "no memory for a header of %zu bytes", larger);
    f->bytes = bytes;
    const ff_status status = ff_exr_bytes_at(f, (int64_t)f->n_bytes, bytes + f->n_bytes, larger - f->n_bytes);
    if (status == FF_OK) f->n_bytes = larger;
    return status;
}

static ff_status open_stream(ff_exr_file *f)
{
    ff_bytes b = {.path = f->path, .err = f->err, .fd = f->fd, .size = -1};
    const ff_status status = ff_bytes_rest(&b, STREAM_MAX, &f->bytes, &f->n_bytes);
    f->size = (int64_t)f->n_bytes;
    f->whole = 1;
    return status;
}

/* ---- attributes ------------------------------------------------------------------------------ */

/* A name at *at, of 1 to 255 bytes; *length is 0 for the empty one that ends the list. */
static ff_status read_name(ff_exr_file *f, size_t *at, const char *what, size_t *length)
{
    for (size_t n = 0; n <= NAME_BYTES; n++) {
        const ff_status status = need(f, *at + n + 1, what);
        if (status != FF_OK) return status;
        if (f->bytes[*at + n]) continue;
        *length = n;
        *at += n + 1;
        return FF_OK;
    }
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, (int64_t)*at, "found a name of more than %d bytes, expected %s",
                        NAME_BYTES, what);
}

/* One attribute at *at, which moves behind it and is 0 after the last. Its texts point into f->bytes. */
static ff_status read_attribute(ff_exr_file *f, size_t *at, size_t *end, ff_exr_attribute *out)
{
    const size_t name = *at;
    size_t length = 0;
    ff_status status = read_name(f, at, "the name of an attribute", &length);
    if (status == FF_OK && length == 0) {
        *end = *at;
        *at = 0;
        return FF_OK;
    }
    const size_t type = *at;
    if (status == FF_OK) status = read_name(f, at, "the type of an attribute", &length);
    if (status == FF_OK) status = need(f, *at + 4, "the size of an attribute");
    if (status != FF_OK) return status;
    const uint32_t n = ff_uint32_of(f->bytes + *at);
    const int64_t left = f->size - (int64_t)*at - 4;
    if (n > INT32_MAX || n > left)
        return ff_error_set(f->err, FF_ERR_READ, f->path, 0, (int64_t)*at,
                            "found an attribute of %lu bytes, expected at most the %lld that the file still has", (unsigned long)n,
                            (long long)left);
    *at += 4;
    status = need(f, *at + n, "the value of an attribute");
    const char *text = (const char *)f->bytes;
    if (status == FF_OK) *out = (ff_exr_attribute){text + name, text + type, f->bytes + *at, n, (int64_t)*at};
    *at += n;
    return status;
}

static ff_status check_doubled(const ff_exr_file *f)
{
    char found[FF_QUOTE];
    for (size_t k = 0; k < f->n_attributes; k++)
        for (size_t j = 0; j < k; j++)
            if (strcmp(f->attribute[j].name, f->attribute[k].name) == 0)
                return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, f->attribute[k].offset,
                                    "found the attribute %s twice, expected it once",
                                    ff_quote(f->attribute[k].name, strlen(f->attribute[k].name), found));
    return FF_OK;
}

/* Once to have the whole header in memory, which may move meanwhile, and once more for the list. */
static ff_status read_attributes(ff_exr_file *f, size_t *end)
{
    ff_exr_attribute a;
    size_t n = 0;
    for (size_t at = MAGIC_BYTES; at; n++) {
        const ff_status status = read_attribute(f, &at, end, &a);
        if (status != FF_OK) return status;
        if (n > ATTRIBUTES_MAX)
            return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a.offset, "found more than %d attributes, expected fewer",
                                ATTRIBUTES_MAX);
    }
    f->attribute = calloc(n, sizeof *f->attribute);
    if (!f->attribute) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, 0, -1, "no memory for the attributes of the header");
    f->n_attributes = n - 1;
    for (size_t k = 0, at = MAGIC_BYTES; k < f->n_attributes; k++) read_attribute(f, &at, end, &f->attribute[k]);
    return check_doubled(f);
}

const ff_exr_attribute *ff_exr_attribute_find(const ff_exr_file *f, const char *name)
{
    for (size_t k = 0; k < f->n_attributes; k++)
        if (strcmp(f->attribute[k].name, name) == 0) return &f->attribute[k];
    return NULL;
}

static ff_status bad_attribute(const ff_exr_file *f, const ff_exr_attribute *a, const char *expected)
{
    char type[FF_QUOTE], name[FF_QUOTE];
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset, "attribute %s: found the type %s with %zu bytes, expected %s",
                        ff_quote(a->name, strlen(a->name), name), ff_quote(a->type, strlen(a->type), type), a->n, expected);
}

/* Sizes that types of OpenEXR have; the library allocates and copies by them. -1: not fixed. */
static long size_of_type(const char *type)
{
    static const struct {
        const char *type;
        long n;
    } known[] = {{"box2i", 16},      {"box2f", 16},  {"chromaticities", 32},
                 {"compression", 1}, {"double", 8},  {"envmap", 1},
                 {"float", 4},       {"int", 4},     {"keycode", 28},
                 {"lineOrder", 1},   {"m33f", 36},   {"m33d", 72},
                 {"m44f", 64},       {"m44d", 128},  {"rational", 8},
                 {"timecode", 8},    {"v2i", 8},     {"v2f", 8},
                 {"v2d", 16},        {"v3i", 12},    {"v3f", 12},
                 {"v3d", 24},        {"tiledesc", 9}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (strcmp(type, known[k].type) == 0) return known[k].n;
    return -1;
}

static int string_vector_is_right(const ff_exr_attribute *a)
{
    size_t at = 0;
    while (at < a->n) {
        if (a->n - at < 4) return 0;
        const uint32_t n = ff_uint32_of(a->data + at);
        at += 4;
        if (n > a->n - at) return 0;
        at += n;
    }
    return 1;
}

static int preview_is_right(const ff_exr_attribute *a)
{
    if (a->n < 8) return 0;
    const uint64_t width = ff_uint32_of(a->data), height = ff_uint32_of(a->data + 4);
    return width < 1 << 14 && height < 1 << 14 && a->n - 8 == 4 * width * height;
}

static ff_status check_types(const ff_exr_file *f)
{
    for (size_t k = 0; k < f->n_attributes; k++) {
        const ff_exr_attribute *a = &f->attribute[k];
        const long n = size_of_type(a->type);
        char expected[32];
        snprintf(expected, sizeof expected, "%ld", n);
        if (n >= 0 && (size_t)n != a->n) return bad_attribute(f, a, expected);
        if (strcmp(a->type, "floatvector") == 0 && a->n % 4) return bad_attribute(f, a, "a multiple of 4");
        if (strcmp(a->type, "stringvector") == 0 && !string_vector_is_right(a))
            return bad_attribute(f, a, "texts that fill it, each after its length");
        if (strcmp(a->type, "preview") == 0 && !preview_is_right(a)) return bad_attribute(f, a, "a picture that fills it");
    }
    return FF_OK;
}

static ff_status required(const ff_exr_file *f, const char *name, const char *type, const ff_exr_attribute **out)
{
    const ff_exr_attribute *a = ff_exr_attribute_find(f, name);
    if (!a)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, MAGIC_BYTES,
                            "found no attribute '%s', which every OpenEXR image has", name);
    *out = a;
    return strcmp(a->type, type) == 0 ? FF_OK : bad_attribute(f, a, type);
}

/* ---- the image ------------------------------------------------------------------------------- */

static ff_status read_window(ff_exr_file *f)
{
    const ff_exr_attribute *a = NULL;
    const ff_status status = required(f, "dataWindow", "box2i", &a);
    if (status != FF_OK) return status;
    const int64_t x0 = (int32_t)ff_uint32_of(a->data), y0 = (int32_t)ff_uint32_of(a->data + 4);
    const int64_t x1 = (int32_t)ff_uint32_of(a->data + 8), y1 = (int32_t)ff_uint32_of(a->data + 12);
    f->width = x1 - x0 + 1;
    f->height = y1 - y0 + 1;
    f->first_x = x0;
    f->first_y = y0;
    const int64_t most = INT32_MAX / 4;
    if (f->width < 1 || f->height < 1 || f->width > most || f->height > most || x0 < -most || y0 < -most || x1 > most || y1 > most)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset,
                            "found a data window from (%lld, %lld) to (%lld, %lld), expected 1 to %lld pixels in each direction",
                            (long long)x0, (long long)y0, (long long)x1, (long long)y1, (long long)most);
    return FF_OK;
}

int ff_exr_chunk_lines(int compression)
{
    static const int lines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
    return lines[compression];
}

static ff_status read_compression(ff_exr_file *f)
{
    const ff_exr_attribute *a = NULL;
    const ff_status status = required(f, "compression", "compression", &a);
    if (status != FF_OK) return status;
    if (a->data[0] > EXR_COMPRESSION_DWAB)
        return ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, 0, a->offset,
                            "found the compression %d, expected 0 (none) to %d (DWAB)", a->data[0], EXR_COMPRESSION_DWAB);
    f->compression = a->data[0];
    return FF_OK;
}

static ff_status bad_channel(const ff_exr_file *f, const ff_exr_attribute *a, size_t at, const char *expected)
{
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, a->offset + (int64_t)at, "list of channels: channel %zu: expected %s",
                        f->n_channels + 1, expected);
}

/* name\0, i32 type, u8 linear, 3 bytes, i32 x sampling, i32 y sampling */
static ff_status read_channel(ff_exr_file *f, const ff_exr_attribute *a, size_t *at)
{
    const char *name = (const char *)a->data + *at;
    const size_t length = strnlen(name, a->n - *at);
    if (length > NAME_BYTES) return bad_channel(f, a, *at, "a name of at most 255 bytes");
    if (a->n - *at < length + 17) return bad_channel(f, a, *at, "a name and 16 bytes");
    const unsigned char *p = a->data + *at + length + 1;
    const uint32_t type = ff_uint32_of(p);
    if (type > EXR_PIXEL_FLOAT) return bad_channel(f, a, *at, "the type 0, 1 or 2 of its pixels");
    if (ff_uint32_of(p + 8) != 1 || ff_uint32_of(p + 12) != 1)
        return bad_channel(f, a, *at, "as many pixels as the image, not fewer");
    /* the library sorts them, and a list that is not in order has another order of data than the file */
    // NOLINTNEXTLINE(clang-analyzer-core.NonNullParamChecker): the channels before have their names
    if (f->n_channels && strcmp(f->channel[f->n_channels - 1].name, name) >= 0)
        return bad_channel(f, a, *at, "a name of its own, after the names before it");
    if (f->n_channels == CHANNELS_MAX) return bad_channel(f, a, *at, "at most 16384 channels");
    f->channel[f->n_channels++] = (ff_exr_channel){name, (int)type};
    *at += length + 17;
    return FF_OK;
}

static ff_status read_channels(ff_exr_file *f)
{
    const ff_exr_attribute *a = NULL;
    ff_status status = required(f, "channels", "chlist", &a);
    if (status != FF_OK) return status;
    f->channel = calloc(a->n / 18 + 1, sizeof *f->channel);
    if (!f->channel) return ff_error_set(f->err, FF_ERR_MEMORY, f->path, 0, -1, "no memory for the channels of the image");
    size_t at = 0;
    while (status == FF_OK && at < a->n && a->data[at]) status = read_channel(f, a, &at);
    if (status != FF_OK) return status;
    if (f->n_channels == 0 || at + 1 != a->n) return bad_channel(f, a, at, "at least one, and an empty name that ends the list");
    return FF_OK;
}

long ff_exr_channel_find(const ff_exr_file *f, const char *name)
{
    for (size_t c = 0; c < f->n_channels; c++)
        if (strcmp(f->channel[c].name, name) == 0) return (long)c;
    return -1;
}

static int64_t line_bytes(const ff_exr_file *f)
{
    int64_t pixel = 0;
    for (size_t c = 0; c < f->n_channels; c++) pixel += f->channel[c].type == EXR_PIXEL_HALF ? 2 : 4;
    return pixel * f->width; /* at most 2^16 x 2^29 */
}

/* ---- chunks ---------------------------------------------------------------------------------- */

/* Checks chunk k, which is said to be at `offset`; *used grows by its bytes. */
static ff_status check_chunk(ff_exr_file *f, int64_t k, uint64_t offset, int64_t begin, int64_t *used)
{
    unsigned char head[8];
    if (offset < (uint64_t)begin || offset > (uint64_t)f->size || (uint64_t)f->size - offset < sizeof head)
        return ff_error_set(
            f->err, FF_ERR_READ, f->path, 0, begin,
            "found chunk %lld of the image at byte %llu, expected it after the header and before the end of the file", (long long)k,
            (unsigned long long)offset);
    const ff_status status = ff_exr_bytes_at(f, (int64_t)offset, head, sizeof head);
    if (status != FF_OK) return status;
    const int lines = ff_exr_chunk_lines(f->compression);
    const int64_t y = (int32_t)ff_uint32_of(head), n = (int32_t)ff_uint32_of(head + 4), expected_y = f->first_y + k * lines;
    if (y != expected_y)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, (int64_t)offset, "found a chunk of line %lld, expected line %lld",
                            (long long)y, (long long)expected_y);
    const int64_t left = f->height - k * lines, most = line_bytes(f) * (left < lines ? left : lines);
    if (n < 1 || n > most || (f->compression == EXR_COMPRESSION_NONE && n != most))
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, (int64_t)offset + 4, "found a chunk of %lld bytes, expected %s%lld",
                            (long long)n, f->compression ? "1 to " : "", (long long)most);
    if (n > f->size - (int64_t)offset - 8) return ended(f, "the whole of every chunk");
    *used += n + 8;
    return FF_OK;
}

/* Every chunk in its place, and nothing but chunks after the header. */
static ff_status check_chunks(ff_exr_file *f, int64_t table)
{
    const int lines = ff_exr_chunk_lines(f->compression);
    const int64_t n = (f->height + lines - 1) / lines, begin = table + 8 * n;
    if (f->size < table || n > (f->size - table) / (8 + 8 + 1)) /* offset, head, data */
        return ended(f, "all lines of the image");
    if (line_bytes(f) > INT32_MAX / lines)
        return ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, 0, -1, "found lines of %lld bytes, expected at most %d",
                            (long long)line_bytes(f), INT32_MAX / lines);
    int64_t used = 0;
    for (int64_t k = 0; k < n; k++) {
        enum { AT_ONCE = 512 };
        unsigned char offsets[8 * AT_ONCE];
        ff_status status = FF_OK;
        if (k % AT_ONCE == 0) status = ff_exr_bytes_at(f, table + 8 * k, offsets, 8 * (size_t)(n - k < AT_ONCE ? n - k : AT_ONCE));
        if (status == FF_OK) status = check_chunk(f, k, ff_uint64_of(offsets + 8 * (k % AT_ONCE)), begin, &used);
        if (status != FF_OK) return status;
    }
    if (used == f->size - begin) return FF_OK;
    return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, begin,
                        "found %lld bytes after the header, expected the %lld of the chunks", (long long)(f->size - begin),
                        (long long)used);
}

static ff_status check_version(ff_exr_file *f)
{
    static const unsigned char magic[4] = {0x76, 0x2F, 0x31, 0x01};
    const ff_status status = need(f, MAGIC_BYTES, "the header of an OpenEXR image");
    if (status != FF_OK) return status;
    if (memcmp(f->bytes, magic, sizeof magic) != 0)
        return ff_error_set(f->err, FF_ERR_FORMAT, f->path, 0, 0,
                            "found the bytes %02x %02x %02x %02x, expected 76 2f 31 01 of OpenEXR", f->bytes[0], f->bytes[1],
                            f->bytes[2], f->bytes[3]);
    const uint32_t version = ff_uint32_of(f->bytes + 4);
    const char *kind = version & PARTS ? "several parts" : version & DEEP ? "deep pixels" : version & TILED ? "tiles" : NULL;
    if (kind)
        return ff_error_set(
            f->err, FF_ERR_UNSUPPORTED, f->path, 0, 4,
            "found an image of %s, expected one part of scan lines, as tables of reflectance have; pictures are read "
            "through a CSV that lists them, one image per pair of directions",
            kind);
    if ((version & ~(uint32_t)LONG_NAMES) != 2)
        return ff_error_set(f->err, FF_ERR_UNSUPPORTED, f->path, 0, 4, "found version and flags %lx, expected version 2",
                            (unsigned long)version);
    return FF_OK;
}

ff_status ff_exr_open(const char *path, ff_exr_file *out, ff_error *err)
{
    ff_exr_file f = {.path = path, .err = err};
    size_t end = 0;
    ff_status status = ff_input_open(path, &f.fd, &f.size, err);
    if (status != FF_OK) return status;
    if (f.size < 0 || lseek(f.fd, 0, SEEK_CUR) != 0) status = open_stream(&f);
    if (status == FF_OK) status = check_version(&f);
    if (status == FF_OK) status = read_attributes(&f, &end);
    if (status == FF_OK) status = check_types(&f);
    if (status == FF_OK) status = read_window(&f);
    if (status == FF_OK) status = read_compression(&f);
    if (status == FF_OK) status = read_channels(&f);
    if (status == FF_OK) status = check_chunks(&f, (int64_t)end);
    if (status != FF_OK)
        ff_exr_close(&f);
    else
        *out = f;
    return status;
}

void ff_exr_close(ff_exr_file *f)
{
    close(f->fd);
    free(f->bytes);
    free(f->attribute);
    free(f->channel);
    *f = (ff_exr_file){.fd = -1};
}
