/* How far the errors of neighbouring samples go together, and the outer products of the score over clusters of that length.
 *
 * Samples are in the order of the file, which is that of the scan. The score of a sample (J^T r of all its channels) is summed over
 * runs of 8, 16, 32, ... samples (of many samples 128, 256, ...). Were the errors independent, the sum of the squares of these sums
 * would be the same at every length, on average; it grows as long as a cluster is shorter than the errors' reach (the blocking
 * method of Flyvbjerg and Petersen 1989, here for the score of an M-estimator: clusters as in Liang and Zeger 1986). A length is
 * left for a longer one where the growth is more than twice its own scatter from cluster to cluster. */
#include "internal_information.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MIN_CLUSTERS = 20 }; /* fewer say nothing about their scatter ...                        */
enum { PER_PARAMETER = 3 }; /* ... nor do fewer than this many for each parameter of a channel  */

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

size_t ff_clusters_join(double *sums, size_t n, size_t P)
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
 * ones inside each of these; NULL when samples are the chosen ones, whose squares add up to 1: of runs of independent samples the
 * growth then has (2 - 2 / run) / 3 of the mean of u^2 for its variance. */
static int grows(const double *sums, const double *single, size_t n, size_t P, size_t run, const double *squares)
{
    const double share = (2 - 2 / (double)run) / 3;
    double growth = squares ? 0 : -1, scatter = 0;
    for (size_t b = 0; b < n; b++) {
        const double u = relative_square(sums + b * P, single, P), more = squares ? u - squares[b] : u;
        growth += more;
        scatter += squares ? more * more : share * u * u;
    }
    return growth > 2 * sqrt(scatter);
}

/* Root mean square residual over the mean datum, below which there is nothing but rounding. */
#define FF_ROUNDING 1e-9

static int is_rounding(const struct ff_problem *p, const ff_normal *n)
{
    double mean = 0;
    for (size_t c = 0; c < p->n_channels; c++) mean = fmax(mean, p->channel_mean[c]);
    return !(sqrt(n->stat[FF_STAT_PLAIN] / fmax(n->stat[FF_STAT_WEIGHT], 1e-300)) > FF_ROUNDING * mean);
}

size_t ff_clusters_centred(const struct ff_problem *p, const ff_normal *n, size_t n_samples, double *sums, double *mean)
{
    const size_t P = n->P, length = ff_run_length(p), runs = (p->n + length - 1) / length;
    const double share = (double)n_samples / (double)p->n;
    memset(mean, 0, P * sizeof *mean);
    for (size_t b = 0; b < runs; b++)
        for (size_t k = 0; k < P; k++) mean[k] += n->runs[b * P + k] / (double)n_samples;
    for (size_t b = 0; b < runs; b++) {
        const size_t left = p->n - b * length;
        const double count = share * (double)(left < length ? left : length);
        for (size_t k = 0; k < P; k++) sums[b * P + k] = n->runs[b * P + k] - count * mean[k];
    }
    return runs;
}

/* Sums of squares over single samples, less their mean. */
static double single_product(const ff_normal *n, size_t n_samples, const double *mean, size_t a, size_t b)
{
    return n->score_products[n->diagonal ? a : ff_tri(a, b)] - (double)n_samples * mean[a] * mean[b];
}

/* Doubles the runs, whose n_now centred sums come in and are joined, and stops where clusters would be too few. share: of the
 * samples that are in use. squares [n_now] */
static void lengthen(const ff_normal *n, double share, size_t n_now, size_t run, const double *single, double *sums,
                     double *squares, ff_clusters *out)
{
    const size_t P = n->P;
    int beyond = 0;
    while (share * (double)n_now >= MIN_CLUSTERS && share * (double)n_now >= (double)(PER_PARAMETER * (n->m1 - 1))) {
        const int moved = grows(sums, single, n_now, P, run, out->run > 1 ? squares : NULL);
        if (moved || (out->run > 1 && out->run * 2 == run && !beyond)) {
            beyond = !moved; /* the last that grew and one more: clusters of the errors' own length miss what reaches across their
                                ends */
            *out = (ff_clusters){.run = run, .n = (size_t)(share * (double)n_now)};
            for (size_t b = 0; b < n_now; b++) squares[b] = relative_square(sums + b * P, single, P);
        }
        out->settled = !moved;
        if (out->run > 1) join_squares(squares, n_now);
        n_now = ff_clusters_join(sums, n_now, P);
        run *= 2;
    }
}

ff_status ff_clusters_choose(const ff_plan *plan, const ff_normal *n, size_t n_samples, ff_clusters *out)
{
    const struct ff_problem *p = plan->p;
    const size_t P = n->P, length = ff_run_length(p), runs = (p->n + length - 1) / length;
    *out = (ff_clusters){.run = 1, .n = n_samples, .settled = 1};
    if (!n->runs || P == 0 || is_rounding(p, n)) return FF_OK;
    double *sums = malloc((runs * P + 1) * sizeof *sums), *squares = malloc((runs + 1) * sizeof *squares),
           *single = malloc((2 * P + 1) * sizeof *single), *mean = single + P;
    const ff_status status = sums && squares && single ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        const size_t n_now = ff_clusters_centred(p, n, n_samples, sums, mean);
        for (size_t k = 0; k < P; k++) /* one that is held in its channel is not asked: it has no error */
            single[k] = ff_layout_is_fixed(&plan->l, k) ? 0 : single_product(n, n_samples, mean, k, k);
        lengthen(n, (double)n_samples / (double)p->n, n_now, length, single, sums, squares, out);
    }
    free(sums);
    free(squares);
    free(single);
    return status;
}

/* Values that would say as much were they independent: fewer by what the squares of the score grow by from single values to
 * clusters. Of the shared parameters, where the channels of a sample meet; of all where none is free. */
double ff_clusters_effective(const ff_normal *n, const double *square, size_t n_shared, double n_values)
{
    const size_t P = n_shared ? n_shared : n->P;
    double growth = 0;
    size_t counted = 0;
    for (size_t k = 0; k < P; k++) {
        if (!(n->own[k] > 0)) continue;
        growth += square[k] / n->own[k];
        counted++;
    }
    return counted && growth > (double)counted ? n_values * (double)counted / growth : n_values;
}

/* ---- how many of them count ------------------------------------------------------------------ */

enum { FEWEST_COUNTED = 6 }; /* a smaller count is itself not known from so few */

/* (sum of the variances)^2 / sum of the clusters' squares, both without the scatter of what they are estimated from: of squares q_j
 * of normal variables E (sum q)^2 = (sum v)^2 + 2 sum v^2 and E sum q^2 = 3 sum v^2. all: sum q and sum q^2; squares: of the
 * clusters, sum of (sum q)^2 - 2/3 sum q^2. */
double ff_clusters_count(const double all[2], double squares, double n)
{
    const double count = squares > 0 ? (all[0] * all[0] - 2.0 / 3 * all[1]) / squares : n;
    return fmax(fmin(fmax(count, FEWEST_COUNTED), n), 2);
}

ff_status ff_clusters_informative(const struct ff_problem *p, const ff_normal *n, size_t n_samples, const uint32_t *cluster,
                                  size_t n_clusters, const ff_information *info, double *number)
{
    const size_t P = n->P, length = ff_run_length(p), runs = (p->n + length - 1) / length;
    double *sums = malloc((runs * P + 1) * sizeof *sums), *share = calloc(2 * n_clusters * P + 1, sizeof *share),
           *mean = malloc((3 * P + 1) * sizeof *mean), *of_run = mean + P;
    const ff_status status = sums && share && mean ? FF_OK : FF_ERR_MEMORY;
    if (!status) {
        ff_clusters_centred(p, n, n_samples, sums, mean);
        for (size_t b = 0; b < runs; b++) {
            double *to = share + 2 * (cluster ? cluster[b * length] : b * n_clusters / runs) * P;
            ff_information_influence(info, n, sums + b * P, of_run);
            for (size_t k = 0; k < P; k++) {
                const double square = of_run[k] * of_run[k];
                to[2 * k] += square;
                to[2 * k + 1] += square * square;
            }
        }
        for (size_t k = 0; k < P; k++) {
            double all[2] = {0}, squares = 0;
            for (size_t c = 0; c < n_clusters; c++) {
                const double *q = share + 2 * (c * P + k);
                all[0] += q[0];
                all[1] += q[1];
                squares += q[0] * q[0] - 2.0 / 3 * q[1];
            }
            number[k] = ff_clusters_count(all, squares, (double)n_clusters);
        }
    }
    free(sums);
    free(share);
    free(mean);
    return status;
}

/* 1 - 1/G where the errors inside a cluster are independent, near 1 - m/G where they are one error, since a fit of m parameters
 * follows each cluster a little (Bell and McCaffrey 2002): two thirds of the way, and no less than a half. */
double ff_clusters_share_seen(double parameters, double number)
{
    return fmax(1 - (1 + 2 * parameters) / (3 * number), 0.5);
}
