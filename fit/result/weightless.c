/* Which parameters have nothing to act on: those of a lobe or of a base that adds nothing to the model at the optimum.
 *
 * A lobe whose ks or whose F0 is 0 leaves its roughness without a meaning. What Schlick's rise towards grazing incidence still adds
 * then is no sign of a lobe, as long as it is little: it is there whatever the data say. And of data that are 0 everywhere nothing
 * has a meaning but that. */
#include "internal_result.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RISE    0.01  /* share of the data, root mean square, up to which the rise of a lobe without F0 counts as nothing */
#define NOTHING 1e-12 /* reflectance that is 0 but for rounding, of data of that size */

/* ---- the weight of a term in a channel -------------------------------------------------------- */

/* What is 0 but for rounding: data may be in units in which all reflectances are small. */
static double nothing_in(const ff_plan *plan, size_t c)
{
    return NOTHING * fmin(1, plan->p->channel_mean[c]);
}

/* Fresnel reflectance of lobe l at normal incidence in channel c. */
static double normal_reflectance(const ff_plan *plan, const ff_point *at, uint32_t l, size_t c)
{
    const double zero = 0, one = 1;
    const ff_dirs up = {&zero, &zero, &one, &zero, &zero, &one};
    double fresnel = 1;
    const ff_terms out = {.fresnel = &fresnel};
    const ff_status status =
        ff_model_terms(plan->l.m, plan->p->isa, plan->l.n_channels, at->shape, at->channel, l, c, &up, 1, &out);
    return status ? 1 : fresnel;
}

/* The lobe whose Fresnel term and scale lobe l has. */
static uint32_t leader_of(const ff_model *m, uint32_t l)
{
    return m->lobe[l].fresnel == FF_FRESNEL_SHARED ? 0 : l;
}

static int lobe_is_off(const ff_plan *plan, const ff_point *at, uint32_t l, size_t c)
{
    const ff_model *m = plan->l.m;
    const ff_lobe *leader = &m->lobe[leader_of(m, l)];
    const double *own = at->channel + c * m->n_channel;
    double weight[FF_MAX_LOBES];
    ff_model_weights(m, at->shape, weight, NULL);
    const double scale = weight[l] * own[leader->channel0 + leader->n_channel - 1];
    return fabs(scale * fmin(1, normal_reflectance(plan, at, l, c))) <= nothing_in(plan, c);
}

/* Is it one that says itself that its term is 0: a reflectance or scale? kd is one also where it does not enter linearly. */
static int is_scale(const ff_model_param *p)
{
    return (p->flags & FF_PARAM_LINEAR) != 0 || strcmp(p->info->name, "kd") == 0;
}

static int base_is_off(const ff_plan *plan, const ff_point *at, uint32_t b, size_t c)
{
    const ff_model *m = plan->l.m;
    const ff_base *base = &m->base[b];
    int scales = 0;
    for (uint32_t k = base->channel0; k < base->channel0 + base->n_channel; k++) {
        if (!is_scale(&m->channel[k])) continue;
        if (fabs(at->channel[c * m->n_channel + k]) > nothing_in(plan, c)) return 0;
        scales++;
    }
    return scales > 0;
}

/* Is the term that parameter p belongs to off in channel c? */
static int is_off(const ff_plan *plan, const ff_point *at, const ff_model_param *p, size_t c)
{
    const uint32_t lobes = plan->l.m->n_lobes;
    return p->lobe < lobes ? lobe_is_off(plan, at, p->lobe, c) : base_is_off(plan, at, p->lobe - lobes, c);
}

/* ---- against the data ------------------------------------------------------------------------- */

/* Sum of squares of the data as the loss compares them. */
static double data_square(const struct ff_problem *p, size_t c)
{
    double sum = 0;
    for (size_t i = 0; i < p->n; i++) {
        const double w = ff_problem_plane(p, i / FF_BLOCK, p->weight + p->weight_stride * (int)c)[i % FF_BLOCK];
        const double t = w * ff_problem_plane(p, i / FF_BLOCK, p->target + (int)c)[i % FF_BLOCK];
        sum += t * t;
    }
    return sum;
}

int ff_problem_is_dark(const struct ff_problem *p)
{
    for (size_t c = 0; c < p->n_channels; c++)
        if (p->channel_mean[c] != 0) return 0;
    return 1;
}

/* Sum of squares of what a coordinate moves the model by, over the channels that it has to do with. */
static double effect_square(const ff_gram *g, size_t k, size_t c)
{
    double sum = 0;
    for (size_t i = 0; i < g->S + g->K; i++)
        if (ff_gram_coordinate(g, c, i) == k) sum += g->local[c * g->tri + ff_tri(i, i)];
    return sum;
}

/* Has coordinate k nothing to act on in any of its channels? square [C]: of the data. */
static int has_no_weight(const ff_plan *plan, const ff_point *at, const ff_gram *g, const double *square, size_t k)
{
    const ff_layout *l = &plan->l;
    size_t own;
    const ff_model_param *p = ff_layout_param(l, k, &own);
    double effect = 0, data = 0;
    if (is_scale(p)) return 0;
    for (size_t c = 0; c < l->n_channels; c++) {
        if (k >= l->n_shared && c != own) continue;
        if (!is_off(plan, at, p, c)) return 0;
        effect += effect_square(g, k, c);
        data += square[c];
    }
    return effect <= RISE * RISE * data;
}

/* The sums of the point's pass, in coordinates. */
static ff_status fill_gram(const ff_plan *plan, const ff_point *at, ff_gram *g)
{
    double *slope = malloc((plan->l.P + 1) * sizeof *slope);
    ff_status status = slope ? ff_gram_new(&plan->l, g) : FF_ERR_MEMORY;
    if (!status) {
        ff_layout_slope(&plan->l, at->shape, at->channel, slope);
        ff_gram_fill(&plan->l, &at->normal, slope, g);
    }
    free(slope);
    return status;
}

/* ---- the whole -------------------------------------------------------------------------------- */

ff_status ff_result_weightless(const ff_plan *plan, const ff_point *at, ff_fit_result *r)
{
    const ff_layout *l = &plan->l;
    const int dark = ff_problem_is_dark(plan->p);
    ff_gram g;
    double *square = calloc(l->n_channels + 1, sizeof *square);
    ff_status status = square ? fill_gram(plan, at, &g) : FF_ERR_MEMORY;
    if (!status) {
        for (size_t c = 0; c < l->n_channels; c++) square[c] = data_square(plan->p, c);
        for (size_t k = 0; k < l->P; k++) {
            ff_fit_value *v = ff_result_value(l, r, k);
            if (v->held) continue;
            v->weightless = dark ? !is_scale(ff_layout_param(l, k, NULL)) : has_no_weight(plan, at, &g, square, k);
        }
        ff_gram_free(&g);
    }
    free(square);
    return status;
}

void ff_result_forget_weightless(const ff_plan *plan, ff_fit_result *r)
{
    const int dark = ff_problem_is_dark(plan->p);
    for (size_t k = 0; k < plan->l.P; k++) {
        ff_fit_value *v = ff_result_value(&plan->l, r, k);
        if (!v->weightless && !dark) continue;
        v->std_error = v->low = v->high = v->carriers = v->residual_error = NAN;
        v->interval = FF_INTERVAL_NONE;
    }
}
