/* Rays on heights that repeat themselves. The mesh has a cell more than the tile on every side, so that no ray slips through where
 * tiles meet; a ray that reaches the edge goes on at the other side. */
#include "internal_surface.h"
#include "base/internal_philox.h"
#include <math.h>
#include <stdlib.h>

void ff_height_field_random(uint64_t seed, uint64_t id, uint32_t step, uint32_t kind, double u[4])
{
    const uint32_t counter[4] = {(uint32_t)id, (uint32_t)(id >> 32), step, kind}, key[2] = {(uint32_t)seed, (uint32_t)(seed >> 32)};
    uint32_t word[4];
    ff_philox(counter, key, word);
    for (int k = 0; k < 4; k++) u[k] = ((double)word[k] + 0.5) * 0x1p-32;
}

static ff_status mesh_of(ff_tile *t, ff_error *err)
{
    const ff_heights *s = &t->heights;
    const size_t nx = s->nx + 3, ny = s->ny + 3;
    double *h = malloc(nx * ny * sizeof *h);
    if (!h) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu x %zu heights", nx, ny);
    for (size_t j = 0; j < ny; j++)
        for (size_t i = 0; i < nx; i++) h[j * nx + i] = s->h[(j + s->ny - 1) % s->ny * s->nx + (i + s->nx - 1) % s->nx];
    const ff_status status = t->rays->mesh_new(nx, ny, h, -s->dx, -s->dy, s->dx, s->dy, &t->mesh, err);
    free(h);
    return status;
}

ff_status ff_tile_make(const ff_rays *rays, ff_heights *heights, ff_tile *out, ff_error *err)
{
    const ff_heights *s = heights;
    ff_tile t = {.heights = *s, .rays = rays, .length = {(double)s->nx * s->dx, (double)s->ny * s->dy}};
    t.lowest = t.highest = s->h[0];
    for (size_t k = 0; k < s->nx * s->ny; k++) {
        t.lowest = fmin(t.lowest, s->h[k]);
        t.highest = fmax(t.highest, s->h[k]);
    }
    t.skin = 1e-6 * fmax(t.length[0], t.length[1]); /* some roundings of a coordinate */
    const ff_status status = mesh_of(&t, err);
    if (status)
        free(t.heights.h);
    else
        *out = t;
    return status;
}

void ff_tile_clear(ff_tile *t)
{
    if (t->rays) t->rays->mesh_free(t->mesh);
    free(t->heights.h);
    *t = (ff_tile){.rays = NULL};
}

static double wrapped(double x, double length)
{
    const double y = x - floor(x / length) * length;
    return y < length ? y : 0;
}

/* How far to the edge of the tile, `beyond` it, or to the height that nothing surpasses. */
static double to_edge(const ff_tile *t, const ff_flights *f, size_t k, double beyond, int *axis)
{
    double far = f->r[2][k] > 0 ? fmax(t->highest - f->p[2][k], 0) / f->r[2][k] + t->skin : INFINITY;
    *axis = 2;
    for (int j = 0; j < 2; j++) {
        const double r = f->r[j][k], way = r > 0 ? t->length[j] - f->p[j][k] + beyond : f->p[j][k] + beyond;
        if (r == 0 || way / fabs(r) >= far) continue;
        far = way / fabs(r);
        *axis = j;
    }
    return far;
}

static void normal_of(double sx, double sy, double m[3])
{
    const double inv = 1 / sqrt(1 + sx * sx + sy * sy);
    m[0] = -sx * inv, m[1] = -sy * inv, m[2] = inv;
}

/* Nothing was met: on to the edge. */
static void fly_on(const ff_tile *t, ff_flights *f, size_t k)
{
    int axis;
    const double way = to_edge(t, f, k, 0, &axis);
    if (axis == 2 || !isfinite(way)) {
        f->fate[k] = f->r[2][k] > 0 ? FF_LEAVES : FF_IS_LOST;
        return;
    }
    for (int j = 0; j < 3; j++) f->p[j][k] += way * f->r[j][k];
    f->p[axis][k] = f->r[axis][k] > 0 ? 0 : t->length[axis];
    f->fate[k] = f->r[2][k] < 0 && f->p[2][k] < t->lowest - t->skin ? FF_IS_LOST : FF_FLIES;
}

/* The facet of the mesh's triangle; the point is put a skin above it. A ray that comes from below has slipped through. */
static void meet(const ff_tile *t, ff_flights *f, size_t k)
{
    const ff_heights *s = &t->heights;
    const size_t width = s->nx + 2, cell = f->ray[k].triangle / 2;
    const size_t i = (cell % width + s->nx - 1) % s->nx, j = (cell / width + s->ny - 1) % s->ny;
    double sx, sy, m[3];
    ff_heights_slopes(s, i, j, (int)(f->ray[k].triangle % 2), &sx, &sy);
    normal_of(sx, sy, m);
    const double c = -(f->r[0][k] * m[0] + f->r[1][k] * m[1] + f->r[2][k] * m[2]);
    for (int a = 0; a < 3; a++) {
        f->m[a][k] = m[a];
        f->p[a][k] += f->ray[k].t * f->r[a][k] + t->skin * m[a];
    }
    for (int a = 0; a < 2; a++) f->p[a][k] = wrapped(f->p[a][k], t->length[a]);
    f->fate[k] = c > 0 ? FF_MEETS : FF_IS_LOST;
}

void ff_tile_trace(const ff_tile *t, ff_flights *f)
{
    const double beyond = 0.5 * fmin(t->heights.dx, t->heights.dy);
    int axis;
    for (size_t k = 0; k < f->n; k++) {
        ff_ray *ray = &f->ray[k];
        for (int j = 0; j < 3; j++) {
            ray->o[j] = (float)f->p[j][k];
            ray->d[j] = (float)f->r[j][k];
        }
        ray->far = (float)to_edge(t, f, k, beyond, &axis);
    }
    t->rays->trace(t->mesh, f->n, f->ray);
    for (size_t k = 0; k < f->n; k++)
        if (f->ray[k].t >= 0)
            meet(t, f, k);
        else
            fly_on(t, f, k);
}

void ff_tile_point(const ff_tile *t, size_t i, size_t j, int k, double u, double v, double p[3], double m[3])
{
    const ff_heights *s = &t->heights;
    const double x = k ? 1 - u : u, y = k ? 1 - v : v;
    const double corner = s->h[k ? (j + 1) % s->ny * s->nx + (i + 1) % s->nx : j * s->nx + i];
    double sx, sy;
    ff_heights_slopes(s, i, j, k, &sx, &sy);
    normal_of(sx, sy, m);
    p[0] = ((double)i + x) * s->dx;
    p[1] = ((double)j + y) * s->dy;
    p[2] = corner + (k ? -1 : 1) * (u * sx * s->dx + v * sy * s->dy);
    for (int a = 0; a < 3; a++) p[a] += t->skin * m[a];
    for (int a = 0; a < 2; a++) p[a] = wrapped(p[a], t->length[a]);
}
