/* Integrals over the stretched slopes of a lobe: directional albedo and weak white furnace.
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
#include "internal_integral.h"
#include "base/internal_gauss.h"
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

enum {
    ORDER_FIRST = 8, /* Gauss-Legendre points of a panel; doubles                            */
    ORDER_LAST = 32,
    CENTRES = 16 /* directions at which panels of psi end                                */
};
static const double tolerance = 1e-9;
static const double panel_x = 1.5;   /* width of a panel of x                                 */
static const double slope_far = 1e6; /* the furnace integral continues as a power law beyond this */

/* ---- points ---------------------------------------------------------------------------------- */

/* The geometry of n pairs of directions, in the planes of the work. */
static ff_geometry geometry_of(const ff_integrand *k, const ff_dirs *w, size_t n)
{
    const uint32_t needs = ff_prepared_planes(k->p);
    ff_geometry g = {{NULL}};
    for (int i = 0; i < FF_G_COUNT; i++)
        if (needs & 1u << i) g.plane[i] = k->work->planes[i];
    k->p->kernels->geometry(w, n, &g);
    return g;
}

/* f of every channel; of a model with bases, the bases alone. Or D of its lobe. */
static void evaluate(const ff_integrand *k, ff_integral_kind kind, const ff_dirs *w, size_t n,
                     double f[FF_INTEGRAL_GROUP][FF_BLOCK])
{
    const ff_prepared *p = k->p;
    ff_block *b = &k->work->block;
    const ff_geometry g = geometry_of(k, w, n);
    double lobes[FF_BLOCK];
    if (kind == FF_INTEGRAL_FURNACE) {
        p->kernels->lobe_terms(&p->lobe[0], &g, n, &b->lobe, f[0], f[1], f[2], f[3]);
        return;
    }
    p->kernels->block_shape(p, &g, n, b);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, &g, n, c, b, f[c]);
        if (kind == FF_INTEGRAL_LOBES) continue;
        p->kernels->block_value(&k->lobes, &g, n, c, b, lobes);
        for (size_t i = 0; i < n; i++) f[c][i] -= lobes[i];
    }
}

/* Adds sign times value and columns of p. */
static void add_columns(ff_integrand *k, const ff_prepared *p, const ff_geometry *g, double sign)
{
    double f[FF_BLOCK];
    ff_block *b = &k->work->block;
    for (size_t c = 0; c < k->n_channels; c++) {
        p->kernels->block_value(p, g, k->n, c, b, f);
        p->kernels->block_columns(p, k->n, c, k->w, b, k->work->column);
        for (size_t i = 0; i < k->n; i++) k->sum[c] += sign * k->w[i] * f[i];
        for (size_t j = 0; j < k->n_columns; j++)
            for (size_t i = 0; i < k->n; i++) k->column_sum[c][j] += sign * k->work->column[j][i];
    }
}

static void flush_columns(ff_integrand *k, const ff_dirs *w)
{
    const ff_geometry g = geometry_of(k, w, k->n);
    k->p->kernels->block_shape(k->p, &g, k->n, &k->work->block);
    add_columns(k, k->p, &g, 1);
    if (k->kind != FF_INTEGRAL_LOBES) add_columns(k, &k->lobes, &g, -1);
}

static void flush(ff_integrand *k)
{
    double f[FF_INTEGRAL_GROUP][FF_BLOCK];
    const ff_dirs w = {k->plane[0], k->plane[1], k->plane[2], k->plane[3], k->plane[4], k->plane[5]};
    if (k->n == 0) return;
    if (k->n_columns) {
        flush_columns(k, &w);
        k->n = 0;
        return;
    }
    evaluate(k, k->kind, &w, k->n, f);
    for (size_t c = 0; c < k->n_channels; c++)
        for (size_t i = 0; i < k->n; i++) k->sum[c] += k->w[i] * f[c][i];
    k->n = 0;
}

static void add_point(ff_integrand *k, const double wi[3], const double wo[3], double weight)
{
    if (k->n == FF_BLOCK) flush(k);
    for (int j = 0; j < 3; j++) {
        k->plane[j][k->n] = wi[j];
        k->plane[3 + j][k->n] = wo[j];
    }
    k->w[k->n++] = weight;
}

static ff_vec2 ray_direction(const ff_integrand *k, double psi)
{
    const double c = cos(psi), s = sin(psi);
    return (ff_vec2){k->l11 * c, k->l21 * c + k->l22 * s};
}

/* L^T v: the covector of u that belongs to a covector v of s. */
static ff_vec2 to_unit(const ff_integrand *k, ff_vec2 v)
{
    return (ff_vec2){k->l11 * v.x + k->l21 * v.y, k->l22 * v.y};
}

/* G1 of the furnace integral: twice the cosine of the V-cavity's groove over V, or the constant of a Smith form. */
static double furnace_g1(const ff_integrand *k, double v)
{
    return k->own_g1 ? fmin(1, 2 * k->o[2] / v) : k->g1;
}

/* Adds the half vector at distance q along the ray e; weight is that of dq dpsi. */
static void add_half_vector(ff_integrand *k, ff_vec2 e, double q, double weight)
{
    const ff_vec2 s = {k->s0.x + q * e.x, k->s0.y + q * e.y};
    const double hz2 = 1 / (1 + ff_dot2(s, s)), hz = sqrt(hz2), v = k->v0 - q * ff_dot2(k->oxy, e);
    const double h[3] = {-s.x * hz, -s.y * hz, hz};
    const double w = weight * k->det * q * hz2 * hz2 * v;
    if (v <= 0) return;
    if (k->kind == FF_INTEGRAL_FURNACE) { /* the kernel's half vector of (h, h) is h, and D knows nothing else */
        add_point(k, h, h, w * furnace_g1(k, v) / k->v0);
        return;
    }
    const double twice = 2 * v * hz; /* wi = 2 (wo.h) h - wo */
    const double wi[3] = {twice * h[0] - k->o[0], twice * h[1] - k->o[1], twice * h[2] - k->o[2]};
    if (wi[2] > 0) add_point(k, wi, k->o, 4 * w * wi[2]);
}

/* ---- one ray --------------------------------------------------------------------------------- */

/* Gauss-Legendre panels in x = asinh(q / w) between two cuts. */
static void integrate_piece(ff_integrand *k, const ff_gauss *g, ff_vec2 e, double q0, double q1, double weight)
{
    const double x0 = asinh(q0 / k->width), x1 = asinh(q1 / k->width);
    const int panels = (int)ceil((x1 - x0) / panel_x);
    const double half = (x1 - x0) / (2 * panels);
    for (int p = 0; p < panels; p++) {
        const double mid = x0 + (2 * p + 1) * half;
        for (int i = 0; i < g->n; i++) {
            const double grown = exp(mid + half * g->x[i]), shrunk = 1 / grown, w = 0.5 * k->width;
            add_half_vector(k, e, w * (grown - shrunk), weight * half * g->w[i] * w * (grown + shrunk)); /* sinh and cosh */
        }
    }
}

void ff_integrand_tail(ff_integrand *k)
{
    double d[FF_INTEGRAL_GROUP][FF_BLOCK], plane[3][2];
    const ff_vec2 e = ray_direction(k, 0);
    k->far = slope_far / sqrt(ff_dot2(e, e) + k->l22 * k->l22);
    for (int i = 0; i < 2; i++) {
        const double q = k->far * (i + 1) / 2;
        const ff_vec2 s = {k->s0.x + q * e.x, k->s0.y + q * e.y};
        const double hz = 1 / sqrt(1 + ff_dot2(s, s));
        plane[0][i] = -s.x * hz;
        plane[1][i] = -s.y * hz;
        plane[2][i] = hz;
    }
    const ff_dirs w = {plane[0], plane[1], plane[2], plane[0], plane[1], plane[2]};
    evaluate(k, FF_INTEGRAL_FURNACE, &w, 2, d);
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
static double power_tail(const ff_integrand *k, ff_vec2 e, double end)
{
    if (!(k->p_far > 0)) return 0;
    const double far = k->far, nu = k->nu, b = ff_dot2(k->oxy, e), v = k->v0 - b * far;
    const double reach = log(end / far), area = far * far * power_integral(nu - 2, reach),
                 moment = far * far * far * power_integral(nu - 3, reach);
    if (k->own_g1 && b < 0) return k->p_far * area * furnace_g1(k, v) * v / k->v0; /* there G1 V = 2 oz, constant */
    return k->p_far * (k->v0 * area - b * moment) * furnace_g1(k, v) / k->v0;
}

static void integrate_furnace_ray(ff_integrand *k, const ff_gauss *g, double psi, double weight)
{
    const ff_vec2 e = ray_direction(k, psi);
    const double b = ff_dot2(k->oxy, e), far = k->far;
    const double end = b > 0 ? k->v0 / b : INFINITY; /* V = 0 */
    ff_cuts c = {1, {0}};
    ff_cuts_branches(k, e, 0, fmin(end, far), &c);
    c.q[c.n++] = fmin(end, far);
    ff_cuts_sort(&c);
    for (int i = 0; i + 1 < c.n; i++) integrate_piece(k, g, e, c.q[i], c.q[i + 1], weight);
    if (end > far) k->sum[0] += weight * k->det * power_tail(k, e, end);
}

/* wi is above the horizon inside a disc of slopes about -t, t = tan(theta_o) towards o: |s + t|^2 < 1 / oz^2. */
static void integrate_albedo_ray(ff_integrand *k, const ff_gauss *g, double psi, double weight)
{
    const ff_vec2 e = ray_direction(k, psi), t = {k->oxy.x / k->o[2], k->oxy.y / k->o[2]};
    const ff_vec2 from = {k->s0.x + t.x, k->s0.y + t.y};
    double root[2];
    const double inside = ff_dot2(k->s0, k->s0) + 2 * ff_dot2(k->s0, t) - 1; /* < 0 where s0 lies in the disc */
    if (ff_quadratic_roots(inside, 2 * ff_dot2(e, from), ff_dot2(e, e), root) < 2 || root[1] <= 0) return;
    const double lo = fmax(root[0], 0), hi = root[1];
    ff_cuts c = {1, {lo}};
    ff_cuts_branches(k, e, lo, hi, &c);
    c.q[c.n++] = hi;
    ff_cuts_sort(&c);
    for (int i = 0; i + 1 < c.n; i++) integrate_piece(k, g, e, c.q[i], c.q[i + 1], weight);
}

/* ---- all rays -------------------------------------------------------------------------------- */

typedef struct centres {
    int n, levels; /* panels halve this often towards a centre */
    double psi[CENTRES];
} centres;

static void centre_add_line(centres *c, double psi)
{
    for (int i = 0; i < 2; i++) {
        const double turn = fmod(psi + i * PI, 2 * PI);
        if (c->n < CENTRES) c->psi[c->n++] = turn < 0 ? turn + 2 * PI : turn;
    }
}

/* Lines where (u . a)^2 = level u^T L^T L u: the rays that touch the disc when they start outside. */
static void centre_add_tangents(const ff_integrand *k, centres *c, ff_vec2 a, double level)
{
    const double m00 = a.x * a.x - level * (k->l11 * k->l11 + k->l21 * k->l21);
    const double m01 = a.x * a.y - level * k->l21 * k->l22, m11 = a.y * a.y - level * k->l22 * k->l22;
    double root[2]; /* tan psi */
    const int n = ff_quadratic_roots(m00, 2 * m01, m11, root);
    for (int i = 0; i < n; i++) centre_add_line(c, atan(root[i]));
}

/* psi of the ray whose slopes point along d. */
static double psi_towards(const ff_integrand *k, ff_vec2 d)
{
    return atan2((k->l11 * d.y - k->l21 * d.x) / k->l22, d.x);
}

static int has_cavities(const ff_integrand *k)
{
    return (k->p->kernels->masking[k->p->lobe[0].masking]->planes & 1u << FF_G_VCAVITY) != 0;
}

/* The branches of the V-cavity change their order where the view, projected to the plane of the ray, is 45 degrees from the normal:
 * tan(theta_o) cos(phi) = 1. */
static void centre_add_cavity(const ff_integrand *k, centres *c, double tangent)
{
    if (tangent <= 1) return;
    const double cosine = 1 / tangent, sine = sqrt((1 - cosine) * (1 + cosine));
    for (int side = -1; side <= 1; side += 2)
        centre_add_line(
            c, psi_towards(k, (ff_vec2){cosine * k->oxy.x - side * sine * k->oxy.y, cosine * k->oxy.y + side * sine * k->oxy.x}));
}

static void find_centres(const ff_integrand *k, centres *c)
{
    const double m00 = k->l11 * k->l11 + k->l21 * k->l21, m01 = k->l21 * k->l22, m11 = k->l22 * k->l22; /* L^T L */
    const double spread = hypot((m00 - m11) / 2, m01), major2 = (m00 + m11) / 2 + spread;
    const double aspect = fmax(1, major2 / k->det); /* a1 / a2 */
    const ff_vec2 t = {k->oxy.x / k->o[2], k->oxy.y / k->o[2]}, from = {k->s0.x + t.x, k->s0.y + t.y};
    const ff_vec2 view = to_unit(k, k->oxy), disc = to_unit(k, from);
    double sharpness = 1 + (k->kind == FF_INTEGRAL_FURNACE ? hypot(view.x, view.y) / k->v0 : hypot(t.x, t.y) * aspect);
    c->n = 0;
    /* where V stops to shrink along the ray, where the way to the horizon turns from short to long */
    centre_add_line(c, atan2(view.y, view.x) + PI / 2);
    if (k->kind != FF_INTEGRAL_FURNACE) {
        const double inside = ff_dot2(k->s0, k->s0) + 2 * ff_dot2(k->s0, t) - 1;
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
    for (int i = 1; i < c->n; i++)
        for (int j = i; j > 0 && c->psi[j] < c->psi[j - 1]; j--) {
            const double swap = c->psi[j];
            c->psi[j] = c->psi[j - 1];
            c->psi[j - 1] = swap;
        }
}

static void integrate_panel(ff_integrand *k, const ff_gauss *g, double a, double b)
{
    const double mid = (a + b) / 2, half = (b - a) / 2;
    for (int i = 0; i < g->n; i++) {
        const double psi = mid + half * g->x[i], weight = fabs(half) * g->w[i];
        if (k->kind == FF_INTEGRAL_FURNACE) {
            integrate_furnace_ray(k, g, psi, weight);
        } else {
            integrate_albedo_ray(k, g, psi, weight);
        }
    }
}

/* From a centre to the middle between it and the next, in panels that halve towards the centre. */
static void integrate_half_arc(ff_integrand *k, const ff_gauss *g, double centre, double middle, int levels)
{
    double outer = 1;
    for (int l = 0; l < levels; l++) {
        const double inner = l + 1 < levels ? outer / 2 : 0;
        integrate_panel(k, g, centre + (middle - centre) * inner, centre + (middle - centre) * outer);
        outer = inner;
    }
}

/* Is the lobe the same on both sides of the plane of incidence, whose two directions are centres? The derivatives are not. */
static int has_two_halves(const ff_integrand *k)
{
    return k->kind == FF_INTEGRAL_LOBES && !k->n_columns && k->l21 == 0 && k->l11 == k->l22 && k->s0.x == 0 && k->s0.y == 0;
}

/* The whole, or twice the half on one side of the plane of incidence. */
static void integrate_circle(ff_integrand *k, const ff_gauss *g, const centres *c)
{
    const int halved = has_two_halves(k);
    const double plane = psi_towards(k, k->oxy);
    for (int i = 0; i < c->n; i++) {
        const double a = c->psi[i], b = i + 1 < c->n ? c->psi[i + 1] : c->psi[0] + 2 * PI;
        if (b - a < 1e-12 || (halved && sin((a + b) / 2 - plane) < 0)) continue;
        integrate_half_arc(k, g, a, (a + b) / 2, c->levels);
        integrate_half_arc(k, g, b, (a + b) / 2, c->levels);
    }
}

/* The bases are smooth over the hemisphere of wi, but for kinks where wi.z = wo.z and at right azimuths; those that are coupled to
 * narrow lobes change fast near grazing light. wi.z = x^3. */
static void integrate_hemisphere(ff_integrand *k, const ff_gauss *g)
{
    double edge[] = {0, 0.1, 0.2, 0.35, 0.55, 0.8, 1, cbrt(k->o[2])};
    enum { EDGES = sizeof edge / sizeof edge[0] };
    const double towards = atan2(k->o[1], k->o[0]);
    for (int i = EDGES - 1; i > 0 && edge[i] < edge[i - 1]; i--) {
        const double swap = edge[i];
        edge[i] = edge[i - 1];
        edge[i - 1] = swap;
    }
    for (int panel = 0; panel + 1 < EDGES; panel++)
        for (int i = 0; i < g->n; i++) {
            const double half = (edge[panel + 1] - edge[panel]) / 2, x = edge[panel] + half * (1 + g->x[i]);
            const double z = x * x * x, r = sqrt((1 - z) * (1 + z)), weight = half * g->w[i] * 3 * x * x * z;
            for (int j = 0; j < 4 * g->n; j++) {
                const int quarter = j / g->n, node = j % g->n;
                const double phi = towards + PI / 4 * (2 * quarter + 1 + g->x[node]);
                add_point(k, (const double[]){r * cos(phi), r * sin(phi), z}, k->o, weight * PI / 4 * g->w[node]);
            }
        }
}

/* The narrowest peak of the bases, a difference of direction cosines; INFINITY where none has one. */
static double narrowest_peak(const ff_prepared *p)
{
    double least = INFINITY;
    for (uint32_t b = 0; b < p->m->n_bases; b++) {
        const ff_diffuse *term = p->kernels->diffuse[p->m->base[b].diffuse];
        double width, power;
        if (!term->peak) continue;
        term->peak(p->base_param[b], &width, &power);
        least = fmin(least, fmax(width, 1e-12));
    }
    return least;
}

/* One ray of direction cosines from the mirror direction, beta = -wo + d (cos, sin), to the horizon; d = peak sinh x as above, and
 * wi.z dwi = d dd dphi. */
static void integrate_cosines_ray(ff_integrand *k, const ff_gauss *g, double peak, double phi, double weight)
{
    const double c = cos(phi), s = sin(phi), along = k->o[0] * c + k->o[1] * s, root = sqrt(along * along + k->o[2] * k->o[2]);
    const double end = along > 0 ? along + root : k->o[2] * k->o[2] / (root - along), most = asinh(end / peak);
    const int panels = (int)ceil(most / panel_x);
    const double half = most / (2 * panels);
    for (int p = 0; p < panels; p++)
        for (int i = 0; i < g->n; i++) {
            const double at = (2 * p + 1 + g->x[i]) * half, d = peak * sinh(at);
            const double x = d * c - k->o[0], y = d * s - k->o[1], z2 = 1 - x * x - y * y;
            if (z2 > 0) add_point(k, (const double[]){x, y, sqrt(z2)}, k->o, weight * half * g->w[i] * d * peak * cosh(at));
        }
}

/* Bases with a peak. The way to the horizon changes within wo.z of the right angles to the plane of incidence, in panels that halve
 * towards them. */
static void integrate_peak(ff_integrand *k, const ff_gauss *g, double peak)
{
    const double towards = atan2(k->o[1], k->o[0]);
    const int levels = (int)fmin(16, 3 + ceil(fmax(0, -log2(k->o[2]))));
    for (int quarter = 0; quarter < 4; quarter++) {
        const double bend = towards + (quarter < 2 ? 0.5 : -0.5) * PI, way = (quarter % 2 ? 0.5 : -0.5) * PI;
        for (int l = 0; l < levels; l++) {
            const double outer = ldexp(way, -l), inner = l + 1 < levels ? 0.5 * outer : 0;
            for (int i = 0; i < g->n; i++)
                integrate_cosines_ray(k, g, peak, bend + 0.5 * (outer + inner) + 0.5 * (outer - inner) * g->x[i],
                                      0.5 * fabs(outer - inner) * g->w[i]);
        }
    }
}

void ff_integrand_sum(ff_integrand *k, int order)
{
    const double peak = k->kind == FF_INTEGRAL_BASES ? narrowest_peak(k->p) : INFINITY;
    centres c = {0, 0, {0}};
    ff_gauss g;
    ff_gauss_make(order, &g);
    memset(k->sum, 0, sizeof k->sum);
    if (k->n_columns) memset(k->column_sum, 0, sizeof k->column_sum);
    if (isfinite(peak)) {
        integrate_peak(k, &g, peak);
    } else if (k->kind == FF_INTEGRAL_BASES) {
        integrate_hemisphere(k, &g);
    } else {
        find_centres(k, &c);
        integrate_circle(k, &g, &c);
    }
    flush(k);
    for (size_t i = 0; i < k->n_channels && has_two_halves(k); i++) k->sum[i] *= 2;
}

void ff_integrand_integrate(ff_integrand *k, ff_integral out[FF_INTEGRAL_GROUP])
{
    double before[FF_INTEGRAL_GROUP] = {0}, worst = INFINITY;
    for (int order = ORDER_FIRST; order <= ORDER_LAST && !(worst < tolerance); order *= 2) {
        ff_integrand_sum(k, order);
        worst = order > ORDER_FIRST ? 0 : INFINITY;
        for (size_t i = 0; i < k->n_channels; i++) {
            out[i] = (ff_integral){k->sum[i], fabs(k->sum[i] - before[i])};
            before[i] = k->sum[i];
            worst = fmax(worst, out[i].error);
        }
    }
}

/* ---- a new integral -------------------------------------------------------------------------- */

/* Where the profile first leaves [p(0)/4, 4 p(0)]: its narrowest feature. */
static double profile_width(const ff_prepared *p)
{
    const ff_lobe_pass *lobe = &p->lobe[0];
    double q[FF_BLOCK], q2[FF_BLOCK], value[FF_BLOCK], slope[FF_BLOCK];
    for (int i = 0; i < FF_BLOCK; i++) {
        q[i] = 1e-6 * exp2(0.25 * i); /* to 3e3 */
        q2[i] = q[i] * q[i];
    }
    p->kernels->ndf[lobe->ndf]->profile(&lobe->ndf_pass, FF_BLOCK, q2, value, slope, NULL);
    for (int i = 1; i < FF_BLOCK; i++)
        if (!(value[i] > 0.25 * value[0] && value[i] < 4 * value[0])) return q[i];
    return 1;
}

void ff_integrand_make(ff_integral_kind kind, const ff_prepared *p, const double wo[3], ff_block_work *work, ff_integrand *k)
{
    *k = (ff_integrand){.kind = kind,
                        .p = p,
                        .n_channels = p->n_channels,
                        .oxy = {wo[0], wo[1]},
                        .g1 = 1,
                        .work = work,
                        .n_columns = p->wanted.n_shape + p->wanted.n_channel};
    memcpy(k->o, wo, sizeof k->o);
    if (kind == FF_INTEGRAL_BASES) {
        k->lobes = *p;
        k->lobes.n_parts = 0;
        return;
    }
    const ff_stretch s = p->lobe[0].s;
    k->l11 = s.ax;
    k->l21 = s.r * s.ay;
    k->l22 = s.ay * sqrt((1 - s.r) * (1 + s.r));
    k->det = k->l11 * k->l22;
    k->s0 = (ff_vec2){s.x0, s.y0};
    k->v0 = wo[2] - ff_dot2(k->oxy, k->s0);
    k->width = profile_width(p);
}
