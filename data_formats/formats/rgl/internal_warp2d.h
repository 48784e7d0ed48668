/** @file internal_warp2d.h  Densities on the unit square that depend on two parameters, and the maps that make them uniform.
 *
 *  For each pair of nodes (a, b) of the parameters the density is bilinear between the numbers of a height x width grid, whose
 *  corners are the corners of the square, and has integral 1; between nodes of the parameters it is interpolated linearly, and
 *  constant beyond the outer ones. The map from uniform s to u with that density goes by its marginal over rows (s.y -> u.y), then
 *  by the density along the row there (s.x -> u.x): Dupuy and Jakob 2018, section 4, and the class of the same kind in their
 * loader.
 *
 *  x is the last index of the grid, y the one before. */
#ifndef FF_INTERNAL_WARP2D_H
#define FF_INTERNAL_WARP2D_H
#include <stddef.h>

typedef struct ff_warp2d {
    size_t width, height; /**< >= 2 each                                                                      */
    size_t n_node[2];     /**< of the parameters, >= 1 each                                                   */
    double *node[2];      /**< [n_node[k]], increasing                                                        */
    float *density;       /**< [n_node[0]][n_node[1]][height][width], divided by the integral in cells         */
    float *marginal;      /**< [slices][height], integral of the rows before                                  */
    float *conditional;   /**< [slices][height][width], integral along the row so far; NULL without inverse    */
} ff_warp2d;

/** Copies nodes; takes over `density` [slices][height][width] (malloc'ed, numbers of any scale, finite and >= 0, each slice with a
 *  positive integral), also on failure. Returns 0 when memory is out. */
int ff_warp2d_new(size_t width, size_t height, const size_t n_node[2], const double *const node[2], float *density,
                  int with_inverse, ff_warp2d *out);
void ff_warp2d_free(ff_warp2d *w);

/** The slices that stand for a point of the parameters: up to four with their weights. */
typedef struct ff_warp2d_mix {
    int n;
    size_t slice[4];
    double weight[4];
} ff_warp2d_mix;
ff_warp2d_mix ff_warp2d_at(const ff_warp2d *w, const double parameter[2]);

/** From u to s; requires the inverse. */
void ff_warp2d_invert(const ff_warp2d *w, const ff_warp2d_mix *mix, const double u[2], double s[2]);

/** From s to u, a row at a time: returns u.y of s_y; what ff_warp2d_along needs goes into row [2 width], unless that is NULL. */
double ff_warp2d_row(const ff_warp2d *w, const ff_warp2d_mix *mix, double s_y, double *row);
/** u.x of s_x in that row; *cell (0 for the first) is kept between calls with increasing s_x. */
double ff_warp2d_along(const ff_warp2d *w, const double *row, double s_x, size_t *cell);

/** Bilinear number of grid [height][width] at u, whose corners are the corners of the square. */
double ff_bilinear(const float *grid, size_t width, size_t height, const double u[2]);
#endif
