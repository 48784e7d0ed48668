/* Nodes over an aperture, in the frame of its centre. */
#include "internal_averaging.h"
#include "base/internal_gauss.h"
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

int ff_aperture_valid(const ff_aperture *a)
{
    const int disc = a->outline == FF_APERTURE_DISC;
    if (!disc && a->outline != FF_APERTURE_RECTANGLE) return 0;
    if (!(a->source >= 0 && a->source <= FF_APERTURE_MOST)) return 0;
    return a->half >= 0 && a->half <= FF_APERTURE_MOST && (disc || (a->across >= 0 && a->across <= FF_APERTURE_MOST));
}

int ff_aperture_extended(const ff_aperture *a)
{
    return a->half > 0 || a->source > 0 || (a->outline == FF_APERTURE_RECTANGLE && a->across > 0);
}

/* Gauss in the share of the disc's solid angle, and equal angles: 2 n - 1 of the powers of its radius squared come out exactly. The
 * rule of 7 nodes is exact to the fifth degree, as 9 of those would be. */
static const struct {
    int rings, around, centre, degree;
} disc_rule[FF_LEVEL_MAPPED] = {{0, 0, 1, 1}, {1, 4, 0, 3}, {1, 6, 1, 5}, {2, 8, 0, 7}, {3, 12, 0, 11}, {5, 20, 0, 19}};
static const int side_rule[FF_LEVEL_MAPPED] = {1, 2, 3, 4, 6, 10};

/* Along the sides of the rules whose nodes crowd where the lobe is. */
static const int side[FF_LEVELS - FF_LEVEL_MAPPED] = {8, 12, 16, 24, 32, 48, 64, FF_MAPPED_MOST};

static size_t nodes_of(ff_aperture_outline outline, int level)
{
    if (outline == FF_APERTURE_RECTANGLE) return (size_t)(side_rule[level] * side_rule[level]);
    return (size_t)(disc_rule[level].rings * disc_rule[level].around + disc_rule[level].centre);
}

static void put(ff_rule *r, double p, double q, double z, double weight)
{
    r->p[r->n] = p;
    r->q[r->n] = q;
    r->r[r->n] = z;
    r->weight[r->n++] = weight;
}

static void ring(ff_rule *r, double half, double share, int around, double turn, double weight)
{
    const double z = 1 - share * (1 - cos(half)), sine = sqrt(fmax(1 - z * z, 0));
    for (int k = 0; k < around; k++) {
        const double phi = 2 * pi * (k + turn) / around;
        put(r, sine * cos(phi), sine * sin(phi), z, weight / around);
    }
}

/* centre: what the centre alone weighs. */
static void disc(double half, int level, double centre, ff_rule *r)
{
    const int rings = disc_rule[level].rings, around = disc_rule[level].around;
    ff_gauss g;
    r->degree = disc_rule[level].degree;
    if (level == 0) {
        put(r, 0, 0, 1, centre);
        return;
    }
    if (disc_rule[level].centre) { /* a quarter at the centre, the rest at two thirds of the solid angle */
        put(r, 0, 0, 1, 0.25);
        ring(r, half, 2 / 3.0, around, 0, 0.75);
        return;
    }
    ff_gauss_make(rings, &g);
    for (int i = 0; i < rings; i++) ring(r, half, 0.5 * (1 + g.x[i]), around, 0.5 * (i % 2), 0.5 * g.w[i]);
}

static void rectangle(const ff_aperture *a, int level, ff_rule *r)
{
    const int n = side_rule[level];
    const double sides[2] = {tan(a->half), tan(a->across)};
    double sum = 0, cosine = 0;
    ff_gauss g;
    ff_gauss_make(level ? n : 10, &g);
    r->degree = 2 * n - 1;
    for (int i = 0; i < g.n; i++)
        for (int k = 0; k < g.n; k++) {
            const double x = sides[0] * g.x[i], y = sides[1] * g.x[k], z = 1 / sqrt(1 + x * x + y * y),
                         weight = g.w[i] * g.w[k] * z * z * z;
            sum += weight;
            cosine += weight * z;
            if (level) put(r, x * z, y * z, z, weight);
        }
    if (!level) put(r, 0, 0, 1, cosine);
    for (size_t i = 0; i < r->n; i++) r->weight[i] /= sum;
}

/* The rules of a detector: the centre alone weighs as the mean of the cosine about it, so that Lambert's term is exact. */
static void detector(const ff_aperture *a, int level, ff_rule *r)
{
    if (a->outline == FF_APERTURE_RECTANGLE)
        rectangle(a, level, r);
    else
        disc(a->half, a->half > 0 ? level : 0, 0.5 * (1 + cos(a->half)), r);
}

/* How far an aperture reaches from its centre. */
static double radius(const ff_aperture *a)
{
    return a->outline == FF_APERTURE_DISC ? a->half : atan(hypot(tan(a->half), tan(a->across)));
}

static void make_side(int n, ff_line *s)
{
    ff_gauss g;
    s->n = n;
    if (n % FF_GAUSS == 0) {
        ff_gauss_panels(-1, 1, n / FF_GAUSS, s->x, s->w);
        return;
    }
    ff_gauss_make(n, &g);
    for (int i = 0; i < n; i++) s->x[i] = g.x[i], s->w[i] = g.w[i];
}

/* The level at which a cone that is `ratio` times as large errs no more than another at `level`, about a lobe of twice its width.
 */
static int level_of_smaller(const ff_rule *rules, double ratio, int level, int degree)
{
    int k = 0;
    while (k < level && pow(0.5 * ratio, rules[k].degree + 1) > pow(0.5, degree + 1)) k++;
    return k;
}

enum { NODES_MOST = 20000 }; /* of a pair */

/* Which rule of the detector goes with which of the source. */
static void pair_levels(ff_rules *r, double detector)
{
    const double source = r->a.source, ratio = fmin(source, detector) / fmax(source, detector);
    r->crowds = detector >= source;
    r->larger = r->crowds ? r->a : (ff_aperture){.outline = FF_APERTURE_DISC, .half = source};
    const ff_rule *smaller = r->crowds ? r->source : r->detector;
    for (int k = FF_LEVEL_MAPPED; k < FF_LEVELS; k++)
        r->smaller[k] = &smaller[level_of_smaller(smaller, ratio, FF_LEVEL_MAPPED - 1, 7 + 4 * (k - FF_LEVEL_MAPPED))];
    r->n_levels = FF_LEVELS;
    while (r->smaller[r->n_levels - 1]->n *
               (size_t)(side[r->n_levels - 1 - FF_LEVEL_MAPPED] * side[r->n_levels - 1 - FF_LEVEL_MAPPED]) >
           NODES_MOST)
        r->n_levels--;
    for (int k = 0; k < FF_LEVEL_MAPPED; k++) {
        r->of_detector[k] = r->of_source[k] = k;
        if (source < detector)
            r->of_source[k] = level_of_smaller(r->source, source / detector, k, r->detector[k].degree);
        else if (detector < source)
            r->of_detector[k] = level_of_smaller(r->detector, detector / source, k, r->source[k].degree);
    }
}

ff_rules *ff_rules_new(const ff_aperture *a, double tolerance)
{
    size_t n = 0;
    for (int level = 0; level < FF_LEVEL_MAPPED; level++) n += nodes_of(a->outline, level) + nodes_of(FF_APERTURE_DISC, level);
    ff_rules *r = malloc(sizeof *r + 4 * n * sizeof *r->storage);
    if (!r) return NULL;
    r->a = *a;
    r->tolerance = tolerance;
    r->reach = radius(a) + a->source;
    for (int k = 0; k < FF_LEVELS - FF_LEVEL_MAPPED; k++) make_side(side[k], &r->side[k]);
    double *next = r->storage;
    for (int k = 0; k < 2 * FF_LEVEL_MAPPED; k++) {
        const int level = k / 2;
        ff_rule *rule = k % 2 ? &r->source[level] : &r->detector[level];
        const size_t size = nodes_of(k % 2 ? FF_APERTURE_DISC : a->outline, level);
        *rule = (ff_rule){.p = next, .q = next + size, .r = next + 2 * size, .weight = next + 3 * size};
        next += 4 * size;
        if (k % 2)
            disc(a->source, a->source > 0 ? level : 0, 1, rule);
        else
            detector(a, level, rule);
    }
    pair_levels(r, r->reach - a->source);
    return r;
}
