/* What is said of an optimum: values, errors, the ellipse, residuals, and the words that go with the numbers. */
#include "internal_result.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ff_result_warn(ff_fit_result *r, const char *fmt, ...)
{
    if (r->n_warnings == FF_MAX_WARNINGS) return;
    va_list args;
    va_start(args, fmt);
    vsnprintf(r->warning[r->n_warnings++], FF_WARNING_LENGTH, fmt, args);
    va_end(args);
}

void ff_result_label(const ff_layout *l, const struct ff_problem *p, size_t k, char *out, size_t size)
{
    size_t c;
    const char *name = ff_layout_param(l, k, &c)->name;
    if (k >= l->n_shared && l->n_channels > 1)
        snprintf(out, size, "%s (%.32s)", name, p->channel_name[c]);
    else
        snprintf(out, size, "%s", name);
}

static int is_of_channel(const ff_model *m, const ff_model_param *p)
{
    return p >= m->channel && p < m->channel + m->n_channel;
}

/* The parameter that others may follow. */
ff_fit_value *ff_result_value(const ff_layout *l, ff_fit_result *r, size_t k)
{
    size_t c;
    const ff_model_param *p = ff_layout_param(l, k, &c);
    return is_of_channel(l->m, p) ? &r->channel_value[c * l->m->n_channel + (size_t)(p - l->m->channel)]
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
        if (!ff_extras_prior(l->extras, (int)k, 0, &r->shape_value[k].prior_mean, &r->shape_value[k].prior_sd))
            r->shape_value[k].prior_mean = r->shape_value[k].prior_sd = NAN;
    for (uint32_t k = 0; k < l->m->n_channel; k++)
        for (size_t c = 0; c < l->n_channels; c++) {
            ff_fit_value *v = &r->channel_value[c * l->m->n_channel + k];
            if (!ff_extras_prior(l->extras, -1 - (int)k, c, &v->prior_mean, &v->prior_sd)) v->prior_mean = v->prior_sd = NAN;
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
        v->held = ff_layout_is_fixed(l, k);
        v->at_bound = v->held ? 0 : at_bound[k];
        if (v->held) ff_layout_range(l, k, &v->value, &v->value); /* not as rounded by the coordinate */
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
    if (!st) st = ff_condition_fill(l, p, normal, use, r);
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

/* Parameters of one channel (or the shape) that the data cannot tell apart. */
static void warn_correlated(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    char a[80], b[80];
    for (size_t i = 0; i < l->P; i++)
        for (size_t j = 0; j < i; j++) {
            const int x = ff_result_value(l, r, i)->column, y = ff_result_value(l, r, j)->column;
            if (x < 0 || y < 0) continue;
            const double c = r->correlation[(size_t)x * r->n_columns + (size_t)y];
            if (fabs(c) < 0.99) continue;
            ff_result_label(l, p, i, a, sizeof a);
            ff_result_label(l, p, j, b, sizeof b);
            ff_result_warn(r, "%s and %s are correlated by %.4f: these data hardly tell them apart", b, a, c);
        }
}

/* Is the bound one that the caller gave? */
static int is_given(const ff_model_param *p, int bound)
{
    return bound < 0 ? p->lo != p->info->lo : p->hi != p->info->hi;
}

static double bound_at(const ff_layout *l, size_t c, uint32_t k, int bound)
{
    return bound < 0 ? ff_layout_lo(l, c, k) : ff_layout_hi(l, c, k);
}

/* The channels whose parameter k lies on the bound that it has in `first`, which is one of them, into mark [n_channels]. */
static void mark_same_bound(const ff_layout *l, const ff_fit_result *r, uint32_t k, int bound, size_t first, unsigned char *mark)
{
    for (size_t c = 0; c < l->n_channels; c++) {
        const ff_fit_value *v = &r->channel_value[c * l->m->n_channel + k];
        mark[c] = v->at_bound == bound && !v->tied && bound_at(l, c, k, bound) == bound_at(l, first, k, bound);
    }
}

/* One warning for all channels whose parameter k lies on the same bound as in channel `first`, unless an earlier one does. */
static void warn_channels_at_bound(const ff_layout *l, const struct ff_problem *p, uint32_t k, int bound, size_t first,
                                   ff_fit_result *r)
{
    char names[120];
    const ff_fit_value *of_first = &r->channel_value[first * l->m->n_channel + k];
    if (of_first->at_bound != bound || of_first->tied) return;
    unsigned char *mark = malloc(l->n_channels + 1);
    int any = mark != NULL;
    if (any) mark_same_bound(l, r, k, bound, first, mark);
    for (size_t c = 0; c < first && any; c++) any = !mark[c];
    if (any) ff_channels_label(p, mark, names, sizeof names);
    free(mark);
    if (!any) return;
    const double value = of_first->value;
    const int several = l->n_channels > 1 && r->channel_value[l->m->n_channel + k].follows != -1 - (int)k; /* else one for all */
    const ff_param *info = l->m->channel[k].info;
    const int given = bound_at(l, first, k, bound) != (bound < 0 ? info->lo : info->hi);
    const int too_bright = bound > 0 && !given && (l->m->channel[k].info->flags & FF_PARAM_LINEAR);
    ff_result_warn(r, "%s%s%s%s is on %s %s bound, %g%s", l->m->channel[k].name, several ? " (" : "", several ? names : "",
                   several ? ")" : "", given ? "the given" : "its", bound < 0 ? "lower" : "upper", value,
                   too_bright ? "; are the data in 1/sr?" : "");
}

static void warn_dark_channels(const struct ff_problem *p, ff_fit_result *r)
{
    char names[120];
    unsigned char *mark = calloc(p->n_channels + 1, 1);
    int any = 0;
    for (size_t c = 0; c < p->n_channels && p->n_channels > 1 && mark; c++) {
        mark[c] = p->channel_mean[c] == 0;
        any |= mark[c];
        if (mark[c] && p->n_channels <= FF_CHANNELS_NAMED)
            ff_result_warn(r,
                           "channel %.64s is zero everywhere, which no lobe is: it pulls the shape of the others; --channels each "
                           "keeps them apart",
                           p->channel_name[c]);
    }
    if (any && p->n_channels > FF_CHANNELS_NAMED)
        ff_result_warn(r,
                       "channels that are zero everywhere (%s), which no lobe is, pull the shape of the others; --channels each "
                       "keeps them apart",
                       ff_channels_label(p, mark, names, sizeof names));
    free(mark);
}

static void fill_warnings(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    char label[80], text[FF_WARNING_LENGTH];
    const int many = l->arrow && l->n_channels > FF_CHANNELS_NAMED;
    if (r->outcome == FF_LIMIT)
        ff_result_warn(r, "stopped after %d iterations before it converged; --max-iterations allows more", r->iterations);
    if (r->outcome == FF_STALLED)
        ff_result_warn(r, "the solver found no step that lowers the objective; the parameters may not be the best ones");
    for (size_t k = 0; k < l->P; k++) {
        const ff_fit_value *v = ff_result_value(l, r, k);
        ff_result_label(l, p, k, label, sizeof label);
        const ff_model_param *param = ff_layout_param(l, k, NULL);
        if (!is_of_channel(l->m, param) && v->at_bound)
            ff_result_warn(r, "%s is on %s %s bound, %g", label, is_given(param, v->at_bound) ? "the given" : "its",
                           v->at_bound < 0 ? "lower" : "upper", v->value);
        if (many && is_of_channel(l->m, param)) continue; /* they are named together */
        if (!v->at_bound && !v->held && r->correlation && isnan(v->std_error))
            ff_result_warn(r, "%s is not determined by these data; --profile says how far it may go", label);
    }
    if (many && r->correlation) ff_result_warn_undetermined(l, p, r);
    for (uint32_t k = 0; k < l->m->n_channel; k++) {
        if (l->m->channel[k].flags & FF_PARAM_HELD) continue;
        for (int bound = -1; bound <= 1; bound += 2)
            for (size_t c = 0; c < l->n_channels; c++) warn_channels_at_bound(l, p, k, bound, c, r);
    }
    if (r->channel_correlation)
        ff_result_warn_channels_correlated(l, p, r);
    else if (r->correlation)
        warn_correlated(l, p, r);
    for (size_t k = 0; ff_extras_warning(l, p, r->residual.objective, k, text); k++) ff_result_warn(r, "%s", text);
    if (r->correlation && r->has_ellipse && !l->m->lobe[0].isotropic && l->mode != FF_ISOTROPIC_MODE && !r->ellipse.phi_determined)
        ff_result_warn(r, "the two roughness axes differ by less than their error: the orientation is undetermined");
    if (r->correlation && !r->correlation_settled)
        ff_result_warn(
            r,
            "the residuals go together over more than %zu neighbouring samples, as far as can be seen: the true errors are "
            "larger than the standard errors",
            r->correlated_over);
    if (p->selection.at_top)
        ff_result_warn(
            r, "%zu samples at different places share the largest value, %g: is the detector saturated? --saturation %g says so",
            p->selection.at_top, p->selection.top, p->selection.top);
    warn_dark_channels(p, r);
    if (p->selection.negative)
        ff_result_warn(r, "%zu of the samples have negative values; they are kept as noise", p->selection.negative);
    const size_t n = p->n * p->n_channels;
    if (p->selection.weighting == FF_WEIGHT_SIGMA && n > l->P) {
        const double chi2 = 2 * r->residual.objective / (double)(n - l->P);
        if (chi2 > 2 || chi2 < 0.5)
            ff_result_warn(
                r,
                "chi^2 per degree of freedom is %.3g: the standard deviations of the data do not match the residuals, and the "
                "standard errors follow them",
                chi2);
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
        fill_warnings(l, p, r);
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
    memset(r, 0, sizeof *r);
}
