/* Samples near the plane of incidence, gathered by the direction of the light. */
#include "internal_curves.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SLAB = 2048, DISTINCT = 120, FEW = 10, PHI_ROOM = 1024, FIRST_OF_RINGS = 2 };
#define WIDEST 0.0872 /* sine of 5 degrees */

/* Tolerances for measurements that are nearly in the plane, tried in turn. */
static const double tolerances[] = {0.001, 0.0105, 0.0262, WIDEST};

typedef struct gathering {
    ff_plane_sample *sample;
    size_t n, room;
} gathering;

static int keep(gathering *g, const ff_plane_sample *s)
{
    if (g->n == g->room) {
        const size_t room = g->room ? 2 * g->room : 1024;
        ff_plane_sample *longer = realloc(g->sample, room * sizeof *longer);
        if (!longer) return 0;
        g->sample = longer;
        g->room = room;
    }
    g->sample[g->n++] = *s;
    return 1;
}

/* w: wi, wo. With the light along the normal every plane is one of incidence; that of the x axis is taken. */
static int look_at(const double w[6], int isotropic, uint32_t index, gathering *g)
{
    const double across_normal = hypot(w[0], w[1]);
    const double ux = across_normal > 1e-6 ? w[0] / across_normal : 1, uy = across_normal > 1e-6 ? w[1] / across_normal : 0;
    const double along = w[3] * ux + w[4] * uy, across = fabs(w[4] * ux - w[3] * uy);
    if (w[2] <= 0 || w[5] <= 0 || across > WIDEST) return 1;
    const ff_plane_sample s = {atan2(across_normal, w[2]),
                               isotropic || across_normal < 1e-6 ? 0 : atan2(w[1], w[0]),
                               atan2(-along, w[5]),
                               across,
                               index,
                               0};
    return keep(g, &s);
}

/* `step` samples apart. */
static ff_status gather(const ff_table *t, size_t step, gathering *g)
{
    const size_t total = (t->n + step - 1) / step;
    double *block = malloc(6 * SLAB * sizeof *block);
    ff_status status = block ? FF_OK : FF_ERR_MEMORY;
    for (size_t first = 0; first < total && !status; first += SLAB) {
        const size_t n = total - first < SLAB ? total - first : SLAB;
        double *const planes[6] = {block, block + SLAB, block + 2 * SLAB, block + 3 * SLAB, block + 4 * SLAB, block + 5 * SLAB};
        if (step == 1) ff_table_directions(t, first, n, planes);
        for (size_t i = 0; i < n && !status; i++) {
            const size_t index = (first + i) * step;
            double *const own[6] = {planes[0] + i, planes[1] + i, planes[2] + i, planes[3] + i, planes[4] + i, planes[5] + i};
            if (step > 1) ff_table_directions(t, index, 1, own);
            const double w[6] = {planes[0][i], planes[1][i], planes[2][i], planes[3][i], planes[4][i], planes[5][i]};
            if (t->valid[index] && !look_at(w, t->isotropic, (uint32_t)index, g)) status = FF_ERR_MEMORY;
        }
    }
    free(block);
    return status;
}

/* The group of a sample by theta_i and phi_i, these in steps of half a degree. */
static void number(ff_plane_sample *s, size_t n, double step)
{
    for (size_t i = 0; i < n; i++)
        s[i].group = (int32_t)lround(s[i].theta_i / step) * PHI_ROOM + (int32_t)lround(s[i].phi_i / 0.0087);
}

static int by_place(const void *a, const void *b)
{
    const ff_plane_sample *x = a, *y = b;
    if (x->group != y->group) return x->group < y->group ? -1 : 1;
    if (x->theta_o != y->theta_o) return x->theta_o < y->theta_o ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

static size_t order(ff_plane_sample *s, size_t n, double step)
{
    size_t groups = n > 0;
    number(s, n, step);
    qsort(s, n, sizeof *s, by_place);
    for (size_t i = 1; i < n; i++) groups += s[i - 1].group != s[i].group;
    return groups;
}

/* How many samples the tolerance leaves; they move to the front. */
static size_t within(const gathering *g, double tolerance, ff_plane_sample *out)
{
    size_t n = 0;
    for (size_t i = 0; i < g->n; i++)
        if (g->sample[i].across <= tolerance) out[n++] = g->sample[i];
    return n;
}

/* Distinct theta_i, of samples in the order of their groups. */
static size_t count_incidences(const ff_planes *p)
{
    size_t n = p->n_samples > 0;
    for (size_t i = 1; i < p->n_samples; i++)
        n += (p->sample[i - 1].group + PHI_ROOM / 2) / PHI_ROOM != (p->sample[i].group + PHI_ROOM / 2) / PHI_ROOM;
    return n;
}

/* In groups by incidence, or where every sample has its own, in rings of a degree. Returns how many samples a group has: the
 * largest of them; of rings the smallest of those that are neither steep nor grazing, where a lattice of half angles is dense. */
static size_t group(ff_planes *p)
{
    size_t largest = 0, smallest = SIZE_MAX;
    p->width = 0;
    p->n_groups = order(p->sample, p->n_samples, 1e-3);
    if (count_incidences(p) > DISTINCT) {
        p->width = FF_DEGREE;
        p->n_groups = order(p->sample, p->n_samples, p->width);
    }
    for (size_t first = 0, end; first < p->n_samples; first = end) {
        const double theta = p->sample[first].theta_i / FF_DEGREE;
        for (end = first; end < p->n_samples && p->sample[end].group == p->sample[first].group;) end++;
        largest = end - first > largest ? end - first : largest;
        if (theta > 15 && theta < 65 && end - first < smallest) smallest = end - first;
    }
    return p->width > 0 && smallest < SIZE_MAX ? smallest : largest;
}

static ff_status mark_groups(ff_planes *p)
{
    size_t groups = 0;
    p->first = malloc((p->n_groups + 1) * sizeof *p->first);
    if (!p->first) return FF_ERR_MEMORY;
    p->tolerance = 0;
    for (size_t i = 0; i < p->n_samples; i++) {
        if (i == 0 || p->sample[i - 1].group != p->sample[i].group) p->first[groups++] = i;
        p->tolerance = fmax(p->tolerance, p->sample[i].across);
    }
    p->first[groups] = p->n_samples;
    return FF_OK;
}

ff_status ff_planes_find(const ff_table *t, ff_planes *out, ff_error *err)
{
    gathering g = {NULL, 0, 0};
    const size_t step = ff_plot_step(t->n);
    ff_status status = gather(t, step, &g);
    ff_planes p = {.step = step, .sample = status ? NULL : malloc((g.n + 1) * sizeof *p.sample)};
    if (!p.sample) status = FF_ERR_MEMORY;
    for (size_t k = 0; k < sizeof tolerances / sizeof *tolerances && !status; k++) {
        p.n_samples = within(&g, tolerances[k], p.sample);
        const size_t n = group(&p);
        if (p.width > 0 && k < FIRST_OF_RINGS)
            k = FIRST_OF_RINGS - 1;
        else if (n >= FEW)
            break;
    }
    free(g.sample);
    if (!status && p.n_samples == 0)
        status = ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "no sample lies within 5 degrees of the plane of incidence");
    if (!status) status = mark_groups(&p);
    if (status)
        ff_planes_free(&p);
    else
        *out = p;
    return status;
}

void ff_planes_free(ff_planes *p)
{
    free(p->sample);
    free(p->first);
    *p = (ff_planes){.n_samples = 0};
}

double ff_planes_theta(const ff_planes *p, size_t group)
{
    double sum = 0;
    for (size_t i = p->first[group]; i < p->first[group + 1]; i++) sum += p->sample[i].theta_i;
    return sum / (double)(p->first[group + 1] - p->first[group]);
}

/* The group nearest to an incidence; of several the largest, then the first. */
static size_t nearest(const ff_planes *p, double theta)
{
    size_t best = 0;
    double least = INFINITY;
    for (size_t g = 0; g < p->n_groups; g++) {
        const double d = fabs(ff_planes_theta(p, g) - theta);
        const size_t n = p->first[g + 1] - p->first[g], most = p->first[best + 1] - p->first[best];
        if (d < least - 1e-4 || (d < least + 1e-4 && n > most)) {
            best = g;
            least = fmin(least, d);
        }
    }
    return best;
}

static int has(const size_t *list, size_t n, size_t x)
{
    for (size_t i = 0; i < n; i++)
        if (list[i] == x) return 1;
    return 0;
}

size_t ff_planes_choose(const ff_planes *p, const ff_plot_choice *c, size_t most, size_t *out)
{
    size_t n = 0;
    for (size_t k = 0; k < c->n_incidence; k++) {
        const size_t g = nearest(p, c->incidence[k] * FF_DEGREE);
        if (!has(out, n, g)) out[n++] = g;
    }
    if (c->n_incidence) return n;
    /* spread over what was measured with a number of samples worth a curve, oblique light first of all */
    double lo = INFINITY, hi = 0;
    size_t full = 0;
    for (size_t g = 0; g < p->n_groups && !(p->width > 0); g++)
        full = p->first[g + 1] - p->first[g] > full ? p->first[g + 1] - p->first[g] : full;
    for (size_t g = 0; g < p->n_groups; g++) {
        const double theta = ff_planes_theta(p, g);
        if (2 * (p->first[g + 1] - p->first[g]) < full || theta > 1.4) continue;
        lo = fmin(lo, theta);
        hi = fmax(hi, theta);
    }
    if (!(hi >= lo)) lo = hi = ff_planes_theta(p, 0);
    for (size_t k = 0; k < most; k++) {
        const size_t g = nearest(p, lo + (hi - lo) * ((double)k + 0.5) / (double)most);
        if (!has(out, n, g)) out[n++] = g;
    }
    return n;
}
