#include "internal_report.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

void ff_report_rank(const ff_report_fits *r, size_t p, size_t *rank)
{
    const size_t n = r->n_fits / r->n_problems;
    ff_fits_rank(r->problem[p], r->fit + p * n, n, rank);
    for (size_t i = 0; i < n; i++) rank[i] += p * n;
}

ff_status ff_report_best_of_maskings(const ff_report_fits *r, size_t p, size_t **row, size_t *n)
{
    const size_t all = r->n_fits / r->n_problems;
    *row = malloc((all ? all : 1) * sizeof **row);
    *n = 0;
    if (!*row) return FF_ERR_MEMORY;
    ff_report_rank(r, p, *row);
    for (size_t i = 0; i < all; i++) {
        int seen = 0;
        for (size_t k = 0; k < *n; k++) seen |= r->fit[(*row)[k]].model.lobe[0].masking == r->fit[(*row)[i]].model.lobe[0].masking;
        if (!seen) (*row)[(*n)++] = (*row)[i];
    }
    return FF_OK;
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

/* ---- which is the answer --------------------------------------------------------------------- */

const ff_fit_result *ff_report_best(const ff_report_fits *r, size_t p)
{
    const size_t n = r->n_fits / r->n_problems;
    return &r->fit[p * n + ff_fits_best(r->problem[p], r->fit + p * n, n)];
}

const ff_versus *ff_report_versus(const ff_report_fits *r, const ff_fit_result *f)
{
    const ff_fit_trust *t = r->trust ? &r->trust[f - r->fit] : NULL;
    return t && t->has_versus ? &t->versus : NULL;
}

int ff_report_is_tied(const ff_report_fits *r, const ff_fit_result *f, const ff_fit_result *best)
{
    const ff_versus *v = ff_report_versus(r, f);
    return v && f != best && !v->told_apart;
}

const ff_fit_result *ff_report_simplest(const ff_report_fits *r, const ff_fit_result *best)
{
    const size_t models = r->n_fits / r->n_problems, first = (size_t)(best - r->fit) / models * models;
    const ff_fit_result *found = NULL;
    for (size_t i = first; i < first + models; i++) {
        const ff_fit_result *f = &r->fit[i];
        const ff_versus *v = ff_report_versus(r, f);
        if (v && f != best && isnan(v->vuong_p)) return best;
        if (!v || v->told_apart) continue;
        if (!found || f->n_free < found->n_free ||
            (f->n_free == found->n_free && f->residual.objective < found->residual.objective))
            found = f;
    }
    return found ? found : best;
}
