/** @file internal_kept.h  A stream whose characters are kept in memory. */
#ifndef FF_INTERNAL_KEPT_H
#define FF_INTERNAL_KEPT_H
#include "ff_status.h"
#include <stdio.h>

/* Zero before it is opened. */
typedef struct ff_kept {
    char *text; /* [n] characters and a 0, those before the last fflush of the stream; after ff_kept_close all of them, the caller's
                 * to free; NULL where there was no memory */
    size_t n, room;
} ff_kept;

/* A stream to write to; NULL: no memory. Unlike one of open_memstream it fails where it cannot grow: glibc's leaves out what there
 * was no room for, by no error, and no text at all where that was the first of it. k must stay where it is until it is closed. */
FILE *ff_kept_open(ff_kept *k);
/* Closes what ff_kept_open returned, NULL too: FF_ERR_MEMORY where anything of it is missing, and then there is no text. */
ff_status ff_kept_close(ff_kept *k, FILE *stream);

#endif
