/* Shirley and Chiu's square of the disk, by angles as Radiance has it: a second way to what the reader of tensor trees computes. */
#ifndef FF_TEST_SQUARE_H
#define FF_TEST_SQUARE_H
#include <math.h>

static inline void square_of(double x, double y, double *u, double *v)
{
    const double pi = 3.14159265358979323846, r = hypot(x, y);
    double phi = atan2(y, x), a, b;
    if (phi < -pi / 4) phi += 2 * pi;
    if (phi < pi / 4)
        a = r, b = phi * r / (pi / 4);
    else if (phi < 3 * pi / 4)
        b = r, a = (pi / 2 - phi) * r / (pi / 4);
    else if (phi < 5 * pi / 4)
        a = -r, b = (phi - pi) * a / (pi / 4);
    else
        b = -r, a = -(phi - 3 * pi / 2) * b / (pi / 4);
    *u = (a + 1) / 2;
    *v = (b + 1) / 2;
}
#endif
