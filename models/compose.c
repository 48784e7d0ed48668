/* Composition of terms into a model: which go together, and the parameters that come of it. */
#include "internal_model.h"
#include <stdio.h>
#include <string.h>

/* The parameters that lobes have from being lobes. */
static const ff_param alpha_param = {"alpha", "1", "roughness, the same in every direction", 1e-4, 4, 0.3, FF_PARAM_LOG, 0};
static const ff_param scale_param = {
    "ks", "1", "scale of the lobe", 0, 1e15, 1, FF_PARAM_PER_CHANNEL | FF_PARAM_LINEAR | FF_PARAM_HELD, 0};
static const ff_param weight_param = {"weight", "1", "share of the lobe among those with the same Fresnel term", 0, 1, 0.5, 0, 0};

/* prefix: "lobe2", NULL for none. */
static ff_status add_param(ff_model *m, const ff_param *info, uint32_t lobe, const char *prefix, ff_error *err)
{
    const int per_channel = (info->flags & FF_PARAM_PER_CHANNEL) != 0;
    if (per_channel ? m->n_channel == FF_MAX_CHANNEL_PARAMS : m->n_shape == FF_MAX_SHAPE)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the model has too many parameters");
    ff_model_param *p = per_channel ? &m->channel[m->n_channel++] : &m->shape[m->n_shape++];
    *p = (ff_model_param){.info = info, .lobe = lobe, .init = info->init, .lo = info->lo, .hi = info->hi, .flags = info->flags};
    snprintf(p->name, sizeof p->name, "%.8s%s%.20s", prefix ? prefix : "", prefix ? "." : "", info->name);
    return FF_OK;
}

static ff_status add_params(ff_model *m, const ff_term *term, uint32_t from, uint32_t lobe, const char *prefix, ff_error *err)
{
    ff_status status = FF_OK;
    for (uint32_t i = from; i < term->n_params && !status; i++) status = add_param(m, &term->params[i], lobe, prefix, err);
    return status;
}

static ff_status add_lobe(ff_model *m, uint32_t l, ff_error *err)
{
    ff_lobe *lobe = &m->lobe[l];
    const ff_ndf *ndf = ff_ndf_at(lobe->ndf);
    ff_status status = FF_OK;
    char number[16];
    snprintf(number, sizeof number, "lobe%u", l + 1);
    const char *prefix = l > 0 ? number : NULL;
    lobe->shape0 = m->n_shape;
    lobe->channel0 = m->n_channel;
    if (lobe->isotropic && ff_ndf_is_stretched(ndf)) {
        status = add_param(m, &alpha_param, l, prefix, err);
        if (!status) status = add_params(m, &ndf->term, FF_STRETCH_COUNT, l, prefix, err);
    } else
        status = add_params(m, &ndf->term, 0, l, prefix, err);
    if (!status) status = add_params(m, &ff_masking_at(lobe->masking)->term, 0, l, prefix, err);
    if (!status && lobe->fresnel == FF_FRESNEL_SHARED) status = add_param(m, &weight_param, l, prefix, err);
    if (!status && lobe->fresnel != FF_FRESNEL_SHARED) {
        status = add_params(m, &ff_fresnel_at(lobe->fresnel)->term, 0, l, prefix, err);
        if (!status) status = add_param(m, &scale_param, l, prefix, err);
    }
    lobe->n_shape = m->n_shape - lobe->shape0;
    lobe->n_channel = m->n_channel - lobe->channel0;
    return status;
}

static ff_status add_base(ff_model *m, uint32_t b, ff_error *err)
{
    ff_base *base = &m->base[b];
    base->shape0 = m->n_shape;
    base->channel0 = m->n_channel;
    const ff_term *term = &ff_diffuse_at(base->diffuse)->term;
    int taken = 0; /* a name that the first base has: the second one's say whose they are */
    for (uint32_t i = 0; i < term->n_params; i++) taken |= ff_model_param_find(m, term->params[i].name).kind != FF_PARAM_NONE;
    const ff_status status = add_params(m, term, 0, m->n_lobes + b, taken ? "base2" : NULL, err);
    base->n_shape = m->n_shape - base->shape0;
    base->n_channel = m->n_channel - base->channel0;
    return status;
}

/* Names of the maskings that need no Lambda, for the message below. */
static void list_lambda_free(char *text, size_t size)
{
    for (size_t i = 0; i < ff_term_count(FF_MASKING); i++) {
        const ff_masking *k = ff_masking_at((int)i);
        const size_t used = strlen(text);
        if (!k->uses_lambda && !k->only) snprintf(text + used, size - used, "%s%s", used ? ", " : "", k->term.name);
    }
}

/* Do the terms of a lobe go together? */
static ff_status check_lobe(const ff_lobe *lobe, ff_error *err)
{
    const ff_ndf *ndf = ff_ndf_at(lobe->ndf);
    const ff_masking *masking = ff_masking_at(lobe->masking);
    if (masking->only && strcmp(masking->only, ndf->term.name) != 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "the masking %s is made for %s, not for %s", masking->term.name,
                            masking->only, ndf->term.name);
    if (masking->uses_lambda && !ndf->lambda) {
        char names[200] = "";
        list_lambda_free(names, sizeof names);
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1,
                            "%s is no distribution over a unit area, so that %s has no meaning for it; allowed are %s",
                            ndf->term.name, masking->term.name, names);
    }
    return FF_OK;
}

/* Is the lobe one of those that a base is made for? */
static ff_status check_only(const ff_model *m, const ff_diffuse *base, ff_error *err)
{
    const char *ndf = m->n_lobes ? ff_ndf_at(m->lobe[0].ndf)->term.name : "", *masking = "smith-height-correlated";
    int known = 0;
    for (const char *const *name = base->only; *name; name++) known |= !strcmp(*name, ndf);
    if (known && m->n_lobes == 1 && !strcmp(ff_masking_at(m->lobe[0].masking)->term.name, masking)) return FF_OK;
    char names[80] = "";
    for (const char *const *name = base->only; *name; name++) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%s%s", used ? " or " : "", *name);
    }
    return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is made for one lobe of %s with the masking %s", base->term.name,
                        names, masking);
}

/* Does a base have what it is coupled to? */
static ff_status check_base(const ff_model *m, const ff_diffuse *base, ff_error *err)
{
    if (base->couples && m->n_lobes == 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s is coupled to the lobes above it: the model needs one",
                            base->term.name);
    if ((base->couples & FF_COUPLE_ALPHA) && ff_ndf_at(m->lobe[0].ndf)->alpha_own < 0)
        return ff_error_set(err, FF_ERR_UNSUPPORTED, NULL, 0, -1, "%s reads the roughness alpha of the first lobe, and %s has none",
                            base->term.name, ff_ndf_at(m->lobe[0].ndf)->term.name);
    return base->only ? check_only(m, base, err) : FF_OK;
}

ff_status ff_model_finish(ff_model *m, ff_error *err)
{
    ff_status status = FF_OK;
    int isotropic = 0;
    m->n_shape = m->n_channel = 0;
    for (uint32_t b = 0; b < m->n_bases && !status; b++) {
        const ff_diffuse *base = ff_diffuse_at(m->base[b].diffuse);
        isotropic |= (base->couples & FF_COUPLES_ISOTROPIC) != 0;
        status = check_base(m, base, err);
    }
    for (uint32_t l = 0; l < m->n_lobes && !status; l++) {
        ff_lobe *lobe = &m->lobe[l];
        lobe->isotropic = lobe->isotropic || isotropic || (ff_ndf_at(lobe->ndf)->term.claims & FF_ISOTROPIC) ||
                          (ff_masking_at(lobe->masking)->term.claims & FF_ISOTROPIC);
        status = check_lobe(lobe, err);
        if (!status) status = add_lobe(m, l, err);
    }
    for (uint32_t b = 0; b < m->n_bases && !status; b++) status = add_base(m, b, err);
    return status;
}

ff_status ff_model_compose(int ndf, int masking, int fresnel, int diffuse, ff_model *out, ff_error *err)
{
    const int index[FF_TERM_KINDS] = {ndf, masking, fresnel, diffuse};
    for (int kind = 0; kind < FF_TERM_KINDS; kind++) {
        const int lowest = kind == FF_DIFFUSE ? -1 : 0;
        if (index[kind] < lowest || index[kind] >= (int)ff_term_count((ff_term_kind)kind))
            return ff_error_set(err, FF_ERR_RANGE, NULL, 0, -1, "%s number %d does not exist",
                                ff_term_kind_name((ff_term_kind)kind), index[kind]);
    }
    ff_model m = {.n_lobes = 1, .n_bases = diffuse >= 0};
    m.lobe[0] = (ff_lobe){.ndf = ndf, .masking = masking, .fresnel = fresnel};
    m.base[0].diffuse = diffuse;
    const ff_status status = ff_model_finish(&m, err);
    if (!status) *out = m;
    return status;
}

void ff_model_lobe_alone(const ff_model *m, uint32_t l, size_t n_channels, const double *shape, const double *channel,
                         ff_model *out, double *out_shape, double *out_channel)
{
    const ff_lobe *lobe = &m->lobe[l], *group = &m->lobe[ff_model_group(m, l)];
    ff_model alone = {.n_lobes = 1};
    alone.lobe[0] = *lobe;
    alone.lobe[0].fresnel = group->fresnel;
    (void)ff_model_finish(&alone, NULL); /* its terms went together before */
    *out = alone;
    memcpy(out_shape, shape + lobe->shape0, alone.n_shape * sizeof *shape);
    for (size_t c = 0; c < n_channels; c++)
        memcpy(out_channel + c * alone.n_channel, channel + c * m->n_channel + group->channel0, alone.n_channel * sizeof *channel);
}
