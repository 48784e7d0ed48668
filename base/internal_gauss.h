/* Gauss and Legendre quadrature on panels. */
#ifndef FF_INTERNAL_GAUSS_H
#define FF_INTERNAL_GAUSS_H
#include <math.h>

enum { FF_GAUSS = 16, FF_GAUSS_MOST = 32 };

/* A rule of n points on [-1, 1]. */
typedef struct ff_gauss {
    int n;
    double x[FF_GAUSS_MOST], w[FF_GAUSS_MOST];
} ff_gauss;

/* n <= FF_GAUSS_MOST points by Newton's iteration on P_n. */
static inline void ff_gauss_make(int n, ff_gauss *g)
{
    g->n = n;
    for (int i = 0; i < n; i++) {
        double x = cos(3.14159265358979323846 * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int it = 0; it < 8; it++) {
            double p0 = 1, p1 = x;
            for (int k = 2; k <= n; k++) {
                const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1);
            x -= p1 / slope;
        }
        g->x[i] = x;
        g->w[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

/* Nodes x [FF_GAUSS * panels] and weights w of Gauss and Legendre on equal panels from a to b. */
static inline void ff_gauss_panels(double a, double b, int panels, double *x, double *w)
{
    static const double node[FF_GAUSS / 2] = {0.0950125098376374402, 0.281603550779258913, 0.458016777657227386,
                                              0.617876244402643748,  0.755404408355003034, 0.865631202387831744,
                                              0.944575023073232576,  0.989400934991649933};
    static const double weight[FF_GAUSS / 2] = {0.189450610455068496,  0.182603415044923589, 0.169156519395002538,
                                                0.149595988816576732,  0.124628971255533872, 0.0951585116824927848,
                                                0.0622535239386478929, 0.0271524594117540949};
    const double half = 0.5 * (b - a) / panels;
    for (int k = 0; k < panels; k++)
        for (int i = 0; i < FF_GAUSS; i++) {
            const int at = i < FF_GAUSS / 2 ? FF_GAUSS / 2 - 1 - i : i - FF_GAUSS / 2;
            x[FF_GAUSS * k + i] = a + half * (2 * k + 1 + (i < FF_GAUSS / 2 ? -node[at] : node[at]));
            w[FF_GAUSS * k + i] = half * weight[at];
        }
}
#endif
