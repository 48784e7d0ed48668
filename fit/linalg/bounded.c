/* Least squares in a box, of a few unknowns. */
#include "internal_linalg.h"
#include <math.h>

/* Solves the k x k system A x = b, symmetric positive semidefinite, by elimination with diagonal pivots; a vanishing pivot gives 0.
 */
static void solve_small(double *A, double *b, size_t k, double *x)
{
    double diagonal[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < k; i++) diagonal[i] = A[i * k + i];
    for (size_t i = 0; i < k; i++) {
        if (!(A[i * k + i] > 1e-13 * diagonal[i])) {
            A[i * k + i] = 0;
            continue;
        }
        for (size_t r = i + 1; r < k; r++) {
            const double f = A[r * k + i] / A[i * k + i];
            for (size_t c = i; c < k; c++) A[r * k + c] -= f * A[i * k + c];
            b[r] -= f * b[i];
        }
    }
    for (size_t i = k; i-- > 0;) {
        double sum = b[i];
        for (size_t c = i + 1; c < k; c++) sum -= A[i * k + c] * x[c];
        x[i] = A[i * k + i] > 0 ? sum / A[i * k + i] : 0;
    }
}

/* |r + L q|^2 from the packed gram of [L r]. */
static double quadratic(const double *gram, size_t n, const double *q)
{
    double sum = gram[ff_tri(n, n)];
    for (size_t a = 0; a < n; a++) {
        sum += 2 * q[a] * gram[ff_tri(n, a)];
        for (size_t b = 0; b < n; b++) sum += q[a] * q[b] * gram[ff_tri(a, b)];
    }
    return sum;
}

/* The minimum over the free parameters (state 2) with the others at their lower (0) or upper (1) bound; x [n]. */
static void minimise_free(const double *gram, size_t n, const double *lo, const double *hi, const int *state, double *x)
{
    size_t free_index[FF_MAX_CHANNEL_PARAMS], k = 0;
    double A[FF_MAX_CHANNEL_PARAMS * FF_MAX_CHANNEL_PARAMS], b[FF_MAX_CHANNEL_PARAMS], y[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < n; i++) {
        x[i] = state[i] == 0 ? lo[i] : hi[i];
        if (state[i] == 2) free_index[k++] = i;
    }
    for (size_t r = 0; r < k; r++) {
        b[r] = -gram[ff_tri(n, free_index[r])];
        for (size_t i = 0; i < n; i++)
            if (state[i] != 2) b[r] -= gram[ff_tri(free_index[r], i)] * x[i];
        for (size_t c = 0; c < k; c++) A[r * k + c] = gram[ff_tri(free_index[r], free_index[c])];
    }
    solve_small(A, b, k, y);
    for (size_t r = 0; r < k; r++) x[free_index[r]] = y[r];
}

/* How far from q towards x all stay in the box, at most 1; the parameter that stops it, and at which bound. */
static double way_to_wall(size_t n, const double *lo, const double *hi, const double *q, const double *x, size_t *which, int *bound)
{
    double step = 1;
    for (size_t i = 0; i < n; i++) {
        const int up = x[i] > hi[i];
        if (!up && !(x[i] < lo[i])) continue;
        const double s = ((up ? hi[i] : lo[i]) - q[i]) / (x[i] - q[i]);
        if (s >= step) continue;
        step = fmax(s, 0);
        *which = i;
        *bound = up;
    }
    return step;
}

/* The parameter at a bound that the objective pulls inside the most, -1 when none does. Where the bounds are one, there is no
 * inside. */
static int pulled_inside(const double *gram, size_t n, const double *lo, const double *hi, const double *q, const int *state)
{
    int which = -1;
    double most = 1e-12;
    for (size_t i = 0; i < n; i++) {
        double slope = gram[ff_tri(n, i)];
        for (size_t k = 0; k < n; k++) slope += gram[ff_tri(i, k)] * q[k];
        const double scale = sqrt(gram[ff_tri(i, i)] * gram[ff_tri(n, n)]);
        const double pull = state[i] == 2 || !(scale > 0) || lo[i] == hi[i] ? 0 : (state[i] ? slope : -slope) / scale;
        if (pull > most) most = pull, which = (int)i;
    }
    return which;
}

/* Active sets: from a point in the box to the minimum over what is free, as far as the walls allow, until no bound is worth leaving
 * (Lawson and Hanson 1974, chapter 23; Stark and Parker 1995). Convex, so that the end is the minimum. */
double ff_bounded_least_squares(const double *gram, size_t n, const double *lo, const double *hi, double *q)
{
    int state[FF_MAX_CHANNEL_PARAMS] = {0};
    double x[FF_MAX_CHANNEL_PARAMS];
    for (size_t i = 0; i < n; i++) {
        state[i] = 2;
        q[i] = fmin(fmax(0, lo[i]), hi[i]);
    }
    for (size_t step = 0; step < 8 * n + 8; step++) {
        size_t wall = 0;
        int bound = 0;
        minimise_free(gram, n, lo, hi, state, x);
        const double way = way_to_wall(n, lo, hi, q, x, &wall, &bound);
        for (size_t i = 0; i < n; i++) q[i] = state[i] == 2 ? fmin(fmax(q[i] + way * (x[i] - q[i]), lo[i]), hi[i]) : x[i];
        if (way < 1) {
            state[wall] = bound;
            q[wall] = bound ? hi[wall] : lo[wall];
            continue;
        }
        const int leave = pulled_inside(gram, n, lo, hi, q, state);
        if (leave < 0) break;
        state[leave] = 2;
    }
    return quadratic(gram, n, q);
}
