/* Roughness along two axes with a correlation, and the ellipse that it is. */
#include "internal_conversions.h"
#include <float.h>
#include <math.h>

/* Axes of the ellipse whose matrix is [[ax^2, r ax ay], [r ax ay, ay^2]]. The difference of the diagonal is factored, and the
 * minor axis comes from the determinant, so that neither ax ~ ay nor |r| -> 1 loses digits. */
static const char *correlated_to_ellipse(const double *in, double *out)
{
    const double scale = ldexp(1, ilogb(fmax(in[0], in[1]))); /* a power of two: ax - ay keeps every digit */
    const double ax = in[0] / scale, ay = in[1] / scale, r = in[2];
    const double half_difference = (ax - ay) * (ax + ay) / 2, off = r * ax * ay;
    const double major = sqrt((ax * ax + ay * ay) / 2 + hypot(half_difference, off));
    double phi = atan2(off, half_difference) / 2; /* (-pi/2, pi/2] */
    if (phi < 0) phi += FF_CONVERSION_PI;
    out[0] = scale * major;
    out[1] = fmin(scale * (ax * ay * sqrt((1 - r) * (1 + r)) / major), out[0]); /* a circle's axes may differ by a rounding */
    out[2] = phi < FF_CONVERSION_PI ? phi : 0; /* a tiny negative angle rounds up to pi, which is 0 */
    return NULL;
}

static const char *doubt_circle(const double *in, const double *out)
{
    (void)in;
    return out[0] - out[1] <= 4 * DBL_EPSILON * out[0] ? "the two axes are equal: phi has no meaning and is reported as 0" : NULL;
}

/* A cosine within a rounding of 0 belongs to a right angle that pi cannot express exactly. */
static double snap(double c)
{
    return fabs(c) <= DBL_EPSILON ? 0 : c;
}

static const char *ellipse_to_correlated(const double *in, double *out)
{
    const double a1 = in[0], a2 = in[1], c = snap(cos(in[2])), s = snap(sin(in[2]));
    if (a2 > a1) return "alpha_minor must not exceed alpha_major";
    const double ax = hypot(a1 * c, a2 * s), ay = hypot(a1 * s, a2 * c);
    const double r = (a1 - a2) / ax * ((a1 + a2) / ay) * s * c;
    if (!(fabs(r) < 1)) return "the ellipse is so thin that r_xy rounds to 1, and r_xy must lie in (-1, 1)";
    out[0] = ax;
    out[1] = ay;
    out[2] = r + 0.0; /* no negative zero */
    return NULL;
}

/* A circle is its radius. */
static const char *circle(const double *in, double *out)
{
    out[0] = out[1] = in[0];
    out[2] = 0;
    return NULL;
}

/* alpha_x alpha_y sqrt(1 - r^2) is what the peak of D depends on. */
static const char *mean_axis(const double *in, double *out)
{
    if (in[1] > in[0]) return "alpha_minor must not exceed alpha_major";
    out[0] = sqrt(in[0]) * sqrt(in[1]);
    return NULL;
}

static const char *doubt_one_axis(const double *in, const double *out)
{
    (void)out;
    return in[0] - in[1] > 0.01 * in[0] ? "the surface has a direction, which one roughness does not" : NULL;
}

static const char eigen[] = "Heitz 2014 (RR-8468), section 3.4: eigen-decomposition of [[alpha_x^2, r_xy alpha_x alpha_y], [r_xy "
                            "alpha_x alpha_y, alpha_y^2]]";
static const char eigen_assumes[] = "a shape-invariant distribution; phi from the tangent x, counter-clockwise, in half turns";
static const char eigen_limits[] =
    "exact; phi has no meaning where the two axes are equal. Grooves run across the major axis: along them the surface is smoother";

static const ff_conversion ellipse[] = {
    {.from = "correlated",
     .to = "ellipse",
     .by = "",
     .formula = "alpha_major^2, alpha_minor^2 and phi: eigenvalues and first eigenvector",
     .source = eigen,
     .assumes = eigen_assumes,
     .limits = eigen_limits,
     .n_in = 3,
     .n_out = 3,
     .in = {V_POSITIVE("alpha_x"), V_POSITIVE("alpha_y"), V_R},
     .out = {V_POSITIVE("alpha_major"), V_POSITIVE("alpha_minor"), V_PHI},
     .apply = correlated_to_ellipse,
     .doubt = doubt_circle},
    {.from = "ellipse",
     .to = "correlated",
     .by = "",
     .formula = "alpha_x^2, alpha_y^2 and r_xy alpha_x alpha_y: entries of the matrix of the ellipse",
     .source = eigen,
     .assumes = eigen_assumes,
     .limits = eigen_limits,
     .n_in = 3,
     .n_out = 3,
     .in = {V_POSITIVE("alpha_major"), V_POSITIVE("alpha_minor"), V_PHI},
     .out = {V_POSITIVE("alpha_x"), V_POSITIVE("alpha_y"), V_R},
     .apply = ellipse_to_correlated},
    {.from = "alpha",
     .to = "ellipse",
     .by = "",
     .formula = "alpha_major = alpha_minor = alpha, phi = 0",
     .source = "a circle",
     .assumes = "a surface without a direction",
     .limits = "exact",
     .n_in = 1,
     .n_out = 3,
     .in = {V_FROM("alpha", 0)},
     .out = {V_POSITIVE("alpha_major"), V_POSITIVE("alpha_minor"), V_PHI},
     .apply = circle},
    {.from = "ellipse",
     .to = "alpha",
     .by = "",
     .formula = "alpha = sqrt(alpha_major alpha_minor)",
     .source = "peak of a shape-invariant distribution: D(z) = P(0)/(alpha_x alpha_y sqrt(1 - r_xy^2))",
     .assumes = "equal peak D(z)",
     .limits = "exact for a surface without a direction; the direction is lost",
     .matches = 1,
     .n_in = 3,
     .n_out = 1,
     .in = {V_POSITIVE("alpha_major"), V_POSITIVE("alpha_minor"), V_PHI},
     .out = {V_FROM("alpha", 0)},
     .apply = mean_axis,
     .doubt = doubt_one_axis},
};

FF_CONVERSION_GROUP(ellipse, ellipse);
