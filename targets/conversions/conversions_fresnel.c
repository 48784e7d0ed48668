/* Reflectance at normal incidence, indices of refraction, and the numbers that renderers have in their place.
 *
 *   f0      reflectance at normal incidence
 *   eta, k  index of refraction eta + i k over that of the medium outside
 *   g       edge tint of Gulbrandsen 2014
 *   f82     reflectance at cos = 1/7, about 82 degrees
 */
#include "internal_conversions.h"
#include <float.h>
#include <math.h>

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
    out[0] = in[0];
    out[1] = in[1] * schlick_at_82(in[0]);
    return NULL;
}

static const char *f82_to_f82_tint(const double *in, double *out)
{
    if (in[0] > 1) return "f0 must not exceed 1";
    out[0] = in[0];
    out[1] = in[1] / schlick_at_82(in[0]);
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
    return out[1] > 1 ? tint_above_1 : NULL;
}

/* ---- what renderers have in their place ------------------------------------------------------ */

static const char *specular_to_f0(const double *in, double *out)
{
    out[0] = 0.08 * in[0];
    return NULL;
}

static const char *f0_to_specular(const double *in, double *out)
{
    out[0] = in[0] / 0.08;
    return NULL;
}

static const char *reflectance_to_f0(const double *in, double *out)
{
    out[0] = 0.16 * in[0] * in[0];
    return NULL;
}

static const char *f0_to_reflectance(const double *in, double *out)
{
    out[0] = sqrt(in[0] / 0.16);
    return NULL;
}

static const char above_1[] = "above 1: most renderers end the slider there";

static const char *doubt_slider_in(const double *in, const double *out)
{
    (void)out;
    return in[0] > 1 ? above_1 : NULL;
}

static const char *doubt_slider_out(const double *in, const double *out)
{
    (void)in;
    return out[0] > 1 ? above_1 : NULL;
}

/* ---- metals ---------------------------------------------------------------------------------- */

/* F of eta + i k at the cosine c of the angle of incidence: the mean of both polarisations. */
static double fresnel_at(double eta, double k, double c)
{
    const double s2 = (1 - c) * (1 + c), t0 = eta * eta - k * k - s2, both = hypot(t0, 2 * eta * k);
    const double a2 = fmax((both + t0) / 2, 0), a = sqrt(a2);
    const double rs = (both + c * c - 2 * a * c) / (both + c * c + 2 * a * c);
    return rs / 2 * (1 + (both * c * c + s2 * s2 - 2 * a * c * s2) / (both * c * c + s2 * s2 + 2 * a * c * s2));
}

static const char *conductor_to_f0(const double *in, double *out)
{
    const double k2 = in[1] * in[1];
    out[0] = ((in[0] - 1) * (in[0] - 1) + k2) / ((in[0] + 1) * (in[0] + 1) + k2);
    return NULL;
}

static const char *eta_to_conductor(const double *in, double *out)
{
    out[0] = in[0];
    out[1] = 0;
    return NULL;
}

static const char *conductor_to_f82(const double *in, double *out)
{
    conductor_to_f0(in, out);
    out[1] = fresnel_at(in[0], in[1], 1.0 / 7);
    return NULL;
}

/* Of the indices with this f0, that which reflects f82 there: F at 82 degrees rises with g all the way from the dielectric, g = 0,
 * to the circle |eta + i k| = 1, g = 1. */
static const char *f82_to_edge_tint(const double *in, double *out)
{
    double lo = 0, hi = 1, index[2];
    if (!(in[0] < 1)) return "f0 must be below 1";
    for (int end = 0; end < 2; end++) {
        const double at[2] = {in[0], end};
        edge_tint_to_conductor(at, index);
        const double f = fresnel_at(index[0], index[1], 1.0 / 7), slack = 1e-12;
        if (end ? in[1] > f + slack : in[1] < f - slack)
            return end ? "no index with this f0 reflects as much at 82 degrees"
                       : "no index with this f0 reflects as little at 82 degrees: a dielectric reflects more";
    }
    while (hi - lo > 2e-16) {
        const double g = (lo + hi) / 2, at[2] = {in[0], g};
        if (g <= lo || g >= hi) break;
        edge_tint_to_conductor(at, index);
        if (fresnel_at(index[0], index[1], 1.0 / 7) < in[1])
            lo = g;
        else
            hi = g;
    }
    out[0] = in[0];
    out[1] = (lo + hi) / 2;
    return NULL;
}

/* Schlick's curve has a value at 82 degrees too. */
static const char *f0_to_f82(const double *in, double *out)
{
    out[0] = in[0];
    out[1] = schlick_at_82(in[0]);
    return NULL;
}

static const char *first(const double *in, double *out)
{
    if (!(in[0] < 1)) return "f0 must be below 1";
    out[0] = in[0];
    return NULL;
}

/* ---- the table ------------------------------------------------------------------------------- */

static const char fresnel[] = "Fresnel's equations at normal incidence";
static const char dielectric[] = "no absorption, and light that comes from the rarer medium (eta >= 1)";
static const char gulbrandsen[] = "Gulbrandsen 2014, Artist Friendly Metallic Fresnel";
static const char gulbrandsen_assumes[] = "a medium with the index eta + i k below one with the index 1";
static const char gulbrandsen_limits[] =
    "exact for f0 in (0, 1) and g in [0, 1], that is eta^2 + k^2 >= 1; g = 0 is the dielectric, g = 1 has eta^2 + k^2 = 1";
static const char kutz[] = "Kutz et al. 2021 (Adobe Standard Material)";
static const char kutz_assumes[] = "the renderer gives the reflectance at 82 degrees as a fraction of Schlick's value there";
static const char kutz_limits[] = "exact for tint in [0, 1]; f82 = schlick at that angle is schlick itself";
static const char burley[] = "Burley 2012, section 5.5";
static const char burley_assumes[] = "the renderer's 0 to 1 are reflectances of 0 to 8 % (Disney, Blender before 4, Unreal)";
static const char lagarde[] = "Lagarde and de Rousiers 2014, section 3.1.3";
static const char lagarde_assumes[] = "the renderer's 0 to 1 are reflectances of 0 to 16 %, quadratically (Frostbite, Filament)";
static const char exact[] = "exact";
static const char slider[] = "exact; above 1 most renderers have no number";
static const char at_82[] = "equal at normal incidence and at 82 degrees (cos = 1/7)";

static const ff_conversion fresnels[] = {
    {.from = "f0",
     .to = "eta",
     .by = "",
     .formula = "eta = (1 + sqrt(f0))/(1 - sqrt(f0))",
     .source = fresnel,
     .assumes = dielectric,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_F0},
     .out = {V_ETA(1, 1)},
     .apply = f0_to_eta},
    {.from = "eta",
     .to = "f0",
     .by = "",
     .formula = "f0 = ((eta - 1)/(eta + 1))^2",
     .source = fresnel,
     .assumes = dielectric,
     .limits = exact,
     .n_in = 1,
     .n_out = 1,
     .in = {V_ETA(1, 1)},
     .out = {V_F0},
     .apply = eta_to_f0},
    {.from = "specular",
     .to = "f0",
     .by = "",
     .formula = "f0 = 0.08 specular",
     .source = burley,
     .assumes = burley_assumes,
     .limits = slider,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("specular", 0)},
     .out = {V_F0},
     .apply = specular_to_f0,
     .doubt = doubt_slider_in},
    {.from = "f0",
     .to = "specular",
     .by = "",
     .formula = "specular = f0/0.08",
     .source = burley,
     .assumes = burley_assumes,
     .limits = slider,
     .n_in = 1,
     .n_out = 1,
     .in = {V_F0},
     .out = {V_FROM("specular", 0)},
     .apply = f0_to_specular,
     .doubt = doubt_slider_out},
    {.from = "reflectance",
     .to = "f0",
     .by = "",
     .formula = "f0 = 0.16 reflectance^2",
     .source = lagarde,
     .assumes = lagarde_assumes,
     .limits = slider,
     .n_in = 1,
     .n_out = 1,
     .in = {V_FROM("reflectance", 0)},
     .out = {V_F0},
     .apply = reflectance_to_f0,
     .doubt = doubt_slider_in},
    {.from = "f0",
     .to = "reflectance",
     .by = "",
     .formula = "reflectance = sqrt(f0/0.16)",
     .source = lagarde,
     .assumes = lagarde_assumes,
     .limits = slider,
     .n_in = 1,
     .n_out = 1,
     .in = {V_F0},
     .out = {V_FROM("reflectance", 0)},
     .apply = f0_to_reflectance,
     .doubt = doubt_slider_out},
    {.from = "eta",
     .to = "conductor",
     .by = "",
     .formula = "k = 0",
     .source = fresnel,
     .assumes = dielectric,
     .limits = exact,
     .n_in = 1,
     .n_out = 2,
     .in = {V_ETA(1, 1)},
     .out = {V_ETA(0, 0), V_FROM("k", 0)},
     .apply = eta_to_conductor},
    {.from = "conductor",
     .to = "f0",
     .by = "",
     .formula = "f0 = ((eta - 1)^2 + k^2)/((eta + 1)^2 + k^2)",
     .source = fresnel,
     .assumes = gulbrandsen_assumes,
     .limits = "exact; what happens at other angles is lost",
     .matches = 1,
     .n_in = 2,
     .n_out = 1,
     .in = {V_ETA(0, 0), V_FROM("k", 0)},
     .out = {V_F0},
     .apply = conductor_to_f0},
    {.from = "edge-tint",
     .to = "conductor",
     .by = "",
     .formula = "eta = g (1 - f0)/(1 + f0) + (1 - g) (1 + sqrt(f0))/(1 - sqrt(f0)), k^2 = (f0 (eta + 1)^2 - (eta - 1)^2)/(1 - f0)",
     .source = gulbrandsen,
     .assumes = gulbrandsen_assumes,
     .limits = gulbrandsen_limits,
     .n_in = 2,
     .n_out = 2,
     .in = {V_F0, V_FROM("g", 0)},
     .out = {V_ETA(0, 0), V_FROM("k", 0)},
     .apply = edge_tint_to_conductor},
    {.from = "conductor",
     .to = "edge-tint",
     .by = "",
     .formula = "f0 = ((eta - 1)^2 + k^2)/((eta + 1)^2 + k^2), g = (n_max - eta)/(n_max - n_min)",
     .source = gulbrandsen,
     .assumes = gulbrandsen_assumes,
     .limits = gulbrandsen_limits,
     .n_in = 2,
     .n_out = 2,
     .in = {V_ETA(0, 0), V_FROM("k", 0)},
     .out = {V_F0, V_FROM("g", 0)},
     .apply = conductor_to_edge_tint},
    {.from = "f82-tint",
     .to = "f82",
     .by = "",
     .formula = "f82 = tint (f0 + (1 - f0)(6/7)^5)",
     .source = kutz,
     .assumes = kutz_assumes,
     .limits = kutz_limits,
     .n_in = 2,
     .n_out = 2,
     .in = {V_FROM("f0", 0), V_FROM("tint", 0)},
     .out = {V_FROM("f0", 0), V_FROM("f82", 0)},
     .apply = f82_tint_to_f82,
     .doubt = doubt_tint_in},
    {.from = "f82",
     .to = "f82-tint",
     .by = "",
     .formula = "tint = f82/(f0 + (1 - f0)(6/7)^5)",
     .source = kutz,
     .assumes = kutz_assumes,
     .limits = kutz_limits,
     .n_in = 2,
     .n_out = 2,
     .in = {V_FROM("f0", 0), V_FROM("f82", 0)},
     .out = {V_FROM("f0", 0), V_FROM("tint", 0)},
     .apply = f82_to_f82_tint,
     .doubt = doubt_tint_out},
    {.from = "conductor",
     .to = "f82",
     .by = "",
     .formula = "f0 and f82 are F at cos = 1 and at cos = 1/7",
     .source = "Fresnel's equations",
     .assumes = at_82,
     .limits = "exact at these two angles; in between schlick-f82 follows the metal nearly",
     .matches = 1,
     .n_in = 2,
     .n_out = 2,
     .in = {V_ETA(0, 0), V_FROM("k", 0)},
     .out = {V_FROM("f0", 0), V_FROM("f82", 0)},
     .apply = conductor_to_f82},
    {.from = "f82",
     .to = "edge-tint",
     .by = "",
     .formula = "the g whose F at cos = 1/7 is f82",
     .source = "Fresnel's equations",
     .assumes = at_82,
     .limits = "an f82 below the dielectric's of that f0, or above that of |eta + i k| = 1, belongs to no index",
     .matches = 1,
     .n_in = 2,
     .n_out = 2,
     .in = {V_FROM("f0", 0), V_FROM("f82", 0)},
     .out = {V_F0, V_FROM("g", 0)},
     .apply = f82_to_edge_tint},
    {.from = "f0",
     .to = "f82",
     .by = "",
     .formula = "f82 = f0 + (1 - f0)(6/7)^5",
     .source = kutz,
     .assumes = "F is Schlick's",
     .limits = exact,
     .n_in = 1,
     .n_out = 2,
     .in = {V_F0},
     .out = {V_FROM("f0", 0), V_FROM("f82", 0)},
     .apply = f0_to_f82},
    {.from = "f82",
     .to = "f0",
     .by = "",
     .formula = "f0 = f0",
     .source = kutz,
     .assumes = "the angle of 82 degrees does not matter",
     .limits = "exact at normal incidence; f82 is lost",
     .matches = 1,
     .n_in = 2,
     .n_out = 1,
     .in = {V_FROM("f0", 0), V_FROM("f82", 0)},
     .out = {V_F0},
     .apply = first},
    {.from = "edge-tint",
     .to = "f0",
     .by = "",
     .formula = "f0 = f0",
     .source = gulbrandsen,
     .assumes = "other angles than normal incidence do not matter",
     .limits = "exact at normal incidence; the tint is lost",
     .matches = 1,
     .n_in = 2,
     .n_out = 1,
     .in = {V_F0, V_FROM("g", 0)},
     .out = {V_F0},
     .apply = first},
};

FF_CONVERSION_GROUP(fresnel, fresnels);
