/* The least squares of ff_start_channels where parameters are tied: the normal equations of a channel with the columns of one
 * coordinate added up, and unknowns that all channels share. Those and the others are solved for in turn: for given shared ones the
 * channels fall apart into small bounded problems, for given own ones the shared are one more. The sum is convex and its bounds are
 * a box, so that the turns lead to the minimum. */
#include "internal_start.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Steps of the own unknowns of each channel and of the shared ones. */
typedef struct tied_problem {
    const ff_layout *l;     /* of channel parameters alone                                                  */
    size_t n_local, n_tri;  /* own, shared: what a channel knows of; doubles of its packed gram with r      */
    double *gram;           /* [n_channels][n_tri]                                                          */
    double *lo, *hi, *step; /* [P], in the order of the coordinates                                         */
} tied_problem;

/* Coordinate of local unknown i of channel c. */
static size_t coordinate_of(const tied_problem *t, size_t c, size_t i)
{
    return i < t->l->n_own ? t->l->n_shared + c * t->l->n_own + i : i - t->l->n_own;
}

/* Local unknown of channel column k. */
static size_t local_of(const ff_layout *l, size_t k)
{
    return l->channel_shared[k] ? l->n_own + l->channel_at[k] : l->channel_at[k];
}

/* Adds up the columns of each unknown; column and unknown number n are the residual. */
static void fold(const tied_problem *t, const ff_normal *normal)
{
    const size_t n = t->l->free.n_channel, tri = normal->m1 * (normal->m1 + 1) / 2;
    for (size_t c = 0; c < normal->n_channels; c++) {
        double *out = t->gram + c * t->n_tri;
        for (size_t a = 0; a <= n; a++)
            for (size_t b = 0; b <= n; b++) {
                const size_t i = a < n ? local_of(t->l, a) : t->n_local, j = b < n ? local_of(t->l, b) : t->n_local;
                if (i >= j) out[ff_tri(i, j)] += normal->gram[c * tri + ff_tri(a, b)];
            }
    }
}

/* The gram of unknowns [from, from + n) of channel c with the others at their steps, added to out, residual last. */
static void condense(const tied_problem *t, size_t c, size_t from, size_t n, double *out)
{
    const double *gram = t->gram + c * t->n_tri;
    double constant = gram[ff_tri(t->n_local, t->n_local)];
    for (size_t i = 0; i < t->n_local; i++) {
        const int kept = i >= from && i < from + n;
        double slope = gram[ff_tri(t->n_local, i)];
        for (size_t k = 0; k < t->n_local; k++)
            if (k < from || k >= from + n) slope += gram[ff_tri(i, k)] * t->step[coordinate_of(t, c, k)];
        if (!kept) {
            constant += (slope + gram[ff_tri(t->n_local, i)]) * t->step[coordinate_of(t, c, i)];
            continue;
        }
        out[ff_tri(n, i - from)] += slope;
        for (size_t k = from; k <= i; k++) out[ff_tri(i - from, k - from)] += gram[ff_tri(i, k)];
    }
    out[ff_tri(n, n)] += constant;
}

/* One turn; the sum of squares after it. */
static double take_turn(const tied_problem *t)
{
    const ff_layout *l = t->l;
    double gram[(FF_MAX_CHANNEL_PARAMS + 1) * (FF_MAX_CHANNEL_PARAMS + 2) / 2], sum = 0;
    for (size_t c = 0; c < l->n_channels && l->n_own; c++) {
        const size_t at = coordinate_of(t, c, 0);
        memset(gram, 0, sizeof gram);
        condense(t, c, 0, l->n_own, gram);
        sum += ff_bounded_least_squares(gram, l->n_own, t->lo + at, t->hi + at, t->step + at);
    }
    if (l->n_shared == 0) return sum;
    memset(gram, 0, sizeof gram);
    for (size_t c = 0; c < l->n_channels; c++) condense(t, c, l->n_own, l->n_shared, gram);
    return ff_bounded_least_squares(gram, l->n_shared, t->lo, t->hi, t->step);
}

double ff_tied_least_squares(const ff_layout *l, const ff_normal *normal, const double *at, double *out)
{
    enum { TURNS = 200 };
    const size_t C = l->n_channels, size = C * l->m->n_channel;
    tied_problem t = {.l = l, .n_local = l->n_own + l->n_shared};
    t.n_tri = (t.n_local + 1) * (t.n_local + 2) / 2;
    t.gram = calloc(C * t.n_tri + 3 * l->P, sizeof *t.gram);
    if (out != at) memcpy(out, at, size * sizeof *out);
    if (!t.gram) return INFINITY;
    t.lo = t.gram + C * t.n_tri;
    t.hi = t.lo + l->P;
    t.step = t.hi + l->P;
    fold(&t, normal);
    for (size_t k = 0; k < l->P; k++) {
        size_t c;
        const ff_model_param *p = ff_layout_param(l, k, &c);
        const double from = at[c * l->m->n_channel + (size_t)(p - l->m->channel)];
        ff_layout_range(l, k, &t.lo[k], &t.hi[k]);
        t.lo[k] -= from;
        t.hi[k] -= from;
    }
    double sum = INFINITY;
    for (int turn = 0; turn < TURNS; turn++) {
        const double before = sum;
        sum = take_turn(&t);
        if (before - sum <= 1e-10 * sum || l->n_shared == 0) break;
    }
    for (size_t c = 0; c < C; c++)
        for (uint32_t k = 0; k < l->free.n_channel; k++) {
            const uint32_t i = l->free.channel[k];
            double *v = &out[c * l->m->n_channel + i];
            *v = fmin(fmax(*v + t.step[ff_layout_coordinate(l, c, k)], ff_layout_lo(l, c, i)), ff_layout_hi(l, c, i));
        }
    free(t.gram);
    return sum;
}
