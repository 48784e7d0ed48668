/* Places on a ray of an albedo's integral at which the integrand is not smooth. */
#include "internal_integral.h"
#include <math.h>

static void cut_add(ff_cuts *c, double q, double lo, double hi)
{
    if (q > lo && q < hi && c->n < FF_INTEGRAL_CUTS) c->q[c->n++] = q;
}

static double poly3(const double a[4], double q)
{
    return a[0] + q * (a[1] + q * (a[2] + q * a[3]));
}

int ff_quadratic_roots(double a0, double a1, double a2, double root[2])
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

/* The root of the cubic between l and r, where its signs differ: Newton's steps, and halves where these lead out. */
static double root_between(const double a[4], double l, double r)
{
    const int below = poly3(a, l) < 0;
    double x = (l + r) / 2;
    for (int it = 0; it < 60; it++) {
        const double f = poly3(a, x), slope = a[1] + x * (2 * a[2] + x * 3 * a[3]);
        if (f == 0) break;
        if ((f < 0) == below)
            l = x;
        else
            r = x;
        const double before = x, step = x - f / slope;
        x = step > l && step < r ? step : (l + r) / 2;
        if (fabs(x - before) <= 1e-15 * fabs(x)) break;
    }
    return x;
}

/* Roots of the polynomial inside (lo, hi): between its turning points a cubic is monotone. */
static void cut_roots(ff_cuts *c, const double a[4], double lo, double hi)
{
    double turn[2], end[4] = {lo};
    int n = 1;
    if (a[3] == 0) {
        const int roots = ff_quadratic_roots(a[0], a[1], a[2], turn);
        for (int i = 0; i < roots; i++) cut_add(c, turn[i], lo, hi);
        return;
    }
    const int turns = ff_quadratic_roots(a[1], 2 * a[2], 3 * a[3], turn);
    for (int i = 0; i < turns; i++)
        if (turn[i] > lo && turn[i] < hi) end[n++] = turn[i];
    end[n++] = hi;
    for (int i = 0; i + 1 < n; i++) {
        if (poly3(a, end[i]) * poly3(a, end[i + 1]) < 0) cut_add(c, root_between(a, end[i], end[i + 1]), lo, hi);
    }
}

/* Branches of the maskings, as polynomials in q with V = v0 - b q and 1 + |s|^2 = c0 + c1 q + c2 q^2:
 *   wi.z = wo.z                 V = oz (1 + |s|^2)             the larger Lambda, the smaller term of the V-cavity
 *   2 hz oz / (o.h) = 1         V = 2 oz                       V-cavity
 *   2 hz iz / (i.h) = 1         V (4 - (1 + |s|^2)) = 2 oz (1 + |s|^2)
 *   wi in the mesosurface       2 V (1 + s.s0) = ozp (1 + |s|^2)         with a mean slope: no light from below it */
void ff_cuts_branches(const ff_integrand *k, ff_vec2 e, double lo, double hi, ff_cuts *c)
{
    const double oz = k->o[2], v = k->v0, b = ff_dot2(k->oxy, e);
    const double c0 = 1 + ff_dot2(k->s0, k->s0), c1 = 2 * ff_dot2(k->s0, e), c2 = ff_dot2(e, e);
    const double equal_z[4] = {v - oz * c0, -b - oz * c1, -oz * c2, 0};
    const double groove_o[4] = {v - 2 * oz, -b, 0, 0};
    const double d0 = 4 - c0;
    const double groove_i[4] = {v * d0 - 2 * oz * c0, -v * c1 - b * d0 - 2 * oz * c1, -v * c2 + b * c1 - 2 * oz * c2, b * c2};
    const double m0 = c0, m1 = c1 / 2; /* 1 + s.s0 */
    const double mesosurface[4] = {2 * v * m0 - v * c0, 2 * (v * m1 - b * m0) - v * c1, -2 * b * m1 - v * c2, 0};
    cut_roots(c, groove_o, lo, hi);
    if (k->kind == FF_INTEGRAL_FURNACE) return;
    if (k->s0.x != 0 || k->s0.y != 0) cut_roots(c, mesosurface, lo, hi);
    cut_roots(c, equal_z, lo, hi);
    cut_roots(c, groove_i, lo, hi);
}

void ff_cuts_sort(ff_cuts *c)
{
    for (int i = 1; i < c->n; i++)
        for (int j = i; j > 0 && c->q[j] < c->q[j - 1]; j--) {
            const double t = c->q[j];
            c->q[j] = c->q[j - 1];
            c->q[j - 1] = t;
        }
}
