/* Scans in the plane of incidence. Half vectors of such samples lie on a line through the normal: what is beside it is not between
 * them, however near, since nothing says how values fall off across the line. */
#include "models/model_struct.h"
#include "internal_interpolate.h"
#include <math.h>

/* Sine of half a degree: how far a scan may leave the plane. */
static const double out_of_line = 0.0087;
static const double at_normal = 1e-6;

/* Half vector, and its components along an azimuth and across it. */
static void lean(const double wi[3], const double wo[3], double azimuth, double h[3], double *along, double *across)
{
    double length = 0;
    for (int k = 0; k < 3; k++) h[k] = wi[k] + wo[k];
    length = sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (int k = 0; k < 3; k++) h[k] /= length;
    *along = cos(azimuth) * h[0] + sin(azimuth) * h[1];
    *across = cos(azimuth) * h[1] - sin(azimuth) * h[0];
}

/* Of the plane of incidence; of light from the normal that of its samples. */
static double azimuth_of(const ff_plane *plane, const double wi[3])
{
    return hypot(wi[0], wi[1]) > at_normal ? atan2(wi[1], wi[0]) : plane->normal_azimuth;
}

typedef struct finding {
    ff_plane *plane;
    size_t oblique, normal;
    double widest, widest_at_normal;
} finding;

static void look(void *context, size_t i, const double wi[3], const double wo[3])
{
    finding *f = context;
    double h[3], along, across;
    (void)i;
    const int oblique = hypot(wi[0], wi[1]) > at_normal;
    lean(wi, wo, azimuth_of(f->plane, wi), h, &along, &across);
    if (oblique) {
        f->oblique++;
        f->widest = fmax(f->widest, fabs(across));
    } else if (hypot(h[0], h[1]) > out_of_line) {
        if (f->normal++ == 0) {
            f->plane->normal_azimuth = atan2(h[1], h[0]);
            across = 0;
        }
        f->widest_at_normal = fmax(f->widest_at_normal, fabs(across));
    }
}

void ff_plane_find(ff_interpolant *p)
{
    finding f = {.plane = &p->plane};
    p->plane = (ff_plane){0};
    ff_each_usable(p->t, look, &f);
    p->plane.all_in = f.oblique > 0 && f.widest <= out_of_line;
    p->plane.one_at_normal = f.normal > 0 && f.widest_at_normal <= out_of_line;
    p->plane.widest = fmax(f.widest, p->plane.one_at_normal ? f.widest_at_normal : 0);
}

int ff_plane_is_beside(const ff_plane *plane, const double wi[3], const double wo[3])
{
    static const double rounding = 1e-6;
    double h[3], along, across;
    if (!plane->all_in || (hypot(wi[0], wi[1]) <= at_normal && !plane->one_at_normal)) return 0;
    lean(wi, wo, azimuth_of(plane, wi), h, &along, &across);
    return fabs(across) > plane->widest + rounding;
}

int ff_plane_turn(const ff_plane *plane, const double wi[3], const double wo[3], double to[2][3], double share[2])
{
    const double azimuth = azimuth_of(plane, wi);
    double h[3], along, across, sum = 0;
    lean(wi, wo, azimuth, h, &along, &across);
    const double sine = hypot(along, across);
    for (int k = 0; k < 2; k++) {
        const double s = k ? -sine : sine, m[3] = {s * cos(azimuth), s * sin(azimuth), h[2]};
        const double c = wi[0] * m[0] + wi[1] * m[1] + wi[2] * m[2];
        for (int j = 0; j < 3; j++) to[k][j] = 2 * c * m[j] - wi[j];
        share[k] = c > 0 && to[k][2] > FF_COS_MIN ? 0.5 * (1 + along / s) : 0;
        sum += share[k];
    }
    for (int k = 0; k < 2 && sum > 0; k++) share[k] /= sum;
    return sum > 0;
}
