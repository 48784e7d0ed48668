/* Coordinates by the places of results, and as warnings name them. */
#include "internal_layout.h"

int ff_is_of_channel(const ff_model *m, const ff_model_param *p)
{
    return p >= m->channel && p < m->channel + m->n_channel;
}

/* The parameter that others may follow. */
ff_fit_value *ff_result_value(const ff_layout *l, ff_fit_result *r, size_t k)
{
    size_t c;
    const ff_model_param *p = ff_layout_param(l, k, &c);
    return ff_is_of_channel(l->m, p) ? &r->channel_value[c * l->m->n_channel + (size_t)(p - l->m->channel)]
                                     : &r->shape_value[p - l->m->shape];
}

/* What follows another parameter is as that one is, but for what was said of it before. */
static void follow(ff_fit_value *v, const ff_fit_value *leader, ff_param_ref follows, size_t channel)
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
        const ff_param_ref leader = {FF_PARAM_SHAPE, l->free.shape[l->shape_follows[k] < 0 ? k : (uint32_t)l->shape_follows[k]]};
        if (l->shape_follows[k] >= 0) follow(v, &r->shape_value[leader.index], leader, 0);
        if (l->free.tied[k]) follow(v + 1, v, leader, 0); /* alpha_y */
    }
    for (size_t c = 0; c < l->n_channels && l->tied; c++)
        for (uint32_t k = 0; k < l->free.n_channel; k++) {
            const uint32_t leader = l->channel_follows[k] < 0 ? k : (uint32_t)l->channel_follows[k];
            const size_t from = l->channel_shared[k] ? 0 : c;
            if (leader == k && from == c) continue;
            const ff_param_ref at = {FF_PARAM_CHANNEL, l->free.channel[leader]};
            follow(&r->channel_value[c * l->m->n_channel + l->free.channel[k]],
                   &r->channel_value[from * l->m->n_channel + at.index], at, from);
        }
}

/* ---- as a warning names them -------------------------------------------------------------------- */

ff_warning_parameter ff_layout_warned(const ff_layout *l, size_t k)
{
    size_t c;
    const ff_param_ref at = ff_model_param_ref(l->m, ff_layout_param(l, k, &c));
    return (ff_warning_parameter){at, k >= l->n_shared && l->n_channels > 1 ? c : FF_NO_CHANNEL};
}

ff_status ff_layout_warn(const ff_layout *l, size_t k, ff_warning_code code, const double *value, ff_warnings *out)
{
    ff_warning_parameter parameter = ff_layout_warned(l, k);
    const size_t channel = parameter.channel;
    ff_warning w = {.code = code, .n_parameters = 1, .parameter = &parameter};
    for (size_t i = 0; i < FF_WARNING_VALUES && ff_warning_kind_of((int)code)->value[i]; i++) w.value[i] = value[i];
    if (channel != FF_NO_CHANNEL) w.channel = &channel, w.n_channels = 1;
    parameter.channel = FF_NO_CHANNEL;
    return ff_warnings_add(out, &w);
}
