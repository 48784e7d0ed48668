/* A detector at its limit, seen in the data themselves. */
#include "base/internal_order.h"
#include "internal_problem.h"
#include <math.h>
#include <stdlib.h>

/* Values that are further apart than 0.01, of n; sorted here. */
static size_t count_distinct(double *v, size_t n)
{
    size_t count = 1, last = 0;
    qsort(v, n, sizeof *v, ff_ascending);
    for (size_t i = 1; i < n; i++)
        if (v[i] - v[last] > 0.01) last = i, count++;
    return count;
}

int ff_problem_looks_saturated(const struct ff_problem *p, const ff_table *t, const uint32_t *index)
{
    enum { LOOKED_AT = 256, SEVERAL = 3 };
    const size_t at_top = p->selection.at_top, step = at_top / LOOKED_AT + 1;
    double half[LOOKED_AT], difference[LOOKED_AT], w[6];
    size_t n = 0, seen = 0;
    if (at_top <= SEVERAL || at_top > p->n / 2) return 0;
    for (size_t i = 0; i < p->n && n < LOOKED_AT; i++) {
        int is_top = 0;
        for (size_t c = 0; c < p->n_channels; c++)
            is_top |= ff_problem_plane(p, i / FF_BLOCK, p->value + (int)c)[i % FF_BLOCK] == p->selection.top;
        if (!is_top || seen++ % step) continue;
        double *const planes[6] = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        ff_table_directions(t, index[i], 1, planes);
        const double io = w[0] * w[3] + w[1] * w[4] + w[2] * w[5];
        half[n] = acos(fmin((w[2] + w[5]) / sqrt(fmax(2 + 2 * io, 1e-300)), 1));
        difference[n++] = acos(fmin(fmax(io, -1), 1));
    }
    return n > SEVERAL && count_distinct(half, n) >= SEVERAL && count_distinct(difference, n) >= SEVERAL;
}
