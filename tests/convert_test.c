/* Conversions of roughness and of reflectance: values by hand, round trips, what is refused and why, the ellipse at its two hard
 * ends, indices of refraction over their whole range. */
#include "ff_test.h"
#include "ff_convert.h"
#include <complex.h>
#include <float.h>

#define PI 3.14159265358979323846

static ff_status convert(const char *from, const char *to, const char *by, const double *in, double *out, ff_error *err)
{
    const int i = ff_conversion_find(from, to, by, 0);
    if (i < 0) {
        FF_CHECK(0, "no conversion %s -> %s by %s", from, to, by ? by : "any");
        exit(1);
    }
    return ff_conversion_apply(ff_conversion_at((size_t)i), in, PI / 4, out, err);
}

static double convert1(const char *from, const char *to, const char *by, double x)
{
    double out = NAN;
    ff_error err = {0};
    FF_CHECK(convert(from, to, by, &x, &out, &err) == FF_OK, "%s -> %s of %g: %s", from, to, x, err.message);
    return out;
}

static void by_hand(void)
{
    FF_CHECK(convert1("beckmann", "phong", NULL, 0.25) == 30, "2/0.0625 - 2");
    FF_CHECK_CLOSE(convert1("phong", "beckmann", NULL, 30), 0.25, 1e-15, 0);
    FF_CHECK_CLOSE(convert1("phong", "beckmann", NULL, 1e-9), 1, 1e-9, 0);
    FF_CHECK_CLOSE(convert1("beckmann", "ggx", "mean-slope", 1), 0.5641895835477563, 1e-15, 0);
    FF_CHECK_CLOSE(convert1("ggx", "beckmann", "mean-slope", 1), 1.7724538509055159, 1e-15, 0);
    FF_CHECK(convert1("beckmann", "ggx", "peak", 0.3) == 0.3, "equal peak");
    FF_CHECK(convert1("roughness", "alpha", NULL, 0.5) == 0.25, "squared");
    FF_CHECK(convert1("alpha", "roughness", NULL, 0.25) == 0.5, "root");
    FF_CHECK(convert1("roughness", "alpha", NULL, 0) == 0, "a mirror");
    FF_CHECK_CLOSE(convert1("kelemen-ward", "kelemen-phong", NULL, 0.8), 2.125, 1e-14, 0); /* 2.1 in figure 3 of the paper */
    FF_CHECK_CLOSE(convert1("kelemen-ward", "kelemen-phong", NULL, 0.4), 11.5, 1e-14, 0);  /* 11.5 there                  */
    FF_CHECK_CLOSE(convert1("beckmann", "rms-slope", NULL, 0.2), 0.2 / sqrt(2), 1e-15, 0);
    FF_CHECK_CLOSE(convert1("rms-slope", "beckmann", NULL, 0.2), 0.2 * sqrt(2), 1e-15, 0);
}

/* The criterion that each entry names, by quadrature of the two distributions rather than by the formula of the entry. */
static void criteria_hold(void)
{
    const double m = 0.37, g = convert1("beckmann", "ggx", "mean-slope", m), n = convert1("beckmann", "phong", NULL, m);
    double mean_b = 0, mean_g = 0;
    /* E|s_x| = integral of |s| P2(s) over one axis, s = tan(t) */
    const int steps = 200000;
    for (int i = 0; i < steps; i++) {
        const double t = (i + 0.5) * (PI / 2) / steps, s = tan(t), ds = (PI / 2) / steps / (cos(t) * cos(t));
        mean_b += 2 * s * exp(-s * s / (m * m)) / (m * sqrt(PI)) * ds;
        mean_g += 2 * s * g * g / (2 * pow(g * g + s * s, 1.5)) * ds;
    }
    FF_CHECK_CLOSE(mean_b, mean_g, 1e-4, 0);
    FF_CHECK_CLOSE((n + 2) / (2 * PI), 1 / (PI * m * m), 1e-14, 0); /* equal D(z): phong and beckmann */
}

static void round_trips(void)
{
    static const char *const pairs[][3] = {
        {"beckmann", "phong", NULL},  {"beckmann", "ggx", "mean-slope"},       {"beckmann", "ggx", "peak"},
        {"roughness", "alpha", NULL}, {"kelemen-ward", "kelemen-phong", NULL}, {"beckmann", "rms-slope", NULL}};
    for (size_t p = 0; p < sizeof pairs / sizeof pairs[0]; p++)
        for (double x = 1e-3; x < 0.999; x *= 1.7) {
            const double there = convert1(pairs[p][0], pairs[p][1], pairs[p][2], x);
            FF_CHECK_CLOSE(convert1(pairs[p][1], pairs[p][0], pairs[p][2], there), x, 1e-14, 0);
        }
}

/* A convention has the same values in every conversion that takes or gives it. */
static void check_values(const char *name, const ff_conversion_value *v, uint32_t n)
{
    for (size_t i = 0; i < ff_conversion_count(); i++) {
        const ff_conversion *c = ff_conversion_at(i);
        for (int side = 0; side < 2; side++) {
            const ff_conversion_value *w = side ? c->out : c->in;
            if (strcmp(side ? c->to : c->from, name)) continue;
            FF_CHECK((side ? c->n_out : c->n_in) == n, "%s has %u values, and another number", name, n);
            for (uint32_t k = 0; k < n; k++)
                FF_CHECK(!strcmp(v[k].name, w[k].name) && !strcmp(v[k].unit, w[k].unit), "%s: %s, %s", name, v[k].name, w[k].name);
        }
    }
}

/* What leads there leads back, but where values are lost on the way. */
static void every_entry_has_its_inverse_and_its_words(void)
{
    for (size_t i = 0; i < ff_conversion_count(); i++) {
        const ff_conversion *c = ff_conversion_at(i);
        ff_conversion_path path;
        FF_CHECK(ff_conversion_find(c->to, c->from, c->by, 0) >= 0 || c->n_in != c->n_out || *c->by == '\0', "%s -> %s", c->to,
                 c->from);
        FF_CHECK(ff_conversion_paths(c->to, c->from, NULL, 1, &path) == 1, "no way from %s to %s", c->to, c->from);
        FF_CHECK(*c->formula && *c->source && *c->assumes && *c->limits, "%s -> %s says too little", c->from, c->to);
        FF_CHECK(c->n_in > 0 && c->n_out > 0 && !c->apply != !c->apply_at, "%s -> %s", c->from, c->to);
        check_values(c->from, c->in, c->n_in);
        check_values(c->to, c->out, c->n_out);
        for (size_t j = i + 1; j < ff_conversion_count(); j++) {
            const ff_conversion *d = ff_conversion_at(j);
            FF_CHECK(strcmp(c->from, d->from) || strcmp(c->to, d->to) || strcmp(c->by, d->by), "%s -> %s twice", c->from, c->to);
        }
    }
    FF_CHECK(ff_conversion_at(ff_conversion_count()) == NULL, "past the end");
    FF_CHECK(ff_conversion_find("beckmann", "nothing", NULL, 0) == -1, "unknown");
    FF_CHECK(ff_conversion_find("beckmann", "ggx", "looks", 0) == -1, "unknown criterion");
    FF_CHECK(ff_conversion_find("beckmann", "ggx", NULL, (size_t)ff_conversion_find("beckmann", "ggx", "mean-slope", 0) + 1) >= 0,
             "the second one");
}

static void refuses(const char *from, const char *to, double x, const char *words)
{
    double out = 4711;
    ff_error err = {0};
    FF_CHECK(convert(from, to, NULL, &x, &out, &err) == FF_ERR_RANGE, "%s -> %s of %g gives %g", from, to, x, out);
    FF_CHECK(out == 4711, "output written by a refusal");
    FF_CHECK(strstr(err.message, words) != NULL, "'%s' lacks '%s'", err.message, words);
}

static void what_has_no_answer(void)
{
    refuses("beckmann", "phong", 1, "n = 0");
    refuses("phong", "beckmann", 0, "n = 0"); /* m = 1, which has no exponent */
    refuses("beckmann", "phong", 2, "n = -1.5");
    refuses("beckmann", "phong", 2, "(0, 1)");
    refuses("beckmann", "phong", 0, "(0, 1)");
    refuses("beckmann", "phong", -0.1, "(0, 1)");
    refuses("beckmann", "phong", NAN, "nan");
    refuses("beckmann", "phong", INFINITY, "inf");
    refuses("beckmann", "phong", 1e-200, "outside"); /* n overflows */
    refuses("phong", "beckmann", -2, "(0, inf)");
    refuses("phong", "beckmann", -3, "(0, inf)");
    refuses("phong", "beckmann", NAN, "nan");
    refuses("kelemen-phong", "kelemen-ward", -1, "(-1, inf)");
    refuses("kelemen-ward", "kelemen-phong", 1.5, "n = -0.111111");
    refuses("roughness", "alpha", -0.5, "[0, inf)");
    refuses("ggx", "beckmann", 0, "(0, inf)");
}

static void doubts(void)
{
    const ff_conversion *c = ff_conversion_at((size_t)ff_conversion_find("beckmann", "phong", NULL, 0));
    double in = 0.25, out;
    ff_conversion_apply(c, &in, 0, &out, NULL);
    FF_CHECK(ff_conversion_doubt(c, &in, &out) == NULL, "n = 30 is in the good range");
    in = 0.5; /* n = 6 */
    ff_conversion_apply(c, &in, 0, &out, NULL);
    FF_CHECK(ff_conversion_doubt(c, &in, &out) && strstr(ff_conversion_doubt(c, &in, &out), "n <= 8"), "n = 6 is not");
}

/* Long double reference: eigenvalues of the matrix. */
static void check_ellipse(double ax, double ay, double r)
{
    const double in[3] = {ax, ay, r};
    double e[3], back[3];
    ff_error err = {0};
    FF_CHECK(convert("correlated", "ellipse", NULL, in, e, &err) == FF_OK, "%s", err.message);
    const long double A = (long double)ax * ax, B = (long double)ay * ay, C = (long double)r * ax * ay;
    const long double half_difference = ((long double)ax - ay) * ((long double)ax + ay) / 2;
    const long double R = hypotl(half_difference, C), det = A * B * (1 - (long double)r) * (1 + (long double)r);
    const long double major = sqrtl((A + B) / 2 + R), minor = sqrtl(det) / major;
    FF_CHECK_CLOSE(e[0], (double)major, 4e-16, 0);
    FF_CHECK_CLOSE(e[1], (double)minor, 8e-16, 0);
    FF_CHECK(e[0] >= e[1] * (1 - 4e-16), "%g %g %g: major %.17g minor %.17g", ax, ay, r, e[0], e[1]);
    FF_CHECK(e[2] >= 0 && e[2] < PI, "phi %.17g", e[2]);
    long double phi = atan2l(C, half_difference) / 2;
    if (phi < 0) phi += acosl(-1);
    if (R > 0) FF_CHECK_CLOSE(fabs(remainder(e[2] - (double)phi, PI)), 0, 0, 4e-16 * PI);
    if (convert("ellipse", "correlated", NULL, e, back, &err) != FF_OK) {
        FF_CHECK(1 - fabs(r) < 1e-12, "%g %g %g does not come back: %s", ax, ay, r, err.message);
        return;
    }
    /* An axis much shorter than the ellipse is long inherits the rounding of phi. */
    const double slack = 4e-16 * e[0];
    FF_CHECK_CLOSE(back[0], ax, 2e-15, slack);
    FF_CHECK_CLOSE(back[1], ay, 2e-15, slack);
    FF_CHECK_CLOSE(back[2], r, 0, 2e-15 + 4 * slack / fmin(ax, ay));
}

static void ellipse(void)
{
    static const double alphas[] = {1e-4, 0.05, 0.2, 0.2 + 1e-15, 0.45, 0.9, 0.9 + 1.2e-16, 1.5, 4};
    static const double rs[] = {0, 1e-300, 1e-17, -1e-17, 0.4, -0.4, 0.9, -0.9, 0.999999999, 1 - 1e-15, -1 + 1e-15};
    for (size_t i = 0; i < sizeof alphas / sizeof alphas[0]; i++)
        for (size_t j = 0; j < sizeof alphas / sizeof alphas[0]; j++)
            for (size_t k = 0; k < sizeof rs / sizeof rs[0]; k++) check_ellipse(alphas[i], alphas[j], rs[k]);
    check_ellipse(1e-200, 3e-200, 0.5);
    check_ellipse(1e200, 3e200, 0.5);

    double e[3];
    ff_error err = {0};
    convert("correlated", "ellipse", NULL, (const double[]){0.2, 0.45, 0}, e, &err);
    FF_CHECK(e[0] == 0.45 && e[1] == 0.2, "the longer axis comes first");
    FF_CHECK_CLOSE(e[2], PI / 2, 1e-16, 0);
    convert("correlated", "ellipse", NULL, (const double[]){0.3, 0.3, -0.5}, e, &err); /* eigenvalues 0.09 (1 +- 0.5) */
    FF_CHECK_CLOSE(e[0], 0.3 * sqrt(1.5), 1e-15, 0);
    FF_CHECK_CLOSE(e[1], 0.3 * sqrt(0.5), 1e-15, 0);
    FF_CHECK_CLOSE(e[2], 3 * PI / 4, 1e-15, 0);
    convert("ellipse", "correlated", NULL, (const double[]){0.45, 0.2, PI / 2}, e, &err);
    FF_CHECK(e[0] == 0.2 && e[1] == 0.45 && e[2] == 0, "a right angle gives r_xy = 0 exactly: %g %g %g", e[0], e[1], e[2]);
    FF_CHECK(convert("ellipse", "correlated", NULL, (const double[]){0.2, 0.45, 0}, e, &err) == FF_ERR_RANGE, "minor above major");
    FF_CHECK(convert("correlated", "ellipse", NULL, (const double[]){0.2, 0.45, 1}, e, &err) == FF_ERR_RANGE, "r_xy = 1");
    const ff_conversion *c = ff_conversion_at((size_t)ff_conversion_find("correlated", "ellipse", NULL, 0));
    FF_CHECK(ff_conversion_apply(c, (const double[]){0.3, 0.3, 0}, 0, e, &err) == FF_OK && e[2] == 0, "a circle");
    FF_CHECK(ff_conversion_doubt(c, (const double[]){0.3, 0.3, 0}, e) != NULL, "a circle has no direction");
}

/* ---- reflectance and index of refraction ----------------------------------------------------- */

/* Both ways in the precision of long double, from the definition of each. */
static long double reflectance(long double eta, long double k)
{
    return ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
}

static void dielectric_indices(void)
{
    FF_CHECK_CLOSE(convert1("eta", "f0", NULL, 1.5), 0.04, 1e-15, 0);
    FF_CHECK_CLOSE(convert1("eta", "f0", NULL, 1.329), 0.108241 / 5.424241, 1e-15, 0); /* methanol: 0.329^2 / 2.329^2 */
    FF_CHECK_CLOSE(convert1("f0", "eta", NULL, 0.04), 1.5, 1e-15, 0);
    FF_CHECK_CLOSE(convert1("f0", "eta", NULL, 0.25), 3, 1e-15, 0);
    FF_CHECK(convert1("f0", "eta", NULL, 0) == 1 && convert1("eta", "f0", NULL, 1) == 0, "nothing there");
    for (double f0 = 1e-12; f0 < 1 - 1e-12; f0 = f0 < 0.5 ? 1.7 * f0 : (1 + f0) / 2) {
        const double eta = convert1("f0", "eta", NULL, f0);
        FF_CHECK_CLOSE(convert1("eta", "f0", NULL, eta), f0, 4e-16, 4e-16 * sqrt(f0));
        FF_CHECK_CLOSE((double)reflectance(eta, 0), f0, 4e-16, 4e-16 * sqrt(f0));
    }
    refuses("f0", "eta", 1, "[0, 1)");
    refuses("f0", "eta", -0.01, "[0, 1)");
    refuses("eta", "f0", 0.9, "[1, inf)");
    refuses("eta", "f0", 1e300, "outside"); /* rounds to a perfect mirror */
}

static void check_index(double f0, double g)
{
    double index[2], back[2];
    ff_error err = {0};
    FF_CHECK(convert("edge-tint", "conductor", NULL, (const double[]){f0, g}, index, &err) == FF_OK, "%s", err.message);
    const long double a = sqrtl(f0), n_max = (1 + a) * (1 + a) / (1 - (long double)f0),
                      n_min = (1 - (long double)f0) / (1 + (long double)f0);
    FF_CHECK_CLOSE(index[0], (double)(n_max * (1 - (long double)g) + n_min * g), 1e-15, 0);
    const double slack = 8e-16 * sqrt(f0); /* the rounding of an index near 1 */
    FF_CHECK_CLOSE((double)reflectance(index[0], index[1]), f0, 1e-15, slack);
    FF_CHECK(convert("conductor", "edge-tint", NULL, index, back, &err) == FF_OK, "f0 %g g %g: %s", f0, g, err.message);
    FF_CHECK_CLOSE(back[0], f0, 1e-15, slack);
    FF_CHECK_CLOSE(back[1], g, 1e-15, 4e-16 / sqrt(f0));
}

static void metallic_indices(void)
{
    static const double tints[] = {0, 1e-9, 0.1, 0.5, 0.9, 1 - 1e-9, 1};
    for (double f0 = 1e-4; f0 < 1 - 1e-9; f0 = f0 < 0.5 ? 1.9 * f0 : (3 * f0 + 1) / 4 + 1e-10)
        for (size_t i = 0; i < sizeof tints / sizeof tints[0]; i++) check_index(f0, tints[i]);

    double out[2];
    ff_error err = {0};
    /* aluminium at 500 nm, the index that Mikkelsen 2009 uses */
    FF_CHECK(convert("conductor", "edge-tint", NULL, (const double[]){0.769, 6.08}, out, &err) == FF_OK, "%s", err.message);
    FF_CHECK_CLOSE(out[0], 0.923283661, 0, 5e-10);
    const double aluminium[2] = {out[0], out[1]};
    FF_CHECK(convert("edge-tint", "conductor", NULL, aluminium, out, &err) == FF_OK, "%s", err.message);
    FF_CHECK_CLOSE(out[0], 0.769, 1e-14, 0);
    FF_CHECK_CLOSE(out[1], 6.08, 1e-14, 0);
    /* its two ends: a dielectric, and the circle |eta + i k| = 1 */
    convert("edge-tint", "conductor", NULL, (const double[]){0.04, 0}, out, &err);
    FF_CHECK_CLOSE(out[0], 1.5, 1e-15, 0);
    FF_CHECK(out[1] == 0, "no absorption: k = %g", out[1]);
    convert("edge-tint", "conductor", NULL, (const double[]){0.25, 1}, out, &err);
    FF_CHECK_CLOSE(out[0], 0.6, 1e-15, 0);
    FF_CHECK_CLOSE(out[1], 0.8, 1e-15, 0);

    double kept[2] = {4711, 4711};
    FF_CHECK(convert("edge-tint", "conductor", NULL, (const double[]){0.5, 1.01}, kept, &err) == FF_ERR_RANGE, "g above 1");
    FF_CHECK(convert("edge-tint", "conductor", NULL, (const double[]){1, 0.5}, kept, &err) == FF_ERR_RANGE, "a perfect mirror");
    FF_CHECK(convert("conductor", "edge-tint", NULL, (const double[]){0.3, 0.2}, kept, &err) == FF_ERR_RANGE, "inside the circle");
    FF_CHECK(strstr(err.message, "below 1"), "'%s'", err.message);
    FF_CHECK(convert("conductor", "edge-tint", NULL, (const double[]){1, 0}, kept, &err) == FF_ERR_RANGE, "nothing there");
    FF_CHECK(kept[0] == 4711 && kept[1] == 4711, "output written by a refusal");
}

static void tints_at_82_degrees(void)
{
    double there[2], back[2];
    ff_error err = {0};
    convert("f82-tint", "f82", NULL, (const double[]){0, 1}, there, &err);
    FF_CHECK_CLOSE(there[1], 7776.0 / 16807, 1e-15, 0); /* (6/7)^5 */
    for (double f0 = 0; f0 <= 1; f0 += 0.125)
        for (double t = 0; t <= 1; t += 0.25) {
            convert("f82-tint", "f82", NULL, (const double[]){f0, t}, there, &err);
            convert("f82", "f82-tint", NULL, there, back, &err);
            FF_CHECK(back[0] == f0, "f0 %g", back[0]);
            FF_CHECK_CLOSE(back[1], t, 1e-15, 0);
        }
    FF_CHECK(convert("f82-tint", "f82", NULL, (const double[]){1.5, 1}, there, &err) == FF_ERR_RANGE, "f0 above 1");
    const ff_conversion *c = ff_conversion_at((size_t)ff_conversion_find("f82", "f82-tint", NULL, 0));
    const double above[2] = {0.04, 0.9};
    FF_CHECK(ff_conversion_apply(c, above, 0, back, &err) == FF_OK && ff_conversion_doubt(c, above, back) != NULL, "tint %g",
             back[1]);
}

/* ---- metals at two angles -------------------------------------------------------------------- */

/* F in long double, by complex arithmetic from the two amplitudes. */
static double fresnel(double eta, double k, double c)
{
    const double complex m = eta + k * I, t = csqrt(1 - (1 - c * c) / (m * m));
    const double complex rs = (c - m * t) / (c + m * t), rp = (m * c - t) / (m * c + t);
    return (cabs(rs) * cabs(rs) + cabs(rp) * cabs(rp)) / 2;
}

static void two_angles_tell_the_index(void)
{
    double out[2], back[2];
    ff_error err = {0};
    static const double metals[][2] = {{0.769, 6.08}, {0.143, 4.1}, {0.2, 3.0}, {2.9, 3.1}, {1.5, 0}, {1.3, 0.4}};
    for (size_t i = 0; i < sizeof metals / sizeof *metals; i++) {
        FF_CHECK(convert("conductor", "f82", NULL, metals[i], out, &err) == FF_OK, "%s", err.message);
        FF_CHECK_CLOSE(out[0], fresnel(metals[i][0], metals[i][1], 1), 1e-14, 0);
        FF_CHECK_CLOSE(out[1], fresnel(metals[i][0], metals[i][1], 1.0 / 7), 1e-13, 0);
        FF_CHECK(convert("f82", "edge-tint", NULL, out, back, &err) == FF_OK, "%s", err.message);
        FF_CHECK(convert("edge-tint", "conductor", NULL, back, out, &err) == FF_OK, "%s", err.message);
        FF_CHECK_CLOSE(out[0], metals[i][0], 1e-9, 0);
        FF_CHECK_CLOSE(out[1], metals[i][1], 1e-9, 1e-6);
    }
    /* F at 82 degrees rises with g, on which the search for it rests */
    for (double f0 = 1e-3; f0 < 0.995; f0 += 0.02) {
        double before = 0;
        for (int i = 0; i <= 100; i++) {
            convert("edge-tint", "conductor", NULL, (const double[]){f0, i / 100.0}, out, &err);
            const double f = fresnel(out[0], out[1], 1.0 / 7);
            FF_CHECK(f > before, "f0 %g, g %g: %g after %g", f0, i / 100.0, f, before);
            before = f;
        }
    }
    FF_CHECK(convert("f82", "edge-tint", NULL, (const double[]){0.9, 0.6}, out, &err) == FF_ERR_RANGE, "darker than any");
    FF_CHECK(convert("f82", "edge-tint", NULL, (const double[]){0.9, 0.99}, out, &err) == FF_ERR_RANGE, "brighter than any");
}

/* ---- gloss and exponents --------------------------------------------------------------------- */

static void scales_of_renderers(void)
{
    FF_CHECK(convert1("smoothness", "roughness", NULL, 0.75) == 0.25, "1 - smoothness");
    FF_CHECK(convert1("glossiness", "roughness", NULL, 1) == 0, "a mirror");
    FF_CHECK(convert1("gloss-8192", "phong", NULL, 1) == 8192 && convert1("gloss-8192", "phong", NULL, 0) == 1, "its ends");
    FF_CHECK(convert1("gloss-2048", "phong", NULL, 1) == 2048 && convert1("gloss-2048", "phong", NULL, 0) == 2, "its ends");
    FF_CHECK_CLOSE(convert1("phong", "gloss-8192", NULL, 90.50966799187809), 0.5, 1e-15, 0); /* the root of 8192 */
    FF_CHECK(convert1("mirror-phong", "phong", NULL, 10) == 40, "four times");
    FF_CHECK_CLOSE(convert1("specular", "f0", NULL, 0.5), 0.04, 1e-15, 0);
    FF_CHECK_CLOSE(convert1("reflectance", "f0", NULL, 0.5), 0.04, 1e-15, 0);
    refuses("smoothness", "roughness", 1.5, "[0, 1)");
    refuses("phong", "gloss-2048", 1, "below 2");
}

/* E|s| of cos^n by quadrature: the marginal of the slopes is integrated twice, over one axis and the other. */
static void mean_slopes_of_exponents(void)
{
    static const double exponents[] = {0.01, 0.5, 1, 3, 30, 1000, 1e6};
    for (size_t i = 0; i < sizeof exponents / sizeof *exponents; i++) {
        const double n = exponents[i], alpha = convert1("phong", "ggx", "mean-slope", n);
        /* E|s_x| = (2/pi) E|s|, E|s| = integral of (n + 2) cos^n(t) tan(t) sin(t) cos(t) dt = (n + 2) B: D cos and 2 pi sin */
        double radial = 0;
        const int steps = 400000;
        for (int k = 0; k < steps; k++) { /* u = cos(t)^((n+1)), which the integrand falls with */
            const double u = (k + 0.5) / steps, c = pow(u, 1 / (n + 1));
            radial += sqrt((1 - c) * (1 + c)) / (n + 1) / steps * (n + 2);
        }
        FF_CHECK_CLOSE(alpha, radial * 2 / PI, 2e-6, 0);
        FF_CHECK_CLOSE(convert1("phong", "beckmann", "mean-slope", n), sqrt(PI) * alpha, 1e-15, 0);
        FF_CHECK_CLOSE(convert1("ggx", "phong", "mean-slope", alpha), n, 1e-12, 1e-12);
        FF_CHECK_CLOSE(convert1("beckmann", "phong", "mean-slope", sqrt(PI) * alpha), n, 1e-12, 1e-12);
    }
}

/* ---- the nearest lobe ------------------------------------------------------------------------ */

static double lambda(int is_ggx, double alpha, double cosine)
{
    const double t = sqrt((1 - cosine) * (1 + cosine)) / cosine;
    if (is_ggx) return (sqrt(1 + alpha * alpha * t * t) - 1) / 2;
    const double a = 1 / (alpha * t);
    return t > 0 ? (erf(a) - 1) / 2 + exp(-a * a) / (2 * a * sqrt(PI)) : 0;
}

/* f cos(theta_o), written down anew. */
static double lobe(int is_ggx, double alpha, const double wi[3], const double wo[3])
{
    double h[3], length = 0;
    for (int k = 0; k < 3; k++) h[k] = wi[k] + wo[k], length += h[k] * h[k];
    const double z = h[2] / sqrt(length), t2 = (1 - z * z) / (z * z), a2 = alpha * alpha;
    const double d = is_ggx ? 1 / (PI * a2 * pow(z, 4) * (1 + t2 / a2) * (1 + t2 / a2)) : exp(-t2 / a2) / (PI * a2 * pow(z, 4));
    return d / (1 + lambda(is_ggx, alpha, wi[2]) + lambda(is_ggx, alpha, wo[2])) / (4 * wi[2]);
}

/* Squared difference over directions of light, not over half vectors. */
static double difference(double m, double alpha, double theta_i)
{
    const double wi[3] = {sin(theta_i), 0, cos(theta_i)};
    double sum = 0;
    const int polar = 400, turns = 400;
    for (int i = 0; i < polar; i++)
        for (int k = 0; k < turns; k++) {
            const double z = (i + 0.5) / polar, phi = 2 * PI * (k + 0.5) / turns, s = sqrt(1 - z * z);
            const double wo[3] = {s * cos(phi), s * sin(phi), z}, e = lobe(0, m, wi, wo) - lobe(1, alpha, wi, wo);
            sum += e * e;
        }
    return sum * 2 * PI / polar / turns;
}

static void the_nearest_lobe(void)
{
    static const double cases[][2] = {{0.5, 0}, {0.3, 0.8}, {0.7, 1.2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double m = cases[i][0], theta = cases[i][1];
        double alpha;
        ff_error err = {0};
        const ff_conversion *c = ff_conversion_at((size_t)ff_conversion_find("beckmann", "ggx", "lobe", 0));
        FF_CHECK(ff_conversion_apply(c, &m, theta, &alpha, &err) == FF_OK, "%s", err.message);
        /* a parabola through three places has its least at the answer */
        const double h = 0.02 * alpha, d0 = difference(m, alpha - h, theta), d1 = difference(m, alpha, theta),
                     d2 = difference(m, alpha + h, theta), least = h * (d0 - d2) / (2 * (d0 - 2 * d1 + d2));
        FF_CHECK(d1 < d0 && d1 < d2, "m %g at %g: alpha %g is not the least: %g %g %g", m, theta, alpha, d0, d1, d2);
        FF_CHECK_CLOSE(least / alpha, 0, 0, 1e-3);
    }
    double out = 4711;
    ff_error err = {0};
    const ff_conversion *c = ff_conversion_at((size_t)ff_conversion_find("beckmann", "ggx", "lobe", 0));
    FF_CHECK(ff_conversion_apply(c, (const double[]){0.3}, PI / 2, &out, &err) == FF_ERR_RANGE && out == 4711, "grazing");
    FF_CHECK(ff_conversion_apply(c, (const double[]){0.3}, NAN, &out, &err) == FF_ERR_RANGE && out == 4711, "no angle");
    FF_CHECK(ff_conversion_apply(c, (const double[]){30}, 0, &out, &err) == FF_ERR_RANGE && out == 4711, "no model so rough");
    /* there and back: each is the nearest of the other only nearly; of the same kind it would be exact */
    const double n = convert1("beckmann", "phong", "lobe", 0.1);
    FF_CHECK_CLOSE(n, 2 / 0.01 - 2, 0.02, 0); /* the two are alike at this roughness */
}

/* ---- renderers ------------------------------------------------------------------------------- */

/* An ellipse said in every renderer's way and back is the same one; one that is round needs no more than its roughness. */
static void renderers_say_the_same_ellipse(void)
{
    static const char *const names[] = {"disney", "blender-glossy", "gltf", "filament", "openpbr", "standard-surface", "mitsuba"};
    static const double ellipses[][3] = {{0.3, 0.1, 0}, {0.1, 0.3, 0.4}, {0.5, 0.45, -0.7}, {0.2, 0.19, 0.01}};
    ff_error err = {0};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        for (size_t k = 0; k < sizeof ellipses / sizeof *ellipses; k++) {
            double said[3], back[3];
            FF_CHECK(convert("correlated", names[i], NULL, ellipses[k], said, &err) == FF_OK, "%s: %s", names[i], err.message);
            FF_CHECK(convert(names[i], "correlated", NULL, said, back, &err) == FF_OK, "%s: %s", names[i], err.message);
            for (int j = 0; j < 3; j++) FF_CHECK_CLOSE(back[j], ellipses[k][j], 1e-12, 1e-13);
        }
        const ff_conversion *c = ff_conversion_at((size_t)ff_conversion_find(names[i], "correlated", NULL, 0));
        const int is_axes = !strcmp(names[i], "mitsuba");
        FF_CHECK(c->in[2].optional && c->in[2].initial == 0 && (is_axes || c->in[1].optional), "%s", names[i]);
        double round[3];
        FF_CHECK(convert(names[i], "correlated", NULL, (const double[]){is_axes ? 0.25 : 0.5, is_axes ? 0.25 : 0, 0}, round,
                         &err) == FF_OK,
                 "%s", err.message);
        FF_CHECK_CLOSE(round[0], 0.25, 1e-15, 0);
        FF_CHECK_CLOSE(round[1], 0.25, 1e-15, 0);
        FF_CHECK_CLOSE(round[2], 0, 0, 1e-15);
    }
    /* by hand: aspect^2 = 0.55 */
    double out[3];
    convert("disney", "correlated", NULL, (const double[]){0.5, 0.5, 0}, out, &err);
    FF_CHECK_CLOSE(out[0], 0.25 / sqrt(0.55), 1e-15, 0);
    FF_CHECK_CLOSE(out[1], 0.25 * sqrt(0.55), 1e-15, 0);
    FF_CHECK(convert("correlated", "disney", NULL, (const double[]){0.5, 0.01, 0}, out, &err) == FF_ERR_RANGE,
             "flatter than 1 to 10");
    FF_CHECK(!strcmp(ff_conversion_name("blender"), "disney") && !strcmp(ff_conversion_name("arnold"), "standard-surface"),
             "names");
}

/* ---- ways ------------------------------------------------------------------------------------ */

static double along(const char *from, const char *to, const char *by, double x, size_t ways, const char *middle)
{
    ff_conversion_path path[8];
    ff_error err = {0};
    double out[3] = {NAN};
    const size_t n = ff_conversion_paths(from, to, by, 8, path);
    FF_CHECK(n == ways, "%s -> %s: %zu ways", from, to, n);
    if (!n) return NAN;
    FF_CHECK(!middle || (path[0].n > 1 && !strcmp(path[0].step[0]->to, middle)), "%s -> %s goes by %s", from, to,
             path[0].step[0]->to);
    FF_CHECK(ff_conversion_follow(&path[0], &x, PI / 4, out, NULL, &err) == FF_OK, "%s", err.message);
    return out[0];
}

static void ways_between_conventions(void)
{
    FF_CHECK(along("beckmann", "phong", NULL, 0.25, 1, NULL) == 30, "Mikkelsen's, and no other unless it is named");
    FF_CHECK(along("smoothness", "alpha", NULL, 0.5, 1, "roughness") == 0.25, "squared");
    FF_CHECK(along("smoothness", "beckmann", "peak", 0.5, 1, "roughness") == 0.25, "by ggx");
    along("smoothness", "beckmann", NULL, 0.5, 3, "roughness");
    along("smoothness", "rms-slope", NULL, 0.5, 3, "roughness");
    FF_CHECK_CLOSE(along("gloss-8192", "roughness", "peak", 0.5, 1, "phong"), sqrt(sqrt(2 / (90.50966799187809 + 2))), 1e-15, 0);
    FF_CHECK_CLOSE(along("specular", "eta", NULL, 0.5, 1, "f0"), 1.5, 1e-15, 0);
    FF_CHECK_CLOSE(along("eta", "f82", NULL, 1.5, 1, NULL), 0.04, 1e-14, 0);
    FF_CHECK(isnan(along("roughness", "eta", NULL, 0.5, 0, NULL)), "a roughness is no index");
    FF_CHECK(isnan(along("beckmann", "phong", "peak", 0.5, 0, NULL)), "Mikkelsen's rule has no name of a criterion");
    FF_CHECK(isnan(along("roughness", "roughness", NULL, 0.5, 0, NULL)), "nowhere to go");
    ff_conversion_path path;
    double out = 4711;
    ff_error err = {0};
    ff_conversion_paths("smoothness", "phong", "peak", 1, &path);
    FF_CHECK(ff_conversion_follow(&path, (const double[]){0}, 0, &out, NULL, &err) == FF_ERR_RANGE && out == 4711,
             "alpha 1: n = 0");
    const char *doubt = NULL;
    FF_CHECK(ff_conversion_paths("gloss-8192", "beckmann", NULL, 1, &path) == 1, "no way");
    FF_CHECK(ff_conversion_follow(&path, (const double[]){0.2}, 0, &out, &doubt, NULL) == FF_OK && doubt && strstr(doubt, "n <= 8"),
             "8192^0.2 is 6.1: %s", doubt ? doubt : "no doubt");
    FF_CHECK(ff_conversion_follow(&path, (const double[]){0.8}, 0, &out, &doubt, NULL) == FF_OK && !doubt, "%s", doubt);
    FF_CHECK(strstr(err.message, "from ggx to phong"), "'%s' does not say where", err.message);
    FF_CHECK(!strcmp(ff_conversion_name("ior"), "eta") && !strcmp(ff_conversion_name("ggx"), "ggx") && !ff_conversion_name("gxg"),
             "names");
    /* no convention stands alone, and a way there has one back */
    for (size_t i = 0; i < ff_conversion_count(); i++)
        for (size_t k = 0; k < ff_conversion_count(); k++) {
            const char *a = ff_conversion_at(i)->from, *b = ff_conversion_at(k)->to;
            FF_CHECK(!strcmp(a, b) || !ff_conversion_paths(a, b, NULL, 1, &path) == !ff_conversion_paths(b, a, NULL, 1, &path),
                     "%s and %s: one way only", a, b);
        }
}

FF_TEST_MAIN(FF_TEST(by_hand), FF_TEST(criteria_hold), FF_TEST(round_trips), FF_TEST(every_entry_has_its_inverse_and_its_words),
             FF_TEST(what_has_no_answer), FF_TEST(doubts), FF_TEST(ellipse), FF_TEST(dielectric_indices), FF_TEST(metallic_indices),
             FF_TEST(tints_at_82_degrees), FF_TEST(two_angles_tell_the_index), FF_TEST(scales_of_renderers),
             FF_TEST(mean_slopes_of_exponents), FF_TEST(the_nearest_lobe), FF_TEST(renderers_say_the_same_ellipse),
             FF_TEST(ways_between_conventions))
