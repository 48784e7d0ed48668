/* From the request to the plan: names, constraints and defaults are resolved here, once, and nowhere after it. */
#include "fit/losses/robust/internal_robust.h"
#include "internal_problem.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What the options say of how a fit is made, whatever its model. */
static void take_options(const ff_fit_options *o, ff_plan *plan)
{
    plan->robust = o->robust;
    plan->robust_scale = o->robust_scale > 0 ? o->robust_scale : ff_robust_tuning(o->robust);
    plan->errors = o->std_errors;
    plan->by_residuals = o->errors == FF_ERRORS_RESIDUALS;
    plan->noise = o->noise;
    plan->max_iterations = o->max_iterations;
    plan->cancel = o->cancel;
    plan->progress = o->progress;
    plan->progress_context = o->progress_context;
    plan->start_shape = o->start_shape;
    plan->start_channel = o->start_channel;
    plan->bounded = o->constraints != NULL;
}

ff_plan ff_plan_with(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o)
{
    ff_plan plan = {.l = *l, .p = p, .shape = o->shape};
    take_options(o, &plan);
    return plan;
}

ff_plan ff_plan_of_channels(const ff_plan *plan)
{
    ff_plan channels = *plan;
    channels.l = ff_layout_of_channels(&plan->l);
    return channels;
}

/* Has the problem what the model needs, and the model its tables? */
static ff_status check_model(const ff_plan *plan, ff_error *err)
{
    const ff_model *m = plan->model;
    uint32_t have = 0;
    for (int k = 0; k < FF_G_COUNT; k++)
        if (plan->p->geometry[k] >= 0) have |= 1u << k;
    const uint32_t need = ff_model_planes(m, plan->l.mode);
    if ((need & have) != need)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "the problem was not made for this model and shape: name them to ff_problem_new");
    for (uint32_t k = 0; k < m->n_lobes; k++)
        if (ff_ndf_at(m->lobe[k].ndf)->needs_values && !m->lobe[k].table)
            return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s needs the table of its profile",
                                ff_ndf_at(m->lobe[k].ndf)->term.name);
    return FF_OK;
}

static ff_status check_numbers(const ff_plan *plan, ff_error *err)
{
    const struct ff_problem *p = plan->p;
    const size_t levels = plan->noise ? ff_noise_level_count(plan->noise) : 1;
    if (levels != 1 && levels != p->n_channels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1,
                            "a noise model has one level, or one for each of the %zu channels that are fitted; found %zu",
                            p->n_channels, levels);
    if (p->n * p->n_channels < plan->l.P) {
        const size_t left_out = p->selection.samples - p->selection.used;
        char others[64] = "";
        if (left_out) snprintf(others, sizeof others, "; %zu others are left out", left_out);
        return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1,
                            "%zu values (%zu samples of %zu channels%s) cannot determine %zu parameters", p->n * p->n_channels,
                            p->n, p->n_channels, others, plan->l.P);
    }
    if ((plan->start_shape == NULL) != (plan->start_channel == NULL))
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a start needs both its shape and its channel parameters");
    if (!plan->start_shape) return FF_OK;
    return ff_model_check(plan->model, plan->l.n_channels, plan->start_shape, plan->start_channel, err);
}

/* A copy of the plan's own, to be changed. It is by far the largest part of a plan, and plans are copied. */
static ff_status take_model(const ff_model *m, ff_plan *plan, ff_error *err)
{
    plan->model = malloc(sizeof *plan->model);
    if (!plan->model) return ff_error_set(err, FF_ERR_MEMORY, NULL, 0, -1, "out of memory");
    *plan->model = *m;
    return FF_OK;
}

/* Bounds, what is held, coordinates and ties; where channels differ. */
static ff_status lay_out(const ff_fit_options *o, size_t n_channels, ff_plan *plan, ff_error *err)
{
    ff_ties ties;
    ff_status status = ff_constraints_apply(o->constraints, plan->shape, plan->model, &ties, err);
    if (!status) status = ff_layout_init(plan->model, n_channels, plan->shape, o->mean_slope, &plan->l, err);
    if (!status && ties.n) ff_layout_tie(&plan->l, &ties);
    if (!status) status = ff_limits_of(o->constraints, plan->p, plan->model, &ties, &plan->own_limits, err);
    if (!status) plan->l.limits = plan->own_limits;
    return status;
}

ff_status ff_plan_new(const struct ff_problem *p, const ff_model *m, const ff_fit_options *o, ff_plan *out, ff_error *err)
{
    ff_status status = ff_fit_options_check(o, err);
    if (status) return status;
    *out = (ff_plan){.p = p, .shape = ff_layout_shape(m, p->selection.isotropic, o->shape, o->mean_slope)};
    take_options(o, out);
    status = take_model(m, out, err);
    if (!status) status = lay_out(o, p->n_channels, out, err);
    if (!status) status = check_model(out, err);
    if (!status) status = check_numbers(out, err);
    if (!status) status = ff_penalties_new(o->constraints, &out->l, p, out->shape, &out->own_penalties, err);
    if (status) {
        ff_plan_free(out);
        return status;
    }
    out->penalties = out->own_penalties;
    out->errors |= out->penalties != NULL; /* the weight of a prior needs the errors of the data */
    out->l.arrowhead = ff_layout_is_arrowhead(&out->l, o->dense_channels);
    return FF_OK;
}

void ff_plan_free(ff_plan *plan)
{
    ff_penalties_free(plan->own_penalties);
    ff_limits_free(plan->own_limits);
    free(plan->model);
    plan->model = NULL;
    plan->own_penalties = NULL;
    plan->own_limits = NULL;
    plan->penalties = NULL;
}

ff_status ff_plan_of_result(const struct ff_problem *p, const ff_fit_options *o, const ff_fit_result *fit, ff_plan *out,
                            ff_error *err)
{
    if (fit->n_channels != p->n_channels)
        return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "a fit of %zu channels does not belong to a problem of %zu",
                            fit->n_channels, p->n_channels);
    if (o->robust != FF_ROBUST_NONE && o->robust_scale == 0 && !p->unit)
        return ff_error_set(
            err, FF_ERR_RANGE, NULL, 0, -1,
            "the scale of the robust loss is that of one fit alone: ff_problem_estimate_scale makes it the problem's");
    *out = (ff_plan){.p = p, .shape = fit->shape};
    take_options(o, out);
    out->errors = 1; /* whoever asks for a finished fit asks for them */
    ff_status status = take_model(&fit->model, out, err);
    if (!status) status = lay_out(o, fit->n_channels, out, err);
    if (!status) status = check_model(out, err);
    if (status) ff_plan_free(out);
    return status;
}

ff_status ff_plan_pass(const ff_plan *plan, const double *shape, const double *channel, ff_pass *pass)
{
    const struct ff_problem *p = plan->p;
    const ff_layout *l = &plan->l;
    pass->p = p;
    pass->robust = p->linearised ? FF_ROBUST_NONE : plan->robust;
    pass->robust_scale = plan->robust_scale;
    pass->deviation = NULL;
    pass->final = 0;
    pass->errors = plan->errors;
    pass->levels = plan->levels;
    pass->averaging = ff_plan_averages(plan) ? malloc(sizeof *pass->averaging) : NULL;
    if (ff_plan_averages(plan) && !pass->averaging) return FF_ERR_MEMORY;
    const ff_status status = ff_prepare(l->m, ff_kernels_get(p->isa), l->mode, l->n_channels, shape, channel, &l->free, p->tan2_lo,
                                        p->tan2_hi, &pass->prepared);
    if (pass->averaging && !status)
        ff_averaging_make(p->rules, &pass->prepared, plan->levels ? &plan->levels->needles : NULL, pass->averaging);
    if (status) free(pass->averaging);
    return status;
}

void ff_pass_free(ff_pass *pass)
{
    free(pass->averaging);
    ff_prepared_free(&pass->prepared);
}
