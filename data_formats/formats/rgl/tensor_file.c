/* The tensor container: internal_tensor_file.h has its layout. */
#include "internal_tensor_file.h"
#include "base/internal_input.h"
#include <stdlib.h>

const char ff_tensor_magic[FF_TENSOR_MAGIC] = "tensor_file";

enum { ALIGNMENT = 8, FIXED = 2 + 2 + 1 + 8 };
static const size_t largest_file = (size_t)1 << 33;
/* No descriptions are longer: 256 times a name of 65535 bytes and 16 dimensions. */
enum { MOST_DESCRIPTIONS = FF_TENSOR_HEADER + FF_TENSOR_FIELDS * (FIXED + 65535 + 8 * FF_TENSOR_DIMS) };

static const struct {
    const char *name;
    size_t bytes;
} types[] = {{NULL, 0},    {"uint8", 1},  {"int8", 1},  {"uint16", 2},  {"int16", 2},   {"uint32", 4},
             {"int32", 4}, {"uint64", 8}, {"int64", 8}, {"float16", 2}, {"float32", 4}, {"float64", 8}};

const char *ff_tensor_type_name(unsigned type)
{
    return type < sizeof types / sizeof types[0] ? types[type].name : NULL;
}

size_t ff_tensor_type_bytes(unsigned type)
{
    return type < sizeof types / sizeof types[0] ? types[type].bytes : 0;
}

void ff_floats_from_file(const unsigned char *in, size_t n, float *out)
{
#if !defined(__BYTE_ORDER__) || __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
    for (size_t i = 0; i < n; i++) out[i] = ff_float_of(in + 4 * i);
#else
    memcpy(out, in, n * sizeof *out);
#endif
}

const char *ff_tensor_describe(const ff_tensor *t, char out[FF_TENSOR_TEXT])
{
    size_t used = (size_t)snprintf(out, FF_TENSOR_TEXT, "%s [", ff_tensor_type_name(t->type));
    for (size_t k = 0; k < t->n_dims && used < FF_TENSOR_TEXT; k++)
        used += (size_t)snprintf(out + used, FF_TENSOR_TEXT - used, "%s%llu", k ? ", " : "", (unsigned long long)t->shape[k]);
    if (used < FF_TENSOR_TEXT) snprintf(out + used, FF_TENSOR_TEXT - used, "]");
    return out;
}

const ff_tensor *ff_tensor_find(const ff_tensor_file *f, const char *name)
{
    for (size_t k = 0; k < f->n_fields; k++)
        if (strcmp(f->field[k].name, name) == 0) return &f->field[k];
    return NULL;
}

void ff_tensor_file_free(ff_tensor_file *f)
{
    for (size_t k = 0; k < f->n_fields && f->field; k++) {
        free(f->field[k].name);
        free(f->field[k].shape);
    }
    free(f->field);
    free(f->bytes);
    *f = (ff_tensor_file){0};
}

static ff_status no_memory(const char *path, ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, path, 0, -1, "no memory for a tensor file");
}

/* ---- reading --------------------------------------------------------------------------------- */

/* The descriptions on their way through memory. */
typedef struct reader {
    const char *path;
    ff_error *err;
    const unsigned char *bytes;
    size_t n, at;
    int no_size; /* 1: n is only what a file may have */
} reader;

static ff_status need(const reader *r, size_t bytes, const char *what)
{
    if (bytes <= r->n - r->at) return FF_OK;
    return ff_error_set(r->err, FF_ERR_READ, r->path, 0, (int64_t)r->n, "found the end of the file after %zu bytes, expected %s",
                        r->n, what);
}

static ff_status wrong(const reader *r, size_t at, const char *found, const char *expected)
{
    return ff_error_set(r->err, FF_ERR_FORMAT, r->path, 0, (int64_t)at, "found %s, expected %s", found, expected);
}

static ff_status read_name(reader *r, ff_tensor *t)
{
    ff_status status = need(r, FIXED, "the description of a field");
    if (status != FF_OK) return status;
    const size_t length = ff_uint16_of(r->bytes + r->at);
    if ((status = need(r, FIXED + length, "the description of a field")) != FF_OK) return status;
    const unsigned char *text = r->bytes + r->at + 2;
    if (length == 0 || memchr(text, '\0', length))
        return wrong(r, r->at, length ? "a zero byte in the name of a field" : "a field without a name", "a name");
    if (!(t->name = calloc(length + 1, 1))) return no_memory(r->path, r->err);
    memcpy(t->name, text, length);
    r->at += 2 + length;
    return FF_OK;
}

/* The number of elements, of which there can be no more than bytes in the file. */
static ff_status read_shape(reader *r, ff_tensor *t)
{
    char found[64];
    t->count = 1;
    for (size_t k = 0; k < t->n_dims; k++, r->at += 8) {
        t->shape[k] = ff_uint64_of(r->bytes + r->at);
        if (t->shape[k] > r->n / (t->count ? t->count : 1)) {
            snprintf(found, sizeof found, "a dimension of %llu", (unsigned long long)t->shape[k]);
            return wrong(r, r->at, found, "no more elements than the file has bytes");
        }
        t->count *= (size_t)t->shape[k];
    }
    return FF_OK;
}

static ff_status read_description(reader *r, ff_tensor *t)
{
    char found[96], quoted[FF_QUOTE];
    t->header = r->at;
    ff_status status = read_name(r, t);
    if (status != FF_OK) return status;
    t->n_dims = ff_uint16_of(r->bytes + r->at);
    t->type = r->bytes[r->at + 2];
    const uint64_t offset = ff_uint64_of(r->bytes + r->at + 3);
    if (t->n_dims > FF_TENSOR_DIMS) {
        snprintf(found, sizeof found, "%zu dimensions", t->n_dims);
        return wrong(r, r->at, found, "at most 16");
    }
    if (!ff_tensor_type_name(t->type)) {
        snprintf(found, sizeof found, "the type %u", t->type);
        return wrong(r, r->at + 2, found, "a number from 1 (uint8) to 11 (float64)");
    }
    const size_t offset_at = r->at + 3;
    r->at += FIXED - 2;
    if ((status = need(r, 8 * t->n_dims, "the dimensions of a field")) != FF_OK) return status;
    if (!(t->shape = calloc(t->n_dims + 1, sizeof *t->shape))) return no_memory(r->path, r->err);
    if ((status = read_shape(r, t)) != FF_OK) return status;
    const size_t size = t->count * ff_tensor_type_bytes(t->type);
    if (offset > r->n || size > r->n - (size_t)offset)
        return ff_error_set(r->err, FF_ERR_READ, r->path, 0, (int64_t)offset_at,
                            "found the field %s of %zu bytes at offset %llu, expected it inside the file of %zu bytes",
                            ff_quote(t->name, strlen(t->name), quoted), size, (unsigned long long)offset, r->n);
    t->offset = (size_t)offset;
    return FF_OK;
}

static int by_offset(const void *a, const void *b)
{
    const ff_tensor *const *x = a, *const *y = b;
    return ((*x)->offset > (*y)->offset) - ((*x)->offset < (*y)->offset);
}

/* The data follow one another from `begin`, a few bytes of padding apart, up to the end of the file. */
static ff_status check_places(const reader *r, const ff_tensor_file *f, size_t begin)
{
    const ff_tensor *order[FF_TENSOR_FIELDS];
    char quoted[FF_QUOTE];
    size_t end = begin;
    for (size_t k = 0; k < f->n_fields; k++) order[k] = &f->field[k];
    qsort(order, f->n_fields, sizeof order[0], by_offset);
    for (size_t k = 0; k < f->n_fields; k++) {
        const ff_tensor *t = order[k];
        if (t->offset < end || t->offset - end >= ALIGNMENT)
            return ff_error_set(
                r->err, FF_ERR_FORMAT, r->path, 0, (int64_t)t->header,
                "found the data of the field %s at byte %zu, expected them at %zu, where %s, or up to 7 bytes later",
                ff_quote(t->name, strlen(t->name), quoted), t->offset, end,
                k ? "those of the one before end" : "the descriptions end");
        end = t->offset + t->count * ff_tensor_type_bytes(t->type);
    }
    if (r->n - end < ALIGNMENT || r->no_size) return FF_OK;
    return ff_error_set(r->err, FF_ERR_FORMAT, r->path, 0, (int64_t)end,
                        "found %zu bytes after the last field, expected the end of the file", r->n - end);
}

static ff_status read_fields(reader *r, ff_tensor_file *f)
{
    char found[64], quoted[FF_QUOTE];
    ff_status status = need(r, FF_TENSOR_HEADER, "a header of 18 bytes");
    if (status != FF_OK) return status;
    if (memcmp(r->bytes, ff_tensor_magic, FF_TENSOR_MAGIC) != 0)
        return wrong(r, 0, ff_quote((const char *)r->bytes, FF_TENSOR_MAGIC, quoted), "'tensor_file' and a zero byte");
    if (r->bytes[12] != 1 || r->bytes[13] != 0) {
        snprintf(found, sizeof found, "version %d.%d", r->bytes[12], r->bytes[13]);
        return wrong(r, 12, found, "1.0");
    }
    const uint32_t n = ff_uint32_of(r->bytes + 14);
    if (n == 0 || n > FF_TENSOR_FIELDS) {
        snprintf(found, sizeof found, "%lu fields", (unsigned long)n);
        return wrong(r, 14, found, "1 to 256");
    }
    if (!(f->field = calloc(n, sizeof *f->field))) return no_memory(r->path, r->err);
    r->at = FF_TENSOR_HEADER;
    for (uint32_t k = 0; k < n; k++) {
        f->n_fields = k + 1;
        if ((status = read_description(r, &f->field[k])) != FF_OK) return status;
        if (ff_tensor_find(f, f->field[k].name) != &f->field[k])
            return wrong(r, f->field[k].header, ff_quote(f->field[k].name, strlen(f->field[k].name), quoted),
                         "a name that no field before has");
    }
    return check_places(r, f, r->at);
}

/* Are the descriptions those of a tensor file of this size? Then it is worth its memory. */
static ff_status check_head(const ff_bytes *b, const unsigned char *head, size_t n)
{
    const int is_whole = n < MOST_DESCRIPTIONS, no_size = !is_whole && b->size < 0;
    ff_tensor_file f = {0};
    reader r = {.path = b->path, .err = b->err, .bytes = head, .n = n, .no_size = no_size};
    if (!is_whole) r.n = no_size ? largest_file : (size_t)b->size;
    const ff_status status = read_fields(&r, &f);
    ff_tensor_file_free(&f);
    return status;
}

ff_status ff_tensor_file_read(const char *path, ff_tensor_file *out, ff_error *err)
{
    ff_bytes b;
    ff_tensor_file f = {0};
    ff_status status = ff_bytes_open(path, &b, err);
    if (status != FF_OK) return status;
    status = ff_bytes_head(&b, MOST_DESCRIPTIONS, &f.bytes, &f.n_bytes);
    if (status == FF_OK) status = check_head(&b, f.bytes, f.n_bytes);
    if (status == FF_OK) status = ff_bytes_rest(&b, largest_file, &f.bytes, &f.n_bytes);
    ff_bytes_close(&b);
    if (status == FF_OK) {
        reader r = {.path = path, .err = err, .bytes = f.bytes, .n = f.n_bytes};
        status = read_fields(&r, &f);
    }
    if (status != FF_OK)
        ff_tensor_file_free(&f);
    else
        *out = f;
    return status;
}

/* ---- making ---------------------------------------------------------------------------------- */

static int copy_field(const ff_tensor *from, ff_tensor *to)
{
    *to = *from;
    const size_t name = strlen(from->name) + 1;
    to->name = malloc(name);
    to->shape = calloc(from->n_dims + 1, sizeof *to->shape);
    if (!to->name || !to->shape) return 0;
    memcpy(to->name, from->name, name);
    memcpy(to->shape, from->shape, from->n_dims * sizeof *to->shape);
    return 1;
}

static ff_status copy_fields(const ff_tensor *from, size_t n, ff_tensor_file *f, ff_error *err)
{
    if (!(f->field = calloc(n, sizeof *f->field))) return no_memory(NULL, err);
    f->n_fields = n;
    for (size_t k = 0; k < n; k++)
        if (!copy_field(&from[k], &f->field[k])) return no_memory(NULL, err);
    return FF_OK;
}

ff_status ff_tensor_file_copy(const ff_tensor_file *from, ff_tensor_file *out, ff_error *err)
{
    ff_tensor_file f = {.n_bytes = from->n_bytes, .bytes = malloc(from->n_bytes)};
    ff_status status = f.bytes ? copy_fields(from->field, from->n_fields, &f, err) : no_memory(NULL, err);
    if (status != FF_OK) {
        ff_tensor_file_free(&f);
        return status;
    }
    memcpy(f.bytes, from->bytes, from->n_bytes);
    *out = f;
    return FF_OK;
}

static size_t aligned(size_t at)
{
    return (at + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
}

/* Where everything goes; 0 when a size overflows. */
static int place_fields(ff_tensor_file *f)
{
    size_t at = FF_TENSOR_HEADER;
    for (size_t k = 0; k < f->n_fields; k++) {
        f->field[k].header = at;
        at += FIXED + strlen(f->field[k].name) + 8 * f->field[k].n_dims;
    }
    for (size_t k = 0; k < f->n_fields; k++) {
        ff_tensor *t = &f->field[k];
        t->offset = at = aligned(at);
        t->count = 1;
        for (size_t d = 0; d < t->n_dims; d++) {
            if (t->shape[d] == 0 || t->shape[d] > largest_file / t->count) return 0;
            t->count *= (size_t)t->shape[d];
        }
        at += t->count * ff_tensor_type_bytes(t->type);
        if (at > largest_file) return 0;
    }
    f->n_bytes = at;
    return 1;
}

static void write_description(const ff_tensor *t, unsigned char *b)
{
    const size_t length = strlen(t->name);
    ff_bytes_of_uint(length, 2, b);
    memcpy(b + 2, t->name, length);
    b += 2 + length;
    ff_bytes_of_uint(t->n_dims, 2, b);
    b[2] = (unsigned char)t->type;
    ff_bytes_of_uint(t->offset, 8, b + 3);
    for (size_t d = 0; d < t->n_dims; d++) ff_bytes_of_uint(t->shape[d], 8, b + 11 + 8 * d);
}

ff_status ff_tensor_file_make(const ff_tensor *fields, size_t n_fields, ff_tensor_file *out, ff_error *err)
{
    ff_tensor_file f = {0};
    ff_status status = copy_fields(fields, n_fields, &f, err);
    if (status == FF_OK && (!place_fields(&f) || !(f.bytes = calloc(f.n_bytes, 1)))) status = no_memory(NULL, err);
    if (status != FF_OK) {
        ff_tensor_file_free(&f);
        return status;
    }
    memcpy(f.bytes, ff_tensor_magic, FF_TENSOR_MAGIC);
    f.bytes[12] = 1;
    ff_bytes_of_uint(n_fields, 4, f.bytes + 14);
    for (size_t k = 0; k < n_fields; k++) write_description(&f.field[k], f.bytes + f.field[k].header);
    *out = f;
    return FF_OK;
}
