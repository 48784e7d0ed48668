/** @file internal_scatter_grid.h  Text files of the family "ScatterAzimuth n, ScatterRadial n, DataBegin": lists of angles and
 *  blocks of values, and the cells that the nodes of a product grid stand for. */
#ifndef FF_INTERNAL_SCATTER_GRID_H
#define FF_INTERNAL_SCATTER_GRID_H
#include "base/internal_tokens.h"
#include "internal_table.h"

/** Numbers that grow as the file gives them, so that a count in a header never asks for memory by itself. Zero-initialise; release
 *  with free(value). */
typedef struct ff_values {
    double *value;
    size_t n, capacity;
} ff_values;

/** Appends the next `count` numbers of the file; `what` is for the message. Errors as ff_tokens_numbers, FF_ERR_MEMORY. */
ff_status ff_values_read(ff_tokens *t, size_t count, const char *what, ff_values *v);

/** What follows a keyword: a count n >= 1 and n angles in degrees, strictly ascending, in [least, most]. out must be empty:
 *  FF_ERR_FORMAT when the keyword comes twice or the count is none, FF_ERR_DATA for the angles, FF_ERR_READ, FF_ERR_MEMORY. */
ff_status ff_angles_read(ff_tokens *t, const char *keyword, double least, double most, ff_values *out);

/** The word after a keyword as its index in a NULL-terminated list, whatever the case of its letters. *index must be -1 before:
 *  FF_ERR_FORMAT when the keyword comes twice or the word is not in the list, FF_ERR_READ. */
ff_status ff_choice_read(ff_tokens *t, const char *keyword, const char *const *choices, int *index);

/** Bit k is set when a line of the first n bytes starts with keywords[k] (NULL-terminated list, at most 32), in any case. 0 for
 *  what is not text. */
unsigned ff_keywords_in(const unsigned char *head, size_t n, const char *const *keywords);

/* ---- cells: each node stands for the angles nearest to it; degrees in, radians or steradian per radian out ----------------- */

/** Azimuths: the circle when the nodes go around it (a gap at its end of at most twice the largest inside), else from the first to
 *  the last node. `mirrored` nodes within half a circle stand for their mirror images too. */
void ff_cells_circle(const double *node, size_t n, int mirrored, double *cell);

/** Polar angles: cos(low) - cos(high) of the cells from 0 to `end`; end < 0: half a step past the last node. */
void ff_cells_polar(const double *node, size_t n, double end, double *cell);

/** Largest distance between neighbouring nodes, 0 for one node. */
double ff_largest_gap(const double *node, size_t n);
#endif
