/** @file internal_output.h  An output file that appears whole or not at all.
 *
 *  The content goes to a temporary name in the same directory ("PATH.part-PID-N", ".part-PID-N" where that is too long) and takes
 *  its name only when every byte has reached the disk; the name itself has when commit returns. "-" is standard output; devices and
 *  pipes (/dev/null) are written directly, since a rename would replace them. A symbolic link stays one, also one that leads
 *  nowhere yet, and a file that may not be written is not replaced.
 *  Until then only its owner may read it. A new file has the permissions that the umask leaves; one that replaces another has the
 *  other's, its owner and group where the system lets them be given (else no more for our group than for everyone), and never the
 *  setuid, setgid or sticky bit.
 *
 *      ff_output out;
 *      if ((s = ff_output_open(path, &out, err)) != FF_OK) return s;
 *      fprintf(out.file, ...);                      // no need to check each call: commit knows of any that failed
 *      return ff_output_commit(&out, err);          // or ff_output_abort(&out)
 *
 *  Signals  a program that catches SIGINT calls ff_output_abort on its way out, outside the handler. One that leaves from the
 *           handler itself calls ff_outputs_remove there, on the thread that opened the outputs.
 *  Errors   FF_ERR_WRITE with path and the system's reason (no space left, permission denied); FF_ERR_MEMORY.
 *  Threads  an ff_output belongs to one thread at a time; any number may be open, also on the same path (the last commit wins). */
#ifndef FF_INTERNAL_OUTPUT_H
#define FF_INTERNAL_OUTPUT_H
#include "ff_status.h"
#include <stdio.h>
#include <sys/types.h>
#ifdef __cplusplus
extern "C" {
#endif

/** An output between open and commit or abort. Write to `file`; the rest is to be looked at only. */
typedef struct ff_output {
    FILE *file;      /**< buffered, binary; never closed by the caller                          */
    char *target;    /**< where the content will be, symbolic links followed; NULL for "-"      */
    char *temporary; /**< name of the unfinished file; NULL for "-", devices and pipes          */
    mode_t mode;     /**< permissions that it has when it is finished                           */
} ff_output;

/** The name that a file to be created as `path` has, links to nowhere followed. The caller frees it. NULL: errno says why. */
char *ff_output_name(const char *path);

/** Opens path for writing. *out is written only on FF_OK; then exactly one of commit and abort must follow. */
ff_status ff_output_open(const char *path, ff_output *out, ff_error *err);

/** Flushes, checks every earlier write, syncs, closes and gives the file its name. On failure nothing is left behind and an
 *  existing file is as it was (what went to stdout, a device or a pipe cannot be taken back). Releases *out in either case. */
ff_status ff_output_commit(ff_output *out, ff_error *err);

/** Drops the output and removes the temporary file. Releases *out; a zeroed or released *out and NULL are legal. */
void ff_output_abort(ff_output *out);

/** Removes the temporary files of all outputs of this process that are open (of 64 at most), which then cannot be committed: for a
 *  handler that ends the program. Async-signal-safe. */
void ff_outputs_remove(void);

#ifdef __cplusplus
}
#endif
#endif
