/** @file internal_tensor_file.h  The container of Mitsuba and of the RGL material database: named arrays of numbers in one file.
 *
 *      char[12]   "tensor_file\0"
 *      uint8 x 2  version 1, 0
 *      uint32     number of fields; then for each
 *          uint16 length of the name, the name
 *          uint16 number of dimensions
 *          uint8  type
 *          uint64 offset of the data from the start of the file
 *          uint64 size of each dimension, the last one contiguous
 *
 *  All little-endian. The data follow, each field at a multiple of 8. */
#ifndef FF_INTERNAL_TENSOR_FILE_H
#define FF_INTERNAL_TENSOR_FILE_H
#include "base/internal_bytes.h"
#include <stdio.h>

enum { FF_TENSOR_MAGIC = 12, FF_TENSOR_HEADER = 18 };
extern const char ff_tensor_magic[FF_TENSOR_MAGIC];

/** Numbers of the types in the file. */
enum {
    FF_TENSOR_UINT8 = 1,
    FF_TENSOR_INT8,
    FF_TENSOR_UINT16,
    FF_TENSOR_INT16,
    FF_TENSOR_UINT32,
    FF_TENSOR_INT32,
    FF_TENSOR_UINT64,
    FF_TENSOR_INT64,
    FF_TENSOR_FLOAT16,
    FF_TENSOR_FLOAT32,
    FF_TENSOR_FLOAT64
};
const char *ff_tensor_type_name(unsigned type); /**< "float32"; NULL for a number that is none */
size_t ff_tensor_type_bytes(unsigned type);     /**< of one element; 0 for a number that is none */

/** One array of the file. */
typedef struct ff_tensor {
    char *name;      /**< '\0'-terminated copy; may hold any other byte                    */
    unsigned type;   /**< FF_TENSOR_...                                                    */
    size_t n_dims;   /**< 0: one element                                                   */
    uint64_t *shape; /**< [n_dims]                                                         */
    size_t count;    /**< elements, the product of the shape                               */
    size_t offset;   /**< of the data in the file                                          */
    size_t header;   /**< where its description stands in the file, for messages           */
} ff_tensor;

/** A whole file in memory. */
typedef struct ff_tensor_file {
    unsigned char *bytes; /**< [n_bytes], as in the file */
    size_t n_bytes;
    ff_tensor *field; /**< [n_fields] */
    size_t n_fields;
} ff_tensor_file;

/** Limits beyond any file of the kind. */
enum { FF_TENSOR_FIELDS = 256, FF_TENSOR_DIMS = 16 };

/** Reads path. Every field lies inside the file, after the descriptions, and apart from the others; names differ; nothing but up to
 * 7 bytes of padding stands between the fields or after the last. *out is written only on FF_OK; then ff_tensor_file_free must
 * follow. FF_ERR_READ where the file ends early, FF_ERR_FORMAT, FF_ERR_MEMORY, FF_ERR_OPEN. */
ff_status ff_tensor_file_read(const char *path, ff_tensor_file *out, ff_error *err);

/** A file in memory with these fields (name, type, n_dims, shape are read), their data zero; laid out as the database does. */
ff_status ff_tensor_file_make(const ff_tensor *fields, size_t n_fields, ff_tensor_file *out, ff_error *err);

ff_status ff_tensor_file_copy(const ff_tensor_file *from, ff_tensor_file *out, ff_error *err);
void ff_tensor_file_free(ff_tensor_file *f);

/** The field of that name, NULL when there is none. */
const ff_tensor *ff_tensor_find(const ff_tensor_file *f, const char *name);

/** Its data in the file's bytes. */
static inline unsigned char *ff_tensor_data(const ff_tensor_file *f, const ff_tensor *t)
{
    return f->bytes + t->offset;
}

/** "float32 [1, 8, 3, 32, 32]" for messages. Returns out. */
enum { FF_TENSOR_TEXT = 160 };
const char *ff_tensor_describe(const ff_tensor *t, char out[FF_TENSOR_TEXT]);

/** n float32 as they lie in the file into numbers of this machine; in and out may be anywhere. */
void ff_floats_from_file(const unsigned char *in, size_t n, float *out);
#endif
