/* What an image is, by its first bytes. The kinds are those that cameras, their programs and renderers write. OpenImageIO knows
 * many more, but tries one after the other on a file that none of them fits, and some are not made for damaged files: one flipped
 * bit of an SGI image ends the process, one of a DPX image takes 1.5 GB (OpenImageIO 2.4.7). */
#define _GNU_SOURCE
#include "internal_image_check.h"
#include "base/internal_bytes.h"
#include "base/internal_input.h"
#include <stdio.h>
#include <stdlib.h>
#include <strings.h>
#include <unistd.h>

enum { HEAD = 16 };

static int is_pnm(const unsigned char *h)
{
    return h[0] == 'P' && ((h[1] >= '1' && h[1] <= '6') || h[1] == 'f' || h[1] == 'F') &&
           (h[2] == ' ' || h[2] == '\n' || h[2] == '\r');
}

static const char *extension(const char *path)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    return dot ? dot + 1 : "";
}

/* Camera raw files look like TIFF and hold a small preview where an image would stand. */
static int is_raw(const char *path)
{
    static const char *const raw[] = {"cr2", "cr3", "nef", "nrw", "arw", "sr2", "dng",
                                      "orf", "rw2", "pef", "srw", "raf", "3fr", "iiq"};
    for (size_t k = 0; k < sizeof raw / sizeof raw[0]; k++)
        if (strcasecmp(extension(path), raw[k]) == 0) return 1;
    return 0;
}

static const char *kind_of(const unsigned char h[HEAD], const char *path)
{
    static const struct {
        const char *bytes;
        size_t n;
        const char *kind;
    } known[] = {{"\x89PNG\r\n\x1A\n", 8, "png"},
                 {"\xFF\xD8\xFF", 3, "jpeg"},
                 {"II*\0", 4, "tiff"},
                 {"MM\0*", 4, "tiff"},
                 {"II+\0", 4, "tiff"},
                 {"MM\0+", 4, "tiff"},
                 {"\x76\x2F\x31\x01", 4, "openexr"},
                 {"#?RADIANCE", 10, "hdr"},
                 {"#?RGBE", 6, "hdr"},
                 {"\0\0\0\x0CjP  ", 8, "jpeg2000"},
                 {"BM", 2, "bmp"}};
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (memcmp(h, known[k].bytes, known[k].n) == 0) return known[k].kind;
    if (memcmp(h, "RIFF", 4) == 0 && memcmp(h + 8, "WEBP", 4) == 0) return "webp";
    if (is_pnm(h)) return "pnm";
    return strcasecmp(extension(path), "tga") == 0 ? "targa" : NULL; /* which has no first bytes of its own */
}

static ff_status too_large(const ff_bytes *b, int64_t at, const char *what, uint64_t n)
{
    return ff_error_set(b->err, FF_ERR_FORMAT, b->path, 0, at,
                        "found %s of %llu bytes, expected at most the %lld that the file still has", what, (unsigned long long)n,
                        (long long)(b->size - at));
}

static ff_status skip(ff_bytes *b, uint64_t n)
{
    b->offset += (int64_t)n;
    if (lseek(b->fd, b->offset, SEEK_SET) == b->offset) return FF_OK;
    return ff_error_set(b->err, FF_ERR_READ, b->path, 0, b->offset, "cannot be read");
}

/* Chunks: u32 (high byte first) n, type, n bytes, u32. */
static ff_status check_png(ff_bytes *b)
{
    unsigned char head[8];
    ff_status status = skip(b, 8);
    while (status == FF_OK && b->size - b->offset >= 8) {
        status = ff_bytes_read(b, head, sizeof head, "a chunk of a PNG image");
        if (status != FF_OK) break;
        const uint64_t n = (uint64_t)head[0] << 24 | (uint64_t)head[1] << 16 | (uint64_t)head[2] << 8 | head[3];
        if (n + 4 > (uint64_t)(b->size - b->offset)) return too_large(b, b->offset, "a chunk", n);
        if (memcmp(head + 4, "IEND", 4) == 0) break;
        status = skip(b, n + 4);
    }
    return status;
}

/* A text of at most 255 bytes that ends in 0. */
static ff_status read_text(ff_bytes *b, char text[256])
{
    for (size_t length = 0; length < 256; length++) {
        const ff_status status = ff_bytes_read(b, text + length, 1, "a name in the header of an OpenEXR image");
        if (status != FF_OK || text[length] == '\0') return status;
    }
    return ff_error_set(b->err, FF_ERR_FORMAT, b->path, 0, b->offset,
                        "found a name of more than 255 bytes, expected one in a header");
}

/* Types whose size is fixed. The library reads as many bytes as the type has, whatever the file says, and goes on from there: with
 * another size it would take anything for what follows. */
static const struct {
    const char *type;
    uint32_t size;
} fixed_sizes[] = {{"box2f", 16},
                   {"box2i", 16},
                   {"chromaticities", 32},
                   {"compression", 1},
                   {"deepImageState", 1},
                   {"double", 8},
                   {"envmap", 1},
                   {"float", 4},
                   {"int", 4},
                   {"keycode", 28},
                   {"lineOrder", 1},
                   {"m33d", 72},
                   {"m33f", 36},
                   {"m44d", 128},
                   {"m44f", 64},
                   {"rational", 8},
                   {"tiledesc", 9},
                   {"timecode", 8},
                   {"v2d", 16},
                   {"v2f", 8},
                   {"v2i", 8},
                   {"v3d", 24},
                   {"v3f", 12},
                   {"v3i", 12}};

static ff_status wrong_attribute(const ff_bytes *b, const char *type, uint32_t size)
{
    char found[FF_QUOTE];
    return ff_error_set(b->err, FF_ERR_FORMAT, b->path, 0, b->offset,
                        "found an attribute of the type %s in %lu bytes that do not hold one, expected a sound header",
                        ff_quote(type, strlen(type), found), (unsigned long)size);
}

/* Channels: name, 16 bytes, up to an empty name, which is the last byte. */
static int is_channel_list(const unsigned char *v, size_t n)
{
    size_t at = 0;
    while (at < n && v[at] != 0) {
        const unsigned char *end = memchr(v + at, 0, n - at);
        if (!end || (size_t)(v + n - end) < 17 + 1) return 0;
        at = (size_t)(end - v) + 17;
    }
    return at + 1 == n;
}

/* i32 n, n bytes, and so on. */
static int is_string_vector(const unsigned char *v, size_t n)
{
    while (n >= 4 && ff_uint32_of(v) <= n - 4) {
        const size_t step = 4 + ff_uint32_of(v);
        v += step;
        n -= step;
    }
    return n == 0;
}

static int is_preview(const unsigned char *v, size_t n)
{
    return n >= 8 && ff_uint32_of(v) <= 65535 && ff_uint32_of(v + 4) <= 65535 &&
           n == 8 + 4 * (size_t)ff_uint32_of(v) * ff_uint32_of(v + 4);
}

/* Steps over the value of an attribute, which holds what its type says. */
static ff_status check_attribute(ff_bytes *b, const char *type, uint32_t size)
{
    for (size_t k = 0; k < sizeof fixed_sizes / sizeof fixed_sizes[0]; k++)
        if (strcmp(type, fixed_sizes[k].type) == 0)
            return size == fixed_sizes[k].size ? skip(b, size) : wrong_attribute(b, type, size);
    static const struct {
        const char *type;
        int (*is)(const unsigned char *, size_t);
    } lists[] = {{"chlist", is_channel_list}, {"stringvector", is_string_vector}, {"preview", is_preview}};
    for (size_t k = 0; k < sizeof lists / sizeof lists[0]; k++) {
        if (strcmp(type, lists[k].type) != 0) continue;
        unsigned char *value = malloc(size + 1);
        if (!value) return ff_error_set(b->err, FF_ERR_MEMORY, b->path, 0, b->offset, "no memory for an attribute");
        const ff_status status = ff_bytes_read(b, value, size, "the value of an attribute");
        const int sound = status == FF_OK && lists[k].is(value, size);
        free(value);
        return status != FF_OK ? status : sound ? FF_OK : wrong_attribute(b, type, size);
    }
    if (strcmp(type, "idmanifest") == 0) return wrong_attribute(b, type, size); /* packed: it unfolds to any size */
    if (strcmp(type, "floatvector") == 0 && size % 4 != 0) return wrong_attribute(b, type, size);
    return skip(b, size);
}

/* Attributes: name, type, i32 n, n bytes, up to an empty name; of several parts one list after the other, up to an empty one. */
static ff_status check_exr(ff_bytes *b)
{
    unsigned char version[8], size[4];
    char name[256], type[256];
    ff_status status = ff_bytes_read(b, version, sizeof version, "the header of an OpenEXR image");
    const int parts = (version[5] & 0x10) != 0;
    for (int in_part = 0; status == FF_OK;) {
        status = read_text(b, name);
        if (status == FF_OK && name[0] == '\0') {
            if (!parts || !in_part) return FF_OK;
            in_part = 0;
            continue;
        }
        in_part = 1;
        if (status == FF_OK) status = read_text(b, type);
        if (status == FF_OK) status = ff_bytes_read(b, size, sizeof size, "the size of an attribute");
        if (status != FF_OK) break;
        if (ff_uint32_of(size) > b->size - b->offset) return too_large(b, b->offset, "an attribute", ff_uint32_of(size));
        status = check_attribute(b, type, ff_uint32_of(size));
    }
    return status;
}

static ff_status check_open(ff_bytes *b, const char **kind)
{
    unsigned char head[HEAD] = {0};
    size_t n;
    ff_status status = ff_input_read(b->fd, b->path, 0, head, sizeof head, &n, b->err);
    if (status != FF_OK) return status;
    const char *k = kind_of(head, b->path);
    if (k && strcmp(k, "tiff") == 0 && is_raw(b->path))
        return ff_error_set(b->err, FF_ERR_UNSUPPORTED, b->path, 0, 0,
                            "found a raw file of a camera, expected an image: develop it to a linear TIFF or OpenEXR image");
    if (!k)
        return ff_error_set(
            b->err, FF_ERR_UNSUPPORTED, b->path, 0, 0,
            "found another kind of file, expected a PNG, JPEG, JPEG 2000, TIFF, OpenEXR, Radiance HDR, PNM, PFM, BMP, TGA or "
            "WebP image"); /* not what it holds: a list can name any file that the reader of the message may not see */
    if (b->size < 0) return ff_error_set(b->err, FF_ERR_UNSUPPORTED, b->path, 0, -1, "found a pipe or device, expected a file");
    status = skip(b, 0);
    if (status == FF_OK && strcmp(k, "png") == 0) status = check_png(b);
    if (status == FF_OK && strcmp(k, "openexr") == 0) status = check_exr(b);
    if (status == FF_OK) *kind = k;
    return status;
}

ff_status ff_image_check(const char *path, const char **kind, ff_error *err)
{
    ff_bytes b;
    ff_status status = ff_bytes_open(path, &b, err);
    if (status != FF_OK) return status;
    status = check_open(&b, kind);
    ff_bytes_close(&b);
    return status;
}
