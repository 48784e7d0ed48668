/* Parameters as a warning names them. */
#include "internal_problem.h"

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
