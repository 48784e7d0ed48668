/* Clear sky: Preetham, Shirley and Smits 1999, "A practical analytic model for daylight", appendix A.2.
 *
 *   F(t, g) = (1 + A e^(B / cos t)) (1 + C e^(D g) + E cos^2 g)       Perez et al. 1993, eq. 3 of the paper
 *   q(t, g) = q_zenith F(t, g) / F(0, t_s)                            for q = Y, x, y
 *
 * t the angle from the zenith, g that from the sun, t_s the sun's angle from the zenith. */
#include "internal_render.h"
#include "base/internal_options.h"
#include <math.h>
#include <stdlib.h>

static const double pi = 3.14159265358979323846;

enum { SKY_COLUMNS = 256, SKY_ROWS = 128 };

typedef struct perez {
    double a, b, c, d, e;
} perez;

typedef struct sky {
    perez of[3]; /* Y, x, y */
    double zenith[3];
    double sun[3], sun_zenith; /* unit vector, angle */
} sky;

static double distribution(const perez *p, double cos_t, double g)
{
    const double cos_g = cos(g);
    return (1 + p->a * exp(p->b / cos_t)) * (1 + p->c * exp(p->d * g) + p->e * cos_g * cos_g);
}

/* A to E as lines in the turbidity. */
static perez coefficients(int q, double T)
{
    static const double slope[3][5] = {{0.1787, -0.3554, -0.0227, 0.1206, -0.0670},
                                       {-0.0193, -0.0665, -0.0004, -0.0641, -0.0033},
                                       {-0.0167, -0.0950, -0.0079, -0.0441, -0.0109}};
    static const double level[3][5] = {{-1.4630, 0.4275, 5.3251, -2.5771, 0.3703},
                                       {-0.2592, 0.0008, 0.2125, -0.8989, 0.0452},
                                       {-0.2608, 0.0092, 0.2102, -1.6537, 0.0529}};
    double v[5];
    for (int k = 0; k < 5; k++) v[k] = slope[q][k] * T + level[q][k];
    return (perez){v[0], v[1], v[2], v[3], v[4]};
}

/* Of x or y: [T^2 T 1] M [t^3 t^2 t 1]. */
static double zenith_chromaticity(int q, double T, double t)
{
    static const double m[2][3][4] = {
        {{0.00166, -0.00375, 0.00209, 0}, {-0.02903, 0.06377, -0.03202, 0.00394}, {0.11693, -0.21196, 0.06052, 0.25886}},
        {{0.00275, -0.00610, 0.00317, 0}, {-0.04214, 0.08970, -0.04153, 0.00516}, {0.15346, -0.26756, 0.06670, 0.26688}}};
    const double by_T[3] = {T * T, T, 1};
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += by_T[k] * (((m[q][k][0] * t + m[q][k][1]) * t + m[q][k][2]) * t + m[q][k][3]);
    return sum;
}

static sky make(double elevation, double T)
{
    const double a = -0.75 * pi, t = 0.5 * pi - elevation, chi = (4.0 / 9 - T / 120) * (pi - 2 * t);
    sky s = {.zenith = {(4.0453 * T - 4.9710) * tan(chi) - 0.2155 * T + 2.4192, zenith_chromaticity(0, T, t),
                        zenith_chromaticity(1, T, t)},
             .sun = {sin(t) * sin(a), cos(t), -sin(t) * cos(a)},
             .sun_zenith = t};
    for (int q = 0; q < 3; q++) s.of[q] = coefficients(q, T);
    return s;
}

/* Linear red, green, blue of Rec. 709, in kcd/m^2; what is outside of its gamut has the negative ones as 0. */
static void radiance(const sky *s, const double w[3], double out[3])
{
    static const double rgb_of_xyz[3][3] = {
        {3.2404542, -1.5371385, -0.4985314}, {-0.9692660, 1.8760108, 0.0415560}, {0.0556434, -0.2040259, 1.0572252}};
    const double cos_g = s->sun[0] * w[0] + s->sun[1] * w[1] + s->sun[2] * w[2], g = acos(fmin(fmax(cos_g, -1), 1));
    double q[3];
    for (int k = 0; k < 3; k++) q[k] = s->zenith[k] * distribution(&s->of[k], w[1], g) / distribution(&s->of[k], 1, s->sun_zenith);
    const double Y = fmax(q[0], 0), xyz[3] = {q[1] / q[2] * Y, Y, (1 - q[1] - q[2]) / q[2] * Y};
    for (int k = 0; k < 3; k++) out[k] = fmax(rgb_of_xyz[k][0] * xyz[0] + rgb_of_xyz[k][1] * xyz[1] + rgb_of_xyz[k][2] * xyz[2], 0);
}

/* The upper half of the map; its irradiance on a horizontal surface. */
static void paint_sky(const sky *s, float *rgb, double irradiance[3])
{
    for (size_t r = 0; r < SKY_ROWS / 2; r++) {
        const double t = pi * ((double)r + 0.5) / SKY_ROWS, lo = cos(pi * (double)r / SKY_ROWS),
                     hi = cos(pi * (double)(r + 1) / SKY_ROWS), omega_cos = pi / SKY_COLUMNS * (lo * lo - hi * hi);
        for (size_t c = 0; c < SKY_COLUMNS; c++) {
            const double a = 2 * pi * (((double)c + 0.5) / SKY_COLUMNS - 0.5);
            double L[3];
            radiance(s, (const double[]){sin(t) * sin(a), cos(t), -sin(t) * cos(a)}, L);
            for (size_t k = 0; k < 3; k++) {
                rgb[3 * (r * SKY_COLUMNS + c) + k] = (float)L[k];
                irradiance[k] += L[k] * omega_cos;
            }
        }
    }
}

ff_status ff_environment_sky(double elevation, double turbidity, double ground, double turn, ff_environment **out, ff_error *err)
{
    double irradiance[3] = {0};
    if (!(elevation >= 0 && elevation <= FF_HORIZON) || !(turbidity >= 2 && turbidity <= 10) || !(ground >= 0 && ground <= 1) ||
        !(fabs(turn) <= 1e9))
        return ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "a sky of elevation %g, turbidity %g, ground %g, turn %g: expected 0 to pi/2, 2 to 10, 0 to 1, -1e9 to 1e9", elevation,
            turbidity, ground, turn);
    float *rgb = malloc(3 * (size_t)SKY_COLUMNS * SKY_ROWS * sizeof *rgb);
    if (!rgb) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "no memory for a sky");
    const sky s = make(elevation, turbidity);
    paint_sky(&s, rgb, irradiance);
    const double scale = pi / ff_luminance(irradiance[0], irradiance[1], irradiance[2]);
    const size_t half = 3 * (size_t)SKY_COLUMNS * (SKY_ROWS / 2);
    for (size_t k = 0; k < half; k++) {
        rgb[k] = (float)(rgb[k] * scale);
        rgb[half + k] = (float)(ground / pi * irradiance[k % 3] * scale);
    }
    const ff_status status = ff_environment_of(SKY_COLUMNS, SKY_ROWS, rgb, turn, out, err);
    free(rgb);
    return status;
}
