/* Evaluation of a composed model over any number of direction pairs, block by block. */
#include "internal_kernel.h"
#include <string.h>

/* The cheapest mode that gives the value. */
static ff_stretch_mode mode_for(const ff_stretch *s)
{
    if (s->x0 != 0 || s->y0 != 0) return FF_TILTED_MODE;
    return s->ax == s->ay && s->r == 0 ? FF_ISOTROPIC_MODE : FF_CENTRED_MODE;
}

/* Everything that does not change between blocks. */
typedef struct evaluation {
    const ff_kernels *k;
    const ff_model *m;
    size_t n_channels;
    const double *channel;
    uint32_t planes;
    /* The value always comes from the cheapest mode, so that it has the same bits with and without derivatives; those need the
     * general mode also where alpha_x = alpha_y. */
    ff_lobe_pass pass[FF_MAX_LOBES], dpass[FF_MAX_LOBES];
    double jac[FF_MAX_LOBES][FF_MAX_SHAPE][FF_D_COUNT];
} evaluation;

/* derivatives: dpass is needed too. */
static void prepare(evaluation *e, const double *shape, int derivatives)
{
    for (uint32_t l = 0; l < e->m->n_lobes; l++) {
        ff_lobe_pass *pass = &e->pass[l];
        pass->ndf = e->m->lobe[l].ndf;
        pass->masking = e->m->lobe[l].masking;
        ff_model_stretch(e->m, l, shape, &pass->s, e->jac[l]);
        pass->mode = mode_for(&pass->s);
        ff_lobe_pass_prepare(e->k, pass);
        e->planes |= ff_model_planes(e->m, pass->mode);
        if (!derivatives) continue;
        e->dpass[l] = *pass;
        e->dpass[l].mode = (ff_ndf_at(pass->ndf)->term.claims & FF_ISOTROPIC) ? FF_ISOTROPIC_MODE : FF_TILTED_MODE;
        e->planes |= ff_model_planes(e->m, e->dpass[l].mode);
    }
    if (e->m->diffuse >= 0) e->planes |= ff_diffuse_at(e->m->diffuse)->planes;
}

static ff_dirs dirs_at(const ff_dirs *w, size_t i)
{
    return (ff_dirs){w->wix + i, w->wiy + i, w->wiz + i, w->wox + i, w->woy + i, w->woz + i};
}

/* 1 above the horizon, 0 at and under it. */
static void above_horizon(const ff_dirs *w, size_t n, double *up)
{
    for (size_t i = 0; i < n; i++) up[i] = w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN ? 1 : 0;
}

/* df of the lobe's own parameters from the kernels' derivatives: sum over d of jac[k][d] dS[d], times F. */
static void shape_derivatives(const evaluation *e, uint32_t l, const double (*dS)[FF_BLOCK], const double *F, size_t n, double *df,
                              size_t ld)
{
    const ff_lobe *lobe = &e->m->lobe[l];
    /* In the isotropic mode FF_D_AX is the derivative by both alphas at once. */
    const int isotropic = e->dpass[l].mode == FF_ISOTROPIC_MODE;
    for (uint32_t k = 0; k < lobe->n_shape; k++) {
        double *out = df + (size_t)(lobe->shape0 + k) * ld;
        for (int d = 0; d < FF_D_COUNT; d++) {
            const double j = e->jac[l][k][d];
            if (j == 0 || (isotropic && d != FF_D_AX && d != FF_D_OWN)) continue;
            for (size_t i = 0; i < n; i++) out[i] += j * dS[d][i] * F[i];
        }
    }
}

static void eval_block(const evaluation *e, const ff_dirs *w, size_t n, double *f, double *df, size_t ld)
{
    const ff_model *m = e->m;
    double planes[FF_G_COUNT][FF_BLOCK], up[FF_BLOCK], S[FF_BLOCK], dS[FF_D_COUNT][FF_BLOCK], F[FF_BLOCK];
    double d_optics[FF_MAX_CHANNEL_PARAMS][FF_BLOCK];
    double *d_lobe[FF_D_COUNT], *d_term[FF_MAX_CHANNEL_PARAMS];
    ff_geometry g = {{NULL}};
    for (int p = 0; p < FF_G_COUNT; p++)
        if (e->planes & 1u << p) g.plane[p] = planes[p];
    for (int k = 0; k < FF_MAX_CHANNEL_PARAMS; k++) d_term[k] = d_optics[k];
    e->k->geometry(w, n, &g);
    above_horizon(w, n, up);
    const size_t n_params = m->n_shape + m->n_channel;
    for (size_t c = 0; c < e->n_channels; c++) memset(f + c * ld, 0, n * sizeof *f);
    if (df)
        for (size_t k = 0; k < e->n_channels * n_params; k++) memset(df + k * ld, 0, n * sizeof *df);
    for (uint32_t l = 0; l < m->n_lobes; l++) {
        const ff_lobe *lobe = &m->lobe[l];
        const int has_own = ff_ndf_at(lobe->ndf)->has_own;
        for (int d = 0; d < FF_D_COUNT; d++) d_lobe[d] = d != FF_D_OWN || has_own ? dS[d] : NULL;
        if (df) e->k->lobe(&e->dpass[l], &g, n, S, d_lobe);
        e->k->lobe(&e->pass[l], &g, n, S, NULL);
        for (size_t c = 0; c < e->n_channels; c++) {
            double *fc = f + c * ld, *dfc = df ? df + c * n_params * ld : NULL;
            e->k->fresnel[lobe->fresnel]->eval(e->channel + c * m->n_channel + lobe->channel0, &g, n, F, df ? d_term : NULL);
            for (size_t i = 0; i < n; i++) fc[i] += S[i] * F[i];
            if (!df) continue;
            shape_derivatives(e, l, (const double(*)[FF_BLOCK])dS, F, n, dfc, ld);
            for (uint32_t k = 0; k < lobe->n_channel; k++) {
                double *out = dfc + (m->n_shape + lobe->channel0 + k) * ld;
                for (size_t i = 0; i < n; i++) out[i] = S[i] * d_optics[k][i];
            }
        }
    }
    if (m->diffuse < 0) return;
    const uint32_t n_diffuse = ff_diffuse_at(m->diffuse)->term.n_params, first = m->n_channel - n_diffuse;
    for (size_t c = 0; c < e->n_channels; c++) {
        double *fc = f + c * ld;
        e->k->diffuse[m->diffuse]->eval(e->channel + c * m->n_channel + first, &g, n, F, df ? d_term : NULL);
        for (size_t i = 0; i < n; i++) fc[i] += up[i] * F[i];
        if (!df) continue;
        for (uint32_t k = 0; k < n_diffuse; k++) {
            double *out = df + (c * n_params + m->n_shape + first + k) * ld;
            for (size_t i = 0; i < n; i++) out[i] = up[i] * d_optics[k][i];
        }
    }
}

ff_status ff_model_eval(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                        const ff_dirs *w, size_t n, double *f, double *df, size_t ld)
{
    evaluation e = {.k = ff_kernels_get(isa), .m = m, .n_channels = n_channels, .channel = channel};
    const ff_status s = ff_model_check(m, n_channels, shape, channel, NULL);
    if (s) return s;
    if (!e.k) return FF_ERR_UNSUPPORTED;
    prepare(&e, shape, df != NULL);
    for (size_t i = 0; i < n; i += FF_BLOCK) {
        const ff_dirs block = dirs_at(w, i);
        eval_block(&e, &block, n - i < FF_BLOCK ? n - i : FF_BLOCK, f + i, df ? df + i : NULL, ld);
    }
    return FF_OK;
}

ff_status ff_model_terms(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel, uint32_t l,
                         size_t c, const ff_dirs *w, size_t n, const ff_terms *out)
{
    evaluation e = {.k = ff_kernels_get(isa), .m = m, .n_channels = n_channels, .channel = channel};
    const ff_status s = ff_model_check(m, n_channels, shape, channel, NULL);
    if (s) return s;
    if (!e.k) return FF_ERR_UNSUPPORTED;
    if (l >= m->n_lobes || c >= n_channels) return FF_ERR_RANGE;
    prepare(&e, shape, 1);
    const ff_lobe *lobe = &m->lobe[l];
    e.pass[l].mode = FF_TILTED_MODE; /* the terms are asked for one at a time, by people: the general form serves all */
    e.planes = ff_model_planes(m, FF_TILTED_MODE);
    for (size_t i = 0; i < n; i += FF_BLOCK) {
        const size_t count = n - i < FF_BLOCK ? n - i : FF_BLOCK;
        const ff_dirs block = dirs_at(w, i);
        double planes[FF_G_COUNT][FF_BLOCK], up[FF_BLOCK], term[5][FF_BLOCK];
        ff_geometry g = {{NULL}};
        for (int p = 0; p < FF_G_COUNT; p++)
            if (e.planes & 1u << p) g.plane[p] = planes[p];
        e.k->geometry(&block, count, &g);
        above_horizon(&block, count, up);
        e.k->lobe_terms(&e.pass[l], &g, count, term[0], term[1], term[2], term[3]);
        e.k->fresnel[lobe->fresnel]->eval(channel + c * m->n_channel + lobe->channel0, &g, count, term[4], NULL);
        for (size_t j = 0; j < count; j++) term[4][j] *= up[j];
        double *const planes_out[5] = {out->d, out->lambda_i, out->lambda_o, out->g, out->fresnel};
        for (int t = 0; t < 5; t++)
            if (planes_out[t]) memcpy(planes_out[t] + i, term[t], count * sizeof(double));
    }
    return FF_OK;
}
