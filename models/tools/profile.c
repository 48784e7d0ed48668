/* The lattice of a tabulated distribution; see ff_profile.h. */
#define FF_ISA_SUFFIX scalar /* the baseline's kernels: a table is the same on every machine */
#include "profile_struct.h"
#include "base/internal_gauss.h"
#include "models/terms/internal_lambda_table.h"
#include "models/terms/internal_tabulated.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

/* The points as they are interpolated: `n` of them after what follows the first of the zeros at the end. */
typedef struct points {
    ff_profile_kind kind;
    size_t n;
    const double *x, *y;
    double least; /* smaller values count as this                      */
    double s;     /* the q2 at which the values have fallen to half    */
} points;

static double q2_most(void)
{
    return ldexp(1, FF_PROFILE_OCTAVE_HI);
}

/* The horizon, where tan^2 is infinite, is the end of the lattice. */
static double q2_of(const points *p, size_t i)
{
    if (p->kind == FF_PROFILE_P) return p->x[i];
    const double t = tan(p->x[i]);
    return p->x[i] < 1.57 || (t > 0 && t * t < q2_most()) ? t * t : q2_most();
}

/* ---- what is refused ------------------------------------------------------------------------- */

static ff_status refuse(ff_error *err, size_t *bad, size_t i, const char *found, double value, const char *expected)
{
    if (bad) *bad = i;
    return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "found %s %.9g, expected %s", found, value, expected);
}

static ff_status check_points(const points *p, size_t *bad, ff_error *err)
{
    const int of_angle = p->kind == FF_PROFILE_D;
    const char *abscissa = of_angle ? "the angle in degrees" : "q2 =", *ordinate = of_angle ? "D =" : "p =";
    const double unit = of_angle ? 180 / pi : 1;
    double most = 0;
    if (p->n < FF_PROFILE_POINTS_MIN) return refuse(err, bad, p->n, "a number of points of", (double)p->n, "at least 4");
    for (size_t i = 0; i < p->n; i++) {
        if (!isfinite(p->x[i]) || p->x[i] < 0 || (of_angle && p->x[i] > pi / 2 + 1e-9))
            return refuse(err, bad, i, abscissa, unit * p->x[i], of_angle ? "0 to 90" : "a number >= 0");
        if (!isfinite(p->y[i]) || p->y[i] < 0) return refuse(err, bad, i, ordinate, p->y[i], "a number >= 0");
        if (i > 0 && !(q2_of(p, i) > q2_of(p, i - 1)))
            return refuse(err, bad, i, abscissa, unit * p->x[i],
                          "one beyond that of the point before (and at most one at the horizon)");
        most = fmax(most, p->y[i]);
    }
    return most > 0 ? FF_OK : refuse(err, bad, p->n, "a largest value of", 0, "one above 0");
}

/* ---- the monotone cubic ---------------------------------------------------------------------- */

/* The q2 at which the values have fallen to half the largest; the last one where they do not. */
static double half_width(const points *p)
{
    size_t top = 0;
    for (size_t i = 1; i < p->n; i++)
        if (p->y[i] > p->y[top]) top = i;
    for (size_t i = top + 1; i < p->n; i++) {
        const double half = 0.5 * p->y[top], a = q2_of(p, i - 1), b = q2_of(p, i);
        if (p->y[i] <= half) return a + (b - a) * (p->y[i - 1] - half) / (p->y[i - 1] - p->y[i]);
    }
    return q2_of(p, p->n - 1);
}

/* Abscissa and ordinate of the interpolation. */
static double knot_x(const points *p, size_t i)
{
    return log1p(q2_of(p, i) / p->s);
}

static double knot_y(const points *p, size_t i)
{
    return log(fmax(p->y[i], p->least));
}

static double secant(const points *p, size_t i)
{
    return (knot_y(p, i + 1) - knot_y(p, i)) / (knot_x(p, i + 1) - knot_x(p, i));
}

/* m within [0, 3 d], either sign of d: a cubic with such slopes at both ends is monotone (Fritsch and Carlson 1980). */
static double limited(double m, double d)
{
    return m * d <= 0 ? 0 : copysign(fmin(fabs(m), 3 * fabs(d)), d);
}

/* Slope at knot i: that of the parabola through it and its neighbours, limited. */
static double knot_slope(const points *p, size_t i)
{
    const size_t last = p->n - 1, at = i == 0 ? 1 : i == last ? last - 1 : i;
    const double before = knot_x(p, at) - knot_x(p, at - 1), behind = knot_x(p, at + 1) - knot_x(p, at);
    const double d0 = secant(p, at - 1), d1 = secant(p, at), bend = (d1 - d0) / (before + behind);
    if (i == 0) return limited(d0 - before * bend, d0);
    if (i == last) {
        const double m = limited(d1 + behind * bend, d1);
        return p->kind == FF_PROFILE_D ? fmin(m, 0) : m;
    }
    return d0 * d1 <= 0 ? 0 : limited(d0 + before * bend, fabs(d0) < fabs(d1) ? d0 : d1);
}

/* The interpolating function on one interval between knots, or beyond the ends. */
typedef struct segment {
    double x0, width, y0, y1, m0, m1;
} segment;

static segment segment_at(const points *p, size_t i)
{
    const double x0 = knot_x(p, i);
    return (segment){x0, knot_x(p, i + 1) - x0, knot_y(p, i), knot_y(p, i + 1), knot_slope(p, i), knot_slope(p, i + 1)};
}

/* Value and derivative by x; straight on beyond the ends. */
static void segment_eval(const segment *g, double x, double *f, double *d)
{
    const double u = (x - g->x0) / g->width, rise = g->y1 - g->y0, a = g->m0 * g->width, b = g->m1 * g->width;
    if (u <= 0 || u >= 1) {
        *f = u <= 0 ? g->y0 + a * u : g->y1 + b * (u - 1);
        *d = u <= 0 ? g->m0 : g->m1;
        return;
    }
    const double c2 = 3 * rise - 2 * a - b, c3 = a + b - 2 * rise;
    *f = g->y0 + ((c3 * u + c2) * u + a) * u;
    *d = ((3 * c3 * u + 2 * c2) * u + a) / g->width;
}

/* ---- the lattice ----------------------------------------------------------------------------- */

/* Lower end of bin k. */
static double bin_q2(int k)
{
    return ldexp(1 + k % 32 / 32., FF_PROFILE_OCTAVE_LO + k / 32);
}

/* ln p and d ln p / d q2. */
static void log_p(const points *p, const segment *g, double q2, double *f, double *d)
{
    segment_eval(g, log1p(q2 / p->s), f, d);
    *d /= p->s + q2;
    if (p->kind == FF_PROFILE_P) return;
    *f -= 2 * log1p(q2); /* p = D mz^4 */
    *d -= 2 / (1 + q2);
}

/* ln p at the ends of the bins into c[0], its slope into c[1]; those of the last bin's upper end into top. */
static void fill_ends(const points *p, ff_profile_table *out, double top[2])
{
    size_t at = 0, now = 0;
    segment g = segment_at(p, 0);
    for (int k = 0; k <= FF_PROFILE_BINS; k++) {
        const double q2 = bin_q2(k);
        while (now + 2 < p->n && q2_of(p, now + 1) <= q2) now++;
        if (now != at) g = segment_at(p, at = now);
        log_p(p, &g, q2, k < FF_PROFILE_BINS ? &out->c[0][k] : &top[0], k < FF_PROFILE_BINS ? &out->c[1][k] : &top[1]);
    }
}

/* Where the values on both sides go the same way, a slope between them that keeps the cubics monotone: a bin that holds a point of
 * the table does not know of it. */
static double monotone(double slope, double before, double behind)
{
    return before * behind <= 0 ? slope : limited(slope, fabs(before) < fabs(behind) ? before : behind);
}

static void fill_bins(const points *p, ff_profile_table *out)
{
    double top[2], *f = out->c[0], *d = out->c[1], before = 0;
    fill_ends(p, out, top);
    for (int k = 0; k < FF_PROFILE_BINS; k++) {
        const double behind = ((k + 1 < FF_PROFILE_BINS ? f[k + 1] : top[0]) - f[k]) / (bin_q2(k + 1) - bin_q2(k));
        d[k] = monotone(d[k], before, behind);
        before = behind;
    }
    for (int k = 0; k < FF_PROFILE_BINS; k++) {
        const int last = k + 1 == FF_PROFILE_BINS;
        const double width = bin_q2(k + 1) - bin_q2(k), rise = (last ? top[0] : f[k + 1]) - f[k];
        const double a = d[k] * width, b = (last ? top[1] : d[k + 1]) * width;
        d[k] = a;
        out->c[2][k] = 3 * rise - 2 * a - b;
        out->c[3][k] = a + b - 2 * rise;
    }
}

/* pi integral p dq2 by Gauss and Legendre in each bin; constant below the lattice, p ~ q2^-2 above. */
static double area_of(const ff_profile_table *t)
{
    double node[FF_GAUSS], weight[FF_GAUSS];
    const int last = FF_PROFILE_BINS - 1;
    double sum = bin_q2(0) * exp(t->c[0][0]);
    ff_gauss_panels(0, 1, 1, node, weight);
    for (int k = 0; k <= last; k++) {
        double bin = 0;
        for (int i = 0; i < FF_GAUSS; i++) {
            const double u = node[i];
            bin += weight[i] * exp(t->c[0][k] + u * (t->c[1][k] + u * (t->c[2][k] + u * t->c[3][k])));
        }
        sum += bin * (bin_q2(k + 1) - bin_q2(k));
    }
    return pi * (sum + q2_most() * exp(t->c[0][last] + t->c[1][last] + t->c[2][last] + t->c[3][last]));
}

ff_status ff_profile_make(ff_profile_kind kind, size_t n, const double *x, const double *y, ff_profile_table *out, size_t *bad,
                          ff_error *err)
{
    if (kind != FF_PROFILE_D && kind != FF_PROFILE_P)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a profile of kind %d, expected %d or %d", (int)kind, (int)FF_PROFILE_D,
                            (int)FF_PROFILE_P);
    points p = {.kind = kind, .n = n, .x = x, .y = y};
    const ff_status status = check_points(&p, bad, err);
    if (status) return status;
    double most = 0;
    for (size_t i = 0; i < n; i++) most = fmax(most, y[i]);
    p.least = 1e-30 * most;
    p.s = half_width(&p);
    if (!(p.s >= ldexp(1, -34) && p.s <= ldexp(1, 34)))
        return refuse(err, bad, n, "the values fallen to half at q2 =", p.s, "that within 2^-34 to 2^34");
    while (p.n > 2 && y[p.n - 1] <= p.least && y[p.n - 2] <= p.least) p.n--;
    if (p.n < 3) return refuse(err, bad, n, "nothing but a number of values above 0 of", (double)p.n - 1, "at least 2");
    const double end = knot_slope(&p, p.n - 1);
    if (kind == FF_PROFILE_P && end > -1.6)
        return refuse(err, bad, p.n - 1, "a table that ends falling as q2 to the power", end,
                      "-1.6 or steeper: beyond the last point it goes on so, and its slopes would have no mean");
    double *storage = malloc(FF_LAMBDA_FINE * sizeof *storage);
    if (!storage) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for the quadrature of a table's Lambda");
    fill_bins(&p, out);
    out->half_q2 = p.s;
    out->area = area_of(out);
    for (int k = 0; k < FF_PROFILE_BINS; k++) out->c[0][k] -= log(out->area);
    ff_tabulated_lambda(out, storage);
    free(storage);
    return FF_OK;
}

ff_status ff_profile_new(ff_profile_kind kind, size_t n, const double *x, const double *y, ff_profile_table **out, size_t *bad,
                         ff_error *err)
{
    ff_profile_table *made = malloc(sizeof *made);
    if (bad) *bad = n;
    if (!made) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    const ff_status status = ff_profile_make(kind, n, x, y, made, bad, err);
    if (status)
        ff_profile_free(made);
    else
        *out = made;
    return status;
}

void ff_profile_free(ff_profile_table *t)
{
    free(t);
}
