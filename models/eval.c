/* Evaluation of a composed model over any number of direction pairs, block by block. */
#include "internal_model.h"
#include <math.h>
#include <string.h>

static ff_dirs dirs_at(const ff_dirs *w, size_t i)
{
    return (ff_dirs){w->wix + i, w->wiy + i, w->wiz + i, w->wox + i, w->woy + i, w->woz + i};
}

/* 1 above the horizon, 0 at and under it. */
static void above_horizon(const ff_dirs *w, size_t n, double *up)
{
    for (size_t i = 0; i < n; i++) up[i] = w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN ? 1 : 0;
}

/* Does a lobe make a table of the directions that are to come? */
static int has_tables(const ff_model *m)
{
    size_t doubles = 0;
    for (uint32_t l = 0; l < m->n_lobes; l++) doubles += ff_ndf_at(m->lobe[l].ndf)->table_size;
    return doubles > 0;
}

/* The range of tan^2 theta over all directions above the horizon, for models that ask for it. */
static void range_of_tan2(const ff_model *m, const ff_dirs *w, size_t n, double *lo, double *hi)
{
    double least = 1, greatest = FF_COS_MIN; /* cosines */
    *lo = 0;
    *hi = INFINITY;
    if (!has_tables(m)) return;
    for (size_t i = 0; i < n; i++) {
        if (!(w->wiz[i] > FF_COS_MIN && w->woz[i] > FF_COS_MIN)) continue;
        least = fmin(least, fmin(w->wiz[i], w->woz[i]));
        greatest = fmax(greatest, fmax(w->wiz[i], w->woz[i]));
    }
    *hi = 1 / (least * least) - 1;
    *lo = fmax(1 / (greatest * greatest) - 1, 0);
    *hi = fmax(*hi * (1 + 1e-9), 1e-12);
    if (*lo < 1e-12 || *lo > *hi) *lo = 0; /* no more than the rounding of the unit vectors; nothing above the horizon */
}

/* Every derivative of the model. */
static void want_all(const ff_model *m, ff_wanted *w)
{
    *w = (ff_wanted){.n_shape = m->n_shape, .n_channel = m->n_channel};
    for (uint32_t k = 0; k < m->n_shape; k++) w->shape[k] = k;
    for (uint32_t k = 0; k < m->n_channel; k++) w->channel[k] = k;
}

/* The value always comes from the cheapest mode, so that it has the same bits with and without derivatives; those need the general
 * mode also where alpha_x = alpha_y. */
typedef struct evaluation {
    ff_prepared value, derivatives;
    uint32_t planes;
} evaluation;

static ff_status prepare(evaluation *e, const ff_model *m, const ff_kernels *k, size_t n_channels, const double *shape,
                         const double *channel, const ff_dirs *w, size_t n, int derivatives)
{
    double lo, hi;
    range_of_tan2(m, w, n, &lo, &hi);
    ff_status status = ff_prepare(m, k, FF_CHEAPEST_MODE, n_channels, shape, channel, NULL, lo, hi, &e->value);
    if (status) return status;
    e->planes = ff_prepared_planes(&e->value);
    if (!derivatives) return FF_OK;
    ff_wanted wanted;
    want_all(m, &wanted);
    status = ff_prepare(m, k, FF_TILTED_MODE, n_channels, shape, channel, &wanted, lo, hi, &e->derivatives);
    if (status)
        ff_prepared_free(&e->value);
    else
        e->planes |= ff_prepared_planes(&e->derivatives);
    return status;
}

static void eval_block(const evaluation *e, const ff_dirs *w, size_t n, double *f, double *df, size_t ld)
{
    const ff_kernels *k = e->value.kernels;
    const size_t C = e->value.n_channels, n_params = e->value.m->n_shape + e->value.m->n_channel;
    double planes[FF_G_COUNT][FF_BLOCK], up[FF_BLOCK], column[FF_MAX_SHAPE + FF_MAX_CHANNEL_PARAMS][FF_BLOCK], unused[FF_BLOCK];
    ff_block b;
    ff_geometry g = {{NULL}};
    for (int p = 0; p < FF_G_COUNT; p++)
        if (e->planes & 1u << p) g.plane[p] = planes[p];
    k->geometry(w, n, &g);
    above_horizon(w, n, up);
    if (df) {
        k->block_shape(&e->derivatives, &g, n, &b);
        for (size_t c = 0; c < C; c++) {
            k->block_value(&e->derivatives, &g, n, c, &b, unused);
            k->block_columns(&e->derivatives, n, c, up, &b, column);
            for (size_t p = 0; p < n_params; p++) memcpy(df + (c * n_params + p) * ld, column[p], n * sizeof *df);
        }
    }
    k->block_shape(&e->value, &g, n, &b);
    for (size_t c = 0; c < C; c++) {
        double *fc = f + c * ld;
        k->block_value(&e->value, &g, n, c, &b, fc);
        for (size_t i = 0; i < n; i++) fc[i] *= up[i];
    }
}

ff_status ff_model_eval(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel,
                        const ff_dirs *w, size_t n, double *f, double *df, size_t ld)
{
    const ff_kernels *k = ff_kernels_get(isa);
    ff_status status = ff_model_check(m, n_channels, shape, channel, NULL);
    if (status) return status;
    if (!k) return FF_ERR_UNSUPPORTED;
    if (ld < n) return FF_ERR_RANGE;
    evaluation e;
    status = prepare(&e, m, k, n_channels, shape, channel, w, n, df != NULL);
    if (status) return status;
    for (size_t i = 0; i < n; i += FF_BLOCK) {
        const ff_dirs block = dirs_at(w, i);
        eval_block(&e, &block, n - i < FF_BLOCK ? n - i : FF_BLOCK, f + i, df ? df + i : NULL, ld);
    }
    ff_prepared_free(&e.value);
    if (df) ff_prepared_free(&e.derivatives);
    return FF_OK;
}

ff_status ff_model_terms(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel, uint32_t l,
                         size_t c, const ff_dirs *w, size_t n, const ff_terms *out)
{
    const ff_kernels *k = ff_kernels_get(isa);
    ff_status status = ff_model_check(m, n_channels, shape, channel, NULL);
    if (status) return status;
    if (!k) return FF_ERR_UNSUPPORTED;
    if (l >= m->n_lobes || c >= n_channels) return FF_ERR_RANGE;
    ff_model lobes = *m; /* what the bases are coupled to is not asked for */
    lobes.n_bases = 0;
    ff_prepared p;
    double lo, hi;
    range_of_tan2(m, w, n, &lo, &hi);
    status = ff_prepare(&lobes, k, FF_TILTED_MODE, n_channels, shape, channel, NULL, lo, hi, &p);
    if (status) return status;
    p.lobe[l].mode = FF_TILTED_MODE; /* the terms are asked for one at a time, by people: the general form serves all */
    const uint32_t need = ff_prepared_planes(&p);
    const ff_lobe *with_fresnel = &m->lobe[ff_model_group(m, l)];
    for (size_t i = 0; i < n; i += FF_BLOCK) {
        const size_t count = n - i < FF_BLOCK ? n - i : FF_BLOCK;
        const ff_dirs block = dirs_at(w, i);
        double planes[FF_G_COUNT][FF_BLOCK], up[FF_BLOCK], term[5][FF_BLOCK];
        ff_geometry g = {{NULL}};
        for (int q = 0; q < FF_G_COUNT; q++)
            if (need & 1u << q) g.plane[q] = planes[q];
        k->geometry(&block, count, &g);
        above_horizon(&block, count, up);
        k->lobe_terms(&p.lobe[l], &g, count, term[0], term[1], term[2], term[3]);
        k->fresnel[with_fresnel->fresnel]->eval(channel + c * m->n_channel + with_fresnel->channel0, &g, count, term[4], NULL);
        for (size_t j = 0; j < count; j++) term[4][j] *= up[j];
        double *const planes_out[5] = {out->d, out->lambda_i, out->lambda_o, out->g, out->fresnel};
        for (int t = 0; t < 5; t++)
            if (planes_out[t]) memcpy(planes_out[t] + i, term[t], count * sizeof(double));
    }
    ff_prepared_free(&p);
    return FF_OK;
}
