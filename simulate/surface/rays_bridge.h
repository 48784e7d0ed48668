/* The only door to Embree and FFTW: rays on a mesh of heights, and the transform that makes heights of a spectrum. It is a module,
 * facetfit_rays.so, that is opened when the first surface is made. */
#ifndef FF_RAYS_BRIDGE_H
#define FF_RAYS_BRIDGE_H
#include "ff_status.h"
#include <stddef.h>
#include <stdint.h>
#ifdef __cplusplus
extern "C" {
#endif

typedef struct ff_mesh ff_mesh;

/** A ray and what it meets first. */
typedef struct ff_ray {
    float o[3], d[3];  /**< from o along d, a unit vector      */
    float far;         /**< as far as this                     */
    float t;           /**< out: where it meets, or below 0    */
    uint32_t triangle; /**< out: of the mesh                  */
} ff_ray;

/** What the module does. */
typedef struct ff_rays {
    int version; /**< FF_RAYS */
    /** h[y][x] = sum over k of a[ky][kx] e^(2 pi i (kx x / nx + ky y / ny)), of the half of a Hermitian a: a [ny][nx / 2 + 1][2],
     * which is overwritten; h [ny][nx]. FF_ERR_MEMORY. */
    ff_status (*transform)(size_t nx, size_t ny, double *a, double *h, ff_error *err);
    /** A mesh of nx x ny heights h [ny][nx], dx and dy apart, the first at (x0, y0). Cell (i, j) is two triangles, number
     *  2 (j (nx - 1) + i) below and beside its diagonal from (i + 1, j) to (i, j + 1), and the next beyond it. Built by the
     * caller's thread alone, so that it is the same every time. FF_ERR_MEMORY, FF_ERR_INTERNAL. */
    ff_status (*mesh_new)(size_t nx, size_t ny, const double *h, double x0, double y0, double dx, double dy, ff_mesh **out,
                          ff_error *err);
    void (*mesh_free)(ff_mesh *mesh); /**< NULL is legal */
    /** May be called from many threads at once. */
    void (*trace)(const ff_mesh *mesh, size_t n, ff_ray *ray);
} ff_rays;

enum { FF_RAYS = 1 };
/** Symbol of the module. */
extern const ff_rays ff_rays_v1;

/** Opens the module, which stays open. FF_ERR_UNSUPPORTED when it is not there; the message says how to get it. */
ff_status ff_rays_get(const ff_rays **out, ff_error *err);

#ifdef __cplusplus
}
#endif
#endif
