/* What a result should be taken with: how it ended, bounds, what the data do not determine or tell apart, samples that pull. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>

/* ---- of many channels ------------------------------------------------------------------------ */

/* Channels with the same trouble. */
typedef struct channels {
    size_t n, *at; /* [n] rising */
} channels;

static ff_status channels_new(const ff_fit_result *r, channels *out)
{
    *out = (channels){0, malloc((r->n_channels + 1) * sizeof *out->at)};
    return out->at ? FF_OK : FF_ERR_MEMORY;
}

/* Nothing where there are none. */
static ff_status say_of_channels(ff_warning_code code, const ff_warning_parameter *parameter, size_t n_parameters,
                                 const channels *c, const double *value, ff_fit_result *r)
{
    ff_warning w = {.code = code, .n_parameters = n_parameters, .n_channels = c->n, .parameter = parameter, .channel = c->at};
    for (size_t k = 0; value && k < FF_WARNING_VALUES && ff_warning_kind_of((int)code)->value[k]; k++) w.value[k] = value[k];
    return c->n ? ff_warnings_add(&r->warnings, &w) : FF_OK;
}

static ff_warning_parameter of_channel(uint32_t k)
{
    return (ff_warning_parameter){{FF_PARAM_CHANNEL, k}, FF_NO_CHANNEL};
}

/* ---- bounds ---------------------------------------------------------------------------------- */

/* Is the bound one that the caller gave? */
static int is_given(const ff_model_param *p, int bound)
{
    return bound < 0 ? p->lo != p->info->lo : p->hi != ff_param_box_end(p->info);
}

static ff_status warn_at_bound(const ff_layout *l, double reflects, size_t k, ff_fit_result *r)
{
    const ff_model_param *param = ff_layout_param(l, k, NULL);
    const ff_fit_value *v = ff_result_value(l, r, k);
    if (ff_is_of_channel(l->m, param) || !v->at_bound || v->weightless) return FF_OK; /* those of channels are named together */
    const double value[] = {v->value, v->at_bound, is_given(param, v->at_bound), reflects};
    return ff_layout_warn(l, k, FF_WARNING_AT_BOUND, value, &r->warnings);
}

static double bound_at(const ff_layout *l, size_t c, uint32_t k, int bound)
{
    return bound < 0 ? ff_layout_lo(l, c, k) : ff_layout_hi(l, c, k);
}

/* Is parameter k of channel c on the bound that it has in channel `first`? */
static int is_on_bound(const ff_layout *l, const ff_fit_result *r, uint32_t k, int bound, size_t first, size_t c)
{
    const ff_fit_value *v = &r->channel_value[c * l->m->n_channel + k];
    return v->at_bound == bound && !v->tied && !v->weightless && bound_at(l, c, k, bound) == bound_at(l, first, k, bound);
}

/* One warning for all channels whose parameter k lies on the same bound as in channel `first`, unless an earlier one does. */
static ff_status warn_channels_at_bound(const ff_layout *l, double reflects, uint32_t k, int bound, size_t first, ff_fit_result *r)
{
    const ff_warning_parameter parameter = of_channel(k);
    const ff_param *info = l->m->channel[k].info;
    const double value[] = {r->channel_value[first * l->m->n_channel + k].value, bound,
                            bound_at(l, first, k, bound) != (bound < 0 ? info->lo : ff_param_box_end(info)), reflects};
    channels on;
    if (!is_on_bound(l, r, k, bound, first, first)) return FF_OK;
    ff_status status = channels_new(r, &on);
    for (size_t c = 0; c < r->n_channels && !status; c++)
        if (is_on_bound(l, r, k, bound, first, c)) on.at[on.n++] = c;
    const int one_for_all = r->n_channels == 1 || ff_param_is(r->channel_value[l->m->n_channel + k].follows, parameter.parameter),
              said = !status && on.at[0] < first;
    const ff_warning w = {
        .code = FF_WARNING_AT_BOUND, .n_parameters = 1, .parameter = &parameter, .value = {value[0], value[1], value[2], value[3]}};
    if (!status && !said && one_for_all) status = ff_warnings_add(&r->warnings, &w);
    if (!status && !said && !one_for_all) status = say_of_channels(FF_WARNING_AT_BOUND, &parameter, 1, &on, value, r);
    free(on.at);
    return status;
}

/* ---- what the data say nothing of ------------------------------------------------------------ */

static int is_undetermined(const ff_fit_value *v)
{
    return v->weightless || (!v->at_bound && !v->held && isnan(v->std_error));
}

static ff_status warn_undetermined(const ff_layout *l, size_t k, ff_fit_result *r)
{
    const ff_fit_value *v = ff_result_value(l, r, k);
    const double weightless = v->weightless;
    if (!is_undetermined(v) || !r->correlation) return FF_OK;
    return ff_layout_warn(l, k, FF_WARNING_NOT_DETERMINED, &weightless, &r->warnings);
}

/* Index in the model of a channel's own coordinate k. */
static uint32_t own_index(const ff_layout *l, size_t k)
{
    return (uint32_t)(ff_layout_param(l, l->n_shared + k, NULL) - l->m->channel);
}

/* One warning for all channels whose own coordinate k is not determined, for one of two reasons. */
static ff_status warn_channels_undetermined(const ff_layout *l, size_t k, int weightless, ff_fit_result *r)
{
    const double reason = weightless;
    const ff_warning_parameter parameter = of_channel(own_index(l, k));
    channels in;
    ff_status status = channels_new(r, &in);
    for (size_t c = 0; c < r->n_channels && !status; c++) {
        const ff_fit_value *v = ff_result_value(l, r, l->n_shared + c * l->n_own + k);
        if (is_undetermined(v) && v->weightless == weightless) in.at[in.n++] = c;
    }
    if (!status) status = say_of_channels(FF_WARNING_NOT_DETERMINED, &parameter, 1, &in, &reason, r);
    free(in.at);
    return status;
}

/* ---- what the data do not tell apart --------------------------------------------------------- */

/* Can the data hardly tell parameters i and j apart, whose errors go together by so much? That they do is not enough: where all
 * noise is in one value every error is that one's, and yet each parameter has values of its own. */
static int hardly_apart(const ff_information *info, size_t i, size_t j, double correlation)
{
    const double scale = sqrt(info->inverse[i] * info->inverse[j]), by_weights = ff_information_inverse(info, i, j) / scale;
    return fabs(correlation) >= FF_CORRELATED && (isnan(by_weights) || fabs(by_weights) >= FF_CORRELATED);
}

static ff_status warn_pair(ff_warning_parameter a, ff_warning_parameter b, double correlation, ff_fit_result *r)
{
    const ff_warning_parameter pair[] = {a, b};
    return ff_warnings_add(
        &r->warnings, &(ff_warning){.code = FF_WARNING_CORRELATED, .n_parameters = 2, .parameter = pair, .value = {correlation}});
}

/* Pairs of the first n parameters. */
static ff_status warn_correlated(const ff_layout *l, const ff_information *info, size_t n, ff_fit_result *r)
{
    ff_status status = FF_OK;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i && !status; j++) {
            const int x = ff_result_value(l, r, i)->column, y = ff_result_value(l, r, j)->column;
            if (x < 0 || y < 0) continue;
            const double correlation = r->correlation[(size_t)x * r->n_columns + (size_t)y];
            if (hardly_apart(info, i, j, correlation))
                status = warn_pair(ff_layout_warned(l, j), ff_layout_warned(l, i), correlation, r);
        }
    return status;
}

/* One warning for all channels in which their own coordinate k goes with `with`, a shared one, or their own from n_shared on;
 * column is where its correlation stands. */
static ff_status warn_channels_pair(const ff_layout *l, const ff_information *info, size_t k, size_t with, size_t column,
                                    ff_fit_result *r)
{
    const uint32_t own = own_index(l, k);
    const ff_warning_parameter name = with < l->n_shared ? ff_layout_warned(l, with) : of_channel(own_index(l, with - l->n_shared));
    const size_t N = l->m->n_channel, width = r->n_columns + N;
    const ff_warning_parameter pair[] = {name, of_channel(own)};
    double most = 0;
    channels in;
    ff_status status = channels_new(r, &in);
    for (size_t c = 0; c < r->n_channels && !status; c++) {
        const double v = r->channel_correlation[(c * N + own) * width + column];
        const size_t of = c * l->n_own;
        if (!hardly_apart(info, l->n_shared + of + k, with < l->n_shared ? with : with + of, v)) continue;
        in.at[in.n++] = c;
        if (fabs(v) > fabs(most)) most = v;
    }
    if (!status) status = say_of_channels(FF_WARNING_CORRELATED, pair, 2, &in, &most, r);
    free(in.at);
    return status;
}

static ff_status warn_channels_correlated(const ff_layout *l, const ff_information *info, ff_fit_result *r)
{
    ff_status status = warn_correlated(l, info, l->n_shared, r);
    for (size_t k = 0; k < l->n_own; k++) {
        for (size_t j = 0; j < l->n_shared && !status; j++) {
            const ff_fit_value *v = ff_result_value(l, r, j);
            if (v->column >= 0) status = warn_channels_pair(l, info, k, j, (size_t)v->column, r);
        }
        for (size_t j = 0; j < k && !status; j++)
            status = warn_channels_pair(l, info, k, l->n_shared + j, r->n_columns + own_index(l, j), r);
    }
    return status;
}

/* ---- what few values carry -------------------------------------------------------------------- */

#define FEW 3.0
enum { FEW_NAMED = 12 };

/* One warning for all of them, those that the fewest carry first. */
static ff_status warn_of_few(const ff_layout *l, ff_weighting by, ff_fit_result *r)
{
    ff_warning_parameter named[FEW_NAMED];
    double number[FEW_NAMED], error = NAN;
    size_t n = 0;
    for (size_t k = 0; k < l->P; k++) {
        const ff_fit_value *v = ff_result_value(l, r, k);
        if (isnan(v->std_error) || !(v->carriers < FEW) || !(v->carriers > 0)) continue;
        size_t at = n < FEW_NAMED ? n++ : FEW_NAMED;
        for (; at > 0 && number[at - 1] > v->carriers; at--) {
            if (at == FEW_NAMED) continue;
            number[at] = number[at - 1];
            named[at] = named[at - 1];
        }
        if (at == FEW_NAMED) continue;
        number[at] = v->carriers;
        named[at] = ff_layout_warned(l, k);
        if (at == 0) error = v->residual_error;
    }
    const ff_warning w = {.code = FF_WARNING_FEW_CARRIERS,
                          .n_parameters = n,
                          .parameter = named,
                          .value = {n ? number[0] : 0, error, by == FF_WEIGHT_NOISE}};
    return n ? ff_warnings_add(&r->warnings, &w) : FF_OK;
}

/* ---- parameters ------------------------------------------------------------------------------ */

static ff_status warn_of_parameters(const ff_layout *l, const ff_information *info, double reflects, ff_fit_result *r)
{
    const int many = l->arrowhead && l->n_channels > FF_CHANNELS_NAMED;
    ff_status status = FF_OK;
    for (size_t k = 0; k < l->P && !status; k++) {
        status = warn_at_bound(l, reflects, k, r);
        if (many && ff_is_of_channel(l->m, ff_layout_param(l, k, NULL))) continue; /* they are named together */
        if (!status) status = warn_undetermined(l, k, r);
    }
    for (size_t k = 0; k < l->n_own && many && r->correlation; k++)
        for (int weightless = 0; weightless < 2 && !status; weightless++) status = warn_channels_undetermined(l, k, weightless, r);
    for (uint32_t k = 0; k < l->m->n_channel && !status; k++) {
        if (l->m->channel[k].flags & FF_PARAM_HELD) continue;
        for (int bound = -1; bound <= 1; bound += 2)
            for (size_t c = 0; c < l->n_channels && !status; c++) status = warn_channels_at_bound(l, reflects, k, bound, c, r);
    }
    if (status || !r->correlation) return status;
    if (!info) return FF_OK;
    return r->channel_correlation ? warn_channels_correlated(l, info, r) : warn_correlated(l, info, l->P, r);
}

/* ---- samples --------------------------------------------------------------------------------- */

static ff_status warn_of_dark_channels(const struct ff_problem *p, ff_fit_result *r)
{
    channels dark, one = {.n = 1};
    ff_status status = channels_new(r, &dark);
    for (size_t c = 0; c < p->n_channels && p->n_channels > 1 && !status; c++)
        if (p->channel_mean[c] == 0) dark.at[dark.n++] = c;
    if (!status && p->n_channels > FF_CHANNELS_NAMED) status = say_of_channels(FF_WARNING_DARK_CHANNEL, NULL, 0, &dark, NULL, r);
    for (size_t k = 0; k < dark.n && p->n_channels <= FF_CHANNELS_NAMED && !status; k++) {
        one.at = &dark.at[k];
        status = say_of_channels(FF_WARNING_DARK_CHANNEL, NULL, 0, &one, NULL, r);
    }
    free(dark.at);
    return status;
}

static ff_status warn_of_sigma(const ff_layout *l, const struct ff_problem *p, ff_fit_result *r)
{
    const size_t n = p->n * p->n_channels;
    if (p->selection.weighting != FF_WEIGHT_SIGMA || n <= l->P) return FF_OK;
    const double chi2 = 2 * r->residual.objective / (double)(n - l->P);
    return chi2 > 2 || chi2 < 0.5 ? ff_warnings_say(&r->warnings, FF_WARNING_SIGMA_MISMATCH, &chi2) : FF_OK;
}

static ff_status warn_of_samples(const struct ff_problem *p, ff_fit_result *r)
{
    const double run = (double)r->correlated_over, top[] = {(double)p->selection.at_top, p->selection.top},
                 negative = (double)p->selection.negative, copies = (double)p->selection.copies;
    ff_status status = copies > 0 ? ff_warnings_say(&r->warnings, FF_WARNING_COPIES, &copies) : FF_OK;
    if (!status && r->correlation && !r->correlation_settled)
        status = ff_warnings_say(&r->warnings, FF_WARNING_ERRORS_TOO_SMALL, &run);
    if (!status && p->selection.at_top) status = ff_warnings_say(&r->warnings, FF_WARNING_SATURATED, top);
    if (!status) status = warn_of_dark_channels(p, r);
    if (!status && negative > 0) status = ff_warnings_say(&r->warnings, FF_WARNING_NEGATIVE_VALUES, &negative);
    return status;
}

static ff_status warn_of_side(const struct ff_problem *p, ff_fit_result *r)
{
    const ff_side odd = ff_brightest_odd(&p->selection.brightest);
    const double value[] = {(double)p->selection.brightest.count[odd], (double)odd};
    return odd != FF_SIDE_NONE ? ff_warnings_say(&r->warnings, FF_WARNING_BRIGHTEST_ELSEWHERE, value) : FF_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static ff_status warn_of_outcome(ff_fit_result *r)
{
    const double iterations = r->iterations;
    if (r->outcome == FF_LIMIT) return ff_warnings_say(&r->warnings, FF_WARNING_ITERATION_LIMIT, &iterations);
    return r->outcome == FF_STALLED ? ff_warnings_say(&r->warnings, FF_WARNING_STALLED, NULL) : FF_OK;
}

ff_status ff_result_warnings(const ff_plan *plan, const ff_information *info, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    const struct ff_problem *p = plan->p;
    const int turns = r->correlation && r->has_ellipse && !l->m->lobe[0].isotropic && l->mode != FF_ISOTROPIC_MODE;
    ff_status status = warn_of_outcome(r);
    if (!status && ff_problem_is_dark(p)) status = ff_warnings_say(&r->warnings, FF_WARNING_NOTHING_TO_FIT, NULL);
    if (!status) status = warn_of_side(p, r);
    if (!status) status = warn_of_parameters(l, info, p->selection.brightest.reflects, r);
    if (!status) status = ff_penalties_warnings(plan, r->residual.objective, &r->warnings);
    if (!status && turns && !r->ellipse.phi_determined)
        status = ff_warnings_say(&r->warnings, FF_WARNING_ORIENTATION_NOT_DETERMINED, NULL);
    if (!status) status = warn_of_few(l, p->selection.weighting, r);
    if (!status && r->correlation) status = ff_result_warn_of_narrow_lobes(p, r);
    if (!status) status = warn_of_samples(p, r);
    return status ? status : warn_of_sigma(l, p, r);
}
