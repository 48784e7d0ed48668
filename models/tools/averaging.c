/* Means of a model over an aperture and a source: sums over nodes, of pairs side by side or of one pair, at the level that
 * suffices. */
#include "internal_averaging.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- memory ------------------------------------------------------------------------------------ */

static ff_average_work *work_new(size_t C, size_t P)
{
    const size_t nodes = (size_t)FF_MAPPED_MOST * FF_MAPPED_MOST, planes = C * (3 + 2 * P + 2);
    ff_average_work *w = malloc(sizeof *w + (planes * FF_BLOCK + 4 * nodes) * sizeof *w->storage);
    if (!w) return NULL;
    w->block = ff_block_work_new(1);
    if (!w->block) {
        free(w);
        return NULL;
    }
    w->n_channels = C;
    w->n_columns = P;
    double *next = w->storage;
    double **const plane[] = {&w->f, &w->now, &w->before, &w->least, &w->most};
    for (size_t k = 0; k < sizeof plane / sizeof *plane; k++, next += C * FF_BLOCK) *plane[k] = next;
    w->df = next;
    w->dnow = w->df + C * P * FF_BLOCK;
    next = w->dnow + C * P * FF_BLOCK;
    double **const node[] = {&w->p, &w->q, &w->r, &w->w};
    for (size_t k = 0; k < sizeof node / sizeof *node; k++, next += nodes) *node[k] = next;
    return w;
}

ff_average_work **ff_average_works_new(size_t count, size_t n_channels, size_t n_columns)
{
    ff_average_work **works = calloc(count + 1, sizeof(ff_average_work *));
    for (size_t i = 0; works && i < count; i++) {
        works[i] = work_new(n_channels, n_columns);
        if (works[i]) continue;
        ff_average_works_free(works);
        return NULL;
    }
    return works;
}

void ff_average_works_free(ff_average_work **works)
{
    for (size_t i = 0; works && works[i]; i++) {
        free(works[i]->block);
        free(works[i]);
    }
    free(works);
}

void ff_averaging_make(const ff_rules *rules, const ff_prepared *prepared, const ff_needles *needles, ff_averaging *out)
{
    out->rules = rules;
    out->prepared = prepared;
    out->values = *prepared;
    out->values.wanted = (ff_wanted){0};
    memset(out->values.needs, 0, sizeof out->values.needs);
    if (needles)
        out->needles = *needles;
    else
        ff_needles_find(prepared, &out->needles);
}

/* ---- nodes of pairs side by side ------------------------------------------------------------------ */

static void frame_of(double x, double y, double *cos_phi, double *sin_phi)
{
    const double sine = sqrt(x * x + y * y), inverse = sine > 1e-12 ? 1 / sine : 0;
    *cos_phi = sine > 1e-12 ? x * inverse : 1;
    *sin_phi = y * inverse;
}

/* Centres of lanes [n] of the pairs. */
static void gather(const ff_dirs *w, size_t n, ff_average_work *t)
{
    const double *const from[6] = {w->wix, w->wiy, w->wiz, w->wox, w->woy, w->woz};
    for (int d = 0; d < 6; d++)
        for (size_t k = 0; k < n; k++) t->centre[d][k] = from[d][t->lane[k]];
    for (size_t k = 0; k < n; k++) t->inverse[k] = 1 / t->centre[5][k];
}

/* And their frames. */
static void make_frames(size_t n, ff_average_work *t)
{
    for (int d = 0; d < 2; d++)
        for (size_t k = 0; k < n; k++)
            frame_of(t->centre[3 * d][k], t->centre[3 * d + 1][k], &t->frame[d][0][k], &t->frame[d][1][k]);
}

/* Node (p, q, r) about the centres of incidence (d = 0) or exit (1). */
static void place(ff_average_work *t, int d, size_t n, double p, double q, double r)
{
    const double *restrict x = t->centre[3 * d], *restrict y = t->centre[3 * d + 1], *restrict z = t->centre[3 * d + 2],
                           *restrict c = t->frame[d][0], *restrict s = t->frame[d][1];
    double *restrict nx = t->node[3 * d], *restrict ny = t->node[3 * d + 1], *restrict nz = t->node[3 * d + 2];
    for (size_t k = 0; k < n; k++) {
        const double sine = x[k] * c[k] + y[k] * s[k];
        nx[k] = p * z[k] * c[k] - q * s[k] + r * x[k];
        ny[k] = p * z[k] * s[k] + q * c[k] + r * y[k];
        nz[k] = -p * sine + r * z[k];
    }
}

/* What the value at a node weighs in the mean; nothing at and below the horizon. inverse: of the cosine of the centre. */
static inline double weigh(double weight, double iz, double oz, double inverse)
{
    return (iz > FF_COS_MIN ? 1.0 : 0.0) * (oz > FF_COS_MIN ? 1.0 : 0.0) * weight * oz * inverse;
}

/* The model ready at the nodes of n lanes. */
static ff_geometry begin(const ff_prepared *p, size_t n, ff_average_work *t)
{
    const ff_dirs w = {t->node[0], t->node[1], t->node[2], t->node[3], t->node[4], t->node[5]};
    ff_geometry g = {{NULL}};
    for (int k = 0; k < FF_G_COUNT; k++)
        if (p->planes & 1u << k) g.plane[k] = t->block->planes[k];
    p->kernels->geometry(&w, n, &g);
    p->kernels->block_shape(p, &g, n, &t->block->block);
    return g;
}

static size_t columns_of(const ff_prepared *p)
{
    return p->wanted.n_shape + p->wanted.n_channel;
}

/* The range of the values at the nodes, times their cosines. */
static void widen_range(size_t n, const double *restrict weight, const double *restrict value, const double *restrict cosine,
                        double *restrict least, double *restrict most)
{
    for (size_t k = 0; k < n; k++) {
        const double v = weight[k] > 0 ? value[k] * cosine[k] : 0;
        least[k] = v < least[k] ? v : least[k];
        most[k] = v > most[k] ? v : most[k];
    }
}

static void add_to(size_t n, const double *restrict a, const double *restrict b, double *restrict sum)
{
    for (size_t k = 0; k < n; k++) sum[k] += a[k] * b[k];
}

/* Adds a node of each of n lanes; ranges: also what the values range over. */
static void add_lanes(const ff_prepared *p, size_t n, int ranges, ff_average_work *t)
{
    const ff_geometry g = begin(p, n, t);
    const size_t P = columns_of(p);
    for (size_t c = 0; c < t->n_channels; c++) {
        p->kernels->block_value(p, &g, n, c, &t->block->block, t->value);
        add_to(n, t->weight, t->value, t->now + c * FF_BLOCK);
        if (ranges) widen_range(n, t->weight, t->value, t->node[5], t->least + c * FF_BLOCK, t->most + c * FF_BLOCK);
        if (!P) continue;
        p->kernels->block_columns(p, n, c, t->weight, &t->block->block, t->block->column);
        for (size_t j = 0; j < P; j++) {
            double *restrict sum = t->dnow + (c * P + j) * FF_BLOCK;
            const double *restrict column = t->block->column[j];
            for (size_t k = 0; k < n; k++) sum[k] += column[k];
        }
    }
}

static void clear(size_t first, size_t n, size_t P, ff_average_work *t)
{
    for (size_t c = 0; c < t->n_channels; c++) {
        memset(t->now + c * FF_BLOCK + first, 0, n * sizeof *t->now);
        for (size_t j = 0; j < P; j++) memset(t->dnow + (c * P + j) * FF_BLOCK + first, 0, n * sizeof *t->dnow);
        for (size_t k = first; k < first + n; k++) t->least[c * FF_BLOCK + k] = INFINITY, t->most[c * FF_BLOCK + k] = -INFINITY;
    }
}

static void weigh_lanes(size_t n, double weight, ff_average_work *t)
{
    for (size_t k = 0; k < n; k++) t->weight[k] = weigh(weight, t->node[2][k], t->node[5][k], t->inverse[k]);
}

/* Means of lanes [n] by the rules of a level that serves all pairs. */
static void sum_lanes(const ff_averaging *a, const ff_prepared *p, int level, size_t n, ff_average_work *t)
{
    const ff_rule *out = &a->rules->detector[a->rules->of_detector[level]], *in = &a->rules->source[a->rules->of_source[level]];
    const int ranges = p == &a->values;
    clear(0, n, columns_of(p), t);
    if (level == FF_LEVEL_CENTRE) {
        for (int d = 0; d < 6; d++) memcpy(t->node[d], t->centre[d], n * sizeof *t->node[d]);
        weigh_lanes(n, out->weight[0], t);
        add_lanes(p, n, ranges, t);
        return;
    }
    make_frames(n, t);
    for (size_t i = 0; i < in->n; i++) {
        place(t, 0, n, in->p[i], in->q[i], in->r[i]);
        for (size_t o = 0; o < out->n; o++) {
            place(t, 1, n, out->p[o], out->q[o], out->r[o]);
            weigh_lanes(n, in->weight[i] * out->weight[o], t);
            add_lanes(p, n, ranges, t);
        }
    }
}

/* ---- nodes of one pair ----------------------------------------------------------------------------- */

/* Nodes from a to b that crowd about t0 as the values of a function do that falls over `width`; by t = t0 + width sinh s, in which
 * such a function has no narrow peak (Johnston and Elliott 2005). */
static void crowd(const ff_line *side, double a, double b, double t0, double width, double *t, double *weight)
{
    const double lo = asinh((a - t0) / width), half = 0.5 * (asinh((b - t0) / width) - lo);
    for (int i = 0; i < side->n; i++) {
        const double e = 0.5 * exp(lo + half * (1 + side->x[i])), inverse = 0.25 / e;
        t[i] = fmin(fmax(t0 + width * (e - inverse), a), b);
        weight[i] = side->w[i] * half * width * (e + inverse);
    }
}

/* The angle psi of v = R sin psi about which nodes crowd, and over how much of it. */
static void crowd_of_disc(double radius, double v0, double width, double *psi, double *over)
{
    const double out = fmax(fabs(v0) - radius, 0), w = (width + out) / radius;
    *psi = asin(fmin(fmax(v0 / radius, -1), 1));
    *over = fmin(w / fmax(cos(*psi), 1e-9), sqrt(2 * w));
}

/* Nodes of an aperture for a view of a lobe: along u, the axis on which it is narrower, on each of the lines of equal v. */
static size_t mapped_nodes(const ff_aperture *a, const ff_needle_view *view, const ff_line *side, ff_average_work *t)
{
    const int rectangle = a->outline == FF_APERTURE_RECTANGLE, along = view->m[0] >= view->m[2];
    const double muu = fmax(along ? view->m[0] : view->m[2], 1e-12), mvv = along ? view->m[2] : view->m[0], muv = view->m[1],
                 bu = view->b[along ? 0 : 1], bv = view->b[along ? 1 : 0], s = fmax(mvv - muv * muv / muu, 1e-9 * muu),
                 v0 = -(bv - muv / muu * bu) / s, radius = sin(a->half);
    const double half_u = rectangle ? tan(along ? a->half : a->across) : radius,
                 half_v = rectangle ? tan(along ? a->across : a->half) : radius;
    double psi, over, sum = 0;
    size_t count = 0;
    if (rectangle)
        crowd(side, -half_v, half_v, v0, 1 / sqrt(s), t->t[0], t->tw[0]);
    else {
        crowd_of_disc(radius, v0, 1 / sqrt(s), &psi, &over);
        crowd(side, -0.5 * 3.14159265358979323846, 0.5 * 3.14159265358979323846, psi, over, t->t[0], t->tw[0]);
    }
    for (int i = 0; i < side->n; i++) {
        const double v = rectangle ? t->t[0][i] : radius * sin(t->t[0][i]), chord = rectangle ? half_u : radius * cos(t->t[0][i]),
                     dv = rectangle ? 1 : radius * cos(t->t[0][i]), u0 = -(bu + muv * v) / muu,
                     width = sqrt((1 + s * (v - v0) * (v - v0)) / muu);
        crowd(side, -chord, chord, u0, width, t->t[1], t->tw[1]);
        for (int k = 0; k < side->n; k++, count++) {
            const double u = t->t[1][k], weight = t->tw[0][i] * dv * t->tw[1][k],
                         z = rectangle ? 1 / sqrt(1 + u * u + v * v) : sqrt(fmax(1 - u * u - v * v, 0)), size = rectangle ? z : 1;
            t->p[count] = (along ? u : v) * size;
            t->q[count] = (along ? v : u) * size;
            t->r[count] = z;
            t->w[count] = rectangle ? weight * z * z * z : weight / z;
            sum += t->w[count];
        }
    }
    for (size_t k = 0; k < count; k++) t->w[k] /= sum;
    return count;
}

/* Unit vectors along theta and across it. */
static void axes(const double w[3], double e[2][3])
{
    double c, s;
    frame_of(w[0], w[1], &c, &s);
    e[0][0] = w[2] * c, e[0][1] = w[2] * s, e[0][2] = -hypot(w[0], w[1]);
    e[1][0] = -s, e[1][1] = c, e[1][2] = 0;
}

/* A lobe is out of an aperture's reach where it is this many half widths away: a Gaussian one is 2^-64 of its peak there. */
#define OUT_OF_REACH 8.0

static int within_reach(const ff_needle_view *view, double stretch)
{
    return sqrt(view->c) < sqrt(stretch) + OUT_OF_REACH;
}

/* What an exit sees of the lobes: the narrowest of those within reach, or of all where none is. */
typedef struct sight {
    ff_needle_view view;
    int reached;
    double stretch; /* square of the aperture's reach in its half widths */
    double bound;   /* the largest of any lobe, times 1 + the square of its distance */
} sight;

/* of: the direction that the larger cone is about, the other one fixed. */
static sight look(const ff_averaging *a, const double other[3], const double of[3])
{
    sight best = {.reached = 0};
    double e[2][3];
    axes(of, e);
    for (uint32_t k = 0; k < a->needles.n; k++) {
        ff_needle_view view;
        ff_needle_look(&a->needles.needle[k], other, of, e, &view);
        const double stretch = ff_needle_stretch(&view, a->rules->reach);
        const int near = within_reach(&view, stretch);
        best.bound = fmax(best.bound, stretch * (1 + view.c));
        if (near < best.reached || (near == best.reached && stretch <= best.stretch)) continue;
        best.reached = near;
        best.stretch = stretch;
        best.view = view;
    }
    return best;
}

/* Adds n nodes from `first` on, about direction d of the pair in a lane of the centres, to what stands there. */
static void add_nodes(const ff_prepared *p, int d, size_t first, size_t n, double weight, size_t slot, ff_average_work *t)
{
    const double c = t->frame[d][0][slot], s = t->frame[d][1][slot], x = t->centre[3 * d][slot], y = t->centre[3 * d + 1][slot],
                 z = t->centre[3 * d + 2][slot], sine = x * c + y * s;
    double(*node)[FF_BLOCK] = t->node + 3 * d, (*other)[FF_BLOCK] = t->node + 3 * (1 - d);
    for (size_t k = 0; k < n; k++) {
        const double a = t->p[first + k], b = t->q[first + k], r = t->r[first + k];
        for (int q = 0; q < 3; q++) other[q][k] = t->other[q];
        node[0][k] = a * z * c - b * s + r * x;
        node[1][k] = a * z * s + b * c + r * y;
        node[2][k] = -a * sine + r * z;
        t->weight[k] = weigh(weight * t->w[first + k], t->node[2][k], t->node[5][k], t->inverse[slot]);
    }
    const ff_geometry g = begin(p, n, t);
    const size_t P = columns_of(p);
    for (size_t ch = 0; ch < t->n_channels; ch++) {
        double sum = 0;
        p->kernels->block_value(p, &g, n, ch, &t->block->block, t->value);
        for (size_t k = 0; k < n; k++) sum += t->weight[k] * t->value[k];
        t->now[ch * FF_BLOCK + slot] += sum;
        if (!P) continue;
        p->kernels->block_columns(p, n, ch, t->weight, &t->block->block, t->block->column);
        for (size_t j = 0; j < P; j++) {
            sum = 0;
            for (size_t k = 0; k < n; k++) sum += t->block->column[j][k];
            t->dnow[(ch * P + j) * FF_BLOCK + slot] += sum;
        }
    }
}

/* The mean of the pair in a lane by nodes of its own over the larger cone, for each node of the smaller one. */
static void sum_mapped(const ff_averaging *a, const ff_prepared *p, int level, size_t slot, ff_average_work *t)
{
    const ff_rules *rules = a->rules;
    const ff_rule *few = rules->smaller[level];
    const int d = rules->crowds;
    double of[3], centre[3], e[2][3];
    clear(slot, 1, columns_of(p), t);
    for (int q = 0; q < 3; q++) centre[q] = t->centre[3 * (1 - d) + q][slot], of[q] = t->centre[3 * d + q][slot];
    axes(centre, e);
    for (size_t i = 0; i < few->n; i++) {
        for (int q = 0; q < 3; q++) t->other[q] = few->p[i] * e[0][q] + few->q[i] * e[1][q] + few->r[i] * centre[q];
        const sight seen = look(a, t->other, of);
        const size_t n = mapped_nodes(&rules->larger, &seen.view, &rules->side[level - FF_LEVEL_MAPPED], t);
        for (size_t first = 0; first < n; first += FF_BLOCK)
            add_nodes(p, d, first, n - first < FF_BLOCK ? n - first : FF_BLOCK, few->weight[i], slot, t);
    }
}

/* Means of lanes [n], gathered before. */
static void sum(const ff_averaging *a, const ff_prepared *p, int level, size_t n, ff_average_work *t)
{
    if (level < FF_LEVEL_MAPPED)
        sum_lanes(a, p, level, n, t);
    else
        for (size_t k = 0; k < n; k++) {
            if (k == 0) make_frames(n, t);
            sum_mapped(a, p, level, k, t);
        }
}

/* ---- how many are needed ---------------------------------------------------------------------------- */

/* A lobe that is narrower than this part of the aperture begins with nodes that crowd on it: others may all miss it. */
#define NARROW 0.7

/* The level at which a pair begins, and whether a bound says that it may end there. A function that halves over w differs from its
 * mean over a disc of radius R by (R/w)^2 at most about its peak, and by that times the square of the distance in w where it falls
 * as a Gaussian, which of all profiles falls fastest; masking, Fresnel and the bases vary over the cosines. */
static int first_level(const ff_averaging *a, const ff_dirs *w, size_t i, int *ends, ff_average_work *t)
{
    const double wi[3] = {w->wix[i], w->wiy[i], w->wiz[i]}, wo[3] = {w->wox[i], w->woy[i], w->woz[i]};
    const sight seen = a->rules->crowds ? look(a, wi, wo) : look(a, wo, wi);
    const double lower = fmin(wi[2], wo[2]), across = a->rules->reach / lower;
    t->ratio[i] = 0.5 * sqrt(seen.stretch / (1 + seen.view.c));
    t->cut[i] = lower < sin(fmin(2 * a->rules->reach, 1));
    *ends = seen.bound + 2 * across * across < a->rules->tolerance;
    return seen.reached && seen.stretch > NARROW * NARROW ? FF_LEVEL_MAPPED : FF_LEVEL_CENTRE;
}

/* By the logarithm of the range of the values at the nodes: a guess at the ratio by which the terms of a series about the centre
 * fall. A power law x^-4 at a distance of four radii has 1/4. */
static double term_ratio(const ff_average_work *t, size_t k)
{
    double most = 0;
    for (size_t c = 0; c < t->n_channels; c++) {
        const double lo = t->least[c * FF_BLOCK + k], hi = t->most[c * FF_BLOCK + k];
        if (hi == lo) continue;
        most = fmax(most, lo > 0 ? 0.25 * log(hi / lo) : INFINITY);
    }
    return most;
}

static double difference(const ff_average_work *t, size_t k, size_t lane)
{
    double most = 0;
    for (size_t c = 0; c < t->n_channels; c++) {
        const double now = t->now[c * FF_BLOCK + k], before = t->before[c * FF_BLOCK + lane];
        if (now != before) most = fmax(most, fabs(now - before) / fabs(now));
    }
    return most;
}

#define AGREED 0.5 /* the part of the tolerance that two levels may differ by: the next has an error too */
#define CUT    10  /* times that near the horizon, which leaves an edge: sums converge as a power of their nodes there */

/* Does the level before suffice? Two that agree by chance are told by how much the values vary over the nodes. */
static int suffices(const ff_averaging *a, const ff_average_work *t, int level, size_t k, size_t lane)
{
    if (!(t->error[lane] <= AGREED * a->rules->tolerance)) return 0;
    if (level >= FF_LEVEL_MAPPED) return 1;
    const double ratio = fmax(term_ratio(t, k), t->ratio[lane]);
    const int of_detector = a->rules->detector[level - 1].degree, of_source = a->rules->source[level - 1].degree,
              degree = of_detector > of_source ? of_detector : of_source; /* a point has 1 */
    return pow(ratio, degree + 2) <= a->rules->tolerance;
}

static void keep(const ff_average_work *t, const double *from, size_t k, double *to, size_t lane)
{
    for (size_t c = 0; c < t->n_channels; c++) to[c * FF_BLOCK + lane] = from[c * FF_BLOCK + k];
}

/* Lanes that take part in a level. */
static size_t lanes_at(const ff_average_work *t, size_t n, int level, unsigned char *lane)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++)
        if (!t->done[i] && t->start[i] <= level) lane[count++] = (unsigned char)i;
    return count;
}

int ff_average_centres_do(const ff_averaging *a, const ff_dirs *w, size_t n, ff_average_work *t)
{
    int ends = 1;
    for (size_t i = 0; i < n && ends; i++)
        if (w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN) (void)first_level(a, w, i, &ends, t);
    return ends;
}

void ff_average_choose(const ff_averaging *a, const ff_dirs *w, size_t n, ff_average_work *t)
{
    int single[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        const int up = w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN;
        t->level[i] = FF_LEVEL_CENTRE;
        t->error[i] = 0;
        t->done[i] = !up;
        if (up)
            t->start[i] = (unsigned char)first_level(a, w, i, &single[i], t);
        else
            for (size_t c = 0; c < t->n_channels; c++) t->f[c * FF_BLOCK + i] = 0;
    }
    for (int level = 0; level < a->rules->n_levels; level++) {
        const size_t count = lanes_at(t, n, level, t->lane);
        if (!count) continue;
        gather(w, count, t);
        sum(a, &a->values, level, count, t);
        for (size_t k = 0; k < count; k++) {
            const size_t i = t->lane[k];
            const int begins = level == t->start[i];
            if (!begins) t->error[i] = difference(t, k, i) * (t->cut[i] ? CUT : 1);
            t->done[i] = begins ? level == FF_LEVEL_CENTRE && single[i] : suffices(a, t, level, k, i);
            if (begins && t->done[i]) t->error[i] = 0;
            t->level[i] = (unsigned char)(t->done[i] && !begins ? level - 1 : level);
            if (t->done[i] && !begins)
                keep(t, t->before, i, t->f, i);
            else {
                keep(t, t->now, k, t->before, i);
                keep(t, t->now, k, t->f, i);
            }
        }
    }
}

void ff_average_at(const ff_averaging *a, const ff_dirs *w, size_t n, const unsigned char *level, ff_average_work *t)
{
    const ff_prepared *p = a->prepared;
    const size_t P = columns_of(p);
    memset(t->f, 0, t->n_channels * FF_BLOCK * sizeof *t->f);
    memset(t->df, 0, t->n_channels * P * FF_BLOCK * sizeof *t->df);
    for (int at = 0; at < FF_LEVELS; at++) {
        size_t count = 0;
        for (size_t i = 0; i < n; i++)
            if (level[i] == at && w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN) t->lane[count++] = (unsigned char)i;
        if (!count) continue;
        gather(w, count, t);
        sum(a, p, at, count, t);
        for (size_t k = 0; k < count; k++) {
            const size_t i = t->lane[k];
            keep(t, t->now, k, t->f, i);
            for (size_t q = 0; q < t->n_channels * P; q++) t->df[q * FF_BLOCK + i] = t->dnow[q * FF_BLOCK + k];
        }
    }
}
