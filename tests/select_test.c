/* What has a place in an order, against sorting: of random values, of many alike, of what is sorted already, of what is hard for
 * pivots. */
#include "base/internal_order.h"
#include "ff_test.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 5000, KINDS = 6 };
static double given[MOST], sorted[MOST], v[MOST];

static void fill(int kind, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const double u = ff_test_uniform(), x = (double)i, half = (double)n / 2;
        given[i] = kind == 0   ? u
                   : kind == 1 ? floor(5 * u)
                   : kind == 2 ? x
                   : kind == 3 ? -x
                   : kind == 4 ? -fabs(x - half)
                               : (i % 2 ? x : (double)n - x);
    }
    memcpy(sorted, given, n * sizeof *given);
    qsort(sorted, n, sizeof *sorted, ff_ascending);
}

static int is_split(size_t n, size_t k)
{
    int good = 1;
    for (size_t i = 0; i < n; i++) good &= i < k ? v[i] <= v[k] : v[i] >= v[k];
    return good;
}

static void places(void)
{
    static const size_t sizes[] = {1, 2, 3, 4, 5, 17, 100, MOST};
    for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++)
        for (int kind = 0; kind < KINDS; kind++) {
            const size_t n = sizes[s], step = n > 100 ? 37 : 1;
            fill(kind, n);
            for (size_t k = 0; k < n; k += step) {
                memcpy(v, given, n * sizeof *v);
                const double got = ff_order_select(v, n, k);
                FF_CHECK(got == sorted[k] && is_split(n, k), "kind %d, %zu of %zu: %g, not %g", kind, k, n, got, sorted[k]);
                qsort(v, n, sizeof *v, ff_ascending);
                FF_CHECK(!memcmp(v, sorted, n * sizeof *v), "kind %d, %zu of %zu: other values than before", kind, k, n);
            }
            memcpy(v, given, n * sizeof *v);
            const double middle = ff_order_median(v, n), wanted = (sorted[(n - 1) / 2] + sorted[n / 2]) / 2;
            FF_CHECK(middle == wanted, "kind %d of %zu: median %g, not %g", kind, n, middle, wanted);
        }
}

FF_TEST_MAIN(FF_TEST(places))
