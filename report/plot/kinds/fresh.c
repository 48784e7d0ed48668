/* Parameters of a fit of this run, by name. */
#include "internal_fresh.h"
#include <stdio.h>
#include <string.h>

typedef struct list {
    const ff_plot_subject *s;
    size_t most, n;
    ff_plot_number *out;
    char known[400];
} list;

static void add(list *l, ff_param_ref ref, size_t channel, int wanted, const char *names)
{
    const ff_fit_result *fit = l->s->fit;
    const ff_model_param *p = ff_model_param_at(&fit->model, ref);
    const ff_fit_value *v = ff_fit_result_at(fit, ref, channel);
    ff_plot_number one = {.ref = ref, .channel = channel, .unit = p->info->unit, .value = v};
    if (!v || v->held || v->tied) return;
    if (ref.kind == FF_PARAM_CHANNEL && fit->n_channels > 1)
        snprintf(one.name, sizeof one.name, "%s[%s]", p->name, ff_problem_channel_name(l->s->problem, channel));
    else
        snprintf(one.name, sizeof one.name, "%s", p->name);
    if (strlen(l->known) + strlen(one.name) + 3 < sizeof l->known)
        snprintf(l->known + strlen(l->known), sizeof l->known - strlen(l->known), "%s%s", *l->known ? ", " : "", one.name);
    if ((names ? ff_plot_names(names, one.name) : wanted) && l->n < l->most) l->out[l->n++] = one;
}

ff_status ff_plot_numbers(const ff_plot_subject *s, const ff_plot_choice *c, size_t most, ff_plot_number *out, size_t *n,
                          ff_error *err)
{
    const ff_fit_result *fit = s->fit;
    list l = {.s = s, .most = most, .out = out};
    ff_plot_channel channel[FF_PLOT_LIST];
    size_t n_channels;
    const ff_status status = ff_plot_channels(&s->model[0], NULL, c->channel, channel, &n_channels, err);
    if (status) return status;
    for (uint32_t k = 0; k < fit->model.n_shape; k++) add(&l, (ff_param_ref){FF_PARAM_SHAPE, k}, 0, 1, c->parameter);
    for (size_t i = 0; i < fit->n_channels; i++) {
        int wanted = 0;
        for (size_t k = 0; k < n_channels; k++) wanted |= channel[k].of_model == i;
        for (uint32_t k = 0; k < fit->model.n_channel; k++) add(&l, (ff_param_ref){FF_PARAM_CHANNEL, k}, i, wanted, c->parameter);
    }
    *n = l.n;
    if (l.n) return FF_OK;
    if (!*l.known) return ff_error_set(err, FF_ERR_DATA, NULL, 0, -1, "the fit has no free parameter");
    return ff_error_set(err, FF_ERR_UNKNOWN, NULL, 0, -1, "no free parameter '%.200s'; there are: %s",
                        c->parameter ? c->parameter : "", l.known);
}
