/* When a coordinate is on its bound. */
#include "internal_minimise.h"
#include <math.h>

#define FF_NEAR 1e-10 /* of the box or of the data: a coordinate that is no further from a bound is on it */

/* What coordinate k of channel c moves its residuals by, squared, and how large these and the parts of the model are that belong to
 * the channel's parameters. */
static void effect_in(const ff_layout *l, const ff_gram *g, const double *x, size_t k, size_t c, double *effect2, double *size2)
{
    const size_t m = g->S + g->K;
    const double *local = g->local + c * g->tri;
    *size2 += local[ff_tri(m, m)];
    for (size_t a = 0; a < m; a++) {
        const size_t at = ff_gram_coordinate(g, c, a);
        const ff_model_param *p = ff_layout_param(l, at, NULL);
        if (!ff_is_of_channel(l->m, p)) continue;
        const double value = ff_coordinate_value(p->info, x[at]), slope = ff_coordinate_slope(p->info, value),
                     h = local[ff_tri(a, a)];
        *size2 += h * (value / slope) * (value / slope);
        if (at == k) *effect2 += h;
    }
}

/* A parameter of a channel has the scale of the data, which may be a millionth of its box: near is what is lost beside the data. */
static double near_bound(const ff_layout *l, const ff_gram *g, const double *x, size_t k, double span)
{
    size_t c, end;
    double effect2 = 0, size2 = 0;
    (void)ff_layout_param(l, k, &c);
    end = k < l->n_shared ? l->n_channels : c + 1;
    for (; c < end; c++) effect_in(l, g, x, k, c, &effect2, &size2);
    return FF_NEAR * (effect2 > 0 ? fmin(span, sqrt(size2 / effect2)) : span);
}

int ff_bound_of(const ff_layout *l, const ff_gram *g, const double *x, double lower, double upper, size_t k)
{
    const double to_lower = x[k] - lower, to_upper = upper - x[k], distance = fmin(to_lower, to_upper);
    if (distance > FF_NEAR * (upper - lower)) return 0;
    if (distance > 0 && distance > near_bound(l, g, x, k, upper - lower)) return 0;
    return to_lower <= to_upper ? -1 : 1;
}
