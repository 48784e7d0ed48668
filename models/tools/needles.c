/* Where the peaks of a model are, and how wide. */
#include "internal_averaging.h"
#include <math.h>

enum { CURVE = 2 * FF_BLOCK };

/* Where a profile is half of what it is at 0, in the square root of q2. */
static double half_of_profile(const ff_prepared *p, const ff_lobe_pass *lobe)
{
    double q2[CURVE], value[CURVE], slope[FF_BLOCK];
    for (int i = 0; i < CURVE; i++) {
        const double q = i ? 1e-5 * pow(1e6, (i - 1) / (CURVE - 2.0)) : 0;
        q2[i] = q * q;
    }
    for (int i = 0; i < CURVE; i += FF_BLOCK)
        p->kernels->ndf[lobe->ndf]->profile(&lobe->ndf_pass, FF_BLOCK, q2 + i, value + i, slope, NULL);
    int i = 1;
    while (i < CURVE && value[i] > 0.5 * value[0]) i++;
    if (i == CURVE) return sqrt(q2[CURVE - 1]);
    const double rest = (value[i - 1] - 0.5 * value[0]) / (value[i - 1] - value[i]);
    return sqrt(q2[i - 1]) + fmin(fmax(rest, 0.5), 1) * (sqrt(q2[i]) - sqrt(q2[i - 1]));
}

/* Sigma = [[ax^2, r ax ay], [r ax ay, ay^2]] of slopes. */
static ff_needle of_lobe(const ff_prepared *p, const ff_lobe_pass *lobe)
{
    const ff_stretch *s = &lobe->s;
    const double half = half_of_profile(p, lobe), scale = 1 / (half * half * (1 - s->r * s->r));
    return (ff_needle){.at = {s->x0, s->y0},
                       .inverse = {scale / (s->ax * s->ax), -scale * s->r / (s->ax * s->ay), scale / (s->ay * s->ay)}};
}

void ff_needles_find(const ff_prepared *p, ff_needles *out)
{
    out->n = 0;
    for (uint32_t l = 0; l < p->m->n_lobes; l++) out->needle[out->n++] = of_lobe(p, &p->lobe[l]);
    for (uint32_t b = 0; b < p->m->n_bases; b++) {
        const ff_diffuse *term = p->kernels->diffuse[p->m->base[b].diffuse];
        double width, power;
        if (!term->peak) continue;
        term->peak(p->base_param[b], &width, &power);
        const double half = width * sqrt(exp2(1 / power) - 1), scale = 1 / (half * half);
        out->needle[out->n++] = (ff_needle){.inverse = {scale, 0, scale}, .of_cosines = 1};
    }
}

static double quadratic(const double m[3], double x, double y)
{
    return m[0] * x * x + 2 * m[1] * x * y + m[2] * y * y;
}

double ff_needle_width(const ff_needle *needle, double azimuth)
{
    return atan(1 / sqrt(quadratic(needle->inverse, cos(azimuth), sin(azimuth))));
}

void ff_needle_look(const ff_needle *needle, const double wi[3], const double wo[3], double e[2][3], ff_needle_view *out)
{
    const double *k = needle->inverse, x = wi[0] + wo[0], y = wi[1] + wo[1], z = wi[2] + wo[2];
    double s[2], ds[2][2]; /* place, and its derivatives by p and q */
    for (int d = 0; d < 2; d++) {
        ds[d][0] = needle->of_cosines ? e[d][0] : (x * e[d][2] / z - e[d][0]) / z;
        ds[d][1] = needle->of_cosines ? e[d][1] : (y * e[d][2] / z - e[d][1]) / z;
    }
    s[0] = (needle->of_cosines ? x : -x / z) - needle->at[0];
    s[1] = (needle->of_cosines ? y : -y / z) - needle->at[1];
    out->c = quadratic(k, s[0], s[1]);
    for (int d = 0; d < 2; d++) out->b[d] = (k[0] * s[0] + k[1] * s[1]) * ds[d][0] + (k[1] * s[0] + k[2] * s[1]) * ds[d][1];
    out->m[0] = quadratic(k, ds[0][0], ds[0][1]);
    out->m[1] = (k[0] * ds[0][0] + k[1] * ds[0][1]) * ds[1][0] + (k[1] * ds[0][0] + k[2] * ds[0][1]) * ds[1][1];
    out->m[2] = quadratic(k, ds[1][0], ds[1][1]);
}

double ff_needle_stretch(const ff_needle_view *v, double radius)
{
    const double mean = 0.5 * (v->m[0] + v->m[2]), apart = hypot(0.5 * (v->m[0] - v->m[2]), v->m[1]);
    return (mean + apart) * radius * radius;
}
