/* A k-d tree in place: the middle of a range of places is its node, the halves its children (Bentley 1975). */
#include "internal_neighbours.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LEAF = 8, DIM = 4 };

/* A place: its coordinates and its samples, which stand together in the list of all. */
typedef struct place {
    double x[DIM];
    uint32_t first, n_samples;
} place;

struct ff_neighbours {
    int dim;
    size_t n;
    place *place;
    uint32_t *sample;
    unsigned char *axis; /* [n] by which a node divides */
};

/* ---- places ---------------------------------------------------------------------------------- */

static int by_coordinates(const void *a, const void *b)
{
    const place *p = a, *q = b;
    for (int k = 0; k < DIM; k++) {
        const double x = round(p->x[k] / FF_NEIGHBOURS_SAME), y = round(q->x[k] / FF_NEIGHBOURS_SAME);
        if (x != y) return x < y ? -1 : 1;
    }
    return 0;
}

static int by_coordinates_and_sample(const void *a, const void *b)
{
    const place *p = a, *q = b;
    const int order = by_coordinates(a, b);
    return order ? order : (p->first > q->first) - (p->first < q->first);
}

/* Joins equal points; until then `first` of a place is the number of its sample. */
static void join(ff_neighbours *t, size_t n)
{
    qsort(t->place, n, sizeof *t->place, by_coordinates_and_sample);
    t->n = 0;
    for (size_t i = 0; i < n; i++) {
        const uint32_t sample = t->place[i].first;
        t->sample[i] = sample;
        if (i > 0 && by_coordinates(&t->place[t->n - 1], &t->place[i]) == 0) {
            t->place[t->n - 1].n_samples++;
            continue;
        }
        t->place[t->n] = t->place[i];
        t->place[t->n].first = (uint32_t)i;
        t->place[t->n++].n_samples = 1;
    }
}

/* ---- the tree -------------------------------------------------------------------------------- */

static void swap_places(ff_neighbours *t, size_t i, size_t j)
{
    const place p = t->place[i];
    t->place[i] = t->place[j];
    t->place[j] = p;
}

/* Brings the place of rank m of lo..hi-1 to where it belongs, no larger ones before it and no smaller ones behind (Hoare's
 * selection; the pivots come from a fixed sequence, so that no order of the points makes it slow on purpose). */
static void select_rank(ff_neighbours *t, size_t lo, size_t hi, size_t m, int axis)
{
    uint64_t state = 88172645463325252u;
    ptrdiff_t left = (ptrdiff_t)lo, right = (ptrdiff_t)hi - 1;
    while (left < right) {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        const double pivot = t->place[(size_t)left + (size_t)(state % (uint64_t)(right - left + 1))].x[axis];
        ptrdiff_t i = left, j = right;
        while (i <= j) {
            while (t->place[i].x[axis] < pivot) i++;
            while (t->place[j].x[axis] > pivot) j--;
            if (i <= j) swap_places(t, (size_t)i++, (size_t)j--);
        }
        if (j < (ptrdiff_t)m) left = i;
        if ((ptrdiff_t)m < i) right = j;
    }
}

static int widest(const ff_neighbours *t, size_t lo, size_t hi)
{
    int best = 0;
    double width = -1;
    for (int k = 0; k < t->dim; k++) {
        double least = t->place[lo].x[k], most = least;
        for (size_t i = lo + 1; i < hi; i++) {
            const double x = t->place[i].x[k];
            least = x < least ? x : least;
            most = x > most ? x : most;
        }
        if (most - least > width) {
            width = most - least;
            best = k;
        }
    }
    return best;
}

static void build(ff_neighbours *t, size_t lo, size_t hi)
{
    while (hi - lo > LEAF) {
        const size_t middle = lo + (hi - lo) / 2;
        const int axis = widest(t, lo, hi);
        select_rank(t, lo, hi, middle, axis);
        t->axis[middle] = (unsigned char)axis;
        build(t, lo, middle);
        lo = middle + 1;
    }
}

ff_neighbours *ff_neighbours_new(int dim, size_t n, double *point, uint32_t *sample)
{
    ff_neighbours *t = calloc(1, sizeof *t);
    if (t) *t = (ff_neighbours){dim, n, calloc(n, sizeof *t->place), sample, malloc(n)};
    if (!t || !t->place || !t->axis) {
        free(point);
        if (t)
            ff_neighbours_free(t);
        else
            free(sample);
        return NULL;
    }
    for (size_t i = 0; i < n; i++) {
        memcpy(t->place[i].x, point + i * (size_t)dim, (size_t)dim * sizeof *point);
        t->place[i].first = sample[i];
    }
    free(point);
    join(t, n);
    build(t, 0, t->n);
    return t;
}

void ff_neighbours_free(ff_neighbours *t)
{
    if (!t) return;
    free(t->place);
    free(t->sample);
    free(t->axis);
    free(t);
}

/* ---- searching ------------------------------------------------------------------------------- */

typedef struct search {
    const ff_neighbours *t;
    const double *x;
    size_t k, n;
    uint32_t without;
    ff_neighbour *best; /* [k], nearest first */
} search;

/* 1 when every sample of the place is the one to leave out. */
static int left_out(const search *s, const place *p)
{
    uint32_t i = 0;
    while (i < p->n_samples && s->t->sample[p->first + i] == s->without) i++;
    return i == p->n_samples;
}

static void consider(search *s, size_t i)
{
    const place *p = &s->t->place[i];
    double d2 = 0;
    for (int k = 0; k < s->t->dim; k++) d2 += (p->x[k] - s->x[k]) * (p->x[k] - s->x[k]);
    if ((s->n == s->k && d2 >= s->best[s->n - 1].distance2) || left_out(s, p)) return;
    size_t j = s->n < s->k ? s->n++ : s->n - 1;
    for (; j > 0 && s->best[j - 1].distance2 > d2; j--) s->best[j] = s->best[j - 1];
    s->best[j] = (ff_neighbour){d2, p->x, s->t->sample + p->first, p->n_samples};
}

static void descend(search *s, size_t lo, size_t hi)
{
    if (hi - lo <= LEAF) {
        for (size_t i = lo; i < hi; i++) consider(s, i);
        return;
    }
    const size_t middle = lo + (hi - lo) / 2;
    const int axis = s->t->axis[middle];
    const double beyond = s->x[axis] - s->t->place[middle].x[axis];
    if (beyond < 0)
        descend(s, lo, middle);
    else
        descend(s, middle + 1, hi);
    consider(s, middle);
    if (s->n == s->k && beyond * beyond >= s->best[s->n - 1].distance2) return;
    if (beyond < 0)
        descend(s, middle + 1, hi);
    else
        descend(s, lo, middle);
}

size_t ff_neighbours_find(const ff_neighbours *tree, const double *x, size_t k, uint32_t without, ff_neighbour *out)
{
    search s = {tree, x, k < FF_NEIGHBOURS_MOST ? k : FF_NEIGHBOURS_MOST, 0, without, out};
    descend(&s, 0, tree->n);
    return s.n;
}
