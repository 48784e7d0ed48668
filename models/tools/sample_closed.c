/* Normals of the unit surface in closed form: which distributions have one, and the visible Gaussian slopes. */
#define FF_ISA_SUFFIX scalar
#include "internal_sample.h"
#include "models/terms/internal_isotropic.h"
#include <string.h>

/* ---- normals --------------------------------------------------------------------------------- */

/* 1 - (1 + q2/nu)^-nu = u */
static double student_t_quantile(const ff_ndf_pass *pass, double u)
{
    const double nu = pass->own[0] - 1;
    return nu * expm1(-log1p(-u) / nu);
}

/* Mikkelsen 2009, eq. 31, for mz in [0, 1]: with low = 1 - mz, (1 - e^(-kappa low)) / (1 - e^-kappa) = u. The source's ln(t e^kappa
 * + ...) overflows. */
static double vmf_quantile(const ff_ndf_pass *pass, double u)
{
    const double kappa = pass->own[0], low = -log1p(u * expm1(-kappa)) / kappa;
    return low * (2 - low) / ((1 - low) * (1 - low));
}

/* Kelemen and Szirmay-Kalos 2001, section 2.1.2: tan = m sqrt(-ln(1 - u)) */
static double kelemen_ward_quantile(const ff_ndf_pass *pass, double u)
{
    return -log1p(-u) * pass->own[0] * pass->own[0];
}

/* The same section: mz = (1 - u)^(1 / (n + 1)) */
static double kelemen_phong_quantile(const ff_ndf_pass *pass, double u)
{
    return expm1(-2 * log1p(-u) / (pass->own[0] + 1));
}

static const struct {
    const char *ndf;
    ff_sample_strategy kind;
    double (*quantile)(const ff_ndf_pass *pass, double u);
} known[] = {
    {"ggx", FF_SAMPLE_VISIBLE_GGX, NULL},
    {"beckmann", FF_SAMPLE_VISIBLE_GAUSSIAN, NULL},
    {"beckmann-walter", FF_SAMPLE_VISIBLE_GAUSSIAN, NULL},
    {"student-t", FF_SAMPLE_NORMALS, student_t_quantile},
    {"phong", FF_SAMPLE_NORMALS, student_t_quantile},
    {"phong-walter", FF_SAMPLE_NORMALS, student_t_quantile},
    {"vmf", FF_SAMPLE_NORMALS, vmf_quantile},
    {"kelemen-ward", FF_SAMPLE_NORMALS, kelemen_ward_quantile},
    {"kelemen-phong", FF_SAMPLE_NORMALS, kelemen_phong_quantile},
};

int ff_sample_closed_form(ff_sample_component *k)
{
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (strcmp(known[i].ndf, k->ndf->term.name) == 0) {
            k->kind = known[i].kind;
            k->quantile = known[i].quantile;
            return 1;
        }
    return 0;
}

/* ---- visible Gaussian slopes ----------------------------------------------------------------- */

ff_gaussian_view ff_gaussian_view_of(double length, double v0)
{
    const double sum = length + v0;
    return (ff_gaussian_view){v0 / sum, length / sum, length > 0 ? -v0 / length : -INFINITY};
}

/* integral_x^inf (one + x z) e^(-z^2) dz, and e^(-x^2) */
static double gaussian_beyond(const ff_gaussian_view *g, double x, double *e)
{
    *e = exp(-x * x);
    return 0.5 * (FF_SQRT_PI * g->one * erfc(x) + g->x * *e);
}

double ff_gaussian_mass(const ff_gaussian_view *g)
{
    double e;
    return gaussian_beyond(g, g->lowest, &e);
}

/* Beyond +-6.2 lies less than a double can tell from 0 or 1. It begins at the quantiles of the two parts (Abramowitz and Stegun,
 * 26.2.23, and that of x e^(-x^2)), weighted as they are, and triples its digits with each step. */
double ff_gaussian_quantile(const ff_gaussian_view *g, double u)
{
    const double enough = 3e-4;
    const double above = (1 - u) * ff_gaussian_mass(g), tail = u < 0.5 ? u : 1 - u, t = sqrt(-2 * log(tail > 1e-17 ? tail : 1e-17));
    const double top = 2.515517 + t * (0.802853 + t * 0.010328), bottom = 1 + t * (1.432788 + t * (0.189269 + t * 0.001308));
    const double normal = copysign((t - top / bottom) * 0.70710678118654752, u - 0.5);
    double lo = fmax(g->lowest, -6.2), hi = 6.2, x = g->one * normal + g->x * sqrt(-log1p(-u));
    if (!(x > lo && x < hi)) x = 0.5 * (lo + hi);
    for (int i = 0; i < 60; i++) {
        double e;
        const double error = gaussian_beyond(g, x, &e) - above, density = g->one + g->x * x;
        if (error > 0)
            lo = x;
        else
            hi = x;
        const double newton = error / (density * e), bend = g->x / density - 2 * x;
        const double next = x + newton / (1 + 0.5 * newton * bend), before = x;
        x = next >= lo && next <= hi ? next : 0.5 * (lo + hi);
        const double moved = fabs(x - before); /* what is left is about moved^3, or moved^3 / (a + x)^2 */
        if (moved < enough && moved * g->x < enough * density) break;
    }
    return x;
}
