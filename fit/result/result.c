/* What is said of an optimum: values, errors, the ellipse, residuals. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The parameter that others may follow. */
ff_fit_value *ff_result_value(const ff_layout *l, ff_fit_result *r, size_t k)
{
    size_t c;
    const ff_model_param *p = ff_layout_param(l, k, &c);
    return ff_param_is_of_channel(l->m, p) ? &r->channel_value[c * l->m->n_channel + (size_t)(p - l->m->channel)]
                                           : &r->shape_value[p - l->m->shape];
}

/* What follows another parameter is as that one is, but for what was said of it before. */
static void follow(ff_fit_value *v, const ff_fit_value *leader, int follows, size_t channel)
{
    const double mean = v->prior_mean, sd = v->prior_sd;
    *v = *leader;
    v->tied = 1;
    v->follows = follows;
    v->follows_channel = channel;
    v->prior_mean = mean;
    v->prior_sd = sd;
}

void ff_result_copy_tied(const ff_layout *l, ff_fit_result *r)
{
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        ff_fit_value *v = &r->shape_value[l->free.shape[k]];
        const uint32_t leader = l->free.shape[l->shape_follows[k] < 0 ? k : (uint32_t)l->shape_follows[k]];
        if (l->shape_follows[k] >= 0) follow(v, &r->shape_value[leader], (int)leader, 0);
        if (l->free.tied[k]) follow(v + 1, v, (int)leader, 0); /* alpha_y */
    }
    for (size_t c = 0; c < l->n_channels && l->tied; c++)
        for (uint32_t k = 0; k < l->free.n_channel; k++) {
            const uint32_t leader = l->channel_follows[k] < 0 ? k : (uint32_t)l->channel_follows[k];
            const size_t from = l->channel_shared[k] ? 0 : c;
            if (leader == k && from == c) continue;
            follow(&r->channel_value[c * l->m->n_channel + l->free.channel[k]],
                   &r->channel_value[from * l->m->n_channel + l->free.channel[leader]], -1 - (int)l->free.channel[leader], from);
        }
}

/* What was said before the data; of a follower it may be something else. */
static void fill_priors(const ff_layout *l, ff_fit_result *r)
{
    for (uint32_t k = 0; k < l->m->n_shape; k++)
        if (!ff_extras_prior(l->extras, (int)k, &r->shape_value[k].prior_mean, &r->shape_value[k].prior_sd))
            r->shape_value[k].prior_mean = r->shape_value[k].prior_sd = NAN;
    for (uint32_t k = 0; k < l->m->n_channel; k++)
        for (size_t c = 0; c < l->n_channels; c++) {
            ff_fit_value *v = &r->channel_value[c * l->m->n_channel + k];
            if (!ff_extras_prior(l->extras, -1 - (int)k, &v->prior_mean, &v->prior_sd)) v->prior_mean = v->prior_sd = NAN;
        }
    r->prior_penalty = ff_extras_penalty(l->extras);
}

static void fill_values(const ff_layout *l, const double *shape, const double *channel, const int *at_bound, ff_fit_result *r)
{
    for (uint32_t k = 0; k < l->m->n_shape; k++)
        r->shape_value[k] = (ff_fit_value){
            .value = shape[k], .std_error = NAN, .low = NAN, .high = NAN, .held = 1, .follows = FF_PARAM_NONE, .column = -1};
    for (size_t k = 0; k < l->n_channels * l->m->n_channel; k++)
        r->channel_value[k] = (ff_fit_value){
            .value = channel[k], .std_error = NAN, .low = NAN, .high = NAN, .held = 1, .follows = FF_PARAM_NONE, .column = -1};
    for (size_t k = 0; k < l->P; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        v->held = 0;
        v->at_bound = at_bound[k];
    }
    ff_result_copy_tied(l, r);
}

/* Standard errors, correlations and intervals of the parameters; cov [P][P] out. */
static ff_status fill_errors(const ff_layout *l, const struct ff_problem *p, const ff_normal *normal, const int *at_bound,
                             double *cov, ff_fit_result *r)
{
    const size_t P = l->P;
    int *use = malloc(P * sizeof *use + 1);
    ff_uncertainty u = {0};
    if (!use) return FF_ERR_MEMORY;
    for (size_t k = 0; k < P; k++) use[k] = at_bound[k] == 0;
    ff_status st = ff_uncertainty_new(l, p, normal, use, p->n, &u);
    size_t n = 0;
    for (size_t k = 0; k < P && !st; k++) {
        ff_fit_value *v = ff_result_value(l, r, k);
        if (!u.determined[k]) continue;
        v->std_error = sqrt(fmax(u.cov[k * P + k], 0)); /* rounding may leave -1e-30 where the residuals vanish */
        v->column = (int)n++;
    }
    if (!st) {
        memcpy(cov, u.cov, P * P * sizeof *cov);
        r->effective_samples = u.effective;
        r->correlated_over = u.clusters.run;
        r->correlation_settled = u.clusters.settled;
        st = ff_intervals_fill(l, p, normal, at_bound, &u, r);
    }
    if (!st) st = ff_condition_fill(l, normal, use, r);
    r->n_columns = n;
    r->correlation = st ? NULL : calloc(n * n + 1, sizeof *r->correlation);
    if (!st && !r->correlation) st = FF_ERR_MEMORY;
    for (size_t a = 0; a < P && !st; a++)
        for (size_t b = 0; b < P; b++) {
            const int i = ff_result_value(l, r, a)->column, j = ff_result_value(l, r, b)->column;
            if (i < 0 || j < 0) continue;
            const double scale = sqrt(cov[a * P + a] * cov[b * P + b]);
            r->correlation[(size_t)i * n + (size_t)j] = a == b ? 1 : scale > 0 ? cov[a * P + b] / scale : 0;
        }
    ff_result_copy_tied(l, r);
    ff_uncertainty_free(&u);
    free(use);
    return st;
}

/* The ellipse of the first lobe's slopes; with covariances, also whether its direction means anything. */
static void fill_ellipse(const ff_layout *l, const double *shape, const double *cov, size_t stride, ff_fit_result *r)
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
    if (!cov || m->lobe[0].isotropic || l->mode == FF_ISOTROPIC_MODE || !(D > 0)) return;
    /* gradients of d and e by alpha_x, alpha_y, r_xy, in the order of the free parameters */
    const double by[3][2] = {{2 * s.ax, 2 * s.r * s.ay}, {-2 * s.ay, 2 * s.r * s.ax}, {0, 2 * s.ax * s.ay}};
    double var_D = 0, var_phi = 0;
    for (uint32_t a = 0; a < l->free.n_shape; a++)
        for (uint32_t b = 0; b < l->free.n_shape; b++) {
            const uint32_t i = l->free.shape[a], j = l->free.shape[b];
            if (i > 2 || j > 2) continue;
            const double gDa = (d * by[i][0] + e * by[i][1]) / D, gDb = (d * by[j][0] + e * by[j][1]) / D;
            const double gpa = 0.5 * (d * by[i][1] - e * by[i][0]) / (D * D), gpb = 0.5 * (d * by[j][1] - e * by[j][0]) / (D * D);
            var_D += gDa * gDb * cov[l->shape_at[a] * stride + l->shape_at[b]];
            var_phi += gpa * gpb * cov[l->shape_at[a] * stride + l->shape_at[b]];
        }
    o->phi_determined = D > 2 * sqrt(fmax(var_D, 0));
    if (o->phi_determined) o->phi_std_error = sqrt(fmax(var_phi, 0));
}

static void fill_residual(const ff_normal *n, ff_fit_result *r)
{
    const double w = n->stat[FF_STAT_WEIGHT] > 0 ? n->stat[FF_STAT_WEIGHT] : 1;
    r->residual = (ff_residual){.objective = 0.5 * n->cost2,
                                .rmse = sqrt(n->stat[FF_STAT_PLAIN] / w),
                                .cosine_rmse = sqrt(n->stat[FF_STAT_COSINE] / w),
                                .log_rmse = sqrt(n->stat[FF_STAT_LOG] / w),
                                .cube_root_rmse = sqrt(n->stat[FF_STAT_CUBE_ROOT] / w),
                                .max_abs = n->stat[FF_STAT_MAX]};
}

static void fill_criteria(const struct ff_problem *p, size_t n_free, ff_fit_result *r)
{
    const double n = (double)(p->n * p->n_channels), q = 2 * r->residual.objective, k = (double)n_free;
    r->n_free = n_free;
    if (p->selection.weighting == FF_WEIGHT_SIGMA) {
        r->aic = q + 2 * k;
        r->bic = q + k * log(n);
    } else {
        const double likelihood = n * log(fmax(q / n, 1e-300));
        r->aic = likelihood + 2 * (k + 1);
        r->bic = likelihood + (k + 1) * log(n);
    }
}

ff_status ff_result_fill(const ff_layout *l, const struct ff_problem *p, const ff_fit_options *o, const double *shape,
                         const double *channel, const int *at_bound, const ff_solution *solution, ff_fit_result *r)
{
    const ff_arrow *arrow = solution->arrow;
    double *cov = calloc(l->arrow ? 1 : l->P * l->P + 1, sizeof *cov);
    ff_status st = cov ? FF_OK : FF_ERR_MEMORY;
    size_t n_free = 0;
    for (size_t k = 0; k < l->P; k++) n_free += at_bound[k] == 0;
    if (!st) {
        r->outcome = solution->outcome;
        r->iterations = solution->iterations;
        r->passes = solution->passes;
        fill_values(l, shape, channel, at_bound, r);
        fill_priors(l, r);
        fill_residual(&solution->normal, r);
        fill_criteria(p, n_free, r);
        if (o->std_errors)
            st = arrow ? ff_result_channel_errors(l, p, &solution->normal, at_bound, arrow, r)
                       : fill_errors(l, p, &solution->normal, at_bound, cov, r);
    }
    if (!st) {
        fill_ellipse(l, shape, !o->std_errors ? NULL : arrow ? arrow->shape : cov, arrow ? arrow->S : l->P, r);
        st = ff_result_warnings(l, p, r);
    }
    free(cov);
    return st;
}

void ff_fit_result_free(ff_fit_result *r)
{
    if (!r) return;
    free(r->shape_value);
    free(r->channel_value);
    free(r->correlation);
    free(r->channel_correlation);
    ff_warnings_free(&r->warnings);
    memset(r, 0, sizeof *r);
}
