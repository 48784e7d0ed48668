/* The elementary functions of the kernels against long double over the domain and to the accuracy that their comments state;
 * compiled as they are and, where the processor can, with fused products, as the kernels have them. */
#include "ff_test.h"
#include "base/internal_vector_math.h"
#include <stdint.h>

#if defined(__x86_64__) && defined(__GNUC__)
#define FUSED __attribute__((target("avx2,fma"), flatten, noinline))
static int can_fuse(void)
{
    return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2");
}
#else
#define FUSED __attribute__((noinline))
static int can_fuse(void)
{
    return 0;
}
#endif

/* ---- sampling -------------------------------------------------------------------------------- */

/* SplitMix64 */
static double uniform(uint64_t *state)
{
    uint64_t z = *state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return (double)((z ^ (z >> 31)) >> 11) / 9007199254740992.0;
}

enum { SAMPLES = 200000 };

/* How arguments are drawn: evenly, evenly in the logarithm (lo > 0), or at 1 +- a number even in the logarithm between lo and hi.
 */
typedef enum spread { EVEN, LOGARITHMIC, NEAR_ONE } spread;

static void draw(spread how, double lo, double hi, uint64_t seed, double *x)
{
    seed = ff_test_seeded(seed);
    for (int i = 0; i < SAMPLES; i++) {
        const double u = uniform(&seed), even = lo + (hi - lo) * u, log_even = lo > 0 ? exp(log(lo) + (log(hi) - log(lo)) * u) : 0;
        x[i] = how == EVEN ? even : how == LOGARITHMIC ? log_even : i % 2 ? 1 + log_even : 1 - log_even;
    }
    if (how != NEAR_ONE) x[0] = lo, x[1] = hi;
}

/* Units in the last place of the reference. */
static double ulps(double value, long double reference)
{
    const double r = (double)reference, next = nextafter(fabs(r), HUGE_VAL) - fabs(r);
    return (double)fabsl((long double)value - reference) / (next > 0 ? next : 5e-324);
}

static double relative(double value, long double reference)
{
    return reference == 0 ? fabs(value) : (double)fabsl(((long double)value - reference) / reference);
}

static double absolute(double value, long double reference)
{
    return (double)fabsl((long double)value - reference);
}

/* ---- what is checked ------------------------------------------------------------------------- */

typedef void (*function)(const double *x, const double *y, double *out);
typedef long double (*reference)(double x, double y);
typedef double (*measure)(double value, long double reference);

/* Each function twice: plain and fused. The inner loop is what a kernel's looks like. */
#define BOTH(name, expression)                                                                                                     \
    static void name##_plain(const double *x, const double *y, double *out)                                                        \
    {                                                                                                                              \
        (void)y;                                                                                                                   \
        for (int i = 0; i < SAMPLES; i++) out[i] = expression;                                                                     \
    }                                                                                                                              \
    FUSED static void name##_fused(const double *x, const double *y, double *out)                                                  \
    {                                                                                                                              \
        (void)y;                                                                                                                   \
        for (int i = 0; i < SAMPLES; i++) out[i] = expression;                                                                     \
    }
BOTH(rsqrt, ff_rsqrt(x[i]))
BOTH(recip, ff_recip(x[i]))
BOTH(exp, ff_exp(x[i]))
BOTH(log, ff_log(x[i]))
BOTH(log1p, ff_log1p(x[i]))
BOTH(erfcx, ff_erfcx(x[i]))
BOTH(angle, ff_angle(x[i], y[i]))
BOTH(rcbrt, ff_rcbrt(x[i]))

static long double rsqrt_reference(double x, double y)
{
    (void)y;
    return 1 / sqrtl((long double)x);
}

static long double recip_reference(double x, double y)
{
    (void)y;
    return 1 / (long double)x;
}

static long double exp_reference(double x, double y)
{
    (void)y;
    return expl((long double)x);
}

static long double log_reference(double x, double y)
{
    (void)y;
    return logl((long double)x);
}

static long double log1p_reference(double x, double y)
{
    (void)y;
    return log1pl((long double)x);
}

static long double angle_reference(double s, double c)
{
    return atan2l((long double)s, (long double)c);
}

static long double rcbrt_reference(double x, double y)
{
    (void)y;
    return 1 / cbrtl((long double)x);
}

/* e^(a^2) erfc(a): directly while the exponent's rounding is harmless, then by the continued fraction (DLMF 7.9.1). */
static long double erfcx_reference(double x, double y)
{
    const long double a = x, root_pi = 1.772453850905516027298167483341145183L;
    long double tail = a;
    (void)y;
    if (x < 3) return expl(a * a) * erfcl(a);
    for (int k = 400; k > 0; k--) tail = a + 0.5L * (long double)k / tail;
    return 1 / (root_pi * tail);
}

static void check(const char *name, function plain, function fused, reference exact, measure error, double allowed, const double *x,
                  const double *y)
{
    static double out[SAMPLES];
    for (int variant = 0; variant < 1 + can_fuse(); variant++) {
        double worst = 0, where[2] = {0, 0};
        (variant ? fused : plain)(x, y, out);
        for (int i = 0; i < SAMPLES; i++) {
            const double e = error(out[i], exact(x[i], y[i]));
            if (e <= worst) continue;
            worst = e; /* also where e is NaN */
            where[0] = x[i], where[1] = y[i];
            if (isnan(e)) break;
        }
        FF_CHECK(worst <= allowed, "%s (%s): error %.3g at %.17g, %.17g; stated is %.3g", name, variant ? "fused" : "plain", worst,
                 where[0], where[1], allowed);
        printf("  %-36s %s  %.3g of %.3g\n", name, variant ? "fused" : "plain", worst, allowed);
    }
}

static double arguments[SAMPLES], second[SAMPLES];

#define CHECK(what, name, error, allowed)                                                                                          \
    check(what, name##_plain, name##_fused, name##_reference, error, allowed, arguments, second)

static void roots_and_reciprocals(void)
{
    draw(LOGARITHMIC, 1e-300, 1e300, 1, arguments);
    CHECK("1/sqrt(x), 1e-300 .. 1e300", rsqrt, ulps, 2);
    CHECK("1/x, 1e-300 .. 1e300", recip, ulps, 2);
    draw(EVEN, 0.25, 4, 2, arguments);
    CHECK("1/sqrt(x), 1/4 .. 4", rsqrt, ulps, 2);
    CHECK("1/x, 1/4 .. 4", recip, ulps, 2);
    draw(LOGARITHMIC, 1e-290, 1e290, 3, arguments);
    CHECK("x^(-1/3), 1e-290 .. 1e290", rcbrt, ulps, 3);
    draw(EVEN, 0.125, 8, 4, arguments);
    CHECK("x^(-1/3), 1/8 .. 8", rcbrt, ulps, 3);
}

static void exponential(void)
{
    draw(EVEN, -650, 709, 5, arguments);
    CHECK("exp(x), -650 .. 709", exp, ulps, 2);
    draw(EVEN, -1, 1, 6, arguments);
    CHECK("exp(x), -1 .. 1", exp, ulps, 2);
    draw(LOGARITHMIC, 1e-300, 1, 7, arguments);
    CHECK("exp(x), 1e-300 .. 1", exp, ulps, 2);
    const double below[] = {nextafter(-650, -HUGE_VAL), -651, -708, -745, -1e4, -1e300, -HUGE_VAL};
    for (size_t i = 0; i < sizeof below / sizeof *below; i++)
        FF_CHECK(ff_exp(below[i]) == 0, "exp(%g) is %g", below[i], ff_exp(below[i]));
    FF_CHECK(ff_exp(0) == 1 && ff_exp(-650) > 0, "exp(0) is %.17g, exp(-650) %g", ff_exp(0), ff_exp(-650));
}

static void logarithms(void)
{
    draw(LOGARITHMIC, 2.3e-308, 1.7e308, 8, arguments);
    CHECK("ln(x), all normal numbers", log, ulps, 2);
    draw(NEAR_ONE, 1e-17, 0.2, 9, arguments);
    CHECK("ln(x), near 1, absolute", log, absolute, 1e-16);
    draw(EVEN, 0.5, 0.8, 10, arguments); /* away from 1, the same octave and the next */
    CHECK("ln(x), 0.5 .. 0.8", log, ulps, 2);
    draw(EVEN, 1.2, 4, 11, arguments);
    CHECK("ln(x), 1.2 .. 4", log, ulps, 2);
    FF_CHECK(ff_log(1) == 0, "ln 1 is %g", ff_log(1));
    draw(LOGARITHMIC, 1e-300, 1e300, 12, arguments);
    CHECK("ln(1 + u), 1e-300 .. 1e300", log1p, relative, 1e-15);
    draw(EVEN, -0.999999, 2, 13, arguments);
    CHECK("ln(1 + u), -0.999999 .. 2", log1p, relative, 1e-15);
    draw(LOGARITHMIC, 1e-16, 0.999, 14, arguments);
    for (int i = 0; i < SAMPLES; i++) arguments[i] = -arguments[i];
    CHECK("ln(1 + u), -0.999 .. -1e-16", log1p, relative, 1e-15);
}

/* Relative error in units of |y ln x|, which the accuracy is stated by (at least 1: the exponential rounds too). */
static void sine_and_cosine(void)
{
    uint64_t state = ff_test_stream("sine and cosine");
    double worst = 0;
    for (int i = 0; i < SAMPLES; i++) { /* small angles, those of measurements, and out to the end of the range */
        const double u = 2 * uniform(&state) - 1, x = i % 3 == 0   ? 7 * u
                                                      : i % 3 == 1 ? 1e5 * u
                                                                   : u * pow(10, -12 * uniform(&state));
        double sine, cosine;
        ff_sincos(x, &sine, &cosine);
        const double e = fmax((double)fabsl(sine - sinl(x)), (double)fabsl(cosine - cosl(x)));
        FF_CHECK(e <= 3e-16, "%.17g: error %.3g", x, e);
        worst = fmax(worst, e);
    }
    printf("  sin(x), cos(x), absolute             plain  %.3g of 3e-16\n", worst);
    for (int k = -8; k <= 8; k++) { /* whole quarter turns, where a wrong quadrant would show */
        const double x = k * (FF_PI / 2);
        double sine, cosine;
        ff_sincos(x, &sine, &cosine);
        FF_CHECK_CLOSE(sine, sin(x), 0, 3e-16);
        FF_CHECK_CLOSE(cosine, cos(x), 0, 3e-16);
    }
    double sine, cosine;
    ff_sincos(0, &sine, &cosine);
    FF_CHECK(sine == 0 && cosine == 1, "at 0: %.17g, %.17g", sine, cosine);
}

static void complementary_error_function(void)
{
    draw(EVEN, 0, 3, 18, arguments);
    CHECK("erfcx(a), 0 .. 3", erfcx, relative, 1e-15);
    draw(EVEN, 3, 30, 19, arguments);
    CHECK("erfcx(a), 3 .. 30", erfcx, relative, 1e-15);
    draw(LOGARITHMIC, 1e-20, 1e100, 20, arguments);
    CHECK("erfcx(a), 1e-20 .. 1e100", erfcx, relative, 1e-15);
    /* the two references agree where they meet */
    const long double a = 3, direct = expl(a * a) * erfcl(a);
    FF_CHECK(fabsl(direct - erfcx_reference(3, 0)) < 1e-18L * direct * 10, "the reference has a seam at 3");
}

static void angles(void)
{
    uint64_t state = ff_test_stream("angles");
    for (int i = 0; i < SAMPLES; i++) { /* all angles, any length of the vector, small angles and those near pi/2 and pi */
        const double phi = 3.14159265358979 * uniform(&state), r = pow(10, 200 * uniform(&state) - 100),
                     small = pow(10, -15 * uniform(&state));
        arguments[i] = fabs(i % 4 == 1 ? small : i % 4 == 2 ? 1 : sin(phi)) * r;
        second[i] = (i % 4 == 1 ? (i % 8 == 1 ? 1 : -1) : i % 4 == 2 ? (i % 8 == 2 ? small : -small) : cos(phi)) * r;
    }
    arguments[0] = 0, second[0] = 1, arguments[1] = 0, second[1] = -1, arguments[2] = 1, second[2] = 0;
    CHECK("angle of (c, s)", angle, ulps, 4);
    for (int i = 0; i < SAMPLES; i++) { /* on both sides of the seams, where the least angle meets the largest error */
        const double ratio = (i % 2 ? 0.25 : 0.75) * (1 + (uniform(&state) - 0.5) * (i % 4 < 2 ? 0.02 : 1e-14)),
                     r = pow(2, 2 * uniform(&state) - 1);
        arguments[i] = i % 8 < 4 ? ratio * r : r;
        second[i] = (i % 16 < 8 ? 1 : -1) * (i % 8 < 4 ? r : ratio * r);
    }
    CHECK("angle of (c, s), at the seams", angle, ulps, 4);
    FF_CHECK(ff_angle(0, 1) == 0 && ff_angle(0, -2) == FF_PI, "the ends: %.17g, %.17g", ff_angle(0, 1), ff_angle(0, -2));
}

FF_TEST_MAIN(FF_TEST(roots_and_reciprocals), FF_TEST(exponential), FF_TEST(logarithms), FF_TEST(sine_and_cosine),
             FF_TEST(complementary_error_function), FF_TEST(angles))
