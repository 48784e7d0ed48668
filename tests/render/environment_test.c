/* Environments: what is drawn against what is said of its density, by quadrature and by counting; the sky against its irradiance.
 */
#include "ff_test.h"
#include "ff_render.h"
#include "ff_simulate.h"

static const double pi = 3.14159265358979323846;

enum { NX = 24, NY = 12, BLOCK = 1024 };

/* A map with black parts, whole black rows, colours, and a pixel that is a thousand times as bright as others. */
static ff_environment *spotted(size_t nx, size_t ny, double turn)
{
    ff_environment *e = NULL;
    ff_error err = {0};
    float *rgb = malloc(3 * nx * ny * sizeof *rgb);
    for (size_t k = 0; k < 3 * nx * ny; k++) {
        const size_t r = k / 3 / nx, c = k / 3 % nx;
        const double v = ff_random_uniform(1, 0, k);
        rgb[k] = (float)(r == 3 || r == 4 || r == 5 || c % 5 == 0 ? 0 : v);
        if (r == ny - 3 && c == nx / 3) rgb[k] *= 1000;
    }
    const ff_status status = ff_environment_new(nx, ny, rgb, turn, &e, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    free(rgb);
    return e;
}

static ff_environment *sky(double elevation, double turbidity, double ground, double turn)
{
    ff_environment *e = NULL;
    ff_error err = {0};
    const ff_status status = ff_environment_sky(elevation, turbidity, ground, turn, &e, &err);
    FF_CHECK(status == FF_OK, "%s", err.message);
    return e;
}

/* Integrals over all directions by the midpoints of n x 2n cells: of the density, of the radiance, of what lights a surface that
 * faces up and one that faces down. */
typedef struct integrals {
    double pdf, rgb[3], up[3], down[3];
} integrals;

static integrals integrate(const ff_environment *e, size_t n)
{
    integrals sum = {0};
    double w[3][BLOCK], rgb[3][BLOCK], pdf[BLOCK], omega[BLOCK];
    size_t filled = 0;
    for (size_t k = 0; k < 2 * n * n; k++) {
        const double t0 = pi * (double)(k / (2 * n)) / (double)n, t = t0 + pi * 0.5 / (double)n,
                     a = pi * ((double)(k % (2 * n)) + 0.5) / (double)n;
        w[0][filled] = sin(t) * sin(a);
        w[1][filled] = cos(t);
        w[2][filled] = -sin(t) * cos(a);
        omega[filled++] = pi / (double)n * (cos(t0) - cos(t0 + pi / (double)n));
        if (filled < BLOCK && k + 1 < 2 * n * n) continue;
        ff_environment_look(e, filled, w[0], rgb[0], pdf, BLOCK);
        for (size_t i = 0; i < filled; i++) {
            sum.pdf += pdf[i] * omega[i];
            for (size_t c = 0; c < 3; c++) {
                sum.rgb[c] += rgb[c][i] * omega[i];
                sum.up[c] += rgb[c][i] * fmax(w[1][i], 0) * omega[i];
                sum.down[c] += rgb[c][i] * fmax(-w[1][i], 0) * omega[i];
            }
        }
        filled = 0;
    }
    return sum;
}

/* The mean of L / pdf over drawn directions against quadrature, within five standard errors; what is drawn is what is looked at. */
static void draws_are_right(const ff_environment *e, const char *name, uint64_t stream)
{
    const integrals want = integrate(e, 768);
    double w[3][BLOCK], rgb[3][BLOCK], pdf[BLOCK], seen[3][BLOCK], seen_pdf[BLOCK], u[2][BLOCK], sum[3] = {0}, squares[3] = {0};
    const size_t n = 400 * BLOCK;
    size_t other_cell = 0;
    FF_CHECK(fabs(want.pdf - 1) < 2e-3, "%s: the density integrates to %.6f", name, want.pdf);
    for (size_t first = 0; first < n; first += BLOCK) {
        for (size_t i = 0; i < BLOCK; i++)
            for (uint32_t d = 0; d < 2; d++) u[d][i] = ff_random_uniform(ff_test_seed(), 10 + d, stream * 1000000 + first + i);
        ff_environment_draw(e, BLOCK, u[0], w[0], rgb[0], pdf, BLOCK);
        ff_environment_look(e, BLOCK, w[0], seen[0], seen_pdf, BLOCK);
        for (size_t i = 0; i < BLOCK; i++) {
            const double length = sqrt(w[0][i] * w[0][i] + w[1][i] * w[1][i] + w[2][i] * w[2][i]);
            FF_CHECK(fabs(length - 1) < 1e-14 && pdf[i] > 0, "%s: |w| = 1 + %g, pdf %g", name, length - 1, pdf[i]);
            other_cell += seen_pdf[i] != pdf[i]; /* on an edge, by rounding */
            for (size_t c = 0; c < 3; c++) {
                const double x = rgb[c][i] / pdf[i];
                FF_CHECK(fabs(rgb[c][i] - seen[c][i]) <= 1e-5 * (rgb[c][i] + 1e-3), "%s: %g drawn, %g seen", name, rgb[c][i],
                         seen[c][i]);
                sum[c] += x;
                squares[c] += x * x;
            }
        }
    }
    FF_CHECK(other_cell < 10, "%s: %zu of %zu drawn directions have another density when looked at", name, other_cell, n);
    for (size_t c = 0; c < 3; c++) {
        const double mean = sum[c] / (double)n, error = sqrt((squares[c] / (double)n - mean * mean) / (double)n);
        FF_CHECK(fabs(mean - want.rgb[c]) < 5 * error + 1e-4 * want.rgb[c], "%s: %g +- %g drawn, %g by quadrature", name, mean,
                 error, want.rgb[c]);
    }
}

static void maps_are_drawn_as_they_are(void)
{
    ff_environment *e = spotted(NX, NY, 0.7);
    draws_are_right(e, "map", 1);
    ff_environment_free(e);
    e = spotted(400, 90, -20); /* columns that are narrow */
    draws_are_right(e, "fine map", 2);
    ff_environment_free(e);
}

static void skies_are_drawn_as_they_are(void)
{
    ff_environment *e = sky(0.6, 3, 0.2, 0);
    draws_are_right(e, "sky", 3);
    ff_environment_free(e);
    e = sky(0.02, 8, 0, 3);
    draws_are_right(e, "evening", 4);
    ff_environment_free(e);
}

/* How often a cell is drawn, against its density: chi square of 288 cells. */
static void counts_are_as_the_density_says(void)
{
    enum { DRAWN = 200000 };
    ff_environment *e = spotted(NX, NY, 0);
    double count[NY][NX] = {{0}}, chi2 = 0, dof = 0, w[3], pdf;
    for (size_t i = 0; i < DRAWN; i++) {
        const double u[2] = {ff_random_uniform(ff_test_seed(), 20, i), ff_random_uniform(ff_test_seed(), 21, i)};
        ff_environment_draw(e, 1, u, w, NULL, &pdf, 1);
        const size_t r = (size_t)fmin(acos(w[1]) / pi * NY, NY - 1),
                     c = (size_t)fmin((atan2(w[0], -w[2]) / (2 * pi) + 0.5) * NX, NX - 1);
        count[r][c]++;
    }
    for (size_t r = 0; r < NY; r++)
        for (size_t c = 0; c < NX; c++) {
            const double t = pi * ((double)r + 0.5) / NY, a = 2 * pi * (((double)c + 0.5) / NX - 0.5);
            const double middle[3] = {sin(t) * sin(a), cos(t), -sin(t) * cos(a)},
                         omega = 2 * pi / NX * (cos(pi * (double)r / NY) - cos(pi * (double)(r + 1) / NY));
            ff_environment_look(e, 1, middle, NULL, &pdf, 1);
            const double want = pdf * omega * DRAWN;
            FF_CHECK(want > 0 || count[r][c] == 0, "cell %zu, %zu of density 0 is drawn", r, c);
            if (want < 5) continue;
            chi2 += (count[r][c] - want) * (count[r][c] - want) / want;
            dof++;
        }
    FF_CHECK(dof > 100 && chi2 < dof + 6 * sqrt(2 * dof), "chi square %.1f of %.0f cells", chi2, dof); /* by chance 1e-8 */
    ff_environment_free(e);
}

/* What the header says of the sky: it lights a horizontal surface with pi, the ground reflects its part of that, and the brightest
 * place is near the sun, to the front left. */
static void skies_are_as_the_header_says(void)
{
    for (int k = 0; k < 12; k++) {
        const double elevation = 0.13 * k, turbidity = 2 + 0.7 * k, ground = 0.09 * k;
        ff_environment *e = sky(elevation, turbidity, ground, 0);
        const integrals got = integrate(e, 768);
        const double *E = got.up, Y = 0.2126 * E[0] + 0.7152 * E[1] + 0.0722 * E[2];
        FF_CHECK(fabs(Y - pi) < 3e-2, "irradiance %g", Y); /* the horizon is between two rows of pixels */
        for (size_t c = 0; c < 3; c++)
            FF_CHECK(fabs(got.down[c] - ground * E[c]) < 0.02 * E[c], "channel %zu: %g from the ground, expected %g of %g", c,
                     got.down[c], ground, E[c]);
        ff_environment_free(e);
    }
    ff_environment *e = sky(0.7, 2.5, 0.2, 0);
    double most = 0, where[3] = {0};
    for (size_t k = 0; k < 20000; k++) {
        const double y = (double)k / 20000, a = 2.399963229728653 * (double)k, s = sqrt(1 - y * y),
                     w[3] = {s * sin(a), y, -s * cos(a)};
        double rgb[3];
        ff_environment_look(e, 1, w, rgb, NULL, 1);
        if (rgb[0] + rgb[1] + rgb[2] > most && y > 0.1) {
            most = rgb[0] + rgb[1] + rgb[2];
            memcpy(where, w, sizeof where);
        }
    }
    const double sun[3] = {-cos(0.7) * sqrt(0.5), sin(0.7), cos(0.7) * sqrt(0.5)};
    const double c = sun[0] * where[0] + sun[1] * where[1] + sun[2] * where[2];
    FF_CHECK(c > cos(0.06), "the brightest place is %.3f from the sun", acos(c));
    ff_environment_free(e);
}

/* A turn of an environment is a turn of the directions the other way. */
static void turns_are_turns(void)
{
    ff_environment *still = spotted(NX, NY, 0), *turned = spotted(NX, NY, 1.1);
    for (size_t k = 0; k < 500; k++) {
        const double y = 2 * ff_random_uniform(ff_test_seed(), 30, k) - 1, a = 2 * pi * ff_random_uniform(ff_test_seed(), 31, k),
                     s = sqrt(1 - y * y);
        const double w[3] = {s * sin(a), y, s * cos(a)}; /* a: counter-clockwise from the viewer, seen from above */
        const double v[3] = {s * sin(a + 1.1), y, s * cos(a + 1.1)};
        double one[3], other[3];
        ff_environment_look(still, 1, w, one, NULL, 1);
        ff_environment_look(turned, 1, v, other, NULL, 1);
        for (int c = 0; c < 3; c++) FF_CHECK(fabs(one[c] - other[c]) < 1e-5 * (1 + one[c]), "%g, turned %g", one[c], other[c]);
    }
    ff_environment_free(still);
    ff_environment_free(turned);
}

static void what_is_no_light_is_refused(void)
{
    ff_error err = {0};
    ff_environment *e = NULL;
    const float bad[][3] = {{NAN, 0, 1}, {-1, 2, 3}, {INFINITY, 1, 1}};
    for (size_t k = 0; k < 3; k++) FF_CHECK(ff_environment_new(1, 1, bad[k], 0, &e, &err) == FF_ERR_RANGE && !e, "pixel %zu", k);
    FF_CHECK(ff_environment_new(1, 1, (const float[]){0, 0, 0}, 0, &e, &err) == FF_ERR_DATA && !e, "black");
    FF_CHECK(ff_environment_new(0, 1, bad[0], 0, &e, &err) == FF_ERR_RANGE, "no column");
    FF_CHECK(ff_environment_new(1, 40000, bad[0], 0, &e, &err) == FF_ERR_RANGE, "too many rows");
    FF_CHECK(ff_environment_new(1, 1, (const float[]){1, 1, 1}, NAN, &e, &err) == FF_ERR_RANGE, "turn");
    const double sky[][4] = {{-0.1, 3, 0, 0}, {2, 3, 0, 0}, {NAN, 3, 0, 0},     {1, 1, 0, 0},
                             {1, 11, 0, 0},   {1, 3, 2, 0}, {1, 3, 0, INFINITY}};
    for (size_t k = 0; k < sizeof sky / sizeof *sky; k++)
        FF_CHECK(ff_environment_sky(sky[k][0], sky[k][1], sky[k][2], sky[k][3], &e, &err) == FF_ERR_RANGE && !e, "sky %zu", k);
    FF_CHECK(ff_environment_read("/nowhere/map.exr", 0, &e, &err) != FF_OK && !e && strstr(err.path, "map.exr"), "missing file");
}

FF_TEST_MAIN(FF_TEST(maps_are_drawn_as_they_are), FF_TEST(skies_are_drawn_as_they_are), FF_TEST(counts_are_as_the_density_says),
             FF_TEST(skies_are_as_the_header_says), FF_TEST(turns_are_turns), FF_TEST(what_is_no_light_is_refused))
