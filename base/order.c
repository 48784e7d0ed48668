/* Quickselect (Hoare 1961), the pivot the median of three; where that halves too slowly the rest is sorted. */
#include "internal_order.h"
#include <stdlib.h>

static double middle_of(double a, double b, double c)
{
    const double low = a < b ? a : b, high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

double ff_order_select(double *v, size_t n, size_t k)
{
    size_t first = 0, last = n - 1, left = 0;
    for (size_t size = n; size; size /= 2) left += 4;
    while (first < last && left-- > 0) {
        const double pivot = middle_of(v[first], v[first + (last - first) / 2], v[last]);
        size_t i = first, j = last;
        for (;;) { /* v[first .. i) <= pivot <= v(j .. last] */
            while (v[i] < pivot) i++;
            while (v[j] > pivot) j--;
            if (i >= j) break;
            const double x = v[i];
            v[i++] = v[j];
            v[j--] = x;
        }
        if (k <= j)
            last = j;
        else
            first = j + 1;
    }
    if (first < last) qsort(v + first, last - first + 1, sizeof *v, ff_ascending);
    return v[k];
}

double ff_order_median(double *v, size_t n)
{
    double high = ff_order_select(v, n, n / 2);
    if (n % 2) return high;
    double low = v[0];
    for (size_t i = 1; i < n / 2; i++) low = v[i] > low ? v[i] : low;
    return (low + high) / 2;
}
