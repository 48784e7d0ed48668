/* What the samples of a table stand for, and the means of cells over it: by points of a sequence that fills the box around a sample
 * evenly, the same for all samples. */
#include "internal_node_means.h"
#include "models/model_struct.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

enum { POINTS = 64, ENOUGH = 16, DIMENSIONS = 5, TURN = 4 }; /* enough: where all are in one cell */

typedef enum kind { POINT, MERL, AXES, KEPT } kind;

/* How far the weight of a node reaches down and up, where it is 0. */
typedef struct reach {
    double down, up;
} reach;

struct ff_node_means {
    const ff_table *from, *to;
    kind kind;                     /* of to: how it says what is around a sample */
    int turns;                     /* to does not know the azimuth of incidence, from does */
    int folded;                    /* azimuths of both signs are one                       */
    int exchanged;                 /* the azimuth of the difference and that of light and detector exchanged are one */
    reach *around[4];              /* [n of the axis], radians; NULL: not an axis of more than one node              */
    double at[POINTS][DIMENSIONS]; /* along the axes, and around the normal */
    double turned[POINTS][2];      /* cosine and sine of the latter          */
};

/* ---- points ---------------------------------------------------------------------------------- */

/* Sobol's first two coordinates of point k, in the middle of their strata: all points are evenly spaced along either, and so is the
 * first half of them; an edge along it is seen where it is. */
static double sobol(int second, unsigned k)
{
    unsigned x = 0, v = POINTS / 2;
    for (; k > 0; k /= 2, v = second ? v ^ v / 2 : v / 2)
        if (k % 2) x ^= v;
    return (x + 0.5) / POINTS;
}

/* Two dimensions, those of the exit where there are such, by Sobol's sequence; the others by the additive recurrence of Roberts
 * 2018, whose steps are powers of the root of x^(d+1) = x + 1. */
static void spread(const int used[DIMENSIONS], double at[POINTS][DIMENSIONS])
{
    double root = 1.2;
    int d = -2, found = 0;
    for (int j = 0; j < DIMENSIONS; j++) d += used[j];
    for (int k = 0; k < 60 && d > 0; k++) root = pow(1 + root, 1 / (d + 1.0));
    for (int n = 0; n < DIMENSIONS; n++) {
        const int j = n < TURN ? TURN - 1 - n : TURN;
        for (int k = 0; k < POINTS; k++) {
            const double x = 0.5 + (k + 1) * pow(root, 1 - found);
            at[k][j] = !used[j] ? 0.5 : found < 2 ? sobol(found, (unsigned)k) : x - floor(x);
        }
        found += used[j];
    }
}

/* Where a number in [0, 1) goes by a weight that falls linearly to 0 on both sides. */
static double under_hat(double u, reach r)
{
    const double all = r.down + r.up, below = u * all;
    if (!(all > 0)) return 0;
    if (below < r.down) return r.down * (sqrt(below / r.down) - 1);
    return r.up * (1 - sqrt((all - below) / r.up));
}

/* A point around a sample: directions, what the value there weighs, and its share in the sum that the value is divided by. */
typedef struct place {
    double wi[3], wo[3], weight, share;
} place;

static void unit(double theta, double phi, double w[3])
{
    w[0] = sin(theta) * cos(phi);
    w[1] = sin(theta) * sin(phi);
    w[2] = cos(theta);
}

/* Ry(theta), then Rz(phi). */
static void tilt(double theta, double phi, double w[3])
{
    const double c = cos(theta), s = sin(theta), x = c * w[0] + s * w[2], a = cos(phi), b = sin(phi), y = w[1];
    w[2] = c * w[2] - s * w[0];
    w[0] = a * x - b * y;
    w[1] = b * x + a * y;
}

/* The directions of a point q of axes, radians, by the formulas of axes.c without the way through angles; measure: of the solid
 * angles, per element of q. */
static void place_at(ff_axes_kind kind, const double q[4], double measure, place *p)
{
    if (kind == FF_AXES_HALF_DIFFERENCE) {
        unit(q[2], q[3], p->wi);
        for (int k = 0; k < 3; k++) p->wo[k] = k < 2 ? -p->wi[k] : p->wi[k];
        tilt(q[0], q[1], p->wi);
        tilt(q[0], q[1], p->wo);
    } else if (kind == FF_AXES_SPECULAR) {
        unit(q[1], -pi / 2 - q[0], p->wi);
        unit(q[3], q[2] + pi, p->wo);
        tilt(q[1], pi / 2 - q[0], p->wo);
    } else {
        unit(q[0], q[1], p->wi);
        unit(q[2], q[3], p->wo);
    }
    p->weight = p->share = fabs(measure) * fmax(p->wo[2], 0);
}

/* Node h covers h^2/90 .. (h+1)^2/90 degrees of theta_h, the others a degree; phi_d and phi_d + 180 degrees are one. */
static void place_merl(size_t i, int k, const double u[DIMENSIONS], place *p)
{
    const size_t half = i / 16200;
    const double degree = pi / 180, h = (double)half + u[0];
    const double d = (double)(i / 180 % 90) + u[1], phi = (double)(i % 180) + u[2] + 180 * (k % 2);
    const double q[4] = {h * h / 90 * degree, 0, d * degree, phi * degree};
    place_at(FF_AXES_HALF_DIFFERENCE, q, h * sin(q[0]) * sin(q[2]) * cos(q[2]), p);
}

static void place_on_axes(const ff_node_means *m, size_t i, int k, const double u[DIMENSIONS], place *p)
{
    const ff_axes *a = &m->to->axes;
    double q[4];
    for (int j = 4; j-- > 0; i /= a->n[j]) {
        const size_t node = i % a->n[j];
        q[j] = a->node[j][node] * m->to->radians_per_unit;
        if (m->around[j]) q[j] += under_hat(u[j], m->around[j][node]);
    }
    if (a->kind == FF_AXES_HALF_DIFFERENCE) {
        if (m->exchanged && k % 2) q[3] += pi;
        place_at(a->kind, q, sin(q[0]) * sin(q[2]) * cos(q[2]), p);
    } else if (a->kind == FF_AXES_SPECULAR) {
        if (m->folded && k % 2) q[2] = -q[2];
        place_at(a->kind, q, sin(q[3]), p);
    } else {
        place_at(a->kind, q, sin(q[2]), p);
    }
}

static void turn(const double by[2], double w[3])
{
    const double x = w[0];
    w[0] = by[0] * x - by[1] * w[1];
    w[1] = by[1] * x + by[0] * w[1];
}

/* ---- what nodes stand for -------------------------------------------------------------------- */

static int is_azimuth(ff_axes_kind kind, int k)
{
    return kind == FF_AXES_SPECULAR ? k == 0 || k == 2 : k % 2;
}

static int is_incidence(ff_axes_kind kind, int k)
{
    return kind != FF_AXES_HALF_DIFFERENCE && k < 2;
}

/* From the last node to the first of the next turn; 0: the nodes do not go around. */
static double gap_of(const double *node, size_t n, double unit, double period)
{
    const double gap = node[0] * unit + period - node[n - 1] * unit, step = (node[1] - node[0]) * unit;
    if (fabs(gap) < 1e-9) return (node[n - 1] - node[n - 2]) * unit; /* the first comes again as the last */
    return gap > 0 && gap < 1.5 * step ? gap : 0;
}

/* Beyond the outer nodes: the next turn; as far as inward, within the angles that there are; nothing about the specular direction,
 * where readers do not look. */
static reach outward(const ff_node_means *m, int k, double gap)
{
    const ff_axes *a = &m->to->axes;
    const double unit = m->to->radians_per_unit, *node = a->node[k];
    const size_t n = a->n[k];
    reach r = {(node[1] - node[0]) * unit, (node[n - 1] - node[n - 2]) * unit};
    if (gap > 0) r.down = r.up = gap;
    if (is_azimuth(a->kind, k)) return r;
    if (a->kind == FF_AXES_SPECULAR && k == 3) return (reach){0, 0};
    return (reach){fmin(r.down, fmax(node[0] * unit, 0)), fmin(r.up, fmax(pi / 2 - node[n - 1] * unit, 0))};
}

static int measure_axis(ff_node_means *m, int k)
{
    const ff_axes *a = &m->to->axes;
    const size_t n = a->n[k];
    const double unit = m->to->radians_per_unit, *node = a->node[k];
    if (n < 2 || is_incidence(a->kind, k)) return 1; /* incidences stand for themselves */
    if (!(m->around[k] = malloc(n * sizeof(reach)))) return 0;
    double gap = is_azimuth(a->kind, k) ? gap_of(node, n, unit, 2 * pi) : 0;
    if (a->kind == FF_AXES_HALF_DIFFERENCE && k == 3 && gap == 0) gap = gap_of(node, n, unit, pi), m->exchanged = gap > 0;
    if (a->kind == FF_AXES_SPECULAR && k == 2)
        m->folded = m->to->isotropic && fabs(node[0]) < 1e-9 && fabs(node[n - 1] * unit - pi) < 1e-9;
    const reach out = outward(m, k, gap);
    for (size_t i = 0; i < n; i++) {
        reach *r = &m->around[k][i];
        *r = (reach){i ? (node[i] - node[i - 1]) * unit : out.down, i + 1 < n ? (node[i + 1] - node[i]) * unit : out.up};
    }
    return 1;
}

ff_node_means *ff_node_means_new(const ff_table *from, const ff_table *to)
{
    ff_node_means *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->kind = to->grid == &ff_grid_merl ? MERL : to->axes.kind != FF_AXES_NONE ? AXES : to->kept_around ? KEPT : POINT;
    m->from = from;
    m->to = to;
    m->turns = !from->isotropic && (to->isotropic || m->kind == MERL);
    const int merl = m->kind == MERL, kept = m->kind == KEPT;
    int measured = 1, used[DIMENSIONS] = {merl, merl, merl || kept, kept, m->turns};
    for (int k = 0; k < 4 && m->kind == AXES; k++) {
        measured = measured && measure_axis(m, k);
        used[k] = m->around[k] != NULL;
    }
    spread(used, m->at);
    for (int k = 0; k < POINTS; k++)
        for (int j = 0; j < 2; j++) m->turned[k][j] = j ? sin(2 * pi * m->at[k][TURN]) : cos(2 * pi * m->at[k][TURN]);
    if (measured) return m;
    ff_node_means_free(m);
    return NULL;
}

void ff_node_means_free(ff_node_means *m)
{
    for (int k = 0; k < 4 && m; k++) free(m->around[k]);
    free(m);
}

int ff_node_means_is_wide(const ff_node_means *m)
{
    return m->turns || m->kind != POINT;
}

/* ---- means ----------------------------------------------------------------------------------- */

/* Points around sample i in a file with a warp of its own. */
static int places_kept(const ff_node_means *m, size_t i, const double wi[3], place p[POINTS])
{
    double by[POINTS][2], wo[POINTS][3], weight[POINTS];
    const reach one = {1, 1};
    for (int k = 0; k < POINTS; k++)
        for (int j = 0; j < 2; j++) by[k][j] = under_hat(m->at[k][2 + j], one);
    if (!m->to->kept_around(m->to->kept, i, POINTS, (const double(*)[2])by, wo, weight)) return 0;
    for (int k = 0; k < POINTS; k++)
        p[k] = (place){{wi[0], wi[1], wi[2]}, {wo[k][0], wo[k][1], wo[k][2]}, weight[k], weight[k] > 0};
    return 1;
}

static void place_around(const ff_node_means *m, size_t i, int k, place *p)
{
    if (m->kind == MERL)
        place_merl(i, k, m->at[k], p);
    else
        place_on_axes(m, i, k, m->at[k], p);
}

/* The sum of the values at the places, and what it is to be divided by. */
typedef struct sum {
    const ff_node_means *m;
    double *value, all;
    size_t stride, cell; /* cell: the last one       */
    int same;            /* in which all places were */
    size_t n_sides;      /* of the incidence; 0: not known yet, or another at every place */
    ff_cells_side side[FF_CELLS_SIDES];
} sum;

static void add_cell(sum *s, const double wi[3], const place *p, double weight)
{
    const ff_table *t = s->m->from;
    const int above = p->weight > 0 && wi[2] > FF_COS_MIN && p->wo[2] > FF_COS_MIN;
    const size_t cell = above ? t->cells->find(t->cells, wi, p->wo) : SIZE_MAX;
    s->same = s->same && above && (s->all == 0 || cell == s->cell);
    s->cell = cell;
    if (cell == SIZE_MAX || !ff_table_is_measured(t, cell)) return;
    s->all += weight * p->share;
    for (size_t c = 0; c < t->n_channels; c++)
        s->value[c * s->stride] += weight * p->weight * t->channels[c].scale * t->value[c * t->n + cell];
}

/* On both sides of a border between cells of incidence; nodes of half and difference angles are spread over incidences anyway. */
static void add_place(sum *s, const place *p)
{
    if (s->m->kind == MERL || s->m->to->axes.kind == FF_AXES_HALF_DIFFERENCE) {
        add_cell(s, p->wi, p, 1);
        return;
    }
    if (s->n_sides == 0 || s->m->turns) s->n_sides = ff_cells_sides(s->m->from->cells, p->wi, s->side);
    for (size_t k = 0; k < s->n_sides; k++) add_cell(s, s->side[k].wi, p, s->side[k].weight);
}

int ff_node_means_at(const ff_node_means *m, size_t i, const double wi[3], const double wo[3], double *value, size_t stride)
{
    const place here = {{wi[0], wi[1], wi[2]}, {wo[0], wo[1], wo[2]}, 1, 1};
    place p[POINTS];
    sum s = {.m = m, .value = value, .stride = stride, .same = 1};
    if (m->kind == KEPT && !places_kept(m, i, wi, p)) return 0;
    for (size_t c = 0; c < m->from->n_channels; c++) value[c * stride] = 0;
    for (int k = 0; k < POINTS && !(k == ENOUGH && s.same && m->kind != KEPT); k++) {
        if (m->kind == POINT)
            p[k] = here;
        else if (m->kind != KEPT)
            place_around(m, i, k, &p[k]);
        if (m->turns) turn(m->turned[k], p[k].wi), turn(m->turned[k], p[k].wo);
        add_place(&s, &p[k]);
    }
    for (size_t c = 0; c < m->from->n_channels && s.all > 0; c++) value[c * stride] /= s.all;
    return s.all > 0;
}
