/* Gauss and Legendre quadrature on panels. */
#ifndef FF_INTERNAL_GAUSS_H
#define FF_INTERNAL_GAUSS_H

enum { FF_GAUSS = 16 };

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
