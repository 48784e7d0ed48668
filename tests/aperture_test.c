/* Means over an aperture, against sums over 10^5 nodes that know nothing of lobes, differences, and what is known exactly. */
#include "ff_aperture.h"
#include "fit_samples.h"
#include "models/internal_model.h"

enum { PAIRS = 24, BRUTE = 320 };

static void direction(double theta, double phi, double *x, double *y, double *z)
{
    *x = sin(theta) * cos(phi), *y = sin(theta) * sin(phi), *z = cos(theta);
}

/* BRUTE x BRUTE midpoints of equal area in a disc, or in the plane of a rectangle. */
static double brute(const fit_surface *s, const ff_aperture *a, const double wi[3], double theta, double phi)
{
    static double w[6][BRUTE], f[BRUTE];
    double sum = 0, area = 0;
    for (int i = 0; i < BRUTE; i++) {
        double weight[BRUTE];
        for (int k = 0; k < BRUTE; k++) {
            const double u = (i + 0.5) / BRUTE, t = (k + 0.5) / BRUTE;
            double local[3];
            if (a->outline == FF_APERTURE_DISC) {
                direction(acos(1 - u * (1 - cos(a->half))), 2 * FIT_DEGREE * 180 * t, &local[0], &local[1], &local[2]);
                weight[k] = 1;
            } else {
                const double p = tan(a->half) * (2 * u - 1), q = tan(a->across) * (2 * t - 1), l = sqrt(1 + p * p + q * q);
                local[0] = p / l, local[1] = q / l, local[2] = 1 / l;
                weight[k] = 1 / (l * l * l);
            }
            for (int d = 0; d < 3; d++) w[d][k] = wi[d];
            const double x = local[0] * cos(theta) + local[2] * sin(theta);
            w[3][k] = x * cos(phi) - local[1] * sin(phi), w[4][k] = x * sin(phi) + local[1] * cos(phi);
            w[5][k] = -local[0] * sin(theta) + local[2] * cos(theta);
        }
        const ff_dirs dirs = {w[0], w[1], w[2], w[3], w[4], w[5]};
        FF_CHECK(!ff_model_eval(&s->model, FF_ISA_BEST, 1, s->shape, s->channel, &dirs, BRUTE, f, NULL, BRUTE), "evaluation");
        for (int k = 0; k < BRUTE; k++) {
            sum += weight[k] * fmax(w[5][k], 0) * f[k];
            area += weight[k];
        }
    }
    return sum / area / cos(theta);
}

static void against_brute_force(void)
{
    static const char *const set[] = {"alpha=0.01 f0=0.5 kd=0.05", "alpha=0.05 f0=0.5 kd=0.05",
                                      "alpha_x=0.02 alpha_y=0.2 f0=0.5 kd=0.05", "alpha=0.3 f0=0.5 kd=0.05"};
    for (size_t k = 0; k < PAIRS; k++) {
        const fit_surface s = fit_surface_make("ggx+lambert", 1, set[k % 4]);
        const double half = (0.1 + 2.9 * ff_test_uniform()) * FIT_DEGREE;
        const ff_aperture a = {k % 3 ? FF_APERTURE_DISC : FF_APERTURE_RECTANGLE, half, half * (0.3 + ff_test_uniform())};
        const double theta_i = 70 * FIT_DEGREE * ff_test_uniform(), phi_i = 6.28 * ff_test_uniform();
        const double theta = fabs(theta_i + 3 * half * (2 * ff_test_uniform() - 1)), phi = phi_i + 180 * FIT_DEGREE;
        double w[6], f, error;
        direction(theta_i, phi_i, &w[0], &w[1], &w[2]);
        direction(theta, phi, &w[3], &w[4], &w[5]);
        const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        FF_CHECK(!ff_aperture_eval(&a, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &f, NULL, &error, 1), "aperture");
        FF_CHECK(error <= FF_APERTURE_TOLERANCE, "error %g at %g degrees, %s", error, half / FIT_DEGREE, set[k % 4]);
        /* midpoints are of second order: their step, in widths of the lobe, says what they are worth */
        FF_CHECK_CLOSE(f, brute(&s, &a, w, theta, phi), 1e-4, 0);
    }
}

/* Derivatives of the sum itself: against differences of it. */
static void derivatives(void)
{
    fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha_x=0.02 alpha_y=0.03 f0=0.5 kd=0.05");
    const ff_aperture a = {FF_APERTURE_DISC, 0.75 * FIT_DEGREE, 0};
    const size_t P = s.model.n_shape + s.model.n_channel;
    double w[6], f, df[FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS], up, down;
    direction(0.5, 0, &w[0], &w[1], &w[2]);
    direction(0.52, 3.15, &w[3], &w[4], &w[5]);
    const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    FF_CHECK(!ff_aperture_eval(&a, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &f, df, NULL, 1), "aperture");
    for (size_t k = 0; k < P; k++) {
        double *p = k < s.model.n_shape ? &s.shape[k] : &s.channel[k - s.model.n_shape];
        const double at = *p, h = 1e-6 * (at > 0 ? at : 1);
        *p = at + h;
        const ff_status above = ff_aperture_eval(&a, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &up, NULL, NULL, 1);
        *p = at - h;
        const ff_status below = ff_aperture_eval(&a, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &down, NULL, NULL, 1);
        *p = at;
        if (above || below) continue; /* ks beyond its box */
        FF_CHECK_CLOSE(df[k], (up - down) / (2 * h), 1e-6, 1e-6 * f);
    }
}

/* Of Lambert's term the mean of the cosine over a cone is (1 + cos A) / 2 of that of its centre; a point is the model itself; and
 * half of an aperture on the horizon is dark. */
static void exact(void)
{
    const fit_surface s = fit_surface_make("lambert", 1, "kd=0.5");
    const double half = 3 * FIT_DEGREE;
    double w[6], f, plain;
    direction(0.5, 0, &w[0], &w[1], &w[2]);
    direction(0.7, 2, &w[3], &w[4], &w[5]);
    const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
    FF_CHECK(!ff_model_eval(&s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &plain, NULL, 1), "evaluation");
    FF_CHECK(!ff_aperture_eval(&(ff_aperture){FF_APERTURE_DISC, half, 0}, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1,
                               &f, NULL, NULL, 1),
             "aperture");
    FF_CHECK_CLOSE(f, plain * 0.5 * (1 + cos(half)), 1e-12, 0);
    FF_CHECK(!ff_aperture_eval(&(ff_aperture){FF_APERTURE_DISC, 0, 0}, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &f,
                               NULL, NULL, 1) &&
                 f == plain,
             "a point: %g, expected %g", f, plain);
    FF_CHECK(ff_aperture_eval(&(ff_aperture){FF_APERTURE_DISC, -1, 0}, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &f,
                              NULL, NULL, 1) == FF_ERR_RANGE,
             "a negative aperture");
}

/* Values of another program, alpha .02, F0 .5, kd .05 through a disc of .75 degrees, in six digits: not of a point. */
static void of_another_program(void)
{
    const fit_surface s = fit_surface_make("ggx+lambert", 1, "alpha=0.02 f0=0.5 kd=0.05");
    const ff_aperture disc = {FF_APERTURE_DISC, 0.75 * FIT_DEGREE, 0};
    FILE *in = fopen(FF_SHARED "/cases/aper02.csv", "r");
    char line[128];
    int n = 0;
    if (!in) FF_SKIP("aper02.csv is not there");
    while (fgets(line, sizeof line, in)) {
        double a[4], y, w[6], f;
        if (sscanf(line, "%lf,%lf,%lf,%lf,%lf", &a[0], &a[1], &a[2], &a[3], &y) != 5) continue;
        direction(a[0] * FIT_DEGREE, a[1] * FIT_DEGREE, &w[0], &w[1], &w[2]);
        direction(a[2] * FIT_DEGREE, a[3] * FIT_DEGREE, &w[3], &w[4], &w[5]);
        const ff_dirs dirs = {w, w + 1, w + 2, w + 3, w + 4, w + 5};
        FF_CHECK(!ff_aperture_eval(&disc, &s.model, FF_ISA_BEST, 1, s.shape, s.channel, &dirs, 1, &f, NULL, NULL, 1), "aperture");
        FF_CHECK_CLOSE(f, y, 3e-4, 0);
        n++;
    }
    fclose(in);
    FF_CHECK(n == 170, "%d samples", n);
}

FF_TEST_MAIN(FF_TEST(against_brute_force), FF_TEST(derivatives), FF_TEST(exact), FF_TEST(of_another_program))
