/* Numbers in text. Reading: a short exact path for what files contain, the C library in the C locale for the rest. Writing: the C++
 * library finds the digits, which are laid out here.
 *
 * A decimal m 10^k is one multiplication or division away from its double. That is correctly rounded when both factors are exact
 * (Clinger 1990: m < 2^53, |k| <= 22). Where long double has a 64-bit significand, m < 2^64 and |k| <= 27 are exact too, and
 * rounding its result to double is right unless it sits exactly half-way between two doubles, which is tested.
 *
 * Beyond that (a large exponent; more than 19 digits, of which the first 19 are taken) the result of a few operations is off by a
 * known number of units in its last place, of which a double has 11 bits fewer: rounding is right unless a half-way point lies
 * within that distance. */
#define _GNU_SOURCE
#include "internal_number.h"
#include "number_bridge.h"
#include <float.h>
#include <locale.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

static const double ten_to[23] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                  1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};

#if LDBL_MANT_DIG == 64 && (defined(__x86_64__) || defined(__i386__))
#define HAVE_EXTENDED 1
static const long double ten_to_extended[28] = {1e0L,  1e1L,  1e2L,  1e3L,  1e4L,  1e5L,  1e6L,  1e7L,  1e8L,  1e9L,
                                                1e10L, 1e11L, 1e12L, 1e13L, 1e14L, 1e15L, 1e16L, 1e17L, 1e18L, 1e19L,
                                                1e20L, 1e21L, 1e22L, 1e23L, 1e24L, 1e25L, 1e26L, 1e27L};

/* 10^(27 i), the closest long doubles. */
static const long double ten_to_27_times[13] = {1e0L,   1e27L,  1e54L,  1e81L,  1e108L, 1e135L, 1e162L,
                                                1e189L, 1e216L, 1e243L, 1e270L, 1e297L, 1e324L};

/* Rounds to double unless a half-way point lies within `units` of x's last place: the true number may be on its other side. */
static int round_extended(long double x, int units, double *value)
{
    uint64_t significand;
    memcpy(&significand, &x, sizeof significand);
    *value = (double)x;
    return abs((int)(significand & 0x7FFu) - 0x400) > units;
}

/* m 10^k, or with `more` any number from there to (m+1) 10^k, correctly rounded into *value; 0 when this cannot be told.
 * Three roundings (two operations and a constant), each of half a unit relative to the lower end of a binade, make 3 units; m has
 * 19 digits when there are more, so that one of its own is 1e-18 2^64 < 19 units at most. */
static int scale_closely(uint64_t m, int k, int more, double *value)
{
    enum { ROUNDINGS = 3, MORE = 19 };
    const int size = k < 0 ? -k : k, i = size / 27;
    if (i > 12) return 0;
    long double x = (long double)m;
    if (k < 0)
        x = x / ten_to_extended[size % 27] / ten_to_27_times[i];
    else
        x = x * ten_to_extended[size % 27] * ten_to_27_times[i];
    if (!(x >= 2 * DBL_MIN && x <= DBL_MAX / 2)) return 0; /* fewer bits than 53, or none */
    return round_extended(x, more ? ROUNDINGS + MORE : ROUNDINGS, value);
}
#else
#define HAVE_EXTENDED 0
static int scale_closely(uint64_t m, int k, int more, double *value)
{
    (void)m, (void)k, (void)more, (void)value;
    return 0;
}
#endif

/* m 10^k correctly rounded into *value; 0 when this needs more than one exact operation. */
static int scale_exactly(uint64_t m, int k, double *value)
{
    if (FLT_EVAL_METHOD == 0 && m <= (UINT64_C(1) << 53) && k >= -22 && k <= 22) {
        *value = k < 0 ? (double)m / ten_to[-k] : (double)m * ten_to[k];
        return 1;
    }
#if HAVE_EXTENDED
    if (k >= -27 && k <= 27)
        return round_extended(k < 0 ? (long double)m / ten_to_extended[-k] : (long double)m * ten_to_extended[k], 0, value);
#endif
    return 0;
}

/* strtod in the C locale, which always exists; the text is known to hold a number. */
static double read_slowly(const char *text)
{
    locale_t c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    double value = strtod_l(text, NULL, c_locale);
    freelocale(c_locale);
    return value;
}

static int is_digit(char c)
{
    return (unsigned)(c - '0') < 10u;
}

enum { EXACT_DIGITS = 19 }; /* as many always fit in 64 bits */

/* The digits from `p` to `stop`, a point among them, are more than EXACT_DIGITS; the last one counts 10^exponent. */
static int scale_long(const char *p, const char *stop, int exponent, double *value)
{
    while (p < stop && (*p == '0' || *p == '.')) p++; /* leading zeros do not count */
    uint64_t m = 0;
    int taken = 0, more = 0;
    for (; p < stop && taken < EXACT_DIGITS; p++)
        if (*p != '.') {
            m = 10 * m + (uint64_t)(*p - '0');
            taken++;
        }
    for (; p < stop; p++)
        if (*p != '.') {
            more |= *p != '0';
            exponent++;
        }
    if (m == 0) {
        *value = 0;
        return 1;
    }
    return (!more && scale_exactly(m, exponent, value)) || scale_closely(m, exponent, more, value);
}

const char *ff_number_read(const char *text, double *value)
{
    enum { EXPONENT_MAX = 100000 };
    const char *p = text;
    int negative = *p == '-';
    if (*p == '-' || *p == '+') p++;

    uint64_t m = 0;
    const char *first = p;
    while (is_digit(*p)) m = 10 * m + (uint64_t)(*p++ - '0');
    ptrdiff_t digits = p - first;
    int exponent = 0;
    if (*p == '.') {
        const char *fraction = ++p;
        while (is_digit(*p)) m = 10 * m + (uint64_t)(*p++ - '0');
        digits += p - fraction;
        if (p - fraction <= EXPONENT_MAX) exponent = -(int)(p - fraction);
    }
    if (digits == 0) return NULL;
    const char *after = p; /* the last digit before an exponent */
    if (*p == 'e' || *p == 'E') {
        const char *q = p + 1;
        int minus = *q == '-';
        if (*q == '-' || *q == '+') q++;
        if (!is_digit(*q)) return NULL;
        int e = 0;
        for (; is_digit(*q); q++)
            if (e < EXPONENT_MAX) e = 10 * e + (*q - '0');
        exponent += minus ? -e : e;
        p = q;
    }
    double magnitude = 0;
    int known = 0;
    if (digits <= EXACT_DIGITS)
        known = m == 0 || scale_exactly(m, exponent, &magnitude) || scale_closely(m, exponent, 0, &magnitude);
    else if (digits <= EXPONENT_MAX)
        known = scale_long(first, after, exponent, &magnitude);
    if (!known) magnitude = fabs(read_slowly(text));
    *value = negative ? -magnitude : magnitude;
    return p;
}

/* "e+05": at least two digits, as %g has them. */
static unsigned put_exponent(int exponent, char *out)
{
    char *p = out;
    const unsigned size = (unsigned)abs(exponent);
    *p++ = 'e';
    *p++ = exponent < 0 ? '-' : '+';
    if (size >= 100) *p++ = (char)('0' + size / 100);
    *p++ = (char)('0' + size / 10 % 10);
    *p++ = (char)('0' + size % 10);
    return (unsigned)(p - out);
}

/* Lays out n digits whose decimal point stands behind `point` of them: fixed point near 1, an exponent elsewhere, as %g would. */
static unsigned lay_out(const char *digits, int n, int point, char *out)
{
    char *p = out;
    if (point < -4 || point > 17) {
        *p++ = digits[0];
        if (n > 1) *p++ = '.';
        memcpy(p, digits + 1, (size_t)(n - 1));
        p += n - 1;
        return (unsigned)(p - out) + put_exponent(point - 1, p);
    }
    if (point <= 0) {
        *p++ = '0';
        *p++ = '.';
        for (int i = point; i < 0; i++) *p++ = '0';
    }
    for (int i = 0; i < n; i++) {
        if (i > 0 && i == point) *p++ = '.';
        *p++ = digits[i];
    }
    for (int i = n; i < point; i++) *p++ = '0';
    return (unsigned)(p - out);
}

unsigned ff_number_write(double value, char out[FF_NUMBER_TEXT])
{
    unsigned sign = 0;
    if (signbit(value)) out[sign++] = '-';
    if (value == 0) {
        out[sign] = '0';
        return sign + 1;
    }
    value = fabs(value);
    if (value >= 1e-5 && value < 1e15) return sign + ff_number_fixed(value, out + sign);
    char digits[FF_NUMBER_DIGITS];
    int exponent;
    const int n = ff_number_digits(value, digits, &exponent);
    return sign + lay_out(digits, n, exponent + 1, out + sign);
}

int ff_number_read_fortran(const char *text, size_t length, double *value)
{
    char copy[64];
    if (length == 0 || length >= sizeof copy) return 0;
    memcpy(copy, text, length);
    copy[length] = '\0';
    char *d = strpbrk(copy, "dD");
    if (!d || d == copy) return 0;
    *d = 'e';
    double v;
    const char *end = ff_number_read(copy, &v);
    if (!end || *end || !isfinite(v)) return 0;
    *value = v;
    return 1;
}
