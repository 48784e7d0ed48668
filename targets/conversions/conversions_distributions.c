/* Distributions of normals, by what two of them have in common: the peak D(z), the mean slope, or Mikkelsen's and Kelemen's rules.
 *
 *   m       Beckmann's roughness (his alpha)     sqrt(2) times the rms slope along one axis
 *   n       exponent of cos^n of the half vector's angle, as in Blinn's model
 *   s       exponent of cos^s of the angle to the mirror direction, as in Phong's
 *   alpha   roughness of ggx
 *   sigma   rms slope along one axis
 */
#include "internal_conversions.h"
#include <math.h>

#define PI FF_CONVERSION_PI

const char *ff_conversion_same(const double *in, double *out)
{
    out[0] = in[0];
    return NULL;
}

/* ---- exponents ------------------------------------------------------------------------------- */

static const char *beckmann_to_phong(const double *in, double *out)
{
    out[0] = 2 / (in[0] * in[0]) - 2;
    return NULL;
}

static const char *phong_to_beckmann(const double *in, double *out)
{
    out[0] = sqrt(2 / (in[0] + 2));
    return NULL;
}

static const char *kelemen_ward_to_phong(const double *in, double *out)
{
    out[0] = 2 / (in[0] * in[0]) - 1;
    return NULL;
}

static const char *kelemen_phong_to_ward(const double *in, double *out)
{
    out[0] = sqrt(2 / (in[0] + 1));
    return NULL;
}

static const char low_exponent[] = "n <= 8: the two distributions look different at this roughness";

static const char *doubt_n_out(const double *in, const double *out)
{
    (void)in;
    return out[0] <= 8 ? low_exponent : NULL;
}

static const char *doubt_n_in(const double *in, const double *out)
{
    (void)out;
    return in[0] <= 8 ? low_exponent : NULL;
}

/* cos^s(2 t) and cos^n(t) have the same curvature at t = 0, normal incidence, where the angle to the mirror direction is twice that
 * of the half vector. */
static const char *mirror_to_phong(const double *in, double *out)
{
    out[0] = 4 * in[0];
    return NULL;
}

static const char *phong_to_mirror(const double *in, double *out)
{
    out[0] = in[0] / 4;
    return NULL;
}

/* ---- mean slopes ----------------------------------------------------------------------------- */

/* E|s| along one axis: m / sqrt(pi) for beckmann (Gaussian), alpha for ggx (marginal 1 / (2 (1 + u^2)^1.5), u = s / alpha). */
static const char *divide_by_sqrt_pi(const double *in, double *out)
{
    out[0] = in[0] / sqrt(PI);
    return NULL;
}

static const char *times_sqrt_pi(const double *in, double *out)
{
    out[0] = in[0] * sqrt(PI);
    return NULL;
}

/* Gamma(x + 1/2) / Gamma(x), x > 0: from its expansion for large x, to which the recurrence leads. */
static double gamma_ratio(double x)
{
    static const double term[] = {1, -1.0 / 8, 1.0 / 128, 5.0 / 1024, -21.0 / 32768, -399.0 / 262144, 869.0 / 4194304};
    double factor = 1, series = 0;
    for (int k = 0; k < 60 && x < 60; k++, x += 1) factor *= x / (x + 0.5);
    for (int k = 6; k >= 0; k--) series = series / x + term[k];
    return factor * sqrt(x) * series;
}

/* Slopes of cos^n have the marginal (1 + s^2)^(-(n + 3)/2) over its integral: E|s| = Gamma((n+1)/2) / (sqrt(pi) Gamma((n+2)/2)). */
static double mean_slope_of_phong(double n)
{
    return 1 / (sqrt(PI) * gamma_ratio((n + 1) / 2));
}

static const char *phong_to_mean_slope_ggx(const double *in, double *out)
{
    out[0] = mean_slope_of_phong(in[0]);
    return NULL;
}

static const char *phong_to_mean_slope_beckmann(const double *in, double *out)
{
    out[0] = sqrt(PI) * mean_slope_of_phong(in[0]);
    return NULL;
}

/* The slope falls as n grows, and 2 / (pi slope^2) lies between n and n + 1 (by Gautschi's inequality for the ratio). */
static const char *phong_of_mean_slope(double slope, double *out)
{
    if (!(slope < 1)) return "a mean slope of 1 and more has no exponent above 0";
    double hi = 2 / (PI * slope * slope), lo = fmax(hi - 1, 0);
    for (int i = 0; i < 200; i++) {
        const double n = (lo + hi) / 2;
        if (n <= lo || n >= hi) break;
        if (mean_slope_of_phong(n) > slope)
            lo = n;
        else
            hi = n;
    }
    out[0] = (lo + hi) / 2;
    return NULL;
}

static const char *ggx_to_phong_by_mean_slope(const double *in, double *out)
{
    return phong_of_mean_slope(in[0], out);
}

static const char *beckmann_to_phong_by_mean_slope(const double *in, double *out)
{
    return phong_of_mean_slope(in[0] / sqrt(PI), out);
}

static const char *divide_by_sqrt_2(const double *in, double *out)
{
    out[0] = in[0] / sqrt(2);
    return NULL;
}

static const char *times_sqrt_2(const double *in, double *out)
{
    out[0] = in[0] * sqrt(2);
    return NULL;
}

/* ---- the table ------------------------------------------------------------------------------- */

static const char mikkelsen[] = "Mikkelsen 2009, eq. 21";
static const char alike[] = "both are distributions of normals with the same peak D(z)";
static const char above_8[] = "close in look for n > 8; m >= 1 has no exponent above 0";
static const char kelemen[] = "Kelemen and Szirmay-Kalos 2001, figure 3";
static const char kelemen_assumes[] =
    "Kelemen's densities, normalised over solid angle (not over projected area), matched in their peak";
static const char kelemen_limits[] = "close in look for n > 8; m >= sqrt(2) has no exponent above 0";
static const char slopes[] = "moments of the two slope distributions";
static const char mean_slope[] = "equal mean absolute slope along an axis";
static const char mean_limits[] =
    "the peaks then differ by a factor pi, and ggx has far more normals in its tail: fit instead where data exist";
static const char phong_mean_limits[] = "close in look for n > 8; a mean slope of 1 and more has no exponent";
static const char peak[] = "equal peak D(z)";
static const char peak_limits[] = "ggx then looks rougher, for its tail has infinite slope variance: fit instead where data exist";
static const char rms[] = "Heitz 2014 (RR-8468), section 3.4: covariance Q^-1 / 2";
static const char rms_assumes[] = "Gaussian slopes; sigma is the rms slope along one axis, not over both";
static const char curvature[] = "cos^s(2 t) = cos^(4 s)(t) to the second order in t";
static const char curvature_assumes[] = "equal curvature of the two lobes at their peak, at normal incidence";
static const char curvature_limits[] = "off normal incidence the lobe of s is round and that of n is not: they differ";
static const char exact[] = "exact";

static const ff_conversion distributions[] = {
    {.from = "beckmann",
     .to = "phong",
     .by = "",
     .formula = "n = 2/m^2 - 2",
     .source = mikkelsen,
     .assumes = alike,
     .limits = above_8,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_M(1)},
     .out = {V_N(0)},
     .apply = beckmann_to_phong,
     .doubt = doubt_n_out},
    {.from = "phong",
     .to = "beckmann",
     .by = "",
     .formula = "m = sqrt(2/(n + 2))",
     .source = mikkelsen,
     .assumes = alike,
     .limits = above_8,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_M(1)},
     .apply = phong_to_beckmann,
     .doubt = doubt_n_in},
    {.from = "beckmann",
     .to = "phong",
     .by = "mean-slope",
     .formula = "the n of the same mean slope",
     .source = slopes,
     .assumes = mean_slope,
     .limits = phong_mean_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_M(INFINITY)},
     .out = {V_N(0)},
     .apply = beckmann_to_phong_by_mean_slope,
     .doubt = doubt_n_out},
    {.from = "phong",
     .to = "beckmann",
     .by = "mean-slope",
     .formula = "m = Gamma((n + 1)/2)/Gamma((n + 2)/2)",
     .source = slopes,
     .assumes = mean_slope,
     .limits = phong_mean_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_M(INFINITY)},
     .apply = phong_to_mean_slope_beckmann,
     .doubt = doubt_n_in},
    {.from = "beckmann",
     .to = "ggx",
     .by = "mean-slope",
     .formula = "alpha_ggx = m/sqrt(pi)",
     .source = slopes,
     .assumes = mean_slope,
     .limits = mean_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_M(INFINITY)},
     .out = {V_ALPHA},
     .apply = divide_by_sqrt_pi},
    {.from = "beckmann",
     .to = "ggx",
     .by = "peak",
     .formula = "alpha_ggx = m",
     .source = slopes,
     .assumes = peak,
     .limits = peak_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_M(INFINITY)},
     .out = {V_ALPHA},
     .apply = ff_conversion_same},
    {.from = "ggx",
     .to = "beckmann",
     .by = "mean-slope",
     .formula = "m = sqrt(pi) alpha_ggx",
     .source = slopes,
     .assumes = mean_slope,
     .limits = mean_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_ALPHA},
     .out = {V_M(INFINITY)},
     .apply = times_sqrt_pi},
    {.from = "ggx",
     .to = "beckmann",
     .by = "peak",
     .formula = "m = alpha_ggx",
     .source = slopes,
     .assumes = peak,
     .limits = peak_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_ALPHA},
     .out = {V_M(INFINITY)},
     .apply = ff_conversion_same},
    {.from = "phong",
     .to = "ggx",
     .by = "mean-slope",
     .formula = "alpha_ggx = Gamma((n + 1)/2)/(sqrt(pi) Gamma((n + 2)/2))",
     .source = slopes,
     .assumes = mean_slope,
     .limits = mean_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_ALPHA},
     .apply = phong_to_mean_slope_ggx},
    {.from = "phong",
     .to = "ggx",
     .by = "peak",
     .formula = "alpha_ggx = sqrt(2/(n + 2))",
     .source = slopes,
     .assumes = peak,
     .limits = peak_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_ALPHA},
     .apply = phong_to_beckmann},
    {.from = "ggx",
     .to = "phong",
     .by = "mean-slope",
     .formula = "the n of the same mean slope",
     .source = slopes,
     .assumes = mean_slope,
     .limits = mean_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_ALPHA},
     .out = {V_N(0)},
     .apply = ggx_to_phong_by_mean_slope},
    {.from = "ggx",
     .to = "phong",
     .by = "peak",
     .formula = "n = 2/alpha_ggx^2 - 2",
     .source = slopes,
     .assumes = peak,
     .limits = peak_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_ALPHA},
     .out = {V_N(0)},
     .apply = beckmann_to_phong},
    {.from = "mirror-phong",
     .to = "phong",
     .by = "",
     .formula = "n = 4 s",
     .source = curvature,
     .assumes = curvature_assumes,
     .limits = curvature_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_POSITIVE("s")},
     .out = {V_N(0)},
     .apply = mirror_to_phong},
    {.from = "phong",
     .to = "mirror-phong",
     .by = "",
     .formula = "s = n/4",
     .source = curvature,
     .assumes = curvature_assumes,
     .limits = curvature_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(0)},
     .out = {V_POSITIVE("s")},
     .apply = phong_to_mirror},
    {.from = "kelemen-ward",
     .to = "kelemen-phong",
     .by = "",
     .formula = "n = 2/m^2 - 1",
     .source = kelemen,
     .assumes = kelemen_assumes,
     .limits = kelemen_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_M(1.4142135623730950488)},
     .out = {V_N(-1)},
     .apply = kelemen_ward_to_phong,
     .doubt = doubt_n_out},
    {.from = "kelemen-phong",
     .to = "kelemen-ward",
     .by = "",
     .formula = "m = sqrt(2/(n + 1))",
     .source = kelemen,
     .assumes = kelemen_assumes,
     .limits = kelemen_limits,
     .matches = 1,
     .n_in = 1,
     .n_out = 1,
     .in = {V_N(-1)},
     .out = {V_M(INFINITY)},
     .apply = kelemen_phong_to_ward,
     .doubt = doubt_n_in},
    {.from = "beckmann",
     .to = "rms-slope",
     .by = "",
     .formula = "sigma = m/sqrt(2)",
     .source = rms,
     .assumes = rms_assumes,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_M(INFINITY)},
     .out = {V_POSITIVE("sigma")},
     .apply = divide_by_sqrt_2},
    {.from = "rms-slope",
     .to = "beckmann",
     .by = "",
     .formula = "m = sqrt(2) sigma",
     .source = rms,
     .assumes = rms_assumes,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_POSITIVE("sigma")},
     .out = {V_M(INFINITY)},
     .apply = times_sqrt_2},
};

FF_CONVERSION_GROUP(distributions, distributions);
