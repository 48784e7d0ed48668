/* What the parameters of a model are to its kernels: the stretch and the weight of each lobe, the planes that are read, and what
 * the whole may claim for them. */
#include "internal_model.h"
#include <string.h>

void ff_model_lobe(const ff_model *m, uint32_t l, const double *shape, ff_lobe_pass *pass, double jac[][FF_D_COUNT])
{
    const ff_lobe *lobe = &m->lobe[l];
    const ff_ndf *ndf = ff_ndf_at(lobe->ndf);
    const double *p = shape + lobe->shape0;
    ff_stretch *s = &pass->s;
    uint32_t k = ndf->term.n_params; /* the masking's parameter follows those of the distribution */
    *pass = (ff_lobe_pass){.ndf = lobe->ndf, .masking = lobe->masking};
    pass->ndf_pass.values = lobe->table;
    if (jac) memset(jac, 0, lobe->n_shape * sizeof *jac);
    if (!ff_ndf_is_stretched(ndf)) {
        ndf->stretch(p, s, jac);
    } else if (lobe->isotropic) {
        s->ax = s->ay = p[0];
        k -= FF_STRETCH_COUNT - 1;
        if (jac) jac[0][FF_D_AX] = jac[0][FF_D_AY] = 1;
        for (uint32_t i = 1; i < k; i++) {
            s->own[i - 1] = p[i];
            if (jac) jac[i][FF_D_OWN + i - 1] = 1;
        }
    } else {
        *s = (ff_stretch){.ax = p[0], .ay = p[1], .r = p[2], .x0 = p[3], .y0 = p[4]};
        for (uint32_t i = FF_STRETCH_COUNT; i < k; i++) s->own[i - FF_STRETCH_COUNT] = p[i];
        if (jac)
            for (uint32_t i = 0; i < k; i++) jac[i][i] = 1; /* own parameters follow the stretch in FF_D_... too */
    }
    if (ff_masking_at(lobe->masking)->term.n_params) {
        pass->masking_own = p[k];
        if (jac) jac[k][FF_D_MASKING] = 1;
    }
}

void ff_model_weights(const ff_model *m, const double *shape, double *weight, double dw[][FF_MAX_LOBES])
{
    double w[FF_MAX_LOBES]; /* own shares */
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        w[l] = lobe->fresnel == FF_FRESNEL_SHARED ? shape[lobe->shape0 + lobe->n_shape - 1] : 0;
    }
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const int shares = m->lobe[l].fresnel == FF_FRESNEL_SHARED;
        weight[l] = shares ? w[l] : 1;
        for (uint32_t k = 0; dw && k < m->n_lobes; k++) dw[k][l] = shares && k == l ? 1 : 0;
        if (l > 0 && !shares) continue;
        for (uint32_t later = l + 1; later < m->n_lobes; later++) { /* each later one takes its share of what is there */
            if (m->lobe[later].fresnel != FF_FRESNEL_SHARED) continue;
            for (uint32_t k = 0; dw && k < m->n_lobes; k++) dw[k][l] = dw[k][l] * (1 - w[later]) - (k == later ? weight[l] : 0);
            weight[l] *= 1 - w[later];
        }
    }
}

uint32_t ff_model_claims(const ff_model *m, const double *shape)
{
    uint32_t claims = FF_RECIPROCAL | FF_ISOTROPIC | (m->n_lobes + m->n_bases <= 1 ? FF_PASSIVE : 0u);
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        const uint32_t masking = ff_masking_at(lobe->masking)->term.claims,
                       fresnel = ff_fresnel_at(m->lobe[ff_model_group(m, l)].fresnel)->term.claims;
        ff_lobe_pass pass;
        ff_model_lobe(m, l, shape, &pass, NULL);
        const ff_stretch *s = &pass.s;
        const int tilted = s->x0 != 0 || s->y0 != 0;
        uint32_t c = ff_ndf_at(lobe->ndf)->term.claims & masking & fresnel & (FF_RECIPROCAL | FF_PASSIVE);
        if (tilted) c &= ~(uint32_t)(FF_RECIPROCAL | FF_PASSIVE);
        if (s->ax == s->ay && s->r == 0 && !tilted) c |= FF_ISOTROPIC;
        claims &= c;
    }
    for (uint32_t b = 0; b < m->n_bases; b++) claims &= ff_diffuse_at(m->base[b].diffuse)->term.claims;
    return claims;
}

uint32_t ff_model_planes(const ff_model *m, ff_stretch_mode mode)
{
    const uint32_t isotropic = 1u << FF_G_S2 | 1u << FF_G_TI2 | 1u << FF_G_TO2;
    const uint32_t vectors = 1u << FF_G_SX | 1u << FF_G_SY | 1u << FF_G_TIX | 1u << FF_G_TIY | 1u << FF_G_TOX | 1u << FF_G_TOY;
    uint32_t planes = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++)
        planes |= 1u << FF_G_K | (m->lobe[l].isotropic || mode == FF_ISOTROPIC_MODE ? isotropic : vectors) |
                  ff_masking_at(m->lobe[l].masking)->planes | ff_fresnel_at(m->lobe[ff_model_group(m, l)].fresnel)->planes;
    for (uint32_t b = 0; b < m->n_bases; b++) {
        const ff_diffuse *base = ff_diffuse_at(m->base[b].diffuse);
        planes |= base->planes;
        if (base->couples & (FF_COUPLE_ALBEDO | FF_COUPLE_LOSS)) planes |= 1u << FF_G_COS_I | 1u << FF_G_COS_O;
    }
    return planes;
}
