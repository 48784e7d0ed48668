/* Directions on the borders between cells. */
#include "internal_cells.h"
#include <math.h>
#include <string.h>

/* Around a direction, radians: more than rounding, less than any cell. */
static const double around = 1e-6;

/* The k-th of four directions around w, one in each quadrant of meridian and parallel; 0: below the horizon. */
static int beside(const double w[3], int k, double out[3])
{
    const double sine = hypot(w[0], w[1]), c = sine > 0 ? w[0] / sine : 1, s = sine > 0 ? w[1] / sine : 0;
    const double along = k & 1 ? around : -around, across = k & 2 ? around : -around;
    /* the meridian's tangent points away from the normal */
    out[0] = w[0] + along * w[2] * c - across * s;
    out[1] = w[1] + along * w[2] * s + across * c;
    out[2] = w[2] - along * sine;
    return out[2] > 0;
}

size_t ff_cells_sides(const ff_cells *cells, const double wi[3], ff_cells_side side[FF_CELLS_SIDES])
{
    uint64_t in[FF_CELLS_SIDES];
    size_t n = 0;
    double all = 0;
    for (int k = 0; k < FF_CELLS_SIDES; k++) {
        double w[3];
        if (!beside(wi, k, w)) continue;
        const uint64_t cell = cells->incident(cells, w);
        size_t j = 0;
        while (j < n && in[j] != cell) j++;
        if (j == n) {
            in[n] = cell;
            side[n].weight = 0;
            memcpy(side[n++].wi, w, sizeof w);
        }
        side[j].weight += 1;
        all += 1;
    }
    for (size_t j = 0; j < n; j++) side[j].weight /= all;
    if (n > 1) return n;
    memcpy(side[0].wi, wi, sizeof side[0].wi);
    side[0].weight = 1;
    return 1;
}
