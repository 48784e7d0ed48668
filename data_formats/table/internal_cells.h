/** @file internal_cells.h  Values that are means over cells of directions, constant within each.
 *
 *  Klems matrices and tensor trees divide both hemispheres without a gap and say one value for every pair of cells. What is between
 *  the centres is therefore known: the same value up to the border. A table of such a file has an ff_cells, whose sample i is the
 *  value of cell i; it may be read from many threads. */
#ifndef FF_INTERNAL_CELLS_H
#define FF_INTERNAL_CELLS_H
#include <stddef.h>
#include <stdint.h>

/** Azimuths of one polar angle of incidence that are looked at, at most. */
enum { FF_CELLS_AZIMUTHS = 360 };

/** Called for every cell that light from one direction goes into.
 *  @param sample     the cell's number
 *  @param projected  integral of cos(theta_o) over it, sr; they add up to pi */
typedef void ff_cells_visitor(void *context, size_t sample, double projected);

/** One of the cells that light from a direction on a border between them goes into. */
typedef struct ff_cells_side {
    double wi[3], weight; /**< a direction within the cell; part of the light */
} ff_cells_side;

enum { FF_CELLS_SIDES = 4 }; /**< at most */

typedef struct ff_cells ff_cells;
struct ff_cells {
    /** Number of the cell around a pair of unit vectors above the horizon, SIZE_MAX where there is none. */
    size_t (*find)(const ff_cells *cells, const double wi[3], const double wo[3]);
    /** All cells of light from wi. */
    void (*visit)(const ff_cells *cells, const double wi[3], ff_cells_visitor *visit, void *context);
    /** A number that is the same for directions of light that go into the same cells. */
    uint64_t (*incident)(const ff_cells *cells, const double wi[3]);
    /** The k-th polar angle of incidence to look at, degrees; NaN where there are no more. */
    double (*theta)(const ff_cells *cells, size_t k);
    /** Azimuths, degrees, spread evenly over one of those: their number, at most FF_CELLS_AZIMUTHS. */
    size_t (*azimuths)(const ff_cells *cells, double theta_i, double *phi_i);
    /** One owner more, for a copy of the table; and one less, the last of whom frees it. */
    ff_cells *(*share)(ff_cells *cells);
    void (*release)(ff_cells *cells);
};

/** The sides of a direction of light: itself alone within a cell; on a border a direction in each cell that meets there, whose
 *  weight is its part of a small surrounding above the horizon. Their number; the weights add up to 1. */
size_t ff_cells_sides(const ff_cells *cells, const double wi[3], ff_cells_side side[FF_CELLS_SIDES]);
#endif
