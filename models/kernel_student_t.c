/* See internal_student_t.h. Compiled once per instruction set. */
#include "internal_student_t.h"
#include <complex.h>
#include <float.h>

/* Gamma(z + 1/2) / Gamma(z), Re z > 0: recurrence up to |z| >= 20, then Stirling's series of the ratio; 1e-15. */
static double complex gamma_ratio(double complex z)
{
    double complex factor = 1;
    for (; creal(z) < 20; z += 1) factor *= z / (z + 0.5);
    const double complex u = 1 / (z * z);
    const double complex series = (-1. / 8 + u * (1. / 192 + u * (-1. / 640 + u * (17. / 14336 - u * (31. / 18432))))) / z;
    return factor * csqrt(z) * cexp(series);
}

/* The imaginary part of nu: so small that its square vanishes, and what comes out in the imaginary part is the derivative. */
#define FF_STEP 1e-40

/* Does a term still count, in the value or in the derivative? For a whole nu the series of the value ends, that of the derivative
 * does not. */
static int matters(double complex term)
{
    return fabs(creal(term)) > DBL_EPSILON / 1024 || fabs(cimag(term)) > DBL_EPSILON / 1024 * FF_STEP;
}

/* m(a) of the header's head: the tail of the slope distribution over E. a >= 0. */
static double complex tail_over_e(double a, double complex nu, double complex inv_beta)
{
    const double complex y = a * a / (nu + a * a), x = nu / (nu + a * a);
    if (creal(y) < 1.5 / (creal(nu) + 2.5)) { /* 1/2 - its complement, by the series of 2F1(1 - nu, 1/2; 3/2; y) */
        double complex term = 1, sum = 1;
        for (int k = 0; k < 500 && matters(term); k++) {
            term *= (k + 1 - nu) / (k + 1.0) * y;
            sum += term / (2 * k + 3);
        }
        return cpow(x, -nu) * (0.5 - csqrt(y) * inv_beta * sum);
    }
    /* continued fraction of I_x(nu, 1/2), modified Lentz (DLMF 8.17.22) */
    double complex c = 1, d = 1 / (1 - (nu + 0.5) * x / (nu + 1)), h = d;
    for (int k = 1; k < 20000; k++) {
        const double complex even = k * (0.5 - k) * x / ((nu - 1 + 2 * k) * (nu + 2 * k));
        d = 1 / (1 + even * d);
        c = 1 + even / c;
        h *= d * c;
        const double complex odd = -(nu + k) * (nu + 0.5 + k) * x / ((nu + 2 * k) * (nu + 1 + 2 * k));
        d = 1 / (1 + odd * d);
        c = 1 + odd / c;
        h *= d * c;
        if (fabs(creal(d * c) - 1) < DBL_EPSILON && fabs(cimag(d * c)) < DBL_EPSILON * FF_STEP) break;
    }
    return csqrt(y) * h * inv_beta / (2 * nu);
}

/* Coefficients by rising power of t of the polynomial through f at the Chebyshev nodes of [-1, 1]. */
static void power_series(const double *f, double *out)
{
    double cheb[FF_POLY], prev[FF_POLY] = {1}, cur[FF_POLY] = {0, 1};
    for (int j = 0; j < FF_POLY; j++) {
        double sum = 0;
        for (int k = 0; k < FF_POLY; k++) sum += f[k] * cos(FF_PI * j * (k + 0.5) / FF_POLY);
        cheb[j] = sum * (j ? 2.0 : 1.0) / FF_POLY;
        out[j] = 0;
    }
    out[0] = cheb[0];
    for (int j = 1; j < FF_POLY; j++) { /* cur = T_j, prev = T_(j-1) */
        for (int k = 0; k <= j; k++) out[k] += cheb[j] * cur[k];
        double next[FF_POLY] = {0};
        for (int k = 0; k < FF_POLY; k++) next[k] = (k ? 2 * cur[k - 1] : 0) - prev[k];
        memcpy(prev, cur, sizeof prev);
        memcpy(cur, next, sizeof cur);
    }
}

/* pass->c */
enum { C_NU, C_K, C_DK, C_T_SCALE, C_INV_NU };

void ff_student_t_prepare(ff_ndf_pass *pass)
{
    const double nu = pass->own - 1;
    const double complex znu = nu + FF_STEP * I, ratio = gamma_ratio(znu), inv_beta = ratio / FF_SQRT_PI;
    const double complex k = csqrt(znu) * ratio / (FF_SQRT_PI * (2 * znu - 1));
    pass->c[C_NU] = nu;
    pass->c[C_INV_NU] = 1 / nu;
    pass->c[C_K] = creal(k);
    pass->c[C_DK] = cimag(k) / FF_STEP;
    /* t covers the a at which E is above 1e-300: all of them unless nu is large. s = a/(a+3) = (t+1)/2 s_max. */
    const double span = expm1(690 / nu), a_max = sqrt(nu * span), s_max = a_max < 1e8 ? a_max / (a_max + 3) : 1;
    pass->c[C_T_SCALE] = 2 / s_max;
    double m[FF_POLY], dm[FF_POLY];
    for (int j = 0; j < FF_POLY; j++) {
        const double s = 0.5 * s_max * (1 + cos(FF_PI * (j + 0.5) / FF_POLY));
        const double complex z = tail_over_e(3 * s / (1 - s), znu, inv_beta);
        m[j] = creal(z);
        dm[j] = cimag(z) / FF_STEP;
    }
    power_series(m, pass->poly[0]);
    power_series(dm, pass->poly[1]);
}

void ff_student_t_profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                          double *restrict dlnp_own)
{
    const double nu = pass->c[C_NU], inv_nu = pass->c[C_INV_NU];
    for (size_t i = 0; i < n; i++) {
        const double u = q2[i] * inv_nu;
        p[i] = ff_exp(-(nu + 1) * ff_log1p(u)) * (1 / FF_PI);
        dlnp[i] = -(nu + 1) * inv_nu * ff_recip(1 + u);
    }
    if (!dlnp_own) return;
    for (size_t i = 0; i < n; i++) {
        const double u = q2[i] * inv_nu;
        dlnp_own[i] = (nu + 1) * inv_nu * u * ff_recip(1 + u) - ff_log1p(u);
    }
}

/* The polynomial of 44 coefficients at t; even and odd powers apart halve the chain of dependent sums. */
static inline double horner(const double *restrict c, double t)
{
    const double t2 = t * t;
    double even = c[FF_POLY - 2], odd = c[FF_POLY - 1];
#pragma GCC unroll 22
    for (int k = FF_POLY - 4; k >= 0; k -= 2) {
        even = even * t2 + c[k];
        odd = odd * t2 + c[k + 1];
    }
    return even + t * odd;
}

void ff_student_t_lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                         double *restrict dlam_own)
{
    double c[8], poly[2][FF_POLY]; /* local copies: the compiler then knows that the stores below leave them alone */
    double e[FF_BLOCK], t[FF_BLOCK], front[FF_BLOCK], bracket[FF_BLOCK], excess[FF_BLOCK], log_A[FF_BLOCK];
    memcpy(c, pass->c, sizeof c);
    memcpy(poly, pass->poly, sizeof poly);
    for (size_t i = 0; i < n; i++) {
        const double a = ff_rsqrt(v[i]), inv_a = v[i] * a;
        excess[i] = ff_recip(c[C_NU] * v[i]); /* a^2 / nu = A - 1 */
        log_A[i] = ff_log1p(excess[i]);
        e[i] = ff_exp(-c[C_NU] * log_A[i]);
        const double root = (1 + excess[i]) * ff_rsqrt(1 + excess[i]), s = c[C_T_SCALE] * ff_recip(1 + 3 * inv_a) - 1;
        t[i] = s > 1 ? 1 : s;
        front[i] = root * inv_a; /* K front = (Lambda + Q) / E, and d Lambda / da = -(Lambda + Q) / a */
        bracket[i] = c[C_K] * front[i] - horner(poly[0], t[i]);
        lam[i] = e[i] * (bracket[i] > 0 ? bracket[i] : 0); /* rounding may leave -1e-17 where E vanishes */
        dlam[i] = 0.5 * c[C_K] * e[i] * front[i] * a * a;
    }
    if (!dlam_own) return;
    for (size_t i = 0; i < n; i++) {
        const double share = excess[i] * ff_recip(1 + excess[i]); /* (A - 1) / A */
        const double dfront = (c[C_DK] - 0.5 * c[C_K] * share * c[C_INV_NU]) * front[i];
        dlam_own[i] = e[i] * ((share - log_A[i]) * bracket[i] + dfront - horner(poly[1], t[i]));
    }
}
