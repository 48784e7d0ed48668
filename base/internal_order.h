/** @file internal_order.h  Orders for qsort. */
#ifndef FF_INTERNAL_ORDER_H
#define FF_INTERNAL_ORDER_H

/** Doubles, ascending; none may be NaN. */
static inline int ff_ascending(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
#endif
