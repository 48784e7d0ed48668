/* What a final pass has left for the errors, in coordinates: columns of one coordinate added up. */
#include "internal_layout.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Coordinate of column i of all channels' columns. */
static size_t coordinate_of(const ff_layout *l, size_t i)
{
    const size_t shape = l->free.n_shape, own = l->free.n_channel;
    return i < shape ? l->shape_at[i] : ff_layout_coordinate(l, (i - shape) / own, shape + (i - shape) % own);
}

/* Squares of the score of single values add up over channels; of columns that meet in one value their sum is not known, -1 says so.
 */
static double fold_own(const ff_layout *l, size_t i, double before, double square)
{
    const size_t at = coordinate_of(l, i), shape = l->free.n_shape;
    for (size_t k = 0; k < shape + l->free.n_channel; k++) {
        const size_t c = i < shape ? 0 : (i - shape) / l->free.n_channel,
                     column = i < shape ? i : shape + (i - shape) % l->free.n_channel;
        if (k != column && ff_layout_coordinate(l, c, k) == at) return -1;
    }
    return before < 0 ? before : before + square;
}

ff_status ff_normal_fold(const ff_layout *l, ff_normal *n)
{
    const size_t P = l->P, from = n->P;
    if (from == P) return FF_OK;
    double *score_products = calloc(P * (P + 1) / 2 + 1, sizeof *score_products), *own = calloc(P + 1, sizeof *own),
           *sums = malloc((P + 1) * sizeof *sums);
    const ff_status status = score_products && own && sums ? FF_OK : FF_ERR_MEMORY;
    for (size_t i = 0; i < from && !status; i++) {
        const size_t a = coordinate_of(l, i);
        for (size_t j = 0; j < from; j++) {
            const size_t b = coordinate_of(l, j);
            if (a >= b) score_products[ff_tri(a, b)] += n->score_products[ff_tri(i, j)];
        }
        own[a] = fold_own(l, i, own[a], n->own[i]);
    }
    for (size_t k = 0; k < P && !status; k++) own[k] = fmax(own[k], 0);
    for (size_t r = 0; n->runs && r < n->n_runs && !status; r++) { /* shorter rows: in place */
        memset(sums, 0, P * sizeof *sums);
        for (size_t i = 0; i < from; i++) sums[coordinate_of(l, i)] += n->runs[r * from + i];
        memcpy(n->runs + r * P, sums, P * sizeof *sums);
    }
    free(sums);
    if (status) {
        free(score_products);
        free(own);
        return status;
    }
    free(n->score_products);
    free(n->own);
    n->score_products = score_products;
    n->own = own;
    n->P = P;
    return FF_OK;
}
