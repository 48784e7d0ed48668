/* A model as a material of a renderer: its own where the renderer has it, else the one that fits it best, and what is lost. */
#ifndef FF_INTERNAL_REFIT_H
#define FF_INTERNAL_REFIT_H
#include "internal_controls.h"

/* Something that the renderer has otherwise. */
typedef struct ff_lost {
    char what[160];
    double share; /* what it alone changes: rms of the difference over rms of the model, both times cos(theta_i); NaN: cannot be
                     told apart */
} ff_lost;

enum { FF_LOST_MOST = 16 };
typedef struct ff_refit {
    const ff_material *material;
    int is_own; /* 1: the model is the material's: nothing was fitted                                */
    ff_model model;
    double shape[FF_MAX_SHAPE];
    double *channel; /* [n_channels][model.n_channel], owned                                              */
    size_t n_channels;
    double left; /* the same measure of what the material's model leaves after the fit            */
    size_t n_lost;
    ff_lost lost[FF_LOST_MOST];
} ff_refit;

/* Surface: a model with its parameters, as ff_model_eval. */
typedef struct ff_surface {
    const ff_model *model;
    size_t n_channels;
    const double *shape, *channel;
} ff_surface;

/* material NULL: the best of the renderer's. loss: by which it is fitted. FF_ERR_UNSUPPORTED where no material can be fitted;
 * others as ff_problem_fit. Release with ff_refit_clear. */
ff_status ff_refit_make(const ff_target *t, const ff_material *material, const ff_surface *s, ff_loss loss, int threads,
                        ff_refit *out, ff_error *err);
void ff_refit_clear(ff_refit *r);

/* The controls of the refit, [ff_control_count][n_channels], within what the renderer takes; what that changes is added to what is
 * lost. FF_ERR_MEMORY. */
ff_status ff_refit_controls(ff_refit *r, double *control);

/* Adds what is lost when `to` takes the place of s, each for itself. */
ff_status ff_lost_find(const ff_surface *s, const ff_material *m, const ff_model *to, ff_refit *out);
/* rms of the difference over rms of a, both times cos(theta_i), over the directions of a goniometer. NaN where one cannot be
 * evaluated. */
double ff_surface_difference(const ff_surface *a, const ff_surface *b);
#endif
