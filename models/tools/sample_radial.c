/* The distance of a normal from the mean one for any distribution: a table of the mass inside, and its inverse. */
#define FF_ISA_SUFFIX scalar
#include "internal_sample.h"
#include "models/terms/internal_isotropic.h"
#include <stdlib.h>

enum { DEEPEST = 30 };                 /* halvings of a panel */
static const double tolerance = 1e-11; /* in probability */

/* w(q2) = p, or p / h.z for a density that covers no unit area, and d ln w / d q2. n <= FF_BLOCK. */
static void radial_density(const ff_sample_component *k, size_t n, const double *q2, double *w, double *dlnw)
{
    k->ndf->profile(&k->pass->ndf_pass, n, q2, w, dlnw, NULL);
    const double a2 = k->pass->s.ax * k->pass->s.ax;
    for (size_t i = 0; i < n && !k->unit_area; i++) {
        w[i] *= sqrt(1 + a2 * q2[i]);
        dlnw[i] += 0.5 * a2 / (1 + a2 * q2[i]);
    }
}

/* The mass between y0 and y1: integral pi q2 w dy. */
static double radial_mass(const ff_sample_component *k, double y0, double y1)
{
    double q2[FF_GAUSS], weight[FF_GAUSS], w[FF_GAUSS], dlnw[FF_GAUSS], sum = 0;
    ff_gauss_panels(y0, y1, 1, q2, weight);
    for (int i = 0; i < FF_GAUSS; i++) q2[i] = exp(q2[i]);
    radial_density(k, FF_GAUSS, q2, w, dlnw);
    for (int i = 0; i < FF_GAUSS; i++) sum += weight[i] * FF_PI * q2[i] * w[i];
    return sum;
}

static ff_sample_node node_at(const ff_sample_component *k, double y, double mass)
{
    const double q2 = exp(y);
    double w, dlnw;
    radial_density(k, 1, &q2, &w, &dlnw);
    const double slope = FF_PI * q2 * w;
    return (ff_sample_node){y, mass, slope, slope * (1 + q2 * dlnw)};
}

/* The polynomial of degree 5 in t = (y - a.y) / (b.y - a.y) with the mass and its derivatives at both nodes. */
static void quintic(const ff_sample_node *a, const ff_sample_node *b, double c[6])
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

static ff_status radial_push(ff_sample_radial *r, ff_sample_node x)
{
    if (r->n == r->room) {
        const size_t room = r->room ? 2 * r->room : 256;
        ff_sample_node *more = realloc(r->node, room * sizeof *more);
        if (!more) return FF_ERR_MEMORY;
        r->node = more;
        r->room = room;
    }
    r->node[r->n++] = x;
    return FF_OK;
}

/* Continues the table from its last node to y; whole: the mass between them. Halves until quadrature and polynomial agree. */
static ff_status radial_extend(ff_sample_component *k, double y, double whole, int depth)
{
    const ff_sample_node a = k->radial.node[k->radial.n - 1];
    const double middle = 0.5 * (a.y + y), left = radial_mass(k, a.y, middle), right = radial_mass(k, middle, y);
    const ff_sample_node b = node_at(k, y, a.mass + left + right);
    double c[6];
    quintic(&a, &b, c);
    const double error = fmax(fabs(left + right - whole), fabs(quintic_at(c, 0.5) - (a.mass + left)));
    if (depth == 0 || !(error >= tolerance)) return radial_push(&k->radial, b);
    const ff_status status = radial_extend(k, middle, left, depth - 1);
    return status ? status : radial_extend(k, y, right, depth - 1);
}

/* Does no more than `nothing` lie beyond the last node? What falls as a power law there holds slope^2 / -curve. */
static int radial_ends(const ff_sample_radial *r, double nothing)
{
    const ff_sample_node last = r->node[r->n - 1];
    if (!(last.slope > 0)) return last.mass > 0.5;
    return last.curve < 0 && last.slope * last.slope < -last.curve * nothing * last.mass;
}

ff_status ff_sample_radial_make(ff_sample_component *k)
{
    const double nothing = 1e-14, zero = 0, far = 680; /* q2 = e^680 */
    ff_sample_radial *r = &k->radial;
    double w, dlnw;
    radial_density(k, 1, &zero, &w, &dlnw);
    r->middle = FF_PI * w;
    double y = log(nothing / r->middle);
    ff_status status = radial_push(r, node_at(k, y, nothing));
    for (; !status && y < far && !radial_ends(r, nothing); y += 1)
        status = radial_extend(k, y + 1, radial_mass(k, y, y + 1), DEEPEST);
    if (status) return status;
    const ff_sample_node last = r->node[r->n - 1];
    r->fall = last.slope > 0 ? -last.curve / last.slope : INFINITY;
    r->total = last.mass + (r->fall > 0 ? last.slope / r->fall : 0);
    return FF_OK;
}

/* Newton's iteration inside the panel a, b, by bisection where it would leave the bracket. */
static double radial_inside(const ff_sample_node *a, const ff_sample_node *b, double mass)
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

double ff_sample_radial_quantile(const ff_sample_radial *r, double u)
{
    const double mass = u * r->total;
    const ff_sample_node *first = r->node, *last = r->node + r->n - 1;
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
