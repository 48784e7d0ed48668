/* Directional albedo and weak white furnace by quadrature over the stretched slopes of a lobe.
 *
 *   s = s0 + L u      slope of the half vector, L L^T = [[ax^2, r ax ay], [r ax ay, ay^2]], s0 the mean slope
 *   u = q (cos psi, sin psi), q = w sinh x     a heavy tail in q is an exponential in x, which Gauss-Legendre likes; w is where the
 *                                              profile first changes by a factor, near 1 unless the width is among its parameters
 *   e = L (cos psi, sin psi)                   the ray in slope space: s = s0 + q e
 *   h = hz (-sx, -sy, 1), hz^-2 = 1 + |s|^2,   dh = hz^3 ds,  dwi = 4 (wo.h) dh
 *   V = wo.h / hz = oz - o.s                   linear along a ray
 *   wi.z = 2 V hz^2 - oz                       its sign is that of a quadratic along a ray
 *
 *   albedo         integral f iz 4 (wo.h) dh = integral 4 f iz V hz^4 det(L) q dq dpsi,  over iz > 0
 *   weak furnace   integral G1 D (wo.h) / ozp dh = integral G1 (D hz^4) V / ozp det(L) q dq dpsi,  over V > 0, ozp = oz - o.s0
 */
#include "ff_albedo.h"
#include "internal_albedo.h"
#include "base/internal_gauss.h"
#include "models/internal_model.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

enum {
    GROUP = 4,       /* colour channels evaluated at once                                    */
    ORDER_FIRST = 8, /* Gauss-Legendre points of a panel; doubles                            */
    ORDER_LAST = 32,
    CENTRES = 16, /* directions at which panels of psi end                                */
    CUTS = 24     /* places on a ray at which panels of x end                             */
};
static const double tolerance = 1e-9;
static const double panel_x = 1.5;   /* width of a panel of x                                 */
static const double slope_far = 1e6; /* the furnace integral continues as a power law beyond this */
static const double nu_least = 3.01; /* of a tail q^-nu whose facets have a finite area           */

/* ---- the lobe and its rays ------------------------------------------------------------------- */

typedef struct vec2 {
    double x, y;
} vec2;

static double dot2(vec2 a, vec2 b)
{
    return a.x * b.x + a.y * b.y;
}

/* One lobe, taken out of a larger model, with its parameters; GROUP channels at most. */
typedef struct part {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[GROUP * FF_MAX_CHANNEL_PARAMS];
    size_t n_channels;
    ff_prepared prepared; /* for all directions */
} part;

typedef enum integral_kind { LOBES, BASES, FURNACE } integral_kind;

typedef struct integrand {
    integral_kind kind;
    const ff_prepared *p;
    size_t n_channels;
    double o[3];          /* view                                               */
    double l11, l21, l22; /* L                                                  */
    double det;           /* det(L)                                             */
    double width;         /* w                                                  */
    vec2 s0, oxy;
    double v0;  /* V at q = 0, the projected view cosine ozp                */
    int own_g1; /* furnace: V-cavity's G1 instead of the constant g1        */
    double g1;
    double far, p_far, nu; /* furnace: P = p_far (q / far)^-nu beyond far   */
    /* points that wait for their evaluation: directions, weights */
    size_t n;
    double plane[6][FF_BLOCK], w[FF_BLOCK];
    double sum[GROUP];
    size_t n_columns; /* of p->wanted: derivatives that are summed too */
    double column_sum[GROUP][FF_ALBEDO_COLUMNS];
} integrand;

/* f of every channel; of a model with bases, the bases alone. Or D of its lobe. */
static void evaluate(const ff_prepared *p, integral_kind kind, const ff_dirs *w, size_t n, double f[GROUP][FF_BLOCK])
{
    const uint32_t needs = ff_prepared_planes(p);
    double planes[FF_G_COUNT][FF_BLOCK], other[3][FF_BLOCK];
    ff_geometry g = {{NULL}};
    ff_block b;
    for (int k = 0; k < FF_G_COUNT; k++)
        if (needs & 1u << k) g.plane[k] = planes[k];
    p->kernels->geometry(w, n, &g);
    if (kind == FURNACE) {
        p->kernels->lobe_terms(&p->lobe[0], &g, n, f[0], other[0], other[1], other[2]);
        return;
    }
    p->kernels->block_shape(p, &g, n, &b);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &g, n, c, &b, f[c]);
        if (kind == LOBES) continue;
        ff_prepared lobes = *p;
        lobes.n_parts = 0;
        p->kernels->block_value(&lobes, &g, n, c, &b, other[0]);
        for (size_t i = 0; i < n; i++) f[c][i] -= other[0][i];
    }
}

/* Adds sign times value and columns of p. */
static void add_columns(integrand *k, const ff_prepared *p, const ff_geometry *g, ff_block *b, double sign)
{
    double f[FF_BLOCK], df[FF_ALBEDO_COLUMNS][FF_BLOCK];
    for (size_t c = 0; c < k->n_channels; c++) {
        p->kernels->block_value(p, g, k->n, c, b, f);
        p->kernels->block_columns(p, k->n, c, k->w, b, df);
        for (size_t i = 0; i < k->n; i++) k->sum[c] += sign * k->w[i] * f[i];
        for (size_t j = 0; j < k->n_columns; j++)
            for (size_t i = 0; i < k->n; i++) k->column_sum[c][j] += sign * df[j][i];
    }
}

static void flush_columns(integrand *k, const ff_dirs *w)
{
    const uint32_t needs = ff_prepared_planes(k->p);
    double planes[FF_G_COUNT][FF_BLOCK];
    ff_geometry g = {{NULL}};
    ff_block b;
    for (int i = 0; i < FF_G_COUNT; i++)
        if (needs & 1u << i) g.plane[i] = planes[i];
    k->p->kernels->geometry(w, k->n, &g);
    k->p->kernels->block_shape(k->p, &g, k->n, &b);
    add_columns(k, k->p, &g, &b, 1);
    if (k->kind == LOBES) return;
    ff_prepared lobes = *k->p;
    lobes.n_parts = 0;
    add_columns(k, &lobes, &g, &b, -1);
}

static void flush(integrand *k)
{
    double f[GROUP][FF_BLOCK];
    const ff_dirs w = {k->plane[0], k->plane[1], k->plane[2], k->plane[3], k->plane[4], k->plane[5]};
    if (k->n == 0) return;
    if (k->n_columns) {
        flush_columns(k, &w);
        k->n = 0;
        return;
    }
    evaluate(k->p, k->kind, &w, k->n, f);
    for (size_t c = 0; c < k->n_channels; c++)
        for (size_t i = 0; i < k->n; i++) k->sum[c] += k->w[i] * f[c][i];
    k->n = 0;
}

static void add_point(integrand *k, const double wi[3], const double wo[3], double weight)
{
    if (k->n == FF_BLOCK) flush(k);
    for (int j = 0; j < 3; ++j) {
        k->plane[j][k->n] = wi[j];
        k->plane[3 + j][k->n] = wo[j];
    }
    k->w[k->n++] = weight;
}

static vec2 ray_direction(const integrand *k, double psi)
{
    const double c = cos(psi), s = sin(psi);
    return (vec2){k->l11 * c, k->l21 * c + k->l22 * s};
}

/* L^T v: the covector of u that belongs to a covector v of s. */
static vec2 to_unit(const integrand *k, vec2 v)
{
    return (vec2){k->l11 * v.x + k->l21 * v.y, k->l22 * v.y};
}

/* G1 of the furnace integral: twice the cosine of the V-cavity's groove over V, or the constant of a Smith form. */
static double furnace_g1(const integrand *k, double v)
{
    return k->own_g1 ? fmin(1, 2 * k->o[2] / v) : k->g1;
}

/* Adds the half vector at distance q along the ray e; weight is that of dq dpsi. */
static void add_half_vector(integrand *k, vec2 e, double q, double weight)
{
    const vec2 s = {k->s0.x + q * e.x, k->s0.y + q * e.y};
    const double hz2 = 1 / (1 + dot2(s, s)), hz = sqrt(hz2), v = k->v0 - q * dot2(k->oxy, e);
    const double h[3] = {-s.x * hz, -s.y * hz, hz};
    const double w = weight * k->det * q * hz2 * hz2 * v;
    if (v <= 0) return;
    if (k->kind == FURNACE) { /* the kernel's half vector of (h, h) is h, and D knows nothing else */
        add_point(k, h, h, w * furnace_g1(k, v) / k->v0);
        return;
    }
    const double twice = 2 * v * hz; /* wi = 2 (wo.h) h - wo */
    const double wi[3] = {twice * h[0] - k->o[0], twice * h[1] - k->o[1], twice * h[2] - k->o[2]};
    if (wi[2] > 0) add_point(k, wi, k->o, 4 * w * wi[2]);
}

/* ---- places on a ray at which the integrand is not smooth ------------------------------------ */

typedef struct cuts {
    int n;
    double q[CUTS];
} cuts;

static void cut_add(cuts *c, double q, double lo, double hi)
{
    if (q > lo && q < hi && c->n < CUTS) c->q[c->n++] = q;
}

static double poly3(const double a[4], double q)
{
    return a[0] + q * (a[1] + q * (a[2] + q * a[3]));
}

/* Real roots of a2 q^2 + a1 q + a0, ascending, without cancellation; the count. */
static int quadratic_roots(double a0, double a1, double a2, double root[2])
{
    const double d = a1 * a1 - 4 * a2 * a0;
    if (a2 == 0) {
        if (a1 == 0) return 0;
        root[0] = -a0 / a1;
        return 1;
    }
    if (d < 0) return 0;
    const double t = -(a1 + copysign(sqrt(d), a1)) / 2;
    const double r0 = t / a2, r1 = t != 0 ? a0 / t : r0;
    root[0] = fmin(r0, r1);
    root[1] = fmax(r0, r1);
    return 2;
}

/* Roots of the cubic inside (lo, hi): between its turning points it is monotone. */
static void cut_roots(cuts *c, const double a[4], double lo, double hi)
{
    double turn[2], end[4] = {lo};
    int n = 1;
    const int turns = quadratic_roots(a[1], 2 * a[2], 3 * a[3], turn);
    for (int i = 0; i < turns; ++i)
        if (turn[i] > lo && turn[i] < hi) end[n++] = turn[i];
    end[n++] = hi;
    for (int i = 0; i + 1 < n; ++i) {
        double l = end[i], r = end[i + 1];
        const double fl = poly3(a, l);
        if (!(fl * poly3(a, r) < 0)) continue;
        for (int it = 0; it < 60; ++it) {
            const double mid = (l + r) / 2;
            if ((poly3(a, mid) < 0) == (fl < 0)) {
                l = mid;
            } else {
                r = mid;
            }
        }
        cut_add(c, (l + r) / 2, lo, hi);
    }
}

/* Branches of the maskings, as polynomials in q with V = v0 - b q and 1 + |s|^2 = c0 + c1 q + c2 q^2:
 *   wi.z = wo.z                 V = oz (1 + |s|^2)             the larger Lambda, the smaller term of the V-cavity
 *   2 hz oz / (o.h) = 1         V = 2 oz                       V-cavity
 *   2 hz iz / (i.h) = 1         V (4 - (1 + |s|^2)) = 2 oz (1 + |s|^2)
 *   wi in the mesosurface       2 V (1 + s.s0) = ozp (1 + |s|^2)         with a mean slope: no light from below it */
static void cut_branches(const integrand *k, vec2 e, double lo, double hi, cuts *c)
{
    const double oz = k->o[2], v = k->v0, b = dot2(k->oxy, e);
    const double c0 = 1 + dot2(k->s0, k->s0), c1 = 2 * dot2(k->s0, e), c2 = dot2(e, e);
    const double equal_z[4] = {v - oz * c0, -b - oz * c1, -oz * c2, 0};
    const double groove_o[4] = {v - 2 * oz, -b, 0, 0};
    const double d0 = 4 - c0;
    const double groove_i[4] = {v * d0 - 2 * oz * c0, -v * c1 - b * d0 - 2 * oz * c1, -v * c2 + b * c1 - 2 * oz * c2, b * c2};
    const double m0 = c0, m1 = c1 / 2; /* 1 + s.s0 */
    const double mesosurface[4] = {2 * v * m0 - v * c0, 2 * (v * m1 - b * m0) - v * c1, -2 * b * m1 - v * c2, 0};
    cut_roots(c, groove_o, lo, hi);
    if (k->kind == FURNACE) return;
    if (k->s0.x != 0 || k->s0.y != 0) cut_roots(c, mesosurface, lo, hi);
    cut_roots(c, equal_z, lo, hi);
    cut_roots(c, groove_i, lo, hi);
}

static void cuts_sort(cuts *c)
{
    for (int i = 1; i < c->n; ++i)
        for (int j = i; j > 0 && c->q[j] < c->q[j - 1]; --j) {
            const double t = c->q[j];
            c->q[j] = c->q[j - 1];
            c->q[j - 1] = t;
        }
}

/* ---- one ray --------------------------------------------------------------------------------- */

/* Gauss-Legendre panels in x = asinh(q / w) between two cuts. */
static void integrate_piece(integrand *k, const ff_gauss *g, vec2 e, double q0, double q1, double weight)
{
    const double x0 = asinh(q0 / k->width), x1 = asinh(q1 / k->width);
    const int panels = (int)ceil((x1 - x0) / panel_x);
    const double half = (x1 - x0) / (2 * panels);
    for (int p = 0; p < panels; ++p) {
        const double mid = x0 + (2 * p + 1) * half;
        for (int i = 0; i < g->n; ++i) {
            const double grown = exp(mid + half * g->x[i]), shrunk = 1 / grown, w = 0.5 * k->width;
            add_half_vector(k, e, w * (grown - shrunk), weight * half * g->w[i] * w * (grown + shrunk)); /* sinh and cosh */
        }
    }
}

/* P = D hz^4 far out, where it is a power law q^-nu or has vanished. It is the same along every ray: measured once. */
static void measure_tail(integrand *k)
{
    double d[GROUP][FF_BLOCK], plane[3][2];
    const vec2 e = ray_direction(k, 0);
    k->far = slope_far / sqrt(dot2(e, e) + k->l22 * k->l22);
    for (int i = 0; i < 2; ++i) {
        const double q = k->far * (i + 1) / 2;
        const vec2 s = {k->s0.x + q * e.x, k->s0.y + q * e.y};
        const double hz = 1 / sqrt(1 + dot2(s, s));
        plane[0][i] = -s.x * hz;
        plane[1][i] = -s.y * hz;
        plane[2][i] = hz;
    }
    const ff_dirs w = {plane[0], plane[1], plane[2], plane[0], plane[1], plane[2]};
    evaluate(k->p, FURNACE, &w, 2, d);
    const double p0 = d[0][0] * pow(plane[2][0], 4);
    k->p_far = d[0][1] * pow(plane[2][1], 4);
    k->nu = k->p_far > 0 ? log2(p0 / k->p_far) : INFINITY;
}

/* integral_0^reach e^(-k y) dy */
static double power_integral(double k, double reach)
{
    return fabs(k) > 1e-12 ? -expm1(-k * reach) / k : reach;
}

/* The furnace integral beyond far: that of q P (v0 - b q) dq with P = p_far (q / far)^-nu, from far to end. */
static double power_tail(const integrand *k, vec2 e, double end)
{
    if (!(k->p_far > 0)) return 0;
    const double far = k->far, nu = k->nu, b = dot2(k->oxy, e), v = k->v0 - b * far;
    const double reach = log(end / far), area = far * far * power_integral(nu - 2, reach),
                 moment = far * far * far * power_integral(nu - 3, reach);
    if (k->own_g1 && b < 0) return k->p_far * area * furnace_g1(k, v) * v / k->v0; /* there G1 V = 2 oz, constant */
    return k->p_far * (k->v0 * area - b * moment) * furnace_g1(k, v) / k->v0;
}

static void integrate_furnace_ray(integrand *k, const ff_gauss *g, double psi, double weight)
{
    const vec2 e = ray_direction(k, psi);
    const double b = dot2(k->oxy, e), far = k->far;
    const double end = b > 0 ? k->v0 / b : INFINITY; /* V = 0 */
    cuts c = {1, {0}};
    cut_branches(k, e, 0, fmin(end, far), &c);
    c.q[c.n++] = fmin(end, far);
    cuts_sort(&c);
    for (int i = 0; i + 1 < c.n; ++i) integrate_piece(k, g, e, c.q[i], c.q[i + 1], weight);
    if (end > far) k->sum[0] += weight * k->det * power_tail(k, e, end);
}

/* wi is above the horizon inside a disc of slopes about -t, t = tan(theta_o) towards o: |s + t|^2 < 1 / oz^2. */
static void integrate_albedo_ray(integrand *k, const ff_gauss *g, double psi, double weight)
{
    const vec2 e = ray_direction(k, psi), t = {k->oxy.x / k->o[2], k->oxy.y / k->o[2]};
    const vec2 from = {k->s0.x + t.x, k->s0.y + t.y};
    double root[2];
    const double inside = dot2(k->s0, k->s0) + 2 * dot2(k->s0, t) - 1; /* < 0 where s0 lies in the disc */
    if (quadratic_roots(inside, 2 * dot2(e, from), dot2(e, e), root) < 2 || root[1] <= 0) return;
    const double lo = fmax(root[0], 0), hi = root[1];
    cuts c = {1, {lo}};
    cut_branches(k, e, lo, hi, &c);
    c.q[c.n++] = hi;
    cuts_sort(&c);
    for (int i = 0; i + 1 < c.n; ++i) integrate_piece(k, g, e, c.q[i], c.q[i + 1], weight);
}

/* ---- all rays -------------------------------------------------------------------------------- */

typedef struct centres {
    int n, levels; /* panels halve this often towards a centre */
    double psi[CENTRES];
} centres;

static void centre_add_line(centres *c, double psi)
{
    for (int i = 0; i < 2; ++i) {
        const double turn = fmod(psi + i * PI, 2 * PI);
        if (c->n < CENTRES) c->psi[c->n++] = turn < 0 ? turn + 2 * PI : turn;
    }
}

/* Lines where (u . a)^2 = level u^T L^T L u: the rays that touch the disc when they start outside. */
static void centre_add_tangents(const integrand *k, centres *c, vec2 a, double level)
{
    const double m00 = a.x * a.x - level * (k->l11 * k->l11 + k->l21 * k->l21);
    const double m01 = a.x * a.y - level * k->l21 * k->l22, m11 = a.y * a.y - level * k->l22 * k->l22;
    double root[2]; /* tan psi */
    const int n = quadratic_roots(m00, 2 * m01, m11, root);
    for (int i = 0; i < n; ++i) centre_add_line(c, atan(root[i]));
}

/* psi of the ray whose slopes point along d. */
static double psi_towards(const integrand *k, vec2 d)
{
    return atan2((k->l11 * d.y - k->l21 * d.x) / k->l22, d.x);
}

static int has_cavities(const integrand *k)
{
    return (k->p->kernels->masking[k->p->lobe[0].masking]->planes & 1u << FF_G_VCAVITY) != 0;
}

/* The branches of the V-cavity change their order where the view, projected to the plane of the ray, is 45 degrees from the normal:
 * tan(theta_o) cos(phi) = 1. */
static void centre_add_cavity(const integrand *k, centres *c, double tangent)
{
    if (tangent <= 1) return;
    const double cosine = 1 / tangent, sine = sqrt((1 - cosine) * (1 + cosine));
    for (int side = -1; side <= 1; side += 2)
        centre_add_line(
            c, psi_towards(k, (vec2){cosine * k->oxy.x - side * sine * k->oxy.y, cosine * k->oxy.y + side * sine * k->oxy.x}));
}

static void find_centres(const integrand *k, centres *c)
{
    const double m00 = k->l11 * k->l11 + k->l21 * k->l21, m01 = k->l21 * k->l22, m11 = k->l22 * k->l22; /* L^T L */
    const double spread = hypot((m00 - m11) / 2, m01), major2 = (m00 + m11) / 2 + spread;
    const double aspect = fmax(1, major2 / k->det); /* a1 / a2 */
    const vec2 t = {k->oxy.x / k->o[2], k->oxy.y / k->o[2]}, from = {k->s0.x + t.x, k->s0.y + t.y};
    const vec2 view = to_unit(k, k->oxy), disc = to_unit(k, from);
    double sharpness = 1 + (k->kind == FURNACE ? hypot(view.x, view.y) / k->v0 : hypot(t.x, t.y) * aspect);
    c->n = 0;
    /* where V stops to shrink along the ray, where the way to the horizon turns from short to long */
    centre_add_line(c, atan2(view.y, view.x) + PI / 2);
    if (k->kind != FURNACE) {
        const double inside = dot2(k->s0, k->s0) + 2 * dot2(k->s0, t) - 1;
        if (k->s0.x != 0 || k->s0.y != 0) centre_add_line(c, atan2(disc.y, disc.x) + PI / 2);
        centre_add_line(c, psi_towards(k, k->oxy));                                   /* plane of incidence: phi_i = phi_o */
        if (aspect > 1.5) centre_add_line(c, atan2(2 * m01, m00 - m11) / 2 + PI / 2); /* the short axis      */
        if (has_cavities(k)) centre_add_cavity(k, c, hypot(t.x, t.y));
        if (inside >= 0) {
            centre_add_tangents(k, c, disc, inside);
            sharpness *= 256; /* square roots end there */
        }
        sharpness *= aspect;
    }
    c->levels = (int)fmin(16, 2 + ceil(log2(sharpness)));
    for (int i = 1; i < c->n; ++i)
        for (int j = i; j > 0 && c->psi[j] < c->psi[j - 1]; --j) {
            const double swap = c->psi[j];
            c->psi[j] = c->psi[j - 1];
            c->psi[j - 1] = swap;
        }
}

static void integrate_panel(integrand *k, const ff_gauss *g, double a, double b)
{
    const double mid = (a + b) / 2, half = (b - a) / 2;
    for (int i = 0; i < g->n; ++i) {
        const double psi = mid + half * g->x[i], weight = fabs(half) * g->w[i];
        if (k->kind == FURNACE) {
            integrate_furnace_ray(k, g, psi, weight);
        } else {
            integrate_albedo_ray(k, g, psi, weight);
        }
    }
}

/* From a centre to the middle between it and the next, in panels that halve towards the centre. */
static void integrate_half_arc(integrand *k, const ff_gauss *g, double centre, double middle, int levels)
{
    double outer = 1;
    for (int l = 0; l < levels; ++l) {
        const double inner = l + 1 < levels ? outer / 2 : 0;
        integrate_panel(k, g, centre + (middle - centre) * inner, centre + (middle - centre) * outer);
        outer = inner;
    }
}

static void integrate_circle(integrand *k, const ff_gauss *g, const centres *c)
{
    for (int i = 0; i < c->n; ++i) {
        const double a = c->psi[i], b = i + 1 < c->n ? c->psi[i + 1] : c->psi[0] + 2 * PI;
        if (b - a < 1e-12) continue;
        integrate_half_arc(k, g, a, (a + b) / 2, c->levels);
        integrate_half_arc(k, g, b, (a + b) / 2, c->levels);
    }
}

/* The bases are smooth over the hemisphere of wi, but for kinks where wi.z = wo.z and at right azimuths; those that are coupled to
 * narrow lobes change fast near grazing light. wi.z = x^3. */
static void integrate_hemisphere(integrand *k, const ff_gauss *g)
{
    double edge[] = {0, 0.1, 0.2, 0.35, 0.55, 0.8, 1, cbrt(k->o[2])};
    enum { EDGES = sizeof edge / sizeof edge[0] };
    const double towards = atan2(k->o[1], k->o[0]);
    for (int i = EDGES - 1; i > 0 && edge[i] < edge[i - 1]; --i) {
        const double swap = edge[i];
        edge[i] = edge[i - 1];
        edge[i - 1] = swap;
    }
    for (int panel = 0; panel + 1 < EDGES; ++panel)
        for (int i = 0; i < g->n; ++i) {
            const double half = (edge[panel + 1] - edge[panel]) / 2, x = edge[panel] + half * (1 + g->x[i]);
            const double z = x * x * x, r = sqrt((1 - z) * (1 + z)), weight = half * g->w[i] * 3 * x * x * z;
            for (int j = 0; j < 4 * g->n; ++j) {
                const double phi = towards + PI / 4 * (2 * (j / g->n) + 1 + g->x[j % g->n]);
                add_point(k, (const double[]){r * cos(phi), r * sin(phi), z}, k->o, weight * PI / 4 * g->w[j % g->n]);
            }
        }
}

/* With one order: k->sum and the columns. */
static void integrate_order(integrand *k, int order)
{
    centres c = {0, 0, {0}};
    ff_gauss g;
    ff_gauss_make(order, &g);
    memset(k->sum, 0, sizeof k->sum);
    if (k->n_columns) memset(k->column_sum, 0, sizeof k->column_sum);
    if (k->kind == BASES) {
        integrate_hemisphere(k, &g);
    } else {
        find_centres(k, &c);
        integrate_circle(k, &g, &c);
    }
    flush(k);
}

/* Doubles the order until two agree. */
static void integrate(integrand *k, ff_integral out[GROUP])
{
    double before[GROUP] = {0}, worst = INFINITY;
    for (int order = ORDER_FIRST; order <= ORDER_LAST && !(worst < tolerance); order *= 2) {
        integrate_order(k, order);
        worst = order > ORDER_FIRST ? 0 : INFINITY;
        for (size_t i = 0; i < k->n_channels; ++i) {
            out[i] = (ff_integral){k->sum[i], fabs(k->sum[i] - before[i])};
            before[i] = k->sum[i];
            worst = fmax(worst, out[i].error);
        }
    }
}

/* ---- parts of a model ------------------------------------------------------------------------ */

/* Where the profile first leaves [p(0)/4, 4 p(0)]: its narrowest feature. */
static double profile_width(const ff_prepared *p)
{
    const ff_lobe_pass *lobe = &p->lobe[0];
    double q[FF_BLOCK], q2[FF_BLOCK], value[FF_BLOCK], slope[FF_BLOCK];
    for (int i = 0; i < FF_BLOCK; ++i) {
        q[i] = 1e-6 * exp2(0.25 * i); /* to 3e3 */
        q2[i] = q[i] * q[i];
    }
    p->kernels->ndf[lobe->ndf]->profile(&lobe->ndf_pass, FF_BLOCK, q2, value, slope, NULL);
    for (int i = 1; i < FF_BLOCK; ++i)
        if (!(value[i] > 0.25 * value[0] && value[i] < 4 * value[0])) return q[i];
    return 1;
}

static void integrand_make(integral_kind kind, const ff_prepared *p, const double wo[3], integrand *k)
{
    *k = (integrand){.kind = kind,
                     .p = p,
                     .n_channels = p->n_channels,
                     .oxy = {wo[0], wo[1]},
                     .g1 = 1,
                     .n_columns = p->wanted.n_shape + p->wanted.n_channel};
    memcpy(k->o, wo, sizeof k->o);
    if (kind == BASES) return;
    const ff_stretch s = p->lobe[0].s;
    k->l11 = s.ax;
    k->l21 = s.r * s.ay;
    k->l22 = s.ay * sqrt((1 - s.r) * (1 + s.r));
    k->det = k->l11 * k->l22;
    k->s0 = (vec2){s.x0, s.y0};
    k->v0 = wo[2] - dot2(k->oxy, k->s0);
    k->width = profile_width(p);
}

static ff_status part_make(const ff_model *m, uint32_t lobe, const ff_kernels *kernels, size_t n_channels, const double *shape,
                           const double *channel, part *p)
{
    p->n_channels = n_channels;
    ff_model_lobe_alone(m, lobe, n_channels, shape, channel, &p->model, p->shape, p->channel);
    return ff_prepare(&p->model, kernels, FF_CHEAPEST_MODE, n_channels, p->shape, p->channel, NULL, 0, INFINITY, &p->prepared);
}

static ff_status check_view(const double wo[3], ff_isa isa, ff_error *err)
{
    const double norm = sqrt(wo[0] * wo[0] + wo[1] * wo[1] + wo[2] * wo[2]);
    if (!(fabs(norm - 1) < 1e-9))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the view has length %g, expected a unit vector", norm);
    if (!(wo[2] > FF_COS_MIN))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the view has cosine %g, expected one above the horizon", wo[2]);
    if (!ff_isa_available(isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(isa));
    return FF_OK;
}

static ff_status out_of_memory(ff_error *err)
{
    return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the tables of the model");
}

/* ---- albedo ---------------------------------------------------------------------------------- */

static ff_status add_lobe(const ff_model *m, uint32_t lobe, const ff_kernels *kernels, size_t n, const double *shape,
                          const double *channel, const double wo[3], ff_integral total[GROUP])
{
    part p;
    integrand k;
    ff_integral one[GROUP];
    double weight[FF_MAX_LOBES];
    const ff_status status = part_make(m, lobe, kernels, n, shape, channel, &p);
    if (status != FF_OK) return status;
    ff_model_weights(m, shape, weight, NULL);
    integrand_make(LOBES, &p.prepared, wo, &k);
    integrate(&k, one);
    ff_prepared_free(&p.prepared);
    for (size_t c = 0; c < n; ++c) {
        total[c].value += weight[lobe] * one[c].value;
        total[c].error += weight[lobe] * one[c].error;
    }
    return FF_OK;
}

static ff_status add_bases(const ff_model *m, const ff_kernels *kernels, size_t n, const double *shape, const double *channel,
                           const double wo[3], ff_integral total[GROUP])
{
    ff_prepared p;
    integrand k;
    ff_integral one[GROUP];
    const ff_status status = ff_prepare(m, kernels, FF_CHEAPEST_MODE, n, shape, channel, NULL, 0, INFINITY, &p);
    if (status != FF_OK) return status;
    integrand_make(BASES, &p, wo, &k);
    integrate(&k, one);
    ff_prepared_free(&p);
    for (size_t c = 0; c < n; ++c) {
        total[c].value += one[c].value;
        total[c].error += one[c].error;
    }
    return FF_OK;
}

ff_status ff_albedo_directional(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                const double wo[3], ff_integral *out, ff_error *err)
{
    ff_status status = ff_model_check(m, n_channels, shape, channel, err);
    if (status == FF_OK) status = check_view(wo, isa, err);
    if (status != FF_OK) return status;
    const ff_kernels *kernels = ff_kernels_get(isa);
    for (size_t first = 0; first < n_channels; first += GROUP) {
        const size_t n = n_channels - first < GROUP ? n_channels - first : GROUP;
        const double *group = channel + first * m->n_channel;
        ff_integral total[GROUP] = {{0, 0}};
        for (uint32_t l = 0; l < m->n_lobes && status == FF_OK; ++l) status = add_lobe(m, l, kernels, n, shape, group, wo, total);
        if (m->n_bases && status == FF_OK) status = add_bases(m, kernels, n, shape, group, wo, total);
        if (status != FF_OK) return out_of_memory(err);
        memcpy(out + first, total, n * sizeof *out);
    }
    return FF_OK;
}

/* ---- albedo with its derivatives ------------------------------------------------------------- */

/* One group of channels. What is made ready points into `lobe` and to the caller's channels. */
typedef struct channel_group {
    size_t n;
    part lobe[FF_MAX_LOBES];
    ff_prepared whole; /* where there are bases */
} channel_group;

struct ff_albedo_parts {
    const ff_model *m;
    ff_wanted wanted;
    size_t n_channels, n_groups;
    double weight[FF_MAX_LOBES], dw[FF_MAX_LOBES][FF_MAX_LOBES];
    size_t column[FF_MAX_LOBES][FF_ALBEDO_COLUMNS]; /* of the model, by that of the lobe alone */
    channel_group group[];
};

/* The columns of the model that lobe l has by itself, and which they are. */
static ff_wanted columns_of_lobe(const ff_model *m, const ff_model *alone, uint32_t l, const ff_wanted *all, size_t *column)
{
    const ff_lobe *lobe = &m->lobe[l], *group = &m->lobe[ff_model_group(m, l)];
    ff_wanted w = {.n_shape = 0};
    for (uint32_t k = 0; k < all->n_shape; k++) {
        const uint32_t at = all->shape[k] - lobe->shape0;
        if (m->shape[all->shape[k]].lobe != l || at >= alone->n_shape) continue; /* the last may be the weight */
        column[w.n_shape] = k;
        w.tied[w.n_shape] = all->tied[k];
        w.shape[w.n_shape++] = at;
    }
    for (uint32_t k = 0; k < all->n_channel; k++) {
        if (m->channel[all->channel[k]].lobe != ff_model_group(m, l)) continue;
        column[w.n_shape + w.n_channel] = all->n_shape + k;
        w.channel[w.n_channel++] = all->channel[k] - group->channel0;
    }
    return w;
}

ff_status ff_albedo_parts_make(const ff_model *m, const ff_kernels *kernels, ff_stretch_mode mode, size_t n_channels,
                               const double *shape, const double *channel, const ff_wanted *wanted, ff_albedo_parts **out)
{
    const size_t n_groups = (n_channels + GROUP - 1) / GROUP;
    ff_albedo_parts *a = calloc(1, sizeof *a + n_groups * sizeof *a->group);
    ff_status status = a ? FF_OK : FF_ERR_MEMORY;
    if (a) *a = (ff_albedo_parts){.m = m, .wanted = *wanted, .n_channels = n_channels, .n_groups = n_groups};
    if (a) ff_model_weights(m, shape, a->weight, a->dw);
    for (size_t g = 0; g < n_groups && status == FF_OK; g++) {
        channel_group *group = &a->group[g];
        const double *of_group = channel + g * GROUP * m->n_channel;
        group->n = n_channels - g * GROUP < GROUP ? n_channels - g * GROUP : GROUP;
        for (uint32_t l = 0; l < m->n_lobes && status == FF_OK; l++) {
            part *p = &group->lobe[l];
            ff_model_lobe_alone(m, l, group->n, shape, of_group, &p->model, p->shape, p->channel);
            const ff_wanted own = columns_of_lobe(m, &p->model, l, wanted, a->column[l]);
            status = ff_prepare(&p->model, kernels, mode, group->n, p->shape, p->channel, &own, 0, INFINITY, &p->prepared);
        }
        if (m->n_bases && status == FF_OK)
            status = ff_prepare(m, kernels, mode, group->n, shape, of_group, wanted, 0, INFINITY, &group->whole);
    }
    if (status != FF_OK) {
        ff_albedo_parts_free(a);
        return status;
    }
    *out = a;
    return FF_OK;
}

void ff_albedo_parts_free(ff_albedo_parts *a)
{
    if (!a) return;
    for (size_t g = 0; g < a->n_groups; g++) {
        for (uint32_t l = 0; l < a->m->n_lobes; l++) ff_prepared_free(&a->group[g].lobe[l].prepared);
        ff_prepared_free(&a->group[g].whole);
    }
    free(a);
}

/* Adds lobe l, times its weight, and what the weights change. */
static void add_lobe_columns(const ff_albedo_parts *a, uint32_t l, const integrand *k, size_t c, double *out)
{
    out[0] += a->weight[l] * k->sum[c];
    for (size_t j = 0; j < k->n_columns; j++) out[1 + a->column[l][j]] += a->weight[l] * k->column_sum[c][j];
    for (uint32_t j = 0; j < a->wanted.n_shape; j++) {
        const uint32_t at = a->wanted.shape[j], other = a->m->shape[at].lobe;
        if (other >= a->m->n_lobes || a->m->lobe[other].fresnel != FF_FRESNEL_SHARED) continue;
        if (at + 1 == a->m->lobe[other].shape0 + a->m->lobe[other].n_shape) out[1 + j] += a->dw[other][l] * k->sum[c];
    }
}

void ff_albedo_parts_at(const ff_albedo_parts *a, int order, const double wo[3], double *out)
{
    const size_t stride = 1 + a->wanted.n_shape + a->wanted.n_channel;
    integrand k;
    memset(out, 0, a->n_channels * stride * sizeof *out);
    for (size_t g = 0; g < a->n_groups; g++) {
        const channel_group *group = &a->group[g];
        double *of_group = out + g * GROUP * stride;
        for (uint32_t l = 0; l < a->m->n_lobes; l++) {
            integrand_make(LOBES, &group->lobe[l].prepared, wo, &k);
            integrate_order(&k, order);
            for (size_t c = 0; c < group->n; c++) add_lobe_columns(a, l, &k, c, of_group + c * stride);
        }
        if (a->m->n_bases == 0) continue;
        integrand_make(BASES, &group->whole, wo, &k);
        integrate_order(&k, order);
        for (size_t c = 0; c < group->n; c++) {
            of_group[c * stride] += k.sum[c];
            for (size_t j = 0; j < k.n_columns; j++) of_group[c * stride + 1 + j] += k.column_sum[c][j];
        }
    }
}

/* ---- weak white furnace ---------------------------------------------------------------------- */

/* G1(wo) of a form that is a function of wi and wo alone: its G2 with the light at the normal, where nothing is in shadow. */
static double g1_of(const part *p, const double wo[3])
{
    static const double none = 0, up = 1;
    double f[GROUP][FF_BLOCK], lambda[2][FF_BLOCK], g2[FF_BLOCK], planes[FF_G_COUNT][1];
    const ff_dirs w = {&none, &none, &up, &wo[0], &wo[1], &wo[2]};
    ff_geometry g = {{NULL}};
    for (int k = 0; k < FF_G_COUNT; ++k) g.plane[k] = planes[k];
    p->prepared.kernels->geometry(&w, 1, &g);
    p->prepared.kernels->lobe_terms(&p->prepared.lobe[0], &g, 1, f[0], lambda[0], lambda[1], g2);
    return g2[0];
}

/* Is there a G1 of this masking, and does it depend on the facet? */
static ff_status check_g1(const ff_masking *masking, int *own, ff_error *err)
{
    *own = (masking->planes & 1u << FF_G_VCAVITY) != 0;
    if (*own || masking->uses_lambda || masking->uses_alpha || !masking->planes) return FF_OK;
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                        "%s is a factor of both directions together: there is no masking of one to test", masking->term.name);
}

ff_status ff_albedo_weak_furnace(const ff_model *m, ff_isa isa, const double *shape, uint32_t lobe, const double wo[3],
                                 ff_integral *out, ff_error *err)
{
    double channel[FF_MAX_CHANNEL_PARAMS];
    part p;
    integrand k;
    ff_integral result[GROUP];
    int own_g1 = 0;
    ff_model_defaults(m, 1, NULL, channel);
    ff_status status = ff_model_check(m, 1, shape, channel, err);
    if (status == FF_OK) status = check_view(wo, isa, err);
    if (status != FF_OK) return status;
    if (lobe >= m->n_lobes)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has %u lobes, the furnace test asks for lobe %u",
                            m->n_lobes, lobe + 1);
    status = check_g1(ff_masking_at(m->lobe[lobe].masking), &own_g1, err);
    if (status != FF_OK) return status;
    if (part_make(m, lobe, ff_kernels_get(isa), 1, shape, channel, &p) != FF_OK) return out_of_memory(err);
    p.prepared.lobe[0].mode = FF_TILTED_MODE; /* the one that has D by itself */
    integrand_make(FURNACE, &p.prepared, wo, &k);
    if (!(k.v0 > 0)) {
        ff_prepared_free(&p.prepared);
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "the mean slope turns the surface away from the view (projected cosine %g)", k.v0);
    }
    k.own_g1 = own_g1;
    k.g1 = own_g1 ? 1 : g1_of(&p, wo);
    measure_tail(&k);
    if (!own_g1 && k.nu < nu_least)
        result[0] = (ff_integral){INFINITY, 0};
    else
        integrate(&k, result);
    ff_prepared_free(&p.prepared);
    *out = result[0];
    return FF_OK;
}

int ff_albedo_weak_furnace_claimed(const ff_model *m, uint32_t lobe)
{
    const uint32_t ndf = ff_ndf_at(m->lobe[lobe].ndf)->term.claims;
    const ff_masking *masking = ff_masking_at(m->lobe[lobe].masking);
    if (masking->uses_lambda) return (ndf & FF_WEAK_FURNACE) != 0;
    return (masking->term.claims & FF_WEAK_FURNACE) && (ndf & FF_UNIT_AREA);
}
