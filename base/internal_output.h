/** @file internal_output.h  An output file that appears whole or not at all.
 *
 *  The content goes to a temporary name in the same directory ("PATH.part-PID-N") and takes its name only when every byte has
 *  reached the disk. "-" is standard output; devices and pipes (/dev/null) are written directly, since a rename would replace them.
 *  An existing file keeps its permissions, a symbolic link stays one, and a file that may not be written is not replaced.
 *
 *      ff_output out;
 *      if ((s = ff_output_open(path, &out, err)) != FF_OK) return s;
 *      fprintf(out.file, ...);                      // no need to check each call: commit knows of any that failed
 *      return ff_output_commit(&out, err);          // or ff_output_abort(&out)
 *
 *  Signals  a program that catches SIGINT calls ff_output_abort on its way out, outside the handler. One that wants to leave
 *           from the handler itself may unlink(out.temporary) there: that string does not change between open and
 *           commit or abort, and is NULL where no temporary file exists.
 *  Errors   FF_ERR_WRITE with path and the system's reason (no space left, permission denied); FF_ERR_MEMORY.
 *  Threads  an ff_output belongs to one thread at a time; any number may be open, also on the same path (the last commit wins). */
#ifndef FF_INTERNAL_OUTPUT_H
#define FF_INTERNAL_OUTPUT_H
#include "ff_status.h"
#include <stdio.h>
#ifdef __cplusplus
extern "C" {
#endif

/** An output between open and commit or abort. Write to `file`; the rest is to be looked at only. */
typedef struct ff_output {
    FILE *file;      /**< buffered, binary; never closed by the caller                          */
    char *target;    /**< where the content will be, symbolic links followed; NULL for "-"      */
    char *temporary; /**< name of the unfinished file; NULL for "-", devices and pipes          */
} ff_output;

/** Opens path for writing. *out is written only on FF_OK; then exactly one of commit and abort must follow. */
ff_status ff_output_open(const char *path, ff_output *out, ff_error *err);

/** Flushes, checks every earlier write, syncs, closes and gives the file its name. On failure nothing is left behind and an
 *  existing file is as it was (what went to stdout, a device or a pipe cannot be taken back). Releases *out in either case. */
ff_status ff_output_commit(ff_output *out, ff_error *err);

/** Drops the output and removes the temporary file. Releases *out; a zeroed or released *out and NULL are legal. */
void ff_output_abort(ff_output *out);

#ifdef __cplusplus
}
#endif
#endif
