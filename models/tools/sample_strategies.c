/* How each strategy draws a direction, and the density with which it does. */
#define FF_ISA_SUFFIX scalar
#include "internal_sample.h"
#include "models/terms/internal_isotropic.h"

/* ---- views ----------------------------------------------------------------------------------- */

/* The view of the unit surface: (l, v0) of the head of sample.c. */
typedef struct unit_view {
    double lx, ly, v0;
} unit_view;

static unit_view unit_view_of(const ff_sample_component *k, const double o[3])
{
    const ff_stretch *s = &k->pass->s;
    return (unit_view){k->l11 * o[0] + k->l21 * o[1], k->l22 * o[1], o[2] - o[0] * s->x0 - o[1] * s->y0};
}

/* N: the area that the unit surface shows to the view. */
static double visible_area(const ff_sample_component *k, const unit_view *v)
{
    const double l2 = v->lx * v->lx + v->ly * v->ly;
    if (k->kind == FF_SAMPLE_VISIBLE_GGX) return 0.5 * (v->v0 + sqrt(l2 + v->v0 * v->v0));
    const double length = sqrt(l2);
    const ff_gaussian_view g = ff_gaussian_view_of(length, v->v0);
    return (length + v->v0) * (1 / FF_SQRT_PI) * ff_gaussian_mass(&g);
}

int ff_sample_sees(const ff_sample_component *k, const double o[3])
{
    return o[2] > FF_COS_MIN && (!k->ndf || unit_view_of(k, o).v0 > 0);
}

/* ---- drawing --------------------------------------------------------------------------------- */

/* wi = 2 (wo.h) h - wo for an h of any length. */
static void mirror(const double o[3], const double h[3], double wi[3])
{
    const double twice = 2 * (o[0] * h[0] + o[1] * h[1] + o[2] * h[2]) / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (int j = 0; j < 3; j++) wi[j] = twice * h[j] - o[j];
}

/* From the unit surface to h: m of the direction (-u, 1), of any length. */
static void mirror_unit(const ff_sample_component *k, const double o[3], double mx, double my, double mz, double wi[3])
{
    const ff_stretch *s = &k->pass->s;
    const double h[3] = {k->l11 * mx - s->x0 * mz, k->l21 * mx + k->l22 * my - s->y0 * mz, mz};
    mirror(o, h, wi);
}

static void draw_ggx(const ff_sample_component *k, const double o[3], double u1, double u2, double wi[3])
{
    const unit_view v = unit_view_of(k, o);
    const double inv = 1 / sqrt(v.lx * v.lx + v.ly * v.ly + v.v0 * v.v0), top = v.v0 * inv;
    const double low = u1 * (1 + top), side = sqrt(low * (2 - low)), turn = 2 * FF_PI * u2; /* in the cap z > -top */
    mirror_unit(k, o, side * cos(turn) + v.lx * inv, side * sin(turn) + v.ly * inv, (1 - u1) * (1 + top), wi);
}

static void draw_gaussian(const ff_sample_component *k, const double o[3], double u1, double u2, double wi[3])
{
    static const ff_gaussian_view across = {1, 0, -INFINITY};
    const unit_view v = unit_view_of(k, o);
    const double length = sqrt(v.lx * v.lx + v.ly * v.ly);
    const ff_gaussian_view along = ff_gaussian_view_of(length, v.v0);
    const double ex = length > 0 ? v.lx / length : 1, ey = length > 0 ? v.ly / length : 0;
    const double x = ff_gaussian_quantile(&along, u1), y = ff_gaussian_quantile(&across, u2);
    mirror_unit(k, o, x * ex - y * ey, x * ey + y * ex, 1, wi);
}

static void draw_normal(const ff_sample_component *k, const double o[3], double u1, double u2, double wi[3])
{
    const double q2 = k->quantile ? k->quantile(&k->pass->ndf_pass, u1) : ff_sample_radial_quantile(&k->radial, u1);
    const double q = sqrt(q2 < 1e80 ? q2 : 1e80), turn = 2 * FF_PI * u2;
    mirror_unit(k, o, q * cos(turn), q * sin(turn), 1, wi);
}

/* mu^2 with the fraction u of the area under `rest` below it: linear between nodes, so that the integral is quadratic. */
static double matte_quantile(const ff_sample_component *k, double u)
{
    const double area = u * k->below[FF_SAMPLE_MATTE - 1];
    int j = 0;
    while (j < FF_SAMPLE_MATTE - 2 && k->below[j + 1] <= area) j++;
    const double first = ff_matte_node(j), width = ff_matte_node(j + 1) - first, need = (area - k->below[j]) / width;
    const double r0 = k->rest[j], rise = k->rest[j + 1] - r0, root = sqrt(fmax(r0 * r0 + 2 * rise * need, 0));
    return fmin(first + width * 2 * need / (r0 + root), 1);
}

/* Around z: the square of the cosine mu. */
static void draw_around(double mu2, double u2, double wi[3])
{
    const double side = sqrt(1 - mu2), turn = 2 * FF_PI * u2;
    wi[0] = side * cos(turn);
    wi[1] = side * sin(turn);
    wi[2] = sqrt(mu2);
}

/* Direction cosines: beta = -wo + d (cos, sin) of density (1 + (d / width)^2)^-power over the disc d < 1 + sin(theta_o), which
 * holds all that is above the horizon; d beta = wi.z dwi. With u = (d / width)^2 the mass within is pi width^2 times
 *     ((1 + u)^m - 1) / m,  m = 1 - power,
 * ln(1 + u) where m = 0. */
static double peak_mass(const ff_sample_component *k, double u)
{
    const double m = 1 - k->power, l = log1p(u);
    return fabs(m) * l > 1e-9 ? expm1(m * l) / m : l;
}

static double peak_farthest(const ff_sample_component *k, double oz)
{
    const double farthest = (1 + sqrt(fmax((1 - oz) * (1 + oz), 0))) / k->width;
    return farthest * farthest;
}

static double peak_quantile(const ff_sample_component *k, double oz, double u)
{
    const double m = 1 - k->power, farthest = peak_farthest(k, oz), mass = u * peak_mass(k, farthest);
    const double l = fabs(m) * log1p(farthest) > 1e-9 ? log1p(fmax(m * mass, -1)) / m : mass;
    return fmin(expm1(l), farthest);
}

static void draw_peak(const ff_sample_component *k, const double o[3], double u1, double u2, double wi[3])
{
    const double d = k->width * sqrt(peak_quantile(k, o[2], u1)), turn = 2 * FF_PI * u2;
    const double x = d * cos(turn) - o[0], y = d * sin(turn) - o[1], z2 = 1 - x * x - y * y;
    const int lost = !(z2 > 0);
    wi[0] = lost ? 0 : x;
    wi[1] = lost ? 0 : y;
    wi[2] = lost ? -1 : sqrt(z2);
}

void ff_sample_draw(const ff_sample_component *k, const double o[3], double u1, double u2, double wi[3])
{
    switch (k->kind) {
    case FF_SAMPLE_VISIBLE_GGX:
        draw_ggx(k, o, u1, u2, wi);
        break;
    case FF_SAMPLE_VISIBLE_GAUSSIAN:
        draw_gaussian(k, o, u1, u2, wi);
        break;
    case FF_SAMPLE_NORMALS:
        draw_normal(k, o, u1, u2, wi);
        break;
    case FF_SAMPLE_MATTE_TABLE:
        draw_around(matte_quantile(k, u1), u2, wi);
        break;
    case FF_SAMPLE_PEAK:
        draw_peak(k, o, u1, u2, wi);
        break;
    default:
        draw_around(1 - u1, u2, wi);
    }
}

/* ---- densities ------------------------------------------------------------------------------- */

/* Of a lobe. */
static void density_of_lobe(const ff_sample_component *k, const ff_sample_pairs *b, double *out)
{
    const ff_stretch *s = &k->pass->s;
    const double *sx = b->g.plane[FF_G_SX], *sy = b->g.plane[FF_G_SY], *c = b->g.plane[FF_G_C];
    const double inv11 = 1 / k->l11, inv22 = 1 / k->l22, inv_det = inv11 * inv22;
    double q2[FF_BLOCK], p[FF_BLOCK], dlnp[FF_BLOCK];
    for (size_t i = 0; i < b->n; i++) {
        const double ux = (sx[i] - s->x0) * inv11, uy = (sy[i] - s->y0 - k->l21 * ux) * inv22;
        q2[i] = ux * ux + uy * uy;
    }
    k->ndf->profile(&k->pass->ndf_pass, b->n, q2, p, dlnp, NULL);
    for (size_t i = 0; i < b->n; i++) {
        const double inv_hz2 = 1 + sx[i] * sx[i] + sy[i] * sy[i];
        out[i] = 0.25 * inv_det * p[i] * inv_hz2 * inv_hz2; /* D / 4 */
        if (k->kind == FF_SAMPLE_NORMALS) out[i] /= c[i] * (k->unit_area ? sqrt(inv_hz2) : 1) * k->radial.total;
    }
    for (size_t i = 0; i < b->n && k->kind != FF_SAMPLE_NORMALS; i++) {
        const unit_view v = unit_view_of(k, (const double[]){b->w[3][i], b->w[4][i], b->w[5][i]});
        out[i] = v.v0 > 0 ? out[i] / visible_area(k, &v) : 0;
    }
}

/* The density of mu^2 over pi is that of wi over mu. */
static void density_of_matte(const ff_sample_component *k, const ff_sample_pairs *b, double *out)
{
    const double inv = 1 / (FF_PI * k->below[FF_SAMPLE_MATTE - 1]);
    for (size_t i = 0; i < b->n; i++) {
        const double mu = b->w[2][i] > 0 ? fmin(b->w[2][i], 1) : 0;
        const int j = (int)fmin(sqrt(mu) * (FF_SAMPLE_MATTE - 1), FF_SAMPLE_MATTE - 2);
        const double first = ff_matte_node(j), at = (mu * mu - first) / (ff_matte_node(j + 1) - first);
        out[i] = mu * inv * (k->rest[j] + at * (k->rest[j + 1] - k->rest[j]));
    }
}

/* d as the terms have it: 2 (wi.h) sin(theta_h). */
static void density_of_peak(const ff_sample_component *k, const ff_sample_pairs *b, double *out)
{
    const double *sx = b->g.plane[FF_G_SX], *sy = b->g.plane[FF_G_SY], *c = b->g.plane[FF_G_C], width2 = k->width * k->width;
    for (size_t i = 0; i < b->n; i++) {
        const double s2 = sx[i] * sx[i] + sy[i] * sy[i], u = 4 * c[i] * c[i] * s2 / ((1 + s2) * width2);
        const double all = FF_PI * width2 * peak_mass(k, peak_farthest(k, b->w[5][i]));
        out[i] = b->w[2][i] * exp(-k->power * log1p(u)) / all;
    }
}

void ff_sample_density(const ff_sample_component *k, const ff_sample_pairs *b, double *out)
{
    if (k->kind == FF_SAMPLE_MATTE_TABLE)
        density_of_matte(k, b, out);
    else if (k->kind == FF_SAMPLE_PEAK)
        density_of_peak(k, b, out);
    else if (k->kind == FF_SAMPLE_COSINE)
        for (size_t i = 0; i < b->n; i++) out[i] = b->w[2][i] * (1 / FF_PI);
    else
        density_of_lobe(k, b, out);
}
