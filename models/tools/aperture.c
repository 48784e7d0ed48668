/* Means over an aperture at any number of pairs. */
#include "internal_averaging.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A model made ready twice, as by ff_model_eval: its value in the cheapest mode, so that it has the same bits with derivatives and
 * without. */
typedef struct readiness {
    ff_prepared value, derivatives;
    ff_averaging by_value, by_derivatives;
} readiness;

static ff_status make_ready(const ff_rules *rules, const ff_model *m, const ff_kernels *k, size_t n_channels, const double *shape,
                            const double *channel, int derivatives, readiness *out)
{
    ff_status status = ff_prepare(m, k, FF_CHEAPEST_MODE, n_channels, shape, channel, NULL, 0, INFINITY, &out->value);
    if (status) return status;
    ff_averaging_make(rules, &out->value, NULL, &out->by_value);
    if (!derivatives) return FF_OK;
    ff_wanted all = {.n_shape = m->n_shape, .n_channel = m->n_channel};
    for (uint32_t i = 0; i < m->n_shape; i++) all.shape[i] = i;
    for (uint32_t i = 0; i < m->n_channel; i++) all.channel[i] = i;
    status = ff_prepare(m, k, FF_TILTED_MODE, n_channels, shape, channel, &all, 0, INFINITY, &out->derivatives);
    if (!status) ff_averaging_make(rules, &out->derivatives, &out->by_value.needles, &out->by_derivatives);
    return status;
}

static void average_block(const readiness *r, const ff_dirs *w, size_t n, ff_average_work *t, double *f, double *df, double *error,
                          size_t ld)
{
    unsigned char level[FF_BLOCK];
    ff_average_choose(&r->by_value, w, n, t);
    for (size_t c = 0; c < t->n_channels; c++) memcpy(f + c * ld, t->f + c * FF_BLOCK, n * sizeof *f);
    if (error) memcpy(error, t->error, n * sizeof *error);
    if (!df) return;
    memcpy(level, t->level, sizeof level);
    ff_average_at(&r->by_derivatives, w, n, level, t);
    for (size_t k = 0; k < t->n_channels * t->n_columns; k++) memcpy(df + k * ld, t->df + k * FF_BLOCK, n * sizeof *df);
}

static ff_status average(const ff_aperture *a, const ff_model *m, const ff_kernels *k, size_t n_channels, const double *shape,
                         const double *channel, const ff_dirs *w, size_t n, double *f, double *df, double *error, size_t ld)
{
    readiness *r = calloc(1, sizeof *r);
    ff_rules *rules = ff_rules_new(a, FF_APERTURE_TOLERANCE);
    ff_average_work **works = ff_average_works_new(1, n_channels, df ? m->n_shape + m->n_channel : 0);
    ff_status status = r && rules && works ? make_ready(rules, m, k, n_channels, shape, channel, df != NULL, r) : FF_ERR_MEMORY;
    for (size_t i = 0; i < n && !status; i += FF_BLOCK) {
        const ff_dirs block = {w->wix + i, w->wiy + i, w->wiz + i, w->wox + i, w->woy + i, w->woz + i};
        average_block(r, &block, n - i < FF_BLOCK ? n - i : FF_BLOCK, works[0], f + i, df ? df + i : NULL, error ? error + i : NULL,
                      ld);
    }
    if (r) ff_prepared_free(&r->value);
    if (r) ff_prepared_free(&r->derivatives);
    ff_average_works_free(works);
    free(rules);
    free(r);
    return status;
}

ff_status ff_aperture_eval(const ff_aperture *a, const ff_model *m, ff_isa isa, size_t n_channels, const double *shape,
                           const double *channel, const ff_dirs *w, size_t n, double *f, double *df, double *error, size_t ld)
{
    const ff_kernels *k = ff_kernels_get(isa);
    const ff_status status = ff_model_check(m, n_channels, shape, channel, NULL);
    if (status) return status;
    if (!k) return FF_ERR_UNSUPPORTED;
    if (!ff_aperture_valid(a) || ld < n) return FF_ERR_RANGE;
    if (ff_aperture_extended(a)) return average(a, m, k, n_channels, shape, channel, w, n, f, df, error, ld);
    for (size_t i = 0; error && i < n; i++) error[i] = 0;
    return ff_model_eval(m, isa, n_channels, shape, channel, w, n, f, df, ld);
}
