#include "internal_report.h"
#include <math.h>
#include <stdio.h>
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

/* What fits are ranked by: the objective, or 0 where the fit leaves nothing but rounding. */
static double rank_objective(const ff_report_fits *r, size_t i)
{
    const ff_problem *p = r->problem[i / (r->n_fits / r->n_problems)];
    const ff_residual *left = &r->fit[i].residual;
    return left->rmse <= FF_REPORT_TIE * fabs(ff_problem_selected(p)->top) ? 0 : left->objective;
}

/* NaN, of a fit that never came to an end, goes last. */
static int is_better(const ff_report_fits *r, size_t i, size_t k)
{
    const double a = rank_objective(r, i), b = rank_objective(r, k);
    return a < b || (!isnan(a) && isnan(b));
}

/* Numbers that the fit could move, those that ended on a bound among them. */
static size_t count_parameters(const ff_fit_result *f)
{
    size_t n = 0;
    for (size_t k = 0; k < f->model.n_shape; k++) n += !f->shape_value[k].held && !f->shape_value[k].tied;
    for (size_t k = 0; k < f->n_channels * f->model.n_channel; k++) n += !f->channel_value[k].held && !f->channel_value[k].tied;
    return n;
}

/* Of two whose objectives are equal but for rounding: fewer parameters, then the name. */
static int is_simpler(const ff_report_fits *r, size_t i, size_t k)
{
    const size_t n[2] = {count_parameters(&r->fit[i]), count_parameters(&r->fit[k])};
    char name[2][FF_MODEL_NAME];
    if (n[0] != n[1]) return n[0] < n[1];
    ff_model_expression(&r->fit[i].model, name[0], FF_MODEL_NAME);
    ff_model_expression(&r->fit[k].model, name[1], FF_MODEL_NAME);
    return strcmp(name[0], name[1]) < 0;
}

/* What is neither before the other keeps its order. */
static void sort(const ff_report_fits *r, size_t *rank, size_t n, int (*is_before)(const ff_report_fits *, size_t, size_t))
{
    for (size_t i = 1; i < n; i++) {
        const size_t one = rank[i];
        size_t at = i;
        for (; at > 0 && is_before(r, one, rank[at - 1]); at--) rank[at] = rank[at - 1];
        rank[at] = one;
    }
}

/* How many of the sorted fits from the first on are tied with it; 1 of a fit that never came to an end. */
static size_t count_tied(const ff_report_fits *r, const size_t *rank, size_t n)
{
    const double most = rank_objective(r, rank[0]) * (1 + FF_REPORT_TIE);
    size_t tied = 1;
    while (tied < n && rank_objective(r, rank[tied]) <= most) tied++;
    return tied;
}

void ff_report_rank(const ff_report_fits *r, size_t p, size_t *rank)
{
    const size_t n = r->n_fits / r->n_problems;
    for (size_t i = 0; i < n; i++) rank[i] = p * n + i;
    sort(r, rank, n, is_better);
    for (size_t i = 0, tied; i < n; i += tied) {
        tied = count_tied(r, rank + i, n - i);
        sort(r, rank + i, tied, is_simpler);
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

/* ---- which is the answer --------------------------------------------------------------------- */

const ff_fit_result *ff_report_best(const ff_report_fits *r, size_t p)
{
    const size_t models = r->n_fits / r->n_problems;
    size_t best = p * models;
    for (size_t i = best + 1; i < (p + 1) * models; i++) {
        const double least = rank_objective(r, best), own = rank_objective(r, i);
        const int tied = own <= least * (1 + FF_REPORT_TIE) && least <= own * (1 + FF_REPORT_TIE);
        if (tied ? is_simpler(r, i, best) : is_better(r, i, best)) best = i;
    }
    return &r->fit[best];
}

const ff_versus *ff_report_versus(const ff_report_fits *r, const ff_fit_result *f)
{
    const ff_report_trust *t = r->trust ? &r->trust[f - r->fit] : NULL;
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
