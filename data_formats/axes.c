/* Points of product grids as pairs of directions; what a file's numbers stand for.
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
#include "ff_model.h"
#include <math.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

/* Rz(phi) Ry(theta) v as angles in radians. */
static void turned(double theta, double phi, const double v[3], double *polar, double *azimuth)
{
    const double x = cos(theta) * v[0] + sin(theta) * v[2], y = v[1], z = cos(theta) * v[2] - sin(theta) * v[0];
    *polar = atan2(hypot(x, y), z);
    *azimuth = atan2(y, x) + phi;
}

static void about(double polar, double azimuth, double v[3])
{
    v[0] = sin(polar) * cos(azimuth);
    v[1] = sin(polar) * sin(azimuth);
    v[2] = cos(polar);
}

void ff_axes_angles(ff_axes_kind kind, double unit, const double q[4], double angle[4])
{
    double v[3], r[4];
    memcpy(angle, q, 4 * sizeof *angle);
    if (kind != FF_AXES_HALF_DIFFERENCE && kind != FF_AXES_SPECULAR) return;
    for (int k = 0; k < 4; k++) r[k] = q[k] * unit;
    if (kind == FF_AXES_HALF_DIFFERENCE) {
        about(r[2], r[3], v);
        turned(r[0], r[1], v, &angle[0], &angle[1]);
        about(r[2], r[3] + pi, v);
        turned(r[0], r[1], v, &angle[2], &angle[3]);
    } else {
        about(r[3], r[2] + pi, v);
        turned(r[1], pi / 2 - r[0], v, &angle[2], &angle[3]);
    }
    for (int k = 0; k < 4; k++) angle[k] /= unit;
    if (kind == FF_AXES_SPECULAR) {
        angle[0] = q[1]; /* not through radians and back */
        angle[1] = -pi / 2 / unit - q[0];
    }
}

ff_quantity ff_read_quantity(const ff_read_options *o, ff_quantity in_file)
{
    return o->quantity >= 0 ? (ff_quantity)o->quantity : in_file;
}

static void divide_by_cosine(ff_table *t)
{
    enum { BLOCK = 512 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t n = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, n, planes);
        for (size_t k = 0; k < n; k++) {
            const int gone = !(plane[5][k] > FF_COS_MIN);
            if (gone) t->valid[first + k] = 0;
            for (size_t c = 0; c < t->n_channels; c++) {
                double *v = t->value + c * t->n + first + k, *s = t->sigma ? t->sigma + c * t->n + first + k : v;
                *v = gone ? 0 : *v / plane[5][k];
                if (s != v) *s = gone ? 0 : *s / plane[5][k];
            }
        }
    }
}

void ff_table_set_quantity(ff_table *t, ff_quantity quantity)
{
    t->quantity = quantity;
    if (quantity == FF_BRDF_COS) divide_by_cosine(t);
    for (size_t c = 0; c < t->n_channels && quantity == FF_REFLECTANCE_FACTOR; c++) t->channels[c].scale /= pi;
}

void ff_table_name_channels_like(ff_table *t, const ff_table *from)
{
    static const char *const rgb[3] = {"r", "g", "b"};
    for (size_t c = 0; c < t->n_channels; c++) {
        ff_channel *to = &t->channels[c];
        if (from->n_channels == 1 && t->n_channels == 3) {
            strcpy(to->name, rgb[c]);
            continue;
        }
        const ff_channel *source = &from->channels[from->n_channels == 1 ? 0 : c];
        memcpy(to->name, source->name, sizeof to->name);
        to->wavelength_nm = source->wavelength_nm;
    }
}
