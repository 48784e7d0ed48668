/** @file internal_exr.h  Tables in OpenEXR images: what the files of this format share. The layout is in docs/exr.md. */
#ifndef FF_INTERNAL_EXR_H
#define FF_INTERNAL_EXR_H
#include "base/internal_output.h"
#include "data_formats/table/table_struct.h"
#include <openexr.h>

/* ---- exr_kept.c: names of the layout, and what a table keeps of it ---------------------------- */

enum { FF_EXR_VERSION = 1, FF_EXR_SOURCE = 32 };
#define FF_EXR_A(name) "facetfit." name /**< an attribute of the table                                     */
#define FF_EXR_HIGH    ".high"          /**< appended to the name of a plane of doubles: its upper 32 bits */
#define FF_EXR_LOW     ".low"
extern const char *const ff_exr_direction[4];       /**< planes of angles: "direction.theta_i", ...                */
extern const char *const ff_exr_parametrisation[4]; /**< by ff_axes_kind: "list", "half-difference", ...           */
extern const char *const ff_exr_axis_name[4][4];    /**< [ff_axes_kind][k], the attribute that holds an axis       */

/** ff_table.kept of a table that was read or laid out here; kept_free is ff_exr_kept_free. */
typedef struct ff_exr_kept {
    int doubles;                /**< values, sigmas and weights are written as doubles */
    char source[FF_EXR_SOURCE]; /**< format that the table came from                    */
} ff_exr_kept;
void ff_exr_kept_free(void *kept);
/** Gives t a kept; FF_ERR_MEMORY. */
ff_status ff_exr_keep(ff_table *t, int doubles, const char *source, ff_error *err);
/** The kept of t, NULL when it is of another format or none. */
const ff_exr_kept *ff_exr_kept_of(const ff_table *t);

/* ---- exr_file.c: the bytes of an input, and its header --------------------------------------- */

typedef struct ff_exr_attribute {
    const char *name, *type;
    const unsigned char *data;
    size_t n;
    int64_t offset; /**< of data in the file */
} ff_exr_attribute;

typedef struct ff_exr_channel {
    const char *name;
    int type; /**< exr_pixel_type_t */
} ff_exr_channel;

/** An opened file whose header and list of chunks are as they should be: what OpenEXRCore is given to read. */
typedef struct ff_exr_file {
    const char *path; /**< the caller's */
    ff_error *err;    /**< the caller's */
    int fd;
    int64_t size;
    unsigned char *bytes; /**< the first n_bytes of the file; all of it where fd has no positions (pipes) */
    size_t n_bytes;
    int whole; /**< bytes is all of it */
    ff_exr_attribute *attribute;
    size_t n_attributes;
    ff_exr_channel *channel; /**< in the file's order */
    size_t n_channels;
    int64_t width, height, first_x, first_y;
    int compression;
} ff_exr_file;

/** *f is written only on FF_OK; then ff_exr_close must follow. FF_ERR_OPEN, FF_ERR_READ, FF_ERR_FORMAT, FF_ERR_UNSUPPORTED (images
 *  that are not scan lines of one part), FF_ERR_MEMORY. */
ff_status ff_exr_open(const char *path, ff_exr_file *f, ff_error *err);
void ff_exr_close(ff_exr_file *f);

/** Reads n bytes at an offset; FF_ERR_READ when they are not there. */
ff_status ff_exr_bytes_at(ff_exr_file *f, int64_t offset, void *out, size_t n);

const ff_exr_attribute *ff_exr_attribute_find(const ff_exr_file *f, const char *name);
/** Index of a channel, -1 = none. */
long ff_exr_channel_find(const ff_exr_file *f, const char *name);
/** Lines of one chunk under a compression. */
int ff_exr_chunk_lines(int compression);

/* ---- exr_pixels.c: planes of numbers --------------------------------------------------------- */

typedef enum ff_exr_role { FF_EXR_VALUE, FF_EXR_SIGMA, FF_EXR_WEIGHT, FF_EXR_ANGLE } ff_exr_role;

/** A plane of the table and the channels it comes from. */
typedef struct ff_exr_plane {
    const char *name; /**< in the file, without ".high" */
    ff_exr_role role;
    double *to;   /**< [n]                                           */
    long channel; /**< index of the numbers, or of their upper bits  */
    long low;     /**< index of the lower bits, -1 = 32-bit numbers  */
} ff_exr_plane;

/** Sets plane->channel and low. FF_ERR_FORMAT when the file has no such plane. */
ff_status ff_exr_plane_find(const ff_exr_file *f, ff_exr_plane *plane);

/** Fills n samples of the planes and t->valid. FF_ERR_READ, FF_ERR_FORMAT, FF_ERR_DATA, FF_ERR_MEMORY. */
ff_status ff_exr_pixels_read(ff_exr_file *f, const ff_exr_plane *planes, size_t n_planes, ff_table *t);

/* ---- the rest -------------------------------------------------------------------------------- */

/** See ff_format.layout; exr_layout.c. */
ff_status ff_exr_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err);
/** See ff_format.write; exr_write.c. */
ff_status ff_exr_write(const char *path, const ff_table *t, ff_error *err);

/** What OpenEXRCore said last, and where it is to read and write: the user data of a context. */
typedef struct ff_exr_io {
    ff_exr_file *in;
    void *out;
    exr_result_t code;
    int no_memory; /**< 1: an allocation of the library has failed; what it says then may be anything */
    char message[256];
} ff_exr_io;
/** A context initializer whose errors go to io, which print nothing. From here to ff_exr_finish one context at a time is this
 *  thread's. */
exr_context_initializer_t ff_exr_initializer(ff_exr_io *io);
/** exr_finish; a context that is NULL is legal. */
exr_result_t ff_exr_finish(exr_context_t *context);
/** The status of an OpenEXRCore result that is not EXR_ERR_SUCCESS, with its message. */
ff_status ff_exr_failed(const ff_exr_io *io, exr_result_t result, const char *path, const char *expected, ff_error *err);
/* ---- exr_output.c: an image on its way into a file ------------------------------------------- */

/** What is between the opening of an output and its end. */
typedef struct ff_exr_output {
    const char *path; /**< the caller's */
    ff_error *err;    /**< the caller's */
    ff_output out;
    FILE *file; /**< out.file, or a scratch file where that has no positions */
    uint64_t position;
    int broken; /**< a write has failed: nothing more is to be written */
    ff_exr_io io;
    exr_context_t context;
} ff_exr_output;

/** Writes header and pixels into out->context. */
typedef ff_status ff_exr_body(ff_exr_output *out, void *context);
/** Opens path, has the body write, commits; nothing is left behind when anything fails. FF_ERR_WRITE, or what the body says. */
ff_status ff_exr_output_write(const char *path, ff_exr_body *body, void *context, ff_error *err);
/** What a body returns: FF_OK also for an output that is broken, which the commit reports. */
ff_status ff_exr_output_result(const ff_exr_output *out, exr_result_t result, const char *expected);

/* ---- exr_picture.c --------------------------------------------------------------------------- */

/** A channel of a picture: pixel (x, y) is at[(y width + x) stride]. */
typedef struct ff_exr_samples {
    const char *name; /**< each once, at most 255 bytes */
    const float *at;
    size_t stride;
} ff_exr_samples;

typedef struct ff_exr_picture {
    size_t width, height, n;
    const ff_exr_samples *samples; /**< [n] */
} ff_exr_picture;

/** FF_ERR_WRITE, FF_ERR_MEMORY. */
ff_status ff_exr_picture_write(const char *path, const ff_exr_picture *p, ff_error *err);
#endif
