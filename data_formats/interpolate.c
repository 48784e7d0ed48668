/* Interpolation between the samples of a table; ff_interpolate.h has the method. */
#include "ff_interpolate.h"
#include "ff_model.h"
#include "internal_neighbours.h"
#include "internal_table.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;
static const double degrees = 180 / 3.14159265358979323846;
static const double same = 1e-6; /* degrees: directions of files are rounded */

/* Samples at one incident direction. */
typedef struct slice {
    double theta_i, phi_i; /* degrees; phi_i only where the table is not isotropic */
    ff_neighbours *tree;
} slice;

/* One axis of a product of nodes, radians. */
typedef struct axis {
    size_t n;
    double *node;
    double period; /* 0: none; then a coordinate outside the nodes is beyond the data        */
    int folded;    /* nodes from 0 to pi of an azimuth whose sign makes no difference          */
    int open;      /* one node only: the coordinate makes no difference                        */
    int centred;   /* nodes are centres of cells: the outer half of the last one is no gap     */
} axis;

typedef enum method { PRODUCT, SLICES, SCATTERED } method;

struct ff_interpolant {
    const ff_table *t;
    method method;
    int mirrored;      /* the table is isotropic and has one side of the plane of incidence only */
    ff_axes_kind kind; /* PRODUCT             */
    axis axis[4];
    size_t n_slices;     /* SLICES              */
    slice *slice;        /* by theta_i, phi_i   */
    ff_neighbours *tree; /* SCATTERED         */
};

/* ---- products of axes ------------------------------------------------------------------------ */

static int is_azimuth(ff_axes_kind kind, int k)
{
    return kind == FF_AXES_SPECULAR ? k == 0 || k == 2 : k % 2;
}

/* Joins the ends of an azimuth whose nodes go once around, which for the difference angle may be half a turn by reciprocity. */
static void close_azimuth(axis *a, ff_axes_kind kind, int k, int isotropic)
{
    if (a->n < 2) return;
    const double first = a->node[0], last = a->node[a->n - 1], step = a->node[1] - first;
    if (fabs(last - first - 2 * pi) < 1e-9 || fabs(last + step - first - 2 * pi) < 1e-9) {
        a->period = 2 * pi;
    } else if (kind == FF_AXES_HALF_DIFFERENCE && k == 3 && fabs(last + step - first - pi) < 1e-9) {
        a->period = pi;
    } else if (kind == FF_AXES_SPECULAR && k == 2 && isotropic && fabs(first) < 1e-9 && fabs(last - pi) < 1e-9) {
        a->folded = 1;
    }
}

static int new_axis(axis *a, size_t n, const double *node, double unit)
{
    a->n = n;
    a->node = malloc(n * sizeof *a->node);
    if (!a->node) return 0;
    for (size_t i = 0; i < n; i++) a->node[i] = node[i] * unit;
    for (size_t i = 1; i < n; i++)
        if (!(a->node[i] > a->node[i - 1])) return -1; /* not in order: regression does not mind */
    return 1;
}

/* The nodes of the MERL grid, from its own directions: theta_h, theta_d and phi_d at which its samples lie. */
static int merl_axes(ff_interpolant *p)
{
    enum { ROW = 180, SHEET = 90 * 180 };
    static const size_t stride[4] = {SHEET, 0, ROW, 1}, count[4] = {90, 1, 90, 180};
    p->kind = FF_AXES_HALF_DIFFERENCE;
    for (int k = 0; k < 4; k++) {
        double node[180];
        for (size_t i = 0; i < count[k]; i++) {
            double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5}, q[4];
            const size_t base = k == 3 ? 45 * ROW : 0; /* far from where phi_d is undetermined */
            ff_grid_merl.directions(base + i * stride[k], 1, planes);
            ff_axes_point(FF_AXES_HALF_DIFFERENCE, w, w + 3, q);
            node[i] = k == 1 ? 0 : q[k];
        }
        if (new_axis(&p->axis[k], count[k], node, 1) != 1) return 0;
    }
    p->axis[0].centred = p->axis[2].centred = 1;
    p->axis[1].open = 1;
    p->axis[3].period = pi;
    return 1;
}

/* 1 when the table is a product that this file interpolates along its axes; 0 when it is not; -1 without memory. */
static int find_axes(ff_interpolant *p)
{
    const ff_table *t = p->t;
    if (t->grid == &ff_grid_merl) return merl_axes(p) ? 1 : -1;
    p->kind = t->axes.kind;
    if (t->grid || (p->kind != FF_AXES_HALF_DIFFERENCE && p->kind != FF_AXES_SPECULAR)) return 0;
    for (int k = 0; k < 4; k++) {
        const int made = new_axis(&p->axis[k], t->axes.n[k], t->axes.node[k], t->radians_per_unit);
        if (made != 1) return made == 0 ? -1 : 0;
        p->axis[k].centred = p->kind == FF_AXES_HALF_DIFFERENCE && !is_azimuth(p->kind, k);
        if (is_azimuth(p->kind, k)) close_azimuth(&p->axis[k], p->kind, k, t->isotropic);
    }
    const int turns = p->kind == FF_AXES_SPECULAR ? 0 : 1; /* the axis that turns the sample */
    if (p->axis[turns].n == 1) {
        if (!t->isotropic) return 0;
        p->axis[turns].open = 1;
    }
    return 1;
}

/* Nodes on both sides of x and the weight of the upper one; 0 when x is outside of them (then the nearest, twice). */
static int bracket(const axis *a, double x, size_t index[2], double *weight)
{
    index[0] = index[1] = 0;
    *weight = 0;
    if (a->open) return 1;
    if (a->folded) x = fabs(x);
    const double first = a->node[0], last = a->node[a->n - 1];
    if (a->period > 0) x -= a->period * floor((x - first) / a->period);
    if (fabs(x - first) < 1e-9) x = first; /* angles come back from directions with their rounding */
    if (fabs(x - last) < 1e-9) x = last;
    if (x < first || x > last) {
        const double gap = a->period > 0 ? first + a->period - last : 0, past = x - last;
        index[0] = index[1] = x > last ? a->n - 1 : 0;
        if (a->period > 0 && gap > 0) { /* between the last node and the first of the next turn */
            index[1] = 0;
            *weight = past / gap;
            return 1;
        }
        const double edge = x > last ? past : first - x;
        const double cell = a->n < 2 ? 0 : x > last ? last - a->node[a->n - 2] : a->node[1] - first;
        return a->centred && edge <= cell / 2 + 1e-12;
    }
    size_t lo = 0, hi = a->n - 1;
    while (hi - lo > 1) {
        const size_t middle = (lo + hi) / 2;
        if (a->node[middle] <= x)
            lo = middle;
        else
            hi = middle;
    }
    index[0] = lo;
    index[1] = hi;
    if (hi > lo) *weight = (x - a->node[lo]) / (a->node[hi] - a->node[lo]);
    return 1;
}

static ff_found product_at(const ff_interpolant *p, const double wi[3], const double wo[3], double *value, size_t stride)
{
    const ff_table *t = p->t;
    double q[4], upper[4], sum_weight = 0, valid_weight = 0;
    size_t index[4][2];
    int inside = 1;
    ff_axes_point(p->kind, wi, wo, q);
    for (int k = 0; k < 4; k++) inside &= bracket(&p->axis[k], q[k], index[k], &upper[k]);
    for (size_t c = 0; c < t->n_channels; c++) value[c * stride] = 0;
    double whole = 0;
    for (int corner = 0; corner < 16; corner++) {
        double w = 1;
        size_t i = 0;
        for (int k = 0; k < 4; k++) {
            const int side = corner >> k & 1;
            w *= side ? upper[k] : 1 - upper[k];
            i = i * p->axis[k].n + index[k][side];
        }
        if (w <= 0) continue;
        sum_weight += w;
        if (!t->valid[i]) continue;
        valid_weight += w;
        whole = fmax(whole, w);
        for (size_t c = 0; c < t->n_channels; c++) value[c * stride] += w * t->channels[c].scale * t->value[c * t->n + i];
    }
    if (!(valid_weight > 0)) return FF_FOUND_BEYOND;
    for (size_t c = 0; c < t->n_channels; c++) value[c * stride] /= valid_weight;
    if (!inside || valid_weight < 0.5 * sum_weight) return FF_FOUND_BEYOND;
    return whole > 1 - 1e-9 ? FF_FOUND_SAMPLE : FF_FOUND_BETWEEN;
}

/* ---- regression over neighbours ------------------------------------------------------------ */

enum { TERMS = 6 };

/* Terms of the polynomial at an offset: of second degree in the plane, of first in more dimensions. Their number. */
static int terms(int dim, const double *offset, double out[TERMS])
{
    out[0] = 1;
    for (int k = 0; k < dim; k++) out[k + 1] = offset[k];
    if (dim > 2) return dim + 1;
    out[3] = offset[0] * offset[0];
    out[4] = offset[0] * offset[1];
    out[5] = offset[1] * offset[1];
    return TERMS;
}

/* Solves a x = b for a symmetric positive definite a of m rows, in place. */
static void solve(int m, double a[TERMS][TERMS], double b[TERMS])
{
    for (int k = 0; k < m; k++)
        for (int i = k + 1; i < m; i++) {
            const double f = a[i][k] / a[k][k];
            for (int j = k; j < m; j++) a[i][j] -= f * a[k][j];
            b[i] -= f * b[k];
        }
    for (int k = m - 1; k >= 0; k--) {
        for (int j = k + 1; j < m; j++) b[k] -= a[k][j] * b[j];
        b[k] /= a[k][k];
    }
}

/* The shares with which the neighbours' values make up the value at x: that of the weighted polynomial through them. */
static void fitted_shares(int dim, const double *x, size_t n, const ff_neighbour *near, double *share)
{
    const double reach = 1.05 * sqrt(near[n - 1].distance2);
    double a[TERMS][TERMS] = {{0}}, b[TERMS] = {1}, row[FF_NEIGHBOURS_MOST][TERMS], w[FF_NEIGHBOURS_MOST], offset[4];
    int m = 0;
    for (size_t j = 0; j < n; j++) {
        const double r = sqrt(near[j].distance2) / reach, u = 1 - r * r * r;
        w[j] = u * u * u;
        for (int k = 0; k < dim; k++) offset[k] = (near[j].point[k] - x[k]) / reach;
        m = terms(dim, offset, row[j]);
        for (int i = 0; i < m; i++)
            for (int k = 0; k < m; k++) a[i][k] += w[j] * row[j][i] * row[j][k];
    }
    for (int k = 1; k < m; k++) a[k][k] += (k <= dim ? 1e-4 : 1e-3) * a[0][0]; /* no slope where the neighbours show none */
    solve(m, a, b);
    for (size_t j = 0; j < n; j++) {
        share[j] = 0;
        for (int k = 0; k < m; k++) share[j] += b[k] * row[j][k];
        share[j] *= w[j];
    }
}

/* Mean of the samples at one place, without one. */
static double value_of(const ff_table *t, size_t c, const ff_neighbour *place, uint32_t without)
{
    double sum = 0;
    size_t n = 0;
    for (size_t k = 0; k < place->n_samples; k++) {
        if (place->sample[k] == without) continue;
        sum += t->value[c * t->n + place->sample[k]];
        n++;
    }
    return t->channels[c].scale * sum / (double)n;
}

/* One channel from its neighbours: by logarithms where all are positive, within their range. */
static double combine(const ff_table *t, size_t c, size_t n, const ff_neighbour *near, uint32_t without, const double *share)
{
    double v[FF_NEIGHBOURS_MOST], lo = INFINITY, hi = -INFINITY, plain = 0, logs = 0;
    for (size_t j = 0; j < n; j++) {
        v[j] = value_of(t, c, &near[j], without);
        lo = fmin(lo, v[j]);
        hi = fmax(hi, v[j]);
    }
    for (size_t j = 0; j < n; j++) {
        plain += share[j] * v[j];
        if (lo > 0) logs += share[j] * log(v[j]);
    }
    return fmin(fmax(lo > 0 ? exp(logs) : plain, lo), hi);
}

/* 1 when all the neighbours lie to one side of x and not close, measured by their own spread. */
static int is_beyond(int dim, const double *x, size_t n, const ff_neighbour *near)
{
    double mean[4] = {0};
    for (size_t j = 0; j < n; j++)
        for (int k = 0; k < dim; k++) mean[k] += near[j].point[k] - x[k];
    for (size_t j = 0; j < n; j++) {
        double along = 0;
        for (int k = 0; k < dim; k++) along += mean[k] * (near[j].point[k] - x[k]);
        if (along <= 0) return 0;
    }
    return sqrt(near[0].distance2) > 0.3 * sqrt(near[n - 1].distance2);
}

/* The neighbours to make a value of. Where the nearest all lie to one side (a row of samples close together), more are asked. */
static size_t neighbours_around(const ff_neighbours *tree, int dim, const double *x, uint32_t without, ff_neighbour *near,
                                ff_found *found)
{
    size_t n = ff_neighbours_find(tree, x, FF_INTERPOLATE_NEIGHBOURS, without, near);
    *found = FF_FOUND_BEYOND;
    if (n == 0) return 0;
    *found = FF_FOUND_SAMPLE;
    if (near[0].distance2 < same * same) return 1;
    *found = FF_FOUND_BETWEEN;
    if (!is_beyond(dim, x, n, near)) return n;
    n = ff_neighbours_find(tree, x, FF_NEIGHBOURS_MOST, without, near);
    if (!is_beyond(dim, x, n, near)) return n;
    *found = FF_FOUND_BEYOND;
    return 1;
}

/* The value at x of the samples in one tree. */
static ff_found regress(const ff_table *t, const ff_neighbours *tree, int dim, const double *x, uint32_t without, double *value,
                        size_t stride)
{
    ff_neighbour near[FF_NEIGHBOURS_MOST];
    double share[FF_NEIGHBOURS_MOST];
    ff_found found;
    const size_t n = neighbours_around(tree, dim, x, without, near, &found);
    share[0] = 1;
    if (n > 1) fitted_shares(dim, x, n, near, share);
    for (size_t c = 0; c < t->n_channels; c++) value[c * stride] = n ? combine(t, c, n, near, without, share) : 0;
    return found;
}

/* ---- one pair of directions in the coordinates of each method -------------------------------- */

/* Half vector seen from an incident direction at azimuth 0 where the table is isotropic, else as it is. */
static void in_slice(int isotropic, const double wi[3], const double wo[3], double *theta_i, double *phi_i, double x[2])
{
    double q[4];
    const double h[3] = {wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    ff_axes_point(FF_AXES_INCIDENT_EXIT, wi, h, q);
    const double turn = isotropic ? q[1] : 0;
    *theta_i = degrees * q[0];
    *phi_i = isotropic ? 0 : degrees * q[1];
    x[0] = degrees * q[2] * cos(q[3] - turn);
    x[1] = degrees * q[2] * sin(q[3] - turn);
}

/* The coordinates of scattered samples; their number. */
static int in_space(int isotropic, const double wi[3], const double wo[3], double x[4])
{
    double q[4];
    ff_axes_point(FF_AXES_HALF_DIFFERENCE, wi, wo, q);
    const double h = FF_INTERPOLATE_HALF_SCALE * degrees * q[0], d = degrees * q[2];
    if (isotropic) {
        x[0] = h * cos(q[3]);
        x[1] = -h * sin(q[3]);
        x[2] = d;
        return 3;
    }
    x[0] = h * cos(q[1]);
    x[1] = h * sin(q[1]);
    x[2] = d * cos(q[3] + q[1]);
    x[3] = d * sin(q[3] + q[1]);
    return 4;
}

/* Calls visit for every measured sample above the horizon. */
typedef void visitor(void *context, size_t i, const double wi[3], const double wo[3]);
static void each_usable(const ff_table *t, visitor *visit, void *context)
{
    enum { BLOCK = 512 };
    double plane[6][BLOCK], *const planes[6] = {plane[0], plane[1], plane[2], plane[3], plane[4], plane[5]};
    for (size_t first = 0; first < t->n; first += BLOCK) {
        const size_t count = t->n - first < BLOCK ? t->n - first : BLOCK;
        ff_table_directions(t, first, count, planes);
        for (size_t k = 0; k < count; k++) {
            const double wi[3] = {plane[0][k], plane[1][k], plane[2][k]}, wo[3] = {plane[3][k], plane[4][k], plane[5][k]};
            if (t->valid[first + k] && wi[2] > FF_COS_MIN && wo[2] > FF_COS_MIN) visit(context, first + k, wi, wo);
        }
    }
}

/* The sides of the plane of incidence that have samples. */
typedef struct sides {
    int left, right;
} sides;

static void look_aside(void *context, size_t i, const double wi[3], const double wo[3])
{
    sides *s = context;
    const double across = wi[0] * wo[1] - wi[1] * wo[0];
    (void)i;
    s->left |= across > 1e-6;
    s->right |= across < -1e-6;
}

static int is_one_sided(const ff_table *t)
{
    sides s = {0, 0};
    if (!t->isotropic) return 0;
    each_usable(t, look_aside, &s);
    return s.left != s.right;
}

/* ---- samples in slices of one incident direction --------------------------------------------- */

enum { LEAST_IN_SLICE = 12, MOST_SLICES = 4096 };
static const double same_incidence = 1e-4; /* degrees */

/* A sample on its way into a slice. */
typedef struct placed {
    double theta_i, phi_i, x[2];
    uint32_t sample;
} placed;

typedef struct placing {
    int isotropic, mirrored;
    size_t n;
    placed *at;
} placing;

static void place(void *context, size_t i, const double wi[3], const double wo[3])
{
    placing *p = context;
    placed *s = &p->at[p->n++];
    in_slice(p->isotropic, wi, wo, &s->theta_i, &s->phi_i, s->x);
    if (s->theta_i < same_incidence) s->phi_i = 0; /* the same direction at every azimuth */
    s->theta_i = round(s->theta_i / same_incidence) * same_incidence;
    s->phi_i = round(s->phi_i / same_incidence) * same_incidence;
    if (s->phi_i <= -180) s->phi_i += 360;
    s->sample = (uint32_t)i;
    if (!p->mirrored) return;
    p->at[p->n] = *s;
    p->at[p->n++].x[1] *= -1;
}

static int by_incidence(const void *a, const void *b)
{
    const placed *p = a, *q = b;
    if (p->theta_i != q->theta_i) return p->theta_i < q->theta_i ? -1 : 1;
    if (p->phi_i != q->phi_i) return p->phi_i < q->phi_i ? -1 : 1;
    return (p->sample > q->sample) - (p->sample < q->sample);
}

static size_t slice_end(const placing *p, size_t first)
{
    size_t end = first;
    while (end < p->n && p->at[end].theta_i == p->at[first].theta_i && p->at[end].phi_i == p->at[first].phi_i) end++;
    return end;
}

static int new_slice(slice *s, const placed *at, size_t n)
{
    double *point = malloc(2 * n * sizeof *point);
    uint32_t *sample = malloc(n * sizeof *sample);
    *s = (slice){at->theta_i, at->phi_i, NULL};
    if (point && sample) {
        for (size_t j = 0; j < n; j++) {
            memcpy(point + 2 * j, at[j].x, sizeof at[j].x);
            sample[j] = at[j].sample;
        }
        s->tree = ff_neighbours_new(2, n, point, sample);
    } else {
        free(point);
        free(sample);
    }
    return s->tree != NULL;
}

/* 1 when the samples come in slices, which p then has; 0 when not; -1 without memory. */
static int cut_slices(ff_interpolant *p, const placing *all)
{
    size_t slices = 0, thin = 0;
    for (size_t i = 0, end; i < all->n; i = end, slices++) {
        end = slice_end(all, i);
        if (end - i < LEAST_IN_SLICE) thin += end - i;
    }
    if (slices == 0 || slices > MOST_SLICES || thin > all->n / 20) return 0;
    p->slice = calloc(slices, sizeof *p->slice);
    if (!p->slice) return -1;
    for (size_t i = 0, end; i < all->n; i = end) {
        end = slice_end(all, i);
        if (end - i >= LEAST_IN_SLICE && !new_slice(&p->slice[p->n_slices++], all->at + i, end - i)) return -1;
    }
    return 1;
}

static int find_slices(ff_interpolant *p)
{
    placing all = {p->t->isotropic, p->mirrored, 0, malloc((p->mirrored ? 2 : 1) * p->t->n * sizeof *all.at)};
    if (!all.at) return -1;
    each_usable(p->t, place, &all);
    qsort(all.at, all.n, sizeof *all.at, by_incidence);
    const int found = cut_slices(p, &all);
    free(all.at);
    return found;
}

/* Slices beside an incident direction with their shares. */
typedef struct beside {
    size_t n, index[4];
    double share[4];
    int outside; /* the direction is beyond all of them */
} beside;

static beside beside_theta(const ff_interpolant *p, double theta_i)
{
    size_t hi = 0;
    while (hi < p->n_slices && p->slice[hi].theta_i < theta_i - same_incidence) hi++;
    if (hi < p->n_slices && fabs(p->slice[hi].theta_i - theta_i) <= same_incidence) return (beside){1, {hi}, {1}, 0};
    if (hi == 0 || hi == p->n_slices) return (beside){1, {hi ? hi - 1 : 0}, {1}, 1};
    const double lower = p->slice[hi - 1].theta_i, u = (theta_i - lower) / (p->slice[hi].theta_i - lower);
    return (beside){2, {hi - 1, hi}, {1 - u, u}, 0};
}

/* One past the slices that have the theta_i of slice `first`: a ring. */
static size_t ring_end(const ff_interpolant *p, size_t first)
{
    size_t end = first;
    while (end < p->n_slices && p->slice[end].theta_i == p->slice[first].theta_i) end++;
    return end;
}

/* Adds the slices of a ring on both sides of an azimuth, linear in it; 0 when the azimuth lies in a gap of the ring. */
static int add_from_ring(const ff_interpolant *p, size_t first, size_t end, double phi_i, double share, beside *out)
{
    static const double widest_gap = 100; /* degrees */
    if (end - first == 1) {               /* the normal, or not a ring */
        out->index[out->n] = first;
        out->share[out->n++] = share;
        return p->slice[first].theta_i < same_incidence;
    }
    double below = INFINITY, above = INFINITY;
    size_t lo = first, hi = first;
    for (size_t j = first; j < end; j++) {
        double up = fmod(p->slice[j].phi_i - phi_i, 360);
        if (up < 0) up += 360;
        const double down = up > 0 ? 360 - up : 0;
        if (up < above) above = up, hi = j;
        if (down < below) below = down, lo = j;
    }
    if (fmin(below, above) < same_incidence) {
        out->index[out->n] = below < above ? lo : hi;
        out->share[out->n++] = share;
        return 1;
    }
    const int gap = below + above > widest_gap;
    const double u = gap ? (double)(above < below) : below / (below + above);
    const size_t side[2] = {lo, hi};
    for (int k = 0; k < 2; k++)
        if ((k ? u : 1 - u) > 0) {
            out->index[out->n] = side[k];
            out->share[out->n++] = share * (k ? u : 1 - u);
        }
    return !gap;
}

/* The slices of the rings below and above theta_i; 0 when the incident directions do not come in rings there. */
static int beside_rings(const ff_interpolant *p, double theta_i, double phi_i, beside *out)
{
    size_t lower = 0, upper = 0;
    while (ring_end(p, upper) < p->n_slices && p->slice[upper].theta_i < theta_i - same_incidence) {
        lower = upper;
        upper = ring_end(p, upper);
    }
    const double a = p->slice[lower].theta_i, b = p->slice[upper].theta_i;
    const size_t lower_end = ring_end(p, lower), upper_end = ring_end(p, upper);
    const int is_upper = upper_end - upper >= 3 || b < same_incidence, is_lower = lower_end - lower >= 3 || a < same_incidence;
    *out = (beside){0};
    if (fabs(b - theta_i) <= same_incidence || b < theta_i || a >= theta_i) { /* on a ring, or outside of them all */
        if (!is_upper) return 0;
        out->outside = !add_from_ring(p, upper, upper_end, phi_i, 1, out) || fabs(b - theta_i) > same_incidence;
        return 1;
    }
    if (!is_upper || !is_lower) return 0;
    const double u = (theta_i - a) / (b - a);
    const int inside = add_from_ring(p, lower, lower_end, phi_i, 1 - u, out) & add_from_ring(p, upper, upper_end, phi_i, u, out);
    out->outside = !inside;
    return 1;
}

/* The nearest slice in each quadrant, seen from the direction along its meridian and across; inverse distances. Outside when one of
 * the outer quadrants is empty. */
static beside beside_quadrants(const ff_interpolant *p, double theta_i, double phi_i)
{
    double nearest[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
    size_t index[4] = {0};
    const double a = phi_i / degrees;
    for (size_t j = 0; j < p->n_slices; j++) {
        const double b = p->slice[j].phi_i / degrees, r = p->slice[j].theta_i;
        const double along = r * cos(b - a) - theta_i, across = r * sin(b - a), d = hypot(along, across);
        if (d < 2 * same_incidence) return (beside){1, {j}, {1}, 0};
        const int quadrant = (along >= 0) + 2 * (across >= 0);
        if (d < nearest[quadrant]) nearest[quadrant] = d, index[quadrant] = j;
    }
    beside out = {0};
    double sum = 0;
    for (int k = 0; k < 4; k++)
        if (isfinite(nearest[k])) {
            out.index[out.n] = index[k];
            out.share[out.n++] = 1 / nearest[k];
            sum += 1 / nearest[k];
        }
    for (size_t k = 0; k < out.n; k++) out.share[k] /= sum;
    out.outside = !isfinite(nearest[1]) && !isfinite(nearest[3]);
    return out;
}

static beside beside_direction(const ff_interpolant *p, double theta_i, double phi_i)
{
    beside out;
    return beside_rings(p, theta_i, phi_i, &out) ? out : beside_quadrants(p, theta_i, phi_i);
}

/* Mean of the slices' values at the half vector, by logarithms where they are positive. Slices whose own data do not reach that
 * half vector step back for those whose data do. */
static ff_found across_slices(const ff_interpolant *p, const beside *b, const double x[2], uint32_t without, double *value,
                              size_t stride)
{
    enum { CHANNELS = 64 };
    const size_t channels = p->t->n_channels;
    double one[4 * CHANNELS], *many = channels <= CHANNELS ? one : malloc(4 * channels * sizeof *many);
    if (!many) return FF_FOUND_BEYOND;
    ff_found how[4];
    double reached = 0;
    int all_samples = 1;
    for (size_t k = 0; k < b->n; k++) {
        how[k] = regress(p->t, p->slice[b->index[k]].tree, 2, x, without, many + k * channels, 1);
        if (how[k] != FF_FOUND_BEYOND) reached += b->share[k];
        all_samples &= how[k] == FF_FOUND_SAMPLE;
    }
    const int use_all = reached < 0.5;
    for (size_t c = 0; c < channels; c++) {
        double plain = 0, logs = 0, lo = INFINITY;
        for (size_t k = 0; k < b->n; k++) {
            if (!use_all && how[k] == FF_FOUND_BEYOND) continue;
            const double share = b->share[k] / (use_all ? 1 : reached), v = many[k * channels + c];
            lo = fmin(lo, v);
            plain += share * v;
            if (lo > 0) logs += share * log(v);
        }
        value[c * stride] = b->n == 1 || !(lo > 0) ? plain : exp(logs);
    }
    if (many != one) free(many);
    if (use_all || b->outside) return FF_FOUND_BEYOND;
    return b->n == 1 && all_samples ? FF_FOUND_SAMPLE : FF_FOUND_BETWEEN;
}

static ff_found slices_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                          size_t stride)
{
    double theta_i, phi_i, x[2];
    in_slice(p->t->isotropic, wi, wo, &theta_i, &phi_i, x);
    const beside b = p->t->isotropic ? beside_theta(p, theta_i) : beside_direction(p, theta_i, phi_i);
    return across_slices(p, &b, x, without, value, stride);
}

/* ---- scattered samples ----------------------------------------------------------------------- */

/* A pair whose difference azimuth is undetermined (light and detector in one place) stands on a circle of the isotropic
 * coordinates. */
enum { RING = 12 };
static size_t copies_of(int isotropic, const double x[4], const double wi[3], const double wo[3])
{
    const double apart = fabs(wi[0] - wo[0]) + fabs(wi[1] - wo[1]) + fabs(wi[2] - wo[2]);
    return isotropic && apart < 1e-7 && hypot(x[0], x[1]) > same ? RING : 1;
}

typedef struct gathering {
    int isotropic, mirrored, dim;
    size_t n;
    double *point; /* NULL: only count */
    uint32_t *sample;
} gathering;

static void gather_at(gathering *g, size_t i, const double x[4], const double wi[3], const double wo[3])
{
    const size_t copies = copies_of(g->isotropic, x, wi, wo);
    for (size_t j = 0; j < copies && g->point; j++) {
        const double turn = 2 * pi * (double)j / RING;
        double *to = g->point + (g->n + j) * (size_t)g->dim;
        memcpy(to, x, (size_t)g->dim * sizeof *to);
        to[0] = cos(turn) * x[0] - sin(turn) * x[1];
        to[1] = sin(turn) * x[0] + cos(turn) * x[1];
        g->sample[g->n + j] = (uint32_t)i;
    }
    g->n += copies;
}

static void gather(void *context, size_t i, const double wi[3], const double wo[3])
{
    gathering *g = context;
    double x[4];
    in_space(g->isotropic, wi, wo, x);
    gather_at(g, i, x, wi, wo);
    x[1] *= -1;
    if (g->mirrored) gather_at(g, i, x, wi, wo);
}

static ff_status grow_tree(ff_interpolant *p, ff_error *err)
{
    gathering g = {.isotropic = p->t->isotropic, .mirrored = p->mirrored, .dim = p->t->isotropic ? 3 : 4};
    each_usable(p->t, gather, &g);
    if (g.n == 0)
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "found no measured sample above the horizon, expected at least one to interpolate from");
    g.point = malloc(g.n * (size_t)g.dim * sizeof *g.point);
    g.sample = malloc(g.n * sizeof *g.sample);
    if (g.point && g.sample) {
        const size_t n = g.n;
        g.n = 0;
        each_usable(p->t, gather, &g);
        p->tree = ff_neighbours_new(g.dim, n, g.point, g.sample); /* takes both over */
    } else {
        free(g.point);
        free(g.sample);
    }
    return p->tree ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory to interpolate between %zu samples", g.n);
}

static ff_found scattered_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                             size_t stride)
{
    double x[4];
    const int dim = in_space(p->t->isotropic, wi, wo, x);
    return regress(p->t, p->tree, dim, x, without, value, stride);
}

/* ---- all methods ----------------------------------------------------------------------------- */

/* The first method that fits the table. */
static ff_status choose(ff_interpolant *p, int scattered, ff_error *err)
{
    if (p->t->n > UINT32_MAX / (2 * RING))
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "found %zu samples, expected at most %u to interpolate between",
                            p->t->n, UINT32_MAX / (2 * RING));
    int found = scattered ? 0 : find_axes(p);
    p->method = PRODUCT;
    p->mirrored = found == 0 && is_one_sided(p->t);
    if (found == 0) {
        p->method = SLICES;
        found = find_slices(p);
    }
    if (found == 0) {
        p->method = SCATTERED;
        return grow_tree(p, err);
    }
    return found > 0 ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory to interpolate");
}

ff_status ff_interpolant_new(const ff_table *t, int scattered, ff_interpolant **out, ff_error *err)
{
    ff_interpolant *p = calloc(1, sizeof *p);
    if (!p) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory to interpolate");
    p->t = t;
    const ff_status s = choose(p, scattered, err);
    if (s == FF_OK)
        *out = p;
    else
        ff_interpolant_free(p);
    return s;
}

void ff_interpolant_free(ff_interpolant *p)
{
    if (!p) return;
    for (int k = 0; k < 4; k++) free(p->axis[k].node);
    for (size_t j = 0; j < p->n_slices; j++) ff_neighbours_free(p->slice[j].tree);
    free(p->slice);
    ff_neighbours_free(p->tree);
    free(p);
}

const char *ff_interpolant_method(const ff_interpolant *p)
{
    return p->method == PRODUCT  ? "linear along the axes of the grid"
           : p->method == SLICES ? "local regression over half vectors at each incidence, linear between incidences"
                                 : "local regression over the nearest samples";
}

static ff_found value_at(const ff_interpolant *p, const double wi[3], const double wo[3], uint32_t without, double *value,
                         size_t stride)
{
    if (!(wi[2] > FF_COS_MIN) || !(wo[2] > FF_COS_MIN)) {
        for (size_t c = 0; c < p->t->n_channels; c++) value[c * stride] = 0;
        return FF_FOUND_BELOW;
    }
    return p->method == PRODUCT  ? product_at(p, wi, wo, value, stride)
           : p->method == SLICES ? slices_at(p, wi, wo, without, value, stride)
                                 : scattered_at(p, wi, wo, without, value, stride);
}

ff_found ff_interpolant_without(const ff_interpolant *p, size_t i, double *value)
{
    double w[6], *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    ff_table_directions(p->t, i, 1, planes);
    return value_at(p, w, w + 3, (uint32_t)i, value, 1);
}

int ff_interpolant_is_incidence(const ff_interpolant *p, const double wi[3], double within)
{
    const double theta_i = degrees * atan2(hypot(wi[0], wi[1]), wi[2]);
    for (size_t j = 0; j < p->n_slices; j++) {
        const slice *s = &p->slice[j];
        if (fabs(s->theta_i - theta_i) > within) continue;
        const double a = s->theta_i / degrees, b = s->phi_i / degrees;
        const double apart = hypot(wi[0] - sin(a) * cos(b), wi[1] - sin(a) * sin(b));
        if (p->t->isotropic || apart * degrees <= within) return 1;
    }
    return 0;
}

/* The range of theta_i in the data. */
typedef struct theta_range {
    double lo, hi;
} theta_range;

static void widen(void *context, size_t i, const double wi[3], const double wo[3])
{
    theta_range *r = context;
    const double theta = degrees * atan2(hypot(wi[0], wi[1]), wi[2]);
    (void)i, (void)wo;
    r->lo = fmin(r->lo, theta);
    r->hi = fmax(r->hi, theta);
}

/* First slices of each theta_i, spread evenly when there are more than asked for. */
static size_t slice_incidences(const ff_interpolant *p, size_t most, double *theta_i, double *phi_i)
{
    size_t distinct = 0, taken = 0, seen = 0;
    for (size_t j = 0; j < p->n_slices; j++) distinct += j == 0 || p->slice[j].theta_i != p->slice[j - 1].theta_i;
    for (size_t j = 0; j < p->n_slices; j++) {
        if (j > 0 && p->slice[j].theta_i == p->slice[j - 1].theta_i) continue;
        const size_t wanted = distinct <= most ? seen : taken * (distinct - 1) / (most - 1);
        if (seen++ != wanted || taken == most) continue;
        theta_i[taken] = p->slice[j].theta_i;
        phi_i[taken++] = p->slice[j].phi_i;
    }
    return taken;
}

size_t ff_interpolant_incidences(const ff_interpolant *p, size_t most, double *theta_i, double *phi_i)
{
    static const double round_ones[] = {5, 15, 30, 45, 60, 75};
    theta_range r = {INFINITY, -INFINITY};
    size_t n = 0;
    if (p->method == SLICES) return slice_incidences(p, most, theta_i, phi_i);
    if (p->method == PRODUCT && p->kind == FF_AXES_SPECULAR) {
        for (; n < most && n < p->axis[1].n; n++) {
            theta_i[n] = degrees * p->axis[1].node[n];
            phi_i[n] = -90 - degrees * p->axis[0].node[0];
        }
        return n;
    }
    each_usable(p->t, widen, &r);
    for (size_t k = 0; k < sizeof round_ones / sizeof round_ones[0] && n < most; k++)
        if (round_ones[k] >= r.lo && round_ones[k] <= r.hi) {
            theta_i[n] = round_ones[k];
            phi_i[n++] = 0;
        }
    return n;
}

static void eval(const ff_interpolant *p, const double *const w[6], size_t n, int reciprocal, double *value, unsigned char *found)
{
    for (size_t i = 0; i < n; i++) {
        const double wi[3] = {w[0][i], w[1][i], w[2][i]}, wo[3] = {w[3][i], w[4][i], w[5][i]};
        ff_found how = value_at(p, wi, wo, UINT32_MAX, value + i, n);
        if (reciprocal && how == FF_FOUND_BEYOND) {
            how = value_at(p, wo, wi, UINT32_MAX, value + i, n);
            if (how == FF_FOUND_BEYOND)
                value_at(p, wi, wo, UINT32_MAX, value + i, n);
            else
                how = FF_FOUND_RECIPROCAL;
        }
        if (found) found[i] = (unsigned char)how;
    }
}

void ff_interpolant_eval(const ff_interpolant *p, const double *const w[6], size_t n, double *value, unsigned char *found)
{
    eval(p, w, n, 0, value, found);
}

void ff_interpolant_eval_reciprocal(const ff_interpolant *p, const double *const w[6], size_t n, double *value,
                                    unsigned char *found)
{
    eval(p, w, n, 1, value, found);
}
