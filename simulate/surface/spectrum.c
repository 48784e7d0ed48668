/* Heights of a Gaussian process: independent complex amplitudes of the variance that the spectrum says, and their transform. */
#include "internal_surface.h"
#include "base/internal_vector_math.h"
#include <math.h>
#include <stdlib.h>

static const uint32_t kind_amplitude = 0x68656967;

/* Spectra whose slopes have no finite variance end at waves of so many cells; the facets follow what is longer. */
static const double shortest = 8;

static double density(const ff_height_field_options *o, double kl2)
{
    const double k = 2 * FF_PI / shortest * o->correlation;
    if (o->spectrum != FF_SPECTRUM_GAUSSIAN && kl2 > k * k) return 0;
    switch (o->spectrum) {
    case FF_SPECTRUM_EXPONENTIAL:
        return pow(1 + kl2, -1.5);
    case FF_SPECTRUM_POWER_LAW:
        return pow(1 + kl2, -1 - o->hurst);
    default:
        return exp(-0.25 * kl2);
    }
}

/* h(x) = g(A x) of an isotropic g with A = L^T / alpha, alpha the larger roughness: the spectrum of h at k is that of g at alpha
 * L^-1 k. */
static double stretched(const ff_height_field_options *o, const double l[3], double kx, double ky)
{
    const double xx = l[0] * l[0], xy = l[0] * l[1], yy = l[1] * l[1] + l[2] * l[2];
    const double most = 0.5 * (xx + yy) + hypot(0.5 * (xx - yy), xy); /* of the eigenvalues of L L^T */
    const double gx = kx / l[0], gy = (ky - l[1] * gx) / l[2];
    return density(o, most * (gx * gx + gy * gy) * o->correlation * o->correlation);
}

static void amplitudes(const ff_height_field_options *o, const double l[3], uint64_t number, size_t n, double *a)
{
    const size_t half = n / 2 + 1;
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < half; i++) {
            double u[4], *at = a + 2 * (j * half + i);
            const double kx = 2 * FF_PI * (double)i / (double)n,
                         ky = 2 * FF_PI * (j <= n / 2 ? (double)j : (double)j - (double)n) / (double)n;
            ff_height_field_random(o->seed, number * n * half + j * half + i, 0, kind_amplitude, u);
            const double size = i + j ? sqrt(stretched(o, l, kx, ky) * -log(u[0])) : 0;
            at[0] = size * cos(2 * FF_PI * u[1]);
            at[1] = size * sin(2 * FF_PI * u[1]);
        }
    for (size_t i = 0; i < half; i += n / 2) /* columns that are their own mirror image: Hermitian in themselves */
        for (size_t j = 0; j < n; j++) {
            double *at = a + 2 * (j * half + i), *other = a + 2 * ((n - j) % n * half + i);
            if (at == other)
                at[0] *= sqrt(2), at[1] = 0;
            else if (j > n / 2)
                at[0] = other[0], at[1] = -other[1];
        }
}

void ff_heights_moments(const ff_heights *s, double m[4])
{
    double sum[4] = {0};
    for (size_t j = 0; j < s->ny; j++)
        for (size_t i = 0; i < s->nx; i++)
            for (int k = 0; k < 2; k++) {
                double x, y;
                ff_heights_slopes(s, i, j, k, &x, &y);
                sum[0] += x * x;
                sum[1] += y * y;
                sum[2] += x * y;
                sum[3] += x * x * x * x;
            }
    for (int k = 0; k < 4; k++) m[k] = sum[k] / (2 * (double)s->nx * (double)s->ny);
}

ff_status ff_heights_draw(const ff_rays *rays, const ff_height_field_options *o, const double l[3], uint64_t number,
                          ff_heights *out, ff_error *err)
{
    const size_t n = o->cells & ~(size_t)1;
    double *a = malloc(2 * n * (n / 2 + 1) * sizeof *a), m[4];
    *out = (ff_heights){n, n, malloc(n * n * sizeof *a), 1, 1};
    ff_status status = a && out->h ? FF_OK : ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for %zu x %zu heights", n, n);
    if (!status) {
        amplitudes(o, l, number, n, a);
        status = rays->transform(n, n, a, out->h, err);
    }
    free(a);
    if (status) {
        free(out->h);
        out->h = NULL;
        return status;
    }
    ff_heights_moments(out, m);
    const double tx = l[0] / sqrt(2), ty = hypot(l[1], l[2]) / sqrt(2), rx = sqrt(m[0]), ry = sqrt(m[1]),
                 scale = sqrt(tx * ty / (rx * ry));
    for (size_t k = 0; k < n * n; k++) out->h[k] *= scale;
    out->dx = rx * scale / tx;
    out->dy = ry * scale / ty;
    return FF_OK;
}
