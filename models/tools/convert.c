/* Conversions between conventions of roughness and of reflectance. A new one is a function and a line of the table at the end.
 *
 *   m       Beckmann's roughness (his alpha)     sqrt(2) times the rms slope along one axis
 *   n       exponent of cos^n
 *   alpha   roughness of the slope distribution, as everywhere in the project
 *   sigma   rms slope along one axis
 *   f0      reflectance at normal incidence
 *   eta, k  index of refraction eta + i k over that of the medium outside
 *   g       edge tint of Gulbrandsen 2014
 *   f82     reflectance at cos = 1/7, about 82 degrees
 */
#include "ff_convert.h"
#include <float.h>
#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

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

/* ---- beckmann and ggx ------------------------------------------------------------------------ */

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

static const char *same(const double *in, double *out)
{
    out[0] = in[0];
    return NULL;
}

/* ---- roughness of renderers, rms slope ------------------------------------------------------- */

static const char *square(const double *in, double *out)
{
    out[0] = in[0] * in[0];
    return NULL;
}

static const char *square_root(const double *in, double *out)
{
    out[0] = sqrt(in[0]);
    return NULL;
}

static const char *doubt_roughness(const double *in, const double *out)
{
    (void)out;
    if (in[0] > 1) return "above 1: the roughness of most renderers ends at 1";
    return in[0] > 0 ? NULL : "0 is a perfect mirror, which no slope distribution describes";
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

/* ---- correlated roughness and its ellipse ---------------------------------------------------- */

/* Axes of the ellipse whose matrix is [[ax^2, r ax ay], [r ax ay, ay^2]]. The difference of the diagonal is factored, and the
 * minor axis comes from the determinant, so that neither ax ~ ay nor |r| -> 1 loses digits. */
static const char *correlated_to_ellipse(const double *in, double *out)
{
    const double scale = ldexp(1, ilogb(fmax(in[0], in[1]))); /* a power of two: ax - ay keeps every digit */
    const double ax = in[0] / scale, ay = in[1] / scale, r = in[2];
    const double half_difference = (ax - ay) * (ax + ay) / 2, off = r * ax * ay;
    const double major = sqrt((ax * ax + ay * ay) / 2 + hypot(half_difference, off));
    double phi = atan2(off, half_difference) / 2; /* (-pi/2, pi/2] */
    if (phi < 0) phi += PI;
    out[0] = scale * major;
    out[1] = fmin(scale * (ax * ay * sqrt((1 - r) * (1 + r)) / major), out[0]); /* a circle's axes may differ by a rounding */
    out[2] = phi < PI ? phi : 0; /* a tiny negative angle rounds up to pi, which is 0 */
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

/* ---- reflectance and index of refraction ----------------------------------------------------- */

static const char *f0_to_eta(const double *in, double *out)
{
    const double root = sqrt(in[0]);
    out[0] = (1 + root) * (1 + root) / (1 - in[0]); /* (1 + root) / (1 - root) */
    return NULL;
}

static const char *eta_to_f0(const double *in, double *out)
{
    const double root = (in[0] - 1) / (in[0] + 1);
    out[0] = root * root;
    return NULL;
}

/* Gulbrandsen's eq. with a = sqrt(f0): n_max = (1 + a)/(1 - a), n_min = (1 - a^2)/(1 + a^2), eta = n_max (1 - g) + n_min g, and
 * k^2 = (n_max - eta)(eta - 1/n_max), the circle of the indices with this f0, here without a difference of like terms. */
static const char *edge_tint_to_conductor(const double *in, double *out)
{
    const double a = sqrt(in[0]), g = in[1], one_less = (1 - in[0]) / (1 + a); /* 1 - a */
    if (g > 1) return "the edge tint g must not exceed 1";
    const double n_max = (1 + a) / one_less, n_min = (1 - in[0]) / (1 + in[0]);
    out[0] = n_max * (1 - g) + n_min * g;
    out[1] = 2 * a / (one_less * (1 + in[0])) * sqrt(g * (one_less * one_less + (1 - g) * (1 + a) * (1 + a)));
    return NULL;
}

/* On the circle n_max - eta = k^2/(eta - 1/n_max) and eta - n_min = n_min (eta^2 + k^2 - 1)/2: g is the first over their sum. */
static const char *conductor_to_edge_tint(const double *in, double *out)
{
    const double eta = in[0], k2 = in[1] * in[1], whole = (eta + 1) * (eta + 1) + k2;
    const double beyond = (eta - 1) * (eta + 1) + k2; /* eta^2 + k^2 - 1 */
    if (eta == 1 && k2 == 0) return "eta = 1 with k = 0 reflects nothing: no edge tint belongs to it";
    if (beyond < -4 * DBL_EPSILON) return "eta^2 + k^2 is below 1: no edge tint in [0, 1] belongs to such an index";
    const double f0 = ((eta - 1) * (eta - 1) + k2) / whole, a = sqrt(f0), one_less_f0 = 4 * eta / whole;
    const double to_max = k2 / (eta - one_less_f0 / ((1 + a) * (1 + a))), to_min = one_less_f0 / (1 + f0) * fmax(beyond, 0) / 2;
    out[0] = f0;
    out[1] = k2 > 0 ? to_max / (to_max + to_min) : 0;
    return NULL;
}

/* Schlick's F at cos = 1/7, where the correction of schlick-f82 is largest. */
static double schlick_at_82(double f0)
{
    const double m = 6.0 / 7, m5 = m * m * m * m * m;
    return f0 + (1 - f0) * m5;
}

static const char *f82_tint_to_f82(const double *in, double *out)
{
    if (in[0] > 1) return "f0 must not exceed 1";
    out[0] = in[1] * schlick_at_82(in[0]);
    return NULL;
}

static const char *f82_to_f82_tint(const double *in, double *out)
{
    if (in[0] > 1) return "f0 must not exceed 1";
    out[0] = in[1] / schlick_at_82(in[0]);
    return NULL;
}

static const char tint_above_1[] = "a tint above 1: F then rises above Schlick's curve and may exceed 1";

static const char *doubt_tint_in(const double *in, const double *out)
{
    (void)out;
    return in[1] > 1 ? tint_above_1 : NULL;
}

static const char *doubt_tint_out(const double *in, const double *out)
{
    (void)in;
    return out[0] > 1 ? tint_above_1 : NULL;
}

/* ---- the table ------------------------------------------------------------------------------- */

/* clang-format off */
#define V_M(hi)       {"m", "alpha", "1", 0, hi, 0}
#define V_N(lo)       {"n", NULL, "1", lo, INFINITY, 0}
#define V_ALPHA       {"alpha", NULL, "1", 0, INFINITY, 0}
#define V_POSITIVE(n) {n, NULL, "1", 0, INFINITY, 0}
#define V_R           {"r_xy", NULL, "1", -1, 1, 0}
#define V_PHI         {"phi", NULL, "rad", -INFINITY, INFINITY, 0}
#define V_F0          {"f0", NULL, "1", 0, 1, 1}
#define V_FROM(n, lo) {n, NULL, "1", lo, INFINITY, 1}
/* clang-format on */

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
static const char peak[] = "equal peak D(z)";
static const char peak_limits[] = "ggx then looks rougher, for its tail has infinite slope variance: fit instead where data exist";
static const char burley[] = "Burley 2012, section 5.4";
static const char burley_assumes[] = "the renderer squares its roughness (Disney, UE4, glTF, Filament); some take alpha itself";
static const char burley_limits[] = "exact for 0 < roughness <= 1";
static const char rms[] = "Heitz 2014 (RR-8468), section 3.4: covariance Q^-1 / 2";
static const char rms_assumes[] = "Gaussian slopes; sigma is the rms slope along one axis, not over both";
static const char exact[] = "exact";
static const char eigen[] = "Heitz 2014 (RR-8468), section 3.4: eigen-decomposition of [[alpha_x^2, r_xy alpha_x alpha_y], [r_xy "
                            "alpha_x alpha_y, alpha_y^2]]";
static const char eigen_assumes[] = "a shape-invariant distribution; phi from the tangent x, counter-clockwise, in half turns";
static const char eigen_limits[] = "exact; phi has no meaning where the two axes are equal";

static const char fresnel[] = "Fresnel's equations at normal incidence";
static const char dielectric[] = "no absorption, and light that comes from the rarer medium (eta >= 1)";
static const char gulbrandsen[] = "Gulbrandsen 2014, Artist Friendly Metallic Fresnel";
static const char gulbrandsen_assumes[] = "a medium with the index eta + i k below one with the index 1";
static const char gulbrandsen_limits[] =
    "exact for f0 in (0, 1) and g in [0, 1], that is eta^2 + k^2 >= 1; g = 0 is the dielectric, g = 1 has eta^2 + k^2 = 1";
static const char kutz[] = "Kutz et al. 2021 (Adobe Standard Material)";
static const char kutz_assumes[] = "the renderer gives the reflectance at 82 degrees as a fraction of Schlick's value there";
static const char kutz_limits[] = "exact for tint in [0, 1]; f82 = schlick at that angle is schlick itself";

static const ff_conversion conversions[] = {
    {"beckmann", "phong", "", "n = 2/m^2 - 2", mikkelsen, alike, above_8, 1, 1, {V_M(1)}, {V_N(0)}, beckmann_to_phong, doubt_n_out},
    {"phong",
     "beckmann",
     "",
     "m = sqrt(2/(n + 2))",
     mikkelsen,
     alike,
     above_8,
     1,
     1,
     {V_N(0)},
     {V_M(1)},
     phong_to_beckmann,
     doubt_n_in},
    {"beckmann",
     "ggx",
     "mean-slope",
     "alpha_ggx = m/sqrt(pi)",
     slopes,
     mean_slope,
     mean_limits,
     1,
     1,
     {V_M(INFINITY)},
     {V_ALPHA},
     divide_by_sqrt_pi,
     NULL},
    {"beckmann", "ggx", "peak", "alpha_ggx = m", slopes, peak, peak_limits, 1, 1, {V_M(INFINITY)}, {V_ALPHA}, same, NULL},
    {"ggx",
     "beckmann",
     "mean-slope",
     "m = sqrt(pi) alpha_ggx",
     slopes,
     mean_slope,
     mean_limits,
     1,
     1,
     {V_ALPHA},
     {V_M(INFINITY)},
     times_sqrt_pi,
     NULL},
    {"ggx", "beckmann", "peak", "m = alpha_ggx", slopes, peak, peak_limits, 1, 1, {V_ALPHA}, {V_M(INFINITY)}, same, NULL},
    {"roughness",
     "alpha",
     "",
     "alpha = roughness^2",
     burley,
     burley_assumes,
     burley_limits,
     1,
     1,
     {V_FROM("roughness", 0)},
     {V_FROM("alpha", 0)},
     square,
     doubt_roughness},
    {"alpha",
     "roughness",
     "",
     "roughness = sqrt(alpha)",
     burley,
     burley_assumes,
     burley_limits,
     1,
     1,
     {V_FROM("alpha", 0)},
     {V_FROM("roughness", 0)},
     square_root,
     doubt_roughness},
    {"kelemen-ward",
     "kelemen-phong",
     "",
     "n = 2/m^2 - 1",
     kelemen,
     kelemen_assumes,
     kelemen_limits,
     1,
     1,
     {V_M(1.4142135623730950488)},
     {V_N(0)},
     kelemen_ward_to_phong,
     doubt_n_out},
    {"kelemen-phong",
     "kelemen-ward",
     "",
     "m = sqrt(2/(n + 1))",
     kelemen,
     kelemen_assumes,
     kelemen_limits,
     1,
     1,
     {V_N(-1)},
     {V_M(INFINITY)},
     kelemen_phong_to_ward,
     doubt_n_in},
    {"beckmann",
     "rms-slope",
     "",
     "sigma = m/sqrt(2)",
     rms,
     rms_assumes,
     exact,
     1,
     1,
     {V_M(INFINITY)},
     {V_POSITIVE("sigma")},
     divide_by_sqrt_2,
     NULL},
    {"rms-slope",
     "beckmann",
     "",
     "m = sqrt(2) sigma",
     rms,
     rms_assumes,
     exact,
     1,
     1,
     {V_POSITIVE("sigma")},
     {V_M(INFINITY)},
     times_sqrt_2,
     NULL},
    {"correlated",
     "ellipse",
     "",
     "alpha_major^2, alpha_minor^2 and phi: eigenvalues and first eigenvector",
     eigen,
     eigen_assumes,
     eigen_limits,
     3,
     3,
     {V_POSITIVE("alpha_x"), V_POSITIVE("alpha_y"), V_R},
     {V_POSITIVE("alpha_major"), V_POSITIVE("alpha_minor"), V_PHI},
     correlated_to_ellipse,
     doubt_circle},
    {"ellipse",
     "correlated",
     "",
     "alpha_x^2, alpha_y^2 and r_xy alpha_x alpha_y: entries of the matrix of the ellipse",
     eigen,
     eigen_assumes,
     eigen_limits,
     3,
     3,
     {V_POSITIVE("alpha_major"), V_POSITIVE("alpha_minor"), V_PHI},
     {V_POSITIVE("alpha_x"), V_POSITIVE("alpha_y"), V_R},
     ellipse_to_correlated,
     NULL},
    {"f0",
     "eta",
     "",
     "eta = (1 + sqrt(f0))/(1 - sqrt(f0))",
     fresnel,
     dielectric,
     exact,
     1,
     1,
     {V_F0},
     {V_FROM("eta", 1)},
     f0_to_eta,
     NULL},
    {"eta",
     "f0",
     "",
     "f0 = ((eta - 1)/(eta + 1))^2",
     fresnel,
     dielectric,
     exact,
     1,
     1,
     {V_FROM("eta", 1)},
     {V_F0},
     eta_to_f0,
     NULL},
    {"edge-tint",
     "conductor",
     "",
     "eta = g (1 - f0)/(1 + f0) + (1 - g) (1 + sqrt(f0))/(1 - sqrt(f0)), k^2 = (f0 (eta + 1)^2 - (eta - 1)^2)/(1 - f0)",
     gulbrandsen,
     gulbrandsen_assumes,
     gulbrandsen_limits,
     2,
     2,
     {V_F0, V_FROM("g", 0)},
     {V_POSITIVE("eta"), V_FROM("k", 0)},
     edge_tint_to_conductor,
     NULL},
    {"conductor",
     "edge-tint",
     "",
     "f0 = ((eta - 1)^2 + k^2)/((eta + 1)^2 + k^2), g = (n_max - eta)/(n_max - n_min)",
     gulbrandsen,
     gulbrandsen_assumes,
     gulbrandsen_limits,
     2,
     2,
     {V_POSITIVE("eta"), V_FROM("k", 0)},
     {V_F0, V_FROM("g", 0)},
     conductor_to_edge_tint,
     NULL},
    {"f82-tint",
     "f82",
     "",
     "f82 = tint (f0 + (1 - f0)(6/7)^5)",
     kutz,
     kutz_assumes,
     kutz_limits,
     2,
     1,
     {V_FROM("f0", 0), V_FROM("tint", 0)},
     {V_FROM("f82", 0)},
     f82_tint_to_f82,
     doubt_tint_in},
    {"f82",
     "f82-tint",
     "",
     "tint = f82/(f0 + (1 - f0)(6/7)^5)",
     kutz,
     kutz_assumes,
     kutz_limits,
     2,
     1,
     {V_FROM("f0", 0), V_FROM("f82", 0)},
     {V_FROM("tint", 0)},
     f82_to_f82_tint,
     doubt_tint_out},
};

size_t ff_conversion_count(void)
{
    return sizeof conversions / sizeof conversions[0];
}

const ff_conversion *ff_conversion_at(size_t i)
{
    return i < ff_conversion_count() ? &conversions[i] : NULL;
}

int ff_conversion_find(const char *from, const char *to, const char *by, size_t start)
{
    for (size_t i = start; i < ff_conversion_count(); i++) {
        const ff_conversion *c = &conversions[i];
        if (!strcmp(c->from, from) && !strcmp(c->to, to) && (!by || !strcmp(c->by, by))) return (int)i;
    }
    return -1;
}

static int inside(const ff_conversion_value *v, double x)
{
    return isfinite(x) && x < v->hi && (x > v->lo || (v->lo_included && x >= v->lo));
}

/* Says what the formula would give for an argument that it can be computed for, since that is the reason of the refusal. */
static ff_status refuse(const ff_conversion *c, const ff_conversion_value *v, double x, const double *in, ff_error *err)
{
    double would[FF_CONVERSION_VALUES] = {0};
    const char open = v->lo_included ? '[' : '(';
    if (c->n_in == 1 && isfinite(x) && x >= v->hi && !c->apply(in, would))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g: %s would give %s = %g; %s must lie in %c%g, %g)", v->name, x,
                            c->formula, c->out[0].name, would[0], v->name, open, v->lo, v->hi);
    return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g: must be a number in %c%g, %g) for %s", v->name, x, open, v->lo,
                        v->hi, c->formula);
}

ff_status ff_conversion_apply(const ff_conversion *c, const double *in, double *out, ff_error *err)
{
    double result[FF_CONVERSION_VALUES] = {0};
    for (uint32_t k = 0; k < c->n_in; k++)
        if (!inside(&c->in[k], in[k])) return refuse(c, &c->in[k], in[k], in, err);
    const char *reason = c->apply(in, result);
    if (reason) return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s", reason);
    for (uint32_t k = 0; k < c->n_out; k++)
        if (!inside(&c->out[k], result[k]))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s = %g is outside %c%g, %g): %s has no usable answer here",
                                c->out[k].name, result[k], c->out[k].lo_included ? '[' : '(', c->out[k].lo, c->out[k].hi,
                                c->formula);
    memcpy(out, result, c->n_out * sizeof *out);
    return FF_OK;
}

const char *ff_conversion_doubt(const ff_conversion *c, const double *in, const double *out)
{
    return c->doubt ? c->doubt(in, out) : NULL;
}
