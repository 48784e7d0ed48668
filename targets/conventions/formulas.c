/* The conventions of renderers as functions with derivatives. */
#include "internal_formulas.h"
#include <math.h>

#define PI 3.14159265358979323846

/* Passes a derivative on where it is wanted. */
static double with(double value, double *d, double slope)
{
    if (d) d[0] = slope;
    return value;
}

/* ---- one number ------------------------------------------------------------------------------ */

double ff_same(const double *x, double *d)
{
    return with(x[0], d, 1);
}

double ff_square_root(const double *x, double *d)
{
    return with(sqrt(x[0]), d, 0.5 / sqrt(fmax(x[0], 1e-12)));
}

double ff_squared(const double *x, double *d)
{
    return with(x[0] * x[0], d, 2 * x[0]);
}

double ff_fourfold(const double *x, double *d)
{
    return with(4 * x[0], d, 4);
}

double ff_quarter(const double *x, double *d)
{
    return with(0.25 * x[0], d, 0.25);
}

double ff_f0_of_index(const double *x, double *d)
{
    const double root = (x[0] - 1) / (x[0] + 1);
    return with(root * root, d, 4 * root / ((x[0] + 1) * (x[0] + 1)));
}

double ff_index_of_f0(const double *x, double *d)
{
    const double root = sqrt(fmin(x[0], 1 - 1e-9)), gap = 1 - root;
    return with((1 + root) / gap, d, 1 / (fmax(root, 1e-6) * gap * gap));
}

double ff_specular_of_index(const double *x, double *d)
{
    const double specular = ff_f0_of_index(x, d) / 0.08;
    if (d) d[0] /= 0.08;
    return specular;
}

double ff_index_of_specular(const double *x, double *d)
{
    const double f0 = 0.08 * x[0], index = ff_index_of_f0(&f0, d);
    if (d) d[0] *= 0.08;
    return index;
}

double ff_specular_of_f0(const double *x, double *d)
{
    return with(x[0] / 0.08, d, 1 / 0.08);
}

double ff_f0_of_specular(const double *x, double *d)
{
    return with(0.08 * x[0], d, 0.08);
}

double ff_reflectance_of_f0(const double *x, double *d)
{
    const double root = sqrt(x[0] / 0.16);
    return with(root, d, 0.5 / (0.16 * fmax(root, 1e-6)));
}

double ff_f0_of_reflectance(const double *x, double *d)
{
    return with(0.16 * x[0] * x[0], d, 0.32 * x[0]);
}

/* ---- two numbers ----------------------------------------------------------------------------- */

static const double rise_at_82 = 0.46266436305110356; /* (1 - 1/7)^5 */

double ff_tint_of_f82(const double *x, double *d)
{
    const double own = rise_at_82 + (1 - rise_at_82) * x[0];
    if (d) d[0] = -x[1] / (own * own) * (1 - rise_at_82), d[1] = 1 / own;
    return x[1] / own;
}

double ff_f82_of_tint(const double *x, double *d)
{
    const double own = rise_at_82 + (1 - rise_at_82) * x[0];
    if (d) d[0] = x[1] * (1 - rise_at_82), d[1] = own;
    return x[1] * own;
}

double ff_artistic_r(const double *x, double *d)
{
    const double n = x[0], k2 = x[1] * x[1], below = (n + 1) * (n + 1) + k2, r = ((n - 1) * (n - 1) + k2) / below;
    if (d) {
        d[0] = (2 * (n - 1) - r * 2 * (n + 1)) / below;
        d[1] = 2 * x[1] * (1 - r) / below;
    }
    return r;
}

/* n = g n_min + (1 - g) n_max, n_min = (1 - r) / (1 + r), n_max = (1 + sqrt r) / (1 - sqrt r). */
double ff_artistic_g(const double *x, double *d)
{
    double dr[2];
    const double r = ff_artistic_r(x, dr), root = sqrt(r), most = (1 + root) / (1 - root), least = (1 - r) / (1 + r);
    const double range = most - least, g = (most - x[0]) / range;
    if (d) {
        const double d_most = 1 / (root * (1 - root) * (1 - root)), d_least = -2 / ((1 + r) * (1 + r));
        const double by_r = (d_most - g * (d_most - d_least)) / range;
        d[0] = by_r * dr[0] - 1 / range;
        d[1] = by_r * dr[1];
    }
    return g;
}

double ff_artistic_eta(const double *x, double *d)
{
    const double r = x[0], root = sqrt(r);
    (void)d;
    return x[1] * (1 - r) / (1 + r) + (1 - x[1]) * (1 + root) / (1 - root);
}

double ff_artistic_k(const double *x, double *d)
{
    const double n = ff_artistic_eta(x, d), r = x[0];
    return sqrt(fmax((r * (n + 1) * (n + 1) - (n - 1) * (n - 1)) / (1 - r), 0));
}

/* ---- the ellipse ----------------------------------------------------------------------------- */

/* Of [[ax^2, r ax ay], [r ax ay, ay^2]], with the derivatives of each by alpha_x, alpha_y, r_xy. */
typedef struct ellipse {
    double a1, a2, phi, d1[3], d2[3], dphi[3];
} ellipse;

static ellipse ellipse_of(const double *x)
{
    const double ax = x[0], ay = x[1], r = x[2], xx = ax * ax, yy = ay * ay, xy = r * ax * ay;
    const double dxx[3] = {2 * ax, 0, 0}, dyy[3] = {0, 2 * ay, 0}, dxy[3] = {r * ay, r * ax, ax * ay};
    const double half = 0.5 * (xx - yy), gap = hypot(half, xy), mean = 0.5 * (xx + yy);
    ellipse e = {.a1 = sqrt(mean + gap)};
    e.a2 = ax * ay * sqrt((1 - r) * (1 + r)) / e.a1; /* the product is the root of the determinant */
    const int round = gap <= 1e-12 * mean;
    e.phi = round ? 0 : 0.5 * atan2(xy, half);
    if (e.phi < 0) e.phi += PI;
    const double c = cos(e.phi), s = sin(e.phi);
    for (int k = 0; k < 3; k++) {
        /* along an axis that is none the mean of both directions stands for the derivative */
        const double along = round ? 0.5 * (dxx[k] + dyy[k]) : c * c * dxx[k] + 2 * c * s * dxy[k] + s * s * dyy[k];
        const double across = round ? 0.5 * (dxx[k] + dyy[k]) : s * s * dxx[k] - 2 * c * s * dxy[k] + c * c * dyy[k];
        e.d1[k] = along / (2 * e.a1);
        e.d2[k] = across / (2 * e.a2);
        e.dphi[k] = round ? 0 : (c * s * (dyy[k] - dxx[k]) + (c * c - s * s) * dxy[k]) / (2 * gap);
    }
    return e;
}

/* A function of a1 and a2 with its derivatives by them. */
static double of_axes(const ellipse *e, double value, double by_1, double by_2, double *d)
{
    for (int k = 0; d && k < 3; k++) d[k] = by_1 * e->d1[k] + by_2 * e->d2[k];
    return value;
}

static double of_angle(const ellipse *e, double value, double factor, double *d)
{
    for (int k = 0; d && k < 3; k++) d[k] = factor * e->dphi[k];
    return value;
}

double ff_alpha_major(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_axes(&e, e.a1, 1, 0, d);
}

double ff_alpha_minor(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_axes(&e, e.a2, 0, 1, d);
}

double ff_major_radians(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_angle(&e, e.phi, 1, d);
}

double ff_major_degrees(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_angle(&e, e.phi * 180 / PI, 180 / PI, d);
}

double ff_major_turns(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_angle(&e, e.phi / (2 * PI), 1 / (2 * PI), d);
}

double ff_minor_turns(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_angle(&e, fmod(e.phi + PI / 2, PI) / (2 * PI), 1 / (2 * PI), d);
}

double ff_mean_roughness(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    const double value = pow(e.a1 * e.a2, 0.25);
    return of_axes(&e, value, 0.25 * value / e.a1, 0.25 * value / e.a2, d);
}

/* (1 - a2 / a1) * factor */
static double flatness(const double *x, double factor, double *d)
{
    const ellipse e = ellipse_of(x);
    const double ratio = e.a2 / e.a1;
    return of_axes(&e, (1 - ratio) * factor, factor * ratio / e.a1, -factor / e.a1, d);
}

double ff_disney_anisotropy(const double *x, double *d)
{
    return flatness(x, 1 / 0.9, d);
}

double ff_aspect_anisotropy(const double *x, double *d)
{
    return flatness(x, 1, d);
}

double ff_glossy_anisotropy(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    const double root = sqrt(e.a2 / e.a1);
    return of_axes(&e, 1 - root, 0.5 * root / e.a1, -0.5 * root / e.a2, d);
}

double ff_gltf_roughness(const double *x, double *d)
{
    return ff_sqrt_minor(x, d);
}

double ff_gltf_strength(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    const double rest = fmax(1 - e.a2, 1e-9), strength = sqrt(fmax(e.a1 - e.a2, 0) / rest),
                 slope = 0.5 / (rest * fmax(strength, 1e-6));
    return of_axes(&e, strength, slope, slope * (strength * strength - 1), d);
}

double ff_openpbr_roughness(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    const double square = 0.5 * (e.a1 * e.a1 + e.a2 * e.a2), value = pow(square, 0.25), slope = 0.25 * value / square;
    return of_axes(&e, value, slope * e.a1, slope * e.a2, d);
}

double ff_sqrt_major(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_axes(&e, sqrt(e.a1), 0.5 / sqrt(e.a1), 0, d);
}

double ff_sqrt_minor(const double *x, double *d)
{
    const ellipse e = ellipse_of(x);
    return of_axes(&e, sqrt(e.a2), 0, 0.5 / sqrt(e.a2), d);
}

/* ---- the ways back --------------------------------------------------------------------------- */

/* alpha_x, alpha_y or r_xy (which 0, 1, 2) of an ellipse. */
static double stretch_of(double a1, double a2, double phi, int which)
{
    const double c = cos(phi), s = sin(phi), xx = a1 * a1 * c * c + a2 * a2 * s * s, yy = a1 * a1 * s * s + a2 * a2 * c * c;
    const double value[3] = {sqrt(xx), sqrt(yy), (a1 * a1 - a2 * a2) * c * s / sqrt(xx * yy)};
    return value[which];
}

static double disney(const double *x, int which)
{
    const double aspect = sqrt(1 - 0.9 * x[1]), alpha = x[0] * x[0];
    return stretch_of(alpha / aspect, alpha * aspect, 2 * PI * x[2], which);
}

static double glossy(const double *x, int which)
{
    const double alpha = x[0] * x[0];
    return stretch_of(alpha / (1 - x[1]), alpha * (1 - x[1]), 2 * PI * x[2] + PI / 2, which);
}

static double aspect(const double *x, int which)
{
    const double root = sqrt(1 - x[1]), alpha = x[0] * x[0];
    return stretch_of(alpha / root, alpha * root, 2 * PI * x[2], which);
}

static double gltf(const double *x, int which)
{
    const double alpha = x[0] * x[0];
    return stretch_of(alpha + (1 - alpha) * x[1] * x[1], alpha, x[2], which);
}

static double openpbr(const double *x, int which)
{
    const double flat = 1 - x[1], along = x[0] * x[0] * sqrt(2 / (1 + flat * flat));
    return stretch_of(along, flat * along, 2 * PI * x[2], which);
}

static double axes(const double *x, int which)
{
    return stretch_of(x[0], x[1], x[2] * PI / 180, which);
}

static double sqrt_axes(const double *x, int which)
{
    return stretch_of(x[0] * x[0], x[1] * x[1], x[2] * PI / 180, which);
}

#define WAYS_BACK(convention)                                                                                                      \
    double ff_##convention##_x(const double *x, double *d)                                                                         \
    {                                                                                                                              \
        (void)d;                                                                                                                   \
        return convention(x, 0);                                                                                                   \
    }                                                                                                                              \
    double ff_##convention##_y(const double *x, double *d)                                                                         \
    {                                                                                                                              \
        (void)d;                                                                                                                   \
        return convention(x, 1);                                                                                                   \
    }                                                                                                                              \
    double ff_##convention##_r(const double *x, double *d)                                                                         \
    {                                                                                                                              \
        (void)d;                                                                                                                   \
        return convention(x, 2);                                                                                                   \
    }
WAYS_BACK(disney)
WAYS_BACK(glossy)
WAYS_BACK(aspect)
WAYS_BACK(gltf)
WAYS_BACK(openpbr)
WAYS_BACK(axes)
WAYS_BACK(sqrt_axes)
