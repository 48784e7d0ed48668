/** @file instrument.h  A goniometer's file made here: the layout and the faults of a real one, for the tests that want measured
 *  files and do not have them. C. */
#ifndef INSTRUMENT_H
#define INSTRUMENT_H
#include "fit_samples.h"

enum { INSTRUMENT_INCIDENCES = 4, INSTRUMENT_EXITS = 45, INSTRUMENT_AZIMUTHS = 36 };
enum { INSTRUMENT_POINTS = INSTRUMENT_INCIDENCES * INSTRUMENT_EXITS * INSTRUMENT_AZIMUTHS };

/** What is wrong with it. */
typedef struct instrument_faults {
    double noise;   /**< relative standard deviation                                                              */
    double offset;  /**< of the detector, 1/sr: taken off all values, so that dark ones become negative           */
    double horizon; /**< degrees of theta_s beyond which the detector sees less and less of its spot; 90: never   */
} instrument_faults;

/** Writes an ASTM E1392 file: three channels at 465, 525 and 630 nm, theta_i 0 to 60 degrees by 20, theta_s 0 to 88 by 2, phi_s
 *  around by 10; VARS does not name phi_s, though the rows have it, and the light comes from phi_i = pi. */
static inline void instrument_write(const char *path, const fit_surface *s, const instrument_faults *faults, const char *name)
{
    FILE *out = fopen(path, "w");
    uint64_t state = ff_test_stream("instrument %s", name);
    if (!out || s->n_channels != 3) {
        perror(path);
        exit(1);
    }
    fprintf(out, "SYSTEM_NAME made by the test\nAPERTURE Circular\n\nSAMPLE_NAME %s\n\nMEAS_NAME BRDF\nNUM_POINTS %d\n", name,
            INSTRUMENT_POINTS);
    fprintf(out, "VARS theta_i,phi_i,theta_s,465nm,525nm,630nm\n\n");
    for (int k = 0; k < INSTRUMENT_POINTS; k++) {
        const int i = k / (INSTRUMENT_EXITS * INSTRUMENT_AZIMUTHS), e = k / INSTRUMENT_AZIMUTHS % INSTRUMENT_EXITS;
        const double theta_i = 20 * i * FIT_DEGREE, theta_s = 2 * e * FIT_DEGREE,
                     phi_s = 10 * (k % INSTRUMENT_AZIMUTHS) * FIT_DEGREE;
        const double wi[3] = {-sin(theta_i), 0, cos(theta_i)},
                     wo[3] = {sin(theta_s) * cos(phi_s), sin(theta_s) * sin(phi_s), cos(theta_s)};
        const ff_dirs w = {wi, wi + 1, wi + 2, wo, wo + 1, wo + 2};
        const double seen = fmin((90 - 2 * e) / (90 - fmin(faults->horizon, 89)), 1);
        double f[3];
        if (ff_model_eval(&s->model, FF_ISA_BEST, 3, s->shape, s->channel, &w, 1, f, NULL, 1)) exit(1);
        fprintf(out, "%.15g,3.14159265358979,%.15g,%.15g", theta_i, theta_s, phi_s);
        for (int c = 0; c < 3; c++) fprintf(out, ",%.15g", f[c] * seen * (1 + faults->noise * fit_normal(&state)) - faults->offset);
        fprintf(out, "\n");
    }
    if (fclose(out) != 0) exit(1);
}

#endif
