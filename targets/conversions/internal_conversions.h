/* What the files of conversions share: how a value of a convention is written, so that it is the same in every conversion that
 * takes or gives it, and functions that several need. */
#ifndef FF_INTERNAL_CONVERSIONS_H
#define FF_INTERNAL_CONVERSIONS_H
#include "ff_convert.h"
#include <math.h>

/* The conversions of one file; conversions.def lists the files. */
typedef struct ff_conversion_group {
    const ff_conversion *at;
    size_t n;
} ff_conversion_group;

#define FF_CONVERSION_GROUP(name, list)                                                                                            \
    extern const ff_conversion_group ff_conversions_##name;                                                                        \
    const ff_conversion_group ff_conversions_##name = {list, sizeof list / sizeof *list}

/* clang-format off */
#define V_M(end)      {.name = "m", .alias = "alpha", .unit = "1", .lo = 0, .hi = end}
#define V_N(least)    {.name = "n", .unit = "1", .lo = least, .hi = INFINITY}
#define V_ALPHA       {.name = "alpha", .unit = "1", .lo = 0, .hi = INFINITY}
#define V_POSITIVE(n) {.name = n, .unit = "1", .lo = 0, .hi = INFINITY}
#define V_R           {.name = "r_xy", .unit = "1", .lo = -1, .hi = 1}
#define V_PHI         {.name = "phi", .unit = "rad", .lo = -INFINITY, .hi = INFINITY}
#define V_F0          {.name = "f0", .unit = "1", .lo = 0, .hi = 1, .lo_included = 1}
#define V_ETA(l, at)  {.name = "eta", .alias = "ior", .unit = "1", .lo = l, .hi = INFINITY, .lo_included = at}
#define V_FROM(n, l)  {.name = n, .unit = "1", .lo = l, .hi = INFINITY, .lo_included = 1}
/* clang-format on */

#define FF_CONVERSION_PI 3.14159265358979323846

/* out = in: two names of one number. */
const char *ff_conversion_same(const double *in, double *out);

#endif
