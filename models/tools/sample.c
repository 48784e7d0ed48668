/* Directions drawn in proportion to a model; the strategies are listed in ff_sample.h.
 *
 *   s = s0 + L u       slope of the normal h, L L^T = [[ax^2, r ax ay], [r ax ay, ay^2]]; the density of u is p(|u|^2)
 *   V = wo.h / h.z = v0 - l.u,    v0 = wo.z - wo.s0,  l = L^T wo: what a unit surface without mean slope shows to the view (l, v0)
 *   dwi = 4 (wo.h) dh,  dh = h.z^3 ds
 *
 *   visible normals    density of u: p V+ / N,  N = integral of p V+ = v0 (1 + Lambda);  of wi: D / (4 N)
 *   normals            density of u: p,                                                  of wi: D h.z / (4 wo.h)
 *   normals, no unit area    density of u: p / h.z over its integral,                    of wi: D / (4 wo.h), likewise
 *
 * Shear and stretch carry the visible normals of any ellipse and mean slope over to those of the unit surface seen from (l, v0).
 * There ggx is the uniform hemisphere, whose mirror images of a view fill a cap of the sphere evenly (Dupuy and Benyoub 2023; the
 * normals are those of Heitz 2018), and beckmann has Gaussian slopes: independent across the view, and along it of density
 * (a + x)+ exp(-x^2), a = v0 / |l| (Heitz and d'Eon 2014), whose integral is inverted here by Halley's iteration. */
#define FF_ISA_SUFFIX scalar
#include "ff_sample.h"
#include "models/internal_model.h"
#include "models/terms/internal_isotropic.h"
#include <stdlib.h>

enum {
    COMPONENTS = FF_MAX_LOBES + FF_MAX_PARTS,
    VIEWS = 17,  /* nodes of the albedo tables, at mu = (j / (VIEWS - 1))^2        */
    MATTE = 65,  /* nodes of the matte tables, at mu = (j / (MATTE - 1))^2         */
    DEEPEST = 30 /* halvings of a panel of the radial table                       */
};
static const double least_share = 0.01;
static const double tolerance = 1e-11; /* of the radial table, in probability */

/* ---- the unit surface: radial tables --------------------------------------------------------- */

/* The mass inside q2 = e^y with its first two derivatives by y. */
typedef struct node {
    double y, mass, slope, curve;
} node;

/* The cumulative mass of a radial density w(q2) of u: quintic between its nodes, w constant below the first, q2 w a power law
 * beyond the last. */
typedef struct radial {
    node *node;
    size_t n, room;
    double middle; /* pi w(0)                 */
    double total, fall;
} radial;

typedef enum strategy { VISIBLE_GGX, VISIBLE_GAUSSIAN, NORMALS, MATTE_TABLE, COSINE } strategy;

/* What draws and what it draws for: lobe `at`, or part `at - n_lobes`. */
typedef struct component {
    strategy kind;
    const ff_ndf *ndf; /* of a lobe, else NULL */
    const ff_lobe_pass *pass;
    double l11, l21, l22;
    int unit_area;
    double (*quantile)(const ff_ndf_pass *pass, double u); /* q2 of NORMALS; NULL: by the table    */
    radial radial;
    double rest[MATTE], below[MATTE]; /* MATTE_TABLE: a density of mu^2, and its integral up to a node */
    double albedo[VIEWS];
} component;

/* w(q2) = p, or p / h.z for a density that covers no unit area, and d ln w / d q2. n <= FF_BLOCK. */
static void radial_density(const component *k, size_t n, const double *q2, double *w, double *dlnw)
{
    k->ndf->profile(&k->pass->ndf_pass, n, q2, w, dlnw, NULL);
    const double a2 = k->pass->s.ax * k->pass->s.ax;
    for (size_t i = 0; i < n && !k->unit_area; i++) {
        w[i] *= sqrt(1 + a2 * q2[i]);
        dlnw[i] += 0.5 * a2 / (1 + a2 * q2[i]);
    }
}

/* The mass between y0 and y1: integral pi q2 w dy. */
static double radial_mass(const component *k, double y0, double y1)
{
    double q2[FF_GAUSS], weight[FF_GAUSS], w[FF_GAUSS], dlnw[FF_GAUSS], sum = 0;
    ff_gauss_panels(y0, y1, 1, q2, weight);
    for (int i = 0; i < FF_GAUSS; i++) q2[i] = exp(q2[i]);
    radial_density(k, FF_GAUSS, q2, w, dlnw);
    for (int i = 0; i < FF_GAUSS; i++) sum += weight[i] * FF_PI * q2[i] * w[i];
    return sum;
}

static node node_at(const component *k, double y, double mass)
{
    const double q2 = exp(y);
    double w, dlnw;
    radial_density(k, 1, &q2, &w, &dlnw);
    const double slope = FF_PI * q2 * w;
    return (node){y, mass, slope, slope * (1 + q2 * dlnw)};
}

/* The polynomial of degree 5 in t = (y - a.y) / (b.y - a.y) with the mass and its derivatives at both nodes. */
static void quintic(const node *a, const node *b, double c[6])
{
    const double h = b->y - a->y, rise = b->mass - a->mass;
    const double d0 = h * a->slope, d1 = h * b->slope, dd0 = h * h * a->curve, dd1 = h * h * b->curve;
    c[0] = a->mass;
    c[1] = d0;
    c[2] = 0.5 * dd0;
    c[3] = 10 * rise - 6 * d0 - 4 * d1 - 1.5 * dd0 + 0.5 * dd1;
    c[4] = -15 * rise + 8 * d0 + 7 * d1 + 1.5 * dd0 - dd1;
    c[5] = 6 * rise - 3 * (d0 + d1) - 0.5 * (dd0 - dd1);
}

static double quintic_at(const double c[6], double t)
{
    return ((((c[5] * t + c[4]) * t + c[3]) * t + c[2]) * t + c[1]) * t + c[0];
}

static double quintic_slope(const double c[6], double t)
{
    return (((5 * c[5] * t + 4 * c[4]) * t + 3 * c[3]) * t + 2 * c[2]) * t + c[1];
}

static ff_status radial_push(radial *r, node x)
{
    if (r->n == r->room) {
        const size_t room = r->room ? 2 * r->room : 256;
        node *more = realloc(r->node, room * sizeof *more);
        if (!more) return FF_ERR_MEMORY;
        r->node = more;
        r->room = room;
    }
    r->node[r->n++] = x;
    return FF_OK;
}

/* Continues the table from its last node to y; whole: the mass between them. Halves until quadrature and polynomial agree. */
static ff_status radial_extend(component *k, double y, double whole, int depth)
{
    const node a = k->radial.node[k->radial.n - 1];
    const double middle = 0.5 * (a.y + y), left = radial_mass(k, a.y, middle), right = radial_mass(k, middle, y);
    const node b = node_at(k, y, a.mass + left + right);
    double c[6];
    quintic(&a, &b, c);
    const double error = fmax(fabs(left + right - whole), fabs(quintic_at(c, 0.5) - (a.mass + left)));
    if (depth == 0 || !(error >= tolerance)) return radial_push(&k->radial, b);
    const ff_status s = radial_extend(k, middle, left, depth - 1);
    return s ? s : radial_extend(k, y, right, depth - 1);
}

/* Does no more than `nothing` lie beyond the last node? What falls as a power law there holds slope^2 / -curve. */
static int radial_ends(const radial *r, double nothing)
{
    const node last = r->node[r->n - 1];
    if (!(last.slope > 0)) return last.mass > 0.5;
    return last.curve < 0 && last.slope * last.slope < -last.curve * nothing * last.mass;
}

/* From where 1e-14 of the mass lies inside to where that is left outside. */
static ff_status radial_make(component *k)
{
    const double nothing = 1e-14, zero = 0, far = 680; /* q2 = e^680 */
    radial *r = &k->radial;
    double w, dlnw;
    radial_density(k, 1, &zero, &w, &dlnw);
    r->middle = FF_PI * w;
    double y = log(nothing / r->middle);
    ff_status s = radial_push(r, node_at(k, y, nothing));
    for (; !s && y < far && !radial_ends(r, nothing); y += 1) s = radial_extend(k, y + 1, radial_mass(k, y, y + 1), DEEPEST);
    if (s) return s;
    const node last = r->node[r->n - 1];
    r->fall = last.slope > 0 ? -last.curve / last.slope : INFINITY;
    r->total = last.mass + (r->fall > 0 ? last.slope / r->fall : 0);
    return FF_OK;
}

/* Newton's iteration inside the panel a, b, by bisection where it would leave the bracket. */
static double radial_inside(const node *a, const node *b, double mass)
{
    double c[6], lo = 0, hi = 1, t = (mass - a->mass) / (b->mass - a->mass);
    quintic(a, b, c);
    for (int i = 0; i < 60; i++) {
        const double error = quintic_at(c, t) - mass;
        if (error > 0)
            hi = t;
        else
            lo = t;
        const double step = error / quintic_slope(c, t), next = t - step;
        if (fabs(step) < 1e-14) break;
        t = next >= lo && next <= hi ? next : 0.5 * (lo + hi);
    }
    return a->y + t * (b->y - a->y);
}

/* q2 with the fraction u of the mass inside. */
static double radial_quantile(const radial *r, double u)
{
    const double mass = u * r->total;
    const node *first = r->node, *last = r->node + r->n - 1;
    if (mass <= first->mass) return mass / r->middle;
    if (mass >= last->mass) {
        const double outside = r->total - last->mass, left = r->total - mass;
        return outside > 0 && left > 0 ? exp(fmin(last->y + log(outside / left) / r->fall, 200)) : exp(last->y);
    }
    size_t lo = 0, hi = r->n - 1;
    while (hi - lo > 1) {
        const size_t middle = (lo + hi) / 2;
        if (r->node[middle].mass <= mass)
            lo = middle;
        else
            hi = middle;
    }
    return exp(radial_inside(&r->node[lo], &r->node[hi], mass));
}

/* ---- the unit surface: closed forms ---------------------------------------------------------- */

/* 1 - (1 + q2/nu)^-nu = u */
static double student_t_quantile(const ff_ndf_pass *pass, double u)
{
    const double nu = pass->own[0] - 1;
    return nu * expm1(-log1p(-u) / nu);
}

/* Mikkelsen 2009, eq. 31, for mz in [0, 1]: with low = 1 - mz, (1 - e^(-kappa low)) / (1 - e^-kappa) = u. The source's ln(t e^kappa
 * + ...) overflows. */
static double vmf_quantile(const ff_ndf_pass *pass, double u)
{
    const double kappa = pass->own[0], low = -log1p(u * expm1(-kappa)) / kappa;
    return low * (2 - low) / ((1 - low) * (1 - low));
}

/* Kelemen and Szirmay-Kalos 2001, section 2.1.2: tan = m sqrt(-ln(1 - u)) */
static double kelemen_ward_quantile(const ff_ndf_pass *pass, double u)
{
    return -log1p(-u) * pass->own[0] * pass->own[0];
}

/* The same section: mz = (1 - u)^(1 / (n + 1)) */
static double kelemen_phong_quantile(const ff_ndf_pass *pass, double u)
{
    return expm1(-2 * log1p(-u) / (pass->own[0] + 1));
}

static const struct {
    const char *ndf;
    strategy kind;
    double (*quantile)(const ff_ndf_pass *pass, double u);
} known[] = {
    {"ggx", VISIBLE_GGX, NULL},
    {"beckmann", VISIBLE_GAUSSIAN, NULL},
    {"beckmann-walter", VISIBLE_GAUSSIAN, NULL},
    {"student-t", NORMALS, student_t_quantile},
    {"phong", NORMALS, student_t_quantile},
    {"phong-walter", NORMALS, student_t_quantile},
    {"vmf", NORMALS, vmf_quantile},
    {"kelemen-ward", NORMALS, kelemen_ward_quantile},
    {"kelemen-phong", NORMALS, kelemen_phong_quantile},
};

/* ---- the unit surface: visible Gaussian slopes ----------------------------------------------- */

/* The slopes along the view have the density (a + x)+ e^(-x^2); as weights of 1 and x, so that a may be infinite. */
typedef struct gaussian_view {
    double one, x, lowest; /* a / (a + 1), 1 / (a + 1), -a */
} gaussian_view;

static gaussian_view gaussian_view_of(double length, double v0)
{
    const double sum = length + v0;
    return (gaussian_view){v0 / sum, length / sum, length > 0 ? -v0 / length : -INFINITY};
}

/* integral_x^inf (one + x z) e^(-z^2) dz, and e^(-x^2) */
static double gaussian_beyond(const gaussian_view *g, double x, double *e)
{
    *e = exp(-x * x);
    return 0.5 * (FF_SQRT_PI * g->one * erfc(x) + g->x * *e);
}

/* Integral of all of it: N of the head's text is (|l| + v0) / sqrt(pi) times this. */
static double gaussian_mass(const gaussian_view *g)
{
    double e;
    return gaussian_beyond(g, g->lowest, &e);
}

/* Beyond +-6.2 lies less than a double can tell from 0 or 1. It begins at the quantiles of the two parts (Abramowitz and Stegun,
 * 26.2.23, and that of x e^(-x^2)), weighted as they are, and triples its digits with each step. */
static double gaussian_quantile(const gaussian_view *g, double u)
{
    const double enough = 3e-4;
    const double above = (1 - u) * gaussian_mass(g), tail = u < 0.5 ? u : 1 - u, t = sqrt(-2 * log(tail > 1e-17 ? tail : 1e-17));
    const double top = 2.515517 + t * (0.802853 + t * 0.010328), bottom = 1 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    const double normal = copysign((t - top / bottom) * 0.70710678118654752, u - 0.5);
    double lo = fmax(g->lowest, -6.2), hi = 6.2, x = g->one * normal + g->x * sqrt(-log1p(-u));
    if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
    for (int i = 0; i < 60; i++) {
        double e;
        const double error = gaussian_beyond(g, x, &e) - above, density = g->one + g->x * x;
        if (error > 0)
            lo = x;
        else
            hi = x;
        const double newton = error / (density * e), bend = g->x / density - 2 * x;
        const double next = x + newton / (1 + 0.5 * newton * bend), before = x;
        x = next >= lo && next <= hi ? next : 0.5 * (lo + hi);
        const double moved = fabs(x - before); /* what is left is about moved^3, or moved^3 / (a + x)^2 */
        if (moved < enough && moved * g->x < enough * density) break;
    }
    return x;
}

/* ---- views ----------------------------------------------------------------------------------- */

/* The view of the unit surface: (l, v0) of the head's text. */
typedef struct unit_view {
    double lx, ly, v0;
} unit_view;

static unit_view unit_view_of(const component *k, const double o[3])
{
    const ff_stretch *s = &k->pass->s;
    return (unit_view){k->l11 * o[0] + k->l21 * o[1], k->l22 * o[1], o[2] - o[0] * s->x0 - o[1] * s->y0};
}

/* N: the area that the unit surface shows to the view. */
static double visible_area(const component *k, const unit_view *v)
{
    const double l2 = v->lx * v->lx + v->ly * v->ly;
    if (k->kind == VISIBLE_GGX) return 0.5 * (v->v0 + sqrt(l2 + v->v0 * v->v0));
    const double length = sqrt(l2);
    const gaussian_view g = gaussian_view_of(length, v->v0);
    return (length + v->v0) * (1 / FF_SQRT_PI) * gaussian_mass(&g);
}

/* ---- drawing --------------------------------------------------------------------------------- */

/* wi = 2 (wo.h) h - wo for an h of any length. */
static void mirror(const double o[3], const double h[3], double wi[3])
{
    const double twice = 2 * (o[0] * h[0] + o[1] * h[1] + o[2] * h[2]) / (h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    for (int j = 0; j < 3; j++) wi[j] = twice * h[j] - o[j];
}

/* From the unit surface to h: m of the direction (-u, 1), of any length. */
static void mirror_unit(const component *k, const double o[3], double mx, double my, double mz, double wi[3])
{
    const ff_stretch *s = &k->pass->s;
    const double h[3] = {k->l11 * mx - s->x0 * mz, k->l21 * mx + k->l22 * my - s->y0 * mz, mz};
    mirror(o, h, wi);
}

static void draw_ggx(const component *k, const double o[3], double u1, double u2, double wi[3])
{
    const unit_view v = unit_view_of(k, o);
    const double inv = 1 / sqrt(v.lx * v.lx + v.ly * v.ly + v.v0 * v.v0), top = v.v0 * inv;
    const double low = u1 * (1 + top), side = sqrt(low * (2 - low)), turn = 2 * FF_PI * u2; /* in the cap z > -top */
    mirror_unit(k, o, side * cos(turn) + v.lx * inv, side * sin(turn) + v.ly * inv, (1 - u1) * (1 + top), wi);
}

static void draw_gaussian(const component *k, const double o[3], double u1, double u2, double wi[3])
{
    static const gaussian_view across = {1, 0, -INFINITY};
    const unit_view v = unit_view_of(k, o);
    const double length = sqrt(v.lx * v.lx + v.ly * v.ly);
    const gaussian_view along = gaussian_view_of(length, v.v0);
    const double ex = length > 0 ? v.lx / length : 1, ey = length > 0 ? v.ly / length : 0;
    const double x = gaussian_quantile(&along, u1), y = gaussian_quantile(&across, u2);
    mirror_unit(k, o, x * ex - y * ey, x * ey + y * ex, 1, wi);
}

static void draw_normal(const component *k, const double o[3], double u1, double u2, double wi[3])
{
    const double q2 = k->quantile ? k->quantile(&k->pass->ndf_pass, u1) : radial_quantile(&k->radial, u1);
    const double q = sqrt(q2 < 1e80 ? q2 : 1e80), turn = 2 * FF_PI * u2;
    mirror_unit(k, o, q * cos(turn), q * sin(turn), 1, wi);
}

/* mu^2 at a node of the matte tables. */
static double matte_node(int j)
{
    const double mu = (double)(j * j) * (1.0 / ((MATTE - 1) * (MATTE - 1)));
    return mu * mu;
}

/* mu^2 with the fraction u of the area under `rest` below it: linear between nodes, so that the integral is quadratic. */
static double matte_quantile(const component *k, double u)
{
    const double area = u * k->below[MATTE - 1];
    int j = 0;
    while (j < MATTE - 2 && k->below[j + 1] <= area) j++;
    const double first = matte_node(j), width = matte_node(j + 1) - first, need = (area - k->below[j]) / width;
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

static void draw(const component *k, const double o[3], double u1, double u2, double wi[3])
{
    switch (k->kind) {
    case VISIBLE_GGX:
        draw_ggx(k, o, u1, u2, wi);
        break;
    case VISIBLE_GAUSSIAN:
        draw_gaussian(k, o, u1, u2, wi);
        break;
    case NORMALS:
        draw_normal(k, o, u1, u2, wi);
        break;
    case MATTE_TABLE:
        draw_around(matte_quantile(k, u1), u2, wi);
        break;
    default:
        draw_around(1 - u1, u2, wi);
    }
}

/* ---- the sampler ----------------------------------------------------------------------------- */

struct ff_sampler {
    ff_model model;
    double *channel;
    ff_prepared prepared;
    uint32_t planes; /* of geometry */
    size_t n;
    component part[COMPONENTS];
};

/* A block of pairs of directions. */
typedef struct pairs {
    size_t n;
    double w[6][FF_BLOCK]; /* wi, wo                                                               */
    double plane[FF_G_COUNT][FF_BLOCK];
    ff_geometry g;
} pairs;

static void pairs_geometry(const ff_sampler *s, pairs *b)
{
    const ff_dirs w = {b->w[0], b->w[1], b->w[2], b->w[3], b->w[4], b->w[5]};
    for (int k = 0; k < FF_G_COUNT; k++) b->g.plane[k] = s->planes & 1u << k ? b->plane[k] : NULL;
    s->prepared.kernels->geometry(&w, b->n, &b->g);
}

/* ---- densities ------------------------------------------------------------------------------- */

/* Density of wi for strategy k, wherever both directions are above the horizon. */
static void density_of_lobe(const component *k, const pairs *b, double *out)
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
        if (k->kind == NORMALS) out[i] /= c[i] * (k->unit_area ? sqrt(inv_hz2) : 1) * k->radial.total;
    }
    for (size_t i = 0; i < b->n && k->kind != NORMALS; i++) {
        const unit_view v = unit_view_of(k, (const double[]){b->w[3][i], b->w[4][i], b->w[5][i]});
        out[i] = v.v0 > 0 ? out[i] / visible_area(k, &v) : 0;
    }
}

/* The density of mu^2 over pi is that of wi over mu. */
static void density_of_matte(const component *k, const pairs *b, double *out)
{
    const double inv = 1 / (FF_PI * k->below[MATTE - 1]);
    for (size_t i = 0; i < b->n; i++) {
        const double mu = b->w[2][i] > 0 ? fmin(b->w[2][i], 1) : 0;
        const int j = (int)fmin(sqrt(mu) * (MATTE - 1), MATTE - 2);
        const double first = matte_node(j), at = (mu * mu - first) / (matte_node(j + 1) - first);
        out[i] = mu * inv * (k->rest[j] + at * (k->rest[j + 1] - k->rest[j]));
    }
}

static void density(const component *k, const pairs *b, double *out)
{
    if (k->kind == MATTE_TABLE)
        density_of_matte(k, b, out);
    else if (k->kind == COSINE)
        for (size_t i = 0; i < b->n; i++) out[i] = b->w[2][i] * (1 / FF_PI);
    else
        density_of_lobe(k, b, out);
}

/* ---- the mixture ----------------------------------------------------------------------------- */

/* Shares of the strategies for each wo of a block, and the albedo that the tables give. All 0 where nothing can be drawn: at or
 * below the horizon; the share of a lobe is 0 where its mean surface is seen from below. */
typedef struct shares {
    double of[COMPONENTS][FF_BLOCK], albedo[FF_BLOCK];
} shares;

static double table_at(const double albedo[VIEWS], double mu)
{
    const double x = sqrt(fmin(mu, 1)) * (VIEWS - 1);
    const int j = (int)fmin(x, VIEWS - 2);
    return albedo[j] + (x - j) * (albedo[j + 1] - albedo[j]);
}

static int is_seen(const component *k, const double o[3])
{
    return o[2] > FF_COS_MIN && (!k->ndf || unit_view_of(k, o).v0 > 0);
}

static void shares_of(const ff_sampler *s, const pairs *b, shares *out)
{
    for (size_t i = 0; i < b->n; i++) {
        const double o[3] = {b->w[3][i], b->w[4][i], b->w[5][i]};
        double a[COMPONENTS], sum = 0, all = 0;
        for (size_t k = 0; k < s->n; k++) {
            a[k] = is_seen(&s->part[k], o) ? table_at(s->part[k].albedo, o[2]) : -1;
            if (a[k] > 0) sum += a[k];
        }
        for (size_t k = 0; k < s->n; k++) {
            a[k] = a[k] < 0 ? 0 : fmax(a[k], least_share * sum + 1e-300);
            all += a[k];
        }
        for (size_t k = 0; k < s->n; k++) out->of[k][i] = all > 0 ? a[k] / all : 0;
        out->albedo[i] = sum;
    }
}

static void mixture(const ff_sampler *s, const pairs *b, const shares *share, double *pdf)
{
    double one[FF_BLOCK];
    memset(pdf, 0, b->n * sizeof *pdf);
    for (size_t k = 0; k < s->n; k++) {
        density(&s->part[k], b, one);
        for (size_t i = 0; i < b->n; i++) pdf[i] += share->of[k][i] * one[i];
    }
    for (size_t i = 0; i < b->n; i++)
        if (!(b->plane[FF_G_K][i] > 0)) pdf[i] = 0;
}

/* The strategy in whose share u lies; the last that has one where rounding leaves a gap. */
static size_t choose(const ff_sampler *s, const shares *share, size_t i, double u)
{
    size_t last = s->n;
    double below = 0;
    for (size_t k = 0; k < s->n; k++) {
        if (share->of[k][i] == 0) continue;
        below += share->of[k][i];
        last = k;
        if (u < below) break;
    }
    return last;
}

/* ---- tables of a new sampler ----------------------------------------------------------------- */

/* wo of a pair of the block. */
static void set_view(pairs *b, size_t i, double mu, double turn)
{
    const double side = sqrt((1 - mu) * (1 + mu));
    b->w[3][i] = side * cos(turn);
    b->w[4][i] = side * sin(turn);
    b->w[5][i] = mu;
}

/* What component `at` alone reflects, summed over channels. */
static void value_of(const ff_sampler *s, const pairs *b, size_t at, double *out)
{
    const ff_prepared *p = &s->prepared;
    double f[FF_BLOCK];
    ff_block t;
    memset(out, 0, b->n * sizeof *out);
    p->kernels->block_shape(p, &b->g, b->n, &t);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &b->g, b->n, c, &t, f);
        const int lobe = at < p->m->n_lobes;
        const double *x = lobe ? t.S[at] : t.part[at - p->m->n_lobes], *F = t.F[lobe ? ff_model_group(p->m, (uint32_t)at) : 0];
        const double scale = lobe ? p->weight[at] : t.scale[at - p->m->n_lobes];
        for (size_t i = 0; i < b->n; i++) out[i] += scale * x[i] * (lobe ? F[i] : 1);
    }
}

/* As a function of wi.z; it is a product with one of wo.z, so that any views will do. At least a hundredth of its maximum, lest a
 * direction be left out. */
static void matte_make(ff_sampler *s, size_t at)
{
    static const double views[] = {0.1, 0.4, 0.7, 1};
    component *k = &s->part[at];
    double most = 0, f[FF_BLOCK];
    pairs b = {.n = MATTE};
    for (size_t v = 0; v < sizeof views / sizeof views[0]; v++) {
        for (size_t j = 0; j < MATTE; j++) {
            const double mu = fmax(sqrt(matte_node((int)j)), 1e-6), side = sqrt((1 - mu) * (1 + mu));
            b.w[0][j] = side, b.w[1][j] = 0, b.w[2][j] = mu;
            set_view(&b, j, views[v], 0);
        }
        pairs_geometry(s, &b);
        value_of(s, &b, at, f);
        for (size_t j = 0; j < MATTE; j++) k->rest[j] += f[j];
    }
    for (size_t j = 0; j < MATTE; j++) most = fmax(most, k->rest[j]);
    for (size_t j = 0; j < MATTE; j++) k->rest[j] = most > 0 ? fmax(k->rest[j], least_share * most) : 1;
    for (int j = 0; j + 1 < MATTE; j++)
        k->below[j + 1] = k->below[j] + 0.5 * (matte_node(j + 1) - matte_node(j)) * (k->rest[j] + k->rest[j + 1]);
}

/* The mean over azimuths and channels by the component's own samples, at the points of a lattice in place of random numbers
 * (Roberts 2018: the multiples of powers of 1/g, g^4 = g + 1). */
static void albedo_make(ff_sampler *s, size_t at)
{
    static const double step[3] = {0.8191725133961645, 0.6710436067037893, 0.5497004779019703};
    component *k = &s->part[at];
    for (int j = 0; j < VIEWS; j++) {
        const double x = (double)j / (VIEWS - 1);
        double pdf[FF_BLOCK], f[FF_BLOCK], sum = 0;
        pairs b = {.n = FF_BLOCK};
        for (size_t i = 0; i < b.n; i++) {
            double u[3], o[3], wi[3] = {0, 0, -1};
            for (int d = 0; d < 3; d++) u[d] = fmod(0.5 + (double)(i + 1) * step[d], 1);
            set_view(&b, i, fmax(x * x, 1e-3), 2 * FF_PI * u[0]);
            for (int d = 0; d < 3; d++) o[d] = b.w[3 + d][i];
            if (is_seen(k, o)) draw(k, o, u[1], u[2], wi);
            for (int d = 0; d < 3; d++) b.w[d][i] = wi[d];
        }
        pairs_geometry(s, &b);
        density(k, &b, pdf);
        value_of(s, &b, at, f);
        for (size_t i = 0; i < b.n; i++)
            if (b.plane[FF_G_K][i] > 0 && pdf[i] > 0) sum += f[i] * b.w[2][i] / pdf[i];
        k->albedo[j] = sum / ((double)b.n * (double)s->prepared.n_channels);
    }
}

static ff_status lobe_make(const ff_prepared *p, uint32_t l, component *k)
{
    const ff_stretch *t = &p->lobe[l].s;
    k->ndf = p->kernels->ndf[p->lobe[l].ndf];
    k->pass = &p->lobe[l];
    k->l11 = t->ax;
    k->l21 = t->r * t->ay;
    k->l22 = t->ay * sqrt((1 - t->r) * (1 + t->r));
    k->unit_area = (k->ndf->term.claims & FF_UNIT_AREA) != 0;
    k->kind = NORMALS;
    k->radial.total = 1;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (strcmp(known[i].ndf, k->ndf->term.name) == 0) {
            k->kind = known[i].kind;
            k->quantile = known[i].quantile;
            return FF_OK;
        }
    return radial_make(k);
}

static ff_status sampler_fill(ff_sampler *s, const ff_kernels *kernels, size_t n_channels, const double *shape)
{
    ff_prepared *p = &s->prepared;
    ff_status status = ff_prepare(&s->model, kernels, FF_CHEAPEST_MODE, n_channels, shape, s->channel, NULL, 0, INFINITY, p);
    if (status) return status;
    s->planes = ff_prepared_planes(p) | 1u << FF_G_K | 1u << FF_G_SX | 1u << FF_G_SY | 1u << FF_G_C;
    s->n = p->m->n_lobes + p->n_parts;
    for (uint32_t l = 0; l < p->m->n_lobes && !status; l++) status = lobe_make(p, l, &s->part[l]);
    for (uint32_t at = p->m->n_lobes; at < s->n && !status; at++) {
        const uint32_t base = p->part[at - p->m->n_lobes].base;
        const int left_over = (kernels->diffuse[p->m->base[base].diffuse]->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS)) != 0;
        s->part[at].kind = left_over ? MATTE_TABLE : COSINE;
        if (left_over) matte_make(s, at);
    }
    for (size_t at = 0; at < s->n && !status; at++) albedo_make(s, at);
    return status;
}

/* ---- public ---------------------------------------------------------------------------------- */

ff_status ff_sampler_new(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                         ff_sampler **out, ff_error *err)
{
    const ff_kernels *kernels = ff_kernels_get(isa);
    ff_status status = ff_model_check(m, n_channels, shape, channel, err);
    if (status) return status;
    if (!kernels) return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(isa));
    ff_sampler *s = calloc(1, sizeof *s);
    if (s) s->channel = malloc((n_channels * m->n_channel + 1) * sizeof *channel);
    if (!s || !s->channel) {
        free(s);
        return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a sampler of %zu channels", n_channels);
    }
    s->model = *m;
    memcpy(s->channel, channel, n_channels * m->n_channel * sizeof *channel);
    status = sampler_fill(s, kernels, n_channels, shape);
    if (status) {
        ff_sampler_free(s);
        return ff_error_set(err, status, NULL, 0, -1, "no sampler can be made of this model: %s", ff_status_str(status));
    }
    *out = s;
    return FF_OK;
}

void ff_sampler_free(ff_sampler *s)
{
    if (!s) return;
    for (size_t k = 0; k < COMPONENTS; k++) free(s->part[k].radial.node);
    ff_prepared_free(&s->prepared);
    free(s->channel);
    free(s);
}

/* Pairs first ... of [3][ld] planes. */
static void load(pairs *b, int from, const double *v, size_t first, size_t ld)
{
    for (size_t j = 0; j < 3; j++) memcpy(b->w[(size_t)from + j], v + j * ld + first, b->n * sizeof *v);
}

static void draw_block(const ff_sampler *s, const shares *share, const double *u, size_t ld, pairs *b)
{
    for (size_t i = 0; i < b->n; i++) {
        const double o[3] = {b->w[3][i], b->w[4][i], b->w[5][i]}, most = 1 - 0x1p-53;
        const size_t k = choose(s, share, i, u[i]);
        double wi[3] = {0, 0, -1};
        if (k < s->n) draw(&s->part[k], o, fmin(u[ld + i], most), u[2 * ld + i], wi);
        for (size_t j = 0; j < 3; j++) b->w[j][i] = wi[j];
    }
}

/* With f wi.z / pdf over `goes_on`, 0 where the path ends. */
static void weigh_block(const ff_sampler *s, const pairs *b, const double *pdf, const double *goes_on, double *f, double *weight,
                        size_t ld)
{
    const ff_prepared *p = &s->prepared;
    double value[FF_BLOCK];
    ff_block t;
    p->kernels->block_shape(p, &b->g, b->n, &t);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &b->g, b->n, c, &t, value);
        for (size_t i = 0; i < b->n; i++) {
            if (!(b->plane[FF_G_K][i] > 0)) value[i] = 0;
            weight[c * ld + i] = pdf[i] > 0 && goes_on[i] > 0 ? value[i] * b->w[2][i] / (pdf[i] * goes_on[i]) : 0;
        }
        if (f) memcpy(f + c * ld, value, b->n * sizeof *f);
    }
}

void ff_sampler_sample(const ff_sampler *s, size_t n, const double *wo, const double *u, const double *roulette, double *wi,
                       double *pdf, double *f, double *weight, size_t ld)
{
    for (size_t first = 0; first < n; first += FF_BLOCK) {
        double goes_on[FF_BLOCK];
        shares share;
        pairs b;
        b.n = n - first < FF_BLOCK ? n - first : FF_BLOCK;
        load(&b, 3, wo, first, ld);
        shares_of(s, &b, &share);
        draw_block(s, &share, u + first, ld, &b);
        pairs_geometry(s, &b);
        mixture(s, &b, &share, pdf + first);
        for (size_t i = 0; i < b.n; i++) {
            const double q = roulette ? fmax(fmin(share.albedo[i], 1), least_share) : 1;
            goes_on[i] = !roulette || roulette[first + i] < q ? q : 0;
        }
        weigh_block(s, &b, pdf + first, goes_on, f ? f + first : NULL, weight + first, ld);
        for (size_t j = 0; j < 3; j++) memcpy(wi + j * ld + first, b.w[j], b.n * sizeof *wi);
    }
}

void ff_sampler_pdf(const ff_sampler *s, size_t n, const double *wo, const double *wi, double *pdf, size_t ld)
{
    for (size_t first = 0; first < n; first += FF_BLOCK) {
        shares share;
        pairs b;
        b.n = n - first < FF_BLOCK ? n - first : FF_BLOCK;
        load(&b, 3, wo, first, ld);
        load(&b, 0, wi, first, ld);
        shares_of(s, &b, &share);
        pairs_geometry(s, &b);
        mixture(s, &b, &share, pdf + first);
    }
}
