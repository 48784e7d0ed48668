/* A k-d tree in place: the middle of a range of points is its node, the halves its children (Bentley 1975). */
#include "internal_neighbours.h"
#include <stdlib.h>
#include <string.h>

enum { LEAF = 8 };

struct ff_neighbours {
    int dim;
    size_t n;
    double *point;
    uint32_t *sample;
    unsigned char *axis; /* [n] by which a node divides */
};

static void swap_points(ff_neighbours *t, size_t i, size_t j)
{
    for (int k = 0; k < t->dim; k++) {
        const double x = t->point[i * (size_t)t->dim + (size_t)k];
        t->point[i * (size_t)t->dim + (size_t)k] = t->point[j * (size_t)t->dim + (size_t)k];
        t->point[j * (size_t)t->dim + (size_t)k] = x;
    }
    const uint32_t s = t->sample[i];
    t->sample[i] = t->sample[j];
    t->sample[j] = s;
}

static double at(const ff_neighbours *t, size_t i, int axis)
{
    return t->point[i * (size_t)t->dim + (size_t)axis];
}

/* Brings the point of rank m of lo..hi-1 into its place, no larger ones before it and no smaller ones behind (Hoare's selection;
 * the pivots come from a fixed sequence, so that no order of the points makes it slow on purpose). */
static void select_rank(ff_neighbours *t, size_t lo, size_t hi, size_t m, int axis)
{
    uint64_t state = 88172645463325252u;
    ptrdiff_t left = (ptrdiff_t)lo, right = (ptrdiff_t)hi - 1;
    while (left < right) {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        const double pivot = at(t, (size_t)left + (size_t)(state % (uint64_t)(right - left + 1)), axis);
        ptrdiff_t i = left, j = right;
        while (i <= j) {
            while (at(t, (size_t)i, axis) < pivot) i++;
            while (at(t, (size_t)j, axis) > pivot) j--;
            if (i <= j) swap_points(t, (size_t)i++, (size_t)j--);
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
        double least = at(t, lo, k), most = least;
        for (size_t i = lo + 1; i < hi; i++) {
            const double x = at(t, i, k);
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
    ff_neighbours *t = malloc(sizeof *t);
    unsigned char *axis = malloc(n);
    if (!t || !axis) {
        free(t);
        free(axis);
        free(point);
        free(sample);
        return NULL;
    }
    *t = (ff_neighbours){dim, n, point, sample, axis};
    build(t, 0, n);
    return t;
}

void ff_neighbours_free(ff_neighbours *t)
{
    if (!t) return;
    free(t->point);
    free(t->sample);
    free(t->axis);
    free(t);
}

typedef struct search {
    const ff_neighbours *t;
    const double *x;
    size_t k, n;
    uint32_t without;
    ff_neighbour *best; /* [k], nearest first */
} search;

static void consider(search *s, size_t i)
{
    const ff_neighbours *t = s->t;
    const double *p = t->point + i * (size_t)t->dim;
    double d2 = 0;
    for (int k = 0; k < t->dim; k++) d2 += (p[k] - s->x[k]) * (p[k] - s->x[k]);
    if (t->sample[i] == s->without || (s->n == s->k && d2 >= s->best[s->n - 1].distance2)) return;
    size_t j = s->n < s->k ? s->n++ : s->n - 1;
    for (; j > 0 && s->best[j - 1].distance2 > d2; j--) s->best[j] = s->best[j - 1];
    s->best[j] = (ff_neighbour){d2, p, t->sample[i]};
}

static void descend(search *s, size_t lo, size_t hi)
{
    if (hi - lo <= LEAF) {
        for (size_t i = lo; i < hi; i++) consider(s, i);
        return;
    }
    const size_t middle = lo + (hi - lo) / 2;
    const int axis = s->t->axis[middle];
    const double beyond = s->x[axis] - at(s->t, middle, axis);
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
