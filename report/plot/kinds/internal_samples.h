/* All samples of a table with their angles, and what a model says of them. */
#ifndef FF_INTERNAL_SAMPLES_H
#define FF_INTERNAL_SAMPLES_H
#include "internal_curves.h"

/* Planes [n] of the valid samples whose directions are above the horizon and up to max_theta. */
typedef struct ff_samples {
    size_t n, step;                  /* one of `step` samples of the table is here          */
    double *theta_h, *theta_d;       /* radians                                             */
    double *value;                   /* 1/sr                                                */
    double *total, *lobe, *base, *d; /* of the model: f, its first lobe, f less it, D of it; NULL without a model */
} ff_samples;

/* One channel of the subject's table, with its first model where there is one. FF_ERR_DATA where no sample is left. */
ff_status ff_samples_make(const ff_plot_subject *s, const ff_plot_channel *channel, ff_isa isa, ff_samples *out, ff_error *err);
void ff_samples_free(ff_samples *s);

#endif
