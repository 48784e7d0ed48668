/* Tails and quantiles: the incomplete gamma function by series and continued fraction, Student's t by the incomplete beta function
 * (DLMF 8.7.1, 8.9.2, 8.17.22), and so F. */
#define _DEFAULT_SOURCE /* lgamma_r */
#include "internal_statistics.h"
#include <float.h>
#include <math.h>

enum { FF_TERMS_OF_FRACTION = 10000 };

double ff_normal_two_sided(double z)
{
    return erfc(z / sqrt(2));
}

/* ln Gamma(a), a > 0. lgamma itself writes the sign to a variable that all threads have. */
static double ln_gamma(double a)
{
    int sign;
    return lgamma_r(a, &sign);
}

/* P(a, x) by its series; x < a + 1. */
static double gamma_series(double a, double x)
{
    double term = 1 / a, sum = term;
    for (int k = 1; k < FF_TERMS_OF_FRACTION && term > sum * DBL_EPSILON; k++) {
        term *= x / (a + k);
        sum += term;
    }
    return sum * exp(a * log(x) - x - ln_gamma(a));
}

/* Keeps a denominator of Lentz's algorithm away from 0. */
static double not_zero(double v)
{
    return fabs(v) < 1e-300 ? 1e-300 : v;
}

/* Q(a, x) by its continued fraction; x >= a + 1. */
static double gamma_fraction(double a, double x)
{
    double b = x + 1 - a, c = 1e300, d = 1 / not_zero(b), h = d;
    for (int k = 1; k < FF_TERMS_OF_FRACTION; k++) {
        const double an = -k * (k - a);
        b += 2;
        d = 1 / not_zero(an * d + b);
        c = not_zero(b + an / c);
        h *= c * d;
        if (fabs(c * d - 1) < DBL_EPSILON) break;
    }
    return h * exp(a * log(x) - x - ln_gamma(a));
}

double ff_chi2_tail(double x, double dof)
{
    const double a = 0.5 * dof, half = 0.5 * x;
    if (!(half > 0)) return 1;
    if (isinf(half)) return 0;
    return half < a + 1 ? 1 - gamma_series(a, half) : gamma_fraction(a, half);
}

/* The continued fraction of I_x(a, b), where it converges fast: x < (a + 1) / (a + b + 2). */
static double beta_fraction(double a, double b, double x)
{
    double c = 1, d = 1 / not_zero(1 - (a + b) * x / (a + 1)), h = d;
    for (int k = 1; k < FF_TERMS_OF_FRACTION; k++) {
        const double m = k, even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
                     odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
        d = 1 / not_zero(1 + even * d);
        c = not_zero(1 + even / c);
        h *= c * d;
        d = 1 / not_zero(1 + odd * d);
        c = not_zero(1 + odd / c);
        h *= c * d;
        if (fabs(c * d - 1) < DBL_EPSILON) break;
    }
    return h;
}

/* I_x(a, b); y = 1 - x without its rounding. */
static double incomplete_beta(double a, double b, double x, double y)
{
    if (!(x > 0)) return 0;
    if (!(y > 0)) return 1;
    const double front = exp(ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * log(x) + b * log(y));
    return x < (a + 1) / (a + b + 2) ? front * beta_fraction(a, b, x) / a : 1 - front * beta_fraction(b, a, y) / b;
}

double ff_student_two_sided(double t, double dof)
{
    const double sum = dof + t * t;
    if (!(dof < 1e7)) return ff_normal_two_sided(t); /* the difference is below 1e-7 then */
    return incomplete_beta(0.5 * dof, 0.5, dof / sum, t * t / sum);
}

double ff_student_quantile(double p, double dof)
{
    const double tail = 1 - p;
    double lo = 0, hi = 1;
    while (hi < 1e15 && ff_student_two_sided(hi, dof) > tail) lo = hi, hi *= 2;
    for (int k = 0; k < 100 && hi - lo > 4 * DBL_EPSILON * hi; k++) {
        const double mid = 0.5 * (lo + hi);
        if (ff_student_two_sided(mid, dof) > tail)
            lo = mid;
        else
            hi = mid;
    }
    return 0.5 * (lo + hi);
}

double ff_student_degrees(double p, double t)
{
    double lo = 0, hi = 1;                                                            /* of 1 / dof */
    if (!(ff_student_two_sided(t, INFINITY) < (1 - p) * (1 - 1e-9))) return INFINITY; /* to rounding */
    while (hi < 1e15 && ff_student_two_sided(t, 1 / hi) < 1 - p) lo = hi, hi *= 2;
    for (int k = 0; k < 100 && hi - lo > 4 * DBL_EPSILON * hi; k++) {
        const double mid = 0.5 * (lo + hi);
        if (ff_student_two_sided(t, 1 / mid) < 1 - p)
            lo = mid;
        else
            hi = mid;
    }
    return 2 / (lo + hi);
}

double ff_f_tail(double x, double dof, double of_error)
{
    const double sum = of_error + dof * x;
    if (!(x > 0)) return 1;
    if (!(of_error < 1e7)) return ff_chi2_tail(dof * x, dof); /* the difference is below 1e-7 then */
    return incomplete_beta(0.5 * of_error, 0.5 * dof, of_error / sum, dof * x / sum);
}
