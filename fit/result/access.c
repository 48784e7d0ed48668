/* A result, read by name and place. */
#include "ff_fit.h"

const ff_fit_value *ff_fit_result_at(const ff_fit_result *r, ff_param_ref ref, size_t c)
{
    if (ref.kind == FF_PARAM_SHAPE && ref.index < r->model.n_shape) return &r->shape_value[ref.index];
    if (ref.kind == FF_PARAM_CHANNEL && ref.index < r->model.n_channel && c < r->n_channels)
        return &r->channel_value[c * r->model.n_channel + ref.index];
    return NULL;
}

const ff_fit_value *ff_fit_result_find(const ff_fit_result *r, const char *name, size_t c)
{
    return ff_fit_result_at(r, ff_model_param_find(&r->model, name), c);
}
