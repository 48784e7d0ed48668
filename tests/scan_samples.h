/** @file scan_samples.h  Measurements in scans: a detector that goes around for each of some incident directions, with noise that
 * may go together along a scan. */
#ifndef SCAN_SAMPLES_H
#define SCAN_SAMPLES_H
#include "fit_samples.h"

/** What is left 0: no noise, all independent. */
typedef struct scan_sampling {
    size_t n_theta, n_phi; /**< incident directions: theta_i evenly up to 0.9 max_theta, phi_i evenly around              */
    size_t n_exit;         /**< samples of a scan, along a spiral over the hemisphere up to max_theta                    */
    double max_theta;      /**< degrees                                                                                  */
    double noise;          /**< standard deviation relative to the value                                                 */
    double reach;          /**< samples over which the noise of a scan falls to 1/e                                       */
    uint64_t seed;
} scan_sampling;

/** Exits: in turn across the hemisphere in a spiral, and close to the mirror direction, where lobes are. */
static inline void scan_exit(const scan_sampling *how, size_t k, double theta_i, double phi_i, double *theta, double *phi)
{
    const double s = ((double)k + 0.5) / (double)how->n_exit, limit = how->max_theta * FIT_DEGREE;
    if (k < how->n_exit / 2) {
        const double turn = 2 * s; /* a spiral about the mirror direction: 0.5 to 35 degrees from it */
        const double r = (0.5 + 34.5 * turn) * FIT_DEGREE, a = 2 * 180 * FIT_DEGREE * 7 * turn;
        *theta = fmin(fabs(theta_i + r * cos(a)), limit);
        *phi = phi_i + 180 * FIT_DEGREE + r * sin(a) / fmax(sin(theta_i), 0.2);
        return;
    }
    const double turn = 2 * s - 1;
    *theta = limit * turn;
    *phi = phi_i + 360 * FIT_DEGREE * 5 * turn;
}

static inline ff_table scan_measure(const fit_surface *s, const scan_sampling *how)
{
    ff_table t;
    uint64_t state = ff_test_seeded(how->seed * UINT64_C(0xd1342543de82ef95) + 1);
    const size_t directions = how->n_theta * how->n_phi;
    if (ff_table_init(directions * how->n_exit, s->n_channels, NULL, 0, 0, &t, NULL)) exit(1);
    t.radians_per_unit = 1;
    t.isotropic = how->n_phi == 1;
    for (size_t i = 0; i < t.n; i++) {
        const size_t d = i / how->n_exit;
        t.angle[0][i] = 0.9 * how->max_theta * FIT_DEGREE * (double)(d / how->n_phi + 1) / (double)how->n_theta;
        t.angle[1][i] = 360 * FIT_DEGREE * (double)(d % how->n_phi) / (double)how->n_phi;
        scan_exit(how, i % how->n_exit, t.angle[0][i], t.angle[1][i], &t.angle[2][i], &t.angle[3][i]);
    }
    fit_evaluate(s, &t);
    const double keep = how->reach > 0 ? exp(-1 / how->reach) : 0;
    for (size_t c = 0; c < t.n_channels; c++) {
        double e = 0;
        for (size_t i = 0; i < t.n; i++) {
            e = i % how->n_exit == 0 ? fit_normal(&state) : keep * e + sqrt(1 - keep * keep) * fit_normal(&state);
            t.value[c * t.n + i] *= 1 + how->noise * e;
        }
    }
    return t;
}

#endif
