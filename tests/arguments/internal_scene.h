/* What the probes of arguments.def are made on: a small measurement, models, fits. Made once, by one thread, so that a process
 * that is split off has all of it. */
#ifndef FF_INTERNAL_SCENE_H
#define FF_INTERNAL_SCENE_H
#include "ff_test.h"

#include "ff_albedo.h"
#include "ff_aperture.h"
#include "ff_convert.h"
#include "ff_fit.h"
#include "ff_interpolate.h"
#include "ff_ndf.h"
#include "ff_picture.h"
#include "ff_profile_file.h"
#include "ff_render.h"
#include "ff_resample.h"
#include "ff_rgl.h"
#include "ff_sample.h"
#include "ff_simulate.h"
#include "ff_study.h"
#include "ff_spectral.h"
#include "ff_survey.h"
#include "ff_trust.h"
#include "ff_version.h"
#include "ff_walk.h"
#include "ff_words.h"

enum { N_CHANNELS = 2, N_SHAPE_MOST = 16, N_CHANNEL_MOST = 16 };

typedef struct scene {
    ff_model *model;                                                  /* ggx+lambert, whose parameters are these */
    double shape[N_SHAPE_MOST], channel[N_CHANNELS * N_CHANNEL_MOST]; /* [n_shape], [n_channels][n_channel] */
    size_t n_shape, n_channel;
    ff_table *table, *grey; /* grey: the mean of its channels */
    size_t n;
    ff_fit_options options, robust; /* of one thread */
    ff_problem *problem, *robust_problem, *ndf_problem;
    ff_fit_result *fit[2]; /* ggx, beckmann */
    ff_fit_result *robust_fit;
    ff_places *places;
    ff_interpolant *interpolant;
    ff_sampler *sampler;
    ff_walk *walk; /* of coupled facets, a few paths */
    ff_picture *picture;
    ff_adaptive *adaptive;
    ff_noise *noise; /* of N_CHANNELS levels */
    ff_ndf_options ndf_options;
    ff_ndf_result *ndf;
    ff_study *study; /* of the first model */
} scene;

/* Makes it; 0 with a message when a step fails, which a test counts. */
static int scene_make(scene *s)
{
    static const ff_noise_level level[N_CHANNELS] = {{1e-6, 0, 1e-4}, {2e-6, 0, 1e-4}};
    ff_error err = {0};
    ff_model *beckmann = NULL;
    ff_simulate_options made;
    ff_simulate_options_init(&made);
    ff_fit_options_init(&s->options);
    ff_ndf_options_init(&s->ndf_options);
    s->options.threads = 1;
    s->options.shape = FF_SHAPE_ISOTROPIC;
    s->robust = s->options;
    s->robust.robust = FF_ROBUST_HUBER;
    s->ndf_options.fit = &s->options;
    ff_status status = ff_model_new("ggx+lambert", &s->model, &err);
    if (!status) status = ff_model_new("beckmann+lambert", &beckmann, &err);
    if (!status) {
        s->n_shape = ff_model_param_count(s->model, FF_PARAM_SHAPE);
        s->n_channel = ff_model_param_count(s->model, FF_PARAM_CHANNEL);
        ff_model_defaults(s->model, N_CHANNELS, s->shape, s->channel);
        status = ff_model_set(s->model, N_CHANNELS, "alpha=0.3", s->shape, s->channel, &err);
    }
    ff_walk_options walk;
    ff_walk_options_init(&walk);
    walk.facets = FF_FACETS_COUPLED;
    walk.paths = 20;
    walk.threads = 1;
    made.sampling.step_deg = 15;
    made.relative = 0.01;
    made.floor = 1e-3;
    made.sigma = 1;
    const ff_model *both[2] = {s->model, beckmann};
    if (!status) status = ff_noise_new(level, N_CHANNELS, 0, 0, &s->noise, &err);
    if (!status) status = ff_simulate(s->model, N_CHANNELS, s->shape, s->channel, &made, &s->table, &err);
    if (!status) status = ff_table_reduce(s->table, "mean", &s->grey, &err);
    s->options.weighting = s->robust.weighting = FF_WEIGHT_SAMPLE;
    if (!status) status = ff_problem_new(s->table, both, 2, &s->options, &s->problem, &err);
    for (int k = 0; k < 2 && !status; k++) status = ff_problem_fit(s->problem, both[k], &s->options, &s->fit[k], &err);
    if (!status) status = ff_problem_new(s->table, both, 2, &s->robust, &s->robust_problem, &err);
    if (!status) status = ff_problem_estimate_scale(s->robust_problem, s->model, &s->robust, &err);
    if (!status) status = ff_problem_fit(s->robust_problem, s->model, &s->robust, &s->robust_fit, &err);
    if (!status) status = ff_places_new(s->problem, s->table, &s->places, &err);
    if (!status) status = ff_interpolant_new(s->table, 0, &s->interpolant, &err);
    if (!status) status = ff_sampler_new(s->model, FF_ISA_BEST, N_CHANNELS, s->shape, s->channel, &s->sampler, &err);
    if (!status) status = ff_walk_new(s->model, N_CHANNELS, s->shape, s->channel, &walk, &s->walk, &err);
    if (!status) status = ff_picture_new(s->table, &s->options, &s->picture, &err);
    if (!status) status = ff_fit_adaptive(s->table, s->model, &s->options, &s->adaptive, &err);
    if (!status) status = ff_ndf_problem_new(s->table, &s->ndf_options, &s->ndf_problem, &err);
    if (!status) status = ff_ndf_retrieve(s->ndf_problem, &s->ndf_options, &s->ndf, &err);
    if (!status) status = ff_study_new(s->table, both, 1, &s->options, NULL, &s->study, &err);
    if (!status) s->n = ff_table_samples(s->table);
    ff_model_free(beckmann);
    return FF_CHECK(status == FF_OK, "the scene: %s", err.message);
}

static void scene_free(scene *s)
{
    ff_study_free(s->study);
    ff_ndf_result_free(s->ndf);
    ff_problem_free(s->ndf_problem);
    ff_adaptive_free(s->adaptive);
    ff_picture_free(s->picture);
    ff_walk_free(s->walk);
    ff_sampler_free(s->sampler);
    ff_interpolant_free(s->interpolant);
    ff_places_free(s->places);
    ff_fit_result_free(s->robust_fit);
    for (int k = 0; k < 2; k++) ff_fit_result_free(s->fit[k]);
    ff_problem_free(s->robust_problem);
    ff_problem_free(s->problem);
    ff_table_free(s->table);
    ff_table_free(s->grey);
    ff_noise_free(s->noise);
    ff_model_free(s->model);
}
#endif
