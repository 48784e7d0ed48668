/** @file internal_interpolate.h  The methods of interpolation behind ff_interpolate.h, a file for each. */
#ifndef FF_INTERNAL_INTERPOLATE_H
#define FF_INTERNAL_INTERPOLATE_H
#include "data_formats/table/table_struct.h"
#include "ff_interpolate.h"
#include "internal_neighbours.h"

/** One axis of a product of nodes, radians. */
typedef struct ff_axis {
    size_t n;
    double *node;
    double period; /**< 0: none; then a coordinate outside the nodes is beyond the data        */
    int folded;    /**< nodes from 0 to pi of an azimuth whose sign makes no difference          */
    int open;      /**< one node only: the coordinate makes no difference                        */
    int centred;   /**< nodes are centres of cells: the outer half of the last one is no gap     */
} ff_axis;

/** Samples at one incident direction. */
typedef struct ff_slice {
    double theta_i, phi_i; /**< degrees; phi_i only where the table is not isotropic */
    ff_neighbours *tree;
} ff_slice;

/** Whether all half vectors lie in the plane of incidence, as those of a scan in that plane do. */
typedef struct ff_plane {
    int all_in;            /**< 1: nothing was measured beside the plane                                        */
    int one_at_normal;     /**< 1: those of light from the normal lie in one plane as well                      */
    double normal_azimuth; /**< its azimuth, radians                                                            */
    double widest;         /**< how far half vectors lie beside the plane, as the sine of an angle              */
} ff_plane;

typedef enum ff_interpolation { FF_PRODUCT, FF_SLICES, FF_SCATTERED, FF_CELLS } ff_interpolation;

struct ff_interpolant {
    const ff_table *t;
    ff_interpolation method;
    int mirrored;      /**< the table is isotropic and has one side of the plane of incidence only */
    ff_plane plane;    /**< regressions: are all samples in the plane of incidence?                */
    ff_axes_kind kind; /**< product   */
    ff_axis axis[4];
    size_t n_slices;     /**< slices    */
    ff_slice *slice;     /**< by theta_i, phi_i */
    ff_neighbours *tree; /**< scattered */
};

/** Each method: find_ says whether the table is of its kind and prepares (1 yes, 0 no, -1 no memory); at_ is the value of every
 * channel, value[c * stride], for unit vectors above the horizon, as seen without the sample `without` (UINT32_MAX: none). */
int ff_product_find(ff_interpolant *p);
ff_found ff_product_at(const ff_interpolant *p, const double wi[3], const double wo[3], double *value, size_t stride);
/** Of a table that has cells. */
ff_found ff_cells_at(const ff_interpolant *p, const double wi[3], const double wo[3], double *value, size_t stride);
int ff_slices_find(ff_interpolant *p);
ff_found ff_slices_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                      size_t stride);
/** First slices of each theta_i, spread evenly when there are more than asked for. */
size_t ff_slices_incidences(const ff_interpolant *p, size_t most, double *theta_i, double *phi_i);
int ff_scattered_find(ff_interpolant *p);
ff_found ff_scattered_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                         size_t stride);

/** in_plane.c: fills p->plane; says whether a pair lies beside the plane of the samples (then all that can be done is to
 * extrapolate); and its two pairs in the plane whose half vectors lean as far, on either side: to [2], the exits, with shares that
 * add up to 1, 0 of one that would look below the horizon. 0: both do. */
void ff_plane_find(ff_interpolant *p);
int ff_plane_is_beside(const ff_plane *plane, const double wi[3], const double wo[3]);
int ff_plane_turn(const ff_plane *plane, const double wi[3], const double wo[3], double to[2][3], double share[2]);

/** A sample that scattered_find adds to its tree may stand there this often. */
enum { FF_SCATTERED_COPIES = 24 };

/** The value at x [dim] of the samples in one tree, by regression over its neighbours: of second degree in the plane, else of
 * first. */
ff_found ff_regress(const ff_table *t, const ff_neighbours *tree, int dim, const double *x, uint32_t without, double *value,
                    size_t stride);

/** Calls visit for every measured sample above the horizon; visit.c. */
typedef void ff_visitor(void *context, size_t i, const double wi[3], const double wo[3]);
void ff_each_usable(const ff_table *t, ff_visitor *visit, void *context);

/** Degrees; directions of files are rounded to more. */
static const double ff_same_place = 1e-6, ff_same_incidence = 1e-4;
#endif
