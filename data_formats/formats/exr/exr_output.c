/* An OpenEXR image on its way into a file that appears whole or not at all. */
#define _GNU_SOURCE
#include "internal_exr.h"
#include "base/internal_errno.h"
#include <errno.h>
#include <stdlib.h>

static int64_t write_at(exr_const_context_t context, void *user, const void *bytes, uint64_t n, uint64_t offset,
                        exr_stream_error_func_ptr_t report)
{
    ff_exr_output *o = ((ff_exr_io *)user)->out;
    if (!o->broken && offset != o->position) o->broken = fseeko(o->file, (off_t)offset, SEEK_SET) != 0;
    if (!o->broken) o->broken = fwrite(bytes, 1, n, o->file) != n;
    o->position = offset + n;
    if (!o->broken) return (int64_t)n;
    report(context, EXR_ERR_WRITE_IO, "cannot be written");
    return -1;
}

/* A pipe gets the file when it is finished: the list of chunks stands before them and is written last. */
static ff_status copy_scratch(ff_exr_output *o)
{
    unsigned char block[1 << 14];
    size_t n;
    int failed = fflush(o->file) != 0 || fseeko(o->file, 0, SEEK_SET) != 0;
    while (!failed && (n = fread(block, 1, sizeof block, o->file)) > 0) fwrite(block, 1, n, o->out.file);
    failed |= ferror(o->file) != 0;
    if (!failed) return FF_OK;
    return ff_error_set(o->err, FF_ERR_WRITE, o->path, 0, -1, "the scratch file cannot be used: %s",
                        ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
}

ff_status ff_exr_output_result(const ff_exr_output *o, exr_result_t result, const char *expected)
{
    if (o->broken) return FF_OK; /* ff_output_commit says why */
    return result == EXR_ERR_SUCCESS ? FF_OK : ff_exr_failed(&o->io, result, o->path, expected, o->err);
}

static ff_status write_context(ff_exr_output *o, ff_exr_body *body, void *context)
{
    exr_context_initializer_t init = ff_exr_initializer(&o->io);
    init.write_fn = write_at;
    exr_result_t r = exr_start_write(&o->context, o->path, EXR_WRITE_FILE_DIRECTLY, &init);
    if (r != EXR_ERR_SUCCESS) {
        ff_exr_finish(&o->context);
        return ff_exr_failed(&o->io, r, o->path, "to start an image", o->err);
    }
    const ff_status status = body(o, context);
    r = ff_exr_finish(&o->context);
    return status == FF_OK ? ff_exr_output_result(o, r, "to finish the image") : status;
}

ff_status ff_exr_output_write(const char *path, ff_exr_body *body, void *context, ff_error *err)
{
    ff_exr_output o = {.path = path, .err = err};
    ff_status status = ff_output_open(path, &o.out, err);
    if (status != FF_OK) return status;
    const int scratch = !o.out.temporary;
    o.io.out = &o;
    o.file = scratch ? tmpfile() : o.out.file;
    if (!o.file)
        status = ff_error_set(err, FF_ERR_WRITE, path, 0, -1, "no scratch file can be made: %s",
                              ff_errno_text(errno, (char[FF_ERRNO_TEXT]){""}));
    if (status == FF_OK) status = write_context(&o, body, context);
    if (status == FF_OK && scratch) status = copy_scratch(&o);
    if (scratch && o.file) fclose(o.file);
    if (status == FF_OK) return ff_output_commit(&o.out, err);
    ff_output_abort(&o.out);
    return status;
}
