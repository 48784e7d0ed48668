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
 *  Outputs that belong together are opened with one ff_outputs. Their commits make each of them whole under its temporary name, and
 *  ff_outputs_commit gives all their names at once: until it does, not one has changed. What cannot be taken back (standard output,
 *  pipes, devices) is flushed when everything else is on the disk, and before the first rename.
 *
 *      ff_outputs all = {0};
 *      ... ff_output_open_with(path, &all, &out, err), ff_output_commit(&out, err), for each
 *      return ff_outputs_commit(&all, err);         // or ff_outputs_abort(&all), also where one of them failed
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
/** Of one ff_outputs. */
enum { FF_OUTPUTS_MOST = 8 };

#ifdef __cplusplus
extern "C" {
#endif

typedef struct ff_outputs ff_outputs;

/** An output between open and commit or abort. Write to `file`; the rest but for is_unsynced is to be looked at only. */
typedef struct ff_output {
    FILE *file;       /**< buffered, binary; never closed by the caller                          */
    char *target;     /**< where the content will be, symbolic links followed; NULL for "-"      */
    char *temporary;  /**< name of the unfinished file; NULL for "-", devices and pipes          */
    mode_t mode;      /**< permissions that it has when it is finished                           */
    ff_outputs *with; /**< those that it belongs to; NULL: none                                  */
    int is_unsynced;  /**< 1, set by the caller: a power failure may take its bytes, of thousands of files that whoever wrote them
                         checks by their sums and syncs at once; a process that is killed takes none     */
} ff_output;

/** Outputs that appear together or not at all. Zeroed is empty; to be looked at only. */
struct ff_outputs {
    size_t n;
    ff_output of[FF_OUTPUTS_MOST]; /**< those that are finished: whole, or with nothing left but to be flushed */
};

/** The name that a file to be created as `path` has, links to nowhere followed. The caller frees it. NULL: errno says why. */
char *ff_output_name(const char *path);

/** Opens path for writing. *out is written only on FF_OK; then exactly one of commit and abort must follow. */
ff_status ff_output_open(const char *path, ff_output *out, ff_error *err);

/** The same, as one of `with`, which must outlive it; NULL: alone. */
ff_status ff_output_open_with(const char *path, ff_outputs *with, ff_output *out, ff_error *err);

/** Flushes, checks every earlier write, syncs, closes and gives the file its name. On failure nothing is left behind and an
 *  existing file is as it was (what went to stdout, a device or a pipe cannot be taken back). Releases *out in either case.
 *  One of several is handed over to them instead, closed and synced, or open where it cannot be taken back: it has no name yet.
 *  FF_ERR_INTERNAL for one more than FF_OUTPUTS_MOST. */
ff_status ff_output_commit(ff_output *out, ff_error *err);

/** Flushes what cannot be taken back, then gives all others their names, with signals held back meanwhile on this thread, and syncs
 *  their folders. What fails before the first name leaves every file as it was. A name that cannot be given after others were (its
 *  folder went away in between) does not undo them: err says which are in place. `all` is empty afterwards, whatever came of it. */
ff_status ff_outputs_commit(ff_outputs *all, ff_error *err);

/** Drops all that were handed over, and empties `all`. An empty one is legal. */
void ff_outputs_abort(ff_outputs *all);

/** Drops the output and removes the temporary file. Releases *out; a zeroed or released *out and NULL are legal. */
void ff_output_abort(ff_output *out);

/** Removes the temporary files of all outputs of this process that are open (of 64 at most), which then cannot be committed: for a
 *  handler that ends the program. Async-signal-safe. */
void ff_outputs_remove(void);

#ifdef __cplusplus
}
#endif
#endif
