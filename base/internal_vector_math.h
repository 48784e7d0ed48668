/* Elementary functions as plain inline arithmetic, so that loops which call them are vectorised for every instruction set and
 * give the same answer with every C library. Accuracy is stated per function and checked against long double in the tests.
 * Nothing here looks at errno, traps or the rounding mode. */
#ifndef FF_INTERNAL_VECTOR_MATH_H
#define FF_INTERNAL_VECTOR_MATH_H
#include <math.h>
#include <stdint.h>
#include <string.h>

#define FF_PI      3.14159265358979323846
#define FF_SQRT_PI 1.77245385090551602730

static inline uint64_t ff_bits(double x)
{
    uint64_t b;
    memcpy(&b, &x, sizeof b);
    return b;
}

static inline double ff_from_bits(uint64_t b)
{
    double x;
    memcpy(&x, &b, sizeof x);
    return x;
}

/* 1/sqrt(x), x in [1e-300, 1e300]; 2 ulp. A first guess from the exponent, then Newton; several times faster than a vector
 * square root and division, which is what bounds the kernels. */
static inline double ff_rsqrt(double x)
{
    double y = ff_from_bits(UINT64_C(0x5fe6eb50c7b537a9) - (ff_bits(x) >> 1));
    const double h = 0.5 * x;
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    y = y * (1.5 - h * y * y);
    return y + y * (0.5 - h * y * y);
}

/* 1/x, x in [1e-300, 1e300], positive; 2 ulp. With e = 1 - x y, 1/x = y (1 + e) (1 + e^2) (1 + e^4) ...; the squares do not wait
 * for the products. The last step takes its e afresh and so removes the rounding of those before. */
static inline double ff_recip(double x)
{
    double y = ff_from_bits(UINT64_C(0x7fde623822fc16e6) - ff_bits(x));
    const double e = 1 - x * y, e2 = e * e, e4 = e2 * e2, e8 = e4 * e4;
    y += y * e;
    y += y * e2;
    y += y * e4;
    y += y * e8;
    return y + y * (1 - x * y);
}

/* e^x for x <= 709; below -650 (6e-283) exactly 0, so that what it is multiplied by does not soon make it subnormal, at a hundred
 * times the cost; 2 ulp. */
static inline double ff_exp(double x)
{
    const double magic = 6755399441055744.0; /* 1.5 * 2^52: adding it rounds to an integer kept in the low bits */
    const double xc = x < -650 ? -650 : x;
    const double k = xc * 1.4426950408889634074 + magic;
    const double n = k - magic;
    const double r = (xc - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
    /* Taylor, |r| <= ln(2)/2 leaves 1e-17; the even and the odd powers from the square on apart, 1 + r last */
    const double r2 = r * r;
    double even = 2.0876756987868099e-09, odd = 1.6059043836821613e-10; /* 1/12!, 1/13! ... */
    even = even * r2 + 2.7557319223985891e-07;
    odd = odd * r2 + 2.5052108385441719e-08;
    even = even * r2 + 2.4801587301587302e-05;
    odd = odd * r2 + 2.7557319223985893e-06;
    even = even * r2 + 1.3888888888888889e-03;
    odd = odd * r2 + 1.9841269841269841e-04;
    even = even * r2 + 4.1666666666666667e-02;
    odd = odd * r2 + 8.3333333333333333e-03;
    even = even * r2 + 0.5;
    odd = odd * r2 + 1.6666666666666667e-01;
    const double p = 1 + (r + r2 * (even + r * odd));
    const double y = ff_from_bits(ff_bits(p) + (ff_bits(k) << 52));
    return x < -650 ? 0 : y;
}

/* ln x for x a positive normal number; 2 ulp away from 1, absolute 1e-16 near it. */
static inline double ff_log(double x)
{
    /* x = m 2^e with m in [sqrt(1/2), sqrt(2)): subtracting the bits of sqrt(1/2) makes the exponent round the right way */
    const uint64_t b = ff_bits(x) - UINT64_C(0x3fe6a09e667f3bcd);
    const uint64_t biased = (b >> 52) + 2048; /* the shift drops the sign, which the sum below restores modulo 2^12 */
    const double e = ff_from_bits(UINT64_C(0x4330000000000000) | (biased & 0xfff)) - 4503599627370496.0;
    const double exponent = e - 2048;
    const double m = ff_from_bits((b & UINT64_C(0x000fffffffffffff)) + UINT64_C(0x3fe6a09e667f3bcd));
    const double f = m - 1, s = f * ff_recip(2 + f), z = s * s;
    /* 2 atanh(s) = 2s + 2s^3/3 + ..., s^2 <= 0.0295; every other power apart */
    const double z2 = z * z;
    double even = 0.0526315789473684211, odd = 0.0588235294117647059;
    even = 0.0666666666666666667 + z2 * even;
    odd = 0.0769230769230769231 + z2 * odd;
    even = 0.0909090909090909091 + z2 * even;
    odd = 0.1111111111111111111 + z2 * odd;
    even = 0.1428571428571428571 + z2 * even;
    odd = 0.2 + z2 * odd;
    even = 0.3333333333333333333 + z2 * even;
    const double p = even + z * odd;
    /* 2 s = f - f^2/2 + s f^2/2, since s (2 + f) = f: the rounding of s then weighs little */
    const double half = 0.5 * f * f, log_m = f - (half - s * (half + 2 * z * p));
    return exponent * 6.93147180369123816490e-01 + (log_m + exponent * 1.90821492927058770002e-10);
}

/* ln(1 + u), u > -1; relative error 1e-15 also for small u. */
static inline double ff_log1p(double u)
{
    const double w = 1 + u;
    return ff_log(w) + (u - (w - 1)) * ff_recip(w);
}

/* erfcx(a) = e^(a^2) erfc(a) for a >= 0; relative error 1e-15. Chebyshev in t = (a-3)/(a+3) of (1+2a) erfcx(a), after Shepherd
 * and Laframboise 1981; the coefficients were made with 50 digits and are listed by rising power of t. */
static inline double ff_erfcx(double a)
{
    const double inv = ff_recip((a + 3) * (1 + 2 * a));
    const double t = (a - 3) * (1 + 2 * a) * inv;
    const double t2 = t * t;
    double even = -1.8819366309448578957e-10, odd = -3.4514974876643280986e-11;
    even = even * t2 + 2.0626322959832453872e-9;
    odd = odd * t2 + 1.2019719440135792655e-9;
    even = even * t2 - 1.1734464137789657048e-8;
    odd = odd * t2 - 1.3906145791730994106e-8;
    even = even * t2 + 4.6950946691614736373e-8;
    odd = odd * t2 + 1.027799748827105812e-7;
    even = even * t2 - 1.4683175494120583286e-7;
    odd = odd * t2 - 6.1756176789923229375e-7;
    even = even * t2 + 3.6039109257127711052e-7;
    odd = odd * t2 + 3.4730241678415327668e-6;
    even = even * t2 - 7.3314325974359697639e-7;
    odd = odd * t2 - 2.0100843094844726218e-5;
    even = even * t2 + 4.9499886622643469614e-6;
    odd = odd * t2 + 1.2509943557128120702e-4;
    even = even * t2 - 1.0515990108729848212e-4;
    odd = odd * t2 - 7.7983228848230843277e-4;
    even = even * t2 + 1.8886903716907627074e-3;
    odd = odd * t2 + 2.5293918180474667515e-3;
    even = even * t2 - 2.3770514919506851001e-2;
    odd = odd * t2 + 6.8308027343845158991e-2;
    even = even * t2 - 0.11927366341528022434;
    odd = odd * t2 + 0.12964515870276474118;
    even = even * t2 - 4.7562294353451092395e-2;
    odd = odd * t2 - 0.13562110612458120994;
    even = even * t2 + 1.2530080582697296527;
    return (even + t * odd) * (a + 3) * inv;
}

/* sin x and cos x for |x| <= 1e5; absolute error 3e-16. Reduction by multiples of pi/2 in three parts, Taylor series on [-pi/4,
 * pi/4]. */
static inline void ff_sincos(double x, double *sin_x, double *cos_x)
{
    const double magic = 6755399441055744.0; /* 1.5 * 2^52, as in ff_exp */
    const double shifted = x * 0.63661977236758134308 + magic, k = shifted - magic;
    const uint64_t quadrant = ff_bits(shifted);
    const double r = ((x - k * 1.57079632673412561417e+00) - k * 6.07710050630396597660e-11) - k * 2.02226624879595063154e-21,
                 z = r * r;
    double s = -7.6471637318198164759e-13; /* -1/15! */
    s = s * z + 1.6059043836821614599e-10;
    s = s * z - 2.5052108385441718775e-08;
    s = s * z + 2.7557319223985890653e-06;
    s = s * z - 1.9841269841269841270e-04;
    s = s * z + 8.3333333333333333333e-03;
    s = s * z - 1.6666666666666666667e-01;
    s = r + r * z * s;
    double c = 4.7794773323873852974e-14; /* 1/16! */
    c = c * z - 1.1470745597729724714e-11;
    c = c * z + 2.0876756987868098979e-09;
    c = c * z - 2.7557319223985890653e-07;
    c = c * z + 2.4801587301587301587e-05;
    c = c * z - 1.3888888888888888889e-03;
    c = c * z + 4.1666666666666666667e-02;
    c = (1 - 0.5 * z) + z * z * c;
    const double a = quadrant & 1 ? c : s, b = quadrant & 1 ? s : c;
    *sin_x = ff_from_bits(ff_bits(a) ^ (quadrant & 2) << 62);
    *cos_x = ff_from_bits(ff_bits(b) ^ ((quadrant + 1) & 2) << 62);
}

/* Angle in [0, pi] whose cosine and sine are proportional to c and s >= 0, not both 0; 4 ulp. The octant, then atan(lo/hi) = atan T
 * + atan t with t = (lo - T hi) / (hi + T lo) and T the nearest of 0, 1/2 and 1, then the series of atan for |t| <= 1/4.
 *
 * With u = 2^-53: T hi and T lo are exact, and so is lo - T hi (Sterbenz; lo is between T hi / 2 and 2 T hi). So t has two
 * roundings, of the sum and the quotient, 2 u t; its series adds one and 1/50, being t + t^3/3 at most; what is left out is below
 * 1e-17 t. atan T is given to twice the digits. Where T is 1/2 that is 3.1 u of |atan t| <= 0.219 and half an ulp, at worst where
 * the sum is as small as 0.245 with an ulp of u/4: 3.2 ulp. Where T is 0, t has one rounding: 1.6 ulp; where it is 1: 1 ulp. From
 * pi/2, and from pi, the ulp is 2 or 4 times that, the error another half of it and 0.6 u of pi/2: below 3 ulp. */
static inline double ff_angle(double s, double c)
{
    const double ac = fabs(c), hi = s > ac ? s : ac, lo = s > ac ? ac : s;
    const double T = lo > 0.75 * hi ? 1 : lo > 0.25 * hi ? 0.5 : 0;
    const double at = lo > 0.75 * hi   ? 7.85398163397448278999e-01
                      : lo > 0.25 * hi ? 4.63647609000806093515e-01
                                       : 0,
                 rest = lo > 0.75 * hi   ? 3.06161699786838301793e-17
                        : lo > 0.25 * hi ? 2.26987774529616870924e-17
                                         : 0;
    const double t = (lo - T * hi) / (hi + T * lo), z = t * t;
    double p = 0.04;
    p = -0.0434782608695652174 + z * p;
    p = 0.0476190476190476190 + z * p;
    p = -0.0526315789473684211 + z * p;
    p = 0.0588235294117647059 + z * p;
    p = -0.0666666666666666667 + z * p;
    p = 0.0769230769230769231 + z * p;
    p = -0.0909090909090909091 + z * p;
    p = 0.1111111111111111111 + z * p;
    p = -0.1428571428571428571 + z * p;
    p = 0.2 + z * p;
    p = -0.3333333333333333333 + z * p;
    const double first = at + (t + (rest + t * z * p));
    const double quarter = s > ac ? FF_PI / 2 - first : first;
    return c < 0 ? FF_PI - quarter : quarter;
}

/* x^(-1/3), x in [1e-290, 1e290]; 3 ulp. A first guess from the exponent, then Newton. */
static inline double ff_rcbrt(double x)
{
    /* a third of the exponent in integer arithmetic: the multiplication is that of the high word only */
    const uint64_t third = ((ff_bits(x) >> 32) * UINT64_C(1431655766)) >> 32;
    double y = ff_from_bits((UINT64_C(0x553ef0ff) - third) << 32);
    const double h = x * (1.0 / 3);
    y = y * (4.0 / 3 - h * y * y * y);
    y = y * (4.0 / 3 - h * y * y * y);
    y = y * (4.0 / 3 - h * y * y * y);
    y = y * (4.0 / 3 - h * y * y * y);
    return y + y * (1.0 / 3 - h * y * y * y);
}

/* A polynomial of an even count of coefficients by rising power, the count a constant at each call; even and odd powers apart halve
 * the chain of dependent sums. */
static inline double ff_polynomial(int count, const double *restrict c, double t)
{
    const double t2 = t * t;
    double even = c[count - 2], odd = c[count - 1];
#pragma GCC unroll 16
    for (int k = count - 4; k >= 0; k -= 2) {
        even = even * t2 + c[k];
        odd = odd * t2 + c[k + 1];
    }
    return even + t * odd;
}

#endif
