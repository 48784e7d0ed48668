/* How far the errors of neighbouring samples go together, and the outer products of the score over clusters of that length.
 *
 * Samples are in the order of the file, which is that of the scan. The score of a sample (J^T r of all its channels) is summed over runs
 * of FF_RUN, 2 FF_RUN, 4 FF_RUN, ... samples. Were the errors independent, the sum of the squares of these sums would be the same at
 * every length, on average; it grows as long as a cluster is shorter than the errors' reach (the blocking method of Flyvbjerg and
 * Petersen 1989, here for the score of an M-estimator: clusters as in Liang and Zeger 1986). A length is left for a longer one where
 * the growth is more than twice its own scatter from cluster to cluster. */
#include "internal_fit.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MIN_CLUSTERS = 20 };   /* fewer say nothing about their scatter ...                        */
enum { PER_PARAMETER = 3 };   /* ... nor do fewer than this many for each parameter               */
#define FF_SINGLE_SCATTER 0.6 /* of sum u^2 for runs of independent samples: (2 - 2/FF_RUN) / 3    */

/* The squares of a cluster's sums relative to those of single samples, a mean over the parameters. */
static double relative_square(const double *sum, const double *single, size_t P)
{
    double total = 0;
    size_t n = 0;
    for (size_t k = 0; k < P; k++) {
        if (!(single[k] > 0)) continue;
        total += sum[k] * sum[k] / single[k];
        n++;
    }
    return n ? total / (double)n : 0;
}

/* Joins pairs of clusters; a last one without partner stays. */
static size_t join_sums(double *sums, size_t n, size_t P)
{
    const size_t half = (n + 1) / 2;
    for (size_t b = 0; b < half; b++)
        for (size_t k = 0; k < P; k++) sums[b * P + k] = sums[2 * b * P + k] + (2 * b + 1 < n ? sums[(2 * b + 1) * P + k] : 0);
    return half;
}

static void join_squares(double *squares, size_t n)
{
    for (size_t b = 0; b < (n + 1) / 2; b++) squares[b] = squares[2 * b] + (2 * b + 1 < n ? squares[2 * b + 1] : 0);
}

/* Does the total of the squares grow from the chosen clusters to these by more than twice its scatter? squares [n]: of the chosen
 * ones inside each of these; NULL when samples are the chosen ones, whose squares add up to 1. */
static int grows(const double *sums, const double *single, size_t n, size_t P, const double *squares)
{
    double growth = squares ? 0 : -1, scatter = 0;
    for (size_t b = 0; b < n; b++) {
        const double u = relative_square(sums + b * P, single, P), more = squares ? u - squares[b] : u;
        growth += more;
        scatter += squares ? more * more : FF_SINGLE_SCATTER * u * u;
    }
    return growth > 2 * sqrt(scatter);
}

ff_status ff_clusters_choose(const ff_normal *n, size_t n_samples, ff_clusters *out)
{
    const size_t P = n->P;
    *out = (ff_clusters){.run = 1, .n = n_samples, .settled = 1};
    if (!n->runs || P == 0) return FF_OK;
    size_t n_now = (n_samples + FF_RUN - 1) / FF_RUN, run = FF_RUN;
    double *sums = malloc((n_now * P + 1) * sizeof *sums), *squares = malloc((n_now + 1) * sizeof *squares),
           *single = malloc((P + 1) * sizeof *single);
    ff_status st = sums && squares && single ? FF_OK : FF_ERR_MEMORY;
    if (!st) {
        memcpy(sums, n->runs, n_now * P * sizeof *sums);
        for (size_t k = 0; k < P; k++) single[k] = n->meat[ff_tri(k, k)];
    }
    while (!st && n_now >= MIN_CLUSTERS && n_now >= PER_PARAMETER * P) {
        const int moved = grows(sums, single, n_now, P, out->run > 1 ? squares : NULL);
        if (moved) {
            *out = (ff_clusters){.run = run, .n = n_now};
            for (size_t b = 0; b < n_now; b++) squares[b] = relative_square(sums + b * P, single, P);
        }
        out->settled = !moved;
        if (out->run > 1) join_squares(squares, n_now);
        n_now = join_sums(sums, n_now, P);
        run *= 2;
    }
    free(sums);
    free(squares);
    free(single);
    return st;
}

ff_status ff_clusters_meat(const ff_normal *n, size_t n_samples, size_t run, double *meat)
{
    const size_t P = n->P, at_once = run / FF_RUN, all = (n_samples + FF_RUN - 1) / FF_RUN;
    if (run == 1) {
        memcpy(meat, n->meat, P * (P + 1) / 2 * sizeof *meat);
        return FF_OK;
    }
    double *sum = malloc((P + 1) * sizeof *sum);
    if (!sum) return FF_ERR_MEMORY;
    memset(meat, 0, P * (P + 1) / 2 * sizeof *meat);
    for (size_t first = 0; first < all; first += at_once) {
        memset(sum, 0, P * sizeof *sum);
        for (size_t b = first; b < first + at_once && b < all; b++)
            for (size_t k = 0; k < P; k++) sum[k] += n->runs[b * P + k];
        for (size_t a = 0; a < P; a++)
            for (size_t b = 0; b <= a; b++) meat[ff_tri(a, b)] += sum[a] * sum[b];
    }
    free(sum);
    return FF_OK;
}

/* Values that would say as much were they independent: fewer by what the squares of the score grow by from single values to clusters.
 * Of the shared parameters, where the channels of a sample meet; of all where none is free. */
double ff_clusters_effective(const ff_normal *n, const double *meat, size_t n_shape, double n_values)
{
    const size_t P = n_shape ? n_shape : n->P;
    double growth = 0;
    size_t counted = 0;
    for (size_t k = 0; k < P; k++) {
        if (!(n->own[k] > 0)) continue;
        growth += meat[ff_tri(k, k)] / n->own[k];
        counted++;
    }
    return counted && growth > (double)counted ? n_values * (double)counted / growth : n_values;
}
