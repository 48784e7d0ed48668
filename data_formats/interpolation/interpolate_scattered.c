/* Interpolation among samples without any order. */
#include "internal_interpolate.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double degrees = 180 / 3.14159265358979323846;

/* The coordinates of scattered samples; their number. */
static int in_space(int isotropic, const double wi[3], const double wo[3], double x[4])
{
    double q[4];
    ff_axes_point(FF_AXES_HALF_DIFFERENCE, wi, wo, q);
    const double h = FF_INTERPOLATE_HALF_SCALE * degrees * q[0], d = degrees * q[2];
    if (isotropic) {
        x[0] = h * cos(q[3]);
        x[1] = -h * sin(q[3]);
        x[2] = d;
        return 3;
    }
    x[0] = h * cos(q[1]);
    x[1] = h * sin(q[1]);
    x[2] = d * cos(q[3] + q[1]);
    x[3] = d * sin(q[3] + q[1]);
    return 4;
}

/* A pair whose difference azimuth is undetermined (light and detector in one place) stands on a circle of the isotropic
 * coordinates. */
enum { RING = FF_SCATTERED_COPIES / 2 }; /* and each may be mirrored */
static size_t copies_of(int isotropic, const double x[4], const double wi[3], const double wo[3])
{
    const double apart = fabs(wi[0] - wo[0]) + fabs(wi[1] - wo[1]) + fabs(wi[2] - wo[2]);
    return isotropic && apart < 1e-7 && hypot(x[0], x[1]) > ff_same_place ? RING : 1;
}

typedef struct gathering {
    int isotropic, mirrored, dim;
    size_t n;
    double *point; /* NULL: only count */
    uint32_t *sample;
} gathering;

static void gather_at(gathering *g, size_t i, const double x[4], const double wi[3], const double wo[3])
{
    const size_t copies = copies_of(g->isotropic, x, wi, wo);
    for (size_t j = 0; j < copies && g->point; j++) {
        const double turn = 2 * pi * (double)j / RING;
        double *to = g->point + (g->n + j) * (size_t)g->dim;
        memcpy(to, x, (size_t)g->dim * sizeof *to);
        to[0] = cos(turn) * x[0] - sin(turn) * x[1];
        to[1] = sin(turn) * x[0] + cos(turn) * x[1];
        g->sample[g->n + j] = (uint32_t)i;
    }
    g->n += copies;
}

static void gather(void *context, size_t i, const double wi[3], const double wo[3])
{
    gathering *g = context;
    double x[4];
    in_space(g->isotropic, wi, wo, x);
    gather_at(g, i, x, wi, wo);
    x[1] *= -1;
    if (g->mirrored) gather_at(g, i, x, wi, wo);
}

int ff_scattered_find(ff_interpolant *p)
{
    gathering g = {.isotropic = p->t->isotropic, .mirrored = p->mirrored, .dim = p->t->isotropic ? 3 : 4};
    ff_each_usable(p->t, gather, &g);
    if (g.n == 0) return 0;
    g.point = malloc(g.n * (size_t)g.dim * sizeof *g.point);
    g.sample = malloc(g.n * sizeof *g.sample);
    if (g.point && g.sample) {
        const size_t n = g.n;
        g.n = 0;
        ff_each_usable(p->t, gather, &g);
        p->tree = ff_neighbours_new(g.dim, n, g.point, g.sample); /* takes both over */
    } else {
        free(g.point);
        free(g.sample);
    }
    return p->tree ? 1 : -1;
}

ff_found ff_scattered_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                         size_t stride)
{
    double x[4];
    const int dim = in_space(p->t->isotropic, wi, wo, x);
    return ff_regress(p->t, p->tree, dim, x, without, value, stride);
}
