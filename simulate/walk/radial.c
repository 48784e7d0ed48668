/* Radii of the unit surface drawn by tables, for any distribution: from the cumulative masses of 2 pi q p and 2 pi q^2 p over q. */
#define FF_ISA_SUFFIX scalar
#include "internal_walk.h"
#include "models/terms/internal_isotropic.h"
#include "base/internal_gauss.h"
#include <math.h>
#include <stdlib.h>

/* Equal panels of y = ln q. What lies within e^-60 is p(0) and no more; how much may lie beyond e^150. */
enum { OF_ONE = 16, PANELS = OF_ONE * 210 }; /* OF_ONE: panels while y grows by 1 */
#define Y_FIRST (-60.)
#define Y_LAST  150.
static const double beyond = 1e-6;

/* Up to panel k: the mass inside, that outside, and the density by y. */
typedef struct masses {
    double inside[PANELS + 1], outside[PANELS + 1], density[PANELS + 1];
} masses;

static double y_at(int k)
{
    return Y_FIRST + (Y_LAST - Y_FIRST) / PANELS * k;
}

/* 2 pi q^(power + 2) p by y, of n <= FF_BLOCK places. */
static void density(const ff_ndf *ndf, const ff_ndf_pass *pass, int power, size_t n, const double *y, double *out)
{
    double q2[FF_BLOCK], dlnp[FF_BLOCK];
    for (size_t i = 0; i < n; i++) q2[i] = exp(2 * y[i]);
    ndf->profile(pass, n, q2, out, dlnp, NULL);
    for (size_t i = 0; i < n; i++) out[i] *= 2 * FF_PI * exp((power + 2) * y[i]);
}

/* 0 where too much lies beyond the last panel. What falls as a power law there holds density / fall. */
static int masses_fill(const ff_ndf *ndf, const ff_ndf_pass *pass, int power, masses *m)
{
    double y[FF_GAUSS], w[FF_GAUSS], d[FF_GAUSS];
    for (int k = 0; k <= PANELS; k++) {
        const double at = y_at(k);
        density(ndf, pass, power, 1, &at, &m->density[k]);
    }
    m->inside[0] = m->density[0] / (power + 2);
    for (int k = 0; k < PANELS; k++) {
        double sum = 0;
        ff_gauss_panels(y_at(k), y_at(k + 1), 1, y, w);
        density(ndf, pass, power, FF_GAUSS, y, d);
        for (int i = 0; i < FF_GAUSS; i++) sum += w[i] * d[i];
        m->outside[k] = sum;
        m->inside[k + 1] = m->inside[k] + sum;
    }
    const double last = m->density[PANELS], before = m->density[PANELS - OF_ONE];
    const double fall = last > 0 ? log(before / last) : INFINITY;
    m->outside[PANELS] = last > 0 && fall > 0 ? last / fall : 0;
    if (last > 0 && !(fall > 0 && m->outside[PANELS] < beyond * m->inside[PANELS])) return 0;
    for (int k = PANELS - 1; k >= 0; k--) m->outside[k] += m->outside[k + 1];
    return 1;
}

/* y and its slope at a place t between nodes a and b, where t and its slopes by y are known. */
static void invert(const masses *m, int a, int b, const double *t, double at, double *y, double *slope)
{
    const double h = t[b] - t[a], x = (at - t[a]) / h;
    const double d0 = h / (m->density[a] * (1 / m->inside[a] + 1 / m->outside[a])),
                 d1 = h / (m->density[b] * (1 / m->inside[b] + 1 / m->outside[b])), rise = y_at(b) - y_at(a);
    /* a density that is 0 at one end has no slope there */
    const double s0 = isfinite(d0) ? fmin(d0, 3 * rise) : rise, s1 = isfinite(d1) ? fmin(d1, 3 * rise) : rise;
    const double c2 = 3 * rise - 2 * s0 - s1, c3 = s0 + s1 - 2 * rise;
    *y = y_at(a) + x * (s0 + x * (c2 + x * c3));
    *slope = (s0 + x * (2 * c2 + 3 * x * c3)) / h;
}

/* ln q at the edges of the bins. Without a node on both sides it is that of the nearest. */
static void edges(const masses *m, double *t, double *y, double *slope)
{
    int first = -1, last = -1, k = 0;
    for (int j = 0; j <= PANELS; j++) {
        t[j] = m->inside[j] > 0 && m->outside[j] > 0 ? log(m->inside[j] / m->outside[j]) : -INFINITY;
        if (!isfinite(t[j])) continue;
        if (first < 0) first = j;
        last = j;
    }
    k = first;
    for (int b = 0; b <= FF_WALK_BINS; b++) {
        const double at = 2 * FF_WALK_T / FF_WALK_BINS * b - FF_WALK_T;
        slope[b] = 0;
        y[b] = y_at(at <= t[first] ? first : last);
        if (at <= t[first] || at >= t[last]) continue;
        while (k + 1 < last && t[k + 1] <= at) k++;
        invert(m, k, k + 1, t, at, &y[b], &slope[b]);
    }
}

static void bins(const double *y, const double *slope, ff_walk_radial *out)
{
    const double h = 2 * FF_WALK_T / FF_WALK_BINS;
    for (int b = 0; b < FF_WALK_BINS; b++) {
        const double rise = y[b + 1] - y[b], s0 = h * slope[b], s1 = h * slope[b + 1];
        out->c[0][b] = y[b];
        out->c[1][b] = s0;
        out->c[2][b] = 3 * rise - 2 * s0 - s1;
        out->c[3][b] = s0 + s1 - 2 * rise;
    }
}

ff_status ff_walk_radial_make(const ff_ndf *ndf, const ff_ndf_pass *pass, ff_walk_radial out[2], double *mean)
{
    masses *m = malloc(sizeof *m);
    double *t = malloc((PANELS + 1) * sizeof *t), *y = malloc(2 * (FF_WALK_BINS + 1) * sizeof *y);
    ff_status status = m && t && y ? FF_OK : FF_ERR_MEMORY;
    for (int power = 0; power < 2 && !status; power++) {
        if (!masses_fill(ndf, pass, power, m)) status = FF_ERR_UNSUPPORTED;
        if (status) break;
        if (power == 1) *mean = (m->inside[0] + m->outside[0]) / FF_PI;
        edges(m, t, y, y + FF_WALK_BINS + 1);
        bins(y, y + FF_WALK_BINS + 1, &out[power]);
    }
    free(y);
    free(t);
    free(m);
    return status;
}
