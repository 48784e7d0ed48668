/* What is said of an optimum: values, errors, the ellipse, residuals. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What was said before the data; of a follower it may be something else. */
static void fill_priors(const ff_plan *plan, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    for (uint32_t k = 0; k < l->m->n_shape; k++)
        if (!ff_penalties_prior(plan->penalties, (ff_param_ref){FF_PARAM_SHAPE, k}, 0, &r->shape_value[k].prior_mean,
                                &r->shape_value[k].prior_sd))
            r->shape_value[k].prior_mean = r->shape_value[k].prior_sd = NAN;
    for (uint32_t k = 0; k < l->m->n_channel; k++)
        for (size_t c = 0; c < l->n_channels; c++) {
            ff_fit_value *v = &r->channel_value[c * l->m->n_channel + k];
            if (!ff_penalties_prior(plan->penalties, (ff_param_ref){FF_PARAM_CHANNEL, k}, c, &v->prior_mean, &v->prior_sd))
                v->prior_mean = v->prior_sd = NAN;
        }
    r->prior_penalty = ff_penalties_penalty(plan->penalties);
}

/* A number of which nothing else is known. */
static ff_fit_value value_alone(double value)
{
    return (ff_fit_value){
        .value = value, .std_error = NAN, .low = NAN, .high = NAN, .held = 1, .column = -1, .carriers = NAN, .residual_error = NAN};
}

static void fill_values(const ff_layout *l, const ff_point *at, ff_fit_result *r)
{
    for (uint32_t k = 0; k < l->m->n_shape; k++) r->shape_value[k] = value_alone(at->shape[k]);
    for (size_t k = 0; k < l->n_channels * l->m->n_channel; k++) r->channel_value[k] = value_alone(at->channel[k]);
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        v->held = ff_layout_is_fixed(l, k);
        v->at_bound = v->held ? 0 : at->at_bound[k];
        if (v->held) ff_layout_range(l, k, &v->value, &v->value); /* not as rounded by the coordinate */
    }
    ff_result_copy_tied(l, r);
}

/* The ellipse of the first lobe's slopes; with covariances, also whether its direction means anything. */
static void fill_ellipse(const ff_layout *l, const double *shape, const ff_information *info, ff_fit_result *r)
{
    const ff_model *m = l->m;
    if (m->n_lobes == 0 || ff_ndf_at(m->lobe[0].ndf)->alpha_own != 0) return;
    ff_lobe_pass pass;
    ff_model_lobe(m, 0, shape, &pass, NULL);
    const ff_stretch s = pass.s;
    const double xx = s.ax * s.ax, yy = s.ay * s.ay, xy = s.r * s.ax * s.ay, d = xx - yy, e = 2 * xy, D = hypot(d, e), T = xx + yy;
    ff_ellipse *o = &r->ellipse;
    r->has_ellipse = 1;
    o->alpha_major = sqrt(0.5 * (T + D));
    o->alpha_minor = D < T ? sqrt((xx * yy - xy * xy) / (0.5 * (T + D))) : 0;
    o->phi = D > 0 ? 0.5 * atan2(e, d) : 0;
    if (o->phi < 0) o->phi += 3.14159265358979323846;
    o->phi_std_error = NAN;
    o->phi_determined = 0;
    if (!info || m->lobe[0].isotropic || l->mode == FF_ISOTROPIC_MODE || !(D > 0)) return;
    /* gradients of d and e by alpha_x, alpha_y, r_xy, in the order of the free parameters */
    const double by[3][2] = {{2 * s.ax, 2 * s.r * s.ay}, {-2 * s.ay, 2 * s.r * s.ax}, {0, 2 * s.ax * s.ay}};
    double var_D = 0, var_phi = 0;
    for (uint32_t a = 0; a < l->free.n_shape; a++)
        for (uint32_t b = 0; b < l->free.n_shape; b++) {
            const uint32_t i = l->free.shape[a], j = l->free.shape[b];
            if (i > 2 || j > 2) continue;
            const double gDa = (d * by[i][0] + e * by[i][1]) / D, gDb = (d * by[j][0] + e * by[j][1]) / D;
            const double gpa = 0.5 * (d * by[i][1] - e * by[i][0]) / (D * D), gpb = 0.5 * (d * by[j][1] - e * by[j][0]) / (D * D);
            const double cov = ff_information_covariance(info, l->shape_at[a], l->shape_at[b]);
            var_D += gDa * gDb * cov;
            var_phi += gpa * gpb * cov;
        }
    o->phi_determined = D > 2 * sqrt(fmax(var_D, 0));
    if (o->phi_determined) o->phi_std_error = sqrt(fmax(var_phi, 0));
}

static void fill_residual(const ff_normal *n, ff_fit_result *r)
{
    const double w = n->stat[FF_STAT_WEIGHT] > 0 ? n->stat[FF_STAT_WEIGHT] : 1;
    r->residual =
        (ff_residual){.objective = 0.5 * n->cost2, .rmse = sqrt(n->stat[FF_STAT_PLAIN] / w), .max_abs = n->stat[FF_STAT_MAX]};
    double *of = r->residual.loss_rmse;
    for (int loss = 0; loss < FF_LOSS_COUNT; loss++)
        of[loss] = ff_loss_at(loss)->rmse_unit ? sqrt(n->stat[FF_STAT_LOSS + loss] / w) : NAN;
    r->residual.cosine_rmse = of[FF_LOSS_COSINE];
    r->residual.log_rmse = of[FF_LOSS_LOG];
    r->residual.cube_root_rmse = of[FF_LOSS_CUBE_ROOT];
}

static void fill_criteria(const struct ff_problem *p, size_t n_free, ff_fit_result *r)
{
    const double n = (double)(p->n * p->n_channels), q = 2 * r->residual.objective, k = (double)n_free;
    r->n_free = n_free;
    if (p->selection.weighting == FF_WEIGHT_SIGMA || p->selection.weighting == FF_WEIGHT_NOISE) {
        r->aic = q + 2 * k;
        r->bic = q + k * log(n);
    } else {
        const double likelihood = n * log(fmax(q / n, 1e-300));
        r->aic = likelihood + 2 * (k + 1);
        r->bic = likelihood + (k + 1) * log(n);
    }
}

/* What it took to come there, and what is left. */
static void fill_outcome(const ff_plan *plan, const ff_point *at, ff_fit_result *r)
{
    size_t n_free = 0;
    for (size_t k = 0; k < plan->l.P; k++) n_free += at->at_bound[k] == 0;
    r->outcome = at->outcome;
    r->iterations = at->iterations;
    r->passes = at->passes;
    fill_residual(&at->normal, r);
    fill_criteria(plan->p, n_free, r);
}

ff_status ff_result_fill(const ff_plan *plan, ff_point *at, int errors, ff_fit_result *r)
{
    fill_outcome(plan, at, r);
    fill_values(&plan->l, at, r);
    fill_priors(plan, r);
    const ff_status status = errors ? ff_result_errors(plan, at, r) : FF_OK;
    if (status) return status;
    fill_ellipse(&plan->l, at->shape, errors ? at->information : NULL, r);
    return ff_result_warnings(plan, errors ? at->information : NULL, r);
}

ff_status ff_result_new(const ff_plan *plan, ff_fit_result *out)
{
    const ff_layout *l = &plan->l;
    ff_fit_result r = {.model = *plan->model, .n_channels = l->n_channels, .shape = plan->shape};
    r.shape_value = calloc(l->m->n_shape + 1, sizeof *r.shape_value);
    r.channel_value = calloc(l->n_channels * l->m->n_channel + 1, sizeof *r.channel_value);
    if (!r.shape_value || !r.channel_value) {
        ff_fit_result_clear(&r);
        return FF_ERR_MEMORY;
    }
    *out = r;
    return FF_OK;
}

void ff_fit_result_clear(ff_fit_result *r)
{
    if (!r) return;
    free(r->shape_value);
    free(r->channel_value);
    free(r->correlation);
    free(r->channel_correlation);
    free(r->noise);
    ff_warnings_clear(&r->warnings);
    memset(r, 0, sizeof *r);
}
