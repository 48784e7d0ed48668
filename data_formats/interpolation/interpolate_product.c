/* Interpolation along the axes of a grid in which the mirror direction stands still. */
#include "models/model_struct.h"
#include "internal_interpolate.h"
#include "data_formats/table/internal_table.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

static int is_azimuth(ff_axes_kind kind, int k)
{
    return kind == FF_AXES_SPECULAR ? k == 0 || k == 2 : k % 2;
}

/* Joins the ends of an azimuth whose nodes go once around, which for the difference angle may be half a turn by reciprocity. */
static void close_azimuth(ff_axis *a, ff_axes_kind kind, int k, int isotropic)
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

static int new_axis(ff_axis *a, size_t n, const double *node, double unit)
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
int ff_product_find(ff_interpolant *p)
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
static int bracket(const ff_axis *a, double x, size_t index[2], double *weight)
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

ff_found ff_product_at(const ff_interpolant *p, const double wi[3], const double wo[3], double *value, size_t stride)
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
        if (!ff_table_is_measured(t, i)) continue;
        valid_weight += w;
        whole = fmax(whole, w);
        for (size_t c = 0; c < t->n_channels; c++) value[c * stride] += w * t->channels[c].scale * t->value[c * t->n + i];
    }
    if (!(valid_weight > 0)) return FF_FOUND_BEYOND;
    for (size_t c = 0; c < t->n_channels; c++) value[c * stride] /= valid_weight;
    if (!inside || valid_weight < 0.5 * sum_weight) return FF_FOUND_BEYOND;
    return whole > 1 - 1e-9 ? FF_FOUND_SAMPLE : FF_FOUND_BETWEEN;
}
