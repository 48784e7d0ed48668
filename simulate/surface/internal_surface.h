/* A surface inside: its realisations as tiles, and rays on a tile. Files in the order of their calls: options, map, spectrum,
 * rays_module < tile < paths < surface. */
#ifndef FF_INTERNAL_SURFACE_H
#define FF_INTERNAL_SURFACE_H
#include "ff_height_field.h"
#include "rays_bridge.h"
#include "base/internal_pool.h"
#include "models/internal_model.h"

/* FF_ERR_RANGE, naming the option. */
ff_status ff_height_field_check(const ff_height_field_options *o, ff_error *err);

/* ---- heights --------------------------------------------------------------------------------- */

/* nx x ny heights that repeat themselves, dx and dy apart: h[j nx + i]. */
typedef struct ff_heights {
    size_t nx, ny;
    double *h; /* owned */
    double dx, dy;
} ff_heights;

/* Reads a map: .exr and .tif through the module of images, SDF (ISO 25178-71, text), ESRI text grids, or numbers in rows. The mean
 * plane is taken out, and the edges are faded. pitch as ff_height_field_options. FF_ERR_FORMAT, FF_ERR_DATA and what reading may
 * end with. */
ff_status ff_heights_read(const char *path, const double pitch[2], double unit, ff_heights *out, ff_error *err);

/* The realisation of a number; slopes L L^T / 2. FF_ERR_MEMORY. */
ff_status ff_heights_draw(const ff_rays *rays, const ff_height_field_options *o, const double l[3], uint64_t number,
                          ff_heights *out, ff_error *err);

/* Slopes of triangle k (0, 1) of cell (i, j); neighbours across the edge are those of the other side. */
static inline void ff_heights_slopes(const ff_heights *s, size_t i, size_t j, int k, double *sx, double *sy)
{
    const size_t i1 = i + 1 < s->nx ? i + 1 : 0, j1 = j + 1 < s->ny ? j + 1 : 0;
    const double a = s->h[j * s->nx + i], b = s->h[j * s->nx + i1], c = s->h[j1 * s->nx + i], d = s->h[j1 * s->nx + i1];
    *sx = (k ? d - c : b - a) / s->dx;
    *sy = (k ? d - b : c - a) / s->dy;
}

/* Means of sx^2, sy^2, sx sy and sx^4 over the plane. */
void ff_heights_moments(const ff_heights *s, double m[4]);

/* ---- rays on a tile -------------------------------------------------------------------------- */

typedef struct ff_tile {
    ff_heights heights;
    double lowest, highest, length[2], skin; /* skin: how far from a facet a ray begins */
    const ff_rays *rays;
    ff_mesh *mesh;
} ff_tile;

ff_status ff_tile_make(const ff_rays *rays, ff_heights *heights, ff_tile *out,
                       ff_error *err); /* takes the heights, also on failure */
void ff_tile_clear(ff_tile *t);

typedef enum ff_fate { FF_FLIES = 0, FF_MEETS = 1, FF_LEAVES = 2, FF_IS_LOST = 3 } ff_fate;

/* Rays on their way. m: the normal of the facet that was met. */
typedef struct ff_flights {
    size_t n;
    double p[3][FF_BLOCK], r[3][FF_BLOCK], m[3][FF_BLOCK];
    ff_fate fate[FF_BLOCK];
    ff_ray ray[FF_BLOCK];
} ff_flights;

/* Each goes on to what it meets first, to the edge of the tile, or away. */
void ff_tile_trace(const ff_tile *t, ff_flights *f);

/* A point of triangle k of cell (i, j), u and v in [0, 1] with u + v <= 1 from its corner, and the normal there; a skin above it.
 */
void ff_tile_point(const ff_tile *t, size_t i, size_t j, int k, double u, double v, double p[3], double m[3]);

/* ---- paths ----------------------------------------------------------------------------------- */

struct ff_height_field {
    ff_model model;
    double *channel;
    size_t n_channels;
    ff_height_field_options o;
    const ff_rays *rays;
    ff_prepared prepared;
    const ff_fresnel *fresnel;
    double l[3]; /* l11, l21, l22 */
    int isotropic;
    uint32_t last;
    ff_heights map; /* h NULL: a spectrum */
};

/* Cones about the wo of some pairs, found by the cells of a grid of direction cosines. */
typedef struct ff_cones ff_cones;

/* Paths of one direction on one tile. */
enum { FF_SURFACE_W, FF_SURFACE_WR, FF_SURFACE_SUMS = FF_SURFACE_WR + 3 };
typedef struct ff_paths {
    const ff_height_field *s;
    const ff_tile *tile;
    double wi[3];
    int turned; /* 1: about a random azimuth                                         */
    uint64_t first, n;
    const ff_cones *cones; /* NULL: lobes                                             */
    double *sum;           /* cones: [n_orders][n_channels][cones]; lobes: [..][FF_SURFACE_SUMS]; added to */
    double lost;
} ff_paths;
void ff_paths_run(ff_paths *p);

ff_cones *ff_cones_new(size_t n, const double *const wo[3], double half_angle); /* NULL without memory; wo is borrowed */
void ff_cones_free(ff_cones *c);
/* Adds `weight` [n_channels] (a stride apart) to all cones that hold r: sum [n_channels][cones]. */
void ff_cones_add(const ff_cones *c, const double r[3], size_t n_channels, const double *weight, size_t stride, double *sum);

/* Random numbers in (0, 1), four a call; stream by kind. */
void ff_height_field_random(uint64_t seed, uint64_t id, uint32_t step, uint32_t kind, double u[4]);
#endif
