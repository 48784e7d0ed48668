/* Points of product grids as pairs of directions; what a file's numbers stand for.
 *
 *   half, difference    h at (theta_h, phi_h); d = (sin theta_d cos phi_d, sin theta_d sin phi_d, cos theta_d) is wi seen from the
 * half vector: wi = Rz(phi_h) Ry(theta_h) d, wo = Rz(phi_h) Ry(theta_h) (-dx, -dy, dz)   (Rusinkiewicz 1998) incident, exit      as
 * they stand specular            the light at (incidence, -rotation): turning the sample by +rotation about its normal turns the
 * light by -rotation as the sample sees it. The specular direction is s = (incidence, 180 degrees - rotation). wo lies at the polar
 * angle `radial` from s and the azimuth A about it, A = 0 pointing from s away from the normal: wo = Rz(180 - rotation)
 * Ry(incidence) (sin radial cos A, sin radial sin A, cos radial) */
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
        angle[0] = r[1];
        angle[1] = -r[0];
        about(r[3], r[2], v);
        turned(r[1], pi - r[0], v, &angle[2], &angle[3]);
    }
    for (int k = 0; k < 4; k++) angle[k] /= unit;
    if (kind == FF_AXES_SPECULAR) {
        angle[0] = q[1]; /* not through radians and back */
        angle[1] = -q[0];
    }
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
        q[0] = -phi_i;
        q[1] = theta_i;
        seen(theta_i, phi_i + pi, wo, &q[3], &q[2]);
    } else {
        q[0] = theta_i;
        q[1] = phi_i;
        q[2] = atan2(hypot(wo[0], wo[1]), wo[2]);
        q[3] = azimuth_of(wo);
    }
}

const char *ff_quantity_name(int quantity)
{
    static const char *const name[3] = {"brdf", "brdf-cos", "reflectance-factor"};
    return quantity >= 0 && quantity < 3 ? name[quantity] : NULL;
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
