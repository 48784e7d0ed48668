/* The normal equations of a pass in coordinates, channel by channel: columns of one coordinate added up. */
#include "internal_layout.h"
#include <stdlib.h>
#include <string.h>

ff_status ff_gram_new(const ff_layout *l, ff_gram *out)
{
    ff_gram g = {.S = l->n_shared, .K = l->n_own, .C = l->n_channels};
    const size_t m1 = g.S + g.K + 1;
    g.tri = m1 * (m1 + 1) / 2;
    g.local = calloc(g.C * g.tri + 1, sizeof *g.local);
    if (!g.local) return FF_ERR_MEMORY;
    *out = g;
    return FF_OK;
}

void ff_gram_free(ff_gram *g)
{
    free(g->local);
    g->local = NULL;
}

/* From parameters to coordinates. */
static void scale(const ff_gram *g, size_t c, const double *slope, double *local)
{
    const size_t m = g->S + g->K;
    for (size_t i = 0; i <= m; i++) {
        const double by_i = i < m ? slope[ff_gram_coordinate(g, c, i)] : 1;
        for (size_t j = 0; j <= i; j++) local[ff_tri(i, j)] *= by_i * (j < m ? slope[ff_gram_coordinate(g, c, j)] : 1);
    }
}

void ff_gram_fill(const ff_layout *l, const ff_normal *n, const double *slope, ff_gram *out)
{
    const size_t columns = n->m1 - 1, tri = n->m1 * (n->m1 + 1) / 2;
    size_t place[FF_MAX_COLUMNS];
    for (size_t a = 0; a < columns; a++) place[a] = ff_layout_coordinate(l, 0, a);
    place[columns] = out->S + out->K;
    memset(out->local, 0, out->C * out->tri * sizeof *out->local);
    for (size_t c = 0; c < out->C; c++) {
        const double *from = n->gram + c * tri;
        double *to = out->local + c * out->tri;
        for (size_t a = 0; a <= columns; a++)
            for (size_t b = 0; b <= a; b++) /* two columns of one coordinate meet twice on its diagonal */
                to[ff_tri(place[a], place[b])] += from[ff_tri(a, b)] * (a != b && place[a] == place[b] ? 2 : 1);
        if (slope) scale(out, c, slope, to);
    }
    out->cost2 = n->cost2;
}

void ff_gram_dense(const ff_gram *g, double *H, double *gradient)
{
    const size_t P = g->S + g->C * g->K, m = g->S + g->K;
    memset(H, 0, P * P * sizeof *H);
    memset(gradient, 0, P * sizeof *gradient);
    for (size_t c = 0; c < g->C; c++) {
        const double *local = g->local + c * g->tri;
        for (size_t a = 0; a < m; a++) {
            const size_t i = ff_gram_coordinate(g, c, a);
            gradient[i] += local[ff_tri(m, a)];
            for (size_t b = 0; b < m; b++) H[i * P + ff_gram_coordinate(g, c, b)] += local[ff_tri(a, b)];
        }
    }
}

void ff_gram_gradient(const ff_gram *g, double *gradient)
{
    const size_t m = g->S + g->K;
    memset(gradient, 0, (g->S + g->C * g->K) * sizeof *gradient);
    for (size_t c = 0; c < g->C; c++)
        for (size_t a = 0; a < m; a++) gradient[ff_gram_coordinate(g, c, a)] += g->local[c * g->tri + ff_tri(m, a)];
}

void ff_gram_add_row(ff_gram *g, size_t c, double weight, double residual, const double *row)
{
    const size_t m = g->S + g->K;
    double *local = g->local + c * g->tri;
    g->cost2 += weight * residual * residual;
    local[ff_tri(m, m)] += weight * residual * residual;
    for (size_t i = 0; i < m; i++) {
        if (row[i] == 0) continue;
        local[ff_tri(m, i)] += weight * residual * row[i];
        for (size_t j = 0; j <= i; j++) local[ff_tri(i, j)] += weight * row[i] * row[j];
    }
}
