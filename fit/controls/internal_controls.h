/* What a person sets in a renderer, with the errors that a fit of its material has. */
#ifndef FF_INTERNAL_CONTROLS_H
#define FF_INTERNAL_CONTROLS_H
#include "fit/trust/trust_struct.h"
#include "targets/internal_target.h"

typedef struct ff_control_estimate {
    double value;
    double std_error; /* NaN: held, on a bound, or not determined                                   */
    double low, high; /* 95 %; NaN where there is none                                              */
    int held;         /* 1: all that it is made of is held                                          */
    int at_bound;     /* as of the parameter, if it is made of one; else 0                          */
    int beyond;       /* -1 below, 1 above what the renderer takes; 0 inside                        */
} ff_control_estimate;

/* Control k of a fit of its material, in channel c (0 unless it is a colour). Its error is that of the parameters carried over by
 * the derivatives of the formula, with their correlations (the delta method); of a control that is made of one parameter the
 * interval is the parameter's own, transformed. */
ff_control_estimate ff_control_estimate_of(const ff_control *k, const ff_fit_result *fit, size_t c);

/* The angles at which a fit of a material is further from the data than a fit that is free, by more than `least` of the data there.
 * Bands of theta_i and theta_h, worst first; returns how many of out [most]. */
typedef struct ff_shortfall {
    int place, band;
    double mean, rms, free_rms; /* relative, as ff_band */
} ff_shortfall;
size_t ff_shortfalls_find(const ff_bands *fit, const ff_bands *other, double least, size_t most, ff_shortfall *out);
#endif
