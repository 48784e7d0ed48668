#include "internal_report.h"
#include <math.h>
#include <stdio.h>

const char *ff_report_key(const char *name, const char *channel, char out[FF_REPORT_KEY])
{
    if (!channel) return name;
    snprintf(out, FF_REPORT_KEY, "%s[%s]", name, channel);
    return out;
}

int ff_report_all_held(const ff_fit_result *f, uint32_t k)
{
    int held = 1;
    for (size_t c = 0; c < f->n_channels; c++) held &= f->channel_value[c * f->model.n_channel + k].held;
    return held;
}

double ff_report_degrees(double radians)
{
    const double degrees = radians * 180 / 3.14159265358979323846;
    return round(degrees * 1e9) / 1e9;
}

/* NaN, of a fit that never came to an end, goes last. */
static int better(const ff_fit_result *a, const ff_fit_result *b)
{
    return a->residual.objective < b->residual.objective || (!isnan(a->residual.objective) && isnan(b->residual.objective));
}

void ff_report_rank(const ff_report_fits *r, size_t p, size_t *rank)
{
    const size_t n = r->n_fits / r->n_problems;
    for (size_t i = 0; i < n; i++) {
        size_t at = i;
        for (; at > 0 && better(&r->fit[p * n + i], &r->fit[rank[at - 1]]); at--) rank[at] = rank[at - 1];
        rank[at] = p * n + i;
    }
}

const char *ff_report_channel_param(const ff_problem *p, const ff_fit_result *f, uint32_t k, size_t c, char out[FF_REPORT_NAME])
{
    if (f->n_channels == 1) {
        snprintf(out, FF_REPORT_NAME, "%s", f->model.channel[k].name);
    } else {
        snprintf(out, FF_REPORT_NAME, "%s[%s]", f->model.channel[k].name, ff_problem_channel_name(p, c));
    }
    return out;
}

const ff_model_param *ff_report_followed(const ff_fit_result *f, const ff_fit_value *v)
{
    return ff_model_param_at(&f->model, v->follows);
}

/* Has channel parameter k one value for all channels? */
static int is_shared(const ff_fit_result *f, uint32_t k)
{
    const ff_fit_value *v = &f->channel_value[(f->n_channels - 1) * f->model.n_channel + k];
    return f->n_channels > 1 && v->tied && v->follows_channel == 0;
}

const char *ff_report_column_name(const ff_problem *p, const ff_fit_result *f, size_t column, char out[FF_REPORT_NAME])
{
    for (uint32_t k = 0; k < f->model.n_shape; k++) {
        if (f->shape_value[k].tied || f->shape_value[k].column != (int)column) continue;
        snprintf(out, FF_REPORT_NAME, "%s", f->model.shape[k].name);
        return out;
    }
    for (size_t c = 0; c < f->n_channels; c++)
        for (uint32_t k = 0; k < f->model.n_channel; k++) {
            const ff_fit_value *v = &f->channel_value[c * f->model.n_channel + k];
            if (v->tied || v->column != (int)column) continue;
            if (!is_shared(f, k)) return ff_report_channel_param(p, f, k, c, out);
            snprintf(out, FF_REPORT_NAME, "%s", f->model.channel[k].name);
            return out;
        }
    snprintf(out, FF_REPORT_NAME, "column %zu", column);
    return out;
}
