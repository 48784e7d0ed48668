/* Where the fit of a model starts that is not linear in its channel parameters: at the optimum of one that is. Schlick's Fresnel
 * term stands for the others, Lambert's for what is coupled or curved, and lobes that share a Fresnel term are set apart. */
#include "internal_start.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Is the base affine in its channel parameters, whatever the lobes do? */
static int is_simple(const ff_diffuse *base)
{
    int simple = !(base->couples & ~(uint32_t)FF_COUPLE_ALPHA);
    for (uint32_t k = 0; k < base->term.n_params; k++)
        if ((base->term.params[k].flags & FF_PARAM_PER_CHANNEL) && !(base->term.params[k].flags & FF_PARAM_LINEAR)) simple = 0;
    return simple;
}

/* Has the base a scale of its own that Lambert's kd can stand for? */
static int has_scale(const ff_diffuse *base)
{
    for (uint32_t k = 0; k < base->term.n_params; k++)
        if (base->term.params[k].flags & FF_PARAM_PER_CHANNEL) return 1;
    return 0;
}

static void expression_of(const ff_model *m, char *out, size_t size)
{
    size_t used = 0;
    int lambert = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        const int keeps = lobe->fresnel != FF_FRESNEL_SHARED && !ff_fresnel_at(lobe->fresnel)->like_schlick;
        used +=
            (size_t)snprintf(out + used, size - used, "%s%s/%s/%s", l ? "+" : "", ff_ndf_at(lobe->ndf)->term.name,
                             ff_masking_at(lobe->masking)->term.name, keeps ? ff_fresnel_at(lobe->fresnel)->term.name : "schlick");
    }
    for (uint32_t b = 0; b < m->n_bases; b++) {
        const ff_diffuse *base = ff_diffuse_at(m->base[b].diffuse);
        const int simple = is_simple(base), stands = !simple && has_scale(base) && !lambert;
        lambert |= stands || strcmp(base->term.name, "lambert") == 0;
        if (simple || stands)
            used += (size_t)snprintf(out + used, size - used, "%s%s", used ? "+" : "", simple ? base->term.name : "lambert");
    }
}

/* Index of the shape parameter of the same name, or of alpha_x for an isotropic lobe's alpha; -1 = none. */
static int find_like(const ff_model *m, const char *name)
{
    char axis[FF_PARAM_NAME + 2];
    ff_param_ref at = ff_model_param_find(m, name);
    snprintf(axis, sizeof axis, "%s_x", name);
    if (at.kind == FF_PARAM_NONE) at = ff_model_param_find(m, axis);
    return at.kind == FF_PARAM_SHAPE ? (int)at.index : -1;
}

/* Index of the per-channel parameter of that name; -1 = none. */
static int find_channel(const ff_model *m, const char *name)
{
    const ff_param_ref at = ff_model_param_find(m, name);
    return at.kind == FF_PARAM_CHANNEL ? (int)at.index : -1;
}

/* Shape parameters that are tied are so in the surrogate; channel parameters, which may be others there, are not:
 * ff_surrogate_start brings them together. */
static void tie_shape(const ff_layout *l, ff_layout *surrogate)
{
    ff_ties ties = {.n = 0};
    for (uint32_t k = 0; k < FF_MAX_SHAPE; k++) ties.shape[k] = k;
    for (uint32_t k = 0; k < FF_MAX_CHANNEL_PARAMS; k++) ties.channel[k] = k;
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        if (l->shape_follows[k] < 0) continue;
        const int i = find_like(surrogate->m, l->m->shape[l->free.shape[k]].name),
                  to = find_like(surrogate->m, l->m->shape[l->free.shape[l->shape_follows[k]]].name);
        if (i >= 0 && to >= 0) ties.shape[i] = (uint32_t)to;
    }
    ff_layout_tie(surrogate, &ties);
}

static ff_model_param *scale_of(ff_model *m, uint32_t lobe)
{
    return &m->channel[m->lobe[lobe].channel0 + m->lobe[lobe].n_channel - 1];
}

/* Is the Fresnel term of lobe k that of other lobes too? */
static int is_shared(const ff_model *m, uint32_t k)
{
    int others = 0;
    for (uint32_t other = 1; other < m->n_lobes; other++) others |= m->lobe[other].fresnel == FF_FRESNEL_SHARED;
    return others && (k == 0 || m->lobe[k].fresnel == FF_FRESNEL_SHARED);
}

/* Where the scale of a lobe is free, so is that of its surrogate: F0 and the scale together are linear, and the data may be of any
 * magnitude. Lobes that share a Fresnel term share its scale; in their surrogates, each of which has a scale, F0 is the same and
 * stays what it is: with one of their own they would describe what the model cannot. */
static void free_scales(const ff_model *m, double f0_in_common, ff_model *surrogate)
{
    for (uint32_t k = 0; k < m->n_lobes; k++) {
        const ff_lobe *own = &m->lobe[m->lobe[k].fresnel == FF_FRESNEL_SHARED ? 0 : k];
        if (m->channel[own->channel0 + own->n_channel - 1].flags & FF_PARAM_HELD) continue;
        scale_of(surrogate, k)->flags &= ~(uint32_t)FF_PARAM_HELD;
        ff_model_param *f0 = &surrogate->channel[surrogate->lobe[k].channel0];
        if (!is_shared(m, k) || surrogate->lobe[k].n_channel < 2 || (f0->flags & FF_PARAM_HELD)) continue;
        f0->flags |= FF_PARAM_HELD;
        f0->init = f0_in_common;
    }
}

/* What channels differ in, for the parameters that the surrogate has too. */
static ff_status take_limits(const ff_layout *l, ff_surrogate *out)
{
    const ff_model *m = l->m;
    if (!l->limits) return FF_OK;
    out->limits = ff_limits_new(&out->model, l->n_channels);
    if (!out->limits) return FF_ERR_MEMORY;
    for (uint32_t k = 0; k < m->n_channel; k++) {
        const int i = find_channel(&out->model, m->channel[k].name);
        if (i >= 0) ff_limits_copy(l->limits, m->n_channel, k, l->n_channels, out->limits, out->model.n_channel, (size_t)i);
    }
    out->plan.l.limits = out->limits;
    return FF_OK;
}

void ff_surrogate_free(ff_surrogate *s)
{
    ff_limits_free(s->limits);
    s->limits = NULL;
}

ff_status ff_surrogate_make(const ff_plan *plan, double f0_in_common, ff_surrogate *out)
{
    const ff_layout *l = &plan->l;
    const ff_model *m = l->m;
    out->limits = NULL;
    out->plan = *plan; /* penalties weigh nothing yet; which lobes they name counts */
    if (l->linear) {
        out->model = *m;
        out->plan.l.m = &out->model;
        return FF_OK;
    }
    char text[FF_MODEL_NAME];
    expression_of(m, text, sizeof text);
    const ff_status status = ff_model_parse(text, &out->model, NULL);
    if (status) return FF_ERR_INTERNAL;
    for (uint32_t k = 0; k < m->n_lobes; k++) out->model.lobe[k].table = m->lobe[k].table;
    for (uint32_t k = 0; k < m->n_shape; k++) { /* what is held stays held */
        const int i = find_like(&out->model, m->shape[k].name);
        if (i < 0) continue;
        out->model.shape[i].init = m->shape[k].init;
        out->model.shape[i].flags = m->shape[k].flags;
        out->model.shape[i].lo = m->shape[k].lo;
        out->model.shape[i].hi = m->shape[k].hi;
    }
    for (uint32_t k = 0; k < m->n_channel; k++) {
        const int i = find_channel(&out->model, m->channel[k].name);
        if (i < 0) continue;
        out->model.channel[i].lo = m->channel[k].lo;
        out->model.channel[i].hi = m->channel[k].hi;
        if (!(m->channel[k].flags & FF_PARAM_HELD)) continue;
        out->model.channel[i].init = m->channel[k].init;
        out->model.channel[i].flags = m->channel[k].flags;
    }
    free_scales(m, f0_in_common, &out->model);
    const int mean_slope = l->mode == FF_TILTED_MODE;
    ff_shape shape = FF_SHAPE_ISOTROPIC;
    for (uint32_t k = 0; k < l->free.n_shape; k++) {
        const char *name = m->shape[l->free.shape[k]].info->name;
        if (strcmp(name, "r_xy") == 0) shape = FF_SHAPE_CORRELATED;
        if (strcmp(name, "alpha_y") == 0 && shape == FF_SHAPE_ISOTROPIC) shape = FF_SHAPE_AXIS;
    }
    if (ff_layout_init(&out->model, l->n_channels, shape, mean_slope, &out->plan.l, NULL)) return FF_ERR_INTERNAL;
    tie_shape(l, &out->plan.l);
    out->plan.l.arrowhead = l->arrowhead && ff_layout_is_arrowhead(&out->plan.l, 0);
    return take_limits(l, out);
}

int ff_surrogate_has_f0_in_common(const ff_layout *l)
{
    const ff_model *m = l->m;
    if (m->n_lobes < 2 || !is_shared(m, 0) || l->linear) return 0;
    return !(m->channel[m->lobe[0].channel0 + m->lobe[0].n_channel - 1].flags & FF_PARAM_HELD);
}

static double clamp(const ff_param *info, double v)
{
    return fmin(fmax(v, info->lo), info->hi);
}

/* Where a scale is free, nothing says how much of a lobe is Fresnel's and how much the scale's: F0 to be tried. */
static const double f0_tried[] = {0.2, 0.03, 0.5, 0.9};

uint32_t ff_surrogate_variants(const ff_layout *l)
{
    for (uint32_t k = 0; k < l->free.n_channel && !l->linear; k++) {
        const ff_model_param *p = &l->m->channel[l->free.channel[k]];
        if (p->lobe >= l->m->n_lobes) continue;
        const ff_lobe *lobe = &l->m->lobe[p->lobe];
        const int is_scale = l->free.channel[k] + 1 == lobe->channel0 + lobe->n_channel;
        if (is_scale && ff_fresnel_at(lobe->fresnel)->like_schlick) return sizeof f0_tried / sizeof *f0_tried;
    }
    return 1;
}

/* F0 of a lobe of the surrogate times its scale. */
static double normal_reflectance(const ff_model *m, uint32_t lobe, const double *channel)
{
    const double *own = channel + m->lobe[lobe].channel0, ks = own[m->lobe[lobe].n_channel - 1];
    return m->lobe[lobe].n_channel > 1 ? own[0] * ks : ks;
}

/* That of lobe k and of the lobes that share its Fresnel term: it will be shared out by the weights. */
static double joint_reflectance(const ff_layout *l, const ff_surrogate *s, uint32_t k, const double *from)
{
    double sum = normal_reflectance(&s->model, k, from);
    for (uint32_t other = 1; k == 0 && other < l->m->n_lobes; other++)
        if (l->m->lobe[other].fresnel == FF_FRESNEL_SHARED) sum += normal_reflectance(&s->model, other, from);
    return sum;
}

/* Channel parameters of the Fresnel term of lobe k for one channel; a free scale takes what F0 leaves. */
static void start_fresnel(const ff_layout *l, const ff_surrogate *s, uint32_t k, uint32_t variant, const double *from,
                          double *channel)
{
    const ff_lobe *lobe = &l->m->lobe[k], *stand = &s->model.lobe[k];
    const ff_fresnel *term = ff_fresnel_at(lobe->fresnel);
    const uint32_t n = term->term.n_params;
    const ff_model_param *own = &l->m->channel[lobe->channel0];
    const int scaled = !(own[n].flags & FF_PARAM_HELD);
    const double sum = joint_reflectance(l, s, k, from), alone = normal_reflectance(&s->model, k, from),
                 ks = from[stand->channel0 + stand->n_channel - 1], f0 = ks > 0 ? sum / ks : from[stand->channel0];
    double *out = channel + lobe->channel0, params[FF_FRESNEL_PARAMS];
    if (!term->like_schlick) {
        for (uint32_t i = 0; i < n; i++) out[i] = from[stand->channel0 + i];
        if (n && !scaled) out[0] = clamp(own[0].info, f0);
        if (scaled) out[n] = clamp(own[n].info, alone > 0 ? ks * (sum / alone) : ks);
        return;
    }
    const double share = scaled ? f0_tried[variant] : f0;
    term->like_schlick(fmin(fmax(share, 1e-3), 0.999), params);
    for (uint32_t i = 0; i < n; i++)
        if (!(own[i].flags & FF_PARAM_HELD)) out[i] = clamp(own[i].info, params[i]);
    if (scaled) out[n] = clamp(own[n].info, fmax(sum / share, 1e-4 * ks));
}

/* Those of the bases: by name, else Lambert's kd for the first of them. */
static void start_bases(const ff_layout *l, const ff_surrogate *s, const double *from, double *channel)
{
    for (uint32_t b = 0; b < l->m->n_bases; b++) {
        const ff_base *base = &l->m->base[b];
        for (uint32_t k = 0; k < base->n_channel; k++) {
            const ff_model_param *p = &l->m->channel[base->channel0 + k];
            ff_param_ref at = ff_model_param_find(&s->model, p->name);
            if (at.kind == FF_PARAM_NONE && k == 0) at = ff_model_param_find(&s->model, "kd");
            if (at.kind != FF_PARAM_CHANNEL || (p->flags & FF_PARAM_HELD)) continue;
            channel[base->channel0 + k] = clamp(p->info, from[at.index]);
        }
    }
}

void ff_surrogate_start(const ff_layout *l, const ff_surrogate *s, uint32_t variant, const double *from_shape,
                        const double *from_channel, double *shape, double *channel)
{
    const ff_model *m = l->m;
    ff_layout_defaults(l, shape, channel);
    for (uint32_t k = 0; k < m->n_shape; k++) {
        const int i = find_like(&s->model, m->shape[k].name);
        if (i >= 0) shape[k] = from_shape[i];
    }
    double sum[FF_MAX_LOBES] = {0};
    for (size_t c = 0; c < l->n_channels; c++) {
        const double *from = from_channel + c * s->model.n_channel;
        for (uint32_t k = 0; k < m->n_lobes; k++) sum[k] += normal_reflectance(&s->model, k, from);
        if (l->linear) {
            memcpy(channel + c * m->n_channel, from, m->n_channel * sizeof *channel);
            continue;
        }
        for (uint32_t k = 0; k < m->n_lobes; k++)
            if (m->lobe[k].fresnel != FF_FRESNEL_SHARED) start_fresnel(l, s, k, variant, from, channel + c * m->n_channel);
        start_bases(l, s, from, channel + c * m->n_channel);
    }
    double up_to = m->n_lobes ? sum[0] : 0;
    for (uint32_t k = 1; k < m->n_lobes; k++) { /* weight: the share among the lobes up to this one */
        const ff_lobe *lobe = &m->lobe[k];
        if (lobe->fresnel != FF_FRESNEL_SHARED) continue;
        up_to += sum[k];
        const uint32_t at = lobe->shape0 + lobe->n_shape - 1;
        if (!(m->shape[at].flags & FF_PARAM_HELD)) shape[at] = up_to > 0 ? fmin(fmax(sum[k] / up_to, 0.01), 0.99) : 0.5;
    }
    ff_layout_project(l, shape, channel);
}

int ff_surrogate_end_of_valley(const ff_layout *l, uint32_t lobe, size_t c, int high, double *channel)
{
    const ff_model *m = l->m;
    const ff_lobe *at = &m->lobe[lobe];
    if (at->fresnel == FF_FRESNEL_SHARED || strcmp(ff_fresnel_at(at->fresnel)->term.name, "conductor") != 0) return 0;
    if ((m->channel[at->channel0].flags | m->channel[at->channel0 + 1].flags) & FF_PARAM_HELD) return 0;
    double *n = channel + c * m->n_channel + at->channel0, *k = n + 1;
    const double f0 = ((*n - 1) * (*n - 1) + *k * *k) / ((*n + 1) * (*n + 1) + *k * *k), r = sqrt(fmin(f0, 0.999));
    *n = clamp(m->channel[at->channel0].info, high ? (1 + r) / (1 - r) : (1 - r) / (1 + r));
    *k = 0;
    return 1;
}
