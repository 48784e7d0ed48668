/* Points of product grids as pairs of directions, and the solid angles that they stand for.
 *
 * half, difference: h at (theta_h, phi_h); d = (sin theta_d cos phi_d, sin theta_d sin phi_d, cos theta_d) is wi seen from h,
 *     wi = Rz(phi_h) Ry(theta_h) d,  wo = Rz(phi_h) Ry(theta_h) (-dx, -dy, dz)  (Rusinkiewicz 1998).
 * incident, exit: as they stand.
 * specular: turning the sample by +rotation about its normal turns the light by -rotation as the sample sees it. At rotation 0
 *     the plane of incidence is yz, its normal x, and the light comes from -y: it is at (incidence, -90 degrees - rotation), the
 *     specular direction s at (incidence, 90 degrees - rotation). wo lies at the polar angle `radial` from s, at the azimuth A
 *     about it: A = 0 points from s towards the normal, and A grows counter-clockwise for an eye that s points at,
 *     wo = Rz(90 - rotation) Ry(incidence) (-sin radial cos A, -sin radial sin A, cos radial).
 *     So has it the BSDF data interchange format (format_zemax.c), whose local +x is our x. */
#include "internal_table.h"
#include "models/model_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* An angle in radians with its cosine and sine: an axis has few, and a table many samples. */
typedef struct turn {
    double angle, c, s;
} turn;

static turn turn_of(double angle)
{
    return (turn){angle, cos(angle), sin(angle)};
}

/* Rz(phi) Ry(theta) v as angles in radians. */
static void turned(turn theta, double phi, const double v[3], double *polar, double *azimuth)
{
    const double x = theta.c * v[0] + theta.s * v[2], y = v[1], z = theta.c * v[2] - theta.s * v[0];
    *polar = atan2(sqrt(x * x + y * y), z);
    *azimuth = atan2(y, x) + phi;
}

/* `sign` -1: at the azimuth + 180 degrees. */
static void about(turn polar, turn azimuth, double sign, double v[3])
{
    v[0] = sign * polar.s * azimuth.c;
    v[1] = sign * polar.s * azimuth.s;
    v[2] = polar.c;
}

/* The point q, whose angles in radians are r. */
static void point(ff_axes_kind kind, double unit, const double q[4], const turn r[4], double angle[4])
{
    double v[3];
    if (kind == FF_AXES_HALF_DIFFERENCE) {
        about(r[2], r[3], 1, v);
        turned(r[0], r[1].angle, v, &angle[0], &angle[1]);
        about(r[2], r[3], -1, v);
        turned(r[0], r[1].angle, v, &angle[2], &angle[3]);
        for (int k = 0; k < 4; k++) angle[k] /= unit;
    } else if (kind == FF_AXES_SPECULAR) {
        about(r[3], r[2], -1, v);
        turned(r[1], pi / 2 - r[0].angle, v, &angle[2], &angle[3]);
        angle[0] = q[1]; /* not through radians and back */
        angle[1] = -pi / 2 / unit - q[0];
        for (int k = 2; k < 4; k++) angle[k] /= unit;
    } else {
        memcpy(angle, q, 4 * sizeof *angle);
    }
}

void ff_axes_angles(ff_axes_kind kind, double unit, const double q[4], double angle[4])
{
    turn r[4];
    for (int k = 0; k < 4; k++) r[k] = turn_of(q[k] * unit);
    point(kind, unit, q, r, angle);
}

int ff_axes_fill(const ff_axes *axes, double unit, double *const angle[4])
{
    const size_t *n = axes->n;
    turn *all = malloc((n[0] + n[1] + n[2] + n[3]) * sizeof *all), *of[4], r[4];
    double q[4], *to[4] = {angle[0], angle[1], angle[2], angle[3]}, one[4];
    size_t a[4], used = 0;
    if (!all) return 0;
    for (int k = 0; k < 4; used += n[k++]) {
        of[k] = all + used;
        for (size_t i = 0; i < n[k]; i++) of[k][i] = turn_of(axes->node[k][i] * unit);
    }
    for (a[0] = 0; a[0] < n[0]; a[0]++)
        for (a[1] = 0; a[1] < n[1]; a[1]++)
            for (a[2] = 0; a[2] < n[2]; a[2]++)
                for (a[3] = 0; a[3] < n[3]; a[3]++) {
                    for (int k = 0; k < 4; k++) q[k] = axes->node[k][a[k]], r[k] = of[k][a[k]];
                    point(axes->kind, unit, q, r, one);
                    for (int k = 0; k < 4; k++) *to[k]++ = one[k];
                }
    free(all);
    return 1;
}

/* The polar angles of v as seen from a frame turned by Rz(phi) Ry(theta). */
static void seen(double theta, double phi, const double v[3], double *polar, double *azimuth)
{
    const double x0 = cos(phi) * v[0] + sin(phi) * v[1], y = cos(phi) * v[1] - sin(phi) * v[0];
    const double x = cos(theta) * x0 - sin(theta) * v[2], z = sin(theta) * x0 + cos(theta) * v[2];
    *polar = atan2(hypot(x, y), z);
    *azimuth = x == 0 && y == 0 ? 0 : atan2(y, x);
}

static double azimuth_of(const double v[3])
{
    return v[0] == 0 && v[1] == 0 ? 0 : atan2(v[1], v[0]);
}

void ff_axes_point(ff_axes_kind kind, const double wi[3], const double wo[3], double q[4])
{
    const double theta_i = atan2(hypot(wi[0], wi[1]), wi[2]), phi_i = azimuth_of(wi);
    if (kind == FF_AXES_HALF_DIFFERENCE) {
        const double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
        q[0] = atan2(hypot(h[0], h[1]), h[2]);
        q[1] = azimuth_of(h);
        seen(q[0], q[1], wi, &q[2], &q[3]);
    } else if (kind == FF_AXES_SPECULAR) {
        const int upright = wi[0] == 0 && wi[1] == 0;
        q[0] = upright ? 0 : phi_i >= pi / 2 ? 1.5 * pi - phi_i : -pi / 2 - phi_i; /* in (-pi, pi] */
        q[1] = theta_i;
        seen(-theta_i, upright ? -pi / 2 : phi_i, wo, &q[3], &q[2]);
    } else {
        q[0] = theta_i;
        q[1] = phi_i;
        q[2] = atan2(hypot(wo[0], wo[1]), wo[2]);
        q[3] = azimuth_of(wo);
    }
}

void ff_polar_bands(const double *node, size_t n, double unit, double *band)
{
    double low = n > 1 ? fmax(0, node[0] - (node[1] - node[0]) / 2) * unit : 0;
    for (size_t k = 0; k < n; k++) {
        double high = pi / 2;
        if (k + 1 < n)
            high = (node[k] + node[k + 1]) / 2 * unit;
        else if (n > 1)
            high = fmin(pi / 2, (node[k] + (node[k] - node[k - 1]) / 2) * unit);
        band[k] = 2 * sin((low + high) / 2) * sin((high - low) / 2); /* cos low - cos high without its cancellation */
        low = high;
    }
}

void ff_table_product_weights(ff_table *t, const double *const factor[4])
{
    const size_t *n = t->axes.n;
    double *w = t->weight;
    for (size_t a = 0; a < n[0]; a++)
        for (size_t b = 0; b < n[1]; b++)
            for (size_t c = 0; c < n[2]; c++) {
                const double abc = factor[0][a] * factor[1][b] * factor[2][c];
                for (size_t d = 0; d < n[3]; d++) *w++ = abc * factor[3][d];
            }
}
