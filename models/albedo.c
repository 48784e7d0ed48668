/* Directional albedo and weak white furnace by quadrature over the stretched slopes of a lobe.
 *
 *   s = s0 + L u      slope of the half vector, L L^T = [[ax^2, r ax ay], [r ax ay, ay^2]], s0 the mean slope
 *   u = q (cos psi, sin psi), q = sinh x       a heavy tail in q is an exponential in x, which Gauss-Legendre likes
 *   e = L (cos psi, sin psi)                   the ray in slope space: s = s0 + q e
 *   h = hz (-sx, -sy, 1), hz^-2 = 1 + |s|^2,   dh = hz^3 ds,  dwi = 4 (wo.h) dh
 *   V = wo.h / hz = oz - o.s                   linear along a ray
 *   wi.z = 2 V hz^2 - oz                       its sign is that of a quadratic along a ray
 *
 *   albedo         integral f iz 4 (wo.h) dh = integral 4 f iz V hz^4 det(L) q dq dpsi,  over iz > 0
 *   weak furnace   integral G1 D (wo.h) / ozp dh = integral G1 (D hz^4) V / ozp det(L) q dq dpsi,  over V > 0, ozp = oz - o.s0
 */
#include "ff_albedo.h"
#include "internal_kernel.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

enum {
    POINTS = 2048,   /* evaluated at once                                                    */
    GROUP = 4,       /* colour channels evaluated at once                                    */
    ORDER_FIRST = 8, /* Gauss-Legendre points of a panel; doubles                            */
    ORDER_LAST = 32,
    CENTRES = 16, /* directions at which panels of psi end                                */
    CUTS = 24     /* places on a ray at which panels of x end                             */
};
static const double tolerance = 1e-9;
static const double panel_x = 1.5;   /* width of a panel of x                                 */
static const double slope_far = 1e6; /* the furnace integral continues as a power law beyond this */

typedef struct rule {
    int n;
    double x[ORDER_LAST], w[ORDER_LAST]; /* on [-1, 1] */
} rule;

/* Gauss-Legendre by Newton's iteration on P_n. */
static void rule_make(int n, rule *g)
{
    g->n = n;
    for (int i = 0; i < n; ++i) {
        double x = cos(PI * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int it = 0; it < 8; ++it) {
            double p0 = 1, p1 = x;
            for (int k = 2; k <= n; ++k) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1);
            x -= p1 / slope;
        }
        g->x[i] = x;
        g->w[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* ---- the lobe and its rays ------------------------------------------------------------------- */

typedef struct vec2 {
    double x, y;
} vec2;

static double dot2(vec2 a, vec2 b)
{
    return a.x * b.x + a.y * b.y;
}

/* A model of one term, taken out of a larger one, with its parameters. */
typedef struct part {
    ff_model model;
    double shape[FF_MAX_SHAPE], channel[GROUP * FF_MAX_CHANNEL_PARAMS];
    size_t n_channels;
} part;

typedef struct integrand {
    const part *p;
    ff_isa isa;
    double o[3];          /* view                                               */
    double l11, l21, l22; /* L                                                  */
    double det;           /* det(L)                                             */
    vec2 s0, oxy;
    double v0; /* V at q = 0, the projected view cosine ozp          */
    int furnace;
    int own_g1; /* furnace: V-cavity's G1 instead of the constant g1  */
    double g1;
    double far, p_far, nu; /* furnace: P = p_far (q / far)^-nu beyond far       */
    /* points that wait for their evaluation: directions, weights */
    size_t n;
    double plane[6][POINTS], w[POINTS];
    double sum[GROUP];
    ff_status status;
} integrand;

static ff_dirs dirs_of(const integrand *k)
{
    return (ff_dirs){k->plane[0], k->plane[1], k->plane[2], k->plane[3], k->plane[4], k->plane[5]};
}

static void flush(integrand *k)
{
    double f[GROUP][POINTS];
    const ff_dirs w = dirs_of(k);
    const part *p = k->p;
    size_t planes = 1;
    if (k->n == 0 || k->status != FF_OK) return;
    if (k->furnace) {
        const ff_terms t = {.d = f[0]};
        k->status = ff_model_terms(&p->model, k->isa, 1, p->shape, p->channel, 0, 0, &w, k->n, &t);
    } else {
        planes = p->n_channels;
        k->status = ff_model_eval(&p->model, k->isa, p->n_channels, p->shape, p->channel, &w, k->n, f[0], NULL, POINTS);
    }
    for (size_t c = 0; c < planes && k->status == FF_OK; ++c)
        for (size_t i = 0; i < k->n; ++i) k->sum[c] += k->w[i] * f[c][i];
    k->n = 0;
}

static void add_point(integrand *k, const double wi[3], const double wo[3], double weight)
{
    if (k->n == POINTS) flush(k);
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
    if (k->furnace) { /* the kernel's half vector of (h, h) is h, and D knows nothing else */
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
    if (k->furnace) return;
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

/* Gauss-Legendre panels in x = asinh q between two cuts. */
static void integrate_piece(integrand *k, const rule *g, vec2 e, double q0, double q1, double weight)
{
    const double x0 = asinh(q0), x1 = asinh(q1);
    const int panels = (int)ceil((x1 - x0) / panel_x);
    const double half = (x1 - x0) / (2 * panels);
    for (int p = 0; p < panels; ++p) {
        const double mid = x0 + (2 * p + 1) * half;
        for (int i = 0; i < g->n; ++i) {
            const double x = mid + half * g->x[i];
            add_half_vector(k, e, sinh(x), weight * half * g->w[i] * cosh(x));
        }
    }
}

/* P = D hz^4 far out, where it is a power law q^-nu or has vanished. It is the same along every ray: measured once. */
static ff_status measure_tail(integrand *k)
{
    double d[2], plane[3][2];
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
    const ff_terms t = {.d = d};
    const ff_status status = ff_model_terms(&k->p->model, k->isa, 1, k->p->shape, k->p->channel, 0, 0, &w, 2, &t);
    if (status != FF_OK) return status;
    const double p0 = d[0] * pow(plane[2][0], 4);
    k->p_far = d[1] * pow(plane[2][1], 4);
    k->nu = k->p_far > 0 ? log2(p0 / k->p_far) : INFINITY;
    return FF_OK;
}

/* The furnace integral beyond far: that of q P (v0 - b q) dq with P = p_far (q / far)^-nu, from far to end. */
static double power_tail(const integrand *k, vec2 e, double end)
{
    if (!(k->p_far > 0)) return 0;
    const double far = k->far, nu = k->nu, b = dot2(k->oxy, e), v = k->v0 - b * far;
    const double rest = isinf(end) ? 0 : far / end;
    const double area = far * far * (1 - pow(rest, nu - 2)) / (nu - 2),
                 moment = far * far * far * (1 - pow(rest, nu - 3)) / (nu - 3);
    if (k->own_g1 && b < 0) return k->p_far * area * furnace_g1(k, v) * v / k->v0; /* there G1 V = 2 oz, constant */
    return k->p_far * (k->v0 * area - b * moment) * furnace_g1(k, v) / k->v0;
}

static void integrate_furnace_ray(integrand *k, const rule *g, double psi, double weight)
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
static void integrate_albedo_ray(integrand *k, const rule *g, double psi, double weight)
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

static void find_centres(const integrand *k, centres *c)
{
    const double m00 = k->l11 * k->l11 + k->l21 * k->l21, m01 = k->l21 * k->l22, m11 = k->l22 * k->l22; /* L^T L */
    const double spread = hypot((m00 - m11) / 2, m01), major2 = (m00 + m11) / 2 + spread;
    const double aspect = fmax(1, major2 / k->det); /* a1 / a2 */
    const vec2 t = {k->oxy.x / k->o[2], k->oxy.y / k->o[2]}, from = {k->s0.x + t.x, k->s0.y + t.y};
    const vec2 view = to_unit(k, k->oxy), disc = to_unit(k, from);
    double sharpness = 1 + (k->furnace ? hypot(view.x, view.y) / k->v0 : hypot(t.x, t.y) * aspect);
    c->n = 0;
    /* where V stops to shrink along the ray, where the way to the horizon turns from short to long */
    centre_add_line(c, atan2(view.y, view.x) + PI / 2);
    if (!k->furnace) {
        const double inside = dot2(k->s0, k->s0) + 2 * dot2(k->s0, t) - 1;
        if (k->s0.x != 0 || k->s0.y != 0) centre_add_line(c, atan2(disc.y, disc.x) + PI / 2);
        centre_add_line(c,
                        atan2((k->l11 * k->oxy.y - k->l21 * k->oxy.x) / k->l22, k->oxy.x)); /* plane of incidence: phi_i = phi_o */
        if (aspect > 1.5) centre_add_line(c, atan2(2 * m01, m00 - m11) / 2 + PI / 2);       /* the short axis      */
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

static void integrate_panel(integrand *k, const rule *g, double a, double b)
{
    const double mid = (a + b) / 2, half = (b - a) / 2;
    for (int i = 0; i < g->n; ++i) {
        const double psi = mid + half * g->x[i], weight = fabs(half) * g->w[i];
        if (k->furnace) {
            integrate_furnace_ray(k, g, psi, weight);
        } else {
            integrate_albedo_ray(k, g, psi, weight);
        }
    }
}

/* From a centre to the middle between it and the next, in panels that halve towards the centre. */
static void integrate_half_arc(integrand *k, const rule *g, double centre, double middle, int levels)
{
    double outer = 1;
    for (int l = 0; l < levels; ++l) {
        const double inner = l + 1 < levels ? outer / 2 : 0;
        integrate_panel(k, g, centre + (middle - centre) * inner, centre + (middle - centre) * outer);
        outer = inner;
    }
}

static void integrate_circle(integrand *k, const centres *c, int order)
{
    rule g;
    rule_make(order, &g);
    memset(k->sum, 0, sizeof k->sum);
    for (int i = 0; i < c->n && k->status == FF_OK; ++i) {
        const double a = c->psi[i], b = i + 1 < c->n ? c->psi[i + 1] : c->psi[0] + 2 * PI;
        if (b - a < 1e-12) continue;
        integrate_half_arc(k, &g, a, (a + b) / 2, c->levels);
        integrate_half_arc(k, &g, b, (a + b) / 2, c->levels);
    }
    flush(k);
}

/* Doubles the order until two agree. */
static ff_status integrate(integrand *k, size_t n, ff_integral out[GROUP])
{
    centres c;
    double before[GROUP] = {0};
    find_centres(k, &c);
    for (int order = ORDER_FIRST; order <= ORDER_LAST; order *= 2) {
        double worst = 0;
        integrate_circle(k, &c, order);
        if (k->status != FF_OK) return k->status;
        for (size_t i = 0; i < n; ++i) {
            out[i] = (ff_integral){k->sum[i], fabs(k->sum[i] - before[i])};
            before[i] = k->sum[i];
            worst = fmax(worst, out[i].error);
        }
        if (order > ORDER_FIRST && worst < tolerance) break;
    }
    return FF_OK;
}

/* ---- parts of a model ------------------------------------------------------------------------ */

/* Term number `index` (n_lobes: the diffuse one) of m with its parameters, as a model of its own. */
static ff_status part_make(const ff_model *m, uint32_t index, size_t n_channels, const double *shape, const double *channel,
                           part *p)
{
    ff_status status;
    size_t n = 0;
    if (index < m->n_lobes) {
        const ff_lobe *l = &m->lobe[index];
        status = ff_model_compose(l->ndf, l->masking, l->fresnel, -1, &p->model, NULL);
    } else {
        status = ff_model_parse(ff_term_at(FF_DIFFUSE, (size_t)m->diffuse)->name, &p->model, NULL);
    }
    if (status != FF_OK) return status;
    for (uint32_t i = 0; i < m->n_shape; ++i)
        if (m->shape[i].lobe == index) p->shape[n++] = shape[i];
    n = 0;
    p->n_channels = n_channels;
    for (size_t c = 0; c < n_channels; ++c)
        for (uint32_t i = 0; i < m->n_channel; ++i)
            if (m->channel[i].lobe == index) p->channel[n++] = channel[c * m->n_channel + i];
    return FF_OK;
}

static void integrand_make(const part *p, ff_isa isa, const double wo[3], integrand *k)
{
    ff_stretch s;
    ff_model_stretch(&p->model, 0, p->shape, &s, NULL);
    k->p = p;
    k->isa = isa;
    memcpy(k->o, wo, sizeof k->o);
    k->l11 = s.ax;
    k->l21 = s.r * s.ay;
    k->l22 = s.ay * sqrt((1 - s.r) * (1 + s.r));
    k->det = k->l11 * k->l22;
    k->s0 = (vec2){s.x0, s.y0};
    k->oxy = (vec2){wo[0], wo[1]};
    k->v0 = wo[2] - dot2(k->oxy, k->s0);
    k->furnace = k->own_g1 = 0;
    k->g1 = 1;
    k->n = 0;
    k->status = FF_OK;
}

/* Lambert-like terms: a smooth function over the hemisphere, wi = (sqrt(1 - z^2) (cos, sin), z). */
static ff_status integrate_diffuse(const part *p, ff_isa isa, const double wo[3], ff_integral out[GROUP])
{
    integrand k = {.p = p, .isa = isa};
    double before[GROUP] = {0};
    for (int order = ORDER_FIRST; order <= ORDER_LAST; order *= 2) {
        rule g;
        rule_make(order, &g);
        memset(k.sum, 0, sizeof k.sum);
        for (int i = 0; i < order; ++i)
            for (int j = 0; j < 2 * order; ++j) {
                const double z = (1 + g.x[i]) / 2, r = sqrt(1 - z * z), phi = PI * (j + 0.5) / order;
                add_point(&k, (const double[]){r * cos(phi), r * sin(phi), z}, wo, z * g.w[i] / 2 * PI / order);
            }
        flush(&k);
        if (k.status != FF_OK) return k.status;
        for (size_t c = 0; c < p->n_channels; ++c) {
            out[c] = (ff_integral){k.sum[c], fabs(k.sum[c] - before[c])};
            before[c] = k.sum[c];
        }
    }
    return FF_OK;
}

static ff_status check_view(const double wo[3], ff_error *err)
{
    const double norm = sqrt(wo[0] * wo[0] + wo[1] * wo[1] + wo[2] * wo[2]);
    if (!(fabs(norm - 1) < 1e-9))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the view has length %g, expected a unit vector", norm);
    if (!(wo[2] > FF_COS_MIN))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "the view has cosine %g, expected one above the horizon", wo[2]);
    return FF_OK;
}

ff_status ff_albedo_directional(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                                const double wo[3], ff_integral *out, ff_error *err)
{
    ff_status status = ff_model_check(m, n_channels, shape, channel, err);
    if (status == FF_OK) status = check_view(wo, err);
    if (status != FF_OK) return status;
    if (!ff_isa_available(isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(isa));
    for (size_t first = 0; first < n_channels; first += GROUP) {
        const size_t n = n_channels - first < GROUP ? n_channels - first : GROUP;
        ff_integral total[GROUP] = {{0, 0}};
        for (uint32_t term = 0; term < m->n_lobes + (m->diffuse >= 0); ++term) {
            part p;
            ff_integral one[GROUP];
            status = part_make(m, term, n, shape, channel + first * m->n_channel, &p);
            if (status == FF_OK && term < m->n_lobes) {
                integrand k;
                integrand_make(&p, isa, wo, &k);
                status = integrate(&k, n, one);
            } else if (status == FF_OK) {
                status = integrate_diffuse(&p, isa, wo, one);
            }
            if (status != FF_OK)
                return ff_error_set(err, status, NULL, 0, -1, "term %u of the model cannot be integrated", term + 1);
            for (size_t c = 0; c < n; ++c) {
                total[c].value += one[c].value;
                total[c].error += one[c].error;
            }
        }
        memcpy(out + first, total, n * sizeof *out);
    }
    return FF_OK;
}

/* G1(wo) of a Smith form from the kernels, with wi = wo (which every half vector of the furnace test shares a Lambda with). */
static ff_status smith_g1(const part *p, ff_isa isa, const double wo[3], double *g1)
{
    const ff_dirs w = {&wo[0], &wo[1], &wo[2], &wo[0], &wo[1], &wo[2]};
    double lambda = 0, g = 0;
    const ff_terms t = {.lambda_o = &lambda, .g = &g};
    const ff_status status = ff_model_terms(&p->model, isa, 1, p->shape, p->channel, 0, 0, &w, 1, &t);
    const int own = !strcmp(ff_masking_at(p->model.lobe[0].masking)->term.name, "smith-masking-only");
    if (status == FF_OK) *g1 = own ? g : 1 / (1 + lambda);
    return status;
}

ff_status ff_albedo_weak_furnace(const ff_model *m, ff_isa isa, const double *shape, uint32_t lobe, const double wo[3],
                                 ff_integral *out, ff_error *err)
{
    double channel[FF_MAX_CHANNEL_PARAMS];
    part p;
    integrand k;
    ff_integral result[GROUP];
    ff_model_defaults(m, 1, NULL, channel);
    ff_status status = ff_model_check(m, 1, shape, channel, err);
    if (status == FF_OK) status = check_view(wo, err);
    if (status != FF_OK) return status;
    if (!ff_isa_available(isa))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "this processor has no %s", ff_isa_name(isa));
    if (lobe >= m->n_lobes)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has %u lobes, the furnace test asks for lobe %u",
                            m->n_lobes, lobe + 1);
    status = part_make(m, lobe, 1, shape, channel, &p);
    if (status != FF_OK) return ff_error_set(err, status, NULL, 0, -1, "lobe %u of the model cannot be integrated", lobe + 1);
    integrand_make(&p, isa, wo, &k);
    if (!(k.v0 > 0))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "the mean slope turns the surface away from the view (projected cosine %g)", k.v0);
    const ff_masking *masking = ff_masking_at(p.model.lobe[0].masking);
    k.furnace = 1;
    k.own_g1 = !masking->uses_lambda && (masking->term.claims & FF_WEAK_FURNACE) != 0;
    if (masking->uses_lambda) status = smith_g1(&p, isa, wo, &k.g1);
    if (status == FF_OK) status = measure_tail(&k);
    if (status == FF_OK) status = integrate(&k, 1, result);
    if (status != FF_OK) return ff_error_set(err, status, NULL, 0, -1, "lobe %u of the model cannot be integrated", lobe + 1);
    *out = result[0];
    return FF_OK;
}
