/* Couplings of bases to the lobes: the curves of directional albedo, and the average of a Fresnel term.
 *
 * With h = hz (-s, 1), slope s = q (cos psi, sin psi), V = wo.h / hz and dwi = 4 (wo.h) dh = 4 V hz^4 q dq dpsi,
 *
 *   a(mu) = integral f iz dwi = integral 4 f iz V hz^4 q dq dpsi   over iz = 2 V hz^2 - mu > 0.
 *
 * A fit compares values whose parameters differ by little, so that nothing about the points may depend on parameters: the sums then
 * have exact derivatives, and no noise. What does depend on geometry alone, with T = tan(theta_o) cos(psi) = tan(tau), psi = 0
 * towards the view:
 *
 *   horizon of wi        q = T + sqrt(1 + T^2) = tan(pi/4 + tau/2)
 *   wi.z = wo.z          q = T                        kink of the forms that know the azimuth
 *   2 hz oz / (o.h) = 1  q = 1/T,    T > 1            kinks of the V-cavity: these two and q = T where T > 1,
 *   2 hz iz / (i.h) = 1  q = tan(pi/6 + tau/3), T < 1     the last alone where T < 1
 *
 * Along a ray the integrand is smooth in ln q, whatever the width of the distribution: q = end (1 + e^(-p s))^(-1/p) takes s in
 * (-inf, inf) to (0, end), exponentially at both ends, which the trapezoidal rule likes; every second ray lies half a step aside.
 * Beyond the first kink Gauss-Legendre panels go on. Rays are equidistant in u, T = sinh(asinh(tan theta_o) sin u): close where V
 * changes its sign, which at grazing view is a matter of mu; a rule without ends again, or Gauss-Legendre between the psi at which
 * the order of the kinks changes.
 *
 * What changes nothing is left out: lobes are narrow, and q runs from 0 to infinity. Below `nearest` the slopes hold 1e-8 of the
 * distribution, and one point stands for all.
 *
 * a(mu) is interpolated in mu^(1/3), which takes apart what happens at mu of the order of alpha and of alpha^2. */
#include "base/internal_gauss.h"
#include "internal_model.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ---- rules ----------------------------------------------------------------------------------- */

enum { RAY_POINTS = 190, PANEL_ORDER = 10, ARC_ORDER = 14, GRAZING_ORDER = 26 };
static const double step = 0.25;     /* between points of a ray, in s                                    */
static const double sharpness = 3;   /* p of the transformation                                          */
static const double last = 4.7;      /* largest s                                                        */
static const double panel_ratio = 4; /* ends of a panel                                                  */

enum { KINK_EQUAL = 1, KINK_CAVITY = 2 };

/* What one fill shares between its nodes. */
typedef struct filler {
    ff_prepared lobes; /* without the bases */
    int kinks;
    double nearest, farthest;                  /* slopes */
    ff_gauss panel, arc[2];                    /* the second for grazing views */
    double q[2][RAY_POINTS], w[2][RAY_POINTS]; /* by falling q: those of a ray with end = 1, and of the rays half a step aside */
    double mu, tangent;                        /* of the view */
    uint32_t at;
    ff_albedo_points points;
    ff_block_work *work;
} filler;

static void make_ray(filler *f)
{
    for (int aside = 0; aside < 2; aside++)
        for (int j = 0; j < RAY_POINTS; j++) {
            const double x = exp(sharpness * ((j + 0.5 * aside) * step - last)), q = pow(1 + x, -1 / sharpness);
            f->q[aside][j] = q;
            f->w[aside][j] = step * q * q * x / (1 + x);
            if (j == 0) f->w[aside][j] /= 1 - exp(-sharpness * step); /* with it, as a geometric series, all above */
        }
}

/* Masses of 256 slopes of a lobe decide which of them count. */
static void range_of_lobe(const ff_prepared *p, uint32_t l, double *nearest, double *farthest)
{
    enum { SLOPES = 2 * FF_BLOCK };
    const ff_lobe_pass *lobe = &p->lobe[l];
    double q[SLOPES], q2[SLOPES], density[SLOPES], slope[SLOPES], mass = 0, moment = 0, below = 0, above = 0;
    for (int i = 0; i < SLOPES; i++) {
        q[i] = exp(23 * (2.0 * i / SLOPES - 1)); /* 1e-10 to 1e10 */
        q2[i] = q[i] * q[i];
    }
    for (int i = 0; i < SLOPES; i += FF_BLOCK)
        p->kernels->ndf[lobe->ndf]->profile(&lobe->ndf_pass, FF_BLOCK, q2 + i, density + i, slope + i, NULL);
    for (int i = 0; i < SLOPES; i++) {
        mass += density[i] * q2[i];
        moment += density[i] * q2[i] * q[i];
    }
    int lo = 0, hi = SLOPES - 1;
    while (lo < hi && (below += density[lo] * q2[lo]) < 1e-8 * mass) lo++;
    while (hi > lo && (above += density[hi] * q2[hi] * q[hi]) < 1e-16 * moment) hi--; /* V may go as q */
    *nearest = fmin(*nearest, q[lo] * lobe->s.ax);
    *farthest = fmax(*farthest, q[hi] * lobe->s.ax);
}

/* ---- points ---------------------------------------------------------------------------------- */

static void flush(filler *f)
{
    if (f->points.n) f->lobes.kernels->albedo_add(&f->lobes, f->mu, &f->points, f->at, f->work);
    f->points.n = 0;
}

typedef struct ray {
    double cos_psi, sin_psi, weight; /* weight: that of dpsi */
    int aside;
} ray;

/* `count` slopes q along a ray, with weights, both in units of `scale`. */
static void add_points(filler *f, const ray *r, int count, const double *q, const double *w, double scale)
{
    ff_albedo_points *t = &f->points;
    const double factor = scale * scale * r->weight, cos_psi = r->cos_psi, sin_psi = r->sin_psi;
    while (count > 0) {
        const int room = FF_BLOCK - (int)t->n, n = count < room ? count : room;
        double *restrict to_q = t->q + t->n, *restrict to_w = t->weight + t->n;
        double *restrict to_cos = t->cos_psi + t->n, *restrict to_sin = t->sin_psi + t->n;
        for (int i = 0; i < n; i++) {
            to_q[i] = scale * q[i];
            to_w[i] = factor * w[i];
            to_cos[i] = cos_psi;
            to_sin[i] = sin_psi;
        }
        t->n += (size_t)n;
        q += n;
        w += n;
        count -= n;
        if (t->n == FF_BLOCK) flush(f);
    }
}

/* From 0 to end. */
static void add_from_zero(filler *f, const ray *r, double end)
{
    const double *q = f->q[r->aside], *w = f->w[r->aside], near = f->nearest / end, far = f->farthest / end;
    int from = 0, to;
    if (near > 0.3) { /* next to nothing happens on this ray */
        add_points(f, r, 1, &(double){2.0 / 3}, &(double){0.5}, end);
        return;
    }
    while (q[from] > far) from++;
    for (to = from; to < RAY_POINTS - 1 && q[to] > near;) to++;
    add_points(f, r, to - from, q + from, w + from, end);
    add_points(f, r, 1, q + to, &(double){w[to] / (1 - exp(-2 * step))}, end); /* with it, as a geometric series, all below */
}

/* Between two kinks. */
static void add_panels(filler *f, const ray *r, double from, double to)
{
    const int n = (int)ceil(log(to / from) / log(panel_ratio));
    const double ratio = n > 1 ? pow(to / from, 1.0 / n) : to / from;
    double q[PANEL_ORDER], w[PANEL_ORDER];
    for (int k = 0; k < PANEL_ORDER; k++) {
        q[k] = 0.5 * (ratio + 1 + (ratio - 1) * f->panel.x[k]);
        w[k] = 0.5 * (ratio - 1) * f->panel.w[k] * q[k];
    }
    for (int i = 0; i < n; i++, from *= ratio)
        if (from < f->farthest && from * ratio > 0.01 * f->nearest) add_points(f, r, PANEL_ORDER, q, w, from);
}

static void add_ray(filler *f, const ray *r)
{
    const double T = f->tangent * r->cos_psi, root = sqrt(1 + T * T), horizon = T > 0 ? T + root : 1 / (root - T);
    double end[4];
    int n = 0;
    if ((f->kinks & KINK_CAVITY) && T > 1) end[n++] = 1 / T;
    if (((f->kinks & KINK_EQUAL) && T > 0) || ((f->kinks & KINK_CAVITY) && T > 1)) end[n++] = T;
    if ((f->kinks & KINK_CAVITY) && T <= 1) end[n++] = tan(PI / 6 + atan(T) / 3);
    end[n++] = horizon;
    add_from_zero(f, r, end[0]);
    for (int i = 0; i + 1 < n; i++) add_panels(f, r, end[i], end[i + 1]);
}

/* ---- one view -------------------------------------------------------------------------------- */

/* The ray at u, with the weight du; rays come in pairs, at psi and -psi. */
static void add_ray_at(filler *f, double reach, double scale, double u, double du, int number)
{
    const double e = exp(reach * sin(u)), c = fmin(fmax(0.5 * (e - 1 / e) / scale, -1), 1), s = sqrt(1 - c * c);
    const ray r = {c, s, 2 * du * reach * cos(u) * 0.5 * (e + 1 / e) / (scale * s), number & 1};
    add_ray(f, &r);
}

/* a(mu) of all functions, added to their coefficient number `at`. */
static void add_view(filler *f, double mu, uint32_t at)
{
    f->mu = mu;
    f->at = at;
    f->tangent = sqrt((1 - mu) * (1 + mu)) / mu;
    const double scale = fmax(f->tangent, 1e-3), reach = asinh(scale); /* from normal incidence all rays look alike */
    double edge[4] = {-PI / 2};
    int edges = 1, number = 0;
    if (f->kinks & KINK_EQUAL) edge[edges++] = 0;                                             /* T = 0 */
    if ((f->kinks & KINK_CAVITY) && scale > 1 + 1e-9) edge[edges++] = asin(asinh(1) / reach); /* T = 1 */
    edge[edges] = PI / 2;
    if (f->kinks) {
        const ff_gauss *arc = &f->arc[mu < 0.2];
        for (int i = 0; i < edges; i++) {
            const double mid = 0.5 * (edge[i] + edge[i + 1]), half = 0.5 * (edge[i + 1] - edge[i]);
            for (int k = 0; k < arc->n; k++) add_ray_at(f, reach, scale, mid + half * arc->x[k], half * arc->w[k], number++);
        }
    } else {
        const int n = (int)ceil(4 + 5 * reach + 4 * fmin(scale, 1));
        for (int i = 0; i < n; i++) add_ray_at(f, reach, scale, PI * ((i + 0.5) / n - 0.5), PI / n, number++);
    }
    flush(f);
}

/* ---- curves ---------------------------------------------------------------------------------- */

static const int piece_size[FF_ALBEDO_PIECES] = {FF_ALBEDO_PIECE_0, FF_ALBEDO_PIECE_1, FF_ALBEDO_PIECE_2};
static const double piece_end[FF_ALBEDO_PIECES + 1] = {FF_ALBEDO_X_0, FF_ALBEDO_X_1, FF_ALBEDO_X_2, 1};

/* Chebyshev series of the polynomial through y at the points cos(pi k / (n - 1)). */
static void chebyshev(int n, const double *y, double *c)
{
    const int period = 2 * (n - 1);
    double cosine[2 * FF_ALBEDO_PIECE_0];
    for (int k = 0; k < period; k++) cosine[k] = cos(2 * PI * k / period);
    for (int j = 0; j < n; j++) {
        double sum = 0;
        for (int k = 0; k < n; k++) sum += (k == 0 || k == n - 1 ? 0.5 : 1) * y[k] * cosine[j * k % period];
        c[j] = sum * (j == 0 || j == n - 1 ? 1 : 2) / (n - 1);
    }
}

/* Chebyshev series -> coefficients by rising power. */
static void to_powers(int n, const double *c, double *out)
{
    double before[FF_ALBEDO_PIECE_0] = {1}, now[FF_ALBEDO_PIECE_0] = {0, 1}; /* T_(j-1), T_j */
    memset(out, 0, (size_t)n * sizeof *out);
    out[0] = c[0];
    for (int j = 1; j < n; j++) {
        double next[FF_ALBEDO_PIECE_0];
        for (int k = 0; k <= j; k++) out[k] += c[j] * now[k];
        for (int k = 0; k < n; k++) next[k] = (k ? 2 * now[k - 1] : 0) - before[k];
        memcpy(before, now, sizeof before);
        memcpy(now, next, sizeof now);
    }
}

/* x at t in [-1, 1] of a piece, and dx/dt. At the end of the middle piece a region of masked facets opens as (x_end - x)^(3/2); at
 * normal incidence Lambda is a power of tan(theta_o) that need not be even. The root of the distance makes polynomials of that. */
static double piece_x(int i, double t, double *slope)
{
    const double from = piece_end[i], to = piece_end[i + 1], low = 0.5 * (1 - t);
    *slope = (to - from) * (i > 0 ? low : 0.5);
    return to - (to - from) * (i > 0 ? low * low : low);
}

/* Values at the nodes -> coefficients, in place. Neighbours share a node. */
static void finish_function(double *v)
{
    double series[FF_ALBEDO_PIECE_0];
    for (int i = 0; i < FF_ALBEDO_PIECES; v += piece_size[i++]) {
        if (i + 1 < FF_ALBEDO_PIECES) v[0] = v[piece_size[i] + piece_size[i + 1] - 1];
        chebyshev(piece_size[i], v, series);
        to_powers(piece_size[i], series, v);
    }
}

/* 2 integral a mu dmu = integral 6 a x^5 dx, exact for the polynomials; f->arc[1] serves as the rule. */
static void finish_curve(const filler *f, ff_albedo_curve *curve)
{
    double mu[FF_ALBEDO_PIECES * GRAZING_ORDER], w[FF_ALBEDO_PIECES * GRAZING_ORDER], a[FF_ALBEDO_PIECES * GRAZING_ORDER];
    size_t n = 0;
    for (int i = 0; i < FF_ALBEDO_PIECES; i++)
        for (int k = 0; k < f->arc[1].n; k++, n++) {
            double slope;
            const double x = piece_x(i, f->arc[1].x[k], &slope);
            mu[n] = x * x * x;
            w[n] = 6 * slope * f->arc[1].w[k] * mu[n] * x * x;
        }
    for (uint32_t k = 0; k < curve->n_functions; k++) {
        finish_function(curve->coefficient + k * FF_ALBEDO_COEFFICIENTS);
        f->lobes.kernels->albedo_at(curve, k, n, mu, a);
        curve->mean[k] = 0;
        for (size_t i = 0; i < n; i++) curve->mean[k] += w[i] * a[i];
    }
}

/* 2 integral F(mu) mu dmu of every group and channel, with its derivatives. mu = x^2 takes the steep end apart. */
static void average_fresnel(const filler *f, ff_prepared *p)
{
    static const double end[] = {0, 0.1, 0.4, 1};
    enum { PANELS = 3, PER_TERM = 1 + FF_FRESNEL_PARAMS };
    double mu[FF_BLOCK], w[FF_BLOCK], value[PER_TERM][FF_BLOCK], *d[FF_FRESNEL_PARAMS];
    size_t n = 0;
    for (int i = 0; i < PANELS; i++)
        for (int k = 0; k < f->arc[1].n; k++, n++) {
            const double half = 0.5 * (end[i + 1] - end[i]), x = end[i] + half * (1 + f->arc[1].x[k]);
            mu[n] = x * x;
            w[n] = 4 * half * f->arc[1].w[k] * mu[n] * x;
        }
    const ff_geometry g = {.plane = {[FF_G_C] = mu}};
    for (int k = 0; k < FF_FRESNEL_PARAMS; k++) d[k] = value[1 + k];
    for (size_t c = 0; c < p->n_channels; c++)
        for (uint32_t l = 0; l < p->m->n_lobes; l++) {
            double *out = p->f_average + (c * p->m->n_lobes + l) * PER_TERM;
            memset(out, 0, PER_TERM * sizeof *out);
            if (ff_model_group(p->m, l) != l) continue;
            const ff_fresnel *term = p->kernels->fresnel[p->m->lobe[l].fresnel];
            term->eval(p->channel + c * p->m->n_channel + p->m->lobe[l].channel0, &g, n, value[0], d);
            for (uint32_t k = 0; k <= term->term.n_params; k++)
                for (size_t i = 0; i < n; i++) out[k] += w[i] * value[k][i];
        }
}

/* A masking that reads nothing is a constant: its lobe reflects without bound at grazing view, as 1/mu. */
static int is_unbounded(const ff_prepared *p, uint32_t l)
{
    const ff_masking *masking = p->kernels->masking[p->lobe[l].masking];
    return !masking->uses_lambda && !masking->uses_alpha && !masking->planes;
}

static void start(const ff_prepared *p, filler *f)
{
    f->lobes = *p;
    f->lobes.n_parts = 0;
    f->points.n = 0;
    f->kinks = 0;
    f->nearest = INFINITY;
    f->farthest = 0;
    ff_gauss_make(PANEL_ORDER, &f->panel);
    ff_gauss_make(ARC_ORDER, &f->arc[0]);
    ff_gauss_make(GRAZING_ORDER, &f->arc[1]);
    make_ray(f);
    for (uint32_t l = 0; l < p->m->n_lobes; l++) {
        const uint32_t planes = p->kernels->masking[p->lobe[l].masking]->planes;
        if (planes & 1u << FF_G_PHI) f->kinks |= KINK_EQUAL;
        if (planes & 1u << FF_G_VCAVITY) f->kinks |= KINK_CAVITY;
        range_of_lobe(p, l, &f->nearest, &f->farthest);
    }
}

/* Node by node, all functions of all curves at once. The first node of a piece is the last of the next. */
static void sum_curves(filler *f)
{
    uint32_t at = 0;
    for (int i = 0; i < FF_ALBEDO_PIECES; i++)
        for (int k = 0; k < piece_size[i]; k++, at++) {
            if (i + 1 < FF_ALBEDO_PIECES && k == 0) continue;
            double slope;
            const double x = piece_x(i, cos(PI * k / (piece_size[i] - 1)), &slope);
            add_view(f, x * x * x, at);
        }
}

ff_status ff_coupling_fill(ff_prepared *p)
{
    const size_t albedos = p->couples & FF_COUPLE_ALBEDO ? p->n_channels : 0,
                 losses = p->couples & FF_COUPLE_LOSS ? p->m->n_lobes : 0;
    filler *f = malloc(sizeof *f);
    if (f) f->work = ff_block_work_new(1);
    if (!f || !f->work) {
        free(f);
        return FF_ERR_MEMORY;
    }
    for (uint32_t l = 0; l < losses; l++) p->loss[l].over_cosine = is_unbounded(p, l);
    for (size_t c = 0; c < albedos; c++)
        for (uint32_t l = 0; l < p->m->n_lobes; l++) p->albedo[c].over_cosine |= is_unbounded(p, l);
    for (size_t i = 0; i < albedos + losses; i++) /* the curves of both kinds lie one after the other */
        memset(p->albedo[i].coefficient, 0, p->albedo[i].n_functions * FF_ALBEDO_COEFFICIENTS * sizeof(double));
    start(p, f);
    sum_curves(f);
    for (size_t i = 0; i < albedos + losses; i++) finish_curve(f, &p->albedo[i]);
    if (losses) average_fresnel(f, p);
    free(f->work);
    free(f);
    return FF_OK;
}
