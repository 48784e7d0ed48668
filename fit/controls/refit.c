/* A model as a material of a renderer. */
#include "internal_refit.h"
#include "simulate/simulate_struct.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the fit --------------------------------------------------------------------------------- */

static ff_status keep_values(const ff_model *m, size_t n_channels, const double *shape, const double *channel, ff_refit *out)
{
    out->model = *m;
    out->n_channels = n_channels;
    free(out->channel);
    out->channel = malloc((n_channels * m->n_channel + 1) * sizeof *out->channel);
    if (!out->channel) return FF_ERR_MEMORY;
    memcpy(out->shape, shape, m->n_shape * sizeof *shape);
    memcpy(out->channel, channel, n_channels * m->n_channel * sizeof *channel);
    return FF_OK;
}

static ff_status keep_fit(const ff_fit_result *fit, ff_refit *out)
{
    double shape[FF_MAX_SHAPE], *channel = malloc((fit->n_channels * fit->model.n_channel + 1) * sizeof *channel);
    if (!channel) return FF_ERR_MEMORY;
    ff_fit_result_values(fit, shape, channel);
    const ff_status status = keep_values(&fit->model, fit->n_channels, shape, channel, out);
    free(channel);
    return status;
}

/* Fits one material to the table; takes it when it is better than what is there. */
static ff_status try_material(const ff_material *m, const ff_table *t, const ff_fit_options *o, double *least, ff_refit *out,
                              ff_error *err)
{
    ff_model model;
    ff_problem *problem = NULL;
    ff_fit_result fit;
    ff_status status = ff_material_model(m, &model, err);
    if (status == FF_OK) status = ff_problem_make(t, &model, 1, o, &problem, err);
    if (status == FF_OK) status = ff_problem_fit_into(problem, &model, o, &fit, err);
    ff_problem_free(problem);
    if (status == FF_ERR_UNSUPPORTED) return FF_OK; /* the data have a direction that the material has not */
    if (status != FF_OK) return status;
    if (fit.residual.objective < *least) {
        *least = fit.residual.objective;
        out->material = m;
        status = keep_fit(&fit, out);
    }
    ff_fit_result_clear(&fit);
    return status;
}

static ff_status fit_materials(const ff_target *t, const ff_material *material, const ff_surface *s, ff_loss loss, int threads,
                               ff_refit *out, ff_error *err)
{
    ff_table table;
    ff_simulate_options simulate;
    ff_fit_options o;
    double least = INFINITY;
    ff_simulate_options_init(&simulate);
    ff_fit_options_init(&o);
    o.loss = loss;
    o.threads = threads;
    o.std_errors = 0;
    o.max_theta = 0.5 * 3.14159265358979323846; /* there is no noise that would speak against grazing angles */
    ff_status status = ff_simulate_into(s->model, s->n_channels, s->shape, s->channel, &simulate, &table, err);
    if (status != FF_OK) return status;
    for (size_t i = 0; i < t->n_materials && status == FF_OK; i++)
        if (!material || material == &t->material[i]) status = try_material(&t->material[i], &table, &o, &least, out, err);
    ff_table_clear(&table);
    if (status == FF_OK && !out->material)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "no material of %s can be fitted to this model", t->name);
    return status;
}

ff_status ff_refit_make(const ff_target *t, const ff_material *material, const ff_surface *s, ff_loss loss, int threads,
                        ff_refit *out, ff_error *err)
{
    ff_refit r = {.material = ff_material_of_model(t, s->model, s->n_channels, s->shape, s->channel)};
    r.is_own = r.material && (!material || material == r.material);
    ff_status status;
    if (r.is_own) {
        status = keep_values(s->model, s->n_channels, s->shape, s->channel, &r);
    } else {
        r.material = NULL;
        status = fit_materials(t, material, s, loss, threads, &r, err);
        if (status == FF_OK) status = ff_lost_find(s, r.material, &r.model, &r);
        const ff_surface made = {&r.model, r.n_channels, r.shape, r.channel};
        if (status == FF_OK) r.left = ff_surface_difference(s, &made);
    }
    if (status == FF_OK)
        *out = r;
    else
        ff_refit_clear(&r);
    return status == FF_ERR_MEMORY ? ff_error_set(err, status, NULL, 0, -1, "out of memory") : status;
}

void ff_refit_clear(ff_refit *r)
{
    free(r->channel);
    r->channel = NULL;
}
