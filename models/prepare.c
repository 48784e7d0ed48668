/* A model made ready for its samples: everything that its parameters decide once for all blocks. */
#include "internal_model.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- lobes ----------------------------------------------------------------------------------- */

/* The v = (alpha_o tan theta)^2 that a stretch makes of a range of tan^2 theta. */
static void range_of_v(const ff_stretch *s, ff_stretch_mode mode, double tan2_lo, double tan2_hi, ff_ndf_pass *pass)
{
    const double mean = 0.5 * (s->ax * s->ax + s->ay * s->ay),
                 half = hypot(0.5 * (s->ax * s->ax - s->ay * s->ay), s->r * s->ax * s->ay);
    const double least = fmax(mean - half, s->ax * s->ax * s->ay * s->ay * (1 - s->r * s->r) / (mean + half));
    pass->v_lo = FF_V_MIN;
    pass->v_hi = 1e60;
    if (mode == FF_TILTED_MODE) return; /* the mean slope can turn any direction into any other */
    pass->v_lo = fmax(least * tan2_lo * (1 - 1e-9), FF_V_MIN);
    pass->v_hi = fmin((mean + half) * tan2_hi * (1 + 1e-9), 1e60);
}

static ff_stretch_mode cheapest_mode(const ff_stretch *s)
{
    if (s->x0 != 0 || s->y0 != 0) return FF_TILTED_MODE;
    return s->ax == s->ay && s->r == 0 ? FF_ISOTROPIC_MODE : FF_CENTRED_MODE;
}

static void prepare_lobes(ff_prepared *p, ff_stretch_mode mode, const double *shape, double jac[][FF_MAX_SHAPE][FF_D_COUNT],
                          double tan2_lo, double tan2_hi, double *storage)
{
    for (uint32_t l = 0; l < p->m->n_lobes; l++) {
        ff_lobe_pass *lobe = &p->lobe[l];
        ff_model_lobe(p->m, l, shape, lobe, jac ? jac[l] : NULL);
        const ff_ndf *ndf = p->kernels->ndf[lobe->ndf];
        lobe->mode = p->m->lobe[l].isotropic ? FF_ISOTROPIC_MODE : mode == FF_CHEAPEST_MODE ? cheapest_mode(&lobe->s) : mode;
        memcpy(lobe->ndf_pass.own, lobe->s.own, sizeof lobe->s.own);
        range_of_v(&lobe->s, lobe->mode, tan2_lo, tan2_hi, &lobe->ndf_pass);
        if (!p->kernels->masking[lobe->masking]->uses_lambda)
            lobe->ndf_pass.v_lo = 1, lobe->ndf_pass.v_hi = 0; /* nothing will be asked */
        lobe->ndf_pass.table = ndf->table_size ? storage : NULL;
        storage += ndf->table_size;
        if (ndf->prepare) ndf->prepare(&lobe->ndf_pass);
    }
    const int own = p->m->n_lobes ? p->kernels->ndf[p->lobe[0].ndf]->alpha_own : -1;
    if (own >= 0) p->alpha = own == 0 ? p->lobe[0].s.ax : p->lobe[0].s.own[own - 1];
}

/* ---- columns --------------------------------------------------------------------------------- */

/* The column of a lobe's parameter: row k of its jac. */
static void lobe_column(ff_prepared *p, uint32_t l, uint32_t k, int tied, double jac[][FF_D_COUNT], ff_shape_column *c)
{
    const ff_lobe *lobe = &p->m->lobe[l];
    c->lobe = (int)l;
    memcpy(c->d, jac[k], sizeof c->d);
    if (p->lobe[l].mode == FF_ISOTROPIC_MODE)
        c->d[FF_D_AY] = 0; /* FF_D_AX is the derivative by both */
    else if (tied)
        c->d[FF_D_AY] = 1;
    const int own = p->kernels->ndf[lobe->ndf]->alpha_own;
    if (l == 0 && own >= 0) c->alpha = c->d[own == 0 ? FF_D_AX : FF_D_OWN + own - 1];
    for (int d = 0; d < FF_D_COUNT; d++) {
        c->d[d] *= p->weight[l];
        if (c->d[d] == 0) continue;
        p->needs[l] |= 1u << d;
        if (d >= FF_D_OWN && d < FF_D_MASKING) /* those of the profile come together, and so do those of the stretch */
            for (int own_k = 0; own_k < p->kernels->ndf[lobe->ndf]->n_own; own_k++) p->needs[l] |= 1u << (FF_D_OWN + own_k);
        if (d <= FF_D_R) p->needs[l] |= 1u << FF_D_AX | 1u << FF_D_AY | 1u << FF_D_R;
        if (d == FF_D_X0 || d == FF_D_Y0) p->needs[l] |= 1u << FF_D_X0 | 1u << FF_D_Y0;
    }
}

/* Index of a base's k-th shared (per_channel = 0) or per-channel parameter among all of its term. */
static uint32_t base_param_index(const ff_term *term, int per_channel, uint32_t k)
{
    for (uint32_t i = 0; i < term->n_params; i++)
        if (((term->params[i].flags & FF_PARAM_PER_CHANNEL) != 0) == per_channel && k-- == 0) return i;
    return 0;
}

static const ff_term *base_term(const ff_model *m, uint32_t b)
{
    return &ff_diffuse_at(m->base[b].diffuse)->term;
}

static void prepare_columns(ff_prepared *p, double jac[][FF_MAX_SHAPE][FF_D_COUNT], double dw[][FF_MAX_LOBES])
{
    const ff_model *m = p->m;
    for (uint32_t k = 0; k < p->wanted.n_shape; k++) {
        const uint32_t at = p->wanted.shape[k], l = m->shape[at].lobe;
        ff_shape_column *c = &p->shape[k];
        *c = (ff_shape_column){.lobe = -1, .base = -1};
        if (l >= m->n_lobes) {
            c->base = (int)(l - m->n_lobes);
            c->base_param = base_param_index(base_term(m, l - m->n_lobes), 0, at - m->base[c->base].shape0);
        } else if (m->lobe[l].fresnel == FF_FRESNEL_SHARED && at + 1 == m->lobe[l].shape0 + m->lobe[l].n_shape) {
            c->moves_weights = 1;
            memcpy(c->weight, dw[l], sizeof c->weight);
        } else
            lobe_column(p, l, at - m->lobe[l].shape0, p->wanted.tied[k], jac[l], c);
    }
    for (uint32_t k = 0; k < p->wanted.n_channel; k++) {
        const uint32_t at = p->wanted.channel[k], l = m->channel[at].lobe;
        ff_channel_column *c = &p->column[k];
        *c = (ff_channel_column){.group = -1, .base = -1};
        if (l >= m->n_lobes) {
            c->base = (int)(l - m->n_lobes);
            c->param = base_param_index(base_term(m, l - m->n_lobes), 1, at - m->base[c->base].channel0);
        } else {
            c->group = (int)l;
            c->param = at - m->lobe[l].channel0;
            c->is_scale = at + 1 == m->lobe[l].channel0 + m->lobe[l].n_channel;
        }
    }
}

/* ---- bases ----------------------------------------------------------------------------------- */

static void prepare_bases(ff_prepared *p, const double *shape)
{
    const ff_model *m = p->m;
    for (uint32_t b = 0; b < m->n_bases; b++) {
        const ff_diffuse *term = p->kernels->diffuse[m->base[b].diffuse];
        for (uint32_t k = 0; k < m->base[b].n_shape; k++)
            p->base_param[b][base_param_index(&term->term, 0, k)] = shape[m->base[b].shape0 + k];
        p->couples |= term->couples;
        if (!(term->couples & FF_COUPLE_LOSS)) {
            p->part[p->n_parts++] = (ff_part){b, -1};
            continue;
        }
        for (uint32_t l = 0; l < m->n_lobes; l++) p->part[p->n_parts++] = (ff_part){b, (int)l};
    }
}

/* F of the lobes at normal incidence, per channel. */
static void prepare_f0(ff_prepared *p)
{
    double one = 1, d[FF_FRESNEL_PARAMS], *planes[FF_FRESNEL_PARAMS];
    const ff_geometry g = {.plane = {[FF_G_C] = &one}};
    for (int k = 0; k < FF_FRESNEL_PARAMS; k++) planes[k] = &d[k];
    for (size_t c = 0; c < p->n_channels; c++)
        for (uint32_t l = 0; l < p->m->n_lobes; l++) {
            const ff_lobe *lobe = &p->m->lobe[ff_model_group(p->m, l)];
            double *out = p->f0 + (c * p->m->n_lobes + l) * (1 + FF_FRESNEL_PARAMS);
            memset(d, 0, sizeof d);
            p->kernels->fresnel[lobe->fresnel]->eval(p->channel + c * p->m->n_channel + lobe->channel0, &g, 1, &out[0], planes);
            memcpy(out + 1, d, sizeof d);
        }
}

/* ---- the whole ------------------------------------------------------------------------------- */

/* Doubles that curves take. */
static size_t curve_doubles(size_t curves, size_t functions)
{
    return curves * functions * (FF_ALBEDO_COEFFICIENTS + 1);
}

static double *lay_out_curves(ff_albedo_curve *curve, size_t curves, size_t functions, double *storage)
{
    for (size_t i = 0; i < curves; i++) {
        curve[i] = (ff_albedo_curve){.n_functions = (uint32_t)functions, .coefficient = storage};
        curve[i].mean = storage += functions * FF_ALBEDO_COEFFICIENTS;
        storage += functions;
    }
    return storage;
}

/* Allocates what the model's tables and couplings need and points to it; the lobes' tables come first. */
static ff_status allocate(ff_prepared *p)
{
    const ff_model *m = p->m;
    const size_t C = p->n_channels, per_term = 1 + FF_FRESNEL_PARAMS;
    const size_t all = 1 + p->wanted.n_shape + p->wanted.n_channel, shape_only = 1 + p->wanted.n_shape;
    const size_t albedos = p->couples & FF_COUPLE_ALBEDO ? C : 0, losses = p->couples & FF_COUPLE_LOSS ? m->n_lobes : 0;
    const size_t f0 = p->couples & FF_COUPLE_F0 ? C * m->n_lobes * per_term : 0, average = losses ? C * m->n_lobes * per_term : 0;
    size_t tables = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++) tables += p->kernels->ndf[m->lobe[l].ndf]->table_size;
    const size_t doubles = tables + f0 + average + curve_doubles(albedos, all) + curve_doubles(losses, shape_only);
    if (doubles == 0) return FF_OK;
    const size_t bytes = doubles * sizeof(double) + (albedos + losses) * sizeof(ff_albedo_curve);
    p->storage = aligned_alloc(64, (bytes + 63) / 64 * 64);
    if (!p->storage) return FF_ERR_MEMORY;
    double *next = p->storage + tables;
    p->f0 = f0 ? next : NULL;
    p->f_average = average ? next + f0 : NULL;
    next += f0 + average;
    p->albedo = (ff_albedo_curve *)(void *)(p->storage + doubles);
    p->loss = p->albedo + albedos;
    next = lay_out_curves(p->albedo, albedos, all, next);
    lay_out_curves(p->loss, losses, shape_only, next);
    return FF_OK;
}

ff_status ff_prepare(const ff_model *m, const ff_kernels *k, ff_stretch_mode mode, size_t n_channels, const double *shape,
                     const double *channel, const ff_wanted *wanted, double tan2_lo, double tan2_hi, ff_prepared *out)
{
    double jac[FF_MAX_LOBES][FF_MAX_SHAPE][FF_D_COUNT], dw[FF_MAX_LOBES][FF_MAX_LOBES];
    *out = (ff_prepared){.kernels = k, .m = m, .n_channels = n_channels, .channel = channel};
    if (wanted) out->wanted = *wanted;
    ff_model_weights(m, shape, out->weight, dw);
    prepare_bases(out, shape);
    ff_status status = allocate(out);
    if (status) return status;
    const int curves = (out->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS)) != 0; /* they ask for all directions */
    prepare_lobes(out, mode, shape, wanted ? jac : NULL, curves ? 0 : tan2_lo, curves ? INFINITY : tan2_hi, out->storage);
    if (wanted) prepare_columns(out, jac, dw);
    if (out->f0) prepare_f0(out);
    out->planes = ff_prepared_planes(out);
    if (curves) status = ff_coupling_fill(out);
    if (status) ff_prepared_free(out);
    return status;
}

void ff_prepared_free(ff_prepared *p)
{
    free(p->storage);
    p->storage = NULL;
}

uint32_t ff_prepared_planes(const ff_prepared *p)
{
    uint32_t planes = ff_model_planes(p->m, FF_ISOTROPIC_MODE) & ~(1u << FF_G_S2 | 1u << FF_G_TI2 | 1u << FF_G_TO2);
    for (uint32_t l = 0; l < p->m->n_lobes; l++)
        planes |= p->lobe[l].mode == FF_ISOTROPIC_MODE
                      ? 1u << FF_G_S2 | 1u << FF_G_TI2 | 1u << FF_G_TO2
                      : 1u << FF_G_SX | 1u << FF_G_SY | 1u << FF_G_TIX | 1u << FF_G_TIY | 1u << FF_G_TOX | 1u << FF_G_TOY;
    for (uint32_t b = 0; b < p->m->n_bases; b++) planes |= ff_diffuse_at(p->m->base[b].diffuse)->planes;
    return planes;
}
