/* Distributions of normals by what is seen of them: the roughness whose lobe is nearest, in least squares, at one angle of
 * incidence.
 *
 *   f cos(theta_o) = D(h) G2(wi, wo) / (4 cos(theta_i)), Smith's height-correlated G2, F = 1
 *
 * What is minimised is the integral over wo of the squared difference. Half vectors are drawn on a polar grid of slopes whose
 * radius goes as sinh, which a lobe with a tail and one without fill alike; dwo = 4 (wi.h) dh.
 */
#include "internal_conversions.h"
#include "models/internal_model.h"
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { RADII = 64, TURNS = 40, NODES = RADII * TURNS, PLANES = 6, SCAN = 17 };
static const double farthest = 8; /* of asinh(slope / roughness): slopes up to 1,490 times the roughness */

/* One distribution: the model, and whether its parameter is an exponent. */
typedef struct side {
    const char *expression;
    int is_exponent;
} side;
static const side beckmann = {"beckmann/smith-height-correlated/none", 0}, ggx = {"ggx/smith-height-correlated/none", 0},
                  phong = {"phong/smith-height-correlated/none", 1};

/* Everything of one comparison, on the heap. */
typedef struct match {
    ff_model given, wanted;
    int exponent_given, exponent_wanted;
    double lo, hi; /* where a parameter is looked for */
    double cos_i;
    size_t n;
    double plane[PLANES][NODES], weight[NODES], value[NODES], trial[NODES];
} match;

/* f cos(theta_o) of one of the two at the nodes. */
static ff_status evaluate(const ff_model *m, int is_exponent, double x, const match *a, double *out, ff_error *err)
{
    double shape[FF_MAX_SHAPE], channel[FF_MAX_CHANNEL_PARAMS];
    ff_model_defaults(m, 1, shape, channel);
    if (is_exponent)
        shape[ff_model_param_find(m, "n").index] = x;
    else
        shape[ff_model_param_find(m, "alpha_x").index] = shape[ff_model_param_find(m, "alpha_y").index] = x;
    const ff_dirs w = {a->plane[0], a->plane[1], a->plane[2], a->plane[3], a->plane[4], a->plane[5]};
    const ff_status status = ff_model_eval(m, FF_ISA_BEST, 1, shape, channel, &w, a->n, out, NULL, a->n);
    if (status == FF_ERR_RANGE) return ff_error_set(err, status, NULL, 0, -1, "%g lies outside what the models cover", x);
    if (status) return ff_error_set(err, status, NULL, 0, -1, "a lobe could not be evaluated");
    for (size_t i = 0; i < a->n; i++) out[i] *= a->plane[5][i];
    return FF_OK;
}

/* Half vectors about the normal, on one side of the plane of incidence, in rings whose slopes grow with the roughness; those that
 * send the light below the horizon are left out. The integrand is smooth and falls to nothing at both ends of the radius, where
 * equal steps are as good as any rule. */
static void place_nodes(match *a, double roughness, double theta_i)
{
    const double wi[3] = {sin(theta_i), 0, cos(theta_i)}, step = 2 * farthest / RADII;
    a->n = 0;
    for (int r = 0; r < RADII; r++) {
        const double q = exp(-farthest + (r + 0.5) * step), slope = roughness * q, hz = 1 / sqrt(1 + slope * slope);
        for (int t = 0; t < TURNS; t++) {
            const double phi = FF_CONVERSION_PI * (t + 0.5) / TURNS, h[3] = {slope * hz * cos(phi), slope * hz * sin(phi), hz};
            const double c = wi[0] * h[0] + wi[2] * h[2], oz = 2 * c * h[2] - wi[2];
            if (c <= 0 || oz <= 0) continue;
            for (int k = 0; k < 3; k++) {
                a->plane[k][a->n] = wi[k];
                a->plane[3 + k][a->n] = 2 * c * h[k] - wi[k];
            }
            /* dh = slope d(slope) dphi hz^3, d(slope) = slope d(ln q) */
            a->weight[a->n++] = 4 * c * slope * slope * hz * hz * hz * step * (FF_CONVERSION_PI / TURNS);
        }
    }
}

/* Sum of squares at the parameter exp(u). */
static ff_status distance(match *a, double u, double *out, ff_error *err)
{
    const ff_status status = evaluate(&a->wanted, a->exponent_wanted, fmin(fmax(exp(u), a->lo), a->hi), a, a->trial, err);
    *out = 0;
    for (size_t i = 0; i < a->n && !status; i++) {
        const double d = a->trial[i] - a->value[i];
        *out += a->weight[i] * d * d;
    }
    return status;
}

/* The least of it: the best of a scan of the box, then the golden section between its neighbours. */
static ff_status nearest(match *a, double *out, ff_error *err)
{
    static const double golden = 0.61803398874989485;
    double u[SCAN], best = INFINITY, d;
    int at = 0;
    ff_status status = FF_OK;
    for (int k = 0; k < SCAN && !status; k++) {
        u[k] = log(a->lo) + (log(a->hi) - log(a->lo)) * k / (SCAN - 1);
        status = distance(a, u[k], &d, err);
        if (!status && d < best) best = d, at = k;
    }
    if (status) return status;
    if (at == 0 || at == SCAN - 1)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "no roughness of the convention wanted has a lobe like it");
    double left = u[at - 1], right = u[at + 1], x1 = right - golden * (right - left), x2 = left + golden * (right - left), d1, d2;
    status = distance(a, x1, &d1, err);
    if (!status) status = distance(a, x2, &d2, err);
    while (!status && right - left > 1e-7) {
        if (d1 < d2) {
            right = x2, x2 = x1, d2 = d1, x1 = right - golden * (right - left);
            status = distance(a, x1, &d1, err);
        } else {
            left = x1, x1 = x2, d1 = d2, x2 = left + golden * (right - left);
            status = distance(a, x2, &d2, err);
        }
    }
    *out = exp((left + right) / 2);
    return status;
}

/* The lobes of two distributions of the same peak are alike: the nearest is within a factor of eight of that, and in the box of the
 * models. */
static void look_around(match *a, double roughness)
{
    const double least = fmax(roughness / 8, 1e-4), most = fmin(8 * roughness, 4);
    a->lo = a->exponent_wanted ? fmax(2 / (most * most) - 2, 1e-3) : least;
    a->hi = a->exponent_wanted ? fmin(fmax(2 / (least * least) - 2, 1), 2e6) : most;
}

static ff_status match_lobes(side given, side wanted, double x, double theta_i, double *out, ff_error *err)
{
    match *a = malloc(sizeof *a);
    if (!a) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu bytes", sizeof *a);
    a->exponent_given = given.is_exponent, a->exponent_wanted = wanted.is_exponent;
    ff_status status = ff_model_parse(given.expression, &a->given, err);
    if (!status) status = ff_model_parse(wanted.expression, &a->wanted, err);
    if (!status) {
        const double roughness = given.is_exponent ? sqrt(2 / (x + 2)) : x;
        place_nodes(a, roughness, theta_i);
        status = evaluate(&a->given, a->exponent_given, x, a, a->value, err);
    }
    look_around(a, given.is_exponent ? sqrt(2 / (x + 2)) : x);
    if (!status) status = nearest(a, out, err);
    free(a);
    return status;
}

#define LOBES(given, wanted)                                                                                                       \
    static ff_status given##_to_##wanted(const double *in, double theta_i, double *out, ff_error *err)                             \
    {                                                                                                                              \
        return match_lobes(given, wanted, in[0], theta_i, out, err);                                                               \
    }
LOBES(beckmann, ggx)
LOBES(ggx, beckmann)
LOBES(beckmann, phong)
LOBES(phong, beckmann)
LOBES(ggx, phong)
LOBES(phong, ggx)

/* ---- the table ------------------------------------------------------------------------------- */

#define ENTRY(a, b, given, wanted)                                                                                                 \
    {                                                                                                                              \
        .from = #a, .to = #b, .by = "lobe",                                                                                        \
        .formula = "least squares of f cos(theta_o) over all directions, at one angle of incidence",                               \
        .source = "Smith's height-correlated masking, F = 1; Heitz 2014, eq. 99",                                                  \
        .assumes = "the nearest lobe at that angle, in the values that count most: those of the peak",                             \
        .limits = "another angle has another answer; fit instead where data exist", .matches = 1, .n_in = 1, .n_out = 1,           \
        .in = {given}, .out = {wanted}, .apply_at = a##_to_##b                                                                     \
    }

static const ff_conversion lobes[] = {
    ENTRY(beckmann, ggx, V_M(INFINITY), V_ALPHA),
    ENTRY(ggx, beckmann, V_ALPHA, V_M(INFINITY)),
    ENTRY(beckmann, phong, V_M(INFINITY), V_N(0)),
    ENTRY(phong, beckmann, V_N(0), V_M(INFINITY)),
    ENTRY(ggx, phong, V_ALPHA, V_N(0)),
    ENTRY(phong, ggx, V_N(0), V_ALPHA),
};

FF_CONVERSION_GROUP(lobes, lobes);
