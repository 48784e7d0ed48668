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
        const double u = a * a / creal(nu); /* ln A by log1p: nu multiplies its error */
        const double complex log_A = log1p(u) - I * cimag(nu) * u / (creal(nu) * (1 + u));
        return cexp(nu * log_A) * (0.5 - csqrt(y) * inv_beta * sum);
    }
    /* Continued fraction of I_x(nu, 1/2), modified Lentz (DLMF 8.17.22). For large nu its odd coefficients are nearly -1: what they
     * lack of it is carried, since the differences from 1 are what counts. */
    double complex c = 1, d = (nu + 1) / (0.5 + (nu + 0.5) * y), h = d;
    for (int k = 1; k < 20000; k++) {
        const double complex even = k * (0.5 - k) * x / ((nu - 1 + 2 * k) * (nu + 2 * k));
        const double complex below = even * d / (1 + even * d), above = even / c; /* 1 - d and c - 1 from here on */
        c = 1 + above;
        h *= (1 - below) * c;
        const double complex lack = (nu * (2 * k + 0.5) + 3.0 * k * k + 1.5 * k + (nu + k) * (nu + 0.5 + k) * y) /
                                    ((nu + 2 * k) * (nu + 1 + 2 * k)); /* the odd coefficient is lack - 1 */
        d = 1 / (lack + below - lack * below);
        c = (above + lack) / c;
        h *= d * c;
        if (fabs(creal(d * c) - 1) < DBL_EPSILON && fabs(cimag(d * c)) < DBL_EPSILON * FF_STEP) break;
    }
    return csqrt(y) * h * inv_beta / (2 * nu);
}

/* Coefficients by rising power of t of the polynomial through f at the Chebyshev nodes cos(pi (k + 1/2) / FF_POLY). */
static void power_series(const double *f, double *out)
{
    double cosine[4 * FF_POLY], cheb[FF_POLY], prev[FF_POLY] = {1}, cur[FF_POLY] = {0, 1};
    for (int i = 0; i < 4 * FF_POLY; i++) cosine[i] = cos(FF_PI * i / (2 * FF_POLY));
    for (int j = 0; j < FF_POLY; j++) {
        double sum = 0;
        for (int k = 0; k < FF_POLY; k++) sum += f[k] * cosine[j * (2 * k + 1) % (4 * FF_POLY)];
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

/* pass->c; K and its derivative are those of the header over sqrt(nu), for sqrt(A) / a = R / sqrt(nu) */
enum { C_NU, C_K, C_DK, C_T_SCALE, C_R_SCALE, C_INV_NU };

void ff_student_t_prepare_profile(ff_ndf_pass *pass)
{
    pass->c[C_NU] = pass->own[0] - 1;
    pass->c[C_INV_NU] = 1 / pass->c[C_NU];
}

void ff_student_t_prepare(ff_ndf_pass *pass)
{
    ff_student_t_prepare_profile(pass);
    const double nu = pass->c[C_NU];
    const double complex znu = nu + FF_STEP * I, ratio = gamma_ratio(znu), inv_beta = ratio / FF_SQRT_PI;
    const double complex k = ratio / (FF_SQRT_PI * (2 * znu - 1));
    pass->c[C_K] = creal(k);
    pass->c[C_DK] = cimag(k) / FF_STEP;
    /* t covers the R at which E is above 1e-300: all of them unless nu is large. s = 1 / (1 + scale R) = (t + 1) / 2 s_max. */
    const double scale = 3 / sqrt(nu > 1 ? nu : 1), s_max = 1 / (1 + scale * sqrt(1 + 1 / expm1(690 / nu)));
    pass->c[C_R_SCALE] = scale;
    pass->c[C_T_SCALE] = 2 / s_max;
    double m[FF_POLY], dm[FF_POLY];
    for (int j = 0; j < FF_POLY; j++) {
        const double s = 0.5 * s_max * (1 + cos(FF_PI * (j + 0.5) / FF_POLY)), R = (1 - s) / (s * scale);
        const double complex z = tail_over_e(sqrt(nu / ((R - 1) * (R + 1))), znu, inv_beta);
        m[j] = creal(z);
        dm[j] = cimag(z) / FF_STEP;
    }
    power_series(m, pass->table);
    power_series(dm, pass->table + FF_POLY);
}

/* p = A^-(nu + 1) / pi with A = 1 + q2 / nu */
void ff_student_t_profile(const ff_ndf_pass *pass, size_t n, const double *restrict q2, double *restrict p, double *restrict dlnp,
                          double *const *dlnp_own)
{
    const double nu = pass->c[C_NU], inv_nu = pass->c[C_INV_NU];
    double inv_A[FF_BLOCK], log_A[FF_BLOCK];
    for (size_t i = 0; i < n; i++) {
        inv_A[i] = ff_recip(1 + q2[i] * inv_nu);
        dlnp[i] = -(nu + 1) * inv_nu * inv_A[i];
    }
    for (size_t i = 0; i < n; i++) {
        const double u = q2[i] * inv_nu, A = 1 + u;
        log_A[i] = ff_log(A) + (u - (A - 1)) * inv_A[i];
    }
    for (size_t i = 0; i < n; i++) p[i] = ff_exp(-(nu + 1) * log_A[i]) * (1 / FF_PI);
    if (!dlnp_own) return;
    double *restrict own = dlnp_own[0];
    for (size_t i = 0; i < n; i++) own[i] = (nu + 1) * inv_nu * (q2[i] * inv_nu * inv_A[i]) - log_A[i];
}

/* With w = nu v: 1/A = x = w / (1 + w), R = sqrt(1 + w), and a^2 / (nu + a^2) = y = 1 / (1 + w). */
void ff_student_t_lambda(const ff_ndf_pass *pass, size_t n, const double *restrict v, double *restrict lam, double *restrict dlam,
                         double *const *dlam_own)
{
    double c[16], poly[2][FF_POLY]; /* local copies: the compiler then knows that the stores below leave them alone */
    double x[FF_BLOCK], e[FF_BLOCK], t[FF_BLOCK], R[FF_BLOCK], y[FF_BLOCK], bracket[FF_BLOCK], log_x[FF_BLOCK];
    memcpy(c, pass->c, sizeof c);
    memcpy(poly, pass->table, sizeof poly);
    /* Several short loops: their iterations overlap in the processor where those of one long chain of operations cannot. */
    for (size_t i = 0; i < n; i++) {
        const double w = c[C_NU] * v[i], inv_R = ff_rsqrt(1 + w);
        R[i] = (1 + w) * inv_R;
        y[i] = inv_R * inv_R;
        x[i] = w * y[i];
    }
    for (size_t i = 0; i < n; i++) {
        const double s = c[C_T_SCALE] * ff_recip(1 + c[C_R_SCALE] * R[i]) - 1;
        t[i] = s > 1 ? 1 : s;
    }
    for (size_t i = 0; i < n; i++)
        bracket[i] = c[C_K] * R[i] -
                     ff_polynomial(FF_POLY, poly[0], t[i]); /* K R = (Lambda + Q) / E, and d Lambda / da = -(Lambda + Q) / a */
    for (size_t i = 0; i < n; i++) { /* ln x: of 1 - y with what that lost in rounding where x is near 1, of x elsewhere */
        const double below = 1 - y[i], near = y[i] < 0.5 ? 1 : 0;
        log_x[i] = ff_log(near > 0 ? below : x[i]) + near * ((1 - below) - y[i]) * (1 + y[i]);
    }
    for (size_t i = 0; i < n; i++) {
        const double steep = ff_exp((c[C_NU] - 1) * log_x[i]); /* E A */
        e[i] = steep * x[i];
        lam[i] = e[i] * (bracket[i] > 0 ? bracket[i] : 0); /* rounding may leave -1e-17 where E vanishes */
        dlam[i] = 0.5 * c[C_K] * R[i] * c[C_NU] * y[i] * steep;
    }
    if (!dlam_own) return;
    double *restrict own = dlam_own[0];
    for (size_t i = 0; i < n; i++) {
        const double dfront = (c[C_DK] + 0.5 * (1 - y[i]) * c[C_K] * c[C_INV_NU]) * R[i];
        own[i] = e[i] * ((y[i] + log_x[i]) * bracket[i] + dfront - ff_polynomial(FF_POLY, poly[1], t[i]));
    }
}
