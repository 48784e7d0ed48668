/* How long the clusters are that errors of neighbouring samples are summed over, and how many of them count: asked by hand. */
#include "ff_test.h"
#include "fit/errors/internal_errors.h"
#include "fit/pass/internal_pass.h"

enum { RUNS = 64, RUN = 8 };

/* Scores of one parameter: every run of 8 samples sums up to +-1, in turn, so that their mean is 0, and the squares of the samples
 * to RUNS / total. The total of the squares of the runs is then `total`, relative to that of the samples. */
static ff_clusters chosen(double total)
{
    double runs[RUNS], score_products = RUNS / total, mean = 1;
    const struct ff_problem p = {.n = RUNS * RUN, .n_channels = 1, .channel_mean = &mean};
    const ff_plan plan = {.p = &p};
    ff_normal n = {.m1 = 2, .P = 1, .n_channels = 1, .score_products = &score_products, .n_runs = RUNS, .runs = runs};
    ff_clusters c = {0};
    for (int b = 0; b < RUNS; b++) runs[b] = b % 2 ? -1 : 1;
    n.stat[FF_STAT_PLAIN] = n.stat[FF_STAT_WEIGHT] = RUNS * RUN;
    FF_CHECK(ff_run_length(&p) == RUN, "a run is %zu samples, expected %d", ff_run_length(&p), RUN);
    FF_CHECK(ff_clusters_choose(&plan, &n, p.n, &c) == FF_OK, "no clusters");
    return c;
}

/* A run of L independent samples has a sum of the variance v = L s^2. Of normal ones, u = (sum)^2 grows from the sum of the L
 * squares by something of the mean 0 and the variance 2 L (L - 1) s^4, which is (2 - 2 / L) / 3 of the mean of u^2, 3 v^2. Clusters
 * are made where the growth of all RUNS is more than twice that scatter: total - 1 > 2 sqrt((2 - 2 / L) / 3 RUNS (total / RUNS)^2).
 */
static void growth_that_counts(void)
{
    const double per_total = 2 * sqrt((2 - 2.0 / RUN) / 3 / RUNS), limit = 1 / (1 - per_total);
    const ff_clusters below = chosen(limit * 0.999), above = chosen(limit * 1.001);
    FF_CHECK(limit > 1.2 && limit < 1.3, "the limit is %g", limit);
    FF_CHECK(below.run == 1 && below.n == RUNS * RUN, "below the limit: clusters of %zu samples", below.run);
    FF_CHECK(above.run > 1, "above the limit: no clusters");
    FF_CHECK(chosen(0.5).run == 1, "squares that fall are no sign of clusters");
}

/* Two and two; the last one is alone where their number is odd. */
static void joined(void)
{
    double sums[] = {1, 10, 2, 20, 4, 40, 8, 80, 16, 160};
    static const double expected[] = {3, 30, 12, 120, 16, 160};
    FF_CHECK(ff_clusters_join(sums, 5, 2) == 3, "five make three");
    for (int k = 0; k < 6; k++) FF_CHECK(sums[k] == expected[k], "%d: %g, expected %g", k, sums[k], expected[k]);
}

/* Sums of normal clusters with known variances, drawn often: the mean of (sum q)^2 - 2/3 sum q^2 is (sum v)^2, that of sum q^2 is
 * 3 sum v^2, so that the count of what is drawn once lies around (sum v)^2 / sum v^2 in the mean of its parts. */
static void count_of_unequal_clusters(void)
{
    enum { CLUSTERS = 40, DRAWS = 20000 };
    double above = 0, below = 0, of_variances[2] = {0};
    for (int d = 0; d < DRAWS; d++) {
        double all[2] = {0};
        for (int c = 0; c < CLUSTERS; c++) {
            const double v = c < 10 ? 4 : 1, z = sqrt(-2 * log(1 - ff_test_uniform())) * cos(6.283185307179586 * ff_test_uniform()),
                         q = v * z * z;
            all[0] += q;
            all[1] += q * q;
            if (d == 0) of_variances[0] += v, of_variances[1] += v * v;
        }
        /* each cluster is one run: (sum q)^2 - 2/3 sum q^2 of it is q^2 / 3 */
        above += ff_clusters_count(all, 1, 1e300) / DRAWS; /* the numerator alone */
        below += all[1] / 3 / DRAWS;
    }
    const double expected = of_variances[0] * of_variances[0] / of_variances[1];
    FF_CHECK(fabs(above / below - expected) < 0.05 * expected, "%g count, expected %g", above / below, expected);
    FF_CHECK_CLOSE(ff_clusters_count((double[]){10, 12}, 6, 100), (100 - 8) / 6.0, 1e-15, 0);
    FF_CHECK(ff_clusters_count((double[]){10, 12}, 6, 9) == 9, "no more than there are");
    FF_CHECK(ff_clusters_count((double[]){10, 12}, 60, 100) == 6, "fewer than six are not known to be so few");
    FF_CHECK(ff_clusters_count((double[]){0, 0}, 0, 30) == 30, "clusters without a score");
}

static void share_that_a_fit_sees(void)
{
    FF_CHECK_CLOSE(ff_clusters_share_seen(2, 30), 1 - 5.0 / 90, 1e-15, 0);
    FF_CHECK_CLOSE(ff_clusters_share_seen(0, 10), 1 - 1.0 / 30, 1e-15, 0);
    FF_CHECK(ff_clusters_share_seen(9, 10) == 0.5, "no less than a half");
}

FF_TEST_MAIN(FF_TEST(growth_that_counts), FF_TEST(joined), FF_TEST(count_of_unequal_clusters), FF_TEST(share_that_a_fit_sees))
