/* Where the minimisation over all samples began. The search is gone through once more: the same data give the same start. */
#include "fit/start/internal_start.h"
#include "internal_html.h"

static void put_values(ff_json *j, const ff_model *m, size_t n_channels, const ff_point *at)
{
    for (uint32_t k = 0; k < m->n_shape; k++) {
        ff_json_array(j, m->shape[k].name, FF_JSON_LINE);
        ff_json_number(j, NULL, ff_page_rounded(at->shape[k], 6));
        ff_json_close(j);
    }
    for (uint32_t k = 0; k < m->n_channel; k++) {
        ff_json_array(j, m->channel[k].name, FF_JSON_LINE);
        for (size_t c = 0; c < n_channels; c++) ff_json_number(j, NULL, ff_page_rounded(at->channel[c * m->n_channel + k], 6));
        ff_json_close(j);
    }
}

/* Not known where the options alone do not lead to it: weights by the noise, which a first fit has found. */
ff_status ff_html_start_json(ff_json *j, const ff_html_subject *s)
{
    const ff_fit_result *fit = &s->r->fit[s->shown];
    const ff_problem *p = s->r->problem[s->shown / s->models];
    ff_fit_options o = *s->r->options;
    ff_plan plan;
    ff_point at;
    ff_error reason = {0};
    o.progress = NULL;
    if (o.channels == FF_CHANNELS_EACH) o.channels = FF_CHANNELS_RGB, o.only_channel = (int)(s->shown / s->models);
    if (o.weighting == FF_WEIGHT_NOISE) return FF_OK;
    ff_status status = ff_plan_new(p, &fit->model, &o, &plan, &reason);
    if (status) return status == FF_ERR_MEMORY ? status : FF_OK;
    status = ff_point_new(&plan, &at);
    if (!status) {
        status = ff_start(&plan, &at, &reason);
        if (!status) {
            ff_json_object(j, "start", FF_JSON_LINE);
            put_values(j, &fit->model, fit->n_channels, &at);
            ff_json_close(j);
        }
        ff_point_free(&at);
    }
    ff_plan_free(&plan);
    return status == FF_ERR_MEMORY ? status : FF_OK;
}
