/* Curves of directional albedo at given cosines; see coupling.c. Compiled once per instruction set. */
#include "internal_compose.h"
#include "base/internal_vector_math.h"
#include <string.h>

/* x in [from, to] -> [-1, 1] */
static inline double within(double x, double from, double to)
{
    return (2 * x - (from + to)) * (1 / (to - from));
}

/* The variable t in [-1, 1] of a piece in which 1 - t goes as the root of the distance from its end. */
static inline double root_within(double x, double from, double to)
{
    const double distance = (to - x) * (1 / (to - from));
    const double d = 0.5 * (distance + fabs(distance)) + 1e-30; /* a choice would be made after the root, of negative numbers too */
    return 1 - 2 * d * ff_rsqrt(d);
}

void ff_albedo_place_of(size_t n, const double *restrict mu, ff_albedo_place *place)
{
    const double lowest = FF_ALBEDO_X_0 * FF_ALBEDO_X_0 * FF_ALBEDO_X_0;
    for (size_t i = 0; i < n; i++) {
        const double m = mu[i] > lowest ? mu[i] : lowest, inv = ff_rcbrt(m), x = m * inv * inv;
        place->x[i] = x;
        place->middle[i] = root_within(x, FF_ALBEDO_X_1, FF_ALBEDO_X_2);
        place->last[i] = root_within(x, FF_ALBEDO_X_2, 1);
    }
}

void ff_albedo_values(const ff_albedo_curve *curve, uint32_t function, size_t n, const ff_albedo_place *place, double *restrict out)
{
    double c[FF_ALBEDO_COEFFICIENTS]; /* a local copy: the compiler then knows that the stores below leave it alone */
    const double *restrict c1 = c + FF_ALBEDO_PIECE_0, *restrict c2 = c1 + FF_ALBEDO_PIECE_1;
    memcpy(c, curve->coefficient + function * FF_ALBEDO_COEFFICIENTS, sizeof c);
    for (size_t i = 0; i < n; i++) {
        const double x = place->x[i];
        const double v0 = ff_polynomial(FF_ALBEDO_PIECE_0, c, within(x, FF_ALBEDO_X_0, FF_ALBEDO_X_1));
        const double v1 = ff_polynomial(FF_ALBEDO_PIECE_1, c1, place->middle[i]);
        const double v2 = ff_polynomial(FF_ALBEDO_PIECE_2, c2, place->last[i]);
        out[i] = x < FF_ALBEDO_X_1 ? v0 : x < FF_ALBEDO_X_2 ? v1 : v2;
    }
    if (!curve->over_cosine) return;
    for (size_t i = 0; i < n; i++) {
        const double x = place->x[i];
        out[i] *= ff_recip(x * x * x);
    }
}

void ff_albedo_at(const ff_albedo_curve *curve, uint32_t function, size_t n, const double *restrict mu, double *restrict out)
{
    ff_albedo_place place;
    ff_albedo_place_of(n, mu, &place);
    ff_albedo_values(curve, function, n, &place, out);
}
