/* Evaluation of a composed model over any number of direction pairs, block by block. */
#include "internal_model.h"
#include <math.h>
#include <stdlib.h>
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
typedef struct derivation {
    ff_block_work work;
    ff_prepared prepared;
} derivation;
typedef struct evaluation {
    ff_prepared value;
    uint32_t planes;
    derivation *d; /* NULL: values alone */
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
    e->d = aligned_alloc(64, (sizeof *e->d + 63) / 64 * 64);
    if (!e->d) return FF_ERR_MEMORY;
    e->d->work.block.d = &e->d->work.slopes;
    e->d->prepared.storage = NULL;
    ff_wanted wanted;
    want_all(m, &wanted);
    status = ff_prepare(m, k, FF_TILTED_MODE, n_channels, shape, channel, &wanted, lo, hi, &e->d->prepared);
    if (!status) e->planes |= ff_prepared_planes(&e->d->prepared);
    return status;
}

static void release(evaluation *e)
{
    ff_prepared_free(&e->value);
    if (e->d) ff_prepared_free(&e->d->prepared);
    free(e->d);
}

/* df of every channel and parameter; `up` is 0 where they are 0. */
static void derive_block(const evaluation *e, const ff_geometry *g, size_t n, const double *up, double *df, size_t ld)
{
    const ff_prepared *p = &e->d->prepared;
    ff_block_work *work = &e->d->work;
    const size_t n_params = p->m->n_shape + p->m->n_channel;
    double unused[FF_BLOCK];
    p->kernels->block_shape(p, g, n, &work->block);
    for (size_t c = 0; c < p->n_channels; c++) {
        p->kernels->block_value(p, g, n, c, &work->block, unused);
        p->kernels->block_columns(p, n, c, up, &work->block, work->column);
        for (size_t k = 0; k < n_params; k++) memcpy(df + (c * n_params + k) * ld, work->column[k], n * sizeof *df);
    }
}

/* Not a part of its caller, which has the planes of the geometry on its stack. */
static __attribute__((noinline)) void value_block(const evaluation *e, const ff_geometry *g, size_t n, const double *up, double *f,
                                                  size_t ld)
{
    const ff_kernels *k = e->value.kernels;
    ff_block b;
    b.d = NULL;
    k->block_shape(&e->value, g, n, &b);
    for (size_t c = 0; c < e->value.n_channels; c++) {
        double *fc = f + c * ld;
        k->block_value(&e->value, g, n, c, &b, fc);
        for (size_t i = 0; i < n; i++) fc[i] *= up[i];
    }
}

static void eval_block(const evaluation *e, const ff_dirs *w, size_t n, double *f, double *df, size_t ld)
{
    double planes[FF_G_COUNT][FF_BLOCK], up[FF_BLOCK];
    ff_geometry g = {{NULL}};
    for (int p = 0; p < FF_G_COUNT; p++)
        if (e->planes & 1u << p) g.plane[p] = planes[p];
    e->value.kernels->geometry(w, n, &g);
    above_horizon(w, n, up);
    if (df) derive_block(e, &g, n, up, df, ld);
    value_block(e, &g, n, up, f, ld);
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
    e.value.storage = NULL;
    e.d = NULL;
    status = prepare(&e, m, k, n_channels, shape, channel, w, n, df != NULL);
    for (size_t i = 0; i < n && !status; i += FF_BLOCK) {
        const ff_dirs block = dirs_at(w, i);
        eval_block(&e, &block, n - i < FF_BLOCK ? n - i : FF_BLOCK, f + i, df ? df + i : NULL, ld);
    }
    release(&e);
    return status;
}

/* The terms are asked for by people, a few at a time: what they need may be allocated. */
typedef struct terms_work {
    ff_model lobes; /* without bases: what these are coupled to is not asked for */
    ff_prepared p;
    double planes[FF_G_COUNT][FF_BLOCK], up[FF_BLOCK], term[5][FF_BLOCK];
    ff_lobe_work lobe;
} terms_work;

static void terms_block(terms_work *t, uint32_t l, const double *channel, const ff_dirs *w, size_t n)
{
    const ff_kernels *k = t->p.kernels;
    const ff_lobe *with_fresnel = &t->lobes.lobe[ff_model_group(&t->lobes, l)];
    ff_geometry g = {{NULL}};
    for (int q = 0; q < FF_G_COUNT; q++)
        if (t->p.planes & 1u << q) g.plane[q] = t->planes[q];
    k->geometry(w, n, &g);
    above_horizon(w, n, t->up);
    k->lobe_terms(&t->p.lobe[l], &g, n, &t->lobe, t->term[0], t->term[1], t->term[2], t->term[3]);
    k->fresnel[with_fresnel->fresnel]->eval(channel + with_fresnel->channel0, &g, n, t->term[4], NULL);
    for (size_t j = 0; j < n; j++) t->term[4][j] *= t->up[j];
}

ff_status ff_model_terms(const ff_model *m, ff_isa isa, size_t n_channels, const double *shape, const double *channel, uint32_t l,
                         size_t c, const ff_dirs *w, size_t n, const ff_terms *out)
{
    const ff_kernels *k = ff_kernels_get(isa);
    ff_status status = ff_model_check(m, n_channels, shape, channel, NULL);
    if (status) return status;
    if (!k) return FF_ERR_UNSUPPORTED;
    if (l >= m->n_lobes || c >= n_channels) return FF_ERR_RANGE;
    terms_work *t = malloc(sizeof *t);
    if (!t) return FF_ERR_MEMORY;
    t->lobes = *m;
    t->lobes.n_bases = 0;
    double lo, hi;
    range_of_tan2(m, w, n, &lo, &hi);
    status = ff_prepare(&t->lobes, k, FF_TILTED_MODE, n_channels, shape, channel, NULL, lo, hi, &t->p);
    if (!status) {
        t->p.lobe[l].mode = FF_TILTED_MODE; /* the general form serves all */
        t->p.planes = ff_prepared_planes(&t->p);
    }
    for (size_t i = 0; i < n && !status; i += FF_BLOCK) {
        const size_t count = n - i < FF_BLOCK ? n - i : FF_BLOCK;
        const ff_dirs block = dirs_at(w, i);
        terms_block(t, l, channel + c * m->n_channel, &block, count);
        double *const planes_out[5] = {out->d, out->lambda_i, out->lambda_o, out->g, out->fresnel};
        for (int q = 0; q < 5; q++)
            if (planes_out[q]) memcpy(planes_out[q] + i, t->term[q], count * sizeof(double));
    }
    if (!status) ff_prepared_free(&t->p);
    free(t);
    return status;
}
