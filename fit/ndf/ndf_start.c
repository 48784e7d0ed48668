/* Where a retrieval starts: the falls of the best fit of student-t, or the power iteration over back-scatter samples.
 * Dupuy, Heitz, Iehl, Poulin and Ostromoukhov 2015, Extracting Microfacet-based BRDF Parameters from Arbitrary Materials with Power
 * Iterations, section 3.
 *
 *   f(o, o) = F0 D(o) G1(o) / (4 cos^2),   G1(o) = cos / integral D(m) <o, m> dm
 *   F0 D(o) = b(o) / cos(o) integral D(m) <o, m> dm,   b = 4 cos^2 f(o, o)
 *
 * D is the eigenvector of a positive kernel and F0 its eigenvalue once integral D cos = 1. Unlike there, the diffuse part of the
 * best parametric fit is taken off first, samples count whose directions are apart by a few degrees (b is then 4 iz oz f at their
 * half vector), and the azimuths are integrated in closed form. */
#include "internal_ndf.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double pi = 3.14159265358979323846;

enum { NODES = FF_NDF_MOST_TOP + 1, LEAST_SAMPLES = 12 };

void ff_ndf_falls(const ff_curve *curve, const double *ln_d, double *falls)
{
    double c[NODES];
    ff_curve_interpolate(curve, ln_d, c);
    for (int k = 0; k < curve->top; k++) falls[k] = c[k] - c[k + 1];
}

/* ---- samples that look back ------------------------------------------------------------------ */

/* Means of b by the nearest node. */
typedef struct back_scatter {
    size_t samples, filled;
    double b[NODES], count[NODES];
} back_scatter;

static void gather(const struct ff_problem *p, const ff_curve *curve, double cos_min, const double *kd, back_scatter *out)
{
    *out = (back_scatter){.samples = 0};
    for (size_t i = 0; i < p->n; i++) {
        const size_t block = i / FF_BLOCK, lane = i % FF_BLOCK;
        if (ff_problem_plane(p, block, p->geometry[FF_G_C])[lane] < cos_min) continue;
        const double s2 = ff_problem_plane(p, block, p->geometry[FF_G_S2])[lane];
        const double four_cos2 = (1 + s2) * (1 + s2) / ff_problem_plane(p, block, p->geometry[FF_G_K])[lane];
        const long k = lround(asinh(sqrt(s2) / curve->scale) / curve->step);
        if (k > curve->top) continue;
        for (size_t c = 0; c < p->n_channels; c++)
            out->b[k] += four_cos2 * (ff_problem_plane(p, block, p->value + (int)c)[lane] - kd[c] / pi) / (double)p->n_channels;
        out->count[k]++;
        out->samples++;
    }
    for (int k = 0; k <= curve->top; k++) {
        if (out->count[k] == 0) continue;
        out->b[k] /= out->count[k];
        out->filled++;
    }
}

/* Bins without a sample, or below nothing, between their neighbours in the logarithm; level before the first. 0: no bin has any. */
static int fill_gaps(const ff_curve *curve, back_scatter *s)
{
    int last = -1;
    for (int k = 0; k <= curve->top; k++) {
        if (s->count[k] == 0 || !(s->b[k] > 0)) continue;
        for (int i = last + 1; i < k; i++) {
            const double t = last < 0 ? 1 : (double)(i - last) / (k - last);
            s->b[i] = last < 0 ? s->b[k] : s->b[last] * pow(s->b[k] / s->b[last], t);
        }
        last = k;
    }
    for (int i = last + 1; i <= curve->top && last >= 0; i++) /* beyond the last: as the tail of ggx */
        s->b[i] = s->b[last] * pow(ff_curve_node(curve, last) / ff_curve_node(curve, i), 4);
    return last >= 0;
}

/* ---- the power iteration --------------------------------------------------------------------- */

/* integral of <o, m> over the azimuth, both at given tangents. */
static double visible(double tan_o, double tan_m)
{
    const double a = 1, b = tan_o * tan_m, norm = 1 / sqrt((1 + tan_o * tan_o) * (1 + tan_m * tan_m));
    if (b <= a) return 2 * pi * a * norm;
    const double phi = acos(-a / b);
    return 2 * (phi * a + b * sin(phi)) * norm;
}

/* Weight of node k for an integral over sin(theta) dtheta. */
static double measure(const ff_curve *curve, int k)
{
    const double here = atan(ff_curve_node(curve, k));
    const double before = k ? atan(ff_curve_node(curve, k - 1)) : here,
                 behind = k < curve->top ? atan(ff_curve_node(curve, k + 1)) : here;
    return 0.5 * (behind - before) * sin(here);
}

/* D [top + 1] of area 1 from b; returns F0. kernel [top + 1]. */
static double iterate(const ff_curve *curve, const double *b, double (*kernel)[NODES], double *d, int *iterations)
{
    enum { MOST = 200 };
    double weight[NODES], next[NODES], f0 = 0, change = 1;
    const int n = curve->top + 1;
    for (int m = 0; m < n; m++) weight[m] = measure(curve, m);
    for (int o = 0; o < n; o++) {
        const double tan_o = ff_curve_node(curve, o);
        for (int m = 0; m < n; m++)
            kernel[o][m] = b[o] * sqrt(1 + tan_o * tan_o) * visible(tan_o, ff_curve_node(curve, m)) * weight[m];
        d[o] = 1;
    }
    for (*iterations = 0; *iterations < MOST && change > 1e-9; (*iterations)++) {
        change = f0 = 0;
        for (int o = 0; o < n; o++) {
            next[o] = 0;
            for (int m = 0; m < n; m++) next[o] += kernel[o][m] * d[m];
            const double tan_o = ff_curve_node(curve, o);
            f0 += 2 * pi * weight[o] * next[o] / sqrt(1 + tan_o * tan_o);
        }
        for (int o = 0; o < n; o++) {
            change = fmax(change, fabs(next[o] / f0 - d[o]) / (next[o] / f0));
            d[o] = next[o] / f0;
        }
    }
    return f0;
}

ff_status ff_ndf_back_scatter(const struct ff_problem *p, const ff_curve *curve, const double *kd, double *falls,
                              ff_ndf_result *out)
{
    static const double limits[] = {2.5, 5, 10};
    back_scatter s = {.samples = 0};
    double d[NODES], ln_d[NODES];
    size_t i = 0;
    for (; i < sizeof limits / sizeof *limits; i++) {
        gather(p, curve, cos(limits[i] * pi / 180), kd, &s);
        if (s.samples >= LEAST_SAMPLES && 4 * s.filled >= (size_t)curve->top) break;
    }
    out->back_samples = s.samples;
    out->from_back_scatter = i < sizeof limits / sizeof *limits && fill_gaps(curve, &s);
    if (!out->from_back_scatter) return FF_OK;
    double(*kernel)[NODES] = malloc(NODES * sizeof *kernel);
    if (!kernel) return FF_ERR_MEMORY;
    out->back_angle = limits[i] * pi / 180;
    out->back_f0 = iterate(curve, s.b, kernel, d, &out->back_iterations);
    free(kernel);
    for (int k = 0; k <= curve->top; k++) ln_d[k] = log(d[k]);
    for (int k = 1; k <= curve->top; k++) ln_d[k] = fmin(ln_d[k], ln_d[k - 1]);
    ff_ndf_falls(curve, ln_d, falls);
    return FF_OK;
}
