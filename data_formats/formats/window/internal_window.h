/** @file internal_window.h  The numbers of a WINDOW file: patches of the hemisphere, matrices over them, tensor trees. */
#ifndef FF_INTERNAL_WINDOW_H
#define FF_INTERNAL_WINDOW_H
#include "data_formats/table/internal_table.h"

/* ---- bases ----------------------------------------------------------------------------------- */

enum { FF_WINDOW_NAME = 64, FF_WINDOW_RINGS = 128, FF_WINDOW_PATCHES = 1 << 20 };

/** One ring of patches, all of the same size; patch k is centred at the azimuth 360 k / n_phi. Degrees. */
typedef struct ff_window_ring {
    double theta, lower, upper;
    size_t n_phi;
} ff_window_ring;

/** A division of the hemisphere into patches, numbered ring by ring from the normal. */
typedef struct ff_window_basis {
    char name[FF_WINDOW_NAME];
    size_t n_rings, n; /**< n: patches of all rings */
    ff_window_ring ring[FF_WINDOW_RINGS];
} ff_window_basis;

/** Fills a basis whose name is set with the rings that the name stands for ("LBNL/Klems Full", Half, Quarter): 1, else 0. */
int ff_window_standard_basis(ff_window_basis *b);

/** Adds a ring beyond the last one. FF_ERR_DATA for one that does not continue it, FF_ERR_UNSUPPORTED for a ring of one patch,
 * whose values have no azimuth. */
ff_status ff_window_add_ring(ff_window_basis *b, const ff_window_ring *ring, const char *path, long line, ff_error *err);

/** Centres and solid angles of the patches: theta, phi (degrees), omega (sr) [n] each. */
void ff_window_patches(const ff_window_basis *b, double *theta, double *phi, double *omega);

/* ---- scattering data ------------------------------------------------------------------------- */

enum { FF_TREE_LEVELS = 20, FF_SCATTERING_BUFFER = 1 << 14 };

/** An open node of a tree: a cube whose width is that of its level. */
typedef struct ff_tree_node {
    double corner[4];
    unsigned children; /**< nodes closed in it so far                    */
} ff_tree_node;

/** Where the cell of a sample of a tree lies: a cube of FF_TREE_LEVELS levels whose corner is in units of the smallest cell. */
typedef struct ff_tree_place {
    uint32_t corner[4];
    unsigned char level;
} ff_tree_place;

/** A cell of the directions on one side. Degrees. */
typedef struct ff_tree_cell {
    double theta, phi, omega;
} ff_tree_cell;

/** Reader of the text of one ScatteringData, in pieces of any size. Zero-initialise, then set what is named first. */
typedef struct ff_scattering {
    const char *path;
    ff_error *err;
    char *buffer;             /**< [FF_SCATTERING_BUFFER], the caller's          */
    long (*line)(void *user); /**< where the present piece begins                */
    void *user;
    uint64_t expected; /**< numbers of a matrix                           */
    char what[64];     /**< "145 x 145 values"                            */
    int rank;          /**< 0: a matrix; 3 or 4: a tensor tree            */
    int mirrored;      /**< 1: x of a tree points the other way           */

    size_t n_buffer; /**< text that waits                               */
    long first_line; /**< of the buffer                                 */
    const char *at;  /**< what is being looked at in it                 */
    int comma_may_follow;
    double *value; /**< the matrix; of a tree: the present leaf       */
    size_t n, capacity;
    ff_tree_node node[FF_TREE_LEVELS + 1];
    unsigned depth;     /**< open nodes                                    */
    int closed;         /**< the tree is complete                          */
    ff_tree_cell *cell; /**< of the present leaf                           */
    size_t n_cells;
    ff_rows leaves;       /**< theta_i, phi_i, theta_o, phi_o (degrees), value, d wi d wo */
    ff_tree_place *place; /**< [leaves.n] */
    size_t place_room;
} ff_scattering;

/** Takes the next piece. FF_ERR_DATA for what is no finite number, FF_ERR_FORMAT for too many of them or a tree that is none. */
ff_status ff_scattering_text(ff_scattering *s, const char *text, size_t n);
/** The text is over. FF_ERR_FORMAT where numbers or braces are missing. */
ff_status ff_scattering_end(ff_scattering *s);
void ff_scattering_free(ff_scattering *s);

/* ---- window_cells.c: which cell a pair of directions is in ------------------------------------ */

/** The cells of a matrix with these bases (copied), rows: incidence by incidence; front: azimuths mirrored. NULL: no memory. */
ff_cells *ff_window_matrix_cells(const ff_window_basis *incident, const ff_window_basis *exit, int rows, int front);

/* ---- window_write.c ------------------------------------------------------------------------------ */

/** See ff_format.layout: fifteen directions in every patch of "LBNL/Klems Full", which is also the only grid. */
ff_status ff_window_layout(const ff_table *t, const char *grid, ff_table *out, ff_error *err);

/** Writes the means over these patches. FF_ERR_UNSUPPORTED where one has no sample. */
ff_status ff_window_write(const char *path, const ff_table *t, struct ff_outputs *with, ff_error *err);

/** The cells of a tree: takes over place [n] (malloc'ed), also on failure. NULL: no memory. */
ff_cells *ff_window_tree_cells(int rank, int front, size_t n, ff_tree_place *place);
#endif
