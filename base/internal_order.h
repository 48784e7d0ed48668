/** @file internal_order.h  Orders for qsort, and what has a place in an order without all being sorted. */
#ifndef FF_INTERNAL_ORDER_H
#define FF_INTERNAL_ORDER_H
#include <stddef.h>

/** Doubles, ascending; none may be NaN. */
static inline int ff_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/** What v [n], n > k, none NaN, would have at k if it were sorted; v is rearranged: v[0 .. k) <= v[k] <= v(k .. n). Time in
 *  proportion to n on average, never more than that of sorting by a factor. */
double ff_order_select(double *v, size_t n, size_t k);

/** The median of v [n], n > 0, none NaN: of an even n the mean of both in the middle. v is rearranged. */
double ff_order_median(double *v, size_t n);
#endif
